//! Files that belong together in the archive: documentation, icons, licences.

use std::collections::HashSet;

use super::finding::Findings;
use super::model::{FmiVersion, Model, is_true};
use super::rules;

/// Checks the names of the entries.
pub(crate) fn check(model: &Model, entries: &HashSet<String>, out: &mut Findings) {
    let any_of = |names: &[&str]| names.iter().any(|n| entries.contains(*n));
    let in_folder = |folder: &str| entries.iter().any(|e| e.len() > folder.len() && e.starts_with(folder));
    let code = ["binaries/", "sources/"]
        .iter()
        .any(|folder| entries.iter().any(|e| e.starts_with(folder) && !e.ends_with('/')));
    if !code {
        out.add("archive", rules::no_implementation());
    }
    for (svg, png) in [
        ("terminalsAndIcons/icon.svg", "terminalsAndIcons/icon.png"),
        ("documentation/diagram.svg", "documentation/diagram.png"),
    ] {
        if entries.contains(svg) && !entries.contains(png) {
            out.add(svg, rules::svg_without_png(svg, png));
        }
    }
    // Releases of FMI 2.0 differ in where the folder is.
    let beside = model.version == FmiVersion::V2 && in_folder("licenses/");
    let licenses = "documentation/licenses/";
    let entry = ["spdx", "txt", "html"].map(|end| format!("{licenses}license.{end}"));
    for (is_there, rule, place, message) in [
        (
            any_of(&["documentation/index.html"]),
            &rules::DOCUMENTATION_MISSING,
            "documentation/",
            "The archive has no documentation/index.html, which tools present as the documentation of the model",
        ),
        (
            in_folder(licenses) || beside,
            &rules::LICENSE_MISSING,
            "documentation/",
            "The archive has no folder documentation/licenses, so the terms of its use are unknown",
        ),
        (
            model.version == FmiVersion::V2
                || !in_folder(licenses)
                || entry.iter().any(|e| entries.contains(e)),
            &rules::LICENSE_ENTRY,
            licenses,
            "The licence folder has no entry point license.spdx, license.txt or license.html",
        ),
    ] {
        if !is_there {
            out.add(place, rule.says(message));
        }
    }
    if model.version == FmiVersion::V2 {
        return;
    }
    let documented =
        any_of(&["documentation/externalDependencies.txt", "documentation/externalDependencies.html"]);
    if let Some(interface) =
        model.interfaces.iter().find(|i| is_true(**i, "needsExecutionTool")).filter(|_| !documented)
    {
        out.add(model.place(*interface), rules::tool_undocumented());
    }
}
