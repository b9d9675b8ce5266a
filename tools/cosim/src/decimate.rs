//! Fewer points for a line, with every peak kept.

/// Points a drawn line may have, about.
const MAX_POINTS: usize = 2000;

/// At most about 2000 of the points `(times, values)`: of each bunch of neighbours the lowest and the highest, in the
/// order of time; first and last always. What is no number is kept once per bunch, so that gaps stay visible.
pub(crate) fn decimated(times: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let count = times.len().min(values.len());
    let point = |i: usize| (times[i], values[i]);
    if count <= MAX_POINTS {
        return (0..count).map(point).collect();
    }
    let bunch = count.div_ceil(MAX_POINTS / 2);
    let mut kept = vec![0];
    for start in (1..count - 1).step_by(bunch) {
        let members = start..(start + bunch).min(count - 1);
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let numbers = || members.clone().filter(|i| values[*i].is_finite());
        let mut picks = [
            numbers().min_by(by_value),
            numbers().max_by(by_value),
            members.clone().find(|i| !values[*i].is_finite()),
        ];
        picks.sort();
        kept.extend(picks.into_iter().flatten());
    }
    kept.push(count - 1);
    kept.dedup();
    kept.into_iter().map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_ends_and_order_survive() {
        let times: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut values = vec![0.0; 100_000];
        values[54_321] = 7.0;
        values[54_322] = -7.0;
        values[99_999] = 1.0;
        let kept = decimated(&times, &values);
        assert!(kept.len() <= MAX_POINTS + 2 && kept.is_sorted());
        assert!(kept.contains(&(54_321.0, 7.0)) && kept.contains(&(54_322.0, -7.0)));
        assert_eq!((kept[0], kept[kept.len() - 1]), ((0.0, 0.0), (99_999.0, 1.0)));
        values[5] = f64::NAN;
        assert!(decimated(&times, &values).iter().any(|(_, y)| y.is_nan()));
        assert_eq!(decimated(&times[..3], &values), [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
    }
}
