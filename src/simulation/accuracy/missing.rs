//! Modes that a model lacks, found from the unbalanced forces of its motion.
//!
//! States of a motion are inserted into a model with many more modes. The forces on the new modes do not
//! vanish, and the static displacement of the tip that they would cause shows which strains without modes
//! matter, and which fraction of the missing displacement a model with only two more modes per strain
//! captures. Kinks, point loads and springs near an end act on much higher modes than the next ones.

use super::inputs::{Given, set_state};
use super::linear::Response;
use super::paths::{largest, size, turned};
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
const SIGNIFICANT: f64 = 0.1;

/// Deformations smaller than that by this factor fulfil neither condition.
const NEGLIGIBLE_DEFORMATION: f64 = 1e-3;

/// Strains without modes whose frequency exceeds the resolved ones by this factor respond statically; the
/// forces give their whole effect, and they get no modes.
const FAST_FREQUENCY_RATIO: f64 = 10.0;

/// A suddenly loaded spring overshoots to twice its static displacement.
const STEP_LOAD_OVERSHOOT: f64 = 2.0;

/// Part of a diagonal entry of the stiffness below which its pivot is rounding.
const SINGULAR: f64 = 1e-9;

/// Claimed error over the estimate: not less than the true error for most random rods
/// (`benches/python/accuracy/honesty.py --space`).
pub(super) const SAFETY: f64 = 2.0;

/// A vibration that is lost, or has the wrong phase, moves by up to twice its deflection.
const DEFLECTIONS: f64 = 2.0;

/// No run is needed where forces and linear responses alone show a space error of more than this many times what was asked. Of 60 random rods
/// and closed loops runs of a finer model showed 0.44 to 1.9 times that error (`benches/python/accuracy/cost.py`); true errors of 66 random
/// rods were at most 0.95 times it (`honesty.py --space`).
const DECISIVE_EXCESS: f64 = 2.0;

/// Reported error over that one, which lacks what wrong frequencies add.
const REPORTED_SHARE: f64 = 1.5;

/// A bound below this part of what was asked needs no better one.
const SUFFICIENT_BOUND: f64 = 0.5;

/// Upper bound of the tip error, relative to the length.
const FARTHEST: f64 = 2.0;

/// A finer model for comparison, and the estimate of its effect by forces.
pub(super) struct Finer<M> {
    /// `None` if it would be too large, or is not needed.
    pub(super) model: Option<M>,
    pub(super) estimate: Estimate,
    /// Frequencies of the vibrations about the start, in rad/s, with the relative errors that the finer model shows; empty if unknown.
    pub(super) frequencies: Vec<(f64, f64)>,
    /// Indices of the coarse model's coordinates in the finer model.
    places: Vec<usize>,
}

impl<M> Finer<M> {
    /// Converts coordinates of the coarse model to those of the finer one, which has `n`.
    pub(super) fn embed(&self, values: &[f64], n: usize) -> Vec<f64> {
        embed(values, &self.places, n)
    }
}

/// Static displacements of the tip by new modes, relative to the length.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Estimate {
    /// By the modes of the finer model.
    pub(super) finds: f64,
    /// By modes that even the finer model lacks, without fast strains.
    leaves: f64,
    /// By fast strains.
    fast: f64,
    /// Ratio of elastic energies of variation: that of the missing displacements without fast strains, over that of the motion. It is
    /// twice the relative error of frequencies (Rayleigh's quotient).
    pub(super) energy: f64,
    /// Upper bound of the error of the tip, relative to the length, if the motion has none of its deflections.
    pub(super) by_deflection: f64,
    /// Upper bound that is clearly smaller than what was asked, in which all vibrations but the largest one are lost.
    pub(super) at_most: Option<f64>,
    /// Difference of the linear responses of the coarse and of the finer model.
    linear: f64,
    /// Whether the motion is that of the linear response.
    is_linear: bool,
    /// False if the displacements were not found.
    is_known: bool,
}

impl Estimate {
    /// Upper bound of the space error of the coarse model from the static displacements and from `late`, the displacement of the tip by
    /// wrong frequencies. `None` if the forces are unknown.
    pub(super) fn bound(self, late: f64) -> Option<f64> {
        let error =
            SAFETY * (self.finds.max(self.linear) + self.leaves + late) + STEP_LOAD_OVERSHOOT * self.fast;
        (self.is_known && error.is_finite()).then_some(error)
    }

