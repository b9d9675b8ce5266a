//! The five modes of cooling by air against values computed here from the energy balance, with no function of the product but the one
//! under test: air from a table, correlations and pressure losses written out once more, the operating point by bisection.
//!
//! *Sources*: Incropera et al., 7th ed. (table A.4; eqs. 9.34, 7.54, 9.64, 13.20), Gnielinski, VDI Heat Atlas, 2nd ed.,
//! G2 (annuli) and Int. J. Heat Mass Transfer 63 (2013) 134 (transition), Shah and London (1978) for the pressure drop
//! of the entrance, von Mises (1917) for the contraction of a plane jet, Kays (1950) for contraction and expansion, Churchill and Usagi for mixing.

use crate::common::motor;
use physics::models::annulus_cooled_motor::cooling::{Conditions, Cooling};
use physics::models::annulus_cooled_motor::{
    AnnulusCooledMotor, CoolingMode, DriveMode, Inputs, MechanicalMode,
};
use std::f64::consts::PI;

/// Segments of the housing.
const N: usize = 8;
const SIGMA: f64 = 5.67e-8;
/// Ambient and housing, K: the thesis's room, and a housing 42 K above it.
const AMBIENT: f64 = 298.0;
const SURFACE: f64 = 340.0;
const TUBE: f64 = 305.0;

/// Properties of air at 1 bar: density, specific heat, viscosity, conductivity, Prandtl number.
struct Air {
    rho: f64,
    c_p: f64,
    mu: f64,
    k: f64,
    pr: f64,
}

/// Incropera, table A.4, linear between 250, 300 and 350 K; density by the gas law from the row of 300 K.
fn air(t: f64) -> Air {
    const TABLE: [[f64; 5]; 3] = [
        [250.0, 1006.0, 159.6e-7, 22.3e-3, 0.720],
        [300.0, 1007.0, 184.6e-7, 26.3e-3, 0.707],
        [350.0, 1009.0, 208.2e-7, 30.0e-3, 0.700],
    ];
    let row = if t < 300.0 { 0 } else { 1 };
    let (a, b) = (TABLE[row], TABLE[row + 1]);
    let at = |k: usize| a[k] + (b[k] - a[k]) * (t - a[0]) / (b[0] - a[0]);
    Air { rho: 1.1614 * 300.0 / t, c_p: at(1), mu: at(2), k: at(3), pr: at(4) }
}

/// The motor at its declared geometry in this mode, and its coefficients at these conditions.
fn cooled(mode: CoolingMode, change: impl Fn(&mut AnnulusCooledMotor)) -> AnnulusCooledMotor {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.parameters.choices.cooling_mode = mode;
    m.parameters.thermal.G_mount = 0.0;
    change(&mut m);
    m
}

fn conditions(command: f64) -> Conditions {
    let inputs = Inputs { ambient_pressure: 1e5, fan_command: command, ..Inputs::default() };
    Conditions::of(&inputs, SURFACE, TUBE, AMBIENT)
}

#[track_caller]
fn near(got: f64, want: f64, relative: f64, what: &str) {
    assert!((got - want).abs() <= relative * want.abs(), "{what}: {got} and {want} by the book");
}

/// Natural convection on the horizontal motor, W/(m2.K).
fn lying_cylinder(d: f64) -> f64 {
    natural_on_cylinder(d, SURFACE)
}

/// Natural convection on a horizontal cylinder at `t`, eq. 9.34, W/(m2.K).
fn natural_on_cylinder(d: f64, t: f64) -> f64 {
    let film = air(0.5 * (t + AMBIENT));
    let nu = film.mu / film.rho;
    let alpha = film.k / (film.rho * film.c_p);
    let ra = 9.81 * 2.0 / (t + AMBIENT) * (t - AMBIENT) * d.powi(3) / (nu * alpha);
    let root =
        0.60 + 0.387 * ra.powf(1.0 / 6.0) / (1.0 + (0.559 / film.pr).powf(9.0 / 16.0)).powf(8.0 / 27.0);
    root * root * film.k / d
}

