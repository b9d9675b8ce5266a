"""What `motor-fmu close-loop` does with bench data that contain ordinary mistakes: refused, set aside or unusable, and no effect is named on them.

Each mistake is made in a set whose missing effect is known (iron loss), by what such a mistake does and with sizes that are not special.
"""

import json
import subprocess
import time

import numpy as np
import public_sets
import pytest

FOLDER = public_sets.SETS / "iron-loss"
FILES = [f"run-{k}.csv" for k in (1, 2, 3, 4)]
CURRENT, SPEED, AMBIENT = "current_A", "speed_rad_per_s", "ambient_temperature_degC"
VOLTAGE, TORQUE = "voltage_V", "shaft_torque_Nm"
WINDING, HOUSING = "winding_temperature_degC", "housing_temperature_degC"


def scaled(column, factor, offset=0.0, files=FILES):
    def change(name, table):
        if name in files:
            table[column] = factor * table[column] + offset

    return change


def swapped(a, b):
    def change(_, table):
        table[a], table[b] = table[b].copy(), table[a].copy()

    return change


def part(column, values, file, begin, end=1.0):
    """Other readings in a part of a run; `values` of the table and the rows."""

    def change(name, table):
        if name == file:
            rows = np.arange(int(begin * len(table[column])), int(end * len(table[column])))
            table[column][rows] = values(table, rows)

    return change


def noisy(level, size=0.1):
    return lambda table, rows: level + size * np.random.default_rng(5).standard_normal(len(rows))


def off(table, rows):
    """A sensor that has come off: it cools to ambient with its own time constant."""
    first = rows[0]
    elapsed = table["time_s"][rows] - table["time_s"][first]
    return table[AMBIENT][rows] + (table[HOUSING][first] - table[AMBIENT][first]) * np.exp(-elapsed / 25.0)


def spikes(column, size, count):
    def change(name, table):
        rng = np.random.default_rng(len(name))
        table[column][rng.choice(len(table[column]), count, replace=False)] += size

    return change


def coupled(column, tau, files=FILES):
    """What an instrument with AC coupling shows: the readings without their first-order lag."""

    def change(name, table):
        if name in files:
            removed, time, own = 0.0, table["time_s"], table[column]
            for row in range(len(own)):
                step = time[row] - time[row - 1] if row else 0.0
                own[row] -= removed
                removed += own[row] * (1.0 - np.exp(-step / tau))

    return change


def stuck(column, size, files=FILES):
    """A bit of the converter that is always 1."""

    def change(name, table):
        if name in files:
            table[column] += size * (1.0 - np.floor(table[column] / size) % 2)

    return change


def both(*changes):
    def change(name, table):
        for one in changes:
            one(name, table)

    return change


UNUSABLE = {
    "speed in revolutions per minute": (scaled(SPEED, 30.0 / np.pi), SPEED),
    "speed in revolutions per minute in one run": (scaled(SPEED, 30.0 / np.pi, files=FILES[1:2]), SPEED),
    "speed in rad/s of a column in rpm in one run": (scaled(SPEED, np.pi / 30.0, files=FILES[1:2]), SPEED),
    "speed of three pole pairs": (scaled(SPEED, 3.0), SPEED),
    "speed with the other sign": (scaled(SPEED, -1.0), SPEED),
    "torque in pound-force inch": (scaled(TORQUE, 8.850_746), TORQUE),
    "torque with the other sign in one run": (scaled(TORQUE, -1.0, files=FILES[:1]), TORQUE),
    "torque in mN.m in the test run": (scaled(TORQUE, 1e3, files=FILES[3:]), TORQUE),
    "voltage in mV": (scaled(VOLTAGE, 1e3), VOLTAGE),
    "winding in degF": (scaled(WINDING, 1.8, 32.0), WINDING),
    "ambient in K": (scaled(AMBIENT, 1.0, 273.15), AMBIENT),
    "ambient and housing exchanged": (swapped(AMBIENT, HOUSING), AMBIENT),
    "time in ms": (scaled("time_s", 1e3), "time_s"),
    "torque behind AC coupling of 210 s": (coupled(TORQUE, 210.0), TORQUE),
    "current behind AC coupling of 17 s in one run": (coupled(CURRENT, 17.0, files=FILES[:1]), CURRENT),
}
ASIDE = {
    "housing open at -61 degC": (scaled(HOUSING, 0.0, -61.0), HOUSING),
    "housing open at 131 degC in a part": (part(HOUSING, noisy(131.0), "run-1.csv", 0.35, 0.6), HOUSING),
    "winding frozen in a part": (part(WINDING, lambda t, rows: t[WINDING][rows[0]], "run-2.csv", 0.3, 0.75), WINDING),
    "housing comes off": (part(HOUSING, off, "run-1.csv", 0.55), HOUSING),
    "torque sensor dead in one run": (part(TORQUE, noisy(0.0, 1e-3), "run-2.csv", 0.0), TORQUE),
    "winding with spikes": (spikes(WINDING, 37.0, 25), WINDING),
    "housing with a stuck bit": (stuck(HOUSING, 9.0), HOUSING),
}
# Outputs that no run has, each and two at once: every part of the search and of the report has to do without them.
ABSENT = {
    "voltage": scaled(VOLTAGE, 0.0, 0.4),
    "torque": scaled(TORQUE, 0.0, 7.0),
    "winding": scaled(WINDING, 0.0, 411.0),
    "housing": scaled(HOUSING, 0.0, -27.5),
    "both temperatures": both(scaled(WINDING, 0.0, -88.0), scaled(HOUSING, 0.0, 214.0)),
}


