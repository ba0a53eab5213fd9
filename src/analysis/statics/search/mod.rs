//! The search for equilibria: a trust-region Newton method that stays on its constraints.
//!
//! Steps are measured in sizes of coordinates ([`sizes`](crate::model::Elastic::sizes)), rotations are steps on the group
//! ([`crate::model::chart`]), tendons are inequalities of the quadratic problem of a step ([`quadratic`]), and the end is judged by forces
//! relative to the magnitudes of their contributions ([`balance`]). Every iterate satisfies loops and tendons, so that no weight between
//! energy and gaps has to be chosen (Absil, Baker and Gallivan 2007, "Trust-region methods on Riemannian manifolds"). Energies are
//! compared by the work along steps; nothing depends on masses, times or units.

mod balance;
mod problem;
mod quadratic;
mod scale;
mod step;

use nalgebra::DVector;

use super::equations::Counters;
use super::interrupted::{InterruptedSearch, Monitor, Reached};
use super::path::Path;
use super::stiffness_continuation::{
    DEEP_OVERLAP, MAX_SOFT_ITERATIONS, NextStart, SOFT_TOLERANCE, StiffnessContinuation,
};
use super::tunnelling::Passage;
use crate::error::Interrupted;
use crate::model::constraint::{self, closing};
use crate::model::{InvalidShape, Static, chart};
use crate::numerics::linalg::{Matrix, dot, norm};

use balance::{Balance, IndependentRows};
use problem::{Problem, Shape, add_transposed, times};
use quadratic::Linearised;
use scale::Scale;
use step::{Bounds, FIRST_SHIFT};

/// First radius, in sizes of coordinates: half a radian.
const FIRST_RADIUS: f64 = 0.5;

/// A radius below this one is rounding.
const SMALLEST_RADIUS: f64 = 1e-14;

/// A step that does this part of the predicted work is accepted; from `GOOD_RATIO` on the radius may grow by `RADIUS_GROWTH`, below `POOR_RATIO`
/// it is half the step; after a refused one it shrinks by `RADIUS_CUT` (Conn, Gould and Toint 2000, section 6.1).
const ACCEPTED_RATIO: f64 = 0.05;
const GOOD_RATIO: f64 = 0.7;
const POOR_RATIO: f64 = 0.25;
const RADIUS_GROWTH: f64 = 3.0;
const RADIUS_CUT: f64 = 0.3;

/// With contacts the radius grows to this multiple of a step; the shift of the second derivative changes by these factors after a step
/// that is refused, and after one that is accepted (Levenberg 1944; Marquardt 1963).
const RADIUS_OVER_STEP: f64 = 4.0;
const MORE_DAMPING: f64 = 4.0;
const LESS_DAMPING: f64 = 1.0 / 16.0;

/// A refused step below this part of the radius was limited by the shift, not by the radius: the shift grows, and the radius becomes
/// `1 / RADIUS_CUT` times the step. Smaller than `RADIUS_CUT`, so that rounding cannot lead to the same step and radius again.
const WELL_WITHIN: f64 = 0.25;

/// A start whose forces balance to this part is nearly an equilibrium; contacts need not be softened on the way to it.
const NEARLY_EQUILIBRIUM: f64 = 1e-2;

/// A search ends where surfaces overlap by this part of their thickness and a step leads beyond it: those on the way only come closer to it.
const NEARLY_SUNK: f64 = 0.99;

/// Work below this part of the energies is rounding.
const ROUNDING_OF_WORK: f64 = 1e-11;

/// Forces that balance to this part do so to rounding.
const BALANCED_TO_ROUNDING: f64 = 1e-13;

/// If no step, however short, improves the balance, forces that balance to this part are in equilibrium to rounding.
const NEARLY_BALANCED: f64 = 1e-8;

/// If forces balance to this part, but their error has not halved within [`MAX_STALE_STEPS`] steps, the shape is fixed along directions whose
/// stiffness is below [`IDLE_STIFFNESS`] of the magnitude of the forces and along which these balance to [`IDLE_FORCE`].
const SETTLING_ERROR: f64 = 1e-5;
const MAX_STALE_STEPS: usize = 5;
const IDLE_STIFFNESS: f64 = 1e-7;
const IDLE_FORCE: f64 = 1e-11;

/// Newton steps of this length, in sizes, have the same effect.
const NEARLY_THERE: f64 = 1e-9;

