//! Figures of the models: location of the residual, parameters, an effect over its driver, readings that contradict the model.

use super::super::text::{self, plain};
use super::words::Words;
use super::{models, port};
use calibrate::intake::Illustration;
use calibrate::outcome::{Follows, Found, Outcome, Unexplained};
use calibrate::report::{column_words, driver_unit};
use describe::{Driver, GenericTerm, Grid, Law};
use maud::{Markup, html};
use present::figure::{Axis, Figure, Mark, Row, Rows};
use present::page::{Plate, plates};

/// 95 % of a normal distribution lie within this many standard deviations.
pub const WITHIN_95: f64 = 1.96;

/// The name of the final model in legends.
pub fn last_model(outcome: &Outcome) -> String {
    models(outcome, [("after", ())]).remove(0).0
}

/// A column in words with its unit; a temperature in degC.
pub fn with_unit(column: &str) -> String {
    let (name, unit) = column_words(column);
    let unit = if column.ends_with("_degC") { "°C" } else { unit };
    if unit.is_empty() { name } else { format!("{name} in {unit}") }
}

/// The least fraction of the residual that is drawn.
const LEAST_SHARE: f64 = 0.01;

/// The fraction of the residual that an unconstrained input at each port explains, in a figure; in a sentence where there is none.
pub fn localised(outcome: &Outcome) -> Markup {
    let mut places: Vec<_> = outcome.localised.iter().filter(|l| l.share >= LEAST_SHARE).collect();
    places.sort_by(|a, b| b.share.total_cmp(&a.share));
    if places.is_empty() {
        return html! { p { "No port explains 1 % of it: no input that the model lacks is seen in the residual of the fit." } };
    }
    let row = |l: &&calibrate::outcome::Localised| {
        let port = plain(l.port.name());
        let remark = format!("{:.0} %", 100.0 * l.share);
        Row {
            name: l.follows.name().map_or(port.clone(), |name| format!("{port} (follows {})", plain(&name))),
            marks: vec![(0, Mark::Bar(100.0 * l.share, remark))],
        }
    };
    let figure = Rows::new(
        "Unconstrained input at each port",
        "fraction of the residual beyond noise in %",
        &[],
        places.iter().map(row).collect(),
    );
    let caption = "In brackets: the driver that correlates best with the input at the port.";
    plates(&[Plate::new("localised", figure, caption)])
}

/// Parameters as their change from the preset in standard deviations of their priors, which are comparable however wide a prior is.
pub fn forest(words: Words, outcome: &Outcome) -> Plate {
    let row = |p: &calibrate::outcome::Estimate| {
        let prior = words.experiment.priors.iter().find(|q| q.name == p.name)?;
        let nominal = words.declaration.by_name(&p.name).map_or(f64::NAN, |entry| entry.row.nominal);
        let change = |value: f64| (value - p.prior) / prior.deviation.of(p.prior, nominal);
        let interval = |(a, b): (f64, f64)| {
            let (a, b) = (change(a), change(b));
            (a.min(b), a.max(b))
        };
        let mut marks = vec![(2, Mark::Span(-WITHIN_95, WITHIN_95))];
        let refit = outcome.refit.iter().find(|r| r.name == p.name && !outcome.effects.is_empty());
        if let Some(refit) = refit {
            marks.push((1, Mark::Point(change(refit.value), interval(refit.ci95))));
        }
        marks.push((0, Mark::Point(change(p.value), interval(p.ci95))));
        Some(Row { name: format!("{} ({})", words.meaning(&p.name), p.name).trim_start().to_owned(), marks })
    };
    let figure = Rows::new(
        "Change of the parameters from the preset",
        "change in standard deviations of the prior",
        &[&last_model(outcome), if outcome.effects.is_empty() { "" } else { "refit" }, "prior"],
        outcome.parameters.iter().filter_map(row).collect(),
    );
    Plate::new(
        "parameters",
        figure,
        "95 % intervals. A parameter outside its prior after the fit indicates an effect that the model lacks.",
    )
}

/// Points of the line of a law.
const SAMPLES: usize = 60;

/// A driver with its unit, as an axis has it; with its lag where the law follows the lagged one.
pub fn driver_label(driver: Driver, follows: Follows, terms: &[&GenericTerm]) -> String {
    let lag = terms.iter().filter_map(|term| term.lag).find(|lag| lag.driver == driver && !lag.difference);
    let late = match (lag, follows) {
        (Some(lag), _) => format!(", lag {}", text::with_unit(lag.tau, "s")),
        (None, Follows::Late(_)) => ", lagged".to_owned(),
        _ => String::new(),
    };
    let unit = text::with_unit(1.0, driver_unit(driver));
    match unit.split_once(' ') {
        Some((_, unit)) if late.is_empty() => format!("{} in {unit}", plain(driver.name())),
        Some((_, unit)) => format!("{}{late}, in {unit}", plain(driver.name())),
        None => plain(driver.name()) + &late,
    }
}

/// The quantity of a port with its unit.
pub fn port_label(of: describe::Port) -> String {
    match present::words::unit(of.unit().name()) {
        unit if unit.is_empty() => format!("relative change of {}", port(of)),
        unit => format!("{} in {unit}", plain(of.name())),
    }
}

