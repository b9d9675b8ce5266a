//! Prepared experiment: bench, runs, parameters to fit, noise.

mod blocks;

use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::{Channel, Experiment, Prior, Role, Run};
use crate::hypothesis::{Addition, Hypothesis};
use crate::noise;
use crate::overrides::Override;
use crate::parallel;
use crate::simulate::{Bench, Drive};
use blocks::blocks;
pub use blocks::{BLOCKS, Block};
use nalgebra::DMatrix;
use physics::model::{Entry, Slot};
use physics::terms::Drivers;
use std::sync::{Arc, OnceLock};

/// Relaxation of the integration tolerances of heat, and of current and speed, for the many simulations of a search: an error of current or speed
/// passes, one of heat adds up. Numerical: over 1.5 h of noisy rows three to nine times faster, with errors of at most 0.2 mK, 0.06 mA and
/// 1.5 mrad/s at 400 rad/s; with ten times as much intervals of parameters at a limit move by a quarter.
pub const EASE: [f64; 2] = [100.0, 1000.0];
/// Relative standard deviation of a prior above which it limits the parameter. Derivation: zero is then inside of 3.3 standard
/// deviations, two-sided level 1e-3, so the parameter is known by its logarithm only.
pub const WIDE: f64 = 0.3;
/// Relative standard deviation of a prior from which the parameter may be zero. Numerical: limits at factors of 6e7 are none.
const HARDLY: f64 = 5.0;
/// Limits of a parameter that cannot be zero: standard deviations of the logarithm, at least [`WIDE`]. Numerical: fits that diverge end.
const FAR: f64 = 10.0;
/// A parameter further than this from its prior, in standard deviations, compensates for another effect. Derivation: 95 % quantile of
/// the greatest of four deviations (Sidak, J. Am. Stat. Assoc. 62 (1967) 626-633).
const ASTRAY: f64 = 2.5;

/// Declared parameter, which may vary from specimen to specimen.
#[derive(Clone, Debug)]
pub struct Declared {
    /// Its name; for an unknown of one run, with the file.
    pub name: String,
    /// The runs in which it applies, if it is an unknown of one file only.
    pub runs: Option<Vec<usize>>,
    /// Its slot in the model.
    pub slot: Slot,
    /// The preset's value.
    pub prior: f64,
    /// Standard deviation of its prior.
    pub deviation: f64,
    /// Limits of its value.
    pub limits: (f64, f64),
    /// Its unit.
    pub unit: &'static str,
    /// Whether the prior is ignored: for a parameter uncertain by a factor, no deviation from the preset contradicts the data.
    pub is_free: bool,
    /// Whether it has no prior in the experiment (`undeclared.rs`).
    pub is_released: bool,
}

impl Declared {
    /// A parameter that applies in all runs.
    pub fn new(entry: &Entry, prior: f64, deviation: f64) -> Declared {
        let mut limits = (entry.row.min, entry.row.max);
        // A parameter that cannot be zero: less is no plausible capacity of a motor, and a short time constant has short steps.
        let relative = deviation / prior.abs();
        if prior > 0.0 && limits.0 > 0.0 && relative < HARDLY {
            let factor = (1.0 + relative.max(WIDE)).powf(FAR);
            limits = (limits.0.max(prior / factor), limits.1.min(prior * factor));
        }
        Declared {
            name: entry.name.clone(),
            runs: None,
            slot: entry.slot,
            prior,
            deviation,
            limits,
            unit: entry.row.unit.name(),
            is_free: false,
            is_released: false,
        }
    }

    /// Whether it applies in a run.
    pub fn acts_in(&self, run: usize) -> bool {
        self.runs.as_ref().is_none_or(|runs| runs.contains(&run))
    }

    /// Whether a prior of the experiment holds it.
    pub fn is_held(&self) -> bool {
        !self.is_free && !self.is_released
    }

    /// Whether a value is inside the limits; a value at a limit stands in for something else.
    pub fn is_inside(&self, value: f64) -> bool {
        self.limits.0 < value && value < self.limits.1
    }

    /// Whether a value is so far from the prior that it compensates for another effect.
    pub fn astray(&self, value: f64) -> bool {
        (value - self.prior).abs() > ASTRAY * self.deviation
    }
}

