//! Noise of a channel.
//!
//! e_k = y_k - [(t_{k+1} - t_k) y_{k-1} + (t_k - t_{k-1}) y_{k+1}] / (t_{k+1} - t_{k-1})              (1)
//! sigma = 1.4826 median |e_k| / sqrt(1 + a^2 + b^2),   a and b the two weights in (1)                (2)
//!
//! Deviation of a row from the line between its neighbours: for a quantity that changes slowly compared with the rows, only noise remains.
//! The median is insensitive to the few rows at which an input steps.
//! quantised: q^2 / 12,   q the quantization step of a channel                                             (3)
//!
//! A load that alternates from row to row is no noise, but (2) cannot tell: `input_noise.rs` lowers the estimates to what the residual of the
//! model has.
//!
//! *Assumes* white noise; for slowly drifting noise (2) gives 0, and [`LEAST`] is used instead. Quantization (3) by a converter or a
//! display also gives 0 in (2) if it is coarser than the noise; if it is finer, (2) includes it. The greater of both is therefore used. A
//! stated noise is that of the sensor alone; (3) is added to it.
//! *Source*: Gasser, Sroka, Jennen-Steinmetz, Biometrika 73 (1986) 625-633; 1.4826 makes the median of a normal
//! distribution its standard deviation. (3): Widrow, IRE Transactions on Circuit Theory 3 (1956) 266-276.

mod held;

use crate::experiment::{Channel, Experiment};
use crate::levels::{NEARLY, STRUCTURE};
pub use held::{held, repeated};

/// Lower limit of the noise, as a fraction of the channel's span. Numerical: accuracy of a simulation.
const LEAST: f64 = 1e-5;

/// Most rows for which a slower sensor holds a reading. Tuned: longer plateaus are commanded.
pub const LONGEST: usize = 20;
/// Fewest changes between rows for estimating a quantization step. Derivation: 4 % of the changes of a continuous quantity are
/// multiples of a step within [`ON_STEP`]; of 20, nearly all are with a probability of 1e-23.
const MOVES: usize = 20;
/// Quantile of the changes at which the step is read. Numerical: for quantised noise all low quantiles are the step itself, for
/// continuous noise they are nearly zero.
const FIRST: f64 = 0.02;
/// Tolerance of a change as a multiple of the step. Numerical: rounding of the readings in a file.
const ON_STEP: f64 = 0.02;
/// A channel with fewer steps in its span is commanded (a fan on and off, a staircase of speeds) and therefore exact. Derivation: a
/// coarser sensor could not resolve the structure error of the model.
const STEPS: f64 = 1.0 / STRUCTURE;
/// Coarsest thermometer, K. Limit: displays resolve at least 1 K; a temperature is never commanded, so few steps are sufficient.
const COARSEST: f64 = 1.0;
/// Standard deviation of a normal distribution relative to the median of its magnitude. Definition: 1 / 0.67449, with the upper
/// quartile.
const NORMAL: f64 = 1.4826;
/// Rounding of a reading, relative to it. Numerical: 16 digits.
const ROUNDING: f64 = 1e-12;
/// Least reading for rounding, in SI units. Numerical: a smaller one is zero.
const ZERO: f64 = 1e-3;

/// Quantization step of a quantity; `None` if it is continuous, nearly constant, or commanded. The decimals of a file also form a step,
/// however small.
fn step<'a>(columns: impl Iterator<Item = &'a [f64]>, is_temperature: bool) -> Option<f64> {
    let (mut moves, mut least, mut most) = (Vec::new(), f64::INFINITY, f64::NEG_INFINITY);
    for column in columns {
        let known: Vec<f64> = column.iter().copied().filter(|v| v.is_finite()).collect();
        (least, most) = known.iter().fold((least, most), |(a, b), v| (a.min(*v), b.max(*v)));
        let sizes = known.windows(2).map(|pair| ((pair[1] - pair[0]).abs(), pair[0].abs().max(ZERO)));
        // Rounding errors of equal readings are not changes.
        moves.extend(sizes.filter(|(size, of)| *size > ROUNDING * of).map(|(size, _)| size));
    }
    if moves.len() < MOVES {
        return None;
    }
    moves.sort_by(f64::total_cmp);
    let step = moves[(FIRST * moves.len() as f64) as usize];
    let on = |size: &&f64| (*size / step - (*size / step).round()).abs() <= ON_STEP;
    let all = moves.iter().filter(on).count() as f64 >= NEARLY * moves.len() as f64;
    let measured = most - least >= STEPS * step || (is_temperature && step <= COARSEST);
    (all && measured).then_some(step)
}

