use super::*;
use physics::terms::Drivers;

const VALID: &str = r#"{"format": "motor-fmu effects 1", "terms": [
    {"name": "seal", "port": "drag_torque", "coefficient": 1.2e-3, "unit": "N.m",
     "drivers": [{"driver": "speed", "reference": 100.0, "offset": 0.0, "exponent": 0.5}]},
    {"port": "winding_heat", "table": {"driver": "winding_temperature", "x": [300, 400], "y": [0, 2]}}]}"#;

const GRID: &str = r#"{"format": "motor-fmu effects 1", "terms": [
    {"name": "grease", "port": "drag_torque", "grid": {"drivers": ["speed", "housing_temperature"],
     "x": [0, 600], "y": [300, 330, 360], "z": [[0, 0, 0], [8e-3, 5e-3, 4e-3]]}},
    {"port": "housing_heat", "coefficient": 0.5, "drivers": [{"driver": "copper_loss", "reference": 1.0}]
     , "lag": {"driver": "copper_loss", "tau": 400.0}}]}"#;

/// A grid and a lag are unchanged after writing and reading; at 300 rad/s and 345 K the grid gives half of 4.5 mN.m.
#[test]
fn grids_and_lags_are_read() {
    let terms = TermsFile::parse(GRID, "x.json").unwrap().terms().unwrap();
    let at = Drivers { speed: 300.0, housing_temperature: 345.0, copper_loss: 8.0, ..Drivers::default() };
    assert!((terms[0].value(&at) - 2.25e-3).abs() < 1e-12);
    assert_eq!((terms[1].value(&at), terms[1].lag.unwrap().tau), (4.0, 400.0));
    let texts = terms.iter().map(|term| TermText::of("", term)).collect();
    let again = TermsFile::parse(&TermsFile::new(texts).text(), "y.json").unwrap();
    assert_eq!(again.terms().unwrap(), terms);
}

/// The mass of the documentation: 0.5 W/K, of which 20 K less than the housing take 10 W from it; of a heat flow there is no difference.
#[test]
fn a_mass_is_read_and_written() {
    let text = r#"{"format": "motor-fmu effects 1", "terms": [
        {"port": "housing_heat", "coefficient": 5.0, "drivers": [{"driver": "housing_temperature", "reference": 10.0}],
         "lag": {"driver": "housing_temperature", "tau": 100.0, "difference": true}}]}"#;
    let terms = TermsFile::parse(text, "x.json").unwrap().terms().unwrap();
    let at = Drivers { housing_temperature: 340.0, lagged: [320.0, 0.0, 0.0], ..Drivers::default() };
    assert_eq!(terms[0].along_as(0, &at, None::<(physics::terms::Driver, f64)>), -10.0);
    let again = TermsFile::new(vec![TermText::of("", &terms[0])]).text();
    assert!(again.contains("\"difference\": true"), "{again}");
    assert_eq!(TermsFile::parse(&again, "y.json").unwrap().terms().unwrap(), terms);
    let of_heat = text.replace("housing_temperature", "copper_loss");
    assert!(error_of(&of_heat).contains("lag.difference"), "{}", error_of(&of_heat));
}

fn error_of(text: &str) -> String {
    let sentence = TermsFile::parse(text, "x.json").unwrap_err().to_string();
    assert!(!sentence.contains('\n') && sentence.starts_with("x.json"), "{sentence}");
    sentence
}

/// A term is unchanged after writing and reading.
#[test]
fn a_term_becomes_text_and_a_term_again() {
    let terms = TermsFile::parse(VALID, "x.json").unwrap().terms().unwrap();
    let texts = terms.iter().map(|term| TermText::of("seal", term)).collect();
    let again = TermsFile::parse(&TermsFile::new(texts).text(), "y.json").unwrap();
    assert_eq!(again.terms().unwrap(), terms);
    assert_eq!(again.terms[0].name, "seal");
    let text = VALID.replace("0.5}", "0.5, \"range\": [0, 225]}");
    let held = TermsFile::parse(&text, "x.json").unwrap().terms().unwrap();
    let at = |speed: f64| held[0].value(&Drivers { speed, ..Drivers::default() });
    assert!((at(-400.0) - 1.8e-3).abs() < 1e-12 && (at(100.0) - 1.2e-3).abs() < 1e-12);
    let again = TermsFile::parse(&TermsFile::new(vec![TermText::of("", &held[0])]).text(), "y.json");
    assert_eq!(again.unwrap().terms().unwrap(), held[..1]);
}

