//! The ports of a model: where effects act, and what each may do there.
//!
//! Each port is declared once, in [`ports!`]. The method of [`Effect`], the sum over all effects, the derivative and the activity
//! are generated from this declaration.

use super::Effects;
use super::candidate::Candidate;
use crate::number::Number;
use crate::terms::{Driver, Drivers, GenericTerm, Lag};

/// An event that is less than this ahead has come, s: times that differ by rounding are the same.
pub const IMMINENT: f64 = 1e-9;

/// A value for each thermal node that effects know of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PerNode {
    /// That of the winding.
    pub winding: f64,
    /// That of the housing.
    pub housing: f64,
}

impl std::ops::Add for PerNode {
    type Output = PerNode;
    #[inline]
    fn add(self, other: PerNode) -> PerNode {
        PerNode { winding: self.winding + other.winding, housing: self.housing + other.housing }
    }
}

impl From<f64> for PerNode {
    #[inline]
    fn from(both: f64) -> PerNode {
        PerNode { winding: both, housing: both }
    }
}

/// A stator between winding and housing; both values are positive, or both 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stator {
    /// Thermal resistance to the housing, K/W.
    pub resistance: f64,
    /// Heat capacity, J/K.
    pub capacity: f64,
}

impl std::ops::Add for Stator {
    type Output = Stator;
    #[inline]
    fn add(self, other: Stator) -> Stator {
        Stator { resistance: self.resistance + other.resistance, capacity: self.capacity + other.capacity }
    }
}

impl From<f64> for Stator {
    #[inline]
    fn from(both: f64) -> Stator {
        Stator { resistance: both, capacity: both }
    }
}

/// The neutral summand: x + -0.0 is x to the last bit for every x, so that no addition remains of it in
/// the sum over all effects; x + 0.0 is not, where x is -0.0.
const NONE: f64 = -0.0;

