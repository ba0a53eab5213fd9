//! A support compiled for computing. There are few of them: all is done in three dimensions, of which a plane takes its part.

use super::base::Base;
use super::kinematics;
use super::plan::Plan;
use super::points::PointState;
use super::response::{Linear, Response};
use super::support::Support;
use super::turning::Turning;
use super::workspace::Workspace;
use crate::lie::{Cross, Quaternion, Rotation, Symmetric, Twist, Vector, Wrench};

/// An anchor with its springs and dampers, in the frame of a base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    position: Vector<f64>,
    axes: Rotation<f64>,
    /// In the frame, which follows the base: zero where that rests.
    velocity: Vector<f64>,
    along_axes: AlongAxes,
    stiffness: Symmetric<f64>,
    damping: Symmetric<f64>,
    /// The factors c of the potential of rotation (see [`Support`]).
    turning: [f64; 3],
    rotational_damping: Symmetric<f64>,
    /// Moment and force that are taken for those of the springs.
    held: Option<[Vector<f64>; 2]>,
}

/// Moment and force of an anchor's springs, and their stiffness.
pub(super) struct Held {
    pub(super) forces: [Vector<f64>; 2],
    pub(super) stiffness: [Symmetric<f64>; 2],
    pub(super) energy: f64,
    /// Principal stiffnesses below these, smallest first, are not relied on: turned far, rotational springs soften, and push away in
    /// the end.
    pub(super) firm: [[f64; 3]; 2],
}

/// Rotational springs are relied on as long as they have this part of their stiffness at rest.
const FIRM: f64 = 0.1;

/// Parts of a stiffness below this part of the largest one are rounding.
const ROUNDING: f64 = 1e-12;

/// What a support has along and about the axes of its anchor.
#[derive(Clone, Copy, Debug)]
struct AlongAxes {
    stiffness: [f64; 3],
    damping: [f64; 3],
    rotational_damping: [f64; 3],
}

/// The section at a support, in three dimensions.
#[derive(Clone, Copy, Debug)]
struct Section {
    offset: Vector<f64>,
    axes: [Vector<f64>; 3],
    angular: Vector<f64>,
    velocity: Vector<f64>,
}

/// Compiles the supports of a rod, of which `at` says at which points of the plan they act, in the frame of the base at rest.
pub(super) fn compile<G: Turning>(plan: &Plan<G>, supports: &[Support], at: &[usize]) -> Vec<Anchor> {
    // Where the sections are when all coordinates are zero.
    let mut work = Workspace::new(plan);
    kinematics::update(plan, &mut work, &vec![0.0; plan.n]);
    let base = &plan.world.base.rotation;
    let in_frame = |v: Vector<f64>| base.apply_transposed(v);
    let compiled = |(support, &p): (&Support, &usize)| {
        let state = &work.points[p];
        let position = match support.position {
            Some(position) => in_frame(Vector::from(position) - plan.world.base.position),
            None => G::in_space(plan.frame, state.position),
        };
        let axes = match support.orientation {
            Some(orientation) => {
                let Rotation { x, y, z } = Quaternion::from_array(orientation).rotation();
                Rotation { x: in_frame(x), y: in_frame(y), z: in_frame(z) }
            }
            None => G::rotation_in_space(plan.frame, &state.rotation),
        };
        let [x, y, z] = support.rotational_stiffness.map(|stiffness| 0.5 * stiffness);
        let turning = [y + z - x, z + x - y, x + y - z];
        let &Support { stiffness, damping, rotational_damping, .. } = support;
        Anchor::new(position, axes, turning, AlongAxes { stiffness, damping, rotational_damping })
    };
    supports.iter().zip(at).map(compiled).collect()
}

impl Anchor {
    fn new(position: Vector<f64>, axes: Rotation<f64>, turning: [f64; 3], along_axes: AlongAxes) -> Self {
        let about = |diagonal: [f64; 3]| {
            let mut sum = Symmetric::diagonal(0.0);
            for (i, value) in diagonal.into_iter().enumerate() {
                sum += Symmetric::square(axes.axis(i)) * value;
            }
            sum
        };
        Self {
            stiffness: about(along_axes.stiffness),
            damping: about(along_axes.damping),
            rotational_damping: about(along_axes.rotational_damping),
            velocity: Vector::from([0.0; 3]),
            position,
            axes,
            turning,
            along_axes,
            held: None,
        }
    }

    /// Takes moment and force for those of the springs, whatever the section does, until it gets none.
    pub(super) fn hold(&mut self, forces: Option<[Vector<f64>; 2]>) {
        self.held = forces;
    }

    /// An anchor in the frame of the base at rest as it is seen from where the base is now.
    pub(super) fn seen_from(&self, base: &Base, at_rest: &Base) -> Self {
        let turned = |v: Vector<f64>| base.rotation.apply_transposed(at_rest.rotation.apply(v));
        let to_anchor = at_rest.position - base.position;
        let position = base.rotation.apply_transposed(to_anchor) + turned(self.position);
        let Rotation { x, y, z } = self.axes;
        let axes = Rotation { x: turned(x), y: turned(y), z: turned(z) };
        let velocity = -base.rotation.apply_transposed(base.velocity);
        Self { velocity, ..Self::new(position, axes, self.turning, self.along_axes) }
    }

