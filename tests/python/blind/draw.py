"""Draws one set: motor, structure, effect of a size that the data can show, runs, noise; and computes what the data
can show.
"""

from dataclasses import dataclass, field

import numpy as np
from bench.law import CATALOGUE
from bench.rig import AMBIENT, COLUMNS, LAYOUTS, SPEED, TORQUE, WINDING, Rig, draw_units
from bench.write import ROLES
from scipy.optimize import least_squares

from . import cycles, laws, structure
from .network import TERMINAL, Column, Network
from .two_node import TwoNode

NULL, LISTED, FUNCTION, PRODUCT, HIDDEN, MISTAKE = "null", "listed", "function", "product", "hidden", "mistake"
RANDOM = (FUNCTION, PRODUCT, HIDDEN)
RUNS = {3: 0.15, 4: 0.6, 5: 0.25}
DRIVES = {"current": 0.75, "voltage": 0.15, "power": 0.1}
OTHER_MOTOR, WRONG_PRIOR, WARM, STATED = 0.7, 0.25, 0.25, 0.6  # fractions of sets
SCATTER = 2.0  # largest deviation of a specimen, in standard deviations
UNDERSTATED = (0.33, 0.5)  # of the true standard deviation, in a wrong prior
STEP = 0.1  # of a prior, for sensitivities
SMALL = 1e-6  # relative, for the slopes of the nonlinear refit
WIDER = 10.0  # factor on the scatter of specimens in the nonlinear refit
LIMITS = (0.2, 20.0)  # of a parameter there, times the specimen's: a winding without heat capacity is stiff
CONVERGED = {"ftol": 1e-10, "xtol": 1e-9, "gtol": 1e-9}  # of the nonlinear refit
SIGNAL = (3.0, 30.0)  # size of an effect after a refit, in standard deviations of noise and structure error
NONLINEAR = ("stator_node", "demagnetisation", "housing_sensor_lag")  # as drawn
HOTTEST = 180.0  # degC of a winding
VISIBLE = 1.0  # below it, `nothing` is right too
STRONGEST = 3.0  # scale of the pieces of the structure
SAME_DRIVER = 0.98  # explained fraction of a law's variance above which another driver states the same law


@dataclass
class Run:
    """One file: all rows from the start of the simulation; `kept` are those in the file."""

    role: str
    times: np.ndarray
    inputs: dict
    kept: np.ndarray
    warm: bool
    readings: dict = field(default_factory=dict)


@dataclass
class Set:
    name: str
    kind: str
    rig: Rig
    specimen: dict
    prior: dict
    bench: cycles.Bench
    stated: bool
    runs: list
    laws: list
    pieces: dict
    scale: float = 0.0  # of the pieces
    facts: dict = field(default_factory=dict)  # for the truth file
    floor: dict = field(default_factory=dict)
    mistake: dict | None = None
    hottest: float = 0.0  # degC

    @property
    def parameters(self) -> dict:
        return self.rig.nominal | self.specimen


def draw_rig(rng, kind: str, name: str | None) -> Rig:
    possible = [d for d in DRIVES if kind not in RANDOM or d != "power"]
    if name:
        possible = [d for d in possible if LAYOUTS[d].allows(CATALOGUE[name])]
        if CATALOGUE[name].port in TERMINAL and CATALOGUE[name].driver == "current":
            possible = [d for d in possible if d != "voltage"]
    p = np.array([DRIVES[d] for d in possible])
    drive = str(rng.choice(possible, p=p / p.sum()))
    return Rig(LAYOUTS[drive], draw_units(rng) if rng.random() < OTHER_MOTOR else {})


def draw_runs(rng, rig: Rig, warm: bool) -> list:
    roles = ROLES[int(rng.choice(list(RUNS), p=list(RUNS.values())))]
    runs, start = [], 0.0
    for (role,) in roles:
        lead = float(rng.uniform(*cycles.PREHEAT)) if warm and rng.random() < 0.5 else 0.0
        times = cycles.clock(rng, start, lead)
        inputs = cycles.draw_inputs(rng, times, role, rig)
        runs.append(Run(role, times, inputs, times >= start + lead, lead > 0.0))
        start = float(np.ceil(times[-1] + cycles.PAUSE))
    return runs


