"""A system of 20 small FMUs of both standards, with two rates and an algebraic loop, against its monolithic solution; also with a component
of pythonfmu, and with components that step at the same time."""

import json
import os
import subprocess

import corpus
import numpy as np
import pytest
from corpus import exports
from requirements import where_demanded

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


def description(step, integrator=None):
    """Lag 0 has the constant input 1; lag 9 gets y_a, all others the lag before them. With an integrator the last lag is made of it and of
    a sum: its rate is the gain 1 / T times the lag before it minus its own state."""
    connect = [f"x{k - 1}.x -> x{k}.u" for k in range(1, LAGS) if k != 9]
    connect += ["a.y -> x9.u", "b.y -> a.u", "a.y -> b.u", "x8.x -> a.v", "x17.x -> b.v"]
    text = f'[system]\nname = "large"\nconnect = {json.dumps(connect)}\n[experiment]\nstop = {STOP}\nstep = {step}\n'
    if integrator:
        last = LAGS - 1
        text = text.replace(f'"x{last - 1}.x -> x{last}.u"', f'"x{last - 1}.x -> minus.v", "i.y -> minus.u", "minus.y -> i.u"')
        text = text.replace(f"x{last}.x ->", "i.y ->")
        text += f'[[component]]\nname = "i"\nfmu = "{integrator}"\n[component.set]\ngain = {1.0 / TIMES[last]}\n'
        text += '[[component]]\nname = "minus"\nfmu = "sum2.fmu"\n[component.set]\na = -1.0\n'
    for k, time in enumerate(TIMES[: LAGS - 1] if integrator else TIMES):
        own = f"step = {step / 4}\n" if k % 3 == 0 else ""
        text += f'[[component]]\nname = "x{k}"\nfmu = "lag{2 + k % 2}.fmu"\n{own}[component.set]\nT = {time}\n'
    for name, fmi, gain in (("a", 2, A), ("b", 3, B)):
        text += f'[[component]]\nname = "{name}"\nfmu = "sum{fmi}.fmu"\n[component.set]\na = {gain}\n'
    return text


@pytest.fixture
def parts(tmp_path):
    """The FMUs of the system."""
    for model in ("lag", "sum"):
        for fmi in (2, 3):
            corpus.build(model, fmi, tmp_path / f"{model}{fmi}.fmu")
    return tmp_path


@pytest.mark.parametrize(
    "algorithm, exporter", [("jacobi", None), ("gauss-seidel", None), pytest.param("jacobi", "pythonfmu", marks=where_demanded("pythonfmu"))]
)
def test_a_large_system_equals_its_monolithic_solution(program, parts, algorithm, exporter):
    (parts / "pythonfmu").mkdir()
    integrator = exports.build(exporter, parts / exporter) if exporter else None
    environment = {**os.environ, **(exports.with_python() if exporter else {})}
    names = [f"x{k}.x" for k in range(LAGS - 1)] + ["i.y" if exporter else f"x{LAGS - 1}.x", "a.y", "b.y"]

    def run(step):
        (parts / "s.toml").write_text(description(step, integrator))
        command = [program, "cosim", "s.toml", "--algorithm", algorithm, "--json"]
        done = subprocess.run(command, cwd=parts, env=environment, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        result = json.loads(done.stdout)
        assert len(result["order"]) == LAGS + 2 + (1 if exporter else 0)
        return np.array([result["final"][name] for name in names])

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


def test_components_that_step_at_the_same_time_give_the_same_bits(motor_fmu, parts):
    """Also with components that have shorter steps of their own, and an algebraic loop."""
    (parts / "s.toml").write_text(description(1e-3))
    rows = []
    for threads in (1, 3):
        done = motor_fmu("cosim", "s.toml", "--threads", threads, "--output", f"{threads}.csv")
        assert done.returncode == 0, done.stderr
        rows.append((parts / f"{threads}.csv").read_bytes())
    assert rows[0] == rows[1] and rows[0].count(b"\n") > 1000


def test_a_crash_beside_other_steps_is_named(motor_fmu, parts):
    """Of several calls that last at the same time one is the cause; the sentence has the crashing one among them."""
    corpus.build("lag:segfault", 2, parts / "lag2.fmu")
    (parts / "s.toml").write_text(description(1e-3))
    done = motor_fmu("cosim", "s.toml", "--threads", 3)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert "segmentation fault" in done.stderr and "fmi2DoStep of x" in done.stderr, done.stderr
