//! List of the effects, one line each. An effect acts at a port of the model, satisfies the energy balance, and is off by default.
//!
//! A port is a line of `ports.rs`. The model's equations use ports only, and enter each power flow with source and sink in the ledger.

/// Implements [`Group`](declare::Group) for an effect with more fields than the group of its parameters.
macro_rules! parameters_of {
    ($effect:ident: $field:ident: $group:ident) => {
        impl declare::Group for $effect {
            const TABLE: &'static [Variable] = $group::TABLE;

            #[inline]
            fn get(&self, index: usize) -> f64 {
                self.$field.get(index)
            }

            #[inline]
            fn set(&mut self, index: usize, value: f64) -> bool {
                self.$field.set(index, value)
            }

            fn zero() -> Self {
                $effect { $field: $group::zero(), ..Default::default() }
            }
        }
    };
}

/// The neutral summand: x + -0.0 is x to the last bit for every x, so the compiler removes the addition from
/// the sum over all effects; x + 0.0 differs where x is -0.0.
const NONE: f64 = -0.0;

/// Value of an effect at a port at which it does not act.
macro_rules! neutral {
    (sum $arguments:tt) => {
        NONE.into()
    };
    (factor $arguments:tt) => {
        1.0.into()
    };
    (least $arguments:tt) => {
        f64::INFINITY
    };
    (chain ($first:ident $($rest:tt)*)) => {
        $first
    };
}

mod ambient_drift;
mod bridge_drop;
mod candidate;
mod contact_drop;
mod coulomb_friction;
mod dead_time;
mod demagnetisation;
mod drive_loss;
mod fan_back_pressure;
mod fan_exponent;
mod forced_convection;
mod generic_term;
mod housing_radiation;
mod housing_sensor_lag;
mod housing_sensor_offset;
mod housing_sensor_stem_loss;
mod interface_temperature;
mod iron_loss;
mod load_dependent_friction;
mod lubricant_friction;
mod natural_convection;
mod ports;
mod propeller_load;
mod pwm_ripple;
mod speed_convection;
mod stator_loss;
mod stator_node;
mod torque_sensor_offset;
mod viscous_friction;
mod windage;
mod winding_sensor_lag;
mod winding_sensor_offset;
mod winding_sensor_stem_loss;

pub use candidate::{Candidate, Follows, Way};
pub use forced_convection::{ConvectionDriver, CooledNode};

use crate::model::Unserved;
pub use crate::number::Number;
use crate::ports::ports;
use crate::terms::{Driver, Drivers, GenericTerm, Lag, MOST_TERMS};
use num_dual::Dual64;
pub use ports::{Acts, DrivenSlopes, Effect, EffectPort, IMMINENT, PerNode, Ports, Stator};

/// What the files of the effects use.
mod prelude {
    pub(super) use super::candidate::{Candidate, Follows, Way};
    pub(super) use super::ports::{Effect, IMMINENT, PerNode, Stator};
    pub(super) use crate::number::{Number, smooth_sign};
    pub(super) use crate::terms::{Driver, Drivers, Port};
    pub(super) use declare::{Unit, Variable, variables};
}

/// The derivative of a port with respect to its argument, at `x`.
#[inline]
fn slope(x: f64, port: impl Fn(Dual64) -> Dual64) -> f64 {
    port(Dual64::from(x).derivative()).eps
}

