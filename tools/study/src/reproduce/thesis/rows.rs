//! Every published number of the thesis, in the order of the audit (T01 to T59): its text from `rows/rows.toml`, its values from here.

mod experiments;
mod model;
mod sheets;

use super::CaseResult;
use crate::reproduce::{Row, Rows};

/// The rows.
pub fn rows(cases: &[CaseResult]) -> Vec<Row> {
    let mut rows = Rows::read(include_str!("rows/rows.toml"));
    experiments::bare(&mut rows);
    experiments::tables(&mut rows, cases);
    experiments::discussion(&mut rows);
    model::rows(&mut rows);
    sheets::rows(&mut rows);
    rows.all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::thesis::Fits;
    use crate::reproduce::{Basis, Printed, Verdict};

    /// Values of a fitted model are marked and listed together with the predictions.
    #[test]
    fn a_fit_is_not_shown_as_a_prediction() {
        let found = crate::reproduce::thesis::thesis(Fits::Rig).unwrap();
        let fitted: Vec<&Row> = found.rows.iter().filter(|r| r.basis == Some(Basis::Fitted)).collect();
        assert_eq!(fitted.len(), 2 * 7, "T_w and R_ha of the seven columns");
        for row in fitted {
            let off = |value: Option<f64>| (value.unwrap() / row.measured.unwrap() - 1.0).abs();
            assert!(
                off(row.corrected) < off(row.leave_one_out),
                "{}: fitting a test brings the model nearer to it",
                row.id
            );
            assert!(row.untuned.is_some() && row.note.contains("fitted to"), "{}", row.id);
        }
        let rms = |of: &dyn Fn(&CaseResult) -> Option<f64>| {
            let square: f64 = found.cases.iter().map(|c| (of(c).unwrap() - c.T_w_measured_K).powi(2)).sum();
            (square / found.cases.len() as f64).sqrt()
        };
        let (fit, left, untuned) =
            (rms(&|c| Some(c.T_w_model_K)), rms(&|c| c.T_w_leave_one_out_K), rms(&|c| Some(c.T_w_untuned_K)));
        let sentence = format!(
            "{fit:.1} K fitted to all tests, {left:.1} K predicted from the other tests (leave-one-out), {untuned:.1} K"
        );
        assert!(found.findings.iter().any(|f| f.contains(&sentence)), "{sentence} in {:?}", found.findings);
        assert!(fit < 0.5 && left > 2.0 * fit && untuned > left, "{sentence}");
    }

    /// What holds agrees with what is published to a percent, and every audit number from T01 to T59 is there.
    #[test]
    fn verdicts_follow_from_the_numbers() {
        let rows = crate::reproduce::thesis::thesis(Fits::None).unwrap().rows;
        for k in 1..=59 {
            let id = format!("T{k:02}");
            assert!(rows.iter().any(|r| r.id.starts_with(&id)), "{id}");
        }
        for row in &rows {
            let Printed::Number(printed) = row.printed else { continue };
            if row.verdict == Verdict::Holds {
                let value = row.as_published.or(row.corrected).unwrap();
                assert!((value / printed - 1.0).abs() < 0.011, "{}: {printed} and {value}", row.id);
            }
            assert!(row.verdict == Verdict::Holds || !row.note.is_empty(), "{} has no reason", row.id);
        }
    }
}
