//! Terms that are data over a step: what they hold of their drivers.

use crate::common::motor;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode, MechanicalMode};
use physics::models::brushed_gearmotor::BrushedGearmotor;
use physics::terms::{Driver, Factor, GenericTerm, Grid, Lag, Law, Port, Product, Table};

fn output(m: &mut AnnulusCooledMotor, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    m.get(slot)
}

/// What a term holds over a step is its mean: with steps of h in 400 s the error is below 1 K (h / 400 s)^2, whether it follows a
/// temperature, also one with a time constant far below h, or a current that answers its voltage within milliseconds. The laws change by a small part of their span, so that no step
/// is divided.
#[test]
fn what_is_held_over_a_step_is_of_second_order() {
    let end = |what: GenericTerm, steps: u32| {
        let mut m = motor(DriveMode::Voltage, MechanicalMode::ImposedSpeed);
        assert!(m.set_terms(&[what]));
        (m.inputs.voltage, m.inputs.imposed_speed) = (1.0, 0.0);
        m.start(-20.0).unwrap();
        // What answers fast has settled before.
        (0..200).for_each(|k| m.step(f64::from(k) * 0.1 - 20.0, 0.1).unwrap());
        let h = 400.0 / f64::from(steps);
        for k in 0..steps {
            m.set_slope(m.declaration().by_name("voltage").unwrap().slot, 0.004);
            m.step(f64::from(k) * h, h).unwrap();
        }
        let (error, energy) = (output(&mut m, "energy_balance_error"), output(&mut m, "energy_electrical"));
        assert!(error.abs() < 1e-6 * energy, "{steps} steps: {error} J of {energy} J");
        output(&mut m, "housing_temperature")
    };
    for (port, driver, size) in [
        (Port::WindingHeat, Driver::Current, 5.0),
        (Port::HousingAmbientConductance, Driver::WindingTemperature, 0.1),
        (Port::HousingHeat, Driver::WindingTemperature, -5.0),
    ] {
        let (offset, reference) = if driver == Driver::Current { (0.0, 10.0) } else { (290.0, 30.0) };
        let what = GenericTerm::new(port, power(driver, offset, FAR * reference, size * FAR * FAR));
        let truth = end(what, 4096);
        for steps in [8, 16, 32, 64, 128] {
            let (error, share) = ((end(what, steps) - truth).abs(), 1.0 / f64::from(steps));
            assert!(error < share * share, "{port:?} {driver:?}: {error} K with {steps} steps");
        }
    }
}

/// A reference that is this many times farther, with a coefficient that makes up for it, is the same law with a greater span.
const FAR: f64 = 100.0;

/// size ((x - offset) / reference)^2.
fn power(driver: Driver, offset: f64, reference: f64, size: f64) -> Law {
    let factor = Factor { driver, offset, reference, exponent: 2.0, range: Factor::UNLIMITED };
    Law::Product(Product { coefficient: size, factors: [Some(factor), None, None] })
}

/// Temperatures after 2 s in which current, speed and fan command rise from 0 to their greatest values, in this number of steps, K.
fn jump(term: GenericTerm, steps: u32) -> [f64; 2] {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    assert!(m.set_terms(&[term]));
    m.start(0.0).unwrap();
    (0..10).for_each(|k| m.step(f64::from(k) * 2.0, 2.0).unwrap());
    let h = 2.0 / f64::from(steps);
    for k in 0..steps {
        for (name, to) in [("current_command", 8.0), ("imposed_speed", 900.0), ("fan_command", 1.0)] {
            m.set_slope(m.declaration().by_name(name).unwrap().slot, to / 2.0);
        }
        m.step(20.0 + f64::from(k) * h, h).unwrap();
    }
    assert!(
        output(&mut m, "energy_balance_error").abs() < 1e-6,
        "{}",
        output(&mut m, "energy_balance_error")
    );
    ["winding_temperature", "housing_temperature"].map(|name| output(&mut m, name))
}

