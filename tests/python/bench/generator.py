"""The two-node motor at an imposed current or voltage and speed, or heated at standstill, integrated on its own: a known answer.

    voltage       = R i + k_t w + drops                        R   = R_ref [1 + alpha (T_w - T_ref)]
    shaft torque  = k_t i - drag                               k_t = k_t,ref [1 + alpha_mag (T_h - T_ref)]
    drag          = tau_c tanh(w / w_small) + further drags    G   = G_still + G_forced n^0.8
    C_w dT_w/dt   = R i^2 + drops i - (T_w - T_h) / R_wh
    C_h dT_h/dt   = (T_w - T_h) / R_wh + drag w - G (T_h - T_a)

plus what `effects` add at their ports. An imposed voltage drives the current that the first equation asks for; an electrical power
at standstill heats the winding. *Assumes* that inputs run linearly between rows and that every node starts at the ambient
true temperature. *Integrates* with the classical Runge-Kutta method, equal substeps between two rows, at most `SUBSTEP` of the
fastest time constant; laws that switch do so at rows, so that each stretch is smooth.
*Source*: README of the public bench sets.
"""

from dataclasses import dataclass
from math import ceil, tanh

import numpy as np

from .law import KELVIN
from .rig import AMBIENT, COLUMNS, FAN, HOUSING, PUBLIC, SPEED, TEMPERATURE_SENSORS, TORQUE, WINDING, Rig

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

NOTHING = dict.fromkeys(PORTS_INSIDE, 0.0)
SUBSTEP = 0.25  # of the fastest time constant: an error below 1e-4 K
EXPONENT = 0.8  # of the fan command in the forced conductance


SAME_CURRENT = 1e-9  # A, where the search for a current ends; relative, too


@dataclass(slots=True)
class Instant:
    """Quantities that a law may use: time s, imposed quantity (A, V or W), speed rad/s, fan command 1, temperatures degC, current A, torque
    N m.
    """

    t: float = 0.0
    drive: float = 0.0
    w: float = 0.0
    n: float = 0.0
    T_a: float = 0.0
    T_w: float = 0.0
    T_h: float = 0.0
    i: float = 0.0
    torque: float = 0.0  # at the shaft, as far as it is known


@dataclass
class Record:
    """The true values of a run, and its energies in J: supplied at terminals and sources, released to ambient."""

    outputs: dict
    supplied: float
    released: float
    winding: np.ndarray  # true temperatures, degC
    housing: np.ndarray
    stator: np.ndarray


