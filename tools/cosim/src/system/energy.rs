//! The books of the coupling: power that one component gives through a connection against power that the other takes.
//!
//! Two connections in opposite directions between the same two components whose units multiply to watts are a bond:
//! speed one way and torque the other, voltage and current, pressure and flow. Each side computes with its own
//! output as it runs and with the other's signal as it was given, held or on a line. What both get differs, and the
//! difference is energy that the coupling made or lost:
//!
//! ```text
//! side A   E_A = integral of y_A(t) * u_A(t) dt, y_A a line between communication points
//! side B   E_B = integral of y_B(t) * u_B(t) dt
//! error    E_A - E_B
//! ```
use super::units::{unit_of, watts};
use super::wiring::{Parts, Port, Wiring};
use crate::Kind;

/// A pair of connections that carries power, and its books.
#[derive(Clone, Debug, PartialEq)]
pub struct Bond {
    /// The connection one way, `component.output -> component.input`.
    pub forth: String,
    /// The connection back.
    pub back: String,
    /// Energy that went through: the product of both signals, with their signs (J).
    pub energy: f64,
    /// Energy that went through in either direction (J).
    pub throughput: f64,
    /// Energy on the side of `forth`'s source less energy on the other (J).
    pub error: f64,
    /// As `error`, with the amounts of all steps added up, so that nothing cancels (J).
    pub gross_error: f64,
}

impl Bond {
    /// The error as a share of the throughput; 0 if nothing went through.
    pub fn share(&self) -> f64 {
        if self.throughput > 0.0 { self.error.abs() / self.throughput } else { 0.0 }
    }

    /// The gross error as a share of the throughput; 0 if nothing went through.
    pub fn gross_share(&self) -> f64 {
        if self.throughput > 0.0 { self.gross_error / self.throughput } else { 0.0 }
    }
}

/// Where a bond's signals stand: inputs of both connections, and factors to watts.
#[derive(Clone, Copy, Debug)]
struct Ends {
    forth: usize,
    back: usize,
    /// Of the output that goes forth times the input that came back.
    a: f64,
    /// Of the output that goes back times the input that came forth.
    b: f64,
}

/// All bonds of a system.
#[derive(Clone, Debug, Default)]
pub(crate) struct Books {
    ends: Vec<Ends>,
    sources: Vec<usize>,
    pub(crate) bonds: Vec<Bond>,
}

/// What happened in one step.
pub(crate) struct Stepped<'a> {
    pub(crate) h: f64,
    /// Outputs at the beginning and at the end.
    pub(crate) before: &'a [f64],
    pub(crate) after: &'a [f64],
    /// Inputs as they were given: value at the beginning, and slope.
    pub(crate) inputs: &'a [f64],
    pub(crate) slopes: &'a [f64],
}

impl Books {
    pub(crate) fn new(parts: Parts, wiring: &Wiring) -> Self {
        let mut books = Self { sources: wiring.feeds.iter().map(|f| f.source).collect(), ..Self::default() };
        let unit = |port: Port| unit_of(parts.description(port.component), parts.variable(port));
        let real = |port: Port| parts.variable(port).kind == Kind::Float64;
        let name = |feed: usize| {
            let feed = &wiring.feeds[feed];
            format!("{} -> {}", parts.name(wiring.outputs[feed.source]), parts.name(feed.port))
        };
        for (forth, f) in wiring.feeds.iter().enumerate() {
            for (back, g) in wiring.feeds.iter().enumerate().skip(forth + 1) {
                let (y_a, y_b) = (wiring.outputs[f.source], wiring.outputs[g.source]);
                let opposite = y_a.component == g.port.component && y_b.component == f.port.component;
                if !opposite || y_a.component == y_b.component || ![y_a, y_b].into_iter().all(real) {
                    continue;
                }
                let a = watts(unit(y_a).as_ref(), unit(g.port).as_ref());
                let b = watts(unit(y_b).as_ref(), unit(f.port).as_ref());
                let (Some(a), Some(b)) = (a, b) else { continue };
                books.ends.push(Ends { forth, back, a, b });
                books.bonds.push(Bond {
                    forth: name(forth),
                    back: name(back),
                    energy: 0.0,
                    throughput: 0.0,
                    error: 0.0,
                    gross_error: 0.0,
                });
            }
        }
        books
    }

    /// Adds one step.
    pub(crate) fn add(&mut self, s: &Stepped) {
        for (ends, bond) in self.ends.iter().zip(&mut self.bonds) {
            let side = |output: usize, input: usize| {
                let u = s.inputs[input];
                product(s.h, s.before[output], s.after[output], u, u + s.h * s.slopes[input])
            };
            let a = ends.a * side(self.sources[ends.forth], ends.back);
            let b = ends.b * side(self.sources[ends.back], ends.forth);
            bond.energy += 0.5 * (a + b);
            bond.throughput += 0.5 * (a + b).abs();
            bond.error += a - b;
            bond.gross_error += (a - b).abs();
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
