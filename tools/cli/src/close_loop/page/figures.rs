//! The figures of the page.

use super::super::text::{self, number, plain};
use super::words::Words;
use super::{models, port};
use calibrate::experiment::Experiment;
use calibrate::outcome::{Curve, Curves, Outcome, Unexplained};
use calibrate::report::{column_words, driver_unit};
use describe::{Grid, Law};
use present::figure::{Axis, Figure, Mark, Row, Rows};
use present::page::Plate;
use std::collections::HashSet;

/// 95 % of a normal distribution lie within this many standard deviations.
const WITHIN_95: f64 = 1.96;

/// Measured and predicted outputs of a run over time, with the inputs that change below them.
pub fn compared(curves: &Curves, experiment: &Experiment, outcome: &Outcome) -> Plate {
    let mut time = Axis::new("time in s");
    if let (true, [from, .., to]) = (curves.outputs.iter().any(is_sparse), &curves.time[..]) {
        // A point at the end of the run would lie half outside the frame.
        time = time.from_to(*from, to + 0.02 * (to - from));
    }
    let mut figure = Figure::stacked("Measured and predicted", time).thin();
    let points = |values: &[f64]| curves.time.iter().copied().zip(values.iter().copied()).collect::<Vec<_>>();
    for curve in &curves.outputs {
        figure = figure.panel(Axis::new(&with_unit(curve.column))).colour(0);
        // Few readings would not be seen as a line.
        figure = match is_sparse(curve) {
            true => figure.points("measured", points(&curve.measured)),
            false => figure.line("measured", points(&curve.measured)),
        };
        figure = figure.colour(1).line(last_model(outcome), points(&curve.after));
    }
    let mut inputs = "";
    if let Some(run) = run_of(curves, experiment) {
        for (channel, column) in experiment.inputs.iter().zip(&run.table.columns) {
            let rows = run.table.time.iter().zip(column).filter(|(t, _)| curves.time.contains(t));
            let points: Vec<(f64, f64)> = rows.map(|(t, x)| (*t, x - channel.offset)).collect();
            if points.iter().any(|p| p.1 != points[0].1) {
                inputs = " Below: the inputs that change.";
                figure = figure.panel(Axis::new(&with_unit(channel.column))).colour(2).line("input", points);
            }
        }
    }
    Plate::new(
        "compared",
        windowed(figure, curves),
        format!(
            "Outputs: measured and predicted by the {} model.{inputs}",
            if outcome.effects.is_empty() { "fitted" } else { "extended" }
        ),
    )
}

/// Fewer readings than this are a table, not a line.
const FEW: usize = 5;

/// Whether an output of a run has a few readings only.
pub fn is_sparse(curve: &Curve) -> bool {
    curve.measured.iter().filter(|x| x.is_finite()).count() < FEW
}

/// The name of the final model in legends.
fn last_model(outcome: &Outcome) -> &'static str {
    models(outcome, [("after", ())])[0].0
}

/// The run of the experiment that curves are of.
fn run_of<'a>(curves: &Curves, experiment: &'a Experiment) -> Option<&'a calibrate::experiment::Run> {
    let mut same = experiment.runs.iter().filter(|r| (&r.file, r.role) == (&curves.file, curves.role));
    let first = same.clone().next();
    same.find(|r| r.window == curves.window).or(first)
}

