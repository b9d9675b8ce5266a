//! What the energy balance starts from.

/// What the books start from, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Opening {
    /// Energy in all stores.
    pub stored: f64,
    /// Energy in the magnetic field.
    pub magnetic: f64,
    /// Energy of the motion.
    pub kinetic: f64,
}

crate::saved!(Opening { stored, magnetic, kinetic });

impl std::ops::Add for Opening {
    type Output = Opening;
    fn add(self, other: Opening) -> Opening {
        Opening {
            stored: self.stored + other.stored,
            magnetic: self.magnetic + other.magnetic,
            kinetic: self.kinetic + other.kinetic,
        }
    }
}

impl std::ops::Sub for Opening {
    type Output = Opening;
    fn sub(self, other: Opening) -> Opening {
        self + Opening { stored: -other.stored, magnetic: -other.magnetic, kinetic: -other.kinetic }
    }
}
