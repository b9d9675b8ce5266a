"""`motor-fmu close-loop` finds what a gearmotor's preset states wrongly or does not state, and effects of no list."""

import json
import subprocess

import gearmotor_benches
import pytest
from clients.paths import archive
from gearmotor_benches import CASES, DEVIATION, LAWS, START

SEED = 7
EVERYDAY = "another decay mode"
LAW_OF_THE_DAY = "a housing sensor that errs with the speed"


def of(cases, everyday):
    """The names of cases, all but one of them nightly."""
    return [name if name == everyday else pytest.param(name, marks=pytest.mark.nightly) for name in cases]


def report_of(name, program, folder):
    """Report of the tool on a case."""
    path = gearmotor_benches.write(program, archive("BrushedGearmotor", 3), name, SEED, folder)
    command = [program, "close-loop", str(path), "--out", str(folder / "out"), "--budget", "200"]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["replay"]["agrees"] and not report["budget"]["exhausted"]
    return report


@pytest.mark.parametrize("name", of(LAWS, LAW_OF_THE_DAY))
def test_an_effect_of_no_list_is_found_and_added(name, program, tmp_path):
    report, term = report_of(name, program, tmp_path), LAWS[name].term
    [law] = [effect["law"] for effect in report["effects"]]
    assert law["port"] == term["port"] and [driver["driver"] for driver in law["drivers"]] == [term["drivers"][0]["driver"]]
    assert ("lag" in law) == ("lag" in term)
    # The resistance without the law and its exponent are determined by the same temperatures.
    assert law["drivers"][0]["exponent"] == pytest.approx(term["drivers"][0]["exponent"], rel=0.2)
    # Runs that no fit has seen: the repaired model predicts them to their noise.
    for channel, error in report["error"]["test"].items():
        assert error["after"] < 1.3 * error["floor"], (channel, error)


@pytest.mark.parametrize("name", of(CASES, EVERYDAY))
def test_what_the_preset_lacks_is_found(name, program, tmp_path):
    report = report_of(name, program, tmp_path)
    # A duty that is 0 to within its noise may change its sign after a step, and the current of that row with it.
    assert report["explains_data"] or CASES[name].rest, report["remaining_error"]
    found = {key: value["value"] for key, value in report["parameters"].items()}
    for effect in report["effects"]:
        found |= {f"effect.{effect['id']}.{symbol}": value["value"] for symbol, value in effect["parameters"].items()}
    for parameter, share in DEVIATION.items():
        assert found[parameter] == pytest.approx(START[parameter] * (1.0 + share), rel=0.02), parameter
    contradicting = [note for note in report["notes"] if "contradicts the data" in note]
    # Viscous friction of the gear, which the preset states as 0, has a name.
    instead = {"gear.k": "effect.viscous_friction.k"} if report["effects"] else {}
    for parameter, true in CASES[name].truth.items():
        if isinstance(true, str):
            assert any(f'{parameter} = "{true}"' in note for note in contradicting), report["notes"]
        else:
            assert found[instead.get(parameter, parameter)] == pytest.approx(true, rel=0.02), (parameter, found)
    # Nothing else is blamed, neither a value, a mode nor a sensor.
    assert all(any(key in note for key in CASES[name].truth) for note in contradicting), contradicting
    assert not [note for note in report["notes"] if "dead or detached" in note]
