"""Model Exchange: fmpy integrates the equations of Co-Simulation and handles the events."""

import numpy as np
import pytest
from clients import paths
from conftest import STANDARDS
from exchanged import width
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.simulation import instantiate_fmu
from fmpy.validation import validate_fmu

MOTOR, GEARMOTOR, ACTUATOR, GAIT = "AnnulusCooledMotor", "BrushedGearmotor", "SeriesElasticActuator", "GaitLoad"
AGREE = 1e-5  # of the largest value of the run (of temperatures: the largest rise), or of a hundredth of the nominal value
TIGHT = 1e-9  # CVODE's relative tolerance

# Choices by their FMI value, as fmpy takes them.
VOLTAGE, PWM, CURRENT, POWER = 1, 2, 3, 4
FREE, IMPOSED = 1, 2
CONDUCTANCE, BARE, CROSSFLOW, PUSH, PULL = 1, 2, 3, 4, 5
DC, BLOCK, SINUSOIDAL = 1, 2, 3

FRICTION = {"effect.coulomb_friction.tau_c": 9.83e-3, "effect.viscous_friction.k": 2e-6}
EFFECTS = {
    **FRICTION,
    "effect.iron_loss.k": 1e-4,
    "effect.windage.k": 2e-9,
    "effect.load_dependent_friction.mu": 0.06,
    "effect.contact_drop.V_b": 0.4,
    "effect.housing_radiation.k": 6e-10,
    "effect.interface_temperature.beta": 0.004,
    "effect.ambient_drift.rate": 0.01,
    "effect.housing_sensor_lag.tau": 20.0,
    "effect.winding_sensor_lag.tau": 6.0,
    "effect.housing_sensor_stem_loss.k": 0.06,
    "effect.stator_node.C_s": 20.0,
}
BRIDGE = {"effect.pwm_ripple.f": 20e3, "effect.bridge_drop.V_0": 0.8, "effect.dead_time.share": 0.02}

# name: model, end in s, output interval in s, start values
CASES = {
    "voltage, free": (MOTOR, 0.5, 1e-3, {"voltage": 24.0, "load_torque": 0.05, **FRICTION}),
    "pwm, free, bridge": (MOTOR, 0.5, 1e-3, {"drive_mode": PWM, "voltage": 36.0, "duty": 0.4, "load_torque": 0.03, **BRIDGE}),
    "current, imposed": (
        MOTOR, 600.0, 1.0, {"drive_mode": CURRENT, "mechanical_mode": IMPOSED, "current_command": 5.0, "imposed_speed": 300.0, **EFFECTS}
    ),
    "current, free, sensor": (MOTOR, 2.0, 1e-2, {"drive_mode": CURRENT, "current_command": 2.0, "load_torque": 0.03, **EFFECTS}),
    "power, crossflow": (MOTOR, 600.0, 1.0, {"drive_mode": POWER, "electrical_power": 20.0, "fan_command": 0.6, "cooling_mode": CROSSFLOW}),
    "bare": (MOTOR, 1800.0, 2.0, {"drive_mode": CURRENT, "mechanical_mode": IMPOSED, "current_command": 6.0, "cooling_mode": BARE}),
    "push, effects": (
        MOTOR,
        300.0,
        0.5,
        {
            "drive_mode": CURRENT,
            "mechanical_mode": IMPOSED,
            "current_command": 6.0,
            "imposed_speed": 500.0,
            "fan_command": 0.8,
            "cooling_mode": PUSH,
            "air_segments": 5,
            **EFFECTS,
            "effect.ambient_drift.rate": 0.0,
        },
    ),
    "pull": (
        MOTOR,
        300.0,
        0.5,
        {"drive_mode": POWER, "electrical_power": 25.0, "fan_command": 1.0, "cooling_mode": PULL, "ambient_pressure": 8e4},
    ),
    "stall, sinusoidal": (
        MOTOR, 2.0, 1e-3, {"drive_mode": CURRENT, "mechanical_mode": IMPOSED, "current_command": 5.0, "commutation": SINUSOIDAL, "imposed_speed": 0.5}
    ),
    "gearmotor": (GEARMOTOR, 3.0, 1e-2, {"duty": 0.7, "load_torque": 0.3}),
    "gearmotor, discontinuous": (
        GEARMOTOR, 3.0, 1e-2, {"duty": 0.25, "load_torque": 0.05, "effect.contact_drop.V_b": 0.5, "effect.ambient_drift.rate": 0.01}
    ),
    "actuator, elastic coupling": (
        ACTUATOR, 0.5, 1e-3, {"transmission.coupling": 2, "motor_angle": 20.0, "motor_current": 1.5, "torque_demand": 30.0, "drive.efficiency": 0.9}
    ),
    "gait": (GAIT, 3.0, 1e-2, {"gait.variation": 0.05, "gait.start_time": 0.3, "gait.stop_time": 2.5, "gait.ramp_time": 0.5}),
    "gait, stairs": (GAIT, 2.8, 7e-3, {"gait.activity": 6, "gait.joint": 2, "joint_torque": 40.0}),
    "gearmotor, reverse": (GEARMOTOR, 1.0, 1e-3, {"duty": -0.9, "load_torque": -0.5, "drive.decay": 2}),
}


