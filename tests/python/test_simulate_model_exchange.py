"""`motor-fmu simulate --interface me` against fmpy's CVODE: all models, inputs over time with a jump, recorded locals, messages.

The bouncing ball and the staircase with their closed forms are in test_corpus.py.
"""

import csv
import subprocess

import numpy as np
import pytest
from clients import paths
from conftest import STANDARDS
from fmpy import read_model_description, simulate_fmu

#: Relative tolerance (CVODE has a hundredth of it): of the error of one step, relative to value plus nominal value. Over a run the outputs may be apart by
#: ten of it and by this part of their range.
TOLERANCE, AGREE = 1e-7, 2e-5

CASES = {
    "motor": ("AnnulusCooledMotor", 0.5, 2e-3, {"voltage": 24.0, "load_torque": 0.05}),
    "motor, thermal": ("AnnulusCooledMotor", 600.0, 2.0, {"voltage": 12.0, "load_torque": 0.02}),
    "gearmotor": ("BrushedGearmotor", 2.0, 5e-3, {"duty": 0.6, "load_torque": 0.5}),
    "actuator": ("SeriesElasticActuator", 1.0, 5e-3, {"torque_demand": 20.0, "motor_speed": 5.0}),
    # No row at the end of a stride, where the phase falls from 1 to 0.
    "gait": ("GaitLoad", 2.0, 2.0 / 427, {}),
}


def run(program, path, out, stop, step, *arguments, interface="me"):
    command = [program, "simulate", path, "--interface", interface, "--tolerance", str(TOLERANCE), "--output", out / "me.csv"]
    done = subprocess.run([*command, "--stop", str(stop), "--step", str(step), *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with open(out / "me.csv", newline="") as file:
        names, *rows = csv.reader(file)
    values = np.array(rows, dtype=float)
    return {name: values[:, k] for k, name in enumerate(names)}


def compare(ours, theirs, names, path, agree=AGREE):
    assert len(ours["time"]) == len(theirs["time"])
    nominals = {v.name: float(v.nominal or 1.0) for v in read_model_description(str(path), validate=False).modelVariables}
    for name in names:
        a, b = ours[name], np.asarray(theirs[name], dtype=float)
        room = agree * np.ptp(b) + 10 * TOLERANCE * (np.max(np.abs(b)) + nominals[name])
        assert np.max(np.abs(a - b)) <= room, name


def cvode(path, stop, step, **options):
    options = {"relative_tolerance": 1e-2 * TOLERANCE, "record_events": False, **options}
    return simulate_fmu(str(path), fmi_type="ModelExchange", solver="CVode", stop_time=stop, output_interval=step, **options)


@pytest.mark.parametrize("fmi", STANDARDS)
@pytest.mark.parametrize("case", CASES)
def test_the_solver_agrees_with_cvode(program, tmp_path, case, fmi):
    model, stop, step, starts = CASES[case]
    path = paths.archive(model, fmi)
    theirs = cvode(path, stop, step, start_values=starts)
    sets = [word for name, value in starts.items() for word in ("--set", f"{name}={value}")]
    ours = run(program, path, tmp_path, stop, step, *sets)
    # Balances are differences of large numbers.
    names = [n for n in theirs.dtype.names if n != "time" and n in ours and "error" not in n and "balance" not in n]
    assert len(names) > 2
    compare(ours, theirs, names, path)


@pytest.mark.parametrize("fmi", STANDARDS)
def test_inputs_over_time_with_a_jump(program, tmp_path, fmi):
    """Co-Simulation of FMI 2 integrates linear inputs with another method."""
    rows = [(0.0, 6.0), (0.1, 12.0), (0.1, 20.0), (0.2, 20.0), (0.3, 0.0)]
    (tmp_path / "in.csv").write_text("time,voltage\n" + "".join(f"{t},{u}\n" for t, u in rows))
    given = (tmp_path, 0.3, 1e-3, "--input", tmp_path / "in.csv")
    stepped = paths.archive("AnnulusCooledMotor", 2)
    theirs = run(program, stepped, *given, interface="cs")
    ours = run(program, paths.archive("AnnulusCooledMotor", fmi), *given)
    # Where an output follows the input at once, Co-Simulation shows the value before the jump.
    keep = np.abs(ours["time"] - 0.1) > 1e-6
    ours, theirs = ({n: v[keep] for n, v in result.items()} for result in (ours, theirs))
    compare(ours, theirs, ["current", "shaft_speed", "winding_temperature"], stepped, agree=1e-4)


def test_locals_are_recorded_where_asked(program, tmp_path):
    path = paths.archive("AnnulusCooledMotor", 2)
    ours = run(program, path, tmp_path, 0.01, 0.005, "--record", "motor.R_ref", "--set", "voltage=6")
    assert np.all(ours["motor.R_ref"] > 0.0)
    bad = subprocess.run([program, "simulate", path, "--record", "motor.R_reff"], capture_output=True, text=True)
    assert bad.returncode == 2
    assert "motor.R_reff" in bad.stderr
    assert "did you mean motor.R_ref" in bad.stderr


@pytest.mark.parametrize("value", ["0", "1", "-1e-6", "nan"])
def test_a_tolerance_outside_its_limits_is_refused(program, value):
    command = [program, "simulate", paths.archive("GaitLoad", 3), "--interface", "me", f"--tolerance={value}"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert "must be above 0 and below 1" in done.stderr
