//! Continuation in the stiffness of contacts.
//!
//! The stiffer surfaces are, the shorter are the steps for which linearised contacts are valid. Therefore shapes are first searched with
//! contacts as soft as the forces allow; these shapes start searches with stiffer ones (penalty continuation: Nocedal and Wright 2006,
//! section 17.1). Obstacles of thin rods are larger with soft contacts, and shrink from search to search. The last search uses the
//! contacts of the model, so that its result is an equilibrium of these; the soft contacts only determine its start.

use crate::analysis::normalised;
use crate::model::{Softened, Static, chart};
use crate::numerics::linalg::Matrix;

/// This fraction of the estimated forces presses the softest surfaces into each other by their thickness.
const SOFTEST_FRACTION: f64 = 0.3;

/// Factor between stiffnesses, unless overlaps are so small that a shape hardly depends on them.
const STIFFNESS_FACTOR: f64 = 10.0;

/// Tolerance of searches with soft contacts, relative to the forces.
pub(super) const SOFT_TOLERANCE: f64 = 1e-4;

/// More iterations than this number do not help with soft contacts.
pub(super) const MAX_SOFT_ITERATIONS: usize = 100;

/// Beyond this overlap over the thickness, surfaces may be on either side of each other.
pub(super) const DEEP_OVERLAP: f64 = 0.5;

/// Beyond this overlap over the thickness, the middle of a surface may be inside the other one.
pub(super) const INSIDE_OVERLAP: f64 = 1.0;

/// The start of the search that follows one with softer contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NextStart {
    /// The last shape of the softer search.
    LastShape,
    /// The last shape, an equilibrium without contact, which is valid for any stiffness.
    WithoutContact,
    /// The shape from which the softer search began.
    InitialShape,
}

/// Softened contacts of a search, which begins at a shape.
pub(super) struct StiffnessContinuation {
    start: Vec<f64>,
    /// Forces on every pair of surfaces, newtons.
    forces: Vec<f64>,
    /// The part of these forces that presses surfaces into each other by their thickness.
    fraction: f64,
}

/// Enlargement of obstacles with contacts of this stiffness, over the largest one: forces press surfaces into each other by the same part of
/// it in every search.
fn enlargement(fraction: f64) -> f64 {
    fraction.sqrt().recip()
}

impl StiffnessContinuation {
    pub(super) fn new(model: &mut dyn Static, q: &[f64]) -> Self {
        Self { start: q.to_vec(), forces: forces_on_contacts(model, q), fraction: SOFTEST_FRACTION }
    }

    /// Softens the contacts for the next search. False if none became softer.
    pub(super) fn soften(&self, model: &mut dyn Static) -> bool {
        let Self { start, forces, fraction } = self;
        model.soften_contact(Some(Softened {
            forces,
            fraction: *fraction,
            enlargement: enlargement(*fraction),
            start,
        }))
    }

    /// The fraction of the forces in the next search.
    pub(super) fn fraction(&self) -> f64 {
        self.fraction
    }

    /// Shrinks obstacles by this part of the change from the search with `fraction` to the next one, without a change of the stiffness.
    pub(super) fn shrink(&self, model: &mut dyn Static, fraction: f64, part: f64) {
        let enlargement = enlargement(fraction) + part * (enlargement(self.fraction) - enlargement(fraction));
        model.soften_contact(Some(Softened {
            forces: &self.forces,
            fraction,
            enlargement,
            start: &self.start,
        }));
    }

    /// Use of the last shape of a search in the next one, with this overlap over the thickness there and at most `deepest` on the way.
    /// If nothing touches although surfaces were deep in each other, they may have passed through. Without deep overlaps, a shape
    /// that is not in equilibrium is a start as well.
    pub(super) fn next_start(&mut self, overlap: f64, deepest: f64, has_converged: bool) -> NextStart {
        let is_sound = deepest <= DEEP_OVERLAP;
        let next = match (has_converged, overlap > 0.0) {
            (true, true) => NextStart::LastShape,
            (true, false) if is_sound => NextStart::WithoutContact,
            (false, _) if is_sound => NextStart::LastShape,
            _ => NextStart::InitialShape,
        };
        self.fraction *= if has_converged && overlap > 0.0 {
            STIFFNESS_FACTOR.max(overlap.recip())
        } else {
            STIFFNESS_FACTOR
        };
        next
    }
}

/// Size of the forces that press the surfaces of every pair together: the work of weight, loads and bending by a radian over the
/// displacement of the surfaces.
fn forces_on_contacts(model: &mut dyn Static, q: &[f64]) -> Vec<f64> {
    let n = q.len();
    let mut sizes = vec![0.0; n];
    model.sizes(q, &mut sizes);
    let mut loads = Matrix::zeros(n, 3);
    model.turned_loads(q, &mut loads, &mut vec![0.0; n]);
    for mut column in loads.column_iter_mut() {
        chart::forces(&model.facts().rotation_vectors, q, column.as_mut_slice());
    }
    let material = normalised::material(model, &vec![0.0; n], &vec![1.0; n]);
    let shifts = model.shifts_of_contact(q);
    let work = |k: usize| {
        let bent = if model.facts().turns[k] { material[(k, k)].abs() * sizes[k] } else { 0.0 };
        let strained: f64 = (0..n).map(|j| (material[(k, j)] * q[j]).abs()).sum();
        (loads.row(k).norm() + bent + strained) * sizes[k]
    };
    let of_pair = |p: usize| {
        let moving = || (0..n).filter(|&k| shifts[(p, k)] > 0.0);
        let shift = moving().map(|k| shifts[(p, k)] * sizes[k]).fold(0.0, f64::max);
        let work = moving().map(work).fold(0.0, f64::max);
        if shift > 0.0 { work / shift } else { f64::INFINITY }
    };
    (0..shifts.nrows()).map(of_pair).collect()
}
