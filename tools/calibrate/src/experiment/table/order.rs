//! The sentence on a time that does not come after that of the row before, with its likely cause.

use crate::experiment::stamp::{HOUR, Stamp};

/// Half a day, after which a 12-hour clock begins again. Definition: of this clock.
const HALF_DAY: f64 = 12.0 * HOUR;
/// Deviation of a change of the clock from its nominal length, s and intervals of the rows. Numerical: rounding of the stamps, and an
/// interval that is not constant.
const NEAR: (f64, f64) = (1.0, 0.5);

/// The time of a row.
#[derive(Clone, Debug)]
pub struct Instant {
    /// The time, s.
    pub time: f64,
    stamp: Stamp,
    cell: String,
    line: u64,
}

impl Instant {
    /// The time of a line from its cell.
    pub fn new(time: f64, stamp: Stamp, cell: &str, line: u64) -> Instant {
        Instant { time, stamp, cell: cell.to_owned(), line }
    }

    /// The time as the file has it; a number with its unit.
    fn text(&self, unit: &str) -> String {
        match self.stamp {
            Stamp::Number(number) => format!("{number} {unit}"),
            _ => self.cell.clone(),
        }
    }
}

/// The sentence; `interval` is that of the rows before, `repeated` are the lines of repeated headers.
pub fn sentence(now: &Instant, last: &Instant, interval: f64, repeated: &[u64], unit: &str) -> String {
    let cause = match repeated.iter().find(|line| (last.line..now.line).contains(line)) {
        Some(line) => format!(
            "the header is repeated in line {line}, and the clock of the logger started again: write each part into a file of its own"
        ),
        None => cause(now, last.time - now.time, interval).to_owned(),
    };
    format!("time_s = {} does not come after {} of the row before; {cause}", now.text(unit), last.text(unit))
}

fn cause(now: &Instant, back: f64, interval: f64) -> &'static str {
    let is_near = |change: f64| (back + interval - change).abs() <= NEAR.0 + NEAR.1 * interval;
    let is_number = matches!(now.stamp, Stamp::Number(_));
    if back == 0.0 {
        "the resolution of the times is coarser than the sampling interval: record fractions of a second, or the time in seconds"
    } else if is_number {
        "the time of the logger was reset, or the rows are not in order: write each recording into a file of its own"
    } else if is_near(HALF_DAY) {
        "a 12-hour clock without AM and PM begins again after 12:59: record 24 hours, or AM and PM"
    } else if is_near(HOUR) {
        "the clock was set back one hour, as at the end of daylight saving time: record UTC, or the offset (2026-10-25T02:00:00+01:00)"
    } else {
        "the clock of the logger was set back, or the rows are not in order: record the time in seconds since the start"
    }
}
