"""`motor-fmu build GaitLoad --load FILE`: torque and speed of the user's own as the load table of the FMU."""

import json
import subprocess
import zipfile

import numpy as np
import pytest
from clients import paths
from clients.fmu import Archive, FmuError
from conftest import STANDARDS
from test_cli_bad_input import CANNOT, one_sentence

PERIOD = 0.8
TIMES = np.array([0.0, 0.05, 0.16, 0.3, 0.42, 0.5, 0.66, 0.73])
TORQUE = np.array([5.0, 40.0, 62.0, -8.0, -30.0, 0.0, 12.0, 9.0])
# A shaft that turns on: 3 rad/s in the mean of the periods.
SPEED = np.array([3.0, 4.5, 1.0, 5.0, 3.5, 2.0, -1.0, 2.5])


def between(values, t):
    return np.interp(t, TIMES, values, period=PERIOD)


def write(folder):
    """The cycle in units and columns of its own; decimal comma, last row equal to the first of the next period."""
    rows = zip(np.append(TIMES, PERIOD) * 1e3, np.append(TORQUE, TORQUE[0]) * 1e3, np.append(SPEED, SPEED[0]) * 30.0 / np.pi)
    lines = [";".join(repr(float(v)).replace(".", ",") for v in row) for row in rows]
    (folder / "press.csv").write_text("clock;M_shaft;rev\n" + "\n".join(lines) + "\n")
    cycle = folder / "press.toml"
    cycle.write_text(
        '[cycle]\nfile = "press.csv"\ntime = { column = "clock", unit = "ms" }\n'
        'torque = { column = "M_shaft", unit = "mN.m" }\nspeed = { column = "rev", unit = "rpm" }\n'
    )
    return cycle


@pytest.fixture(scope="module")
def built(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("load")
    build = [program, "build", "GaitLoad", "--load", write(folder), "--out", folder / "dist"]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder, {fmi: folder / "dist" / f"fmi{fmi}" / "GaitLoad.fmu" for fmi in STANDARDS}


@pytest.mark.parametrize("fmi", STANDARDS)
def test_the_fmu_follows_the_rows(built, fmi):
    angle, work, last = 0.0, 0.0, 0.0
    with Archive(built[1][fmi]) as archive, archive.instance() as load:
        load.initialise({"gait.support": 0.5})
        start = load.get("joint_angle")[0]
        for k in range(1, 60):
            load.step(0.037)
            t = k * 0.037
            fine = np.linspace(last, t, 20001)
            speed, torque = between(SPEED, fine), 0.5 * between(TORQUE, fine)
            angle += np.trapezoid(speed, fine)
            work += np.trapezoid(speed * torque, fine)
            last = t
            found = load.get("torque_demand", "joint_speed", "joint_angle", "energy_demand", "gait_phase")
            expected = (torque[-1], speed[-1], start + angle, work, t / PERIOD % 1.0)
            assert found == pytest.approx(expected, rel=1e-6, abs=1e-6), t


def test_model_exchange_and_both_standards_agree(motor_fmu, built, tmp_path):
    last = {}
    for fmi in STANDARDS:
        for interface in ("cs", "me"):
            table = tmp_path / f"{fmi}{interface}.csv"
            run = ("--stop", "4", "--step", "0.01", "--tolerance", "1e-8", "--interface", interface, "--output", table)
            done = motor_fmu("simulate", built[1][fmi], *run)
            assert done.returncode == 0, done.stderr
            names, *_, row = table.read_text().splitlines()
            last[fmi, interface] = [float(v) for v in row.split(",")]
    assert last[2, "cs"] == last[3, "cs"] and len(names.split(",")) == len(last[2, "cs"])
    assert last[2, "me"] == pytest.approx(last[2, "cs"], rel=1e-5, abs=1e-5)
    assert last[3, "me"] == pytest.approx(last[2, "cs"], rel=1e-5, abs=1e-5)


def test_steady_and_cosim_give_the_same_temperature(motor_fmu, built, tmp_path):
    """The cycle at the joint of an actuator: `steady --load` couples the models, `cosim` the FMUs."""
    folder, archives = built
    carried = folder / "carried.toml"
    carried.write_text(
        (folder / "press.toml").read_text()
        + '[actuator]\n"transmission.ratio" = 150\n"spring.stiffness" = 250\n[motor]\ndrive_mode = "voltage"\nfan_command = 1\n'
    )
    stop = 40 * PERIOD
    done = motor_fmu("steady", "--load", carried, "--preset", "maxon-305015", "--hours", stop / 3600.0, "--json")
    assert done.returncode == 0, done.stderr
    envelope = json.loads(done.stdout)["envelope"]
    system = (paths.EXAMPLES / "systems" / "actuator-gait.toml").read_text()
    system = system.replace("../../dist/fmi2/GaitLoad.fmu", str(archives[2])).replace("../../dist", str(paths.dist().resolve()))
    system = system.replace('"gait.body_mass" = 75', "").replace('"transmission.ratio" = 250', '"transmission.ratio" = 150')
    (tmp_path / "press.toml").write_text(system)
    table = tmp_path / "press.csv"
    done = motor_fmu("cosim", tmp_path / "press.toml", "--stop", stop, "--output", table)
    assert done.returncode == 0, done.stderr
    with table.open() as lines:
        header = lines.readline().strip().split(",")
        rows = np.loadtxt(lines, delimiter=",")
    time, winding = rows[:, 0], rows[:, header.index("motor.winding_temperature")]
    points = [p for p in envelope if p["time"] > 0.5 * stop]
    assert points
    for point in points:
        within = (time > point["time"] - PERIOD) & (time <= point["time"] + 1e-9)
        rise = point["winding_temperature"] - winding[0]
        assert rise > 1.0 and winding[within].max() - winding[0] == pytest.approx(rise, rel=2e-3)


def test_the_archive_says_what_it_carries(motor_fmu, built):
    for path in built[1].values():
        with zipfile.ZipFile(path) as archive:
            table = json.loads(archive.read("resources/load.json"))
            assert len(table["rows"]) == len(TIMES) and "press.csv" in table["source"]
            assert "Load table of this FMU" in archive.read("documentation/index.html").decode()
    done = motor_fmu("info", built[1][2])
    assert "8 rows, period 0.8 s" in done.stdout and "press.csv" in done.stdout, done.stdout


def test_a_model_without_the_table_says_so(motor_fmu, tmp_path):
    with Archive(paths.archive("GaitLoad", 2)) as archive, archive.instance() as load:
        with pytest.raises(FmuError) as refused:
            load.initialise({"gait.activity": "table"})
        assert "motor-fmu build GaitLoad --load" in str(refused.value)
    done = motor_fmu("build", "SeriesElasticActuator", "--load", write(tmp_path), "--out", tmp_path / "dist")
    one_sentence(done, CANNOT, "press.toml", "SeriesElasticActuator has no use", "GaitLoad")
    gait = tmp_path / "gait.toml"
    gait.write_text('[gait]\n"gait.support" = 0.5\n')
    one_sentence(motor_fmu("build", "GaitLoad", "--load", gait, "--out", tmp_path / "dist"), CANNOT, "gait.toml", "[cycle]")
