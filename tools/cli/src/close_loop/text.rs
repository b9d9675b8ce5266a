//! Verdict, effects and replay of closing the loop, as text.

use calibrate::experiment::{Experiment, Role};
use calibrate::outcome::{ChannelError, Estimate, Follows, Found, Outcome, Unexplained, Verdict};
pub use calibrate::report::words as plain;
use calibrate::report::{Replay, column_words, driver_unit, role_words};
use describe::{Driver, Factor, GenericTerm, Lag, Law, ModelType, Port, Resources, StartValues, usage};
pub use present::number;
use std::collections::HashSet;

use super::page::numbers::{estimate, interval, rough};

/// The port of a term, as text.
pub fn port(port: Port) -> &'static str {
    match port {
        Port::DragTorque => "the torque against the motion",
        Port::TerminalVoltage => "the voltage drop between terminals and winding",
        Port::SeriesVoltage => "the voltage in series with the winding",
        Port::WindingResistance => "the winding's resistance",
        Port::TorqueConstant => "the torque constant",
        Port::WindingHeat => "the heat in the winding",
        Port::HousingHeat => "the heat in the housing",
        Port::WindingHousingResistance => "the thermal resistance from winding to housing",
        Port::HousingAmbientConductance => "the heat flow from the housing to ambient",
        Port::HeatCapacity => "the heat capacities",
        Port::FanFlow => "the flow of the fan",
        Port::AmbientSensor => "the ambient temperature's sensor",
        Port::WindingSensor => "the winding's temperature sensor",
        Port::HousingSensor => "the housing's temperature sensor",
        Port::TorqueSensor => "the torque sensor",
    }
}

/// The driver of a term, as a predicate.
pub fn driver(follows: Follows) -> String {
    let driver = match follows {
        Follows::Nothing => "is constant",
        Follows::History => "depends on the history",
        Follows::Both(first, second) => {
            let [first, second] = [first, second].map(|own| self::driver(Follows::Driver(own)));
            return format!("{first} and {}", second.trim_start_matches("follows "));
        }
        Follows::Late(driver) => {
            return self::driver(Follows::Driver(driver)) + " with a first-order lag";
        }
        Follows::Mass(driver) => return format!("is the heat of {}", attached(driver)),
        Follows::Driver(driver) => match driver {
            Driver::Speed => "follows the speed",
            Driver::Current => "follows the current",
            Driver::LoadTorque => "follows the load",
            Driver::WindingTemperature => "follows the winding's temperature",
            Driver::HousingTemperature => "follows the housing's temperature",
            Driver::AmbientTemperature => "follows the ambient temperature",
            Driver::FanCommand => "follows the fan's command",
            Driver::Time => "follows time",
            Driver::CopperLoss => "follows the copper loss",
            Driver::FrictionLoss => "follows the friction loss",
        },
    };
    driver.to_owned()
}

/// A mass at the node of this temperature.
pub fn attached(driver: Driver) -> String {
    format!("a mass that is attached to the {}", plain(driver.name()).replace(" temperature", ""))
}

/// A list with a last word before its last item.
pub fn list(items: &[String], last: &str) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., end] => format!("{} {last} {end}", most.join(", ")),
    }
}

/// A value with its unit; a pure number has none.
pub fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {}", number(value), present::words::unit(unit)).trim_end().to_owned()
}

/// A value of a driver with its unit.
fn in_driver(value: f64, driver: Driver) -> String {
    with_unit(value, driver_unit(driver))
}

/// Whether a number of an effect is a value of a law by points, which a table has.
pub fn is_value(estimate: &Estimate) -> bool {
    estimate.name.starts_with("value at ")
}

/// A term's law: an equation, a table or a grid, and its lag.
pub fn law(term: &GenericTerm) -> String {
    if let Some([conductance, capacity]) = term.mass() {
        let [conductance, capacity] = [with_unit(conductance, "W/K"), with_unit(capacity, "J/K")];
        return format!("{} = that of a mass of {capacity} behind {conductance}", plain(term.port.name()));
    }
    let late = |lag: Lag| {
        let (driver, tau) = (plain(lag.driver.name()), with_unit(lag.tau, "s"));
        let less = if lag.difference { " less its present value" } else { "" };
        format!("; {driver} with a first-order lag of {tau}{less}")
    };
    present_law(term) + &term.lag.map(late).unwrap_or_default()
}