/// After a step below the rounding of coordinates, in sizes, a residual below the second part of the forces is rounding of stiff
/// contacts, and any residual whose Newton step is as short is rounding of gaps: without loads there are no other forces.
const ROUNDING_OF_STEPS: f64 = 1e-13;
const ROUNDING_OF_FORCES: f64 = 1e-6;

/// After a Newton step of this length, in sizes, the error is its square, hence rounding.
const QUADRATIC_STEP: f64 = 1e-7;

/// A shape that is farther than this, in sizes, from the nearest closed one is open, however small its gaps are: near singular shapes,
/// such as an exactly straight rope, gaps are squares of distances. Gaps below the second number, relative to their sizes, are
/// rounding.
const LARGEST_CLOSED_DISTANCE: f64 = 1e-7;
const ROUNDING_OF_GAPS: f64 = 1e-13;

/// Shapes of loops that the rounding of gaps moves by more than this part of sizes are near a singular position. Their multipliers are
/// undetermined if that motion changes them by more than the second part.
const MOVED_BY_ROUNDING: f64 = 1e-12;
const UNDETERMINED_MULTIPLIERS: f64 = 1e-4;

/// A model is not held if it moves by this many sizes in a step, or by [`FAR_STEP`] sizes without a relative change of forces: farther away,
/// gaps of loops are rounding.
pub(super) const UNSUPPORTED_STEP: f64 = 1e9;
const FAR_STEP: f64 = 1e6;
const UNCHANGED_FORCES: f64 = 1e-9;

/// Smallest error of the balance by which steps are regularised: the default tolerance of equilibria.
const LEAST_ERROR: f64 = 1e-10;

/// Maximum number of saddles that a search leaves.
const MAX_SADDLES: usize = 5;
const ESCAPING_RADIUS: f64 = 0.1;

/// How a search has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ended {
    Converged,
    IterationLimit,
    Stalled,
    /// Steps grow without end.
    Unheld,
    Invalid(InvalidShape),
    NonFinite,
    /// The forces have no potential in the last shape.
    WithoutPotential,
}

/// The last shape of a search.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) q: Vec<f64>,
    pub(super) ended: Ended,
    /// Length of the next Newton step, or of the last one, in sizes.
    pub(super) step_norm: f64,
    /// Norm of the residual forces times sizes, in joules.
    pub(super) residual_norm: f64,
    /// Multipliers of loops, followed by those of tendons that do not stretch.
    pub(super) multipliers: Vec<f64>,
    pub(super) counters: Counters,
}

/// What a search should find.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    pub(super) tolerance: f64,
    pub(super) max_iter: usize,
    /// Whether saddles are left.
    pub(super) is_stable: bool,
}

/// Searches an equilibrium from a shape, at first from the nearest one in which loops and tendons are closed.
pub(super) fn search(
    model: &mut dyn Static,
    q0: &[f64],
    goal: Goal,
    monitor: Monitor<'_>,
) -> Result<Found, InterruptedSearch> {
    let mut q = q0.to_vec();
    if model.facts().constraints() > 0 {
        // A shape that stays open is reported at the end.
        closing::close(model, &mut q);
    }
    let mut search = Search::new(model, q, monitor)?;
    let ended = search.search_with_soft_contacts(goal).map(|ended| search.explained(ended));
    search.problem.model.soften_contact(None);
    match ended {
        Ok(ended) => Ok(search.found(ended)),
        Err(Interrupted) => {
            let (q, counters) = (search.shape.q, search.problem.counters);
            Err(InterruptedSearch::with(Reached { q, load_factor: 1.0, path: Path::default(), counters }))
        }
    }
}

/// Distance of a shape from equilibrium: the largest relative change of its forces that would balance them. Does not change the shape.
pub(super) fn error_of_balance(
    model: &mut dyn Static,
    q: &[f64],
    monitor: Monitor<'_>,
) -> Result<f64, Interrupted> {
    Ok(Search::new(model, q.to_vec(), monitor)?.balance.error)
}

/// Whether rounding of gaps determines the multipliers of loops in a shape. Does not change the shape.
pub(super) fn multipliers_are_rounding(model: &mut dyn Static, q: &[f64]) -> bool {
    let mut never_interrupt = || Ok(());
    let search = Search::new(model, q.to_vec(), &mut never_interrupt);
    search.is_ok_and(|mut search| search.multipliers_are_rounding())
}

