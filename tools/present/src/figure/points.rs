//! Fewer points for a line, with every peak kept; and lines that go up and down more often than pixels can show, as bands.

use super::scale::Scale;

/// Points a drawn line may have, about.
const MAX_POINTS: usize = 2000;

/// Width in pixels of a step of a band, and the steps on both sides of it whose values it holds: a band from step to step alone would show
/// where the turns of a line meet the steps.
const STEP: f64 = 2.0;
const BESIDE: usize = 2;
/// Width in pixels of what a place of a band holds.
pub(super) const WINDOW: f64 = STEP * (2 * BESIDE + 1) as f64;
/// Steps on both sides of a step over which the way of a line is summed: many, so that a line does not change its kind back and forth.
const AROUND: usize = 12;
/// Strokes that cover this part of an area fill it for the eye.
const INK: f64 = 0.8;
/// Height in pixels of what is no area but a line.
const LEAST_HEIGHT: f64 = 6.0;
/// Steps that a band has at least.
const LEAST_STEPS: usize = 12;

/// What is drawn of a line: itself, and in its place a mean with a band where it turns at every pixel.
#[derive(Default)]
pub(super) struct Drawn {
    pub line: Vec<(f64, f64)>,
    /// Places with the least and the greatest value, band by band.
    pub bands: Vec<Vec<(f64, f64, f64)>>,
}

/// A line as it is drawn. Where its strokes lie side by side, it would fill an area and hide what lies below; there, its mean is drawn
/// over the band from its least to its greatest value.
/// `weight` is the width of the line in pixels.
pub(super) fn drawn(points: &[(f64, f64)], x: &Scale, y: &Scale, weight: f64) -> Drawn {
    let is_crowded = crowded(points, x, y, weight);
    if !is_crowded.contains(&true) {
        return Drawn { line: thinned(points), bands: Vec::new() };
    }
    let step_of = |p: &(f64, f64)| step(p, x, y, is_crowded.len());
    let mut drawn = Drawn::default();
    for run in points.chunk_by(|a, b| {
        let crowd = |p| step_of(p).is_some_and(|k| is_crowded[k]);
        crowd(a) == crowd(b)
    }) {
        if !step_of(&run[0]).is_some_and(|k| is_crowded[k]) {
            drawn.line.extend(thinned(run));
            continue;
        }
        let parts: Vec<Part> = run.chunk_by(|a, b| step_of(a) == step_of(b)).map(Part::of).collect();
        let mut band = Vec::new();
        for (k, part) in parts.iter().enumerate() {
            let beside = &parts[k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(parts.len())];
            let (low, high) =
                beside.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p.low), h.max(p.high)));
            // A step reaches to both its ends, so that a band is as long as its line.
            band.extend([part.from, part.to].map(|at| (at, low, high)));
            drawn.line.push((0.5 * (part.from + part.to), Part::mean(beside)));
        }
        drawn.bands.push(band);
    }
    drawn
}

/// The step of a point; none for what is outside the panel, or no number.
fn step(p: &(f64, f64), x: &Scale, y: &Scale, steps: usize) -> Option<usize> {
    let is_inside = x.holds(p.0) && y.holds(p.1);
    is_inside.then(|| (((x.at(p.0) - x.pixels.0) / STEP).max(0.0) as usize).min(steps - 1))
}

