"""Power balance of the FMU at every communication point, energy balance over each run."""

import pytest
from cases import CONSTANT, DRIVE_CYCLE

POWER_ERROR = 1e-6  # W
ENERGY_ERROR = 1e-6  # of the energy that went through


@pytest.mark.parametrize("case", [*CONSTANT, DRIVE_CYCLE], ids=lambda case: case.name)
def test_balances_close(make, case):
    fmu = make(case.start)
    throughput, last = 0.0, 0.0
    for inputs, slopes, steps in case.stretches():
        for k in range(steps):
            fmu.set(vars(inputs.after(slopes, k * case.step)))
            assert abs(fmu.get("power_balance_error")[0]) <= POWER_ERROR
            fmu.step(case.step)
            energy = fmu.get("energy_electrical")[0]
            throughput, last = throughput + abs(energy - last), energy
    assert throughput > 0.0
    assert abs(fmu.get("energy_balance_error")[0]) <= ENERGY_ERROR * throughput


def test_energy_balance_from_the_outputs_closes(make):
    """The stored heat is taken from the temperatures here, so that a wrong book of the FMU cannot agree with itself."""
    fmu = make(drive_mode="current", mechanical_mode="imposed_speed", current_command=8.0, imposed_speed=500.0)
    ambient = fmu.get("ambient_temperature")[0]
    for _ in range(2000):
        fmu.step(0.1)
    electrical, mechanical, ambient_heat = fmu.get(
        "energy_electrical", "energy_mechanical", "energy_heat_to_ambient"
    )
    c_w, c_h, t_w, t_h = fmu.get("thermal.C_w", "thermal.C_h", "winding_temperature", "housing_temperature")
    stored = c_w * (t_w - ambient) + c_h * (t_h - ambient)
    assert electrical - mechanical - ambient_heat == pytest.approx(stored, rel=ENERGY_ERROR)
    assert stored > 0.1 * (electrical - mechanical)


def test_heat_flows_from_warm_to_cold(make):
    """A warm motor at rest in cold ambient air cools, and the winding is never colder than the housing."""
    fmu = make(drive_mode="current", mechanical_mode="imposed_speed", current_command=10.0)
    for _ in range(100):
        fmu.step(1.0)
    fmu.set({"current_command": 0.0})
    w0, h0 = fmu.get("winding_temperature", "housing_temperature")
    assert w0 > h0 > fmu.get("ambient_temperature")[0]
    for _ in range(600):
        fmu.step(1.0)
    w, h, leaving = fmu.get("winding_temperature", "housing_temperature", "heat_to_ambient")
    assert w < w0 and h < h0 and w >= h > fmu.get("ambient_temperature")[0] and leaving > 0.0
