//! Forces and stiffnesses of a model at rest with the magnitudes of their terms, for bounds of rounding, and the residual of equilibrium.

use crate::analysis::normalised;
use crate::analysis::normalised::{DISPLACEMENT_ROUNDING, Normalised, scaled};
use crate::analysis::ties::Ties;
use crate::model::{Reached, Static};
use crate::numerics::linalg::{Matrix, norm};

/// Largest residual of an equilibrium over the magnitude of all forces: ten times the tolerance of equilibria. It contributes to the
/// error of the stiffness.
pub(crate) const LARGEST_RESIDUAL: f64 = 1e-9;

/// Magnitudes of generalised forces below this fraction of the largest one of the same part are rounding: no force does work along such
/// a coordinate.
const NEGLIGIBLE_FORCE: f64 = 1e-5;

/// Gaps up to this part of their sizes are those of closed loops and taut tendons.
const LARGEST_CLOSED_GAP: f64 = 1e-9;

/// A gap displaces the constraint force relative to both of its ends.
const ENDS_OF_A_GAP: f64 = 2.0;

/// Rounding of a stiffness over n coordinates, in units of n eps times the sum of the magnitudes of its terms: each is itself a sum of
/// products of rotations, and a change of charts multiplies it once more.
pub(crate) const ROUNDING: f64 = 16.0;

/// Central differences of eighth order (Fornberg 1988, table 1), and their step in sizes, whose eighth power over 630, the relative
/// error, is rounding.
const DIFFERENCES: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
pub(crate) const DIFFERENCE_STEP: f64 = 0.03;

/// A sum of matrices, and the sum of the magnitudes of their entries.
pub(crate) struct Sum {
    pub(crate) total: Matrix,
    pub(crate) magnitudes: Matrix,
}

/// Forces and stiffnesses of a model at rest, in scaled coordinates, as sums of contributions: gravity may cancel a contact or a loop,
/// which leaves only rounding.
pub(crate) struct AtRest<'a> {
    pub(crate) model: &'a mut dyn Static,
    pub(crate) q: &'a [f64],
    pub(crate) sizes: &'a [f64],
    pub(crate) load_factor: f64,
    pub(crate) multipliers: &'a [f64],
    /// Springs and taut tendons, whose forces are prescribed, and these forces.
    pub(crate) ties: &'a Ties,
    pub(crate) tie_forces: &'a [f64],
}

