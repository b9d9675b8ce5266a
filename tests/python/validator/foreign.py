"""A small FMU that is independent of this project: an oscillator, compiled from the C source in this folder."""

import math
import platform
import subprocess
import sys
from pathlib import Path

from .archive import Files

FOLDER = Path(__file__).resolve().parent
MARK, LENGTH = b"SEEDED-FAULT-IS:", 48
#: Where reference results are, after the layered standard of that name.
EXTRA = "extra/org.fmi-standard.fmi-ls-ref"
REFERENCE = f"{EXTRA}/oscillator.csv"
MANIFEST = """<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest" fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref"
    fmi-ls:fmi-ls-version="1.0.0-alpha.1">
  <Related type="text/csv" source="inputs.csv" role="testcase" description="No force at all"/>
  <Related type="text/csv" source="oscillator.csv" role="result" description="The closed form of a damped oscillation"/>
</fmiReferences>
"""
ENDING = {"linux": "so", "darwin": "dylib"}.get(sys.platform, "dll")


def folder(fmi):
    """This machine's platform folder."""
    system = {"linux": "linux", "darwin": "darwin"}.get(sys.platform, "windows")
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    if fmi == 2 and machine == "x86_64":
        return {"windows": "win64"}.get(system, f"{system}64")
    return f"{machine}-{system}"


def closed_form(damping=0.4, stiffness=25.0, start=0.5):
    """x(t) of the unforced mass of 1 kg, as a table."""
    decay, pulsation = damping / 2, math.sqrt(stiffness - damping**2 / 4)
    lines = ["time,x"]
    for k in range(41):
        t = 0.05 * k
        x = start * math.exp(-decay * t) * (math.cos(pulsation * t) + decay / pulsation * math.sin(pulsation * t))
        lines.append(f"{t:.17g},{x:.17g}")
    return "\n".join(lines) + "\n"


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
            f"{EXTRA}/fmi-ls-manifest.xml": MANIFEST.encode(),
            f"{EXTRA}/inputs.csv": b"time,force\n0,0\n2,0\n",
            REFERENCE: closed_form().encode(),
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
