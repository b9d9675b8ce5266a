//! Channels that end at the range of their instrument.
//!
//! The greatest or the least reading repeats exactly in many rows ([`clipped`]) although the channel has noise: an analog value at a limit
//! of the drive would have it there, too. A command without noise may stand at a limit, and a shaft or a current stands at 0. The true
//! value in these rows is unknown; of an output they are set aside, of an input they are what the model is simulated with.
//!
//! d_k = x_{k-1} - 2 x_k + x_{k+1}                                                                  (1)
//!
//! Successive d of white noise have the correlation -2/3 and therefore opposite signs in 73 % of all cases, 1/2 + asin(2/3) / pi; those of a
//! smooth line do not change their sign. The rounding of three readings changes d by up to two resolutions.
//!
//! *Source*: probability of opposite signs of two normal variables: Sheppard, Phil. Trans. R. Soc. A 192 (1899) 101-167.

use super::Unusable;
use crate::comparison::converted;
use crate::experiment::Experiment;
use crate::report::count_of;
use physics::declare::Unit;

/// Fraction of opposite signs in (1) above which readings have noise. Derivation: the middle between none and 0.73.
const NOISY: f64 = 0.37;
/// Resolutions by which rounding may change (1). Derivation: a half, two halves and a half.
const ROUNDED: f64 = 2.0;
/// Change relative to the channel that is a rounding error. Numerical: of double precision; no instrument resolves it.
const DIGITS: f64 = 1e-12;
/// Saturation: the end value must occur this many times as often as each of the [`NEXT`] readings next to it. Derivation: if all nine
/// were equally frequent, once each, the end value would occur eight times with a probability of 3e-7.
const CLIPPED: usize = 8;
/// Number of readings next to the end value. Derivation: as for [`CLIPPED`].
const NEXT: usize = 8;

/// Sets aside the readings of outputs at the end of a range, with notes. A reading of a temperature is also one without noise: a sensor that
/// is finer than its noise repeats no other reading as often. Other outputs stand exactly at a value in a simulation or at rest.
pub fn outputs(experiment: &mut Experiment) {
    for run in &mut experiment.runs {
        for (k, channel) in (experiment.inputs.len()..).zip(&experiment.outputs) {
            for side in [1.0, -1.0] {
                let column = &mut run.table.columns[k];
                let Some(end) = clipped(column, side) else { continue };
                let stands = if channel.is_temperature() { is_coarse } else { is_still };
                if stands(column, end) {
                    continue;
                }
                let count = column.iter().filter(|v| **v == end).count();
                column.iter_mut().filter(|v| **v == end).for_each(|v| *v = f64::NAN);
                // Below absolute zero a reading is a code for a missing one.
                let why = if channel.is_temperature() && end < 0.0 {
                    "which is no temperature; set aside"
                } else {
                    "where the sensor ends; set aside as clipped"
                };
                let (name, at) = (channel.column, converted(end - channel.offset));
                experiment.notes.push(format!(
                    "{}: {} of {name} at {at}, {why}",
                    run.file,
                    count_of(count, "reading")
                ));
            }
        }
    }
}

/// The first input that is clipped in a run.
pub fn input(experiment: &Experiment) -> Option<Unusable> {
    let ends = experiment.runs.iter().flat_map(|run| {
        let inputs = experiment.inputs.iter().enumerate();
        // A command ends at 1; the end of an ambient sensor is treated with the other temperatures.
        let inputs = inputs.filter(|(_, c)| c.unit != Unit::One && !c.is_temperature());
        inputs.flat_map(move |(k, c)| [1.0, -1.0].map(|side| (run, c, &run.table.columns[k], side)))
    });
    let found = ends.filter_map(|(run, channel, column, side)| {
        let end = clipped(column, side).filter(|end| *end != 0.0 && is_noisy(column, *end))?;
        Some((run, channel, column, end))
    });
    let (run, channel, column, end) = found.into_iter().next()?;
    let count = column.iter().filter(|x| **x == end).count();
    let unit = channel.unit.name();
    Some(Unusable::new(
        channel.column,
        format!(
            "{} in {} is exactly {end} {unit} in {count} rows, and its other readings have noise: the instrument or the logger ends \
             there, and the true value is unknown",
            channel.column, run.file
        ),
        format!("measure {} with a greater range, or leave the run out", channel.column),
    ))
}

/// The largest reading (`side` 1) or the smallest (-1), if it is the end of the sensor's range: it occurs far more often than the
/// readings next to it. A sensor with coarse resolution also repeats its other readings.
fn clipped(column: &[f64], side: f64) -> Option<f64> {
    let mut values: Vec<f64> = column.iter().filter(|v| v.is_finite()).map(|v| side * v).collect();
    values.sort_by(|a, b| b.total_cmp(a));
    let runs: Vec<&[f64]> = values.chunk_by(|a, b| a == b).take(NEXT + 1).collect();
    let (first, next) = runs.split_first()?;
    let usual = next.iter().map(|run| run.len()).max()?;
    (next.len() == NEXT && first.len() >= CLIPPED * usual).then_some(side * first[0])
}

/// Whether a channel may stand exactly at this value without a limit: at 0, or one without noise.
fn is_still(column: &[f64], end: f64) -> bool {
    end == 0.0 || !is_noisy(column, end)
}

