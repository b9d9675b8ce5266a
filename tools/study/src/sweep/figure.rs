//! A sweep as CSV and as a figure.

use super::infeasible::{item, named};
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

    /// The figure: each objective over the first variable, a line for each combination of the others.
    ///
    /// # Errors
    /// As [`check_figure`].
    pub fn figure(&self) -> Result<Figure, StudyError> {
        let axis = |what: &str, of: &Shown| Axis::new(&format!("{what}{}", unit(&of.unit(" in "))));
        let source = self.source.as_ref().map_or(String::new(), |source| format!(". {source}"));
        let objectives = self.objectives.iter().map(|o| words(&o.name)).collect::<Vec<_>>().join(" and ");
        let varied = self.varied.iter().map(|name| named(name)).collect::<Vec<_>>().join(" and ");
        let first = &self.varied[0];
        let what = match self.meanings[0] {
            // A symbol is explained.
            Some(meaning) if named(first) == *first && first.contains('.') => format!("{meaning} ({first})"),
            _ => named(first),
        };
        let x = axis(&what, &self.shown[0]);
        let mut figure =
            Figure::stacked(&format!("{objectives} over {varied}{source}"), x).remark(&self.remark());
        type Points = Vec<(f64, f64)>;
        // Words are drawn as categories.
        let mut words_of_x: Vec<String> = Vec::new();
        for (k, target) in self.objectives.iter().enumerate() {
            let shown = target.shown();
            let mut lines: Vec<(&[Choice], Points)> = Vec::new();
            for point in &self.points {
                let key = &point.values[1..];
                let x = point.values[0].number().map(|x| self.shown[0].of(x)).unwrap_or_else(|| {
                    let word = point.values[0].text();
                    words_of_x.iter().position(|known| *known == word).unwrap_or_else(|| {
                        words_of_x.push(word);
                        words_of_x.len() - 1
                    }) as f64
                });
                let place = (x, point.objectives.get(k).map_or(f64::NAN, |value| shown.of(*value)));
                match lines.iter_mut().find(|(known, _)| *known == key) {
                    Some((_, line)) => line.push(place),
                    None => lines.push((key, vec![place])),
                }
            }
            check_lines(lines.len())?;
            figure = figure.panel(axis(&words(&target.name), &shown));
            for (key, line) in lines {
                let label = self.place_in_words(1, key);
                figure = match words_of_x.is_empty() {
                    true => figure.line(&label, line),
                    false => figure.points(&label, line),
                };
            }
        }
        if !words_of_x.is_empty() {
            let names: Vec<String> = words_of_x.iter().map(|word| item(first, word)).collect();
            figure = figure.categories(&names.iter().map(String::as_str).collect::<Vec<_>>());
        }
        Ok(figure)
    }

    /// Sentences below the figure: infeasible points, and values at the end of the simulated time.
    fn remark(&self) -> String {
        let infeasible = self.infeasible_points(LISTED, |values| self.place_in_words(0, values));
        let mut sentences: Vec<String> =
            infeasible.iter().map(|line| format!("{}.", sentence(line.trim_end_matches('.')))).collect();
        for (k, target) in self.objectives.iter().enumerate() {
            let Some(most) = target.most else { continue };
            if self.points.iter().any(|point| point.objectives.get(k) == Some(&most)) {
                let value = Choice::Number(most).in_words(&target.shown());
                sentences.push(format!(
                    "{value} is the end of the simulated time: {} is later.",
                    words(&target.name)
                ));
            }
        }
        sentences.join("\n")
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
