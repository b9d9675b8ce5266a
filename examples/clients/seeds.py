"""The measurements of the two publications as runs: one file for each test, with a reading in its last row only."""

import json
from functools import cache
from pathlib import Path

from clients.program import motor_fmu

KELVIN = 273.15
# Heating time until the steady state is reached to 0.02 K, s: ten times the slowest time constant, which is shorter with the fan.
STILL_AIR, FAN = 18_000.0, 9_000.0
# Rows before the last one: the closed loop linearises the model from row to row, and the gearmotor's state changes much.
THESIS_ROWS, PAPER_ROWS = 10, 60


@cache
def thesis_cases() -> list[dict]:
    """The thesis's eight tests, with the fits of the model to them, which take seconds."""
    return json.loads(motor_fmu("reproduce", "thesis", "--json"))["cases"]


def thesis_runs() -> dict[str, str]:
    """Files of the thesis's eight tests, by name."""
    files = {}
    for case in thesis_cases():
        bare = case["cooling_mode"] == "bare"
        inputs = {
            "electrical_power_W": case["power_W"],
            "fan_command_1": 0.0 if bare else 1.0,
            "ambient_temperature_degC": case["ambient_K"] - KELVIN,
        }
        outputs = {"winding_temperature_degC": case["T_w_measured_K"] - KELVIN}
        files[f"{case['name']}.csv"] = run(STILL_AIR if bare else FAN, THESIS_ROWS, inputs, outputs)
    return files


def thesis_predictions() -> dict[str, dict[str, float]]:
    """Winding temperatures of the eight tests, K: measured, fitted to all tests, fitted to the other seven, untuned."""
    keys = {"measured": "T_w_measured_K", "fitted": "T_w_model_K", "leave_one_out": "T_w_leave_one_out_K", "untuned": "T_w_untuned_K"}
    # Two digits: a fit ends where its steps no longer matter.
    return {case["name"]: {name: round(case[key], 2) for name, key in keys.items()} for case in thesis_cases()}


def paper_runs() -> dict[str, str]:
    """Files of the paper's five runs, by name."""
    files = {}
    for point in json.loads(motor_fmu("reproduce", "paper", "--json"))["measured"]:
        inputs = {
            "duty_1": point["duty_percent"] / 100.0,
            "supply_voltage_V": point["supply_V"],
            "ambient_temperature_degC": point["room_degC"],
        }
        outputs = {
            "voltage_V": point["voltage_V"],
            "current_A": point["current_A"],
            "housing_temperature_degC": point["temperature_degC"],
        }
        files[f"duty-{point['duty_percent']:.0f}.csv"] = run(point["duration_s"], PAPER_ROWS, inputs, outputs)
    return files


def run(end: float, count: int, inputs: dict[str, float], outputs: dict[str, float]) -> str:
    """A file with constant inputs, and readings of the outputs in the last row only."""
    number = "{:.6g}".format
    held = [number(value) for value in inputs.values()]
    rows = [["time_s", *inputs, *outputs]]
    rows += [[number(end * k / count), *held, *("" for _ in outputs)] for k in range(count)]
    rows.append([number(end), *held, *map(number, outputs.values())])
    return "".join(",".join(row) + "\n" for row in rows)


def write(files: dict[str, str], folder: Path) -> None:
    """Writes the files into a folder."""
    for name, text in files.items():
        (folder / name).write_text(text)
