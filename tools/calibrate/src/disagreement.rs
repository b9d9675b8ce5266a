//! Disagreement between runs of one rig beyond the sensor noise, modelled as additional noise.
//!
//! y_k = y(t_k; p) + d_i(t_k) + e_k,   d_i ~ (0, tau^2) in run i, e_k ~ (0, sigma^2)                        (1)
//! g = 1 + 2 sum_k rho_k,   n_eff = n / g                                                                 (2)
//! tau^2 = RSS / n * n_eff / (n_eff - gamma) - sigma^2,   gamma = tr[N_c (N + L)^-1]                       (3)
//! variance of a reading in the fit: sigma^2 + kappa^2 g tau^2                                            (4)
//!
//! d_i is the deviation of run i from one model of all runs, caused by the position of a sensor, the phase that carries the current, or
//! a heat path missing in the model. It changes slowly, so n readings of a run are worth n_eff independent ones; rho_k are the
//! autocorrelations of the residual about zero. (3) is the residual variance of an output that determines gamma parameters (N_c is its
//! information, N that of all outputs, L that of the priors). A few runs determine tau poorly. Its scale kappa is therefore chosen by
//! leave-one-file-out validation, with the left-out runs' own parameters at their priors. kappa = 0, the plain fit, is kept if it
//! predicts left-out runs at least as well as the preset.
//!
//! score = sum_c ln max(MSE_c, sigma_c^2)   over all left-out readings                                     (5)
//!
//! *Sources*: Kennedy, O'Hagan, J. R. Stat. Soc. B 63 (2001) 425-464 (discrepancy); Geyer, Statistical Science 7 (1992) 473-483 (2), with
//! the initial positive sequence; MacKay, Neural Computation 4 (1992) 415-447 (3); Stone, J. R. Stat. Soc. B 36 (1974) 111-147 (choice by
//! prediction). (5) is the normal density at the best variance of each output.
//!
//! An effect that acts only in some runs also makes runs disagree. The search therefore also starts from the plain fit, and the model
//! with the smaller misfit in the fit and validation runs is kept (`close_loop`).

use crate::CalibrateError;
use crate::fit::Fitted;
use crate::hypothesis::Hypothesis;
use crate::parallel;
use crate::setup::Setup;
use nalgebra::DMatrix;

/// Largest number of iterations of (3) and the fit. Numerical: a limit of effort; the scale of (4) is chosen afterwards.
const REPETITIONS: usize = 8;
/// Relative change of the standard deviations for convergence. Numerical: a few runs determine them to 20 % at best, 1 / sqrt(2 n).
const AGREES: f64 = 0.05;
/// Relative size of singular values that count as zero. Numerical: rounding of sums over 1e4 readings.
const ROUNDING: f64 = 1e-12;
/// Scales of (4) that are compared, in addition to 0. Numerical: the prediction of a few left-out runs determines the scale to a factor
/// of two at best.
const SCALES: [f64; 8] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Residual of one output over runs.
struct Residual {
    squares: f64,
    count: f64,
    /// g of (2).
    memory: f64,
}

/// Noise and fit including the disagreement between runs.
pub struct Disagreement<'a> {
    /// The setup with this noise.
    pub setup: Setup<'a>,
    /// The fit with this noise.
    pub fitted: Fitted,
    /// Whether the plain fit's model stops at a validity limit during its own fit runs, although the measured motor did not.
    pub is_plain_refuted: bool,
}

