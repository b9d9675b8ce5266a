//! Order statistics of readings with blanks.

/// Difference of the greatest and the least number; 0 without any.
pub fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = ends(values.filter(|x| x.is_finite()));
    (high - low).max(0.0)
}

/// The least and the greatest number.
pub fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// Sorted copy of the finite values.
pub fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = values.filter(|x| x.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Median of the finite values; NaN if there are none.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let all = sorted(values);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Usual interval between rows, of all these times together: the median.
pub fn interval<'a>(times: impl IntoIterator<Item = &'a [f64]>) -> f64 {
    median(times.into_iter().flat_map(|time| time.windows(2).map(|pair| pair[1] - pair[0])))
}

/// Linear interpolation, constant outside the points.
pub fn between(x: &[f64], y: &[f64], at: f64) -> f64 {
    let k = x.partition_point(|v| *v <= at);
    if k == 0 {
        return y[0];
    }
    if k == x.len() {
        return y[k - 1];
    }
    let share = (at - x[k - 1]) / (x[k] - x[k - 1]);
    if share == 0.0 { y[k - 1] } else { y[k - 1] + share * (y[k] - y[k - 1]) }
}
