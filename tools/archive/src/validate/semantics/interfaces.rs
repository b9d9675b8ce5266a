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
        out.add(&rules::INTERFACE_MISSING, model.place(model.root), message);
    }
    let mut names = Vec::new();
    for interface in &model.interfaces {
        let (name, place) = (interface.tag_name().name(), model.place(*interface));
        // The schema of FMI 2 allows an interface twice; that of FMI 3 does not.
        if model.version == FmiVersion::V2 && names.contains(&name) {
            out.add(&rules::INTERFACE_REPEATED, &place, format!("<{name}> is present more than once"));
        }
        names.push(name);
        if let Some(identifier) = interface.attribute("modelIdentifier") {
            check_identifier(identifier, name, &place, out);
        }
        let needs = |flag: &str, other: &str, out: &mut Findings| {
            if is_true(*interface, flag) && !is_true(*interface, other) {
                let message = format!("{flag} is true in <{name}>, but {other}, which it requires, is not");
                out.add(&rules::CAPABILITY_REQUIRES, &place, message);
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
            let message =
                format!("fixedInternalStepSize is {step}, but a step must be greater than 0 and finite");
            out.add(&rules::INTERNAL_STEP, &place, message);
        }
    }
}

fn check_identifier(identifier: &str, interface: &str, place: &str, out: &mut Findings) {
    let first_ok = identifier.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !first_ok || !identifier.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        let message =
            format!("The modelIdentifier \"{}\" of <{interface}> is not a C identifier", short(identifier));
        out.add(&rules::MODEL_IDENTIFIER, place, message);
    } else if identifier.len() > LONGEST_IDENTIFIER {
        let message = format!(
            "The modelIdentifier of <{interface}> has {} characters; more than {LONGEST_IDENTIFIER} is not a short class name",
            identifier.len()
        );
        out.add(&rules::MODEL_IDENTIFIER_LONG, place, message);
    }
}