/// Whether a shape is not close to one with closed loops and with taut tendons of their commanded lengths. Does not change the shape.
pub(super) fn is_open(model: &mut dyn Static, q: &[f64]) -> bool {
    let (m, n) = (model.facts().constraints(), q.len());
    let (mut gaps, mut sizes) = (vec![0.0; m], vec![0.0; n]);
    model.gaps(q, &mut gaps);
    model.sizes(q, &mut sizes);
    for (gap, size) in gaps.iter_mut().zip(&model.facts().gap_sizes) {
        *gap = if gap.abs() > ROUNDING_OF_GAPS * size { *gap } else { 0.0 };
    }
    let mut rows = Matrix::zeros(m, n);
    model.gap_jacobian(q, &mut rows);
    constraint::forget_unmoved(&mut rows, &sizes, &model.facts().gap_sizes);
    chart::rows(&model.facts().rotation_vectors, q, &mut rows);
    let constraints = IndependentRows::new(&problem::scaled(&rows, &sizes));
    norm(&times(&constraints.transform, &gaps)) > LARGEST_CLOSED_DISTANCE
}

/// State of a search that persists between steps.
struct Progress {
    radius: f64,
    /// Remaining number of saddles that may be left.
    escapes: usize,
    /// The error before the last step, and its length.
    before: f64,
    last: f64,
    /// The smallest error, the number of steps since it last halved, and whether that exceeds [`MAX_STALE_STEPS`].
    best: f64,
    stale: usize,
    is_settling: bool,
    /// Whether a shift of the second derivative limits steps, and the shift.
    is_damped: bool,
    damping: f64,
}

impl Progress {
    fn new(escapes: usize, is_damped: bool) -> Self {
        let far = f64::INFINITY;
        let (radius, damping, is_settling) = (FIRST_RADIUS, 0.0, false);
        Self { radius, escapes, before: far, last: far, best: far, stale: 0, is_settling, is_damped, damping }
    }

    fn record_error(&mut self, error: f64) {
        (self.stale, self.best) =
            if error < 0.5 * self.best { (0, error) } else { (self.stale + 1, self.best) };
        self.is_settling |= error < SETTLING_ERROR && self.stale > MAX_STALE_STEPS;
    }

    /// The radius after a step that did this part of the predicted work.
    fn resize(&mut self, ratio: f64, length: f64, shift: f64) {
        let may_grow = self.radius < 1.0 || shift > 0.5 * self.radius;
        if ratio < POOR_RATIO {
            self.radius = 0.5 * length;
        } else if self.is_damped && may_grow {
            // Steps are short where surfaces begin to touch, and may be longer afterwards.
            self.radius = self.radius.max(RADIUS_OVER_STEP * length);
        } else if ratio > GOOD_RATIO && length > 0.8 * self.radius && may_grow {
            self.radius *= RADIUS_GROWTH;
        }
    }
}

/// The quadratic problem of a step, in normalised coordinates; `constraints` are those of closed loops.
struct Local {
    hessian: Matrix,
    gradient: Vec<f64>,
    constraints: IndependentRows,
    rows: Matrix,
    excess: Vec<f64>,
    stiffness: Vec<f64>,
    is_one_sided: Vec<bool>,
    regularisation: Vec<f64>,
    taut: Vec<bool>,
}

impl Local {
    fn linearised(&self) -> Linearised<'_> {
        let Self { gradient, constraints, rows, excess, stiffness, is_one_sided, .. } = self;
        Linearised { gradient, constraints, rows, excess, stiffness, is_one_sided }
    }

    /// The length of Newton's step.
    fn next(&self, metric: &[f64]) -> f64 {
        let next = self.linearised().solve(&self.hessian, &self.taut);
        next.map_or(f64::INFINITY, |next| step::length(&next.x, metric))
    }

    /// Whether the energy falls to second order in a free direction.
    fn is_saddle(&self) -> bool {
        let mut regular = self.hessian.clone();
        self.regularisation.iter().enumerate().for_each(|(k, x)| regular[(k, k)] += x);
        let none = vec![0.0; self.gradient.len()];
        let holds = |row: usize| self.taut[row] || !self.is_one_sided[row];
        let excess: Vec<f64> =
            (0..self.taut.len()).map(|row| if holds(row) { 0.0 } else { f64::NEG_INFINITY }).collect();
        let at_rest = Linearised { gradient: &none, excess: &excess, ..self.linearised() };
        at_rest.solve(&regular, &self.taut).is_none()
    }
}

