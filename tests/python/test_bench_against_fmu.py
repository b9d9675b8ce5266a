"""The generator of bench experiments and the FMU, written independently, agree in every layout and size of motor."""

import numpy as np
import pytest
from bench import make, profiles
from bench.effects import CATALOGUE
from bench.generator import simulate
from bench.law import KELVIN, Effect
from bench.rig import LAYOUTS, Rig, draw_units

NAMES = {
    "current_A": "current_command",
    "voltage_V": "voltage",
    "electrical_power_W": "electrical_power",
    "speed_rad_per_s": "imposed_speed",
    "fan_command_1": "fan_command",
    "ambient_temperature_degC": "ambient_temperature",
}
READ = {
    "current_A": "current",
    "shaft_torque_Nm": "shaft_torque",
    "winding_temperature_degC": "winding_temperature",
    "housing_temperature_degC": "housing_temperature",
}
# What a specimen has in each layout: at several ports, with the tolerances of both integrations far below any sensor's noise.
EFFECTS = {
    "current": ("iron_loss", "housing_radiation", "fan_back_pressure", "interface_temperature"),
    "voltage": ("contact_drop", "iron_loss", "housing_sensor_stem_loss"),
    "power": ("drive_loss", "stator_node", "winding_sensor_offset"),
}
TOLERANCE = 0.02  # of the sensor's noise


def sized(name, rig):
    law = CATALOGUE[name]
    return Effect(law, {symbol: rig.scaled(v, law.scale.get(symbol, {})) for symbol, v in law.typical().parameters.items()})


def in_si(column, value):
    return value + KELVIN if column.endswith("degC") else value


@pytest.mark.parametrize("units", [{}, draw_units(np.random.default_rng(5))], ids=["public", "another"])
@pytest.mark.parametrize("drive", LAYOUTS)
def test_generator_and_fmu_are_the_same_motor(archives, monkeypatch, drive, units):
    for name, seconds in (("DURATION", (900.0, 1000.0)), ("REST_BEFORE", (20.0, 30.0)), ("REST_AFTER", (50.0, 60.0))):
        monkeypatch.setattr(profiles, name, seconds)
    monkeypatch.setattr(profiles, "SAMPLING", (2.0,))
    rig = Rig(LAYOUTS[drive], units)
    drawn = make.draw_set(6, 0, make.NONE, rig, 2)
    effects, run = [sized(name, rig) for name in EFFECTS[drive]], drawn.runs[0]
    inputs = {column: run.truth[column] for column in rig.layout.inputs}
    expected = simulate(drawn.specimen, effects, run.times, inputs, rig).outputs
    start = {"drive_mode": drive, "mechanical_mode": "free_shaft" if drive == "power" else "imposed_speed"}
    # The generator has no inductance.
    start |= {"cooling_mode": "conductance", "commutation": "equivalent_dc", "motor.L": 1e-6} | rig.nominal | drawn.specimen
    for effect in effects:
        start |= {f"effect.{effect.law.id}.{symbol}": value for symbol, value in effect.parameters.items()}
    with archives[2].instance() as fmu:
        fmu.initialise(start | {NAMES[c]: in_si(c, values[0]) for c, values in inputs.items()})
        for k, span in enumerate(np.diff(run.times)):
            fmu.set({NAMES[c]: in_si(c, values[k]) for c, values in inputs.items()})
            fmu.slopes({NAMES[c]: (values[k + 1] - values[k]) / span for c, values in inputs.items()})
            fmu.step(span)
            for column in set(rig.layout.outputs) & set(READ):
                (read,) = fmu.get(READ[column])
                miss = read - in_si(column, expected[column][k + 1])
                assert abs(miss) < TOLERANCE * drawn.noise[column], (column, run.times[k + 1], miss)
    hot = expected["winding_temperature_degC"]
    assert np.max(hot) - hot[0] > 8.0
