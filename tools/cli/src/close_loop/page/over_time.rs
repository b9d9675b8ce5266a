//! Figures of the runs: outputs, inputs and residuals over time, residuals over the drivers.

use super::super::text::{list, number};
use super::figures::{WITHIN_95, last_model, with_unit};
use super::models;
use super::numbers::rough;
use super::parts::{Data, Part};
use calibrate::outcome::{Curve, Curves, Outcome};
use calibrate::report::{column_words, count_of};
use present::figure::{Axis, Figure};
use present::page::Plate;
use std::collections::HashSet;

/// Heights of what was used above and below it up to which readings that were set aside are drawn; the scale remains that of the others.
const AROUND: f64 = 1.0;
/// Readings set aside from which on they are points, and the most that are drawn.
const MANY_ASIDE: usize = 100;
const MOST_ASIDE: usize = 600;
/// Gaps that a caption lists; of more it names the longest.
const FEW_GAPS: usize = 3;
/// Part of the range that is left free at the end, where a point would lie half outside the frame.
const MARGIN: f64 = 0.02;
/// The colour of readings that were set aside, and of bands: grey.
const GREY: usize = 4;

/// The axis of all figures of a run.
fn time(part: &Part) -> Axis {
    let has_points = part.curves.outputs.iter().any(|curve| part.is_sparse(curve));
    Axis::time().from_to(0.0, part.length() * if has_points { 1.0 + MARGIN } else { 1.0 })
}

/// First and last time of the rows that count, s from the start.
fn counted(part: &Part) -> (f64, f64) {
    let (from, to) = part.curves.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    ((from - part.start()).max(0.0), (to - part.start()).min(part.length()))
}

/// The noise of an output in the role of a run.
fn noise(curves: &Curves, outcome: &Outcome, column: &str) -> f64 {
    let error = outcome.errors.iter().find(|e| e.role == curves.role && e.column == column);
    error.map_or(f64::NAN, |e| e.floor)
}

/// Least and greatest of the values.
fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values = values.filter(|x| x.is_finite());
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// The readings that were set aside and are near enough to the others to be drawn, and how many are not.
fn near(points: Vec<(f64, f64)>, (low, high): (f64, f64), least: f64) -> (Vec<(f64, f64)>, usize) {
    // Without anything else they make the scale.
    if low > high {
        return (thinned(points), 0);
    }
    let margin = AROUND * (high - low).max(least);
    let count = points.len();
    let mut kept = points;
    kept.retain(|p| (low - margin..=high + margin).contains(&p.1));
    let outside = count - kept.len();
    (thinned(kept), outside)
}

/// Readings that a figure shows apart from each other.
fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let step = points.len().div_ceil(MOST_ASIDE).max(1);
    points.into_iter().step_by(step).collect()
}

/// Readings that were set aside: few as rings, many as points, whose rings would be a bar.
fn with_aside(figure: Figure, points: Vec<(f64, f64)>) -> Figure {
    let figure = figure.colour(GREY);
    if points.len() > MANY_ASIDE {
        figure.points("set aside", points)
    } else {
        figure.rings("set aside", points)
    }
}

