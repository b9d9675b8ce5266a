//! The map of the temperatures over a stride: its fixed point, and its iteration over hours.
//!
//! Phi(y) are the temperatures after a stride that began at y.
//! slope        Phi' = S = exp(A T), A the slopes of the heat flows, T the stride; then Broyden's updates      (1)
//! steady       y <- y + (1 - S)^-1 (Phi(y) - y), in steps of 30 K and, where the slope predicts well, more, until they are small (2)
//!              Where the slowest mode grows, (2) leads to a steady state to which no motor comes: y follows Phi(y) - y instead.
//! envelope     y after m strides = y + (S^m - 1) (S - 1)^-1 (Phi(y) - y), with m as the error of a jump of m
//!              against two of m / 2 allows                                                                 (3)
//!
//! (2) is Newton's method with an approximate slope, (3) exact for a map that is a straight line. Current and motion are
//! periodic by themselves: a stride that begins where the last one ended needs no search.
//! *Source*: Broyden, Math. Comp. 19 (1965) 577; (3) is the exponential Rosenbrock-Euler step of Hochbruck, Ostermann,
//! Acta Numerica 19 (2010) 209, for a map in place of a flow.

use super::envelope::{Envelope, EnvelopePoint};
use super::periodic::Periodic;
use super::walker::{SETTLING, Walker};
use crate::StudyError;
use nalgebra::{DMatrix, DVector, RowDVector};

/// How near the steady state must be, K.
const STEADY: f64 = 2e-3;
/// Strides that the search may take.
const MOST_STRIDES: u32 = 60;
/// Longest first step of the search, K: derivatives of a cold winding do not hold 100 K above.
const LONGEST: f64 = 30.0;
/// The next step may be twice as long if the slope predicts the gain of a step within this fraction of its change, or less than it is.
const PREDICTED: f64 = 0.1;
/// Disturbance of a steady state, along the slowest mode, for the stability test, K.
const NUDGE: f64 = 1.0;
/// A steady state near one that was stable is disturbed only where the slope of the slowest mode is less than this fraction of the slope
/// there.
const STILL: f64 = 0.5;
/// Temperature that counts as thermal runaway, K.
const RUNAWAY: f64 = 1000.0;
/// Doublings of the map until only the slowest mode is left: strides of seconds against time constants of hours.
const DOUBLINGS: usize = 24;
/// Error of a jump that is taken, K.
const JUMP_ERROR: f64 = 0.05;

/// Change of the temperatures over a stride.
struct Change {
    gain: DVector<f64>,
    stride: Periodic,
}

fn change(walker: &mut Walker) -> Result<Change, StudyError> {
    let before = DVector::from_vec(walker.temperatures());
    let stride = walker.stride()?;
    Ok(Change { gain: DVector::from_vec(walker.temperatures()) - before, stride })
}

/// The same, with the slopes of the map: eq. (1).
fn change_with_slopes(walker: &mut Walker) -> Result<(Change, DMatrix<f64>), StudyError> {
    let before = DVector::from_vec(walker.temperatures());
    let (stride, rows) = walker.stride_with_slopes()?;
    let n = rows.len();
    let s = DMatrix::from_fn(n, n, |r, c| rows[r][c] * walker.stride_time()).exp();
    Ok((Change { gain: DVector::from_vec(walker.temperatures()) - before, stride }, s))
}

/// What a search begins with.
#[derive(Clone, Debug)]
pub struct Near {
    /// Temperatures, K.
    pub temperatures: Vec<f64>,
    /// Slopes of what a stride gains.
    slopes: DMatrix<f64>,
    /// Slope of the slowest mode in the last steady state that was disturbed to find it.
    disturbed: f64,
}

