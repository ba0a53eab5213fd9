//! Choice of the number of modes of each strain for a motion.

use super::missing::SAFETY;
use super::paths::{distances, largest};
use super::request::Request;
use super::run::{Plan, Run};
use crate::description::rod::{MAX_MODES, STRAINS};
use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::model::{Dynamics as _, InTime as _};
use crate::numerics::linalg::Matrix;
use crate::robot::{Robot, RobotModel};
use crate::simulation::simulate::{Simulation, Status};

/// Initial modes: two for bending, none for other strains.
const FIRST_MODES: [usize; STRAINS] = [0, 2, 2, 0, 0, 0];

/// Additional modes in a trial, for a strain with modes and for a strain without.
const MORE_MODES: usize = 2;
const ANY_MODES: usize = 1;

/// A mode is kept if it moves the tip by this fraction of the tolerance; the fraction decreases after each
/// failed verification.
const KEPT: f64 = 0.1;
const SMALLER: f64 = 0.25;

/// Time tolerance of the trials, relative to the requested accuracy.
const TRIAL_TOLERANCE: f64 = 0.3;

/// Maximum number of trials.
const TRIALS: usize = 24;

/// Number of states of a trial that are examined.
const STATES: usize = 32;

/// Result of a choice of modes.
#[derive(Clone, Debug)]
pub struct Modes {
    /// The robot with the chosen modes; after an interruption with those that the trials until then needed.
    pub robot: Robot,
    /// Change of the tip by the additional modes of the last trial, relative to the length; `None` without
    /// such a trial.
    pub space_error: Option<f64>,
    /// `Finished`, or the status of the trial that failed, or [`Status::AccuracyNotReached`].
    pub status: Status,
    /// Status in words.
    pub message: String,
}

/// Chooses the numbers of modes of the segments `open` of a robot, counted link by link, such that its motion
/// from rest over `t_span` has the requested accuracy with respect to modes. Each trial has additional modes
/// of every strain and keeps those that move the tip. `monitor` is called with the time after every step of
/// every trial and may stop the search.
///
/// Strains that a symmetric motion does not excite get no modes. Costs about five to fifteen motions.
pub fn choose_modes(
    robot: &Robot,
    open: &[usize],
    t_span: (f64, f64),
    request: Request,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Modes, InvalidInput> {
    request.validate()?;
    let mut check = Checker::new();
    let (t0, t_end) = t_span;
    if check.require(t0.is_finite(), "t_span[0]", t0, "a finite number (seconds)") {
        let expected = format!("a finite number > {} (seconds)", Number(t0));
        check.require(t_end.is_finite() && t_end > t0, "t_span[1]", Number(t_end), &expected);
    }
    let segments: Vec<_> = robot.segments().collect();
    for &segment in open {
        let expected = format!("a segment, 0 to {}", segments.len().saturating_sub(1));
        let is_there = check.require(segment < segments.len(), "segments", segment, &expected);
        let is_nested = is_there && segments[segment].basis.is_nested();
        let (place, expected) =
            (format!("segments[{segment}].basis"), "polynomials over the segment, such as \"legendre\"");
        check.require(!is_there || is_nested, &place, "piecewise functions", expected);
    }
    check.finish()?;
    let mut trials = Trials { open, t_span, request, monitor };
    let mut modes = vec![FIRST_MODES; open.len()];
    let mut kept = KEPT;
    let mut space_error = None;
    let ended = |failed: Failed, modes: &[[usize; STRAINS]], space_error| match failed.0.status {
        status if status.is_interrupted() => {
            let message =
                "The trials were interrupted: these are the modes that they needed by then.".to_owned();
            Modes { robot: with_modes(robot, open, modes), space_error, status, message }
        }
        _ => failed.choice(robot.clone(), space_error),
    };
    for _ in 0..TRIALS {
        let more: Vec<[usize; STRAINS]> = modes.iter().map(|modes| modes.map(more)).collect();
        let fine = match trials.run(robot, &more)? {
            Ok(trial) => trial,
            Err(failed) => return Ok(ended(failed, &modes, space_error)),
        };
        let needed = trials.needed(&fine, &more, kept * request.rtol);
        let is_enough =
            needed.iter().flatten().zip(modes.iter().flatten()).all(|(needed, modes)| needed <= modes);
        if !is_enough {
            // Modes needed once are kept: a smaller number may only mean that the trial was too coarse.
            for (modes, needed) in modes.iter_mut().flatten().zip(needed.iter().flatten()) {
                *modes = (*modes).max(*needed);
            }
            continue;
        }
        let coarse = match trials.run(robot, &needed)? {
            Ok(trial) => trial,
            Err(failed) => return Ok(ended(failed, &modes, space_error)),
        };
        let error = SAFETY * largest(&distances(&fine.tips, &coarse.tips)) / robot.length();
        space_error = Some(error);
        if error <= request.rtol {
            let message = format!("The modes leave a space error of {error:.0e} of the length.");
            if coarse.model.facts().n == 0 {
                return Ok(unmoved(robot, open, error, fine.simulation.status));
            }
            return Ok(Modes { robot: coarse.robot, space_error, status: fine.simulation.status, message });
        }
        kept *= SMALLER;
        modes = more;
    }
    let message = format!(
        "No number of modes was found that reaches {:.0e}: cut the rod into more segments, or ask for less.",
        request.rtol
    );
    Ok(Modes {
        robot: with_modes(robot, open, &modes),
        space_error,
        status: Status::AccuracyNotReached,
        message,
    })
}

/// Result if nothing moves by the requested accuracy.
fn unmoved(robot: &Robot, open: &[usize], error: f64, status: Status) -> Modes {
    let one_bend = [0, 1, 0, 0, 0, 0];
    let message = "Nothing moves the tip by as much as the accuracy: one mode of bending is there because a rod needs one. If a load \
                   was meant to, look at its times and at its size.";
    let robot = with_modes(robot, open, &vec![one_bend; open.len()]);
    Modes { robot, space_error: Some(error), status, message: message.to_owned() }
}

/// Number of modes of a strain in a trial.
fn more(modes: usize) -> usize {
    if modes == 0 { ANY_MODES } else { (modes + MORE_MODES).min(MAX_MODES) }
}

fn with_modes(robot: &Robot, open: &[usize], modes: &[[usize; STRAINS]]) -> Robot {
    let mut robot = robot.clone();
    let mut segments: Vec<_> = robot.segments_mut().collect();
    for (&segment, &modes) in open.iter().zip(modes) {
        segments[segment].modes = modes;
    }
    robot
}

/// Data shared by all trials.
struct Trials<'a> {
    open: &'a [usize],
    t_span: (f64, f64),
    request: Request,
    monitor: &'a mut dyn FnMut(f64) -> Result<(), Interrupted>,
}