fn present_law(term: &GenericTerm) -> String {
    match &term.law {
        Law::Product(product) => {
            let factors = product.factors.iter().flatten().map(|f| {
                let off = match f.offset {
                    0.0 => plain(f.driver.name()),
                    off if off > 0.0 => {
                        format!("({} − {})", plain(f.driver.name()), in_driver(off, f.driver))
                    }
                    off => format!("({} + {})", plain(f.driver.name()), in_driver(-off, f.driver)),
                };
                let power =
                    if f.exponent == 1.0 { String::new() } else { format!("^{}", number(f.exponent)) };
                format!(" · ({off} / {}){power}", in_driver(f.reference, f.driver))
            });
            let size = with_unit(product.coefficient, term.port.unit().name());
            let ranged = product.factors.iter().flatten().filter(|f| f.range != Factor::UNLIMITED).map(|f| {
                let (least, most) = f.range;
                let most = in_driver(most, f.driver);
                format!("; constant outside {} from {} to {most}", plain(f.driver.name()), number(least))
            });
            let law: String = factors.chain(ranged).collect();
            format!("{} = {size}{law}", plain(term.port.name()))
        }
        Law::Table(table) => {
            let (x, y) = table.points();
            let end = |k: usize| {
                let value = with_unit(y[k], term.port.unit().name());
                format!("{value} at {}", in_driver(x[k], table.driver))
            };
            format!(
                "a table of {} over {} with {} points, from {} to {}, held beyond its ends",
                plain(term.port.name()),
                plain(table.driver.name()),
                x.len(),
                end(0),
                end(x.len() - 1)
            )
        }
        Law::Grid(grid) => {
            let line = |k: usize| {
                let (points, driver) = (grid.points(k), grid.drivers[k]);
                let last = in_driver(points[points.len() - 1], driver);
                format!(
                    "{} ({} points from {} to {last})",
                    plain(driver.name()),
                    points.len(),
                    number(points[0])
                )
            };
            let values = || grid.values().flatten().copied();
            let [least, most] =
                [values().fold(f64::INFINITY, f64::min), values().fold(-f64::INFINITY, f64::max)];
            format!(
                "a grid of {} over {} and {}, bilinear, held beyond its edges: values from {} to {}",
                plain(term.port.name()),
                line(0),
                line(1),
                number(least),
                with_unit(most, term.port.unit().name())
            )
        }
    }
}

/// An effect with its parameters and runs.
pub fn found(effect: &Found) -> String {
    let name = if let Follows::Mass(driver) = effect.follows {
        attached(driver)
    } else if effect.term.is_some() {
        format!("an unlisted effect that acts on {} and {}", port(effect.port), driver(effect.follows))
    } else {
        plain(&effect.id)
    };
    let sizes: Vec<String> = effect
        .parameters
        .iter()
        .filter(|p| !is_value(p))
        .map(|p| {
            let unit = present::words::unit(p.unit);
            let value = format!("{} {unit}", estimate(p.value, p.ci95));
            format!("{} = {} ({})", p.name, value.trim_end(), interval(p.ci95))
        })
        .collect();
    let runs =
        if effect.everywhere { String::new() } else { format!(" in {} only", list(&effect.runs, "and")) };
    let sizes = if sizes.is_empty() { String::new() } else { format!(", {}", list(&sizes, "and")) };
    format!("{name}{sizes}{runs}")
}

/// The verdict in one sentence, and another one if a large deviation remains where an effect was found: in the fit runs, else in the others.
pub fn verdict(outcome: &Outcome) -> String {
    let sentence = lacks(outcome);
    let is_found = matches!(outcome.verdict, Verdict::Named | Verdict::Class | Verdict::Unexplained);
    let model = if outcome.effects.is_empty() { "fitted" } else { "repaired" };
    let Some((e, ratio)) = outcome.remaining_error().filter(|_| is_found) else { return sentence };
    let error = times_the_noise(e, ratio);
    if e.role == Role::Fit {
        return format!(
            "{sentence} The {model} model does not explain all of it: {error}. Another effect or a mistake in the data remains."
        );
    }
    format!(
        "{sentence} The {model} model explains the fit data, but not the other runs: {error}. What was found does not hold there, or another \
         effect acts in them."
    )
}

