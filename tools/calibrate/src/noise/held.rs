//! Readings that are written in several rows because the sensor is read less often: sample-and-hold.

use super::{FIRST, MOVES, ON_STEP};
use crate::levels::NEARLY;
use crate::numbers::interval;

/// Rows above which an interval is more than one. Derivation: intervals are whole numbers of rows; this is between one and two.
const LONGER: f64 = 1.5;

/// Which readings repeat an earlier one, if a logger with sample-and-hold has a new one at a constant interval of 2 to `longest` rows. A new
/// reading may be equal to the one before.
pub fn held(time: &[f64], values: &[f64], longest: usize) -> Option<Vec<bool>> {
    let changes: Vec<f64> =
        (1..values.len()).filter(|k| values[*k] != values[k - 1]).map(|k| time[k]).collect();
    let row = interval([time]);
    let (start, period) = lattice(&changes, row)?;
    let sample = |k: usize| ((time[k] - start) / period + 0.5 * row / period).floor();
    let held = (0..values.len()).map(|k| k > 0 && sample(k) == sample(k - 1)).collect();
    (period < (longest as f64 + 0.5) * row).then_some(held)
}

/// Start and period of equidistant times at which all changes happen, each in the first row after it; `row` is the interval between the
/// rows. Changes that have nothing to do with such times lie at one with a probability of row / period each.
fn lattice(changes: &[f64], row: f64) -> Option<(f64, f64)> {
    let mut gaps: Vec<f64> = changes.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    // A gap may be longer by the samples that repeat the one before, and any by the rounding to rows.
    let shortest = *gaps.get((FIRST * gaps.len() as f64) as usize).filter(|gap| **gap > LONGER * row)?;
    let single: Vec<f64> = gaps.iter().copied().filter(|gap| *gap < shortest + LONGER * row).collect();
    let mut period = single.iter().sum::<f64>() / single.len() as f64;
    let mut places = vec![0.0];
    for pair in changes.windows(2) {
        places.push(places[places.len() - 1] + ((pair[1] - pair[0]) / period).round());
    }
    let mut start = changes[0];
    for _ in 0..2 {
        let n = changes.len() as f64;
        let (x, y) = (places.iter().sum::<f64>() / n, changes.iter().sum::<f64>() / n);
        let both: f64 = places.iter().zip(changes).map(|(p, t)| (p - x) * (t - y)).sum();
        period = both / places.iter().map(|p| (p - x).powi(2)).sum::<f64>();
        start = y - period * x;
        places = changes.iter().map(|t| ((t - start) / period).round()).collect();
    }
    let off = |(place, t): (&f64, &f64)| (t - start - period * place).abs();
    let near = places.iter().zip(changes).filter(|pair| off(*pair) <= (0.5 + ON_STEP) * row).count();
    let is_regular = near as f64 >= NEARLY * changes.len() as f64 && changes.len() >= MOVES;
    (is_regular && period > LONGER * row).then_some((start, period))
}

