"""By how much do a fan and an annulus raise the continuous torque, under which load, at which mass? The thesis's question.

Continuous torque is the torque in steady state with the winding at its limit of 155 degC. The rig's model is fitted to the thesis's
measurements, so the predictions that do not use a measurement stand beside it: untuned, and fitted to the other tests. Run it after `cargo xtask demo`, with
`motor-fmu` on the path; `--out FOLDER` also writes the answer as a page of Markdown.
"""

import argparse
import json
import textwrap
from pathlib import Path

from clients.program import motor_fmu

ARRANGEMENTS = {
    "bare": {"cooling_mode": "bare"},
    "fan at 5 mm": {"cooling_mode": "fan_crossflow"},
    "40 mm annulus, pushed": {"cooling_mode": "annulus_push", "annulus.outer_diameter": 0.040, "annulus.mass": 0.0155},
    "35 mm annulus, pushed": {"cooling_mode": "annulus_push", "annulus.outer_diameter": 0.035, "annulus.mass": 0.0180},
}
# The rig's fit holds for its own rig; the other motor is the datasheet's with default start values.
MOTORS = {"thesis rig, fitted to its eight tests": "thesis-rig", "datasheet, untuned": "maxon-305015"}
# Tests of the thesis with the same arrangement.
TESTS = {
    "bare": "bare",
    "fan at 5 mm": "fan-5mm",
    "40 mm annulus, pushed": "annulus-40-push",
    "35 mm annulus, pushed": "annulus-35-push",
}
LEAK = "annulus.leak_area"
GRAMS, SQUARE_CM = 1e3, 1e4
STANDSTILL, TURNING = "standstill", "1000 rad/s"
LOADS = {
    STANDSTILL: {"imposed_speed": 0.0},
    TURNING: {"imposed_speed": 1000.0},
    "standstill, ambient temperature 40 °C, altitude 2500 m": {"imposed_speed": 0.0, "ambient_temperature": 313.15, "ambient_pressure": 74_700.0},
}


def digits(value: float, count: int = 5) -> float:
    """A number to so many digits: a fit ends where its steps no longer matter."""
    return float(f"{value:.{count}g}")


def continuous(preset: str, *settings: dict) -> dict:
    """Continuous torque, N.m, and torque density, N.m/kg."""
    options = {"drive_mode": "current", "mechanical_mode": "imposed_speed", "fan_command": 1.0}
    for setting in settings:
        options |= setting
    sets = [part for name, value in options.items() for part in ("--set", f"{name}={value}")]
    found = json.loads(motor_fmu("steady", "--preset", preset, *sets, "--json"))["continuous"]
    return {"torque_Nm": found["torque"], "density_Nm_per_kg": found["torque_density"]}


def gains(rows: dict) -> dict:
    """The rows with their gains over the bare motor, percent."""
    bare = rows["bare"]
    for row in rows.values():
        row["torque_gain_percent"] = 100.0 * (row["torque_Nm"] / bare["torque_Nm"] - 1.0)
        row["density_gain_percent"] = 100.0 * (row["density_Nm_per_kg"] / bare["density_Nm_per_kg"] - 1.0)
    return rows


def study() -> dict:
    """Every motor, load and arrangement, and the thesis's own tests with what is measured, fitted and predicted."""
    thesis = json.loads(motor_fmu("reproduce", "thesis", "--json"))
    cases = {case["name"]: case for case in thesis["cases"]}
    fitted = {p["name"]: p for p in thesis["identifiability"]["parameters"]}
    keys = ("T_w_measured_K", "T_w_model_K", "T_w_leave_one_out_K", "T_w_untuned_K", "torque_density_at_5A")
    torques = ("torque_at_limit", "torque_at_limit_model", "torque_at_limit_leave_one_out", "torque_at_limit_untuned")
    return {
        "motors": {
            motor: {
                load: gains({name: continuous(preset, setting, inputs) for name, setting in ARRANGEMENTS.items()})
                for load, inputs in LOADS.items()
            }
            for motor, preset in MOTORS.items()
        },
        "tests": {name: {key: digits(cases[test][key]) for key in (*keys, *torques)} for name, test in TESTS.items()},
        "leak_area_m2": {key: digits(fitted[LEAK][key], 3) for key in ("value", "deviation")},
    }


def percent(value: float) -> str:
    """A gain with its sign."""
    return f"{value:+.0f} %"


