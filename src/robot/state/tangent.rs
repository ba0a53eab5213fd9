//! The working memory of the tangent: coordinates outside their own pieces, and the part beyond a place.

use crate::lie::{Geometry, Twist, VectorSpace, Wrench};
use crate::linalg::{Matrix, TreeMatrix};
use crate::robot::algebra::inertia::{Gyroscope, Inertia};
use crate::robot::algebra::response::Response;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Point;
use crate::robot::plan::space::Space;
use crate::robot::state::actuation::ActuationTangent;
use crate::robot::state::contact::ContactTangent;
use crate::robot::state::loops::LoopTangent;

/// What a coordinate is outside its own piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinate<G: Geometry> {
    /// Psi at the end of the piece.
    pub(crate) shape: Twist<G, f64>,
    /// As a column: the angular part of Y, and Z, of all that lies behind the piece, and how far it turns.
    pub(crate) y: G::Axial<f64>,
    pub(crate) z: Twist<G, f64>,
    pub(crate) turn: G::Axial<f64>,
    /// As a column: H at the end of the piece, and of all that lies before it.
    pub(crate) end: Wrench<G, f64>,
    pub(crate) before: Wrench<G, f64>,
    /// As a row: products with y, z and turn of the coordinates of earlier pieces.
    pub(crate) row_y: G::Axial<f64>,
    pub(crate) row_z: Wrench<G, f64>,
    pub(crate) row_turn: G::Axial<f64>,
}

impl<G: Geometry> Coordinate<G> {
    pub(crate) fn zero() -> Self {
        Self {
            shape: Twist::zero(),
            y: VectorSpace::zero(),
            z: Twist::zero(),
            turn: VectorSpace::zero(),
            end: Wrench::zero(),
            before: Wrench::zero(),
            row_y: VectorSpace::zero(),
            row_z: Wrench::zero(),
            row_turn: VectorSpace::zero(),
        }
    }
}

/// What else a coordinate is outside its own piece, where there are responses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift<G: Geometry> {
    /// As a column: the linear part of Y, and that of the displacement.
    pub(crate) y: G::Vector<f64>,
    pub(crate) displacement: G::Vector<f64>,
    /// As a row: products with both.
    pub(crate) row_y: G::Vector<f64>,
    pub(crate) row_displacement: G::Vector<f64>,
}

impl<G: Geometry> Shift<G> {
    pub(crate) fn zero() -> Self {
        let zero = VectorSpace::zero();
        Self { y: zero, displacement: zero, row_y: zero, row_displacement: zero }
    }
}

/// A coordinate as a row, to which responses are added.
pub(crate) struct Row<'a, G: Geometry> {
    pub(crate) coordinate: &'a mut Coordinate<G>,
    pub(crate) shift: &'a mut Shift<G>,
}

impl<G: Geometry> Row<'_, G> {
    /// Adds what a response at a place that moves with `psi` multiplies.
    #[inline(always)]
    pub(crate) fn answer(&mut self, response: &Response<G, f64>, psi: Twist<G, f64>) {
        self.add_rows(response.transposed_times(psi));
    }

    /// The same of a pack of nodes.
    #[inline(always)]
    pub(crate) fn answer_nodes(&mut self, response: &Response<G, G::Pack>, psi: Twist<G, G::Pack>) {
        self.add_rows(response.transposed_times(psi).map(Wrench::sum));
    }

    #[inline(always)]
    fn add_rows(&mut self, [displacement, y, z]: [Wrench<G, f64>; 3]) {
        self.coordinate.row_z += z;
        self.coordinate.row_y += y.moment;
        self.shift.row_y += y.force;
        self.coordinate.row_turn += displacement.moment;
        self.shift.row_displacement += displacement.force;
    }
}

/// Memory of the tangent: one piece at a time, and what is left of every coordinate.
#[derive(Clone, Debug)]
pub(crate) struct TangentWorkspace<G: Geometry> {
    pub(crate) coordinates: Vec<Coordinate<G>>,
    /// Of robots with branches: what all that a station carries answers.
    pub(crate) carried: Vec<Rest<G>>,
    /// Of every place inside a piece where others are attached: what the coordinates of the piece are there.
    pub(crate) attached: Vec<Attached<G>>,
    /// Only where there are responses.
    pub(crate) shifts: Vec<Shift<G>>,
    /// Per pack, times the quadrature weights: N and C.
    pub(crate) inertia: Vec<Inertia<G, G::Pack>>,
    pub(crate) gyroscope: Vec<Gyroscope<G, G::Pack>>,
    /// Per pack, times the quadrature weights: that of the dead loads that are spread along the piece.
    pub(crate) dead: Vec<Gyroscope<G, G::Pack>>,
    pub(crate) points: PointTangents<G>,
    pub(crate) actuation: ActuationTangent<G::Pack>,
    /// The same of closed loops.
    pub(crate) loops: LoopTangent,
    /// And of contact.
    pub(crate) contact: ContactTangent,
    /// Per pack, times the quadrature weights: that of the fluid, if there is one.
    pub(crate) response: Vec<Response<G, G::Pack>>,
    /// Per component of the piece and pack: S, ad_V S, (ad_A + ad_V ad_V) S and w_q ad_S^T F of a unit strain.
    pub(crate) shape: Vec<Twist<G, G::Pack>>,
    pub(crate) shape_rate: Vec<Twist<G, G::Pack>>,
    pub(crate) shape_acceleration: Vec<Twist<G, G::Pack>>,
    pub(crate) load: Vec<Wrench<G, G::Pack>>,
    /// Per pack, for the column at hand: an integrand, Psi' and Psi''.
    pub(crate) integrand: Vec<Twist<G, G::Pack>>,
    pub(crate) psi_rate: Vec<Twist<G, G::Pack>>,
    pub(crate) psi_acceleration: Vec<Twist<G, G::Pack>>,
    /// Per coordinate of the piece and pack: Psi, and the change of the force times the quadrature weights.
    pub(crate) psi: Vec<Twist<G, G::Pack>>,
    pub(crate) source: Vec<Wrench<G, G::Pack>>,
}

