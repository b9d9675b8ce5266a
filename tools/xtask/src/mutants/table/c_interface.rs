//! The C interface.

use super::super::Mutant;

const fn mutant(
    name: &'static str,
    file: &'static str,
    text: &'static str,
    replacement: &'static str,
    breaks: &'static str,
) -> Mutant {
    Mutant { name, noticed_by: &["fmu"], file, text, replacement, breaks }
}

/// All of them.
pub const MUTANTS: &[Mutant] = &[
    mutant(
        "fmu-plain-set-unchecked",
        "fmu-src/fmu/src/instance/values.rs",
        "place.takes(value(k))",
        "true",
        "a value out of range is accepted after the first call",
    ),
    mutant(
        "fmu-wrong-element",
        "fmu-src/fmu/src/instance/values.rs",
        "entry.slot.row + k as u16",
        "entry.slot.row",
        "an array repeats its first element",
    ),
    mutant(
        "fmu-set-when-fixed",
        "fmu-src/fmu/src/instance/values.rs",
        "!matches!(self.mode, Mode::Instantiated | Mode::Configuration | Mode::Initialization)",
        "false",
        "a fixed parameter can be set while the model runs",
    ),
    mutant(
        "fmu-refused-set-applies",
        "fmu-src/fmu/src/instance/values.rs",
        "if k < n { value(k) } else { f64::NAN }",
        "0.0",
        "a value that is no number is accepted",
    ),
    mutant(
        "fmu-slope-order",
        "fmu-src/fmu/src/instance/values.rs",
        "orders.iter().all(|&order| order == 1)",
        "true",
        "a derivative of any order is taken as a slope",
    ),
    mutant(
        "fmu-event-missed",
        "fmu-src/fmu/src/instance/stepping.rs",
        "due || new || (ahead && timed <= at + way + IMMINENT)",
        "due || new",
        "an event whose time is known is not reported",
    ),
    mutant(
        "fmu-find-upper",
        "fmu-src/fmu/src/instance/stepping.rs",
        "0.5 * (low + high)",
        "0.75 * high + 0.25 * low",
        "an event found by unequal parts",
    ),
    mutant(
        "fmu-early-return",
        "fmu-src/fmu/src/instance/stepping.rs",
        "course.end.min(until)",
        "course.end",
        "a step does not return early",
    ),
    mutant(
        "fmu-adjoint",
        "fmu-src/fmu/src/instance/slopes.rs",
        "slopes.iter().zip(seed).map(|(slope, seed)| slope * seed).sum()",
        "slopes.iter().sum()",
        "an adjoint derivative without its seeds",
    ),
    mutant(
        "fmu-directional-restart",
        "fmu-src/fmu/src/instance/slopes.rs",
        "(self.mode == Mode::Initialization).then_some(self.window.0)",
        "None",
        "derivatives of initialization hold the states",
    ),
];
