//! Paths of equilibria over the load factor, by pseudo-arclength continuation (Keller 1977, "Numerical
//! solution of bifurcation and nonlinear eigenvalue problems").
//!
//! Arc length is measured in scaled coordinates and the load factor together: one radian of the whole rod
//! counts as much as the full load. The contraction of Newton's method determines the step length (den Heijer
//! and Rheinboldt 1981, "On steplength algorithms for a class of continuation methods"). Every step is
//! checked: if stiffnesses have changed sign, the critical points in between are located; if none are found,
//! the step has jumped to another path and is undone.

use super::corrector::{self, Corrected, correct, correct_held};
use super::equations::{Equations, Linear, State, Step};
use super::stability::{NEUTRAL, Stiffness};
use super::tunnelling::Passage;
use crate::analysis::stability::Stability;
use crate::error::Interrupted;
use crate::model::InvalidShape;
use crate::model::constraint::one_sided::most_switches;
use crate::numerics::linalg::{dot, norm, norm_inf};
use crate::numerics::roots::bracket::{Point, find_zero};

/// Target of the first contraction rate: about four iterations per step.
const WANTED_RATE: f64 = 0.1;

/// Largest ratio of successive step lengths.
const LARGEST_GROWTH: f64 = 4.0;

/// Factor of the step length after a failed step.
const FAILED_STEP_FACTOR: f64 = 0.25;

/// Length of the first step if the distance to the goal is unknown.
const FIRST_STEP: f64 = 1.0;

/// Length of the first step away from a bifurcation, where both paths are still close.
const FIRST_STEP_OF_BRANCH: f64 = 0.1;

/// The path ends if steps become shorter than this.
const SHORTEST_STEP: f64 = 1e-9;

/// Limit of the step length towards invalid shapes.
const SHORTEST_STEP_TO_INVALID: f64 = 1e-4;

/// Largest deviation of a step's end from its predicted end, relative to the step's length; beyond, the step
/// is shortened. The load factor is checked separately, because in flexible models paths with very different
/// loads are close together.
const LARGEST_DEVIATION: f64 = 0.5;

/// Longest turn of a coordinate in a step, in radians: with soft springs, longer ones would end on another winding. Longer turns are
/// accepted if the path deviates from a straight line by at most the second number, in scaled coordinates, as for a moment that
/// rolls a rod up.
const LONGEST_TURN: f64 = 2.0;
const STRAIGHT: f64 = 1e-6;

/// Steps in which the path turns by more than 60 degrees are shortened: they may have reached another path.
const SMALLEST_COSINE: f64 = 0.5;

/// Distance in load factors at which the path is searched behind a corner, such as where a tendon becomes
/// slack. Steps up to the corner have then become shorter than [`SHORTEST_STEP`].
const STEP_OVER_CORNER: f64 = 1e-5;

/// Longest step over a corner in scaled coordinates: soft models move far within [`STEP_OVER_CORNER`].
const LONGEST_OVER_CORNER: f64 = 0.01;

/// Steps over a corner are not made shorter than this, in load factors: near limit points the load factor does
/// not measure steps.
const SHORTEST_STEP_OVER_CORNER: f64 = 1e-10;

/// Largest change of the coordinates across a corner, relative to the change along either side.
const ALONG_CORNER: f64 = 2.0;

/// A stiffness that changed sign has a zero in between if it can be made this small, relative to its values
/// before and after.
const ZERO_STIFFNESS: f64 = 1e-5;

/// Eigenvalues with imaginary parts below this fraction of the elastic stiffness count as real: rounding, and
/// forces that are not exactly conservative, turn equal real eigenvalues into pairs.
const REAL_EIGENVALUE: f64 = 1e-5;

/// A path can start in a given direction only if the smallest stiffness is below this fraction of the elastic
/// one; elsewhere there is only one path.
const CRITICAL_STIFFNESS: f64 = 1e-6;

/// Critical points closer than this, relative to the step, count as one.
const SAME_POINT: f64 = 1e-5;

