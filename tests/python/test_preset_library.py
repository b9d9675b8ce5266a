"""Every preset of examples/presets against what its maker prints (preset_datasheets.toml), through `motor-fmu`.

    no-load point    free shaft at nominal voltage, cold                                      simulate
    stall torque     shaft held at nominal voltage, cold, after ten electrical time constants simulate
    nominal point    continuous current and torque at the printed speed                       steady
    time constants   step of electrical power from ambient temperature                        simulate
    print            the printed values compared with each other, which finds a wrong copy

A preset file without a table in preset_datasheets.toml fails; so does a recorded deviation that no longer exists.
"""

import csv
import json
import re
import subprocess
import textwrap
import tomllib
from math import log, pi
from pathlib import Path

import pytest
from clients.paths import EXAMPLES
from fmpy import simulate_fmu

FILES = {file.stem: file for file in sorted((EXAMPLES / "presets").glob("*.toml"))}
PRINTED = tomllib.loads((Path(__file__).parent / "preset_datasheets.toml").read_text())
PRESETS = {name: tomllib.loads(file.read_text()) for name, file in FILES.items()}
RPM = pi / 30

# Tolerances, relative. Makers print three digits and k_t to 0.5 %; the no-load speed also contains it in R I_0. The nominal
# point depends on how the maker treats losses at speed: 10 % is the limit that the project sets itself.
TOLERANCE = {
    "no_load_speed": 0.03,
    "no_load_current": 0.03,
    "stall_torque": 0.03,
    "nominal_current": 0.10,
    "nominal_torque": 0.10,
    "hot_torque": 0.10,
    "winding_time_constant": 0.01,
    "motor_time_constant": 0.01,
    "speed_constant": 0.01,
    "mechanical_time_constant": 0.03,
    "rated_torque_constant": 0.03,
}
# Specific heat of a motor from its time constant, J/(kg.K): steel 460, copper 390, magnets 450, aluminium 900. Open flat motors
# warm up in parts, so that the time constant of the stator alone is printed.
SPECIFIC_HEAT = (200.0, 1000.0)

# Presets whose archives are built every day, a motor of each model; at night all. A preset is only start values, and the tests of
# its values that need no archive take all presets every day.
EVERYDAY = ("maxon-305015", "thesis-rig", "maxon-re30-gp32a-86")


def each(names, every_day=None):
    """A test for each of these presets; `every_day` are those of the everyday run."""
    marks = {name: () if every_day is None or name in every_day else pytest.mark.nightly for name in names}
    return pytest.mark.parametrize("name", [pytest.param(name, marks=marks[name]) for name in names])


WITH_PRINT = [n for n, p in PRINTED.items() if "no_datasheet" not in p]
DIRECT = [n for n in WITH_PRINT if "same_motor" not in PRINTED[n]]


def value(name, key):
    """A value of the preset; 0 if it has none and the effect is off."""
    found = PRESETS[name]["start"].get(key)
    return found["value"] if found else 0.0


def check(name, quantity, model, printed):
    """Model over print is 1 within the tolerance, or the recorded deviation."""
    ratio = model / printed
    expected, reason = PRINTED[name].get("deviation", {}).get(quantity, (1.0, ""))
    text = f"{name}, {quantity}: model {model:.4g}, printed {printed:.4g}, ratio {ratio:.3f}"
    if reason:
        assert abs(expected - 1) > TOLERANCE[quantity], f"{text}: the deviation {expected} is within the tolerance, remove it"
        assert abs(ratio - expected) <= 0.01, f"{text}, recorded {expected}: {reason}"
    else:
        assert abs(ratio - 1) <= TOLERANCE[quantity], text


@pytest.fixture(scope="module")
def built(program, tmp_path_factory):
    """The FMI 3.0 archive of a preset, built once. `motor-fmu build` makes the checks of `motor-fmu validate`."""
    archives = {}

    def build(name):
        if name not in archives:
            out, model = tmp_path_factory.mktemp(name), PRESETS[name]["model"]
            command = [program, "build", model, "--preset", FILES[name], "--fmi", "3", "--out", out]
            done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=300)
            report = done.stdout + done.stderr
            assert done.returncode == 0 and f"{model}.fmu: 0 errors, 0 warnings" in report, f"{name}: {report}"
            archives[name] = out / "fmi3" / f"{model}.fmu"
        return archives[name]

    return build


def settings(name, sets):
    """Arguments of `motor-fmu` for values by name (`__` for the point), at the ambient temperature the datasheet refers to."""
    pairs = {"ambient_temperature": value(name, "motor.T_ref"), **sets}
    return [part for key, v in pairs.items() for part in ("--set", f"{key.replace('__', '.')}={v}")]


@pytest.fixture
def simulate(motor_fmu, built, tmp_path):
    """The outputs over time of the archive of a preset, as rows of name and value; the last is the final state."""

    def run(name, stop, **sets):
        output = tmp_path / "out.csv"
        done = motor_fmu("simulate", built(name), "--stop", stop, "--step", stop / 500, "--output", output, *settings(name, sets))
        assert done.returncode == 0, f"{name}: {done.stderr}"
        with output.open() as lines:
            return [{key: float(v) for key, v in row.items() if v not in ("true", "false")} for row in csv.DictReader(lines)]

    return run


