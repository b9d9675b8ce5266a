mod figures;

use super::*;
use calibrate::experiment::{Deviation, Role};
use calibrate::outcome::{ChannelError, Curves, Follows};
use describe::{Driver, Factor, GenericTerm, Grid, Lag, Law, Port, Product};
use present::check;
use serde_json::{Value, json};

const ALL: [Verdict; 4] = [Verdict::Named, Verdict::Class, Verdict::Unexplained, Verdict::Nothing];

fn json_of(verdict: Verdict) -> Value {
    let (outcome, replay) = (sample::outcome(verdict), sample::replay());
    let fmu = ["fmi2/AnnulusCooledMotor.fmu".to_owned()];
    let report = Report::new(&outcome, &fmu, Some(&replay), &outcome.notes, (4.5, 45.0));
    serde_json::from_str(&serde_json::to_string(&report).unwrap()).unwrap()
}

/// The keys that scripts rely on, with their values where the contract has them.
#[test]
fn the_report_is_that_of_the_contract() {
    let found = json_of(Verdict::Named);
    assert_eq!(
        (&found["name"], &found["verdict"], &found["seconds"]),
        (&json!("bench <17>"), &json!("named"), &json!(4.5))
    );
    let effect = &found["effects"][0];
    for (key, value) in [
        ("id", json!("iron_loss")),
        ("port", json!("drag_torque")),
        ("driver", json!("speed")),
        ("alternatives", json!(["viscous_friction"])),
        ("weights", json!({"iron_loss": 0.75, "viscous_friction": 0.25})),
        ("runs", json!(["run-1.csv"])),
    ] {
        assert_eq!(effect[key], value, "{key}");
    }
    let k = &effect["parameters"]["k"];
    assert_eq!((&k["value"], &k["unit"]), (&json!(9.5e-5), &json!("N.m.s^0.5")));
    assert!((k["ci95"][0].as_f64().unwrap() - 9.1e-5).abs() < 1e-12);
    assert_eq!(effect["evidence"]["delta_bic"], json!(120.0));
    assert_eq!(effect["evidence"]["validation_rmse_ratio"], json!(0.41));
    assert!(effect["separating_experiment"].is_string() && found["unexplained"].is_null());
    assert_eq!(found["parameters"]["motor.R_ref"]["prior"], json!(0.386));
    let voltage = json!({"before": 1.9, "refit": 0.5, "after": 0.11, "floor": 0.1, "blackbox": 0.7});
    assert_eq!(found["error"]["fit"]["voltage_V"], voltage);
    assert_eq!(found["prediction"]["fit"]["voltage_V"], json!({"half_width": 0.2, "inside": 0.95}));
    assert_eq!(found["error"]["validate"], json!({}), "a role without runs is there and empty");
    assert_eq!(found["fmu"], json!(["fmi2/AnnulusCooledMotor.fmu"]));
    assert_eq!((&found["explains_data"], &found["remaining_error"]), (&json!(true), &Value::Null));
}

#[test]
fn numbers_that_are_none_are_null() {
    let found = json_of(Verdict::Named);
    assert_eq!(found["parameters"]["thermal.C_w"]["ci95"], json!([null, null]));
    assert!(found["error"]["test"]["winding_temperature_degC"]["before"].is_null());
}

#[test]
fn what_has_no_name_has_a_port_a_driver_a_shape_and_a_law() {
    let found = json_of(Verdict::Unexplained);
    let unexplained = &found["unexplained"];
    assert_eq!((&unexplained["port"], &unexplained["driver"]), (&json!("drag_torque"), &json!("speed")));
    assert_eq!((&unexplained["unit"], &unexplained["driver_unit"]), (&json!("N.m"), &json!("rad/s")));
    assert_eq!(unexplained["shape"].as_array().unwrap().len(), 8);
    assert_eq!(found["effects"][0]["law"]["drivers"][0]["exponent"], json!(0.75));
    let nothing = json_of(Verdict::Nothing);
    assert_eq!((&nothing["effects"], &nothing["unexplained"]), (&json!([]), &Value::Null));
    assert_eq!(nothing["detection_limits"][0]["size"], json!(2e-6));
}

