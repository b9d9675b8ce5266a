//! A listed effect in place of a law that was accepted.

use super::preference::is_as_good;
use super::{Candidate, Known, Round, alike, candidates, release};
use crate::hypothesis::Hypothesis;
use crate::linearization::Linearization;
use crate::search::{Scored, variants};

impl Round<'_> {
    /// Whether a candidate, or a variant of it in other runs, was fitted or could not be.
    pub fn has_tried(&self, scored: &Scored) -> bool {
        let failed = self.failed.iter().map(|(scored, _)| &scored.name);
        let mut all = self.candidates.iter().map(|c| &c.name).chain(failed);
        all.any(|name| variants(name) == variants(&scored.name))
    }
}

/// The round with a listed effect instead of its law, if one at the same port that was not fitted is as good. Which candidates are fitted is
/// decided to first order: where the missing effect has moved parameters far, a law, which has more numbers, follows the data to first order,
/// and a constant does so only after a fit.
pub fn listed_instead<'a>(
    point: &Linearization<'a>,
    start: &Hypothesis,
    scored: &[Scored],
    known: &Known,
    mut round: Round<'a>,
) -> Round<'a> {
    let Some(law) = round.winner().filter(|c| !c.addition().is_listed()) else { return round };
    let is_name = |c: &Candidate| c.refused.is_none() && c.addition().is_listed() && is_as_good(c, law);
    // The law says that the data do not distinguish effects of different ports.
    if round.candidates.iter().any(is_name) {
        return round;
    }
    let port = law.addition().port;
    let is_left = |s: &&Scored| s.listed && s.port == port && !round.has_tried(s);
    let left: Vec<Scored> = scored.iter().filter(is_left).cloned().collect();
    let mut more = candidates(point, start, &left, known);
    let is_instead = |own: &mut Candidate| own.refused.is_none() && is_as_good(own, law) && own.judge(point);
    let taken = more.candidates.iter_mut().position(is_instead);
    let others = taken.map_or_else(Vec::new, |k| alike(point, &more.candidates, k));
    release(&mut more.candidates, &[taken]);
    let before = round.candidates.len();
    if let Some(k) = taken {
        (round.taken, round.part) = (Some(before + k), None);
        round.alike = others.into_iter().map(|k| before + k).collect();
    }
    round.candidates.extend(more.candidates);
    round.failed.extend(more.failed);
    round
}
