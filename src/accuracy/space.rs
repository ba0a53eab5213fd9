//! Which modes a model lacks, by the forces that its motion leaves unbalanced.
//!
//! States of a motion are given to a model with many more modes: the forces that hold the modes there are not zero for the new ones, and what
//! they would do to the tip if the new modes gave way, elastically and at once, tells two things: which strains without modes
//! matter, and how much of what is missing a model with only two more modes of each strain finds. Kinks, point loads and springs near an end are
//! not seen by the next modes but by much higher ones.

use super::following::FARTHEST;
use super::largest;
use crate::linalg::Matrix;
use crate::model::{ForwardScratch, Model};
use crate::simulate::Simulation;

/// More modes of a strain that has any, of one that has none, in the model that is moved, and in the one that is only asked for forces.
const MORE_MODES: usize = 2;
const ANY_MODES: usize = 1;
const MANY_MODES: usize = 12;
const SOME_MODES: usize = 3;

/// The largest model that is asked for forces: a second of work.
const MOST_COORDINATES: usize = 600;

/// States of the motion that are looked at.
const STATES: usize = 12;

/// Strains without modes get one if it moves the tip by this part of the tolerance.
const MATTERS: f64 = 0.1;

/// What is claimed, relative to what is found: not less than the truth for most random rods (`benches/python/auto_honesty.py --space`).
pub(super) const SAFETY: f64 = 1.5;

/// A model to compare with.
pub(super) struct Finer<M> {
    pub(super) model: M,
    /// Which of its coordinates are those of the coarse one.
    places: Vec<usize>,
    estimate: Estimate,
}

impl<M: Model> Finer<M> {
    /// Coordinates of the coarse model as those of this one.
    pub(super) fn embed(&self, values: &[f64]) -> Vec<f64> {
        embed(values, &self.places, self.model.n())
    }

    pub(super) fn estimate(&self) -> Estimate {
        self.estimate
    }
}

/// What new modes do to the tip at once, relative to the length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    /// Those of the finer model.
    finds: f64,
    /// All that even it lacks.
    leaves: f64,
}

impl Estimate {
    /// The space error of the coarse model, where the finer one is apart from it by so much. What even the finer one lacks is added: in
    /// proportion to what came of that which it has, if that is most of it.
    pub(super) fn error(self, apart: f64) -> f64 {
        let left =
            if self.leaves < self.finds { apart * self.leaves / self.finds } else { self.leaves.max(apart) };
        (SAFETY * (apart + left)).min(FARTHEST)
    }
}

/// The model to compare `coarse` with, which has moved like this; why there is none where there is none, and nothing for models that are
/// not discretised.
pub(super) fn finer<M: Model + Clone>(
    coarse: &M,
    motion: &Simulation,
    tolerance: f64,
) -> Result<Option<Finer<M>>, &'static str> {
    let Some(modes) = coarse.modes() else {
        let why = "its bases are made of pieces, to which no modes can be added";
        return if coarse.is_discretised() { Err(why) } else { Ok(None) };
    };
    let too_many = "with more modes the model would be too large";
    let richest: Vec<usize> = modes.iter().map(|&modes| more(modes, [MANY_MODES, SOME_MODES])).collect();
    let is_small = richest.iter().sum::<usize>() <= MOST_COORDINATES;
    let Some(mut richer) = is_small.then(|| coarse.with_modes(&richest)).flatten() else {
        // Nothing tells which strains matter, nor what is left.
        let fine: Vec<usize> = modes.iter().map(|&modes| more(modes, [MORE_MODES, 0])).collect();
        let model = coarse.with_modes(&fine).ok_or(too_many)?;
        let estimate = Estimate { finds: 0.0, leaves: 0.0 };
        return Ok(Some(Finer { model, places: places(&modes, &fine), estimate }));
    };
    let length = coarse.length();
    let missing = Missing::new(coarse, &mut richer, &places(&modes, &richest), motion);
    let mut fine: Vec<usize> = modes.iter().map(|&modes| more(modes, [MORE_MODES, ANY_MODES])).collect();
    for series in (0..modes.len()).filter(|&series| modes[series] == 0) {
        let mut only = modes.clone();
        only[series] = richest[series];
        let alone = missing.moved(&mut richer, &places(&only, &richest));
        if largest(&sizes(&alone)) <= MATTERS * tolerance * length {
            fine[series] = 0;
        }
    }
    let found = missing.moved(&mut richer, &places(&fine, &richest));
    let all = missing.moved(&mut richer, &places(&richest, &richest));
    let left: Vec<[f64; 3]> =
        all.iter().zip(&found).map(|(all, found)| std::array::from_fn(|i| all[i] - found[i])).collect();
    let model = coarse.with_modes(&fine).ok_or(too_many)?;
    let [finds, leaves] = [found, left].map(|moved| largest(&sizes(&moved)) / length);
    Ok(Some(Finer { model, places: places(&modes, &fine), estimate: Estimate { finds, leaves } }))
}

