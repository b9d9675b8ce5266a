//! The platforms that an archive can hold a library for, and where the libraries are.

use crate::build::BuildError;
use crate::object_file;
use std::path::{Path, PathBuf};

/// A platform that the library can be for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Its name in FMI 3, and for the user.
    pub tuple: &'static str,
    /// Its name in FMI 2.
    pub fmi2: &'static str,
    /// What the compiler calls the library.
    pub file: &'static str,
    /// Ending of a library.
    pub ending: &'static str,
}

const fn platform(
    tuple: &'static str,
    fmi2: &'static str,
    file: &'static str,
    ending: &'static str,
) -> Platform {
    Platform { tuple, fmi2, file, ending }
}

/// All of them.
pub const ALL: [Platform; 5] = [
    platform("x86_64-linux", "linux64", "libmotor_fmu.so", "so"),
    platform("x86_64-windows", "win64", "motor_fmu.dll", "dll"),
    platform("aarch64-linux", "aarch64-linux", "libmotor_fmu.so", "so"),
    platform("aarch64-darwin", "aarch64-darwin", "libmotor_fmu.dylib", "dylib"),
    platform("x86_64-darwin", "darwin64", "libmotor_fmu.dylib", "dylib"),
];

/// The platform that this tool runs on.
pub const HERE: Platform = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    ALL[0]
} else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
    ALL[1]
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    ALL[2]
} else if cfg!(target_arch = "aarch64") {
    ALL[3]
} else {
    ALL[4]
};

/// A library and what it runs on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Library {
    /// The platform.
    pub platform: Platform,
    /// The file.
    pub path: PathBuf,
}

impl Library {
    /// A library for the platform that this tool runs on.
    pub fn here(path: &Path) -> Library {
        Library { platform: HERE, path: path.to_path_buf() }
    }

    /// Requirements of the machine, as text.
    pub fn needs(&self) -> String {
        let glibc = std::fs::read(&self.path).ok().and_then(|bytes| object_file::glibc(&bytes));
        let glibc = glibc.map(|(a, b)| format!(" with glibc {a}.{b} or later")).unwrap_or_default();
        format!("{}{glibc}", self.platform.tuple)
    }
}

/// The platform with this name.
pub fn by_name(name: &str) -> Result<Platform, BuildError> {
    let known = || ALL.map(|p| p.tuple).join(", ");
    let found = ALL.into_iter().find(|p| p.tuple == name);
    found.ok_or_else(|| BuildError(format!("{name} is no platform; there is {}", known())))
}

/// The FMU library in the folder of the running program.
pub fn library_path() -> Result<PathBuf, BuildError> {
    let program = std::env::current_exe().map_err(|error| BuildError::library(HERE.file.as_ref(), &error))?;
    Ok(program.with_file_name(HERE.file))
}

/// The library for a platform among those that `cargo xtask cross` has put beside the running program; that of the
/// program itself where it has made none for here.
pub fn library(platform: Platform) -> Result<Library, BuildError> {
    let own = library_path()?;
    among(platform, &own)
}

fn among(platform: Platform, own: &Path) -> Result<Library, BuildError> {
    let made = own.with_file_name("platforms").join(platform.tuple).join(platform.file);
    if made.is_file() {
        Ok(Library { platform, path: made })
    } else if platform == HERE {
        Ok(Library::here(own))
    } else {
        Err(BuildError(format!(
            "there is no library for {} at {}; `cargo xtask cross` makes it, on any platform with its compiler \
             `cargo build --release`",
            platform.tuple,
            made.display()
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_is_an_error_that_lists_the_names() {
        assert_eq!(by_name("x86_64-windows").unwrap().fmi2, "win64");
        let error = by_name("win64").unwrap_err().to_string();
        assert!(error.contains("win64") && error.contains("aarch64-linux"), "{error}");
    }

    #[test]
    fn a_library_that_was_not_made_is_missing_and_never_another_s() {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join(HERE.file);
        assert_eq!(among(HERE, &own).unwrap(), Library::here(&own));
        let other = ALL.into_iter().find(|p| *p != HERE).unwrap();
        let error = among(other, &own).unwrap_err().to_string();
        assert!(error.contains(other.tuple) && error.contains("cargo xtask cross"), "{error}");
        let made = folder.path().join("platforms").join(other.tuple);
        std::fs::create_dir_all(&made).unwrap();
        std::fs::write(made.join(other.file), "library").unwrap();
        assert_eq!(among(other, &own).unwrap(), Library { platform: other, path: made.join(other.file) });
    }
}
