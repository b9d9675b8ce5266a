//! A substep of the network beside winding and stator.

use super::{FIRST, Inflow, Network, ROTOR, mean};
use crate::line::Line;
use crate::solver::stabilized::{MOST, Stabilized, States, error};
use std::array::from_fn;

/// Number of states of a network with a few segments.
const FEW: usize = 12;

/// Time integrals of winding and stator over a substep.
#[derive(Clone, Copy, Debug)]
pub struct CouplingIntegrals {
    /// Integral of the winding temperature, K.s.
    pub winding: f64,
    /// Integral of the stator temperature, K.s.
    pub stator: f64,
    /// Friction heat, J.
    pub friction: f64,
}

/// Result of a substep.
#[derive(Clone, Copy, Debug)]
pub struct Advance {
    /// Heat that winding and stator gave to the network, J.
    pub left: f64,
    /// Heat that the network gave to ambient, J.
    pub to_ambient: f64,
    /// Ratio of the error estimate to the tolerance.
    pub error: f64,
}

impl Network {
    /// Mean heat flows over a substep of `h` seconds into the rotor and the segments, W, from the time integrals of winding and stator
    /// temperature and the friction energy, with rotor and housing linear in time. Last result: the heat that left winding and stator, J.
    fn mean_inflow<const M: usize>(
        &self,
        rates: &States,
        h: f64,
        integrals: &CouplingIntegrals,
    ) -> (f64, [f64; M], f64) {
        let body = &self.body;
        let &CouplingIntegrals { winding, stator, friction } = integrals;
        let to_housing = self.friction_of_segment(friction);
        let along = |k: usize| h * (self.states[k] + 0.5 * h * rates[k]);
        let from_winding = body.winding_to_rotor * (winding - along(ROTOR));
        let mut left = from_winding;
        let rotor = (from_winding + friction * body.friction_to_rotor) / h;
        let mut segments = [0.0; M];
        for (k, segment) in segments.iter_mut().enumerate().take(body.segments) {
            let q = body.from_stator * (stator - along(FIRST + k));
            left += q;
            *segment = (q + to_housing) / h;
        }
        (rotor, segments, left)
    }

    /// Computes a substep of `h` seconds: `rates` are the derivatives at its start with the heat flows `at_start`, `integrals`
    /// those of winding and stator over the substep; ambient is linear in time. [`accept`](Self::accept) accepts the result.
    pub fn advance(
        &mut self,
        h: f64,
        start: (&States, &Inflow),
        integrals: &CouplingIntegrals,
        ambient: Line,
    ) -> Advance {
        match self.body.states() {
            ..=FEW => self.advance_of::<FEW>(h, start, integrals, ambient),
            _ => self.advance_of::<MOST>(h, start, integrals, ambient),
        }
    }

    /// The same with at most `M` states, because short arrays are copied faster.
    fn advance_of<const M: usize>(
        &mut self,
        h: f64,
        (rates, at_start): (&States, &Inflow),
        integrals: &CouplingIntegrals,
        ambient: Line,
    ) -> Advance {
        let (n, count) = (self.body.segments, self.body.states());
        let (into_rotor, into_segment, left) = self.mean_inflow::<M>(rates, h, integrals);
        let stiffness = h * self.fastest;
        if stiffness > self.method.stiffness() || self.method.stages() > 2 {
            self.method = Stabilized::for_stiffness(stiffness);
        }
        self.states[FIRST + n] = 0.0;
        // `rates` belongs to the heat flows at the start; the derivatives are linear in them.
        let [start, mut first]: [[f64; M]; 2] = [&self.states, rates].map(|all| from_fn(|k| all[k]));
        let [rotor, _, segment] = self.body.per_joule;
        first[ROTOR] += (into_rotor - at_start.rotor) * rotor;
        for k in 0..n {
            first[FIRST + k] += (into_segment[k] - self.heat_of_segment(at_start, k)) * segment;
        }
        let into = |k: usize| into_segment[k];
        let at =
            |t: f64, y: &[f64; M], out: &mut [f64; M]| self.rates(ambient.at(t), (into_rotor, into), y, out);
        let end = self.method.step(count, &start, &first, h, at);
        let mut worst = self.miss(rates, &end, h);
        // Bound of the local error, (h lambda)^2 h y'/6. At steps of milliseconds it is far below the rounding error of the
        // error estimate; the estimate's extra evaluation is needed only for larger bounds.
        let steepest = first[..FIRST + n].iter().fold(0.0f64, |m, r| m.max(r.abs()));
        if stiffness * stiffness * h * steepest > 0.1 * self.tolerance {
            let mut last = [0.0; M];
            at(h, &end, &mut last);
            for k in 0..FIRST + n {
                worst = worst.max(error(start[k], first[k], end[k], last[k], h).abs());
            }
        }
        self.next[..M].copy_from_slice(&end);
        let over = if stiffness > self.method.stiffness() { f64::INFINITY } else { worst / self.tolerance };
        Advance { left, to_ambient: end[FIRST + n], error: over }
    }

    /// Error of the stator temperature over a substep because the housing temperature is not linear in time, K: a third of
    /// the difference at the end (for a parabola), times the fraction of its heat that the stator exchanges.
    fn miss(&self, rates: &States, end: &[f64], h: f64) -> f64 {
        let n = self.body.segments;
        let line = self.housing_temperature() + h * self.housing_rate(rates);
        let off = mean(&end[FIRST..FIRST + n]) - line;
        let exchange = h
            * self.body.from_stator
            * n as f64
            * (1.0 / self.body.stator + 1.0 / (n as f64 * self.body.capacity[2]));
        (off * exchange / 3.0).abs()
    }

    /// Accepts the states at the end of the last substep.
    pub fn accept(&mut self) {
        // A copy of a fixed length is not a call.
        match self.body.states() {
            ..=FEW => self.states[..FEW].copy_from_slice(&self.next[..FEW]),
            _ => self.states = self.next,
        }
    }
}