/// An accepted step: its end, the fraction of the predicted work that it does, its length, by how much it shifts coordinates, and
/// whether the model is not held along it.
struct AcceptedStep {
    shape: Shape,
    balance: Balance,
    ratio: f64,
    length: f64,
    shift: f64,
    is_unsupported: bool,
}

enum Tried {
    AcceptedStep(Box<AcceptedStep>),
    /// No step was short enough; with the problem of the last shape, if it was invalid.
    Refused(Option<InvalidShape>),
    /// Softened surfaces have passed through each other.
    Deep,
}

struct Search<'a> {
    problem: Problem<'a>,
    shape: Shape,
    scale: Scale,
    balance: Balance,
    is_one_sided: Vec<bool>,
    /// Sizes moved since the scale was found.
    moved: f64,
    step_norm: f64,
    /// The largest overlap of softened contacts so far, over the thickness of the surfaces; `None` if contacts are not softened.
    deepest: Option<f64>,
}

impl<'a> Search<'a> {
    fn new(model: &'a mut dyn Static, q: Vec<f64>, monitor: Monitor<'a>) -> Result<Self, Interrupted> {
        let mut problem = Problem::new(model, monitor);
        let shape = problem.shape(q)?;
        let scale = Scale::new(&mut problem, &shape.q);
        let balance = Balance::new(&problem, &shape, &scale);
        let is_one_sided = (0..shape.excess.len()).map(|row| problem.is_one_sided(row)).collect();
        Ok(Self {
            problem,
            shape,
            scale,
            balance,
            is_one_sided,
            moved: 0.0,
            step_norm: f64::NAN,
            deepest: None,
        })
    }

    fn found(self, ended: Ended) -> Found {
        let Self { problem, shape, scale, balance, step_norm, .. } = self;
        let residual: f64 =
            balance.gradient.iter().zip(&scale.sizes).map(|(force, size)| (force * size).powi(2)).sum();
        let rigid = (0..shape.excess.len()).filter(|&row| problem.is_rigid(row));
        let multipliers =
            balance.multipliers.iter().copied().chain(rigid.map(|row| balance.tensions[row])).collect();
        Found {
            ended,
            step_norm,
            residual_norm: residual.sqrt(),
            multipliers,
            counters: problem.counters,
            q: shape.q,
        }
    }

    /// Searches with soft contacts first, if there are any.
    fn search_with_soft_contacts(&mut self, goal: Goal) -> Result<Ended, Interrupted> {
        if !self.problem.model.facts().has_contact || self.balance.error < NEARLY_EQUILIBRIUM {
            return self.descend(goal);
        }
        let start = self.shape.q.clone();
        let mut stiffness_continuation = StiffnessContinuation::new(&mut *self.problem.model, &start);
        let mut left = goal.max_iter;
        while stiffness_continuation.soften(&mut *self.problem.model) && left > 0 {
            self.deepest = Some(0.0);
            self.reevaluate()?;
            let before = self.problem.counters.iterations;
            // Half of the iterations are reserved for the next searches.
            let loose = Goal {
                tolerance: SOFT_TOLERANCE,
                max_iter: MAX_SOFT_ITERATIONS.min(left.div_ceil(2)),
                ..goal
            };
            let ended = self.descend(loose)?;
            if ended == Ended::WithoutPotential {
                return Ok(ended);
            }
            left = left.saturating_sub(self.problem.counters.iterations - before);
            let overlap = self.overlap();
            let deepest = match ended {
                Ended::Converged | Ended::IterationLimit => self.deepest.unwrap_or(0.0),
                _ => f64::INFINITY,
            };
            let fraction = stiffness_continuation.fraction();
            match stiffness_continuation.next_start(overlap, deepest, ended == Ended::Converged) {
                NextStart::LastShape if ended == Ended::Converged => {
                    self.follow_obstacles(&stiffness_continuation, fraction)?;
                }
                NextStart::LastShape => {}
                NextStart::WithoutContact => break,
                NextStart::InitialShape => self.shape.q.clone_from(&start),
            }
        }
        self.problem.model.soften_contact(None);
        self.deepest = None;
        self.reevaluate()?;
        self.descend(Goal { max_iter: left, ..goal })
    }

