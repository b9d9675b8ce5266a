//! Inputs and outputs of the motor.

use declare::{Group, Unit, Variable, enumeration, variables};

enumeration! {
    /// Quantity that is imposed at the terminals.
    pub enum DriveMode {
        /// Voltage: the input voltage is applied to the terminals.
        Voltage = 1, "voltage";
        /// PWM: the mean voltage, duty times voltage, is applied to the terminals.
        Pwm = 2, "pwm";
        /// Current: an ideal current source imposes current_command.
        Current = 3, "current";
        /// Power: the input electrical_power heats the winding; there is no torque.
        Power = 4, "power";
    }
}

enumeration! {
    /// Mechanical boundary condition of the shaft.
    pub enum MechanicalMode {
        /// Free shaft: the rotor accelerates under load_torque.
        FreeShaft = 1, "free_shaft";
        /// Imposed speed: the shaft turns at imposed_speed.
        ImposedSpeed = 2, "imposed_speed";
    }
}

variables! {
    /// What the importer sets at every communication point.
    pub struct Inputs {
        /// Voltage at the terminals (drive_mode voltage) or of the supply (drive_mode pwm)
        voltage: f64 = Variable::input(1, 0.0, Unit::Volt, -1e4, 1e4).nominal(48.0),
        /// Imposed current (drive_mode current)
        current_command: f64 = Variable::input(2, 0.0, Unit::Ampere, -1e4, 1e4).nominal(5.0),
        /// Duty cycle: mean terminal voltage over supply voltage, negative for reverse (drive_mode pwm); 0: see drive.zero_duty
        duty: f64 = Variable::input(3, 0.0, Unit::One, -1.0, 1.0).saturates(),
        /// Load torque on the shaft (mechanical_mode free_shaft)
        load_torque: f64 = Variable::input(4, 0.0, Unit::NewtonMetre, -1e4, 1e4).nominal(0.1),
        /// Imposed speed of the shaft (mechanical_mode imposed_speed)
        imposed_speed: f64 = Variable::input(5, 0.0, Unit::RadianPerSecond, -1e5, 1e5).nominal(1000.0),
        /// Fan command: speed over full speed
        fan_command: f64 = Variable::input(6, 0.0, Unit::One, 0.0, 1.0).saturates(),
        /// Indicated ambient temperature; initial temperature of the nodes for which initial.* gives none
        ambient_temperature: f64 = Variable::input(7, 298.15, Unit::Kelvin, 173.15, 473.15).nominal(300.0)
            .source("reference temperature of the maxon datasheet"),
        /// Ambient pressure; without effect in cooling_mode conductance
        ambient_pressure: f64 = Variable::input(8, 101_325.0, Unit::Pascal, 1e4, 2e5).nominal(1e5)
            .source("standard atmosphere, ISO 2533"),
        /// Electrical power that heats the winding, before the losses of the drive (drive_mode power)
        electrical_power: f64 = Variable::input(9, 0.0, Unit::Watt, -1e6, 1e6).nominal(10.0),
        /// Additional heat flow into the winding
        heat_power: f64 = Variable::input(10, 0.0, Unit::Watt, -1e6, 1e6).nominal(10.0),
        /// Temperature of the coolant at the inlet of the jacket (cooling_mode water_jacket)
        coolant_inlet_temperature: f64 = Variable::input(11, 298.15, Unit::Kelvin, 273.16, 373.15).nominal(300.0)
            .source("as the ambient temperature"),
        /// Volume flow rate of the coolant at the inlet of the jacket (cooling_mode water_jacket)
        coolant_flow_rate: f64 = Variable::input(12, 0.0, Unit::CubicMetrePerSecond, 0.0, 0.1).nominal(1e-5),
    }
}

variables! {
    /// What the model shows of its state.
    pub struct Outputs {
        /// Current in the winding
        current: f64 = Variable::output(20, Unit::Ampere).nominal(5.0),
        /// Angle of the shaft, initial.shaft_angle at the start
        shaft_angle: f64 = Variable::output(21, Unit::Radian).unbounded().nominal(100.0),
        /// Speed of the shaft
        shaft_speed: f64 = Variable::output(22, Unit::RadianPerSecond).nominal(1000.0),
        /// Indicated torque of the shaft on the load (effect torque_sensor_offset; mechanical_mode imposed_speed: without the rotor's
        /// inertia)
        shaft_torque: f64 = Variable::output(23, Unit::NewtonMetre).nominal(0.1),
        /// Indicated winding temperature (effects winding_sensor_*); true mean temperature without these effects
        winding_temperature: f64 = Variable::output(24, Unit::Kelvin).nominal(300.0),
        /// Temperature of the stator; equal to the housing's in cooling_mode conductance
        stator_temperature: f64 = Variable::output(25, Unit::Kelvin).nominal(300.0),
        /// Temperature of the magnets; equal to the housing's in cooling_mode conductance
        magnet_temperature: f64 = Variable::output(26, Unit::Kelvin).nominal(300.0),
        /// Indicated housing temperature (effects housing_sensor_*); true mean temperature without these effects
        housing_temperature: f64 = Variable::output(27, Unit::Kelvin).nominal(300.0),
        /// Resistance of the winding at its temperature
        winding_resistance: f64 = Variable::output(31, Unit::Ohm),
        /// Torque constant at the magnets' temperature
        torque_constant: f64 = Variable::output(32, Unit::NewtonMetrePerAmpere).nominal(0.03),
        /// Margin of the hottest phase to the winding's temperature limit thermal.T_w_max
        winding_margin: f64 = Variable::output(41, Unit::Kelvin).nominal(100.0).difference(),
        /// True while the hottest phase of the winding is above thermal.T_w_max
        over_temperature: bool = Variable::flag(42),
        /// Shaft torque over the mass of the motor and of the parts that its cooling mode adds
        torque_density: f64 = Variable::output(43, Unit::NewtonMetrePerKilogram),
        /// Voltage at the terminals
        terminal_voltage: f64 = Variable::output(44, Unit::Volt).nominal(48.0),
        /// Temperature of the hottest phase; above the mean of the winding at stall (commutation block or
        /// sinusoidal)
        winding_hot_spot_temperature: f64 = Variable::output(49, Unit::Kelvin).nominal(300.0),
    }
}

