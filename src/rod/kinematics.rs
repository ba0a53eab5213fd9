//! Where the rod is: rotations by Magnus steps, positions by integration.

use super::basis::legendre;
use super::plan::{Plan, SegmentPlan, magnus_points};
use super::workspace::Workspace;
use crate::lie::{LANES, Pack, Quaternion, Rotation, Scalar, Vector, weighted_sum};

/// A place of a rod in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Body axes in world coordinates.
    pub rotation: Rotation<f64>,
    /// Position in metres.
    pub position: Vector<f64>,
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

impl SegmentPlan {
    /// Curvature at the Magnus points; `basis(point, degree)` is the basis there.
    #[inline(always)]
    fn curvatures<T: Scalar>(&self, q: &[f64], basis: impl Fn(usize, usize) -> T) -> [Vector<T>; 3] {
        let [x, y, z, ..] = self.reference_strain.map(T::splat);
        let mut kappa = [[x, y, z]; 3];
        for component in self.components.iter().filter(|component| component.strain < 3) {
            for (k, &q) in q[component.first..][..component.modes].iter().enumerate() {
                for (point, kappa) in kappa.iter_mut().enumerate() {
                    kappa[component.strain] += basis(point, k) * q;
                }
            }
        }
        kappa.map(|[x, y, z]| Vector::new(x, y, z))
    }

    /// `sum_k phi_k q_k` of every strain at the nodes of one pack; components that do not exist are zero.
    #[inline(always)]
    pub(super) fn field(&self, q: &[f64], pack: usize) -> [Pack; 6] {
        let mut field = [Pack::ZERO; 6];
        for component in &self.components {
            for k in 0..component.modes {
                field[component.strain] += self.basis[k * self.packs + pack] * q[component.first + k];
            }
        }
        field
    }

    /// Derivative of the position along the rod at the nodes of one pack: `R gamma`.
    #[inline(always)]
    fn slope(&self, q: &[f64], pack: usize, rotation: &Rotation<Pack>) -> Vector<Pack> {
        if self.is_extensible {
            let field = self.field(q, pack);
            let gamma: [Pack; 3] =
                std::array::from_fn(|i| field[3 + i] + Pack::splat(self.reference_strain[3 + i]));
            rotation.apply(Vector::new(gamma[0], gamma[1], gamma[2]))
        } else {
            rotation.x
        }
    }
}

/// Rotations and positions of all nodes and stations for the coordinates `q`, unless they are there already.
#[inline(always)]
pub(super) fn update(plan: &Plan, work: &mut Workspace, q: &[f64]) {
    if work.kinematics_of == q {
        return;
    }
    work.kinematics_of.clear();
    work.kinematics_of.extend_from_slice(q);
    // Whatever was computed of the motion belongs to another shape.
    work.motion_of.fill(f64::NAN);
    for (s, segment) in plan.segments.iter().enumerate() {
        let packs = segment.packs;
        let rotation = &mut work.rotation[segment.node_packs()];
        let position = &mut work.position[segment.node_packs()];

        let mut orientation = work.stations[s].orientation;
        for pack in 0..packs {
            let basis =
                |point: usize, k: usize| segment.magnus_basis[(point * segment.degrees + k) * packs + pack];
            let step = Quaternion::exp(magnus_step(segment.steps[pack], segment.curvatures(q, basis)));
            let mut here = step;
            for lane in 0..LANES {
                orientation = orientation.times(step.lane(lane));
                here.set_lane(lane, orientation);
            }
            rotation[pack] = here.normalised().rotation();
        }
        let basis = |point: usize, k: usize| segment.last_magnus_basis[point * segment.degrees + k];
        let last = Quaternion::exp(magnus_step(segment.last_step, segment.curvatures(q, basis)));
        work.stations[s + 1].orientation = orientation.times(last).normalised();

        let slopes = &mut work.slope[segment.node_packs()];
        for pack in 0..packs {
            slopes[pack] = segment.slope(q, pack, &rotation[pack]);
        }
        let base = work.stations[s].position;
        let mut total = Vector::<Pack>::zero();
        for pack in 0..packs {
            let row = segment.row(&segment.from_base, pack);
            position[pack] = weighted_sum(Vector::splat(base.to_array()), row, slopes);
            total += slopes[pack] * segment.weights[pack];
        }
        work.stations[s + 1].position = base + total.sum();
    }
}

/// The pose at arc length `x` in [0, L], with the kinematics up to date.
pub(super) fn pose(plan: &Plan, work: &Workspace, q: &[f64], x: f64) -> Pose {
    let (mut s, mut start) = (0, 0.0);
    while s + 1 < plan.segments.len() && x > start + plan.segments[s].length {
        start += plan.segments[s].length;
        s += 1;
    }
    let segment = &plan.segments[s];
    // Rounding of the sum of lengths must not lead outside.
    let x = ((x - start) / segment.length).clamp(0.0, 1.0);
    let nodes = &segment.gauss.nodes;
    let before = nodes.partition_point(|&node| node <= x);

    // The rotation of the node before x, turned by one Magnus step.
    let (from, rotation) = match before {
        0 => (0.0, work.stations[s].orientation.rotation()),
        i => (nodes[i - 1], work.rotation[segment.first_pack + (i - 1) / LANES].lane((i - 1) % LANES)),
    };
    let mut values = vec![0.0; 3 * segment.degrees];
    for (point, values) in magnus_points().iter().zip(values.chunks_exact_mut(segment.degrees.max(1))) {
        legendre(from + point * (x - from), values);
    }
    let basis = |point: usize, k: usize| values[point * segment.degrees + k];
    let step = magnus_step((x - from) * segment.length, segment.curvatures(q, basis));
    let step = Quaternion::exp(step).rotation();
    let rotation =
        Rotation { x: rotation.apply(step.x), y: rotation.apply(step.y), z: rotation.apply(step.z) };

    let mut position = plan.base_position + work.stations[s].position;
    let slopes = &work.slope[segment.node_packs()];
    for (i, weight) in segment.gauss.weights_up_to(x).into_iter().enumerate() {
        position += slopes[i / LANES].lane(i % LANES) * (weight * segment.length);
    }
    Pose { rotation, position }
}
