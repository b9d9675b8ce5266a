"""Bench experiments as loggers and instruments spoil them: the motor of `logging_rate`, four runs, and one thing that is wrong."""

import json
from dataclasses import dataclass
from typing import Callable

import logging_rate
import numpy as np
from logging_rate import INPUTS, OUTPUTS, PRIOR, RADIATION, VISCOUS, Case

RATE = 0.5  # Hz
ROLES = ("fit", "fit", "validate", "test")
WINDING, HOUSING, FAN = "winding_temperature_degC", "housing_temperature_degC", "fan_command_1"
TORQUE, CURRENT, VOLTAGE = "shaft_torque_Nm", "current_A", "voltage_V"
FORCED = "conductance.G_forced"


@dataclass(frozen=True)
class Mistake:
    """What is true of the motor, which runs are wrong, and what is expected."""

    effect: dict
    runs: tuple
    #: A part of a note.
    note: str
    #: Change of the columns of a run.
    change: Callable = lambda read: None
    #: The motor in the runs that are wrong.
    other: dict = None
    #: The channel of `unusable`, if this is also a right answer.
    channel: str = ""
    #: Number of readings in a row: their mean has less noise, and the error is compared with that of one reading.
    rows: int = 1


def scanned(period, *columns, start=0.0, step=0.0):
    """Thermometers to which a scanner comes every `period` seconds, one after the other; `step` is its resolution."""

    def change(read):
        time = read["time_s"]
        for place, column in enumerate(columns):
            first = start + place * period / 3
            rows = np.searchsorted(time, first + np.floor((time - first) / period) * period)
            values = read[column][np.clip(rows, 0, len(time) - 1)]
            read[column] = np.round(values / step) * step if step else values

    return change


def polled(read):
    """Thermometers that are polled at irregular times, on average every 20 s."""
    draw, row = np.random.default_rng(4), 0
    while row < len(read["time_s"]):
        end = row + 4 + draw.integers(0, 13)
        for column in (WINDING, HOUSING):
            read[column][row:end] = read[column][row]
        row = end


def scaled(column, factor):
    """One channel with another gain."""
    return lambda read: read.update({column: factor * read[column]})


def paused(seconds, at):
    """The logger pauses, and its times go on without the pause."""

    def change(read):
        time = read["time_s"]
        keep = (time < at) | (time >= at + seconds)
        for column in read:
            read[column] = time[: keep.sum()] if column == "time_s" else read[column][keep]

    return change


def averaged(rows):
    """A logger whose rows are means over so many of these."""

    def change(read):
        for column, values in read.items():
            whole = len(values) // rows * rows
            read[column] = values[:whole].reshape(-1, rows).mean(axis=1)

    return change


def behind(tau, *columns):
    """Instruments with a first-order filter of `tau` seconds, and the noise of their converters behind it."""

    def change(read):
        kept, draw = np.exp(-1.0 / (RATE * tau)), np.random.default_rng(6)
        for column in columns:
            for row in range(1, len(read[column])):
                read[column][row] = kept * read[column][row - 1] + (1.0 - kept) * read[column][row]
            read[column] += draw.normal(0.0, 5e-4 * np.ptp(read[column]), len(read[column]))

    return change


ALL, HELD = (0, 1, 2, 3), "a new reading in"
CASES = {
    "scans of 15 s, viscous friction": Mistake({VISCOUS: 1.2e-5}, ALL, HELD, scanned(15.0, WINDING, HOUSING)),
    "scans of 50 s of one thermometer": Mistake({}, ALL, HELD, scanned(50.0, WINDING, start=21.0)),
    "scans of 9 s, 0.1 K, radiation": Mistake({RADIATION: 8e-10}, ALL, HELD, scanned(9.0, WINDING, HOUSING, step=0.1)),
    "scans of 45 s in one run": Mistake({}, (1,), HELD, scanned(45.0, WINDING)),
    "polled at irregular times": Mistake({RADIATION: 8e-10}, ALL, HELD, polled),
    "a fan that does not run": Mistake({}, (0,), f"{FAN} was 0 throughout", other={FORCED: 0.0}),
    "an amplifier with another gain": Mistake({VISCOUS: 1.2e-5}, (2,), f"{TORQUE} is divided by 1.", scaled(TORQUE, 1.4)),
    "a probe with another range": Mistake({}, (1,), f"{CURRENT} is multiplied by 1.5", scaled(CURRENT, 0.65), channel=CURRENT),
    "a pause that is not in the times": Mistake({RADIATION: 8e-10}, (0,), "as if the logger had paused", paused(150.0, 2000.0)),
    "means over 24 s, viscous friction": Mistake({VISCOUS: 1.2e-5}, ALL, "as means over 24", averaged(12), rows=12),
    "means over 14 s, radiation": Mistake({RADIATION: 8e-10}, ALL, "as means over 14", averaged(7), rows=7),
    "two outputs behind filters of 11 s": Mistake(
        {VISCOUS: 1.2e-5}, ALL, "is behind a first-order lag", behind(11.0, VOLTAGE, TORQUE)
    ),
    "a current behind a filter of 4 s": Mistake({}, ALL, "", behind(4.0, CURRENT), channel=CURRENT),
}


def write(mistake, seed, folder):
    """The experiment: two fit runs, a validation run and a test run."""
    lines = ["[experiment]", 'name = "acquisition"', 'model = "AnnulusCooledMotor"', 'preset = "maxon-305015"']
    lines += [f"inputs = {json.dumps(list(INPUTS))}", f"outputs = {json.dumps(list(OUTPUTS))}", "[prior]"]
    lines += [f'"{name}" = {deviation}' for name, deviation in PRIOR.items()]
    for number, role in enumerate(ROLES):
        is_wrong = number in mistake.runs
        effect = {**mistake.effect, **((mistake.other or {}) if is_wrong else {})}
        read = logging_rate.recorded(Case(effect, (RATE,) * len(ROLES), duration=3600.0), number, seed)
        if is_wrong:
            mistake.change(read)
        name = f"run-{number + 1}.csv"
        rows = np.column_stack(list(read.values()))
        text = "\n".join(",".join(f"{x:.7g}" for x in row) for row in rows.tolist())
        (folder / name).write_text(f"{','.join(read)}\n{text}\n", encoding="utf-8")
        lines += ["[[run]]", f'file = "{name}"', f'role = "{role}"']
    path = folder / "experiment.toml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
