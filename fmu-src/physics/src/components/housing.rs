//! The motor's outer surface: a cylinder with two flat ends.
//!
//! G_still = h A_lateral + 2 h_end A_end + mount,   h = Nu k/L by `correlations/natural_convection.rs`   (1)
//! G_room  = h_r (A_lateral + 2 A_end),             h_r by `correlations/radiation.rs`                   (2)
//! axial conductance between segments of the length dx = lambda pi (D - s) s/dx                          (3)
//!
//! *Assumes* a smooth grey cylinder in large still ambient air, one coefficient for the whole surface at its mean
//! temperature, properties at the mean of surface and air. *Neglects* fins, labels and cable glands.
//! *Range*: that of the correlations. *Source*: (1), (2) see there; (3) Fourier. Emissivity of stainless steel,
//! cleaned: 0.22 at 300 K (Incropera, 7th ed., table A.11, not verified; FLIR's tables give 0.24 for steel freshly
//! worked with emery); anodised aluminium has 0.8, painted metal 0.9.
//! Diameter 30 mm: data sheet of maxon 305015; its length of 64 mm is not in the data sheet and
//! unconfirmed. Wall of 2 mm of steel, 16 W/(m.K): an estimate.

use crate::correlations::{natural_convection as natural, radiation};
use crate::media::air::Air;
use declare::{Unit, Variable, enumeration, variables};
use std::f64::consts::PI;

/// Most segments of the housing along its axis.
pub const SEGMENTS: usize = 64;
/// Standard gravity, m/s2.
pub const GRAVITY: f64 = 9.80665;

enumeration! {
    /// Orientation of the motor's axis.
    pub enum Orientation {
        /// Horizontal axis.
        Horizontal = 1, "horizontal";
        /// Vertical axis.
        Vertical = 2, "vertical";
    }
}

impl Orientation {
    /// Film coefficient of natural convection on the lateral surface of a cylinder of this diameter and length, m, W/(m2.K), with
    /// the surface and the ambient air at these temperatures, K, and `p` pascal.
    pub fn lateral_coefficient(self, [d, l]: [f64; 2], [t_s, t_a]: [f64; 2], p: f64) -> f64 {
        let film = Air::at(0.5 * (t_s + t_a), p);
        let rayleigh = |length: f64| film.rayleigh(natural::driving_difference(t_s - t_a), length, GRAVITY);
        match self {
            Orientation::Horizontal => natural::horizontal_cylinder(rayleigh(d), film.pr) * film.k / d,
            Orientation::Vertical => natural::vertical_cylinder(rayleigh(l), film.pr, l / d) * film.k / l,
        }
    }
}

variables! {
    /// Size and surface of the housing.
    pub struct Housing {
        /// Outer diameter of the motor
        diameter: f64 = Variable::tunable(0, 0.030, Unit::Metre, 1e-3, 1.0).log()
            .source("maxon datasheet 305015"),
        /// Length of the motor without its shaft
        length: f64 = Variable::tunable(1, 0.064, Unit::Metre, 1e-3, 2.0).log()
            .source("estimate: not in the text of the datasheet"),
        /// Wall thickness of the housing, for axial conduction
        thickness: f64 = Variable::tunable(2, 0.002, Unit::Metre, 1e-5, 0.1).log()
            .source("estimate"),
        /// Thermal conductivity of the housing's wall
        conductivity: f64 = Variable::tunable(3, 16.0, Unit::WattPerMetreKelvin, 0.1, 500.0).log()
            .source("stainless steel"),
        /// Emissivity of the housing's surface
        emissivity: f64 = Variable::tunable(4, 0.22, Unit::One, 0.0, 1.0)
            .source("Incropera, 7th ed., table A.11: stainless steel, cleaned"),
        /// Orientation of the motor's axis
        orientation: Orientation = Variable::choice(5, 1),
    }
}

/// Film coefficients of natural convection and radiation, W/(m2.K).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StillAir {
    /// Natural convection on the lateral surface.
    pub lateral: f64,
    /// Natural convection on the ends.
    pub end: f64,
    /// Radiation to ambient.
    pub radiation: f64,
}

impl Housing {
    /// Lateral surface, m2.
    pub fn lateral_area(&self) -> f64 {
        PI * self.diameter * self.length
    }

    /// Area of one end, m2.
    pub fn end_area(&self) -> f64 {
        PI / 4.0 * self.diameter * self.diameter
    }

    /// Conductance along the axis between the centres of two neighbours of `segments` equal segments, eq. (3), W/K.
    pub fn axial_conductance(&self, segments: usize) -> f64 {
        // A wall thicker than the radius is a solid bar.
        let wall = self.thickness.min(0.5 * self.diameter);
        let section = PI * (self.diameter - wall) * wall;
        self.conductivity * section * segments as f64 / self.length
    }

