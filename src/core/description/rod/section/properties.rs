//! Properties of a section at one point of a rod.

use crate::description::body;
use crate::description::rod::strain::STRAINS;

/// Stiffness and inertia of a section at one point of a rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionProperties {
    /// Stiffness per length of the strains, [`STRAIN_NAMES`](crate::description::rod::STRAIN_NAMES): for a shape diag(G
    /// J_t, E I_y, E I_z, E A, k_y G A, k_z G A).
    pub stiffness: [[f64; STRAINS]; STRAINS],
    /// Area within the outline in m^2, including the hole of a hollow circle: the area that displaces a
    /// fluid. Zero for a section with given properties.
    pub outline_area: f64,
    /// Mass per length in kg/m: rho A.
    pub mass: f64,
    /// Centre of mass relative to the rod's axis, in the section's axes, in metres.
    pub centre: [f64; 3],
    /// Inertia tensor per length about the centre of mass, in the section's axes, in kg m: for a shape rho
    /// diag(I_y + I_z, I_y, I_z), with the polar moment instead of the torsion constant.
    pub inertia: [[f64; 3]; 3],
}

impl SectionProperties {
    /// Matrix that maps the twist of the section, (angular velocity; velocity of the rod's axis), to its
    /// momentum per length.
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

/// Diagonal matrix with these entries.
pub fn diagonal<const N: usize>(entries: [f64; N]) -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { entries[i] } else { 0.0 }))
}
