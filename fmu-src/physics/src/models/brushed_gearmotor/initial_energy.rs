//! Reference energies of the energy balance.

/// Stored energies to which the energy balance is relative, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InitialEnergy {
    /// Total stored energy.
    pub stored: f64,
    /// Magnetic energy.
    pub magnetic: f64,
    /// Kinetic energy.
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
