//! The equations of the motor.
//!
//! voltage drive     L dI/dt = V - R(T_w) I - V_drop(I) - k_t(T_m) w                        (1)
//! current drive     I = I_command                                                          (2)
//! free shaft        J dw/dt = k_t(T_m) I - tau_drag - tau_load                             (3)
//! imposed speed     w = w_imposed                                                          (4)
//! copper heat       Q_w = R(T_w) I^2 + V_drop(I) I (+ heat_power; electrical_power in drive_mode power) (5)
//! friction heat     Q_h = tau_drag w, with tau_drag = tau(w) + c(w, tau_s) tau_s           (6)
//! temperatures      components/thermal.rs (1), (2) with components/conductance.rs (1)
//!
//! tau_s is the torque handed to the load: tau_load on a free shaft, k_t I - tau_drag on an imposed one.
//! V_drop, tau and c are the sums over all effects (`effects.rs`).
//!
//! Effects also multiply k_t and the resistance from winding to housing, add conductances to ambient and
//! radiation, shift the ambient temperature, and take their share of electrical_power (`effects.rs`).
//!
//! Whoever imposes a current or a speed also feeds the energy that inductance or rotor store by it; those
//! energies stay outside the model's books, and L dI/dt and J dw/dt outside its terminals and its shaft.
//! In drive_mode power no current flows.
//!
//! Over one step every input runs along a line. The equations are solved by `solver/split.rs`; its reference is
//! `solver/reference.rs`, which takes [`Step::rates`].

mod outputs;
mod ports;

use super::{DriveMode, Inputs, MechanicalMode, Parameters};
use crate::effects::{Effect, PerNode};
use crate::ledger::{Account, Ledger};
use crate::solver::split::{Fast, Segment, State, System, Work};
use nalgebra::{Matrix2, SMatrix, SVector};
use ports::{Acts, Ports};

/// Thermal nodes: winding and housing.
pub const NODES: usize = 2;
pub(super) const WINDING: usize = 0;
pub(super) const HOUSING: usize = 1;
/// Temperatures of the nodes, K.
pub type Temperatures = SVector<f64, NODES>;

/// State variables of [`Step::rates`]: current, speed, angle, T_w, T_h, and the three energies.
pub const STATES: usize = 3 + NODES + 3;

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
    /// How fast the true ambient temperature leaves the shown one, K/s.
    drift: f64,
    /// Share of electrical_power that the drive loses.
    lost: f64,
    /// Whether a port may jump at a time of its own.
    pub(super) eventful: bool,
    /// Where effects act.
    acts: Acts,
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
            drift: parameters.effects.ambient_sensor(),
            lost: parameters.effects.drive_loss(),
            eventful: parameters.effects.next_event(f64::NEG_INFINITY).is_finite(),
            acts: Acts::of(&parameters.effects),
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
    /// Heat that the drive gives to the surroundings, W.
    drive: Line,
    /// True temperature of the surroundings, K.
    ambient: Line,
    /// What is left of the torque constant, 1 for all.
    strength: f64,
    /// Conductance to ambient, where the fan stands still over the step, W/K.
    conductance: PerNode,
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
    /// Heat flow to the surroundings, W: from the winding, the housing, and the drive.
    pub to_ambient: f64,
    /// The books.
    pub ledger: Ledger,
}

impl<'a> Step<'a> {
    /// The equations of a motor with its inputs on lines from `time` on; `conductance` is that of the fan's
    /// command, [`Parameters::to_ambient`]. They hold until the next event of the effects.
    #[inline]
    pub fn new(
        model: &'a Parameters,
        constants: &'a Constants,
        inputs: &'a Inputs,
        slopes: &'a Inputs,
        conductance: PerNode,
        time: f64,
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
        let mut heat = Line { start: u.heat_power + model.effects.winding_heat(), slope: s.heat_power };
        let mut drive = none;
        if model.choices.drive_mode == DriveMode::Power {
            let lost = constants.lost;
            drive = Line { start: lost * u.electrical_power, slope: lost * s.electrical_power };
            heat.start += u.electrical_power - drive.start;
            heat.slope += s.electrical_power - drive.slope;
        }
        let drift = constants.drift;
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
            drive,
            ambient: Line {
                start: u.ambient_temperature + drift * time + model.effects.ambient_offset(),
                slope: s.ambient_temperature + drift,
            },
            strength: model.effects.torque_constant(time),
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
    fn ports(&self) -> Ports<'_> {
        Ports { effects: &self.model.effects, acts: self.constants.acts }
    }

