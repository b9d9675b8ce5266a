"""Level walking as a load: joint angle, speed and torque over the stride, smooth and periodic.

Source: that of the activity, `Gait.source`. Adults: torque and angular velocity [Grimmer2014] (fmu-src/physics/data/gait-walking-stairs-cc0);
the angle is the integral of the velocity, with zero mean. Children: normative gait at five speeds [Schwartz2008]
(fmu-src/physics/data/gait-schwartz2008), 51 points per stride.
*Assumes* that every stride is the same, and that torque scales with body mass.
*Sign*: angle and torque are positive in extension (plantarflexion at the ankle), so that torque * speed > 0 is
power from the actuator into the leg. The children's table has flexion positive in angle and extension positive in moment.
"""

import csv
import xml.etree.ElementTree as xml
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from clients.paths import DATA, ROOT

ADULTS = DATA / "gait-walking-stairs-cc0"
CHILDREN = DATA / "gait-schwartz2008"
CHILDREN_CYCLES = CHILDREN / "schwartz2008_joint_angle_moment_power.csv"
DESCRIPTION = ROOT / "model-description" / "GaitLoad" / "fmi3.xml"
# Activities as GaitLoad names them; of children with the name of the speed in the table.
ADULT_WALK = "walk"
CHILDREN_SPEEDS = {
    "child_walk_very_slow": "VerySlow",
    "child_walk_slow": "Slow",
    "child_walk": "Free",
    "child_walk_fast": "Fast",
    "child_walk_very_fast": "VeryFast",
}
ACTIVITIES = (ADULT_WALK, *CHILDREN_SPEEDS)
JOINTS = ("hip", "knee", "ankle")
BODY_MASS_MIN, BODY_MASS_MAX = 20.0, 200.0
SUPPORT_MAX = 2.0
POINTS = 100  # equidistant points of the adults' stride
HARMONICS = 12  # kept of it, 10.5 Hz: above lies the ripple of the digitisation


@dataclass(frozen=True)
class Motion:
    """Joint motion and torque demand at given times, each an array."""

    angle: np.ndarray  # rad
    speed: np.ndarray  # rad/s
    acceleration: np.ndarray  # rad/s2
    torque: np.ndarray  # N.m
    torque_rate: np.ndarray  # N.m/s
    torque_rate2: np.ndarray  # N.m/s2


class Gait:
    """A joint in level walking. `support` is the fraction of the biological torque that the actuator gives."""

    def __init__(self, body_mass: float, activity: str = ADULT_WALK, joint: str = "ankle", support: float = 1.0):
        if not BODY_MASS_MIN <= body_mass <= BODY_MASS_MAX:
            raise ValueError(f"body_mass = {body_mass} kg; it must lie in {BODY_MASS_MIN:g} to {BODY_MASS_MAX:g} kg")
        if not 0.0 <= support <= SUPPORT_MAX:
            raise ValueError(f"support = {support}; it must lie in 0 to {SUPPORT_MAX:g}")
        if joint not in JOINTS:
            raise ValueError(f"joint = {joint!r}; it takes {', '.join(JOINTS)}")
        if activity not in ACTIVITIES:
            raise ValueError(f"activity = {activity!r}; it takes {', '.join(ACTIVITIES)}")
        self.activity = activity
        self.stride_time = stride_time(activity)
        phase, angle, moment = cycle(activity, joint)
        self._angle = self._spline(phase, angle)
        self._torque = self._spline(phase, moment * body_mass * support)

    def _spline(self, phase, values):
        return CubicSpline(phase * self.stride_time, _closed(phase, values), bc_type="periodic")

    @property
    def source(self) -> str:
        """Subjects and publication of the data."""
        return source(self.activity)

    def at(self, time) -> Motion:
        """Motion and demand at given times; derivatives are those of the splines, not differences."""
        angle = [self._angle(time, order) for order in range(3)]
        torque = [self._torque(time, order) for order in range(3)]
        return Motion(*angle, *torque)

    def phase(self, time):
        """Gait phase, 0 to 1."""
        return np.mod(time, self.stride_time) / self.stride_time


def source(activity: str) -> str:
    """Subjects and publication of an activity's data, as GaitLoad declares them."""
    items = xml.parse(DESCRIPTION).iterfind(".//EnumerationType[@name='Activity']/Item")
    return next(item.get("description") for item in items if item.get("name") == activity)


def _rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def stride_time(activity: str) -> float:
    """Seconds per stride."""
    if activity == ADULT_WALK:
        rows = {row["activity"]: row for row in _rows(ADULTS / "stride_time_s.csv")}
        return float(rows["walk"]["stride_time_s"])
    rows = {row[""]: row for row in _rows(CHILDREN / "stride_time_inferred_s.csv")}
    return float(rows[CHILDREN_SPEEDS[activity]]["stride_time_s"])


def cycle(activity: str, joint: str):
    """Phase (0 to 1), angle (rad, extension positive) and moment (N.m/kg)."""
    return _adult_cycle(joint) if activity == ADULT_WALK else _child_cycle(CHILDREN_SPEEDS[activity], joint)


def _adult_cycle(joint: str):
    phase = np.arange(POINTS + 1) / POINTS

    def curve(quantity):
        percent, values = np.array([[float(cell) for cell in row.values()] for row in _rows(ADULTS / f"walking_{joint}_{quantity}.csv")]).T
        waves = np.fft.rfft(np.interp(phase[:-1], percent / 100.0, values, period=1.0))
        waves[HARMONICS + 1 :] = 0.0
        smooth = np.fft.irfft(waves, POINTS)
        return np.append(smooth, smooth[0])

    speed = np.radians(curve("angle_velocity"))
    speed -= speed[:-1].mean()
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) * stride_time(ADULT_WALK) / POINTS
    return phase, angle - angle[:-1].mean(), curve("torque")


def _child_cycle(speed: str, joint: str):
    rows = [row for row in _rows(CHILDREN_CYCLES) if row["speed"] == speed]
    column = lambda name: np.array([float(row[name]) for row in rows])  # noqa: E731
    return column("gait_pct") / 100.0, -np.radians(column(f"{joint}_angles_mean")), column(f"{joint}_moment_mean")


def _closed(phase, values):
    """The curve with its end made equal to its start.

    The means of 76 to 82 children do not close exactly (0.2 degrees at self-selected speed); the gap is spread over the
    stride, so that the speed is continuous from one stride to the next.
    """
    closed = values - (values[-1] - values[0]) * (phase - 0.5)
    closed[-1] = closed[0]
    return closed
