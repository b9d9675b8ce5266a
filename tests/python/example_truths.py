"""What the examples must give by closed form, by literature, by construction of their data, or by the order of a method."""

import json
import tomllib

import pytest
from clients.paths import EXAMPLES, ROOT

PRESET = {
    name: entry["value"]
    for name, entry in tomllib.loads((EXAMPLES / "presets" / "maxon-305015.toml").read_text())["start"].items()
}


def free_shaft(found):
    """The torque balance of a shaft at constant speed without friction, and Ohm's law with back-EMF: 24 V and 0.1 N.m."""
    warm = found["winding_temperature"] - PRESET["motor.T_ref"]
    k_t = PRESET["motor.k_t"]
    current = 0.1 / k_t
    resistance = PRESET["motor.R_ref"] * (1 + PRESET["motor.alpha"] * warm)
    # The magnets lose 0.12 % a kelvin and warm by less than the winding, by about a kelvin.
    assert found["current"] == pytest.approx(current, rel=2e-3)
    assert found["shaft_speed"] == pytest.approx((24 - resistance * found["current"]) / k_t, rel=2e-3)
    # R I^2 for ten seconds into the winding of 10 J/K, less what has gone to the housing through 0.21 K/W (2.1 s).
    rise = resistance * found["current"] ** 2 * PRESET["thermal.R_wh"]
    assert warm == pytest.approx(rise, abs=1.0)


def walking(found):
    """Where the limit of 155 degC ends the walk, the winding is at it. Energy is not made on the way to the joint."""
    for case in (value for value in found.values() if isinstance(value, dict)):
        if case["winding_limit_reached"]:
            assert case["winding_temperature_end_degC"] == pytest.approx(155.0, abs=0.1)
        assert case["energy_electrical_drawn_J"] > case["energy_shaft_J"] > case["energy_joint_J"] > 0
        assert abs(case["energy_balance_error_percent"]) < 0.01
    assert found["still air"]["minutes_walked"] < found["fan at full speed"]["minutes_walked"]


def continuous_torque(found):
    """Torque at the winding's limit by the audit of the thesis: its measured resistances, N.m at standstill."""
    fitted = found["motors"]["thesis rig, fitted to its eight tests"]["standstill"]
    for name, torque in {"bare": 0.108, "fan at 5 mm": 0.180, "40 mm annulus, pushed": 0.173}.items():
        assert found["tests"][name]["torque_at_limit"] == pytest.approx(torque, rel=5e-3), name
        assert fitted[name]["torque_Nm"] == pytest.approx(torque, rel=0.03), name


def repaired(found):
    """The generator of the data used this coefficient."""
    truth = json.loads((ROOT / "tests" / "reference" / "bench-synthetic" / "iron-loss" / "truth.json").read_text())
    (effect,) = found["iron-loss"]["effects"]
    assert effect["id"] == "iron_loss"
    assert effect["k"] == pytest.approx(coefficient(truth), rel=0.05)


def coefficient(truth):
    """The coefficient k anywhere in the truth."""
    if isinstance(truth, dict):
        if isinstance(truth.get("k"), (int, float)):
            return truth["k"]
        return next((k for k in map(coefficient, truth.values()) if k is not None), None)
    if isinstance(truth, list):
        return next((k for k in map(coefficient, truth) if k is not None), None)
    return None


def tracking(found):
    """The actuator follows the torque of the gait; the peak is that of the data."""
    assert found["torque_error_rms_Nm"] < 0.01 * found["joint_torque_peak_Nm"]


def orders(found):
    """Held inputs are of first order, extrapolated ones of second order, for the torque at the coupling."""
    for algorithm, order in found["order"].items():
        least = 1.7 if algorithm.endswith("input derivatives") else 0.7
        assert order["actuator.joint_torque"] >= least, algorithm
    for name, errors in found["error"].items():
        torque = [row["actuator.joint_torque"] for row in errors]
        assert torque == sorted(torque, reverse=True), f"{name}: the error does not fall with the step"


def operating_range(found):
    """The continuous torque by the maker's rule is the printed one within 10 %, unless the page says why not."""
    agree = [name for name, m in found.items() if abs(m["with_cold_magnets_mNm"] / m["printed_mNm"] - 1) <= 0.10]
    assert len(agree) >= 3 and all(m["reason"] for name, m in found.items() if name not in agree)


def never_far_worse(found):
    """Runs that disagree mislead neither the refit nor the repair: no channel of a run that was not fitted gets twice the error of the
    preset, and the repair is as good as the refit."""
    for split in found["splits"].values():
        for errors in split["test_K"].values():
            assert errors["after"] <= 1.02 * errors["refit"] and errors["refit"] <= 2.0 * errors["before"], errors


TRUTHS = {
    "01_first_step": (free_shaft,),
    "02_walking": (walking,),
    "03_what_cooling_buys": (continuous_torque,),
    "07_refit_against_repair": (repaired,),
    "09_plain_master": (tracking,),
    "12_coupling_error": (orders,),
    "13_operating_range": (operating_range,),
    "14_runs_that_disagree": (never_far_worse,),
}
