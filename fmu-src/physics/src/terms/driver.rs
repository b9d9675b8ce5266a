//! Ports and drivers of the terms: names, units, nominal values and present values.

use super::MOST_TERMS;
use crate::ports::ports;

macro_rules! named {
    ($(#[doc = $doc:literal])* pub enum $type:ident { $($(#[doc = $idoc:literal])* $item:ident = $name:expr),* $(,)? }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $type { $($(#[doc = $idoc])* $item),* }

        impl $type {
            /// All items, in order.
            pub const ALL: &'static [$type] = &[$($type::$item),*];

            /// Name in files.
            pub fn name(self) -> &'static str {
                match self { $($type::$item => $name),* }
            }

            /// The item with this name.
            pub fn by_name(name: &str) -> Option<$type> {
                Self::ALL.iter().copied().find(|item| item.name() == name)
            }
        }
    };
}

macro_rules! term_ports {
    (() $($(#[$doc:meta])* [$($port:ident $(as $term:ident $file:literal $unit:ident $(of $live:ident)?)?)?]
        $rule:ident $name:ident [$($d:ident : $number:ident)?]
        ($($argument:ident : $type:ty),*) -> $result:ty, derivative [$($slope:ident)?];)*) => {
        named! {
            /// Port of a term: `effects/generic_term.rs` describes the effect of its value there.
            pub enum Port {
                $($($(#[doc = $file] $term = $file,)?)?)*
            }
        }

        impl Port {
            /// Unit of a term's value at the port; 1 is a relative change.
            pub fn unit(self) -> declare::Unit {
                match self { $($($(Port::$term => declare::Unit::$unit,)?)?)* }
            }

            /// The driver that is always evaluated within a step; the others are constant over a step unless the port [is
            /// fast](Port::is_fast).
            pub fn live(self) -> Option<Driver> {
                match self { $($($($(Port::$term => Some(Driver::$live),)?)?)?)* _ => None }
            }
        }
    };
}

ports!(term_ports);

impl Port {
    /// Whether a term there changes the equations of current and speed. These follow it within milliseconds, so all drivers are
    /// evaluated within a step: with constant ones, the current at the end of a long step would belong to its middle.
    pub fn is_fast(self) -> bool {
        matches!(
            self,
            Port::DragTorque
                | Port::TerminalVoltage
                | Port::SeriesVoltage
                | Port::WindingResistance
                | Port::TorqueConstant
        )
    }

    /// The quantity that a term there changes, in reports: two ports may change the same one in different ways.
    pub fn quantity(self) -> &'static str {
        match self {
            Port::SeriesVoltage => Port::TerminalVoltage.name(),
            other => other.name(),
        }
    }

    /// Whether a term there changes only what a sensor indicates.
    pub fn is_reading(self) -> bool {
        matches!(self, Port::WindingSensor | Port::HousingSensor | Port::TorqueSensor)
    }
}

/// Declares the drivers: item of [`Driver`], field of [`Drivers`], which is also the name in files, unit and typical change.
macro_rules! drivers {
    ($($(#[doc = $doc:literal])* $driver:ident $field:ident: $unit:ident, $nominal:literal;)*) => {
        named! {
            /// Variable that a term depends on.
            pub enum Driver { $($(#[doc = $doc])* $driver = stringify!($field)),* }
        }

        impl Driver {
            /// Unit of the driver.
            pub fn unit(self) -> declare::Unit {
                match self { $(Driver::$driver => declare::Unit::$unit),* }
            }

            /// Typical change; scale of a lag state.
            pub fn nominal(self) -> f64 {
                match self { $(Driver::$driver => $nominal),* }
            }
        }

        /// The drivers at one instant, in the units of [`Driver`].
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct Drivers {
            $($(#[doc = $doc])* pub $field: f64,)*
            /// State of each term's lag, in the unit of its driver; 0 without a lag.
            pub lagged: [f64; MOST_TERMS],
        }

        impl Drivers {
            /// Mean of these drivers and `to`.
            pub fn middle(&self, to: &Drivers) -> Drivers {
                self.toward(to, 0.5)
            }

            /// The drivers this part of the way to `to`.
            pub fn toward(&self, to: &Drivers, part: f64) -> Drivers {
                let mix = |a: f64, b: f64| (1.0 - part) * a + part * b;
                let lagged = std::array::from_fn(|k| mix(self.lagged[k], to.lagged[k]));
                Drivers { $($field: mix(self.$field, to.$field),)* lagged }
            }

            /// The same with another value of one driver.
            pub fn with(mut self, driver: Driver, value: f64) -> Drivers {
                match driver { $(Driver::$driver => self.$field = value),* }
                self
            }

            /// Value of one driver.
            #[inline]
            pub fn of(&self, driver: Driver) -> f64 {
                match driver { $(Driver::$driver => self.$field),* }
            }
        }
    };
}

drivers! {
    /// Speed of the shaft, rad/s.
    Speed speed: RadianPerSecond, 100.0;
    /// Current in the winding, A.
    Current current: Ampere, 1.0;
    /// Torque on the load, N.m.
    LoadTorque load_torque: NewtonMetre, 0.1;
    /// True temperature of the winding, K.
    WindingTemperature winding_temperature: Kelvin, 100.0;
    /// True temperature of the housing, K.
    HousingTemperature housing_temperature: Kelvin, 100.0;
    /// True ambient temperature without the effect of terms, K.
    AmbientTemperature ambient_temperature: Kelvin, 10.0;
    /// Fan command, 0 to 1.
    FanCommand fan_command: One, 1.0;
    /// Time, s.
    Time time: Second, 1000.0;
    /// Heat in the winding, W: copper loss, and in drive_mode power the power that heats the winding; only with a lag.
    CopperLoss copper_loss: Watt, 10.0;
    /// Friction loss of all drags, W; only with a lag.
    FrictionLoss friction_loss: Watt, 1.0;
}

impl Driver {
    /// Whether it is a heat flow, which is available only after the terms are evaluated.
    pub fn is_heat(self) -> bool {
        matches!(self, Driver::CopperLoss | Driver::FrictionLoss)
    }

    /// Whether a power of the driver depends on its sign relative to the offset.
    pub fn has_sides(self) -> bool {
        !matches!(self, Driver::Speed | Driver::Current | Driver::LoadTorque)
    }
}
