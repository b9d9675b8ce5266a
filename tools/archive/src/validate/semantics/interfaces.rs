//! Interface types, model identifiers and capability flags.

use super::*;

/// A short class name; longer ones break path limits when the archive is unpacked.
const LONGEST_IDENTIFIER: usize = 64;

pub(super) fn check(model: &Model, out: &mut Findings) {
    if model.interfaces.is_empty() {
        let message = match model.version {
            FmiVersion::V2 => {
                "Neither <ModelExchange> nor <CoSimulation> is present; at least one is required"
            }
            FmiVersion::V3 => {
                "None of <ModelExchange>, <CoSimulation> and <ScheduledExecution> is present; at least one is required"
            }
        };
        out.add(model.place(model.root), rules::INTERFACE_MISSING.says(message));
    }
    let mut names = Vec::new();
    for interface in &model.interfaces {
        let (name, place) = (interface.tag_name().name(), model.place(*interface));
        // The schema of FMI 2 allows an interface twice; that of FMI 3 does not.
        if model.version == FmiVersion::V2 && names.contains(&name) {
            out.add(&place, rules::interface_repeated(name));
        }
        names.push(name);
        if let Some(identifier) = interface.attribute("modelIdentifier") {
            check_identifier(identifier, name, &place, out);
        }
        let needs = |flag: &str, other: &str, out: &mut Findings| {
            if is_true(*interface, flag) && !is_true(*interface, other) {
                out.add(&place, rules::capability_requires(flag, name, other));
            }
        };
        match model.version {
            FmiVersion::V2 => needs("canSerializeFMUstate", "canGetAndSetFMUstate", out),
            FmiVersion::V3 => {
                needs("canSerializeFMUState", "canGetAndSetFMUState", out);
                needs("canReturnEarlyAfterIntermediateUpdate", "providesIntermediateUpdate", out);
            }
        }
        if let Some(step) =
            double(*interface, "fixedInternalStepSize").filter(|s| !(*s > 0.0 && s.is_finite()))
        {
            out.add(&place, rules::internal_step(step));
        }
    }
}

fn check_identifier(identifier: &str, interface: &str, place: &str, out: &mut Findings) {
    let first_ok = identifier.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !first_ok || !identifier.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        out.add(place, rules::model_identifier(short(identifier), interface));
    } else if identifier.len() > LONGEST_IDENTIFIER {
        out.add(place, rules::model_identifier_long(interface, identifier.len(), LONGEST_IDENTIFIER));
    }
}