def run(model, fmi, kind, stop, interval, start, **options):
    """The outputs of a run of fmpy's master, by name, and its description."""
    path = str(paths.archive(model, fmi))
    description = read_model_description(path)
    # fmpy's master does not configure FMI 3: sizes of arrays are set for it.
    sizes = {v.name: v for v in description.modelVariables if v.causality == "structuralParameter" and v.name in start}
    names = [v.name for v in description.modelVariables if v.causality == "output" and not (sizes and v.dimensions)]
    made = instantiate_fmu(extract(path), description, kind) if sizes else None
    for name, variable in sizes.items():
        made.enterConfigurationMode()
        made.setUInt64([variable.valueReference], [start[name]])
        made.exitConfigurationMode()
    if sizes and kind == "ModelExchange":
        description.numberOfContinuousStates = made.getNumberOfContinuousStates()
    result = simulate_fmu(
        path,
        model_description=description,
        fmi_type=kind,
        fmu_instance=made,
        start_values={name: value for name, value in start.items() if name not in sizes},
        stop_time=stop,
        output_interval=interval,
        relative_tolerance=TIGHT,
        record_events=options.pop("record_events", False),
        output=options.pop("output", names),
        **options,
    )
    return result, description


def disagreement(one, other, description):
    """Largest difference of each output, relative to its nominal value."""
    variables = {v.name: v for v in description.modelVariables}
    errors = {}
    for name in one.dtype.names:
        # Zero apart from rounding and the importer's own error: no scale of their own.
        if name == "time" or name.endswith("balance_error") or one[name].dtype == bool:
            continue
        zero = one[name][0] if variables[name].unit == "K" else 0.0
        size = max(np.abs(one[name] - zero).max(), 0.01 * float(variables[name].nominal))
        errors[name] = float(np.abs(one[name] - other[name]).max() / size)
    return errors


