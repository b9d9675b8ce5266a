//! Heat transfer, friction, fans: one correlation a file, pure functions with equation, range and source.
//!
//! Every function is finite for all finite arguments. Outside its range it returns the value at the limit or is
//! extrapolated as documented; none panics, none allocates. Combined correlations are continuous.

pub mod annulus_friction;
pub mod annulus_heat_transfer;
pub mod crossflow;
pub mod entrance_exit;
pub mod fan_curve;
pub mod jet;
pub mod natural_convection;
pub mod radiation;
pub mod tube_flow;

/// Reynolds number up to which the flow in a duct is laminar.
pub const RE_LAMINAR: f64 = 2300.0;
/// Reynolds number from which on the flow in a duct is turbulent.
pub const RE_TURBULENT: f64 = 4000.0;

/// Weight of turbulent flow at the Reynolds number `re` of a duct: 0 up to 2300, 1 from 4000 on, linear
/// between.
///
/// *Source*: Gnielinski, Int. J. Heat Mass Transfer 63 (2013) 134-140, who interpolates Nu in tubes in this way.
#[inline]
pub fn turbulent_share(re: f64) -> f64 {
    ((re.abs() - RE_LAMINAR) / (RE_TURBULENT - RE_LAMINAR)).clamp(0.0, 1.0)
}

/// Helpers for the tests of the correlations.
#[cfg(test)]
pub(crate) mod checks {
    /// `computed` is within the relative `tolerance` of `expected`.
    #[track_caller]
    pub fn close(computed: f64, expected: f64, tolerance: f64) {
        let error = (computed / expected - 1.0).abs();
        assert!(error <= tolerance, "{computed} instead of {expected}: {error:.2e} > {tolerance:.0e}");
    }

    /// `f` jumps by less than 1e-3 of its value between two correlations at `x`.
    #[track_caller]
    pub fn continuous(f: impl Fn(f64) -> f64, x: f64) {
        let d = 1e-9 * x.abs().max(1e-3);
        let (left, at, right) = (f(x - d), f(x), f(x + d));
        let jump = (right - left).abs().max((at - left).abs()) / at.abs().max(1e-12);
        assert!(jump <= 1e-3, "at {x}: {left}, {at}, {right}");
    }

    /// Rows of a comma-separated text without its header; an empty field is NaN.
    pub fn rows(csv: &str) -> Vec<Vec<f64>> {
        let number = |s: &str| s.parse().unwrap_or(f64::NAN);
        csv.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn share_of_turbulence_at_its_corners() {
        assert_eq!(turbulent_share(0.0), 0.0);
        assert_eq!(turbulent_share(2300.0), 0.0);
        assert_eq!(turbulent_share(3150.0), 0.5);
        assert_eq!(turbulent_share(-4000.0), 1.0);
        assert_eq!(turbulent_share(1e9), 1.0);
    }
}
