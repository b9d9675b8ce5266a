"""cooling_mode water_jacket through the archives, against a steady model that is written from the sources.

    water           Perry's handbook, 9th ed., table 2-135 (saturated liquid), interpolated
    tube            Gnielinski, VDI Heat Atlas, 2nd ed., G1 (laminar, developing), Int. J. Heat Mass Transfer 63 (2013) 134 (transition, turbulent)
    stream          dT/dx = G' (T_h - T)/C along a housing of 60 segments with conduction along its wall
    ends            Churchill, Chu (1975), grey radiation
    within          winding - stator - housing, winding - rotor - housing, leads to ambient, as resistances
"""

from math import exp, log10, pi

import numpy as np
import pytest
from clients.fmu import FmuError
from scipy.optimize import fsolve

T_A, POWER, N = 297.0, 80.0, 60
MODES = {"drive_mode": 4, "mechanical_mode": 2, "cooling_mode": 6, "electrical_power": POWER, "ambient_temperature": T_A}
MOLAR = 18.015268e-3
# T in K, mol/dm3, J/(mol.K), mW/(m.K), uPa.s
TABLE = np.array(
    [
        (280, 55.501, 75.688, 574.04, 1433.7),
        (290, 55.440, 75.429, 592.73, 1084.0),
        (300, 55.315, 75.320, 610.28, 853.84),
        (310, 55.139, 75.294, 626.05, 693.54),
        (320, 54.919, 75.317, 639.71, 577.02),
        (330, 54.662, 75.373, 651.18, 489.49),
        (340, 54.371, 75.456, 660.55, 421.97),
        (350, 54.049, 75.567, 668.00, 368.77),
        (360, 53.698, 75.708, 673.76, 326.10),
        (370, 53.321, 75.883, 678.02, 291.36),
    ]
)


def water(t):
    """Density, specific heat, viscosity, conductivity."""
    near = np.argsort(np.abs(TABLE[:, 0] - t))[:4]

    def interpolated(column):
        x, y = TABLE[near, 0], TABLE[near, column]
        return sum(y[k] * np.prod([(t - x[j]) / (x[k] - x[j]) for j in range(4) if j != k]) for k in range(4))

    return interpolated(1) * 1e3 * MOLAR, interpolated(2) / MOLAR, interpolated(4) * 1e-6, interpolated(3) * 1e-3


def nusselt(re, pr, d_over_l):
    """Mean over the length, wall of uniform temperature."""

    def laminar(re):
        gz = re * pr * d_over_l
        nu_2, nu_3 = 1.615 * gz ** (1 / 3), (2 / (1 + 22 * pr)) ** (1 / 6) * gz**0.5
        return (3.66**3 + 0.7**3 + (nu_2 - 0.7) ** 3 + nu_3**3) ** (1 / 3)

    def turbulent(re):
        xi = (1.8 * log10(re) - 1.5) ** -2
        nu = xi / 8 * (re - 1000) * pr / (1 + 12.7 * (xi / 8) ** 0.5 * (pr ** (2 / 3) - 1))
        return nu * (1 + d_over_l ** (2 / 3))

    if re < 2300:
        return laminar(re)
    if re > 4000:
        return turbulent(re)
    gamma = (re - 2300) / 1700
    return (1 - gamma) * laminar(2300) + gamma * turbulent(4000)


def friction(re):
    """Darcy's factor of a smooth tube."""
    xi = (1.8 * log10(max(re, 4000)) - 1.5) ** -2
    gamma = min(max((re - 2300) / 1700, 0), 1)
    return 64 / re if re < 2300 else (1 - gamma) * 64 / 2300 + gamma * xi


def jacket(p, flow, inlet, surface):
    """Conductance, W/K, heat capacity of the flow, W/K, pressure drop, Pa, with properties at the mean temperature of the water."""
    d, length = p["hydraulic_diameter"], p["channel_length"]
    speed = flow / (p["channels"] * pi / 4 * d**2)
    mean, last = inlet, 0.0
    while abs(mean - last) > 1e-9:
        rho, c_p, mu, k = water(mean)
        re = rho * speed * d / mu
        g = nusselt(re, mu * c_p / k, d / length) * k / d * p["wetted_area"]
        stream = water(inlet)[0] * flow * c_p
        last, mean = mean, surface - (surface - inlet) * stream / g * (1 - exp(-g / stream))
    return g, stream, (friction(re) * length / d + p["loss_coefficient"]) * rho * speed**2 / 2


def end_conductance(p, t):
    """One end of the motor in still air, W/K."""
    film, height = 0.5 * (t + T_A), pi / 4 * p["diameter"]
    mu = 1.458e-6 * film**1.5 / (film + 110.4)
    k = 2.64638e-3 * film**1.5 / (film + 245.4 * 10 ** (-12 / film))
    rho, pr = 101325.0 / (287.053 * film), mu * 1006.0 / k
    rayleigh = 9.80665 / film * abs(t - T_A) * height**3 * pr * (rho / mu) ** 2
    convection = (0.68 + 0.670 * rayleigh**0.25 / (1 + (0.492 / pr) ** (9 / 16)) ** (4 / 9)) * k / height
    radiation = p["emissivity"] * 5.670374419e-8 * (t + T_A) * (t**2 + T_A**2)
    return pi / 4 * p["diameter"] ** 2 * (convection + radiation)


