"""A motor of seven thermal nodes, integrated for many columns (run, specimen, inputs) at once.

    0 slot winding   1 end winding   2 stator core   3 housing front   4 housing back   5 rotor   6 core of
    `stator_node`

The winding's heat goes to core and housing, friction heat to the bearings, both housing ends release heat to ambient.
With the strength 0 of
every piece of structure each node has the fraction of heat, capacity and conductance of its part, so that all nodes of
a part have one
temperature, and the network is the two-node motor of `bench.generator`. The strengths move these fractions: no time
constant becomes short.

*Assumes* linear inputs between rows. *Integrates* with the classical Runge-Kutta method, equal substeps of at most
`SUBSTEP` of the fastest time
constant. *Source*: README of the public bench sets for the two-node limit.
"""

from dataclasses import dataclass, field

import numpy as np
from bench.rig import AMBIENT, COLUMNS, FAN, HOUSING, SPEED, TORQUE, WINDING

KELVIN = 273.15
T_REF = 25.0
SUBSTEP = 0.9
NODES = 7
END, CORE = 0.35, 0.3  # fraction of the winding in the end turns, of the housing's capacity in the core
BRIDGE = 0.25  # conductance between slot and end winding, in winding conductances
TO_HOUSING, ALONG = 3.0, 1.5  # conductances core to housing and along the housing, in winding conductances
TERMINAL = ("terminal_voltage", "winding_resistance", "torque_constant")
NAMES = {
    "R_ref": "motor.R_ref",
    "k_t": "motor.k_t",
    "R_wh": "thermal.R_wh",
    "C_w": "thermal.C_w",
    "C_h": "thermal.C_h",
    "G_still": "conductance.G_still",
    "G_forced": "conductance.G_forced",
    "tau_c": "effect.coulomb_friction.tau_c",
    "w_small": "effect.coulomb_friction.w_small",
    "alpha": "motor.alpha",
    "alpha_mag": "motor.alpha_mag",
}


@dataclass
class Column:
    """One simulated run: times s, imposed columns, parameters by their name in the product, which laws act, strength
    of the structure.
    """

    times: np.ndarray
    inputs: dict
    parameters: dict
    laws: bool = True
    structure: float = 0.0
    run: int = 0


@dataclass
class Point:
    """What a law may depend on, one value a column: s, A, rad/s, 1, degC, N m; hidden states by law."""

    t: np.ndarray
    w: np.ndarray
    n: np.ndarray
    T_a: np.ndarray
    T_w: np.ndarray
    T_h: np.ndarray
    i: np.ndarray
    torque: np.ndarray | float = 0.0
    power: np.ndarray | float = 0.0
    lagged: dict = field(default_factory=dict)


