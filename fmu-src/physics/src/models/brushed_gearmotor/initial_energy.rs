//! What the energy balance starts from.

/// Stored energies from which the energy balance counts, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InitialEnergy {
    /// Energy in all stores.
    pub stored: f64,
    /// Energy in the magnetic field.
    pub magnetic: f64,
    /// Energy of the motion.
    pub kinetic: f64,
}

crate::saved!(InitialEnergy { stored, magnetic, kinetic });

impl std::ops::Add for InitialEnergy {
    type Output = InitialEnergy;
    fn add(self, other: InitialEnergy) -> InitialEnergy {
        InitialEnergy {
            stored: self.stored + other.stored,
            magnetic: self.magnetic + other.magnetic,
            kinetic: self.kinetic + other.kinetic,
        }
    }
}

impl std::ops::Sub for InitialEnergy {
    type Output = InitialEnergy;
    fn sub(self, other: InitialEnergy) -> InitialEnergy {
        self + InitialEnergy { stored: -other.stored, magnetic: -other.magnetic, kinetic: -other.kinetic }
    }
}