def impose_voltage(s: Set):
    """The voltage that gives the demanded current in the two-node motor without the effects."""
    made = Network([column(s, k) for k in range(len(s.runs))], "current").simulate()
    for run, one in zip(s.runs, made):
        rest = {c: v for c, v in run.inputs.items() if c != COLUMNS["current"]}
        run.inputs = {COLUMNS["voltage"]: one[COLUMNS["voltage"]]} | rest


def column(s: Set, k: int, moved=None, laws_on=False, scale=0.0, inputs=None) -> Column:
    run = s.runs[k]
    return Column(run.times, inputs or run.inputs, s.parameters | (moved or {}), laws_on, scale, k)


def sigma(s: Set) -> dict:
    """Noise of a reading relative to a model with the measured inputs, by output."""
    p, noise = s.parameters, s.bench.noise
    i, v, w = (noise.get(c, 0.0) for c in (COLUMNS["current"], COLUMNS["voltage"], SPEED))
    through = {COLUMNS["voltage"]: np.hypot(p["motor.k_t"] * w, p["motor.R_ref"] * i), TORQUE: p["motor.k_t"] * i}
    if s.rig.layout.drive == "voltage":
        driven = np.hypot(v, p["motor.k_t"] * w) / p["motor.R_ref"]
        through = {COLUMNS["current"]: driven, TORQUE: p["motor.k_t"] * driven}
    return {c: float(np.hypot(noise[c], through.get(c, 0.0))) for c in s.rig.layout.outputs}


