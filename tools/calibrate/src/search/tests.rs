use super::*;

/// A law over a driver with so much evidence, and its shape: driver and value.
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

/// The ports that are left of a heat and of a conductance over the housing's temperature.
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
    // One that explains far less explains something else.
    assert_eq!(left(&falling, 85.0).len(), 2);
    // A heat that grows is no loss.
    let growing = falling.map(|(x, y)| (x, -y));
    assert_eq!(left(&growing, 95.0).len(), 2);
    // Of a power the coefficient alone says it.
    assert_eq!((left(&[(0.0, -1.0)], 95.0).len(), left(&[(0.0, 1.0)], 95.0).len()), (1, 2));
}

#[test]
fn what_knows_its_past_is_clear_where_no_present_value_comes_near() {
    let latch = law(Port::DragTorque, Follows::History, 1000.0, &[(310.0, 1.0)]);
    let present = |sure: f64| law(Port::DragTorque, over(Driver::Speed), sure, &[(0.0, 1.0)]);
    assert!(remembers(&[latch.clone(), present(850.0)]));
    assert!(!remembers(&[latch.clone(), present(900.0)]));
    // A law over time may be the same in other words; a force that is free in time is none that latches.
    let in_time = law(Port::DragTorque, over(Driver::Time), 990.0, &[(0.0, 1.0)]);
    assert!(remembers(&[latch.clone(), in_time]));
    let free = Scored { name: format!("{}{FREE}", latch.name), ..latch };
    assert!(!remembers(&[free, present(100.0)]));
}
