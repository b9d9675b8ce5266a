//! Variables whose best value is an end of their range.

use super::{Case, Choice, Point, Vary};
use serde::Serialize;

/// Objectives that differ by a smaller fraction are equal.
const EQUAL: f64 = 1e-9;

/// A variable whose best value is the first or the last of its range: the optimum may lie outside.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Edge {
    /// The variable.
    pub name: String,
    /// Its value at the best point.
    pub value: f64,
    /// Whether that is the lower or the upper end of the range.
    pub end: &'static str,
}

/// The variables that are at an end of their range, behind which more values are possible.
pub fn edges(case: &dyn Case, vary: &[Vary], at: &[Choice]) -> Vec<Edge> {
    let edge = |(v, value): (&Vary, &Choice)| {
        let (numbers, value) = (v.numbers()?, value.number()?);
        let (least, most) =
            numbers.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), x| (l.min(*x), m.max(*x)));
        let end = match value {
            _ if least == most => return None,
            value if value == least => "lower",
            value if value == most => "upper",
            _ => return None,
        };
        if case.limits(&v.name).is_some_and(|(low, high)| value <= low || value >= high) {
            return None;
        }
        Some(Edge { name: v.name.clone(), value, end })
    };
    vary.iter().zip(at).filter_map(edge).collect()
}

/// The edges of the best point; none where all points are equally good.
pub(super) fn open_edges(case: &dyn Case, vary: &[Vary], best: &Point, points: &[Point]) -> Vec<Edge> {
    let values: Vec<f64> = points.iter().filter_map(|p| p.objective).collect();
    let is_equal = |v: &f64| values.iter().all(|w| (v - w).abs() <= EQUAL * v.abs().max(w.abs()));
    if values.len() > 1 && values.first().is_some_and(is_equal) {
        return Vec::new();
    }
    edges(case, vary, &best.values)
}
