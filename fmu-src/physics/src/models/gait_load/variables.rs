//! Inputs, outputs, states and event indicators of the gait. The parameters are declared in `components/gait.rs`.

use declare::{State, Unit, Variable, states, variables};

variables! {
    /// Inputs.
    pub struct Inputs {
        /// Torque of the actuator at the joint
        joint_torque: f64 = Variable::input(1, 0.0, Unit::NewtonMetre, -1e6, 1e6).nominal(100.0),
    }
}

variables! {
    /// Outputs. Positive is extension, plantarflexion at the ankle.
    pub struct Outputs {
        /// Joint angle
        joint_angle: f64 = Variable::output(20, Unit::Radian),
        /// Joint speed
        joint_speed: f64 = Variable::output(21, Unit::RadianPerSecond),
        /// Torque demanded of the actuator
        torque_demand: f64 = Variable::output(22, Unit::NewtonMetre).nominal(100.0),
        /// Gait phase, 0 at heel strike, 1 at the next
        gait_phase: f64 = Variable::output(23, Unit::One),
        /// Torque of the actuator minus torque demanded
        tracking_error: f64 = Variable::output(24, Unit::NewtonMetre),
        /// Power demanded of the actuator; positive into the leg
        power_demand: f64 = Variable::output(25, Unit::Watt).nominal(100.0),
        /// Work demanded of the actuator since the start
        energy_demand: f64 = Variable::output(26, Unit::Joule).unbounded().nominal(1000.0),
        /// Number of complete strides since the start
        strides: f64 = Variable::output(27, Unit::One).unbounded(),
    }
}

variables! {
    /// Event indicators of Model Exchange: residuals that pass through zero at an event.
    pub struct Indicators {
        /// Sine of pi times the stride coordinate: zero at each heel strike
        heel_strike: f64 = Variable::local(901, Unit::One),
    }
}

states! {
    /// The states, in the order of the rates.
    pub const LIST = {
        /// Strides since the start, the phase of the present one included
        "state.stride" = State::new(701, 801, Unit::One).unbounded().nominal(1.0, 1.0),
        /// Work demanded of the actuator since the start
        "state.energy_demand" = State::new(702, 802, Unit::Joule).unbounded().nominal(1000.0, 100.0),
    }
}
