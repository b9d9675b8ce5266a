"""The first run in a tool that only loads an FMU and starts it: every model responds, in every archive that `motor-fmu build` writes."""

import textwrap

import numpy as np
import pytest
from clients import paths
from conftest import STANDARDS
from fmpy import read_model_description, simulate_fmu

# Smallest change from the start, in SI units.
RESPONSES = {
    "AnnulusCooledMotor": {"shaft_speed": 100.0, "current": 5.0},
    "BrushedGearmotor": {"shaft_speed": 1.0, "current": 0.5},
    "SeriesElasticActuator": {"voltage": 5.0},
    "GaitLoad": {"joint_angle": 0.2, "joint_speed": 1.0, "torque_demand": 50.0},
}
# Drives, shafts and coolings that no built-in preset selects, with the output that must respond.
PRESETS = {
    "current, imposed speed": ('drive_mode = "current"\nmechanical_mode = "imposed_speed"\nvoltage = 12', "winding_temperature", 2.0),
    "current, free shaft": ('drive_mode = "current"', "shaft_speed", 50.0),
    "power, bare": ('drive_mode = "power"\ncooling_mode = "bare"', "winding_temperature", 2.0),
    "pwm, water jacket": ('drive_mode = "pwm"\ncooling_mode = "water_jacket"', "shaft_speed", 100.0),
    "fan in an annulus": ('cooling_mode = "annulus_pull"\n"motor.R_ref" = "5 Ohm"\n"motor.k_t" = "0.1 N.m/A"', "shaft_speed", 50.0),
}


def change(result, name):
    values = np.array(result[name], dtype=float)
    return np.abs(values - values[0]).max()


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("fmi", STANDARDS)
@pytest.mark.parametrize("model", RESPONSES)
def test_every_model_responds(model, fmi, kind):
    result = simulate_fmu(str(paths.archive(model, fmi)), fmi_type=kind)
    assert result["time"][-1] == pytest.approx(float(read_model_description(str(paths.archive(model, fmi))).defaultExperiment.stopTime))
    found = {name: change(result, name) for name in RESPONSES[model]}
    # What loads or cools the machine is 0 until the importer sets it.
    start = {v.name: v.start for v in read_model_description(str(paths.archive(model, fmi))).modelVariables if v.causality == "input"}
    assert all(float(start[name]) == 0.0 for name in ("load_torque", "fan_command", "coolant_flow_rate") if name in start)
    assert all(found[name] > least for name, least in RESPONSES[model].items()), found
    if "winding_margin" in result.dtype.names:
        assert result["winding_margin"].min() > 0.0


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_responds(motor_fmu, tmp_path, name):
    """Values that have no effect in the modes of the preset, such as a voltage with an imposed current, choose no operating point."""
    text, output, least = PRESETS[name]
    (tmp_path / "own.toml").write_text(f'name = "own"\nmodel = "AnnulusCooledMotor"\n[start]\n{textwrap.dedent(text)}\n')
    done = motor_fmu("build", "AnnulusCooledMotor", "--fmi", 3, "--preset", "own.toml", "--out", "dist")
    assert done.returncode == 0, done.stdout + done.stderr
    result = simulate_fmu(str(tmp_path / "dist" / "fmi3" / "AnnulusCooledMotor.fmu"))
    assert change(result, output) > least, {n: change(result, n) for n in result.dtype.names}
    assert result["winding_margin"].min() > 0.0


def test_a_preset_may_keep_the_motor_at_rest(motor_fmu, tmp_path):
    (tmp_path / "rest.toml").write_text('name = "rest"\nmodel = "AnnulusCooledMotor"\n[start]\nvoltage = 0\nload_torque = 0\n')
    assert motor_fmu("build", "AnnulusCooledMotor", "--fmi", 3, "--preset", "rest.toml", "--out", "dist").returncode == 0
    result = simulate_fmu(str(tmp_path / "dist" / "fmi3" / "AnnulusCooledMotor.fmu"))
    assert change(result, "shaft_speed") == 0.0 and change(result, "winding_temperature") < 1e-6
