//! Propagation of input noise to the outputs of a model, inputs whose noise causes autocorrelated output noise, and loads that alternate
//! from row to row.
//!
//! sigma_y <= sigma_r,   sigma_u <= sigma_r / |dy/du|                                                  (1)
//!
//! u' = u + K (r - r_m),   K = J sigma_u^2 / (sigma_s^2 + J^2 sigma_u^2)                              (2)
//!
//! sigma_r is the noise of the residual of output y by eq. (2) of `noise.rs`, |dy/du| the rms response of y to an input in the same row. The
//! model describes changes between rows that eq. (2) takes for noise in the readings themselves.
//!
//! (2) is the estimate of an input from its reading and from an output that its noise reaches within a row by J, and whose sensor is the
//! better one: a current near 0 is known from its own reading, and not from the difference of a voltage and a back-EMF that both vary. r is
//! the residual of the output, r_m its mean over neighbours that agree to within noise, so that what is slow stays in the residual. It is
//! used where this output is 0 to within noise: a law over it that makes the model insensitive to its inputs would otherwise explain the
//! noise.
//!
//! Where rows differ much in the noise that inputs cause, each reading has a weight of its own: [`Setup::weights`].
//! *Source*: Gelb (ed.), Applied Optimal Estimation (1974), sec. 4.2 (gain K).

use crate::CalibrateError;
use crate::experiment::Role;
use crate::fit::Slopes;
use crate::hypothesis::Hypothesis;
use crate::levels::{CERTAIN, FACTOR, NEARLY, NEGLIGIBLE};
use crate::noise::{self, is_new_in_every_row, is_stated, least, of_columns};
use crate::setup::Setup;
use crate::smoothing::smoothed;
use crate::tangent::{Direction, Probe, Tangent};
use std::sync::Arc;

/// Readings of an output in a run, and their residual.
struct Column<'a> {
    time: &'a [f64],
    read: Vec<f64>,
    left: Vec<f64>,
}

