//! The units of the interface. All values are SI; a unit is a name with its dimension.

/// Exponents of the SI base units and the radian, as in FMI.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, non_snake_case)] // the field names are the units' own symbols
pub struct BaseUnits {
    pub kg: i8,
    pub m: i8,
    pub s: i8,
    pub A: i8,
    pub K: i8,
    pub mol: i8,
    pub cd: i8,
    pub rad: i8,
}

/// Display unit: `displayed value = factor * value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Name of the display unit, for example `degC`.
    pub name: &'static str,
    /// Factor on the SI value.
    pub factor: f64,
    /// Offset, added after the factor.
    pub offset: f64,
}

macro_rules! units {
    ($($(#[doc = $doc:literal])* $unit:ident = $name:literal $({ $($base:ident : $power:literal),* })?
       $(shown as $shown:literal, $factor:expr, $offset:expr)?;)*) => {
        /// Unit of a variable. The documentation of a variant is its meaning.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Unit { $($(#[doc = $doc])* $unit),* }

        impl Unit {
            /// All units, in the order of their declaration.
            pub const ALL: &'static [Unit] = &[$(Unit::$unit),*];

            /// The name of the unit in FMI.
            pub const fn name(self) -> &'static str {
                match self { $(Unit::$unit => $name),* }
            }

            /// The dimension, if its exponents are integers. Every unit is coherent SI: its factor is 1.
            pub const fn base(self) -> Option<BaseUnits> {
                let none = BaseUnits { kg: 0, m: 0, s: 0, A: 0, K: 0, mol: 0, cd: 0, rad: 0 };
                $($(if matches!(self, Unit::$unit) {
                    return Some(BaseUnits { $($base: $power,)* ..none });
                })?)*
                let _ = none;
                None
            }

            /// The display unit, if it differs from the SI unit.
            pub const fn display(self) -> Option<Display> {
                match self {
                    $($(Unit::$unit => Some(Display { name: $shown, factor: $factor, offset: $offset }),)?)*
                    #[allow(unreachable_patterns)]
                    _ => None,
                }
            }
        }
    };
}

impl Unit {
    /// A clause about a refused value of an absolute temperature, K, that may have been meant in degC: empty unless that is within the limits.
    pub fn celsius_clause(self, value: f64, limits: [f64; 2]) -> String {
        let [low, high] = limits;
        let kelvin = value - self.display().map_or(0.0, |celsius| celsius.offset);
        let may_be = self == Unit::Kelvin && (low..=high).contains(&kelvin);
        if may_be { format!("; {value} degC is within them") } else { String::new() }
    }

    /// The physical quantity, with the names of Modelica.Units.SI; `None` for a coefficient without such a name.
    pub const fn quantity(self) -> Option<&'static str> {
        Some(match self {
            Unit::Second => "Time",
            Unit::Hertz => "Frequency",
            Unit::Volt => "ElectricPotential",
            Unit::Ampere => "ElectricCurrent",
            Unit::Ohm => "Resistance",
            Unit::Henry => "Inductance",
            Unit::Kelvin => "ThermodynamicTemperature",
            Unit::PerKelvin => "LinearTemperatureCoefficient",
            Unit::Radian => "Angle",
            Unit::RadianPerSecond => "AngularVelocity",
            Unit::RadianPerSquareSecond => "AngularAcceleration",
            Unit::NewtonMetre => "Torque",
            Unit::NewtonMetrePerAmpere => "ElectricalTorqueConstant",
            Unit::NewtonMetrePerRadian => "RotationalSpringConstant",
            Unit::NewtonMetreSecond => "RotationalDampingConstant",
            Unit::KilogramSquareMetre => "MomentOfInertia",
            Unit::Kilogram => "Mass",
            Unit::Watt => "Power",
            Unit::Joule => "Energy",
            Unit::WattPerKelvin => "ThermalConductance",
            Unit::KelvinPerWatt => "ThermalResistance",
            Unit::KelvinPerSecond => "TemperatureSlope",
            Unit::JoulePerKelvin => "HeatCapacity",
            Unit::JoulePerKilogramKelvin => "SpecificHeatCapacity",
            Unit::WattPerMetreKelvin => "ThermalConductivity",
            Unit::WattPerSquareMetreKelvin => "CoefficientOfHeatTransfer",
            Unit::Metre => "Length",
            Unit::SquareMetre => "Area",
            Unit::CubicMetrePerSecond => "VolumeFlowRate",
            Unit::Pascal => "Pressure",
            Unit::KilogramPerCubicMetre => "Density",
            _ => return None,
        })
    }

    /// The unit of the derivative with respect to time.
    ///
    /// # Panics
    /// If no continuous state has this unit, at compile time.
    pub const fn rate(self) -> Unit {
        match self {
            Unit::Ampere => Unit::AmperePerSecond,
            Unit::RadianPerSecond => Unit::RadianPerSquareSecond,
            Unit::Radian => Unit::RadianPerSecond,
            Unit::Kelvin => Unit::KelvinPerSecond,
            Unit::Joule => Unit::Watt,
            Unit::NewtonMetre => Unit::NewtonMetrePerSecond,
            Unit::Volt => Unit::VoltPerSecond,
            Unit::One => Unit::Hertz,
            _ => panic!("no state has this unit"),
        }
    }
}

