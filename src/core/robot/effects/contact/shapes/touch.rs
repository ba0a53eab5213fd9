//! Pressure and friction of two overlapping surfaces, and their derivatives.
//!
//! With the overlap d, its rate d', a stiffness k and a dissipation c the normal force is `f = k d max(0, 1 +
//! c d')` (Hunt and Crossley 1975, eq. 13, with the exponent 1 of a foundation). Friction opposes the sliding
//! velocity v of the surfaces, `-f (mu_s v + (mu_l - mu_s) (v . e) e) / sqrt(|v|^2 + v_s^2)`, with the
//! coefficients mu_s sideways and mu_l along the direction e of the first surface, and the regularisation
//! velocity v_s. At rest friction may be larger, and falls to that with the speed of sliding: it has the factor
//! `1 + a exp(-(|v| / v_st)^2)` (Bo and Pavelescu 1982), with a such that its largest value is that of static friction. On a patch of radius r friction also opposes the spin w of the surfaces about the normal,
//! with the moment `-f mu_s r w / sqrt(w^2 + (v_s/r)^2)`, with that factor at the speed r w.
//!
//! The second side may be a moving solid. Let `g(x)` be the distance of the point x from the solid, u the
//! velocity of the first side's material at x, `U(x)` that of the solid there, and W its angular velocity.
//! Then
//!
//! ```text
//! d = r - g,   n = grad g,   d' = -n . (u - U(x)),   dn = dW x n + H w,   H = grad grad g,
//! ```
//!
//! where `dW` is the rotation of the solid, and w the displacement of the first side relative to the solid's
//! material at x. Both forces act at the same point, `x - r n`, so that they are frame indifferent and add no
//! moment. The centre of the second side is the solid's material point at x. Since w moves x away from this
//! material point, the arm from there changes by `d(-r n) + w`, and the velocity relative to the rotating
//! normal by `dU + W x w`.

use super::ellipse::Rolling;
use crate::numerics::lie::{Scalar, Symmetric, Vector};
use crate::robot::algebra::tie::Motion;

/// The material constants of a contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    pub(crate) stiffness: f64,
    pub(crate) dissipation: f64,
    /// Coefficients of friction forward, backward and sideways.
    pub(crate) friction: [f64; 3],
    pub(crate) slip_velocity: f64,
    /// Excess a of static friction; see [`excess_at_rest`].
    pub(crate) excess: f64,
    /// Velocity v_st over which static friction falls to that of sliding; infinite without an excess.
    pub(crate) stribeck_velocity: f64,
    /// Radius of the patch for friction against spinning.
    pub(crate) patch_radius: f64,
}

/// The excess a with which the largest friction, of all speeds, is `ratio` times that of fast sliding, where the velocity v_st is `velocities` times
/// v_s: with `h(v) = v / sqrt(v^2 + 1)` the least of `(ratio / h(v) - 1) exp((v / velocities)^2)`.
pub(crate) fn excess_at_rest(ratio: f64, velocities: f64) -> f64 {
    /// Number of golden-section steps in the logarithm of the speed; the error of the minimum is the square of that of its place.
    const SECTIONS: usize = 60;
    let needed = |x: f64| {
        let v = x.exp();
        (ratio * (v * v + 1.0).sqrt() / v - 1.0) * (v / velocities).powi(2).exp()
    };
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    // The minimum lies between speeds at which one factor rises far more than the other falls.
    let (mut from, mut to) = (0.0_f64.min(velocities.ln() - 1.0), velocities.ln() + 1.0);
    let [mut a, mut b] = [to - golden * (to - from), from + golden * (to - from)];
    let [mut at_a, mut at_b] = [needed(a), needed(b)];
    for _ in 0..SECTIONS {
        if at_a < at_b {
            (to, b, at_b) = (b, a, at_a);
            a = to - golden * (to - from);
            at_a = needed(a);
        } else {
            (from, a, at_a) = (a, b, at_b);
            b = from + golden * (to - from);
            at_b = needed(b);
        }
    }
    at_a.min(at_b)
}

