//! Small FMUs without a fault, built in memory, and the means to spoil them.

use std::io::{Cursor, Write};

use archive::validate::{Finding, validate_static};
use zip::write::SimpleFileOptions;

/// An archive before it is zipped.
#[derive(Clone)]
pub struct Fmu {
    pub entries: Vec<(String, Vec<u8>)>,
}

/// Which fixture a case starts from.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
pub enum Base {
    Fmi2,
    Fmi3,
    Clocks,
}

impl Fmu {
    pub fn new(base: Base) -> Fmu {
        let mut fmu = Fmu { entries: Vec::new() };
        let description = match base {
            Base::Fmi2 => FMI2,
            Base::Fmi3 => FMI3,
            Base::Clocks => CLOCKS,
        };
        fmu.add("modelDescription.xml", description);
        fmu.add("sources/model.c", "int model;");
        fmu.add("sources/buildDescription.xml", BUILD);
        if base != Base::Clocks {
            fmu.add("terminalsAndIcons/terminalsAndIcons.xml", TERMINALS);
        }
        fmu.add("terminalsAndIcons/port.png", include_bytes!("../../assets/icon.png"));
        fmu.add("documentation/index.html", "<html/>");
        fmu.add("documentation/licenses/license.txt", "MIT");
        fmu
    }

    pub fn add(&mut self, name: &str, bytes: impl AsRef<[u8]>) {
        self.entries.push((name.to_owned(), bytes.as_ref().to_vec()));
    }

    pub fn remove(&mut self, name: &str) {
        self.entries.retain(|(n, _)| n != name);
    }

    /// Replaces a text that must occur, in the first file that has it.
    pub fn replace(&mut self, find: &str, by: &str) {
        for (_, bytes) in &mut self.entries {
            let text = String::from_utf8(bytes.clone()).unwrap_or_default();
            if text.contains(find) {
                *bytes = text.replacen(find, by, 1).into_bytes();
                return;
            }
        }
        panic!("the fixture has no {find:?}");
    }

    pub fn zip(&self) -> Vec<u8> {
        self.zip_as(zip::CompressionMethod::Deflated)
    }

    pub fn zip_as(&self, method: zip::CompressionMethod) -> Vec<u8> {
        let options = SimpleFileOptions::default().compression_method(method);
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in &self.entries {
            writer.start_file(name.as_str(), options).unwrap();
            writer.write_all(bytes).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }
}

/// Validates bytes as a file called `model.fmu`.
pub fn findings(bytes: &[u8]) -> Vec<Finding> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.fmu");
    std::fs::write(&path, bytes).unwrap();
    validate_static(&path).unwrap()
}

/// The codes found, each once.
pub fn codes(bytes: &[u8]) -> Vec<&'static str> {
    let mut codes: Vec<_> = findings(bytes).iter().map(|f| f.code).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

const FMI2: &str = include_str!("fixtures/fmi2.xml");
const FMI3: &str = include_str!("fixtures/fmi3.xml");
const CLOCKS: &str = include_str!("fixtures/clocks.xml");
const BUILD: &str = include_str!("fixtures/buildDescription.xml");
const TERMINALS: &str = include_str!("fixtures/terminalsAndIcons.xml");
