//! The gearmotor as those see it who integrate it themselves ([`Exchange`]): its states, all of which always move,
//! and its events.

use super::{BrushedGearmotor, ENERGIES, Indicators, NODES, STATES, State, Step};
use crate::effects::Effect;
use crate::exchange::{Exchange, Update, is_above, is_reached};
use crate::model::{Fault, Slot};
use declare::{Unit, states};

states! {
    /// The states of the gearmotor, in the order of [`Step::rates`].
    pub const LIST = {
        /// Mean current in the winding
        "state.current" = declare::State::new(701, 801, Unit::Ampere),
        /// Speed of the output shaft
        "state.shaft_speed" = declare::State::new(702, 802, Unit::RadianPerSecond).nominal(10.0),
        /// Angle of the output shaft since the start
        "state.shaft_angle" = declare::State::new(703, 803, Unit::Radian).nominal(100.0),
        /// Temperature of the winding
        "state.winding_temperature" = declare::State::new(704, 804, Unit::Kelvin).nominal(300.0),
        /// Temperature of the housing, with magnets and gear
        "state.housing_temperature" = declare::State::new(705, 805, Unit::Kelvin).nominal(300.0),
        /// Temperature of the box, air and walls
        "state.box_temperature" = declare::State::new(706, 806, Unit::Kelvin).nominal(300.0),
        /// Energy taken from the supply since the start
        "state.energy_supply" = declare::State::new(707, 807, Unit::Joule).nominal(1000.0),
        /// Energy given to the load since the start
        "state.energy_shaft" = declare::State::new(708, 808, Unit::Joule).nominal(1000.0),
        /// Heat given to the surroundings since the start
        "state.energy_heat_to_ambient" = declare::State::new(709, 809, Unit::Joule).nominal(1000.0),
        /// Heat set free in the winding since the start
        "state.work_electrical" = declare::State::new(710, 810, Unit::Joule).nominal(100.0),
        /// Heat of friction since the start
        "state.work_friction" = declare::State::new(711, 811, Unit::Joule).nominal(100.0),
    }
}

/// Place of the winding's temperature.
const WINDING: usize = 3;

/// What is held between events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held {
    /// Time of the last event, s.
    since: f64,
    /// Sign of the duty at the last event.
    direction: f64,
    /// Whether the winding was above its limit at the last event.
    pub over_temperature: bool,
}

impl Held {
    const NONE: Held = Held { since: 0.0, direction: 0.0, over_temperature: false };

    /// What a saved instance must hold.
    pub fn to_numbers(self) -> [f64; 3] {
        [self.since, self.direction, f64::from(u8::from(self.over_temperature))]
    }

    /// Takes back what [`to_numbers`](Held::to_numbers) gave.
    pub fn from_numbers([since, direction, over]: [f64; 3]) -> Held {
        Held { since, direction, over_temperature: over != 0.0 }
    }

    /// The equations with the bridge and the magnets as the last event has left them. A duty that has just left
    /// zero has the direction in which it left.
    pub fn applied<'a>(&self, step: Step<'a>, duty: f64) -> Step<'a> {
        let direction = if self.direction == 0.0 && duty != 0.0 { duty.signum() } else { self.direction };
        step.with_events(direction, self.since)
    }
}

impl BrushedGearmotor {
    /// Opens what is held anew, where the caller integrates.
    pub(super) fn hold_start(&mut self) {
        if self.held.is_some() {
            self.held = Some(Held::NONE);
            self.update();
        }
    }

    /// The event indicators at the present time, states and inputs.
    pub(super) fn indicate(&self) -> Indicators {
        let over_temperature = self.state.temperature[0] - self.parameters.thermal.T_w_max;
        Indicators {
            over_temperature,
            bridge_direction: self.inputs.duty,
            validity_limit: self.constants.limits().beyond(&self.extremes()),
        }
    }

    fn all_states(&self) -> [f64; STATES] {
        let mut all = [0.0; STATES];
        all[..2].copy_from_slice(self.state.x.as_slice());
        all[2] = self.state.angle;
        all[3..3 + NODES].copy_from_slice(self.state.temperature.as_slice());
        all[3 + NODES..].copy_from_slice(&self.state.energy);
        all
    }

    fn put_states(&mut self, all: &[f64; STATES]) {
        self.state = State {
            x: crate::solver::split::Fast::new(all[0], all[1]),
            angle: all[2],
            temperature: std::array::from_fn::<f64, NODES, _>(|k| all[3 + k]).into(),
            energy: std::array::from_fn::<f64, ENERGIES, _>(|k| all[3 + NODES + k]),
            ..self.state
        };
        self.outputs_are_stale = true;
    }

    fn all_rates(&self) -> [f64; STATES] {
        self.step_equations().rates(0.0, &self.all_states())
    }

    /// A state or a rate by its slot.
    pub(super) fn inside(&self, slot: Slot) -> f64 {
        let all = if slot.group == Slot::STATES { self.all_states() } else { self.all_rates() };
        all[slot.row as usize]
    }
}

impl Exchange for BrushedGearmotor {
    fn hand_over(&mut self) {
        self.held = Some(Held::NONE);
        self.update();
    }

    fn read_states(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.all_states()[..out.len()]);
    }

    fn write_states(&mut self, states: &[f64]) {
        let mut all = self.all_states();
        all[..states.len()].copy_from_slice(states);
        self.put_states(&all);
    }

    fn write_time(&mut self, time: f64) {
        if time != self.time {
            self.time = time;
            self.outputs_are_stale = true;
        }
    }

    fn derivatives(&mut self, out: &mut [f64]) -> Result<(), Fault> {
        out.copy_from_slice(&self.all_rates()[..out.len()]);
        Ok(())
    }

    fn accept_step(&mut self) {}

    fn update(&mut self) -> Update {
        if self.held.is_some() {
            let duty = self.inputs.duty;
            self.held = Some(Held {
                since: self.time,
                direction: if duty == 0.0 { 0.0 } else { duty.signum() },
                over_temperature: is_above(self.indicate().over_temperature, self.all_rates()[WINDING]),
            });
            self.outputs_are_stale = true;
        }
        Update { states_changed: false, next_event: Exchange::next_event(self) }
    }

    fn next_event(&self) -> f64 {
        self.parameters.effects.next_event(self.time)
    }

    fn ending(&mut self) -> Option<String> {
        let is_over = is_reached(self.constants.limits().beyond(&self.extremes()));
        is_over.then(|| self.ending_sentence(self.time))
    }
}
