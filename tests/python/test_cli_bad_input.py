"""Bad input through the `motor-fmu` program: exit code 1 = check failed, 2 = could not run."""

import json
import os
import re
import subprocess
import zipfile
from functools import partial

import pytest
from clients.paths import EXAMPLES

NO, CANNOT = 1, 2


def one_sentence(done, code, *words):
    """One clear line, with these words, and the exit code."""
    assert done.returncode == code, f"exit code {done.returncode}: {done.stdout}{done.stderr}"
    progress = re.compile(r" *\d+ s, +\d+ %: ")
    lines = [line for line in done.stderr.splitlines() if line.strip() and not progress.match(line)]
    assert len(lines) == 1, done.stderr
    for word in words:
        assert word in lines[0], f"{word!r} is not in {lines[0]!r}"


@pytest.fixture
def simulate(motor_fmu, archive_paths, tmp_path):
    """A short simulation with further arguments."""

    def run(*arguments):
        return motor_fmu("simulate", archive_paths[2], "--stop", "0.01", "--step", "0.001", "--output", tmp_path / "o.csv", *arguments)

    return run


def test_good_input_is_fine(simulate, tmp_path):
    assert simulate("--set", "voltage=3").returncode == 0
    assert (tmp_path / "o.csv").is_file()


def test_unknown_name(simulate):
    one_sentence(simulate("--set", "motor.R_reff=0.4"), CANNOT, "motor.R_reff")


def test_value_out_of_range(simulate):
    one_sentence(simulate("--set", "motor.R_ref=-1"), CANNOT, "motor.R_ref", "-1")


def test_value_that_is_no_number(simulate):
    one_sentence(simulate("--set", "motor.R_ref=big"), CANNOT, "motor.R_ref", "big")


def test_a_setting_is_given_once(simulate, motor_fmu):
    one_sentence(simulate("--set", "voltage=3", "--set", "voltage=4"), CANNOT, "voltage", "two values: 3 and 4")
    one_sentence(motor_fmu("steady", "--set", "fan_command=0", "--set", "fan_command=1"), CANNOT, "fan_command", "two values: 0 and 1")


def test_a_periodic_load_has_no_steady_state(motor_fmu):
    one_sentence(motor_fmu("steady", "--model", "GaitLoad"), CANNOT, "GaitLoad is a periodic load", "--load")


@pytest.mark.parametrize(("value", "code"), [("2,5", 0), ("2,500", CANNOT), ("1,2,3", CANNOT)])
def test_decimal_comma(simulate, value, code):
    """A comma that may separate thousands is not guessed."""
    done = simulate("--set", f"voltage={value}")
    assert done.returncode == code, done.stderr
    if code:
        one_sentence(done, code, "voltage", value)


@pytest.mark.parametrize(("name", "word"), [("missing/o.svg", "the folder missing does not exist"), (".", ".svg")])
def test_place_of_a_plot_is_checked_before_the_run(motor_fmu, archive_paths, name, word):
    one_sentence(motor_fmu("simulate", archive_paths[2], "--stop", "1e6", "--step", "0.001", "--plot", name), CANNOT, word)


def test_outputs_need_a_name(simulate):
    one_sentence(simulate("--outputs", ""), CANNOT, "--outputs", "no name")


@pytest.mark.parametrize(
    ("encoding", "text"),
    [
        ("utf-8-sig", "time [ms];voltage [mV];ambient_temperature [°C]\r\n0;1000,0;25\r\n10;2000,0;25\r\n"),
        ("cp1252", "# Prüfstand\ntime;voltage;ambient_temperature [°C]\n0;1;25\n0,01;2;25\n"),
        ("utf-16", "time\tvoltage [V]\tambient_temperature [degF]\n0\t1\t77\n0.01\t2\t77\n"),
    ],
)
def test_input_tables_of_spreadsheets(simulate, tmp_path, encoding, text):
    table = tmp_path / "in.csv"
    table.write_bytes(text.encode(encoding))
    done = simulate("--input", table)
    assert done.returncode == 0, done.stderr
    last = (tmp_path / "o.csv").read_text().splitlines()
    row = dict(zip(last[0].split(","), map(float, last[-1].split(",")), strict=True))
    assert row["terminal_voltage"] == pytest.approx(2.0, abs=1e-9)


def test_table_that_is_no_text(simulate, archive_paths):
    one_sentence(simulate("--input", archive_paths[2]), CANNOT, "AnnulusCooledMotor.fmu", "not text", "CSV")


