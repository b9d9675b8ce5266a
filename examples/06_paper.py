"""The paper's five runs close the loop: the error of an ideal DC motor, the part of it that the bridge voltage drop and friction
explain, and the temperatures, which no consistent model explains unless the sensor is 12 K off.

Run it with `motor-fmu` on the path; `--write` regenerates the runs of `06_paper/` with `motor-fmu reproduce`.
"""

import argparse
import json
from pathlib import Path

from clients.loop import close_loop, summary
from clients.seeds import paper_runs, write

FOLDER = Path(__file__).resolve().parent / "06_paper"

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="regenerate the runs")
    if parser.parse_args().write:
        write(paper_runs(), FOLDER)
    print(json.dumps(summary(close_loop(FOLDER / "EXPERIMENT.toml")), indent=2))
