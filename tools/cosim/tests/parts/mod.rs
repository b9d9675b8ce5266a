//! Systems of tiny FMUs (`data/parts.c`): a rotor, a spring with a mass behind it, a gain, a mixer.

use crate::common::{binary_name, compile, data};
use cosim::{Error, FmiVersion, System, SystemOptions, SystemRun, cosimulate};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The model description of a part.
pub fn xml(part: &str) -> String {
    fs::read_to_string(data(&format!("{part}.xml"))).unwrap()
}

fn binary() -> &'static [u8] {
    static BUILT: OnceLock<Vec<u8>> = OnceLock::new();
    BUILT.get_or_init(|| compile(&data("parts.c")))
}

/// A zip archive of these entries.
pub fn zip(path: &Path, entries: &[(&str, &[u8])]) {
    let mut zip = zip::ZipWriter::new(fs::File::create(path).unwrap());
    for (name, bytes) in entries {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
}

/// A folder with the FMUs and files of the test.
pub struct Folder {
    pub dir: tempfile::TempDir,
}

impl Folder {
    pub fn new() -> Self {
        let folder = Self { dir: tempfile::tempdir().unwrap() };
        for part in ["rotor", "spring", "gain", "mixer"] {
            folder.fmu(part, &xml(part));
        }
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// Writes `name.fmu` with this description.
    pub fn fmu(&self, name: &str, xml: &str) {
        let entries = [("modelDescription.xml", xml.as_bytes()), (binary_name(FmiVersion::V2), binary())];
        zip(&self.path(&format!("{name}.fmu")), &entries);
    }

    pub fn toml(&self, text: &str) -> Result<System, Error> {
        let path = self.path("s.toml");
        fs::write(&path, text).unwrap();
        System::open(&path)
    }

    /// An SSP of this description, the FMUs, and further files.
    pub fn ssp(&self, ssd: &str, further: &[(&str, &str)]) -> Result<System, Error> {
        let path = self.path("s.ssp");
        let fmus = ["rotor", "spring", "gain", "mixer"].map(|part| {
            (format!("resources/{part}.fmu"), fs::read(self.path(&format!("{part}.fmu"))).unwrap())
        });
        let mut entries: Vec<(&str, &[u8])> = vec![("SystemStructure.ssd", ssd.as_bytes())];
        entries.extend(fmus.iter().map(|(n, b)| (n.as_str(), b.as_slice())));
        entries.extend(further.iter().map(|(n, t)| (*n, t.as_bytes())));
        zip(&path, &entries);
        System::open(&path)
    }

    /// The sentence of what fails, without the folder's own path.
    pub fn sentence(&self, done: Result<System, Error>, options: &SystemOptions) -> String {
        let result = done.and_then(|system| cosimulate(&system, options, &mut |_| ()));
        result.map(|_| ()).unwrap_err().to_string().replace(&format!("{}/", self.dir.path().display()), "")
    }
}

/// The two-mass oscillator: the rotor starts at 1 rad/s.
pub const PAIR: &str = include_str!("../data/pair.toml");

/// Speed of the rotor, of the far mass, and the torque between them, in closed form.
pub fn exact(t: f64) -> [f64; 3] {
    let (j1, j2, k): (f64, f64, f64) = (2.0, 0.5, 3.0);
    let w = (k * (1.0 / j1 + 1.0 / j2)).sqrt();
    let middle = j1 / (j1 + j2);
    [middle + j2 / (j1 + j2) * (w * t).cos(), middle - j1 / (j1 + j2) * (w * t).cos(), k / w * (w * t).sin()]
}

/// The largest deviation from the closed form at the end.
pub fn error_at_end(run: &SystemRun) -> f64 {
    let end = *run.recording.times.last().unwrap();
    let names = ["rotor.speed", "spring.far_speed", "spring.torque"];
    let last = |name: &str| *run.recording.column(name).unwrap().values.last().unwrap();
    names.iter().zip(exact(end)).map(|(n, x)| (last(n) - x).abs()).fold(0.0, f64::max)
}
