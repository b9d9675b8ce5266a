"""The archives in importers of other projects: the same bits as `motor-fmu simulate`.

Values are compared, not exit codes: an importer that ignores errors continues with zeros. The step is a power of two, because some
importers add steps up and some count nanoseconds; all times are then the same.
"""

import csv
import json
import math
import os
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from clients import paths
from clients.fmu import Archive
from conftest import STANDARDS
from requirements import DEMANDED, is_demanded
from importers import Drive

STEP, STEPS = 2.0**-9, 256

# Parameters of each model, then inputs as functions of the number of the communication point.
DRIVES = {
    "AnnulusCooledMotor": (
        {"effect.viscous_friction.k": 2e-6, "motor.R_ref": 0.4},
        {
            "voltage": lambda k: 24.0 * math.sin(0.05 * k),
            "load_torque": lambda k: 0.02 if k < STEPS // 2 else 0.1,
            "fan_command": lambda k: k / STEPS,
            "ambient_temperature": lambda k: 295.15 + 0.01 * k,
        },
    ),
    "BrushedGearmotor": (
        {"motor.L": 2.5e-3},
        {
            "duty": lambda k: 0.9 * math.sin(0.03 * k),
            "supply_voltage": lambda k: 12.0 - 0.005 * k,
            "load_torque": lambda k: 0.1 if k < STEPS // 2 else 0.4,
            "ambient_temperature": lambda k: 293.15,
        },
    ),
    "SeriesElasticActuator": (
        {"spring.stiffness": 300.0, "transmission.backlash": 0.002},
        {
            "motor_angle": lambda k: 40.0 * math.sin(0.02 * k),
            "motor_speed": lambda k: 40.0 * 0.02 / STEP * math.cos(0.02 * k),
            "motor_current": lambda k: 3.0 * math.cos(0.03 * k),
            "joint_angle": lambda k: 0.1 * math.sin(0.01 * k),
            "joint_speed": lambda k: 0.1 * 0.01 / STEP * math.cos(0.01 * k),
            "torque_demand": lambda k: 20.0 if k < STEPS // 2 else -30.0,
            "supply_voltage": lambda k: 48.0 - 0.01 * k,
        },
    ),
    "GaitLoad": ({"gait.variation": 0.03, "gait.body_mass": 82.0}, {"joint_torque": lambda k: 0.5 * k}),
}

# A varying output of each.
MOVES = {
    "AnnulusCooledMotor": "shaft_speed",
    "BrushedGearmotor": "shaft_speed",
    "SeriesElasticActuator": "joint_torque",
    "GaitLoad": "torque_demand",
}

# Which importers take which standard, and the package of each; docs/comparison.md says why a standard is missing.
ALL = {
    "fmpy": ((2, 3), "fmpy"),
    "ecos": ((2, 3), "ecospy"),
    "libcosim": ((2,), "libcosimpy"),
    "container": ((2, 3), "fmu-manipulation-toolbox"),
}
# Two of them have packages for some machines and Pythons alone. Where requirements.txt demands one that is missing, its tests fail.
IMPORTERS = {name: standards for name, (standards, package) in ALL.items() if is_demanded(package)}
# Points at the start of a run without outputs from an importer.
BLIND_POINTS = {"libcosim": 1}
MODELS = sorted(path.stem for path in (paths.dist() / "fmi2").glob("*.fmu"))


def test_there_is_an_archive_of_each_model_for_each_standard():
    assert MODELS == sorted(DRIVES), "every model needs an entry in DRIVES"
    assert MODELS == sorted(path.stem for path in (paths.dist() / "fmi3").glob("*.fmu"))


def test_all_importers_are_tested_where_they_have_packages():
    if sys.platform == "linux" and platform.machine() == "x86_64" and (3, 11) <= sys.version_info[:2] < (3, 15):
        assert set(IMPORTERS) == set(ALL)
    else:
        assert set(IMPORTERS) >= {"fmpy", "container"}


@pytest.mark.parametrize("package", sorted(DEMANDED))
def test_demanded_packages_are_installed(package):
    assert version(package)


