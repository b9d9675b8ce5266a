"""Evaluation of the blind suite, on reports with known content: outcomes, rates and their bounds, pages, and the run
of a program.
"""

import json
import os
import sys

import pytest
from blind import judge as j
from blind import make, page, run, score

CHANNELS = ("voltage_V", "housing_temperature_degC")
DRAG = {"id": "function", "port": "drag_torque", "driver": "speed", "drivers": ["speed"], "parameters": {"size": 1.0}}


def truth(kind=j.NULL, names=(), law=None, mistake=None, visible=True, name="blind-1-0", structure=0.0):
    return {
        "name": name,
        "kind": kind,
        "effects": [{"id": i, "parameters": {"k": 2.0, "node": "housing"}} for i in names],
        "law": law,
        "mistake": mistake,
        "parameters": {"motor.R_ref": 0.4, "thermal.C_h": 160.0},
        "effective_parameters": {"motor.R_ref": 0.4, "thermal.C_h": 170.0},
        "floor": {"test": dict.fromkeys(CHANNELS, 0.1)},
        "structure_error_max": structure,
        "structure_error_test": dict.fromkeys(CHANNELS, structure),
        "true_of_structure": {"ports": ["heat_capacity"], "effects": ["stator_node"]}
        if structure
        else {"ports": [], "effects": []},
        "wrong_prior": False,
        "warm": False,
        "signal": 5.0 if visible else 0.5,
        "detectable": visible,
        "drivers": ["speed", "current"],
        "ports": ["drag_torque"],
    }


def report(verdict, *ids, alternatives=(), law=None, lag=None, channel=None, notes=(), after=0.104):
    interval = {"value": 2.0, "ci95": [1.9, 2.1]}
    effects = [{"id": i, "alternatives": list(alternatives), "parameters": {"k": interval}} for i in ids]
    if lag:
        effects.append({"id": "generic_term", "parameters": {}, "law": {"port": law[0], "lag": lag}})
    return {
        "verdict": verdict,
        "effects": effects,
        "unexplained": {"port": law[0], "driver": law[1]} if law else None,
        "unusable": {"channel": channel, "reason": "unit", "suggestion": "rpm"} if channel else None,
        "notes": list(notes),
        "parameters": {
            "motor.R_ref": {"value": 0.4, "ci95": [0.39, 0.41]},
            "thermal.C_h": {"value": 170.0, "ci95": [165.0, 175.0]},
        },
        "error": {
            "test": {c: {"before": 3.0, "refit": 0.2, "after": after, "blackbox": 0.3, "floor": 0.1} for c in CHANNELS}
        },
    }


NOTHING = report("nothing")
MASS = ("winding_heat", "winding_temperature")
RPM = {"id": "rpm", "channels": ["speed_rad_per_s"], "answers": ["unusable", "refused"]}
FROZEN = {"id": "frozen", "channels": ["winding_temperature_degC"], "answers": ["set aside"]}
HARMLESS = {"id": "foreign_csv", "channels": [], "answers": ["works"]}
LISTED = truth(j.LISTED, ["iron_loss"])
HIDDEN = truth(j.LISTED, ["iron_loss"], visible=False)
LAW = truth("function", law=DRAG)
ROUGH = truth(structure=3.0)


