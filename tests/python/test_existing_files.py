"""An existing file is overwritten if it is an earlier result of the same command, or with --force; any other file is refused."""

import pytest
from test_cli_bad_input import CANNOT, one_sentence

NOTES = "my notes, of a day's work\n"
STEADY = ("steady", "--load", "walk.toml", "--hours", "0.05", "--plot", "f.svg")
SWEEP = ("sweep", "--vary", "fan_command=0:1:2", "--output", "o.csv", "--plot", "f.svg")
LOAD = '[motor]\ndrive_mode = "current"\n[gait]\n"gait.support" = 0.3\n'


def commands(fmu):
    simulate = ("simulate", fmu, "--stop", "0.01", "--step", "0.001", "--output", "o.csv", "--plot", "f.svg")
    return {
        "simulate": (simulate, ("o.csv", "f.svg")),
        "build": (("build", "GaitLoad", "--fmi", "3", "--out", "built"), ("built/fmi3/GaitLoad.fmu",)),
        "steady": (STEADY, ("f.svg",)),
        "sweep": (SWEEP, ("o.csv", "f.svg")),
        "man": (("man", "--out", "man"), ("man/motor-fmu-build.1",)),
    }


@pytest.mark.parametrize("name", ["simulate", "build", "steady", "sweep", "man"])
def test_only_own_results_are_overwritten(motor_fmu, archive_paths, tmp_path, name):
    (tmp_path / "walk.toml").write_text(LOAD)
    command, files = commands(archive_paths[2])[name]
    for _ in range(2):
        done = motor_fmu(*command)
        assert done.returncode == 0, done.stderr
    for file in files:
        (tmp_path / file).write_text(NOTES)
        one_sentence(motor_fmu(*command), CANNOT, file, "exists", "--force")
        assert (tmp_path / file).read_text() == NOTES
        assert motor_fmu(*command, "--force").returncode == 0
        assert (tmp_path / file).read_bytes() != NOTES.encode()


def test_results_of_another_subject_are_refused(motor_fmu, archive_paths, tmp_path):
    (tmp_path / "inputs.csv").write_text("time,voltage\n0,1\n1,2\n")
    run = ("simulate", archive_paths[2], "--stop", "0.01", "--step", "0.001")
    one_sentence(motor_fmu(*run, "--input", "inputs.csv", "--output", "inputs.csv"), CANNOT, "inputs.csv", "--force")
    assert motor_fmu(*SWEEP).returncode == 0
    other = ("sweep", "--vary", "ambient_temperature=290:300:2", "--output", "o.csv")
    one_sentence(motor_fmu(*other), CANNOT, "o.csv", "ambient_temperature", "--force")
    one_sentence(motor_fmu(*run, "--plot", "f.svg"), CANNOT, "f.svg", "AnnulusCooledMotor", "--force")
