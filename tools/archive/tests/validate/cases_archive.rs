//! One fault per rule, as a change of the archive.

use crate::fixture::Base::{self, Clocks, Fmi2, Fmi3};
use crate::fixture::Fmu;
use crate::libraries::{Library, darwin_x86_64, linux_aarch64, linux_x86_64};

/// Code, and the archive that has this fault and no other.
pub type Case = (&'static str, fn() -> Vec<u8>);

/// A fixture with a change.
fn changed(base: Base, change: impl Fn(&mut Fmu)) -> Vec<u8> {
    let mut fmu = Fmu::new(base);
    change(&mut fmu);
    fmu.zip()
}

fn with(name: &str) -> Vec<u8> {
    changed(Fmi2, |fmu| fmu.add(name, "x"))
}

/// Changes the archive's bytes: `at` counts from the directory header of the first entry.
fn in_directory(base: Base, change: impl Fn(&mut [u8])) -> Vec<u8> {
    in_headers(Fmu::new(base).zip(), |_, directory| change(directory))
}

/// Changes an archive with this text as its first entry: the bytes from that entry's local header on, and from its
/// directory header on.
fn in_first(text: &str, change: impl Fn(&mut [u8], &mut [u8])) -> Vec<u8> {
    in_headers(changed(Fmi2, |fmu| fmu.entries.insert(0, ("resources/a".into(), text.into()))), change)
}

fn in_headers(mut bytes: Vec<u8>, change: impl Fn(&mut [u8], &mut [u8])) -> Vec<u8> {
    let at = bytes.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
    let (entries, directory) = bytes.split_at_mut(at);
    change(entries, directory);
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

/// The fixture of FMI 2 with a library that lacks the first `drop` functions.
pub fn with_library(folder: &str, file: &str, library: Library, drop: usize) -> Fmu {
    let mut fmu = Fmu::new(Fmi2);
    let functions = "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment \
        EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString \
        SetReal SetInteger SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize \
        SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative EnterEventMode NewDiscreteStates \
        EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates GetDerivatives \
        GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates SetRealInputDerivatives \
        GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus \
        GetStringStatus";
    let names: Vec<_> = functions.split_ascii_whitespace().skip(drop).map(|f| format!("fmi2{f}")).collect();
    fmu.add(&format!("binaries/{folder}/{file}"), library(&names));
    fmu
}

pub const CASES: &[Case] = &[
    ("archive-spanned", || {
        let mut bytes = Fmu::new(Fmi2).zip();
        let end = bytes.len() - 22;
        bytes[end + 4] = 1;
        bytes
    }),
    ("archive-bomb", || changed(Fmi2, |fmu| fmu.add("resources/zeros", vec![0; 140 << 20]))),
    ("entry-duplicate", || {
        let mut fmu = Fmu::new(Fmi2);
        fmu.add("resources/a", "x");
        fmu.add("resources/b", "x");
        rename(fmu.zip(), "resources/b", "resources/a")
    }),
    ("entry-case", || {
        changed(Fmi2, |fmu| {
            fmu.add("resources/a", "x");
            fmu.add("resources/A", "x");
        })
    }),
    ("entry-backslash", || rename(with("resources/data"), "resources/data", "resources\\data")),
    ("entry-absolute", || rename(with("resources/data"), "resources/data", "/esources/data")),
    ("entry-absolute", || rename(with("resources/data"), "resources/data", "c:sources/data")),
    ("entry-outside", || rename(with("resources/data"), "resources/data", "../ources/data")),
    ("entry-not-ascii", || with("resources/größe")),
    ("entry-unportable", || with("resources/what?")),
    ("entry-encrypted", || {
        in_first("x", |local, directory| {
            directory[8] |= 1;
            local[6] |= 1;
        })
    }),
    ("entry-method", || {
        in_first("x", |local, directory| {
            directory[10] = 12;
            local[8] = 12;
        })
    }),
    ("entry-version", || in_directory(Fmi3, |b| b[6] = 45)),
    ("entry-descriptor", || {
        let mut fmu = Fmu::new(Fmi2);
        fmu.entries.insert(0, ("resources/a".into(), Vec::new()));
        in_headers(fmu.zip_as(zip::CompressionMethod::Stored), |_, directory| directory[8] |= 8)
    }),
    ("entry-link", || {
        in_directory(Fmi2, |b| {
            b[5] = 3;
            b[38..42].copy_from_slice(&(0o120777_u32 << 16).to_le_bytes());
        })
    }),
    ("entry-header", || {
        let mut bytes = Fmu::new(Fmi2).zip();
        bytes[30] = b'M';
        bytes
    }),
    ("entry-damaged", || {
        // The checksum, in both headers.
        in_first("some text", |local, directory| {
            directory[16] ^= 1;
            local[14] ^= 1;
        })
    }),
    ("model-description-missing", || {
        changed(Fmi2, |fmu| fmu.entries[0].0 = "Model/modelDescription.xml".into())
    }),
    ("xml-not-utf8", || changed(Fmi2, |fmu| fmu.entries[0].1[60] = 0xE4)),
    ("xml-depth", || {
        changed(Fmi2, |fmu| {
            fmu.replace("<x/>", &format!("{}{}", "<x>".repeat(20_000), "</x>".repeat(20_000)))
        })
    }),
    ("fmi-version-newer", || {
        changed(Clocks, |fmu| {
            fmu.replace("fmiVersion=\"3.0\" modelName", "fmiVersion=\"3.1\" modelName");
            fmu.replace("fmiBuildDescription fmiVersion=\"3.0\"", "fmiBuildDescription fmiVersion=\"3.1\"");
        })
    }),
    ("state-repeated", || {
        changed(Fmi2, |fmu| {
            fmu.replace(
                "valueReference=\"9\"><Real/>",
                "valueReference=\"9\" initial=\"exact\"><Real derivative=\"3\" start=\"0\"/>",
            );
            fmu.replace("<Derivatives>", "<Derivatives><Unknown index=\"13\"/>");
        })
    }),
    ("no-implementation", || {
        changed(Clocks, |fmu| {
            fmu.remove("sources/model.c");
            fmu.remove("sources/buildDescription.xml");
        })
    }),
    ("svg-without-png", || {
        changed(Fmi2, |fmu| {
            fmu.add("terminalsAndIcons/icon.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"/>")
        })
    }),
    ("picture-unreadable", || with("model.png")),
    ("picture-unreadable", || with("documentation/diagram.png")),
    ("documentation-missing", || changed(Fmi2, |fmu| fmu.remove("documentation/index.html"))),
    ("license-missing", || changed(Fmi3, |fmu| fmu.remove("documentation/licenses/license.txt"))),
    ("license-entry", || {
        changed(Fmi3, |fmu| {
            fmu.remove("documentation/licenses/license.txt");
            fmu.add("documentation/licenses/MIT", "MIT");
        })
    }),
    ("build-description-missing", || changed(Fmi3, |fmu| fmu.remove("sources/buildDescription.xml"))),
    ("platform-of-fmi2", || changed(Fmi3, |fmu| fmu.add("binaries/linux64/model.a", "static"))),
    ("platform-of-fmi3", || with_library("x86_64-linux", "model.so", linux_x86_64, 0).zip()),
    ("platform-unknown", || with("binaries/amiga/model.library")),
    ("binary-missing", || with_library("linux64", "wrong.so", linux_x86_64, 0).zip()),
    ("binary-missing", || with_library("linux64", "model.dll", linux_x86_64, 0).zip()),
    ("binary-format", || with("binaries/linux64/model.so")),
    ("binary-architecture", || with_library("linux64", "model.so", linux_aarch64, 0).zip()),
    ("binary-architecture", || with_library("win64", "model.dll", linux_x86_64, 0).zip()),
    ("symbol-missing", || with_library("linux64", "model.so", linux_x86_64, 1).zip()),
    ("symbol-missing", || with_library("darwin64", "model.dylib", darwin_x86_64, 1).zip()),
];