fn lacks(outcome: &Outcome) -> String {
    let effects: Vec<String> = outcome.effects.iter().map(found).collect();
    match outcome.verdict {
        Verdict::Named if outcome.unexplained.is_none() => {
            format!("the model lacks {}.", list(&effects, "and"))
        }
        Verdict::Class => {
            // Each effect with its alternatives; an effect without alternatives is no part of the class.
            let classes: Vec<String> = outcome
                .effects
                .iter()
                .map(|e| match &e.alternatives[..] {
                    [] => plain(&e.id),
                    others => {
                        let names: Vec<String> =
                            std::iter::once(&e.id).chain(others).map(|id| plain(id)).collect();
                        format!("one of {}", list(&names, "or"))
                    }
                })
                .collect();
            format!(
                "the model lacks {}; the data do not distinguish them. Added to the model: {}.",
                list(&classes, "and"),
                list(&effects, "and")
            )
        }
        Verdict::Named | Verdict::Unexplained => {
            let listed: Vec<String> =
                outcome.effects.iter().filter(|e| e.term.is_none()).map(found).collect();
            let beside = if outcome.verdict == Verdict::Named {
                "beside that, and explaining less,"
            } else {
                "beside that,"
            };
            match &listed[..] {
                [] => unexplained(outcome),
                listed => {
                    format!("the model lacks {}; {beside} {}", list(listed, "and"), unexplained(outcome))
                }
            }
        }
        Verdict::Fitted => {
            let searched = "the declared parameters were fitted; no missing effect was looked for";
            match left(outcome) {
                Some(error) => {
                    format!("{searched}, and the fitted parameters do not explain the data: {error}.")
                }
                None => format!("{searched}."),
            }
        }
        Verdict::Nothing => nothing(outcome),
    }
}

/// The sentence without an effect: whether the search was cut, and whether the parameters explain the data that were not fitted.
fn nothing(outcome: &Outcome) -> String {
    let effect = match outcome.is_cut {
        true => "the time budget ended the search before an effect was found (--budget sets another one)",
        false => "no missing effect is detected",
    };
    match left(outcome) {
        Some(error) => format!("{effect}, and the fitted parameters do not explain the data: {error}."),
        None => format!("{effect}; other parameter values explain the differences."),
    }
}

/// What the parameters do not explain of the data that show what the model is worth.
fn left(outcome: &Outcome) -> Option<String> {
    outcome.unexplained_error(outcome.unfitted()).map(|(e, ratio)| times_the_noise(e, ratio))
}

/// The error of a channel in the runs of a role.
pub fn error_of(e: &ChannelError) -> String {
    format!("the error of {} on the {} data", column_words(e.column).0, role_words(e.role))
}

fn times_the_noise(e: &ChannelError, ratio: f64) -> String {
    format!("{} is {} times the noise", error_of(e), rough(ratio))
}

/// What is known of a residual that is no function of the drivers.
pub fn undescribed(found: &Unexplained, outcome: &Outcome) -> String {
    let others: Vec<String> = outcome.ports_like(found.port).map(|own| port(own).to_owned()).collect();
    let others = match &others[..] {
        [] => String::new(),
        others => format!(", or about as well of {}", list(others, "or")),
    };
    format!(
        "something is left that is no function of the measured quantities or of their first-order lags, an effect with a memory or a mistake \
         in the data; a change over time of {}{others} describes it best",
        port(found.port)
    )
}

/// The sentence on what no listed effect explains.
fn unexplained(outcome: &Outcome) -> String {
    match &outcome.unexplained {
        Some(u) => {
            let laws: Vec<String> = outcome.effects.iter().filter_map(|e| e.term.as_ref()).map(law).collect();
            let is_undescribed = u.follows == Follows::History;
            let given = if u.added {
                format!("a law was added to the model: {}", list(&laws, "and"))
            } else if laws.is_empty() && is_undescribed {
                "nothing was added for it".to_owned()
            } else if laws.is_empty() {
                "none was added, since it does not lower the validation error".to_owned()
            } else {
                format!("a law that explains part of it was added to the model: {}", list(&laws, "and"))
            };
            let what = match is_undescribed {
                true => undescribed(u, outcome),
                false => {
                    format!(
                        "an effect that is not in the list acts on {} and {}",
                        port(u.port),
                        driver(u.follows)
                    )
                }
            };
            format!("{what}; {given}.")
        }
        None => "the model lacks an effect that is not in the list.".to_owned(),
    }
}

