"""Minutes of walking with the motor FMU in the loop: run, energy balance and results.

The loop is causal: the motor gives angle and speed, the spring gives torque, the torque loads the motor.
"""

from dataclasses import dataclass

import numpy as np

from clients import master
from clients.actuator import MEASURED, Actuator, Design, MotorData
from clients.fmu import Archive
from clients.gait import Gait

KELVIN = 273.15
STEP = 1e-3  # s, communication step
OUTPUTS = (
    *MEASURED,
    "current",
    "terminal_voltage",
    "winding_temperature",
    "housing_temperature",
    "energy_electrical",
    "energy_mechanical",
)


@dataclass(frozen=True)
class Walk:
    """A finished run: arrays over the communication points, with actuator and temperature limit."""

    time: np.ndarray
    motor: dict[str, np.ndarray]  # by name of the FMU's variable, inputs included
    joint_angle: np.ndarray
    joint_speed: np.ndarray
    torque_demand: np.ndarray
    joint_torque: np.ndarray
    actuator: Actuator
    winding_limit: float  # K

    @property
    def first_judged(self) -> int:
        """First point used for mean values: the motor starts at rest and follows the gait after one stride."""
        return int(self.actuator.gait.stride_time / STEP) + 1


def walk(path, gait: Gait, design: Design, seconds: float, drive="current", fan=0.0, ambient=None, label="walking") -> Walk:
    """Walks with the FMU at `path`, until the winding passes its limit at the latest.

    `fan` is the fan command, 0 to 1; `ambient` a temperature in K.
    """
    if not seconds >= 2.0 * gait.stride_time:
        raise ValueError(f"seconds = {seconds:g}; a walk has at least two strides, {2.0 * gait.stride_time:g} s")
    start = {"drive_mode": drive, "mechanical_mode": "free_shaft", "cooling_mode": "conductance", "fan_command": fan}
    if ambient is not None:
        start["ambient_temperature"] = ambient
    command = "current_command" if drive == "current" else "voltage"
    inputs = (command, "load_torque")
    with Archive(path) as archive, archive.instance() as motor:
        motor.initialise(start)
        actuator = Actuator(design, MotorData.of(motor), gait, STEP, drive)
        (limit,) = motor.get("thermal.T_w_max")
        winding = OUTPUTS.index("winding_temperature")
        too_hot = lambda y: y[winding] > limit
        record = master.run(motor, actuator.command, inputs, OUTPUTS, STEP, round(seconds / STEP), too_hot, label)
    time = np.arange(len(record)) * STEP
    columns = dict(zip(OUTPUTS + inputs, record.T))
    motion = gait.at(time)
    torque = actuator.joint_torque(columns["shaft_angle"], motion.angle)
    return Walk(time, columns, motion.angle, motion.speed, motion.torque, torque, actuator, limit)


def _trapezoid_work(torque, angle) -> float:
    return float(np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(angle)))


def results(run: Walk) -> dict:
    """The numbers an actuator designer asks for. Names end in their unit."""
    m, judged = run.motor, slice(run.first_judged, None)
    current, voltage = m["current"], m["terminal_voltage"]
    error = (run.joint_torque - run.torque_demand)[judged]
    hours = run.time[-1] / 3600.0
    electrical, shaft = float(m["energy_electrical"][-1]), float(m["energy_mechanical"][-1])
    joint = _trapezoid_work(run.joint_torque, run.joint_angle)
    loss, stored = transmission_loss(run), spring_energy(run)
    return {
        "minutes_walked": float(run.time[-1] / 60.0),
        "strides": float(run.time[-1] / run.actuator.gait.stride_time),
        "winding_limit_reached": bool(m["winding_temperature"][-1] > run.winding_limit),
        "joint_torque_peak_Nm": float(np.max(np.abs(run.joint_torque[judged]))),
        "joint_torque_error_rms_percent_of_peak": float(
            100.0 * np.sqrt(np.mean(error**2)) / np.max(np.abs(run.torque_demand))
        ),
        "joint_power_peak_W": float(np.max((run.joint_torque * run.joint_speed)[judged])),
        "current_rms_A": float(np.sqrt(np.mean(current[judged] ** 2))),
        "current_peak_A": float(np.max(np.abs(current[judged]))),
        "voltage_peak_V": float(np.max(np.abs(voltage[judged]))),
        "motor_speed_peak_rad_per_s": float(np.max(np.abs(m["shaft_speed"][judged]))),
        "winding_temperature_end_degC": float(m["winding_temperature"][-1] - KELVIN),
        "winding_temperature_peak_degC": float(np.max(m["winding_temperature"]) - KELVIN),
        "housing_temperature_end_degC": float(m["housing_temperature"][-1] - KELVIN),
        "energy_electrical_J": electrical,
        "energy_electrical_drawn_J": float(np.sum(np.maximum(np.diff(m["energy_electrical"]), 0.0))),
        "energy_shaft_J": shaft,
        "energy_joint_J": joint,
        "energy_transmission_loss_J": loss,
        "energy_balance_error_percent": 100.0 * (shaft - joint - loss - stored) / _throughput(run),
        "battery_Wh_per_hour": electrical / 3600.0 / hours,
    }


def _mid_step(run: Walk):
    """Spring torque that the load of each step came from, and the motor's way in that step."""
    a, motor_way = run.actuator, np.diff(run.motor["shaft_angle"])
    middle = run.motor["shaft_angle"][:-1] + 0.5 * STEP * run.motor["shaft_speed"][:-1]
    joint = a.gait.at(run.time[:-1] + 0.5 * STEP).angle
    return a.joint_torque(middle, joint), motor_way


def transmission_loss(run: Walk) -> float:
    """Work that goes in at the motor's side of the transmission and does not come out at the spring's, J."""
    torque, way = _mid_step(run)
    return float(np.sum((run.motor["load_torque"][:-1] - torque / run.actuator.design.ratio) * way))


def spring_energy(run: Walk) -> float:
    """Energy in the spring at the end, less that at the start, J."""
    return float(np.diff(run.joint_torque[[0, -1]] ** 2)[0] / (2.0 * run.actuator.design.stiffness))


def _throughput(run: Walk) -> float:
    """Work that went through the joint in either direction, J."""
    return float(np.sum(np.abs(run.joint_torque * run.joint_speed)) * STEP)
