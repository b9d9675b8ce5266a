use super::*;

fn number(value: f64, sloped: bool) -> Number {
    let limits = (f64::NEG_INFINITY, f64::INFINITY);
    Number { symbol: "x".to_string(), value, limits, unit: "1", scale: 1.0, sloped }
}

fn addition(shape: Shape, numbers: &[f64]) -> Addition {
    Addition {
        id: "generic_term".to_string(),
        port: Port::DragTorque,
        follows: Follows::Driver(Driver::Speed),
        shape,
        numbers: numbers.iter().map(|x| number(*x, true)).collect(),
        active: vec![true],
    }
}

/// A power of the speed relative to 200 rad/s, without a range.
fn speed_to(exponent: f64) -> Factor {
    Factor { driver: Driver::Speed, offset: 0.0, reference: 200.0, exponent, range: Factor::UNLIMITED }
}

/// Derivatives of a law with a lag, including that with respect to the time constant, against differences along a run.
#[test]
fn slopes_of_a_lag_are_those_of_its_law() {
    let time: Vec<f64> = (0..200).map(|k| 3.0 * f64::from(k)).collect();
    let drivers: Vec<Drivers> = time.iter().map(|t| at(300.0 + 200.0 * (t / 40.0).sin())).collect();
    let factor = speed_to(1.0);
    let (late, mass) = (Follows::Late(Driver::Speed), Follows::Mass(Driver::Speed));
    for (follows, shape, numbers) in [
        (late, Shape::Power { factor }, &[0.3, 1.4, 60.0][..]),
        (mass, Shape::Linear { factor }, &[0.3, 60.0]),
    ] {
        slopes_are_differences(&time, &drivers, numbers, |numbers| Addition {
            follows,
            ..addition(shape.clone(), numbers)
        });
    }
}

fn slopes_are_differences(
    time: &[f64],
    drivers: &[Drivers],
    numbers: &[f64],
    with: impl Fn(&[f64]) -> Addition,
) {
    let values = |numbers: &[f64]| -> Vec<f64> {
        let own = with(numbers);
        let term = own.term().unwrap();
        let reached = followed(time, drivers, own.lag().unwrap(), 0.0);
        reached.iter().map(|z| term.value(&at(*z))).collect()
    };
    for k in 0..numbers.len() {
        let (mut more, mut less) = (numbers.to_vec(), numbers.to_vec());
        more[k] *= 1.0 + 1e-5;
        less[k] *= 1.0 - 1e-5;
        let slopes = with(numbers).slopes(k, time, drivers, 0.0);
        let pairs = values(&more).into_iter().zip(values(&less));
        let truth: Vec<f64> = pairs.map(|(a, b)| (a - b) / (2e-5 * numbers[k])).collect();
        let most = truth.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
        for (row, (slope, own)) in truth.iter().zip(&slopes).enumerate() {
            assert!((slope - own).abs() <= 2e-3 * most, "{k} {row}");
        }
    }
    let start = with(numbers).slopes(numbers.len() - 1, time, drivers, 0.0)[0];
    assert_eq!(start, 0.0);
}

fn at(speed: f64) -> Drivers {
    Drivers { speed, ..Drivers::default() }
}

/// The hat functions add up to 1 and reproduce a straight line; outside the table they are constant.
#[test]
fn hats_share_the_whole() {
    let knots = [-1.0, 0.5, 1.0, 4.0];
    let sum = |x: f64, of: &dyn Fn(usize) -> f64| (0..4).map(|k| hat(&knots, k, x) * of(k)).sum::<f64>();
    for step in 0..=100 {
        let x = -3.0 + 0.1 * f64::from(step);
        assert!((sum(x, &|_| 1.0) - 1.0).abs() < 1e-12, "{x}");
        let line = 2.0 * x.clamp(-1.0, 4.0) - 1.0;
        assert!((sum(x, &|k| 2.0 * knots[k] - 1.0) - line).abs() < 1e-12, "{x}");
    }
    assert_eq!((hat(&knots, 1, 0.5), hat(&knots, 1, 1.0), hat(&knots, 3, 9.0)), (1.0, 0.0, 1.0));
}

