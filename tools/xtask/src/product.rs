//! The product: the `motor-fmu` program, the archives it builds, and a Python environment with the paths of both.

use crate::{Outcome, files, shell, workspace::Workspace};
use std::path::Path;
use std::process::Command;

/// Motor and actuator of the walking examples: the declared ones with the friction that the preset adds, and the control
/// that compensates for it.
const WALKING: ([&str; 2], &str) = (["AnnulusCooledMotor", "SeriesElasticActuator"], "maxon-305015");

/// Builds everything, in the one profile that all commands share.
pub fn build(workspace: &Workspace) -> Outcome {
    shell::run(&mut workspace.cargo(&["build", "--release", "--workspace"]))
}

/// Builds the archives into dist/ with the default start values, and those of the walking examples into dist/presets/PRESET/.
pub fn archives(workspace: &Workspace) -> Outcome {
    shell::run(motor_fmu(workspace).args(["build", "--out"]).arg(workspace.dist()))?;
    let (models, preset) = WALKING;
    let out = workspace.dist().join("presets").join(preset);
    shell::run(motor_fmu(workspace).arg("build").args(models).args(["--preset", preset, "--out"]).arg(out))
}

/// Validates every archive in dist/; an empty folder is an error.
pub fn validate(workspace: &Workspace) -> Outcome {
    let mut found = Vec::new();
    for standard in ["fmi2", "fmi3"] {
        let folder = workspace.dist().join(standard);
        let mut fmus = files::entries(&folder)?;
        fmus.retain(|path| path.extension().is_some_and(|e| e == "fmu"));
        if fmus.is_empty() {
            return Err(format!("there is no .fmu in {}", folder.display()));
        }
        found.extend(fmus);
    }
    shell::run(motor_fmu(workspace).arg("validate").args(found))
}

/// The program, in the root of the workspace.
pub fn motor_fmu(workspace: &Workspace) -> Command {
    let mut command = Command::new(workspace.program("motor-fmu"));
    command.current_dir(&workspace.root);
    command
}

/// Python with the paths of archives and program.
pub fn python(workspace: &Workspace, python: &Path) -> Command {
    let mut command = Command::new(python);
    command
        .current_dir(&workspace.root)
        .env("MOTOR_FMU_DIST", workspace.dist())
        .env("MOTOR_FMU_BIN", workspace.program("motor-fmu"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        // Else Python buffers its progress for minutes when it writes to a pipe.
        .env("PYTHONUNBUFFERED", "1");
    command
}
