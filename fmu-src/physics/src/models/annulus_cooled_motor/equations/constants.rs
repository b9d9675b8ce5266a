//! Quantities that follow from the parameters alone.

use super::drive::Chopper;
use super::{DriveMode, Inputs, MechanicalMode, NODES, Temperatures};
use crate::components::validity::Limits;
use crate::effects::{Acts, EffectPort};
use crate::models::annulus_cooled_motor::network::Body;
use crate::models::annulus_cooled_motor::parameters::Parameters;
use crate::solver::split::HeatCapacities;

/// Ports, besides the drag torque, that are evaluated at every stage of a step.
const BRANCHES: [EffectPort; 13] = [
    EffectPort::WarmDrag,
    EffectPort::LoadDrag,
    EffectPort::TerminalVoltage,
    EffectPort::WindingResistance,
    EffectPort::DrivenDrag,
    EffectPort::DrivenVoltage,
    EffectPort::SeriesVoltage,
    EffectPort::DrivenTorqueConstant,
    EffectPort::HousingHeat,
    EffectPort::WindingHousingResistance,
    EffectPort::HousingToAmbient,
    EffectPort::StillAir,
    EffectPort::PowerModeLoad,
];

/// Constants of the parameters, computed once and not in every step.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    /// 1/L if the current is a state, 0 if the source imposes it.
    pub(super) inverse_l: f64,
    /// 1/J if the shaft is free, 0 if its speed is imposed.
    pub(super) inverse_j: f64,
    /// Heat capacities of the nodes.
    pub(in super::super) capacity: HeatCapacities<NODES>,
    /// Conductance from winding to housing, W/K.
    pub(super) across: f64,
    /// Drift of the true ambient temperature from the indicated one, K/s.
    pub(super) drift: f64,
    /// Fraction of electrical_power that the drive dissipates.
    pub(super) lost: f64,
    /// Fraction of electrical_power that heats the stator.
    pub(super) in_stator: f64,
    /// Whether effects have time events.
    pub(in super::super) eventful: bool,
    /// Ratio of the torque constant to its data sheet value, by the commutation.
    pub(super) torque_factor: f64,
    /// Whether the drive is a chopper with losses, ripple or open switches.
    pub(super) chops: bool,
    /// Whether a network is coupled to the two nodes.
    pub(super) has_network: bool,
    /// Whether iron loss heats the core while all other friction heat goes to the network.
    pub(super) iron_in_core: bool,
    /// Ports at which effects act.
    pub(super) acts: Acts,
    /// Whether any effect gets the present drivers within a step.
    pub(super) driven: bool,
    /// Whether no effect except a drag torque acts within a step.
    plain: bool,
    /// Limits of validity.
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
        // The power of this load is part of electrical_power; its torque acts at an imposed speed.
        let is_loaded = parameters.choices.drive_mode == DriveMode::Power && !free;
        let acts = if is_loaded { acts } else { acts.without(EffectPort::PowerModeLoad) };
        // With a network, the network computes what leaves the housing.
        let of_housing =
            |acts: Acts| acts.without(EffectPort::HousingToAmbient).without(EffectPort::StillAir);
        let acts = if body.is_none() { acts } else { of_housing(acts) };
        let chops = Chopper::acts(parameters);
        Constants {
            inverse_l: if voltage_driven { 1.0 / parameters.motor.L } else { 0.0 },
            inverse_j: if free { 1.0 / parameters.motor.J } else { 0.0 },
            capacity: HeatCapacities::new(capacity),
            across: parameters.thermal.winding_to_housing(1.0, 0.0),
            drift: parameters.effects.ambient_sensor(),
            lost,
            in_stator: (1.0 - lost) * parameters.effects.stator_loss(),
            eventful: parameters.effects.next_event(f64::NEG_INFINITY).is_finite(),
            torque_factor: parameters.choices.commutation.torque_factor(),
            chops,
            has_network: body.is_some(),
            iron_in_core: body.as_ref().is_some_and(|b| b.iron_in_stator),
            acts,
            driven: EffectPort::ALL.iter().any(|port| port.is_driven() && acts.at(*port)),
            plain: !(chops || BRANCHES.iter().any(|port| acts.at(*port))),
            limits: parameters.limits(),
        }
    }

    /// The same with all heat capacities multiplied by `factor`.
    pub fn with_capacity(self, factor: f64) -> Constants {
        Constants { capacity: self.capacity.scaled(factor), ..self }
    }

    /// Limits of validity.
    #[inline]
    pub(in super::super) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Whether a step with these input derivatives is of the kind [`PLAIN`](super::PLAIN): drag torques are the only effects within it, the drive
    /// is ideal, the fan command is constant and the source voltage linear.
    #[inline]
    pub(in super::super) fn are_plain(&self, slopes: &Inputs) -> bool {
        self.plain && slopes.fan_command == 0.0 && slopes.duty * slopes.voltage == 0.0
    }

    /// Drift of the true ambient temperature from the indicated one, K/s.
    pub(in super::super) fn drift(&self) -> f64 {
        self.drift
    }
}
