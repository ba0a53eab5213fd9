//! Modes that a model lacks, found from the unbalanced forces of its motion.
//!
//! States of a motion are inserted into a model with many more modes. The forces on the new modes do not
//! vanish, and the static displacement of the tip that they would cause shows which strains without modes
//! matter, and which fraction of the missing displacement a model with only two more modes per strain
//! captures. Kinks, point loads and springs near an end act on much higher modes than the next ones.

use super::paths::{largest, size};
use crate::analysis::refined::{all_places, embed, places_of_modes};
use crate::model::constraint::one_sided;
use crate::model::{ForwardScratch, Model};
use crate::numerics::linalg::Matrix;
use crate::simulation::simulate::Simulation;

/// Additional modes: of a strain that has modes, of a strain without modes, in the model that is simulated,
/// and in the richest model, which is only evaluated for forces.
const MORE_MODES: usize = 2;
const ANY_MODES: usize = 1;
const MANY_MODES: usize = 12;
const SOME_MODES: usize = 3;

/// Largest model for evaluations of forces: one second of work.
const MOST_COORDINATES: usize = 600;

/// Number of examined states of the motion, without the first state, in which the tip has no error yet.
const STATES: usize = 12;

/// Strains without modes get some if they move the tip by this fraction of the tolerance, relative to the
/// length, or deform the model by this fraction, relative to typical deformations. The second condition
/// matters for the torsion of a straight rod, which moves the tip only later.
const MATTERS: f64 = 0.1;

/// Strains without modes whose frequency exceeds the resolved ones by this factor respond statically; the
/// forces give their whole effect, and they get no modes.
const FAST: f64 = 10.0;

/// A suddenly loaded spring overshoots to twice its static displacement.
const SUDDEN: f64 = 2.0;

/// Claimed error over the estimate: not less than the true error for most random rods
/// (`benches/python/accuracy/honesty.py --space`).
pub(super) const SAFETY: f64 = 2.0;

/// Upper bound of the tip error, relative to the length.
const FARTHEST: f64 = 2.0;

/// A finer model for comparison.
pub(super) struct Finer<M> {
    pub(super) model: M,
    pub(super) estimate: Estimate,
    /// Indices of the coarse model's coordinates in this model.
    places: Vec<usize>,
}

impl<M: Model> Finer<M> {
    /// Converts coordinates of the coarse model to coordinates of this model.
    pub(super) fn embed(&self, values: &[f64]) -> Vec<f64> {
        embed(values, &self.places, self.model.facts().n)
    }
}

/// Static displacements of the tip by new modes, relative to the length.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Estimate {
    /// By the modes of the finer model.
    finds: f64,
    /// By modes that even the finer model lacks, without fast strains.
    leaves: f64,
    /// By fast strains.
    fast: f64,
}

impl Estimate {
    /// Space error of the coarse model whose tip differs from that of the finer model by `apart`. The effect
    /// of modes that even the finer model lacks is added: in proportion to the observed difference, if the
    /// finer model captures most of the static displacement.
    pub(super) fn error(self, apart: f64) -> f64 {
        let left =
            if self.leaves < self.finds { apart * self.leaves / self.finds } else { self.leaves.max(apart) };
        (SAFETY * (apart + left) + SUDDEN * self.fast).min(FARTHEST)
    }
}

/// A finer model for comparison with `coarse`, given its motion, whose steps resolved frequencies up to
/// `resolved` rad/s. An error is the reason why there is none; `None` for models that are not discretised.
pub(super) fn finer<M: Model + Clone>(
    coarse: &M,
    motion: &Simulation,
    resolved: f64,
    tolerance: f64,
) -> Result<Option<Finer<M>>, &'static str> {
    let Some(modes) = coarse.modes() else {
        let why = "its bases are made of pieces, to which no modes can be added";
        return if coarse.facts().is_discretised { Err(why) } else { Ok(None) };
    };
    let with_more = |of_some: usize, of_none: usize| -> Vec<usize> {
        modes.iter().map(|&modes| if modes == 0 { of_none } else { modes + of_some }).collect()
    };
    let between = coarse.coordinates_between();
    let model_with = |fine: &[usize], estimate: Estimate| {
        let model = coarse.with_modes(fine).ok_or("with more modes the model would be too large")?;
        Ok(Some(Finer { model, estimate, places: all_places(&modes, fine, &between) }))
    };
    let richest = with_more(MANY_MODES, SOME_MODES);
    let is_small = richest.iter().sum::<usize>() <= MOST_COORDINATES;
    let Some(mut richer) = is_small.then(|| coarse.with_modes(&richest)).flatten() else {
        // Too large to find out which strains matter and how much even the finer model lacks.
        return model_with(&with_more(MORE_MODES, 0), Estimate::default());
    };
    let missing = Missing::new(coarse, &mut richer, &all_places(&modes, &richest, &between), motion);
    let of_modes = |modes: &[usize]| places_of_modes(modes, &richest, &between);
    let mut moved = |modes: &[usize]| missing.moved(&mut richer, &of_modes(modes));
    let (mut fine, mut slow) = (with_more(MORE_MODES, ANY_MODES), richest.clone());
    let mut first = 0;
    for (series, &number) in richest.iter().enumerate() {
        first += between[series];
        if modes[series] == 0 {
            let mut only = modes.clone();
            only[series] = number;
            let is_fast = missing.frequency(first) > FAST * resolved;
            let matters = missing.deforms(&of_modes(&only)) > MATTERS * tolerance
                || longest(&moved(&only)) > MATTERS * tolerance * coarse.facts().length;
            if is_fast || !matters {
                fine[series] = 0;
            }
            if is_fast {
                slow[series] = 0;
            }
        }
        first += number;
    }
    let [found, of_slow, all] = [&fine, &slow, &richest].map(|modes| moved(modes));
    let relative = |to: &[[f64; 3]], from: &[[f64; 3]]| {
        largest(&super::paths::distances(to, from)) / coarse.facts().length
    };
    let estimate = Estimate {
        finds: longest(&found) / coarse.facts().length,
        leaves: relative(&of_slow, &found),
        fast: relative(&all, &of_slow),
    };
    model_with(&fine, estimate)
}

