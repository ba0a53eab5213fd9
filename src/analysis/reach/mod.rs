//! Inverse kinematics: a shape of a robot that brings links to target poses.
//!
//! A least-squares problem for the errors of the targets within limits of the coordinates
//! ([`crate::numerics::roots::least_squares`]), solved from a given start and, if this fails, from further starts; then
//! an optional search for the preferred one among the shapes that reach the targets.
//!
//! ```
//! use lissom::reach::{Options, Target, reach};
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//!
//! let segment = Segment { modes: [0, 2, 2, 0, 0, 0], ..Segment::straight(0.3, 0.01, 1e6, 4e5, 1000.0) };
//! let mut rod = RobotModel::of_rod(&Rod::new(vec![segment]))?;
//! let tip = Target { position: Some([0.2, 0.1, 0.05]), ..Target::new(0) };
//! let found = reach(&mut rod, &[tip], &Options::default(), &mut || Ok(()))?.expect("nothing interrupts it");
//! assert!(found.status.is_success() && found.errors[0].position < 1e-9);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```
//!
//! `target` describes targets, `misfit` computes their errors, `starts` further starts, and `preference`
//! selects among solutions.

pub(crate) mod misfit;
mod outcome;
mod preference;
mod starts;
mod target;

pub use misfit::Error;
pub(crate) use outcome::is_off;
pub use outcome::{Reached, Status};
pub use preference::Preference;
pub use target::Target;

use crate::analysis::statics::Monitor;
use crate::error::{Checker, Interrupted, InvalidInput, Number, Unfinished};
use crate::model::{Dynamics as _, Elastic as _, rotation_vectors};
use crate::numerics::roots::least_squares;
use crate::numerics::roots::least_squares::{Bounds, Counters, End, Form, Outcome, SecondOrder, solve};
use crate::robot::{Origin, Robot, RobotModel, origin};
use misfit::Misfit;
use preference::{form_of, shortest_equivalent};
use starts::Starts;

/// A remaining error smaller by this factor justifies a shape farther from the start.
const SMALLER_ERROR: f64 = 1.0 - 1e-6;

/// Options of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Initial coordinates, clipped to the limits; default: zero.
    pub q0: Option<Vec<f64>>,
    /// Lower and upper limits of the coordinates, infinite if there is no limit, equal for fixed coordinates.
    /// Limits of joints always apply too.
    pub bounds: Option<[Vec<f64>; 2]>,
    /// Preference among the shapes that reach the targets.
    pub prefer: Preference,
    /// A target is reached when its position error is at most this fraction of the length of the chain of links that
    /// carries it, and its orientation error at most this number of radians; 1e-9 by default.
    pub tol: f64,
    /// Maximum number of steps from one start; 200 by default.
    pub max_iter: usize,
    /// Maximum number of further starts, distributed over the robot's range of shapes, if the first one does
    /// not reach the targets; 8 by default.
    pub restarts: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { q0: None, bounds: None, prefer: Preference::Any, tol: 1e-9, max_iter: 200, restarts: 8 }
    }
}

/// Maximum number of further starts that can be requested.
pub const MAX_RESTARTS: usize = 100_000;

