//! What a section gives to the rod at one place.

use crate::body;
use crate::rod::strain::STRAINS;

/// What a section gives to the rod at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionProperties {
    /// Stiffness per length of the strains, [`STRAIN_NAMES`](crate::rod::STRAIN_NAMES): of a shape diag(G J_t, E I_y, E I_z, E A, k_y G
    /// A, k_z G A).
    pub stiffness: [[f64; STRAINS]; STRAINS],
    /// Area within its outline in m^2, that of a hollow circle's hole included: what a fluid makes way for. Zero of a
    /// given section.
    pub outline_area: f64,
    /// Mass per length in kg/m: rho A.
    pub mass: f64,
    /// Centre of mass seen from the rod's axis, in the section's axes, in metres.
    pub centre: [f64; 3],
    /// Inertia tensor per length about the centre of mass, in the section's axes, in kg m: of a shape
    /// rho diag(I_y + I_z, I_y, I_z), with the polar moment in place of the torsion constant.
    pub inertia: [[f64; 3]; 3],
}

impl SectionProperties {
    /// The matrix that takes a twist of the section, (angular velocity; velocity of the rod's axis), to its momentum
    /// per length.
    pub fn inertia_matrix(&self) -> [[f64; 6]; 6] {
        let rotary = self.inertia_about_axis();
        let [x, y, z] = self.centre.map(|offset| self.mass * offset);
        let turned = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match (i < 3, j < 3) {
                (true, true) => rotary[i][j],
                (true, false) => turned[i][j - 3],
                (false, true) => -turned[i - 3][j],
                (false, false) => f64::from(u8::from(i == j)) * self.mass,
            })
        })
    }

    /// Inertia tensor per length about the rod's axis.
    pub(crate) fn inertia_about_axis(&self) -> [[f64; 3]; 3] {
        body::carried_inertia(self.mass, self.centre, &self.inertia)
    }
}

/// The diagonal matrix with these entries.
pub fn diagonal<const N: usize>(entries: [f64; N]) -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { entries[i] } else { 0.0 }))
}
