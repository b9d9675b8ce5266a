//! The gearmotor as those see it who integrate it themselves ([`Exchange`]): its states, all of which always move,
//! and its events.

use super::equations::{ENERGIES, STATES, State};
use super::held::Held;
use super::motor::BrushedGearmotor;
use super::states::NODES;
use super::variables::Indicators;
use crate::exchange::{Exchange, Update, is_above, is_reached};
use crate::model::{Fault, Slot};

/// Place of the winding's temperature.
const WINDING: usize = 3;

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
