"""An existing file is overwritten if it is an earlier result of the same command, or with --force; any other file is refused."""

import os

import pytest
from test_cli_bad_input import CANNOT, one_sentence

NOTES = "my notes, of a day's work\n"
STEADY = ("steady", "--load", "walk.toml", "--hours", "0.05", "--plot", "f.svg")
SWEEP = ("sweep", "--vary", "fan_command=0:1:2", "--output", "o.csv", "--plot", "f.svg")
PRESET = ("preset", "new", "--name", "p", "--torque-constant", "60", "--terminal-resistance", "1")
LOAD = '[motor]\ndrive_mode = "current"\n[gait]\n"gait.support" = 0.3\n'


def commands(fmu):
    simulate = ("simulate", fmu, "--stop", "0.01", "--step", "0.001", "--output", "o.csv", "--plot", "f.svg")
    return {
        "simulate": (simulate, ("o.csv", "f.svg")),
        "build": (("build", "GaitLoad", "--fmi", "3", "--out", "built"), ("built/fmi3/GaitLoad.fmu",)),
        "steady": (STEADY, ("f.svg",)),
        "sweep": (SWEEP, ("o.csv", "f.svg")),
        "preset": (PRESET, ("p.toml",)),
        "man": (("man", "--out", "man"), ("man/motor-fmu-build.1",)),
    }


@pytest.mark.parametrize("name", ["simulate", "build", "steady", "sweep", "preset", "man"])
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
    assert motor_fmu(*PRESET).returncode == 0
    one_sentence(motor_fmu("preset", "new", "--name", "q", *PRESET[4:], "--output", "p.toml"), CANNOT, "p.toml", "--force")


@pytest.mark.parametrize("command", [PRESET, SWEEP[:3]])
@pytest.mark.parametrize("path", ["-", "/dev/stdout", "/dev/fd/1"])
def test_a_result_on_the_standard_output_is_refused(motor_fmu, tmp_path, command, path):
    one_sentence(motor_fmu(*command, "--output", path), CANNOT, path, "name a file")
    assert not list(tmp_path.iterdir())


SYSTEM = '[system]\nname = "one"\n[experiment]\nstop = 0.01\nstep = 0.001\n[[component]]\nname = "m"\nfmu = "{}"\n'


@pytest.mark.parametrize(
    "command, files", [(("cosim", "s.toml", "--output", "o.csv", "--plot", "f.svg"), ("o.csv", "f.svg")), (("ssp", "s.toml"), ("s.ssp",))]
)
def test_results_of_systems_are_overwritten_and_nothing_else(motor_fmu, archive_paths, tmp_path, command, files):
    (tmp_path / "s.toml").write_text(SYSTEM.format(archive_paths[2]))
    for _ in range(2):
        assert motor_fmu(*command).returncode == 0
    # The same command of another system: its result is no earlier one.
    (tmp_path / "s.toml").write_text(SYSTEM.format(archive_paths[2]).replace('"one"', '"two"').replace('"m"', '"n"'))
    one_sentence(motor_fmu(*command), CANNOT, files[0], "exists", "--force")
    for file in files:
        assert motor_fmu(*command, "--force").returncode == 0
        (tmp_path / file).write_text(NOTES)
        one_sentence(motor_fmu(*command), CANNOT, file, "exists", "--force")
        assert (tmp_path / file).read_text() == NOTES
    assert motor_fmu(*command, "--force").returncode == 0


EXPERIMENT = """[experiment]
name = "e"
model = "AnnulusCooledMotor"
preset = "maxon-305015"
inputs = ["current_A", "speed_rad_per_s", "ambient_temperature_degC"]
outputs = ["winding_temperature_degC"]
[prior]
"motor.R_ref" = 0.03
[[run]]
file = "r.csv"
role = "fit"
"""


