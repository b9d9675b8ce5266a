//! Parameters without influence.

use super::{Instant, Tangent};
use crate::initial::Started;
use crate::overrides::Override;
use crate::simulate::{Bench, Drive};

impl Tangent {
    /// Whether with another change of the model the start, a rate or an output differs in any digit at the states of any row. If none
    /// does, a simulation has the same outputs; this is known in a third of its time.
    pub fn is_moved_by(&self, bench: &Bench, drive: &Drive, change: &Override) -> bool {
        // A model that cannot start is judged by its simulation.
        let Ok(Started { mut model, .. }) = bench.begin_at(drive, change, &self.unknowns) else {
            return true;
        };
        let (n, m) = (self.states, self.outputs);
        let (mut start, mut here) = (Vec::with_capacity(n), Instant::default());
        model.states(&mut start);
        start != self.at[..n]
            || (0..self.time.len()).any(|row| {
                drive.hold(model.as_mut(), bench.inputs(), row);
                model.set_states(self.time[row], &self.at[row * n..(row + 1) * n]);
                here.read(model.as_mut(), bench.outputs());
                here.rates != self.rates[row * n..(row + 1) * n]
                    || here.outputs != self.shown[row * m..(row + 1) * m]
            })
    }
}
