"""A container FMU by fmu-manipulation-toolbox around one of the FMUs, run by fmpy."""

import subprocess
import sys
import tempfile
from pathlib import Path

from clients.fmu import Archive
from importers import Drive, with_fmpy


def record(path: Path, drive: Drive) -> list[list[float]]:
    with tempfile.TemporaryDirectory(prefix="container-") as folder:
        container = pack(path, Path(folder), drive.step, drive.outputs)
        # What is inside keeps its names as inputs and outputs; its parameters get the name of their FMU in front.
        parameters = {f"{path.stem.lower()}.{name}": value for name, value in drive.parameters.items()}
        return with_fmpy.record(container, Drive(drive.step, parameters, drive.inputs, drive.outputs))


def pack(path: Path, folder: Path, step: float, outputs: list[str]) -> Path:
    """The container with one FMU of the same standard. It does not support arrays with a structural size, so the outputs are listed."""
    with Archive(path) as archive:
        version = archive.version[0]
    shown = "".join(f"OUTPUT;{path.name};{name};;{name}\n" for name in outputs)
    (folder / "motor.csv").write_text(f"rule;from_fmu;from_port;to_fmu;to_port\nFMU;{path.name};;;\n{shown}")
    (folder / path.name).write_bytes(path.read_bytes())
    program = Path(sys.executable).with_name("fmucontainer")
    what = ["-container", f"motor.csv:{step!r}", "-fmi", version, "-auto-parameter", "-no-auto-output"]
    command = [program, "-fmu-directory", folder, *what]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True, timeout=120)
    return folder / "motor.fmu"
