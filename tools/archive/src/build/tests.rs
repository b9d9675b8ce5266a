use super::*;
use describe::models;
use std::io::Read;

/// A folder with a library.
struct Packing {
    folder: tempfile::TempDir,
    library: PathBuf,
}

impl Packing {
    fn new() -> Packing {
        let folder = tempfile::tempdir().unwrap();
        let library = folder.path().join("library");
        fs::write(&library, [b"code ", &start_values::empty()[..]].concat()).unwrap();
        Packing { folder, library }
    }

    /// The motor in an archive below the folder.
    fn build(&self, standard: Standard, contents: Contents<'_>) -> Result<PathBuf, BuildError> {
        build(&models::ALL[0], standard, contents, &self.library, self.folder.path())
    }
}

/// Text or bytes of an entry.
fn entry(archive: &Path, name: &str) -> Vec<u8> {
    let mut zip = zip::ZipArchive::new(fs::File::open(archive).unwrap()).unwrap();
    let mut bytes = Vec::new();
    zip.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    for standard in Standard::ALL {
        let make = || fs::read(Packing::new().build(standard, Contents::default()).unwrap()).unwrap();
        assert_eq!(make(), make());
    }
}

#[test]
fn a_preset_reaches_the_xml_and_the_binary() {
    let (packing, preset) = (Packing::new(), Preset::load("maxon-305015").unwrap());
    let contents = Contents { preset: Some(&preset), ..Contents::default() };
    let path = packing.build(Standard::Fmi2, contents).unwrap();
    let xml = String::from_utf8(entry(&path, "modelDescription.xml")).unwrap();
    assert!(xml.contains("start=\"0.00983\""), "tau_c of the preset is the start value");
    let binary = entry(&path, &format!("binaries/{}/AnnulusCooledMotor.{}", HERE.fmi2, HERE.ending));
    let block: [u8; start_values::SIZE] = binary[5..].try_into().unwrap();
    assert!(start_values::entries(&block).any(|entry| entry == (1000, 9.83e-3)));
}

/// The token in the model description of an archive.
fn token(archive: &Path) -> String {
    let xml = String::from_utf8(entry(archive, "modelDescription.xml")).unwrap();
    let document = roxmltree::Document::parse(&xml).unwrap();
    let root = document.root_element();
    root.attribute("guid").or(root.attribute("instantiationToken")).unwrap().to_owned()
}

#[test]
fn presets_and_terms_have_tokens_of_their_own() {
    let packing = Packing::new();
    let [one, other] = ["maxon-305015", "maxon-re40-148877"].map(|name| Preset::load(name).unwrap());
    let text =
        r#"{"format": "motor-fmu effects 1", "terms": [{"port": "drag_torque", "coefficient": 1e-3}]}"#;
    let terms = TermsFile::parse(text, "x.json").unwrap();
    let all = [
        Contents::default(),
        Contents { preset: Some(&one), ..Contents::default() },
        Contents { preset: Some(&other), ..Contents::default() },
        Contents { preset: Some(&one), effects: Some(&terms), ..Contents::default() },
    ];
    let mut tokens = all.map(|contents| {
        let [two, three] = Standard::ALL.map(|standard| token(&packing.build(standard, contents).unwrap()));
        assert_eq!(two, three);
        assert_eq!(two, token(&packing.build(Standard::Fmi2, contents).unwrap()));
        let kind = models::by_token(&two).expect("a model");
        assert_eq!((kind.declaration)().name, "AnnulusCooledMotor");
        two
    });
    tokens.sort_unstable();
    assert!(tokens.windows(2).all(|pair| pair[0] != pair[1]), "{tokens:?}");
}

/// The library compares the start values in its block with the token.
#[test]
fn the_token_is_that_of_the_start_values_in_the_library() {
    let (packing, preset) = (Packing::new(), Preset::load("maxon-305015").unwrap());
    let path =
        packing.build(Standard::Fmi3, Contents { preset: Some(&preset), ..Contents::default() }).unwrap();
    let binary = entry(&path, &format!("binaries/{}/AnnulusCooledMotor.{}", HERE.tuple, HERE.ending));
    let block: [u8; start_values::SIZE] = binary[5..].try_into().unwrap();
    let own = (models::ALL[0].declaration)().token;
    let found = describe::Token::parse(&token(&path)).unwrap().contents(own);
    assert_eq!(found, Resources::default().contents(start_values::entries(&block)));
    assert_ne!(found.starts, 0);
}

