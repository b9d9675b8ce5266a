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


@dataclass(frozen=True)
class Fault:
    """A sensor's flaw; `size` in the channel's unit, a share for blanks, of the largest value for clipping."""

    kind: str
    channel: str
    size: float


def drift(rng, times, values, size):
    """A slow wave over hours, of its own phase."""
    return values + size * np.sin(2.0 * np.pi * (times / rng.uniform(8000.0, 20000.0) + rng.random()))


def blanks(rng, times, values, size):
    """Single rows and one stretch of a few per cent, not measured."""
    lost = rng.random(len(values)) < size
    begin = rng.integers(len(values))
    lost[begin : begin + len(values) // 30] = True
    return np.where(lost, np.nan, values)


FAULTS = {
    "drift": drift,
    "quantised": lambda rng, times, values, size: size * np.round(values / size),
    "bias": lambda rng, times, values, size: values + size,
    "clipped": lambda rng, times, values, size: np.minimum(values, size * np.max(values)),
    "blanks": blanks,
    "dead": lambda rng, times, values, size: np.full_like(values, size),
}
COMMON = ("drift", "drift", "quantised", "quantised", "bias", "blanks", "dead", "clipped")


def draw_noise(rng) -> dict:
    factor = rng.uniform(*NOISE_FACTOR)
    return {channel: float(f"{factor * sigma:.3g}") for channel, sigma in NOISE.items()}


def draw_faults(rng, noise: dict, spared=()) -> list:
    """One kind of flaw: a bias hides in the noise, thermocouples drift together, a dead one is none of the `spared`."""
    kind = str(rng.choice(COMMON))
    if kind == "drift":
        return [Fault(kind, channel, float(rng.uniform(0.03, 0.08))) for channel in THERMOCOUPLES]
    if kind == "dead":
        free = [channel for channel in THERMOCOUPLES if channel not in spared]
        return [Fault(kind, str(rng.choice(free)), DEAD)]
    if kind == "clipped":
        return [Fault(kind, "shaft_torque_Nm", float(rng.uniform(0.85, 0.97)))]
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
                values = FAULTS[fault.kind](rng, times, values, fault.size)
        readings[channel] = values
    return readings


def described(faults) -> list:
    """For the truth file."""
    return [asdict(fault) for fault in faults]
