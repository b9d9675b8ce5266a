"""What a specimen has that the preset lacks: listed effects, random functions, and functions of a lagged driver; all on
arrays.

A law adds at its port: N m of drag, V of drop, W of heat, W/K of conductance, K at a sensor, N m at the torque sensor,
else a fraction.
*Source*: the table of effects in the design; ranges of sizes as in `bench.effects`, for the public motor, carried over
by the units of a rig.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from bench.effects import I_SMALL, W_SMALL
from bench.law import CATALOGUE, KELVIN

T_REF = 25.0
FIELDS = {
    "speed": "w",
    "current": "i",
    "load_torque": "torque",
    "winding_temperature": "T_w",
    "housing_temperature": "T_h",
    "ambient_temperature": "T_a",
    "fan_command": "n",
    "time": "t",
}


@dataclass(frozen=True)
class Law:
    """A law with its size; `shape` gives the value of a random one from its drivers, `lag` s delays the driver of a
    hidden state.
    """

    id: str
    port: str
    drivers: tuple
    parameters: dict
    listed: bool = False
    function: Callable | None = None
    shape: Callable | None = None
    runs: tuple | None = None
    lag: float | None = None
    filter: bool = False
    fixed: dict = field(default_factory=dict)

    @property
    def key(self) -> str:
        return f"{self.id}:{self.port}"

    def acts_in(self, run: int) -> bool:
        return self.runs is None or run in self.runs

    def sized(self, factor: float) -> "Law":
        """The first parameter changed by a factor."""
        first = next(iter(self.parameters))
        return replace(self, parameters=self.parameters | {first: self.parameters[first] * factor})

    def driver_value(self, x):
        return getattr(x, FIELDS[self.drivers[0]])

    def value(self, x):
        if self.function:
            return self.function(x, **self.parameters)
        if self.lag is not None:
            arguments = [x.lagged[self.key]] if self.key in x.lagged else [self.driver_value(x)]
        else:
            arguments = [getattr(x, FIELDS[d]) for d in self.drivers]
        value = self.parameters["size"] * self.shape(*arguments)
        return value * np.tanh(x.w / W_SMALL) if self.port == "drag_torque" else value


def power(w, exponent):
    return np.sign(w) * np.abs(w) ** exponent


def load_friction(x, mu):
    share = mu * np.tanh(x.w / W_SMALL)
    return share * np.abs(x.torque) / (1.0 + np.sign(x.torque) * share)


def radiation(x, k):
    h, a = x.T_h + KELVIN, x.T_a + KELVIN
    return k * (h * h + a * a) * (h + a)


# Name: function of the point and its parameters, drivers that state the same law. Ports and ranges come from the
# catalogue of `bench`.
LISTED = {
    "iron_loss": lambda x, k: k * power(x.w, 0.5),
    "viscous_friction": lambda x, k: k * x.w,
    "windage": lambda x, k: k * power(x.w, 2.0),
    "load_dependent_friction": load_friction,
    "contact_drop": lambda x, V_b: V_b * np.tanh(x.i / I_SMALL),
    "housing_radiation": radiation,
    "forced_convection": lambda x, G: G,
    "fan_back_pressure": lambda x, k: -k * x.n,
    "interface_temperature": lambda x, beta: np.maximum(beta * (x.T_w - T_REF), -0.8),
    "stator_node": lambda x, R_sh, C_s: 0.0,
    "demagnetisation": lambda x, fraction, time: -fraction * (x.t >= time),
    "ambient_drift": lambda x, rate: rate * x.t,
    "housing_sensor_lag": lambda x, tau: 0.0,
    "winding_sensor_offset": lambda x, offset: offset,
    "housing_sensor_offset": lambda x, offset: offset,
    "winding_sensor_stem_loss": lambda x, k: -k * (x.T_w - x.T_a),
    "housing_sensor_stem_loss": lambda x, k: -k * (x.T_h - x.T_a),
    "drive_loss": lambda x, share: -share * x.power,
}


def listed(rng, name: str, rig, fitted: int, count: int) -> Law:
    """A listed effect of random size; one that a declared parameter could replace acts in some runs, in and outside
    of the fitted ones.
    """
    entry = CATALOGUE[name]
    effect = entry.draw(rng, rig)
    runs = (int(rng.integers(fitted)), int(rng.integers(fitted, count))) if entry.some_runs else None
    parameters = {key: value for key, value in effect.parameters.items()}
    filtered = name == "housing_sensor_lag"
    return Law(
        name,
        entry.port,
        (entry.driver,),
        parameters,
        True,
        LISTED[name],
        runs=runs,
        filter=filtered,
        fixed=dict(entry.fixed),
    )


# --- random functions


@dataclass(frozen=True)
class Curve:
    """A smooth random function on [low, high], constant outside: a Gaussian process at knots; its mean and slope are
    free too.
    """

    low: float
    high: float
    values: np.ndarray

    def __call__(self, x):
        return np.interp(x, np.linspace(self.low, self.high, len(self.values)), self.values)


KNOTS = 81


def curve(rng, low: float, high: float, positive: bool = False) -> Curve:
    """Length scale 0.2 to 0.7 of the range, zero at its lower end or at its lowest value, largest value 1."""
    u = np.linspace(0.0, 1.0, KNOTS)
    length = rng.uniform(0.2, 0.7)
    covariance = np.exp(-0.5 * ((u[:, None] - u) / length) ** 2) + 1e-8 * np.eye(KNOTS)
    g = np.linalg.cholesky(covariance) @ rng.standard_normal(KNOTS) + rng.normal() * u
    g = g - g[0]
    if positive:
        g = g - g.min()
    return Curve(low, high, g / max(float(np.max(np.abs(g))), 1e-3))


# Port: its drivers and the largest size, a fraction of the nominal quantity of that port (see `draw.unit_of`), K at
# temperature sensors.
RANDOM = {
    "drag_torque": (("speed", "current", "winding_temperature", "housing_temperature", "load_torque"), 0.25),
    "terminal_voltage": (("current", "speed", "winding_temperature"), 0.25),
    "winding_resistance": (("current", "winding_temperature"), 0.3),
    "torque_constant": (("current", "winding_temperature", "speed"), 0.12),
    "winding_heat": (("speed", "current"), 0.6),
    "housing_heat": (("speed", "current", "fan_command"), 0.6),
    "winding_housing_resistance": (("winding_temperature", "housing_temperature", "speed"), 0.6),
    "housing_ambient_conductance": (("housing_temperature", "speed", "ambient_temperature", "fan_command"), 0.6),
    "heat_capacity": (("housing_temperature", "winding_temperature"), 0.5),
    "fan_flow": (("fan_command", "housing_temperature"), 0.5),
    "winding_sensor": (("current", "winding_temperature", "speed"), 6.0),
    "housing_sensor": (("housing_temperature", "fan_command", "speed"), 6.0),
    "torque_sensor": (("current", "housing_temperature"), 0.25),
}
SAME = {
    "terminal_voltage": ("winding_resistance",),
    "winding_resistance": ("terminal_voltage",),
    "fan_flow": ("housing_ambient_conductance",),
}
FAST = ("speed", "current", "load_torque", "fan_command")


def names_at(drive: str, port: str) -> tuple:
    """Drivers that a bench of this drive has at a port; an imposed voltage has one current only if no terminal law
    depends on it.
    """
    names = RANDOM[port][0]
    if drive == "voltage" and port in ("terminal_voltage", "winding_resistance", "torque_constant"):
        names = tuple(n for n in names if n != "current")
    return names


def ports(drive: str) -> list:
    return [port for port in RANDOM if names_at(drive, port)]


def random_law(rng, kind: str, drive: str, ranges: dict) -> Law:
    """`function` of one driver, `product` of two, or `hidden`: of a driver behind a first-order lag. `ranges` has
    (low, high) by driver.
    """
    possible = ports(drive)
    if kind == "hidden":
        possible = [
            p for p in possible if set(names_at(drive, p)) & set(FAST) and p not in ("fan_flow", "torque_sensor")
        ]
    port = str(rng.choice(possible))
    names = names_at(drive, port)
    size = {"size": float(rng.choice([-1.0, 1.0]))}
    if kind == "product":
        pair = [str(d) for d in rng.choice(sorted({*names, "speed", "housing_temperature"}), 2, replace=False)]
        one, other = (curve(rng, *ranges[d], positive=True) for d in pair)
        return Law("product", port, tuple(pair), size, shape=lambda a, b: one(a) * other(b))
    if kind == "hidden":
        driver = str(rng.choice([n for n in names if n in FAST]))
        bent = (
            curve(rng, *ranges[driver]) if rng.random() < 0.5 else Curve(*ranges[driver], np.linspace(0.0, 1.0, KNOTS))
        )
        return Law(
            "hidden", port, (driver,), size, shape=bent, lag=float(np.exp(rng.uniform(np.log(60.0), np.log(900.0))))
        )
    driver = str(rng.choice(names))
    return Law("function", port, (driver,), size, shape=curve(rng, *ranges[driver]))
