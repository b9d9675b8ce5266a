"""What a specimen may have that the preset lacks: one small function per effect, each a term at a port of the motor.

A law takes the instant `x` (a `generator.Instant`: t s, drive in its unit, i A, w rad/s, n 1, T_a, T_w, T_h degC, torque N m at
the shaft) and its parameters, and gives what it adds at its port:

    drag_torque                  N m that slow the shaft; their power heats the housing
    terminal_voltage             V between terminals and winding; their power heats the winding
    winding_resistance           share of the resistance
    torque_constant              share of the torque constant
    winding_heat, housing_heat   W from elsewhere
    winding_housing_resistance   share of the resistance
    housing_ambient_conductance  W/K
    heat_capacity                share of the housing's capacity
    fan_flow                     share of the fan command that arrives
    ambient_sensor               K from the shown to the true ambient temperature
    winding_sensor, housing_sensor   K from the node's temperature to the reading

*Source*: the listed laws are those of the design's table of effects, the others what benches show. Ranges are (low, high) of a
size that a motor of 0.4 Ohm, 30 mN m/A and 6 A can have; they are drawn log-uniformly, with a random sign where `signed`, and
carried over to another motor as `scale` says.
"""

from math import copysign, cos, exp, pi, tanh

import numpy as np

from .law import CATALOGUE, KELVIN, effect, known

W_SMALL = 5.0  # rad/s, within which a friction changes sign
I_SMALL = 0.05  # A, the same for a contact
T_REF = 25.0  # degC, at which shares are zero
ROOM = 20.0  # degC

TORQUE = {"torque": 1}
VOLTAGE = {"voltage": 1}
POWER = {"power": 1}
CONDUCTANCE = {"conductance": 1}


def power(w, exponent):
    """|w|^exponent with the sign of w."""
    return copysign(abs(w) ** exponent, w)


# --- in the design's list


@known("drag_torque", "speed", "k w^0.5", k=(6e-5, 1.5e-4), scale={"k": TORQUE | {"speed": -0.5}})
def iron_loss(x, k):
    return k * power(x.w, 0.5)


@known("drag_torque", "speed", "k w", k=(2e-6, 6e-6), scale={"k": TORQUE | {"speed": -1}})
def viscous_friction(x, k):
    return k * x.w


@known("drag_torque", "speed", "k w^2", k=(2e-9, 6e-9), scale={"k": TORQUE | {"speed": -2}})
def windage(x, k):
    return k * power(x.w, 2.0)


@known("drag_torque", "load_torque", "mu |shaft torque|", mu=(0.03, 0.12))
def load_dependent_friction(x, mu):
    """Shaft torque after this friction: s = t - mu |s| tanh(w/w_small), solved for s."""
    share = mu * tanh(x.w / W_SMALL)
    return share * abs(x.torque) / (1.0 + copysign(share, x.torque))


@known("terminal_voltage", "current", "V_b tanh(i / 0.05 A)", V_b=(0.1, 0.5), scale={"V_b": VOLTAGE})
def contact_drop(x, V_b):
    return V_b * tanh(x.i / I_SMALL)


@known("housing_ambient_conductance", "housing_temperature", "k (T_h^4 - T_a^4)", k=(4e-10, 1e-9), scale={"k": CONDUCTANCE})
def housing_radiation(x, k):
    """The heat divided by its temperature difference, so that it is smooth at zero difference."""
    h, a = x.T_h + KELVIN, x.T_a + KELVIN
    return k * (h * h + a * a) * (h + a)


@known(
    "housing_ambient_conductance",
    "history",
    "G in some runs",
    G=(0.03, 0.1),
    some_runs=True,
    fixed=(("node", "housing"),),
    scale={"G": CONDUCTANCE},
)
def forced_convection(x, G):
    """Constant. In all runs it would be the conductance itself; in some runs it is, for example, an open window."""
    return G


@known("fan_flow", "fan_command", "n (1 - k n)", k=(0.15, 0.45))
def fan_back_pressure(x, k):
    return -k * x.n


