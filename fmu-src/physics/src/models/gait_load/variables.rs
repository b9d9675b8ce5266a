//! Inputs, outputs, states and event indicators of the gait. Parameters stand with `components/gait.rs`.

use declare::{State, Unit, Variable, states, variables};

variables! {
    /// What the importer sets at every communication point.
    pub struct Inputs {
        /// Torque that the actuator gives to the joint
        joint_torque: f64 = Variable::input(1, 0.0, Unit::NewtonMetre, -1e6, 1e6).nominal(100.0),
    }
}

variables! {
    /// What the model computes. Positive is extension, plantarflexion at the ankle.
    pub struct Outputs {
        /// Angle of the joint
        joint_angle: f64 = Variable::output(20, Unit::Radian),
        /// Speed of the joint
        joint_speed: f64 = Variable::output(21, Unit::RadianPerSecond),
        /// Torque that is asked of the actuator
        torque_demand: f64 = Variable::output(22, Unit::NewtonMetre).nominal(100.0),
        /// Share of the stride, from heel strike, that is over
        gait_phase: f64 = Variable::output(23, Unit::One),
        /// Torque that the actuator gives less the one asked for
        tracking_error: f64 = Variable::output(24, Unit::NewtonMetre),
        /// Power that is asked of the actuator; positive into the leg
        power_demand: f64 = Variable::output(25, Unit::Watt).nominal(100.0),
        /// Work that has been asked of the actuator since the start
        energy_demand: f64 = Variable::output(26, Unit::Joule).nominal(1000.0),
        /// Whole strides since the start
        strides: f64 = Variable::output(27, Unit::One),
    }
}

variables! {
    /// Residuals that pass through zero at an event, for those who integrate the model themselves.
    pub struct Indicators {
        /// Sine of half the turn of the stride: zero at each heel strike
        heel_strike: f64 = Variable::local(901, Unit::One),
    }
}

states! {
    /// The states, in the order of the rates.
    pub const LIST = {
        /// Strides since the start, with the share of the present one
        "state.stride" = State::new(701, 801, Unit::One),
        /// Work that has been asked of the actuator since the start
        "state.energy_demand" = State::new(702, 802, Unit::Joule).nominal(1000.0),
    }
}
