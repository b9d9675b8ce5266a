"""The answer of `motor-fmu close-loop` does not depend on the rate of the logger."""

import json
import math
import re
import subprocess

import logging_rate
import pytest
from logging_rate import CASES, COLUMNS, OUTPUTS, TRUE

SEED = 20
EVERYDAY = "viscous friction, 10 Hz"
SHORT = 0.13  # greatest duration of a mean in a gait cycle of 1 s
NAMES = [name if name == EVERYDAY else pytest.param(name, marks=pytest.mark.nightly) for name in CASES]


@pytest.mark.parametrize("name", NAMES)
def test_a_fast_logger_has_the_answer_of_a_slow_one(name, program, tmp_path):
    case = CASES[name]
    path = logging_rate.write(case, SEED, tmp_path)
    command = [program, "close-loop", str(path), "--out", str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["replay"]["agrees"]
    assert [f"effect.{e['id']}" for e in report["effects"]] == [key.rpartition(".")[0] for key in case.effect]
    found = dict(report["parameters"])
    for effect in report["effects"]:
        found |= {f"effect.{effect['id']}.{symbol}": value for symbol, value in effect["parameters"].items()}
    for parameter, true in {**TRUE, **case.effect}.items():
        least, most = found[parameter]["ci95"]
        # A held reading is late by half of the time for which it is held.
        slack = (most - least) / 2 + (0.02 if case.slow or case.ramp < 1 else 0.005) * abs(true)
        assert least - slack <= true <= most + slack, (parameter, found[parameter])
    for role, errors in report["error"].items():
        for column, error in errors.items():
            # A contact drop makes volts of the noise of a current near zero; a coarse thermometer has its quanta.
            if not (column in case.quanta or (column == "voltage_V" and logging_rate.DROP in case.effect)):
                sigma = case.noise * own_noise(column)
                assert error["floor"] == pytest.approx(sigma, rel=0.13), (role, column)
                assert error["after"] < 1.3 * error["floor"], (role, column)
    note = next((note for note in report["notes"] if re.search(r"\d means over", note)), None)
    if case.gait:
        assert note is None or float(re.search(r"about ([\d.]+) s", note)[1]) <= SHORT, note
    else:
        assert note and re.match(rf"the runs have {report_rows(tmp_path)} rows", note), report["notes"]


def own_noise(column):
    """Noise of an output with that of current and speed in it."""
    resistance, k_t = TRUE["motor.R_ref"], TRUE["motor.k_t"]
    direct = {"voltage_V": (resistance, k_t), "shaft_torque_Nm": (k_t, 0.0)}.get(column, (0.0, 0.0))
    return math.hypot(OUTPUTS[column], direct[0] * COLUMNS["current_A"], direct[1] * COLUMNS["speed_rad_per_s"])


def report_rows(folder):
    return sum(len(path.read_text(encoding="utf-8").splitlines()) - 1 for path in folder.glob("run-*.csv"))
