//! Rotations in space, by Magnus steps.

use super::{Turning, angular_degrees, integrals_between};
use crate::description::rod::Gauss;
use crate::description::rod::piece::Piece;
use crate::numerics::lie::{Geometry, LANES, Pack, Quaternion, Rotation, Scalar, Spatial, Vector};
use crate::robot::plan::material::Component;
use crate::robot::plan::packed;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::space::{MagnusSteps, Passage};

/// Offsets of the three Gauss points of a Magnus step of order six (Blanes, Casas, Oteo and Ros 2009, section 5.4).
fn magnus_points() -> [f64; 3] {
    let offset = 15f64.sqrt() / 10.0;
    [0.5 - offset, 0.5, 0.5 + offset]
}

/// Weights of these points.
const MAGNUS_WEIGHTS: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

/// Values of functions at the Gauss points of a Magnus step, by point, from their values at a place and their
/// integrals between two places. Values at the midpoint are chosen such that the Gauss sum equals the exact
/// integral over the step: a rod that bends about one axis then has the exact rotation for any function.
fn at_magnus_points(
    [from, to]: [f64; 2],
    values: impl Fn(f64) -> Vec<f64>,
    integrals: impl Fn(f64, f64) -> Vec<f64>,
) -> [Vec<f64>; 3] {
    let mut points = magnus_points().map(|point| values(from + point * (to - from)));
    if to > from {
        for (k, integral) in integrals(from, to).into_iter().enumerate() {
            let mean = integral / (to - from);
            let others = MAGNUS_WEIGHTS[0] * points[0][k] + MAGNUS_WEIGHTS[2] * points[2][k];
            points[1][k] = (mean - others) / MAGNUS_WEIGHTS[1];
        }
    }
    points
}

/// Basis functions at the points of a Magnus step.
fn magnus_basis(piece: &Piece, step: [f64; 2], degrees: usize) -> [Vec<f64>; 3] {
    let values = |x| {
        let mut values = vec![0.0; degrees];
        piece.basis.values(x, &mut values);
        values
    };
    at_magnus_points(step, values, |from, to| integrals_between(piece, from, to, degrees))
}

/// Reference curvature at the points of a Magnus step; a single value if it is constant.
fn magnus_reference(piece: &Piece, step: [f64; 2]) -> [Vec<f64>; 3] {
    if piece.segment.reference_strain.constant().is_some() {
        return std::array::from_fn(|_| piece.reference(0.0)[..3].to_vec());
    }
    at_magnus_points(
        step,
        |x| piece.reference(x)[..3].to_vec(),
        |from, to| piece.reference_between(from, to)[..3].to_vec(),
    )
}

/// Rotation vector of a step of length `h` of R' = R [kappa], from kappa at the Gauss points of
/// [`magnus_points`]: Magnus expansion of order six (Blanes, Casas, Oteo and Ros 2009, eq. 253). Their
/// equation is Y' = A Y; here A is on the right, which changes the sign of every bracket.
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

/// Curvature at the Magnus points from the basis `basis(point, degree)` and the reference curvature
/// `reference(point)`.
#[inline(always)]
fn curvatures<const FUSED: bool, T: Scalar>(
    piece: &PiecePlan<Spatial<FUSED>>,
    q: &[f64],
    basis: impl Fn(usize, usize) -> T,
    reference: impl Fn(usize) -> Vector<T>,
) -> [Vector<T>; 3] {
    let mut kappa = [reference(0), reference(1), reference(2)];
    for component in piece.components.iter().filter(|component| component.index < Spatial::<FUSED>::ANGULAR) {
        for (k, &q) in q[component.first..][..component.modes].iter().enumerate() {
            for (point, kappa) in kappa.iter_mut().enumerate() {
                let entry = kappa.component_mut(component.index);
                *entry = basis(point, k).mul_add(T::splat(q), *entry);
            }
        }
    }
    kappa
}

/// Vector of a point stored as `[point * 3 + axis]`.
#[inline(always)]
fn vector_at(values: &[f64], point: usize) -> Vector<f64> {
    Vector { x: values[3 * point], y: values[3 * point + 1], z: values[3 * point + 2] }
}

