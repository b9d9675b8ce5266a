//! `report.html`: what closing the loop has found, for a person. One file, for light and dark, without a script.

pub(super) mod figures;
mod measurement;
mod words;

use super::text::{
    attached, driver, law, list, number, own_headers, plain, port, replay as replay_words, verdict,
};
use calibrate::experiment::{Experiment, Role};
use calibrate::intake::Unusable;
use calibrate::outcome::{Curves, Evidence, Follows, Found, Outcome, Unexplained, Verdict};
use calibrate::report::{Provenance, ROLES, Replay, column_words, role_words};
use describe::Declaration;
use maud::{Markup, html};
use present::page::{Cell, page as page_of, plates, table};
use words::Words;

/// The page; `notes` are those of the outcome and of the export.
pub fn page(
    experiment: &Experiment,
    outcome: &Outcome,
    replay: &Replay,
    notes: &[String],
    declaration: &Declaration,
    provenance: &Provenance,
) -> String {
    let words = Words { experiment, declaration };
    let body = html! {
        p.lead { (capital(&verdict(outcome))) }
        p { (status(outcome, replay)) }
        (about(experiment, outcome))
        (made(provenance))
        (errors(outcome))
        (effects(outcome, words))
        @if let Some(found) = &outcome.unexplained { (unexplained(found, experiment, outcome)) }
        (next(experiment, outcome))
        (limits(outcome))
        (residuals(experiment, outcome))
        (over_drivers(experiment, outcome))
        @if !outcome.localised.is_empty() {
            h2 { "Location of the residual" }
            p {
                "An unconstrained input at each port of the model, estimated jointly with the parameters: the fraction of the \
                 residual beyond noise that it explains after the fit."
            }
            (plates(&[figures::localised(outcome)]))
        }
        (candidates(outcome, words))
        (parameters(outcome, words))
        (measurement::noises(experiment, outcome))
        (whiteness(outcome))
        (exported(outcome, replay))
        @if !notes.is_empty() { h2 { "Notes" } ul { @for note in notes { li { (words.sentence(note)) } } } }
    };
    page_of(&title(&outcome.name), body)
}

/// Its title.
pub fn title(experiment: &str) -> String {
    format!("{experiment}: calibration report")
}

/// The page on data of which nothing can be said.
pub fn unusable(
    experiment: &Experiment,
    why: &Unusable,
    declaration: &Declaration,
    provenance: &Provenance,
) -> String {
    let words = Words { experiment, declaration };
    let body = html! {
        p.lead { "Unusable data: " (words.sentence(&why.reason)) "." }
        p { "Channel: " code { (why.channel) } ". Suggestion: " (words.sentence(&why.suggestion)) ". Nothing was fitted and no effect was looked for." }
        @if let Some(headers) = own_headers(experiment, &[&why.reason]) { p { (capital(&words.text(&headers))) "." } }
        (made(provenance))
        @if !experiment.notes.is_empty() { h2 { "Notes" } ul { @for note in &experiment.notes { li { (words.sentence(note)) } } } }
    };
    page_of(&title(&experiment.name), body)
}

pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// A column of the data in words, with its unit.
fn channel(column: &str) -> String {
    let (name, unit) = column_words(column);
    if unit.is_empty() { name } else { format!("{name} in {unit}") }
}

/// The model, the preset and the data.
fn about(experiment: &Experiment, outcome: &Outcome) -> Markup {
    let of_role = |role: Role| {
        let mut files: Vec<String> = Vec::new();
        for run in experiment.runs.iter().filter(|r| r.role == role) {
            if !files.contains(&run.file) {
                files.push(run.file.clone());
            }
        }
        (!files.is_empty()).then(|| format!("{} on {}", role_words(role), list(&files, "and")))
    };
    let runs: Vec<String> = ROLES.into_iter().filter_map(of_role).collect();
    html! {
        p.soft {
            "Model " (outcome.model) ", preset " (experiment.preset) ". Runs: " (list(&runs, "and")) ". The search took "
            (number(outcome.seconds)) " s."
        }
    }
}

