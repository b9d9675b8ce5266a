//! One fault per rule, as a change of the archive.

use crate::elf;
use crate::fixture::{Base, Fmu};

/// Code, and the archive that has this fault and no other.
pub type Case = (&'static str, fn() -> Vec<u8>);

fn with(name: &str) -> Vec<u8> {
    let mut fmu = Fmu::new(Base::Fmi2);
    fmu.add(name, "x");
    fmu.zip()
}

/// Changes the archive's bytes: `at` counts from the directory header of the first entry.
fn in_directory(base: Base, change: impl Fn(&mut [u8])) -> Vec<u8> {
    let mut bytes = Fmu::new(base).zip();
    let at = bytes.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
    change(&mut bytes[at..]);
    bytes
}

/// Renames an entry in both of its headers.
fn rename(mut bytes: Vec<u8>, from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    for at in 0..bytes.len() - from.len() {
        if bytes[at..].starts_with(from.as_bytes()) {
            bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
        }
    }
    bytes
}

/// The fixture of FMI 2 with a library for the folder `linux64`.
pub fn with_library(folder: &str, file: &str, machine: u16, drop: usize) -> Fmu {
    let mut fmu = Fmu::new(Base::Fmi2);
    let functions = "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment \
        EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString \
        SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize \
        SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative EnterEventMode NewDiscreteStates \
        EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates GetDerivatives \
        GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates SetRealInputDerivatives \
        GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus \
        GetStringStatus";
    let names: Vec<_> = functions.split_ascii_whitespace().skip(drop).map(|f| format!("fmi2{f}")).collect();
    fmu.add(&format!("binaries/{folder}/{file}"), elf::library(machine, &names));
    fmu
}

pub const CASES: &[Case] = &[
    ("archive-spanned", || {
        let mut bytes = Fmu::new(Base::Fmi2).zip();
        let end = bytes.len() - 22;
        bytes[end + 4] = 1;
        bytes
    }),
    ("archive-bomb", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.add("resources/zeros", vec![0; 140 << 20]);
        fmu.zip()
    }),
    ("entry-duplicate", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.add("resources/a", "x");
        fmu.add("resources/b", "x");
        rename(fmu.zip(), "resources/b", "resources/a")
    }),
    ("entry-case", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.add("resources/a", "x");
        fmu.add("resources/A", "x");
        fmu.zip()
    }),
    ("entry-backslash", || rename(with("resources/data"), "resources/data", "resources\\data")),
    ("entry-absolute", || rename(with("resources/data"), "resources/data", "/esources/data")),
    ("entry-absolute", || rename(with("resources/data"), "resources/data", "c:sources/data")),
    ("entry-outside", || rename(with("resources/data"), "resources/data", "../ources/data")),
    ("entry-not-ascii", || with("resources/größe")),
    ("entry-unportable", || with("resources/what?")),
    ("entry-encrypted", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.entries.insert(0, ("resources/a".into(), b"x".to_vec()));
        let mut bytes = fmu.zip();
        let at = bytes.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
        bytes[at + 8] |= 1;
        bytes[6] |= 1;
        bytes
    }),
    ("entry-method", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.entries.insert(0, ("resources/a".into(), b"x".to_vec()));
        let mut bytes = fmu.zip();
        let at = bytes.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
        bytes[at + 10] = 12;
        bytes[8] = 12;
        bytes
    }),
    ("entry-version", || in_directory(Base::Fmi3, |b| b[6] = 45)),
    ("entry-descriptor", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.entries.insert(0, ("resources/a".into(), Vec::new()));
        let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let stored =
            zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        for (name, bytes) in &fmu.entries {
            writer.start_file(name.as_str(), stored).unwrap();
            std::io::Write::write_all(&mut writer, bytes).unwrap();
        }
        let mut bytes = writer.finish().unwrap().into_inner();
        let at = bytes.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
        bytes[at + 8] |= 8;
        bytes
    }),
    ("entry-link", || {
        in_directory(Base::Fmi2, |b| {
            b[5] = 3;
            b[38..42].copy_from_slice(&(0o120777_u32 << 16).to_le_bytes());
        })
    }),
    ("entry-header", || {
        let mut bytes = Fmu::new(Base::Fmi2).zip();
        bytes[30] = b'M';
        bytes
    }),
    ("entry-damaged", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.entries.insert(0, ("resources/a".into(), b"some text".to_vec()));
        let mut bytes = fmu.zip();
        let at = bytes.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
        // The checksum, in both headers.
        bytes[at + 16] ^= 1;
        bytes[14] ^= 1;
        bytes
    }),
    ("model-description-missing", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.entries[0].0 = "Model/modelDescription.xml".into();
        fmu.zip()
    }),
    ("xml-not-utf8", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.entries[0].1[60] = 0xE4;
        fmu.zip()
    }),
    ("xml-depth", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.replace("<x/>", &format!("{}{}", "<x>".repeat(20_000), "</x>".repeat(20_000)));
        fmu.zip()
    }),
    ("fmi-version-newer", || {
        let mut fmu = Fmu::new(Base::Clocks);
        fmu.replace("fmiVersion=\"3.0\" modelName", "fmiVersion=\"3.1\" modelName");
        fmu.replace("fmiBuildDescription fmiVersion=\"3.0\"", "fmiBuildDescription fmiVersion=\"3.1\"");
        fmu.zip()
    }),
    ("model-exchange-only", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.replace("<ModelExchange modelIdentifier=\"model\" canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\">\n    <SourceFiles><File name=\"model.c\"/></SourceFiles>\n  </ModelExchange>", "");
        fmu.zip()
    }),
    ("state-repeated", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.replace(
            "valueReference=\"9\"><Real/>",
            "valueReference=\"9\" initial=\"exact\"><Real derivative=\"3\" start=\"0\"/>",
        );
        fmu.replace("<Derivatives>", "<Derivatives><Unknown index=\"13\"/>");
        fmu.zip()
    }),
    ("state-causality", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.replace("causality=\"local\" initial=\"exact\"", "causality=\"input\"");
        fmu.zip()
    }),
    ("no-implementation", || {
        let mut fmu = Fmu::new(Base::Clocks);
        fmu.remove("sources/model.c");
        fmu.remove("sources/buildDescription.xml");
        fmu.zip()
    }),
    ("svg-without-png", || with("terminalsAndIcons/icon.svg")),
    ("documentation-missing", || {
        let mut fmu = Fmu::new(Base::Fmi2);
        fmu.remove("documentation/index.html");
        fmu.zip()
    }),
    ("license-missing", || {
        let mut fmu = Fmu::new(Base::Fmi3);
        fmu.remove("documentation/licenses/license.txt");
        fmu.zip()
    }),
    ("license-entry", || {
        let mut fmu = Fmu::new(Base::Fmi3);
        fmu.remove("documentation/licenses/license.txt");
        fmu.add("documentation/licenses/MIT", "MIT");
        fmu.zip()
    }),
    ("tool-undocumented", || {
        let mut fmu = Fmu::new(Base::Fmi3);
        fmu.replace("fixedInternalStepSize", "needsExecutionTool=\"true\" fixedInternalStepSize");
        fmu.zip()
    }),
    ("build-description-missing", || {
        let mut fmu = Fmu::new(Base::Fmi3);
        fmu.remove("sources/buildDescription.xml");
        fmu.zip()
    }),
    ("platform-of-fmi2", || {
        let mut fmu = Fmu::new(Base::Fmi3);
        fmu.add("binaries/linux64/model.a", "static");
        fmu.zip()
    }),
    ("platform-of-fmi3", || with_library("x86_64-linux", "model.so", elf::X86_64, 0).zip()),
    ("platform-unknown", || with("binaries/amiga/model.library")),
    ("binary-missing", || with_library("linux64", "wrong.so", elf::X86_64, 0).zip()),
    ("binary-missing", || with_library("linux64", "model.dll", elf::X86_64, 0).zip()),
    ("binary-format", || with("binaries/linux64/model.so")),
    ("binary-architecture", || with_library("linux64", "model.so", elf::AARCH64, 0).zip()),
    ("binary-architecture", || with_library("win64", "model.dll", elf::X86_64, 0).zip()),
    ("symbol-missing", || with_library("linux64", "model.so", elf::X86_64, 1).zip()),
];