    /// Moves the shape with the surfaces of obstacles that shrink between the search with `fraction` and the next one, to first order (Euler
    /// predictor: Allgower and Georg 1990, section 2.1): what touches stays in contact, instead of falling across the gap.
    fn follow_obstacles(
        &mut self,
        stiffness_continuation: &StiffnessContinuation,
        fraction: f64,
    ) -> Result<(), Interrupted> {
        /// Fraction of the change for which forces are differenced: the ends of overlaps hardly move.
        const DIFFERENCE_FRACTION: f64 = 1e-4;
        stiffness_continuation.shrink(&mut *self.problem.model, fraction, DIFFERENCE_FRACTION);
        let shrunk = self.problem.shape(self.shape.q.clone())?;
        if shrunk.force == self.shape.force {
            return Ok(());
        }
        stiffness_continuation.shrink(&mut *self.problem.model, fraction, 0.0);
        let Some(mut local) = self.local(false, self.balance.error) else { return Ok(()) };
        let change =
            shrunk.force.iter().zip(&self.shape.force).map(|(new, old)| (new - old) / DIFFERENCE_FRACTION);
        local.gradient = change.zip(&self.scale.w).map(|(force, w)| force * w).collect();
        let linearised = local.linearised();
        let bounds = Bounds { scale: &self.scale, radius: FIRST_RADIUS };
        let Local { hessian, regularisation, taut, .. } = &local;
        let solution = step::damped(&linearised, hessian, regularisation, bounds, taut, &mut 0.0);
        let Some(solution) = solution else { return Ok(()) };
        let length = step::length(&solution.x, &self.scale.metric(FIRST_RADIUS));
        let Self { problem, shape, scale, .. } = self;
        let new = step::retracted(problem, shape, scale, &linearised, &solution, &local.constraints, length)?;
        if let Some(new) = new
            && new.force.iter().all(|force| force.is_finite())
            && self.problem.model.invalid_shape(&new.q).is_none()
            && self.passage(&new, length) == Passage::Free
        {
            self.shape = new;
        }
        Ok(())
    }

    /// Evaluates the shape again, after contacts have changed.
    fn reevaluate(&mut self) -> Result<(), Interrupted> {
        self.shape = self.problem.shape(std::mem::take(&mut self.shape.q))?;
        self.scale = Scale::new(&mut self.problem, &self.shape.q);
        self.balance = Balance::new(&self.problem, &self.shape, &self.scale);
        self.moved = 0.0;
        Ok(())
    }

    /// Whether softened surfaces overlap so far that they may be on either side of obstacles.
    fn is_deep(&mut self) -> bool {
        self.deepest.is_some() && self.overlap() > DEEP_OVERLAP
    }

    /// Whether surfaces overlap by almost their thickness.
    fn is_nearly_sunk(&mut self) -> bool {
        let [_, deepest] = self.problem.model.deepest_overlaps(&self.shape.q);
        deepest.is_some_and(|overlap| overlap.share > NEARLY_SUNK)
    }

    /// The largest overlap over the thickness of the thinner surface.
    fn overlap(&mut self) -> f64 {
        let [deepest, _] = self.problem.model.deepest_overlaps(&self.shape.q);
        deepest.map_or(0.0, |overlap| overlap.share)
    }

