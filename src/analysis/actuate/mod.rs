//! Inverse statics: inputs that bring links of a robot to target poses.
//!
//! A least-squares problem for the errors of the targets within limits of the inputs
//! ([`crate::numerics::roots::least_squares`]). Each evaluation solves for the equilibrium by continuation from the
//! previous one ([`crate::analysis::statics::continuation`]). Its sensitivity is exact: `dq/du = -K^-1 dtau/du`. If the
//! targets do not determine all inputs, the smallest ones are chosen.
//!
//! `commands` describes the inputs, `equilibria` computes shapes for inputs, and `misfit` the errors of the
//! targets.
//!
//! ```
//! use lissom::actuate::{Options, actuate};
//! use lissom::actuator::{Actuator, Along, Drive, Part, Tendon};
//! use lissom::reach::Target;
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::{Profile, Segment};
//! use lissom::signal::{Input, Signal};
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(0.2, 2e-3, 1e9, 4e8, 1200.0) };
//! let offset = [Profile::linear([[0.0]; 2]), Profile::linear([[0.01]; 2])];
//! let tension = Signal::Input(Input { name: "pull".into(), value: [1.0] });
//! let tendon = Tendon {
//!     name: "pull".into(),
//!     path: vec![Part::Along(Along { link: 0, offset, along: [0.0, 0.2] })],
//!     drive: Drive::Tension(tension),
//!     friction: 0.0,
//!     friction_velocity: 1e-3,
//!     sliding: None,
//! };
//! let rod = Rod { actuators: vec![Actuator::Tendon(tendon)], ..Rod::new(vec![segment]) };
//! let mut finger = RobotModel::of_rod(&rod)?;
//! let target = Target {
//!     link: 0,
//!     at: None,
//!     point: [0.0; 3],
//!     position: Some([0.0, 0.0, 0.02]),
//!     orientation: None,
//!     weights: [[0.0, 0.0, 1.0], [0.0; 3]],
//! };
//! let found = actuate(&mut finger, &[target], &Options::default(), &mut || Ok(()))?.expect("nothing interrupts it");
//! assert!(found.status.is_success(), "{}", found.message);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod commands;
mod equilibria;
mod misfit;
mod outcome;

pub use outcome::{Found, Status};

use crate::analysis::reach::Target;
use crate::analysis::reach::misfit::Misfit;
use crate::analysis::stability::Verdict;
use crate::analysis::statics;
use crate::analysis::statics::{Equilibrium, Monitor, Start, Tendons, equilibrium};
use crate::error::{Checker, Interrupted, InvalidInput, Number, Unfinished};
use crate::model::{Dynamics as _, InTime as _};
use crate::numerics::linalg::{Matrix, full_svd, norm};
use crate::numerics::roots::NonlinearSystem as _;
use crate::numerics::roots::least_squares;
use crate::numerics::roots::least_squares::{Bounds, Counters, End, Form, Outcome, SecondOrder, solve};
use crate::robot::effects::actuator::{Actuator, Drive, Tendon};
use crate::robot::{Robot, RobotModel};
use commands::{Command, Kind, commands};
use equilibria::{Equilibria, State};
use misfit::Actuated;

/// Relative singular value below which the targets do not determine an input, because of rounding.
const RANK_TOLERANCE: f64 = 1e-8;

/// Accuracy of positions from equilibria, in units of rounding.
const ROUNDING_OF_POSITIONS: f64 = 1e3;

/// Options of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Initial inputs, clipped to their limits, shape (m,); defaults of the robot if `None`.
    pub u: Option<Vec<f64>>,
    /// A shape near the equilibrium at the initial inputs; if `None`, loads grow from zero.
    pub q0: Option<Vec<f64>>,
    /// Entries of u that may change; by default all except directions of sliding.
    pub free: Option<Vec<usize>>,
    /// Additional limits of entries of u. These always hold: tensions and lengths are not negative, torques
    /// stay within the limits of their motor, directions of sliding within [-1, 1].
    pub limits: Vec<(usize, [f64; 2])>,
    /// Time of the model, in seconds.
    pub time: f64,
    /// A target is reached when its position error is at most this fraction of the length of the chain of links that carries it, and its
    /// orientation error at most this number of radians; 1e-9 by default.
    pub tol: f64,
    /// Largest number of steps; 100 by default.
    pub max_iter: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { u: None, q0: None, free: None, limits: Vec::new(), time: 0.0, tol: 1e-9, max_iter: 100 }
    }
}

