//! Annular gap between the motor and a tube around it, and the pressure drop of the air in it.
//!
//! pushed: p(Q) = rho u^2/2 [1 - sigma^2 + K_c(sigma)] + friction                            (1)
//! pulled: p(Q) = rho u^2/2 [K_c(0) + K_e(sigma)] + friction                                 (2)
//! leak:   Q_leak = A_leak sqrt(2 p/rho)                                                     (3)
//! upright: buoyancy = g L (rho_a - rho_gap) = g L rho_gap (T_gap - T_a)/T_a                 (4)
//! at rest: heat from motor to tube = 2 pi L k_eff (T - T_t)/ln(D_o/D_i)                     (5)
//! tube:    heat to ambient = F (h + h_r) pi D_o L (T_t - T_a)                               (6)
//!
//! sigma is the ratio of the gap's section to the fan's opening. With a pushing fan the air leaves the gap with its dynamic head, which is
//! lost (K_e(0) = 1). With a pulling fan the air enters from still ambient air (sigma = 0); the fan's static pressure refers to the total
//! pressure before it. Friction: `correlations/annulus_friction.rs`; K_c: `correlations/entrance_exit.rs`, for a uniform profile, since
//! the friction of the developing flow includes the momentum of the profile. A gap wider than the opening has sigma = 1: no contraction.
//! *Assumes* a smooth concentric gap as long as the shorter of tube and motor; a leak like an orifice of the area A_leak between fan
//! and gap; A_leak includes the contraction.
//! (4) acts in an upright gap together with the fan, upwards; T_gap is the air's mean temperature. With friction and heat transfer
//! of the developing flow, it covers the chimney flow from boundary layers to developed flow: within 15 % of Bar-Cohen and Rohsenow's
//! channel of one isothermal and one adiabatic wall (test in `tests/fan_at_rest.rs`). A fan at rest has no pressure drop.
//! (5) k_eff by `correlations/natural_convection.rs` (5) in a horizontal gap, conduction in an upright gap (convection there: (4)).
//! It replaces the two film coefficients of the developed flow with the weight exp(-Gz), Gz = Re Pr D_h/L: below Gz = 1 the air
//! reaches the wall temperature within the gap, and the flow transports no more heat.
//! (6) natural convection h on a cylinder in the motor's orientation, radiation h_r with the tube's emissivity, factor F.
//! *Neglects* air flow through the open ends of a horizontal gap at rest, the resistance of the fan's blades at rest, the tube's wall
//! (2 mm of ABS: 10 % of (6)), downward flow against the buoyancy, the wake of the hub, tabs that hold the tube, the part of the tube
//! that is longer than the motor.
//! *Sign*: p > 0 against the fan. *Range*: D_motor < D_tube; that of the correlations.
//! *Source*: Kays and London, Compact Heat Exchangers, ch. 2 and 5, with a corrected exit loss in (1), (2) (`seeds` audit T35);
//! masses from the thesis, tables 1 to 3; ABS: c_p 1400 J/(kg.K), emissivity 0.9 (typical of plastics); (4) Bar-Cohen and Rohsenow,
//! J. Heat Transfer 106 (1984) 116-123: their momentum balance of developed flow, here with the friction of the entrance.

use super::housing::{GRAVITY, Housing, Orientation};
use crate::correlations::annulus_friction::{Friction, pressure_drop};
use crate::correlations::annulus_heat_transfer::{Entry, HeatedAnnulus, Wall};
use crate::correlations::entrance_exit::{contraction, expansion, momentum_ratio};
use crate::correlations::{natural_convection as natural, radiation};
use crate::media::air::{Air, density};
use declare::{Unit, Variable, variables};
use std::f64::consts::{FRAC_PI_4, PI};

