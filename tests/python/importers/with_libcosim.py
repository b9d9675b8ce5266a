"""libcosim, the engine of the Open Simulation Platform, through libcosimpy. It reads FMI 2 alone."""

from pathlib import Path

from clients.fmu import Archive
from importers import Drive
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

NANOSECONDS = 1_000_000_000


def record(path: Path, drive: Drive) -> list[list[float] | None]:
    step = round(drive.step * NANOSECONDS)
    assert step == drive.step * NANOSECONDS, "libcosim counts whole nanoseconds"
    with Archive(path) as archive:
        references = {name: variable.valueReference for name, variable in archive.variables.items()}
    execution = CosimExecution.from_step_size(step)
    slave = CosimLocalSlave(str(path), "motor")
    motor = execution.add_local_slave(slave)
    observer, override = CosimObserver.create_last_value(), CosimManipulator.create_override()
    assert execution.add_observer(observer) and execution.add_manipulator(override)
    for name, value in (drive.parameters | drive.at(0)).items():
        assert execution.real_initial_value(motor, references[name], value), name

    def read():
        return observer.last_real_values(motor, [references[name] for name in drive.outputs])

    # Its observers see nothing before the first step.
    rows = [None]
    for k in range(drive.steps):
        inputs = drive.at(k)
        assert override.slave_real_values(motor, [references[name] for name in inputs], list(inputs.values()))
        assert execution.step(1), f"step {k}"
        rows.append(read())
    return rows
