//! Test FMUs: C compiled on the spot with the linker's compiler, zipped with a model description.

use cosim::{Archive, Error, FmiVersion, InputTable, Options, Recording, simulate};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

pub const BOTH: [FmiVersion; 2] = [FmiVersion::V2, FmiVersion::V3];

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The compiled test FMU of a standard.
pub fn binary(version: FmiVersion) -> &'static [u8] {
    static BUILT: [OnceLock<Vec<u8>>; 2] = [OnceLock::new(), OnceLock::new()];
    let (slot, source) = match version {
        FmiVersion::V2 => (&BUILT[0], "lag2.c"),
        FmiVersion::V3 => (&BUILT[1], "lag3.c"),
    };
    slot.get_or_init(|| compile(&data(source)))
}

/// Compiles one C file to a shared library.
pub fn compile(source: &Path) -> Vec<u8> {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("lag.so");
    let status = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-Wall", "-o"])
        .args([&out, source])
        .arg("-lm")
        .status()
        .expect("cc is needed, as for linking Rust");
    assert!(status.success());
    fs::read(out).unwrap()
}

pub fn xml(version: FmiVersion) -> String {
    let name = if version == FmiVersion::V2 { "lag2.xml" } else { "lag3.xml" };
    fs::read_to_string(data(name)).unwrap()
}

pub fn binary_name(version: FmiVersion) -> &'static str {
    let arm = cfg!(target_arch = "aarch64");
    match version {
        FmiVersion::V2 if !arm => "binaries/linux64/lag.so",
        FmiVersion::V3 if !arm => "binaries/x86_64-linux/lag.so",
        _ => "binaries/aarch64-linux/lag.so",
    }
}

/// An archive in a directory of its own.
pub struct Fmu {
    pub dir: tempfile::TempDir,
    pub path: PathBuf,
}

impl Fmu {
    pub fn with(entries: &[(&str, &[u8])]) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("lag.fmu");
        crate::parts::zip(&path, entries);
        Self { dir, path }
    }

    pub fn good(version: FmiVersion) -> Self {
        Self::described(version, &xml(version))
    }

    pub fn described(version: FmiVersion, xml: &str) -> Self {
        Self::with(&[
            ("modelDescription.xml", xml.as_bytes()),
            (binary_name(version), binary(version)),
            ("resources/a.txt", b"a"),
        ])
    }

    pub fn open(&self) -> Result<Archive, Error> {
        Archive::open(&self.path)
    }

    /// The message of opening and instantiating, without the directory of the test.
    pub fn message(&self) -> String {
        let done = self.open().and_then(|a| cosim::Instance::instantiate(&a, "lag", cosim::Log::new()));
        self.strip(&done.map(|_| ()).unwrap_err().to_string())
    }

    pub fn strip(&self, message: &str) -> String {
        message.replace(&format!("{}/", self.dir.path().display()), "")
    }
}

pub fn sets(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
    pairs.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect()
}

pub fn run(version: FmiVersion, options: &Options) -> Result<Recording, Error> {
    simulate(&Fmu::good(version).open()?, options, &mut |_| ())
}

pub fn table(version: FmiVersion, text: &str) -> InputTable {
    let fmu = Fmu::good(version);
    let path = fmu.dir.path().join("in.csv");
    fs::write(&path, text).unwrap();
    InputTable::read(&path, fmu.open().unwrap().description(), false).unwrap()
}

/// The tables of `data/faults.toml`.
#[derive(serde::Deserialize)]
pub struct Faults {
    pub toml: Vec<[String; 3]>,
    pub ssp: Vec<[String; 4]>,
    pub description: Vec<[String; 2]>,
    pub setting: Vec<[String; 3]>,
}

pub fn faults() -> Faults {
    toml::from_str(include_str!("../data/faults.toml")).unwrap()
}
