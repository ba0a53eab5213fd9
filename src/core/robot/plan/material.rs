//! Material of a piece: stiffness and mass.

use super::space::Space;
use crate::numerics::linalg::Matrix;
use crate::robot::algebra::inertia::Inertia;

/// A strain component that has modes in a piece.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    /// Index among the strains of the geometry.
    pub(crate) index: usize,
    pub(crate) modes: usize,
    /// Index of the first coordinate.
    pub(crate) first: usize,
    /// `int phi_j H phi_k`, modes x modes.
    pub(crate) stiffness: Matrix,
    /// Whether the stiffness is diagonal.
    pub(crate) is_orthogonal: bool,
}

impl Component {
    /// Row `j` of `K (q + mu qd)` for the coordinates of this component.
    #[inline(always)]
    pub(crate) fn elastic_force(&self, j: usize, q: &[f64], qd: &[f64], mu: f64) -> f64 {
        if self.is_orthogonal {
            return self.stiffness[(j, j)] * (q[j] + mu * qd[j]);
        }
        (0..self.modes).map(|k| self.stiffness[(j, k)] * (q[k] + mu * qd[k])).sum()
    }
}

/// Stiffness between two strain components of a piece, `int phi_j H phi_k` with the first one as rows. K
/// contains this block above the diagonal, and its transpose below.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    /// Indices of the first coordinates.
    pub(crate) first: [usize; 2],
    pub(crate) stiffness: Matrix,
}

impl Coupling {
    /// Coordinates of both components.
    #[inline(always)]
    pub(crate) fn coordinates(&self) -> [std::ops::Range<usize>; 2] {
        let (rows, columns) = self.stiffness.shape();
        [self.first[0]..self.first[0] + rows, self.first[1]..self.first[1] + columns]
    }

    /// Adds the contribution of this block to `K (q + mu qd)`.
    #[inline(always)]
    pub(crate) fn add_elastic_force(&self, q: &[f64], qd: &[f64], mu: f64, tau: &mut [f64]) {
        let [rows, columns] = self.coordinates();
        for (j, row) in rows.enumerate() {
            for (k, column) in columns.clone().enumerate() {
                let stiffness = self.stiffness[(j, k)];
                tau[row] += stiffness * (q[column] + mu * qd[column]);
                tau[column] += stiffness * (q[row] + mu * qd[row]);
            }
        }
    }
}

/// Distribution of mass within the sections of a piece.
#[derive(Clone, Debug)]
pub(crate) enum Moments<G: Space> {
    /// Isotropic in the rod's space: rotary inertia per length at the nodes.
    Round(Vec<G::Pack>),
    /// General: inertia per length at the nodes, about the rod's axis and in section axes.
    General(Vec<Inertia<G, G::Pack>>),
}
