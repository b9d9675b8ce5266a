"""Level walking as a load: joint angle, speed and torque over the stride, smooth and periodic.

Source: normative gait at five speeds, [Schwartz2008] (fmu-src/physics/data/gait-schwartz2008/SOURCE.md), 51 points per stride.
*Assumes* that every stride is the same, and that torque scales with body mass.
*Sign*: angle and torque are positive in extension (plantarflexion at the ankle), so that torque * speed > 0 is
power from the actuator into the leg. The table has flexion positive in angle and extension positive in moment.
"""

import csv
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from clients.paths import DATA

FOLDER = DATA / "gait-schwartz2008"
CYCLES = FOLDER / "schwartz2008_joint_angle_moment_power.csv"
STRIDES = FOLDER / "stride_time_inferred_s.csv"
JOINTS = ("hip", "knee", "ankle")
BODY_MASS_MIN, BODY_MASS_MAX = 20.0, 200.0
SUPPORT_MAX = 2.0


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
    """A joint in level walking. `support` is the share of the biological torque that the actuator gives."""

    def __init__(self, body_mass: float, speed: str = "Free", joint: str = "ankle", support: float = 1.0):
        if not BODY_MASS_MIN <= body_mass <= BODY_MASS_MAX:
            raise ValueError(f"body_mass = {body_mass} kg; it must lie in {BODY_MASS_MIN:g} to {BODY_MASS_MAX:g} kg")
        if not 0.0 <= support <= SUPPORT_MAX:
            raise ValueError(f"support = {support}; it must lie in 0 to {SUPPORT_MAX:g}")
        if joint not in JOINTS:
            raise ValueError(f"joint = {joint!r}; it takes {', '.join(JOINTS)}")
        strides = stride_times()
        if speed not in strides:
            raise ValueError(f"speed = {speed!r}; it takes {', '.join(strides)}")
        self.stride_time = strides[speed]
        phase, angle, moment = cycle(speed, joint)
        self._angle = self._spline(phase, angle)
        self._torque = self._spline(phase, moment * body_mass * support)

    def _spline(self, phase, values):
        return CubicSpline(phase * self.stride_time, _closed(phase, values), bc_type="periodic")

    def at(self, time) -> Motion:
        """Motion and demand at given times; derivatives are those of the splines, not differences."""
        angle = [self._angle(time, order) for order in range(3)]
        torque = [self._torque(time, order) for order in range(3)]
        return Motion(*angle, *torque)

    def phase(self, time):
        """Share of the stride, 0 to 1, that is over."""
        return np.mod(time, self.stride_time) / self.stride_time


def stride_times() -> dict[str, float]:
    """Seconds per stride for each speed class of the table."""
    with STRIDES.open(newline="") as file:
        return {row[""]: float(row["stride_time_s"]) for row in csv.DictReader(file)}


def cycle(speed: str, joint: str):
    """Phase (0 to 1), angle (rad, extension positive) and moment (N.m/kg) as the table has them."""
    with CYCLES.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["speed"] == speed]
    column = lambda name: np.array([float(row[name]) for row in rows])
    phase = column("gait_pct") / 100.0
    return phase, -np.radians(column(f"{joint}_angles_mean")), column(f"{joint}_moment_mean")


def _closed(phase, values):
    """The curve with its end made equal to its start.

    The means of 76 to 82 walkers do not close exactly (0.2 degrees at free speed); the gap is spread over the
    stride, so that there is no step in speed where one stride ends and the next begins.
    """
    closed = values - (values[-1] - values[0]) * (phase - 0.5)
    closed[-1] = closed[0]
    return closed
