"""The page of the walking study: each conclusion follows from the results that it is given."""

import copy
import importlib.util
import re

import pytest
from clients.paths import EXAMPLES


@pytest.fixture(scope="module")
def study():
    spec = importlib.util.spec_from_file_location("walking_study", EXAMPLES / "08_walking_study.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def answer(study):
    """Results in which the middle of the grid is best, everywhere and for all activities."""
    cell = lambda support, minutes=None, mass=0.3: {  # noqa: E731
        "minutes_to_limit": minutes,
        "continuous_support": support,
        "continuous_torque_Nm": 100.0 * support,
        "limited_by": "winding temperature",
        "mass_kg": mass,
        "gait": "Level walking of adults (source)",
    }
    mass = {name: 0.3 + 0.01 * k for k, name in enumerate(study.ARRANGEMENTS)}
    point = {"ratio": 300.0, "stiffness_Nm_per_rad": 200.0, "support": 1.2, "infeasible": None}
    design = lambda name, k: {  # noqa: E731
        "mass_kg": mass[name],
        "declared": 1.0,
        "best": point | cell(1.2 + 0.1 * k, mass=mass[name]),
        "edges": [],
        "points": [point],
    }
    row = {"ratio": 300.0, "stiffness_Nm_per_rad": 200.0, "support": dict.fromkeys(study.DESIGNED_FOR, 1.1), "infeasible": {}}
    rows = {f"best for {activity}": row for activity in study.DESIGNED_FOR} | {"best in the worst activity": row}
    return {
        "activities": {name: {activity: cell(1.0, mass=mass[name]) for activity in study.ACTIVITIES} for name in study.SHOWN},
        "designs": {name: design(name, k) for k, name in enumerate(study.ARRANGEMENTS)},
        "across_activities": {name: copy.deepcopy(rows) for name in study.SHOWN},
        "pareto_front": list(study.ARRANGEMENTS),
    }


def page(study, answer):
    return " ".join(study.markdown(answer).split())


def test_an_optimum_inside_the_grid_has_no_warning(study, answer):
    text = page(study, answer)
    assert "may lie outside" not in text and "less support" not in text and "infeasible" not in text
    assert "at least the support of the design of `walk.toml` in every activity" in text


def test_an_optimum_at_the_edge_is_flagged(study, answer):
    answer["designs"]["bare"]["edges"] = ["stiffness_Nm_per_rad lower"]
    assert "The best stiffness is at the lower end of the grid for bare: the optimum may lie outside." in page(study, answer)


def test_a_design_that_fails_on_stairs_is_named_with_numbers(study, answer):
    row = answer["across_activities"]["fan at 5 mm"][f"best for {study.LEVEL}"]
    row["support"]["stairs up"] = 0.33
    text = page(study, answer)
    assert "Fan at 5 mm: the best design on level ground, 300 : 1 and 200 N.m/rad, gives less support" in text
    assert "stairs up 33 % instead of 100 %" in text
    row["infeasible"]["stairs up"] = "no continuous torque"
    assert "(infeasible: no continuous torque)" in page(study, answer)


def test_percentages_belong_to_the_design_that_is_printed(study, answer):
    answer["designs"]["bare"]["best"] |= {"support": 1.5, "continuous_torque_Nm": 150.0, "ratio": 375.0}
    answer["designs"]["bare"]["declared"] = 0.5
    assert "bare 150 N.m at 375 : 1 and 200 N.m/rad (+200 %)" in page(study, answer)


def test_deflection_and_front_are_computed(study, answer):
    answer["designs"]["bare"]["best"]["stiffness_Nm_per_rad"] = 1000.0
    text = page(study, answer)
    assert "deflect by 0.12 to" in text
    answer["pareto_front"] = ["bare"]
    assert "front of continuous torque over mass: bare. Not on it:" in page(study, answer)


def test_every_activity_names_its_data(study, answer):
    answer["activities"]["bare"]["stairs down"]["gait"] = "Stairs down, adults (another source)"
    assert "| Stairs down, adults (another source) |" in page(study, answer)
    assert {"walk", "stairs_up", "stairs_down", "child_walk_slow"} <= {a["gait.activity"] for a in study.ACTIVITIES.values()}


def test_the_figure_is_readable_in_a_narrow_column(study, answer, tmp_path):
    from clients.figure import STYLE, words

    study.figure(answer, tmp_path / "f.svg")
    points = float(re.search(r'width="([\d.]+)pt"', (tmp_path / "f.svg").read_text()).group(1))
    assert STYLE["font.size"] * 388.0 / points > 8.5, "text in px where the figure is 388 px wide"
    assert words("motor.winding_temperature") == "Winding temperature, motor"
