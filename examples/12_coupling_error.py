"""Coupling error of co-simulated FMUs over the step, relative to one integration of the joined equations.

`motor-fmu cosim` simulates the powered ankle as three FMUs at steps from 0.125 to 1 ms: with Jacobi and Gauss-Seidel, each with constant
inputs and with input derivatives. The reference is one integration of the joined equations (`tests/reference/coupled-ankle`). Constant inputs give
an error of first order in the step, because each FMU uses values of the others that are one step old. Input derivatives give second order.
`--out FOLDER` also writes the figure.
"""

import argparse
import csv
import json
import math
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

from clients.paths import EXAMPLES, ROOT, dist
from clients.program import motor_fmu

SYSTEM = EXAMPLES / "systems" / "actuator-gait.toml"
SOLUTION = ROOT / "tests" / "reference" / "coupled-ankle" / "joined.csv"
FIGURE = "coupling-error.svg"
STEPS = (1e-3, 5e-4, 2.5e-4, 1.25e-4)
# The joined equations are those of the default start values: no friction of the preset, no compensation for it, and no fan.
DECLARED = [
    part
    for value in ("motor.effect.coulomb_friction.tau_c=0", "actuator.control.tau_c=0", "motor.fan_command=0")
    for part in ("--set", value)
]
MASTERS = {
    "jacobi, constant inputs": ("--algorithm", "jacobi", "--no-input-derivatives"),
    "jacobi, input derivatives": ("--algorithm", "jacobi"),
    "gauss-seidel, constant inputs": ("--algorithm", "gauss-seidel", "--no-input-derivatives"),
    "gauss-seidel, input derivatives": ("--algorithm", "gauss-seidel"),
}


def table(path: Path) -> list[dict]:
    with path.open(newline="") as file:
        return [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]


def errors() -> dict:
    """Rms error of each compared quantity over the instants of the solution, relative to its range, by master and step.

    Rms and not the largest: dry friction reverses within a step of one instant, and that error depends on the phase of the step.
    """
    solution = table(SOLUTION)
    names = [name for name in solution[0] if name != "time"]
    size = {name: max(row[name] for row in solution) - min(row[name] for row in solution) for name in names}
    found = {}
    with TemporaryDirectory() as folder:
        system, out = Path(folder) / "ankle.toml", Path(folder) / "out.csv"
        system.write_text(SYSTEM.read_text().replace("../../dist", dist().resolve().as_posix()))
        for master, options in MASTERS.items():
            found[master] = []
            for step in STEPS:
                arguments = ("--stop", str(solution[-1]["time"]), "--step", repr(step), "--output", str(out))
                motor_fmu("cosim", str(system), *DECLARED, *options, *arguments)
                rows = {round(row["time"], 9): row for row in table(out)}
                off = {name: math.sqrt(fmean((rows[round(s["time"], 9)][name] - s[name]) ** 2 for s in solution)) / size[name] for name in names}
                found[master].append({"step_s": step} | off)
    return found


def orders(found: dict) -> dict:
    """The exponent of the step in the error, from half a millisecond to the smallest step."""
    order = lambda coarse, fine: math.log2(coarse / fine) / 2.0  # noqa: E731
    ends = {master: (rows[1], rows[3]) for master, rows in found.items()}
    return {m: {n: round(order(a[n], b[n]), 2) for n in a if n != "step_s"} for m, (a, b) in ends.items()}


def figure(found: dict, path: Path):
    """Error over step, one panel for each quantity."""
    from clients.figure import CURVES, STYLE, WIDTH, plt, words

    names = [name for name in next(iter(found.values()))[0] if name != "step_s"]
    with plt.rc_context(STYLE):
        canvas, panels = plt.subplots(len(names), 1, figsize=(WIDTH, 2.2 * len(names) + 1.0), layout="constrained", sharex=True)
        for panel, name in zip(panels, names):
            for color, (master, rows) in zip(CURVES, found.items()):
                panel.loglog([1e3 * r["step_s"] for r in rows], [r[name] for r in rows], "o-", ms=4, color=color, label=master)
            panel.set(title=words(name), ylabel="rms error / range")
            panel.set_xticks([1e3 * step for step in STEPS], [f"{1e3 * step:g}" for step in STEPS])
            panel.minorticks_off()
        panels[-1].set_xlabel("communication step in ms")
        canvas.legend(*panels[-1].get_legend_handles_labels(), loc="outside lower left", ncols=2)
        canvas.savefig(path, metadata={"Date": None})
        plt.close(canvas)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help=f"folder to write {FIGURE} to")
    out = parser.parse_args().out
    found = errors()
    if out:
        figure(found, out / FIGURE)
    print(json.dumps({"order": orders(found), "error": found}, indent=2))
