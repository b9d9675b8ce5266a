"""cooling_mode annulus_push and annulus_pull through the archives, against a steady model that is written from the sources.

    air             ideal gas, Sutherland, US Standard Atmosphere 1976; c_p by Vincenti and Kruger (1965), ch. IV
    pressure        Shah, J. Fluids Eng. 100 (1978) 177 (laminar entrance), Gnielinski, VDI Heat Atlas, 2nd ed., G2 (turbulent);
                    Kays, Trans. ASME 72 (1950) 1067 with the contraction of a slot by free streamlines
    films           Martin and Gnielinski, VDI Heat Atlas, 2nd ed., G2; both walls of the gap with the same film, exact along each segment
    fan at rest     buoyancy g L (rho_a - rho_gap) upright (Bar-Cohen and Rohsenow 1984), conduction between the cylinders
    tube            grey radiation from the motor, Churchill and Chu (1975) and Le Fevre and Ede (1956) with radiation to ambient
    within          winding - stator - housing, winding - rotor - housing, leads to ambient, as resistances
"""

from math import atan, exp, expm1, log, log10, pi

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

T_A, PRESSURE, POWER, N = 297.0, 101325.0, 10.0, 16
SIGMA, G = 5.670374419e-8, 9.80665
MODES = {"annulus_push": 4, "annulus_pull": 5}
TEST = {"drive_mode": 4, "mechanical_mode": 2, "electrical_power": POWER, "ambient_temperature": T_A}
# D_i/D_o, K, C of the laminar entrance
SHAH = np.array([(0.05, 0.830, 5.0e-5), (0.10, 0.784, 4.3e-5), (0.50, 0.688, 3.2e-5), (0.75, 0.678, 3.0e-5), (1.0, 0.674, 2.9e-5)])


def air(t):
    """Density, viscosity, conductivity, specific heat."""

    def vibration(theta):
        z = theta / t
        return z**2 * exp(z) / expm1(z) ** 2

    c_p = 287.053 * (3.5 * 0.9903 + 2.5 * 0.0097 + 0.7808 * vibration(3390.0) + 0.2095 * vibration(2270.0))
    k = 2.64638e-3 * t**1.5 / (t + 245.4 * 10 ** (-12 / t))
    return PRESSURE / (287.053 * t), 1.458e-6 * t**1.5 / (t + 110.4), k, c_p


def rayleigh(t, length):
    """Rayleigh and Prandtl number and conductivity in the film at a surface in ambient air."""
    film = 0.5 * (t + T_A)
    rho, mu, k, c_p = air(film)
    pr = mu * c_p / k
    return G / film * abs(t - T_A) * length**3 * pr * (rho / mu) ** 2, pr, k


def plate(t, height):
    """Laminar vertical plate, Nusselt number, and its film's Prandtl number and conductivity."""
    ra, pr, k = rayleigh(t, height)
    return 0.68 + 0.670 * ra**0.25 / (1 + (0.492 / pr) ** (9 / 16)) ** (4 / 9), pr, k


def free(t, d, length, upright):
    """Natural convection on the lateral surface of a cylinder, W/(m2.K)."""
    if upright:
        nu, pr, k = plate(t, length)
        return (nu + 4 * (272 + 315 * pr) / (35 * (64 + 63 * pr)) * length / d) * k / length
    ra, pr, k = rayleigh(t, d)
    return (0.60 + 0.387 * ra ** (1 / 6) / (1 + (0.559 / pr) ** (9 / 16)) ** (8 / 27)) ** 2 * k / d


def room(emissivity, t):
    """Radiation to ambient, W/(m2.K)."""
    return emissivity * SIGMA * (t + T_A) * (t**2 + T_A**2)


def slot(sigma):
    """Contraction of the jet behind the edge of a slot."""
    if sigma == 0:
        return pi / (pi + 2)
    return brentq(lambda c: c + 2 / pi * (1 - c**2) * atan(c) - sigma, 0, 1) / sigma


def turbulent_part(re):
    return min(max((re - 2300) / 1700, 0), 1)