@pytest.mark.parametrize(
    ("true", "said", "outcome"),
    [
        (truth(), NOTHING, j.RIGHT),
        (truth(), report("named", "iron_loss"), j.FALSE_ALARM),
        (truth(), report("unexplained", law=("fan_flow", "time")), j.FALSE_ALARM),
        (truth(), report("unusable", channel="voltage"), j.REFUSED_GOOD),
        (truth(), None, j.NO_REPORT),
        # What the specimen has beyond two nodes may be stated, nothing else.
        (ROUGH, report("named", "stator_node"), j.STRUCTURE),
        (ROUGH, report("unexplained", law=("heat_capacity", "time")), j.STRUCTURE),
        (ROUGH, report("named", "stator_node", "windage"), j.FALSE_ALARM),
        # A mass at a node is a heat capacity; a heat over a lag is none, and there is none without structure.
        (ROUGH, report("unexplained", law=MASS, lag={"tau": 9.0, "difference": True}), j.STRUCTURE),
        (ROUGH, report("unexplained", law=MASS, lag={"tau": 9.0, "difference": False}), j.FALSE_ALARM),
        (truth(), report("unexplained", law=MASS, lag={"tau": 9.0, "difference": True}), j.FALSE_ALARM),
        # Beside a law as well, an effect with alternatives is not named.
        (ROUGH, report("unexplained", "windage", alternatives=["stator_node"], law=("heat_capacity", "time")), j.STRUCTURE),
        (ROUGH, report("unexplained", "windage", law=("heat_capacity", "time")), j.FALSE_ALARM),
        (LISTED, report("named", "iron_loss"), j.RIGHT),
        # Alternatives that were rejected do not make a class of a name.
        (LISTED, report("named", "iron_loss", alternatives=["windage"]), j.RIGHT),
        (LISTED, report("named", "windage"), j.WRONG_NAME),
        (LISTED, report("named", "iron_loss", "windage"), j.WRONG_NAME),
        (LISTED, report("class", "iron_loss", alternatives=["windage"]), j.CLASS_WITH),
        (LISTED, report("class", "windage", alternatives=["contact_drop"]), j.WRONG_NAME),
        (LISTED, report("unexplained", law=("drag_torque", "speed")), j.UNEXPLAINED),
        (LISTED, NOTHING, j.MISSED),
        (HIDDEN, NOTHING, j.BELOW),
        (HIDDEN, report("named", "windage"), j.WRONG_NAME),
        (LAW, report("unexplained", law=("drag_torque", "current")), j.RIGHT),
        (LAW, report("unexplained", law=("drag_torque", "time")), j.PORT_ONLY),
        (LAW, report("unexplained", law=("fan_flow", "speed")), j.WRONG_PORT),
        (LAW, report("named", "iron_loss"), j.WRONG_NAME),
        (LAW, NOTHING, j.MISSED),
        (truth(j.MISTAKE, mistake=RPM), report("unusable", channel="speed_rad_per_s"), j.RIGHT),
        (truth(j.MISTAKE, mistake=RPM), report("unusable", channel="voltage_V"), j.OTHER_CHANNEL),
        (truth(j.MISTAKE, mistake=RPM), report("named", "iron_loss"), j.TRACED),
        (truth(j.MISTAKE, mistake=RPM), NOTHING, j.UNNOTICED),
        (
            truth(j.MISTAKE, mistake=FROZEN),
            report("nothing", notes=["run-1.csv: winding_temperature_degC is set aside"]),
            j.RIGHT,
        ),
        (truth(j.MISTAKE, mistake=FROZEN), report("nothing", notes=["run-1.csv: voltage_V is set aside"]), j.UNNOTICED),
        (
            truth(j.MISTAKE, mistake=FROZEN),
            report("named", "windage", notes=["winding_temperature_degC is set aside"]),
            j.TRACED,
        ),
        # The same of a specimen that has what is named, with the mistake recognised and without.
        (
            truth(j.MISTAKE, mistake=FROZEN, structure=3.0),
            report("named", "stator_node", notes=["winding_temperature_degC is set aside"]),
            j.RIGHT,
        ),
        (truth(j.MISTAKE, mistake=FROZEN, structure=3.0), report("named", "stator_node"), j.UNNOTICED),
        (truth(j.MISTAKE, mistake=FROZEN, structure=3.0), report("named", "windage"), j.TRACED),
        (truth(j.MISTAKE, mistake=HARMLESS, structure=3.0), report("named", "stator_node"), j.RIGHT),
        (truth(j.MISTAKE, mistake=HARMLESS, structure=3.0), report("named", "windage"), j.FALSE_ALARM),
        (truth(j.MISTAKE, mistake=HARMLESS), NOTHING, j.RIGHT),
        (truth(j.MISTAKE, mistake=HARMLESS), report("unusable", channel="voltage_V"), j.REFUSED_GOOD),
    ],
)
def test_outcome(true, said, outcome):
    assert j.judge(true, said).outcome == outcome


