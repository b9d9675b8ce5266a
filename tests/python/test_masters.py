"""The powered ankle with masters of other projects.

The plain master of `examples/09_plain_master.py` gives the same bits as the native one, and so does ecos with the SSP file. ecos sets the
parameter sets of one name only; those of all components have the same name.
"""

import csv
import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from clients import paths
from requirements import where_demanded
from timing import processor_time

STEP, STEPS = 2.0**-10, 512
READ = ("gait.joint_angle", "motor.shaft_speed", "motor.current", "actuator.energy_joint", "motor.winding_temperature")


@pytest.fixture
def system(tmp_path):
    file = tmp_path / "ankle.toml"
    text = (paths.EXAMPLES / "systems" / "actuator-gait.toml").read_text()
    file.write_text(text.replace("../../dist", paths.dist().resolve().as_posix()))
    return file


@pytest.fixture
def with_parameter(system):
    """The fan command is a parameter of the system, in files of the archive that ecos does not read."""
    text = system.read_text().replace("[component.set]\nfan_command = 1.0\n", "")
    assert "fan_command" not in text
    file = system.with_name("parameter.toml")
    file.write_text(text + '\n[[parameter]]\nname = "fan"\nvalue = 1.0\nset = ["motor.fan_command"]\n')
    return file


@pytest.fixture
def ours(motor_fmu, system, tmp_path):
    out = tmp_path / "ours.csv"
    options = ("--algorithm", "jacobi-delayed", "--no-input-derivatives", "--stop", repr(STEP * STEPS), "--step", repr(STEP))
    done = motor_fmu("cosim", system, *options, "--output", out)
    assert done.returncode == 0, done.stderr
    with out.open(newline="") as file:
        return [[float(row[name]) for name in READ] for row in csv.DictReader(file)]


def test_the_plain_master_gives_the_same_bits(ours):
    spec = importlib.util.spec_from_file_location("plain_master", paths.EXAMPLES / "09_plain_master.py")
    plain = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(plain)
    rows = plain.run(stop=STEP * STEPS, step=STEP, record=READ)
    assert len(rows) == len(ours) == STEPS + 1
    for k, (a, b) in enumerate(zip(rows, ours)):
        assert a == b, f"point {k}"
    assert max(abs(row[1]) for row in rows) > 100.0


@where_demanded("ecospy")
@pytest.mark.parametrize("has_outputs", [False, True])
def test_ecos_opens_the_archive_and_agrees(ours, with_parameter, motor_fmu, tmp_path, has_outputs):
    """ecos refuses every connection without a component at both ends: with `--components-only` there is none."""
    written = ("ssp", with_parameter, "--out", tmp_path / "ankle.ssp")
    if has_outputs:
        text = with_parameter.read_text().replace("connect = [", 'connect = [\n  "actuator.joint_torque -> torque", "load -> motor.heat_power",')
        with_parameter.write_text(text)
        done = motor_fmu(*written)
        assert "ecos" in done.stderr and "--components-only" in done.stderr, done.stderr
        written = (*written, "--components-only")
    done = motor_fmu(*written)
    assert done.returncode == 0 and "ecos" not in done.stderr, done.stderr
    theirs = tmp_path / "theirs.json"
    command = [sys.executable, __file__, str(tmp_path / "ankle.ssp"), str(theirs)]
    environment = {**os.environ, "PYTHONPATH": str(paths.EXAMPLES)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)
    assert done.returncode == 0, done.stderr[-2000:]
    rows = json.loads(theirs.read_text())
    assert len(rows) == len(ours)
    for name, theirs_, ours_ in zip(READ, zip(*rows), zip(*ours)):
        assert theirs_ == ours_, name


@pytest.mark.nightly
@where_demanded("ecospy")
def test_a_minute_of_walking_takes_no_longer_than_in_ecos(system, program, tmp_path):
    subprocess.run([program, "ssp", system, "--out", tmp_path / "ankle.ssp"], check=True, capture_output=True)
    environment = {**os.environ, "PYTHONPATH": str(paths.EXAMPLES)}
    options = ("--algorithm", "jacobi-delayed", "--no-input-derivatives", "--stop", "60", "--step", repr(STEP))
    ours = [program, "cosim", tmp_path / "ankle.ssp", *options]
    theirs = [sys.executable, __file__, str(tmp_path / "ankle.ssp"), str(tmp_path / "rows.json"), str(round(60 / STEP))]
    assert processor_time(ours, environment) < processor_time(theirs, environment)


def record(ssp, steps=STEPS, read_each=True):
    """The run by ecos."""
    import ctypes

    ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=ssp, step_size=STEP) as simulation:
        assert simulation.init(parameter_set="initialValues"), "ecos could not initialise the system"
        read = lambda: [simulation.get_real(name.replace(".", "::")) for name in READ]  # noqa: E731
        if not read_each:
            simulation.step(steps)
            return [read()]
        rows = [read()]
        for _ in range(steps):
            simulation.step()
            rows.append(read())
    return rows


if __name__ == "__main__":
    further = (int(sys.argv[3]), False) if len(sys.argv) > 3 else ()
    Path(sys.argv[2]).write_text(json.dumps(record(sys.argv[1], *further)))
