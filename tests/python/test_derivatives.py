"""Directional and adjoint derivatives equal finite differences by the importer, in every interface."""

from ctypes import c_double, c_int, c_uint

import numpy as np
import pytest
from clients import paths
from clients.fmu import Archive
from conftest import STANDARDS
from exchanged import Exchanged, elements, width
from fmpy.fmi1 import FMICallException
from test_model_exchange import (
    ACTUATOR,
    BARE,
    BLOCK,
    CROSSFLOW,
    CURRENT,
    EFFECTS,
    FRICTION,
    GAIT,
    GEARMOTOR,
    IMPOSED,
    MOTOR,
    POWER,
    PULL,
    PUSH,
    PWM,
    SINUSOIDAL,
)

RELATIVE = 1e-6

# Away from rest and from the limits of the inputs, where both sides of a difference are there.
POINT = {"ambient_temperature": 299.0}
FORCED = {"fan_command": 0.7, "ambient_pressure": 9.5e4, "annulus.length": 0.06, **POINT}
PUSHING = {
    "motor_angle": 9.0,
    "motor_speed": 40.0,
    "motor_current": 3.0,
    "joint_angle": 0.05,
    "joint_speed": 0.4,
    "torque_demand": 30.0,
}
CASES = {
    "voltage": (MOTOR, {"voltage": 24.0, "load_torque": 0.05, "fan_command": 0.5, **FRICTION, **POINT}),
    "pwm, effects": (MOTOR, {"drive_mode": PWM, "voltage": 36.0, "duty": 0.4, "load_torque": 0.03, "fan_command": 0.5, **EFFECTS}),
    "current, block": (
        MOTOR,
        {"drive_mode": CURRENT, "mechanical_mode": IMPOSED, "current_command": 5.0, "imposed_speed": 300.0, "commutation": BLOCK, **POINT},
    ),
    "power, crossflow": (MOTOR, {"drive_mode": POWER, "electrical_power": 20.0, "cooling_mode": CROSSFLOW, **FORCED}),
    "bare, sinusoidal": (MOTOR, {"voltage": 12.0, "cooling_mode": BARE, "commutation": SINUSOIDAL, **FRICTION, **POINT}),
    "push": (MOTOR, {"voltage": 20.0, "load_torque": 0.02, "cooling_mode": PUSH, **EFFECTS, **FORCED}),
    "pull": (MOTOR, {"voltage": 20.0, "load_torque": 0.02, "cooling_mode": PULL, **FRICTION, **FORCED}),
    "gearmotor": (GEARMOTOR, {"duty": 0.7, "load_torque": 0.3, "effect.contact_drop.V_b": 0.3, **POINT}),
    "gearmotor, discontinuous": (GEARMOTOR, {"duty": 0.25, "load_torque": 0.05, **POINT}),
    "actuator": (ACTUATOR, PUSHING),
    "actuator, elastic": (ACTUATOR, {**PUSHING, "transmission.coupling": 2, "spring.damping": 0.3}),
    "gait": (GAIT, {"joint_torque": 30.0, "gait.initial_phase": 0.37, "gait.variation": 0.03}),
}
# How many derivatives at least are not zero: of the interface that integrates, of the others.
MOVED = {MOTOR: (60, 5), GEARMOTOR: (60, 5), ACTUATOR: (60, 5), GAIT: (10, 1)}
# What follows a parameter of the fan's curve to 1e-4 of the slope alone.
HEAT = "heat_to_ambient"
# Steps integrate the linearized cooling; the derivatives over time are those of the full equations.
LINEARIZED = ("heat_to_ambient", "energy_heat_to_ambient")
# How far from the start the states are taken, by unit; a step of the run leads Co-Simulation away.
AWAY = {"A": 1.3, "rad/s": 7.0, "rad": 0.4, "K": 31.0, "J": 12.0, "N.m": 4.0, "V": 1.1, "1": 0.2}