class Network:
    """The columns of one set; `drive` is current, voltage or power, `pieces` the strengths of the structure at 1."""

    def __init__(self, columns, drive: str, laws=(), pieces=None):
        self.columns, self.drive = columns, drive
        p = lambda name: np.array([c.parameters[NAMES[name]] for c in columns])  # noqa: E731
        for name in NAMES:
            setattr(self, name, p(name))
        self.s = np.array([c.structure for c in columns])
        self.runs = np.array([c.run for c in columns])
        self.pieces = pieces or {}
        self.strengths = {n: self.s * v for n, v in self.pieces.items() if n != "moved"}
        self.none = np.zeros(len(columns))
        on = np.array([float(c.laws) for c in columns])
        # Terminal laws come first, since an imposed voltage needs them for the current; friction of the load last.
        order = sorted(laws, key=lambda law: (law.port not in TERMINAL, "load_torque" in law.drivers))
        self.laws = [(law, on * [law.acts_in(c.run) for c in columns]) for law in order]
        self.hidden = [law for law in order if law.lag is not None]
        self.extra = next(((law.parameters, mask) for law, mask in self.laws if law.id == "stator_node"), None)
        self.ports = {law.port for law in order}
        self.shares()

    def strength(self, piece: str):
        return self.strengths.get(piece, self.none)

    def shares(self):
        """Fractions of the nodes core, front, back, per column."""
        core = np.clip(self.strength("stator"), 0.0, 1.0)
        ends = np.clip(self.strength("housing_ends"), -0.9, 0.9)
        shell = 0.5 * (1.0 - CORE)
        self.into = np.array([CORE + core * (1.0 - CORE), shell * (1.0 - core), shell * (1.0 - core)])
        left = CORE * core / 2.0
        self.out = np.array([CORE * (1.0 - core), (shell + left) * (1.0 - ends), (shell + left) * (1.0 + ends)])
        self.rub = np.array(
            [CORE * (1.0 - core), (shell + left) * (1.0 + 0.5 * ends), (shell + left) * (1.0 - 0.5 * ends)]
        )
        self.end = np.clip(self.strength("end_winding"), 0.0, 0.95)
        self.rotor = np.clip(self.strength("rotor"), 0.0, 1.0)

    def longest(self) -> float:
        fastest = float(np.min(self.R_wh * self.C_w))
        if self.extra:
            p = self.extra[0]
            fastest = min(fastest, float(np.min(p["C_s"] / (1.0 / self.R_wh + 1.0 / p["R_sh"]))))
        return SUBSTEP * fastest

    def add(self, x: Point, terminal: bool, total: dict, k_t=None, friction=None):
        """Adds the laws of the terminals, or the others, to `total` by port."""
        for law, mask in self.laws:
            if (law.port in TERMINAL) == terminal and not law.port.endswith("_sensor"):
                if "load_torque" in law.drivers and k_t is not None:
                    x.torque = k_t * x.i - friction - total.get("drag_torque", 0.0)
                total[law.port] = total.get(law.port, 0.0) + mask * law.value(x)

    def electric(self, x: Point, drive, magnet):
        """Resistance, drop, torque constant, friction before the laws, and the sums of the laws; sets the current."""
        total: dict = {}
        R = self.R_ref * (1.0 + self.alpha * (x.T_w - T_REF))
        k_t = self.k_t * (1.0 + self.alpha_mag * (magnet - T_REF))
        friction = self.tau_c * np.tanh(x.w / self.w_small)
        if "grease" in self.pieces:
            friction = friction * (1.0 - self.strength("grease") * np.clip((x.T_h - T_REF) / 40.0, -0.5, 1.0))
        x.i, x.power = (drive, 0.0) if self.drive == "current" else (np.zeros_like(drive), drive)
        self.add(x, True, total)
        R = R * (1.0 + total.get("winding_resistance", 0.0))
        k_t = k_t * (1.0 + total.get("torque_constant", 0.0))
        drop = total.get("terminal_voltage", 0.0)
        if self.drive == "voltage":
            x.i, x.power = (drive - k_t * x.w - drop) / R, 0.0
        self.add(x, False, total, k_t, friction)
        return R, drop, k_t, friction, total

    def conductance(self, x: Point, total: dict):
        still = self.G_still
        if "convection" in self.pieces:
            rise = np.maximum(np.abs(x.T_h - x.T_a), 0.5)
            still = still * (1.0 + self.strength("convection") * ((rise / 20.0) ** 0.25 - 1.0))
        flow = np.maximum(x.n * (1.0 + total.get("fan_flow", 0.0)), 0.0)
        forced = self.G_forced * flow ** (0.8 + self.strength("fan_exponent"))
        return np.maximum(still + forced + total.get("housing_ambient_conductance", 0.0), 0.0)

    def point(self, y, u) -> Point:
        t, _, w, n, T_a = u
        lagged = {law.key: y[NODES + k] for k, law in enumerate(self.hidden)}
        return Point(t, w, n, T_a, (1.0 - END) * y[0] + END * y[1], 0.5 * (y[3] + y[4]), u[1], lagged=lagged)

    def rates(self, y, u):
        """Rates of the nodes and hidden states; stores voltage, current, shaft torque and heat flows of the instant."""
        x = self.point(y, u)
        R, drop, k_t, friction, total = self.electric(x, u[1], x.T_h + self.rotor * (y[5] - x.T_h))
        drag = friction + total.get("drag_torque", 0.0)
        self.voltage, self.current, self.torque = R * x.i + k_t * x.w + drop, x.i, k_t * x.i - drag
        G_w = 1.0 / (self.R_wh * (1.0 + total.get("winding_housing_resistance", 0.0)))
        parts = y[2:5]
        below = D = np.sum(self.into * parts, axis=0)
        if self.extra:
            on = self.extra[1] > 0
            below = np.where(on, y[6], D)
        slot, end = (1.0 - END) * G_w * (y[0] - below), END * (1.0 - self.end) * G_w * (y[1] - below)
        across = BRIDGE / self.R_wh * (y[0] - y[1])
        copper = R * x.i * x.i + drop * x.i + total.get("winding_heat", 0.0) + x.power
        dy = np.zeros_like(y)
        dy[0] = (copper * (1.0 - END) - slot - across) / ((1.0 - END) * self.C_w)
        dy[1] = (copper * END - end + across) / (END * self.C_w)
        conducted = slot + end
        if self.extra:
            p = self.extra[0]
            passed = np.where(on, (y[6] - D) / p["R_sh"], conducted)
            dy[6] = np.where(on, (conducted - passed) / p["C_s"], 0.0)
            source, strength = np.where(on, y[6], 0.0), np.where(on, 1.0 / p["R_sh"], 0.0)
            heat = self.into * np.where(on, strength * (source - parts), 0.0)
            heat += np.where(on, 0.0, 1.0) * self.spread(y, G_w, parts)
        else:
            heat = self.spread(y, G_w, parts)
        G = self.conductance(x, total)
        leaving = self.out * G * (parts - x.T_a)
        heat = heat + self.rub * (drag * x.w) + self.out * total.get("housing_heat", 0.0) - leaving
        base = 1.0 / self.R_wh
        inner = 0.5 * TO_HOUSING * base * (parts[0] - parts[1:])
        along = ALONG * base * (parts[1] - parts[2])
        air = self.rotor * 0.4 * base * (parts[0] - y[5])
        C = self.C_h * (1.0 + total.get("heat_capacity", 0.0))
        dy[2] = (heat[0] - inner[0] - inner[1] - air) / (CORE * C)
        dy[3] = (heat[1] + inner[0] - along) / (0.5 * (1.0 - CORE) * C)
        dy[4] = (heat[2] + inner[1] + along) / (0.5 * (1.0 - CORE) * C)
        dy[5] = 0.4 * base * (parts[0] - y[5]) / (0.12 * self.C_h)
        for k, law in enumerate(self.hidden):
            dy[NODES + k] = (law.driver_value(x) - y[NODES + k]) / law.lag
        shaft = self.torque * x.w
        self.supplied = (
            self.voltage * x.i + total.get("winding_heat", 0.0) + x.power - shaft + total.get("housing_heat", 0.0)
        )
        self.released = np.sum(leaving, axis=0)
        return dy

    def spread(self, y, G_w, parts):
        """Heat from both parts of the winding into core, front and back."""
        return self.into * G_w * ((1.0 - END) * (y[0] - parts) + END * (1.0 - self.end) * (y[1] - parts))

    def stored(self, y):
        """Thermal energy in J above 0 degC, without laws at the capacity."""
        C = self.C_h
        energy = self.C_w * ((1.0 - END) * y[0] + END * y[1]) + C * (CORE * y[2] + 0.5 * (1.0 - CORE) * (y[3] + y[4]))
        energy = energy + self.rotor * 0.12 * C * y[5]
        return energy + (self.extra[0]["C_s"] * self.extra[1] * y[6] if self.extra else 0.0)

    def table(self):
        """Inputs of all columns, rows x 5 x columns; a shorter run repeats its last row."""
        rows = max(len(c.times) for c in self.columns)
        u = np.zeros((rows, 5, len(self.columns)))
        for k, c in enumerate(self.columns):
            still = np.zeros(len(c.times))
            for q, values in enumerate(
                (c.times, c.inputs[COLUMNS[self.drive]], c.inputs.get(SPEED, still), c.inputs[FAN], c.inputs[AMBIENT])
            ):
                u[: len(c.times), q, k], u[len(c.times) :, q, k] = values, values[-1]
        for law, mask in self.laws:
            if law.port == "ambient_sensor":
                drift = law.value(Point(u[:, 0], u[:, 2], u[:, 3], u[:, 4], u[:, 4], u[:, 4], u[:, 1]))
                u[:, 4] = u[:, 4] + drift * mask
        return u

    def substeps(self, u):
        """Their number between each two rows, for all columns alike."""
        return np.maximum(1, np.ceil(np.max(np.diff(u[:, 0], axis=0), axis=1) / self.longest())).astype(int)

    def simulate(self) -> list:
        """Per column: readings of an ideal bench by column name, and the values of the laws' drivers at the rows."""
        u = self.table()
        counts = self.substeps(u)
        y = np.tile(u[0, 4], (NODES + len(self.hidden), 1))
        x = self.point(y, u[0])
        for k, law in enumerate(self.hidden):
            self.electric(x, u[0, 1], x.T_h)
            y[NODES + k] = law.driver_value(x)
        states, terminals, self.balance = np.zeros((len(u), *y.shape)), np.zeros((len(u), 3, y.shape[1])), 0.0
        begun = self.stored(y)
        for row in range(len(u)):
            k1 = self.rates(y, u[row])
            states[row], terminals[row] = y, (self.voltage, self.current, self.torque)
            if row + 1 == len(u):
                break
            step = u[row + 1] - u[row]
            count = int(counts[row])
            h = step[0] / count
            for sub in range(count):
                if sub:
                    k1 = self.rates(y, u[row] + (sub / count) * step)
                f1 = self.supplied - self.released
                middle = u[row] + ((sub + 0.5) / count) * step
                k2 = self.rates(y + 0.5 * h * k1, middle)
                f2 = self.supplied - self.released
                k3 = self.rates(y + 0.5 * h * k2, middle)
                f3 = self.supplied - self.released
                k4 = self.rates(y + h * k3, u[row] + ((sub + 1) / count) * step)
                self.balance = self.balance + h / 6.0 * (f1 + 2.0 * (f2 + f3) + self.supplied - self.released)
                y = y + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        self.kept = self.stored(y) - begun
        return self.read(u, states, terminals)

    def read(self, u, states, terminals) -> list:
        """Readings of the sensors at the rows."""
        y = np.moveaxis(states, 0, 1)
        x = self.point(y, np.moveaxis(u, 0, 1))
        x.i, x.torque, x.power = terminals[:, 1], terminals[:, 2], u[:, 1] if self.drive == "power" else 0.0
        seat, lag = self.strength("sensor_seat"), self.strength("sensor_lag")
        winding = x.T_w + np.clip(seat, 0.0, 1.0) * (y[1] - x.T_w)
        housing = x.T_h + np.clip(seat, -1.0, 1.0) * 0.5 * (y[4] - y[3])
        moved = np.array([self.pieces.get("moved", {}).get(run, (0.0, 0.0)) for run in self.runs]).reshape(-1, 2)
        winding, housing = winding + self.s * moved[:, 0], housing + self.s * moved[:, 1]
        read = {
            TORQUE: terminals[:, 2],
            WINDING: winding,
            HOUSING: housing,
            COLUMNS["voltage"]: terminals[:, 0],
            COLUMNS["current"]: x.i,
        }
        at = {"torque_sensor": TORQUE, "winding_sensor": WINDING, "housing_sensor": HOUSING}
        for law, mask in self.laws:
            if law.port in at:
                read[at[law.port]] = read[at[law.port]] + mask * law.value(x)
        made = []
        for k, c in enumerate(self.columns):
            rows = len(c.times)
            one = {name: np.array(values[:rows, k]) for name, values in read.items()}
            if lag[k] > 0.0:
                one = {n: lagged(c.times, v, lag[k]) if n in (WINDING, HOUSING) else v for n, v in one.items()}
            for law, mask in self.laws:
                if law.filter and mask[k]:
                    one[at[law.port]] = lagged(c.times, one[at[law.port]], law.parameters["tau"])
            one["drivers"] = {
                "speed": x.w[:rows, k],
                "current": x.i[:rows, k],
                "load_torque": x.torque[:rows, k],
                "winding_temperature": x.T_w[:rows, k],
                "housing_temperature": x.T_h[:rows, k],
                "ambient_temperature": x.T_a[:rows, k],
                "fan_command": x.n[:rows, k],
                "time": x.t[:rows, k],
            }
            one["laws"] = [np.broadcast_to(law.value(x), x.w.shape)[:rows, k] * mask[k] for law, mask in self.laws]
            made.append(one)
        return made


def lagged(times, values, tau: float):
    """First-order lag of values that are linear between rows; starts at the first one. Exact."""
    shown = [values[0]]
    for h, before, now in zip(np.diff(times), values, values[1:]):
        slope = (now - before) / h
        shown.append(now - slope * tau + (shown[-1] - before + slope * tau) * np.exp(-h / tau))
    return np.array(shown)
