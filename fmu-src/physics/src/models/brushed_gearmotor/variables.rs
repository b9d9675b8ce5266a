//! Inputs and outputs of the gearmotor. The parameters are declared with their components.

use super::nodes::{NODES, nodes};
use declare::{Group, Named, Unit, Variable, variables};

variables! {
    /// What the importer sets at every communication point.
    pub struct Inputs {
        /// Duty cycle: fraction of each switching period with the supply on, negative for reverse; 0: see drive.zero_duty
        duty: f64 = Variable::input(1, 0.0, Unit::One, -1.0, 1.0).saturates(),
        /// Voltage of the supply in front of the H-bridge
        supply_voltage: f64 = Variable::input(2, 12.0, Unit::Volt, 0.0, 1e4).nominal(12.0)
            .source("paper on the gearmotor 37D, section 2.5"),
        /// Load torque on the output shaft
        load_torque: f64 = Variable::input(3, 0.0, Unit::NewtonMetre, -1e6, 1e6).nominal(0.1),
        /// Indicated ambient temperature around the box; initial temperature of the nodes for which initial.* gives none
        ambient_temperature: f64 = Variable::input(4, 293.15, Unit::Kelvin, 173.15, 473.15).nominal(300.0)
            .source("paper on the gearmotor 37D: 20 degC"),
    }
}