fn longest(moved: &[[f64; 3]]) -> f64 {
    moved.iter().map(size).fold(0.0, f64::max)
}

/// Forces on a richer model in the states of a coarser model's motion.
struct Missing {
    /// Coordinates of the richer model, and the forces on them.
    states: Vec<[Vec<f64>; 2]>,
    stiffness: Matrix,
    mass: Matrix,
    /// Typical sizes of the coordinates.
    sizes: Vec<f64>,
}

impl Missing {
    fn new<M: Model + Clone>(coarse: &M, richer: &mut M, places: &[usize], motion: &Simulation) -> Self {
        let (n, all) = (motion.n, richer.facts().n);
        let mut coarse = coarse.clone();
        let mut scratch = ForwardScratch::of(&coarse);
        let [mut stiffness, mut mass] = [(); 2].map(|()| Matrix::zeros(all, all));
        let (rest, sizes) = (vec![0.0; all], richer.facts().typical_coordinates.clone());
        richer.elastic_tangent(&rest, &mut stiffness);
        richer.mass_matrix(&rest, &mut mass);
        let last = motion.t.len().saturating_sub(1);
        let mut states = Vec::with_capacity(STATES);
        for i in (1..=STATES).map(|k| k * last / STATES) {
            let [q, v] = [&motion.q, &motion.v].map(|values| &values[i * n..][..n]);
            let mut a = vec![0.0; n];
            let is_known = coarse.set_time(motion.t[i]).is_ok()
                && richer.set_time(motion.t[i]).is_ok()
                && coarse.forward_dynamics(q, v, &mut a, &mut scratch).is_ok();
            if !is_known {
                continue;
            }
            let mut multipliers = vec![0.0; coarse.facts().constraints()];
            if !multipliers.is_empty()
                && one_sided::multipliers(&mut coarse, [q, v, &a], &mut multipliers).is_err()
            {
                continue;
            }
            let [q, v, a] = [q, v, &a[..]].map(|values| embed(values, places, all));
            let mut forces = vec![0.0; all];
            richer.set_multipliers(&multipliers);
            richer.inverse_dynamics(&q, &v, &a, &mut forces);
            multipliers.fill(0.0);
            richer.set_multipliers(&multipliers);
            states.push([q, forces]);
        }
        Self { states, stiffness, mass, sizes }
    }

    /// Uncoupled frequency of a coordinate, in rad/s.
    fn frequency(&self, i: usize) -> f64 {
        (self.stiffness[(i, i)] / self.mass[(i, i)]).sqrt()
    }

    /// Static response of these coordinates in each state.
    fn gives(&self, chosen: &[usize]) -> Vec<Vec<f64>> {
        let of_chosen =
            Matrix::from_fn(chosen.len(), chosen.len(), |i, j| self.stiffness[(chosen[i], chosen[j])]);
        let Some(cholesky) = of_chosen.cholesky() else { return Vec::new() };
        let gives = |[_, forces]: &[Vec<f64>; 2]| {
            let mut give = Matrix::from_fn(chosen.len(), 1, |i, _| -forces[chosen[i]]);
            cholesky.solve_mut(&mut give);
            give.iter().copied().collect()
        };
        self.states.iter().map(gives).collect()
    }

    /// Largest static response of these coordinates, relative to their typical sizes.
    fn deforms(&self, chosen: &[usize]) -> f64 {
        let relative = |give: Vec<f64>| {
            chosen.iter().zip(give).map(|(&place, give)| (give / self.sizes[place]).abs()).fold(0.0, f64::max)
        };
        self.gives(chosen).into_iter().map(relative).fold(0.0, f64::max)
    }

    /// Displacements of the measured places by the static response of these coordinates, in each state.
    fn moved<M: Model>(&self, richer: &mut M, chosen: &[usize]) -> Vec<[f64; 3]> {
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for ([q, _], give) in self.states.iter().zip(self.gives(chosen)) {
            let mut there = q.clone();
            for (&place, give) in chosen.iter().zip(give) {
                there[place] += give;
            }
            richer.places(q, &mut from);
            richer.places(&there, &mut to);
        }
        from.iter().zip(&to).map(|(from, to)| std::array::from_fn(|i| to[i] - from[i])).collect()
    }
}