/// A step in which the drivers jump is as exact as many short ones, for each law form with a bend inside, at ports of heat and of
/// factors on what jumps as well: to 1e-3 of what the span of the law changes over that step.
#[test]
fn a_jump_of_the_drivers_divides_the_step() {
    let table = |driver: Driver, ends: f64, values: [f64; 3]| {
        Law::Table(Table::new(driver, &[0.0, 0.37 * ends, ends], &values).unwrap())
    };
    let grid = Law::Grid(
        Grid::new(
            [Driver::Speed, Driver::Current],
            [&[0.0, 400.0, 900.0], &[0.0, 3.0, 8.0]],
            &[vec![0.0, 9.0, 2.0], vec![4.0, 0.0, 7.0], vec![1.0, 8.0, 3.0]],
        )
        .unwrap(),
    );
    for (port, law) in [
        (Port::WindingHeat, table(Driver::Speed, 900.0, [0.0, 40.0, 10.0])),
        (Port::HousingHeat, table(Driver::FanCommand, 1.0, [0.0, -60.0, 60.0])),
        (Port::WindingHeat, grid),
        (Port::WindingResistance, power(Driver::Speed, 0.0, 450.0, 0.4)),
        (Port::HeatCapacity, table(Driver::Current, 8.0, [0.0, 0.8, -0.3])),
        (Port::TorqueConstant, table(Driver::Current, 8.0, [0.0, -0.2, 0.1])),
    ] {
        let constant = |value: f64| jump(GenericTerm::new(port, power(Driver::Time, -1e9, 1e9, value)), 4096);
        let [one, many] = [1, 4096].map(|steps| jump(GenericTerm::new(port, law), steps));
        let [without, whole] = [0.0, law.span()].map(constant);
        for n in 0..2 {
            let (error, span) = ((one[n] - many[n]).abs(), (whole[n] - without[n]).abs());
            assert!(error < 1e-3 * span + 1e-7, "{port:?}: {error} of {span} K");
        }
    }
}

/// A term whose driver is a first-order lag with this time constant, linear in it.
fn lagging(port: Port, driver: Driver, (offset, size): (f64, f64), tau: f64) -> GenericTerm {
    let factor = Factor { driver, offset, reference: FAR, exponent: 1.0, range: Factor::UNLIMITED };
    let law = Law::Product(Product { coefficient: size * FAR, factors: [Some(factor), None, None] });
    GenericTerm { lag: Some(Lag { driver, tau, difference: false }), ..GenericTerm::new(port, law) }
}

/// Current 6 A from the start on, at rest: the lag of the current is 6 (1 - exp(-t / tau)), that of the copper loss follows R I^2.
#[test]
fn a_lag_is_the_solution_of_its_equation() {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    let (tau, size) = (50.0, 0.02);
    assert!(m.set_terms(&[
        lagging(Port::WindingSensor, Driver::Current, (0.0, size), tau),
        lagging(Port::HousingSensor, Driver::CopperLoss, (0.0, size), tau),
    ]));
    m.start(0.0).unwrap();
    m.inputs.current_command = 6.0;
    m.set(m.declaration().by_name("current_command").unwrap().slot, 6.0);
    (0..100).for_each(|k| m.step(f64::from(k), 1.0).unwrap());
    let share = 1.0 - (-100.0 / tau).exp();
    let off = output(&mut m, "winding_temperature") - output(&mut m, "state.winding_temperature");
    assert!((off - size * 6.0 * share).abs() < 1e-12, "{off}");
    let lag = output(&mut m, "state.term_lag[2]") * Driver::CopperLoss.nominal();
    let loss = output(&mut m, "loss_copper");
    // The loss has risen by a tenth while the winding warmed.
    assert!(lag < share * loss && lag > 0.95 * share * loss, "{lag} {loss}");
    let off = output(&mut m, "housing_temperature") - output(&mut m, "state.core_temperature");
    assert!((off - size * lag).abs() < 1e-9);
}

/// Every lag at a port that acts on its own driver: halving the step quarters the error, an importer that integrates finds the same
/// states, and a motor that is put back goes the same way to the last bit.
#[test]
fn lags_are_of_second_order_exchanged_and_saved() {
    converge_are_exchanged_and_saved(
        1.7,
        &[
            lagging(Port::TorqueConstant, Driver::WindingTemperature, (298.15, -2e-3), 40.0),
            lagging(Port::DragTorque, Driver::FrictionLoss, (0.0, -4e-4), 60.0),
            lagging(Port::HousingHeat, Driver::CopperLoss, (0.0, 0.3), 80.0),
        ],
    );
}