@pytest.fixture(scope="session")
def drives():
    """A drive by model. The outputs are those that are real, in the order of the FMI 2 archive."""

    def drive(model):
        parameters, inputs = DRIVES[model]
        with Archive(paths.archive(model, 2)) as archive:
            outputs = [v.name for v in archive.variables.values() if v.causality == "output" and v.type == "Real"]
        return Drive(STEP, parameters, {name: [f(k) for k in range(STEPS)] for name, f in inputs.items()}, outputs)

    return {model: drive(model) for model in DRIVES}


@pytest.fixture(scope="session")
def natively(drives, program, tmp_path_factory):
    """Outputs of the native master by model and standard; each is run once."""
    folder, known = tmp_path_factory.mktemp("natively"), {}

    def rows(model, fmi):
        if (model, fmi) not in known:
            known[model, fmi] = simulate(program, paths.archive(model, fmi), drives[model], folder)
        return known[model, fmi]

    return rows


def simulate(program, archive, drive, folder):
    table, out = folder / "inputs.csv", folder / f"{archive.stem}.csv"
    with table.open("w", newline="") as text:
        writer = csv.writer(text)
        writer.writerow(["time", *drive.inputs])
        writer.writerows([repr(k * drive.step), *map(repr, drive.at(k).values())] for k in range(drive.steps))
    settings = [item for name, value in drive.parameters.items() for item in ("--set", f"{name}={value!r}")]
    stop = drive.step * drive.steps
    command = [program, "simulate", archive, "--stop", repr(stop), "--step", repr(drive.step), "--no-input-derivatives", "--input", table]
    subprocess.run([*map(str, command), *settings, "--output", str(out)], check=True, capture_output=True, timeout=60)
    with out.open(newline="") as text:
        return [[float(row[name]) for name in drive.outputs] for row in csv.DictReader(text)]


def run(importer, archive, drive, folder):
    """Runs an importer in its own process; its standard error explains a failure."""
    drive_file, rows = folder / "drive.json", folder / "rows.json"
    drive.write(drive_file)
    environment = {**os.environ, "PYTHONPATH": str(paths.EXAMPLES)}
    command = [sys.executable, "-m", "importers", importer, archive, drive_file, rows]
    command = [*map(str, command)]
    done = subprocess.run(command, cwd=Path(__file__).parent, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, f"{importer} ended with {done.returncode}: {done.stderr[-2000:]}"
    return json.loads(rows.read_text())


@pytest.mark.nightly
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(("importer", "fmi"), [(name, fmi) for name, takes in IMPORTERS.items() for fmi in takes])
def test_an_importer_reads_the_same_bits(importer, fmi, model, drives, natively, tmp_path):
    drive, native = drives[model], natively(model, fmi)
    read = run(importer, paths.archive(model, fmi), drive, tmp_path)
    assert len(native) == len(read) == STEPS + 1
    blind = BLIND_POINTS.get(importer, 0)
    assert [row is None for row in read] == [k < blind for k in range(STEPS + 1)]
    for k, (ours, theirs) in enumerate(zip(native[blind:], read[blind:]), blind):
        differing = {name: (a, b) for name, a, b in zip(drive.outputs, ours, theirs) if a != b}
        assert not differing, f"point {k}: {differing}"
    # Constant outputs would agree trivially.
    assert max(abs(row[drive.outputs.index(MOVES[model])]) for row in read[blind:]) > 0.3


@pytest.mark.parametrize("model", MODELS)
def test_both_standards_hear_the_drive_alike(model, natively):
    assert natively(model, 2) == natively(model, 3)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("fmi", STANDARDS)
def test_fmutool_finds_nothing(fmi, model):
    """Schema and semantics by fmu-manipulation-toolbox; its exit code is always 0."""
    program = Path(sys.executable).with_name("fmutool")
    command = [program, "-input", paths.archive(model, fmi), "-check"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    said = done.stdout + done.stderr
    assert f"compliant with FMI-{fmi}.0" in said and "No semantic error" in said, said
    assert "ERROR" not in said and "WARNING" not in said, said