/// Whether a display is so coarse that most readings equal the one before: at rest it repeats any of them.
fn is_coarse(column: &[f64], end: f64) -> bool {
    let known = || column.windows(2).filter(|w| w.iter().all(|x| x.is_finite() && *x != end));
    2 * known().filter(|w| w[0] == w[1]).count() > known().count()
}

/// Whether successive values of (1) have opposite signs as those of noise, where no reading is at the end.
fn is_noisy(column: &[f64], end: f64) -> bool {
    let size = column.iter().filter(|x| x.is_finite()).fold(0.0_f64, |size, x| size.max(x.abs()));
    let known = column.windows(4).filter(|w| w.iter().all(|x| x.is_finite() && *x != end));
    let pairs: Vec<[f64; 2]> = known.map(|w| [0, 1].map(|k| w[k] - 2.0 * w[k + 1] + w[k + 2])).collect();
    let changes = pairs.iter().flatten().map(|d| d.abs()).filter(|d| *d > DIGITS * size);
    let least = ROUNDED * changes.fold(f64::INFINITY, f64::min);
    let is_opposite = |d: &&[f64; 2]| d.iter().all(|d| d.abs() > least) && d[0] * d[1] < 0.0;
    pairs.iter().filter(is_opposite).count() as f64 > NOISY * pairs.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{self, normal, rng};

    /// A run with this current; the other columns are 1.
    fn with_current(of: impl Fn(usize, f64) -> f64) -> Experiment {
        let mut experiment = testing::experiment("", true);
        let mut rng = rng(1);
        let table = &mut experiment.runs[0].table;
        table.time = (0..900).map(|k| k as f64).collect();
        let all = experiment.inputs.len() + experiment.outputs.len();
        table.columns = vec![vec![1.0; 900]; all];
        table.columns[0] = (0..900).map(|k| of(k, normal(&mut rng))).collect();
        experiment
    }

    /// A ramp with noise that ends at 50; a resolution of 0.5 and a motor at rest are no ends.
    #[test]
    fn readings_at_the_end_of_a_sensor_are_set_aside() {
        let of = |place: usize, shown: &dyn Fn(f64, f64) -> f64| {
            let (mut experiment, mut rng) = (testing::experiment("", true), rng(2));
            let (k, offset) = (experiment.place_of(place), experiment.outputs[place].offset);
            let table = &mut experiment.runs[0].table;
            let rows = table.time.len();
            table.columns[k] = (0..rows).map(|k| shown(k as f64, normal(&mut rng)) + offset).collect();
            outputs(&mut experiment);
            let aside = experiment.runs[0].table.columns[k].iter().filter(|v| v.is_nan()).count();
            (aside, experiment.notes.join(" "))
        };
        let (voltage, torque, winding) = (0, 1, 2);
        for (place, noise) in [(winding, 0.02), (winding, 0.0), (voltage, 0.02), (torque, 0.3)] {
            let (aside, note) = of(place, &|k, n| (0.2 * k + noise * n).min(50.0));
            let expected = if place == torque { 48..=53 } else { 49..=51 };
            assert!(expected.contains(&aside), "{place} {noise}: {aside} {note}");
            assert!(note.contains(" at 50, where the sensor ends"), "{note}");
        }
        assert!(of(winding, &|k, n| (-0.2 * k - 0.01 * n).max(-30.0)).0 > 140);
        assert_eq!(of(winding, &|k, _| (0.4 * k).round() * 0.5).0, 0);
        // Simulated: friction of a shaft that turns at one speed, a voltage that is switched off, a torque with its ripple at rest.
        let ripple = |k: f64, _: f64| if k < 100.0 { -0.0317 } else { 0.3 + 0.1 * (k / 20.0).sin() };
        assert_eq!(of(torque, &ripple).0, 0);
        assert_eq!(of(voltage, &|k, n| if k < 100.0 { 0.0 } else { 5.0 + 0.1 * n }).0, 0);
    }

    #[test]
    fn a_current_beyond_the_range_of_its_instrument_is_unusable() {
        let wave = |k: usize| 4.0 * (k as f64 / 60.0).sin();
        let noisy = |k: usize, noise: f64| wave(k) + 0.02 * noise;
        let found = |of: &dyn Fn(usize, f64) -> f64| input(&with_current(of)).map(|why| why.reason);
        for clip in [3.0, 1.2, 0.4] {
            let reason = found(&|k, noise| noisy(k, noise).min(clip)).unwrap();
            assert!(reason.contains(&format!("exactly {clip} A")), "{reason}");
            assert!(found(&|k, noise| noisy(k, noise).clamp(-clip, 9.0)).is_some());
        }
        // In range; at a limit that has its noise; a command at its limit; a current that is switched off; steps; a coarse instrument.
        assert_eq!(found(&noisy), None);
        assert_eq!(found(&|k, noise| wave(k).min(2.0) + 0.02 * noise), None);
        assert_eq!(found(&|k, _| wave(k).min(2.0)), None);
        assert_eq!(found(&|k, _| (wave(k).min(2.0) * 1e3).round() / 1e3), None);
        assert_eq!(found(&|k, noise| noisy(k, noise).max(0.0)), None);
        assert_eq!(found(&|k, _| f64::from((k / 90 % 5) as u8)), None);
        assert_eq!(found(&|k, noise| (noisy(k, noise).min(3.0) / 0.2).round() * 0.2), None);
    }
}