/// Hands the list of the ports to the macro `$then`, with whatever follows its name. A line of the list is
///
/// ```text
/// [Port] rule method [D: Number] (arguments) -> result, derivative [method];
/// ```
///
/// `sum`, `factor`, `chain` (each effect gets the first argument from the one before) and `least` say how the effects combine. A
/// method without a port is a part of the port before it. A derivative is one with respect to the first argument.
macro_rules! ports {
    ($then:ident $($with:tt)*) => { $then! { ($($with)*)
        /// A torque against the motion at speed `w`, rad/s: N.m, of the sign of `w`. Its power heats the housing.
        [DragTorque] sum drag_torque [D: Number] (w: D) -> D, derivative [drag_torque_slope];
        /// The part of [`drag_torque`](Effect::drag_torque) that arises in the iron, N.m.
        [] sum iron_drag [] (w: f64) -> f64, derivative [];
        /// A torque against the motion for each newton metre that the shaft hands to its load: of the sign of `w`
        /// times that of the load's torque, which is about `tau`, N.m. Its power heats the housing.
        [LoadDrag] sum load_drag [D: Number] (w: D, tau: f64) -> D, derivative [load_drag_slope];
        /// Volts lost between the terminals and the winding at current `i`, A: of the sign of `i`. Their power heats
        /// the winding.
        [TerminalVoltage] sum terminal_voltage [D: Number] (i: D) -> D, derivative [terminal_voltage_slope];
        /// Volts lost in the drive's bridge at current `i`, A (drive_mode pwm): of the sign of `i`. Their power heats
        /// ambient.
        [Bridge] sum bridge_voltage [D: Number] (i: D) -> D, derivative [bridge_voltage_slope];
        /// Volts that the motor misses at current `i`, A, while the supply of `supply` volts gives as much less
        /// (drive_mode pwm): of the sign of `i`. No heat.
        [] sum missed_voltage [D: Number] (i: D, supply: f64) -> D, derivative [missed_voltage_slope];
        /// Mean square of the current's ripple, A2 (drive_mode pwm), which heats the winding.
        [Ripple] sum ripple_square [] (duty: f64, supply: f64, inductance: f64) -> f64, derivative [];
        /// Multiplies the winding's resistance; positive.
        [WindingResistance] factor winding_resistance [] () -> f64, derivative [];
        /// Heat set free in the winding beside that of its current, W.
        [WindingHeat] sum winding_heat [] () -> f64, derivative [];
        /// Multiplies every heat capacity; positive.
        [HeatCapacity] factor heat_capacity [] () -> f64, derivative [];
        /// Multiplies the torque constant at `time`, s. Over time alone it steps at [`next_event`](Effect::next_event) and only there.
        [TorqueConstant] factor torque_constant [] (time: f64) -> f64, derivative [];
        /// The first time after `time` at which a port jumps, s; infinite where none does.
        [] least next_event [] (time: f64) -> f64, derivative [];
        /// Multiplies the thermal resistance from winding to housing with the winding at `t_w`, K; positive.
        [WindingHousingResistance] factor winding_housing_resistance [D: Number] (t_w: D) -> D,
            derivative [winding_housing_resistance_slope];
        /// Further conductances to ambient, W/K, at the fan's `flow`, 0 to 1.
        [AmbientConductance] sum ambient_conductance [] (flow: f64) -> PerNode, derivative [];
        /// Heat flow from the housing at `t_h`, K, to ambient at `t_a` that follows no conductance, W.
        [HousingToAmbient] sum housing_to_ambient [D: Number] (t_h: D, t_a: f64) -> D,
            derivative [housing_to_ambient_slope];
        /// Heat set free in the housing at `t_h`, K, that ambient gives, W.
        [HousingHeat] sum housing_heat [D: Number] (t_h: D) -> D, derivative [housing_heat_slope];
        /// A stator between winding and housing.
        [Stator] sum stator [] () -> Stator, derivative [];
        /// The command that the fan really follows when it is given `n`, 0 to 1.
        [FanFlow] chain fan_flow [] (n: f64) -> f64, derivative [];
        /// How fast the true ambient temperature leaves the indicated one, K/s; they agree at time 0.
        [AmbientSensor] sum ambient_sensor [] () -> f64, derivative [];
        /// What the true ambient temperature is above the indicated one, beside its drift, K.
        [] sum ambient_offset [] () -> f64, derivative [];
        /// Time constant with which the sensor of the housing follows, s.
        [HousingSensorLag] sum housing_sensor_lag [] () -> f64, derivative [];
        /// What the sensor of the winding indicates at its temperature `t` with ambient at `t_a`, K.
        [WindingSensor] chain winding_sensor [] (t: f64, t_a: f64) -> f64, derivative [];
        /// What the sensor of the housing indicates at its temperature `t` (that it lags behind) with ambient at
        /// `t_a`, K.
        [HousingSensor] chain housing_sensor [] (t: f64, t_a: f64) -> f64, derivative [];
        /// Fraction of the input electrical_power that never reaches the winding and heats ambient.
        [DriveLoss] sum drive_loss [] () -> f64, derivative [];
    } };
}
pub(super) use ports;

/// What an effect gives at a port that it does not touch.
macro_rules! neutral {
    (sum $($argument:ident)*) => {
        NONE.into()
    };
    (factor $($argument:ident)*) => {
        1.0.into()
    };
    (least $($argument:ident)*) => {
        f64::INFINITY
    };
    (chain $first:ident $($argument:ident)*) => {
        $first
    };
}

/// What all effects together give at a port where none acts.
macro_rules! inactive {
    (sum $($argument:ident)*) => { 0.0.into() };
    ($($other:tt)*) => { neutral!($($other)*) };
}

