//! Terms that are data: what an effect found in measurements says, where no effect of the list says it.
//!
//! y = c prod_i b_i^p_i,   b_i = (x_i - offset_i) / reference_i,   up to three drivers x_i      (1)
//! y = a table in one driver: linear between its points, held at its ends beyond            (2)
//!
//! A term is a port and one of these laws. What its value does at the port stands with the effect that carries
//! terms, `effects/generic_term.rs`; the file that brings terms into an FMU is the matter of the crate `terms`.
//! Speed, current and load torque count by their size, |b|^p, since a drag or a drop is the same either way. Temperatures, fan
//! command and time have a side: below their offset the power is that of |b| with the other sign, so that p = 1 is a line.
//! *Assumes* nothing: (1) and (2) are fits. *Range*: |p| up to [`GREATEST_EXPONENT`]; where p < 0, a base below
//! [`LEAST_BASE`] counts as that. *Neglects* history: a term knows the present alone.

use crate::number::Number;

/// Most terms that a model carries.
pub const MOST_TERMS: usize = 3;
/// Most drivers of a product.
pub const MOST_DRIVERS: usize = 3;
/// Most points of a table.
pub const MOST_POINTS: usize = 32;
/// Greatest exponent, either way.
pub const GREATEST_EXPONENT: f64 = 6.0;
/// A base with a negative exponent is not taken below this.
pub const LEAST_BASE: f64 = 1e-3;

macro_rules! named {
    ($(#[doc = $doc:literal])* pub enum $type:ident { $($(#[doc = $idoc:literal])* $item:ident = $name:literal),* $(,)? }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $type { $($(#[doc = $idoc])* $item),* }

        impl $type {
            /// All of them, in order.
            pub const ALL: &'static [$type] = &[$($type::$item),*];

            /// Its name in files.
            pub fn name(self) -> &'static str {
                match self { $($type::$item => $name),* }
            }

            /// The one of this name.
            pub fn by_name(name: &str) -> Option<$type> {
                Self::ALL.iter().copied().find(|item| item.name() == name)
            }
        }
    };
}

named! {
    /// Where a term acts.
    pub enum Port {
        /// Torque against the motion, N.m.
        DragTorque = "drag_torque",
        /// Volts lost between terminals and winding, V.
        TerminalVoltage = "terminal_voltage",
        /// Relative change of the winding's resistance.
        WindingResistance = "winding_resistance",
        /// Relative change of the torque constant.
        TorqueConstant = "torque_constant",
        /// Heat set free in the winding, W.
        WindingHeat = "winding_heat",
        /// Heat set free in the housing, W.
        HousingHeat = "housing_heat",
        /// Relative change of the resistance from winding to housing.
        WindingHousingResistance = "winding_housing_resistance",
        /// Further conductance from the housing to ambient, W/K.
        HousingAmbientConductance = "housing_ambient_conductance",
        /// Relative change of the heat capacities.
        HeatCapacity = "heat_capacity",
        /// Relative change of the command that the fan follows.
        FanFlow = "fan_flow",
        /// What the true ambient temperature is above the shown one, K.
        AmbientSensor = "ambient_sensor",
        /// What the winding's sensor shows too much, K.
        WindingSensor = "winding_sensor",
        /// What the housing's sensor shows too much, K.
        HousingSensor = "housing_sensor",
    }
}

impl Port {
    /// The unit of a value there.
    pub fn unit(self) -> declare::Unit {
        use declare::Unit::*;
        match self {
            Port::DragTorque => NewtonMetre,
            Port::TerminalVoltage => Volt,
            Port::WindingHeat | Port::HousingHeat => Watt,
            Port::HousingAmbientConductance => WattPerKelvin,
            Port::AmbientSensor | Port::WindingSensor | Port::HousingSensor => Kelvin,
            Port::WindingResistance
            | Port::TorqueConstant
            | Port::WindingHousingResistance
            | Port::HeatCapacity
            | Port::FanFlow => One,
        }
    }
}

named! {
    /// What a term depends on.
    pub enum Driver {
        /// Speed of the shaft, rad/s.
        Speed = "speed",
        /// Current in the winding, A.
        Current = "current",
        /// Torque given to the load, N.m.
        LoadTorque = "load_torque",
        /// True temperature of the winding, K.
        WindingTemperature = "winding_temperature",
        /// True temperature of the housing, K.
        HousingTemperature = "housing_temperature",
        /// True temperature of the surroundings, but for what terms add to it, K.
        AmbientTemperature = "ambient_temperature",
        /// Command to the fan, 0 to 1.
        FanCommand = "fan_command",
        /// Time, s.
        Time = "time",
    }
}

/// The drivers at one instant, in the units of [`Driver`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(missing_docs)] // each is explained in `Driver`
pub struct Drivers {
    pub speed: f64,
    pub current: f64,
    pub load_torque: f64,
    pub winding_temperature: f64,
    pub housing_temperature: f64,
    pub ambient_temperature: f64,
    pub fan_command: f64,
    pub time: f64,
}