impl Law {
    /// Factor of friction at the square of a speed, and minus the derivative of its logarithm with respect to half of that square.
    #[inline(always)]
    fn at_rest(&self, square: f64) -> [f64; 2] {
        if self.excess == 0.0 {
            return [1.0, 0.0];
        }
        let per_square = (self.stribeck_velocity * self.stribeck_velocity).recip();
        let more = self.excess * (-square * per_square).exp();
        [1.0 + more, 2.0 * per_square * more / (1.0 + more)]
    }

    /// Whether friction is isotropic.
    pub(crate) fn is_even(&self) -> bool {
        let [forward, backward, sideways] = self.friction;
        forward == backward && forward == sideways
    }
}

/// Two overlapping sides, in space and the frame of the plan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactPoint {
    pub(crate) law: Law,
    /// Fraction of the stiffness at this point.
    pub(crate) weight: f64,
    /// Overlap, > 0.
    pub(crate) overlap: f64,
    /// Normal from the second side to the first, and its derivative with respect to the relative displacement
    /// of the centres.
    pub(crate) normal: Vector<f64>,
    pub(crate) curvature: Symmetric<f64>,
    /// Distances from the centres to the surfaces.
    pub(crate) radii: [f64; 2],
    /// Whether the second side is a solid that rotates the normal with it; its centre then coincides with
    /// that of the first side.
    pub(crate) is_carried: bool,
    /// Motion of the contact point along the edge of a section that is not round; the contact point is then
    /// the first centre.
    pub(crate) rolling: Option<Rolling>,
    /// Smallest distance of the first surface from the middle of its section.
    pub(crate) thickness: f64,
    /// Angular velocities, and velocities of the centres.
    pub(crate) motions: [Motion; 2],
    /// Direction along the first side.
    pub(crate) axis: Vector<f64>,
    /// The normal force by which friction is multiplied, in place of the one that acts.
    pub(crate) held: Option<f64>,
}

/// Contact forces between the sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactForce {
    /// Normal force, and its conservative part.
    pub(crate) normal_force: f64,
    elastic: f64,
    /// Rate of the distance, and sliding velocity of the first surface over the second.
    pub(crate) rate: f64,
    pub(crate) sliding: Vector<f64>,
    /// Friction on the first side, and friction per unit normal force on the second.
    pub(crate) friction: Vector<f64>,
    pub(crate) friction_ratio: Vector<f64>,
    /// Friction at unit regularised speed.
    direction: Vector<f64>,
    /// Direction along the first side in the plane of contact; the velocity along it, and the coefficient of
    /// friction for that sign.
    along: Vector<f64>,
    inverse_along: f64,
    of_along: [f64; 3],
    /// Reciprocal of the regularised speed, times the factor of static friction; and minus the derivative of its logarithm with respect to
    /// half the square of the speed.
    inverse_speed: f64,
    fall: f64,
    /// Moment on the first side about the normal, the spin that it opposes, the reciprocal of the regularised spin, and minus the
    /// derivative of the logarithm of moment over spin with respect to half the square of the spin.
    torsion: f64,
    spin: f64,
    inverse_spin: f64,
    fall_of_spin: f64,
}

/// Held friction has at most this multiple of the normal force that acts, so that it ends where surfaces let go. Without a limit, catheters with
/// friction of 0.2 to 0.4 take as many iterations, and one step more in a hundred is not solved.
const LETTING_GO: f64 = 2.0;

/// An axis whose sine with the normal is smaller than this has no direction in the plane of contact.
const UPRIGHT: f64 = 1e-9;

/// Component of a vector perpendicular to a direction.
#[inline(always)]
fn across<T: Scalar>(v: Vector<T>, normal: Vector<T>) -> Vector<T> {
    v - normal * normal.dot(v)
}

impl ContactPoint {
    /// Vectors from the centres to the point of contact.
    pub(crate) fn arms(&self) -> [Vector<f64>; 2] {
        let arm = self.normal * -self.radii[0];
        [arm, if self.is_carried { arm } else { self.normal * self.radii[1] }]
    }

    /// The normal force by which friction is multiplied, from the one that acts.
    fn pressing(&self, normal_force: f64) -> f64 {
        self.held.map_or(normal_force, |held| held.min(LETTING_GO * normal_force))
    }

