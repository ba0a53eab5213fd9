//! Derivatives of runs of the Newmark family and of Radau IIA. They are derivatives of the discrete solution:
//! the limits of finite differences of whole runs with the same steps.
//!
//! A step of Newmark's family solves `r(q, v, a, p, t) = 0` with `q = q_base + w_q a`, `v = v_base + w_v a`.
//! Hence `S da = -(K dq_base + D dv_base + r_p dp)` with `S = w_q K + w_v D + M`, all at the converged state.
//! The three stages of a step of Radau IIA solve such equations together. The forward method propagates one
//! column per parameter from step to step; the adjoint method runs backward with the transposed steps and
//! propagates one column, whatever the number of parameters.
//!
//! The derivative of a run with respect to its initial curvature:
//!
//! ```
//! use lissom::linalg::Matrix;
//! use lissom::newmark;
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::sensitivity::{Trajectory, Parameter, Parameters, Rule, forward};
//! use lissom::simulate::{Method, simulate};
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let mut wire = RobotModel::of_rod(&Rod::new(vec![segment]))?;
//! let options = newmark::Options::new(1e-3);
//! let method = Method::Newmark(options.clone());
//! let mut run = |q0: f64| simulate(wire.clone(), (0.0, 0.05), &[q0, 0.0, 0.0], &[0.0; 3], &method, None, &mut |_| Ok(()));
//! let (motion, more, less) = (run(0.5)?, run(0.501)?, run(0.499)?);
//!
//! let a = motion.a.as_ref().expect("implicit methods solve for accelerations");
//! let rule = Rule::Newmark(options.scheme);
//! let trajectory = Trajectory { t: &motion.t, q: &motion.q, v: &motion.v, a, rule, intervals: &[] };
//! let dq0 = Matrix::from_column_slice(3, 1, &[1.0, 0.0, 0.0]);
//! let mut parameters = Parameters { dq0: &dq0, dv0: &Matrix::zeros(3, 1), of: &mut [Parameter::<RobotModel>::Start] };
//! let [dq, _] = forward(&mut wire, &trajectory, &mut parameters, &mut || Ok(())).expect("regular tangents");
//! let last = motion.q.len() - 3;
//! let difference = (more.q[last] - less.q[last]) / 2e-3;
//! assert!((dq[last] - difference).abs() < 1e-4);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod equations;
mod force;
mod lengths;
mod newmark;
mod radau;
mod sections;

use std::f64::consts::PI;

use crate::description::signal::Jumps;
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::newmark::{Scheme, Step, memory};
use crate::model::Model;
use crate::numerics::linalg::{Matrix, dot};

pub use self::force::ForceDerivative;
pub use self::lengths::Lengths;
pub use self::sections::{OfInertia, Sections};

/// Called after every step; may stop the computation.
type Monitor<'a> = dyn FnMut() -> Result<(), Interrupted> + 'a;

/// Inputs that are constant during a part of a run.
#[derive(Clone, Debug)]
pub struct Interval {
    /// Index of the state at which the interval starts.
    pub first: usize,
    /// The inputs.
    pub inputs: Vec<f64>,
}

/// Integration method of a run.
#[derive(Clone, Copy, Debug)]
pub enum Rule {
    /// A member of Newmark's family, with fixed steps.
    Newmark(Scheme),
    /// [`crate::integrators::radau`], with fixed step sizes in the differentiation.
    Radau,
}

/// A recorded run: m states of n coordinates, one for every accepted step.
#[derive(Clone, Copy, Debug)]
pub struct Trajectory<'a> {
    /// Times, m of them.
    pub t: &'a [f64],
    /// Coordinates, m x n.
    pub q: &'a [f64],
    /// Velocities, m x n.
    pub v: &'a [f64],
    /// Accelerations, m x n; at the start of an interval, those with the inputs of this interval.
    pub a: &'a [f64],
    /// Method of the run.
    pub rule: Rule,
    /// Intervals in order, the first one from the start; empty if the model's own inputs apply.
    pub intervals: &'a [Interval],
}

