//! Choice of the number of modes of each strain for a motion or an equilibrium.

use super::inputs::Given;
use super::missing::SAFETY;
use super::paths::{distances, largest};
use super::request::Request;
use super::run::{Plan, Run};
use crate::analysis::statics::{self, Effort, SpaceError, Start};
use crate::description::rod::{MAX_MODES, STRAIN_NAMES, STRAINS, reference_turns};
use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::model::{Dynamics as _, InTime as _};
use crate::numerics::linalg::Matrix;
use crate::robot::{Place, Robot, RobotModel};

/// Initial modes: two for bending, none for other strains.
const FIRST_MODES: [usize; STRAINS] = [0, 2, 2, 0, 0, 0];

/// Additional modes in a trial, for a strain with modes and for a strain without.
const MORE_MODES: usize = 2;
const ANY_MODES: usize = 1;

/// A mode is kept if it moves the tip by this fraction of the tolerance; the fraction decreases after each
/// failed verification.
const KEPT_TIP_MOTION: f64 = 0.1;
const KEPT_FACTOR: f64 = 0.25;

/// Time tolerance of the trials, relative to the requested accuracy.
const TRIAL_TOLERANCE: f64 = 0.3;

/// Maximum number of trials.
const MAX_TRIALS: usize = 24;

/// Number of states of a trial that are examined.
const STATES: usize = 32;

/// Largest number of turns of a segment by its reference strain. The response to loads oscillates with each turn, and polynomials
/// approximate it only with three or more modes per turn (Boyd 2001, section 2.4).
const MOST_TURNS: f64 = 3.0;

/// Number of places of each segment that are measured in addition to tips.
const SECTIONS: usize = 4;

/// What modes are chosen for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Purpose<'a> {
    /// The motion from rest over this interval, in seconds.
    Motion((f64, f64)),
    /// The same with these inputs.
    Held((f64, f64), &'a [f64]),
    /// The equilibrium at this time, in seconds, reached with loads that grow from zero; with contact the one in which the straight
    /// model comes to rest.
    Equilibrium(f64),
    /// The equilibrium that this search finds.
    Search(&'a Search),
}

/// A search for an equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Time of the loads, in seconds.
    pub t: f64,
    /// Inputs; `None` for the defaults.
    pub u: Option<Vec<f64>>,
    /// Options with a start in the coordinates of the robot for which modes are chosen; additional modes start at zero.
    pub options: statics::Options,
}

/// Numbers of modes of the segments `open` in words: those that all have, or the range.
pub fn in_words(robot: &Robot, open: &[usize]) -> String {
    let segments: Vec<_> = robot.segments().collect();
    let of_strain = |k: usize| {
        let counts = open.iter().map(|&i| segments[i].modes[k]);
        let (least, most) = (counts.clone().min()?, counts.max()?);
        match most {
            0 => None,
            most if most == least => Some(format!("{} {most}", STRAIN_NAMES[k])),
            most => Some(format!("{} {least} to {most}", STRAIN_NAMES[k])),
        }
    };
    let counts: Vec<String> = (0..STRAINS).filter_map(of_strain).collect();
    let place = if open.len() > 1 { format!(" in {} segments", open.len()) } else { String::new() };
    format!("Modes chosen{place}: {}.", if counts.is_empty() { "none".to_owned() } else { counts.join(", ") })
}

/// Result of a choice of modes.
#[derive(Clone, Debug)]
pub struct Modes {
    /// The robot with the chosen modes; after an interruption with those that the trials until then needed, without success those of
    /// the most accurate trial.
    pub robot: Robot,
    /// Change of the measured places by the additional modes of the last trial, relative to the length; `None` without
    /// such a trial.
    pub space_error: Option<f64>,
    /// Whether the robot has the requested accuracy.
    pub is_success: bool,
    /// Description of the result, or why there is none.
    pub message: String,
}

