use super::*;
use crate::testing::normal;

fn column(n: usize, of: impl Fn(f64) -> f64) -> DMatrix<f64> {
    DMatrix::from_fn(n, 1, |k, _| of(k as f64 / n as f64))
}

/// Hat functions over a time of 10 000 s, for readings of nine rows each.
fn sensor(n: usize) -> (DMatrix<f64>, Vec<(f64, usize)>) {
    let points: Vec<f64> = (0..12).map(|k| k as f64 / 11.0).collect();
    let drift =
        DMatrix::from_fn(n, 12, |row, k| 3.0 * crate::hypothesis::hat(&points, k, row as f64 / n as f64));
    (drift, points.iter().map(|t| (1e4 * t, 0)).collect())
}

/// A planted signal is recovered with its size, given a parameter and sensor drift, with the variance of least squares.
#[test]
fn what_was_planted_is_found() {
    let (n, mut rng) = (400, crate::testing::rng(2));
    let fast = column(n, |t| if (40.0 * t).sin() > 0.0 { 1.0 } else { -1.0 });
    let slope = column(n, |t| 5.0 * t);
    let r = DVector::from_fn(n, |k, _| 0.7 * fast[(k, 0)] + 0.4 * slope[(k, 0)] + normal(&mut rng));
    let (drift, knots) = sensor(n);
    let gain =
        Evidence::new(r, &slope, Prior::new(&[0.0]), &drift, &knots, vec![]).unwrap().gain(&fast).unwrap();
    let deviation = gain.covariance[(0, 0)].sqrt();
    // Almost orthogonal to all other columns: deviation 1 / sqrt n.
    assert!((deviation * (n as f64).sqrt() - 1.0).abs() < 0.1, "{deviation}");
    assert!((gain.size[0] - 0.7).abs() < 3.0 * deviation, "{gain:?}");
    let expected = (0.7 / deviation).powi(2);
    assert!(gain.raw > 0.6 * expected && gain.whitened > 0.6 * expected, "{gain:?} {expected}");
}

/// Sensor drift and a slow column that resembles it: evidence against white noise alone, no evidence against drift.
#[test]
fn a_drift_is_no_effect() {
    let (n, mut rng) = (400, crate::testing::rng(4));
    let (drift, knots) = sensor(n);
    let walk = |t: f64| (3.1 * t).sin() + 0.5 * (7.3 * t + 1.0).cos();
    let r = DVector::from_fn(n, |k, _| 1.5 * walk(k as f64 / n as f64) + normal(&mut rng));
    let none = DMatrix::zeros(n, 0);
    let slow = column(n, |t| (3.0 * t).sin());
    let gain = Evidence::new(r, &none, Prior::new(&[]), &drift, &knots, vec![]).unwrap().gain(&slow).unwrap();
    assert!(gain.raw > 100.0 && gain.whitened < 10.0, "{gain:?}");
}

/// Three readings, a free mean and a ramp: of the sum of squares 14 the mean leaves 2, which the ramp explains.
#[test]
fn raw_is_the_fall_of_the_squares() {
    let r = DVector::from_vec(vec![1.0, 2.0, 3.0]);
    let (mean, ramp) = (DMatrix::from_element(3, 1, 1.0), DMatrix::from_vec(3, 1, vec![0.0, 1.0, 2.0]));
    let evidence =
        Evidence::new(r, &mean, Prior::new(&[f64::NAN]), &DMatrix::zeros(3, 0), &[], vec![]).unwrap();
    assert!((evidence.cost().1 - 2.0).abs() < 1e-6);
    let gain = evidence.gain(&ramp).unwrap();
    assert!((gain.raw - 2.0).abs() < 1e-6 && (gain.whitened - 2.0).abs() < 1e-6, "{gain:?}");
    assert!((gain.size[0] - 1.0).abs() < 1e-6 && (gain.covariance[(0, 0)] - 0.5).abs() < 1e-6);
}

