"""Values that are set without effect in the selected modes are named: `motor-fmu simulate`, `steady`, `sweep` and `build`."""

import json
import re
import subprocess
import zipfile

import pytest
from clients import paths
from test_cli_bad_input import CANNOT, one_sentence

MOTOR = "AnnulusCooledMotor"
MODES = ("--set", "drive_mode=current", "--set", "mechanical_mode=imposed_speed")


@pytest.fixture(scope="module", params=(2, 3), ids=lambda fmi: f"fmi{fmi}")
def archive(request):
    return paths.archive(MOTOR, request.param)


def notes(done):
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["notes"]


def test_an_input_that_the_modes_ignore(motor_fmu, archive):
    """In drive_mode current the voltage changes no output, and a note says so and how to use it."""
    without, with_voltage = (
        motor_fmu("simulate", archive, "--stop", 0.1, *MODES, "--set", "current_command=2", *further, "--json")
        for further in ((), ("--set", "voltage=24", "--set", "load_torque=0.1"))
    )
    assert json.loads(without.stdout)["final"] == json.loads(with_voltage.stdout)["final"]
    assert notes(without) == []
    (note,) = notes(with_voltage)
    assert "voltage (--set) has no effect with drive_mode = current, only with drive_mode = voltage or pwm" in note
    assert "load_torque (--set) has no effect with mechanical_mode = imposed_speed" in note
    assert f"note: {note}" in with_voltage.stderr
    # The settings that the note names, in place of the others, give both an effect.
    settings = re.findall(r"--set \S+", note)
    assert settings == ["--set drive_mode=voltage", "--set mechanical_mode=free_shaft"]
    used = [part for setting in settings for part in setting.split()]
    done = motor_fmu("simulate", archive, "--stop", 0.1, *used, "--set", "voltage=24", "--set", "load_torque=0.1", "--json")
    assert notes(done) == []
    assert json.loads(done.stdout)["final"]["shaft_speed"] != 0.0


def test_a_column_of_an_input_file(motor_fmu, archive, tmp_path):
    (tmp_path / "inputs.csv").write_text("time,duty,fan_command\n0,0.5,1\n1,0.5,1\n")
    (note,) = notes(motor_fmu("simulate", archive, "--stop", 0.1, "--input", "inputs.csv", "--json"))
    assert "duty (--input) has no effect with drive_mode = voltage, only with drive_mode = pwm" in note
    assert "fan_command" not in note


def test_a_resistance_that_the_cooling_mode_drops(motor_fmu):
    power = ("--set", "electrical_power=10", "--preset", "maxon-305015", "--json")
    assert notes(motor_fmu("steady", *power)) == []
    (note,) = notes(motor_fmu("steady", "--set", "cooling_mode=bare", *power))
    assert note.startswith("conductance.G_still (preset maxon-305015) has no effect with cooling_mode = bare")
    (note,) = notes(motor_fmu("sweep", "--vary", "fan.flow_max=0.001:0.005:2", "--objective", "winding_temperature", *power))
    assert note.startswith("fan.flow_max (--vary) has no effect with cooling_mode = conductance, only with cooling_mode = ")


def test_the_page_of_an_archive_names_unused_inputs(motor_fmu, tmp_path):
    preset = "name = 'bench'\nmodel = 'AnnulusCooledMotor'\ndescription = 'd'\n\n[start]\ndrive_mode = 'current'\n\"motor.L\" = 1e-4\n"
    (tmp_path / "bench.toml").write_text(preset.replace("'", '"'))
    done = motor_fmu("build", MOTOR, "--fmi", "3", "--preset", "bench.toml", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "note: motor.L (preset bench) has no effect with drive_mode = current" in done.stderr
    with zipfile.ZipFile(tmp_path / "out" / "fmi3" / f"{MOTOR}.fmu") as archive:
        page = archive.read("documentation/index.html").decode()
    assert "voltage has no effect with drive_mode = current, only with drive_mode = voltage or pwm" in page


def test_version_names_the_product(program):
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    assert re.fullmatch(r"motor-fmu \d+\.\d+\.\d+\n", done.stdout)


def test_a_variable_of_other_models_is_refused_with_the_reason(motor_fmu, tmp_path):
    """`simulate` and `cosim` say what `build --preset` says of a variable that the model does not serve."""
    fmu = paths.archive("BrushedGearmotor", 2)
    preset = tmp_path / "p.toml"
    preset.write_text('model = "BrushedGearmotor"\nname = "p"\n[start]\n"effect.drive_loss.share" = 0.1\n')
    said = motor_fmu("build", "BrushedGearmotor", "--preset", preset).stderr
    reason = "BrushedGearmotor has no variable effect.drive_loss.share: "
    assert reason in said, said
    sentence = said[said.index(reason) :].strip()
    one_sentence(motor_fmu("simulate", fmu, "--set", "effect.drive_loss.share=0.1"), CANNOT, sentence)
    system = tmp_path / "one.toml"
    system.write_text(f'[system]\nname = "one"\n[[component]]\nname = "drive"\nfmu = "{fmu}"\n[experiment]\nstop = 0.1\nstep = 0.01\n')
    one_sentence(motor_fmu("cosim", system, "--set", "drive.effect.drive_loss.share=0.1"), CANNOT, "drive: ", sentence)


@pytest.mark.parametrize("name, first", [("load", "load_torque"), ("mass", "fan.mass"), ("motor.R", "motor.R_ref")])
def test_the_nearest_names_begin_with_what_was_written(motor_fmu, name, first):
    done = motor_fmu("simulate", paths.archive(MOTOR, 2), "--set", f"{name}=1")
    one_sentence(done, CANNOT, f"has no variable {name}, did you mean {first}")
