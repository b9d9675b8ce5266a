"""The gait load: smooth, periodic, with correct signs and sizes."""

import csv

import numpy as np
import pytest
from clients import gait
from clients.gait import Gait
from clients.paths import DATA

SPEEDS = tuple(gait.stride_times())
CELLS = [(speed, joint) for speed in SPEEDS for joint in gait.JOINTS]


@pytest.mark.parametrize("speed, joint", CELLS)
def test_strides_join_smoothly(speed, joint):
    g = Gait(75.0, speed, joint)
    eps = 1e-9
    before, after = g.at(g.stride_time - eps), g.at(g.stride_time + eps)
    for name in ("angle", "speed", "acceleration", "torque", "torque_rate", "torque_rate2"):
        a, b = getattr(before, name), getattr(after, name)
        assert a == pytest.approx(b, rel=1e-5, abs=1e-5), name


@pytest.mark.parametrize("speed, joint", CELLS)
def test_derivatives_belong_to_the_angle(speed, joint):
    g, eps = Gait(75.0, speed, joint), 1e-5
    t = np.linspace(0.0, g.stride_time, 37)
    low, mid, high = g.at(t - eps), g.at(t), g.at(t + eps)
    for name, rate in (("angle", "speed"), ("speed", "acceleration"), ("torque", "torque_rate")):
        slope = (getattr(high, name) - getattr(low, name)) / (2 * eps)
        size = np.abs(getattr(mid, rate)).max()
        assert np.abs(slope - getattr(mid, rate)).max() <= 2e-3 * size


@pytest.mark.parametrize("speed, joint", CELLS)
def test_power_is_that_of_the_source(speed, joint):
    """The source has the power as a measured column; torque times speed must agree approximately, because the product of two mean curves is
    not the mean of the products.
    """
    g = Gait(75.0, speed, joint)
    with gait.CYCLES.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["speed"] == speed]
    power = np.array([float(row[f"{joint}_power_mean"]) for row in rows])
    motion = g.at(g.stride_time * np.array([float(row["gait_pct"]) for row in rows]) / 100.0)
    ours = motion.torque * motion.speed / 75.0
    assert np.corrcoef(ours, power)[0, 1] > 0.8
    assert ours.max() == pytest.approx(power.max(), rel=0.25)


def test_torque_scales_with_mass_and_support():
    one, two = Gait(60.0), Gait(90.0, support=0.5)
    t = np.linspace(0.0, 2.0, 50)
    assert np.allclose(two.at(t).torque, 0.75 * one.at(t).torque, rtol=1e-12, atol=0.0)
    assert np.array_equal(two.at(t).angle, one.at(t).angle)


def test_two_sources_agree_on_the_ankle():
    """Digitised from another laboratory's adults: peak moment per kilogram within 15 %, at the same time."""
    file = DATA / "gait-walking-stairs-cc0" / "walking_ankle_torque.csv"
    with file.open(newline="") as text:
        rows = [(float(row["pct_cycle"]), float(row["value"])) for row in csv.DictReader(text)]
    percent, moment = np.array(rows).T
    phase, _, ours = gait.cycle("Free", "ankle")
    assert ours.max() == pytest.approx(moment.max(), rel=0.15)
    assert 100.0 * phase[ours.argmax()] == pytest.approx(percent[moment.argmax()], abs=4.0)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(body_mass=5.0), ("body_mass", "5.0", "20")),
        (dict(body_mass=float("nan")), ("body_mass", "nan")),
        (dict(body_mass=75.0, support=-0.1), ("support", "-0.1")),
        (dict(body_mass=75.0, joint="toe"), ("joint", "toe", "ankle")),
        (dict(body_mass=75.0, speed="Run"), ("speed", "Run", "VeryFast")),
    ],
)
def test_bad_input_is_named(bad, words):
    with pytest.raises(ValueError) as caught:
        Gait(**bad)
    for word in words:
        assert word in str(caught.value)
