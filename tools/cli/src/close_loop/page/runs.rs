//! Sections on the runs: residuals over time and over the drivers.

use super::models_table;
use super::over_time;
use super::parts::{Data, Part};
use calibrate::experiment::Role;
use calibrate::outcome::Outcome;
use calibrate::report::ROLES;
use maud::{Markup, html};
use present::page::{Cell, plates};
use present::typeset;

/// Every run with its outputs and residuals.
pub fn residuals(data: Data, outcome: &Outcome) -> Markup {
    let parts = Part::all(data, &outcome.curves);
    let has_lines = parts.iter().any(|part| part.curves.outputs.iter().any(|c| part.is_line(c)));
    let has_few = parts.iter().any(|part| part.curves.outputs.iter().any(|c| part.is_sparse(c)));
    let is_late = parts.iter().any(|part| part.start() != 0.0);
    html! {
        h2 { "Residuals" }
        p {
            "Measured minus predicted, in the rows that count. Where a model is complete, its residual is noise about zero"
            @if has_lines {
                ", 95 % of it in the band. The second figure of each output omits the preset."
            } @else { "." }
            @if has_few { " Outputs with few readings are a table; the model is drawn from row to row." }
            @if is_late { " Times are since the start of a run; its heading has the clock of the file." }
            " residuals.csv has the values of the figures."
        }
        // The test runs first and open; the others can be opened.
        @for role in ROLES.into_iter().rev() {
            @for part in parts.iter().filter(|part| part.curves.role == role) {
                details open=[(role == Role::Test).then_some("")] {
                    summary { (typeset(&part.heading())) }
                    (plates(&[over_time::compared(part, data, outcome)]))
                    (readings(part, outcome))
                    (plates(&over_time::residuals(part, outcome)))
                }
            }
        }
    }
}

/// The outputs of a run that have a few readings, which would be dots in empty figures.
fn readings(part: &Part, outcome: &Outcome) -> Markup {
    let curves = part.curves;
    let sparse = curves.outputs.iter().filter(|c| !part.is_line(c));
    let rows: Vec<Vec<Cell>> = sparse
        .flat_map(|c| {
            let error = outcome.errors.iter().find(|e| e.role == curves.role && e.column == c.column);
            let of = move |k: usize| {
                let residuals = [&c.before, &c.refit, &c.after].map(|model| c.measured[k] - model[k]);
                // The clock of the file, in which the row is found.
                let mut cells = vec![
                    super::figures::with_unit(c.column).into(),
                    Cell::Number(curves.time[k].to_string()),
                ];
                cells.extend([c.measured[k]].into_iter().chain(residuals).map(Cell::number));
                cells.push(Cell::maybe(error.map(|e| e.floor)));
                cells
            };
            (0..c.measured.len())
                .filter(|k| c.measured[*k].is_finite() && part.counts(curves.time[*k]))
                .map(of)
        })
        .collect();
    let time = if part.start() == 0.0 { "time in s" } else { "clock in s" };
    let headers =
        ["output", time, "measured", "residual, before", "residual, refit", "residual, after", "noise"];
    html! { @if !rows.is_empty() { (models_table(outcome, &headers, rows)) } }
}

/// The residual over each driver.
pub fn over_drivers(data: Data, outcome: &Outcome) -> Markup {
    let all = over_time::over_drivers(data, outcome);
    html! {
        @if !all.is_empty() {
            h2 { "Residual over the drivers" }
            p {
                "The output whose error after the fit of the parameters is furthest above its noise. Where points of the residual follow one \
                 curve over a driver, an effect follows this driver."
                @if !outcome.effects.is_empty() { " The law that was found has to lie on them." }
            }
            (plates(&all))
        }
    }
}
