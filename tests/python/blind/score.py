"""Rates with binomial intervals, compared with the criteria: `python -m blind.score SETS [--tables DIR --page FILE]`,
in `tests/python`.

A rate meets its criterion if it is on the right side of the limit and its 95 % interval (Clopper and Pearson,
Biometrika 26, 1934) does not cross the bound. Exit code 1 if a criterion is not met. With `--tables` the table of this seed is stored beside those of all seeds before, and the page is made of all of
them.
"""

import argparse
import json
import sys
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
from scipy.stats import beta

from . import judge as j
from .run import BUDGET, in_order, judged

LEVEL = 0.95
MARGIN = 1.02  # of the refit's error: above it a repair is worse
SHOWN, OPEN, MISSED = "met", "not decided", "**missed**"


@dataclass
class Rate:
    """A rate with its criterion: at least or at most `bar`, and the bound that its interval must keep."""

    what: str
    hits: int
    of: int
    least: float | None = None
    most: float | None = None
    bound: float | None = None

    @property
    def interval(self) -> tuple:
        a = (1.0 - LEVEL) / 2.0
        low = beta.ppf(a, self.hits, self.of - self.hits + 1) if self.hits else 0.0
        high = beta.ppf(1.0 - a, self.hits + 1, self.of - self.hits) if self.hits < self.of else 1.0
        return float(low), float(high)

    @property
    def verdict(self) -> str:
        """Met, missed, or not decided by so few sets."""
        if self.least is None and self.most is None:
            return ""
        if not self.of:
            return OPEN
        low, high = self.interval
        share = self.hits / self.of
        if self.least is not None:
            bound = self.least if self.bound is None else self.bound
            return SHOWN if share >= self.least and low >= bound else MISSED if high < self.least else OPEN
        bound = self.most if self.bound is None else self.bound
        return SHOWN if share <= self.most and high <= bound else MISSED if low > self.most else OPEN

    @property
    def bar(self) -> str:
        side = (
            f">= {self.least:.0%}" if self.least is not None else f"<= {self.most:.0%}" if self.most is not None else ""
        )
        which = "lower" if self.least is not None else "upper"
        return f"{side}, {which} bound {self.bound:.0%}" if side and self.bound is not None else side

    @property
    def text(self) -> str:
        if not self.of:
            return "no set"
        low, high = self.interval
        return f"{self.hits / self.of:.1%} ({self.hits} of {self.of}; {low:.1%} to {high:.1%})"


@dataclass
class Number:
    """A quantile of a number of each set with its limit."""

    what: str
    values: list
    quantile: float
    most: float | None = None

    @property
    def value(self) -> float | None:
        return float(np.quantile(self.values, self.quantile)) if self.values else None

    @property
    def verdict(self) -> str:
        if self.most is None:
            return ""
        return OPEN if self.value is None else SHOWN if self.value <= self.most else MISSED

    @property
    def bar(self) -> str:
        return "" if self.most is None else f"<= {self.most:g}"

    @property
    def text(self) -> str:
        return "no set" if self.value is None else f"{self.value:.3g} ({len(self.values)} sets)"


@dataclass
class Coverage(Rate):
    """Of 95 % intervals: between 92 and 98 %."""

    def __init__(self, what, hits, of, judged_by_bar=True):
        super().__init__(what, hits, of)
        self.judged_by_bar = judged_by_bar

    @property
    def verdict(self) -> str:
        if not self.judged_by_bar:
            return ""
        if not self.of:
            return OPEN
        low, high = self.interval
        return SHOWN if 0.92 <= self.hits / self.of <= 0.98 else OPEN if high >= 0.92 and low <= 0.98 else MISSED

    @property
    def bar(self) -> str:
        return "92 to 98 %" if self.judged_by_bar else ""


def count(sets, *outcomes) -> int:
    return sum(s.outcome in outcomes for s in sets)


