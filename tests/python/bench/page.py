"""The page of the blind suite: rates, the confusion table, what was wrong; and the table as a figure of said against truth."""

from collections import Counter
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from . import judge as j
from .score import further, rates, spreads

CELL = 0.25  # inch
DARK, LIGHT, NONE = (20, 80, 140), (238, 244, 250), (247, 247, 247)
WRONG = (190, 60, 40)
STYLE = {"font.size": 8, "svg.fonttype": "none", "svg.hashsalt": "motor-fmu"}  # the same sets give the same bytes
KIND_ORDER = (j.NULL, j.LISTED, j.UNLISTED)

HEAD = """# The blind suite

{count} synthetic sets with a known answer, which `motor-fmu close-loop` is asked about one by one; made by `{command}`.
The sets are drawn by [`tests/python/bench`](../tests/python/bench), which has equations of its own: motors of several sizes, driven by
current, voltage or power, two to five runs, uneven clocks, flawed sensors. A fifth lacks nothing, half has an effect that is in no list.
An effect *can be seen* when the best change of all declared parameters leaves a change of a fifth of the noise or more in some channel
of the runs to fit, and a chi-square of 40. Where it cannot, silence is right and only a wrong name is wrong.
"""
NOTES = """Intervals are counted over all sets, also where an effect was missed, or cannot be seen and bends the parameters. Errors are
those of the worst channel with a living sensor, over the floor of the true model driven by the same measured inputs.
Worse than the refit: more than {margin:.0%} above it, all channels together. Seconds are of the whole program, the FMUs included.

## Confusion table
"""
AGAIN = """A set is made again by its name, `bench-SEED-NUMBER`, in `tests/python`:
`python -m bench.make --seed SEED --first NUMBER --out DIR`.
"""


def table(head, rows) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def in_rows(sets) -> dict:
    """Sets by kind and truth, null first, then what is listed, then what is in no list."""
    by: dict = {}
    for s in sorted(sets, key=lambda s: (KIND_ORDER.index(s.kind), s.truth)):
        by.setdefault((s.kind, s.truth), []).append(s)
    return by


def confusion(sets) -> str:
    """Rows: the truth. Columns: how what was said of it compares, as far as it happened, and what was said where it was not right."""
    used = [outcome for outcome in j.OUTCOMES if any(s.outcome == outcome for s in sets)]
    rows = []
    for (kind, truth), group in in_rows(sets).items():
        counts = Counter(s.outcome for s in group)
        other = Counter(s.said for s in group if s.outcome != j.RIGHT and s.said != "no report")
        said = "; ".join(f"{text} ({n})" if n > 1 else text for text, n in other.most_common())
        rows.append([truth, kind, len(group), *(counts[outcome] or "" for outcome in used), said])
    total = Counter(s.outcome for s in sets)
    rows.append(["**all**", "", len(sets), *(total[outcome] for outcome in used), ""])
    return table(["truth", "kind", "sets", *used, "said where not right"], rows)


def shade(fraction: float, fine: bool) -> tuple:
    """Light for few, dark for many; red where it is wrong."""
    end = DARK if fine else WRONG
    return tuple(round(a + (b - a) * fraction) for a, b in zip(LIGHT, end))


def cells(sets):
    """Rows, columns, and (count, colour) of each cell: every truth against every answer, shaded by its fraction of the row."""
    columns = sorted({s.said for s in sets}, key=lambda text: (text != "nothing", " by " in text, text))
    rows, grid = [], []
    for (_, truth), group in in_rows(sets).items():
        rows.append(f"{truth} ({len(group)})")
        answers = [[s for s in group if s.said == said] for said in columns]
        fine = [all(s.outcome in j.FINE for s in cell) for cell in answers]
        grid.append([(len(c), shade(len(c) / len(group), f) if c else NONE) for c, f in zip(answers, fine)])
    return rows, columns, grid


def figure(sets, file: Path):
    """The cells as a figure."""
    rows, columns, grid = cells(sets)
    with matplotlib.rc_context(STYLE):
        canvas = Figure(figsize=(CELL * len(columns), CELL * len(rows)))
        axes = canvas.add_axes((0, 0, 1, 1))
        axes.imshow([[colour for _, colour in row] for row in grid], aspect="auto")
        axes.set_xticks(range(len(columns)), columns, rotation=60, ha="left", rotation_mode="anchor")
        axes.set_yticks(range(len(rows)), rows)
        axes.tick_params(top=True, bottom=False, left=False, labeltop=True, labelbottom=False, length=0)
        for y, row in enumerate(grid):
            for x, (count, _) in enumerate(row):
                if count:
                    light = count <= 0.5 * sum(n for n, _ in row)
                    axes.text(x, y, count, ha="center", va="center", color="black" if light else "white")
        for spine in axes.spines.values():
            spine.set_visible(False)
        canvas.savefig(file, bbox_inches="tight", metadata={"Date": None})


def page(sets, wrong, command: str, picture: str) -> str:
    """The text of the page."""
    bars = [[r.what, r.text, r.bar, "met" if r.met else "**missed**"] for r in rates(sets)]
    made = f"made by `{command}`" if command else "made by `bench.score`"
    information = [[r.what, r.text] for r in further(sets)] + [[spread.what, spread.text] for spread in spreads(sets)]
    parts = [
        HEAD.format(count=len(sets), command=command or "python -m bench.score"),
        table(["rate", "found", "bar", ""], bars),
        table(["for information", "found"], information),
        NOTES.format(margin=j.MARGIN - 1.0),
        confusion(sets),
        f"![What was said against what is true]({picture})\n",
        "## What was wrong\n",
        "\n".join(f"- {sentence}" for sentence in wrong) + "\n" if wrong else "Nothing.\n",
        AGAIN,
    ]
    return "\n".join(parts)


def write_page(file: Path, sets, wrong, command: str = ""):
    """The page and its figure beside it."""
    picture = file.with_suffix(".svg")
    figure(sets, picture)
    file.write_text(page(sets, wrong, command, picture.name), encoding="utf-8")
