//! Fewer points for a line, with every peak kept.

/// Points a drawn line may have, about.
const MAX_POINTS: usize = 2000;

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
