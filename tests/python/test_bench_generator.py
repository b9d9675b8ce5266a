"""The generator of synthetic bench experiments: public sets, energy balance, seeds, effects, files."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from bench import detect, make, numbered, profiles, write
from bench.effects import CATALOGUE, T_REF
from bench.generator import Instant, Motor, simulate
from bench.law import Effect
from bench.rig import LAYOUTS, PRIOR, PUBLIC as PUBLIC_RIG, Rig, draw_specimen, draw_units
from bench.sensors import DEAD, Fault, draw_faults, draw_noise, measure, spread
from scipy.integrate import solve_ivp

try:
    import tomllib
except ModuleNotFoundError:
    import tomli as tomllib  # below Python 3.11 pytest brings it

# The sets that it wrote are stored and used every day.
pytestmark = pytest.mark.nightly

INPUTS, OUTPUTS = PUBLIC_RIG.layout.inputs, PUBLIC_RIG.layout.outputs
PUBLIC = Path(__file__).parents[1] / "reference" / "bench-synthetic"
PUBLIC_SETS = ("iron-loss", "housing-radiation", "drag-power-075", "thermocouple-drift")
PUBLIC_FILES = {"validate": "run-3.csv", "test": "run-4.csv"}
UNLISTED_NAMES = {"tau = k w^0.75": "drag_power_075"}
THERMOCOUPLES = OUTPUTS[2:]

# A hot, steady point: A, rad/s, 1, degC, or for the drive W, 1, degC; and where each typical effect
# must show at its end: the signs of the change in voltage, torque, winding and housing temperature; 0 is exactly none, ? is one of
# either sign.
STEADY = (3.0, 800.0, 0.5, 28.0)
HEATED = (6.0, 0.5, 28.0)
DRAG, DROP, HEAT, COOL = "?-++", "+?++", "??++", "??--"
SIGNS = {
    **dict.fromkeys(("iron_loss", "viscous_friction", "windage", "load_dependent_friction"), DRAG),
    **dict.fromkeys(("drag_power_075", "drag_power_13"), DRAG),
    **dict.fromkeys(("drag_rising_with_winding", "grease_thinning", "drag_with_current", "latched_drag"), DRAG),
    **dict.fromkeys(("contact_drop", "drop_with_root_of_current", "resistance_with_current", "resistance_ageing"), DROP),
    **dict.fromkeys(("fan_back_pressure", "ambient_drift", "fan_heat", "periodic_heat", "fan_fading_with_room"), HEAT),
    **dict.fromkeys(("housing_radiation", "forced_convection", "thermostat", "conductance_with_housing"), COOL),
    **dict.fromkeys(("conductance_with_room", "capacity_with_temperature"), COOL),
    "interface_temperature": "??+?",
    "drive_loss": "--",
    "stator_node": "???-",
    **dict.fromkeys(("demagnetisation", "saturation"), "--00"),
    **dict.fromkeys(("winding_sensor_offset", "winding_sensor_pickup"), "00+0"),
    **dict.fromkeys(("winding_sensor_stem_loss", "winding_sensor_lag"), "00-0"),
    "housing_sensor_offset": "000+",
    **dict.fromkeys(("housing_sensor_stem_loss", "housing_sensor_lag"), "000-"),
}


def run_of(path):
    """Columns of a set's file; blanks are NaN."""
    rows = list(csv.DictReader(path.open(encoding="utf-8")))
    return {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0]}


def public_effects(truth):
    """The catalogue's effects for a public set's truth."""
    found = [Effect(CATALOGUE[e["id"]], e["parameters"]) for e in truth["effects"]]
    if truth["unexplained"]:
        found.append(Effect(CATALOGUE[UNLISTED_NAMES[truth["unexplained"]["law"]]], {"k": truth["unexplained"]["k"]}))
    return found


def expected_noise(noise, specimen):
    """Noise per output when measured inputs drive the model: its own and what current and speed bring, rms."""
    i, w, k_t = noise["current_A"], noise["speed_rad_per_s"], specimen["motor.k_t"]
    brought = {"voltage_V": np.hypot(k_t * w, specimen["motor.R_ref"] * i), "shaft_torque_Nm": k_t * i}
    return {channel: np.hypot(noise[channel], brought.get(channel, 0.0)) for channel in OUTPUTS}


