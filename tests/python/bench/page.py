"""The page of the blind suite: rates, the confusion table, what was wrong; and the table as a figure of said against truth."""

from collections import Counter
from html import escape
from math import cos, radians, sin
from pathlib import Path

from . import judge as j
from .score import further, rates, spreads

CELL, MARGIN, LETTER = 22, 12, 6.6  # px; the width of a letter, generously
TILT = 60  # degrees
DARK, LIGHT = (20, 80, 140), (238, 244, 250)
WRONG = (190, 60, 40)
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


def shade(share: float, fine: bool) -> str:
    """Light for few, dark for many; red where it is wrong."""
    end = DARK if fine else WRONG
    return "#" + "".join(f"{round(a + (b - a) * share):02x}" for a, b in zip(LIGHT, end))


def figure(sets) -> str:
    """Every truth against everything that was said, shaded by its share of the row."""
    rows = in_rows(sets)
    columns = sorted({s.said for s in sets}, key=lambda text: (text != "nothing", " by " in text, text))
    # Room for the longest words, and at the right for what the tilted ones reach beyond their columns.
    left = MARGIN + LETTER * max(len(truth) + 5 for _, truth in rows)
    top = MARGIN + LETTER * max(map(len, columns)) * sin(radians(TILT))
    reach = max(CELL * (k + 1) + LETTER * len(said) * cos(radians(TILT)) for k, said in enumerate(columns))
    left, top, width = round(left), round(top), round(left + max(CELL * len(columns), reach) + MARGIN)
    height = top + CELL * len(rows) + MARGIN
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    parts = [head, ' font-family="sans-serif" font-size="11">\n<rect width="100%" height="100%" fill="white"/>\n']
    for k, said in enumerate(columns):
        x, y = left + CELL * k + 15, top - 6
        parts.append(f'<text transform="translate({x} {y}) rotate(-{TILT})">{escape(said)}</text>\n')
    for k, ((_, truth), group) in enumerate(rows.items()):
        y = top + CELL * k
        parts.append(f'<text x="{left - 6}" y="{y + 15}" text-anchor="end">{escape(truth)} ({len(group)})</text>\n')
        for m, said in enumerate(columns):
            cell = [s for s in group if s.said == said]
            fine = all(s.outcome in j.FINE for s in cell)
            fill = shade(len(cell) / len(group), fine) if cell else "#f7f7f7"
            parts.append(f'<rect x="{left + CELL * m}" y="{y}" width="{CELL - 1}" height="{CELL - 1}" fill="{fill}"/>\n')
            if cell:
                colour = "white" if len(cell) > 0.5 * len(group) else "black"
                place = f'x="{left + CELL * m + 10}" y="{y + 15}" text-anchor="middle"'
                parts.append(f'<text {place} fill="{colour}">{len(cell)}</text>\n')
    return "".join(parts) + "</svg>\n"


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
    picture.write_text(figure(sets), encoding="utf-8")
    file.write_text(page(sets, wrong, command, picture.name), encoding="utf-8")