/// The same in the gearmotor, whose current and speed are states; they have settled at the start.
#[test]
fn lags_in_a_gearmotor_are_of_second_order_exchanged_and_saved() {
    let geared = |terms: &[GenericTerm]| -> Box<dyn Model> {
        let mut m = BrushedGearmotor::default();
        assert!(m.set_terms(terms));
        (m.inputs.duty, m.inputs.load_torque) = (0.7, 0.1);
        m.start(-2.0).unwrap();
        after(&mut m, 2000, 1e-3);
        Box::new(m)
    };
    let housing = mass(Port::HousingHeat, Driver::HousingTemperature, 0.2, 70.0);
    for terms in [
        [
            lagging(Port::TorqueConstant, Driver::WindingTemperature, (298.15, -2e-3), 40.0),
            lagging(Port::DragTorque, Driver::FrictionLoss, (0.0, -0.02), 60.0),
            lagging(Port::HousingHeat, Driver::CopperLoss, (0.0, 0.3), 80.0),
        ],
        [
            housing,
            lagging(Port::WindingResistance, Driver::HousingTemperature, (298.15, 1e-3), 50.0),
            lagging(Port::HeatCapacity, Driver::Current, (0.0, 0.5), 30.0),
        ],
    ] {
        converge(&geared, 1.7, &terms);
        are_exchanged(&geared, 25_000, 2e-5, &terms);
        are_saved(&geared, &terms);
    }
}

/// A mass behind `conductance`, W/K, at the node that a port heats.
fn mass(port: Port, driver: Driver, conductance: f64, tau: f64) -> GenericTerm {
    let term = lagging(port, driver, (0.0, conductance), tau);
    GenericTerm { lag: term.lag.map(|lag| Lag { difference: true, ..lag }), ..term }
}

/// The housing's own temperature is evaluated within a step, that of the winding is constant over it (`effects/generic_term.rs`).
#[test]
fn masses_converge_are_exchanged_and_saved() {
    let sensor = lagging(Port::WindingSensor, Driver::HousingTemperature, (298.15, 0.1), 40.0);
    let housing = |g: f64, tau: f64| mass(Port::HousingHeat, Driver::HousingTemperature, g, tau);
    converge_are_exchanged_and_saved(1.7, &[housing(0.6, 70.0), housing(0.1, 400.0), sensor]);
    let winding = mass(Port::WindingHeat, Driver::WindingTemperature, 0.2, 25.0);
    converge_are_exchanged_and_saved(1.0, &[winding, housing(0.6, 70.0), sensor]);
}

/// A mass at the housing is a third node: the network of winding, housing and mass, integrated here with steps of 10 ms.
#[test]
fn a_mass_is_a_node() {
    let (conductance, tau) = (0.6, 70.0);
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    assert!(m.set_terms(&[mass(Port::HousingHeat, Driver::HousingTemperature, conductance, tau)]));
    m.inputs.current_command = 5.0;
    m.start(0.0).unwrap();
    let p = m.parameters;
    let (motor, thermal) = (&p.motor, &p.thermal);
    let ambient = m.inputs.ambient_temperature;
    let mut t = [ambient; 3];
    for k in 0..600 {
        m.step(f64::from(k), 1.0).unwrap();
        for _ in 0..100 {
            let loss = 25.0 * motor.resistance(t[0]);
            let (to_housing, to_mass) = ((t[0] - t[1]) / thermal.R_wh, conductance * (t[1] - t[2]));
            let away = p.conductance.G_still * (t[1] - ambient);
            let rates = [
                (loss - to_housing) / thermal.C_w,
                (to_housing - to_mass - away) / thermal.C_h,
                to_mass / (conductance * tau),
            ];
            t.iter_mut().zip(rates).for_each(|(t, rate)| *t += 0.01 * rate);
        }
    }
    let found = ["state.winding_temperature", "state.core_temperature"].map(|name| output(&mut m, name));
    let lag = output(&mut m, "state.term_lag[1]") * Driver::HousingTemperature.nominal();
    for (found, truth) in found.into_iter().chain([lag]).zip(t) {
        assert!((found - truth).abs() < 0.02 && truth > ambient + 10.0, "{found} {truth}");
    }
}

/// A motor with current and speed from outside.
fn heated(terms: &[GenericTerm]) -> Box<dyn Model> {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    assert!(m.set_terms(terms));
    m.parameters.effects.coulomb_friction.tau_c = 0.01;
    (m.inputs.current_command, m.inputs.imposed_speed) = (5.0, 400.0);
    m.start(0.0).unwrap();
    Box::new(m)
}

/// A motor with terms at the start of a run.
type Begun<'a> = &'a dyn Fn(&[GenericTerm]) -> Box<dyn Model>;

/// The states after further steps of `h` seconds.
fn after(m: &mut dyn Model, steps: u32, h: f64) -> Vec<f64> {
    let from = m.time();
    (0..steps).for_each(|k| m.step(from + f64::from(k) * h, h).unwrap());
    let mut states = Vec::new();
    m.states(&mut states);
    states
}

