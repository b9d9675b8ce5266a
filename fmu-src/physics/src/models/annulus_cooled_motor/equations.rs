//! The equations of the motor.
//!
//! voltage drive     L dI/dt = V - R(T_w) I - k_t(T_m) w                                    (1)
//! current drive     I = I_command                                                          (2)
//! free shaft        J dw/dt = k_t(T_m) I - tau_drag(w) - tau_load                          (3)
//! imposed speed     w = w_imposed                                                          (4)
//! copper heat       Q_w = R(T_w) I^2 (+ heat_power; electrical_power in drive_mode power)  (5)
//! friction heat     Q_h = tau_drag w                                                       (6)
//! temperatures      components/thermal.rs (1), (2) with components/conductance.rs (1)
//!
//! Whoever imposes a current or a speed also feeds the energy that inductance or rotor store by it; those
//! energies stay outside the model's books, and L dI/dt and J dw/dt outside its terminals and its shaft.
//! In drive_mode power no current flows.
//!
//! Over one step every input runs along a line. The equations are solved by `solver/split.rs`; its reference is
//! `solver/reference.rs`, which takes [`Step::rates`].

use super::{DriveMode, Inputs, MechanicalMode, Outputs, Parameters};
use crate::ledger::{Account, Ledger};
use crate::solver::split::{Fast, Segment, State, System, Work};
use nalgebra::{Matrix2, SMatrix, SVector};

/// Thermal nodes: winding and housing.
pub const NODES: usize = 2;
const WINDING: usize = 0;
const HOUSING: usize = 1;
/// Temperatures of the nodes, K.
pub type Temperatures = SVector<f64, NODES>;

/// State variables of [`Step::rates`]: current, speed, angle, T_w, T_h, and the three energies.
pub const STATES: usize = 3 + NODES + 3;

impl Inputs {
    /// All zero: no slope.
    pub const ZERO: Inputs = Inputs {
        voltage: 0.0,
        current_command: 0.0,
        duty: 0.0,
        load_torque: 0.0,
        imposed_speed: 0.0,
        fan_command: 0.0,
        ambient_temperature: 0.0,
        electrical_power: 0.0,
        heat_power: 0.0,
    };
}

/// A value that runs along a line.
#[derive(Clone, Copy, Debug)]
struct Line {
    start: f64,
    slope: f64,
}

impl Line {
    #[inline]
    fn at(&self, t: f64) -> f64 {
        self.start + self.slope * t
    }
}

/// What follows from the parameters alone, so that no step divides by them again.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    /// 1/L where the inductance decides the current, 0 where the source does.
    inverse_l: f64,
    /// 1/J where the rotor is free, 0 where its speed is imposed.
    inverse_j: f64,
    /// Heat capacities of the nodes, J/K.
    capacity: Temperatures,
    /// Their reciprocals, K/J.
    inverse_capacity: Temperatures,
    /// Conductance from winding to housing, W/K.
    across: f64,
}

impl Constants {
    /// The constants of a motor.
    pub fn of(parameters: &Parameters) -> Constants {
        let voltage_driven = matches!(parameters.choices.drive_mode, DriveMode::Voltage | DriveMode::Pwm);
        let free = parameters.choices.mechanical_mode == MechanicalMode::FreeShaft;
        let capacity = Temperatures::new(parameters.thermal.C_w, parameters.thermal.C_h);
        Constants {
            inverse_l: if voltage_driven { 1.0 / parameters.motor.L } else { 0.0 },
            inverse_j: if free { 1.0 / parameters.motor.J } else { 0.0 },
            capacity,
            inverse_capacity: capacity.map(|c| 1.0 / c),
            across: parameters.thermal.winding_to_housing(1.0, 0.0),
        }
    }
}

/// The equations over one step, inputs on their lines. Times are seconds from the start of the step.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    model: &'a Parameters,
    inputs: &'a Inputs,
    slopes: &'a Inputs,
    constants: &'a Constants,
    /// The voltage of the source, V.
    voltage: Line,
    /// The current, where it is imposed, A.
    current: Line,
    /// The torque of the load, N.m, where the rotor is free.
    load: Line,
    /// The speed, where it is imposed, rad/s.
    speed: Line,
    /// Heat set free in the winding without a current, W.
    heat: Line,
    /// Conductance to ambient, where the fan stands still over the step, W/K.
    conductance: f64,
}

/// All that the equations say at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Voltage at the terminals, V.
    pub voltage: f64,
    /// Drag torque, N.m.
    pub drag: f64,
    /// Torque given to the load, N.m.
    pub shaft_torque: f64,
    /// Derivatives of current and speed.
    pub fast: Fast,
    /// Derivatives of the temperatures, K/s.
    pub warming: Temperatures,
    /// Heat flow to the surroundings, W.
    pub to_ambient: f64,
    /// The books.
    pub ledger: Ledger,
}

