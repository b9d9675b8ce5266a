//! Linearized coefficients of the cooling: an evaluation of the correlations takes longer than a step of 1 ms and the coefficients
//! change slowly, so they are linearized between two evaluations.

use super::{Coefficients, Conditions, Cooling};
use crate::models::annulus_cooled_motor::parameters::Parameters;

/// Coefficients for one set of conditions, with their derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Tangent {
    /// Conditions of the evaluation.
    pub at: Conditions,
    base: Coefficients,
    /// Derivatives with respect to the housing temperature, 1/K.
    slope: Coefficients,
    /// Changes for a rise of the tube temperature by [`reach_tube`], if there is a tube.
    by_tube: Option<Coefficients>,
    /// Changes for a rise of the fan command by the fraction [`BACK`]; computed when the command first changes.
    by_command: Option<Coefficients>,
}

/// Temperature difference of the finite difference, K: 1, so that the difference equals the derivative.
const RISE: f64 = 1.0;
/// Temperature change that requires a new evaluation, K. The linearization error is of second order: for natural
/// convection at 40 K above ambient it is 4e-6 of the conductance at this limit.
const NEAR: f64 = 0.25;
/// Relative step of the finite difference of the fan command.
const BACK: f64 = 0.01;
/// [`NEAR`] of housing and tube at ambient temperature, where natural convection is most nonlinear, K, and its increase per
/// kelvin above ambient. The finite difference for the tube has this step.
const NEAR_AT_REST: f64 = 0.02;
const NEAR_AT_REST_TUBE: f64 = 0.005;
const PER_KELVIN: f64 = 0.02;

/// Limit for the surface cooled by a coolant, K: coolant properties change by 2 % per kelvin, the conductance is tens of
/// times that of air, and the correlations take a tenth of the time of a fan's operating point.
const NEAR_COOLANT: f64 = 0.02;

impl Tangent {
    /// Coefficients before the first evaluation.
    pub const NONE: Tangent = Tangent {
        at: Conditions::NONE,
        base: Coefficients::NONE,
        slope: Coefficients::NONE,
        by_tube: None,
        by_command: None,
    };

    /// The linearization at these conditions.
    pub fn new(cooling: &Cooling, parameters: &Parameters, at: Conditions) -> Tangent {
        let n = cooling.segments;
        let base = cooling.coefficients(parameters, &at);
        let warmer = Conditions { surface: at.surface + RISE, ..at };
        let mut slope = cooling.coefficients(parameters, &warmer);
        slope.change(&base, -1.0, n);
        let by_tube = cooling.has_node().then(|| {
            let warmer = Conditions { tube: at.tube + reach_tube(&at), ..at };
            let mut slope = cooling.coefficients(parameters, &warmer);
            slope.change(&base, -1.0, n);
            slope
        });
        Tangent { at, base, slope, by_tube, by_command: None }
    }

    /// The coefficients at the conditions of the evaluation.
    #[cfg(test)]
    pub fn base(&self) -> &Coefficients {
        &self.base
    }

    /// Whether the linearization is accurate enough at `now`.
    #[inline]
    pub fn serves(&self, now: &Conditions) -> bool {
        let at = &self.at;
        at.serve(now)
            && self.beyond(now).abs() <= self.reach()
            && (at.ambient - now.ambient).abs() <= NEAR
            && self.beyond_tube(now).abs() <= reach_tube(at)
    }

    /// Permitted change of the surface temperature, K.
    #[inline]
    fn reach(&self) -> f64 {
        let near = if self.base.coolant_inlet.is_some() { NEAR_COOLANT } else { NEAR };
        near.min(NEAR_AT_REST + PER_KELVIN * (self.at.surface - self.at.ambient).abs())
    }

    /// Change of the tube temperature above its limit, K; without a tube its temperature is no condition.
    #[inline]
    fn beyond_tube(&self, now: &Conditions) -> f64 {
        if self.by_tube.is_none() {
            return 0.0;
        }
        (now.tube - now.ambient) - (self.at.tube - self.at.ambient)
    }

    /// Change of the surface's excess temperature over ambient since the evaluation, K.
    #[inline]
    fn beyond(&self, now: &Conditions) -> f64 {
        (now.surface - now.ambient) - (self.at.surface - self.at.ambient)
    }

    /// The coefficients at `now`, for the segments in use.
    #[inline]
    pub fn coefficients(
        &mut self,
        cooling: &Cooling,
        parameters: &Parameters,
        now: &Conditions,
        out: &mut Coefficients,
    ) {
        let n = cooling.segments;
        out.take(&self.base, n);
        out.change(&self.slope, self.beyond(now), n);
        if let Some(by_tube) = &self.by_tube {
            out.change(by_tube, self.beyond_tube(now) / reach_tube(&self.at), n);
        }
        out.coolant_inlet = self.base.coolant_inlet.map(|_| now.coolant_inlet_temperature);
        if now.fan_command != self.at.fan_command {
            // Depends only on the conditions of the evaluation, so that the result does not depend on when it is computed.
            let (base, at) = (&self.base, self.at);
            let by_command = self.by_command.get_or_insert_with(|| {
                let slower = Conditions { fan_command: at.fan_command * (1.0 - BACK), ..at };
                let mut slope = *base;
                slope.change(&cooling.coefficients(parameters, &slower), -1.0, n);
                slope
            });
            let share = (now.fan_command / self.at.fan_command - 1.0) / BACK;
            out.change(by_command, share, n);
        }
    }
}

/// Permitted change of the tube temperature, K.
#[inline]
fn reach_tube(at: &Conditions) -> f64 {
    NEAR.min(NEAR_AT_REST_TUBE + PER_KELVIN * (at.tube - at.ambient).abs())
}
