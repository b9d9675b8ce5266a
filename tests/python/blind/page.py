"""The page of the blind suite: a table for each seed that was ever run, made from the stored results."""

import json
from collections import Counter
from pathlib import Path

from . import judge as j
from .run import BUDGET
from .score import criteria, information

HEAD = """# The blind suite

`{command}` generates this page. It computes the newest table; the tables of earlier seeds are made from
their stored results in `tests/reference/blind-suite`.

`motor-fmu close-loop` evaluates synthetic experiments (sets) whose true effects are known. The generator in
[`tests/python/blind`](../tests/python/blind) was written from the documentation of the command, without knowledge of its source code. Its
motor has seven thermal nodes (slot and end winding, stator core, housing front and back, rotor, and the node that the effect `stator_node`
adds), convection that depends on temperature, friction that decreases with temperature, and temperature sensors that lag, are mounted at a
warmer or colder place, or were moved between runs. The model of `motor-fmu` has two nodes. The *structure error* of a set is the deviation
that remains between the noise-free motor and this model after a refit of the declared parameters to the fit runs. It is divided by the
standard deviation of the noise; the value of the channel and role (fit or test) where it is largest is stated. Each set has another motor,
other noise with drift (inputs too), priors that are sometimes wrong, and runs that sometimes start warm.

The true value of a parameter is its value in the *best two-node model*. This is the two-node model that describes the
specimen's noise-free response in the fit runs best: a nonlinear least-squares fit, weighted with the noise, without the
priors. Without structure error it is the specimen. With structure error its parameters can differ from the specimen's:
a winding whose end turns release little heat responds like a two-node motor with a larger `R_wh`. The criterion compares
the 95 % intervals with these values, in sets with a structure error of at most {low:g} standard deviations and without
a wrong prior. Parameters of listed effects are compared with those of the set. Tables with "(specimen)" compare with
the parameters of the specimen; there, best two-node model and structure error come from one linear least-squares step.

| kind of set | true effect |
| --- | --- |
| null | none; a quarter of these sets have no structure error, the others about 0.3 to 5 standard deviations |
| listed | one of the [effects](glossary.md#effects) that `motor-fmu` knows |
| function | a smooth random function of a random driver at a random port |
| product | a product of two random functions of two drivers |
| hidden | a random function of a driver behind a first-order lag of 1 to 15 minutes |
| mistake | an ordinary mistake in the data (unit, sign, exchanged columns, defective sensor, time) |

An effect is *visible* if it changes a channel of the fit runs by at least noise and structure error together, after a linear refit of the
declared parameters. The *floor* is the error of the true model with the measured inputs. Test errors are those of the channel with the largest ratio to
its floor. A report that names a real difference between the two models (for example a second heat capacity) is not counted as a false alarm
(column "{real}"). In sets with a mistake, such a report is correct if it also recognises the mistake.
In sets with an effect, "{wrong}" is a report of an effect that the set does not have and that is no real difference; "{missed}" is a report
without the true effect, with nothing or only real differences. Column "{below}": the effect is not visible and nothing
wrong was reported. If it was reported correctly nevertheless, the set is in column "{right}". Column "{law}":
a law was reported in place of the listed effect, or in addition to it at a port where no real difference acts. Column "{elsewhere}":
verdict `unusable` with another channel than the one with the mistake. Column "{unnoticed}": neither the verdict nor a note names
the mistake, and no effect is reported. Column "{refused}": verdict `unusable` or exit code 2 although the data can be used. Column "{silent}":
the command wrote no report.
A driver counts as correct if its best function explains 98 % of the law over the fit runs.

A rate meets its criterion if it is on the right side of the limit and its 95 % interval (Clopper and Pearson) does not cross the stated bound
(without one: the limit). It misses the criterion if the whole interval is on the wrong side of the limit; otherwise it is not decided. The
criterion "92 to 98 %" is met by a rate within these limits and missed if the whole interval is outside. Medians and percentiles are compared
with the limit.

In the lists of sets, "port by driver" is a law, "behind 85 s" a first-order lag of its driver with this time constant, "history" a law with
memory ([glossary](glossary.md#closed-loop-and-statistics)). "A + B": both together; "A or B": verdict `class`. Test errors are divided by
the floor. The text after "reported" is quoted from the report, in the wording of the program at that time.
"""
AGAIN = """To generate a set again, in `tests/python`: `python -m blind.make --seed SEED --first NUMBER --out DIR`.
"""


def table(head, rows) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "/") for cell in line) + " |" for line in lines) + "\n"


def outcomes(sets) -> str:
    used = [o for o in j.OUTCOMES if any(s.outcome == o for s in sets)]
    rows = []
    for kind in (j.NULL, j.LISTED, *j.RANDOM, j.MISTAKE):
        group = [s for s in sets if s.kind == kind]
        counts = Counter(s.outcome for s in group)
        if group:
            rows.append([kind, len(group), *(counts[o] or "" for o in used)])
    return table(["kind", "sets", *(j.title(o) for o in used)], rows)


def section(stored: dict, newest: bool) -> str:
    """One seed: criteria, outcomes by kind, and the sets with a wrong or missing result."""
    sets = [j.Judged(**s) for s in stored["sets"]]
    budget = max((one.budget or BUDGET for one in sets), default=BUDGET)
    allowed = (
        f" Each set had {budget:g} s of wall time instead of {BUDGET:g} s (a machine in use)."
        if budget != BUDGET
        else ""
    )
    command = f"; `{stored['command']}`" if stored["command"] else ""
    parts = [f"## Seed {stored['seed']} ({stored['date']})\n", f"{len(sets)} sets{command}.{allowed}\n"]
    parts.append(
        table(["quantity", "result", "criterion", ""], [[r.what, r.text, r.bar, r.verdict] for r in criteria(sets)])
    )
    parts.append(outcomes(sets))
    if newest:
        parts.append(table(["for information", "result"], [[r.what, r.text] for r in information(sets)]))
    wrong = [f"- {s.sentence}" for s in sets if s.outcome not in j.FINE]
    parts.append("Sets with a wrong or missing result:\n\n" + "\n".join(wrong) + "\n" if wrong else "No set has a wrong or missing result.\n")
    return "\n".join(parts)


def page(tables: list) -> str:
    """Newest first."""
    order = sorted(tables, key=lambda t: (t["date"], t["seed"]), reverse=True)
    columns = {"real": j.title(j.STRUCTURE), "below": j.title(j.BELOW), "right": j.title(j.RIGHT)}
    columns |= {"wrong": j.title(j.WRONG_NAME), "missed": j.title(j.MISSED), "law": j.title(j.UNEXPLAINED)}
    columns |= {"elsewhere": j.title(j.OTHER_CHANNEL), "unnoticed": j.title(j.UNNOTICED)}
    columns |= {"refused": j.title(j.REFUSED_GOOD), "silent": j.title(j.NO_REPORT)}
    parts = [HEAD.format(command=order[0]["command"] or "python -m blind.score", low=j.LOW, **columns)]
    return "\n".join([*parts, *(section(t, t is order[0]) for t in order), AGAIN])


def write_page(file: Path, folder: Path):
    tables = [json.loads(f.read_text(encoding="utf-8")) for f in sorted(folder.glob("*.json"))]
    file.write_text(page(tables), encoding="utf-8")
