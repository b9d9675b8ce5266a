//! A joint of a walking person as the load: the winding over hours, and the continuous support.

use crate::Answer;
use crate::choice::{Choice, Gait, ZERO_CELSIUS};
use crate::heating::duration;
use present::number;
use present::words::sentence;
use study::StudyError;
use study::walk::{Load, continuous_support, walk};

/// Motor, actuator and gait of a choice.
///
/// # Errors
/// One sentence naming variable, value and limits.
pub fn load(choice: &Choice, gait: &Gait) -> Result<Load, StudyError> {
    let mut sets = choice.ambient();
    let number = |name: &str, value: f64| (name.to_owned(), value.to_string());
    sets.extend([
        ("drive_mode".to_owned(), "current".to_owned()),
        ("gait.activity".to_owned(), gait.activity.clone()),
        ("gait.joint".to_owned(), gait.joint.clone()),
        number("gait.body_mass", gait.body_mass),
        number("gait.support", gait.support),
        number("transmission.ratio", gait.ratio),
        number("spring.stiffness", gait.stiffness),
        number("supply_voltage", choice.voltage),
    ]);
    Load::parse("", "page", Some(&choice.preset()?), &sets)
}

/// Figure, sentences and values.
pub fn answer(choice: &Choice, gait: &Gait) -> Result<Answer, StudyError> {
    let load = load(choice, gait)?;
    let found = walk(&load, choice.minutes / 60.0, &|_| ())?;
    let limit = found.limit - ZERO_CELSIUS;
    let mut figure = found.figure("Winding temperature");
    let mut text = match (found.envelope.time_to_limit, &found.forever) {
        (Some(time), _) => {
            figure = figure.note(time / 60.0, &duration(time));
            format!("The winding reaches its limit of {} °C after {}.", number(limit), duration(time))
        }
        (None, Some(stride)) => format!(
            "The winding stays below its limit of {} °C; in the periodic steady state it reaches {} °C, the supply power is {} W.",
            number(limit),
            number(stride.winding_temperature - ZERO_CELSIUS),
            number(stride.power_supply)
        ),
        (None, None) => {
            "There is no periodic steady state: thermal runaway after the end of the curve.".to_owned()
        }
    };
    let continuous = match continuous_support(&load, &|_| ()) {
        Ok(continuous) => {
            text += &format!(
                " Continuous support: {} % of the biological torque, peak {} N·m, limited by {}.",
                number(100.0 * continuous.support),
                number(continuous.at.joint_torque_peak),
                continuous.limited_by.text()
            );
            Some(continuous)
        }
        Err(reason) => {
            text += &format!(" There is {}.", sentence(&reason.to_string()));
            None
        }
    };
    text += &format!(" Gait: {}.", load.source()?.trim_end_matches('.'));
    Ok(Answer::new(&figure, text, &serde_json::json!({ "walk": found, "continuous": continuous })))
}
