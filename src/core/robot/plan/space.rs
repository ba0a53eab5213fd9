//! Planar and spatial geometry for rods, with precomputed data of rotations per piece.

use crate::numerics::lie::{
    Geometry, Planar, Plane, PlaneRotation, Quaternion, Rotation, Spatial, Turn, Vector,
};

/// A geometry with the additional data for a rod's plan.
pub(crate) trait Space: Geometry {
    /// Orientation in a form from which others are computed.
    type Orientation: Copy + std::fmt::Debug + Send + Sync;
    /// State-independent data for the rotations of a piece.
    type Constants: Clone + Default + std::fmt::Debug + Send + Sync;

    /// Orientation of the frame.
    fn start() -> Self::Orientation;

    /// Orientation of a body rotated by `by` relative to one with this orientation.
    fn turned(orientation: Self::Orientation, by: Self::Orientation) -> Self::Orientation;

    /// Rotation matrix of an orientation.
    fn matrix(orientation: Self::Orientation) -> Self::Rotation<f64>;

    /// Orientation of a rotation matrix.
    fn orientation(matrix: &Self::Rotation<f64>) -> Self::Orientation;

    /// Orientation and rotation for an angle about a unit axis; sine and cosine of half the angle are given.
    fn turn_about(
        axis: Self::Axial<f64>,
        angle: f64,
        half: [f64; 2],
    ) -> (Self::Orientation, Self::Rotation<f64>);

    /// Converts a three-dimensional orientation that preserves this space.
    fn orientation_of(frame: Self::Frame, orientation: Quaternion<f64>) -> Self::Orientation;
}

impl<const FUSED: bool> Space for Spatial<FUSED> {
    type Orientation = Quaternion<f64>;
    type Constants = MagnusSteps<Self::Pack>;

    fn start() -> Quaternion<f64> {
        Quaternion { w: 1.0, v: Vector::zero() }
    }

    fn turned(orientation: Quaternion<f64>, by: Quaternion<f64>) -> Quaternion<f64> {
        orientation.times(by)
    }

    fn matrix(orientation: Quaternion<f64>) -> Self::Rotation<f64> {
        orientation.rotation()
    }

    fn orientation(matrix: &Self::Rotation<f64>) -> Quaternion<f64> {
        Quaternion::of_rotation(matrix)
    }

    #[inline(always)]
    fn turn_about(axis: Vector<f64>, _: f64, [sine, cosine]: [f64; 2]) -> (Quaternion<f64>, Rotation<f64>) {
        let turn = Quaternion { w: cosine, v: axis * sine };
        (turn, turn.rotation())
    }

    fn orientation_of((): (), orientation: Quaternion<f64>) -> Quaternion<f64> {
        orientation
    }
}

impl<const FUSED: bool> Space for Planar<FUSED> {
    type Orientation = f64;
    type Constants = Angles<Self::Pack>;

    fn start() -> f64 {
        0.0
    }

    fn turned(angle: f64, by: f64) -> f64 {
        angle + by
    }

    fn matrix(angle: f64) -> PlaneRotation<f64> {
        PlaneRotation::by(angle)
    }

    fn orientation(matrix: &PlaneRotation<f64>) -> f64 {
        matrix.sin.atan2(matrix.cos)
    }

    #[inline(always)]
    fn turn_about(Turn(axis): Turn<f64>, angle: f64, [sine, cosine]: [f64; 2]) -> (f64, PlaneRotation<f64>) {
        let rotation =
            PlaneRotation { cos: cosine * cosine - sine * sine, sin: 2.0 * axis * (sine * cosine) };
        (axis * angle, rotation)
    }

    fn orientation_of(plane: Plane, orientation: Quaternion<f64>) -> f64 {
        let Quaternion { w, v } = orientation;
        2.0 * v.to_array()[plane.normal].atan2(w)
    }
}

/// The passage between two places of a piece.
#[derive(Clone, Debug)]
pub(crate) struct Passage {
    /// Signed length.
    pub(crate) step: f64,
    /// In space, the basis at the Magnus points, `[point * degrees + degree]`; in the plane, its integrals.
    pub(crate) basis: Vec<f64>,
    /// In space, the reference curvature, `[point * 3 + axis]`; in the plane, its integral.
    pub(crate) reference: Vec<f64>,
}

/// Magnus steps from the base to the first node, between nodes, and from the last node to the end.
#[derive(Clone, Debug)]
pub(crate) struct MagnusSteps<P> {
    /// Lengths of all steps except the last.
    pub(crate) steps: Vec<P>,
    /// Basis at the Magnus points of these steps: entry `[(point * degrees + degree) * packs + pack]`.
    pub(crate) basis: Vec<P>,
    /// Reference curvature at these points: entry `[(point * 3 + axis) * packs + pack]`; empty if constant.
    pub(crate) reference: Vec<P>,
    pub(crate) constant_reference: Vector<f64>,
    /// Length of the last step, its basis `[point * degrees + degree]` and reference curvature `[point * 3 +
    /// axis]`.
    pub(crate) last_step: f64,
    pub(crate) last_basis: Vec<f64>,
    pub(crate) last_reference: Vec<f64>,
    /// Largest number of modes of an angular strain.
    pub(crate) degrees: usize,
}

/// Rotation angles per unit of each coordinate.
#[derive(Clone, Debug)]
pub(crate) struct Angles<P> {
    /// Angles at the nodes, for the reference strain and then by degree: entry `[degree * packs + pack]`.
    pub(crate) reference: Vec<P>,
    pub(crate) at_nodes: Vec<P>,
    /// Mean values over the piece of the reference curvature and of the basis functions with non-zero mean;
    /// Legendre polynomials beyond the first have mean zero.
    pub(crate) mean_reference: f64,
    pub(crate) means: Vec<f64>,
    /// Axis of bending.
    pub(crate) normal: usize,
}

impl<P> Default for MagnusSteps<P> {
    /// For pieces without nodes.
    fn default() -> Self {
        Self {
            steps: Vec::new(),
            basis: Vec::new(),
            reference: Vec::new(),
            constant_reference: Vector::zero(),
            last_step: 0.0,
            last_basis: Vec::new(),
            last_reference: Vec::new(),
            degrees: 0,
        }
    }
}

impl<P> Default for Angles<P> {
    /// For pieces without nodes.
    fn default() -> Self {
        Self {
            reference: Vec::new(),
            at_nodes: Vec::new(),
            mean_reference: 0.0,
            means: Vec::new(),
            normal: 0,
        }
    }
}
