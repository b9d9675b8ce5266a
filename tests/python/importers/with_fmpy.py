"""fmpy, through its two classes for Co-Simulation."""

from pathlib import Path

from clients.fmu import Archive
from importers import Drive


def record(path: Path, drive: Drive) -> list[list[float]]:
    with Archive(path) as archive, archive.instance() as fmu:
        fmu.initialise({**drive.parameters, **drive.at(0)})
        rows = [fmu.get(*drive.outputs)]
        for k in range(drive.steps):
            fmu.set(drive.at(k))
            fmu.step(drive.step, point=k * drive.step)
            rows.append(fmu.get(*drive.outputs))
    return rows
