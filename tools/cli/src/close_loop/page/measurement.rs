//! What the data are worth: noise and drift, power of what was found, and the next experiment.

use super::super::text::{error_of, list, number, plain};
use super::numbers::rough;
use super::{channel, models_table};
use calibrate::experiment::{Channel, Experiment};
use calibrate::noise;
use calibrate::outcome::{ChannelError, Follows, Found, Outcome, Unexplained, Verdict};
use calibrate::report::column_words;
use describe::{Driver, Law, Port};
use maud::{Markup, html};
use present::page::Cell;
use std::cmp::Ordering;

/// A driver spans too little to show what follows it, in deviations of its noise.
const SPANS: f64 = 20.0;
/// Test error over noise from which on the model lacks something.
const ABOVE_NOISE: f64 = 1.3;

/// Noise of every channel and the correlation that is left.
pub fn noises(experiment: &Experiment, outcome: &Outcome) -> Markup {
    let channels: Vec<&Channel> = experiment.inputs.iter().chain(&experiment.outputs).copied().collect();
    let sizes = noise::of_experiment(experiment);
    let rows = channels.iter().zip(sizes).map(|(c, size)| {
        let is_constant = is_constant(experiment, c);
        let origin = match experiment.noise.contains_key(c.column) {
            true => "stated",
            false if is_constant => "constant",
            false => "estimated",
        };
        let white = outcome.whiteness.iter().find(|w| w.column == c.column);
        vec![
            channel(c.column).into(),
            // The noise that a constant column is given for the numerics says nothing about its sensor.
            Cell::Number(if origin == "constant" { String::new() } else { rough(size) }),
            origin.into(),
            Cell::maybe(white.map(|w| w.autocorrelation.1)),
            Cell::maybe(white.map(|w| w.blocks_after)),
        ]
    });
    let headers = ["channel", "standard deviation", "origin", "correlation of rows, after", "drift, after"];
    html! {
        h2 { "Noise and drift" }
        p {
            "Noise of each channel as used. Drift: mean square of block means of the residual relative to that of the noise alone; 1 without \
             drift."
        }
        (models_table(outcome, &headers, rows.collect()))
    }
}

/// Whether a column has one value in each run.
fn is_constant(experiment: &Experiment, channel: &Channel) -> bool {
    let mut all = experiment.inputs.iter().chain(&experiment.outputs);
    let Some(k) = all.position(|c| c.column == channel.column) else { return false };
    experiment.runs.iter().all(|run| {
        let mut known = run.table.columns[k].iter().filter(|x| x.is_finite());
        let first = known.next();
        known.all(|x| Some(x) == first)
    })
}

