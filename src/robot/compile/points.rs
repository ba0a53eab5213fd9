//! What is concentrated at places made into points of a plan.

use crate::body::Body;
use crate::load::{Extent, Frame};
use crate::robot::algebra::inertia::Inertia;
use crate::robot::plan::load::LoadPlan;
use crate::robot::plan::packed;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::{Inside, Place, Point, Points};
use crate::robot::turning::Turning;
use crate::robot::turning::place;
use crate::support::Support;

/// All that is concentrated on a rod with these pieces, in the order of the places, and at which of these points each
/// support acts; tells the pieces which points are theirs.
pub(crate) fn compile<G: Turning>(
    frame: G::Frame,
    pieces: &mut [PiecePlan<G>],
    loads: &[LoadPlan<G>],
    bodies: impl Iterator<Item = Body>,
    supports: &[Support],
) -> (Vec<Point<G>>, Vec<usize>) {
    let length: f64 = pieces.iter().map(|piece| piece.length).sum();
    let mut points: Vec<Point<G>> = Vec::new();
    for (l, load) in loads.iter().enumerate() {
        let x = match load.extent {
            Extent::Tip => length,
            Extent::At(x) => x,
            Extent::Along(_) => continue,
        };
        let point = point_at(&mut points, pieces, x);
        point.loads.push(l);
        point.is_oriented |= load.frame == Frame::Body;
    }
    for body in bodies {
        let point = point_at(&mut points, pieces, body.at.unwrap_or(length));
        point.is_oriented |= body.centre != [0.0; 3] || body.inertia != [[0.0; 3]; 3];
        let first_moment = G::vector_of(frame, body.centre.into()) * body.mass;
        let second_moment = G::second_moment_of(frame, body.inertia_about_section());
        point.body.get_or_insert(Inertia::zero()).add(Inertia {
            mass: body.mass,
            first_moment,
            second_moment,
        });
    }
    for (a, support) in supports.iter().enumerate() {
        let point = point_at(&mut points, pieces, support.at.unwrap_or(length));
        point.anchors.push(a);
        point.is_oriented = true;
    }
    let order = |point: &Point<G>| (point.place.piece, point.place.x);
    points.sort_by(|a, b| order(a).partial_cmp(&order(b)).expect("places are finite"));
    for (s, piece) in pieces.iter_mut().enumerate() {
        let first = points.partition_point(|point| point.place.piece < s);
        let end = points.partition_point(|point| point.place.piece <= s);
        let inside = points[first..end].iter().filter(|point| point.inside.is_some()).count();
        piece.points = Points { inside: first..first + inside, at_end: first + inside..end };
    }
    let holds = |a: usize| points.iter().position(|point| point.anchors.contains(&a));
    let supported = (0..supports.len()).filter_map(holds).collect();
    (points, supported)
}

/// The point at arc length `x` of the rod, a new one if there is none yet.
fn point_at<'a, G: Turning>(
    points: &'a mut Vec<Point<G>>,
    pieces: &[PiecePlan<G>],
    x: f64,
) -> &'a mut Point<G> {
    let place = place::at_arc_length(pieces, x);
    let is_there = |point: &Point<G>| (point.place.piece, point.place.x) == (place.piece, place.x);
    let i = points.iter().position(is_there).unwrap_or_else(|| {
        points.push(point(&pieces[place.piece], place));
        points.len() - 1
    });
    &mut points[i]
}

/// A place with nothing there.
pub(crate) fn point<G: Turning>(piece: &PiecePlan<G>, place: Place) -> Point<G> {
    let inside = (place.x < 1.0).then(|| {
        let nodes = place.weights.len();
        let weight = |i: usize| piece.length * piece.gauss.weights[i];
        Inside {
            up_to: packed(nodes, |i| place.weights[i]),
            share: packed(nodes, |i| place.weights[i] / weight(i)),
        }
    });
    Point { place, inside, body: None, loads: Vec::new(), anchors: Vec::new(), is_oriented: false }
}