def run(program, folder, change, *arguments, command="close-loop"):
    """The exit code, the report and the wall time of the command on the changed set."""
    folder.mkdir(exist_ok=True)
    (folder / "experiment.toml").write_text((FOLDER / "experiment.toml").read_text())
    for name in FILES:
        table = np.genfromtxt(FOLDER / name, delimiter=",", names=True, deletechars="")
        columns = {column: table[column].copy() for column in table.dtype.names}
        change(name, columns)
        rows = zip(*columns.values())
        lines = [",".join(columns), *(",".join(f"{x:.7g}" for x in row) for row in rows)]
        (folder / name).write_text("\n".join(lines) + "\n")
    begun = time.monotonic()
    command = [program, command, str(folder / "experiment.toml"), "--out", str(folder / "out"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    report = folder / "out" / "report.json"
    return done, json.loads(report.read_text()) if report.exists() else None, time.monotonic() - begun


NIGHTLY = pytest.mark.nightly
# In the everyday run one of each kind: sign, unit, time, sensor.
EVERYDAY = ("torque with the other sign in one run", "winding in degF", "time in ms", "housing comes off")


def cases(table):
    return [pytest.param(*case, id=name, marks=[] if name in EVERYDAY else [NIGHTLY]) for name, case in table.items()]


@pytest.mark.parametrize(("change", "channel"), cases(UNUSABLE))
def test_data_that_contradict_the_model_are_unusable(program, tmp_path, change, channel):
    done, report, _ = run(program, tmp_path / "set", change)
    assert done.returncode == 1, done.stdout + done.stderr
    assert report["verdict"] == "unusable" and report["effects"] == [] and report["fmu"] == []
    assert set(report["unusable"]) == {"channel", "reason", "suggestion"}
    assert channel in report["unusable"]["reason"] and report["unusable"]["suggestion"]
    assert "Unusable data" in (tmp_path / "set" / "out" / "report.html").read_text()


def is_set_aside(done, report, channel):
    assert done.returncode == 0, done.stdout + done.stderr
    assert any(channel in note and "set aside" in note and "run-" in note for note in report["notes"]), report["notes"]


@pytest.mark.parametrize(("change", "channel"), cases(ASIDE))
def test_a_sensor_that_does_not_work_is_set_aside(program, tmp_path, change, channel):
    """By the intake, which is the same for both commands; the fit alone takes a third of the time."""
    done, report, _ = run(program, tmp_path / "set", change, command="fit")
    is_set_aside(done, report, channel)
    assert report["verdict"] == "fitted" and report["effects"] == []


@pytest.mark.nightly
@pytest.mark.parametrize(("change", "channel"), ASIDE.values(), ids=ASIDE)
def test_a_sensor_that_is_set_aside_does_not_hide_the_effect(program, tmp_path, change, channel):
    done, report, _ = run(program, tmp_path / "set", change)
    is_set_aside(done, report, channel)
    assert report["verdict"] == "named" and [effect["id"] for effect in report["effects"]] == ["iron_loss"]


@pytest.mark.nightly
@pytest.mark.parametrize("change", ABSENT.values(), ids=ABSENT)
def test_the_loop_closes_without_an_output(program, tmp_path, change):
    done, report, _ = run(program, tmp_path / "set", change)
    assert done.returncode in (0, 1) and report is not None, done.stdout + done.stderr
    assert (report["verdict"] == "unusable") == (done.returncode == 1)
    assert {effect["id"] for effect in report["effects"]} <= {"iron_loss"}, report["effects"]


def test_a_budget_ends_the_search(program, tmp_path):
    """The search needs more than a tenth of a second; the refit is the answer then, and the report says so."""
    done, report, _ = run(program, tmp_path / "set", lambda *_: None, "--budget", "0.2")
    assert done.returncode == 0, done.stdout + done.stderr
    assert report["budget"] == {"seconds": 0.2, "exhausted": True}
    assert any("time budget" in note for note in report["notes"])


@pytest.mark.parametrize("budget", ["0.5", "1", "1.5", "2", "2.5"])
def test_nothing_is_stated_about_data_that_were_not_checked(program, tmp_path, budget):
    """The budget ends before, during or after the checks of data with a mistake."""
    change, _ = UNUSABLE["torque with the other sign in one run"]
    done, report, _ = run(program, tmp_path / "set", change, "--budget", budget)
    assert report is not None, done.stdout + done.stderr
    if report["verdict"] != "unusable":
        assert (report["verdict"], report["effects"], report["unexplained"]) == ("nothing", [], None)
        assert report["budget"]["exhausted"]
        assert any("ended the checks" in note for note in report["notes"])


@pytest.mark.parametrize("text", ["0", "-3", "soon"])
def test_a_budget_that_is_none(program, tmp_path, text):
    done, _, _ = run(program, tmp_path / "set", lambda *_: None, f"--budget={text}")
    assert done.returncode == 2 and text in done.stderr


def test_two_rows_are_refused(program, tmp_path):
    def change(_, table):
        for column in table:
            table[column] = table[column][:2]

    done, report, _ = run(program, tmp_path / "set", change)
    assert done.returncode == 2 and report is None
    assert "run-1.csv: 2 rows count" in done.stderr


def test_fit_writes_the_same_files_and_looks_for_nothing(program, tmp_path):
    command = [program, "fit", str(FOLDER / "experiment.toml"), "--out", str(tmp_path), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["verdict"] == "fitted" and report["effects"] == []
    for name, parameter in report["parameters"].items():
        low, high = parameter["ci95"]
        assert low <= parameter["value"] <= high, name
    for error in report["error"]["test"].values():
        assert abs(error["after"] / error["refit"] - 1.0) < 1e-9
    for name in ("report.html", "preset.toml", "fmi2/AnnulusCooledMotor.fmu", "fmi3/AnnulusCooledMotor.fmu"):
        assert (tmp_path / name).is_file()
