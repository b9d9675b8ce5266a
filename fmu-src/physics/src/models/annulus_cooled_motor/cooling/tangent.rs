//! Linearized coefficients of the cooling: an evaluation of the correlations takes longer than a step of 1 ms and the coefficients
//! change slowly, so they are linearized between two evaluations.
//!
//! c(x, y) with the rises x of the housing and y of the node above ambient has the slopes
//!
//! c_x = (c(x + w, y) - c(x, y))/w,  c_y = (c(x, y + s) - c(x, y))/s                        (1)
//!
//! and serves for changes of x up to r and of y up to s. The linearization is compared with the full equations at (x - r, y - s). For
//! every function of one combination of x and y (of their difference, for example) the difference has the sign of the curvature, so
//! that none remains unseen; with w = r it is
//!
//! e = r^2 c_xx + s^2 c_yy + r s c_xy                                                       (2)
//!
//! and e (z^2 + z)/2 after the fraction z of r and s. The permitted changes are those after which the heat flows are wrong by a tolerance.
//!
//! Measured inputs change at every reading. The slope over an input u is c_u = (c(u) - c(u - v))/v with half of its permitted change
//! (the list in `mod.rs`) as v; it is computed when the input first changes.

use super::{Coefficients, Conditions, Cooling, INPUTS};
use crate::models::annulus_cooled_motor::parameters::Parameters;

/// Coefficients for one set of conditions, with their derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Tangent {
    /// Conditions of the evaluation.
    pub at: Conditions,
    base: Coefficients,
    /// Changes for a rise of the housing temperature by the reciprocal of `per_rise`.
    slope: Coefficients,
    per_rise: f64,
    /// Changes for a rise of the node's temperature by [`largest_of_node`], if there is a node.
    by_tube: Option<Coefficients>,
    /// Permitted changes of the temperatures of housing and node, K.
    reach: [f64; 2],
    /// Changes for a rise of each input by the part [`BACK`] of its permitted change; computed when the input first changes.
    by_input: [Option<Coefficients>; INPUTS],
}

/// Step w of the finite difference of the housing, K. The slope of natural convection then has the error that the accuracy of all modes
/// was measured with; where the coefficients bend more, w is r.
pub(super) const RISE: f64 = 1.0;
/// Largest temperature change without a new evaluation, K. For natural convection at 40 K above ambient the error is then 2e-5 of the
/// conductance.
const NEAR: f64 = 0.25;
/// The same for housing and node at ambient temperature, where natural convection is most nonlinear, K, and its increase per kelvin
/// above ambient. The finite difference of the node has this step.
const AT_REST: [f64; 2] = [0.02, 0.005];
const PER_KELVIN: f64 = 0.02;
/// Limit for the surface cooled by a coolant, K: coolant properties change by 2 % per kelvin, the conductance is tens of
/// times that of air, and the correlations take a tenth of the time of a fan's operating point.
const NEAR_COOLANT: f64 = 0.02;
/// Permitted error of the heat flows as a fraction of the larger one. The mean error is at most 5/12 of it and changes its sign with the
/// curvature, so that temperature rises are accurate to the 1e-6 of the thermal target.
pub(super) const TOLERANCE: f64 = 4e-6;
/// Rise that is added to the present one for the heat flows that the error is compared with, K: estimate of a small rise of a motor in use.
const IN_USE: f64 = 10.0;
/// Step of the finite difference of an input, as a part of its permitted change.
const BACK: f64 = 0.5;

impl Tangent {
    /// Coefficients before the first evaluation.
    pub const NONE: Tangent = Tangent {
        at: Conditions::NONE,
        base: Coefficients::NONE,
        slope: Coefficients::NONE,
        per_rise: 1.0,
        by_tube: None,
        reach: [0.0; 2],
        by_input: [None; INPUTS],
    };

    /// The linearization at these conditions with the largest reach.
    pub(super) fn new(cooling: &Cooling, parameters: &Parameters, at: Conditions) -> Tangent {
        let n = cooling.segments;
        let of = |at: &Conditions| cooling.coefficients(parameters, at);
        let base = of(&at);
        let change = |to: Conditions| {
            let mut to = of(&to);
            to.change(&base, -1.0, n);
            to
        };
        let reach = [largest_of_surface(&at, &base), largest_of_node(&at)];
        let slope = change(Conditions { surface: at.surface + RISE, ..at });
        let by_tube = cooling.has_node().then(|| change(Conditions { tube: at.tube + reach[1], ..at }));
        Tangent { at, base, slope, per_rise: 1.0 / RISE, by_tube, reach, by_input: [None; INPUTS] }
    }