@pytest.fixture
def continuous(motor_fmu):
    """Continuous current and torque of a preset from `motor-fmu steady`."""

    def run(name, **sets):
        sets = settings(name, {"current_command": 0, **sets})
        done = motor_fmu("steady", "--model", "AnnulusCooledMotor", "--preset", FILES[name], *sets, "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)["continuous"]

    return run


def test_every_preset_has_a_datasheet_or_says_why_not():
    assert set(FILES) == set(PRINTED), "files without a table, or tables without a file"
    for name, table in PRESETS.items():
        assert table["name"] == name and PRINTED[name]["source"], name


def test_readme_of_the_library_lists_every_preset():
    text = (EXAMPLES / "presets" / "README.md").read_text()
    listed = set(re.findall(r"^\| `([^`]+)` \|", text, re.MULTILINE))
    assert listed == set(FILES)


@each(FILES)
def test_every_value_says_where_it_is_from(name):
    """A comment on the line of each value or above it; where a datasheet is the source, with the certainty."""
    lines = FILES[name].read_text().split("[start]")[1].splitlines()
    comment = ""
    for line in lines:
        if line.startswith("#"):
            comment = line
        elif line.startswith('"'):
            note = line.partition("#")[2] or comment
            assert note, f"{name}: {line} has no source"
            if "no_datasheet" not in PRINTED[name]:
                words = r"datasheet|distributor|derived|default|estimate|not verified"
                assert re.search(words, note, re.IGNORECASE), f"{name}: {line} does not say how sure it is"
        else:
            comment = ""


@each(FILES, EVERYDAY)
def test_archive_of_the_preset_is_valid(name, built):
    assert built(name).is_file()


@each(WITH_PRINT, EVERYDAY)
def test_no_load_point(name, simulate):
    printed, of = PRINTED[name], lambda key: value(name, key)
    # Twenty times the mechanical time constant J R/k_t^2 and the electrical one L/R: the winding is still cold.
    settled = 20 * (of("motor.J") * of("motor.R_ref") / of("motor.k_t") ** 2 + of("motor.L") / of("motor.R_ref"))
    sets = {"duty": 1} if of("gear.ratio") else {"voltage": printed["nominal_voltage_V"]}
    final = simulate(name, settled, **sets)[-1]
    check(name, "no_load_speed", final["shaft_speed"] / RPM, printed["no_load_speed_rpm"])
    if "no_load_current_mA" in printed:
        check(name, "no_load_current", final["current"] * 1e3, printed["no_load_current_mA"])


@each(DIRECT, EVERYDAY)
def test_stall_torque(name, simulate):
    printed = PRINTED[name]
    sets = {"mechanical_mode": "imposed_speed", "voltage": printed["nominal_voltage_V"], "motor__L": 1e-6}
    final = simulate(name, 10 * 1e-6 / value(name, "motor.R_ref"), **sets)[-1]
    check(name, "stall_torque", final["shaft_torque"] * 1e3, printed["stall_torque_mNm"])


@each(DIRECT)
def test_nominal_point(name, continuous):
    """Continuous current and torque with k_t of the catalogue, and the torque with hot magnets."""
    printed = PRINTED[name]
    speed = 0 if printed.get("standstill") else printed["nominal_speed_rpm"] * RPM
    sets = {"imposed_speed": speed, **printed.get("conditions", {})}
    cold, hot = continuous(name, motor__alpha_mag=0, **sets), continuous(name, **sets)
    check(name, "nominal_torque", cold["torque"] * 1e3, printed["nominal_torque_mNm"])
    check(name, "hot_torque", hot["torque"] * 1e3, printed["nominal_torque_mNm"])
    if "nominal_current_A" in printed:
        check(name, "nominal_current", cold["current"], printed["nominal_current_A"])


def heating(name):
    """Electrical power into the winding at standstill that heats the housing by 10 K."""
    return {"drive_mode": "power", "mechanical_mode": "imposed_speed", "electrical_power": 10 * value(name, "conductance.G_still")}


@each([n for n, p in PRINTED.items() if "winding_time_constant_s" in p], EVERYDAY)
def test_winding_time_constant(name, simulate):
    """Housing held at ambient temperature: time constant from the rise after the printed one."""
    tau = PRINTED[name]["winding_time_constant_s"]
    sets = heating(name) | {"conductance__G_still": 1e4}
    rise = simulate(name, tau, **sets)[-1]["winding_temperature"] - value(name, "motor.T_ref")
    final = sets["electrical_power"] * value(name, "thermal.R_wh")
    check(name, "winding_time_constant", -tau / log(1 - rise / final), tau)


@each(DIRECT, EVERYDAY)
def test_motor_time_constant(name, simulate):
    """The mean delay of the housing's step response, the integral of what is missing, is the sum of both time constants."""
    tau, winding = PRINTED[name]["motor_time_constant_s"], value(name, "thermal.C_w") * value(name, "thermal.R_wh")
    rows = simulate(name, 15 * (tau + winding), **heating(name))
    missing = [1 - (row["housing_temperature"] - value(name, "motor.T_ref")) / 10 for row in rows]
    times = [row["time"] for row in rows]
    delay = sum((missing[k] + missing[k - 1]) / 2 * (times[k] - times[k - 1]) for k in range(1, len(rows)))
    check(name, "motor_time_constant", delay - winding, tau)


@each(DIRECT)
def test_printed_values_agree_with_each_other(name):
    printed, of = PRINTED[name], lambda key: value(name, key)
    if "speed_constant_rpm_per_V" in printed:
        check(name, "speed_constant", 1 / (of("motor.k_t") * RPM), printed["speed_constant_rpm_per_V"])
    if "mechanical_time_constant_ms" in printed:
        rise = of("motor.J") * of("motor.R_ref") / of("motor.k_t") ** 2
        check(name, "mechanical_time_constant", rise * 1e3, printed["mechanical_time_constant_ms"])
    if "nominal_current_A" in printed and not printed.get("conditions"):
        # M_N = k_t (I_N - I_0) in the makers' definition.
        torque = of("motor.k_t") * (printed["nominal_current_A"] * 1e3 - printed.get("no_load_current_mA", 0.0))
        check(name, "rated_torque_constant", torque, printed["nominal_torque_mNm"])
    heat = printed["motor_time_constant_s"] * of("conductance.G_still") / of("motor.mass")
    low, high = SPECIFIC_HEAT
    assert low < heat < high, f"{name}: {heat:.0f} J/(kg.K) from the motor's time constant, its thermal resistance and its weight"


@each([n for n, p in PRINTED.items() if "same_motor" in p])
def test_gearmotor_has_the_data_of_its_motor(name):
    motor = PRINTED[name]["same_motor"]
    shared = [k for k in PRESETS[name]["start"] if k in PRESETS[motor]["start"] and k != "motor.J"]
    assert len(shared) >= 10
    for key in shared:
        assert value(name, key) == value(motor, key), key
    resistance = 1 / value(name, "thermal.G_hb") + 1 / value(name, "thermal.G_ba")
    assert resistance == pytest.approx(1 / value(motor, "conductance.G_still"), rel=1e-4)


def test_the_program_lists_every_file_and_names_the_nearest(motor_fmu):
    listed = json.loads(motor_fmu("presets", "--json").stdout)
    assert [preset["name"] for preset in listed] == list(FILES)
    table = motor_fmu("presets").stdout.splitlines()
    assert [line.split()[0] for line in table] == [preset["name"] for preset in listed]
    wrong = motor_fmu("steady", "--preset", "maxon-re40-148878")
    assert wrong.returncode == 2 and "did you mean maxon-re40-148877?" in wrong.stderr


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_preset_with_inputs_and_an_experiment_runs_without_settings(motor_fmu, tmp_path, fmi):
    """The preset of docs/importers.md: a tool that only loads the FMU and starts it sees a motor that warms up."""
    page = (EXAMPLES.parent / "docs" / "importers.md").read_text()
    text = re.search(r"```toml\n(.*?)```", page, re.S)[1]
    (tmp_path / "loaded.toml").write_text(textwrap.dedent(text))
    done = motor_fmu("build", "AnnulusCooledMotor", "--fmi", fmi, "--preset", tmp_path / "loaded.toml", "--out", tmp_path / "dist")
    assert done.returncode == 0, done.stderr
    result = simulate_fmu(str(tmp_path / "dist" / f"fmi{fmi}" / "AnnulusCooledMotor.fmu"))
    assert result["time"][-1] == pytest.approx(1800.0)
    assert result["shaft_speed"][-1] > 500.0
    stated = int(re.search(r"the winding is at (\d+) °C", page)[1])
    assert result["winding_temperature"][-1] - 273.15 == pytest.approx(stated, abs=0.5)


@pytest.mark.parametrize(
    "choices",
    [
        pytest.param({"commutation": "block", "cooling_mode": "annulus_push"}),
        pytest.param({"commutation": "sinusoidal", "cooling_mode": "bare"}, marks=pytest.mark.nightly),
        pytest.param({"commutation": "block", "cooling_mode": "conductance"}, marks=pytest.mark.nightly),
    ],
    ids=lambda choices: " ".join(choices.values()),
)
def test_an_archive_that_starts_in_other_modes_is_valid(choices, program, tmp_path):
    """Block commutation changes the conducting phases several hundred times in a step of the checks."""
    start = {"drive_mode": "current", "mechanical_mode": "imposed_speed", **choices}
    preset = tmp_path / "modes.toml"
    lines = "\n".join(f'"{name}" = "{item}"' for name, item in start.items())
    preset.write_text(f'name = "modes"\nmodel = "AnnulusCooledMotor"\n[start]\n{lines}\n', encoding="utf-8")
    command = [program, "build", "AnnulusCooledMotor", "--preset", preset, "--fmi", "2", "--out", tmp_path / "out"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and "0 errors, 0 warnings" in done.stdout + done.stderr, done.stdout + done.stderr