/// A law over one driver between two values.
fn line(law: &Law, driver: Driver, (from, to): (f64, f64)) -> Option<Vec<(f64, f64)>> {
    match law {
        Law::Product(product) => {
            let mut factors = product.factors.iter().flatten();
            let (factor, None) = (factors.next()?, factors.next()) else { return None };
            let at = |k: usize| from + (to - from) * k as f64 / (SAMPLES - 1) as f64;
            let points = (0..SAMPLES).map(|k| (at(k), product.coefficient * factor.of(at(k))));
            (factor.driver == driver).then(|| points.collect())
        }
        Law::Table(table) => {
            let (x, y) = table.points();
            (table.driver == driver).then(|| x.iter().copied().zip(y.iter().copied()).collect())
        }
        Law::Grid(_) => None,
    }
}

/// The estimated effect at a port over its driver, with its band, and the law that was added; of two drivers over the first one, averaged over
/// the second, and the law at the points of the second.
pub fn shape(found: &Unexplained, outcome: &Outcome) -> Plate {
    let (widths, y): (Vec<f64>, Vec<(f64, f64)>) = (
        found.shape.iter().map(|p| WITHIN_95 * p.2).collect(),
        found.shape.iter().map(|p| (p.0, p.1)).collect(),
    );
    let effects: Vec<&Found> =
        outcome.effects.iter().filter(|e| e.port == found.port && e.term.is_some()).collect();
    let terms: Vec<&GenericTerm> = effects.iter().filter_map(|e| e.term.as_ref()).collect();
    let mut drivers = found.follows.drivers();
    let (first, second) = (drivers.next(), drivers.next());
    let x = match first {
        Some(Driver::Time) | None => Axis::time(),
        Some(driver) => Axis::new(&driver_label(driver, found.follows, &terms)),
    };
    let mean = second.map_or(String::new(), |driver| format!(", mean over {}", plain(driver.name())));
    let ends = y.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let mut figure = Figure::new(&plain(found.port.name()), x, Axis::new(&port_label(found.port)))
        .band("95 % interval of the estimate", y.clone(), widths)
        .colour(0)
        .line(&format!("estimate{mean}"), y);
    let mut colour = 1;
    let mut has_law = false;
    for term in &terms {
        let line = first.and_then(|driver| line(&term.law, driver, ends));
        if let Some(line) = line {
            has_law = true;
            figure = figure.colour(colour).dashed("law added", line);
            colour += 1;
        }
        if let Law::Grid(grid) = &term.law {
            for (label, line) in sections(grid) {
                has_law = true;
                figure = figure.colour(colour).line(&label, line);
                colour += 1;
            }
        }
    }
    let law = if has_law { " with the law that was added" } else { "" };
    let magnitude = effects.first().map_or(String::new(), |e| format!(" It {}.", e.magnitude));
    Plate::new("shape", figure, format!("Estimated effect on {}{law}.{magnitude}", port(found.port)))
}

/// The law over the first driver of a grid at each point of the second, with a label.
fn sections(grid: &Grid) -> Vec<(String, Vec<(f64, f64)>)> {
    let rows: Vec<&[f64]> = grid.values().collect();
    let section = |(k, at): (usize, &f64)| {
        let line = grid.points(0).iter().zip(&rows).map(|(x, row)| (*x, row[k])).collect();
        let second = grid.drivers[1];
        (format!("law at {} {}", plain(second.name()), text::with_unit(*at, driver_unit(second))), line)
    };
    grid.points(1).iter().enumerate().map(section).collect()
}

/// Height of a line in its panel below which it is a straight line to the eye.
const FLAT: f64 = 0.1;

/// Readings that contradict the model, as recorded, as predicted by the preset, and as corrected.
pub fn contradiction(found: &Illustration) -> Plate {
    let mut figure = Figure::stacked("Readings that contradict the model", Axis::time()).thin();
    let points = |values: &[f64]| found.time.iter().copied().zip(values.iter().copied()).collect::<Vec<_>>();
    let height = |values: &[f64]| {
        let all = values.iter().filter(|x| x.is_finite());
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        high - low
    };
    for channel in &found.channels {
        let label = with_unit(channel.column);
        figure = figure.panel(Axis::new(&label)).line("as recorded", points(&channel.recorded));
        if let Some(values) = &channel.predicted {
            figure = figure.colour(1).line("predicted by the preset", points(values));
        }
        if let Some(values) = &channel.corrected {
            // Next to readings of another order of magnitude they would be a straight line.
            let ratio = height(values) / height(&channel.recorded);
            if ratio.is_finite() && !(FLAT..=1.0 / FLAT).contains(&ratio) {
                figure = figure.panel(Axis::new(&label));
            }
            figure = figure.colour(2).line("as corrected", points(values));
        }
        if let Some(values) = &channel.predicted_corrected {
            figure = figure.colour(3).line("predicted from the corrected readings", points(values));
        }
    }
    let change = found.change.as_ref().map_or(String::new(), |change| {
        format!(
            " As corrected: {}.",
            change.split(' ').map(present::words::unit).collect::<Vec<_>>().join(" ")
        )
    });
    Plate::new("contradiction", figure, format!("Readings of {} from its first row on.{change}", found.file))
}
