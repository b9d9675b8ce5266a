//! Every printed number of the thesis, in the order of the audit (T01 to T59).

mod experiments;
mod model;
mod sheets;

use super::native::Native;
use crate::StudyError;
use crate::reproduce::Row;

/// The rows.
///
/// # Errors
/// A native model that does not settle.
pub fn rows(native: &Native) -> Result<Vec<Row>, StudyError> {
    let mut rows = experiments::bare();
    rows.extend(experiments::tables(native)?);
    rows.extend(experiments::discussion());
    rows.extend(model::rows(native));
    rows.extend(sheets::rows());
    // T01, T02, ... T24-5mm ...: the audit's order is that of the text.
    rows.sort_by_key(|row| row.id);
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::{Printed, Verdict};

    /// What holds agrees with what is printed to a percent, and every audit number from T01 to T59 is there.
    #[test]
    fn verdicts_follow_from_the_numbers() {
        let rows = rows(&Native::find()).unwrap();
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
        let mut ids: Vec<&str> = rows.iter().map(|r| r.id).collect();
        ids.dedup();
        assert_eq!(ids.len(), rows.len(), "an id appears twice");
    }
}