impl Trajectory<'_> {
    /// Time and state with this index.
    fn state(&self, step: usize, n: usize) -> (f64, [&[f64]; 3]) {
        let of = step * n..(step + 1) * n;
        (self.t[step], [&self.q[of.clone()], &self.v[of.clone()], &self.a[of]])
    }

    /// The steps that fixed steps of the scheme made.
    fn steps<M: Model + ?Sized>(&self, model: &M, scheme: Scheme) -> Vec<Step> {
        let step_to = |i: usize| {
            let [t, end] = [self.t[i - 1], self.t[i]];
            let before = i.checked_sub(2).map(|before| self.t[before]);
            scheme.step(end - t, memory(|cell| model.corner(cell), before, [t, end]))
        };
        (1..self.t.len()).map(step_to).collect()
    }

    /// The first state in which a rotation vector jumped from the previous state: rotation vectors longer
    /// than half a turn are replaced by the opposite ones.
    fn turned<M: Model + ?Sized>(&self, model: &M) -> Option<usize> {
        let n = model.facts().n;
        let has_turned = |step: usize| {
            model.facts().rotation_vectors.iter().any(|&first| {
                let change = |i: usize| self.q[step * n + first + i] - self.q[(step - 1) * n + first + i];
                (0..3).map(|i| change(i) * change(i)).sum::<f64>() > PI * PI
            })
        };
        (1..self.t.len()).find(|&step| has_turned(step))
    }

    /// Last interval of the run.
    fn last_interval(&self) -> usize {
        self.intervals.len().saturating_sub(1)
    }

    /// The interval that starts at this state.
    fn interval_from(&self, step: usize) -> Option<usize> {
        self.intervals.binary_search_by_key(&step, |interval| interval.first).ok()
    }
}

/// A parameter of a run.
#[derive(Debug)]
pub enum Parameter<M: ?Sized> {
    /// A parameter that affects only the initial state.
    Start,
    /// A parameter of the model, by the derivative of the generalised forces.
    Model(Box<ForceDerivative<M>>),
    /// An input during an interval.
    Input {
        /// Index of the interval.
        interval: usize,
        /// Index of the input.
        input: usize,
    },
}

/// Parameters of a run, p of them.
#[derive(Debug)]
pub struct Parameters<'a, M: ?Sized> {
    /// Derivatives of the initial coordinates, n x p.
    pub dq0: &'a Matrix,
    /// Derivatives of the initial velocities, n x p.
    pub dv0: &'a Matrix,
    /// The parameters.
    pub of: &'a mut [Parameter<M>],
}

impl<M: ?Sized> Parameters<'_, M> {
    /// Adds to the gradient the effect of parameters on the initial coordinates and velocities, given the
    /// derivatives with respect to these.
    fn add_starts(&self, [on_q, on_v]: [&[f64]; 2], gradient: &mut [f64]) {
        for (i, gradient) in gradient.iter_mut().enumerate() {
            *gradient += dot(self.dq0.column(i).as_slice(), on_q) + dot(self.dv0.column(i).as_slice(), on_v);
        }
    }
}

/// Parameters whose derivatives are accumulated over the run in one pass.
#[derive(Clone, Debug)]
pub struct Together {
    /// Parameters of the inertia of sections.
    pub sections: Sections,
    /// Lengths of segments.
    pub lengths: Lengths,
}

/// Derivatives of coordinates and of velocities, state by state, each n x p in row-major order.
struct StateDerivatives([Vec<f64>; 2]);

impl StateDerivatives {
    fn new(capacity: usize) -> Self {
        Self([0; 2].map(|_| Vec::with_capacity(capacity)))
    }

    fn add(&mut self, state: [&Matrix; 2]) {
        for (kept, values) in self.0.iter_mut().zip(state) {
            for row in values.row_iter() {
                kept.extend(row.iter());
            }
        }
    }
}