class Refit:
    """Refit of the declared parameters of the two-node motor to the fit runs: linear to a change of the outputs,
    for the sizes of structure and law; nonlinear to the response with structure, for the truth file.
    """

    def __init__(self, s: Set):
        self.s, self.sigma = s, sigma(s)
        self.fit, self.test = ([k for k, run in enumerate(s.runs) if run.role == role] for role in ("fit", "test"))
        runs = [*self.fit, *self.test]
        moved = [{}] + [{n: s.parameters[n] + STEP * p * s.rig.nominal[n]} for n, p in s.prior.items()]
        columns = [column(s, k, m) for m in moved for k in runs] + [column(s, k, scale=1.0) for k in runs]
        made = Network(columns, s.rig.layout.drive, (), s.pieces).simulate()
        groups = [dict(zip(runs, made[n:])) for n in range(0, len(made), len(runs))]
        self.base, self.structured, self.moved = groups[0], groups[-1], groups[1:-1]
        self.slopes = self.slopes_in(self.fit)

    def change(self, one: dict, other: dict, runs) -> list:
        """In standard deviations, an array a channel; simulations by run."""

        def block(c):
            return np.concatenate([(one[k][c] - other[k][c])[self.s.runs[k].kept] for k in runs]) / self.sigma[c]

        return [block(c) for c in self.s.rig.layout.outputs]

    def slopes_in(self, runs):
        return np.column_stack([np.concatenate(self.change(group, self.base, runs)) / STEP for group in self.moved])

    def rms(self, change: list, shift, slopes) -> dict:
        """Per channel, of what a shift of the parameters leaves."""
        rest = np.concatenate(change) - slopes @ shift
        ends = np.cumsum([len(block) for block in change])[:-1]
        return {c: float(np.sqrt(np.mean(part**2))) for c, part in zip(self.s.rig.layout.outputs, np.split(rest, ends))}

    def left(self, one: dict):
        """rms per channel that the refit leaves in the fit runs, and the shift of the parameters in priors."""
        change, size = self.change(one, self.base, self.fit), self.slopes.shape[1]
        bent = np.vstack([self.slopes, np.eye(size)])
        shift = np.linalg.lstsq(bent, np.append(np.concatenate(change), np.zeros(size)), rcond=None)[0]
        return self.rms(change, shift, self.slopes), shift

    def in_test(self, one: dict, shift) -> dict:
        """The same in the test runs, which are hotter and faster."""
        return self.rms(self.change(one, self.base, self.test), shift, self.slopes_in(self.test))

    def simulated(self, scale: float):
        """The noise-free response with structure, by run, and the substeps between its rows."""
        runs = [*self.fit, *self.test]
        network = Network([column(self.s, k, scale=scale) for k in runs], self.s.rig.layout.drive, (), self.s.pieces)
        return dict(zip(runs, network.simulate())), network.substeps(network.table())

    def two_node(self, points, runs, substeps) -> list:
        """For each point (logarithms of the parameters relative to the specimen's) the response, by run."""
        values = [{n: self.s.specimen[n] * float(np.exp(x)) for n, x in zip(self.s.prior, point)} for point in points]
        columns = [column(self.s, k, moved) for moved in values for k in runs]
        made = TwoNode(columns, self.s.rig.layout.drive, substeps).simulate()
        return [dict(zip(runs, made[n:])) for n in range(0, len(made), len(runs))]

    def best(self, response: dict, substeps, start=None):
        """Nonlinear refit to a response in the fit runs; logarithms of the parameters relative to the specimen's.

        The priors are no part of it, because they pull a parameter away from the value that the data give. Where the
        data do not determine a value, the scatter of specimens times `WIDER` keeps the parameter near the specimen's.
        """
        weights = np.diag([1.0 / (WIDER * self.s.rig.prior[n]) for n in self.s.prior])
        cache: dict = {}

        def at(x):
            """Residuals and their slopes, from one simulation."""
            if not np.array_equal(cache.get("x"), x):
                points = np.vstack([x, x + SMALL * np.eye(len(x))])
                simulations = self.two_node(points, self.fit, substeps)
                first, *moved = [np.concatenate(self.change(one, response, self.fit)) for one in simulations]
                slopes = np.column_stack([(one - first) / SMALL for one in moved])
                cache.update(x=x.copy(), rest=np.append(first, weights @ x), slopes=np.vstack([slopes, weights]))
            return cache

        start, limits = np.zeros(len(weights)) if start is None else start, np.log(LIMITS)
        found = least_squares(lambda x: at(x)["rest"], start, lambda x: at(x)["slopes"], limits, **CONVERGED)
        if not found.success:
            raise RuntimeError(f"{self.s.name}: the refit of the two-node model does not converge")
        return found.x

    def remaining(self, response: dict, substeps, x) -> tuple:
        """rms per channel that the two-node model at a point leaves, in the fit runs and in the test runs."""
        made = self.two_node([x], [*self.fit, *self.test], substeps)[0]
        changes = [dict(zip(self.sigma, self.change(made, response, runs))) for runs in (self.fit, self.test)]
        return tuple({c: float(np.sqrt(np.mean(v**2))) for c, v in by.items()} for by in changes)

    def effective(self) -> dict:
        """Facts: parameters of the two-node model that describes the noise-free response best, and its errors."""
        none = dict.fromkeys(self.sigma, 0.0)
        values, fit, test = {n: self.s.specimen[n] for n in self.s.prior}, none, none
        if self.s.scale:
            response, substeps = self.simulated(self.s.scale)
            x = self.best(response, substeps)
            values = {n: v * float(np.exp(d)) for (n, v), d in zip(values.items(), x)}
            fit, test = self.remaining(response, substeps, x)
        return {
            "structure_error": {c: float(f"{v:.3g}") for c, v in fit.items()},
            "structure_error_test": {c: float(f"{v:.3g}") for c, v in test.items()},
            "structure_error_max": float(f"{max(*fit.values(), *test.values()):.3g}"),
            "effective_parameters": values,
        }

    def with_laws(self, effects, scale=0.0) -> dict:
        columns = [column(self.s, k, laws_on=True, scale=scale) for k in self.fit]
        return dict(zip(self.fit, Network(columns, self.s.rig.layout.drive, effects, self.s.pieces).simulate()))


