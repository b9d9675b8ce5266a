//! The equations of the motor.
//!
//! voltage drive     L dI/dt = V - R(T_w) I - V_drop(I) - k_t(T_m) w                        (1)
//! current drive     I = I_command                                                          (2)
//! free shaft        J dw/dt = k_t(T_m) I - tau_drag - tau_load                             (3)
//! imposed speed     w = w_imposed                                                          (4)
//! copper heat       Q_w = R(T_w) I^2 + V_drop(I) I (+ heat_power; in drive_mode power: electrical_power without the drive loss,
//!                   the heat in the stator and the power of the load)                      (5)
//! friction heat     Q_h = tau_drag w, with tau_drag = tau(w) + c(w, tau_s) tau_s           (6)
//! temperatures      components/thermal.rs (1), (2) with components/conductance.rs (1), or network.rs
//!
//! tau_s is the torque on the load: tau_load on a free shaft, k_t I - tau_drag at an imposed speed.
//! V_drop, tau and c are the sums over all effects (`effects.rs`).
//!
//! Effects also multiply k_t and the resistance from winding to housing, add conductances to ambient and
//! radiation, shift the ambient temperature, and dissipate a fraction of electrical_power (`effects.rs`).
//!
//! The source that imposes a current or a speed also supplies the energy stored in the inductance or the rotor. The energy
//! balance, the terminal voltage and the shaft torque therefore exclude these energies, L dI/dt and J dw/dt.
//! In drive_mode power the current is zero.
//!
//! Over one step every input is linear in time. `solver/split.rs` solves the equations; the crate `reference` solves
//! [`Step::rates`] as the reference.

mod constants;
mod drive;
mod driven;
mod outputs;
mod system;

pub use constants::Constants;

use super::parameters::Parameters;
use super::variables::{DriveMode, Inputs, MechanicalMode};
use crate::components::commutation::PhaseLoad;
use crate::effects::{EffectPort, PerNode, Ports};
use crate::ledger::{Account, Ledger};
use crate::line::Line;
use crate::solver::split::{Fast, State, System};
use crate::terms::{Driver, Drivers, MOST_TERMS};
use declare::Group;
use drive::Chopper;
use nalgebra::SVector;
use system::Instant;

/// Thermal nodes that a step solves: the winding and its neighbour. The neighbour is the stator if the model has a network
/// (`network.rs`), else the whole housing.
pub const NODES: usize = 2;
const WINDING: usize = 0;
const CORE: usize = 1;
/// Temperatures of the nodes, K.
pub type Temperatures = SVector<f64, NODES>;

/// Number of states of [`Step::rates`]: current, speed, angle, T_w, T_h, and the three energies.
pub const STATES: usize = 3 + NODES + 3;

/// Form of the equations: all of them, those of [`Constants::are_plain`] without the branches of the others, the latter without a
/// network, or these with constant inputs.
pub const ALL: u8 = 0;
pub(super) const PLAIN: u8 = 1;
pub(super) const PLAIN_ALONE: u8 = 2;
pub(super) const PLAIN_STILL: u8 = 3;

/// The equations over one step with linear inputs, in one of the forms. Times are seconds from the start of the step.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, const FORM: u8 = ALL> {
    model: &'a Parameters,
    inputs: &'a Inputs,
    slopes: &'a Inputs,
    /// Time of the start of the step, s.
    time: f64,
    constants: &'a Constants,
    /// Linear part of the source voltage, V.
    voltage: Line,
    /// Quadratic coefficient of the source voltage over the step, V/s2: the product of duty and supply voltage, both linear.
    voltage_bend: f64,
    /// Imposed current, A.
    current: Line,
    /// Load torque on a free shaft, N.m.
    load: Line,
    /// Imposed speed, rad/s.
    speed: Line,
    /// Heat flow into the winding that no current causes, W.
    heat: Line,
    /// Electrical power that heats the stator, W (drive_mode power).
    stator: Line,
    /// Heat flow from the drive to ambient, W.
    drive: Line,
    /// True ambient temperature, K.
    ambient: Line,
    /// Ratio of the torque constant to its data sheet value at the same temperature: commutation and demagnetisation.
    strength: f64,
    /// Temperature of the conducting phases above the mean winding temperature, K.
    pub(super) excess: f64,
    /// State of each term's lag, in the unit of its driver.
    pub(super) lags: [Line; MOST_TERMS],
    /// The drive in drive_mode pwm.
    chopper: Chopper,
    /// Conductance of each node to its environment if the fan command is constant over the step, W/K.
    conductance: PerNode,
    /// Rotor and housing, if there is a network, else ambient.
    coupling: ThermalCoupling,
}

