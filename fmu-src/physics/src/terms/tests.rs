use super::*;
use num_dual::Dual64;

fn factor(driver: Driver, reference: f64, offset: f64, exponent: f64) -> Option<Factor> {
    Some(Factor { driver, offset, reference, exponent, range: Factor::UNLIMITED })
}

fn product(coefficient: f64, factors: [Option<Factor>; 3]) -> GenericTerm {
    GenericTerm::new(Port::DragTorque, Law::Product(Product { coefficient, factors }))
}

const AT: Drivers = Drivers {
    speed: -400.0,
    current: 5.0,
    load_torque: 0.1,
    winding_temperature: 400.0,
    housing_temperature: 350.0,
    ambient_temperature: 300.0,
    fan_command: 0.25,
    time: 60.0,
    copper_loss: 12.0,
    friction_loss: 3.0,
    lagged: [320.0, 0.0, 0.0],
};

/// 2 |-400/100|^0.5 ((350 - 300)/10)^2 (0.25/1)^-1 = 2 * 2 * 25 * 4 = 400.
#[test]
fn a_product_by_hand() {
    let term = product(
        2.0,
        [
            factor(Driver::Speed, 100.0, 0.0, 0.5),
            factor(Driver::HousingTemperature, 10.0, 300.0, 2.0),
            factor(Driver::FanCommand, 1.0, 0.0, -1.0),
        ],
    );
    assert!((term.value(&AT) - 400.0).abs() < 1e-12);
    assert!(!term.is_held(&AT));
    assert_eq!(product(-3.0, [None; 3]).value(&AT), -3.0);
}

/// 3 K below its offset a straight line is negative, and so is a root; a speed enters by its magnitude.
#[test]
fn temperatures_have_sides() {
    let at = Drivers { ambient_temperature: 290.0, speed: -4.0, ..AT };
    let line = product(2.0, [factor(Driver::AmbientTemperature, 1.0, 293.0, 1.0), None, None]);
    assert_eq!(line.value(&at), -6.0);
    let root = product(2.0, [factor(Driver::AmbientTemperature, 3.0, 293.0, 0.5), None, None]);
    assert_eq!(root.value(&at), -2.0);
    let dual = line.along(&at, Some((Driver::AmbientTemperature, Dual64::from(290.0).derivative())));
    assert_eq!((dual.re, dual.eps), (-6.0, 2.0));
    assert_eq!(product(1.0, [factor(Driver::Speed, 1.0, 0.0, 1.0), None, None]).value(&at), 4.0);
}

/// A power keeps the value at the end of its range, without a derivative; the range of a speed is that of its magnitude.
#[test]
fn a_power_is_held_outside_its_range() {
    let square = Factor { range: (0.0, 300.0), ..factor(Driver::Speed, 100.0, 0.0, 2.0).unwrap() };
    let term = product(2.0, [Some(square), None, None]);
    for (speed, value, held) in
        [(-400.0, 18.0, true), (300.0, 18.0, false), (-200.0, 8.0, false), (0.0, 0.0, false)]
    {
        let at = Drivers { speed, ..AT };
        assert_eq!((term.value(&at), term.is_held(&at)), (value, held), "{speed}");
        let dual = term.along(&at, Some((Driver::Speed, Dual64::from(speed).derivative())));
        assert_eq!(dual.eps, if held { 0.0 } else { 4.0 * speed / 1e4 }, "{speed}");
    }
    let line =
        Factor { range: (280.0, 360.0), ..factor(Driver::HousingTemperature, 10.0, 300.0, 1.0).unwrap() };
    for (housing_temperature, value) in [(250.0, -2.0), (290.0, -1.0), (350.0, 5.0), (400.0, 6.0)] {
        let at = Drivers { housing_temperature, ..AT };
        assert_eq!(product(1.0, [Some(line), None, None]).value(&at), value, "{housing_temperature}");
    }
}

#[test]
fn at_zero_roots_vanish_and_reciprocals_are_bounded() {
    let still = Drivers { speed: 0.0, ..AT };
    assert_eq!(product(2.0, [factor(Driver::Speed, 100.0, 0.0, 0.5), None, None]).value(&still), 0.0);
    let reciprocal = product(2.0, [factor(Driver::Speed, 100.0, 0.0, -1.0), None, None]);
    assert!((reciprocal.value(&still) - 2000.0).abs() < 1e-9);
    let dual = reciprocal.along(&AT, Some((Driver::Speed, Dual64::from(0.0).derivative())));
    assert!(dual.re.is_finite() && dual.eps.is_finite());
}

