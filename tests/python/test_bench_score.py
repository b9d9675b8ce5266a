"""Evaluation of the blind suite, on reports with known content: outcomes, rates, intervals, errors, and the run of a program."""

import json
import os
import sys
from copy import deepcopy

import pytest
from bench import judge as j
from bench import make, page, run, score

PORT, DRIVER = "drag_torque", "speed"
CHANNELS = ("voltage_V", "housing_temperature_degC")


def truth(ids=(), unlisted=False, detectable=True, name="bench-1-0"):
    effects = [{"id": i, "parameters": {"k": 2.0, "node": "housing"}, "detectable": detectable} for i in ids]
    other = {"shape": "drag_power_075", "port": PORT, "driver": DRIVER, "detectable": detectable} if unlisted else None
    return {
        "name": name,
        "effects": effects,
        "unexplained": other,
        "parameters": {"motor.R_ref": 0.4, "thermal.C_h": 160.0},
        "sensors": [],
        "detectable": detectable and bool(effects or other),
        "rmse": {"test": {c: {"before": 3.0, "floor": 0.1} for c in CHANNELS}},
    }


def report(verdict, *ids, alternatives=(), unexplained=None):
    interval = {"value": 2.0, "ci95": [1.9, 2.1]}
    return {
        "verdict": verdict,
        "seconds": 3.0,
        "effects": [{"id": i, "alternatives": list(alternatives), "parameters": {"k": interval}} for i in ids],
        "unexplained": dict(zip(("port", "driver"), unexplained)) if unexplained else None,
        "parameters": {"motor.R_ref": {"value": 0.4, "ci95": [0.39, 0.41]}, "thermal.C_h": {"value": 170.0, "ci95": [165.0, 175.0]}},
        "error": {"test": {c: {"before": 3.0, "refit": 0.2, "after": 0.104, "floor": 0.1} for c in CHANNELS}},
    }


NOTHING = report("nothing")
IRON = truth(["iron_loss"])
DRAG = truth(unlisted=True)
UNSEEN = truth(["iron_loss"], detectable=False)
BOTH = truth(["contact_drop"], unlisted=True)
TWO = truth(["iron_loss", "contact_drop"])


@pytest.mark.parametrize(
    ("true", "said", "outcome"),
    [
        (truth(), NOTHING, j.RIGHT),
        (truth(), report("named", "iron_loss"), j.FALSE_ALARM),
        (truth(), report("class", "iron_loss", alternatives=["windage"]), j.FALSE_ALARM),
        (truth(), report("unexplained", unexplained=(PORT, DRIVER)), j.FALSE_ALARM),
        (IRON, report("named", "iron_loss"), j.RIGHT),
        # Alternatives that were beaten do not make a class of a name.
        (IRON, report("named", "iron_loss", alternatives=["windage"]), j.RIGHT),
        (IRON, report("named", "windage", alternatives=["iron_loss"]), j.WRONG_NAME),
        (IRON, report("named", "iron_loss", "windage"), j.WRONG_NAME),
        (IRON, report("class", "windage", alternatives=["iron_loss"]), j.CLASS_WITH),
        (IRON, report("class", "windage", "iron_loss"), j.CLASS_WITH),
        (IRON, report("class", "windage", alternatives=["viscous_friction"]), j.CLASS_WITHOUT),
        (IRON, report("unexplained", unexplained=(PORT, DRIVER)), j.UNEXPLAINED),
        (IRON, NOTHING, j.MISSED),
        (IRON, None, j.NO_REPORT),
        (UNSEEN, NOTHING, j.HIDDEN),
        (UNSEEN, report("named", "iron_loss"), j.HIDDEN),
        (UNSEEN, report("named", "windage"), j.WRONG_NAME),
        (TWO, report("named", "iron_loss", "contact_drop"), j.RIGHT),
        (TWO, report("named", "iron_loss"), j.MISSED),
        (DRAG, report("unexplained", unexplained=(PORT, DRIVER)), j.RIGHT),
        (DRAG, report("unexplained", j.GENERIC, unexplained=(PORT, DRIVER)), j.RIGHT),
        (DRAG, report("unexplained", unexplained=(PORT, "current")), j.PORT_ONLY),
        (DRAG, report("unexplained", unexplained=("fan_flow", DRIVER)), j.WRONG_PORT),
        (DRAG, report("named", "iron_loss"), j.WRONG_NAME),
        (DRAG, report("class", "iron_loss", alternatives=["windage"]), j.WRONG_NAME),
        (DRAG, NOTHING, j.MISSED),
        (truth(unlisted=True, detectable=False), NOTHING, j.HIDDEN),
        (BOTH, report("unexplained", "contact_drop", unexplained=(PORT, DRIVER)), j.RIGHT),
        (BOTH, report("unexplained", unexplained=(PORT, DRIVER)), j.UNEXPLAINED),
        (BOTH, report("named", "contact_drop"), j.MISSED),
    ],
)
def test_outcome(true, said, outcome):
    assert j.judge(true, said).outcome == outcome


