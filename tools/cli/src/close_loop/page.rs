//! `report.html`: what closing the loop has come to, for a person. One file, for light and dark, without a script.

mod figures;

use super::words::{driver, law, list, number, plain, port, replay as replay_words, verdict};
use calibrate::experiment::{Experiment, Role};
use calibrate::outcome::{Curves, Found, Outcome, Unexplained, Verdict};
use calibrate::report::{ROLES, Replay, role_name};
use describe::Declaration;
use std::fmt::Write;
use study::figure::escaped;
use study::page::{Plate, begun, plates, table};

/// The page; `notes` are the outcome's with what was odd since.
pub fn page(
    experiment: &Experiment,
    outcome: &Outcome,
    replay: &Replay,
    notes: &[String],
    declaration: &Declaration,
) -> String {
    let mut html = begun(&format!("{}: the loop closed", outcome.name));
    let _ = write!(html, "<p class=\"lead\">{}</p>", escaped(&capital(&verdict(outcome))));
    html += &about(experiment, outcome);
    html += &errors(outcome);
    html += &effects(outcome, declaration);
    html += &outcome.unexplained.as_ref().map(|u| unexplained(u, outcome)).unwrap_or_default();
    html += &limits(outcome);
    html += &residuals(outcome);
    html += &localised(outcome);
    html += &ladder(outcome);
    html += &parameters(experiment, outcome);
    html += &whiteness(outcome);
    html += &loop_end(outcome, replay);
    html += &remarks(notes);
    html + "</body></html>"
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn paragraph(text: &str) -> String {
    format!("<p>{}</p>", escaped(text))
}

fn rows(id: &str, headers: &[&str], rows: Vec<Vec<String>>) -> String {
    format!("<div class=\"wide\">{}</div>", table(id, headers, rows.into_iter().map(|cells| ("", cells))))
}

/// A cell with a number.
fn cell(value: f64) -> String {
    format!("#{}", number(value))
}

/// What was asked, of which data.
fn about(experiment: &Experiment, outcome: &Outcome) -> String {
    let of_role = |role: Role| {
        let mut files: Vec<String> = Vec::new();
        for run in experiment.runs.iter().filter(|r| r.role == role) {
            if !files.contains(&run.file) {
                files.push(run.file.clone());
            }
        }
        let words = match role {
            Role::Fit => "fitted to",
            Role::Validate => "decided on",
            Role::Test => "tested, once, on",
        };
        (!files.is_empty()).then(|| format!("{words} {}", list(&files, "and")))
    };
    let runs: Vec<String> = ROLES.into_iter().filter_map(of_role).collect();
    format!(
        "<p class=\"soft\">{}</p>",
        escaped(&format!(
            "{} with the preset {}, {}. The search took {} s.",
            outcome.model,
            experiment.preset,
            list(&runs, "and"),
            number(outcome.seconds)
        ))
    )
}

fn errors(outcome: &Outcome) -> String {
    let row = |e: &calibrate::outcome::ChannelError| {
        let mut cells = vec![role_name(e.role).to_owned(), e.column.to_owned()];
        cells.extend([e.before, e.refit, e.after, e.floor].map(cell));
        cells.push(cell(e.after / e.floor));
        cells
    };
    let headers = ["runs", "error (RMSE) of", "#before", "#refit", "#after", "#noise", "#after / noise"];
    format!(
        "<h2>The error, before and after</h2>{}{}",
        paragraph(
            "Before: the untouched preset. Refit: other parameters alone, the naive answer. After: the repaired model. \
             Noise: what a perfect model would leave. In the channel's unit."
        ),
        rows("errors", &headers, outcome.errors.iter().map(row).collect())
    )
}

fn effects(outcome: &Outcome, declaration: &Declaration) -> String {
    if outcome.effects.is_empty() {
        return String::new();
    }
    let mut html = String::from("<h2>What the model lacked</h2>");
    for effect in &outcome.effects {
        let _ = write!(html, "<h3>{}</h3>", escaped(&heading(effect)));
        let acts = format!("It acts on {} and {}.", port(effect.port), driver(effect.follows));
        let size =
            if effect.magnitude.is_empty() { String::new() } else { format!(" It {}.", effect.magnitude) };
        let runs = if effect.everywhere {
            String::new()
        } else {
            format!(" It acts in {} alone.", list(&effect.runs, "and"))
        };
        html += &paragraph(&format!("{acts}{size}{runs}"));
        html += &sizes(effect, declaration);
        if let Some(law) = effect.term.as_ref().map(law) {
            html += &paragraph(&format!("Its law: {law}."));
        }
        html += &paragraph(&support(effect));
        if !effect.alternatives.is_empty() {
            let names: Vec<String> = effect.alternatives.iter().map(|a| plain(a)).collect();
            html += &paragraph(&format!("This data is explained as well by {}.", list(&names, "or by")));
        }
        if let Some(run) = &effect.separating_experiment {
            html += &paragraph(&format!("What would tell them apart: {run}."));
        }
    }
    html
}

fn heading(effect: &Found) -> String {
    if effect.term.is_none() {
        return capital(&plain(&effect.id));
    }
    let over = effect.follows.name().map_or(String::new(), |name| format!(" over {}", plain(name)));
    format!("In no list: {}{over}", plain(effect.port.name()))
}

/// An interval; one that is not known is said to be so.
fn interval(ci95: (f64, f64)) -> String {
    if ci95.0.is_finite() && ci95.1.is_finite() {
        format!("#{} ... {}", number(ci95.0), number(ci95.1))
    } else {
        "#unknown".to_owned()
    }
}

/// A unit; a pure number has none.
fn unit(name: &str) -> String {
    if name == "1" { String::new() } else { name.to_owned() }
}

/// The numbers of an effect with what they mean.
fn sizes(effect: &Found, declaration: &Declaration) -> String {
    if effect.parameters.is_empty() {
        return String::new();
    }
    let row = |p: &calibrate::outcome::Estimate| {
        let entry = declaration.by_name(&format!("effect.{}.{}", effect.id, p.name));
        // The rest of a description says what switches it off.
        let means = entry.map_or("", |e| e.row.doc.split(';').next().unwrap_or_default());
        vec![p.name.clone(), means.to_owned(), cell(p.value), interval(p.ci95), unit(p.unit)]
    };
    let headers = ["symbol", "meaning", "#value", "#95 % interval", "unit"];
    rows(&format!("effect-{}", effect.id), &headers, effect.parameters.iter().map(row).collect())
}

fn support(effect: &Found) -> String {
    let validation = effect.validation_ratio.map_or(String::new(), |ratio| {
        format!(
            " On the runs that decide and were not fitted, the error is {} of that without it.",
            number(ratio)
        )
    });
    format!(
        "BIC falls by {} with it, by {} when the noise may have a memory; above 10 is strong.{validation}",
        number(effect.delta_bic),
        number(effect.delta_bic_whitened)
    )
}

fn unexplained(found: &Unexplained, outcome: &Outcome) -> String {
    let given = if found.added {
        "The model was given the law above, since that improves what was not fitted; the figure is what the data draws \
         without a law."
    } else {
        "The model was not given it: what was not fitted does not improve by it."
    };
    let mut html = String::from("<h2>What has no name</h2>");
    html +=
        &paragraph(&format!("Something acts on {} and {}. {given}", port(found.port), driver(found.follows)));
    if !found.shape.is_empty() {
        html += &plates(&[figures::shape(found, outcome)]);
    }
    html
}

fn limits(outcome: &Outcome) -> String {
    if outcome.limits.is_empty() {
        return String::new();
    }
    let row =
        |l: &calibrate::outcome::Limit| vec![plain(&l.id), l.symbol.to_owned(), cell(l.size), unit(l.unit)];
    let what = if outcome.verdict == Verdict::Nothing {
        "Nothing was found. An effect of this size or more would have been:"
    } else {
        "Beside what was found, an effect of this size or more would have been seen:"
    };
    format!(
        "<h2>What would have been seen</h2>{}{}",
        paragraph(what),
        rows("limits", &["effect", "symbol", "#size", "unit"], outcome.limits.iter().map(row).collect())
    )
}

fn residuals(outcome: &Outcome) -> String {
    let mut html = String::from("<h2>What each model leaves</h2>");
    html += &paragraph(
        "Measured less model, over time. Where a model explains all that there is, its line is noise about zero: 95 % of it \
         in the pale band. On the right the same without the untouched preset.",
    );
    // The runs that were never fitted first; the others can be opened.
    let heading = |c: &Curves| format!("{} ({})", c.file, role_name(c.role));
    for role in ROLES.into_iter().rev() {
        for curves in outcome.curves.iter().filter(|c| c.role == role) {
            let drawn = plates(&figures::residuals(curves, outcome));
            let open = if role == Role::Test { " open" } else { "" };
            let _ = write!(
                html,
                "<details{open}><summary>{}</summary>{drawn}</details>",
                escaped(&heading(curves))
            );
        }
    }
    html
}

fn localised(outcome: &Outcome) -> String {
    if outcome.localised.is_empty() {
        return String::new();
    }
    format!(
        "<h2>Where the residual sits</h2>{}{}",
        paragraph(
            "What the refit leaves beyond noise, and the share of it that a free force at each place of the model would \
             explain."
        ),
        plates(&[figures::localised(outcome)])
    )
}

fn ladder(outcome: &Outcome) -> String {
    if outcome.ladder.is_empty() {
        return String::new();
    }
    let row = |e: &calibrate::outcome::Evidence| {
        vec![
            format!("#{}", e.round),
            plain(&e.name),
            plain(e.port.name()),
            cell(e.delta_bic),
            cell(e.delta_bic_whitened),
            e.validation_ratio.map_or("#".to_owned(), cell),
            if e.accepted { "accepted" } else { "rejected" }.to_owned(),
            e.reason.clone(),
        ]
    };
    let headers = [
        "#round",
        "candidate",
        "acts at",
        "#BIC falls by",
        "#whitened",
        "#validation error ratio",
        "verdict",
        "why",
    ];
    format!("<h2>What was tried</h2>{}", rows("ladder", &headers, outcome.ladder.iter().map(row).collect()))
}

fn parameters(experiment: &Experiment, outcome: &Outcome) -> String {
    if outcome.parameters.is_empty() {
        return String::new();
    }
    let row = |p: &calibrate::outcome::Estimate| {
        let refit = outcome.refit.iter().find(|r| r.name == p.name);
        vec![
            p.name.clone(),
            cell(p.prior),
            refit.map_or("#".to_owned(), |r| cell(r.value)),
            cell(p.value),
            interval(p.ci95),
            unit(p.unit),
        ]
    };
    let headers = ["parameter", "#preset", "#refit", "#repaired", "#95 % interval", "unit"];
    let pairs: Vec<String> =
        outcome.correlated.iter().map(|(a, b, r)| format!("{a} with {b} ({})", number(*r))).collect();
    let pairs = if pairs.is_empty() {
        String::new()
    } else {
        paragraph(&format!("This data hardly separates, with their correlation: {}.", list(&pairs, "and")))
    };
    format!(
        "<h2>Parameters</h2>{}{}{pairs}",
        plates(&[figures::forest(experiment, outcome)]),
        rows("parameters", &headers, outcome.parameters.iter().map(row).collect())
    )
}

fn whiteness(outcome: &Outcome) -> String {
    if outcome.whiteness.is_empty() {
        return String::new();
    }
    let row = |w: &calibrate::outcome::Whiteness| {
        vec![
            w.column.to_owned(),
            cell(w.blocks_refit),
            cell(w.blocks_after),
            cell(w.autocorrelation.0),
            cell(w.autocorrelation.1),
        ]
    };
    let headers = [
        "output",
        "#block means, refit",
        "#block means, after",
        "#correlation, refit",
        "#correlation, after",
    ];
    format!(
        "<h2>Whether what is left is noise</h2>{}{}",
        paragraph(
            "Mean square of block means over what noise alone gives: 1 for noise. Correlation of neighbouring rows: 0 for \
             noise."
        ),
        rows("whiteness", &headers, outcome.whiteness.iter().map(row).collect())
    )
}

fn loop_end(outcome: &Outcome, replay: &Replay) -> String {
    let row = |c: &calibrate::report::ReplayedChannel| {
        vec![
            c.standard.to_owned(),
            c.column.to_owned(),
            cell(c.rmse),
            cell(c.after),
            cell(c.difference),
            cell(c.difference_of_a_value),
        ]
    };
    let headers = [
        "archive",
        "output",
        "#error of the FMU",
        "#after",
        "#difference / range",
        "#of a single value / range",
    ];
    format!(
        "<h2>The FMUs</h2>{}{}",
        paragraph(&format!(
            "fmi2/{model}.fmu and fmi3/{model}.fmu start at the calibrated values of preset.toml, as in {file}. {}.",
            capital(&replay_words(replay)),
            model = outcome.model,
            file = outcome.export.file
        )),
        rows("replay", &headers, replay.channels.iter().map(row).collect())
    )
}

fn remarks(notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    let items: String = notes.iter().map(|n| format!("<li>{}</li>", escaped(n))).collect();
    format!("<h2>Notes</h2><ul>{items}</ul>")
}
