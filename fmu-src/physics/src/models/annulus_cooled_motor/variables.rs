//! Inputs, outputs and choices of the motor. Parameters stand with their components.

use crate::components::commutation::Commutation;
use declare::{Group, Unit, Variable, enumeration, variables};

enumeration! {
    /// What drives the winding.
    pub enum DriveMode {
        /// The input voltage lies at the terminals.
        Voltage = 1, "voltage";
        /// The mean of a chopped supply, duty times voltage, lies at the terminals.
        Pwm = 2, "pwm";
        /// An ideal source drives current_command; its own voltage covers the inductance.
        Current = 3, "current";
        /// The input electrical_power heats the winding; no torque.
        Power = 4, "power";
    }
}

enumeration! {
    /// What the shaft is coupled to.
    pub enum MechanicalMode {
        /// The rotor accelerates under load_torque.
        FreeShaft = 1, "free_shaft";
        /// The shaft turns at imposed_speed; what imposes it also accelerates the rotor.
        ImposedSpeed = 2, "imposed_speed";
    }
}

enumeration! {
    /// How heat leaves the housing.
    pub enum CoolingMode {
        /// Through a conductance that the fan raises; winding and housing are the only nodes.
        Conductance = 1, "conductance";
        /// Natural convection and radiation in a still room.
        Bare = 2, "bare";
        /// A fan that blows across the motor.
        FanCrossflow = 3, "fan_crossflow";
        /// A fan that pushes air through a tube around the motor.
        AnnulusPush = 4, "annulus_push";
        /// A fan that pulls air through a tube around the motor.
        AnnulusPull = 5, "annulus_pull";
    }
}

variables! {
    /// Choices that hold for the whole run.
    pub struct Choices {
        /// What drives the winding
        drive_mode: DriveMode = Variable::choice(80, 1),
        /// What the shaft is coupled to
        mechanical_mode: MechanicalMode = Variable::choice(81, 1),
        /// How heat leaves the housing
        cooling_mode: CoolingMode = Variable::choice(82, 1),
        /// How current is given to the phases
        commutation: Commutation = Variable::choice(83, 1),
        /// Segments of the housing along its axis (not in cooling_mode conductance)
        air_segments: i32 = Variable::count(84, 8, 1, 64)
            .source("grid study: physics/tests/network.rs"),
    }
}

variables! {
    /// What the importer sets at every communication point.
    pub struct Inputs {
        /// Voltage at the terminals (drive_mode voltage) or of the supply (drive_mode pwm)
        voltage: f64 = Variable::input(1, 0.0, Unit::Volt, -1e4, 1e4).nominal(48.0),
        /// Current to be driven (drive_mode current)
        current_command: f64 = Variable::input(2, 0.0, Unit::Ampere, -1e4, 1e4).nominal(5.0),
        /// Share of the supply voltage, negative for reverse (drive_mode pwm)
        duty: f64 = Variable::input(3, 0.0, Unit::One, -1.0, 1.0),
        /// Torque that the load takes from the shaft (mechanical_mode free_shaft)
        load_torque: f64 = Variable::input(4, 0.0, Unit::NewtonMetre, -1e4, 1e4).nominal(0.1),
        /// Speed at which the shaft is turned (mechanical_mode imposed_speed)
        imposed_speed: f64 = Variable::input(5, 0.0, Unit::RadianPerSecond, -1e5, 1e5).nominal(1000.0),
        /// Command to the fan, 0 off, 1 full speed
        fan_command: f64 = Variable::input(6, 0.0, Unit::One, 0.0, 1.0),
        /// Temperature of the surroundings as shown; every node starts at the true one
        ambient_temperature: f64 = Variable::input(7, 298.15, Unit::Kelvin, 173.15, 473.15).nominal(300.0)
            .source("reference temperature of the maxon datasheet"),
        /// Pressure of the surrounding air (altitude); without effect in cooling_mode conductance
        ambient_pressure: f64 = Variable::input(8, 101_325.0, Unit::Pascal, 1e4, 2e5).nominal(1e5)
            .source("standard atmosphere, ISO 2533"),
        /// Electrical power that heats the winding, less what the drive loses (drive_mode power)
        electrical_power: f64 = Variable::input(9, 0.0, Unit::Watt, -1e6, 1e6).nominal(10.0),
        /// Further heat set free in the winding
        heat_power: f64 = Variable::input(10, 0.0, Unit::Watt, -1e6, 1e6).nominal(10.0),
    }
}