/// Two values of a table with correlated priors: the estimate is that of the posterior, and of least squares without the prior.
#[test]
fn a_table_has_its_prior_until_it_is_taken_away() {
    let values = DVector::from_vec(vec![0.2, -0.1]);
    let precision = DMatrix::from_row_slice(2, 2, &[2.0, -1.0, -1.0, 2.0]);
    let units = [0.5, 2.0];
    let mut prior = Prior::new(&[0.3, f64::NAN, f64::NAN]);
    prior.table(1, &values, &precision, &units);
    let z = DMatrix::from_row_slice(4, 3, &[1.0, 0.5, 0.0, 0.0, 1.0, 2.0, 1.0, 0.0, -1.0, 2.0, 1.0, 1.0]);
    let r = DVector::from_vec(vec![0.4, 1.0, -0.5, 0.7]);
    let evidence = Evidence::new(r.clone(), &z, prior, &DMatrix::zeros(4, 0), &[], vec![]).unwrap();
    let scale = DMatrix::from_diagonal(&DVector::from_row_slice(&units));
    let normal = |with: f64| {
        let mut l = z.tr_mul(&z);
        let mut rhs = z.tr_mul(&r);
        (l[(0, 0)], rhs[0]) = (l[(0, 0)] + 1.0, rhs[0] - 0.3);
        let mut own = l.view_mut((1, 1), (2, 2));
        own += &scale * &precision * &scale * with;
        let mut pull = rhs.rows_mut(1, 2);
        pull -= &scale * &precision * &values * with;
        l.cholesky().unwrap().solve(&rhs)
    };
    for (evidence, with) in [(evidence.without_tables().unwrap().into_owned(), 0.0), (evidence, 1.0)] {
        let (moves, _) = evidence.estimate(3, None);
        let expected = normal(with);
        assert!(
            moves.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-6),
            "{with}: {moves:?} {expected}"
        );
        // Minus twice the logarithm of the posterior density at its maximum.
        let x = &values + &scale * expected.rows(1, 2);
        let cost = (&r - &z * &expected).norm_squared()
            + (0.3 + expected[0]).powi(2)
            + with * x.dot(&(&precision * &x));
        assert!((evidence.cost().1 - cost).abs() < 1e-6, "{with}: {} {cost}", evidence.cost().1);
    }
}

/// Two laws of the null model with small errors: a residual that resembles them is no evidence for an effect, since structure error of
/// the observed size explains it; a much larger residual is.
#[test]
fn structure_error_is_no_effect() {
    let (n, mut rng) = (400, crate::testing::rng(6));
    let waves = DMatrix::from_fn(n, 12, |k, j| 1.4 * ((j + 1) as f64 * 0.008 * k as f64 + j as f64).sin());
    let none = DMatrix::zeros(n, 0);
    let column = column(n, |t| (10.0 * t).sin());
    let mut found = |size: f64, effect: f64| {
        let numbers = DVector::from_fn(12, |_, _| size * normal(&mut rng));
        let r = &waves * numbers + effect * &column + DVector::from_fn(n, |_, _| normal(&mut rng));
        let evidence = Evidence::new(r, &none, Prior::new(&[]), &none, &[], vec![])
            .unwrap()
            .with_structure(&waves)
            .unwrap();
        (evidence.structure(), evidence.gain(&column.columns(0, 1).into_owned()).unwrap())
    };
    let (size, gain) = found(0.0, 0.0);
    assert!(size <= NEGLIGIBLE && gain.whitened < 10.0, "{size} {gain:?}");
    let (size, gain) = found(1.0, 0.0);
    assert!((0.4..3.0).contains(&size) && gain.whitened < 10.0 && gain.raw > 100.0, "{size} {gain:?}");
    let (_, gain) = found(0.0, 5.0);
    assert!(gain.whitened > 30.0, "{gain:?}");
    assert!((gain.size[0] - 5.0).abs() < 1.0, "{gain:?}");
}

/// -2 log of a normal density, without the constant 2 pi.
fn minus_two_log(r: &DVector<f64>, mean: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
    let factor = covariance.clone().cholesky().unwrap();
    let off = r - mean;
    off.dot(&factor.solve(&off)) + covariance.determinant().ln()
}