/// Whether the model explains the data, with the error that it leaves, as the first sentence of the report has it.
#[test]
fn the_report_states_whether_the_model_explains_the_data() {
    for verdict in ALL {
        let mut outcome = sample::outcome(verdict);
        let test = outcome.errors.iter_mut().find(|e| e.role == Role::Test).unwrap();
        test.after = 6.0 * test.floor;
        let report = Report::new(&outcome, &[], None, &[], (4.5, 45.0));
        let found: Value = serde_json::from_str(&serde_json::to_string(&report).unwrap()).unwrap();
        assert_eq!(found["explains_data"], json!(false));
        let remaining = &found["remaining_error"];
        assert_eq!((&remaining["role"], &remaining["channel"]), (&json!("test"), &json!("voltage_V")));
        assert!((remaining["error_over_noise"].as_f64().unwrap() - 6.0).abs() < 1e-9);
        let sentence = text::verdict(&outcome);
        assert!(
            sentence.contains("the error of voltage on the test data is 6 times the noise"),
            "{sentence}"
        );
        // Good instruments err as much.
        outcome.errors.iter_mut().for_each(|e| e.instruments = 10.0 * e.floor);
        assert!(outcome.remaining_error().is_none());
    }
    let why = Unusable::new("", "", "");
    let report = Report::unusable(("a", "b"), &why, &[], (0.0, 0.0));
    assert!(serde_json::to_value(&report).unwrap()["explains_data"].is_null());
}

/// Rows count in the role of their window, once each; those of two parts of a run are not lost.
#[test]
fn rows_count_once_in_each_role() {
    let mut outcome = sample::outcome(Verdict::Named);
    let whole = outcome.curves[0].clone();
    let in_role = |role, window| Curves { role, window, ..whole.clone() };
    let rows = |outcome: &Outcome| text::residuals(outcome).lines().count() - 1;
    outcome.curves = vec![in_role(Role::Fit, Some((0.0, 995.0))), in_role(Role::Test, Some((995.0, 5000.0)))];
    assert_eq!(rows(&outcome), 2 * 300);
    outcome.curves = vec![in_role(Role::Fit, None), in_role(Role::Test, None)];
    assert_eq!(rows(&outcome), 2 * 2 * 300, "once in each role");
    outcome.curves = vec![in_role(Role::Fit, Some((0.0, 1000.0))), in_role(Role::Fit, Some((500.0, 1490.0)))];
    assert_eq!(rows(&outcome), 2 * 150, "windows that share rows");
}

/// A row for each run, output and time in the window; a blank where nothing was measured.
#[test]
fn residuals_are_a_table() {
    let outcome = sample::outcome(Verdict::Named);
    let text = text::residuals(&outcome);
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 2 * 2 * 201);
    assert!(rows.iter().all(|row| row.len() == 9));
    assert_eq!(rows[8][..5], ["\"run-1.csv\"", "fit", "voltage_V", "70", ""]);
    let curve = &outcome.curves[0].outputs[0];
    assert_eq!((rows[1][4].parse(), rows[1][7].parse()), (Ok(curve.measured[0]), Ok(curve.after[0])));
}

/// Each verdict is a sentence with its subject.
#[test]
fn verdicts_are_sentences() {
    for (verdict, words) in ALL.iter().zip([
        ["iron loss", "k = 9.5e-5 N·m·s^0.5", "run-1.csv only"],
        ["one of iron loss or viscous friction", "do not distinguish", "iron loss"],
        ["the torque against the motion", "follows the speed", "not in the list"],
        ["no missing effect", "is detected", "other parameter values"],
    ]) {
        let sentence = text::verdict(&sample::outcome(*verdict));
        assert!(words.iter().all(|w| sentence.contains(w)), "{sentence}");
        assert!(sentence.ends_with('.') && !sentence.contains('_'), "{sentence}");
    }
}

/// Without an effect, the sentence does not claim what the errors contradict, nor a search that was cut.
#[test]
fn a_verdict_of_nothing_follows_the_errors() {
    let mut outcome = sample::outcome(Verdict::Nothing);
    let test = outcome.errors.iter_mut().find(|e| e.role == Role::Test).unwrap();
    test.after = 6.0 * test.floor;
    let sentence = text::verdict(&outcome);
    assert!(
        sentence.contains("do not explain the data: the error of voltage on the test data is 6"),
        "{sentence}"
    );
    assert!(!sentence.contains("other parameter values"), "{sentence}");
    outcome.verdict = Verdict::Fitted;
    let fitted = text::verdict(&outcome);
    assert!(
        fitted.contains("no missing effect was looked for, and the fitted parameters do not explain"),
        "{fitted}"
    );
    outcome.verdict = Verdict::Nothing;
    outcome.is_cut = true;
    let sentence = text::verdict(&outcome);
    assert!(
        sentence.starts_with("the time budget ended the search before") && !sentence.contains('_'),
        "{sentence}"
    );
}

