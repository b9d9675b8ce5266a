//! The motor as [`Equations`] of the runtime: its state, outputs and events. `states.rs` has the continuous states, `reading.rs` their
//! derivatives, `stepping.rs` the steps, `drivers.rs` the drivers of terms, changed parameters, the sensor and the initial state.

use super::equations::{Constants, NODES, Step, Temperatures};
use super::network::{Body, Network};
use super::parameters::Parameters;
use super::state_list::{ALL, STATES, is_coupled};
use super::variables::{DriveMode, EnergyBalance, Indicators, Inputs, MechanicalMode, Outputs};
use crate::components::commutation::{Commutation, Phases};
use crate::components::validity::Extremes;
use crate::effects::PerNode;
use crate::exchange::is_above;
use crate::model::{Declaration, Declared, Fault, HousingHeat};
use crate::runtime::{Driven, Equations, Halt, Runtime, TermStates};
use crate::saved;
use crate::solver::split::{Split, State};
use crate::terms::{Drivers, GenericTerm};
use declare::{Named, State as Declare};
use std::f64::consts::FRAC_PI_3;

/// The motor.
pub type AnnulusCooledMotor = Runtime<Motor, ALL>;

/// State between communication points.
#[derive(Clone, Debug)]
pub struct Motor {
    pub(super) constants: Constants,
    /// Fan command and its conductance, cached: the power function takes half the time of a step.
    pub(super) fan: (f64, PerNode),
    pub(super) state: State<NODES>,
    /// Temperatures of the sensors, K.
    pub(super) sensors: PerNode,
    /// States of the terms.
    pub(super) terms: TermStates,
    /// Temperature at the start, K; reference of the stored heat.
    pub(super) t_start: f64,
    /// Energy stored at the start, J.
    pub(super) stored_at_start: f64,
    pub(super) split: Split<NODES>,
    /// Temperature of each phase relative to the mean winding temperature.
    pub(super) phases: Phases,
    /// Thermal network beside winding and stator, if the cooling mode has one. In a box: it is twice as large as the rest.
    pub(super) network: Option<Box<Network>>,
    /// Inconsistency between parameters.
    pub(super) fault: Option<String>,
}

saved!(PerNode { winding, housing });
saved!(Motor { sensors, t_start, terms, stored_at_start, state, split, phases });

/// Discrete states in Model Exchange.
#[derive(Clone, Copy, Debug, Default)]
pub struct Discrete {
    /// The sector of block commutation since the last event.
    sector: f64,
    /// Whether the winding was above its limit at the last event.
    pub(super) over_temperature: bool,
    /// Whether the duty was zero at the last event.
    idle: bool,
    /// Factor on the heat capacities that the energy balance contains.
    booked: f64,
}

saved!(Discrete { sector, over_temperature, idle, booked });

impl Discrete {
    /// The electrical angle at the middle of the sector, rad.
    pub(super) fn angle(&self) -> f64 {
        (self.sector + 0.5) * FRAC_PI_3
    }
}

/// The rows of the outputs by name.
type Output = <Outputs as Named>::Row;
type Flow = <EnergyBalance as Named>::Row;
/// Distance from the border of a sector within which an electrical angle is at the border, rad.
const NEAR_SECTOR: f64 = 1e-9;

impl AnnulusCooledMotor {
    /// The state at the present time: current, A, speed, rad/s, angle, rad, temperatures, K, energies, J.
    pub fn state(&self) -> &State<NODES> {
        &self.own.state
    }

