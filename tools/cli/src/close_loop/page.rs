//! `report.html`: what closing the loop has found, for a person. One file, for light and dark, without a script.

mod effects;
pub(super) mod figures;
mod measurement;
pub(super) mod numbers;
mod over_time;
mod parts;
mod runs;
mod words;

use super::text::{list, number, own_headers, plain, port, replay as replay_words, verdict};
use calibrate::experiment::{Experiment, Role};
use calibrate::intake::{Illustration, Unusable};
use calibrate::outcome::{Evidence, Outcome, Verdict};
use calibrate::report::{Provenance, ROLES, Replay, column_words, role_words};
use describe::Declaration;
use maud::{Markup, html};
use numbers::{estimate, interval, rough};
pub use parts::Data;
use present::page::{Cell, page as page_of, plates, table};
use present::typeset;
use words::Words;

/// The page; `notes` are those of the outcome and of the export.
pub fn page(
    data: Data,
    outcome: &Outcome,
    replay: &Replay,
    notes: &[String],
    declaration: &Declaration,
    provenance: &Provenance,
) -> String {
    let experiment = data.used;
    let words = Words { experiment, declaration };
    let body = html! {
        p.lead { (typeset(&capital(&verdict(outcome)))) }
        p { (typeset(&status(outcome, replay))) }
        (about(experiment, outcome))
        (made(provenance))
        (errors(outcome))
        (effects::effects(outcome, words))
        @if let Some(found) = &outcome.unexplained { (effects::unexplained(found, experiment, outcome)) }
        (next(experiment, outcome))
        (limits(outcome, words))
        (runs::residuals(data, outcome))
        (runs::over_drivers(data, outcome))
        @if !outcome.localised.is_empty() {
            h2 { "Location of the residual" }
            p {
                "An unconstrained input at each port of the model, estimated jointly with the parameters: the fraction of the \
                 residual beyond noise that it explains after the fit."
            }
            (figures::localised(outcome))
        }
        (candidates(outcome, words))
        (parameters(outcome, words))
        (measurement::noises(experiment, outcome))
        (whiteness(outcome))
        (exported(outcome, replay))
        @if !notes.is_empty() { h2 { "Notes" } ul { @for note in notes { li { (words.note(note)) } } } }
    };
    page_of(&title(&outcome.name), body)
}

/// Its title.
pub fn title(experiment: &str) -> String {
    format!("{experiment}: calibration report")
}

/// The page on data of which nothing can be said; `found` are the readings that contradict the model, if they can be drawn.
pub fn unusable(
    experiment: &Experiment,
    (why, found): (&Unusable, Option<&Illustration>),
    declaration: &Declaration,
    provenance: &Provenance,
) -> String {
    let words = Words { experiment, declaration };
    let body = html! {
        p.lead { "Unusable data: " (words.sentence(&why.reason)) "." }
        p { "Channel: " (words.text(&why.channel)) " (" code { (why.channel) } "). Suggestion: " (words.sentence(&why.suggestion)) ". Nothing was fitted and no effect was looked for." }
        @if let Some(headers) = own_headers(experiment, &[&why.reason]) { p { (capital(&words.text(&headers))) "." } }
        @if let Some(found) = found { (plates(&[figures::contradiction(found)])) }
        (made(provenance))
        @if !experiment.notes.is_empty() { h2 { "Notes" } ul { @for note in &experiment.notes { li { (words.note(note)) } } } }
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
            (typeset(&numbers::seconds(outcome.seconds))) "."
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
        @if !sentences.is_empty() { h2 { "Next experiment" } ul { @for text in &sentences { li { (typeset(text)) } } } }
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
            let with_unit = |number: String| format!("{number} {unit}").trim_end().to_owned();
            let [after, before, noise] = [number(e.after), number(e.before), rough(e.floor)].map(with_unit);
            format!("{name} {after} (before {before}, noise {noise})")
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
                " Black box: a model without physics, fitted to the same runs and simulated from the same inputs (" (typeset(&list(&boxes, "and"))) ")."
            }
        }
        (models_table(outcome, &headers, outcome.errors.iter().map(row).collect()))
    }
}

/// What there is of the models, by name. Without an added effect, refit and after are one model, the fitted one.
fn models<'a, T>(outcome: &Outcome, all: impl IntoIterator<Item = (&'a str, T)>) -> Vec<(String, T)> {
    let all = all.into_iter();
    if !outcome.effects.is_empty() {
        return all.map(|(name, of)| (name.to_owned(), of)).collect();
    }
    let kept = all.filter(|(name, _)| !name.ends_with("refit"));
    kept.map(|(name, of)| (name.replace("after", "fitted"), of)).collect()
}

