//! Fan curve: pressure as a function of flow, and the operating point in a system.
//!
//! p(Q) = n^2 rho/rho_ref p_0(Q/n)                                                          (1)
//! p_0(q) = p_max (1 - q/q_max), or a table, linear between its points                      (2)
//! stall: p_0(q) times 1 - depth exp(-((q/q_max - centre)/width)^2)                         (3)
//! operating point: p(Q) = p_system(Q)                                                      (4)
//!
//! n is the speed over that of the data sheet, rho_ref the density there. Power scales with n^3 rho/rho_ref.
//! *Assumes* the affinity laws (efficiency and curve do not change with Reynolds number).
//! *Neglects* hysteresis of the stall. If only the end points of (2) are known, the straight line is an
//! estimate with an error of about 20 % in flow for a small axial fan.
//! *Sign*: Q > 0 in the direction of the fan, p > 0 against it.
//! *Range*: any flow. Outside its end points the curve is extrapolated linearly: p < 0 above q_max (external
//! flow through the fan), p > p_max for Q < 0. n below 1e-6 is set to 0: no pressure. With (3) a curve may rise; of several operating
//! points (4) uses the one with the largest flow, which a fan reaches when it starts unloaded.
//! *Source*: (1) Eck, Fans (1973), ch. 1, or ASHRAE Handbook, HVAC Systems and Equipment, ch. Fans; (2) end
//! points of 40x40x10 fans: data sheet CUI CFM-40V; stall at 30 to 60 % of the free flow is usual for axial
//! fans; (3) the project's own form.

use crate::root::try_root_between;
use std::convert::Infallible;
use std::fmt;

/// Stall dip, eq. (3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stall {
    /// Fraction of the pressure that is lost in the middle of the dip, 0 to 1
    pub depth: f64,
    /// Flow in the middle of the dip over q_max
    pub centre: f64,
    /// Half-width of the dip over q_max; at least 1e-3
    pub width: f64,
}

/// The data sheet's curve p_0(q): flow in m3/s, pressure in Pa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape<'a> {
    /// Free flow and shut-off pressure
    EndPoints {
        /// Flow without pressure, m3/s
        flow_max: f64,
        /// Pressure without flow, Pa
        pressure_max: f64,
    },
    /// Points of a measured curve, flows rising, pressures falling
    Table {
        /// Flows, m3/s
        flow: &'a [f64],
        /// Pressures, Pa
        pressure: &'a [f64],
    },
}

/// Why a curve is invalid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CurveError {
    /// Fewer than two points or two columns that differ in length: flows, pressures
    Points(usize, usize),
    /// A number is not finite, or an end point is not positive: name, value
    Number(&'static str, f64),
    /// The flow does not rise after this point: its number from 1, flow, next flow
    FlowNotRising(usize, f64, f64),
    /// The pressure does not fall after this point: its number from 1, pressure, next pressure
    NotFalling(usize, f64, f64),
    /// The table does not reach zero flow and zero pressure: first flow, last pressure
    Ends(f64, f64),
}

impl fmt::Display for CurveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Points(q, p) => {
                write!(
                    f,
                    "the fan curve has {q} flows and {p} pressures; it needs two or more of each, as many"
                )
            }
            Self::Number(name, value) => {
                write!(f, "the fan curve's {name} is {value}; it must be finite and positive")
            }
            Self::FlowNotRising(k, a, b) => {
                write!(
                    f,
                    "the fan curve's flow must rise from point to point, but point {k} has {a} m3/s and the next {b} m3/s"
                )
            }
            Self::NotFalling(k, a, b) => {
                write!(
                    f,
                    "the fan curve must fall, but its pressure goes from {a} Pa at point {k} to {b} Pa at the next"
                )
            }
            Self::Ends(q, p) => {
                write!(
                    f,
                    "the fan curve must start at zero flow and end at zero pressure, but starts at {q} m3/s and ends at {p} Pa"
                )
            }
        }
    }
}

impl std::error::Error for CurveError {}

