//! Faults that show only when the FMU runs, in this process: a few of those that `tests/python/validator` seeds into its
//! oscillator, which is compiled here, too. The whole list runs there, through the program and its child.

use archive::validate::{dynamic, validate_static};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where the oscillator and the list of all seeded faults are.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/python/validator");

/// Code expected, and the fault.
const CASES: &[(&str, &str)] = &[
    ("instantiate", "instantiate"),
    ("life-cycle", "step_error"),
    ("reset", "reset_parameter"),
    ("rollback", "rollback_input"),
    ("exchange-differs", "dynamics_steps"),
    ("directional-derivative", "directional"),
];

/// Codes that need the program and its child, or no FMU at all: see `validate/dynamic.rs`. (A leak, which is in the list of `faults.py`, needs
/// them too: other tests of this process free memory while it is measured.)
const OTHERS: &[&str] =
    &["not-run", "load", "crash", "hang", "hang-on-misuse", "rollback-inexact", "time-limit"];

/// All codes that are seen to be found here or in Python.
pub fn covered() -> Vec<String> {
    let list = std::fs::read_to_string(format!("{FOLDER}/faults.py")).unwrap();
    // The first text of each `Fault(...)` and `seeded(...)`.
    let first = |call: &'static str| list.split(call).skip(1).filter_map(|rest| rest.split('"').nth(1));
    let seeded = first("Fault(").chain(first("seeded(")).map(str::to_owned);
    OTHERS.iter().map(|s| (*s).to_owned()).chain(seeded).collect()
}

const MARK: &[u8] = b"SEEDED-FAULT-IS:";

/// The oscillator of FMI 2 with one fault (or none), in a folder of its own; with `platform` as its only binary folder.
fn oscillator(fault: &str, platform: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("oscillator.so");
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-O1", "-w", "-o"]).arg(&library).arg(format!("{FOLDER}/fmi2.c")).arg("-lm");
    assert!(cc.status().expect("cc is needed, as for linking Rust").success());
    let mut bytes = std::fs::read(library).unwrap();
    let at = bytes.windows(MARK.len()).position(|w| w == MARK).unwrap() + MARK.len();
    let text = format!("{fault}\0");
    bytes[at..at + text.len()].copy_from_slice(text.as_bytes());
    let path = folder.path().join("oscillator.fmu");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let options = zip::write::SimpleFileOptions::default();
    zip.start_file("modelDescription.xml", options).unwrap();
    zip.write_all(&std::fs::read(format!("{FOLDER}/fmi2.xml")).unwrap()).unwrap();
    for name in ["documentation/index.html", "documentation/licenses/license.txt"] {
        zip.start_file(name, options).unwrap();
    }
    zip.start_file(format!("binaries/{platform}/oscillator.so"), options).unwrap();
    zip.write_all(&bytes).unwrap();
    zip.finish().unwrap();
    (folder, path)
}

/// This machine's folder of FMI 2.
fn here() -> &'static str {
    if cfg!(target_arch = "aarch64") { "aarch64-linux" } else { "linux64" }
}

/// Observations of the child process.
fn codes(path: &Path) -> Vec<String> {
    let mut codes = Vec::new();
    dynamic::probe(path, 0, &mut |event| {
        if let dynamic::Event::Seen(o) = event {
            codes.push(o.code);
        }
    });
    codes.dedup();
    codes
}

#[test]
fn without_a_fault_nothing_is_found() {
    let (_folder, path) = oscillator("none", here());
    assert_eq!(validate_static(&path).unwrap(), []);
    assert_eq!(codes(&path), [""; 0]);
}

#[test]
fn each_fault_gives_its_code() {
    for (code, fault) in CASES {
        let (_folder, path) = oscillator(fault, here());
        assert_eq!(validate_static(&path).unwrap(), [], "{fault} does not show without running");
        let found = codes(&path);
        assert!(found.iter().any(|c| c == code), "{fault}: {found:?}");
    }
}

#[test]
fn an_fmu_for_another_platform_is_not_run_and_said_so() {
    let (_folder, path) = oscillator("none", "win64");
    assert_eq!(codes(&path), ["not-run"]);
}
