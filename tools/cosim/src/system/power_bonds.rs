//! Power bonds: the energy that one component transmits through connections against the energy that the other receives.
//!
//! Two connections in opposite directions between the same two components whose units multiply to watts are a power
//! bond: speed and torque, voltage and current, pressure and volume flow. Each side computes with its own output as it
//! varies in the step and with the other's signal as it is set, constant or linear. The difference of the two energies is
//! the coupling energy residual:
//!
//! ```text
//! side A   E_A = integral of y_A(t) * u_A(t) dt, y_A a line between communication points
//! side B   E_B = integral of y_B(t) * u_B(t) dt
//! residual E_A - E_B
//! ```
use super::connections::Connections;
use super::parts::{Parts, Port};
use super::units::{unit_of, watts};
use crate::Kind;

/// A pair of connections that carries power, with its energies.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerBond {
    /// The connection one way, `component.output -> component.input`.
    pub forth: String,
    /// The connection back.
    pub back: String,
    /// Transmitted energy: the integral of the product of both signals, with sign (J).
    pub energy: f64,
    /// Energy transmitted in either direction (J).
    pub throughput: f64,
    /// Coupling energy residual: energy on the side of `forth`'s source less energy on the other (J).
    pub residual: f64,
    /// Sum of the magnitudes of the residuals of all steps, so that nothing cancels (J).
    pub gross_residual: f64,
}

impl PowerBond {
    /// The residual over the throughput; 0 if no energy was transmitted.
    pub fn relative_residual(&self) -> f64 {
        if self.throughput > 0.0 { self.residual.abs() / self.throughput } else { 0.0 }
    }

    /// The gross residual over the throughput; 0 if no energy was transmitted.
    pub fn relative_gross_residual(&self) -> f64 {
        if self.throughput > 0.0 { self.gross_residual / self.throughput } else { 0.0 }
    }
}

/// The inputs of both connections of a power bond, and factors to watts.
#[derive(Clone, Copy, Debug)]
struct Ends {
    forth: usize,
    back: usize,
    /// Of the output of `forth` times the input of `back`.
    a: f64,
    /// Of the output of `back` times the input of `forth`.
    b: f64,
}

/// All power bonds of a system.
#[derive(Clone, Debug, Default)]
pub(crate) struct PowerBonds {
    ends: Vec<Ends>,
    sources: Vec<usize>,
    pub(crate) bonds: Vec<PowerBond>,
}

/// The signals of one step.
pub(crate) struct Stepped<'a> {
    pub(crate) h: f64,
    /// Outputs at the beginning and at the end.
    pub(crate) before: &'a [f64],
    pub(crate) after: &'a [f64],
    /// Inputs as they were set: value at the beginning, and derivative.
    pub(crate) inputs: &'a [f64],
    pub(crate) derivatives: &'a [f64],
}

impl PowerBonds {
    pub(crate) fn new(parts: Parts, connections: &Connections) -> Self {
        let mut bonds =
            Self { sources: connections.inputs.iter().map(|f| f.source).collect(), ..Self::default() };
        let unit = |port: Port| unit_of(parts.description(port.component), parts.variable(port));
        let real = |port: Port| parts.variable(port).kind == Kind::Float64;
        let name = |input: usize| {
            let input = &connections.inputs[input];
            format!("{} -> {}", parts.name(connections.outputs[input.source]), parts.name(input.port))
        };
        for (forth, f) in connections.inputs.iter().enumerate() {
            for (back, g) in connections.inputs.iter().enumerate().skip(forth + 1) {
                let (y_a, y_b) = (connections.outputs[f.source], connections.outputs[g.source]);
                let opposite = y_a.component == g.port.component && y_b.component == f.port.component;
                if !opposite || y_a.component == y_b.component || ![y_a, y_b].into_iter().all(real) {
                    continue;
                }
                let a = watts(unit(y_a).as_ref(), unit(g.port).as_ref());
                let b = watts(unit(y_b).as_ref(), unit(f.port).as_ref());
                let (Some(a), Some(b)) = (a, b) else { continue };
                bonds.ends.push(Ends { forth, back, a, b });
                bonds.bonds.push(PowerBond {
                    forth: name(forth),
                    back: name(back),
                    energy: 0.0,
                    throughput: 0.0,
                    residual: 0.0,
                    gross_residual: 0.0,
                });
            }
        }
        bonds
    }

    pub(crate) fn add(&mut self, s: &Stepped) {
        for (ends, bond) in self.ends.iter().zip(&mut self.bonds) {
            let side = |output: usize, input: usize| {
                let u = s.inputs[input];
                product(s.h, s.before[output], s.after[output], u, u + s.h * s.derivatives[input])
            };
            let a = ends.a * side(self.sources[ends.forth], ends.back);
            let b = ends.b * side(self.sources[ends.back], ends.forth);
            bond.energy += 0.5 * (a + b);
            bond.throughput += 0.5 * (a + b).abs();
            bond.residual += a - b;
            bond.gross_residual += (a - b).abs();
        }
    }
}

/// The integral over `h` of the product of two lines.
fn product(h: f64, a0: f64, a1: f64, b0: f64, b1: f64) -> f64 {
    h / 6.0 * (2.0 * a0 * b0 + a0 * b1 + a1 * b0 + 2.0 * a1 * b1)
}

#[cfg(test)]
mod tests {
    use super::product;

    #[test]
    fn products_of_lines_are_exact() {
        // (1 + 2 t) (3 - t) from 0 to 2: 3 t + 5/2 t^2 - 2/3 t^3.
        let exact = 6.0 + 10.0 - 16.0 / 3.0;
        assert!((product(2.0, 1.0, 5.0, 3.0, 1.0) - exact).abs() < 1e-14);
        assert_eq!(product(0.5, 4.0, 4.0, 3.0, 3.0), 6.0);
    }
}