    /// Contact forces.
    pub(crate) fn contact_force(&self) -> ContactForce {
        let Law { stiffness, dissipation, friction, slip_velocity, patch_radius, .. } = self.law;
        let [forward, backward, sideways] = friction;
        let [[turning, velocity], [other_turning, other_velocity]] = self.motions;
        let [arm, other_arm] = self.arms();
        let relative = velocity - other_velocity;
        let rate = self.normal.dot(relative);
        let elastic = self.weight * stiffness * self.overlap;
        let normal_force = elastic * (1.0 - dissipation * rate).max(0.0);
        let at_contact = relative + turning.cross(arm) - other_turning.cross(other_arm);
        let sliding = across(at_contact, self.normal);
        let square = sliding.dot(sliding);
        let inverse = (square + slip_velocity * slip_velocity).sqrt().recip();
        let [at_rest, weakening] = self.law.at_rest(square);
        let (inverse_speed, fall) = (inverse * at_rest, inverse * inverse + weakening);
        let mut along = Vector::zero();
        let (mut inverse_along, mut of_along) = (0.0, [0.0, sideways, 0.0]);
        if !self.law.is_even() {
            let lying = across(self.axis, self.normal);
            let length = lying.dot(lying).sqrt();
            if length > UPRIGHT {
                inverse_along = length.recip();
                along = lying * inverse_along;
                let speed = along.dot(sliding);
                let size = speed.hypot(slip_velocity);
                let [mean, half] = [0.5 * (forward + backward), 0.5 * (forward - backward)];
                let slope = half * slip_velocity * slip_velocity / (size * size * size);
                of_along = [speed, mean + half * speed / size, slope];
            }
        }
        let [speed, of_speed, _] = of_along;
        let direction = sliding * sideways + along * ((of_speed - sideways) * speed);
        let friction_ratio = direction * inverse_speed;
        let pressing = self.pressing(normal_force);
        let friction = friction_ratio * -pressing;
        let [mut torsion, mut spin, mut inverse_spin, mut fall_of_spin] = [0.0; 4];
        if patch_radius > 0.0 {
            spin = self.normal.dot(turning - other_turning);
            let inverse = spin.hypot(slip_velocity / patch_radius).recip();
            let [at_rest, weakening] = self.law.at_rest((spin * patch_radius).powi(2));
            inverse_spin = inverse * at_rest;
            fall_of_spin = inverse * inverse + weakening * patch_radius * patch_radius;
            torsion = -pressing * sideways * patch_radius * spin * inverse_spin;
        }
        ContactForce {
            normal_force,
            elastic,
            rate,
            sliding,
            friction,
            friction_ratio,
            direction,
            along,
            inverse_along,
            of_along,
            inverse_speed,
            fall,
            torsion,
            spin,
            inverse_spin,
            fall_of_spin,
        }
    }

    /// Moments about the centres, and forces, on both sides.
    pub(crate) fn wrenches(&self, contact_force: &ContactForce) -> [Motion; 2] {
        let force = self.normal * contact_force.normal_force + contact_force.friction;
        let [arm, other_arm] = self.arms();
        let torsion = self.normal * contact_force.torsion;
        [[arm.cross(force) + torsion, force], [-other_arm.cross(force) - torsion, -force]]
    }

