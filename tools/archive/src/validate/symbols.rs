//! The functions that a binary must export (`fmi2Functions.h`, `fmi3Functions.h`), and what it does export.

use object::read::macho::{FatArch, MachOFatFile32, MachOFatFile64};
use object::{Architecture, FileKind, Object, ObjectSymbol};

use super::model::{FmiVersion, Model};

const FMI2_COMMON: &[&str] = &[
    "GetTypesPlatform",
    "GetVersion",
    "SetDebugLogging",
    "Instantiate",
    "FreeInstance",
    "SetupExperiment",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "Terminate",
    "Reset",
    "GetReal",
    "GetInteger",
    "GetBoolean",
    "GetString",
    "SetReal",
    "SetInteger",
    "SetBoolean",
    "SetString",
    "GetFMUstate",
    "SetFMUstate",
    "FreeFMUstate",
    "SerializedFMUstateSize",
    "SerializeFMUstate",
    "DeSerializeFMUstate",
    "GetDirectionalDerivative",
];
const FMI2_MODEL_EXCHANGE: &[&str] = &[
    "EnterEventMode",
    "NewDiscreteStates",
    "EnterContinuousTimeMode",
    "CompletedIntegratorStep",
    "SetTime",
    "SetContinuousStates",
    "GetDerivatives",
    "GetEventIndicators",
    "GetContinuousStates",
    "GetNominalsOfContinuousStates",
];
const FMI2_CO_SIMULATION: &[&str] = &[
    "SetRealInputDerivatives",
    "GetRealOutputDerivatives",
    "DoStep",
    "CancelStep",
    "GetStatus",
    "GetRealStatus",
    "GetIntegerStatus",
    "GetBooleanStatus",
    "GetStringStatus",
];
const FMI3: &[&str] = &[
    "GetVersion",
    "SetDebugLogging",
    "InstantiateModelExchange",
    "InstantiateCoSimulation",
    "InstantiateScheduledExecution",
    "FreeInstance",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "EnterEventMode",
    "Terminate",
    "Reset",
    "GetFloat32",
    "GetFloat64",
    "GetInt8",
    "GetUInt8",
    "GetInt16",
    "GetUInt16",
    "GetInt32",
    "GetUInt32",
    "GetInt64",
    "GetUInt64",
    "GetBoolean",
    "GetString",
    "GetBinary",
    "GetClock",
    "SetFloat32",
    "SetFloat64",
    "SetInt8",
    "SetUInt8",
    "SetInt16",
    "SetUInt16",
    "SetInt32",
    "SetUInt32",
    "SetInt64",
    "SetUInt64",
    "SetBoolean",
    "SetString",
    "SetBinary",
    "SetClock",
    "GetNumberOfVariableDependencies",
    "GetVariableDependencies",
    "GetFMUState",
    "SetFMUState",
    "FreeFMUState",
    "SerializedFMUStateSize",
    "SerializeFMUState",
    "DeserializeFMUState",
    "GetDirectionalDerivative",
    "GetAdjointDerivative",
    "EnterConfigurationMode",
    "ExitConfigurationMode",
    "GetIntervalDecimal",
    "GetIntervalFraction",
    "GetShiftDecimal",
    "GetShiftFraction",
    "SetIntervalDecimal",
    "SetIntervalFraction",
    "SetShiftDecimal",
    "SetShiftFraction",
    "EvaluateDiscreteStates",
    "UpdateDiscreteStates",
    "EnterContinuousTimeMode",
    "CompletedIntegratorStep",
    "SetTime",
    "SetContinuousStates",
    "GetContinuousStateDerivatives",
    "GetEventIndicators",
    "GetContinuousStates",
    "GetNominalsOfContinuousStates",
    "GetNumberOfEventIndicators",
    "GetNumberOfContinuousStates",
    "EnterStepMode",
    "GetOutputDerivatives",
    "DoStep",
    "ActivateModelPartition",
];

/// The names that the binary called `identifier` must export.
pub(crate) fn required(model: &Model, identifier: &str) -> Vec<String> {
    let lists: Vec<&[&str]> = match model.version {
        FmiVersion::V3 => vec![FMI3],
        FmiVersion::V2 => {
            let is_for = |interface: &str| {
                model
                    .interfaces
                    .iter()
                    .any(|i| i.has_tag_name(interface) && i.attribute("modelIdentifier") == Some(identifier))
            };
            let mut lists = vec![FMI2_COMMON];
            if is_for("ModelExchange") {
                lists.push(FMI2_MODEL_EXCHANGE);
            }
            if is_for("CoSimulation") {
                lists.push(FMI2_CO_SIMULATION);
            }
            lists
        }
    };
    let prefix = if model.version == FmiVersion::V2 { "fmi2" } else { "fmi3" };
    lists.concat().into_iter().map(|name| format!("{prefix}{name}")).collect()
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
