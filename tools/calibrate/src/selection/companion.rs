//! The second effect of two that only together predict better.

use super::{LEAST, Round, candidates, release};
use crate::hypothesis::Hypothesis;
use crate::linearization::Linearization;
use crate::search::Scored;

/// The effect beside one that explains most, but predicts worse alone: of all candidates the one that explains most and predicts better. Both
/// together have to explain as much as one effect, so that [`LEAST`] is enough.
pub fn companion<'a>(point: &Linearization<'a>, start: &Hypothesis, scored: &[Scored]) -> Round<'a> {
    let mut round = candidates(point, start, scored);
    round.taken = round.candidates.iter_mut().position(|c| c.refused.is_none() && c.judge_for(point, LEAST));
    round.excuse = Some("of all candidates, both together explain most");
    release(&mut round.candidates, &[round.taken]);
    round
}