@pytest.mark.parametrize("role", PUBLIC_FILES)
@pytest.mark.parametrize("name", PUBLIC_SETS)
def test_public_sets_are_met_to_their_noise(name, role):
    truth = json.loads((PUBLIC / name / "truth.json").read_text())
    stated = tomllib.loads((PUBLIC / name / "experiment.toml").read_text()).get("noise")
    run = run_of(PUBLIC / name / PUBLIC_FILES[role])
    outputs = simulate(truth["parameters"], public_effects(truth), run["time_s"], run).outputs
    rms = {channel: detect.rms(outputs[channel] - run[channel]) for channel in OUTPUTS}
    for channel in OUTPUTS:
        assert rms[channel] == pytest.approx(truth["rmse"][role][channel]["floor"], rel=0.005), channel
        if stated and not (name == "thermocouple-drift" and channel in THERMOCOUPLES):
            assert rms[channel] == pytest.approx(expected_noise(stated, truth["parameters"])[channel], rel=0.05), channel


@pytest.fixture(scope="module")
def specimen():
    return draw_specimen(np.random.default_rng(5))


@pytest.fixture(scope="module")
def steady(specimen):
    """Per drive: inputs of the steady point and what a specimen without effects gives; demagnetisation has happened by its start."""
    times = np.arange(4000.0, 5500.0, 5.0)
    points = {}
    for drive, values in (("current", STEADY), ("power", HEATED)):
        rig = Rig(LAYOUTS[drive])
        inputs = {name: np.full(len(times), value) for name, value in zip(rig.layout.inputs, values)}
        points[drive] = rig, times, inputs, simulate(specimen, [], times, inputs, rig)
    return points


def stored(specimen, effect, record):
    """Heat in the capacities since the start, J."""
    winding, housing = (record.winding[-1] - record.winding[0]), (record.housing[-1] - record.housing[0])
    heat = specimen["thermal.C_w"] * winding + specimen["thermal.C_h"] * housing
    if effect.law.id == "stator_node":
        heat += effect.parameters["C_s"] * (record.stator[-1] - record.stator[0])
    if effect.law.id == "capacity_with_temperature":
        squares = (record.housing[-1] - T_REF) ** 2 - (record.housing[0] - T_REF) ** 2
        heat += specimen["thermal.C_h"] * effect.parameters["beta"] * squares / 2.0
    return heat


@pytest.mark.parametrize("name", CATALOGUE)
def test_effect_acts_at_its_port_and_energy_balance_closes(specimen, steady, name):
    effect = CATALOGUE[name].typical()
    rig, times, inputs, without = steady[effect.law.drive or "current"]
    record = simulate(specimen, [effect], times, inputs, rig)
    for channel, sign in zip(rig.layout.outputs, SIGNS[name], strict=True):
        change = record.outputs[channel][-1] - without.outputs[channel][-1]
        if sign != "?":
            assert np.sign(change) == {"+": 1, "-": -1, "0": 0}[sign], (channel, change)
    assert record.supplied - record.released == pytest.approx(stored(specimen, effect, record), abs=1e-8 * record.supplied)


def test_integration_agrees_with_lsoda(specimen):
    """Row by row at tight tolerance, on a run with every kind of input, with a stator node."""
    rng = np.random.default_rng(3)
    times = np.arange(0.0, 600.0, 5.0)
    inputs = {name: np.abs(rng.normal(value, 0.3 * value, len(times))) for name, value in zip(INPUTS, STEADY)}
    effects = [CATALOGUE["stator_node"].typical(), CATALOGUE["iron_loss"].typical()]
    record, motor = simulate(specimen, effects, times, inputs), Motor(specimen, effects)
    rows = np.column_stack([times, *(inputs[name] for name in INPUTS)])
    y = np.full(3, rows[0, -1])
    for a, b in zip(rows, rows[1:]):

        def slope(t, y, a=a, b=b):
            x = Instant(*(a + (t - a[0]) / (b[0] - a[0]) * (b - a)), *y[:2])
            return motor.rates(x, y[2])[2:5]

        y = solve_ivp(slope, (a[0], b[0]), y, method="LSODA", rtol=1e-9, atol=1e-9).y[:, -1]
    assert [record.winding[-1], record.housing[-1], record.stator[-1]] == pytest.approx(list(y), abs=1e-3)