def unit_of(port: str, s: Set) -> float:
    """The nominal quantity of a port, of which a law takes a fraction."""
    p, current = s.rig.nominal, s.rig.scaled(4.4, {"current": 1})
    loss = p["motor.R_ref"] * (0.6 * current) ** 2
    units = {"drag_torque": p["motor.k_t"] * current, "torque_sensor": p["motor.k_t"] * current}
    units |= {"terminal_voltage": p["motor.R_ref"] * current, "winding_heat": loss, "housing_heat": loss}
    return (units | {"housing_ambient_conductance": p["conductance.G_still"] + 0.3 * p["conductance.G_forced"]}).get(
        port, 1.0
    )


def draw_law(rng, s: Set, refit: Refit, name: str | None, noise: dict) -> float:
    """Gives the set a law of a size that the fit runs show: `SIGNAL` times noise and structure error after a refit,
    within what is plausible; returns its size in these units.
    """
    if name:
        law = laws.listed(rng, name, s.rig, len(refit.fit), len(s.runs))
        smallest, largest = 0.5, 2.0
    else:
        seen = [refit.structured[k]["drivers"] for k in refit.fit]
        ranges = {d: (float(min(m[d].min() for m in seen)), float(max(m[d].max() for m in seen))) for d in seen[0]}
        law = laws.random_law(rng, s.kind, s.rig.layout.drive, ranges)
        most = laws.RANDOM[law.port][1] * unit_of(law.port, s)
        law, smallest, largest = law.sized(0.5 * most), 0.02, 2.0
    shown = refit.left(refit.with_laws([law]))[0]
    signal = max(shown[c] / noise[c] for c in shown)
    aim = float(np.exp(rng.uniform(*np.log(SIGNAL))))
    factor = 1.0 if name in NONLINEAR else float(np.clip(aim / max(signal, 1e-9), smallest, largest))
    s.laws = [law.sized(factor)]
    return signal * factor


def same_drivers(s: Set, refit: Refit, made) -> list:
    """Drivers whose best smooth function equals the law's values over the fit runs."""
    law = s.laws[0]
    if law.lag is not None or law.drivers == ("history",):
        return list(law.drivers)
    rows = lambda of: np.concatenate([of(made[k])[s.runs[k].kept] for k in refit.fit])  # noqa: E731
    y = rows(lambda m: m["laws"][0])
    counts = (
        rows(lambda m: m["drivers"]["speed"]) > 4.0 * laws.W_SMALL
        if law.port == "drag_torque"
        else np.full(len(y), True)
    )
    y, found = y[counts], list(law.drivers)
    for name in laws.FIELDS:
        x = rows(lambda m: m["drivers"][name])[counts]  # noqa: B023
        if len(law.drivers) == 1 and name not in found and name != "time" and explained(x, y) > SAME_DRIVER:
            found.append(name)
    return found


def explained(x, y) -> float:
    """Fraction of the variance of y that its mean over 40 equally filled classes of x explains."""
    if len(y) < 80 or float(np.var(y)) == 0.0:
        return 0.0
    order = np.argsort(x)
    groups = np.array_split(y[order], 40)
    return 1.0 - sum(float(np.sum((g - g.mean()) ** 2)) for g in groups) / float(np.sum((y - y.mean()) ** 2))


def draw_set(seed: int, number: int, kind: str, name: str | None = None) -> Set:
    """A set of a kind, with the listed effect `name`; drawn again while some winding would burn."""
    for attempt in range(10):
        s, refit = drawn(np.random.default_rng([seed, number, attempt]), f"blind-{seed}-{number}", kind, name)
        if s.hottest < HOTTEST:
            break
    s.facts |= refit.effective()
    return s


