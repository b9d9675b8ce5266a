//! Free jet of an axial fan.
//!
//! A_0 = pi (D^2 - d^2)/4,  u_0 = Q/A_0                                                     (1)
//! r(x) = D/2 + x tan(theta),  r_i(x) = max(0, d/2 - x tan(theta)),  A(x) = pi (r^2 - r_i^2)  (2)
//! u(x) = u_0 (A_0/A)^m                                                                     (3)
//!
//! D is the bore of the fan, d its hub, theta the half-angle of spread. The air leaves the fan as a ring that spreads outward, and inward over
//! the wake of the hub until it is a full disc. m = 1/2 in (3) conserves the momentum rho u^2 A: a jet with entrainment. m = 1 conserves
//! the flow: a swirling jet that spreads by centrifugal force. A fan without guide vanes is between the two.
//! *Assumes* one mean speed over the ring (top hat), air at rest around it, no wall nearby.
//! *Neglects* swirl (a wider cone: choose theta), the profile across the jet, the potential core.
//! *Sign*: Q < 0 (suction side) has no jet; the velocity is 0.
//! *Range*: x >= 0, x < 0 is set to 0. The spread of a round turbulent jet without swirl is tan(theta) = 1/B
//! = 0.17, with B the decay constant of its centreline speed U_c/U_0 = B D/x: a Gaussian profile of the same
//! mass and momentum has U_c = 2 u. A small fan with swirl spreads wider; 0.1 to 0.5 are in use.
//! *Source*: Pope, Turbulent Flows (2000), sec. 5.1 and table 5.1: B = 5.8 to 6.1, half-width S x, S = 0.094
//! to 0.102.

use std::f64::consts::PI;

/// tan(theta) of a round turbulent jet without swirl: 1/B with B = 5.9.
pub const TAN_SPREAD_ROUND_JET: f64 = 0.17;

/// An axial fan as the source of a jet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FanJet {
    /// Diameter of the bore, m
    pub bore: f64,
    /// Diameter of the hub, m; limited to 0.99 of the bore
    pub hub: f64,
    /// Tangent of the half-angle of spread; limited to 0 ... 2
    pub tan_spread: f64,
    /// Exponent m of eq. (3); limited to 0.5 ... 1
    pub decay: f64,
}

impl FanJet {
    #[inline]
    fn bore(&self) -> f64 {
        self.bore.clamp(1e-6, 1e3)
    }

    /// Area of the exit between hub and bore, eq. (1), m2.
    #[inline]
    pub fn exit_area(&self) -> f64 {
        let bore = self.bore();
        let hub = self.hub.clamp(0.0, 0.99 * bore);
        PI / 4.0 * (bore * bore - hub * hub)
    }

    /// Radius of the jet at the distance `x` in m, eq. (2), m.
    #[inline]
    pub fn radius(&self, x: f64) -> f64 {
        0.5 * self.bore() + x.clamp(0.0, 1e6) * self.tan_spread.clamp(0.0, 2.0)
    }

    /// Section of the jet at the distance `x` in m, eq. (2), m2.
    #[inline]
    pub fn area(&self, x: f64) -> f64 {
        let (outer, hub) = (self.radius(x), self.hub.clamp(0.0, 0.99 * self.bore()));
        let inner = (0.5 * hub - (outer - 0.5 * self.bore())).max(0.0);
        PI * (outer - inner) * (outer + inner)
    }

    /// Mean velocity of the jet at the distance `x` in m with the flow `q` in m3/s, eq. (3), m/s.
    #[inline]
    pub fn speed(&self, q: f64, x: f64) -> f64 {
        let exit = self.exit_area();
        q.clamp(0.0, 1e6) / exit * (exit / self.area(x)).powf(self.decay.clamp(0.5, 1.0))
    }