@pytest.mark.parametrize("fmi", STANDARDS)
@pytest.mark.parametrize("case", CASES)
def test_cvode_agrees_with_co_simulation(case, fmi):
    model, stop, interval, start = CASES[case]
    stepped, description = run(model, fmi, "CoSimulation", stop, interval, start)
    integrated, _ = run(model, fmi, "ModelExchange", stop, interval, start)
    assert len(stepped) == len(integrated) == round(stop / interval) + 1
    errors = disagreement(stepped, integrated, description)
    worst = max(errors, key=errors.get)
    assert errors[worst] < AGREE, (worst, errors[worst])
    moved = [name for name in errors if np.ptp(stepped[name]) > 0.0]
    assert len(moved) >= min(8, len(errors) // 2), moved


@pytest.mark.parametrize("fmi", STANDARDS)
@pytest.mark.parametrize("model", (MOTOR, GEARMOTOR, ACTUATOR, GAIT))
def test_fmpy_finds_nothing(model, fmi):
    path = str(paths.archive(model, fmi))
    assert validate_fmu(path) == []
    description = read_model_description(path)
    states = [u.variable.derivative for u in description.derivatives]
    count = {MOTOR: 26, GEARMOTOR: 15, ACTUATOR: 8, GAIT: 2}[model]
    assert sum(map(width, states)) == description.numberOfContinuousStates == count
    for unknown, state in zip(description.derivatives, states):
        assert unknown.variable.name == f"der({state.name})"
    assert description.numberOfEventIndicators == {MOTOR: 3, GEARMOTOR: 3, ACTUATOR: 4, GAIT: 1}[model]


@pytest.mark.parametrize("fmi", STANDARDS)
def test_the_limit_is_an_event(fmi):
    start = {"drive_mode": CURRENT, "mechanical_mode": IMPOSED, "current_command": 30.0}
    names = ["winding_margin", "over_temperature"]
    result, _ = run(MOTOR, fmi, "ModelExchange", 60.0, 5.0, start, output=names, record_events=True)
    hot = result["over_temperature"].astype(bool)
    first = int(np.argmax(hot))
    assert hot[first:].all() and not hot[:first].any() and 0 < first < len(hot) - 1
    # The flag turns at the event alone: before and after it the record has the same time, and the margin is zero there.
    assert result["time"][first - 1] == result["time"][first]
    assert abs(result["winding_margin"][first]) < 1e-6
    assert abs(result["time"][first] / 5.0 - round(result["time"][first] / 5.0)) > 1e-6, "between two samples"


@pytest.mark.parametrize("fmi", STANDARDS)
def test_magnets_lose_strength_at_their_time(fmi):
    start = {"voltage": 24.0, "effect.demagnetisation.fraction": 0.2, "effect.demagnetisation.time": 0.0337, **FRICTION}
    stepped, description = run(MOTOR, fmi, "CoSimulation", 0.1, 1e-3, start)
    integrated, _ = run(MOTOR, fmi, "ModelExchange", 0.1, 1e-3, start)
    errors = disagreement(stepped, integrated, description)
    assert max(errors.values()) < AGREE, errors
    k_t = integrated["torque_constant"]
    assert k_t[33] > 1.2 * k_t[34] and np.ptp(k_t[:33]) < 1e-4 * k_t[0]


@pytest.mark.parametrize("fmi", STANDARDS)
def test_block_commutation_turns_by_sectors(fmi):
    """Two pole pairs at 3 rad/s: a sector of 60 electrical degrees each 0.1745 s."""
    start = {"drive_mode": CURRENT, "mechanical_mode": IMPOSED, "current_command": 5.0, "imposed_speed": 3.0, "commutation": BLOCK}
    names = ["winding_hot_spot_temperature", "winding_resistance"]
    result, _ = run(MOTOR, fmi, "ModelExchange", 2.0, 0.05, start, output=names, record_events=True)
    time = result["time"]
    events = time[1:][np.diff(time) == 0.0]
    assert events == pytest.approx(np.pi / 18 * np.arange(1, 12), abs=1e-6)
    # The mean over a step is what Co-Simulation holds; with small steps both are the same.
    stepped, _ = run(MOTOR, fmi, "CoSimulation", 2.0, 1e-3, start, output=names)
    shown = np.interp(time, stepped["time"], stepped["winding_hot_spot_temperature"])
    rise = np.ptp(stepped["winding_hot_spot_temperature"])
    assert np.abs(result["winding_hot_spot_temperature"] - shown).max() < 1e-3 * rise


@pytest.mark.parametrize("fmi", STANDARDS)
def test_the_bridge_turns_with_the_duty(fmi):
    """A duty cycle that jumps from forward to reverse is an event of the input, at which the bridge reverses."""
    signals = np.array([(0.0, 0.6), (0.3, 0.6), (0.3, -0.6), (0.6, -0.6)], dtype=[("time", "f8"), ("duty", "f8")])
    stepped, description = run(GEARMOTOR, fmi, "CoSimulation", 0.6, 1e-3, {}, input=signals)
    integrated, _ = run(GEARMOTOR, fmi, "ModelExchange", 0.6, 1e-3, {}, input=signals)
    # fmpy's Co-Simulation shows outputs at the jump with the new duty, its Model Exchange with the old one.
    away = np.abs(stepped["time"] - 0.3) > 1e-9
    errors = disagreement(stepped[away], integrated[away], description)
    worst = max(errors, key=errors.get)
    assert errors[worst] < AGREE, (worst, errors[worst])
    assert stepped["shaft_speed"][299] > 1.5 and stepped["shaft_speed"][-1] < -0.9
