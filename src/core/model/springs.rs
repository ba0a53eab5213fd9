//! Springs to the world: their forces in a shape, and the derivatives of these forces.
//!
//! ```
//! use lissom::model::Dynamics;
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::support::Support;
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let prop = Support { stiffness: [0.0, 0.0, 100.0], ..Support::at_tip() };
//! let model = RobotModel::of_rod(&Rod { supports: vec![prop], ..Rod::new(vec![segment]) })?;
//! assert!(model.facts().springs > 0);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

use crate::numerics::linalg::Matrix;

/// Springs of a model in a shape. Their m forces f contribute `-J^T f` to the generalised forces, and change
/// by `-(G G^T + S) J dq`.
#[derive(Clone, Debug)]
pub struct Springs {
    /// The forces f, shape (m,), in axes that do not move with the coordinates.
    pub forces: Vec<f64>,
    /// J: displacements of the points of attack per unit change of the coordinates, m x n.
    pub jacobian: Matrix,
    /// G: a square root of the stiffness, m x m.
    pub root: Matrix,
    /// Pseudo-inverse of G.
    pub inverse_root: Matrix,
    /// S: the part of the stiffness with no real root, or nearly none; m x m, symmetric.
    pub rest: Matrix,
    /// Potential energy of the springs, in joules.
    pub energy: f64,
}

/// Tendons of a commanded length in a shape, which pull but never push.
#[derive(Clone, Debug)]
pub struct LengthTendons {
    /// Stiffness in N/m, shape (m,); infinite for those that do not stretch.
    pub stiffness: Vec<f64>,
    /// By how much each one is longer than commanded, in metres; negative where it is slack.
    pub excesses: Vec<f64>,
    /// Lengths, in metres, to which the rounding of the excesses is relative.
    pub spans: Vec<f64>,
    /// Derivatives of the excesses with respect to the coordinates, m x n.
    pub jacobian: Matrix,
    /// Summed lengths of the relative displacements of the ends of straight parts per unit change of the coordinates: bounds of the
    /// absolute values of the derivatives; m x n.
    pub reach: Matrix,
}

impl LengthTendons {
    /// Memory for m length_tendons of a model with n coordinates.
    pub fn new(m: usize, n: usize) -> Self {
        Self {
            stiffness: vec![0.0; m],
            excesses: vec![0.0; m],
            spans: vec![0.0; m],
            jacobian: Matrix::zeros(m, n),
            reach: Matrix::zeros(m, n),
        }
    }
}

impl Springs {
    /// Memory for m forces of a model with n coordinates.
    pub fn new(m: usize, n: usize) -> Self {
        let square = Matrix::zeros(m, m);
        Self {
            forces: vec![0.0; m],
            jacobian: Matrix::zeros(m, n),
            root: square.clone(),
            inverse_root: square.clone(),
            rest: square,
            energy: 0.0,
        }
    }

    /// Starts with the springs of another list; the rest has no stiffness.
    pub fn begin_with(&mut self, first: &Self) {
        let (m, n) = first.jacobian.shape();
        for all in [&mut self.root, &mut self.inverse_root, &mut self.rest] {
            all.fill(0.0);
        }
        self.forces[..m].copy_from_slice(&first.forces);
        self.jacobian.view_mut((0, 0), (m, n)).copy_from(&first.jacobian);
        self.root.view_mut((0, 0), (m, m)).copy_from(&first.root);
        self.inverse_root.view_mut((0, 0), (m, m)).copy_from(&first.inverse_root);
        self.rest.view_mut((0, 0), (m, m)).copy_from(&first.rest);
        self.energy = first.energy;
    }

    /// Sets stiffness and elongation of one of the rest.
    pub fn stretch(&mut self, place: usize, stiffness: f64, elongation: f64) {
        self.forces[place] = -stiffness * elongation;
        self.root[(place, place)] = stiffness.sqrt();
        self.inverse_root[(place, place)] = 1.0 / stiffness.sqrt();
        self.energy += 0.5 * stiffness * elongation * elongation;
    }

    /// Converts to coordinates divided by these sizes.
    pub fn scale(&mut self, sizes: &[f64]) {
        for (mut column, size) in self.jacobian.column_iter_mut().zip(sizes) {
            column *= *size;
        }
    }

    /// Change of the forces with coordinates: `-(G G^T + S) J dq`.
    pub fn changes(&self, dq: &[f64]) -> Vec<f64> {
        let moved = &self.jacobian * nalgebra::DVector::from_column_slice(dq);
        let changes = &self.root * self.root.tr_mul(&moved) + &self.rest * moved;
        changes.iter().map(|change| -change).collect()
    }

    /// `G+ (f - others)`, and the remainder of `f - others` outside the range of G.
    pub fn mismatch(&self, others: &[f64]) -> [Vec<f64>; 2] {
        let m = others.len();
        let times = |a: &Matrix, x: &[f64]| -> Vec<f64> {
            (0..m).map(|i| (0..m).map(|j| a[(i, j)] * x[j]).sum()).collect()
        };
        // Subtracting amplitudes instead of forces avoids cancellation.
        let [amplitudes, other_amplitudes] =
            [&self.forces[..], others].map(|forces| times(&self.inverse_root, forces));
        let differences = amplitudes.iter().zip(&other_amplitudes).map(|(x, other)| x - other).collect();
        let [part, other_part] =
            [amplitudes, other_amplitudes].map(|amplitudes| times(&self.root, &amplitudes));
        let left = (0..m).map(|i| (self.forces[i] - part[i]) - (others[i] - other_part[i])).collect();
        [differences, left]
    }
}