/// A verdict with an effect says what the repaired model leaves of the fit runs.
#[test]
fn a_verdict_states_what_remains() {
    let mut outcome = sample::outcome(Verdict::Named);
    assert!(!text::verdict(&outcome).contains("does not explain all"), "{}", text::verdict(&outcome));
    let fit = outcome.errors.iter_mut().find(|e| e.role == Role::Fit).unwrap();
    fit.after = 12.0 * fit.floor;
    let sentence = text::verdict(&outcome);
    assert!(
        sentence.contains("does not explain all of it: the error of voltage on the fit data is 12"),
        "{sentence}"
    );
}

/// A verdict with an effect says what the repaired model leaves of the runs that were not fitted: the worst of them.
#[test]
fn a_verdict_states_what_remains_of_other_runs() {
    let mut outcome = sample::outcome(Verdict::Unexplained);
    let fit = outcome.errors.clone();
    outcome.errors.extend(fit.into_iter().filter(|e| e.role == Role::Fit).map(|e| ChannelError {
        role: Role::Validate,
        after: 25.0 * e.floor,
        ..e
    }));
    outcome.errors.iter_mut().filter(|e| e.role == Role::Test).for_each(|e| e.after = 19.0 * e.floor);
    let sentence = text::verdict(&outcome);
    assert!(
        sentence.contains("explains the fit data, but not the other runs: the error of")
            && sentence.contains("on the validation data is 25 times the noise"),
        "{sentence}"
    );
}

/// A law beside an effect that explains more is stated with it.
#[test]
fn what_explains_less_is_stated_beside_a_name() {
    let mut outcome = sample::outcome(Verdict::Named);
    let beside = sample::outcome(Verdict::Unexplained);
    outcome.effects.extend(beside.effects);
    outcome.unexplained = beside.unexplained;
    let sentence = text::verdict(&outcome);
    let law = "; beside that, and explaining less, an effect that is not in the list acts on";
    assert!(sentence.starts_with("the model lacks iron loss") && sentence.contains(law), "{sentence}");
}

/// An effect without alternatives is no part of a class.
#[test]
fn a_class_excludes_effects_without_alternatives() {
    let mut outcome = sample::outcome(Verdict::Class);
    let mut beside = outcome.effects[0].clone();
    beside.id = "windage".to_owned();
    beside.alternatives.clear();
    outcome.effects.push(beside);
    let sentence = text::verdict(&outcome);
    assert!(sentence.contains("lacks one of iron loss or viscous friction and windage;"), "{sentence}");
}

fn page_of(verdict: Verdict) -> String {
    page_with(&sample::experiment(), &sample::outcome(verdict))
}

fn page_with(experiment: &Experiment, outcome: &Outcome) -> String {
    page_from(page::Data { used: experiment, read: experiment }, outcome)
}

/// A page with the letters that are typed.
fn plain(page: &str) -> String {
    page.replace('\u{a0}', " ").replace('\u{2212}', "-")
}

fn page_from(data: page::Data, outcome: &Outcome) -> String {
    let declaration = (describe::models::by_name(outcome.model).unwrap().declaration)();
    plain(&page::page(data, outcome, &sample::replay(), &outcome.notes, declaration, &sample::made_of()))
}

/// Keys are code, or words: in headings, sentences, tables and figures of every verdict, and where the data are unusable.
#[test]
fn a_page_has_no_raw_keys() {
    let experiment = sample::experiment();
    let why = Unusable::new(
        "voltage_V",
        "voltage_V in run-1.csv contradicts the model",
        "check unit and sign of voltage_V",
    );
    let declaration = (describe::models::by_name("AnnulusCooledMotor").unwrap().declaration)();
    let unusable = page::unusable(&experiment, (&why, None), declaration, &sample::made_of());
    for page in ALL.map(page_of).into_iter().chain([unusable]) {
        for text in check::texts(&page).iter().filter(|text| *text != "residuals.csv") {
            let key = text.split_whitespace().find(|word| check::is_key(word));
            assert_eq!(key, None, "{text}");
        }
    }
}

/// Without an effect, one model is fitted and nothing is repaired: no column, line or sentence of a second one.
#[test]
fn a_fit_without_an_effect_is_no_repair() {
    for verdict in [Verdict::Nothing, Verdict::Fitted] {
        for text in check::texts(&page_of(verdict)) {
            let lower = text.to_lowercase();
            assert!(
                !["refit", "repair", "after:", "extended"].iter().any(|word| lower.contains(word)),
                "{text}"
            );
            assert!(lower.trim() != "after", "legend or header");
        }
    }
    let named = page_of(Verdict::Named);
    assert!(
        ["<th class=\"n\">refit</th>", "After: the extended model"].iter().all(|part| named.contains(part))
    );
}