    /// Changes of these wrenches with rotations and displacements of the sides, and with changes of their
    /// motion; several at once if T is a pack.
    #[inline(always)]
    pub(crate) fn change<T: Scalar>(
        &self,
        contact_force: &ContactForce,
        friction_ratio: Vector<f64>,
        [[turn, shift], [other_turn, other_shift]]: [Motion<T>; 2],
        [[spin, velocity], [other_spin, other_velocity]]: [Motion<T>; 2],
    ) -> [Motion<T>; 2] {
        let Law { stiffness, dissipation, friction: [_, _, sideways], patch_radius, .. } = self.law;
        let &ContactForce { normal_force, rate, inverse_speed, .. } = contact_force;
        // Written out: `array::map` is not always inlined.
        let normal = Vector::<T>::all(self.normal);
        let sliding = Vector::all(contact_force.sliding);
        let [[turning, own], [other_turning, other]] = self.motions;
        let ([arm, other_arm], relative) = (self.arms(), own - other);
        let at_contact = Vector::all(relative + turning.cross(arm) - other_turning.cross(other_arm));
        let (relative, arm, other_arm) = (Vector::all(relative), Vector::all(arm), Vector::all(other_arm));
        let (turning, other_turning) = (Vector::all(turning), Vector::all(other_turning));
        let way = shift - other_shift;
        // Relative to the solid, sections rotate less if the solid rotates with them.
        let turned = if self.is_carried { turn - other_turn } else { turn };
        let mut slide = Vector::zero();
        if let Some(Rolling { along, of_turn, of_shift }) = self.rolling {
            slide = Vector::all(along) * (Vector::all(of_turn).dot(turned) + Vector::all(of_shift).dot(way));
        }
        let mut normal_change = Symmetric::all(self.curvature).times(way + slide);
        if self.is_carried {
            normal_change += other_turn.cross(normal);
        }
        let mut rate_change = normal_change.dot(relative)
            + normal.dot(velocity - other_velocity)
            + normal.dot(turning.cross(slide));
        if self.is_carried {
            rate_change += -normal.dot(other_turning.cross(way + slide));
        }
        let part = 1.0 - dissipation * rate;
        let force_change = if part > 0.0 {
            (normal.dot(way) * part + rate_change * (self.overlap * dissipation)) * -(self.weight * stiffness)
        } else {
            T::splat(0.0)
        };
        let arm_change = normal_change * T::splat(-self.radii[0]) + slide;
        let other_arm_change =
            if self.is_carried { arm_change + way } else { normal_change * T::splat(self.radii[1]) };
        let at_contact_change = velocity - other_velocity + spin.cross(arm) + turning.cross(arm_change)
            - other_spin.cross(other_arm)
            - other_turning.cross(other_arm_change);
        let sliding_change = across(at_contact_change, normal)
            - normal_change * normal.dot(at_contact)
            - normal * normal_change.dot(at_contact);
        let direction_change = self.direction_change(contact_force, turn, normal_change, sliding_change);
        let pressing = self.pressing(normal_force);
        // Without the slope where surfaces let go, so that held friction has a symmetric tangent.
        let pressing_change = if self.held.is_some() { T::splat(0.0) } else { force_change };
        let factor = pressing * inverse_speed;
        let factor_change = pressing_change - sliding.dot(sliding_change) * (pressing * contact_force.fall);
        let change = normal * force_change + normal_change * T::splat(normal_force)
            - Vector::all(friction_ratio) * factor_change
            - direction_change * T::splat(factor);
        let force = Vector::all(self.normal * normal_force + contact_force.friction);
        let moment = arm_change.cross(force) + arm.cross(change);
        let other_moment = other_arm_change.cross(force) + other_arm.cross(change);
        if patch_radius == 0.0 {
            return [[moment, change], [-other_moment, -change]];
        }
        let spin_change = normal_change.dot(turning - other_turning) + normal.dot(spin - other_spin);
        // With a constant factor of friction this is the square of the regularised part of the spin.
        let growth = 1.0 - contact_force.spin * contact_force.spin * contact_force.fall_of_spin;
        let torsion_change = (pressing_change * contact_force.spin + spin_change * (pressing * growth))
            * (-sideways * patch_radius * contact_force.inverse_spin);
        let torsion = normal * torsion_change + normal_change * T::splat(contact_force.torsion);
        [[moment + torsion, change], [-other_moment - torsion, -change]]
    }

    /// Change of the weighted sliding velocity that friction opposes; sliding along the first side has its own coefficients.
    #[inline(always)]
    fn direction_change<T: Scalar>(
        &self,
        contact_force: &ContactForce,
        turn: Vector<T>,
        normal_change: Vector<T>,
        sliding_change: Vector<T>,
    ) -> Vector<T> {
        let [_, _, sideways] = self.law.friction;
        let mut direction_change = sliding_change * T::splat(sideways);
        if contact_force.inverse_along > 0.0 {
            let [speed, of_speed, slope] = contact_force.of_along;
            let (normal, along) = (Vector::<T>::all(self.normal), Vector::all(contact_force.along));
            let axis = Vector::all(self.axis);
            let lying_change = across(turn.cross(axis), normal)
                - normal_change * normal.dot(axis)
                - normal * normal_change.dot(axis);
            let along_change = across(lying_change, along) * T::splat(contact_force.inverse_along);
            let speed_change =
                along_change.dot(Vector::all(contact_force.sliding)) + along.dot(sliding_change);
            let excess = of_speed - sideways;
            direction_change +=
                along * (speed_change * (slope * speed + excess)) + along_change * T::splat(excess * speed);
        }
        direction_change
    }

