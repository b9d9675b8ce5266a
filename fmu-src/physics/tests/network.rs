//! The network of rotor, housing segments and tube in every mode of cooling: books, accuracy, grid, rollback.

use crate::common::{busy_inputs, cooling_inputs, motor, network_modes as modes};
use declare::Group;
use physics::components::commutation::Commutation;
use physics::effects::Effects;
use physics::model::{Model, Slot};
use physics::models::annulus_cooled_motor::cooling::{Conditions, Cooling};
use physics::models::annulus_cooled_motor::network::{Body, Network};
use physics::models::annulus_cooled_motor::{
    AnnulusCooledMotor, CoolingMode, DriveMode, EnergyBalance, Inputs, MechanicalMode, Outputs,
};

/// 10 W in the winding of a motor at rest, the fan at full speed: the thesis's experiment.
fn stalled(mode: CoolingMode) -> AnnulusCooledMotor {
    let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
    m.parameters.choices.cooling_mode = mode;
    m.inputs = busy_inputs();
    m.inputs.electrical_power = 10.0;
    m.inputs.ambient_temperature = 297.9;
    m.inputs.coolant_inlet_temperature = 290.0;
    m
}

/// What the model shows: of its state, and of its flows of power.
struct Shown {
    state: Outputs,
    balance: EnergyBalance,
}

impl std::ops::Deref for Shown {
    type Target = Outputs;
    fn deref(&self) -> &Outputs {
        &self.state
    }
}

fn outputs(m: &mut AnnulusCooledMotor) -> Shown {
    let mut shown = Shown { state: Outputs::default(), balance: EnergyBalance::default() };
    for row in 0..Outputs::TABLE.len() {
        shown.state.set(row, m.get(Slot { group: 1, row: row as u16 }));
    }
    for row in 0..EnergyBalance::TABLE.len() {
        shown.balance.set(row, m.get(Slot { group: 2, row: row as u16 }));
    }
    shown
}

fn run(m: &mut AnnulusCooledMotor, stop: f64, h: f64) -> Shown {
    m.start(0.0).unwrap();
    for k in 0..(stop / h).round() as i32 {
        m.step(h * f64::from(k), h).unwrap();
    }
    outputs(m)
}

/// Sets an input by its row, and its slope, as an importer would.
fn drive(m: &mut AnnulusCooledMotor, name: &str, value: f64, slope: f64) {
    let entry = m.declaration().by_name(name).unwrap();
    m.set(entry.slot, value);
    m.set_slope(entry.slot, slope);
}

/// A drive cycle with every effect on: the balance holds at each instant, the energies over the whole.
#[test]
fn the_books_close_in_every_mode() {
    for mode in modes() {
        for drive_mode in [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power] {
            for mechanical in [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed] {
                let mut m = motor(drive_mode, mechanical);
                m.parameters.choices.cooling_mode = mode;
                m.parameters.choices.commutation = Commutation::Block;
                m.parameters.effects = Effects::examples();
                m.parameters.thermal.G_mount = 0.02;
                m.parameters.cooling.annulus.leak_area = 2e-4;
                m.inputs.voltage = 24.0;
                m.inputs.electrical_power = 20.0;
                m.start(0.0).unwrap();
                let (mut worst, mut through) = (0.0f64, 0.0f64);
                let h = 5e-3;
                for k in 0..200 {
                    let t = h * f64::from(k);
                    for (_, name, nominal) in cooling_inputs() {
                        drive(&mut m, name, nominal * (0.5 + 0.5 * t), 0.5 * nominal);
                    }
                    drive(&mut m, "fan_command", 0.5 + 0.4 * (3.0 * t).sin(), 1.2 * (3.0 * t).cos());
                    drive(&mut m, "ambient_temperature", 300.0 + 2.0 * t, 2.0);
                    drive(&mut m, "coolant_inlet_temperature", 290.0 + t, 1.0);
                    drive(&mut m, "ambient_pressure", 1e5 - 1e3 * t, -1e3);
                    drive(&mut m, "duty", (2.0 * t).sin(), 2.0 * (2.0 * t).cos());
                    drive(&mut m, "current_command", 6.0 * (5.0 * t).cos(), -30.0 * (5.0 * t).sin());
                    drive(&mut m, "imposed_speed", 300.0 * (4.0 * t).sin(), 1200.0 * (4.0 * t).cos());
                    drive(&mut m, "load_torque", 0.02 * (6.0 * t).sin(), 0.12 * (6.0 * t).cos());
                    m.step(t, h).unwrap();
                    let o = outputs(&mut m);
                    worst = worst.max(o.balance.power_balance_error.abs());
                    through = through.max(o.balance.energy_electrical.abs());
                    let off = o.balance.energy_balance_error.abs();
                    assert!(
                        off <= 1e-6 * through.max(1.0),
                        "{mode:?} {drive_mode:?} {mechanical:?}: {off} J"
                    );
                }
                assert!(worst <= 1e-6, "{mode:?} {drive_mode:?} {mechanical:?}: {worst} W");
            }
        }
    }
}

