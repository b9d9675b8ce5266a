"""Drive cycles: what a bench operator imposes on current, speed, fan and room in one run.

Every input runs linearly between the rows, so a cycle is just its values at the rows, also across a gap. A run starts and ends
at rest (no current, no speed). Units are those of the columns: s, A, rad/s, 1, degC.
"""

from dataclasses import dataclass

import numpy as np

from .generator import INPUTS

SAMPLING = (0.5, 1.0, 2.0, 2.0, 5.0)  # s between rows
DURATION = (3600.0, 4400.0)  # s
REST_BEFORE = (60.0, 180.0)  # s
REST_AFTER = (200.0, 500.0)  # s
ROOM_SPREAD = 3.0  # K from one run's room to another's
PAUSE = 8400.0  # s between two runs of a set: the motor soaks
GAIT_ROWS = 12  # rows in the shortest gait cycle
JITTER = 0.1  # of the time between rows


@dataclass(frozen=True)
class Demand:
    """How hard a run is driven: largest A and rad/s, the room's degC, the largest fan command."""

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
    """Times of the rows: equidistant, or with jitter, or with up to three gaps."""
    step = rng.choice(SAMPLING)
    times = np.arange(0.0, rng.uniform(*DURATION), step)
    if rng.random() < 0.3:
        times[1:] += step * JITTER * rng.uniform(-1.0, 1.0, len(times) - 1)
    if rng.random() < 0.3:
        for _ in range(rng.integers(1, 4)):
            begin = rng.uniform(0.1, 0.9) * times[-1]
            times = times[(times < begin) | (times > begin + rng.uniform(10.0, 60.0))]
    return start + np.round(times, 3)


def steps(rng, times, largest: float, ramp=(2.0, 20.0), hold=(60.0, 300.0), idle=0.15) -> np.ndarray:
    """Levels held for a while, joined by ramps; a share of them is zero."""
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


SHAPES = (steps, steps, ramps, gait)


def rest(rng, times) -> np.ndarray:
    """1 while the motor is driven, 0 in the rests at both ends, with short ramps."""
    begin, end = times[0] + rng.uniform(*REST_BEFORE), times[-1] - rng.uniform(*REST_AFTER)
    return np.interp(times, [begin, begin + 5.0, end - 5.0, end], [0.0, 1.0, 1.0, 0.0])


def fan_schedule(rng, times, largest: float) -> np.ndarray:
    """Off and on at levels, minutes at a time."""
    return np.clip(steps(rng, times, largest, ramp=(2.0, 6.0), hold=(200.0, 700.0), idle=0.35), 0.0, 1.0)


def room(rng, times, start: float) -> np.ndarray:
    """The ambient temperature: two slow waves of about half a kelvin that begin at `start`."""
    since = times - times[0]
    waves = np.zeros_like(times)
    for _ in range(2):
        phase = rng.uniform(0.0, 2.0 * np.pi)
        waves += rng.uniform(0.2, 0.6) * (np.sin(2.0 * np.pi * since / rng.uniform(2000.0, 7000.0) + phase) - np.sin(phase))
    return start + waves


def draw_run(rng, start: float, demand: Demand):
    """Times and inputs by column name of one run."""
    times = clock(rng, start)
    driven = rest(rng, times)
    current = driven * SHAPES[rng.integers(len(SHAPES))](rng, times, demand.current)
    speed = driven * SHAPES[rng.integers(len(SHAPES))](rng, times, demand.speed)
    fan = fan_schedule(rng, times, demand.fan)
    ambient = room(rng, times, round(demand.room + rng.uniform(-1.0, 1.0) * ROOM_SPREAD, 1))
    return times, dict(zip(INPUTS, (current, speed, fan, ambient)))
