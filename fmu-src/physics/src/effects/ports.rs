//! Ports of a model: where effects act, and the interface of each.
//!
//! Each port is declared once, in [`ports!`]. The method of [`Effect`], the sum over all effects, the derivative and the activity
//! are generated from this declaration.

use super::candidate::Candidate;
use super::{Effects, NONE};
use crate::number::Number;
use crate::ports::ports;
use crate::terms::{Driver, Drivers, GenericTerm, Lag};
use declare::Group;
use nalgebra::Vector2;

/// A time event that is less than this ahead is due, s: equality of times within rounding.
pub const IMMINENT: f64 = 1e-9;

/// A pair of values that add up.
macro_rules! pair {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$doc:meta])* $field:ident),* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name { $($(#[$doc])* pub $field: f64),* }

        impl std::ops::Add for $name {
            type Output = $name;
            #[inline]
            fn add(self, other: $name) -> $name {
                $name { $($field: self.$field + other.$field),* }
            }
        }

        impl From<f64> for $name {
            #[inline]
            fn from(both: f64) -> $name {
                $name { $($field: both),* }
            }
        }
    };
}

pair! {
    /// A value for each thermal node that effects use.
    pub struct PerNode {
        /// Winding.
        winding,
        /// Housing.
        housing
    }
}

pair! {
    /// A stator between winding and housing; both values are positive, or both 0.
    pub struct Stator {
        /// Thermal resistance to the housing, K/W.
        resistance,
        /// Heat capacity, J/K.
        capacity
    }
}

/// Sum of all effects at a port where none acts.
macro_rules! inactive {
    (sum $arguments:tt) => { 0.0.into() };
    ($rule:ident $arguments:tt) => { neutral!($rule $arguments) };
}

macro_rules! define {
    (() $($(#[$doc:meta])* [$($port:ident $(as $term:ident $file:literal $unit:ident $(of $live:ident)?)?)?]
        $rule:ident $name:ident [$($d:ident : $number:ident)?]
        ($($argument:ident : $type:ty),*) -> $result:ty, derivative [$($slope:ident)?];)*) => {
        /// The ports of an effect. The default of each port is neutral.
        #[allow(unused_variables)]
        pub trait Effect: Group + Default {
            /// The candidate forms of the effect for `close-loop`; none where a bench cannot distinguish it from others.
            const CANDIDATES: &'static [Candidate];
            /// Values of the first parameters with the effect on, with a realistic size: for tests of all effects.
            const EXAMPLE: &'static [f64];

            /// The effect with the values of [`EXAMPLE`](Effect::EXAMPLE).
            fn example() -> Self {
                let mut effect = Self::default();
                Self::EXAMPLE.iter().enumerate().for_each(|(row, value)| assert!(effect.set(row, *value)));
                effect
            }

            /// Whether the effect is on: its first parameter, 0 by default, is not 0.
            #[inline]
            fn is_on(&self) -> bool {
                self.get(0) != 0.0
            }

            /// Replaces the effect's terms that are data; returns false and changes nothing if it has none or rejects
            /// these.
            fn take_terms(&mut self, terms: &[GenericTerm]) -> bool {
                false
            }

            /// Sets the drivers; an effect that depends on drivers holds them constant over a step. Returns whether this may change film
            /// coefficients, which are cached over many steps.
            #[inline]
            fn set_drivers(&mut self, drivers: &Drivers) -> bool {
                false
            }

            /// Whether what it holds constant over a step, as [`set_drivers`](Effect::set_drivers) set it, depends on this driver, or on
            /// its lag.
            fn holds(&self, driver: Driver) -> bool {
                false
            }

            /// Change, on the way from one set of drivers to another, of what the effect holds constant over a step, as a fraction of its range:
            /// a step with a great change is divided.
            fn change(&self, from: &Drivers, to: &Drivers) -> f64 {
                0.0
            }

            /// The lag of the `k`-th term that is data; its state is integrated by the model.
            #[inline]
            fn lag(&self, k: usize) -> Option<Lag> {
                None
            }

            $($(#[$doc])*
            #[inline]
            fn $name $(<$d: $number>)? (&self, $($argument: $type),*) -> $result {
                neutral!($rule ($($argument),*))
            })*
        }

        /// Where an effect acts: the ports of [`Effect`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum EffectPort {
            /// Any port: data decide where it acts, or the effect depends on drivers ([`set_drivers`](Effect::set_drivers)).
            Any,
            $($(#[doc = concat!("Port of [`", stringify!($name), "`](Effect::", stringify!($name), ").")] $port,)?)*
        }

        impl EffectPort {
            /// All ports except [`Any`](EffectPort::Any).
            pub const ALL: &'static [EffectPort] = &[$($(EffectPort::$port,)?)*];

            /// Whether an effect there gets the present drivers at every stage of a step: its method has an argument `drivers`.
            pub fn is_driven(self) -> bool {
                const ARGUMENTS: &[(&[EffectPort], &[&str])] =
                    &[$((&[$(EffectPort::$port)?], &[$(stringify!($argument)),*])),*];
                ARGUMENTS.iter().any(|(port, arguments)| port.contains(&self) && arguments.contains(&"drivers"))
            }
        }

        /// The ports at which any effect acts.
        #[derive(Clone, Copy, Debug)]
        pub struct Acts(u32);

        impl Acts {
            /// The ports at which these effects act.
            pub fn of(effects: &Effects) -> Acts {
                let bit = |port: EffectPort| u32::from(effects.acts_at(port)) << port as u32;
                Acts(EffectPort::ALL.iter().fold(0, |all, port| all | bit(*port)))
            }

            /// The same ports without one.
            pub fn without(self, port: EffectPort) -> Acts {
                Acts(self.0 & !(1 << port as u32))
            }

            /// This port alone, if any effect acts there.
            #[inline(always)]
            pub fn only(self, port: EffectPort) -> Acts {
                Acts(self.0 & 1 << port as u32)
            }

            /// Whether any effect acts at this port.
            #[inline(always)]
            pub fn at(self, port: EffectPort) -> bool {
                self.0 >> port as u32 & 1 != 0
            }
        }

        /// Effects as used in a step: ports where nothing acts are not evaluated.
        #[derive(Clone, Copy, Debug)]
        pub struct Ports<'a> {
            /// The effects.
            pub effects: &'a Effects,
            /// The ports at which they act.
            pub acts: Acts,
        }

        impl Ports<'_> {
            $(active! { [$($port)?] $rule $name ($($argument: $type),*) -> $result, derivative [$($slope)?] })*

            /// Reciprocal of the factor on the thermal resistance from winding to housing.
            #[inline]
            pub fn winding_housing_conductance(&self, t_w: f64) -> f64 {
                if self.acts.at(EffectPort::WindingHousingResistance) { 1.0 / self.winding_housing_resistance(t_w) } else { 1.0 }
            }
        }
    };
}

/// Number type of the methods of [`Ports`], which need no derivatives.
type D = f64;

/// A port that is evaluated only if an effect acts there, and its derivative.
macro_rules! active {
    ([] $($rest:tt)*) => {};
    ([$port:ident] $rule:ident $name:ident ($($argument:ident : $type:ty),*) -> $result:ty, derivative []) => {
        #[doc = concat!("[`", stringify!($name), "`](Effect::", stringify!($name), ").")]
        #[inline]
        pub fn $name(&self, $($argument: $type),*) -> $result {
            if self.acts.at(EffectPort::$port) { self.effects.$name($($argument),*) } else { inactive!($rule ($($argument),*)) }
        }
    };
    ([$port:ident] $rule:ident $name:ident ($($argument:ident : $type:ty),*) -> $result:ty, derivative [$slope:ident]) => {
        active! { [$port] $rule $name ($($argument: $type),*) -> $result, derivative [] }

        #[doc = concat!("Derivative of [`", stringify!($name), "`](Effect::", stringify!($name), ").")]
        #[inline]
        pub fn $slope(&self, $($argument: $type),*) -> f64 {
            if self.acts.at(EffectPort::$port) { self.effects.$slope($($argument),*) } else { 0.0 }
        }
    };
}

ports!(define);

/// Derivatives with respect to current and speed by the drivers alone.
#[derive(Clone, Copy, Debug)]
pub struct DrivenSlopes {
    /// Of the factor on the winding's resistance, 1/A and s/rad.
    pub resistance: Vector2<f64>,
    /// Of the voltage between terminals and winding, V/A and V.s/rad.
    pub voltage: Vector2<f64>,
    /// Of the factor on the torque constant, 1/A and s/rad.
    pub torque_constant: Vector2<f64>,
    /// Of the drag torque, N.m/A and N.m.s/rad.
    pub drag: Vector2<f64>,
}

impl Ports<'_> {
    /// The derivatives at these drivers; the load torque follows the current by `load_per_ampere`, N.m/A. Without them, an integrator would
    /// follow the changes in explicit steps, as short as L/R.
    #[inline(never)]
    pub fn driven_slopes(&self, drivers: &Drivers, load_per_ampere: f64) -> DrivenSlopes {
        let by_both = |of: &dyn Fn(f64, Driver) -> f64| {
            let by = |driver: Driver| of(drivers.of(driver), driver);
            let through_load =
                if load_per_ampere == 0.0 { 0.0 } else { load_per_ampere * by(Driver::LoadTorque) };
            Vector2::new(by(Driver::Current) + through_load, by(Driver::Speed))
        };
        DrivenSlopes {
            resistance: by_both(&|x, by| self.winding_resistance_slope(x, by, drivers)),
            voltage: by_both(&|x, by| {
                self.driven_voltage_slope(x, by, drivers) + self.series_voltage_slope(x, by, drivers)
            }),
            torque_constant: by_both(&|x, by| self.driven_torque_constant_slope(x, by, drivers)),
            drag: by_both(&|x, by| self.driven_drag_slope(x, by, drivers)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The driven ports are those whose methods have the drivers as an argument; data act at any.
    #[test]
    fn ports_with_drivers_are_driven() {
        let driven: Vec<EffectPort> =
            EffectPort::ALL.iter().copied().filter(|port| port.is_driven()).collect();
        assert_eq!(
            driven,
            [
                EffectPort::DrivenDrag,
                EffectPort::DrivenVoltage,
                EffectPort::SeriesVoltage,
                EffectPort::WindingResistance,
                EffectPort::DrivenTorqueConstant
            ]
        );
    }
}
