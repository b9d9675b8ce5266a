//! Reading of outputs and derivatives between the steps, which leaves the motor as it is.
//!
//! Steps use linearized cooling and constant drivers of terms. What is read is evaluated by the full equations with the present drivers,
//! from copies of the parameters and, if there is one, the network.

use super::equations::{Constants, Step};
use super::motor::AnnulusCooledMotor;
use super::network::Network;
use super::state_list::{
    ALL, ANGLE, All, CORE, CURRENT, ENERGIES, HOUSING, HOUSING_SENSOR, LAGS, PHASES, ROTOR, SPEED, TUBE,
    WINDING, WINDING_SENSOR,
};
use super::variables::Outputs;
use crate::effects::PerNode;
use crate::solver::split::System;

/// The motor at the present time, as outputs and derivatives see it.
pub(super) struct Reading<'a> {
    pub(super) run: &'a AnnulusCooledMotor,
    /// The equations with the present drivers.
    pub(super) step: Step<'a>,
    /// The network with the present coefficients.
    pub(super) network: Option<&'a Network>,
    /// Energy stored at the start, J, with the present heat capacities.
    pub(super) stored_at_start: f64,
}

impl AnnulusCooledMotor {
    /// Result of `look` at the present time with the drivers set and, if `cooled`, the cooling by its full equations. The motor
    /// is unchanged: linearized cooling and constant drivers belong to the steps, and reading an output must not change them.
    #[inline(always)]
    pub(super) fn observe<T>(&self, cooled: bool, look: impl FnOnce(&Reading) -> T) -> T {
        let own = &self.own;
        let is_driven = self.has_driven_effects();
        let is_cooled = own.network.as_ref().is_none_or(|n| {
            self.pre.is_some() && n.is_evaluated_at(&self.inputs, self.ambient(self.time).start)
        });
        if !is_driven && (is_cooled || !cooled) {
            let (step, network) = (self.equations(), own.network.as_deref());
            return look(&Reading { run: self, step, network, stored_at_start: own.stored_at_start });
        }
        let mut parameters = self.parameters;
        let cools = is_driven && parameters.effects.set_drivers(&self.drivers_after(self.time, 0.0));
        let fan = if cools { (f64::NAN, PerNode::default()) } else { own.fan };
        let factor = parameters.effects.capacity_factor();
        let changed =
            (factor != own.terms.capacity_factor).then(|| Constants::of(&parameters).with_capacity(factor));
        let constants = changed.as_ref().unwrap_or(&own.constants);
        let stored_at_start = own.stored_at_start + self.heat_gained(factor);
        let mut network = own.network.as_deref().map(Network::bare);
        if let Some(network) = &mut network {
            if cools || self.pre.is_none() {
                network.forget();
            }
            let ambient = self.ambient_of(&parameters, self.time).start;
            network.evaluate(&parameters, &self.inputs, ambient);
        }
        let step = self.equations_of(&parameters, constants, network.as_ref(), fan);
        look(&Reading { run: self, step, network: network.as_ref(), stored_at_start })
    }
}

impl Reading<'_> {
    pub(super) fn outputs(&self) -> Outputs {
        let own = &self.run.own;
        let mut outputs = self.step.outputs(&own.state, &own.sensors, &own.phases);
        if let Some(pre) = &self.run.pre {
            outputs.over_temperature = pre.discrete.over_temperature;
        }
        outputs
    }

    /// Derivatives of all states; zero for states that are not in use.
    pub(super) fn rates(&self) -> All {
        let Reading { run, step, network, .. } = self;
        let mut all = self.rates_of_heat_and_motion();
        let (x, temperature) = (run.own.state.x, run.own.state.temperature);
        let point = step.point(0.0, &x, &temperature);
        let to_ambient = match network {
            None => point.to_ambient,
            Some(network) => {
                let friction = step.drag_beyond(&x, &temperature);
                let ambient = step.ambient_at_start();
                let rates =
                    network.rates_now(ambient, &network.inflow(temperature[0], temperature[1], friction));
                network.to_ambient(&rates) + step.leads(temperature[0], network) + point.drive
            }
        };
        all[ANGLE] = x[1];
        all[ENERGIES..LAGS].copy_from_slice(&[point.power_in, point.shaft_torque * x[1], to_ambient]);
        all[PHASES..ENERGIES].copy_from_slice(&run.phase_rates(step));
        for (k, rate) in all.iter_mut().enumerate() {
            if !run.moves(k) {
                *rate = 0.0;
            }
        }
        all
    }

    /// Derivatives of the coupled states.
    pub(super) fn rates_of_heat_and_motion(&self) -> All {
        let Reading { run, step, network, .. } = self;
        let mut all = [0.0; ALL];
        let (x, temperature) = (run.own.state.x, run.own.state.temperature);
        let fast = step.fast_rates(0.0, &x, &temperature);
        let warming = step.network_rates(0.0, &temperature)
            + step.heat_rates(0.0, &x, &temperature).component_mul(&step.capacity().inverse);
        let friction = step.drag_beyond(&x, &temperature);
        let ambient = step.ambient_at_start();
        (all[CURRENT], all[SPEED]) = (fast[0], fast[1]);
        (all[WINDING], all[CORE]) = (warming[0], warming[1]);
        if let Some(network) = network {
            let rates = network.rates_now(ambient, &network.inflow(temperature[0], temperature[1], friction));
            (all[ROTOR], all[TUBE]) = (rates[0], rates[1]);
            let n = network.body.segments;
            all[HOUSING..HOUSING + n].copy_from_slice(&rates[2..2 + n]);
        }
        let (lag, sensed, sensors) = (run.parameters.effects.sensor_lag(), run.sensed(), run.own.sensors);
        if lag.winding > 0.0 {
            all[WINDING_SENSOR] = (sensed.winding - sensors.winding) / lag.winding;
        }
        if lag.housing > 0.0 {
            all[HOUSING_SENSOR] = (sensed.housing - sensors.housing) / lag.housing;
        }
        all[LAGS..HOUSING].copy_from_slice(&run.lag_rates(|| step.heat_flows(&run.own.state)));
        all
    }
}
