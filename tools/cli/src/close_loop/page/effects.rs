//! Sections on what the model lacks: effects with their numbers and laws, and the effect that no law of the list explains.

use super::capital;
use super::figures::{driver_label, port_label, shape};
use super::measurement;
use super::numbers::{estimate, evidence, interval};
use super::words::Words;
use crate::close_loop::text::{
    attached, driver, is_value, law, list, number, plain, port, undescribed, with_unit,
};
use calibrate::experiment::Experiment;
use calibrate::outcome::{Estimate, Follows, Found, Outcome, Unexplained};
use calibrate::report::driver_unit;
use describe::{GenericTerm, Law};
use maud::{Markup, html};
use present::page::{Cell, plates, table};
use present::typeset;

/// Each effect that was added.
pub fn effects(outcome: &Outcome, words: Words) -> Markup {
    html! {
        @if !outcome.effects.is_empty() { h2 { "Identified effects" } }
        @for effect in &outcome.effects {
            h3 { (heading(effect)) }
            p {
                "It acts on " (port(effect.port)) " and " (driver(effect.follows)) "."
                @if !effect.magnitude.is_empty() { " It " (typeset(&effect.magnitude)) "." }
                @if !effect.everywhere { " It acts in " (list(&effect.runs, "and")) " only." }
            }
            @if let Some(term) = &effect.term { p { "Law: " (typeset(&law(term))) "." } }
            (sizes(effect, words))
            p { (typeset(&support(effect))) }
            @if !effect.alternatives.is_empty() {
                @let names: Vec<String> = effect.alternatives.iter().map(|a| plain(a)).collect();
                @let weights: Vec<String> = effect.class().map(|(id, weight)| format!("{} {weight:.2}", plain(id))).collect();
                p { "The data are explained equally well by " (list(&names, "or by")) ". Posterior weights: " (list(&weights, "and")) "." }
            }
            @if let Some(run) = &effect.separating_experiment { p { "Experiment that distinguishes them: " (typeset(run)) "." } }
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

/// The parameters of an effect with their meaning; the values of a law by points are a table over its drivers.
fn sizes(effect: &Found, words: Words) -> Markup {
    let (values, others): (Vec<&Estimate>, Vec<&Estimate>) =
        effect.parameters.iter().partition(|p| is_value(p));
    let points = effect.term.as_ref().and_then(|term| law_table(effect, term, &values));
    let others = if points.is_some() { others } else { effect.parameters.iter().collect() };
    let row = |p: &Estimate| {
        vec![
            Cell::Code(p.name.clone()),
            words.meaning(&format!("effect.{}.{}", effect.id, p.name)).into(),
            Cell::Number(estimate(p.value, p.ci95)),
            Cell::Number(interval(p.ci95)),
            Cell::Unit(p.unit),
        ]
    };
    let headers = ["symbol", "meaning", "value", "95 % interval", "unit"];
    html! {
        @if let Some(points) = points { (points) }
        @if !others.is_empty() { (table(&headers, others.into_iter().map(row).collect())) }
    }
}

/// The values of a table or a grid over its drivers, with their intervals; `None` for another law.
fn law_table(effect: &Found, term: &GenericTerm, values: &[&Estimate]) -> Option<Markup> {
    let label = |driver| driver_label(driver, effect.follows, &[term]);
    let cell = |p: &Estimate| Cell::Number(format!("{} ({})", estimate(p.value, p.ci95), interval(p.ci95)));
    match &term.law {
        Law::Table(points) if points.points().0.len() == values.len() => {
            let headers = [label(points.driver), port_label(effect.port), "95 % interval".to_owned()];
            let row = |(x, p): (&f64, &&Estimate)| {
                vec![
                    Cell::number(*x),
                    Cell::Number(estimate(p.value, p.ci95)),
                    Cell::Number(interval(p.ci95)),
                ]
            };
            let rows = points.points().0.iter().zip(values).map(row).collect();
            Some(table(&headers.each_ref().map(String::as_str), rows))
        }
        Law::Grid(grid) if grid.points(0).len() * grid.points(1).len() == values.len() => {
            let second = grid.drivers[1];
            let column =
                |at: &f64| format!("{} {}", plain(second.name()), with_unit(*at, driver_unit(second)));
            let headers: Vec<String> =
                std::iter::once(label(grid.drivers[0])).chain(grid.points(1).iter().map(column)).collect();
            let row = |(x, own): (&f64, &[&Estimate])| {
                std::iter::once(Cell::number(*x)).chain(own.iter().map(|p| cell(p))).collect()
            };
            let rows = grid.points(0).iter().zip(values.chunks(grid.points(1).len())).map(row).collect();
            Some(html! {
                p { (capital(&port_label(effect.port))) " with its 95 % interval:" }
                (table(&headers.iter().map(String::as_str).collect::<Vec<_>>(), rows))
            })
        }
        _ => None,
    }
}

fn support(effect: &Found) -> String {
    let validation = effect.validation_ratio.map_or(String::new(), |ratio| {
        format!(" The validation error with it is {} of the error without it.", number(ratio))
    });
    format!(
        "It lowers BIC by {}, and by {} when allowing for autocorrelated noise; above 10 is strong.{validation}",
        evidence(effect.delta_bic),
        evidence(effect.delta_bic_whitened)
    )
}

/// The effect that no law of the list explains.
pub fn unexplained(found: &Unexplained, experiment: &Experiment, outcome: &Outcome) -> Markup {
    let given = if found.added {
        "The law above was added to the model, since it lowers the validation error. The estimate in the figure is from the data without a \
         law."
    } else if outcome.effects.iter().any(|e| e.term.is_some()) {
        "The law above was added to the model, since it lowers the validation error; it explains a part of this effect."
    } else {
        "It was not added to the model, since it does not lower the validation error."
    };
    html! {
        h2 { "Unexplained effect" }
        p {
            @if found.follows == Follows::History { (capital(&undescribed(found, outcome))) ". " }
            @else { "An effect acts on " (port(found.port)) " and " (driver(found.follows)) ". " }
            (given)
            @if let Some(power) = measurement::power(found, experiment, outcome) { " " (typeset(&power)) }
        }
        @if !found.shape.is_empty() { (plates(&[shape(found, outcome)])) }
    }
}
