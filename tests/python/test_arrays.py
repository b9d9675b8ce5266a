"""FMI 3 arrays: the housing segments are one variable with a structural size, equal to the elements of FMI 2 bit for bit."""

import csv

import numpy as np
import pytest
from clients import paths
from clients.fmu import Archive, FmuError
from fmpy import read_model_description, simulate_fmu
from test_model_exchange import MOTOR, POWER, PUSH

PUSHED = {"cooling_mode": PUSH, "drive_mode": POWER, "electrical_power": 20.0, "fan_command": 0.8}
STEPS = 20


@pytest.fixture(scope="module")
def three():
    with Archive(paths.archive(MOTOR, 3)) as archive:
        yield archive


def housing(archive, start):
    """Segment temperatures over a run, one row per step."""
    with archive.instance() as fmu:
        fmu.initialise({**PUSHED, **start})
        count = start.get("air_segments", 8)
        names = ["T_housing"] if archive.version == "3.0" else [f"T_housing[{k + 1}]" for k in range(count)]
        rows = []
        for _ in range(STEPS):
            fmu.step(0.5)
            values = fmu.get(*names)
            rows.append(values[0] if archive.version == "3.0" else values)
        return np.array(rows)


def test_the_array_is_the_elements(three):
    with Archive(paths.archive(MOTOR, 2)) as two:
        assert housing(two, {}).tobytes() == housing(three, {}).tobytes()


@pytest.mark.parametrize("count", (1, 3, 8, 17, 64))
def test_any_number_of_segments(three, count):
    warm = housing(three, {"air_segments": count})
    assert warm.shape == (STEPS, count)
    assert np.all(np.diff(warm, axis=0) > 0.0), "all are warming"
    if count > 1:
        assert np.all(warm[-1, 1:] > warm[-1, 0]), "coldest where the air enters"


@pytest.mark.parametrize("count", (0, 65))
def test_other_numbers_are_refused(three, count):
    with pytest.raises(FmuError, match=f"air_segments = {count} is outside its limits 1 ... 64") as refused:
        housing(three, {"air_segments": count})
    assert len(refused.value.lines) == 1


def test_the_number_is_set_in_its_own_mode_alone(three):
    with three.instance() as fmu:
        with pytest.raises(FmuError, match="air_segments can be set in configuration mode alone"):
            fmu.set({"air_segments": 4})
        fmu.slave.enterConfigurationMode()
        with pytest.raises(FmuError, match="voltage can be set outside configuration mode alone"):
            fmu.set({"voltage": 4.0})
        fmu.slave.exitConfigurationMode()
        fmu.initialise(PUSHED)
        assert len(fmu.get("T_housing")[0]) == 8


def test_fmpy_records_the_array():
    path = str(paths.archive(MOTOR, 3))
    names = ["winding_temperature", "T_housing", "shaft_speed"]
    for kind in ("CoSimulation", "ModelExchange"):
        result = simulate_fmu(path, fmi_type=kind, start_values=PUSHED, stop_time=10.0, output_interval=0.5, output=names)
        assert result["T_housing"].shape == (21, 8)
        assert np.ptp(result["T_housing"][-1]) > 1e-3 and np.all(result["T_housing"][-1] > result["T_housing"][0])


def test_the_native_master_records_each_element(motor_fmu, tmp_path, three):
    out = tmp_path / "rows.csv"
    settings = [word for name, value in {**PUSHED, "air_segments": 5}.items() for word in ("--set", f"{name}={value}")]
    command = ("simulate", paths.archive(MOTOR, 3), "--stop", "10", "--step", "0.5", *settings, "--output", out)
    done = motor_fmu(*command)
    assert done.returncode == 0, done.stderr
    with out.open(newline="") as text:
        rows = list(csv.DictReader(text))
    names = [name for name in rows[0] if name.startswith("T_housing")]
    assert names == [f"T_housing[{k + 1}]" for k in range(5)]
    native = np.array([[float(row[name]) for name in names] for row in rows[1:]])
    assert native.tobytes() == housing(three, {"air_segments": 5}).tobytes()


def test_the_description_says_how_long_it_is():
    description = read_model_description(str(paths.archive(MOTOR, 3)))
    variables = {v.name: v for v in description.modelVariables}
    size, array = variables["air_segments"], variables["T_housing"]
    assert (size.type, size.causality, size.variability, size.start) == ("UInt64", "structuralParameter", "fixed", "8")
    assert array.causality == "output" and array.dimensions[0].variable is size
    assert variables["der(T_housing)"].derivative is array
