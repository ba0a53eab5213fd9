//! Typical sizes of coordinates, from the rotations and translations of sections, bodies, and ends of tendons, loops and contacts per
//! unit of each coordinate.

use crate::model::Constraint;
use crate::numerics::lie::{Twist, Vector};
use crate::numerics::linalg::Matrix;
use crate::robot::algebra::tie::Row;
use crate::robot::effects::contact::plan::Side;
use crate::robot::effects::contact::state::SidePlace;
use crate::robot::effects::loops::force::frames;
use crate::robot::kernel::{kinematics, lines, loops};
use crate::robot::plan::Plan;
use crate::robot::plan::point::Place;
use crate::robot::state::Workspace;
use crate::robot::state::tangent::TangentWorkspace;
use crate::robot::turning::{Turning, columns, place};

/// Fractions of a piece of a rod at which sections are evaluated. Modes of higher degree do not rotate its end.
const SECTIONS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// Relative motions below this part of the largest motion of the coordinate are rounding.
const ROUNDING: f64 = 1e-9;

/// Extents and distances below this part of the length of the robot do not say how far a coordinate moves: bodies that are almost points,
/// and ends that almost meet.
const SMALLEST_EXTENT: f64 = 1e-6;

/// Quantity of which three rows are derivatives.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// An angular velocity.
    Turn,
    /// The velocity of a part of this extent, in metres.
    Shift(f64),
    /// The velocity of a point relative to its pivot, at this distance in metres.
    Apart(f64),
}

/// Motions for a unit of each coordinate.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motions {
    kinds: Vec<Kind>,
    /// Three numbers per coordinate and motion.
    entries: Vec<f64>,
}

impl Motions {
    fn push(&mut self, kind: Kind, of_coordinates: impl IntoIterator<Item = Vector<f64>>) {
        self.kinds.push(kind);
        self.entries.extend(of_coordinates.into_iter().flat_map(Vector::to_array));
    }

    /// Three rows for every motion, n columns.
    pub(crate) fn rows(&self, n: usize) -> Matrix {
        Matrix::from_fn(3 * self.kinds.len(), n, |row, k| self.entries[(row / 3 * n + k) * 3 + row % 3])
    }

    /// The sizes of coordinates: those of a largest rotation by one radian; without rotations a strain of one, or the extent of the
    /// translated parts or their distance from their pivots. `rows` are [`Self::rows`] for the independent coordinates. `fallback` is
    /// the size for parts without extent, in metres.
    pub(crate) fn sizes(&self, rows: &Matrix, is_strain: &[bool], fallback: f64, sizes: &mut [f64]) {
        for (k, size) in sizes.iter_mut().enumerate() {
            let rates = || {
                let column = rows.column(k);
                let rate = move |i: usize| (0..3).map(|j| column[3 * i + j].powi(2)).sum::<f64>().sqrt();
                self.kinds.iter().enumerate().map(move |(i, kind)| (*kind, rate(i)))
            };
            let (mut turn, mut shift, mut extent) = (0.0_f64, 0.0_f64, 0.0_f64);
            for (kind, rate) in rates() {
                match kind {
                    Kind::Turn => turn = turn.max(rate),
                    Kind::Shift(_) => shift = shift.max(rate),
                    Kind::Apart(_) => {}
                }
            }
            for (kind, rate) in rates() {
                match kind {
                    Kind::Shift(own) if rate > 0.0 => extent = extent.max(own),
                    Kind::Apart(distance) if rate > ROUNDING * shift => extent = extent.max(distance),
                    _ => {}
                }
            }
            *size = if turn > 0.0 {
                1.0 / turn
            } else if is_strain[k] || shift == 0.0 {
                1.0
            } else if extent > SMALLEST_EXTENT * fallback {
                extent / shift
            } else {
                fallback / shift
            };
        }
    }
}

/// A place with the extent of the part there, in metres.
#[derive(Clone, Debug)]
pub(crate) struct Extent {
    pub(crate) place: Place,
    pub(crate) own: f64,
}

