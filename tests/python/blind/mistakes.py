"""Ordinary mistakes of data: each spoils the readings or the files of a set, and says which answers are correct.

Answers: `unusable` (verdict, with one of `channels`), `set aside` (a note that says so and names one of `channels`),
`refused` (exit code 2), `works` (the mistake is declared or harmless: the set is evaluated as one without it).
Nothing may be named on data that are wrong.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from bench.rig import AMBIENT, COLUMNS, FAN, HOUSING, SPEED, TORQUE, WINDING

VOLTAGE, CURRENT, POWER = COLUMNS["voltage"], COLUMNS["current"], COLUMNS["power"]
WRONG, ASIDE, REFUSED, WORKS = "unusable", "set aside", "refused", "works"


@dataclass(frozen=True)
class Mistake:
    """`apply(rng, set)` changes the readings in place and returns the channels concerned; `needs` are columns the set
    must have.
    """

    id: str
    apply: Callable
    answers: tuple
    needs: tuple = ()


ALL: dict[str, Mistake] = {}


def mistake(*answers, needs=()):
    def enter(apply):
        ALL[apply.__name__] = Mistake(apply.__name__, apply, answers, needs)
        return apply

    return enter


def every(s, change, *channels) -> list:
    """Changes columns of all runs."""
    for channel in channels:
        for run in s.runs:
            run.readings[channel] = change(run.readings[channel])
    return list(channels)


@mistake(WRONG, REFUSED, needs=(SPEED,))
def rpm(rng, s):
    return every(s, lambda v: v * 60.0 / (2.0 * np.pi), SPEED)


@mistake(WRONG, REFUSED, needs=(TORQUE,))
def torque_in_mNm(rng, s):
    return every(s, lambda v: v * 1e3, TORQUE)


@mistake(WRONG, REFUSED, needs=(CURRENT,))
def current_in_mA(rng, s):
    return every(s, lambda v: v * 1e3, CURRENT)


@mistake(WRONG, REFUSED)
def temperatures_in_K(rng, s):
    return every(s, lambda v: v + 273.15, WINDING, HOUSING, AMBIENT)


@mistake(WRONG, REFUSED)
def one_temperature_in_degF(rng, s):
    return every(s, lambda v: 1.8 * v + 32.0, str(rng.choice([WINDING, HOUSING])))


@mistake(WRONG, REFUSED)
def fan_in_percent(rng, s):
    return every(s, lambda v: v * 100.0, FAN)


@mistake(WRONG, REFUSED, needs=(TORQUE,))
def torque_sign(rng, s):
    return every(s, lambda v: -v, TORQUE)


@mistake(WRONG, REFUSED, needs=(VOLTAGE, SPEED))
def voltage_sign(rng, s):
    return every(s, lambda v: -v, VOLTAGE)


@mistake(WRONG, REFUSED)
def winding_and_housing_swapped(rng, s):
    for run in s.runs:
        run.readings[WINDING], run.readings[HOUSING] = run.readings[HOUSING], run.readings[WINDING]
    return [WINDING, HOUSING]


@mistake(WRONG, REFUSED)
def ambient_and_housing_swapped(rng, s):
    for run in s.runs:
        run.readings[AMBIENT], run.readings[HOUSING] = run.readings[HOUSING], run.readings[AMBIENT]
    return [AMBIENT, HOUSING]


@mistake(WRONG, REFUSED, needs=(SPEED,))
def one_file_in_rpm(rng, s):
    run = s.runs[int(rng.integers(len(s.runs)))]
    run.readings[SPEED] = run.readings[SPEED] * 60.0 / (2.0 * np.pi)
    return [SPEED]


@mistake(WRONG, REFUSED)
def time_in_ms(rng, s):
    s.facts["time_factor"] = 1000.0
    return ["time_s"]


@mistake(WRONG, REFUSED)
def time_in_minutes(rng, s):
    s.facts["time_factor"] = 1.0 / 60.0
    return ["time_s"]


def from_some_time(rng, run) -> int:
    return int(rng.uniform(0.1, 0.7) * len(run.readings[HOUSING]))


@mistake(ASIDE)
def frozen(rng, s):
    """A sensor that repeats its last reading from some time on, in one run."""
    channel, run = str(rng.choice([WINDING, HOUSING])), s.runs[0]
    begin = from_some_time(rng, run)
    run.readings[channel][begin:] = run.readings[channel][begin]
    return [channel]


@mistake(ASIDE)
def detached(rng, s):
    """A thermocouple that falls off: from some time on it measures the air near the housing, with its own lag."""
    channel, run = str(rng.choice([WINDING, HOUSING])), s.runs[int(rng.integers(2))]
    v, air = run.readings[channel], run.readings[AMBIENT] + 0.1 * (run.readings[HOUSING] - run.readings[AMBIENT])
    begin, times = from_some_time(rng, run), run.times[run.kept]
    gone = np.exp(-(times[begin:] - times[begin]) / 15.0)
    noise = s.bench.noise[channel] * rng.standard_normal(len(gone))
    v[begin:] = air[begin:] + (v[begin] - air[begin:]) * gone + noise
    return [channel]


@mistake(ASIDE, WRONG)
def open_thermocouple(rng, s):
    """An amplifier shows some end of its range, with a little noise or without, in a whole run or from some time on."""
    channel, run = str(rng.choice([WINDING, HOUSING])), s.runs[int(rng.integers(len(s.runs)))]
    begin = int(rng.choice([0, from_some_time(rng, run)]))
    shown = float(rng.choice([-273.0, -210.0, -45.0, 0.0, 130.0, 400.0, 850.0, 1372.0]))
    values = run.readings[channel][begin:]
    run.readings[channel][begin:] = shown + rng.choice([0.0, 0.05]) * rng.standard_normal(len(values))
    return [channel]


@mistake(ASIDE, WRONG, needs=(TORQUE,))
def dead_torque_sensor(rng, s):
    for run in s.runs:
        run.readings[TORQUE] = s.bench.noise[TORQUE] * rng.standard_normal(len(run.readings[TORQUE]))
    return [TORQUE]


@mistake(ASIDE)
def clipped(rng, s):
    """A range that ends below the highest readings of the fit runs."""
    channel = str(rng.choice([c for c in s.rig.layout.outputs if c != CURRENT]))
    most = max(float(run.readings[channel].max()) for run in s.runs if run.role == "fit")
    least = min(float(run.readings[channel].min()) for run in s.runs)
    end = least + float(rng.uniform(0.6, 0.85)) * (most - least)
    return every(s, lambda v: np.minimum(v, end), channel)


@mistake(ASIDE)
def spikes(rng, s):
    """Single wild readings of both signs, one in a hundred rows."""
    channel = str(rng.choice(s.rig.layout.outputs))
    size = 40.0 * s.bench.noise[channel] + 0.3 * max(float(np.ptp(run.readings[channel])) for run in s.runs)
    for run in s.runs:
        hit = rng.random(len(run.readings[channel])) < 0.01
        run.readings[channel] = run.readings[channel] + hit * size * rng.choice([-1.0, 1.0], len(hit)) * rng.uniform(
            0.5, 2.0, len(hit)
        )
    return [channel]


@mistake(ASIDE, WRONG, "note")
def clock_shift(rng, s):
    """One logger's clock is late by 20 to 90 s."""
    channel = str(rng.choice([c for c in s.rig.layout.outputs if c in (VOLTAGE, TORQUE, WINDING)]))
    late = float(rng.uniform(20.0, 90.0))
    for run in s.runs:
        times = run.times[run.kept]
        run.readings[channel] = np.interp(times - late, times, run.readings[channel])
    return [channel]