variables! {
    /// Data of the tube around the motor.
    pub struct Annulus {
        /// Inner diameter of the tube, outer diameter of the gap
        outer_diameter: f64 = Variable::tunable(0, 0.040, Unit::Metre, 1e-3, 2.0).log()
            .source("thesis, table 2"),
        /// Length of the tube over the motor
        length: f64 = Variable::tunable(1, 0.064, Unit::Metre, 1e-3, 2.0).log()
            .source("length of the motor"),
        /// Mass of the tube
        mass: f64 = Variable::tunable(2, 0.0155, Unit::Kilogram, 1e-5, 100.0).log()
            .source("thesis, table 2"),
        /// Specific heat capacity of the tube (ABS)
        specific_heat: f64 = Variable::tunable(3, 1400.0, Unit::JoulePerKilogramKelvin, 100.0, 1e4)
            .source("ABS, typical"),
        /// Leak area between fan and annulus; 0 = no leak
        leak_area: f64 = Variable::tunable(4, 0.0, Unit::SquareMetre, 0.0, 1.0).nominal(1e-3),
        /// Factor on the heat transfer coefficient in the annulus, fan pushing
        factor_push: f64 = Variable::tunable(5, 1.0, Unit::One, 0.1, 10.0).log()
            .source("neutral"),
        /// Factor on the heat transfer coefficient in the annulus, fan pulling
        factor_pull: f64 = Variable::tunable(6, 1.0, Unit::One, 0.1, 10.0).log()
            .source("neutral"),
        /// Emissivity of the tube's inner and outer surface
        emissivity: f64 = Variable::tunable(7, 0.9, Unit::One, 0.0, 1.0)
            .source("plastics, typical"),
        /// Factor on natural convection and radiation from the tube to ambient; 0 = insulated tube
        factor_outside: f64 = Variable::tunable(9, 1.0, Unit::One, 0.0, 10.0)
            .source("neutral"),
    }
}

/// Flow direction of the fan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowDirection {
    /// From the fan into the gap.
    Push,
    /// From the gap into the fan.
    Pull,
}

/// Annular gap with all values that follow from its dimensions.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// Section, m2.
    pub section: f64,
    /// Hydraulic diameter, m.
    pub d_h: f64,
    /// Length with the motor inside, m.
    pub length: f64,
    /// Inner surface of the tube along that length, m2.
    pub wall_area: f64,
    /// Heat transfer from the motor's surface.
    pub heated: HeatedAnnulus,
    friction: Friction,
    ratio: f64,
    /// Section over the fan's opening, at most 1.
    sigma: f64,
    /// Losses of the entrance and exit that do not depend on the flow.
    fixed_loss: f64,
    leak_area: f64,
    direction: FlowDirection,
    /// Diameters of motor and tube, m.
    diameters: [f64; 2],
    orientation: Orientation,
}

impl Gap {
    /// The gap between a motor and a tube, for a fan with the given opening, m2.
    pub fn new(annulus: &Annulus, housing: &Housing, opening: f64, direction: FlowDirection) -> Gap {
        let (d_i, d_o) = (housing.diameter, annulus.outer_diameter.max(1.001 * housing.diameter));
        let length = annulus.length.min(housing.length);
        let section = FRAC_PI_4 * (d_o - d_i) * (d_o + d_i);
        let ratio = d_i / d_o;
        let sigma = (section / opening).min(1.0);
        let fixed_loss = match direction {
            FlowDirection::Push => 1.0 - sigma * sigma + contraction(sigma, 1.0),
            FlowDirection::Pull => contraction(0.0, 1.0),
        };
        Gap {
            section,
            d_h: d_o - d_i,
            length,
            wall_area: PI * d_o * length,
            heated: HeatedAnnulus::new(ratio, Wall::UniformTemperature, Entry::Developing),
            friction: Friction::new(ratio, length / (d_o - d_i)),
            ratio,
            sigma,
            fixed_loss,
            leak_area: annulus.leak_area,
            direction,
            diameters: [d_i, d_o],
            orientation: housing.orientation,
        }
    }

    /// Ratio of the diameters, motor to tube.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Whether buoyancy drives air along the gap.
    pub fn is_upright(&self) -> bool {
        self.orientation == Orientation::Vertical
    }

    /// Buoyancy pressure, eq. (4), Pa, with the gap's air at the mean temperature `t`, ambient air at `t_a`, K, and `p`, Pa; positive
    /// in the direction of the buoyant flow; 0 in a horizontal gap.
    pub fn buoyancy(&self, t: f64, t_a: f64, p: f64) -> f64 {
        if !self.is_upright() {
            return 0.0;
        }
        let dt = t - t_a;
        // Smooth magnitude of dt, for flow reversal.
        let magnitude = dt * dt / natural::driving_difference(dt);
        GRAVITY * self.length * density(t, p) * magnitude / t_a
    }

