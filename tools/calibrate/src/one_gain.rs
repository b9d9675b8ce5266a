//! The one channel whose gain or offset makes runs agree with a motor that describes the others.
//!
//! In these runs,
//!
//! ```text
//! output:  y = g p                    input:  u' = g u  or  u' = u + d          ambient temperature:  T' = T + d          (1)
//! ```
//! with the prediction p of an output; g of an output by least squares, g of an input and d by search. A command that was not executed is an
//! input with g = 0. A change is named if it leaves less than a tenth of their mean square error beyond the noise.

use crate::CalibrateError;
use crate::comparison::digits;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role};
use crate::hypothesis::Hypothesis;
use crate::levels::{AT_NOISE, SMALL};
use crate::setup::{Setup, Shown};
use physics::declare::Unit;

/// Gains of an input at which the search begins. Numerical: between two of them the error has one minimum.
const GAINS: [f64; 17] =
    [-1.0, -0.3, 0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.2, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0, 15.0];
/// Number of those that are negative. Definition: of the list above.
const NEGATIVE: usize = 2;
/// Offsets of the ambient temperature at which the search begins, K. Limit: a bench is in a room.
const OFFSETS: [f64; 10] = [-20.0, -10.0, -5.0, -2.5, -1.0, 1.0, 2.5, 5.0, 10.0, 20.0];
/// Zeros of an input at which the search begins, as parts of its largest reading. Numerical: between two of them the error has one minimum.
const SHARES: [f64; 8] = [-0.5, -0.2, -0.08, -0.03, 0.03, 0.08, 0.2, 0.5];
/// Halvings of the distance to the next of them. Numerical: a gain is then known to 1 %.
const HALVINGS: usize = 6;

/// Change of one channel.
pub struct Change {
    /// The channel, inputs first.
    pub column: usize,
    /// What has to be done to it, as a clause.
    pub words: String,
    /// What is left of the mean square error beyond the noise.
    left: f64,
}

/// The change of one channel with which these runs agree with the motor of the other fit and validation runs, by the declared parameters
/// alone; `None` if no single channel does it.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn beside_others(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    runs: &[usize],
    deadline: &Deadline,
) -> Result<Option<Change>, CalibrateError> {
    let setup = Setup::new(experiment, preset)?.until(deadline.clone());
    let is_other =
        |run: &usize| matches!(experiment.runs[*run].role, Role::Fit | Role::Validate) && !runs.contains(run);
    let others: Vec<usize> = (0..experiment.runs.len()).filter(is_other).collect();
    let fitted = setup.fit(setup.preset(), &others);
    Ok(fitted.ok().and_then(|fitted| of(&setup, &fitted.hypothesis, runs)))
}

/// The change of one channel with which these runs agree with a model that was fitted to others; `None` if no single channel does it.
pub fn of(setup: &Setup, hypothesis: &Hypothesis, runs: &[usize]) -> Option<Change> {
    let odd = Odd { setup, runs, hypothesis };
    let shown = setup.show(hypothesis, runs).ok()?;
    let before = odd.excess(&shown, None);
    let mut all = odd.outputs(&shown);
    for input in 0..setup.experiment.inputs.len() {
        if setup.deadline().is_near() {
            return None;
        }
        all.extend(odd.input(input));
    }
    let best = all.into_iter().min_by(|a, b| a.left.total_cmp(&b.left));
    best.filter(|change| change.left < SMALL * before)
}

/// Runs that disagree, and the motor of the others.
struct Odd<'a> {
    setup: &'a Setup<'a>,
    runs: &'a [usize],
    hypothesis: &'a Hypothesis,
}

