//! Problems of the literature with known answers (Moré, Garbow, Hillstrom, ACM TOMS 7 (1981) 17), and box constraints.

use super::*;

/// Residuals as a function, and the digit to which an evaluation rounds them; slopes are central differences of the exact ones.
struct Function<F>(F, Option<f64>);

impl<F: Fn(&DVector<f64>) -> Vec<f64>> Function<F> {
    fn exact(&self, x: &DVector<f64>) -> Result<DVector<f64>, String> {
        let r = DVector::from_vec((self.0)(x));
        if r.iter().all(|v| v.is_finite()) { Ok(r) } else { Err("not finite".into()) }
    }
}

impl<F: Fn(&DVector<f64>) -> Vec<f64>> Problem for Function<F> {
    type Point = DVector<f64>;
    type Slopes = DMatrix<f64>;
    type Error = String;

    fn evaluate(&self, x: &DVector<f64>) -> Result<DVector<f64>, String> {
        let r = self.exact(x)?;
        Ok(self.1.map_or(r.clone(), |digit| r.map(|v| (v / digit).round() * digit)))
    }

    fn cost(&self, point: &DVector<f64>) -> f64 {
        point.norm_squared()
    }

    fn linearise(&self, x: &DVector<f64>, _: &DVector<f64>) -> Result<DMatrix<f64>, String> {
        let column = |k: usize| {
            let (mut low, mut high) = (x.clone(), x.clone());
            let way = 1e-6 * x[k].abs().max(1e-3);
            (low[k], high[k]) = (x[k] - way, x[k] + way);
            Ok((self.exact(&high)? - self.exact(&low)?) / (2.0 * way))
        };
        Ok(DMatrix::from_columns(&(0..x.len()).map(column).collect::<Result<Vec<_>, String>>()?))
    }

    fn information(&self, slopes: &DMatrix<f64>) -> DMatrix<f64> {
        slopes.transpose() * slopes
    }

    fn gradient(&self, _: &DVector<f64>, point: &DVector<f64>, slopes: &DMatrix<f64>) -> DVector<f64> {
        slopes.transpose() * point
    }
}

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn solve<F: Fn(&DVector<f64>) -> Vec<f64>>(
    residuals: F,
    start: &[f64],
    limits: &[(f64, f64)],
    options: Options,
) -> Solution<Function<F>> {
    let found =
        minimise(&Function(residuals, None), DVector::from_column_slice(start), limits, &options).unwrap();
    assert!(found.x.iter().zip(limits).all(|(x, (l, u))| l <= x && x <= u), "{}", found.x);
    assert_ne!(found.status, Status::Unfinished);
    found
}

fn assert_near(found: &DVector<f64>, expected: &[f64], tolerance: f64) {
    let difference = (found - DVector::from_column_slice(expected)).norm();
    assert!(difference < tolerance, "{found} instead of {expected:?}");
}

fn rosenbrock(x: &DVector<f64>) -> Vec<f64> {
    vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]
}

#[test]
fn rosenbrock_from_the_usual_start_and_from_far() {
    for (start, most) in [([-1.2, 1.0], 40), ([-12.0, 10.0], 60), ([120.0, -100.0], 160)] {
        let found = solve(rosenbrock, &start, &[FREE; 2], Options::default());
        assert_near(&found.x, &[1.0, 1.0], 1e-8);
        assert!(found.evaluations < most, "{} evaluations", found.evaluations);
    }
}

/// A valley whose walls are ten to a thousand times as steep as that of Rosenbrock. Without eq. (3) this takes 60 to 1350 linearisations.
#[test]
fn a_narrow_curved_valley_is_followed() {
    for (wall, most) in [(1e2, 20), (1e3, 45), (1e4, 80)] {
        let valley = |x: &DVector<f64>| vec![wall * (x[1] - x[0] * x[0]), 1.0 - x[0]];
        for start in [[-1.2, 1.44], [-3.0, 2.0], [6.0, -5.0]] {
            let found = solve(valley, &start, &[FREE; 2], Options::default());
            assert_near(&found.x, &[1.0, 1.0], 1e-6);
            assert!(found.linearisations < most, "{wall}, {start:?}: {}", found.linearisations);
        }
    }
}