#[test]
fn a_table_is_linear_inside_and_held_outside() {
    let table = Table::new(Driver::WindingTemperature, &[300.0, 320.0, 400.0], &[1.0, 3.0, -1.0]).unwrap();
    for (at, value, held) in [
        (250.0, 1.0, true),
        (300.0, 1.0, false),
        (310.0, 2.0, false),
        (320.0, 3.0, false),
        (360.0, 1.0, false),
        (400.0, -1.0, false),
        (400.1, -1.0, true),
    ] {
        assert_eq!(table.at(at), (value, held), "at {at}");
    }
    let term = GenericTerm::new(Port::WindingHeat, Law::Table(table));
    assert_eq!((term.value(&AT), term.is_held(&AT)), (-1.0, false));
    assert!(term.is_held(&Drivers { winding_temperature: 401.0, ..AT }));
    let dual = term.along(&AT, Some((Driver::WindingTemperature, Dual64::from(350.0).derivative())));
    assert_eq!((dual.re, dual.eps), (1.5, -0.05));
}

#[test]
fn a_table_needs_two_to_thirty_two_ascending_finite_points() {
    let many: Vec<f64> = (0..40).map(f64::from).collect();
    let new = |x: &[f64], y: &[f64]| Table::new(Driver::Time, x, y);
    assert!(new(&many[..32], &many[..32]).is_some());
    assert!(new(&many[..33], &many[..33]).is_none());
    assert!(new(&[1.0], &[1.0]).is_none());
    assert!(new(&[1.0, 1.0], &[1.0, 2.0]).is_none());
    assert!(new(&[1.0, 2.0], &[1.0]).is_none());
    assert!(new(&[1.0, 2.0], &[1.0, f64::NAN]).is_none());
}

/// Rows over speed 0 and 100 rad/s, columns over 300 and 400 K: (1, 2), (3, 8). In the middle 3.5; outside an edge the edge value.
#[test]
fn a_grid_is_bilinear_inside_and_held_outside() {
    let drivers = [Driver::Speed, Driver::WindingTemperature];
    let new = |points: [&[f64]; 2], rows: &[Vec<f64>]| Grid::new(drivers, points, rows);
    let rows = [vec![1.0, 2.0], vec![3.0, 8.0]];
    let grid = new([&[0.0, 100.0], &[300.0, 400.0]], &rows).unwrap();
    for (x, y, value, held) in [
        (50.0, 350.0, 3.5, false),
        (100.0, 400.0, 8.0, false),
        (100.0, 350.0, 5.5, false),
        (200.0, 350.0, 5.5, true),
        (50.0, 290.0, 2.0, true),
    ] {
        assert_eq!(grid.at(x, y), (value, held), "{x} {y}");
    }
    let term = GenericTerm::new(Port::WindingHeat, Law::Grid(grid));
    let at = Drivers { speed: 50.0, winding_temperature: 350.0, ..AT };
    let dual = term.along(&at, Some((Driver::WindingTemperature, Dual64::from(350.0).derivative())));
    assert_eq!((dual.re, dual.eps), (3.5, 0.03));
    assert!(term.follows(Driver::Speed) && !term.is_held(&at) && term.is_held(&AT));
    assert!(new([&[0.0], &[300.0, 400.0]], &rows[..1]).is_none());
    assert!(new([&[0.0, 100.0], &[400.0, 300.0]], &rows).is_none());
    assert!(new([&[0.0, 100.0], &[300.0, 400.0]], &[vec![1.0, 2.0], vec![3.0, f64::NAN]]).is_none());
    assert!(Grid::new([Driver::Speed; 2], [&[0.0, 1.0], &[0.0, 1.0]], &rows).is_none());
}

/// The state of a lag replaces its driver, without a derivative with respect to it.
#[test]
fn a_lagged_driver_is_the_state_of_its_lag() {
    let law = product(2.0, [factor(Driver::WindingTemperature, 10.0, 300.0, 1.0), None, None]).law;
    let lag = Some(Lag { driver: Driver::WindingTemperature, tau: 60.0, difference: false });
    let term = GenericTerm { port: Port::TorqueConstant, law, lag };
    let live = Some((Driver::WindingTemperature, Dual64::from(400.0).derivative()));
    let late = term.along_as(0, &AT, live);
    assert_eq!((late.re, late.eps), (4.0, 0.0));
    assert!(!term.follows(Driver::WindingTemperature) && term.is_whole());
    let heat = product(1.0, [factor(Driver::CopperLoss, 1.0, 0.0, 1.0), None, None]);
    let lag = |driver, tau| GenericTerm { lag: Some(Lag { driver, tau, difference: false }), ..heat };
    assert!(!heat.is_whole() && lag(Driver::CopperLoss, 60.0).is_whole());
    assert!(!lag(Driver::Speed, 60.0).is_whole() && !lag(Driver::CopperLoss, 0.0).is_whole());
}