def test_refused_input_needs_a_message():
    for error, outcome in (("run-1.csv:7: unit", j.RIGHT), ("", j.NO_REPORT)):
        assert j.judge(truth(j.MISTAKE, mistake=RPM), None, {"exit_code": 2, "error": error}).outcome == outcome
    assert j.judge(truth(j.MISTAKE, mistake=FROZEN), None, {"exit_code": 2, "error": "no"}).outcome == j.REFUSED_GOOD


def test_numbers_of_a_set():
    one = j.judge(LISTED, report("named", "iron_loss"), {"seconds": 3.0, "cpu_seconds": 2.0, "memory_MB": 50.0})
    # C_h of the specimen is outside its interval, that of the best two-node model is inside.
    assert (one.inside, one.parameters) == (3, 3) and (one.effective_inside, one.effective_parameters) == (2, 2)
    assert one.over_floor == pytest.approx({"before": 30.0, "refit": 2.0, "after": 1.04, "blackbox": 3.0})
    assert one.over_refit == pytest.approx(0.52) and one.cpu == 2.0
    assert j.judge(ROUGH, NOTHING).over_model["refit"] == pytest.approx(2.0 / 10.0**0.5)
    assert j.judge(ROUGH, NOTHING).parameters == 0 and j.judge(LAW, NOTHING).port is False
    assert j.judge(truth() | {"wrong_prior": True}, NOTHING).parameters == 0


def test_the_criterion_states_which_parameters_are_compared():
    now = j.judge(truth(structure=j.LOW), NOTHING)
    assert (now.inside, now.parameters) == (2, 2)
    stored = {name: value for name, value in vars(now).items() if name != "compared"}
    for one, whose in ((now, j.BEST), (j.Judged(**stored), j.SPECIMEN)):
        assert any(r.what == f"true parameters ({whose}) inside their 95 % interval" for r in score.criteria([one]))


def sets(wrong: int, count: int = 100):
    return [
        j.judge(truth(), report("named", "windage") if k < wrong else NOTHING, {"seconds": 1.0}) for k in range(count)
    ]


def test_a_criterion_is_judged_by_the_bound_of_the_interval():
    alarms = lambda group: next(r for r in score.criteria(group) if r.what.startswith("false alarms"))  # noqa: E731
    assert alarms(sets(0)).verdict == score.SHOWN
    assert alarms(sets(0, 30)).verdict == score.OPEN and alarms(sets(2)).verdict == score.OPEN
    assert alarms(sets(12)).verdict == score.MISSED
    # Clopper and Pearson: 3 of 20 is 3.2 to 37.9 %.
    assert score.Rate("", 3, 20).interval == pytest.approx((0.0321, 0.3789), abs=1e-4)
    assert score.Rate("", 97, 100, least=0.95, bound=0.90).verdict == score.SHOWN
    assert score.Rate("", 96, 100, least=0.95).verdict == score.OPEN
    worse = [j.judge(LISTED, report("named", "iron_loss", after=0.206), {"seconds": 1.0})]
    assert next(r for r in score.criteria(worse) if "refit's by more" in r.what).hits == 1


def test_the_page_keeps_the_tables_of_all_seeds(tmp_path):
    tables = []
    for seed, date, wrong in (("7", "2026-01-02", 2), ("9", "2026-01-01", 0)):
        group = sets(wrong)
        group[0].budget = 90.0 if wrong else 45.0
        tables.append({"seed": seed, "date": date, "command": f"seed {seed}", "sets": [vars(s) for s in group]})
        (tmp_path / f"{seed}.json").write_text(json.dumps(tables[-1]))
    page.write_page(tmp_path / "page.md", tmp_path)
    text = (tmp_path / "page.md").read_text()
    assert text.index("## Seed 7") < text.index("## Seed 9") and "generated by `seed 7`" in text
    assert text.count("90 s of wall time instead of 45 s") == 1
    assert "- blind-1-0: false alarm: nothing" in text and "| null | 100 | 98 | 2 |" in text


