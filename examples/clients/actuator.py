"""A series elastic actuator between the motor FMU and a joint: transmission, spring, torque control, supply.

    deflection    d = angle_motor / ratio - angle_joint                                  (1)
    joint torque  tau_j = k_s d                                                          (2)
    motor load    tau_l = tau_j / ratio * efficiency^-tanh(P / P_small)                  (3)
    P = tau_j speed_motor / ratio, the power that leaves the transmission

*Assumes* a spring without mass, a rigid transmission, one efficiency for both directions of power.
*Neglects* the inertia of the transmission, backlash, the compliance of the leg.
*Sign*: tau_j > 0 pushes the joint in the positive direction; tau_l > 0 brakes a motor that turns forwards.
(3) loses power in both directions: 1/efficiency of it is asked of the motor when it drives, efficiency of it
arrives when the joint drives. tanh makes the change smooth, within a few P_small around zero power.

Control: a feed-forward of the torque that the demand needs, plus a proportional-derivative law on the deflection
(seen from the motor: on the angle that would give the deflection demanded). Commands are held over a step, so both
the feed-forward and the load are taken at the middle of the step; held at its start they would lag by half a step,
and the spring would give energy that nobody put in.
"""

import math
from dataclasses import dataclass

import numpy as np

from clients.gait import Gait

# Outputs of the FMU that `Actuator.command` takes, in this order. Resistance and torque constant stand for the
# drive's current loop, which finds the voltage for a current whatever the temperatures are.
MEASURED = ("shaft_angle", "shaft_speed", "winding_resistance", "torque_constant")
P_SMALL = 0.5  # W, width of the change-over between driving and being driven


@dataclass(frozen=True)
class Design:
    """What an actuator designer chooses."""

    ratio: float = 250.0  # motor angle over joint angle
    efficiency: float = 0.85  # of the transmission, either direction
    stiffness: float = 250.0  # N.m/rad, of the spring, at the joint
    supply_voltage: float = 48.0  # V
    current_max: float = 30.0  # A, of the drive
    natural_frequency: float = 40.0  # Hz, of the deflection control
    damping: float = 1.0  # of the deflection control

    def __post_init__(self):
        for name in ("ratio", "stiffness", "supply_voltage", "current_max", "natural_frequency", "damping"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} = {getattr(self, name)}; it must be greater than 0")
        if not 0.0 < self.efficiency <= 1.0:
            raise ValueError(f"efficiency = {self.efficiency}; it must be greater than 0 and at most 1")


@dataclass(frozen=True)
class MotorData:
    """What the torque control knows of its motor: values at the reference temperature, not the present ones."""

    k_t: float  # N.m/A
    J: float  # kg.m2
    tau_c: float  # N.m
    w_small: float  # rad/s

    NAMES = ("motor.k_t", "motor.J", "effect.coulomb_friction.tau_c", "effect.coulomb_friction.w_small")

    @classmethod
    def of(cls, instance) -> "MotorData":
        """Read from an FMU."""
        return cls(*instance.get(*cls.NAMES))


class Actuator:
    """Motor command and load for each step, from the motor's angle and speed."""

    # Steps prepared at once: the demand does not depend on the motor, so whole arrays of it are cheap.
    CHUNK = 4096

    def __init__(self, design: Design, motor: MotorData, gait: Gait, step: float, drive: str = "current"):
        if drive not in ("current", "voltage"):
            raise ValueError(f"drive = {drive!r}; it takes current, voltage")
        self.design, self.motor, self.gait, self.step, self.drive = design, motor, gait, step, drive
        omega = 2.0 * math.pi * design.natural_frequency
        self._k_p = motor.J * omega**2 / motor.k_t
        self._k_d = 2.0 * design.damping * motor.J * omega / motor.k_t
        self._chunk, self._first = [], 0
        # The FMU counts its angle from zero; there the spring shall have the deflection demanded at the start.
        self.offset = float(self.motor_angle(gait.at(0.0))[0])

    def load_torque(self, joint_torque, motor_speed, tanh=math.tanh):
        """Eq. (3). For arrays pass numpy's tanh; for one number the one of math is ten times as fast."""
        power = joint_torque * motor_speed / self.design.ratio
        return joint_torque / self.design.ratio * self.design.efficiency ** -tanh(power / P_SMALL)

    def joint_torque(self, motor_angle, joint_angle):
        """Eqs. (1) and (2)."""
        return self.design.stiffness * ((motor_angle + self.offset) / self.design.ratio - joint_angle)

    def motor_angle(self, motion):
        """Motor angle, speed and acceleration that give the torque demanded; (1) and (2) solved for the motor."""
        n, k = self.design.ratio, self.design.stiffness
        return (
            n * (motion.angle + motion.torque / k),
            n * (motion.speed + motion.torque_rate / k),
            n * (motion.acceleration + motion.torque_rate2 / k),
        )

    def _prepare(self, first: int):
        middle = self.gait.at((np.arange(first, first + self.CHUNK) + 0.5) * self.step)
        angle, speed, acceleration = self.motor_angle(middle)
        torque = (
            self.load_torque(middle.torque, speed, np.tanh)
            + self.motor.J * acceleration
            + self.motor.tau_c * np.tanh(speed / self.motor.w_small)
        )
        # Targets at the start of the step, where the motor is measured.
        target, target_speed, _ = self.motor_angle(self.gait.at(np.arange(first, first + self.CHUNK) * self.step))
        columns = (target - self.offset, target_speed, torque / self.motor.k_t, middle.angle)
        self._chunk, self._first = list(zip(*(column.tolist() for column in columns))), first

    def command(self, k: int, y) -> tuple[float, float]:
        """Command (A, or V for a voltage drive) and load torque for step k, from the `MEASURED` at its start."""
        angle, speed, resistance, torque_constant = y[:4]
        if not self._first <= k < self._first + len(self._chunk):
            self._prepare(k)
        target, target_speed, feed_forward, joint = self._chunk[k - self._first]
        d = self.design
        current = feed_forward + self._k_p * (target - angle) + self._k_d * (target_speed - speed)
        # The supply cannot push a current whose voltage it does not have.
        emf = torque_constant * speed
        low = max((-d.supply_voltage - emf) / resistance, -d.current_max)
        high = min((d.supply_voltage - emf) / resistance, d.current_max)
        current = min(max(current, low), high)
        torque = self.joint_torque(angle + 0.5 * self.step * speed, joint)
        load = self.load_torque(torque, speed)
        return (current if self.drive == "current" else resistance * current + emf), load
