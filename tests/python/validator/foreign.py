"""A small FMU that has nothing to do with this project: an oscillator, compiled from the C source in this folder."""

import platform
import subprocess
import sys
from pathlib import Path

from .archive import Files

FOLDER = Path(__file__).resolve().parent
MARK, LENGTH = b"SEEDED-FAULT-IS:", 48
ENDING = {"linux": "so", "darwin": "dylib"}.get(sys.platform, "dll")


def folder(fmi):
    """This machine's platform folder."""
    system = {"linux": "linux", "darwin": "darwin"}.get(sys.platform, "windows")
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    if fmi == 2 and machine == "x86_64":
        return {"windows": "win64"}.get(system, f"{system}64")
    return f"{machine}-{system}"


def build(fmi, out):
    """The FMU without a fault."""
    binary = Path(out) / f"oscillator-{fmi}.{ENDING}"
    command = ["cc", "-shared", "-fPIC", "-O1", "-w", "-o", str(binary), str(FOLDER / f"fmi{fmi}.c"), "-lm"]
    subprocess.run(command, check=True)
    return Files(
        {
            "modelDescription.xml": (FOLDER / f"fmi{fmi}.xml").read_bytes(),
            f"binaries/{folder(fmi)}/oscillator.{ENDING}": binary.read_bytes(),
            "documentation/index.html": b"<!DOCTYPE html><title>Oscillator</title><p>A mass on a spring with a damper.</p>",
            "documentation/licenses/license.txt": b"Public domain.",
        }
    )


def seed(files, fault):
    """The same with a fault of the C source switched on."""
    files = files.copy()
    for name, content in files.entries.items():
        if MARK in content:
            at = content.index(MARK)
            text = (MARK + fault.encode()).ljust(LENGTH, b"\0")
            assert len(text) == LENGTH
            files.entries[name] = content[:at] + text + content[at + LENGTH :]
            return files
    raise AssertionError("no library with a mark")
