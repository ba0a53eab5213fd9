//! The part of the contact tangent that is due to the contact point's motion along the axis of a second rod, in addition to the part for
//! points fixed to the material.
//!
//! `shapes::slide` has the row dxi of derivatives of that place with respect to the coordinates. The change of forces per unit of dxi
//! is computed once: the wrenches of both sides, with the place moving along the axis, and the shares of the nodes of the second
//! rod (see `force`), the row `shares`. Without friction and dissipation both together add `f h s s^T` to the stiffness, with the
//! normal force f, the row `s = dxi` and the second derivative h of the distance along the axis, which is minimal at the place.
//!
//! The ends of an overlap move along the first rod as well. This is neglected: the overlap is zero there, so that its integral does not
//! change. These tangents lack only the change of the quadrature error.

use std::ops::Range;

use super::curve::Shape;
use crate::numerics::lie::{LANES, Lanes, Symmetric, Twist, Vector, Wrench};
use crate::robot::algebra::tie::Motion;
use crate::robot::effects::contact::shapes::distance::SHORTEST;
use crate::robot::effects::contact::shapes::slide::Slide;
use crate::robot::effects::contact::shapes::touch::ContactPoint;
use crate::robot::effects::contact::state::{Rows, SidePlace, Touch};
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::{Turning, columns};

/// Motion of the nearest place on the second rod of a contact point along that rod.
pub(super) struct Sliding {
    /// The contact point, with a place fixed to the material.
    pub(super) contact_point: ContactPoint,
    slide: Slide,
    /// Changes of the required wrenches of both sides per unit of dxi.
    answers: [Motion; 2],
}

/// Computes it; `None` without a second rod, or at its end. Writes the row of shares per unit of dxi, and the part of dxi due to
/// strains of that rod at the place.
#[inline(always)]
pub(super) fn find<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    touch: &Touch,
    linearised: Vector<f64>,
    rows: &mut Rows<G::Pack>,
) -> Option<Sliding> {
    let SidePlace::Along { curve, x } = touch.sides[1] else { return None };
    let centre = touch.centres[1];
    let way = touch.centres[0] - centre;
    let length = way.dot(way).sqrt();
    // The normal rotates with sections that are not round, and a point on the axis has none.
    if touch.contact_point.is_carried || touch.contact_point.rolling.is_some() || length <= SHORTEST {
        return None;
    }
    let contact = &work.effects.contact;
    let curve = &plan.effects.contacts.curves[curve];
    let piece = &plan.pieces[curve.piece];
    let [_, slope, bend] = Shape::new(curve, &contact.terms, &contact.axes).at(x);
    let widening = curve.widening(x);
    let slide = Slide::new(way, [slope, bend], widening)?;
    let mut contact_point = touch.contact_point;
    contact_point.curvature += Symmetric::square(slide.across) * (slide.stretch * length).recip();

    let Rows { slides, shares, at, weights, polynomials } = rows;
    let weights = &mut weights[..piece.packs * LANES];
    curve.integral.write_weights_at(x, weights, polynomials);
    for (pack, lanes) in at.iter_mut().zip(weights.chunks_exact(LANES)) {
        *pack = G::Pack::from_lanes(std::array::from_fn(|lane| lanes[lane] * curve.length));
    }
    for reach in &plan.effects.contacts.pairs[touch.pair].reaches {
        shares[reach.clone()].fill(0.0);
        slides[reach.clone()].fill(0.0);
    }
    columns::add_powers(work, piece, at, touch.needs::<G>(plan.frame)[1], shares);
    let of_slope = Wrench {
        moment: G::axial_of(plan.frame, centre.cross(slide.of_slope)),
        force: G::vector_of(plan.frame, slide.of_slope),
    };
    columns::add_powers(work, piece, at, of_slope, slides);

    let mut rate = Twist::zero();
    for (&weight, &own) in at.iter().zip(&work.rate[piece.node_packs()]) {
        rate += own * weight;
    }
    let rate = rate.sum();
    let angular = G::axial_in_space(plan.frame, rate.angular);
    // Along the surface, so that a changing radius does not change the distance.
    let along = slope + contact_point.normal * widening;
    let [turning, _] = contact_point.motions[1];
    let linear = G::in_space(plan.frame, rate.linear) + angular.cross(centre) + turning.cross(along);
    let at_rest = [Vector::zero(); 2];
    let moved = [at_rest, [Vector::zero(), along]];
    let change = contact_point.change(&touch.contact_force, linearised, moved, [at_rest, [angular, linear]]);
    let [[moment, force], [other_moment, other_force]] = change;
    let [_, [_, pressed]] = contact_point.wrenches(&touch.contact_force);
    let answers = [[-moment, -force], [-(other_moment + along.cross(pressed)), -other_force]];
    Some(Sliding { contact_point, slide, answers })
}

impl Sliding {
    /// Adds the motions of both sides to dxi, and multiplies it by a factor.
    #[inline(always)]
    pub(super) fn write(
        &self,
        reaches: &[Range<usize>],
        factor: f64,
        moved: &[Vec<f64>; 12],
        slides: &mut [f64],
    ) {
        let Slide { of_way, of_turn, .. } = self.slide;
        let factors = [of_way, of_turn, -of_way].map(|of| [of.x, of.y, of.z]);
        let [_, shifts @ ..] = moved.as_chunks::<3>().0 else { return };
        for reach in reaches {
            let slides = &mut slides[reach.clone()];
            for (component, factor) in shifts.as_flattened().iter().zip(factors.as_flattened()) {
                for (slide, x) in slides.iter_mut().zip(&component[reach.clone()]) {
                    *slide += factor * x;
                }
            }
            slides.iter_mut().for_each(|slide| *slide *= factor);
        }
    }

    /// Adds the changes of the required wrenches of both sides for a pack of coordinates.
    #[inline(always)]
    pub(super) fn add_answers<P: Lanes>(&self, slide: P, answered: &mut [Motion<P>; 2]) {
        for (answered, answers) in answered.as_flattened_mut().iter_mut().zip(self.answers.as_flattened()) {
            *answered += Vector::all(*answers) * slide;
        }
    }
}
