//! `motor-fmu steady --load`: a motor under the periodic load of a gait.

use super::{SteadyArgs, rounded};
use crate::progress::Progress;
use crate::{Failure, drawing};
use ::study::reproduce::significant;
use ::study::walk::{Load, Periodic, check_hours, continuous_support, walk};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Title of the figure.
const TITLE: &str = "Winding temperature";

/// Part of the computing time that the way to the steady state takes; the search for the continuous support takes the rest.
const WAY: f64 = 0.25;

pub fn run(args: &SteadyArgs, file: &Path) -> Result<ExitCode, Failure> {
    let load = args.start.load(file)?;
    let is_title = |title: &str| title.starts_with(TITLE);
    drawing::check(args.plot.as_deref(), args.force, "a figure of steady --load", is_title)?;
    check_hours(args.load.hours)?;
    let bar = Progress::new("periodic steady state, time to the limit, continuous torque");
    let (way, search) = (AtomicU32::new(0), AtomicU32::new(0));
    // Thousandths of each part. A failure ends its part, too.
    let done = |part: &AtomicU32, fraction: f64| {
        part.store((1000.0 * fraction) as u32, Relaxed);
        let [way, search] = [&way, &search].map(|part| f64::from(part.load(Relaxed)) / 1000.0);
        bar.at(WAY * way + (1.0 - WAY) * search);
    };
    let (walked, continuous) = rayon::join(
        || {
            let walked = walk(&load, args.load.hours, &|fraction| done(&way, fraction));
            done(&way, 1.0);
            walked
        },
        || {
            let continuous = continuous_support(&load, &|fraction| done(&search, fraction));
            done(&search, 1.0);
            continuous
        },
    );
    bar.finish();
    let walked = walked?;
    if let Some(path) = &args.plot {
        drawing::write(path, &walked.figure(&format!("{TITLE}. {}", load.source()?)).svg())?;
    }
    let (source, derived) = (load.source()?, load.derived()?);
    let notes = load.notes()?;
    crate::remark(&notes);
    if args.json {
        let result = json!({
            "gait": source,
            "derived": derived,
            "stride_time": walked.stride_time,
            "limit": walked.limit,
            "forever": walked.forever,
            "at_limit": walked.at_limit,
            "time_to_limit": walked.envelope.time_to_limit,
            "envelope": walked.envelope.points,
            "continuous": continuous.as_ref().ok(),
            "no_continuous_torque": continuous.as_ref().err().map(ToString::to_string),
            "mass": load.mass()?,
            "notes": notes,
        });
        crate::say_json(&result)?;
        return Ok(ExitCode::SUCCESS);
    }
    let words = load.words();
    let mut text = format!("load: {source}\n");
    if !derived.is_empty() {
        let values = derived.iter().map(|d| format!("{} = {} {}", d.name, significant(d.value), d.unit));
        text += &format!("derived from the motor: {}\n", values.collect::<Vec<_>>().join(", "));
    }
    text += &supply(&load)?;
    let limit = format!("{:.2} K ({:.2} degC)", walked.limit, walked.limit - 273.15);
    text += &match (&walked.forever, &walked.at_limit) {
        (Some(periodic), _) => {
            format!(
                "periodic steady state, {} {:.3} s\n{}",
                words.period,
                walked.stride_time,
                lines(periodic)
            )
        }
        (None, Some(at)) => format!(
            "thermal runaway: no periodic steady state; {} of {:.3} s at the winding's limit\n{}",
            words.period,
            walked.stride_time,
            lines(at)
        ),
        (None, None) => "thermal runaway: no periodic steady state\n".to_owned(),
    };
    text += &match walked.envelope.time_to_limit {
        Some(time) => format!("time to the winding's limit of {limit}: {:.1} min\n", time / 60.0),
        None => format!("the winding stays below its limit of {limit} for {} h\n", args.load.hours),
    };
    text += &match continuous {
        Ok(c) => format!(
            "continuous {} {} {}{}, peak {} N.m at the {}; limited by {}\n",
            words.factor[0],
            significant(c.support),
            words.factor[1],
            // The name of the same number in sweep.
            if words.factor[0] == "support" { "" } else { " (continuous_support)" },
            significant(c.at.joint_torque_peak),
            words.place,
            c.limited_by.text()
        ),
        Err(reason) => format!("{reason}\n"),
    };
    crate::say(&text);
    Ok(ExitCode::SUCCESS)
}

/// A line where the supply voltage is that of the declaration, which belongs to another motor.
fn supply(load: &Load) -> Result<String, Failure> {
    let Some(voltage) = load.default_supply()? else { return Ok(String::new()) };
    Ok(format!(
        "supply_voltage = {} V is the default of the actuator; --set supply_voltage or the table [actuator] changes it\n",
        significant(voltage)
    ))
}

fn lines(p: &Periodic) -> String {
    let celsius = |kelvin: f64| format!("K  ({:.2} degC)", kelvin - 273.15);
    let rows = [
        ("winding_temperature, peak", p.winding_temperature, celsius(p.winding_temperature)),
        ("winding_temperature, mean", p.winding_temperature_mean, celsius(p.winding_temperature_mean)),
        ("current, rms", p.current_rms, "A".into()),
        ("current, peak", p.current_peak, "A".into()),
        ("joint_torque, peak", p.joint_torque_peak, "N.m".into()),
        ("torque_error, rms", p.torque_error_rms, "N.m".into()),
        ("power_electrical, mean", p.power_electrical, "W".into()),
        ("joint_power, mean", p.power_joint, "W".into()),
        ("supply_power, mean", p.power_supply, "W".into()),
    ];
    let voltage = p.voltage_peak.map(|voltage| ("voltage, peak", voltage, "V".to_owned()));
    let line =
        |(name, value, unit): &(&str, f64, String)| format!("  {name:30} {:>12} {unit}\n", rounded(*value));
    rows.iter().chain(&voltage).map(line).collect()
}