    /// The equations over the next step, with linear inputs.
    pub fn step_equations(&mut self) -> Step<'_> {
        self.set_drivers(self.time);
        self.follow_cooling();
        self.equations()
    }

    /// Updates the cached cooling to the inputs.
    #[inline]
    pub(super) fn follow_cooling(&mut self) {
        if self.own.network.is_some() {
            self.bring_network_to_inputs();
        } else if self.own.fan.0 != self.inputs.fan_command {
            self.own.fan = (self.inputs.fan_command, self.parameters.to_ambient(self.inputs.fan_command));
        }
    }

    /// The equations with the cached cooling.
    #[inline(always)]
    pub(super) fn equations(&self) -> Step<'_> {
        let own = &self.own;
        self.equations_of(&self.parameters, &own.constants, own.network.as_deref(), own.fan)
    }

    /// The equations in the present state with other parameters, and what follows from them. Inlined, so that only what an output needs is
    /// computed and nothing is copied.
    #[inline(always)]
    pub(super) fn equations_of<'a>(
        &'a self,
        parameters: &'a Parameters,
        constants: &'a Constants,
        network: Option<&Network>,
        fan: (f64, PerNode),
    ) -> Step<'a> {
        let is_kept = network.is_some() || fan.0 == self.inputs.fan_command;
        let fan = if is_kept { fan.1 } else { parameters.to_ambient(self.inputs.fan_command) };
        let mut step = Step::new(parameters, constants, &self.inputs, &self.slopes, fan, self.time);
        step.excess = self.excess();
        step.lags = self.own.terms.lags_after(self.time);
        if let Some(pre) = &self.pre {
            step = step.with_strength_since(pre.since).with_open_switches(pre.discrete.idle);
        }
        if let Some(network) = network {
            step.couple(self.coupling(parameters, network));
        }
        step
    }

    /// Stored energy, J.
    pub(super) fn stored(&self) -> f64 {
        let state = self.own.state;
        let network = self.own.network.as_ref().map_or(0.0, |n| n.stored(self.own.t_start));
        self.equations().stored(&state, self.own.t_start) + network
    }

    /// Temperatures with limits of validity.
    pub(super) fn extremes(&self) -> Extremes {
        let [winding, core] = [self.own.state.temperature[0], self.own.state.temperature[1]];
        let magnets = self.own.network.as_deref().map_or(core, Network::rotor_temperature);
        Extremes { winding: winding + self.own.phases.hottest(), magnets, lowest: winding.min(magnets) }
    }
}

impl Equations<ALL> for Motor {
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Balance = EnergyBalance;
    type Indicators = Indicators;
    type Point = ();
    type Discrete = Discrete;
    const LIST: &'static [Declare] = STATES;
    const IS_LIMITED: bool = true;

