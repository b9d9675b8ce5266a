//! SSP as others write it: values inline and in files, with prefixes and units, connectors of the system, conversions.
use crate::parts::*;
use cosim::{SspForm, SystemOptions, SystemRun, cosimulate};

/// Two components, everything that is read; `%` stands for what a test puts there.
pub const SSD: &str = include_str!("data/units.ssd");

/// The start speed is in a file, in revolutions per minute.
pub const SSV: &str = include_str!("data/units.ssv");

fn run(ssd: &str, sets: &[(&str, &str)]) -> SystemRun {
    let system = Folder::new().ssp(ssd, &[("resources/all.ssv", SSV)]).unwrap();
    let options = SystemOptions { sets: crate::common::sets(sets), ..SystemOptions::default() };
    cosimulate(&system, &options, &mut |_| ()).unwrap()
}

/// A file of a package.
fn text_of(package: &std::path::Path, name: &str) -> String {
    let mut text = String::new();
    let mut archive = zip::ZipArchive::new(std::fs::File::open(package).unwrap()).unwrap();
    std::io::Read::read_to_string(&mut archive.by_name(name).unwrap(), &mut text).unwrap();
    text
}

fn last(run: &SystemRun, name: &str) -> f64 {
    *run.recording.column(name).unwrap().values.last().unwrap()
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{a} is not {b}");
}

const RPM: f64 = std::f64::consts::TAU / 60.0;

#[test]
fn values_units_and_directions_arrive() {
    let r = run(SSD, &[]);
    assert_eq!((r.recording.times[0], r.recording.times[1], r.recording.steps), (1.0, 1.125, 8));
    // 60 rpm, then 1 s of 2 N.m at 0.5 kg.m2; the connection is written from the input to the output.
    let speed = 60.0 * RPM + 4.0;
    close(last(&r, "rotor.speed"), speed);
    close(last(&r, "turns"), speed / RPM);
    assert_eq!(r.recording.column("turns").unwrap().unit.as_deref(), Some("rpm"));
    // The gain has no unit: it gets what the connector shows, revolutions per minute.
    close(last(&r, "gain.y"), 2.0 * speed / RPM);
    assert_eq!((last(&r, "gain.twice"), last(&r, "gain.some")), (8.0, 1.0));
    assert_eq!(r.notes, [] as [&str; 0]);
}

/// A unit in the text of a setting is that of its number, also where the connector has another one.
#[test]
fn settings_may_have_units_of_their_own() {
    let expected = last(&run(SSD, &[]), "rotor.speed");
    for push in ["-2000", "-2 N.m", "-0,002 kN.m", "-200 N.cm"] {
        close(last(&run(SSD, &[("push", push)]), "rotor.speed"), expected);
    }
    close(last(&run(SSD, &[("rotor.w", "120 rpm")]), "rotor.speed"), expected + 60.0 * RPM);
}

#[test]
fn connections_transform_and_may_suppress_the_units() {
    let text = "endElement=\"rotor\" endConnector=\"speed\"/>";
    let with = |attributes: &str, body: &str| {
        let new = format!("endElement=\"rotor\" endConnector=\"speed\" {attributes}>{body}</ssd:Connection>");
        SSD.replace(text, &new)
    };
    let speed = 60.0 * RPM + 4.0;
    let linear = "<ssc:LinearTransformation factor=\"3\" offset=\"1\"/>";
    close(last(&run(&with("", linear), &[]), "gain.y"), 2.0 * (3.0 * speed / RPM + 1.0));
    // Both connectors in units of their own: converted, then transformed, or transformed alone.
    let unit = |ssd: String| {
        ssd.replace("\"u\" kind=\"input\"><ssc:Real/>", "\"u\" kind=\"input\"><ssc:Real unit=\"rpm\"/>")
    };
    close(last(&run(&unit(with("", linear)), &[]), "gain.y"), 2.0 * (3.0 * speed / RPM + 1.0));
    let folder = Folder::new();
    let described = xml("gain").replace(
        "name=\"u\" valueReference=\"1\" causality=\"input\" variability=\"continuous\"><Real",
        "name=\"u\" valueReference=\"1\" causality=\"input\" variability=\"continuous\"><Real unit=\"rad/s\"",
    );
    assert_ne!(described, xml("gain"));
    folder.fmu("gain", &described);
    let suppressed = "suppressUnitConversion=\"true\"";
    for (attributes, body, expected) in [
        ("", "", 2.0 * speed),
        (suppressed, "", 2.0 * speed / RPM),
        // Units first.
        ("", linear, 2.0 * (3.0 * speed + 1.0)),
        (suppressed, linear, 2.0 * (3.0 * speed / RPM + 1.0)),
    ] {
        let ssd = with(attributes, body);
        let system = folder.ssp(&ssd, &[("resources/all.ssv", SSV)]).unwrap();
        let r = cosimulate(&system, &SystemOptions::default(), &mut |_| ()).unwrap();
        close(last(&r, "gain.y"), expected);
    }
}

