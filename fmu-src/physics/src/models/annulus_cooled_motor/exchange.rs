//! The motor as those see it who integrate it themselves ([`Exchange`]).

use super::held::Held;
use super::motor::AnnulusCooledMotor;
use super::state_list::ALL;
use super::variables::Indicators;
use crate::components::commutation::Commutation;
use crate::exchange::{Exchange, Update, is_above, is_reached};
use crate::model::{Fault, Slot};
use std::f64::consts::FRAC_PI_3;

/// How near the border of a sector an electrical angle is at it, rad.
const NEAR_SECTOR: f64 = 1e-9;

impl AnnulusCooledMotor {
    /// A state or a rate by its slot.
    pub(super) fn inside(&mut self, slot: Slot) -> f64 {
        let row = slot.row as usize;
        if slot.group == Slot::STATES {
            let mut first = [0.0; ALL];
            self.read_states(&mut first[..=row]);
            first[row]
        } else {
            self.all_rates().map_or(f64::NAN, |all| all[row])
        }
    }

    /// Opens what is held anew, where the caller integrates.
    pub(super) fn hold_start(&mut self) {
        if self.held.is_some() {
            let states = std::array::from_fn(|k| self.state_value(k));
            self.held = Some(Held { states, ..Held::NONE });
            self.update();
        }
    }

    /// The event indicators ([`Indicators`]) at the present time, states and inputs.
    pub(super) fn indicate(&mut self) -> Indicators {
        let sector = match self.parameters.choices.commutation {
            Commutation::Block => (3.0 * self.electrical_angle(&self.state)).sin(),
            Commutation::EquivalentDc | Commutation::Sinusoidal => 1.0,
        };
        let hottest = self.state.temperature[0] + self.phases.hottest();
        Indicators {
            over_temperature: hottest - self.parameters.thermal.T_w_max,
            commutation_sector: sector,
            validity_limit: self.constants.limits().beyond(&self.extremes()),
        }
    }
}

impl Exchange for AnnulusCooledMotor {
    fn hand_over(&mut self) {
        if let Some(network) = &mut self.network {
            network.forget();
        }
        self.held = Some(Held::NONE);
        self.hold_start();
    }

    fn read_states(&self, out: &mut [f64]) {
        for (k, value) in out.iter_mut().enumerate() {
            *value = match &self.held {
                Some(held) if !held.moving[k] => held.states[k],
                _ => self.state_value(k),
            };
        }
    }

    fn write_states(&mut self, states: &[f64]) {
        for (k, &value) in states.iter().enumerate() {
            let moves = match &mut self.held {
                Some(held) => {
                    held.states[k] = value;
                    held.moving[k]
                }
                None => self.moves(k),
            };
            if moves {
                self.put_state(k, value);
            }
        }
        self.follow_states();
    }

    fn write_time(&mut self, time: f64) {
        if time != self.time {
            self.time = time;
            self.outdate();
        }
    }

    fn derivatives(&mut self, out: &mut [f64]) -> Result<(), Fault> {
        if self.held.is_some() && self.fault.is_none() {
            // What is evaluated here depends on the present values alone; it serves the outputs at the same point as well.
            self.tell_effects(self.time);
            self.bring_network_to_inputs();
        }
        let all = self.all_rates()?;
        out.copy_from_slice(&all[..out.len()]);
        Ok(())
    }

    fn accept_step(&mut self) {
        self.tell_effects(self.time);
        if let Some(mut held) = self.held {
            // What the capacities hold more or less because a term has changed them is no error of the books.
            let heat = self.constants.heat(&self.state.temperature, self.t_start);
            self.stored_at_start += heat - heat * held.booked / self.capacity_factor;
            held.booked = self.capacity_factor;
            self.held = Some(held);
            self.outdate();
        }
    }

    fn update(&mut self) -> Update {
        let Some(mut held) = self.held else {
            return Update { states_changed: false, next_event: f64::INFINITY };
        };
        let mut states_changed = false;
        for k in 0..ALL {
            let moves = self.moves(k);
            if moves != held.moving[k] {
                // From here on the node, or what the mode keeps in its place, decides.
                (held.states[k], held.moving[k]) = (self.state_value(k), moves);
                states_changed = true;
            }
        }
        held.since = self.time;
        held.idle = self.inputs.duty == 0.0;
        // At the border of a sector, where the rotor is heading decides.
        let ahead = NEAR_SECTOR * self.state.x[1].signum();
        held.sector = ((self.electrical_angle(&self.state) + ahead) / FRAC_PI_3).floor();
        let excess = self.indicate().over_temperature;
        held.over_temperature = is_above(excess, self.all_rates().map_or(0.0, |rates| self.warming(&rates)));
        self.held = Some(held);
        self.follow_states();
        Update { states_changed, next_event: Exchange::next_event(self) }
    }

    fn next_event(&self) -> f64 {
        self.parameters.effects.next_event(self.time)
    }

    fn ending(&mut self) -> Option<String> {
        let is_over = is_reached(self.constants.limits().beyond(&self.extremes()));
        is_over.then(|| self.ending_sentence(self.time))
    }
}