/// The stride in the periodic steady state, with the number of strides that were simulated to find it, and what a search for a steady
/// state nearby begins with. The result does not depend on `near` beyond its tolerance.
///
/// # Errors
/// No steady state: thermal runaway of the winding.
pub fn steady(walker: &Walker, near: Option<&Near>) -> Result<(Periodic, Near), StudyError> {
    let fits = near.filter(|near| near.temperatures.len() == walker.temperatures().len());
    let from_near = fits.and_then(|near| {
        let mut walker = walker.clone();
        walker.put_temperatures(&near.temperatures);
        search(walker, Some(near)).ok()
    });
    from_near.map_or_else(|| search(walker.clone(), None), Ok)
}

/// The search from the temperatures of the walker, those of `near` if there are some.
fn search(mut walker: Walker, near: Option<&Near>) -> Result<(Periodic, Near), StudyError> {
    // The last stride until current and motion repeat is near enough to one that repeats for a first estimate.
    let settling = walker.settling().max(1);
    for _ in 1..settling {
        walker.stride()?;
    }
    let mut y = DVector::from_vec(walker.temperatures());
    let one = DMatrix::identity(y.len(), y.len());
    let (mut f, mut minus) = match near {
        Some(near) => (change(&mut walker)?.gain, near.slopes.clone()),
        None => {
            let (Change { gain, .. }, s) = change_with_slopes(&mut walker)?;
            (gain, s - &one)
        }
    };
    let slowest = Slowest::of(&minus + one);
    let (mut walked, mut longest) = (settling, LONGEST);
    let runaway = || {
        StudyError::Unsettled(
            "thermal runaway: no periodic steady state, since the losses grow faster with the winding's temperature than \
             the heat flow"
                .to_owned(),
        )
    };
    while walked < MOST_STRIDES {
        let mut step = minus.clone().lu().solve(&-&f).ok_or_else(runaway)?;
        let (gain, size) = (slowest.part_of(&f), step.amax());
        if slowest.part_of(&step) * gain < 0.0 && size > NUDGE {
            // The losses grow faster than the heat flow: no steady state here to which anything leads. The temperatures go on.
            step = &slowest.way * longest.copysign(gain);
            longest *= 2.0;
        } else {
            step *= (longest / size).min(1.0);
        }
        let next = &y + &step;
        if next.iter().any(|t| !(0.0..RUNAWAY).contains(t)) {
            return Err(runaway());
        }
        walker.put_temperatures(next.as_slice());
        let Change { gain: f_next, stride } = change(&mut walker)?;
        walked += 1;
        // Broyden: the slope that the last step has seen.
        let predicted = &minus * &step;
        let seen = &f_next - &f - &predicted;
        // Newton's steps do not pass a steady state towards which the gain falls less and less.
        let is_convex = slowest.part_of(&seen) * slowest.part_of(&f) > 0.0;
        if is_convex || seen.amax() < PREDICTED * predicted.amax() {
            longest *= 2.0;
        }
        minus += seen / step.norm_squared().max(1e-300) * step.transpose();
        (y, f) = (next, f_next);
        // What the next step would be is how far the steady state is.
        let left = minus.clone().lu().solve(&-&f).ok_or_else(runaway)?;
        if left.amax() < STEADY {
            let slope = slowest.part_of(&(&minus * &slowest.way));
            let disturbed = match near {
                Some(near) if slope < STILL * near.disturbed => near.disturbed,
                _ => {
                    walked += 1;
                    let seen = (change_above(&walker, &slowest.way)? - &f) / NUDGE;
                    minus += (&seen - &minus * &slowest.way) / slowest.way.norm_squared()
                        * slowest.way.transpose();
                    slowest.part_of(&seen)
                }
            };
            if disturbed >= 0.0 {
                return Err(runaway());
            }
            // The winding is the first node.
            let stride = Periodic {
                winding_temperature: stride.winding_temperature + left[0],
                winding_temperature_mean: stride.winding_temperature_mean + left[0],
                strides_walked: walked,
                ..stride
            };
            return Ok((stride, Near { temperatures: walker.temperatures(), slopes: minus, disturbed }));
        }
    }
    Err(runaway())
}