#[test]
fn an_archive_that_is_written_again_means_the_same() {
    let linear = "endElement=\"rotor\" endConnector=\"speed\"><ssc:LinearTransformation factor=\"3\" offset=\"1\"/></ssd:Connection>";
    let ssd = SSD.replace("endElement=\"rotor\" endConnector=\"speed\"/>", linear);
    let folder = Folder::new();
    // Another FMU defines the unit differently, so its definition gets another name.
    let described = xml("gain").replace("factor=\"0.10471975511965977\"", "factor=\"0.1\"");
    let output = "name=\"y\" valueReference=\"2\" causality=\"output\" variability=\"continuous\"><Real";
    assert!(described.contains(output));
    folder.fmu("gain", &described.replace(output, &format!("{output} unit=\"rpm\"")));
    let first = folder.ssp(&ssd, &[("resources/all.ssv", SSV)]).unwrap();
    let path = folder.path("again.ssp");
    first.write_ssp(&path, SspForm::default()).unwrap();
    let mut text = String::new();
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&path).unwrap()).unwrap();
    std::io::Read::read_to_string(&mut archive.by_name("SystemStructure.ssd").unwrap(), &mut text).unwrap();
    assert!(
        text.contains("<ssc:Unit name=\"rpm\">") && text.contains("<ssc:Unit name=\"rpm (2)\">"),
        "{text}"
    );
    let again = cosim::System::open(&path).unwrap();
    let run = |system| cosimulate(system, &SystemOptions::default(), &mut |_| ()).unwrap();
    let (a, b) = (run(&first), run(&again));
    assert_eq!(a.recording.times, b.recording.times);
    let columns = |r: &SystemRun| {
        r.recording.columns.iter().map(|c| (c.name.clone(), c.unit.clone())).collect::<Vec<_>>()
    };
    assert_eq!(columns(&a), columns(&b));
    for (x, y) in a.recording.columns.iter().zip(&b.recording.columns) {
        assert_eq!(x.values, y.values, "{}", x.name);
    }
    close(last(&b, "gain.y"), 2.0 * (3.0 * (60.0 + 4.0 / RPM) + 1.0));
}

#[test]
fn settings_on_the_command_line_win() {
    let r = run(SSD, &[("rotor.w", "1"), ("push", "0"), ("gain.g", "1")]);
    close(last(&r, "rotor.speed"), 1.0);
    close(last(&r, "gain.y"), 1.0 / RPM);
}

#[test]
fn unconnected_inputs_are_reported() {
    let without = SSD.replace("<ssv:Parameter name=\"n\"><ssv:Integer value=\"4\"/></ssv:Parameter>", "");
    assert_eq!(run(&without, &[]).notes, ["gain: n stays at its start value"]);
}

