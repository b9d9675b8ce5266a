"""What the bench's sensors make of the truth: white noise on every channel but the fan command, and one fault at times."""

from dataclasses import asdict, dataclass

import numpy as np

from .generator import INPUTS, OUTPUTS

# Standard deviation of each channel's white noise; a bench scales them all by one factor.
NOISE = {
    "current_A": 0.004,
    "speed_rad_per_s": 0.3,
    "ambient_temperature_degC": 0.02,
    "voltage_V": 0.02,
    "shaft_torque_Nm": 0.001,
    "winding_temperature_degC": 0.1,
    "housing_temperature_degC": 0.1,
}
NOISE_FACTOR = (0.7, 1.2)
DEAD = -40.0  # degC, what an amplifier shows for an open thermocouple
THERMOCOUPLES = OUTPUTS[2:]
DRIFT = (0.03, 8000.0, 0.0), (0.08, 20000.0, 2.0 * np.pi)  # lowest and highest size K, period s, phase rad
TORQUE_RANGE = (0.10, 0.14)  # N m, where a clipped torque sensor ends: in the peaks of the hardest runs


@dataclass(frozen=True)
class Fault:
    """A sensor's flaw; `size` in the channel's unit, a share for blanks; drift is a wave over the set's clock."""

    kind: str
    channel: str
    size: float
    period: float = 0.0  # s
    phase: float = 0.0  # rad


def drift(rng, times, values, fault):
    """A slow wave over hours, that goes on from file to file."""
    return values + fault.size * np.sin(2.0 * np.pi * times / fault.period + fault.phase)


def blanks(rng, times, values, fault):
    """Single rows and one stretch of a few per cent, not measured."""
    lost = rng.random(len(values)) < fault.size
    begin = rng.integers(len(values))
    lost[begin : begin + len(values) // 30] = True
    return np.where(lost, np.nan, values)


FAULTS = {
    "drift": drift,
    "quantised": lambda rng, times, values, fault: fault.size * np.round(values / fault.size),
    "bias": lambda rng, times, values, fault: values + fault.size,
    "clipped": lambda rng, times, values, fault: np.minimum(values, fault.size),
    "blanks": blanks,
    "dead": lambda rng, times, values, fault: np.full_like(values, fault.size),
}
COMMON = ("drift", "drift", "quantised", "quantised", "bias", "blanks", "dead", "clipped")


def draw_noise(rng) -> dict:
    factor = rng.uniform(*NOISE_FACTOR)
    return {channel: float(f"{factor * sigma:.3g}") for channel, sigma in NOISE.items()}


def draw_faults(rng, noise: dict, spared=()) -> list:
    """One kind of flaw: a bias hides in the noise, thermocouples drift together, a dead one is none of the `spared`."""
    kind = str(rng.choice(COMMON))
    if kind == "drift":
        return [Fault(kind, channel, *map(float, rng.uniform(*DRIFT))) for channel in THERMOCOUPLES]
    if kind == "dead":
        free = [channel for channel in THERMOCOUPLES if channel not in spared]
        return [Fault(kind, str(rng.choice(free)), DEAD)]
    if kind == "clipped":
        return [Fault(kind, "shaft_torque_Nm", float(rng.uniform(*TORQUE_RANGE)))]
    channel = str(rng.choice(OUTPUTS))
    sizes = {"quantised": noise[channel] * rng.uniform(1.0, 4.0), "bias": 0.3 * noise[channel], "blanks": 0.02}
    return [Fault(kind, channel, float(f"{sizes[kind]:.3g}"))]


def measure(rng, times, truth: dict, noise: dict, faults=()) -> dict:
    """Readings by column. The first row's ambient is exact: after a long soak it is read with care."""
    readings = {}
    for channel in (*INPUTS, *OUTPUTS):
        values = truth[channel] + noise.get(channel, 0.0) * rng.standard_normal(len(times))
        if channel == "ambient_temperature_degC":
            values[0] = truth[channel][0]
        for fault in faults:
            if fault.channel == channel:
                values = FAULTS[fault.kind](rng, times, values, fault)
        readings[channel] = values
    return readings


def described(faults) -> list:
    """For the truth file."""
    return [asdict(fault) for fault in faults]