@known("winding_housing_resistance", "winding_temperature", "R_wh (1 + beta (T_w - 25))", beta=(0.006, 0.02))
def interface_temperature(x, beta):
    return beta * (x.T_w - T_REF)


@known(
    "heat_capacity",
    "winding_temperature",
    "a node of C_s behind R_wh and before R_sh",
    R_sh=(0.15, 0.4),
    C_s=(20.0, 60.0),
    scale={"R_sh": {"conductance": -1}, "C_s": {"capacity": 1}},
)
def stator_node(x, R_sh, C_s):
    """No term: the generator has the node."""
    return 0.0


@known(
    "torque_constant",
    "time",
    "k_t (1 - fraction) from time on",
    fraction=(0.02, 0.06),
    time=(500.0, 3000.0),
    switch=lambda x, was_on, fraction, time: x.t >= time,
)
def demagnetisation(x, fraction, time):
    return -fraction


@known("ambient_sensor", "time", "true = shown + rate t", rate=(1e-5, 5e-5), signed=True)
def ambient_drift(x, rate):
    return rate * x.t


def lagged(times, readings, tau):
    """First-order lag of a reading that is linear between rows; starts at the temperature of the node. Exact."""
    shown = [readings[0]]
    for h, before, now in zip(np.diff(times), readings, readings[1:]):
        slope = (now - before) / h
        shown.append(now - slope * tau + (shown[-1] - before + slope * tau) * exp(-h / tau))
    return np.array(shown)


@known("housing_sensor", "history", "tau dT/dt = T_h - T", tau=(20.0, 90.0), filter=lagged)
def housing_sensor_lag(x, tau):
    return 0.0


@known("winding_sensor", "time", "T_w + offset", offset=(0.5, 3.0), signed=True)
def winding_sensor_offset(x, offset):
    return offset


@known("housing_sensor", "time", "T_h + offset", offset=(0.5, 3.0), signed=True)
def housing_sensor_offset(x, offset):
    return offset


@known("winding_sensor", "winding_temperature", "T_w - k (T_w - T_a)", k=(0.02, 0.08))
def winding_sensor_stem_loss(x, k):
    return -k * (x.T_w - x.T_a)


@known("housing_sensor", "housing_temperature", "T_h - k (T_h - T_a)", k=(0.02, 0.08))
def housing_sensor_stem_loss(x, k):
    return -k * (x.T_h - x.T_a)


@known("winding_heat", "history", "(1 - share) P into the winding", share=(0.05, 0.25), some_runs=True, drive="power")
def drive_loss(x, share):
    """In some runs, with another drive: in all runs it would be equivalent to other capacities, conductances and resistances."""
    return -share * x.drive


@known("winding_sensor", "history", "tau dT/dt = T_w - T", tau=(4.0, 15.0), filter=lagged)
def winding_sensor_lag(x, tau):
    return 0.0


# --- in no list


@effect("drag_torque", "speed", "k w^0.75", k=(1e-5, 3e-5), scale={"k": TORQUE | {"speed": -0.75}})
def drag_power_075(x, k):
    return k * power(x.w, 0.75)


@effect("drag_torque", "speed", "k w^1.3", k=(2.5e-7, 8e-7), scale={"k": TORQUE | {"speed": -1.3}})
def drag_power_13(x, k):
    return k * power(x.w, 1.3)


@effect("drag_torque", "winding_temperature", "k (T_w - 25) tanh(w / 5 rad/s)", k=(4e-5, 1.5e-4), scale={"k": TORQUE})
def drag_rising_with_winding(x, k):
    """A swelling seal: the drag torque rises with winding temperature."""
    return k * (x.T_w - T_REF) * tanh(x.w / W_SMALL)


@effect("drag_torque", "housing_temperature", "tau exp(-(T_h - 25) / 20) tanh(w / 5 rad/s)", tau=(0.003, 0.008), scale={"tau": TORQUE})
def grease_thinning(x, tau):
    return tau * exp(-(x.T_h - T_REF) / 20.0) * tanh(x.w / W_SMALL)