/// Thermal coupling of winding and core to the network, linear over a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ThermalCoupling {
    /// Conductances, W/K: from the winding to rotor and ambient together, from the core to the housing.
    pub conductance: PerNode,
    /// Temperature at the other end of the winding's conductance, K.
    pub winding: Line,
    /// Temperature at the other end of the core's conductance, K.
    pub core: Line,
    /// Temperature of the magnets, K.
    pub rotor: Line,
}

/// Voltages and torques at one instant.
#[derive(Clone, Copy, Debug)]
struct Ends {
    /// Voltage at the terminals, V.
    voltage: f64,
    /// Torque on the load, N.m.
    shaft_torque: f64,
    /// Drag torque, N.m.
    drag: f64,
    /// Bridge voltage drop, V.
    bridge: f64,
    /// Resistance, Ohm.
    r: f64,
    /// Torque constant, N.m/A.
    k: f64,
    /// Voltage drop between terminals and winding, V.
    lost: f64,
}

/// Evaluation of the equations at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Voltage at the terminals, V.
    pub voltage: f64,
    /// Input power at the terminals (drive_mode pwm: at the drive) and as heat, W.
    pub power_in: f64,
    /// Power loss of the drive, W.
    pub drive: f64,
    /// Drag torque, N.m.
    pub drag: f64,
    /// Torque on the load, N.m.
    pub shaft_torque: f64,
    /// Derivatives of current and speed.
    pub fast: Fast,
    /// Derivatives of the temperatures, K/s.
    pub warming: Temperatures,
    /// Heat flow from winding and core to their environment, and from the drive, W.
    pub to_ambient: f64,
    /// The energy balance without the network.
    pub ledger: Ledger,
}

impl<'a> Step<'a> {
    /// The equations of a motor with inputs that are linear from `time` on; `conductance` is that at the fan command,
    /// [`Parameters::to_ambient`]. They hold until the next event of the effects.
    #[inline(always)]
    pub fn new(
        model: &'a Parameters,
        constants: &'a Constants,
        inputs: &'a Inputs,
        slopes: &'a Inputs,
        conductance: PerNode,
        time: f64,
    ) -> Self {
        Step::of(model, constants, [inputs, slopes], conductance, time)
    }
}

