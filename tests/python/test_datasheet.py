"""From a datasheet to a preset, and what `info` and `variables` say: through the program."""

import json
import os
import re
import shlex
import subprocess
import time
import tomllib
from pathlib import Path

import pytest
import scipy.integrate

NO, CANNOT = 1, 2
DOC = Path(__file__).resolve().parents[2] / "docs" / "from-a-datasheet.md"

# A made-up brushed motor of 17 W that agrees with itself, in the units of a datasheet in which speeds are min⁻¹.
SHEET = """
name = "brushed-17"
source = "made up for this test"
[datasheet]
nominal_voltage = 24
terminal_resistance = "7.1 Ω"
no_load_speed = "8640 min⁻¹"
no_load_current = "0.042 A"
stall_torque = "88.4 mNm"
speed_constant = "364 min⁻¹/V"
torque_constant = "26.2 mNm/A"
terminal_inductance = "265 µH"
mechanical_time_constant = "6 ms"
rotor_inertia = "5.8 gcm²"
resistance_winding_housing = "2 K/W"
resistance_housing_ambient = "13 K/W"
winding_time_constant = "6.8 s"
motor_time_constant = "455 s"
max_winding_temperature = "125 °C"
mass = "88 g"
"""


@pytest.fixture
def new(motor_fmu, tmp_path):
    """`preset new` on a datasheet with further options; the answer as JSON."""

    def run(text, *options, code=0):
        (tmp_path / "sheet.toml").write_text(text)
        out = tmp_path / "new.toml"
        done = motor_fmu("preset", "new", "--from", tmp_path / "sheet.toml", "--output", out, "--force", "--json", *options)
        assert done.returncode == code, done.stdout + done.stderr
        return json.loads(done.stdout), out

    return run


def test_a_datasheet_becomes_a_preset_that_build_takes(new, motor_fmu, tmp_path):
    answer, preset = new(SHEET)
    assert answer["consistent"] and answer["contradictions"] == []
    values = {v["name"]: v for v in answer["preset"]["values"]}
    expected = {
        "motor.L": 265e-6,
        "motor.J": 5.8e-7,
        "thermal.C_w": 6.8 / 2,
        "thermal.C_h": 455 / 13 - 6.8 / 2,
        "conductance.G_still": 1 / 13,
        "thermal.T_w_max": 398.15,
        "effect.coulomb_friction.tau_c": 0.0262 * 0.042,
    }
    for name, value in expected.items():
        assert values[name]["value"] == pytest.approx(value, rel=1e-12), name
        assert values[name]["certainty"] in ("datasheet", "derived") and values[name]["source"]
    assert values["motor.alpha"]["certainty"] == "default" and "copper" in values["motor.alpha"]["source"]
    assert tomllib.loads(preset.read_text())["model"] == "AnnulusCooledMotor"

    assert motor_fmu("build", "AnnulusCooledMotor", "--fmi", "3", "--preset", preset, "--out", tmp_path).returncode == 0
    fmu = tmp_path / "fmi3" / "AnnulusCooledMotor.fmu"
    info = json.loads(motor_fmu("info", fmu, "--json").stdout)
    assert info["standard"] == "FMI 3.0" and info["interface_types"] == ["Model Exchange", "Co-Simulation"]
    starts = {v["name"]: float(v["start"]) for v in info["start_values"]}
    assert starts["thermal.C_w"] == pytest.approx(3.4) and starts["motor.mass"] == 0.088
    rows = json.loads(motor_fmu("variables", fmu, "motor.*", "drive_mode", "--json").stdout)
    by_name = {row["name"]: row for row in rows}
    assert float(by_name["motor.k_t"]["start"]) == 0.0262 and by_name["motor.k_t"]["unit"] == "N.m/A"
    assert {i["name"]: i["value"] for i in by_name["drive_mode"]["items"]} == {"voltage": 1, "pwm": 2, "current": 3, "power": 4}


