//! The header of a library: its platform, its exports, and the C library that it needs.

use object::elf::FileHeader64;
use object::read::elf::FileHeader;
use object::{Architecture, BinaryFormat, Endianness, Object};

/// What a library of an FMU may export.
const EXPORTS: [&str; 2] = ["fmi2", "fmi3"];

/// Name of the platform as FMI 3 writes it; `None` where the file is no library that can be read.
pub fn platform(bytes: &[u8]) -> Option<String> {
    let file = object::File::parse(bytes).ok()?;
    let system = match file.format() {
        BinaryFormat::Elf => "linux",
        BinaryFormat::Pe | BinaryFormat::Coff => "windows",
        BinaryFormat::MachO => "darwin",
        _ => return None,
    };
    let architecture = match file.architecture() {
        Architecture::X86_64 => "x86_64".to_string(),
        Architecture::Aarch64 => "aarch64".to_string(),
        other => format!("{other:?}").to_lowercase(),
    };
    Some(format!("{architecture}-{system}"))
}

/// Exported names that are not functions of FMI.
pub fn foreign_exports(bytes: &[u8]) -> Vec<String> {
    let Ok(file) = object::File::parse(bytes) else { return Vec::new() };
    let names = file.exports().unwrap_or_default();
    let names = names.iter().map(|e| String::from_utf8_lossy(e.name()).into_owned());
    // On macOS names have a line in front.
    names
        .filter(|name| !EXPORTS.iter().any(|start| name.trim_start_matches('_').starts_with(start)))
        .collect()
}

/// The newest version of glibc whose symbols the library requires.
pub fn glibc(bytes: &[u8]) -> Option<(u32, u32)> {
    let newest = || -> object::Result<Option<(u32, u32)>> {
        let header = FileHeader64::<Endianness>::parse(bytes)?;
        let endian = header.endian()?;
        let sections = header.sections(endian, bytes)?;
        let Some((mut files, strings)) = sections.gnu_verneed(endian, bytes)? else { return Ok(None) };
        let strings = sections.strings(endian, bytes, strings)?;
        let mut newest = None;
        while let Some((_, mut versions)) = files.next()? {
            while let Some(version) = versions.next()? {
                newest = newest.max(version_of(version.name(endian, strings)?));
            }
        }
        Ok(newest)
    };
    newest().ok().flatten()
}

/// `GLIBC_2.14` and `GLIBC_2.2.5` as numbers; the third one never decides.
fn version_of(name: &[u8]) -> Option<(u32, u32)> {
    let mut numbers = std::str::from_utf8(name).ok()?.strip_prefix("GLIBC_")?.split('.').map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::platform::HERE;

    #[test]
    fn a_program_of_this_platform_says_so() {
        let own = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert_eq!(platform(&own).as_deref(), Some(HERE.tuple));
        assert_eq!(platform(b"text"), None);
        #[cfg(all(target_os = "linux", target_env = "gnu"))]
        assert!(glibc(&own).unwrap() >= (2, 14), "memcpy of Rust's own library is of 2.14");
    }

    #[test]
    fn versions_compare_as_numbers() {
        assert_eq!(version_of(b"GLIBC_2.2.5"), Some((2, 2)));
        assert!(version_of(b"GLIBC_2.34") > version_of(b"GLIBC_2.4"));
        assert_eq!(version_of(b"GCC_3.0"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn exports_other_than_fmi_functions_are_listed() {
        let folder = tempfile::tempdir().unwrap();
        let (source, library) = (folder.path().join("x.c"), folder.path().join("x.so"));
        std::fs::write(&source, "int fmi2Reset(void) { return 0; }\nint helper(void) { return 1; }\n")
            .unwrap();
        let mut compiler = std::process::Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-nostdlib", "-o"]).arg(&library).arg(&source);
        assert!(compiler.status().unwrap().success());
        assert_eq!(foreign_exports(&std::fs::read(&library).unwrap()), ["helper"]);
    }
}
