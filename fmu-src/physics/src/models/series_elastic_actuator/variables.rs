//! Inputs, outputs, states and event indicators of the actuator. The parameters are declared with their components.

use declare::{State, Unit, Variable, states, variables};

variables! {
    /// Inputs.
    pub struct Inputs {
        /// Angle of the motor's shaft
        motor_angle: f64 = Variable::input(1, 0.0, Unit::Radian, -1e9, 1e9).nominal(100.0),
        /// Speed of the motor's shaft
        motor_speed: f64 = Variable::input(2, 0.0, Unit::RadianPerSecond, -1e6, 1e6).nominal(100.0),
        /// Current in the motor
        motor_current: f64 = Variable::input(3, 0.0, Unit::Ampere, -1e5, 1e5),
        /// Angle of the joint
        joint_angle: f64 = Variable::input(4, 0.0, Unit::Radian, -1e3, 1e3),
        /// Speed of the joint
        joint_speed: f64 = Variable::input(5, 0.0, Unit::RadianPerSecond, -1e4, 1e4),
        /// Torque demanded at the joint
        torque_demand: f64 = Variable::input(6, 0.0, Unit::NewtonMetre, -1e6, 1e6).nominal(100.0),
        /// Supply voltage of the drive
        supply_voltage: f64 = Variable::input(7, 48.0, Unit::Volt, 0.0, 1e4).nominal(48.0)
            .source("maxon datasheet 305015: nominal voltage"),
        /// Electrical power of the motor; used with drive.power_source motor_power
        motor_power: f64 = Variable::input(8, 0.0, Unit::Watt, -1e6, 1e6).nominal(100.0),
    }
}

variables! {
    /// Outputs.
    pub struct Outputs {
        /// Voltage commanded to the motor, limited to the supply voltage
        voltage: f64 = Variable::output(20, Unit::Volt).nominal(48.0),
        /// Current commanded to the motor, within the limits of current and supply
        current_command: f64 = Variable::output(21, Unit::Ampere).nominal(10.0),
        /// Torque that the transmission takes from the motor's shaft
        load_torque: f64 = Variable::output(22, Unit::NewtonMetre),
        /// Torque at the joint, parallel spring included
        joint_torque: f64 = Variable::output(23, Unit::NewtonMetre).nominal(100.0),
        /// Angle of the series spring's input minus joint angle, backlash included
        spring_deflection: f64 = Variable::output(24, Unit::Radian),
        /// Power taken from the supply: electrical power of the motor (drive.power_source) plus losses of the drive
        supply_power: f64 = Variable::output(25, Unit::Watt).nominal(100.0),
        /// Torque at the joint minus torque demanded
        torque_error: f64 = Variable::output(26, Unit::NewtonMetre),
        /// Mechanical power at the joint
        joint_power: f64 = Variable::output(27, Unit::Watt).nominal(100.0),
        /// Friction loss of the transmission and damping loss of coupling and spring
        loss_transmission: f64 = Variable::output(28, Unit::Watt),
        /// Power loss of the drive between supply and motor
        loss_drive: f64 = Variable::output(29, Unit::Watt),
        /// Energy taken from the motor's shaft since the start
        energy_shaft: f64 = Variable::output(30, Unit::Joule).unbounded().nominal(1000.0),
        /// Mechanical work at the joint since the start
        energy_joint: f64 = Variable::output(31, Unit::Joule).unbounded().nominal(1000.0),
        /// Energy dissipated in transmission and springs since the start
        energy_transmission: f64 = Variable::output(32, Unit::Joule).unbounded().nominal(1000.0),
        /// Energy taken from the supply since the start
        energy_supply: f64 = Variable::output(33, Unit::Joule).unbounded().nominal(1000.0),
    }
}

variables! {
    /// Balance residuals, which are computed on request only.
    pub struct Balance {
        /// Power balance residual
        power_balance_error: f64 = Variable::output(34, Unit::Watt),
        /// Energy balance residual since the start; zero to rounding where the input speeds are the derivatives of
        /// the input angles
        energy_balance_error: f64 = Variable::output(35, Unit::Joule),
    }
}

variables! {
    /// Event indicators of Model Exchange: residuals that pass through zero at an event.
    pub struct Indicators {
        /// Unlimited current command minus upper current limit
        current_above: f64 = Variable::local(901, Unit::Ampere).nominal(10.0),
        /// Unlimited current command minus lower current limit
        current_below: f64 = Variable::local(902, Unit::Ampere).nominal(10.0),
        /// Deflection of the series spring minus half of the backlash
        contact_above: f64 = Variable::local(903, Unit::Radian),
        /// Deflection of the series spring plus half of the backlash
        contact_below: f64 = Variable::local(904, Unit::Radian),
    }
}

// Nominal derivatives: demand / control.filter_time, voltage times control.current_bandwidth in rad/s, nominal speed for the twist,
// speed times control.natural_frequency in rad/s, and powers for the energies.
states! {
    /// The states, in the order of the rates.
    pub const LIST = {
        /// Filtered torque demand on the spring
        "state.demand" = State::new(701, 801, Unit::NewtonMetre).nominal(100.0, 5e4),
        /// Integral part of the current control
        "state.voltage" = State::new(702, 802, Unit::Volt).nominal(10.0, 3e3),
        /// Twist of the transmission's input shaft against the motor's, with an elastic coupling
        "state.coupling_twist" = State::new(703, 803, Unit::Radian).nominal(1.0, 100.0),
        /// Speed of the transmission's input shaft, with an elastic coupling
        "state.input_speed" = State::new(704, 804, Unit::RadianPerSecond).nominal(100.0, 3e4),
        /// Energy taken from the motor's shaft since the start
        "state.energy_shaft" = State::new(705, 805, Unit::Joule).unbounded().nominal(1000.0, 100.0),
        /// Mechanical work at the joint since the start
        "state.energy_joint" = State::new(706, 806, Unit::Joule).unbounded().nominal(1000.0, 100.0),
        /// Energy dissipated in transmission and springs since the start
        "state.energy_transmission" = State::new(707, 807, Unit::Joule).unbounded().nominal(1000.0, 100.0),
        /// Energy taken from the supply since the start
        "state.energy_supply" = State::new(708, 808, Unit::Joule).unbounded().nominal(1000.0, 100.0),
    }
}