#[test]
fn effects_are_packed_and_checked() {
    let packing = Packing::new();
    let term = r#"{"port": "drag_torque", "coefficient": 1e-3}"#;
    let text = |terms: &str| format!(r#"{{"format": "motor-fmu effects 1", "terms": [{terms}]}}"#);
    let mut file = TermsFile::parse(&text(term), "x.json").unwrap();
    let make = |file: &TermsFile| {
        packing.build(Standard::Fmi3, Contents { effects: Some(file), ..Contents::default() })
    };
    let packed = String::from_utf8(entry(&make(&file).unwrap(), "resources/effects.json")).unwrap();
    assert_eq!(TermsFile::parse(&packed, "resources").unwrap(), file);
    file.terms[0].port = "nowhere".to_string();
    assert!(make(&file).unwrap_err().to_string().contains("nowhere"));
}

/// A term is refused with its name or port and with what the model lacks.
#[test]
fn a_model_says_why_it_does_not_take_a_term() {
    let why = |model: &str, term: &str| {
        let file =
            TermsFile::parse(&format!(r#"{{"format": "motor-fmu effects 1", "terms": [{term}]}}"#), "x.json");
        let contents = Contents { effects: Some(&file.unwrap()), ..Contents::default() };
        resources(models::by_name(model).unwrap(), contents).err().map(|error| error.to_string())
    };
    let by = |port: &str, driver: &str| {
        format!(
            r#"{{"name": "duct", "port": "{port}", "coefficient": 0.1, "drivers": [{{"driver": "{driver}", "reference": 1.0}}]}}"#
        )
    };
    for term in [by("fan_flow", "speed"), by("housing_heat", "fan_command")] {
        assert_eq!(why("AnnulusCooledMotor", &term), None);
        let sentence = "effects.json: BrushedGearmotor does not take the term \"duct\": it has no fan";
        assert_eq!(why("BrushedGearmotor", &term).unwrap(), sentence);
    }
    assert_eq!(why("BrushedGearmotor", &by("housing_heat", "speed")), None);
    let nameless = r#"{"port": "drag_torque", "coefficient": 1e-3}"#;
    let sentence = "effects.json: GaitLoad does not take the term at port drag_torque: it takes no terms";
    assert_eq!(why("GaitLoad", nameless).unwrap(), sentence);
}

#[test]
fn a_preset_for_another_model_is_refused() {
    let mut preset = Preset::load("maxon-305015").unwrap();
    preset.model = "Other".to_string();
    let contents = Contents { preset: Some(&preset), ..Contents::default() };
    let error = Packing::new().build(Standard::Fmi2, contents).unwrap_err();
    assert_eq!(error.to_string(), "preset maxon-305015 is for Other and not for AnnulusCooledMotor");
}

#[test]
fn a_missing_library_is_named() {
    let missing = Packing { library: "nothing.so".into(), ..Packing::new() };
    let error = missing.build(Standard::Fmi3, Contents::default()).unwrap_err().to_string();
    assert!(error.contains("nothing.so") && error.contains("cargo build --release"), "{error}");
}

#[test]
fn a_library_for_another_platform_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let platform = crate::platform::ALL.into_iter().find(|p| *p != HERE).unwrap();
    let library = Library { platform, path: std::env::current_exe().unwrap() };
    let error = build_all(&models::ALL[0], &Standard::ALL, Contents::default(), &[library], folder.path())
        .unwrap_err();
    let sentence = error.to_string();
    assert!(sentence.contains(HERE.tuple) && sentence.contains(platform.tuple), "{sentence}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
}

#[test]
fn every_platform_has_its_own_folder() {
    let Packing { folder, library } = Packing::new();
    let libraries = crate::platform::ALL.map(|platform| Library { platform, path: library.clone() });
    for standard in Standard::ALL {
        let out =
            build_all(&models::ALL[0], &[standard], Contents::default(), &libraries, folder.path()).unwrap();
        let zip = zip::ZipArchive::new(fs::File::open(&out[0]).unwrap()).unwrap();
        let names = zip.file_names().map(|name| name.unwrap().into_owned());
        let mut found: Vec<String> = names.filter(|n| n.starts_with("binaries/")).collect();
        found.sort_unstable();
        let name = |p: &Platform| if standard == Standard::Fmi2 { p.fmi2 } else { p.tuple };
        let mut wanted: Vec<String> = crate::platform::ALL
            .iter()
            .map(|p| format!("binaries/{}/AnnulusCooledMotor.{}", name(p), p.ending))
            .collect();
        wanted.sort_unstable();
        assert_eq!(found, wanted);
    }
}