/// 0.5 W/K to a mass of 330 K, from a node at 350 K: the node loses 10 W, and 0.5 W more with each kelvin.
#[test]
fn a_mass_gives_the_heat_of_the_difference() {
    let law = product(1.0, [factor(Driver::HousingTemperature, 2.0, 0.0, 1.0), None, None]).law;
    let lag = Lag { driver: Driver::HousingTemperature, tau: 60.0, difference: true };
    let term = GenericTerm { port: Port::HousingHeat, law, lag: Some(lag) };
    let at = Drivers { housing_temperature: 350.0, lagged: [0.0, 330.0, 0.0], ..AT };
    let live = Some((Driver::HousingTemperature, Dual64::from(350.0).derivative()));
    let heat = term.along_as(1, &at, live);
    assert_eq!((heat.re, heat.eps), (-10.0, -0.5));
    assert_eq!(term.along_as(1, &at, None::<(Driver, f64)>), -10.0);
    assert_eq!(term.along_as(1, &at, Some((Driver::Speed, 5.0))), -10.0, "another driver within the step");
    assert!(term.follows(Driver::HousingTemperature) && !term.follows(Driver::Speed) && term.is_whole());
    assert_eq!(term.mass(), Some([0.5, 30.0]));
    assert_eq!(GenericTerm { port: Port::WindingHeat, ..term }.mass(), None);
    assert_eq!(GenericTerm { lag: Some(Lag { difference: false, ..lag }), ..term }.mass(), None);
    // The present heat flow is unknown when the terms are evaluated.
    let of_heat = Lag { driver: Driver::CopperLoss, ..lag };
    let law = product(1.0, [factor(Driver::CopperLoss, 1.0, 0.0, 1.0), None, None]).law;
    assert!(!GenericTerm { law, lag: Some(of_heat), ..term }.is_whole());
}

#[test]
fn names_lead_back() {
    assert!(Port::ALL.iter().all(|port| Port::by_name(port.name()) == Some(*port)));
    assert!(Driver::ALL.iter().all(|driver| Driver::by_name(driver.name()) == Some(*driver)));
    assert_eq!((Port::ALL.len(), Port::by_name("nothing")), (15, None));
}

/// A lag of a fan that stands still decays to any number; the law and its derivative are those of the formula down to the smallest.
#[test]
fn a_power_of_a_lag_that_has_decayed_has_a_derivative() {
    for exponent in [0.1, 0.659, 1.0, 2.5, 5.0] {
        for fan in [1e-3, 1e-60, 1.9e-132, 3e-308, f64::MIN_POSITIVE * f64::EPSILON] {
            let term = product(2.0, [factor(Driver::FanCommand, 1.0, 0.0, exponent), None, None]);
            let at = Drivers { fan_command: fan, ..AT };
            let dual = term.along(&at, Some((Driver::FanCommand, Dual64::from(fan).derivative())));
            let (value, slope) = (2.0 * fan.powf(exponent), 2.0 * exponent * fan.powf(exponent - 1.0));
            assert_eq!(dual.re, value, "{exponent} {fan}");
            // A value that underflows has the derivative 0.
            let off = (dual.eps - slope).abs();
            assert!(
                off <= 1e-9 * slope || (value == 0.0 && off < 1e-100),
                "{exponent} {fan}: {dual} {slope}"
            );
            let other = term.along(&at, Some((Driver::WindingTemperature, Dual64::from(350.0).derivative())));
            assert_eq!((other.re, other.eps), (value, 0.0), "{exponent} {fan}");
        }
    }
}

/// The starts of lags are divided by typical values, which users find in the document that describes them.
#[test]
fn the_document_has_the_typical_values() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/close-the-loop.md"));
    let text = text.unwrap().replace('\n', " ");
    for driver in Driver::ALL.iter().filter(|d| **d != Driver::Time) {
        let unit = driver.unit().name();
        let value = format!("{} {}", driver.nominal(), if unit == "1" { "for" } else { unit });
        assert!(text.contains(&value), "{}: {value}", driver.name());
    }
}