/// Prepared experiment.
#[derive(Clone)]
pub struct Setup<'a> {
    /// The measured data.
    pub experiment: &'a Experiment,
    /// The rows as measured, if the data are means of them; what is found is evaluated there.
    pub all_rows: Option<&'a Experiment>,
    /// The model with the experiment's start values.
    pub bench: Arc<Bench>,
    /// The inputs of the runs as measured.
    pub drives: Arc<Vec<Drive>>,
    /// The inputs with their noise smoothed out; the model is linearised along these. Sensitivities with the same noise as the residual
    /// would produce spurious effects.
    pub smooth: Arc<Vec<Drive>>,
    /// The inputs used in simulations. Smoothed during the search: with noisy inputs, candidates that make the model less sensitive to the
    /// input would be preferred. As measured for reported results.
    pub driven: Arc<Vec<Drive>>,
    /// Parameters that may be fitted.
    pub declared: Vec<Declared>,
    /// Parameters without prior that are not estimated, because their values in the preset are right.
    pub kept: Vec<String>,
    /// Standard deviations of the noise: inputs, then outputs.
    pub noise: Vec<f64>,
    /// Weight of each reading (rows times outputs of each run) beside that of its noise's mean over the rows; empty where all are alike.
    /// *Source*: effective variance, Orear, Am. J. Phys. 50 (1982) 912.
    pub weights: Arc<Vec<Vec<f64>>>,
    /// Part of the outputs' noise due to disagreement between runs; empty if there is none.
    pub between: Vec<f64>,
    /// Inputs whose noise is stored in heat capacities and therefore correlates between neighbouring rows.
    pub remembered: Vec<usize>,
    /// Drivers predicted by the fit without added effects at the rows of the fit runs; they set the range of each driver in the search.
    pub reached: Arc<Vec<Drivers>>,
    /// Directions of the structure error along the fit runs, linearised at the first fit that is evaluated.
    pub structure: Arc<OnceLock<DMatrix<f64>>>,
    /// Time window of each run: from and to, s.
    pub windows: Vec<(f64, f64)>,
    /// Blocks of each run; shared by the copies of the setup.
    pub blocks: Vec<Arc<Vec<Block>>>,
}

/// Outputs predicted at every row of a run: rows times outputs, in SI units.
pub type Shown = Vec<f64>;

impl<'a> Setup<'a> {
    /// Prepares an experiment; `preset` are the start values of its preset, by value reference.
    ///
    /// # Errors
    /// A run for which the model's inputs are incomplete.
    pub fn new(experiment: &'a Experiment, preset: &[(u32, f64)]) -> Result<Setup<'a>, CalibrateError> {
        let mut bench = Bench::new(experiment, preset)?;
        bench.ease = EASE;
        bench.lenient = true;
        let of_all = experiment.priors.iter().map(|p| (p, None));
        let declared = of_all.chain(of_one_run(experiment)).map(|(p, runs)| {
            let entry = bench
                .declaration()
                .by_name(&p.name)
                .ok_or_else(|| CalibrateError(format!("{} has no {}", experiment.model, p.name)))?;
            let own = runs.as_ref().and_then(|runs: &Vec<usize>| experiment.runs.get(*runs.first()?));
            let set =
                own.and_then(|run| run.set.iter().find(|(name, _)| *name == p.name)).map(|(_, value)| *value);
            let prior = set.unwrap_or_else(|| bench.start_of(entry.slot));
            let deviation = p.deviation.of(prior, entry.row.nominal);
            let name = own.map_or_else(|| p.name.clone(), |run| format!("{} [{}]", p.name, run.file));
            let is_released = experiment.released.contains(&p.name);
            Ok(Declared { name, runs, is_released, ..Declared::new(entry, prior, deviation) })
        });
        let declared = declared.collect::<Result<Vec<_>, CalibrateError>>()?;
        let own = Setup {
            experiment,
            all_rows: None,
            bench: Arc::new(bench),
            driven: Arc::default(),
            smooth: Arc::default(),
            drives: Arc::default(),
            declared,
            kept: Vec::new(),
            noise: Vec::new(),
            weights: Arc::default(),
            between: Vec::new(),
            remembered: Vec::new(),
            reached: Arc::default(),
            structure: Arc::default(),
            windows: Vec::new(),
            blocks: Vec::new(),
        };
        own.with_rows(experiment)
    }

    /// The same for an experiment with means over its rows, if there are any.
    ///
    /// # Errors
    /// As [`new`](Setup::new).
    pub fn of_means(
        experiment: &'a Experiment,
        means: Option<&'a Experiment>,
        preset: &[(u32, f64)],
    ) -> Result<Setup<'a>, CalibrateError> {
        let all_rows = means.map(|_| experiment);
        Ok(Setup { all_rows, ..Setup::new(means.unwrap_or(experiment), preset)? })
    }

