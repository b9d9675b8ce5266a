"""Raw logs of the rig to runs in the format of `motor-fmu close-loop`.

Each run has two logs without a common clock: temperatures (`runN_daq.csv`) and electrical power (`runN_esc.csv`). They become
one table with a row for every `ROW_S` of the thermometers' clock: a temperature is the mean of its readings in that time, the
power the mean over the same time, so that the energy stays what it was. Readings closer than that wander together and would be
counted as if each of them were news. All runs share one clock: each starts at its own multiple of `RUN_EVERY_S`; how much time
really lay between the runs is not known.

There is no speed: the motor stood, and the log's `erpm_raw` is noise. The experiments say that the shaft stands; a column of
zeros would claim a measurement that nobody made.

    python -m rig.prepare RAW_FOLDER OUT_FOLDER     (from examples/) writes run-N.csv and prepared.json
"""

import argparse
import json
from pathlib import Path

import numpy as np
from rig.align import align

RUNS = (1, 2, 3, 4, 5, 12)
RUN_EVERY_S = 1000.0
ROW_S = 2.0
# Column of the table, and what the rig's logs call it; the first that a log has. Run 12 had other sensors.
TEMPERATURES = {
    "ambient_temperature_degC": ("Ambient_degC",),
    "winding_temperature_degC": ("Winding_Temp_degC",),
    "housing_temperature_degC": ("Stator_Body_degC", "Housing_degC"),
    "stator_temperature_degC": ("Stator_Inner_degC",),
}
NEEDED = ("ambient_temperature_degC", "winding_temperature_degC", "housing_temperature_degC")
POWER = "electrical_power_W"
# An open thermocouple reads this; a channel that does so in half of its rows is dead.
DEAD_DEGC, DEAD_SHARE = -40.0, 0.5
# A pause of this many usual rows is a gap.
GAP_ROWS = 5.0
# Power that heats, W; and by how much the two clocks may disagree on how long it did.
HEATING_W = 100.0
CLOCKS_AGREE = 0.03


def read(path: Path) -> dict[str, np.ndarray]:
    """The columns of a raw log; blanks are NaN, text is an error with file and line."""
    lines = path.read_text(encoding="utf-8").splitlines()
    header = lines[0].split(",")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        try:
            row = [float(cell) if cell.strip() else np.nan for cell in line.split(",")]
        except ValueError as error:
            raise ValueError(f"{path}:{number}: {error}") from None
        if len(row) != len(header):
            raise ValueError(f"{path}:{number}: {len(row)} cells where the header has {len(header)}")
        rows.append(row)
    columns = dict(zip(header, np.array(rows).T))
    falls = np.flatnonzero(np.diff(columns["t_s"]) <= 0.0)
    if falls.size:
        raise ValueError(f"{path}:{falls[0] + 3}: t_s = {columns['t_s'][falls[0] + 1]:g} s does not come after the row before")
    return columns


def without_dead(column: np.ndarray, name: str, notes: list[str]) -> np.ndarray:
    """A temperature without the readings of an open thermocouple."""
    dead = np.abs(column - DEAD_DEGC) < 0.5
    if dead.mean() > DEAD_SHARE:
        notes.append(f"{name} reads {DEAD_DEGC:g} degC and is left blank as dead")
        return np.full_like(column, np.nan)
    if dead.any():
        notes.append(f"{dead.sum()} readings of {DEAD_DEGC:g} degC in {name} are left blank as drop-outs")
    return np.where(dead, np.nan, column)