@pytest.fixture(scope="module", params=STANDARDS, ids=lambda fmi: f"fmi{fmi}")
def both(request):
    """The archives of all models in one standard."""
    opened = {model: Archive(paths.archive(model, request.param)) for model in MOVED}
    yield opened
    for archive in opened.values():
        archive.__exit__()


def names(archive, keep):
    return [v.name for v in archive.description.modelVariables if v.type in ("Real", "Float64") and keep(v)]


def outputs(archive):
    """Outputs without the balance residuals, which are rounding errors."""
    return names(archive, lambda v: v.causality == "output" and not v.name.endswith("balance_error"))


def inputs(archive):
    return names(archive, lambda v: v.causality == "input")


def tunable(archive, start):
    """Parameters of the motor, and of the active effects."""
    on = {name.rsplit(".", 1)[0] for name in start if name.startswith("effect.")}
    keep = lambda v: v.variability == "tunable" and v.min != v.start != v.max and (
        v.name.rsplit(".", 1)[0] in on if v.name.startswith("effect.") else True
    )
    return names(archive, keep)


def difference(read, move, at, size, sizes):
    """The derivative of `read()` with respect to the variable that `move` changes: differences with one extrapolation. Also the rounding
    error: of the unknowns, and the disagreement of two differences where large terms cancel.
    """
    found, noise = [], None
    for way in (size, size / 2.0):
        move(at + way)
        ahead = np.array(read())
        move(at - way)
        behind = np.array(read())
        found.append((ahead - behind) / (2.0 * way))
        # An unknown may be what is left of terms of its typical size.
        noise = 8.0 * np.finfo(float).eps * np.maximum(np.abs(ahead), sizes) / way
    move(at)
    return (4.0 * found[1] - found[0]) / 3.0, noise + np.abs(found[1] - found[0])


def nominals(archive, unknowns):
    """The nominal value of each element."""
    return np.array([float(v.nominal or 1.0) for v, _ in elements([archive.variable(name) for name in unknowns])])


def labels(archive, unknowns):
    """The name of each element, as FMI 2 has it."""
    cells = elements([archive.variable(name) for name in unknowns])
    return [f"{v.name}[{k + 1}]" if width(v) > 1 else v.name for v, k in cells]


def states_of(archive):
    """The states with the places of their elements."""
    return elements([u.variable.derivative for u in archive.description.derivatives])


def flat(values):
    """Values, with lists flattened."""
    return np.array([x for value in values for x in (value if isinstance(value, list) else [value])])


def compare(derivatives, found, noise, known, unknowns):
    """Each derivative within 1e-6 of the difference plus its rounding error."""
    derivatives = np.array(derivatives)
    off = np.abs(derivatives - found) - RELATIVE * np.abs(found) - 2.0 * noise
    worst = int(np.argmax(off))
    assert off[worst] <= 0.0, (known, unknowns[worst], derivatives[worst], found[worst], noise[worst])
    return np.count_nonzero(np.abs(found) > noise)


def way(variable, at):
    """Step of the differences: small enough for the curvature, large enough for rounding."""
    return 2e-5 * max(abs(at), 0.1 * float(variable.nominal or 1.0))


