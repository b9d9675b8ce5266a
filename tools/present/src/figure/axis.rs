//! What an axis shows: its quantity, its unit and its range.

use super::scale::{Scale, Ticks};
use crate::units::times_ten_to;

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
    /// What stands for 0, 1, 2 ...
    names: Vec<String>,
}

impl Axis {
    /// The axis of a quantity with its unit.
    pub fn new(label: &str) -> Axis {
        Axis { label: label.to_owned(), range: None, is_time: false, names: Vec::new() }
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

    /// With names in place of the numbers 0, 1, 2 ..., such as `false` and `true`.
    pub fn names(mut self, names: &[&str]) -> Axis {
        self.names = names.iter().map(|name| (*name).to_owned()).collect();
        // Lines at the outer names are not on the frame.
        self.from_to(-0.1, names.len() as f64 - 0.9)
    }

    /// The range, where it does not follow from the data.
    pub(super) fn range(&self) -> Option<(f64, f64)> {
        self.range
    }

    /// Its scale: over its range, or over all numbers with a margin; never empty.
    pub(super) fn scale(&self, values: impl Iterator<Item = f64>, margin: f64, pixels: (f64, f64)) -> Scale {
        // Beyond these sizes a span has no inverse; below, a number is rounding about zero.
        let numbers = values.filter(|v| v.abs() < 1e150).map(|v| if v.abs() < 1e-60 { 0.0 } else { v });
        let (low, high) = numbers.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        let span = match (self.range, low.abs().max(high.abs())) {
            (Some(range), _) => range,
            _ if low > high => (0.0, 1.0),
            (None, 0.0) => (-1.0, 1.0),
            // Values that differ by rounding alone are constant.
            (None, size) if high - low < 1e-9 * size => (low - 0.05 * size, high + 0.05 * size),
            _ => (low - margin * (high - low), high + margin * (high - low)),
        };
        Scale { span, pixels, unit: self.unit_over(span) }
    }

    /// The unit of the ticks over a span, in that of the data.
    pub(super) fn unit_over(&self, span: (f64, f64)) -> f64 {
        TIMES.iter().find(|(most, ..)| span.1 - span.0 <= *most).filter(|_| self.is_time).map_or(1.0, |t| t.1)
    }

    /// The ticks upwards, about `count` of them.
    pub(super) fn ticks_upwards(&self, scale: &Scale, count: usize) -> Ticks {
        match self.names.len() {
            0 => scale.ticks_upwards(count),
            names => Ticks {
                places: (0..names).map(|k| k as f64).collect(),
                labels: self.names.clone(),
                power: 0,
                origin: None,
            },
        }
    }

    /// The quantity, and its unit on a scale; a label without " in " has none.
    fn parts(&self, scale: &Scale) -> (&str, &str) {
        if let Some((.., symbol)) = TIMES.iter().find(|(_, unit, _)| self.is_time && *unit == scale.unit) {
            return (&self.label, symbol);
        }
        // What has a space behind " in " goes on as a sentence.
        self.label.rsplit_once(" in ").filter(|(_, unit)| !unit.contains(' ')).unwrap_or((&self.label, ""))
    }

    /// The quantity with the unit of the tick labels, which holds their power of ten; of differences with the origin that is taken away.
    pub(super) fn title(&self, scale: &Scale, ticks: &Ticks) -> String {
        let (quantity, unit) = self.parts(scale);
        // A difference of temperatures in °C is in K.
        let of_difference = if ticks.origin.is_some() && unit == "°C" { "K" } else { unit };
        let of_ticks = times_ten_to(ticks.power, of_difference);
        let Some(origin) = &ticks.origin else {
            return if of_ticks.is_empty() {
                quantity.to_owned()
            } else {
                format!("{quantity} in {of_ticks}")
            };
        };
        let (sign, size) =
            origin.strip_prefix('\u{2212}').map_or(('\u{2212}', origin.as_str()), |size| ('+', size));
        let difference = format!("{quantity} {sign} {} ", [size, unit].join(" ").trim_end());
        match of_ticks.is_empty() {
            true => difference.trim_end().to_owned(),
            false => format!("{}, in {of_ticks}", difference.trim_end()),
        }
    }

    /// A length along the axis with two digits and its unit.
    pub(super) fn amount(&self, scale: &Scale, length: f64) -> String {
        let length = length / scale.unit;
        let last = 10f64.powf(length.abs().log10().floor() - 1.0);
        let rounded = crate::number((length / last).round() * last);
        format!("{rounded} {}", self.parts(scale).1).trim_end().to_owned()
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
            let scale = axis.scale([from, to].into_iter(), 0.0, (0.0, 100.0));
            let found = scale.ticks(4);
            assert_eq!(
                (axis.title(&scale, &found).as_str(), &found.labels),
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
        let scale = axis.scale([0.0, 40_000.0].into_iter(), 0.0, (0.0, 100.0));
        assert_eq!((scale.unit, axis.title(&scale, &scale.ticks(4)).as_str()), (1.0, "speed in rad/s"));
    }

    /// "× 10⁻³" behind a unit leaves open whether a tick is to be multiplied or was.
    #[test]
    fn powers_of_ten_are_in_the_unit() {
        for (label, from, to, expected) in [
            ("torque in N·m", 0.0, 0.005, "torque in mN·m"),
            ("motor R ref in Ω", 1e-4, 5e-4, "motor R ref in µΩ"),
            ("flow in m³/s", 0.0, 2e-5, "flow in 10⁻⁶ m³/s"),
            ("fraction", 0.0, 2e-5, "fraction in 10⁻⁶"),
            (
                "torque constant in N·m/A",
                0.027_600_1,
                0.027_600_4,
                "torque constant − 0.027600 N·m/A, in nN·m/A",
            ),
            ("torque", -0.060_300_1, -0.060_299_4, "torque + 0.06030, in 10⁻⁹"),
            ("voltage in V", 100_000.0, 100_010.0, "voltage − 100000 V, in V"),
            ("winding in °C", 25.0, 25.003, "winding − 25.00 °C, in mK"),
            (
                "change in one of the parts in percent of all",
                0.0,
                1.0,
                "change in one of the parts in percent of all",
            ),
        ] {
            let axis = Axis::new(label);
            let scale = axis.scale([from, to].into_iter(), 0.0, (100.0, 0.0));
            assert_eq!(axis.title(&scale, &scale.ticks(6)), expected);
        }
    }

    #[test]
    fn names_stand_at_their_numbers() {
        let axis = Axis::new("switch").names(&["false", "true"]);
        let scale = axis.scale([0.0].into_iter(), 0.06, (120.0, 0.0));
        let ticks = axis.ticks_upwards(&scale, 4);
        assert_eq!(ticks.marks(), [(0.0, "false".to_owned()), (1.0, "true".to_owned())]);
        assert_eq!(
            (axis.title(&scale, &ticks).as_str(), scale.holds(0.0), scale.holds(1.0)),
            ("switch", true, true)
        );
    }

    #[test]
    fn lengths_have_two_digits_and_the_unit_of_the_axis() {
        let amount = |axis: &Axis, to: f64, length: f64| {
            axis.amount(&axis.scale([0.0, to].into_iter(), 0.0, (0.0, 400.0)), length)
        };
        assert_eq!(amount(&Axis::time(), 500.0, 3.1234), "3.1 s");
        assert_eq!(amount(&Axis::time(), 36_000.0, 270.0), "0.075 h");
        assert_eq!(amount(&Axis::new("speed in rad/s"), 1e5, 1234.5), "1200 rad/s");
        assert_eq!(amount(&Axis::new("number of the run"), 10.0, 0.1), "0.1");
    }
}
