//! The motor as a model: parameters, inputs, and the state it has reached.

use super::equations::{Constants, NODES, Step, Temperatures};
use super::held::Held;
use super::network::{Body, Network};
use super::parameters::Parameters;
use super::state_list::{Followed, STATES};
use super::variables::{Books, DriveMode, Indicators, Inputs, MechanicalMode, Outputs};
use crate::components::commutation::Phases;
use crate::components::validity::Extremes;
use crate::effects::{IMMINENT, PerNode, Port};
use crate::ending::{Halt, approach};
use crate::groups;
use crate::model::{Declaration, Declared, Fault, HousingHeat, Model, ModelType, Slot};
use crate::solver::split::{Split, State};
use crate::terms::{Drivers, GenericTerm, MOST_TERMS};

/// The motor: parameters, inputs, and the state it has reached.
#[derive(Clone, Debug)]
pub struct AnnulusCooledMotor {
    /// What the importer sets.
    pub inputs: Inputs,
    pub(super) outputs: Outputs,
    pub(super) books: Books,
    pub(super) indicators: Indicators,
    /// What the motor is made of.
    pub parameters: Parameters,
    pub(super) constants: Constants,
    /// The fan command and the conductance that belongs to it: a power costs as much as half a step.
    pub(super) fan: (f64, PerNode),
    pub(super) slopes: Inputs,
    pub(super) time: f64,
    pub(super) state: State<NODES>,
    /// The temperature that the housing's sensor has reached, K.
    pub(super) t_sensor: f64,
    /// What the lag of each term has reached, in the unit of its driver.
    pub(super) term_lags: [f64; MOST_TERMS],
    /// The temperature at the start, K; stored heat counts from it.
    pub(super) t_start: f64,
    /// Multiplies the heat capacities of [`Constants`].
    pub(super) capacity_factor: f64,
    /// Energy stored at the start, J.
    pub(super) stored_at_start: f64,
    pub(super) split: Split<NODES>,
    /// How far each phase is above the mean winding.
    pub(super) phases: Phases,
    /// The heat beyond winding and stator, where the mode of cooling has any.
    pub(super) network: Option<Network>,
    /// What is held between events, where the caller integrates.
    pub(super) held: Option<Held>,
    /// What those who fit see of the states.
    pub(super) followed: Followed,
    /// What is wrong with the parameters taken together.
    pub(super) fault: Option<String>,
    /// Whether the last step ended at a limit of validity.
    pub(super) ended: bool,
    pub(super) outputs_are_stale: bool,
    pub(super) books_are_stale: bool,
}

groups! {
    AnnulusCooledMotor {
        "" @ 0 => inputs: Inputs,
        "" @ 0 => outputs: Outputs,
        "" @ 0 => books: Books,
        "event." @ 0 => indicators: Indicators,
    } then parameters: Parameters
}

/// Index of the inputs in the list of groups.
const INPUTS: usize = 0;
/// Index of the outputs in the list of groups.
const OUTPUTS: usize = 1;
/// Last of the outputs that are states and shown as they are: current, shaft_angle and shaft_speed come first.
const LAST_STATE: usize = 2;
/// Rows of the outputs that sensors of winding and housing indicate.
pub(super) const WINDING_SENSOR: usize = 4;
pub(super) const HOUSING_SENSOR: usize = 7;
/// Index of the flows of power in the list of groups.
const BOOKS: usize = 2;
/// Index of the event indicators in the list of groups; parameters follow.
const INDICATORS: usize = 3;

impl Default for AnnulusCooledMotor {
    fn default() -> Self {
        let parameters = Parameters::default();
        AnnulusCooledMotor {
            inputs: Inputs::default(),
            outputs: Outputs::default(),
            books: Books::default(),
            indicators: Indicators::default(),
            parameters,
            constants: Constants::of(&parameters),
            fan: (f64::NAN, PerNode::default()),
            slopes: Inputs::ZERO,
            time: 0.0,
            state: State::default(),
            t_sensor: 0.0,
            term_lags: [0.0; MOST_TERMS],
            t_start: 0.0,
            capacity_factor: 1.0,
            stored_at_start: 0.0,
            split: Split::default(),
            phases: Phases::default(),
            network: None,
            held: None,
            followed: Followed::default(),
            fault: None,
            ended: false,
            outputs_are_stale: true,
            books_are_stale: true,
        }
    }
}