#[test]
fn one_archive_for_several_components_is_unpacked_once() {
    let folder = Folder::new();
    let before = std::fs::read_dir(std::env::temp_dir()).unwrap().count();
    let text = "[system]\nname = \"many\"\n".to_owned()
        + &(0..40)
            .map(|i| format!("[[component]]\nname = \"g{i}\"\nfmu = \"gain.fmu\"\n"))
            .collect::<String>();
    let system = folder.toml(&text).unwrap();
    let after = std::fs::read_dir(std::env::temp_dir()).unwrap().count();
    assert!(after < before + 20, "{before} {after}");
    let r = cosimulate(&system, &SystemOptions::default(), &mut |_| ()).unwrap();
    assert_eq!(r.recording.columns.len(), 120);
    let out = folder.path("many.ssp");
    system.write_ssp(&out, SspForm::default()).unwrap();
    let archive = zip::ZipArchive::new(std::fs::File::open(&out).unwrap()).unwrap();
    let names: Vec<String> = archive.file_names().map(|n| n.unwrap().into_owned()).collect();
    assert_eq!(names, ["SystemStructure.ssd", "resources/gain.fmu"]);
}

/// SSP 2.0: a system in a system in a system, a signal dictionary, a parameter mapping.
const NESTED: &str = include_str!("data/nested.ssd");
const SSM: &str = r#"<ssm:ParameterMapping version="1.0"
    xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
  <ssm:MappingEntry source="of.start" target="drive.inner.rotor.w"><ssc:LinearTransformation factor="0.5" offset="1"/></ssm:MappingEntry>
  <ssm:MappingEntry source="of.switch" target="a.g">
    <ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="3"/></ssc:BooleanMappingTransformation>
  </ssm:MappingEntry>
</ssm:ParameterMapping>"#;
const SSB: &str = r#"<ssb:SignalDictionary version="1.0" name="bus"
    xmlns:ssb="http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
  <ssb:DictionaryEntry name="speed"><ssc:Real unit="rpm"/></ssb:DictionaryEntry>
  <ssb:Units><ssc:Unit name="rpm"><ssc:BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></ssc:Unit></ssb:Units>
</ssb:SignalDictionary>"#;

#[test]
fn nested_systems_dictionaries_and_mappings_are_flattened() {
    let folder = Folder::new();
    let further = [("resources/all.ssm", SSM), ("resources/bus.ssb", SSB)];
    let system = folder.ssp(NESTED, &further).unwrap();
    assert_eq!(system.components().collect::<Vec<_>>(), ["drive.inner.rotor", "a", "b"]);
    // Start: 60 rpm in rad/s, then half of it and 1 more; 1 s of 2 N.m at 1 kg.m2.
    let speed = 0.5 * 60.0 * RPM + 1.0 + 2.0;
    let check = |system: &cosim::System| {
        let r = cosimulate(system, &SystemOptions::default(), &mut |_| ()).unwrap();
        close(last(&r, "drive.inner.rotor.speed"), speed);
        close(last(&r, "a.y"), 3.0 * (2.0 * speed / RPM + 1.0));
        close(last(&r, "b.y"), speed / RPM);
        close(last(&r, "result"), -speed / RPM);
    };
    check(&system);
    // Written again it is flat, means the same, and still has the parameter with its unit in a file, mapped to the variable. The value that a
    // table of the mapping replaced stands at the component.
    let path = folder.path("flat.ssp");
    system.write_ssp(&path, SspForm { dictionary: true, ..SspForm::default() }).unwrap();
    check(&cosim::System::open(&path).unwrap());
    // One entry for the speed that two components use, in the unit of its source.
    let signals = text_of(&path, "resources/signals.ssb");
    assert_eq!(signals.matches("<ssb:DictionaryEntry").count(), 1, "{signals}");
    assert!(
        signals.contains("name=\"drive.inner.rotor.speed\"") && signals.contains("unit=\"rad/s\""),
        "{signals}"
    );
    system.write_ssp(&path, SspForm::default()).unwrap();
    check(&cosim::System::open(&path).unwrap());
    let values = text_of(&path, "resources/parameters.ssv");
    assert!(
        values.contains("name=\"of.start\"") && values.contains("<ssv:Real value=\"60\" unit=\"rpm\"/>"),
        "{values}"
    );
    assert!(values.contains("<ssc:Unit name=\"rpm\">") && !values.contains("switch"), "{values}");
    let mapping = text_of(&path, "resources/parameters.ssm");
    assert!(mapping.contains("source=\"of.start\" target=\"drive.inner.rotor.w\""), "{mapping}");
    assert!(mapping.contains("factor=\"0.5\" offset=\"1\""), "{mapping}");
    // Two sources for one entry.
    let twice = "<ssd:Connection startElement=\"b\" startConnector=\"y\" endElement=\"line\" endConnector=\"speed\"/>";
    let ssd = NESTED.replace(
        "      <ssd:Connection startElement=\"b\"",
        &format!("      {twice}\n      <ssd:Connection startElement=\"b\""),
    );
    let sentence = folder.ssp(&ssd, &further).unwrap_err().to_string();
    assert!(
        sentence.contains("bus.speed has a source already: drive.inner.rotor.speed, line "),
        "{sentence}"
    );
}