/// Rotations at the nodes of a piece that begins with `orientation`, given its reference curvature by point
/// and pack; returns the orientation at the last node.
#[inline(always)]
fn turn_steps<const FUSED: bool>(
    piece: &PiecePlan<Spatial<FUSED>>,
    q: &[f64],
    mut orientation: Quaternion<f64>,
    rotations: &mut [Rotation<Pack<FUSED>>],
    reference: impl Fn(usize, usize) -> Vector<Pack<FUSED>>,
) -> Quaternion<f64> {
    let magnus = &piece.turning;
    for (pack, rotation) in rotations.iter_mut().enumerate() {
        let basis = |point: usize, k: usize| magnus.basis[(point * magnus.degrees + k) * piece.packs + pack];
        let kappa = curvatures(piece, q, basis, |point| reference(point, pack));
        let step = Quaternion::exp(magnus_step(magnus.steps[pack], kappa));
        let mut here = step;
        for lane in 0..LANES {
            orientation = orientation.times(step.lane(lane));
            here.set_lane(lane, orientation);
        }
        *rotation = here.normalised().rotation();
    }
    orientation
}

impl<const FUSED: bool> Turning for Spatial<FUSED> {
    fn constants(piece: &Piece, (): (), gauss: &Gauss, components: &[Component]) -> MagnusSteps<Self::Pack> {
        let degrees = angular_degrees::<Self>(components);
        let nodes = gauss.nodes.len();
        let start = |i: usize| if i == 0 { 0.0 } else { gauss.nodes[i - 1] };
        let last = gauss.nodes[nodes - 1];
        let packed_by_point = |values: Vec<[Vec<f64>; 3]>, number: usize| {
            let mut all = Vec::with_capacity(3 * number * nodes / LANES);
            for point in 0..3 {
                for k in 0..number {
                    all.extend(packed::<Self::Pack>(nodes, |i| values[i][point][k]));
                }
            }
            all
        };
        let steps = || (0..nodes).map(|i| [start(i), gauss.nodes[i]]);
        let is_constant = piece.segment.reference_strain.constant().is_some();
        let reference = if is_constant {
            Vec::new()
        } else {
            packed_by_point(steps().map(|step| magnus_reference(piece, step)).collect(), 3)
        };
        let [x, y, z, ..] = piece.reference(0.0);
        MagnusSteps {
            steps: packed(nodes, |i| piece.length() * (gauss.nodes[i] - start(i))),
            basis: packed_by_point(steps().map(|step| magnus_basis(piece, step, degrees)).collect(), degrees),
            reference,
            constant_reference: [x, y, z].into(),
            last_step: piece.length() * (1.0 - last),
            last_basis: magnus_basis(piece, [last, 1.0], degrees).concat(),
            last_reference: magnus_reference(piece, [last, 1.0]).concat(),
            degrees,
        }
    }

    #[inline(always)]
    fn turn(
        piece: &PiecePlan<Self>,
        q: &[f64],
        orientation: Quaternion<f64>,
        rotations: &mut [Self::Rotation<Self::Pack>],
    ) -> Quaternion<f64> {
        let magnus = &piece.turning;
        let orientation = if magnus.reference.is_empty() {
            let reference = Vector::splat(magnus.constant_reference.to_array());
            turn_steps(piece, q, orientation, rotations, |_, _| reference)
        } else {
            let packs = piece.packs;
            turn_steps(piece, q, orientation, rotations, |point, pack| {
                let axis = |axis: usize| magnus.reference[(point * 3 + axis) * packs + pack];
                Vector { x: axis(0), y: axis(1), z: axis(2) }
            })
        };
        let basis = |point: usize, k: usize| magnus.last_basis[point * magnus.degrees + k];
        let kappa = curvatures(piece, q, basis, |point| vector_at(&magnus.last_reference, point));
        let last = Quaternion::exp(magnus_step(magnus.last_step, kappa));
        orientation.times(last).normalised()
    }

    fn passage(piece: &PiecePlan<Self>, from: f64, to: f64) -> Passage {
        let source = piece.part();
        Passage {
            step: (to - from) * piece.length,
            basis: magnus_basis(source, [from, to], piece.turning.degrees).concat(),
            reference: magnus_reference(source, [from, to]).concat(),
        }
    }

    #[inline(always)]
    fn pass(piece: &PiecePlan<Self>, q: &[f64], passage: &Passage) -> Self::Rotation<f64> {
        let degrees = piece.turning.degrees;
        let basis = |point: usize, k: usize| passage.basis[point * degrees + k];
        let kappa = curvatures(piece, q, basis, |point| vector_at(&passage.reference, point));
        Quaternion::exp(magnus_step(passage.step, kappa)).rotation()
    }
}
