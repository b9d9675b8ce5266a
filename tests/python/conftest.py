"""Fixtures: the built archives, the `motor-fmu` program, instances by name."""

import os
import shutil
import subprocess

import pytest
from clients import paths
from clients.fmu import Archive

# Files and tests that take longest, first in the run: begun last, one of them would keep one process busy alone.
# `cargo xtask test` prints the durations.
LONGEST = (
    "test_example[08_walking_study]",
    "test_example[05_thesis]",
    "test_example[07_refit_against_repair]",
    "test_close_loop_intake",
    "test_preset_library",
    "test_close_loop",
    "test_public_sets",
    "test_example[02_walking]",
    "test_blind_sets",
    "test_validator_faults",
    "test_corpus",
    "test_cosim_system",
    "test_importers",
    "test_reproduce",
    "test_bench_generator",
    "test_example[04_close_the_loop_bench]",
    "test_values_without_prior",
    "test_blind_suite",
    "test_notebooks",
    "test_default_experiment",
    "test_archives",
    "test_datasheet",
)

MODEL = "AnnulusCooledMotor"
STANDARDS = (2, 3)


# First: pytest-xdist reads the groups in the same hook.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """With several processes: the tests of a file share its fixtures, so they stay together; each example is on its own."""

    def group(item):
        file = item.path.stem
        return item.nodeid if file == "test_examples" else file

    def rank(item):
        names = [item.path.stem, item.name]
        return min((k for k, name in enumerate(LONGEST) if name in names), default=len(LONGEST))

    for item in items:
        item.add_marker(pytest.mark.xdist_group(group(item)))
    items.sort(key=rank)


@pytest.fixture(scope="session")
def archive_paths():
    """The archive of the motor for each standard."""
    return {fmi: paths.archive(MODEL, fmi) for fmi in STANDARDS}


@pytest.fixture(scope="session")
def archives(archive_paths):
    """The unzipped archives by standard."""
    opened = {fmi: Archive(path) for fmi, path in archive_paths.items()}
    yield opened
    for archive in opened.values():
        archive.__exit__()


@pytest.fixture(scope="session", params=STANDARDS, ids=lambda fmi: f"fmi{fmi}")
def archive(request, archives):
    """One unzipped archive; a test that takes it runs for both standards."""
    return archives[request.param]


@pytest.fixture
def make(archive):
    """Makes initialised instances from start values; they are freed after the test."""
    made = []

    def make(start=None, **further):
        made.append(archive.instance())
        return made[-1].initialise({**(start or {}), **further})

    yield make
    for instance in made:
        instance.close()


@pytest.fixture(scope="session")
def program():
    """The `motor-fmu` program: MOTOR_FMU_BIN, else the one on the path."""
    found = os.environ.get("MOTOR_FMU_BIN") or shutil.which("motor-fmu")
    assert found, "motor-fmu is not on the path; set MOTOR_FMU_BIN to it or run `cargo xtask test`"
    return found


@pytest.fixture
def motor_fmu(program, tmp_path):
    """Runs `motor-fmu` in a folder of the test's own and returns the finished process."""

    def run(*arguments):
        command = [program, *map(str, arguments)]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)

    return run
