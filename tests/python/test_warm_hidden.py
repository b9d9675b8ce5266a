"""`motor-fmu close-loop` finds hidden states also in runs that start warm."""

import json
import subprocess

import pytest
import warm_hidden
from warm_hidden import CASES, NOISE

SEED = 3
EVERYDAY = "mass on the housing, hotter"
NAMES = [name if name == EVERYDAY else pytest.param(name, marks=pytest.mark.nightly) for name in CASES]


@pytest.mark.parametrize("name", NAMES)
def test_a_hidden_state_is_found_where_it_started(name, program, tmp_path):
    case = CASES[name]
    path, above = warm_hidden.write(name, SEED, tmp_path)
    command = [program, "close-loop", str(path), "--out", str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["replay"]["agrees"]
    assert report["effects"][0]["port"] == case.port, report["effects"]
    lag = report["effects"][0]["law"]["lag"]
    assert (lag["driver"], lag.get("difference", False)) == (case.driver, case.mass)
    assert lag["tau"] == pytest.approx(case.tau, rel=0.1)
    for column, error in report["error"]["test"].items():
        assert error["after"] < 1.3 * NOISE[column], (column, error)
    start = report["replay"]["start_values"]["run-4.csv"]["initial.term_lag_1"]
    assert start == pytest.approx(above, abs=0.1 * max(abs(above), 0.02))