/// Temperatures of winding, stator and network, for the reference below.
struct Reference {
    cooling: Cooling,
    body: Body,
}

impl Reference {
    /// Eqs. (1) to (3) of network.rs and (1), (2) of thermal.rs written out once more, with the coefficients of the
    /// air evaluated at every call. `y`: winding, stator, rotor, tube, segments.
    fn rates(&self, m: &AnnulusCooledMotor, y: &[f64]) -> Vec<f64> {
        let (p, inputs, body) = (&m.parameters, &m.inputs, &self.body);
        let n = body.segments;
        let segments = &y[4..4 + n];
        let ambient = inputs.ambient_temperature;
        let mean = segments.iter().sum::<f64>() / n as f64;
        let at = Conditions::of(inputs, mean, y[3], ambient);
        let c = self.cooling.coefficients(p, &at);
        let mut gain = vec![0.0; 4 + n];
        let mut flow = |from: usize, to: Option<usize>, watts: f64| {
            gain[from] -= watts;
            if let Some(to) = to {
                gain[to] += watts;
            }
        };
        flow(0, Some(1), (y[0] - y[1]) / p.thermal.R_wh);
        flow(0, Some(2), body.winding_to_rotor * (y[0] - y[2]));
        flow(0, None, body.leads * (y[0] - ambient));
        flow(3, None, c.tube_to_ambient * (y[3] - ambient));
        let mut air = c.coolant_inlet.unwrap_or(ambient + c.inlet_rise);
        for k in 0..n {
            let t = segments[k];
            flow(1, Some(4 + k), body.from_stator * (y[1] - t));
            flow(2, Some(4 + k), body.from_rotor * (y[2] - t));
            flow(4 + k, None, c.ambient_conductance[k] * (t - ambient));
            flow(4 + k, Some(3), c.to_tube * (t - y[3]));
            if k + 1 < n {
                flow(4 + k, Some(5 + k), body.axial * (t - segments[k + 1]));
            }
            if c.m_flow_cp > 0.0 {
                // Mean air along the segment: NTU relation of two walls.
                let (own, other) =
                    (c.share[k] * c.film_conductance[k], (1.0 - c.share[k]) * c.film_conductance[k]);
                let wall = (own * t + other * y[3]) / (own + other);
                let ntu = (own + other) / c.m_flow_cp;
                let out = wall + (air - wall) * (-ntu).exp();
                let mean = wall + (air - wall) * (1.0 - (-ntu).exp()) / ntu;
                flow(4 + k, None, own * (t - mean));
                flow(3, None, other * (y[3] - mean));
                air = out;
            }
        }
        gain[0] += inputs.electrical_power;
        let capacity = |k: usize| match k {
            0 => p.thermal.C_w,
            1 => body.stator,
            _ => body.capacity[(k - 2).min(2)],
        };
        gain.iter().enumerate().map(|(k, g)| if capacity(k) > 0.0 { g / capacity(k) } else { 0.0 }).collect()
    }

    /// Classical Runge-Kutta of fourth order.
    fn run(&self, m: &AnnulusCooledMotor, y: &mut [f64], stop: f64, steps: usize) {
        self.run_ramped(m, |_| m.inputs.fan_command, y, stop, steps);
    }