@pytest.mark.parametrize(
    ("key", "text", "size"),
    [("stall_torque", "110 mNm", 110 / 88.4), ("rotor_inertia", "58 gcm²", 10), ("speed_constant", "38.1 rad/s/V", 1), ("mass", "8.8 kg", None)],
)
def test_a_contradiction_is_named_with_its_size(new, key, text, size):
    lines = [line for line in SHEET.splitlines() if not line.startswith(key)]
    answer, preset = new("\n".join([*lines, f'{key} = "{text}"', ""]), code=0 if size == 1 else NO)
    assert preset.is_file()
    named = [c for group in answer["contradictions"] for c in group if c["quantity"] == key]
    if size is None:
        assert any("specific heat" in i["words"] for i in answer["implausible"])
    elif size == 1:
        assert named == []
    else:
        assert named and named[0]["ratio"] == pytest.approx(size, rel=0.05), answer["contradictions"]


def test_files_are_not_overwritten_and_errors_come_with_lines(motor_fmu, tmp_path):
    sheet, out = tmp_path / "sheet.toml", tmp_path / "out.toml"
    sheet.write_text(SHEET)
    arguments = ["preset", "new", "--from", sheet, "--output", out]
    assert all(motor_fmu(*arguments).returncode == 0 for _ in range(2)), "its own result is overwritten"
    out.write_text("name = 'another'\n")
    done = motor_fmu(*arguments)
    assert done.returncode == CANNOT and "--force" in done.stderr and len(done.stderr.splitlines()) == 1
    sheet.write_text(SHEET + 'torque_konstant = 3\nlength = "4 V"\n')
    done = motor_fmu(*arguments, "--force")
    assert done.returncode == CANNOT
    last = len(SHEET.splitlines())
    lines = done.stderr.splitlines()
    assert len(lines) == 2 and f":{last + 1}: torque_konstant" in lines[0] and f":{last + 2}: length" in lines[1], done.stderr


def test_the_page_shows_what_the_command_prints(new):
    text = DOC.read_text().split("```toml\n")[1].split("```")[0]
    assert new(text)[0]["consistent"]
    changed = text.replace("= 2560 ", "= 3200 ")
    assert changed != text
    (found,) = [c for group in new(changed, code=NO)[0]["contradictions"] for c in group]
    assert f"{found['printed']:.0f} mN.m, the other values give {found['expected']:.0f} mN.m" in DOC.read_text()


def test_it_asks_on_a_terminal(program, tmp_path):
    pty = pytest.importorskip("pty")
    primary, secondary = pty.openpty()
    child = subprocess.Popen([program, "preset", "new"], stdin=secondary, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=tmp_path)
    answers = {"name of": "asked", "torque constant": "60,3 mNm/A", "terminal resistance": "1.13", "rotor inertia": "1.37e-5 kg.m2"}
    question = b""
    deadline = time.monotonic() + 60
    while child.poll() is None and time.monotonic() < deadline:
        byte = os.read(child.stderr.fileno(), 1)
        question += byte
        if question.endswith(b": ") and question not in (b"source: ", b"Datasheet values: "):
            asked = question.decode()
            os.write(primary, (next((a for q, a in answers.items() if asked.startswith(q)), "") + "\n").encode())
            question = b""
        elif byte == b"\n" or not byte:
            question = b""
    assert child.wait(10) == 0
    start = tomllib.loads((tmp_path / "asked.toml").read_text())["start"]
    assert start["motor.J"] == {"value": 1.37e-5, "unit": "kg.m2"} and start["motor.k_t"]["value"] == 60.3


