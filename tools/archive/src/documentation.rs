//! The page inside the archive: the model's behaviour in figures, a first script, terminals, and all variables.

mod figures;

use crate::native::Native;
use crate::{reference, terminals};
use describe::markdown::{self, Section};
use describe::{DEFAULT_STEP, DEFAULT_STOP, Preset, VERSION, usage};
use maud::{Markup, html};
use present::page::{Cell, Plate, page as page_of, plates, table};

/// documentation/index.html.
pub fn page(native: &Native<'_>, preset: Option<&Preset>) -> String {
    let declaration = (native.kind.declaration)();
    let name = declaration.name;
    let [inputs, results] = reference::file_names(name);
    let terminals = terminals::of(declaration);
    let terminals = terminals.iter().map(|terminal| {
        let members: Vec<String> =
            terminal.members.iter().map(|member| format!("{} ({})", member.variable, member.kind)).collect();
        vec![Cell::Code(terminal.name.clone()), terminal.what.as_str().into(), Cell::Code(members.join(", "))]
    });
    let behaviour = figures::of(native).into_iter().map(|f| Plate::new("behaviour", f.figure, f.caption));
    let body = html! {
        p.lead { (declaration.description) "." }
        @if let Some(preset) = preset { p { "Start values: " (preset.name) " (" (preset.description) ")." } }
        @if let Some(unused) = unused_inputs(native) { p { "Inputs in the start modes: " (unused) "." } }
        h2 { "Behaviour" }
        (plates(&behaviour.collect::<Vec<_>>()))
        h2 { "First simulation" }
        p { "In Python, with fmpy:" }
        pre { (start(native)) }
        h2 { "Reference results" }
        p {
            code { (reference::FOLDER) "/" (inputs) } " holds inputs, " code { (reference::FOLDER) "/" (results) }
            " the results of the native model at communication steps of " (DEFAULT_STEP) " s. An importer that holds inputs \
             over a step reproduces them."
        }
        @if terminals.len() > 0 {
            h2 { "Terminals" }
            (table(&["terminal", "meaning", "variables"], terminals.collect()))
        }
        @for section in markdown::sections(native.kind, native.starts) { (variables(&section)) }
    };
    page_of(&format!("{name} {VERSION}"), body)
}

/// The inputs that have no effect in the modes in which the FMU starts, in a sentence.
fn unused_inputs(native: &Native<'_>) -> Option<String> {
    usage::sentence(&usage::inputs(native.kind, native.starts, native.resources), |_| String::new())
}

/// Variables of one role; those of a component or an effect together, to be opened.
fn variables(section: &Section) -> Markup {
    let mut groups: Vec<(String, Vec<Vec<Cell>>)> = Vec::new();
    for row in &section.rows {
        let [name, unit, start, limits, changes, description] = row.clone();
        let key = group(&name);
        let cells = vec![
            Cell::Code(name),
            unit.into(),
            Cell::Code(start),
            Cell::Code(limits),
            changes.into(),
            description.into(),
        ];
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, rows)) => rows.push(cells),
            None => groups.push((key, vec![cells])),
        }
    }
    html! {
        h2 { (section.title) }
        @for (key, rows) in groups {
            @if key.is_empty() { (table(&markdown::COLUMNS, rows)) } @else {
                details { summary { (key) " (" (rows.len()) ")" } (table(&markdown::COLUMNS, rows)) }
            }
        }
    }
}

/// The component that a variable belongs to, in words; none for a variable of the model itself.
fn group(name: &str) -> String {
    let parts: Vec<&str> = name.split('.').collect();
    match parts.as_slice() {
        ["effect", effect, ..] => format!("Effect: {}", effect.replace('_', " ")),
        [component, _, ..] => {
            let words = component.replace('_', " ");
            words[..1].to_uppercase() + &words[1..]
        }
        _ => String::new(),
    }
}

/// A script that runs the model with its drive and its load at their nominal values.
fn start(native: &Native<'_>) -> String {
    let declaration = (native.kind.declaration)();
    let name = declaration.name;
    let own = figures::own(native);
    let nominal = |name: &&str| native.entry(name).map(|e| (name.to_string(), e.row));
    let drive: Vec<String> = (own.drive.iter().filter_map(nominal))
        .map(|(name, row)| format!("\"{name}\": {}", row.nominal.clamp(row.min, row.max)))
        .collect();
    format!(
        "from fmpy import plot_result, simulate_fmu\n\n\
         result = simulate_fmu(\n    \"{name}.fmu\",\n    stop_time={DEFAULT_STOP},\n    step_size={DEFAULT_STEP},\n    \
         output_interval={DEFAULT_STEP},\n    start_values={{{}}},\n    \
         output=[{}],\n)\nplot_result(result)\n",
        drive.join(", "),
        own.shown.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::{StartValues, models};

    #[test]
    fn the_page_of_every_model_follows_the_rules_of_pages() {
        for kind in models::ALL.iter() {
            let page = page(
                &Native { kind, starts: &StartValues::default(), resources: &describe::Resources::default() },
                None,
            );
            assert_eq!(present::check::faults(&page), Vec::<String>::new(), "{kind:?}");
        }
    }

    /// The page names the inputs that the start modes ignore.
    #[test]
    fn unused_inputs_are_named() {
        let kind = models::by_name("AnnulusCooledMotor").unwrap();
        let page = page(
            &Native { kind, starts: &StartValues::default(), resources: &describe::Resources::default() },
            None,
        );
        assert!(page.contains("imposed_speed has no effect with mechanical_mode = free_shaft"), "{page}");
        assert!(!page.contains("voltage has no effect"));
    }

    #[test]
    fn variables_are_grouped_by_component_and_effect() {
        for (name, words) in
            [("effect.iron_loss.k", "Effect: iron loss"), ("motor.R_ref", "Motor"), ("drive_mode", "")]
        {
            assert_eq!(group(name), words);
        }
    }
}