    fn declaration() -> &'static Declaration {
        static DECLARED: Declared = Declared::new();
        DECLARED.get_or_init(|| {
            AnnulusCooledMotor::declare(
                "AnnulusCooledMotor",
                "Thermo-electromechanical motor with thermal network and cooling: electrical terminals, shaft, winding and housing temperature",
                &[],
            )
        })
    }

    fn new(parameters: &Parameters) -> Motor {
        Motor {
            constants: Constants::of(parameters),
            fan: (f64::NAN, PerNode::default()),
            state: State::default(),
            sensors: PerNode::default(),
            terms: TermStates::default(),
            t_start: 0.0,
            stored_at_start: 0.0,
            split: Split::default(),
            phases: Phases::default(),
            network: None,
            fault: None,
        }
    }

    fn start(run: &mut AnnulusCooledMotor) -> Result<(), Fault> {
        let parameters = &run.parameters;
        let fault = Body::fault(parameters).or_else(|| parameters.initial.fault(&parameters.limits()));
        if let Some(fault) = fault {
            return Err(Fault(fault));
        }
        let time = run.time;
        let mut ambient = run.inputs.ambient_temperature + run.parameters.effects.ambient_sensor() * time;
        run.own.state = State { temperature: Temperatures::repeat(ambient), ..State::default() };
        run.own.split = Split::default();
        run.own.phases = Phases::default();
        run.own.network = None;
        Self::follow_parameters(run);
        Self::follow_inputs(run);
        run.set_drivers(time);
        ambient += run.parameters.effects.ambient_offset();
        run.own.state.temperature = Temperatures::repeat(ambient);
        run.own.t_start = ambient;
        // Created again, because a new network starts at the temperature of the state.
        run.own.network = None;
        Self::follow_parameters(run);
        run.put_initial(ambient);
        // Terms may depend on the initial temperatures.
        run.set_drivers(time);
        run.start_lags();
        run.own.stored_at_start = run.stored();
        Ok(())
    }

    #[inline]
    fn advance(run: &mut AnnulusCooledMotor, time: f64, h: f64) -> Result<(), Halt> {
        match &run.own.fault {
            Some(fault) => Err(Halt::Fault(Fault(fault.clone()))),
            None => run.advance_driven(time, h),
        }
    }

    fn point(_: &AnnulusCooledMotor) {}

    fn outputs(run: &AnnulusCooledMotor, (): &()) -> Outputs {
        run.observe(false, |now| now.outputs())
    }

    /// Outputs that need no evaluation of the equations: states, and the sensors of winding and housing.
    #[inline]
    fn output(run: &AnnulusCooledMotor, row: usize) -> Option<f64> {
        let (state, effects) = (&run.own.state, &run.parameters.effects);
        match Outputs::row(row)? {
            Output::current => Some(state.x[0]),
            Output::shaft_angle => Some(state.angle),
            Output::shaft_speed => Some(state.x[1]),
            sensor @ (Output::winding_temperature | Output::housing_temperature)
                if !run.has_driven_effects() =>
            {
                let ambient = run.ambient(run.time).start;
                Some(match sensor {
                    Output::winding_temperature => effects.winding_sensor(run.own.sensors.winding, ambient),
                    _ => effects.housing_sensor(run.own.sensors.housing, ambient),
                })
            }
            _ => None,
        }
    }

    /// The power at the terminals, which a drive reads at every step, needs no evaluation of the cooling.
    fn flow(run: &AnnulusCooledMotor, row: usize) -> Option<f64> {
        (row == Flow::power_electrical as usize)
            .then(|| run.observe(false, |now| now.step.power_electrical(&run.own.state)))
    }

    fn balance(run: &AnnulusCooledMotor, (): &()) -> EnergyBalance {
        run.observe(true, |now| {
            let start = (run.own.t_start, now.stored_at_start);
            now.step.energy_balance(&run.own.state, start, now.network)
        })
    }

    fn indicators(run: &AnnulusCooledMotor, (): &()) -> Indicators {
        let sector = match run.parameters.choices.commutation {
            Commutation::Block => (3.0 * run.electrical_angle(&run.own.state)).sin(),
            Commutation::EquivalentDc | Commutation::Sinusoidal => 1.0,
        };
        let hottest = run.own.state.temperature[0] + run.own.phases.hottest();
        Indicators {
            over_temperature: hottest - run.parameters.thermal.T_w_max,
            commutation_sector: sector,
            validity_limit: Self::excess(run),
        }
    }

    /// The energy balance excludes the change of stored energy by a tunable parameter.
    fn set_parameter(run: &mut AnnulusCooledMotor, set: impl FnOnce(&mut Parameters) -> bool) -> bool {
        let before = run.stored();
        let taken = set(&mut run.parameters);
        Self::follow_parameters(run);
        run.own.stored_at_start += run.stored() - before;
        taken
    }

    #[inline]
    fn follow_inputs(run: &mut AnnulusCooledMotor) {
        match run.parameters.choices.drive_mode {
            DriveMode::Voltage | DriveMode::Pwm => {}
            DriveMode::Current => run.own.state.x[0] = run.inputs.current_command,
            DriveMode::Power => run.own.state.x[0] = 0.0,
        }
        match run.parameters.choices.mechanical_mode {
            MechanicalMode::FreeShaft => {}
            MechanicalMode::ImposedSpeed => run.own.state.x[1] = run.inputs.imposed_speed,
        }
    }

    fn refusal(_: &GenericTerm) -> Option<&'static str> {
        None
    }

    fn set_terms(run: &mut AnnulusCooledMotor, terms: &[GenericTerm]) -> bool {
        let taken = run.parameters.effects.take_terms(terms);
        Self::follow_parameters(run);
        taken
    }

    fn state(run: &AnnulusCooledMotor, k: usize) -> f64 {
        run.state_value(k)
    }

    fn put_state(run: &mut AnnulusCooledMotor, k: usize, value: f64) {
        run.put_state(k, value);
    }

    /// Without lag a sensor has the temperature of its node.
    fn follow_states(run: &mut AnnulusCooledMotor) {
        let (lag, sensed) = (run.parameters.effects.sensor_lag(), run.sensed());
        if lag.winding == 0.0 {
            run.own.sensors.winding = sensed.winding;
        }
        if lag.housing == 0.0 {
            run.own.sensors.housing = sensed.housing;
        }
    }

    fn moves(run: &AnnulusCooledMotor, k: usize) -> bool {
        run.moves(k)
    }

    fn is_coupled(k: usize) -> bool {
        is_coupled(k)
    }

    fn rates(run: &AnnulusCooledMotor, (): &()) -> Result<[f64; ALL], Fault> {
        match &run.own.fault {
            Some(fault) => Err(Fault(fault.clone())),
            None => Ok(run.observe(true, |now| now.rates())),
        }
    }

    fn coupled_rates_and_outputs(run: &AnnulusCooledMotor, (): &()) -> ([f64; ALL], Outputs) {
        run.observe(true, |now| (now.rates_of_heat_and_motion(), now.outputs()))
    }

    fn next_event(run: &AnnulusCooledMotor, time: f64) -> f64 {
        run.parameters.effects.next_event(time)
    }

    #[inline]
    fn next_division(run: &AnnulusCooledMotor, time: f64) -> f64 {
        if run.own.constants.eventful { Self::next_event(run, time) } else { f64::INFINITY }
    }

    fn discrete_before(run: &AnnulusCooledMotor) -> Discrete {
        Discrete { booked: run.own.terms.capacity_factor, ..Discrete::default() }
    }

    fn discrete(run: &AnnulusCooledMotor, before: &Discrete) -> Discrete {
        // At the border of a sector the direction of rotation decides.
        let ahead = NEAR_SECTOR * run.own.state.x[1].signum();
        let excess = Self::indicators(run, &()).over_temperature;
        let warming = || Self::rates(run, &()).map_or(0.0, |rates| run.warming(&rates));
        Discrete {
            sector: ((run.electrical_angle(&run.own.state) + ahead) / FRAC_PI_3).floor(),
            over_temperature: is_above(excess, warming),
            idle: run.inputs.duty == 0.0,
            booked: before.booked,
        }
    }

    fn enter_model_exchange(run: &mut AnnulusCooledMotor) {
        if let Some(network) = &mut run.own.network {
            network.forget();
        }
    }

    /// Depends on the present values only, so the outputs at the same instant use it as well.
    fn evaluate(run: &mut AnnulusCooledMotor) {
        if run.own.fault.is_none() {
            run.set_drivers(run.time);
            run.bring_network_to_inputs();
        }
    }

    /// The energy balance excludes the change of stored heat when a term changes the heat capacities.
    fn accept_step(run: &mut AnnulusCooledMotor) {
        run.book_capacity(|discrete| &mut discrete.booked);
    }

    fn excess(run: &AnnulusCooledMotor) -> f64 {
        run.own.constants.limits().excess(&run.extremes())
    }

    fn termination_reason(run: &AnnulusCooledMotor, time: f64) -> String {
        let balance = Self::balance(run, &());
        let heat = run.inputs.heat_power + run.parameters.effects.winding_heat();
        let flows = [
            balance.loss_copper + balance.loss_friction + heat,
            balance.heat_to_ambient - balance.loss_drive,
        ];
        run.own.constants.limits().sentence(&run.extremes(), time, flows)
    }

    fn passed_limit(run: &AnnulusCooledMotor) -> String {
        run.own.constants.limits().passed(&run.extremes())
    }

    fn save_rest(&self, out: &mut Vec<f64>) {
        self.network.iter().for_each(|network| network.save(out));
    }

    fn restored(run: &mut AnnulusCooledMotor, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        run.own.network = None;
        Self::follow_parameters(run);
        match &mut run.own.network {
            Some(network) => network.take_numbers(&run.parameters, next),
            None => Some(()),
        }
    }

    fn ease(run: &mut AnnulusCooledMotor, factors: [f64; 2]) {
        run.own.split.ease(factors);
        if let Some(network) = &mut run.own.network {
            network.ease(factors[0]);
        }
    }

    fn scale_tolerances(run: &mut AnnulusCooledMotor, factor: f64) {
        run.own.split.scale_tolerances(factor);
        if let Some(network) = &mut run.own.network {
            network.ease(factor);
        }
    }

    fn rejected_steps(run: &AnnulusCooledMotor) -> u64 {
        run.own.split.rejected
    }

    fn housing_heat(run: &AnnulusCooledMotor) -> Option<HousingHeat> {
        Some(run.observe(true, |now| now.step.housing_heat(&run.own.state, now.network)))
    }

    fn drivers(run: &AnnulusCooledMotor) -> Drivers {
        run.observe(false, |now| run.drivers_with(now.step.heat_flows(&run.own.state)))
    }
}
