//! Verdict, effects and replay of closing the loop, as text.

use calibrate::experiment::{Experiment, Role};
use calibrate::outcome::{ChannelError, Follows, Found, Outcome, Verdict};
pub use calibrate::report::words as plain;
use calibrate::report::{Replay, column_words, driver_unit, role_words};
use describe::{Driver, Factor, GenericTerm, Lag, Law, ModelType, Port, Resources, StartValues, usage};
pub use present::number;

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
                    off if off > 0.0 => format!("({} − {})", plain(f.driver.name()), number(off)),
                    off => format!("({} + {})", plain(f.driver.name()), number(-off)),
                };
                format!(" · ({off} / {})^{}", number(f.reference), number(f.exponent))
            });
            let size = with_unit(product.coefficient, term.port.unit().name());
            let ranged = product.factors.iter().flatten().filter(|f| f.range != Factor::UNLIMITED).map(|f| {
                let (least, most) = f.range;
                let most = with_unit(most, driver_unit(f.driver));
                format!("; constant outside {} from {} to {most}", plain(f.driver.name()), number(least))
            });
            let law: String = factors.chain(ranged).collect();
            format!("{} = {size}{law}", plain(term.port.name()))
        }
        Law::Table(table) => {
            let (x, y) = table.points();
            let points: Vec<String> =
                x.iter().zip(y).map(|(x, y)| format!("{} at {}", number(*y), number(*x))).collect();
            format!(
                "a table of {} over {}, held beyond its ends: {}",
                plain(term.port.name()),
                plain(table.driver.name()),
                points.join(", ")
            )
        }
        Law::Grid(grid) => {
            let line = |k: usize| {
                let (points, driver) = (grid.points(k), grid.drivers[k]);
                let last = with_unit(points[points.len() - 1], driver_unit(driver));
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
        .map(|p| {
            format!(
                "{} = {} ({} to {})",
                p.name,
                with_unit(p.value, p.unit),
                number(p.ci95.0),
                number(p.ci95.1)
            )
        })
        .collect();
    let runs =
        if effect.everywhere { String::new() } else { format!(" in {} only", list(&effect.runs, "and")) };
    let sizes = if sizes.is_empty() { String::new() } else { format!(", {}", list(&sizes, "and")) };
    format!("{name}{sizes}{runs}")
}

/// The verdict in one sentence, and a second one if a large deviation remains in the fit runs of a repaired model.
pub fn verdict(outcome: &Outcome) -> String {
    let sentence = lacks(outcome);
    let is_found = matches!(outcome.verdict, Verdict::Named | Verdict::Class | Verdict::Unexplained);
    let model = if outcome.effects.is_empty() { "fitted" } else { "repaired" };
    match is_found.then(|| unexplained_error(outcome, Role::Fit)).flatten() {
        Some(error) => format!(
            "{sentence} The {model} model does not explain all of it: {error}. Another effect or a mistake in the data remains."
        ),
        None => sentence,
    }
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

/// Error over noise up to which parameter values explain the data.
const EXPLAINED: f64 = 2.0;

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

/// What the parameters do not explain of the data that were not fitted: of the test runs, else of the validation runs.
fn left(outcome: &Outcome) -> Option<String> {
    unexplained_error(outcome, unfitted(outcome))
}

/// The role whose runs show what the model is worth.
pub fn unfitted(outcome: &Outcome) -> Role {
    let is_tested = outcome.errors.iter().any(|e| e.role == Role::Test && e.floor > 0.0);
    if is_tested { Role::Test } else { Role::Validate }
}

/// The error of a channel in the runs of a role.
pub fn error_of(e: &ChannelError) -> String {
    format!("the error of {} on the {} data", column_words(e.column).0, role_words(e.role))
}

/// The greatest error of the final model relative to the noise, if it is above [`EXPLAINED`] and the error of good instruments.
fn unexplained_error(outcome: &Outcome, role: Role) -> Option<String> {
    let of = outcome.errors.iter().filter(|e| e.role == role && e.floor > 0.0 && e.after > e.instruments);
    let ratios = of.map(|e| (e, e.after / e.floor)).filter(|(_, ratio)| *ratio > EXPLAINED);
    let (e, ratio) = ratios.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!("{} is {} times the noise", error_of(e), number(ratio)))
}

/// The sentence on what no listed effect explains.
fn unexplained(outcome: &Outcome) -> String {
    match &outcome.unexplained {
        Some(u) => {
            let laws: Vec<String> = outcome.effects.iter().filter_map(|e| e.term.as_ref()).map(law).collect();
            let given = if u.added {
                format!("a law was added to the model: {}", list(&laws, "and"))
            } else if laws.is_empty() {
                "none was added, since it does not lower the validation error".to_owned()
            } else {
                format!("a law that explains part of it was added to the model: {}", list(&laws, "and"))
            };
            format!(
                "an effect that is not in the list acts on {} and {}; {given}.",
                port(u.port),
                driver(u.follows)
            )
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
        let [before, after, low, high] = [p.prior, p.value, p.ci95.0, p.ci95.1].map(number);
        let unit = present::words::unit(p.unit);
        text += &format!("{:32} {before:>12} {after:>12} {unit:12} {low} ... {high}\n", p.name);
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
    format!(
        "replayed with the exported FMUs: {} ({} data); their RMSE differs from the model's by at most {} of the channel's range ({} in {}), \
         {relation} {:.0e}",
        list(&replay.replayed, "and"),
        replay.role,
        number(replay.greatest_difference),
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

/// Measured and predicted values of every output and the residual of the model after the repair, as in the figures of the report: a row for each run, output and time.
pub fn residuals(outcome: &Outcome) -> String {
    let mut text = String::from(RESIDUALS);
    let quoted = |file: &str| format!("\"{}\"", file.replace('"', "\"\""));
    for curves in &outcome.curves {
        let (file, role) = (quoted(&curves.file), calibrate::report::role_name(curves.role));
        for curve in &curves.outputs {
            let columns = [&curve.measured, &curve.before, &curve.refit, &curve.after];
            for (k, time) in curves.time.iter().enumerate() {
                let cell = |x: f64| if x.is_finite() { x.to_string() } else { String::new() };
                let cells = columns.map(|values| cell(values[k])).join(",");
                let residual = cell(curve.measured[k] - curve.after[k]);
                text += &format!("{file},{role},{},{time},{cells},{residual}\n", curve.column);
            }
        }
    }
    text
}
