//! Motions to an accuracy that is asked for: method, step sizes and an honest estimate of what was reached.
//!
//! The accuracy is that of the tip: the largest distance, over the times that are returned, between the tip and where it would be
//! without error, relative to the length of the model. Two errors count: that of the steps in time, and that of the finite number of
//! modes and nodes in space.
//!
//! The time error is measured, not trusted: every run is compared with one at a tolerance ten times tighter, of which the
//! difference tells the error (tolerance proportionality; Hairer, Norsett and Wanner 1993, section II.4), and tightened until it is
//! met. The space error is the difference that two more modes of every strain make, with more nodes.

mod choice;
mod spectrum;

use std::time::Instant;

use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::model::Model;
use crate::ode;
use crate::radau;
use crate::simulate::{Method, Simulation, Status, simulate};

use choice::Choice;
use spectrum::Spectrum;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Largest error of the tip, relative to the length of the model; in [1e-11, 0.1].
    pub tolerance: f64,
    /// Distance of the output times where none are asked for.
    pub dt: f64,
}

impl Request {
    /// Refuses accuracies that cannot be asked for.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut checker = Checker::new();
        let range = SMALLEST_TOLERANCE..=LARGEST_TOLERANCE;
        let expected = "a number in [1e-11, 0.1]: the error of the tip relative to the model's length";
        checker.require(range.contains(&self.tolerance), "rtol", Number(self.tolerance), expected);
        checker.finish()
    }
}

/// What can be asked for: rounding of a run leaves about a hundredth of the first; with the second the estimate would say nothing.
const SMALLEST_TOLERANCE: f64 = 1e-11;
const LARGEST_TOLERANCE: f64 = 0.1;

/// What is asked for where nothing is said.
pub const DEFAULT_TOLERANCE: f64 = 1e-4;

/// Each run's tolerance over that of the next one, with which it is compared.
const TIGHTENING: f64 = 10.0;

/// The first run's tolerance over the one that is asked for, so that the second one meets it as a rule.
const FIRST_TOLERANCE: f64 = 5.0;

/// Where the estimate was not met: aims at this part of it.
const AIM: f64 = 0.3;

/// Runs until an accuracy counts as out of reach, in motions that multiply every error.
const RUNS: usize = 6;

/// Tightest tolerance of a run; below, rounding rules.
const SMALLEST_RUN_TOLERANCE: f64 = 1e-13;

/// The free motion of `model` from `q0`, `v0` over `[0, t_end]`, to an accuracy. `t_eval` are increasing times at which it is wanted.
/// `monitor` sees the time after every accepted step of every run and may stop it.
///
/// The statistics of the result have the estimated errors, and the counters of the run that is returned; the wall time is that of all
/// of them. Where the accuracy could not be reached, the status says so.
pub fn simulate_to_accuracy<M: Model + Clone>(
    mut model: M,
    t_end: f64,
    q0: &[f64],
    v0: &[f64],
    request: Request,
    t_eval: Option<&[f64]>,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Simulation, InvalidInput> {
    let clock = Instant::now();
    request.validate()?;
    crate::newmark::check_start(model.n(), (0.0, t_end), q0, v0, request.dt)?;
    let choice = match Spectrum::new(&mut model, q0, v0) {
        Some(spectrum) => Choice::new(&mut model, q0, &spectrum, request.tolerance),
        // There are no accelerations: the method says so.
        None => Choice::implicit(),
    };
    let plan = Plan { model: &model, choice: &choice, t_end, dt: request.dt, t_eval };
    let mut found = plan.to_accuracy(q0, v0, request.tolerance, monitor)?;
    if found.status.is_success() {
        plan.add_space_error(&mut found, q0, v0, request.tolerance, monitor)?;
    }
    found.simulation.message = format!("{} {}", found.simulation.message, choice.reason);
    found.simulation.statistics.wall_time = clock.elapsed().as_secs_f64();
    found.simulation.status = found.status;
    Ok(found.simulation)
}

/// What all runs have in common.
struct Plan<'a, M> {
    model: &'a M,
    choice: &'a Choice,
    t_end: f64,
    dt: f64,
    t_eval: Option<&'a [f64]>,
}

/// The best run so far.
struct Found {
    simulation: Simulation,
    status: Status,
    /// Its tolerance.
    tolerance: f64,
}

