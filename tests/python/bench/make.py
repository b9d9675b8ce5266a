"""Draws sets of bench experiments: `python -m bench.make --seed N --out DIR [--effect ID] [--count K] [--jobs J]`,
in `tests/python`.

Of ten sets two are null, five have an effect that is in no list and three a listed one; two in five have a flawed sensor, a few
have a second effect. The motor, what drives it, the number of runs and their profiles differ from set to set.
The same seed gives the same files, in any number of processes.
"""

import argparse
import hashlib
from pathlib import Path

import numpy as np

from .effects import CATALOGUE
from .generator import simulate
from .numbered import add_options, make_sets
from .profiles import DEMANDS, PAUSE, draw_run
from .rig import COLUMNS, LAYOUTS, TEMPERATURE_SENSORS, Rig, draw_specimen, draw_units
from .sensors import draw_faults, draw_noise, draw_slow, measure
from .write import CUT, ROLES, Run, Set, write_set

KINDS = ("null",) * 2 + ("unlisted",) * 5 + ("listed",) * 3
FLAWED = 0.4  # share of sets with a flawed sensor
SLOWED = 0.15  # share of sets with a sensor that is read less often than the others
STATED = 0.7  # share of sets that state their noise
TWO = 0.1  # share of sets with an effect that have a second one, which is listed
OTHER_MOTOR = 0.5  # share of sets with another motor than the public one
DRIVES = {"current": 0.7, "voltage": 0.15, "power": 0.15}
RUNS = {2: 0.1, 3: 0.15, 4: 0.6, 5: 0.15}
NONE = "none"


def drawn_kind(seed: int, number: int) -> str:
    """Each ten consecutive sets have the fractions of `KINDS`, in random order."""
    order = np.random.default_rng([seed, number // len(KINDS)]).permutation(len(KINDS))
    return KINDS[order[number % len(KINDS)]]


def draw_laws(rng, kind: str, chosen: str | None) -> list:
    """The laws of a set. A second one is listed and has another port, so that it has to be found separately."""
    if chosen == NONE or (chosen is None and kind == "null"):
        return []
    names = [name for name, law in CATALOGUE.items() if law.listed == (kind == "listed")]
    laws = [CATALOGUE[chosen or str(rng.choice(names))]]
    if chosen is None and rng.random() < TWO:
        beside = lambda law: law.port != laws[0].port and any(on.allows(laws[0]) and on.allows(law) for on in LAYOUTS.values())  # noqa: E731
        others = [law for law in CATALOGUE.values() if law.listed and law.drive is None and beside(law)]
        laws.append(others[rng.integers(len(others))])
    return laws


def draw_rig(rng, laws) -> Rig:
    """A bench on which all of these laws can act."""
    drives = [drive for drive in DRIVES if all(LAYOUTS[drive].allows(law) for law in laws)]
    shares = np.array([DRIVES[drive] for drive in drives])
    drive = str(rng.choice(drives, p=shares / shares.sum()))
    return Rig(LAYOUTS[drive], draw_units(rng) if rng.random() < OTHER_MOTOR else {})


def draw_roles(rng, laws) -> tuple:
    """The number of runs and their roles. An effect in some runs only needs two fit runs."""
    counts = [count for count in RUNS if count >= 4 or not any(law.some_runs for law in laws)]
    shares = np.array([RUNS[count] for count in counts])
    return ROLES[int(rng.choice(counts, p=shares / shares.sum()))]


def draw_effect(rng, law, rig: Rig, roles):
    effect = law.draw(rng, rig)
    if not law.some_runs:
        return effect
    # Once in the fitted runs and once outside of them, so that both sides can be seen.
    fitted = sum("fit" in names for names in roles)
    return effect.only_in([int(rng.integers(0, fitted)), int(rng.integers(fitted, len(roles)))])


def imposed(specimen: dict, times, inputs: dict, rig: Rig) -> dict:
    """Imposed voltage: the one that gives the demanded current in a motor without the effects."""
    if rig.layout.drive != "voltage":
        return inputs
    current = Rig(LAYOUTS["current"], rig.units)
    voltage = simulate(specimen, [], times, inputs, current).outputs[COLUMNS["voltage"]]
    return {COLUMNS["voltage"]: voltage} | {name: inputs[name] for name in rig.layout.inputs[1:]}


def windows(times, names) -> dict:
    """The window of each role of a run, in s."""
    if len(names) == 1:
        return {names[0]: None}
    begin, end = float(times[0]), float(times[-1])
    cut = round(begin + CUT * (end - begin), 1)
    return dict(zip(names, ((begin, cut), (cut + 0.001, end))))


def draw_set(seed: int, number: int, chosen: str | None = None, rig: Rig | None = None, count: int | None = None) -> Set:
    """Set `number` of a seed, with the effect of the id `chosen` if one is given, with no effect for `NONE`; on a rig if one is given."""
    rng = np.random.default_rng([seed, number, len(KINDS)])
    laws = draw_laws(rng, drawn_kind(seed, number), chosen)
    rig = rig or draw_rig(rng, laws)
    roles = ROLES[count] if count else draw_roles(rng, laws)
    effects = [draw_effect(rng, law, rig, roles) for law in laws]
    noise = draw_noise(rng, rig)
    spared = [TEMPERATURE_SENSORS.get(e.law.port) for e in effects]
    faults = draw_faults(rng, noise, spared, rig) if rng.random() < FLAWED else []
    if rng.random() < SLOWED:
        faults.append(draw_slow(rng, rig))
    s = Set(f"bench-{seed}-{number}", rig, draw_specimen(rng, rig), effects, noise, bool(rng.random() < STATED), faults, [])
    start = 0.0
    for k, names in enumerate(roles):
        times, demanded = draw_run(rng, start, DEMANDS[names[0]], rig)
        inputs = imposed(s.specimen, times, demanded, rig)
        without = simulate(s.specimen, [], times, inputs, rig).outputs
        truth = inputs | (simulate(s.specimen, s.effects_in(k), times, inputs, rig).outputs if s.effects_in(k) else without)
        s.runs.append(Run(windows(times, names), times, measure(rng, times, truth, noise, faults, rig), truth, without))
        start = float(np.ceil(times[-1] + PAUSE))
    return s


def fingerprint() -> str:
    """Hash of the generator's sources: sets of another generator are other sets."""
    sources = sorted(Path(__file__).parent.glob("*.py"))
    parts = [f.name.encode() + f.read_bytes() for f in sources]
    return hashlib.sha256(b"".join(parts)).hexdigest()


def make_one(options, number: int) -> str:
    """Writes a set unless it is complete; the truth is written last."""
    folder = options.out / f"bench-{options.seed}-{number}"
    if not (options.keep and (folder / "truth.json").exists()):
        write_set(draw_set(options.seed, number, options.effect), folder)
    return folder.name


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m bench.make", description="Draws sets of synthetic bench experiments.")
    add_options(parser)
    parser.add_argument("--effect", choices=[NONE, *CATALOGUE], metavar="ID", help=f"one of {', '.join([NONE, *CATALOGUE])}")
    options = parser.parse_args(arguments)
    make_sets(options, "bench", fingerprint(), make_one)


if __name__ == "__main__":
    main()
