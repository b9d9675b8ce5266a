//! `motor-fmu steady --load`: a motor under the periodic load of a gait.

use super::{SteadyArgs, rounded};
use crate::progress::Progress;
use crate::{Failure, drawing};
use ::study::reproduce::significant;
use ::study::walk::{Periodic, Walked, check_hours, continuous_support, walk};
use present::figure::{Axis, Figure};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Title of the figure.
const TITLE: &str = "Winding temperature";

pub fn run(args: &SteadyArgs, file: &Path) -> Result<ExitCode, Failure> {
    let load = args.start.load(file)?;
    let is_title = |title: &str| title.starts_with(TITLE);
    drawing::check(args.plot.as_deref(), args.force, "a figure of steady --load", is_title)?;
    check_hours(args.load.hours)?;
    let bar = Progress::new("periodic steady state, time to the limit, continuous torque");
    let (way, search) = (AtomicU32::new(0), AtomicU32::new(0));
    // Thousandths of each half.
    let done = |part: &AtomicU32, fraction: f64| {
        part.store((1000.0 * fraction) as u32, Relaxed);
        bar.at(f64::from(way.load(Relaxed) + search.load(Relaxed)) / 2000.0);
    };
    let (walked, continuous) = rayon::join(
        || walk(&load, args.load.hours, &|fraction| done(&way, fraction)),
        || continuous_support(&load, &|fraction| done(&search, fraction)),
    );
    bar.finish();
    let walked = walked?;
    if let Some(path) = &args.plot {
        drawing::write(path, &figure(&walked, &load.source()?).svg())?;
    }
    let (source, derived) = (load.source()?, load.derived()?);
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
            "continuous {} {} {}, peak {} N.m at the {}; limited by {}\n",
            words.factor[0],
            significant(c.support),
            words.factor[1],
            significant(c.at.joint_torque_peak),
            words.place,
            c.limited_by.text()
        ),
        Err(reason) => format!("{reason}\n"),
    };
    crate::say(&text);
    Ok(ExitCode::SUCCESS)
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

fn figure(walked: &Walked, source: &str) -> Figure {
    let points: Vec<(f64, f64)> =
        walked.envelope.points.iter().map(|p| (p.time / 60.0, p.winding_temperature - 273.15)).collect();
    let limit = walked.limit - 273.15;
    Figure::new(
        &format!("{TITLE}. {source}"),
        Axis::new("time in min"),
        Axis::new("peak winding temperature in °C"),
    )
    .line("winding", points)
    .limit(limit, "limit")
}
