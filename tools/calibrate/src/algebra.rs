//! Products and factors of large matrices, block by block.
//!
//! nalgebra multiplies in blocks that fit the cache, but takes transposed products, triangular solutions and Cholesky factors column by
//! column, which is several times slower for matrices with some hundred columns.
//! *Source*: Golub, Van Loan, Matrix Computations (4th ed., 2013), sec. 3.1.4 (solution), 4.2.6 (block Cholesky).

use nalgebra::{Cholesky, DMatrix, DMatrixView, Dyn, Matrix, Storage};

/// Columns of a block. Numerical: a block of 48 by 48 values fits into the cache of first level.
const BLOCK: usize = 48;
/// Least number of rows and columns for which nalgebra multiplies block by block; with fewer rows it would read a transposed view beyond its
/// end. Numerical: its own limit.
const WIDE: usize = 6;

/// a'b.
pub fn product(a: &DMatrix<f64>, b: &Matrix<f64, Dyn, Dyn, impl Storage<f64, Dyn, Dyn>>) -> DMatrix<f64> {
    product_of(a.as_slice(), a.shape(), b)
}

/// a'b; `a` in columns, with the numbers of its rows and columns.
fn product_of(
    a: &[f64],
    (rows, columns): (usize, usize),
    b: &Matrix<f64, Dyn, Dyn, impl Storage<f64, Dyn, Dyn>>,
) -> DMatrix<f64> {
    if rows.min(columns).min(b.ncols()) < WIDE {
        return DMatrixView::from_slice(a, rows, columns).tr_mul(b);
    }
    let (rows, columns) = (Dyn(rows), Dyn(columns));
    let transposed: DMatrixView<f64, Dyn, Dyn> =
        DMatrixView::from_slice_with_strides_generic(a, columns, rows, rows, Dyn(1));
    transposed * b
}

/// a'a, of which the first rows and columns are `known`. Only blocks on and above the diagonal are multiplied.
pub fn squares(a: &DMatrix<f64>, known: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, first) = (a.ncols(), known.ncols());
    let mut all = known.clone().resize(n, n, 0.0);
    for from in (first..n).step_by(BLOCK) {
        let to = n.min(from + BLOCK);
        let above = &a.as_slice()[..a.nrows() * to];
        let own = product_of(above, (a.nrows(), to), &a.columns_range(from..to));
        all.view_range_mut(..to, from..to).copy_from(&own);
    }
    all.fill_lower_triangle_with_upper_triangle();
    all
}

/// a'a of each group of `width` columns.
pub fn squares_of_groups(a: &DMatrix<f64>, width: usize) -> Vec<DMatrix<f64>> {
    let (rows, values) = (a.nrows(), a.nrows() * width);
    let groups = (0..a.ncols() / width.max(1)).map(|k| &a.as_slice()[k * values..(k + 1) * values]);
    groups.map(|own| product_of(own, (rows, width), &DMatrixView::from_slice(own, rows, width))).collect()
}

/// L b, where the matrix L is 0 above its diagonal.
pub fn lower_product(l: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let n = l.nrows();
    let mut all = DMatrix::zeros(n, b.ncols());
    for from in (0..n).step_by(BLOCK) {
        let to = n.min(from + BLOCK);
        all.rows_range_mut(from..to).gemm(1.0, &l.view_range(from..to, ..to), &b.rows_range(..to), 0.0);
    }
    all
}

/// The solution of L x = b, with the Cholesky factor L.
pub fn solve_lower(factor: &Cholesky<f64, Dyn>, mut b: DMatrix<f64>) -> DMatrix<f64> {
    let l = factor.l_dirty();
    let n = l.nrows();
    for from in (0..n).step_by(BLOCK) {
        let to = n.min(from + BLOCK);
        let (mut own, mut below) = b.rows_range_pair_mut(from..to, to..);
        l.view_range(from..to, from..to).solve_lower_triangular_unchecked_mut(&mut own);
        below.gemm(-1.0, &l.view_range(to.., from..to), &own, 1.0);
    }
    b
}

/// Cholesky factor; `None` if the matrix is not positive definite.
pub fn cholesky(mut a: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let n = a.nrows();
    for from in (0..n).step_by(BLOCK) {
        let width = BLOCK.min(n - from);
        let (left, mut own) = a.columns_range_pair_mut(..from, from..from + width);
        let (left, mut own) = (left.rows_range(from..), own.rows_range_mut(from..));
        own.gemm(-1.0, &left, &left.rows(0, width).transpose(), 1.0);
        let corner = own.rows(0, width).into_owned().cholesky()?.unpack();
        let mut inverse = DMatrix::identity(width, width);
        corner.solve_lower_triangular_unchecked_mut(&mut inverse);
        let below = own.rows_range(width..) * inverse.transpose();
        own.rows_mut(0, width).copy_from(&corner);
        own.rows_range_mut(width..).copy_from(&below);
    }
    Some(Cholesky::pack_dirty(a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{normal, rng};

    /// Over more than two blocks: product, factor and solution against those of nalgebra.
    #[test]
    fn blocks_give_the_result_of_the_whole() {
        let mut rng = rng(3);
        let z = DMatrix::from_fn(150, 2 * BLOCK + 7, |_, _| normal(&mut rng));
        let square = product(&z, &z);
        assert!((&square - z.tr_mul(&z)).norm() < 1e-12 * square.norm());
        for known in [0, 1, BLOCK + 3] {
            let known = square.view((0, 0), (known, known)).into_owned();
            assert!((squares(&z, &known) - &square).norm() < 1e-12 * square.norm());
        }
        let (own, whole) = (cholesky(square.clone()).unwrap(), square.clone().cholesky().unwrap());
        assert!((own.l() - whole.l()).norm() < 1e-9 * whole.l().norm());
        assert!(
            (lower_product(&whole.l(), &square) - whole.l() * &square).norm()
                < 1e-12 * square.norm().powf(1.5)
        );
        for width in [1, WIDE + 1] {
            let groups = squares_of_groups(&z, width);
            assert_eq!(groups.len(), z.ncols() / width);
            for (k, own) in groups.iter().enumerate() {
                let part = z.columns(k * width, width).into_owned();
                assert!((own - part.tr_mul(&part)).norm() < 1e-12 * own.norm());
            }
        }
        // Few rows: a null model of few parameters.
        for rows in 0..=WIDE {
            let few = z.rows(0, rows).into_owned();
            assert!((product(&few, &few) - few.tr_mul(&few)).norm() < 1e-9);
            for (k, own) in squares_of_groups(&few, WIDE + 1).iter().enumerate() {
                let part = few.columns(k * (WIDE + 1), WIDE + 1).into_owned();
                assert!((own - part.tr_mul(&part)).norm() < 1e-9, "{rows}");
            }
        }
        for columns in [1, WIDE] {
            let b = z.rows(0, columns).transpose();
            let x = solve_lower(&own, b.clone());
            assert!((own.l() * x - &b).norm() < 1e-9 * b.norm());
        }
        assert!(cholesky(-square).is_none());
    }
}
