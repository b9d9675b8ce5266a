"""A motor with a hidden state that ran before the files begin: a two-node motor, independent of the Rust code.

A mass is attached to a node, or a law follows a first-order lag of a driver. Before the first row each run has another load, of which nothing
is recorded, so that the hidden state does not start where its driver is.
"""

import json
import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

TRUE = {
    "motor.R_ref": 0.80,
    "motor.k_t": 0.050,
    "thermal.R_wh": 1.2,
    "thermal.C_w": 25.0,
    "thermal.C_h": 180.0,
    "conductance.G_still": 0.25,
    "conductance.G_forced": 0.35,
    "effect.coulomb_friction.tau_c": 0.006,
}
ERROR = (1.05, 0.95, 0.90, 1.12, 0.93, 1.08, 0.90, 1.10)  # of the start values, in the order of TRUE
PRIOR = (0.06, 0.06, 0.12, 0.12, 0.10, 0.10, 0.12, 0.12)
NOISE = {
    "voltage_V": 0.01,
    "shaft_torque_Nm": 0.0005,
    "winding_temperature_degC": 0.05,
    "housing_temperature_degC": 0.05,
}
INPUTS = ("current_A", "speed_rad_per_s", "fan_command_1", "ambient_temperature_degC")
TYPICAL = {"speed": 100.0, "current": 1.0, "winding_temperature": 100.0, "housing_temperature": 100.0}
ALPHA, ALPHA_MAG, REFERENCE, KELVIN = 0.0039, -0.0012, 298.15, 273.15
ROW, DIVIDED, DURATION = 4.0, 4, 4500.0  # s, steps within a row, s
ROLES = ("fit", "fit", "validate", "test")
FIRST = ((1.5, 100.0, 0.0), (3.5, 300.0, 1.0), (0.5, 0.0, 0.0), (1.5, 100.0, 0.4))  # A, rad/s, fan: of each run


@dataclass
class Case:
    """A law over the lag of a driver at a port, or a mass on a node; and what ran before each run: (minutes, A, rad/s, fan)."""

    port: str
    driver: str
    tau: float
    law: Callable[[float], float]
    before: tuple
    mass: bool = False
    first: tuple = FIRST


HOT = ([(45, 4.2, 300, 0.0)], [(40, 3.8, 100, 0.0)], [(50, 4.0, 200, 0.0)], [(60, 4.2, 400, 0.0)])
COOLED = tuple([*run, (6, 0.3, 0, 1.0)] for run in HOT)
HEATED = tuple([(20, 0.5, 0, 1.0), (4, 5.0, speed, 0.0)] for speed in (300, 100, 200, 400))
# The first fit run begins at the upper end of the driver, the second one at the lower end.
CURRENT = ([(50, 4.4, 300, 0.0)], [(50, 0.6, 200, 0.4)], [(45, 3.5, 200, 1.0)], [(45, 4.0, 400, 0.0)])
SPEED = ([(50, 3.0, 400, 0.4)], [(50, 3.0, 0, 0.0)], [(45, 3.0, 300, 1.0)], [(50, 3.0, 380, 0.0)])
STOPPED = ([(30, 3.0, 0, 0.0)],) * 4


def mass(port, node, capacity, conductance, before):
    return Case(port, node, capacity / conductance, lambda difference: conductance * difference, before, mass=True)


CASES = {
    "mass on the housing, hotter": mass("housing_heat", "housing_temperature", 90.0, 0.20, COOLED),
    "mass on the housing, colder": mass("housing_heat", "housing_temperature", 90.0, 0.20, HEATED),
    "mass on the winding": mass("winding_heat", "winding_temperature", 30.0, 0.10, HOT),
    "heat by current": Case("winding_heat", "current", 600.0, lambda z: 0.9 * z, CURRENT),
    "conductance by speed": Case("housing_ambient_conductance", "speed", 500.0, lambda z: 0.1 * z / 300.0, SPEED),
    "torque constant by speed": Case("torque_constant", "speed", 400.0, lambda z: -0.05 * z / 300.0, SPEED),
    "sensor by current": Case("winding_sensor", "current", 500.0, lambda z: 0.8 * z, CURRENT),
    "heat by speed, first row above the law": Case(
        "housing_heat", "speed", 60.0, lambda z: 3.0 * z / 300.0, STOPPED, first=(*FIRST[:3], (1.5, 400.0, 0.4))
    ),
}


