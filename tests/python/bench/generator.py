"""The two-node motor with imposed current and speed, integrated on its own, for bench experiments with a known answer.

    voltage       = R i + k_t w + drops                        R   = R_ref [1 + alpha (T_w - T_ref)]
    shaft torque  = k_t i - drag                               k_t = k_t,ref [1 + alpha_mag (T_h - T_ref)]
    drag          = tau_c tanh(w / w_small) + further drags    G   = G_still + G_forced n^0.8
    C_w dT_w/dt   = R i^2 + drops i - (T_w - T_h) / R_wh
    C_h dT_h/dt   = (T_w - T_h) / R_wh + drag w - G (T_h - T_a)

plus what `effects` add at their ports. *Assumes* that inputs run linearly between rows and that every node starts at the room's
true temperature. *Integrates* with the classical Runge-Kutta method, equal substeps between two rows, at most `SUBSTEP` of the
fastest time constant; laws that switch do so at rows, so that each stretch is smooth.
*Source*: README of the public bench sets.
"""

from dataclasses import dataclass
from math import ceil, tanh

import numpy as np

from .law import KELVIN

INPUTS = ("current_A", "speed_rad_per_s", "fan_command_1", "ambient_temperature_degC")
OUTPUTS = ("voltage_V", "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC")
TEMPERATURE_SENSORS = {"winding_sensor": OUTPUTS[2], "housing_sensor": OUTPUTS[3]}

PORTS_INSIDE = (
    "drag_torque",
    "terminal_voltage",
    "winding_resistance",
    "torque_constant",
    "winding_heat",
    "housing_heat",
    "winding_housing_resistance",
    "housing_ambient_conductance",
    "heat_capacity",
    "fan_flow",
)

# The declared motor: every value of the equations above, SI units.
NOMINAL = {
    "motor.R_ref": 0.386,
    "motor.T_ref": 298.15,
    "motor.alpha": 0.0039,
    "motor.k_t": 0.0276,
    "motor.alpha_mag": -0.0012,
    "thermal.R_wh": 0.21,
    "thermal.C_w": 10.05,
    "thermal.C_h": 159.0,
    "conductance.G_still": 0.1351,
    "conductance.G_forced": 0.35,
    "effect.coulomb_friction.tau_c": 0.005,
    "effect.coulomb_friction.w_small": 5.0,
}
# How far specimens scatter around it: relative standard deviations.
PRIOR = {
    "motor.R_ref": 0.03,
    "motor.k_t": 0.02,
    "effect.coulomb_friction.tau_c": 0.3,
    "thermal.R_wh": 0.15,
    "thermal.C_w": 0.1,
    "conductance.G_still": 0.1,
    "conductance.G_forced": 0.15,
    "thermal.C_h": 0.05,
}
SCATTER_LIMIT = 2.5  # standard deviations; keeps every parameter positive
SUBSTEP = 0.25  # of the fastest time constant: an error below 1e-4 K
EXPONENT = 0.8  # of the fan command in the forced conductance


def draw_specimen(rng) -> dict:
    """The parameters with a prior, of one motor."""
    scatter = {name: np.clip(rng.standard_normal(), -SCATTER_LIMIT, SCATTER_LIMIT) for name in PRIOR}
    return {name: float(NOMINAL[name] * (1.0 + PRIOR[name] * scatter[name])) for name in PRIOR}


@dataclass
class Instant:
    """What a law may look at: time s, current A, speed rad/s, fan command 1, temperatures degC, shaft torque so far N m."""

    t: float = 0.0
    i: float = 0.0
    w: float = 0.0
    n: float = 0.0
    T_a: float = 0.0
    T_w: float = 0.0
    T_h: float = 0.0
    torque: float = 0.0


@dataclass
class Record:
    """A run as a perfect bench would see it, and its energy books in J: in by terminals and sources, out to the room."""

    outputs: dict
    supplied: float
    released: float
    winding: np.ndarray  # true temperatures, degC
    housing: np.ndarray
    stator: np.ndarray