def test_full_disk_is_no_success(program):
    """Results that were not written are an error, and no message panics."""
    with open("/dev/full", "w") as full:
        assert subprocess.run([program, "steady", "--json"], stdout=full, stderr=subprocess.PIPE).returncode == CANNOT
        assert subprocess.run([program, "simulate", "none.fmu"], stdout=subprocess.PIPE, stderr=full).returncode == CANNOT


def test_unknown_item(simulate):
    one_sentence(simulate("--set", "drive_mode=steam"), CANNOT, "drive_mode", "steam", "current")


def test_preset_of_another_model(motor_fmu, tmp_path):
    done = motor_fmu("build", "AnnulusCooledMotor", "--preset", "bdcm-37d", "--out", tmp_path)
    one_sentence(done, CANNOT, "bdcm-37d", "BrushedGearmotor", "AnnulusCooledMotor")


def test_missing_archive(motor_fmu, tmp_path):
    one_sentence(motor_fmu("simulate", tmp_path / "none.fmu"), CANNOT, "none.fmu")


def test_archive_that_is_no_zip(motor_fmu, tmp_path):
    file = tmp_path / "broken.fmu"
    file.write_bytes(b"this is not a zip archive")
    one_sentence(motor_fmu("simulate", file), CANNOT, "broken.fmu")


def test_temporary_folder_that_is_missing(program, archive_paths, tmp_path):
    done = subprocess.run(
        [program, "simulate", archive_paths[2]],
        env={**os.environ, "TMPDIR": str(tmp_path / "gone")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        timeout=300,
    )
    one_sentence(done, CANNOT, "temporary folder", "TMPDIR", "gone")


def test_archive_without_its_library(motor_fmu, archive_paths, tmp_path):
    file = tmp_path / "hollow.fmu"
    with zipfile.ZipFile(archive_paths[2]) as source, zipfile.ZipFile(file, "w") as target:
        for name in source.namelist():
            if not name.startswith("binaries/"):
                target.writestr(name, source.read(name))
    one_sentence(motor_fmu("simulate", file), CANNOT, "hollow.fmu")
    assert motor_fmu("validate", file).returncode == NO


def test_validate_reports_every_file_that_can_be_read(motor_fmu, archive_paths, tmp_path):
    missing, broken = tmp_path / "missing.fmu", tmp_path / "broken.fmu"
    broken.write_bytes(b"no archive")
    done = motor_fmu("validate", archive_paths[2], missing, archive_paths[3])
    assert done.returncode == CANNOT
    assert [line.split(": ")[0] for line in done.stdout.splitlines()] == [str(archive_paths[2]), str(archive_paths[3])]
    errors = [line for line in done.stderr.splitlines() if line.startswith("error")]
    assert len(errors) == 1 and "missing.fmu" in errors[0]
    listed = json.loads(motor_fmu("validate", "--json", missing, archive_paths[2], broken).stdout)
    assert [sorted(entry) for entry in listed][:2] == [["error", "file", "findings"], ["file", "findings"]]
    assert "missing.fmu" in listed[0]["error"] and listed[0]["findings"] == [] and listed[1]["findings"] == [] and len(listed) == 3
    two = motor_fmu("validate", missing, tmp_path / "another.fmu").stderr
    assert "missing.fmu" in two and "another.fmu" in two


@pytest.fixture
def preset(archive_paths, tmp_path):
    """A copy of the shipped preset with one line more, or with a text replaced."""

    def write(old="", new=""):
        shipped = EXAMPLES / "presets" / "maxon-305015.toml"
        text = shipped.read_text()
        assert not old or old in text, f"{old!r} is not in {shipped.name}"
        file = tmp_path / "changed.toml"
        file.write_text(text.replace(old, new, 1) if old else text + new)
        return file

    return write


def build(motor_fmu, preset, tmp_path):
    return motor_fmu("build", "--preset", preset, "--out", tmp_path / "dist")


def test_preset_with_unknown_key(motor_fmu, preset, tmp_path):
    one_sentence(build(motor_fmu, preset(new='\n"motor.colour" = 3.0\n'), tmp_path), CANNOT, "changed.toml", "motor.colour")
    assert not (tmp_path / "dist").exists()


def test_preset_with_wrong_unit(motor_fmu, preset, tmp_path):
    one_sentence(
        build(motor_fmu, preset('unit = "Ohm"', 'unit = "V"'), tmp_path), CANNOT, "changed.toml", "motor.R_ref", '"Ohm"', '"V"'
    )
    assert not (tmp_path / "dist").exists()


def test_all_errors_of_a_preset_at_once(motor_fmu, preset, tmp_path):
    done = build(motor_fmu, preset(new='\n"motor.colour" = 3.0\nvoltage = "3 A"\nimposed_speed = "50 Hz"\n'), tmp_path)
    assert done.returncode == CANNOT, done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) == 3, done.stderr
    for line, words in zip(lines, (["motor.colour"], ["voltage", '"V"', '"A"'], ["imposed_speed", '"rad/s"', '"Hz"']), strict=True):
        assert re.search(r"changed\.toml:\d+: ", line) and all(word in line for word in words), line


