"""Fitting the known parameters once more, against finding what the model lacks: which of the two still holds where nobody measured?

Two synthetic motors with a drag that the model has not, so that the truth is known. Their test runs are faster and hotter than
what is fitted. Run it with `motor-fmu` on the path; `--out FOLDER` also writes the answer as a page of Markdown with a figure.
"""

import argparse
import csv
import json
import re
import textwrap
from pathlib import Path
from tempfile import TemporaryDirectory

from clients.paths import ROOT
from clients.program import motor_fmu

SETS = ROOT / "tests" / "reference" / "bench-synthetic"
MOTORS = {"iron-loss": "an iron loss, ~ speed^0.5", "drag-power-075": "a drag of no list, ~ speed^0.75"}
ROLES = {"fit": "fitted runs", "validate": "deciding run", "test": "test run, outside the fitted range"}
STAGES = ("before", "refit", "after", "floor")
# The figure is of this motor's winding over its test run.
SHOWN, PLATE = "drag-power-075", "winding temperature, without the preset"
FIGURE = "refit-against-repair.svg"
# Standard deviations in half an interval of 95 %.
WITHIN_95 = 1.96


def figures(value: float, digits: int = 3) -> float:
    """A number to so many digits: more would be the arithmetic of one machine."""
    return float(f"{value:.{digits}g}")


def off(estimate: dict, true: float) -> dict:
    """How far a fitted number is from the truth: in percent of it, and in the deviations that the fit itself claims."""
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
    report = json.loads(motor_fmu("close-loop", str(SETS / name / "experiment.toml"), "--out", str(folder), "--json"))
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
    """What refit and repair leave of the winding's temperature over the test run, as report.html draws it."""
    test = report[report.index("(test)</summary>") :]
    drawn = re.search(rf'<svg [^>]*aria-label="{PLATE}".*?</svg>', test, re.DOTALL).group(0)
    return drawn.replace(PLATE, "winding temperature in the test run") + "\n"


def errors(answer: dict) -> str:
    """Winding errors as Markdown."""
    lines = ["| the winding's error, K | before | refit | after | noise |", "|---|---|---|---|---|"]
    for name, what in MOTORS.items():
        for role, words in ROLES.items():
            e = answer[name]["error"][role]["winding_temperature_degC"]
            lines.append(f"| {what}: {words} | " + " | ".join(f"{e[stage]:.2f}" for stage in STAGES) + " |")
    return "\n".join(lines)


def parameters(motor: dict) -> str:
    """Parameters as Markdown."""
    lines = ["| parameter | true | refit | is off by | repaired | is off by |", "|---|---|---|---|---|---|"]
    said = lambda p: f"{p['value']:g} | {p['percent_off']:+g} %, {abs(p['own_deviations_off']):g} of its deviations"  # noqa: E731
    for key, p in motor["parameters"].items():
        lines.append(f"| `{key}` | {p['true']:g} | {said(p['refit'])} | {said(p['after'])} |")
    return "\n".join(lines)


def page(answer: dict) -> str:
    """The answer with its numbers."""
    iron, other = answer["iron-loss"], answer[SHOWN]
    winding = {role: other["error"][role]["winding_temperature_degC"] for role in ROLES}
    friction, still = (other["parameters"][key]["refit"] for key in ("effect.coulomb_friction.tau_c", "conductance.G_still"))
    speed, heat = other["reached"]["speed_rad_per_s"], other["reached"]["winding_temperature_degC"]
    ironed = iron["error"]["test"]["winding_temperature_degC"]
    sizes = [abs(p["after"]["own_deviations_off"]) for motor in answer.values() for p in motor["parameters"].values()]
    intro = """Made by `examples/07_refit_against_repair.py`; the tests run it and compare this page. The two motors are synthetic (see
        `tests/reference/bench-synthetic/SOURCE.md`), so that the truth is known. Each has a drag that the model lacks. Refit: the
        model's own parameters fitted once more, as one does by hand. After: what `motor-fmu close-loop` makes of the same runs."""
    why = f"""On what it was fitted to, the refit looks like an answer: {winding["fit"]["refit"]:.2g} K instead of
        {winding["fit"]["before"]:.2g} K. It has no drag that grows with speed, so it makes the friction that it has
        {friction["percent_off"]:.0f} % too large, and the conductance to the room {still["percent_off"]:.0f} % too large to be rid of
        the heat. By its own reckoning those two are off by {friction["own_deviations_off"]:.0f} and
        {still["own_deviations_off"]:.0f} standard deviations: the interval of a fit tells how well the runs fix a number in a model
        that is true, and this one is not."""
    fails = f"""Such errors cancel in the runs that made them, and nowhere else: at a higher speed that friction is too small after
        all, and the conductance carries off what the motor in fact keeps. The fitted runs reach {speed["fitted"]:.0f} rad/s and
        {heat["fitted"]:.0f} °C, the test run {speed["tested"]:.0f} rad/s and {heat["tested"]:.0f} °C. There the refit is
        {winding["test"]["refit"]:.1f} K off, {winding["test"]["refit"] / winding["test"]["floor"]:.0f} times the noise, the repaired model
        {winding["test"]["after"]:.2g} K, which is the noise. With the iron loss it is {ironed["refit"]:.1f} K against
        {ironed["after"]:.2g} K. The repaired model holds because its parameters are the specimen's: none of the
        {len(sizes)} is further from the truth than {max(sizes):.1f} of its deviations."""
    fill = lambda paragraph: textwrap.fill(" ".join(paragraph.split()), 128)  # noqa: E731
    parts = [
        "# A refit against a repair",
        fill(intro),
        errors(answer),
        fill(why),
        parameters(other),
        fill(fails),
        f"![What refit and repair leave of the winding's temperature over the test run]({FIGURE})",
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
        (out / "refit-against-repair.md").write_text(page(answer), encoding="utf-8")
        (out / FIGURE).write_text(drawn, encoding="utf-8")
    print(json.dumps(answer, indent=2))