    /// The same with the fan's command over time.
    fn run_ramped(
        &self,
        m: &AnnulusCooledMotor,
        command: impl Fn(f64) -> f64,
        y: &mut [f64],
        stop: f64,
        steps: usize,
    ) {
        let mut m = m.clone();
        let h = stop / steps as f64;
        let along =
            |y: &[f64], f: &[f64], s: f64| -> Vec<f64> { y.iter().zip(f).map(|(y, f)| y + s * f).collect() };
        for step in 0..steps {
            let mut rates = |y: &[f64], part: f64| {
                m.inputs.fan_command = command(h * (step as f64 + part));
                self.rates(&m, y)
            };
            let a = rates(y, 0.0);
            let b = rates(&along(y, &a, 0.5 * h), 0.5);
            let c = rates(&along(y, &b, 0.5 * h), 0.5);
            let d = rates(&along(y, &c, h), 1.0);
            for k in 0..y.len() {
                y[k] += h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]);
            }
        }
    }
}

/// A warm-up of ten minutes against the reference, which knows nothing of pieces, tangents and lines. The
/// thermal target is 1e-6 of the rise.
#[test]
fn a_warm_up_agrees_with_the_equations_written_out() {
    for mode in modes() {
        let mut m = stalled(mode);
        m.parameters.thermal.G_mount = 0.01;
        let body = Body::of(&m.parameters).unwrap();
        let reference = Reference { cooling: Cooling::new(&m.parameters, body.segments), body };
        let mut y = vec![297.9; 4 + body.segments];
        reference.run(&m, &mut y, 600.0, 3000);
        for h in [0.1, 20.0] {
            let o = run(&mut m, 600.0, h);
            let got = [o.winding_temperature, o.stator_temperature, o.magnet_temperature];
            let rise = (y[0] - 297.9).abs();
            for (got, want) in got.iter().zip(&y) {
                assert!((got - want).abs() <= 2e-6 * rise, "{mode:?} {h} s: {got} and {want}");
            }
        }
    }
}

/// A fan that runs up, slows down and rests: the coefficients follow the command.
#[test]
fn a_fan_that_ramps_agrees_with_the_equations_written_out() {
    let command = |t: f64| if t < 60.0 { 0.1 + 0.8 * t / 60.0 } else { 0.9 - 0.9 * (t - 60.0) / 60.0 };
    for mode in modes() {
        let mut m = stalled(mode);
        m.inputs.fan_command = command(0.0);
        m.inputs.electrical_power = 40.0;
        let body = Body::of(&m.parameters).unwrap();
        let reference = Reference { cooling: Cooling::new(&m.parameters, body.segments), body };
        let mut y = vec![297.9; 4 + body.segments];
        reference.run_ramped(&m, command, &mut y, 60.0, 600);
        reference.run_ramped(&m, |t| command(60.0 + t), &mut y, 59.0, 590);
        m.start(0.0).unwrap();
        for k in 0..1190 {
            let t = 0.1 * f64::from(k);
            drive(&mut m, "fan_command", command(t), (command(t + 0.05) - command(t)) / 0.05);
            m.step(t, 0.1).unwrap();
        }
        let o = outputs(&mut m);
        let rise = y[0] - 297.9;
        for (got, want) in [(o.winding_temperature, y[0]), (o.magnet_temperature, y[2])] {
            assert!((got - want).abs() <= 1e-5 * rise, "{mode:?}: {got} and {want}");
        }
    }
}

/// A stator of its own in the two-node mode: three nodes, solved exactly by the reference.
#[test]
fn a_stator_node_agrees_with_the_equations_written_out() {
    let mut m = stalled(CoolingMode::Conductance);
    m.parameters.effects.stator_node.R_sh = 0.4;
    m.parameters.effects.stator_node.C_s = 60.0;
    let body = Body::of(&m.parameters).unwrap();
    let reference = Reference { cooling: Cooling::new(&m.parameters, 1), body };
    let mut y = vec![297.9; 5];
    reference.run(&m, &mut y, 600.0, 6000);
    let o = run(&mut m, 600.0, 0.1);
    for (got, want) in
        [(o.winding_temperature, y[0]), (o.stator_temperature, y[1]), (o.housing_temperature, y[4])]
    {
        assert!((got - want).abs() <= 2e-6 * (y[0] - 297.9), "{got} and {want}");
    }
    assert_eq!(o.magnet_temperature, o.housing_temperature);
}

