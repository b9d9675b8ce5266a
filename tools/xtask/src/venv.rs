//! Python environments in the target folder, with pinned packages: that of tests and examples, and one for each command
//! that needs a tool which comes as a package.

use crate::{Outcome, files, shell, workspace::Workspace};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Name of an environment, and the file of its requirements.
pub type Environment = (&'static str, &'static str);
/// Of tests and examples.
pub const TESTS: Environment = ("venv", "tests/python/requirements.txt");
/// Of `cargo xtask cross`: a linker for other platforms.
pub const CROSS: Environment = ("venv-cross", "tools/xtask/cross-requirements.txt");
/// Of `cargo xtask importers`: what bindings to C are made with.
pub const IMPORTERS: Environment = ("venv-importers", "tests/importers/requirements.txt");
const OLDEST: (u32, u32) = (3, 11);
/// The requirements of the venv; it is made again when they change.
const STAMP: &str = "requirements.stamp";

/// The Python of an environment, which is made first if it is not there or has other packages.
pub fn python(workspace: &Workspace, (name, requirements): Environment) -> Outcome<PathBuf> {
    let file = workspace.root.join(requirements);
    let wanted = files::read(&file)?;
    let folder = workspace.target.join(name);
    let python = if cfg!(windows) { folder.join("Scripts/python.exe") } else { folder.join("bin/python") };
    if is_current(&folder, &wanted) && works(&python) {
        return Ok(python);
    }
    shell::stage(&format!("Python packages into {}", folder.display()));
    let base = base_python()?;
    files::remove(&folder)?;
    make(base, &folder)?;
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]).arg(&file);
    shell::run(&mut pip).map_err(|e| {
        format!("the packages of {requirements} could not be installed; is the network reachable? {e}")
    })?;
    files::write(&folder.join(STAMP), &wanted)?;
    Ok(python)
}

fn is_current(folder: &Path, wanted: &str) -> bool {
    std::fs::read_to_string(folder.join(STAMP)).is_ok_and(|have| have == wanted)
}

/// A venv keeps a link to the Python it was made with, which may be gone.
fn works(python: &Path) -> bool {
    Command::new(python).arg("--version").output().is_ok_and(|o| o.status.success())
}

/// The first Python on the path that is new enough.
fn base_python() -> Outcome<&'static str> {
    let mut too_old = None;
    for name in ["python3", "python"] {
        let ask = ["-c", "import sys; print(*sys.version_info[:2])"];
        let Ok(text) = shell::output(Command::new(name).args(ask)) else { continue };
        match version(&text) {
            Some(found) if found >= OLDEST => return Ok(name),
            Some((major, minor)) => too_old = Some(format!("`{name}` is Python {major}.{minor}")),
            None => continue,
        }
    }
    let need = format!("install Python {}.{} or newer with venv", OLDEST.0, OLDEST.1);
    Err(match too_old {
        Some(found) => format!("{found}, which is too old; {need}"),
        None => format!("neither `python3` nor `python` runs; {need}"),
    })
}

fn version(text: &str) -> Option<(u32, u32)> {
    let (major, minor) = text.trim().split_once(' ')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

fn make(base: &str, folder: &Path) -> Outcome {
    // Debian and Ubuntu split venv off, and say so only after a folder has been half made.
    shell::output(Command::new(base).args(["-c", "import venv, ensurepip"])).map_err(|_| {
        format!("`{base}` has no venv; install it, on Debian and Ubuntu with `apt-get install python3-venv`")
    })?;
    shell::output(Command::new(base).args(["-m", "venv"]).arg(folder)).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_compare_as_numbers() {
        assert!(version("3 10").unwrap() < OLDEST);
        assert!(version("3 11\n").unwrap() >= OLDEST);
        assert!(version("4 0").unwrap() >= OLDEST);
        assert_eq!(version("Python 3"), None);
    }

    #[test]
    fn every_requirement_is_pinned() {
        for (_, file) in [TESTS, CROSS, IMPORTERS] {
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
            let text = std::fs::read_to_string(file).unwrap();
            let lines: Vec<&str> = text.lines().filter(|l| !l.is_empty() && !l.starts_with('#')).collect();
            assert!(!lines.is_empty());
            for line in lines {
                assert!(line.contains("=="), "{line}");
            }
        }
    }
}