impl<'a, const FORM: u8> Step<'a, FORM> {
    /// The equations of [`new`](Step::new); `FORM` as it applies.
    #[inline(always)]
    pub(super) fn of(
        model: &'a Parameters,
        constants: &'a Constants,
        [inputs, slopes]: [&'a Inputs; 2],
        conductance: PerNode,
        time: f64,
    ) -> Self {
        let none = Line { start: 0.0, slope: 0.0 };
        let zero = Inputs::zero();
        let (u, s) = (inputs, if Self::STILL { &zero } else { slopes });
        let voltage = match model.choices.drive_mode {
            DriveMode::Voltage => Line { start: u.voltage, slope: s.voltage },
            DriveMode::Pwm => {
                Line { start: u.duty * u.voltage, slope: s.duty * u.voltage + u.duty * s.voltage }
            }
            DriveMode::Current | DriveMode::Power => none,
        };
        let bends = !Self::PLAIN && model.choices.drive_mode == DriveMode::Pwm;
        let voltage_bend = if bends { s.duty * s.voltage } else { 0.0 };
        let current = match model.choices.drive_mode {
            DriveMode::Current => Line { start: u.current_command, slope: s.current_command },
            _ => none,
        };
        let mut heat = Line { start: u.heat_power + model.effects.winding_heat(), slope: s.heat_power };
        let (mut drive, mut stator) = (none, none);
        if model.choices.drive_mode == DriveMode::Power {
            let of = |fraction: f64| Line {
                start: fraction * u.electrical_power,
                slope: fraction * s.electrical_power,
            };
            drive = of(constants.lost);
            stator = of(constants.in_stator);
            heat.start += u.electrical_power - drive.start - stator.start;
            heat.slope += s.electrical_power - drive.slope - stator.slope;
        }
        let ambient = Line {
            start: u.ambient_temperature + constants.drift * time + model.effects.ambient_offset(),
            slope: s.ambient_temperature + constants.drift,
        };
        let free = constants.inverse_j != 0.0;
        Step {
            model,
            inputs,
            slopes,
            time,
            constants,
            voltage,
            voltage_bend,
            current,
            load: if free { Line { start: u.load_torque, slope: s.load_torque } } else { none },
            speed: if free { none } else { Line { start: u.imposed_speed, slope: s.imposed_speed } },
            heat,
            stator,
            drive,
            ambient,
            strength: constants.torque_factor * model.effects.torque_constant(time),
            excess: 0.0,
            lags: [none; MOST_TERMS],
            chopper: Chopper::new(model, !Self::PLAIN && constants.chops, inputs, slopes),
            conductance,
            coupling: ThermalCoupling { conductance, winding: ambient, core: ambient, rotor: none },
        }
    }

    /// Heat flows and conductances of the phases in a state `t` seconds after the start of the step.
    pub(super) fn phase_load(&self, t: f64, state: &State<NODES>) -> PhaseLoad {
        let (i, t_w) = (state.x[0], state.temperature[WINDING]);
        let (motor, ports) = (&self.model.motor, self.ports());
        let drivers = self.drivers(t, &state.x, &state.temperature);
        let square = (i * i + self.ripple_square(t)) * self.resistance_factor(&drivers);
        // The input heat_power is distributed evenly over the phases.
        let even = self.inputs.heat_power + self.slopes.heat_power * t;
        PhaseLoad {
            heat: motor.resistance(t_w) * square
                + self.lost_voltage(i, &drivers) * i
                + self.heat_at(t, state.x[1])
                - even,
            per_kelvin: motor.R_ref * motor.alpha * square,
            capacity: self.capacity().values[WINDING],
            conductance: self.constants.across * ports.winding_housing_conductance(t_w)
                + self.conductance_at(t).winding,
        }
    }

    /// Couples the equations to a network.
    #[inline]
    pub fn couple(&mut self, coupling: ThermalCoupling) {
        (self.conductance, self.coupling) = (coupling.conductance, coupling);
    }

    /// True ambient temperature at the start of the step, K.
    pub(super) fn ambient_at_start(&self) -> f64 {
        self.ambient.start
    }

    const PLAIN: bool = FORM != ALL;
    const STILL: bool = FORM == PLAIN_STILL;

    /// Value of a line `t` seconds after the start of the step.
    #[inline(always)]
    fn at(line: &Line, t: f64) -> f64 {
        if Self::STILL { line.start } else { line.at(t) }
    }

    #[inline(always)]
    fn has_network(&self) -> bool {
        matches!(FORM, ALL | PLAIN) && self.constants.has_network
    }

    fn is_free(&self) -> bool {
        self.constants.inverse_j != 0.0
    }

    fn is_voltage_driven(&self) -> bool {
        self.constants.inverse_l != 0.0
    }

    #[inline]
    fn ports(&self) -> Ports<'_> {
        let acts = self.constants.acts;
        Ports {
            effects: &self.model.effects,
            acts: if Self::PLAIN { acts.only(EffectPort::DragTorque) } else { acts },
        }
    }