impl Odd<'_> {
    /// Mean square error beyond the noise, in units of the noise, with the squares of an output in place of its own.
    fn excess(&self, shown: &[Shown], other: Option<(usize, f64)>) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (k, (own, readings)) in self.setup.squares(self.runs, shown).into_iter().enumerate() {
            let square = other.filter(|(output, _)| *output == k).map_or(own, |(_, square)| square);
            sum += square / self.setup.sensor_noise(k).powi(2);
            count += readings;
        }
        let excess = (sum / count.max(1) as f64 - 1.0).max(AT_NOISE - 1.0);
        if excess.is_nan() { f64::INFINITY } else { excess }
    }

    /// Each output that has a gain of its own, with what is left. A temperature has effects at its sensor instead.
    fn outputs(&self, shown: &[Shown]) -> Vec<Change> {
        let outputs = &self.setup.experiment.outputs;
        let mut sums = vec![(0.0, 0.0, 0.0); outputs.len()];
        for (run, shown) in self.runs.iter().zip(shown) {
            self.setup.each(*run, shown, |row, output, off| {
                let y = self.setup.experiment.readings(*run, output)[row];
                let p = y - off;
                let (yy, yp, pp) = &mut sums[output];
                (*yy, *yp, *pp) = (*yy + y * y, *yp + y * p, *pp + p * p);
            });
        }
        let of = |(k, (yy, yp, pp)): (usize, (f64, f64, f64))| {
            let gain = yp / pp;
            let is_one = outputs[k].is_temperature() || !(gain.is_finite() && gain != 0.0);
            let left = self.excess(shown, Some((k, (yy - gain * yp) / (gain * gain))));
            let column = self.setup.experiment.place_of(k);
            let words = format!("{} is divided by {}", outputs[k].column, digits(gain));
            (!is_one).then_some(Change { column, words, left })
        };
        sums.into_iter().enumerate().filter_map(of).collect()
    }

    /// An input with each change that its instrument may need, and what is left then.
    fn input(&self, input: usize) -> Vec<Change> {
        let channel = self.setup.experiment.inputs[input];
        let (column, unit) = (channel.column, channel.unit.name());
        let added = |x: f64| format!("{} {unit} is added to {column}", digits(x));
        if channel.is_temperature() {
            return self.best(input, &OFFSETS, &|u, x| u + x, &added).into_iter().collect();
        }
        let is_command = channel.unit == Unit::One;
        let scaled = |x: f64| match () {
            () if x.abs() < SMALL * SMALL => {
                format!("{column} was 0 throughout, whatever was commanded or read")
            }
            () if is_command => format!("{column} acted as {} times its value", digits(x)),
            () => format!("{column} is multiplied by {}", digits(x)),
        };
        // A command has no sign that a wire could change, and no zero of its own.
        let gains = if is_command { &GAINS[NEGATIVE..] } else { &GAINS };
        let gain = self.best(input, gains, &|u, x| u * x, &scaled);
        if is_command {
            return gain.into_iter().collect();
        }
        let most = self.runs.iter().map(|run| self.setup.drives[*run].scale(input)).fold(0.0, f64::max);
        let zeros = SHARES.map(|share| share * most);
        let zero = self.best(input, &zeros, &|u, x| u + x, &added);
        gain.into_iter().chain(zero).collect()
    }

    /// The number with which a change of an input leaves least, between the first and the last of the starts, which ascend.
    fn best(
        &self,
        input: usize,
        starts: &[f64],
        change: &dyn Fn(f64, f64) -> f64,
        words: &dyn Fn(f64) -> String,
    ) -> Option<Change> {
        let changed = |x: f64| -> f64 {
            let setup = self.setup.with_input(input, self.runs, |_, _, _, u| change(u, x));
            setup.show(self.hypothesis, self.runs).map_or(f64::INFINITY, |shown| self.excess(&shown, None))
        };
        let tried = starts.iter().enumerate().map(|(k, x)| (k, *x, changed(*x)));
        let (k, mut at, mut left) = tried.min_by(|a, b| a.2.total_cmp(&b.2))?;
        let beside = [k.checked_sub(1).map(|k| starts[k]), starts.get(k + 1).copied()];
        let mut step = beside.iter().flatten().map(|x| 0.5 * (x - at).abs()).fold(0.0, f64::max);
        for _ in 0..HALVINGS {
            for x in [at - step, at + step].into_iter().filter(|x| *x >= starts[0]) {
                let excess = changed(x);
                if excess < left {
                    (at, left) = (x, excess);
                }
            }
            step *= 0.5;
        }
        Some(Change { column: input, words: words(at), left })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::tests::{AMBIENT, CURRENT, FAN, SPEED, TORQUE, VOLTAGE, WINDING, with_inputs};
    use crate::intake::three;

    fn change(odd: usize, column: usize, of: impl Fn(usize, f64) -> f64) -> Option<Change> {
        beside_others(&three(odd, column, of), &[], &[odd], &Deadline::default()).unwrap()
    }

    /// The readings of one channel of one file are wrong by a factor, or those of an input by an offset.
    #[test]
    fn the_gain_of_a_channel_is_found() {
        for (odd, column, factor) in [
            (0, CURRENT, 1.25),
            (1, SPEED, 0.4),
            (2, TORQUE, 7.0),
            (0, VOLTAGE, 0.9),
            (1, CURRENT, -1.0),
            (2, CURRENT, 0.1),
        ] {
            let found = change(odd, column, |_, x| factor * x).unwrap_or_else(|| panic!("{column} {factor}"));
            assert_eq!(found.column, column, "{factor}: {}", found.words);
            let stated: f64 = found.words.rsplit(' ').next().unwrap().parse().unwrap();
            let meant = if column < VOLTAGE { 1.0 / factor } else { factor };
            assert!((stated / meant - 1.0).abs() < 0.03, "{factor}: {}", found.words);
        }
        for (column, zero) in [(AMBIENT, -4.0), (CURRENT, 0.6), (SPEED, -35.0)] {
            let found = change(1, column, |_, x| x + zero).unwrap_or_else(|| panic!("{column}"));
            let stated: f64 = found.words.split(' ').next().unwrap().parse().unwrap_or(f64::NAN);
            assert_eq!(found.column, column, "{}", found.words);
            assert!((stated / -zero - 1.0).abs() < 0.06, "{}", found.words);
        }
    }

    /// A fan that did not run in one file.
    #[test]
    fn a_command_that_was_not_executed_is_found() {
        let mut data = three(1, FAN, |_, x| x);
        let still = with_inputs(72, |columns| {
            columns[CURRENT]
                .iter_mut()
                .enumerate()
                .for_each(|(k, i)| *i = [5.0, 0.0, 2.0, 4.0, 1.0][k / 60 % 5]);
            columns[FAN].fill(0.0);
        });
        let commanded = data.runs[1].table.columns[FAN].clone();
        data.runs[1].table = still.runs[0].table.clone();
        data.runs[1].table.columns[FAN] = commanded;
        let found = beside_others(&data, &[], &[1], &Deadline::default()).unwrap().unwrap();
        assert!(found.column == FAN && found.words.contains("was 0 throughout"), "{}", found.words);
    }

    /// What is no factor of one channel: a drift, a scatter, an effect that the load has.
    #[test]
    fn other_errors_are_no_gain() {
        assert!(change(0, WINDING, |row, x| x + 6.0 * (row as f64 / 1200.0)).is_none());
        assert!(change(2, VOLTAGE, |row, x| if row % 200 < 100 { x } else { 1.3 * x }).is_none());
        assert!(change(1, TORQUE, |_, x| x + 0.004 * x.signum()).is_none());
    }
}
