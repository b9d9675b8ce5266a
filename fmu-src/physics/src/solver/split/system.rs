//! Interface of a model to the split integrator.

use super::HeatCapacities;
use crate::line::Line;
use crate::solver::phi::product;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

/// Current, A, and speed, rad/s.
pub type Fast = Vector2<f64>;

/// Interface of a model to the integrator. Times are seconds since the start of the communication step.
pub trait System<const N: usize>: Sized {
    /// Intermediate results at one instant, shared by rates, heat and work.
    type Instant: Copy;
    /// Intermediate results at an instant.
    fn instant(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>) -> Self::Instant;
    /// Derivatives of current and speed, A/s and rad/s2, with the intermediate results of the instant.
    fn fast_rates_at(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>, instant: &Self::Instant)
    -> Fast;
    /// Derivatives of current and speed, A/s and rad/s2.
    #[inline(always)]
    fn fast_rates(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>) -> Fast {
        self.fast_rates_at(t, x, temperature, &self.instant(t, x, temperature))
    }
    /// Their Jacobian with respect to (current, speed), 1/s, with the intermediate results of the instant.
    fn fast_matrix_at(
        &self,
        t: f64,
        x: &Fast,
        temperature: &SVector<f64, N>,
        instant: &Self::Instant,
    ) -> Matrix2<f64>;
    /// Their Jacobian with respect to (current, speed), 1/s.
    fn fast_matrix(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>) -> Matrix2<f64> {
        self.fast_matrix_at(t, x, temperature, &self.instant(t, x, temperature))
    }
    /// Derivatives of the temperatures by conduction, convection and radiation only, K/s, and the heat flow out of the nodes
    /// to their environment, W.
    fn network(&self, t: f64, temperature: &SVector<f64, N>) -> (SVector<f64, N>, f64);
    /// Whether the network is linear, with a matrix that is constant over a step.
    const IS_NETWORK_LINEAR: bool = false;
    /// What remains of [`network`](Self::network) without `matrix` and the heat flow of `share`, W/K, out of the nodes; `matrix` is
    /// exact if the network is linear.
    #[inline(always)]
    fn network_remainder(
        &self,
        t: f64,
        temperature: &SVector<f64, N>,
        matrix: &SMatrix<f64, N, N>,
        share: &SVector<f64, N>,
    ) -> (SVector<f64, N>, f64) {
        let (rates, outflow) = self.network(t, temperature);
        (rates - product(matrix, temperature), outflow - share.dot(temperature))
    }
    /// Derivatives of the temperatures by conduction, convection and radiation only, K/s.
    #[inline]
    fn network_rates(&self, t: f64, temperature: &SVector<f64, N>) -> SVector<f64, N> {
        self.network(t, temperature).0
    }
    /// Heat flow out of the nodes to their environment, W.
    #[inline]
    fn outflow(&self, t: f64, temperature: &SVector<f64, N>) -> f64 {
        self.network(t, temperature).1
    }
    /// Their Jacobian, 1/s.
    fn network_matrix(&self, t: f64, temperature: &SVector<f64, N>) -> SMatrix<f64, N, N>;
    /// Heat capacities of the nodes.
    fn capacity(&self) -> &HeatCapacities<N>;
    /// Heat generated in each node, W, with the intermediate results of the instant.
    fn heat_rates_at(
        &self,
        t: f64,
        x: &Fast,
        temperature: &SVector<f64, N>,
        instant: &Self::Instant,
    ) -> SVector<f64, N>;
    /// Heat generated in each node at one instant, W.
    #[inline(always)]
    fn heat_rates(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>) -> SVector<f64, N> {
        self.heat_rates_at(t, x, temperature, &self.instant(t, x, temperature))
    }
    /// Energies over one step, from the fast solution's integrals, with the intermediate results at its start, middle and end.
    fn work(&self, segment: &Segment<N>, instants: &[Self::Instant; 3]) -> Work<N>;
    /// Whether the fast rates are nonlinear within a stiff step, so that the stage error needs the tolerance of the
    /// other errors.
    fn bends_where_stiff(&self) -> bool;
}

/// The fast solution over one step, with the temperatures.
#[derive(Clone, Copy, Debug)]
pub struct Segment<const N: usize> {
    /// Start, s after the start of the communication step.
    pub t: f64,
    /// Length, s.
    pub h: f64,
    /// Current and speed at the start, the middle and the end.
    pub x: [Fast; 3],
    /// Their integrals, A.s and rad.
    pub integral: Fast,
    /// Integral of the square of the current, A2.s, and, where it is not exact, its difference to a coarser rule.
    pub square: f64,
    /// See [`square`](Segment::square).
    pub error_of_square: f64,
    /// Integrals of (t - start) times current and speed.
    pub moment: Fast,
    /// Temperatures at the start, the middle and the end, K.
    pub temperature: [SVector<f64, N>; 3],
}

impl<const N: usize> Segment<N> {
    /// Integral by Simpson's rule of a quantity with these values at the start, the middle and the end.
    #[inline(always)]
    pub fn simpson(&self, f: [f64; 3]) -> f64 {
        self.h / 6.0 * (f[0] + 4.0 * f[1] + f[2])
    }

    /// Integral of f times current (`k` = 0) or speed (1): the end value of f times the exact integral, plus Simpson's rule for the
    /// deviation of f from its end value. Second result: the error that the trapezoidal rule would have.
    #[inline(always)]
    pub fn against(&self, f: [f64; 3], k: usize) -> (f64, f64) {
        let beyond = |n: usize| (f[n] - f[2]) * self.x[n][k];
        let start = beyond(0);
        let extra = self.simpson([start, beyond(1), 0.0]);
        (f[2] * self.integral[k] + extra, (extra - 0.5 * self.h * start).abs())
    }

    /// Integral of a linear function times current (`k` = 0) or speed (1): start value by the integral, derivative by the moment.
    #[inline(always)]
    pub fn against_line(&self, line: &Line, k: usize) -> f64 {
        line.at(self.t) * self.integral[k] + line.slope * self.moment[k]
    }
}

/// Energies over one step, J.
#[derive(Clone, Copy, Debug)]
pub struct Work<const N: usize> {
    /// Heat generated in each node.
    pub heat: SVector<f64, N>,
    /// Losses in the winding and by friction.
    pub losses: [f64; 2],
    /// Electrical energy at the terminals, and external heat input.
    pub electrical: f64,
    /// Energy at the shaft.
    pub mechanical: f64,
    /// Heat to ambient that does not pass a node.
    pub ambient: f64,
    /// Heat generated outside the nodes.
    pub aside: f64,
    /// Difference to a coarser rule of the energies that are not exact.
    pub quadrature_error: f64,
}