/// The mode of a map that dies out last.
struct Slowest {
    /// Its direction, with the largest component 1.
    way: DVector<f64>,
    /// The row whose product with a change is the fraction of `way` in it.
    part: RowDVector<f64>,
}

impl Slowest {
    /// Of a map with these slopes.
    fn of(s: DMatrix<f64>) -> Slowest {
        // S^(2^k) is, but for its size, what dies out last times what of a change belongs to that.
        let far = (0..DOUBLINGS).fold(s, |s, _| {
            let twice = &s * &s;
            &twice / twice.amax()
        });
        let (way, part) = (far.column(0) / far.column(0).amax(), far.row(0));
        Slowest { part: part / (part * &way)[0], way }
    }

    /// The fraction of the mode in a change.
    fn part_of(&self, change: &DVector<f64>) -> f64 {
        (&self.part * change)[0]
    }
}

/// What a stride gains a little above a steady state. Where the winding's heat grows faster with its temperature than what it drives out,
/// there is a second steady state, to which nothing leads: the walker does not come back to it.
fn change_above(walker: &Walker, way: &DVector<f64>) -> Result<DVector<f64>, StudyError> {
    let mut walker = walker.clone();
    let moved = DVector::from_vec(walker.temperatures()) + way * NUDGE;
    walker.put_temperatures(moved.as_slice());
    Ok(change(&mut walker)?.gain)
}

/// Follows the winding for `duration`, s, or until it reaches `limit`, K: eq. (3).
///
/// # Errors
/// Equations that have no solution.
pub fn envelope(walker: &Walker, duration: f64, limit: f64, done: Done<'_>) -> Result<Envelope, StudyError> {
    let mut walker = walker.clone();
    walker
        .own_envelope(duration, limit, done)
        .unwrap_or_else(|| follow(&mut walker, duration, limit, &mut Pace::default(), done))
}

/// Takes the fraction that is done.
pub type Done<'a> = &'a (dyn Fn(f64) + Sync);

/// What is known of a walker that is followed again and again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// The longest jump that was taken.
    jump: u64,
    /// Strides until motion and current repeat.
    settling: u32,
}

impl Default for Pace {
    fn default() -> Pace {
        Pace { jump: 1, settling: SETTLING }
    }
}

/// The same from the present temperatures on; the walker is then at the end.
///
/// # Errors
/// Equations that have no solution.
pub(super) fn follow(
    now: &mut Walker,
    duration: f64,
    limit: f64,
    pace: &mut Pace,
    done: Done<'_>,
) -> Result<Envelope, StudyError> {
    let time = now.stride_time();
    let mut found = Envelope::default();
    found.mean.winding_temperature = f64::NEG_INFINITY;
    let mut strides = 0u64;
    let last = ((duration / time - 1e-9).ceil() as u64).max(1);
    let count = last as f64;
    let (mut jump, mut longest) = (pace.jump, 1);
    while strides < last {
        done(strides as f64 / count);
        // A stride walked: a point of the envelope, and what the temperatures gain.
        let (Change { gain, stride }, s) = change_with_slopes(now)?;
        found.mean.add(&stride, 1.0 / count);
        (strides, found.strides_walked) = (strides + 1, found.strides_walked + 1);
        let at =
            EnvelopePoint { time: strides as f64 * time, winding_temperature: stride.winding_temperature };
        let earlier = found.points.last().copied();
        found.points.push(at);
        if at.winding_temperature > limit {
            found.at_limit = Some(Periodic { strides_walked: found.strides_walked, ..stride });
            found.time_to_limit = Some(match earlier {
                Some(p) if p.winding_temperature < limit => {
                    let share =
                        (limit - p.winding_temperature) / (at.winding_temperature - p.winding_temperature);
                    p.time + share * (at.time - p.time)
                }
                _ => at.time,
            });
            return Ok(found);
        }
        if found.strides_walked <= pace.settling || strides >= last {
            continue;
        }
        let start = DVector::from_vec(now.temperatures());
        // What the next stride gains.
        let f = &s * gain;
        jump = (2 * jump).min(last - strides);
        while jump > 1 {
            let whole = jumped(&s, &f, jump, &start);
            // Two halves, the second with what the temperatures gain there.
            let middle = jumped(&s, &f, jump / 2, &start);
            now.put_temperatures(middle.as_slice());
            let Change { gain, stride } = change(now)?;
            found.strides_walked += 1;
            let halves = jumped(&s, &gain, jump - jump / 2, &middle);
            let gap = stride.winding_temperature - at.winding_temperature;
            // The limit is passed stride by stride.
            let near = stride.winding_temperature + gap.max(0.0) > limit;
            let error = &halves - whole;
            if error.amax() < JUMP_ERROR && !near {
                // The whole jump errs by its square as the halves by half of it.
                now.put_temperatures((halves + error).as_slice());
                strides += jump;
                found.mean.add(&stride, jump as f64 / count);
                longest = longest.max(jump);
                break;
            }
            now.put_temperatures(start.as_slice());
            jump /= 2;
        }
        jump = jump.max(1);
    }
    // Half of it, since the first trial is twice the pace.
    *pace = Pace { jump: (longest / 2).max(1), settling: 0 };
    found.mean = found.mean.finished();
    Ok(found)
}

