//! Lobatto quadrature with five points: for states whose rates along a step are known in advance.
//!
//! Exact for polynomials of degree 7 at the end of the step, of degree 4 at the inner points. The error estimate is the difference to
//! Simpson's rule on three of the points.
//! *Source*: Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, section IV.5, Lobatto IIIA.

/// Number of points.
pub const POINTS: usize = 5;
/// The points, as fractions of the step: its ends, its middle, and 1/2 -+ (3/28)^(1/2).
pub const AT: [f64; POINTS] = [0.0, 0.17267316464601146, 0.5, 0.8273268353539885, 1.0];
/// Weights of the whole step.
const WHOLE: [f64; POINTS] = [1.0 / 20.0, 49.0 / 180.0, 16.0 / 45.0, 49.0 / 180.0, 1.0 / 20.0];
/// Weights of the integrals up to the inner points.
const WITHIN: [[f64; POINTS]; POINTS - 2] = [
    [
        0.06772843218615689,
        0.11974476934341167,
        -0.02173572186655812,
        0.010635824225415506,
        -0.0037001392424145306,
    ],
    [13.0 / 320.0, 0.30318418332304276, 8.0 / 45.0, -0.030961961100820546, 3.0 / 320.0],
    [
        0.053700139242414534,
        0.2615863979968067,
        0.37729127742211366,
        0.15247745287881054,
        -0.017728432186156898,
    ],
];
/// A kink in f causes at most this fraction of the largest difference to Simpson's rule as error.
const CORNER: f64 = 0.35;

/// The integral over a step of `h`, and its error estimate: `f` at [`AT`].
#[inline(always)]
pub fn integral(f: &[f64; POINTS], h: f64) -> (f64, f64) {
    let ends = f[0] + f[4];
    let whole = WHOLE[0] * ends + WHOLE[1] * (f[1] + f[3]) + WHOLE[2] * f[2];
    let simpson = (ends + 4.0 * f[2]) / 6.0;
    (h * whole, CORNER * h * (whole - simpson))
}

/// The integrals from the beginning of a step of `h` to each of [`AT`].
#[inline(always)]
pub fn integrals(f: &[f64; POINTS], h: f64) -> [f64; POINTS] {
    let sum = |w: &[f64; POINTS]| h * (0..POINTS).map(|k| w[k] * f[k]).sum::<f64>();
    [0.0, sum(&WITHIN[0]), sum(&WITHIN[1]), sum(&WITHIN[2]), integral(f, h).0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_exact() {
        for degree in 0..8 {
            let f = AT.map(|t| (2.0 * t).powi(degree));
            let exact = |t: f64| (2.0 * t).powi(degree + 1) / f64::from(2 * (degree + 1));
            let (whole, off) = integral(&f, 1.0);
            assert!((whole - exact(1.0)).abs() < 1e-13, "{degree} {whole}");
            // Simpson's rule is exact to degree 3; above, the estimate is not zero.
            assert_eq!(off.abs() < 1e-14, degree <= 3, "{degree} {off}");
            for (found, t) in integrals(&f, 1.0).into_iter().zip(AT).filter(|_| degree <= 4) {
                assert!((found - exact(t)).abs() < 1e-13, "{degree} {t} {found}");
            }
        }
    }

    /// max(t - s, 0): for any position s of the kink, the estimate bounds the error, except where both rules agree by chance.
    #[test]
    fn a_corner_is_told() {
        let (mut worst, mut told, mut blind) = (0.0f64, 0.0f64, 0);
        for k in 1..1000 {
            let s = f64::from(k) / 1000.0;
            let (whole, off) = integral(&AT.map(|t| (t - s).max(0.0)), 1.0);
            let error = (whole - 0.5 * (1.0 - s) * (1.0 - s)).abs();
            (worst, told) = (worst.max(error), told.max(off.abs()));
            blind += i32::from(error > 3.0 * off.abs() && error > 1e-4);
        }
        assert!(worst < 1.05 * told, "{worst} {told}");
        assert!(blind < 200, "{blind}");
    }
}