/// A block of a table in a narrow window is headed by what the row is about, not by its round, role or archive.
#[test]
fn blocks_of_tables_have_headings() {
    let page = page_of(Verdict::Named);
    let heads: Vec<&str> = page.split("class=\"cards\"><thead><tr><th").skip(1).collect();
    assert!(heads.len() >= 5, "{}", heads.len());
    for head in heads {
        let first = head.split(['>', '<']).nth(1).unwrap();
        assert!(
            ["output", "candidate", "parameter", "channel", "effect", "symbol"].contains(&first),
            "{first}"
        );
    }
}

/// A run with one reading has a row with it in place of figures with one dot.
#[test]
fn few_readings_are_a_table() {
    let mut outcome = sample::outcome(Verdict::Named);
    for curves in &mut outcome.curves {
        for (row, value) in curves.outputs[0].measured.iter_mut().enumerate() {
            *value = if [150, 299].contains(&row) { *value } else { f64::NAN };
        }
    }
    let page = page_with(&sample::experiment(), &outcome);
    assert!(
        !page.contains("voltage, without the preset")
            && page.contains("winding temperature, without the preset")
    );
    let row = page
        .split("<td data-label=\"output\">voltage in V</td><td class=\"n\" data-label=\"time in s\">")
        .nth(1);
    assert!(row.is_some_and(|row| row.starts_with("1500<")), "{row:?}");
    assert!(!page.contains(">2990<"), "a row behind the window is no row of the table");
    assert!(page.contains("measured, with 95 % of the noise"));
    // Over the time of the only reading of each run there is nothing to see.
    for curve in outcome.curves.iter_mut().flat_map(|c| &mut c.outputs) {
        curve.measured[..150].fill(f64::NAN);
        curve.measured[151..].fill(f64::NAN);
    }
    assert!(!page_with(&sample::experiment(), &outcome).contains("over time"));
}

/// A prior that is many times as wide as its value hides no other parameter.
#[test]
fn changes_of_parameters_are_comparable() {
    let mut experiment = sample::experiment();
    experiment.priors[1].deviation = Deviation::Relative(3000.0);
    let page = page_with(&experiment, &sample::outcome(Verdict::Named));
    let figure =
        page.split("aria-label=\"Change of the parameters").nth(1).unwrap().split("</svg>").next().unwrap();
    // The refit of motor.R_ref is 1.4 standard deviations of its prior away from the preset.
    assert!(figure.contains(">-2<") && figure.contains(">2<") && !figure.contains(">4<"), "{figure}");
}

/// The sentence of the verdict and the next experiment are about one error.
#[test]
fn the_next_experiment_names_the_error_of_the_verdict() {
    let mut outcome = sample::outcome(Verdict::Nothing);
    for e in &mut outcome.errors {
        e.after = if e.role == Role::Test { 6.0 } else { 9.0 } * e.floor;
    }
    let page = page_with(&sample::experiment(), &outcome);
    assert_eq!(
        page.matches("on the test data is 6 times the noise").count(),
        2,
        "verdict and next experiment"
    );
    assert!(!page.contains("is 9 times"));
}

/// A constant column shows no noise; its lower limit for the numerics is none.
#[test]
fn constant_columns_have_no_noise() {
    let page = page_of(Verdict::Named);
    let row = page.split("data-label=\"channel\">ambient temperature in K</td>").nth(1).unwrap();
    assert!(
        row.starts_with(
            "<td class=\"n\" data-label=\"standard deviation\"></td><td data-label=\"origin\">constant"
        ),
        "{row}"
    );
}

/// Each number of an unlisted law has a meaning.
#[test]
fn numbers_of_a_law_are_described() {
    let page = page_of(Verdict::Unexplained);
    assert!(page.contains("<code>exponent</code></td><td data-label=\"meaning\">Power of the driver</td>"));
}

