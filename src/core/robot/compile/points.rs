//! Compiles loads, bodies and other items at places of a robot to points of a plan.

use super::links::Tree;
use crate::description::body::{Body, Hull};
use crate::numerics::lie::Vector;
use crate::robot::algebra::inertia::Inertia;
use crate::robot::description::Robot;
use crate::robot::effects::fluid::compile as immersion;
use crate::robot::effects::load::plan::LoadPlan;
use crate::robot::effects::load::{Extent, Frame};
use crate::robot::plan::packed;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Inside, Offset, Place, Point, Points};
use crate::robot::turning::Turning;
use crate::robot::turning::place;

/// Places of the items of an effect, for those that have one, and the list of a point that takes their indices.
pub(crate) type PointsFor<G> = (Vec<Option<Place>>, fn(&mut Point<G>) -> &mut Vec<usize>);

/// Compiles concentrated loads, bodies and all other items that need points to points in the order of places, and assigns them to
/// the pieces. Places at which other pieces are attached are points too.
pub(crate) fn compile<G: Turning>(
    frame: G::Frame,
    tree: &mut Tree<G>,
    loads: &[LoadPlan<G>],
    places: impl IntoIterator<Item = PointsFor<G>>,
    robot: &Robot,
) -> Vec<Point<G>> {
    let Tree { pieces, links, attachments, .. } = tree;
    let mut points: Vec<Point<G>> = Vec::new();
    for (l, load) in loads.iter().enumerate() {
        let x = match load.extent {
            Extent::Tip => None,
            Extent::At(x) => Some(x),
            Extent::Along(_) => continue,
        };
        let point = point_at(&mut points, pieces, place::on_link(pieces, &links[load.link], x));
        point.effects.loads.push(l);
        point.is_oriented |= load.frame == Frame::Body;
    }
    for body in robot.all_bodies() {
        let place = place::on_link(pieces, &links[body.link], body.at);
        let body = match place.beside {
            Some(beside) => moved(&body, beside),
            None => body,
        };
        let point = point_at(&mut points, pieces, place);
        point.is_oriented |= body.centre != [0.0; 3] || body.inertia != [[0.0; 3]; 3];
        let first_moment = G::vector_of(frame, body.centre.into()) * body.mass;
        let second_moment = G::second_moment_of(frame, body.inertia_about_section());
        point.body.get_or_insert(Inertia::zero()).add(Inertia {
            mass: body.mass,
            first_moment,
            second_moment,
        });
        let Some((fluid, hull)) = robot.fluid.as_ref().zip(body.hull) else { continue };
        let centre = hull.centre.unwrap_or(body.centre);
        let hull = immersion::hull::<G>(fluid, &hull, G::vector_of(frame, centre.into()));
        let added = Body { centre, ..Body::point(hull.added_mass) };
        point.is_oriented |= centre != [0.0; 3];
        point.body.get_or_insert(Inertia::zero()).add(Inertia {
            mass: hull.added_mass,
            first_moment: hull.centre * hull.added_mass,
            second_moment: G::second_moment_of(frame, added.inertia_about_section()),
        });
        point.effects.hulls.push(hull);
    }
    for (places, list) in places {
        for (item, place) in places.into_iter().enumerate() {
            let Some(place) = place else { continue };
            let point = point_at(&mut points, pieces, place);
            list(point).push(item);
            point.is_oriented = true;
        }
    }
    for (place, station) in attachments.drain(..) {
        let point = point_at(&mut points, pieces, place);
        point.carries = Some(station);
        point.is_oriented = true;
    }
    let order = |point: &Point<G>| (point.place.piece, point.place.x);
    points.sort_by(|a, b| order(a).partial_cmp(&order(b)).expect("places are finite"));
    let mut attachments_before = 0;
    for (s, piece) in pieces.iter_mut().enumerate() {
        let first = points.partition_point(|point| point.place.piece < s);
        let end = points.partition_point(|point| point.place.piece <= s);
        let inside = points[first..end].iter().filter(|point| point.inside.is_some()).count();
        piece.points =
            Points { inside: first..first + inside, attachments_before, at_end: first + inside..end };
        attachments_before += points[first..end].iter().filter(|point| point.carries.is_some()).count();
    }
    points
}

/// A body in the axes of the place relative to which it is fixed.
fn moved(body: &Body, beside: Offset) -> Body {
    let rotation = beside.orientation.rotation();
    let columns = [rotation.x, rotation.y, rotation.z].map(Vector::to_array);
    let turned = |i: usize, j: usize| -> f64 {
        let product = |k: usize, l: usize| columns[k][i] * body.inertia[k][l] * columns[l][j];
        (0..3).flat_map(|k| (0..3).map(move |l| (k, l))).map(|(k, l)| product(k, l)).sum()
    };
    let placed = |centre: [f64; 3]| (beside.position + rotation.apply(Vector::from(centre))).to_array();
    Body {
        centre: placed(body.centre),
        inertia: std::array::from_fn(|i| std::array::from_fn(|j| turned(i, j))),
        hull: body.hull.map(|hull| Hull { centre: hull.centre.map(placed), ..hull }),
        ..body.clone()
    }
}

/// The point at a place; created if it does not exist yet.
fn point_at<'a, G: Turning>(
    points: &'a mut Vec<Point<G>>,
    pieces: &[PiecePlan<G>],
    place: Place,
) -> &'a mut Point<G> {
    let is_there = |point: &Point<G>| (point.place.piece, point.place.x) == (place.piece, place.x);
    let i = points.iter().position(is_there).unwrap_or_else(|| {
        points.push(point(&pieces[place.piece], place));
        points.len() - 1
    });
    &mut points[i]
}

/// An empty point at a place.
pub(crate) fn point<G: Turning>(piece: &PiecePlan<G>, place: Place) -> Point<G> {
    let inside = (place.x < 1.0).then(|| {
        let nodes = place.weights.len();
        let weight = |i: usize| piece.length * piece.gauss.weights[i];
        Inside {
            up_to: packed(nodes, |i| place.weights[i]),
            share: packed(nodes, |i| place.weights[i] / weight(i)),
        }
    });
    Point::empty(place, inside)
}