impl AnnulusCooledMotor {
    /// The model in the list of models.
    pub const TYPE: ModelType = ModelType { declaration: Self::declared, new: || Box::new(Self::default()) };

    fn declared() -> &'static Declaration {
        static DECLARED: Declared = Declared::new();
        DECLARED.get_or_init(|| {
            Declaration::new(
                "AnnulusCooledMotor",
                "Thermo-electromechanical motor with thermal network and cooling: electrical terminals, shaft, winding and housing temperature",
                Self::groups(),
                STATES,
                &[],
            )
        })
    }

    /// The state at the present time: current, A, speed, rad/s, angle, rad, temperatures, K, energies, J.
    pub fn state(&self) -> &State<NODES> {
        &self.state
    }

    /// The equations over the next step, with the inputs on their slopes.
    pub fn step_equations(&mut self) -> Step<'_> {
        self.tell_effects(self.time);
        self.follow_cooling();
        self.equations()
    }

    /// Brings what the model keeps of the cooling to the inputs.
    #[inline]
    pub(super) fn follow_cooling(&mut self) {
        if self.network.is_some() {
            self.bring_network_to_inputs();
        } else if self.fan.0 != self.inputs.fan_command {
            self.fan = (self.inputs.fan_command, self.parameters.to_ambient(self.inputs.fan_command));
        }
    }

    /// The equations with the cooling as it is kept.
    #[inline]
    pub(super) fn equations(&self) -> Step<'_> {
        let is_kept = self.network.is_some() || self.fan.0 == self.inputs.fan_command;
        let fan = if is_kept { self.fan.1 } else { self.parameters.to_ambient(self.inputs.fan_command) };
        let step = Step::new(&self.parameters, &self.constants, &self.inputs, &self.slopes, fan, self.time)
            .with_excess(self.excess());
        let step = match &self.held {
            Some(held) => step.with_strength_since(held.since).with_open_switches(held.idle),
            None => step,
        };
        if self.network.is_some() { step.within(self.beyond()) } else { step }
    }

    /// Energy in all stores, J.
    pub(super) fn stored(&self) -> f64 {
        let state = self.state;
        let beyond = self.network.as_ref().map_or(0.0, |n| n.stored(self.t_start));
        self.equations().stored(&state, self.t_start) + beyond
    }

    /// Draws the consequences of parameters that were written.
    pub(super) fn follow_parameters(&mut self) {
        self.constants = Constants::of(&self.parameters).with_capacity(self.capacity_factor);
        self.fan = (f64::NAN, PerNode::default());
        self.fault = Body::fault(&self.parameters);
        let body = Body::of(&self.parameters);
        self.network = match (self.network.take(), body) {
            (Some(mut network), Some(body)) if network.body.segments == body.segments => {
                network.follow(&self.parameters, body);
                Some(network)
            }
            // A network that comes anew stands at the temperature of what it grows from.
            (_, Some(body)) => Some(Network::new(&self.parameters, body, self.state.temperature[1])),
            (_, None) => None,
        };
        self.followed = Followed::of(self);
    }

    /// What `look` sees at the present time with the effects told and, if `cooled`, the cooling by its full equations. The motor
    /// stays as it is: the linearized cooling and the values that effects hold belong to the steps, and reading decides nothing
    /// about them.
    pub(super) fn observe<T>(&self, cooled: bool, look: impl FnOnce(&Self) -> T) -> T {
        let is_told = self.parameters.effects.acts_at(Port::Any);
        let is_cooled = self.network.as_ref().is_none_or(|n| {
            self.held.is_some() && n.is_evaluated_at(&self.inputs, self.ambient(self.time).start)
        });
        if !is_told && (is_cooled || !cooled) {
            return look(self);
        }
        let mut copy = self.clone();
        copy.tell_effects(copy.time);
        copy.evaluate_cooling();
        look(&copy)
    }

    fn outputs_now(&self) -> Outputs {
        let mut outputs = self.observe(false, |m| m.equations().outputs(&m.state, m.t_sensor, &m.phases));
        if let Some(held) = &self.held {
            outputs.over_temperature = held.over_temperature;
        }
        outputs
    }

    fn books_now(&self) -> Books {
        self.observe(true, |m| {
            m.equations().books(&m.state, (m.t_start, m.stored_at_start), m.network.as_ref())
        })
    }

    /// Outputs that are states.
    #[inline]
    pub(super) fn show_straight(&mut self) {
        (self.outputs.current, self.outputs.shaft_speed) = (self.state.x[0], self.state.x[1]);
        self.outputs.shaft_angle = self.state.angle;
    }

    /// Outputs of the sensors, which need no equations of the motor.
    #[inline]
    fn show_sensors(&mut self) {
        let (effects, ambient) = (&self.parameters.effects, self.ambient(self.time).start);
        self.outputs.winding_temperature = effects.winding_sensor(self.state.temperature[0], ambient);
        self.outputs.housing_temperature = effects.housing_sensor(self.t_sensor, ambient);
    }

    /// The state, an input or a parameter has changed.
    #[inline]
    pub(super) fn outdate(&mut self) {
        (self.outputs_are_stale, self.books_are_stale) = (true, true);
    }

    /// The current and the speed that the inputs dictate replace those of the state.
    #[inline]
    pub(super) fn follow_inputs(&mut self) {
        match self.parameters.choices.drive_mode {
            DriveMode::Voltage | DriveMode::Pwm => {}
            DriveMode::Current => self.state.x[0] = self.inputs.current_command,
            DriveMode::Power => self.state.x[0] = 0.0,
        }
        match self.parameters.choices.mechanical_mode {
            MechanicalMode::FreeShaft => {}
            MechanicalMode::ImposedSpeed => self.state.x[1] = self.inputs.imposed_speed,
        }
        self.outdate();
    }

    /// A step, cut at the events within it.
    pub(super) fn step_over_events(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        if !self.constants.eventful {
            return self.advance(time, h);
        }
        let end = time + h;
        let event = self.parameters.effects.next_event(time);
        if event < end - IMMINENT {
            // An event within the step: up to it and on from it, or nothing of both.
            let (before, slopes) = (self.clone(), self.slopes);
            let outcome = self.advance(time, event - time).and_then(|()| {
                self.slopes = slopes;
                self.step_over_events(event, end - event)
            });
            match outcome {
                Ok(()) => self.time = end,
                Err(_) => *self = before,
            }
            return outcome;
        }
        self.advance(time, h)
    }

    /// The temperatures that are limited.
    pub(super) fn extremes(&self) -> Extremes {
        let [winding, core] = [self.state.temperature[0], self.state.temperature[1]];
        let magnets = self.network.as_ref().map_or(core, Network::rotor_temperature);
        Extremes { winding: winding + self.phases.hottest(), magnets, lowest: winding.min(magnets) }
    }

    /// Why the run ends at `time`, s.
    pub(super) fn ending_sentence(&self, time: f64) -> String {
        let books = self.books_now();
        let heat = self.inputs.heat_power + self.parameters.effects.winding_heat();
        let flows =
            [books.loss_copper + books.loss_friction + heat, books.heat_to_ambient - books.loss_drive];
        self.constants.limits().sentence(&self.extremes(), time, flows)
    }
}

