//! The public synthetic sets: errors of the preset and of a plain refit are those of their truth.json, and the
//! true effect wins the competition.

use calibrate::compete::compete;
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
        // Four runs one after the other, whose channels move together.
        assert_eq!(experiment.notes, Vec::<String>::new());
        let truth: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(set.path().join("truth.json")).unwrap()).unwrap();
        let preset = Preset::load(&experiment.preset).unwrap().starts.entries();
        let problem = Problem::new(&experiment, &preset).unwrap();
        let fitted = problem.fit(Role::Fit).unwrap();
        // Terms compete with the listed effects. Where one is true it comes first, with its size, and helps where it was
        // not fitted. Sensors that drift by millikelvins look like a drifting room, which does not: BIC alone would
        // take it.
        let scores = problem.scores(Role::Fit, &fitted).unwrap();
        let contenders = compete(&problem, &fitted, &scores, 3).unwrap();
        let best = &contenders[0];
        let (size, validation) = (best.fitted.last().unwrap().value, best.validation.unwrap());
        assert!(best.delta_bic > 10.0);
        match experiment.name.as_str() {
            "iron-loss" => {
                assert_eq!(best.candidate.name, "iron_loss");
                assert!((size / 9.5e-5 - 1.0).abs() < 0.02, "{size}");
                assert!(validation < 0.5, "{validation}");
            }
            "housing-radiation" => {
                assert_eq!(best.candidate.name, "housing_radiation");
                assert!(validation < 0.95, "{validation}");
            }
            "drag-power-075" => {
                assert_eq!(best.candidate.name, "drag_torque ~ speed^0.75");
                assert!(validation < 0.1, "{validation}");
            }
            "thermocouple-drift" => assert!(validation > 1.0, "{validation}"),
            other => panic!("nothing is known of {other}"),
        }
        for (key, errors) in
            [("before", problem.errors(&[]).unwrap()), ("refit", problem.errors(&fitted).unwrap())]
        {
            for rmse in &errors {
                let role = format!("{:?}", rmse.role).to_lowercase();
                for (channel, found) in experiment.outputs.iter().zip(&rmse.outputs) {
                    let told = truth["rmse"][&role][channel.column][key].as_f64().unwrap();
                    let close = (found / told - 1.0).abs();
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
