//! Each error in a system description is one sentence with component, connector, file and line.
use crate::common::{faults, sets};
use crate::parts::*;
use cosim::SystemOptions;

#[test]
fn connections_in_toml() {
    for [old, new, expected] in faults().toml {
        let folder = Folder::new();
        let text = PAIR.replace(&old, &new);
        assert_ne!(text, PAIR);
        assert_eq!(folder.sentence(folder.toml(&text), &SystemOptions::default()), expected);
    }
}

/// Gains with a connection for each arrow.
fn gains(connect: &str) -> String {
    let components: String =
        ["a", "b", "c"].map(|n| format!("[[component]]\nname = \"{n}\"\nfmu = \"gain.fmu\"\n")).concat();
    format!("[system]\nname = \"gains\"\nconnect = [\n{connect}\n]\n{components}")
}

#[test]
fn kinds_do_not_mix() {
    let folder = Folder::new();
    for (connect, expected) in [
        ("a.some -> b.u", "a.some is Boolean and b.u is Real"),
        ("a.twice -> b.u", "a.twice is Integer and b.u is Real"),
        ("a.y -> b.n", "a.y is Real and b.n is Integer"),
    ] {
        let sentence =
            folder.sentence(folder.toml(&gains(&format!("\"{connect}\""))), &SystemOptions::default());
        assert_eq!(sentence, format!("s.toml, line 4: connection {connect}: {expected}"));
    }
}

#[test]
fn algebraic_loops_are_named() {
    let folder = Folder::new();
    let circle = gains("\"a.y -> b.u\",\n\"b.y -> c.u\",\n\"c.y -> a.u\"");
    let sentence = folder.sentence(folder.toml(&circle), &SystemOptions::default());
    assert!(sentence.starts_with("s.toml, line 4: algebraic loop: "), "{sentence}");
    let end = ": no unique solution at t = 0 s, as the gain around the loop is 1";
    assert!(sentence.ends_with(end), "{sentence}");
    let (_, way) = sentence.strip_suffix(end).unwrap().split_once("loop: ").unwrap();
    let stops: Vec<&str> = way.split(" -> ").collect();
    assert_eq!((stops.len(), stops[0]), (7, stops[6]));
    for step in ["a.y -> b.u -> b.y", "b.y -> c.u -> c.y", "c.y -> a.u -> a.y"] {
        assert!(format!("{way} -> {}", stops[1..4].join(" -> ")).contains(step), "{way}");
    }
    let own = folder.sentence(folder.toml(&gains("\"a.y -> a.u\"")), &SystemOptions::default());
    assert_eq!(own, format!("s.toml, line 4: algebraic loop: a.y -> a.u -> a.y{end}"));

    // An FMU without declared dependencies may have none: the loop is not reported as an error but in a note.
    let silent = xml("gain").replace(" dependencies=\"1 3\"", "");
    assert_ne!(silent, xml("gain"));
    folder.fmu("silent", &silent);
    let text = circle.replacen("gain.fmu", "silent.fmu", 1);
    let run =
        cosim::cosimulate(&folder.toml(&text).unwrap(), &SystemOptions::default(), &mut |_| ()).unwrap();
    let note = run.notes.iter().find(|n| n.contains("algebraic loop")).unwrap();
    assert!(note.contains("a.u -> a.y -> b.u") && note.ends_with("delayed by one step"), "{note}");
}

#[test]
fn inputs_need_a_source_or_a_value() {
    let folder = Folder::new();
    let naked = xml("rotor").replace("unit=\"N.m\" start=\"0\"", "unit=\"N.m\"");
    assert_ne!(naked, xml("rotor"));
    folder.fmu("rotor", &naked);
    let text = PAIR.replace("\"spring.torque -> rotor.torque\",", "");
    let sentence = folder.sentence(folder.toml(&text), &SystemOptions::default());
    assert_eq!(
        sentence,
        "s.toml, line 12: component rotor: the input torque has no connection, no value and no start value"
    );
    let given = SystemOptions { sets: sets(&[("rotor.torque", "1")]), ..SystemOptions::default() };
    assert!(cosim::cosimulate(&folder.toml(&text).unwrap(), &given, &mut |_| ()).is_ok());
}

