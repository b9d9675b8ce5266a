"""The gait load: smooth, periodic, with correct signs and sizes."""

import numpy as np
import pytest
from clients import gait, paths
from clients.fmu import Archive
from clients.gait import Gait

CELLS = [(activity, joint) for activity in gait.ACTIVITIES for joint in gait.JOINTS]
CHILDREN = [(activity, joint) for activity in gait.CHILDREN_SPEEDS for joint in gait.JOINTS]


@pytest.mark.parametrize("activity, joint", CELLS)
def test_strides_join_smoothly(activity, joint):
    g = Gait(75.0, activity, joint)
    eps = 1e-9
    before, after = g.at(g.stride_time - eps), g.at(g.stride_time + eps)
    for name in ("angle", "speed", "acceleration", "torque", "torque_rate", "torque_rate2"):
        a, b = getattr(before, name), getattr(after, name)
        assert a == pytest.approx(b, rel=1e-5, abs=1e-5), name


@pytest.mark.parametrize("activity, joint", CELLS)
def test_derivatives_belong_to_the_angle(activity, joint):
    g, eps = Gait(75.0, activity, joint), 1e-6
    t = np.linspace(0.0, g.stride_time, 37)
    low, mid, high = g.at(t - eps), g.at(t), g.at(t + eps)
    for name, rate in (("angle", "speed"), ("speed", "acceleration"), ("torque", "torque_rate")):
        slope = (getattr(high, name) - getattr(low, name)) / (2 * eps)
        size = np.abs(getattr(mid, rate)).max()
        assert np.abs(slope - getattr(mid, rate)).max() <= 2e-3 * size


@pytest.mark.parametrize("activity, joint", CHILDREN)
def test_power_is_that_of_the_source(activity, joint):
    """The children's table has the power as a measured column; torque times speed must agree approximately, because the product of two mean
    curves is not the mean of the products.
    """
    g = Gait(75.0, activity, joint)
    rows = [row for row in gait._rows(gait.CHILDREN_CYCLES) if row["speed"] == gait.CHILDREN_SPEEDS[activity]]
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


def test_the_default_is_the_adult():
    """Peak ankle moment of the digitised curve, 1.37 N.m/kg; children reach 1.23 N.m/kg, within 15 % and at the same phase."""
    moments = {activity: gait.cycle(activity, "ankle") for activity in ("walk", "child_walk")}
    peak = {activity: (moment.max(), 100.0 * phase[moment.argmax()]) for activity, (phase, _, moment) in moments.items()}
    measured = max(float(row["value"]) for row in gait._rows(gait.ADULTS / "walking_ankle_torque.csv"))
    assert Gait(75.0).activity == "walk" and measured == pytest.approx(1.37, abs=1e-3)
    assert peak["walk"][0] == pytest.approx(measured, abs=5e-3)
    assert peak["child_walk"][0] == pytest.approx(1.23, abs=5e-3)
    assert peak["walk"][1] == pytest.approx(peak["child_walk"][1], abs=4.0)


def test_the_source_names_the_subjects():
    assert "adults" in Gait(75.0).source and "Grimmer" in Gait(75.0).source
    assert all("children" in gait.source(activity) and "Schwartz" in gait.source(activity) for activity in gait.CHILDREN_SPEEDS)


@pytest.mark.parametrize("activity", gait.ACTIVITIES)
def test_client_and_fmu_agree(activity):
    """Two implementations of one gait: angle and torque of GaitLoad over a stride."""
    g = Gait(75.0, activity)
    with Archive(paths.archive("GaitLoad", 2)) as archive, archive.instance() as load:
        load.initialise({"gait.activity": activity})
        for k in range(20):
            angle, torque = load.get("joint_angle", "torque_demand")
            expected = g.at(np.array(k * 0.05))
            assert angle == pytest.approx(float(expected.angle), abs=2e-3)
            assert torque == pytest.approx(float(expected.torque), abs=0.5)
            load.step(0.05)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(body_mass=5.0), ("body_mass", "5.0", "20")),
        (dict(body_mass=float("nan")), ("body_mass", "nan")),
        (dict(body_mass=75.0, support=-0.1), ("support", "-0.1")),
        (dict(body_mass=75.0, joint="toe"), ("joint", "toe", "ankle")),
        (dict(body_mass=75.0, activity="run"), ("activity", "run", "child_walk_fast")),
    ],
)
def test_bad_input_is_named(bad, words):
    with pytest.raises(ValueError) as caught:
        Gait(**bad)
    for word in words:
        assert word in str(caught.value)
