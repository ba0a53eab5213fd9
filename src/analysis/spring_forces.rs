//! Forces of springs and taut tendons in a shape at rest, and coordinates normalised by the stiffness.

use crate::analysis::at_rest::{AtRest, ROUNDING};
use crate::analysis::normalised;
use crate::analysis::normalised::Normalised;
use crate::analysis::ties::Ties;
use crate::model::Static;
use crate::numerics::linalg::Matrix;

/// Normalised coordinates of a shape, and the forces of springs and taut tendons at equilibrium.
pub(crate) struct SpringForces {
    /// Tangent of the material, in scaled coordinates.
    pub(crate) material: Matrix,
    pub(crate) normalised: Normalised,
    pub(crate) forces: Vec<f64>,
}

impl SpringForces {
    /// `None` if a number is not finite.
    pub(crate) fn new(
        model: &mut dyn Static,
        q: &[f64],
        sizes: &[f64],
        load_factor: f64,
        multipliers: &[f64],
        ties: &Ties,
    ) -> Option<Self> {
        let material = normalised::material(model, q, sizes);
        let (of_loads, uncoupled) = (normalised::work_of_loads(model, q, sizes), model.facts().parts.clone());
        let groups = normalised::groups(model, q);
        let reference =
            |stiffness: &Matrix| normalised::reference(&material, stiffness, &of_loads, &uncoupled, &groups);
        let mut at_rest = AtRest { model, q, sizes, load_factor, multipliers, ties, tie_forces: &[] };
        let (normalised, forces) = at_rest.spring_forces(&material, reference)?;
        Some(Self { material, normalised, forces })
    }

    /// Changes of the material's forces, times sizes, by rounding of coordinates.
    pub(crate) fn rounding(&self) -> Vec<f64> {
        let stiffness = self.material.row_iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>());
        stiffness.map(|stiffness| ROUNDING * f64::EPSILON * stiffness).collect()
    }

    /// The same with the tendons that have a tension; tendons that are only just taut are left out.
    pub(crate) fn with_ties(
        model: &mut dyn Static,
        q: &[f64],
        sizes: &[f64],
        load_factor: f64,
        multipliers: &[f64],
    ) -> Option<(Self, Ties)> {
        let mut ties = Ties::new(model, q, sizes, load_factor);
        loop {
            let springs = Self::new(model, q, sizes, load_factor, multipliers, &ties)?;
            let tie_forces = &springs.forces;
            let mut at_rest =
                AtRest { model: &mut *model, q, sizes, load_factor, multipliers, ties: &ties, tie_forces };
            if !ties.has_taut() {
                return Some((springs, ties));
            }
            let [residual, work] = at_rest.forces();
            let work = at_rest.most_work(&work);
            if !ties.slacken(tie_forces, &residual, &springs.rounding(), &work) {
                return Some((springs, ties));
            }
        }
    }
}