/// 8 segments against 64, and 1: what the grid costs.
#[test]
fn eight_segments_are_enough() {
    for mode in modes() {
        let settled = |segments: i32| {
            let mut m = stalled(mode);
            m.parameters.choices.air_segments = segments;
            let o = run(&mut m, 15_000.0, 500.0);
            (o.winding_temperature, o.balance.air_outlet_temperature)
        };
        let (fine, eight, one) = (settled(64), settled(8), settled(1));
        assert!((eight.0 - fine.0).abs() <= 0.2, "{mode:?}: {eight:?} {fine:?}");
        assert!((one.0 - fine.0).abs() <= 0.5, "{mode:?}: {one:?} {fine:?}");
        assert!((eight.1 - fine.1).abs() <= 0.05, "{mode:?}: {eight:?} {fine:?}");
    }
}

/// What is saved goes on bit for bit, also in the middle of a tangent and with pieces cut.
#[test]
fn rollback_is_bitwise() {
    for mode in modes() {
        let mut m = stalled(mode);
        m.parameters.choices.commutation = Commutation::Sinusoidal;
        m.parameters.choices.mechanical_mode = MechanicalMode::ImposedSpeed;
        m.start(0.0).unwrap();
        let go = |m: &mut AnnulusCooledMotor| -> Vec<u64> {
            for k in 0..40 {
                let t = m.time();
                drive(m, "fan_command", 0.5 + 0.01 * f64::from(k), 0.002);
                m.step(t, if k % 7 == 0 { 5.0 } else { 0.01 }).unwrap();
            }
            let mut numbers = Vec::new();
            m.save(&mut numbers);
            numbers.iter().map(|x| x.to_bits()).collect()
        };
        go(&mut m);
        let mut saved = Vec::new();
        m.save(&mut saved);
        let mut other = AnnulusCooledMotor::default();
        assert!(other.restore(&saved));
        let mut copy = AnnulusCooledMotor::default();
        assert!(copy.copy_from(&m));
        let first = go(&mut m);
        assert_eq!(first, go(&mut other), "{mode:?}: restored");
        assert_eq!(first, go(&mut copy), "{mode:?}: copied");
        // A stiff network, where nothing renews the coefficients before the next step and that step is long.
        let mut m = stalled(mode);
        m.parameters.choices.air_segments = 64;
        m.parameters.housing.conductivity = 200.0;
        m.start(0.0).unwrap();
        for h in [0.05, 0.3, 2.0, 60.0] {
            (0..10).for_each(|_| m.step(m.time(), 0.01).unwrap());
            let mut saved = Vec::new();
            m.save(&mut saved);
            let mut restored = AnnulusCooledMotor::default();
            assert!(restored.restore(&saved));
            let long = |m: &mut AnnulusCooledMotor| {
                m.step(m.time(), h).unwrap();
                let mut numbers = Vec::new();
                m.save(&mut numbers);
                numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            assert_eq!(long(&mut m), long(&mut restored), "{mode:?}: restored before {h} s");
        }
    }
}

/// More fan, thicker air, a shorter distance: each cools. A hotter room does not change the rise by much.
#[test]
fn directions_are_those_of_nature() {
    for mode in [CoolingMode::FanCrossflow, CoolingMode::AnnulusPush, CoolingMode::AnnulusPull] {
        let settled = |change: &dyn Fn(&mut AnnulusCooledMotor)| {
            let mut m = stalled(mode);
            change(&mut m);
            run(&mut m, 15_000.0, 500.0).winding_temperature
        };
        let base = settled(&|_| ());
        assert!(settled(&|m| m.inputs.fan_command = 0.5) > base + 2.0, "{mode:?}");
        assert!(settled(&|m| m.inputs.fan_command = 0.0) > base + 20.0, "{mode:?}");
        assert!(settled(&|m| m.inputs.ambient_pressure = 7e4) > base + 2.0, "{mode:?}");
        assert!((settled(&|m| m.inputs.ambient_temperature = 317.9) - base - 20.0).abs() < 2.0, "{mode:?}");
    }
    let jet = |distance: f64| {
        let mut m = stalled(CoolingMode::FanCrossflow);
        m.parameters.cooling.fan.distance = distance;
        run(&mut m, 15_000.0, 500.0).winding_temperature
    };
    assert!(jet(0.005) < jet(0.015) && jet(0.015) < jet(0.030));
    // A fan that pushes gives its power to the air of the gap, one that pulls does not.
    let inlet = |mode| {
        let mut m = stalled(mode);
        m.inputs.electrical_power = 0.0;
        run(&mut m, 100.0, 1.0)
    };
    let pushed = inlet(CoolingMode::AnnulusPush);
    assert!(pushed.balance.air_outlet_temperature > 298.1 && pushed.winding_temperature > 297.91);
    assert_eq!(inlet(CoolingMode::AnnulusPull).balance.air_outlet_temperature, 297.9);
}

/// The thesis's curve jumps twice where its flow turns turbulent and laminar again. Here neither flow, nor pressure,
/// nor the heat that the air takes jumps, whatever the tube's width: of 60000 neighbours, three in a row lie on a
/// line within 1e-3. (A jump stands out of the line by all of its height.)
#[test]
fn nothing_jumps_over_the_width_of_the_annulus() {
    for mode in [CoolingMode::AnnulusPush, CoolingMode::AnnulusPull] {
        let mut m = stalled(mode);
        let at = Conditions::of(&Inputs { fan_command: 1.0, ..Inputs::default() }, 340.0, 305.0, 298.0);
        let mut regimes = [false; 3];
        let mut curve = |k: u32| -> [f64; 3] {
            let d = 0.031 * (f64::from(k) * 3.3e-5).exp();
            m.parameters.cooling.annulus.outer_diameter = d;
            let c = Cooling::new(&m.parameters, 8).coefficients(&m.parameters, &at);
            let re = 1.2 * c.flow * 4.0 / (std::f64::consts::PI * 1.85e-5 * (d + 0.030));
            regimes[usize::from(re > 2300.0) + usize::from(re > 4000.0)] = true;
            [(0..8).map(|k| c.film_conductance[k] * c.share[k]).sum(), c.flow, c.pressure_drop + 0.1]
        };
        let points: Vec<[f64; 3]> = (0..60_000).map(&mut curve).collect();
        for three in points.windows(3) {
            for n in 0..3 {
                let off = three[0][n] - 2.0 * three[1][n] + three[2][n];
                assert!((off / three[1][n]).abs() <= 1e-3, "{mode:?}: {three:?}");
            }
        }
        assert_eq!(regimes, [true; 3], "laminar, transitional and turbulent flow are all on the way");
    }
}

/// A hot spot at stall, none while the rotor turns; the pair's own resistance counts.
#[test]
fn stall_has_a_hot_spot() {
    let hot = |commutation, speed: f64| {
        let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
        m.parameters.choices.commutation = commutation;
        m.inputs.current_command = 5.0;
        m.inputs.imposed_speed = speed;
        let o = run(&mut m, 60.0, 0.01);
        o.winding_hot_spot_temperature - o.winding_temperature
    };
    assert_eq!(hot(Commutation::EquivalentDc, 0.0), 0.0);
    // 0.21 K/W x 3 (1/2 - 1/3) x about 10 W, and the like with a share of 2/3.
    let (block, sinusoidal) = (hot(Commutation::Block, 0.0), hot(Commutation::Sinusoidal, 0.0));
    assert!((1.0..1.2).contains(&block), "{block}");
    assert!((2.0..2.4).contains(&sinusoidal), "{sinusoidal}");
    assert!(hot(Commutation::Block, 500.0) < 0.02);
    assert!(hot(Commutation::Sinusoidal, 500.0) < 0.02);
}

/// A drive that loses volts and leaves a ripple: each watt with both ends, the right sizes.
#[test]
fn a_chopped_supply_loses_what_its_effects_say() {
    let mut m = motor(DriveMode::Pwm, MechanicalMode::ImposedSpeed);
    m.inputs.voltage = 24.0;
    m.inputs.duty = 0.25;
    m.parameters.effects.bridge_drop.V_0 = 1.5;
    m.parameters.effects.bridge_drop.R_on = 0.1;
    m.parameters.effects.dead_time.share = 0.02;
    m.parameters.effects.pwm_ripple.f = 5e4;
    let o = run(&mut m, 1.0, 1e-3);
    let i = o.current;
    assert!((o.terminal_voltage - (6.0 - 1.5 - 0.1 * i - 0.48)).abs() < 1e-9);
    assert!((o.current * o.winding_resistance - o.terminal_voltage).abs() < 1e-3);
    assert!((o.balance.loss_drive - (1.5 + 0.1 * i) * i).abs() < 1e-9);
    let ripple: f64 = 24.0 * 0.25 * 0.75 / (65.3e-6 * 5e4);
    let copper = o.winding_resistance * (i * i + ripple * ripple / 12.0);
    assert!((o.balance.loss_copper - copper).abs() < 1e-9);
    assert!(
        o.balance.power_balance_error.abs() < 1e-6
            && o.balance.energy_balance_error.abs() < 1e-6 * o.balance.energy_electrical
    );
}

/// Parameters that cannot be together are named when the model starts, or at the next step.
#[test]
fn what_cannot_be_is_named() {
    type Spoil = fn(&mut AnnulusCooledMotor);
    let cases: [(&str, Spoil); 4] = [
        ("annulus.outer_diameter = 0.03 m", |m| m.parameters.cooling.annulus.outer_diameter = 0.030),
        ("must fall", |m| m.parameters.cooling.fan.p_60 = 0.7),
        ("fan.hub = 0.04 m", |m| m.parameters.cooling.fan.hub = 0.04),
        ("thermal.C_r = 200 J/K", |m| m.parameters.thermal.C_r = 200.0),
    ];
    for (part, spoil) in cases {
        let mut m = stalled(CoolingMode::AnnulusPush);
        spoil(&mut m);
        let fault = m.start(0.0).unwrap_err().to_string();
        assert!(fault.contains(part), "{fault}");
    }
    let mut m = stalled(CoolingMode::AnnulusPush);
    m.start(0.0).unwrap();
    let slot = m.declaration().by_name("annulus.outer_diameter").unwrap().slot;
    m.set(slot, 0.020);
    assert!(m.step(0.0, 0.1).unwrap_err().to_string().contains("does not pass the motor"));
    m.set(slot, 0.040);
    m.step(0.0, 0.1).unwrap();
}

/// The model stays finite over its whole range: the coldest and the hottest room, any command, thin air.
#[test]
fn finite_at_the_limits_of_the_inputs() {
    for mode in modes() {
        for ambient in [173.15, 473.15] {
            for (pressure, command) in [(1e4, 0.0), (2e5, 1.0), (1e4, 1e-9), (1e5, 0.003)] {
                let mut m = stalled(mode);
                m.inputs = Inputs { ambient_temperature: ambient, ambient_pressure: pressure, ..m.inputs };
                m.inputs.fan_command = command;
                m.inputs.electrical_power = 200.0;
                m.start(0.0).unwrap();
                // 200 W may take the winding to its limit of validity; nothing else may end the run.
                let ended = (0..5).any(|k| m.step(10.0 * f64::from(k), 10.0).is_err());
                assert_eq!(ended, m.ended(), "{mode:?} {ambient} {pressure} {command}");
                let o = outputs(&mut m);
                let at = Conditions::of(&m.inputs, ambient, ambient, ambient);
                let coolant = Cooling::new(&m.parameters, 1).coefficients(&m.parameters, &at).coolant_inlet;
                let coldest = ambient.min(coolant.unwrap_or(ambient));
                assert!(o.winding_temperature.is_finite() && o.winding_temperature > coldest);
                assert_eq!(ended, m.time() < 50.0 && o.winding_temperature > 543.0);
                assert!(o.over_temperature == (o.winding_temperature > 428.15));
            }
        }
    }
    // Nothing of this size is lost by its own clone.
    assert!(std::mem::size_of::<Network>() < 16 * 1024);
}
