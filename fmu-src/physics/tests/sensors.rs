//! Temperature sensors: lag, stem loss and offset.

use crate::effects::{close, heating, output};
use physics::model::Model;
use physics::models::annulus_cooled_motor::AnnulusCooledMotor;

/// Each sensor lags, then loses along its stem, then is off by a constant; nothing else feels it.
#[test]
fn the_sensors_show_what_they_show() {
    let (mut plain, mut sensed) = (heating(), heating());
    sensed.parameters.effects.winding_sensor_lag.tau = 7.0;
    sensed.parameters.effects.housing_sensor_lag.tau = 30.0;
    sensed.parameters.effects.housing_sensor_stem_loss.k = 0.1;
    sensed.parameters.effects.housing_sensor_offset.offset = 2.0;
    sensed.parameters.effects.winding_sensor_stem_loss.k = 0.05;
    sensed.parameters.effects.winding_sensor_offset.offset = -3.0;
    sensed.parameters.effects.ambient_drift.rate = 1e-3;
    plain.parameters.effects.ambient_drift.rate = 1e-3;
    sensed.start(100.0).unwrap();
    plain.start(100.0).unwrap();
    close(output(&mut sensed, "housing_temperature"), 298.25 + 2.0, 1e-12);
    // The lags by a thousand times as many steps of the trapezoidal rule, in a motor that takes fifty times as many.
    const SENSORS: [(&str, f64); 2] = [("winding_temperature", 7.0), ("housing_temperature", 30.0)];
    let (mut lagged, mut fine) = ([298.25; 2], plain.clone());
    for _ in 0..60 {
        plain.step(plain.time(), 1.0).unwrap();
        sensed.step(sensed.time(), 1.0).unwrap();
        for _ in 0..50 {
            let before = SENSORS.map(|(name, _)| output(&mut fine, name));
            fine.step(fine.time(), 0.02).unwrap();
            for ((lagged, before), (name, tau)) in lagged.iter_mut().zip(before).zip(SENSORS) {
                let after = output(&mut fine, name);
                for k in 0..20 {
                    let t = before + (after - before) * (f64::from(k) + 0.5) / 20.0;
                    *lagged += (t - *lagged) * 1e-3 / tau / (1.0 + 0.5e-3 / tau);
                }
            }
        }
        let ([t_w, t_h], t_a) = (lagged, 298.15 + 1e-3 * sensed.time());
        // A parabola follows a winding of 2 s over 1 s to 3e-5 K at first.
        close(output(&mut sensed, "winding_temperature"), t_w - 0.05 * (t_w - t_a) - 3.0, 3e-5);
        close(output(&mut sensed, "housing_temperature"), t_h - 0.1 * (t_h - t_a) + 2.0, 1e-6);
    }
    assert_eq!(plain.state(), sensed.state(), "a sensor changes nothing");
    for name in ["winding_margin", "over_temperature", "winding_resistance", "stator_temperature"] {
        assert_eq!(output(&mut plain, name).to_bits(), output(&mut sensed, name).to_bits(), "{name}");
    }
}

/// What the sensors have reached is saved, and a start forgets it.
#[test]
fn the_lag_is_part_of_the_state() {
    let mut m = heating();
    m.parameters.effects.winding_sensor_lag.tau = 9.0;
    m.parameters.effects.housing_sensor_lag.tau = 30.0;
    let shown = |m: &mut AnnulusCooledMotor| {
        ["winding_temperature", "housing_temperature"].map(|name| output(m, name).to_bits())
    };
    m.start(0.0).unwrap();
    let minute = |m: &mut AnnulusCooledMotor| {
        (0..60).for_each(|_| m.step(m.time(), 1.0).unwrap());
        shown(m)
    };
    let first = minute(&mut m);
    let mut saved = Vec::new();
    m.save(&mut saved);
    let second = minute(&mut m);
    assert!(m.restore(&saved));
    assert_eq!(shown(&mut m), first);
    assert_eq!(minute(&mut m), second);
    m.start(0.0).unwrap();
    assert_eq!(minute(&mut m), first);
}
