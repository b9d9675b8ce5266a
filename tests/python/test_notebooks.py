"""The notebooks of examples/notebooks: each is valid and its code runs from top to bottom, in one namespace and an empty folder."""

import os
import subprocess
import sys

import nbformat
import pytest
from clients.paths import EXAMPLES

NOTEBOOKS = sorted((EXAMPLES / "notebooks").glob("*.ipynb"))
# Searches of some seconds each.
NIGHTLY = ("calibrate", "size_an_actuator")


def marked(path):
    return pytest.param(path, id=path.stem, marks=pytest.mark.nightly if path.stem in NIGHTLY else ())


@pytest.mark.parametrize("path", map(marked, NOTEBOOKS))
def test_notebook(path, program, tmp_path):
    notebook = nbformat.reads(path.read_text(encoding="utf-8"), as_version=4)
    nbformat.validate(notebook)
    cells = [cell.source for cell in notebook.cells if cell.cell_type == "code"]
    assert len(cells) >= 3 and all(not cell.get("outputs") for cell in notebook.cells), "stored without outputs"
    # The repository's folders around an empty folder of the notebook.
    folder = tmp_path / "examples" / "notebooks"
    folder.mkdir(parents=True)
    (folder.parent / "clients").symlink_to(EXAMPLES / "clients")
    (tmp_path / "tests").symlink_to(EXAMPLES.parent / "tests")
    environment = {**os.environ, "MOTOR_FMU_BIN": program}
    done = subprocess.run([sys.executable, "-c", "\n".join(cells)], cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
