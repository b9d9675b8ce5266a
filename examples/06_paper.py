"""The paper's five runs close the loop: what an ideal DC motor misses, what a bridge's drop and friction explain of it, and what
no consistent model does: its temperatures, for which the sensor would have to be 12 K off.

Run it with `motor-fmu` on the path; `--write` writes the runs of `06_paper/` anew from `motor-fmu reproduce`.
"""

import argparse
import json
from pathlib import Path

from clients.loop import close_loop, summary
from clients.seeds import paper_runs, write

FOLDER = Path(__file__).resolve().parent / "06_paper"

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write the runs anew")
    if parser.parse_args().write:
        write(paper_runs(), FOLDER)
    print(json.dumps(summary(close_loop(FOLDER / "EXPERIMENT.toml")), indent=2))
