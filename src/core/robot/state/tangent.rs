//! Working memory of the tangent: effects of coordinates outside their own pieces, and sums over what lies
//! beyond a place.

use crate::numerics::lie::{Geometry, Twist, VectorSpace, Wrench};
use crate::numerics::linalg::{Matrix, TreeMatrix};
use crate::robot::algebra::inertia::{Gyroscope, Inertia};
use crate::robot::algebra::response::Response;
use crate::robot::effects::parts::Tangents;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Point;
use crate::robot::plan::space::Space;

/// Effect of a coordinate outside its own piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinate<G: Geometry> {
    /// Psi at the end of the piece.
    pub(crate) shape: Twist<G, f64>,
    /// As a column: the angular part of Y, and Z, of everything beyond the piece, and its rotation.
    pub(crate) y: G::Axial<f64>,
    pub(crate) z: Twist<G, f64>,
    pub(crate) turn: G::Axial<f64>,
    /// As a column: H at the end of the piece, and H of everything before the piece.
    pub(crate) end: Wrench<G, f64>,
    pub(crate) before: Wrench<G, f64>,
    /// As a row: factors of y, z and rotation of the coordinates of preceding pieces.
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

/// Additional effect of a coordinate outside its own piece, if there are responses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift<G: Geometry> {
    /// As a column: the linear parts of Y and of the displacement.
    pub(crate) y: G::Vector<f64>,
    pub(crate) displacement: G::Vector<f64>,
    /// As a row: factors of both.
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
    /// Adds the factors due to a response at a place that moves with `psi`.
    #[inline(always)]
    pub(crate) fn answer(&mut self, response: &Response<G, f64>, psi: Twist<G, f64>) {
        self.add_rows(response.transposed_times(psi));
    }

    /// The same for a pack of nodes.
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

/// Memory of the tangent: for one piece at a time, and for the effects of every coordinate.
#[derive(Clone, Debug)]
pub(crate) struct TangentWorkspace<G: Geometry> {
    pub(crate) coordinates: Vec<Coordinate<G>>,
    /// For robots with branches: sums over everything that a station carries.
    pub(crate) carried: Vec<Rest<G>>,
    /// For every place inside a piece with attached pieces: effects of the piece's coordinates there.
    pub(crate) attached: Vec<Attached<G>>,
    /// Present only with responses.
    pub(crate) shifts: Vec<Shift<G>>,
    /// Per pack, times quadrature weights: N and C.
    pub(crate) inertia: Vec<Inertia<G, G::Pack>>,
    pub(crate) gyroscope: Vec<Gyroscope<G, G::Pack>>,
    /// Per pack, times quadrature weights: gyroscope of the dead loads along the piece.
    pub(crate) dead: Vec<Gyroscope<G, G::Pack>>,
    pub(crate) points: PointTangents<G>,
    pub(crate) effects: Tangents<G>,
    /// Per pack, times quadrature weights: response of the fluid, if any.
    pub(crate) response: Vec<Response<G, G::Pack>>,
    /// Per component of the piece and pack: S, ad_V S, (ad_A + ad_V ad_V) S and w_q ad_S^T F for a unit
    /// strain.
    pub(crate) shape: Vec<Twist<G, G::Pack>>,
    pub(crate) shape_rate: Vec<Twist<G, G::Pack>>,
    pub(crate) shape_acceleration: Vec<Twist<G, G::Pack>>,
    pub(crate) load: Vec<Wrench<G, G::Pack>>,
    /// Per pack, for the current column: an integrand, Psi' and Psi''.
    pub(crate) integrand: Vec<Twist<G, G::Pack>>,
    pub(crate) psi_rate: Vec<Twist<G, G::Pack>>,
    pub(crate) psi_acceleration: Vec<Twist<G, G::Pack>>,
    /// Per coordinate of the piece and pack: Psi, and the change of the force times quadrature weights.
    pub(crate) psi: Vec<Twist<G, G::Pack>>,
    pub(crate) source: Vec<Wrench<G, G::Pack>>,
}

