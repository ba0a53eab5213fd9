//! How rotations follow from the curvature: by Magnus steps in space, by a sum in the plane.

use super::basis::{integrals, legendre};
use super::cost::Products;
use super::description::Segment;
use super::plan::{Component, SegmentPlan, packed};
use super::quadrature::Gauss;
use crate::lie::{
    Counted, Geometry, LANES, Planar, PlaneRotation, Quaternion, Scalar, Spatial, Vector, products,
};

/// A geometry whose rotations can be found from the curvature.
pub(super) trait Turning: Geometry {
    /// An orientation that others follow from.
    type Orientation: Copy + std::fmt::Debug + Send + Sync;
    /// What of a segment does not change with the state.
    type Constants: Clone + std::fmt::Debug + Send + Sync;

    /// The orientation of the frame.
    fn start() -> Self::Orientation;

    /// The rotation ready to be applied.
    fn matrix(orientation: Self::Orientation) -> Self::Rotation<f64>;

    /// Prepares a segment with these nodes and components.
    fn constants(
        segment: &Segment,
        frame: Self::Frame,
        gauss: &Gauss,
        components: &[Component],
    ) -> Self::Constants;

    /// Rotations at the nodes of a segment that begins with `orientation`; returns that of its end.
    fn turn(
        segment: &SegmentPlan<Self>,
        q: &[f64],
        orientation: Self::Orientation,
        rotations: &mut [Self::Rotation<Self::Pack>],
    ) -> Self::Orientation;

    /// What [`Self::turn`] costs.
    fn products_of_turn(segment: &SegmentPlan<Self>) -> Products;

    /// Prepares the way from one place of a segment to another, given as fractions of its length.
    fn passage(segment: &SegmentPlan<Self>, from: f64, to: f64) -> Passage;

    /// The rotation along a passage.
    fn pass(segment: &SegmentPlan<Self>, q: &[f64], passage: &Passage) -> Self::Rotation<f64>;
}

/// The way from one place of a segment to another.
#[derive(Clone, Debug)]
pub(super) struct Passage {
    /// Its length, signed.
    step: f64,
    /// In space: the basis at the Magnus points, `[point * degrees + degree]`. In the plane: its integrals.
    basis: Vec<f64>,
}

/// The largest number of modes of an angular strain.
fn angular_degrees<G: Geometry>(components: &[Component]) -> usize {
    components.iter().filter(|component| component.index < G::ANGULAR).map(|c| c.modes).max().unwrap_or(0)
}

/// Offsets of the three Gauss points of a Magnus step of order six (Blanes, Casas, Oteo and Ros 2009, section 5.4).
fn magnus_points() -> [f64; 3] {
    let offset = 15f64.sqrt() / 10.0;
    [0.5 - offset, 0.5, 0.5 + offset]
}

/// Weights of these points.
const MAGNUS_WEIGHTS: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

/// The basis at the Gauss points of a Magnus step, by point. That of the midpoint is chosen such that the points give the exact
/// integral over the step: a rod that bends about one axis then turns exactly, whatever the number of modes.
fn magnus_basis(from: f64, to: f64, degrees: usize) -> [Vec<f64>; 3] {
    let mut basis = magnus_points().map(|point| {
        let mut values = vec![0.0; degrees];
        legendre(from + point * (to - from), &mut values);
        values
    });
    if to > from {
        let up_to = |x| {
            let mut values = vec![0.0; degrees];
            integrals(x, &mut values);
            values
        };
        let (start, end) = (up_to(from), up_to(to));
        for k in 0..degrees {
            let mean = (end[k] - start[k]) / (to - from);
            let others = MAGNUS_WEIGHTS[0] * basis[0][k] + MAGNUS_WEIGHTS[2] * basis[2][k];
            basis[1][k] = (mean - others) / MAGNUS_WEIGHTS[1];
        }
    }
    basis
}

/// Rotation vector of a step of length `h` of R' = R [kappa], given kappa at the Gauss points of [`magnus_points`]: Magnus
/// expansion of order six (Blanes, Casas, Oteo and Ros 2009, eq. 253). Their equation reads Y' = A Y; ours has A on the
/// right, which turns the sign of every bracket.
#[inline(always)]
fn magnus_step<T: Scalar>(h: T, kappa: [Vector<T>; 3]) -> Vector<T> {
    let scaled = |v: Vector<T>, factor: f64| v * T::splat(factor);
    let bracket = |a: Vector<T>, b: Vector<T>| b.cross(a);
    let a1 = kappa[1] * h;
    let a2 = scaled((kappa[2] - kappa[0]) * h, 15f64.sqrt() / 3.0);
    let a3 = scaled((kappa[2] - scaled(kappa[1], 2.0) + kappa[0]) * h, 10.0 / 3.0);
    let c1 = bracket(a1, a2);
    let c2 = scaled(bracket(a1, scaled(a3, 2.0) + c1), -1.0 / 60.0);
    a1 + scaled(a3, 1.0 / 12.0) + scaled(bracket(scaled(a1, -20.0) - a3 + c1, a2 + c2), 1.0 / 240.0)
}

