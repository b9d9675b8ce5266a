"""libcosim opens the SSP files of this project and gives the same bits as the native master with the same algorithm.

libcosim reads outputs once after each step and keeps inputs constant: `--algorithm jacobi-delayed --no-input-derivatives`. It counts whole
nanoseconds, so the step is a power of two that is a whole number of nanoseconds.
"""

import csv
import json
import os
import re
import subprocess
import sys

from clients import paths
import pytest
from requirements import where_demanded
from timing import processor_time

STEP_NS, STEPS = 1_953_125, 512
READ = (
    ("gait", "joint_angle"),
    ("gait", "joint_speed"),
    ("motor", "shaft_angle"),
    ("motor", "shaft_speed"),
    ("motor", "current"),
    ("motor", "winding_temperature"),
    ("actuator", "energy_joint"),
)


@where_demanded("libcosimpy")
@pytest.mark.parametrize("parameter", ["", '\n[[parameter]]\nname = "fan"\nvalue = 0.5\nset = ["motor.fan_command"]\n'])
def test_the_same_bits(motor_fmu, tmp_path, parameter):
    """A parameter of the system is in files that libcosim does not read, and at the component."""
    text = re.sub(r'"\.\./\.\./dist/', f'"{paths.dist()}/', (paths.EXAMPLES / "systems" / "actuator-gait.toml").read_text())
    (tmp_path / "walk.toml").write_text(text + parameter)
    made = motor_fmu("ssp", "walk.toml")
    assert made.returncode == 0, made.stderr
    step = STEP_NS * 1e-9
    times = ("--stop", repr(STEPS * step), "--step", repr(step))
    done = motor_fmu("cosim", "walk.ssp", *times, "--algorithm", "jacobi-delayed", "--no-input-derivatives", "--output", "ours.csv")
    assert done.returncode == 0, done.stderr
    with (tmp_path / "ours.csv").open(newline="") as file:
        ours = [[float(row[f"{component}.{name}"]) for component, name in READ] for row in csv.DictReader(file)]

    theirs = tmp_path / "theirs.json"
    environment = {**os.environ, "PYTHONPATH": str(paths.EXAMPLES)}
    command = [sys.executable, __file__, str(tmp_path / "walk.ssp"), str(theirs)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(theirs.read_text())
    assert len(found) == STEPS and len(ours) == STEPS + 1
    for k, (a, b) in enumerate(zip(found, ours[1:])):
        assert a == b, f"step {k}"
    # Something happened.
    assert max(abs(row[3]) for row in ours) > 100.0


@pytest.mark.nightly
@where_demanded("libcosimpy")
def test_a_minute_of_walking_takes_no_longer(motor_fmu, program, tmp_path):
    text = re.sub(r'"\.\./\.\./dist/', f'"{paths.dist()}/', (paths.EXAMPLES / "systems" / "actuator-gait.toml").read_text())
    (tmp_path / "walk.toml").write_text(text)
    assert motor_fmu("ssp", "walk.toml").returncode == 0
    environment = {**os.environ, "PYTHONPATH": str(paths.EXAMPLES)}
    steps, ssp = 60 * 512, str(tmp_path / "walk.ssp")
    options = ("--algorithm", "jacobi-delayed", "--no-input-derivatives", "--stop", "60", "--step", repr(STEP_NS * 1e-9))
    theirs = [sys.executable, __file__, ssp, str(tmp_path / "rows.json"), str(steps)]
    assert processor_time([program, "cosim", ssp, *options], environment) < processor_time(theirs, environment)


def record(ssp, steps=STEPS, read_each=True):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_ssp_file(ssp, STEP_NS)
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    index, reference = {}, {}
    for info in execution.slave_infos():
        component = info.name.decode()
        index[component] = info.index
        for variable in execution.slave_variables(info.index):
            reference[component, variable.name.decode()] = variable.reference
    read = lambda component, name: observer.last_real_values(index[component], [reference[component, name]])[0]
    rows = []
    for _ in range(steps if read_each else 1):
        assert execution.step(1 if read_each else steps)
        rows.append([read(*which) for which in READ])
    return rows


if __name__ == "__main__":
    with open(sys.argv[2], "w") as out:
        json.dump(record(sys.argv[1], *([int(sys.argv[3]), False] if len(sys.argv) > 3 else [])), out)
