"""`motor-fmu close-loop` finds what a gearmotor's preset states wrongly or does not state."""

import json
import subprocess

import gearmotor_benches
import pytest
from clients.paths import archive
from gearmotor_benches import CASES, DEVIATION, START

SEED = 7
EVERYDAY = "another decay mode"
NAMES = [name if name == EVERYDAY else pytest.param(name, marks=pytest.mark.nightly) for name in CASES]


@pytest.mark.parametrize("name", NAMES)
def test_what_the_preset_lacks_is_found(name, program, tmp_path):
    path = gearmotor_benches.write(program, archive("BrushedGearmotor", 3), name, SEED, tmp_path)
    command = [program, "close-loop", str(path), "--out", str(tmp_path / "out"), "--budget", "200"]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["replay"]["agrees"] and not report["budget"]["exhausted"]
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
