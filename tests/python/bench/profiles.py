"""Drive cycles: imposed current, speed, fan command and ambient temperature of one run.

Every input is linear between the rows, so a cycle is defined by its values at the rows, also across a gap. A run starts and ends at rest
(no current, no speed). Units are those of the columns: s, A, rad/s, 1, degC.
"""

from dataclasses import dataclass

import numpy as np

from .rig import AMBIENT, COLUMNS, FAN, NOMINAL, SPEED, Rig

SAMPLING = (0.5, 1.0, 2.0, 2.0, 5.0, 10.0)  # s between rows
DURATION = (1800.0, 7200.0)  # s; its logarithm is uniform
REST_BEFORE = (60.0, 180.0)  # s
REST_AFTER = (200.0, 500.0)  # s
ROOM_SPREAD = 3.0  # K from one run's room to another's
PAUSE = 8400.0  # s between two runs of a set: the motor soaks
GAIT_ROWS = 12  # rows in the shortest gait cycle
JITTER = 0.1  # of the time between rows
UNEVEN = (0.4, 1.6)  # the same, from the shortest to the longest of an uneven log


@dataclass(frozen=True)
class Demand:
    """Load level of a run of the public motor: largest A and rad/s, ambient degC, largest fan command."""

    current: float
    speed: float
    room: float
    fan: float = 1.0


# The test run is hotter and faster than what is fitted, in a warmer room with a slow fan.
DEMANDS = {
    "fit": Demand(4.4, 1250.0, 23.0),
    "validate": Demand(4.8, 1350.0, 23.0),
    "test": Demand(5.8, 1550.0, 30.0, 0.4),
}


def clock(rng, start: float) -> np.ndarray:
    """Times of the rows: equidistant, with jitter, or irregular as from a busy logger; sometimes with up to three gaps."""
    step = rng.choice(SAMPLING)
    times = np.arange(0.0, np.exp(rng.uniform(*np.log(DURATION))), step)
    kind = rng.random()
    if kind < 0.3:
        times[1:] += step * JITTER * rng.uniform(-1.0, 1.0, len(times) - 1)
    elif kind < 0.4:
        times = np.concatenate([[0.0], np.cumsum(step * rng.uniform(*UNEVEN, len(times) - 1))])
    if rng.random() < 0.3:
        for _ in range(rng.integers(1, 4)):
            begin = rng.uniform(0.1, 0.9) * times[-1]
            times = times[(times < begin) | (times > begin + rng.uniform(10.0, 60.0))]
    return start + np.round(times, 3)


def steps(rng, times, largest: float, ramp=(2.0, 20.0), hold=(60.0, 300.0), idle=0.15) -> np.ndarray:
    """Constant levels joined by ramps; a fraction of them is zero."""
    at, values, t = [times[0]], [0.0], times[0]
    while t < times[-1]:
        level = 0.0 if rng.random() < idle else rng.uniform(0.1, 1.0) * largest
        rise = rng.uniform(*ramp)
        at += [t + rise, t + rise + rng.uniform(*hold)]
        values += [level, level]
        t = at[-1]
    return np.interp(times, at, values)


def ramps(rng, times, largest: float) -> np.ndarray:
    """Slow ramps from level to level."""
    return steps(rng, times, largest, ramp=(100.0, 400.0), hold=(1.0, 60.0))


def gait(rng, times, largest: float) -> np.ndarray:
    """Periodic with two harmonics, never negative, its amplitude in steps."""
    period = rng.uniform(GAIT_ROWS, 3 * GAIT_ROWS) * max(np.median(np.diff(times)), 1.0)
    phase = 2.0 * np.pi * (times - times[0]) / period
    shape = 0.5 - 0.35 * np.cos(phase) + 0.15 * np.sin(2.0 * phase + rng.uniform(0.0, 2.0 * np.pi))
    return np.clip(shape, 0.0, 1.0) * steps(rng, times, largest)


def staircase(rng, times, largest: float) -> np.ndarray:
    """Equal steps up to the maximum and down again, minutes on each, sometimes repeated."""
    stairs = rng.integers(3, 6)
    levels = np.concatenate([np.arange(stairs), np.arange(stairs, 0, -1)]) * largest / stairs
    hold = rng.uniform(120.0, 300.0)
    at = np.arange(times[0], times[-1] + hold, hold)
    values = levels[np.arange(len(at)) % len(levels)]
    # Each stair begins with a short ramp.
    return np.interp(times, np.column_stack([at, at + hold - 8.0]).ravel(), np.repeat(values, 2))


def long_rests(rng, times, largest: float) -> np.ndarray:
    """Levels with pauses in which the motor cools."""
    return steps(rng, times, largest, hold=(200.0, 700.0), idle=0.45)


SHAPES = (steps, steps, ramps, gait, staircase, long_rests)


def rest(rng, times) -> np.ndarray:
    """1 while the motor is driven, 0 in the pauses at both ends, with short ramps."""
    begin, end = times[0] + rng.uniform(*REST_BEFORE), times[-1] - rng.uniform(*REST_AFTER)
    return np.interp(times, [begin, begin + 5.0, end - 5.0, end], [0.0, 1.0, 1.0, 0.0])


def fan_schedule(rng, times, largest: float) -> np.ndarray:
    """On and off at levels, for minutes at a time."""
    return np.clip(steps(rng, times, largest, ramp=(2.0, 6.0), hold=(200.0, 700.0), idle=0.35), 0.0, 1.0)


def room(rng, times, start: float) -> np.ndarray:
    """The ambient temperature: two slow waves of about half a kelvin that begin at `start`."""
    since = times - times[0]
    waves = np.zeros_like(times)
    for _ in range(2):
        phase = rng.uniform(0.0, 2.0 * np.pi)
        waves += rng.uniform(0.2, 0.6) * (np.sin(2.0 * np.pi * since / rng.uniform(2000.0, 7000.0) + phase) - np.sin(phase))
    return start + waves


def draw_run(rng, start: float, demand: Demand, rig: Rig):
    """Times and inputs by column name of one run. At standstill the power is the copper heat of the current, while it is cold."""
    times = clock(rng, start)
    driven = rest(rng, times)
    shape, largest = SHAPES[rng.integers(len(SHAPES))], demand.current
    if rig.layout.drive == "power":
        largest = rig.scaled(NOMINAL["motor.R_ref"] * largest**2, {"power": 1})
        inputs = {COLUMNS["power"]: driven * shape(rng, times, largest)}
    else:
        inputs = {COLUMNS["current"]: driven * shape(rng, times, rig.scaled(largest, {"current": 1}))}
        shape = SHAPES[rng.integers(len(SHAPES))]
        inputs[SPEED] = driven * shape(rng, times, rig.scaled(demand.speed, {"speed": 1}))
    inputs[FAN] = fan_schedule(rng, times, demand.fan)
    inputs[AMBIENT] = room(rng, times, round(demand.room + rng.uniform(-1.0, 1.0) * ROOM_SPREAD, 1))
    return times, inputs
