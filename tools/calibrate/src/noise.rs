//! How much a channel trembles by itself.
//!
//! e_k = y_k - [(t_{k+1} - t_k) y_{k-1} + (t_k - t_{k-1}) y_{k+1}] / (t_{k+1} - t_{k-1})              (1)
//! sigma = 1.4826 median |e_k| / sqrt(1 + a^2 + b^2),   a and b the two weights in (1)                (2)
//!
//! A row against the line between its neighbours: a quantity that changes slowly beside the rows leaves noise alone.
//! The median is deaf to the few rows where an input jumps.
//! *Assumes* white noise; one that drifts or is quantised coarser than itself reads as 0: [`LEAST`] then stands in.
//! *Source*: Gasser, Sroka, Jennen-Steinmetz, Biometrika 73 (1986) 625-633; 1.4826 makes the median of a normal
//! distribution its standard deviation.

use crate::experiment::Experiment;

/// Share of a channel's span that its noise is at least taken for.
const LEAST: f64 = 1e-5;

/// Standard deviation of the noise of one column of one run; `None` with fewer than five rows that were measured.
pub fn of_column(time: &[f64], column: &[f64]) -> Option<f64> {
    let mut sizes: Vec<f64> = (1..column.len().saturating_sub(1))
        .filter_map(|k| {
            let span = time[k + 1] - time[k - 1];
            let (a, b) = ((time[k + 1] - time[k]) / span, (time[k] - time[k - 1]) / span);
            let off = column[k] - a * column[k - 1] - b * column[k + 1];
            let size = off.abs() / (1.0 + a * a + b * b).sqrt();
            size.is_finite().then_some(size)
        })
        .collect();
    if sizes.len() < 3 {
        return None;
    }
    sizes.sort_by(f64::total_cmp);
    Some(1.4826 * sizes[sizes.len() / 2])
}

/// Standard deviations of all channels, inputs first, in SI units: what the experiment says, else the median of its
/// runs.
pub fn of_experiment(experiment: &Experiment) -> Vec<f64> {
    let channels = experiment.inputs.iter().chain(&experiment.outputs);
    channels
        .enumerate()
        .map(|(n, channel)| {
            if let Some(told) = experiment.noise.get(channel.column).filter(|told| **told > 0.0) {
                return *told;
            }
            let tables = || experiment.runs.iter().map(|r| &r.table);
            let mut all: Vec<f64> = tables().filter_map(|t| of_column(&t.time, &t.columns[n])).collect();
            all.sort_by(f64::total_cmp);
            let values = || tables().flat_map(|t| t.columns[n].iter().copied()).filter(|v| v.is_finite());
            let span = values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
            let least = if span.is_finite() { (LEAST * span).max(1e-12) } else { 1.0 };
            all.get(all.len() / 2).copied().unwrap_or(least).max(least)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slow wave with noise of standard deviation 0.2 (a uniform one of width 0.2 sqrt 12), rows at uneven times.
    #[test]
    fn noise_on_a_slow_wave() {
        let mut seed = 1u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        let time: Vec<f64> = (0..4000).map(|k| 2.0 * f64::from(k) + 0.5 * uniform()).collect();
        let normal = |u: &mut dyn FnMut() -> f64| (0..12).map(|_| u()).sum::<f64>() - 6.0;
        let column: Vec<f64> =
            time.iter().map(|t| 40.0 * (t / 800.0).sin() + 0.2 * normal(&mut uniform)).collect();
        let sigma = of_column(&time, &column).unwrap();
        assert!((sigma / 0.2 - 1.0).abs() < 0.05, "{sigma}");
        assert_eq!(of_column(&time[..4], &column[..4]), None);
    }
}