# FAULHABER 1331 T 012 SR, 2.5 W, in the terms of its datasheet.
FAULHABER = """
name = "faulhaber-1331"
[datasheet]
nominal_voltage = 12
terminal_resistance = 13.7
no_load_speed = 9900
no_load_current = "0.0105 A"
friction_torque = 0.12
back_emf_constant = "1.20 mV/rpm"
slope_of_n_m_curve = 1000
rotor_inductance = "310 µH"
rotor_inertia = 0.67
rth1 = 6
rth2 = 25
tau_w1 = 5
tau_w2 = 190
max_rotor_temperature = 125
weight = 19
"""


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
def test_a_sheet_of_another_maker_in_any_encoding_becomes_an_archive_without_findings(motor_fmu, tmp_path, encoding):
    """The smallest motor: its archive passes the validator, which `build` runs."""
    (tmp_path / "sheet.toml").write_bytes(FAULHABER.encode(encoding))
    done = motor_fmu("preset", "new", "--from", "sheet.toml")
    assert done.returncode == 0, done.stdout + done.stderr
    start = tomllib.loads((tmp_path / "faulhaber-1331.toml").read_text())["start"]
    assert start["motor.k_t"] == {"value": 1.2, "unit": "mV/rpm"} and start["motor.L"] == {"value": 310, "unit": "µH"}
    done = motor_fmu("build", "AnnulusCooledMotor", "--fmi", "2", "--preset", "faulhaber-1331.toml", "--out", ".")
    assert done.returncode == 0, done.stdout + done.stderr
    steady = json.loads(motor_fmu("steady", "--preset", "faulhaber-1331.toml", "--json").stdout)
    # 100 K over 31 K/W of the hot resistance.
    assert steady["continuous"]["current"] == pytest.approx((100 / (31 * 13.7 * 1.39)) ** 0.5, rel=1e-3)


def test_a_datasheet_is_kept(motor_fmu, tmp_path):
    """Neither its preset nor a wrong use of it overwrites or hides the datasheet."""
    (tmp_path / "faulhaber-1331.toml").write_text(FAULHABER, encoding="utf-8")
    for force in ([], ["--force"]):
        done = motor_fmu("preset", "new", "--from", "faulhaber-1331.toml", *force)
        assert done.returncode == CANNOT and "would overwrite its datasheet" in done.stderr
    done = motor_fmu("steady", "--preset", "faulhaber-1331.toml")
    assert done.returncode == CANNOT and "motor-fmu preset new --from faulhaber-1331.toml" in done.stderr
    assert (tmp_path / "faulhaber-1331.toml").read_text(encoding="utf-8") == FAULHABER


@pytest.mark.parametrize("preset", ["faulhaber-1524t006sr", "maxon-ecmax22-283856", "maxon-ec90flat-323772"])
def test_small_and_flat_motors_are_archives_without_findings(motor_fmu, tmp_path, preset):
    done = motor_fmu("build", "AnnulusCooledMotor", "--fmi", "2", "--preset", preset, "--out", ".")
    assert done.returncode == 0 and "0 errors, 0 warnings" in done.stdout, done.stdout + done.stderr


def test_names_are_hinted_and_manuals_written(motor_fmu, tmp_path):
    done = motor_fmu("variables", "AnulusCooledMotor")
    assert done.returncode == CANNOT and "did you mean AnnulusCooledMotor?" in done.stderr
    done = motor_fmu("variables", "maxon-305015", "motor.R_reff")
    assert done.returncode == CANNOT and "did you mean motor.R_ref?" in done.stderr
    info = json.loads(motor_fmu("info", "maxon-305015", "--json").stdout)
    sources = {v["name"]: v["source"] for v in info["start_values"]}
    assert info["model"] == "AnnulusCooledMotor" and "k_t I_0" in sources["effect.coulomb_friction.tau_c"]
    assert motor_fmu("--version").stdout.startswith("motor-fmu ")
    assert "preset" in motor_fmu("completions", "bash").stdout
    assert motor_fmu("man", "--out", tmp_path).returncode == 0
    assert ".TH" in (tmp_path / "motor-fmu-preset-new.1").read_text()