def merge(daq: dict, esc: dict) -> tuple[dict, dict]:
    """One table on the clock of the temperatures, and the report on it."""
    notes = []
    time, power_time, power = daq["t_s"], esc["t_s"], esc["P_dc_W"]
    temperatures = {}
    for column, names in TEMPERATURES.items():
        name = next((name for name in names if name in daq), None)
        if name:
            temperatures[column] = without_dead(daq[name], name, notes)
        elif column in NEEDED:
            raise ValueError(f"no column {' or '.join(names)}; there is {', '.join(daq)}")
    used = {name for names in TEMPERATURES.values() for name in names} | {"t_s"}
    notes += [f"{name} has no place in the format and is left out" for name in daq if name not in used]
    step = float(np.median(np.diff(time)))
    for row in np.flatnonzero(np.diff(time) > GAP_ROWS * step):
        notes.append(f"no temperatures from {time[row]:g} s to {time[row + 1]:g} s")
    if not np.isfinite(power).all():
        raise ValueError(f"P_dc_W is blank at t_s = {power_time[~np.isfinite(power)][0]:g} s")

    winding = temperatures["winding_temperature_degC"]
    found = align(time, winding, power_time, power)
    heated = float(power_time[np.flatnonzero(power > HEATING_W)[-1]])
    # The reading peaks about a lag after the power has gone.
    seen = float(time[np.nanargmax(winding)]) - found.lag_s - found.shift_s
    trusted = abs(seen / heated - 1.0) <= CLOCKS_AGREE
    if not trusted:
        notes.append(f"the power's log heats for {heated:.1f} s and the winding rises for {seen:.1f} s: do not trust this energy")
    table = averaged(time, temperatures, power_time + found.shift_s, power)
    report = {
        "rows": len(table["time_s"]),
        "seconds": float(time[-1]),
        "shift_s": round(found.shift_s, 3),
        "shift_sure_to_s": round(found.sure_to_s, 3),
        "reading_lag_s": round(found.lag_s, 3),
        "alignment_rms_K": round(found.rms_K, 3),
        "clock_ratio": round(seen / heated, 4),
        "energy_trusted": trusted,
        "energy_logged_kJ": round(float(energy(power_time, power)[1][-1]) / 1e3, 3),
        "energy_in_table_kJ": round(float(np.trapezoid(table[POWER], table["time_s"])) / 1e3, 3),
        "notes": notes,
    }
    return table, report


def averaged(time: np.ndarray, temperatures: dict, power_time: np.ndarray, power: np.ndarray) -> dict:
    """Means over `ROW_S` each, at the mean time of the readings; no power before the log and after it. Empty rows are left out."""
    rows = (time / ROW_S).astype(int)
    numbers = np.unique(rows)
    mean = lambda column: np.array([_mean(column[rows == number]) for number in numbers])  # noqa: E731
    centre = mean(time)
    borders = np.concatenate([time[:1], 0.5 * (centre[1:] + centre[:-1]), time[-1:]])
    spent = np.interp(borders, *energy(power_time, power))
    return {"time_s": centre, POWER: np.diff(spent) / np.diff(borders)} | {n: mean(column) for n, column in temperatures.items()}


def _mean(readings: np.ndarray) -> float:
    there = readings[np.isfinite(readings)]
    return float(there.mean()) if there.size else np.nan


def energy(power_time: np.ndarray, power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Energy since the log began, and when; a row's power holds until the next row."""
    edges = np.append(power_time, 2.0 * power_time[-1] - power_time[-2])
    return edges, np.concatenate([[0.0], np.cumsum(power * np.diff(edges))])


def write(path: Path, table: dict, start: float) -> None:
    """A run's table; blank where nothing was measured."""
    decimals = {"time_s": 4, POWER: 2}
    cell = lambda name, value: "" if np.isnan(value) else f"{value:.{decimals.get(name, 3)}f}"  # noqa: E731
    columns = {**table, "time_s": table["time_s"] + start}
    rows = [",".join(cell(name, value) for name, value in zip(columns, row)) for row in zip(*columns.values())]
    path.write_text("\n".join([",".join(columns), *rows]) + "\n", encoding="utf-8")


def prepare(raw: Path, out: Path) -> dict:
    """All runs of the rig; gives the report that is also written as prepared.json."""
    out.mkdir(parents=True, exist_ok=True)
    report = {}
    for place, run in enumerate(RUNS):
        try:
            table, report[f"run-{run}.csv"] = merge(read(raw / f"run{run}_daq.csv"), read(raw / f"run{run}_esc.csv"))
        except ValueError as error:
            raise ValueError(f"run {run}: {error}") from None
        start = RUN_EVERY_S * place
        report[f"run-{run}.csv"] = {"starts_at_s": start, **report[f"run-{run}.csv"]}
        write(out / f"run-{run}.csv", table, start)
    (out / "prepared.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    return report


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("raw", type=Path, help="folder with runN_daq.csv and runN_esc.csv")
    parser.add_argument("out", type=Path, help="folder for run-N.csv and prepared.json")
    arguments = parser.parse_args()
    print(json.dumps(prepare(arguments.raw, arguments.out), indent=2))
