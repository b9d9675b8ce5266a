//! A time in a shorter unit than that of its column.

use super::mistakes::{Mistake, mistakes};
use super::search::{FALL, spoils};
use super::{Judge, MOST_OFF, Unusable, cost::fitted, score, worst};
use crate::CalibrateError;
use crate::experiment::{Experiment, LONGEST_RUN};
use crate::levels::{PART, SMALL};

/// Factor of time below which a preset of another size is no explanation. Limit: time constants of motors differ by tens, not by hundreds.
const ANOTHER_SIZE: f64 = 1e-2;

/// The time of every run (`of` is `None`) or of one file, if it is too long: no run of a bench lasts as long, or the model agrees with the
/// data in a shorter unit only. It makes every simulation of the data as they are long, and is therefore looked for before anything is
/// fitted to them.
pub(super) fn wrong_time(
    whole: &Judge,
    experiment: &Experiment,
    of: Option<(&str, &[usize])>,
) -> Result<Option<Unusable>, CalibrateError> {
    let (files, runs, most) =
        of.map_or(("every run", whole.runs, ANOTHER_SIZE), |(file, runs)| (file, runs, SMALL));
    let judge = &Judge { runs, ..whole.clone() };
    let spans = runs.iter().map(|run| experiment.runs[*run].table.span());
    let shortest = spans.fold(f64::INFINITY, f64::min);
    let before = match shortest > LONGEST_RUN {
        true => vec![Some((MOST_OFF, f64::NAN)); experiment.outputs.len()],
        false => judge.outputs(experiment, &judge.predicted(experiment)),
    };
    let is_shorter = |m: &Mistake| matches!(m, Mistake::Time(factor, _) if *factor < most);
    let mut likely: Vec<(f64, Mistake, Experiment)> = Vec::new();
    for mistake in mistakes(experiment).into_iter().filter(|m| worst(&before) > PART && is_shorter(m)) {
        let mut data = experiment.clone();
        mistake.apply(&mut data, judge.runs);
        let after = judge.outputs(&data, &judge.predicted(&data));
        let fall = score(&after) - score(&before);
        if fall < -FALL && !spoils(&before, &after) {
            likely.push((fall, mistake, data));
        }
    }
    // The preset may be far from the motor: the fit decides, and no parameter makes up for such a factor.
    likely.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, mistake, data) in likely {
        let as_meant = fitted(whole, &data)?;
        if !as_meant.is_cut && as_meant.follows_all() {
            let (channel, reason, suggestion) = mistake.words(experiment, files);
            return Ok(Some(Unusable::new(&channel, reason, suggestion)));
        }
    }
    Ok((shortest > LONGEST_RUN).then(|| {
        let days = |seconds: f64| seconds / 86_400.0;
        Unusable::new(
            "time_s",
            format!(
                "{files} lasts {:.0} days or more by time_s; no run of a bench lasts longer than {:.0} days",
                days(shortest),
                days(LONGEST_RUN)
            ),
            "[columns] states the unit of the time, such as { name = \"time\", unit = \"ms\" }",
        )
    }))
}