    /// Drag torque, N.m; `k` is the torque constant.
    #[inline(always)]
    fn drag(&self, t: f64, x: &Fast, temperature: &Temperatures, k: f64, drivers: &Drivers) -> f64 {
        let effects = self.ports();
        let own = effects.drag_torque(x[1]);
        if Self::PLAIN {
            return own;
        }
        let own = own
            + effects.warm_drag(x[1], self.magnets(t, temperature))
            + effects.driven_drag(x[1], Driver::Speed, drivers);
        if self.is_free() {
            let load = self.load.at(t);
            own + effects.load_drag(x[1], load) * load
        } else {
            // Load-dependent friction is a fraction of the torque that remains after speed-dependent drag.
            let before = k * x[0] - own;
            let share = effects.load_drag(x[1], before);
            if share == 0.0 { own } else { own + before * (share / (1.0 + share)) }
        }
    }

    #[inline(always)]
    fn conductance_at(&self, t: f64) -> PerNode {
        if Self::PLAIN || self.slopes.fan_command == 0.0 || self.has_network() {
            self.conductance
        } else {
            self.model.to_ambient(self.inputs.fan_command + self.slopes.fan_command * t)
        }
    }

    /// Temperature of the magnets, K; that of the housing without a rotor node.
    #[inline(always)]
    fn magnets(&self, t: f64, temperature: &Temperatures) -> f64 {
        if self.has_network() { self.coupling.rotor.at(t) } else { temperature[CORE] }
    }

    /// Part of the drag power `drag`, W, that heats the core, W.
    #[inline(always)]
    fn drag_in_core(&self, w: f64, drag: f64) -> f64 {
        if !self.has_network() {
            drag
        } else if self.constants.iron_in_core {
            self.iron_drag(w) * w
        } else {
            0.0
        }
    }

    /// Drag power that does not heat the core, at the start of the step, W.
    pub fn drag_beyond(&self, x: &Fast, temperature: &Temperatures) -> f64 {
        let drag = self.instant(0.0, x, temperature).drag * x[1];
        drag - self.drag_in_core(x[1], drag)
    }

    /// Drag torque of the iron loss, N.m.
    #[inline]
    fn iron_drag(&self, w: f64) -> f64 {
        self.model.effects.iron_drag(w)
    }

    /// Torque of a load whose power is part of the input electrical_power, N.m.
    #[inline(always)]
    fn power_mode_torque(&self, w: f64) -> f64 {
        self.ports().power_mode_torque(w)
    }

    /// Heat flow into the winding that no current causes, at the speed `w`, W.
    #[inline(always)]
    fn heat_at(&self, t: f64, w: f64) -> f64 {
        let load = if Self::PLAIN { 0.0 } else { self.power_mode_torque(w) * w };
        Self::at(&self.heat, t) - load
    }

    /// Heat flows from the nodes to their environment, W.
    #[inline(always)]
    fn leaving(&self, t: f64, temperature: &Temperatures) -> PerNode {
        let conductance = self.conductance_at(t);
        let coupling = &self.coupling;
        let mut leaving = PerNode {
            winding: conductance.winding * (temperature[WINDING] - Self::at(&coupling.winding, t)),
            housing: conductance.housing * (temperature[CORE] - Self::at(&coupling.core, t)),
        };
        if !(Self::PLAIN || self.has_network()) {
            let (effects, t_h) = (self.ports(), temperature[CORE]);
            leaving.housing += self.curved(t_h, self.ambient.at(t)) - effects.housing_heat(t_h);
        }
        leaving
    }

    /// Heat flow from the housing at `t_h`, K, to ambient at `t_a` that no conductance describes, W, without a network.
    #[inline(always)]
    fn curved(&self, t_h: f64, t_a: f64) -> f64 {
        let effects = self.ports();
        effects.housing_to_ambient(t_h, t_a) + self.model.conductance.G_still * effects.still_air(t_h - t_a)
    }

