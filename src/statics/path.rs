//! The path of equilibria over the load factor, by pseudo-arclength continuation (Keller 1977, "Numerical solution of
//! bifurcation and nonlinear eigenvalue problems").
//!
//! Arc length is measured in scaled coordinates and the load factor together: one radian of the whole rod counts as much
//! as the whole load. Steps are as long as Newton's method contracts well (den Heijer and Rheinboldt 1981, "On steplength
//! algorithms for a class of continuation methods"), and each one is checked: when stiffnesses have changed sign, the
//! critical points in between are found; when there are none, the step has jumped to another path and is taken back.

use super::corrector::{self, Corrected, correct, correct_held};
use super::equations::{Equations, Linear, State, Step};
use super::stability::{NEUTRAL, Stiffness};
use crate::constraint::one_sided::most_switches;
use crate::error::Interrupted;
use crate::linalg::{dot, norm, norm_inf};
use crate::model::Flaw;
use crate::roots::bracket::{Point, find_zero};
use crate::stability::Stability;

/// The first contraction rate that steps aim at: about four iterations a step.
const WANTED_RATE: f64 = 0.1;

/// How much longer the next step may be.
const LARGEST_GROWTH: f64 = 4.0;

/// How much shorter a step that failed is tried again.
const CUT: f64 = 0.25;

/// The step that is tried where the distance to the goal is unknown.
const FIRST_STEP: f64 = 1.0;

/// First step away from a bifurcation, where two paths are still close together.
const FIRST_STEP_OF_BRANCH: f64 = 0.1;

/// Steps shorter than that are not worth going on with.
const SHORTEST_STEP: f64 = 1e-9;

/// Nor are steps shorter than that towards shapes that are none.
const SHORTEST_STEP_TO_FLAW: f64 = 1e-4;

/// A step that ends farther from where its direction pointed, relative to its length, is tried again shorter. The
/// load factor is looked at for itself: where a little load moves much, paths of very different loads are close to
/// each other.
const LARGEST_DEVIATION: f64 = 0.5;

/// So is one in which the path turns by more than 60 degrees: it may have come to another path.
const SMALLEST_COSINE: f64 = 0.5;

/// How far behind a corner (where a tendon becomes slack, say) the path is looked for: in load factors. By then steps up to it
/// have become shorter than [`SHORTEST_STEP`].
const STEP_OVER_CORNER: f64 = 1e-5;

/// Behind a corner the coordinates have moved by at most that many times as much as along either side of it.
const ALONG_CORNER: f64 = 2.0;

/// A stiffness that has changed sign was zero in between if it can be made that small, relative to its values before and
/// after.
const ZERO: f64 = 1e-5;

/// Eigenvalues with imaginary parts below that part of the elastic stiffness are real: rounding and what is left of a
/// potential make pairs of two that are equal.
const REAL: f64 = 1e-5;

/// A path leaves in the direction that is asked for where the smallest stiffness is below that part of the elastic
/// one; elsewhere there is only one path.
const CRITICAL: f64 = 1e-6;

/// Critical points that close to each other, relative to the step, are one.
const SAME: f64 = 1e-5;

/// How a path is followed.
#[derive(Clone, Debug)]
pub(super) struct Course {
    /// Load factors at which the path ends.
    pub(super) bounds: [f64; 2],
    /// Increasing load factors up to the upper bound, it included, at which a step has to end.
    pub(super) stops: Vec<f64>,
    pub(super) max_step: f64,
    pub(super) max_steps: usize,
    pub(super) tolerance: f64,
}

/// What a critical point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CriticalKind {
    /// The load factor has an extremum: beyond it there is no equilibrium nearby (snap-through).
    Limit,
    /// Paths cross (buckling).
    Bifurcation,
}

impl CriticalKind {
    /// As one word in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Limit => "limit",
            Self::Bifurcation => "bifurcation",
        }
    }
}

