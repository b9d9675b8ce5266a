//! Every rule of the validator reports its fault, and reports nothing for an FMU without faults.

mod cases_archive;
mod cases_behaviour;
mod fixture;
mod libraries;

use std::collections::{BTreeMap, HashSet};

use archive::validate::{rules, validate_static};
use fixture::{Base, Fmu, codes, findings};
use proptest::prelude::*;

/// By code: the fixture, a text in it, and what that becomes.
fn replacements() -> BTreeMap<String, Vec<(Base, String, String)>> {
    toml::from_str(include_str!("cases.toml")).unwrap()
}

#[test]
fn the_fixtures_are_clean() {
    for base in [Base::Fmi2, Base::Fmi3, Base::Clocks] {
        assert_eq!(findings(&Fmu::new(base).zip()), [], "{base:?}");
    }
    let libraries: [(&str, &str, libraries::Library); 3] = [
        ("linux64", "model.so", libraries::linux_x86_64),
        ("aarch64-linux", "model.so", libraries::linux_aarch64),
        ("darwin64", "model.dylib", libraries::darwin_x86_64),
    ];
    for (folder, file, library) in libraries {
        assert_eq!(findings(&cases_archive::with_library(folder, file, library, 0).zip()), [], "{folder}");
    }
}

#[test]
fn each_change_of_a_file_gives_its_code_and_no_other() {
    let mut failed = Vec::new();
    for (code, cases) in replacements() {
        for (base, find, by) in cases {
            let mut fmu = Fmu::new(base);
            fmu.replace(&find, &by);
            let found = codes(&fmu.zip());
            if found != [code.as_str()] {
                failed.push(format!("{base:?} {find} -> {by}: expected {code}, found {found:?}"));
            }
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn each_change_of_the_archive_gives_its_code_and_no_other() {
    let mut failed = Vec::new();
    for (code, build) in cases_archive::CASES {
        let found = codes(&build());
        if found != [*code] {
            failed.push(format!("expected {code}, found {found:?}"));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn every_rule_has_a_case_and_a_unique_code() {
    let mut covered: HashSet<&str> = HashSet::from(["file-extension"]);
    let replacements = replacements();
    covered.extend(replacements.keys().map(String::as_str));
    covered.extend(cases_archive::CASES.iter().map(|c| c.0));
    let behaviour = cases_behaviour::covered();
    covered.extend(behaviour.iter().map(String::as_str));
    let all: HashSet<&str> = rules::ALL.iter().map(|r| r.code).collect();
    assert_eq!(all.len(), rules::ALL.len(), "a code occurs twice");
    let untested: Vec<_> = all.difference(&covered).collect();
    assert!(untested.is_empty(), "rules without a case: {untested:?}");
}

#[test]
fn findings_name_line_variable_value_and_section() {
    let mut fmu = Fmu::new(Base::Fmi2);
    fmu.replace(r#"start="2" min="1""#, r#"start="5" min="1""#);
    let found = findings(&fmu.zip());
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].place, "modelDescription.xml:25");
    assert_eq!(
        found[0].message,
        "Variable \"p\" has the start value 5 outside its limits (min 1, max 3) (FMI 2.0, section 2.2.3)."
    );
    let json = serde_json::to_value(&found[0]).unwrap();
    assert_eq!((&json["severity"], &json["where"]), (&"error".into(), &"modelDescription.xml:25".into()));
}

#[test]
fn what_is_no_archive_is_unreadable_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.fmu");
    for bytes in [&b""[..], b"PK", b"not an archive at all", b"PK\x05\x06"] {
        std::fs::write(&path, bytes).unwrap();
        let error = validate_static(&path).unwrap_err().to_string();
        assert!(error.ends_with("is not a zip archive"), "{error}");
    }
    assert!(validate_static(folder.path()).unwrap_err().to_string().contains("is a folder"));
    assert!(
        validate_static(&folder.path().join("none.fmu")).unwrap_err().to_string().contains("cannot be read")
    );
}

#[test]
fn an_archive_with_another_name_is_doubtful() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.zip");
    std::fs::write(&path, Fmu::new(Base::Fmi3).zip()).unwrap();
    let found = validate_static(&path).unwrap();
    assert_eq!(found.iter().map(|f| f.code).collect::<Vec<_>>(), ["file-extension"]);
}

#[test]
fn many_findings_of_one_kind_are_summarized() {
    let mut fmu = Fmu::new(Base::Clocks);
    let many: String =
        (100..1000).map(|i| format!("<Float64 name=\"x{i}\" valueReference=\"{i}\" unit=\"?\"/>")).collect();
    fmu.replace("</ModelVariables>", &format!("{many}</ModelVariables>"));
    let found = findings(&fmu.zip());
    assert_eq!(found.len(), 201);
    assert_eq!(found[200].message, "700 more findings of this kind are not listed.");
}

/// Validates and ignores the findings: the call must return.
fn survives(bytes: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.fmu");
    std::fs::write(&path, bytes).unwrap();
    let _ = validate_static(&path);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bytes_of_an_archive_never_panic(flips in prop::collection::vec((any::<prop::sample::Index>(), 1_u8..), 1..8)) {
        let mut bytes = cases_archive::with_library("linux64", "model.so", libraries::linux_x86_64, 0).zip();
        for (index, mask) in flips {
            let at = index.index(bytes.len());
            bytes[at] ^= mask;
        }
        survives(&bytes);
    }

    #[test]
    fn truncated_archives_never_panic(index in any::<prop::sample::Index>()) {
        let bytes = Fmu::new(Base::Fmi3).zip();
        survives(&bytes[..index.index(bytes.len())]);
    }

    #[test]
    fn changed_files_inside_the_archive_never_panic(
        base in prop::sample::select(vec![Base::Fmi2, Base::Fmi3, Base::Clocks]),
        entry in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(b"0919-<>\"/ \n\xffeE.[('".to_vec())), 1..12),
    ) {
        let mut fmu = Fmu::new(base);
        fmu.add("binaries/x86_64-linux/model.so", libraries::linux_x86_64(&["fmi3GetVersion".into()]));
        let count = fmu.entries.len();
        let bytes = &mut fmu.entries[entry.index(count)].1;
        for (index, value) in flips {
            let at = index.index(bytes.len());
            bytes[at] = value;
        }
        survives(&fmu.zip());
    }

    #[test]
    fn any_text_as_an_attribute_value_never_panics(value in "\\PC{0,20}", place in 0_usize..9) {
        let mut fmu = Fmu::new(Base::Fmi3);
        let escaped = value.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let targets = ["start=\"300 301 302\"", "unit=\"K/s\"", "name=\"z\"", "derivative=\"3\"", "dependencies=\"1 3\"",
            "valueReference=\"11\"", "2026-01-31T12:00:00Z", "modelIdentifier=\"model\"", "iconBaseName=\"port\""];
        let target = targets[place];
        let by = match target.split_once('=') {
            Some((name, _)) => format!("{name}=\"{escaped}\""),
            None => escaped,
        };
        fmu.replace(target, &by);
        survives(&fmu.zip());
    }
}
