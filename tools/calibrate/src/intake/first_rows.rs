//! First readings of a run that starts warm, from before a thermometer or the logger worked.
//!
//! Such a run starts at the temperatures that its first rows show, so that a prediction follows them, whatever they are. The rows before a
//! jump are therefore left out of the estimate of the start ([`crate::initial`]), and compared with what it then says of them:
//!
//! |y - f| > c g s sqrt(1 + S (N + e^2)^-1 S^T)                                              (1)
//!
//! y reading, f prediction, S its response to the start, N the sum of S^T S over the rows of the estimate, e its ridge, g the structure error
//! as a fraction of s, the spread of the temperatures. A winding that has forgotten its start by the next row may have had any; a housing has
//! not.
//! *Source*: prediction error of a linear regression, Weisberg, Applied Linear Regression, 4th ed. (2014), sec. 3.5 (1), 9.2 (outliers).

use super::signals::jumps;
use super::{median, range};
use crate::CalibrateError;
use crate::experiment::{Experiment, Start};
use crate::initial::PART;
use crate::levels::CERTAIN;
use crate::overrides::Override;
use crate::simulate::{Bench, Drive};

/// Sets aside first readings that contradict those after a jump, with a note.
pub fn set_aside(experiment: &mut Experiment, preset: &[(u32, f64)]) -> Result<(), CalibrateError> {
    let bench = Bench::new(experiment, preset)?;
    for r in 0..experiment.runs.len() {
        if experiment.runs[r].start == Start::Measured {
            in_run(experiment, &bench, r);
        }
    }
    Ok(())
}

fn in_run(experiment: &mut Experiment, bench: &Bench, r: usize) {
    let inputs = experiment.inputs.len();
    let columns = &experiment.runs[r].table.columns;
    let early = |column: &[f64]| jumps(column).into_iter().rfind(|row| *row < column.len() / PART);
    let nodes = experiment.outputs.iter().enumerate().filter(|(_, channel)| channel.node().is_some());
    let leading: Vec<(usize, usize)> =
        nodes.filter_map(|(k, _)| Some((k, early(&columns[inputs + k])?))).collect();
    if leading.is_empty() {
        return;
    }
    let mut other = experiment.clone();
    let blank = &mut other.runs[r].table.columns;
    leading.iter().for_each(|(k, rows)| blank[inputs + k][..*rows].fill(f64::NAN));
    let channels = experiment.inputs.iter().chain(&experiment.outputs).zip(&*blank);
    let warm = channels.filter(|(channel, _)| channel.is_temperature());
    let spread = range(warm.flat_map(|(_, column)| column.iter().copied()));
    // A run that cannot be simulated is judged by the checks that follow.
    let Ok(drive) = Drive::new(&other, &other.runs[r]) else { return };
    let Ok(Some(foretold)) = bench.foretold(&drive, &Override::default()) else { return };
    for (k, rows) in leading {
        let Some((_, said)) = foretold.iter().find(|(output, _)| *output == k) else { continue };
        let run = &mut experiment.runs[r];
        let read = &mut run.table.columns[inputs + k][..rows];
        let off = |(y, (mean, deviation)): (&f64, &(f64, f64))| (y - mean).abs() / (spread * deviation);
        if median(read.iter().zip(said).map(off).filter(|z| z.is_finite())) > CERTAIN {
            read.fill(f64::NAN);
            let (file, channel) = (&run.file, experiment.outputs[k].column);
            experiment.notes.push(format!(
                "{file}: what {channel} reads before a jump, in {rows} of the first rows, contradicts what it reads then; it is set aside"
            ));
        }
    }
}

#[cfg(test)]
mod tests;
