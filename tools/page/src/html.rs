//! The page: controls, places for the answers, the script and the compiled models, in one file.

use crate::choice::MODEL;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use describe::{Declaration, Kind, Preset, StartValues, models};
use maud::{Markup, PreEscaped, html};
use study::StudyError;

const SCRIPT: &str = include_str!("page.js");
const WORKER: &str = include_str!("worker.js");
const STYLE: &str = include_str!("controls.css");

/// A number that the reader chooses: key of the state, label, unit (empty where it has none), start, least, most, step.
type Number = (&'static str, &'static str, &'static str, f64, f64, f64, f64);

/// The motor that is selected first: that of the declared defaults.
const FIRST: &str = "maxon-305015";
/// Numbers about motor and ambient.
const AMBIENT: [Number; 3] = [
    ("fan", "Fan speed", "fraction of full speed", 0.0, 0.0, 1.0, 0.05),
    ("ambient", "Ambient temperature", "°C", 25.0, -40.0, 100.0, 1.0),
    ("voltage", "Supply voltage", "V", 24.0, 0.5, 600.0, 0.5),
];
/// Numbers of a constant load.
const CONSTANT: [Number; 3] = [
    ("torque", "Torque", "N·m", 0.1, 0.0, 1000.0, 0.0001),
    ("current", "Current", "A", 5.0, 0.0, 1000.0, 0.001),
    ("speed", "Speed", "1/min", 0.0, 0.0, 100_000.0, 1.0),
];
/// Numbers of a walking person and the actuator.
const GAIT: [Number; 4] = [
    ("body_mass", "Body mass", "kg", 75.0, 20.0, 200.0, 1.0),
    ("support", "Fraction of the biological torque", "", 0.5, 0.0, 2.0, 0.05),
    ("ratio", "Gear ratio", "", 250.0, 1.0, 1000.0, 1.0),
    ("stiffness", "Stiffness of the series spring", "N·m/rad", 250.0, 1.0, 10_000.0, 1.0),
];
const DURATION: Number = ("minutes", "Duration", "min", 30.0, 0.5, 600.0, 0.5);

/// Loads: value of the state, label.
const LOADS: [(&str, &str); 3] =
    [("torque", "Constant torque"), ("current", "Constant current"), ("gait", "Walking person")];

/// Places for answers: question, heading.
const PLACES: [(&str, &str); 3] =
    [("heating", "Winding temperature"), ("range", "Operating range"), ("efficiency", "Efficiency map")];

fn number((key, label, unit, start, least, most, step): Number) -> Markup {
    // Well-formed XML as all of the page, so that its rules can be checked.
    let input = format!(
        r#"<input id="{key}" type="number" inputmode="decimal" value="{start}" min="{least}" max="{most}" step="{step}"/>"#
    );
    html! {
        label for=(key) { (label) @if !unit.is_empty() { ", " (unit) } }
        (PreEscaped(input))
    }
}

fn choice(key: &str, label: &str, items: &[(String, String)]) -> Markup {
    html! {
        label for=(key) { (label) }
        select id=(key) { @for (value, text) in items { option value=(value) { (text) } } }
    }
}

/// The items of an enumeration with their descriptions, the declared start value first: it is selected at the start.
fn items(declaration: &Declaration, name: &str) -> Vec<(String, String)> {
    let Some(entry) = declaration.by_name(name) else { return Vec::new() };
    let Kind::Enumeration(t) = entry.row.kind else { return Vec::new() };
    let start = StartValues::default().of(entry);
    let mut items: Vec<_> = t.items.iter().collect();
    items.sort_by_key(|item| f64::from(item.value) != start);
    // Items are distinguished by all of their description.
    let words = |text: &str| text.trim().trim_end_matches('.').to_owned();
    items.into_iter().map(|item| (item.name.to_owned(), words(item.doc))).collect()
}

fn declaration(model: &str) -> Result<&'static Declaration, StudyError> {
    let kind = models::by_name(model).ok_or_else(|| StudyError::new(format!("unknown model {model}")))?;
    Ok((kind.declaration)())
}

