//! A sweep as CSV and as a figure.

use super::{Choice, Sweep};
use crate::StudyError;
use present::figure::{Axis, Figure};

impl Sweep {
    /// Header and rows, 17 digits; the quantities of an infeasible point are blank.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.objectives.iter().map(|o| o.name.as_str()).collect();
        let mut text = format!("{},{}\n", self.varied.join(","), names.join(","));
        for point in &self.points {
            let values = point.values.iter().map(|value| match value {
                Choice::Number(number) => format!("{number:.16e}"),
                Choice::Word(word) => word.clone(),
            });
            let found = (0..names.len())
                .map(|k| point.objectives.get(k).map_or(String::new(), |o| format!("{o:.16e}")));
            text += &values.chain(found).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }

    /// The figure: the first objective over the first variable, a line for each value of the second.
    ///
    /// # Errors
    /// More than two variables, or more lines than are distinguishable.
    pub fn figure(&self) -> Result<Figure, StudyError> {
        const MAX_LINES: usize = 8;
        let axis = |name: &str, of: &str| Axis::new(&format!("{}{}", words(name), unit(" in ", of)));
        let source = self.source.as_ref().map_or(String::new(), |source| format!(". {source}"));
        let mut figure = Figure::new(
            &format!("{} over {}{source}", words(&self.objective), words(&self.varied.join(" and "))),
            axis(&self.varied[0], self.units[0]),
            axis(&self.objective, self.objective_unit),
        );
        type Points = Vec<(f64, f64)>;
        let mut lines: Vec<(Option<Choice>, Points)> = Vec::new();
        // Words are drawn as categories.
        let mut words_of_x: Vec<String> = Vec::new();
        if self.varied.len() > 2 {
            return Err(StudyError::new(
                "--plot takes one or two varied variables; --output takes any number",
            ));
        }
        for point in &self.points {
            let key = point.values.get(1).cloned();
            let x = point.values[0].number().unwrap_or_else(|| {
                let word = point.values[0].shown();
                words_of_x.iter().position(|known| *known == word).unwrap_or_else(|| {
                    words_of_x.push(word);
                    words_of_x.len() - 1
                }) as f64
            });
            let place = (x, point.objective.unwrap_or(f64::NAN));
            match lines.iter_mut().find(|(k, _)| *k == key) {
                Some((_, line)) => line.push(place),
                None => lines.push((key, vec![place])),
            }
        }
        if lines.len() > MAX_LINES {
            return Err(StudyError::new(format!(
                "--plot draws a line for each of the {} values of {}; {MAX_LINES} are possible",
                lines.len(),
                self.varied[1]
            )));
        }
        for (key, line) in lines {
            let label = key.map_or(String::new(), |k| {
                format!("{} = {}{}", words(&self.varied[1]), k.shown(), unit(" ", self.units[1]))
            });
            figure = match words_of_x.is_empty() {
                true => figure.line(&label, line),
                false => figure.points(&label, line),
            };
        }
        if !words_of_x.is_empty() {
            figure = figure.categories(&words_of_x.iter().map(String::as_str).collect::<Vec<_>>());
        }
        Ok(figure)
    }
}

/// The name of a variable in words.
fn words(name: &str) -> String {
    name.replace(['_', '.'], " ")
}

/// A unit after a separator; a pure number has none.
fn unit(separator: &str, unit: &str) -> String {
    if unit == "1" { String::new() } else { format!("{separator}{}", unit.replace('.', "·")) }
}