/// A point of a path at which a stiffness is zero.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalPoint {
    /// What it is.
    pub kind: CriticalKind,
    /// It lies between this point of the path and the next.
    pub index: usize,
    /// Load factor.
    pub load_factor: f64,
    /// Inputs, shape (m,), where they are what grows; else empty.
    pub inputs: Vec<f64>,
    /// Coordinates, shape (n,).
    pub q: Vec<f64>,
    /// Directions without stiffness, one after the other, n numbers each; each of norm one in the scaled coordinates.
    pub directions: Vec<f64>,
}

/// Equilibria in the order in which they were found, and the critical points between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// Load factors, shape (m,).
    pub load_factor: Vec<f64>,
    /// Inputs one after the other, m numbers each, where they are what grows; else empty.
    pub inputs: Vec<f64>,
    /// Coordinates one after the other, n numbers each.
    pub q: Vec<f64>,
    /// Smallest eigenvalue of the tangent stiffness relative to that of material and springs, shape (m,).
    pub lowest: Vec<f64>,
    /// What small disturbances do, shape (m,); `None` where the mass matrix is singular.
    pub stability: Vec<Option<Stability>>,
    /// Critical points.
    pub critical: Vec<CriticalPoint>,
}

/// Why a path ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    UpperBound,
    LowerBound,
    StepTooSmall,
    TooManySteps,
    /// Beyond, equilibria are shapes that the model does not have.
    Flawed(Flaw),
}

/// The last equilibrium of a path.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) state: State,
    /// Of the path there, of scaled norm one.
    direction: Step,
    pub(super) stiffness: Stiffness,
    pub(super) linear: Linear,
    pub(super) corrected: Corrected,
}

/// Equilibria followed one after the other.
pub(super) struct Follower<'a, 'b> {
    pub(super) equations: &'a mut Equations<'b>,
    pub(super) path: Path,
    course: Course,
    is_branch: bool,
    /// Scaled change of the coordinates with the load factor at the start.
    compliance: f64,
    /// Why the last step led nowhere, where it led to a shape that is none.
    pub(super) flaw: Option<Flaw>,
}

impl<'a, 'b> Follower<'a, 'b> {
    pub(super) fn new(equations: &'a mut Equations<'b>, course: Course) -> Self {
        Self { equations, path: Path::default(), course, is_branch: false, compliance: 0.0, flaw: None }
    }

    /// The equilibrium near `start` at its load factor, from which the path goes to larger load factors, or along
    /// `direction` (coordinates) where that is given, to that side of it. `None` when there is none nearby.
    pub(super) fn start(
        &mut self,
        mut start: State,
        direction: Option<&[f64]>,
    ) -> Result<Option<Place>, Interrupted> {
        let n = start.q.len();
        let mut at_load_factor = vec![0.0; n + 1];
        at_load_factor[n] = 1.0;
        let Some(mut linear) = self.equations.linearise(&start)? else { return Ok(None) };
        let residual_norm = linear.residual_norm;
        let mut corrected = Corrected { rate: 0.0, step_norm: 0.0, residual_norm };
        let tolerance = self.course.tolerance;
        // Where a branch begins the tangent is singular, so that what is an equilibrium already is left alone.
        if norm_inf(&linear.natural.coordinates(&linear.residual)) > tolerance {
            let load_factor = start.load_factor;
            match self.land_switched(&mut start, load_factor)? {
                Some(done) => corrected = done,
                None => return Ok(None),
            }
            let Some(there) = self.equations.linearise(&start)? else { return Ok(None) };
            linear = there;
        }
        self.flaw = self.equations.flaw(&start.q);
        if self.flaw.is_some() {
            return Ok(None);
        }
        let stiffness = Stiffness::new(&linear);
        let forward: Vec<f64> = match direction {
            Some(direction) => {
                let scaled = direction.iter().zip(&self.equations.sizes).map(|(d, s)| d / s);
                let scaled: Vec<f64> = scaled.chain([0.0]).collect();
                let size = norm(&scaled);
                scaled.into_iter().map(|x| x / size).collect()
            }
            None => at_load_factor,
        };
        self.is_branch = direction.is_some() && stiffness.smallest() <= CRITICAL;
        let direction = if self.is_branch {
            Some(linear.moved(forward))
        } else {
            corrector::direction(&linear, &forward)
        };
        let Some(direction) = direction else { return Ok(None) };
        // Along a branch nothing is known of it; the deviation of the whole state has to do.
        self.compliance =
            if self.is_branch { 0.0 } else { norm(&direction.scaled[..n]) / direction.load_factor().abs() };
        let place = Place { state: start, direction, stiffness, linear, corrected };
        self.record(&place)?;
        Ok(Some(place))
    }

