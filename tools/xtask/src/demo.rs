//! `cargo xtask demo`: from a clean clone to the main job and a page about it.

mod page;

use crate::{Outcome, product, shell, venv, workspace::Workspace};
use std::path::Path;
use std::process::Stdio;

const EXAMPLE: &str = "examples/02_walking.py";

/// Takes no arguments.
pub fn run(workspace: &Workspace, arguments: &[String]) -> Outcome {
    if let Some(extra) = arguments.first() {
        return Err(format!("`demo` takes no arguments, got {extra:?}"));
    }
    // First, because a missing Python should not be found out after minutes of compiling.
    let python = venv::python(workspace)?;
    shell::stage("building everything");
    product::build(workspace)?;
    shell::stage("packing the FMUs");
    product::archives(workspace)?;
    shell::stage("validating the FMUs");
    product::validate(workspace)?;
    shell::stage("twenty minutes of walking, twice");
    let dist = workspace.dist();
    // Its numbers are for the page; its progress, on standard error, is for the user.
    let mut example = product::python(workspace, &python);
    shell::run(example.arg(EXAMPLE).arg("--out").arg(&dist).stdout(Stdio::null()))?;
    shell::stage("the two publications recomputed");
    let published = ["thesis", "paper"];
    for what in published {
        let mut reproduce = product::motor_fmu(workspace);
        shell::run(reproduce.args(["reproduce", what, "--out"]).arg(&dist).stdout(Stdio::null()))?;
    }
    let page = dist.join("index.html");
    let html = page::html(&read(&dist.join("walking.json"))?, &read(&dist.join("walking.svg"))?)?;
    std::fs::write(&page, html).map_err(|e| format!("{} cannot be written: {e}", page.display()))?;
    println!("FMUs: {0}/fmi2, {0}/fmi3\nresults: {1}", dist.display(), page.display());
    published
        .iter()
        .for_each(|what| println!("publication: {}", dist.join(what).with_extension("html").display()));
    Ok(())
}

fn read(file: &Path) -> Outcome<String> {
    std::fs::read_to_string(file).map_err(|e| format!("{} cannot be read: {e}", file.display()))
}