def test_a_verdict_that_is_none_is_an_error():
    with pytest.raises(ValueError, match="perhaps"):
        j.judge(IRON, report("perhaps"))


def test_a_term_that_follows_nothing_has_no_driver():
    said = report("unexplained", unexplained=(PORT, None))
    assert j.judge(DRAG, said).outcome == j.PORT_ONLY and j.judge(DRAG, said).said == f"{PORT}, constant"
    del said["unexplained"]["driver"]
    assert j.judge(DRAG, said).outcome == j.PORT_ONLY


@pytest.mark.parametrize("missing", ["verdict", "parameters", "error", "seconds"])
def test_a_report_that_breaks_the_contract_is_none(suite, missing):
    folder = suite[0] / "bench-1-0"
    (folder / "result").mkdir()
    said = report("named", "iron_loss")
    del said[missing]
    (folder / "result" / "report.json").write_text(json.dumps(said))
    (folder / "result" / "run.json").write_text(json.dumps({"exit_code": 0}))
    one = run.judged(folder)
    assert one.outcome == j.NO_REPORT and f"'{missing}'" in one.sentence and one.parameters == 0


def test_port_and_driver_are_counted_apart():
    for said, port, driver in ((("fan_flow", DRIVER), False, True), ((PORT, "current"), True, False)):
        one = j.judge(DRAG, report("unexplained", unexplained=said))
        assert (one.port, one.driver) == (port, driver)
    assert (j.judge(DRAG, NOTHING).port, j.judge(DRAG, None).driver) == (False, False)
    assert j.judge(IRON, NOTHING).port is None and j.judge(truth(unlisted=True, detectable=False), NOTHING).port is None


def test_intervals_are_of_parameters_and_of_effects_that_were_found():
    null = j.judge(truth(), NOTHING)
    found, other = (j.judge(IRON, report("named", name)) for name in ("iron_loss", "windage"))
    assert (null.inside, null.parameters) == (1, 2)
    assert (found.inside, found.parameters) == (2, 3)
    assert (other.inside, other.parameters) == (1, 2)
    without = deepcopy(NOTHING)
    del without["parameters"]["motor.R_ref"]
    assert (j.judge(truth(), without).inside, j.judge(truth(), without).parameters) == (0, 2)


def test_errors_are_of_the_worst_channel_with_a_living_sensor():
    said = report("named", "iron_loss")
    said["error"]["test"][CHANNELS[1]]["after"] = 0.3
    one = j.judge(IRON, said)
    assert one.over_floor == pytest.approx(3.0) and one.over_refit == pytest.approx(((1.04**2 + 9.0) / 8.0) ** 0.5)
    dead = deepcopy(IRON) | {"sensors": [{"kind": "dead", "channel": CHANNELS[1]}]}
    assert j.judge(dead, said).over_floor == pytest.approx(1.04)


def ten(wrong=0):
    """Ten listed sets, ten in no list, five null; the first few of each kind are wrong."""
    sets = []
    for k in range(10):
        name = "windage" if k < wrong else "iron_loss"
        sets.append(j.judge(truth(["iron_loss"], name=f"bench-1-{k}"), report("named", name), {"seconds": 2.0 + k, "memory_MB": 90.0}))
        port = "fan_flow" if k < wrong else PORT
        sets.append(j.judge(truth(unlisted=True, name=f"bench-1-{k + 10}"), report("unexplained", unexplained=(port, DRIVER))))
        if k < 5:
            sets.append(j.judge(truth(name=f"bench-1-{k + 20}"), report("named", "windage") if k < wrong else NOTHING))
    return sets