/// With x1 <= 0.5 the solution is at the limit, where x2 = x1^2.
#[test]
fn rosenbrock_in_a_box() {
    let found = solve(rosenbrock, &[-1.2, 1.0], &[(-2.0, 0.5), (-2.0, 2.0)], Options::default());
    assert_near(&found.x, &[0.5, 0.25], 1e-9);
    // A start value at an inactive limit moves away from it.
    let found = solve(rosenbrock, &[-2.0, 2.0], &[(-2.0, 2.0), (-2.0, 2.0)], Options::default());
    assert_near(&found.x, &[1.0, 1.0], 1e-8);
    // With x2 <= 0.25 both limits of x1 are inactive: the answer is where d/dx1 of 100 (0.25 - x1^2)^2 + (1 - x1)^2 is zero.
    let found = solve(rosenbrock, &[-1.2, 0.0], &[(-2.0, 2.0), (-2.0, 0.25)], Options::default());
    let slope = |x: f64| -400.0 * x * (0.25 - x * x) - 2.0 * (1.0 - x);
    assert!(slope(found.x[0]).abs() < 1e-5 && found.x[1] == 0.25 && found.x[0] > 0.0, "{}", found.x);
}

/// The Jacobian is singular at the solution: convergence is linear, and the residuals become small long before x does.
#[test]
fn powell_s_singular_function() {
    let powell = |x: &DVector<f64>| {
        vec![
            x[0] + 10.0 * x[1],
            5f64.sqrt() * (x[2] - x[3]),
            (x[1] - 2.0 * x[2]).powi(2),
            10f64.sqrt() * (x[0] - x[3]).powi(2),
        ]
    };
    let found =
        solve(powell, &[3.0, -1.0, 0.0, 1.0], &[FREE; 4], Options { decrease: 1e-20, ..Options::default() });
    assert!(found.point.norm_squared() < 1e-16, "{}", found.point.norm_squared());
    assert_near(&found.x, &[0.0; 4], 1e-3);
}

/// x1 of the size of 1e-5, x2 of 1e1: what one unit of a variable means must not matter.
#[test]
fn powell_s_badly_scaled_function() {
    let badly = |x: &DVector<f64>| vec![1e4 * x[0] * x[1] - 1.0, (-x[0]).exp() + (-x[1]).exp() - 1.0001];
    let found = solve(badly, &[0.0, 1.0], &[FREE; 2], Options::default());
    assert!((found.x[0] / 1.098_159_327_696e-5 - 1.0).abs() < 1e-6, "{}", found.x);
    assert!((found.x[1] / 9.106_146_739_866 - 1.0).abs() < 1e-6, "{}", found.x);
}

/// 33 readings of two decays with a background; the sum of squares of the literature is 5.46489e-5.
#[test]
fn osborne_s_first_function() {
    const Y: [f64; 33] = [
        0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685, 0.658,
        0.628, 0.603, 0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448, 0.438, 0.431,
        0.424, 0.420, 0.414, 0.411, 0.406,
    ];
    let osborne = |x: &DVector<f64>| {
        let at = |k: usize| {
            let t = 10.0 * k as f64;
            Y[k] - (x[0] + x[1] * (-t * x[3]).exp() + x[2] * (-t * x[4]).exp())
        };
        (0..Y.len()).map(at).collect::<Vec<_>>()
    };
    let found = solve(osborne, &[0.5, 1.5, -1.0, 0.01, 0.02], &[FREE; 5], Options::default());
    let cost = found.point.norm_squared();
    assert!((cost / 5.464_894_7e-5 - 1.0).abs() < 1e-6, "{cost}");
}