/// Temperatures `m` strides after `y`, from which the map gains `f`: eq. (3) by doubling.
fn jumped(s: &DMatrix<f64>, f: &DVector<f64>, m: u64, y: &DVector<f64>) -> DVector<f64> {
    // sum = 1 + S + ... + S^(m-1), power = S^m, from the bits of m.
    let n = f.len();
    let (mut sum, mut power) = (DMatrix::zeros(n, n), DMatrix::identity(n, n));
    for bit in (0..64 - m.leading_zeros()).rev() {
        sum = &sum + &power * &sum;
        power = &power * &power;
        if m >> bit & 1 == 1 {
            sum += &power;
            power = &power * s;
        }
    }
    y + sum * f
}

#[cfg(test)]
mod tests {
    use super::super::load::Load;
    use super::super::walker::Period;
    use super::*;
    use describe::Preset;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    fn bare(support: f64) -> Walker {
        let preset = Preset::load("thesis-rig").unwrap();
        let text = format!(
            "[motor]\ndrive_mode = \"current\"\ncooling_mode = \"bare\"\n\
             \"validity.winding_temperature\" = 1200\n\"validity.magnet_temperature\" = 1200\n\
             [gait]\n\"gait.support\" = {support}\n\
             [actuator]\n\"transmission.ratio\" = 250\n\"transmission.efficiency\" = 0.85\n\"spring.stiffness\" = 250\n"
        );
        Load::parse(&text, "gait.toml", Some(&preset), &[]).unwrap().walker().unwrap()
    }

    /// Below thermal runaway a steady state exists, and its temperature increases with the support. Steps from the gradients at low
    /// temperature overshoot it, near the runaway without bound.
    #[test]
    fn steady_states_exist_up_to_thermal_runaway() {
        let found: Vec<Option<f64>> = (0..13)
            .map(|k| {
                steady(&bare(0.40 + 0.02 * f64::from(k)), None)
                    .ok()
                    .map(|(stride, _)| stride.winding_temperature)
            })
            .collect();
        println!("{found:?}");
        let settled = found.iter().take_while(|t| t.is_some()).count();
        assert!((7..12).contains(&settled), "{settled}");
        assert!(found[..settled].windows(2).all(|pair| pair[0] < pair[1]));
        assert!(found[settled..].iter().all(Option::is_none));
    }

