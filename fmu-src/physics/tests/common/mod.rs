//! What the tests share: motors, input profiles, and the comparison with the reference.

use declare::{Group, Scalar};
use physics::components::enclosure::Enclosure;
use physics::effects::*;
use physics::load_table::LoadTable;
use physics::model::{Model, Slot};
use physics::models::annulus_cooled_motor::cooling::{Conditions, method};
use physics::models::annulus_cooled_motor::{
    AnnulusCooledMotor, Constants, CoolingMode, DriveMode, Inputs, MechanicalMode, Parameters, STATES, Step,
};
use physics::models::brushed_gearmotor::BrushedGearmotor;
use physics::terms::{Driver, Drivers, Factor, GenericTerm, Law, MOST_TERMS, Port, Product};
use reference::{Tolerance, integrate};
use std::fmt;

/// The reference's tolerances.
pub const TIGHT: Tolerance = Tolerance { relative: 1e-10, absolute: 1e-12 };

/// Which states are temperatures, whose size is their rise.
const RISE: [bool; STATES] = [false, false, false, true, true, false, false, false];

/// Whether a state is a temperature or the heat to ambient.
fn is_thermal(state: usize) -> bool {
    RISE[state] || state == STATES - 1
}

/// A motor in these modes at its declared values.
pub fn motor(drive: DriveMode, mechanical: MechanicalMode) -> AnnulusCooledMotor {
    let mut motor = AnnulusCooledMotor::default();
    motor.parameters.choices.drive_mode = drive;
    motor.parameters.choices.mechanical_mode = mechanical;
    motor
}

/// Gives each node of the gearmotor that is off by default its nominal heat capacity.
pub fn turn_on_all_nodes(gearmotor: &mut BrushedGearmotor) {
    let thermal = &mut gearmotor.parameters.thermal;
    for (row, parameter) in Enclosure::TABLE.iter().enumerate() {
        if parameter.unit == declare::Unit::JoulePerKelvin && parameter.start == 0.0 {
            assert!(thermal.set(row, parameter.nominal));
        }
    }
}

/// These effects with terms at every port for which `serves` is true, a few at a time.
pub fn with_terms(effects: Effects, serves: fn(Port) -> bool) -> Vec<Effects> {
    let ports: Vec<Port> = Port::ALL.iter().copied().filter(|port| serves(*port)).collect();
    let some = |ports: &[Port]| {
        let terms: Vec<GenericTerm> = ports.iter().map(|port| moving_term(*port)).collect();
        let mut effects = effects;
        assert!(effects.take_terms(&terms));
        effects
    };
    ports.chunks(MOST_TERMS).map(some).collect()
}

/// A term that moves with temperature, current and speed, of a size that its port bears.
fn moving_term(port: Port) -> GenericTerm {
    let factor = |driver: Driver, offset: f64, reference: f64| {
        Some(Factor { driver, offset, reference, exponent: 0.7, range: Factor::UNLIMITED })
    };
    let factors = [
        factor(Driver::HousingTemperature, 250.0, 50.0),
        factor(Driver::Current, -20.0, 20.0),
        factor(Driver::Speed, 0.0, 1000.0),
    ];
    let coefficient = match port {
        Port::DragTorque => 5e-3,
        Port::WindingHeat | Port::HousingHeat => 5.0,
        _ => 0.2,
    };
    GenericTerm::new(port, Law::Product(Product { coefficient, factors }))
}

/// All modes of cooling.
pub fn cooling_modes() -> impl Iterator<Item = CoolingMode> {
    (1..).map_while(|value| CoolingMode::from_f64(f64::from(value)))
}

/// Those with a thermal network.
pub fn network_modes() -> impl Iterator<Item = CoolingMode> {
    cooling_modes().filter(|mode| method(*mode).has_network())
}

/// The inputs of the cooling that start at 0, by name, with their rows and nominal values: each input that a cooling mode adds is among
/// them.
pub fn cooling_inputs() -> impl Iterator<Item = (usize, &'static str, f64)> {
    let at = |inputs: &Inputs| Conditions::of(inputs, 300.0, 300.0, 300.0);
    let changes_conditions = move |row: usize, value: f64| {
        let mut inputs = Inputs::default();
        inputs.set(row, value);
        at(&inputs) != at(&Inputs::default())
    };
    let rows = Inputs::TABLE.iter().enumerate().filter(|(_, input)| input.start == 0.0);
    let all = rows.map(|(row, input)| (row, input.name, input.nominal));
    all.filter(move |(row, _, nominal)| changes_conditions(*row, *nominal))
}

/// Inputs at their start values, but those of the cooling at their nominal values: fan, pump and what other modes add are on.
pub fn busy_inputs() -> Inputs {
    let mut inputs = Inputs::default();
    for (row, _, nominal) in cooling_inputs() {
        inputs.set(row, nominal);
    }
    inputs
}

