//! Inputs, outputs, states and event indicators of the actuator. Parameters stand with their components.

use declare::{Group, State, Unit, Variable, states, variables};

variables! {
    /// What the importer sets at every communication point.
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
        /// Torque that the actuator shall give to the joint
        torque_demand: f64 = Variable::input(6, 0.0, Unit::NewtonMetre, -1e6, 1e6).nominal(100.0),
        /// Voltage of the supply in front of the drive
        supply_voltage: f64 = Variable::input(7, 48.0, Unit::Volt, 0.0, 1e4).nominal(48.0)
            .source("maxon datasheet 305015: nominal voltage"),
    }
}

/// Value reference of the first of the outputs that the books show.
const BOOKS: u32 = 34;

variables! {
    /// What the model computes.
    pub struct Outputs {
        /// Voltage for the motor, within the supply's
        voltage: f64 = Variable::output(20, Unit::Volt).nominal(48.0),
        /// Current that the control wants of the motor, within the limits
        current_command: f64 = Variable::output(21, Unit::Ampere).nominal(10.0),
        /// Torque that the transmission takes from the motor's shaft
        load_torque: f64 = Variable::output(22, Unit::NewtonMetre),
        /// Torque that the actuator gives to the joint, parallel spring included
        joint_torque: f64 = Variable::output(23, Unit::NewtonMetre).nominal(100.0),
        /// Angle of the series spring's input less that of the joint, play included
        spring_deflection: f64 = Variable::output(24, Unit::Radian),
        /// Power taken from the supply
        supply_power: f64 = Variable::output(25, Unit::Watt).nominal(100.0),
        /// Torque of the joint less the one demanded
        torque_error: f64 = Variable::output(26, Unit::NewtonMetre),
        /// Power given to the joint
        joint_power: f64 = Variable::output(27, Unit::Watt).nominal(100.0),
        /// Power that friction of the transmission and damping of coupling and spring turn into heat
        loss_transmission: f64 = Variable::output(28, Unit::Watt),
        /// Power lost between supply and motor
        loss_drive: f64 = Variable::output(29, Unit::Watt),
        /// Energy taken from the motor's shaft since the start
        energy_shaft: f64 = Variable::output(30, Unit::Joule).nominal(1000.0),
        /// Energy given to the joint since the start
        energy_joint: f64 = Variable::output(31, Unit::Joule).nominal(1000.0),
        /// Heat of transmission and springs since the start
        energy_transmission: f64 = Variable::output(32, Unit::Joule).nominal(1000.0),
        /// Energy taken from the supply since the start
        energy_supply: f64 = Variable::output(33, Unit::Joule).nominal(1000.0),
        /// Power that the books miss at this instant; zero but for rounding
        power_balance_error: f64 = Variable::output(BOOKS, Unit::Watt),
        /// Energy taken in, less given out, less stored, since the start; zero but for rounding where the angles
        /// that come in move with the speeds that come in
        energy_balance_error: f64 = Variable::output(35, Unit::Joule),
    }
}

/// The first of the outputs that the books show: they come last, and are not asked for at every step.
pub const LATE: usize = {
    let mut row = 0;
    while !matches!(<Outputs as Group>::TABLE[row].value_reference, BOOKS) {
        row += 1;
    }
    row
};

variables! {
    /// Residuals that pass through zero at an event, for those who integrate the model themselves.
    pub struct Indicators {
        /// How far the current wanted is above the greatest that is allowed
        current_above: f64 = Variable::local(901, Unit::Ampere).nominal(10.0),
        /// How far the current wanted is above the least that is allowed
        current_below: f64 = Variable::local(902, Unit::Ampere).nominal(10.0),
        /// Deflection of the series spring beyond half of the play
        contact_above: f64 = Variable::local(903, Unit::Radian),
        /// Deflection of the series spring above the other half of the play
        contact_below: f64 = Variable::local(904, Unit::Radian),
    }
}

states! {
    /// The states, in the order of the rates.
    pub const LIST = {
        /// Demand on the spring, filtered
        "state.demand" = State::new(701, 801, Unit::NewtonMetre).nominal(100.0),
        /// Voltage that the control adds until the current is the one wanted
        "state.voltage" = State::new(702, 802, Unit::Volt).nominal(10.0),
        /// Turn of the transmission's input shaft against the motor's, where the coupling gives
        "state.coupling_twist" = State::new(703, 803, Unit::Radian),
        /// Speed of the transmission's input shaft, where the coupling gives
        "state.input_speed" = State::new(704, 804, Unit::RadianPerSecond).nominal(100.0),
        /// Energy taken from the motor's shaft since the start
        "state.energy_shaft" = State::new(705, 805, Unit::Joule).nominal(1000.0),
        /// Energy given to the joint since the start
        "state.energy_joint" = State::new(706, 806, Unit::Joule).nominal(1000.0),
        /// Heat of transmission and springs since the start
        "state.energy_transmission" = State::new(707, 807, Unit::Joule).nominal(1000.0),
        /// Energy taken from the supply since the start
        "state.energy_supply" = State::new(708, 808, Unit::Joule).nominal(1000.0),
    }
}
