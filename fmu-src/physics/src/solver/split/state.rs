//! State between steps, and the integrals over a step.

use super::Fast;
use nalgebra::SVector;
use std::ops::AddAssign;

/// State between steps. `E` is the number of energies, at least three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize, const E: usize = 3> {
    /// Current, A, and speed, rad/s.
    pub x: Fast,
    /// Shaft angle, rad.
    pub angle: f64,
    /// Node temperatures, K.
    pub temperature: SVector<f64, N>,
    /// Energy input, energy at the shaft, and heat to ambient since the start, J; then, depending on
    /// `E`, the losses in the winding and by friction.
    pub energy: [f64; E],
    /// Integrals over the last call to [`super::Split::advance`], for states other than the nodes.
    pub integrals: StepIntegrals<N>,
}

impl<const N: usize, const E: usize> Default for State<N, E> {
    fn default() -> Self {
        State {
            x: Fast::zeros(),
            angle: 0.0,
            temperature: SVector::zeros(),
            energy: [0.0; E],
            integrals: StepIntegrals::default(),
        }
    }
}

impl<const N: usize, const E: usize> State<N, E> {
    /// Current, speed and temperatures in the middle of the last call, over `h` seconds, in which each was a parabola with the mean that the
    /// integrator found; `from` is the state at the start. The rest is that of the end.
    pub fn middle(&self, from: &Self, h: f64) -> Self {
        let (x, temperature) = (&self.integrals.fast, &self.integrals.temperature);
        State {
            x: middle_of(from.x, *x, self.x, h),
            temperature: middle_of(from.temperature, *temperature, self.temperature, h),
            ..*self
        }
    }
}

/// Middle value of a parabola between two values with this integral over `h` seconds.
pub fn middle_of<T>(from: T, integral: T, to: T, h: f64) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::ops::Div<f64, Output = T> + std::ops::Sub<Output = T>,
{
    (integral * 6.0 / h - from - to) * 0.25
}

/// Integrals over one call to [`super::Split::advance`]; the next call does not depend on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepIntegrals<const N: usize> {
    /// Integrals of current, A.s, and speed, rad.
    pub fast: Fast,
    /// Integrals of the node temperatures over time, K.s.
    pub temperature: SVector<f64, N>,
    /// Heat of the work outside the nodes, J ([`super::Work::aside`]).
    pub aside: f64,
    /// Heat flow out of the nodes, integrated, J.
    pub outflow: f64,
}

impl<const N: usize> Default for StepIntegrals<N> {
    fn default() -> Self {
        StepIntegrals { fast: Fast::zeros(), temperature: SVector::zeros(), aside: 0.0, outflow: 0.0 }
    }
}

impl<const N: usize> StepIntegrals<N> {
    /// Those of current and speed, and of the temperatures of winding and housing, the first two nodes.
    pub fn of_drivers(&self) -> [f64; 4] {
        [self.fast[0], self.fast[1], self.temperature[0], self.temperature[1]]
    }
}

impl<const N: usize> AddAssign for StepIntegrals<N> {
    fn add_assign(&mut self, before: Self) {
        self.fast += before.fast;
        self.temperature += before.temperature;
        self.aside += before.aside;
        self.outflow += before.outflow;
    }
}

impl<const N: usize, const E: usize> State<N, E> {
    /// The state as numbers, for a saved instance.
    pub fn to_numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let fast = [self.x[0], self.x[1], self.angle];
        fast.into_iter().chain(self.temperature.iter().copied()).chain(self.energy)
    }
}

crate::saved!(State<const N: usize, const E: usize> { x, angle, temperature, energy });
