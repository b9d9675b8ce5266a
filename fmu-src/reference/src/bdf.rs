//! Variable-order BDF.
//!
//! *Source*: diffsol, Bdf (Shampine, Reichelt, SIAM J. Sci. Comput. 18 (1997)).

use crate::Tolerance;
use diffsol::{DenseMatrix, DiffsolError, NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod};

/// The state at each of `times`.
pub fn solve<const S: usize>(
    rates: impl Fn(f64, &[f64; S]) -> [f64; S],
    y0: &[f64; S],
    times: &[f64],
    tolerance: Tolerance,
) -> Result<Vec<[f64; S]>, String> {
    let read = |y: &[f64]| -> [f64; S] { std::array::from_fn(|k| y[k]) };
    let rates = |t: f64, y: &[f64], dy: &mut [f64]| dy.copy_from_slice(&rates(t, &read(y)));
    let found = run(&rates, y0, times, tolerance).map_err(|e| e.to_string())?;
    Ok(found.iter().map(|y| read(y)).collect())
}

/// Writes dy/dt at a time and a state.
type Rates<'a> = dyn Fn(f64, &[f64], &mut [f64]) + 'a;

/// The same for any number of states: not generic, so that diffsol is compiled only once and not in every test.
fn run(
    rates: &Rates,
    y0: &[f64],
    times: &[f64],
    tolerance: Tolerance,
) -> Result<Vec<Vec<f64>>, DiffsolError> {
    let count = y0.len();
    let problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(tolerance.relative)
        .atol([tolerance.absolute])
        .rhs_implicit(
            |y, _p, t, dy| rates(t, y, dy),
            // Jacobian by central differences: it affects the convergence of Newton's iteration, not the result.
            |y, _p, t, v, jv| {
                let size = |a: &[f64]| a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
                let step = 1e-6 * (1.0 + size(y)) / size(v).max(1e-300);
                let moved = |s: f64| y.iter().zip(v).map(|(y, v)| y + s * v).collect::<Vec<f64>>();
                let mut minus = vec![0.0; count];
                rates(t, &moved(step), jv);
                rates(t, &moved(-step), &mut minus);
                jv.iter_mut().zip(minus).for_each(|(plus, minus)| *plus = (*plus - minus) / (2.0 * step));
            },
        )
        .init(|_p, _t, y| y[..count].copy_from_slice(y0), count)
        .build()?;
    let mut solver = problem.bdf::<NalgebraLU<f64>>()?;
    let solution = solver.solve_dense(times)?;
    let ys = solution.0;
    Ok((0..times.len()).map(|c| (0..count).map(|k| ys.get_index(k, c)).collect()).collect())
}
