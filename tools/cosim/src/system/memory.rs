//! What the master knows at a communication point.
use super::batch::Signals;
use super::power_bonds::PowerBonds;
use super::units::Affine;
use crate::Instance;

/// State of the master, in addition to the states of the FMUs.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    /// The communication point (s).
    pub(super) time: f64,
    /// Connected outputs now.
    pub(super) outputs: Vec<f64>,
    /// Those of integers without rounding.
    pub(super) integers: Vec<i128>,
    /// Connected inputs now, in the units of the inputs.
    pub(super) inputs: Vec<f64>,
    /// Inputs one step ago, and the length of that step; 0 before the first.
    pub(super) earlier: Vec<f64>,
    pub(super) last_step: f64,
    pub(super) bonds: PowerBonds,
}

impl Memory {
    /// As `clone_from`, without allocation.
    pub(super) fn copy(&mut self, other: &Self) {
        self.outputs.copy_from_slice(&other.outputs);
        self.integers.copy_from_slice(&other.integers);
        self.inputs.copy_from_slice(&other.inputs);
        self.earlier.copy_from_slice(&other.earlier);
        (self.time, self.last_step) = (other.time, other.last_step);
        for (own, bond) in self.bonds.bonds.iter_mut().zip(&other.bonds.bonds) {
            (own.energy, own.throughput) = (bond.energy, bond.throughput);
            (own.residual, own.gross_residual) = (bond.residual, bond.gross_residual);
        }
    }

    /// The values together with the instances and the sources of the inputs.
    pub(super) fn signals<'a>(
        &'a mut self,
        instances: &'a mut [Instance],
        sources: &'a [(usize, Affine)],
    ) -> Signals<'a> {
        let Self { outputs, integers, inputs, .. } = self;
        Signals { instances, outputs, integers, inputs, sources }
    }
}