class Motor:
    """A specimen with its effects; one object per run, since switching effects have a memory."""

    def __init__(self, specimen: dict, effects=()):
        p = NOMINAL | specimen
        self.R_ref, self.k_t_ref = p["motor.R_ref"], p["motor.k_t"]
        self.alpha, self.alpha_mag, self.T_ref = p["motor.alpha"], p["motor.alpha_mag"], p["motor.T_ref"] - KELVIN
        self.R_wh, self.C_w, self.C_h = p["thermal.R_wh"], p["thermal.C_w"], p["thermal.C_h"]
        self.G_still, self.G_forced = p["conductance.G_still"], p["conductance.G_forced"]
        self.tau_c, self.w_small = p["effect.coulomb_friction.tau_c"], p["effect.coulomb_friction.w_small"]
        # Friction of the load comes last: it needs the torque that the others leave.
        self.effects = sorted(effects, key=lambda e: e.law.driver == "load_torque")
        self.inside = [e for e in self.effects if not e.law.port.endswith("_sensor")]
        self.on = {e.law.id: e.law.switch is None for e in self.effects}
        self.stator = next((e.parameters for e in self.effects if e.law.id == "stator_node"), None)

    def fastest(self) -> float:
        """The shortest time constant, s."""
        winding = self.R_wh * self.C_w
        if self.stator is None:
            return winding
        R_sh = self.stator["R_sh"]
        return min(winding, self.stator["C_s"] * self.R_wh * R_sh / (self.R_wh + R_sh))

    def ask_switches(self, x: Instant):
        for e in self.effects:
            if e.law.switch is not None:
                self.on[e.law.id] = e.law.switch(x, self.on[e.law.id], **e.parameters)

    def added(self, port: str, x: Instant) -> float:
        """Sum of the laws at a sensor's port, K."""
        return sum(e.law.add(x, **e.parameters) for e in self.effects if e.law.port == port)

    def rates(self, x: Instant, T_s: float):
        """Voltage V, shaft torque N m, then the rates: winding, housing, stator K/s, supplied and released W."""
        add = dict.fromkeys(PORTS_INSIDE, 0.0)
        k_t = self.k_t_ref * (1.0 + self.alpha_mag * (x.T_h - self.T_ref))
        friction = self.tau_c * tanh(x.w / self.w_small)
        for e in self.inside:
            if self.on[e.law.id]:
                x.torque = k_t * (1.0 + add["torque_constant"]) * x.i - friction - add["drag_torque"]
                add[e.law.port] += e.law.add(x, **e.parameters)
        R = self.R_ref * (1.0 + self.alpha * (x.T_w - self.T_ref)) * (1.0 + add["winding_resistance"])
        drag, drop, k_t = friction + add["drag_torque"], add["terminal_voltage"], k_t * (1.0 + add["torque_constant"])
        flow = max(x.n * (1.0 + add["fan_flow"]), 0.0)
        G = self.G_still + self.G_forced * flow**EXPONENT + add["housing_ambient_conductance"]
        voltage, torque = R * x.i + k_t * x.w + drop, k_t * x.i - drag

        sources = add["winding_heat"] + add["housing_heat"]
        leaving = G * (x.T_h - x.T_a)
        R_wh = self.R_wh * (1.0 + add["winding_housing_resistance"])
        if self.stator is None:
            out = into = (x.T_w - x.T_h) / R_wh
            stator = 0.0
        else:
            out, into = (x.T_w - T_s) / R_wh, (T_s - x.T_h) / self.stator["R_sh"]
            stator = (out - into) / self.stator["C_s"]
        winding = (R * x.i * x.i + drop * x.i + add["winding_heat"] - out) / self.C_w
        housing = (into + drag * x.w + add["housing_heat"] - leaving) / (self.C_h * (1.0 + add["heat_capacity"]))
        return voltage, torque, winding, housing, stator, voltage * x.i - torque * x.w + sources, leaving


def true_ambient(times, shown, motor: Motor):
    """The room's temperature behind a sensor that the motor's effects may bend, degC."""
    return np.array([a + motor.added("ambient_sensor", Instant(t=t, T_a=a)) for t, a in zip(times, shown)])


def simulate(specimen: dict, effects, times, inputs: dict) -> Record:
    """A run: `inputs` by column name at `times` s, the ambient temperature as its sensor shows it."""
    motor = Motor(specimen, effects)
    columns = [np.asarray(inputs[name], float) for name in INPUTS]
    columns[3] = true_ambient(times, columns[3], motor)
    rows = np.column_stack([times, *columns]).tolist()
    longest = SUBSTEP * motor.fastest()

    T_a = rows[0][4]
    y = (T_a, T_a, T_a, 0.0, 0.0)  # winding, housing, stator degC, supplied, released J
    states, terminals, readings = [], [], {port: [] for port in TEMPERATURE_SENSORS}
    for k, row in enumerate(rows):
        x = Instant(*row, y[0], y[1])
        motor.ask_switches(x)
        terminals.append(motor.rates(x, y[2])[:2])
        states.append(y[:3])
        for port, T in (("winding_sensor", x.T_w), ("housing_sensor", x.T_h)):
            readings[port].append(T + motor.added(port, x))
        if k + 1 < len(rows):
            y = across(motor, row, rows[k + 1], y, longest)

    for e in motor.effects:
        if e.law.filter is not None:
            readings[e.law.port] = e.law.filter(times, readings[e.law.port], **e.parameters)
    voltage, torque = np.array(terminals).T
    outputs = dict(zip(OUTPUTS, (voltage, torque, *(np.array(readings[port]) for port in TEMPERATURE_SENSORS))))
    return Record(outputs, y[3], y[4], *np.array(states).T)


def across(motor: Motor, row, following, y, longest: float):
    """The state at the following row, from this row's."""
    span = following[0] - row[0]
    count = ceil(span / longest)
    h = span / count

    def slope(share, y):
        x = Instant(*(a + share * (b - a) for a, b in zip(row, following)), y[0], y[1])
        return motor.rates(x, y[2])[2:]

    for k in range(count):
        a = slope(k / count, y)
        b = slope((k + 0.5) / count, tuple(u + 0.5 * h * v for u, v in zip(y, a)))
        c = slope((k + 0.5) / count, tuple(u + 0.5 * h * v for u, v in zip(y, b)))
        d = slope((k + 1) / count, tuple(u + h * v for u, v in zip(y, c)))
        y = tuple(u + h / 6.0 * (p + 2.0 * (q + r) + s) for u, p, q, r, s in zip(y, a, b, c, d))
    return y
