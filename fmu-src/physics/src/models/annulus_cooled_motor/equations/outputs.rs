//! Outputs, and the residual of the energy balance.

use super::{CORE, Ends, Instant, NODES, Step, WINDING};
use crate::components::commutation::Phases;
use crate::effects::PerNode;
use crate::ledger::{Account, Ledger};
use crate::model::HousingHeat;
use crate::models::annulus_cooled_motor::cooling::mass;
use crate::models::annulus_cooled_motor::network::Network;
use crate::models::annulus_cooled_motor::variables::{DriveMode, EnergyBalance, Outputs};
use crate::solver::split::{State, System};

impl<const FORM: u8> Step<'_, FORM> {
    /// Stored energy, J: magnetic and kinetic unless imposed, and heat above the temperature `origin`, K.
    pub fn stored(&self, state: &State<NODES>, origin: f64) -> f64 {
        let (i, w) = (state.x[0], state.x[1]);
        self.magnetic(i) + self.kinetic(w) + self.constants.capacity.heat(&state.temperature, origin)
    }

    pub(super) fn magnetic(&self, i: f64) -> f64 {
        if self.is_voltage_driven() { 0.5 * self.model.motor.L * i * i } else { 0.0 }
    }

    pub(super) fn kinetic(&self, w: f64) -> f64 {
        if self.is_free() { 0.5 * self.model.motor.J * w * w } else { 0.0 }
    }

    /// Outputs at the start of the step; `sensors` are the temperatures of the sensors.
    pub fn outputs(&self, state: &State<NODES>, sensors: &PerNode, phases: &Phases) -> Outputs {
        let (model, ambient) = (self.model, self.ambient.start);
        let (x, temperature) = (&state.x, &state.temperature);
        let t_w = temperature[WINDING];
        let Ends { voltage, shaft_torque, k, r, .. } = self.ends(0.0, x, temperature);
        let hottest = t_w + phases.hottest();
        Outputs {
            current: x[0],
            shaft_angle: state.angle,
            shaft_speed: x[1],
            shaft_torque: model.effects.torque_sensor(shaft_torque),
            winding_temperature: model.effects.winding_sensor(sensors.winding, ambient),
            stator_temperature: temperature[CORE],
            magnet_temperature: self.magnets(0.0, temperature),
            housing_temperature: model.effects.housing_sensor(sensors.housing, ambient),
            winding_resistance: r,
            torque_constant: k,
            winding_margin: model.thermal.T_w_max - hottest,
            over_temperature: hottest > model.thermal.T_w_max,
            torque_density: shaft_torque / mass(model),
            terminal_voltage: voltage,
            winding_hot_spot_temperature: hottest,
        }
    }

    /// Power at the terminals (drive_mode pwm: at the supply of the drive) at the start of the step, W.
    pub fn power_electrical(&self, state: &State<NODES>) -> f64 {
        let (x, temperature) = (&state.x, &state.temperature);
        self.at_terminals(self.power_in(0.0, x, &self.ends(0.0, x, temperature)))
    }

    /// The part of the input power at the terminals, W: without heat that no current causes.
    fn at_terminals(&self, power_in: f64) -> f64 {
        power_in - self.inputs.heat_power - self.model.effects.winding_heat()
    }

    /// Copper loss and friction loss, W.
    pub fn heat_flows(&self, state: &State<NODES>) -> [f64; 2] {
        let p = self.point(0.0, &state.x, &state.temperature);
        [self.copper_loss(state, p.drive), p.drag * state.x[1]]
    }

    /// Copper loss including contact voltage drop, and in drive_mode power the power that heats the winding, W.
    fn copper_loss(&self, state: &State<NODES>, drive: f64) -> f64 {
        let i = state.x[0];
        let Instant { r, lost, .. } = self.instant(0.0, &state.x, &state.temperature);
        let copper = r * i * i + lost * i + self.ripple_loss(0.0, r);
        match self.model.choices.drive_mode {
            DriveMode::Power => {
                let load = self.power_mode_torque(state.x[1]) * state.x[1];
                copper + self.inputs.electrical_power - drive - self.stator.at(0.0) - load
            }
            _ => copper,
        }
    }

    /// The same equations with the magnetisation since the last event at `time`, s.
    pub fn with_strength_since(mut self, time: f64) -> Self {
        self.strength = self.constants.torque_factor * self.model.effects.torque_constant(time);
        self
    }

    /// Heat flow along the leads from the winding at `t_w` to ambient, W.
    pub fn leads(&self, t_w: f64, network: &Network) -> f64 {
        let conductance = self.coupling.conductance.winding - network.body.winding_to_rotor;
        conductance * (t_w - self.ambient.start)
    }

    /// Heat flow from the housing to ambient at the start of the step.
    pub fn housing_heat(&self, state: &State<NODES>, network: Option<&Network>) -> HousingHeat {
        let (ambient, core) = (self.ambient.start, state.temperature[CORE]);
        let (housing, flow) = match network {
            Some(network) => (network.housing_temperature(), network.housing_heat(ambient)),
            None => {
                let conductance = self.conductance_at(0.0).housing;
                (core, conductance * (core - ambient) + self.curved(core, ambient))
            }
        };
        HousingHeat { housing, ambient, flow }
    }

    /// Power flows at the start of the step, and the balance residuals. Energies are relative to the energy stored at the start,
    /// heat to the temperature `origin`, K, so that rounding errors of energies above 0 K do not enter the residual.
    pub fn energy_balance(
        &self,
        state: &State<NODES>,
        (origin, stored_at_start): (f64, f64),
        network: Option<&Network>,
    ) -> EnergyBalance {
        use Account::*;
        let (x, temperature) = (&state.x, &state.temperature);
        let w = x[1];
        let mut p = self.point(0.0, x, temperature);
        let capacity = self.capacity().values;
        let (cooling, heat_to_ambient, error) = match network {
            Some(network) => self.network_books(state, network, p.drive, &mut p.ledger),
            None => {
                let error = p.ledger.error(&[(Ambient, p.to_ambient)]);
                (EnergyBalance::without_flow(self.inputs, self.ambient.start), p.to_ambient, error)
            }
        };
        let power_balance_error = error
            + p.ledger.error(&[
                (Terminals, -p.power_in),
                (AirGap, 0.0),
                (Shaft, p.shaft_torque * w),
                (Winding, capacity[WINDING] * p.warming[WINDING]),
                (self.core(), capacity[CORE] * p.warming[CORE]),
            ]);
        let [energy_in, energy_out, energy_heat] = state.energy;
        let copper = self.copper_loss(state, p.drive);
        let stored = self.stored(state, origin) + network.map_or(0.0, |n| n.stored(origin));
        EnergyBalance {
            power_electrical: self.at_terminals(p.power_in),
            power_mechanical: p.shaft_torque * w,
            loss_copper: copper,
            loss_iron: self.iron_drag(w) * w,
            loss_friction: p.drag * w,
            loss_drive: p.drive,
            heat_to_ambient,
            power_balance_error,
            energy_electrical: energy_in,
            energy_mechanical: energy_out,
            energy_heat_to_ambient: energy_heat,
            energy_balance_error: energy_in - energy_out - energy_heat - (stored - stored_at_start),
            ..cooling
        }
    }

    /// Enters the flows of the network, each at both ends, and compares them with the derivatives of its temperatures. Returns the
    /// outputs of the cooling, the heat flow to ambient, W, and the power balance residual of the network, W.
    fn network_books(
        &self,
        state: &State<NODES>,
        network: &Network,
        drive: f64,
        ledger: &mut Ledger,
    ) -> (EnergyBalance, f64, f64) {
        use Account::*;
        let (x, temperature) = (&state.x, &state.temperature);
        let (t_w, t_core) = (temperature[WINDING], temperature[CORE]);
        let (ambient, body) = (self.ambient.start, &network.body);
        let friction = self.drag_beyond(x, temperature);
        let flows = network.flows(ambient);
        let (rotor, housing) = (network.rotor_temperature(), network.housing_temperature());
        let leads = self.leads(t_w, network);

        ledger.transfer(AirGap, Rotor, friction * body.friction_to_rotor);
        ledger.transfer(AirGap, Housing, friction * (1.0 - body.friction_to_rotor));
        ledger.transfer(Winding, Rotor, body.winding_to_rotor * (t_w - rotor));
        ledger.transfer(Winding, Ambient, leads);
        ledger.transfer(Stator, Housing, body.segments as f64 * body.from_stator * (t_core - housing));
        ledger.transfer(Rotor, Housing, flows.rotor_to_housing);
        ledger.transfer(Housing, Ambient, flows.housing_to_room);
        ledger.transfer(Housing, Air, flows.housing_to_air);
        ledger.transfer(Housing, Tube, flows.housing_to_tube);
        ledger.transfer(Tube, Air, flows.tube_to_air);
        ledger.transfer(Tube, Ambient, flows.tube_to_ambient);
        ledger.transfer(Fan, Air, flows.fan_to_air);
        ledger.transfer(Air, Ambient, flows.air_to_room);

        let inflow = network.inflow(t_w, t_core, friction);
        let rates = network.rates_now(ambient, &inflow);
        let [to_rotor, to_tube, to_housing] = network.stored_rates(&rates);
        let to_ambient = network.to_ambient(&rates) + leads + drive;
        let error = ledger.error(&[
            (Rotor, to_rotor),
            (Tube, to_tube),
            (Housing, to_housing),
            (Air, 0.0),
            (Fan, -network.coefficients().fan_power),
            (Ambient, to_ambient + network.coefficients().fan_power),
        ]);
        (network.show(self.model, self.inputs, ambient, &flows), to_ambient, error)
    }
}
