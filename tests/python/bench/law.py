"""An effect: a law with port, driver and plausible sizes, in a catalogue; and a law with the size of one specimen."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import sqrt

import numpy as np

KELVIN = 273.15  # K at 0 degC


@dataclass(frozen=True)
class Law:
    """An entry of the catalogue: port, driver, range of sizes."""

    id: str
    port: str
    driver: str
    text: str
    add: Callable
    ranges: dict
    listed: bool
    signed: bool = False
    some_runs: bool = False  # acts in some runs of a set only
    fixed: tuple = ()  # parameters that are no number, as (name, value)
    scale: dict = field(default_factory=dict)  # how a size goes with the units of a rig: {parameter: {unit: exponent}}
    drive: str | None = None  # the only drive that it can act with
    switch: Callable | None = None  # (x, was_on, **parameters) -> bool, asked at rows only: the law counts while it is on
    filter: Callable | None = None  # (times, readings, **parameters) -> readings of a sensor with a memory

    def draw(self, rng, rig) -> "Effect":
        """A random size for a specimen on this rig."""
        sign = rng.choice([-1.0, 1.0]) if self.signed else 1.0
        sizes = {name: float(np.exp(rng.uniform(*np.log(limits)))) for name, limits in self.ranges.items()}
        sizes = {name: rig.scaled(size, self.scale.get(name, {})) for name, size in sizes.items()}
        first = next(iter(sizes))
        return Effect(self, sizes | {first: sign * sizes[first]})

    def typical(self) -> "Effect":
        """The size in the middle of the ranges, with a positive sign."""
        return Effect(self, {name: sqrt(low * high) for name, (low, high) in self.ranges.items()})


@dataclass(frozen=True)
class Effect:
    """A law with its size, in some runs (numbers from 0) or in all (None)."""

    law: Law
    parameters: dict
    runs: tuple | None = None

    def only_in(self, runs) -> "Effect":
        return replace(self, runs=tuple(runs))

    def with_size(self, name: str, value: float) -> "Effect":
        return replace(self, parameters=self.parameters | {name: value})

    def acts_in(self, run: int) -> bool:
        return self.runs is None or run in self.runs


CATALOGUE: dict[str, Law] = {}


def effect(port, driver, text, listed=False, **options):
    """Adds the function to the catalogue under its own name; pairs among the options are the ranges of its parameters."""
    ranges = {name: value for name, value in options.items() if isinstance(value, tuple) and name != "fixed"}
    rest = {name: value for name, value in options.items() if name not in ranges}

    def enter(add):
        CATALOGUE[add.__name__] = Law(add.__name__, port, driver, text, add, ranges, listed, **rest)
        return add

    return enter


def known(*arguments, **options):
    """A listed effect."""
    return effect(*arguments, listed=True, **options)
