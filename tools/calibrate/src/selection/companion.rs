//! The second effect of two that only together predict better.

use super::{LEAST, Round, candidates, release};
use crate::hypothesis::Hypothesis;
use crate::levels::STRUCTURE;
use crate::linearization::Linearization;
use crate::search::Scored;

/// The effect beside one that explains most, but predicts worse alone: of all candidates the one with the smallest validation error, a listed
/// effect if it predicts as well up to structure error. Both together have to explain as much as one effect, so that [`LEAST`] is enough.
pub fn companion<'a>(point: &Linearization<'a>, start: &Hypothesis, scored: &[Scored]) -> Round<'a> {
    let mut round = candidates(point, start, scored);
    let mut least = f64::INFINITY;
    for (k, candidate) in round.candidates.iter_mut().enumerate() {
        if candidate.refused.is_some() || !candidate.judge_for(point, LEAST) {
            continue;
        }
        let law = if candidate.addition().is_listed() { 1.0 } else { 1.0 + STRUCTURE };
        if let Some(worth) = candidate.validation.map(|ratio| law * ratio).filter(|worth| *worth < least) {
            (least, round.taken) = (worth, Some(k));
        }
    }
    round.excuse = Some("of all candidates, both together predict best");
    release(&mut round.candidates, &[round.taken]);
    round
}
