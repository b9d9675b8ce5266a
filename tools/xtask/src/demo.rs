//! `cargo xtask demo`: from a clean clone to the main job and a page about it.

mod page;

use crate::files::{read, write_page};
use crate::{Outcome, product, shell, venv, workspace::Workspace};
use std::path::Path;
use std::process::Stdio;

const WALK: &str = "examples/02_walking.py";
/// What cooling buys under gait: results and figure of `examples/08_walking_study.py`, which takes a quarter of an hour and is
/// recomputed and compared by `cargo xtask nightly`.
const STUDY: [&str; 2] = ["examples/expected/08_walking_study.json", "docs/walking-study.svg"];
/// Motor, actuator and gait as one system.
const SYSTEM: &str = "examples/systems/actuator-gait.toml";
/// The measured motor of the bench.
const BENCH: &str = "examples/04_close_the_loop_bench.py";

/// Builds all that the page shows, and the page.
pub fn run(workspace: &Workspace, force: bool) -> Outcome {
    // First, so that a missing Python is reported before minutes of compiling.
    let python = venv::python(workspace, venv::TESTS)?;
    shell::stage("building everything");
    product::build(workspace)?;
    shell::stage("packing the FMUs");
    product::archives(workspace)?;
    shell::stage("validating the FMUs");
    product::validate(workspace)?;
    shell::stage("walking until the winding reaches its limit, without and with fan");
    let dist = workspace.dist();
    example(workspace, &python, WALK, &dist)?;
    shell::stage("motor, actuator and gait as one system");
    let system = dist.join("actuator-gait.ssp");
    shell::run(product::motor_fmu(workspace).args(["ssp", SYSTEM, "--out"]).arg(&system))?;
    let mut run = product::motor_fmu(workspace);
    shell::run(run.arg("cosim").arg(&system).arg("--output").arg(system.with_extension("csv")))?;
    shell::stage("closing the loop on the measured bench data");
    let bench = dist.join("bench");
    example(workspace, &python, BENCH, &bench)?;
    let report = dist.join("bench.html");
    write_page(&report, &read(&bench.join("fan/report.html"))?, force)?;
    shell::stage("the two publications recomputed");
    let published = ["thesis", "paper"];
    for what in published {
        let mut reproduce = product::motor_fmu(workspace);
        shell::run(reproduce.args(["reproduce", what, "--out"]).arg(&dist).stdout(Stdio::null()))?;
    }
    let page = dist.join("index.html");
    let walk = page::walk(&read(&dist.join("walking.json"))?, &read(&dist.join("walking.svg"))?)?;
    let [study, figure] = STUDY.map(|file| read(&workspace.root.join(file)));
    let study = page::study(&study?, &figure?)?;
    let html = page::html(walk, study, page::bench(&read(&bench.join("fan/report.json"))?)?);
    write_page(&page, &html, force)?;
    println!("FMUs: {0}/fmi2, {0}/fmi3\nresults: {1}", dist.display(), page.display());
    println!("system: {}", system.display());
    println!("closed loop: {}, all of it in {}", report.display(), bench.display());
    published
        .iter()
        .for_each(|what| println!("publication: {}", dist.join(what).with_extension("html").display()));
    Ok(())
}

/// An example with its files in a folder. Its numbers are in those files; its progress, on standard error, is for the user.
fn example(workspace: &Workspace, python: &Path, script: &str, out: &Path) -> Outcome {
    std::fs::create_dir_all(out).map_err(|e| format!("{} cannot be made: {e}", out.display()))?;
    shell::run(product::python(workspace, python).arg(script).arg("--out").arg(out).stdout(Stdio::null()))
}