/// The greatest size of a driver in the runs, and its range; in SI units.
fn range(experiment: &Experiment, is_it: impl Fn(&Channel) -> bool) -> Option<(&'static Channel, f64, f64)> {
    let all = experiment.inputs.iter().chain(&experiment.outputs).enumerate();
    let (k, channel) = all.into_iter().find(|(_, c)| is_it(c))?;
    let values = experiment.runs.iter().flat_map(|r| r.table.columns[k].iter().copied());
    let (least, most) = values
        .filter(|x| x.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    (least <= most).then_some((*channel, least, most))
}

/// Whether a channel reads a driver.
fn reads(channel: &Channel, driver: Driver) -> bool {
    let is = |name: &str| channel.column.starts_with(name);
    match driver {
        Driver::Speed => is("speed"),
        Driver::Current | Driver::CopperLoss => is("current"),
        Driver::FrictionLoss => is("speed"),
        Driver::LoadTorque => is("load_torque") || is("shaft_torque"),
        Driver::WindingTemperature => is("winding_temperature"),
        Driver::HousingTemperature => is("housing_temperature"),
        Driver::AmbientTemperature => is("ambient_temperature"),
        Driver::FanCommand => is("fan_command"),
        Driver::Time => false,
    }
}

/// The power of a value at a port, at the greatest speed, current or temperature rise of the runs, W; `None` where it is no power.
fn watts(port: Port, value: f64, experiment: &Experiment) -> Option<f64> {
    let most = |driver: Driver| {
        range(experiment, |c| reads(c, driver)).map(|(_, least, most)| least.abs().max(most.abs()))
    };
    let rise = || {
        let (_, _, housing) = range(experiment, |c| reads(c, Driver::HousingTemperature))?;
        let (_, ambient, _) = range(experiment, |c| reads(c, Driver::AmbientTemperature))?;
        Some((housing - ambient).abs())
    };
    Some(match port {
        Port::DragTorque => value * most(Driver::Speed)?,
        Port::TerminalVoltage | Port::SeriesVoltage => value * most(Driver::Current)?,
        Port::WindingHeat | Port::HousingHeat => value,
        Port::HousingAmbientConductance => value * rise()?,
        _ => return None,
    })
}

/// The power that an unexplained effect amounts to, in a sentence.
pub fn power(found: &Unexplained, experiment: &Experiment, outcome: &Outcome) -> Option<String> {
    // The shape over two drivers is a mean over the second one.
    let grids = outcome.effects.iter().filter(|e| e.port == found.port).filter_map(|e| match &e.term?.law {
        Law::Grid(grid) => Some(grid.values().flatten().copied().collect::<Vec<_>>()),
        _ => None,
    });
    let most = found.shape.iter().map(|p| p.1).chain(grids.flatten()).map(f64::abs).fold(0.0, f64::max);
    let power = watts(found.port, most, experiment).filter(|p| *p > 0.0)?;
    Some(format!(
        "At most {} W, at the greatest speed, current or temperature rise of the runs.",
        number(power)
    ))
}

/// A range in the unit of the column.
fn spanned(found: (&Channel, f64, f64)) -> String {
    let (channel, least, most) = found;
    let (name, unit) = column_words(channel.column);
    let unit = if channel.is_temperature() { "degC" } else { unit };
    let (least, most) = (number(least - channel.offset), number(most - channel.offset));
    let ends = if least == most { format!("{least} {unit}") } else { format!("{least} to {most} {unit}") };
    format!("{name} ({})", ends.trim_end())
}

/// A driver with its range in the runs, if it is measured.
fn ranged(driver: Driver, experiment: &Experiment) -> String {
    range(experiment, |c| reads(c, driver)).map_or_else(|| plain(driver.name()), spanned)
}

/// What a further run has to do to show what follows a driver.
fn run_for(follows: Follows, port: Port, experiment: &Experiment) -> String {
    let place = plain(port.name());
    match follows {
        Follows::Driver(Driver::Time) => format!(
            "Repeat the first run after the last one: what changes between the two follows the time (wear, drift of a sensor), and not {place}."
        ),
        Follows::Both(first, second) => {
            let [first, second] = [first, second].map(|driver| ranged(driver, experiment));
            format!(
                "Runs that go through {first} in five steps, each at another value of {second}, with the other inputs constant: a law over both \
                 is measured directly."
            )
        }
        Follows::Driver(driver) | Follows::Late(driver) | Follows::Mass(driver) => {
            let own = ranged(driver, experiment);
            let late = if matches!(follows, Follows::Late(_) | Follows::Mass(_)) {
                " Hold each step for at least three lags, and log the steps with short rows."
            } else {
                ""
            };
            format!(
                "A run that goes through {own} in five steps up and down, beyond both ends if the motor permits, with the other inputs constant: \
                 the law over it is measured directly, and the way down shows hysteresis.{late}"
            )
        }
        Follows::History => format!(
            "The same load cycle twice, after a short and after a long pause, followed by a cooling at rest of three time constants: a \
             difference between the two cycles is a state that the model lacks at {place}; without a difference, look at the clocks and the \
             seat of the sensors."
        ),
        Follows::Nothing => format!(
            "A run at rest without current and one at constant load: a constant {place} is present in both."
        ),
    }
}

/// The next experiment, in sentences.
pub fn next(experiment: &Experiment, outcome: &Outcome) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let separating: Vec<&Found> =
        outcome.effects.iter().filter(|e| e.separating_experiment.is_some()).collect();
    for effect in &separating {
        let text = effect.separating_experiment.as_deref().unwrap_or_default();
        all.push(format!("To distinguish {} from its alternatives: {text}.", plain(&effect.id)));
    }
    if let Some(found) = &outcome.unexplained {
        all.push(run_for(found.follows, found.port, experiment));
    } else if let Some(effect) = outcome.effects.first().filter(|_| separating.is_empty()) {
        all.push(format!(
            "To confirm {}: {}",
            plain(&effect.id),
            run_for(effect.follows, effect.port, experiment)
        ));
    }
    let sizes = noise::of_experiment(experiment);
    let still: Vec<String> = experiment
        .inputs
        .iter()
        .zip(&sizes)
        .filter_map(|(c, size)| {
            let found = range(experiment, |other| other.column == c.column)?;
            (found.2 - found.1 <= SPANS * size && !c.is_temperature()).then(|| spanned(found))
        })
        .collect();
    if !still.is_empty() {
        all.push(format!(
            "What follows {} cannot be seen, since it hardly changes in the runs: vary it in steps.",
            list(&still, "or")
        ));
    }
    if matches!(outcome.verdict, Verdict::Nothing | Verdict::Fitted) {
        let worst = outcome
            .errors
            .iter()
            .filter(|e| e.after > ABOVE_NOISE * e.floor)
            // First of the runs of the verdict, so that both name one error.
            .max_by(|a, b| {
                let rank = |e: &ChannelError| (e.role == outcome.unfitted(), e.after / e.floor);
                rank(a).partial_cmp(&rank(b)).unwrap_or(Ordering::Equal)
            });
        all.push(match worst {
            Some(e) => format!(
                "{} is {} times the noise: a run with steps of one input at a time, each held for three time constants, shows which input it \
                 follows; a second sensor on the same part shows whether the sensor is the cause.",
                super::capital(&error_of(e)),
                rough(e.after / e.floor)
            ),
            None => "The model predicts the runs to the noise. Runs of twice the length lower the detection limits by a factor of \
                     1.4; runs at higher speed, current and temperature lower those of effects that grow with these."
                .to_owned(),
        });
    }
    all
}
