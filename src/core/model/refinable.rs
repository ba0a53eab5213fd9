//! Models with an adjustable discretisation.

use super::Dynamics;

/// Effects of the strains that a finite number of modes leaves out of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MissingStrain {
    /// Largest displacement of anything, to first order, in metres.
    pub displacement: f64,
    /// Largest curvature, torsion included, in radians per metre.
    pub curvature: f64,
    /// Largest moment of the material, in newton metres.
    pub moment: f64,
    /// Largest rotation of a rod in that shape between neighbouring quadrature nodes, in radians: where it is large,
    /// integrals have errors that the balance of forces does not show.
    pub turn: f64,
    /// The segment, counted through all rods, that contributes most to the largest displacement, and its strain that stores most
    /// energy, by its index in [`STRAIN_NAMES`](crate::description::rod::STRAIN_NAMES).
    pub segment: usize,
    /// See `segment`.
    pub strain: usize,
    /// Deflection by shear, of a cantilever with the sections of this segment and the length of its rod under a force at the tip, over that
    /// by bending: zero where shear has modes, otherwise what they leave out.
    pub rigid_shear: f64,
    /// What stretch without modes leaves out.
    pub rigid_stretch: RigidStretch,
}

/// The segment of a shape at rest whose length the axial forces in it would change most if its stretch, which has no modes, were not
/// rigid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidStretch {
    /// Mean axial strain of the segment, forces over stiffness.
    pub strain: f64,
    /// Largest axial force of the material, in newtons, positive in tension, with the axial stiffness E A there, in newtons.
    pub force: f64,
    /// See `force`.
    pub stiffness: f64,
    /// The segment, counted through all rods.
    pub segment: usize,
}

/// A finite number of modes and quadrature nodes.
pub trait Refinable: Dynamics {
    /// Numbers of modes of all series whose coefficients are coordinates, in order, empty series included;
    /// `None` for a system that is not discretised by hierarchical series (where a longer series contains the
    /// shorter one).
    fn modes(&self) -> Option<Vec<usize>>;

    /// Numbers of coordinates, such as those of joints, before each of these series and after the last one.
    fn coordinates_between(&self) -> Vec<usize>;

    /// The same system with these numbers of modes and enough nodes; `None` if there would be too many.
    fn with_modes(&self, modes: &[usize]) -> Option<Self>
    where
        Self: Sized;

    /// The same system and coordinates with this multiple of the default number of quadrature nodes; `None`
    /// if the nodes are fixed, or would be too many.
    fn with_nodes_times(&self, factor: usize) -> Option<Self>
    where
        Self: Sized;

    /// The same system and coordinates with `factor` times the inertia under the same forces, weight included; `None` if not
    /// available.
    fn with_inertia_times(&self, factor: f64) -> Option<Self>
    where
        Self: Sized;

    /// The strains that the finite number of modes leaves out of a shape at rest, from the balance of the forces in that shape with
    /// fixed joints and forces, under this fraction of the loads (elastic supports count among them). Strains without modes do not
    /// count. `None` for a system without rods. Costs little more than an evaluation of the forces. Allocates.
    fn missing_strain(&mut self, q: &[f64], load_factor: f64) -> Option<MissingStrain>;

    /// The effect of the strains of these coordinates in a shape, with fixed joints. Allocates.
    fn effect_of_strains(&mut self, q: &[f64], change: &[f64]) -> Option<MissingStrain>;

    /// Adds the positions of a fixed set of many sections of all rods, in metres.
    fn outline(&mut self, q: &[f64], positions: &mut Vec<[f64; 3]>);

    /// A segment, counted through all rods, in words for messages.
    fn name_of_segment(&self, segment: usize) -> String;
}