/// For each step of a panel whether a line of this weight covers the area in and around it in which it goes up and down.
fn crowded(points: &[(f64, f64)], x: &Scale, y: &Scale, weight: f64) -> Vec<bool> {
    let steps = ((x.pixels.1 - x.pixels.0) / STEP).ceil().max(1.0) as usize;
    // Few points cannot crowd, and only over a growing x do neighbours belong together.
    if points.len() < LEAST_STEPS * STEP as usize || !points.is_sorted_by(|a, b| a.0 <= b.0) {
        return vec![false; steps];
    }
    // The way up and down, and the lowest and highest pixel in each step.
    let (mut way, mut ends) = (vec![0.0; steps], vec![(f64::MAX, f64::MIN); steps]);
    let mut before: Option<f64> = None;
    for p in points {
        let found = step(p, x, y, steps).map(|k| (k, y.at(p.1)));
        if let Some((k, py)) = found {
            way[k] += before.map_or(0.0, |before| (py - before).abs());
            ends[k] = (ends[k].0.min(py), ends[k].1.max(py));
        }
        before = found.map(|f| f.1);
    }
    let height = |k: usize| {
        let beside = &ends[k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(steps)];
        let (low, high) = beside.iter().fold((f64::MAX, f64::MIN), |(l, h), e| (l.min(e.0), h.max(e.1)));
        (high - low).max(LEAST_HEIGHT)
    };
    let area: Vec<f64> = (0..steps).map(|k| STEP * height(k)).collect();
    let around = |k: usize| k.saturating_sub(AROUND)..(k + AROUND + 1).min(steps);
    let sum = |of: &[f64], k: usize| of[around(k)].iter().sum::<f64>();
    let mut crowded: Vec<bool> = (0..steps).map(|k| weight * sum(&way, k) >= INK * sum(&area, k)).collect();
    for run in crowded.chunk_by_mut(|a, b| a == b) {
        if run.len() < LEAST_STEPS {
            run.fill(false);
        }
    }
    crowded
}

/// The piece of a line in a step.
struct Part {
    from: f64,
    to: f64,
    low: f64,
    high: f64,
    /// The integral of the line over its x, and the mean of its values.
    integral: f64,
    plain: f64,
}

impl Part {
    fn of(points: &[(f64, f64)]) -> Part {
        let (low, high) = points.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p.1), h.max(p.1)));
        let integral = points.windows(2).map(|p| 0.5 * (p[0].1 + p[1].1) * (p[1].0 - p[0].0)).sum();
        let plain = points.iter().map(|p| p.1).sum::<f64>() / points.len() as f64;
        Part { from: points[0].0, to: points[points.len() - 1].0, low, high, integral, plain }
    }

    /// The mean over several, by time where they have a length.
    fn mean(parts: &[Part]) -> f64 {
        let wide: f64 = parts.iter().map(|p| p.to - p.from).sum();
        match wide > 0.0 {
            true => parts.iter().map(|p| p.integral).sum::<f64>() / wide,
            false => parts.iter().map(|p| p.plain).sum::<f64>() / parts.len() as f64,
        }
    }
}

/// At most about 2000 of the points: of each bunch of neighbours the lowest and the highest, in the order given; first and last always.
/// What is no number is kept once per bunch, so that gaps stay visible.
pub(super) fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let count = points.len();
    if count <= MAX_POINTS {
        return points.to_vec();
    }
    let bunch = count.div_ceil(MAX_POINTS / 2);
    let mut kept = vec![0];
    for start in (1..count - 1).step_by(bunch) {
        let members = start..(start + bunch).min(count - 1);
        let by_value = |a: &usize, b: &usize| points[*a].1.total_cmp(&points[*b].1);
        let numbers = || members.clone().filter(|i| points[*i].1.is_finite());
        let mut picks = [
            numbers().min_by(by_value),
            numbers().max_by(by_value),
            members.clone().find(|i| !points[*i].1.is_finite()),
        ];
        picks.sort();
        kept.extend(picks.into_iter().flatten());
    }
    kept.push(count - 1);
    kept.dedup();
    kept.into_iter().map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_ends_and_order_survive() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[54_321].1 = 7.0;
        points[54_322].1 = -7.0;
        points[99_999].1 = 1.0;
        let kept = thinned(&points);
        assert!(kept.len() <= MAX_POINTS + 2 && kept.is_sorted());
        assert!(kept.contains(&(54_321.0, 7.0)) && kept.contains(&(54_322.0, -7.0)));
        assert_eq!((kept[0], kept[kept.len() - 1]), ((0.0, 0.0), (99_999.0, 1.0)));
        points[5].1 = f64::NAN;
        assert!(thinned(&points).iter().any(|(_, y)| y.is_nan()));
        assert_eq!(thinned(&points[..3]), [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
    }
}
