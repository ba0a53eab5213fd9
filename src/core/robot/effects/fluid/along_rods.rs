//! Drag and added mass of the fluid around a rod, at the nodes. Buoyancy is a distributed dead load.
//!
//! With the current U = (0; u), uniform and steady in the frame at every time, the twist of a section
//! relative to the fluid is `V_r = V - U`. Its drag is a force -h at the section. The added mass has the
//! momentum `N_a V_r`, where `N_a` is about the origin like the inertia N, but has mass only perpendicular to
//! the axis. Kirchhoff's equations hold in the frame that moves with the current; transformed back to the
//! frame of the rod, the section requires
//!
//! ```text
//! N_a (A_k + ad_V U) - ad_{V_r}^T N_a V_r,    A_k = A + (0; g), the acceleration without gravity
//! ```
//!
//! The energy is `1/2 V . N_a V - 1/2 U . N_a U` with the velocities in the world. The second term is a
//! potential that rotates rods perpendicular to the current.
//!
//! Relative to the moving material (see `tangent`), with Psi for `w_q Psi`, V_r varies by
//! `Y_r = Y + ad_Psi U` and A_k by `Z - ad_V Y - ad_Psi (0; g)`.

use crate::model::Energy;
use crate::numerics::lie::{Cross, Geometry, Lanes, Scalar, Twist, VectorSpace, Wrench};
use crate::robot::algebra::response::{Linear, Response};
use crate::robot::effects::fluid::plan::{Drag, Immersion};
use crate::robot::effects::kinds::{
    Dissipation, LineResponse, LineWrench, NoCoordinateForce, NoDeadLineWrench, NoPartialWrench, NotAtPoints,
    StoredEnergy, Supply, VelocityDependence,
};
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Fluid and pose at a section.
#[derive(Clone, Copy, Debug)]
struct Stream<G: Geometry, T: Scalar> {
    axis: G::Vector<T>,
    position: G::Vector<T>,
    current: G::Vector<T>,
    crossing: T,
}

/// Relative velocity perpendicular to the axis and along it, with both speeds.
#[derive(Clone, Copy, Debug)]
struct Relative<G: Geometry, T: Scalar> {
    across: G::Vector<T>,
    along: T,
    /// Speeds, never zero, so that the quotient with a zero velocity is zero.
    speeds: [T; 2],
}

/// Motion relative to the fluid, with the momentum of the added mass.
struct Moving<'a, G: Geometry, T: Scalar> {
    mass: T,
    drag: &'a Drag<T>,
    twist: Twist<G, T>,
    momentum: Wrench<G, T>,
    relative: Relative<G, T>,
}

impl<T: Scalar> Drag<T> {
    fn weighted(&self, weight: T) -> Self {
        Self { viscous: self.viscous.map(|c| c * weight), quadratic: self.quadratic.map(|c| c * weight) }
    }

    /// Drag over velocity, perpendicular to the axis and along it.
    #[inline(always)]
    fn factors<G: Geometry>(&self, relative: &Relative<G, T>) -> [T; 2] {
        let factor = |i: usize| self.quadratic[i].mul_add(relative.speeds[i], self.viscous[i]);
        [factor(0), factor(1)]
    }

    /// h, minus the drag.
    #[inline(always)]
    fn force<G: Geometry>(&self, stream: &Stream<G, T>, relative: &Relative<G, T>) -> G::Vector<T> {
        let [across, along] = self.factors(relative);
        (relative.across * across).add_scaled(stream.axis, relative.along * along)
    }

    /// Change of h with the relative velocity.
    #[inline(always)]
    fn change<G: Geometry>(
        &self,
        stream: &Stream<G, T>,
        relative: &Relative<G, T>,
        change: G::Vector<T>,
    ) -> G::Vector<T> {
        let [across, along] = self.factors(relative);
        let of_along = stream.axis.dot(change);
        let of_across = change.add_scaled(stream.axis, -of_along);
        // |v| v is differentiable everywhere, including at rest: |v| w + v (v . w) / |v|.
        let of_speed = relative.across.dot(of_across) * relative.speeds[0].reciprocal();
        let stiffer = along + self.quadratic[1] * relative.speeds[1];
        (of_across * across)
            .add_scaled(relative.across, self.quadratic[0] * of_speed)
            .add_scaled(stream.axis, of_along * stiffer)
    }
}

impl<G: Geometry, T: Scalar> Stream<G, T> {
    #[inline(always)]
    fn translation(linear: G::Vector<T>) -> Twist<G, T> {
        Twist { angular: VectorSpace::zero(), linear }
    }

    #[inline(always)]
    fn current(&self) -> Twist<G, T> {
        Self::translation(self.current)
    }

    /// Velocity of the section's centre.
    #[inline(always)]
    fn velocity(&self, twist: Twist<G, T>) -> G::Vector<T> {
        twist.angular.cross_add(self.position, twist.linear)
    }

