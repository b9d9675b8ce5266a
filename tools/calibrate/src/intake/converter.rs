//! Converter faults of thermometers: a stuck bit, missing codes, a range that is switched.
//!
//! The readings jump by the same amount whenever the temperature passes certain values, up and down. A temperature belongs to a heat
//! capacity; an effect on it has many sizes, and follows the load. Jumps are the changes between rows that a gap separates from all
//! others,
//!
//! e_k = min(|c_k|, |c_k - c_(k-1)|, |c_k - c_(k+1)|),   e_(j+1) > [`FACTOR`] e_(j),   e_(j+1) > [`SENSOR_ERROR`]           (1)
//!
//! c_k the change of the reading before row k, e_(1), e_(2), ... in ascending order: a heat that sets in or ends leaves one of the
//! neighbouring changes equal. At most a tenth of the changes are jumps. They are of one kind if their sizes |c| differ by no more than
//! twice as much as the other changes do. A step of the heat always follows a change of an input, a fault of the converter as often as any
//! row does: the fraction of the jumps that follow one has to be nearer to that of all rows than to 1.
//!
//! *Source*: IEEE Std 1241-2010, Standard for Terminology and Test Methods for Analog-to-Digital Converters (missing codes, differential
//! nonlinearity).

use super::signals::{REPEATED, Readings, SENSOR_ERROR, bound};
use super::{range, sorted};
use crate::experiment::{Experiment, Run};
use crate::levels::{FACTOR, SMALL};

/// Rows before a jump within which a change of an input is its cause. Derivation: an input is linear between rows, so that what it causes
/// begins in one interval and is greatest in this or the next.
const BEFORE: usize = 2;

/// Jumps of a column.
struct Jumps {
    rows: Vec<usize>,
    /// Their median size.
    size: f64,
    /// Range of their sizes.
    range: f64,
    /// Range of the other changes.
    usual: f64,
}

/// Sets aside the thermometers whose readings jump repeatedly by the same amount without a cause, with notes.
pub fn set_aside(experiment: &mut Experiment) {
    let inputs = experiment.inputs.len();
    let least = bound(experiment);
    for k in 0..experiment.outputs.len() {
        let channel = experiment.outputs[k];
        if !channel.is_temperature() {
            continue;
        }
        for run in &mut experiment.runs {
            let Some(found) =
                jumps(&run.table.columns[inputs + k]).filter(|own| is_fault(run, inputs, least, own))
            else {
                continue;
            };
            experiment.notes.push(format!(
                "{}: {} jumps {} times by {:.1} K, whether an input changes or not, as a converter with a stuck bit or missing codes or a \
                 switched range does; it is set aside in this run",
                run.file,
                channel.column,
                found.rows.len(),
                found.size
            ));
            run.table.columns[inputs + k].fill(f64::NAN);
        }
    }
}

