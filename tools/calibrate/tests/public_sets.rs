//! The public synthetic sets: the errors of the preset and of a plain refit are those of their truth.json.

use calibrate::experiment::{Experiment, Role};
use calibrate::refit::Problem;
use describe::Preset;
use std::path::Path;

#[test]
fn before_and_refit_are_those_of_the_truth() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/bench-synthetic");
    let mut sets = 0;
    for set in std::fs::read_dir(&folder).unwrap().flatten().filter(|e| e.path().is_dir()) {
        sets += 1;
        let experiment = Experiment::read(&set.path().join("experiment.toml")).unwrap();
        let truth: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(set.path().join("truth.json")).unwrap()).unwrap();
        let preset = Preset::load(&experiment.preset).unwrap().starts.entries();
        let problem = Problem::new(&experiment, &preset).unwrap();
        let fitted = problem.fit(Role::Fit).unwrap();
        for (key, errors) in
            [("before", problem.errors(&[]).unwrap()), ("refit", problem.errors(&fitted).unwrap())]
        {
            for rmse in &errors {
                let role = format!("{:?}", rmse.role).to_lowercase();
                for (channel, found) in experiment.outputs.iter().zip(&rmse.outputs) {
                    let told = truth["rmse"][&role][channel.column][key].as_f64().unwrap();
                    let close = (found / told - 1.0).abs();
                    println!("{} {role} {} {key}: {found:.4} {told:.4}", experiment.name, channel.column);
                    // A refit may stop a little elsewhere than another fitter's.
                    let tolerance = if key == "before" { 2e-3 } else { 0.05 };
                    assert!(
                        close <= tolerance,
                        "{} {role} {} {key}: {found} instead of {told}",
                        experiment.name,
                        channel.column
                    );
                }
            }
        }
    }
    assert!(sets >= 2, "no sets in {}", folder.display());
}
