"""Sets of the blind suite, drawn, run and judged: no effect at all, a wrong sign, a pair that only together predicts better."""

import json

import pytest
from blind import draw, judge, make, run
from blind.files import write_set

pytestmark = pytest.mark.nightly

SEED = 41
SETS = {
    (11, draw.NULL): "another motor with noise, drift and no effect",
    (2, draw.MISTAKE): "the sign of the voltage",
}


@pytest.mark.parametrize(("number", "kind"), SETS)
def test_a_set_is_right(number, kind, program, tmp_path):
    s = make.made(SEED, number)
    assert s.kind == kind
    write_set(s, tmp_path)
    run.ask(tmp_path, program, "", 120.0)
    one = run.judged(tmp_path)
    assert one.outcome == judge.RIGHT, f"{one.sentence}: {SETS[number, kind]}"


def test_a_wrong_unit_of_an_input_is_found_beside_a_wrong_prior(program, tmp_path):
    """Voltage and speed are inputs, so that the current is the small difference of the voltage and the back-EMF: with the torque constant of
    the preset no output agrees, whatever the unit of the speed is."""
    s = make.made(39119, 6)
    write_set(s, tmp_path)
    run.ask(tmp_path, program, "", 240.0, 120.0)
    report = json.loads((tmp_path / "result" / "report.json").read_text(encoding="utf-8"))
    assert report["unusable"]["channel"] == "speed_rad_per_s", report["unusable"]
    assert "readings in rpm" in report["unusable"]["reason"]


def test_an_effect_that_predicts_worse_alone_is_found_with_a_second_one(program, tmp_path):
    """The lag of the winding's sensor explains most; beside the other differences of this specimen, convection and end winding, it does
    not predict better alone. The lag and the heat capacity of the winding can be exchanged, and a fit may end with the wrong one."""
    s = make.made(35227, 21)
    assert s.pieces["sensor_lag"] > 10.0
    write_set(s, tmp_path)
    run.ask(tmp_path, program, "", 240.0, 120.0)
    report = json.loads((tmp_path / "result" / "report.json").read_text(encoding="utf-8"))
    assert "winding_sensor_lag" in [effect["id"] for effect in report["effects"]]
    for channel, error in report["error"]["test"].items():
        assert error["after"] < (0.5 if "temperature" in channel else 1.02) * error["refit"], channel
