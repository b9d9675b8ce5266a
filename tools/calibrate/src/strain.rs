//! Estimates that their priors hardly permit.
//!
//! Heat capacities, inductances and inertias appear only as products with a time derivative. If the times of the readings are k times the
//! true ones, all of them are estimated k times too large, and nothing else is. With x_i = ln(value / prior) and s_i the relative standard
//! deviations of the priors, a common factor leaves
//!
//! sum (x_i - ln k)^2 / s_i^2,   ln k = sum x_i s_i^-2 / sum s_i^-2                                             (1)
//!
//! of the squared deviations. It is stated as the cause if it removes more than [`CERTAIN`]^2 of them, what is left is usual, and no other
//! parameter is strained. It may be the motor as well: it is a note and refuses no data.

use crate::comparison::with_unit;
use crate::experiment::Experiment;
use crate::levels::{CERTAIN, SURE};
use crate::setup::Declared;
use physics::declare::Unit;

/// Units of the quantities that are multiplied by a time derivative. Definition: of heat capacity, inductance, inertia.
const STORES: [Unit; 3] = [Unit::JoulePerKelvin, Unit::Henry, Unit::KilogramSquareMetre];
/// Interval of a time that may be a number of the row, s. Definition: rows are numbered by ones.
const ROW: f64 = 1.0;

/// Sentences on all parameters at a limit or far from their priors.
pub fn notes(experiment: &Experiment, declared: &[Declared], values: &[f64]) -> Vec<String> {
    let pairs = || declared.iter().zip(values.iter().copied());
    let (stores, others): (Vec<_>, Vec<_>) = pairs().partition(|(d, _)| is_store(d));
    let factor = common_factor(&stores).filter(|_| !others.iter().any(|(d, v)| is_strained(d, *v)));
    let mut notes: Vec<String> =
        pairs().filter(|(d, _)| factor.is_none() || !is_store(d)).filter_map(|(d, v)| strain(d, v)).collect();
    if let Some(factor) = factor {
        let own = |(d, v): &(&Declared, f64)| {
            format!("{} = {} (prior {})", d.name, with_unit(*v, d.unit), with_unit(d.prior, d.unit))
        };
        let rows = if numbers_the_rows(experiment) {
            "; it increases by 1 from row to row, as row numbers do"
        } else {
            ""
        };
        notes.push(format!(
            "{} are about {factor:.3} times their priors, and no other parameter is far from its own: times multiplied by {:.3} would agree \
             with the priors: check the unit and the interval of time_s{rows}; or the preset is that of another motor",
            stores.iter().map(own).collect::<Vec<_>>().join(", "),
            1.0 / factor
        ));
    }
    notes
}

fn is_store(d: &Declared) -> bool {
    d.is_held() && d.prior > 0.0 && STORES.iter().any(|unit| unit.name() == d.unit)
}

fn is_strained(d: &Declared, value: f64) -> bool {
    d.is_held() && (value - d.prior).abs() > CERTAIN * d.deviation
}

/// (1)
fn common_factor(stores: &[(&Declared, f64)]) -> Option<f64> {
    let all = || stores.iter().map(|(d, v)| ((v / d.prior).ln(), (d.prior / d.deviation).powi(2)));
    let (sum, weight) = all().fold((0.0, 0.0), |(sum, weight), (x, w)| (sum + w * x, weight + w));
    let mean = sum / weight;
    let left: f64 = all().map(|(x, w)| w * (x - mean).powi(2)).sum();
    let is_usual = left <= SURE.powi(2) * (stores.len() as f64 - 1.0);
    (stores.len() > 1 && is_usual && sum * mean > CERTAIN.powi(2)).then(|| mean.exp())
}

/// Whether the time may be the number of the row.
fn numbers_the_rows(experiment: &Experiment) -> bool {
    experiment.runs.iter().all(|run| run.table.time.windows(2).all(|pair| pair[1] - pair[0] == ROW))
}

/// Sentence on a parameter at a limit, or with a value that its prior hardly permits.
fn strain(d: &Declared, value: f64) -> Option<String> {
    let (name, (least, most)) = (&d.name, d.limits);
    let apart = (value - d.prior).abs() / d.deviation;
    let [own, prior] = [value, d.prior].map(|x| with_unit(x, d.unit));
    if value <= least || value >= most {
        let side = if value <= least { "lower" } else { "greater" };
        Some(format!(
            "{name} = {own} is at its limit: the data ask for a {side} value, or do not determine it"
        ))
    } else if is_strained(d, value) {
        Some(format!(
            "{name} = {own} is {apart:.1} standard deviations of its prior from {prior}: check the prior and the data, or an effect that \
             the model still lacks moves it"
        ))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::Setup;
    use crate::testing;

    /// A value that its prior hardly permits is stated, and one at a limit; a usual one is not.
    #[test]
    fn values_far_from_their_priors_are_stated() {
        let experiment = testing::experiment("\"thermal.C_w\" = 0.1", true);
        let d = &Setup::new(&experiment, &[]).unwrap().declared[0];
        assert_eq!(strain(d, 1.35 * d.prior), None);
        let sentence = strain(d, 0.5 * d.prior).unwrap();
        assert!(
            sentence.contains("thermal.C_w") && sentence.contains("5.0 standard deviations"),
            "{sentence}"
        );
        let sentence = strain(d, d.limits.0).unwrap();
        assert!(sentence.contains("is at its limit: the data ask for a lower") && !sentence.contains("0000"));
    }

    /// Both heat capacities by one factor are a question of time; one of them, or a resistance beside them, is not.
    #[test]
    fn a_common_factor_of_the_heat_capacities_is_one_of_time() {
        let priors = "\"thermal.C_w\" = 0.1\n\"thermal.C_h\" = 0.05\n\"thermal.R_wh\" = 0.1";
        let mut experiment = testing::experiment(priors, true);
        let declared = Setup::new(&experiment, &[]).unwrap().declared;
        let with = |experiment: &Experiment, [winding, housing, between]: [f64; 3]| {
            let factor = |d: &Declared| match d.name.as_str() {
                "thermal.C_w" => winding,
                "thermal.C_h" => housing,
                _ => between,
            };
            let values: Vec<f64> = declared.iter().map(|d| factor(d) * d.prior).collect();
            notes(experiment, &declared, &values).join("; ")
        };
        let both = with(&experiment, [0.5, 0.5, 1.0]);
        assert!(both.contains("thermal.C_w") && both.contains("thermal.C_h"), "{both}");
        assert!(both.contains("times multiplied by 2.000") && !both.contains("row numbers"), "{both}");
        assert!(with(&experiment, [1.4, 1.5, 1.0]).contains("times multiplied by 0.67"));
        for factors in [[1.0, 0.5, 1.0], [0.5, 2.0, 1.0], [0.5, 0.5, 1.5], [1.1, 1.1, 1.0]] {
            assert!(!with(&experiment, factors).contains("times multiplied"), "{factors:?}");
        }
        let table = &mut experiment.runs[0].table;
        table.time = (0..table.time.len()).map(|row| row as f64).collect();
        assert!(with(&experiment, [0.5, 0.5, 1.0]).contains("as row numbers do"));
    }
}