impl<'a> Step<'a> {
    /// The equations of a motor with its inputs on lines; `conductance` is that of the fan's command.
    #[inline]
    pub fn new(
        model: &'a Parameters,
        constants: &'a Constants,
        inputs: &'a Inputs,
        slopes: &'a Inputs,
        conductance: f64,
    ) -> Self {
        let none = Line { start: 0.0, slope: 0.0 };
        let (u, s) = (inputs, slopes);
        let voltage = match model.choices.drive_mode {
            DriveMode::Voltage => Line { start: u.voltage, slope: s.voltage },
            // A product of two lines: exact at the start, its tangent after.
            DriveMode::Pwm => {
                Line { start: u.duty * u.voltage, slope: s.duty * u.voltage + u.duty * s.voltage }
            }
            DriveMode::Current | DriveMode::Power => none,
        };
        let current = match model.choices.drive_mode {
            DriveMode::Current => Line { start: u.current_command, slope: s.current_command },
            _ => none,
        };
        let mut heat = Line { start: u.heat_power, slope: s.heat_power };
        if model.choices.drive_mode == DriveMode::Power {
            heat = Line { start: heat.start + u.electrical_power, slope: heat.slope + s.electrical_power };
        }
        let free = constants.inverse_j != 0.0;
        Step {
            model,
            inputs,
            slopes,
            constants,
            voltage,
            current,
            load: if free { Line { start: u.load_torque, slope: s.load_torque } } else { none },
            speed: if free { none } else { Line { start: u.imposed_speed, slope: s.imposed_speed } },
            heat,
            conductance,
        }
    }

    fn is_free(&self) -> bool {
        self.constants.inverse_j != 0.0
    }

    fn is_voltage_driven(&self) -> bool {
        self.constants.inverse_l != 0.0
    }

    #[inline]
    fn conductance_at(&self, t: f64) -> f64 {
        if self.slopes.fan_command == 0.0 {
            self.conductance
        } else {
            self.model.conductance.at(self.inputs.fan_command + self.slopes.fan_command * t)
        }
    }

    #[inline]
    fn ambient(&self, t: f64) -> f64 {
        self.inputs.ambient_temperature + self.slopes.ambient_temperature * t
    }

    /// The inputs after `t` seconds on their lines.
    pub fn inputs_at(&self, t: f64) -> Inputs {
        use declare::Group;
        let mut inputs = *self.inputs;
        for row in 0..Inputs::TABLE.len() {
            inputs.set(row, self.inputs.get(row) + self.slopes.get(row) * t);
        }
        inputs
    }

    /// Energy in the model's stores, J: magnetic and kinetic where they are its own, and heat above 0 K.
    pub fn stored(&self, state: &State<NODES>) -> f64 {
        let (i, w) = (state.x[0], state.x[1]);
        self.magnetic(i) + self.kinetic(w) + self.capacity().dot(&state.temperature)
    }

    fn magnetic(&self, i: f64) -> f64 {
        if self.is_voltage_driven() { 0.5 * self.model.motor.L * i * i } else { 0.0 }
    }

    fn kinetic(&self, w: f64) -> f64 {
        if self.is_free() { 0.5 * self.model.motor.J * w * w } else { 0.0 }
    }

