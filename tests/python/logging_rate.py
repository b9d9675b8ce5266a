"""A bench experiment as loggers of different rates record it: a two-node motor with one more effect, independent of the Rust code.

The motor is that of `tests/reference/bench-synthetic/SOURCE.md`. Its loads change in ramps of six seconds, or in steps, or alternate within a
gait cycle; readings have white noise.
"""

import json
from dataclasses import dataclass, field

import numpy as np

PRIOR = {
    "motor.R_ref": 0.05,
    "motor.k_t": 0.05,
    "thermal.R_wh": 0.15,
    "thermal.C_w": 0.15,
    "thermal.C_h": 0.1,
    "conductance.G_still": 0.1,
    "conductance.G_forced": 0.15,
    "effect.coulomb_friction.tau_c": 0.3,
}
TRUE = {
    "motor.R_ref": 0.400,
    "motor.k_t": 0.0268,
    "thermal.R_wh": 0.235,
    "thermal.C_w": 11.0,
    "thermal.C_h": 160.0,
    "conductance.G_still": 0.145,
    "conductance.G_forced": 0.105,
    "effect.coulomb_friction.tau_c": 0.0085,
}
INPUTS = {"current_A": 0.008, "speed_rad_per_s": 0.02, "fan_command_1": 0.0, "ambient_temperature_degC": 0.05}
OUTPUTS = {
    "voltage_V": 0.015,
    "shaft_torque_Nm": 0.0004,
    "winding_temperature_degC": 0.12,
    "housing_temperature_degC": 0.08,
}
COLUMNS = {**INPUTS, **OUTPUTS}  # with the standard deviation of the noise
VISCOUS, RADIATION = "effect.viscous_friction.k", "effect.housing_radiation.k"
CONVECTION, DROP, LAG = "effect.speed_convection.G", "effect.contact_drop.V_b", "effect.housing_sensor_lag.tau"
FINE = 0.02  # step of the integration, s
KELVIN, SMALL_CURRENT, SLOW = 273.15, 0.05, 10  # rows of which a slow thermocouple reads one


@dataclass
class Case:
    """What is true, and how it is recorded."""

    effect: dict
    rates: tuple  # Hz, of each run
    duration: float = 1800.0
    noise: float = 1.0  # relative to COLUMNS
    ramp: float = 6.0
    hold: tuple = (120.0, 420.0)
    gait: float = 0.0  # duration of a cycle, s
    quanta: dict = field(default_factory=dict)
    slow: bool = False  # one thermocouple reads every tenth row, the other repeats its reading
    jitter: bool = False
    gap: bool = False
    warm: bool = False


CASES = {
    "viscous friction, 10 Hz": Case({VISCOUS: 1e-5}, (10, 10, 10)),
    "no effect, 10 Hz": Case({}, (10, 10, 10)),
    "radiation, 20 Hz, noise in proportion": Case({RADIATION: 8e-10}, (20, 20, 20), noise=40.0**0.5, duration=3000.0),
    "contact drop, gait of 1 s, 50 Hz": Case({DROP: 0.3}, (50, 50, 50), gait=1.0, duration=720.0, hold=(60.0, 180.0)),
    "sensor lag, 10 Hz, slow thermocouples": Case({LAG: 60.0}, (10, 10, 10), slow=True, duration=2400.0),
    "speed convection, 10 Hz, quanta": Case(
        {CONVECTION: 0.05},
        (10, 10, 10),
        duration=2400.0,
        quanta={"winding_temperature_degC": 0.1, "housing_temperature_degC": 0.5},
    ),
    "contact drop, 10 Hz beside 0.5 Hz": Case({DROP: 0.25}, (10, 0.5, 10), duration=2400.0),
    "viscous friction, 10 Hz, irregular": Case({VISCOUS: 1.2e-5}, (10, 10, 10), jitter=True, duration=2400.0),
    "viscous friction, 10 Hz, steps and a gap": Case({VISCOUS: 1.2e-5}, (10, 10, 10), ramp=0.1, hold=(40.0, 160.0), gap=True),
    "speed convection, 10 Hz, warm": Case({CONVECTION: 0.05}, (10, 10, 10), warm=True),
}


def loads(case, seed, times):
    """Current, speed and fan over time."""
    draw = np.random.default_rng(seed)
    at, levels = [0.0, 2.0], [(0.0, 0.0, 0.0)] * 2
    while at[-1] < times[-1]:
        current = draw.choice([0, 1.5, 3, 4, 5, 6], p=[0.1, 0.12, 0.18, 0.2, 0.2, 0.2]) * draw.choice([-1, 1], p=[0.3, 0.7])
        speed = draw.choice([0, 60, 150, 300, 450]) * draw.choice([-1, 1], p=[0.3, 0.7])
        levels += [(current, speed, draw.choice([0.0, 0.0, 0.3, 0.6, 1.0]))] * 2
        at += [at[-1] + case.ramp, at[-1] + case.ramp + draw.uniform(*case.hold)]
    current, speed, fan = (np.interp(times, at, column) for column in np.array(levels).T)
    if case.gait:
        # Corners at tenths of the cycle, so that rows at 10 Hz and at 50 Hz have them.
        swing = np.interp(times / case.gait % 1, [0, 0.1, 0.4, 0.5, 0.6, 0.9, 1], [0, 1, 1, 0, -1, -1, 0])
        current, speed = current * (0.15 + swing), np.abs(speed) * (0.7 + 0.3 * np.roll(swing, 5))
    return current, speed, fan, 22.5 + 0.5 * np.sin(2 * np.pi * times / 4000 + seed)