    /// Space error of a motion whose forces and linear responses leave no doubt that it is larger than what was `wanted`, with `late` as in
    /// [`Self::bound`]; `None` for others.
    pub(super) fn beyond(self, wanted: f64, late: f64) -> Option<f64> {
        let shown = self.bound(0.0).filter(|&shown| shown > DECISIVE_EXCESS * wanted)?;
        self.bound(late).map(|bound| bound.min(REPORTED_SHARE * shown).min(FARTHEST))
    }

    /// Space error of a motion that is almost linear; `None` for others.
    pub(super) fn of_linear(self) -> Option<f64> {
        self.bound(0.0).filter(|_| self.is_linear)
    }

    /// Space error of the coarse model whose tip differs from that of the finer model by `apart`. The effect
    /// of modes that even the finer model lacks is added: in proportion to the observed difference, if the
    /// finer model captures most of the static displacement.
    pub(super) fn error(self, apart: f64) -> f64 {
        let left =
            if self.leaves < self.finds { apart * self.leaves / self.finds } else { self.leaves.max(apart) };
        (SAFETY * (apart + left) + STEP_LOAD_OVERSHOOT * self.fast).min(FARTHEST)
    }
}

/// A finer model for comparison with `coarse`, with the motion of that and the measured places on it, whose steps resolved frequencies up to
/// `resolved` rad/s. An error is the reason why there is none; `None` for models that are not discretised.
/// `late_at_most` is the error of the tip by a relative error of the frequency of the largest vibration, without all others, in which
/// vibrations have at most the second argument.
pub(super) fn finer<M: Model + Clone>(
    coarse: &M,
    (motion, tips): (&Simulation, &[[f64; 3]]),
    given: Given<'_>,
    late_at_most: &dyn Fn(f64, f64) -> f64,
    [resolved, tolerance]: [f64; 2],
) -> Result<Option<Finer<M>>, &'static str> {
    let Some(modes) = coarse.modes() else {
        let why = "its bases are made of pieces, to which no modes can be added";
        return if coarse.facts().is_discretised { Err(why) } else { Ok(None) };
    };
    let with_more = |of_some: usize, of_none: usize| -> Vec<usize> {
        modes.iter().map(|&modes| if modes == 0 { of_none } else { modes + of_some }).collect()
    };
    let between = coarse.coordinates_between();
    let richest = with_more(MANY_MODES, SOME_MODES);
    let is_small = richest.iter().sum::<usize>() <= MOST_COORDINATES;
    let Some(mut richer) = is_small.then(|| coarse.with_modes(&richest)).flatten() else {
        // The richest model would be too large: the estimate remains unknown.
        let fine = with_more(MORE_MODES, 0);
        let (model, places) = (coarse.with_modes(&fine), all_places(&modes, &fine, &between));
        return Ok(Some(Finer { model, estimate: Estimate::default(), frequencies: Vec::new(), places }));
    };
    let missing = Missing::new(coarse, &mut richer, &all_places(&modes, &richest, &between), motion);
    let of_modes = |modes: &[usize]| places_of_modes(modes, &richest, &between);
    let mut fine = with_more(MORE_MODES, ANY_MODES);
    let slow = missing.leave_out(&mut richer, &mut fine, [&modes, &richest, &between], [resolved, tolerance]);
    let [found, all] = [&fine, &richest].map(|modes| missing.moved(&mut richer, &of_modes(modes)));
    let of_slow = if slow == richest { all.clone() } else { missing.moved(&mut richer, &of_modes(&slow)) };
    let relative = |to: &[[f64; 3]], from: &[[f64; 3]]| {
        largest(&super::paths::distances(to, from)) / coarse.facts().length
    };
    let mut estimate = Estimate {
        finds: longest(&found) / coarse.facts().length,
        leaves: relative(&of_slow, &found),
        fast: relative(&all, &of_slow),
        energy: missing.energy(&of_modes(&slow)),
        is_known: !all.is_empty() && missing.is_well_conditioned(),
        by_deflection: f64::INFINITY,
        ..Estimate::default()
    };
    // Without a second mode of a strain, nothing tells how far the missing ones reach.
    let has_several = modes.iter().all(|&modes| modes != 1);
    let clear = |estimate: &Estimate| {
        let bound = estimate.bound(late_at_most(0.5 * estimate.energy, estimate.by_deflection));
        bound.filter(|bound| has_several && *bound <= SUFFICIENT_BOUND * tolerance)
    };
    estimate.at_most = clear(&estimate);
    if estimate.at_most.is_none() {
        // All deflections, also those that this model lacks, and what they change of the turns of links meanwhile.
        let deflected = missing.deflected(&mut richer, &of_modes(&richest)) / coarse.facts().length;
        let turned = turned(motion, &coarse.facts().turns, &places_of_modes(&modes, &modes, &between));
        let missed = estimate.finds + estimate.leaves + estimate.fast;
        estimate.by_deflection = DEFLECTIONS * (deflected + missed) * (1.0 + turned);
        estimate.at_most = clear(&estimate);
    }
    let places = all_places(&modes, &fine, &between);
    if estimate.at_most.is_some() {
        return Ok(Some(Finer { model: None, estimate, frequencies: Vec::new(), places }));
    }
    let elastic: Vec<f64> =
        all_places(&fine, &richest, &between).iter().map(|&k| missing.stiffness[(k, k)]).collect();
    let mut model = coarse.with_modes(&fine);
    let compared = model.as_mut().and_then(|fine| {
        Compared::new([&mut coarse.clone(), fine], (motion, tips), given, (&elastic, &places))
    });
    let Compared { apart, is_linear, frequencies } = compared.unwrap_or_default();
    let facts = coarse.facts();
    let acts_on_high_modes = facts.springs > 0 || facts.length_tendons > 0 || facts.has_contact;
    estimate.linear = apart / facts.length;
    estimate.is_linear = is_linear && !acts_on_high_modes;
    Ok(Some(Finer { model, estimate, frequencies, places }))
}