/// Finds inputs that bring links to their targets, or as near as possible, and the equilibrium at these
/// inputs. A step costs a few tangents of the model, and a few for every input if the targets do not
/// determine the inputs or cannot be reached. An interruption carries the best inputs until then.
///
/// Fails before the search if an argument is invalid.
pub fn actuate(
    model: &mut RobotModel,
    targets: &[Target],
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Result<Found, Unfinished<Found>>, InvalidInput> {
    let problem = Problem::new(model, targets, options)?;
    Ok(search(model, targets, options, problem, monitor))
}

/// Error due to the finite number of modes of the equilibrium that was found at the time `t`; `None` if there is none.
pub fn space_error(
    model: &mut RobotModel,
    found: &Found,
    t: f64,
) -> Result<Option<statics::SpaceError>, Interrupted> {
    if matches!(found.status, Status::NoStart | Status::Interrupted) {
        return Ok(None);
    }
    model.set_inputs(&found.u);
    model.set_time(t)?;
    let stability = found.verdict.map(|verdict| verdict.stability);
    let rest = statics::Rest::of(&found.q, stability);
    statics::error_at_rest(model, rest, (t, Some(&found.u)), statics::Effort::Little)
}

/// The search problem after validation.
struct Problem {
    /// Initial inputs.
    u: Vec<f64>,
    free: Vec<usize>,
    commands: Vec<Command>,
}

impl Problem {
    fn new(model: &mut RobotModel, targets: &[Target], options: &Options) -> Result<Self, InvalidInput> {
        let robot = model.description();
        let mut commands = commands(robot);
        let m = commands.len();
        let names = robot.inputs().names();
        let mut check = Checker::new();
        check.require(m > 0, "robot", "a robot without inputs", "one with a lissom.Input that may be chosen");
        check.require(!targets.is_empty(), "targets", "none", "at least one target");
        for (i, target) in targets.iter().enumerate() {
            target.check(&mut check, &format!("targets[{i}]"), robot);
        }
        let u = options.u.clone().unwrap_or_else(|| robot.inputs().defaults().to_vec());
        if check.length(&u, m, "u") {
            check.finite(&u, "u");
        }
        for &(entry, [lower, upper]) in &options.limits {
            let Some(command) = commands.get_mut(entry) else {
                check.require(
                    false,
                    "limits",
                    entry,
                    &format!("an entry of u, 0 to {}", m.saturating_sub(1)),
                );
                continue;
            };
            let limits = [command.limits[0].max(lower), command.limits[1].min(upper)];
            let found = format_args!("{} to {}", Number(lower), Number(upper)).to_string();
            let [least, most] = command.limits;
            let is_range =
                limits[0] <= limits[1] && limits[0] < f64::INFINITY && limits[1] > f64::NEG_INFINITY;
            let ok = is_range && !lower.is_nan() && !upper.is_nan();
            let expected =
                format!("a lower and an upper limit, with values from {least} to {most} between them");
            if check.require(ok, &format!("limits['{}']", names[entry]), found, &expected) {
                command.limits = limits;
            }
        }
        let free = options
            .free
            .clone()
            .unwrap_or_else(|| (0..m).filter(|&entry| commands[entry].kind != Kind::Sliding).collect());
        check.require(!free.is_empty() || m == 0, "inputs", "none", "at least one input that may change");
        for &entry in &free {
            check.require(entry < m, "inputs", entry, &format!("entries of u, 0 to {}", m.saturating_sub(1)));
        }
        check.positive(options.tol, "tol", "fraction of the length of the chain to the target, and radians");
        if let Some(q0) = &options.q0
            && check.length(q0, model.facts().n, "q0")
        {
            check.finite(q0, "q0");
        }
        check.finish()?;
        if let Some(q0) = &options.q0 {
            model.check_shape(q0, "q0")?;
        }
        let problem = Self { u: Vec::new(), free, commands };
        Ok(Self { u: problem.clipped(u), ..problem })
    }

    /// Inputs within their limits.
    fn clipped(&self, mut u: Vec<f64>) -> Vec<f64> {
        for &entry in &self.free {
            let [lower, upper] = self.commands[entry].limits;
            u[entry] = u[entry].max(lower).min(upper);
        }
        u
    }

    /// Scales of the free inputs: a change by one unit of scale moves the shape by about a typical size, for
    /// the most effective input of its kind.
    fn sizes(&self, sensitivity: &Matrix) -> Vec<f64> {
        let strongest = |kind: Kind| {
            let of_kind = self.free.iter().filter(|&&entry| self.commands[entry].kind == kind);
            of_kind.map(|&entry| norm(sensitivity.column(entry).as_slice())).fold(0.0, f64::max)
        };
        let size = |&entry: &usize| {
            let Command { kind, limits: [lower, upper], .. } = self.commands[entry];
            let [size, range] = [strongest(kind).recip(), upper - lower];
            if size.is_normal() {
                size
            } else if range.is_normal() {
                range
            } else {
                1.0
            }
        };
        self.free.iter().map(size).collect()
    }

    /// Slack tendons whose lengths are free inputs. Derivatives with respect to these lengths vanish.
    fn slack(
        &self,
        model: &mut RobotModel,
        q: &[f64],
        u: &[f64],
        time: f64,
    ) -> Result<Vec<String>, Interrupted> {
        let slack = Tendons::of(model, q, time, Some(u))?.slack;
        let robot = model.description();
        let inputs = robot.inputs();
        let is_free = |actuator: &&Actuator| match actuator {
            Actuator::Tendon(Tendon { drive: Drive::Length { length, .. }, .. }) => {
                length.input().is_some_and(|input| self.free.contains(&inputs.place(input)))
            }
            _ => false,
        };
        let names = robot.actuators.iter().filter(is_free).map(Actuator::name);
        Ok(names.filter(|name| slack.iter().any(|slack| slack == name)).map(str::to_owned).collect())
    }

    /// Evaluates `of` for every free input and divides by its scale.
    fn of_free(&self, sizes: &[f64], of: impl Fn(&Command, usize) -> f64) -> Vec<f64> {
        self.free.iter().zip(sizes).map(|(&entry, size)| of(&self.commands[entry], entry) / size).collect()
    }
}

fn search(
    model: &mut RobotModel,
    targets: &[Target],
    options: &Options,
    problem: Problem,
    monitor: Monitor<'_>,
) -> Result<Found, Unfinished<Found>> {
    let robot = model.description().clone();
    let mut seen = model.clone();
    let set = seen.set_time(options.time).and_then(|()| {
        model.set_inputs(&problem.u);
        model.set_time(options.time)
    });
    let mut never = || Ok(());
    let near = options.q0.clone().unwrap_or_else(|| vec![0.0; model.facts().n]);
    let mut of_targets = Misfit::new(&mut seen, targets, &near, Vec::new(), &mut never);
    if set.is_err() {
        let q = options.q0.clone().unwrap_or_else(|| vec![0.0; of_targets.unknowns()]);
        return Ending::of_start(Status::Interrupted, State { u: problem.u, q }).conclude(
            &mut of_targets,
            &robot,
            targets,
        );
    }
    let beginning = options.q0.clone().map_or(Start::Unloaded { stops: vec![1.0] }, Start::Descent);
    let (start, is_interrupted) = match find(model, beginning, monitor) {
        Ok(start) => (start, false),
        Err(unfinished) => (unfinished.into_inner(), true),
    };
    if !start.status.is_success() {
        let status = if is_interrupted { Status::Interrupted } else { Status::NoStart };
        let end = Ending::of_start(status, State { u: problem.u, q: start.q });
        return Ending { verdict: start.verdict, ..end }.conclude(&mut of_targets, &robot, targets);
    }
    let sizes = of_targets.sizes.clone();
    let mut equilibria = Equilibria::new(model, options.time, problem.u.clone(), start.q, sizes, monitor);
    let Ok(sensitivity) = equilibria.sensitivity() else {
        let state = equilibria.known(&problem.u);
        return Ending::of_start(Status::Interrupted, state).conclude(&mut of_targets, &robot, targets);
    };
    let sensitivity = sensitivity.unwrap_or_else(|| Matrix::zeros(of_targets.unknowns(), problem.u.len()));
    let sizes = problem.sizes(&sensitivity);
    let bounds = Bounds {
        lower: problem.of_free(&sizes, |command, _| command.limits[0]),
        upper: problem.of_free(&sizes, |command, _| command.limits[1]),
    };
    let mut x = problem.of_free(&sizes, |_, entry| problem.u[entry]);
    let wanted = problem.of_free(&sizes, |command, _| command.least);
    let mut system = Actuated::new(equilibria, of_targets, problem.u.clone(), problem.free.clone(), sizes);
    let (found, mut counters) = descend(&mut system, &mut x, &bounds, options);
    let no_equilibrium = system.equilibria.no_equilibrium;
    let mut status = Status::of(found.end, !found.at_bounds.is_empty(), no_equilibrium);
    system.targets.count_alike(true);
    if status == Status::Reached {
        status = match refine_inputs(&mut system, &mut x, wanted, &bounds, options, &mut counters) {
            Ok(true) => Status::Reached,
            Ok(false) => Status::NotSettled,
            Err(Interrupted) => Status::Interrupted,
        };
    }
    // Scaling must not move an input beyond its limits by rounding.
    let u = problem.clipped(system.inputs(&x));
    let Actuated { mut equilibria, targets: mut of_targets, .. } = system;
    let judged = match status {
        Status::Interrupted => Err(Interrupted),
        _ => judged(&mut equilibria, &problem, &u, options.time),
    };
    let (State { u, q }, verdict, slack) = judged.unwrap_or_else(|Interrupted| {
        status = Status::Interrupted;
        let State { u, q } = equilibria.known(&u);
        (State { u: problem.clipped(u), q }, None, Vec::new())
    });
    let at_limits = match status {
        Status::AtLimits => found.at_bounds.iter().map(|&k| problem.free[k]).collect(),
        _ => Vec::new(),
    };
    let equilibria = equilibria.number;
    let end = Ending { u, q, status, at_limits, no_equilibrium, slack, verdict, counters, equilibria };
    end.conclude(&mut of_targets, &robot, targets)
}

/// The equilibrium at the inputs that were found, with its stability, and slack tendons with free lengths.
fn judged(
    equilibria: &mut Equilibria<'_, '_>,
    problem: &Problem,
    u: &[f64],
    time: f64,
) -> Result<(State, Option<Verdict>, Vec<String>), Interrupted> {
    let near = equilibria.at(u)?.map(<[f64]>::to_vec);
    let (model, monitor, q) = equilibria.parts(near);
    model.set_inputs(u);
    model.set_time(time)?;
    let found = find(model, Start::Newton(q), monitor).map_err(Unfinished::interrupted)?;
    let slack = problem.slack(model, &found.q, u, time)?;
    Ok((State { u: u.to_vec(), q: found.q }, found.verdict, slack))
}

/// Result of a search, before its message is written.
struct Ending {
    u: Vec<f64>,
    q: Vec<f64>,
    status: Status,
    at_limits: Vec<usize>,
    no_equilibrium: Option<equilibria::NoEquilibrium>,
    slack: Vec<String>,
    verdict: Option<Verdict>,
    counters: Counters,
    equilibria: usize,
}

impl Ending {
    fn conclude(
        self,
        misfit: &mut Misfit<'_, '_>,
        robot: &Robot,
        targets: &[Target],
    ) -> Result<Found, Unfinished<Found>> {
        let Self { u, q, status, at_limits, no_equilibrium, slack, verdict, counters, equilibria } = self;
        let (errors, poses): (Vec<_>, Vec<_>) = misfit.errors(&q).into_iter().unzip();
        let of_links = targets.iter().map(|target| target.link).zip(errors.iter().copied());
        let message = outcome::message(status, robot, of_links, &at_limits, no_equilibrium, &slack, verdict);
        let found = Found { u, q, status, message, errors, poses, at_limits, verdict, counters, equilibria };
        if status == Status::Interrupted { Err(Unfinished::new(found)) } else { Ok(found) }
    }

    /// At the start, without a step.
    fn of_start(status: Status, State { u, q }: State) -> Self {
        Self {
            u,
            q,
            status,
            at_limits: Vec::new(),
            no_equilibrium: None,
            slack: Vec::new(),
            verdict: None,
            counters: Counters::default(),
            equilibria: 1,
        }
    }
}

fn find(
    model: &mut RobotModel,
    start: Start,
    monitor: Monitor<'_>,
) -> Result<Equilibrium, Unfinished<Equilibrium>> {
    let options = statics::Options { start, ..statics::Options::default() };
    equilibrium(model, &options, monitor).expect("options and shape were validated")
}

fn search_of(options: &Options, tolerance: f64) -> least_squares::Options {
    let (max_iter, second_order) = (options.max_iter, SecondOrder::WhereSlow);
    least_squares::Options { tolerance, terms: ROUNDING_OF_POSITIONS, max_iter, second_order }
}

/// Finds the best inputs near x. Equal weights come first, because they converge fastest; if all targets can
/// be reached, weights do not matter.
fn descend(
    system: &mut Actuated<'_, '_>,
    x: &mut [f64],
    bounds: &Bounds,
    options: &Options,
) -> (Outcome, Counters) {
    let solved = |system: &mut Actuated<'_, '_>, x: &mut [f64], tolerance| {
        solve(system, x, bounds, &search_of(options, tolerance)).unwrap_or_else(Unfinished::into_inner)
    };
    let alike = solved(system, x, options.tol);
    let mut counters = alike.counters;
    if matches!(alike.end, End::Root | End::Interrupted) || system.targets.counts_alike() {
        return (alike, counters);
    }
    system.targets.count_alike(false);
    let tolerance = options.tol * system.targets.least_weight();
    let found = solved(system, x, tolerance);
    counters += found.counters;
    (found, counters)
}

/// Continues to the inputs nearest to the preferred ones, among those that give the same poses. False if these are not found.
fn refine_inputs(
    system: &mut Actuated<'_, '_>,
    x: &mut [f64],
    wanted: Vec<f64>,
    bounds: &Bounds,
    options: &Options,
    counters: &mut Counters,
) -> Result<bool, Interrupted> {
    let form = Form { root: Matrix::identity(x.len(), x.len()), wanted };
    Ok(!leaves_a_choice(system, x)?
        || form.refine(system, x, bounds, &search_of(options, options.tol), counters)?)
}

/// Whether other inputs nearby give the same poses.
fn leaves_a_choice(system: &mut Actuated<'_, '_>, x: &[f64]) -> Result<bool, Interrupted> {
    let mut jacobian = Matrix::zeros(system.equations(), x.len());
    system.jacobian(x, &mut jacobian)?;
    if !jacobian.iter().all(|entry| entry.is_finite()) {
        return Ok(false);
    }
    let Some((_, values, _)) = full_svd(&jacobian) else { return Ok(false) };
    let largest = values.iter().copied().fold(0.0, f64::max);
    Ok(values.iter().filter(|&&value| value > RANK_TOLERANCE * largest).count() < x.len())
}

#[cfg(test)]
mod tests;
