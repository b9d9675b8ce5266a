//! `cargo xtask importers`: the archives in third-party Rust importers. These take longer to compile than the product
//! itself, so they are a stage of `cargo xtask nightly`; the Python importers are part of the everyday run.

use crate::{Outcome, product, shell, venv, workspace::Workspace};
use std::path::Path;

const MANIFEST: &str = "tests/importers/Cargo.toml";
const TESTS: &str = "tests/python/rust_importers.py";

/// Builds archives and importers, and runs the tests of these.
pub fn run(workspace: &Workspace) -> Outcome {
    let (python, tools) = (venv::python(workspace, venv::TESTS)?, venv::python(workspace, venv::IMPORTERS)?);
    shell::stage("building the archives");
    product::build(workspace)?;
    product::archives(workspace)?;
    shell::stage("building the importers");
    let target = workspace.target.join("importers");
    let mut build = workspace.cargo(&["build", "--release", "--locked", "--manifest-path", MANIFEST]);
    build.env("CARGO_TARGET_DIR", &target).env("LIBCLANG_PATH", libclang(&tools)?);
    if let Some(headers) = compiler_headers() {
        build.env("BINDGEN_EXTRA_CLANG_ARGS", format!("-I{headers}"));
    }
    shell::run(&mut build)?;
    shell::stage("running them");
    let program = target.join("release").join(format!("importers{}", std::env::consts::EXE_SUFFIX));
    let mut tests = product::python(workspace, &python);
    tests.env("MOTOR_FMU_RUST_IMPORTERS", program).args(["-m", "pytest", TESTS]);
    shell::run(&mut tests)
}

/// The folder of the shared library in the package.
fn libclang(python: &Path) -> Outcome<String> {
    let ask = "import clang, pathlib; print(pathlib.Path(clang.__file__).parent / 'native')";
    shell::output(std::process::Command::new(python).args(["-c", ask]))
}

/// The package has no headers of its own (stddef.h); those of the C compiler serve.
fn compiler_headers() -> Option<String> {
    let found = shell::output(std::process::Command::new("cc").arg("-print-file-name=include")).ok()?;
    Path::new(&found).is_absolute().then_some(found)
}