/// A fan's curve at the speed and density of its data sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FanCurve<'a> {
    shape: Shape<'a>,
    stall: Option<Stall>,
}

impl<'a> FanCurve<'a> {
    /// The curve, if it falls from positive pressure at zero flow to zero pressure at positive flow.
    pub fn new(shape: Shape<'a>, stall: Option<Stall>) -> Result<Self, CurveError> {
        let positive = |name, value: f64| {
            if value.is_finite() && value > 0.0 { Ok(()) } else { Err(CurveError::Number(name, value)) }
        };
        match shape {
            Shape::EndPoints { flow_max, pressure_max } => {
                positive("free flow", flow_max)?;
                positive("shut-off pressure", pressure_max)?;
            }
            Shape::Table { flow, pressure } => check_table(flow, pressure)?,
        }
        if let Some(s) = stall {
            for (name, value) in
                [("stall depth", s.depth), ("stall centre", s.centre), ("stall width", s.width)]
            {
                if !value.is_finite() || value < 0.0 {
                    return Err(CurveError::Number(name, value));
                }
            }
        }
        Ok(Self { shape, stall })
    }

    /// Flow without pressure at the data sheet's speed, m3/s.
    #[inline]
    pub fn free_flow(&self) -> f64 {
        match self.shape {
            Shape::EndPoints { flow_max, .. } => flow_max,
            Shape::Table { flow, .. } => flow.last().copied().unwrap_or(0.0),
        }
    }

    /// p_0 of eqs. (2) and (3), Pa, at the flow `q` in m3/s.
    #[inline]
    fn reference(&self, q: f64) -> f64 {
        let base = match self.shape {
            Shape::EndPoints { flow_max, pressure_max } => pressure_max * (1.0 - q / flow_max),
            Shape::Table { flow, pressure } => interpolated(flow, pressure, q),
        };
        match self.stall {
            None => base,
            Some(s) => {
                let z = (q / self.free_flow() - s.centre) / s.width.max(1e-3);
                base * (1.0 - s.depth.min(1.0) * (-z * z).exp())
            }
        }
    }

    /// Pressure in Pa at the flow `q` in m3/s, the speed ratio `n` and the ratio of densities
    /// `rho_ratio` = rho/rho_ref, eq. (1).
    #[inline]
    pub fn pressure(&self, q: f64, n: f64, rho_ratio: f64) -> f64 {
        if n < 1e-6 {
            return 0.0;
        }
        let n = n.min(1e3);
        n * n * rho_ratio.clamp(0.0, 1e3) * self.reference(q.clamp(-1e6, 1e6) / n)
    }

    /// Operating flow of the fan with `system`, m3/s, eq. (4). `system` gives the pressure drop in Pa at a flow in m3/s: 0 or less at
    /// zero flow, rising. A system that drives the fan (negative pressure drop) gives a flow above the free flow. A fan at rest
    /// has no pressure drop.
    pub fn operating_flow(&self, n: f64, rho_ratio: f64, system: impl Fn(f64) -> f64) -> f64 {
        self.operating_flow_with_leak(n, rho_ratio, |q| (system(q), 0.0), None)
    }

    /// As [`operating_flow`](Self::operating_flow), with a leak between fan and system: `system` gives the pressure drop at
    /// a flow, and the leak flow at this pressure, m3/s, rising too. Returns the flow through the system. `near` is the operating flow
    /// of a similar system: it saves evaluations.
    pub fn operating_flow_with_leak(
        &self,
        n: f64,
        rho_ratio: f64,
        system: impl Fn(f64) -> (f64, f64),
        near: Option<f64>,
    ) -> f64 {
        if rho_ratio <= 0.0 {
            return 0.0;
        }
        let free = self.free_flow() * n.clamp(0.0, 1e3);
        let surplus = |q: f64| {
            let (taken, leak) = system(q);
            self.pressure(q + leak, n, rho_ratio) - taken
        };
        let (low, high) = match near.filter(|_| self.stall.is_none()).and_then(|q| around(q, surplus)) {
            Some(bracket) => bracket,
            None => self.bracket(free, surplus),
        };
        if low.1 <= 0.0 || low.1.is_nan() {
            return low.0;
        }
        let Ok(flow) =
            try_root_between::<Infallible>(|q| Ok(surplus(q)), low, high, ACCURACY * high.0.max(free));
        flow.unwrap_or(0.5 * (low.0 + high.0))
    }

