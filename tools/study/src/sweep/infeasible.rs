//! Points of a sweep with the names and units of their values, and the reasons of the infeasible ones.

use super::{Choice, PRESET, Sweep};
use present::words::{is_word, words};

/// A name of whole words in words; that of a symbol, such as `motor.R_ref`, as it is set.
pub(super) fn named(name: &str) -> String {
    if name.split(['.', '_']).all(is_word) { words(name) } else { name.to_owned() }
}

/// An item of a variable in words; a motor keeps its name.
pub(super) fn item(variable: &str, name: &str) -> String {
    if variable == PRESET { name.to_owned() } else { words(name) }
}

impl Sweep {
    /// Names and values of the varied variables, as they are set.
    pub fn place(&self, values: &[Choice]) -> String {
        let named = self.varied.iter().zip(&self.shown).zip(values);
        named
            .map(|((name, shown), value)| format!("{name} = {}", value.with_unit(shown)))
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// The same in words, for figures; the values are those from variable `first` on.
    pub(super) fn place_in_words(&self, first: usize, values: &[Choice]) -> String {
        let pairs = self.varied[first..].iter().zip(&self.shown[first..]).zip(values);
        let parts = pairs.map(|((name, shown), value)| match value {
            Choice::Number(_) => format!("{} = {}", named(name), value.in_words(shown)),
            Choice::Word(word) => format!("{} = {}", named(name), item(name, word)),
        });
        parts.collect::<Vec<_>>().join(", ")
    }

    /// The reasons of the infeasible points, each with its points.
    fn reasons(&self) -> Vec<(&str, Vec<&[Choice]>)> {
        let mut reasons: Vec<(&str, Vec<&[Choice]>)> = Vec::new();
        for point in &self.points {
            let Some(failure) = &point.failure else { continue };
            match reasons.iter_mut().find(|(reason, _)| reason == failure) {
                Some((_, places)) => places.push(&point.values),
                None => reasons.push((failure, vec![&point.values])),
            }
        }
        reasons
    }

    /// Number of the infeasible points, and a line for each of at most `listed` reasons; empty where all are feasible.
    pub fn infeasible_points(&self, listed: usize, place: impl Fn(&[Choice]) -> String) -> Vec<String> {
        let reasons = self.reasons();
        if reasons.is_empty() {
            return Vec::new();
        }
        let mut lines = vec![format!("{} of {} points infeasible", self.infeasible, self.points.len())];
        for (reason, places) in reasons.iter().take(listed) {
            let more = match places.len() - 1 {
                0 => String::new(),
                1 => " and 1 more point".to_owned(),
                more => format!(" and {more} more points"),
            };
            lines.push(format!("{}{more}: {reason}", place(places[0])));
        }
        if let more @ 1.. = reasons.len().saturating_sub(listed) {
            let reasons = if more == 1 { "reason" } else { "reasons" };
            lines.push(format!("{more} more {reasons}; --json lists all points"));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use crate::steady::Setup;
    use crate::sweep::{ConstantInputs, Goal, Vary, sweep};

    /// A figure names variables and items in words, with units; each reason is a line that ends, and no instant of a search is in it.
    #[test]
    fn reasons_are_lines_in_words() {
        let case =
            ConstantInputs { setup: Setup::new("AnnulusCooledMotor", None, &[("drive_mode", "current")]) };
        let vary = ["current_command=1:40:4", "cooling_mode=conductance,water_jacket"];
        let vary = vary.map(|text| Vary::parse(text).unwrap());
        let found = sweep(&case, &vary, &Goal::of("winding_temperature"), |_| {}).unwrap();
        let lines = found.infeasible_points(12, |values| found.place(values));
        assert!(lines[0].ends_with("of 8 points infeasible") && lines.len() > 1, "{lines:?}");
        assert!(lines[1].starts_with("current_command = 14 A, cooling_mode = "), "{lines:?}");
        // Equal reasons stand together.
        assert!(lines[1].contains(" more point") && !lines[1].contains(" s:"), "{lines:?}");
        let one = found.infeasible_points(0, |values| found.place(values));
        assert!(one[1].ends_with("; --json lists all points"), "{one:?}");
        let figure = found.figure().unwrap().svg();
        for text in ["current command = 14 A", "cooling mode = water jacket"] {
            assert!(figure.contains(text), "{text}: {figure}");
        }
        assert!(figure.contains(" of 8 points infeasible.<") && !figure.contains("water_jacket"), "{figure}");
    }
}