    /// The torque against the motion, N.m; `k` is the torque constant.
    #[inline(always)]
    fn drag(&self, t: f64, x: &Fast, k: f64) -> f64 {
        let effects = self.ports();
        let own = effects.drag_torque(x[1]);
        if self.is_free() {
            let load = self.load.at(t);
            own + effects.load_drag(x[1], load) * load
        } else {
            // The friction of the load takes its share of the very torque that it leaves over.
            let before = k * x[0] - own;
            let share = effects.load_drag(x[1], before);
            if share == 0.0 { own } else { own + before * (share / (1.0 + share)) }
        }
    }

    #[inline]
    fn conductance_at(&self, t: f64) -> PerNode {
        if self.slopes.fan_command == 0.0 {
            self.conductance
        } else {
            self.model.to_ambient(self.inputs.fan_command + self.slopes.fan_command * t)
        }
    }

    /// Torque constant with the magnets at the housing's temperature.
    #[inline]
    fn torque_constant(&self, temperature: &Temperatures) -> f64 {
        self.model.motor.torque_constant(temperature[HOUSING]) * self.strength
    }

    /// Resistance of the winding, Ohm.
    #[inline]
    fn resistance(&self, t_w: f64) -> f64 {
        self.model.motor.resistance(t_w) * self.ports().winding_resistance()
    }

    /// Heat flows from the nodes to the surroundings, W.
    #[inline]
    fn leaving(&self, t: f64, temperature: &Temperatures) -> PerNode {
        let (conductance, ambient) = (self.conductance_at(t), self.ambient.at(t));
        PerNode {
            winding: conductance.winding * (temperature[WINDING] - ambient),
            housing: conductance.housing * (temperature[HOUSING] - ambient)
                + self.ports().housing_to_ambient(temperature[HOUSING], ambient),
        }
    }

    /// Power lost in the drive at the start of the step, W.
    pub fn drive_loss(&self) -> f64 {
        self.drive.start
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
        let (r, k) = (self.resistance(t_w), self.torque_constant(temperature));
        let lost = self.ports().terminal_voltage(i);
        let drag = self.drag(t, x, k);
        let fast = self.fast_rates(t, x, temperature);
        let voltage = if self.is_voltage_driven() { self.voltage.at(t) } else { r * i + lost + k * w };
        let shaft_torque = if self.is_free() { self.load.at(t) } else { k * i - drag };
        let (leaving, drive) = (self.leaving(t, temperature), self.drive.at(t));
        let insulation = self.ports().winding_housing_resistance(t_w);
        let across = self.model.thermal.winding_to_housing(t_w, t_h) / insulation;

        let mut ledger = Ledger::default();
        ledger.transfer(Terminals, Winding, r * i * i);
        ledger.transfer(Terminals, Winding, lost * i);
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
        ledger.transfer(Winding, Ambient, leaving.winding);
        ledger.transfer(Housing, Ambient, leaving.housing);
        ledger.transfer(Terminals, Ambient, drive);

        let warming = self.network_rates(t, temperature)
            + self.heat_rates(t, x, temperature).component_mul(self.inverse_capacity());
        let to_ambient = self.ambient_flow(t, temperature) + drive;
        Point { voltage, drag, shaft_torque, fast, warming, to_ambient, ledger }
    }

