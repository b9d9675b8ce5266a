use super::*;
use crate::testing;
use physics::terms::{GenericTerm, Law, Product};

const PRIORS: &str = "\"motor.R_ref\" = 0.1\n\"conductance.G_still\" = 0.1\n\
                      \"effect.coulomb_friction.tau_c\" = 0.5\n\"thermal.C_h\" = 0.1";

fn preset(experiment: &crate::experiment::Experiment) -> Vec<f64> {
    Setup::new(experiment, &[]).unwrap().preset().declared
}

#[test]
fn planted_numbers_come_back() {
    let mut experiment = testing::experiment(PRIORS, true);
    let mut truth = preset(&experiment);
    truth.iter_mut().zip([1.03, 0.93, 1.4, 1.08]).for_each(|(x, share)| *x *= share);
    testing::read(&mut experiment, &truth, None);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let found = setup.fit(setup.preset(), &[0]).unwrap();
    for ((found, told), d) in found.hypothesis.declared.iter().zip(&truth).zip(&setup.declared) {
        assert!((found / told - 1.0).abs() < 2e-3, "{}: {found} instead of {told}", d.name);
    }
    assert_eq!(found.readings, 1200);
}

/// Two runs with different positions of the winding sensor: its offset is an unknown of each run and is estimated jointly with the
/// common parameters.
#[test]
fn unknowns_of_single_runs_come_back() {
    use crate::experiment::{Deviation, Prior, Role};
    let mut experiment = testing::experiment(PRIORS, true);
    let mut truth = preset(&experiment);
    truth.iter_mut().zip([1.03, 0.93, 1.4, 1.08]).for_each(|(x, share)| *x *= share);
    testing::read(&mut experiment, &truth, None);
    let deviation = Deviation::Absolute(2.0);
    let offset = "effect.winding_sensor_offset.offset";
    experiment.runs[0].priors = vec![Prior { name: offset.to_string(), deviation }];
    let mut second = experiment.runs[0].clone();
    second.file = "second.csv".to_string();
    // The same file as a test run, which is not fitted.
    let again = crate::experiment::Run { role: Role::Test, priors: Vec::new(), ..second.clone() };
    experiment.runs.extend([second, again]);
    let winding = experiment.inputs.len() + 2;
    for (run, off) in experiment.runs.iter_mut().zip([1.5, -0.8, -0.8]) {
        run.table.columns[winding].iter_mut().for_each(|x| *x += off);
    }
    let setup = Setup::new(&experiment, &[]).unwrap();
    let found = setup.fit(setup.preset(), &[0, 1]).unwrap();
    let names: Vec<&str> = setup.declared.iter().map(|d| d.name.as_str()).collect();
    assert_eq!(names[4..], [format!("{offset} [run.csv]"), format!("{offset} [second.csv]")]);
    for ((found, told), name) in
        found.hypothesis.declared.iter().zip(truth.iter().chain(&[1.5, -0.8])).zip(names)
    {
        assert!((found / told - 1.0).abs() < 5e-3, "{name}: {found} instead of {told}");
    }
    // The offset of the second file applies in every role of that file; the common model has no offset.
    let slot = setup.declared[4].slot;
    let of =
        |change: crate::overrides::Override| change.values.iter().find(|(s, _)| *s == slot).map(|(_, v)| *v);
    assert_eq!(of(setup.change(&found.hypothesis, 2)), Some(found.hypothesis.declared[5]));
    assert_eq!(of(setup.common_change(&found.hypothesis, 0)), None);
    assert_eq!(of(setup.common_change(&found.hypothesis, 2)), None);
}

/// A driving torque asks for negative friction. The estimate stops at the limit zero, and the speed-dependent coefficient, which a
/// joint step could not distinguish from it, still converges to its optimum.
#[test]
fn one_that_stands_at_its_limit_does_not_stop_the_others() {
    let priors = format!("{PRIORS}\n\"effect.viscous_friction.k\" = 10");
    let mut experiment = testing::experiment(&priors, true);
    let mut truth = preset(&experiment);
    let place = |name: &str| experiment.priors.iter().position(|p| p.name == name).unwrap();
    let (none, grows) = (place("effect.coulomb_friction.tau_c"), place("effect.viscous_friction.k"));
    truth[none] = 0.0;
    truth[grows] = 2e-5;
    let law = Law::Product(Product { coefficient: -1e-4, factors: [None; 3] });
    testing::read(&mut experiment, &truth, Some(GenericTerm::new(Port::DragTorque, law)));
    let setup = Setup::new(&experiment, &[]).unwrap();
    let found = setup.fit(setup.preset(), &[0]).unwrap();
    assert_eq!(found.hypothesis.declared[none], 0.0);
    for (k, d) in setup.declared.iter().enumerate().filter(|(k, _)| *k != none) {
        for share in [0.997, 1.003] {
            let mut other = found.hypothesis.clone();
            other.declared[k] *= share;
            let other = setup.judged(other, &[0]).unwrap().cost;
            assert!(other > found.cost, "{} at {share}: {other} instead of {}", d.name, found.cost);
        }
    }
}