class Motor:
    """A specimen with its effects; one object per run, since switching effects have a memory."""

    def __init__(self, specimen: dict, effects=(), rig: Rig = PUBLIC):
        p = rig.nominal | specimen
        self.drive = rig.layout.drive
        self.R_ref, self.k_t_ref = p["motor.R_ref"], p["motor.k_t"]
        self.alpha, self.alpha_mag, self.T_ref = p["motor.alpha"], p["motor.alpha_mag"], p["motor.T_ref"] - KELVIN
        self.R_wh, self.C_w, self.C_h = p["thermal.R_wh"], p["thermal.C_w"], p["thermal.C_h"]
        self.G_still, self.G_forced = p["conductance.G_still"], p["conductance.G_forced"]
        self.tau_c, self.w_small = p["effect.coulomb_friction.tau_c"], p["effect.coulomb_friction.w_small"]
        # Friction of the load comes last: it needs the torque that the others leave.
        self.effects = sorted(effects, key=lambda e: e.law.driver == "load_torque")
        self.inside = [e for e in self.effects if not e.law.port.endswith("_sensor")]
        self.on = {e.law.id: e.law.switch is None for e in self.effects}
        # The voltage is linear in the current, unless a law of these ports bends it.
        bends = ("terminal_voltage", "winding_resistance", "torque_constant")
        self.bent = any(e.law.port in bends and e.law.driver == "current" for e in self.effects)
        self.last_current = 0.0
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

    def terms(self, x: Instant):
        """The contributions of the laws at their ports, the friction N m and the torque constant N m/A before them."""
        add = NOTHING.copy() if self.inside else NOTHING
        k_t = self.k_t_ref * (1.0 + self.alpha_mag * (x.T_h - self.T_ref))
        friction = self.tau_c * tanh(x.w / self.w_small)
        for e in self.inside:
            if self.on[e.law.id]:
                x.torque = k_t * (1.0 + add["torque_constant"]) * x.i - friction - add["drag_torque"]
                add[e.law.port] += e.law.add(x, **e.parameters)
        return add, friction, k_t

    def terminals(self, x: Instant):
        """Resistance Ohm, drops V, drag N m, torque constant N m/A at the instant's current, and the terms."""
        add, friction, k_t = self.terms(x)
        R = self.R_ref * (1.0 + self.alpha * (x.T_w - self.T_ref)) * (1.0 + add["winding_resistance"])
        return R, add["terminal_voltage"], friction + add["drag_torque"], k_t * (1.0 + add["torque_constant"]), add

    def voltage(self, x: Instant, i: float) -> float:
        """Between the terminals at a current, V."""
        x.i = i
        R, drop, _, k_t, _ = self.terminals(x)
        return R * i + k_t * x.w + drop

    def current_at(self, x: Instant) -> float:
        """The current at the imposed voltage, A: Newton's method, with bisection outside the bracket."""
        x.i = 0.0
        R, drop, _, k_t, _ = self.terminals(x)
        at_zero = k_t * x.w + drop
        if not self.bent:
            return (x.drive - at_zero) / R
        # The voltage rises with the current, by the resistance or more or a little less.
        far = 2.0 * (x.drive - at_zero) / self.R_ref
        low, high = min(far, 0.0), max(far, 0.0)
        i = min(max(self.last_current, low), high)
        for _ in range(200):
            miss = self.voltage(x, i) - x.drive
            low, high = (i, high) if miss < 0.0 else (low, i)
            step = 1e-6 * (1.0 + abs(i))
            following = i - miss * step / (self.voltage(x, i + step) - x.drive - miss)
            if not low <= following <= high:
                following = 0.5 * (low + high)
            done = abs(following - i) < SAME_CURRENT * (1.0 + abs(i))
            i = following
            if done:
                break
        self.last_current = i
        return i

    def settle(self, x: Instant):
        """Computes the current from the imposed quantity."""
        if self.drive == "voltage":
            x.i = self.current_at(x)
        else:
            x.i = x.drive if self.drive == "current" else 0.0

    def rates(self, x: Instant, T_s: float):
        """Voltage V, shaft torque N m, then the rates: winding, housing, stator K/s, supplied and released W."""
        self.settle(x)
        R, drop, drag, k_t, add = self.terminals(x)
        flow = max(x.n * (1.0 + add["fan_flow"]), 0.0)
        G = self.G_still + (self.G_forced * flow**EXPONENT if flow else 0.0) + add["housing_ambient_conductance"]
        voltage, torque = R * x.i + k_t * x.w + drop, k_t * x.i - drag

        arriving = add["winding_heat"] + (x.drive if self.drive == "power" else 0.0)
        leaving = G * (x.T_h - x.T_a)
        R_wh = self.R_wh * (1.0 + add["winding_housing_resistance"])
        if self.stator is None:
            out = into = (x.T_w - x.T_h) / R_wh
            stator = 0.0
        else:
            out, into = (x.T_w - T_s) / R_wh, (T_s - x.T_h) / self.stator["R_sh"]
            stator = (out - into) / self.stator["C_s"]
        winding = (R * x.i * x.i + drop * x.i + arriving - out) / self.C_w
        housing = (into + drag * x.w + add["housing_heat"] - leaving) / (self.C_h * (1.0 + add["heat_capacity"]))
        supplied = voltage * x.i - torque * x.w + arriving + add["housing_heat"]
        return voltage, torque, winding, housing, stator, supplied, leaving


