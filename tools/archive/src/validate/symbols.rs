//! The functions that a binary must export (`fmi2Functions.h`, `fmi3Functions.h`), and what it does export.

use object::read::macho::{FatArch, MachOFatFile32, MachOFatFile64};
use object::{Architecture, FileKind, Object, ObjectSymbol};

use super::model::{FmiVersion, Model};

/// Groups of functions, each under the prefix of its standard and, where only one needs them, the interface type.
const FUNCTIONS: &str = include_str!("functions.txt");

/// The names that the binary called `identifier` must export.
pub(crate) fn required(model: &Model, identifier: &str) -> Vec<String> {
    let standard = if model.version == FmiVersion::V2 { "fmi2" } else { "fmi3" };
    let is_for = |interface: &str| {
        let named = |i: &roxmltree::Node| i.attribute("modelIdentifier") == Some(identifier);
        model.interfaces.iter().any(|i| i.has_tag_name(interface) && named(i))
    };
    let mut names = Vec::new();
    for group in FUNCTIONS.split("\n\n") {
        let Some((head, functions)) = group.split_once(':') else { continue };
        let (prefix, interface) = head.split_once(' ').map_or((head, None), |(p, i)| (p, Some(i)));
        if prefix == standard && interface.is_none_or(is_for) {
            names.extend(functions.split_ascii_whitespace().map(|name| format!("{prefix}{name}")));
        }
    }
    names
}

/// The operating system that a binary format belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum System {
    Linux,
    Windows,
    Darwin,
}

/// One machine's part of a binary.
pub(crate) struct Part {
    pub(crate) system: System,
    pub(crate) architecture: Architecture,
    pub(crate) exports: Vec<String>,
}

/// Reads a shared library; several parts only for a universal Mach-O file, none for anything unreadable.
pub(crate) fn read(bytes: &[u8]) -> Vec<Part> {
    match FileKind::parse(bytes) {
        Ok(FileKind::MachOFat32) => {
            MachOFatFile32::parse(bytes).map_or(Vec::new(), |f| fat(f.arches(), bytes))
        }
        Ok(FileKind::MachOFat64) => {
            MachOFatFile64::parse(bytes).map_or(Vec::new(), |f| fat(f.arches(), bytes))
        }
        Ok(FileKind::Elf32 | FileKind::Elf64) => single(bytes, System::Linux),
        Ok(FileKind::Pe32 | FileKind::Pe64) => single(bytes, System::Windows),
        Ok(FileKind::MachO32 | FileKind::MachO64) => single(bytes, System::Darwin),
        _ => Vec::new(),
    }
}

fn fat<A: FatArch>(arches: &[A], bytes: &[u8]) -> Vec<Part> {
    let data = |arch: &A| arch.data(bytes).ok().map(|b: &[u8]| single(b, System::Darwin));
    arches.iter().filter_map(data).flatten().collect()
}

fn single(bytes: &[u8], system: System) -> Vec<Part> {
    let Ok(file) = object::File::parse(bytes) else { return Vec::new() };
    let mut exports: Vec<String> = match system {
        System::Linux => file
            .dynamic_symbols()
            .filter(|s| s.is_definition())
            .filter_map(|s| Some(s.name().ok()?.to_owned()))
            .collect(),
        _ => file
            .exports()
            .unwrap_or_default()
            .iter()
            .map(|e| String::from_utf8_lossy(e.name()).into_owned())
            .collect(),
    };
    if system == System::Darwin {
        // The C compilers of Darwin put an underscore in front; symbol tables serve where there is no export list.
        exports.extend(
            file.symbols()
                .filter(|s| s.is_global() && s.is_definition())
                .filter_map(|s| Some(s.name().ok()?.to_owned())),
        );
        exports = exports.into_iter().map(|n| n.strip_prefix('_').map(str::to_owned).unwrap_or(n)).collect();
    }
    vec![Part { system, architecture: file.architecture(), exports }]
}
