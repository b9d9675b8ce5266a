"""A thermal runaway ends the run at a limit of validity, through fmpy in both standards and both interfaces, with the reason in the log."""

import csv
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from clients import paths
from conftest import MODEL, STANDARDS
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException

KELVIN = 273.15
LIMIT = 543.15  # validity.winding_temperature, IEC 60317-3
# 25 A at standstill, without a fan: 270 degC after some minutes. Before there was a limit: 34,929 degC after half an hour.
STALLED = {"drive_mode": 3, "mechanical_mode": 2, "current_command": 25.0}
STOP = 1800.0
RECORD = ["winding_temperature", "torque_constant"]
OVERLOADED = {"BrushedGearmotor": {"duty": 1.0, "supply_voltage": 60.0, "load_torque": 5.0}, MODEL: STALLED}


def ended(result, logged):
    """The time of the end, from a result and what was logged."""
    assert result["time"][-1] < STOP - 1.0 and np.isfinite(result["winding_temperature"]).all()
    assert result["winding_temperature"].max() <= LIMIT + 1e-3
    # Model Exchange is sampled every second and warms by up to 15 K in one.
    assert result["winding_temperature"][-1] > LIMIT - 15.0
    assert (result["torque_constant"] > 0.0).all()
    (sentence,) = {line for line in logged if "validity.winding_temperature" in line}
    assert "runaway" in sentence and f"{LIMIT} K" in sentence
    return float(sentence.split(" ends at ")[1].split(" s:")[0])


@pytest.mark.parametrize("model", OVERLOADED)
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("fmi", STANDARDS, ids=lambda fmi: f"fmi{fmi}")
def test_fmpy_stops_with_the_reason(fmi, kind, model):
    # In a process of its own: fmpy keeps one FMI 2 logger for a whole process, and that of this one belongs to the clients.
    environment = {**os.environ, "PYTHONPATH": str(paths.EXAMPLES)}
    command = [sys.executable, __file__, str(paths.archive(model, fmi)), kind, json.dumps(OVERLOADED[model])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)
    assert done.returncode == 0, done.stderr[-2000:]
    answer = json.loads(done.stdout.splitlines()[-1])
    result = {name: np.array(column) for name, column in answer["result"].items()}
    time = ended(result, answer["log"])
    assert abs(result["time"][-1] - time) < 1.5, f"{result['time'][-1]} s and {time} s"


def simulated(path, kind, start):
    """A run by fmpy alone: its columns and its log."""
    logged = []
    result = simulate_fmu(
        path,
        fmi_type=kind,
        stop_time=STOP,
        output_interval=1.0,
        relative_tolerance=1e-6,
        start_values=start,
        output=RECORD,
        debug_logging=True,
        logger=lambda *arguments: logged.append(arguments[-1].decode()),
    )
    return {"result": {name: result[name].tolist() for name in result.dtype.names}, "log": logged}


def test_fmi_2_discards_the_step_and_logs_the_reason(archives):
    with archives[2].instance() as motor:
        motor.initialise(STALLED)
        slave = motor.slave
        with pytest.raises(FMICallException) as refused:
            slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=STOP)
        assert refused.value.status == 2, "fmi2Discard"
        assert slave.getBooleanStatus(3), "fmi2Terminated"
        end = slave.getRealStatus(2)
        assert 10.0 < end < STOP
        # The state of the instance is that of the last successful time.
        assert LIMIT - 1e-2 < motor.get("winding_temperature")[0] <= LIMIT
        slave.terminate()


def test_fmi_3_asks_for_the_end(archives):
    with archives[3].instance() as motor:
        motor.initialise(STALLED)
        event, terminate, early, last = motor.slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=STOP)
        assert terminate and not early and 10.0 < last < STOP
        assert LIMIT - 1e-2 < motor.get("winding_temperature")[0] <= LIMIT


def test_simulate_writes_what_there_is_and_exits_with_1(motor_fmu, tmp_path):
    sets = ("--set", "drive_mode=current", "--set", "mechanical_mode=imposed_speed", "--set", "current_command=25")
    for fmi in STANDARDS:
        command = ("simulate", paths.archive(MODEL, fmi), "--stop", STOP, "--step", "1", *sets)
        done = motor_fmu(*command, "--output", f"{fmi}.csv")
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        assert done.returncode == 1 and len(lines) == 1, done.stderr
        assert all(word in lines[0] for word in ("ends at", " s:", f"validity.winding_temperature = {LIMIT} K", "runaway"))
        with (tmp_path / f"{fmi}.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert 10 < len(rows) < STOP and float(rows[-1]["winding_temperature"]) <= LIMIT
        assert all(float(row["torque_constant"]) > 0.0 for row in rows)


if __name__ == "__main__":
    archive, interface, start_values = sys.argv[1:]
    print(json.dumps(simulated(archive, interface, json.loads(start_values))))