/// A motion with a given number of modes.
struct Trial {
    robot: Robot,
    model: RobotModel,
    simulation: Simulation,
    tips: Vec<[f64; 3]>,
}

/// A motion that did not reach its end.
struct Failed(Simulation);

impl Failed {
    fn choice(self, robot: Robot, space_error: Option<f64>) -> Modes {
        let Simulation { status, message, .. } = self.0;
        let message = format!("No modes were chosen, because a trial failed. {message}");
        Modes { robot, space_error, status, message }
    }
}

impl Trials<'_> {
    fn run(
        &mut self,
        robot: &Robot,
        modes: &[[usize; STRAINS]],
    ) -> Result<Result<Trial, Failed>, InvalidInput> {
        let robot = with_modes(robot, self.open, modes);
        let mut model = RobotModel::new(&robot)?;
        let rest = vec![0.0; model.facts().n];
        let tolerance = TRIAL_TOLERANCE * self.request.rtol;
        let request = Request { rtol: tolerance, ..self.request };
        let plan = Plan::new(&mut model, self.t_span, [&rest, &rest], request, None, self.monitor)?;
        let run = plan.run(tolerance, f64::INFINITY, self.monitor)?;
        if !run.is_success() {
            return Ok(Err(Failed(run.simulation)));
        }
        let Run { simulation, tips, .. } = run;
        Ok(Ok(Trial { robot, model, simulation, tips }))
    }

    /// Smallest numbers of modes such that no further mode moves the tip by more than `tolerance` times the
    /// length, to first order.
    fn needed(&self, trial: &Trial, modes: &[[usize; STRAINS]], tolerance: f64) -> Vec<[usize; STRAINS]> {
        let moved = trial.moved();
        let mut needed = vec![[0; STRAINS]; modes.len()];
        for ((needed, modes), &segment) in needed.iter_mut().zip(modes).zip(self.open) {
            let mut first = trial.robot.first_coordinate(segment);
            for (needed, &modes) in needed.iter_mut().zip(modes) {
                let own = &moved[first..first + modes];
                *needed = own
                    .iter()
                    .rposition(|&moved| moved > tolerance * trial.robot.length())
                    .map_or(0, |k| k + 1);
                first += modes;
            }
        }
        needed
    }
}

impl Trial {
    /// Largest displacement of the tip by each coordinate, to first order, in metres.
    fn moved(&self) -> Vec<f64> {
        let mut model = self.model.clone();
        let n = model.facts().n;
        let tips = model.tips_of_rods();
        let mut jacobian = Matrix::zeros(6, n);
        let mut moved = vec![0.0_f64; n];
        let states = self.simulation.q.chunks_exact(n.max(1));
        let every = states.len().div_ceil(STATES).max(1);
        for (q, &t) in states.zip(&self.simulation.t).rev().step_by(every) {
            // The run has already evaluated this time; a failure here has occurred there too.
            if model.set_time(t).is_err() {
                continue;
            }
            for tip in &tips {
                model.jacobian_at(q, tip, &mut jacobian);
                for (k, moved) in moved.iter_mut().enumerate() {
                    let velocity = (3..6).map(|i| jacobian[(i, k)].powi(2)).sum::<f64>().sqrt();
                    *moved = moved.max(velocity * q[k].abs());
                }
            }
        }
        moved
    }
}