@effect("drag_torque", "current", "k i^2 tanh(w / 5 rad/s)", k=(1.5e-4, 5e-4), scale={"k": TORQUE | {"current": -2}})
def drag_with_current(x, k):
    return k * x.i * x.i * tanh(x.w / W_SMALL)


@effect(
    "drag_torque",
    "history",
    "tau tanh(w / 5 rad/s) from the moment T_w has passed T_on",
    tau=(0.003, 0.008),
    T_on=(38.0, 48.0),
    switch=lambda x, was_on, tau, T_on: was_on or x.T_w > T_on,
    scale={"tau": TORQUE},
)
def latched_drag(x, tau, T_on):
    """A bearing that loses its preload for the rest of the run."""
    return tau * tanh(x.w / W_SMALL)


@effect(
    "housing_ambient_conductance",
    "history",
    "G from T_h above T_on to T_h below T_on - 8",
    G=(0.04, 0.12),
    T_on=(36.0, 44.0),
    switch=lambda x, was_on, G, T_on: x.T_h > (T_on - 8.0 if was_on else T_on),
    scale={"G": CONDUCTANCE},
)
def thermostat(x, G, T_on):
    return G


@effect("torque_constant", "current", "k_t (1 - k i^2)", k=(1e-3, 4e-3), scale={"k": {"current": -2}}, drive="current")
def saturation(x, k):
    """With imposed voltage a fast motor would have two solutions for the current."""
    return -k * x.i * x.i


@effect("winding_resistance", "current", "R (1 + k |i|)", k=(0.01, 0.04), scale={"k": {"current": -1}})
def resistance_with_current(x, k):
    return k * abs(x.i)


@effect("winding_resistance", "time", "R (1 + rate t)", rate=(1e-6, 4e-6))
def resistance_ageing(x, rate):
    return rate * x.t


@effect("terminal_voltage", "current", "k sqrt(i)", k=(0.05, 0.2), scale={"k": VOLTAGE | {"current": -0.5}})
def drop_with_root_of_current(x, k):
    return k * power(x.i, 0.5)


@effect("housing_heat", "fan_command", "P n", P=(1.5, 4.0), scale={"P": POWER})
def fan_heat(x, P):
    """The loss of the fan, blown over the housing."""
    return P * x.n


@effect("housing_heat", "history", "P (1 - cos(2 pi t / period)) / 2", P=(1.5, 4.0), period=(600.0, 1800.0), scale={"P": POWER})
def periodic_heat(x, P, period):
    """A neighbouring device on the bench that switches on and off."""
    return P * (1.0 - cos(2.0 * pi * x.t / period)) / 2.0


@effect("housing_ambient_conductance", "housing_temperature", "k max(T_h - 25, 0)^1.5", k=(1.5e-4, 6e-4), scale={"k": CONDUCTANCE})
def conductance_with_housing(x, k):
    return k * max(x.T_h - T_REF, 0.0) ** 1.5


@effect("housing_ambient_conductance", "ambient_temperature", "k (T_a - 20)", k=(0.004, 0.012), scale={"k": CONDUCTANCE})
def conductance_with_room(x, k):
    """An air flow from a room ventilation that opens at high temperature."""
    return k * (x.T_a - ROOM)


@effect("heat_capacity", "housing_temperature", "C_h (1 + beta (T_h - 25))", beta=(0.004, 0.012))
def capacity_with_temperature(x, beta):
    return beta * (x.T_h - T_REF)


@effect("fan_flow", "ambient_temperature", "n (1 - k (T_a - 20))", k=(0.015, 0.04))
def fan_fading_with_room(x, k):
    return -k * (x.T_a - ROOM)


@effect("winding_sensor", "current", "T_w + k i^2", k=(0.05, 0.2), scale={"k": {"current": -2}})
def winding_sensor_pickup(x, k):
    return k * x.i * x.i
