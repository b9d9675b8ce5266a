"""Motor, actuator and gait coupled by a plain master in fmpy alone: a starting point for own scripts.

Every step: read all outputs, set the connected inputs, step all FMUs (Jacobi, constant inputs). `motor-fmu cosim examples/systems/actuator-gait.toml
--algorithm jacobi-delayed --no-input-derivatives` gives the same bits, and without these two options a more accurate result in a fraction of the time.
"""

import json
from shutil import rmtree

from clients.paths import archive
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

STEP, STOP = 1e-3, 10.0
FMUS = {"gait": "GaitLoad", "motor": "AnnulusCooledMotor", "actuator": "SeriesElasticActuator"}
# The motor's friction, and the actuator's control that compensates for it.
PRESETS = {"AnnulusCooledMotor": "maxon-305015", "SeriesElasticActuator": "maxon-305015"}
SET = {"motor": {"fan_command": 1.0}}
CHOOSE = {"actuator": {"drive.power_source": 2}}  # motor_power
CONNECT = (
    ("gait.joint_angle", "actuator.joint_angle"),
    ("gait.joint_speed", "actuator.joint_speed"),
    ("gait.torque_demand", "actuator.torque_demand"),
    ("motor.shaft_angle", "actuator.motor_angle"),
    ("motor.shaft_speed", "actuator.motor_speed"),
    ("motor.current", "actuator.motor_current"),
    ("actuator.voltage", "motor.voltage"),
    ("actuator.load_torque", "motor.load_torque"),
    ("motor.power_electrical", "actuator.motor_power"),
    ("actuator.joint_torque", "gait.joint_torque"),
)
RECORD = ("gait.torque_demand", "actuator.joint_torque", "motor.current", "motor.winding_temperature")


def run(stop=STOP, step=STEP, record=RECORD, path=lambda model: archive(model, 2, PRESETS.get(model))):
    """Rows of `record` at every communication point."""
    slaves, reference, folders = {}, {}, []
    for name, model in FMUS.items():
        description = read_model_description(str(path(model)))
        folders.append(extract(str(path(model))))
        reference |= {f"{name}.{v.name}": v.valueReference for v in description.modelVariables}
        slave = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=folders[-1],
            instanceName=name,
        )
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slaves[name] = slave

    get = lambda name: slaves[name.split(".")[0]].getReal([reference[name]])[0]  # noqa: E731
    put = lambda name, value: slaves[name.split(".")[0]].setReal([reference[name]], [value])  # noqa: E731

    def exchange():
        values = [get(source) for source, _ in CONNECT]
        for (_, sink), value in zip(CONNECT, values):
            put(sink, value)

    for slave in slaves.values():
        slave.enterInitializationMode()
    for component, values in SET.items():
        for name, value in values.items():
            put(f"{component}.{name}", value)
    for component, choices in CHOOSE.items():
        for name, item in choices.items():
            slaves[component].setInteger([reference[f"{component}.{name}"]], [item])
    for _ in CONNECT:  # until values that pass through several FMUs have arrived
        exchange()
    for slave in slaves.values():
        slave.exitInitializationMode()
    rows = [[get(name) for name in record]]
    for k in range(round(stop / step)):
        exchange()
        for slave in slaves.values():
            slave.doStep(k * step, step)
        rows.append([get(name) for name in record])
    for slave, folder in zip(slaves.values(), folders):
        slave.terminate()
        slave.freeInstance()
        rmtree(folder, ignore_errors=True)
    return rows


if __name__ == "__main__":
    demand, torque, current, winding = zip(*run())
    errors = [a - b for a, b in zip(torque, demand)]
    answer = {
        "joint_torque_peak_Nm": max(torque),
        "torque_error_rms_Nm": (sum(e * e for e in errors) / len(errors)) ** 0.5,
        "current_peak_A": max(current),
        "winding_temperature_end_degC": winding[-1] - 273.15,
    }
    print(json.dumps(answer, indent=2))
