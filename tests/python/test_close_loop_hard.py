"""Sets of the blind suite that were wrong once, each for another reason: generated, run and evaluated again."""

import json
import subprocess

import pytest
from bench.judge import FINE, judge
from bench.make import draw_set
from bench.write import write_set

SEED = 2028
HARD = {
    53: "driven by a voltage with no current for most of the time: what makes the model deaf would explain the voltage's noise",
    57: "a drop, and a drag that latches in the validation run only: what the drop explains is predicted better, the rest is new",
    77: "a thermostat: it switches by the temperature that was measured, not by that of a model without it",
    79: "heat that leaves a warm housing is a conductance, and follows the housing",
    86: "a stator node and a resistance that grows with the current: alone, each predicts worse",
}


# A minute and a half of computing time each.
LONG = (77,)
SETS = [pytest.param(n, id=f"set {n}", marks=[pytest.mark.nightly] * (n in LONG)) for n in HARD]


@pytest.mark.parametrize("number", SETS)
def test_what_was_wrong_once_is_right(number, program, tmp_path):
    folder = tmp_path / "set"
    write_set(draw_set(SEED, number), folder)
    command = [program, "close-loop", str(folder / "experiment.toml"), "--out", str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode in (0, 1), done.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    one = judge(json.loads((folder / "truth.json").read_text()), report)
    assert one.outcome in FINE, f"{one.sentence}: {HARD[number]}"
    assert one.port in (None, True), one.said
