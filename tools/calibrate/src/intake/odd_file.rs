//! The file that disagrees with all others: of another motor, with a channel that is late or wrong, or with an effect that the others lack.
//!
//! ```text
//! e_f < c min e_g over g != f                                                              (1)
//! ```
//! e_f is the mean square of the residual beyond the noise, in units of the noise, of the declared parameters fitted to the fit and
//! validation runs without file f. Where (1) holds, the parameters alone describe the others, and what is found rests on file f. Of two files
//! nothing says which is the odd one. A channel whose clock is shifted in the odd file only is looked for there.
//!
//! *Source*: leave-one-out deletion diagnostics, Cook, Technometrics 19 (1977) 15-18.

use super::consistency::{ROWS, files, thinned};
use super::{Unusable, clocks};
use crate::CalibrateError;
use crate::comparison::digits;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, OddFile, Role};
use crate::levels::{AT_NOISE, SMALL};
use crate::one_gain;
use crate::parallel;
use crate::setup::Setup;

/// Fewest files of which one can be odd. Derivation: of two, each disagrees with the other.
const FEWEST: usize = 3;

/// Looks for the odd file: a channel with another clock in it is set aside or makes it unusable; otherwise the experiment names the file.
///
/// # Errors
/// An experiment whose model cannot be set up.
pub fn check(
    experiment: &mut Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Option<Unusable>, CalibrateError> {
    let Some((runs, ratio)) = found(experiment, preset, deadline)? else { return Ok(None) };
    let known = experiment.notes.len();
    let unusable = clocks::in_runs(experiment, &runs, preset, deadline)?;
    if unusable.is_none() && experiment.notes.len() == known {
        let name = experiment.runs[runs[0]].file.clone();
        let cause = match one_gain::beside_others(&thinned(experiment, ROWS), preset, &runs, deadline)? {
            Some(change) => format!("it agrees with them if {}", change.words),
            None => "either it shows what the others do not, or one of its channels is wrong, or it is of another motor".to_string(),
        };
        let note = format!(
            "{name} disagrees with the other runs: without it the declared parameters alone describe the fit and validation runs, with a residual \
             beyond the noise that is {} times smaller than without any other run; {cause}",
            digits(ratio)
        );
        experiment.notes.push(note.clone());
        experiment.odd_file = Some(OddFile { name, note });
    }
    Ok(unusable)
}

/// The runs of the odd file, and how many times smaller the root mean square of the residual is without it.
fn found(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    deadline: &Deadline,
) -> Result<Option<(Vec<usize>, f64)>, CalibrateError> {
    let thin = thinned(experiment, ROWS);
    let is_counted = |run: &usize| matches!(thin.runs[*run].role, Role::Fit | Role::Validate);
    let files = files(&thin).into_iter().map(|(_, runs)| runs);
    let files: Vec<Vec<usize>> = files.filter(|runs| runs.iter().all(is_counted)).collect();
    if files.len() < FEWEST || deadline.is_near() {
        return Ok(None);
    }
    let setup = Setup::new(&thin, preset)?.until(deadline.clone());
    let excess = |left_out: &Vec<usize>| -> f64 {
        let others: Vec<usize> = files.iter().filter(|runs| *runs != left_out).flatten().copied().collect();
        let fitted = setup.fit(setup.preset(), &others);
        fitted.map_or(f64::INFINITY, |f| (f.chi_square / f.readings as f64 - 1.0).max(AT_NOISE - 1.0))
    };
    let all = parallel::map(&files, excess);
    let Some(odd) = (0..files.len()).min_by(|a, b| all[*a].total_cmp(&all[*b])) else { return Ok(None) };
    let others = (0..files.len()).filter(|k| *k != odd).map(|k| all[k]).fold(f64::INFINITY, f64::min);
    let is_odd = all[odd] < SMALL * others && others.is_finite() && !deadline.is_near();
    Ok(is_odd.then(|| (files[odd].clone(), (others / all[odd]).sqrt())))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::intake::tests::{CURRENT, HOUSING, SPEED, TORQUE, WINDING, with_inputs};

    /// Three files with other loads; one column of one of them is changed by row and reading.
    pub(crate) fn three(odd: usize, column: usize, change: impl Fn(usize, f64) -> f64) -> Experiment {
        let loads = [[0.0, 4.0, 1.5, 6.0, 3.0], [5.0, 0.0, 2.0, 4.0, 1.0], [2.0, 5.0, 0.0, 3.0, 6.0]];
        let all = loads.iter().zip(71..).map(|(loads, seed)| {
            with_inputs(seed, |columns| {
                columns[CURRENT].iter_mut().enumerate().for_each(|(k, i)| *i = loads[k / 60 % 5]);
                columns[SPEED].iter_mut().for_each(|w| *w *= 0.5 + 0.1 * loads[1]);
            })
        });
        let mut all: Vec<Experiment> = all.collect();
        let mut experiment = all.remove(0);
        experiment.runs.extend(all.into_iter().flat_map(|other| other.runs));
        for (run, file) in experiment.runs.iter_mut().zip(["a.csv", "b.csv", "c.csv"]) {
            run.file = file.to_string();
        }
        experiment.runs[2].role = Role::Validate;
        let readings = &mut experiment.runs[odd].table.columns[column];
        readings.iter_mut().enumerate().for_each(|(row, x)| *x = change(row, *x));
        experiment
    }

    fn odd(experiment: &Experiment) -> Option<usize> {
        found(experiment, &[], &Deadline::default()).unwrap().map(|(runs, _)| runs[0])
    }

    /// Whatever is wrong with a fit run or the validation run.
    #[test]
    fn the_file_that_disagrees_is_found() {
        let falls = |row: usize, x: f64| x - 6.0 * (row as f64 / 1200.0);
        assert_eq!(odd(&three(0, WINDING, falls)), Some(0));
        assert_eq!(odd(&three(1, HOUSING, |row, x| if row > 700 { x + 4.0 } else { x })), Some(1));
        assert_eq!(odd(&three(2, TORQUE, |_, x| 1.15 * x)), Some(2));
        let mut experiment = three(1, CURRENT, |_, x| 1.2 * x + 0.3);
        assert_eq!(odd(&experiment), Some(1));
        check(&mut experiment, &[], &Deadline::default()).unwrap();
        assert!(experiment.notes.iter().any(|n| n.starts_with("b.csv disagrees")), "{:?}", experiment.notes);
        let OddFile { name, note } = experiment.odd_file.unwrap();
        assert!(name == "b.csv" && note.starts_with("b.csv disagrees"), "{note}");
    }

    /// Nothing wrong, the same in all files, and of two files.
    #[test]
    fn without_a_file_that_differs_there_is_none() {
        assert_eq!(odd(&three(0, WINDING, |_, x| x)), None);
        let mut all = three(0, TORQUE, |_, x| x + 0.01);
        for run in &mut all.runs[1..] {
            run.table.columns[TORQUE].iter_mut().for_each(|x| *x += 0.01);
        }
        assert_eq!(odd(&all), None);
        let mut two = three(1, TORQUE, |_, x| 1.15 * x);
        two.runs.truncate(2);
        assert_eq!(odd(&two), None);
    }

    /// A thermometer on another logger in one file.
    #[test]
    fn a_clock_of_one_file_is_found() {
        let clean = three(0, WINDING, |_, x| x);
        let own = clean.runs[1].table.columns[WINDING].clone();
        let mut late = three(1, WINDING, |row, _| own[row.saturating_sub(20)]);
        assert_eq!(check(&mut late, &[], &Deadline::default()).unwrap(), None);
        let note = late.notes.join(" ");
        assert!(note.contains("late") && note.contains("in b.csv, which no lag"), "{note}");
        assert!(late.runs[1].table.columns[WINDING].iter().all(|x| x.is_nan()));
        assert!(late.runs[0].table.columns[WINDING].iter().all(|x| x.is_finite()));
    }
}
