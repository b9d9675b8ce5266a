"""Initial states that an importer sets: Co-Simulation and Model Exchange of both standards continue a run, both motors."""

import subprocess

import numpy as np
import pytest
from clients import paths
from clients.fmu import Archive
from exchanged import Exchanged

# Initial values and the states that they belong to.
MOTION = {
    "initial.current": "state.current",
    "initial.shaft_speed": "state.shaft_speed",
    "initial.shaft_angle": "state.shaft_angle",
    "initial.winding_temperature": "state.winding_temperature",
}
CASES = {
    "AnnulusCooledMotor": (
        dict(voltage=18.0, load_torque=0.02, ambient_temperature=291.0),
        MOTION | {"initial.housing_temperature": "state.core_temperature"},
    ),
    "BrushedGearmotor": (
        dict(duty=0.8, load_torque=0.2, ambient_temperature=291.0) | {"thermal.C_g": 20.0, "gear.B": 3000.0},
        MOTION
        | {
            "initial.housing_temperature": "state.housing_temperature",
            "initial.box_temperature": "state.box_temperature",
            "initial.gear_temperature": "state.gear_temperature",
        },
    ),
}


@pytest.fixture(scope="module", params=[(m, fmi) for m in CASES for fmi in (2, 3)], ids=lambda p: f"{p[0]}-fmi{p[1]}")
def case(request):
    model, fmi = request.param
    with Archive(paths.archive(model, fmi)) as archive:
        yield archive, *CASES[model]


def test_co_simulation_continues(case):
    archive, start, pairs = case
    first, second = archive.instance(), archive.instance()
    first.initialise(start)
    for _ in range(300):
        first.step(0.01)
    names = list(pairs.values())
    there = first.get(*names)
    second.initialise({**start, **dict(zip(pairs, there))})
    assert second.get(*names) == there
    for _ in range(300):
        first.step(0.01)
        second.step(0.01)
    np.testing.assert_allclose(second.get(*names), first.get(*names), rtol=1e-9, atol=1e-9)
    assert abs(second.get("energy_balance_error")[0]) < 1e-6
    first.close()
    second.close()


def test_model_exchange_starts_there(case):
    archive, start, pairs = case
    values = np.array([1.5, 7.0, 3.0, 345.0, 333.0, 305.0, 320.0][: len(pairs)])
    exchanged = Exchanged(archive, {**start, **dict(zip(pairs, values))})
    assert exchanged.get(pairs.values()) == list(values)
    plain = Exchanged(archive, start)
    ambient = plain.get(["state.winding_temperature"])
    assert ambient == [291.0] and plain.get(["state.shaft_speed"]) == [0.0]
    exchanged.close()
    plain.close()


def test_the_command_line_sets_them_and_names_what_it_refuses(program):
    archive = paths.archive("AnnulusCooledMotor", 3)
    run = lambda *options: subprocess.run([program, "simulate", archive, *options], capture_output=True, text=True)
    rest = ("--set", "voltage=0")
    done = run("--stop", "1", *rest, "--set", "initial.winding_temperature=350", "--set", "initial.housing_temperature=350")
    assert done.returncode == 0, done.stderr
    assert "winding_temperature                76." in done.stdout
    refused = run("--stop", "1", "--set", "initial.winding_temperature=50")
    assert refused.returncode == 2
    assert "initial.winding_temperature = 50 K" in refused.stderr and "543.15" in refused.stderr
