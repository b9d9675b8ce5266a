//! Faults that show only when the FMU runs: a C file compiled with one fault each.

use archive::validate::{dynamic, validate_static};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Code expected, and the macro that switches the fault on.
pub const CASES: &[(&str, &str)] = &[
    ("instantiate", "FAULT_INSTANTIATE"),
    ("life-cycle", "FAULT_LIFE_CYCLE"),
    ("output-not-finite", "FAULT_NOT_FINITE"),
    ("reset", "FAULT_RESET"),
];

/// Codes that are triggered by other means: below, and by stand-ins for the child in `validate/dynamic.rs`.
pub const OTHERS: &[&str] = &["not-run", "crash", "hang"];

const XML: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="faulty" guid="{faulty}">
  <CoSimulation modelIdentifier="faulty" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="x" valueReference="1" causality="output" variability="continuous" initial="calculated"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="1"/></Outputs>
    <InitialUnknowns><Unknown index="1"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"#;

/// The FMU with one fault (or none), in a folder of its own; with `platform` as its only binary folder.
fn faulty(fault: Option<&str>, platform: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("faulty.so");
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-O1", "-w", "-o"]).arg(&library);
    cc.args(fault.map(|f| format!("-D{f}")))
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/validate/faulty.c"));
    assert!(cc.arg("-lm").status().expect("cc is needed, as for linking Rust").success());
    let path = folder.path().join("faulty.fmu");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let options = zip::write::SimpleFileOptions::default();
    zip.start_file("modelDescription.xml", options).unwrap();
    zip.write_all(XML.as_bytes()).unwrap();
    zip.start_file(format!("binaries/{platform}/faulty.so"), options).unwrap();
    zip.write_all(&std::fs::read(library).unwrap()).unwrap();
    zip.finish().unwrap();
    (folder, path)
}

/// This machine's folder of FMI 2.
fn here() -> &'static str {
    if cfg!(target_arch = "aarch64") { "aarch64-linux" } else { "linux64" }
}

/// What the child saw, as the parent reads it.
fn codes(path: &Path) -> Vec<String> {
    let seen = serde_json::to_value(dynamic::probe(path)).unwrap();
    seen.as_array().unwrap().iter().map(|o| o["code"].as_str().unwrap().to_string()).collect()
}

#[test]
fn without_a_fault_nothing_is_found() {
    let (_folder, path) = faulty(None, here());
    assert_eq!(validate_static(&path).unwrap(), []);
    assert!(codes(&path).is_empty());
}

#[test]
fn each_fault_gives_its_code_and_no_other() {
    for (code, fault) in CASES {
        let (_folder, path) = faulty(Some(fault), here());
        assert_eq!(validate_static(&path).unwrap(), [], "{fault} does not show without running");
        assert_eq!(codes(&path), [*code], "{fault}");
    }
}

#[test]
fn an_fmu_for_another_platform_is_not_run_and_said_so() {
    let (_folder, path) = faulty(None, "win64");
    assert_eq!(codes(&path), ["not-run"]);
}
