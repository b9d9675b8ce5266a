"""Draws sets of bench experiments: `python -m bench.make --seed N --out DIR [--effect ID] [--count K]`, in `tests/python`.

Of ten sets two are null, five have an effect that is in no list and three a listed one; two in five have a flawed sensor.
The same seed gives the same files.
"""

import argparse
from pathlib import Path

import numpy as np

from .effects import CATALOGUE
from .generator import TEMPERATURE_SENSORS, draw_specimen, simulate
from .profiles import DEMANDS, PAUSE, draw_run
from .sensors import draw_faults, draw_noise, measure
from .write import ROLES, Run, Set, write_set

KINDS = ("null",) * 2 + ("unlisted",) * 5 + ("listed",) * 3
FLAWED = 0.4  # share of sets with a flawed sensor
STATED = 0.7  # share of sets that state their noise
NONE = "none"


def drawn_kind(seed: int, number: int) -> str:
    """Each ten sets in a row have the shares of `KINDS`, in an order of their own."""
    order = np.random.default_rng([seed, number // len(KINDS)]).permutation(len(KINDS))
    return KINDS[order[number % len(KINDS)]]


def draw_effects(rng, kind: str, chosen: str | None) -> list:
    if chosen == NONE or (chosen is None and kind == "null"):
        return []
    names = [name for name, law in CATALOGUE.items() if law.listed == (kind == "listed")]
    law = CATALOGUE[chosen or str(rng.choice(names))]
    effect = law.draw(rng)
    if not law.some_runs:
        return [effect]
    # Once in the fitted runs and once outside of them, so that both sides can be seen.
    return [effect.only_in([int(rng.integers(0, 2)), int(rng.integers(2, len(ROLES)))])]


def draw_set(seed: int, number: int, chosen: str | None = None) -> Set:
    """Set `number` of a seed, with the effect of the id `chosen` if one is given, with no effect for `NONE`."""
    rng = np.random.default_rng([seed, number, len(KINDS)])
    effects = draw_effects(rng, drawn_kind(seed, number), chosen)
    noise = draw_noise(rng)
    spared = [TEMPERATURE_SENSORS.get(e.law.port) for e in effects]
    faults = draw_faults(rng, noise, spared) if rng.random() < FLAWED else []
    s = Set(f"bench-{seed}-{number}", draw_specimen(rng), effects, noise, bool(rng.random() < STATED), faults, [])
    start = 0.0
    for k, role in enumerate(ROLES):
        times, inputs = draw_run(rng, start, DEMANDS[role])
        truth = inputs | simulate(s.specimen, s.effects_in(k), times, inputs).outputs
        without = simulate(s.specimen, [], times, inputs).outputs if s.effects_in(k) else truth
        s.runs.append(Run(role, times, measure(rng, times, truth, noise, faults), truth, without))
        start = float(np.ceil(times[-1] + PAUSE))
    return s


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m bench.make", description="Draws sets of synthetic bench experiments.")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--effect", choices=[NONE, *CATALOGUE], metavar="ID", help=f"one of {', '.join([NONE, *CATALOGUE])}")
    parser.add_argument("--count", type=int, default=1)
    options = parser.parse_args(arguments)
    for number in range(options.count):
        s = draw_set(options.seed, number, options.effect)
        write_set(s, options.out / s.name)


if __name__ == "__main__":
    main()