#[test]
fn options_that_make_no_sense() {
    let folder = Folder::new();
    let none = SystemOptions::default;
    for (options, expected) in [
        (
            SystemOptions { sets: sets(&[("rotor.J", "x")]), ..none() },
            "setting rotor.J = x is refused: J = \"x\" is not a finite number",
        ),
        (
            SystemOptions { sets: sets(&[("motor.J", "1")]), ..none() },
            "setting motor.J = 1 is neither component.variable nor an input of the system",
        ),
        (
            SystemOptions { stop: Some(-1.0), ..none() },
            "stop time = -1 s must be finite and above the start time 0 s",
        ),
        (SystemOptions { step: Some(0.0), ..none() }, "step size = 0 s must be finite and above 0 s"),
        (SystemOptions { every: Some(0), ..none() }, "every = 0 must be above 0"),
        (SystemOptions { tolerance: Some(0.0), ..none() }, "tolerance = 0 must be above 0 and below 1"),
    ] {
        assert_eq!(folder.sentence(folder.toml(PAIR), &options), expected);
    }
    let tolerance = SystemOptions { tolerance: Some(1e-3), ..none() };
    for (flag, expected) in [
        (
            "canGetAndSetFMUstate=\"true\"",
            "tolerance = 0.001 requires rollback, but rotor cannot save its state",
        ),
        (
            "canHandleVariableCommunicationStepSize=\"true\"",
            "tolerance = 0.001 requires a variable communication step, which rotor does not support",
        ),
    ] {
        folder.fmu("rotor", &xml("rotor").replace(flag, ""));
        assert_eq!(folder.sentence(folder.toml(PAIR), &tolerance), expected);
    }
    let uneven = SystemOptions { step: Some(0.7), ..none() };
    assert_eq!(
        folder.sentence(folder.toml(PAIR), &uneven),
        "step size = 0.7 s does not divide the time from 0 s to 6 s, and rotor cannot vary its step"
    );
}

/// Times of the file are named with their line, also when the system is written as SSP; those of the caller are not.
#[test]
fn times_that_make_no_sense_have_their_line() {
    let folder = Folder::new();
    let above = "must be finite and above";
    for (old, new, expected) in [
        ("stop = 6", "stop = -1", format!("line 9: stop time = -1 s {above} the start time 0 s")),
        ("stop = 6", "stop = nan", format!("line 9: stop time = NaN s {above} the start time 0 s")),
        ("stop = 6", "stop = 6\nstart = 7", format!("line 9: stop time = 6 s {above} the start time 7 s")),
        ("stop = 6", "start = inf", "line 9: start time = inf s must be finite".to_owned()),
        ("step = 0.01", "step = \"0 ms\"", format!("line 10: step size = 0 s {above} 0 s")),
        (
            "step = 0.01",
            "step = 1e-12",
            "line 10: step size = 0.000000000001 s is too small for a span of 6 s".to_owned(),
        ),
        (
            "\"spring.fmu\"",
            "\"spring.fmu\"\nstep = 0.3",
            "line 20: component spring: its step 0.3 s does not divide the communication step 0.01 s"
                .to_owned(),
        ),
    ] {
        let text = PAIR.replace(old, new);
        assert_ne!(text, PAIR);
        assert_eq!(
            folder.sentence(folder.toml(&text), &SystemOptions::default()),
            format!("s.toml, {expected}")
        );
        let written = folder.toml(&text).unwrap().write_ssp(&folder.path("s.ssp"), cosim::SspForm::default());
        assert!(written.unwrap_err().to_string().ends_with(&expected), "{text}");
    }
    let text = PAIR.replace("stop = 6", "stop = 6\nstart = 7");
    let asked = SystemOptions { stop: Some(5.0), ..SystemOptions::default() };
    let sentence = folder.sentence(folder.toml(&text), &asked);
    assert_eq!(sentence, format!("stop time = 5 s {above} the start time 7 s"));
    let ssd = component("").replace(
        "</SystemStructureDescription>",
        "<DefaultExperiment\nstartTime=\"1\" stopTime=\"0\"/>\n</SystemStructureDescription>",
    );
    let sentence = folder.sentence(folder.ssp(&ssd, &[]), &SystemOptions::default());
    let expected = format!("s.ssp: SystemStructure.ssd, line 9: stop time = 0 s {above} the start time 1 s");
    assert_eq!(sentence, expected);
}

