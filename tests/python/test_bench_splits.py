"""The five runs of the measured rig that disagree: their preparation, and fits that do not depend on where they start."""

import json

import numpy as np
import pytest
from clients.paths import ROOT
from clients.program import motor_fmu
from rig import prepare, splits
from test_bench_rig import table_of

RAW = ROOT / "tests" / "reference" / "bench-bldc-stall"
OPTIMUM = 0.01  # relative difference of two fits that are the same


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """Folder of the prepared runs and the shifts of the clocks."""
    folder = tmp_path_factory.mktemp("splits")
    return folder, splits.prepare(RAW, folder)


def test_runs_keep_energy_and_readings(prepared):
    """The energy of each log, and readings of a motor between ambient and 250 degC."""
    folder, shifts = prepared
    assert list(shifts) == list(splits.SENSORS)
    for run in splits.SENSORS:
        table = table_of(folder / f"run-{run}.csv")
        log = prepare.read(RAW / f"run{run}_esc.csv")
        energy = np.trapezoid(table[prepare.POWER], table["time_s"])
        assert energy == pytest.approx(prepare.energy(log["t_s"], log["P_dc_W"])[1][-1], rel=0.02), run
        for name in splits.SENSORS[run]:
            assert np.isfinite(table[name]).mean() > 0.99, (run, name)
            assert 15.0 < np.nanmin(table[name]) < np.nanmax(table[name]) < 250.0, (run, name)


def test_every_run_is_tested_and_fitted():
    """Each run is the test run once and fitted in at least two splits; a split fits three runs."""
    assert sorted(test for test, _ in splits.SPLITS) == sorted(splits.SENSORS)
    for test, validate in splits.SPLITS:
        text = splits.split(test, validate)
        assert test != validate and text.count('role = "fit"') == len(splits.SENSORS) - 2
        assert "[noise]" not in text


def fitted(folder, preset):
    """Winding and housing of run 10C alone: parameters by name, and the error of the fit, K."""
    text = splits.experiment({"10C": "fit"}, "10C alone", preset).split("\n[[run]]")[0]
    outputs = 'outputs = ["winding_temperature_degC", "housing_temperature_degC"]'
    text = "\n".join(outputs if line.startswith("outputs") else line for line in text.splitlines())
    # The seat of the sensor is known, so that the data determine all parameters.
    text = text.replace("[prior]", '"effect.winding_sensor_stem_loss.k" = 0.2\n\n[prior]')
    file = folder / f"from-{preset}.toml"
    file.write_text(text + '\n\n[[run]]\nfile = "run-10C.csv"\nrole = "fit"\nstart = "measured"\n')
    report = json.loads(motor_fmu("fit", str(file), "--out", str(folder / f"from-{preset}"), "--json"))
    return {name: number["value"] for name, number in report["parameters"].items()}, report["error"]["fit"]


@pytest.mark.parametrize(
    "presets",
    [
        ("bench-bldc-stall", "maxon-305015"),
        pytest.param(
            ("bench-bldc-stall", "maxon-305015", "maxon-eci40-488607", "maxon-re40-148877", "maxon-ec90flat-323772"),
            marks=pytest.mark.nightly,
        ),
    ],
    ids=("two", "five"),
)
def test_the_refit_of_a_run_is_the_same_from_any_preset(prepared, presets, tmp_path):
    """Heat capacities of the winding in these presets differ by a factor of 40, their errors by a factor of 17."""
    for file in prepared[0].glob("*.csv"):
        (tmp_path / file.name).write_text(file.read_text())
    (first, error), *others = (fitted(tmp_path, preset) for preset in presets)
    assert error["winding_temperature_degC"]["refit"] < 3.0 and error["housing_temperature_degC"]["refit"] < 0.5, error
    for other, _ in others:
        assert other == pytest.approx(first, rel=OPTIMUM)