    fn descend(&mut self, goal: Goal) -> Result<Ended, Interrupted> {
        // Contacts set in abruptly: steps are limited by a shift of the second derivative, which hardly affects stiff directions.
        let is_damped = self.problem.model.facts().has_contact;
        let mut so_far = Progress::new(if goal.is_stable { MAX_SADDLES } else { 0 }, is_damped);
        for _ in 0..goal.max_iter {
            self.problem.counters.iterations += 1;
            let mut error = self.balance.error;
            if !error.is_finite() {
                return Ok(Ended::NonFinite);
            }
            so_far.record_error(error);
            let Some(local) = self.local(so_far.is_settling, error) else {
                let is_finite = self.shape.force.iter().all(|force| force.is_finite());
                return Ok(if is_finite { Ended::WithoutPotential } else { Ended::NonFinite });
            };
            let is_pressed = !self.shape.contact_force.is_empty() && so_far.damping == 0.0;
            // What balances to rounding may be a saddle, which is left below.
            if so_far.last < ROUNDING_OF_STEPS
                && error > BALANCED_TO_ROUNDING
                && (error < if is_pressed { NEARLY_EQUILIBRIUM } else { ROUNDING_OF_FORCES }
                    || local.next(&self.scale.metric(1.0)) < ROUNDING_OF_STEPS)
            {
                return Ok(Ended::Converged);
            }
            if error <= goal.tolerance.max(BALANCED_TO_ROUNDING) {
                let next = local.next(&self.scale.metric(so_far.radius));
                let is_end = error <= BALANCED_TO_ROUNDING
                    || next <= goal.tolerance
                    || error > 0.1 * so_far.before
                    || so_far.last < QUADRATIC_STEP;
                if is_end {
                    self.step_norm = next.min(so_far.last);
                    if so_far.escapes == 0 || !local.is_saddle() {
                        return Ok(Ended::Converged);
                    }
                    so_far.escapes -= 1;
                    (so_far.radius, error) = (ESCAPING_RADIUS, 1.0);
                }
            }
            let tried = self.try_steps(&local, &mut so_far, error)?;
            so_far.damping *= LESS_DAMPING;
            let AcceptedStep { shape, balance, ratio, length, shift, is_unsupported } = match tried {
                Tried::AcceptedStep(accepted) => *accepted,
                Tried::Deep => return Ok(Ended::Stalled),
                Tried::Refused(invalid_shape) => {
                    // Rounding of the shape causes forces of stiff contacts and stops that no step can reduce.
                    let next = local.next(&self.scale.metric(1.0));
                    if next < NEARLY_THERE || error < NEARLY_BALANCED {
                        self.step_norm = next.min(so_far.last);
                        return Ok(Ended::Converged);
                    }
                    return Ok(invalid_shape.map_or(Ended::Stalled, Ended::Invalid));
                }
            };
            so_far.resize(ratio, length, shift);
            if is_unsupported {
                return Ok(Ended::Unheld);
            }
            (so_far.before, so_far.last) = (error, length);
            (self.shape, self.balance) = (shape, balance);
            if let Some(deepest) = self.deepest {
                self.deepest = Some(deepest.max(self.overlap()));
            }
            self.step_norm = length;
            self.rescale(length);
        }
        Ok(Ended::IterationLimit)
    }

    /// The quadratic problem of a step from the shape; `None` if the forces have no potential. If the search `is_settling`, the shape is
    /// fixed along the softest directions.
    fn local(&mut self, is_settling: bool, error: f64) -> Option<Local> {
        let hessian = self.hessian()?;
        let n = self.problem.n();
        let w = &self.scale.w;
        let hessian = Matrix::from_fn(n, n, |i, j| hessian[(i, j)] * w[i] * w[j]);
        let constraints = IndependentRows::new(&self.scale.rows(&self.shape.gap_rows));
        let rows = self.scale.rows(&self.shape.rows);
        let taut: Vec<bool> = self.balance.tensions.iter().map(|tension| *tension > 0.0).collect();
        let gradient = if is_settling {
            let active: Vec<bool> =
                taut.iter().zip(&self.is_one_sided).map(|(taut, tendon)| *taut || !tendon).collect();
            self.without_idle_residuals(&quadratic::softest(
                &hessian,
                &constraints,
                &rows,
                &self.problem.stiffness,
                &active,
            ))
        } else {
            self.gradient()
        };
        Some(Local {
            hessian,
            gradient,
            constraints,
            rows,
            excess: self.shape.excess.clone(),
            stiffness: self.problem.stiffness.clone(),
            is_one_sided: self.is_one_sided.clone(),
            regularisation: self.scale.regularisation(error.max(LEAST_ERROR), &self.balance.work),
            taut,
        })
    }