/// Sections of all rods, with the extents of their links, and the bases of rigid links, with zero extent.
pub(crate) fn sections<G: Turning>(plan: &Plan<G>) -> Vec<Extent> {
    let mut sections = Vec::new();
    for link in &plan.links {
        let own: f64 = plan.pieces[link.rod.clone()].iter().map(|piece| piece.length).sum();
        if link.rod.is_empty() {
            sections.push(Extent { place: place::on_link(&plan.pieces, link, None), own });
        }
        for s in link.rod.clone() {
            sections.extend(SECTIONS.map(|x| Extent { place: place::at_fraction(&plan.pieces, s, x), own }));
        }
    }
    sections
}

/// Motions in a shape of these places, and of ends of loops, tendons and contacts, with the motion up to date.
pub(crate) fn motions<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    memory: &mut TangentWorkspace<G>,
    extents: &[Extent],
) -> Motions {
    let n = plan.n;
    let mut motions = Motions::default();
    let mut jacobian = Matrix::zeros(6, n);
    let beyond = kinematics::twists_beyond(plan, work);
    for Extent { place, own } in extents {
        kinematics::jacobian_from(plan, work, place, Some(&beyond), &mut jacobian);
        motions.push(Kind::Turn, half(&jacobian, 0));
        motions.push(Kind::Shift(*own), half(&jacobian, 3));
    }
    loops::find(plan, work, &mut memory.effects.loops);
    let moved = memory.effects.loops.moved.chunks_exact(n.max(1));
    for (tie, moved) in plan.effects.loops.ties.iter().zip(moved) {
        // Ends of other ties meet, so that their distance is a gap.
        if !tie.rows.iter().any(|row| matches!(row, Row::Distance(_))) {
            continue;
        }
        let [from, to] = frames(plan, work, tie).map(|frame| frame.position);
        motions.push(Kind::Apart(size(to - from)), moved.iter().map(|[from, to]| to[1] - from[1]));
    }
    if !plan.effects.actuation.lines.is_empty() {
        lines::find(plan, work, &mut memory.effects.actuation);
        let moved = memory.effects.actuation.moved.chunks_exact(n.max(1));
        for (line, moved) in work.effects.actuation.lines.iter().zip(moved) {
            motions.push(Kind::Apart(size(line.ends[1] - line.ends[0])), moved.iter().copied());
        }
    }
    let contacts = &plan.effects.contacts;
    let balls = contacts.balls.iter().map(|ball| (ball.on, size(ball.centre) + ball.radius));
    let bodies = contacts.bodies.iter().map(|body| (body.on, body.size + body.radius));
    for (fixture, own) in balls.chain(bodies) {
        // All points of a part that only translates move alike.
        if let Some(on) = fixture {
            jacobian_with(plan, work, on, Vector::zero(), &mut jacobian);
            motions.push(Kind::Shift(own), half(&jacobian, 3));
        }
    }
    motions
}

/// Jacobian of a place of a fixture, as of a section.
fn jacobian_with<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    fixture: usize,
    place: Vector<f64>,
    jacobian: &mut Matrix,
) {
    jacobian.fill(0.0);
    let moved_by = &plan.effects.contacts.fixtures[fixture].moved_by;
    columns::visit(plan, work, columns::each(moved_by), |k, [Twist { angular, linear }, _]| {
        let turn = G::axial_in_space(plan.frame, angular);
        let shift = G::in_space(plan.frame, linear) + turn.cross(place);
        for (i, x) in turn.to_array().into_iter().chain(shift.to_array()).enumerate() {
            jacobian[(i, k)] = x;
        }
    });
}

/// Three rows of a Jacobian: first rotations, then translations.
fn half(jacobian: &Matrix, first: usize) -> impl Iterator<Item = Vector<f64>> + '_ {
    (0..jacobian.ncols()).map(move |k| Vector::from(std::array::from_fn(|i| jacobian[(first + i, k)])))
}