@pytest.mark.parametrize(
    "command, file",
    [
        (("fit", "e.toml", "--out", "out"), "report.json"),
        (("fit", "e.toml", "--out", "out"), "preset.toml"),
        (("close-loop", "e.toml", "--out", "out"), "report.html"),
        (("close-loop", "e.toml", "--out", "out"), "fmi3/AnnulusCooledMotor.fmu"),
        (("reproduce", "thesis", "--out", "out"), None),
        (("reproduce", "paper", "--out", "out"), None),
    ],
)
def test_long_commands_refuse_foreign_files_before_they_compute(motor_fmu, tmp_path, command, file):
    (tmp_path / "e.toml").write_text(EXPERIMENT)
    rows = [f"{k},2.0,100.0,25.0,{25.0 + 0.01 * k}" for k in range(200)]
    (tmp_path / "r.csv").write_text("time_s,current_A,speed_rad_per_s,ambient_temperature_degC,winding_temperature_degC\n" + "\n".join(rows) + "\n")
    path = tmp_path / "out" / (file or f"{command[1]}.html")
    path.parent.mkdir(parents=True)
    path.write_text(NOTES)
    one_sentence(motor_fmu(*command), CANNOT, path.name, "exists", "--force")
    assert path.read_text() == NOTES


@pytest.mark.parametrize("command, other", [("fit", "named"), ("close-loop", "fitted")])
@pytest.mark.parametrize("file", ["report.json", "preset.toml"])
def test_fit_and_close_loop_do_not_replace_the_results_of_each_other(motor_fmu, tmp_path, command, other, file):
    (tmp_path / "e.toml").write_text(EXPERIMENT)
    rows = [f"{k},2.0,100.0,25.0,{25.0 + 0.01 * k}" for k in range(200)]
    (tmp_path / "r.csv").write_text("time_s,current_A,speed_rad_per_s,ambient_temperature_degC,winding_temperature_degC\n" + "\n".join(rows) + "\n")
    (tmp_path / "out").mkdir()
    header = "# Calibrated by motor-fmu close-loop: the preset maxon-305015 and the experiment e, as in e.toml.\n"
    texts = {
        "report.json": f'{{"name": "e", "verdict": "{other}"}}',
        "preset.toml": f'{header}name = "e"\ndescription = "maxon-305015 after the experiment e; verdict: {other}"\n',
    }
    (tmp_path / "out" / file).write_text(texts[file])
    one_sentence(motor_fmu(command, "e.toml", "--out", "out"), CANNOT, file, f"of {command} for the experiment e", "--force")
    assert (tmp_path / "out" / file).read_text() == texts[file]


@pytest.mark.parametrize("place", ["-", "/dev/stdout", "/dev/fd/1"] if os.name == "posix" else ["-"])
def test_a_table_on_the_standard_output(motor_fmu, archive_paths, tmp_path, place):
    """The FMU runs in a process whose standard output is not that of the command."""
    (tmp_path / "s.toml").write_text(SYSTEM.format(archive_paths[2]))
    for run in (("simulate", archive_paths[2], "--stop", "0.01", "--step", "0.001"), ("cosim", "s.toml")):
        table = motor_fmu(*run, "--output", "o.csv", "--force") and (tmp_path / "o.csv").read_text()
        assert motor_fmu(*run, "--output", place).stdout == table
        one_sentence(motor_fmu(*run, "--output", place, "--json"), CANNOT, place, "--json", "standard output")
    assert not (tmp_path / "-").exists()
    one_sentence(motor_fmu("sweep", "--vary", "fan_command=0,1", "--output", "-"), CANNOT, "name a file")


def test_two_results_in_one_file_are_refused(motor_fmu, archive_paths, tmp_path):
    (tmp_path / "s.toml").write_text(SYSTEM.format(archive_paths[2]))
    runs = (("simulate", archive_paths[2]), ("cosim", "s.toml"), ("sweep", "--vary", "fan_command=0,1"))
    for run in runs:
        one_sentence(motor_fmu(*run, "--output", "x.svg", "--plot", tmp_path / "x.svg"), CANNOT, "--output", "--plot", "x.svg")
    assert not (tmp_path / "x.svg").exists()