/// Limits of a path.
#[derive(Clone, Debug)]
pub(super) struct PathLimits {
    /// Load factors at which the path ends.
    pub(super) bounds: [f64; 2],
    /// Increasing load factors, up to and including the upper bound, at which a step must end.
    pub(super) stops: Vec<f64>,
    pub(super) max_step: f64,
    pub(super) max_steps: usize,
    pub(super) tolerance: f64,
}

/// Kind of a critical point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CriticalKind {
    /// Limit point: the load factor has an extremum, beyond which there is no equilibrium nearby
    /// (snap-through).
    Limit,
    /// Bifurcation: paths cross (buckling).
    Bifurcation,
}

impl CriticalKind {
    /// The name as one word in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Limit => "limit",
            Self::Bifurcation => "bifurcation",
        }
    }
}

/// A point of a path with zero stiffness in some direction.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalPoint {
    /// Kind.
    pub kind: CriticalKind,
    /// Index of the path's point before the critical point.
    pub index: usize,
    /// Load factor.
    pub load_factor: f64,
    /// Inputs, shape (m,), if inputs grow; otherwise empty.
    pub inputs: Vec<f64>,
    /// Coordinates, shape (n,).
    pub q: Vec<f64>,
    /// Directions without stiffness, n numbers each, with norm one in scaled coordinates.
    pub directions: Vec<f64>,
}

/// Equilibria in the order of the path, and the critical points between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    /// Load factors, shape (m,).
    pub load_factor: Vec<f64>,
    /// Inputs of each point, m numbers each, if inputs grow; otherwise empty.
    pub inputs: Vec<f64>,
    /// Coordinates of each point, n numbers each.
    pub q: Vec<f64>,
    /// Smallest eigenvalue of the tangent stiffness relative to that of material and springs, shape (m,).
    pub lowest: Vec<f64>,
    /// Stability, shape (m,); `None` if the mass matrix is singular, if it was not requested or its computation was interrupted, and
    /// before the end of a path of growing loads, for which only the end is judged.
    pub stability: Vec<Option<Stability>>,
    /// Critical points.
    pub critical: Vec<CriticalPoint>,
}

/// Reason why a path ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    UpperBound,
    LowerBound,
    StepTooSmall,
    TooManySteps,
    /// Further equilibria are invalid shapes.
    Invalid(InvalidShape),
}

/// Last equilibrium of a path.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) state: State,
    /// Direction of the path, with scaled norm one.
    direction: Step,
    pub(super) stiffness: Stiffness,
    pub(super) corrected: Corrected,
}

/// Follows a path of equilibria.
pub(super) struct Follower<'a, 'b> {
    pub(super) equations: &'a mut Equations<'b>,
    pub(super) path: Path,
    limits: PathLimits,
    is_branch: bool,
    /// Scaled derivative of the coordinates with respect to the load factor at the start.
    compliance: f64,
    /// Problem of the invalid shape to which the last step led, if any.
    pub(super) invalid_shape: Option<InvalidShape>,
    /// Whether a long turn has deviated from its prediction, so that no more are allowed.
    is_winding: bool,
}

impl<'a, 'b> Follower<'a, 'b> {
    pub(super) fn new(equations: &'a mut Equations<'b>, limits: PathLimits) -> Self {
        Self {
            equations,
            path: Path::default(),
            limits,
            is_branch: false,
            compliance: 0.0,
            invalid_shape: None,
            is_winding: false,
        }
    }

    /// Finds the equilibrium near `start` at its load factor. From there the path goes to larger load
    /// factors, or to the side of `direction` (coordinates) if given. `None` if there is no equilibrium
    /// nearby.
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
        let tolerance = self.limits.tolerance;
        // At the start of a branch the tangent is singular; do not correct a state that is in equilibrium
        // already.
        if norm_inf(&linear.normalised.coordinates(&linear.residual)) > tolerance {
            let (load_factor, given) = (start.load_factor, start.clone());
            match self.correct_at_target_with_active_set(&mut start, load_factor)? {
                Some(done) => corrected = done,
                None => return Ok(None),
            }
            if self.is_blocked(&given, &start) {
                return Ok(None);
            }
            let Some(there) = self.equations.linearise(&start)? else { return Ok(None) };
            linear = there;
        }
        self.invalid_shape = self.equations.invalid_shape(&start.q);
        if self.invalid_shape.is_some() {
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
        self.is_branch = direction.is_some() && stiffness.smallest() <= CRITICAL_STIFFNESS;
        let direction = if self.is_branch {
            Some(linear.moved(forward))
        } else {
            corrector::direction(&linear, &forward)
        };
        let Some(direction) = direction else { return Ok(None) };
        // Unknown along a branch; there only the deviation of the whole state is checked.
        self.compliance =
            if self.is_branch { 0.0 } else { norm(&direction.scaled[..n]) / direction.load_factor().abs() };
        let place = Place { state: start, direction, stiffness, corrected };
        self.record(&place)?;
        Ok(Some(place))
    }