    /// Two flows, with their surplus of pressure, between which the operating point is.
    fn bracket(&self, free: f64, surplus: impl Fn(f64) -> f64) -> ((f64, f64), (f64, f64)) {
        let at = |q: f64| (q, surplus(q));
        let mut high = at(free);
        if high.1 > 0.0 {
            // Above the free flow: growing steps, the first a thousandth of the free flow at full speed.
            let (mut low, mut way) = (high, 1e-3 * self.free_flow());
            for _ in 0..50 {
                (low, high) = (high, at(high.0 + way));
                way *= 2.0;
                if high.1 <= 0.0 {
                    break;
                }
            }
            return (low, high);
        }
        if high.1 < 0.0 && self.stall.is_some() {
            // From the free flow downward, to find the operating point with the largest flow.
            const PARTS: i32 = 64;
            for k in (0..PARTS).rev() {
                let next = at(free * f64::from(k) / f64::from(PARTS));
                if next.1 >= 0.0 || k == 0 {
                    return (next, high);
                }
                high = next;
            }
        }
        (at(0.0), high)
    }
}

/// Accuracy of an operating flow as a fraction of the free flow or, if it is above, of the operating flow.
const ACCURACY: f64 = 1e-13;
/// Change of an operating flow between similar systems, as a fraction.
const SIMILAR: f64 = 0.01;

/// The flow `q` and one that differs by [`SIMILAR`], with their surplus of pressure, if the operating point is between them.
fn around(q: f64, surplus: impl Fn(f64) -> f64) -> Option<((f64, f64), (f64, f64))> {
    let here = (q, surplus(q));
    let other = q * if here.1 > 0.0 { 1.0 + SIMILAR } else { 1.0 - SIMILAR };
    let there = (other, surplus(other));
    let (low, high) = if here.1 > 0.0 { (here, there) } else { (there, here) };
    (low.1 > 0.0 && high.1 <= 0.0).then_some((low, high))
}

fn check_table(flow: &[f64], pressure: &[f64]) -> Result<(), CurveError> {
    if flow.len() < 2 || flow.len() != pressure.len() {
        return Err(CurveError::Points(flow.len(), pressure.len()));
    }
    for (name, column) in [("flow", flow), ("pressure", pressure)] {
        if let Some(&bad) = column.iter().find(|v| !v.is_finite() || **v < 0.0) {
            return Err(CurveError::Number(name, bad));
        }
    }
    for (k, q) in flow.windows(2).enumerate() {
        if q[1] <= q[0] {
            return Err(CurveError::FlowNotRising(k + 1, q[0], q[1]));
        }
    }
    for (k, p) in pressure.windows(2).enumerate() {
        if p[1] >= p[0] {
            return Err(CurveError::NotFalling(k + 1, p[0], p[1]));
        }
    }
    let (first, last) = (flow[0], pressure[pressure.len() - 1]);
    if first != 0.0 || last != 0.0 { Err(CurveError::Ends(first, last)) } else { Ok(()) }
}

/// Linear between the points of a checked table, and extrapolated linearly.
#[inline]
fn interpolated(flow: &[f64], pressure: &[f64], q: f64) -> f64 {
    let last = flow.len() - 2;
    let k = flow[1..=last].partition_point(|&x| x < q);
    let slope = (pressure[k + 1] - pressure[k]) / (flow[k + 1] - flow[k]);
    pressure[k] + slope * (q - flow[k])
}

#[cfg(test)]
#[path = "fan_curve_tests.rs"]
mod tests;
