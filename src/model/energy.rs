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
    /// Potential energy of the loads that have one.
    pub loads: f64,
}

impl Energy {
    /// The sum of all parts: constant in free motion without damping.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational + self.loads
    }
}
