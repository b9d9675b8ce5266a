//! `cargo xtask page`: compiles the native models for WebAssembly and writes `dist/page.html`, which holds everything and needs no network.

use crate::{Outcome, files, product, shell, venv, workspace::Workspace};

const TARGET: &str = "wasm32-unknown-unknown";
/// The profile of Cargo.toml that optimises all that the page computes.
const PROFILE: &str = "page";
/// Opens the page in Chromium and compares its values with `motor-fmu`; a stage of `cargo xtask nightly`.
const TESTS: &str = "tests/python/browser_page.py";

/// Compiles the models and writes the page.
pub fn run(workspace: &Workspace, force: bool) -> Outcome {
    shell::stage("compiling the models for WebAssembly");
    let mut build =
        workspace.cargo(&["build", "--profile", PROFILE, "--package", "page", "--lib", "--target", TARGET]);
    shell::run(&mut build)
        .map_err(|e| format!("{e}; the target is installed by `rustup target add {TARGET}`"))?;
    shell::stage("writing the page");
    let models = workspace.target.join(TARGET).join(PROFILE).join("page.wasm");
    let page = workspace.dist().join("page.html");
    let mut write = workspace.cargo(&["run", "--quiet", "--release", "--package", "page", "--"]);
    let made = workspace.target.join("page.html");
    shell::run(write.arg(models).arg(&made))?;
    files::write_page(&page, &files::read(&made)?, force)?;
    println!("page: {}", page.display());
    Ok(())
}

/// Writes the page and tests it in Chromium.
pub fn test(workspace: &Workspace) -> Outcome {
    run(workspace, false)?;
    product::build(workspace)?;
    product::archives(workspace)?;
    let mut tests = product::python(workspace, &venv::python(workspace, venv::TESTS)?);
    shell::run(tests.args(["-m", "pytest", TESTS]))
}