/// Reason why derivatives could not be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The tangent at the state with this index is singular or not finite.
    Singular(usize),
    /// Before the state with this index a spherical or free joint passed half a turn, where its coordinates
    /// jump.
    Turned(usize),
    /// A user-defined function of time failed, or the caller stopped the computation.
    Interrupted,
}

impl From<Interrupted> for Failure {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// Rejects models for which runs of this method, with states at the times `t`, cannot be differentiated.
pub fn check<M: Model + ?Sized>(model: &mut M, rule: Rule, t: &[f64]) -> Result<(), InvalidInput> {
    if model.facts().has_contact && matches!(rule, Rule::Newmark(_)) {
        let expected = "method \"radau\": steps of the Newmark family into contact are not all of one scheme";
        return Err(InvalidInput::new(
            "method",
            "one of the Newmark family for surfaces that touch",
            expected,
        ));
    }
    if let Rule::Newmark(_) = rule {
        // Some steps end at corners of tables within the grid.
        model.set_steps(t.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max));
    }
    if let Some(&start) = t.first() {
        model.start_at(start);
    }
    match (model.jumps(), rule) {
        (Jumps::Velocities, _) => {
            let expected = "a cubic table, or a function: velocities that jump are not differentiated";
            return Err(InvalidInput::new("model", "a prescribed motion by a linear table", expected));
        }
        (Jumps::Accelerations, Rule::Newmark(_)) => {
            let expected = "edges that take some time, a cubic table, a function, or method \"radau\": accelerations that jump between steps are not differentiated";
            let found = "a load or command by a table that jumps, or a prescribed motion by a monotone table";
            return Err(InvalidInput::new("model", found, expected));
        }
        _ => {}
    }
    if model.facts().constraints() > 0 {
        let expected = "a robot without them: their runs are not differentiated yet (multipliers would have to be differentiated too)";
        return Err(InvalidInput::new("model", "closed loops", expected));
    }
    Ok(())
}

/// Derivatives of coordinates and velocities of all states with respect to all parameters, each m x n x p.
///
/// `monitor` is called after every step and may stop the computation.
pub fn forward<M: Model + ?Sized, F: Model + ?Sized>(
    model: &mut M,
    trajectory: &Trajectory<'_>,
    parameters: &mut Parameters<'_, F>,
    monitor: &mut dyn FnMut() -> Result<(), Interrupted>,
) -> Result<[Vec<f64>; 2], Failure> {
    if let Some(step) = trajectory.turned(model) {
        return Err(Failure::Turned(step));
    }
    let StateDerivatives(kept) = match trajectory.rule {
        Rule::Newmark(scheme) => newmark::forward(model, (trajectory, scheme), parameters, monitor),
        Rule::Radau => radau::forward(model, trajectory, parameters, monitor),
    }?;
    Ok(kept)
}

/// Gradient, with respect to all parameters, of a function with the derivatives `weights` with respect to
/// coordinates and velocities of all states, each m x n. Contributions of `together` are added.
///
/// `monitor` is called after every step and may stop the computation.
pub fn adjoint<M: Model + ?Sized, F: Model + ?Sized>(
    model: &mut M,
    trajectory: &Trajectory<'_>,
    weights: [&[f64]; 2],
    parameters: &mut Parameters<'_, F>,
    together: &mut Together,
    monitor: &mut dyn FnMut() -> Result<(), Interrupted>,
) -> Result<Vec<f64>, Failure> {
    if let Some(step) = trajectory.turned(model) {
        return Err(Failure::Turned(step));
    }
    let mut gradient = match trajectory.rule {
        Rule::Newmark(scheme) => {
            newmark::adjoint(model, (trajectory, scheme), weights, parameters, together, monitor)
        }
        Rule::Radau => radau::adjoint(model, trajectory, weights, parameters, together, monitor),
    }?;
    together.sections.add_to(&mut gradient);
    together.lengths.add_to(&mut gradient);
    Ok(gradient)
}