    /// Length of the part of a body of `length` m inside the jet at the distance `x`, m; the body is centred on the axis.
    #[inline]
    pub fn covered_length(&self, length: f64, x: f64) -> f64 {
        length.max(0.0).min(2.0 * self.radius(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::checks::close;

    const FAN: FanJet = FanJet { bore: 0.038, hub: 0.024, tan_spread: TAN_SPREAD_ROUND_JET, decay: 0.5 };

    /// Far from the fan, the centreline of the equivalent Gaussian jet (twice the mean speed) has the
    /// measured decay B = 5.8 (Hussein and others) to 6.06 (Panchapakesan and Lumley), Pope, table 5.1. The test fails
    /// if the velocity decreases with the area instead of its square root.
    #[test]
    fn measured_decay_of_a_round_jet() {
        let jet = FanJet { hub: 0.0, ..FAN };
        let (q, x) = (0.004, 1000.0 * jet.bore);
        let exit = q / jet.exit_area();
        let b = 2.0 * jet.speed(q, x) / exit * x / jet.bore;
        assert!((5.8..=6.06).contains(&b), "{b}");
    }

    /// The measured half-width S = 0.094 to 0.102 is an independent measurement of the same jet: the top hat with a
    /// Gaussian's mass and momentum has the radius sqrt(2/ln 2) S x.
    #[test]
    fn spread_agrees_with_the_measured_half_width() {
        let s = TAN_SPREAD_ROUND_JET / (2.0 / 2f64.ln()).sqrt();
        assert!((0.094..=0.102).contains(&s), "{s}");
    }

    #[test]
    fn momentum_is_that_of_the_exit_at_any_distance() {
        let q = 0.004667;
        let exit = q * q / FAN.exit_area();
        for x in [0.0, 0.005, 0.03, 1.0] {
            close(FAN.speed(q, x).powi(2) * FAN.area(x), exit, 1e-13);
        }
    }

    #[test]
    fn flow_is_that_of_the_exit_where_swirl_rules() {
        let swirling = FanJet { decay: 1.0, ..FAN };
        for x in [0.0, 0.005, 0.03, 1.0] {
            close(swirling.speed(0.004, x) * swirling.area(x), 0.004, 1e-13);
        }
    }

    /// By hand: 38 mm bore, 24 mm hub: A_0 = pi/4 (0.038^2 - 0.024^2) = 6.8173e-4 m2, u(0) = Q/A_0 = 6.846 m/s.
    /// 15 mm away, the ring reaches from 9.45 to 21.55 mm: A = 1.1784e-3 m2. From 71 mm on it is a full disc.
    #[test]
    fn hub_raises_the_speed() {
        close(FAN.exit_area(), 6.8173e-4, 1e-4);
        close(FAN.speed(0.004667, 0.0), 6.8458, 1e-4);
        close(FAN.area(0.015), 1.1784e-3, 1e-4);
        close(FAN.area(0.2), PI * FAN.radius(0.2).powi(2), 1e-12);
        let open = FanJet { hub: 0.0, ..FAN };
        assert!(open.speed(0.004, 0.01) < FAN.speed(0.004, 0.01));
        close(open.speed(0.004, 0.0), 0.004 / open.exit_area(), 1e-13);
    }

    #[test]
    fn decays_with_distance_covers_the_body_and_stays_finite() {
        assert!(FAN.speed(0.004, 0.03) < FAN.speed(0.004, 0.005));
        assert_eq!(FAN.speed(0.004, -1.0), FAN.speed(0.004, 0.0));
        assert_eq!(FAN.speed(-0.004, 0.01), 0.0);
        close(FAN.covered_length(0.064, 0.0), 0.038, 1e-14);
        close(FAN.covered_length(0.064, 1.0), 0.064, 1e-14);
        let odd = FanJet { bore: 0.0, hub: 1e300, tan_spread: -1.0, decay: 1e9 };
        assert!(odd.speed(1e300, 1e300).is_finite());
    }
}
