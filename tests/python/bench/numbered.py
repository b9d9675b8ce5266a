"""Makes the numbered sets of a seed, in any number of processes; what both generators of sets share."""

import argparse
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from pathlib import Path

STAMP = "generator.stamp"


def add_options(parser: argparse.ArgumentParser):
    """The options of every generator; each adds what is its own."""
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--count", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first set")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--keep", action="store_true", help="keep sets that this generator has made before")


def make_sets(options, prefix: str, fingerprint: str, make_one):
    """Calls `make_one(options, number)` for each number; sets of another generator (fingerprint) are made again."""
    options.out.mkdir(parents=True, exist_ok=True)
    stamp = options.out / STAMP
    if not (stamp.exists() and stamp.read_text() == fingerprint):
        # Sets of another generator must not be taken for ours, also if we are stopped half-way.
        for old in options.out.glob(f"{prefix}-{options.seed}-*/truth.json"):
            old.unlink()
        stamp.write_text(fingerprint)
    numbers = range(options.first, options.first + options.count)
    if options.jobs == 1:
        progress((make_one(options, number) for number in numbers), options.count)
        return
    with ProcessPoolExecutor(options.jobs) as pool:
        waiting = [pool.submit(partial(make_one, options), number) for number in numbers]
        progress((done.result() for done in as_completed(waiting)), options.count)


def progress(sets, count: int):
    """A line for every ten sets."""
    for number, _ in enumerate(sets, 1):
        if number % 10 == 0 or number == count:
            print(f"{number} of {count} sets", flush=True)