#[test]
fn what_is_written_is_read() {
    let file = TermsFile::parse(VALID, "x.json").unwrap();
    let terms = file.terms().unwrap();
    let at = Drivers { speed: 400.0, winding_temperature: 350.0, ..Drivers::default() };
    assert_eq!((terms[0].port, terms[0].value(&at)), (Port::DragTorque, 2.4e-3));
    assert_eq!((terms[1].port, terms[1].value(&at)), (Port::WindingHeat, 1.0));
    assert_eq!(TermsFile::parse(&file.text(), "y.json").unwrap(), file, "after writing");
    assert!(TermsFile::parse(&TermsFile::new(Vec::new()).text(), "z.json").is_ok());
}

/// Valid texts with one error each: the message names term, field, value and limits, or the line.
#[test]
fn errors_name_what_is_wrong() {
    for (old, new, words) in [
        ("effects 1", "effects 2", &["\"motor-fmu effects 2\"", "\"motor-fmu effects 1\""][..]),
        ("drag_torque", "drag", &["\"seal\"", "port = \"drag\"", "drag_torque, terminal_voltage"]),
        ("\"N.m\"", "\"W\"", &["\"seal\"", "unit = \"W\"", "drag_torque", "\"N.m\""]),
        ("\"speed\"", "\"spede\"", &["\"seal\"", "driver = \"spede\"", "speed, current"]),
        ("1.2e-3", "1e9", &["\"seal\"", "coefficient = 1000000000", "-1000000 ... 1000000"]),
        ("100.0", "0.0", &["\"seal\"", "reference = 0", "0.000000001 ... 1000000000"]),
        ("0.5}", "7}", &["\"seal\"", "exponent = 7", "-6 ... 6"]),
        ("0.5}", "0.5, \"range\": [300, 100]}", &["\"seal\"", "range = [300, 100]", "larger"]),
        ("[300, 400]", "[400, 300]", &["term 2", "table.x[1] = 300", "table.x[0] = 400"]),
        ("[300, 400]", "[300]", &["term 2", "1 values of x and 2 of y"]),
        ("[0, 2]", "[0, 1e7]", &["term 2", "table.y[1] = 10000000"]),
        (
            "\"port\": \"winding_heat\", ",
            "\"port\": \"winding_heat\", \"coefficient\": 1, ",
            &["term 2", "either"],
        ),
        ("1.2e-3", "\"much\"", &["x.json:2:", "\"much\""]),
        ("1.2e-3", "1e999", &["x.json:2:", "out of range"]),
        ("\"exponent\"", "\"exponnent\"", &["x.json:3:", "exponnent"]),
        ("\"port\": \"winding_heat\", ", "", &["x.json:4:", "missing field `port`"]),
        ("]}}]}", "", &["x.json:4:", "EOF"]),
    ] {
        assert_eq!(VALID.matches(old).count(), 1, "{old}");
        let sentence = error_of(&VALID.replace(old, new));
        assert!(words.iter().all(|w| sentence.contains(w)), "{words:?} in {sentence}");
    }
    for (text, words) in [
        (GRID.replace("[300, 330, 360]", "[300, 360, 330]"), &["\"grease\"", "grid.y[2] = 330"][..]),
        (GRID.replace("[0, 0, 0], ", ""), &["2 rows of 3 values", "row 1"]),
        (GRID.replace("[\"speed\", ", "[\"housing_temperature\", "), &["housing_temperature twice"]),
        (GRID.replace("400.0", "0.0"), &["term 2", "lag.tau = 0", "0.001 ... 1000000"]),
        (
            GRID.replace(r#""lag": {"driver": "copper_loss""#, r#""lag": {"driver": "speed""#),
            &["lag.driver = \"speed\"", "copper_loss"],
        ),
        (
            GRID.replace(r#", "lag": {"driver": "copper_loss", "tau": 400.0}"#, ""),
            &["copper_loss needs a lag"],
        ),
    ] {
        assert!(text != GRID, "{words:?}");
        let sentence = error_of(&text);
        assert!(words.iter().all(|w| sentence.contains(w)), "{words:?} in {sentence}");
    }
    let four = TermsFile::new(vec![TermText::default(); 4]).text();
    assert!(error_of(&four).contains("4 terms; the limit is 3"));
}