    #[inline(always)]
    fn relative(&self, twist: Twist<G, T>) -> Relative<G, T> {
        let velocity = self.velocity(twist) - self.current;
        let along = self.axis.dot(velocity);
        let across = velocity.add_scaled(self.axis, -along);
        let least = T::splat(f64::MIN_POSITIVE);
        let speeds = [across.dot_add(across, self.crossing + least), along.mul_add(along, least)];
        Relative { across, along, speeds: speeds.map(Scalar::sqrt) }
    }

    /// `N_a` times a twist.
    #[inline(always)]
    fn added_momentum(&self, mass: T, twist: Twist<G, T>) -> Wrench<G, T> {
        let velocity = self.velocity(twist);
        let across = velocity.add_scaled(self.axis, -self.axis.dot(velocity));
        self.at_section(across * mass)
    }

    #[inline(always)]
    fn at_section(&self, force: G::Vector<T>) -> Wrench<G, T> {
        Wrench { moment: VectorSpace::zero(), force }.at(self.position)
    }

    /// Wrench required by the added mass in a motion, for the acceleration minus gravity.
    #[inline(always)]
    fn added_force(
        &self,
        mass: T,
        gravity: G::Vector<T>,
        velocity: Twist<G, T>,
        acceleration: Twist<G, T>,
    ) -> Wrench<G, T> {
        let relative = velocity - self.current();
        let linear = velocity.angular.cross_add(self.current, acceleration.linear + gravity);
        let felt = Twist { angular: acceleration.angular, linear };
        self.added_momentum(mass, felt) - relative.bracket_transposed(self.added_momentum(mass, relative))
    }

    /// Wrench required to overcome the drag.
    #[inline(always)]
    fn drag_force(&self, drag: &Drag<T>, velocity: Twist<G, T>) -> Wrench<G, T> {
        self.at_section(drag.force(self, &self.relative(velocity)))
    }

    /// Response of added mass and drag.
    #[inline(always)]
    fn response(
        &self,
        mass: T,
        drag: &Drag<T>,
        gravity: G::Vector<T>,
        velocity: Twist<G, T>,
    ) -> Response<G, T> {
        let current = self.current();
        let relative = velocity - current;
        let moving = Moving {
            mass,
            drag,
            twist: relative,
            momentum: self.added_momentum(mass, relative),
            relative: self.relative(velocity),
        };
        Response {
            stiffness: Linear::of(|displacement| {
                let turn: G::Axial<T> = displacement.angular;
                let turned = |v: G::Vector<T>| Self::translation(turn.cross(v));
                let motion = turned(self.current);
                self.change(&moving, motion, -turned(gravity) - velocity.bracket(motion))
            }),
            damping: Linear::of(|y| self.change(&moving, y, -(velocity + current).bracket(y))),
            inertia: self.inertia(mass),
        }
    }

    /// Change of the required wrench for changes of V_r, and of A_k + ad_V U. (As a closure it stays a call, without the instructions of
    /// the sweep.)
    #[inline(always)]
    fn change(&self, moving: &Moving<'_, G, T>, motion: Twist<G, T>, felt: Twist<G, T>) -> Wrench<G, T> {
        let &Moving { mass, drag, twist, momentum, ref relative } = moving;
        let added = self.added_momentum(mass, felt)
            - motion.bracket_transposed(momentum)
            - twist.bracket_transposed(self.added_momentum(mass, motion));
        added + self.at_section(drag.change(self, relative, self.velocity(motion)))
    }

    #[inline(always)]
    fn inertia(&self, mass: T) -> Linear<G, T> {
        Linear::of(|z| self.added_momentum(mass, z))
    }
}

/// Fluid and poses at a pack of nodes.
#[inline(always)]
fn stream<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, node: usize) -> Stream<G, G::Pack> {
    Stream {
        axis: G::rod_axis(plan.frame, &work.rotation[node]),
        position: work.position[node],
        current: splat::<G>(work.surroundings.current),
        crossing: G::Pack::splat(work.surroundings.crossing),
    }
}

#[inline(always)]
fn splat<G: Geometry>(v: G::Vector<f64>) -> G::Vector<G::Pack> {
    G::map_vector(&v, |&x| G::Pack::splat(x))
}

/// Energy and power of the fluid, with the motion up to date.
#[derive(Clone, Copy, Debug, Default)]
struct EnergyAndPower {
    /// Kinetic energy of the added mass, and its potential in the current.
    kinetic: f64,
    potential: f64,
    /// Power dissipated by drag in the motion relative to the fluid, and power supplied by the current.
    dissipated: f64,
    supplied: f64,
}

