//! How places where surfaces touch slide along rods, and how forces change with that: the part of the tangent beside that of
//! places which are fixed to the material.
//!
//! Forces along a rod are sums over the nodes of a rule between the ends of an overlap. The ends are zeros of the gap and move with
//! the shape; so do the nodes and their weights. On a second rod the place that is nearest to a node slides (`shapes::slide`). For
//! each touch both are rows dxi of derivatives with respect to the coordinates. What forces change by for a unit of dxi is
//! computed once: by places, normals, radii and motions ([`Slider::answers`]), and by the shares of the nodes of the rod (see
//! `force`) in the rows `shares`.

use std::ops::Range;

use super::curve::Shape;
use super::force::needs;
use super::narrow_phase::{Edge, Scene};
use crate::numerics::lie::{LANES, Lanes, Symmetric, Twist, Vector, Wrench};
use crate::robot::algebra::tie::Motion;
use crate::robot::effects::contact::plan::{Curve, NODES};
use crate::robot::effects::contact::shapes::distance::SHORTEST;
use crate::robot::effects::contact::shapes::slide::Slide;
use crate::robot::effects::contact::shapes::touch::Meeting;
use crate::robot::effects::contact::state::{Interval, Rows, Share, Standing, Touch};
use crate::robot::turning::{Turning, columns};

/// Fractions of a curve that differ by less are the same.
const SAME: f64 = 1e-12;

/// How the places of a touch slide.
pub(super) struct Slides {
    /// The touch as places that do not slide see it.
    pub(super) meeting: Meeting,
    pub(super) first: Option<Node>,
    pub(super) second: Option<Nearest>,
}

/// A node of the rule on the first side.
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// Wrenches that both sides answer for a unit of its dxi, and for a unit of the length of the interval.
    pub(super) answers: [Motion; 2],
    pub(super) of_length: [Motion; 2],
    /// Its fraction of the interval.
    pub(super) place: f64,
    /// dxi of the nearest place on the second side for a unit of its own.
    pub(super) followed: f64,
}

/// The nearest place on a second rod.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    /// Wrenches that both sides answer for a unit of its dxi.
    pub(super) answers: [Motion; 2],
    pub(super) slide: Slide,
}

/// A touch whose places slide.
pub(super) struct Slider<'a, G: Turning> {
    pub(super) scene: &'a Scene<'a, G>,
    pub(super) touch: &'a Touch,
    /// Friction in the tangent (see `follow`).
    pub(super) linearised: Vector<f64>,
}