/// The page with the compiled models.
///
/// # Errors
/// A built-in preset that cannot be read.
pub fn page(wasm: &[u8]) -> Result<String, StudyError> {
    let mut motors: Vec<(String, String)> = Preset::built_in()?
        .into_iter()
        .filter(|preset| preset.model == MODEL)
        .map(|preset| (preset.name, preset.description))
        .collect();
    motors.sort_by_key(|(name, _)| name != FIRST);
    let mut cooling = vec![(String::new(), "as in the preset of the motor".to_owned())];
    cooling.extend(items(declaration(MODEL)?, "cooling_mode"));
    let gait = declaration("GaitLoad")?;
    // A load table is data of an FMU, which the page does not have.
    let mut activities = items(gait, "gait.activity");
    activities.retain(|(name, _)| name != "table");
    let loads = LOADS.map(|(value, text)| (value.to_owned(), text.to_owned()));
    let body = html! {
        style { (PreEscaped(STYLE.replace('\n', ""))) }
        p.lead { "Torque, temperature and operating range of an electric motor. The models of motor-fmu run in this page; it needs no network." }
        form.controls aria-label="Motor, cooling and load" {
            fieldset { legend { "Motor and cooling" }
                (choice("motor", "Motor", &motors))
                (choice("cooling", "Cooling", &cooling))
                @for row in AMBIENT { (number(row)) }
            }
            fieldset { legend { "Load" }
                (choice("load", "Kind of load", &loads))
                div data-load="torque" { (number(CONSTANT[0])) }
                div data-load="current" { (number(CONSTANT[1])) }
                div data-load="torque current" { (number(CONSTANT[2])) }
                div data-load="gait" {
                    (choice("activity", "Activity", &activities))
                    (choice("joint", "Joint", &items(gait, "gait.joint")))
                    @for row in GAIT { (number(row)) }
                }
                (number(DURATION))
            }
        }
        p #status role="status" aria-live="polite" { "Loading the models" }
        div.answers { @for (question, heading) in PLACES {
            section id=(question) aria-labelledby={ (question) "-heading" } {
                h2 id={ (question) "-heading" } { (heading) }
                p.text aria-live="polite" {}
                div.figure {}
                details { summary { "Values" } div.wide tabindex="0" { pre.values {} } }
            }
        } }
        noscript { p { "This page computes with WebAssembly and needs JavaScript." } }
        script #worker type="text/plain" { (PreEscaped(cdata(WORKER))) }
        script #models type="text/plain" { (STANDARD.encode(wasm)) }
        script { (PreEscaped(cdata(SCRIPT))) }
    };
    Ok(present::page::page("Electric motors: torque, temperature, operating range", body))
}

/// A script that is also well-formed XML.
fn cdata(script: &str) -> String {
    format!("//<![CDATA[\n{script}//]]>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_follows_the_rules_and_has_every_motor_and_mode() {
        let page = page(b"\0asm").unwrap();
        assert_eq!(present::check::faults(&page), Vec::<String>::new());
        for preset in Preset::built_in().unwrap() {
            let option = format!("<option value=\"{}\">", preset.name);
            assert_eq!(page.contains(&option), preset.model == MODEL, "{}", preset.name);
        }
        for (name, _) in items(declaration(MODEL).unwrap(), "cooling_mode") {
            assert!(page.contains(&format!("<option value=\"{name}\">")), "{name}");
        }
        // The options of a list are different, and no description is cut.
        for list in page.split("<select ").skip(1).filter_map(|list| list.split("</select>").next()) {
            let options: Vec<&str> =
                list.split("<option ").skip(1).filter_map(|o| o.split_once('>')).map(|o| o.1).collect();
            assert!((1..options.len()).all(|k| !options[..k].contains(&options[k])), "{options:?}");
        }
        for text in
            [">Level walking of adults, 1.14 s per stride (Grimmer and Seyfarth 2014)<", ">Gear ratio<"]
        {
            assert!(page.contains(text), "{text}");
        }
        // A browser selects the first option.
        for (control, first) in [("motor", FIRST), ("activity", "walk"), ("joint", "ankle")] {
            assert!(
                page.contains(&format!("<select id=\"{control}\"><option value=\"{first}\">")),
                "{control}"
            );
        }
        // Every control has a label, and every label a control.
        for part in page.split("<label for=\"").skip(1) {
            let id = part.split('"').next().unwrap();
            assert!(page.contains(&format!("id=\"{id}\"")), "{id}");
        }
    }
}