def test_rates_against_their_bars():
    named, wrong, alarms, port, driver, inside, lost = score.rates(ten())
    assert all(rate.met for rate in (named, wrong, alarms, port, driver, lost)) and not inside.met
    assert (inside.hits, inside.of) == (35, 60)
    named, wrong, alarms, port, driver, *_ = score.rates(ten(1))
    assert [(r.hits, r.of, r.met) for r in (named, wrong, alarms, port, driver)] == [
        (9, 10, False),
        (1, 20, False),
        (1, 5, False),
        (9, 10, False),
        (10, 10, True),
    ]
    assert score.rates([j.judge(IRON, None)])[-1].met is False
    assert score.Rate("a", 0, 0, least=0.9).met and score.Rate("a", 9, 10, least=0.9).met


def test_what_the_bars_hide_is_counted():
    sets = [j.judge(IRON, said) for said in (report("class", "iron_loss", "windage"), report("named", "iron_loss"), NOTHING)]
    sets += [j.judge(UNSEEN, NOTHING)]
    either, classes, missed, hidden, *_, worse = score.further(sets)
    assert [(r.hits, r.of) for r in (either, classes, missed, hidden, worse)] == [(2, 3), (1, 3), (1, 3), (1, 4), (0, 4)]
    worst = report("named", "iron_loss")
    worst["error"]["test"] = {c: {"refit": 0.1, "after": 0.102, "floor": 0.1} for c in CHANNELS}
    assert score.further([j.judge(IRON, worst)])[-1].hits == 1
    listed, *_, seconds, memory = score.spreads(ten())
    assert "median 1.04" in listed.text and "10 of 10 within 1.05" in listed.text
    assert "worst 11" in seconds.text and "19 of 25 within 5" in seconds.text and "worst 90" in memory.text


def test_the_table_has_every_truth_and_the_page_every_failure(tmp_path):
    sets = ten(2)
    rows = page.confusion(sets).splitlines()
    assert rows[0] == "| truth | kind | sets | right | wrong port | wrong name | false alarm | reported instead |"
    assert rows[2:] == [
        "| nothing | null | 5 | 3 |  |  | 2 | windage (2) |",
        "| iron_loss | listed | 10 | 8 |  | 2 |  | windage (2) |",
        "| drag_power_075 | unlisted | 10 | 8 | 2 |  |  | fan_flow by speed (2) |",
        "| **all** |  | 25 | 19 | 2 | 2 | 2 |  |",
    ]
    page.write_page(tmp_path / "blind.md", sets, ["bench-1-0: a sentence"], "a command")
    text = (tmp_path / "blind.md").read_text()
    assert "- bench-1-0: a sentence\n" in text and "generated by `a command`." in text and "](blind.svg)" in text
    assert "| 80.0% (8 of 10) | >= 95% | **missed** |" in text
    rows, columns, grid = page.cells(sets)
    assert rows == ["nothing (5)", "iron_loss (10)", "drag_power_075 (10)"] and columns[0] == "nothing"
    assert [[count for count, _ in row] for row in grid].count([0] * len(columns)) == 0
    colours = [colour for row in grid for _, colour in row]
    assert colours.count(page.shade(0.2, False)) == 2 and colours.count(page.shade(0.8, True)) == 2
    assert (tmp_path / "blind.svg").read_text().count(">windage</text>") == 1


STAND_IN = """#!{python}
import json, pathlib, sys
command, experiment, flag, out = sys.argv[1:]
assert (command, flag) == ("close-loop", "--out")
folder, out = pathlib.Path(experiment).parent, pathlib.Path(out)
if folder.name == "bench-1-2":
    (out / "report.json").write_text((folder.parent / "report").read_text())
    print("run-1.csv:7: time runs backwards", file=sys.stderr)
    sys.exit(2)
with (folder.parent / "asked").open("a") as asked:
    asked.write(folder.name + chr(10))
(out / "fmi2").mkdir()
(out / "fmi2" / "a.fmu").write_text("large")
(out / "report.json").write_text((folder.parent / "report").read_text())
"""


