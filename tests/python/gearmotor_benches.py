"""Benches of a gearmotor whose preset is wrong in one respect that neither [set] nor [prior] states, or that has an effect of no list: its FMU
is the motor on the bench."""

import csv
import io
import json
import subprocess
import tomllib
from dataclasses import dataclass, field

import numpy as np
from clients.paths import ROOT

PRESET = "maxon-re30-gp32a-86"
START = {
    name: entry["value"]
    for name, entry in tomllib.loads((ROOT / "examples" / "presets" / f"{PRESET}.toml").read_text(encoding="utf-8"))["start"].items()
}
# Of the motor on the bench, relative to the preset; the prior of the experiment is a little wider.
DEVIATION = {"motor.R_ref": 0.03, "motor.k_t": -0.02, "thermal.R_wh": 0.1, "thermal.C_h": -0.06, "thermal.G_hb": 0.1, "gear.tau_c": -0.1}
PRIOR = {name: 2 * abs(share) for name, share in DEVIATION.items()}
INPUTS = {"duty_1": "duty", "supply_voltage_V": "supply_voltage", "load_torque_Nm": "load_torque"}
AMBIENT = "ambient_temperature_degC"
OUTPUTS = {
    "current_A": "current",
    "voltage_V": "voltage",
    "speed_rad_per_s": "shaft_speed",
    "winding_temperature_degC": "winding_temperature",
    "housing_temperature_degC": "housing_temperature",
}
NOISE = {
    "duty_1": 0.0005,
    "supply_voltage_V": 0.01,
    "load_torque_Nm": 0.003,
    AMBIENT: 0.05,
    "current_A": 0.006,
    "voltage_V": 0.02,
    "speed_rad_per_s": 0.02,
    "winding_temperature_degC": 0.1,
    "housing_temperature_degC": 0.1,
}
ROLES = ("fit", "fit", "validate", "test")
ROW, DURATION, KELVIN = 2.0, 1800.0, 273.15
REST = 120.0  # s without duty and load, at the start of each run and between its levels


@dataclass
class Case:
    """What the motor on the bench has in place of the preset."""

    truth: dict = field(default_factory=dict)
    rest: bool = field(default=False)  # whether the motor rests between the levels
    term: dict | None = None  # an effect of no list, as in effects.json


CASES = {
    "a gear with a temperature of its own": Case({"thermal.C_g": 50.0}),
    "viscous friction that nobody stated": Case({"gear.k": 0.02}),
    "another decay mode": Case({"drive.decay": "fast"}),
    "a loss of magnetisation": Case({"effect.demagnetisation.fraction": 0.05, "effect.demagnetisation.time": 3210.0}),
    "nothing, long at rest": Case(rest=True),
}


def power(port, coefficient, driver, reference, exponent=1.0, offset=0.0, **further):
    """A term: a power of a driver."""
    return {
        "port": port,
        "coefficient": coefficient,
        "drivers": [{"driver": driver, "reference": reference, "exponent": exponent, "offset": offset}],
        **further,
    }


MASS = {"driver": "housing_temperature", "tau": 200.0, "difference": True}
LAWS = {
    "a housing sensor that errs with the speed": Case(term=power("housing_sensor", -2.0, "speed", 8.0)),
    "a mass on the housing": Case(term=power("housing_heat", 0.3, "housing_temperature", 1.0, lag=MASS)),
    "a joint that conducts better in motion": Case(term=power("winding_housing_resistance", -0.3, "speed", 8.0, 0.8)),
}


def levels(rng, time, least, most):
    """A staircase that begins with a rest."""
    values = np.zeros(len(time))
    begin = REST
    while begin < DURATION:
        end = begin + rng.uniform(120.0, 420.0)
        values[(time >= begin) & (time < end)] = rng.uniform(least, most)
        begin = end
    return values


def with_term(program, term, folder):
    """The FMU of a gearmotor with a term."""
    file = folder / "effects.json"
    file.write_text(json.dumps({"format": "motor-fmu effects 1", "terms": [term]}), encoding="utf-8")
    command = [program, "build", "BrushedGearmotor", "--fmi", "3", "--effects", str(file), "--out", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "fmi3" / "BrushedGearmotor.fmu"


def write(program, fmu, name, seed, folder):
    """The files of a case; the path of its experiment."""
    case, rng = (CASES | LAWS)[name], np.random.default_rng(seed)
    fmu = with_term(program, case.term, folder) if case.term else fmu
    truth = {key: value * (1.0 + DEVIATION.get(key, 0.0)) for key, value in START.items()} | case.truth
    settings = [part for key, value in truth.items() if key not in INPUTS.values() for part in ("--set", f"{key}={value}")]
    for k, role in enumerate(ROLES):
        time = np.arange(0.0, DURATION, ROW)
        own = {
            "duty_1": levels(rng, time, 0.3, 0.9) * (-1.0) ** k,
            "supply_voltage_V": np.full(len(time), 24.0),
            "load_torque_Nm": levels(rng, time, 0.3, 3.0) * (-1.0) ** k,
            AMBIENT: 22.0 + k + 0.5 * np.sin(time / 700.0),
        }
        if case.rest:
            still = np.sin(time / 250.0) < 0.0
            own["duty_1"][still] = own["load_torque_Nm"][still] = 0.0
        start = k * (DURATION + 600.0)
        rows = {"time": time + start} | {INPUTS[column]: own[column] for column in INPUTS} | {"ambient_temperature": own[AMBIENT] + KELVIN}
        text = io.StringIO()
        writer = csv.writer(text)
        writer.writerow(rows)
        writer.writerows(zip(*(column.tolist() for column in rows.values()), strict=True))
        times = ["--start", str(start), "--stop", str(start + time[-1]), "--step", str(ROW)]
        outputs = ["--outputs", ",".join(OUTPUTS.values()), "--output", "-"]
        command = [program, "simulate", str(fmu), "--input", "-", *times, *settings, *outputs]
        done = subprocess.run(command, input=text.getvalue(), capture_output=True, text=True, encoding="utf-8")
        assert done.returncode == 0, done.stderr
        seen = list(csv.DictReader(io.StringIO(done.stdout)))
        assert len(seen) == len(time), (len(seen), len(time))
        for column, output in OUTPUTS.items():
            own[column] = np.array([float(row[output]) for row in seen]) - (KELVIN if column.endswith("_degC") else 0.0)
        with (folder / f"run-{k + 1}.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["time_s", *own])
            noisy = [values + NOISE[column] * rng.standard_normal(len(time)) for column, values in own.items()]
            writer.writerows([f"{value:.6g}" for value in row] for row in zip(time + start, *noisy, strict=True))
    lines = [
        "[experiment]",
        f'name = "{name}"',
        'model = "BrushedGearmotor"',
        f'preset = "{PRESET}"',
        f"inputs = {[*INPUTS, AMBIENT]}",
        f"outputs = {[*OUTPUTS]}",
        "[prior]",
        *(f'"{key}" = {value}' for key, value in PRIOR.items()),
        *(f'[[run]]\nfile = "run-{k + 1}.csv"\nrole = "{role}"' for k, role in enumerate(ROLES)),
    ]
    path = folder / "experiment.toml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