fn embed(values: &[f64], places: &[usize], n: usize) -> Vec<f64> {
    let mut all = vec![0.0; n];
    for (&place, &value) in places.iter().zip(values) {
        all[place] = value;
    }
    all
}

/// More modes of a series that has some, or none.
fn more(modes: usize, [of_some, of_none]: [usize; 2]) -> usize {
    if modes == 0 { of_none } else { modes + of_some }
}

/// Where the coordinates of a model with these numbers of modes are among those of one with more of them.
fn places(modes: &[usize], of: &[usize]) -> Vec<usize> {
    let mut first = 0;
    let mut places = Vec::new();
    for (modes, of) in modes.iter().zip(of) {
        places.extend(first..first + modes);
        first += of;
    }
    places
}

fn sizes(moved: &[[f64; 3]]) -> Vec<f64> {
    moved.iter().map(|moved| moved.iter().map(|x| x * x).sum::<f64>().sqrt()).collect()
}

/// The forces that hold a richer model in the states of a motion of a coarser one.
struct Missing {
    /// Coordinates of the richer model, and the forces on them.
    states: Vec<[Vec<f64>; 2]>,
    stiffness: Matrix,
}

impl Missing {
    fn new<M: Model + Clone>(coarse: &M, richer: &mut M, places: &[usize], motion: &Simulation) -> Self {
        let (n, all) = (motion.n, richer.n());
        let mut coarse = coarse.clone();
        let mut scratch = ForwardScratch::of(&coarse);
        let mut stiffness = Matrix::zeros(all, all);
        richer.elastic_tangent(&vec![0.0; all], &mut stiffness);
        let last = motion.t.len().saturating_sub(1);
        let mut states = Vec::with_capacity(STATES + 1);
        for i in (0..=STATES).map(|k| k * last / STATES) {
            let [q, v] = [&motion.q, &motion.v].map(|values| &values[i * n..][..n]);
            let mut a = vec![0.0; n];
            let is_known = coarse.set_time(motion.t[i]).is_ok()
                && richer.set_time(motion.t[i]).is_ok()
                && coarse.forward_dynamics(q, v, &mut a, &mut scratch).is_ok();
            if !is_known {
                continue;
            }
            let [q, v, a] = [q, v, &a[..]].map(|values| embed(values, places, all));
            let mut forces = vec![0.0; all];
            richer.inverse_dynamics(&q, &v, &a, &mut forces);
            states.push([q, forces]);
        }
        Self { states, stiffness }
    }

    /// How far the tip moves in each state where these coordinates give way.
    fn moved<M: Model>(&self, richer: &mut M, chosen: &[usize]) -> Vec<[f64; 3]> {
        let of_chosen =
            Matrix::from_fn(chosen.len(), chosen.len(), |i, j| self.stiffness[(chosen[i], chosen[j])]);
        let Some(cholesky) = of_chosen.cholesky() else { return Vec::new() };
        let moved = |[q, forces]: &[Vec<f64>; 2]| {
            let mut give = Matrix::from_fn(chosen.len(), 1, |i, _| -forces[chosen[i]]);
            cholesky.solve_mut(&mut give);
            let mut there = q.clone();
            for (i, &place) in chosen.iter().enumerate() {
                there[place] += give[(i, 0)];
            }
            let (from, to) = (richer.tip(q), richer.tip(&there));
            std::array::from_fn(|i| to[i] - from[i])
        };
        self.states.iter().map(moved).collect()
    }
}
