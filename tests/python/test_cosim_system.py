"""Motor, actuator and gait as one system: a minute of walking with the native master, from TOML and from its SSP."""

import csv
import json
import re
import zipfile
from math import pi
from pathlib import Path

import fmpy
import pytest
import xmlschema
from clients import paths
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

NAME = "actuator-gait"
EXAMPLE = paths.EXAMPLES / "systems" / f"{NAME}.toml"
# The seconds in which motor and spring, which start at rest, get in step with the leg.
GETTING_IN_STEP = 2.0


@pytest.fixture(scope="session")
def description():
    """The example's text, with the archives that are tested."""
    text, count = re.subn(r'"\.\./\.\./dist/', f'"{paths.dist()}/', EXAMPLE.read_text())
    assert count == 3
    return text


@pytest.fixture
def toml(description, tmp_path):
    path = tmp_path / f"{NAME}.toml"
    path.write_text(description)
    return path


@pytest.fixture
def ssp(motor_fmu, toml):
    done = motor_fmu("ssp", toml)
    assert done.returncode == 0, done.stderr
    return toml.with_suffix(".ssp")


@pytest.fixture
def cosim(motor_fmu):
    """Runs a system and returns the result of `--json`."""

    def run(*arguments):
        done = motor_fmu("cosim", *arguments, "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def rows(path):
    with path.open(newline="") as text:
        return list(csv.DictReader(text))


def test_a_minute_of_walking(cosim, toml, tmp_path):
    result = cosim(toml, "--output", tmp_path / "walk.csv", "--plot", tmp_path / "walk.svg")
    assert result["steps"] == 60_000 and result["rows"] == 60_001
    walk = rows(tmp_path / "walk.csv")
    assert list(walk[0])[:2] == ["time", "gait.joint_angle"] and float(walk[-1]["time"]) == 60.0
    judged = [row for row in walk if float(row["time"]) > GETTING_IN_STEP]
    # An adult's ankle, 75 kg: 103 N.m, followed within a few percent.
    peak = max(float(row["gait.torque_demand"]) for row in judged)
    assert 101.0 < peak < 105.0
    assert max(abs(float(row["actuator.torque_error"])) for row in judged) < 0.05 * peak
    assert result["final"]["motor.winding_temperature"] > 305.0
    assert 50 < result["final"]["gait.strides"] < 60
    assert (tmp_path / "walk.svg").read_text().startswith("<svg")


def test_numbers_have_units_in_and_out(cosim, motor_fmu, toml, tmp_path):
    """--set takes any unit of the quantity; --units datasheet writes display units, named in the header."""
    short = (toml, "--stop", "0.05", "--outputs", "motor.winding_temperature,motor.shaft_speed")
    si = cosim(*short, "--set", "motor.ambient_temperature=308.15", "--set", "motor.motor.J=3.33e-6", "--output", tmp_path / "si.csv")
    sets = ("--set", "motor.ambient_temperature=35 degC", "--set", "motor.motor.J=33.3 g.cm2")
    assert cosim(*short, *sets)["final"] == pytest.approx(si["final"], rel=1e-12)
    out = tmp_path / "datasheet.csv"
    cosim(*short, "--units", "datasheet", "--set", "motor.ambient_temperature=35", *sets[2:], "--output", out)
    shown, plain = rows(out), rows(tmp_path / "si.csv")
    for name, unit, factor, offset in (("winding_temperature", "degC", 1, -273.15), ("shaft_speed", "rpm", 30 / pi, 0)):
        values = [(float(a[f"motor.{name} [{unit}]"]), float(b[f"motor.{name}"])) for a, b in zip(shown, plain)]
        assert all(a == pytest.approx(factor * b + offset, rel=1e-9, abs=1e-9) for a, b in values)
    (tmp_path / "in.csv").write_text("time,motor.ambient_temperature\n0,35\n")
    given = cosim(*short, "--units", "datasheet", "--input", tmp_path / "in.csv", *sets[2:])["final"]
    assert given["motor.winding_temperature"] == pytest.approx(float(shown[-1]["motor.winding_temperature [degC]"]), rel=1e-12)
    done = motor_fmu("cosim", *short, "--set", "motor.ambient_temperature=35 mm")
    assert done.returncode == 2 and "mm" in done.stderr and "ambient_temperature" in done.stderr


@pytest.mark.parametrize("drive", ["voltage", "current"])
def test_the_supply_gives_the_electrical_power(drive, cosim, description, tmp_path):
    """Energy from the supply is the motor's electrical energy in either drive mode, within the coupling error."""
    command = {"voltage": "actuator.voltage -> motor.voltage", "current": "actuator.current_command -> motor.current_command"}
    text = description.replace(command["voltage"], command[drive])
    text = text.replace("fan_command = 1.0", f'fan_command = 1.0\ndrive_mode = "{drive}"')
    path = tmp_path / "drive.toml"
    path.write_text(text)
    for step, error in ((1e-3, 5e-3), (2.5e-4, 5e-4)):
        final = cosim(path, "--stop", "20", "--step", str(step))["final"]
        assert final["motor.energy_electrical"] > 500.0
        assert final["actuator.energy_supply"] == pytest.approx(final["motor.energy_electrical"], rel=error)


def test_energy_closes_over_the_connections(cosim, toml):
    bonds = {bond["forth"]: bond for bond in cosim(toml)["energy"]}
    assert set(bonds) == {
        "gait.joint_speed -> actuator.joint_speed",
        "motor.shaft_speed -> actuator.motor_speed",
        "motor.current -> actuator.motor_current",
    }
    for name, bond in bonds.items():
        assert bond["throughput_J"] > 500.0, name
        assert bond["share"] <= 1e-3, f"{name}: {bond}"
    # What goes to the leg, and what the motor gives at its shaft, as the FMUs themselves have counted it.
    final = cosim(toml)["final"]
    assert bonds["gait.joint_speed -> actuator.joint_speed"]["energy_J"] == pytest.approx(final["actuator.energy_joint"], rel=1e-3)
    assert bonds["motor.shaft_speed -> actuator.motor_speed"]["energy_J"] == pytest.approx(final["actuator.energy_shaft"], rel=2e-3)


def test_the_documented_energies_are_those_of_the_example(cosim, motor_fmu, toml):
    """Table and sentences of docs/co-simulation.md, to the digits that they print; the simulation ends where they say."""
    text = (EXAMPLE.parents[2] / "docs" / "co-simulation.md").read_text(encoding="utf-8")
    part = text.split("Walking ankle (", 1)[1].split("\n## ", 1)[0]
    table = [re.findall(r"([0-9.]+) (?:kJ|%)", line) for line in part.splitlines() if " kJ " in line]
    bonds = cosim(toml, "--stop", "600")["energy"]
    assert len(table) == len(bonds) == 3
    for line, bond in zip(table, bonds):
        for digits, value in zip(line, (1e-3 * bond["throughput_J"], 100.0 * bond["share"], 100.0 * bond["gross_share"])):
            places = len(digits.split(".")[1])
            assert round(value, places) == pytest.approx(float(digits), abs=1.01 * 10.0**-places), (digits, bond)
    held = cosim(toml, "--stop", "600", "--no-input-derivatives")["energy"][0]
    assert f"of the first bond is {100.0 * held['share']:.1f} %" in part
    done = motor_fmu("cosim", toml, "--stop", "1900")
    at = re.search(r"ends at t = (\d+) s", part.replace("\n", " "))
    assert done.returncode == 1 and re.search(rf"ends at {int(at[1]) - 1}\.[0-9]+ s|ends at {at[1]}\.", done.stderr), done.stderr


def test_held_inputs_lose_what_slopes_keep(cosim, toml):
    """Coupling residuals decrease with the step, with twice the order for input derivatives; 0.01 % is out of reach without."""

    def joint(step, *further):
        bonds = cosim(toml, "--stop", "8", "--step", str(step), *further)["energy"]
        return next(bond for bond in bonds if bond["forth"].startswith("gait."))["gross_share"]

    held = [joint(step, "--no-input-derivatives") for step in (1e-3, 2.5e-4)]
    sloped = [joint(step) for step in (1e-3, 2.5e-4)]
    assert held[0] / held[1] == pytest.approx(4.0, rel=0.15)
    assert sloped[0] / sloped[1] == pytest.approx(16.0, rel=0.25)
    assert sloped[0] < 0.05 * held[0]


def test_the_archive_runs_as_the_description_does(motor_fmu, cosim, toml, ssp, tmp_path):
    first, second = tmp_path / "toml.csv", tmp_path / "ssp.csv"
    cosim(toml, "--stop", "3", "--output", first)
    cosim(ssp, "--stop", "3", "--output", second)
    assert first.read_bytes() == second.read_bytes()
    again = tmp_path / "again.ssp"
    assert motor_fmu("ssp", toml, "--out", again).returncode == 0
    assert again.read_bytes() == ssp.read_bytes()


def test_the_archive_is_valid_and_whole(ssp):
    # read_ssd validates it with the standard's schema.
    system = read_ssd(str(ssp), validate=True).system
    assert [component.name for component in system.elements] == ["gait", "motor", "actuator"]
    assert len(system.connections) == 10
    with zipfile.ZipFile(ssp) as archive:
        assert archive.namelist() == [
            "SystemStructure.ssd",
            *(f"resources/{model}.fmu" for model in ("AnnulusCooledMotor", "GaitLoad", "SeriesElasticActuator")),
        ]
        for model in ("AnnulusCooledMotor", "GaitLoad", "SeriesElasticActuator"):
            preset = None if model == "GaitLoad" else "maxon-305015"
            assert archive.read(f"resources/{model}.fmu") == paths.archive(model, 2, preset).read_bytes()


def test_parameters_of_the_system_are_valid_files_that_can_be_exchanged(motor_fmu, cosim, toml, tmp_path):
    """All four files follow the schemas of SSP 1.0; another value in the file of values reaches both variables."""
    toml.write_text(toml.read_text() + '\n[[parameter]]\nname = "warm"\nvalue = 310.0\nset = ["motor.ambient_temperature"]\n')
    ssp = toml.with_suffix(".ssp")
    assert motor_fmu("ssp", toml, "--dictionary").returncode == 0
    schemas = Path(fmpy.__file__).parent / "ssp" / "schema"
    files = {
        "SystemStructure.ssd": "SystemStructureDescription",
        "resources/parameters.ssv": "SystemStructureParameterValues",
        "resources/parameters.ssm": "SystemStructureParameterMapping",
        "resources/signals.ssb": "SystemStructureSignalDictionary",
    }
    other = tmp_path / "other.ssp"
    with zipfile.ZipFile(ssp) as archive, zipfile.ZipFile(other, "w") as changed:
        for name in archive.namelist():
            content = archive.read(name)
            if name in files:
                xmlschema.XMLSchema(str(schemas / f"{files[name]}.xsd")).validate(content.decode())
            assert set(files) < set(archive.namelist())
            changed.writestr(name, content.replace(b'"310"', b'"320"') if name.endswith(".ssv") else content)
    warm = {}
    for system in (toml, ssp, other):
        cosim(system, "--stop", "0.01", "--output", tmp_path / "out.csv")
        warm[system] = float(rows(tmp_path / "out.csv")[0]["motor.winding_temperature"])
    assert warm == {toml: 310.0, ssp: 310.0, other: 320.0}


@pytest.mark.nightly
def test_fmpy_s_own_master_runs_it(cosim, ssp, tmp_path):
    """The master of fmpy transfers values once per step without input derivatives: first order, and the same within that."""
    out = tmp_path / "held.csv"

    def apart(step):
        theirs = simulate_ssp(str(ssp), stop_time=3.0, step_size=step)
        cosim(ssp, "--stop", "3", "--step", step, "--algorithm", "jacobi-delayed", "--no-input-derivatives", "--output", out)
        ours = {round(float(row["time"]) / step): row for row in rows(out)}
        far = 0.0
        for row in theirs:
            # Their row has the values at the end of the step and the time of its start.
            point = round(row["time"] / step) + 1
            if row["time"] > GETTING_IN_STEP and point in ours:
                far = max(far, abs(row["actuator.joint_torque"] - float(ours[point]["actuator.joint_torque"])))
        return far

    coarse, fine = apart(1e-3), apart(2.5e-4)
    assert 0.0 < coarse < 4.0, "of more than 80 N.m"
    assert fine < 0.35 * coarse


def test_a_variable_step_walks_as_well(cosim, toml):
    fixed = cosim(toml, "--stop", "4", "--step", "0.0001")["final"]
    result = cosim(toml, "--stop", "4", "--tolerance", "1e-4")
    assert result["steps"] < 40_000
    for name in ("motor.winding_temperature", "actuator.joint_torque", "actuator.energy_joint"):
        assert result["final"][name] == pytest.approx(fixed[name], rel=2e-3), name


def test_both_standards_walk_alike(cosim, toml, description, tmp_path):
    """With constant inputs FMI 3 gives the bits of FMI 2. Standards can be mixed. FMI 3 takes input derivatives in intermediate update
    mode: its coupling energy residuals are those of FMI 2, and decrease with the square of the step."""
    held, three = (tmp_path / f"{name}.csv" for name in ("held", "three"))
    cosim(toml, "--stop", "2", "--no-input-derivatives", "--output", held)
    fmi3 = tmp_path / "fmi3.toml"
    fmi3.write_text(description.replace("/fmi2/", "/fmi3/"))
    assert cosim(fmi3, "--stop", "2", "--no-input-derivatives", "--output", three)["slopes"] is False
    assert shared(three, held) == shared(held, held)

    def residuals(system, step):
        result = cosim(system, "--stop", "4", "--step", str(step))
        assert result["slopes"] is True
        return result["final"], [bond["gross_share"] for bond in result["energy"]]

    final, coarse = residuals(fmi3, 1e-3)
    final_2, coarse_2 = residuals(toml, 1e-3)
    _, fine = residuals(fmi3, 5e-4)
    assert coarse == pytest.approx(coarse_2, rel=0.01)
    # The first bond, of the joint; the others have not reached the order of the coupling at 1 ms.
    assert coarse[0] / fine[0] == pytest.approx(4.0, rel=0.05)
    assert all(a > 3.0 * b for a, b in zip(coarse, fine))
    for name in ("motor.winding_temperature", "actuator.joint_torque"):
        assert final[name] == pytest.approx(final_2[name], rel=1e-4)
    mixed = tmp_path / "mixed.toml"
    mixed.write_text(description.replace("/fmi2/GaitLoad", "/fmi3/GaitLoad"))
    cosim(mixed, "--stop", "2", "--no-input-derivatives", "--output", three)
    assert three.read_bytes() == held.read_bytes()


def shared(file, columns_of):
    """The cells as text of the columns of both files; FMI 3 has the housing segments as an output."""
    with columns_of.open(newline="") as other:
        names = next(csv.reader(other))
    with file.open(newline="") as rows:
        return [[row[name] for name in names] for row in csv.DictReader(rows)]


@pytest.mark.parametrize("further", [(), ("--algorithm", "jacobi-delayed", "--no-input-derivatives"), ("--tolerance", "1e-3")])
def test_threads_change_no_bit(motor_fmu, toml, tmp_path, further):
    rows = []
    for threads in (1, 2):
        table = tmp_path / f"{threads}.csv"
        done = motor_fmu("cosim", toml, "--stop", 0.5, "--threads", threads, "--output", table, *further)
        assert done.returncode == 0, done.stderr
        rows.append(table.read_bytes())
    assert rows[0] == rows[1] and rows[0].count(b"\n") > 20
