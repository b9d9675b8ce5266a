//! What the split asks of a model, and what it says of a step.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

/// Current, A, and speed, rad/s.
pub type Fast = Vector2<f64>;

/// Interface from a model to the integrator. Times are seconds since the start of the caller's step.
pub trait System<const N: usize> {
    /// What rates, heat and work share at one instant and costs to compute.
    type Instant: Copy;
    /// That of an instant.
    fn instant(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>) -> Self::Instant;
    /// Derivatives of current and speed, A/s and rad/s2, with what is known of the instant.
    fn fast_rates_at(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>, instant: &Self::Instant)
    -> Fast;
    /// Derivatives of current and speed, A/s and rad/s2.
    #[inline]
    fn fast_rates(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>) -> Fast {
        self.fast_rates_at(t, x, temperature, &self.instant(t, x, temperature))
    }
    /// Their Jacobian with respect to (current, speed), 1/s.
    fn fast_matrix(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>) -> Matrix2<f64>;
    /// Derivatives of the temperatures by conduction, convection and radiation alone, K/s, and the heat flow from the nodes
    /// to whatever surrounds them, W.
    fn network(&self, t: f64, temperature: &SVector<f64, N>) -> (SVector<f64, N>, f64);
    /// Derivatives of the temperatures by conduction, convection and radiation alone, K/s.
    #[inline]
    fn network_rates(&self, t: f64, temperature: &SVector<f64, N>) -> SVector<f64, N> {
        self.network(t, temperature).0
    }
    /// Heat flow from the nodes to whatever surrounds them, W.
    #[inline]
    fn outflow(&self, t: f64, temperature: &SVector<f64, N>) -> f64 {
        self.network(t, temperature).1
    }
    /// Their Jacobian, 1/s.
    fn network_matrix(&self, t: f64, temperature: &SVector<f64, N>) -> SMatrix<f64, N, N>;
    /// Heat capacities of the nodes, J/K.
    fn capacity(&self) -> &SVector<f64, N>;
    /// Their reciprocals, K/J.
    fn inverse_capacity(&self) -> &SVector<f64, N>;
    /// Heat set free in each node, W, with what is known of the instant.
    fn heat_rates_at(
        &self,
        t: f64,
        x: &Fast,
        temperature: &SVector<f64, N>,
        instant: &Self::Instant,
    ) -> SVector<f64, N>;
    /// Heat set free in each node at one instant, W.
    #[inline]
    fn heat_rates(&self, t: f64, x: &Fast, temperature: &SVector<f64, N>) -> SVector<f64, N> {
        self.heat_rates_at(t, x, temperature, &self.instant(t, x, temperature))
    }
    /// Energies over one step, from the fast solution's integrals, with what is known of its start, middle and end.
    fn work(&self, segment: &Segment<N>, instants: &[Self::Instant; 3]) -> Work<N>;
    /// True where the fast rates bend on a scale that a stiff block passes within a step, so that the last stage must be
    /// as near as all else.
    fn bends_where_stiff(&self) -> bool;
}

/// The fast solution over one step, and the temperatures under it.
#[derive(Clone, Copy, Debug)]
pub struct Segment<const N: usize> {
    /// Start, s after the start of the caller's step.
    pub t: f64,
    /// Length, s.
    pub h: f64,
    /// Current and speed at the start, the middle and the end.
    pub x: [Fast; 3],
    /// Their integrals, A.s and rad.
    pub integral: Fast,
    /// Integral of the square of the current, A2.s, and how far a coarser rule would miss it where it is not exact.
    pub square: f64,
    /// See [`square`](Segment::square).
    pub error_of_square: f64,
    /// Integrals of (t - start) times current and speed.
    pub moment: Fast,
    /// Temperatures at the start, the middle and the end, K.
    pub temperature: [SVector<f64, N>; 3],
}

/// Energies over one step, J.
#[derive(Clone, Copy, Debug)]
pub struct Work<const N: usize> {
    /// Heat set free in each node.
    pub heat: SVector<f64, N>,
    /// Losses in the winding and by friction.
    pub losses: [f64; 2],
    /// Electrical energy taken at the terminals, and heat put in from outside.
    pub electrical: f64,
    /// Energy delivered at the shaft.
    pub mechanical: f64,
    /// Heat given to ambient without passing a node.
    pub ambient: f64,
    /// Heat set free beyond the nodes.
    pub aside: f64,
    /// How far a coarser rule would miss the energies that are not exact.
    pub quadrature_error: f64,
}