    /// Film coefficients in still air and radiation to walls, both at `t_a`, eqs. (1) and (2), with the surface
    /// at `t_s` kelvin and the air at `p` pascal. At equal temperatures conduction and radiation remain.
    pub fn still_air(&self, t_s: f64, t_a: f64, p: f64) -> StillAir {
        let film = Air::at(0.5 * (t_s + t_a), p);
        let d = self.diameter;
        let rayleigh = |length: f64| film.rayleigh(natural::driving_difference(t_s - t_a), length, GRAVITY);
        let lateral = self.orientation.lateral_coefficient([d, self.length], [t_s, t_a], p);
        let height = natural::end_disc_height(d);
        StillAir {
            lateral,
            end: natural::vertical_plate_laminar(rayleigh(height), film.pr) * film.k / height,
            radiation: radiation::coefficient(self.emissivity, t_s, t_a),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: a 30 x 64 mm motor at 400 K in air at 296 K: Ra_D about 1.5e5, Nu 8.4, h 8.4 W/(m2.K);
    /// lateral 6.03e-3 m2, ends 2 x 7.07e-4 m2. Radiation at 0.22: 2.2 W/(m2.K).
    #[test]
    fn a_motor_in_still_air() {
        let housing = Housing::default();
        let still = housing.still_air(400.0, 296.0, 101_325.0);
        assert!((7.6..9.2).contains(&still.lateral), "{still:?}");
        assert!((8.0..13.0).contains(&still.end), "{still:?}");
        let exact = 0.22 * 5.670_374e-8 * (400.0 + 296.0) * (400.0f64.powi(2) + 296.0f64.powi(2));
        assert!((still.radiation - exact).abs() < 1e-6, "{still:?}");
        assert!((housing.lateral_area() - 6.0319e-3).abs() < 1e-6);
    }

    #[test]
    fn thinner_air_cools_less_and_equal_temperatures_are_no_special_case() {
        let housing = Housing::default();
        let (low, high) = (housing.still_air(350.0, 300.0, 101_325.0), housing.still_air(350.0, 300.0, 5e4));
        assert!(high.lateral < low.lateral && high.radiation == low.radiation);
        let none = housing.still_air(300.0, 300.0, 101_325.0);
        assert!(none.lateral > 0.0 && none.lateral < low.lateral);
    }

    /// Coefficients on the lateral surface with (6) of the correlations and without, at differences from 1e-4 K to 100 K: equal to
    /// 1e-3 above 0.6 K, and the heat flows to 1 mW below. The derivative at equal temperatures is that of the air's properties.
    #[test]
    fn natural_convection_is_smooth_at_equal_temperatures() {
        let (t_a, p, size) = (298.15, 101_325.0, [0.030, 0.064]);
        for orientation in [Orientation::Horizontal, Orientation::Vertical] {
            let h = |dt: f64| orientation.lateral_coefficient(size, [t_a + dt, t_a], p);
            let by_the_book = |dt: f64| {
                let film = Air::at(t_a + 0.5 * dt, p);
                let rayleigh = |length: f64| film.rayleigh(dt, length, GRAVITY);
                let [d, l] = size;
                match orientation {
                    Orientation::Horizontal => {
                        natural::horizontal_cylinder(rayleigh(d), film.pr) * film.k / d
                    }
                    Orientation::Vertical => {
                        natural::vertical_cylinder(rayleigh(l), film.pr, l / d) * film.k / l
                    }
                }
            };
            for k in 0..=60 {
                let dt = 1e-4 * 10f64.powf(0.1 * f64::from(k));
                let (smooth, book) = (h(dt), by_the_book(dt));
                assert!(
                    dt < 0.6 || (smooth / book - 1.0).abs() < 1e-3,
                    "{orientation:?} {dt} K: {smooth}, {book}"
                );
                let heat = (smooth - book).abs() * dt * Housing::default().lateral_area();
                assert!(heat < 1e-3, "{orientation:?} {dt} K: {heat} W");
            }
            // 0.3 % per kelvin at most; |dt|^(1/6) gives 1e4 times that over 1e-6 K.
            for dt in [1e-6, 1e-4, 1e-3] {
                let slope = (h(dt) - h(-dt)).abs().max((h(dt) - h(0.0)).abs()) / dt / h(0.0);
                assert!(slope < 3e-3 + 100.0 * dt, "{orientation:?} {dt} K: {slope} 1/K");
            }
        }
    }

    #[test]
    fn axial_conductance_of_a_tube() {
        // 16 W/(m.K) * pi 28 mm 2 mm / (64 mm / 8)
        let g = Housing::default().axial_conductance(8);
        assert!((g - 16.0 * PI * 0.028 * 0.002 / 0.008).abs() < 1e-12);
        assert!(Housing { thickness: 0.1, ..Housing::default() }.axial_conductance(8).is_finite());
    }
}
