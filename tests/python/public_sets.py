"""The public synthetic sets of tests/reference/bench-synthetic: `motor-fmu close-loop` on one of them, and its report compared with the truth."""

import json
import subprocess

import pytest
from clients.paths import ROOT

SETS = ROOT / "tests" / "reference" / "bench-synthetic"


def closed(program, name, out):
    """What `close-loop --json` prints on a set; a machine in use needs more than the default budget."""
    command = [program, "close-loop", str(SETS / name / "experiment.toml"), "--out", str(out), "--json", "--budget", "300"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def truth(name):
    return json.loads((SETS / name / "truth.json").read_text())


def holds(estimate, true):
    low, high = estimate["ci95"]
    return low <= true <= high


def inside(report, name):
    """The declared parameters whose true values are inside their intervals."""
    true = truth(name)["parameters"]
    assert report["parameters"].keys() == true.keys() and len(true) == 8
    return [parameter for parameter, value in true.items() if holds(report["parameters"][parameter], value)]


def has_the_errors_of_the_truth(report, name, beside_floor):
    """Errors before and of the refit are those of the truth; in the test run, those after are near its floor and never above the refit's.

    Four runs one after the other, whose channels move together: the intake has nothing to note. A law is finally estimated from the
    validation run, too.
    """
    known = ("the exported FMUs start in the modes", "the repaired model (after) was finally estimated from the fit")
    assert all(note.startswith(known) for note in report["notes"]), report["notes"]
    beside_refit = 1.01 if report["verdict"] == "nothing" else 1.0
    for role, channels in truth(name)["rmse"].items():
        assert channels.keys() == report["error"][role].keys() and len(channels) == 4
        for column, true in channels.items():
            error = report["error"][role][column]
            assert error["before"] == pytest.approx(true["before"], rel=2e-3), (role, column)
            # A refit may stop a little elsewhere than another fitter's.
            assert error["refit"] == pytest.approx(true["refit"], rel=0.05), (role, column)
            if role == "test":
                assert error["after"] <= beside_floor * true["floor"], (column, error, true)
                assert error["after"] <= beside_refit * error["refit"], (column, error)


def named(report, effect):
    """The parameters of the only effect, which is this one in all runs."""
    assert report["verdict"] == "named"
    (found,) = report["effects"]
    assert (found["id"], found["everywhere"]) == (effect, True)
    return found["parameters"]
