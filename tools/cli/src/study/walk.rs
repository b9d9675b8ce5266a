//! `motor-fmu steady --load`: a motor that walks.

use super::{SteadyArgs, rounded, write};
use crate::Failure;
use ::study::figure::{Axis, Figure};
use ::study::reproduce::significant;
use ::study::walk::{Forever, Walked, continuous_support, walk};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

/// Runs `steady --load`.
pub fn run(args: &SteadyArgs, file: &Path) -> Result<ExitCode, Failure> {
    let load = args.start.load(file)?;
    let walked = walk(&load, args.load.hours)?;
    let continuous = continuous_support(&load);
    if let Some(path) = &args.plot {
        write(path, &figure(&walked).svg())?;
    }
    if args.json {
        let result = json!({
            "stride_time": walked.stride_time,
            "limit": walked.limit,
            "forever": walked.forever,
            "time_to_limit": walked.envelope.time_to_limit,
            "envelope": walked.envelope.points,
            "continuous": continuous.as_ref().ok().map(|(support, at)| json!({"support": support, "at": at})),
            "no_continuous_torque": continuous.as_ref().err().map(ToString::to_string),
            "mass": load.mass()?,
        });
        crate::say(&format!("{}\n", serde_json::to_string_pretty(&result)?));
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = match &walked.forever {
        Some(forever) => {
            format!("walking for ever, strides of {:.3} s\n{}", walked.stride_time, lines(forever))
        }
        None => "walking on and on, the winding runs away\n".to_owned(),
    };
    let limit = format!("its limit of {:.2} K ({:.2} degC)", walked.limit, walked.limit - 273.15);
    text += &match walked.envelope.time_to_limit {
        Some(time) => format!("the winding passes {limit} after {:.1} min\n", time / 60.0),
        None => format!("in {} h the winding does not pass {limit}\n", args.load.hours),
    };
    text += &match continuous {
        Ok((support, at)) => format!(
            "for ever {} of the biological torque can be given, {} N.m at the joint\n",
            significant(support),
            significant(at.joint_torque_peak)
        ),
        Err(reason) => format!("{reason}\n"),
    };
    crate::say(&text);
    Ok(ExitCode::SUCCESS)
}

fn lines(f: &Forever) -> String {
    let celsius = |kelvin: f64| format!("K  ({:.2} degC)", kelvin - 273.15);
    let rows = [
        ("winding_temperature", f.winding_temperature, celsius(f.winding_temperature)),
        ("winding_temperature, mean", f.winding_temperature_mean, celsius(f.winding_temperature_mean)),
        ("current, rms", f.current_rms, "A".into()),
        ("current, peak", f.current_peak, "A".into()),
        ("joint_torque, peak", f.joint_torque_peak, "N.m".into()),
        ("torque_error, rms", f.torque_error_rms, "N.m".into()),
        ("power_electrical, mean", f.power_electrical, "W".into()),
        ("joint_power, mean", f.power_joint, "W".into()),
        ("supply_power, mean", f.power_supply, "W".into()),
    ];
    rows.iter().map(|(name, value, unit)| format!("  {name:30} {:>12} {unit}\n", rounded(*value))).collect()
}

fn figure(walked: &Walked) -> Figure {
    let points: Vec<(f64, f64)> =
        walked.envelope.points.iter().map(|p| (p.time / 60.0, p.winding_temperature - 273.15)).collect();
    let end = points.last().map_or(1.0, |p| p.0);
    let limit = walked.limit - 273.15;
    Figure::new(
        "The winding while walking",
        Axis::new("time in min"),
        Axis::new("greatest winding_temperature of a stride in °C"),
    )
    .line("winding", points)
    .dashed("limit", vec![(0.0, limit), (end, limit)])
}