/// (1)
fn jumps(column: &[f64]) -> Option<Jumps> {
    let rows: Vec<usize> = (0..column.len()).filter(|row| column[*row].is_finite()).collect();
    let changes: Vec<f64> = rows.windows(2).map(|pair| column[pair[1]] - column[pair[0]]).collect();
    let apart = |k: usize, other: Option<&f64>| other.map_or(f64::INFINITY, |c| (changes[k] - c).abs());
    let e = |k: usize| {
        let beside = [k.checked_sub(1).map(|k| &changes[k]), changes.get(k + 1)];
        beside.into_iter().map(|other| apart(k, other)).fold(changes[k].abs(), f64::min)
    };
    let mut all: Vec<(f64, usize)> = (0..changes.len()).map(|k| (e(k), k)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ratio = |j: usize| all[j].0 / all[j - 1].0.max(f64::MIN_POSITIVE);
    let from = all.len() - (SMALL * all.len() as f64) as usize;
    let first = (from.max(1)..all.len()).max_by(|a, b| ratio(*a).total_cmp(&ratio(*b)))?;
    if ratio(first) <= FACTOR || all[first].0 <= SENSOR_ERROR {
        return None;
    }
    let ends = |of: &[(f64, usize)], size: &dyn Fn(f64) -> f64| {
        let sizes = sorted(of.iter().map(|(_, k)| size(changes[*k])));
        (sizes[sizes.len() - 1] - sizes[0], sizes[sizes.len() / 2])
    };
    let (own, others) = (&all[first..], &all[..first]);
    let (range, size) = ends(own, &f64::abs);
    let (usual, _) = ends(others, &|change| change);
    Some(Jumps { rows: own.iter().map(|(_, k)| rows[k + 1]).collect(), size, range, usual })
}

/// Whether the jumps are repeated, of one size, and not caused by the inputs.
fn is_fault(run: &Run, inputs: usize, least: f64, found: &Jumps) -> bool {
    let table = &run.table;
    let inputs: Vec<(&[f64], f64)> = table.columns[..inputs]
        .iter()
        .map(|c| (&c[..], least * Readings::of(&table.time, c).size()))
        .collect();
    let has_cause = |row: &usize| {
        let near = row.saturating_sub(BEFORE)..=*row;
        inputs.iter().any(|(column, least)| range(column[near.clone()].iter().copied()) > *least)
    };
    let fraction = |rows: &mut dyn Iterator<Item = usize>| {
        let (count, causes) = rows.fold((0, 0), |(n, m), row| (n + 1, m + usize::from(has_cause(&row))));
        causes as f64 / f64::from(count.max(1))
    };
    let usual = fraction(&mut (0..table.time.len()));
    found.rows.len() >= REPEATED
        && found.range < 2.0 * found.usual
        && fraction(&mut found.rows.iter().copied()) < 0.5 * (1.0 + usual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::tests::{CURRENT, HOUSING, WINDING, column, experiment, with_inputs};

    /// What a converter shows instead of a reading.
    type Fault = fn(f64) -> f64;

    fn bits(x: f64, step: f64) -> u32 {
        ((x - 273.15) / step) as u32
    }

    const STUCK: [(&str, Fault); 2] = [
        ("bit of 6.4 K stuck low", |x| x - 6.4 * f64::from(bits(x, 6.4) % 2)),
        ("bit of 12.8 K stuck high", |x| x + 12.8 * f64::from(1 - bits(x, 12.8) % 2)),
    ];
    /// At one reading only, which the winding of this bench passes just after a step of the load.
    const ONE: [(&str, Fault); 2] = [
        ("range switched at 44 degC", |x| if x > 317.15 { x + 0.1 * (x - 273.15) } else { x }),
        ("missing codes", |x| if (316.0..320.0).contains(&x) { 316.0 } else { x }),
    ];

    #[test]
    fn a_converter_fault_is_set_aside() {
        let of = |k: usize, faults: [(&'static str, Fault); 2]| faults.map(|(name, fault)| (k, name, fault));
        for (k, name, fault) in [of(WINDING, STUCK), of(HOUSING, STUCK), of(HOUSING, ONE)].concat() {
            let mut faulty = experiment(41);
            column(&mut faulty, k).iter_mut().for_each(|x| *x = fault(*x));
            set_aside(&mut faulty);
            let is_blank = column(&mut faulty, k).iter().all(|x| x.is_nan());
            assert!(is_blank && faulty.notes.len() == 1, "{name} {k}: {:?}", faulty.notes);
        }
    }

    /// A winding that is fast for the distance of the rows changes by the same amount at each step of the load.
    #[test]
    fn equal_steps_of_a_load_are_no_fault() {
        let mut good = with_inputs(42, |columns| {
            columns[CURRENT].iter_mut().enumerate().for_each(|(k, i)| *i = [0.0, 6.0][k / 30 % 2]);
        });
        let readings = column(&mut good, WINDING).clone();
        // Every 10th row: 30 s.
        let table = &mut good.runs[0].table;
        table.time = table.time.iter().step_by(10).copied().collect();
        table.columns.iter_mut().for_each(|c| *c = c.iter().step_by(10).copied().collect());
        set_aside(&mut good);
        assert_eq!(column(&mut good, WINDING).len(), readings.len() / 10);
        assert!(column(&mut good, WINDING).iter().all(|x| x.is_finite()), "{:?}", good.notes);
        let mut other = experiment(43);
        set_aside(&mut other);
        assert!(other.notes.is_empty(), "{:?}", other.notes);
    }
}
