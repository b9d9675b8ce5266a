//! Model Exchange: the importer integrates; quantities that change only at events are constant in between.

use super::{Equations, Runtime};
use crate::exchange::{Exchange, Update, is_reached};
use crate::model::Fault;

/// Values that are constant between events.
#[derive(Clone, Copy, Debug)]
pub struct PreValues<D, const N: usize> {
    /// Time of the last event, s.
    pub since: f64,
    /// Values that the importer has set for states that are not in use.
    pub(super) still: [Option<f64>; N],
    /// The discrete states of the model.
    pub discrete: D,
}

impl<D: Default, const N: usize> Default for PreValues<D, N> {
    /// Before the first event.
    fn default() -> Self {
        PreValues { since: 0.0, still: [None; N], discrete: D::default() }
    }
}

impl<D: super::Saved, const N: usize> super::Saved for PreValues<D, N> {
    fn save(&self, out: &mut Vec<f64>) {
        self.since.save(out);
        self.still.save(out);
        self.discrete.save(out);
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        self.since.load(next)?;
        self.still.load(next)?;
        self.discrete.load(next)
    }
}

/// Indices of the coupled states in use, cached: a search through all states takes longer than their derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Followed<const N: usize> {
    places: [u8; N],
    count: usize,
}

impl<const N: usize> Default for Followed<N> {
    fn default() -> Self {
        Followed { places: [0; N], count: 0 }
    }
}

impl<const N: usize> Followed<N> {
    /// Number of these states.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Indices of these states.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        self.places.into_iter().take(self.count).map(usize::from)
    }
}

impl<M: Equations<N>, const N: usize> Runtime<M, N> {
    /// Updates the list of states in use after a change of the parameters.
    pub(super) fn follow_modes(&mut self) {
        let mut followed = Followed::default();
        for k in (0..N).filter(|&k| M::is_coupled(k) && M::moves(self, k)) {
            followed.places[followed.count] = k as u8;
            followed.count += 1;
        }
        self.followed = followed;
    }

    /// In Model Exchange, treats the present time as the first event.
    pub(super) fn hold_start(&mut self) {
        if self.pre.is_some() {
            let still = std::array::from_fn(|k| Some(M::state(self, k)));
            self.pre = Some(PreValues { still, since: 0.0, discrete: M::discrete_before(self) });
            self.update();
        }
    }
}

impl<M: Equations<N>, const N: usize> Exchange for Runtime<M, N> {
    fn enter_model_exchange(&mut self) {
        M::enter_model_exchange(self);
        self.pre = Some(PreValues::default());
        self.hold_start();
    }

    fn read_states(&self, out: &mut [f64]) {
        for (k, value) in out.iter_mut().enumerate() {
            *value = self.shown_state(k);
        }
    }

    fn write_states(&mut self, states: &[f64]) {
        for (k, &value) in states.iter().enumerate() {
            let moves = match &mut self.pre {
                Some(pre) => match &mut pre.still[k] {
                    Some(still) => {
                        *still = value;
                        false
                    }
                    None => true,
                },
                None => M::moves(self, k),
            };
            if moves {
                M::put_state(self, k, value);
            }
        }
        M::follow_states(self);
        self.outdate();
    }

    fn write_time(&mut self, time: f64) {
        if time != self.time {
            self.time = time;
            self.outdate();
        }
    }

    fn derivatives(&mut self, out: &mut [f64]) -> Result<(), Fault> {
        if self.pre.is_some() {
            M::evaluate(self);
        }
        out.copy_from_slice(&self.all_rates()?[..out.len()]);
        Ok(())
    }

    fn accept_step(&mut self) {
        M::accept_step(self);
    }

    fn update(&mut self) -> Update {
        let mut states_changed = false;
        if let Some(mut pre) = self.pre {
            for (k, still) in pre.still.iter_mut().enumerate() {
                let moves = M::moves(self, k);
                if moves != still.is_none() {
                    // A state in use follows its equation; any other keeps its value.
                    *still = (!moves).then(|| M::state(self, k));
                    states_changed = true;
                }
            }
            pre.since = self.time;
            pre.discrete = M::discrete(self, &pre.discrete);
            self.pre = Some(pre);
            M::follow_states(self);
            self.outdate();
        }
        Update { states_changed, next_event: self.next_event() }
    }

    fn next_event(&self) -> f64 {
        M::next_event(self, self.time)
    }

    fn termination_reason(&mut self) -> Option<String> {
        is_reached(M::excess(self)).then(|| M::termination_reason(self, self.time))
    }
}
