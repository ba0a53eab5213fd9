//! Options of searches for equilibria.

use super::load_parameter::InputPath;
use crate::error::{Checker, InvalidInput};
use crate::model::Facts;

/// Tolerance for the scaled norm of the last Newton step: for a rod about the error of its shape in radians.
const TOLERANCE: f64 = 1e-10;

/// Limit of the Newton iterations of a search without a path.
const MAX_ITERATIONS: usize = 500;

/// Limit of the steps along a path.
const MAX_STEPS: usize = 500;

/// Factor for the default limit in models with contact, where every point that begins or ceases to touch
/// takes an additional iteration.
const ITERATIONS_OF_CONTACT: usize = 10;

/// Maximum number of load factors at which a path stops: at a millisecond each they take a quarter of an
/// hour.
pub const MAX_STOPS: usize = 1_000_000;

/// Longest step of a continuation, for smooth plots: a quarter of a radian of the whole rod, or a quarter of
/// the load.
const MAX_STEP: f64 = 0.25;

/// Start of a search, which also determines the kind of equilibrium that is found.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// The unloaded model under loads that grow step by step: finds the equilibrium of quasi-static loading,
    /// stable or not. If the path ends before the full load, the model is released there.
    Unloaded {
        /// Load factors in (0, 1] at which the path stops, increasing; it ends at the last one.
        stops: Vec<f64>,
    },
    /// Any shape, which is released: finds the stable equilibrium that strongly damped motion would reach.
    Descent(Vec<f64>),
    /// A shape near the desired equilibrium, stable or not: Newton's method in a trust region.
    Newton(Vec<f64>),
}

impl Start {
    /// The first shape, of n coordinates.
    pub(super) fn shape(&self, n: usize) -> Vec<f64> {
        match self {
            Self::Unloaded { .. } => vec![0.0; n],
            Self::Descent(q0) | Self::Newton(q0) => q0.clone(),
        }
    }
}

/// Options of a search for an equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Start of the search. Default: unloaded, with as few steps as possible.
    pub start: Start,
    /// Tolerance of the Newton step `|dq / s|` with the sizes s of the coordinates ([`Elastic::sizes`](crate::model::Elastic::sizes)); 1e-10 by default.
    pub tol: f64,
    /// Maximum number of iterations of a descent or of Newton's method; 500 by default.
    pub max_iter: usize,
    /// Maximum number of steps along the path; 500 by default.
    pub max_steps: usize,
    /// Whether to judge the stability of the equilibrium, the end of its path; true by default.
    pub stability: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            start: Start::Unloaded { stops: vec![1.0] },
            tol: TOLERANCE,
            max_iter: MAX_ITERATIONS,
            max_steps: MAX_STEPS,
            stability: true,
        }
    }
}

impl Options {
    /// Options of a search that is given no start in a model with these facts. With growing loads, the path of equilibria has a kink at
    /// every new contact; a model with contact is therefore released.
    pub fn of(facts: &Facts) -> Self {
        let usual = Self::default();
        if !facts.has_contact {
            return usual;
        }
        let max_iter = ITERATIONS_OF_CONTACT * usual.max_iter;
        Self { start: Start::Descent(vec![0.0; facts.n]), max_iter, ..usual }
    }

    pub(super) fn check(&self, n: usize) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        match &self.start {
            Start::Unloaded { stops } => {
                /// Maximum number listed in a message.
                const MAX_LISTED: usize = 10;
                let increasing = stops.windows(2).all(|pair| pair[0] < pair[1]);
                let inside = stops.iter().all(|stop| *stop > 0.0 && *stop <= 1.0);
                check.require(
                    increasing && inside && stops.last() == Some(&1.0),
                    "load_steps",
                    format_args!("{} of them: {:?} ...", stops.len(), &stops[..stops.len().min(MAX_LISTED)]),
                    "increasing parts of the load in (0, 1], the last one 1",
                );
            }
            Start::Descent(q0) | Start::Newton(q0) => check_state(&mut check, q0, n, "q0"),
        }
        check.positive(self.tol, "tol", "scaled units of q");
        check.finish()
    }
}

/// Options of a path of equilibria.
#[derive(Clone, Debug, PartialEq)]
pub struct ContinuationOptions {
    /// Inputs that grow with the load factor, under the full loads; `None` (the default) scales the loads
    /// instead.
    pub inputs: Option<InputPath>,
    /// Coordinates near an equilibrium at `load_factor`. Default: zero or, if inputs grow, the shape to which
    /// loads growing from zero lead at the initial inputs.
    pub q0: Option<Vec<f64>>,
    /// Load factor at the start of the path; 0 by default.
    pub load_factor: f64,
    /// Initial direction of the path in coordinates, such as that of a critical point to follow its other
    /// branch. Default: towards larger load factors.
    pub direction: Option<Vec<f64>>,
    /// Load factors at which the path ends; [0, 1] by default.
    pub bounds: [f64; 2],
    /// Longest step in scaled coordinates and load factor; 0.25 by default.
    pub max_step: f64,
    /// Maximum number of steps; 500 by default.
    pub max_steps: usize,
    /// Tolerance, as in [`Options::tol`].
    pub tol: f64,
    /// Whether to judge the stability of every point; true by default.
    pub stability: bool,
}

impl Default for ContinuationOptions {
    fn default() -> Self {
        Self {
            inputs: None,
            q0: None,
            load_factor: 0.0,
            direction: None,
            bounds: [0.0, 1.0],
            max_step: MAX_STEP,
            max_steps: MAX_STEPS,
            tol: TOLERANCE,
            stability: true,
        }
    }
}

impl ContinuationOptions {
    /// Checks the options for n coordinates and m inputs.
    pub(super) fn check(&self, n: usize, m: usize) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        if let Some(inputs) = &self.inputs {
            inputs.check(&mut check, m);
        }
        if let Some(q0) = &self.q0 {
            check_state(&mut check, q0, n, "q0");
        }
        if let Some(direction) = &self.direction {
            check_state(&mut check, direction, n, "direction");
            let is_zero = direction.iter().all(|x| *x == 0.0);
            check.require(!is_zero, "direction", "zero", "a direction in which the path leaves");
        }
        let [lower, upper] = self.bounds;
        let ordered = lower.is_finite() && upper.is_finite() && lower < upper;
        let found = format!("({lower}, {upper})");
        if check.require(ordered, "bounds", found, "two finite numbers, the smaller one first") {
            check.require(
                (lower..=upper).contains(&self.load_factor),
                "load_factor",
                self.load_factor,
                &format!("a number between the bounds {lower} and {upper}"),
            );
        }
        check.positive(self.max_step, "max_step", "scaled units of q and load factor");
        check.positive(self.tol, "tol", "scaled units of q");
        check.finish()
    }
}

fn check_state(check: &mut Checker, values: &[f64], n: usize, place: &str) {
    check.length(values, n, place);
    check.finite(values, place);
}