def test_time_to_the_limit_of_the_tutorial(motor_fmu, tmp_path):
    """The tutorial's overload: the FMU trips when the two bodies of the datasheet reach the limit, solved by scipy."""
    text = DOC.read_text()
    sheet = text.split("```toml\n")[1].split("```")[0]
    (tmp_path / "sheet.toml").write_text(sheet)
    for command in (["preset", "new", "--from", "sheet.toml"], ["build", "AnnulusCooledMotor", "--fmi", "2", "--preset", "my-re40.toml", "--out", "re40"]):
        assert motor_fmu(*command).returncode == 0
    steps = text.split("## 5.")[1].split("```sh\n")[1].split("```")[0]
    done = motor_fmu(*shlex.split(steps.replace("\\\n", " "))[1:])
    assert done.returncode == 0, done.stderr
    assert text.split("```text\n")[-1].split("```")[0].strip() in done.stdout
    printed = float(re.search(r"over_temperature +true since t = ([\d.]+) s", done.stdout)[1])

    value = {key: entry for key, entry in tomllib.loads(sheet)["datasheet"].items() if isinstance(entry, (int, float))}
    inner, outer = value["resistance_winding_housing"], value["resistance_housing_ambient"]
    winding = value["winding_time_constant"] / inner
    housing = value["motor_time_constant"] / outer - winding

    def rates(_, rise):
        copper = 6.0**2 * value["terminal_resistance"] * (1.0 + 0.0039 * rise[0])
        through = (rise[0] - rise[1]) / inner
        return [(copper - through) / winding, (through - rise[1] / outer) / housing]

    def limit(_, rise):
        return rise[0] - (value["max_winding_temperature"] - 25.0)

    limit.terminal = True
    solved = scipy.integrate.solve_ivp(rates, (0.0, 300.0), [0.0, 0.0], events=limit, rtol=1e-9)
    # The output is seen at the next of the steps of 0.1 s.
    assert 0.0 <= printed - solved.t[-1] <= 0.11
    assert f"{solved.t[-1]:.1f} s" in text


def read(path):
    rows = [line.split(",") for line in path.read_text().splitlines()]
    return rows[0], [[float(x) for x in row] for row in rows[1:]]


def test_outputs_units_and_every_of_simulate(motor_fmu, archive_paths, tmp_path):
    run = ["simulate", archive_paths[2], "--stop", "1", "--step", "0.01", "--set", "drive_mode=current", "--set", "current_command=5000 mA"]
    chosen = ["--outputs", "shaft_speed,*housing_temp*", "--every", "30"]

    def recorded(*options):
        done = motor_fmu(*run, *options, "--output", "o.csv", "--json")
        assert done.returncode == 0, done.stderr
        return (*read(tmp_path / "o.csv"), json.loads(done.stdout)["final"])

    _, full, _ = recorded()
    names, si, last = recorded(*chosen, "--set", "ambient_temperature=35degC")
    assert names == ["time", "shaft_speed", "housing_temperature"] and list(last) == names[1:]
    assert [row[0] for row in si] == pytest.approx([0.0, 0.3, 0.6, 0.9, 1.0]) and len(full) == 101
    assert si[0][2] == pytest.approx(308.15) and si[-1][1] > 10.0
    names, shown, last = recorded(*chosen, "--units", "datasheet", "--set", "ambient_temperature=35")
    assert names == ["time", "shaft_speed [rpm]", "housing_temperature [degC]"]
    for a, b in zip(si, shown, strict=True):
        assert b == pytest.approx([a[0], a[1] * 9.549296585513721, a[2] - 273.15], rel=1e-9, abs=1e-9)
    assert last["housing_temperature"] == pytest.approx(shown[-1][2])
    (tmp_path / "in.csv").write_text("time,ambient_temperature,imposed_speed\n0,35,1000\n")
    imposed = ["--input", "in.csv", "--set", "mechanical_mode=imposed_speed"]
    _, shown, _ = recorded(*chosen, *imposed, "--units", "datasheet")
    assert shown[0][1:] == pytest.approx([1000.0, 35.0])
    done = motor_fmu(*run, "--outputs", "voltage")
    assert done.returncode == CANNOT and "voltage is no output (causality input); --record voltage records it" in done.stderr
    done = motor_fmu(*run, "--outputs", "shaft_sped")
    assert done.returncode == CANNOT and "did you mean shaft_speed?" in done.stderr
    done = motor_fmu(*run, "--set", "voltage=3 A")
    assert done.returncode == CANNOT and "voltage" in done.stderr
