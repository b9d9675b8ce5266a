//! `cargo xtask wheel`: a Python wheel with the program, the FMU library beside it, the archives of all models and the package `motor_fmu`.
//!
//! setuptools and not maturin, which puts a program into the folder of scripts, apart from the library that belongs beside it.

use crate::{Outcome, files, product, shell, venv, workspace::Workspace};
use std::process::Command;

/// Installs the wheel into a fresh environment and uses it; a stage of `cargo xtask nightly`.
const TESTS: &str = "tests/python/wheel_package.py";
/// The package's own files, and what else stands in the wheel: file of the repository, name there.
const SOURCES: [&str; 5] =
    ["pyproject.toml", "setup.py", "README.md", "motor_fmu/__init__.py", "motor_fmu/py.typed"];
const LICENCES: [(&str, &str); 2] =
    [("LICENSE", "LICENSE"), ("tools/archive/assets/third-party.txt", "THIRD-PARTY.txt")];

/// Builds the program and packs the wheel.
pub fn run(workspace: &Workspace) -> Outcome {
    let python = venv::python(workspace, venv::TESTS)?;
    shell::stage("building the program and the archives");
    product::build(workspace)?;
    let stage = workspace.target.join("wheel");
    files::remove(&stage)?;
    let package = stage.join("motor_fmu");
    for name in SOURCES {
        files::copy(&workspace.root.join("python").join(name), &stage.join(name))?;
    }
    for (file, name) in LICENCES {
        files::copy(&workspace.root.join(file), &stage.join(name))?;
    }
    files::write(&stage.join("VERSION"), env!("CARGO_PKG_VERSION"))?;
    let program = workspace.program("motor-fmu");
    let library = format!("{}motor_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    for file in [program.as_path(), &program.with_file_name(library)] {
        files::copy(file, &package.join("bin").join(file.file_name().unwrap_or_default()))?;
    }
    shell::run(product::motor_fmu(workspace).args(["build", "--out"]).arg(package.join("archives")))?;
    shell::stage("packing the wheel");
    let out = workspace.dist();
    let mut pack = Command::new(python);
    pack.args(["-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir"]).arg(&out).arg(&stage);
    shell::run(&mut pack)?;
    println!("wheel: {}/motor_fmu-*.whl", out.display());
    Ok(())
}

/// Packs the wheel and tests it.
pub fn test(workspace: &Workspace) -> Outcome {
    run(workspace)?;
    let mut tests = product::python(workspace, &venv::python(workspace, venv::TESTS)?);
    shell::run(tests.args(["-m", "pytest", TESTS]))
}