    /// Copy for the rows of this experiment, which otherwise is the same, with the noise of its readings.
    fn with_rows(&self, experiment: &'a Experiment) -> Result<Setup<'a>, CalibrateError> {
        let runs = || experiment.runs.iter();
        let noise = noise::of_experiment(experiment);
        let of_outputs = &noise[experiment.inputs.len()..];
        let drive = |run: &Run| Ok(Drive::new(experiment, run)?.with_others(experiment, run, of_outputs));
        let drives = Arc::new(runs().map(drive).collect::<Result<Vec<_>, CalibrateError>>()?);
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        let windows: Vec<(f64, f64)> = runs().map(|run| run.window.unwrap_or(all)).collect();
        let of_run = |(run, window): (&Run, &(f64, f64))| Arc::new(blocks(experiment, run, *window));
        let mut own = Setup {
            experiment,
            all_rows: None,
            weights: Arc::default(),
            between: Vec::new(),
            driven: Arc::clone(&drives),
            smooth: Arc::clone(&drives),
            drives,
            noise,
            blocks: runs().zip(&windows).map(of_run).collect(),
            windows,
            ..self.clone()
        };
        own.smooth_inputs();
        Ok(own)
    }

    /// Copy for the rows as measured, with their noise at a hypothesis; the setup itself if its rows are no means.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn at_all_rows(&self, found: &Hypothesis) -> Result<Setup<'a>, CalibrateError> {
        let Some(all) = self.all_rows else { return Ok(self.clone()) };
        let mut own = self.with_rows(all)?;
        if !self.between.is_empty() {
            own = own.with_between_runs(&self.between);
        }
        let fit = own.runs(Role::Fit);
        own.include_input_noise(found, &fit)?;
        Ok(own)
    }