/// Derivatives of a power law against differences of the law, on both sides of its zero.
#[test]
fn slopes_of_a_power_are_those_of_its_law() {
    let factor = speed_to(0.7);
    let law = |numbers: &[f64], x: f64| numbers[0] * power(&factor, x, numbers[1]);
    for x in [-350.0, -20.0, 5.0, 300.0] {
        let of = addition(Shape::Power { factor }, &[0.3, 0.7]);
        for k in 0..2 {
            let (mut more, mut less) = ([0.3, 0.7], [0.3, 0.7]);
            more[k] += 1e-6;
            less[k] -= 1e-6;
            let slope = (law(&more, x) - law(&less, x)) / 2e-6;
            assert!((of.slope(k, &at(x)) - slope).abs() < 1e-8, "{x} {k}");
        }
    }
    // A drag torque changes its sign with the speed; a power of the current's magnitude does not.
    let current = Factor { driver: Driver::Current, ..factor };
    assert_eq!(power(&current, -100.0, 2.0), power(&current, 100.0, 2.0));
    let warm = Factor {
        driver: Driver::WindingTemperature,
        offset: 298.15,
        reference: 50.0,
        exponent: 1.0,
        range: Factor::UNLIMITED,
    };
    assert!((power(&warm, 248.15, 1.0) + 1.0).abs() < 1e-12);
    assert_eq!(addition(Shape::Power { factor }, &[0.3, 0.7]).slope(1, &at(0.0)), 0.0);
    let ranged = Shape::Power { factor: Factor { range: (0.0, 250.0), ..factor } };
    let narrow = Addition { port: Port::FanFlow, ..addition(ranged, &[0.3, 0.7]) };
    let [held, end] = [-400.0, 250.0].map(|x| [narrow.slope(0, &at(x)), narrow.slope(1, &at(x))]);
    assert_eq!(held, end);
}

fn table_of(axes: &[(Driver, &[f64])]) -> Shape {
    let axes: Vec<Axis> = axes
        .iter()
        .map(|(driver, knots)| Axis { driver: *driver, knots: knots.to_vec(), is_even: false })
        .collect();
    let n = values(&axes);
    Shape::Table { axes, precision: DMatrix::zeros(n, n) }
}

/// The value of a table over two drivers is the sum of its derivatives times its numbers, inside the grid and outside.
#[test]
fn a_table_over_two_drivers_is_linear_in_its_values() {
    let values = [1.0, -2.0, 0.5, 3.0, 4.0, -1.0];
    let own = addition(
        table_of(&[(Driver::Speed, &[0.0, 50.0]), (Driver::HousingTemperature, &[290.0, 310.0, 350.0])]),
        &values,
    );
    let term = own.term().unwrap();
    for (speed, housing_temperature) in [(0.0, 310.0), (20.0, 333.0), (49.0, 291.0), (80.0, 280.0)] {
        let here = Drivers { speed, housing_temperature, ..Drivers::default() };
        let sum: f64 = values.iter().enumerate().map(|(k, v)| v * own.slope(k, &here)).sum();
        assert!((sum - term.value(&here)).abs() < 1e-12, "{speed} {housing_temperature}");
    }
    assert_eq!((own.kind(), own.sizes(), own.price()), (4, 6, 1.5));
}