class Gap:
    """The gap between motor and tube; lengths in m."""

    def __init__(self, p, push):
        self.d_i, self.d_o, self.length = p["housing_diameter"], p["annulus_outer_diameter"], p["housing_length"]
        self.d_h, self.a, self.push = self.d_o - self.d_i, self.d_i / self.d_o, push
        self.section = pi / 4 * (self.d_o**2 - self.d_i**2)
        self.inner, self.outer = pi * self.d_i * self.length, pi * self.d_o * self.length
        self.sigma = min(1.0, self.section / (pi / 4 * p["fan_bore"] ** 2))
        a, ln = self.a, log(self.a)
        self.phi = ((1 + a**2) * ln + 1 - a**2) / ((1 - a) ** 2 * ln)
        contraction = slot(self.sigma if push else 0.0)
        loss = 1 / contraction**2 - 2 / contraction + 1
        self.loss = 1 - self.sigma**2 + loss if push else loss

    def reynolds(self, m, mu):
        return m * self.d_h / (self.section * mu)

    def fanning(self, re):
        def entrance(re):
            x = self.length / self.d_h / re
            k, c = (np.interp(self.a, SHAH[:, 0], SHAH[:, n]) for n in (1, 2))
            steep = 3.44 / x**0.5
            return (steep + (16 / self.phi + k / (4 * x) - steep) / (1 + c / x**2)) / re

        def developed(re):
            return max(0.25 / (1.8 * log10(re * self.phi) - 1.5) ** 2, entrance(re))

        g = turbulent_part(re)
        return entrance(re) if g == 0 else developed(re) if g == 1 else (1 - g) * entrance(2300) + g * developed(4000)

    def drop(self, m, t):
        """Pressure that a mass flow takes, Pa, air at the mean temperature t."""
        rho, mu, _, _ = air(t)
        u, re = m / (rho * self.section), max(self.reynolds(m, mu), 1e-9)
        loss = self.loss
        if not self.push:
            momentum = 1.2 + turbulent_part(re) * (1 + 0.04 * (max(re, 4000) / 1e4) ** -0.2 - 1.2)
            loss += 1 - 2 * momentum * self.sigma + self.sigma**2
        return rho * u**2 / 2 * (loss + 4 * self.fanning(re) * self.length / self.d_h)

    @property
    def nu_developed(self):
        return 3.66 + 1.2 * self.a**-0.8

    def nusselt(self, re, pr, x):
        """Mean over the first x hydraulic diameters."""

        def laminar(re):
            gz = re * pr / x
            nu_2 = 1.615 * (1 + 0.14 * self.a**-0.5) * gz ** (1 / 3)
            return (self.nu_developed**3 + nu_2**3 + ((2 / (1 + 22 * pr)) ** (1 / 6) * gz**0.5) ** 3) ** (1 / 3)

        def turbulent(re):
            f = (1.8 * log10(re * self.phi) - 1.5) ** -2 / 8
            k_1 = 1.07 + 900 / re - 0.63 / (1 + 10 * pr)
            nu = f * re * pr * 0.75 * self.a**-0.17 / (k_1 + 12.7 * f**0.5 * (pr ** (2 / 3) - 1))
            return nu * (1 + x ** (-2 / 3))

        g = turbulent_part(re)
        return laminar(re) if g == 0 else turbulent(re) if g == 1 else (1 - g) * laminar(2300) + g * turbulent(4000)


def operating_flow(p, gap, command, t, buoyancy):
    """Flow at which the fan and the buoyancy give what the gap takes, m3/s; the fan's curve is a line."""
    rho = air(T_A)[0]

    def surplus(q):
        fan = rho / p["fan_density_ref"] * p["fan_pressure_max"] * command * (command - q / p["fan_flow_max"])
        return fan + buoyancy(rho * q) - gap.drop(rho * q, t)

    return brentq(surplus, 0.0, 2 * p["fan_flow_max"], xtol=1e-12) if surplus(0.0) > 0 else 0.0


def mean_air(wall, ntu):
    """Mean temperature of air that approaches a wall."""
    return T_A + (wall - T_A) * (1 - (1 - exp(-ntu)) / ntu)


def gap_air(p, gap, command, t_h, t_t, upright):
    """Flow, m3/s, its heat capacity, W/K, and the conductance of both films along each segment, W/K."""
    rho, both = air(T_A)[0], gap.inner + gap.outer
    wall = (t_h * gap.inner + t_t * gap.outer) / both
    t, q = T_A, 0.0
    for _ in range(12):
        _, mu, k, c_p = air(t)
        pr = mu * c_p / k

        def film(m):
            return gap.nusselt(gap.reynolds(m, mu), pr, gap.length / gap.d_h) * k / gap.d_h

        def buoyancy(m):
            if not upright:
                return 0.0
            return G * gap.length * (rho - air(mean_air(wall, film(m) * both / max(m * c_p, 1e-12)))[0])

        q = operating_flow(p, gap, command, t, buoyancy)
        stream = rho * q * c_p
        t = mean_air(t_h, film(rho * q) * gap.inner / max(stream, 1e-12))
    edges = np.linspace(1e-12, gap.length / gap.d_h, N + 1)
    total = [x * gap.nusselt(gap.reynolds(rho * q, mu), pr, x) for x in edges]
    films = np.diff(total) / edges[-1] * k / gap.d_h * both
    # Air that hardly moves conducts between the cylinders in place of two developed films.
    developed, ratio = gap.nu_developed * k / gap.d_h * both, gap.inner / both
    rest = 2 * pi * gap.length * air(0.5 * (t_h + t_t))[2] / log(gap.d_o / gap.d_i)
    films += (rest / (ratio * (1 - ratio)) - developed) * exp(-stream * gap.d_h**2 / (k * gap.section * gap.length)) / N
    return q, stream, films


