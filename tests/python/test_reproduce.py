"""`motor-fmu reproduce`, `steady` and `sweep` through the program, against numbers of the audit and hand calculation."""

import csv
import json
import subprocess
import tomllib

import pytest
from clients import seeds
from clients.paths import EXAMPLES

CANNOT = 2

# The audit of the publications: measured T_w, K, and R_ha, K/W; N.m/kg at 5 A.
AUDIT = {
    "bare": (413.17, 11.5, 0.394),
    "fan-5mm": (340.3, 4.03, 0.414),
    "fan-15mm": (342.0, 4.20, 0.413),
    "fan-30mm": (344.5, 4.45, 0.412),
    "annulus-40-push": (343.8, 4.38, 0.393),
    "annulus-35-push": (346.4, 4.65, 0.389),
    "annulus-40-pull": (346.8, 4.69, 0.391),
    "annulus-35-pull": (350.6, 5.07, 0.386),
}


@pytest.fixture(scope="module")
def thesis(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("thesis")
    command = [program, "reproduce", "thesis", "--json", "--out", folder / "pages"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    return json.loads(done.stdout), folder / "pages"


def test_cases(thesis):
    cases = {case["name"]: case for case in thesis[0]["cases"]}
    assert cases.keys() == AUDIT.keys()
    for name, (t_w, r_ha, density) in AUDIT.items():
        case = cases[name]
        assert (case["T_w_measured_K"], case["R_ha_measured"]) == (t_w, r_ha)
        assert case["torque_density_at_5A"] == pytest.approx(density, abs=1e-3)
        assert case["T_w_model_K"] == pytest.approx(t_w, abs=0.5)
        published = {"40": 343.1, "35": 358.3}.get(name.split("-")[1] if name.startswith("annulus") else None)
        assert case["T_w_as_published_K"] == (published and pytest.approx(published, abs=1.0))
    for name, torque in {"bare": 0.108, "fan-5mm": 0.180, "annulus-40-push": 0.173}.items():
        assert cases[name]["torque_at_limit"] == pytest.approx(torque, abs=1e-3)


def test_fit_repeats_the_preset(thesis):
    """The fit from the declared values gives the preset's six fitted values again."""
    start = tomllib.loads((EXAMPLES / "presets" / "thesis-rig.toml").read_text())["start"]
    fitted = thesis[0]["identifiability"]["parameters"]
    assert len(fitted) == 6
    for parameter in fitted:
        assert parameter["value"] == pytest.approx(start[parameter["name"]]["value"], rel=1e-3)
    assert thesis[0]["identifiability"]["rms"] < 0.4


def test_left_out_cases(thesis):
    """All cases except the bare motor are predicted within 2.5 K; the emissivity is known from the bare motor alone, and the output states
    this.
    """
    left_out = {case["case"]: case for case in thesis[0]["leave_one_out"]}
    assert left_out.keys() == AUDIT.keys()
    bare = left_out.pop("bare")
    assert "housing.emissivity" in bare["at_limit"]
    assert all(abs(case["error"]) < 2.5 for case in left_out.values())


def test_predictions_stand_beside_the_fit(thesis):
    """Each case has the leave-one-out prediction; rows say which corrected values are fitted; other causes fit as well."""
    found = thesis[0]
    left_out = {case["case"]: case["predicted"] for case in found["leave_one_out"]}
    for case in found["cases"]:
        assert case["T_w_leave_one_out_K"] == left_out[case["name"]]
        errors = {key: abs(case[f"T_w_{key}_K"] - case["T_w_measured_K"]) for key in ("model", "leave_one_out", "untuned")}
        assert errors["model"] < errors["leave_one_out"], case["name"]
    rms = lambda key: (sum((c[key] - c["T_w_measured_K"]) ** 2 for c in found["cases"]) / len(found["cases"])) ** 0.5  # noqa: E731
    fit, left, untuned = (rms(f"T_w_{key}_K") for key in ("model", "leave_one_out", "untuned"))
    sentence = f"{fit:.1f} K fitted to all tests, {left:.1f} K predicted from the other tests (leave-one-out), {untuned:.1f} K"
    assert any(sentence in finding for finding in found["findings"]), (sentence, found["findings"])
    assert fit < 0.5 and left > 2.0 * fit and untuned > left, sentence
    # Temperature and R_ha of the seven columns of the tables.
    fitted = [row for row in found["rows"] if row["basis"] == "fitted"]
    assert len(fitted) == 14 and all(row["id"].startswith(("T24", "T25")) for row in fitted)
    for row in fitted:
        errors = {key: abs(row[key] / row["measured"] - 1.0) for key in ("corrected", "leave_one_out", "untuned")}
        assert errors["corrected"] < errors["leave_one_out"] and "fitted to" in row["note"], row["id"]
    others = [f for f in found["findings"] if "in place of" in f]
    assert others and all("K)" in f for f in others), found["findings"]


@pytest.mark.parametrize(("folder", "runs"), [("05_thesis", seeds.thesis_runs), ("06_paper", seeds.paper_runs)])
def test_the_runs_of_the_examples_are_those_of_the_publications(thesis, monkeypatch, folder, runs):
    """The stored runs of examples 05 and 06 contain the numbers of `motor-fmu reproduce` and nothing else."""
    monkeypatch.setattr(seeds, "thesis_cases", lambda: thesis[0]["cases"])
    files = runs()
    assert {file.name: file.read_text() for file in (EXAMPLES / folder).glob("*.csv")} == files
    experiment = tomllib.loads((EXAMPLES / folder / "EXPERIMENT.toml").read_text())
    assert sorted(run["file"] for run in experiment["run"]) == sorted(files)


def test_each_run_of_the_thesis_is_set_as_it_was(thesis):
    runs = tomllib.loads((EXAMPLES / "05_thesis" / "EXPERIMENT.toml").read_text())["run"]
    sets = {run["file"]: run["set"] for run in runs}
    for case in thesis[0]["cases"]:
        expected = {"cooling_mode": case["cooling_mode"]} | dict([case["setting"]] if case["setting"] else [])
        assert sets[f"{case['name']}.csv"] == expected, case["name"]


def test_the_paper_separates_fitted_from_predicted(motor_fmu):
    compared = json.loads(motor_fmu("reproduce", "paper", "--json").stdout)["compared"]
    assert {c["used_in_fit"] for c in compared} == {True, False}
    for c in compared:
        assert bool(c["fitted"]) == c["used_in_fit"], c
        if c["used_in_fit"]:
            assert c["simulated"] == pytest.approx(c["published"], rel=0.03), c["quantity"]


def test_pages_stand_alone(thesis):
    page = (thesis[1] / "thesis.html").read_text()
    assert page.count("<svg") == len(list(thesis[1].glob("*.svg"))) >= 7
    assert "src=" not in page and "href=" not in page


def test_paper(motor_fmu):
    paper = json.loads(motor_fmu("reproduce", "paper", "--json").stdout)
    assert paper["voltage"]["total"] == pytest.approx(1.656 + 8.132)
    assert paper["power"]["total"] == pytest.approx(1.7618, abs=1e-4)
    assert paper["work"]["total"] == pytest.approx(1585.7, abs=0.1)
    assert paper["slopes"]["voltage_mV_per_percent"] == pytest.approx(91.62, rel=0.02)
    assert paper["slopes"]["current_mA_per_percent"] == pytest.approx(1.04, rel=0.02)


def test_steady_by_hand(motor_fmu):
    """10 W through R_wh = 0.21 K/W and G = 0.1351 W/K from 298.15 K; stall current of the audit, 5.42 A."""
    done = motor_fmu("steady", "--preset", "maxon-305015", "--set", "electrical_power=10", "--json")
    found = json.loads(done.stdout)
    assert found["steady"]["winding_temperature"] == pytest.approx(298.15 + 10 * (0.21 + 1 / 0.1351), abs=1e-3)
    assert found["R_ha"] == pytest.approx(1 / 0.1351, abs=1e-4)
    assert found["continuous"]["current"] == pytest.approx(5.42, abs=0.01)


def test_sweep(motor_fmu, tmp_path):
    vary = ["--vary", "fan_command=0:1:3", "--vary", "ambient_temperature=290:300:2"]
    files = ["--output", "grid.csv", "--plot", "grid.svg"]
    done = motor_fmu("sweep", *vary, *files, "--set", "electrical_power=10", "--objective", "winding_temperature")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "grid.csv").open()))
    assert len(rows) == 6
    for row in rows:
        to_ambient = 0.1351 + 0.113 * float(row["fan_command"]) ** 0.8
        by_hand = float(row["ambient_temperature"]) + 10 * (0.21 + 1 / to_ambient)
        assert float(row["winding_temperature"]) == pytest.approx(by_hand, abs=1e-3)
    assert "fan_command = 1, ambient_temperature = 290 K" in done.stdout
    assert (tmp_path / "grid.svg").read_text().startswith("<svg")
    # Above the winding's limit: the figure says why a place is empty.
    assert motor_fmu("sweep", "--vary", "ambient_temperature=290,450", "--plot", "hot.svg").returncode == 0
    assert "1 of 2 points infeasible" in (tmp_path / "hot.svg").read_text()