def standstill_words(rows: dict) -> str:
    """Torque and torque density at standstill on the rig; which arrangement is best follows from the numbers."""
    bare, fan, annulus = (rows[name] for name in ("bare", "fan at 5 mm", "40 mm annulus, pushed"))
    tube = GRAMS * ARRANGEMENTS["40 mm annulus, pushed"]["annulus.mass"]
    mass = 100.0 * ((100.0 + fan["torque_gain_percent"]) / (100.0 + fan["density_gain_percent"]) - 1.0)
    better = annulus["density_Nm_per_kg"] > fan["density_Nm_per_kg"]
    verdict = "higher" if better else "lower"
    best = max(rows, key=lambda name: rows[name]["density_Nm_per_kg"])
    return f"""At standstill (preset `thesis-rig`) the fan at 5 mm changes the continuous torque from {bare["torque_Nm"]:.3f} to
        {fan["torque_Nm"]:.3f} N.m ({percent(fan["torque_gain_percent"])}), the mass by {percent(mass)} and the torque per mass by
        {percent(fan["density_gain_percent"])}. With fan and 40 mm annulus (tube: {tube:.1f} g) the torque is {annulus["torque_Nm"]:.3f} N.m
        ({percent(annulus["torque_gain_percent"])} relative to the bare motor). The torque per mass changes by
        {percent(annulus["density_gain_percent"])}, which is {verdict} than with the fan alone. The arrangement with the highest torque per
        mass is: {best}."""


def current_words(tests: dict) -> str:
    """Why the thesis found no improvement: densities at 5 A."""
    bare = tests["bare"]["torque_density_at_5A"]
    best = max(tests, key=lambda name: tests[name]["torque_density_at_5A"])
    gain = 100.0 * (tests[best]["torque_density_at_5A"] / bare - 1.0)
    at_limit = 100.0 * (max(t["torque_at_limit"] for t in tests.values()) / tests["bare"]["torque_at_limit"] - 1.0)
    return f"""The thesis compares the arrangements at a current of 5 A. At this current the highest torque per mass is {gain:.1f} % above
        that of the bare motor ({best}), because at a given current cooling changes the torque only through the temperature of the
        magnets. At equal winding temperature (155 °C) the torque is up to {at_limit:.0f} % higher than that of the bare motor, computed from the measured thermal
        resistances."""


def prediction_words(answer: dict) -> str:
    """How far the model can be trusted where nothing was measured."""
    tests = answer["tests"]
    off = lambda key: {name: t[key] - t["T_w_measured_K"] for name, t in tests.items()}  # noqa: E731
    rms = lambda errors: (sum(e * e for e in errors.values()) / len(errors)) ** 0.5  # noqa: E731
    fit, left, untuned = (off(key) for key in ("T_w_model_K", "T_w_leave_one_out_K", "T_w_untuned_K"))
    annuli = [error for name, error in untuned.items() if "annulus" in name]
    leak, deviation = (SQUARE_CM * answer["leak_area_m2"][key] for key in ("value", "deviation"))
    if max(annuli) < 0.0:
        cause = f"""The untuned model predicts more cooling by the annuli than was measured. The fit explains the difference by a leak area of
            {leak:.1f} ± {deviation:.1f} cm² between fan and annulus; `motor-fmu reproduce thesis --out DIR` shows fits with other
            causes."""
    else:
        cause = "The untuned model does not predict more cooling for all annuli than was measured."
    return f"""The table compares the model with four tests of the thesis (winding temperature T_w at a heating power of 10 W; in
        parentheses the error). "Fitted to all": preset `thesis-rig`, fitted to all eight tests; its rms error of {rms(fit):.1f} K over
        these four tests is a fit error, not a prediction error. "Leave-one-out": fitted to the other seven tests; the rms error of the
        prediction is {rms(left):.1f} K (largest error: {max(left, key=lambda name: abs(left[name]))},
        {max(left.values(), key=abs):+.1f} K). "Untuned": preset `maxon-305015`, rms error {rms(untuned):.1f} K. {cause}"""


def speed_words(rows: dict) -> str:
    """The gain at speed over that at standstill, for the untuned motor."""
    name = "40 mm annulus, pushed"
    turning, still = (rows[load][name]["torque_gain_percent"] for load in (TURNING, STANDSTILL))
    relation = "higher" if turning > still else "lower"
    bare = {load: rows[load]["bare"]["torque_Nm"] for load in (TURNING, STANDSTILL)}
    return f"""At 1000 rad/s friction heats the housing: the continuous torque of the bare untuned motor (mode `bare`) is {bare[TURNING]:.3f} N.m,
        compared with {bare[STANDSTILL]:.3f} N.m at standstill. The 40 mm annulus changes it by {percent(turning)} at 1000 rad/s; this
        gain is {relation} than that at standstill ({percent(still)})."""