/// One file without network references that contains all parts of its verdict.
#[test]
fn a_page_is_complete_in_itself() {
    for (verdict, words) in ALL.iter().zip([
        ["Identified effects", "Experiment that distinguishes them", "9.1 × 10⁻⁵ to 9.9 × 10⁻⁵"],
        ["one of iron loss or viscous friction", "explained equally well by", "Probability"],
        [
            "Law: drag torque = 0.002 N·m · (speed / 500 rad/s)^0.75",
            "was added to the model",
            "At most 0.14 W",
        ],
        ["Detection limits", "2 × 10⁻⁶", "predicts the runs to the noise"],
    ]) {
        let page = page_of(*verdict);
        for word in words.iter().chain(&[
            "bench &lt;17&gt;",
            "Location of the residual",
            "iron loss explains the same",
            "(<code>thermal.C_w</code>) with thermal resistance",
            "Whiteness of the residuals",
            "fmi3/AnnulusCooledMotor.fmu",
            "set aside as dead",
            "window ends",
            "noise: 0.1 K",
            "Measured and predicted",
            "Status: test errors: voltage 0.11 V (before 2.9 V, noise 0.1 V)",
            "the exported FMUs reproduce them",
            "ARX of order 2",
            "Unknowns of single runs",
            "Heat capacity of the winding (thermal.C_w)",
            "Change of the parameters from the preset",
            "Next experiment",
            "Noise and drift",
            "Residual over the drivers",
            "2026-03-01T12:00:00Z",
            "c0ffee",
            "unknown",
        ]) {
            assert!(page.to_lowercase().contains(&word.to_lowercase()), "{}: {word}", verdict.name());
        }
        assert_eq!(check::faults(&page), Vec::<String>::new(), "{}", verdict.name());
        assert!(!page.contains("<script") && !page.contains("inf "), "{}", verdict.name());
        if let Ok(folder) = std::env::var("PAGES") {
            std::fs::write(Path::new(&folder).join(format!("{}.html", verdict.name())), &page).unwrap();
        }
    }
    assert!(!page_of(Verdict::Named).contains("Unexplained effect"));
    assert!(!page_of(Verdict::Nothing).contains("Identified effects"));
}

/// A mass is described by its heat capacity and its conductance, not as a lagged driver.
#[test]
fn a_mass_is_described_as_one() {
    let driver = Driver::HousingTemperature;
    assert_eq!(text::driver(Follows::Mass(driver)), "is the heat of a mass that is attached to the housing");
    let factor = Factor { driver, offset: 0.0, reference: 10.0, exponent: 1.0, range: Factor::UNLIMITED };
    let law = Law::Product(Product { coefficient: 5.0, factors: [Some(factor), None, None] });
    let lag = Some(Lag { driver, tau: 100.0, difference: true });
    let term = GenericTerm { lag, ..GenericTerm::new(Port::HousingHeat, law) };
    assert_eq!(text::law(&term), "housing heat = that of a mass of 50 J/K behind 0.5 W/K");
    let elsewhere = GenericTerm { port: Port::WindingHeat, ..term };
    assert!(text::law(&elsewhere).ends_with("less its present value"), "{}", text::law(&elsewhere));
}

/// A law over two drivers is a sentence with the range of both, and a line for each point of the second in its figure.
#[test]
fn a_law_of_two_drivers_is_described() {
    let follows = Follows::Both(Driver::Speed, Driver::HousingTemperature);
    assert_eq!(text::driver(follows), "follows the speed and the housing's temperature");
    let rows = [vec![0.0, 1.0, 2.0], vec![3.0, 4.0, 5.5]];
    let grid = Grid::new(
        [Driver::Speed, Driver::HousingTemperature],
        [&[0.0, 500.0], &[290.0, 300.0, 320.0]],
        &rows,
    );
    let term = GenericTerm::new(Port::HousingHeat, Law::Grid(grid.unwrap()));
    let sentence = text::law(&term);
    for part in ["speed (2 points from 0 to 500 rad/s)", "(3 points from 290 to 320 K)", "from 0 to 5.5 W"] {
        assert!(sentence.contains(part), "{sentence}");
    }
    let mut outcome = sample::outcome(Verdict::Unexplained);
    let mut found = outcome.unexplained.clone().unwrap();
    (found.port, found.follows) = (Port::HousingHeat, follows);
    (outcome.effects[0].port, outcome.effects[0].term) = (Port::HousingHeat, Some(term));
    let svg = page::figures::shape(&found, &outcome).svg;
    assert!(
        ["290 K", "300 K", "320 K"]
            .iter()
            .all(|at| svg.contains(&format!("law at housing temperature {at}"))),
        "{svg}"
    );
    assert!(
        svg.contains("estimate, mean over housing temperature") && svg.contains("housing heat in W"),
        "{svg}"
    );
    outcome.unexplained = Some(found);
    outcome.effects[0].parameters =
        (0..6).map(|k| figures::value(&format!("point {k}"), 0.5 * f64::from(k))).collect();
    let page = page_with(&sample::experiment(), &outcome);
    let head = "<th class=\"n\">speed in rad/s</th><th class=\"n\">housing temperature 290 K</th>";
    assert!(
        page.contains(head) && page.contains(">2.50 (2.40 to 2.60)<") && !page.contains("value at"),
        "{page}"
    );
    // The mean over the second driver is less than the greatest value.
    assert!(page.contains("At most 5.5 W"));
}
