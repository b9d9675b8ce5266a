"""Detectability of an effect: its change of the outputs relative to the noise, before and after a refit of the parameters."""

from dataclasses import dataclass

import numpy as np

from .generator import simulate
from .sensors import spread

STEP = 0.1  # of a parameter's standard deviation, for its sensitivity
SIZE_STEP = 0.02  # of an effect's parameter, for its sensitivity
DETECTABLE = 0.2  # rms change over noise that a refit must leave in some channel; over 4000 rows a chi-square of 160
CHI_SQUARE = 40.0  # that a refit must leave in all channels together, where readings are few


@dataclass
class Finding:
    """Signal of effects per output relative to its noise, and the sum of squares over all fit readings."""

    plain: dict
    refit: dict
    chi_square: float

    @property
    def detectable(self) -> bool:
        return bool(max(self.refit.values()) >= DETECTABLE and self.chi_square >= CHI_SQUARE)


def rms(values) -> float:
    """Over the measured rows."""
    return float(np.sqrt(np.nanmean(np.square(values))))


def alive(s) -> list:
    """The outputs with a working sensor."""
    dead = {fault.channel for fault in s.faults if fault.kind == "dead"}
    return [channel for channel in s.rig.layout.outputs if channel not in dead]


class Seen:
    """The readings of some roles that count: present, with a working sensor, relative to their noise."""

    def __init__(self, s, roles):
        self.s, self.channels = s, alive(s)
        self.runs = [k for k, run in enumerate(s.runs) if any(role in roles for role in run.roles)]
        self.noise = spread(s.noise, s.faults, s.specimen, s.rig)
        self.rows = {k: np.any([s.runs[k].rows(role) for role in roles], axis=0) for k in self.runs}

    def whitened(self, one, other) -> list:
        """Differences of two lists of outputs, one item per run: an array per channel."""

        def block(channel):
            parts = []
            for k, a, b in zip(self.runs, one, other):
                counts = self.rows[k] & ~np.isnan(self.s.runs[k].readings[channel])
                parts.append((a[channel] - b[channel])[counts] / self.noise[channel])
            return np.concatenate(parts)

        return [block(channel) for channel in self.channels]

    def per_channel(self, blocks) -> dict:
        """rms of each channel; a dead one shows nothing."""
        shown = {channel: rms(block) for channel, block in zip(self.channels, blocks)}
        return {channel: shown.get(channel, 0.0) for channel in self.s.rig.layout.outputs}

    def simulated(self, specimen, effects) -> list:
        """Outputs of each run; `effects` are those that act in some run."""
        runs = [(k, self.s.runs[k]) for k in self.runs]
        acting = [[e for e in effects if e.acts_in(k)] for k, _ in runs]
        return [simulate(specimen, e, run.times, run.truth, self.s.rig).outputs for e, (_, run) in zip(acting, runs)]


def signal_to_noise(s) -> dict:
    """Per output over all runs: rms change without the effects, nothing refitted, relative to the noise."""
    seen = Seen(s, ("fit", "validate", "test"))
    return seen.per_channel(seen.whitened([run.truth for run in s.runs], [run.without for run in s.runs]))


def left(s, without: list, others=()):
    """Change in the fit runs, per channel, after the best linear change of all parameters within their priors. `without` has the outputs of
    those runs without the effect in question, `others` are the remaining effects; their sizes are free.
    """
    seen = Seen(s, ("fit",))
    change = seen.whitened([s.runs[k].truth for k in seen.runs], without)
    if not any(np.any(block) for block in change):
        return seen, change
    prior = s.rig.prior
    columns = []
    for name, sigma in prior.items():
        moved = s.specimen | {name: s.specimen[name] + STEP * sigma * s.rig.nominal[name]}
        columns.append(np.concatenate(seen.whitened(seen.simulated(moved, others), without)) / STEP)
    for effect in others:
        for name, value in effect.parameters.items():
            moved = [e.with_size(name, value * (1.0 + SIZE_STEP)) if e is effect else e for e in others]
            columns.append(np.concatenate(seen.whitened(seen.simulated(s.specimen, moved), without)) / SIZE_STEP)
    # One more row per parameter: its distance from the specimen costs what its prior says.
    stacked = np.column_stack(columns)
    bent = np.vstack([stacked, np.eye(len(prior), stacked.shape[1])])
    best = np.linalg.lstsq(bent, np.append(np.concatenate(change), np.zeros(len(prior))), rcond=None)[0]
    ends = np.cumsum([len(block) for block in change])[:-1]
    return seen, np.split(np.concatenate(change) - stacked @ best, ends)


def signal_to_noise_refit(s) -> dict:
    """The same as `signal_to_noise` in the fit runs, after that best change."""
    seen, blocks = left(s, [run.without for run in s.runs if "fit" in run.roles])
    return seen.per_channel(blocks)


def findings(s):
    """Signal of all effects together, and of each one with the others present."""
    plain = signal_to_noise(s)

    def finding(without, others=()):
        seen, blocks = left(s, without, others)
        return Finding(plain, seen.per_channel(blocks), float(sum(np.sum(np.square(block)) for block in blocks)))

    together = finding([run.without for run in s.runs if "fit" in run.roles])
    if len(s.effects) < 2:
        return together, [together] * len(s.effects)
    each = []
    for effect in s.effects:
        others = [e for e in s.effects if e is not effect]
        each.append(finding(Seen(s, ("fit",)).simulated(s.specimen, others), others))
    return together, each
