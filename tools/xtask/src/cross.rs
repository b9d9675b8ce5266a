//! `cargo xtask cross`: the library for each platform, one archive that holds all of them, and the same run on each.

mod compare;
mod compiler;

use crate::{Outcome, files, product, shell, venv, workspace::Workspace};
use compiler::Compiler;
use std::path::{Path, PathBuf};

/// A platform to build for, and how its programs are run here.
struct Target {
    /// Its name in the archive.
    platform: &'static str,
    /// Its name for the compiler.
    triple: &'static str,
    /// What the compiler calls the library.
    library: &'static str,
    /// Ending of a program.
    program: &'static str,
    /// The linker, where zig is not it.
    linker: Option<&'static str>,
    /// What runs its programs elsewhere: candidates for the program, and its arguments.
    runner: (&'static [&'static str], &'static [&'static str]),
}

/// zig links for Linux, so that the oldest glibc of use is enough. For Windows it lacks a library that Rust's standard
/// library asks for (seen with 0.17); mingw has it.
const TARGETS: [Target; 3] = [
    Target {
        platform: "x86_64-linux",
        triple: "x86_64-unknown-linux-gnu",
        library: "libmotor_fmu.so",
        program: "",
        linker: None,
        runner: (&[], &[]),
    },
    Target {
        platform: "x86_64-windows",
        triple: "x86_64-pc-windows-gnu",
        library: "motor_fmu.dll",
        program: ".exe",
        linker: Some("x86_64-w64-mingw32-gcc"),
        runner: (&["wine64", "wine", "/usr/lib/wine/wine64"], &[]),
    },
    Target {
        platform: "aarch64-linux",
        triple: "aarch64-unknown-linux-gnu",
        library: "libmotor_fmu.so",
        program: "",
        linker: None,
        runner: (&["qemu-aarch64", "qemu-aarch64-static"], &["-L", "/usr/aarch64-linux-gnu"]),
    },
];

/// The glibc that the Linux libraries must do with: that of every distribution in use since 2014.
const GLIBC: (u32, u32) = (2, 17);
/// Bytes that an archive may have.
const MOST_BYTES: u64 = 3 << 20;
/// What platforms may differ by (`compare::difference`): their C libraries round pow and exp differently.
const TOLERANCE: f64 = 1e-12;
/// The run that is compared: stop and step (s), and settings by model. The step is one that the integrator takes whole:
/// where its error control cuts one, the length of the parts depends on the last digits, and an ulp of the
/// supply moves the gearmotor's outputs by 1e-10 on one and the same machine.
const RUN: [&str; 2] = ["1", "0.0002"];
const SETTINGS: [(&str, &[&str]); 4] = [
    (
        "AnnulusCooledMotor",
        &["voltage=36", "load_torque=0.08", "fan_command=0.5", "cooling_mode=annulus_push"],
    ),
    ("BrushedGearmotor", &["duty=0.7", "load_torque=0.1"]),
    ("SeriesElasticActuator", &["torque_demand=30", "motor_speed=50", "motor_current=2"]),
    ("GaitLoad", &["gait.variation=0.03", "joint_torque=20"]),
];

/// Builds and runs on every platform; `other` is the root of another Rust.
pub fn run(workspace: &Workspace, other: Option<&Path>) -> Outcome {
    product::build(workspace)?;
    let python = venv::python(workspace, venv::CROSS)?;
    let target = workspace.target.join("cross");
    for one in &TARGETS {
        shell::stage(&format!("building for {}", one.platform));
        build(workspace, one, other, &python, &target)?;
    }
    shell::stage("packing one archive for all of them");
    let dist = workspace.dist().join("cross");
    pack(workspace, &dist)?;
    compare::pack_here(workspace, &target)?;
    let mut missing = Vec::new();
    for one in &TARGETS {
        shell::stage(&format!("running on {}", one.platform));
        match runner(one) {
            Ok(runner) => {
                compare::help_wine(one, &target)?;
                compare::run(workspace, one, &runner, &target, &dist)?;
            }
            Err(sentence) => missing.push(sentence),
        }
    }
    if missing.is_empty() { Ok(()) } else { Err(missing.join("; ")) }
}