def test_a_motor_without_a_steady_state(motor_fmu):
    """30 A at standstill: the run ends at a limit of validity, and that is an answer and no failure of the command."""
    done = motor_fmu("steady", "--set", "current_command=30")
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert done.returncode == 1 and len(lines) == 1, done.stderr
    assert all(word in lines[0] for word in ("does not settle", "runaway", "validity.winding_temperature = 543.15 K"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["steady", "--set", "motor.R_reff=1"], ["motor.R_reff", "motor.R_ref?"]),
        (["steady", "--set", "motor.R_ref=-1"], ["motor.R_ref = -1 Ohm", "0.0001"]),
        (["steady", "--set", "drive_mode=steam"], ["drive_mode = steam", "current"]),
        (["steady", "--preset", "no-such"], ["no-such", "motor-fmu presets"]),
        (["steady", "--model", "Motor"], ["unknown model Motor"]),
        (["sweep", "--vary", "fan_command=0:2:3"], ["--vary fan_command", "0 ... 1"]),
        (["sweep", "--vary", "fan_command=0:1"], ["--vary", "name=from:to:n"]),
        (["sweep", "--vary", "fan_command=0:1:2", "--objective", "torque"], ["torque"]),
        (["reproduce", "paper", "--out", "/dev/null/x"], ["/dev/null/x", "cannot be written"]),
    ],
)
def test_bad_input(motor_fmu, arguments, words):
    done = motor_fmu(*arguments)
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert done.returncode == CANNOT and len(lines) == 1, done.stderr
    assert all(word in lines[0] for word in words), lines[0]