    /// Conductance from motor to tube through air at rest, eq. (5), W/K.
    pub fn at_rest(&self, surface: f64, tube: f64, p: f64) -> f64 {
        let air = Air::at(0.5 * (surface + tube), p);
        let [d_i, d_o] = self.diameters;
        let circulation = if self.is_upright() {
            1.0
        } else {
            let length = natural::concentric_length(d_i, d_o);
            natural::concentric_cylinders(
                air.rayleigh(natural::driving_difference(surface - tube), length, GRAVITY),
                air.pr,
            )
        };
        2.0 * PI * self.length * circulation * air.k / (d_o / d_i).ln()
    }

    /// Conductance from the tube to ambient, eq. (6), W/K.
    pub fn tube_to_ambient(&self, annulus: &Annulus, t: f64, t_a: f64, p: f64) -> f64 {
        let size = [self.diameters[1], self.length];
        let convection = self.orientation.lateral_coefficient(size, [t, t_a], p);
        let all = convection + radiation::coefficient(annulus.emissivity, t, t_a);
        annulus.factor_outside * all * self.wall_area
    }

    /// Reynolds number on the hydraulic diameter at the mass flow `m` in kg/s.
    pub fn reynolds(&self, m: f64, air: &Air) -> f64 {
        (m * self.d_h / (self.section * air.mu)).abs()
    }

    /// Pressure drop at the mass flow `m` in kg/s, eq. (1) or (2), Pa.
    pub fn pressure(&self, m: f64, air: &Air) -> f64 {
        self.resistance(air).pressure(m)
    }

    /// The resistance to air of one state.
    pub fn resistance(&self, air: &Air) -> Resistance<'_> {
        let per_mass = 1.0 / (air.rho * self.section);
        Resistance {
            gap: self,
            reynolds: self.reynolds(1.0, air),
            dynamic: 0.5 * air.rho * per_mass * per_mass,
            friction: pressure_drop(1.0, air.mu, per_mass, self.length, self.d_h),
        }
    }

    /// Leak flow at the pressure `p` in Pa in air of the density `rho`, eq. (3), m3/s; negative (inwards) where buoyancy lowers the
    /// pressure behind the fan.
    pub fn leak(&self, p: f64, rho: f64) -> f64 {
        self.leak_area * (2.0 * p.abs() / rho).sqrt().copysign(p)
    }
}

/// The resistance of a gap to air of one state.
#[derive(Clone, Copy, Debug)]
pub struct Resistance<'a> {
    gap: &'a Gap,
    /// Reynolds number per mass flow, s/kg.
    reynolds: f64,
    /// Dynamic head per square of the mass flow, Pa.s2/kg2.
    dynamic: f64,
    /// Pressure drop by friction per f Re and mass flow, Pa.s/kg.
    friction: f64,
}

impl Resistance<'_> {
    /// Pressure drop at the mass flow `m` in kg/s, eq. (1) or (2), Pa.
    #[inline]
    pub fn pressure(&self, m: f64) -> f64 {
        let (gap, re) = (self.gap, (self.reynolds * m).abs());
        let loss = match gap.direction {
            FlowDirection::Push => gap.fixed_loss,
            FlowDirection::Pull => gap.fixed_loss + expansion(gap.sigma, momentum_ratio(re)),
        };
        m * (self.dynamic * loss * m + self.friction * gap.friction.f_re(re))
    }
}

impl Annulus {
    /// Heat capacity of the tube, J/K.
    pub fn capacity(&self) -> f64 {
        self.mass * self.specific_heat
    }

    /// Factor on the heat transfer for a flow direction of the fan.
    pub fn factor(&self, direction: FlowDirection) -> f64 {
        match direction {
            FlowDirection::Push => self.factor_push,
            FlowDirection::Pull => self.factor_pull,
        }
    }

