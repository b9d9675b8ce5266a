//! A sweep as CSV and as a figure.

use super::infeasible::item;
use super::{Choice, Shown, Sweep, Vary};
use crate::StudyError;
use present::figure::{Axis, Figure};
use present::words::{sentence, unit, words};

/// Reasons of infeasible points below a figure.
const LISTED: usize = 3;

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

    /// The figure: the first objective over the first variable, a line for each combination of the others.
    ///
    /// # Errors
    /// As [`check_figure`].
    pub fn figure(&self) -> Result<Figure, StudyError> {
        let axis = |name: &str, of: &Shown| Axis::new(&format!("{}{}", words(name), unit(&of.unit(" in "))));
        let source = self.source.as_ref().map_or(String::new(), |source| format!(". {source}"));
        let objective = self.objectives[0].shown();
        let varied: Vec<String> = self.varied.iter().map(|name| words(name)).collect();
        let mut figure = Figure::new(
            &format!("{} over {}{source}", words(&self.objective), varied.join(" and ")),
            axis(&self.varied[0], &self.shown[0]),
            axis(&self.objective, &objective),
        );
        let infeasible = self.infeasible_points(LISTED, |values| self.place_in_words(0, values));
        let sentences = infeasible.iter().map(|line| format!("{}.\n", sentence(line.trim_end_matches('.'))));
        figure = figure.remark(&sentences.collect::<String>());
        type Points = Vec<(f64, f64)>;
        let mut lines: Vec<(&[Choice], Points)> = Vec::new();
        // Words are drawn as categories.
        let mut words_of_x: Vec<String> = Vec::new();
        for point in &self.points {
            let key = &point.values[1..];
            let x = point.values[0].number().map(|x| self.shown[0].of(x)).unwrap_or_else(|| {
                let word = point.values[0].text();
                words_of_x.iter().position(|known| *known == word).unwrap_or_else(|| {
                    words_of_x.push(word);
                    words_of_x.len() - 1
                }) as f64
            });
            let place = (x, point.objective.map_or(f64::NAN, |value| objective.of(value)));
            match lines.iter_mut().find(|(k, _)| *k == key) {
                Some((_, line)) => line.push(place),
                None => lines.push((key, vec![place])),
            }
        }
        check_lines(lines.len())?;
        for (key, line) in lines {
            let label = self.place_in_words(1, key);
            figure = match words_of_x.is_empty() {
                true => figure.line(&label, line),
                false => figure.points(&label, line),
            };
        }
        if !words_of_x.is_empty() {
            let names: Vec<String> = words_of_x.iter().map(|word| item(&self.varied[0], word)).collect();
            figure = figure.categories(&names.iter().map(String::as_str).collect::<Vec<_>>());
        }
        Ok(figure)
    }
}

/// Lines that are distinguishable.
const MAX_LINES: usize = 8;

/// Whether a sweep over these variables can be drawn, before it runs.
///
/// # Errors
/// More lines than are distinguishable.
pub fn check_figure(vary: &[Vary]) -> Result<(), StudyError> {
    check_lines(vary.iter().skip(1).map(|v| v.values.len()).fold(1, usize::saturating_mul))
}

fn check_lines(lines: usize) -> Result<(), StudyError> {
    if lines <= MAX_LINES {
        return Ok(());
    }
    Err(StudyError::new(format!(
        "--plot draws a line for each combination of the values behind the first --vary: {lines}, at most {MAX_LINES} are possible; \
         name the variable with the most values first, or use --output"
    )))
}
