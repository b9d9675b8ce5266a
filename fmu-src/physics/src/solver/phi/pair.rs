//! The functions of a matrix of two rows: each is p + q z (Cayley, Hamilton), so that two numbers replace four.

use super::{HALF, KEPT, POWER, POWER_SMALL, RECIPROCAL, SMALL, Weights, functions, scaling};
use nalgebra::{SMatrix, Vector2};

/// Eigenvalues up to which the functions of a matrix of two rows have series of their own, of a step and of half of it, without a doubling.
const NEAR: f64 = 1.0;
/// Size up to which [`POWER_MIDDLE`] is sufficient: 0.1^10 6! / 16!.
const MIDDLE: f64 = 0.1;
const POWER_MIDDLE: usize = 8;
/// Eigenvalues above which p + q z loses more digits than the product of matrices.
pub(super) const FAR: f64 = 1e4;
/// Half the difference of scaled real eigenvalues above which functions of the eigenvalues replace products of p + q z: 0.7 of the
/// instructions. Rounding errors of q are multiplied by the reciprocal of the difference.
const APART: f64 = 0.05;

/// p + q z.
#[inline(always)]
fn of_matrix<const N: usize>(z: &SMatrix<f64, N, N>, f: Vector2<f64>) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| if i == j { f[1] * z[(i, j)] + f[0] } else { f[1] * z[(i, j)] })
}

/// phi_0 to the highest of `COUNT` functions as p and q, for a matrix with this trace and determinant.
#[inline(always)]
fn series<const COUNT: usize>([trace, determinant]: [f64; 2], power: usize) -> [Vector2<f64>; COUNT] {
    // z^2 = trace z - determinant.
    let times_z = |f: Vector2<f64>| Vector2::new(-determinant * f[1], f[0] + trace * f[1]);
    let [square, cube] = [times_z(Vector2::new(0.0, 1.0)), times_z(times_z(Vector2::new(0.0, 1.0)))];
    let times_square = |f: Vector2<f64>| square * f[0] + cube * f[1];
    let term = |k: usize| Vector2::new(RECIPROCAL[COUNT - 1 + k], 0.0);
    // Even and odd powers separately, for instruction-level parallelism.
    let (mut even, mut odd) = (term(power), term(power + 1));
    for k in (0..power).step_by(2).rev() {
        even = times_square(even) + term(k);
        odd = times_square(odd) + term(k + 1);
    }
    let mut phi = [even + times_z(odd); COUNT];
    for k in (0..COUNT - 1).rev() {
        phi[k] = times_z(phi[k + 1]) + Vector2::new(RECIPROCAL[k], 0.0);
    }
    phi
}

/// The weights as p and q, for a matrix with this trace and determinant and eigenvalues up to `size`, at most [`NEAR`].
#[inline(always)]
fn near([trace, determinant]: [f64; 2], size: f64, h: f64) -> Weights<Vector2<f64>> {
    let power = match size {
        size if size < SMALL => POWER_SMALL,
        size if size < MIDDLE => POWER_MIDDLE,
        _ => POWER,
    };
    let half = series::<HALF>([0.5 * trace, 0.25 * determinant], power);
    let of_half = half.map(|f| Vector2::new(f[0], 0.5 * f[1]));
    Weights::of((series::<KEPT>([trace, determinant], power), of_half), h)
}

/// The functions of a matrix of two rows: each is p + q z (Cayley, Hamilton), so that two numbers replace four, and the number of
/// halvings depends on the eigenvalues only. `None` for other matrices, and for eigenvalues so large that p + q z would
/// suffer from cancellation.
pub(super) fn pair<const N: usize>(z: &SMatrix<f64, N, N>, h: f64) -> Option<Weights<SMatrix<f64, N, N>>> {
    if N != 2 {
        return None;
    }
    let half_trace = 0.5 * (z[(0, 0)] + z[(1, 1)]);
    let apart = 0.5 * (z[(0, 0)] - z[(1, 1)]);
    // The eigenvalues are half the trace plus and minus the root.
    let square = apart * apart + z[(0, 1)] * z[(1, 0)];
    let root = square.abs().sqrt();
    let size = half_trace.abs() + root;
    if size.is_nan() || size > FAR {
        return None;
    }
    if size <= NEAR {
        let determinant = z[(0, 0)] * z[(1, 1)] - z[(0, 1)] * z[(1, 0)];
        return Some(near([2.0 * half_trace, determinant], size, h).map(|f| of_matrix(z, f)));
    }
    let (doublings, power) = scaling(size);
    let shrink = 0.5f64.powi(doublings);
    let (z, root) = (z * shrink, root * shrink);
    let matrix = |f: Vector2<f64>| of_matrix(&z, f);
    if square > 0.0 && root > APART {
        // p + q z is the line through the functions of both eigenvalues.
        let eigenvalues = Vector2::new(half_trace * shrink + root, half_trace * shrink - root);
        let of_eigenvalues = functions(
            [Vector2::repeat(1.0), eigenvalues],
            (power, doublings),
            |a, b| Vector2::new(a[0] * b[0], a[1] * b[1]),
            |a, number| Vector2::new(a[0] + number, a[1] + number),
        );
        let per = 0.5 / root;
        let line = |f: Vector2<f64>| {
            let q = (f[0] - f[1]) * per;
            matrix(Vector2::new(f[0] - q * eigenvalues[0], q))
        };
        return Some(Weights::of(of_eigenvalues, h).map(line));
    }
    let (trace, determinant) = (z[(0, 0)] + z[(1, 1)], z[(0, 0)] * z[(1, 1)] - z[(0, 1)] * z[(1, 0)]);
    // z^2 = trace z - determinant.
    let times = |a: &Vector2<f64>, b: &Vector2<f64>| {
        let square = a[1] * b[1];
        Vector2::new(a[0] * b[0] - square * determinant, a[0] * b[1] + a[1] * b[0] + square * trace)
    };
    let plus = |a: Vector2<f64>, number: f64| Vector2::new(a[0] + number, a[1]);
    let of_z = functions([Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)], (power, doublings), times, plus);
    Some(Weights::of(of_z, h).map(matrix))
}

#[cfg(test)]
mod tests {
    use super::super::of_any;
    use super::*;
    use nalgebra::matrix;

    /// On both sides of each limit up to which fewer powers or no doublings are sufficient.
    #[test]
    fn a_matrix_of_two_rows_has_the_functions_of_any_matrix() {
        for size in [1e-7, 0.9e-3, 1.1e-3, 0.03, 0.09, 0.11, 0.4, 0.99, 1.01, 1.9, 2.1, 5.0] {
            for shape in
                [matrix![-1.0, -0.3; 0.4, -0.1], matrix![-0.2, -0.9; 0.9, 0.0], matrix![-0.3, 0.0; 2.0, -0.7]]
            {
                let z = shape * size;
                let [of_pair, of_any] = [pair(&z, 0.7).unwrap(), of_any(&z, 0.7)].map(|weights| {
                    let Weights { middle, end, integral, moment, second, curvature, last } = weights;
                    [middle, end, integral, moment, second].concat().into_iter().chain([curvature, last])
                });
                for (k, (found, wanted)) in of_pair.zip(of_any).enumerate() {
                    let error = (found - wanted).norm();
                    assert!(error < 4e-15 * wanted.norm(), "weight {k} of {z}: {found} {wanted} {error:e}");
                }
            }
        }
    }
}