/// Standard deviation of the noise of one column of one run; `None` with fewer than five readings. Rows that a slower sensor leaves blank
/// are ignored; if readings are repeated for a constant number of rows, only new readings count.
pub fn of_column(time: &[f64], column: &[f64]) -> Option<f64> {
    let known: Vec<(f64, f64)> =
        time.iter().copied().zip(column.iter().copied()).filter(|(_, v)| v.is_finite()).collect();
    let sigma = of_readings(&known)?;
    if sigma > 0.0 {
        return Some(sigma);
    }
    let (time, values): (Vec<f64>, Vec<f64>) = known.iter().copied().unzip();
    let Some(held) = held(&time, &values, LONGEST) else { return Some(0.0) };
    let new: Vec<(f64, f64)> = known.iter().zip(held).filter(|(_, held)| !held).map(|(r, _)| *r).collect();
    of_readings(&new).or(Some(0.0))
}

/// Whether nearly all readings of a column differ from the one before: neither held by a slower sensor nor coarsely quantised.
pub fn is_new_in_every_row(column: &[f64]) -> bool {
    let known: Vec<f64> = column.iter().copied().filter(|v| v.is_finite()).collect();
    let new = known.windows(2).filter(|pair| pair[0] != pair[1]).count();
    new as f64 > NEARLY * known.len() as f64
}

/// Eq. (2).
fn of_readings(known: &[(f64, f64)]) -> Option<f64> {
    let mut sizes: Vec<f64> = known
        .windows(3)
        .map(|w| {
            let [(t0, y0), (t1, y1), (t2, y2)] = [w[0], w[1], w[2]];
            let (a, b) = ((t2 - t1) / (t2 - t0), (t1 - t0) / (t2 - t0));
            (y1 - a * y0 - b * y2).abs() / (1.0 + a * a + b * b).sqrt()
        })
        .collect();
    if sizes.len() < 3 {
        return None;
    }
    sizes.sort_by(f64::total_cmp);
    Some(NORMAL * sizes[sizes.len() / 2])
}

/// Whether the experiment states the noise of a channel.
pub fn is_stated(experiment: &Experiment, channel: &Channel) -> bool {
    experiment.noise.get(channel.column).is_some_and(|told| *told > 0.0)
}

/// Quantization noise of the `n`-th channel, inputs first; 0 if its readings are continuous.
pub fn quantised(experiment: &Experiment, n: usize, channel: &Channel) -> f64 {
    let columns = experiment.runs.iter().map(|r| r.table.columns[n].as_slice());
    step(columns, channel.is_temperature()).unwrap_or(0.0) / 12f64.sqrt()
}

/// Lower limit of the estimated noise of the `n`-th channel, inputs first: from quantization and the accuracy of a simulation.
pub fn least(experiment: &Experiment, n: usize, channel: &Channel) -> f64 {
    let values = || experiment.runs.iter().flat_map(|r| r.table.columns[n].iter().copied());
    let (low, high) = values()
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let span = high - low;
    let least = if span.is_finite() { (LEAST * span).max(ROUNDING) } else { 1.0 };
    least.max(quantised(experiment, n, channel))
}

/// Standard deviations of all channels, inputs first, in SI units: as stated in the experiment, otherwise that of its runs
/// ([`of_columns`]); including quantization.
pub fn of_experiment(experiment: &Experiment) -> Vec<f64> {
    let channels = experiment.inputs.iter().chain(&experiment.outputs);
    channels
        .enumerate()
        .map(|(n, channel)| {
            if is_stated(experiment, channel) {
                return experiment.noise[channel.column].hypot(quantised(experiment, n, channel));
            }
            let least = least(experiment, n, channel);
            of_runs(experiment, n, channel).unwrap_or(least).max(least)
        })
        .collect()
}

/// Noise of the `n`-th channel, inputs first, in the runs of an experiment ([`of_columns`]).
pub fn of_runs(experiment: &Experiment, n: usize, channel: &Channel) -> Option<f64> {
    let columns = experiment.runs.iter().map(|r| (r.table.time.as_slice(), r.table.columns[n].as_slice()));
    of_columns(columns, channel.is_temperature())
}