    /// A step that does enough of the predicted work, within a radius that shrinks until one does.
    fn try_steps(&mut self, local: &Local, so_far: &mut Progress, error: f64) -> Result<Tried, Interrupted> {
        let size = self.problem.energies(&self.shape.q) + self.problem.spring_energy(&self.shape);
        let is_leaving = so_far.radius == ESCAPING_RADIUS && error == 1.0;
        let is_damped = so_far.is_damped && !is_leaving;
        let (linearised, mut invalid_shape) = (local.linearised(), None);
        let Local { hessian, regularisation, taut, .. } = local;
        while so_far.radius > SMALLEST_RADIUS {
            let radius = so_far.radius;
            let solution = if is_damped {
                let bounds = Bounds { scale: &self.scale, radius };
                step::damped(&linearised, hessian, regularisation, bounds, taut, &mut so_far.damping)
            } else {
                step::within(&linearised, hessian, regularisation, &self.scale, radius, taut)
            };
            let Some(solution) = solution else { break };
            let length = step::length(&solution.x, &self.scale.metric(radius));
            let Self { problem, shape, scale, .. } = self;
            let new =
                step::retracted(problem, shape, scale, &linearised, &solution, &local.constraints, length)?;
            if let Some(new) = new
                && new.force.iter().all(|force| force.is_finite())
            {
                invalid_shape = self
                    .problem
                    .model
                    .invalid_shape(&new.q)
                    .filter(|invalid_shape| matches!(invalid_shape, InvalidShape::Inverted { .. }));
                let passage =
                    if invalid_shape.is_none() { self.passage(&new, length) } else { Passage::Free };
                if passage != Passage::Free && self.is_deep() {
                    return Ok(Tried::Deep);
                }
                if let Passage::Sunk(_) = passage
                    && self.is_nearly_sunk()
                {
                    return Ok(Tried::Refused(passage.invalid_shape()));
                }
                if invalid_shape.is_none() && passage == Passage::Free {
                    let decrease = predicted(&linearised, hessian, &solution.x);
                    let done = self.problem.work(&self.shape, &new)?;
                    let balance = Balance::new(&self.problem, &new, &self.scale);
                    let ratio = if decrease > ROUNDING_OF_WORK * size {
                        done / decrease
                    } else if balance.error < 2.0 * error || done > 0.0 {
                        1.0
                    } else {
                        0.0
                    };
                    if ratio > ACCEPTED_RATIO {
                        let straight = -dot(&local.gradient, &solution.x);
                        let is_unsupported = length > UNSUPPORTED_STEP
                            || length > FAR_STEP
                                && (decrease - straight).abs() < UNCHANGED_FORCES * straight.abs();
                        let shift = self.scale.shift(&solution.x);
                        let accepted =
                            AcceptedStep { shape: new, balance, ratio, length, shift, is_unsupported };
                        return Ok(Tried::AcceptedStep(Box::new(accepted)));
                    }
                }
            }
            if is_damped && length < WELL_WITHIN * radius {
                let steepest = linearised.steepest(&self.scale.metric(radius));
                so_far.damping = MORE_DAMPING * so_far.damping.max(FIRST_SHIFT * steepest);
                so_far.radius = radius.min(length / RADIUS_CUT);
            } else {
                so_far.radius = RADIUS_CUT * radius.min(length);
            }
        }
        Ok(Tried::Refused(invalid_shape))
    }

    fn hessian(&mut self) -> Option<Matrix> {
        let Balance { raw_gradient, multipliers, tensions, work, .. } = &self.balance;
        self.problem.hessian(&self.shape, raw_gradient, multipliers, tensions, &self.scale.sizes, work)
    }

    /// The reason why a search has failed: the forces may have no potential in the last shape.
    fn explained(&mut self, ended: Ended) -> Ended {
        if !matches!(ended, Ended::IterationLimit | Ended::Stalled) {
            return ended;
        }
        self.problem.is_conservative = false;
        match self.hessian() {
            Some(_) => ended,
            None => Ended::WithoutPotential,
        }
    }

    /// Whether rounding of gaps determines the multipliers. Example: a straight rope under a transverse weight, whose gap is the square of
    /// its sag, so that a shape that is closed to rounding balances any weight.
    fn multipliers_are_rounding(&mut self) -> bool {
        if self.shape.gaps.is_empty() {
            return false;
        }
        let Scale { sizes, w, .. } = &self.scale;
        let constraints = IndependentRows::new(&self.scale.rows(&self.shape.gap_rows));
        let rounding = |k: usize| -> f64 {
            let gap_sizes = self.problem.model.facts().gap_sizes.iter();
            constraints
                .transform
                .row(k)
                .iter()
                .zip(gap_sizes)
                .map(|(t, size)| (t * size).abs() * f64::EPSILON)
                .sum()
        };
        // Displacements by that rounding.
        let moved: Vec<DVector<f64>> = (0..constraints.rows.nrows())
            .map(|k| {
                let most = rounding(k);
                DVector::from_fn(w.len(), |j, _| w[j] * constraints.rows[(k, j)] * most)
            })
            .filter(|moved| moved.iter().zip(sizes).any(|(x, size)| x.abs() > MOVED_BY_ROUNDING * size))
            .collect();
        if moved.is_empty() {
            return false;
        }
        let multipliers = &self.balance.multipliers;
        let geometric = self.problem.stiffness_of_loops(&self.shape.q, multipliers);
        let mut of_loops = vec![0.0; w.len()];
        add_transposed(&self.shape.gap_rows, multipliers, &mut of_loops);
        let normalised = |forces: &[f64]| norm(&forces.iter().zip(w).map(|(f, w)| f * w).collect::<Vec<_>>());
        let most = normalised(&of_loops);
        moved
            .iter()
            .any(|moved| normalised((&geometric * moved).as_slice()) > UNDETERMINED_MULTIPLIERS * most)
    }