/// A table over the speed with a point that no row reaches: its value follows from its neighbour by the prior, whatever the fit starts with.
#[test]
fn a_point_without_data_has_the_value_of_its_prior() {
    use crate::hypothesis::{Addition, Axis, Number, Shape};
    use crate::linearization::Linearization;
    use crate::outcome::Follows;
    use physics::terms::{Driver, Factor};
    let mut experiment = testing::experiment(PRIORS, true);
    let truth = preset(&experiment);
    let factor = Factor {
        driver: Driver::Speed,
        offset: 0.0,
        reference: 300.0,
        exponent: 1.0,
        range: Factor::UNLIMITED,
    };
    let law = Law::Product(Product { coefficient: 1e-3, factors: [Some(factor), None, None] });
    testing::read(&mut experiment, &truth, Some(GenericTerm::new(Port::DragTorque, law)));
    let setup = Setup::new(&experiment, &[]).unwrap();
    // The speed of the run is 100 to 500 rad/s.
    let knots = vec![100.0, 500.0, 1500.0];
    let like = |a: f64, b: f64| f64::exp(-(a - b).abs() / 1400.0);
    let kernel = DMatrix::from_fn(3, 3, |a, b| like(knots[a], knots[b]) * 2e-3f64.powi(2));
    let expected = like(500.0, 1500.0);
    let number = |value: f64| Number {
        symbol: "value".to_string(),
        value,
        limits: (f64::NEG_INFINITY, f64::INFINITY),
        unit: "N.m",
        scale: 1e-4,
        sloped: true,
    };
    let table = Addition {
        id: "generic_term".to_string(),
        port: Port::DragTorque,
        follows: Follows::Driver(Driver::Speed),
        shape: Shape::Table {
            axes: vec![Axis { driver: Driver::Speed, knots, is_even: false }],
            precision: kernel.try_inverse().unwrap(),
        },
        numbers: [0.0, 0.0, 0.5].map(number).to_vec(),
        active: vec![true],
    };
    let start = Hypothesis { additions: vec![table], ..setup.preset() };
    let fitted = setup.fit(start, &[0]).unwrap();
    let found = &fitted.hypothesis;
    let values: Vec<f64> = found.additions[0].numbers.iter().map(|n| n.value).collect();
    // The Coulomb friction takes over a constant.
    assert!(((values[1] - values[0]) / (1e-3 * 400.0 / 300.0) - 1.0).abs() < 0.01, "{values:?}");
    assert!((values[2] / values[1] - expected).abs() < 1e-3, "{values:?}, {expected}");
    // The same holds for the correction to first order, and its deviation is that of the prior given the neighbour.
    let place = found.numbers().len() - 1;
    let point = Linearization::judged(&setup, fitted.clone(), &[0]).unwrap().estimated(None);
    assert!((point.moved[place] / point.moved[place - 1] - expected).abs() < 0.02, "{:?}", point.moved);
    let deviation = 1e-4 * point.covariance[(place, place)].sqrt();
    assert!((deviation / (2e-3 * (1.0 - expected * expected).sqrt()) - 1.0).abs() < 0.1, "{deviation}");
}

/// A lag of the winding is its heat capacity or its thermometer, and a fit may end with the wrong one of them: with a capacity at its limit.
#[test]
fn a_fit_that_ends_at_a_limit_is_repeated_from_the_priors() {
    let priors = format!("{PRIORS}\n\"thermal.C_w\" = 0.1\n\"thermal.R_wh\" = 0.2");
    let mut experiment = testing::experiment(&priors, true);
    let truth = preset(&experiment);
    testing::read_of(&mut experiment, |setup| {
        let additions = vec![testing::addition(setup, "winding_sensor_lag", 40.0)];
        setup.change(&Hypothesis { declared: truth.clone(), additions }, 0)
    });
    let setup = Setup::new(&experiment, &[]).unwrap();
    let own = experiment.priors.iter().position(|p| p.name == "thermal.C_w").unwrap();
    for tau in [0.5, 2.0, 100.0] {
        let mut start = setup.preset();
        start.declared[own] = setup.declared[own].limits.1;
        start.additions.push(testing::addition(&setup, "winding_sensor_lag", tau));
        let plain = setup.fit(start.clone(), &[0]).unwrap();
        assert!(!setup.declared[own].is_inside(plain.hypothesis.declared[own]), "{tau}: {}", plain.cost);
        let found = setup.fit_addition(start, &[0]).unwrap();
        let [capacity, lag] =
            [found.hypothesis.declared[own], found.hypothesis.additions[0].numbers[0].value];
        assert!(
            (capacity / truth[own] - 1.0).abs() < 0.01 && (lag / 40.0 - 1.0).abs() < 0.01,
            "{capacity}, {lag}"
        );
    }
}