    /// Everything at one instant.
    pub fn point(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Point {
        use Account::*;
        let motor = &self.model.motor;
        let (i, w) = (x[0], x[1]);
        let (t_w, t_h) = (temperature[WINDING], temperature[HOUSING]);
        let (r, k) = (motor.resistance(t_w), motor.torque_constant(t_h));
        let drag = self.model.effects.drag_torque(w);
        let fast = self.fast_rates(t, x, temperature);
        let voltage = if self.is_voltage_driven() { self.voltage.at(t) } else { r * i + k * w };
        let shaft_torque = if self.is_free() { self.load.at(t) } else { k * i - drag };
        let to_ambient = self.ambient_flow(t, temperature);
        let across = self.model.thermal.winding_to_housing(t_w, t_h);

        let mut ledger = Ledger::default();
        ledger.transfer(Terminals, Winding, r * i * i);
        ledger.transfer(Terminals, Winding, self.heat.at(t));
        ledger.transfer(Terminals, AirGap, k * w * i);
        ledger.transfer(AirGap, Housing, drag * w);
        ledger.transfer(AirGap, Shaft, shaft_torque * w);
        if self.is_voltage_driven() {
            ledger.transfer(Terminals, Magnetic, motor.L * i * fast[0]);
        }
        if self.is_free() {
            ledger.transfer(AirGap, Kinetic, motor.J * w * fast[1]);
        }
        ledger.transfer(Winding, Housing, across);
        ledger.transfer(Housing, Ambient, to_ambient);

        let warming = self.network_rates(t, temperature)
            + self.heat_rates(t, x, temperature).component_mul(self.inverse_capacity());
        Point { voltage, drag, shaft_torque, fast, warming, to_ambient, ledger }
    }

    /// Power taken in at one instant: at the terminals and as heat, W.
    fn power_in(&self, t: f64, point: &Point, x: &Fast) -> f64 {
        point.voltage * x[0] + self.heat.at(t)
    }

    /// Derivatives of all states, for an integrator that knows nothing of the split.
    ///
    /// `y` holds current, A, speed, rad/s, angle, rad, winding and housing temperature, K, and the energies
    /// taken in, given to the load and given to the surroundings, J.
    pub fn rates(&self, t: f64, y: &[f64; STATES]) -> [f64; STATES] {
        let x = Fast::new(y[0], y[1]);
        let temperature = Temperatures::new(y[3], y[4]);
        let p = self.point(t, &x, &temperature);
        let power = self.power_in(t, &p, &x);
        [p.fast[0], p.fast[1], y[1], p.warming[0], p.warming[1], power, p.shaft_torque * y[1], p.to_ambient]
    }

    /// The outputs at the start of the step.
    pub fn outputs(&self, state: &State<NODES>, stored_at_start: f64) -> Outputs {
        use Account::*;
        let model = self.model;
        let (x, temperature) = (&state.x, &state.temperature);
        let (i, w) = (x[0], x[1]);
        let (t_w, t_h) = (temperature[WINDING], temperature[HOUSING]);
        let p = self.point(0.0, x, temperature);
        let capacity = self.capacity();
        let power_balance_error = p.ledger.error(&[
            (Terminals, -self.power_in(0.0, &p, x)),
            (AirGap, 0.0),
            (Shaft, p.shaft_torque * w),
            (Winding, capacity[WINDING] * p.warming[WINDING]),
            (Housing, capacity[HOUSING] * p.warming[HOUSING]),
        ]);
        let [energy_in, energy_out, energy_heat] = state.energy;
        let r = model.motor.resistance(t_w);
        let copper = r * i * i;
        let (electrical, copper) = match model.choices.drive_mode {
            DriveMode::Power => (self.inputs.electrical_power, copper + self.inputs.electrical_power),
            _ => (p.voltage * i, copper),
        };
        Outputs {
            current: i,
            shaft_angle: state.angle,
            shaft_speed: w,
            shaft_torque: p.shaft_torque,
            winding_temperature: t_w,
            stator_temperature: t_h,
            magnet_temperature: t_h,
            housing_temperature: t_h,
            winding_resistance: r,
            torque_constant: model.motor.torque_constant(t_h),
            power_electrical: electrical,
            power_mechanical: p.shaft_torque * w,
            loss_copper: copper,
            loss_friction: p.drag * w,
            heat_to_ambient: p.to_ambient,
            power_balance_error,
            winding_margin: model.thermal.T_w_max - t_w,
            over_temperature: t_w > model.thermal.T_w_max,
            torque_density: p.shaft_torque / model.motor.mass,
            terminal_voltage: p.voltage,
            energy_electrical: energy_in,
            energy_mechanical: energy_out,
            energy_heat_to_ambient: energy_heat,
            energy_balance_error: energy_in
                - energy_out
                - energy_heat
                - (self.stored(state) - stored_at_start),
        }
    }
}

impl System<NODES> for Step<'_> {
    #[inline]
    fn fast_rates(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Fast {
        let motor = &self.model.motor;
        let (i, w) = (x[0], x[1]);
        let k = motor.torque_constant(temperature[HOUSING]);
        let di = if self.is_voltage_driven() {
            (self.voltage.at(t) - motor.resistance(temperature[WINDING]) * i - k * w)
                * self.constants.inverse_l
        } else {
            self.current.slope
        };
        let dw = if self.is_free() {
            (k * i - self.model.effects.drag_torque(w) - self.load.at(t)) * self.constants.inverse_j
        } else {
            self.speed.slope
        };
        Fast::new(di, dw)
    }

    #[inline]
    fn fast_matrix(&self, _t: f64, x: &Fast, temperature: &Temperatures) -> Matrix2<f64> {
        let motor = &self.model.motor;
        let r = motor.resistance(temperature[WINDING]);
        let k = motor.torque_constant(temperature[HOUSING]);
        let slope = if self.is_free() { self.model.effects.drag_torque_slope(x[1]) } else { 0.0 };
        let (l, j) = (self.constants.inverse_l, self.constants.inverse_j);
        Matrix2::new(-r * l, -k * l, k * j, -slope * j)
    }

    #[inline]
    fn network_rates(&self, t: f64, temperature: &Temperatures) -> Temperatures {
        let across = self.constants.across * (temperature[WINDING] - temperature[HOUSING]);
        let gain = Temperatures::new(-across, across - self.ambient_flow(t, temperature));
        gain.component_mul(&self.constants.inverse_capacity)
    }

    #[inline]
    fn network_matrix(&self, t: f64) -> SMatrix<f64, NODES, NODES> {
        let per_kelvin = self.constants.inverse_capacity;
        let (w, h) =
            (self.constants.across * per_kelvin[WINDING], self.constants.across * per_kelvin[HOUSING]);
        Matrix2::new(-w, w, h, -h - self.conductance_at(t) * per_kelvin[HOUSING])
    }

    #[inline]
    fn capacity(&self) -> &Temperatures {
        &self.constants.capacity
    }

    #[inline]
    fn inverse_capacity(&self) -> &Temperatures {
        &self.constants.inverse_capacity
    }

    #[inline]
    fn ambient_flow(&self, t: f64, temperature: &Temperatures) -> f64 {
        self.conductance_at(t) * (temperature[HOUSING] - self.ambient(t))
    }

    #[inline]
    fn heat_rates(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Temperatures {
        let (i, w) = (x[0], x[1]);
        let copper = self.model.motor.resistance(temperature[WINDING]) * i * i;
        Temperatures::new(copper + self.heat.at(t), self.model.effects.drag_torque(w) * w)
    }

    /// The energies of one step. All but the friction heat follow from integrals that are exact for the fast
    /// solution; the copper heat of a voltage drive is what the books leave, so they close by construction.
    #[inline]
    fn work(&self, segment: &Segment<NODES>) -> Work<NODES> {
        let (motor, effects) = (&self.model.motor, &self.model.effects);
        let (t, h) = (segment.t, segment.h);
        let [x0, xm, x1] = segment.x;
        let simpson = |f0: f64, fm: f64, f1: f64| h / 6.0 * (f0 + 4.0 * fm + f1);
        // A line times the solution: value at the step's start by the integral, slope by the moment.
        let line = |l: &Line, k: usize| l.at(t) * segment.integral[k] + l.slope * segment.moment[k];
        let k_t = |n: usize| motor.torque_constant(segment.temperature[n][HOUSING]);

        // Simpson's rule for what the drag adds to its value at the end; that value times the exact angle.
        let drag_end = effects.drag_torque(x1[1]);
        let beyond = |w: f64| (effects.drag_torque(w) - drag_end) * w;
        let (beyond_start, beyond_middle) = (beyond(x0[1]), beyond(xm[1]));
        let extra = simpson(beyond_start, beyond_middle, 0.0);
        let doubt = (extra - 0.5 * h * beyond_start).abs();
        let friction = drag_end * segment.integral[1] + extra;
        let (air_gap, mechanical) = if self.is_free() {
            let load = line(&self.load, 1);
            (self.kinetic(x1[1]) - self.kinetic(x0[1]) + load + friction, load)
        } else {
            let air_gap = if self.is_voltage_driven() {
                // The magnets' temperature moves by microkelvins over a step; its middle stands for it.
                k_t(1) * line(&self.speed, 0)
            } else {
                simpson(k_t(0) * x0[0] * x0[1], k_t(1) * xm[0] * xm[1], k_t(2) * x1[0] * x1[1])
            };
            (air_gap, air_gap - friction)
        };
        let heat = simpson(self.heat.at(t), self.heat.at(t + 0.5 * h), self.heat.at(t + h));
        let (copper, electrical) = if self.is_voltage_driven() {
            let electrical = line(&self.voltage, 0);
            (electrical - (self.magnetic(x1[0]) - self.magnetic(x0[0])) - air_gap, electrical)
        } else {
            let r = |n: usize| motor.resistance(segment.temperature[n][WINDING]);
            let copper = simpson(r(0) * x0[0] * x0[0], r(1) * xm[0] * xm[0], r(2) * x1[0] * x1[0]);
            (copper, copper + air_gap)
        };
        Work {
            heat: Temperatures::new(copper + heat, friction),
            electrical: electrical + heat,
            mechanical,
            doubt,
        }
    }

    #[inline]
    fn wants_moment(&self) -> bool {
        self.voltage.slope != 0.0 || self.load.slope != 0.0 || self.speed.slope != 0.0
    }
}