/// Magnus steps from the base to the first node, from node to node, and from the last node to the end.
#[derive(Clone, Debug)]
pub(super) struct MagnusSteps<P> {
    /// Lengths of all steps but the last.
    steps: Vec<P>,
    /// Basis at the Magnus points of these steps: entry `[(point * degrees + degree) * packs + pack]`.
    basis: Vec<P>,
    /// The last step, and its basis `[point * degrees + degree]`.
    last_step: f64,
    last_basis: Vec<f64>,
    /// Largest number of modes of an angular strain.
    degrees: usize,
}

/// Curvature at the Magnus points; `basis(point, degree)` is the basis there.
#[inline(always)]
fn curvatures<const FUSED: bool, T: Scalar>(
    segment: &SegmentPlan<Spatial<FUSED>>,
    q: &[f64],
    basis: impl Fn(usize, usize) -> T,
) -> [Vector<T>; 3] {
    let reference = segment.reference_strain.angular.to_array();
    let mut kappa = [Vector::splat(reference); 3];
    for component in segment.components.iter().filter(|component| component.index < Spatial::<FUSED>::ANGULAR)
    {
        for (k, &q) in q[component.first..][..component.modes].iter().enumerate() {
            for (point, kappa) in kappa.iter_mut().enumerate() {
                let entry = kappa.component_mut(component.index);
                *entry = basis(point, k).mul_add(T::splat(q), *entry);
            }
        }
    }
    kappa
}

impl<const FUSED: bool> Turning for Spatial<FUSED> {
    type Orientation = Quaternion<f64>;
    type Constants = MagnusSteps<Self::Pack>;

    fn start() -> Quaternion<f64> {
        Quaternion { w: 1.0, v: Vector::zero() }
    }

    fn matrix(orientation: Quaternion<f64>) -> Self::Rotation<f64> {
        orientation.rotation()
    }

    fn constants(
        segment: &Segment,
        (): (),
        gauss: &Gauss,
        components: &[Component],
    ) -> MagnusSteps<Self::Pack> {
        let degrees = angular_degrees::<Self>(components);
        let nodes = gauss.nodes.len();
        let start = |i: usize| if i == 0 { 0.0 } else { gauss.nodes[i - 1] };
        let last = gauss.nodes[nodes - 1];
        let values: Vec<[Vec<f64>; 3]> =
            (0..nodes).map(|i| magnus_basis(start(i), gauss.nodes[i], degrees)).collect();
        let mut basis = Vec::with_capacity(3 * degrees * nodes / LANES);
        for point in 0..3 {
            for degree in 0..degrees {
                basis.extend(packed::<Self::Pack>(nodes, |i| values[i][point][degree]));
            }
        }
        MagnusSteps {
            steps: packed(nodes, |i| segment.length * (gauss.nodes[i] - start(i))),
            basis,
            last_step: segment.length * (1.0 - last),
            last_basis: magnus_basis(last, 1.0, degrees).concat(),
            degrees,
        }
    }

    #[inline(always)]
    fn turn(
        segment: &SegmentPlan<Self>,
        q: &[f64],
        mut orientation: Quaternion<f64>,
        rotations: &mut [Self::Rotation<Self::Pack>],
    ) -> Quaternion<f64> {
        let magnus = &segment.turning;
        for (pack, rotation) in rotations.iter_mut().enumerate() {
            let basis =
                |point: usize, k: usize| magnus.basis[(point * magnus.degrees + k) * segment.packs + pack];
            let step = Quaternion::exp(magnus_step(magnus.steps[pack], curvatures(segment, q, basis)));
            let mut here = step;
            for lane in 0..LANES {
                orientation = orientation.times(step.lane(lane));
                here.set_lane(lane, orientation);
            }
            *rotation = here.normalised().rotation();
        }
        let basis = |point: usize, k: usize| magnus.last_basis[point * magnus.degrees + k];
        let last = Quaternion::exp(magnus_step(magnus.last_step, curvatures(segment, q, basis)));
        orientation.times(last).normalised()
    }

    fn products_of_turn(segment: &SegmentPlan<Self>) -> Products {
        let q = vec![0.0; segment.first + segment.n];
        let here = Quaternion { w: Counted, v: Vector::zero() };
        let step =
            products(|| Quaternion::exp(magnus_step(Counted, curvatures(segment, &q, |_, _| Counted))));
        let composed = products(|| here.times(here));
        let [packs, nodes] = [segment.packs, segment.packs * LANES].map(|number| number as u64);
        Products {
            packs: packs * (step + products(|| here.normalised().rotation())),
            singles: (nodes + 1) * composed + step + products(|| here.normalised()),
        }
    }

