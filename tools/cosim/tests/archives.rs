//! Archives and descriptions, good and broken: each fault gives its one sentence.
use crate::common::*;
use cosim::{Archive, Causality, Dimension, FmiVersion, Kind, ModelDescription, Variability};
use std::fs;

#[test]
fn descriptions_of_both_standards_say_the_same() {
    for version in BOTH {
        let d = ModelDescription::parse(&xml(version)).unwrap();
        assert_eq!((d.fmi_version, d.model_name.as_str(), d.token.as_str()), (version, "Lag", "lag-guid"));
        let cs = d.co_simulation().unwrap();
        assert!(cs.can_handle_variable_step && cs.can_get_and_set_state && cs.can_serialize_state);
        assert_eq!(cs.can_interpolate_inputs, version == FmiVersion::V2);
        assert!(d.interface(cosim::raw::InterfaceType::ModelExchange).is_none());
        assert_eq!(d.default_experiment.step, Some(0.01));
        assert_eq!(d.log_categories, ["all"]);

        let u = d.variable("u").unwrap();
        assert_eq!(
            (u.kind, u.causality, u.variability),
            (Kind::Float64, Causality::Input, Variability::Continuous)
        );
        assert_eq!((u.min, u.max, u.unit.as_deref()), (Some(-10.0), Some(10.0), Some("K")));
        let shown = d.display_unit(u).unwrap();
        assert_eq!((shown.name.as_str(), shown.show(273.15)), ("degC", 0.0));
        let mode = d.variable("mode").unwrap();
        assert_eq!(mode.kind, Kind::Enumeration);
        assert_eq!(d.enumeration(mode).unwrap().items[2].name, "fast");
        let line = xml(version).lines().position(|l| l.contains("name=\"mode\"")).unwrap() as u32 + 1;
        assert_eq!(mode.line, line);
        assert_eq!(d.variable("warm").unwrap().variability, Variability::Discrete);
    }
    let d = ModelDescription::parse(&xml(FmiVersion::V3)).unwrap();
    let y = d.variable("y").unwrap();
    assert_eq!(y.dimensions, [Dimension::Reference(11)]);
    assert_eq!(d.element_count(y, &|_| None), 2);
    assert_eq!(d.element_count(y, &|_| Some(5)), 5);
}

#[test]
fn broken_descriptions_name_the_line() {
    for [text, expected] in faults().description {
        let message = ModelDescription::parse(&text).unwrap_err().to_string();
        assert!(message.starts_with(&expected), "{message}");
    }
}

#[test]
fn a_billion_laughs_is_refused() {
    let text = r#"<!DOCTYPE l [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;">]><fmiModelDescription>&b;</fmiModelDescription>"#;
    assert!(ModelDescription::parse(text).is_err());
}

#[test]
fn what_is_no_archive_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("x.fmu");
    let message = || Archive::open(&path).unwrap_err().to_string();
    assert!(message().starts_with(&format!("cannot open {}: No such file", path.display())));
    for bytes in [&b""[..], b"no zip at all", &[0x50, 0x4b, 3, 4, 0, 0]] {
        fs::write(&path, bytes).unwrap();
        assert!(message().contains("x.fmu is not a usable FMU archive: "), "{}", message());
    }
    assert!(Archive::open(dir.path()).unwrap_err().to_string().ends_with("it is a directory"));

    let whole = fs::read(&Fmu::good(FmiVersion::V2).path).unwrap();
    for length in (0..whole.len()).step_by(whole.len() / 50) {
        fs::write(&path, &whole[..length]).unwrap();
        assert!(Archive::open(&path).is_err());
    }
    // A damaged entry, with the directory intact.
    let mut damaged = whole;
    damaged[200..300].fill(0x55);
    fs::write(&path, damaged).unwrap();
    assert!(message().contains("x.fmu is not a usable FMU archive: entry"), "{}", message());
}

#[test]
fn names_that_lead_out_are_refused() {
    for name in ["../evil", "/etc/evil", "a/../../evil", "a\\..\\evil"] {
        let fmu = Fmu::with(&[("modelDescription.xml", b"<a/>"), (name, b"x")]);
        let message = fmu.message();
        assert!(message.contains("is not a relative path with forward slashes"), "{message}");
        assert!(!fmu.dir.path().join("evil").exists());
    }
}

#[test]
fn archives_that_cannot_run_say_why() {
    let says = |fmu: Fmu, expected: &str| {
        let message = fmu.message();
        assert!(message.starts_with(expected), "{message}");
    };
    for version in BOTH {
        let (xml, name) = (xml(version), binary_name(version));
        let description = ("modelDescription.xml", xml.as_bytes());
        says(Fmu::with(&[("a", b"")]), "lag.fmu is not a usable FMU archive: it has no modelDescription.xml");
        says(
            Fmu::with(&[("modelDescription.xml", b"\xff\xfe<")]),
            "lag.fmu is not a usable FMU archive: its modelDescription.xml, line 1, is not text of the declared encoding",
        );
        says(
            Fmu::with(&[("modelDescription.xml", b"<a>")]),
            "lag.fmu: modelDescription.xml, line 1: not well-formed",
        );
        says(
            Fmu::with(&[description]),
            &format!("lag.fmu has no binary {name} for this platform, it has none at all"),
        );
        says(
            Fmu::with(&[description, ("binaries/win64/lag.dll", b"")]),
            &format!("lag.fmu has no binary {name} for this platform, it has win64"),
        );
        says(Fmu::with(&[description, (name, b"no library")]), &format!("cannot load {name} of lag.fmu: "));
        let other = if version == FmiVersion::V2 { FmiVersion::V3 } else { FmiVersion::V2 };
        let missing =
            if version == FmiVersion::V2 { "fmi2Instantiate" } else { "fmi3InstantiateCoSimulation" };
        says(
            Fmu::with(&[description, (name, binary(other))]),
            &format!("the binary of lag.fmu does not export {missing}"),
        );
        let wrong = Fmu::described(version, &xml.replace("lag-guid", "other"));
        let word = if version == FmiVersion::V2 { "guid" } else { "token" };
        says(wrong, &format!("lag.fmu refused to be instantiated as lag: the {word} is not mine"));
        let exchange = xml.replace("CoSimulation", "ModelExchange");
        says(Fmu::described(version, &exchange), "lag.fmu cannot be stepped: it is for Model Exchange only");
        let scheduled = xml.replace("CoSimulation", "ScheduledExecution");
        let expected = "lag.fmu cannot be stepped: it is for Scheduled Execution only, which this program does not support";
        if version == FmiVersion::V3 {
            says(Fmu::described(version, &scheduled), expected);
        }
    }
}

#[test]
fn unpacked_files_go_with_the_last_user() {
    let archive = Fmu::good(FmiVersion::V2).open().unwrap();
    let dir = archive.dir().to_owned();
    let instance = cosim::Instance::instantiate(&archive, "a", cosim::Log::new()).unwrap();
    drop(archive);
    assert!(dir.join("resources/a.txt").exists());
    drop(instance);
    assert!(!dir.exists());
}
