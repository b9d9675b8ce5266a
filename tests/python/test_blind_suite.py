"""The blind suite: its motor against the two-node generator and its own energy balance, its laws, its mistakes, its
judgement.
"""

from copy import deepcopy

import numpy as np
import pytest
from bench.effects import CATALOGUE
from bench.generator import simulate
from bench.rig import COLUMNS, LAYOUTS, PUBLIC, SPEED, TORQUE, WINDING
from blind import cycles, draw, files, laws, mistakes
from blind.network import Column, Network
from blind.two_node import TwoNode

# The suite itself runs at night.
pytestmark = pytest.mark.nightly

SEED = 4


def short_run(monkeypatch, rig=PUBLIC):
    """25 minutes at 10 s."""
    monkeypatch.setattr(cycles, "DURATION", (1500.0, 1501.0))
    monkeypatch.setattr(cycles, "SAMPLING", {10.0: 1.0})
    rng = np.random.default_rng(SEED)
    times = cycles.clock(rng, 0.0, 0.0)
    inputs = cycles.draw_inputs(rng, times, "fit", rig)
    assert np.ptp(inputs[COLUMNS["current"]]) > 1.0 and np.ptp(inputs[SPEED]) > 100.0
    return times, inputs


def test_without_structure_the_network_is_the_two_node_motor(monkeypatch):
    times, inputs = short_run(monkeypatch)
    for name in ("iron_loss", "stator_node", "housing_radiation", "contact_drop", "housing_sensor_lag"):
        effect = CATALOGUE[name].typical()
        law = laws.listed(np.random.default_rng(1), name, PUBLIC, 1, 2)
        law = laws.replace(law, parameters=effect.parameters)
        network = Network([Column(times, inputs, PUBLIC.nominal)], "current", [law])
        made, expected = network.simulate()[0], simulate({}, [effect], times, inputs).outputs
        for column, values in expected.items():
            scale = 0.1 if column.endswith("degC") else 0.02 if column == COLUMNS["voltage"] else 1e-3
            assert np.max(np.abs(made[column] - values)) < 0.1 * scale, (name, column)


@pytest.mark.parametrize("drive", LAYOUTS)
def test_the_fast_two_node_motor_is_the_network_without_structure(monkeypatch, drive):
    times, inputs = short_run(monkeypatch)
    nominal, current = PUBLIC.nominal, inputs.pop(COLUMNS["current"])
    voltage = nominal["motor.R_ref"] * current + nominal["motor.k_t"] * inputs[SPEED]
    inputs[COLUMNS[drive]] = {"current": current, "voltage": voltage, "power": 3.0 * np.abs(current)}[drive]
    moved = [{}, {"thermal.R_wh": 1.5 * nominal["thermal.R_wh"]}, {"motor.alpha": 0.003, "motor.k_t": 0.02}]
    # The second run is shorter.
    runs = [(times[:rows], {c: v[:rows] for c, v in inputs.items()}) for rows in (len(times), 90)]
    columns = [Column(*run, nominal | one) for one in moved for run in runs]
    expected = Network(columns, drive).simulate()
    assert np.ptp(expected[0][WINDING]) > 5.0
    for one, other in zip(TwoNode(columns, drive).simulate(), expected):
        for column in LAYOUTS[drive].outputs:
            assert np.allclose(one[column], other[column], rtol=1e-12, atol=1e-11), column


@pytest.mark.parametrize("extra", [(), ("stator_node",), ("iron_loss", "contact_drop")])
def test_energy_is_conserved_with_every_piece_of_structure(monkeypatch, extra):
    times, inputs = short_run(monkeypatch)
    pieces = {
        "end_winding": 0.5,
        "stator": 0.8,
        "rotor": 1.0,
        "housing_ends": -0.5,
        "convection": 1.0,
        "fan_exponent": 0.1,
        "grease": 0.5,
    }
    effects = [laws.listed(np.random.default_rng(1), name, PUBLIC, 1, 2) for name in extra]
    network = Network([Column(times, inputs, PUBLIC.nominal, structure=1.0)], "current", effects, pieces)
    made = network.simulate()[0]
    assert np.ptp(made[TORQUE]) > 0.01
    assert abs(network.kept - network.balance)[0] < 1e-4 * abs(network.kept)[0]