STAND_IN = """#!{python}
import json, pathlib, sys
command, experiment, flag, out = sys.argv[1:5]
assert (command, flag) == ("close-loop", "--out")
folder, out = pathlib.Path(experiment).parent, pathlib.Path(out)
if folder.name == "blind-1-2":
    print("run-1.csv:7: time runs backwards", file=sys.stderr)
    sys.exit(2)
with (folder.parent / "asked").open("a") as asked:
    asked.write(folder.name + " ".join(sys.argv[5:]) + chr(10))
(out / "fmi2").mkdir()
(out / "fmi2" / "a.fmu").write_text("large")
(out / "report.json").write_text((folder.parent / "report").read_text())
"""


@pytest.fixture
def suite(tmp_path):
    """Three sets, and a program that reports iron loss in the first two and refuses the third."""
    folders = tmp_path / "sets"
    for number in (0, 1, 2):
        folder = folders / f"blind-1-{number}"
        folder.mkdir(parents=True)
        content = truth(j.LISTED, ["iron_loss"], name=folder.name) if number == 0 else truth(name=folder.name)
        (folder / "truth.json").write_text(json.dumps(content))
        (folder / "experiment.toml").write_text("")
    (folders / "report").write_text(json.dumps(report("named", "iron_loss")))
    script = tmp_path / "bin" / "motor-fmu"
    script.parent.mkdir()
    script.write_text(STAND_IN.replace("{python}", sys.executable))
    script.chmod(0o755)
    if os.name != "nt":
        return folders, script
    program = script.with_suffix(".cmd")
    program.write_text(f'@"{sys.executable}" "{script}" %*\n')
    return folders, program


def test_a_program_runs_once_on_each_set_and_is_counted(suite, capsys):
    folders, program = suite
    ask = [str(folders), "--program", str(program), "--jobs", "2"]
    run.main(ask)
    out = capsys.readouterr().out
    assert sorted((folders / "asked").read_text().split()) == ["blind-1-0", "blind-1-1"]
    assert "blind-1-1" in out and "false alarm" in out and "run-1.csv:7: time runs backwards" in out
    assert not list(folders.rglob("*.fmu"))
    kept = json.loads((folders / "blind-1-0" / "result" / "run.json").read_text())
    assert kept["exit_code"] == 0 and 0.0 < kept["seconds"] < 60.0
    if hasattr(os, "wait4"):
        assert 1.0 < kept["memory_MB"] < 500.0 and 0.0 < kept["cpu_seconds"] < 60.0
    # A result of the same program and set is kept; another set, program or budget is run again.
    run.main(ask)
    assert len((folders / "asked").read_text().split()) == 2
    (folders / "blind-1-1" / "experiment.toml").write_text("# changed\n")
    run.main(ask)
    assert len((folders / "asked").read_text().split()) == 3
    program.write_text(program.read_text() + "\n")
    run.main([*ask, "--count", "1", "--budget", "90"])
    assert (folders / "asked").read_text().split()[-2:] == ["blind-1-0--budget", "90"]
    arguments = ["--tables", str(folders / "tables"), "--page", str(folders / "page.md"), "--command", "cargo"]
    assert score.main([str(folders), *arguments]) == 1
    assert "false alarms, of sets without an effect: 50.0% (1 of 2" in capsys.readouterr().out
    text = (folders / "page.md").read_text()
    assert "- blind-1-2: no report" in text and "run-1.csv:7: time runs backwards" in text
    assert len(json.loads((folders / "tables" / "1.json").read_text())["sets"]) == 3


def test_a_program_that_hangs_is_stopped(tmp_path):
    code, seconds, *_ = run.measured([sys.executable, "-c", "import time; time.sleep(60)"], tmp_path / "stderr", 0.5)
    assert code != 0 and 0.4 < seconds < 20.0


def test_the_evaluation_is_no_part_of_the_generator(monkeypatch):
    assert all((make.Path(make.__file__).parent / f"{name}.py").exists() for name in make.EVALUATION)
    before = make.fingerprint()
    monkeypatch.setattr(make, "EVALUATION", ())
    assert make.fingerprint() != before
