"""The FMU compared with the same equations in SciPy's Radau and DOP853 at a tolerance of 1e-10."""

import numpy as np
import pytest
from cases import CONSTANT, DRIVE_CYCLE, relative_error
from reference import REST, STATES, Motor

WITH_RAMPS = 1e-6
HELD = 1e-5


def start(make, case):
    """An FMU and its reference, both at the start of a case, and the state there."""
    fmu = make(case.start)
    twin = Motor.like(fmu, case.drive, case.shaft, case.knots[0].inputs.ambient_temperature)
    twin.impose(case.knots[0].inputs)
    return fmu, twin


def check(case, found, reference, limit):
    for name, error in zip(STATES, relative_error(found, reference)):
        assert error <= limit, f"{case.name}: {name} is off by {error:.2e}, allowed is {limit:g}"


@pytest.mark.parametrize("case", CONSTANT, ids=lambda case: case.name)
def test_constant_inputs(make, case):
    fmu, twin = start(make, case)
    found, reference = [fmu.get(*STATES)], [twin.y.copy()]
    for inputs, _, steps in case.stretches():
        for _ in range(steps):
            fmu.step(case.step)
            found.append(fmu.get(*STATES))
        reference.extend(twin.advance(inputs, REST, case.step * np.arange(1, steps + 1)))
    check(case, found, reference, WITH_RAMPS)


@pytest.mark.parametrize("archive", [2], ids=["fmi2"], indirect=True)
def test_drive_cycle_with_linear_ramps(make):
    case = DRIVE_CYCLE
    fmu, twin = start(make, case)
    found, reference = [fmu.get(*STATES)], [twin.y.copy()]
    for inputs, slopes, steps in case.stretches():
        moving = {name: slope for name, slope in vars(slopes).items() if slope}
        for k in range(steps):
            fmu.set(vars(inputs.after(slopes, k * case.step)))
            if moving:
                fmu.slopes(moving)
            fmu.step(case.step)
            found.append(fmu.get(*STATES))
        reference.extend(twin.advance(inputs, slopes, case.step * np.arange(1, steps + 1)))
    check(case, found, reference, WITH_RAMPS)


@pytest.fixture(scope="session")
def held_reference(archives):
    """The drive cycle with inputs that jump at every step. The integration starts a thousand times; the result is cached for both standards."""
    case = DRIVE_CYCLE
    with archives[2].instance() as fmu:
        twin = Motor.like(fmu.initialise(case.start), case.drive, case.shaft)
    states = [twin.y.copy()]
    for inputs, slopes, steps in case.stretches():
        for k in range(steps):
            states.extend(twin.advance(inputs.after(slopes, k * case.step), REST, [case.step], method="DOP853"))
    return states


def test_drive_cycle_with_held_inputs(make, held_reference):
    case = DRIVE_CYCLE
    fmu = make(case.start)
    found = [fmu.get(*STATES)]
    for inputs, slopes, steps in case.stretches():
        for k in range(steps):
            fmu.set(vars(inputs.after(slopes, k * case.step)))
            fmu.step(case.step)
            found.append(fmu.get(*STATES))
    check(case, found, held_reference, HELD)


def test_slopes_hold_for_one_step_only(archives):
    """Two steps, input derivative set before the first: in the second the input keeps the value reached."""
    with archives[2].instance() as fmu:
        fmu.initialise({"drive_mode": "current", "mechanical_mode": "imposed_speed"})
        fmu.slopes({"current_command": 1000.0})
        fmu.step(1e-3)
        after_ramp = fmu.get("current")[0]
        fmu.step(1e-3)
        assert after_ramp == pytest.approx(1.0, rel=1e-12)
        assert fmu.get("current")[0] == after_ramp
