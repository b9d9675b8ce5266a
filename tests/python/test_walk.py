"""`motor-fmu steady --load` and `sweep --load`: the motor under gait, through the command."""

import json

import pytest
from clients.paths import EXAMPLES

LOAD = str(EXAMPLES / "loads" / "walk.toml")
PRESET = ("--preset", "maxon-305015")
CANNOT = 2


def ask(motor_fmu, *arguments):
    done = motor_fmu("steady", *PRESET, "--load", LOAD, *arguments, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_walk_ends_at_the_windings_limit(motor_fmu, tmp_path):
    plot = tmp_path / "walk.svg"
    cold = ask(motor_fmu, "--plot", plot)
    assert cold["forever"] is None and 600.0 < cold["time_to_limit"] < 1200.0
    last = cold["envelope"][-1]
    assert last["winding_temperature"] > cold["limit"] and last["time"] == pytest.approx(cold["time_to_limit"], abs=2.0)
    assert "<svg" in plot.read_text() and "winding" in plot.read_text()
    assert 0.3 < cold["continuous"]["support"] < 0.8 and cold["continuous"]["limited_by"] == "winding_temperature"
    # Peaks, rms and powers also where there is no steady state.
    assert cold["at_limit"]["current_rms"] > 5.0 and cold["at_limit"]["joint_torque_peak"] == pytest.approx(1.37 * 75.0, rel=0.02)
    assert "adults" in cold["gait"] and "Grimmer" in cold["gait"]
    assert 0.0 <= cold["limit"] - cold["continuous"]["at"]["winding_temperature"] < 0.05


def test_cooling_and_less_torque_have_a_steady_state(motor_fmu):
    fan = ask(motor_fmu, "--set", "fan_command=1", "--set", "gait.support=0.6")
    assert fan["time_to_limit"] is None
    assert fan["forever"]["winding_temperature"] < fan["limit"]
    assert 0.0 < fan["forever"]["power_joint"] < fan["forever"]["power_electrical"]
    # Mean power from the supply is the motor's electrical power, although the motor follows a current.
    assert fan["forever"]["power_supply"] == pytest.approx(fan["forever"]["power_electrical"], rel=6e-3)
    derived = {d["name"]: d["value"] for d in fan["derived"]}
    assert derived["control.k_t"] == 0.0276 and derived["control.tau_c"] == 9.83e-3
    cold = ask(motor_fmu, "--set", "fan_command=1", "--set", "gait.support=0.6", "--set", "ambient_temperature=273.15")
    assert cold["forever"]["winding_temperature"] < fan["forever"]["winding_temperature"] - 10.0


def test_a_sweep_walks(motor_fmu, tmp_path):
    table = tmp_path / "sweep.csv"
    arguments = ("--vary", "transmission.ratio=200:300:2", "--vary", "fan_command=0:1:2", "--output", table, "--json")
    done = motor_fmu("sweep", *PRESET, "--load", LOAD, *arguments)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["objective_unit"] == "N.m" and len(found["points"]) == 4
    torque = {tuple(p["values"]): p["objective"] for p in found["points"]}
    assert torque[200.0, 1.0] > 1.2 * torque[200.0, 0.0] and torque[300.0, 0.0] > torque[200.0, 0.0]
    assert {edge["name"]: edge["end"] for edge in found["best_at_edge"]} == {"transmission.ratio": "upper"}, "1 is the limit of fan_command"
    assert found["infeasible"] == 0 and "adults" in found["source"]
    assert len(table.read_text().splitlines()) == 5


@pytest.mark.parametrize(
    ("text", "arguments", "words"),
    [
        ("[gait]\n\"gait.activity\" = \"fly\"\n", (), ("gait.toml:2", "fly", "stairs_up")),
        ("[leg]\n", (), ("gait.toml:1", "leg", "[actuator]")),
        ("[gait\n", (), ("gait.toml:1",)),
        ("# nothing\n", (), ("gait.toml", "is empty", "[cycle]")),
        ("[gait]\n", ("--set", "gait.body_mas=80"), ("gait.body_mas",)),
        ("[gait]\n", ("--set", "gait.body_mass=-1"), ("gait.body_mass = -1 kg", "500")),
        ("[gait]\n", ("--set", "cycle.scale=2"), ("cycle.scale", "no [cycle]")),
        ("[gait]\n", ("--set", "drive_mode=power"), ("drive_mode", "voltage or current")),
        ("[gait]\n", ("--hours", "0"), ("hours",)),
        ("", ("--model", "BrushedGearmotor"), ("BrushedGearmotor",)),
        (None, (), ("gait.toml", "cannot be read")),
    ],
)
def test_bad_loads_are_one_sentence(text, arguments, words, motor_fmu, tmp_path):
    file = tmp_path / "gait.toml"
    if text is not None:
        file.write_text(text)
    done = motor_fmu("steady", "--load", file, *arguments)
    assert done.returncode == CANNOT and done.stderr.count("\n") == 1, done.stderr
    assert all(word in done.stderr for word in words), done.stderr


def test_an_objective_of_a_walk_is_named(motor_fmu):
    done = motor_fmu("sweep", "--load", LOAD, "--vary", "fan_command=0:1:2", "--objective", "happiness")
    assert done.returncode == CANNOT and "continuous_support" in done.stderr, done.stderr


def write_cycle(folder, name="cycle.csv"):
    """Half a second of constant torque forth and back, in units of its own."""
    rows = [f"{k * 10};{(60.0 if k < 25 else -20.0)};{1200.0}" for k in range(51)]
    (folder / name).write_text("t [ms];M;n\n" + "\n".join(rows).replace(".", ",") + "\n")
    load = folder / "load.toml"
    load.write_text(
        f'[cycle]\nfile = "{name}"\ntime = "t"\ntorque = {{ column = "M", unit = "mN.m" }}\nspeed = {{ column = "n", unit = "rpm" }}\n'
    )
    return load


def test_a_cycle_from_a_file(motor_fmu, tmp_path):
    load = write_cycle(tmp_path)
    done = motor_fmu("steady", *PRESET, "--load", load, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)["forever"]
    assert found["joint_torque_peak"] == pytest.approx(0.06) and found["voltage_peak"] > 0.0276 * 125.0
    # Cold torque constant and friction: (60 + 9.8) and (-20 + 9.8) mN.m over 27.6 mN.m/A, within the magnets' 5 %.
    assert found["current_rms"] == pytest.approx(((69.8**2 + 10.2**2) / 2) ** 0.5 / 27.6, rel=0.05)
    text = motor_fmu("steady", *PRESET, "--load", load).stdout
    assert "continuous factor" in text and "voltage, peak" in text and "cycle.csv" in text
    done = motor_fmu("steady", *PRESET, "--load", load, "--set", "gait.support=1")
    assert done.returncode == CANNOT and "gait.support" in done.stderr and len(done.stderr.splitlines()) == 1


def test_a_mix_rests(motor_fmu, tmp_path):
    load = write_cycle(tmp_path)
    mixed = tmp_path / "mix.toml"
    mixed.write_text(load.read_text() + '[mix]\nperiod = "20 s"\nphase = [{ fraction = "50 %" }, { fraction = 0.5, rest = true }]\n')

    def factor(file):
        done = motor_fmu("steady", *PRESET, "--load", file, "--hours", "0.05", "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)["continuous"]["support"]

    assert factor(mixed) > 1.15 * factor(load)


def test_a_sweep_over_motors_and_modes_has_a_pareto_set(motor_fmu, tmp_path):
    load = write_cycle(tmp_path)
    vary = ("--vary", "preset=maxon-305015,maxon-re40-148877", "--vary", "cycle.scale=0.5,1,4", "--vary", "fan_command=0:1:2")
    goals = ("--objective", "continuous_torque", "--objective", "supply_power", "--constraint", "winding_temperature<=150 degC")
    done = motor_fmu("sweep", "--load", load, *vary, *goals, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert [o["least_is_best"] for o in found["objectives"]] == [False, True]
    assert len(found["points"]) == 12 and 0 < found["infeasible"] < 12
    for point in found["points"]:
        beaten = any(
            o["objectives"] and point["objectives"] and o != point
            and o["objectives"][0] >= point["objectives"][0] and o["objectives"][1] <= point["objectives"][1]
            for o in found["points"]
        )  # fmt: skip
        assert point["pareto"] == (point["failure"] is None and not beaten), point
    text = motor_fmu("sweep", "--load", load, *vary, *goals).stdout
    assert "Pareto set" in text and "minimum of supply_power" in text and "constraint: winding_temperature <= 150 degC" in text
    assert f"{found['infeasible']} of 12 points infeasible\n  preset = " in text
    assert all(point["failure"] in text for point in found["points"] if point["failure"])


def test_a_sweep_that_cannot_be_drawn_ends_before_it_computes(motor_fmu, tmp_path):
    load = write_cycle(tmp_path)
    vary = ("--vary", "fan_command=0,1", "--vary", "cycle.scale=0.5,0.6,0.7", "--vary", "ambient_temperature=290:300:3")
    done = motor_fmu("sweep", "--load", load, *vary, "--objective", "supply_power", "--plot", "f.svg", "--output", "f.csv")
    assert done.returncode == CANNOT and "9, at most 8" in done.stderr and not (tmp_path / "f.csv").exists()
    drawn = ("--vary", "fan_command=0,1", "--vary", "cycle.scale=0.5,0.6", "--vary", "ambient_temperature=290:300:2")
    done = motor_fmu("sweep", "--load", load, *drawn, "--objective", "supply_power", "--plot", "f.svg")
    assert done.returncode == 0, done.stderr
    assert "cycle scale = 0.5, ambient temperature = 290" in (tmp_path / "f.svg").read_text()
