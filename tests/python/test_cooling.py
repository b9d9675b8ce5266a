"""The modes of cooling through the archives, against steady balances with correlations written a second time.

    still air       Churchill, Chu (1975) on the cylinder, laminar plate of height pi D/4 on the ends, grey radiation
    fan across      Churchill, Bernstein (1977) under the ring jet, fourth powers added to natural convection
    within          winding - stator - housing, winding - rotor - housing, leads to ambient, as resistances
"""

import json
from math import pi, sqrt

import pytest
from clients.fmu import FmuError
from scipy.optimize import brentq, fsolve

MODES = {"bare": 2, "fan_crossflow": 3, "annulus_push": 4, "annulus_pull": 5}
POWER, T_A, PRESSURE = 10.0, 297.9, 101325.0
TEST = {"drive_mode": 4, "mechanical_mode": 2, "electrical_power": POWER, "fan_command": 1.0, "ambient_temperature": T_A}


def air(t, p):
    """Density, dynamic viscosity, conductivity, Prandtl number: ideal gas, Sutherland, US Standard Atmosphere 1976."""
    rho, mu = p / (287.053 * t), 1.458e-6 * t**1.5 / (t + 110.4)
    k = 2.64638e-3 * t**1.5 / (t + 245.4 * 10 ** (-12 / t))
    return rho, mu, k, mu * 1006.0 / k


def still(p, t_s):
    """Coefficients on the cylinder, on its ends, and of radiation, W/(m2.K)."""
    rho, mu, k, pr = air(0.5 * (t_s + T_A), PRESSURE)
    film, d = 0.5 * (t_s + T_A), p["housing_diameter"]

    def rayleigh(length):
        return 9.80665 / film * (t_s - T_A) * length**3 * pr * (rho / mu) ** 2

    lateral = (0.60 + 0.387 * rayleigh(d) ** (1 / 6) / (1 + (0.559 / pr) ** (9 / 16)) ** (8 / 27)) ** 2 * k / d
    height = pi / 4 * d
    end = (0.68 + 0.670 * rayleigh(height) ** 0.25 / (1 + (0.492 / pr) ** (9 / 16)) ** (4 / 9)) * k / height
    room = p["housing_emissivity"] * 5.670374419e-8 * (t_s + T_A) * (t_s**2 + T_A**2)
    return lateral, end, room


def blown(p, t_s, natural):
    """Coefficient on the part of the cylinder in the jet, W/(m2.K), and the length of that part, m."""
    rho, mu, k, pr = air(0.5 * (t_s + T_A), PRESSURE)
    d, x, tan = p["housing_diameter"], p["fan_distance"], p["fan_tan_spread"]
    outer, inner = p["fan_bore"] / 2 + x * tan, max(0.0, p["fan_hub"] / 2 - x * tan)
    exit_area = pi / 4 * (p["fan_bore"] ** 2 - p["fan_hub"] ** 2)
    speed = p["fan_flow_max"] / exit_area * (exit_area / (pi * (outer**2 - inner**2))) ** p["fan_decay"]
    re = rho * speed * d / mu
    forced = 0.62 * sqrt(re) * pr ** (1 / 3) / (1 + (0.4 / pr) ** (2 / 3)) ** 0.25 * (1 + (re / 282000) ** 0.625) ** 0.8
    nu = ((p["fan_turbulence_factor"] * forced) ** 4 + (natural * d / k) ** 4) ** 0.25
    return nu * k / d, min(p["housing_length"], 2 * outer)


def steady(p, mode):
    """Winding temperature of the thesis's test, K, with the housing at one temperature."""
    area, ends = pi * p["housing_diameter"] * p["housing_length"], pi / 2 * p["housing_diameter"] ** 2

    def leaving(t_h):
        lateral, end, room = still(p, t_h)
        convection = lateral
        if mode == "fan_crossflow":
            jet, covered = blown(p, t_h, lateral)
            share = covered / p["housing_length"]
            convection = share * jet + (1 - share) * lateral
        return (area * (convection + room) + ends * (end + room)) * (t_h - T_A)

    def balance(t):
        t_w, t_s, t_r, t_h = t
        core, rotor = (t_w - t_s) / p["thermal_R_wh"], p["thermal_G_wr"] * (t_w - t_r)
        stator, bearings = (t_s - t_h) / p["thermal_R_sh"], p["thermal_G_rh"] * (t_r - t_h)
        leads = p["thermal_G_leads"] * (t_w - T_A)
        return POWER - core - rotor - leads, core - stator, rotor - bearings, stator + bearings - leaving(t_h)

    start = brentq(lambda t: leaving(t) - POWER, T_A + 0.1, T_A + 500.0)
    return fsolve(balance, [start + 3, start + 1, start + 2, start], xtol=1e-10)[0]


def parameters(fmu):
    """All parameters of the motor by name; the dots become underscores."""
    names = [v.name for v in fmu.archive.variables.values() if v.causality == "parameter" and "effect" not in v.name]
    return {name.replace(".", "_"): value for name, value in zip(names, fmu.get(*names))}


def show(fmu, name):
    """Reads one variable."""
    (value,) = fmu.get(name)
    return value


def settled(make, mode, step=20.0, **further):
    """The motor of the thesis's test after four hours."""
    fmu = make(TEST, cooling_mode=MODES[mode], **further)
    for _ in range(int(14_400 / step)):
        fmu.step(step)
    return fmu


@pytest.mark.parametrize("mode", ["bare", "fan_crossflow"])
def test_steady_state_is_that_of_the_equations(make, mode):
    """One housing temperature here, eight segments in the FMU; the difference comes from the edge of the jet."""
    fmu = settled(make, mode)
    assert show(fmu, "winding_temperature") == pytest.approx(steady(parameters(fmu), mode), abs=0.15)


@pytest.mark.parametrize("mode", MODES)
def test_the_studies_agree_with_the_archive(make, motor_fmu, mode):
    """`motor-fmu steady` and a long run of the FMU agree within 0.01 K."""
    sets = [f"--set={name}={value}" for name, value in {**TEST, "drive_mode": "power", "mechanical_mode": "imposed_speed"}.items()]
    preset = ("--preset", "maxon-305015", f"--set=cooling_mode={mode}")
    found = json.loads(motor_fmu("steady", *preset, *sets, "--json").stdout)["steady"]["winding_temperature"]
    assert show(settled(make, mode), "winding_temperature") == pytest.approx(found, abs=0.01)


@pytest.mark.parametrize("mode", MODES)
def test_energy_balance_closes_for_every_step(make, mode):
    short, long = settled(make, mode), settled(make, mode, step=600.0)
    for fmu in (short, long):
        assert abs(show(fmu, "power_balance_error")) < 1e-6
        assert abs(show(fmu, "energy_balance_error")) < 1e-6 * show(fmu, "energy_electrical")
        assert show(fmu, "heat_to_ambient") == pytest.approx(POWER, abs=0.02)
    assert show(short, "winding_temperature") == pytest.approx(show(long, "winding_temperature"), abs=1e-3)


def test_one_segment_is_allowed_and_more_than_64_are_refused(make, archive):
    assert show(settled(make, "annulus_push", air_segments=1), "winding_temperature") == pytest.approx(
        show(settled(make, "annulus_push"), "winding_temperature"), abs=0.5
    )
    with pytest.raises(FmuError, match="air_segments = 65"):
        make(TEST, air_segments=65)


def test_an_annulus_that_does_not_pass_the_motor_is_refused(make):
    with pytest.raises(FmuError, match="does not pass the motor"):
        make(TEST, cooling_mode=MODES["annulus_push"], **{"annulus.outer_diameter": 0.03})