def criteria(sets: list) -> list:
    """What the suite demands; a set without a report counts as wrong."""
    nulls = [s for s in sets if s.kind == j.NULL]
    listed = [s for s in sets if s.kind == j.LISTED]
    visible = [s for s in listed if s.detectable]
    random = [s for s in sets if s.kind in j.RANDOM]
    seen = [s for s in random if s.port is not None]
    mistakes = [s for s in sets if s.kind == j.MISTAKE]
    after = lambda group: [s.over_floor["after"] for s in group if "after" in s.over_floor]  # noqa: E731
    repaired = [s for s in sets if s.over_refit is not None]
    plain = [s for s in seen if s.kind != "hidden"]
    hidden = [s for s in seen if s.kind == "hidden"]
    compared = sorted({s.compared for s in sets})
    return [
        Rate("listed effects named, of visible ones", count(visible, j.RIGHT), len(visible), least=0.95, bound=0.90),
        Rate(
            "wrong names, of sets with an effect",
            count([*listed, *random], j.WRONG_NAME),
            len(listed) + len(random),
            most=0.02,
            bound=0.04,
        ),
        Rate("false alarms, of sets without an effect", count(nulls, j.FALSE_ALARM), len(nulls), most=0.02, bound=0.04),
        Rate("random laws and hidden states: correct port, of visible ones", sum(s.port for s in seen), len(seen), least=0.90),
        Rate("random laws and hidden states: correct driver, of visible ones", sum(s.driver for s in seen), len(seen), least=0.80),
        Number("visible random laws without hidden states: test error after the repair / floor, median", after(plain), 0.5, 1.3),
        Number("visible random laws without hidden states: test error after the repair / floor, 90th percentile", after(plain), 0.9, 3.0),
        Number("hidden states: test error after the repair / floor, median", after(hidden), 0.5, 1.5),
        Rate(
            "test error larger than the refit's by more than 2 %",
            sum(s.over_refit > MARGIN for s in repaired),
            len(repaired),
            most=0.0,
            bound=0.04,
        ),
        Coverage(
            f"true parameters ({' or '.join(compared)}) inside their 95 % interval",
            sum(s.inside for s in sets),
            sum(s.parameters for s in sets),
        ),
        Rate("mistakes in the data handled", count(mistakes, j.RIGHT), len(mistakes), least=0.95, bound=0.90),
        Rate(
            "mistakes in the data reported as an effect", count(mistakes, j.TRACED), len(mistakes), most=0.02, bound=0.04
        ),
        Rate(
            "good data refused, or no report",
            count(sets, j.REFUSED_GOOD, j.NO_REPORT),
            len(sets),
            most=0.02,
            bound=0.04,
        ),
        Rate(
            "wall time above the budget",
            sum((s.seconds or 0.0) > (s.budget or BUDGET) for s in sets),
            len(sets),
            most=0.0,
            bound=0.04,
        ),
        Number("seconds of CPU, median", [s.cpu for s in sets if s.cpu is not None], 0.5, 5.0),
        Number("seconds of CPU, 95th percentile", [s.cpu for s in sets if s.cpu is not None], 0.95, 30.0),
        Number("peak memory in MB, largest", [s.memory for s in sets if s.memory is not None], 1.0, 500.0),
    ]


def information(sets: list) -> list:
    """Rates and numbers without a criterion."""
    groups = {kind: [s for s in sets if s.kind == kind] for kind in (j.NULL, j.LISTED, *j.RANDOM)}
    visible = [s for s in groups[j.LISTED] if s.detectable]
    rows = [
        Rate(
            "listed effects named or in a class with the true one", count(visible, j.RIGHT, j.CLASS_WITH), len(visible)
        ),
        Rate(
            "sets without an effect: reports with an effect or law, real differences (column 'real difference') included",
            sum(s.said != "nothing" for s in groups[j.NULL]),
            len(groups[j.NULL]),
        ),
        Coverage(
            "true parameters (best two-node model) inside their 95 % interval, all sets",
            sum(s.effective_inside for s in sets),
            sum(s.effective_parameters for s in sets),
            False,
        ),
        Rate(
            "test error of a channel larger than the refit's by more than 2 %",
            sum(s.over_refit_worst > MARGIN for s in sets if s.over_refit_worst is not None),
            sum(s.over_refit_worst is not None for s in sets),
        ),
    ]
    for low, high in ((0.0, 0.3), (0.3, 2.0), (2.0, 99.0)):
        some = [s for s in sets if low <= s.structure < high and s.kind not in (j.MISTAKE,)]
        rows.append(
            Rate(
                f"no wrong or missing result, structure error {low:g} to {high:g} sigma"
                if high < 99
                else f"no wrong or missing result, structure error above {low:g} sigma",
                count(some, *j.FINE),
                len(some),
            )
        )
    for kind, group in groups.items():
        for model in j.MODELS:
            values = [s.over_floor[model] for s in group if model in s.over_floor]
            if values:
                rows += [
                    Number(f"{kind}: test error {model} / floor, {name}", values, q)
                    for name, q in (("median", 0.5), ("90th percentile", 0.9))
                ]
        both = [s.over_model["after"] for s in group if "after" in s.over_model]
        rows.append(Number(f"{kind}: test error after / floor with structure error, median", both, 0.5))
    return rows


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m blind.score", description="Rates of a folder of reports, with intervals, against the criteria."
    )
    parser.add_argument("sets", type=Path)
    parser.add_argument("--count", type=int, help="the first sets only")
    parser.add_argument("--tables", type=Path, help="folder with the tables of all seeds; that of this seed is added")
    parser.add_argument("--page", type=Path, help="write the page of all tables there")
    parser.add_argument("--command", default="", help="command that generates the table, for the page")
    options = parser.parse_args(arguments)
    asked = [folder for folder in in_order(options.sets)[: options.count] if (folder / "result" / "run.json").exists()]
    if not asked:
        sys.exit(f"{options.sets} has no set with a report")
    sets = [judged(folder) for folder in asked]
    for s in sets:
        if s.outcome not in j.FINE:
            print(s.sentence)
    every = criteria(sets)
    for rate in [*every, *information(sets)]:
        print(f"{rate.what}: {rate.text}{f', criterion {rate.bar}: {rate.verdict}' if rate.bar else ''}")
    if options.tables:
        options.tables.mkdir(parents=True, exist_ok=True)
        table = {
            "seed": asked[0].name.split("-")[1],
            "date": datetime.now().strftime("%Y-%m-%d %H:%M"),  # two tables of a day have an order
            "command": options.command,
            "sets": [asdict(s) for s in sets],
        }
        file = options.tables / f"{table['seed']}.json"
        file.write_text(json.dumps(table, indent=0, ensure_ascii=False) + "\n", encoding="utf-8")
    if options.tables and options.page:
        from .page import write_page

        write_page(options.page, options.tables)
    failed = [rate.what for rate in every if rate.verdict not in ("", SHOWN)]
    if failed:
        print(f"not met: {'; '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
