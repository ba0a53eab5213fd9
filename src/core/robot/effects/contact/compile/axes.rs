//! Axes in which surfaces are computed.

use crate::numerics::lie::{LANES, Lanes as _, Quaternion, Rotation, Vector};
use crate::robot::description::Link;
use crate::robot::effects::contact::obstacles::Frame;
use crate::robot::effects::contact::plan::{Contacts, Fixture};
use crate::robot::kernel::kinematics;
use crate::robot::plan::Plan;
use crate::robot::turning::{Turning, place};

/// Axes in which a surface is computed, and its pose in these axes.
pub(super) struct Axes {
    /// Index of the fixture; `None` is the frame of the plan.
    pub(super) on: Option<usize>,
    /// The map to these axes from those in which the surface is described.
    pub(super) frame: Frame,
}

impl Axes {
    /// The frame of the plan, which is that of the first link's joint; for a moving base, the frame fixed in
    /// the world.
    pub(super) fn in_world<G: Turning>(contacts: &mut Contacts<G>, plan: &Plan<G>, root: &Link) -> Self {
        let on = plan.world.motion.is_some().then(|| fixture(contacts, plan, None));
        let rotation = Quaternion::from_array(root.orientation).rotation();
        Self { on, frame: Frame::relative_to(rotation, Vector::from(root.position)) }
    }

    /// Axes of the point that carries surface number `surface` among those on links.
    pub(super) fn on_link<G: Turning>(
        contacts: &mut Contacts<G>,
        plan: &Plan<G>,
        number: usize,
        link: usize,
        at: Option<f64>,
    ) -> Self {
        let point = plan.points.iter().position(|point| point.effects.surfaces.contains(&number));
        let point = point.expect("every surface on a link is at a point");
        let on = Some(fixture(contacts, plan, Some(point)));
        // Links that are welded together share a point.
        let beside = place::on_link(&plan.pieces, &plan.links[link], at).beside;
        let (rotation, position) = beside.map_or_else(
            || (Rotation::identity(), Vector::zero()),
            |beside| (beside.orientation.rotation(), beside.position),
        );
        Self { on, frame: Frame::of(rotation, position) }
    }
}

/// The fixture at a point; created if it does not exist yet.
fn fixture<G: Turning>(contacts: &mut Contacts<G>, plan: &Plan<G>, point: Option<usize>) -> usize {
    let known = contacts.fixtures.iter().position(|fixture| fixture.point == point);
    known.unwrap_or_else(|| {
        let moved_by =
            point.map_or_else(Vec::new, |point| kinematics::moved_by(plan, &plan.points[point].place));
        let turned_by = turned_by(plan, &moved_by);
        contacts.fixtures.push(Fixture { point, moved_by, turned_by });
        contacts.fixtures.len() - 1
    })
}

/// Angular coordinates of pieces that rotate what these pieces move, each with the largest rotation per unit.
fn turned_by<G: Turning>(plan: &Plan<G>, moved_by: &[(usize, Vec<G::Pack>)]) -> Vec<(usize, f64)> {
    let mut found = Vec::new();
    for (p, weights) in moved_by {
        let piece = &plan.pieces[*p];
        if let Some(hinge) = &piece.hinge {
            found.extend(hinge.turns.then_some((piece.first, 1.0)));
            continue;
        }
        for component in piece.components.iter().filter(|component| component.index < G::ANGULAR) {
            for (degree, basis) in piece.basis.chunks_exact(piece.packs).take(component.modes).enumerate() {
                let products = weights.iter().zip(basis).map(|(&weight, &basis)| weight * basis);
                let sizes = products.flat_map(|pack| (0..LANES).map(move |lane| pack.lane(lane).abs()));
                found.push((component.first + degree, sizes.sum()));
            }
        }
    }
    found
}
