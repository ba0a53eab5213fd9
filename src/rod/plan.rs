//! A rod compiled for computing: everything that does not change with the state, computed once.

use super::basis::legendre;
use super::description::{Rod, STRAIGHT, STRAINS, Segment};
use super::quadrature::Gauss;
use super::section::Section;
use crate::error::InvalidInput;
use crate::lie::{LANES, Pack, Quaternion, Vector};
use crate::linalg::Matrix;

/// Nodes that a segment needs beyond its number of modes: two integrations (strain to velocity, velocity to force) and
/// a rotation by up to about half a turn cost this many degrees of the polynomials; see `docs/rod.md` for the measured
/// error.
const NODES_BEYOND_MODES: usize = 9;

/// A linearly tapered radius enters the second moment of area with its fourth power.
const NODES_FOR_TAPER: usize = 4;

/// Offsets of the three Gauss points of a Magnus step of order six (Blanes, Casas, Oteo and Ros 2009, section 5.4).
pub(super) fn magnus_points() -> [f64; 3] {
    let offset = 15f64.sqrt() / 10.0;
    [0.5 - offset, 0.5, 0.5 + offset]
}

/// A rod compiled for computing.
#[derive(Clone, Debug)]
pub struct Plan {
    pub(super) n: usize,
    pub(super) segments: Vec<SegmentPlan>,
    /// Packs of nodes of all segments together.
    pub(super) packs: usize,
    pub(super) base_position: Vector<f64>,
    pub(super) base_orientation: Quaternion<f64>,
    pub(super) gravity: Vector<f64>,
    pub(super) tip_force: Vector<f64>,
    pub(super) tip_moment: Vector<f64>,
    pub(super) tip_mass: f64,
    /// Whether a dead load acts at the tip.
    pub(super) has_tip_load: bool,
}

/// One segment of a [`Plan`].
#[derive(Clone, Debug)]
pub(super) struct SegmentPlan {
    pub(super) length: f64,
    /// First coordinate and number of coordinates.
    pub(super) first: usize,
    pub(super) n: usize,
    /// First pack of nodes and number of packs.
    pub(super) first_pack: usize,
    pub(super) packs: usize,
    pub(super) gauss: Gauss,
    /// Quadrature weights, times the length.
    pub(super) weights: Vec<Pack>,
    /// Integration matrix from the segment's base to the nodes, times the length: entry `[pack * nodes + l]`.
    pub(super) from_base: Vec<Pack>,
    /// The same from the nodes to the segment's end.
    pub(super) to_end: Vec<Pack>,
    /// Basis at the nodes: entry `[degree * packs + pack]`.
    pub(super) basis: Vec<Pack>,
    /// Basis times quadrature weights.
    pub(super) weighted_basis: Vec<Pack>,
    /// Steps of the rotation: to the first node, then from node to node.
    pub(super) steps: Vec<Pack>,
    /// Basis at the Magnus points of these steps: entry `[(point * degrees + degree) * packs + pack]`.
    pub(super) magnus_basis: Vec<Pack>,
    /// The last step of the rotation, from the last node to the end, and its basis `[point * degrees + degree]`.
    pub(super) last_step: f64,
    pub(super) last_magnus_basis: Vec<f64>,
    /// Largest number of modes of a component.
    pub(super) degrees: usize,
    pub(super) components: Vec<Component>,
    pub(super) reference_strain: [f64; STRAINS],
    /// Whether stretch or shear can differ from those of a straight rod.
    pub(super) is_extensible: bool,
    pub(super) mass: Vec<Pack>,
    pub(super) rotary_inertia: Vec<Pack>,
    pub(super) retardation_time: f64,
}

/// A strain component that exists in a segment.
#[derive(Clone, Debug)]
pub(super) struct Component {
    /// Index of the strain, 0..6.
    pub(super) strain: usize,
    pub(super) modes: usize,
    /// First coordinate.
    pub(super) first: usize,
    /// `int phi_j H phi_k`, modes x modes.
    pub(super) stiffness: Matrix,
}

impl Plan {
    /// Compiles a rod; refuses one that is not valid.
    pub fn new(rod: &Rod) -> Result<Self, InvalidInput> {
        rod.validate()?;
        let mut segments = Vec::with_capacity(rod.segments.len());
        let (mut first, mut first_pack) = (0, 0);
        for segment in &rod.segments {
            let plan = SegmentPlan::new(segment, first, first_pack);
            first += plan.n;
            first_pack += plan.packs;
            segments.push(plan);
        }
        Ok(Self {
            n: first,
            segments,
            packs: first_pack,
            base_position: rod.base_position.into(),
            base_orientation: Quaternion::from_array(rod.base_orientation),
            gravity: rod.gravity.into(),
            tip_force: rod.tip_force.into(),
            tip_moment: rod.tip_moment.into(),
            tip_mass: rod.tip_mass,
            has_tip_load: rod.tip_force.iter().chain(&rod.tip_moment).any(|&x| x != 0.0),
        })
    }

    /// Quadrature nodes of each segment.
    pub fn nodes(&self) -> Vec<usize> {
        self.segments.iter().map(|segment| segment.gauss.nodes.len()).collect()
    }
}

