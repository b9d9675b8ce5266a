//! What stands around the equations: the drivers of terms that are data, the sensor of the housing, and a warm start.

use super::{AnnulusCooledMotor, MechanicalMode, Network, Temperatures};
use crate::components::sensor::lagged;
use crate::effects::{Effect, PerNode, Port};
use crate::model::Node;
use crate::terms::Drivers;

impl AnnulusCooledMotor {
    /// Tells the effects that are data where the motor stands at `time`, and follows what they do to capacities.
    #[inline]
    pub(super) fn tell_effects(&mut self, time: f64) {
        if self.parameters.effects.acts_at(Port::Any) {
            self.tell_drivers(time);
        }
        let factor = self.parameters.effects.heat_capacity();
        if factor != self.capacity_factor {
            let before = self.constants.heat(&self.state.temperature);
            self.capacity_factor = factor;
            self.follow_parameters();
            self.stored_at_start += self.constants.heat(&self.state.temperature) - before;
        }
    }

    /// What terms follow, at `time`.
    pub(super) fn drivers_at(&self, time: f64) -> Drivers {
        let (x, housing) = (&self.state.x, self.housing_temperature());
        Drivers {
            speed: x[1],
            current: x[0],
            load_torque: match self.parameters.choices.mechanical_mode {
                MechanicalMode::FreeShaft => self.inputs.load_torque,
                // Without its own drags, which may be what is asked for.
                MechanicalMode::ImposedSpeed => self.parameters.motor.torque_constant(housing) * x[0],
            },
            winding_temperature: self.state.temperature[0],
            housing_temperature: housing,
            ambient_temperature: self.inputs.ambient_temperature
                + self.parameters.effects.ambient_sensor() * time,
            fan_command: self.inputs.fan_command,
            time,
        }
    }

    fn tell_drivers(&mut self, time: f64) {
        let drivers = self.drivers_at(time);
        self.parameters.effects.tell(&drivers);
        self.fan = (f64::NAN, PerNode::default());
        if let Some(network) = &mut self.network {
            network.forget();
        }
    }

    /// True temperature of the housing, K.
    pub(super) fn housing_temperature(&self) -> f64 {
        self.network.as_ref().map_or(self.state.temperature[1], Network::housing_temperature)
    }

    /// The sensor of the housing follows a step of `h` seconds that began with the housing at `before`, K.
    pub(super) fn follow_sensor(&mut self, before: f64, h: f64) {
        let tau = self.parameters.effects.housing_sensor_lag();
        self.t_sensor = lagged(self.t_sensor, tau, before, self.housing_temperature(), h);
    }

    /// [`Model::warm_start`](crate::model::Model::warm_start). The tube of an annulus stays at the ambient
    /// temperature: the room and the passing air are nearer to it than the motor.
    pub(super) fn put_temperatures(&mut self, known: &[(Node, f64)]) -> Option<()> {
        use Node::{Housing, Magnets, Stator, Winding};
        let winding = Node::nearest(known, &[Winding, Stator, Housing, Magnets])?;
        let stator = Node::nearest(known, &[Stator, Housing, Winding, Magnets])?;
        let magnets = Node::nearest(known, &[Magnets, Housing, Stator, Winding])?;
        let housing = Node::nearest(known, &[Housing, Stator, Magnets, Winding])?;
        // Two nodes alone: the second is the whole housing.
        let core = if self.network.is_some() { stator } else { housing };
        self.state.temperature = Temperatures::new(winding, core);
        if let Some(network) = &mut self.network {
            network.put_temperatures(magnets, housing);
        }
        self.t_sensor = housing;
        self.tell_effects(self.time);
        self.stored_at_start = self.stored();
        self.outdate();
        Some(())
    }
}