/// Natural convection on an end disc, as a vertical plate of the disc's mean height pi/4 D, eq. 9.27, W/(m2.K).
fn end_disc(d: f64) -> f64 {
    let film = air(0.5 * (SURFACE + AMBIENT));
    let height = PI / 4.0 * d;
    let (nu, alpha) = (film.mu / film.rho, film.k / (film.rho * film.c_p));
    let ra = 9.81 * 2.0 / (SURFACE + AMBIENT) * (SURFACE - AMBIENT) * height.powi(3) / (nu * alpha);
    let nusselt = 0.68 + 0.670 * ra.powf(0.25) / (1.0 + (0.492 / film.pr).powf(9.0 / 16.0)).powf(4.0 / 9.0);
    nusselt * film.k / height
}

/// Radiation to a large room, W/(m2.K).
fn radiation(eps: f64) -> f64 {
    radiation_from(eps, SURFACE)
}

/// The same from a surface at `t`, W/(m2.K).
fn radiation_from(eps: f64, t: f64) -> f64 {
    eps * SIGMA * (t.powi(4) - AMBIENT.powi(4)) / (t - AMBIENT)
}

/// Two conductances of the datasheet: 1/7.4 K/W in still air and G_forced more at full command, by Re^0.8 in between.
#[test]
fn conductance() {
    let m = cooled(CoolingMode::Conductance, |m| {
        (m.parameters.conductance.G_still, m.parameters.conductance.G_forced) = (0.135, 0.113);
    });
    for (command, want) in [(0.0, 0.135), (0.5, 0.135 + 0.113 * 0.574_35), (1.0, 0.248)] {
        let c = Cooling::new(&m.parameters, N).coefficients(&m.parameters, &conditions(command));
        near(c.ambient_conductance[..N].iter().sum(), want, 1e-4, "conductance");
    }
}

/// A bare motor, lying: shell, two ends, radiation.
#[test]
fn bare() {
    let m = cooled(CoolingMode::Bare, |_| ());
    let c = Cooling::new(&m.parameters, N).coefficients(&m.parameters, &conditions(0.0));
    let (d, l, eps) =
        (m.parameters.housing.diameter, m.parameters.housing.length, m.parameters.housing.emissivity);
    let shell = PI * d * l * (lying_cylinder(d) + radiation(eps));
    let ends = 2.0 * PI / 4.0 * d * d * (end_disc(d) + radiation(eps));
    near(c.ambient_conductance[..N].iter().sum(), shell + ends, 0.01, "conductance of the bare motor");
    near(c.ambient_conductance[N / 2], shell / N as f64, 0.01, "conductance of a segment of the shell");
    // By hand: Ra_D = 8.6e4, Nu_D = 7.5, h = 7.0 + 1.6 W/(m2.K) on 60 cm2, and 10.2 on the two ends of 7 cm2.
    near(c.ambient_conductance[..N].iter().sum(), 0.0663, 0.04, "conductance of the bare motor by hand");
}

