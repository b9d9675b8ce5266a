//! The start of a lag in a run that starts warm: an unknown of the run, beside the law.
//!
//! Where the state of a lag exceeds the driver by d at the start, it exceeds the lagged driver by d exp(-t / tau) later. To first order a
//! law of it has one more column for each such run, whose coefficient is an unknown of the run (`initial/lags.rs` has it for a simulation).
//! It is used if it is plausible: the state of a lag has been within the range of its driver.

use super::hidden::Late;
use crate::evidence::Gain;
use crate::linearization::Linearization;
use nalgebra::DMatrix;
use physics::terms::Port;

/// Responses to exp(-t / tau) at a port.
pub(super) struct Decays {
    /// One column for each run that starts warm, for each time constant.
    columns: DMatrix<f64>,
    taus: Vec<f64>,
    runs: usize,
}

impl Decays {
    pub(super) fn new(point: &Linearization, port: Port, taus: &[f64]) -> Option<Decays> {
        let warm: Vec<usize> = point.warm_runs().collect();
        let columns = point.port_columns(port, taus.len() * warm.len(), |k, r, row, _| {
            let time = &point.slopes.tangents[r].time;
            let passed = (time[row] - time[0]) / taus[k / warm.len()];
            if r == warm[k % warm.len()] { (-passed).exp() } else { 0.0 }
        })?;
        Some(Decays { columns, taus: taus.to_vec(), runs: warm.len() })
    }

    /// Columns of laws, as many for each of these lags, each followed by those of its starts.
    fn beside(&self, laws: &DMatrix<f64>, late: &[&Late]) -> DMatrix<f64> {
        let width = laws.ncols() / late.len();
        let own = late.iter().enumerate().flat_map(|(k, late)| {
            let tau = self.taus.iter().position(|tau| *tau == late.lag.tau).unwrap_or(0);
            let law = (k * width..(k + 1) * width).map(|column| laws.column(column).into_owned());
            law.chain((0..self.runs).map(move |run| self.columns.column(tau * self.runs + run).into_owned()))
        });
        DMatrix::from_columns(&own.collect::<Vec<_>>())
    }

    /// Gains of laws, each with its starts where these are plausible and explain more than their price, that of a number each; `explain` has the
    /// gains of groups of columns, `span` the greatest less the least value of the law with this index.
    pub(super) fn gains(
        &self,
        laws: &DMatrix<f64>,
        late: &[&Late],
        explain: impl Fn(&DMatrix<f64>, usize) -> Vec<Option<Gain>>,
        span: impl Fn(&Gain, usize) -> f64,
        per_number: f64,
    ) -> Vec<Option<Gain>> {
        let plain = explain(laws, 0);
        if self.runs == 0 {
            return plain;
        }
        let with = explain(&self.beside(laws, late), self.runs);
        let is_plausible = |gain: &Gain, k: usize| {
            let starts = gain.size.iter().skip(gain.size.len() - self.runs);
            starts.map(|start| start.abs()).fold(0.0, f64::max) <= span(gain, k)
        };
        let best = |(k, (with, plain)): (usize, (Option<Gain>, Option<Gain>))| {
            let price = self.runs as f64 * per_number;
            let with = with.filter(|gain| is_plausible(gain, k)).map(|gain| gain.less(price));
            [with, plain].into_iter().flatten().max_by(|a, b| a.whitened.total_cmp(&b.whitened))
        };
        with.into_iter().zip(plain).enumerate().map(best).collect()
    }
}