def drawn(rng, title: str, kind: str, name: str | None) -> tuple:
    """A set without the facts of the nonlinear refit, and its refit."""
    if kind == LISTED and not name:
        name = str(rng.choice(list(laws.LISTED)))
    rig = draw_rig(rng, kind, name)
    warm, wrong = bool(rng.random() < WARM), bool(rng.random() < WRONG_PRIOR)
    runs = draw_runs(rng, rig, warm)
    while name and CATALOGUE[name].some_runs and len(runs) < 4:
        runs = draw_runs(rng, rig, warm)
    deviation = {n: float(np.clip(rng.standard_normal(), -SCATTER, SCATTER)) for n in rig.prior}
    specimen = {n: float(rig.nominal[n] * np.exp(rig.prior[n] * d)) for n, d in deviation.items()}
    prior = {
        n: float(f"{v * (rng.uniform(*UNDERSTATED) if wrong and rng.random() < 0.5 else 1.0):.2g}")
        for n, v in rig.prior.items()
    }
    ambiguous = {
        "stator_node": ("stator", "rotor", "end_winding", "housing_ends"),
        "housing_sensor_lag": ("sensor_lag",),
    }
    without = ambiguous.get(name, ()) + (("rotor",) if rig.layout.drive == "power" else ())
    pieces = structure.draw(rng, len(runs), without)
    s = Set(
        title, kind, rig, specimen, prior, cycles.draw_bench(rng, rig), bool(rng.random() < STATED), runs, [], pieces
    )
    if rig.layout.drive == "voltage":
        impose_voltage(s)
    refit = Refit(s)
    aim, (size, shift) = structure.level(rng), refit.left(refit.structured)
    aim = 0.4 * aim if kind == MISTAKE else aim
    tested = refit.in_test(refit.structured, shift)
    s.scale = min(aim / max(*size.values(), *tested.values(), 1e-9), STRONGEST)
    signal = (
        draw_law(rng, s, refit, name, {c: float(np.hypot(1.0, s.scale * v)) for c, v in size.items()})
        if kind in (LISTED, *RANDOM)
        else None
    )
    made = measure(rng, s)
    describe(s, wrong)
    if s.laws:
        s.facts |= {"signal": float(f"{signal:.3g}"), "detectable": bool(signal >= VISIBLE)}
        s.facts["drivers"] = same_drivers(s, refit, made)
        s.facts["ports"] = [s.laws[0].port, *laws.SAME.get(s.laws[0].port, ())]
    return s, refit


def measure(rng, s: Set):
    """Readings of all runs, and the noise floor: the truth's own simulation with the measured inputs, against the
    readings.
    """
    imposed = [{c: cycles.measured(rng, s.bench, run.times, c, v) for c, v in run.inputs.items()} for run in s.runs]
    for run, inputs in zip(s.runs, imposed):
        inputs[AMBIENT][0] = run.inputs[AMBIENT][0]
    columns = [
        column(s, k, laws_on=True, scale=s.scale, inputs=i) for k in range(len(s.runs)) for i in (None, imposed[k])
    ]
    made = Network(columns, s.rig.layout.drive, s.laws, s.pieces).simulate()
    misses: dict = {}
    for k, run in enumerate(s.runs):
        true, floor = made[2 * k], made[2 * k + 1]
        outputs = {c: cycles.measured(rng, s.bench, run.times, c, true[c]) for c in s.rig.layout.outputs}
        run.readings = {c: v[run.kept] for c, v in (imposed[k] | outputs).items()}
        for c in outputs:
            misses.setdefault(run.role, {}).setdefault(c, []).append((floor[c] - outputs[c])[run.kept])
    rms = lambda parts: float(f"{np.sqrt(np.mean(np.concatenate(parts) ** 2)):.4g}")  # noqa: E731
    s.hottest = max(float(m[WINDING].max()) for m in made)
    s.floor = {role: {c: rms(parts) for c, parts in by.items()} for role, by in misses.items()}
    return made[::2]


def describe(s: Set, wrong: bool):
    """Structure, the true statements about it, and whether the prior is wrong."""
    active = s.pieces if s.scale else {}
    ports, ids = structure.true_statements(active)
    s.facts |= {
        "pieces": {n: v if isinstance(v, float) else "offset of each run" for n, v in active.items()},
        "scale": s.scale,
        "true_of_structure": {"ports": ports, "effects": ids},
        "wrong_prior": wrong,
    }
