//! Terms that are data over a step: what they hold of their drivers.

use crate::common::motor;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode, MechanicalMode};
use physics::terms::{Driver, Factor, GenericTerm, Law, Port, Product};

fn output(m: &mut AnnulusCooledMotor, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot;
    m.get(slot)
}

/// What a term holds over a step it holds in the middle: halving the step quarters the error of what is slow, whether it follows a
/// temperature or a current that answers its voltage within milliseconds.
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
        assert!(output(&mut m, "energy_balance_error").abs() < 1e-6);
        output(&mut m, "housing_temperature")
    };
    for (port, driver, size) in [
        (Port::WindingHeat, Driver::Current, 5.0),
        (Port::HousingAmbientConductance, Driver::WindingTemperature, 0.1),
        (Port::HousingHeat, Driver::WindingTemperature, -5.0),
    ] {
        let (offset, reference) = if driver == Driver::Current { (0.0, 10.0) } else { (290.0, 30.0) };
        let factor = Factor { driver, offset, reference, exponent: 2.0 };
        let law = Law::Product(Product { coefficient: size, factors: [Some(factor), None, None] });
        let what = GenericTerm { port, law };
        let truth = end(what, 4096);
        let errors = [8, 16, 32].map(|steps| (end(what, steps) - truth).abs());
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!(order > 1.7, "{port:?} {driver:?}: order {order}, errors {errors:?}");
        }
    }
}
