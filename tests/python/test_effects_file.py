"""Generic terms as data: `motor-fmu build --effects FILE`, and the FMU with this file."""

import json
import subprocess
import zipfile

import pytest
from clients.fmu import Archive, FmuError
from conftest import MODEL, STANDARDS
from test_cli_bad_input import CANNOT, one_sentence

# A drag of 6 mN.m at 500 rad/s, and 2 W of heat in the winding at 300 K that are gone at 320 K.
TERMS = [
    {
        "name": "seal",
        "port": "drag_torque",
        "coefficient": 6e-3,
        "unit": "N.m",
        "drivers": [{"driver": "speed", "reference": 500.0, "exponent": 0.5}],
    },
    {"name": "stray", "port": "winding_heat", "table": {"driver": "winding_temperature", "x": [300.0, 320.0], "y": [2.0, 0.0]}},
]
SEEN = ("loss_friction", "winding_temperature", "power_balance_error")


def text(terms=TERMS):
    return json.dumps({"format": "motor-fmu effects 1", "terms": terms})


@pytest.fixture
def effects(tmp_path):
    """Writes a file of terms."""

    def write(content):
        file = tmp_path / "found.json"
        file.write_text(content)
        return file

    return write


@pytest.fixture(scope="module")
def built(program, tmp_path_factory):
    """Archives with the terms, by standard."""
    folder = tmp_path_factory.mktemp("terms")
    file, out = folder / "found.json", folder / "dist"
    file.write_text(text())
    command = [program, "build", MODEL, "--effects", file, "--out", out]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return {fmi: out / f"fmi{fmi}" / f"{MODEL}.fmu" for fmi in STANDARDS}


def rewritten(path, content, target):
    """A copy of an archive with other terms in it."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(target, "w") as copy:
        for name in source.namelist():
            copy.writestr(name, content if name == "resources/effects.json" else source.read(name))
    return target


def run(path, **start):
    """Outputs after a millisecond at 500 rad/s and 4 A, from 300 K."""
    modes = {"drive_mode": "current", "mechanical_mode": "imposed_speed"}
    inputs = {"current_command": 4.0, "imposed_speed": 500.0, "ambient_temperature": 300.0}
    with Archive(path) as archive, archive.instance() as motor:
        motor.initialise({**modes, **inputs, **start})
        motor.step(1e-3)
        return dict(zip(SEEN, motor.get(*SEEN)))


@pytest.mark.parametrize("fmi", STANDARDS)
def test_terms_act_and_can_be_switched_off(built, fmi):
    on, off = run(built[fmi]), run(built[fmi], **{"effect.generic_term.gain": 0.0})
    assert on["loss_friction"] == pytest.approx(6e-3 * 500.0, abs=1e-12)
    assert off["loss_friction"] == 0.0
    # 2 W on the winding's 10.05 J/K, for a millisecond.
    assert on["winding_temperature"] - off["winding_temperature"] == pytest.approx(2.0 / 10.05 * 1e-3, rel=1e-3)
    assert abs(on["power_balance_error"]) < 1e-6


def test_both_standards_agree(built):
    assert run(built[2]) == run(built[3])


def test_archives_are_valid_and_hold_the_file(motor_fmu, built):
    assert motor_fmu("validate", *built.values()).returncode == 0
    for path in built.values():
        with zipfile.ZipFile(path) as archive:
            assert json.loads(archive.read("resources/effects.json"))["terms"][0]["name"] == "seal"


@pytest.mark.parametrize("fmi", STANDARDS)
def test_an_archive_with_a_broken_file_is_refused(built, fmi, tmp_path):
    bad = text([{**TERMS[0], "coefficient": 1e12}])
    with Archive(rewritten(built[fmi], bad, tmp_path / "broken.fmu")) as archive:
        with pytest.raises(FmuError) as refused:
            archive.instance()
        assert len(refused.value.lines) == 1, refused.value.lines
        for word in ("effects.json", '"seal"', "coefficient = 1000000000000", "-1000000 ... 1000000"):
            assert word in refused.value.lines[0].text


@pytest.mark.parametrize(
    "content, words",
    [
        (text([{**TERMS[0], "port": "gearbox"}]), ['"seal"', 'port = "gearbox"', "drag_torque"]),
        (text([{**TERMS[0], "unit": "W"}]), ['"seal"', 'unit = "W"', '"N.m"']),
        (text().replace("}", "", 1), ["found.json:1:"]),
        (text(TERMS * 2), ["4 terms", "the limit is 3"]),
    ],
)
def test_a_broken_file_is_not_packed(motor_fmu, effects, tmp_path, content, words):
    done = motor_fmu("build", MODEL, "--effects", effects(content), "--out", tmp_path / "dist")
    one_sentence(done, CANNOT, "found.json", *words)
    assert not (tmp_path / "dist").exists()


def test_a_missing_file_is_named(motor_fmu, tmp_path):
    one_sentence(motor_fmu("build", "--effects", tmp_path / "none.json"), CANNOT, "none.json")
