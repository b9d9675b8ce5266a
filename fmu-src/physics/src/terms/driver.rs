//! Ports and drivers of the terms: names, units, nominal values and present values.

use super::MOST_TERMS;
use crate::ports::ports;

macro_rules! named {
    ($(#[doc = $doc:literal])* pub enum $type:ident { $($(#[doc = $idoc:literal])* $item:ident = $name:literal),* $(,)? }) => {
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

            /// The driver that is evaluated within a step; the others are constant over a step.
            pub fn live(self) -> Option<Driver> {
                match self { $($($($(Port::$term => Some(Driver::$live),)?)?)?)* _ => None }
            }
        }
    };
}

ports!(term_ports);

named! {
    /// Variable that a term depends on.
    pub enum Driver {
        /// Speed of the shaft, rad/s.
        Speed = "speed",
        /// Current in the winding, A.
        Current = "current",
        /// Torque on the load, N.m.
        LoadTorque = "load_torque",
        /// True temperature of the winding, K.
        WindingTemperature = "winding_temperature",
        /// True temperature of the housing, K.
        HousingTemperature = "housing_temperature",
        /// True ambient temperature without the effect of terms, K.
        AmbientTemperature = "ambient_temperature",
        /// Fan command, 0 to 1.
        FanCommand = "fan_command",
        /// Time, s.
        Time = "time",
        /// Heat in the winding, W: copper loss, and in drive_mode power the power that heats the winding; only with a lag.
        CopperLoss = "copper_loss",
        /// Friction loss of all drags, W; only with a lag.
        FrictionLoss = "friction_loss",
    }
}

impl Driver {
    /// Whether it is a heat flow, which is available only after the terms are evaluated.
    pub fn is_heat(self) -> bool {
        matches!(self, Driver::CopperLoss | Driver::FrictionLoss)
    }

    /// Unit of the driver.
    pub fn unit(self) -> declare::Unit {
        use declare::Unit::*;
        match self {
            Driver::Speed => RadianPerSecond,
            Driver::Current => Ampere,
            Driver::LoadTorque => NewtonMetre,
            Driver::WindingTemperature | Driver::HousingTemperature | Driver::AmbientTemperature => Kelvin,
            Driver::FanCommand => One,
            Driver::Time => Second,
            Driver::CopperLoss | Driver::FrictionLoss => Watt,
        }
    }

    /// Typical change; scale of a lag state.
    pub fn nominal(self) -> f64 {
        match self {
            Driver::Speed | Driver::WindingTemperature | Driver::HousingTemperature => 100.0,
            Driver::AmbientTemperature | Driver::CopperLoss => 10.0,
            Driver::Current | Driver::FanCommand | Driver::FrictionLoss => 1.0,
            Driver::LoadTorque => 0.1,
            Driver::Time => 1000.0,
        }
    }
}

/// The drivers at one instant, in the units of [`Driver`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(missing_docs)] // described in `Driver`
pub struct Drivers {
    pub speed: f64,
    pub current: f64,
    pub load_torque: f64,
    pub winding_temperature: f64,
    pub housing_temperature: f64,
    pub ambient_temperature: f64,
    pub fan_command: f64,
    pub time: f64,
    pub copper_loss: f64,
    pub friction_loss: f64,
    /// State of each term's lag, in the unit of its driver; 0 without a lag.
    pub lagged: [f64; MOST_TERMS],
}

impl Drivers {
    /// Mean of these drivers and `to`.
    pub fn middle(&self, to: &Drivers) -> Drivers {
        let mean = |of: fn(&Drivers) -> f64| 0.5 * (of(self) + of(to));
        Drivers {
            speed: mean(|d| d.speed),
            current: mean(|d| d.current),
            load_torque: mean(|d| d.load_torque),
            winding_temperature: mean(|d| d.winding_temperature),
            housing_temperature: mean(|d| d.housing_temperature),
            ambient_temperature: mean(|d| d.ambient_temperature),
            fan_command: mean(|d| d.fan_command),
            time: mean(|d| d.time),
            copper_loss: mean(|d| d.copper_loss),
            friction_loss: mean(|d| d.friction_loss),
            lagged: std::array::from_fn(|k| 0.5 * (self.lagged[k] + to.lagged[k])),
        }
    }

    /// The same with another value of one driver.
    pub fn with(mut self, driver: Driver, value: f64) -> Drivers {
        *self.place(driver) = value;
        self
    }

    fn place(&mut self, driver: Driver) -> &mut f64 {
        match driver {
            Driver::Speed => &mut self.speed,
            Driver::Current => &mut self.current,
            Driver::LoadTorque => &mut self.load_torque,
            Driver::WindingTemperature => &mut self.winding_temperature,
            Driver::HousingTemperature => &mut self.housing_temperature,
            Driver::AmbientTemperature => &mut self.ambient_temperature,
            Driver::FanCommand => &mut self.fan_command,
            Driver::Time => &mut self.time,
            Driver::CopperLoss => &mut self.copper_loss,
            Driver::FrictionLoss => &mut self.friction_loss,
        }
    }

    /// Value of one driver.
    #[inline]
    pub fn of(&self, driver: Driver) -> f64 {
        match driver {
            Driver::Speed => self.speed,
            Driver::Current => self.current,
            Driver::LoadTorque => self.load_torque,
            Driver::WindingTemperature => self.winding_temperature,
            Driver::HousingTemperature => self.housing_temperature,
            Driver::AmbientTemperature => self.ambient_temperature,
            Driver::FanCommand => self.fan_command,
            Driver::Time => self.time,
            Driver::CopperLoss => self.copper_loss,
            Driver::FrictionLoss => self.friction_loss,
        }
    }
}

impl Driver {
    /// Whether a power of the driver depends on its sign relative to the offset.
    pub fn has_sides(self) -> bool {
        !matches!(self, Driver::Speed | Driver::Current | Driver::LoadTorque)
    }
}