/// A parameter of the system sets variables of two components; a change in the file of values reaches both.
#[test]
fn a_parameter_of_the_system_is_one_value_for_several_variables() {
    let folder = Folder::new();
    let text = r#"
[system]
name = "shared"
connect = ["rotor.speed -> gain.u"]
[[component]]
name = "rotor"
fmu = "rotor.fmu"
[[component]]
name = "gain"
fmu = "gain.fmu"
[[parameter]]
name = "level"
value = 3
set = ["rotor.w", "gain.g"]
"#;
    let system = folder.toml(text).unwrap();
    let at_start = |system: &cosim::System| {
        let options = SystemOptions { stop: Some(0.01), ..SystemOptions::default() };
        let r = cosimulate(system, &options, &mut |_| ()).unwrap();
        ["rotor.speed", "gain.y"].map(|name| r.recording.column(name).unwrap().values[0])
    };
    let [speed, y] = at_start(&system);
    assert_eq!((speed, y), (3.0, 9.0));
    let path = folder.path("level.ssp");
    system.write_ssp(&path, SspForm::default()).unwrap();
    assert_eq!(at_start(&cosim::System::open(&path).unwrap()), [3.0, 9.0]);
    let values = text_of(&path, "resources/parameters.ssv").replace("value=\"3\"", "value=\"2\"");
    let (ssd, mapping) = (text_of(&path, "SystemStructure.ssd"), text_of(&path, "resources/parameters.ssm"));
    let changed =
        [("resources/parameters.ssv", values.as_str()), ("resources/parameters.ssm", mapping.as_str())];
    assert_eq!(at_start(&folder.ssp(&ssd, &changed).unwrap()), [2.0, 4.0]);
    let empty = text.replace("set = [\"rotor.w\", \"gain.g\"]", "set = []");
    let sentence = folder.toml(&empty).unwrap_err().to_string();
    assert!(sentence.contains("parameter level: the list `set` names no component.variable"), "{sentence}");
}

#[test]
fn an_archive_has_what_other_tools_need() {
    let folder = Folder::new();
    let text = PAIR.replace("fmu = \"rotor.fmu\"", "fmu = \"rotor.fmu\"\nstep = 0.005");
    let path = folder.path("pair.ssp");
    folder.toml(&text).unwrap().write_ssp(&path, SspForm::default()).unwrap();
    let mut ssd = String::new();
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&path).unwrap()).unwrap();
    std::io::Read::read_to_string(&mut archive.by_name("SystemStructure.ssd").unwrap(), &mut ssd).unwrap();
    // A start time, although the description has none, and parameter sets of one name.
    assert!(ssd.contains("startTime=\"0\" stopTime=\"6\""), "{ssd}");
    assert_eq!(ssd.matches("<ssv:ParameterSet version=\"1.0\" name=\"initialValues\">").count(), 2);
    // The step of the component is read again.
    let again = cosim::System::open(&path).unwrap();
    let options = |longest: &str| SystemOptions {
        sets: crate::common::sets(&[("rotor.longest", longest)]),
        ..SystemOptions::default()
    };
    assert!(cosimulate(&again, &options("0.00501"), &mut |_| ()).is_ok());
    assert!(cosimulate(&again, &options("0.00499"), &mut |_| ()).is_err());
}
