"""A system of 20 small FMUs of both standards, with two rates and an algebraic loop, against its monolithic solution."""

import json

import corpus
import numpy as np
import pytest

LAGS = 18
#: Time constants (s): each third lag is fast and has a step of its own.
TIMES = [0.02 if k % 3 == 0 else 0.1 + 0.01 * k for k in range(LAGS)]
#: y_a = A y_b + x_8, y_b = B y_a + x_17: the gain around the loop is -3, so that a plain fixed point diverges.
A, B = 2.0, -1.5
STOP = 2.0


def monolithic():
    """The states at the end: x' = M x + c, by the exponential of M; its Taylor series for a small part of the time, squared."""
    matrix, constant = np.zeros((LAGS, LAGS)), np.zeros(LAGS)
    y_a = np.zeros(LAGS)
    y_a[8], y_a[17] = 1.0 / (1.0 - A * B), A / (1.0 - A * B)
    y_b = B * y_a
    y_b[17] += 1.0
    for k, time in enumerate(TIMES):
        matrix[k, k] -= 1.0 / time
        if k == 0:
            constant[k] = 1.0 / time
        elif k == 9:
            matrix[k] += y_a / time
        else:
            matrix[k, k - 1] += 1.0 / time
    rest = np.linalg.solve(matrix, -constant)
    part, term, squarings = np.eye(LAGS), np.eye(LAGS), 12
    for k in range(1, 15):
        term = term @ matrix * (STOP / 2**squarings / k)
        part = part + term
    states = rest - np.linalg.matrix_power(part, 2**squarings) @ rest
    return states, y_a @ states, y_b @ states


def description(step):
    """Lag 0 has the constant input 1; lag 9 gets y_a, all others the lag before them."""
    connect = [f"x{k - 1}.x -> x{k}.u" for k in range(1, LAGS) if k != 9]
    connect += ["a.y -> x9.u", "b.y -> a.u", "a.y -> b.u", "x8.x -> a.v", "x17.x -> b.v"]
    text = f'[system]\nname = "large"\nconnect = {json.dumps(connect)}\n[experiment]\nstop = {STOP}\nstep = {step}\n'
    for k, time in enumerate(TIMES):
        own = f"step = {step / 4}\n" if k % 3 == 0 else ""
        text += f'[[component]]\nname = "x{k}"\nfmu = "lag{2 + k % 2}.fmu"\n{own}[component.set]\nT = {time}\n'
    for name, fmi, gain in (("a", 2, A), ("b", 3, B)):
        text += f'[[component]]\nname = "{name}"\nfmu = "sum{fmi}.fmu"\n[component.set]\na = {gain}\n'
    return text


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_a_large_system_equals_its_monolithic_solution(motor_fmu, tmp_path, algorithm):
    for model in ("lag", "sum"):
        for fmi in (2, 3):
            corpus.build(model, fmi, tmp_path / f"{model}{fmi}.fmu")

    def run(step):
        (tmp_path / "s.toml").write_text(description(step))
        done = motor_fmu("cosim", "s.toml", "--algorithm", algorithm, "--json")
        assert done.returncode == 0, done.stderr
        result = json.loads(done.stdout)
        assert len(result["order"]) == LAGS + 2
        final = result["final"]
        return np.array([*(final[f"x{k}.x"] for k in range(LAGS)), final["a.y"], final["b.y"]])

    states, y_a, y_b = monolithic()
    exact = np.array([*states, y_a, y_b])
    coarse, middle, fine = (run(step) for step in (2e-3, 1e-3, 5e-4))
    # The loop is solved at the last communication point.
    assert fine[-2] == pytest.approx(A * fine[-1] + fine[8], abs=1e-12)
    assert fine[-1] == pytest.approx(B * fine[-2] + fine[17], abs=1e-12)
    # The inputs of these FMUs are constant during a step: first order, and second order after extrapolation.
    errors = [np.abs(found - exact).max() for found in (coarse, middle, fine)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05) and errors[1] / errors[2] == pytest.approx(2.0, rel=0.05)
    extrapolated = [np.abs(2.0 * b - a - exact).max() for a, b in ((coarse, middle), (middle, fine))]
    assert extrapolated[0] / extrapolated[1] == pytest.approx(4.0, rel=0.1) and extrapolated[1] < 1e-5
