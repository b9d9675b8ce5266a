//! PLACEHOLDER until the pipeline is there: the naive refit alone, with the verdict "nothing".
//!
//! It exists so that the command, the report, the export and the replay can be built beside the pipeline; it looks for
//! no effect. The pipeline overwrites this file.

use crate::CalibrateError;
use crate::candidate::Change;
use crate::experiment::{Experiment, Role};
use crate::noise;
use crate::outcome::{ChannelError, Curve, Curves, Estimate, Outcome, Setting, Verdict};
use crate::refit::{Fitted, Problem};
use crate::simulate::{Bench, Drive};

/// Runs the refit; `progress` hears the share that is done and what is being done.
///
/// # Errors
/// A run that the model cannot be driven with.
pub fn run(
    experiment: &Experiment,
    preset: &[(u32, f64)],
    progress: &dyn Fn(f64, &str),
) -> Result<Outcome, CalibrateError> {
    let begun = std::time::Instant::now();
    progress(0.0, "refit");
    let problem = Problem::new(experiment, preset)?;
    let fitted = problem.fit(Role::Fit)?;
    progress(0.8, "errors");
    let (before, refit) = (problem.errors(&[])?, problem.errors(&fitted)?);
    let floor = noise::of_experiment(experiment)[experiment.inputs.len()..].to_vec();
    let errors = before.iter().zip(&refit).flat_map(|(before, refit)| {
        experiment
            .outputs
            .iter()
            .enumerate()
            .map(|(n, channel)| ChannelError {
                role: before.role,
                column: channel.column,
                before: before.outputs[n],
                refit: refit.outputs[n],
                after: refit.outputs[n],
                floor: floor[n],
            })
            .collect::<Vec<_>>()
    });
    let bench = Bench::new(experiment, preset)?;
    let declaration = bench.declaration();
    let change = |fitted: &[Fitted]| Change {
        values: fitted.iter().filter_map(|f| Some((declaration.by_name(&f.name)?.slot, f.value))).collect(),
        terms: Vec::new(),
    };
    let estimate = |f: &Fitted| Estimate {
        name: f.name.clone(),
        value: f.value,
        ci95: (f.value - 1.96 * f.deviation, f.value + 1.96 * f.deviation),
        prior: f.prior,
        unit: declaration.by_name(&f.name).map_or("1", |e| e.row.unit.name()),
    };
    let mut curves = Vec::new();
    for run in &experiment.runs {
        let drive = Drive::new(experiment, run)?;
        let (before, after) = (bench.run(&drive, &change(&[]))?, bench.run(&drive, &change(&fitted))?);
        let rows: Vec<usize> = (0..drive.time.len()).step_by(drive.time.len().div_ceil(600)).collect();
        let outputs = experiment.outputs.iter().enumerate().map(|(n, channel)| {
            let thin =
                |column: &[f64]| rows.iter().map(|k| column[*k] - channel.offset).collect::<Vec<f64>>();
            Curve {
                column: channel.column,
                measured: thin(&run.table.columns[experiment.inputs.len() + n]),
                before: thin(&before[n]),
                refit: thin(&after[n]),
                after: thin(&after[n]),
            }
        });
        curves.push(Curves {
            file: run.file.clone(),
            role: run.role,
            window: run.window,
            time: rows.iter().map(|k| drive.time[*k]).collect(),
            outputs: outputs.collect(),
        });
    }
    let values: Vec<(String, f64)> = declaration
        .entries
        .iter()
        .filter_map(|entry| {
            let fitted = fitted.iter().find(|f| f.name == entry.name).map(|f| f.value);
            let value = fitted.unwrap_or_else(|| bench.start_of(entry.slot));
            (!entry.row.start.is_nan() && value != entry.row.start).then(|| (entry.name.clone(), value))
        })
        .collect();
    let setting = |run: &crate::experiment::Run| Setting {
        file: run.file.clone(),
        role: run.role,
        values: values.clone(),
        terms: Vec::new(),
    };
    let settings: Vec<Setting> = experiment.runs.iter().map(setting).collect();
    let last = settings.iter().rev().find(|s| s.role == Role::Test).or(settings.last());
    let export = last.cloned().ok_or_else(|| CalibrateError("an experiment without runs".to_string()))?;
    let estimates: Vec<Estimate> = fitted.iter().map(estimate).collect();
    Ok(Outcome {
        name: experiment.name.clone(),
        model: declaration.name,
        verdict: Verdict::Nothing,
        effects: Vec::new(),
        unexplained: None,
        parameters: estimates.clone(),
        refit: estimates,
        correlated: Vec::new(),
        errors: errors.collect(),
        localised: Vec::new(),
        ladder: Vec::new(),
        whiteness: Vec::new(),
        limits: Vec::new(),
        curves,
        settings,
        export,
        notes: experiment.notes.clone(),
        seconds: begun.elapsed().as_secs_f64(),
    })
}