def torque_words(answer: dict) -> str:
    """Why the torques of the tests and those at standstill differ for the same motor."""
    ends = zip(("_model", "_untuned"), answer["motors"].values(), strict=True)
    ratios = [rows[STANDSTILL][name]["torque_Nm"] / t["torque_at_limit" + end] for end, rows in ends for name, t in answer["tests"].items()]
    most = 100.0 * max(abs(ratio - 1.0) for ratio in ratios)
    return f"""The torques of this table are computed as in the thesis: from the thermal resistance at 10 W, with the winding resistance and
        the ambient temperature of the tests (24.8 °C) in all columns. The tables below state the steady state of the model with the
        winding at 155 °C and the heat that it then releases, with the winding resistance of the preset and an ambient temperature of
        25 °C. Their torques at standstill differ from those of this table by up to {most:.0f} %."""


def test_table(tests: dict) -> str:
    """Measured, fitted and predicted values of the thesis's tests as Markdown."""
    text = "| arrangement | T_w in K: measured | T_w: fitted to all | T_w: leave-one-out | T_w: untuned "
    text += "| torque at 155 °C in N.m: from measured thermal resistance | torque: fitted to all | torque: leave-one-out | torque: untuned |\n"
    text += "|" + "---|" * 9 + "\n"
    for name, t in tests.items():
        with_error = [f"{t[key]:.1f} ({t[key] - t['T_w_measured_K']:+.1f})" for key in
                      ("T_w_model_K", "T_w_leave_one_out_K", "T_w_untuned_K")]
        torques = [f"{t['torque_at_limit' + end]:.3f}" for end in ("", "_model", "_leave_one_out", "_untuned")]
        text += f"| {name} | {t['T_w_measured_K']:.1f} | " + " | ".join(with_error + torques) + " |\n"
    return text


def markdown(answer: dict) -> str:
    """The answer with its numbers; each conclusion is computed from them."""
    fitted, untuned = (answer["motors"][motor] for motor in MOTORS)
    fill = lambda paragraph: textwrap.fill(" ".join(paragraph.split()), 128, break_on_hyphens=False)  # noqa: E731
    paragraphs = [
        """This page is generated by `examples/03_what_cooling_buys.py`; the nightly tests run the example and compare the page. Motor:
        maxon 305015 with the fan and the annuli of the [thesis](../README.md#publications). Arrangements and cooling modes: bare motor
        (`bare`: natural convection and radiation, computed); fan 5 mm from the motor in crossflow (`fan_crossflow`); fan that pushes air
        through an annulus with an outer diameter of 40 or 35 mm (`annulus_push`). The README uses the mode `conductance`, in which the
        conductance to ambient is a parameter, and therefore has other torques for the motor without fan. Continuous torque: torque in
        steady state with the winding at its limit of 155 °C. Two parameter sets: preset `thesis-rig`, fitted to the eight tests of the
        thesis (the rig), and preset `maxon-305015` from the datasheet, not fitted (untuned).""",
        standstill_words(fitted[STANDSTILL]),
        current_words(answer["tests"]),
        speed_words(untuned),
    ]
    text = "# Continuous torque with fan and annulus\n\n" + "\n\n".join(map(fill, paragraphs)) + "\n"
    text += "\n## Measured, fitted, predicted\n\n" + fill(prediction_words(answer)) + "\n\n" + test_table(answer["tests"])
    text += "\n" + fill(torque_words(answer)) + "\n"
    for motor, loads in answer["motors"].items():
        text += f"\n## Motor: {motor}\n"
        for load, rows in loads.items():
            text += f"\n{load[0].upper()}{load[1:]}:\n\n| arrangement | torque N.m | per mass N.m/kg | gain | gain per mass |\n"
            text += "|---|---|---|---|---|\n"
            for name, row in rows.items():
                text += (
                    f"| {name} | {row['torque_Nm']:.3f} | {row['density_Nm_per_kg']:.3f} "
                    f"| {percent(row['torque_gain_percent'])} | {percent(row['density_gain_percent'])} |\n"
                )
    return text


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="folder to write what-cooling-buys.md to")
    out = parser.parse_args().out
    answer = study()
    if out:
        out.mkdir(parents=True, exist_ok=True)
        (out / "what-cooling-buys.md").write_text(markdown(answer))
    print(json.dumps(answer, indent=2))
