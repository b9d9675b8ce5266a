"""The token (GUID) of an archive: it differs with the contents, and the FMU refuses files that do not belong together."""

import json
import subprocess
import zipfile

import pytest
from clients.fmu import Archive, FmuError
from conftest import MODEL, STANDARDS

PRESETS = ("maxon-305015", "maxon-re40-148877")
EFFECTS = {"format": "motor-fmu effects 1", "terms": [{"port": "drag_torque", "coefficient": 6e-3}]}


@pytest.fixture(scope="module")
def built(program, tmp_path_factory):
    """Archives of two presets, and of the first one with terms, by name and standard."""
    folder = tmp_path_factory.mktemp("tokens")
    effects = folder / "effects.json"
    effects.write_text(json.dumps(EFFECTS))
    variants = {name: ["--preset", name] for name in PRESETS}
    variants["terms"] = [*variants[PRESETS[0]], "--effects", effects]
    for name, options in variants.items():
        command = [program, "build", MODEL, *options, "--out", folder / name]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stdout + done.stderr
    return {name: {fmi: folder / name / f"fmi{fmi}" / f"{MODEL}.fmu" for fmi in STANDARDS} for name in variants}


def mixed(path, other, target, names):
    """A copy of an archive with the files `names` of another; a file that the other does not have is left out."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(other) as donor, zipfile.ZipFile(target, "w") as copy:
        for name in source.namelist():
            if not name.startswith(names):
                copy.writestr(name, source.read(name))
        for name in donor.namelist():
            if name.startswith(names):
                copy.writestr(name, donor.read(name))
    return target


def reason(path):
    with pytest.raises(FmuError) as error, Archive(path) as archive, archive.instance():
        pass
    return str(error.value)


def test_tokens_differ_with_the_contents_and_agree_between_the_standards(built):
    tokens = {}
    for name, paths in built.items():
        own = set()
        for path in paths.values():
            with Archive(path) as archive:
                own.add(archive.description.guid)
        assert len(own) == 1
        tokens[name] = own.pop()
    assert len(set(tokens.values())) == len(tokens)
    # The first 64 bits select the model.
    assert len({token[:20] for token in tokens.values()}) == 1


@pytest.mark.parametrize("fmi", STANDARDS)
def test_files_of_different_archives_are_refused(built, tmp_path, fmi):
    first, second = (built[name][fmi] for name in PRESETS)
    text = reason(mixed(first, second, tmp_path / "xml.fmu", "modelDescription.xml"))
    assert "other start values than those in this library" in text
    text = reason(mixed(built["terms"][fmi], first, tmp_path / "terms.fmu", "resources/"))
    assert "resources/effects.json" in text
    # Terms may be added without a compiler.
    with Archive(mixed(first, built["terms"][fmi], tmp_path / "added.fmu", "resources/")) as archive, archive.instance() as motor:
        motor.initialise({})