/// Program, data and date.
fn made(provenance: &Provenance) -> Markup {
    html! {
        p.soft {
            (provenance.program) ", " (provenance.date) ". SHA-256 of the experiment and its runs: " code { @for (k, digit) in provenance.data_sha256.chars().enumerate() { @if k > 0 && k % 16 == 0 { wbr; } (digit) } } "."
        }
    }
}

fn next(experiment: &Experiment, outcome: &Outcome) -> Markup {
    let sentences = measurement::next(experiment, outcome);
    html! {
        @if !sentences.is_empty() { h2 { "Next experiment" } ul { @for text in &sentences { li { (text) } } } }
    }
}

fn over_drivers(experiment: &Experiment, outcome: &Outcome) -> Markup {
    let all = figures::over_drivers(experiment, outcome);
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

/// What the verdict is worth, in one sentence: errors over noise of the runs that were not fitted, and the replay.
fn status(outcome: &Outcome, replay: &Replay) -> String {
    let test: Vec<String> = outcome
        .errors
        .iter()
        .filter(|e| e.role == Role::Test && e.after.is_finite())
        .map(|e| {
            let (name, unit) = column_words(e.column);
            format!(
                "{name} {} {unit} (before {}, noise {})",
                number(e.after),
                number(e.before),
                number(e.floor)
            )
        })
        .collect();
    let errors = if test.is_empty() {
        "no test run".to_owned()
    } else {
        format!("test errors: {}", list(&test, "and"))
    };
    let agrees = if replay.agrees {
        "the exported FMUs reproduce them"
    } else {
        "the exported FMUs do not reproduce them"
    };
    format!("Status: {errors}; {agrees}.")
}

fn errors(outcome: &Outcome) -> Markup {
    let row = |e: &calibrate::outcome::ChannelError| {
        let mut cells: Vec<Cell> = vec![channel(e.column).into(), role_words(e.role).into()];
        cells.extend([e.before, e.refit, e.after, e.floor, e.after / e.floor].map(Cell::number));
        cells.push(Cell::maybe(e.blackbox));
        cells
    };
    let headers = ["output", "runs", "before", "refit", "after", "noise", "after / noise", "black box"];
    let boxes: Vec<String> =
        outcome.boxes.iter().map(|b| format!("{}: {}", column_words(b.column).0, b.kind)).collect();
    html! {
        h2 { "Errors (RMSE)" }
        p {
            @match outcome.effects.is_empty() {
                true => "Before: the preset. Fitted: parameters fitted, no effect added.",
                false => "Before: the preset. Refit: parameters fitted, model unchanged. After: the extended model.",
            }
            " Noise: the error of a perfect model."
            @if !boxes.is_empty() {
                " Black box: a model without physics, fitted to the same runs and simulated from the same inputs (" (list(&boxes, "and")) ")."
            }
        }
        (models_table(outcome, &headers, outcome.errors.iter().map(row).collect()))
    }
}

/// What there is of the models of the errors. Without an added effect, refit and after are one model, the fitted one.
fn models<'a, T, const N: usize>(outcome: &Outcome, all: [(&'a str, T); N]) -> Vec<(&'a str, T)> {
    let is_fitted = outcome.effects.is_empty();
    let kept = all.into_iter().filter(|(name, _)| !(is_fitted && *name == "refit"));
    kept.map(|(name, of)| (if is_fitted && name == "after" { "fitted" } else { name }, of)).collect()
}

/// A table with columns of these models.
fn models_table(outcome: &Outcome, headers: &[&str], rows: Vec<Vec<Cell>>) -> Markup {
    if !outcome.effects.is_empty() {
        return table(headers, rows);
    }
    let is_kept = |k: usize| !headers[k].ends_with("refit");
    let kept = headers.iter().filter(|header| !header.ends_with("refit"));
    let names: Vec<String> = kept.map(|header| header.replace("after", "fitted")).collect();
    let cells = |row: Vec<Cell>| {
        row.into_iter().enumerate().filter(|(k, _)| is_kept(*k)).map(|(_, cell)| cell).collect()
    };
    table(&names.iter().map(String::as_str).collect::<Vec<_>>(), rows.into_iter().map(cells).collect())
}