/// Dry friction of this torque, N.m.
pub fn friction(tau_c: f64) -> CoulombFriction {
    CoulombFriction { tau_c, w_small: 1.0 }
}

/// How the inputs run.
pub struct Profile {
    /// Length of a line, s; infinite where the inputs stand still.
    line: f64,
    /// Inputs are held over each communication step instead of running along the line.
    held: bool,
}

impl Profile {
    pub fn constant() -> Profile {
        Profile { line: f64::INFINITY, held: false }
    }

    pub fn ramps(line: f64) -> Profile {
        Profile { line, held: false }
    }

    pub fn held(line: f64) -> Profile {
        Profile { line, held: true }
    }

    /// Whether the inputs run along lines within a step.
    fn slopes(&self) -> bool {
        self.line.is_finite() && !self.held
    }

    /// Corner `k` of the lines: a drive with reversals, load, fan and a room that changes. Inputs without a line of their own that start
    /// at 0 vary below their nominal values.
    fn corner(&self, base: &Inputs, k: usize) -> Inputs {
        let x = k as f64;
        let mut others = *base;
        for (row, input) in Inputs::TABLE.iter().enumerate().filter(|(_, input)| input.start == 0.0) {
            others.set(row, input.nominal * (0.75 + 0.25 * (0.3 * x).sin()));
        }
        Inputs {
            voltage: 18.0 * (0.7 * x).sin() + 6.0 * (1.9 * x).cos(),
            current_command: 5.0 * (0.6 * x).sin() + 2.0,
            duty: 0.5 * (0.4 * x).sin(),
            load_torque: 0.03 * (0.9 * x).sin(),
            imposed_speed: 600.0 * (0.3 * x).sin(),
            fan_command: 0.5 - 0.4 * (0.25 * x).cos(),
            ambient_temperature: 298.15 + 3.0 * (0.1 * x).sin(),
            ambient_pressure: base.ambient_pressure,
            electrical_power: base.electrical_power * (1.0 + 0.5 * (0.8 * x).sin()),
            heat_power: 2.0 * (0.2 * x).sin(),
            coolant_inlet_temperature: 290.0 + 2.0 * (0.1 * x).sin(),
            ..others
        }
    }

    /// Inputs at `t`; those of `base` that the profile does not move stay.
    pub fn at(&self, base: &Inputs, t: f64) -> Inputs {
        if self.line.is_infinite() {
            return *base;
        }
        let k = (t / self.line + 1e-9).floor();
        let share = t / self.line - k;
        let (a, b) = (self.corner(base, k as usize), self.corner(base, k as usize + 1));
        let mut inputs = *base;
        for row in 0..Inputs::TABLE.len() {
            inputs.set(row, a.get(row) + (b.get(row) - a.get(row)) * share);
        }
        // A supply beside the duty keeps its sign.
        if base.voltage != 0.0 {
            inputs.voltage = base.voltage + 0.3 * inputs.voltage;
        }
        inputs
    }

    fn slope(&self, base: &Inputs, t: f64) -> Inputs {
        let mut slope = Inputs::zero();
        if self.slopes() {
            let (a, b) = (self.at(base, t + 0.25 * self.line), self.at(base, t + 0.75 * self.line));
            // The line that holds at t: its quarter points lie on it where t is its start.
            for row in 0..Inputs::TABLE.len() {
                slope.set(row, (b.get(row) - a.get(row)) / (0.5 * self.line));
            }
        }
        slope
    }
}

/// Largest difference of each state over a run, over its largest size (temperatures: its largest rise).
pub struct Errors {
    relative: [f64; STATES],
}

impl Errors {
    pub fn worst(&self) -> f64 {
        self.largest(|_| true)
    }

    /// That of temperatures and heat to ambient.
    pub fn thermal(&self) -> f64 {
        self.largest(is_thermal)
    }

    /// That of current, speed, angle and the energies at the terminals and the shaft.
    pub fn fast(&self) -> f64 {
        self.largest(|state| !is_thermal(state))
    }

    fn largest(&self, of: impl Fn(usize) -> bool) -> f64 {
        let all = self.relative.iter().enumerate().filter(|(state, _)| of(*state));
        all.fold(0.0, |m, (_, e)| if e.is_nan() { f64::NAN } else { m.max(*e) })
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = ["current", "speed", "angle", "T_w", "T_h", "E_in", "E_out", "E_ambient"];
        for (name, e) in names.iter().zip(self.relative) {
            write!(f, "{name} {e:.1e}  ")?;
        }
        Ok(())
    }
}

/// The states of a model in the order of [`Step::rates`].
fn states(m: &AnnulusCooledMotor) -> [f64; STATES] {
    let numbers: Vec<f64> = m.state().to_numbers().collect();
    numbers.try_into().expect("the states of Step::rates")
}

