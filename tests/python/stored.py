"""How far a run may be from an output that is stored. Every tolerance is declared here.

Stored numbers are no truth: they show that an example still runs and still says about the same. Independent truths are in
`example_truths.py` and in the tests of the single features. A tolerance is what the physics behind the number justifies.
"""

import re
from dataclasses import dataclass

import pytest


@dataclass(frozen=True)
class Tolerance:
    """For quantities whose path matches: keys from the outside in, joined by ": "."""

    pattern: str
    relative: float
    absolute: float
    reason: str


# The first that matches applies.
TOLERANCES = (
    Tolerance(r"order: ", 0.0, 0.3, "an order is the slope of errors that differ by rounding and by steps that are rejected"),
    Tolerance(r"error|residual|floor|refit|before|after|blackbox", 0.2, 1e-3, "a residual is the small difference of large numbers"),
    Tolerance(r"_degC$|_K$|temperature", 0.0, 0.1, "0.1 K is what a calibrated thermocouple resolves"),
    Tolerance(r"percent", 0.0, 1.0, "one percentage point of a ratio whose parts have 1 %"),
    Tolerance(r"", 0.01, 1e-6, "1 % is below the uncertainty of any parameter of a motor"),
)
# An interval is as good as its width.
INTERVAL_SHARE = 0.15
# A chart may move by two pixels.
CHART = Tolerance(r"", 0.01, 2.0, "two pixels")
# A page shows rounded numbers: 1 %, or one in the last digit.
PAGE = 0.01

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def tolerance(path):
    """The tolerance of a quantity."""
    return next(t for t in TOLERANCES if re.search(t.pattern, path))


def same(found, expected, where=""):
    """Equal up to the tolerance of each quantity, whatever the nesting."""
    if isinstance(expected, (int, float)) and not isinstance(expected, bool):
        assert isinstance(found, (int, float)) and not isinstance(found, bool), f"{where}: {found!r}, stored {expected!r}"
        allowed = tolerance(where)
        assert found == pytest.approx(expected, rel=allowed.relative, abs=allowed.absolute), f"{where} ({allowed.reason})"
        return
    assert type(found) is type(expected), f"{where}: {found!r}, stored {expected!r}"
    if isinstance(expected, dict):
        assert list(found) == list(expected), where
        for key in expected:
            same(found[key], expected[key], f"{where}: {key}" if where else key)
    elif isinstance(expected, list):
        assert len(found) == len(expected), where
        if where.endswith("ci95"):
            width = INTERVAL_SHARE * abs(expected[1] - expected[0])
            assert found == pytest.approx(expected, rel=0, abs=width), where
            return
        for k, (a, b) in enumerate(zip(found, expected)):
            same(a, b, f"{where}: {k}")
    else:
        assert found == expected, where


def same_page(found, expected, name):
    """Equal text; numbers equal up to their tolerance."""
    assert NUMBER.sub("#", found) == NUMBER.sub("#", expected), f"the text of {name} is stale"
    for a, b in zip(NUMBER.findall(found), NUMBER.findall(expected)):
        if name.endswith(".svg"):
            relative, absolute = CHART.relative, CHART.absolute
        else:
            digits = len(b.partition(".")[2].partition("e")[0])
            relative, absolute = PAGE, 1.01 * 10.0**-digits
        assert float(a) == pytest.approx(float(b), rel=relative, abs=absolute), f"{name}: {a}, stored {b}"
