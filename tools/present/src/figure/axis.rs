//! What an axis shows: its quantity, its unit and its range.

use super::layout::Scale;

/// Units of time: what a range may be at most in s, the unit in s, and its symbol. A little more than 10 min and 5 h, so that a margin at
/// the end does not give one of several figures of the same run another unit.
const TIMES: [(f64, f64, &str); 3] =
    [(630.0, 1.0, "s"), (5.25 * 3600.0, 60.0, "min"), (f64::INFINITY, 3600.0, "h")];

/// An axis: its quantity with unit, and its range where that does not follow from the data.
#[derive(Clone, Debug)]
pub struct Axis {
    label: String,
    range: Option<(f64, f64)>,
    /// Whether the data are times in s, and the unit follows from their range.
    is_time: bool,
}

impl Axis {
    /// The axis of a quantity with its unit.
    pub fn new(label: &str) -> Axis {
        Axis { label: label.to_owned(), range: None, is_time: false }
    }

    /// The axis of a time. Data, range and notes are in s; ticks and label are in s up to 10 min, in min up to 5 h, and in h above.
    pub fn time() -> Axis {
        Axis { is_time: true, ..Axis::new("time") }
    }

    /// With a range.
    pub fn from_to(mut self, from: f64, to: f64) -> Axis {
        self.range = Some((from, to));
        self
    }

    /// The range, where it does not follow from the data.
    pub(super) fn range(&self) -> Option<(f64, f64)> {
        self.range
    }

    /// The unit of the ticks over a span, in that of the data.
    pub(super) fn unit_over(&self, span: (f64, f64)) -> f64 {
        TIMES.iter().find(|(most, ..)| span.1 - span.0 <= *most).filter(|_| self.is_time).map_or(1.0, |t| t.1)
    }

    /// The quantity with the unit of the ticks.
    pub(super) fn label(&self, scale: &Scale) -> String {
        match TIMES.iter().find(|(_, unit, _)| self.is_time && *unit == scale.unit) {
            Some((.., symbol)) => format!("{} in {symbol}", self.label),
            None => self.label.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_the_unit_of_their_range() {
        let (min, h) = (60.0, 3600.0);
        for ((from, to), label, ticks) in [
            ((0.0, 3.0), "time in s", vec!["0", "1", "2", "3"]),
            ((0.0, 9.0 * min), "time in s", vec!["0", "200", "400"]),
            // A margin of 2 % behind 10 min.
            ((0.0, 612.0), "time in s", vec!["0", "200", "400", "600"]),
            ((0.0, 40.0 * min), "time in min", vec!["0", "10", "20", "30", "40"]),
            ((0.0, 5.0 * h), "time in min", vec!["0", "100", "200", "300"]),
            ((0.0, 10.0 * h), "time in h", vec!["0", "5", "10"]),
            ((0.0, 72.0 * h), "time in h", vec!["0", "20", "40", "60"]),
            // The clock of a file: the unit is that of the range, not that of the clock.
            ((39_000.0, 42_000.0), "time in min", vec!["660", "680", "700"]),
            ((-90.0, 90.0), "time in s", vec!["\u{2212}50", "0", "50"]),
        ] {
            let axis = Axis::time();
            let scale = Scale::over(&axis, [from, to].into_iter(), 0.0, (0.0, 100.0));
            let found = scale.ticks(4);
            assert_eq!(
                (axis.label(&scale).as_str(), &found.labels),
                (label, &ticks.iter().map(|t| (*t).to_owned()).collect())
            );
            let seconds =
                |label: &String| label.replace('\u{2212}', "-").parse::<f64>().unwrap() * scale.unit;
            assert_eq!(found.places, found.labels.iter().map(seconds).collect::<Vec<_>>());
        }
    }

    /// Other axes keep the unit that they are given, whatever their range.
    #[test]
    fn only_times_change_their_unit() {
        let axis = Axis::new("speed in rad/s");
        let scale = Scale::over(&axis, [0.0, 40_000.0].into_iter(), 0.0, (0.0, 100.0));
        assert_eq!((scale.unit, axis.label(&scale).as_str()), (1.0, "speed in rad/s"));
    }
}