impl<G: Space> TangentWorkspace<G> {
    pub(crate) fn new(plan: &Plan<G>) -> Self {
        let largest = |size: fn(&PiecePlan<G>) -> usize| plan.pieces.iter().map(size).max().unwrap_or(0);
        let packs = largest(|piece| piece.packs);
        let blocks = largest(|piece| piece.packs * piece.components.len());
        let columns = largest(|piece| piece.packs * piece.n);
        Self {
            coordinates: vec![Coordinate::zero(); plan.n],
            carried: vec![Rest::zero(); if plan.has_branches { plan.stations } else { 0 }],
            attached: plan.attachments().map(|point| Attached::new(plan, point)).collect(),
            shifts: vec![Shift::zero(); if plan.has_responses { plan.n } else { 0 }],
            inertia: vec![Inertia::zero(); packs],
            gyroscope: vec![Gyroscope::zero(); packs],
            dead: vec![Gyroscope::zero(); packs],
            points: PointTangents::new(plan),
            actuation: ActuationTangent::new(&plan.actuation, plan.n),
            loops: LoopTangent::new(&plan.loops, plan.n),
            contact: ContactTangent::new(&plan.contacts, plan.n),
            response: vec![Response::zero(); if plan.immersion.is_some() { packs } else { 0 }],
            shape: vec![Twist::zero(); blocks],
            shape_rate: vec![Twist::zero(); blocks],
            shape_acceleration: vec![Twist::zero(); blocks],
            load: vec![Wrench::zero(); blocks],
            integrand: vec![Twist::zero(); packs],
            psi_rate: vec![Twist::zero(); packs],
            psi_acceleration: vec![Twist::zero(); packs],
            psi: vec![Twist::zero(); columns],
            source: vec![Wrench::zero(); columns],
        }
    }
}

/// What the coordinates of a piece are at a place inside it where others are attached.
#[derive(Clone, Debug)]
pub(crate) struct Attached<G: Geometry> {
    /// The first of them.
    pub(crate) first: usize,
    pub(crate) coordinates: Vec<Coordinate<G>>,
    /// Only where there are responses.
    pub(crate) shifts: Vec<Shift<G>>,
}

impl<G: Space> Attached<G> {
    fn new(plan: &Plan<G>, point: &Point<G>) -> Self {
        let piece = &plan.pieces[point.place.piece];
        Self {
            first: piece.first,
            coordinates: vec![Coordinate::zero(); piece.n],
            shifts: vec![Shift::zero(); if plan.has_responses { piece.n } else { 0 }],
        }
    }
}

impl<G: Space> TangentWorkspace<G> {
    /// What all that lies behind the beginning of a piece answers becomes a part of what its carrier carries.
    #[inline(always)]
    pub(crate) fn carry(&mut self, plan: &Plan<G>, piece: &PiecePlan<G>, rest: &Rest<G>) {
        if plan.has_branches {
            self.carried[piece.joined.carrier()].add(rest, plan.has_responses);
        }
    }

    /// Keeps what coordinate `k` of a piece is at the places inside it where others are attached.
    #[inline(always)]
    pub(crate) fn keep(&mut self, plan: &Plan<G>, piece: &PiecePlan<G>, weights: Weights, k: usize) {
        if self.attached.is_empty() {
            return;
        }
        let range = piece.points.inside.clone();
        let attached = &mut self.attached[piece.points.attachments_before..];
        let carrying = plan.points[range.clone()].iter().enumerate().filter(|(_, p)| p.carries.is_some());
        for ((i, _), attached) in carrying.zip(attached) {
            let (psi, y) = (self.points.psi[k * range.len() + i], self.points.y[i]);
            attached.coordinates[k] = Coordinate {
                shape: psi,
                y: y.angular,
                z: self.points.z[i],
                turn: psi.angular * weights.q,
                ..Coordinate::zero()
            };
            if plan.has_responses {
                let displacement = psi.linear * weights.q;
                attached.shifts[k] = Shift { y: y.linear, displacement, ..Shift::zero() };
            }
        }
    }