impl Setup<'_> {
    /// Adds the noise that inputs cause within a row to the noise of each output, finds the inputs whose noise is autocorrelated at an
    /// output, and stores the drivers along the runs.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn include_input_noise(
        &mut self,
        hypothesis: &Hypothesis,
        runs: &[usize],
    ) -> Result<(), CalibrateError> {
        let (m, inputs) = (self.outputs(), self.experiment.inputs.len());
        let left = self.lower_noise(hypothesis, runs)?;
        let mut slopes = self.input_sensitivities(hypothesis, runs)?;
        let slow = |input: &usize| {
            let (direct, whole) = self.variances(&slopes, |k| k == *input);
            (0..m).any(|k| whole[k] - direct[k] > (NEGLIGIBLE * self.sigma(k)).powi(2))
        };
        let remembered = (0..inputs).filter(slow).collect();
        let (direct, _) = self.variances(&slopes, |_| true);
        let known: Vec<f64> = (0..m).map(|output| self.sigma(output)).collect();
        self.remembered = remembered;
        self.reached = Arc::new(slopes.tangents.iter().flat_map(|t| t.drivers.iter().copied()).collect());
        self.weigh(&mut slopes, &direct, hypothesis)?;
        for (output, direct) in direct.into_iter().enumerate() {
            self.noise[inputs + output] = self.sigma(output).hypot(direct.sqrt());
            self.lower(output, left[output]);
        }
        self.correct_inputs(&mut slopes, &known, hypothesis)
    }

    /// Adds the validation runs to linearised runs, unless they are there.
    fn linearise_validation(
        &self,
        slopes: &mut Slopes,
        hypothesis: &Hypothesis,
    ) -> Result<(), CalibrateError> {
        let others = self.runs(Role::Validate).into_iter().filter(|run| !slopes.runs.contains(run));
        slopes.extend(self.input_sensitivities(hypothesis, &others.collect::<Vec<_>>())?);
        Ok(())
    }

    /// Weighs the readings of linearised runs and of the validation runs by the noise that inputs cause in their rows, where rows differ in
    /// it. `means` are the means of their variances.
    fn weigh(
        &mut self,
        slopes: &mut Slopes,
        means: &[f64],
        hypothesis: &Hypothesis,
    ) -> Result<(), CalibrateError> {
        let m = self.outputs();
        let own = self.direct_variances(slopes);
        self.weights = Arc::default();
        let noise = |output: usize, variance: f64| self.sigma(output).hypot(variance.sqrt());
        // Least and greatest noise of a row. Readings that differ by less have about the same weight, and rows by which structure errors show
        // keep theirs.
        let ends = |output: usize| {
            let all = own.iter().flat_map(|run| run.iter().skip(output).step_by(m));
            let all = all.map(|variance| noise(output, *variance));
            all.fold((f64::INFINITY, 0.0f64), |(a, b), x| (a.min(x), b.max(x)))
        };
        let ends: Vec<(f64, f64)> = (0..m).map(ends).collect();
        let differs: Vec<bool> = ends.iter().map(|(least, most)| *most > FACTOR * least).collect();
        if !differs.contains(&true) {
            return Ok(());
        }
        let of_run = |variances: &Vec<f64>| -> Vec<f64> {
            let of = |(k, variance): (usize, &f64)| {
                let output = k % m;
                if differs[output] { noise(output, means[output]) / noise(output, *variance) } else { 1.0 }
            };
            variances.iter().enumerate().map(of).collect()
        };
        self.linearise_validation(slopes, hypothesis)?;
        let mut weights = vec![Vec::new(); self.experiment.runs.len()];
        for (run, variances) in slopes.runs.iter().zip(&self.direct_variances(slopes)) {
            weights[*run] = of_run(variances);
        }
        self.weights = Arc::new(weights);
        Ok(())
    }

    /// Variance of each reading due to white input noise within its row, for linearised runs.
    fn direct_variances(&self, slopes: &Slopes) -> Vec<Vec<f64>> {
        let of_run =
            |(r, tangent): (usize, &Tangent)| tangent.direct_variance(&self.noises(slopes, r, |_| true));
        slopes.tangents.iter().enumerate().map(of_run).collect()
    }

    /// How the inputs that `heard` selects act in the `r`-th linearised run, with their noise.
    fn noises<'s>(
        &self,
        slopes: &'s Slopes,
        r: usize,
        heard: impl Fn(usize) -> bool,
    ) -> Vec<(&'s Direction, f64)> {
        let known = slopes.further(r, self.experiment.inputs.len()).iter().zip(&self.noise).enumerate();
        let known = known.filter(|(k, _)| heard(*k));
        known.filter_map(|(_, (direction, sigma))| Some((direction.as_ref()?, *sigma))).collect()
    }

    /// Eq. (2) for linearised runs and the validation runs; `known` are the deviations of the sensors of the outputs.
    fn correct_inputs(
        &mut self,
        slopes: &mut Slopes,
        known: &[f64],
        hypothesis: &Hypothesis,
    ) -> Result<(), CalibrateError> {
        let (m, inputs) = (self.outputs(), self.experiment.inputs.len());
        // The zero of a temperature means nothing.
        let better = |k: &usize| {
            !self.experiment.outputs[*k].is_temperature() && self.sigma(*k).powi(2) > 2.0 * known[*k].powi(2)
        };
        let ratio = |k: &usize| self.sigma(*k) / known[*k];
        let Some(output) = (0..m).filter(better).max_by(|a, b| ratio(a).total_cmp(&ratio(b))) else {
            return Ok(());
        };
        self.linearise_validation(slopes, hypothesis)?;
        let shown = self.exact().show(hypothesis, &slopes.runs)?;
        let mut smooth = Vec::clone(&self.smooth);
        for (r, run) in slopes.runs.iter().enumerate() {
            let table = &self.experiment.runs[*run].table;
            let read = &table.columns[inputs + output];
            let mut left = vec![f64::NAN; table.time.len()];
            self.each(*run, &shown[r], |row, own, off| {
                if own == output && read[row].abs() < CERTAIN * self.sigma(output) {
                    left[row] = off;
                }
            });
            let slow = smoothed(&left, self.sigma(output));
            let known_of = slopes.further(r, inputs).iter().zip(&self.noise);
            let direct: Vec<Option<(Vec<f64>, f64)>> = known_of
                .map(|(d, sigma)| Some((slopes.tangents[r].direct(d.as_ref()?), sigma.powi(2))))
                .collect();
            let mut own = self.drives[*run].inputs().to_vec();
            for row in (0..left.len()).filter(|row| left[*row].is_finite()) {
                let change = |d: &Option<(Vec<f64>, f64)>| {
                    d.as_ref().map(|(j, variance)| (j[row * m + output], *variance))
                };
                let whole: f64 = direct.iter().filter_map(change).map(|(j, variance)| j * j * variance).sum();
                let part = (left[row] - slow[row]) / (known[output].powi(2) + whole);
                for (input, d) in own.iter_mut().zip(&direct) {
                    input[row] += change(d).map_or(0.0, |(j, variance)| j * variance * part);
                }
            }
            smooth[*run] = self.drives[*run].with_inputs(own).smoothed(&self.noise[..inputs]);
        }
        self.smooth = Arc::new(smooth);
        self.driven = Arc::clone(&self.smooth);
        Ok(())
    }

    /// Smooths the inputs by their noise, for simulations in the search.
    pub fn smooth_inputs(&mut self) {
        let noise = &self.noise[..self.experiment.inputs.len()];
        self.smooth = Arc::new(self.drives.iter().map(|d| d.smoothed(noise)).collect());
        self.driven = Arc::clone(&self.smooth);
    }

    /// Lowers the estimated noise of inputs and outputs by (1), and smooths the inputs by less then. Result: sigma_r of each output, infinite
    /// where it is unknown.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn lower_noise(
        &mut self,
        hypothesis: &Hypothesis,
        runs: &[usize],
    ) -> Result<Vec<f64>, CalibrateError> {
        let left = self.noise_left(hypothesis)?;
        if (0..self.outputs()).all(|output| left[output] >= NEARLY * self.sensor_noise(output)) {
            return Ok(left);
        }
        let slopes = self.input_sensitivities(hypothesis, runs)?;
        for (k, channel) in self.experiment.inputs.iter().enumerate() {
            let (direct, _) = self.variances(&slopes, |input| input == k);
            let most = left
                .iter()
                .zip(&direct)
                .map(|(left, direct)| left / direct.sqrt())
                .fold(f64::INFINITY, f64::min);
            if most < NEARLY && !is_stated(self.experiment, channel) {
                self.noise[k] = (most * self.noise[k]).max(least(self.experiment, k, channel));
            }
        }
        for (output, left) in left.iter().enumerate() {
            self.lower(output, *left);
        }
        self.smooth_inputs();
        Ok(left)
    }

    /// Lowers the noise of an output to what is `left`, unless the experiment states it.
    fn lower(&mut self, output: usize, left: f64) {
        let (channel, n) = (self.experiment.outputs[output], self.experiment.place_of(output));
        if left < NEARLY * self.sensor_noise(output) && !is_stated(self.experiment, channel) {
            let between = self.between.get(output).copied().unwrap_or(0.0);
            self.noise[n] = between.hypot(left.max(least(self.experiment, n, channel)));
        }
    }

    /// sigma_r of each output with the inputs as measured. Runs differ in their noise, so the estimate from the readings of all runs is
    /// multiplied by the fraction that is left in the fit and validation runs. Infinite if nearly all is left, without readings, and where
    /// readings are held over several rows.
    fn noise_left(&self, hypothesis: &Hypothesis) -> Result<Vec<f64>, CalibrateError> {
        let (m, inputs) = (self.outputs(), self.experiment.inputs.len());
        let runs = [self.runs(Role::Fit), self.runs(Role::Validate)].concat();
        let all = self.exact().show(hypothesis, &runs)?;
        let mut columns: Vec<Vec<Column>> = (0..m).map(|_| Vec::new()).collect();
        for (run, shown) in runs.iter().zip(&all) {
            let table = &self.experiment.runs[*run].table;
            let blank = || vec![f64::NAN; table.time.len()];
            let one = |_| Column { time: &table.time, read: blank(), left: blank() };
            let mut own: Vec<Column> = (0..m).map(one).collect();
            self.each(*run, shown, |row, output, off| {
                own[output].read[row] = table.columns[inputs + output][row];
                own[output].left[row] = off;
            });
            for (all, one) in columns.iter_mut().zip(own).filter(|(_, one)| is_new_in_every_row(&one.read)) {
                all.push(one);
            }
        }
        let told = noise::of_experiment(self.experiment);
        let left = |output: usize| {
            let own = || columns[output].iter();
            let channel = self.experiment.outputs[output];
            let read = of_columns(own().map(|c| (c.time, c.read.as_slice())), channel.is_temperature())?;
            let left = of_columns(own().map(|c| (c.time, c.left.as_slice())), channel.is_temperature())?;
            let is_stated = is_stated(self.experiment, channel);
            let before = if is_stated { read } else { told[inputs + output] };
            (0.0 < left && left < NEARLY * read).then(|| left / read * before)
        };
        Ok((0..m).map(|output| left(output).unwrap_or(f64::INFINITY)).collect())
    }

    /// Mean variance of each output due to white input noise over linearised runs
    /// ([`input_sensitivities`](Setup::input_sensitivities)): within a row, and in total.
    pub fn input_noise(&self, slopes: &Slopes) -> (Vec<f64>, Vec<f64>) {
        self.variances(slopes, |_| true)
    }

    /// The inputs, as directions of a linearization.
    pub fn input_probes(&self) -> impl Iterator<Item = Probe> + '_ {
        (0..self.experiment.inputs.len()).map(|k| Probe::Input(k, self.noise[k]))
    }

    /// A hypothesis linearised along runs, with the sensitivity to each input.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn input_sensitivities(
        &self,
        hypothesis: &Hypothesis,
        runs: &[usize],
    ) -> Result<Slopes, CalibrateError> {
        let probes: Vec<Probe> = self.input_probes().collect();
        Slopes::new(self, hypothesis, runs, &probes)
    }

    /// These variances for the inputs that `heard` selects.
    fn variances(&self, slopes: &Slopes, heard: impl Fn(usize) -> bool) -> (Vec<f64>, Vec<f64>) {
        let m = self.outputs();
        let (mut direct, mut whole, mut rows) = (vec![0.0; m], vec![0.0; m], 0.0);
        for (r, tangent) in slopes.tangents.iter().enumerate() {
            let (at_once, all) = tangent.variance(&self.noises(slopes, r, &heard));
            for (k, (a, b)) in at_once.iter().zip(&all).enumerate() {
                direct[k % m] += a;
                whole[k % m] += b;
            }
            rows += (at_once.len() / m) as f64;
        }
        let mean = |sums: Vec<f64>| sums.into_iter().map(|s| s / rows).collect();
        (mean(direct), mean(whole))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{self, normal, rng};

    /// Deviations of the readings: current in A, then the outputs in SI units.
    const TRUE: [f64; 5] = [0.01, 0.02, 1e-3, 0.05, 0.05];

    /// Noise of current and outputs before and after [`Setup::lower_noise`], of a run with these currents.
    fn noises(current: impl Fn(usize) -> f64, stated: &[&'static str]) -> [Vec<f64>; 2] {
        let mut experiment = testing::experiment("\"thermal.C_h\" = 0.1", true);
        experiment.noise.retain(|column, _| stated.contains(column));
        let rows = experiment.runs[0].table.time.len();
        experiment.runs[0].table.columns[0] = (0..rows).map(current).collect();
        let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &preset, None);
        let (mut rng, inputs) = (rng(3), experiment.inputs.len());
        for (column, sigma) in std::iter::once(0).chain(inputs..).zip(TRUE) {
            experiment.runs[0].table.columns[column].iter_mut().for_each(|x| *x += sigma * normal(&mut rng));
        }
        let mut setup = Setup::new(&experiment, &[]).unwrap();
        let of = |setup: &Setup| [&setup.noise[..1], &setup.noise[inputs..]].concat();
        let before = of(&setup);
        setup.lower_noise(&setup.preset(), &[0]).unwrap();
        [before, of(&setup)]
    }

    /// A current that is another one in every row is taken for noise, also in voltage and torque, until the model describes it.
    #[test]
    fn a_load_that_alternates_from_row_to_row_is_no_noise() {
        let [before, after] = noises(|row| 1.0 + (row * row % 7) as f64, &[]);
        assert!(before[0] > 1.0 && before[1] > 0.3 && before[2] > 0.01, "{before:?}");
        assert!(after[0] < 0.1, "{after:?}");
        for (own, sigma) in after[1..].iter().zip(&TRUE[1..]) {
            assert!((0.8..1.4).contains(&(own / sigma)), "{after:?}");
        }
    }

    /// Noise on slow inputs stays as it was estimated, and a stated noise as it was stated.
    #[test]
    fn other_estimates_stay() {
        let [before, after] = noises(|row| 3.0 + 2.0 * (row as f64 / 20.0).sin(), &[]);
        assert_eq!(before, after);
        let [before, after] = noises(|row| 1.0 + (row * row % 7) as f64, &["voltage_V"]);
        assert!(after[1] == before[1] && after[1] < 2e-3, "{before:?} {after:?}");
        assert!(after[0] < 0.1 && after[0] > TRUE[0] && after[2] < before[2] / 5.0, "{before:?} {after:?}");
    }

    /// At no load the voltage is the back-EMF, which varies faster than a mean over rows; the current, which is measured well, tells its
    /// noise. Under load the voltage stays as it is smoothed otherwise, and so does an effect that the model lacks: an offset of the voltage.
    #[test]
    fn a_current_near_zero_corrects_the_voltage_that_drives_it() {
        let outputs =
            ["current_A", "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC"];
        let (noise, offset) = (0.02, 0.01);
        let mut experiment = testing::driven_by(("voltage_V", 1.0, 7.0), &outputs, testing::PRIORS, true);
        experiment.noise.extend([("voltage_V", noise), ("speed_rad_per_s", 0.01)]);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let (preset, k_t) =
            (setup.preset().declared, setup.declared.iter().position(|d| d.name == "motor.k_t"));
        let k_t = preset[k_t.unwrap()];
        let columns = &mut experiment.runs[0].table.columns;
        let half = columns[0].len() / 2;
        let speed = columns[1].clone();
        for (row, (voltage, speed)) in columns[0].iter_mut().zip(speed).enumerate() {
            *voltage = k_t * speed + if row < half { 0.0 } else { 2.0 };
        }
        testing::read(&mut experiment, &preset, None);
        let mut rng = rng(9);
        let columns = &mut experiment.runs[0].table.columns;
        let truth = columns[0].clone();
        columns[0].iter_mut().for_each(|v| *v += offset + noise * normal(&mut rng));
        let mut setup = Setup::new(&experiment, &[]).unwrap();
        let error = |setup: &Setup, from: usize, to: usize| {
            let own = setup.smooth[0].inputs()[0][from..to].iter().zip(&truth[from..to]);
            let off: Vec<f64> = own.map(|(own, truth)| own - truth - offset).collect();
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            ((off.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / off.len() as f64).sqrt(), mean)
        };
        let of = |setup: &Setup| (error(setup, 10, half - 10), error(setup, half + 10, 2 * half - 10));
        let (before, loaded_before) = of(&setup);
        let fitted = setup.judged(setup.preset(), &[0]).unwrap();
        setup.include_input_noise(&fitted.hypothesis, &[0]).unwrap();
        let (after, loaded) = of(&setup);
        assert!(before.0 > 0.8 * noise && after.0 < 0.4 * noise, "{before:?} {after:?}");
        assert!((after.1 - before.1).abs() < 0.1 * offset, "{before:?} {after:?}");
        assert_eq!(loaded_before, loaded);
    }

    /// At rest a torque follows the noise of the speed by the slope of its friction, and not while the shaft turns: with their weights, the
    /// residuals of both halves have the size of their noise.
    #[test]
    fn rows_that_take_over_the_noise_of_an_input_have_small_weights() {
        let outputs = ["shaft_torque_Nm", "housing_temperature_degC"];
        let mut experiment = testing::driven_by(
            ("current_A", 1.0, 7.0),
            &outputs,
            "\"effect.coulomb_friction.tau_c\" = 0.1",
            true,
        );
        let (own, of_speed) = (1e-4, 0.2);
        experiment.noise.extend([("shaft_torque_Nm", own), ("speed_rad_per_s", of_speed)]);
        let half = experiment.runs[0].table.time.len() / 2;
        experiment.runs[0].table.columns[1][..half].fill(0.0);
        let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &preset, None);
        let (mut rng, torque) = (rng(4), experiment.place_of(0));
        let columns = &mut experiment.runs[0].table.columns;
        columns[1].iter_mut().for_each(|w| *w += of_speed * normal(&mut rng));
        columns[torque].iter_mut().for_each(|m| *m += own * normal(&mut rng));
        let mut setup = Setup::new(&experiment, &[]).unwrap();
        let hypothesis = setup.preset();
        setup.include_input_noise(&hypothesis, &[0]).unwrap();
        let mut squares = [0.0; 2];
        let (shown, setup) = (setup.exact().show(&hypothesis, &[0]).unwrap(), setup.exact());
        setup.each(0, &shown[0], |row, output, off| {
            if output == 0 {
                let relative = off * setup.weight(0, row, output) / setup.sigma(output);
                squares[usize::from(row >= half)] += relative * relative / half as f64;
            }
        });
        assert!(setup.weight(0, 9, 0) < 0.8 && setup.weight(0, half + 9, 0) > 1.2);
        assert!(squares.iter().all(|square| (0.6..1.5).contains(square)), "{squares:?}");
        assert!((setup.weight(0, 9, 1) - 1.0).abs() < NEGLIGIBLE);
    }
}