variables! {
    /// What the model shows of its state.
    pub struct Outputs {
        /// Current in the winding
        current: f64 = Variable::output(20, Unit::Ampere).nominal(5.0),
        /// Angle of the shaft since the start
        shaft_angle: f64 = Variable::output(21, Unit::Radian).nominal(100.0),
        /// Speed of the shaft
        shaft_speed: f64 = Variable::output(22, Unit::RadianPerSecond).nominal(1000.0),
        /// Torque that the shaft gives to the load (mechanical_mode imposed_speed: without the rotor's inertia)
        shaft_torque: f64 = Variable::output(23, Unit::NewtonMetre).nominal(0.1),
        /// Temperature of the winding as its sensor shows it (effects winding_sensor_*); the true one otherwise
        winding_temperature: f64 = Variable::output(24, Unit::Kelvin).nominal(300.0),
        /// Temperature of the stator; the housing's in cooling_mode conductance
        stator_temperature: f64 = Variable::output(25, Unit::Kelvin).nominal(300.0),
        /// Temperature of the magnets; the housing's in cooling_mode conductance
        magnet_temperature: f64 = Variable::output(26, Unit::Kelvin).nominal(300.0),
        /// Temperature of the housing as its sensor shows it (effects housing_sensor_*); the true one otherwise
        housing_temperature: f64 = Variable::output(27, Unit::Kelvin).nominal(300.0),
        /// Flow of air over the motor; 0 in cooling_mode conductance and bare
        air_flow_rate: f64 = Variable::output(29, Unit::CubicMetrePerSecond).nominal(1e-3),
        /// Pressure that the fan gives; 0 unless air is led through an annulus
        air_pressure_drop: f64 = Variable::output(30, Unit::Pascal).nominal(10.0),
        /// Resistance of the winding at its temperature
        winding_resistance: f64 = Variable::output(31, Unit::Ohm),
        /// Torque constant at the magnets' temperature
        torque_constant: f64 = Variable::output(32, Unit::NewtonMetrePerAmpere).nominal(0.03),
        /// How far the hottest phase of the winding truly is below its limit
        winding_margin: f64 = Variable::output(41, Unit::Kelvin).nominal(100.0).difference(),
        /// True while the hottest phase of the winding truly is above its limit
        over_temperature: bool = Variable::flag(42),
        /// Torque at the shaft per mass of the motor, with the fan and the tube where cooling_mode has them
        torque_density: f64 = Variable::output(43, Unit::NewtonMetrePerKilogram),
        /// Voltage at the terminals
        terminal_voltage: f64 = Variable::output(44, Unit::Volt).nominal(48.0),
        /// Temperature of the hottest phase, which differs from the mean winding at stall (commutation block or
        /// sinusoidal)
        winding_hot_spot_temperature: f64 = Variable::output(49, Unit::Kelvin).nominal(300.0),
    }
}

variables! {
    /// What the model shows of its flows of power, and the check of its books. It costs as much as a step, so that
    /// it is computed only where it is read.
    pub struct Books {
        /// Temperature of the air behind the motor; that of the surroundings where none is led past it
        air_outlet_temperature: f64 = Variable::output(28, Unit::Kelvin).nominal(300.0),
        /// Power taken at the terminals (drive_mode pwm: from the supply of the drive, with its losses)
        power_electrical: f64 = Variable::output(33, Unit::Watt).nominal(10.0),
        /// Power given to the load
        power_mechanical: f64 = Variable::output(34, Unit::Watt).nominal(10.0),
        /// Heat set free in the winding by its current: copper with ripple, and what contacts lose
        loss_copper: f64 = Variable::output(35, Unit::Watt).nominal(10.0),
        /// Share of loss_friction that is lost in the iron
        loss_iron: f64 = Variable::output(36, Unit::Watt).nominal(10.0),
        /// Power of all drags, which heats the housing
        loss_friction: f64 = Variable::output(37, Unit::Watt).nominal(10.0),
        /// Power lost in the drive, which heats the surroundings (drive_mode power or pwm)
        loss_drive: f64 = Variable::output(38, Unit::Watt).nominal(10.0),
        /// Heat flow to the surroundings, that of the drive included, without the power of the fan
        heat_to_ambient: f64 = Variable::output(39, Unit::Watt).nominal(10.0),
        /// Power that the books miss at this instant; zero but for rounding
        power_balance_error: f64 = Variable::output(40, Unit::Watt),
        /// Energy taken in since the start: at the terminals, and as heat_power
        energy_electrical: f64 = Variable::output(45, Unit::Joule).nominal(1000.0),
        /// Energy given to the load since the start
        energy_mechanical: f64 = Variable::output(46, Unit::Joule).nominal(1000.0),
        /// Heat given to the surroundings since the start, without the power of the fan
        energy_heat_to_ambient: f64 = Variable::output(47, Unit::Joule).nominal(1000.0),
        /// Energy taken in, less given out, less stored, since the start; zero but for rounding
        energy_balance_error: f64 = Variable::output(48, Unit::Joule),
    }
}

variables! {
    /// Residuals that pass through zero at an event, for those who integrate the model themselves.
    pub struct Indicators {
        /// How far the hottest phase of the winding truly is above its limit
        over_temperature: f64 = Variable::local(901, Unit::Kelvin).nominal(100.0).difference(),
        /// Residual that changes its sign with the sector of block commutation; 1 in any other commutation
        commutation_sector: f64 = Variable::local(902, Unit::One),
        /// Largest excess of a temperature over its limit of validity (validity.*); the simulation ends at 0
        validity_limit: f64 = Variable::local(903, Unit::Kelvin).nominal(100.0).difference(),
    }
}

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
        ambient_pressure: 0.0,
        electrical_power: 0.0,
        heat_power: 0.0,
    };

    /// The inputs after `t` seconds on these slopes.
    pub fn after(&self, t: f64, slopes: &Inputs) -> Inputs {
        let mut inputs = *self;
        for row in 0..Inputs::TABLE.len() {
            inputs.set(row, self.get(row) + slopes.get(row) * t);
        }
        inputs
    }
}