impl<G: Turning> Slider<'_, G> {
    /// Finds how the places of a touch slide, and the rows for that.
    pub(super) fn find(&self, rows: &mut Rows<G::Pack>) -> Slides {
        let touch = self.touch;
        let mut meeting = touch.meeting;
        let second = self.nearest().map(|(curve, x, slide)| {
            let way = touch.centres[0] - touch.centres[1];
            let inverse = (slide.stretch * way.dot(way).sqrt()).recip();
            meeting.curvature += Symmetric::square(slide.across) * inverse;
            let answers = self.slid(&meeting, 1, (curve, x), rows);
            self.clear(&mut rows.of_slopes);
            let wrench = self.about_origin(touch.centres[1], slide.of_slope);
            let piece = &self.scene.plan.pieces[curve.piece];
            columns::add_powers(self.scene.work, piece, &rows.at, wrench, &mut rows.of_slopes);
            Nearest { answers, slide }
        });
        let share = touch.share.filter(|_| meeting.rolling.is_none());
        let first = share.zip(self.along(0)).and_then(|(share, (curve, x))| {
            let length = self.find_ends((curve, x), &share, rows)?;
            let answers = self.slid(&meeting, 0, (curve, x), rows);
            let wrenches = meeting.wrenches(&touch.pressing);
            let of_length = wrenches.map(|wrench| wrench.map(|part| part * -length.recip()));
            let slope = self.shape(curve).at(x)[1];
            let followed = second.map_or(0.0, |second| second.slide.of_way.dot(slope));
            Some(Node { answers, of_length, place: NODES[share.node], followed })
        });
        Slides { meeting, first, second }
    }

    fn shape<'s>(&'s self, curve: &'s Curve<G::Pack>) -> Shape<'s> {
        Shape::new(curve, self.scene.terms, self.scene.axes)
    }

    /// The curve of a side and its fraction, on a rod.
    fn along(&self, s: usize) -> Option<(&Curve<G::Pack>, f64)> {
        let Standing::Along { curve, x } = self.touch.sides[s] else { return None };
        Some((&self.scene.plan.effects.contacts.curves[curve], x))
    }

    /// How the nearest place on a second rod slides, unless it is an end.
    fn nearest(&self) -> Option<(&Curve<G::Pack>, f64, Slide)> {
        let Touch { centres, meeting, .. } = self.touch;
        let way = centres[0] - centres[1];
        // Other sections carry the normal with them, and a point on the axis has none.
        if meeting.is_carried || meeting.rolling.is_some() || way.dot(way).sqrt() <= SHORTEST {
            return None;
        }
        let (curve, x) = self.along(1)?;
        let [_, slope, bend] = self.shape(curve).at(x);
        let slide = Slide::new(way, [slope, bend], curve.widening(x))?;
        Some((curve, x, slide))
    }

    /// What both sides answer for a unit of dxi of one of them; writes how the shares of its nodes change.
    fn slid(
        &self,
        meeting: &Meeting,
        s: usize,
        (curve, x): (&Curve<G::Pack>, f64),
        rows: &mut Rows<G::Pack>,
    ) -> [Motion; 2] {
        let (plan, work) = (self.scene.plan, self.scene.work);
        let piece = &plan.pieces[curve.piece];
        self.clear(&mut rows.shares[s]);
        let Rows { shares, at, weights, polynomials, .. } = rows;
        let weights = &mut weights[..piece.packs * LANES];
        curve.integral.write_weights_at(x, weights, polynomials);
        pack(weights, curve.length, at);
        columns::add_powers(work, piece, at, needs(plan, self.touch)[s], &mut shares[s]);
        let mut rate = Twist::zero();
        for (&weight, &own) in at.iter().zip(&work.rate[piece.node_packs()]) {
            rate += own * weight;
        }
        let rate = rate.sum();
        let angular = G::axial_in_space(plan.frame, rate.angular);
        let [_, slope, bend] = self.shape(curve).at(x);
        let [turning, _] = meeting.motions[s];
        let linear = G::in_space(plan.frame, rate.linear)
            + angular.cross(self.touch.centres[s])
            + turning.cross(slope);
        let turn = slope.cross(bend) * slope.dot(slope).max(f64::MIN_POSITIVE).recip();
        self.answers(meeting, s, [[turn, slope], [angular, linear]], curve.widening(x))
    }

    /// What both sides answer for a change of the place, motion and radius of one of them.
    fn answers(
        &self,
        meeting: &Meeting,
        s: usize,
        [moved, faster]: [Motion; 2],
        widening: f64,
    ) -> [Motion; 2] {
        let pressing = &self.touch.pressing;
        let wrenches = meeting.wrenches(pressing);
        let normal = meeting.normal * widening;
        // Of a solid that carries the normal the arm is that of the first side.
        let arms = match (s, meeting.is_carried) {
            (0, true) => [-normal; 2],
            (0, false) => [-normal, Vector::zero()],
            _ => [Vector::zero(), normal],
        };
        let (mut displacements, mut changes) = ([[Vector::zero(); 2]; 2], [[Vector::zero(); 2]; 2]);
        displacements[s] = moved;
        changes[s] = faster;
        for (change, (arm, [turning, _])) in changes.iter_mut().zip(arms.into_iter().zip(meeting.motions)) {
            change[1] += turning.cross(arm);
        }
        let change = meeting.change(pressing, self.linearised, displacements, changes);
        let growth = widening / meeting.overlap;
        std::array::from_fn(|side| {
            let [moment, force] = wrenches[side];
            let arm = if side == s { arms[side] + moved[1] } else { arms[side] };
            let [moment_change, force_change] = change[side];
            [-(moment_change + moment * growth + arm.cross(force)), -(force_change + force * growth)]
        })
    }

    /// Finds how the ends of an interval on the first side move, unless that is known; returns its length as a fraction of the curve.
    /// `None` if they do not move.
    fn find_ends(
        &self,
        (curve, x): (&Curve<G::Pack>, f64),
        share: &Share,
        rows: &mut Rows<G::Pack>,
    ) -> Option<f64> {
        let Standing::Along { curve: c, .. } = self.touch.sides[0] else { return None };
        let length = share.length / curve.length;
        let from = x - NODES[share.node] * length;
        let is_known = rows.interval.as_ref().is_some_and(|known| {
            known.of == [self.touch.pair, c]
                && (known.from - from).abs() + (known.length - length).abs() <= SAME
        });
        if !is_known {
            let index = curve.samples.partition_point(|sample| sample.x <= x) - 1;
            let mut is_moving = false;
            for (end, place) in [from, from + length].into_iter().enumerate() {
                self.clear(&mut rows.ends[end]);
                if let Some(edge) = self.scene.edge(self.touch.pair, [c, index], place) {
                    self.find_end(place, &edge, end, rows);
                    is_moving = true;
                }
            }
            rows.interval = Some(Interval { of: [self.touch.pair, c], from, length, is_moving });
        }
        rows.interval.as_ref().is_some_and(|interval| interval.is_moving).then_some(length)
    }

    /// How a zero of the gap moves: by the change of the gap at its place, over the slope of the gap there.
    fn find_end(&self, place: f64, edge: &Edge, end: usize, rows: &mut Rows<G::Pack>) {
        let own = match self.touch.sides[0] {
            Standing::Along { curve, .. } => Standing::Along { curve, x: place },
            other => other,
        };
        let contacts = &self.scene.plan.effects.contacts;
        let inverse = edge.change.recip();
        for (standing, centre, sign) in
            [(own, edge.centres[0], -inverse), (edge.on, edge.centres[1], inverse)]
        {
            let wrench = self.about_origin(centre, edge.normal * sign);
            let (moved_by, own) = match standing {
                Standing::Still => continue,
                Standing::On(fixture) => (&contacts.fixtures[fixture].moved_by, None),
                Standing::Along { curve, x } => {
                    let curve = &contacts.curves[curve];
                    let Rows { at, weights, polynomials, .. } = &mut *rows;
                    let weights = &mut weights[..self.scene.plan.pieces[curve.piece].packs * LANES];
                    curve.integral.write_weights_up_to(x, weights, polynomials);
                    pack(weights, curve.length, at);
                    (&curve.moved_by, Some(curve.piece))
                }
            };
            for (p, weights) in moved_by {
                let piece = &self.scene.plan.pieces[*p];
                let Rows { at, ends, .. } = &mut *rows;
                let weights = if own == Some(*p) { &at[..] } else { &weights[..] };
                columns::add_powers(self.scene.work, piece, weights, wrench, &mut ends[end]);
            }
        }
    }

    /// A force at a place, about the origin.
    fn about_origin(&self, place: Vector<f64>, force: Vector<f64>) -> Wrench<G, f64> {
        let frame = self.scene.plan.frame;
        Wrench { moment: G::axial_of(frame, place.cross(force)), force: G::vector_of(frame, force) }
    }

    /// Sets to zero what belongs to the coordinates of the pair.
    fn clear(&self, row: &mut [f64]) {
        let reaches: &[Range<usize>] = &self.scene.plan.effects.contacts.pairs[self.touch.pair].reaches;
        for reach in reaches {
            row[reach.clone()].fill(0.0);
        }
    }
}

/// Weights of nodes in packs, times a length.
fn pack<P: Lanes>(weights: &[f64], length: f64, packs: &mut [P]) {
    for (pack, lanes) in packs.iter_mut().zip(weights.chunks_exact(LANES)) {
        *pack = P::from_lanes(std::array::from_fn(|lane| lanes[lane] * length));
    }
}