    /// What coordinates are for those that are attached there: at the end of their pieces, if at no place inside.
    #[inline(always)]
    pub(crate) fn seen_from(
        &self,
        attached: Option<usize>,
        coordinates: std::ops::Range<usize>,
    ) -> &[Coordinate<G>] {
        match attached {
            None => &self.coordinates[coordinates],
            Some(attached) => {
                let Attached { first, coordinates: all, .. } = &self.attached[attached];
                &all[coordinates.start - first..coordinates.end - first]
            }
        }
    }

    /// The shift of one likewise.
    #[inline(always)]
    pub(crate) fn shift_seen_from(&self, attached: Option<usize>, k: usize) -> &Shift<G> {
        match attached {
            None => &self.shifts[k],
            Some(attached) => &self.attached[attached].shifts[k - self.attached[attached].first],
        }
    }
}

/// The weights of a tangent, with what they make unnecessary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    pub(crate) q: f64,
    pub(crate) v: f64,
    pub(crate) a: f64,
    /// The mass matrix alone: Y and the loads vanish, and the motion need not be known.
    pub(crate) is_mass_only: bool,
}

/// What all that lies behind a place, tip included, answers to variations that are constant along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rest<G: Geometry> {
    pub(crate) inertia: Inertia<G, f64>,
    pub(crate) gyroscope: Gyroscope<G, f64>,
    /// That of the dead loads.
    pub(crate) dead: Gyroscope<G, f64>,
    /// That of springs and fluid.
    pub(crate) response: Response<G, f64>,
}

impl<G: Geometry> Rest<G> {
    pub(crate) fn zero() -> Self {
        Self {
            inertia: Inertia::zero(),
            gyroscope: Gyroscope::zero(),
            dead: Gyroscope::zero(),
            response: Response::zero(),
        }
    }

    /// Adds another one; its responses only where there are any, as they are the most of it.
    pub(crate) fn add(&mut self, other: &Self, has_responses: bool) {
        self.inertia.add(other.inertia);
        self.gyroscope.add(other.gyroscope);
        self.dead.add(other.dead);
        if has_responses {
            self.response.add(other.response);
        }
    }

    /// Takes the place of this one likewise.
    pub(crate) fn set(&mut self, other: &Self, has_responses: bool) {
        self.inertia = other.inertia;
        self.gyroscope = other.gyroscope;
        self.dead = other.dead;
        if has_responses {
            self.response = other.response;
        }
    }
}

/// Where a tangent goes: all entries, or what a tree's matrix is made of.
#[derive(Debug)]
pub(crate) enum Tangent<'a> {
    Dense(&'a mut Matrix),
    Tree(&'a mut TreeMatrix),
}

impl Tangent<'_> {
    /// The entries from the first one of the diagonal block of piece `s` on, by columns, and how many lie between
    /// columns.
    #[inline(always)]
    pub(crate) fn block<G: Space>(&mut self, s: usize, piece: &PiecePlan<G>) -> (&mut [f64], usize) {
        match self {
            Self::Dense(matrix) => {
                let n = matrix.nrows();
                let first = (piece.first * (n + 1)).min(n * n);
                (&mut matrix.as_mut_slice()[first..], n)
            }
            Self::Tree(matrix) => (matrix.blocks[s].as_mut_slice(), piece.n),
        }
    }
}

/// Memory for the points inside one piece at a time.
#[derive(Clone, Debug)]
pub(crate) struct PointTangents<G: Geometry> {
    /// Per point: the inertia there, the gyroscope, and that of dead loads, each with that of all that is attached.
    pub(crate) inertia: Vec<Inertia<G, f64>>,
    pub(crate) gyroscope: Vec<Gyroscope<G, f64>>,
    pub(crate) dead: Vec<Gyroscope<G, f64>>,
    /// Per point: the response of its supports and of all that is attached, if there is any.
    pub(crate) response: Vec<Option<Response<G, f64>>>,
    /// Per point, of the column at hand: Y and Z.
    pub(crate) y: Vec<Twist<G, f64>>,
    pub(crate) z: Vec<Twist<G, f64>>,
    /// Per coordinate of the piece and point: Psi, and the change of the force.
    pub(crate) psi: Vec<Twist<G, f64>>,
    pub(crate) source: Vec<Wrench<G, f64>>,
}

impl<G: Space> PointTangents<G> {
    pub(crate) fn new(plan: &Plan<G>) -> Self {
        let largest = |size: fn(&PiecePlan<G>) -> usize| plan.pieces.iter().map(size).max().unwrap_or(0);
        let points = largest(|piece| piece.points.inside.len());
        let columns = largest(|piece| piece.points.inside.len() * piece.n);
        Self {
            inertia: vec![Inertia::zero(); points],
            gyroscope: vec![Gyroscope::zero(); points],
            dead: vec![Gyroscope::zero(); points],
            response: vec![None; points],
            y: vec![Twist::zero(); points],
            z: vec![Twist::zero(); points],
            psi: vec![Twist::zero(); columns],
            source: vec![Wrench::zero(); columns],
        }
    }
}
