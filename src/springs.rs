//! Springs to the world: their forces at a shape, and the derivatives of these.
//!
//! ```
//! use lissom::model::Elastic;
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::support::Support;
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let prop = Support { stiffness: [0.0, 0.0, 100.0], ..Support::at_tip() };
//! let model = RobotModel::of_rod(&Rod { supports: vec![prop], ..Rod::new(vec![segment]) })?;
//! assert!(model.springs() > 0);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

use crate::linalg::Matrix;

/// The springs of a model in a shape. Their m forces f enter the generalised forces as `-J^T f`, and change by
/// `-(G G^T + S) J dq`.
#[derive(Clone, Debug)]
pub struct Springs {
    /// The forces f, shape (m,), in axes that do not move with the coordinates.
    pub forces: Vec<f64>,
    /// J: displacements of where they act for unit rates of the coordinates, m x n.
    pub jacobian: Matrix,
    /// G: a root of the stiffness, m x m.
    pub root: Matrix,
    /// Its pseudo-inverse.
    pub inverse_root: Matrix,
    /// S: stiffness that has no real root, or nearly none; m x m, symmetric.
    pub rest: Matrix,
    /// Potential energy of the springs, in joules.
    pub energy: f64,
}

impl Springs {
    /// Memory for m forces of a model with n coordinates.
    pub(crate) fn new(m: usize, n: usize) -> Self {
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

    /// In coordinates divided by these sizes.
    pub(crate) fn scale(&mut self, sizes: &[f64]) {
        for (mut column, size) in self.jacobian.column_iter_mut().zip(sizes) {
            column *= *size;
        }
    }

    /// How the forces change with coordinates: `-(G G^T + S) J dq`.
    pub(crate) fn changes(&self, dq: &[f64]) -> Vec<f64> {
        let moved = &self.jacobian * nalgebra::DVector::from_column_slice(dq);
        let changes = &self.root * self.root.tr_mul(&moved) + &self.rest * moved;
        changes.iter().map(|change| -change).collect()
    }

    /// `G+ (f - held)`, and what of `f - held` that leaves.
    pub(crate) fn mismatch(&self, held: &[f64]) -> [Vec<f64>; 2] {
        let m = held.len();
        let times = |a: &Matrix, x: &[f64]| -> Vec<f64> {
            (0..m).map(|i| (0..m).map(|j| a[(i, j)] * x[j]).sum()).collect()
        };
        // The difference of the amplitudes, not of the forces, keeps its digits.
        let [own, other] = [&self.forces[..], held].map(|forces| times(&self.inverse_root, forces));
        let amplitudes: Vec<f64> = own.iter().zip(&other).map(|(own, other)| own - other).collect();
        let [own_part, other_part] = [own, other].map(|amplitudes| times(&self.root, &amplitudes));
        let left = (0..m).map(|i| (self.forces[i] - own_part[i]) - (held[i] - other_part[i])).collect();
        [amplitudes, left]
    }
}
