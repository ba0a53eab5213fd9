//! Energies.

/// The energies of a state, in joules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Elastic (strain) energy.
    pub elastic: f64,
    /// Potential energy in the gravity field, zero at the world's origin.
    pub gravitational: f64,
    /// Potential energy of conservative loads.
    pub loads: f64,
}

impl Energy {
    /// Sum of all parts: constant in free motion without damping.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational + self.loads
    }
}
