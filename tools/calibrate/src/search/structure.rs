//! Structure error: small smooth laws at every port over every driver, none significant on its own.
//!
//! f = sum_pd f_pd,   f_pd ~ N(0, q^2 K_d) at port p over driver d                                         (1)
//! S S' = 1/N sum_pd C_pd K_d C_pd' n / tr(C_pd K_d C_pd')                                                 (2)
//!
//! C_pd are the responses of the linearised model to the knot values of a law. Each law is scaled to the same effect on the n block means,
//! in units of their noise, so that q is the size of the structure error in these units; it is estimated (`evidence.rs`). (2) is a pivoted
//! Cholesky decomposition, truncated where the remainder is below the least size of structure error that matters.
//! *Sources*: Kennedy, O'Hagan, J. R. Stat. Soc. B 63 (2001) 425-464; Alvarez, Luengo, Lawrence, IEEE Trans. Pattern Analysis 35 (2013)
//! 2693-2705 (latent forces); Harbrecht, Peters, Schneider, Applied Numerical Mathematics 62 (2012) 428-440 (pivots).

use super::laws::{acts, alike, is_known, knots};
use crate::hypothesis::hat;
use crate::levels::NEGLIGIBLE;
use crate::linearization::Linearization;
use crate::parallel;
use nalgebra::{DMatrix, DVector};
use physics::terms::{Driver, Drivers, Port};

/// Greatest number of directions. Numerical: as many columns as the drifts of two sensors have; the pivots take the greatest
/// contributions first.
const DIRECTIONS: usize = 48;

/// Directions of the structure error of size 1 at a point: S of (2).
pub fn structure(point: &Linearization) -> DMatrix<f64> {
    let places: Vec<(Port, Driver)> = Port::ALL
        .iter()
        .flat_map(|port| Driver::ALL.iter().map(move |driver| (*port, *driver)))
        .filter(|(port, driver)| !driver.is_heat() && is_known(point, *driver) && acts(point, *port, *driver))
        .collect();
    let laws = parallel::flat_map(&places, |(port, driver)| law(point, *port, *driver));
    compressed(&laws, point.evidence.values())
}

/// Responses to a law; each column belongs to a coefficient of variance 1.
fn law(point: &Linearization, port: Port, driver: Driver) -> Option<DMatrix<f64>> {
    let knots = knots(point, driver)?;
    let hidden = point.hidden(Some(driver));
    let value = |k: usize, d: &Drivers| if hidden(d) { 0.0 } else { hat(&knots, k, d.of(driver)) };
    let columns = point.port_columns(port, knots.len(), |k, _, _, d| value(k, d))?;
    let scaled = columns * alike(&knots).cholesky()?.l();
    let size = scaled.norm();
    (size > 0.0 && size.is_finite()).then(|| scaled * ((point.evidence.values() as f64).sqrt() / size))
}

/// Eq. (2), truncated to few columns.
fn compressed(laws: &[DMatrix<f64>], values: usize) -> DMatrix<f64> {
    let count = laws.len() as f64;
    let mut left = DVector::<f64>::zeros(values);
    for law in laws {
        law.column_iter().for_each(|c| left += c.component_mul(&c) / count);
    }
    let mut columns: Vec<DVector<f64>> = Vec::new();
    while columns.len() < DIRECTIONS && left.mean() > NEGLIGIBLE * NEGLIGIBLE {
        let pivot = left.imax();
        let mut column = DVector::zeros(values);
        for law in laws {
            column.gemv(1.0 / count, law, &law.row(pivot).transpose(), 1.0);
        }
        columns.iter().for_each(|c| column.axpy(-c[pivot], c, 1.0));
        column /= left[pivot].sqrt();
        left -= column.component_mul(&column);
        left[pivot] = 0.0;
        left.iter_mut().for_each(|x| *x = x.max(0.0));
        columns.push(column);
    }
    if columns.is_empty() { DMatrix::zeros(values, 0) } else { DMatrix::from_columns(&columns) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{normal, rng};

    /// Test law with `numbers` coefficients over `n` values, scaled as [`law`] does.
    fn trial(n: usize, numbers: usize, seed: u64) -> DMatrix<f64> {
        let mut rng = rng(seed);
        let columns = DMatrix::from_fn(n, numbers, |_, _| normal(&mut rng));
        let size = columns.norm();
        columns * ((n as f64).sqrt() / size)
    }

    /// Few directions reproduce the covariance of all laws, each with equal weight.
    #[test]
    fn directions_have_the_covariance_of_the_laws() {
        let laws = [trial(60, 3, 1), trial(60, 2, 2), trial(60, 4, 3)];
        let columns = compressed(&laws, 60);
        let sum: DMatrix<f64> = laws.iter().map(|law| law * law.transpose() / 3.0).sum();
        let off = (&columns * columns.transpose() - &sum).norm() / sum.norm();
        assert!(columns.ncols() <= 9 && off < 0.05, "{} directions, {off}", columns.ncols());
        assert!((sum.trace() / 60.0 - 1.0).abs() < 1e-12);
        assert_eq!(compressed(&[], 60).ncols(), 0);
    }

    /// With more laws than directions, the smallest contributions are truncated.
    #[test]
    fn directions_are_few() {
        let laws: Vec<DMatrix<f64>> = (0..100).map(|k| trial(200, 3, k)).collect();
        let columns = compressed(&laws, 200);
        assert_eq!(columns.ncols(), DIRECTIONS);
        let held: f64 = columns.norm_squared() / 200.0;
        // Random laws have equal variance in each of 200 directions; each pivot accounts for at least its fraction.
        assert!(held > DIRECTIONS as f64 / 200.0 && held < 1.0, "{held}");
    }
}