/// Linear problems in a box against a search over all sets of active limits.
#[test]
fn linear_problems_in_a_box_are_solved_as_a_search_over_all_faces_does() {
    let columns = [[1.0, 0.9, 0.2], [0.8, 1.1, -0.3], [0.1, 0.4, 1.0], [0.5, -0.2, 0.3]];
    for target in [[2.0, -1.0, 0.5, 1.0], [-3.0, 2.0, 4.0, 0.0], [0.1, 0.1, 0.1, 0.1], [5.0, 5.0, -5.0, 2.0]]
    {
        let residuals = |x: &DVector<f64>| {
            (0..4).map(|i| (0..3).map(|k| columns[i][k] * x[k]).sum::<f64>() - target[i]).collect::<Vec<_>>()
        };
        let limits = [(-1.0, 1.0); 3];
        let found = solve(residuals, &[0.0; 3], &limits, Options::default());
        let cost = |x: &[f64]| residuals(&DVector::from_column_slice(x)).iter().map(|r| r * r).sum::<f64>();
        let mut least = f64::MAX;
        for face in 0..27 {
            let side = |k: usize| [None, Some(-1.0), Some(1.0)][face / 3usize.pow(k as u32) % 3];
            let free: Vec<usize> = (0..3).filter(|k| side(*k).is_none()).collect();
            let fixed = |i: usize| (0..3).filter_map(|k| Some(columns[i][k] * side(k)?)).sum::<f64>();
            let a = DMatrix::from_fn(4, free.len(), |i, c| columns[i][free[c]]);
            let b = DVector::from_fn(4, |i, _| target[i] - fixed(i));
            let y =
                if free.is_empty() { DVector::zeros(0) } else { a.svd(true, true).solve(&b, 1e-12).unwrap() };
            let x: Vec<f64> = (0..3)
                .map(|k| side(k).unwrap_or_else(|| y[free.iter().position(|f| *f == k).unwrap()]))
                .collect();
            if x.iter().all(|v| v.abs() <= 1.0) {
                least = least.min(cost(&x));
            }
        }
        assert!(found.point.norm_squared() <= least * (1.0 + 1e-9) + 1e-15, "{target:?}: {least}");
    }
}

/// A variable that the residuals do not depend on stays where it was, to the last bit.
#[test]
fn a_variable_without_influence_stays() {
    let found = solve(|x| vec![x[0] * x[0] - 4.0], &[1.0, 10.05], &[FREE; 2], Options::default());
    assert_near(&found.x, &[2.0, 10.05], 1e-9);
    assert_eq!(found.x[1], 10.05);
}

/// A trial step into a region without an answer is shortened; a start there is an error.
#[test]
fn evaluations_that_fail() {
    let log = |x: &DVector<f64>| vec![x[0].ln() + 3.0];
    let found = solve(log, &[20.0], &[FREE], Options::default());
    assert_near(&found.x, &[(-3f64).exp()], 1e-10);
    assert!(
        minimise(&Function(log, None), DVector::from_element(1, -1.0), &[FREE], &Options::default()).is_err()
    );
}

/// The units of the variables do not change the path.
#[test]
fn units_do_not_matter() {
    let plain = solve(rosenbrock, &[-1.2, 1.0], &[FREE; 2], Options::default());
    let scaled = |x: &DVector<f64>| rosenbrock(&DVector::from_vec(vec![1e-3 * x[0], 1e5 * x[1]]));
    let scaled = solve(scaled, &[-1200.0, 1e-5], &[FREE; 2], Options::default());
    assert_near(&scaled.x, &[1000.0, 1e-5], 1e-4);
    assert!(
        plain.evaluations.abs_diff(scaled.evaluations) <= 2,
        "{} {}",
        plain.evaluations,
        scaled.evaluations
    );
}