/// Noise of a channel in several runs, from columns with their times: of a temperature the median of [`of_column`], because its noise may
/// differ between runs, for example in moving air. Of other channels, which a load may change from row to row, the lower quartile of the
/// values that are not 0 (0 if most are): such a load only increases (2), and at rest some channels have no noise.
pub fn of_columns<'a>(
    columns: impl Iterator<Item = (&'a [f64], &'a [f64])>,
    is_temperature: bool,
) -> Option<f64> {
    let mut all: Vec<f64> = columns.filter_map(|(time, column)| of_column(time, column)).collect();
    all.sort_by(f64::total_cmp);
    let median = *all.get(all.len() / 2)?;
    if is_temperature || median == 0.0 {
        return Some(median);
    }
    all.retain(|sigma| *sigma > 0.0);
    all.get((all.len() - 1) / 4).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{normal, rng};
    use rand::RngExt;
    use rand_pcg::Pcg64Mcg;

    /// Slow wave with noise of standard deviation 0.2, rows at uneven times.
    #[test]
    fn noise_on_a_slow_wave() {
        let mut rng = rng(1);
        let time: Vec<f64> = (0..4000).map(|k| 2.0 * f64::from(k) + 0.5 * rng.random::<f64>()).collect();
        let column: Vec<f64> =
            time.iter().map(|t| 40.0 * (t / 800.0).sin() + 0.2 * normal(&mut rng)).collect();
        let sigma = of_column(&time, &column).unwrap();
        assert!((sigma / 0.2 - 1.0).abs() < 0.05, "{sigma}");
        assert_eq!(of_column(&time[..4], &column[..4]), None);
    }

    /// Of four runs two have a load that changes in every row, or one is at rest with a reading of exactly 0.
    #[test]
    fn noise_is_that_of_the_calmer_runs() {
        let mut rng = rng(11);
        let time: Vec<f64> = (0..800).map(|k| 2.0 * f64::from(k)).collect();
        let mut run = |swing: f64, sigma: f64| -> Vec<f64> {
            (0..800).map(|k| swing * f64::from(k % 2) + sigma * normal(&mut rng)).collect()
        };
        let columns = [run(5.0, 0.1), run(0.0, 0.1), run(9.0, 0.1), run(0.0, 0.1), run(0.0, 0.0)];
        let of = |which: &[usize], is_temperature| {
            of_columns(which.iter().map(|k| (&time[..], &columns[*k][..])), is_temperature).unwrap()
        };
        for which in [&[0, 1, 2, 3][..], &[0, 1], &[0, 1, 3, 4]] {
            assert!((of(which, false) / 0.1 - 1.0).abs() < 0.1, "{which:?}: {}", of(which, false));
        }
        assert!(of(&[0, 2], false) > 1.0 && of(&[4, 4, 0], false) == 0.0);
        assert!(of(&[0, 1, 2], true) > 1.0 && of(&[1, 3, 4], true) == of(&[1, 3], false));
        assert_eq!(of_columns(std::iter::empty(), false), None);
    }

    /// Every fifth row measured, and every fifth row new: the noise is that of the readings.
    #[test]
    fn noise_of_a_slower_sensor() {
        let mut rng = rng(5);
        let time: Vec<f64> = (0..6000).map(f64::from).collect();
        let (mut blank, mut held) = (Vec::new(), Vec::new());
        let mut last = 0.0;
        for (k, t) in time.iter().enumerate() {
            if k % 5 == 0 {
                last = 40.0 * (t / 900.0).sin() + 0.1 * normal(&mut rng);
            }
            blank.push(if k % 5 == 0 { last } else { f64::NAN });
            held.push(last);
        }
        for column in [blank, held] {
            let sigma = of_column(&time, &column).unwrap();
            assert!((sigma / 0.1 - 1.0).abs() < 0.08, "{sigma}");
        }
    }

    /// Noise of fan, ambient and winding in an experiment of one run; the three functions give the readings at each row.
    fn noises(stated: &str, read: impl Fn(usize, &mut Pcg64Mcg) -> [f64; 3]) -> Vec<f64> {
        let folder = tempfile::tempdir().unwrap();
        let mut rows = String::from(
            "time_s,current_A,speed_rad_per_s,fan_command_1,ambient_temperature_degC,winding_temperature_degC\n",
        );
        let mut rng = rng(3);
        for k in 0..1500 {
            let [fan, room, winding] = read(k, &mut rng);
            rows.push_str(&format!("{},1,100,{fan},{room},{winding}\n", 2 * k));
        }
        std::fs::write(folder.path().join("a.csv"), rows).unwrap();
        let text = format!(
            "[experiment]\nname = \"a\"\nmodel = \"AnnulusCooledMotor\"\npreset = \"maxon-305015\"\n\
             inputs = [\"current_A\", \"speed_rad_per_s\", \"fan_command_1\", \"ambient_temperature_degC\"]\n\
             outputs = [\"winding_temperature_degC\"]\n[noise]\n{stated}\n[[run]]\nfile = \"a.csv\"\nrole = \"fit\"\n"
        );
        std::fs::write(folder.path().join("e.toml"), text).unwrap();
        of_experiment(&Experiment::read(&folder.path().join("e.toml")).unwrap())[2..].to_vec()
    }

    fn warming(k: usize) -> f64 {
        25.0 + 40.0 * (1.0 - (-(k as f64) / 400.0).exp())
    }

    fn cut(x: f64, step: f64) -> f64 {
        (x / step).round() * step
    }

    /// A thermometer with a step of 0.25 K has quantization noise of 0.25 / sqrt 12 = 0.072 K; a switched fan has none.
    #[test]
    fn a_coarse_sensor_is_as_noisy_as_its_step() {
        let read = |k: usize, rng: &mut Pcg64Mcg| {
            let fan = if k % 60 < 30 { 0.0 } else { 1.0 };
            [fan, cut(23.0 + 0.1 * normal(rng), 0.25), cut(warming(k), 0.25)]
        };
        let found = noises("", read);
        assert!(found[0] < 1e-4, "{found:?}");
        assert!((found[1] - 0.1).abs() < 0.05 && (found[2] - 0.0722).abs() < 0.002, "{found:?}");
        // With a stated noise.
        let found = noises("winding_temperature_degC = 0.1", read);
        assert!((found[2] - 0.1f64.hypot(0.25 / 12f64.sqrt())).abs() < 1e-4, "{found:?}");
    }

    /// Five digits in a file are a step of a thousandth; full digits are not quantised and leave the noise unchanged.
    #[test]
    fn fine_readings_are_as_noisy_as_before() {
        for step in [1e-3, 1e-9] {
            let read = |k: usize, rng: &mut Pcg64Mcg| [0.0, 23.0, cut(warming(k) + 0.1 * normal(rng), step)];
            let (own, told) = (noises("", read), noises("winding_temperature_degC = 0.1", read));
            assert!((own[2] / 0.1 - 1.0).abs() < 0.08, "{own:?}");
            assert!((told[2] / 0.1 - 1.0).abs() < 0.01, "{told:?}");
            assert!((own[2] / bare(step) - 1.0).abs() < 0.01, "{own:?}");
        }
    }

    /// Eq. (2) alone for the same readings.
    fn bare(step: f64) -> f64 {
        let mut rng = rng(3);
        let time: Vec<f64> = (0..1500).map(|k| 2.0 * f64::from(k)).collect();
        let column: Vec<f64> = (0..1500).map(|k| cut(warming(k) + 0.1 * normal(&mut rng), step)).collect();
        of_column(&time, &column).unwrap()
    }

    /// A staircase of few speeds is a command; a counter with many steps is not.
    #[test]
    fn a_stair_is_no_step() {
        let stair: Vec<f64> = (0..400).map(|k| f64::from(k / 10 % 7) * 100.0).collect();
        assert_eq!(step([stair.as_slice()].into_iter(), false), None);
        let counter: Vec<f64> = (0..400).map(|k| cut(300.0 * (f64::from(k) / 60.0).sin(), 0.5)).collect();
        assert!((step([counter.as_slice()].into_iter(), false).unwrap() - 0.5).abs() < 1e-9);
        // Smooth ramp in full digits.
        let ramp: Vec<f64> = (0..400).map(|k| (f64::from(k) / 71.0).exp()).collect();
        assert_eq!(step([ramp.as_slice()].into_iter(), false), None);
    }
}
