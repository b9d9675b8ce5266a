"""Five runs of one motor that disagree: each is predicted from the others, by the preset, a refit, a black box and the repaired model.

The runs are those of the measured motor of example 04 that have a thermocouple at the stator. Their thermocouples sit in other places and
other phases carry the current; nothing in the logs says how much this matters. Each split fits three runs, validates on one and tests one.
`--out FOLDER` keeps runs and reports and writes the page; `--only RUN` runs one split.
"""

import argparse
import json
import sys
import tempfile
import textwrap
from pathlib import Path

import numpy as np
from clients.loop import BUDGET_S
from clients.paths import ROOT
from clients.program import motor_fmu
from rig.splits import SENSORS, SPLITS, prepare, split

RAW = ROOT / "tests" / "reference" / "bench-bldc-stall"
STAGES = ("before", "refit", "blackbox", "after")
CHANNELS = {
    "winding": "winding_temperature_degC",
    "winding, second": "winding_temperature_2_degC",
    "stator": "stator_temperature_degC",
    "housing": "housing_temperature_degC",
}
# Energy at which the rises of the runs are compared, kJ: the shortest run has 41 kJ.
ENERGY_KJ = 20.0
# Two errors that differ by less are equal.
EQUAL = 1.02


def figures(value: float, digits: int = 3) -> float:
    """A number rounded to significant digits, so that rounding errors of the machine do not change it."""
    return float(f"{value:.{digits}g}")


def rises(folder: Path) -> dict:
    """Rise of each thermocouple, K, after the same electrical energy: no model is needed for it."""
    found = {}
    for run in SENSORS:
        table = np.genfromtxt(folder / f"run-{run}.csv", delimiter=",", names=True)
        time, power = table["time_s"], table["electrical_power_W"]
        spent = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (power[1:] + power[:-1]))]) / 1e3
        rise = {name: np.interp(ENERGY_KJ, spent, table[column] - table[column][:3].mean()) for name, column in CHANNELS.items()}
        found[run] = {name: figures(value) for name, value in rise.items()}
    return found


def one_split(folder: Path, test: str, validate: str) -> dict:
    """Verdict, parameters and the errors of the test run, K, of one split."""
    print(f"testing on run {test}, validating on run {validate}", file=sys.stderr)
    file = folder / f"test-{test}.toml"
    file.write_text(split(test, validate), encoding="utf-8")
    arguments = ("--out", str(folder / f"test-{test}"), "--budget", str(BUDGET_S), "--json", "--force")
    report = json.loads(motor_fmu("close-loop", str(file), *arguments))
    errors = report["error"]["test"]
    return {
        "validate": validate,
        "verdict": report["verdict"],
        "effects": [effect["id"] for effect in report["effects"]],
        "parameters": {name: figures(number["value"], 2) for name, number in report["parameters"].items()},
        "disagree": any("the fit runs disagree" in note for note in report["notes"]),
        "test_K": {name: {stage: figures(errors[column][stage]) for stage in STAGES} for name, column in CHANNELS.items()},
    }


def study(folder: Path, only: str | None = None) -> dict:
    """All splits, or one."""
    prepare(RAW, folder)
    chosen = [(test, validate) for test, validate in SPLITS if only in (None, test)]
    if not chosen:
        raise SystemExit(f"--only {only}: there is no such run; there are {', '.join(test for test, _ in SPLITS)}")
    return {"rise_K": rises(folder), "splits": {test: one_split(folder, test, validate) for test, validate in chosen}}


def count(answer: dict, stage: str, other: str) -> tuple[int, int]:
    """Channels of all test runs in which one stage is worse than another, and their number."""
    all_errors = [errors for one in answer["splits"].values() for errors in one["test_K"].values()]
    return sum(errors[stage] > EQUAL * errors[other] for errors in all_errors), len(all_errors)


def windings(answer: dict, runs: tuple[str, ...]) -> dict:
    """Least and greatest rise of the winding thermocouples over runs, K, and the greatest ratio of the two within a run."""
    pairs = [(answer["rise_K"][run]["winding"], answer["rise_K"][run]["winding, second"]) for run in runs]
    values = [value for pair in pairs for value in pair]
    return {"least": min(values), "greatest": max(values), "ratio": max(max(pair) / min(pair) for pair in pairs)}


def fill(text: str) -> str:
    return textwrap.fill(" ".join(text.split()), 128, break_on_hyphens=False)