macro_rules! outputs {
    ($(#[doc = $of:literal] $node:ident $name:ident {
        $(optional $capacity:ident $switch:literal part_of $whole:ident $of_whole:literal,)?
        output $output:literal, $($rest:tt)*
    })*) => {
        variables! {
            /// What the model computes. Voltages, currents and powers are means over a switching cycle.
            pub struct Outputs {
                /// Mean voltage at the motor's terminals
                voltage: f64 = Variable::output(20, Unit::Volt).nominal(12.0),
                /// Mean current in the winding
                current: f64 = Variable::output(21, Unit::Ampere),
                /// Angle of the output shaft, initial.shaft_angle at the start
                shaft_angle: f64 = Variable::output(22, Unit::Radian).unbounded().nominal(100.0),
                /// Speed of the output shaft
                shaft_speed: f64 = Variable::output(23, Unit::RadianPerSecond).nominal(10.0),
                /// Indicated torque of the output shaft on the load (effect torque_sensor_offset)
                shaft_torque: f64 = Variable::output(24, Unit::NewtonMetre),
                $(#[doc = concat!(" Temperature of", $of $(, "; that of", $of_whole, " without ", $switch)?)]
                $name: f64 = Variable::output($output, Unit::Kelvin).nominal(300.0),)*
                /// Voltage across the winding's resistance and the contacts: R I and contact voltage drop
                voltage_electrical: f64 = Variable::output(30, Unit::Volt),
                /// Inductive voltage L dI/dt
                voltage_magnetic: f64 = Variable::output(31, Unit::Volt),
                /// Back-EMF: torque constant times gear ratio times speed of the output shaft
                voltage_mechanical: f64 = Variable::output(32, Unit::Volt).nominal(10.0),
                /// Sum of the three voltages: terminal voltage
                voltage_total: f64 = Variable::output(33, Unit::Volt).nominal(12.0),
                /// Losses in the winding: voltage_electrical times current, and ripple loss R (mean(i^2) - I^2)
                power_electrical: f64 = Variable::output(34, Unit::Watt),
                /// Power into the magnetic field: voltage_magnetic times current
                power_magnetic: f64 = Variable::output(35, Unit::Watt),
                /// Air-gap power: voltage_mechanical times current, friction losses included
                power_mechanical: f64 = Variable::output(36, Unit::Watt),
                /// Sum of the three powers: electrical power at the terminals
                power_total: f64 = Variable::output(37, Unit::Watt),
                /// Integral of power_electrical since the start
                work_electrical: f64 = Variable::output(38, Unit::Joule).unbounded().nominal(100.0),
                /// Integral of power_magnetic since the start: change of L I^2/2
                work_magnetic: f64 = Variable::output(39, Unit::Joule).unbounded().nominal(1e-4),
                /// Integral of power_mechanical since the start
                work_mechanical: f64 = Variable::output(40, Unit::Joule).unbounded().nominal(1000.0),
                /// Sum of the three works
                work_total: f64 = Variable::output(41, Unit::Joule).unbounded().nominal(1000.0),
                /// Power balance residual
                power_balance_error: f64 = Variable::output(42, Unit::Watt),
                /// Energy balance residual since the start
                energy_balance_error: f64 = Variable::output(43, Unit::Joule),
                /// Power from the supply
                supply_power: f64 = Variable::output(44, Unit::Watt),
                /// Mechanical power to the load
                shaft_power: f64 = Variable::output(45, Unit::Watt),
                /// Electrical losses in the winding, ripple loss and contact voltage drop included
                loss_copper: f64 = Variable::output(46, Unit::Watt),
                /// Friction losses of motor and gear, which heat housing and gear
                loss_friction: f64 = Variable::output(47, Unit::Watt),
                /// Losses of the H-bridge, which go to ambient
                loss_drive: f64 = Variable::output(48, Unit::Watt),
                /// Heat flow to ambient, losses of the H-bridge included
                heat_to_ambient: f64 = Variable::output(49, Unit::Watt),
                /// Energy from the supply since the start
                energy_supply: f64 = Variable::output(50, Unit::Joule).unbounded().nominal(1000.0),
                /// Mechanical energy to the load since the start
                energy_shaft: f64 = Variable::output(51, Unit::Joule).unbounded().nominal(1000.0),
                /// Heat to ambient since the start
                energy_heat_to_ambient: f64 = Variable::output(52, Unit::Joule).unbounded().nominal(1000.0),
                /// Margin of the winding to its temperature limit thermal.T_w_max
                winding_margin: f64 = Variable::output(53, Unit::Kelvin).nominal(100.0).difference(),
                /// True while the winding is above thermal.T_w_max
                over_temperature: bool = Variable::flag(54),
                /// Resistance of the winding at its temperature
                winding_resistance: f64 = Variable::output(55, Unit::Ohm).nominal(10.0),
                /// Torque constant at the output shaft: air-gap torque times ratio over current
                torque_constant: f64 = Variable::output(56, Unit::NewtonMetrePerAmpere),
                /// Fraction of each switching period with current in the winding; 1 in continuous conduction
                conduction: f64 = Variable::output(57, Unit::One),
                /// Root mean square of the current, ripple included
                current_rms: f64 = Variable::output(58, Unit::Ampere),
            }
        }

        impl Outputs {
            /// The node whose temperature an output is.
            #[inline(always)]
            pub(super) fn node(output: <Outputs as Named>::Row) -> Option<usize> {
                type Output = <Outputs as Named>::Row;
                match output {
                    $(Output::$name => Some(super::nodes::$node),)*
                    _ => None,
                }
            }

            /// These temperatures of the nodes, K; the other outputs are 0.
            pub(super) fn of_nodes([$($name),*]: [f64; NODES]) -> Outputs {
                Outputs { $($name,)* ..Outputs::zero() }
            }
        }
    };
}
nodes!(outputs);

variables! {
    /// Residuals that pass through zero at an event, for those who integrate the model themselves.
    pub struct Indicators {
        /// Excess of the winding over thermal.T_w_max
        over_temperature: f64 = Variable::local(901, Unit::Kelvin).nominal(100.0).difference(),
        /// Duty cycle, whose sign is the direction of the bridge
        bridge_direction: f64 = Variable::local(902, Unit::One),
        /// Largest excess of a temperature over its limit of validity (validity.*); the simulation ends at 0
        validity_limit: f64 = Variable::local(903, Unit::Kelvin).nominal(100.0).difference(),
    }
}
