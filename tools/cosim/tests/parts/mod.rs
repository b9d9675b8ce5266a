//! Systems of tiny FMUs (`data/parts.c`): a rotor, a spring with a mass behind it, a gain.

use crate::common::{binary_name, compile, data};
use cosim::{Error, FmiVersion, System, SystemOptions, SystemRun, cosimulate};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const UNITS: &str = r#"<UnitDefinitions>
    <Unit name="rad/s"><BaseUnit s="-1" rad="1"/></Unit>
    <Unit name="rpm"><BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></Unit>
    <Unit name="N.m"><BaseUnit kg="1" m="2" s="-2"/></Unit>
    <Unit name="mN.m"><BaseUnit kg="1" m="2" s="-2" factor="0.001"/></Unit>
    <Unit name="K"><BaseUnit K="1"/></Unit>
    <Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
  </UnitDefinitions>"#;

fn real(name: &str, vr: u32, role: &str, unit: &str, start: &str) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" unit=\"{unit}\"") };
    let start = if start.is_empty() { String::new() } else { format!(" start=\"{start}\"") };
    format!(
        "<ScalarVariable name=\"{name}\" valueReference=\"{vr}\" {role}><Real{unit}{start}/></ScalarVariable>\n"
    )
}

/// The model description of a part.
pub fn xml(part: &str) -> String {
    let input = "causality=\"input\" variability=\"continuous\"";
    let output = "causality=\"output\" variability=\"continuous\"";
    let parameter = "causality=\"parameter\" variability=\"tunable\"";
    let variables = match part {
        "rotor" => [
            real("torque", 1, input, "N.m", "0"),
            real("speed", 2, output, "rad/s", ""),
            real("J", 3, parameter, "", "1"),
            real("w", 5, &parameter.replace("tunable", "fixed"), "rad/s", "0"),
            real("longest", 6, parameter, "", "1e9"),
            real("until", 10, parameter, "", "1e99"),
        ]
        .concat(),
        "spring" => [
            real("speed", 1, input, "rad/s", "0"),
            real("torque", 2, output, "N.m", ""),
            real("J", 3, parameter, "", "1"),
            real("k", 4, parameter, "", "1"),
            real("far_speed", 5, output, "rad/s", ""),
        ]
        .concat(),
        _ => {
            let discrete = "variability=\"discrete\"";
            [
                real("u", 1, input, "", "0"),
                real("y", 2, output, "", ""),
                real("g", 7, parameter, "", "1"),
                format!("<ScalarVariable name=\"n\" valueReference=\"8\" causality=\"input\" {discrete}><Integer start=\"0\"/></ScalarVariable>\n"),
                format!("<ScalarVariable name=\"twice\" valueReference=\"9\" causality=\"output\" {discrete}><Integer/></ScalarVariable>\n"),
                format!("<ScalarVariable name=\"some\" valueReference=\"9\" causality=\"output\" {discrete}><Boolean/></ScalarVariable>\n"),
            ]
            .concat()
        }
    };
    let outputs = match part {
        "rotor" => "<Unknown index=\"2\" dependencies=\"\"/>",
        "spring" => "<Unknown index=\"2\" dependencies=\"\"/><Unknown index=\"5\" dependencies=\"\"/>",
        _ => {
            "<Unknown index=\"2\" dependencies=\"1 3\"/><Unknown index=\"5\" dependencies=\"4\"/><Unknown index=\"6\" dependencies=\"4\"/>"
        }
    };
    format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{part}\" guid=\"{part}\">\n\
         <CoSimulation modelIdentifier=\"lag\" canHandleVariableCommunicationStepSize=\"true\" \
         canInterpolateInputs=\"true\" canGetAndSetFMUstate=\"true\"/>\n{UNITS}\n<ModelVariables>\n{variables}\
         </ModelVariables>\n<ModelStructure><Outputs>{outputs}</Outputs></ModelStructure>\n</fmiModelDescription>\n"
    )
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

/// A folder with the three FMUs and files of the test.
pub struct Folder {
    pub dir: tempfile::TempDir,
}

impl Folder {
    pub fn new() -> Self {
        let folder = Self { dir: tempfile::tempdir().unwrap() };
        for part in ["rotor", "spring", "gain"] {
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
        let fmus = ["rotor", "spring", "gain"].map(|part| {
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
pub const PAIR: &str = r#"
[system]
name = "pair"
connect = [
  "rotor.speed -> spring.speed",
  "spring.torque -> rotor.torque",
]
[experiment]
stop = 6
step = 0.01
[[component]]
name = "rotor"
fmu = "rotor.fmu"
[component.set]
J = 2.0
w = 1.0
[[component]]
name = "spring"
fmu = "spring.fmu"
[component.set]
J = 0.5
k = 3.0
"#;

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