/// Motions of the surfaces of every pair of contacts, at their middles or a corner and at the ends of pieces of rods, with the motion up
/// to date; and their number for each pair.
pub(crate) fn motions_of_contact<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> (Motions, Vec<usize>) {
    let (n, contacts) = (plan.n, &plan.effects.contacts);
    let mut motions = Motions::default();
    let mut jacobian = Matrix::zeros(6, n);
    let beyond = kinematics::twists_beyond(plan, work);
    let numbers = contacts.pairs.iter().map(|pair| {
        let before = motions.kinds.len();
        for side in &pair.sides {
            let state = &work.effects.contact;
            let (on, place) = match side {
                Side::Rod(curves) => {
                    for curve in &contacts.curves[curves.clone()] {
                        let end = place::at_fraction(&plan.pieces, curve.piece, 1.0);
                        kinematics::jacobian_from(plan, work, &end, Some(&beyond), &mut jacobian);
                        motions.push(Kind::Shift(0.0), half(&jacobian, 3));
                    }
                    continue;
                }
                Side::Ball(ball) => (contacts.balls[*ball].on, state.centres[*ball]),
                Side::Body(body) => {
                    let body = &contacts.bodies[*body];
                    (body.on, state.corners[body.first_corner])
                }
                Side::Solid(solid) => (contacts.solids[*solid].on, state.poses[*solid].position),
            };
            if let Some(on) = on {
                jacobian_with(plan, work, on, place, &mut jacobian);
                motions.push(Kind::Shift(0.0), half(&jacobian, 3));
            }
        }
        motions.kinds.len() - before
    });
    let numbers = numbers.collect();
    (motions, numbers)
}

/// Magnitudes of the generalised contact forces, with the motion up to date: with the shifts of the surfaces and the shifts of the
/// contact point by their turns added up. These are the terms of a stiffness, also where they cancel, as for a ball that turns in
/// place.
pub(crate) fn work_of_contact<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Vec<f64> {
    let n = plan.n;
    let (mut most, mut jacobian) = (vec![0.0; n], Matrix::zeros(6, n));
    let beyond = kinematics::twists_beyond(plan, work);
    for touch in &work.effects.contact.touches {
        let [[_, force], _] = touch.contact_point.wrenches(&touch.contact_force);
        let force = force.dot(force).sqrt();
        for side in 0..2 {
            let lever = touch.contact_point.radii[side].abs();
            match touch.sides[side] {
                SidePlace::Along { curve, x } => {
                    let piece = plan.effects.contacts.curves[curve].piece;
                    let place = place::at_fraction(&plan.pieces, piece, x);
                    kinematics::jacobian_from(plan, work, &place, Some(&beyond), &mut jacobian);
                }
                SidePlace::On(fixture) => {
                    jacobian_with(plan, work, fixture, touch.centres[side], &mut jacobian);
                }
                SidePlace::AtRest => continue,
            }
            for (k, most) in most.iter_mut().enumerate() {
                let [turn, shift] = [0, 3].map(|first| jacobian.fixed_view::<3, 1>(first, k).norm());
                *most += force * (shift + lever * turn);
            }
        }
    }
    most
}

/// Sizes of gaps, row by row, from the spans of their constraints in metres: the span, one for differences of cosines, and for
/// coordinates their value for such a span.
pub(crate) fn of_gaps<G: Turning>(plan: &Plan<G>, span: impl Fn(Constraint) -> f64) -> Vec<f64> {
    let mut sizes: Vec<f64> =
        plan.effects.loops.constraints.iter().map(|&constraint| span(constraint)).collect();
    for tie in &plan.effects.loops.ties {
        for (size, row) in sizes[tie.first..].iter_mut().zip(&tie.rows) {
            *size = if matches!(row, Row::Angle { .. }) { 1.0 } else { *size };
        }
    }
    for (size, gear) in sizes[plan.effects.loops.first_gear()..].iter_mut().zip(&plan.effects.loops.gears) {
        let first = gear.coordinates[0];
        let Some(piece) = plan.pieces.iter().find(|piece| piece.coordinates().contains(&first)) else {
            continue;
        };
        let mut components = piece.components.iter();
        let component = components.find(|own| (own.first..own.first + own.modes).contains(&first));
        let is_turned = match (&piece.hinge, component) {
            (Some(hinge), _) => hinge.turns,
            (None, component) => component.is_none_or(|component| component.index < G::ANGULAR),
        };
        *size = match (piece.is_joint, is_turned) {
            (true, true) | (false, false) => 1.0,
            (true, false) => *size,
            (false, true) => 1.0 / *size,
        };
    }
    sizes
}

/// Which coordinates are those of strains.
pub(crate) fn are_strains<G: Turning>(plan: &Plan<G>) -> Vec<bool> {
    let mut are_strains = vec![false; plan.n];
    for piece in plan.pieces.iter().filter(|piece| !piece.is_joint) {
        are_strains[piece.coordinates()].fill(true);
    }
    are_strains
}

fn size(v: Vector<f64>) -> f64 {
    v.dot(v).sqrt()
}
