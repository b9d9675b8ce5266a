"""Invalid input through the FMI functions: rejected with a message, without any change."""

import math

import pytest
from clients.fmu import FmuError

DISCARD, ERROR = 2, 3
DRIVE = dict(voltage=24.0, load_torque=0.05)
INPUTS = ("voltage", "load_torque", "fan_command", "ambient_temperature")


@pytest.fixture
def pair(make):
    """Two equal running instances: one for the invalid call, one for comparison."""
    two = make(**DRIVE), make(**DRIVE)
    for fmu in two:
        for _ in range(20):
            fmu.step(1e-3)
    return two


def outputs(fmu):
    """All outputs of an instance."""
    return fmu.get(*(v.name for v in fmu.archive.variables.values() if v.causality == "output"))


def refused(pair, action, *words):
    """The call is rejected with these words in the log, and the instance continues unchanged."""
    disturbed, other = pair
    before = outputs(disturbed)
    with pytest.raises(FmuError) as caught:
        action(disturbed)
    assert caught.value.status in (DISCARD, ERROR)
    said = " ".join(line.text for line in caught.value.lines)
    for word in words:
        assert word in said, f"{word!r} is not in {said!r}"
    assert outputs(disturbed) == before == outputs(other)
    for fmu in pair:
        fmu.step(1e-3)
    assert outputs(disturbed) == outputs(other)


@pytest.mark.parametrize("value, word", [(math.nan, "nan"), (math.inf, "inf"), (-math.inf, "-inf")])
@pytest.mark.parametrize("name", INPUTS)
def test_input_that_is_no_number(pair, name, value, word):
    def act(fmu):
        with_lower = FmuErrorInLowerCase(fmu)
        with_lower.set({name: value})

    refused(pair, act, name.lower(), word)


class FmuErrorInLowerCase:
    """NaN and inf have several spellings: compares the log in lower case."""

    def __init__(self, fmu):
        self.fmu = fmu

    def set(self, values):
        try:
            self.fmu.set(values)
        except FmuError as error:
            error.lines = [line._replace(text=line.text.lower()) for line in error.lines]
            raise


def limits(fmu, name):
    """Limits of a variable as the XML has them."""
    variable = fmu.archive.variable(name)
    return float(variable.min), float(variable.max)


@pytest.mark.parametrize("name", ["motor.R_ref", "thermal.C_w", "conductance.G_still"])
@pytest.mark.parametrize("side", ["below", "above"])
def test_parameter_out_of_range(pair, name, side):
    low, high = limits(pair[0], name)
    value = low - 1.0 if side == "below" else high * 2.0
    refused(pair, lambda fmu: fmu.set({name: value}), name)
    with pytest.raises(FmuError) as caught:
        pair[0].set({name: value})
    numbers = numbers_in(caught.value.lines[-1].text)
    for number in (value, low, high):
        assert any(math.isclose(number, found, rel_tol=1e-9) for found in numbers), f"{number} is not in {numbers}"


def numbers_in(text):
    """All numbers in a sentence."""
    found = []
    for word in text.replace(",", " ").replace("[", " ").replace("]", " ").replace(";", " ").split():
        try:
            found.append(float(word.rstrip(".:)").lstrip("(")))
        except ValueError:
            continue
    return found


def test_input_out_of_range(pair):
    refused(pair, lambda fmu: fmu.set({"ambient_pressure": 1.5e9}), "ambient_pressure", "1500000000")


@pytest.mark.parametrize("name, value, limit", [("fan_command", 1.02, 1.0), ("fan_command", -3.0, 0.0), ("duty", 1.0000001, 1.0)])
def test_input_that_saturates(make, name, value, limit):
    """A finite value beyond the limits acts as the limit, with one warning."""
    drive = dict(drive_mode="pwm", voltage=24.0, duty=0.5)
    limited, other = make(drive), make(drive)
    for _ in range(3):
        limited.set({name: value})
        other.set({name: limit})
        for fmu in (limited, other):
            fmu.step(1e-3)
    assert outputs(limited) == outputs(other)
    warnings = [line for line in limited.lines if line.status == 1]
    assert len(warnings) == 1 and name in warnings[0].text
    assert not [line for line in other.lines if line.status]


@pytest.mark.parametrize("size", [-1e-3, math.nan, math.inf])
def test_step_that_is_no_step(pair, size):
    point = pair[0].time
    refused(pair, lambda fmu: fmu._call("doStep", point, size))


@pytest.mark.parametrize("shift", [-0.01, 0.01, math.nan])
def test_wrong_communication_point(pair, shift):
    point = pair[0].time + shift
    refused(pair, lambda fmu: fmu._call("doStep", point, 1e-3))


@pytest.mark.parametrize("name", ["drive_mode", "mechanical_mode", "cooling_mode"])
def test_fixed_parameter_while_stepping(pair, name):
    refused(pair, lambda fmu: fmu.set({name: 1}), name)


def test_item_that_the_enumeration_lacks(archive):
    with archive.instance() as fmu:
        with pytest.raises(FmuError) as caught:
            fmu.set({"drive_mode": 99})
        text = caught.value.lines[-1].text
        assert "drive_mode" in text and "99" in text
        fmu.initialise(DRIVE).step(1e-3)


@pytest.mark.parametrize("name", ["current", "winding_temperature"])
def test_output_cannot_be_set(pair, name):
    refused(pair, lambda fmu: fmu.set({name: 1.0}), name)


def test_bytes_that_are_no_state(pair):
    refused(pair, lambda fmu: fmu.deserialise(b"not a state", 0.0))


def test_unknown_value_reference(pair):
    accessor = "getReal" if pair[0].archive.version == "2.0" else "getFloat64"
    refused(pair, lambda fmu: fmu._call(accessor, [987654321]), "987654321")