def true_ambient(times, shown, motor: Motor):
    """The true ambient temperature; effects at the ambient sensor change the indicated one, degC."""
    return np.array([a + motor.added("ambient_sensor", Instant(t=t, T_a=a)) for t, a in zip(times, shown)])


def simulate(specimen: dict, effects, times, inputs: dict, rig: Rig = PUBLIC) -> Record:
    """A run: `inputs` by column name at `times` s, the ambient temperature as its sensor shows it."""
    motor = Motor(specimen, effects, rig)
    turning = inputs[SPEED] if SPEED in rig.layout.inputs else np.zeros(len(times))
    columns = [np.asarray(c, float) for c in (inputs[COLUMNS[motor.drive]], turning, inputs[FAN], inputs[AMBIENT])]
    columns[3] = true_ambient(times, columns[3], motor)
    rows = np.column_stack([times, *columns]).tolist()
    longest = SUBSTEP * motor.fastest()

    T_a = rows[0][4]
    y = (T_a, T_a, T_a, 0.0, 0.0)  # winding, housing, stator degC, supplied, released J
    states, terminals, readings = [], [], {port: [] for port in TEMPERATURE_SENSORS}
    for k, row in enumerate(rows):
        x = Instant(*row, y[0], y[1])
        motor.ask_switches(x)
        voltage, torque = motor.rates(x, y[2])[:2]
        terminals.append((voltage, x.i, torque))
        states.append(y[:3])
        for port, T in (("winding_sensor", x.T_w), ("housing_sensor", x.T_h)):
            readings[port].append(T + motor.added(port, x))
        if k + 1 < len(rows):
            y = across(motor, row, rows[k + 1], y, longest)

    for e in motor.effects:
        if e.law.filter is not None:
            readings[e.law.port] = e.law.filter(times, readings[e.law.port], **e.parameters)
    voltage, current, torque = np.array(terminals).T
    read = {COLUMNS["voltage"]: voltage, COLUMNS["current"]: current, TORQUE: torque}
    read |= {WINDING: np.array(readings["winding_sensor"]), HOUSING: np.array(readings["housing_sensor"])}
    outputs = {name: read[name] for name in rig.layout.outputs}
    return Record(outputs, y[3], y[4], *np.array(states).T)


def across(motor: Motor, row, following, y, longest: float):
    """The state at the following row, from this row's."""
    span = following[0] - row[0]
    count = ceil(span / longest)
    h = span / count

    # Written out: this is where the time goes.
    t, drive, w, n, T_a = row
    dt, d_drive, dw, dn, dT_a = (b - a for a, b in zip(row, following))

    def slope(share, T_w, T_h, T_s):
        x = Instant(t + share * dt, drive + share * d_drive, w + share * dw, n + share * dn, T_a + share * dT_a, T_w, T_h)
        return motor.rates(x, T_s)[2:]

    T_w, T_h, T_s, supplied, released = y
    half, sixth = 0.5 * h, h / 6.0
    for k in range(count):
        aw, ah, as_, ai, ao = slope(k / count, T_w, T_h, T_s)
        middle = (k + 0.5) / count
        bw, bh, bs, bi, bo = slope(middle, T_w + half * aw, T_h + half * ah, T_s + half * as_)
        cw, ch, cs, ci, co = slope(middle, T_w + half * bw, T_h + half * bh, T_s + half * bs)
        dw_, dh, ds, di, do = slope((k + 1) / count, T_w + h * cw, T_h + h * ch, T_s + h * cs)
        T_w += sixth * (aw + 2.0 * (bw + cw) + dw_)
        T_h += sixth * (ah + 2.0 * (bh + ch) + dh)
        T_s += sixth * (as_ + 2.0 * (bs + cs) + ds)
        supplied += sixth * (ai + 2.0 * (bi + ci) + di)
        released += sixth * (ao + 2.0 * (bo + co) + do)
    return T_w, T_h, T_s, supplied, released