/// Eq. (2) and (4) against explicit densities: four readings, a parameter with a deviation of 0.3 from its prior, drift of a sensor
/// with two points, a shape with two coefficients.
#[test]
fn evidence_is_that_of_the_densities() {
    let r = DVector::from_vec(vec![2.0, -1.0, 0.5, 3.0]);
    let z = DMatrix::from_vec(4, 1, vec![1.0, 0.5, -0.5, 0.2]);
    let s = DMatrix::from_vec(4, 2, vec![1.0, 0.0, 0.3, 2.0, 0.1, -1.0, 0.4, 0.6]);
    let kernel = DMatrix::from_vec(2, 2, vec![1.0, 0.5, 0.5, 1.0]);
    let mean = &z * DVector::from_element(1, -0.3);
    let one = DMatrix::<f64>::identity(4, 4);
    let plain = &one + &z * z.transpose();
    let evidence =
        Evidence::new(r.clone(), &z, Prior::new(&[0.3]), &DMatrix::zeros(4, 0), &[], vec![]).unwrap();
    let power = s.transpose() * plain.clone().cholesky().unwrap().solve(&s);
    let with = |size: f64| &plain + &s * &kernel * s.transpose() * (size / (power.trace() / 2.0));
    let told = SIZES.iter().map(|size| minus_two_log(&r, &mean, &with(*size)));
    let told = minus_two_log(&r, &mean, &plain) - told.fold(f64::INFINITY, f64::min);
    let gain = evidence.shape(&s, &kernel).unwrap();
    assert!((gain.raw - told).abs() < 1e-6, "{} instead of {told}", gain.raw);
    let drift = DMatrix::from_vec(4, 2, vec![1.0, 0.5, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0]);
    let evidence =
        Evidence::new(r.clone(), &z, Prior::new(&[0.3]), &drift, &[(0.0, 0), (1e3, 0)], vec![]).unwrap();
    let costs = DRIFTS.iter().map(|(sd, length)| {
        let near = (-1e3 / length).exp();
        let k = DMatrix::from_vec(2, 2, vec![1.0, near, near, 1.0]) * (sd * sd);
        let drifting = &drift * k * drift.transpose();
        // The determinant of the parameters alone is the same for all states and omitted.
        let whole = minus_two_log(&r, &mean, &(&plain + &drifting));
        whole - (&plain + &drifting).determinant().ln() + (&one + &drifting).determinant().ln()
    });
    let told = costs.fold(f64::INFINITY, f64::min);
    assert!((evidence.cost().0 - told).abs() < 1e-4, "{:?} instead of {told}", evidence.cost());
    // Structure error of each compared size, as covariance.
    let structure = DMatrix::from_vec(4, 2, vec![0.3, -0.2, 1.5, 0.4, 1.0, 0.9, -0.8, 0.1]);
    let evidence =
        Evidence::new(r.clone(), &z, Prior::new(&[0.3]), &DMatrix::zeros(4, 0), &[], vec![]).unwrap();
    let evidence = evidence.with_structure(&structure).unwrap();
    assert!(evidence.noises[0].states.len() > 3);
    for state in &evidence.noises[0].states {
        let wrong = &structure * structure.transpose() * (state.size * state.size);
        let whole = minus_two_log(&r, &mean, &(&plain + &wrong));
        let told = whole - (&plain + &wrong).determinant().ln() + (&one + &wrong).determinant().ln();
        assert!((state.cost - told).abs() < 1e-6, "{} instead of {told}", state.cost);
    }
}

/// Noise that persists over a few values: against white noise alone a slow column explains much of it, against noise with the memory that
/// is estimated nothing; an effect is still found, with its size. White noise has no memory.
#[test]
fn noise_with_a_memory_is_no_effect() {
    let (n, mut rng) = (800, crate::testing::rng(12));
    let none = DMatrix::zeros(n, 0);
    let series = || vec![Series { output: 0, values: 0..n / 2 }, Series { output: 0, values: n / 2..n }];
    let slow = column(n, |t| (20.0 * t).sin());
    let mut found = |rho: f64, s: f64, effect: f64| {
        let mut x = 0.0;
        let r = DVector::from_fn(n, |k, _| {
            x = rho * x + s * f64::sqrt(1.0 - rho * rho) * normal(&mut rng);
            x + effect * slow[(k, 0)]
        });
        let mut evidence = Evidence::new(r, &none, Prior::new(&[]), &none, &[], series()).unwrap();
        evidence.add_memory().unwrap();
        (evidence.inflation(0), evidence.gain(&slow).unwrap())
    };
    let (inflation, gain) = found(0.0, 1.0, 0.0);
    assert!(inflation == 1.0 && gain.whitened < 10.0, "{inflation} {gain:?}");
    for _ in 0..5 {
        let (inflation, gain) = found(0.8, 4.0, 0.0);
        // s^2 (1 + rho) / (1 - rho).
        assert!((inflation / 144.0 - 1.0).abs() < 0.5, "{inflation}");
        assert!(gain.whitened < 10.0, "{gain:?}");
    }
    // The memory is estimated with the effect in the residual, so that its evidence is a lower bound.
    let (_, gain) = found(0.8, 4.0, 8.0);
    assert!(gain.whitened > 20.0 && (gain.size[0] - 8.0).abs() < 2.0, "{gain:?}");
    assert!(gain.raw > 10.0 * gain.whitened, "{gain:?}");
}