/// A jet across the motor: exit speed by continuity, decay with constant momentum, Churchill and Bernstein's law,
/// still air beside the jet.
#[test]
fn fan_crossflow() {
    for distance in [0.005, 0.030] {
        let m = cooled(CoolingMode::FanCrossflow, |m| m.parameters.cooling.fan.distance = distance);
        let p = &m.parameters;
        let command = 0.8;
        let c = Cooling::new(p, N).coefficients(p, &conditions(command));
        let area = |bore: f64, hub: f64| PI / 4.0 * (bore * bore - hub * hub);
        let wider = 2.0 * distance * p.cooling.fan.tan_spread;
        let (exit, jet) = (
            area(p.cooling.fan.bore, p.cooling.fan.hub),
            area(p.cooling.fan.bore + wider, (p.cooling.fan.hub - wider).max(0.0)),
        );
        let speed = p.cooling.fan.flow_max * command / exit * (exit / jet).sqrt();
        let (d, l) = (p.housing.diameter, p.housing.length);
        let film = air(0.5 * (SURFACE + AMBIENT));
        let re = film.rho * speed * d / film.mu;
        let layer =
            0.62 * re.sqrt() * film.pr.powf(1.0 / 3.0) / (1.0 + (0.4 / film.pr).powf(2.0 / 3.0)).powf(0.25);
        let forced = layer
            * (1.0 + (re / 282_000.0).powf(5.0 / 8.0)).powf(4.0 / 5.0)
            * p.cooling.fan.turbulence_factor;
        let still = lying_cylinder(d);
        let natural = still * d / film.k;
        let blown = (forced.powi(4) + natural.powi(4)).powf(0.25) * film.k / d;
        let covered = (p.cooling.fan.bore + wider).min(l) / l;
        let shell =
            PI * d * l * (covered * blown + (1.0 - covered) * still + radiation(p.housing.emissivity));
        let ends = PI / 2.0 * d * d * (end_disc(d) + radiation(p.housing.emissivity));
        near(c.flow, p.cooling.fan.flow_max * command, 1e-9, "flow");
        near(c.ambient_conductance[..N].iter().sum(), shell + ends, 0.012, "conductance in the jet");
        assert!((3e3..2e4).contains(&re), "Re = {re}");
    }
}

/// Flow through the gap by the book.
struct Gap {
    d_h: f64,
    section: f64,
    length: f64,
    ratio: f64,
    sigma: f64,
    push: bool,
}

impl Gap {
    fn of(m: &AnnulusCooledMotor) -> Gap {
        let p = &m.parameters;
        let (d_i, d_o) = (p.housing.diameter, p.cooling.annulus.outer_diameter);
        let section = PI / 4.0 * (d_o * d_o - d_i * d_i);
        let push = p.choices.cooling_mode == CoolingMode::AnnulusPush;
        let sigma = (section / (PI / 4.0 * p.cooling.fan.bore * p.cooling.fan.bore)).min(1.0);
        Gap {
            d_h: d_o - d_i,
            section,
            length: p.cooling.annulus.length.min(p.housing.length),
            ratio: d_i / d_o,
            sigma,
            push,
        }
    }

    fn reynolds(&self, m_flow: f64, air: &Air) -> f64 {
        m_flow * self.d_h / (self.section * air.mu)
    }

    /// Gnielinski's fraction of turbulent flow between Re 2300 and 4000.
    fn turbulent(re: f64) -> f64 {
        ((re - 2300.0) / 1700.0).clamp(0.0, 1.0)
    }

    /// Re* of an annulus: with it, the laws of the tube hold.
    fn re_star(&self, re: f64) -> f64 {
        let (a, ln) = (self.ratio, self.ratio.ln());
        re * ((1.0 + a * a) * ln + (1.0 - a * a)) / ((1.0 - a).powi(2) * ln)
    }

    /// Mean Nusselt number with the inner wall heated.
    fn nusselt(&self, re: f64, pr: f64) -> f64 {
        let (a, short) = (self.ratio, self.d_h / self.length);
        let laminar = |re: f64| {
            let gz = re * pr * short;
            let one = 3.66 + 1.2 * a.powf(-0.8);
            let two = 1.615 * (1.0 + 0.14 * a.powf(-0.5)) * gz.powf(1.0 / 3.0);
            let three = (2.0 / (1.0 + 22.0 * pr)).powf(1.0 / 6.0) * gz.sqrt();
            (one.powi(3) + two.powi(3) + three.powi(3)).powf(1.0 / 3.0)
        };
        let turbulent = |re: f64| {
            let f = (1.8 * self.re_star(re).log10() - 1.5).powi(-2);
            let k1 = 1.07 + 900.0 / re - 0.63 / (1.0 + 10.0 * pr);
            f / 8.0 * re * pr / (k1 + 12.7 * (f / 8.0).sqrt() * (pr.powf(2.0 / 3.0) - 1.0))
                * (1.0 + short.powf(2.0 / 3.0))
                * 0.75
                * a.powf(-0.17)
        };
        match Self::turbulent(re) {
            0.0 => laminar(re),
            1.0 => turbulent(re),
            share => (1.0 - share) * laminar(2300.0) + share * turbulent(4000.0),
        }
    }

