//! The ports of a model: where effects act, and what each may do there.

use crate::number::Number;
use crate::terms::{Driver, Drivers, GenericTerm, Lag};

/// An event that is less than this ahead has come, s: times that differ by rounding are the same.
pub const IMMINENT: f64 = 1e-9;

/// A value for each thermal node that effects know of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PerNode {
    /// That of the winding.
    pub winding: f64,
    /// That of the housing.
    pub housing: f64,
}

impl std::ops::Add for PerNode {
    type Output = PerNode;
    #[inline]
    fn add(self, other: PerNode) -> PerNode {
        PerNode { winding: self.winding + other.winding, housing: self.housing + other.housing }
    }
}

/// What an effect adds that adds nothing: x + -0.0 is x to the last bit for every x, so that no addition remains of it in
/// the sum over all effects; x + 0.0 is not, where x is -0.0.
const NONE: f64 = -0.0;

/// What an effect may do, port by port. A port that an effect does not touch stays neutral.
pub trait Effect {
    /// Whether its switch, the parameter that is 0 by default, is on.
    fn is_on(&self) -> bool;

    /// Takes terms that are data in place of those it had; false, and nothing taken, where it carries none or not
    /// these.
    fn take_terms(&mut self, _terms: &[GenericTerm]) -> bool {
        false
    }

    /// Tells where the motor stands: what follows a driver slowly holds that over a step. Whether this may change what the air takes,
    /// which is kept over many steps.
    #[inline]
    fn tell(&mut self, _drivers: &Drivers) -> bool {
        false
    }

    /// Whether it holds this driver over a step, as [`tell`](Effect::tell) told it.
    fn holds(&self, _driver: Driver) -> bool {
        false
    }

    /// The lag of the `k`-th term that is data, whose state the model integrates.
    #[inline]
    fn lag(&self, _k: usize) -> Option<Lag> {
        None
    }

    /// A torque against the motion at speed `w`, rad/s: N.m, of the sign of `w`. Its power heats the housing.
    #[inline]
    fn drag_torque<D: Number>(&self, _w: D) -> D {
        D::from(NONE)
    }

    /// A torque against the motion for each newton metre that the shaft hands to its load: of the sign of `w`
    /// times that of the load's torque, which is about `tau`, N.m. Its power heats the housing.
    #[inline]
    fn load_drag<D: Number>(&self, _w: D, _tau: f64) -> D {
        D::from(NONE)
    }

    /// Volts lost between the terminals and the winding at current `i`, A: of the sign of `i`. Their power heats
    /// the winding.
    #[inline]
    fn terminal_voltage<D: Number>(&self, _i: D) -> D {
        D::from(NONE)
    }

    /// Volts lost in the drive's bridge at current `i`, A (drive_mode pwm): of the sign of `i`. Their power heats the
    /// surroundings.
    #[inline]
    fn bridge_voltage<D: Number>(&self, _i: D) -> D {
        D::from(NONE)
    }

    /// Volts that the motor misses at current `i`, A, while the supply of `supply` volts gives as much less
    /// (drive_mode pwm): of the sign of `i`. No heat.
    #[inline]
    fn missed_voltage<D: Number>(&self, _i: D, _supply: f64) -> D {
        D::from(NONE)
    }

    /// Mean square of the current's ripple, A2 (drive_mode pwm), which heats the winding.
    #[inline]
    fn ripple_square(&self, _duty: f64, _supply: f64, _inductance: f64) -> f64 {
        NONE
    }

    /// Multiplies the winding's resistance; positive.
    #[inline]
    fn winding_resistance(&self) -> f64 {
        1.0
    }

    /// Heat set free in the winding beside that of its current, W.
    #[inline]
    fn winding_heat(&self) -> f64 {
        NONE
    }

    /// Multiplies every heat capacity; positive.
    #[inline]
    fn heat_capacity(&self) -> f64 {
        1.0
    }

    /// Multiplies the torque constant at `time`, s. Over time alone it steps at [`next_event`](Effect::next_event) and only there.
    #[inline]
    fn torque_constant(&self, _time: f64) -> f64 {
        1.0
    }

    /// The first time after `time` at which a port jumps, s; infinite where none does.
    #[inline]
    fn next_event(&self, _time: f64) -> f64 {
        f64::INFINITY
    }

    /// Multiplies the thermal resistance from winding to housing with the winding at `t_w`, K; positive.
    #[inline]
    fn winding_housing_resistance<D: Number>(&self, _t_w: D) -> D {
        D::from(1.0)
    }

    /// Further conductances to ambient, W/K, at the fan's `flow`, 0 to 1.
    #[inline]
    fn ambient_conductance(&self, _flow: f64) -> PerNode {
        PerNode::default()
    }

    /// Heat flow from the housing at `t_h`, K, to the surroundings at `t_a` that follows no conductance, W.
    #[inline]
    fn housing_to_ambient<D: Number>(&self, _t_h: D, _t_a: f64) -> D {
        D::from(NONE)
    }

    /// Heat set free in the housing at `t_h`, K, that the surroundings give, W.
    #[inline]
    fn housing_heat<D: Number>(&self, _t_h: D) -> D {
        D::from(NONE)
    }

    /// A stator between winding and housing: its resistance to the housing, K/W, and its capacity, J/K; both positive,
    /// or both 0.
    #[inline]
    fn stator(&self) -> (f64, f64) {
        (0.0, 0.0)
    }

    /// The command that the fan really follows when it is given `n`, 0 to 1.
    #[inline]
    fn fan_flow(&self, n: f64) -> f64 {
        n
    }

    /// How fast the true ambient temperature leaves the shown one, K/s; they agree at time 0.
    #[inline]
    fn ambient_sensor(&self) -> f64 {
        NONE
    }

    /// What the true ambient temperature is above the shown one, beside its drift, K.
    #[inline]
    fn ambient_offset(&self) -> f64 {
        NONE
    }

    /// Time constant with which the sensor of the housing follows, s.
    #[inline]
    fn housing_sensor_lag(&self) -> f64 {
        NONE
    }

    /// What the sensor of the winding shows at its temperature `t` in surroundings at `t_a`, K.
    #[inline]
    fn winding_sensor(&self, t: f64, _t_a: f64) -> f64 {
        t
    }

    /// What the sensor of the housing shows at its temperature `t` (that it lags behind) in surroundings at
    /// `t_a`, K.
    #[inline]
    fn housing_sensor(&self, t: f64, _t_a: f64) -> f64 {
        t
    }

    /// The part of [`drag_torque`](Effect::drag_torque) that arises in the iron, N.m.
    #[inline]
    fn iron_drag(&self, _w: f64) -> f64 {
        NONE
    }

    /// Share of the input electrical_power that never reaches the winding and heats the surroundings.
    #[inline]
    fn drive_loss(&self) -> f64 {
        NONE
    }
}

/// Where an effect acts: the methods of [`Effect`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is explained where it is a method
pub enum Port {
    /// Any of them: what acts there is decided by data.
    Any,
    DragTorque,
    LoadDrag,
    TerminalVoltage,
    WindingResistance,
    TorqueConstant,
    WindingHousingResistance,
    AmbientConductance,
    HousingToAmbient,
    FanFlow,
    AmbientSensor,
    HousingSensorLag,
    WindingSensor,
    HousingSensor,
    DriveLoss,
    Stator,
    Bridge,
    Ripple,
}
