//! Linearisation of friction in the tangents of an iteration.
//!
//! Friction per unit normal force is `mu v / s` with `s = sqrt(|v|^2 + v_s^2)`. Newton's method for this
//! equation oscillates about the velocity at which friction reverses. It converges if instead `s w = mu v` is
//! linearised, with the friction w as a separate unknown: w then changes by little where v changes by much
//! (Chan, Golub and Mulet 1999, who solve for the same function of a gradient). After elimination of w the
//! residual is unchanged, and the tangent is that of friction with w instead of `mu v / s` in the derivative
//! of `1/s`. This tangent is exact at the solution, so that convergence is quadratic.

use crate::numerics::lie::Vector;
use crate::robot::effects::contact::state::{Followed, LinearisedFriction, SidePlace, Touch};

/// Friction at a touch that is linearised exactly.
fn exact(touch: &Touch) -> LinearisedFriction {
    let (curve, x) = match touch.sides[0] {
        SidePlace::Along { curve, x } => (curve, x),
        _ => (0, 0.0),
    };
    LinearisedFriction {
        of: [touch.pair, curve],
        x,
        contact_force: touch.contact_force,
        linearised: touch.contact_force.friction_ratio,
    }
}

/// Determines the linearisation of friction at each contact point. Present and previous contact points are in the order of pairs,
/// curves and places on them.
pub(super) fn follow(touches: &[Touch], followed: &mut Followed) {
    let Followed { length, is_new, now, before } = followed;
    std::mem::swap(now, before);
    now.clear();
    now.extend(touches.iter().map(exact));
    let Some(length) = *length else { return };
    if std::mem::replace(is_new, false) {
        before.clear();
    }
    let mut known = before.iter().peekable();
    let mut nearest: Option<&LinearisedFriction> = None;
    for (friction_ratio, touch) in now.iter_mut().zip(touches) {
        // The previous contact point that is nearest on the same curve.
        while let Some(&next) = known.peek()
            && next.of <= friction_ratio.of
        {
            let is_further = |last: &LinearisedFriction| {
                last.of == friction_ratio.of
                    && next.of == friction_ratio.of
                    && (next.x - friction_ratio.x).abs() > (last.x - friction_ratio.x).abs()
            };
            if nearest.is_some_and(is_further) {
                break;
            }
            nearest = known.next();
        }
        friction_ratio.linearised = match nearest.filter(|last| last.of == friction_ratio.of) {
            Some(last) => turned(last, touch, length),
            // A new contact point has no friction yet: it is linearised as drag.
            None => Vector::zero(),
        };
    }
}

/// The linearisation of friction at a contact point, from its last linearisation and the fraction of the increment that was taken.
fn turned(last: &LinearisedFriction, touch: &Touch, length: f64) -> Vector<f64> {
    let turned = last.contact_force.turned(last.linearised, &touch.contact_force, length);
    let normal = touch.contact_point.normal;
    let turned = turned - normal * normal.dot(turned);
    // Limited to the largest friction: with more, the tangent would not resist all motions.
    let most = touch.contact_point.law.friction.into_iter().fold(0.0, f64::max);
    let size = turned.dot(turned).sqrt();
    if size > most { turned * (most / size) } else { turned }
}