/// Chooses the numbers of modes of the segments `open` of a robot, counted link by link, such that its motion or equilibrium
/// has the requested accuracy with respect to modes. Each trial adds modes of every strain and keeps those that move
/// tips; in equilibria, and in robots with closed loops or supports, those that move any section. `monitor` is called with the time
/// after every step of every trial and may stop the search.
///
/// Strains that a symmetric motion does not excite get no modes. Costs about five to fifteen motions or equilibria.
pub fn choose_modes(
    robot: &Robot,
    open: &[usize],
    purpose: Purpose<'_>,
    request: Request,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Modes, InvalidInput> {
    check(robot, open, purpose, request)?;
    let mut trials = Trials { given: robot, open, purpose, request, monitor };
    let mut modes = vec![FIRST_MODES; open.len()];
    let mut kept = KEPT_TIP_MOTION;
    let mut space_error = None;
    let mut best: Option<(f64, Robot)> = None;
    let ended = |failed: Failed, modes: &[[usize; STRAINS]], space_error, best: Option<(f64, Robot)>| {
        let so_far = || with_modes(robot, open, modes);
        let (robot, message) = match failed {
            Failed::Interrupted => {
                let message = "The trials were interrupted: these are the modes that they needed by then.";
                (so_far(), message.to_owned())
            }
            Failed::Because(why) => {
                let robot = best.map_or_else(so_far, |(_, robot)| robot);
                (robot, format!("No modes were chosen, because a trial failed. {why}"))
            }
        };
        Modes { robot, space_error, is_success: false, message }
    };
    for _ in 0..MAX_TRIALS {
        let more: Vec<[usize; STRAINS]> = modes.iter().map(|modes| modes.map(more)).collect();
        let fine = match trials.run(robot, &more)? {
            Ok(trial) => trial,
            Err(failed) => return Ok(ended(failed, &modes, space_error, best)),
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
        let coarse = match trials.run(robot, &needed) {
            Ok(Ok(trial)) => trial,
            Err(_) | Ok(Err(Failed::Because(_))) => {
                // A trial may fail because of too few modes: a beam between two walls cannot bend without stretching.
                (kept, modes) = (KEPT_FACTOR * kept, more);
                continue;
            }
            Ok(Err(failed)) => return Ok(ended(failed, &modes, space_error, best)),
        };
        let apart = SAFETY * largest(&distances(&fine.places, &coarse.places)) / robot.length();
        let error = coarse.space_error.as_ref().map_or(apart, |error| apart.max(error.relative));
        space_error = Some(error);
        if error <= request.rtol {
            let message = format!("The modes leave a space error of {error:.0e} of the length.");
            if coarse.model.facts().n == 0 {
                return Ok(unmoved(robot, open, error));
            }
            return Ok(Modes { robot: coarse.robot, space_error, is_success: true, message });
        }
        let given = coarse.too_few_given(open, request.rtol);
        if best.as_ref().is_none_or(|(smallest, _)| error < *smallest) {
            best = Some((error, coarse.robot));
        }
        if let (Some(message), true) = (given, apart <= request.rtol)
            && let Some((_, robot)) = best
        {
            return Ok(Modes { robot, space_error, is_success: false, message });
        }
        (kept, modes) = (KEPT_FACTOR * kept, more);
    }
    let message = format!(
        "No number of modes was found that reaches {:.0e}: cut the rod into more segments, or ask for less.",
        request.rtol
    );
    let robot = best.map_or_else(|| with_modes(robot, open, &modes), |(_, robot)| robot);
    Ok(Modes { robot, space_error, is_success: false, message })
}

/// Reports invalid arguments.
fn check(robot: &Robot, open: &[usize], purpose: Purpose<'_>, request: Request) -> Result<(), InvalidInput> {
    request.validate()?;
    let mut check = Checker::new();
    let (Purpose::Motion((t0, _))
    | Purpose::Held((t0, _), _)
    | Purpose::Equilibrium(t0)
    | Purpose::Search(&Search { t: t0, .. })) = purpose;
    if check.require(t0.is_finite(), "t_span[0]", t0, "a finite number (seconds)")
        && let Purpose::Motion((_, t_end)) | Purpose::Held((_, t_end), _) = purpose
    {
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
        let turns = if is_there { reference_turns(segments[segment]) } else { 0.0 };
        let expected = format!(
            "at most {MOST_TURNS}: what loads change swings with each turn; make it of {} segments",
            (turns / MOST_TURNS).ceil()
        );
        let place = format!("segments[{segment}].reference_strain");
        check.require(turns <= MOST_TURNS, &place, format_args!("{turns:.1} turns"), &expected);
    }
    check.finish()
}

/// Result if nothing moves by the requested accuracy.
fn unmoved(robot: &Robot, open: &[usize], error: f64) -> Modes {
    let one_bend = [0, 1, 0, 0, 0, 0];
    let message = "Nothing moves the tip by as much as the accuracy: one mode of bending is there because a rod needs one. If a load \
                   was meant to, look at its times and at its size.";
    let robot = with_modes(robot, open, &vec![one_bend; open.len()]);
    Modes { robot, space_error: Some(error), is_success: true, message: message.to_owned() }
}

/// Number of modes of a strain in a trial.
pub(super) fn more(modes: usize) -> usize {
    if modes == 0 { ANY_MODES } else { (modes + MORE_MODES).min(MAX_MODES) }
}

pub(super) fn with_modes(robot: &Robot, open: &[usize], modes: &[[usize; STRAINS]]) -> Robot {
    let mut robot = robot.clone();
    let mut segments: Vec<_> = robot.segments_mut().collect();
    for (&segment, &modes) in open.iter().zip(modes) {
        segments[segment].modes = modes;
        segments[segment].modes_are_open = false;
    }
    robot
}

/// Coordinates of a robot in one with other numbers of modes: modes that only one of them has are left out, or zero.
fn carried(from: &Robot, to: &Robot, q: &[f64]) -> Vec<f64> {
    let mut there = Vec::with_capacity(to.coordinates());
    let mut next = 0;
    for (segment, (old, new)) in from.segments().zip(to.segments()).enumerate() {
        let first = from.first_coordinate(segment);
        there.extend_from_slice(&q[next..first]);
        next = first;
        for (&old, &new) in old.modes.iter().zip(&new.modes) {
            let both = old.min(new);
            there.extend_from_slice(&q[next..next + both]);
            there.resize(there.len() + new - both, 0.0);
            next += old;
        }
    }
    there.extend_from_slice(&q[next..]);
    there
}

impl Search {
    /// The options for a robot with other numbers of modes than the given one.
    pub fn options_for(&self, given: &Robot, robot: &Robot) -> statics::Options {
        let mut options = self.options.clone();
        if let Start::Descent(q) | Start::Newton(q) = &mut options.start {
            *q = carried(given, robot, q);
        }
        options
    }
}

/// Data shared by all trials.
struct Trials<'a> {
    given: &'a Robot,
    open: &'a [usize],
    purpose: Purpose<'a>,
    request: Request,
    monitor: &'a mut dyn FnMut(f64) -> Result<(), Interrupted>,
}

/// A motion or an equilibrium with a given number of modes.
struct Trial {
    robot: Robot,
    model: RobotModel,
    /// Times and coordinates of its states, one after the other.
    t: Vec<f64>,
    q: Vec<f64>,
    /// Measured places at all times.
    places: Vec<[f64; 3]>,
    /// Space error of this number of modes, if known without another trial.
    space_error: Option<SpaceError>,
}

/// Why there is no trial.
enum Failed {
    Interrupted,
    Because(String),
}

impl Trials<'_> {
    fn run(
        &mut self,
        robot: &Robot,
        modes: &[[usize; STRAINS]],
    ) -> Result<Result<Trial, Failed>, InvalidInput> {
        let robot = with_modes(robot, self.open, modes);
        let mut model = RobotModel::new(&robot)?;
        match self.purpose {
            Purpose::Motion(t_span) => self.motion(robot, model, t_span),
            Purpose::Held(t_span, u) => {
                model.set_inputs(u);
                self.motion(robot, model, t_span)
            }
            Purpose::Equilibrium(t) => {
                let options = statics::Options::of(model.facts());
                self.equilibrium(robot, model, (t, None), options)
            }
            Purpose::Search(search) => {
                let options = search.options_for(self.given, &robot);
                self.equilibrium(robot, model, (search.t, search.u.as_deref()), options)
            }
        }
    }

    fn motion(
        &mut self,
        robot: Robot,
        mut model: RobotModel,
        t_span: (f64, f64),
    ) -> Result<Result<Trial, Failed>, InvalidInput> {
        let rest = vec![0.0; model.facts().n];
        let tolerance = TRIAL_TOLERANCE * self.request.rtol;
        let request = Request { rtol: tolerance, ..self.request };
        let given = Given { t_span, start: [&rest, &rest], held: None, t_eval: None };
        let plan = Plan::new(&mut model, given, request, None, self.monitor)?;
        let run = plan.run(tolerance, f64::INFINITY, self.monitor)?;
        let is_success = run.is_success();
        let Run { simulation, tips, .. } = run;
        if !is_success {
            let is_interrupted = simulation.status.is_interrupted();
            return Ok(Err(if is_interrupted {
                Failed::Interrupted
            } else {
                Failed::Because(simulation.message)
            }));
        }
        let (t, q) = (simulation.t, simulation.q);
        Ok(Ok(Trial { robot, model, t, q, places: tips, space_error: None }.with_sections()))
    }

    fn equilibrium(
        &mut self,
        robot: Robot,
        mut model: RobotModel,
        (t, u): (f64, Option<&[f64]>),
        options: statics::Options,
    ) -> Result<Result<Trial, Failed>, InvalidInput> {
        if let Some(u) = u {
            model.set_inputs(u);
        }
        if model.set_time(t).is_err() {
            return Ok(Err(Failed::Interrupted));
        }
        let options = statics::Options { stability: false, ..options };
        let mut monitor = || (self.monitor)(t);
        let Ok(found) = statics::equilibrium(&mut model, &options, &mut monitor)? else {
            return Ok(Err(Failed::Interrupted));
        };
        if !found.status.is_success() {
            return Ok(Err(Failed::Because(found.message)));
        }
        let Ok(error) = statics::space_error(&mut model, &found, (t, u), Effort::Full) else {
            return Ok(Err(Failed::Interrupted));
        };
        let mut places = Vec::new();
        model.places(&found.q, &mut places);
        Ok(Ok(Trial { robot, model, t: vec![t], q: found.q, places, space_error: error }.with_sections()))
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
    /// What to say if the error is due to segments whose modes are given.
    fn too_few_given(&self, open: &[usize], rtol: f64) -> Option<String> {
        let SpaceError { relative, segment, name, strain, .. } = self.space_error.as_ref()?;
        (*relative > rtol && !open.contains(segment)).then(|| {
            format!(
                "The space error is {relative:.0e} of the length, most of it by {strain}, due to the modes of {name}, which are given: give it \
                 more, or leave them open."
            )
        })
    }

    /// Places along rods that are measured in addition to tips: if constraints or springs act, and in equilibria.
    fn sections(&self) -> Vec<Place> {
        let facts = self.model.facts();
        let is_held = facts.constraints() > 0 || facts.springs > 0;
        if is_held || self.t.len() == 1 { self.model.places_along_rods(SECTIONS) } else { Vec::new() }
    }

    fn with_sections(mut self) -> Self {
        let (sections, n) = (self.sections(), self.model.facts().n);
        for (q, &t) in self.q.chunks_exact(n.max(1)).zip(&self.t) {
            if sections.is_empty() || self.model.set_time(t).is_err() {
                break;
            }
            let place = |place| self.model.pose_at(q, place).position.to_array();
            self.places.extend(sections.iter().map(place));
        }
        self
    }

    /// Largest displacement of the measured places by each coordinate, to first order, in metres.
    fn moved(&self) -> Vec<f64> {
        let mut model = self.model.clone();
        let n = model.facts().n;
        let places = [model.tips_of_rods(), self.sections()].concat();
        let mut jacobian = Matrix::zeros(6, n);
        let mut moved = vec![0.0_f64; n];
        let states = self.q.chunks_exact(n.max(1));
        let every = states.len().div_ceil(STATES).max(1);
        for (q, &t) in states.zip(&self.t).rev().step_by(every) {
            // The run has already evaluated this time; a failure here has occurred there too.
            if model.set_time(t).is_err() {
                continue;
            }
            for place in &places {
                model.jacobian_at(q, place, &mut jacobian);
                for (k, moved) in moved.iter_mut().enumerate() {
                    let velocity = (3..6).map(|i| jacobian[(i, k)].powi(2)).sum::<f64>().sqrt();
                    *moved = moved.max(velocity * q[k].abs());
                }
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::{carried, in_words, with_modes};
    use crate::description::joint::Joint;
    use crate::description::rod::Segment;
    use crate::robot::{Link, Robot};

    fn robot() -> Robot {
        let segment = |modes| Segment { modes, ..Segment::straight(1.0, 1e-3, 1e9, 4e8, 1e3) };
        let rod = vec![segment([0, 2, 0, 0, 0, 0]), segment([1, 1, 0, 0, 0, 0])];
        Robot::new(vec![Link { joint: Joint::Free, rod, ..Link::new("rod") }])
    }

    #[test]
    fn coordinates_of_joints_and_common_modes_are_carried() {
        let (given, open) = (robot(), [0, 1]);
        let other = with_modes(&given, &open, &[[0, 3, 1, 0, 0, 0], [0, 2, 0, 0, 0, 0]]);
        let q: Vec<f64> = (1..=10).map(f64::from).collect();
        let expected = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 0.0, 0.0, 10.0, 0.0];
        assert_eq!(carried(&given, &other, &q), expected);
        assert_eq!(carried(&given, &given, &q), q);
        assert_eq!(in_words(&other, &open), "Modes chosen in 2 segments: bend_y 2 to 3, bend_z 0 to 1.");
    }
}
