"""Actions of a master between two steps: other step sizes, rollback, several instances, reset."""

import pytest
from reference import STATES

DRIVE = dict(voltage=24.0, load_torque=0.05)


def run(fmu, steps, size=1e-3):
    for _ in range(steps):
        fmu.step(size)
    return fmu.get(*STATES)


def test_variable_communication_step(make):
    """Constant inputs: the end does not depend on the step sizes."""
    even, uneven = make(**DRIVE), make(**DRIVE)
    run(even, 400)
    for size in [1e-5] * 50 + [3e-4] * 5 + [0.098] + [0.02] * 5 + [2e-3] * 99 + [1e-3] * 2:
        uneven.step(size)
    assert uneven.time == pytest.approx(even.time, abs=1e-12)
    for name, a, b in zip(STATES, even.get(*STATES), uneven.get(*STATES)):
        assert b == pytest.approx(a, rel=1e-6), name


def test_rollback_is_bitwise(make):
    fmu = make(**DRIVE)
    run(fmu, 20)
    saved = fmu.state()
    there = run(fmu, 30)
    fmu.set({"voltage": -10.0})
    run(fmu, 7, 5e-4)
    fmu.restore(saved)
    assert run(fmu, 30) == there
    fmu.free(saved)


def test_state_may_be_restored_twice_and_reused(make):
    fmu = make(**DRIVE)
    saved = fmu.state()
    first = run(fmu, 10)
    fmu.restore(saved)
    second = run(fmu, 10)
    fmu.restore(saved)
    assert first == second == run(fmu, 10)
    fmu.free(saved)


def test_serialised_state_moves_to_another_instance(make):
    fmu, other = make(**DRIVE), make(voltage=-5.0, load_torque=0.0)
    run(fmu, 20)
    run(other, 3)
    saved = fmu.state()
    data, time = fmu.serialise(saved), fmu.time
    fmu.free(saved)
    there = run(fmu, 30)
    copy = other.deserialise(data, time)
    other.restore(copy)
    other.free(copy)
    assert run(other, 30) == there


def test_instances_are_independent(make):
    alone = make(**DRIVE)
    expected = run(alone, 50)
    a, b = make(**DRIVE), make({"motor.R_ref": 0.5}, voltage=-12.0, fan_command=1.0)
    for _ in range(50):
        a.step(1e-3)
        b.step(1e-3)
    assert a.get(*STATES) == expected
    assert b.get(*STATES) != expected


def test_reset_starts_again(make):
    fmu = make(**DRIVE)
    first = run(fmu, 50)
    fmu.set({"motor.R_ref": 0.7})
    run(fmu, 10)
    fmu.reset()
    fmu.initialise(DRIVE)
    assert run(fmu, 50) == first


def test_tunable_parameter_acts_while_stepping(make):
    fmu, other = make(drive_mode="current", current_command=5.0), make(drive_mode="current", current_command=5.0)
    run(fmu, 5)
    run(other, 5)
    fmu.set({"motor.R_ref": 2.0 * other.get("motor.R_ref")[0]})
    assert fmu.get("winding_resistance")[0] == pytest.approx(2.0 * other.get("winding_resistance")[0], rel=1e-12)


def test_duty_times_supply_is_the_voltage(make):
    chopped, direct = make(drive_mode="pwm", voltage=48.0, duty=-0.25), make(drive_mode="voltage", voltage=-12.0)
    assert run(chopped, 50) == run(direct, 50)
    assert chopped.get("terminal_voltage") == [-12.0]


def test_power_drive_heats_without_torque(make):
    fmu = make(drive_mode="power", electrical_power=10.0)
    run(fmu, 10, 1.0)
    current, speed, winding, housing = fmu.get("current", "shaft_speed", "winding_temperature", "housing_temperature")
    assert (current, speed) == (0.0, 0.0)
    assert winding > housing > fmu.get("ambient_temperature")[0]