def steady(p, mode, command, upright):
    """Winding and mean housing temperature, K, and flow, m3/s."""
    gap = Gap(p, mode == "annulus_push")
    ratio = gap.inner / (gap.inner + gap.outer)
    wall = min(p["housing_thickness"], gap.d_i / 2)
    axial = p["housing_conductivity"] * pi * (gap.d_i - wall) * wall * N / gap.length
    facing = 1 / p["housing_emissivity"] + gap.inner / gap.outer * (1 / p["annulus_emissivity"] - 1)
    fan = p["fan_power"] * command**3 * air(T_A)[0] / p["fan_density_ref"] if mode == "annulus_push" else 0.0

    def balance(t):
        t_w, t_s, t_r, t_t, housing = t[0], t[1], t[2], t[3], t[4:]
        t_h = housing.mean()
        q, stream, films = gap_air(p, gap, command, t_h, t_t, upright)
        cold = T_A + (fan / stream if fan > 0 else 0.0)
        to_air, tube_to_air = np.empty(N), 0.0
        for k in range(N):
            surface = t_t + ratio * (housing[k] - t_t)
            taken = stream * -expm1(-films[k] / max(stream, 1e-12)) * (surface - cold)
            to_air[k] = ratio * (films[k] * (housing[k] - surface) + taken)
            tube_to_air += (1 - ratio) * (films[k] * (t_t - surface) + taken)
            cold += taken / max(stream, 1e-12)
        radiated = SIGMA * (t_h + t_t) * (t_h**2 + t_t**2) / facing * gap.inner / N * (housing - t_t)
        outside = (free(t_t, gap.d_o, gap.length, upright) + room(p["annulus_emissivity"], t_t)) * gap.outer * (t_t - T_A)
        core, rotor, leads = (t_w - t_s) / p["thermal_R_wh"], p["thermal_G_wr"] * (t_w - t_r), p["thermal_G_leads"] * (t_w - T_A)
        stator, bearings = (t_s - housing) / (N * p["thermal_R_sh"]), p["thermal_G_rh"] / N * (t_r - housing)
        gain = stator + bearings - to_air - radiated
        along = axial * np.diff(housing)
        gain[:-1] += along
        gain[1:] -= along
        nu, _, k_end = plate(t_h, pi / 4 * gap.d_i)
        end = pi / 4 * gap.d_i**2 * (nu * k_end / (pi / 4 * gap.d_i) + room(p["housing_emissivity"], t_h))
        gain[[0, -1]] -= end * (housing[[0, -1]] - T_A)
        nodes = POWER - core - rotor - leads, core - stator.sum(), rotor - bearings.sum(), radiated.sum() - tube_to_air - outside
        return np.r_[nodes, gain], q

    start = np.full(4 + N, T_A + (40.0 if command > 0 else 110.0))
    start[3] = T_A + 15.0
    t = fsolve(lambda t: balance(t)[0], start, xtol=1e-9)
    return t[0], t[4:].mean(), balance(t)[1]


def parameters(fmu):
    """All parameters of the motor by name; the dots become underscores."""
    names = [v.name for v in fmu.archive.variables.values() if v.causality == "parameter" and "effect" not in v.name]
    return {name.replace(".", "_"): value for name, value in zip(names, fmu.get(*names))}


CASES = [(0.040, 1.0, False), (0.035, 0.6, False), (0.040, 0.0, False), (0.040, 0.0, True), (0.040, 0.1, True)]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("outer, command, upright", CASES)
def test_steady_state_is_that_of_the_sources(make, mode, outer, command, upright):
    further = {"annulus.outer_diameter": outer, "housing.orientation": 2 if upright else 1}
    fmu = make(TEST, cooling_mode=MODES[mode], fan_command=command, air_segments=N, **further)
    for _ in range(120):
        fmu.step(120.0)
    found = fmu.get("winding_temperature", "housing_temperature", "air_flow_rate")
    winding, housing, flow = steady(parameters(fmu), mode, command, upright)
    np.testing.assert_allclose(found[:2], (winding, housing), atol=0.1, rtol=0)
    assert found[2] == pytest.approx(flow, rel=0.015, abs=1e-9)