/// Linear responses of a model and of a finer one.
#[derive(Default)]
struct Compared {
    /// Largest distance between both, in metres.
    apart: f64,
    /// Whether the motion is like the first one.
    is_linear: bool,
    /// Frequencies of the first one, with their relative errors.
    frequencies: Vec<(f64, f64)>,
}

impl Compared {
    fn new<M: Model>(
        [coarse, fine]: [&mut M; 2],
        (motion, tips): (&Simulation, &[[f64; 3]]),
        given: Given<'_>,
        (elastic, places): (&[f64], &[usize]),
    ) -> Option<Self> {
        let there = given.start.map(|values| embed(values, places, elastic.len()));
        let there = Given { start: there.each_ref().map(Vec::as_slice), ..given };
        let fine = Response::new(fine, there, &motion.t, elastic)?;
        let coarse = Response::new(coarse, given, &motion.t, elastic)?;
        Some(Self {
            apart: largest(&super::paths::distances(&coarse.places, &fine.places)),
            is_linear: coarse.describes(motion.t.len(), tips),
            frequencies: coarse.errors_of_frequencies(&fine, places),
        })
    }
}

/// Static displacement of the tip by forces on a model with the same coordinates and more nodes, relative to the length, and the
/// ratio of energies as in [`Estimate`]. `None` if the stiffness of the modes is singular.
pub(super) fn by_nodes<M: Model + Clone>(coarse: &M, finer: &mut M, motion: &Simulation) -> Option<[f64; 2]> {
    let same: Vec<usize> = (0..motion.n).collect();
    let missing = Missing::new(coarse, finer, &same, motion);
    let elastic: Vec<usize> = same.into_iter().filter(|&k| missing.stiffness[(k, k)] > 0.0).collect();
    let moved = missing.moved(finer, &elastic);
    (!moved.is_empty()).then(|| [longest(&moved) / coarse.facts().length, missing.energy(&elastic)])
}

fn longest(moved: &[[f64; 3]]) -> f64 {
    moved.iter().map(size).fold(0.0, f64::max)
}

/// Forces on a richer model in the states of a coarser model's motion.
struct Missing {
    /// Coordinates of the richer model, and the forces on them.
    states: Vec<[Vec<f64>; 2]>,
    stiffness: Matrix,
    /// Sets of coordinates coupled by the stiffness.
    blocks: Vec<Vec<usize>>,
    /// Typical sizes of the coordinates.
    sizes: Vec<f64>,
    /// Measured places in all states.
    places: Vec<[f64; 3]>,
    /// Forces on the model at rest.
    still: Vec<f64>,
}