impl<G: Space> TangentWorkspace<G> {
    pub(crate) fn new(plan: &Plan<G>) -> Self {
        let largest = |size: fn(&PiecePlan<G>) -> usize| plan.pieces.iter().map(size).max().unwrap_or(0);
        let packs = largest(|piece| piece.packs);
        let block: fn(&PiecePlan<G>) -> usize = |piece| piece.packs * piece.components.len();
        let blocks = largest(block);
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
            effects: Tangents::new(&plan.effects, plan.n, plan.pieces.iter().map(block)),
            response: vec![Response::zero(); if plan.effects.immersion.is_some() { packs } else { 0 }],
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

/// Effects of a piece's coordinates at a place inside it at which others are attached.
#[derive(Clone, Debug)]
pub(crate) struct Attached<G: Geometry> {
    /// Index of the first coordinate.
    pub(crate) first: usize,
    pub(crate) coordinates: Vec<Coordinate<G>>,
    /// Present only with responses.
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
    /// Adds the sums at the beginning of a piece to those of its carrier.
    #[inline(always)]
    pub(crate) fn carry(&mut self, plan: &Plan<G>, piece: &PiecePlan<G>, rest: &Rest<G>) {
        if plan.has_branches {
            self.carried[piece.joined.carrier()].add(rest, plan.has_responses);
        }
    }

    /// Stores the effects of coordinate `k` of a piece at places inside it at which others are attached.
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

    /// Effects of coordinates on pieces attached at a place; at the end of their piece if `None`.
    #[inline(always)]
    pub(crate) fn relative_to(
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

    /// The additional effect of one coordinate there.
    #[inline(always)]
    pub(crate) fn shift_relative_to(&self, attached: Option<usize>, k: usize) -> &Shift<G> {
        match attached {
            None => &self.shifts[k],
            Some(attached) => &self.attached[attached].shifts[k - self.attached[attached].first],
        }
    }
}

/// Weights of a tangent, and which terms they make unnecessary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    pub(crate) q: f64,
    pub(crate) v: f64,
    pub(crate) a: f64,
    /// Mass matrix only: Y and the loads vanish, and the motion need not be known.
    pub(crate) is_mass_only: bool,
}

/// Sums over everything beyond a place, including the tip, for variations that are constant along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rest<G: Geometry> {
    pub(crate) inertia: Inertia<G, f64>,
    pub(crate) gyroscope: Gyroscope<G, f64>,
    /// Gyroscope of the dead loads.
    pub(crate) dead: Gyroscope<G, f64>,
    /// Response of springs and fluid.
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

    /// Adds another one; responses, the largest part, only if there are any.
    pub(crate) fn add(&mut self, other: &Self, has_responses: bool) {
        self.inertia.add(other.inertia);
        self.gyroscope.add(other.gyroscope);
        self.dead.add(other.dead);
        if has_responses {
            self.response.add(other.response);
        }
    }

    /// Copies another one, likewise.
    pub(crate) fn set(&mut self, other: &Self, has_responses: bool) {
        self.inertia = other.inertia;
        self.gyroscope = other.gyroscope;
        self.dead = other.dead;
        if has_responses {
            self.response = other.response;
        }
    }
}

/// Destination of a tangent: all entries, or the data of a tree matrix.
#[derive(Debug)]
pub(crate) enum Tangent<'a> {
    Dense(&'a mut Matrix),
    Tree(&'a mut TreeMatrix),
}

impl Tangent<'_> {
    /// Entries of the diagonal block of piece `s` by columns, and the distance between columns.
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
    /// Per point: inertia, gyroscope, and gyroscope of dead loads, each including everything attached there.
    pub(crate) inertia: Vec<Inertia<G, f64>>,
    pub(crate) gyroscope: Vec<Gyroscope<G, f64>>,
    pub(crate) dead: Vec<Gyroscope<G, f64>>,
    /// Per point: response of its supports and of everything attached there, if any.
    pub(crate) response: Vec<Option<Response<G, f64>>>,
    /// Per point, for the current column: Y and Z.
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
