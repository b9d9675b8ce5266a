"""What loggers and instruments do is neither traced to an effect, nor does it spoil the model."""

import json
import subprocess

import acquisition
import pytest
from acquisition import CASES

SEED = 3
EVERYDAY = "scans of 15 s, viscous friction"
NAMES = [name if name == EVERYDAY else pytest.param(name, marks=pytest.mark.nightly) for name in CASES]


@pytest.mark.parametrize("name", NAMES)
def test_the_mistake_is_named_and_the_motor_is_found(name, program, tmp_path):
    mistake = CASES[name]
    path = acquisition.write(mistake, SEED, tmp_path)
    command = [program, "close-loop", str(path), "--out", str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    if report["verdict"] == "unusable":
        assert report["unusable"]["channel"] == mistake.channel, report["unusable"]
        files = [f"run-{run + 1}.csv" for run in mistake.runs] + ["every run"] * (mistake.runs == acquisition.ALL)
        assert any(file in report["unusable"]["reason"] for file in files), report["unusable"]
        return
    assert done.returncode == 0, done.stdout + done.stderr
    assert [f"effect.{e['id']}" for e in report["effects"]] == [key.rpartition(".")[0] for key in mistake.effect], report["notes"]
    assert any(mistake.note in note for note in report["notes"]), report["notes"]
    # The test run is that of the motor, whatever was left out of the fit.
    for column, error in report["error"]["test"].items():
        assert error["after"] < 1.3 * error["floor"] * mistake.rows**0.5, (column, error)
    assert report["explains_data"] and report["replay"]["agrees"]
