"""Refit of the known parameters against repair of the model: which of the two still predicts outside the fitted range?

Two synthetic motors with a drag that the model lacks, so that the truth is known. Their test runs are faster and hotter than
what is fitted. Run it with `motor-fmu` on the path; `--out FOLDER` also writes the answer as a page of Markdown with a figure.
"""

import argparse
import csv
import json
import re
import textwrap
from pathlib import Path
from tempfile import TemporaryDirectory

from clients.loop import BUDGET_S
from clients.paths import ROOT
from clients.program import motor_fmu

SETS = ROOT / "tests" / "reference" / "bench-synthetic"
MOTORS = {"iron-loss": "iron loss, torque ~ speed^0.5", "drag-power-075": "unlisted friction, torque ~ speed^0.75"}
ROLES = {"fit": "fitted runs", "validate": "validation run", "test": "test run, outside the fitted range"}
STAGES = ("before", "refit", "after", "floor")
# The figure is of this motor's winding over its test run.
SHOWN, PLATE = "drag-power-075", "winding temperature, without the preset"
FIGURE = "refit-against-repair.svg"
# Standard deviations in half an interval of 95 %.
WITHIN_95 = 1.96


def figures(value: float, digits: int = 3) -> float:
    """A number rounded to significant digits, so that rounding errors of the machine do not change it."""
    return float(f"{value:.{digits}g}")


def off(estimate: dict, true: float) -> dict:
    """Error of a fitted value: in percent of the true value, and in standard deviations of the fit."""
    low, high = estimate["ci95"]
    deviations = (estimate["value"] - true) / (0.5 * (high - low) / WITHIN_95)
    return {
        "value": figures(estimate["value"]),
        "percent_off": figures(100.0 * (estimate["value"] / true - 1.0), 2),
        "own_deviations_off": figures(deviations, 2),
    }


def reached(name: str, column: str, runs: range) -> float:
    """The greatest value of a column over some of a motor's runs."""
    files = (SETS / name / f"run-{run}.csv" for run in runs)
    return max(float(row[column]) for file in files for row in csv.DictReader(file.open(encoding="utf-8")))


def compare(name: str, folder: Path) -> dict:
    """Errors and parameters of the refit and of the repair."""
    arguments = (str(SETS / name / "experiment.toml"), "--out", str(folder), "--budget", str(BUDGET_S), "--json")
    report = json.loads(motor_fmu("close-loop", *arguments))
    truth = json.loads((SETS / name / "truth.json").read_text(encoding="utf-8"))["parameters"]
    return {
        "verdict": report["verdict"],
        "effects": [
            {"id": e["id"], "port": e["port"], "driver": e["driver"]}
            | {symbol: figures(number["value"], 2) for symbol, number in e["parameters"].items()}
            for e in report["effects"]
        ],
        "reached": {
            column: {"fitted": figures(reached(name, column, range(1, 3))), "tested": figures(reached(name, column, range(4, 5)))}
            for column in ("speed_rad_per_s", "winding_temperature_degC")
        },
        "error": {
            role: {column: {stage: figures(e[stage]) for stage in STAGES} for column, e in report["error"][role].items()}
            for role in ROLES
        },
        "parameters": {
            key: {"true": figures(true), "refit": off(report["refit"][key], true), "after": off(report["parameters"][key], true)}
            for key, true in truth.items()
        },
    }


def figure(report: str) -> str:
    """Residuals of refit and repair in the winding temperature over the test run, as report.html draws them."""
    test = report[report.index("(test)</summary>") :]
    drawn = re.search(rf'<svg [^>]*aria-label="{PLATE}".*?</svg>', test, re.DOTALL).group(0)
    return drawn.replace(PLATE, "winding temperature in the test run") + "\n"


def errors(answer: dict) -> str:
    """Winding errors as Markdown."""
    lines = ["| RMSE of the winding temperature, K | before | refit | after | noise |", "|---|---|---|---|---|"]
    for name, what in MOTORS.items():
        for role, words in ROLES.items():
            e = answer[name]["error"][role]["winding_temperature_degC"]
            lines.append(f"| {what}: {words} | " + " | ".join(f"{e[stage]:.2f}" for stage in STAGES) + " |")
    return "\n".join(lines)


def parameters(motor: dict) -> str:
    """Parameters as Markdown."""
    lines = ["| parameter | true | refit | error (standard deviations) | repaired | error (standard deviations) |", "|---|---|---|---|---|---|"]
    said = lambda p: f"{p['value']:g} | {p['percent_off']:+g} % ({abs(p['own_deviations_off']):g})"  # noqa: E731
    for key, p in motor["parameters"].items():
        lines.append(f"| `{key}` | {p['true']:g} | {said(p['refit'])} | {said(p['after'])} |")
    return "\n".join(lines)