impl Drivers {
    /// Half way from these to those.
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
        }
    }

    /// One of them.
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
        }
    }
}

/// One driver of eq. (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor {
    /// Which.
    pub driver: Driver,
    /// Subtracted from it first.
    pub offset: f64,
    /// Divides the difference, positive: the base of the power is a pure number.
    pub reference: f64,
    /// The power.
    pub exponent: f64,
}

impl Driver {
    /// Whether a power knows on which side of its offset the driver is.
    pub fn has_sides(self) -> bool {
        !matches!(self, Driver::Speed | Driver::Current | Driver::LoadTorque)
    }
}

impl Factor {
    /// The power at `x`.
    pub fn of<D: Number>(&self, x: D) -> D {
        let signed = (x - self.offset) / self.reference;
        let base = signed.abs();
        let power = self.power(base);
        if signed.re() < 0.0 && self.driver.has_sides() { -power } else { power }
    }

    fn power<D: Number>(&self, base: D) -> D {
        if self.exponent == 0.0 {
            D::from(1.0)
        } else if self.exponent < 0.0 && base.re() < LEAST_BASE {
            D::from(LEAST_BASE.powf(self.exponent))
        } else if base.re() == 0.0 {
            // A root's slope is infinite there, and what multiplies it at the ports is zero.
            D::from(0.0)
        } else {
            base.powf(self.exponent)
        }
    }
}

/// Eq. (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Product {
    /// The value where every base is 1, in the port's unit.
    pub coefficient: f64,
    /// The drivers; none for a constant.
    pub factors: [Option<Factor>; MOST_DRIVERS],
}

/// Eq. (2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// The driver.
    pub driver: Driver,
    count: usize,
    x: [f64; MOST_POINTS],
    y: [f64; MOST_POINTS],
}

impl Table {
    /// The table through these points; `None` unless there are 2 to [`MOST_POINTS`], finite, with x ascending.
    pub fn new(driver: Driver, x: &[f64], y: &[f64]) -> Option<Table> {
        let ascending = x.windows(2).all(|pair| pair[0] < pair[1]);
        let finite = x.iter().chain(y).all(|number| number.is_finite());
        if x.len() != y.len() || !(2..=MOST_POINTS).contains(&x.len()) || !ascending || !finite {
            return None;
        }
        let mut table = Table { driver, count: x.len(), x: [0.0; MOST_POINTS], y: [0.0; MOST_POINTS] };
        table.x[..x.len()].copy_from_slice(x);
        table.y[..y.len()].copy_from_slice(y);
        Some(table)
    }

    /// The points: x and y.
    pub fn points(&self) -> (&[f64], &[f64]) {
        (&self.x[..self.count], &self.y[..self.count])
    }

    /// The value at `at`, and whether that lies beyond the points, so that an end is held.
    pub fn at<D: Number>(&self, at: D) -> (D, bool) {
        let (x, y) = self.points();
        let last = self.count - 1;
        if at.re() < x[0] {
            (D::from(y[0]), true)
        } else if at.re() > x[last] {
            (D::from(y[last]), true)
        } else {
            let k = x[1..last].partition_point(|x| *x <= at.re());
            ((at - x[k]) * ((y[k + 1] - y[k]) / (x[k + 1] - x[k])) + y[k], false)
        }
    }
}

/// How a term follows its drivers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // a box would be an allocation for each copy of a model
pub enum Law {
    /// Eq. (1).
    Product(Product),
    /// Eq. (2).
    Table(Table),
}

/// A term: where it acts, and its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GenericTerm {
    /// Where.
    pub port: Port,
    /// How much.
    pub law: Law,
}

impl GenericTerm {
    /// The value, in the port's unit.
    pub fn value(&self, drivers: &Drivers) -> f64 {
        self.along(drivers, Driver::Speed, drivers.speed)
    }

    /// The value with one driver alive: `x` stands for `live`, and carries its derivative.
    #[inline]
    pub fn along<D: Number>(&self, drivers: &Drivers, live: Driver, x: D) -> D {
        let of = |driver: Driver| if driver == live { x } else { D::from(drivers.of(driver)) };
        match &self.law {
            Law::Product(product) => {
                let factors = product.factors.iter().flatten();
                factors
                    .fold(D::from(product.coefficient), |value, factor| value * factor.of(of(factor.driver)))
            }
            Law::Table(table) => table.at(of(table.driver)).0,
        }
    }

    /// Whether it follows this driver.
    pub fn follows(&self, driver: Driver) -> bool {
        match &self.law {
            Law::Product(product) => product.factors.iter().flatten().any(|f| f.driver == driver),
            Law::Table(table) => table.driver == driver,
        }
    }