@pytest.fixture
def suite(tmp_path):
    """Three sets, and a program that says of the first two that there is iron loss and cannot do the third."""
    sets = tmp_path / "sets"
    for number in (0, 1, 2):
        folder = sets / f"bench-1-{number}"
        folder.mkdir(parents=True)
        (folder / "truth.json").write_text(json.dumps(truth(["iron_loss"] if number == 0 else [], name=folder.name)))
        (folder / "experiment.toml").write_text("")
    (sets / "report").write_text(json.dumps(report("named", "iron_loss")))
    script = tmp_path / "bin" / "motor-fmu"
    script.parent.mkdir()
    script.write_text(STAND_IN.replace("{python}", sys.executable))
    script.chmod(0o755)
    if os.name != "nt":
        return sets, script
    program = script.with_suffix(".cmd")  # where a script does not say who runs it
    program.write_text(f'@"{sys.executable}" "{script}" %*\n')
    return sets, program


def test_a_program_is_asked_once_about_each_set_and_counted(suite, capsys):
    sets, program = suite
    ask = [str(sets), "--program", str(program), "--jobs", "2"]
    run.main(ask)
    out = capsys.readouterr().out
    assert sorted((sets / "asked").read_text().split()) == ["bench-1-0", "bench-1-1"]
    assert "bench-1-1" in out and "false alarm: true effect nothing, reported iron_loss" in out
    assert "bench-1-2" in out and "no report: exit code 2" in out and "run-1.csv:7: time runs backwards" in out
    assert not list(sets.rglob("*.fmu"))
    kept = json.loads((sets / "bench-1-0" / "result" / "run.json").read_text())
    assert kept["exit_code"] == 0 and (1.0 < kept["memory_MB"] < 500.0 if hasattr(os, "wait4") else kept["memory_MB"] is None) and 0.0 < kept["seconds"] < 60.0
    # What the same program has said of the same set is kept; another set or program is run again.
    run.main(ask)
    assert len((sets / "asked").read_text().split()) == 2
    (sets / "bench-1-1" / "experiment.toml").write_text("# changed\n")
    run.main(ask)
    assert len((sets / "asked").read_text().split()) == 3
    program.write_text(program.read_text() + "\n")
    run.main([*ask, "--count", "1"])
    assert len((sets / "asked").read_text().split()) == 4

    assert score.main([str(sets), "--page", str(sets / "page.md"), "--command", "cargo"]) == 1
    out = capsys.readouterr().out
    assert "correctly named, of detectable listed effects: 100.0% (1 of 1), criterion >= 95%   met" in out
    assert "false alarms, of sets without an effect: 50.0% (1 of 2), criterion <= 1%   NOT MET" in out
    assert "sets without a report: 33.3% (1 of 3), criterion <= 0%   NOT MET" in out
    assert "- bench-1-2: no report: true effect nothing, reported no report (exit code 2" in (sets / "page.md").read_text()


def test_a_program_that_hangs_is_stopped(tmp_path):
    code, seconds, _ = run.measured([sys.executable, "-c", "import time; time.sleep(60)"], tmp_path / "stderr", 0.5)
    assert code != 0 and 0.4 < seconds < 20.0


def test_sets_of_a_folder_are_in_order(tmp_path):
    for number in (10, 2, 1):
        (tmp_path / f"bench-1-{number}").mkdir()
        (tmp_path / f"bench-1-{number}" / "truth.json").write_text("{}")
    (tmp_path / "bench-1-3").mkdir()
    assert [s.name for s in run.in_order(tmp_path)] == ["bench-1-1", "bench-1-2", "bench-1-10"]


def test_judges_are_no_part_of_the_generator(monkeypatch):
    assert all((make.Path(make.__file__).parent / f"{name}.py").exists() for name in make.JUDGES)
    before = make.fingerprint()
    monkeypatch.setattr(make, "JUDGES", ())
    assert make.fingerprint() != before