@pytest.fixture(scope="module")
def small():
    """A set with a lagged law and structure error, of short runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cycles, "DURATION", (900.0, 901.0))
        patch.setattr(cycles, "SAMPLING", {10.0: 1.0})
        patch.setattr(draw, "DRIVES", {"current": 1.0})
        patch.setattr(draw, "WARM", 1.0)
        return draw.draw_set(SEED, 0, draw.HIDDEN)


def texts(s):
    return [files.experiment(s), *(files.csv(s, k) for k in range(len(s.runs)))]


def test_the_truth_file_states_what_the_set_has(small):
    stated = files.truth(small)
    law = stated["law"]
    assert (
        law["lag_s"] == small.laws[0].lag
        and stated["ports"][0] == law["port"]
        and law["drivers"][0] in stated["drivers"]
    )
    assert stated["signal"] > 0.0 and set(stated["floor"]) == {"fit", "validate", "test"}
    # The floor is at least the noise of the sensor, less the scatter of few rows.
    assert all(v > 0.7 * small.bench.noise[c] for c, v in stated["floor"]["fit"].items())
    text = files.experiment(small)
    assert text.count('start = "measured"') == sum(run.warm for run in small.runs) > 0
    for k, run in enumerate(small.runs):
        lines = files.csv(small, k).splitlines()
        assert len(lines) == 1 + run.kept.sum() and float(lines[1].split(",")[0]) == pytest.approx(
            run.times[run.kept][0]
        )


def test_the_law_changes_the_readings_by_its_size(small):
    """The difference of the simulations with and without the law is that of the truth file, after the linear refit of
    the parameters.
    """
    refit = draw.Refit(small)
    shown, shift = refit.left(refit.with_laws(small.laws))
    none, still = refit.left(refit.with_laws([]))
    # The number of substeps depends on the other columns.
    assert (
        max(none.values()) < 1e-4
        and np.all(np.abs(still) < 1e-4)
        and max(refit.in_test(refit.base, still).values()) < 1e-4
    )
    assert 0.5 * small.facts["signal"] < max(shown.values()) < 20.0 * small.facts["signal"] and np.any(shift)


def squares(refit, response, substeps, x) -> float:
    made = refit.two_node([x], refit.fit, substeps)[0]
    return sum(float(np.sum(block**2)) for block in refit.change(made, response, refit.fit))


def test_without_structure_the_best_two_node_model_is_the_specimen(small):
    refit = draw.Refit(small)
    response, substeps = refit.simulated(0.0)
    x = refit.best(response, substeps, start=np.linspace(-0.3, 0.4, len(small.prior)))
    assert np.max(np.abs(x)) < 1e-6 and max(max(by.values()) for by in refit.remaining(response, substeps, x)) < 1e-4
    still = deepcopy(small)
    still.scale = 0.0
    facts = draw.Refit(still).effective()
    assert facts["structure_error_max"] == 0.0
    assert facts["effective_parameters"] == files.truth(small)["parameters"]


def test_the_best_two_node_model_is_the_converged_nonlinear_refit(small):
    """Structure like a strongly insulated end winding: R_wh far from the specimen's, nearly no residual."""
    strong = deepcopy(small)
    strong.pieces, strong.scale = {"end_winding": 0.6}, 1.5
    refit = draw.Refit(strong)
    response, substeps = refit.simulated(strong.scale)
    x = refit.best(response, substeps)
    found = dict(zip(strong.prior, np.exp(x)))
    assert found["thermal.R_wh"] > 1.5
    # One linear step with the priors, which the size of the structure error is aimed with.
    shift = refit.left(response)[1]
    step = [d * p * strong.rig.nominal[n] / strong.specimen[n] for d, (n, p) in zip(shift, strong.prior.items())]
    left = squares(refit, response, substeps, x)
    linear = np.log1p(step)
    assert left < 0.5 * squares(refit, response, substeps, linear)
    # Neither further iterations nor another start change the values.
    for start in (x, linear, x + 0.1):
        assert np.allclose(refit.best(response, substeps, start), x, rtol=0.0, atol=2e-5)
    for k in range(len(x)):
        for move in (-1e-3, 1e-3):
            assert squares(refit, response, substeps, x + move * np.eye(len(x))[k]) > left
    facts = refit.effective()
    expected = {n: v * strong.specimen[n] for n, v in found.items()}
    assert facts["effective_parameters"] == pytest.approx(expected, rel=1e-6)
    fit, test = refit.remaining(response, substeps, x)
    assert facts["structure_error"] == pytest.approx(fit, rel=1e-2)
    assert facts["structure_error_max"] == pytest.approx(max(*fit.values(), *test.values()), rel=1e-2)


@pytest.mark.parametrize("name", mistakes.ALL)
def test_a_mistake_is_in_the_files_and_names_its_channel(small, name):
    spoiled = deepcopy(small)
    rng = np.random.default_rng(3)
    spoiled.mistake = mistakes.draw(rng, spoiled, name)
    before, after = texts(small), texts(spoiled)
    assert before != after and set(spoiled.mistake["answers"]) <= {"unusable", "set aside", "refused", "works", "note"}
    columns = {"time_s", "", *small.rig.layout.inputs, *small.rig.layout.outputs}
    assert columns.issuperset(spoiled.mistake["channels"])
    assert all(run.readings.keys() == other.readings.keys() for run, other in zip(small.runs, spoiled.runs))