/// Measured and predicted outputs of a run over time, with the inputs that change below them.
pub fn compared(part: &Part, data: Data, outcome: &Outcome) -> Plate {
    let curves = part.curves;
    let mut figure = Figure::stacked("Measured and predicted", time(part)).thin();
    let mut caption = format!(
        "Outputs: measured and predicted by the {} model.",
        if outcome.effects.is_empty() { "fitted" } else { "extended" }
    );
    let (mut remarks, mut has_rings): (Vec<String>, bool) = (Vec::new(), false);
    let inputs = data.used.inputs.len();
    for (curve, (k, channel)) in curves.outputs.iter().zip(data.used.outputs.iter().enumerate()) {
        let noise = noise(curves, outcome, curve.column);
        let bar = if noise > 0.0 { WITHIN_95 * noise } else { 0.0 };
        let aside =
            part.set_aside(inputs + k).into_iter().map(|(t, x)| (t, x - channel.offset)).collect::<Vec<_>>();
        let count = aside.len();
        let measured = ends(curve.measured.iter().flat_map(|x| [x - bar, x + bar]));
        let model = ends(curve.after.iter().copied());
        let (low, high) = (measured.0.min(model.0), measured.1.max(model.1));
        let (rings, outside) = near(aside, (low, high), bar);
        let rings_ends = ends(rings.iter().map(|p| p.1));
        let (low, high) = (low.min(rings_ends.0), high.max(rings_ends.1));
        let mut y = Axis::new(&with_unit(curve.column));
        // A difference far below the noise must not fill the panel.
        if high - low < 2.0 * bar {
            y = y.from_to(0.5 * (low + high) - bar, 0.5 * (low + high) + bar);
        }
        figure = figure.panel(y).colour(0);
        let points = part.line(curve.measured.iter().copied());
        // Few readings would not be seen as a line.
        figure = match part.is_sparse(curve) {
            true if bar > 0.0 => {
                let bars = vec![bar; points.len()];
                figure.points_with_bars("measured, with 95 % of the noise", points, bars)
            }
            true => figure.points("measured", points),
            false => figure.line("measured", points),
        };
        figure = figure.colour(1).line(&last_model(outcome), part.line(curve.after.iter().copied()));
        has_rings |= !rings.is_empty();
        figure = with_aside(figure, rings);
        let name = column_words(curve.column).0;
        let is_used = curve.measured.iter().any(|x| x.is_finite());
        match (is_used, count) {
            (false, 0) => remarks.push(format!("{name}: not measured in this run")),
            (false, _) => remarks.push(format!("{name}: all readings were set aside (see Notes)")),
            _ => {}
        }
        remarks.extend(not_drawn(&name, outside));
    }
    let mut changing = "";
    for (k, channel) in data.used.inputs.iter().enumerate() {
        let values = part.column(k);
        let shown = |values: &[f64]| values.iter().map(|x| x - channel.offset).collect::<Vec<_>>();
        let (low, high) = ends(values.iter().copied());
        let aside = part.set_aside(k);
        if high <= low && aside.is_empty() {
            continue;
        }
        changing = " Below: the inputs that change.";
        let name = column_words(channel.column).0;
        let (rings, outside) = near(aside, (low, high), 0.0);
        let rings: Vec<(f64, f64)> = rings.into_iter().map(|(t, x)| (t, x - channel.offset)).collect();
        has_rings |= !rings.is_empty();
        // One line needs no legend.
        figure =
            figure.panel(Axis::new(&with_unit(channel.column))).colour(2).line("", part.line(shown(&values)));
        figure = with_aside(figure, rings);
        remarks.extend(not_drawn(&name, outside));
    }
    caption += changing;
    if has_rings {
        caption += " Grey: readings that were set aside (see Notes).";
    }
    caption += &remarks.iter().map(|remark| format!(" {}.", super::capital(remark))).collect::<String>();
    caption += &gaps(part);
    let (figure, is_windowed) = windowed(figure, part);
    if is_windowed {
        caption += " The rows within the window count.";
    }
    Plate::new("compared", figure, caption)
}

/// The remark on readings that were set aside too far from the others to be drawn.
fn not_drawn(name: &str, count: usize) -> Option<String> {
    let was = if count == 1 { "was" } else { "were" };
    let readings = count_of(count, "reading");
    (count > 0).then(|| format!("{name}: {readings} that {was} set aside outside the panel"))
}

/// The gaps in words, by the clock of the file as in the notes.
fn gaps(part: &Part) -> String {
    let gaps = part.gaps();
    let clock = if part.start() == 0.0 { "" } else { " of the clock" };
    let of = |(from, to): &(f64, f64)| format!("from {from} s to {to} s");
    match gaps.len() {
        0 => String::new(),
        1..=FEW_GAPS => {
            format!(" No rows {}{clock}.", list(&gaps.iter().map(of).collect::<Vec<_>>(), "and"))
        }
        count => {
            let longest = gaps.iter().max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
            format!(" {count} gaps without rows, the longest {}{clock}.", longest.map(of).unwrap_or_default())
        }
    }
}

/// Residual of the refit over each driver that was measured, with what the model after the repair predicts beyond the refit; for the output
/// whose refit is furthest above its noise. A row counts once in each role.
pub fn over_drivers(data: Data, outcome: &Outcome) -> Vec<Plate> {
    let experiment = data.used;
    let ratio = |column: &str| {
        let own = outcome.errors.iter().filter(|e| e.column == column);
        own.map(|e| e.refit / e.floor).filter(|r| r.is_finite()).fold(0.0, f64::max)
    };
    let worst = experiment.outputs.iter().map(|c| c.column).max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let Some(worst) = worst else { return Vec::new() };
    let (name, unit) = column_words(worst);
    let parts = Part::all(data, &outcome.curves);
    // Inputs by their place among the columns, measured temperatures and the time.
    let mut drivers: Vec<(String, Axis, Vec<Vec<f64>>)> = Vec::new();
    let channels = experiment.inputs.iter().chain(&experiment.outputs).enumerate();
    for (k, channel) in channels.filter(|(k, c)| *k < experiment.inputs.len() || c.is_temperature()) {
        let values = parts.iter().map(|part| part.column(k).iter().map(|x| x - channel.offset).collect());
        let label = with_unit(channel.column);
        drivers.push((column_words(channel.column).0, Axis::new(&label), values.collect()));
    }
    let since = |part: &Part| part.curves.time.iter().map(|t| t - part.start()).collect();
    drivers.push((
        "time since the start of each run".to_owned(),
        Axis::time(),
        parts.iter().map(since).collect(),
    ));
    let mut all = Vec::new();
    for (driver, axis, values) in drivers {
        let (mut left, mut law, mut known) = (Vec::new(), Vec::new(), HashSet::new());
        for (part, x) in parts.iter().zip(&values) {
            let curves = part.curves;
            let Some(curve) = curves.outputs.iter().find(|c| c.column == worst) else { continue };
            for (row, x) in x.iter().enumerate().filter(|(_, x)| x.is_finite()) {
                let (t, y) = (curves.time[row], curve.measured[row] - curve.refit[row]);
                let mut is_new = || known.insert((&curves.file, curves.role as u8, t.to_bits()));
                if y.is_finite() && part.counts(t) && is_new() {
                    left.push((*x, y));
                    law.push((*x, curve.after[row] - curve.refit[row]));
                }
            }
        }
        // A driver with one value at all readings shows nothing.
        if left.iter().all(|p| p.0 == left[0].0) {
            continue;
        }
        let title = format!("{name} over {}", driver.split(" since").next().unwrap_or(&driver));
        let model = if outcome.effects.is_empty() { "fitted model" } else { "refit" };
        let y = format!("measured − {model}{}", in_unit(unit));
        let mut figure = Figure::new(&title, axis, Axis::new(&y)).thin();
        figure = figure.colour(0).points(&format!("residual of the {model}"), left);
        if !outcome.effects.is_empty() {
            law.retain(|p| p.1.is_finite());
            figure = figure.colour(1).rings("law found (after − refit)", apart(law));
        }
        all.push(Plate::new(
            "over-driver",
            figure,
            format!("Residual of the {model} in the rows of all runs that count, over {driver}."),
        ));
    }
    all
}

