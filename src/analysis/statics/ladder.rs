//! Stiff contacts by way of soft ones.
//!
//! The stiffer surfaces are, the shorter are the steps in which what touches stays as linearised. Hence shapes are first sought with
//! contacts as soft as the forces allow, and these shapes start searches with stiffer ones: homotopy in the penalty (Nocedal and Wright
//! 2006, section 17.1). The last search is that of the model itself. Its result is thus an equilibrium of the stiff contacts; the
//! soft ones decide only where it starts.

use crate::analysis::natural;
use crate::model::{Static, chart};
use crate::numerics::linalg::Matrix;

/// Stiffness of the softest contacts: with this part of it the forces would press surfaces into each other by their thickness.
const FIRST: f64 = 0.3;

/// Factor between stiffnesses, unless overlaps are so small that a shape hardly depends on them.
const FACTOR: f64 = 10.0;

/// Shapes of soft contacts may be off by this part of the forces.
pub(super) const LOOSE: f64 = 1e-4;

/// More iterations than this number do not help with soft contacts.
pub(super) const LONGEST: usize = 100;

/// Surfaces that overlap by more than this part of their thickness do not tell on which side they are.
pub(super) const DEEP: f64 = 0.5;

/// The middle of what overlaps by more than its thickness may be inside the other surface.
const INSIDE: f64 = 1.0;

/// Overlap over the thickness, of surfaces with two sides, beyond which what is on the way between two shapes passes through: parts of
/// a way that are too short to hide anything are not looked at, so that where they end tells.
pub(super) fn inside(model: &mut dyn Static, ends: [&[f64]; 2]) -> f64 {
    let overlaps = ends.map(|q| model.deepest_overlaps(q)[1]);
    overlaps.into_iter().fold(INSIDE, f64::max)
}

/// What a shape of soft contacts is for stiffer ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rung {
    /// The start of the next search.
    Start,
    /// An equilibrium in which nothing touches, whatever the stiffness is.
    Free,
    /// No start: the next search begins where the first one did.
    Dropped,
}

/// Softened contacts of a search, which begins at a shape.
pub(super) struct Ladder {
    /// Forces on every pair of surfaces, newtons.
    forces: Vec<f64>,
    part: f64,
}

impl Ladder {
    pub(super) fn new(model: &mut dyn Static, q: &[f64]) -> Self {
        Self { forces: forces_on_contacts(model, q), part: FIRST }
    }

    /// Softens the contacts for the next search. False if they are not softer than they are themselves.
    pub(super) fn soften(&self, model: &mut dyn Static) -> bool {
        let limits: Vec<f64> = self.forces.iter().map(|force| self.part * force).collect();
        model.soften_contact(Some(&limits))
    }

    /// What a shape, in which a search has ended, is for the next one: surfaces overlap there by this part of their thickness, and by
    /// at most `deepest` on the way. If nothing touches there although surfaces were deep in each other, they may have passed through;
    /// where they never were deep, also a shape on the way to equilibrium is a start.
    pub(super) fn climb(&mut self, overlap: f64, deepest: f64, has_converged: bool) -> Rung {
        let is_sound = deepest <= DEEP;
        let rung = match (has_converged, overlap > 0.0) {
            (true, true) => Rung::Start,
            (true, false) if is_sound => Rung::Free,
            (false, _) if is_sound => Rung::Start,
            _ => Rung::Dropped,
        };
        self.part *= if has_converged && overlap > 0.0 { FACTOR.max(overlap.recip()) } else { FACTOR };
        rung
    }
}

/// Size of the forces that press the surfaces of every pair together: what weight, loads and bending by a radian could do over the
/// way on which surfaces move.
fn forces_on_contacts(model: &mut dyn Static, q: &[f64]) -> Vec<f64> {
    let n = q.len();
    let mut sizes = vec![0.0; n];
    model.sizes(q, &mut sizes);
    let mut loads = Matrix::zeros(n, 3);
    model.turned_loads(q, &mut loads, &mut vec![0.0; n]);
    for mut column in loads.column_iter_mut() {
        chart::forces(&model.facts().rotation_vectors, q, column.as_mut_slice());
    }
    let material = natural::material(model, &vec![0.0; n], &vec![1.0; n]);
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
