//! Derivatives of runs of the Newmark family, of the discrete solution itself: what differences of whole runs converge to.
//!
//! A step solves `r(q, v, a, p, t) = 0` with `q = q_base + w_q a`, `v = v_base + w_v a`. Where that holds,
//! `S da = -(K dq_base + D dv_base + r_p dp)` with `S = w_q K + w_v D + M`, all at the converged state. Forward, the columns of all
//! parameters are carried from step to step; the adjoint goes back with the transposed steps and carries one column, whatever
//! the number of parameters.
//!
//! The derivative of a run with respect to the curvature that it starts with:
//!
//! ```
//! use lissom::linalg::Matrix;
//! use lissom::newmark;
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::sensitivity::{Course, Parameter, Parameters, forward};
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
//! let course = Course { t: &motion.t, q: &motion.q, v: &motion.v, a, scheme: options.scheme, legs: &[] };
//! let dq0 = Matrix::from_column_slice(3, 1, &[1.0, 0.0, 0.0]);
//! let mut parameters = Parameters { dq0: &dq0, dv0: &Matrix::zeros(3, 1), of: &mut [Parameter::<RobotModel>::Start] };
//! let [dq, _] = forward(&mut wire, &course, &mut parameters, &mut || Ok(())).expect("regular tangents");
//! let last = motion.q.len() - 3;
//! let difference = (more.q[last] - less.q[last]) / 2e-3;
//! assert!((dq[last] - difference).abs() < 1e-4);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod force;
mod moment;

use std::f64::consts::PI;

use self::moment::Moment;
use crate::error::{Interrupted, InvalidInput};
use crate::linalg::Matrix;
use crate::model::Model;
use crate::newmark::Scheme;

pub use self::force::ForceDerivative;

/// Inputs that were held for a part of a run.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Number of the state where it begins.
    pub first: usize,
    /// The inputs.
    pub inputs: Vec<f64>,
}

/// A run with fixed steps as it was recorded: m states of n coordinates one after the other, every accepted step of it.
#[derive(Clone, Copy, Debug)]
pub struct Course<'a> {
    /// Times, m of them.
    pub t: &'a [f64],
    /// Coordinates, m x n.
    pub q: &'a [f64],
    /// Velocities, likewise.
    pub v: &'a [f64],
    /// Accelerations, likewise; where a leg begins, those with its inputs.
    pub a: &'a [f64],
    /// The method that has made it.
    pub scheme: Scheme,
    /// Inputs from state to state, the first of them from the start on; none where the model has kept its own.
    pub legs: &'a [Leg],
}

impl Course<'_> {
    /// Time and state of this number.
    fn state(&self, step: usize, n: usize) -> (f64, [&[f64]; 3]) {
        let of = step * n..(step + 1) * n;
        (self.t[step], [&self.q[of.clone()], &self.v[of.clone()], &self.a[of]])
    }

    /// Size of the step to this state, in units of the one before too.
    fn step_to(&self, step: usize) -> (f64, f64) {
        let h = self.t[step] - self.t[step - 1];
        (h, if step > 1 { h / (self.t[step - 1] - self.t[step - 2]) } else { 1.0 })
    }

    /// The first state that has other coordinates of a rotation than the one before: rotation vectors are no longer than half a
    /// turn, so that one that grows beyond comes back from the opposite side.
    fn turned<M: Model + ?Sized>(&self, model: &M) -> Option<usize> {
        let n = model.n();
        let has_turned = |step: usize| {
            model.rotation_vectors().iter().any(|&first| {
                let change = |i: usize| self.q[step * n + first + i] - self.q[(step - 1) * n + first + i];
                (0..3).map(|i| change(i) * change(i)).sum::<f64>() > PI * PI
            })
        };
        (1..self.t.len()).find(|&step| has_turned(step))
    }

    /// The leg that begins with this state.
    fn leg_from(&self, step: usize) -> Option<usize> {
        self.legs.binary_search_by_key(&step, |leg| leg.first).ok()
    }
}

/// What a run is differentiated with respect to, beside the start.
#[derive(Debug)]
pub enum Parameter<M: ?Sized> {
    /// Nothing but the start.
    Start,
    /// A number of the model, by how the generalised forces change with it.
    Model(Box<ForceDerivative<M>>),
    /// An input of a leg.
    Input {
        /// Number of the leg.
        leg: usize,
        /// Number of the input.
        input: usize,
    },
}

