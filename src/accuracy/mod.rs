//! Motions to an accuracy that is asked for: method, step sizes and an honest estimate of what was reached.
//!
//! The accuracy is that of the tip: the largest distance, over the times that are returned, between the tip and where it would be
//! without error, relative to the length of the model. Two errors count: that of the steps in time, and that of the finite number of
//! modes and nodes in space.
//!
//! The time error is measured, not trusted: every run is compared with one at a tolerance five times tighter, of which the
//! difference tells the error (tolerance proportionality; Hairer, Norsett and Wanner 1993, section II.4), and tightened until it is
//! met. The space error is the difference that two more modes of every strain make, with more nodes; where more nodes alone make one, they
//! are taken.

mod choice;
mod following;
mod modes;
mod space;

use std::time::Instant;

use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::model::Model;
use crate::ode;
use crate::radau;
use crate::simulate::{Method, Simulation, Status, grid, simulate};

use crate::spectrum::Spectrum;
pub use modes::{Modes, choose_modes};

use choice::Choice;
use following::Following;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Largest error of the tip, relative to the length of the model; in [1e-11, 0.1].
    pub tolerance: f64,
    /// Distance of the output times where none are asked for.
    pub dt: f64,
    /// Largest number of accepted steps of each of the runs.
    pub max_steps: usize,
    /// Largest step of all runs, in seconds: for loads of which nobody knows when they act. Infinite unless said otherwise.
    pub max_step: f64,
}

impl Request {
    /// With the limit of steps that holds where nothing is said.
    pub fn new(tolerance: f64, dt: f64) -> Self {
        Self { tolerance, dt, max_steps: DEFAULT_MAX_STEPS, max_step: f64::INFINITY }
    }

    /// Refuses accuracies that cannot be asked for.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut checker = Checker::new();
        let range = SMALLEST_TOLERANCE..=LARGEST_TOLERANCE;
        let expected = "a number in [1e-11, 0.1]: the error of the tip relative to the model's length";
        checker.require(range.contains(&self.tolerance), "rtol", Number(self.tolerance), expected);
        checker.require(self.max_step > 0.0, "max_step", Number(self.max_step), "a number > 0");
        checker.finish()
    }
}

/// What can be asked for: rounding of a run leaves about a hundredth of the first; with the second the estimate would say nothing.
const SMALLEST_TOLERANCE: f64 = 1e-11;
const LARGEST_TOLERANCE: f64 = 0.1;

/// What is asked for where nothing is said.
pub const DEFAULT_TOLERANCE: f64 = 1e-4;

/// Differences that grow by this factor from the first half of the time to the second one multiply: the others grow with the time and its
/// square.
const GROWTH: f64 = 100.0;

/// Tolerance of the tightest run that shows the space error, relative to what is asked for, and part of the space error that is small beside
/// it; difference by more nodes that calls for them, relative to what is asked for.
const SPACE_TOLERANCE: f64 = 0.1;
const NODES_TOLERANCE: f64 = 0.3;

/// Tolerance of the first run that shows the space error: that is large as a rule, and found by a cheap run if it is so many times the
/// tolerance.
const FIRST_SPACE_TOLERANCE: f64 = 1e-3;
const CLEAR: f64 = 10.0;

/// Steps of a run where nothing is said about them: some minutes of work, so that no request works without end.
pub const DEFAULT_MAX_STEPS: usize = 1_000_000;

/// Each run's tolerance over that of the next one, with which it is compared.
const TIGHTENING: f64 = 5.0;

/// The first run's tolerance over the one that is asked for, so that the second one meets it as a rule.
const FIRST_TOLERANCE: f64 = 1.5;

/// Where the estimate was not met: aims at this part of it.
const AIM: f64 = 0.5;

/// Two runs can be compared if the better one should have gained that much, by its steps; if not, it is repeated with so many more of them.
const LEAST_GAIN: f64 = 3.0;
const SHORTER_STEPS: f64 = 1.5;

/// A run that has lost or gained this part of the energy that moved is not trusted, whatever it agrees with.
const LARGE_DRIFT: f64 = 0.1;

/// At so many times runs are compared, at least.
const COMPARED: usize = 100;

/// States of the first run that are looked at for what is to be followed.
const STATES: usize = 4;