impl<'a> Setup<'a> {
    /// The disagreement between runs, if a plain fit predicts left-out runs worse than the preset; otherwise `None`.
    ///
    /// # Errors
    /// The model's error if the preset cannot be simulated.
    pub fn between_runs(
        &self,
        plain: &Fitted,
        runs: &[usize],
    ) -> Result<Option<Disagreement<'a>>, CalibrateError> {
        if plain.readings < self.declared.len() {
            return Ok(None);
        }
        let strict = self.strict();
        let preset = self.preset();
        let before = strict.score(&preset, runs)?;
        // A plain fit without predictions of left-out runs has infinite error.
        let kept = strict.score_left_out(&plain.hypothesis, runs).unwrap_or(f64::INFINITY);
        if kept <= before || self.deadline().is_near() {
            return Ok(None);
        }
        let Ok(added) = self.estimated_between_runs(runs) else { return Ok(None) };
        let mut best: Option<(f64, Fitted, Vec<f64>)> = None;
        for scale in SCALES {
            let own: Vec<f64> = added.iter().map(|a| scale * a).collect();
            let other = strict.with_between_runs(&own);
            let Ok(fitted) = other.settled(preset.clone(), runs) else { continue };
            let score = other.score_left_out(&fitted.hypothesis, runs).unwrap_or(f64::INFINITY);
            if best.as_ref().is_none_or(|(least, ..)| score < *least) {
                best = Some((score, fitted, own));
            }
            if self.deadline().is_near() {
                break;
            }
        }
        let Some((_, fitted, own)) = best.filter(|(score, ..)| *score < kept) else { return Ok(None) };
        let setup = self.with_between_runs(&own);
        let fitted = setup.judged(fitted.hypothesis, runs)?;
        let is_plain_refuted = !strict.score(&plain.hypothesis, runs).is_ok_and(f64::is_finite);
        Ok(Some(Disagreement { setup, fitted, is_plain_refuted }))
    }

    /// The setup with the additional standard deviations (4) of the outputs.
    pub(crate) fn with_between_runs(&self, added: &[f64]) -> Self {
        let mut other = self.clone();
        let inputs = self.experiment.inputs.len();
        for (k, added) in added.iter().enumerate() {
            other.noise[inputs + k] = self.sensor_noise(k).hypot(*added);
        }
        other.between = added.to_vec();
        other
    }

    /// The standard deviation of each output due to disagreement between these runs, (4) with kappa = 1.
    fn estimated_between_runs(&self, runs: &[usize]) -> Result<Vec<f64>, CalibrateError> {
        let of = |fitted: &Fitted, own: &[f64]| -> Result<Vec<f64>, CalibrateError> {
            let informations = self.with_between_runs(own).informations(fitted, runs)?;
            let mut whole: DMatrix<f64> = informations.iter().sum();
            // In units of the prior deviations.
            (0..self.declared.len())
                .for_each(|k| whole[(k, k)] += f64::from(u8::from(!self.declared[k].is_free)));
            let inverse = whole.pseudo_inverse(ROUNDING).map_err(|e| CalibrateError(e.to_string()))?;
            let left = self.residuals(fitted, runs);
            Ok(left
                .iter()
                .zip(&informations)
                .enumerate()
                .map(|(k, (left, own))| {
                    if left.count == 0.0 {
                        return 0.0;
                    }
                    let independent = left.count / left.memory;
                    let used =
                        (own * &inverse).trace().clamp(0.0, independent - 1.0f64.min(0.5 * independent));
                    let variance = left.squares / left.count * independent / (independent - used);
                    (left.memory * (variance - self.sensor_noise(k).powi(2)).max(0.0)).sqrt()
                })
                .collect())
        };
        // The iteration starts at the preset, whose residual gives the largest disagreement.
        let mut fitted = self.judged(self.preset(), runs)?;
        let mut added = of(&fitted, &self.unfitted(&fitted, runs))?;
        for _ in 0..REPETITIONS {
            fitted = self.with_between_runs(&added).settled(fitted.hypothesis, runs)?;
            let next = of(&fitted, &added)?;
            let settled = added.iter().zip(&next).all(|(a, b)| (a - b).abs() <= AGREES * a.max(*b));
            added = next;
            if settled || self.deadline().is_near() {
                break;
            }
        }
        Ok(added)
    }

    /// The root of g RSS / n for each output, without the correction for fitted parameters.
    fn unfitted(&self, fitted: &Fitted, runs: &[usize]) -> Vec<f64> {
        let left = self.residuals(fitted, runs);
        left.iter()
            .map(|l| if l.count > 0.0 { (l.memory * l.squares / l.count).sqrt() } else { 0.0 })
            .collect()
    }

    /// Residual of each output of a model.
    fn residuals(&self, fitted: &Fitted, runs: &[usize]) -> Vec<Residual> {
        let m = self.outputs();
        let mut series: Vec<Vec<Vec<f64>>> = vec![Vec::new(); m];
        for (run, shown) in runs.iter().zip(&fitted.shown) {
            series.iter_mut().for_each(|s| s.push(Vec::new()));
            self.each(*run, shown, |_, output, off| {
                if let Some(last) = series[output].last_mut() {
                    last.push(off);
                }
            });
        }
        series.iter().map(|runs| residual(runs)).collect()
    }

    /// Groups runs by file.
    pub(crate) fn files_of(&self, runs: &[usize]) -> Vec<Vec<usize>> {
        let mut files: Vec<Vec<usize>> = Vec::new();
        for run in runs {
            let name = |run: usize| &self.experiment.runs[run].file;
            match files.iter_mut().find(|known| name(known[0]) == name(*run)) {
                Some(known) => known.push(*run),
                None => files.push(vec![*run]),
            }
        }
        files
    }

    /// Eq. (5) of leave-one-file-out fits; of the fit itself if there is only one file.
    fn score_left_out(&self, start: &Hypothesis, runs: &[usize]) -> Result<f64, CalibrateError> {
        let files = self.files_of(runs);
        if files.len() < 2 {
            return self.score(start, runs);
        }
        let one = |left_out: &Vec<usize>| -> Result<Vec<(f64, usize)>, CalibrateError> {
            let others: Vec<usize> = runs.iter().copied().filter(|run| !left_out.contains(run)).collect();
            let fitted = self.fit(self.without_unknowns_of(start, left_out), &others)?;
            Ok(self.squares(left_out, &self.show(&fitted.hypothesis, left_out)?))
        };
        let parts = parallel::map(&files, one).into_iter().collect::<Result<Vec<_>, _>>()?;
        Ok(self.score_of(&parts))
    }

    /// Eq. (5) of a model, with the parameters of single runs at their priors.
    fn score(&self, hypothesis: &Hypothesis, runs: &[usize]) -> Result<f64, CalibrateError> {
        Ok(self.score_of(&[self.squares(runs, &self.show(hypothesis, runs)?)]))
    }

    fn score_of(&self, parts: &[Vec<(f64, usize)>]) -> f64 {
        let one = |k: usize| {
            let (sum, count) = parts.iter().fold((0.0, 0), |(s, n), part| (s + part[k].0, n + part[k].1));
            let least = self.sensor_noise(k).powi(2);
            if count == 0 { 0.0 } else { (sum / count as f64).max(least).ln() }
        };
        let score: f64 = (0..self.outputs()).map(one).sum();
        if score.is_nan() { f64::INFINITY } else { score }
    }

    /// A hypothesis with the parameters of these single runs at their prior means.
    fn without_unknowns_of(&self, hypothesis: &Hypothesis, runs: &[usize]) -> Hypothesis {
        let mut other = hypothesis.clone();
        for (value, d) in other.declared.iter_mut().zip(&self.declared) {
            if d.runs.as_ref().is_some_and(|own| own.iter().any(|run| runs.contains(run))) {
                *value = d.prior;
            }
        }
        other
    }
}

