//! Initial temperatures and lags that are estimated from the first rows adapt to a perturbation.

use super::{Direction, Tangent};
use crate::initial::columns::Column;
use crate::initial::{Starts, lags};
use crate::overrides::Override;
use crate::simulate::{Bench, Drive};

/// What the estimate of the initial temperatures takes out of a response.
#[derive(Clone, Debug)]
pub struct Adapted {
    outputs: usize,
    /// Response of all outputs at all rows, by [unknown](crate::initial::Started::unknowns) that is 1 greater.
    responses: Vec<Vec<f64>>,
    starts: Starts,
}

impl Adapted {
    /// `None` for a run whose initial temperatures are not estimated.
    pub fn new(bench: &Bench, drive: &Drive, change: &Override, tangent: &Tangent) -> Option<Adapted> {
        if !drive.estimates_start() {
            return None;
        }
        let (n, rows) = (tangent.states, tangent.time.len());
        let ways = drive.ways(change);
        let responses = ways.iter().enumerate().map(|(k, way)| {
            let mut warmer = tangent.unknowns.clone();
            warmer[k] += way;
            let mut states = Vec::with_capacity(n);
            bench.begin_at(drive, change, &warmer).ok()?.model.states(&mut states);
            let start = states.iter().zip(&tangent.at).map(|(to, from)| (to - from) / way).collect();
            let direction =
                Direction { start, rates: vec![0.0; rows * n], outputs: vec![0.0; rows * tangent.outputs] };
            Some(tangent.response(&direction, |_| 1.0))
        });
        let responses: Vec<Vec<f64>> = responses.collect::<Option<_>>()?;
        let (columns, outputs) = (drive.columns(change), tangent.outputs);
        let indicated = responses.iter().map(|r| indicated_by(&columns, outputs, r)).collect();
        let starts = Starts::new(&columns, indicated, &lags::ridges(change))?;
        Some(Adapted { outputs, responses, starts })
    }

    /// Subtracts from a response, rows times outputs, what the initial temperatures take over.
    pub fn adapt(&self, response: &mut [f64]) {
        let taken = self.starts.explaining(&indicated_by(self.starts.columns(), self.outputs, response));
        for (own, size) in self.responses.iter().zip(taken.iter()) {
            response.iter_mut().zip(own).for_each(|(value, own)| *value -= size * own);
        }
    }
}

/// A response as these columns have it.
fn indicated_by(columns: &[Column], outputs: usize, response: &[f64]) -> Vec<Vec<f64>> {
    columns.iter().map(|column| column.of_response(outputs, response)).collect()
}