@pytest.mark.parametrize("case", CASES)
def test_model_exchange(case, both):
    model, start = CASES[case]
    archive = both[model]
    instance = Exchanged(archive, start)
    try:
        states, rates = states_of(archive), [u.variable.name for u in archive.description.derivatives]
        x = [at + AWAY[s.unit] * (1.0 + 0.03 * k) for k, ((s, _), at) in enumerate(zip(states, instance.states()))]
        instance.put(x, 3.0)
        shown = outputs(archive)
        unknowns, sizes = rates + shown, nominals(archive, rates + shown)
        names_of = labels(archive, unknowns)
        read = lambda: instance.rates() + instance.get(shown)
        moved = 0

        for k, (state, element) in enumerate(states):
            move = lambda value: instance.put([*x[:k], value, *x[k + 1 :]])
            found, noise = difference(read, move, x[k], way(state, x[k]), sizes)
            moved += compare(instance.derivative(unknowns, state.name, element), found, noise, state.name, names_of)
        for name in inputs(archive):
            at = instance.get([name])[0]
            if at == 0.0:
                continue  # its mode has no use for it, or it stands at a limit
            found, noise = difference(read, lambda value: instance.set({name: value}), at, way(archive.variable(name), at), sizes)
            moved += compare(instance.derivative(unknowns, name), found, noise, name, names_of)
        instance.model.enterEventMode()
        for name in tunable(archive, start):
            at = instance.get([name])[0]
            if at == 0.0:
                continue
            found, noise = difference(read, lambda value: instance.set({name: value}), at, way(archive.variable(name), at), sizes)
            moved += compare(instance.derivative(unknowns, name), found, noise, name, names_of)
        assert moved > MOVED[model][0], moved
    finally:
        instance.close()


def derivative(instance, unknowns, known):
    """As in Co-Simulation."""
    references = [instance.reference(name) for name in unknowns], [instance.reference(known)]
    more = {} if instance.archive.version == "2.0" else {"nSensitivity": len(labels(instance.archive, unknowns))}
    return instance.slave.getDirectionalDerivative(*references, [1.0], **more)


@pytest.mark.parametrize("case", CASES)
def test_before_initialization_ends(case, both):
    """Every output and state with respect to everything that determines the start, by differences of initializations."""
    model, start = CASES[case]
    archive = both[model]
    with archive.instance() as instance:
        instance.set(start)
        if archive.version == "2.0":
            instance.slave.setupExperiment(startTime=0.0)
        instance.slave.enterInitializationMode()
        unknowns = list(dict.fromkeys([*outputs(archive), *(state.name for state, _ in states_of(archive))]))
        sizes, names_of = nominals(archive, unknowns), labels(archive, unknowns)
        read = lambda: flat(instance.get(*unknowns))
        moved = 0
        for name in [*inputs(archive), *tunable(archive, start)]:
            at = instance.get(name)[0]
            if at == 0.0:
                continue
            found, noise = difference(read, lambda value: instance.set({name: value}), at, way(archive.variable(name), at), sizes)
            moved += compare(derivative(instance, unknowns, name), found, noise, name, names_of)
        assert moved > MOVED[model][1], moved


@pytest.mark.parametrize("case", CASES)
def test_co_simulation(case, both):
    model, start = CASES[case]
    archive = both[model]
    with archive.instance() as instance:
        instance.initialise(start)
        for _ in range(20):
            instance.step(0.05)
        unknowns = [name for name in outputs(archive) if name != HEAT or "cooling_mode" not in start]
        sizes, names_of = nominals(archive, unknowns), labels(archive, unknowns)
        read = lambda: flat(instance.get(*unknowns))
        moved = 0
        for name in inputs(archive) + tunable(archive, start):
            at = instance.get(name)[0]
            if at == 0.0:
                continue
            found, noise = difference(read, lambda value: instance.set({name: value}), at, way(archive.variable(name), at), sizes)
            moved += compare(derivative(instance, unknowns, name), found, noise, name, names_of)
        assert moved > MOVED[model][1], moved


