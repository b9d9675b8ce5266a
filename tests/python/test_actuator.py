"""The series elastic actuator: single laws, then in a loop with the FMU."""

import math

import numpy as np
import pytest
from clients.actuator import Actuator, Design, MotorData
from clients.gait import Gait
from clients.walking import results, spring_energy, transmission_loss, walk

R, K_T = 0.386, 0.0276
MOTOR = MotorData(k_t=K_T, J=33.3e-7, tau_c=9.83e-3, w_small=1.0)
GAIT = Gait(75.0)
SECONDS = 12.0


@pytest.fixture
def actuator():
    return Actuator(Design(), MOTOR, GAIT, 1e-3)


@pytest.mark.parametrize("torque", [-60.0, -1.0, 2.0, 90.0])
@pytest.mark.parametrize("speed", [-900.0, 900.0])
def test_transmission_loses_in_both_directions(actuator, torque, speed):
    motor_side = actuator.load_torque(torque, speed) * speed
    spring_side = torque * speed / actuator.design.ratio
    assert motor_side > spring_side
    expected = actuator.design.efficiency if spring_side > 0.0 else 1.0 / actuator.design.efficiency
    # tanh is one within 1e-3 from four P_small on.
    assert spring_side / motor_side == pytest.approx(expected, rel=1e-3)


def test_one_law_for_numbers_and_arrays(actuator):
    torque, speed = np.array([-30.0, 0.0, 40.0]), np.array([100.0, 5.0, 300.0])
    arrays = actuator.load_torque(torque, speed, np.tanh)
    numbers = [actuator.load_torque(t, s) for t, s in zip(torque.tolist(), speed.tolist())]
    assert np.allclose(arrays, numbers, rtol=1e-14, atol=0.0)


def test_commands_respect_current_and_supply():
    for speed in (-1500.0, 0.0, 1500.0):
        for angle in (-1e4, 1e4):
            d = Design()
            command, _ = Actuator(d, MOTOR, GAIT, 1e-3).command(0, (angle, speed, R, K_T))
            voltage, _ = Actuator(d, MOTOR, GAIT, 1e-3, "voltage").command(0, (angle, speed, R, K_T))
            assert abs(command) <= d.current_max
            assert abs(voltage) <= d.supply_voltage * (1 + 1e-12)
            assert math.copysign(1.0, command) == -math.copysign(1.0, angle)


@pytest.mark.parametrize(
    "bad", [dict(ratio=0.0), dict(stiffness=-1.0), dict(efficiency=1.2), dict(efficiency=0.0), dict(current_max=float("nan"))]
)
def test_bad_design_is_named(bad):
    (name, value), = bad.items()
    with pytest.raises(ValueError, match=name) as caught:
        Design(**bad)
    assert str(value) in str(caught.value)


@pytest.fixture(scope="module", params=["current", "voltage"])
def run(request, archive_paths):
    return walk(archive_paths[2], GAIT, Design(), SECONDS, request.param)


def test_joint_gets_the_torque_it_asked_for(run):
    assert results(run)["joint_torque_error_rms_percent_of_peak"] < 2.0
    assert np.abs(run.torque_demand).max() == pytest.approx(1.37 * 75.0, rel=0.02)


def test_supply_is_enough(run):
    found = results(run)
    assert found["voltage_peak_V"] < run.actuator.design.supply_voltage
    assert found["current_peak_A"] < run.actuator.design.current_max


def test_energy_balance_of_the_actuator(run):
    """Shaft work of the FMU = joint work + transmission loss + spring energy."""
    found = results(run)
    assert abs(found["energy_balance_error_percent"]) < 0.2
    assert transmission_loss(run) > 0.05 * abs(found["energy_joint_J"])
    peak = np.abs(run.joint_torque).max() ** 2 / (2.0 * run.actuator.design.stiffness)
    assert abs(spring_energy(run)) < peak


def test_shaft_work_is_what_the_load_took(run):
    """The load torque is constant over a step, so load torque times angle is the exact work of a step."""
    load, angle = run.motor["load_torque"][:-1], run.motor["shaft_angle"]
    work = float(np.sum(load * np.diff(angle)))
    assert run.motor["energy_mechanical"][-1] == pytest.approx(work, rel=1e-6)


def test_drives_agree_on_the_heat(archive_paths):
    """A current loop inside or outside the FMU gives nearly the same heat."""
    ends = [
        walk(archive_paths[2], GAIT, Design(), SECONDS, drive).motor["winding_temperature"][-1]
        for drive in ("current", "voltage")
    ]
    rise = ends[0] - 298.15
    assert rise > 1.0
    assert ends[1] - ends[0] == pytest.approx(0.0, abs=0.1 * rise)


def test_standards_walk_alike(archive_paths):
    """Both standards give the same bits with the master's direct calls."""
    two, three = (walk(archive_paths[fmi], GAIT, Design(), 2.5) for fmi in (2, 3))
    for name, values in two.motor.items():
        assert values.tobytes() == three.motor[name].tobytes(), name
