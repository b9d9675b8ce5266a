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
        out.add(
            &rules::NO_IMPLEMENTATION,
            "archive",
            "The archive has neither binaries nor sources, so the FMU cannot run",
        );
    }
    for (svg, png) in [
        ("terminalsAndIcons/icon.svg", "terminalsAndIcons/icon.png"),
        ("documentation/diagram.svg", "documentation/diagram.png"),
    ] {
        if entries.contains(svg) && !entries.contains(png) {
            out.add(
                &rules::SVG_WITHOUT_PNG,
                svg,
                format!("The archive has {svg} but not {png}, which it then requires"),
            );
        }
    }
    if !any_of(&["documentation/index.html"]) {
        out.add(
            &rules::DOCUMENTATION_MISSING,
            "documentation/",
            "The archive has no documentation/index.html, which tools present as the documentation of the model",
        );
    }
    // Releases of FMI 2.0 differ in where the folder is.
    let beside = model.version == FmiVersion::V2 && in_folder("licenses/");
    if !(in_folder("documentation/licenses/") || beside) {
        out.add(
            &rules::LICENSE_MISSING,
            "documentation/",
            "The archive has no folder documentation/licenses, so the terms of its use are unknown",
        );
    }
    if model.version == FmiVersion::V2 {
        return;
    }
    let licenses = "documentation/licenses/";
    if in_folder(licenses)
        && !any_of(
            &["spdx", "txt", "html"].map(|x| format!("{licenses}license.{x}")).each_ref().map(String::as_str),
        )
    {
        out.add(
            &rules::LICENSE_ENTRY,
            licenses,
            "The licence folder has no entry point license.spdx, license.txt or license.html",
        );
    }
    let documented =
        any_of(&["documentation/externalDependencies.txt", "documentation/externalDependencies.html"]);
    if let Some(interface) =
        model.interfaces.iter().find(|i| is_true(**i, "needsExecutionTool")).filter(|_| !documented)
    {
        let message = "needsExecutionTool is true, but documentation/externalDependencies.{txt|html} does not say which tool";
        out.add(&rules::TOOL_UNDOCUMENTED, model.place(*interface), message);
    }
}