impl SegmentPlan {
    fn new(segment: &Segment, first: usize, first_pack: usize) -> Self {
        let degrees = segment.modes.iter().copied().max().unwrap_or(0);
        let is_tapered = segment.radius[0] != segment.radius[1];
        let needed = degrees + NODES_BEYOND_MODES + if is_tapered { NODES_FOR_TAPER } else { 0 };
        let nodes = segment.nodes.unwrap_or(needed);
        // Whole packs: the rounding up costs nothing and buys accuracy.
        let packs = nodes.div_ceil(LANES);
        let nodes = packs * LANES;
        let gauss = Gauss::new(nodes);
        let length = segment.length;

        let pack = |f: &dyn Fn(usize) -> f64| -> Vec<Pack> {
            (0..packs).map(|p| Pack(std::array::from_fn(|lane| f(p * LANES + lane)))).collect()
        };
        let up_to: Vec<Vec<f64>> = gauss.nodes.iter().map(|&x| gauss.weights_up_to(x)).collect();
        let matrix = |f: &dyn Fn(usize, usize) -> f64| -> Vec<Pack> {
            let entry = |p: usize, l: usize| Pack(std::array::from_fn(|lane| f(p * LANES + lane, l)));
            (0..packs).flat_map(|p| (0..nodes).map(move |l| (p, l))).map(|(p, l)| entry(p, l)).collect()
        };
        let basis_at = |x: f64| {
            let mut values = vec![0.0; degrees];
            legendre(x, &mut values);
            values
        };
        let at_nodes: Vec<Vec<f64>> = gauss.nodes.iter().map(|&x| basis_at(x)).collect();

        let start = |i: usize| if i == 0 { 0.0 } else { gauss.nodes[i - 1] };
        let last = gauss.nodes[nodes - 1];
        let points = magnus_points();
        let mut magnus_basis = Vec::with_capacity(3 * degrees * packs);
        let mut last_magnus_basis = Vec::with_capacity(3 * degrees);
        for point in points {
            let values: Vec<Vec<f64>> =
                (0..nodes).map(|i| basis_at(start(i) + point * (gauss.nodes[i] - start(i)))).collect();
            for degree in 0..degrees {
                magnus_basis.extend(pack(&|i| values[i][degree]));
            }
            last_magnus_basis.extend(basis_at(last + point * (1.0 - last)));
        }

        let mut components = Vec::new();
        let mut next = first;
        for (strain, &modes) in segment.modes.iter().enumerate() {
            if modes > 0 {
                components.push(Component {
                    strain,
                    modes,
                    first: next,
                    stiffness: stiffness(segment, strain, modes),
                });
                next += modes;
            }
        }
        let sections: Vec<Section> = gauss.nodes.iter().map(|&x| Section::at(segment, x)).collect();
        let is_extensible = segment.modes[3..].iter().any(|&modes| modes > 0)
            || segment.reference_strain[3..] != STRAIGHT[3..];

        Self {
            length,
            first,
            n: next - first,
            first_pack,
            packs,
            weights: pack(&|i| length * gauss.weights[i]),
            from_base: matrix(&|i, l| length * up_to[i][l]),
            to_end: matrix(&|i, l| length * (gauss.weights[l] - up_to[i][l])),
            basis: (0..degrees).flat_map(|k| pack(&|i| at_nodes[i][k])).collect(),
            weighted_basis: (0..degrees)
                .flat_map(|k| pack(&|i| length * gauss.weights[i] * at_nodes[i][k]))
                .collect(),
            steps: pack(&|i| length * (gauss.nodes[i] - start(i))),
            magnus_basis,
            last_step: length * (1.0 - last),
            last_magnus_basis,
            degrees,
            components,
            reference_strain: segment.reference_strain,
            is_extensible,
            mass: pack(&|i| sections[i].mass),
            rotary_inertia: pack(&|i| sections[i].rotary_inertia),
            retardation_time: segment.retardation_time,
            gauss,
        }
    }

    /// The packs of this segment's nodes among those of the rod.
    pub(super) fn node_packs(&self) -> std::ops::Range<usize> {
        self.first_pack..self.first_pack + self.packs
    }

    /// The row of an integration matrix (`from_base` or `to_end`) that leads to pack `pack`.
    pub(super) fn row<'a>(&self, matrix: &'a [Pack], pack: usize) -> &'a [Pack] {
        let nodes = self.packs * LANES;
        &matrix[pack * nodes..(pack + 1) * nodes]
    }
}

/// `int phi_j H phi_k` of one strain component: exact, for a constant as for a tapered section.
fn stiffness(segment: &Segment, strain: usize, modes: usize) -> Matrix {
    // Degree 2 (modes - 1) + 4, the radius to the fourth power.
    let gauss = Gauss::new(modes + 2);
    let mut stiffness = Matrix::zeros(modes, modes);
    let mut phi = vec![0.0; modes];
    for (&x, &weight) in gauss.nodes.iter().zip(&gauss.weights) {
        legendre(x, &mut phi);
        let scale = segment.length * weight * Section::at(segment, x).stiffness[strain];
        for j in 0..modes {
            for k in 0..modes {
                stiffness[(j, k)] += scale * phi[j] * phi[k];
            }
        }
    }
    if segment.radius[0] == segment.radius[1] {
        // Legendre polynomials are orthogonal: what stands off the diagonal is rounding.
        stiffness = Matrix::from_diagonal(&stiffness.diagonal());
    }
    stiffness
}