/// The error of the better one of two runs is taken for so many times their difference, over the root of what the better one should have
/// gained: not less than the median by proportionality, and not less than the truth in 99 of 100 random motions
/// (`benches/python/auto_honesty.py`).
const SAFETY: f64 = 2.5;

/// No run is better than this part of its tolerance, whatever it agrees with: more is luck.
const LUCK: f64 = 1e-3;

/// Runs until an accuracy counts as out of reach, in motions that multiply every error.
const RUNS: usize = 6;

/// Tightest tolerance of a run; below, rounding rules.
const SMALLEST_RUN_TOLERANCE: f64 = 1e-13;

/// The free motion of `model` from `q0`, `v0` over `t_span`, to an accuracy; and a model with more quadrature nodes that took its place,
/// where it leaves their number open and the accuracy needs them. `t_eval` are increasing times at which the
/// motion is wanted. `monitor` sees the time after every accepted step of every run and may stop it.
///
/// The statistics of the result have the estimated errors, and the counters of the run that is returned; the wall time is that of all
/// of them. Where the accuracy could not be reached, the status says so.
pub fn simulate_to_accuracy<M: Model + Clone>(
    mut model: M,
    t_span: (f64, f64),
    q0: &[f64],
    v0: &[f64],
    request: Request,
    t_eval: Option<&[f64]>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<(Simulation, Option<M>), InvalidInput> {
    let clock = Instant::now();
    request.validate()?;
    crate::newmark::check_start(model.n(), t_span, q0, v0, request.dt)?;
    let wanted = match t_eval {
        Some(times) => times.to_vec(),
        None => grid(model.n(), t_span, request.dt)?,
    };
    let compared = with_more_times(&wanted, t_span);
    let t_eval = Some(&compared[..]);
    let original = model.clone();
    let mut factor = 1;
    let mut found = loop {
        let mut plan = Plan::new(&mut model, t_span, [q0, v0], request, t_eval)?;
        let mut found = plan.to_accuracy(monitor)?;
        let more_nodes = original.with_nodes_times(2 * factor);
        if found.status.is_success() {
            plan.add_space_error(&mut found, monitor)?;
        }
        let Some(more_nodes) = more_nodes else { break found };
        if !plan.needs_nodes(&found, &more_nodes, monitor)? {
            break found;
        }
        factor *= 2;
        model = more_nodes;
    };
    if factor > 1 {
        found.simulation.message.push_str(&format!(" It takes {factor} times as many nodes as by default."));
    }
    found.simulation.message.push(' ');
    found.simulation.message.push_str(&found.reason);
    found.simulation.statistics.wall_time = clock.elapsed().as_secs_f64();
    found.simulation.status = found.status;
    if compared.len() > wanted.len() {
        found.simulation.keep(&wanted);
    }
    Ok((found.simulation, (factor > 1).then_some(model)))
}

/// What all runs of a model have in common.
struct Plan<'a, M> {
    model: &'a M,
    choice: Choice,
    following: Following,
    t_span: (f64, f64),
    start: [&'a [f64]; 2],
    request: Request,
    t_eval: Option<&'a [f64]>,
}

/// A run to compare with.
struct Looser {
    tolerance: f64,
    steps: f64,
    tips: Vec<[f64; 3]>,
}

/// The best run so far.
struct Found {
    simulation: Simulation,
    status: Status,
    /// Its tolerance.
    tolerance: f64,
    /// Where the tip is at its times.
    tips: Vec<[f64; 3]>,
    /// How far it is from the run of a finer model, relative to the length; zero where that is not known.
    apart: f64,
    /// Why it has the method that it has.
    reason: String,
}

impl<'a, M: Model + Clone> Plan<'a, M> {
    fn new(
        model: &'a mut M,
        t_span: (f64, f64),
        [q0, v0]: [&'a [f64]; 2],
        request: Request,
        t_eval: Option<&'a [f64]>,
    ) -> Result<Self, InvalidInput> {
        model.check_shape(q0, "q0")?;
        let unknown = || (Choice::implicit(), Following::nothing());
        let (choice, following) = match Spectrum::new(model, t_span.0, q0, v0) {
            Some(spectrum) => {
                match Following::new(model, t_span, q0, &spectrum, FIRST_TOLERANCE * request.tolerance) {
                    Ok(following) => (Choice::new(&spectrum, &following, request.tolerance), following),
                    // A function of time fails: the method meets it again.
                    Err(Interrupted) => unknown(),
                }
            }
            // There are no accelerations: the method says so.
            None => unknown(),
        };
        Ok(Self { model, choice, following, t_span, start: [q0, v0], request, t_eval })
    }

    fn duration(&self) -> f64 {
        self.t_span.1 - self.t_span.0
    }

    /// Runs of ever tighter tolerances, until the estimated time error of one is below the tolerance.
    fn to_accuracy(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Found, InvalidInput> {
        let tolerance = self.request.tolerance;
        let mut of_run = FIRST_TOLERANCE * tolerance;
        let mut previous: Option<Looser> = None;
        let mut runs = 0;
        let mut longest_step = f64::INFINITY;
        loop {
            let mut simulation = self.run_with(of_run, longest_step, monitor)?;
            runs += 1;
            let mut status = simulation.status;
            let looked = tips(&mut self.model.clone(), &simulation, monitor);
            let reason = self.choice.reason.clone();
            if looked.is_err() {
                (simulation.message, status) = interrupted();
            }
            let tips = looked.unwrap_or_default();
            if !status.is_success() {
                return Ok(Found { simulation, status, tolerance: of_run, tips, apart: 0.0, reason });
            }
            let steps = simulation.statistics.counters.steps as f64;
            let Some(looser) = previous.take() else {
                let is_first = runs == 1;
                if is_first {
                    self.look(&simulation);
                }
                let followed = self.following.longest_step(self.choice.is_explicit, of_run);
                if is_first && followed * steps < self.duration() {
                    // It has set off what it could not follow: no run to compare with.
                    continue;
                }
                previous = Some(Looser { tolerance: of_run, steps, tips });
                of_run = (of_run / TIGHTENING).max(SMALLEST_RUN_TOLERANCE);
                continue;
            };
            let gain = self.choice.gain(&looser, of_run, steps);
            if gain < LEAST_GAIN && runs < RUNS {
                // Steps that something else than the tolerance limits say nothing about the errors that they share.
                longest_step = self.duration() / (SHORTER_STEPS * looser.steps);
                previous = Some(looser);
                continue;
            }
            let distances = distances(&tips, &looser.tips);
            // Where errors multiply, or the steps were hardly shorter, what is left of them need not be less.
            let is_better = gain >= LEAST_GAIN && !grows(&distances);
            let share = if is_better { SAFETY / gain.sqrt() } else { SAFETY };
            let apart = share * largest(&distances) / self.model.length();
            let lost = self.following.lost(self.choice.is_explicit, self.duration() / steps.max(1.0));
            let error = (apart + lost + LUCK * of_run).max(self.drained(&simulation, &tips));
            simulation.statistics.time_error = Some(error);
            let is_met = error <= tolerance;
            if is_met || runs == RUNS || of_run <= SMALLEST_RUN_TOLERANCE || !error.is_finite() {
                simulation.message = if is_met {
                    format!("The time error is {error:.0e} of the length, {tolerance:.0e} was asked for.")
                } else {
                    status = Status::AccuracyNotReached;
                    format!(
                        "The accuracy of {tolerance:.0e} was not reached: after {runs} runs the time error is {error:.0e} \
                         of the length. The motion multiplies errors, as chaotic ones do: shorten the time, or compare \
                         energies (`balance`) instead of states."
                    )
                };
                return Ok(Found { simulation, status, tolerance: of_run, tips, apart: 0.0, reason });
            }
            // The next run is compared with this one, of which the error is smaller than that by this gain.
            let gain = (error / (AIM * tolerance)).powi(2) / gain;
            let factor = gain.powf(-1.0 / self.choice.exponent()).clamp(1e-3, 1.0 / TIGHTENING);
            previous = Some(Looser { tolerance: of_run, steps, tips });
            of_run = (of_run * factor).max(SMALLEST_RUN_TOLERANCE);
        }
    }

    /// Compares with the run of a finer model, if there is one: by the method that suits that one, and no more accurate than it takes
    /// to tell an error of the modes from one of the steps.
    fn add_space_error(
        &self,
        found: &mut Found,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<(), InvalidInput> {
        let wanted = self.request.tolerance;
        let mut finer = match space::finer(self.model, &found.simulation, wanted) {
            Ok(Some(finer)) => finer,
            Ok(None) => return Ok(()),
            Err(why) => {
                found.simulation.message.push_str(&format!(" The space error is unknown: {why}."));
                return Ok(());
            }
        };
        let [q0, v0] = self.start.map(|values| finer.embed(values));
        let estimate = finer.estimate();
        let plan = Plan::new(&mut finer.model, self.t_span, [&q0, &v0], self.request, self.t_eval)?;
        let tightest = found.tolerance.min(SPACE_TOLERANCE * wanted);
        let mut tolerance = FIRST_SPACE_TOLERANCE.max(found.tolerance);
        let (error, apart) = loop {
            let other = plan.run(tolerance, monitor)?;
            if !other.status.is_success() {
                if other.status.name() == "interrupted" {
                    found.status = other.status;
                }
                found
                    .simulation
                    .message
                    .push_str(" The space error is unknown: the run with more modes failed.");
                return Ok(());
            }
            let Ok(fine) = tips(&mut plan.model.clone(), &other, monitor) else {
                (found.simulation.message, found.status) = interrupted();
                return Ok(());
            };
            let apart = largest(&distances(&fine, &found.tips)) / self.model.length();
            let error = estimate.error(apart);
            if error <= wanted || apart > CLEAR * tolerance || tolerance <= tightest {
                break (error, apart);
            }
            tolerance = (tolerance / TIGHTENING).max(tightest);
        };
        found.simulation.statistics.space_error = Some(error);
        found.apart = apart;
        let verdict = if error <= wanted {
            format!(" The space error is {error:.0e}.")
        } else {
            format!(
                " The modes of the model leave a space error of {error:.0e}: give it more, or more segments."
            )
        };
        found.simulation.message.push_str(&verdict);
        Ok(())
    }

    /// Whether a model with more nodes moves differently, in a run that is the same otherwise: asked only where the space error is too
    /// large or unknown.
    fn needs_nodes(
        &self,
        found: &Found,
        more_nodes: &M,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<bool, InvalidInput> {
        if found.status == Status::Unresolved {
            return Ok(true);
        }
        let tolerance = self.request.tolerance;
        let space_error = found.simulation.statistics.space_error;
        let is_met = space_error.is_some_and(|error| error <= tolerance);
        if !found.status.is_success() || is_met {
            return Ok(false);
        }
        let Self { t_span, start, request, t_eval, .. } = *self;
        let (choice, following) = (self.choice.clone(), self.following.clone());
        let plan = Plan { model: more_nodes, choice, following, t_span, start, request, t_eval };
        // What is small beside the error by the modes does not matter either.
        let matters = (NODES_TOLERANCE * tolerance).max(SPACE_TOLERANCE * found.apart);
        let other = plan.run(found.tolerance, monitor)?;
        let Ok(tips) = tips(&mut more_nodes.clone(), &other, monitor) else { return Ok(false) };
        let apart = distances(&tips, &found.tips);
        Ok(other.status.is_success() && largest(&apart) > matters * self.model.length())
    }

    /// The error of the tip that goes with the energy that a run has lost or gained, if that is much: half of that of the motion, as of a
    /// vibration. The balance itself has errors where loads jump; methods that damp what they step over lose most of it.
    fn drained(&self, simulation: &Simulation, tips: &[[f64; 3]]) -> f64 {
        let drift = simulation.balance(&mut self.model.clone()).map_or(0.0, |balance| balance.drift());
        let Some(start) = tips.first().filter(|_| drift > LARGE_DRIFT) else { return 0.0 };
        let range = largest(&distances(tips, &vec![*start; tips.len()])) / self.model.length();
        0.5 * drift.min(1.0) * range
    }

    /// Looks at states of a run for what is to be followed.
    fn look(&mut self, simulation: &Simulation) {
        let mut model = self.model.clone();
        let (n, number) = (simulation.n, simulation.t.len());
        for i in (1..=STATES).map(|k| k * number.saturating_sub(1) / STATES) {
            let state = [&simulation.q, &simulation.v].map(|values| &values[i * n..][..n]);
            self.following.look(&mut model, simulation.t[i], self.duration(), state);
        }
    }

    fn run(
        &self,
        tolerance: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Simulation, InvalidInput> {
        self.run_with(tolerance, f64::INFINITY, monitor)
    }

    fn run_with(
        &self,
        tolerance: f64,
        longest_step: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Simulation, InvalidInput> {
        let mut model = self.model.clone();
        let followed = self.following.longest_step(self.choice.is_explicit, tolerance);
        let request =
            Request { max_step: self.request.max_step.min(followed).min(longest_step), ..self.request };
        let method = self.choice.method(&mut model, tolerance, request);
        let [q0, v0] = self.start;
        simulate(model, self.t_span, q0, v0, &method, self.t_eval, monitor)
    }
}

impl Choice {
    /// The error of a run grows with this power of its tolerance: steps of size h meet one of the order of h^4 with Radau, whose error
    /// is of the order of h^5, and of h^8 with DOP853, of h^8.
    fn exponent(&self) -> f64 {
        if self.is_explicit { 1.0 } else { 1.25 }
    }

    /// The error of a looser run over that of this one: by the tolerances, as far as the steps bear that out.
    fn gain(&self, looser: &Looser, tolerance: f64, steps: f64) -> f64 {
        let order = if self.is_explicit { 8 } else { 5 };
        let expected = (looser.tolerance / tolerance).powf(self.exponent());
        let seen = (steps / looser.steps).powi(order);
        expected.min(seen).max(1.0)
    }

    /// The method at a tolerance for errors of coordinates relative to their typical sizes, and of velocities likewise.
    fn method<M: Model>(&self, model: &mut M, tolerance: f64, request: Request) -> Method {
        let Request { dt, max_steps, max_step, .. } = request;
        let n = model.n();
        let mut sizes = vec![0.0; n];
        model.typical_coordinates(&mut sizes);
        let of_velocities: Vec<f64> = sizes.iter().map(|size| size * self.frequency * tolerance).collect();
        let atol = sizes.into_iter().map(|size| size * tolerance).chain(of_velocities).collect::<Vec<_>>();
        if self.is_explicit {
            let options = ode::Options {
                method: ode::Method::Dop853,
                rtol: 0.0.into(),
                atol: atol.into(),
                max_steps,
                max_step,
                ..ode::Options::default()
            };
            Method::FirstOrder { options, dt }
        } else {
            let options = radau::Options {
                rtol: (1e-2 * tolerance).into(),
                atol: atol.into(),
                max_steps,
                max_step,
                ..radau::Options::default()
            };
            Method::Radau { options, dt }
        }
    }
}

/// These times and, where they are few, more of them: runs that agree at one time by chance do not at all of them. Times that make no
/// sense are left to those who refuse them.
fn with_more_times(times: &[f64], (t0, t_end): (f64, f64)) -> Vec<f64> {
    let mut all = times.to_vec();
    let make_sense = times.iter().all(|t| (t0..=t_end).contains(t)) && times.is_sorted();
    if times.len() < COMPARED && make_sense {
        all.extend((0..=COMPARED).map(|i| t0 + (t_end - t0) * (i as f64 / COMPARED as f64)));
        all.sort_by(f64::total_cmp);
        all.dedup();
    }
    all
}

/// Where the tip is at all times. `monitor` sees the end of the run now and then and may stop it.
fn tips<M: Model>(
    model: &mut M,
    simulation: &Simulation,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Vec<[f64; 3]>, Interrupted> {
    /// Tips cost less than steps do.
    const TIPS_BETWEEN: usize = 16;
    let end = simulation.t.last().copied().unwrap_or(0.0);
    let tip = |(i, q): (usize, &[f64])| {
        if i.is_multiple_of(TIPS_BETWEEN) {
            monitor(end)?;
        }
        Ok(model.tip(q))
    };
    simulation.q.chunks_exact(simulation.n.max(1)).enumerate().map(tip).collect()
}

/// What a run says that was stopped after its end, when its error was looked for.
fn interrupted() -> (String, Status) {
    let status = crate::newmark::Status::Interrupted;
    ("The run was stopped, as asked for, before its error was known.".to_owned(), Status::SecondOrder(status))
}

/// The distances of two paths at each of their times.
fn distances(a: &[[f64; 3]], b: &[[f64; 3]]) -> Vec<f64> {
    let apart =
        |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    a.iter().zip(b).map(apart).collect()
}

fn largest(distances: &[f64]) -> f64 {
    distances.iter().copied().fold(0.0, f64::max)
}

/// Whether the distances are far larger in the second half of the time than in the first one.
fn grows(distances: &[f64]) -> bool {
    let (first, second) = distances.split_at(distances.len() / 2);
    largest(second) > GROWTH * largest(first) && largest(first) > 0.0
}
