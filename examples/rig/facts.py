"""Evidence from the rig's logs that needs no model and that a fit of two temperatures does not use."""

from pathlib import Path

import numpy as np

from rig.prepare import NEEDED, TEMPERATURES, energy, read

# Interval of the winding's temperature rise over which the first rise is evaluated, K.
FIRST_RISE_K = (5.0, 25.0)
# Copper's resistance per kelvin, relative to that at 20 degC.
COPPER = 0.00393


def first_rise(raw: Path, run: int, shift: float) -> dict:
    """Temperature rise of the winding per energy, K/kJ, and the body's temperature above ambient during this rise, K.

    A body at ambient temperature transfers no heat by convection, whatever the air flow.
    """
    daq, esc = read(raw / f"run{run}_daq.csv"), read(raw / f"run{run}_esc.csv")
    rise = daq["Winding_Temp_degC"] - np.median(daq["Winding_Temp_degC"][:10])
    rows = [int(np.argmax(rise > kelvin)) for kelvin in FIRST_RISE_K]
    spent = np.diff(np.interp(daq["t_s"][rows] - shift, *energy(esc["t_s"], esc["P_dc_W"])))[0]
    stretch = slice(rows[0], rows[1])
    body = daq["Stator_Body_degC"][stretch] - daq["Ambient_degC"][stretch]
    return {
        "power_W": float(spent / np.diff(daq["t_s"][rows])[0]),
        "K_per_kJ": float(np.diff(rise[rows])[0] / spent * 1e3),
        "body_over_air_K": float(body.mean()),
    }


def controller_warming(raw: Path, run: int, spent_kJ: float) -> float:
    """Temperature rise of the motor controller, K, at a given cumulative energy; it increases with the controller's losses."""
    esc = read(raw / f"run{run}_esc.csv")
    time, spent = energy(esc["t_s"], esc["P_dc_W"])
    at = np.interp(1e3 * spent_kJ, spent, time)
    return float(np.interp(at, esc["t_s"], esc["T_esc_degC"]) - esc["T_esc_degC"][0])


def row_scatter(raw: Path, run: int, column: str) -> float:
    """Standard deviation of a reading from row to row while the winding is hot, K, relative to the mean of the adjacent rows.

    The temperature of a body of hundreds of J/K cannot scatter from row to row; a thermocouple in an air flow can.
    """
    daq = read(raw / f"run{run}_daq.csv")
    winding = daq["Winding_Temp_degC"]
    name = next(name for name in TEMPERATURES[column] if name in daq)
    reading = daq[name][winding > 60.0]
    off = reading[1:-1] - 0.5 * (reading[:-2] + reading[2:])
    # 1.4826: from the median of a normal distribution to its standard deviation; 1.5: variance of the combination.
    return float(1.4826 * np.median(np.abs(off)) / np.sqrt(1.5))


def repeatability(raw: Path, runs: tuple[int, int], shifts: tuple[float, float]) -> dict:
    """Repeatability of a reading, K: standard deviation between two equal runs at the same energy."""
    rises = []
    logs = [(read(raw / f"run{run}_daq.csv"), read(raw / f"run{run}_esc.csv")) for run in runs]
    clocks = [energy(esc["t_s"] + shift, esc["P_dc_W"]) for (_, esc), shift in zip(logs, shifts)]
    shared = np.linspace(0.0, min(spent[-1] for _, spent in clocks), 200)
    for (daq, _), (time, spent) in zip(logs, clocks):
        at = np.interp(shared, spent, time)
        readings = {column: daq[TEMPERATURES[column][0]] for column in NEEDED}
        rises.append({column: np.interp(at, daq["t_s"], r) - np.median(r[:10]) for column, r in readings.items()})
    apart = {column: rises[0][column] - rises[1][column] for column in NEEDED}
    return {column: float(np.sqrt(np.mean(difference**2) / 2.0)) for column, difference in apart.items()}


def two_places(raw: Path) -> float:
    """Run 12 had two thermocouples on the winding: ratio of the second's rise to the first's at the end."""
    daq = read(raw / "run12_daq.csv")
    first, second = (daq[name] - np.median(daq[name][:5]) for name in ("Winding_Temp_degC", "Winding2_degC"))
    return float(second[-5:].mean() / first[-5:].mean())


def two_readings_of_one_number(reading: float, ambient: float, usual: float, more: float) -> dict:
    """Winding temperature if the sensor error is that of still air, and if the air flow removes a further fraction of the rise.

    `usual` is the fraction of the rise that the sensor loses in still air. The winding's resistance right after switching off
    distinguishes the two cases: `resistance_ratio` is that of the hotter winding over the cooler.
    """
    as_usual = ambient + (reading - ambient) / (1.0 - usual)
    cooled = ambient + (as_usual - ambient) / (1.0 - more)
    resistance = lambda celsius: 1.0 + COPPER * (celsius - 20.0)  # noqa: E731
    return {
        "less_heat_degC": as_usual,
        "cooled_thermocouple_degC": cooled,
        "resistance_ratio": resistance(cooled) / resistance(as_usual),
    }


def readings_at_the_end(raw: Path, run: int) -> dict:
    """The last readings of the needed channels, degC."""
    daq = read(raw / f"run{run}_daq.csv")
    return {column: float(daq[next(n for n in TEMPERATURES[column] if n in daq)][-1]) for column in NEEDED}
