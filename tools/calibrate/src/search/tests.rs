use super::*;
use crate::hypothesis::{Axis, Hypothesis, Number};
use crate::setup::Setup;
use crate::testing::{self, NOISE, PRIORS};
use nalgebra::DMatrix;
use physics::terms::{Factor, GenericTerm, Lag, Law, Product, Table};

/// Law over a driver with given evidence and shape (driver, value).
fn law(port: Port, follows: Follows, sure: f64, shape: &[(f64, f64)]) -> Scored {
    Scored {
        addition: None,
        name: port.name().to_string(),
        port,
        follows,
        listed: false,
        evidence: sure,
        raw: sure + 1.0,
        shape: shape.iter().map(|(x, y)| (*x, *y, 0.1)).collect(),
    }
}

fn over(driver: Driver) -> Follows {
    Follows::Driver(driver)
}

/// Remaining ports for a heat and a conductance over the housing's temperature.
fn left(heat: &[(f64, f64)], of_conductance: f64) -> Vec<Port> {
    let housing = over(Driver::HousingTemperature);
    let conductance: Vec<(f64, f64)> = heat.iter().map(|(x, _)| (*x, 1.0)).collect();
    let mut all = vec![
        law(Port::HousingHeat, housing, 100.0, heat),
        law(Port::HousingAmbientConductance, housing, of_conductance, &conductance),
    ];
    leave_to_the_air(&mut all);
    all.iter().map(|s| s.port).collect()
}

#[test]
fn heat_that_falls_as_the_housing_warms_leaves_by_a_conductance() {
    let falling = [(300.0, 1.0), (310.0, 0.2), (320.0, -2.0)];
    assert_eq!(left(&falling, 95.0), [Port::HousingAmbientConductance]);
    // A conductance that explains far less describes another effect.
    assert_eq!(left(&falling, 85.0).len(), 2);
    // A heat that increases with temperature is not a loss.
    let growing = falling.map(|(x, y)| (x, -y));
    assert_eq!(left(&growing, 95.0).len(), 2);
    // For a power law the sign of the coefficient decides.
    assert_eq!((left(&[(0.0, -1.0)], 95.0).len(), left(&[(0.0, 1.0)], 95.0).len()), (1, 2));
}

/// A heat over temperature and speed.
type Heat = fn(f64, f64) -> f64;

/// The same of two drivers, in either order, where the heat decreases with the temperature and not with the speed.
#[test]
fn a_loss_over_two_drivers_leaves_by_a_conductance() {
    let (warm, speed) = (Driver::HousingTemperature, Driver::Speed);
    let both = |port: Port, [a, b]: [Driver; 2], of: Heat| {
        let axis = |driver: Driver| Axis { driver, knots: vec![0.0, 1.0], is_even: false };
        let follows = Follows::Both(a, b);
        let mut addition = testing::law(port, follows);
        addition.shape = Shape::Table { axes: vec![axis(a), axis(b)], precision: DMatrix::identity(4, 4) };
        let number = |(x, y): (f64, f64)| {
            let value = if a == warm { of(x, y) } else { of(y, x) };
            Number { symbol: String::new(), value, limits: (-9.0, 9.0), unit: "W", scale: 1.0, sloped: true }
        };
        addition.numbers = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].map(number).to_vec();
        Scored { addition: Some(addition), ..law(port, follows, 100.0, &[(0.0, 0.0), (1.0, 0.0)]) }
    };
    let left = |of: Heat, drivers: [Driver; 2], other: [Driver; 2]| {
        let conductance = both(Port::HousingAmbientConductance, other, |_, _| 1.0);
        let mut all = vec![both(Port::HousingHeat, drivers, of), conductance];
        leave_to_the_air(&mut all);
        all.len()
    };
    let (loss, gain): (Heat, Heat) = (|t, w| 3.0 * w - t, |t, w| t - 3.0 * w);
    for order in [[warm, speed], [speed, warm]] {
        assert_eq!((left(loss, order, [speed, warm]), left(gain, order, [speed, warm])), (1, 2));
        // Another second driver is another law.
        assert_eq!(left(loss, order, [Driver::Current, warm]), 2);
    }
}

