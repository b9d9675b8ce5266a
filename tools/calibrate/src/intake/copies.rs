//! Two columns with the same readings: one sensor that was recorded twice, or the readings of another file.
//!
//! Two sensors have noise of their own, and the nodes of a motor differ by their heat flow. Readings that are equal in nearly all rows in which
//! either changes are therefore those of one sensor; which one, the readings do not say.
//! The same holds for the readings of an output in two files, if an input of the two differs in these rows.

use super::Unusable;
use crate::experiment::Experiment;
use crate::levels::NEARLY;

/// Fewest rows with a change that are compared. Derivation: two thermometers with a coarse resolution may take the same few steps by chance.
const CHANGES: usize = 30;

/// Columns of one quantity that repeat each other in a run.
pub fn repeated(experiment: &Experiment) -> Option<Unusable> {
    let channels: Vec<_> = experiment.inputs.iter().chain(&experiment.outputs).collect();
    let pairs = (0..channels.len()).flat_map(|k| (0..k).map(move |other| (other, k)));
    let alike: Vec<(usize, usize)> = pairs.filter(|(a, b)| channels[*a].unit == channels[*b].unit).collect();
    experiment.runs.iter().find_map(|run| {
        let same = |(a, b): &&(usize, usize)| is_copy(&run.table.columns[*a], &run.table.columns[*b]);
        let (a, b) = alike.iter().find(same)?;
        let [first, second] = [a, b].map(|k| channels[*k].column);
        Some(Unusable::new(
            first,
            format!(
                "{first} and {second} in {} have the same readings, which two sensors never have",
                run.file
            ),
            format!("check which sensor {first} and {second} are of; leave one of the columns out"),
        ))
    })
}

/// An output with the same readings in two files, row by row, although an input differs.
pub fn of_another_file(experiment: &Experiment) -> Option<Unusable> {
    let (runs, inputs) = (&experiment.runs, experiment.inputs.len());
    let pairs = (0..runs.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    pairs.filter(|(a, b)| runs[*a].file != runs[*b].file).find_map(|(a, b)| {
        let is_same = |k: usize| is_copy(&runs[a].table.columns[k], &runs[b].table.columns[k]);
        let is_other = |k: usize| {
            let differs = |(x, y): (&f64, &f64)| x.is_finite() && y.is_finite() && x != y;
            runs[a].table.columns[k].iter().zip(&runs[b].table.columns[k]).any(differs)
        };
        let copied = experiment.outputs.iter().enumerate().filter(|(k, _)| is_same(inputs + k));
        let names: Vec<&str> = copied.map(|(_, channel)| channel.column).collect();
        let first = names.first()?;
        (0..inputs).any(is_other).then(|| Unusable::new(
            first,
            format!(
                "{} in {} and in {} are the same readings, row by row, although the inputs differ: one of the files has the readings of the other",
                names.join(", "),
                runs[a].file,
                runs[b].file
            ),
            format!("export {} and {} again, each with its own readings", runs[a].file, runs[b].file),
        ))
    })
}

/// Whether two columns are equal in nearly all rows in which either changes.
fn is_copy(a: &[f64], b: &[f64]) -> bool {
    let rows: Vec<(f64, f64)> =
        a.iter().copied().zip(b.iter().copied()).filter(|(x, y)| (x + y).is_finite()).collect();
    let moves: Vec<&[(f64, f64)]> =
        rows.windows(2).filter(|w| w[0].0 != w[1].0 || w[0].1 != w[1].1).collect();
    let equal = moves.iter().filter(|w| w[1].0 == w[1].1).count();
    moves.len() >= CHANGES && equal as f64 > NEARLY * moves.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::tests::{HOUSING, VOLTAGE, WINDING, column, experiment};

    /// One or all outputs, also if one file is shorter; two runs of a simulation with the same inputs are none.
    #[test]
    fn readings_of_another_file_are_unusable() {
        let two = |seed: u64, copied: &[usize], rows: usize| {
            let (mut own, other) = (experiment(seed), experiment(seed + 1));
            let mut second = other.runs[0].clone();
            second.file = "other.csv".to_string();
            for k in copied {
                second.table.columns[*k] = own.runs[0].table.columns[*k].clone();
            }
            second.table.time.truncate(rows);
            second.table.columns.iter_mut().for_each(|column| column.truncate(rows));
            own.runs.push(second);
            of_another_file(&own)
        };
        let all = experiment(44).runs[0].table.columns.len();
        assert_eq!(two(44, &[], all), None);
        for (copied, rows) in [(vec![WINDING], 2000), (vec![WINDING, HOUSING], 150), (vec![VOLTAGE], 2000)] {
            let why = two(44, &copied, rows).unwrap_or_else(|| panic!("{copied:?}"));
            assert!(why.reason.contains("other.csv"), "{}", why.reason);
        }
        assert_eq!(two(44, &(0..all).collect::<Vec<_>>(), 2000), None, "the same inputs");
    }

    #[test]
    fn a_column_that_repeats_another_is_unusable() {
        let mut good = experiment(41);
        assert_eq!(repeated(&good), None);
        // A logger that rounds: both thermometers take the same value now and then.
        for k in [WINDING, HOUSING] {
            column(&mut good, k).iter_mut().for_each(|x| *x = x.round());
        }
        assert_eq!(repeated(&good), None);
        for (of, into) in [(WINDING, HOUSING), (HOUSING, WINDING), (3, HOUSING)] {
            let mut copied = experiment(42);
            let noisy = |k: usize| 296.0 + 0.1 * (k as f64).sin();
            column(&mut copied, 3).iter_mut().enumerate().for_each(|(k, x)| *x = noisy(k));
            let own = column(&mut copied, of).clone();
            *column(&mut copied, into) = own;
            assert!(repeated(&copied).is_some(), "{of} {into}");
        }
        let mut other = experiment(43);
        let own = column(&mut other, WINDING).clone();
        *column(&mut other, VOLTAGE) = own;
        assert_eq!(repeated(&other), None, "another quantity");
    }
}