/// Sum of squares, number of readings and autocorrelation factor g of an output's residuals, over all runs.
fn residual(runs: &[Vec<f64>]) -> Residual {
    let product = |lag: usize| -> f64 {
        runs.iter().flat_map(|r| r.iter().zip(r.iter().skip(lag))).map(|(a, b)| a * b).sum()
    };
    let count: usize = runs.iter().map(Vec::len).sum();
    let longest = runs.iter().map(Vec::len).max().unwrap_or(0);
    let squares = product(0);
    let mut memory = 1.0;
    let mut lag = 1;
    // Sums of adjacent autocorrelations of a reversible chain are positive; the first sum that is not positive is noise.
    while squares > 0.0 && lag + 1 < longest {
        let pair = (product(lag) + product(lag + 1)) / squares;
        if pair <= 0.0 {
            break;
        }
        memory += 2.0 * pair;
        lag += 2;
    }
    // A run has at least one independent reading.
    let measured = runs.iter().filter(|r| !r.is_empty()).count().max(1);
    let most = (count as f64 / measured as f64).max(1.0);
    Residual { squares, count: count as f64, memory: memory.min(most) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Experiment, Role};
    use crate::testing;

    /// g is 1 for white noise and (1 + a) / (1 - a) for an AR(1) process with coefficient a; a constant offset is one reading.
    #[test]
    fn memory_of_noise_of_a_process_and_of_an_offset() {
        let mut rng = testing::rng(3);
        let mut process = |a: f64| -> Vec<Vec<f64>> {
            let mut run = || {
                let mut x = 0.0;
                let next = |_| {
                    x = a * x + testing::normal(&mut rng);
                    x
                };
                (0..4000).map(next).collect()
            };
            vec![run(), run()]
        };
        let white = residual(&process(0.0));
        assert!((white.memory - 1.0).abs() < 0.2, "{}", white.memory);
        assert!((white.squares / white.count - 1.0).abs() < 0.05);
        let slow = residual(&process(0.8));
        assert!((slow.memory / 9.0 - 1.0).abs() < 0.2, "{}", slow.memory);
        let offset = residual(&[vec![0.5; 100], vec![-0.5; 100]]);
        // Sum of the autocorrelations of n readings over all lags: n^2, half of them twice, divided by n.
        assert!((offset.memory / 100.0 - 1.0).abs() < 1e-3, "{}", offset.memory);
        assert_eq!(residual(&[vec![], vec![]]).squares, 0.0);
    }

    const PRIORS: &str = "\"thermal.C_w\" = 1.0\n\"thermal.C_h\" = 1.0\n\"thermal.R_wh\" = 1.0\n\
                          \"conductance.G_still\" = 1.0";

    /// Three fit runs and a test run of the preset's own motor, each with the position of its winding sensor as an unknown. The
    /// indicated rise of the winding deviates by the fraction `off[k]`, which grows over the run; that of the housing by the opposite.
    fn runs(off: [f64; 3]) -> Experiment {
        use crate::experiment::{Deviation, Prior};
        let mut experiment = testing::experiment(PRIORS, true);
        let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &preset, None);
        let name = "effect.winding_sensor_stem_loss.k".to_string();
        let seat = Prior { name, deviation: Deviation::Absolute(0.1) };
        let first = experiment.runs[0].clone();
        let outputs = experiment.inputs.len();
        let mut rng = testing::rng(11);
        let all = off.into_iter().map(Some).chain([None]).enumerate().map(|(k, off)| {
            let mut run = first.clone();
            run.file = format!("run-{k}.csv");
            (run.role, run.priors) =
                if off.is_some() { (Role::Fit, vec![seat.clone()]) } else { (Role::Test, Vec::new()) };
            for column in &mut run.table.columns[outputs..] {
                column.iter_mut().for_each(|x| *x += testing::NOISE * testing::normal(&mut rng));
            }
            let off = off.unwrap_or(0.0);
            for (column, part) in run.table.columns[outputs + 2..].iter_mut().zip([off, -off]) {
                let (cold, rows) = (column[0], column.len() as f64);
                let grown = column.iter_mut().enumerate();
                grown.for_each(|(row, x)| *x += part * row as f64 / rows * (*x - cold));
            }
            run
        });
        experiment.runs = all.collect();
        experiment
    }

    /// Error of the winding's temperature in the test run.
    fn tested(setup: &Setup, fitted: &Fitted) -> f64 {
        setup.rmse(&[3], &setup.show(&fitted.hypothesis, &[3]).unwrap())[2]
    }

    /// If all runs are of one motor, the result is the plain fit.
    #[test]
    fn runs_that_agree_are_fitted_as_they_are() {
        let experiment = runs([0.0; 3]);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let plain = setup.refit(&[0, 1, 2]).unwrap();
        assert!(setup.between_runs(&plain, &[0, 1, 2]).unwrap().is_none());
        assert_eq!(setup.sensor_noise(2), setup.sigma(2));
    }

    /// Sensor errors that are a different fraction of the rise in each run. The plain fit compensates for them with motor parameters and
    /// sensor positions and predicts a further run worse than the preset, which is correct; with the disagreement as noise it does not.
    #[test]
    fn runs_that_disagree_do_not_mislead_the_fit() {
        let experiment = runs([0.5, -0.4, -0.2]);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let plain = setup.refit(&[0, 1, 2]).unwrap();
        let worse = tested(&setup, &plain);
        let found = setup.between_runs(&plain, &[0, 1, 2]).unwrap().unwrap();
        let better = tested(&found.setup, &found.fitted);
        // The plain fit is still a valid start of the search: its model completes its own runs.
        assert!(!found.is_plain_refuted);
        assert!(found.setup.between[2] > 10.0 * setup.sigma(2), "{:?}", found.setup.between);
        assert!(better < 0.5 * worse, "{better} K instead of {worse} K");
        for k in 0..4 {
            assert!((found.setup.sensor_noise(k) - setup.sigma(k)).abs() < 1e-6, "output {k}");
        }
    }
}