macro_rules! effects {
    ($($(#[doc = $doc:literal])* $id:ident : $type:ident @ $prefix:literal $base:literal at $port:ident;)*) => {
        $(pub use $id::$type;)*

        $crate::groups! {
            /// All effects of a model with their parameters.
            #[derive(Clone, Copy, Debug, Default, PartialEq)]
            pub struct Effects { $($(#[doc = $doc])* $id: $type = $prefix @ $base,)* }
        }

        impl Effects {
            /// The variables of effects at ports that a model does not support: `reason` says why, and what to use instead.
            pub fn unserved(reason: impl Fn(EffectPort) -> Option<&'static str>) -> Vec<Unserved> {
                let effects = [$(($prefix, EffectPort::$port)),*];
                let unserved = |(start, port)| reason(port).map(|reason| Unserved { start, reason });
                effects.into_iter().filter_map(unserved).collect()
            }

            /// Candidate forms of each effect for `close-loop`, by id.
            pub const CANDIDATES: &'static [(&'static str, &'static [Candidate])] =
                &[$((stringify!($id), <$type as Effect>::CANDIDATES)),*];

            /// Every effect on, each with a realistic size; without terms, which are data.
            pub fn examples() -> Effects {
                Effects { $($id: Effect::example()),* }
            }

            /// Whether any effect at `port` is on, so that a step can skip inactive ports. Inlined, so that for a constant port only its
            /// own effects are checked.
            #[inline(always)]
            pub fn acts_at(&self, port: EffectPort) -> bool {
                false $(|| (matches!(EffectPort::$port, p if p == port || p == EffectPort::Any) && self.$id.is_on()))*
            }

            /// Whether any effect is on.
            pub fn is_on(&self) -> bool {
                false $(|| self.$id.is_on())*
            }

            /// Passes the terms to the effect that evaluates them; false if it rejects them.
            pub fn take_terms(&mut self, terms: &[GenericTerm]) -> bool {
                false $(| self.$id.take_terms(terms))*
            }

            /// Sets the drivers of all effects ([`Effect::set_drivers`]).
            #[inline]
            pub fn set_drivers(&mut self, drivers: &Drivers) -> bool {
                false $(| self.$id.set_drivers(drivers))*
            }

            /// Whether any effect holds this driver constant over a step ([`Effect::holds`]).
            pub fn holds(&self, driver: Driver) -> bool {
                false $(|| self.$id.holds(driver))*
            }

            /// Greatest change of what an effect holds constant over a step ([`Effect::change`]).
            pub fn change(&self, from: &Drivers, to: &Drivers) -> f64 {
                0.0_f64 $(.max(if self.$id.is_on() { self.$id.change(from, to) } else { 0.0 }))*
            }

            /// The lag of the `k`-th term that is data ([`Effect::lag`]).
            #[inline]
            pub fn lag(&self, k: usize) -> Option<Lag> {
                None $(.or_else(|| self.$id.lag(k)))*
            }
        }

        ports!(combine ($($id)*));
    };
}

/// The methods of [`Effects`]: combination of all effects at each port, and its derivative.
macro_rules! combine {
    (($effects:tt) $($(#[$doc:meta])* [$($port:ident $(as $term:ident $file:literal $unit:ident $(of $live:ident)?)?)?]
        $rule:ident $name:ident [$($d:ident : $number:ident)?]
        ($($argument:ident : $type:ty),*) -> $result:ty, derivative [$($slope:ident)?];)*) => {
        impl Effects {
            $(one! {
                $(#[$doc])* $rule $name [$($d: $number)?] ($($argument: $type),*) ($($argument),*) -> $result, $effects
            })*
            $(derivative! { [$($slope)?] $name ($($argument: $type),*) })*
        }
    };
}

/// Combination of all effects at one port; an effect that is off is not evaluated.
macro_rules! one {
    ($(#[$doc:meta])* $rule:ident $name:ident [$($d:ident : $number:ident)?]
        ($($argument:ident : $type:ty),*) $call:tt -> $result:ty, ($($id:ident)*)) => {
        $(#[$doc])*
        #[inline]
        pub fn $name $(<$d: $number>)? (&self, $($argument: $type),*) -> $result {
            add_up! { $rule $result, $($argument)*,
                ($(if self.$id.is_on() { self.$id.$name $call } else { neutral!($rule $call) }),*) }
        }
    };
}

/// The rules by which effects combine.
macro_rules! add_up {
    (sum $result:ty, $($argument:ident)*, ($($each:expr),*)) => { <$result>::from(0.0) $(+ $each)* };
    (factor $result:ty, $($argument:ident)*, ($($each:expr),*)) => { <$result>::from(1.0) $(* $each)* };
    (least $result:ty, $($argument:ident)*, ($($each:expr),*)) => { f64::INFINITY $(.min($each))* };
    (chain $result:ty, $first:ident $($argument:ident)*, ($($each:expr),*)) => {{ $(let $first = $each;)* $first }};
}

/// The derivative of a port with respect to its first argument.
macro_rules! derivative {
    ([] $($rest:tt)*) => {};
    ([$slope:ident] $name:ident ($first:ident : $first_type:ty $(, $argument:ident : $type:ty)*)) => {
        #[doc = concat!("Derivative of [`", stringify!($name), "`](Effect::", stringify!($name), ").")]
        #[inline]
        pub fn $slope(&self, $first: f64 $(, $argument: $type)*) -> f64 {
            slope($first, |$first| self.$name($first $(, $argument)*))
        }
    };
}

effects! {
    /// Dry friction of bearings and seals.
    coulomb_friction: CoulombFriction @ "effect.coulomb_friction." 1000 at DragTorque;
    /// Friction of lubricant, and eddy currents, which follow the same law.
    viscous_friction: ViscousFriction @ "effect.viscous_friction." 1010 at DragTorque;
    /// Friction of a lubricant that thins as it warms up.
    lubricant_friction: LubricantFriction @ "effect.lubricant_friction." 1280 at WarmDrag;
    /// Hysteresis and eddy currents in the stator's iron.
    iron_loss: IronLoss @ "effect.iron_loss." 1020 at DragTorque;
    /// Drag of the air on the rotor.
    windage: Windage @ "effect.windage." 1030 at DragTorque;
    /// Friction of gear and bearings under load.
    load_dependent_friction: LoadDependentFriction @ "effect.load_dependent_friction." 1040 at LoadDrag;
    /// Voltage drop of brushes or semiconductors.
    contact_drop: ContactDrop @ "effect.contact_drop." 1050 at TerminalVoltage;
    /// Radiation from the housing to ambient.
    housing_radiation: HousingRadiation @ "effect.housing_radiation." 1060 at HousingToAmbient;
    /// Conductance of still air that increases with the temperature rise.
    natural_convection: NaturalConvection @ "effect.natural_convection." 1270 at StillAir;
    /// Temperature-dependent resistance between winding and housing.
    interface_temperature: InterfaceTemperature @ "effect.interface_temperature." 1070 at WindingHousingResistance;
    /// Air flow over the housing or through the winding.
    forced_convection: ForcedConvection @ "effect.forced_convection." 1080 at AmbientConductance;
    /// Flow reduction of a fan by back pressure.
    fan_back_pressure: FanBackPressure @ "effect.fan_back_pressure." 1090 at FanFlow;
    /// Another exponent of the fan command.
    fan_exponent: FanExponent @ "effect.fan_exponent." 1290 at FanFlow;
    /// Partial loss of magnetisation.
    demagnetisation: Demagnetisation @ "effect.demagnetisation." 1100 at TorqueConstant;
    /// Drift of the ambient temperature sensor.
    ambient_drift: AmbientDrift @ "effect.ambient_drift." 1110 at AmbientSensor;
    /// Power loss of the drive.
    drive_loss: DriveLoss @ "effect.drive_loss." 1120 at DriveLoss;
    /// Stator with its own temperature.
    stator_node: StatorNode @ "effect.stator_node." 1180 at Stator;
    /// Copper loss of the current ripple from PWM.
    pwm_ripple: PwmRipple @ "effect.pwm_ripple." 1200 at Ripple;
    /// Voltage drop of the drive's H-bridge.
    bridge_drop: BridgeDrop @ "effect.bridge_drop." 1210 at Bridge;
    /// Dead time of the drive's bridge.
    dead_time: DeadTime @ "effect.dead_time." 1220 at Bridge;
    /// Convection of the housing that increases with the speed.
    speed_convection: SpeedConvection @ "effect.speed_convection." 1230 at Any;
    /// Losses in the stator instead of the winding.
    stator_loss: StatorLoss @ "effect.stator_loss." 1240 at StatorLoss;
    /// Shaft power of a propeller or fan.
    propeller_load: PropellerLoad @ "effect.propeller_load." 1250 at PowerModeLoad;
    /// Zero offset of the torque sensor.
    torque_sensor_offset: TorqueSensorOffset @ "effect.torque_sensor_offset." 1260 at TorqueSensor;
    // The order of the sensor effects matters: the stem loss is a fraction of the true rise over ambient.
    /// First-order lag of the housing temperature sensor.
    housing_sensor_lag: HousingSensorLag @ "effect.housing_sensor_lag." 1130 at SensorLag;
    /// First-order lag of the winding temperature sensor.
    winding_sensor_lag: WindingSensorLag @ "effect.winding_sensor_lag." 1300 at SensorLag;
    /// Stem conduction error of the winding temperature sensor.
    winding_sensor_stem_loss: WindingSensorStemLoss @ "effect.winding_sensor_stem_loss." 1140 at WindingSensor;
    /// Stem conduction error of the housing temperature sensor.
    housing_sensor_stem_loss: HousingSensorStemLoss @ "effect.housing_sensor_stem_loss." 1150 at HousingSensor;
    /// Constant offset of the winding temperature sensor.
    winding_sensor_offset: WindingSensorOffset @ "effect.winding_sensor_offset." 1160 at WindingSensor;
    /// Constant offset of the housing temperature sensor.
    housing_sensor_offset: HousingSensorOffset @ "effect.housing_sensor_offset." 1170 at HousingSensor;
    /// Terms found in data that no effect of the list covers.
    generic_term: GenericTerms @ "effect.generic_term." 1190 at Any;
}

impl Effects {
    /// Whether a term that is data has a lag, whose state the model integrates.
    #[inline]
    pub fn has_lags(&self) -> bool {
        (0..MOST_TERMS).any(|k| self.lag(k).is_some())
    }

    /// Whether any effect holds a driver constant over a step that follows the states; current and speed follow them unless they are
    /// imposed.
    pub fn holds_states(&self, is_current_free: bool, is_speed_free: bool) -> bool {
        let follows_states = |driver: &Driver| match driver {
            Driver::Current => is_current_free,
            Driver::Speed => is_speed_free,
            // At an imposed speed it follows from the current.
            Driver::LoadTorque => !is_speed_free,
            Driver::WindingTemperature
            | Driver::HousingTemperature
            | Driver::CopperLoss
            | Driver::FrictionLoss => true,
            Driver::AmbientTemperature | Driver::FanCommand | Driver::Time => false,
        };
        Driver::ALL.iter().any(|driver| follows_states(driver) && self.holds(*driver))
    }

    /// Factor on the heat capacities; 1 exactly where nothing acts on them.
    #[inline]
    pub fn capacity_factor(&self) -> f64 {
        if self.acts_at(EffectPort::HeatCapacity) { self.heat_capacity() } else { 1.0 }
    }

    /// Derivative of [`bridge_voltage`](Effect::bridge_voltage) and [`missed_voltage`](Effect::missed_voltage), Ohm.
    #[inline]
    pub fn drive_voltage_slope(&self, i: f64, supply: f64) -> f64 {
        slope(i, |i| self.bridge_voltage(i) + self.missed_voltage(i, supply))
    }
}

/// Helpers for the tests of the effects.
#[cfg(test)]
mod testing {
    use super::*;

    /// Asserts that the derivative of a port equals its difference quotient within `tolerance`.
    pub fn slope_is_derivative(port: impl Fn(Dual64) -> Dual64, at: &[f64], by: f64, tolerance: f64) {
        for &x in at {
            let exact = slope(x, &port);
            let value = |x: f64| port(Dual64::from(x)).re;
            let difference = (value(x + by) - value(x - by)) / (2.0 * by);
            assert!((exact - difference).abs() <= tolerance, "at {x}: {exact} and {difference}");
        }
    }
}