def motor(effect, times, current, speed, fan, ambient, start):
    """Outputs of the true motor: Heun's method in steps of FINE, inputs linear between them."""
    true = {**TRUE, **effect}
    lag, drop = true.get(LAG, 0.0), true.get(DROP, 0.0) * np.tanh(current / SMALL_CURRENT)
    drag = true["effect.coulomb_friction.tau_c"] * np.tanh(speed) + true.get(VISCOUS, 0.0) * speed
    conductance = true["conductance.G_still"] + true.get(CONVECTION, 0.0) * (np.abs(speed) / 100) ** 0.8
    conductance = conductance + true["conductance.G_forced"] * fan**0.8
    across, radiation = true["thermal.R_wh"], true.get(RADIATION, 0.0)
    capacities = true["thermal.C_w"], true["thermal.C_h"]
    square, brushes, friction = (x.tolist() for x in (true["motor.R_ref"] * current**2, drop * current, drag * speed))

    def rates(k, winding, housing, shown):
        heat = square[k] * (1 + 0.0039 * (winding - 25)) + brushes[k]
        through = (winding - housing) / across
        off = cooling[k] * (housing - room[k]) + radiation * ((housing + KELVIN) ** 4 - (room[k] + KELVIN) ** 4)
        follows = (housing - shown) / lag if lag else 0.0
        return (heat - through) / capacities[0], (through + friction[k] - off) / capacities[1], follows

    cooling, room = conductance.tolist(), ambient.tolist()
    state, all_states = (*start, start[1]), []
    for k, h in enumerate(np.append(np.diff(times), 0.0).tolist()):
        all_states.append(state)
        first = rates(k, *state)
        then = rates(min(k + 1, len(room) - 1), *(x + h * d for x, d in zip(state, first)))
        state = tuple(x + 0.5 * h * (a + b) for x, a, b in zip(state, first, then))
    winding, housing, shown = np.array(all_states).T
    k_t = true["motor.k_t"] * (1 - 0.0012 * (housing - 25))
    voltage = true["motor.R_ref"] * (1 + 0.0039 * (winding - 25)) * current + k_t * speed + drop
    return voltage, k_t * current - drag, winding, shown if lag else housing


def recorded(case, number, seed):
    """Columns of one run with their times."""
    fine = np.arange(round(case.duration / FINE) + 1) * FINE
    driven = loads(case, seed + number, fine)
    start = [(70.0, 62.0), (45.0, 45.0), (58.0, 55.0)][number] if case.warm else (driven[3][0], driven[3][0])
    exact = (*driven, *motor(case.effect, fine, *driven, start))
    draw = np.random.default_rng([seed, number])
    rate = case.rates[number]
    times = np.arange(round(case.duration * rate) + 1) / rate
    if case.jitter:
        times[1:-1] += draw.uniform(-0.4, 0.4, len(times) - 2) / rate
        times = times[np.r_[True, draw.random(len(times) - 2) > 0.07, True]]
    if case.gap and number == 0:
        times = times[np.abs(times - 0.5 * case.duration) > 50.0]
    read = {"time_s": times}
    for (column, noise), values in zip(COLUMNS.items(), exact):
        read[column] = np.interp(times, fine, values) + case.noise * noise * draw.standard_normal(len(times))
        if column in case.quanta:
            read[column] = np.round(read[column] / case.quanta[column]) * case.quanta[column]
    if case.slow and rate > 1:
        place = np.arange(len(times))
        read["winding_temperature_degC"][place % SLOW != 3] = np.nan
        read["housing_temperature_degC"] = read["housing_temperature_degC"][place // SLOW * SLOW]
    return read


def write(case, seed, folder):
    """The experiment: two runs that are fitted and a test run."""
    lines = ["[experiment]", 'name = "logging rate"', 'model = "AnnulusCooledMotor"', 'preset = "maxon-305015"']
    lines += [f"inputs = {json.dumps(list(INPUTS))}", f"outputs = {json.dumps(list(OUTPUTS))}", "[prior]"]
    lines += [f'"{name}" = {deviation}' for name, deviation in PRIOR.items()]
    for number, role in enumerate(("fit", "fit", "test")):
        read = recorded(case, number, seed)
        rows = np.column_stack(list(read.values()))
        name = f"run-{number + 1}.csv"
        text = "\n".join(",".join("" if x != x else f"{x:.7g}" for x in row) for row in rows.tolist())
        (folder / name).write_text(f"{','.join(read)}\n{text}\n", encoding="utf-8")
        lines += ["[[run]]", f'file = "{name}"', f'role = "{role}"', *(['start = "measured"'] if case.warm else [])]
    path = folder / "experiment.toml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