#[test]
fn a_tolerance_that_cannot_be_met_is_an_error() {
    let folder = Folder::new();
    // No step is that short: far below a billionth of the time.
    let options = SystemOptions {
        tolerance: Some(1e-3),
        sets: sets(&[("rotor.longest", "1e-12")]),
        ..SystemOptions::default()
    };
    assert_eq!(
        folder.sentence(folder.toml(PAIR), &options),
        "fmi2DoStep of rotor returned Discard at t = 0 s: the step is too long for me"
    );
    // Rounding alone is more than this.
    let tiny = SystemOptions { tolerance: Some(1e-300), ..SystemOptions::default() };
    let sentence = folder.sentence(folder.toml(PAIR), &tiny);
    assert!(
        sentence.contains(" cannot be met at t = ") && sentence.ends_with(" s are still too long"),
        "{sentence}"
    );
}

const HEAD: &str = r#"<SystemStructureDescription version="1.0" name="x">"#;

fn ssd(system: &str) -> String {
    format!("{HEAD}\n<System name=\"x\">\n{system}\n</System>\n</SystemStructureDescription>")
}

fn component(inside: &str) -> String {
    ssd(&format!(
        "<Elements>\n<Component name=\"g\" source=\"resources/gain.fmu\">\n{inside}\n</Component>\n</Elements>"
    ))
}

#[test]
fn structures_of_ssp() {
    let binding = |inside: &str| component(&format!("<ParameterBindings>\n{inside}\n</ParameterBindings>"));
    let value = |v: &str| {
        binding(&format!(
            "<ParameterBinding><ParameterValues><ParameterSet><Parameters>\n{v}\n</Parameters></ParameterSet></ParameterValues></ParameterBinding>"
        ))
    };
    let joined = |connector: &str, connection: &str| {
        ssd(&format!(
            "<Elements>\n<Component name=\"g\" source=\"resources/gain.fmu\"><Connectors>\n{connector}\n\
             <Connector name=\"y\" kind=\"output\"/></Connectors></Component>\n</Elements>\n<Connections>\n{connection}\n</Connections>"
        ))
    };
    for [form, first, second, expected] in faults().ssp {
        let text = match form.as_str() {
            "whole" => first,
            "system" => ssd(&first),
            "component" => component("").replace(&first, &second),
            "binding" => binding(&first),
            "value" => value(&first),
            "joined" => joined(&first, &second),
            other => panic!("{other}"),
        };
        let folder = Folder::new();
        let sentence = folder.sentence(folder.ssp(&text, &[]), &SystemOptions::default());
        let found =
            sentence.strip_prefix("s.ssp: SystemStructure.ssd, ").or(sentence.strip_prefix("s.ssp, "));
        let found = found.unwrap_or_else(|| panic!("{sentence}"));
        assert!(found == expected || expected.ends_with("XML") && found.starts_with(&expected), "{found}");
    }
}

#[test]
fn files_that_are_no_systems() {
    let folder = Folder::new();
    std::fs::write(folder.path("text.ssp"), "hello").unwrap();
    zip(&folder.path("empty.ssp"), &[("a.txt", b"a")]);
    zip(&folder.path("out.ssp"), &[("../a.txt", b"a")]);
    for (name, expected) in [
        ("text.ssp", "text.ssp is not a usable SSP archive: "),
        ("empty.ssp", "empty.ssp is not a usable SSP archive: it has no SystemStructure.ssd"),
        (
            "out.ssp",
            "out.ssp is not a usable SSP archive: entry \"../a.txt\" is not a relative path with forward slashes",
        ),
        ("none.ssp", "cannot open none.ssp: "),
        ("none.toml", "cannot read none.toml: "),
    ] {
        let sentence = folder.sentence(cosim::System::open(&folder.path(name)), &SystemOptions::default());
        assert!(sentence.starts_with(expected), "{sentence}");
    }
    // An FMU that is none, seen through the system.
    std::fs::write(folder.path("gain.fmu"), "hello").unwrap();
    let sentence = folder.sentence(folder.ssp(&component(""), &[]), &SystemOptions::default());
    assert!(
        sentence.starts_with(
            "s.ssp: SystemStructure.ssd, line 4: component g: resources/gain.fmu is not a usable FMU"
        ),
        "{sentence}"
    );
}
