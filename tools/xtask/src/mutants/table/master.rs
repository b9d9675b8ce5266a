//! The co-simulation master.

use super::super::Mutant;

const fn mutant(
    name: &'static str,
    file: &'static str,
    text: &'static str,
    replacement: &'static str,
    breaks: &'static str,
) -> Mutant {
    Mutant { name, noticed_by: &["cosim"], file, text, replacement, breaks }
}

/// All of them.
pub const MUTANTS: &[Mutant] = &[
    mutant(
        "master-extrapolation",
        "tools/cosim/src/system/bus.rs",
        "(inputs[slot] - earlier[slot]) / last_step",
        "(earlier[slot] - inputs[slot]) / last_step",
        "inputs are extrapolated backwards",
    ),
    mutant(
        "master-turn-slope",
        "tools/cosim/src/system/bus.rs",
        "(end - inputs[slot]) / h",
        "0.0 * (end - inputs[slot]) / h",
        "Gauss-Seidel without slopes",
    ),
    mutant(
        "master-books-before-slope",
        "tools/cosim/src/system/energy.rs",
        "u + s.h * s.slopes[input]",
        "u",
        "energy of a connection from held inputs",
    ),
    mutant(
        "master-product",
        "tools/cosim/src/system/energy.rs",
        "2.0 * a0 * b0 + a0 * b1 + a1 * b0 + 2.0 * a1 * b1",
        "3.0 * a0 * b0 + 3.0 * a1 * b1",
        "energy of a connection by the trapezoidal rule",
    ),
    mutant(
        "master-throughput",
        "tools/cosim/src/system/energy.rs",
        "(a - b).abs()",
        "(a - b)",
        "gross errors of energy cancel",
    ),
    mutant(
        "master-order",
        "tools/cosim/src/system/order.rs",
        "read[self.wiring.feeds[*i].source] + 1",
        "read[self.wiring.feeds[*i].source]",
        "outputs are read before the inputs that they depend on",
    ),
    mutant(
        "master-components",
        "tools/cosim/src/system/order.rs",
        "waits_for(*c).all(|s| s == *c || order.contains(&s))",
        "true",
        "components in the order of the file",
    ),
];
