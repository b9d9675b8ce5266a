"""A parameter that stands neither in [prior] nor in [set] has the preset's value: what `motor-fmu close-loop` does if this value is wrong.

The sets and their true motors are those of tests/reference/bench-synthetic. Each case leaves one parameter out of [prior] and [set]; its value
comes from a preset file beside the experiment, which is the built-in preset with that one value replaced.
"""

import json
import re
import shutil
import subprocess
import tomllib

import public_sets
import pytest
from clients.paths import ROOT

# The plain sets are closed every day, in test_public_sets.py and test_close_loop.py.
pytestmark = pytest.mark.nightly

PRESET = ROOT / "examples" / "presets" / "maxon-305015.toml"
HEAT_CAPACITY, FRICTION = "thermal.C_h", "effect.coulomb_friction.tau_c"


def truth(name):
    return public_sets.truth(name)["parameters"]


def built_in(parameter):
    return tomllib.loads(PRESET.read_text())["start"][parameter]["value"]


def replaced(text, name, line):
    """The text with `line` in place of the only line that begins with the name; without a line there, an error."""
    text, count = re.subn(rf'(?m)^"{re.escape(name)}" *=.*\n', line, text)
    assert count == 1, f"{name}: {count} lines"
    return text


def close_loop(program, folder, name, parameter, value, known=None):
    """The report on the set `name` if the preset has `value` for the parameter, which has no prior; `known` is its value under [set]."""
    shutil.copytree(public_sets.SETS / name, folder)
    preset = PRESET.read_text()
    unit = tomllib.loads(preset)["start"][parameter]["unit"]
    line = f'"{parameter}" = {{ value = {value!r}, unit = "{unit}" }}\n'
    (folder / "mine.toml").write_text(replaced(preset, parameter, line).replace('"maxon-305015"', '"mine"'))

    text = (folder / "experiment.toml").read_text().replace('preset = "maxon-305015"', 'preset = "mine.toml"')
    before, rest = text.split("[prior]\n")
    before = replaced(before, parameter, "" if known is None else f'"{parameter}" = {known!r}\n')
    (folder / "experiment.toml").write_text(before + "[prior]\n" + replaced(rest, parameter, ""))
    read = tomllib.loads((folder / "experiment.toml").read_text())
    assert read["experiment"]["preset"] == "mine.toml" and parameter not in read["prior"] and read["set"].get(parameter) == known

    command = [program, "close-loop", str(folder / "experiment.toml"), "--out", str(folder / "out"), "--budget", "300"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    written = folder / "out" / "report.json"
    report = json.loads(written.read_text()) if written.exists() else {"verdict": None}
    assert done.returncode == (1 if report["verdict"] == "unusable" else 0), done.stdout + done.stderr
    assert not report["budget"]["exhausted"]
    return report


def exported(folder, parameter):
    """The value of the parameter in the repaired model."""
    return tomllib.loads((folder / "out" / "preset.toml").read_text())["start"][parameter]["value"]


def without_prior(report):
    """The parameters of which a note says that the preset's value contradicts the data."""
    notes = [note for note in report["notes"] if "has no prior" in note or "in the preset contradicts the data" in note]
    found = [re.match(r"(\S+) has no prior, but its value .+ in the preset contradicts the data", note) for note in notes]
    assert all(found), notes
    return [match[1] for match in found]


def agrees(estimate, true):
    """Whether the truth is in an interval of twice the width of the 95 % interval.

    This is four standard deviations: a normal variable is outside with a probability of 6e-5.
    """
    low, high = estimate["ci95"]
    half = 0.5 * (high - low)
    return low <= estimate["value"] <= high and low - half <= true <= high + half and half > 0.0


def is_estimated(report, folder, parameter, true):
    assert without_prior(report) == [parameter], report["notes"]
    estimate = report["parameters"][parameter]
    assert agrees(estimate, true), estimate
    assert exported(folder, parameter) == estimate["value"]


def is_kept(report, folder, parameter, value):
    assert without_prior(report) == [], report["notes"]
    assert parameter not in report["parameters"]
    if report["verdict"] != "unusable":  # then there is no repaired model
        assert exported(folder, parameter) == pytest.approx(value, rel=1e-12)


def named(report):
    return report["verdict"], [effect["id"] for effect in report["effects"]]


def test_a_wrong_heat_capacity_is_estimated_and_no_effect_is_named(program, tmp_path):
    """Nothing is missing in this set: no effect takes the place of the heat capacity, which the built-in preset has 14 % too small."""
    name, folder = "thermocouple-drift", tmp_path / "set"
    assert built_in(HEAT_CAPACITY) < 0.9 * truth(name)[HEAT_CAPACITY]
    report = close_loop(program, folder, name, HEAT_CAPACITY, built_in(HEAT_CAPACITY))
    assert named(report) == ("nothing", [])
    is_estimated(report, folder, HEAT_CAPACITY, truth(name)[HEAT_CAPACITY])
    # The wrong value biases none of the parameters that have a prior.
    for parameter, true in truth(name).items():
        assert agrees(report["parameters"][parameter], true), parameter


def test_a_wrong_friction_torque_does_not_hide_the_missing_effect(program, tmp_path):
    """The built-in preset has all of the no-load loss as friction, 9.83 mN.m; the friction of the specimen is less than half of it."""
    name, folder = "housing-radiation", tmp_path / "set"
    assert built_in(FRICTION) > 2.0 * truth(name)[FRICTION]
    report = close_loop(program, folder, name, FRICTION, built_in(FRICTION))
    assert named(report) == ("named", ["housing_radiation"])
    is_estimated(report, folder, FRICTION, truth(name)[FRICTION])


def test_a_value_under_set_is_never_changed(program, tmp_path):
    """A heat capacity 1.5 times too great, in the preset and, as known, under [set]: whatever the verdict is, it is not estimated."""
    name, folder = "thermocouple-drift", tmp_path / "set"
    value = 1.5 * truth(name)[HEAT_CAPACITY]
    report = close_loop(program, folder, name, HEAT_CAPACITY, value, known=value)
    is_kept(report, folder, HEAT_CAPACITY, value)


def test_a_right_value_without_a_prior_is_kept_beside_a_missing_effect(program, tmp_path):
    """The friction torque of the preset is that of the specimen, and the missing iron loss is a drag as well: the effect explains the data."""
    name, folder = "iron-loss", tmp_path / "set"
    value = truth(name)[FRICTION]
    report = close_loop(program, folder, name, FRICTION, value)
    assert named(report) == ("named", ["iron_loss"])
    is_kept(report, folder, FRICTION, value)
