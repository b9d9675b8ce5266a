"""The two-node thermal network compared with its closed form, the matrix exponential."""

import numpy as np
import pytest
from reference import Motor
from scipy.linalg import expm

HEAT = 25.0  # W


@pytest.mark.parametrize("fan", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("step", [0.01, 1.0, 60.0])
def test_against_the_matrix_exponential(make, fan, step):
    fmu = make(drive_mode="current", mechanical_mode="imposed_speed", heat_power=HEAT, fan_command=fan)
    twin = Motor.like(fmu)
    p, ambient = twin.p, fmu.get("ambient_temperature")[0]
    link = 1.0 / p["R_wh"]
    # Rise above ambient, with a constant heat as a third state that does not move.
    a = np.array(
        [
            [-link / p["C_w"], link / p["C_w"], HEAT / p["C_w"]],
            [link / p["C_h"], -(link + twin.conductance(fan)) / p["C_h"], 0.0],
            [0.0, 0.0, 0.0],
        ]
    )
    for k in range(1, 41):
        fmu.step(step)
        exact = ambient + (expm(a * step * k) @ [0.0, 0.0, 1.0])[:2]
        found = np.array(fmu.get("winding_temperature", "housing_temperature"))
        assert np.abs(found - exact).max() <= 1e-9 * (exact[0] - ambient) + 1e-10
