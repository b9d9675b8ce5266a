//! From values to pixels, and the round values on an axis.

use super::layout::width;

/// From values to pixels.
pub(super) struct Scale {
    /// The ends, in the unit of the data.
    pub span: (f64, f64),
    pub pixels: (f64, f64),
    /// The unit of the ticks in that of the data: 60 for min where the data are in s.
    pub unit: f64,
}

impl Scale {
    pub fn at(&self, value: f64) -> f64 {
        self.pixels.0 + (value - self.span.0) / (self.span.1 - self.span.0) * (self.pixels.1 - self.pixels.0)
    }

    /// The place of a value, or of the end of the scale that is next to it.
    pub fn within(&self, value: f64) -> f64 {
        self.at(value.clamp(self.span.0.min(self.span.1), self.span.0.max(self.span.1)))
    }

    pub fn holds(&self, value: f64) -> bool {
        let slack = 1e-9 * (self.span.1 - self.span.0);
        value >= self.span.0 - slack && value <= self.span.1 + slack
    }

    /// Round values within the span, about `count` of them.
    pub fn ticks(&self, count: usize) -> Ticks {
        let span = (self.span.0 / self.unit, self.span.1 / self.unit);
        let rough = (span.1 - span.0) / count as f64;
        let decade = (rough * 1.000_001).log10().floor();
        let (factor, decade) = [1.0, 2.0, 5.0]
            .into_iter()
            .find(|m| m * 10f64.powf(decade) >= 0.999 * rough)
            .map_or((1.0, decade + 1.0), |m| (m, decade));
        let step = factor * 10f64.powf(decade);
        let first = (span.0 / step - 1e-9).ceil() as i64;
        let last = (span.1 / step + 1e-9).floor() as i64;
        let places: Vec<f64> = (first..=last).map(|k| k as f64 * step).collect();
        let greatest = |values: &[f64]| values.iter().fold(0.0, |size: f64, v| size.max(v.abs()));
        // Labels that would all begin with the same four digits or more are differences from a round value of 100 units of the last digit.
        let unit = (100.0 / factor) as i64;
        let origin = match greatest(&places) >= 0.999e4 * step {
            true => ((first + last + unit) / 2).div_euclid(unit) * unit,
            false => 0,
        };
        let size = greatest(&places.iter().map(|v| v - origin as f64 * step).collect::<Vec<_>>());
        let power = match size {
            0.0 => 0,
            _ if (1e-2..1e5).contains(&size) => 0,
            _ => 3 * ((size * 1.000_001).log10() / 3.0).floor() as i32,
        };
        let digits = (f64::from(power) - decade).clamp(0.0, 12.0) as usize;
        let label = |k: i64| match k {
            0 => "0".to_owned(),
            _ => format!("{:.digits$}", k as f64 * factor * 10f64.powf(decade - f64::from(power)))
                .replace('-', "\u{2212}"),
        };
        let labels = (first..=last).map(|k| label(k - origin)).collect();
        let origin = (origin != 0).then(|| rounded(origin as f64 * step, decade + 2.0));
        let places = places.into_iter().map(|place| place * self.unit).collect();
        Ticks { labels, places, power, origin }
    }

    /// At least three round values one above the other, about `count` of them: by two a reader cannot measure, and by one not at all.
    pub fn ticks_upwards(&self, count: usize) -> Ticks {
        // A step is at most 2.5 times what it was sought for, so the last has three.
        let finer = (count..8).map(|count| self.ticks(count)).find(|ticks| ticks.places.len() >= 3);
        finer.unwrap_or_else(|| self.ticks(count.max(8)))
    }

    /// As many ticks as have room side by side.
    pub fn ticks_that_fit(&self) -> Ticks {
        let room = (self.pixels.1 - self.pixels.0).abs();
        let fits = |t: &Ticks| {
            let widest = t.labels.iter().map(|l| width(l)).fold(0.0, f64::max);
            t.labels.len() as f64 * (widest + 14.0) <= room
        };
        [8, 6, 5, 4, 3].map(|count| self.ticks(count)).into_iter().find(fits).unwrap_or_else(|| self.ticks(2))
    }
}

/// A number down to the digit of this power of ten.
fn rounded(value: f64, last: f64) -> String {
    let size = value.abs();
    match (1e-4..1e7).contains(&size) {
        true => format!("{value:.*}", (-last).clamp(0.0, 12.0) as usize),
        false => format!("{value:.*e}", (size.log10().floor() - last).clamp(0.0, 12.0) as usize),
    }
    .replace('-', "\u{2212}")
}

/// Round places on an axis; their labels are differences from an origin, in units of a power of ten.
pub(super) struct Ticks {
    pub places: Vec<f64>,
    pub labels: Vec<String>,
    pub power: i32,
    pub origin: Option<String>,
}

impl Ticks {
    pub fn marks(&self) -> Vec<(f64, String)> {
        self.places.iter().copied().zip(self.labels.iter().cloned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(from: f64, to: f64, count: usize) -> Ticks {
        Scale { span: (from, to), pixels: (0.0, 100.0), unit: 1.0 }.ticks(count)
    }

    #[test]
    fn ticks_are_round_short_and_inside() {
        for ((from, to), labels, power) in [
            ((290.0, 420.0), vec!["300", "350", "400"], 0),
            ((0.0, 1.0), vec!["0", "0.2", "0.4", "0.6", "0.8", "1.0"], 0),
            ((-20.0, 20.0), vec!["\u{2212}20", "\u{2212}10", "0", "10", "20"], 0),
            ((0.0, 2e-5), vec!["0", "5", "10", "15", "20"], -6),
            ((0.0, 3e6), vec!["0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"], 6),
            ((25.0, 25.05), vec!["25.00", "25.01", "25.02", "25.03", "25.04", "25.05"], 0),
            ((1.13008, 1.13022), vec!["100", "150", "200"], -6),
            ((-0.060_300_1, -0.060_299_4), vec!["0", "200", "400", "600"], -9),
            ((100_000.0, 100_010.0), vec!["0", "2", "4", "6", "8", "10"], 0),
        ] {
            let found = ticks(from, to, 6);
            assert_eq!((found.labels, found.power), (labels.into_iter().map(str::to_owned).collect(), power));
        }
    }

    /// Every span has three ticks upwards, and they have room in a panel of 120 pixels.
    #[test]
    fn a_scale_can_be_read() {
        for k in 0..400 {
            let from = f64::from(k % 7) * 0.37 - 1.0;
            let span = 10f64.powf(f64::from(k) / 40.0 - 5.0);
            let scale = Scale { span: (from * span, (from + 1.0) * span), pixels: (120.0, 0.0), unit: 1.0 };
            let found = scale.ticks_upwards(4);
            let apart = (scale.at(found.places[0]) - scale.at(found.places[1])).abs();
            assert!(found.places.len() >= 3 && apart >= 13.0, "{:?}: {:?}", scale.span, found.labels);
        }
    }
}