/// Reused sensitivities save linearisations and do not change the solution: convergence is judged with new sensitivities.
#[test]
fn slopes_can_be_used_again() {
    let decay = |x: &DVector<f64>| {
        (0..20)
            .map(|k| f64::from(k) / 10.0)
            .map(|t| x[0] * (-x[1] * t).exp() - 2.0 * (-1.5 * t).exp())
            .collect::<Vec<_>>()
    };
    let options = Options { relative_decrease: 1e-10, ..Options::default() };
    let fresh = solve(decay, &[1.0, 1.0], &[FREE; 2], options);
    let chords = solve(decay, &[1.0, 1.0], &[FREE; 2], Options { chords: 5, ..options });
    assert_near(&fresh.x, &[2.0, 1.5], 1e-6);
    assert_near(&chords.x, &[2.0, 1.5], 1e-6);
    assert!(
        chords.linearisations < fresh.linearisations,
        "{} {}",
        chords.linearisations,
        fresh.linearisations
    );
}

#[test]
fn the_most_linearisations_are_said() {
    let options = Options { linearisations: 3, ..Options::default() };
    let start = DVector::from_column_slice(&[-1.2, 1.0]);
    let found = minimise(&Function(rosenbrock, None), start, &[FREE; 2], &options).unwrap();
    assert_eq!((found.status, found.linearisations), (Status::Unfinished, 3));
}

/// A simulation rounds its residuals: at the solution no step decreases them, and the slopes still promise a little. One step shows that.
#[test]
fn rounded_residuals_end_the_search_at_the_solution() {
    let options = Options { decrease: 1e-3, damping: 1e-6, gradient: 0.0, step: 0.0, ..Options::default() };
    let decay = |x: &DVector<f64>| {
        let of = |k: i32| f64::from(k).sqrt() - 3.0 * x[0] * (-0.1 * f64::from(k) * x[1]).exp();
        (0..20).map(of).collect::<Vec<_>>()
    };
    let rounded = Function(decay, Some(1e-4));
    let run = |start: DVector<f64>| minimise(&rounded, start, &[FREE; 2], &options).unwrap();
    let first = run(DVector::from_vec(vec![1.0, -0.5]));
    let again = run(first.x);
    assert_eq!((first.status, again.status), (Status::Decrease, Status::Decrease));
    assert!(again.evaluations <= 3 && again.linearisations <= 2, "{} evaluations", again.evaluations);
}

/// A damping that is small against N changes no step: after a failure it is increased until the step is another one.
#[test]
fn a_small_damping_costs_no_evaluations() {
    let evaluations = |damping: f64| {
        let arc = |x: &DVector<f64>| vec![x[0].atan()];
        solve(arc, &[3.0], &[FREE], Options { damping, ..Options::default() }).evaluations
    };
    let usual = evaluations(1e-3);
    for damping in [1e-12, 1e-9, 1e-6] {
        assert!(evaluations(damping) <= usual + 1, "{} instead of {usual}", evaluations(damping));
    }
}

/// A minimum of 1 beside a rival with 0.5: the search ends before it; beside a rival with 2 it does not.
#[test]
fn a_search_that_cannot_beat_its_rival_ends() {
    let of = |rival: f64| {
        let arc = |x: &DVector<f64>| vec![1.0, (0.1 * x[0]).exp() - 1.0, 0.1 * (x[0] - x[1])];
        let options = Options { rival, damping: 1.0, ..Options::default() };
        minimise(&Function(arc, None), DVector::from_vec(vec![9.0, -3.0]), &[FREE; 2], &options).unwrap()
    };
    let (ended, whole) = (of(0.5), of(2.0));
    assert_eq!(ended.status, Status::Unfinished);
    assert!(ended.linearisations < whole.linearisations, "{} {}", ended.linearisations, whole.linearisations);
    assert!(whole.status != Status::Unfinished && whole.point.norm_squared() < 1.0 + 1e-9);
}