/// Builds library and master, and puts the library where `motor-fmu build --platform` looks for it.
fn build(workspace: &Workspace, one: &Target, other: Option<&Path>, python: &Path, target: &Path) -> Outcome {
    let compiler = Compiler::find(workspace, one.triple, other)?;
    if let Some(linker) = one.linker.filter(|linker| !shell::is_program(linker)) {
        return Err(format!(
            "{linker}, which links for {}, is not on the path; on Debian and Ubuntu it is in \
             gcc-mingw-w64-x86-64-win32",
            one.platform
        ));
    }
    for what in [["--package", "fmu", "--lib"].as_slice(), &["--package", "cosim", "--example", "simulate"]] {
        let mut command = compiler.command(workspace);
        if one.linker.is_none() {
            let (major, minor) = GLIBC;
            command.arg("zigbuild").args(["--target", &format!("{}.{major}.{minor}", one.triple)]);
            compiler.find_zig(&mut command, python)?;
        } else {
            command.args(["build", "--target", one.triple]);
        }
        command.args(["--release", "--locked"]).args(what).args(compiler.flags());
        shell::run(command.env("CARGO_TARGET_DIR", target))?;
    }
    let folder = workspace.program("motor-fmu").with_file_name("platforms").join(one.platform);
    files::copy(&built(one, target).join(one.library), &folder.join(one.library))
}

/// The folder that the compiler writes to.
fn built(one: &Target, target: &Path) -> PathBuf {
    target.join(one.triple).join("release")
}

/// Builds the archives and checks their size and the glibc that they need.
fn pack(workspace: &Workspace, dist: &Path) -> Outcome {
    let platforms = TARGETS.map(|t| t.platform).join(",");
    let mut command = product::motor_fmu(workspace);
    let said = shell::output(command.args(["build", "--platform", &platforms, "--out"]).arg(dist))?;
    println!("{said}");
    let too_new = too_new(&said);
    if !too_new.is_empty() {
        return Err(format!("glibc {}.{} is not enough for {}", GLIBC.0, GLIBC.1, too_new.join(", ")));
    }
    for (model, _) in SETTINGS {
        for standard in ["fmi2", "fmi3"] {
            let file = dist.join(standard).join(format!("{model}.fmu"));
            let size = std::fs::metadata(&file)
                .map_err(|e| format!("{} cannot be read: {e}", file.display()))?
                .len();
            println!("{}: {size} bytes", file.display());
            if size > MOST_BYTES {
                return Err(format!("{} has {size} bytes, the limit is {MOST_BYTES}", file.display()));
            }
        }
    }
    Ok(())
}

/// Platforms in `libraries for x86_64-linux with glibc 2.14 or later, ...` that need a glibc newer than ours may be.
fn too_new(said: &str) -> Vec<String> {
    let line = said.lines().find_map(|l| l.strip_prefix("libraries for ")).unwrap_or_default();
    let needs = |part: &str| -> Option<(String, (u32, u32))> {
        let (platform, version) = part.split_once(" with glibc ")?;
        let (major, minor) = version.split_once(' ')?.0.split_once('.')?;
        Some((platform.to_string(), (major.parse().ok()?, minor.parse().ok()?)))
    };
    line.split(", ").filter_map(needs).filter(|(_, version)| *version > GLIBC).map(|(p, _)| p).collect()
}

/// A command that runs programs of a platform; here they run by themselves.
fn runner(one: &Target) -> Outcome<Vec<String>> {
    if one.runner.0.is_empty() {
        return Ok(Vec::new());
    }
    let Some(program) = one.runner.0.iter().find(|p| shell::is_program(p)) else {
        return Err(format!(
            "none of {} is there, so the library for {} was built but not run",
            one.runner.0.join(", "),
            one.platform
        ));
    };
    Ok(std::iter::once(program).chain(one.runner.1).map(|w| (*w).to_string()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_that_needs_too_new_a_glibc_is_named() {
        let said = "libraries for x86_64-linux with glibc 2.34 or later, x86_64-windows, aarch64-linux with glibc 2.17 or later\nx: fine";
        assert_eq!(too_new(said), ["x86_64-linux"]);
    }
}