impl AtRest<'_> {
    /// Evaluates the whole model, the model without constraint forces, and the model also without contacts, each with the prescribed
    /// forces of springs and taut tendons.
    fn each<T: Clone>(&mut self, mut get: impl FnMut(&mut dyn Static) -> T) -> [T; 3] {
        let Self { multipliers, ties, tie_forces, .. } = *self;
        let none = vec![0.0; multipliers.len()];
        ties.hold(self.model, tie_forces, multipliers);
        if !multipliers.is_empty() {
            self.model.set_multipliers(multipliers);
        }
        let whole = get(self.model);
        let mut unconstrained = whole.clone();
        if !multipliers.is_empty() {
            self.model.set_multipliers(&none);
            ties.hold(self.model, tie_forces, &none);
            unconstrained = get(self.model);
        }
        let mut untouched = unconstrained.clone();
        if self.model.facts().has_contact {
            self.model.leave_contact(true);
            untouched = get(self.model);
            self.model.leave_contact(false);
        }
        ties.release(self.model);
        [whole, unconstrained, untouched]
    }

    /// Normalised coordinates with springs and taut tendons, and the forces of these at equilibrium. `reference` computes stiffnesses from
    /// the model for coordinates without elasticity.
    pub(crate) fn spring_forces(
        &mut self,
        material: &Matrix,
        reference: impl Fn(&Matrix) -> Vec<f64>,
    ) -> Option<(Normalised, Vec<f64>)> {
        let Some(springs) = &self.ties.all else {
            self.ties.hold(self.model, &[], self.multipliers);
            let stiffness = self.tangent([1.0, 0.0, 0.0]);
            self.ties.release(self.model);
            return Some((Normalised::new(material, None, || reference(&stiffness))?, Vec::new()));
        };
        let normalised = Normalised::new(material, Some(springs), || reference(material))?;
        let [residual, _] = self.with_tie_forces(&springs.forces).forces();
        let forces = normalised.forces_at_equilibrium(springs, &normalised.forces(&residual));
        Some((normalised, forces))
    }

    /// The same with other forces of springs and tendons.
    pub(crate) fn with_tie_forces<'b>(&'b mut self, tie_forces: &'b [f64]) -> AtRest<'b> {
        AtRest { model: &mut *self.model, tie_forces, ..*self }
    }

    /// `elastic + load_factor loads + constraints`.
    fn under_load(&self, elastic: f64, unconstrained: f64, whole: f64) -> f64 {
        let loads = self.load_factor;
        if loads == 1.0 {
            whole
        } else {
            elastic + loads * (unconstrained - elastic) + (whole - unconstrained)
        }
    }

    pub(crate) fn tangent(&mut self, weights: [f64; 3]) -> Matrix {
        let Self { q, sizes, multipliers, .. } = *self;
        let rest = vec![0.0; q.len()];
        let mut tangent = Matrix::zeros(q.len(), q.len());
        if !multipliers.is_empty() {
            self.model.set_multipliers(multipliers);
        }
        self.model.weighted_tangent(q, &rest, &rest, weights, &mut tangent);
        if !multipliers.is_empty() {
            self.model.set_multipliers(&vec![0.0; multipliers.len()]);
        }
        scaled(tangent, sizes)
    }

    pub(crate) fn stiffness(&mut self, material: &Matrix) -> Sum {
        let Self { q, sizes, .. } = *self;
        let rest = vec![0.0; q.len()];
        let mut elastic = Matrix::zeros(q.len(), q.len());
        self.ties.hold(self.model, self.tie_forces, self.multipliers);
        self.model.elastic_tangent(q, &mut elastic);
        let between = normalised::work_of_interactions(self.model, q, sizes);
        let elastic = scaled(elastic, sizes);
        let parts = self.each(|model| {
            let mut tangent = Matrix::zeros(q.len(), q.len());
            model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
            scaled(tangent, sizes)
        });
        let [work, constraint_loads] = normalised::work_and_constraint_loads(self.model, q, sizes);
        let (mut total, mut magnitudes) = (material.abs(), material.abs());
        for k in 0..total.len() {
            let [whole, unconstrained, untouched] = [0, 1, 2].map(|part| parts[part][k]);
            let elastic = elastic[k];
            total[k] = self.under_load(elastic, unconstrained, whole);
            magnitudes[k] +=
                self.magnitude((elastic - material[k]).abs(), elastic, [whole, unconstrained, untouched]);
        }
        // Entries of loads are sums of products that may cancel: they are bounded by the magnitudes of the loads in any direction and of
        // the constraint wrenches of joints.
        for range in self.parts() {
            for (i, j) in range.clone().flat_map(|i| range.clone().map(move |j| (i, j))) {
                let most = work[i].min(work[j]) + constraint_loads[i].min(constraint_loads[j]);
                magnitudes[(i, j)] += self.load_factor.abs() * most;
            }
        }
        // Contacts and tendons couple parts.
        for (i, j) in (0..q.len()).flat_map(|i| (0..q.len()).map(move |j| (i, j))) {
            magnitudes[(i, j)] += self.load_factor.abs() * between[i].min(between[j]);
        }
        Sum { total, magnitudes }
    }

    /// Coordinates of uncoupled parts.
    fn parts(&self) -> Vec<std::ops::Range<usize>> {
        let whole = [self.q.len()];
        let parts = match &self.model.facts().parts[..] {
            [] => &whole,
            parts => parts,
        };
        let mut first = 0;
        parts
            .iter()
            .map(|part| {
                first += part;
                first - part..first
            })
            .collect()
    }

    /// Generalised forces times sizes, and the summed magnitudes of their contributions.
    pub(crate) fn forces(&mut self) -> [Vec<f64>; 2] {
        let Self { q, sizes, .. } = *self;
        let rest = vec![0.0; q.len()];
        let mut elastic = rest.clone();
        self.ties.hold(self.model, self.tie_forces, self.multipliers);
        self.model.elastic_forces(q, &mut elastic);
        let between = normalised::work_of_interactions(self.model, q, sizes);
        let parts = self.each(|model| {
            let mut forces = rest.clone();
            model.inverse_dynamics(q, &rest, &rest, &mut forces);
            forces
        });
        let of_loads = normalised::work_of_loads(self.model, q, sizes);
        let [mut total, mut work] = [rest.clone(), rest.clone()];
        for (k, size) in sizes.iter().enumerate() {
            let [whole, unconstrained, untouched] = [0, 1, 2].map(|part| parts[part][k]);
            total[k] = size * self.under_load(elastic[k], unconstrained, whole);
            work[k] = size * self.magnitude(elastic[k].abs(), elastic[k], [whole, unconstrained, untouched])
                + self.load_factor.abs() * (of_loads[k] + between[k]);
        }
        [total, work]
    }

    /// The sum of the magnitudes of elasticity (`size`), loads, contacts and constraints.
    fn magnitude(&self, size: f64, elastic: f64, [whole, unconstrained, untouched]: [f64; 3]) -> f64 {
        let by_loads = (untouched - elastic).abs() + (unconstrained - untouched).abs();
        size + self.load_factor.abs() * by_loads + (whole - unconstrained).abs()
    }

    /// The residual, limited to what tolerance and rounding of coordinates explain; with a larger residual the shape is no equilibrium.
    pub(crate) fn missing(&self, residual: &[f64], work: &[f64], magnitudes: &Matrix) -> Vec<f64> {
        let most = |k: usize| {
            LARGEST_RESIDUAL * work[k] + DISPLACEMENT_ROUNDING * magnitudes.row(k).iter().sum::<f64>()
        };
        residual.iter().enumerate().map(|(k, force)| force.min(most(k)).max(-most(k))).collect()
    }

    /// Magnitudes of forces along each coordinate, at least [`NEGLIGIBLE_FORCE`] of the largest one of the same part.
    pub(crate) fn most_work(&self, work: &[f64]) -> Vec<f64> {
        let mut most = work.to_vec();
        for range in self.parts() {
            let least = NEGLIGIBLE_FORCE * most[range.clone()].iter().copied().fold(0.0, f64::max);
            most[range].iter_mut().for_each(|work| *work = work.max(least));
        }
        most
    }

    /// Bound of the error of the stiffness due to missing forces: their norm, since a turn about one axis changes moments about another
    /// one by half of the moment about the third; and their relative size times the magnitudes of forces, because the shape is an
    /// equilibrium under forces that differ by this relative size (Rigal and Gaches 1967). Zero between uncoupled parts.
    pub(crate) fn imbalance(&self, missing: &[f64], work: &[f64]) -> Matrix {
        let mut imbalance = Matrix::zeros(missing.len(), missing.len());
        let most = self.most_work(work);
        for range in self.parts() {
            let part = |k: usize| if missing[k] == 0.0 { 0.0 } else { missing[k].abs() / most[k] };
            let (size, part) = (norm(&missing[range.clone()]), range.clone().map(part).fold(0.0, f64::max));
            for (i, j) in range.clone().flat_map(|i| range.clone().map(move |j| (i, j))) {
                imbalance[(i, j)] = size.min(part * work[i].min(work[j]));
            }
        }
        imbalance
    }

    /// The stiffness in a neighbour of a shape in which the forces `idle` do not act and those of `here` are at their limits. Forces that
    /// come to their limits by the step between the two shapes do not act either.
    pub(crate) fn stiffness_beyond(
        &mut self,
        material: &Matrix,
        idle: &[Reached],
        here: &[Reached],
    ) -> Matrix {
        let more = self.model.reached(self.q).into_iter().filter(|reached| !here.contains(reached));
        let all: Vec<Reached> = idle.iter().copied().chain(more).collect();
        let is_more = all.len() > idle.len();
        if is_more {
            self.model.decide(&all);
        }
        let there = self.stiffness(material).total;
        if is_more {
            self.model.decide(idle);
        }
        there
    }

    /// The derivative of the constraints.
    pub(crate) fn gap_jacobian(&mut self) -> Matrix {
        let mut rows = Matrix::zeros(self.multipliers.len(), self.q.len());
        if !self.multipliers.is_empty() {
            self.model.gap_jacobian(self.q, &mut rows);
        }
        rows
    }

    /// Bound of the error of the stiffness due to gaps of constraints with these derivatives: gaps displace the constraint forces.
    /// Slack tendons have none.
    pub(crate) fn of_gaps(&mut self, rows: &Matrix) -> Matrix {
        let (n, m) = (self.q.len(), self.multipliers.len());
        let (mut change, mut gaps) = (Matrix::zeros(n, n), vec![0.0; m]);
        if m == 0 {
            return change;
        }
        self.model.gaps(self.q, &mut gaps);
        let gap_sizes = &self.model.facts().gap_sizes;
        let relative: Vec<f64> = gaps.iter().zip(gap_sizes).map(|(gap, size)| gap / size).collect();
        let work: Vec<f64> =
            self.multipliers.iter().zip(gap_sizes).map(|(force, size)| force * size).collect();
        for range in self.parts() {
            let is_own = |i: usize| {
                relative[i].abs() <= LARGEST_CLOSED_GAP && range.clone().any(|k| rows[(i, k)] != 0.0)
            };
            let size =
                |values: &[f64]| (0..m).filter(|&i| is_own(i)).map(|i| values[i].powi(2)).sum::<f64>().sqrt();
            let most = ENDS_OF_A_GAP * size(&work) * (size(&relative) + f64::EPSILON);
            change.view_mut((range.start, range.start), (range.len(), range.len())).fill(most);
        }
        change
    }

    /// Difference between numerical derivatives of the forces along directions, in columns, and the tangent stiffness, in scaled
    /// coordinates: the error of quadrature along rods. Contacts are left out, and springs and tendons keep their forces, because their
    /// stiffness is exact.
    pub(crate) fn mismatch(&mut self, directions: &Matrix) -> Matrix {
        let Self { q, sizes, load_factor, multipliers, .. } = *self;
        let (n, rest) = (q.len(), vec![0.0; q.len()]);
        let under_load = |elastic: f64, whole: f64| elastic + load_factor * (whole - elastic);
        let tensions = self.ties.tensions(self.tie_forces, multipliers);
        let (ties, tie_forces) = (self.ties, self.tie_forces);
        let model = &mut *self.model;
        ties.hold(model, tie_forces, multipliers);
        if !multipliers.is_empty() {
            model.set_multipliers(multipliers);
        }
        model.hold_length_tendons(Some(&tensions));
        model.leave_contact(true);
        let [mut elastic, mut whole] = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
        model.elastic_tangent(q, &mut elastic);
        model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut whole);
        let mut mismatch = -(scaled(elastic.zip_map(&whole, under_load), sizes) * directions);
        let [mut elastic, mut whole] = [rest.clone(), rest.clone()];
        for (along, mut mismatch) in directions.column_iter().zip(mismatch.column_iter_mut()) {
            let step = DIFFERENCE_STEP / along.amax();
            let weighted = DIFFERENCES.into_iter().zip([1.0, 2.0, 3.0, 4.0]);
            for (weight, distance) in weighted.flat_map(|(weight, k)| [(weight, k), (-weight, -k)]) {
                let moved = q.iter().zip(sizes).zip(along.iter());
                let moved: Vec<f64> = moved.map(|((q, size), x)| q + size * (distance * step * x)).collect();
                model.elastic_forces(&moved, &mut elastic);
                model.inverse_dynamics(&moved, &rest, &rest, &mut whole);
                for k in 0..n {
                    mismatch[k] += weight * sizes[k] * under_load(elastic[k], whole[k]) / step;
                }
            }
        }
        model.leave_contact(false);
        ties.release(model);
        model.hold_length_tendons(None);
        if !multipliers.is_empty() {
            model.set_multipliers(&vec![0.0; multipliers.len()]);
        }
        mismatch
    }
}