/// Drivers of the effects at these inputs and states.
fn drivers(parameters: &Parameters, inputs: &Inputs, t: f64, y: &[f64; STATES]) -> Drivers {
    let choices = &parameters.choices;
    let is_free = choices.mechanical_mode == MechanicalMode::FreeShaft;
    let current = if choices.drive_mode == DriveMode::Current { inputs.current_command } else { y[0] };
    Drivers {
        speed: if is_free { y[1] } else { inputs.imposed_speed },
        current,
        load_torque: match is_free {
            true => inputs.load_torque,
            false => parameters.motor.torque_constant(y[4]) * current,
        },
        winding_temperature: y[3],
        housing_temperature: y[4],
        ambient_temperature: inputs.ambient_temperature + parameters.effects.ambient_sensor() * t,
        fan_command: inputs.fan_command,
        time: t,
        ..Drivers::default()
    }
}

/// Runs the model by its own steps of `h` beside the reference, which begins anew where an input breaks.
pub fn compare(mut model: AnnulusCooledMotor, profile: &Profile, stop: f64, h: f64) -> Errors {
    let base = model.inputs;
    model.inputs = profile.at(&base, 0.0);
    model.start(0.0).unwrap();
    let mut y = states(&model);
    let ambient = y[3];
    let mut error = [0.0f64; STATES];
    let mut size = [0.0f64; STATES];
    let parameters = model.parameters;
    let constants = Constants::of(&parameters);
    let smooth = if profile.held { h } else { profile.line.min(stop) };
    let steps = (smooth / h).round() as usize;
    let pieces = (stop / smooth).round() as usize;
    for piece in 0..pieces {
        let t0 = piece as f64 * smooth;
        let (inputs, slopes) = (profile.at(&base, t0), profile.slope(&base, t0));
        let conductance = |of: &Parameters| of.to_ambient(inputs.fan_command);
        let step = Step::new(&parameters, &constants, &inputs, &slopes, conductance(&parameters), t0);
        // What the inputs dictate jumps with them.
        model.inputs = inputs;
        touch(&mut model);
        let now = states(&model);
        let dictated = [now[0], now[1]];
        if parameters.choices.drive_mode as i32 >= DriveMode::Current as i32 {
            y[0] = dictated[0];
        }
        if parameters.choices.mechanical_mode == MechanicalMode::ImposedSpeed {
            y[1] = dictated[1];
        }
        let times: Vec<f64> = (1..=steps).map(|k| k as f64 * h).collect();
        // The reference sees temperatures as rises, so that its tolerance is one on the rise.
        let shift =
            |y: &[f64; STATES], by: f64| std::array::from_fn(|s| y[s] + if RISE[s] { by } else { 0.0 });
        let rates = |t: f64, z: &[f64; STATES]| {
            let y = shift(z, ambient);
            if !parameters.effects.acts_at(EffectPort::Any) {
                return step.rates(t, &y);
            }
            // The drivers that a step of the model holds, at this instant.
            let mut now = parameters;
            now.effects.set_drivers(&drivers(&now, &inputs.after(t, &slopes), t0 + t, &y));
            Step::new(&now, &constants, &inputs, &slopes, conductance(&now), t0).rates(t, &y)
        };
        let truth = integrate(rates, &shift(&y, -ambient), &times, TIGHT).unwrap();
        let truth: Vec<[f64; STATES]> = truth.iter().map(|z| shift(z, ambient)).collect();
        for (k, truth) in truth.iter().enumerate() {
            let t = t0 + k as f64 * h;
            model.inputs = if profile.held { inputs } else { profile.at(&base, t) };
            touch(&mut model);
            for row in 0..Inputs::TABLE.len() {
                model.set_slope(Slot { group: 0, row: row as u16 }, slopes.get(row));
            }
            model.step(model.time(), h).unwrap();
            let got = states(&model);
            for s in 0..STATES {
                let origin = if RISE[s] { ambient } else { 0.0 };
                error[s] = error[s].max((got[s] - truth[s]).abs());
                size[s] = size[s].max((truth[s] - origin).abs());
            }
        }
        y = *truth.last().unwrap();
    }
    Errors {
        relative: std::array::from_fn(
            |s| if size[s] <= TIGHT.absolute { error[s] } else { error[s] / size[s] },
        ),
    }
}

/// Lets a model see that its inputs were written directly.
fn touch(model: &mut AnnulusCooledMotor) {
    let slot = Slot { group: 0, row: 0 };
    let value = model.get(slot);
    model.set(slot, value);
}

/// A load with three rows, for models that take one.
pub fn load_table() -> LoadTable {
    let (torques, speeds) = (vec![20.0, -5.0, 40.0], vec![1.0, -2.0, 0.5]);
    LoadTable { times: vec![0.0, 0.2, 0.7], torques, speeds, period: 1.1, angle: None }
}