    /// Power taken in at one instant: at the terminals and as heat, W.
    fn power_in(&self, t: f64, point: &Point, x: &Fast) -> f64 {
        point.voltage * x[0] + self.heat.at(t) + self.drive.at(t)
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
}

impl System<NODES> for Step<'_> {
    #[inline(always)]
    fn fast_rates(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Fast {
        let (i, w) = (x[0], x[1]);
        let k = self.torque_constant(temperature);
        let di = if self.is_voltage_driven() {
            let lost = self.ports().terminal_voltage(i);
            (self.voltage.at(t) - self.resistance(temperature[WINDING]) * i - lost - k * w)
                * self.constants.inverse_l
        } else {
            self.current.slope
        };
        let dw = if self.is_free() {
            (k * i - self.drag(t, x, k) - self.load.at(t)) * self.constants.inverse_j
        } else {
            self.speed.slope
        };
        Fast::new(di, dw)
    }

    #[inline]
    fn fast_matrix(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Matrix2<f64> {
        let effects = self.ports();
        let r = self.resistance(temperature[WINDING]) + effects.terminal_voltage_slope(x[0]);
        let k = self.torque_constant(temperature);
        let slope = if self.is_free() {
            let load = self.load.at(t);
            effects.drag_torque_slope(x[1]) + effects.load_drag_slope(x[1], load) * load
        } else {
            0.0
        };
        let (l, j) = (self.constants.inverse_l, self.constants.inverse_j);
        Matrix2::new(-r * l, -k * l, k * j, -slope * j)
    }

    #[inline]
    fn network_rates(&self, t: f64, temperature: &Temperatures) -> Temperatures {
        let conducts = self.constants.across * self.ports().winding_housing_conductance(temperature[WINDING]);
        let across = conducts * (temperature[WINDING] - temperature[HOUSING]);
        let leaving = self.leaving(t, temperature);
        let gain = Temperatures::new(-across - leaving.winding, across - leaving.housing);
        gain.component_mul(&self.constants.inverse_capacity)
    }

    #[inline]
    fn network_matrix(&self, t: f64, temperature: &Temperatures) -> SMatrix<f64, NODES, NODES> {
        let effects = self.ports();
        let (t_w, t_h) = (temperature[WINDING], temperature[HOUSING]);
        // What crosses from winding to housing grows with T_w by `hot` and falls with T_h by `cold`.
        let share = effects.winding_housing_conductance(t_w);
        let cold = self.constants.across * share;
        let hot = cold - cold * (t_w - t_h) * effects.winding_housing_resistance_slope(t_w) * share;
        let conductance = self.conductance_at(t);
        let from_housing = conductance.housing + effects.housing_to_ambient_slope(t_h, self.ambient.at(t));
        let per_kelvin = self.constants.inverse_capacity;
        Matrix2::new(
            (-hot - conductance.winding) * per_kelvin[WINDING],
            cold * per_kelvin[WINDING],
            hot * per_kelvin[HOUSING],
            (-cold - from_housing) * per_kelvin[HOUSING],
        )
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
        let leaving = self.leaving(t, temperature);
        leaving.winding + leaving.housing
    }

    #[inline]
    fn heat_rates(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Temperatures {
        let (i, w) = (x[0], x[1]);
        let volts = self.resistance(temperature[WINDING]) * i + self.ports().terminal_voltage(i);
        let drag = self.drag(t, x, self.torque_constant(temperature));
        Temperatures::new(volts * i + self.heat.at(t), drag * w)
    }

    /// The energies of one step. All but the friction heat follow from integrals that are exact for the fast
    /// solution; the copper heat of a voltage drive is what the books leave, so they close by construction.
    #[inline]
    fn work(&self, segment: &Segment<NODES>) -> Work<NODES> {
        let effects = self.ports();
        let (t, h) = (segment.t, segment.h);
        let [x0, xm, x1] = segment.x;
        let simpson = |f0: f64, fm: f64, f1: f64| h / 6.0 * (f0 + 4.0 * fm + f1);
        // A line times the solution: value at the step's start by the integral, slope by the moment.
        let line = |l: &Line, k: usize| l.at(t) * segment.integral[k] + l.slope * segment.moment[k];
        let k_t = |n: usize| self.torque_constant(&segment.temperature[n]);

        // The integral of f times current or speed: the value at the end times their exact integral, and what f
        // differs from it by Simpson's rule; with it, how far the trapezoidal rule would miss.
        let against = |f: [f64; 3], k: usize| {
            let beyond = |n: usize| (f[n] - f[2]) * segment.x[n][k];
            let start = beyond(0);
            let extra = simpson(start, beyond(1), 0.0);
            (f[2] * segment.integral[k] + extra, (extra - 0.5 * h * start).abs())
        };
        let drag = |n: usize, at: f64| self.drag(at, &segment.x[n], k_t(n));
        let (friction, mut doubt) = against([drag(0, t), drag(1, t + 0.5 * h), drag(2, t + h)], 1);
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
        let heat = h * self.heat.at(t + 0.5 * h);
        let drive = h * self.drive.at(t + 0.5 * h);
        let (copper, electrical) = if self.is_voltage_driven() {
            let electrical = line(&self.voltage, 0);
            (electrical - (self.magnetic(x1[0]) - self.magnetic(x0[0])) - air_gap, electrical)
        } else {
            let r = |n: usize| self.resistance(segment.temperature[n][WINDING]);
            let copper = simpson(r(0) * x0[0] * x0[0], r(1) * xm[0] * xm[0], r(2) * x1[0] * x1[0]);
            let (drop, doubt_of_drop) = against([x0, xm, x1].map(|x| effects.terminal_voltage(x[0])), 0);
            doubt += doubt_of_drop;
            (copper + drop, copper + drop + air_gap)
        };
        Work {
            heat: Temperatures::new(copper + heat, friction),
            electrical: electrical + heat + drive,
            mechanical,
            ambient: drive,
            doubt,
        }
    }

    #[inline]
    fn bends_where_stiff(&self) -> bool {
        // The drop of contacts turns within milliamperes, and the inductance passes them in microseconds.
        self.constants.acts.terminal_voltage
    }

    #[inline]
    fn wants_moment(&self) -> bool {
        self.voltage.slope != 0.0 || self.load.slope != 0.0 || self.speed.slope != 0.0
    }
}