    /// Follows the path from a place to the end of its limits, and updates the place.
    pub(super) fn follow(&mut self, place: &mut Place) -> Result<End, Interrupted> {
        let mut step = if self.is_branch { FIRST_STEP_OF_BRANCH } else { f64::INFINITY };
        for _ in 0..self.limits.max_steps {
            let target = self.target(place);
            loop {
                let rate = place.direction.load_factor();
                let to_target = (target - place.state.load_factor) / rate;
                let mut longest = step.min(self.limits.max_step);
                if self.is_winding {
                    longest = longest.min(self.longest_turn(place));
                }
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
                step = length * FAILED_STEP_FACTOR;
                match self.invalid_shape {
                    Some(invalid_shape) if step < SHORTEST_STEP_TO_INVALID => {
                        return Ok(End::Invalid(invalid_shape));
                    }
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
            self.fold(place)?;
            self.record(place)?;
            let [lower, upper] = self.limits.bounds;
            if place.state.load_factor >= upper {
                return Ok(End::UpperBound);
            }
            if place.state.load_factor <= lower {
                return Ok(End::LowerBound);
            }
        }
        Ok(End::TooManySteps)
    }

    fn longest_turn(&self, place: &Place) -> f64 {
        let turns = place.direction.scaled.iter().take(place.state.q.len()).enumerate();
        let turns = turns.filter(|(k, _)| self.equations.model.facts().turns[*k]).map(|(_, rate)| rate.abs());
        LONGEST_TURN / turns.fold(0.0, f64::max)
    }

    /// Rewrites a place with rotation vectors no longer than pi: at 2 pi generalised forces vanish under any moment.
    fn fold(&mut self, place: &mut Place) -> Result<(), Interrupted> {
        let Place { state, direction, .. } = place;
        let (n, sizes) = (state.q.len(), self.equations.sizes.clone());
        let mut rates: Vec<f64> = direction.scaled[..n].iter().zip(&sizes).map(|(d, s)| d * s).collect();
        if !self.equations.fold(&mut state.q, &mut rates) {
            return Ok(());
        }
        direction.scaled.iter_mut().zip(rates).zip(&sizes).for_each(|((d, rate), s)| *d = rate / s);
        let size = norm(&direction.scaled);
        direction.scaled.iter_mut().chain(&mut direction.forces).for_each(|x| *x /= size);
        if let Some(linear) = self.equations.linearise(state)? {
            place.stiffness = Stiffness::new(&linear);
        }
        Ok(())
    }

    /// Next load factor at which the path must stop.
    fn target(&self, place: &Place) -> f64 {
        let load_factor = &place.state.load_factor;
        if place.direction.load_factor() < 0.0 {
            return self.limits.bounds[0];
        }
        let next = self.limits.stops.iter().find(|stop| **stop > *load_factor);
        next.copied().unwrap_or(self.limits.bounds[1])
    }

    /// Makes a step of this length, or to the load factor of `landing`. `None` if the step must be shortened.
    fn step(
        &mut self,
        place: &Place,
        length: f64,
        landing: Option<f64>,
    ) -> Result<Option<Place>, Interrupted> {
        self.invalid_shape = None;
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
            Some(target) => self.correct_at_target(&mut state, target)?.filter(|_| is_near(&state)),
            None => {
                let tolerance = self.limits.tolerance;
                let along = correct(self.equations, &mut state, &place.direction.scaled, tolerance)?;
                let along = along.filter(|_| is_near(&state));
                match (along, self.passed(place, &state)) {
                    (Some(_), Some(target)) => {
                        let whole = state.since(&place.state, &self.equations.sizes);
                        let part = (target - place.state.load_factor) / whole.load_factor();
                        state = place.state.clone();
                        state.advance(&whole, part, &self.equations.sizes);
                        self.correct_at_target(&mut state, target)?
                    }
                    (along, _) => along,
                }
            }
        };
        let Some(corrected) = corrected else { return Ok(None) };
        if length > self.longest_turn(place) && norm(&state.since(&predicted, &sizes).scaled) > STRAIGHT {
            self.is_winding = true;
            return Ok(None);
        }
        self.invalid_shape = self.equations.invalid_shape(&state.q);
        if self.invalid_shape.is_some() || self.is_blocked(&place.state, &state) {
            return Ok(None);
        }
        if self.equations.would_switch(&state)? {
            return Ok(None);
        }
        let Some(linear) = self.equations.linearise(&state)? else { return Ok(None) };
        let stiffness = Stiffness::new(&linear);
        let direction = corrector::direction(&linear, &place.direction.scaled);
        // At a bifurcation there is no unique direction: a step just beyond will find one.
        let Some(direction) = direction.filter(|_| stiffness.lowest.is_finite()) else { return Ok(None) };
        if dot(&direction.scaled, &place.direction.scaled) < SMALLEST_COSINE {
            return Ok(None);
        }
        let next = Place { state, direction, stiffness, corrected };
        Ok(self.find_critical_points(place, &next)?.then_some(next))
    }

    /// The place just behind a corner, at which the path changes its direction without a change in the sign
    /// of a stiffness. `None` if the path there is a different one.
    fn step_over_corner(&mut self, place: &Place) -> Result<Option<Place>, Interrupted> {
        let forward = place.direction.load_factor().signum();
        let rate = place.direction.load_factor().abs();
        let mut step = STEP_OVER_CORNER;
        let mut state = place.state.clone();
        if LONGEST_OVER_CORNER * rate >= SHORTEST_STEP_OVER_CORNER {
            // Start on the straight continuation beyond the corner: Newton's method may not contract across it.
            step = step.min(LONGEST_OVER_CORNER * rate);
            state.advance(&place.direction, step / rate, &self.equations.sizes);
        }
        let target = place.state.load_factor + forward * step;
        let Some(corrected) = self.correct_at_target_with_active_set(&mut state, target)? else {
            return Ok(None);
        };
        let Some(linear) = self.equations.linearise(&state)? else { return Ok(None) };
        let stiffness = Stiffness::new(&linear);
        let n = state.q.len();
        let mut along_load_factor = vec![0.0; n + 1];
        along_load_factor[n] = forward;
        let Some(direction) = corrector::direction(&linear, &along_load_factor) else { return Ok(None) };
        let slope = |direction: &Step| norm(&direction.scaled[..n]) / direction.load_factor().abs();
        let steepest = slope(&direction).max(slope(&place.direction));
        let moved = norm(&state.since(&place.state, &self.equations.sizes).scaled[..n]);
        let is_near = moved <= ALONG_CORNER * step * steepest;
        let is_same = place.stiffness.changes_until(&stiffness).is_empty();
        self.invalid_shape = self.equations.invalid_shape(&state.q);
        let is_good = is_near
            && is_same
            && self.invalid_shape.is_none()
            && stiffness.lowest.is_finite()
            && !self.is_blocked(&place.state, &state);
        Ok(is_good.then_some(Place { state, direction, stiffness, corrected }))
    }

    /// Whether surfaces pass through each other on the way between two states, or are sunk into each other at the end: the equilibrium
    /// behind an obstacle is another one.
    fn is_blocked(&mut self, from: &State, to: &State) -> bool {
        let step = to.since(from, &self.equations.sizes);
        let length = norm(&step.scaled[..to.q.len()]);
        let passage = self.equations.passage([&from.q, &to.q], length);
        self.invalid_shape = passage.invalid_shape();
        passage != Passage::Free
    }

    /// Finds the equilibrium near a state at the load factor `target`.
    fn correct_at_target(
        &mut self,
        state: &mut State,
        target: f64,
    ) -> Result<Option<Corrected>, Interrupted> {
        state.load_factor = target;
        let mut at_load_factor = vec![0.0; state.q.len() + 1];
        at_load_factor[state.q.len()] = 1.0;
        correct(self.equations, state, &at_load_factor, self.limits.tolerance)
    }

    /// The same with the set of active one-sided constraints at `target`.
    fn correct_at_target_with_active_set(
        &mut self,
        state: &mut State,
        target: f64,
    ) -> Result<Option<Corrected>, Interrupted> {
        for _ in 0..most_switches(state.forces.len()) {
            let landed = self.correct_at_target(state, target)?;
            if landed.is_none() || !self.equations.switch(state)? {
                return Ok(landed);
            }
        }
        Ok(None)
    }

    /// Load factor between a place and a state at which the path must stop.
    fn passed(&self, place: &Place, state: &State) -> Option<f64> {
        let (from, to) = (place.state.load_factor, state.load_factor);
        let stop = self.limits.stops.iter().find(|stop| from < **stop && **stop < to);
        stop.copied().or((to < self.limits.bounds[0]).then_some(self.limits.bounds[0]))
    }

    /// Equilibrium at the fraction t between two places.
    fn between(
        &mut self,
        from: &Place,
        whole: &Step,
        t: f64,
    ) -> Result<Option<(State, Linear, Stiffness)>, Interrupted> {
        let mut state = from.state.clone();
        state.advance(whole, t, &self.equations.sizes);
        let tolerance = self.limits.tolerance;
        let corrected = correct_held(self.equations, &mut state, &from.direction.scaled, tolerance)?;
        let linear = if corrected.is_some() { self.equations.linearise(&state)? } else { None };
        Ok(linear.map(|linear| {
            let stiffness = Stiffness::new(&linear);
            (state, linear, stiffness)
        }))
    }

    /// Locates the critical points between two places. Returns false if a critical point is missing.
    fn find_critical_points(&mut self, from: &Place, to: &Place) -> Result<bool, Interrupted> {
        // A branch that starts at a critical point need not find this point again.
        let changes = if self.is_branch && self.path.load_factor.len() == 1 {
            0..0
        } else {
            from.stiffness.changes_until(&to.stiffness)
        };
        let sizes = self.equations.sizes.clone();
        let whole = to.state.since(&from.state, &sizes);
        let mut found: Vec<(f64, usize, State, Linear, Stiffness)> = Vec::new();
        for place in changes {
            // A zero real part of a complex pair is no critical point.
            if [from, to].iter().all(|end| end.stiffness.eigenvalue(place).im.abs() > REAL_EIGENVALUE) {
                continue;
            }
            let [a, b] = [from, to].map(|end| match end.stiffness.eigenvalue(place).re {
                // A path that starts or ends at a critical point.
                value if value.abs() <= NEUTRAL => 0.0,
                value => value,
            });
            let at = find_zero(Point { t: 0.0, value: a }, Point { t: 1.0, value: b }, |t| {
                let between = self.between(from, &whole, t)?;
                Ok(between.map_or(f64::NAN, |(.., stiffness)| stiffness.eigenvalue(place).re))
            })?;
            let Some((state, linear, stiffness)) = self.between(from, &whole, at)? else { return Ok(false) };
            let value = stiffness.eigenvalue(place);
            let is_zero = value.re.abs() <= NEUTRAL.max(ZERO_STIFFNESS * a.abs().max(b.abs()));
            if !is_zero {
                return Ok(false);
            }
            if value.im.abs() > REAL_EIGENVALUE {
                continue;
            }
            match found.iter_mut().find(|(other, ..)| (other - at).abs() <= SAME_POINT) {
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
        let verdict = self.equations.judgement(&place.state);
        self.path.load_factor.push(place.state.load_factor);
        self.path.inputs.extend(self.equations.inputs_at(place.state.load_factor));
        self.path.q.extend_from_slice(&place.state.q);
        self.path.lowest.push(place.stiffness.lowest);
        // After an interruption the point stays, without its stability.
        self.path.stability.push(verdict.unwrap_or(None).map(|verdict| verdict.stability));
        verdict.map(|_| ())
    }
}
