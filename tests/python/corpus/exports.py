"""Exports of pythonfmu and pythonfmu3, and how a program without Python runs them."""

import subprocess
import sys
import sysconfig
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
#: Exporter, its script in this folder.
EXPORTERS = {"pythonfmu": "integrator2.py", "pythonfmu3": "integrator3.py"}


def build(exporter, out):
    """The FMU that the exporter makes of its script."""
    command = [sys.executable, "-m", exporter, "build", "-f", str(FOLDER / EXPORTERS[exporter]), "-d", str(out)]
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=60)
    (made,) = Path(out).glob("*.fmu")
    return made


def with_python():
    """The environment in which a program that is not Python loads such an FMU: its library expects that the interpreter's functions are
    there already. Empty where Python has no shared library."""
    shared = Path(sysconfig.get_config_var("LIBDIR") or "", sysconfig.get_config_var("INSTSONAME") or "")
    if ".so" not in shared.name or not shared.is_file():
        return {}
    return {"LD_PRELOAD": str(shared), "PYTHONHOME": sys.base_prefix}