/// Finds a shape that reaches all targets, or comes nearest to them, at the time set last. Costs about ten
/// Jacobians of each target from a good start; with a preference, or if the targets cannot be reached, some
/// tens for every coordinate. An interruption carries the best shape until then.
///
/// Fails before the search if an argument is invalid.
pub fn reach(
    model: &mut RobotModel,
    targets: &[Target],
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Result<Reached, Unfinished<Reached>>, InvalidInput> {
    model.facts().check_untied("`reach`")?;
    check(model.description(), targets, options)?;
    let bounds = limits(model.description(), options.bounds.as_ref())?;
    let mut q0 = options.q0.clone().unwrap_or_else(|| vec![0.0; model.facts().n]);
    bounds.clip(&mut q0);
    model.check_shape(&q0, "q0")?;
    let mut sizes = vec![1.0; model.facts().n];
    model.sizes(&q0, &mut sizes);
    let form = form_of(&options.prefer, model, &q0, &sizes)?;
    Ok(search(model, targets, options, (&q0, &bounds, form.as_ref()), monitor))
}

fn search(
    model: &mut RobotModel,
    targets: &[Target],
    options: &Options,
    (q0, bounds, form): (&[f64], &Bounds, Option<&Form>),
    monitor: Monitor<'_>,
) -> Result<Reached, Unfinished<Reached>> {
    let robot = model.description().clone();
    let all = robot.rotation_vectors();
    let is_free = |first: &usize| (*first..first + 3).all(|k| bounds.lower[k] == -bounds.upper[k]);
    let free: Vec<usize> =
        all.into_iter().filter(|first| is_free(first) && bounds.upper[*first] == f64::INFINITY).collect();
    let mut misfit = Misfit::new(model, targets, q0, free.clone(), monitor);
    let scaled = |q: &[f64]| -> Vec<f64> { q.iter().zip(&misfit.sizes).map(|(q, size)| q / size).collect() };
    let scaled_bounds = Bounds { lower: scaled(&bounds.lower), upper: scaled(&bounds.upper) };
    let search = least_squares::Options {
        tolerance: options.tol,
        terms: 1.0,
        max_iter: options.max_iter,
        second_order: SecondOrder::WhereSlow,
    };
    let mut counters = Counters::default();
    let mut x = scaled(q0);
    let mut best = descend(&mut misfit, &mut x, &scaled_bounds, &search);
    let mut invalid_shape = misfit.invalid_shape;
    counters += best.counters;
    let mut starts = Starts::new(&robot, q0, bounds);
    let mut tried = 1;
    while !matches!(best.end, End::Root | End::Interrupted) && tried <= options.restarts {
        tried += 1;
        let q = starts.next();
        let mut other: Vec<f64> = q.iter().zip(&misfit.sizes).map(|(q, size)| q / size).collect();
        misfit.invalid_shape = None;
        let found = descend(&mut misfit, &mut other, &scaled_bounds, &search);
        counters += found.counters;
        if found.end == End::Interrupted {
            best.end = End::Interrupted;
            if misfit.distance(&other) < misfit.distance(&x) {
                x = other;
            }
        } else if found.norm < SMALLER_ERROR * best.norm || found.end == End::Root {
            (best, x, invalid_shape) = (found, other, misfit.invalid_shape);
        }
    }
    let mut status = Status::of(best.end, !best.at_bounds.is_empty(), invalid_shape);
    misfit.invalid_shape = None;
    misfit.count_alike(true);
    if let Some(form) = form.filter(|_| status == Status::Reached) {
        let mut preferred = x.clone();
        shortest_equivalent(form, misfit.rotation_vectors(), &mut preferred);
        match form.refine(&mut misfit, &mut preferred, &scaled_bounds, &search, &mut counters) {
            Ok(true) => x = preferred,
            Ok(false) => status = Status::NotSettled,
            Err(Interrupted) => status = Status::Interrupted,
        }
    }
    let mut q = misfit.coordinates(&x);
    // Scaling must not move a coordinate beyond its limits by rounding.
    bounds.clip(&mut q);
    let mut rates = vec![0.0; q.len()];
    rotation_vectors::wrap(&free, &mut q, &mut rates, &mut []);
    let (errors, poses): (Vec<_>, Vec<_>) = misfit.errors(&q).into_iter().unzip();
    let at_limits = if status == Status::AtLimits { best.at_bounds } else { Vec::new() };
    let of_links = targets.iter().map(|target| target.link).zip(errors.iter().copied());
    let message = outcome::message(status, &robot, of_links, &at_limits, tried, misfit.invalid_shape);
    let reached = Reached { q, status, message, errors, poses, at_limits, starts: tried, counters };
    if status == Status::Interrupted { Err(Unfinished::new(reached)) } else { Ok(reached) }
}

/// The best coordinates near x. Equal weights first, because they converge fastest; if all targets can be reached, weights do not
/// matter.
fn descend(
    misfit: &mut Misfit<'_, '_>,
    x: &mut [f64],
    bounds: &Bounds,
    search: &least_squares::Options,
) -> Outcome {
    misfit.count_alike(true);
    let alike = solve(misfit, x, bounds, search).unwrap_or_else(Unfinished::into_inner);
    if matches!(alike.end, End::Root | End::Interrupted) || misfit.counts_alike() {
        return alike;
    }
    misfit.count_alike(false);
    let least = least_squares::Options { tolerance: search.tolerance * misfit.least_weight(), ..*search };
    let mut found = solve(misfit, x, bounds, &least).unwrap_or_else(Unfinished::into_inner);
    found.counters += alike.counters;
    found
}

/// Reports all invalid arguments at once.
fn check(robot: &Robot, targets: &[Target], options: &Options) -> Result<(), InvalidInput> {
    let n = robot.coordinates();
    let mut check = Checker::new();
    check.require(!targets.is_empty(), "targets", "none", "at least one target");
    for (i, target) in targets.iter().enumerate() {
        target.check(&mut check, &format!("targets[{i}]"), robot);
    }
    if let Some(q0) = &options.q0
        && check.length(q0, n, "q0")
    {
        check.finite(q0, "q0");
    }
    if let Preference::Weights(weights) = &options.prefer
        && check.length(weights, n, "prefer")
    {
        for (k, &weight) in weights.iter().enumerate() {
            check.non_negative(weight, &format!("prefer[{k}]"), "a weight");
        }
        let expected = "a weight > 0 of any coordinate";
        check.require(weights.iter().any(|&weight| weight != 0.0), "prefer", "zeros", expected);
    }
    check.positive(options.tol, "tol", "fraction of the length of the chain to the target, and radians");
    let restarts = options.restarts;
    check.require(
        restarts <= MAX_RESTARTS,
        "restarts",
        restarts,
        &format!("a whole number of at most {MAX_RESTARTS}"),
    );
    check.finish()
}

/// Limits of all coordinates, from joints and from the options.
fn limits(robot: &Robot, given: Option<&[Vec<f64>; 2]>) -> Result<Bounds, InvalidInput> {
    let n = robot.coordinates();
    let mut bounds = Bounds::none(n);
    let mut check = Checker::new();
    for (i, link) in robot.links.iter().enumerate() {
        let Some(limits) = link.joint.forces().and_then(|forces| forces.limits) else { continue };
        // The limits of a dependent joint also limit the joint that it mimics.
        let Some(Origin { link: own, factor, offset }) = origin(&robot.links, i) else { continue };
        if robot.links[own].driven.is_some() || factor == 0.0 {
            continue;
        }
        let [a, b] = limits.map(|limit| (limit - offset) / factor);
        let k = robot.coordinates_of(own).start;
        let [lower, upper] = [bounds.lower[k].max(a.min(b)), bounds.upper[k].min(a.max(b))];
        let found =
            format_args!("{} to {}, which leave the joint that it mimics nothing", limits[0], limits[1]);
        check.require(
            lower <= upper,
            &format!("links[{i}].joint.limits"),
            found,
            "limits that meet the others",
        );
        (bounds.lower[k], bounds.upper[k]) = (lower, upper);
    }
    let Some([lower, upper]) = given else { return check.finish().map(|()| bounds) };
    let is_whole = check.length(lower, n, "bounds[0]") && check.length(upper, n, "bounds[1]");
    if is_whole {
        let names = robot.coordinate_names();
        for k in 0..n {
            let [least, most] = [lower[k].max(bounds.lower[k]), upper[k].min(bounds.upper[k])];
            let is_some = least <= most && least < f64::INFINITY && most > f64::NEG_INFINITY;
            let found = format_args!(
                "{} to {} for {}, whose joint has {} to {}",
                Number(lower[k]),
                Number(upper[k]),
                names[k],
                bounds.lower[k],
                bounds.upper[k]
            );
            let ok = is_some && !lower[k].is_nan() && !upper[k].is_nan();
            check.require(
                ok,
                &format!("bounds[:, {k}]"),
                found,
                "a lower and an upper bound with values between",
            );
            (bounds.lower[k], bounds.upper[k]) = (least, most);
        }
    }
    check.finish()?;
    Ok(bounds)
}
