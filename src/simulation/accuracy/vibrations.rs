//! Choice of the numbers of modes for small vibrations about an equilibrium.

use super::modes::{Modes, Purpose, Search, choose_modes, more, with_modes};
use super::request::Request;
use crate::analysis::modes;
use crate::analysis::refined_modes::{RESOLVED, refined_modes};
use crate::analysis::statics;
use crate::description::rod::STRAINS;
use crate::error::{Interrupted, InvalidInput};
use crate::model::{Elastic as _, InTime as _};
use crate::numerics::linalg::Matrix;
use crate::robot::{Robot, RobotModel};

/// A mode is kept if it has this part of the elastic energy of a vibration, relative to twice the permitted change of the frequency
/// (Rayleigh's principle: the square of a frequency is a ratio of energies); less after each failed verification.
const KEPT_ENERGY: f64 = 0.1;
const KEPT_FACTOR: f64 = 0.25;

/// Maximum number of trials: each adds two modes to every strain that has some.
const MAX_TRIALS: usize = 12;

/// Chooses the numbers of modes of the segments `open` such that the equilibrium of a search has the requested accuracy, and that its
/// `count` lowest natural frequencies change by at most [`RESOLVED`] with more modes of every strain. Costs those of the equilibrium
/// ([`choose_modes`]) and about three to ten more equilibria with their vibrations.
///
/// # Errors
/// As [`choose_modes`].
pub fn choose_modes_for_vibrations(
    robot: &Robot,
    open: &[usize],
    search: &Search,
    count: usize,
    request: Request,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Modes, InvalidInput> {
    let at_rest = choose_modes(robot, open, Purpose::Search(search), request, monitor)?;
    if !at_rest.is_success {
        return Ok(at_rest);
    }
    let least = numbers(&at_rest.robot, open);
    let failed =
        |why: String, robot: Robot| Modes { robot, is_success: false, message: why, ..at_rest.clone() };
    let (mut present, mut kept) = (least.clone(), KEPT_ENERGY);
    for _ in 0..MAX_TRIALS {
        let enriched: Vec<[usize; STRAINS]> = present.iter().map(|modes| modes.map(more)).collect();
        let fine = match trial(robot, (open, &enriched), search, monitor)? {
            Ok(fine) => fine,
            Err(why) => return Ok(failed(why, at_rest.robot.clone())),
        };
        let mut needed = fine.needed(open, count, kept * 2.0 * RESOLVED);
        for (needed, least) in needed.iter_mut().flatten().zip(least.iter().flatten()) {
            *needed = (*needed).max(*least);
        }
        let coarse = match trial(robot, (open, &needed), search, monitor)? {
            Ok(coarse) => coarse,
            Err(why) => return Ok(failed(why, at_rest.robot.clone())),
        };
        if coarse.is_resolved(&fine, search, count) {
            let message =
                format!("The modes resolve the {count} lowest frequencies to {:.0} %.", 100.0 * RESOLVED);
            return Ok(Modes { robot: coarse.robot, message, ..at_rest.clone() });
        }
        (kept, present) = (KEPT_FACTOR * kept, enriched);
    }
    let why = format!(
        "No number of modes was found that resolves the {count} lowest frequencies: ask for fewer, or cut the rod into more segments."
    );
    Ok(failed(why, with_modes(robot, open, &present)))
}

/// Numbers of modes of these segments.
fn numbers(robot: &Robot, open: &[usize]) -> Vec<[usize; STRAINS]> {
    let segments: Vec<_> = robot.segments().collect();
    open.iter().map(|&segment| segments[segment].modes).collect()
}

/// An equilibrium with a given number of modes, and its vibrations.
struct Trial {
    robot: Robot,
    model: RobotModel,
    q: Vec<f64>,
    vibrations: modes::Modes,
}

/// A trial, or why there is none.
fn trial(
    robot: &Robot,
    (open, modes): (&[usize], &[[usize; STRAINS]]),
    search: &Search,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Result<Trial, String>, InvalidInput> {
    let stopped = || Ok(Err("The trials were interrupted.".to_owned()));
    let finer = with_modes(robot, open, modes);
    let mut model = RobotModel::new(&finer)?;
    if let Some(u) = &search.u {
        model.set_inputs(u);
    }
    if model.set_time(search.t).is_err() {
        return stopped();
    }
    let options = statics::Options { stability: false, ..search.options_for(robot, &finer) };
    let Ok(found) = statics::equilibrium(&mut model, &options, &mut || monitor(search.t))? else {
        return stopped();
    };
    if !found.status.is_success() {
        return Ok(Err(found.message));
    }
    Ok(match modes::modes(&mut model, &found.q) {
        Ok(vibrations) => Ok(Trial { robot: finer, model, q: found.q, vibrations }),
        Err(why) => Err(format!("There are no vibrations: {why}.")),
    })
}

impl Trial {
    /// Indices of the slowest oscillations.
    fn slowest(&self, count: usize) -> impl Iterator<Item = usize> + '_ {
        let oscillates = |k: &usize| self.vibrations.eigenvalues[*k].im > 0.0;
        (0..self.vibrations.frequency.len()).filter(oscillates).take(count)
    }

    /// Smallest numbers of modes such that no further mode has more than this part of the elastic energy of one of the slowest
    /// vibrations.
    fn needed(&self, open: &[usize], count: usize, part: f64) -> Vec<[usize; STRAINS]> {
        let n = self.q.len();
        let mut elastic = Matrix::zeros(n, n);
        self.model.clone().elastic_tangent(&self.q, &mut elastic);
        let mut largest = vec![0.0_f64; n];
        for k in self.slowest(count) {
            let shape = &self.vibrations.shapes[k * n..(k + 1) * n];
            let energies: Vec<f64> = (0..n).map(|i| elastic[(i, i)] * shape[i].norm_sqr()).collect();
            let whole: f64 = energies.iter().sum();
            for (largest, energy) in largest.iter_mut().zip(energies) {
                *largest = largest.max(if whole > 0.0 { energy / whole } else { 0.0 });
            }
        }
        let modes = numbers(&self.robot, open);
        let of_segment = |(modes, &segment): (&[usize; STRAINS], &usize)| {
            let mut first = self.robot.first_coordinate(segment);
            modes.map(|modes| {
                let own = &largest[first..first + modes];
                first += modes;
                own.iter().rposition(|&share| share > part).map_or(0, |k| k + 1)
            })
        };
        modes.iter().zip(open).map(of_segment).collect()
    }

    /// Whether the slowest vibrations have the frequencies of a model with more modes, and change no more with further ones.
    fn is_resolved(&self, fine: &Self, search: &Search, count: usize) -> bool {
        let frequencies = |trial: &Self| -> Vec<f64> {
            trial.slowest(count).map(|k| trial.vibrations.frequency[k]).collect()
        };
        let (own, others) = (frequencies(self), frequencies(fine));
        let is_close = |(own, other): (&f64, &f64)| (own - other).abs() <= RESOLVED * own.max(*other);
        if own.len() < others.len() || !own.iter().zip(&others).all(is_close) {
            return false;
        }
        let at = (search.t, search.u.as_deref());
        match refined_modes(&mut self.model.clone(), &self.q, at) {
            Ok(Some(refined)) => {
                let resolved = refined.resolved(&self.vibrations.frequency);
                self.slowest(count).all(|k| resolved[k])
            }
            // Functions of time have been evaluated at this time before; large models have no finer ones.
            Ok(None) | Err(Interrupted) => true,
        }
    }
}
