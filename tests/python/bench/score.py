"""Evaluates the reports of a folder of sets and compares the rates with their criteria: `python -m bench.score SETS [--page FILE]`, in `tests/python`.

Exit code 1 if a criterion is not met. Wrong sets are listed by name, so that each can be generated and run again.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from . import judge as j
from .run import in_order, judged, report_of, why

GOALS = {j.LISTED: 1.05, j.UNLISTED: 1.5}  # of test error over floor
SECONDS, MEMORY = 5.0, 500.0  # goals of the median set, and in MB of the worst


@dataclass
class Rate:
    """A rate with its criterion."""

    what: str
    hits: int
    of: int
    least: float | None = None  # criterion, at least or at most; None: for information only
    most: float | None = None

    @property
    def share(self) -> float | None:
        return self.hits / self.of if self.of else None

    @property
    def met(self) -> bool:
        """A rate without a case is met."""
        if self.share is None:
            return True
        return (self.least is None or self.share >= self.least) and (self.most is None or self.share <= self.most)

    @property
    def bar(self) -> str:
        if self.least is None and self.most is None:
            return ""
        return f">= {self.least:.0%}" if self.most is None else f"<= {self.most:.0%}"

    @property
    def text(self) -> str:
        return "none tried" if self.share is None else f"{self.share:.1%} ({self.hits} of {self.of})"


def rates(sets: list) -> list:
    """Rates with a criterion; a set without a report counts as wrong."""
    named = [outcome for s in sets for outcome in s.named]
    with_effect = [s for s in sets if s.kind != j.NULL]
    nulls = [s for s in sets if s.kind == j.NULL]
    unlisted = [s for s in sets if s.port is not None]
    count = named.count
    return [
        Rate("correctly named, of detectable listed effects", count(j.RIGHT), len(named), least=0.95),
        Rate("wrong name, of sets with an effect", sum(s.outcome == j.WRONG_NAME for s in with_effect), len(with_effect), most=0.02),
        Rate("false alarms, of sets without an effect", sum(s.outcome == j.FALSE_ALARM for s in nulls), len(nulls), most=0.01),
        Rate("correct port, of detectable unlisted effects", sum(s.port for s in unlisted), len(unlisted), least=0.95),
        Rate("correct driver, of the same", sum(s.driver for s in unlisted), len(unlisted), least=0.8),
        interval_rate("true parameter values inside their 95 % interval", sets, least=0.9),
        Rate("sets without a report", sum(s.outcome == j.NO_REPORT for s in sets), len(sets), most=0.0),
    ]


def interval_rate(what: str, sets: list, least: float | None = None) -> Rate:
    return Rate(what, sum(s.inside for s in sets), sum(s.parameters for s in sets), least=least)


def further(sets: list) -> list:
    """Rates for information."""
    named = [outcome for s in sets for outcome in s.named]
    repaired = [s for s in sets if s.over_refit is not None]
    hidden = [s for s in sets if s.kind != j.NULL and not s.named and s.port is None]
    return [
        Rate("correctly named or in a class with the true effect", named.count(j.RIGHT) + named.count(j.CLASS_WITH), len(named)),
        Rate("in a class with the true effect", named.count(j.CLASS_WITH), len(named)),
        Rate("missed, of detectable listed effects", named.count(j.MISSED), len(named)),
        Rate("undetectable effects, of sets with an effect", len(hidden), sum(s.kind != j.NULL for s in sets)),
        interval_rate("parameters inside, sets without an effect", [s for s in sets if s.kind == j.NULL]),
        interval_rate("parameters inside, correct sets", [s for s in sets if s.outcome == j.RIGHT]),
        interval_rate("parameters inside, other sets", [s for s in sets if s.outcome not in (j.RIGHT, j.HIDDEN)]),
        Rate("larger test error than the refit", sum(s.over_refit > j.MARGIN for s in repaired), len(repaired)),
    ]


@dataclass
class Spread:
    """Median and largest value of a number of each set."""

    what: str
    values: list
    goal: float
    of_worst: bool = False  # the goal is for the worst one, not for the median

    @property
    def text(self) -> str:
        if not self.values:
            return "none"
        within = sum(v <= self.goal for v in self.values)
        return f"median {median(self.values):.3g}, worst {max(self.values):.3g}; {within} of {len(self.values)} within {self.goal:g}"


def spreads(sets: list) -> list:
    ratio = "test error after the repair / noise floor, worst channel"
    reported = [s for s in sets if s.over_floor is not None]
    by_kind = [Spread(f"{ratio}, {kind}", [s.over_floor for s in reported if s.kind == kind], goal) for kind, goal in GOALS.items()]
    null = Spread(f"{ratio}, {j.NULL}", [s.over_floor for s in reported if s.kind == j.NULL], GOALS[j.LISTED])
    seconds = Spread("seconds per set", [s.seconds for s in reported if s.seconds is not None], SECONDS)
    memory = Spread("memory, MB", [s.memory for s in reported if s.memory is not None], MEMORY, of_worst=True)
    return [*by_kind, null, seconds, memory]


def sentence_of(folder: Path, one) -> str:
    """What is wrong with a set."""
    return f"{one.sentence} ({why(folder)})" if report_of(folder) is None else one.sentence


def main(arguments=None) -> int:
    from .page import write_page  # which needs the counts of this file

    parser = argparse.ArgumentParser(prog="python -m bench.score", description="Evaluates the reports of sets and compares the rates with their criteria.")
    parser.add_argument("sets", type=Path)
    parser.add_argument("--count", type=int, help="the first sets only")
    parser.add_argument("--page", type=Path, help="write the table there, with a figure beside it")
    parser.add_argument("--command", default="", help="command that generates the page, for the page")
    options = parser.parse_args(arguments)
    asked = [folder for folder in in_order(options.sets)[: options.count] if (folder / "result" / "run.json").exists()]
    if not asked:
        sys.exit(f"{options.sets} has no set with a report")
    sets = [judged(folder) for folder in asked]
    wrong = [sentence_of(folder, one) for folder, one in zip(asked, sets) if one.outcome not in j.FINE]
    for sentence in wrong:
        print(sentence)
    every = rates(sets)
    for rate in [*every, *further(sets)]:
        mark = "" if not rate.bar else "   met" if rate.met else "   NOT MET"
        print(f"{rate.what}: {rate.text}{f', criterion {rate.bar}' if rate.bar else ''}{mark}")
    for spread in spreads(sets):
        print(f"{spread.what}: {spread.text}")
    if options.page:
        write_page(options.page, sets, wrong, options.command)
    missed = [rate.what for rate in every if not rate.met]
    if missed:
        print(f"not met: {'; '.join(missed)}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