    pub(super) fn is_damped(&self) -> bool {
        let none = Symmetric::diagonal(0.0);
        self.damping != none || self.rotational_damping != none
    }

    fn section<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> Section {
        let Twist { angular, linear } = state.velocity;
        let Rotation { x, y, z } = G::rotation_in_space(frame, &state.rotation);
        Section {
            offset: G::in_space(frame, state.position) - self.position,
            axes: [x, y, z],
            angular: G::axial_in_space(frame, angular),
            velocity: G::in_space(frame, linear + angular.cross(state.position)),
        }
    }

    /// Moment and force of the springs on the section.
    fn elastic(&self, section: &Section) -> [Vector<f64>; 2] {
        let mut moment = Vector::zero();
        for (i, axis) in section.axes.into_iter().enumerate() {
            moment += axis.cross(self.axes.axis(i)) * self.turning[i];
        }
        [moment, -self.stiffness.times(section.offset)]
    }

    /// Moment and force on the section.
    fn moment_and_force(&self, section: &Section) -> [Vector<f64>; 2] {
        let [moment, force] = self.held.unwrap_or_else(|| self.elastic(section));
        let velocity = section.velocity - self.velocity;
        [moment - self.rotational_damping.times(section.angular), force - self.damping.times(velocity)]
    }

    /// The springs at a section. A turn by theta changes the moment m by `-H theta + theta x m / 2`, with the Hessian
    /// `H = sum_i c_i ((a_i . e_i) 1 - (a_i e_i^T + e_i a_i^T) / 2)`.
    pub(super) fn springs<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> Held {
        let section = self.section(frame, state);
        let mut hessian = Symmetric::diagonal(0.0);
        for (i, axis) in section.axes.into_iter().enumerate() {
            let to = self.axes.axis(i);
            hessian +=
                (Symmetric::diagonal(to.dot(axis)) - Symmetric::product(to, axis) * 0.5) * self.turning[i];
        }
        let [x, y, z] = self.turning;
        let firm = |[x, y, z]: [f64; 3], part: f64| {
            let rounding = ROUNDING * x.max(y).max(z);
            let mut firm = [x, y, z].map(|stiffness| (part * stiffness).max(rounding));
            firm.sort_by(f64::total_cmp);
            firm
        };
        Held {
            forces: self.elastic(&section),
            stiffness: [hessian, self.stiffness],
            energy: self.energy(frame, state),
            firm: [firm([y + z, z + x, x + y], FIRM), firm(self.along_axes.stiffness, 0.0)],
        }
    }

    /// The wrench on the section, about its centre.
    #[inline(always)]
    pub(super) fn wrench<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> Wrench<G, f64> {
        let [moment, force] = self.moment_and_force(&self.section(frame, state));
        Wrench { moment: G::axial_of(frame, moment), force: G::vector_of(frame, force) }
    }

    /// How what the section needs against it changes: the force f by `delta f - theta x f` for a turn by theta, as it is seen from
    /// the turning material, and the moment likewise.
    #[inline(always)]
    pub(super) fn response<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> Response<G, f64> {
        let section = self.section(frame, state);
        let [moment, force] = self.moment_and_force(&section);
        let about_origin = |moment: Vector<f64>, force: Vector<f64>| {
            let need = Wrench { moment: G::axial_of(frame, -moment), force: G::vector_of(frame, -force) };
            need.at(state.position)
        };
        let local = |twist: Twist<G, f64>| {
            let linear = twist.linear + twist.angular.cross(state.position);
            [G::axial_in_space(frame, twist.angular), G::in_space(frame, linear)]
        };
        Response {
            stiffness: Linear::of(|displacement| {
                let [turn, shift] = local(displacement);
                let mut turned = -self.rotational_damping.times(turn.cross(section.angular));
                let mut shifted = -self.damping.times(turn.cross(section.velocity));
                match self.held {
                    // Half of what keeps its direction and half of what follows together have a potential, as those of springs have.
                    Some([moment, _]) => turned += turn.cross(moment) * 0.5,
                    None => {
                        for (i, axis) in section.axes.into_iter().enumerate() {
                            turned += turn.cross(axis).cross(self.axes.axis(i)) * self.turning[i];
                        }
                        shifted += -self.stiffness.times(shift);
                    }
                }
                about_origin(turned - turn.cross(moment), shifted - turn.cross(force))
            }),
            damping: Linear::of(|y| {
                let [angular, velocity] = local(y);
                about_origin(-self.rotational_damping.times(angular), -self.damping.times(velocity))
            }),
            inertia: Linear::zero(),
        }
    }

    /// Potential energy of the springs.
    pub(super) fn energy<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> f64 {
        let section = self.section(frame, state);
        let mut energy = 0.5 * section.offset.dot(self.stiffness.times(section.offset));
        for (i, axis) in section.axes.into_iter().enumerate() {
            // 1 - a . e without cancellation, of unit vectors.
            let chord = axis - self.axes.axis(i);
            energy += 0.5 * self.turning[i] * chord.dot(chord);
        }
        energy
    }

    /// Power that the dampers take out of the motion.
    pub(super) fn dissipated_power<G: Turning>(&self, frame: G::Frame, state: &PointState<G>) -> f64 {
        let Section { angular, velocity, .. } = self.section(frame, state);
        let velocity = velocity - self.velocity;
        velocity.dot(self.damping.times(velocity)) + angular.dot(self.rotational_damping.times(angular))
    }
}
