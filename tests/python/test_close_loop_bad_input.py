"""Invalid input to `motor-fmu close-loop`: exit code 2 and one sentence with file and line; irregular data are noted."""

import json

import pytest
from clients import paths
from clients.fmu import Archive
from test_cli_bad_input import CANNOT, one_sentence

EXPERIMENT = """\
[experiment]
name   = "small"
model  = "AnnulusCooledMotor"
preset = "maxon-305015"
inputs  = ["current_A", "speed_rad_per_s", "ambient_temperature_degC"]
outputs = ["voltage_V", "winding_temperature_degC"]
[set]
"conductance.G_still" = 0.2
[prior]
"motor.R_ref" = 0.03
[[run]]
file = "run-1.csv"
role = "fit"
[[run]]
file = "run-2.csv"
role = "test"
window_s = [10.0, 90.0]
"""
HEADER = "time_s,current_A,speed_rad_per_s,ambient_temperature_degC,voltage_V,winding_temperature_degC"


STEP = 2.0


@pytest.fixture(scope="module")
def rows():
    """What a bench with the motor of the preset records at 3 A, then 5 A, with errors of readings that do not repeat with the inputs."""
    fixed = {"drive_mode": "current", "mechanical_mode": "imposed_speed", "imposed_speed": 200.0, "conductance.G_still": 0.2}
    found = []
    with Archive(paths.archive("AnnulusCooledMotor", 2, "maxon-305015")) as archive, archive.instance() as motor:
        motor.initialise({**fixed, "current_command": 3.0, "ambient_temperature": 294.15})
        for k in range(60):
            current = 3.0 if k < 30 else 5.0
            motor.set({"current_command": current})
            voltage, winding = motor.get("terminal_voltage", "winding_temperature")
            readings = [round(voltage + 0.001 * (k % 3 - 1), 4), round(winding - 273.15 + 0.01 * (7 * k % 5 - 2), 3)]
            found.append([k * STEP, current, 200.0, 21.0, *readings])
            motor.step(STEP)
    return found


@pytest.fixture
def close_loop(motor_fmu, tmp_path, rows):
    """Writes an experiment with its runs and the given changes, and closes the loop."""

    def run(experiment=("", ""), table=lambda lines: lines, missing=()):
        old, new = experiment
        assert old in EXPERIMENT, old
        (tmp_path / "experiment.toml").write_text(EXPERIMENT.replace(old, new, 1) if old else EXPERIMENT)
        lines = [HEADER, *(",".join(map(str, row)) for row in rows)]
        for name in ("run-1.csv", "run-2.csv"):
            if name not in missing:
                (tmp_path / name).write_text("\n".join(table(list(lines)) if name == "run-2.csv" else lines) + "\n")
        return motor_fmu("close-loop", tmp_path / "experiment.toml", "--out", tmp_path / "out")

    return run


def with_cell(line, column, text):
    """A table with another text in one cell; lines count from 1, the header is line 1."""

    def change(lines):
        cells = lines[line - 1].split(",")
        cells[HEADER.split(",").index(column)] = text
        lines[line - 1] = ",".join(cells)
        return lines

    return change


def test_good_input_is_fine(close_loop, tmp_path):
    done = close_loop()
    assert done.returncode == 0, done.stdout + done.stderr
    notes = " ".join(json.loads((tmp_path / "out" / "report.json").read_text())["notes"])
    assert "dead" not in notes and "no rows" not in notes


def test_missing_column(close_loop):
    def change(lines):
        return [",".join(line.split(",")[:4] + line.split(",")[5:]) for line in lines]

    one_sentence(close_loop(table=change), CANNOT, "run-2.csv:1:", "voltage_V is missing")


def test_text_in_a_number(close_loop):
    one_sentence(close_loop(table=with_cell(7, "current_A", "n/a")), CANNOT, "run-2.csv:7:", "current_A = n/a")


@pytest.mark.parametrize("text", ["NaN", "nan", "inf"])
def test_number_that_is_not_finite(close_loop, text):
    one_sentence(close_loop(table=with_cell(9, "voltage_V", text)), CANNOT, "run-2.csv:9:", f"voltage_V = {text}")


@pytest.mark.parametrize("text", ["6.0", "8.0"])
def test_time_that_does_not_rise(close_loop, text):
    one_sentence(close_loop(table=with_cell(7, "time_s", text)), CANNOT, "run-2.csv:7:", "does not come after 8 s")