    /// Copy at the model's default accuracy, with the inputs as measured.
    pub fn exact(&self) -> Setup<'a> {
        let mut bench = Bench::clone(&self.bench);
        bench.ease = [1.0; 2];
        bench.lenient = false;
        bench.deadline = Deadline::default();
        Setup { bench: Arc::new(bench), driven: Arc::clone(&self.drives), ..self.clone() }
    }

    /// Copy with a model that stops at its validity limits. The measured motor did not stop, so a stop refutes the model.
    pub fn strict(&self) -> Setup<'a> {
        let mut other = self.clone();
        Arc::make_mut(&mut other.bench).lenient = false;
        other
    }

    /// Copy with a deadline for its simulations.
    pub fn until(mut self, deadline: Deadline) -> Setup<'a> {
        Arc::make_mut(&mut self.bench).deadline = deadline;
        self
    }

    /// Deadline of the simulations.
    pub fn deadline(&self) -> &Deadline {
        &self.bench.deadline
    }

    /// Copy with another time window for a run.
    pub fn with_window(&self, run: usize, window: (f64, f64)) -> Setup<'a> {
        let mut other = self.clone();
        other.windows[run] = window;
        other.blocks[run] = Arc::new(blocks(self.experiment, &self.experiment.runs[run], window));
        other
    }

    /// First and last time of a run's readings inside its window, s; `None` without any.
    pub fn counted(&self, run: usize) -> Option<(f64, f64)> {
        let time = &self.drives[run].time;
        let mut ends: Option<(f64, f64)> = None;
        for block in self.blocks[run].iter() {
            let (a, b) = (time[block.rows[0] as usize], time[block.rows[block.rows.len() - 1] as usize]);
            ends = Some(ends.map_or((a, b), |(from, to)| (from.min(a), to.max(b))));
        }
        ends
    }

    /// Whether the model takes laws, so that a search knows what a law explains.
    pub fn takes_laws(&self) -> bool {
        self.bench.takes_laws()
    }

    /// Whether the load is an input.
    pub fn has_load(&self) -> bool {
        self.experiment.inputs.iter().any(|c| c.input == Some("load_torque"))
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.experiment.outputs.len()
    }

    /// Noise of an output.
    pub fn sigma(&self, output: usize) -> f64 {
        self.noise[self.experiment.place_of(output)]
    }

    /// Relative weight of a reading: the noise of its output, over that of this row.
    pub fn weight(&self, run: usize, row: usize, output: usize) -> f64 {
        self.weights.get(run).and_then(|own| own.get(row * self.outputs() + output)).copied().unwrap_or(1.0)
    }

    /// Noise of a reading.
    pub fn noise_of_reading(&self, run: usize, row: usize, output: usize) -> f64 {
        self.sigma(output) / self.weight(run, row, output)
    }

    /// The setup with another input in these runs; `change` gets drives, run, row and reading.
    pub fn with_input(
        &self,
        input: usize,
        runs: &[usize],
        change: impl Fn(&[Drive], usize, usize, f64) -> f64,
    ) -> Setup<'a> {
        let of = |drives: &[Drive]| -> Arc<Vec<Drive>> {
            let all = drives.iter().enumerate().map(|(run, drive)| match runs.contains(&run) {
                true => drive.with_input(input, |row, reading| change(drives, run, row, reading)),
                false => drive.clone(),
            });
            Arc::new(all.collect())
        };
        let (drives, smooth, driven) = (of(&self.drives), of(&self.smooth), of(&self.driven));
        Setup { drives, smooth, driven, ..self.clone() }
    }

    /// Noise of an output without the disagreement between runs.
    pub fn sensor_noise(&self, output: usize) -> f64 {
        let between = self.between.get(output).copied().unwrap_or(0.0);
        (self.sigma(output).powi(2) - between * between).max(0.0).sqrt()
    }

    /// Noise of a channel, input or output; `None` where it was not measured.
    pub fn noise_of(&self, channel: &Channel) -> Option<f64> {
        let channels = self.experiment.inputs.iter().chain(&self.experiment.outputs);
        channels.zip(&self.noise).find(|(c, _)| c.column == channel.column).map(|(_, noise)| *noise)
    }

    /// The runs of a role.
    pub fn runs(&self, role: Role) -> Vec<usize> {
        self.experiment.of_role(role)
    }

    /// Fit run of the same file as a run: an effect acts in a whole file, for every window.
    pub fn fitted_with(&self, run: usize) -> Option<usize> {
        let file = |run: usize| &self.experiment.runs[run].file;
        self.runs(Role::Fit).into_iter().find(|r| file(*r) == file(run))
    }

    /// The unmodified preset.
    pub fn preset(&self) -> Hypothesis {
        Hypothesis { declared: self.declared.iter().map(|d| d.prior).collect(), additions: Vec::new() }
    }

    /// Parameter overrides of a hypothesis in a run.
    pub fn change(&self, hypothesis: &Hypothesis, run: usize) -> Override {
        let mut change = Override::default();
        let declared = self.declared.iter().zip(&hypothesis.declared).filter(|(d, _)| d.acts_in(run));
        change.values.extend(declared.map(|(d, value)| (d.slot, *value)));
        hypothesis.additions.iter().filter(|a| a.active[run]).for_each(|a| a.apply(&mut change));
        change
    }

    /// Number of coefficients that an addition counts as in the complexity penalty: its own, and the start of its lag in each of these runs that
    /// starts warm.
    pub fn price(&self, addition: &Addition) -> f64 {
        let runs = [Role::Fit, Role::Validate].into_iter().flat_map(|role| self.runs(role));
        let warm = runs.filter(|run| addition.active[*run] && self.drives[*run].estimates_start());
        let starts = if addition.lag().is_some() { warm.count() } else { 0 };
        addition.price() + starts as f64
    }

    /// The same without the unknowns of that single run, as for another run.
    pub fn common_change(&self, hypothesis: &Hypothesis, run: usize) -> Override {
        let mut change = self.change(hypothesis, run);
        change.values.retain(|(slot, _)| {
            !self
                .declared
                .iter()
                .any(|d| d.slot == *slot && d.runs.as_ref().is_some_and(|runs| runs.contains(&run)))
        });
        change
    }

    /// Outputs predicted in each of these runs.
    ///
    /// # Errors
    /// The message of the model if it cannot be run.
    pub fn show(&self, hypothesis: &Hypothesis, runs: &[usize]) -> Result<Vec<Shown>, CalibrateError> {
        Ok(self.show_to_end(hypothesis, runs)?.into_iter().map(|(shown, _)| shown).collect())
    }

    /// The same, each with the reason why the run ends before its last row; `None` if it does not.
    ///
    /// # Errors
    /// The message of the model if it cannot be run.
    pub fn show_to_end(
        &self,
        hypothesis: &Hypothesis,
        runs: &[usize],
    ) -> Result<Vec<(Shown, Option<String>)>, CalibrateError> {
        let one = |&run: &usize| {
            let (columns, ending) =
                self.bench.run_to_end(&self.driven[run], &self.change(hypothesis, run))?;
            let rows = self.drives[run].time.len();
            Ok(((0..rows).flat_map(|row| columns.iter().map(move |c| c[row])).collect(), ending))
        };
        parallel::map(runs, one).into_iter().collect()
    }

    /// Calls `tell` with row, output and residual (measured minus predicted) for each reading inside the window.
    pub fn each(&self, run: usize, shown: &Shown, mut tell: impl FnMut(usize, usize, f64)) {
        let (m, inputs) = (self.outputs(), self.experiment.inputs.len());
        let window = self.windows[run];
        let run = &self.experiment.runs[run];
        for (row, _) in run.table.time.iter().enumerate().filter(|(_, t)| within(window, **t)) {
            for output in 0..m {
                let measured = run.table.columns[inputs + output][row];
                if measured.is_finite() {
                    tell(row, output, measured - shown[row * m + output]);
                }
            }
        }
    }

    /// The weighted sum of squares over runs, and its number of readings.
    pub fn chi_square(&self, runs: &[usize], shown: &[Shown]) -> (f64, usize) {
        let (mut sum, mut count) = (0.0, 0);
        for (run, shown) in runs.iter().zip(shown) {
            self.each(*run, shown, |row, output, off| {
                sum += (off / self.noise_of_reading(*run, row, output)).powi(2);
                count += 1;
            });
        }
        (sum, count)
    }

    /// The weighted sum of squares over runs, output by output.
    pub fn chi_squares(&self, runs: &[usize], shown: &[Shown]) -> Vec<f64> {
        let mut sums = vec![0.0; self.outputs()];
        for (run, shown) in runs.iter().zip(shown) {
            self.each(*run, shown, |row, output, off| {
                sums[output] += (off / self.noise_of_reading(*run, row, output)).powi(2);
            });
        }
        sums
    }

    /// Root mean square error of each output over runs; NaN where there is no reading.
    pub fn rmse(&self, runs: &[usize], shown: &[Shown]) -> Vec<f64> {
        self.squares(runs, shown).into_iter().map(|(sum, count)| (sum / count as f64).sqrt()).collect()
    }

    /// The sum of squares over runs in SI units and the number of readings, output by output.
    pub fn squares(&self, runs: &[usize], shown: &[Shown]) -> Vec<(f64, usize)> {
        let mut sums = vec![(0.0, 0usize); self.outputs()];
        for (run, shown) in runs.iter().zip(shown) {
            self.each(*run, shown, |_, output, off| {
                sums[output].0 += off * off;
                sums[output].1 += 1;
            });
        }
        sums
    }
}

/// Unknowns of single files, with their runs if these are fitted: other runs keep the prior value.
fn of_one_run(experiment: &Experiment) -> Vec<(&Prior, Option<Vec<usize>>)> {
    let mut found: Vec<(&Prior, Option<Vec<usize>>)> = Vec::new();
    let mut known: Vec<(&str, &str)> = Vec::new();
    for run in &experiment.runs {
        let same: Vec<usize> =
            (0..experiment.runs.len()).filter(|k| experiment.runs[*k].file == run.file).collect();
        let is_fitted = same.iter().any(|k| experiment.runs[*k].role == Role::Fit);
        for prior in run.priors.iter().filter(|_| is_fitted) {
            if !known.contains(&(&run.file, &prior.name)) {
                known.push((&run.file, &prior.name));
                found.push((prior, Some(same.clone())));
            }
        }
    }
    found
}

fn within((from, to): (f64, f64), time: f64) -> bool {
    (from..=to).contains(&time)
}