    /// Fanning's apparent friction factor over the length.
    fn friction(&self, re: f64) -> f64 {
        let laminar = |re: f64| {
            let x = self.length / self.d_h / re;
            let developed = 16.0 * re / self.re_star(re);
            // Shah's K and C of wide ratios of diameters: 0.676 and 2.95e-5 within 1 % from 0.75 to 1.
            let steep = 3.44 / x.sqrt();
            (steep + (developed + 0.676 / (4.0 * x) - steep) / (1.0 + 2.95e-5 / (x * x))) / re
        };
        let turbulent = |re: f64| 0.25 / (1.8 * self.re_star(re).log10() - 1.5).powi(2);
        match Self::turbulent(re) {
            0.0 => laminar(re),
            1.0 => turbulent(re).max(laminar(re)),
            share => (1.0 - share) * laminar(2300.0) + share * turbulent(4000.0).max(laminar(4000.0)),
        }
    }

    /// Pressure drop of a mass flow, Pa.
    fn pressure(&self, m_flow: f64, air: &Air) -> f64 {
        let u = m_flow / (air.rho * self.section);
        let re = self.reynolds(m_flow, air);
        let kays = |c: f64| (1.0 / c - 1.0).powi(2);
        let loss = if self.push {
            1.0 - self.sigma * self.sigma + kays(contraction(self.sigma))
        } else {
            let laminar_ratio = 1.2;
            let turbulent_ratio = 1.0 + 0.04 * (re.max(4000.0) / 1e4).powf(-0.2);
            let k_d = laminar_ratio + Self::turbulent(re) * (turbulent_ratio - laminar_ratio);
            kays(contraction(0.0)) + 1.0 - 2.0 * k_d * self.sigma + self.sigma * self.sigma
        };
        0.5 * air.rho * u * u * (loss + 4.0 * self.friction(re) * self.length / self.d_h)
    }
}

/// Contraction of a plane jet behind a sharp edge over the ratio of areas: von Mises's table.
fn contraction(sigma: f64) -> f64 {
    const TABLE: [f64; 11] = [0.611, 0.612, 0.616, 0.622, 0.631, 0.644, 0.662, 0.687, 0.722, 0.781, 1.0];
    let k = ((sigma * 10.0) as usize).min(9);
    TABLE[k] + (TABLE[k + 1] - TABLE[k]) * (sigma * 10.0 - k as f64)
}