    fn passage(segment: &SegmentPlan<Self>, from: f64, to: f64) -> Passage {
        let basis = magnus_basis(from, to, segment.turning.degrees).concat();
        Passage { step: (to - from) * segment.length, basis }
    }

    #[inline(always)]
    fn pass(segment: &SegmentPlan<Self>, q: &[f64], passage: &Passage) -> Self::Rotation<f64> {
        let degrees = segment.turning.degrees;
        let kappa = curvatures(segment, q, |point, k| passage.basis[point * degrees + k]);
        Quaternion::exp(magnus_step(passage.step, kappa)).rotation()
    }
}

/// The angle that a unit of each coordinate turns the rod by.
#[derive(Clone, Debug)]
pub(super) struct Angles<P> {
    /// Up to the nodes, for the reference strain and then by degree: entry `[degree * packs + pack]`.
    reference: Vec<P>,
    at_nodes: Vec<P>,
    /// Up to the end: Legendre polynomials beyond the first have no mean.
    at_end: f64,
}

impl<const FUSED: bool> Turning for Planar<FUSED> {
    type Orientation = f64;
    type Constants = Angles<Self::Pack>;

    fn start() -> f64 {
        0.0
    }

    fn matrix(angle: f64) -> PlaneRotation<f64> {
        PlaneRotation::by(angle)
    }

    fn constants(
        segment: &Segment,
        frame: Self::Frame,
        gauss: &Gauss,
        components: &[Component],
    ) -> Angles<Self::Pack> {
        let degrees = angular_degrees::<Self>(components);
        let nodes = gauss.nodes.len();
        let up_to: Vec<Vec<f64>> = gauss
            .nodes
            .iter()
            .map(|&x| {
                let mut values = vec![0.0; degrees];
                integrals(x, &mut values);
                values
            })
            .collect();
        let curvature = segment.reference_strain[frame.normal];
        Angles {
            reference: packed(nodes, |i| curvature * segment.length * gauss.nodes[i]),
            at_nodes: (0..degrees).flat_map(|k| packed(nodes, |i| segment.length * up_to[i][k])).collect(),
            at_end: segment.length,
        }
    }

    #[inline(always)]
    fn turn(
        segment: &SegmentPlan<Self>,
        q: &[f64],
        orientation: f64,
        rotations: &mut [PlaneRotation<Self::Pack>],
    ) -> f64 {
        let Angles { reference, at_nodes, at_end } = &segment.turning;
        let q = bend(segment).map_or(&[][..], |bend| &q[bend.first..][..bend.modes]);
        for (pack, rotation) in rotations.iter_mut().enumerate() {
            let mut angle = reference[pack] + Self::Pack::splat(orientation);
            for (k, &q) in q.iter().enumerate() {
                angle = at_nodes[k * segment.packs + pack].mul_add(Self::Pack::splat(q), angle);
            }
            *rotation = PlaneRotation::by(angle);
        }
        let mean = segment.reference_strain.angular.0 + q.first().copied().unwrap_or(0.0);
        orientation + at_end * mean
    }

    fn products_of_turn(segment: &SegmentPlan<Self>) -> Products {
        let modes = segment.components.iter().find(|component| component.index == 0).map_or(0, |c| c.modes);
        let turned = modes as u64 + products(|| PlaneRotation::by(Counted));
        Products { packs: segment.packs as u64 * turned, singles: 1 }
    }

    fn passage(segment: &SegmentPlan<Self>, from: f64, to: f64) -> Passage {
        let modes = bend(segment).map_or(0, |bend| bend.modes);
        let up_to = |x| {
            let mut values = vec![0.0; modes];
            integrals(x, &mut values);
            values
        };
        let basis =
            up_to(to).iter().zip(up_to(from)).map(|(to, from)| segment.length * (to - from)).collect();
        Passage { step: (to - from) * segment.length, basis }
    }

    #[inline(always)]
    fn pass(segment: &SegmentPlan<Self>, q: &[f64], passage: &Passage) -> PlaneRotation<f64> {
        let mut angle = segment.reference_strain.angular.0 * passage.step;
        if let Some(bend) = bend(segment) {
            for (q, integral) in q[bend.first..][..bend.modes].iter().zip(&passage.basis) {
                angle += q * integral;
            }
        }
        PlaneRotation::by(angle)
    }
}

/// Bending, if the segment has it.
fn bend<const FUSED: bool>(segment: &SegmentPlan<Planar<FUSED>>) -> Option<&Component> {
    segment.components.iter().find(|component| component.index == 0)
}