@pytest.mark.parametrize("case", ("voltage", "push", "gearmotor"))
def test_a_direction_is_a_sum_and_the_adjoint_is_the_transpose(case, both):
    model, start = CASES[case]
    archive = both[model]
    instance = Exchanged(archive, start)
    try:
        states = states_of(archive)
        instance.put([at + AWAY[s.unit] for (s, _), at in zip(states, instance.states())])
        cells = [*((state.name, element) for state, element in states), ("load_torque", 0)]
        knowns = list(dict.fromkeys(name for name, _ in cells))
        unknowns = [*(u.variable.name for u in archive.description.derivatives), "winding_resistance"]
        jacobian = np.array([instance.derivative(unknowns, name, element) for name, element in cells]).T
        seed = [float(s.nominal) * (1.0 + 0.1 * k) * (-1) ** k * 1e-3 for k, (s, _) in enumerate(states)] + [0.01]
        along = instance.along(unknowns, knowns, seed)
        np.testing.assert_allclose(along, jacobian @ seed, rtol=1e-6, atol=1e-9 * np.abs(jacobian * seed).max())
        if not instance.two:
            rows = np.linspace(-1.0, 2.0, len(jacobian))
            references = [[instance.reference(name) for name in some] for some in (unknowns, knowns)]
            transposed = instance.model.getAdjointDerivative(*references, rows, nSensitivity=len(cells))
            np.testing.assert_allclose(transposed, rows @ jacobian, rtol=1e-9)
    finally:
        instance.close()


def test_what_has_no_derivative_is_refused(both):
    archive = both[MOTOR]
    instance = Exchanged(archive, {"voltage": 12.0})
    try:
        reference = instance.reference
        x = instance.states()
        x[4] += 20.0
        instance.put(x)
        ask = lambda unknown, known: instance.model.getDirectionalDerivative([reference(unknown)], [reference(known)], [1.0])
        assert ask("der(state.current)", "voltage")[0] > 0.0
        for unknown, known in [
            ("voltage", "load_torque"),  # set, not computed
            ("current", "shaft_speed"),  # an output moves nothing
            ("der(state.core_temperature)", "fan_command"),  # n^0.8 has an infinite slope at 0
        ]:
            with pytest.raises(FMICallException):
                ask(unknown, known)
        # A seed of zero asks nothing, and a refusal leaves the instance as it was.
        assert instance.model.getDirectionalDerivative([reference("current")], [reference("fan_command")], [0.0]) == [0.0]
        assert instance.states() == x
    finally:
        instance.close()


@pytest.mark.parametrize("case", ("voltage", "push", "gearmotor"))
def test_derivatives_of_outputs_are_their_slopes(case, both):
    """Compared with steps of 1 us from a saved state with constant inputs. These are short relative to L/R = 0.2 ms of the winding, so the
    remaining error of the current decays as the derivative predicts; otherwise exact apart from rounding.
    """
    model, start = CASES[case]
    archive = both[model]
    with archive.instance() as instance:
        instance.initialise(start)
        for _ in range(40):
            instance.step(0.01)
        unknowns = [name for name in outputs(archive) if name not in LINEARIZED or "cooling_mode" not in start]
        references, names_of = [instance.reference(name) for name in unknowns], labels(archive, unknowns)
        slave, ones = instance.slave, (c_int * len(unknowns))(*[1] * len(unknowns))
        count, found = len(references), (c_double * len(names_of))()
        if archive.version == "2.0":
            slave.fmi2GetRealOutputDerivatives(slave.component, (c_uint * count)(*references), count, ones, found)
        else:
            slave.fmi3GetOutputDerivatives(slave.component, (c_uint * count)(*references), count, ones, found, len(found))
        found = np.array(found)
        here, h = flat(instance.get(*unknowns)), 1e-6
        ahead, state = {}, instance.state()
        for ways in (1, 2, 4):
            instance.restore(state)
            instance.step(ways * h)
            ahead[ways] = flat(instance.get(*unknowns))
        # Forward differences, with their term of first order removed. Values that are solutions of equations, such as the flow through a
        # fan, are rounded more; an error of `here` is in the short difference twice as much as in what the two differ.
        short, long = ((4.0 * ahead[ways] - ahead[2 * ways] - 3.0 * here) / (2.0 * ways * h) for ways in (1, 2))
        noise = 16.0 * np.finfo(float).eps * np.maximum(np.abs(here), nominals(archive, unknowns)) / h + 2.0 * np.abs(short - long)
        compare(found, short, noise / 2.0, case, names_of)
        assert np.count_nonzero(np.abs(found) > 1e3 * noise) > 8