/// A table of a magnitude is the same on both sides of zero, and linear in its values, of one driver and of two, with and without a point at
/// zero.
#[test]
fn a_table_of_a_magnitude_is_even() {
    let warm = Axis { driver: Driver::HousingTemperature, knots: vec![290.0, 350.0], is_even: false };
    for least in [0.0, 2.0] {
        let speed = Axis { driver: Driver::Speed, knots: vec![least, 20.0, 50.0], is_even: true };
        for axes in
            [vec![speed.clone()], vec![speed.clone(), warm.clone()], vec![warm.clone(), speed.clone()]]
        {
            let values: Vec<f64> = (0..values(&axes)).map(|k| (k as f64 - 1.3).powi(2)).collect();
            let precision = DMatrix::zeros(values.len(), values.len());
            let own = addition(Shape::Table { axes, precision }, &values);
            let term = own.term().unwrap();
            for speed in [0.0, 1.0, 13.0, 20.0, 44.0, 70.0] {
                let [there, back] =
                    [speed, -speed].map(|speed| Drivers { speed, housing_temperature: 310.0, ..at(speed) });
                assert!((term.value(&there) - term.value(&back)).abs() < 1e-12);
                let sum: f64 = values.iter().enumerate().map(|(k, v)| v * own.slope(k, &back)).sum();
                assert!((sum - term.value(&back)).abs() < 1e-12, "{least} {speed}");
            }
        }
    }
}

/// A loss that is a power of speed or current continues beyond the data, unless no loss has such an exponent; nothing else does.
#[test]
fn only_losses_continue_beyond_the_data() {
    let of = |port: Port, driver: Driver, exponent: f64, late: Option<Driver>| {
        let follows = late.map_or(Follows::Driver(driver), Follows::Late);
        let factor = Factor { driver, offset: 0.0, reference: 10.0, exponent: 1.0, range: (0.0, 20.0) };
        let own = Addition { port, follows, ..addition(Shape::Power { factor }, &[1.0, exponent]) };
        let at = |x: f64| own.term().unwrap().value(&Drivers::default().with(driver, x));
        at(40.0) > at(20.0)
    };
    assert!(of(Port::DragTorque, Driver::Speed, 0.75, None));
    assert!(of(Port::HousingHeat, Driver::Current, 2.0, None));
    assert!(!of(Port::DragTorque, Driver::Speed, 0.3, None));
    assert!(!of(Port::DragTorque, Driver::Speed, 4.0, None));
    assert!(!of(Port::DragTorque, Driver::FanCommand, 1.0, None));
    assert!(!of(Port::DragTorque, Driver::Speed, 1.0, Some(Driver::Speed)));
    assert!(!of(Port::FanFlow, Driver::Speed, 1.0, None));
}

/// The generic term contains the current numbers.
#[test]
fn a_term_has_its_numbers() {
    let factor = speed_to(1.0);
    let term = addition(Shape::Power { factor }, &[0.3, 0.7]).term().unwrap();
    let Law::Product(product) = term.law else { panic!("{term:?}") };
    assert_eq!((product.coefficient, product.factors[0].unwrap().exponent), (0.3, 0.7));
    let table = addition(table_of(&[(Driver::Speed, &[0.0, 10.0])]), &[1.0, 3.0]);
    assert!(matches!(table.term().unwrap().law, Law::Table(_)));
    let mut change = Override::default();
    table.apply(&mut change);
    assert_eq!((change.terms.len(), change.values.len()), (1, 0));
    let listed = addition(Shape::Listed { slots: Vec::new(), with: Vec::new(), stores: false }, &[]);
    assert!(listed.term().is_none() && listed.is_listed());
}

/// Numbers that are not found by linearization are unchanged.
#[test]
fn numbers_are_taken_in_the_order_in_which_they_are_told() {
    let mut second = addition(Shape::Listed { slots: Vec::new(), with: Vec::new(), stores: false }, &[5.0]);
    second.numbers.push(number(77.0, false));
    second.numbers.push(number(6.0, true));
    let first = addition(table_of(&[(Driver::Speed, &[0.0, 1.0])]), &[3.0, 4.0]);
    let mut hypothesis = Hypothesis { declared: vec![1.0, 2.0], additions: vec![first, second] };
    assert_eq!(hypothesis.numbers(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let others: Vec<f64> = (10..16).map(f64::from).collect();
    hypothesis.take(&others);
    assert_eq!(hypothesis.numbers(), others);
    assert_eq!(hypothesis.additions[1].numbers[1].value, 77.0);
}