/// A table with columns of these models.
fn models_table(outcome: &Outcome, headers: &[&str], rows: Vec<Vec<Cell>>) -> Markup {
    let names = models(outcome, headers.iter().map(|header| (*header, ())));
    let names: Vec<&str> = names.iter().map(|(name, ())| name.as_str()).collect();
    let cells = |row| models(outcome, headers.iter().copied().zip(row)).into_iter().map(|(_, cell)| cell);
    table(&names, rows.into_iter().map(|row: Vec<Cell>| cells(row).collect()).collect())
}

fn limits(outcome: &Outcome, words: Words) -> Markup {
    let row = |l: &calibrate::outcome::Limit| {
        vec![
            plain(&l.id).into(),
            Cell::Code(l.symbol.to_owned()),
            words.meaning(&format!("effect.{}.{}", l.id, l.symbol)).into(),
            Cell::Number(rough(l.size)),
            Cell::Unit(l.unit),
        ]
    };
    let what = match outcome.verdict {
        Verdict::Nothing => "No effect was found. An effect of at least this size would have been detected:",
        _ => "A further effect of at least this size would have been detected:",
    };
    html! {
        @if !outcome.limits.is_empty() {
            h2 { "Detection limits" }
            p { (what) }
            (table(&["effect", "symbol", "meaning", "size", "unit"], outcome.limits.iter().map(row).collect()))
        }
    }
}

/// A candidate or a sentence with one, in words: `drag torque ~ lag of speed^1` is drag torque ∝ lagged speed.
fn law_name(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let mut named: Vec<String> = Vec::new();
    for (k, word) in words.iter().enumerate() {
        let follows = words[..k].contains(&"~");
        match *word {
            "~" => named.push("∝".to_owned()),
            "lag" if follows && words.get(k + 1) == Some(&"of") => named.push("lagged".to_owned()),
            "of" if follows && words[k - 1] == "lag" => {}
            word => named.push(word.strip_suffix("^1").unwrap_or(word).to_owned()),
        }
    }
    named.join(" ")
}

fn candidates(outcome: &Outcome, words: Words) -> Markup {
    let mut ranked: Vec<&Evidence> = outcome.candidate_table.iter().collect();
    ranked.sort_by(|a, b| a.round.cmp(&b.round).then(b.delta_bic_whitened.total_cmp(&a.delta_bic_whitened)));
    let row = |e: &Evidence| {
        vec![
            law_name(&words.text(&e.name)).into(),
            Cell::Number(e.round.to_string()),
            plain(e.port.name()).into(),
            Cell::Number(numbers::evidence(e.delta_bic)),
            Cell::Number(numbers::evidence(e.delta_bic_whitened)),
            Cell::Number(e.delta_validation.map_or(String::new(), numbers::evidence)),
            Cell::Number(numbers::probability(e.probability)),
            Cell::maybe(e.validation_ratio),
            if e.accepted { "accepted" } else { "rejected" }.into(),
            law_name(&words.text(&e.reason)).into(),
        ]
    };
    let headers = [
        "candidate",
        "round",
        "port",
        "decrease of BIC",
        "decrease of BIC, autocorrelated noise",
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
            Cell::Number(estimate(p.value, p.ci95)),
            Cell::Number(interval(p.ci95)),
            Cell::Unit(p.unit),
        ]
    };
    let own = |(file, p): &(String, calibrate::outcome::Estimate)| {
        let cells = [words.meaning(&p.name).into(), Cell::Code(p.name.clone()), file.as_str().into()];
        cells
            .into_iter()
            .chain([
                Cell::number(p.prior),
                Cell::Number(estimate(p.value, p.ci95)),
                Cell::Number(interval(p.ci95)),
                Cell::Unit(p.unit),
            ])
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
    // Columns of zeros say less than the sentence that there is no difference.
    let differs = replay.channels.iter().any(|c| c.difference != 0.0 || c.difference_of_a_value != 0.0);
    let row = |c: &calibrate::report::ReplayedChannel| {
        let mut cells: Vec<Cell> = vec![channel(c.column).into(), c.standard.into()];
        cells.extend([c.rmse, c.after].map(Cell::number));
        if differs {
            cells.extend([c.difference, c.difference_of_a_value].map(|x| Cell::Number(rough(x))));
        }
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
            (outcome.export.file) ". " (typeset(&capital(&replay_words(replay)))) "."
        }
        (table(&headers[..if differs { headers.len() } else { 4 }], replay.channels.iter().map(row).collect()))
    }
}