impl Model for AnnulusCooledMotor {
    fn declaration(&self) -> &'static Declaration {
        Self::declared()
    }

    #[inline]
    fn get(&mut self, slot: Slot) -> f64 {
        let row = slot.row as usize;
        match slot.group as usize {
            OUTPUTS if self.outputs_are_stale => match row {
                // What a coupled system reads at every step costs nothing.
                0..=LAST_STATE => self.show_straight(),
                WINDING_SENSOR | HOUSING_SENSOR if !self.parameters.effects.acts_at(Port::Any) => {
                    self.show_sensors();
                }
                _ => (self.outputs, self.outputs_are_stale) = (self.outputs_now(), false),
            },
            BOOKS if self.books_are_stale => {
                (self.books, self.books_are_stale) = (self.books_now(), false);
            }
            INDICATORS => self.indicators = self.indicate(),
            _ if slot.group >= Slot::STATES => return self.inside(slot),
            _ => {}
        }
        self.value(slot.group as usize, row)
    }

    #[inline]
    fn set(&mut self, slot: Slot, value: f64) -> bool {
        let group = slot.group as usize;
        if group <= INDICATORS {
            let taken = self.set_value(group, slot.row as usize, value);
            self.follow_inputs();
            return taken;
        }
        // A parameter that changes on the way changes what the stores hold; the books start anew from there.
        let before = self.stored();
        let taken = self.set_value(group, slot.row as usize, value);
        self.follow_parameters();
        self.stored_at_start += self.stored() - before;
        self.follow_inputs();
        taken
    }

    fn set_slope(&mut self, slot: Slot, slope: f64) {
        debug_assert_eq!(slot.group as usize, INPUTS);
        declare::Group::set(&mut self.slopes, slot.row as usize, slope);
        self.outdate();
    }

    fn slope(&self, slot: Slot) -> f64 {
        declare::Group::get(&self.slopes, slot.row as usize)
    }

    fn set_terms(&mut self, terms: &[GenericTerm]) -> bool {
        let taken = self.parameters.effects.take_terms(terms);
        self.follow_parameters();
        self.outdate();
        taken
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        let parameters = &self.parameters;
        let fault = Body::fault(parameters).or_else(|| parameters.initial.fault(&parameters.limits()));
        if let Some(fault) = fault {
            return Err(Fault(fault));
        }
        self.time = time;
        let mut ambient = self.inputs.ambient_temperature + self.parameters.effects.ambient_sensor() * time;
        self.state = State { temperature: Temperatures::repeat(ambient), ..State::default() };
        self.split = Split::default();
        self.phases = Phases::default();
        self.network = None;
        self.follow_parameters();
        self.follow_inputs();
        self.tell_effects(time);
        ambient += self.parameters.effects.ambient_offset();
        self.state.temperature = Temperatures::repeat(ambient);
        self.t_start = ambient;
        // Anew, because a network starts at the temperature that the state has.
        self.network = None;
        self.follow_parameters();
        self.put_initial(ambient);
        // Terms may follow the initial temperatures.
        self.tell_effects(time);
        self.start_lags();
        self.stored_at_start = self.stored();
        self.hold_start();
        Ok(())
    }

    fn step(&mut self, time: f64, h: f64) -> Result<(), Fault> {
        self.ended = false;
        let slopes = self.slopes;
        let Err(halt) = self.step_over_events(time, h) else { return Ok(()) };
        let at = approach(self, (time, h), halt, |motor, at, h| {
            motor.slopes = slopes;
            motor.step_over_events(at, h)
        })?;
        (self.ended, self.slopes) = (true, Inputs::ZERO);
        Err(Fault(self.ending_sentence(at)))
    }

    fn ended(&self) -> bool {
        self.ended
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn save(&self, out: &mut Vec<f64>) {
        self.push_saved(out);
    }
    fn restore(&mut self, saved: &[f64]) -> bool {
        match self.with_saved(saved) {
            Some(restored) => {
                *self = restored;
                true
            }
            None => false,
        }
    }

    fn states(&self, out: &mut Vec<f64>) {
        self.push_states(out);
    }

    fn set_states(&mut self, time: f64, states: &[f64]) -> bool {
        let taken = self.take_states(states);
        if taken {
            self.time = time;
        }
        taken
    }

    fn rates(&mut self, out: &mut Vec<f64>) {
        self.push_rates(out);
    }

    fn scale_tolerances(&mut self, factor: f64) {
        self.split.scale_tolerances(factor);
        if let Some(network) = &mut self.network {
            network.ease(factor);
        }
    }

    fn rejected_steps(&self) -> u64 {
        self.split.rejected
    }

    fn ease(&mut self, factor: f64) {
        self.split.ease(factor);
        if let Some(network) = &mut self.network {
            network.ease(factor);
        }
    }

    fn housing_heat(&mut self) -> Option<HousingHeat> {
        Some(self.observe(true, |m| m.equations().housing_heat(&m.state, m.network.as_ref())))
    }

    fn drivers(&self) -> Drivers {
        self.observe(false, Self::drivers_with_heat)
    }

    crate::copies!();
}
