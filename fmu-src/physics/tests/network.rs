//! The network of rotor, housing segments and tube in every mode of cooling.

mod common;
use common::motor;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{
    AnnulusCooledMotor, CoolingMode, DriveMode, MechanicalMode, Outputs,
};

const MODES: [CoolingMode; 4] =
    [CoolingMode::Bare, CoolingMode::FanCrossflow, CoolingMode::AnnulusPush, CoolingMode::AnnulusPull];

/// 10 W in the winding of a motor at rest, the fan at full speed: the thesis's experiment.
fn stalled(mode: CoolingMode) -> AnnulusCooledMotor {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.parameters.choices.cooling_mode = mode;
    m.inputs.electrical_power = 10.0;
    m.inputs.fan_command = 1.0;
    m.inputs.ambient_temperature = 297.9;
    m
}

fn outputs(m: &mut AnnulusCooledMotor) -> Outputs {
    use declare::Group;
    let mut outputs = Outputs::default();
    for row in 0..Outputs::TABLE.len() {
        let value = m.get(physics::model::Slot { group: 1, row: row as u16 });
        outputs.set(row, value);
    }
    outputs
}

fn settle(m: &mut AnnulusCooledMotor) -> Outputs {
    m.start(0.0).unwrap();
    for k in 0..200 {
        m.step(100.0 * f64::from(k), 100.0).unwrap();
    }
    outputs(m)
}

#[test]
fn look() {
    for d in [0.005, 0.015, 0.03] {
        for n in [1.0, 8.0, 64.0] {
            let mut m = stalled(CoolingMode::FanCrossflow);
            m.parameters.fan.distance = d;
            m.parameters.choices.air_segments = n;
            println!("{d} {n} {}", settle(&mut m).winding_temperature);
        }
    }
    for mode in MODES {
        let mut m = stalled(mode);
        let begin = std::time::Instant::now();
        let o = settle(&mut m);
        println!(
            "{mode:?} {:?} T_w {} out {} flow {} dp {} books {} {} amb {}",
            begin.elapsed(),
            o.winding_temperature,
            o.air_outlet_temperature,
            o.air_flow_rate,
            o.air_pressure_drop,
            o.power_balance_error,
            o.energy_balance_error,
            o.heat_to_ambient
        );
        println!(
            "  R_ha {} stator {} housing {} rotor {}",
            (o.winding_temperature - 297.9) / 10.0 - 0.21,
            o.stator_temperature,
            o.housing_temperature,
            o.magnet_temperature
        );
        let mut m = stalled(mode);
        m.start(0.0).unwrap();
        let begin = std::time::Instant::now();
        for k in 0..1000 {
            m.step(1e-3 * f64::from(k), 1e-3).unwrap();
        }
        println!("  {} ns per step", begin.elapsed().as_nanos() as f64 / 1e5);
    }
}
