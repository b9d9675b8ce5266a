"""The thesis's eight tests close the loop: what the data sheet's motor misses, what a fit of the unknown makes of it, and what
these tests cannot tell apart.

Run it with `motor-fmu` on the path; `--write` writes the runs of `05_thesis/` anew from `motor-fmu reproduce`.
"""

import argparse
import json
from pathlib import Path

from clients.loop import close_loop, summary
from clients.seeds import thesis_runs, write

FOLDER = Path(__file__).resolve().parent / "05_thesis"

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write the runs anew")
    if parser.parse_args().write:
        write(thesis_runs(), FOLDER)
    print(json.dumps(summary(close_loop(FOLDER / "EXPERIMENT.toml")), indent=2))