class Motor:
    """Winding, housing and the hidden state: K, K, and the unit of the driver."""

    def __init__(self, case, ambient):
        self.case, self.state = case, [ambient + KELVIN, ambient + KELVIN, 0.0]

    def rates(self, inputs, state):
        """Rates of change, outputs and driver."""
        current, speed, fan, ambient = inputs
        winding, housing, hidden = state
        case, true = self.case, TRUE
        resistance = true["motor.R_ref"] * (1.0 + ALPHA * (winding - REFERENCE))
        loss = resistance * current**2
        driver = {
            "speed": speed,
            "current": current,
            "winding_temperature": winding,
            "housing_temperature": housing,
        }[case.driver]
        value = case.law(hidden - driver if case.mass else hidden)
        acts = {case.port: value}
        k_t = true["motor.k_t"] * (1.0 + ALPHA_MAG * (housing - REFERENCE)) * (1.0 + acts.get("torque_constant", 0.0))
        friction = true["effect.coulomb_friction.tau_c"] * math.tanh(speed)
        conductance = true["conductance.G_still"] + true["conductance.G_forced"] * max(fan, 0.0) ** 0.8
        conductance += acts.get("housing_ambient_conductance", 0.0)
        through = (winding - housing) / true["thermal.R_wh"]
        left = conductance * (housing - ambient - KELVIN)
        rates = (
            (loss + acts.get("winding_heat", 0.0) - through) / true["thermal.C_w"],
            (friction * speed + acts.get("housing_heat", 0.0) + through - left) / true["thermal.C_h"],
            (driver - hidden) / case.tau,
        )
        shown = winding + acts.get("winding_sensor", 0.0) - KELVIN
        outputs = (resistance * current + k_t * speed, k_t * current - friction, shown, housing - KELVIN)
        return rates, outputs, driver

    def advance(self, start, end):
        """Over a row with linear inputs: Runge-Kutta of fourth order."""
        h = ROW / DIVIDED
        for k in range(DIVIDED):
            at = [start + (end - start) * (k + part) / DIVIDED for part in (0.0, 0.5, 1.0)]
            first = self.rates(at[0], self.state)[0]
            second = self.rates(at[1], self.moved(first, h / 2))[0]
            third = self.rates(at[1], self.moved(second, h / 2))[0]
            fourth = self.rates(at[2], self.moved(third, h))[0]
            mean = [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(first, second, third, fourth)]
            self.state = self.moved(mean, h)

    def moved(self, rates, h):
        return [x + h * rate for x, rate in zip(self.state, rates)]


def steps(rng, levels, first, count):
    column = [first] * int(rng.uniform(180, 700) / ROW)
    while len(column) < count:
        others = [level for level in levels if level != column[-1]]
        column += [others[rng.integers(len(others))]] * int(rng.uniform(180, 700) / ROW)
    return column[:count]


def recorded(case, rng, run):
    """Inputs and outputs of the rows, and what the hidden state exceeds its driver by in the first one."""
    count = int(DURATION / ROW) + 1
    current, speed, fan = case.first[run]
    ambient = 22.0 + rng.uniform(-1, 1) + 0.6 * np.sin(2 * np.pi * (np.arange(count) * ROW / 5000 + rng.uniform()))
    loads = np.column_stack(
        [
            steps(rng, [0.5, 1.5, 2.5, 3.5, 4.5], current, count),
            steps(rng, [0.0, 100.0, 200.0, 300.0, 400.0], speed, count),
            steps(rng, [0.0, 0.4, 1.0], fan, count),
            ambient,
        ]
    )
    rest = np.array([[0.0, 0.0, 0.0, ambient[0]]])
    before = [[[*values, ambient[0]]] * int(60 * minutes / ROW) for minutes, *values in case.before[run]]
    before = np.vstack([rest, *map(np.array, before)])
    motor, outputs, above = Motor(case, ambient[0]), [], 0.0
    motor.state[2] = motor.rates(rest[0], motor.state)[2]
    rows = np.vstack([before, loads])
    for k, row in enumerate(rows):
        _, shown, driver = motor.rates(row, motor.state)
        if k == len(before):
            above = motor.state[2] - driver
        if k >= len(before):
            outputs.append(shown)
        if k + 1 < len(rows):
            motor.advance(row, rows[k + 1])
    return loads, np.array(outputs), above


def write(name, seed, folder):
    """Writes the experiment; returns its path and what the hidden state of the test run exceeds its driver by, over a typical value."""
    case = CASES[name]
    text = [
        f"[experiment]\nname = {json.dumps(name)}\nmodel = 'AnnulusCooledMotor'\npreset = 'maxon-305015'",
        f"inputs = {json.dumps(INPUTS)}\noutputs = {json.dumps([*NOISE])}\n[set]",
        *(f"'{key}' = {true * error:.6g}" for (key, true), error in zip(TRUE.items(), ERROR)),
        "[prior]",
        *(f"'{key}' = {prior}" for key, prior in zip(TRUE, PRIOR)),
    ]
    above = 0.0
    for run, role in enumerate(ROLES):
        rng = np.random.default_rng([seed, zlib.crc32(name.encode()), run])
        loads, outputs, above = recorded(case, rng, run)
        time = 20000.0 * run + ROW * np.arange(len(loads))
        outputs = outputs + rng.normal(0.0, list(NOISE.values()), outputs.shape)
        file = f"run-{run + 1}.csv"
        header = ",".join(["time_s", *INPUTS, *NOISE])
        np.savetxt(folder / file, np.column_stack([time, loads, outputs]), "%.8g", ",", header=header, comments="")
        text.append(f"[[run]]\nfile = '{file}'\nrole = '{role}'\nstart = 'measured'")
    path = folder / "experiment.toml"
    path.write_text("\n".join(text) + "\n", encoding="utf-8")
    return path, above / TYPICAL[case.driver]