def page(answer: dict) -> str:
    """The results and the treatment of the disagreement; each conclusion is computed from the numbers."""
    single, phases = ("12", "13"), ("10B", "10C", "10D")
    apart, together = windings(answer, single), windings(answer, phases)
    factors = " and ".join(f"{windings(answer, (run,))['ratio']:.1f} (run {run})" for run in single)
    worse, channels = count(answer, "after", "refit")
    preset = count(answer, "after", "before")[0]
    box = count(answer, "after", "blackbox")[0]
    found = sorted({effect for one in answer["splits"].values() for effect in one["effects"]})
    names = list(CHANNELS)
    rise_rows = [f"| {run} | " + " | ".join(f"{rise[name]:.1f}" for name in names) + " |" for run, rise in answer["rise_K"].items()]
    rows = [
        f"| {test} | {name} | " + " | ".join(f"{errors[stage]:.1f}" for stage in STAGES) + " |"
        for test, one in answer["splits"].items()
        for name, errors in one["test_K"].items()
    ]
    warmed = [rise["housing"] for rise in answer["rise_K"].values()]
    least, most = min(warmed), max(warmed)
    disagree = [test for test, one in answer["splits"].items() if one["disagree"]]
    effects = f"identified {', '.join(f'`{name}`' for name in found)}" if found else "finds no missing effect in any split"
    seats = apart["ratio"] > together["greatest"] / together["least"]
    within = "greater" if seats else "smaller"
    cause = "the mounting of the thermocouples and the phases with current, not the motor" if seats else "not the thermocouples alone"
    parts = [
        "# Runs of one motor that disagree",
        fill("""This page is generated by `examples/14_runs_that_disagree.py`; the nightly tests run the example and compare
        the page.
        It uses five runs of the motor of [the measured bench](close-the-loop-bench.md), heated near standstill by about 600
        W (run 12: 1200 W). `tests/reference/bench-bldc-stall/SOURCE.md` has the source. In run 10B a fan blew
        obliquely at the motor. The runs are divided in five ways (splits) into three fit runs, one validation run and one test run;
        each run is the test run of one split."""),
        "## Measured temperature rises",
        fill(f"""Temperature rise in K after {ENERGY_KJ:.0f} kJ of electrical energy. The housing is then only {least:.0f} to {most:.0f} K
        above its initial temperature, so the fan in run 10B has little effect. The stator's thermocouple is between winding and stator
        at phase A in runs 10B, 10C and 10D, and at the inner stator in runs 12 and 13."""),
        "\n".join(["| run | " + " | ".join(names) + " |", "|---|" + "---|" * len(names), *rise_rows]),
        fill(f"""The two thermocouples at the windings indicate {together["least"]:.0f} to {together["greatest"]:.0f} K in runs 10B,
        10C and 10D, but {apart["least"]:.0f} to {apart["greatest"]:.0f} K in runs 12 and 13, where both are at one winding.
        The ratio
        of the two in a run, at most {apart["ratio"]:.1f}, is {within} than the ratio between runs with the same mounting: the cause
        is {cause}. No set of motor parameters can follow all five runs."""),
        "## Errors of each run, predicted from others",
        fill(f"""Root mean square error of the test run in K. Before: preset. Refit: declared parameters fitted to the three fit runs.
        Black box: thermal network of two nodes with all parameters free, or ARX model, fitted to the same runs without the equations of
        the motor. After: model that `motor-fmu close-loop`
        exports. The command {effects}."""),
        "\n".join(["| test run | thermocouple | before | refit | black box | after |", "|---|---|---|---|---|---|", *rows]),
        fill(f"""The error of the exported model exceeds the error of the refit by more than 2 % in {worse} of {channels} cases, the error
        of the preset in {preset} and the error of the black box in {box}."""),
        "## Treatment of the disagreement",
        fill(f"""In {len(disagree)} of {len(answer["splits"])} splits a fit that assumes sensor noise only predicts left-out fit runs less accurately than
        the preset does. The disagreement is then added to the noise ([method](close-the-loop.md#method)); parameters that the runs do not
        determine stay near their priors. Two thermocouples at one winding that differ by a factor of {factors} limit every prediction for these runs: a model with one winding
        temperature cannot follow both, and a black box fitted to these runs can follow both thermocouples, but this does not carry over to the next run. The
        resistance of each phase during the run would measure the mean temperature of its copper and would show which thermocouple is the outlier."""),
    ]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="folder to keep everything in, and to write bench-splits.md to")
    parser.add_argument("--only", metavar="RUN", help="test on this run alone; no page is written")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        answer = study(given.out or Path(temporary), given.only)
    if given.out and not given.only:
        (given.out / "bench-splits.md").write_text(page(answer), encoding="utf-8")
    print(json.dumps(answer, indent=2))
