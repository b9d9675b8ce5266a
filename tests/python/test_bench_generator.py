"""The generator of synthetic bench experiments: against the public sets, its books, its seeds, its effects, its files."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from bench import detect, make, profiles, write
from bench.effects import CATALOGUE, T_REF
from bench.generator import INPUTS, OUTPUTS, PRIOR, Instant, Motor, draw_specimen, simulate
from bench.law import Effect
from bench.sensors import DEAD, Fault, measure
from scipy.integrate import solve_ivp

try:
    import tomllib
except ModuleNotFoundError:
    import tomli as tomllib  # below Python 3.11 pytest brings it

PUBLIC = Path(__file__).parents[1] / "reference" / "bench-synthetic"
PUBLIC_SETS = ("iron-loss", "housing-radiation", "drag-power-075", "thermocouple-drift")
PUBLIC_FILES = {"validate": "run-3.csv", "test": "run-4.csv"}
UNLISTED_NAMES = {"tau = k w^0.75": "drag_power_075"}
THERMOCOUPLES = OUTPUTS[2:]

# A hot, steady point: A, rad/s, 1, degC; and where each typical effect must show at its end: the signs of the change in
# voltage, torque, winding and housing temperature; 0 is exactly none, ? is one of either sign.
STEADY = (3.0, 800.0, 0.5, 28.0)
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
    "stator_node": "???-",
    **dict.fromkeys(("demagnetisation", "saturation"), "--00"),
    **dict.fromkeys(("winding_sensor_offset", "winding_sensor_pickup"), "00+0"),
    "winding_sensor_stem_loss": "00-0",
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
    """Inputs of the steady point and what a specimen without effects gives; demagnetisation has happened by its start."""
    times = np.arange(4000.0, 5500.0, 5.0)
    inputs = {name: np.full(len(times), value) for name, value in zip(INPUTS, STEADY)}
    return times, inputs, simulate(specimen, [], times, inputs)


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
def test_effect_shows_where_it_must_and_books_close(specimen, steady, name):
    times, inputs, without = steady
    effect = CATALOGUE[name].typical()
    record = simulate(specimen, [effect], times, inputs)
    for channel, sign in zip(OUTPUTS, SIGNS[name]):
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


def files_of(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*.*")) if path.is_file()}


def test_same_seed_same_files(short_runs, tmp_path):
    for folder, seed in (("a", 7), ("b", 7), ("c", 8)):
        make.main(["--seed", str(seed), "--out", str(tmp_path / folder / "x"), "--count", "1"])
    a, b, c = (list(files_of(tmp_path / folder).values()) for folder in "abc")
    assert a == b
    assert all(first != other for first, other in zip(a, c))


def test_written_set_has_the_contract_s_names(short_runs, tmp_path):
    make.main(["--seed", "4", "--out", str(tmp_path), "--effect", "forced_convection"])
    (folder,) = tmp_path.iterdir()
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


def test_floor_of_a_drawn_set_is_its_noise(short_runs):
    drawn = make.draw_set(11, 0, "viscous_friction")
    drawn.faults.clear()
    for run in drawn.runs:
        run.readings = measure(np.random.default_rng(1), run.times, run.truth, drawn.noise)
    noise = expected_noise(drawn.noise, drawn.specimen)
    for channels in write.errors(drawn).values():
        assert {c: channels[c]["floor"] for c in OUTPUTS} == pytest.approx(noise, rel=0.15)


def test_refit_hides_what_parameters_can_mimic(short_runs):
    """A constant conductance in all fitted runs is a parameter, a drag ~ w is not. A dead sensor sees nothing."""
    drawn = make.draw_set(11, 0, "forced_convection")
    drawn.faults.clear()
    fitted = [k for k, run in enumerate(drawn.runs) if run.role == "fit"]
    for k, run in enumerate(drawn.runs):
        effects = [CATALOGUE["forced_convection"].typical()] if k in fitted else []
        run.truth = run.truth | simulate(drawn.specimen, effects, run.times, run.truth).outputs
    plain, refit = detect.signal_to_noise(drawn), detect.signal_to_noise_refit(drawn)
    hot = THERMOCOUPLES[1]
    assert plain[hot] > 0.5 and refit[hot] < 0.2 * plain[hot]
    drawn.faults.append(Fault("dead", hot, DEAD))
    assert detect.signal_to_noise(drawn)[hot] == detect.signal_to_noise_refit(drawn)[hot] == 0.0
    viscous = make.draw_set(11, 0, "viscous_friction")
    assert max(detect.signal_to_noise_refit(viscous).values()) > detect.DETECTABLE


def test_shares_of_null_and_unlisted_sets():
    kinds = [make.drawn_kind(3, number) for number in range(40)]
    assert [kinds.count(kind) for kind in ("null", "unlisted", "listed")] == [8, 20, 12]
    assert all(make.draw_effects(np.random.default_rng(k), "null", None) == [] for k in range(3))


def test_catalogue_is_large_enough():
    assert sum(law.listed for law in CATALOGUE.values()) >= 14
    assert sum(not law.listed for law in CATALOGUE.values()) >= 10
    drivers = {"speed", "current", "time", "history", "fan_command", "ambient_temperature"}
    assert {law.driver for law in CATALOGUE.values()} >= drivers


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