/// Which readings repeat the one before, if a sensor that is finer than its changes repeats nearly all of them: it is read less often than the
/// rows are written, at any times. A noise of several steps gives equal neighbours in one of six rows only, as 1 / (2.5 sqrt(2 pi)).
pub fn repeated(values: &[f64]) -> Option<Vec<bool>> {
    let held: Vec<bool> = (0..values.len()).map(|k| k > 0 && values[k] == values[k - 1]).collect();
    let plateaus: Vec<&[f64]> = values.chunk_by(|a, b| a == b).collect();
    let long = plateaus.iter().filter(|plateau| plateau.len() > 1).count();
    let mut moves: Vec<f64> = plateaus.windows(2).map(|w| (w[1][0] - w[0][0]).abs()).collect();
    moves.sort_by(f64::total_cmp);
    let (step, usual) = (*moves.first()?, moves[moves.len() / 2]);
    let is_fine = usual > 2.0 * step && moves.len() >= MOVES / 2;
    (is_fine && long as f64 >= NEARLY * plateaus.len() as f64).then_some(held)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{normal, rng};

    const ROWS: usize = 1500;

    fn time(row: f64) -> Vec<f64> {
        (0..ROWS).map(|k| row * k as f64).collect()
    }

    /// A winding that warms up and cools down, with noise.
    fn readings(time: &[f64], noise: f64) -> Vec<f64> {
        let mut rng = rng(5);
        let mut at = 20.0;
        let heated = |t: f64| if ((t / 400.0) as usize).is_multiple_of(2) { 60.0 } else { 0.0 };
        time.windows(2)
            .map(|w| {
                at += (w[1] - w[0]) * (heated(w[0]) - (at - 20.0)) / 90.0;
                at + noise * normal(&mut rng)
            })
            .chain([20.0])
            .collect()
    }

    /// The readings of a scanner with this period and start: each row has that of the last scan.
    fn scanned(time: &[f64], values: &[f64], (start, period): (f64, f64)) -> Vec<f64> {
        let scan = |t: f64| start + ((t - start) / period).floor() * period;
        let row = |t: f64| time.partition_point(|other| *other < t - 1e-9).min(values.len() - 1);
        time.iter().map(|t| values[row(scan(*t))]).collect()
    }

    fn new(held: &[bool]) -> usize {
        held.iter().filter(|held| !**held).count()
    }

    /// Whatever the period is of the interval between the rows, also with a resolution at which a scan often repeats the one before.
    #[test]
    fn the_readings_of_a_scanner_are_found() {
        for (row, period, start, step) in [
            (2.0, 15.0, 0.0, 1e-3),
            (2.0, 5.0, 1.0, 1e-6),
            (1.0, 37.0, 12.0, 1e-2),
            (0.5, 7.3, 0.2, 0.1),
            (2.0, 20.0, 6.0, 0.25),
        ] {
            let time = time(row);
            let read: Vec<f64> = readings(&time, 0.1).iter().map(|x| (x / step).round() * step).collect();
            let held = held(&time, &scanned(&time, &read, (start, period)), usize::MAX);
            let found = new(&held.unwrap_or_else(|| panic!("{row} {period}"))) as f64;
            let scans = row * (ROWS - 1) as f64 / period;
            assert!((found - scans).abs() < 2.5, "{found} of {scans} at {period} s");
        }
    }

    /// A reading in each row, a coarse display, and a load that is commanded for longer than a slow instrument holds.
    #[test]
    fn other_readings_are_not_held() {
        let time = time(2.0);
        for (noise, step) in [(0.1, 1e-3), (0.1, 0.1), (0.02, 0.5), (0.0, 0.25), (0.0, 1.0)] {
            let read: Vec<f64> = readings(&time, noise).iter().map(|x| (x / step).round() * step).collect();
            assert_eq!(held(&time, &read, usize::MAX), None, "{noise} {step}");
            assert_eq!(repeated(&read), None, "{noise} {step}");
        }
        let load: Vec<f64> = (0..ROWS).map(|k| (k / 30 * 7 % 11) as f64).collect();
        assert_eq!(held(&time, &load, 20), None);
    }

    /// A logger that writes a reading when the sensor has sent one, at irregular times.
    #[test]
    fn readings_at_irregular_times_are_found_by_their_repetition() {
        let time = time(2.0);
        let mut rng = rng(8);
        let (mut read, mut last, mut next) = (readings(&time, 0.1), 0.0, 0);
        for (k, x) in read.iter_mut().enumerate() {
            if k == next {
                (last, next) = (*x, k + 3 + (4.0 * normal(&mut rng).abs()) as usize);
            }
            *x = last;
        }
        assert_eq!(held(&time, &read, usize::MAX), None);
        let held = repeated(&read).unwrap();
        assert!((0..ROWS).all(|k| held[k] == (k > 0 && read[k] == read[k - 1])));
        assert!(new(&held) < ROWS / 4);
    }
}
