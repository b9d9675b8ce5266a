//! What a column was before a first-order lag or an AC coupling.

/// What a column was before a first-order lag, if it was constant between the rows: (x_k - a x_{k-1}) / (1 - a), a = exp(-h / tau). Blank
/// readings stay blank.
pub(super) fn without_lag(time: &[f64], column: &[f64], tau: f64) -> Vec<f64> {
    let of = |k: usize| {
        let Some(before) = k.checked_sub(1).filter(|before| column[*before].is_finite()) else {
            return column[k];
        };
        let kept = ((time[before] - time[k]) / tau).exp();
        (column[k] - kept * column[before]) / (1.0 - kept)
    };
    (0..column.len()).map(of).collect()
}

/// What a column was before AC coupling, if it was at rest before the first row: x = y + z, dz/dt = y / tau. Blank readings stay blank.
pub(super) fn without_coupling(time: &[f64], column: &[f64], tau: f64) -> Vec<f64> {
    let (mut removed, mut last) = (0.0, None);
    let of = |(t, y): (&f64, &f64)| {
        if y.is_finite() {
            let area = last.map_or(0.0, |(before, from): (f64, f64)| 0.5 * (before + y) * (t - from));
            removed += area / tau;
            last = Some((*y, *t));
        }
        y + removed
    };
    time.iter().zip(column).map(of).collect()
}