def test_row_that_is_too_short(close_loop):
    def change(lines):
        return [*lines[:4], "8.0,3.0", *lines[5:]]

    one_sentence(close_loop(table=change), CANNOT, "run-2.csv:5:", "does not fit the header")


def test_missing_run(close_loop):
    one_sentence(close_loop(missing=("run-2.csv",)), CANNOT, "run-2.csv", "cannot be read")


def test_missing_experiment(motor_fmu, tmp_path):
    one_sentence(motor_fmu("close-loop", tmp_path / "none.toml", "--out", tmp_path / "out"), CANNOT, "none.toml", "cannot be read")


@pytest.mark.parametrize(
    ("experiment", "words"),
    [
        (('"current_A",', '"currant_A",'), ("experiment.toml:5:", "currant_A is no input", "current_A")),
        (('"voltage_V",', '"duty_1",'), ("experiment.toml:6:", "duty_1 is no output")),
        (("AnnulusCooledMotor", "SteamEngine"), ("experiment.toml:3:", "SteamEngine is no model", "AnnulusCooledMotor")),
        (('"conductance.G_still"', '"conductance.G_stil"'), ("experiment.toml:8:", "conductance.G_stil is no parameter")),
        (("= 0.2\n", "= -0.2\n"), ("experiment.toml:8:", "conductance.G_still = -0.2", "outside its limits")),
        (('"motor.R_ref"', '"motor.R_reff"'), ("experiment.toml:10:", "motor.R_reff is no parameter")),
        (("= 0.03", "= 0.0"), ("experiment.toml:10:", "prior of motor.R_ref is 0", "above 0")),
        (('role = "test"', 'role = "exam"'), ("experiment.toml:", "exam", "test")),
        (('role = "fit"', 'role = "validate"'), ("experiment.toml", "no run has role")),
        (("[10.0, 90.0]", "[90.0, 10.0]"), ("experiment.toml:14:", "window_s = [90, 10] is empty", "run-2.csv")),
        (("maxon-305015", "no-such-preset"), ("experiment.toml", "no-such-preset", "motor-fmu presets")),
        (("maxon-305015", "bdcm-37d"), ("experiment.toml", "bdcm-37d", "BrushedGearmotor", "AnnulusCooledMotor")),
        (("preset =", "present ="), ("experiment.toml:4:", "present")),
        (("[set]", "[set"), ("experiment.toml:7:",)),
    ],
    ids=lambda value: value[1] if isinstance(value, tuple) and len(value) == 2 and "." not in value[0] else "",
)
def test_experiment_that_cannot_be(close_loop, tmp_path, experiment, words):
    one_sentence(close_loop(experiment=experiment), CANNOT, *words)
    assert not (tmp_path / "out" / "report.json").exists()


def test_window_without_rows(close_loop):
    """The window is outside the run: no row would count."""
    one_sentence(close_loop(experiment=("[10.0, 90.0]", "[1000.0, 2000.0]")), CANNOT, "experiment.toml:14:", "1000", "run-2.csv")


def test_folder_that_cannot_be_made(close_loop, tmp_path):
    (tmp_path / "out").write_text("a file and no folder")
    one_sentence(close_loop(), CANNOT, "out", "cannot be written")


def test_preset_of_a_file_beside_the_experiment(close_loop, tmp_path):
    listed = (paths.EXAMPLES / "presets" / "maxon-305015.toml").read_text()
    assert listed.count("{ value = 0.386,") == 1
    (tmp_path / "mine.toml").write_text(listed.replace("{ value = 0.386,", "{ value = 0.39,"))
    done = close_loop(experiment=("maxon-305015", "mine.toml"))
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["parameters"]["motor.R_ref"]["prior"] == 0.39


def test_dead_sensor_and_gap_are_noted(close_loop, tmp_path):
    """An open thermocouple reads -61.5 degC: set aside, not fitted. A gap in the rows: simulated across."""

    def change(lines):
        dead = [",".join([*line.split(",")[:5], "-61.5"]) for line in lines[1:]]
        return [lines[0], *dead[:20], *dead[35:]]

    done = close_loop(table=change)
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    notes = " ".join(report["notes"])
    assert "run-2.csv" in notes and "winding_temperature_degC" in notes and "set aside" in notes
    assert "no rows from 38 s to 70 s" in notes
    dead = report["error"]["test"].get("winding_temperature_degC")
    assert dead is None or dead["after"] is None
    assert report["error"]["test"]["voltage_V"]["after"] > 0.0