    /// Follows the path from a place to an end of its course; the place goes along.
    pub(super) fn follow(&mut self, place: &mut Place) -> Result<End, Interrupted> {
        let mut step = if self.is_branch { FIRST_STEP_OF_BRANCH } else { f64::INFINITY };
        for _ in 0..self.course.max_steps {
            let target = self.target(place);
            loop {
                let rate = place.direction.load_factor();
                let to_target = (target - place.state.load_factor) / rate;
                let longest = step.min(self.course.max_step);
                let is_landing = to_target > 0.0 && to_target <= longest;
                let mut length = if is_landing { to_target } else { longest };
                if !length.is_finite() {
                    length = FIRST_STEP;
                }
                let landing = is_landing.then_some(target);
                if let Some(next) = self.step(place, length, landing)? {
                    let growth = (WANTED_RATE / next.corrected.rate).sqrt().min(LARGEST_GROWTH);
                    step = length * growth;
                    *place = next;
                    break;
                }
                step = length * CUT;
                match self.flaw {
                    Some(flaw) if step < SHORTEST_STEP_TO_FLAW => return Ok(End::Flawed(flaw)),
                    None if step < SHORTEST_STEP => match self.step_over_corner(place)? {
                        Some(next) => {
                            step = FIRST_STEP_OF_BRANCH;
                            *place = next;
                            break;
                        }
                        None => return Ok(End::StepTooSmall),
                    },
                    _ => {}
                }
            }
            self.record(place)?;
            let [lower, upper] = self.course.bounds;
            if place.state.load_factor >= upper {
                return Ok(End::UpperBound);
            }
            if place.state.load_factor <= lower {
                return Ok(End::LowerBound);
            }
        }
        Ok(End::TooManySteps)
    }

    /// The load factor that the path goes to next.
    fn target(&self, place: &Place) -> f64 {
        let load_factor = &place.state.load_factor;
        if place.direction.load_factor() < 0.0 {
            return self.course.bounds[0];
        }
        let next = self.course.stops.iter().find(|stop| **stop > *load_factor);
        next.copied().unwrap_or(self.course.bounds[1])
    }

