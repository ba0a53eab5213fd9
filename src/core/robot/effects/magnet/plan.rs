//! Compiled magnets, and the memory of their tangents.

use super::law::Dipole;
use crate::numerics::lie::{Geometry, Vector};
use crate::robot::plan::space::Space;

/// Magnets and magnetised segments of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Magnets<G: Geometry> {
    /// Index of the load that stands for the uniform field, whose force is the field, if there is one.
    pub(super) field: Option<usize>,
    /// Energy in a constant field of moments out of the plane of motion, which no motion changes.
    pub(super) aside: f64,
    pub(super) fixed: Vec<Fixed<G>>,
    /// Moment per length at all nodes, in the axes of the sections; empty if no segment is magnetised.
    pub(super) along: Vec<G::Vector<G::Pack>>,
    /// Whether the piece that begins at a pack is magnetised; empty likewise.
    pub(super) begins: Vec<bool>,
    /// Interacting dipoles: first the magnets, in their order, then nodes on which any of these act.
    pub(super) active_dipoles: Vec<ActiveDipole<G::Pack>>,
    /// Pairs of them that move relative to each other. The first one is a magnet.
    pub(super) pairs: Vec<[usize; 2]>,
}

/// A magnet at a point.
#[derive(Clone, Debug)]
pub(super) struct Fixed<G: Geometry> {
    pub(super) moment: G::Vector<f64>,
    pub(super) point: usize,
}

/// Location of a dipole.
#[derive(Clone, Copy, Debug)]
pub(super) enum DipolePlace {
    /// At a point.
    Point(usize),
    /// A node, by its pack and its lane: its share of a magnetised segment.
    Node { pack: usize, lane: usize, weight: f64 },
}

/// A dipole with a field, or in the field of others.
#[derive(Clone, Debug)]
pub(super) struct ActiveDipole<P> {
    pub(super) place: DipolePlace,
    /// In the axes there.
    pub(super) own: Dipole,
    pub(super) moved_by: Vec<(usize, Vec<P>)>,
}

impl<G: Space> Default for Magnets<G> {
    fn default() -> Self {
        Self {
            field: None,
            aside: 0.0,
            fixed: Vec::new(),
            along: Vec::new(),
            begins: Vec::new(),
            active_dipoles: Vec::new(),
            pairs: Vec::new(),
        }
    }
}

impl<G: Space> Magnets<G> {
    /// Whether the uniform field acts along the piece that begins at a pack.
    #[inline(always)]
    pub(super) fn act_along(&self, first_pack: usize) -> bool {
        self.field.is_some() && self.begins.get(first_pack).is_some_and(|is_magnetised| *is_magnetised)
    }
}

/// Memory of the tangent.
#[derive(Clone, Debug)]
pub(crate) struct MagnetTangent {
    /// The dipoles in the shape.
    pub(super) dipoles: Vec<Dipole>,
    /// Moment about each and force on it.
    pub(super) wrenches: Vec<[Vector<f64>; 2]>,
    /// Rotation and shift of each for a unit of every coordinate: entry `[active_dipole * n + k]`.
    pub(super) moved: Vec<[Vector<f64>; 2]>,
    /// Change of the required wrench of each with a coordinate.
    pub(super) answers: Vec<[Vector<f64>; 2]>,
}

impl MagnetTangent {
    pub(crate) fn new<G: Space>(magnets: &Magnets<G>, n: usize) -> Self {
        let active_dipoles = if magnets.pairs.is_empty() { 0 } else { magnets.active_dipoles.len() };
        let none = [Vector::zero(); 2];
        Self {
            dipoles: vec![Dipole::none(); active_dipoles],
            wrenches: vec![none; active_dipoles],
            moved: vec![none; active_dipoles * n],
            answers: vec![none; active_dipoles],
        }
    }
}