fn exchange<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> EnergyAndPower {
    let mut sum = EnergyAndPower::default();
    let frame = splat::<G>(work.surroundings.velocity);
    for piece in &plan.pieces {
        let Some(immersed) = &piece.immersed else { continue };
        for pack in 0..piece.packs {
            let node = piece.first_pack + pack;
            let weight = piece.weights[pack];
            let stream = stream(plan, work, node);
            let twist = work.velocity[node];
            let half_mass = immersed.added_mass[pack] * weight * 0.5;
            let across = |v: G::Vector<G::Pack>| v.add_scaled(stream.axis, -stream.axis.dot(v));
            let [velocity, current] = [stream.velocity(twist), stream.current].map(|v| v + frame);
            let [moving, streaming] = [velocity, current].map(across);
            sum.kinetic += (moving.dot(moving) * half_mass).sum();
            sum.potential -= (streaming.dot_add(streaming, stream.crossing) * half_mass).sum();
            let relative = stream.relative(twist);
            let drag = immersed.drag[pack].weighted(weight);
            let force = drag.force(&stream, &relative);
            let crossing = drag.factors(&relative)[0] * stream.crossing;
            let supplied = crossing - force.dot(current);
            sum.supplied += supplied.sum();
            sum.dissipated += (force.dot(velocity) + supplied).sum();
        }
    }
    sum
}

/// The fluid around a robot.
pub(crate) struct FluidAround;

impl<G: Turning> LineWrench<G> for FluidAround {
    #[inline(always)]
    fn acts_along(_: &Plan<G>, piece: &PiecePlan<G>) -> bool {
        piece.immersed.is_some()
    }

    #[inline(always)]
    fn act_along(plan: &Plan<G>, piece: &PiecePlan<G>, work: &mut Workspace<G>) {
        let (Some(immersion), Some(immersed)) = (&plan.effects.immersion, &piece.immersed) else { return };
        for pack in 0..piece.packs {
            let node = piece.first_pack + pack;
            let stream = stream(plan, work, node);
            let velocity = work.velocity[node];
            if immersion.has_added_mass {
                let mass = immersed.added_mass[pack];
                let gravity = splat::<G>(work.surroundings.gravity);
                work.force[node] += stream.added_force(mass, gravity, velocity, work.acceleration[node]);
            }
            if immersion.has_drag {
                work.force[node] += stream.drag_force(&immersed.drag[pack], velocity);
            }
        }
    }
}

impl<G: Turning> LineResponse<G> for FluidAround {
    #[inline(always)]
    fn responds_along(piece: &PiecePlan<G>) -> bool {
        piece.immersed.is_some()
    }

    #[inline(always)]
    fn respond_along(
        plan: &Plan<G>,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        is_mass_only: bool,
        sums: &mut [Response<G, G::Pack>],
    ) {
        let Some(immersed) = &piece.immersed else { return };
        let gravity = splat::<G>(work.surroundings.gravity);
        for (pack, sum) in sums.iter_mut().enumerate() {
            let node = piece.first_pack + pack;
            let weight = piece.weights[pack];
            let stream = stream(plan, work, node);
            let mass = immersed.added_mass[pack] * weight;
            if is_mass_only {
                sum.inertia.add(stream.inertia(mass));
            } else {
                let drag = immersed.drag[pack].weighted(weight);
                sum.add(stream.response(mass, &drag, gravity, work.velocity[node]));
            }
        }
    }
}

impl<G: Turning> StoredEnergy<G> for FluidAround {
    fn add_energy(plan: &Plan<G>, work: &Workspace<G>, energy: &mut Energy) {
        let exchange = exchange(plan, work);
        energy.kinetic += exchange.kinetic;
        energy.loads += exchange.potential;
    }
}

impl<G: Turning> Dissipation<G> for FluidAround {
    fn dissipates(plan: &Plan<G>) -> bool {
        plan.effects.immersion.is_some_and(|fluid| fluid.has_drag)
    }

    fn dissipated_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        exchange(plan, work).dissipated
    }
}

impl<G: Turning> Supply<G> for FluidAround {
    fn drives(plan: &Plan<G>) -> bool {
        plan.effects.immersion.is_some_and(|fluid| fluid.has_drag && plan.world.has_current())
    }

    fn supplied_power(plan: &Plan<G>, work: &Workspace<G>) -> f64 {
        exchange(plan, work).supplied
    }
}

impl<G: Turning> VelocityDependence<G> for FluidAround {
    fn depends_on_velocity(plan: &Plan<G>) -> bool {
        let flows = |fluid: Immersion| fluid.has_drag || (fluid.has_added_mass && plan.world.has_current());
        plan.effects.immersion.is_some_and(flows)
    }
}

impl NotAtPoints for FluidAround {}
impl NoPartialWrench for FluidAround {}
impl NoDeadLineWrench for FluidAround {}
impl NoCoordinateForce for FluidAround {}
