//! Inputs that end at the range of their instrument.
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

use super::{Unusable, sorted};
use crate::experiment::{Experiment, clipped};
use physics::declare::Unit;

/// Fraction of opposite signs in (1) above which readings have noise. Derivation: the middle between none and 0.73.
const NOISY: f64 = 0.37;
/// Resolutions by which rounding may change (1). Derivation: a half, two halves and a half.
const ROUNDED: f64 = 2.0;

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
    Some(Unusable {
        channel: channel.column.to_string(),
        reason: format!(
            "{} in {} is exactly {end} {unit} in {count} rows, and its other readings have noise: the instrument or the logger ends \
             there, and the true value is unknown",
            channel.column, run.file
        ),
        suggestion: format!("measure {} with a greater range, or leave the run out", channel.column),
    })
}

/// Whether successive values of (1) have opposite signs as those of noise, where no reading is at the end.
fn is_noisy(column: &[f64], end: f64) -> bool {
    let known = sorted(column.iter().copied());
    let steps = known.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > 0.0);
    let least = ROUNDED * steps.fold(f64::INFINITY, f64::min);
    let (mut opposite, mut all) = (0.0, 0.0);
    for w in column.windows(4).filter(|w| w.iter().all(|x| x.is_finite() && *x != end)) {
        let [first, second] = [0, 1].map(|k| w[k] - 2.0 * w[k + 1] + w[k + 2]);
        let are_clear = first.abs() > least && second.abs() > least;
        opposite += f64::from(u8::from(are_clear && first * second < 0.0));
        all += 1.0;
    }
    opposite > NOISY * all
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