def larger(percent: float) -> str:
    """A deviation in words."""
    return f"{abs(percent):.2g} % too {'large' if percent > 0.0 else 'small'}"


def biased(motor: dict) -> list[str]:
    """Parameters of the refit that are further from the truth than its intervals of 95 % allow, worst first."""
    off = lambda key: abs(motor["parameters"][key]["refit"]["own_deviations_off"])  # noqa: E731
    return sorted((key for key in motor["parameters"] if off(key) > WITHIN_95), key=off, reverse=True)


def refit_words(motor: dict) -> str:
    """The refit on its own runs, and its parameters."""
    winding = motor["error"]["fit"]["winding_temperature_degC"]
    better = "falls" if winding["refit"] < winding["before"] else "does not fall"
    wrong = biased(motor)
    each = "; ".join(
        f"`{key}` is {larger(p['percent_off'])} ({abs(p['own_deviations_off']):.0f} standard deviations)"
        for key, p in ((key, motor["parameters"][key]["refit"]) for key in wrong)
    )
    verdict = (
        f"""For {len(wrong)} of {len(motor["parameters"])} parameters the true value is outside the 95 % interval of the refit (deviation in
        percent of the true value, and in standard deviations of the refit): {each}. The intervals of a fit are valid only if the model is
        correct; this model lacks a friction torque."""
        if wrong
        else "All true values are within the 95 % intervals of the refit."
    )
    return f"""Motor with {MOTORS[SHOWN]}: in the fitted runs the RMSE of the winding temperature {better} by the refit from
        {winding["before"]:.2g} to {winding["refit"]:.2g} K. {verdict}"""


def test_words(answer: dict) -> str:
    """Refit and repair outside the fitted range."""
    motor = answer[SHOWN]
    speed, heat = motor["reached"]["speed_rad_per_s"], motor["reached"]["winding_temperature_degC"]
    lines = []
    for name, what in MOTORS.items():
        e = answer[name]["error"]["test"]["winding_temperature_degC"]
        times = lambda stage: f"{e[stage]:.2g} K, {e[stage] / e['floor']:.1f} times the noise"  # noqa: B023, E731
        lines.append(f"{what}: refit {times('refit')}, repaired {times('after')}")
    sizes = [abs(p["after"]["own_deviations_off"]) for m in answer.values() for p in m["parameters"].values()]
    inside = sum(size <= WITHIN_95 for size in sizes)
    return f"""The fitted runs reach a speed of {speed["fitted"]:.0f} rad/s and a winding temperature of {heat["fitted"]:.0f} °C, the test
        run {speed["tested"]:.0f} rad/s and {heat["tested"]:.0f} °C. RMSE of the winding temperature in the test run: {"; ".join(lines)}.
        For {inside} of the {len(sizes)} parameters of both repaired models the true value is within the 95 % interval; the largest
        deviation is {max(sizes):.1f} standard deviations."""


def page(answer: dict) -> str:
    """The answer with its numbers; each conclusion is computed from them."""
    other = answer[SHOWN]
    intro = """This page is generated by `examples/07_refit_against_repair.py`; the nightly tests run the example and compare the page. The data of two
        motors are synthetic (see `tests/reference/bench-synthetic/SOURCE.md`), so that the true parameters are known. Each motor has a
        friction torque that the model lacks. Before: the preset. Refit: the declared parameters fitted, no effect added. After
        (repaired): the model with the effect or law that `motor-fmu close-loop` identified in the same runs. Noise: the error of the true
        model."""
    fill = lambda paragraph: textwrap.fill(" ".join(paragraph.split()), 128, break_on_hyphens=False)  # noqa: E731
    parts = [
        "# Parameter refit compared with model repair",
        fill(intro),
        errors(answer),
        fill(refit_words(other)),
        parameters(other),
        "Units of the parameters: [parameter list](../model-description/AnnulusCooledMotor/parameters.md).",
        fill(test_words(answer)),
        f"![Residual of refit and repair in the winding temperature over the test run]({FIGURE})",
    ]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help=f"folder to write refit-against-repair.md and {FIGURE} to")
    out = parser.parse_args().out
    with TemporaryDirectory() as temporary:
        answer = {name: compare(name, Path(temporary) / name) for name in MOTORS}
        drawn = figure((Path(temporary) / SHOWN / "report.html").read_text(encoding="utf-8"))
    if out:
        out.mkdir(parents=True, exist_ok=True)
        (out / "refit-against-repair.md").write_text(page(answer), encoding="utf-8")
        (out / FIGURE).write_text(drawn, encoding="utf-8")
    print(json.dumps(answer, indent=2))
