//! Coefficients of the cooling with their slopes: the correlations take longer than a step of a millisecond and change slowly,
//! so the network is linear between two evaluations.

use super::Cooling;
use super::coefficients::{Coefficients, Conditions};
use crate::models::annulus_cooled_motor::parameters::Parameters;

/// Coefficients for one set of conditions, with their slopes.
#[derive(Clone, Copy, Debug)]
pub struct Tangent {
    /// Where they hold.
    pub at: Conditions,
    base: Coefficients,
    /// Over the housing's temperature, per kelvin.
    slope: Coefficients,
    /// Over the tube's temperature, for the difference [`reach_tube`], where there is a tube.
    by_tube: Option<Coefficients>,
    /// Over the fan's command, for all of it; found when the command first moves.
    by_command: Option<Coefficients>,
}

/// Rise of the surface over which a slope is taken, K: 1, so that a difference is a slope.
const RISE: f64 = 1.0;
/// How far temperatures may move before the coefficients are evaluated anew, K. The error of a tangent is of
/// second order: at 40 K above ambient natural convection errs by 4e-6 of itself over this way.
const NEAR: f64 = 0.25;
/// How far the command may move, and over which way its slope is taken, both as a share of it. A flow that grows
/// with a power of the command is off by 1e-4 of itself at the end of this way.
const NEAR_COMMAND: f64 = 0.02;
const BACK: f64 = 0.01;
/// [`NEAR`] of the housing and of the tube where they are at ambient temperature and natural convection bends most, K, and what each
/// kelvin above adds. The tube's slope is taken over this difference.
const NEAR_AT_REST: f64 = 0.02;
const NEAR_AT_REST_TUBE: f64 = 0.005;
const PER_KELVIN: f64 = 0.02;

/// How far the coolant's inlet and the surface that it cools may move, K: its properties change by 2 % per kelvin, its
/// conductance is tens of times that of air, and its correlations take a tenth of the time of a fan's operating point.
const NEAR_COOLANT: f64 = 0.02;

impl Tangent {
    /// Coefficients that hold nowhere yet.
    pub const NONE: Tangent = Tangent {
        at: Conditions::NONE,
        base: Coefficients::NONE,
        slope: Coefficients::NONE,
        by_tube: None,
        by_command: None,
    };

    /// The tangent at these conditions.
    pub fn new(cooling: &Cooling, parameters: &Parameters, at: Conditions) -> Tangent {
        let n = cooling.segments;
        let base = cooling.coefficients(parameters, &at);
        let warmer = Conditions { surface: at.surface + RISE, ..at };
        let mut slope = Coefficients::NONE;
        cooling.coefficients(parameters, &warmer).along(&base, -1.0, n, &mut slope);
        let by_tube = cooling.has_tube().then(|| {
            let warmer = Conditions { tube: at.tube + reach_tube(&at), ..at };
            let mut slope = Coefficients::NONE;
            cooling.coefficients(parameters, &warmer).along(&base, -1.0, n, &mut slope);
            slope
        });
        Tangent { at, base, slope, by_tube, by_command: None }
    }

    /// Whether the tangent still serves at `now`.
    #[inline]
    pub fn serves(&self, now: &Conditions) -> bool {
        let at = &self.at;
        (at.command - now.command).abs() <= NEAR_COMMAND * at.command
            && at.pressure == now.pressure
            && at.coolant_flow == now.coolant_flow
            && (at.coolant_inlet - now.coolant_inlet).abs() <= NEAR_COOLANT
            && self.beyond(now).abs() <= self.reach()
            && (at.ambient - now.ambient).abs() <= NEAR
            && self.beyond_tube(now).abs() <= reach_tube(at)
    }

    /// How far the surface may move, K.
    #[inline]
    fn reach(&self) -> f64 {
        let near = if self.base.coolant_inlet.is_some() { NEAR_COOLANT } else { NEAR };
        near.min(NEAR_AT_REST + PER_KELVIN * (self.at.surface - self.at.ambient).abs())
    }

    /// The same of the tube, K; where there is none, its temperature is no condition.
    #[inline]
    fn beyond_tube(&self, now: &Conditions) -> f64 {
        if self.by_tube.is_none() {
            return 0.0;
        }
        (now.tube - now.ambient) - (self.at.tube - self.at.ambient)
    }

    /// How much further the surface is above ambient than where the tangent was taken, K.
    #[inline]
    fn beyond(&self, now: &Conditions) -> f64 {
        (now.surface - now.ambient) - (self.at.surface - self.at.ambient)
    }

    /// The coefficients at `now`, on the segments in use.
    #[inline]
    pub fn coefficients(
        &mut self,
        cooling: &Cooling,
        parameters: &Parameters,
        now: &Conditions,
        out: &mut Coefficients,
    ) {
        let n = cooling.segments;
        self.base.along(&self.slope, self.beyond(now), n, out);
        if let Some(by_tube) = &self.by_tube {
            let kept = *out;
            kept.along(by_tube, self.beyond_tube(now) / reach_tube(&self.at), n, out);
        }
        out.coolant_inlet = self.base.coolant_inlet.map(|_| now.coolant_inlet);
        if now.command != self.at.command {
            // It follows from where the tangent was taken alone, so that it is the same whenever it is found.
            let (base, at) = (&self.base, self.at);
            let by_command = self.by_command.get_or_insert_with(|| {
                let slower = Conditions { command: at.command * (1.0 - BACK), ..at };
                let mut slope = Coefficients::NONE;
                base.along(&cooling.coefficients(parameters, &slower), -1.0, n, &mut slope);
                slope
            });
            let share = (now.command / self.at.command - 1.0) / BACK;
            let kept = *out;
            kept.along(by_command, share, n, out);
        }
    }
}

/// How far the tube may move, K.
#[inline]
fn reach_tube(at: &Conditions) -> f64 {
    NEAR.min(NEAR_AT_REST_TUBE + PER_KELVIN * (at.tube - at.ambient).abs())
}
