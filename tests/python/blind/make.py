"""Draws the sets of a seed: `python -m blind.make --seed N --out DIR [--count K] [--kind KIND] [--name ID] [--jobs J]`,
in `tests/python`.

Of twenty sets five are null, five have a listed effect, five a random law (two a function, one a product, two behind
a lag) and five an ordinary mistake. The same seed gives the same files, in any number of processes.
"""

import argparse
import hashlib
from pathlib import Path

import numpy as np
from bench.numbered import add_options, make_sets

from . import draw, laws, mistakes
from .files import write_set

KINDS = (
    (draw.NULL,) * 5
    + (draw.LISTED,) * 5
    + (draw.FUNCTION,) * 2
    + (draw.PRODUCT,)
    + (draw.HIDDEN,) * 2
    + (draw.MISTAKE,) * 5
)
EVALUATION = ("judge", "page", "run", "score")


def kind_of(seed: int, number: int) -> str:
    """Each twenty consecutive sets have the fractions of `KINDS`, in random order."""
    order = np.random.default_rng([seed, number // len(KINDS), 1]).permutation(len(KINDS))
    return KINDS[order[number % len(KINDS)]]


def name_of(seed: int, number: int, kind: str) -> str | None:
    """Listed effects and mistakes in random order without repetition, until all were used."""
    names = {draw.LISTED: list(laws.LISTED), draw.MISTAKE: list(mistakes.ALL)}.get(kind)
    if names is None:
        return None
    before = sum(kind_of(seed, n) == kind for n in range(number))
    order = np.random.default_rng([seed, before // len(names), 2]).permutation(len(names))
    return names[order[before % len(names)]]


def made(seed: int, number: int, kind: str | None = None, name: str | None = None) -> draw.Set:
    kind = kind or kind_of(seed, number)
    name = name or name_of(seed, number, kind)
    if kind != draw.MISTAKE:
        return draw.draw_set(seed, number, kind, name)
    for attempt in range(20):
        s = draw.draw_set(seed, number + 100_000 * attempt, draw.MISTAKE)
        if {*s.rig.layout.inputs, *s.rig.layout.outputs}.issuperset(mistakes.ALL[name].needs):
            break
    s.name = f"blind-{seed}-{number}"
    s.mistake = mistakes.draw(np.random.default_rng([seed, number, 3]), s, name)
    return s


def fingerprint() -> str:
    """Hash of the generator's sources: sets of another generator are other sets."""
    here = Path(__file__).parent
    sources = sorted(f for folder in (here, here.parent / "bench") for f in folder.glob("*.py"))
    parts = [f.name.encode() + f.read_bytes() for f in sources if f.stem not in EVALUATION]
    return hashlib.sha256(b"".join(parts)).hexdigest()


def make_one(options, number: int) -> str:
    folder = options.out / f"blind-{options.seed}-{number}"
    if not (options.keep and (folder / "truth.json").exists()):
        write_set(made(options.seed, number, options.kind, options.name), folder)
    return folder.name


def main(arguments=None):
    parser = argparse.ArgumentParser(
        prog="python -m blind.make", description="Draws sets of synthetic bench experiments."
    )
    add_options(parser)
    parser.add_argument("--kind", choices=sorted(set(KINDS)))
    parser.add_argument(
        "--name", choices=[*laws.LISTED, *mistakes.ALL], metavar="ID", help="a listed effect or a mistake, with --kind"
    )
    options = parser.parse_args(arguments)
    make_sets(options, "blind", fingerprint(), make_one)


if __name__ == "__main__":
    main()