    /// Potential energy of the overlap.
    pub(crate) fn energy(&self, contact_force: &ContactForce) -> f64 {
        0.5 * contact_force.elastic * self.overlap
    }
}

impl ContactForce {
    /// Direction for the linearisation of friction per unit normal force in the motion `next`, given the
    /// linearisation `friction_ratio` at this motion and the fraction of the predicted step that was taken.
    pub(crate) fn turned(&self, friction_ratio: Vector<f64>, next: &Self, length: f64) -> Vector<f64> {
        let inverse = self.inverse_speed;
        let slid = next.sliding - self.sliding;
        let answer =
            next.direction - self.direction - friction_ratio * (self.sliding.dot(slid) * self.fall / inverse);
        friction_ratio + (self.friction_ratio - friction_ratio) * length + answer * inverse
    }

    /// Factor by which dissipation increases the stiffness.
    pub(crate) fn stiffening(&self) -> f64 {
        self.normal_force / self.elastic
    }

    /// Power dissipated by normal forces and friction.
    pub(crate) fn dissipated_power(&self) -> f64 {
        (self.elastic - self.normal_force) * self.rate
            - self.friction.dot(self.sliding)
            - self.torsion * self.spin
    }
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::{Placed, Pose, Solid};
    use super::*;
    use crate::numerics::lie::Quaternion;

    fn v(x: f64, y: f64, z: f64) -> Vector<f64> {
        Vector::new(x, y, z)
    }

    /// Two balls with given centres, motions and a rotated axis.
    fn contact_point(
        centres: [Vector<f64>; 2],
        motions: [Motion; 2],
        axis: Vector<f64>,
        (friction, excess): ([f64; 3], f64),
    ) -> ContactPoint {
        let radii = [0.3, 0.5];
        let way = centres[0] - centres[1];
        let length = way.dot(way).sqrt();
        let normal = way * length.recip();
        ContactPoint {
            law: Law {
                stiffness: 50.0,
                dissipation: 0.7,
                friction,
                slip_velocity: 0.1,
                excess,
                stribeck_velocity: 0.7,
                patch_radius: 0.2,
            },
            weight: 0.4,
            overlap: radii[0] + radii[1] - length,
            normal,
            curvature: (Symmetric::diagonal(1.0) - Symmetric::square(normal)) * length.recip(),
            radii,
            is_carried: false,
            rolling: None,
            thickness: radii[0],
            motions,
            axis,
            held: None,
        }
    }

