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
    use crate::reproduce::thesis::Fits;
    use crate::reproduce::{Printed, Verdict};

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