macro_rules! define {
    (() $($(#[$doc:meta])* [$($port:ident)?] $rule:ident $name:ident [$($d:ident : $number:ident)?]
        ($($argument:ident : $type:ty),*) -> $result:ty, derivative [$($slope:ident)?];)*) => {
        /// What an effect may do, port by port. A port that an effect does not touch stays neutral.
        #[allow(unused_variables)]
        pub trait Effect: Sized {
            /// The forms in which close-loop looks for the effect; none where a bench cannot distinguish it from others.
            const CANDIDATES: &'static [Candidate];

            /// The effect switched on, of a size that a bench could have: for tests of all effects.
            fn example() -> Self;

            /// Whether its switch, the parameter that is 0 by default, is on.
            fn is_on(&self) -> bool;

            /// Takes terms that are data in place of those it had; false, and nothing taken, where it carries none or not
            /// these.
            fn take_terms(&mut self, terms: &[GenericTerm]) -> bool {
                false
            }

            /// Tells where the motor stands: what follows a driver slowly holds that over a step. Whether this may change what
            /// the air takes, which is kept over many steps.
            #[inline]
            fn tell(&mut self, drivers: &Drivers) -> bool {
                false
            }

            /// Whether it holds this driver over a step, as [`tell`](Effect::tell) told it.
            fn holds(&self, driver: Driver) -> bool {
                false
            }

            /// The lag of the `k`-th term that is data, whose state the model integrates.
            #[inline]
            fn lag(&self, k: usize) -> Option<Lag> {
                None
            }

            $($(#[$doc])*
            #[inline]
            fn $name $(<$d: $number>)? (&self, $($argument: $type),*) -> $result {
                neutral!($rule $($argument)*)
            })*
        }

        /// Where an effect acts: the ports of [`Effect`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Port {
            /// Any of them: what acts there is decided by data.
            Any,
            $($(#[doc = concat!("Port of [`", stringify!($name), "`](Effect::", stringify!($name), ").")] $port,)?)*
        }

        impl Port {
            /// All ports but [`Any`](Port::Any).
            pub const ALL: &'static [Port] = &[$($(Port::$port,)?)*];
        }

        /// The ports at which any effect acts.
        #[derive(Clone, Copy, Debug)]
        pub struct Acts(u32);

        impl Acts {
            /// Where these effects act.
            pub fn of(effects: &Effects) -> Acts {
                let bit = |port: Port| u32::from(effects.acts_at(port)) << port as u32;
                Acts(Port::ALL.iter().fold(0, |all, port| all | bit(*port)))
            }

            /// The same without one port.
            pub fn without(self, port: Port) -> Acts {
                Acts(self.0 & !(1 << port as u32))
            }

            /// Whether any effect acts at this port.
            #[inline(always)]
            pub fn at(self, port: Port) -> bool {
                self.0 >> port as u32 & 1 != 0
            }
        }

        /// The effects as a step sees them: ports where nothing acts are not evaluated.
        #[derive(Clone, Copy, Debug)]
        pub struct Ports<'a> {
            /// The effects.
            pub effects: &'a Effects,
            /// Where they act.
            pub acts: Acts,
        }

        impl Ports<'_> {
            $(active! { [$($port)?] $rule $name ($($argument: $type),*) -> $result, derivative [$($slope)?] })*

            /// The reciprocal of the factor on the resistance from winding to housing.
            #[inline]
            pub fn winding_housing_conductance(&self, t_w: f64) -> f64 {
                if self.acts.at(Port::WindingHousingResistance) { 1.0 / self.winding_housing_resistance(t_w) } else { 1.0 }
            }
        }
    };
}

/// The number of the methods of [`Ports`], which need no derivatives.
type D = f64;

/// A port that is evaluated where an effect acts, and its derivative.
macro_rules! active {
    ([] $($rest:tt)*) => {};
    ([$port:ident] $rule:ident $name:ident ($($argument:ident : $type:ty),*) -> $result:ty, derivative []) => {
        #[doc = concat!("[`", stringify!($name), "`](Effect::", stringify!($name), ").")]
        #[inline]
        pub fn $name(&self, $($argument: $type),*) -> $result {
            if self.acts.at(Port::$port) { self.effects.$name($($argument),*) } else { inactive!($rule $($argument)*) }
        }
    };
    ([$port:ident] $rule:ident $name:ident ($($argument:ident : $type:ty),*) -> $result:ty, derivative [$slope:ident]) => {
        active! { [$port] $rule $name ($($argument: $type),*) -> $result, derivative [] }

        #[doc = concat!("Derivative of [`", stringify!($name), "`](Effect::", stringify!($name), ").")]
        #[inline]
        pub fn $slope(&self, $($argument: $type),*) -> f64 {
            if self.acts.at(Port::$port) { self.effects.$slope($($argument),*) } else { 0.0 }
        }
    };
}

ports!(define);