    #[test]
    fn forces_change_as_they_say_and_take_power() {
        let centres = [v(0.1, 0.2, 0.6), v(0.0, 0.1, 0.0)];
        let motions = [[v(0.3, -0.2, 0.5), v(0.2, 0.1, -0.4)], [v(-0.1, 0.4, 0.2), v(0.05, -0.1, 0.1)]];
        let axis = v(0.6, 0.8, 0.0);
        let moved = [[v(0.3, 0.1, -0.2), v(0.5, -0.4, 0.2)], [v(0.1, 0.7, 0.3), v(-0.2, 0.3, 0.1)]];
        let faster = [[v(0.2, 0.2, 0.4), v(-0.3, 0.5, 0.6)], [v(0.1, -0.5, 0.2), v(0.4, 0.1, -0.7)]];
        let frictions = [([0.0; 3], 0.0), ([0.5; 3], 0.0), ([0.2, 0.6, 1.1], 0.0), ([0.5; 3], 0.8)];
        // As it acts, and held at a normal force, which is limited to twice the one that acts.
        for (friction, held) in
            frictions.into_iter().flat_map(|friction| [(friction, None), (friction, Some(0.7))])
        {
            let contact_point = |centres, motions, axis, friction| ContactPoint {
                held,
                ..contact_point(centres, motions, axis, friction)
            };
            let here = contact_point(centres, motions, axis, friction);
            let contact_force = here.contact_force();
            assert!(held.is_none_or(|held| held < 2.0 * contact_force.normal_force));
            assert!(contact_force.normal_force > 0.0 && contact_force.dissipated_power() >= 0.0);
            let change = here.change(&contact_force, contact_force.friction_ratio, moved, faster);
            let h = 1e-6;
            let at = |h: f64| {
                let centres = [0, 1].map(|s| centres[s] + moved[s][1] * h);
                let motions: [Motion; 2] =
                    std::array::from_fn(|s| std::array::from_fn(|m| motions[s][m] + faster[s][m] * h));
                let turn = moved[0][0];
                let there = contact_point(centres, motions, axis + turn.cross(axis) * h, friction);
                there.wrenches(&there.contact_force())
            };
            let [ahead, behind] = [at(h), at(-h)];
            for s in 0..2 {
                for m in 0..2 {
                    let slope = (ahead[s][m] - behind[s][m]) * (0.5 / h);
                    let error = slope - change[s][m];
                    assert!(
                        error.dot(error).sqrt() < 1e-7,
                        "{friction:?} {s} {m} {slope:?} {:?}",
                        change[s][m]
                    );
                }
            }
            // The dissipated power is the power of the forces minus the change of the potential.
            let [[_, force], _] = here.wrenches(&contact_force);
            let arms = here.arms();
            let at_contact: Vec<_> = (0..2).map(|s| motions[s][1] + motions[s][0].cross(arms[s])).collect();
            let spin = here.normal.dot(motions[0][0] - motions[1][0]);
            let power = force.dot(at_contact[0] - at_contact[1]) + contact_force.torsion * spin;
            let energy = |h: f64| {
                let there =
                    contact_point([0, 1].map(|s| centres[s] + motions[s][1] * h), motions, axis, friction);
                there.energy(&there.contact_force())
            };
            let stored = (energy(h) - energy(-h)) / (2.0 * h);
            assert!((power + stored + contact_force.dissipated_power()).abs() < 1e-7);
        }
    }

    /// The largest friction is that at rest, and fast sliding has the other one.
    #[test]
    fn friction_falls_from_that_at_rest() {
        for (ratio, velocities) in [(1.0001, 10.0), (1.5, 10.0), (1.5, 1e3), (4.0, 100.0)] {
            let law = Law {
                stiffness: 1.0,
                dissipation: 0.0,
                friction: [1.0; 3],
                slip_velocity: 1e-4,
                excess: excess_at_rest(ratio, velocities),
                stribeck_velocity: 1e-4 * velocities,
                patch_radius: 0.0,
            };
            let friction = |v: f64| law.at_rest(v * v)[0] * v / v.hypot(1e-4);
            let speeds = (0..4000).map(|k| 1e-5 * (0.005 * f64::from(k)).exp());
            let largest = speeds.map(friction).fold(0.0, f64::max);
            assert!((largest / ratio - 1.0).abs() < 1e-5, "{ratio} {velocities}: {largest}");
            assert!((friction(1.0) - 1.0).abs() < 1e-8);
        }
    }

    /// A ball and a moving solid with their motions; the solid's motion is that of its material at the ball's
    /// centre.
    fn carried(solid: &Solid, pose: &Pose, centre: Vector<f64>, motions: [Motion; 2]) -> ContactPoint {
        let distance = Placed { solid, pose: Some(pose) }.distance(centre);
        let plain = contact_point([centre, Vector::zero()], motions, Vector::zero(), ([0.5; 3], 0.0));
        ContactPoint {
            overlap: 0.3 - distance.value,
            normal: distance.normal,
            curvature: distance.curvature,
            radii: [0.3, 0.0],
            is_carried: true,
            ..plain
        }
    }

    fn solids() -> [Solid; 4] {
        let turned = Quaternion::from_array([0.8, 0.36, -0.48, 0.0]).rotation();
        [
            Solid::HalfSpace { point: v(0.1, 0.2, 0.2), normal: v(0.6, 0.0, 0.8) },
            Solid::Ball { centre: v(0.1, 0.0, 0.1), radius: 0.3 },
            Solid::Capsule { ends: [v(-0.5, 0.0, 0.0), v(0.6, 0.1, 0.0)], radius: 0.3 },
            Solid::Cuboid {
                centre: v(0.0, 0.1, -0.1),
                axes: turned,
                half_extents: v(0.2, 0.3, 0.1),
                radius: 0.0,
            },
        ]
    }