@mistake(WORKS)
def repeated_rows(rng, s):
    s.facts["repeat"] = 0.02
    return []


@mistake(REFUSED)
def two_rows(rng, s):
    run = s.runs[0]
    rows = np.flatnonzero(run.kept)
    run.kept[rows[2:]] = False
    run.readings = {c: v[:2] for c, v in run.readings.items()}
    return [""]


@mistake(REFUSED)
def no_prior(rng, s):
    s.facts["no_prior"] = True
    return [""]


@mistake(REFUSED)
def text_in_a_number(rng, s):
    s.facts["text"] = str(rng.choice(["n/a", "NaN", "ERR", "--"]))
    return [""]


@mistake(REFUSED)
def column_missing(rng, s):
    s.facts["missing"] = str(rng.choice([*s.rig.layout.inputs, *s.rig.layout.outputs]))
    return [s.facts["missing"]]


@mistake(WORKS)
def foreign_csv(rng, s):
    """Other headers and units, declared in `[columns]`; some with semicolons and decimal commas."""
    s.facts["foreign"] = "semicolon" if rng.random() < 0.5 else "comma"
    return []


def draw(rng, s, name: str | None = None) -> dict:
    """Applies a mistake to the set; what it is, where, and the correct answers."""
    columns = {*s.rig.layout.inputs, *s.rig.layout.outputs}
    possible = [m for m in ALL.values() if columns.issuperset(m.needs)]
    chosen = ALL[name] if name else possible[int(rng.integers(len(possible)))]
    return {"id": chosen.id, "channels": chosen.apply(rng, s), "answers": list(chosen.answers)}