def steady(p, flow, inlet):
    """Winding, mean housing and outlet temperature, K, pressure drop, Pa."""
    wall = min(p["thickness"], p["diameter"] / 2)
    axial = p["conductivity"] * pi * (p["diameter"] - wall) * wall * N / p["length"]

    def balance(t):
        t_w, t_s, t_r, housing = t[0], t[1], t[2], t[3:]
        g, stream, drop = jacket(p, flow, inlet, housing.mean())
        taken = 1 - exp(-g / stream / N)
        to_water, cold = np.empty(N), inlet
        for k in range(N):
            to_water[k] = stream * taken * (housing[k] - cold)
            cold += taken * (housing[k] - cold)
        core, rotor, leads = (t_w - t_s) / p["R_wh"], p["G_wr"] * (t_w - t_r), p["G_leads"] * (t_w - T_A)
        stator, bearings = (t_s - housing) / (N * p["R_sh"]), p["G_rh"] / N * (t_r - housing)
        gain = stator + bearings - to_water
        along = axial * np.diff(housing)
        gain[:-1] += along
        gain[1:] -= along
        for end in (0, -1):
            gain[end] -= end_conductance(p, housing.mean()) * (housing[end] - T_A)
        return np.r_[POWER - core - rotor - leads, core - stator.sum(), rotor - bearings.sum(), gain], cold, drop

    t = fsolve(lambda t: balance(t)[0], np.full(3 + N, inlet + 30.0), xtol=1e-10)
    _, outlet, drop = balance(t)
    return t[0], t[3:].mean(), outlet, drop


def parameters(fmu):
    """Parameters of motor and jacket by the last part of their name."""
    groups = ("thermal.", "housing.", "jacket.")
    names = [v.name for v in fmu.archive.variables.values() if v.causality == "parameter" and v.name.startswith(groups)]
    return {name.split(".")[1]: value for name, value in zip(names, fmu.get(*names)) if name != "jacket.mass"}


def settled(make, flow, inlet, **further):
    """The motor after two hours."""
    fmu = make(MODES, coolant_flow_rate=flow, coolant_inlet_temperature=inlet, **further)
    for _ in range(240):
        fmu.step(30.0)
    return fmu


# Channels with Re from 60 to 20,000: laminar, in the transition, turbulent.
@pytest.mark.parametrize("inlet", [283.15, 313.15, 338.15])
@pytest.mark.parametrize("flow", [1e-6, 1e-5, 4e-5, 6e-5, 2e-4])
def test_steady_state_is_that_of_the_sources(make, flow, inlet):
    fmu = settled(make, flow, inlet)
    winding, housing, outlet, drop = steady(parameters(fmu), flow, inlet)
    names = ("winding_temperature", "housing_temperature", "coolant_outlet_temperature")
    np.testing.assert_allclose(fmu.get(*names), (winding, housing, outlet), atol=0.1, rtol=0)
    assert fmu.get("coolant_pressure_drop")[0] == pytest.approx(drop, rel=0.01)
    pump, error = fmu.get("pump_power", "power_balance_error")
    assert pump == pytest.approx(drop * flow, rel=0.01) and abs(error) < 1e-6


def test_a_jacket_of_another_size(make):
    """A long helix of two channels around a larger motor."""
    further = {
        "jacket.hydraulic_diameter": 0.006,
        "jacket.channel_length": 1.2,
        "jacket.channels": 2,
        "jacket.wetted_area": 0.02,
        "housing.diameter": 0.06,
        "housing.length": 0.12,
    }
    fmu = settled(make, 3e-5, 300.0, **further)
    found = fmu.get("winding_temperature", "housing_temperature", "coolant_outlet_temperature")
    np.testing.assert_allclose(found, steady(parameters(fmu), 3e-5, 300.0)[:3], atol=0.1, rtol=0)


def test_a_pump_that_fails(make):
    """Without flow the water takes nothing and the winding heats up towards its limit; all outputs stay finite."""
    fmu = settled(make, 2e-5, 300.0)
    fmu.set({"coolant_flow_rate": 0.0})
    before = fmu.get("winding_temperature")[0]
    fmu.step(60.0)
    winding, outlet, housing, heat = fmu.get(
        "winding_temperature", "coolant_outlet_temperature", "housing_temperature", "heat_to_coolant"
    )
    assert winding > before + 20.0 and heat == 0.0
    assert outlet == pytest.approx(housing, abs=2.0)


@pytest.mark.parametrize(("name", "value"), [("coolant_flow_rate", -1e-6), ("coolant_inlet_temperature", 270.0)])
def test_impossible_coolant_is_refused(make, name, value):
    with pytest.raises(FmuError, match=name):
        make(MODES, **{name: value})