/// Residual of the refit over each driver that was measured, with what the model after the repair predicts beyond the refit; for the output
/// whose refit is furthest above its noise.
pub fn over_drivers(experiment: &Experiment, outcome: &Outcome) -> Vec<Plate> {
    let ratio = |column: &str| {
        let own = outcome.errors.iter().filter(|e| e.column == column);
        own.map(|e| e.refit / e.floor).filter(|r| r.is_finite()).fold(0.0, f64::max)
    };
    let worst = experiment.outputs.iter().map(|c| c.column).max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let Some(worst) = worst else { return Vec::new() };
    let (name, unit) = column_words(worst);
    // Inputs by their place among the columns, measured temperatures and the time.
    let mut drivers: Vec<(String, Vec<Vec<f64>>)> = Vec::new();
    let channels = experiment.inputs.iter().chain(&experiment.outputs).enumerate();
    for (k, channel) in channels.filter(|(k, c)| *k < experiment.inputs.len() || c.is_temperature()) {
        let values = outcome.curves.iter().map(|curves| {
            let table = run_of(curves, experiment).map(|run| &run.table);
            let at = |t: &f64| {
                let table = table?;
                let row = table.time.binary_search_by(|x| x.total_cmp(t)).ok()?;
                Some(table.columns[k][row] - channel.offset)
            };
            curves.time.iter().map(|t| at(t).unwrap_or(f64::NAN)).collect()
        });
        drivers.push((with_unit(channel.column), values.collect()));
    }
    drivers.push(("time in s".to_owned(), outcome.curves.iter().map(|c| c.time.clone()).collect()));
    let mut all = Vec::new();
    for (label, values) in drivers {
        let (mut left, mut law) = (Vec::new(), Vec::new());
        for (curves, x) in outcome.curves.iter().zip(&values) {
            let Some(curve) = curves.outputs.iter().find(|c| c.column == worst) else { continue };
            for (row, x) in x.iter().enumerate().filter(|(_, x)| x.is_finite()) {
                let (y, after) =
                    (curve.measured[row] - curve.refit[row], curve.after[row] - curve.refit[row]);
                left.extend(y.is_finite().then_some((*x, y)));
                law.extend((y + after).is_finite().then_some((*x, after)));
            }
        }
        // A driver with one value at all readings shows nothing.
        if left.iter().all(|p| p.0 == left[0].0) {
            continue;
        }
        let title = format!("{name} over {}", label.split(" in ").next().unwrap_or(&label));
        let model = if outcome.effects.is_empty() { "fitted model" } else { "refit" };
        let y = format!("measured − {model} in {unit}");
        let mut figure = Figure::new(&title, Axis::new(&label), Axis::new(&y)).thin();
        figure = figure.colour(0).points(&format!("residual of the {model}"), left);
        if !outcome.effects.is_empty() {
            figure = figure.colour(1).rings("law found (after − refit)", apart(law));
        }
        all.push(Plate::new(
            "over-driver",
            figure,
            format!("Residual of the {model} in all runs over {label}."),
        ));
    }
    all
}

/// One point of those that would lie over each other.
fn apart(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    /// Cells of the figure across and upwards, each as large as a ring.
    const CELLS: [f64; 2] = [50.0, 25.0];
    let range = |of: fn(&(f64, f64)) -> f64| {
        let ends = points.iter().map(of).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        (ends.0, (ends.1 - ends.0).max(f64::MIN_POSITIVE))
    };
    let (x, y) = (range(|p| p.0), range(|p| p.1));
    let mut known = HashSet::new();
    points.retain(|p| {
        let cell =
            |value: f64, (least, span): (f64, f64), count: f64| (count * (value - least) / span) as u32;
        known.insert((cell(p.0, x, CELLS[0]), cell(p.1, y, CELLS[1])))
    });
    points
}

/// A column in words with its unit; a temperature in degC.
pub fn with_unit(column: &str) -> String {
    let (name, unit) = column_words(column);
    let unit = if column.ends_with("_degC") { "°C" } else { unit };
    if unit.is_empty() { name } else { format!("{name} in {unit}") }
}

/// Measured less model over time, for every output: with the preset, and once more without.
pub fn residuals(curves: &Curves, outcome: &Outcome) -> Vec<Plate> {
    let mut all = Vec::new();
    for curve in curves.outputs.iter().filter(|c| !is_sparse(c)) {
        let (name, unit) = column_words(curve.column);
        let error = outcome.errors.iter().find(|e| e.role == curves.role && e.column == curve.column);
        let noise = error.map_or(f64::NAN, |e| e.floor);
        let figure = |title: &str| {
            let figure =
                Figure::new(title, Axis::new("time in s"), Axis::new(&format!("measured − model in {unit}")));
            windowed(figure.thin(), curves)
        };
        let left = |model: &[f64]| residual(curves, curve, model);
        // Each with its colour, which is the same in both figures.
        let all_models =
            [("before", (0, &curve.before)), ("refit", (1, &curve.refit)), ("after", (2, &curve.after))];
        let of_models: Vec<_> = models(outcome, all_models)
            .into_iter()
            .map(|(word, (colour, model))| (word, colour, left(model)))
            .collect();
        let sizes = |list: &[Residual]| {
            let list: Vec<String> =
                list.iter().map(|(word, _, r)| format!("{} {word}", number(size(r)))).collect();
            format!("Greatest residual in {unit}: {}. Noise: {} {unit}.", list.join(", "), number(noise))
        };
        let lines = |figure: Figure, list: &[Residual]| {
            list.iter().fold(figure, |f, (word, colour, r)| f.colour(*colour).line(word, r.clone()))
        };
        all.push(Plate::new("residual", lines(figure(&name), &of_models), sizes(&of_models)));
        let zero: Vec<(f64, f64)> =
            [curves.time.first(), curves.time.last()].into_iter().flatten().map(|t| (*t, 0.0)).collect();
        // The band is grey.
        let near = figure(&format!("{name}, without the preset")).colour(4);
        let near = near.band("noise, 95 %", zero, vec![WITHIN_95 * noise; 2]);
        all.push(Plate::new("residual", lines(near, &of_models[1..]), sizes(&of_models[1..])));
    }
    all
}