units! {
    /// Dimensionless.
    One = "1" {};
    /// Time.
    Second = "s" { s: 1 };
    /// Frequency.
    Hertz = "Hz" { s: -1 };
    /// Electric potential.
    Volt = "V" { kg: 1, m: 2, s: -3, A: -1 };
    /// Time derivative of a voltage.
    VoltPerSecond = "V/s" { kg: 1, m: 2, s: -4, A: -1 };
    /// Electric current.
    Ampere = "A" { A: 1 };
    /// Time derivative of a current.
    AmperePerSecond = "A/s" { A: 1, s: -1 };
    /// Electric resistance.
    Ohm = "Ohm" { kg: 1, m: 2, s: -3, A: -2 };
    /// Inductance.
    Henry = "H" { kg: 1, m: 2, s: -2, A: -2 };
    /// Temperature, displayed in degrees Celsius.
    Kelvin = "K" { K: 1 } shown as "degC", 1.0, -273.15;
    /// Temperature coefficient.
    PerKelvin = "1/K" { K: -1 };
    /// Angle.
    Radian = "rad" { rad: 1 };
    /// Angular velocity, displayed in revolutions per minute.
    RadianPerSecond = "rad/s" { rad: 1, s: -1 } shown as "rpm", 30.0 / std::f64::consts::PI, 0.0;
    /// Angular acceleration.
    RadianPerSquareSecond = "rad/s2" { rad: 1, s: -2 };
    /// Torque.
    NewtonMetre = "N.m" { kg: 1, m: 2, s: -2 };
    /// Torque constant, equal to the back-EMF constant in V.s/rad.
    NewtonMetrePerAmpere = "N.m/A" { kg: 1, m: 2, s: -2, A: -1 };
    /// Time derivative of a torque.
    NewtonMetrePerSecond = "N.m/s" { kg: 1, m: 2, s: -3 };
    /// Stiffness of a rotary spring.
    NewtonMetrePerRadian = "N.m/rad" { kg: 1, m: 2, s: -2, rad: -1 };
    /// Coefficient of a torque proportional to speed.
    NewtonMetreSecond = "N.m.s/rad" { kg: 1, m: 2, s: -1, rad: -1 };
    /// Coefficient of a torque proportional to the square root of speed; its exponents are not integers.
    NewtonMetreRootSecond = "N.m.s0.5/rad0.5";
    /// Coefficient of a torque proportional to the square of speed.
    NewtonMetreSquareSecond = "N.m.s2/rad2" { kg: 1, m: 2, rad: -2 };
    /// Torque per mass.
    NewtonMetrePerKilogram = "N.m/kg" { m: 2, s: -2 };
    /// Moment of inertia.
    KilogramSquareMetre = "kg.m2" { kg: 1, m: 2 };
    /// Mass.
    Kilogram = "kg" { kg: 1 };
    /// Power and heat flow.
    Watt = "W" { kg: 1, m: 2, s: -3 };
    /// Energy and work.
    Joule = "J" { kg: 1, m: 2, s: -2 };
    /// Thermal conductance.
    WattPerKelvin = "W/K" { kg: 1, m: 2, s: -3, K: -1 };
    /// Coefficient of thermal radiation.
    WattPerKelvin4 = "W/K4" { kg: 1, m: 2, s: -3, K: -4 };
    /// Time derivative of a temperature.
    KelvinPerSecond = "K/s" { K: 1, s: -1 };
    /// Thermal resistance.
    KelvinPerWatt = "K/W" { kg: -1, m: -2, s: 3, K: 1 };
    /// Heat capacity.
    JoulePerKelvin = "J/K" { kg: 1, m: 2, s: -2, K: -1 };
    /// Specific heat capacity.
    JoulePerKilogramKelvin = "J/(kg.K)" { m: 2, s: -2, K: -1 };
    /// Thermal conductivity.
    WattPerMetreKelvin = "W/(m.K)" { kg: 1, m: 1, s: -3, K: -1 };
    /// Heat transfer coefficient.
    WattPerSquareMetreKelvin = "W/(m2.K)" { kg: 1, s: -3, K: -1 };
    /// Length.
    Metre = "m" { m: 1 };
    /// Area.
    SquareMetre = "m2" { m: 2 };
    /// Volume flow rate.
    CubicMetrePerSecond = "m3/s" { m: 3, s: -1 };
    /// Pressure.
    Pascal = "Pa" { kg: 1, m: -1, s: -2 };
    /// Density.
    KilogramPerCubicMetre = "kg/m3" { kg: 1, m: -3 };
}

#[cfg(test)]
mod tests {
    use super::Unit;

    #[test]
    fn a_rate_is_per_second() {
        use Unit::{Ampere, Joule, Kelvin, NewtonMetre, One, Radian, RadianPerSecond, Volt};
        for unit in [Ampere, RadianPerSecond, Radian, Kelvin, Joule, NewtonMetre, Volt, One] {
            let (mut base, rate) = (unit.base().unwrap(), unit.rate().base().unwrap());
            base.s -= 1;
            assert_eq!(base, rate, "{unit:?}");
        }
    }
}
