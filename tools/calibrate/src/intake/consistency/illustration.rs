//! Readings that contradict the model, for a figure: as recorded, as predicted and as corrected.

use super::Mistake;
use crate::deadline::Deadline;
use crate::experiment::{Channel, Experiment, Role};
use crate::intake::{Unusable, predicted};

/// A run with readings that contradict the model. Temperatures in degC.
#[derive(Clone, Debug, PartialEq)]
pub struct Illustration {
    /// Its file.
    pub file: String,
    /// Times since the first row, s.
    pub time: Vec<f64>,
    /// The change of the readings that would agree, in words, if it is one of a unit, a factor or a sign.
    pub change: Option<String>,
    /// The channels, the contradicting ones first.
    pub channels: Vec<Illustrated>,
}

/// One channel of an [`Illustration`]; values that are not known are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Illustrated {
    /// The column.
    pub column: &'static str,
    /// Readings as recorded.
    pub recorded: Vec<f64>,
    /// The same after the correction.
    pub corrected: Option<Vec<f64>>,
    /// Prediction of the preset with the inputs as recorded.
    pub predicted: Option<Vec<f64>>,
    /// The same with the corrected inputs.
    pub predicted_corrected: Option<Vec<f64>>,
}

/// The readings of the channel that make an experiment, as read, unusable: of the file that the reason names, else of the first fit run.
/// `None` where the reason is about no channel.
pub fn illustration(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    why: &Unusable,
    deadline: &Deadline,
) -> Option<Illustration> {
    let all: Vec<&'static Channel> = experiment.inputs.iter().chain(&experiment.outputs).copied().collect();
    let inputs = experiment.inputs.len();
    let place = all.iter().position(|c| c.column == why.channel)?;
    let named = experiment.runs.iter().find(|run| why.reason.contains(&run.file));
    let run = named.or_else(|| experiment.runs.iter().find(|run| run.role == Role::Fit))?;
    let alone = Experiment { runs: vec![run.clone()], ..experiment.clone() };
    // Corrected values of these require the model.
    let is_drawn =
        |mistake: &&Mistake| mistake.implied_by().is_none() && !matches!(mistake, Mistake::Magnitude(_));
    let mistake = why.mistake.as_deref().filter(is_drawn);
    let meant = mistake.map(|mistake| {
        let mut meant = alone.clone();
        mistake.apply(&mut meant, &[0]);
        meant
    });
    let mut touched = mistake.map_or_else(|| vec![place], Mistake::touches);
    // An input is judged by the outputs, which follow.
    if touched.iter().any(|k| *k < inputs) {
        let others: Vec<usize> = (inputs..all.len()).filter(|k| !touched.contains(k)).collect();
        touched.extend(others);
    }
    let simulated = |data: &Experiment| predicted(data, preset, &[0], deadline).pop().unwrap_or_default();
    let as_recorded = simulated(&alone);
    let as_meant = meant.as_ref().map(simulated);
    let rows = run.table.drawn();
    let drawn = |column: &[f64], k: usize| -> Option<Vec<f64>> {
        let values: Vec<f64> = rows.iter().map(|row| column[*row] - all[k].offset).collect();
        values.iter().any(|x| x.is_finite()).then_some(values)
    };
    let output = |k: usize, of: &[Vec<f64>]| drawn(of.get(k.checked_sub(inputs)?)?, k);
    let channel = |k: usize| {
        let recorded = drawn(&run.table.columns[k], k);
        let corrected = meant.as_ref().and_then(|m| drawn(&m.runs[0].table.columns[k], k));
        let (before, after) = (output(k, &as_recorded), as_meant.as_ref().and_then(|m| output(k, m)));
        Some(Illustrated {
            column: all[k].column,
            corrected: corrected.filter(|_| mistake.is_some_and(|m| m.touches().contains(&k))),
            predicted_corrected: if before == after { None } else { after },
            recorded: recorded?,
            predicted: before,
        })
    };
    let first = run.table.time[0];
    Some(Illustration {
        file: run.file.clone(),
        time: rows.iter().map(|row| run.table.time[*row] - first).collect(),
        change: mistake.and_then(Mistake::change).map(str::to_owned),
        channels: touched.into_iter().filter_map(channel).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::mistakes::mistakes;
    use super::*;
    use crate::experiment::CELSIUS;
    use crate::testing;

    fn why(mistake: &Mistake, experiment: &Experiment) -> Unusable {
        let (channel, reason, suggestion) = mistake.words(experiment, "every run");
        Unusable { mistake: Some(Box::new(mistake.clone())), ..Unusable::new(&channel, reason, suggestion) }
    }

    /// The correction of each unit mistake, and of a factor that is no unit, brings the readings to the prediction.
    #[test]
    fn readings_are_drawn_as_recorded_and_as_meant() {
        let mut right = testing::experiment(testing::PRIORS, true);
        let preset = crate::setup::Setup::new(&right, &[]).unwrap().preset().declared;
        testing::read(&mut right, &preset, None);
        let inputs = right.inputs.len();
        let winding = right.outputs.iter().position(|c| c.is_temperature()).unwrap();
        let words = "readings times 3.000".to_string();
        let factor = Mistake::Affine { columns: vec![inputs + winding], factor: 3.0, offset: 0.0, words };
        for mistake in mistakes(&right).into_iter().chain([factor]) {
            let Mistake::Affine { columns, factor, offset, .. } = &mistake else { continue };
            if *columns != [inputs + winding] {
                continue;
            }
            let mut wrong = right.clone();
            wrong.runs[0].table.columns[inputs + winding]
                .iter_mut()
                .for_each(|x| *x = (*x - offset) / factor);
            let found = illustration(&wrong, &[], &why(&mistake, &wrong), &Deadline::default()).unwrap();
            let own = &found.channels[0];
            assert_eq!((found.channels.len(), found.change.as_deref()), (1, mistake.change()));
            let expected = right.runs[0].table.columns[inputs + winding][0] - CELSIUS;
            let corrected = own.corrected.as_ref().unwrap()[0];
            assert!((corrected - expected).abs() < 1e-6, "{mistake:?}: {corrected} {expected}");
            assert!((own.predicted.as_ref().unwrap()[0] - expected).abs() < 1.0);
            assert_eq!(own.predicted_corrected, None, "an output does not change the prediction");
        }
    }

    /// An input in a wrong unit: it and all outputs, predicted with it as recorded and as corrected.
    #[test]
    fn an_input_is_drawn_with_the_outputs() {
        let mut right = testing::experiment(testing::PRIORS, true);
        let preset = crate::setup::Setup::new(&right, &[]).unwrap().preset().declared;
        testing::read(&mut right, &preset, None);
        let current = right.inputs.iter().position(|c| c.column == "current_A").unwrap();
        let mistake = mistakes(&right)
            .into_iter()
            .find(|m| matches!(m, Mistake::Affine { columns, words, .. } if *columns == [current] && words.contains("mA")))
            .unwrap();
        let found = illustration(&right, &[], &why(&mistake, &right), &Deadline::default()).unwrap();
        assert_eq!(found.channels[0].column, "current_A");
        assert!(found.channels[0].predicted.is_none() && found.channels[0].corrected.is_some());
        assert!(found.channels[1..].iter().any(|c| c.predicted_corrected.is_some()));
        let none = Unusable { channel: "time_s".to_owned(), ..why(&mistake, &right) };
        assert_eq!(illustration(&right, &[], &none, &Deadline::default()), None);
    }
}