/// Greatest relative difference of two lists of states.
fn apart(found: &[f64], truth: &[f64]) -> f64 {
    assert_eq!(found.len(), truth.len());
    found.iter().zip(truth).map(|(a, b)| ((a - b) / b).abs()).fold(0.0, f64::max)
}

/// Relative error of the integrator, below which nothing converges.
const FLOOR: f64 = 1e-6;

/// `order`: least order of convergence over 200 s, down to the error of the integrator.
fn converge(begun: Begun, order: f64, terms: &[GenericTerm]) {
    let end = |steps: u32| after(begun(terms).as_mut(), steps, 200.0 / f64::from(steps));
    let truth = end(4096);
    assert!(truth.len() >= 5, "at least two nodes and three lags");
    let errors = [32, 64, 128].map(|steps| apart(&end(steps), &truth));
    let converges = |e: &[f64]| e[1] < FLOOR || (e[0] / e[1]).log2() > order;
    assert!(errors.windows(2).all(converges), "{errors:?}");
}

/// An importer that integrates with this many steps of `h` seconds finds the states that the motor itself finds.
fn are_exchanged(begun: Begun, steps: u32, h: f64, terms: &[GenericTerm]) {
    let truth = after(begun(terms).as_mut(), 4000, f64::from(steps) * h / 4000.0);
    let mut m = begun(terms);
    let start = m.time();
    m.enter_model_exchange();
    let count = m.declaration().states.len();
    let (mut x, mut rates, mut middle) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    m.read_states(&mut x);
    for k in 0..steps {
        let time = start + f64::from(k) * h;
        let mut at = |time: f64, x: &[f64], rates: &mut Vec<f64>| {
            m.write_time(time);
            m.write_states(x);
            m.derivatives(rates).unwrap();
        };
        at(time, &x, &mut rates);
        middle.iter_mut().zip(x.iter().zip(&rates)).for_each(|(m, (x, r))| *m = x + 0.5 * h * r);
        at(time + 0.5 * h, &middle, &mut rates);
        x.iter_mut().zip(&rates).for_each(|(x, r)| *x += h * r);
        m.write_time(time + h);
        m.write_states(&x);
        m.accept_step();
    }
    let error = m.get(m.declaration().by_name("energy_balance_error").unwrap().slot);
    assert!(error.abs() < 1e-3, "{error} J");
    let mut found = Vec::new();
    m.states(&mut found);
    let off = apart(&found, &truth);
    assert!(off < 2e-5, "{off}: {found:?} and {truth:?}");
}

/// A motor that is put back goes the same way to the last bit.
fn are_saved(begun: Begun, terms: &[GenericTerm]) {
    let mut m = begun(terms);
    after(m.as_mut(), 50, 1.0);
    let mut saved = Vec::new();
    m.save(&mut saved);
    let once = after(m.as_mut(), 50, 1.0);
    assert!(m.restore(&saved));
    assert_eq!(after(m.as_mut(), 50, 1.0), once);
}

fn converge_are_exchanged_and_saved(order: f64, terms: &[GenericTerm]) {
    converge(&heated, order, terms);
    are_exchanged(&heated, 2000, 0.1, terms);
    are_saved(&heated, terms);
}

/// A table over a driver, bent in the middle.
fn bent(driver: Driver, ends: [f64; 2], values: [f64; 3]) -> Law {
    let middle = 0.4 * ends[0] + 0.6 * ends[1];
    Law::Table(Table::new(driver, &[ends[0], middle, ends[1]], &values).unwrap())
}