    /// A step of that length, or to the load factor of `landing`. `None` when it has to be shorter.
    fn step(
        &mut self,
        place: &Place,
        length: f64,
        landing: Option<f64>,
    ) -> Result<Option<Place>, Interrupted> {
        self.flaw = None;
        let mut state = place.state.clone();
        state.advance(&place.direction, length, &self.equations.sizes);
        let (predicted, sizes) = (state.clone(), self.equations.sizes.clone());
        let allowance =
            (length / self.compliance).max((predicted.load_factor - place.state.load_factor).abs());
        let is_near = |state: &State| {
            norm(&state.since(&predicted, &sizes).scaled) <= LARGEST_DEVIATION * length
                && (state.load_factor - predicted.load_factor).abs() <= LARGEST_DEVIATION * allowance
        };
        let corrected = match landing {
            Some(target) => self.land(&mut state, target)?.filter(|_| is_near(&state)),
            None => {
                let tolerance = self.course.tolerance;
                let along = correct(self.equations, &mut state, &place.direction.scaled, tolerance)?;
                let along = along.filter(|_| is_near(&state));
                match (along, self.passed(place, &state)) {
                    (Some(_), Some(target)) => {
                        let whole = state.since(&place.state, &self.equations.sizes);
                        let part = (target - place.state.load_factor) / whole.load_factor();
                        state = place.state.clone();
                        state.advance(&whole, part, &self.equations.sizes);
                        self.land(&mut state, target)?
                    }
                    (along, _) => along,
                }
            }
        };
        let Some(corrected) = corrected else { return Ok(None) };
        self.flaw = self.equations.flaw(&state.q);
        if self.flaw.is_some() {
            return Ok(None);
        }
        if self.equations.would_switch(&state)? {
            return Ok(None);
        }
        let Some(linear) = self.equations.linearise(&state)? else { return Ok(None) };
        let stiffness = Stiffness::new(&linear);
        let direction = corrector::direction(&linear, &place.direction.scaled);
        // At a bifurcation there is no single direction: a step just beyond will find one.
        let Some(direction) = direction.filter(|_| stiffness.lowest.is_finite()) else { return Ok(None) };
        if dot(&direction.scaled, &place.direction.scaled) < SMALLEST_COSINE {
            return Ok(None);
        }
        let next = Place { state, direction, stiffness, linear, corrected };
        Ok(self.find_critical_points(place, &next)?.then_some(next))
    }

    /// The place a little behind a corner, at which the path turns at once and no stiffness changes its sign. `None` where
    /// there is none: the path is another one.
    fn step_over_corner(&mut self, place: &Place) -> Result<Option<Place>, Interrupted> {
        let forward = place.direction.load_factor().signum();
        let mut state = place.state.clone();
        // From the shape that is there: it is beyond the corner already, since what makes one depends on the load factor.
        let target = place.state.load_factor + forward * STEP_OVER_CORNER;
        let Some(corrected) = self.land_switched(&mut state, target)? else { return Ok(None) };
        let Some(linear) = self.equations.linearise(&state)? else { return Ok(None) };
        let stiffness = Stiffness::new(&linear);
        let n = state.q.len();
        let mut along_load_factor = vec![0.0; n + 1];
        along_load_factor[n] = forward;
        let Some(direction) = corrector::direction(&linear, &along_load_factor) else { return Ok(None) };
        let slope = |direction: &Step| norm(&direction.scaled[..n]) / direction.load_factor().abs();
        let steepest = slope(&direction).max(slope(&place.direction));
        let moved = norm(&state.since(&place.state, &self.equations.sizes).scaled[..n]);
        let is_near = moved <= ALONG_CORNER * STEP_OVER_CORNER * steepest;
        let is_same = place.stiffness.changes_until(&stiffness).is_empty();
        self.flaw = self.equations.flaw(&state.q);
        let is_good = is_near && is_same && self.flaw.is_none() && stiffness.lowest.is_finite();
        Ok(is_good.then_some(Place { state, direction, stiffness, linear, corrected }))
    }

    /// The equilibrium near a state at the load factor `target`.
    fn land(&mut self, state: &mut State, target: f64) -> Result<Option<Corrected>, Interrupted> {
        state.load_factor = target;
        let mut at_load_factor = vec![0.0; state.q.len() + 1];
        at_load_factor[state.q.len()] = 1.0;
        correct(self.equations, state, &at_load_factor, self.course.tolerance)
    }

    /// The same with those constraints, of those that hold one way only, that pull there.
    fn land_switched(&mut self, state: &mut State, target: f64) -> Result<Option<Corrected>, Interrupted> {
        for _ in 0..most_switches(state.forces.len()) {
            let landed = self.land(state, target)?;
            if landed.is_none() || !self.equations.switch(state)? {
                return Ok(landed);
            }
        }
        Ok(None)
    }

    /// The load factor between a place and a state at which the path has to stop.
    fn passed(&self, place: &Place, state: &State) -> Option<f64> {
        let (from, to) = (place.state.load_factor, state.load_factor);
        let stop = self.course.stops.iter().find(|stop| from < **stop && **stop < to);
        stop.copied().or((to < self.course.bounds[0]).then_some(self.course.bounds[0]))
    }