    /// A little above the steady state the winding comes back to it; far above it warms on and on.
    #[test]
    fn beyond_the_second_steady_state_nothing_comes_back() {
        let mut walker = bare(0.5);
        let (_, near) = steady(&walker, None).unwrap();
        walker.put_temperatures(&near.temperatures);
        walker.stride().unwrap();
        let back = |warmer: f64| {
            let mut walker = walker.clone();
            let hot: Vec<f64> = walker.temperatures().iter().map(|t| t + warmer).collect();
            walker.put_temperatures(&hot);
            let (Change { gain, .. }, s) = change_with_slopes(&mut walker.clone()).unwrap();
            let slowest = Slowest::of(s);
            slowest.part_of(&(change_above(&walker, &slowest.way).unwrap() - gain)) < 0.0
        };
        assert!(back(0.0) && !back(200.0));
    }

    /// One temperature that gains `gain` of itself in a stride of a second, and the number of strides of all copies.
    #[derive(Clone)]
    struct Map {
        temperature: f64,
        gain: fn(f64) -> f64,
        strides: Arc<AtomicU32>,
    }

    impl Period for Map {
        fn stride_time(&self) -> f64 {
            1.0
        }
        fn stride(&mut self) -> Result<Periodic, StudyError> {
            self.strides.fetch_add(1, Ordering::Relaxed);
            self.temperature += (self.gain)(self.temperature);
            Ok(Periodic { winding_temperature: self.temperature, ..Periodic::default() })
        }
        fn temperatures(&self) -> Vec<f64> {
            vec![self.temperature]
        }
        fn put_temperatures(&mut self, temperatures: &[f64]) {
            assert!(temperatures[0] > 299.0, "colder than at the start");
            self.temperature = temperatures[0];
        }
        fn stride_with_slopes(&mut self) -> Result<(Periodic, Vec<Vec<f64>>), StudyError> {
            let slope = (self.gain)(self.temperature + 0.5) - (self.gain)(self.temperature - 0.5);
            Ok((self.stride()?, vec![vec![slope.ln_1p()]]))
        }
        fn boxed_clone(&self) -> Box<dyn Period> {
            Box::new(self.clone())
        }
    }

    /// The motor comes to the lower one of two steady states, also from near the upper one; without a steady state the temperatures rise
    /// to the runaway in a few strides.
    #[test]
    fn a_motor_comes_to_the_stable_steady_state_or_to_none() {
        let at = |gain: fn(f64) -> f64| {
            let strides = Arc::new(AtomicU32::new(0));
            let walker = Walker::new(Map { temperature: 300.0, gain, strides: Arc::clone(&strides) });
            (walker, strides)
        };
        let (walker, _) = at(|t| 2e-5 * (t - 380.0) * (t - 440.0));
        let (cold, near) = steady(&walker, None).unwrap();
        for temperature in [370.0, 440.4, 443.0, 470.0] {
            let near = Near { temperatures: vec![temperature], ..near.clone() };
            for found in [cold, steady(&walker, Some(&near)).unwrap().0] {
                assert!((found.winding_temperature - 380.0).abs() < 2e-3, "{temperature} {found:?}");
            }
        }
        let (walker, strides) = at(|t| 2e-5 * (t - 410.0).powi(2) + 0.05);
        assert!(matches!(steady(&walker, None), Err(StudyError::Unsettled(_))));
        assert!(strides.load(Ordering::Relaxed) < 15, "{strides:?}");
    }

    /// A map that is a straight line: m strides at once are m strides one after the other.
    #[test]
    fn a_jump_is_as_many_strides() {
        let s = DMatrix::from_row_slice(2, 2, &[0.6, 0.3, 0.01, 0.985]);
        let b = DVector::from_vec(vec![3.0, 1.0]);
        let start = DVector::from_vec(vec![300.0, 310.0]);
        let f = &s * &start + &b - &start;
        let mut y = start.clone();
        for m in 1..=37u64 {
            y = &s * &y + &b;
            assert!((jumped(&s, &f, m, &start) - &y).amax() < 1e-9, "{m}");
        }
    }
}
