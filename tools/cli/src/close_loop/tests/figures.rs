//! Figures and tables of the page.

use super::*;
use calibrate::outcome::Estimate;

/// A value of a law by points, within 0.1 W.
pub fn value(place: &str, value: f64) -> Estimate {
    let ci95 = (value - 0.1, value + 0.1);
    Estimate { name: format!("value at {place}"), value, ci95, prior: 0.0, unit: "W" }
}

/// A law by points: its ends with units in the sentence, all points in a table, and a dashed line over the estimate.
#[test]
fn a_law_by_points_is_a_table() {
    let driver = Driver::Speed;
    let law = r#"{"format": "motor-fmu effects 1", "terms": [{"port": "drag_torque", "table": {"driver": "speed",
        "x": [0.0, 100.0, 315.3], "y": [-0.15, 3.0, -46.0]}}]}"#;
    let term = archive::build::TermsFile::parse(law, "law").unwrap().terms().unwrap()[0];
    let sentence = text::law(&term);
    assert!(sentence.contains("3 points, from -0.15 N·m at 0 rad/s to -46 N·m at 315.3 rad/s"), "{sentence}");
    let mut outcome = sample::outcome(Verdict::Unexplained);
    outcome.effects[0].term =
        Some(GenericTerm { lag: Some(Lag { driver, tau: 1048.0, difference: false }), ..term });
    outcome.effects[0].follows = Follows::Late(driver);
    outcome.unexplained.as_mut().unwrap().follows = Follows::Late(driver);
    outcome.effects[0].parameters =
        [-0.15, 3.0, -46.0].iter().map(|y| value(&format!("lagged speed = {y:.4}"), *y)).collect();
    let page = page_with(&sample::experiment(), &outcome);
    for part in [
        "<th class=\"n\">speed, lag 1048 s, in rad/s</th>",
        ">-46.10 to -45.90<",
        "law added",
        "95 % interval of the estimate",
        "drag torque in N·m",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
    assert!(!page.contains("value at"));
}

/// Both parts of a run that ends at a gap have their own heading and inputs; nothing is drawn across the gap of one that goes on.
#[test]
fn parts_of_a_run_are_apart() {
    let (mut experiment, mut outcome) = (sample::experiment(), sample::outcome(Verdict::Named));
    let (mut run, mut curves) = (experiment.runs[1].clone(), outcome.curves[1].clone());
    (run.window, curves.window, curves.run) = (None, None, 2);
    experiment.runs[1].window = None;
    outcome.curves[1].window = None;
    run.table.time.iter_mut().for_each(|t| *t += 5000.0);
    curves.time.iter_mut().for_each(|t| *t += 5000.0);
    experiment.runs.push(run);
    outcome.curves.push(curves);
    let page = page_with(&experiment, &outcome);
    for heading in
        ["run-2.csv, clock from 0 s to 2990 s (test)", "run-2.csv, clock from 5000 s to 7990 s (test)"]
    {
        assert!(page.contains(&format!("<summary>{heading}</summary>")), "{heading}");
    }
    assert_eq!(page.matches("Below: the inputs that change").count(), 3);
    let figure = |page: &str| {
        page.split("over current\"")
            .nth(1)
            .unwrap()
            .split("</svg>")
            .next()
            .unwrap()
            .matches("<circle")
            .count()
    };
    let whole = figure(&page);
    experiment.runs.pop();
    outcome.curves.pop();
    // 201 rows of run 1 count, 300 of run 2, and one of each is blank.
    assert!(whole >= figure(&page_with(&experiment, &outcome)) + 299);

    for (table, curves) in experiment.runs.iter_mut().map(|r| &mut r.table).zip(&mut outcome.curves) {
        table.time[150..].iter_mut().for_each(|t| *t += 400.0);
        curves.time[150..].iter_mut().for_each(|t| *t += 400.0);
    }
    let page = page_with(&experiment, &outcome);
    assert!(page.contains("No rows from 1490 s to 1900 s."));
}

/// Readings that the checks set aside are rings; a channel without any is named.
#[test]
fn readings_that_were_set_aside_are_seen() {
    let (read, mut used, mut outcome) =
        (sample::experiment(), sample::experiment(), sample::outcome(Verdict::Named));
    for row in 100..103 {
        used.runs[0].table.columns[3][row] = f64::NAN;
        outcome.curves[0].outputs[0].measured[row] = f64::NAN;
    }
    used.runs[1].table.columns[4].fill(f64::NAN);
    outcome.curves[1].outputs[1].measured.fill(f64::NAN);
    let page = page_from(page::Data { used: &used, read: &read }, &outcome);
    assert!(page.contains("Winding temperature: all readings were set aside (see Notes)."));
    // The sample measures 3 V and predicts 20 V: too far away for the panel.
    assert!(page.contains("Voltage: 3 readings that were set aside outside the panel."));
    assert!(page.contains("Grey: readings that were set aside"));
    let page = page_from(page::Data { used: &used, read: &used }, &outcome);
    assert!(page.contains("Winding temperature: not measured in this run.") && !page.contains("Grey:"));
}

/// Without a port that explains anything there is a sentence in place of a figure.
#[test]
fn an_empty_location_is_a_sentence() {
    let mut outcome = sample::outcome(Verdict::Nothing);
    outcome.localised.iter_mut().for_each(|l| l.share = 0.002);
    let page = page_with(&sample::experiment(), &outcome);
    assert!(page.contains("No port explains 1 %") && !page.contains("Unconstrained input at each port"));
}

/// Exponents of 1 and lags of candidates are words; equal errors are no difference.
#[test]
fn candidates_and_replay_are_in_words() {
    let mut outcome = sample::outcome(Verdict::Named);
    outcome.candidate_table[1].name = "drag_torque ~ lag of friction_loss^1".to_owned();
    outcome.candidate_table[1].probability = 1.5e-66;
    let page = page_with(&sample::experiment(), &outcome);
    assert!(page.contains("drag torque ∝ lagged friction loss<") && page.contains("&lt; 0.001"), "{page}");
    let replay = Replay { greatest_difference: 0.0, ..sample::replay() };
    assert!(text::replay(&replay).ends_with("no difference of their RMSE from the model's"));
}