    /// The equilibrium at a part t of the way between two places.
    fn between(
        &mut self,
        from: &Place,
        whole: &Step,
        t: f64,
    ) -> Result<Option<(State, Linear, Stiffness)>, Interrupted> {
        let mut state = from.state.clone();
        state.advance(whole, t, &self.equations.sizes);
        let tolerance = self.course.tolerance;
        let corrected = correct_held(self.equations, &mut state, &from.direction.scaled, tolerance)?;
        let linear = if corrected.is_some() { self.equations.linearise(&state)? } else { None };
        Ok(linear.map(|linear| {
            let stiffness = Stiffness::new(&linear);
            (state, linear, stiffness)
        }))
    }

    /// Finds the critical points between two places. False when there should be some but are none.
    fn find_critical_points(&mut self, from: &Place, to: &Place) -> Result<bool, Interrupted> {
        // A branch that starts at a critical point has it behind.
        let changes = if self.is_branch && self.path.load_factor.len() == 1 {
            0..0
        } else {
            from.stiffness.changes_until(&to.stiffness)
        };
        let sizes = self.equations.sizes.clone();
        let whole = to.state.since(&from.state, &sizes);
        let mut found: Vec<(f64, usize, State, Linear, Stiffness)> = Vec::new();
        for place in changes {
            let [a, b] = [from, to].map(|end| match end.stiffness.eigenvalue(place).re {
                // A path that begins or ends at a critical point.
                value if value.abs() <= NEUTRAL => 0.0,
                value => value,
            });
            let at = find_zero(Point { t: 0.0, value: a }, Point { t: 1.0, value: b }, |t| {
                let between = self.between(from, &whole, t)?;
                Ok(between.map_or(f64::NAN, |(.., stiffness)| stiffness.eigenvalue(place).re))
            })?;
            let Some((state, linear, stiffness)) = self.between(from, &whole, at)? else { return Ok(false) };
            let value = stiffness.eigenvalue(place);
            let is_zero = value.re.abs() <= NEUTRAL.max(ZERO * a.abs().max(b.abs()));
            if !is_zero {
                return Ok(false);
            }
            // The real part of a pair: there is no equilibrium nearby but that of the path.
            if value.im.abs() > REAL {
                continue;
            }
            match found.iter_mut().find(|(other, ..)| (other - at).abs() <= SAME) {
                Some((_, multiplicity, ..)) => *multiplicity += 1,
                None => found.push((at, 1, state, linear, stiffness)),
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, multiplicity, state, linear, stiffness) in found {
            let Some((directions, is_pushed)) = stiffness.softest(multiplicity, &linear.load) else {
                return Ok(false);
            };
            let directions = directions
                .into_iter()
                .flat_map(|direction| {
                    direction.into_iter().zip(&sizes).map(|(d, s)| d * s).collect::<Vec<_>>()
                })
                .collect();
            self.path.critical.push(CriticalPoint {
                kind: if is_pushed { CriticalKind::Limit } else { CriticalKind::Bifurcation },
                index: self.path.load_factor.len() - 1,
                load_factor: state.load_factor,
                inputs: self.equations.inputs_at(state.load_factor),
                q: state.q,
                directions,
            });
        }
        Ok(true)
    }

    fn record(&mut self, place: &Place) -> Result<(), Interrupted> {
        let verdict = self.equations.verdict(&place.state, &place.linear, &place.stiffness)?;
        self.path.load_factor.push(place.state.load_factor);
        self.path.inputs.extend(self.equations.inputs_at(place.state.load_factor));
        self.path.q.extend_from_slice(&place.state.q);
        self.path.lowest.push(place.stiffness.lowest);
        self.path.stability.push(verdict.map(|verdict| verdict.stability));
        Ok(())
    }
}
