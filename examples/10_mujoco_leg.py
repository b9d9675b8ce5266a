"""A leg in MuJoCo whose motor is an FMU: leg extensions until the winding is warm.

MuJoCo has the shank, the foot and a weight on the ankle; the knee's torque comes from `SeriesElasticActuator` with `AnnulusCooledMotor`,
not from a built-in motor. Its own joint controller asks for a torque, as a robot's would. The loop is causal in both directions: MuJoCo
gives the knee's angle and speed, the actuator's spring gives the torque. Run it after `cargo xtask demo`, with `mujoco` installed.
"""

import json
import math

import mujoco
import numpy as np
from clients.fmu import Archive
from clients.paths import archive

STEP, SECONDS = 1e-3, 60.0
PERIOD = 2.5  # s, of a leg extension
WEIGHT = 8.0  # kg, at the ankle
KELVIN = 273.15

# The knee's angle is 0 where the shank hangs down, positive in extension.
LEG = f"""
<mujoco model="leg extension">
  <option timestep="{STEP}" integrator="implicitfast"/>
  <worldbody>
    <body name="shank">
      <joint name="knee" type="hinge" axis="0 -1 0" damping="0.3"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04" mass="3.2"/>
      <body name="foot" pos="0 0 -0.42">
        <geom type="box" pos="0.06 0 0" size="0.12 0.045 0.02" mass="1.1"/>
        <geom name="weight" type="sphere" size="0.06" mass="{WEIGHT}"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
ACTUATOR = {
    "transmission.ratio": 60.0,
    "spring.stiffness": 400.0,
    "spring.damping": 1.0,
    "control.natural_frequency": 30.0,
}
MOTOR = {"drive_mode": "current", "mechanical_mode": "free_shaft", "cooling_mode": "conductance"}
FROM_MOTOR = {"shaft_angle": "motor_angle", "shaft_speed": "motor_speed", "current": "motor_current"}
PRESET = "maxon-305015"  # adds the motor's friction
STIFFNESS, DAMPING = 150.0, 12.0  # of the joint controller, N.m/rad and N.m.s/rad


def wanted(t):
    """Angle and speed of the exercise: from hanging to stretched and back, smoothly."""
    phase = 2.0 * math.pi * t / PERIOD
    return 0.7 * (1.0 - math.cos(phase)), 0.7 * 2.0 * math.pi / PERIOD * math.sin(phase)


def exercise(fan: float) -> dict:
    model = mujoco.MjModel.from_xml_string(LEG)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    paths = archive("AnnulusCooledMotor", 2, PRESET), archive("SeriesElasticActuator", 2)
    with Archive(paths[0]) as motors, Archive(paths[1]) as actuators:
        with motors.instance() as motor, actuators.instance() as actuator:
            motor.initialise(MOTOR | {"fan_command": fan})
            actuator.initialise(ACTUATOR)
            record = []
            for k in range(round(SECONDS / STEP)):
                t = k * STEP
                angle, speed = float(data.qpos[0]), float(data.qvel[0])
                target, target_speed = wanted(t)
                # What gravity takes, MuJoCo knows; the rest is a spring and a damper about the exercise.
                demand = float(data.qfrc_bias[0]) + STIFFNESS * (target - angle) + DAMPING * (target_speed - speed)
                actuator.set(dict(zip(FROM_MOTOR.values(), motor.get(*FROM_MOTOR))))
                actuator.set({"joint_angle": angle, "joint_speed": speed, "torque_demand": demand})
                torque, load, current = actuator.get("joint_torque", "load_torque", "current_command")
                motor.set({"current_command": current, "load_torque": load})
                data.qfrc_applied[0] = torque
                mujoco.mj_step(model, data)
                motor.step(STEP)
                actuator.step(STEP)
                record.append((target - angle, torque, demand, torque * (float(data.qpos[0]) - angle)))
            winding, housing, electrical = motor.get("winding_temperature", "housing_temperature", "energy_electrical")
            (given,) = actuator.get("energy_joint")
    error, torque, demand, work = np.array(record).T
    settled = slice(round(PERIOD / STEP), None)
    return {
        "angle_error_rms_degree": float(np.degrees(np.sqrt(np.mean(error[settled] ** 2)))),
        "torque_peak_Nm": float(np.max(np.abs(torque))),
        "torque_error_rms_Nm": float(np.sqrt(np.mean((torque - demand)[settled] ** 2))),
        "work_on_the_leg_J": float(np.sum(work)),
        "work_by_the_actuator_J": given,
        "energy_electrical_J": electrical,
        "winding_temperature_degC": winding - KELVIN,
        "housing_temperature_degC": housing - KELVIN,
    }


if __name__ == "__main__":
    print(json.dumps({"still air": exercise(0.0), "fan": exercise(1.0)}, indent=2))