    /// Voltages and torques at one instant.
    #[inline(always)]
    fn ends(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Ends {
        let (i, w) = (x[0], x[1]);
        let Instant { r, k, drag, lost } = self.instant(t, x, temperature);
        let bridge = self.bridge(i);
        let voltage = if self.is_voltage_driven() {
            self.source(t, k * w) - bridge - self.missed(t, i)
        } else {
            r * i + lost + k * w
        };
        let shaft_torque =
            if self.is_free() { self.load.at(t) } else { k * i - drag + self.power_mode_torque(w) };
        Ends { voltage, shaft_torque, drag, bridge, r, k, lost }
    }

    /// Input power at the terminals (drive_mode pwm: at the drive) and as heat, W.
    #[inline(always)]
    fn power_in(&self, t: f64, x: &Fast, ends: &Ends) -> f64 {
        let (i, w) = (x[0], x[1]);
        let (load, drive) = (self.power_mode_torque(w) * w, self.drive.at(t) + ends.bridge * i);
        ends.voltage * i + self.heat_at(t, w) + load + self.stator.at(t) + self.ripple_loss(t, ends.r) + drive
    }

    /// Evaluates the equations at one instant.
    pub fn point(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Point {
        use Account::*;
        let motor = &self.model.motor;
        let (i, w) = (x[0], x[1]);
        let (t_w, t_h) = (temperature[WINDING], temperature[CORE]);
        let ends = self.ends(t, x, temperature);
        let Ends { voltage, shaft_torque, drag, bridge, r, k, lost } = ends;
        let fast = self.fast_rates(t, x, temperature);
        let (heat, stator, load) = (self.heat_at(t, w), self.stator.at(t), self.power_mode_torque(w) * w);
        let (leaving, drive) = (self.leaving(t, temperature), self.drive.at(t) + bridge * i);
        let insulation = self.ports().winding_housing_resistance(t_w);
        let across = self.model.thermal.winding_to_housing(t_w, t_h) / insulation;

        let mut ledger = Ledger::default();
        ledger.transfer(Terminals, Winding, r * i * i);
        ledger.transfer(Terminals, Winding, lost * i);
        ledger.transfer(Terminals, Winding, heat + self.ripple_loss(t, r));
        ledger.transfer(Terminals, AirGap, k * w * i + load);
        let core = self.core();
        ledger.transfer(Terminals, core, stator);
        ledger.transfer(AirGap, core, self.drag_in_core(w, drag * w));
        ledger.transfer(AirGap, Shaft, shaft_torque * w);
        if self.is_voltage_driven() {
            ledger.transfer(Terminals, Magnetic, motor.L * i * fast[0]);
        }
        if self.is_free() {
            ledger.transfer(AirGap, Kinetic, motor.J * w * fast[1]);
        }
        ledger.transfer(Winding, core, across);
        if !self.has_network() {
            ledger.transfer(Winding, Ambient, leaving.winding);
            ledger.transfer(core, Ambient, leaving.housing);
        }
        ledger.transfer(Terminals, Ambient, drive);

        let warming = self.network_rates(t, temperature)
            + self.heat_rates(t, x, temperature).component_mul(&self.capacity().inverse);
        let to_ambient = self.outflow(t, temperature) + drive;
        let power_in = self.power_in(t, x, &ends);
        Point { voltage, power_in, drive, drag, shaft_torque, fast, warming, to_ambient, ledger }
    }

    /// The account of the core in the energy balance.
    fn core(&self) -> Account {
        if self.has_network() { Account::Stator } else { Account::Housing }
    }

    /// Derivatives of all states, for an integrator without operator splitting.
    ///
    /// `y` holds current, A, speed, rad/s, angle, rad, winding and housing temperature, K, and the energies
    /// supplied, delivered to the load and given to ambient, J.
    pub fn rates(&self, t: f64, y: &[f64; STATES]) -> [f64; STATES] {
        let x = Fast::new(y[0], y[1]);
        let temperature = Temperatures::new(y[3], y[4]);
        let p = self.point(t, &x, &temperature);
        [
            p.fast[0],
            p.fast[1],
            y[1],
            p.warming[0],
            p.warming[1],
            p.power_in,
            p.shaft_torque * y[1],
            p.to_ambient,
        ]
    }
}