fn effects(outcome: &Outcome, words: Words) -> Markup {
    html! {
        @if !outcome.effects.is_empty() { h2 { "Identified effects" } }
        @for effect in &outcome.effects {
            h3 { (heading(effect)) }
            p {
                "It acts on " (port(effect.port)) " and " (driver(effect.follows)) "."
                @if !effect.magnitude.is_empty() { " It " (effect.magnitude) "." }
                @if !effect.everywhere { " It acts in " (list(&effect.runs, "and")) " only." }
            }
            (sizes(effect, words))
            @if let Some(term) = &effect.term { p { "Law: " (law(term)) "." } }
            p { (support(effect)) }
            @if !effect.alternatives.is_empty() {
                @let names: Vec<String> = effect.alternatives.iter().map(|a| plain(a)).collect();
                @let weights: Vec<String> = effect.class().map(|(id, weight)| format!("{} {weight:.2}", plain(id))).collect();
                p { "The data are explained equally well by " (list(&names, "or by")) ". Posterior weights: " (list(&weights, "and")) "." }
            }
            @if let Some(run) = &effect.separating_experiment { p { "Experiment that distinguishes them: " (run) "." } }
        }
    }
}

fn heading(effect: &Found) -> String {
    if effect.term.is_none() {
        return capital(&plain(&effect.id));
    }
    if let Follows::Mass(driver) = effect.follows {
        return format!("Unlisted effect: {}", attached(driver));
    }
    let over = effect.follows.name().map_or(String::new(), |name| format!(" over {}", plain(&name)));
    format!("Unlisted effect: {}{over}", plain(effect.port.name()))
}

/// An interval; one that is not known is said to be so.
fn interval(ci95: (f64, f64)) -> Cell {
    if ci95.0.is_finite() && ci95.1.is_finite() {
        Cell::Number(format!("{} ... {}", number(ci95.0), number(ci95.1)))
    } else {
        Cell::Number("unknown".to_owned())
    }
}

/// The parameters of an effect with their meaning.
fn sizes(effect: &Found, words: Words) -> Markup {
    let row = |p: &calibrate::outcome::Estimate| {
        vec![
            Cell::Code(p.name.clone()),
            words.meaning(&format!("effect.{}.{}", effect.id, p.name)).into(),
            Cell::number(p.value),
            interval(p.ci95),
            Cell::Unit(p.unit),
        ]
    };
    let headers = ["symbol", "meaning", "value", "95 % interval", "unit"];
    html! {
        @if !effect.parameters.is_empty() { (table(&headers, effect.parameters.iter().map(row).collect())) }
    }
}

fn support(effect: &Found) -> String {
    let validation = effect.validation_ratio.map_or(String::new(), |ratio| {
        format!(" The validation error with it is {} of the error without it.", number(ratio))
    });
    format!(
        "It lowers BIC by {}, and by {} when allowing for autocorrelated noise; above 10 is strong.{validation}",
        number(effect.delta_bic),
        number(effect.delta_bic_whitened)
    )
}

fn unexplained(found: &Unexplained, experiment: &Experiment, outcome: &Outcome) -> Markup {
    let given = if found.added {
        "The law above was added to the model, since it lowers the validation error. The figure is the estimate from the data \
         without a law."
    } else if outcome.effects.iter().any(|e| e.term.is_some()) {
        "The law above was added to the model, since it lowers the validation error; it explains a part of this effect."
    } else {
        "It was not added to the model, since it does not lower the validation error."
    };
    html! {
        h2 { "Unexplained effect" }
        p { "An effect acts on " (port(found.port)) " and " (driver(found.follows)) ". " (given)
            @if let Some(power) = measurement::power(found, experiment) { " " (power) }
        }
        @if !found.shape.is_empty() { (plates(&[figures::shape(found, outcome)])) }
    }
}