    /// The linearization at these conditions, with a reach that follows from the curvature where the mode is not smooth.
    pub fn evaluate(&mut self, cooling: &Cooling, parameters: &Parameters, at: Conditions) {
        *self = Tangent::new(cooling, parameters, at);
        if !cooling.is_smooth() {
            self.refine(cooling, parameters);
        }
    }

    /// Measures the curvature and reduces the permitted changes where it is large.
    #[inline(never)]
    fn refine(&mut self, cooling: &Cooling, parameters: &Parameters) {
        let (n, at, largest, back) = (cooling.segments, self.at, self.reach, self.back());
        let full = cooling.coefficients(parameters, &back);
        if self.error(&full, &back, n) <= TOLERANCE {
            return;
        }
        self.slope = cooling.coefficients(parameters, &Conditions { surface: at.surface + largest[0], ..at });
        self.slope.change(&self.base, -1.0, n);
        self.per_rise = 1.0 / largest[0];
        let permitted = TOLERANCE / self.error(&full, &back, n);
        let z = 0.5 * ((1.0 + 8.0 * permitted).sqrt() - 1.0);
        self.reach = largest.map(|reach| z.min(1.0) * reach);
    }

    /// The conditions at which the linearization is compared with the full equations.
    pub(super) fn back(&self) -> Conditions {
        let (at, reach) = (self.at, self.reach);
        Conditions { surface: at.surface - reach[0], tube: at.tube - reach[1], ..at }
    }

    /// Error of the heat flows at `now`, where the coefficients are `full`, as a fraction of the larger one at a rise that is higher by
    /// [`IN_USE`].
    pub(super) fn error(&self, full: &Coefficients, now: &Conditions, n: usize) -> f64 {
        let mut line = Coefficients::NONE;
        self.follow(now, n, &mut line);
        let rise = IN_USE.copysign(now.surface - now.ambient);
        let warmer = Conditions { surface: now.surface + rise, tube: now.tube + rise, ..*now };
        let size = full.heats(&warmer, n).map(f64::abs);
        let (full, line) = (full.heats(now, n), line.heats(now, n));
        let error = (full[0] - line[0]).abs().max((full[1] - line[1]).abs());
        error / size[0].max(size[1]).max(f64::MIN_POSITIVE)
    }

    /// Whether the linearization is accurate enough at `now`.
    #[inline]
    pub fn serves(&self, now: &Conditions) -> bool {
        let at = &self.at;
        let changes = at.inputs().into_iter().zip(now.inputs()).map(|(from, to)| (to - from).abs());
        changes.zip(at.near()).all(|(change, near)| change <= near)
            && self.beyond(now).abs() <= self.reach[0]
            && (at.ambient - now.ambient).abs() <= NEAR
            && self.beyond_tube(now).abs() <= self.reach[1]
    }

    /// The coefficients with the changes of the temperatures since the evaluation.
    #[inline]
    fn follow(&self, now: &Conditions, n: usize, out: &mut Coefficients) {
        out.take(&self.base, &self.slope, self.beyond(now) * self.per_rise, n);
        if let Some(by_tube) = &self.by_tube {
            out.change(by_tube, self.beyond_tube(now) / largest_of_node(&self.at), n);
        }
    }

    /// Change of the node's excess temperature over ambient since the evaluation, K; without a node its temperature is no condition.
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

    /// The coefficients at the conditions of the evaluation.
    #[cfg(test)]
    pub fn base(&self) -> &Coefficients {
        &self.base
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
        self.follow(now, n, out);
        out.coolant_inlet = self.base.coolant_inlet.map(|_| now.coolant_inlet_temperature);
        let (at, base) = (self.at, &self.base);
        let (from, to, near) = (at.inputs(), now.inputs(), at.near());
        for (k, by_input) in self.by_input.iter_mut().enumerate() {
            if to[k] == from[k] {
                continue;
            }
            // Depends only on the conditions of the evaluation, so that the result does not depend on when it is computed.
            let step = BACK * near[k];
            let slope = by_input.get_or_insert_with(|| {
                let mut slope = *base;
                slope.change(&cooling.coefficients(parameters, &at.with_input(k, from[k] - step)), -1.0, n);
                slope
            });
            out.change(slope, (to[k] - from[k]) / step, n);
        }
    }
}

/// Largest change of the housing temperature without a new evaluation, K.
#[inline]
fn largest_of_surface(at: &Conditions, base: &Coefficients) -> f64 {
    let near = if base.coolant_inlet.is_some() { NEAR_COOLANT } else { NEAR };
    near.min(AT_REST[0] + PER_KELVIN * (at.surface - at.ambient).abs())
}

/// The same for the node.
#[inline]
fn largest_of_node(at: &Conditions) -> f64 {
    NEAR.min(AT_REST[1] + PER_KELVIN * (at.tube - at.ambient).abs())
}
