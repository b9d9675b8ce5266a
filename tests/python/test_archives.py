"""Both archives are valid and give the same results, bit for bit, also with the native master."""

import csv

import numpy as np
import pytest
from clients import paths
from clients.fmu import Archive
from conftest import MODEL, STANDARDS
from exchanged import width
from fmpy.validation import validate_fmu

STEP, STEPS = 1e-3, 500
START = {"voltage": 36.0, "load_torque": 0.08, "fan_command": 0.5, "effect.coulomb_friction.tau_c": 9.83e-3}


@pytest.mark.parametrize("fmi", STANDARDS)
def test_fmpy_finds_nothing(archive_paths, fmi):
    assert validate_fmu(str(archive_paths[fmi])) == []


@pytest.fixture(scope="module")
def outputs(archives):
    """Names of the continuous outputs, in the order of the FMI 2 file."""
    return [v.name for v in archives[2].variables.values() if v.causality == "output" and v.type == "Real"]


def record(archive, outputs):
    with archive.instance() as fmu:
        fmu.initialise(START)
        rows = [fmu.get(*outputs)]
        for k in range(STEPS):
            fmu.step(STEP, point=k * STEP)
            rows.append(fmu.get(*outputs))
    return np.array(rows)


def element_names(variables):
    for variable in variables:
        array = variable.derivative if variable.derivative is not None else variable
        for k in range(width(variable)):
            name = f"{array.name}[{k + 1}]" if variable.dimensions else array.name
            yield f"der({name})" if variable.derivative is not None else name


def test_both_standards_have_the_same_variables(archives):
    """Where FMI 3 has an array, FMI 2 has its elements."""
    two = set(archives[2].variables)
    three = set(element_names(archives[3].variables.values()))
    assert two - three == set()
    assert three - two <= {"time"}


def test_both_standards_agree_bit_for_bit(archives, outputs):
    two, three = (record(archives[fmi], outputs) for fmi in STANDARDS)
    assert two.tobytes() == three.tobytes()
    assert two[-1, outputs.index("shaft_speed")] > 100.0


@pytest.mark.parametrize("fmi", STANDARDS)
def test_the_native_master_agrees_bit_for_bit(archives, archive_paths, outputs, motor_fmu, tmp_path, fmi):
    settings = [item for name, value in START.items() for item in ("--set", f"{name}={value!r}")]
    file = tmp_path / "native.csv"
    done = motor_fmu("simulate", archive_paths[fmi], "--stop", STEP * STEPS, "--step", STEP, *settings, "--output", file)
    assert done.returncode == 0, done.stderr
    with file.open(newline="") as text:
        rows = list(csv.DictReader(text))
    assert len(rows) == STEPS + 1
    native = np.array([[float(row[name]) for name in outputs] for row in rows])
    ours = record(archives[fmi], outputs)
    assert native.tobytes() == ours.tobytes()


def test_the_binary_starts_at_what_its_description_says(archive):
    """Without any set call: the values of a preset are in the library, too."""
    with archive.instance() as fmu:
        fmu.initialise()
        started = [v for v in archive.variables.values() if v.causality in ("parameter", "input")]
        assert {v.name: fmu.get(v.name)[0] for v in started} == {v.name: float(v.start) for v in started}


@pytest.mark.parametrize("fmi", STANDARDS, ids=lambda fmi: f"fmi{fmi}")
def test_a_preset_adds_its_values_and_nothing_else(archives, fmi):
    """dist/ holds the default start values; the motor that walks has those of its preset, in the library too. Each has the voltage of its
    own default experiment."""
    start = {name: float(v.start) for name, v in archives[fmi].variables.items() if v.causality in ("parameter", "input")}
    assert start["effect.coulomb_friction.tau_c"] == 0.0 and start["conductance.G_forced"] == 0.113
    with Archive(paths.archive(MODEL, fmi, "maxon-305015")) as walking, walking.instance() as motor:
        motor.initialise()
        differ = {name: motor.get(name)[0] for name, value in start.items() if motor.get(name)[0] != value}
    assert differ.pop("voltage") < start["voltage"]
    assert differ == {"effect.coulomb_friction.tau_c": 9.83e-3}


def test_archives_are_reproducible(motor_fmu, tmp_path):
    """Every archive of another build has the same bytes."""
    done = motor_fmu("build", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    again = sorted(tmp_path.glob("fmi?/*.fmu"))
    assert len(again) >= 8
    for path in again:
        assert path.read_bytes() == (paths.dist() / path.relative_to(tmp_path)).read_bytes(), path.name
