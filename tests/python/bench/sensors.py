"""Sensor model: white noise on every channel except the fan command, and sometimes one fault.

A sensor with a lower sampling rate is not a fault; it leaves blanks between its readings.
"""

from dataclasses import asdict, dataclass

import numpy as np

from .rig import AMBIENT, COLUMNS, HOUSING, PUBLIC, SPEED, TORQUE, WINDING, Rig

# Standard deviation of each channel's white noise; a bench scales them all by one factor.
NOISE = {
    COLUMNS["current"]: 0.004,
    SPEED: 0.3,
    AMBIENT: 0.02,
    COLUMNS["voltage"]: 0.02,
    COLUMNS["power"]: 0.02,
    TORQUE: 0.001,
    WINDING: 0.1,
    HOUSING: 0.1,
}
UNITS = {COLUMNS["current"]: "current", SPEED: "speed", COLUMNS["voltage"]: "voltage", COLUMNS["power"]: "power", TORQUE: "torque"}
NOISE_FACTOR = (0.7, 1.2)
DEAD = -40.0  # degC, what an amplifier shows for an open thermocouple
THERMOCOUPLES = (WINDING, HOUSING)
DRIFT = (0.03, 8000.0, 0.0), (0.08, 20000.0, 2.0 * np.pi)  # lowest and highest size K, period s, phase rad
TORQUE_RANGE = (0.10, 0.14)  # N m, where a clipped torque sensor ends: in the peaks of the hardest runs
COARSE = (0.1, 0.5)  # K, the steps of a thermometer that is read in few bits
SLOW = (3, 5, 10)  # rows from one reading of a slow sensor to the next


@dataclass(frozen=True)
class Fault:
    """A sensor fault; `size` in the channel's unit, a fraction for blanks; drift is a wave over the time of the set."""

    kind: str
    channel: str
    size: float
    period: float = 0.0  # s
    phase: float = 0.0  # rad


def drift(rng, times, values, fault):
    """A slow wave over hours, continuous across files."""
    return values + fault.size * np.sin(2.0 * np.pi * times / fault.period + fault.phase)


def blanks(rng, times, values, fault):
    """Single rows and one interval of a few per cent, not measured."""
    lost = rng.random(len(values)) < fault.size
    begin = rng.integers(len(values))
    lost[begin : begin + len(values) // 30] = True
    return np.where(lost, np.nan, values)


def slow(rng, times, values, fault):
    """Sampled every few rows only."""
    return np.where(np.arange(len(values)) % int(fault.size) == 0, values, np.nan)


FAULTS = {
    "drift": drift,
    "quantised": lambda rng, times, values, fault: fault.size * np.round(values / fault.size),
    "bias": lambda rng, times, values, fault: values + fault.size,
    "clipped": lambda rng, times, values, fault: np.minimum(values, fault.size),
    "blanks": blanks,
    "slow": slow,
    "dead": lambda rng, times, values, fault: np.full_like(values, fault.size),
}
COMMON = ("drift", "drift", "quantised", "quantised", "bias", "blanks", "dead", "clipped")


def draw_noise(rng, rig: Rig = PUBLIC) -> dict:
    factor = rng.uniform(*NOISE_FACTOR)
    columns = [c for c in NOISE if c in (*rig.layout.inputs, *rig.layout.outputs)]
    return {c: float(f"{factor * rig.scaled(NOISE[c], {UNITS[c]: 1} if c in UNITS else {}):.3g}") for c in columns}


def draw_faults(rng, noise: dict, spared=(), rig: Rig = PUBLIC) -> list:
    """One kind of fault: a bias within the noise, thermocouples that drift together, or a dead sensor (not one of `spared`)."""
    kind = str(rng.choice([kind for kind in COMMON if kind != "clipped" or TORQUE in rig.layout.outputs]))
    if kind == "drift":
        return [Fault(kind, channel, *map(float, rng.uniform(*DRIFT))) for channel in THERMOCOUPLES]
    if kind == "dead":
        free = [channel for channel in THERMOCOUPLES if channel not in spared]
        return [Fault(kind, str(rng.choice(free)), DEAD)]
    if kind == "clipped":
        return [Fault(kind, TORQUE, rig.scaled(float(rng.uniform(*TORQUE_RANGE)), {"torque": 1}))]
    channel = str(rng.choice(rig.layout.outputs))
    coarse = rng.uniform(*COARSE) if channel in THERMOCOUPLES else noise[channel] * rng.uniform(1.0, 4.0)
    sizes = {"quantised": coarse, "bias": 0.3 * noise[channel], "blanks": 0.02}
    return [Fault(kind, channel, float(f"{sizes[kind]:.3g}"))]


def draw_slow(rng, rig: Rig) -> Fault:
    return Fault("slow", str(rng.choice(rig.layout.outputs)), float(rng.choice(SLOW)))


def measure(rng, times, truth: dict, noise: dict, faults=(), rig: Rig = PUBLIC) -> dict:
    """Readings by column. The ambient temperature of the first row is exact: it is measured carefully after a long soak."""
    readings = {}
    for channel in (*rig.layout.inputs, *rig.layout.outputs):
        values = truth[channel] + noise.get(channel, 0.0) * rng.standard_normal(len(times))
        if channel == AMBIENT:
            values[0] = truth[channel][0]
        for fault in faults:
            if fault.channel == channel:
                values = FAULTS[fault.kind](rng, times, values, fault)
        readings[channel] = values
    return readings


def spread(noise: dict, faults, specimen: dict, rig: Rig) -> dict:
    """rms difference between a reading and the model with the measured inputs, by output; for a motor at 25 degC."""
    p = rig.nominal | specimen
    R, k_t = p["motor.R_ref"], p["motor.k_t"]
    i, v, w = (noise.get(c, 0.0) for c in (COLUMNS["current"], COLUMNS["voltage"], SPEED))
    brought = {COLUMNS["voltage"]: np.hypot(k_t * w, R * i), TORQUE: k_t * i}
    if rig.layout.drive == "voltage":
        driven = np.hypot(v, k_t * w) / R
        brought = {COLUMNS["current"]: driven, TORQUE: k_t * driven}
    flaws = {"drift": 0.5**0.5, "quantised": 12.0**-0.5}
    total = {c: noise[c] ** 2 + brought.get(c, 0.0) ** 2 for c in rig.layout.outputs}
    for fault in faults:
        total[fault.channel] += (flaws.get(fault.kind, 0.0) * fault.size) ** 2
    return {channel: float(square**0.5) for channel, square in total.items()}


def described(faults) -> list:
    """For the truth file."""
    return [asdict(fault) for fault in faults]
