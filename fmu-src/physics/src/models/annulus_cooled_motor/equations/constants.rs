//! Quantities that follow from the parameters alone.

use super::drive::Chopper;
use super::{DriveMode, MechanicalMode, Temperatures};
use crate::components::validity::Limits;
use crate::effects::{Acts, Port};
use crate::models::annulus_cooled_motor::network::Body;
use crate::models::annulus_cooled_motor::parameters::Parameters;

/// What follows from the parameters alone, so that no step divides by them again.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    /// 1/L where the inductance decides the current, 0 where the source does.
    pub(super) inverse_l: f64,
    /// 1/J where the rotor is free, 0 where its speed is imposed.
    pub(super) inverse_j: f64,
    /// Heat capacities of the nodes, J/K.
    pub(super) capacity: Temperatures,
    /// Their reciprocals, K/J.
    pub(super) inverse_capacity: Temperatures,
    /// Conductance from winding to housing, W/K.
    pub(super) across: f64,
    /// How fast the true ambient temperature leaves the shown one, K/s.
    pub(super) drift: f64,
    /// Share of electrical_power that the drive loses.
    pub(super) lost: f64,
    /// Fraction of electrical_power that heats the stator.
    pub(super) in_stator: f64,
    /// Whether a port may jump at a time of its own.
    pub(in super::super) eventful: bool,
    /// Torque over that of the data sheet's torque constant, by the commutation.
    pub(super) torque_factor: f64,
    /// Whether a drive that chops loses something on the way.
    pub(super) chops: bool,
    /// Whether a network stands beyond the two nodes.
    pub(super) has_network: bool,
    /// Whether the iron's loss heats the core while all other friction heat goes to the network.
    pub(super) iron_in_core: bool,
    /// Where effects act.
    pub(super) acts: Acts,
    /// Where the equations end.
    pub(super) limits: Limits,
}

impl Constants {
    /// The constants of a motor.
    pub fn of(parameters: &Parameters) -> Constants {
        let body = Body::of(parameters);
        let voltage_driven = matches!(parameters.choices.drive_mode, DriveMode::Voltage | DriveMode::Pwm);
        let free = parameters.choices.mechanical_mode == MechanicalMode::FreeShaft;
        let core = body.as_ref().map_or(parameters.thermal.C_h, |b| b.stator);
        let capacity = Temperatures::new(parameters.thermal.C_w, core);
        let lost = parameters.effects.drive_loss();
        let acts = Acts::of(&parameters.effects);
        // Its power is a part of electrical_power, and its torque acts at an imposed speed.
        let is_loaded = parameters.choices.drive_mode == DriveMode::Power && !free;
        let acts = if is_loaded { acts } else { acts.without(Port::PowerModeLoad) };
        // Beyond the core, the network radiates.
        let acts = if body.is_none() { acts } else { acts.without(Port::HousingToAmbient) };
        Constants {
            inverse_l: if voltage_driven { 1.0 / parameters.motor.L } else { 0.0 },
            inverse_j: if free { 1.0 / parameters.motor.J } else { 0.0 },
            capacity,
            inverse_capacity: capacity.map(|c| 1.0 / c),
            across: parameters.thermal.winding_to_housing(1.0, 0.0),
            drift: parameters.effects.ambient_sensor(),
            lost,
            in_stator: (1.0 - lost) * parameters.effects.stator_loss(),
            eventful: parameters.effects.next_event(f64::NEG_INFINITY).is_finite(),
            torque_factor: parameters.choices.commutation.torque_factor(),
            chops: Chopper::acts(parameters),
            has_network: body.is_some(),
            iron_in_core: body.as_ref().is_some_and(|b| b.iron_in_stator),
            acts,
            limits: parameters.limits(),
        }
    }

    /// With every heat capacity times `factor`.
    pub fn with_capacity(mut self, factor: f64) -> Constants {
        self.capacity *= factor;
        self.inverse_capacity /= factor;
        self
    }

    /// The heat in the nodes above the temperature `origin`, K, in J.
    pub fn heat(&self, temperature: &Temperatures, origin: f64) -> f64 {
        self.capacity.dot(&temperature.add_scalar(-origin))
    }

    /// Where the equations end.
    #[inline]
    pub(in super::super) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// How fast the true ambient temperature leaves the shown one, K/s.
    pub(in super::super) fn drift(&self) -> f64 {
        self.drift
    }
}