/// Residual of a model over time: its name, its colour and the points.
type Residual<'a> = (&'a str, usize, Vec<(f64, f64)>);

fn residual(curves: &Curves, curve: &Curve, model: &[f64]) -> Vec<(f64, f64)> {
    let rows = curves.time.iter().zip(&curve.measured).zip(model);
    rows.map(|((t, measured), shown)| (*t, measured - shown)).collect()
}

fn size(points: &[(f64, f64)]) -> f64 {
    points.iter().map(|p| p.1.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max)
}

/// With the window of the run, where it is not the whole run.
fn windowed(mut figure: Figure, curves: &Curves) -> Figure {
    let (Some((from, to)), Some(first), Some(last)) =
        (curves.window, curves.time.first(), curves.time.last())
    else {
        return figure;
    };
    if from > *first && from < *last {
        figure = figure.note(from, "window begins");
    }
    if to > *first && to < *last {
        figure = figure.note(to, "window ends");
    }
    figure
}

/// The fraction of the residual that an unconstrained input at each port explains.
pub fn localised(outcome: &Outcome) -> Plate {
    let mut places: Vec<_> = outcome.localised.iter().collect();
    places.sort_by(|a, b| b.share.total_cmp(&a.share));
    let row = |l: &&calibrate::outcome::Localised| {
        let follows = l.follows.name().map_or("constant".to_owned(), |name| plain(&name));
        let remark = format!("{:.0} %", 100.0 * l.share);
        Row {
            name: format!("{}, {follows}", plain(l.port.name())),
            marks: vec![(0, Mark::Bar(100.0 * l.share, remark))],
        }
    };
    let figure = Rows::new(
        "Unconstrained input at each port",
        "fraction of the residual beyond noise in %",
        &[],
        places.iter().map(row).collect(),
    );
    Plate::new("localised", figure, "Each port with the driver that correlates best with its input.")
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
        &[last_model(outcome), if outcome.effects.is_empty() { "" } else { "refit" }, "prior"],
        outcome.parameters.iter().filter_map(row).collect(),
    );
    Plate::new(
        "parameters",
        figure,
        "95 % intervals. A parameter outside its prior after the fit indicates an effect that the model lacks.",
    )
}

/// The estimated effect at a port over its driver, with its band; of two drivers over the first one, averaged over the second, and the law at
/// the points of the second.
pub fn shape(found: &Unexplained, outcome: &Outcome) -> Plate {
    let (x, y): (Vec<f64>, Vec<(f64, f64)>) = (
        found.shape.iter().map(|p| WITHIN_95 * p.2).collect(),
        found.shape.iter().map(|p| (p.0, p.1)).collect(),
    );
    let follows = match found.follows.drivers().next() {
        Some(driver) if driver_unit(driver) == "1" => plain(driver.name()),
        Some(driver) => format!("{} in {}", plain(driver.name()), driver_unit(driver)),
        None => "time in s".to_owned(),
    };
    let unit = present::words::unit(found.port.unit().name());
    let value = if unit.is_empty() { "relative change".to_owned() } else { format!("value in {unit}") };
    let title = plain(found.port.name());
    let figure = Figure::new(&title, Axis::new(&follows), Axis::new(&value))
        .band("95 %", y.clone(), x)
        .colour(0)
        .line("estimate", y);
    let terms = outcome.effects.iter().filter(|e| e.port == found.port).filter_map(|e| e.term.as_ref());
    let grid =
        terms.filter_map(|term| if let Law::Grid(grid) = &term.law { Some(grid) } else { None }).next();
    let figure = grid
        .map_or_else(Vec::new, sections)
        .into_iter()
        .enumerate()
        .fold(figure, |figure, (k, (label, line))| figure.colour(k + 1).line(&label, line));
    let magnitude = outcome
        .effects
        .iter()
        .find(|e| e.term.is_some() && e.port == found.port)
        .map_or(String::new(), |e| format!(" It {}.", e.magnitude));
    Plate::new("shape", figure, format!("Estimated effect on {}.{magnitude}", port(found.port)))
}

/// The law over the first driver of a grid at each point of the second, with a label.
fn sections(grid: &Grid) -> Vec<(String, Vec<(f64, f64)>)> {
    let rows: Vec<&[f64]> = grid.values().collect();
    let section = |(k, at): (usize, &f64)| {
        let line = grid.points(0).iter().zip(&rows).map(|(x, row)| (*x, row[k])).collect();
        let second = grid.drivers[1];
        (format!("{} {}", plain(second.name()), text::with_unit(*at, driver_unit(second))), line)
    };
    grid.points(1).iter().enumerate().map(section).collect()
}
