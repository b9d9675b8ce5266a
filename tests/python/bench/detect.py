"""How well an effect can be seen: what it changes over the noise, as it stands and after the parameters bent to hide it."""

import numpy as np

from .generator import NOMINAL, OUTPUTS, PRIOR, simulate

STEP = 0.1  # of a parameter's standard deviation, for its sensitivity
DETECTABLE = 0.2  # rms change over noise that a refit must leave in some channel; over 4000 rows a chi-square of 160


def rms(values) -> float:
    """Over the rows that were measured."""
    return float(np.sqrt(np.nanmean(np.square(values))))


def alive(s) -> list:
    """The outputs of a set whose sensor is not dead."""
    dead = {fault.channel for fault in s.faults if fault.kind == "dead"}
    return [channel for channel in OUTPUTS if channel not in dead]


def per_channel(s, channels, values) -> dict:
    """rms of each block of the stacked whitened outputs; a dead channel shows nothing."""
    shown = {channel: rms(block) for channel, block in zip(channels, np.split(values, len(channels)))}
    return {channel: shown.get(channel, 0.0) for channel in OUTPUTS}


def signal_to_noise(s) -> dict:
    """Per output, all runs: rms change when the effects are taken away, nothing refitted, over the noise."""
    channels = alive(s)
    return per_channel(s, channels, whitened(s, channels, [(run.truth, run.without) for run in s.runs]))


def whitened(s, channels, pairs) -> np.ndarray:
    """Differences of pairs of outputs over the noise, stacked: channel by channel, run by run."""
    return np.concatenate([(one[c] - other[c]) / s.noise[c] for c in channels for one, other in pairs])


def signal_to_noise_refit(s) -> dict:
    """The same in the runs to fit, after the best linear change of all parameters within their priors."""
    channels, runs = alive(s), [run for run in s.runs if run.role == "fit"]
    change = whitened(s, channels, [(run.truth, run.without) for run in runs])
    if not np.any(change):
        return dict.fromkeys(OUTPUTS, 0.0)
    columns = []
    for name, sigma in PRIOR.items():
        moved = s.specimen | {name: s.specimen[name] + STEP * sigma * NOMINAL[name]}
        pairs = [(simulate(moved, [], run.times, run.truth).outputs, run.without) for run in runs]
        columns.append(whitened(s, channels, pairs) / STEP)
    # One more row per parameter: its distance from the specimen costs what its prior says.
    bent = np.vstack([np.column_stack(columns), np.eye(len(PRIOR))])
    best = np.linalg.lstsq(bent, np.append(change, np.zeros(len(PRIOR))), rcond=None)[0]
    return per_channel(s, channels, change - bent[: len(change)] @ best)