@pytest.fixture
def short_runs(monkeypatch):
    for name, seconds in (("DURATION", (400.0, 450.0)), ("REST_BEFORE", (20.0, 40.0)), ("REST_AFTER", (20.0, 40.0))):
        monkeypatch.setattr(profiles, name, seconds)
    monkeypatch.setattr(profiles, "SAMPLING", (0.5, 1.0, 2.0))


def files_of(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*.*")) if path.is_file()}


def test_same_seed_same_files(short_runs, tmp_path):
    for folder, seed in (("a", 7), ("b", 7), ("c", 8)):
        make.main(["--seed", str(seed), "--out", str(tmp_path / folder / "x"), "--count", "1"])
    a, b, c = (files_of(tmp_path / folder / "x") for folder in "abc")
    assert a == b
    assert not set(a.values()) & {text for path, text in c.items() if path.name != numbered.STAMP}


def test_written_set_has_the_contract_s_names(short_runs, tmp_path):
    drawn = make.draw_set(4, 0, "forced_convection", PUBLIC_RIG, 4)
    folder = tmp_path / drawn.name
    write.write_set(drawn, folder)
    truth = json.loads((folder / "truth.json").read_text())
    model = json.loads((PUBLIC / "iron-loss" / "truth.json").read_text())
    text = tomllib.loads((folder / "experiment.toml").read_text())
    public = tomllib.loads((PUBLIC / "iron-loss" / "experiment.toml").read_text())
    assert {key: text[key] for key in ("set", "prior")} == {key: public[key] for key in ("set", "prior")}
    assert text["experiment"] == public["experiment"] | {"name": folder.name}
    assert text["run"] == public["run"]
    assert "noise" not in text or text["noise"].keys() == public["noise"].keys()
    assert truth.keys() >= model.keys() | {"signal_to_noise", "signal_to_noise_refit", "detectable", "sensors", "noise"}
    assert truth["parameters"].keys() == model["parameters"].keys() == PRIOR.keys()
    (effect,) = truth["effects"]
    assert effect["id"] == "forced_convection" and effect["parameters"]["node"] == "housing" and len(effect["runs"]) == 2
    assert truth["rmse"].keys() == model["rmse"].keys() and truth["signal_to_noise_refit"].keys() == set(OUTPUTS)
    header = (PUBLIC / "iron-loss" / "run-3.csv").read_text().splitlines()[0]
    last = -np.inf
    for run in text["run"]:
        assert (folder / run["file"]).read_text().splitlines()[0] == header
        times = run_of(folder / run["file"])["time_s"]
        assert times[0] > last and np.all(np.diff(times) > 0.0)
        last = times[-1]


def test_more_processes_make_the_same_files_and_keep_what_is_there(short_runs, tmp_path):
    make.main(["--seed", "7", "--out", str(tmp_path / "one"), "--count", "2"])
    make.main(["--seed", "7", "--out", str(tmp_path / "two"), "--count", "2", "--jobs", "2"])
    made = files_of(tmp_path / "two")
    assert files_of(tmp_path / "one") == made
    make.main(["--seed", "7", "--out", str(tmp_path / "second"), "--first", "1"])
    assert files_of(tmp_path / "second").items() < made.items() and (tmp_path / "second" / "bench-7-1").is_dir()
    mark = tmp_path / "two" / "bench-7-0" / "truth.json"
    mark.write_text("kept")
    (tmp_path / "two" / "bench-7-1" / "truth.json").unlink()
    make.main(["--seed", "7", "--out", str(tmp_path / "two"), "--count", "2", "--keep"])
    assert files_of(tmp_path / "two") == made | {mark.relative_to(tmp_path / "two"): b"kept"}
    (tmp_path / "two" / numbered.STAMP).write_text("another generator")
    make.main(["--seed", "7", "--out", str(tmp_path / "two"), "--count", "1", "--keep"])
    assert files_of(tmp_path / "two").keys() == made.keys() - {Path("bench-7-1/truth.json")}
    assert files_of(tmp_path / "two").items() < made.items()


def test_floor_of_a_drawn_set_is_its_noise(short_runs):
    drawn = make.draw_set(11, 0, "viscous_friction", PUBLIC_RIG)
    drawn.faults.clear()
    for run in drawn.runs:
        run.readings = measure(np.random.default_rng(1), run.times, run.truth, drawn.noise)
    noise = expected_noise(drawn.noise, drawn.specimen)
    for channels in write.errors(drawn).values():
        assert {c: channels[c]["floor"] for c in OUTPUTS} == pytest.approx(noise, rel=0.15)


def test_refit_hides_what_parameters_can_mimic(short_runs):
    """A constant conductance in all fit runs can be expressed by a parameter, a drag torque ~ w cannot. A dead sensor shows nothing."""
    drawn = make.draw_set(11, 0, "forced_convection", PUBLIC_RIG)
    drawn.faults.clear()
    fitted = [k for k, run in enumerate(drawn.runs) if "fit" in run.roles]
    for k, run in enumerate(drawn.runs):
        effects = [CATALOGUE["forced_convection"].typical()] if k in fitted else []
        run.truth = run.truth | simulate(drawn.specimen, effects, run.times, run.truth).outputs
    plain, refit = detect.signal_to_noise(drawn), detect.signal_to_noise_refit(drawn)
    hot = THERMOCOUPLES[1]
    assert plain[hot] > 0.5 and refit[hot] < 0.2 * plain[hot]
    drawn.faults.append(Fault("dead", hot, DEAD))
    assert detect.signal_to_noise(drawn)[hot] == detect.signal_to_noise_refit(drawn)[hot] == 0.0
    viscous = make.draw_set(11, 0, "viscous_friction", PUBLIC_RIG)
    assert max(detect.signal_to_noise_refit(viscous).values()) > detect.DETECTABLE


def test_shares_of_null_and_unlisted_sets():
    kinds = [make.drawn_kind(3, number) for number in range(40)]
    assert [kinds.count(kind) for kind in ("null", "unlisted", "listed")] == [8, 20, 12]
    assert all(make.draw_laws(np.random.default_rng(k), "null", None) == [] for k in range(3))


def test_catalogue_is_large_enough():
    assert sum(law.listed for law in CATALOGUE.values()) >= 14
    assert sum(not law.listed for law in CATALOGUE.values()) >= 10
    drivers = {"speed", "current", "time", "history", "fan_command", "ambient_temperature"}
    assert {law.driver for law in CATALOGUE.values()} >= drivers


def in_layout(drive, count=2, chosen=make.NONE):
    """A short set without faults; without effects unless one is given."""
    drawn = make.draw_set(12, 0, chosen, Rig(LAYOUTS[drive]), count)
    drawn.faults.clear()
    for k, run in enumerate(drawn.runs):
        run.readings = measure(np.random.default_rng(k), run.times, run.truth, drawn.noise, (), drawn.rig)
    return drawn


@pytest.mark.parametrize("name", ["contact_drop", "resistance_with_current", "viscous_friction"])
def test_imposed_voltage_drives_the_current_that_asks_for_it(specimen, name):
    times = np.arange(0.0, 300.0, 0.5)
    current = np.interp(times, [10.0, 60.0, 150.0, 240.0], [0.0, 4.0, 1.0, 0.0])
    values = (current, 900.0 * (times > 20.0), np.full(len(times), 0.2), np.full(len(times), 25.0))
    inputs, effects = dict(zip(INPUTS, values)), [CATALOGUE[name].typical()]
    forth = simulate(specimen, effects, times, inputs).outputs
    back = simulate(specimen, effects, times, inputs | {"voltage_V": forth["voltage_V"]}, Rig(LAYOUTS["voltage"])).outputs
    assert back["current_A"] == pytest.approx(current, abs=0.01) and np.max(current) == 4.0
    assert back["winding_temperature_degC"] == pytest.approx(forth["winding_temperature_degC"], abs=0.05)


def test_power_at_standstill_heats_as_copper_does(specimen):
    """Without a temperature coefficient the copper heat of a current is a power; a drive loss reduces it."""
    cold = specimen | {"motor.alpha": 0.0}
    times = np.arange(0.0, 600.0, 1.0)
    inputs = dict(zip(INPUTS, (np.interp(times, [10.0, 20.0], [0.0, 4.0]), 0.0 * times, 0.0 * times, 25.0 + 0.0 * times)))
    rig, thermocouples = Rig(LAYOUTS["power"]), OUTPUTS[2:]
    heat = {"electrical_power_W": cold["motor.R_ref"] * inputs["current_A"] ** 2 / 0.8}
    lossy = simulate(cold, [Effect(CATALOGUE["drive_loss"], {"share": 0.2})], times, inputs | heat, rig).outputs
    copper = simulate(cold, [], times, inputs).outputs
    assert tuple(lossy) == thermocouples
    for channel in thermocouples:
        assert lossy[channel] == pytest.approx(copper[channel], abs=0.01) and np.max(copper[channel]) > 30.0


@pytest.mark.parametrize("drive", LAYOUTS)
def test_every_layout_is_written_as_it_is_driven(short_runs, tmp_path, drive):
    drawn = in_layout(drive)
    write.write_set(drawn, tmp_path)
    text = tomllib.loads((tmp_path / "experiment.toml").read_text())
    head, truth = text["experiment"], json.loads((tmp_path / "truth.json").read_text())
    header = (tmp_path / "run-1.csv").read_text().splitlines()[0]
    assert header == ",".join(["time_s", *head["inputs"], *head["outputs"]])
    assert [c for c in ("current_A", "voltage_V", "electrical_power_W") if c in head["inputs"]] == [head["inputs"][0]]
    assert head["inputs"][0].startswith({"current": "current", "voltage": "voltage", "power": "electrical"}[drive])
    assert text["prior"].keys() == truth["parameters"].keys()
    for channels in truth["rmse"].values():
        floors = {c: errors["floor"] for c, errors in channels.items()}
        assert floors == pytest.approx(spread(drawn.noise, [], drawn.specimen, drawn.rig), rel=0.15)


def test_two_runs_are_cut_into_three_roles(short_runs, tmp_path):
    drawn = in_layout("current")
    write.write_set(drawn, tmp_path)
    first, second, last = tomllib.loads((tmp_path / "experiment.toml").read_text())["run"]
    assert [run["role"] for run in (first, second, last)] == ["fit", "validate", "test"]
    assert first["file"] == second["file"] == "run-1.csv" and "window_s" not in last
    assert first["window_s"][1] < second["window_s"][0] and first["window_s"][0] == 0.0
    run = drawn.runs[0]
    assert np.all(run.rows("fit") ^ run.rows("validate")) and 0.6 < np.mean(run.rows("fit")) < 0.7
    assert not np.any(run.rows("test")) and np.all(drawn.runs[1].rows("test"))


def test_other_motors_run_at_the_temperatures_of_the_public_one(specimen):
    """By similarity; friction does not scale exactly and is switched off."""
    rng = np.random.default_rng(9)
    times = np.arange(0.0, 9000.0, 5.0)
    for _ in range(3):
        rig = Rig(units=draw_units(rng))
        rises = []
        for bench in (PUBLIC_RIG, rig):
            values = (bench.scaled(4.0, {"current": 1}), 0.0, 0.3, 25.0)
            inputs = {name: np.full(len(times), value) for name, value in zip(INPUTS, values)}
            rises.append(simulate({}, [], times, inputs, bench).outputs[THERMOCOUPLES[0]][-1] - 25.0)
        assert rises[1] == pytest.approx(rises[0], rel=0.01) and rises[0] > 10.0
        assert rig.nominal["thermal.C_h"] != PUBLIC_RIG.nominal["thermal.C_h"]


def test_another_motor_is_driven_as_hard():
    units = draw_units(np.random.default_rng(9))
    for drive in LAYOUTS:
        rigs = Rig(LAYOUTS[drive]), Rig(LAYOUTS[drive], units)
        here, there = (profiles.draw_run(np.random.default_rng(1), 0.0, profiles.DEMANDS["fit"], rig)[1] for rig in rigs)
        column = next(iter(here))
        assert np.max(there[column]) == pytest.approx(units["power" if drive == "power" else "current"] * np.max(here[column]))
        assert np.max(here[column]) > 1.0 and there["fan_command_1"] == pytest.approx(here["fan_command_1"])


def test_noise_of_each_input_spreads_to_the_outputs_it_drives(specimen):
    """For a motor whose parameters do not depend on temperature."""
    same, times = specimen | {"motor.alpha": 0.0, "motor.alpha_mag": 0.0}, np.arange(0.0, 2000.0, 2.0)
    for drive, column, size in (("current", "current_A", 0.05), ("voltage", "voltage_V", 0.05), ("voltage", "speed_rad_per_s", 2.0)):
        rig = Rig(LAYOUTS[drive])
        first = {"current": STEADY[0], "voltage": 24.0}[drive]
        truth = {name: np.full(len(times), value) for name, value in zip(rig.layout.inputs, (first, *STEADY[1:]))}
        noise = dict.fromkeys((*rig.layout.inputs, *rig.layout.outputs), 1e-6) | {column: size}
        right = simulate(same, [], times, truth, rig).outputs
        read = simulate(same, [], times, measure(np.random.default_rng(4), times, truth | right, noise, (), rig), rig).outputs
        expected = spread(noise, [], same, rig)
        for channel in rig.layout.outputs[:2]:
            assert detect.rms(read[channel] - right[channel]) == pytest.approx(expected[channel], rel=0.1), (drive, channel)


def test_sizes_go_with_the_motor():
    """A drag torque or voltage drop is the same fraction of the motor's torque or voltage on each rig."""
    rig = Rig(units=draw_units(np.random.default_rng(1)))
    for name, k in (("iron_loss", 0.5), ("windage", 2.0)):
        here, there = (CATALOGUE[name].draw(np.random.default_rng(4), r).parameters["k"] for r in (PUBLIC_RIG, rig))
        speed, torque = (rig.scaled(1.0, {unit: 1}) for unit in ("speed", "torque"))
        assert there * speed**k / torque == pytest.approx(here) and there != pytest.approx(here)


def test_laws_find_a_rig_that_can_show_them():
    rng = np.random.default_rng(6)
    for law in CATALOGUE.values():
        assert law.drive in (None, make.draw_rig(rng, [law]).layout.drive)
    assert not LAYOUTS["power"].allows(CATALOGUE["iron_loss"]) and LAYOUTS["power"].allows(CATALOGUE["drive_loss"])
    for _ in range(20):
        roles = make.draw_roles(rng, [CATALOGUE["drive_loss"]])
        runs = make.draw_effect(rng, CATALOGUE["drive_loss"], Rig(LAYOUTS["power"]), roles).runs
        assert "fit" in roles[runs[0]] and "fit" not in roles[runs[1]] and sum("fit" in names for names in roles) >= 2


def test_second_effects_are_few_and_elsewhere():
    drawn = [make.draw_laws(np.random.default_rng(k), "unlisted", None) for k in range(200)]
    pairs = [laws for laws in drawn if len(laws) == 2]
    assert 8 <= len(pairs) <= 35
    assert all(second.listed and not first.listed and first.port != second.port for first, second in pairs)


def test_each_of_two_effects_is_seen_beside_the_other(short_runs):
    """A conductance in all runs is hidden by a parameter, also together with a visible effect."""
    drawn = in_layout("current", 4, "viscous_friction")
    drag = drawn.effects[0]
    hidden = CATALOGUE["forced_convection"].typical()
    drawn.effects.append(hidden)
    for run in drawn.runs:
        run.truth = run.truth | simulate(drawn.specimen, drawn.effects, run.times, run.truth).outputs
    together, (one, other) = detect.findings(drawn)
    assert together.detectable and one.detectable and not other.detectable
    drawn.effects = [hidden]
    for run in drawn.runs:
        run.truth = run.truth | simulate(drawn.specimen, [hidden], run.times, run.truth).outputs
    alone, _ = detect.findings(drawn)
    assert not alone.detectable and drag.acts_in(0)


def test_few_readings_show_less(short_runs):
    drawn = in_layout("current", 4, "viscous_friction")
    whole, _ = detect.findings(drawn)
    for run in drawn.runs:
        for channel in drawn.rig.layout.outputs:
            run.readings[channel][np.arange(len(run.times)) % 4 > 0] = np.nan
    fewer, _ = detect.findings(drawn)
    assert fewer.chi_square == pytest.approx(whole.chi_square / 4.0, rel=0.15)


def test_profiles_stay_within_their_demand():
    times = np.arange(100.0, 4100.0, 2.0)
    for shape in set(profiles.SHAPES):
        values = shape(np.random.default_rng(8), times, 5.0)
        assert len(values) == len(times) and np.min(values) >= 0.0 and np.max(values) <= 5.0 and np.ptp(values) > 1.0
    stairs = profiles.staircase(np.random.default_rng(8), times, 5.0)
    held = np.abs(np.diff(stairs)) < 1e-9
    assert np.mean(held) > 0.8 and len(np.unique(stairs[1:][held])) >= 4


def test_clocks_differ_and_run_forward():
    steps = [np.diff(profiles.clock(np.random.default_rng(k), 50.0)) for k in range(60)]
    assert all(np.all(step > 0.0) for step in steps)
    middle = [np.median(step) for step in steps]
    assert min(middle) < 0.7 and max(middle) > 8.0
    uneven = [np.ptp(np.percentile(step, [10, 90])) / np.median(step) for step in steps]
    assert 2 <= sum(u > 0.5 for u in uneven) <= 15 and sum(u == 0.0 for u in uneven) >= 20
    assert sum(step.max() > 5.0 + np.median(step) for step in steps) >= 8


def test_coarse_thermometers_and_slow_sensors(specimen):
    times = np.arange(0.0, 1000.0, 2.0)
    truth = {name: 20.0 + times / 50.0 for name in (*INPUTS, *OUTPUTS)}
    read = measure(np.random.default_rng(2), times, truth, {}, [Fault("slow", OUTPUTS[2], 5.0)])
    assert np.array_equal(np.flatnonzero(~np.isnan(read[OUTPUTS[2]])), np.arange(0, len(times), 5))
    drawn = [draw_faults(np.random.default_rng(k), draw_noise(np.random.default_rng(k))) for k in range(300)]
    steps = [f.size for (f, *_) in drawn if f.kind == "quantised" and f.channel in THERMOCOUPLES]
    assert steps and 0.1 <= min(steps) < 0.2 and 0.4 < max(steps) <= 0.5
    coarse = [Fault("quantised", THERMOCOUPLES[0], 0.5)]
    read = measure(np.random.default_rng(3), times, truth, {THERMOCOUPLES[0]: 0.1}, coarse)
    miss = detect.rms(read[THERMOCOUPLES[0]] - truth[THERMOCOUPLES[0]])
    assert miss == pytest.approx(spread(dict.fromkeys((*INPUTS, *OUTPUTS), 0.1), coarse, specimen, PUBLIC_RIG)[THERMOCOUPLES[0]], rel=0.05)


def test_faults_do_what_they_say():
    times = np.arange(0.0, 4000.0, 2.0)
    truth = {name: 20.0 + times / 100.0 for name in (*INPUTS, *OUTPUTS)}
    v, torque, winding, housing = OUTPUTS
    faults = [Fault("quantised", v, 0.5), Fault("clipped", torque, 50.0)]
    faults += [Fault("dead", winding, DEAD), Fault("blanks", housing, 0.02)]
    read = measure(np.random.default_rng(2), times, truth, {}, faults)
    assert np.all(read[v] % 0.5 == 0.0) and np.max(np.abs(read[v] - truth[v])) <= 0.25
    assert np.max(read[torque]) == 50.0
    assert np.all(read[winding] == DEAD)
    slow = measure(np.random.default_rng(2), times, truth, {}, [Fault("drift", housing, 0.05, 8000.0)])
    assert slow[housing] - truth[housing] == pytest.approx(0.05 * np.sin(np.pi * times / times[-1]), abs=1e-4)
    assert 0.01 < np.mean(np.isnan(read[housing])) < 0.1
