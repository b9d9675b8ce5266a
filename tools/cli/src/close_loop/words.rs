//! What closing the loop has come to, in plain words.

use calibrate::outcome::{Follows, Found, Outcome, Verdict};
use calibrate::report::Replay;
use describe::{Driver, Port};

/// Where a term acts, as a person calls it.
pub fn port(port: Port) -> &'static str {
    match port {
        Port::DragTorque => "the torque against the motion",
        Port::TerminalVoltage => "the volts lost between terminals and winding",
        Port::WindingResistance => "the winding's resistance",
        Port::TorqueConstant => "the torque constant",
        Port::WindingHeat => "the heat in the winding",
        Port::HousingHeat => "the heat in the housing",
        Port::WindingHousingResistance => "the thermal resistance from winding to housing",
        Port::HousingAmbientConductance => "the heat that the housing gives to its surroundings",
        Port::HeatCapacity => "the heat capacities",
        Port::FanFlow => "the flow of the fan",
        Port::AmbientSensor => "the ambient temperature's sensor",
        Port::WindingSensor => "the winding's temperature sensor",
        Port::HousingSensor => "the housing's temperature sensor",
    }
}

/// What it follows, as what "it" does.
pub fn driver(follows: Follows) -> &'static str {
    match follows {
        Follows::Nothing => "is constant",
        Follows::History => "depends on what was before",
        Follows::Driver(driver) => match driver {
            Driver::Speed => "follows the speed",
            Driver::Current => "follows the current",
            Driver::LoadTorque => "follows the load",
            Driver::WindingTemperature => "follows the winding's temperature",
            Driver::HousingTemperature => "follows the housing's temperature",
            Driver::AmbientTemperature => "follows the ambient temperature",
            Driver::FanCommand => "follows the fan's command",
            Driver::Time => "follows time",
        },
    }
}

/// An id as words: `iron_loss` is iron loss.
pub fn plain(id: &str) -> String {
    id.replace('_', " ")
}

/// A list with a last word before its last item.
pub fn list(items: &[String], last: &str) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., end] => format!("{} {last} {end}", most.join(", ")),
    }
}

/// Four significant digits.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return "-".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let short = |text: &str| {
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text.to_owned()
        }
    };
    if (1e-3..1e5).contains(&size) {
        let digits = (3.0 - size.log10().floor()).max(0.0) as usize;
        return short(&format!("{value:.digits$}"));
    }
    let text = format!("{value:.3e}");
    text.split_once('e').map_or(text.clone(), |(digits, power)| format!("{}e{power}", short(digits)))
}

/// A value with its unit; a pure number has none.
pub fn with_unit(value: f64, unit: &str) -> String {
    if unit == "1" { number(value) } else { format!("{} {unit}", number(value)) }
}

/// The name of what was found, with its size.
pub fn found(effect: &Found) -> String {
    let name = if effect.term.is_some() {
        format!("something that is in no list, acts on {} and {}", port(effect.port), driver(effect.follows))
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
        if effect.everywhere { String::new() } else { format!(" in {} alone", list(&effect.runs, "and")) };
    let sizes = if sizes.is_empty() { String::new() } else { format!(", {}", list(&sizes, "and")) };
    format!("{name}{sizes}{runs}")
}

/// The verdict in one sentence.
pub fn verdict(outcome: &Outcome) -> String {
    let effects: Vec<String> = outcome.effects.iter().map(found).collect();
    match outcome.verdict {
        Verdict::Named => format!("the model lacks {}.", list(&effects, "and")),
        Verdict::Class => {
            let names: Vec<String> = outcome
                .effects
                .iter()
                .flat_map(|e| std::iter::once(&e.id).chain(&e.alternatives))
                .map(|id| plain(id))
                .collect();
            format!(
                "the model lacks one of {}; this data cannot tell them apart. It was given {}.",
                list(&names, "or"),
                list(&effects, "and")
            )
        }
        Verdict::Unexplained => match &outcome.unexplained {
            Some(u) => format!(
                "something acts on {} and {}; it is in no list of effects, and the model was {}.",
                port(u.port),
                driver(u.follows),
                if u.added {
                    "given its shape"
                } else {
                    "not given it, since that does not help where nothing was fitted"
                }
            ),
            None => "the model lacks something that has no name.".to_owned(),
        },
        Verdict::Nothing => {
            "nothing is missing that this data could show; other parameters explain what differs.".to_owned()
        }
    }
}

/// Whether the FMUs show what the report says.
pub fn replay(replay: &Replay) -> String {
    let worst = replay.channels.iter().max_by(|a, b| a.difference.total_cmp(&b.difference));
    let place = worst.map_or(String::new(), |c| format!(" ({} in {})", c.column, c.standard));
    let relation = if replay.agrees { "within the limit of" } else { "above the limit of" };
    format!(
        "the exported FMUs, run over the {} data, show the model's error to {:.1e} of the channel's range{place}, {relation} {:.0e}",
        replay.role, replay.greatest_difference, replay.limit
    )
}