variables! {
    /// Flows of air, coolant and power, and the balance residuals. They need the full equations of the cooling, which take longer
    /// than a step, so that they are computed only when they are read.
    pub struct EnergyBalance {
        /// Temperature of the air behind the motor; ambient temperature without an air flow
        air_outlet_temperature: f64 = Variable::output(28, Unit::Kelvin).nominal(300.0),
        /// Volume flow rate of air over the motor, by fan and buoyancy; 0 in cooling modes without an air flow
        air_flow_rate: f64 = Variable::output(29, Unit::CubicMetrePerSecond).nominal(1e-3),
        /// Static pressure of the fan; 0 unless a fan drives air through an annulus
        air_pressure_drop: f64 = Variable::output(30, Unit::Pascal).nominal(10.0),
        /// Electrical power at the terminals (drive_mode pwm: at the supply of the drive, with its losses)
        power_electrical: f64 = Variable::output(33, Unit::Watt).nominal(10.0),
        /// Mechanical power to the load
        power_mechanical: f64 = Variable::output(34, Unit::Watt).nominal(10.0),
        /// Electrical losses in the winding: copper loss with ripple, and contact voltage drop
        loss_copper: f64 = Variable::output(35, Unit::Watt).nominal(10.0),
        /// Iron loss; part of loss_friction
        loss_iron: f64 = Variable::output(36, Unit::Watt).nominal(10.0),
        /// Friction, iron and windage losses: heat in housing, stator and rotor
        loss_friction: f64 = Variable::output(37, Unit::Watt).nominal(10.0),
        /// Losses of the drive, which go to ambient (drive_mode power or pwm)
        loss_drive: f64 = Variable::output(38, Unit::Watt).nominal(10.0),
        /// Heat flow to ambient and coolant, losses of the drive included, fan power excluded
        heat_to_ambient: f64 = Variable::output(39, Unit::Watt).nominal(10.0),
        /// Power balance residual
        power_balance_error: f64 = Variable::output(40, Unit::Watt),
        /// Energy supplied since the start: at the terminals, and as heat_power
        energy_electrical: f64 = Variable::output(45, Unit::Joule).unbounded().nominal(1000.0),
        /// Mechanical energy to the load since the start
        energy_mechanical: f64 = Variable::output(46, Unit::Joule).unbounded().nominal(1000.0),
        /// Heat to ambient and coolant since the start, fan power excluded
        energy_heat_to_ambient: f64 = Variable::output(47, Unit::Joule).unbounded().nominal(1000.0),
        /// Energy balance residual since the start
        energy_balance_error: f64 = Variable::output(48, Unit::Joule),
        /// Temperature of the coolant at the outlet of the jacket; inlet temperature in cooling modes without a coolant
        coolant_outlet_temperature: f64 = Variable::output(50, Unit::Kelvin).nominal(300.0),
        /// Pressure drop of the coolant in the jacket
        coolant_pressure_drop: f64 = Variable::output(51, Unit::Pascal).nominal(1000.0),
        /// Hydraulic power of the coolant's pump: pressure drop times volume flow rate
        pump_power: f64 = Variable::output(52, Unit::Watt).nominal(0.01),
        /// Heat flow from the housing to the coolant; part of heat_to_ambient
        heat_to_coolant: f64 = Variable::output(53, Unit::Watt).nominal(10.0),
    }
}

impl EnergyBalance {
    /// Outputs of the cooling in modes that do not compute them: temperatures are stated here, all else is 0.
    pub fn without_flow(inputs: &Inputs, ambient: f64) -> EnergyBalance {
        EnergyBalance {
            air_outlet_temperature: ambient,
            coolant_outlet_temperature: inputs.coolant_inlet_temperature,
            ..EnergyBalance::zero()
        }
    }
}

variables! {
    /// Residuals that pass through zero at an event, for those who integrate the model themselves.
    pub struct Indicators {
        /// Excess of the hottest phase of the winding over thermal.T_w_max
        over_temperature: f64 = Variable::local(901, Unit::Kelvin).nominal(100.0).difference(),
        /// Changes sign at each sector of block commutation; 1 in any other commutation
        commutation_sector: f64 = Variable::local(902, Unit::One),
        /// Largest excess of a temperature over its limit of validity (validity.*); the simulation ends at 0
        validity_limit: f64 = Variable::local(903, Unit::Kelvin).nominal(100.0).difference(),
    }
}