fn in_unit(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" in {unit}") }
}

/// One point of those that would lie over each other.
fn apart(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    /// Cells of the figure across and upwards, each as large as a ring.
    const CELLS: [f64; 2] = [50.0, 25.0];
    let range = |of: fn(&(f64, f64)) -> f64| {
        let (low, high) = ends(points.iter().map(of));
        (low, (high - low).max(f64::MIN_POSITIVE))
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

/// Measured less model over time in the rows that count, for every output: with the preset, and once more without.
pub fn residuals(part: &Part, outcome: &Outcome) -> Vec<Plate> {
    let (curves, (from, to)) = (part.curves, counted(part));
    let mut all = Vec::new();
    for curve in curves.outputs.iter().filter(|c| part.is_line(c)) {
        let (name, unit) = column_words(curve.column);
        let noise = noise(curves, outcome, curve.column);
        let figure = |title: &str| {
            let y = Axis::new(&format!("measured − model{}", in_unit(unit)));
            Figure::new(title, Axis::time().from_to(from, to), y).thin()
        };
        // Each with its colour, which is the same in both figures.
        let all_models =
            [("before", (0, &curve.before)), ("refit", (1, &curve.refit)), ("after", (2, &curve.after))];
        let of_models: Vec<_> = models(outcome, all_models)
            .into_iter()
            .map(|(word, (colour, model))| (word, colour, residual(part, curve, model)))
            .collect();
        let sizes = |list: &[Residual]| {
            let list: Vec<String> =
                list.iter().map(|(word, _, r)| format!("{} {word}", number(size(r)))).collect();
            format!("Greatest residual{}: {}. Noise: {} {unit}", in_unit(unit), list.join(", "), rough(noise))
                .trim_end()
                .to_owned()
                + "."
        };
        let lines = |figure: Figure, list: &[Residual]| {
            list.iter().fold(figure, |f, (word, colour, r)| f.colour(*colour).line(word, r.clone()))
        };
        all.push(Plate::new("residual", lines(figure(&name), &of_models), sizes(&of_models)));
        let near = figure(&format!("{name}, without the preset")).colour(GREY);
        let near = near.band("noise, 95 %", vec![(from, 0.0), (to, 0.0)], vec![WITHIN_95 * noise; 2]);
        all.push(Plate::new("residual", lines(near, &of_models[1..]), sizes(&of_models[1..])));
    }
    all
}

/// Residual of a model over time: its name, its colour and the points.
type Residual = (String, usize, Vec<(f64, f64)>);

fn residual(part: &Part, curve: &Curve, model: &[f64]) -> Vec<(f64, f64)> {
    let rows = part.curves.time.iter().zip(&curve.measured).zip(model);
    part.line(rows.map(|((t, measured), shown)| if part.counts(*t) { measured - shown } else { f64::NAN }))
}

fn size(points: &[(f64, f64)]) -> f64 {
    points.iter().map(|p| p.1.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max)
}

/// With the window of the run, where it is not the whole run; and whether it is not.
fn windowed(mut figure: Figure, part: &Part) -> (Figure, bool) {
    let Some((from, to)) = part.curves.window else { return (figure, false) };
    let (from, to, length) = (from - part.start(), to - part.start(), part.length());
    let (begins, ends) = (from > 0.0 && from < length, to > 0.0 && to < length);
    if begins {
        figure = figure.note(from, "window begins");
    }
    if ends {
        figure = figure.note(to, "window ends");
    }
    (figure, begins || ends)
}