impl<M: Model + Clone> Plan<'_, M> {
    /// Runs of ever tighter tolerances, until the estimated time error of one is below the tolerance.
    fn to_accuracy(
        &self,
        q0: &[f64],
        v0: &[f64],
        tolerance: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Found, InvalidInput> {
        let mut of_run = FIRST_TOLERANCE * tolerance;
        let mut previous: Option<(f64, Vec<[f64; 3]>)> = None;
        let mut runs = 0;
        loop {
            let mut simulation = self.run(self.model.clone(), q0, v0, of_run, monitor)?;
            runs += 1;
            let mut status = simulation.status;
            if !status.is_success() {
                return Ok(Found { simulation, status, tolerance: of_run });
            }
            let tips = tips(&mut self.model.clone(), &simulation);
            let estimate = previous.take().map(|(looser, others)| {
                let ratio = (looser / of_run).powf(self.choice.exponent());
                distance(&tips, &others) / (ratio - 1.0) / self.model.length()
            });
            let Some(error) = estimate else {
                previous = Some((of_run, tips));
                of_run = (of_run / TIGHTENING).max(SMALLEST_RUN_TOLERANCE);
                continue;
            };
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
                return Ok(Found { simulation, status, tolerance: of_run });
            }
            let factor = (AIM * tolerance / error).clamp(1e-3, 1.0 / TIGHTENING);
            previous = Some((of_run, tips));
            of_run = (of_run * factor).max(SMALLEST_RUN_TOLERANCE);
        }
    }

    /// Compares with the run of a finer model, if there is one.
    fn add_space_error(
        &self,
        found: &mut Found,
        q0: &[f64],
        v0: &[f64],
        tolerance: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<(), InvalidInput> {
        let Some((finer, places)) = self.model.refined() else { return Ok(()) };
        let embed = |values: &[f64]| {
            let mut all = vec![0.0; finer.n()];
            for (&place, &value) in places.iter().zip(values) {
                all[place] = value;
            }
            all
        };
        let (q0, v0) = (embed(q0), embed(v0));
        let other = self.run(finer.clone(), &q0, &v0, found.tolerance, monitor)?;
        if !other.status.is_success() {
            if other.status.name() == "interrupted" {
                found.status = other.status;
            }
            found.simulation.message.push_str(" The space error is unknown: the run with more modes failed.");
            return Ok(());
        }
        let (fine, coarse) =
            (tips(&mut finer.clone(), &other), tips(&mut self.model.clone(), &found.simulation));
        let error = distance(&fine, &coarse) / self.model.length();
        found.simulation.statistics.space_error = Some(error);
        let verdict = if error <= tolerance {
            format!(" The space error is {error:.0e}.")
        } else {
            format!(
                " The modes of the model leave a space error of {error:.0e}: give it more, or more segments."
            )
        };
        found.simulation.message.push_str(&verdict);
        Ok(())
    }

    fn run(
        &self,
        mut model: M,
        q0: &[f64],
        v0: &[f64],
        tolerance: f64,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Simulation, InvalidInput> {
        let method = self.choice.method(&mut model, tolerance, self.dt);
        simulate(model, self.t_end, q0, v0, &method, self.t_eval, monitor)
    }
}

impl Choice {
    /// The error of a run grows with this power of its tolerance: steps of size h meet one of the order of h^4 with Radau, whose error
    /// is of the order of h^5, and of h^8 with DOP853, of h^8.
    fn exponent(&self) -> f64 {
        if self.is_explicit { 1.0 } else { 1.25 }
    }

    /// The method at a tolerance for errors of coordinates relative to their typical sizes, and of velocities likewise.
    fn method<M: Model>(&self, model: &mut M, tolerance: f64, dt: f64) -> Method {
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
                ..ode::Options::default()
            };
            Method::FirstOrder { options, dt }
        } else {
            let options = radau::Options {
                rtol: (1e-2 * tolerance).into(),
                atol: atol.into(),
                ..radau::Options::default()
            };
            Method::Radau { options, dt }
        }
    }
}

/// Where the tip is at all times.
fn tips<M: Model>(model: &mut M, simulation: &Simulation) -> Vec<[f64; 3]> {
    simulation.q.chunks_exact(simulation.n.max(1)).map(|q| model.tip(q)).collect()
}

/// The largest distance of two paths.
fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let apart =
        |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    a.iter().zip(b).map(apart).fold(0.0, f64::max)
}
