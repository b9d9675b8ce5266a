"""Times, inputs and noise of the runs of a set."""

from dataclasses import dataclass

import numpy as np
from bench.profiles import DEMANDS, ROOM_SPREAD, SHAPES, fan_schedule, rest, room
from bench.rig import AMBIENT, COLUMNS, FAN, HOUSING, NOMINAL, SPEED, WINDING
from bench.sensors import NOISE, UNITS

SAMPLING = {1.0: 0.1, 2.0: 0.4, 5.0: 0.3, 10.0: 0.2}  # s between rows
DURATION = (1500.0, 4500.0)  # s
PREHEAT = (300.0, 1200.0)  # s that are not in the file of a run that starts warm
NOISE_FACTOR = (0.5, 1.5)
PAUSE = 8400.0


@dataclass
class Bench:
    """Noise of one bench: standard deviations by column, slow waves as (size in standard deviations, period s,
    phase), correlation.
    """

    noise: dict
    waves: dict
    memory: float  # correlation of the noise of the thermometers from row to row


def draw_bench(rng, rig) -> Bench:
    factor = rng.uniform(*NOISE_FACTOR)
    columns = [c for c in NOISE if c in (*rig.layout.inputs, *rig.layout.outputs)]
    noise = {c: float(f"{factor * rig.scaled(NOISE[c], {UNITS[c]: 1} if c in UNITS else {}):.3g}") for c in columns}
    waves = {}
    for c in columns:
        if rng.random() < 0.4:
            waves[c] = (
                float(rng.uniform(0.1, 1.0)),
                float(rng.uniform(8000.0, 30000.0)),
                float(rng.uniform(0.0, 2.0 * np.pi)),
            )
    return Bench(noise, waves, float(rng.uniform(0.3, 0.8)) if rng.random() < 0.3 else 0.0)


def clock(rng, start: float, lead: float) -> np.ndarray:
    """Times of a run: equidistant, jittered or irregular, sometimes with gaps; `lead` s more at the beginning."""
    step = float(rng.choice(list(SAMPLING), p=list(SAMPLING.values())))
    times = np.arange(0.0, lead + np.exp(rng.uniform(*np.log(DURATION))), step)
    kind = rng.random()
    if kind < 0.25:
        times[1:] += 0.1 * step * rng.uniform(-1.0, 1.0, len(times) - 1)
    elif kind < 0.5:
        times = np.concatenate([[0.0], np.cumsum(step * rng.uniform(0.4, 1.6, len(times) - 1))])
    if rng.random() < 0.3:
        for _ in range(rng.integers(1, 4)):
            begin = rng.uniform(0.2, 0.9) * times[-1]
            times = times[(times < begin) | (times > begin + rng.uniform(10.0, 60.0))]
    return start + np.round(times, 3)


def draw_inputs(rng, times, role: str, rig) -> dict:
    """Imposed columns; for a voltage, first the demanded current (see `draw.draw_runs`)."""
    demand, driven = DEMANDS[role], rest(rng, times)
    shape = lambda: SHAPES[rng.integers(len(SHAPES))]  # noqa: E731
    current = driven * shape()(rng, times, rig.scaled(demand.current, {"current": 1}))
    speed = driven * shape()(rng, times, rig.scaled(demand.speed, {"speed": 1}))
    inputs = {COLUMNS["current"]: current}
    if rig.layout.drive == "power":
        inputs = {
            COLUMNS["power"]: driven
            * shape()(rng, times, rig.scaled(NOMINAL["motor.R_ref"] * demand.current**2, {"power": 1}))
        }
    if SPEED in rig.layout.inputs:
        inputs[SPEED] = speed
    begin = round(demand.room + rng.uniform(-1.0, 1.0) * ROOM_SPREAD, 1)
    return inputs | {FAN: fan_schedule(rng, times, demand.fan), AMBIENT: room(rng, times, begin)}


def measured(rng, bench: Bench, times, column: str, values) -> np.ndarray:
    """White or correlated noise and slow drift; the fan command is exact."""
    sigma = bench.noise.get(column, 0.0)
    if not sigma:
        return values
    white = rng.standard_normal(len(times))
    if bench.memory and column in (WINDING, HOUSING):
        for k in range(1, len(white)):
            white[k] = bench.memory * white[k - 1] + (1.0 - bench.memory**2) ** 0.5 * white[k]
    size, period, phase = bench.waves.get(column, (0.0, 1.0, 0.0))
    return values + sigma * (white + size * np.sin(2.0 * np.pi * times / period + phase))
