"""The public synthetic sets, from their files to the verdict: what is found is what was put in. `drag-power-075` is in test_close_loop.py.

In the everyday run a law of no list, one listed effect, and nothing; at night the other listed effect, too.
"""

import json

import pytest
from public_sets import closed, has_the_errors_of_the_truth, holds, inside, named


def report(program, name, out):
    return json.loads(closed(program, name, out))


def test_iron_loss_is_named_with_its_size(program, tmp_path):
    found = report(program, "iron-loss", tmp_path)
    k = named(found, "iron_loss")["k"]
    assert k["value"] == pytest.approx(9.5e-5, rel=0.02) and holds(k, 9.5e-5)
    has_the_errors_of_the_truth(found, "iron-loss", 1.05)
    assert len(inside(found, "iron-loss")) == 8


@pytest.mark.nightly
def test_radiation_is_named(program, tmp_path):
    found = report(program, "housing-radiation", tmp_path)
    assert holds(named(found, "housing_radiation")["k"], 5.4e-10)
    has_the_errors_of_the_truth(found, "housing-radiation", 1.05)
    assert len(inside(found, "housing-radiation")) == 8


def test_nothing_is_found_behind_drifting_thermocouples(program, tmp_path):
    """Sensors that drift by millikelvins look like a drifting room, which does not help where it was not fitted."""
    found = report(program, "thermocouple-drift", tmp_path)
    assert (found["verdict"], found["effects"], found["unexplained"]) == ("nothing", [], None)
    has_the_errors_of_the_truth(found, "thermocouple-drift", 1.05)
    assert len(inside(found, "thermocouple-drift")) == 8