/// Current and speed settle within milliseconds. At the end of longer steps they belong to the present values of a term, so that the
/// derivatives that the motor gives are those of its states: for each law form at each port of current and speed, with and
/// without lag, in each mode in which one of them is a state.
#[test]
fn derivatives_are_those_of_states_that_settle_within_a_step() {
    let after = |tau: f64, driver: Driver, port: Port, law: Law| GenericTerm {
        lag: Some(Lag { driver, tau, difference: false }),
        ..GenericTerm::new(port, law)
    };
    let grid = |drivers: [Driver; 2], rows: [f64; 2], columns: [f64; 2]| {
        Law::Grid(Grid::new(drivers, [&rows, &columns], &[vec![-0.1, 0.4], vec![0.3, -0.2]]).unwrap())
    };
    let (t_w, t_h) = (Driver::WindingTemperature, Driver::HousingTemperature);
    let terms = [
        after(
            2.0,
            Driver::Current,
            Port::WindingResistance,
            bent(Driver::Current, [0.0, 30.0], [0.4, 0.0, 0.3]),
        ),
        GenericTerm::new(Port::WindingResistance, grid([Driver::Current, t_w], [0.0, 60.0], [290.0, 400.0])),
        GenericTerm::new(Port::WindingResistance, power(t_w, 270.0, 60.0, 0.3)),
        GenericTerm::new(Port::WindingResistance, power(Driver::Current, 0.0, 30.0, 0.8)),
        after(0.5, Driver::Speed, Port::TerminalVoltage, bent(Driver::Speed, [0.0, 900.0], [0.0, 1.0, 0.2])),
        GenericTerm::new(Port::TerminalVoltage, power(t_w, 250.0, 100.0, 2.0)),
        GenericTerm::new(Port::SeriesVoltage, bent(Driver::Current, [0.0, 30.0], [0.5, -0.5, 1.0])),
        after(0.8, t_w, Port::SeriesVoltage, power(t_w, 250.0, 100.0, 2.0)),
        GenericTerm::new(Port::TorqueConstant, grid([Driver::Time, t_w], [0.0, 3.0], [290.0, 400.0])),
        after(1.0, Driver::CopperLoss, Port::TorqueConstant, power(Driver::CopperLoss, 0.0, 500.0, -0.1)),
        GenericTerm::new(Port::TorqueConstant, power(Driver::Current, 0.0, 60.0, -0.2)),
        GenericTerm::new(Port::DragTorque, power(t_w, 250.0, 100.0, 0.02)),
        after(0.7, t_w, Port::DragTorque, power(t_w, 250.0, 100.0, 0.02)),
        GenericTerm::new(Port::DragTorque, power(Driver::Current, 0.0, 10.0, 0.01)),
        GenericTerm::new(Port::DragTorque, bent(Driver::Time, [0.0, 3.0], [0.0, 0.02, 0.01])),
        after(0.3, t_h, Port::WindingHeat, power(t_h, 200.0, 100.0, 20.0)),
        GenericTerm::new(Port::WindingHeat, power(Driver::Current, 0.0, 10.0, 5.0)),
    ];
    let h = 0.01;
    let turning = |modes: Option<(DriveMode, MechanicalMode)>, term: &GenericTerm| -> Box<dyn Model> {
        let Some((drive, coupling)) = modes else {
            let mut m = BrushedGearmotor::default();
            assert!(m.set_terms(&[*term]));
            m.start(0.0).unwrap();
            return Box::new(m);
        };
        let mut m = motor(drive, coupling);
        assert!(m.set_terms(&[*term]));
        m.parameters.effects.viscous_friction.k = 1e-3;
        m.start(0.0).unwrap();
        m.inputs.imposed_speed = 200.0;
        Box::new(m)
    };
    for modes in [
        Some((DriveMode::Voltage, MechanicalMode::ImposedSpeed)),
        Some((DriveMode::Voltage, MechanicalMode::FreeShaft)),
        Some((DriveMode::Pwm, MechanicalMode::ImposedSpeed)),
        Some((DriveMode::Current, MechanicalMode::FreeShaft)),
        None,
    ] {
        for term in &terms {
            let mut m = turning(modes, term);
            for (name, value) in [("voltage", 12.0), ("duty", 0.8), ("current_command", 10.0)] {
                let input = m.declaration().by_name(name).filter(|e| e.is_continuous_input());
                assert!(input.is_none_or(|entry| m.set(entry.slot, value)));
            }
            let mut next = |k: u32| {
                let (mut states, mut rates) = (Vec::new(), Vec::new());
                m.step(f64::from(k) * h, h).unwrap();
                m.states(&mut states);
                m.rates(&mut rates);
                (states, rates)
            };
            // The first half second has the start of the rotor.
            let rows: Vec<_> = (0..150).map(&mut next).skip(50).collect();
            for s in 0..rows[0].0.len() {
                let wrong = rows.windows(3).filter(|row| {
                    let (given, measured) = (row[1].1[s], (row[2].0[s] - row[0].0[s]) / (2.0 * h));
                    let size = given.abs().max(measured.abs()).max(1e-6 * row[1].0[s].abs());
                    // A lag is a line over the step: its derivative may be half a step late.
                    let late = 0.5 * (row[2].1[s] - row[0].1[s]).abs();
                    (given - measured).abs() > 0.01 * size + late
                });
                // A bend of a table is between two of the rows.
                let wrong: Vec<_> = wrong.collect();
                assert!(
                    wrong.len() <= 2,
                    "{modes:?} {term:?}: state {s}, {} rows: {:?}",
                    wrong.len(),
                    &wrong[0]
                );
            }
        }
    }
}