fn limits(outcome: &Outcome) -> Markup {
    let row = |l: &calibrate::outcome::Limit| {
        vec![plain(&l.id).into(), Cell::Code(l.symbol.to_owned()), Cell::number(l.size), Cell::Unit(l.unit)]
    };
    let what = match outcome.verdict {
        Verdict::Nothing => "No effect was found. An effect of at least this size would have been detected:",
        _ => "A further effect of at least this size would have been detected:",
    };
    html! {
        @if !outcome.limits.is_empty() {
            h2 { "Detection limits" }
            p { (what) }
            (table(&["effect", "symbol", "size", "unit"], outcome.limits.iter().map(row).collect()))
        }
    }
}

fn residuals(experiment: &Experiment, outcome: &Outcome) -> Markup {
    // The test runs first and open; the others can be opened.
    let heading = |c: &Curves| format!("{} ({})", c.file, role_words(c.role));
    html! {
        h2 { "Residuals" }
        p {
            "Measured minus predicted. Where a model is complete, its residual is noise about zero, 95 % of it in the band. The second \
             figure of each output omits the preset. residuals.csv has the values of the figures."
        }
        @for role in ROLES.into_iter().rev() {
            @for curves in outcome.curves.iter().filter(|c| c.role == role) {
                details open=[(role == Role::Test).then_some("")] {
                    summary { (heading(curves)) }
                    (plates(&[figures::compared(curves, experiment, outcome)]))
                    (readings(curves, outcome))
                    (plates(&figures::residuals(curves, outcome)))
                }
            }
        }
    }
}

/// The outputs of a run that have a few readings, which would be dots in empty figures.
fn readings(curves: &Curves, outcome: &Outcome) -> Markup {
    let sparse = curves.outputs.iter().filter(|c| figures::is_sparse(c));
    let rows: Vec<Vec<Cell>> = sparse
        .flat_map(|c| {
            let error = outcome.errors.iter().find(|e| e.role == curves.role && e.column == c.column);
            let of = move |k: usize| {
                let residuals = [&c.before, &c.refit, &c.after].map(|model| c.measured[k] - model[k]);
                let numbers = [curves.time[k], c.measured[k]].into_iter().chain(residuals);
                let mut cells = vec![figures::with_unit(c.column).into()];
                cells.extend(numbers.map(Cell::number));
                cells.push(Cell::maybe(error.map(|e| e.floor)));
                cells
            };
            (0..c.measured.len()).filter(|k| c.measured[*k].is_finite()).map(of)
        })
        .collect();
    let headers = [
        "output",
        "time in s",
        "measured",
        "residual, before",
        "residual, refit",
        "residual, after",
        "noise",
    ];
    html! { @if !rows.is_empty() { (models_table(outcome, &headers, rows)) } }
}

fn candidates(outcome: &Outcome, words: Words) -> Markup {
    let mut ranked: Vec<&Evidence> = outcome.candidate_table.iter().collect();
    ranked.sort_by(|a, b| a.round.cmp(&b.round).then(b.delta_bic_whitened.total_cmp(&a.delta_bic_whitened)));
    let row = |e: &Evidence| {
        vec![
            words.text(&e.name).into(),
            Cell::Number(e.round.to_string()),
            plain(e.port.name()).into(),
            Cell::number(e.delta_bic),
            Cell::number(e.delta_bic_whitened),
            Cell::maybe(e.delta_validation),
            Cell::number(e.probability),
            Cell::maybe(e.validation_ratio),
            if e.accepted { "accepted" } else { "rejected" }.into(),
            words.text(&e.reason).into(),
        ]
    };
    let headers = [
        "candidate",
        "round",
        "port",
        "decrease of BIC",
        "the same, autocorrelated noise",
        "of which validation runs",
        "probability",
        "validation error ratio",
        "verdict",
        "reason",
    ];
    html! {
        @if !outcome.candidate_table.is_empty() {
            h2 { "Candidates" }
            p {
                "By rank in each round. BIC is that of the fit and validation runs. Probability: of this candidate among those of its round \
                 and the model without any of them, from BIC with autocorrelated noise."
            }
            (table(&headers, ranked.into_iter().map(row).collect()))
        }
    }
}

