//! Rows that two runs share: fitted rows are not held out, and rows that are fitted twice have double weight.

use super::Run;
use super::copied_rows::{self, Readings};
use std::collections::HashSet;

/// Rows that adjacent windows share. Definition: the one row at their common time.
const AT_THE_BORDER: usize = 1;

/// What follows from rows that two runs share.
const CONSEQUENCE: &str = "errors on rows that were fitted are no test, and rows that are fitted twice count twice; state other windows \
                           or other files";

/// One sentence for each pair of runs with shared rows. The first `inputs` columns are inputs.
pub fn notes(inputs: usize, runs: &[Run]) -> Vec<String> {
    let rows: Vec<HashSet<Vec<u64>>> = runs.iter().map(|run| bits(inputs, run)).collect();
    let readings: Vec<Readings> = runs.iter().map(|run| Readings::of(inputs, run)).collect();
    let pairs = (0..runs.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    let of = |(a, b): (usize, usize)| {
        let shared = rows[a].intersection(&rows[b]).count();
        // Rows of two files may coincide where the motor is at rest and readings are coarse, but less than half of them.
        let by_chance = if runs[a].file == runs[b].file {
            AT_THE_BORDER
        } else {
            (rows[a].len().min(rows[b].len()) / 2).max(AT_THE_BORDER)
        };
        let (one, other) = (&runs[a].file, &runs[b].file);
        if shared > by_chance {
            return Some(format!(
                "{shared} rows of {one} count in another run as well ({other}): {CONSEQUENCE}"
            ));
        }
        let copied = copied_rows::count(&readings[a], &readings[b]).filter(|_| one != other)?;
        Some(format!(
            "{copied} rows of {other} have the readings of rows of {one}, noise included, although their times or their numbers of digits \
             differ: one is a copy of the other; {CONSEQUENCE}"
        ))
    };
    pairs.filter_map(of).collect()
}

/// Time and values of the evaluated rows of a run, as bits.
fn bits(inputs: usize, run: &Run) -> HashSet<Vec<u64>> {
    let table = &run.table;
    let row = |k: usize| std::iter::once(table.time[k]).chain(table.columns.iter().map(move |c| c[k]));
    counted(inputs, run).map(|k| row(k).map(f64::to_bits).collect()).collect()
}

/// The evaluated rows of a run that have a reading of an output.
pub fn counted(inputs: usize, run: &Run) -> impl Iterator<Item = usize> + '_ {
    let (from, to) = run.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let outputs = &run.table.columns[inputs..];
    let rows = run.table.time.iter().enumerate().filter(move |(_, t)| (from..=to).contains(*t));
    rows.map(|(k, _)| k).filter(|k| outputs.iter().any(|output| !output[*k].is_nan()))
}

#[cfg(test)]
mod tests {
    use super::super::{Role, Table};
    use super::*;

    fn run(file: &str, role: Role, shift: f64, window: Option<(f64, f64)>) -> Run {
        let time: Vec<f64> = (0..100).map(|k| 2.0 * f64::from(k)).collect();
        // The first thirty rows are at rest and identical in all files.
        let column = (0..100).map(|k| if k < 30 { 0.0 } else { (f64::from(k) + shift).sin() }).collect();
        let table = Table { time, columns: vec![column], ..Table::default() };
        let (priors, set) = (Vec::new(), Vec::new());
        Run { priors, file: file.to_string(), role, window, start: super::super::Start::Ambient, set, table }
    }

    #[test]
    fn rows_that_count_twice_are_found() {
        let fit = || run("a.csv", Role::Fit, 0.0, Some((0.0, 80.0)));
        for (other, shared) in [
            (run("a.csv", Role::Test, 0.0, None), 41),
            (run("a.csv", Role::Fit, 0.0, Some((70.0, 199.0))), 6),
            (run("copy.csv", Role::Test, 0.0, None), 41),
        ] {
            let found = notes(0, &[fit(), other]);
            let begin = format!("{shared} rows of a.csv count in another run as well (");
            assert!(found.len() == 1 && found[0].starts_with(&begin), "{found:?}");
        }
        // A copy with another clock, noted once.
        let mut late = run("late.csv", Role::Test, 0.0, None);
        late.table.time.iter_mut().for_each(|t| *t += 7.0);
        let found = notes(0, &[run("a.csv", Role::Fit, 0.0, None), late]);
        let begin =
            "100 rows of late.csv have the readings of rows of a.csv, noise included, although their times";
        assert!(found.len() == 1 && found[0].starts_with(begin), "{found:?}");
        // Adjacent windows of one file, and another run with the same rows at rest.
        assert!(notes(0, &[fit(), run("a.csv", Role::Test, 0.0, Some((80.0, 199.0)))]).is_empty());
        let whole = |file: &str, shift: f64| run(file, Role::Fit, shift, None);
        assert!(notes(0, &[whole("a.csv", 0.0), whole("b.csv", 0.3)]).is_empty());
        // The only column is an input: no row has an output reading.
        assert!(notes(1, &[fit(), run("a.csv", Role::Test, 0.0, None)]).is_empty());
    }
}