    #[test]
    fn forces_of_solids_that_turn_change_as_they_say() {
        let pose =
            Pose { rotation: Quaternion::exp(v(0.2, -0.5, 0.3)).rotation(), position: v(0.05, 0.02, -0.1) };
        let centre = v(0.15, 0.25, 0.35);
        let motions = [[v(0.3, -0.2, 0.5), v(0.2, 0.1, -0.4)], [v(-0.1, 0.4, 0.2), v(0.05, -0.1, 0.1)]];
        let moved = [[v(0.3, 0.1, -0.2), v(0.5, -0.4, 0.2)], [v(0.1, 0.7, 0.3), v(-0.2, 0.3, 0.1)]];
        let faster = [[v(0.2, 0.2, 0.4), v(-0.3, 0.5, 0.6)], [v(0.1, -0.5, 0.2), v(0.4, 0.1, -0.7)]];
        for solid in solids() {
            let here = carried(&solid, &pose, centre, motions);
            let contact_force = here.contact_force();
            assert!(here.overlap > 0.0 && contact_force.normal_force > 0.0, "{solid:?}");
            let change = here.change(&contact_force, contact_force.friction_ratio, moved, faster);
            let at = |h: f64| {
                let [[_, shift], [turn, of_material]] = moved.map(|motion| motion.map(|v| v * h));
                let small = Quaternion::exp(turn).rotation();
                let moved_pose = Pose {
                    rotation: small.times(&pose.rotation),
                    position: centre + of_material + small.apply(pose.position - centre),
                };
                let centre = centre + shift;
                let [first, mut second]: [Motion; 2] =
                    std::array::from_fn(|s| std::array::from_fn(|m| motions[s][m] + faster[s][m] * h));
                // The material point moves away from the ball's centre.
                let ahead = shift - of_material;
                second[1] += second[0].cross(ahead);
                let there = carried(&solid, &moved_pose, centre, [first, second]);
                let [on_first, [moment, force]] = there.wrenches(&there.contact_force());
                [on_first, [moment + ahead.cross(force), force]]
            };
            let h = 1e-6;
            let [ahead, behind] = [at(h), at(-h)];
            for s in 0..2 {
                for m in 0..2 {
                    let error = (ahead[s][m] - behind[s][m]) * (0.5 / h) - change[s][m];
                    assert!(error.dot(error).sqrt() < 1e-7, "{solid:?} {s} {m} {error:?}");
                }
            }
        }
    }

    #[test]
    fn forces_are_those_that_all_see_who_move_along_and_make_no_moment() {
        let centre = v(0.15, 0.25, 0.35);
        let own = [v(0.3, -0.2, 0.5), v(0.2, 0.1, -0.4)];
        let still = [Vector::zero(); 2];
        for solid in solids() {
            let here = carried(&solid, &Pose::unmoved(), centre, [own, still]);
            let plain = ContactPoint { is_carried: false, ..here };
            let wrenches = here.wrenches(&here.contact_force());
            assert_eq!(wrenches[0], plain.wrenches(&plain.contact_force())[0], "{solid:?}");
            // Both about the centre.
            for m in 0..2 {
                assert_eq!(wrenches[0][m], -wrenches[1][m]);
            }
            // Rotated, and moving with the twist of a rotation.
            let [turning, velocity, shift] = [v(0.7, -1.1, 0.4), v(-0.3, 0.8, 0.5), v(0.4, 0.3, -0.2)];
            let rotation = Quaternion::exp(v(-0.4, 0.9, 0.2)).rotation();
            let pose = Pose { rotation, position: shift };
            let seen = own.map(|v| rotation.apply(v));
            let motions = [[seen[0] + turning, seen[1] + velocity], [turning, velocity]];
            let there = carried(&solid, &pose, pose.place(centre), motions);
            let turned = there.wrenches(&there.contact_force());
            for (here, there) in wrenches.into_iter().flatten().zip(turned.into_iter().flatten()) {
                let error = rotation.apply(here) - there;
                assert!(error.dot(error).sqrt() < 1e-14, "{solid:?} {error:?}");
            }
        }
    }
}