fn parameters(outcome: &Outcome, words: Words) -> Markup {
    let row = |p: &calibrate::outcome::Estimate| {
        let refit = outcome.refit.iter().find(|r| r.name == p.name).map(|r| r.value);
        vec![
            words.meaning(&p.name).into(),
            Cell::Code(p.name.clone()),
            Cell::number(p.prior),
            Cell::maybe(refit),
            Cell::number(p.value),
            interval(p.ci95),
            Cell::Unit(p.unit),
        ]
    };
    let own = |(file, p): &(String, calibrate::outcome::Estimate)| {
        let cells = [words.meaning(&p.name).into(), Cell::Code(p.name.clone()), file.as_str().into()];
        cells
            .into_iter()
            .chain([Cell::number(p.prior), Cell::number(p.value), interval(p.ci95), Cell::Unit(p.unit)])
            .collect()
    };
    let headers = ["parameter", "name", "preset", "refit", "after", "95 % interval", "unit"];
    let of_run = ["parameter", "name", "run", "prior", "value", "95 % interval", "unit"];
    let pairs: Vec<String> =
        outcome.correlated.iter().map(|(a, b, r)| format!("{a} with {b} ({})", number(*r))).collect();
    html! {
        @if !outcome.parameters.is_empty() {
            h2 { "Parameters" }
            (models_table(outcome, &headers, outcome.parameters.iter().map(row).collect()))
            @if !outcome.of_runs.is_empty() {
                h3 { "Unknowns of single runs" }
                (table(&of_run, outcome.of_runs.iter().map(own).collect()))
            }
            @if !pairs.is_empty() { p { "Strongly correlated estimates, with their correlation: " (words.sentence(&list(&pairs, "and"))) "." } }
            (plates(&[figures::forest(words, outcome)]))
        }
    }
}

fn whiteness(outcome: &Outcome) -> Markup {
    let row = |w: &calibrate::outcome::Whiteness| {
        let mut cells: Vec<Cell> = vec![channel(w.column).into()];
        let values = [w.blocks_refit, w.blocks_after, w.autocorrelation.0, w.autocorrelation.1];
        cells.extend(values.map(Cell::number));
        cells
    };
    let headers =
        ["output", "block means, refit", "block means, after", "correlation, refit", "correlation, after"];
    html! {
        @if !outcome.whiteness.is_empty() {
            h2 { "Whiteness of the residuals" }
            p {
                "Block means: their mean square relative to that of noise alone; 1 for white noise. Correlation of neighbouring rows: \
                 0 for white noise."
            }
            (models_table(outcome, &headers, outcome.whiteness.iter().map(row).collect()))
        }
    }
}

fn exported(outcome: &Outcome, replay: &Replay) -> Markup {
    let row = |c: &calibrate::report::ReplayedChannel| {
        let mut cells: Vec<Cell> = vec![channel(c.column).into(), c.standard.into()];
        cells.extend([c.rmse, c.after, c.difference, c.difference_of_a_value].map(Cell::number));
        cells
    };
    let headers = [
        "output",
        "archive",
        "RMSE of the FMU",
        "RMSE of the model",
        "difference / range",
        "greatest difference / range",
    ];
    html! {
        h2 { "Exported FMUs" }
        p {
            "fmi2/" (outcome.model) ".fmu and fmi3/" (outcome.model) ".fmu start at the calibrated values of preset.toml, as in "
            (outcome.export.file) ". " (capital(&replay_words(replay))) "."
        }
        (table(&headers, replay.channels.iter().map(row).collect()))
    }
}
