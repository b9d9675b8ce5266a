//! The product: the `motor-fmu` program, the archives it builds, and an environment that finds both.

use crate::{Outcome, shell, workspace::Workspace};
use std::path::Path;
use std::process::Command;

/// The motor that walks in the examples: the declared motor with the friction that the preset adds.
const WALKING: (&str, &str) = ("AnnulusCooledMotor", "maxon-305015");

/// Builds everything, in the one profile that all commands share.
pub fn build(workspace: &Workspace) -> Outcome {
    shell::run(&mut workspace.cargo(&["build", "--release", "--workspace"]))
}

/// Builds the archives into dist/ with the declared start values, and the motor that walks into dist/presets/PRESET/.
pub fn archives(workspace: &Workspace) -> Outcome {
    shell::run(motor_fmu(workspace).args(["build", "--out"]).arg(workspace.dist()))?;
    let (model, preset) = WALKING;
    let out = workspace.dist().join("presets").join(preset);
    shell::run(motor_fmu(workspace).args(["build", model, "--preset", preset, "--out"]).arg(out))
}

/// Validates every archive in dist/; that there is none is an error.
pub fn validate(workspace: &Workspace) -> Outcome {
    let mut files = Vec::new();
    for standard in ["fmi2", "fmi3"] {
        let folder = workspace.dist().join(standard);
        let entries = folder.read_dir().map_err(|e| format!("{} cannot be read: {e}", folder.display()))?;
        let fmus = entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "fmu"));
        let before = files.len();
        files.extend(fmus);
        if files.len() == before {
            return Err(format!("there is no .fmu in {}", folder.display()));
        }
    }
    files.sort();
    shell::run(motor_fmu(workspace).arg("validate").args(files))
}

/// The program, in the root of the workspace.
pub fn motor_fmu(workspace: &Workspace) -> Command {
    let mut command = Command::new(workspace.program("motor-fmu"));
    command.current_dir(&workspace.root);
    command
}

/// Python that finds archives and program.
pub fn python(workspace: &Workspace, python: &Path) -> Command {
    let mut command = Command::new(python);
    command
        .current_dir(&workspace.root)
        .env("MOTOR_FMU_DIST", workspace.dist())
        .env("MOTOR_FMU_BIN", workspace.program("motor-fmu"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        // Into a pipe Python would else write its progress in blocks of minutes.
        .env("PYTHONUNBUFFERED", "1");
    command
}
