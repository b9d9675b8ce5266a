//! The second effect of two: of two that only together predict better, and of two in place of one law.

use super::{Known, LEAST, Round, candidates, release};
use crate::hypothesis::Hypothesis;
use crate::linearization::Linearization;
use crate::search::Scored;

/// The effect beside one that explains most, but predicts worse alone: of all candidates the one that explains most and predicts better. Both
/// together have to explain as much as one effect, so that [`LEAST`] is enough.
pub fn companion<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &[Scored],
    known: &Known,
) -> Round<'a> {
    let mut round = candidates(point, start, scored, known);
    round.taken = round.candidates.iter_mut().position(|c| c.refused.is_none() && c.judge_for(point, LEAST));
    round.excuse = Some("of all candidates, both together explain most");
    release(&mut round.candidates, &[round.taken]);
    round
}

/// What stands beside a physical element in place of a law: of the candidates that pass and explain at least this much, a physical element if
/// there is one, else a law of one present driver.
pub fn beside<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &[Scored],
    known: &Known,
    least: f64,
) -> Round<'a> {
    let mut round = candidates(point, start, scored, known);
    let mut eligible: Vec<usize> = (0..round.candidates.len()).collect();
    eligible.retain(|k| {
        let own = &round.candidates[*k];
        own.refused.is_none() && own.sure() >= least && (own.addition().is_element() || own.is_simple())
    });
    eligible.sort_by_key(|k| !round.candidates[*k].addition().is_element());
    round.taken = eligible.into_iter().find(|k| round.candidates[*k].judge(point));
    round.excuse = Some("together with what comes before it explains as much as a law");
    release(&mut round.candidates, &[round.taken]);
    round
}