impl Missing {
    fn new<M: Model + Clone>(coarse: &M, richer: &mut M, places: &[usize], motion: &Simulation) -> Self {
        let (n, all) = (motion.n, richer.facts().n);
        let mut coarse = coarse.clone();
        let mut scratch = ForwardScratch::of(&coarse);
        let mut stiffness = Matrix::zeros(all, all);
        let (rest, sizes) = (vec![0.0; all], richer.facts().typical_coordinates.clone());
        richer.elastic_tangent(&rest, &mut stiffness);
        let blocks = blocks(&stiffness);
        let last = motion.t.len().saturating_sub(1);
        let mut states = Vec::with_capacity(STATES);
        for i in (1..=STATES).map(|k| k * last / STATES) {
            let [q, v] = [&motion.q, &motion.v].map(|values| &values[i * n..][..n]);
            let mut a = vec![0.0; n];
            let is_known = set_state(&mut coarse, motion, i).is_ok()
                && set_state(richer, motion, i).is_ok()
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
        let mut from = Vec::new();
        states.iter().for_each(|[q, _]: &[Vec<f64>; 2]| richer.places(q, &mut from));
        let mut still = vec![0.0; all];
        richer.inverse_dynamics(&rest, &rest, &rest, &mut still);
        Self { states, stiffness, blocks, sizes, places: from, still }
    }

    /// Leaves strains that the coarse model does not have out of the `fine` model where they do not deform, are too fast or do not matter. `modes`
    /// are those of the coarse and of the richest model. Returns those of the richest model without the fast ones.
    fn leave_out<M: Model>(
        &self,
        richer: &mut M,
        fine: &mut [usize],
        [modes, richest, between]: [&[usize]; 3],
        [resolved, tolerance]: [f64; 2],
    ) -> Vec<usize> {
        let mut slow = richest.to_vec();
        let mut first = 0;
        for (series, &number) in richest.iter().enumerate() {
            first += between[series];
            if modes[series] == 0 {
                let mut only = modes.to_vec();
                only[series] = number;
                let only = places_of_modes(&only, richest, between);
                if self.deforms(&only) == 0.0 {
                    fine[series] = 0;
                } else if self.frequency(richer, first) > FAST_FREQUENCY_RATIO * resolved {
                    (fine[series], slow[series]) = (0, 0);
                } else if !self.matters(richer, &only, SIGNIFICANT * tolerance) {
                    fine[series] = 0;
                }
            }
            first += number;
        }
        slow
    }

    /// Uncoupled frequency of a coordinate at rest, in rad/s; its mass is the force by which it accelerates.
    fn frequency<M: Model>(&self, richer: &mut M, i: usize) -> f64 {
        let n = self.sizes.len();
        let (rest, mut one) = (vec![0.0; n], vec![0.0; n]);
        let mut moved = vec![0.0; n];
        one[i] = 1.0;
        richer.inverse_dynamics(&rest, &rest, &one, &mut moved);
        (self.stiffness[(i, i)] / (moved[i] - self.still[i])).sqrt()
    }

    /// Whether static responses are accurate in spite of rounding; with many monomials they are not.
    fn is_well_conditioned(&self) -> bool {
        self.blocks.iter().all(|block| {
            if let [i] = block[..] {
                return self.stiffness[(i, i)] >= 0.0;
            }
            let of_block =
                Matrix::from_fn(block.len(), block.len(), |i, j| self.stiffness[(block[i], block[j])]);
            // Coordinates of joints have no stiffness.
            let Some(cholesky) = of_block.clone().cholesky() else {
                return of_block.iter().all(|x| *x == 0.0);
            };
            let factor = cholesky.l_dirty();
            (0..block.len()).all(|i| factor[(i, i)].powi(2) > SINGULAR * of_block[(i, i)])
        })
    }

    /// Static response of these coordinates in each state; empty if their stiffness is singular.
    fn gives(&self, chosen: &[usize]) -> Vec<Vec<f64>> {
        let mut gives = vec![vec![0.0; chosen.len()]; self.states.len()];
        for block in &self.blocks {
            // Positions among the chosen coordinates, which increase.
            let own: Vec<usize> = block.iter().filter_map(|place| chosen.binary_search(place).ok()).collect();
            if own.is_empty() {
                continue;
            }
            if let [i] = own[..] {
                // Orthogonal bases leave most coordinates uncoupled.
                let stiffness = self.stiffness[(chosen[i], chosen[i])];
                if stiffness.is_nan() || stiffness <= 0.0 {
                    return Vec::new();
                }
                for (give, [_, forces]) in gives.iter_mut().zip(&self.states) {
                    give[i] = -forces[chosen[i]] / stiffness;
                }
                continue;
            }
            let of_own = Matrix::from_fn(own.len(), own.len(), |i, j| {
                self.stiffness[(chosen[own[i]], chosen[own[j]])]
            });
            let Some(cholesky) = of_own.cholesky() else { return Vec::new() };
            for (give, [_, forces]) in gives.iter_mut().zip(&self.states) {
                let mut right = Matrix::from_fn(own.len(), 1, |i, _| -forces[chosen[own[i]]]);
                cholesky.solve_mut(&mut right);
                own.iter().zip(right.iter()).for_each(|(&i, &x)| give[i] = x);
            }
        }
        gives
    }

    /// Ratio of elastic energies of variation: that of the static response of these coordinates over that of the motion.
    fn energy(&self, chosen: &[usize]) -> f64 {
        let mut responses = vec![vec![0.0; self.sizes.len()]; self.states.len()];
        for (response, give) in responses.iter_mut().zip(self.gives(chosen)) {
            chosen.iter().zip(give).for_each(|(&place, give)| response[place] = give);
        }
        let motion: Vec<Vec<f64>> = self.states.iter().map(|[q, _]| q.clone()).collect();
        let [missing, present] = [&responses, &motion].map(|states| self.energy_of_variation(states));
        if missing > 0.0 { missing / present } else { 0.0 }
    }

    /// Elastic energy of the deviations of states from their mean, summed over the states.
    fn energy_of_variation(&self, states: &[Vec<f64>]) -> f64 {
        let n = self.sizes.len();
        let mean: Vec<f64> =
            (0..n).map(|k| states.iter().map(|state| state[k]).sum::<f64>() / states.len() as f64).collect();
        let of_state = |state: &Vec<f64>| {
            let away = |k: usize| state[k] - mean[k];
            let of_block = |block: &Vec<usize>| {
                let of_pair = |i: usize, j: usize| away(i) * self.stiffness[(i, j)] * away(j);
                block.iter().map(|&i| block.iter().map(|&j| of_pair(i, j)).sum::<f64>()).sum::<f64>()
            };
            0.5 * self.blocks.iter().map(of_block).sum::<f64>()
        };
        states.iter().map(of_state).sum()
    }

    /// Whether the static response of these coordinates moves the measured places by more than this part of the length, or exceeds this
    /// part of the typical sizes of the coordinates.
    fn matters<M: Model>(&self, richer: &mut M, chosen: &[usize], part: f64) -> bool {
        let deformed = self.deforms(chosen);
        deformed > part
            || (deformed > NEGLIGIBLE_DEFORMATION * part
                && longest(&self.moved(richer, chosen)) > part * richer.facts().length)
    }

    /// Largest static response of these coordinates, relative to their typical sizes.
    fn deforms(&self, chosen: &[usize]) -> f64 {
        let relative = |give: Vec<f64>| {
            chosen.iter().zip(give).map(|(&place, give)| (give / self.sizes[place]).abs()).fold(0.0, f64::max)
        };
        self.gives(chosen).into_iter().map(relative).fold(0.0, f64::max)
    }

    /// Largest displacement of the measured places by these coordinates.
    fn deflected<M: Model>(&self, richer: &mut M, chosen: &[usize]) -> f64 {
        let mut straight = Vec::new();
        for [q, _] in &self.states {
            let mut there = q.clone();
            chosen.iter().for_each(|&place| there[place] = 0.0);
            richer.places(&there, &mut straight);
        }
        largest(&super::paths::distances(&straight, &self.places))
    }

    /// Displacements of the measured places by the static response of these coordinates, in each state.
    fn moved<M: Model>(&self, richer: &mut M, chosen: &[usize]) -> Vec<[f64; 3]> {
        let mut to = Vec::new();
        for ([q, _], give) in self.states.iter().zip(self.gives(chosen)) {
            let mut there = q.clone();
            for (&place, give) in chosen.iter().zip(give) {
                there[place] += give;
            }
            richer.places(&there, &mut to);
        }
        self.places.iter().zip(&to).map(|(from, to)| std::array::from_fn(|i| to[i] - from[i])).collect()
    }
}

/// Sets of coordinates that a symmetric matrix couples, directly or through others; all coordinates, in increasing order.
fn blocks(matrix: &Matrix) -> Vec<Vec<usize>> {
    let n = matrix.nrows();
    let mut is_in_one = vec![false; n];
    let mut blocks = Vec::new();
    for first in 0..n {
        if is_in_one[first] {
            continue;
        }
        is_in_one[first] = true;
        let (mut block, mut next) = (vec![first], 0);
        while next < block.len() {
            let row = block[next];
            let coupled: Vec<usize> = (0..n).filter(|&k| matrix[(row, k)] != 0.0 && !is_in_one[k]).collect();
            coupled.iter().for_each(|&k| is_in_one[k] = true);
            block.extend(coupled);
            next += 1;
        }
        block.sort_unstable();
        blocks.push(block);
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_what_a_matrix_couples() {
        let mut matrix = Matrix::identity(6, 6);
        for (i, j) in [(0, 3), (3, 5), (1, 2)] {
            (matrix[(i, j)], matrix[(j, i)]) = (0.5, 0.5);
        }
        matrix[(4, 4)] = 0.0;
        assert_eq!(blocks(&matrix), [vec![0, 3, 5], vec![1, 2], vec![4]]);
    }
}