    /// Why the data do not fit together, in one sentence.
    pub fn fault(&self, housing: &Housing) -> Option<String> {
        (self.outer_diameter <= housing.diameter).then(|| {
            format!(
                "annulus.outer_diameter = {} m does not pass the motor: it must be above housing.diameter = {} m \
                 (r* below 1).",
                self.outer_diameter, housing.diameter
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(d_o: f64, direction: FlowDirection) -> Gap {
        let annulus = Annulus { outer_diameter: d_o, ..Annulus::default() };
        Gap::new(&annulus, &Housing::default(), FRAC_PI_4 * 0.038 * 0.038, direction)
    }

    /// The thesis's 40 mm tube: section pi/4 (40^2 - 30^2) = 549.8 mm2, D_h = 10 mm.
    #[test]
    fn size_of_the_gap_of_the_thesis() {
        let g = gap(0.040, FlowDirection::Push);
        assert!((g.section - 549.78e-6).abs() < 1e-8 && (g.d_h - 0.010).abs() < 1e-15);
    }

    /// Pressure drop is 0 at zero flow and rises with the flow. It is larger with a pulling fan: the air then enters from still
    /// ambient air, not from a duct.
    #[test]
    fn pressure_rises_from_zero() {
        let air = Air::at(300.0, 101_325.0);
        let (push, pull) = (gap(0.040, FlowDirection::Push), gap(0.040, FlowDirection::Pull));
        assert_eq!(push.pressure(0.0, &air), 0.0);
        let mut last = 0.0;
        for k in 1..50 {
            let m = 1e-4 * f64::from(k);
            let p = push.pressure(m, &air);
            assert!(p > last, "{m}: {p} after {last}");
            assert!(pull.pressure(m, &air) > 0.0);
            last = p;
        }
    }

    /// Continuous where the gap becomes wider than the fan's opening.
    #[test]
    fn no_jump_where_the_gap_outgrows_the_fan() {
        let air = Air::at(300.0, 101_325.0);
        let d = (0.030f64.powi(2) + 0.038f64.powi(2)).sqrt();
        for direction in [FlowDirection::Push, FlowDirection::Pull] {
            let p = |d: f64| gap(d, direction).pressure(3e-3, &air);
            assert!((p(d * (1.0 + 1e-7)) / p(d * (1.0 - 1e-7)) - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn a_tube_that_does_not_pass_the_motor_is_named() {
        let annulus = Annulus { outer_diameter: 0.030, ..Annulus::default() };
        assert!(annulus.fault(&Housing::default()).unwrap().contains("annulus.outer_diameter = 0.03 m"));
        assert_eq!(Annulus::default().fault(&Housing::default()), None);
    }

    /// g L (rho_a - rho): at 60 K above 298.15 K 9.80665 * 0.064 * 1.1839 * 60/358.15 = 0.12448 Pa; at equal temperatures 0 with the
    /// derivative 0; the same law in air colder than ambient.
    #[test]
    fn buoyancy_of_an_upright_gap() {
        let housing = Housing { orientation: Orientation::Vertical, ..Housing::default() };
        let g = Gap::new(&Annulus::default(), &housing, 1e-3, FlowDirection::Pull);
        let (t_a, p) = (298.15, 101_325.0);
        let at = |dt: f64| g.buoyancy(t_a + dt, t_a, p);
        assert!((at(60.0) - 0.12448).abs() < 2e-5, "{}", at(60.0));
        let exact = GRAVITY * 0.064 * (density(t_a - 10.0, p) - density(t_a, p));
        assert!((at(-10.0) / exact - 1.0).abs() < 1e-4);
        assert!(at(0.0) == 0.0 && at(1e-5) < 1e-3 * 1e-5, "{}", at(1e-5));
        assert_eq!(gap(0.040, FlowDirection::Pull).buoyancy(350.0, t_a, p), 0.0, "horizontal");
    }

    #[test]
    fn a_leak_is_an_orifice() {
        let annulus = Annulus { leak_area: 1e-3, ..Annulus::default() };
        let g = Gap::new(&annulus, &Housing::default(), 1e-3, FlowDirection::Push);
        assert!((g.leak(60.0, 1.2) - 1e-2).abs() < 1e-15);
        assert!((g.leak(-60.0, 1.2) + 1e-2).abs() < 1e-15);
        assert_eq!(g.leak(0.0, 1.2), 0.0);
    }
}
