"""The thesis's eight tests close the loop: the error of the datasheet's motor, the fit of the unknown parameters, the
parameters that the tests do not distinguish, and the predictions of the tests that the fit did not use.

Run it with `motor-fmu` on the path; `--write` regenerates the runs of `05_thesis/` with `motor-fmu reproduce`.
"""

import argparse
import json
from pathlib import Path

from clients.loop import close_loop, summary
from clients.seeds import thesis_predictions, thesis_runs, write

FOLDER = Path(__file__).resolve().parent / "05_thesis"

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="regenerate the runs")
    if parser.parse_args().write:
        write(thesis_runs(), FOLDER)
    answer = summary(close_loop(FOLDER / "EXPERIMENT.toml")) | {"winding_temperature_K": thesis_predictions()}
    print(json.dumps(answer, indent=2))
