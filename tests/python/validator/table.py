"""Runs the checkers on every fault and writes the results into docs/validator.md: `python -m validator.table PROGRAM DIST`."""

import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from . import checkers, faults, foreign
from .archive import Files

PAGE = Path(__file__).resolve().parents[3] / "docs" / "validator.md"
BEGIN, END = "<!-- the table of seeded faults: written by tests/python/validator/table.py -->", "<!-- end of the table -->"
MODEL = "BrushedGearmotor"
OTHERS = (checkers.fmpy, checkers.fmutool)


def bases(dist, out):
    """The archives without a fault, by name."""
    ours = {name: Files.read(Path(dist) / f"fmi{fmi}" / f"{MODEL}.fmu") for fmi, name in faults.OURS.items()}
    return ours | {name: foreign.build(fmi, out) for fmi, name in faults.FOREIGN.items()}


def seed(fault, files, path):
    """Writes the archive with the fault."""
    files = files.copy()
    if fault.seed:
        files = foreign.seed(files, fault.seed)
    if fault.change:
        fault.change(files)
    return fault.write(files, path) if fault.write else files.write(path)


def judge(number, program, bases, out, others):
    """The results for one fault: exit code, findings, whether each of the other checkers finds anything."""
    fault = faults.ALL[number]
    path = seed(fault, bases[fault.base], Path(out) / f"fault-{number}.fmu")
    code, findings = checkers.ours(program, path)
    answers = code, findings, *(other(path) for other in others)
    path.unlink()
    return answers


def judge_all(program, dist, out, workers=2, others=OTHERS):
    """The results for all faults, in their order."""
    work = partial(judge, program=program, bases=bases(dist, out), out=out, others=others)
    with ProcessPoolExecutor(workers) as pool:
        return list(pool.map(work, range(len(faults.ALL))))


def text(answers):
    """The table in Markdown."""
    lines, number = [], 0
    counts = [0, 0, 0, 0]
    mark = {True: "yes", False: "-"}
    for title, group in faults.GROUPS:
        lines += ["", f"**{title}**", "", "| fault | FMU | code | motor-fmu | fmpy | fmutool |", "|---|---|---|---|---|---|"]
        for fault in group:
            _, findings, *others = answers[number]
            found = [any(f["code"] == fault.code for f in findings), *others]
            counts = [count + bool(hit) for count, hit in zip(counts, [*found, any(others)])]
            cells = " | ".join(mark[bool(hit)] for hit in found)
            lines.append(f"| {fault.what} | {fault.base} | `{fault.code}` | {cells} |")
            number += 1
    ours, fmpy, fmutool, others = counts
    total = (
        f"{number} faults: `motor-fmu validate` finds {ours}, `fmpy validate` {fmpy}, `fmutool -check` {fmutool}, "
        f"the last two together {others}."
    )
    return "\n".join([total, *lines]) + "\n"


def on_page(page=PAGE):
    """The table as the page has it."""
    return page.read_text(encoding="utf-8").split(BEGIN + "\n\n", 1)[1].split("\n" + END, 1)[0]


def main(program, dist):
    with tempfile.TemporaryDirectory() as out:
        table = text(judge_all(program, dist, out))
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN, 1)
    PAGE.write_text(f"{before}{BEGIN}\n\n{table}\n{END}{rest.split(END, 1)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
