//! Jacobian of the derivatives, and the linear systems with it.
//!
//! Derivatives depend on few of the states: an energy, an angle, or a state that is not in use appears in none of them, and its column of J
//! is zero. With D the states with other columns, (I - h J) y = r is
//! ```text
//! (I - h J_DD) y_D = r_D                              (1)
//! y_i = r_i + h sum_(j in D) J_ij y_j, i not in D      (2)
//! ```
//! so that only (1) is factorised.

use nalgebra::{DMatrix, DVector, Dyn, LU};
use std::rc::Rc;

/// The columns that are not zero.
#[derive(Debug)]
pub struct Jacobian {
    driving: Vec<usize>,
    columns: DMatrix<f64>,
}

impl Jacobian {
    /// The Jacobian with these columns, one for each state.
    pub fn new(columns: Vec<DVector<f64>>) -> Jacobian {
        let rows = columns.len();
        let driving: Vec<usize> = (0..rows).filter(|k| columns[*k].iter().any(|d| *d != 0.0)).collect();
        let columns = DMatrix::from_fn(rows, driving.len(), |i, k| columns[driving[k]][i]);
        Jacobian { driving, columns }
    }
}

/// I - h J, factorised.
pub struct Implicit {
    jacobian: Rc<Jacobian>,
    h: f64,
    factors: LU<f64, Dyn, Dyn>,
}

impl Implicit {
    /// The matrix of a step of length `h`.
    pub fn new(jacobian: &Rc<Jacobian>, h: f64) -> Implicit {
        let mut matrix = jacobian.columns.select_rows(&jacobian.driving) * -h;
        for k in 0..matrix.nrows() {
            matrix[(k, k)] += 1.0;
        }
        Implicit { jacobian: Rc::clone(jacobian), h, factors: matrix.lu() }
    }

    /// Solution with the right-hand side `r`; `None` if the matrix is singular.
    pub fn solve(&self, mut r: DVector<f64>) -> Option<DVector<f64>> {
        let Jacobian { driving, columns } = &*self.jacobian;
        if driving.is_empty() {
            return Some(r);
        }
        let mut y = r.select_rows(driving);
        if !self.factors.solve_mut(&mut y) {
            return None;
        }
        r.gemv(self.h, columns, &y, 1.0);
        driving.iter().zip(y.iter()).for_each(|(state, value)| r[*state] = *value);
        Some(r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_without_influence_are_not_factorised_and_the_solution_is_that_of_the_whole_matrix() {
        // States 1 and 3 appear in no derivative.
        let whole = DMatrix::from_row_slice(
            4,
            4,
            &[-3.0, 0.0, 2.0, 0.0, 5.0, 0.0, 7.0, 0.0, 1.0, 0.0, -40.0, 0.0, 0.0, 0.0, 11.0, 0.0],
        );
        let jacobian = Rc::new(Jacobian::new(whole.column_iter().map(|c| c.into_owned()).collect()));
        assert_eq!(jacobian.driving, [0, 2]);
        let (h, r) = (0.3, DVector::from_column_slice(&[1.0, -2.0, 3.0, 4.0]));
        let expected = (DMatrix::identity(4, 4) - &whole * h).lu().solve(&r).unwrap();
        let found = Implicit::new(&jacobian, h).solve(r).unwrap();
        assert!((found - expected).amax() < 1e-14);
    }

    #[test]
    fn a_system_without_feedback_has_nothing_to_factorise() {
        let jacobian = Rc::new(Jacobian::new(vec![DVector::zeros(2); 2]));
        let r = DVector::from_column_slice(&[1.0, 2.0]);
        assert_eq!(Implicit::new(&jacobian, 0.1).solve(r.clone()), Some(r));
    }
}
