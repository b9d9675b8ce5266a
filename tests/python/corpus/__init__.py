"""Small FMUs that behave as the exporters of other tools do, compiled from the C source in this folder.

An FMU is named `model` or `model:quirk`; `expected.toml` says what the standard demands of it and of its importer. `build` writes the
archive. The C sources are compiled once for each model and standard; a quirk is written into the compiled library.
"""

import functools
import subprocess
import tempfile
from pathlib import Path

from validator.archive import Files
from validator.foreign import ENDING, folder

from . import describe

FOLDER = Path(__file__).resolve().parent
MARK, LENGTH = b"CORPUS-QUIRK-IS:", 48


@functools.cache
def library(model, fmi):
    """The compiled library of a model."""
    with tempfile.TemporaryDirectory(prefix="corpus-") as out:
        binary = Path(out) / f"{model}.{ENDING}"
        source = ["-DMODEL=" + f'"{model}.h"', str(FOLDER / f"fmi{fmi}.c"), "-lm"]
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-w", "-o", str(binary), *source], check=True)
        return binary.read_bytes()


def seeded(content, quirk):
    """The library with its quirk switched on."""
    at = content.index(MARK)
    text = (MARK + quirk.encode()).ljust(LENGTH, b"\0")
    assert len(text) == LENGTH
    return content[:at] + text + content[at + LENGTH :]


def build(name, fmi, path, encoding="UTF-8", only=(), count=0):
    """Writes one FMU of the corpus: `model` or `model:quirk`, with all interfaces or `only` some; lag:many has `count` further variables."""
    model, _, quirk = name.partition(":")
    quirk = quirk or "none"
    seed = f"many-{count}" if quirk == "many" else quirk
    files = {
        "modelDescription.xml": describe.xml(model, fmi, quirk, encoding, only, count).encode(encoding),
        f"binaries/{folder(fmi)}/{model}.{ENDING}": seeded(library(model, fmi), seed),
        "documentation/index.html": b"<!DOCTYPE html><title>Corpus</title><p>A small model that tests importers.</p>",
        "documentation/licenses/license.txt": b"Public domain.",
    }
    return Files(files).write(path)
