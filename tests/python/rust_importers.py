"""The Rust importers of tests/importers with the drives of test_importers.py; run by `cargo xtask importers`.

Not part of the everyday tests, because two hundred crates have to be compiled.
"""

import json
import os
import re
import subprocess

import pytest
from clients import paths
from test_importers import MODELS, STEPS, drives, natively  # noqa: F401  (fixtures)

# How the program calls an importer, and the standard that it is asked for.
IMPORTERS = {"fmi": 2, "fmi-rs-2": 2, "fmi-rs-3": 3}


def run(name, archive, folder, drive=None):
    """The finished process, and the rows where there are any."""
    program = os.environ["MOTOR_FMU_RUST_IMPORTERS"]
    drive_file, rows = folder / "drive.json", folder / "rows.json"
    if drive:
        drive.write(drive_file)
    else:
        drive_file.write_text('{"step": 1, "parameters": {}, "inputs": {}, "outputs": []}')
    done = subprocess.run([program, name, archive, drive_file, rows], capture_output=True, text=True, timeout=60)
    return done, json.loads(rows.read_text()) if rows.exists() else None


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("importer", IMPORTERS)
def test_an_importer_reads_the_same_bits(importer, model, drives, natively, tmp_path):  # noqa: F811
    fmi = IMPORTERS[importer]
    done, read = run(importer, paths.archive(model, fmi), tmp_path, drives[model])
    assert done.returncode == 0, done.stderr
    native = natively(model, fmi)
    assert len(read) == len(native) == STEPS + 1
    for k, (ours, theirs) in enumerate(zip(native, read)):
        assert ours == theirs, f"point {k}"


@pytest.mark.parametrize("model", MODELS)
def test_what_the_docs_say_of_fmi_and_fmi_3(model, tmp_path):
    """docs/comparison.md states that the crate `fmi` cannot read FMI 3 archives, and why; if a later version can, this test fails."""
    done, _ = run("fmi-reads-3", paths.archive(model, 3), tmp_path)
    assert done.returncode == 1 and "UnknownField" in done.stderr
    field = re.search(r'name: "\w+", field: "\w+"', done.stderr)[0]
    assert field in (paths.ROOT / "docs" / "comparison.md").read_text()
