"""The comparison with stored outputs finds what it must find."""

import pytest
from stored import same, same_page


@pytest.mark.parametrize(
    ("found", "stored", "agree"),
    [
        ({"torque_Nm": 1.005}, {"torque_Nm": 1.0}, True),
        ({"torque_Nm": 1.02}, {"torque_Nm": 1.0}, False),
        ({"winding_temperature_degC": 100.09}, {"winding_temperature_degC": 100.0}, True),
        ({"winding_temperature_degC": 100.2}, {"winding_temperature_degC": 100.0}, False),
        ({"ci95": [0.9, 1.1]}, {"ci95": [0.91, 1.1]}, True),
        ({"ci95": [0.9, 1.1]}, {"ci95": [0.99, 1.1]}, False),
        ({"verdict": "named"}, {"verdict": "nothing"}, False),
        ({"limit": True}, {"limit": 1}, False),
        ({"strides": [1.0]}, {"strides": [1.0, 2.0]}, False),
        ({"a": 1.0, "b": 1.0}, {"b": 1.0, "a": 1.0}, False),
    ],
)
def test_a_stored_output(found, stored, agree):
    if agree:
        same(found, stored)
        return
    with pytest.raises(AssertionError):
        same(found, stored)


@pytest.mark.parametrize(
    ("found", "stored", "agree"),
    [
        ("gives 0.182 N.m (+68 %)", "gives 0.181 N.m (+68 %)", True),
        ("gives 0.182 N.m (+68 %)", "gives 0.172 N.m (+68 %)", False),
        ("gives 0.182 N.m", "takes 0.182 N.m", False),
        ("after 33 min", "after 33 min", True),
    ],
)
def test_a_page(found, stored, agree):
    if agree:
        same_page(found, stored, "page.md")
        return
    with pytest.raises(AssertionError):
        same_page(found, stored, "page.md")