/// The declared parameters before and after, as a table.
pub fn parameters(outcome: &Outcome) -> String {
    if outcome.parameters.is_empty() {
        return String::new();
    }
    let mut text =
        format!("\n{:32} {:>12} {:>12} {:12} 95 % interval\n", "parameter", "before", "after", "unit");
    for p in &outcome.parameters {
        let (before, after, interval) = (number(p.prior), estimate(p.value, p.ci95), interval(p.ci95));
        let unit = present::words::unit(p.unit);
        text += &format!("{:32} {before:>12} {after:>12} {unit:12} {interval}\n", p.name);
    }
    text
}

/// Which headers of the files the columns have that the texts name; `None` where the files have the columns' own names.
pub fn own_headers(experiment: &Experiment, texts: &[&str]) -> Option<String> {
    let named = |column: &str| texts.iter().any(|text| text.contains(column));
    let headers: Vec<String> = experiment
        .headers
        .iter()
        .filter(|(column, header)| column != header && named(column))
        .map(|(column, header)| format!("{column} is the column \"{header}\""))
        .collect();
    (!headers.is_empty()).then(|| format!("in the files, {}", list(&headers, "and")))
}

/// Agreement of the FMUs with the model.
pub fn replay(replay: &Replay) -> String {
    let Some(worst) = replay.channels.iter().max_by(|a, b| a.difference.total_cmp(&b.difference)) else {
        return "no run was replayed with the exported FMUs: no role has a reading".to_owned();
    };
    let relation = if replay.agrees { "within the limit of" } else { "above the limit of" };
    let runs = list(&replay.replayed, "and");
    if replay.greatest_difference == 0.0 {
        return format!(
            "replayed with the exported FMUs: {runs} ({} data); no difference of their RMSE from the model's",
            replay.role
        );
    }
    format!(
        "replayed with the exported FMUs: {runs} ({} data); their RMSE differs from the model's by at most {} of the channel's range ({} in {}), \
         {relation} {:.0e}",
        replay.role,
        rough(replay.greatest_difference),
        column_words(worst.column).0,
        worst.standard,
        replay.limit
    )
}

/// The inputs that have no effect in the modes in which the exported FMUs start, which are those of the experiment; `None` where
/// all have one.
pub fn unused_inputs(kind: &ModelType, starts: &StartValues, terms: &[GenericTerm]) -> Option<String> {
    let found = usage::inputs(kind, starts, &Resources::of_terms(terms));
    let other_modes = usage::other_modes(&found);
    let sentence = usage::sentence(&found, |_| String::new())?;
    Some(format!(
        "the exported FMUs start in the modes of the experiment: {sentence}; set {other_modes} before initialization to use them"
    ))
}

/// Header of residuals.csv.
pub const RESIDUALS: &str = "file,role,channel,time_s,measured,before,refit,after,residual\n";

/// Measured and predicted values of every output and the residual of the model after the repair, as in the figures of the report: a row for
/// each output and time in each role in which the time counts.
pub fn residuals(outcome: &Outcome) -> String {
    let mut text = String::from(RESIDUALS);
    let quoted = |file: &str| format!("\"{}\"", file.replace('"', "\"\""));
    let mut known = HashSet::new();
    for curves in &outcome.curves {
        let (file, role) = (quoted(&curves.file), calibrate::report::role_name(curves.role));
        for curve in &curves.outputs {
            let columns = [&curve.measured, &curve.before, &curve.refit, &curve.after];
            let (from, to) = curves.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            let counts = |time: &f64| (from..=to).contains(time);
            for (k, time) in curves.time.iter().enumerate().filter(|(_, time)| counts(time)) {
                // Windows of a role may share rows.
                if !known.insert((&curves.file, role, curve.column, time.to_bits())) {
                    continue;
                }
                let cell = |x: f64| if x.is_finite() { x.to_string() } else { String::new() };
                let cells = columns.map(|values| cell(values[k])).join(",");
                let residual = cell(curve.measured[k] - curve.after[k]);
                text += &format!("{file},{role},{},{time},{cells},{residual}\n", curve.column);
            }
        }
    }
    text
}