#[test]
fn what_knows_its_past_is_clear_where_no_present_value_comes_near() {
    let latch = law(Port::DragTorque, Follows::History, 1000.0, &[(310.0, 1.0)]);
    let present = |sure: f64| law(Port::DragTorque, over(Driver::Speed), sure, &[(0.0, 1.0)]);
    assert!(needs_memory(&[latch.clone(), present(850.0)]));
    assert!(!needs_memory(&[latch.clone(), present(900.0)]));
    // A law over time may describe the same effect; a latent input does not latch.
    let latent_inputs = law(Port::DragTorque, over(Driver::Time), 990.0, &[(0.0, 1.0)]);
    assert!(needs_memory(&[latch.clone(), latent_inputs]));
    let free = Scored { name: format!("{}{FREE}", latch.name), ..latch };
    assert!(!needs_memory(&[free, present(100.0)]));
}

/// Search result for simulated readings of a motor with a term, and the point of linearization.
fn found_of<T>(term: GenericTerm, see: impl Fn(&Linearization, Vec<Scored>) -> T) -> T {
    let experiment = testing::with_term(term);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let point = Linearization::new(&setup, setup.fit(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
    let scored = search(&point);
    see(&point, scored)
}

/// Magnets that warm up with a lag behind the winding: the readings determine port, driver and time constant.
#[test]
fn a_hidden_state_is_found_with_its_time_constant() {
    let factor = Factor {
        driver: Driver::WindingTemperature,
        offset: 298.15,
        reference: 10.0,
        exponent: 1.0,
        range: Factor::UNLIMITED,
    };
    let law = Law::Product(Product { coefficient: -0.02, factors: [Some(factor), None, None] });
    let lag = Some(Lag { driver: Driver::WindingTemperature, tau: 250.0, difference: false });
    found_of(GenericTerm { port: Port::TorqueConstant, law, lag }, |point, scored| {
        let late = |s: &&Scored| s.addition.as_ref().is_some_and(|a| a.lag().is_some());
        // The housing itself lags behind the winding: port and memory are identified at once, the driver only after the fit.
        let best = scored.iter().find(late).unwrap();
        assert!(
            best.port == Port::TorqueConstant && matches!(best.follows, Follows::Late(_)),
            "{}",
            best.name
        );
        // In a single run a law over time may describe the same effect.
        let is_present = |s: &&Scored| !late(s) && s.addition.is_some() && s.follows != over(Driver::Time);
        let present = scored.iter().find(is_present).unwrap();
        assert!(best.sure() > present.sure() + 30.0, "{} and {}", best.name, present.name);
        let follows = Follows::Late(Driver::WindingTemperature);
        let power = |s: &&Scored| {
            s.addition.as_ref().is_some_and(|a| !a.is_table()) && s.port == best.port && s.follows == follows
        };
        let power = scored.iter().find(power).unwrap();
        let mut hypothesis = point.setup.preset();
        hypothesis.additions.extend(power.addition.clone());
        let fitted = point.setup.fit(hypothesis, &[0]).unwrap();
        let lag = fitted.hypothesis.additions[0].lag().unwrap();
        assert!((lag.tau / 250.0 - 1.0).abs() < 0.05, "{lag:?}");
        assert!(fitted.chi_square < 10.0 * fitted.readings as f64, "{}", fitted.chi_square);
    });
}

/// A drag that rises and falls with the lagged speed: a line over it explains little at any time constant, the true one included.
#[test]
fn a_function_of_a_hidden_state_needs_no_slope() {
    let rise_and_fall = [0.0, 4e-3, 0.0, 4e-3, 0.0];
    let table = Table::new(Driver::Speed, &[100.0, 200.0, 300.0, 400.0, 500.0], &rise_and_fall).unwrap();
    let lag = Some(Lag { driver: Driver::Speed, tau: 150.0, difference: false });
    found_of(GenericTerm { port: Port::DragTorque, law: Law::Table(table), lag }, |_, scored| {
        let best = scored.iter().find(|s| s.addition.is_some()).unwrap();
        assert_eq!((best.port, best.follows), (Port::DragTorque, Follows::Late(Driver::Speed)));
        let own = best.addition.as_ref().unwrap();
        let tau = own.lag().unwrap().tau;
        assert!(own.is_table() && (tau / 150.0).ln().abs() < 0.5, "{tau}");
    });
}

/// A mass at the housing: 0.15 W/K, 300 s.
fn mass() -> GenericTerm {
    let driver = Driver::HousingTemperature;
    let factor = Factor { driver, offset: 0.0, reference: 10.0, exponent: 1.0, range: Factor::UNLIMITED };
    let law = Law::Product(Product { coefficient: 1.5, factors: [Some(factor), None, None] });
    let lag = Some(Lag { driver, tau: 300.0, difference: true });
    GenericTerm { port: Port::HousingHeat, law, lag }
}

/// A mass that the model lacks at the housing: its conductance and its time constant, and none at the winding.
#[test]
fn a_mass_at_a_node_is_found() {
    found_of(mass(), |point, scored| {
        let is_mass = |s: &&Scored| matches!(s.follows, Follows::Mass(_));
        let best = scored.iter().find(is_mass).unwrap();
        assert_eq!((best.port, best.follows), (Port::HousingHeat, Follows::Mass(Driver::HousingTemperature)));
        let mut hypothesis = point.setup.preset();
        hypothesis.additions.extend(best.addition.clone());
        let fitted = point.setup.fit(hypothesis, &[0]).unwrap();
        let own = &fitted.hypothesis.additions[0];
        let Some(GenericTerm { law: Law::Product(product), lag: Some(lag), .. }) = own.term() else {
            panic!("{own:?}")
        };
        let conductance = product.coefficient / product.factors[0].unwrap().reference;
        assert!((conductance / 0.15 - 1.0).abs() < 0.05 && lag.difference, "{own:?}");
        assert!((lag.tau / 300.0 - 1.0).abs() < 0.05, "{own:?}");
        assert!(product.factors[0].unwrap().range == Factor::UNLIMITED);
        assert!(fitted.chi_square < 2.0 * fitted.readings as f64, "{}", fitted.chi_square);
    });
}

/// A mass that was heated before the run: its start is an unknown beside its conductance and its time constant.
#[test]
fn a_mass_that_starts_warm_is_found() {
    for above in [0.15, -0.1] {
        let experiment = testing::with_warm_term(PRIORS, mass(), above, NOISE);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let point = Linearization::new(&setup, setup.fit(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
        let scored = search(&point);
        let is_mass = |s: &&Scored| matches!(s.follows, Follows::Mass(_));
        let best = scored.iter().find(is_mass).unwrap();
        assert_eq!((best.port, best.follows), (Port::HousingHeat, Follows::Mass(Driver::HousingTemperature)));
        let tau = best.addition.as_ref().unwrap().lag().unwrap().tau;
        assert!((tau / 300.0).ln().abs() < 0.7, "{tau}");
        let mut hypothesis = setup.preset();
        hypothesis.additions.extend(best.addition.clone());
        let fitted = setup.fit(hypothesis, &[0]).unwrap();
        let own = &fitted.hypothesis.additions[0];
        assert!((own.lag().unwrap().tau / 300.0 - 1.0).abs() < 0.05, "{own:?}");
        assert!(fitted.chi_square < 2.0 * fitted.readings as f64, "{}", fitted.chi_square);
    }
}

/// A product of two drivers, which a grid describes exactly: no function of one driver explains as much, and its fit leaves no residual.
#[test]
fn a_product_of_two_drivers_is_found() {
    let factor = |driver, offset, reference, exponent| {
        Some(Factor { driver, offset, reference, exponent, range: Factor::UNLIMITED })
    };
    let factors =
        [factor(Driver::Speed, 0.0, 300.0, 1.0), factor(Driver::WindingTemperature, 298.15, 10.0, 1.0), None];
    let law = Law::Product(Product { coefficient: 2e-4, factors });
    found_of(GenericTerm::new(Port::DragTorque, law), |point, scored| {
        let law = |s: &&Scored| !s.listed && s.addition.is_some() && s.port == Port::DragTorque;
        let best = scored.iter().find(law).unwrap();
        let both = [Driver::Speed, Driver::WindingTemperature];
        assert!(
            matches!(best.follows, Follows::Both(a, b) if a != b && both.contains(&a) && both.contains(&b)),
            "{}",
            best.name
        );
        let single = scored.iter().filter(law).find(|s| matches!(s.follows, Follows::Driver(_))).unwrap();
        assert!(best.sure() > single.sure() + 100.0, "{} and {}", best.name, single.name);
        let mut hypothesis = point.setup.preset();
        hypothesis.additions.extend(best.addition.clone());
        let [without, with] = [point.setup.preset(), hypothesis].map(|h| point.setup.fit(h, &[0]).unwrap());
        assert!(with.chi_square < 0.02 * without.chi_square, "{} {}", with.chi_square, without.chi_square);
    });
}

/// A law over time is scored so that it competes with other explanations; it cannot be added.
#[test]
fn a_law_over_time_is_not_added() {
    let factor = Factor {
        driver: Driver::Time,
        offset: 0.0,
        reference: 1000.0,
        exponent: 1.0,
        range: Factor::UNLIMITED,
    };
    let law = Law::Product(Product { coefficient: 0.005, factors: [Some(factor), None, None] });
    found_of(GenericTerm::new(Port::DragTorque, law), |_, scored| {
        let over_time: Vec<&Scored> =
            scored.iter().filter(|s| s.follows == over(Driver::Time) && !s.listed).collect();
        assert!(over_time.iter().any(|s| s.port == Port::DragTorque && s.sure() > 100.0));
        assert!(over_time.iter().all(|s| s.addition.is_none()));
    });
}

/// Effects of test rigs rank first by name in readings that contain them, and a fit started at zero estimates their size.
#[test]
fn effects_of_test_rigs_are_named() {
    let power = ("electrical_power_W", 4.0, 190.0);
    let current = ("current_A", 1.0, 190.0);
    let temperatures = &testing::OUTPUTS[2..];
    for (id, size, drive, outputs) in [
        ("speed_convection", 0.05, current, &testing::OUTPUTS[..]),
        ("speed_convection", 0.01, power, temperatures),
        ("torque_sensor_offset", 0.004, current, &testing::OUTPUTS[..]),
        ("torque_sensor_offset", -0.004, current, &testing::OUTPUTS[..]),
        ("stator_loss", 0.2, power, temperatures),
        ("propeller_load", 1e-8, power, temperatures),
        ("drive_loss", 0.1, power, temperatures),
    ] {
        let what = format!("{id} = {size} with {}", drive.0);
        let mut experiment = testing::driven_by(drive, outputs, PRIORS, true);
        testing::read_of(&mut experiment, |setup| {
            let additions = vec![testing::addition(setup, id, size)];
            setup.change(&Hypothesis { additions, ..setup.preset() }, 0)
        });
        let setup = Setup::new(&experiment, &[]).unwrap();
        let point = Linearization::new(&setup, setup.fit(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
        let scored = search(&point);
        let listed: Vec<&Scored> = scored.iter().filter(|s| s.listed).collect();
        assert_eq!(
            listed[0].addition.as_ref().map(|a| a.id.as_str()),
            Some(id),
            "{what}: {}",
            listed[0].name
        );
        let mut hypothesis = setup.preset();
        hypothesis.additions.extend(listed[0].addition.clone());
        let fitted = setup.fit(hypothesis, &[0]).unwrap();
        let found = &fitted.hypothesis.additions[0].numbers[0];
        assert!((found.value / size - 1.0).abs() < 0.05, "{what}: {}", found.value);
        assert!(fitted.chi_square < 2.0 * fitted.readings as f64, "{what}: {}", fitted.chi_square);
    }
}

/// An effect whose shape is far from the preset's ranks first, and is fitted, also where a parameter takes over a part of it: a friction that
/// falls with temperature, beside one that is constant.
#[test]
fn effects_of_another_shape_are_named() {
    let priors = format!("{PRIORS}\n\"effect.coulomb_friction.tau_c\" = 0.3");
    // Last: by how many times the best form explains more than that of the preset, at least.
    for (id, size, shape, times) in [
        ("lubricant_friction", 2e-3, &[0.0, 0.02][..], 1.0),
        ("lubricant_friction", 2e-3, &[0.1, 0.06], 5.0),
        ("lubricant_friction", 1e-3, &[0.95, 0.05], 1.5),
        ("speed_convection", 0.03, &[0.35], 3.0),
        ("speed_convection", 0.02, &[1.15], 1.0),
    ] {
        let what = format!("{id} = {size} with {shape:?}");
        let mut experiment = testing::driven_by(("current_A", 2.0, 190.0), &testing::OUTPUTS, &priors, true);
        testing::read_of(&mut experiment, |setup| {
            let mut addition = testing::addition(setup, id, size);
            addition.numbers[1..].iter_mut().zip(shape).for_each(|(n, value)| n.value = *value);
            setup.change(&Hypothesis { additions: vec![addition], ..setup.preset() }, 0)
        });
        let setup = Setup::new(&experiment, &[]).unwrap();
        let point = Linearization::new(&setup, setup.fit(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
        let scored = search(&point);
        let listed = scored.iter().find(|s| s.listed).unwrap();
        assert_eq!(listed.addition.as_ref().map(|a| a.id.as_str()), Some(id), "{what}: {}", listed.name);
        assert_eq!(scored.iter().filter(|s| s.name == id).count(), 1, "{what}");
        let (preset, _) = point.listed().find(|(_, forms)| forms[0].0.id == id).unwrap();
        let preset = point.evidence.gain(&point.listed_column(preset, &[true]).unwrap()).unwrap();
        assert!(
            listed.evidence > times * preset.whitened - 30.0,
            "{what}: {} {}",
            listed.evidence,
            preset.whitened
        );
        let mut hypothesis = setup.preset();
        hypothesis.additions.extend(listed.addition.clone());
        let fitted = setup.fit_addition(hypothesis, &[0]).unwrap();
        assert!(fitted.chi_square < 1.2 * fitted.readings as f64, "{what}: {}", fitted.chi_square);
    }
}

/// A large effect is beyond its limit to first order and starts half way to it; one of the wrong sign is none.
#[test]
fn the_start_of_a_large_effect_is_inside_its_limits() {
    assert_eq!(possible(0.0, 0.4, (0.0, 1.0)), Some(0.4));
    assert_eq!(possible(0.0, 7.0, (0.0, 1.0)), Some(0.5));
    assert_eq!(possible(0.0, -0.1, (0.0, 1.0)), None);
    assert_eq!(possible(0.2, -9.0, (-1.0, 1.0)), Some(-0.4));
    // At the limit already.
    assert_eq!(possible(1.0, 0.5, (0.0, 1.0)), None);
}

/// A current that reverses and rests distinguishes a drop from a voltage in series; both change the terminal voltage.
#[test]
fn a_voltage_that_does_not_reverse_is_in_series() {
    let factor = Factor {
        driver: Driver::Speed,
        offset: 0.0,
        reference: 300.0,
        exponent: 1.0,
        range: Factor::UNLIMITED,
    };
    let law = Law::Product(Product { coefficient: 0.05, factors: [Some(factor), None, None] });
    for port in [Port::TerminalVoltage, Port::SeriesVoltage] {
        let mut experiment = testing::driven_by(("current_A", 1.0, 190.0), &testing::OUTPUTS, PRIORS, true);
        let current = &mut experiment.runs[0].table.columns[0];
        current.iter_mut().enumerate().for_each(|(k, i)| *i *= [1.0, -1.0, 0.0][k / 20 % 3]);
        let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &preset, Some(GenericTerm::new(port, law)));
        let setup = Setup::new(&experiment, &[]).unwrap();
        let point = Linearization::new(&setup, setup.fit(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
        let scored = search(&point);
        let of =
            |port: Port| scored.iter().find(|s| s.port == port && s.follows == over(Driver::Speed)).unwrap();
        let other = if port == Port::SeriesVoltage { Port::TerminalVoltage } else { Port::SeriesVoltage };
        assert!(of(port).sure() > 2.0 * of(other).sure(), "{port:?}");
        assert_eq!((scored[0].port, scored[0].port.quantity()), (port, "terminal_voltage"));
    }
}

/// Bearings and gears carry a torque: their friction may follow it where the speed is imposed, too. There, all else follows the current.
#[test]
fn friction_may_follow_the_load_at_an_imposed_speed() {
    let lag = Lag { driver: Driver::LoadTorque, tau: 120.0, difference: false };
    let factor = Factor {
        driver: Driver::LoadTorque,
        offset: 0.0,
        reference: 0.1,
        exponent: 1.0,
        range: Factor::UNLIMITED,
    };
    let law = Law::Product(Product { coefficient: 0.005, factors: [Some(factor), None, None] });
    let mut experiment =
        testing::with_term(GenericTerm { lag: Some(lag), ..GenericTerm::new(Port::DragTorque, law) });
    experiment.noise.values_mut().for_each(|noise| *noise = NOISE);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let point = Linearization::new(&setup, setup.judged(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
    let found = search(&point);
    let load = |s: &&Scored| s.follows.drivers().eq([Driver::LoadTorque]);
    assert!(found.iter().filter(load).all(|s| s.port == Port::DragTorque));
    assert!(found.iter().filter(load).any(|s| s.addition.as_ref().is_some_and(|a| a.lag().is_some())));
}
