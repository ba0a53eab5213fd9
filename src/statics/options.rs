//! Options of the search for equilibria.

use super::growth::InputPath;
use crate::error::{Checker, InvalidInput};

/// Bound of the scaled norm of the last Newton step: for a rod about the error of its shape in radians.
const TOLERANCE: f64 = 1e-10;

/// Limit of the Newton iterations of a search without a path.
const MAX_ITERATIONS: usize = 500;

/// Limit of the steps along a path.
const MAX_STEPS: usize = 500;

/// Times the default for models with contact: every place that begins or ceases to touch takes an iteration of its own.
pub const ITERATIONS_OF_CONTACT: usize = 10;

/// Most load factors at which a path has to stop: at a millisecond each they take a quarter of an hour.
pub const MAX_STOPS: usize = 1_000_000;

/// Longest step of a continuation, so that the path can be drawn: a quarter of a radian of the whole rod, or of the load.
const MAX_STEP: f64 = 0.25;

/// Where a search begins, and with it what it finds.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// The unloaded model, whose loads grow step by step: the equilibrium that a careful hand would load it to, stable or
    /// not. If the path ends before the loads are there, the model is let go where it ended.
    Unloaded {
        /// Load factors in (0, 1] at which the path has to stop, increasing; the last one is where it ends.
        stops: Vec<f64>,
    },
    /// Any shape, which is let go: the stable equilibrium that it comes to rest in if all motion is damped strongly.
    Descent(Vec<f64>),
    /// A shape near the equilibrium that is wanted, stable or not, for Newton's method in a trust region.
    Newton(Vec<f64>),
}

/// How an equilibrium is searched for.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Where from. Unloaded by default, with as few steps as possible.
    pub start: Start,
    /// Stop when the Newton step is that small: `|dq / s|` with the typical sizes s of the coordinates; 1e-10 by default.
    pub tol: f64,
    /// Largest number of Newton iterations of a descent or of Newton's method; 500 by default.
    pub max_iter: usize,
    /// Largest number of steps along the path; 500 by default.
    pub max_steps: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            start: Start::Unloaded { stops: vec![1.0] },
            tol: TOLERANCE,
            max_iter: MAX_ITERATIONS,
            max_steps: MAX_STEPS,
        }
    }
}

impl Options {
    pub(super) fn check(&self, n: usize) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        match &self.start {
            Start::Unloaded { stops } => {
                /// As many as a message has room for.
                const SHOWN: usize = 10;
                let increasing = stops.windows(2).all(|pair| pair[0] < pair[1]);
                let inside = stops.iter().all(|stop| *stop > 0.0 && *stop <= 1.0);
                check.require(
                    increasing && inside && stops.last() == Some(&1.0),
                    "load_steps",
                    format_args!("{} of them: {:?} ...", stops.len(), &stops[..stops.len().min(SHOWN)]),
                    "increasing parts of the load in (0, 1], the last one 1",
                );
            }
            Start::Descent(q0) | Start::Newton(q0) => check_state(&mut check, q0, n, "q0"),
        }
        check.positive(self.tol, "tol", "scaled units of q");
        check.finish()
    }
}

/// How a path of equilibria is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct ContinuationOptions {
    /// What grows with the load factor in place of the loads, which then act as a whole; `None` by default.
    pub inputs: Option<InputPath>,
    /// Coordinates near an equilibrium at `load_factor`. By default zero; where inputs grow, what the loads lead to that
    /// grow from zero at the inputs there.
    pub q0: Option<Vec<f64>>,
    /// Where the path begins; 0 by default.
    pub load_factor: f64,
    /// The direction in which the path leaves, in coordinates: that of a critical point, to take the other branch. By
    /// default towards larger load factors.
    pub direction: Option<Vec<f64>>,
    /// The path ends at these load factors; [0, 1] by default.
    pub bounds: [f64; 2],
    /// Longest step in scaled coordinates and load factor; 0.25 by default.
    pub max_step: f64,
    /// Largest number of steps; 500 by default.
    pub max_steps: usize,
    /// As in [`Options::tol`].
    pub tol: f64,
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
        }
    }
}

impl ContinuationOptions {
    /// For n coordinates and m inputs.
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
