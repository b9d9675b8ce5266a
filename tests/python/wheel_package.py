"""The wheel of `cargo xtask wheel` in a fresh environment without Rust; run by `cargo xtask nightly`.

Not part of the everyday tests, because the environment takes packages from the network.
"""

import json
import os
import shutil
import subprocess
import sys

import pytest
from clients import paths

PACKAGES = ("fmpy==0.3.32", "numpy==2.2.6", "pandas==2.3.3")
SCRIPT = """
import json, sys
import fmpy, motor_fmu
from pathlib import Path

found = {}
presets = motor_fmu.presets()
found["presets"] = sorted(presets["name"])
built = motor_fmu.build("AnnulusCooledMotor", preset="maxon-re25-118752", fmi=3, out="built")
found["built"] = [str(path) for path in built]
result = fmpy.simulate_fmu(str(built[0]), stop_time=0.5, start_values={"voltage": 12.0}, output=["shaft_speed"])
found["fmpy"] = float(result["shaft_speed"][-1])
ours = motor_fmu.simulate(built[0], stop=0.5, step=1e-3, settings={"voltage": 12.0})
found["simulate"] = float(ours["shaft_speed"].iloc[-1])
steady = motor_fmu.steady(preset="maxon-re25-118752", settings={"imposed_speed": 100.0})
found["torque"] = steady["continuous"]["torque"]
points = motor_fmu.sweep({"ambient_temperature": (280.0, 320.0, 3)}, preset="maxon-re25-118752", settings={"imposed_speed": 100.0})
found["sweep"] = points.iloc[:, -1].tolist()
found["columns"] = list(points.columns)
found["archives"] = [motor_fmu.archive(m, fmi).is_file() for m in ("GaitLoad", "BrushedGearmotor") for fmi in (2, 3)]
report = motor_fmu.close_loop(sys.argv[1], out="closed")
found["verdict"] = [report["verdict"], report["effects"][0]["id"]]
for name, call in {
    "preset": lambda: motor_fmu.steady(preset="maxon-re25"),
    "value": lambda: motor_fmu.steady(settings={"motor.R_ref": -1}),
    "archive": lambda: motor_fmu.archive("Motor"),
}.items():
    try:
        call()
    except motor_fmu.MotorFmuError as error:
        found[name] = [str(error), error.code]
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What a script finds in a fresh environment that has the wheel, and no Rust on its path."""
    wheels = sorted(paths.dist().glob("motor_fmu-*.whl"))
    assert len(wheels) == 1, f"{paths.dist()}: {wheels}; run `cargo xtask wheel`"
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    bin = folder / "venv" / "bin"
    subprocess.run([bin / "python", "-m", "pip", "install", "--quiet", wheels[0], *PACKAGES], check=True)
    experiment = paths.ROOT / "tests" / "reference" / "bench-synthetic" / "iron-loss" / "experiment.toml"
    environment = {"PATH": f"{bin}:/usr/bin:/bin", "HOME": str(folder), "LANG": "C.UTF-8"}
    assert shutil.which("cargo", path=environment["PATH"]) is None
    done = subprocess.run(
        [bin / "python", "-c", SCRIPT, experiment], cwd=folder, env=environment, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr
    version = subprocess.run([bin / "motor-fmu", "--version"], env=environment, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1]) | {"version": version.stdout}


def test_an_fmu_from_a_preset_runs_in_fmpy(found):
    assert found["built"] == [os.path.join("built", "fmi3", "AnnulusCooledMotor.fmu")]
    assert found["simulate"] == pytest.approx(found["fmpy"], rel=1e-6) and found["fmpy"] > 100


def test_studies_return_numbers(found, motor_fmu):
    native = json.loads(motor_fmu("steady", "--json", "--preset", "maxon-re25-118752", "--set", "imposed_speed=100").stdout)
    assert found["torque"] == native["continuous"]["torque"]
    assert found["columns"][0] == "ambient_temperature" and len(found["sweep"]) == 3
    assert found["sweep"] == sorted(found["sweep"], reverse=True)
    assert json.loads(motor_fmu("presets", "--json").stdout) and "maxon-re25-118752" in found["presets"]
    assert found["archives"] == [True] * 4


def test_the_loop_is_closed(found):
    assert found["verdict"] == ["named", "iron_loss"]


def test_errors_are_sentences(found):
    assert found["preset"][0].startswith("preset maxon-re25 is neither") and found["preset"][1] == 2
    assert "motor.R_ref" in found["value"][0] and found["value"][1] == 2
    assert "AnnulusCooledMotor" in found["archive"][0]
    assert found["version"].strip()
