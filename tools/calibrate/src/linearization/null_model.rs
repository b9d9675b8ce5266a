//! The null model of a linearised model: residual, parameters, zero offsets and drift of the sensors, noise of the inputs.

use super::INSEPARABLE;
use crate::CalibrateError;
use crate::evidence::{Evidence, Prior, Series};
use crate::experiment::Channel;
use crate::fit::{Fitted, Slopes};
use crate::hypothesis::hat;
use crate::levels::CALIBRATED;
use crate::parallel;
use crate::setup::Setup;
use nalgebra::{DMatrix, DVector};

/// Shortest distance between the knots of a sensor's drift, s. Derivation: about half of the shortest correlation time of a drift, 2000
/// s.
const KNOT: f64 = 900.0;
/// Greatest number of such knots over all runs. Numerical: longer experiments resolve slower drifts only.
const MOST_KNOTS: usize = 24;

/// Residual of a fitted model with the columns that may already explain it: its own parameters, drifting sensors, and the error of
/// the first ambient reading, at which all nodes start.
pub(super) fn evidence(
    setup: &Setup,
    fitted: &Fitted,
    runs: &[usize],
    slopes: &Slopes,
    further: usize,
    before_inputs: usize,
) -> Result<Evidence, CalibrateError> {
    let blocks: usize = runs.iter().map(|r| setup.blocks[*r].len()).sum();
    let mut residual = Vec::with_capacity(blocks);
    for (r, run) in runs.iter().enumerate() {
        setup.residual(*run, &fitted.shown[r], &mut residual);
    }
    let gather = |answer: &(dyn Fn(usize) -> Option<Vec<f64>> + Sync)| -> Vec<f64> {
        let mut all = Vec::with_capacity(blocks);
        for (r, run) in runs.iter().enumerate() {
            match answer(r) {
                Some(values) => setup.means(*run, &values, &mut all),
                None => all.extend(setup.blocks[*run].iter().map(|_| 0.0)),
            }
        }
        all
    };
    // Parameters of the model.
    let mut apart: Vec<f64> = setup
        .declared
        .iter()
        .zip(&fitted.hypothesis.declared)
        .map(|(d, value)| (value - d.prior) / d.deviation)
        .collect();
    let added = fitted.hypothesis.additions.iter().flat_map(|a| a.numbers.iter().filter(|n| n.sloped));
    let scales: Vec<f64> = setup.declared.iter().map(|d| d.deviation).chain(added.map(|n| n.scale)).collect();
    let mut columns = parallel::indices(slopes.count(), |k| {
        let mut column = gather(&|r| slopes.answer(&fitted.hypothesis, r, k));
        column.iter_mut().for_each(|x| *x *= scales[k]);
        column
    });
    apart.resize(columns.len(), f64::NAN);
    // Initial temperatures, run by run.
    let ambient = setup.experiment.inputs.iter().position(|c| c.is_temperature());
    if let Some(ambient) = ambient {
        for own in 0..runs.len() {
            let noise = setup.noise[ambient];
            let column = gather(&|r| {
                let direction = slopes.further(r, further)[before_inputs + ambient].as_ref()?;
                let first = |row: usize| if row == 0 { noise } else { 0.0 };
                (r == own).then(|| slopes.tangents[r].response(direction, first))
            });
            columns.push(column);
            apart.push(0.0);
        }
    }
    let clock = |r: usize| &setup.drives[runs[r]].time;
    let (from, to) = (0..runs.len()).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), r| {
        let t = clock(r);
        (a.min(t[0]), b.max(t[t.len() - 1]))
    });
    let count = (((to - from) / KNOT).ceil() as usize).clamp(1, MOST_KNOTS) + 1;
    let points: Vec<f64> = (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64).collect();
    // Zero offsets of sensors of outputs and inputs; those of thermometers at the motor differ from run to run.
    let m = setup.outputs();
    let inputs = setup.experiment.inputs.len();
    let all = || setup.experiment.inputs.iter().chain(&setup.experiment.outputs).enumerate();
    for (channel, _) in all().filter(|(k, c)| setup.noise[*k] > 0.0 && (!c.is_temperature() || *k >= inputs))
    {
        let size = CALIBRATED * setup.noise[channel];
        let moves = channel >= inputs && setup.experiment.outputs[channel - inputs].is_temperature();
        for own in if moves { (0..runs.len()).map(Some).collect() } else { vec![None] } {
            let column = gather(&|r| {
                if channel < inputs {
                    let direction = slopes.further(r, further)[before_inputs + channel].as_ref()?;
                    return Some(slopes.tangents[r].response(direction, |_| size));
                }
                own.is_none_or(|own| own == r).then(|| {
                    let mut values = vec![0.0; clock(r).len() * m];
                    values.iter_mut().skip(channel - inputs).step_by(m).for_each(|v| *v = size);
                    values
                })
            });
            columns.push(column);
            apart.push(0.0);
        }
    }
    // Input noise stored in heat capacities: white noise, combined between knots.
    for input in &setup.remembered {
        for (k, point) in points.iter().enumerate() {
            let column = gather(&|r| {
                let direction = slopes.further(r, further)[before_inputs + input].as_ref()?;
                let time = clock(r);
                let row = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
                let apart = (to - from) / (count - 1) as f64;
                let size = setup.noise[*input] * (row / apart.max(row)).sqrt();
                let reached = time[0] < point + apart && time[time.len() - 1] > point - apart;
                reached
                    .then(|| slopes.tangents[r].response(direction, |row| size * hat(&points, k, time[row])))
            });
            if column.iter().any(|x| *x != 0.0) {
                columns.push(column);
                apart.push(0.0);
            }
        }
    }
    let known = columns.len();
    // Responses to drifting sensors of the outputs and of the ambient temperature: thermometers are of the same kind and have the same
    // drift, up to the noise of the noisiest one.
    let thermometers = all().filter(|(k, c)| c.is_temperature() && *k >= inputs).map(|(k, _)| setup.noise[k]);
    let loudest = thermometers.fold(0.0, f64::max);
    let mut knots = Vec::new();
    let drifts = |k: usize, c: &Channel| setup.noise[k] > 0.0 && (k >= inputs || c.is_temperature());
    for (sensor, channel) in all().filter(|(k, c)| drifts(*k, c)) {
        let size = if channel.is_temperature() { loudest } else { setup.noise[sensor] };
        for (k, point) in points.iter().enumerate() {
            let column = gather(&|r| {
                let time = clock(r);
                if sensor < inputs {
                    let direction = slopes.further(r, further)[before_inputs + sensor].as_ref()?;
                    return Some(
                        slopes.tangents[r].response(direction, |row| size * hat(&points, k, time[row])),
                    );
                }
                let mut values = vec![0.0; time.len() * m];
                for (row, t) in time.iter().enumerate() {
                    values[row * m + sensor - inputs] = size * hat(&points, k, *t);
                }
                Some(values)
            });
            if column.iter().any(|x| *x != 0.0) {
                columns.push(column);
                knots.push((*point, sensor));
            }
        }
    }
    let matrix = |columns: &[Vec<f64>]| {
        DMatrix::from_iterator(blocks, columns.len(), columns.iter().flatten().copied())
    };
    let (slopes, drift) = (matrix(&columns[..known]), matrix(&columns[known..]));
    // Neighbours in time of one output in one run.
    let mut series: Vec<Series> = Vec::new();
    let mut last = None;
    for (k, (run, block)) in
        runs.iter().flat_map(|r| setup.blocks[*r].iter().map(move |b| (r, b))).enumerate()
    {
        match series.last_mut().filter(|_| last == Some((run, block.output))) {
            Some(own) => own.values.end = k + 1,
            None => series.push(Series { output: block.output, values: k..k + 1 }),
        }
        last = Some((run, block.output));
    }
    let mut prior = Prior::new(&apart);
    for (place, values, precision) in fitted.hypothesis.priors() {
        prior.table(place, &values, precision, &scales[place..]);
    }
    Evidence::new(DVector::from_vec(residual), &slopes, prior, &drift, &knots, series)
        .ok_or_else(|| CalibrateError(INSEPARABLE.to_string()))
}