def test_set_takes_units_of_the_quantity(motor_fmu):
    def steady(*sets):
        settings = [word for value in sets for word in ("--set", value)]
        done = motor_fmu("steady", "--json", "--preset", "maxon-305015", *settings)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)["steady"]

    si = steady("ambient_temperature=308.15", "imposed_speed=104.71975511965977", "current_command=2.5")
    assert steady("ambient_temperature=35degC", "imposed_speed=1000 rpm", "current_command=2500 mA") == pytest.approx(si, rel=1e-9, abs=1e-9)
    one_sentence(motor_fmu("steady", "--set", "current_command=2 V"), CANNOT, "current_command", '"A"', '"V"')


def test_names_of_a_load_are_looked_for_in_all_its_models(motor_fmu, tmp_path):
    load = tmp_path / "walk.toml"
    load.write_text('[gait]\n"gait.joint" = "ankle"\n')
    one_sentence(motor_fmu("steady", "--load", load, "--set", "transmission.rtio=3"), CANNOT, "did you mean transmission.ratio?")
    load.write_text('name = "x"\n')
    one_sentence(motor_fmu("steady", "--load", load), CANNOT, "walk.toml:1", "[gait], [cycle], [mix]")


def test_far_names_are_not_suggested(motor_fmu):
    done = motor_fmu("info", "nonsense")
    one_sentence(done, CANNOT, "nonsense")
    assert "did you mean" not in done.stderr
    one_sentence(motor_fmu("steady", "--preset", "no/mine.toml"), CANNOT, "the preset no/mine.toml cannot be read")


def test_motors_are_varied_at_constant_inputs(motor_fmu):
    done = motor_fmu("sweep", "--vary", "preset=maxon-305015,maxon-re40-148877", "--json")
    assert done.returncode == 0, done.stderr
    assert [point["values"] for point in json.loads(done.stdout)["points"]] == [["maxon-305015"], ["maxon-re40-148877"]]


def test_a_temperature_in_degc_is_suspected_wherever_a_value_is_set(motor_fmu, simulate, archive_paths, tmp_path):
    for name in ("initial.winding_temperature", "ambient_temperature"):
        words = (f"{name} = 25 K is outside", "25 degC is within them")
        one_sentence(simulate("--set", f"{name}=25"), CANNOT, *words)
        one_sentence(motor_fmu("steady", "--set", f"{name}=25"), CANNOT, *words)
        one_sentence(motor_fmu("sweep", "--vary", f"{name}=25,26"), CANNOT, *words)
        (tmp_path / "s.toml").write_text(f'[system]\nname = "s"\n[[component]]\nname = "m"\nfmu = "{archive_paths[2]}"\n[component.set]\n"{name}" = 25\n')
        one_sentence(motor_fmu("cosim", "s.toml"), CANNOT, *words)


def test_inputs_come_through_a_pipe(program, archive_paths, tmp_path):
    table = "time,fan_command\n0,0\n0.5,1\n"
    (tmp_path / "fan.csv").write_text(table)
    (tmp_path / "system.csv").write_text(table.replace("fan", "m.fan"))
    (tmp_path / "s.toml").write_text(f'[system]\nname = "s"\n[experiment]\nstop = 1\n[[component]]\nname = "m"\nfmu = "{archive_paths[2]}"\n')
    run = partial(subprocess.run, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    for command, file in ((["simulate", archive_paths[3], "--stop", "1"], "fan.csv"), (["cosim", "s.toml"], "system.csv")):
        command = [program, *command, "--output", "-", "--input"]
        expected = run([*command, file])
        assert expected.returncode == 0, expected.stderr
        text = (tmp_path / file).read_text()
        for name in ("-", "/dev/stdin") if os.name == "posix" else ("-",):
            done = run([*command, name], input=text)
            assert (done.returncode, done.stdout) == (0, expected.stdout), done.stderr
            one_sentence(run([*command, name], input=text.replace("1\n", "x\n")), CANNOT, "standard input, line 3", "x")
            one_sentence(run([*command, name], input=""), CANNOT, "standard input, line 1: the file is empty")