    /// Gradient along normalised coordinates, without the forces of elastic tendons and springs. Residuals at the level of rounding are set to
    /// zero: they would cause large steps along directions without stiffness.
    fn gradient(&self) -> Vec<f64> {
        let Balance { gradient, work, .. } = &self.balance;
        let is_rounding = |(force, work): &(&f64, &f64)| force.abs() <= BALANCED_TO_ROUNDING * **work;
        let mut gradient: Vec<f64> =
            gradient.iter().zip(work).map(|x| if is_rounding(&x) { 0.0 } else { *x.0 }).collect();
        let back: Vec<f64> = self.balance.tensions.iter().map(|tension| -tension).collect();
        add_transposed(&self.shape.rows, &back, &mut gradient);
        gradient.iter().zip(&self.scale.w).map(|(force, w)| force * w).collect()
    }

    /// The same without residuals along directions without stiffness that are rounding or errors of quadrature: they would move the shape
    /// forever, such as a rope that turns about its axis, because every step along the orbit has an error of its square.
    fn without_idle_residuals(&self, softest: &[(f64, Vec<f64>)]) -> Vec<f64> {
        let Balance { gradient, work, tensions, .. } = &self.balance;
        let w = &self.scale.w;
        let normalised = |forces: &[f64]| -> Vec<f64> { forces.iter().zip(w).map(|(f, w)| f * w).collect() };
        let (mut left, work, resistance) =
            (normalised(gradient), normalised(work), self.scale.regularisation(1.0, work));
        for (stiffness, x) in softest {
            let sum = |of: &dyn Fn(usize) -> f64| (0..x.len()).map(of).sum::<f64>();
            let (force, most) = (dot(&left, x), sum(&|k| work[k] * x[k].abs()));
            let is_idle = stiffness.abs() <= IDLE_STIFFNESS * sum(&|k| resistance[k] * x[k] * x[k]);
            if is_idle && force.abs() <= IDLE_FORCE * most {
                left.iter_mut().zip(x).for_each(|(left, x)| *left -= force * x);
            }
        }
        let mut of_tendons = vec![0.0; w.len()];
        add_transposed(&self.shape.rows, tensions, &mut of_tendons);
        left.iter().zip(normalised(&of_tendons)).map(|(left, of_tendons)| left - of_tendons).collect()
    }

    /// Recomputes the sizes of coordinates, which change slowly with the shape, after moving by a part of them.
    fn rescale(&mut self, length: f64) {
        const RESCALING_DISTANCE: f64 = 0.3;
        self.moved += length;
        if self.moved > RESCALING_DISTANCE {
            self.moved = 0.0;
            self.scale = Scale::new(&mut self.problem, &self.shape.q);
            self.balance = Balance::new(&self.problem, &self.shape, &self.scale);
        }
    }

    /// What surfaces do on the way to a shape.
    fn passage(&mut self, to: &Shape, length: f64) -> Passage {
        Passage::between(&mut *self.problem.model, [&self.shape.q, &to.q], length)
    }
}

/// Decrease of the energy by a step, as predicted by its quadratic problem.
fn predicted(linearised: &Linearised<'_>, hessian: &Matrix, x: &[f64]) -> f64 {
    let moved = times(linearised.rows, x);
    let of_row = |row: usize| {
        let (k, c) = (linearised.stiffness[row], linearised.excess[row]);
        if k.is_infinite() {
            return 0.0;
        }
        let there = c + moved[row];
        let (here, there) =
            if linearised.is_one_sided[row] { (c.max(0.0), there.max(0.0)) } else { (c, there) };
        0.5 * k * (here - there) * (here + there)
    };
    -(dot(linearised.gradient, x) + 0.5 * dot(x, &times(hessian, x)))
        + (0..moved.len()).map(of_row).sum::<f64>()
}