/// What a run is differentiated with respect to: p parameters.
#[derive(Debug)]
pub struct Parameters<'a, M: ?Sized> {
    /// How the coordinates at the start move with each of them, n x p.
    pub dq0: &'a Matrix,
    /// Likewise the velocities.
    pub dv0: &'a Matrix,
    /// What each is, p of them.
    pub of: &'a mut [Parameter<M>],
}

/// Models that differ in a number of each of some segments' sections, with their weights in the derivatives with respect to these:
/// one difference for all of them, because the forces of a segment depend on its own sections alone.
#[derive(Debug)]
pub struct Family<M: ?Sized> {
    /// Models with [`Model::separate_segments`], and weights.
    pub terms: Vec<(Box<M>, f64)>,
    /// What the adjoint finds for each segment: the derivative of the number by the forces along it.
    pub gradient: Vec<f64>,
}

/// Why there are no derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The tangent at the state of this number is singular or not finite.
    Singular(usize),
    /// On the way to the state of this number a spherical or free joint has passed half a turn, where its coordinates change.
    Turned(usize),
    /// A function of time that somebody else provides failed, or the caller stopped.
    Interrupted,
}

impl From<Interrupted> for Failure {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// Refuses models whose runs are not differentiated.
pub fn check<M: Model + ?Sized>(model: &M) -> Result<(), InvalidInput> {
    let expected =
        |what: &str| format!("a robot without them: their runs are not differentiated yet ({what})");
    if model.has_contact() {
        let expected = "one without contact: its steps are not all of one scheme";
        return Err(InvalidInput::new("model", "surfaces that touch", expected));
    }
    if model.constraints() > 0 {
        let expected = expected("multipliers would have to be differentiated too");
        return Err(InvalidInput::new("model", "closed loops", expected));
    }
    Ok(())
}

/// Derivatives of coordinates and velocities of all states with respect to all parameters, each m x n x p one after the other.
///
/// `monitor` is asked after every step whether to go on.
pub fn forward<M: Model + ?Sized, F: Model + ?Sized>(
    model: &mut M,
    course: &Course<'_>,
    parameters: &mut Parameters<'_, F>,
    monitor: &mut dyn FnMut() -> Result<(), Interrupted>,
) -> Result<[Vec<f64>; 2], Failure> {
    let n = model.n();
    let p = parameters.of.len();
    if let Some(step) = course.turned(model) {
        return Err(Failure::Turned(step));
    }
    let mut moment = Moment::new(model, course, false);
    let (mut q, mut v) = (parameters.dq0.clone(), parameters.dv0.clone());
    let [mut a, mut before] = [0; 2].map(|_| Matrix::zeros(n, p));
    let (mut q_base, mut v_base) = (q.clone(), v.clone());
    let mut kept = [0, 1].map(|_| Vec::with_capacity(course.t.len() * n * p));

    moment.hold(0, parameters.of);
    moment.begin(0)?;
    moment.accelerations([&q, &v], parameters.of, &mut a)?;
    monitor()?;
    let mut s = a.clone();
    keep(&mut kept, &q, &v);
    for step in 1..course.t.len() {
        let (h, stretch) = course.step_to(step);
        let carried = course.scheme.carried(h, stretch);
        let weights = course.scheme.weights(h);
        for i in 0..n * p {
            let (a, s) = (a[i], s[i]);
            q_base[i] = q[i] + h * v[i] + carried.displacement[0] * a + carried.displacement[1] * s;
            v_base[i] = v[i] + carried.velocity[0] * a + carried.velocity[1] * s;
        }
        s.iter_mut().zip(a.iter()).for_each(|(s, a)| *s = carried.rest[0] * a + carried.rest[1] * *s);
        moment.end(step, weights)?;
        moment.accelerations([&q_base, &v_base], parameters.of, &mut a)?;
        for i in 0..n * p {
            q[i] = q_base[i] + weights[0] * a[i];
            v[i] = v_base[i] + weights[1] * a[i];
            s[i] += carried.gain * a[i];
        }
        if let Some(leg) = course.leg_from(step) {
            moment.hold(leg, parameters.of);
            moment.begin(step)?;
            before.copy_from(&a);
            moment.accelerations([&q, &v], parameters.of, &mut a)?;
            // The method's own accelerations are as far ahead as before.
            s += &a - &before;
        }
        monitor()?;
        keep(&mut kept, &q, &v);
    }
    Ok(kept)
}

/// Appends matrices by rows.
fn keep(kept: &mut [Vec<f64>; 2], q: &Matrix, v: &Matrix) {
    for (kept, values) in kept.iter_mut().zip([q, v]) {
        for row in values.row_iter() {
            kept.extend(row.iter());
        }
    }
}

/// The gradient of a number with respect to all parameters: `weights` are its derivatives with respect to coordinates and
/// velocities of all states, each m x n. What depends on sections of rods can be differentiated in families, to which their
/// derivatives are added.
///
/// `monitor` is asked after every step whether to go on.
pub fn adjoint<M: Model + ?Sized, F: Model + ?Sized>(
    model: &mut M,
    course: &Course<'_>,
    weights: [&[f64]; 2],
    parameters: &mut Parameters<'_, F>,
    families: &mut [Family<F>],
    monitor: &mut dyn FnMut() -> Result<(), Interrupted>,
) -> Result<Vec<f64>, Failure> {
    if let Some(step) = course.turned(model) {
        return Err(Failure::Turned(step));
    }
    let n = model.n();
    let mut gradient = vec![0.0; parameters.of.len()];
    let mut moment = Moment::new(model, course, true);
    // What a change of q, v, a and s of the state at hand does to the number.
    let [mut on_q, mut on_v, mut on_a, mut on_s] = [0; 4].map(|_| vec![0.0; n]);
    let mut lambda = vec![0.0; n];
    let hold =
        |moment: &mut Moment<'_, M>, leg, parameters: &mut Parameters<'_, F>, families: &mut [Family<F>]| {
            moment.hold(leg, parameters.of);
            if let Some(Leg { inputs, .. }) = course.legs.get(leg) {
                families
                    .iter_mut()
                    .flat_map(|family| &mut family.terms)
                    .for_each(|(model, _)| model.set_inputs(inputs));
            }
        };
    hold(&mut moment, course.legs.len().saturating_sub(1), parameters, families);
    for step in (0..course.t.len()).rev() {
        for i in 0..n {
            on_q[i] += weights[0][step * n + i];
            on_v[i] += weights[1][step * n + i];
        }
        let begins = if step == 0 { Some(0) } else { course.leg_from(step) };
        if let Some(leg) = begins {
            moment.begin(step)?;
            for i in 0..n {
                lambda[i] = -(on_a[i] + on_s[i]);
                on_a[i] = -on_s[i];
            }
            moment.back(&mut lambda, parameters.of, &mut gradient, [&mut on_q, &mut on_v])?;
            moment.back_in_families(&lambda, families)?;
            if leg > 0 {
                hold(&mut moment, leg - 1, parameters, families);
            }
        }
        if step > 0 {
            let (h, stretch) = course.step_to(step);
            let carried = course.scheme.carried(h, stretch);
            let of_a = course.scheme.weights(h);
            moment.end(step, of_a)?;
            for i in 0..n {
                lambda[i] = -(on_a[i] + of_a[0] * on_q[i] + of_a[1] * on_v[i] + carried.gain * on_s[i]);
            }
            moment.back(&mut lambda, parameters.of, &mut gradient, [&mut on_q, &mut on_v])?;
            moment.back_in_families(&lambda, families)?;
            for i in 0..n {
                let (q, v, s) = (on_q[i], on_v[i], on_s[i]);
                let of =
                    |k: usize| carried.displacement[k] * q + carried.velocity[k] * v + carried.rest[k] * s;
                on_v[i] += h * q;
                on_a[i] = of(0);
                on_s[i] = of(1);
            }
        }
        monitor()?;
    }
    for (i, gradient) in gradient.iter_mut().enumerate() {
        for j in 0..n {
            *gradient += parameters.dq0[(j, i)] * on_q[j] + parameters.dv0[(j, i)] * on_v[j];
        }
    }
    Ok(gradient)
}