/// Both directions of the flow, a wide gap in transition and a narrow one with laminar flow, full and half command:
/// operating point, film, heat to the air, radiation to the tube.
#[test]
fn annulus_push_and_pull() {
    let mut regimes = [false; 3];
    for mode in [CoolingMode::AnnulusPush, CoolingMode::AnnulusPull] {
        for (outer, command) in [(0.0345, 0.5), (0.040, 0.6), (0.040, 1.0)] {
            // A stronger fan brings the wide gap to turbulent flow at full command.
            let m = cooled(mode, |m| {
                m.parameters.cooling.annulus.outer_diameter = outer;
                m.parameters.cooling.annulus.leak_area = 0.0;
                (m.parameters.cooling.annulus.factor_push, m.parameters.cooling.annulus.factor_pull) =
                    (1.0, 1.0);
                (m.parameters.cooling.fan.flow_max, m.parameters.cooling.fan.pressure_max) = (6e-3, 120.0);
            });
            let (p, gap, what) =
                (&m.parameters, Gap::of(&m), format!("{mode:?} {outer} m, command {command}"));
            let c = Cooling::new(p, N).coefficients(p, &conditions(command));
            let inner = PI * p.housing.diameter * gap.length;
            let wall = PI * p.cooling.annulus.outer_diameter * gap.length;
            let fresh = air(AMBIENT);
            // The default curve is a line from shut-off pressure to free flow; both follow the affinity laws.
            let fan = |q: f64| {
                fresh.rho / p.cooling.fan.density_ref
                    * p.cooling.fan.pressure_max
                    * command
                    * command
                    * (1.0 - q / (p.cooling.fan.flow_max * command))
            };
            let (mut mean, mut q) = (AMBIENT, 0.0);
            let mut film = 0.0;
            for _ in 0..20 {
                let air = air(mean);
                let (mut low, mut high) = (0.0, p.cooling.fan.flow_max * command);
                for _ in 0..60 {
                    q = 0.5 * (low + high);
                    if fan(q) > gap.pressure(fresh.rho * q, &air) { low = q } else { high = q }
                }
                let re = gap.reynolds(fresh.rho * q, &air);
                film = gap.nusselt(re, air.pr) * air.k / gap.d_h;
                let ntu = film * inner / (fresh.rho * q * air.c_p);
                mean = AMBIENT + (SURFACE - AMBIENT) * (1.0 - (1.0 - (-ntu).exp()) / ntu);
            }
            let re = gap.reynolds(fresh.rho * q, &air(mean));
            regimes[usize::from(re > 2300.0) + usize::from(re > 4000.0)] = true;
            println!("{what}: Re {re:.0}, {:.3} L/s, {:.1} W/(m2.K)", 1e3 * q, film);
            near(c.flow, q, 0.015, &format!("{what}: flow"));
            near(c.pressure_drop, fan(q), 0.03, &format!("{what}: pressure"));
            let own: f64 = (0..N).map(|k| c.film_conductance[k] * c.share[k]).sum();
            let both: f64 = c.film_conductance[..N].iter().sum();
            near(own, film * inner, 0.02, &format!("{what}: film on the motor"));
            near(both, film * (inner + wall), 0.02, &format!("{what}: films on both walls"));
            near(
                c.m_flow_cp,
                fresh.rho * q * air(mean).c_p,
                0.02,
                &format!("{what}: heat capacity of the flow"),
            );
            let passed = (0..N).fold(1.0, |left, k| left * (1.0 - c.effectiveness[k]));
            near(passed.ln(), -both / c.m_flow_cp, 1e-9, &format!("{what}: what the air has not taken"));
            // The first segment lies in the entrance, where the film is best.
            assert!(c.film_conductance[0] > 1.2 * c.film_conductance[N - 1], "{what}: entrance");
            // The power of a pushing fan (affinity laws) warms the air before the gap.
            let power = if gap.push {
                p.cooling.fan.power * command.powi(3) * fresh.rho / p.cooling.fan.density_ref
            } else {
                0.0
            };
            near(c.fan_power, power, 0.01, &format!("{what}: power of the fan"));
            near(c.inlet_rise, power / (fresh.rho * q * 1007.0), 0.02, &format!("{what}: rise by the fan"));
            // Long concentric cylinders.
            let black = SIGMA * (SURFACE.powi(4) - TUBE.powi(4)) / (SURFACE - TUBE);
            let resistance = 1.0 / p.housing.emissivity
                + inner / wall * (1.0 - p.cooling.annulus.emissivity) / p.cooling.annulus.emissivity;
            near(c.to_tube * N as f64, inner * black / resistance, 1e-3, &format!("{what}: radiation"));
            let outside =
                natural_on_cylinder(outer, TUBE) + radiation_from(p.cooling.annulus.emissivity, TUBE);
            near(c.tube_to_ambient, outside * wall, 0.01, &format!("{what}: tube to room"));
            // The two ends see the room.
            let ends = PI / 2.0
                * p.housing.diameter.powi(2)
                * (end_disc(p.housing.diameter) + radiation(p.housing.emissivity));
            let open = 1.0 - gap.length / p.housing.length;
            let shell = PI
                * p.housing.diameter
                * p.housing.length
                * open
                * (lying_cylinder(p.housing.diameter) + radiation(p.housing.emissivity));
            near(c.ambient_conductance[..N].iter().sum(), ends + shell, 0.015, &format!("{what}: ends"));
        }
    }
    assert_eq!(regimes, [true; 3], "laminar, transitional and turbulent flow");
}