    /// Whether the term is a table that is asked beyond its points.
    pub fn is_held(&self, drivers: &Drivers) -> bool {
        match &self.law {
            Law::Product(_) => false,
            Law::Table(table) => table.at(drivers.of(table.driver)).1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    fn factor(driver: Driver, reference: f64, offset: f64, exponent: f64) -> Option<Factor> {
        Some(Factor { driver, offset, reference, exponent })
    }

    fn product(coefficient: f64, factors: [Option<Factor>; 3]) -> GenericTerm {
        GenericTerm { port: Port::DragTorque, law: Law::Product(Product { coefficient, factors }) }
    }

    const AT: Drivers = Drivers {
        speed: -400.0,
        current: 5.0,
        load_torque: 0.1,
        winding_temperature: 400.0,
        housing_temperature: 350.0,
        ambient_temperature: 300.0,
        fan_command: 0.25,
        time: 60.0,
    };

    /// 2 |-400/100|^0.5 ((350 - 300)/10)^2 (0.25/1)^-1 = 2 * 2 * 25 * 4 = 400.
    #[test]
    fn a_product_by_hand() {
        let term = product(
            2.0,
            [
                factor(Driver::Speed, 100.0, 0.0, 0.5),
                factor(Driver::HousingTemperature, 10.0, 300.0, 2.0),
                factor(Driver::FanCommand, 1.0, 0.0, -1.0),
            ],
        );
        assert!((term.value(&AT) - 400.0).abs() < 1e-12);
        assert!(!term.is_held(&AT));
        assert_eq!(product(-3.0, [None; 3]).value(&AT), -3.0);
    }

    /// 3 K below its offset a line goes on below zero, and so does a root; a speed counts by its size.
    #[test]
    fn temperatures_have_sides() {
        let at = Drivers { ambient_temperature: 290.0, speed: -4.0, ..AT };
        let line = product(2.0, [factor(Driver::AmbientTemperature, 1.0, 293.0, 1.0), None, None]);
        assert_eq!(line.value(&at), -6.0);
        let root = product(2.0, [factor(Driver::AmbientTemperature, 3.0, 293.0, 0.5), None, None]);
        assert_eq!(root.value(&at), -2.0);
        let dual = line.along(&at, Driver::AmbientTemperature, Dual64::from(290.0).derivative());
        assert_eq!((dual.re, dual.eps), (-6.0, 2.0));
        assert_eq!(product(1.0, [factor(Driver::Speed, 1.0, 0.0, 1.0), None, None]).value(&at), 4.0);
    }

    #[test]
    fn at_zero_roots_vanish_and_reciprocals_are_bounded() {
        let still = Drivers { speed: 0.0, ..AT };
        assert_eq!(product(2.0, [factor(Driver::Speed, 100.0, 0.0, 0.5), None, None]).value(&still), 0.0);
        let reciprocal = product(2.0, [factor(Driver::Speed, 100.0, 0.0, -1.0), None, None]);
        assert!((reciprocal.value(&still) - 2000.0).abs() < 1e-9);
        let dual = reciprocal.along(&AT, Driver::Speed, Dual64::from(0.0).derivative());
        assert!(dual.re.is_finite() && dual.eps.is_finite());
    }

    #[test]
    fn a_table_is_linear_inside_and_held_outside() {
        let table =
            Table::new(Driver::WindingTemperature, &[300.0, 320.0, 400.0], &[1.0, 3.0, -1.0]).unwrap();
        for (at, value, held) in [
            (250.0, 1.0, true),
            (300.0, 1.0, false),
            (310.0, 2.0, false),
            (320.0, 3.0, false),
            (360.0, 1.0, false),
            (400.0, -1.0, false),
            (400.1, -1.0, true),
        ] {
            assert_eq!(table.at(at), (value, held), "at {at}");
        }
        let term = GenericTerm { port: Port::WindingHeat, law: Law::Table(table) };
        assert_eq!((term.value(&AT), term.is_held(&AT)), (-1.0, false));
        assert!(term.is_held(&Drivers { winding_temperature: 401.0, ..AT }));
        let dual = term.along(&AT, Driver::WindingTemperature, Dual64::from(350.0).derivative());
        assert_eq!((dual.re, dual.eps), (1.5, -0.05));
    }

    #[test]
    fn a_table_needs_two_to_thirty_two_ascending_finite_points() {
        let many: Vec<f64> = (0..40).map(f64::from).collect();
        let new = |x: &[f64], y: &[f64]| Table::new(Driver::Time, x, y);
        assert!(new(&many[..32], &many[..32]).is_some());
        assert!(new(&many[..33], &many[..33]).is_none());
        assert!(new(&[1.0], &[1.0]).is_none());
        assert!(new(&[1.0, 1.0], &[1.0, 2.0]).is_none());
        assert!(new(&[1.0, 2.0], &[1.0]).is_none());
        assert!(new(&[1.0, 2.0], &[1.0, f64::NAN]).is_none());
    }

    #[test]
    fn names_lead_back() {
        assert!(Port::ALL.iter().all(|port| Port::by_name(port.name()) == Some(*port)));
        assert!(Driver::ALL.iter().all(|driver| Driver::by_name(driver.name()) == Some(*driver)));
        assert_eq!((Port::ALL.len(), Port::by_name("nothing")), (13, None));
    }
}
