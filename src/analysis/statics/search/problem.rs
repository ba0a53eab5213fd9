//! A model at rest as a problem of least energy: forces, loops, tendons and springs in a shape, along steps of its chart
//! ([`chart`]).

use super::super::equations::Counters;
use super::super::interrupted::Monitor;
use crate::analysis::normalised;
use crate::error::Interrupted;
use crate::model::springs::{LengthTendons, Springs};
use crate::model::{Static, chart, constraint};
use crate::numerics::linalg::{Matrix, dot};

/// Forces whose derivatives differ from their transposes by more than this part of the stiffnesses that they couple have no
/// potential: well above the error of quadrature of sharply bent rods. Weaker forces without a potential only slow the search,
/// because equilibria are judged by forces.
const LARGEST_ASYMMETRY: f64 = 1e-3;

/// Stiffnesses count as at least this part of the largest one when asymmetries are compared with them by [`LARGEST_ASYMMETRY`]: smaller ones are
/// rounding.
const ROUNDING_STIFFNESS: f64 = 1e-8;

/// A model at rest, with the data that do not depend on the shape.
pub(super) struct Problem<'a> {
    pub(super) model: &'a mut dyn Static,
    monitor: Monitor<'a>,
    pub(super) counters: Counters,
    /// First components of rotation vectors.
    pub(super) turns: Vec<usize>,
    rest: Vec<f64>,
    /// Rows of loops among the constraints; tendons that do not stretch follow them there.
    loops: usize,
    tendons: usize,
    springs: usize,
    gap_sizes: Vec<f64>,
    /// Stiffnesses of tendons and springs, infinite for inextensible tendons; one for springs, by their amplitudes.
    pub(super) stiffness: Vec<f64>,
    /// Stiffness of rods and joints.
    pub(super) material: Matrix,
    /// Numbers of coordinates of uncoupled parts.
    pub(super) parts: Vec<usize>,
    /// Whether the forces have had a potential in some shape. In sharply bent shapes the error of quadrature hides it.
    pub(super) is_conservative: bool,
}

/// A shape with its forces and constraints to first order. Rows and forces are along steps, `raw` ones along coordinates.
pub(super) struct Shape {
    pub(super) q: Vec<f64>,
    /// Forces without loops and tendons; of springs only those without amplitudes.
    pub(super) raw_force: Vec<f64>,
    pub(super) force: Vec<f64>,
    /// The same without any springs.
    free_force: Vec<f64>,
    /// The contact forces among them; empty if nothing touches.
    pub(super) contact_force: Vec<f64>,
    pub(super) gaps: Vec<f64>,
    /// The largest gap, in sizes of gaps, including those of dependent rows.
    pub(super) widest: f64,
    raw_gap_rows: Matrix,
    pub(super) gap_rows: Matrix,
    /// Excesses of lengths of tendons, which act above zero; behind them the amplitudes of springs, which act always.
    pub(super) excess: Vec<f64>,
    raw_rows: Matrix,
    pub(super) rows: Matrix,
    /// Magnitudes of the derivatives of the excesses, without cancellation.
    pub(super) reach: Matrix,
    /// Lengths to which the rounding of the excesses is relative.
    pub(super) spans: Vec<f64>,
    springs: Option<Springs>,
    /// Forces of the part of springs without amplitudes.
    left: Vec<f64>,
}

impl<'a> Problem<'a> {
    pub(super) fn new(model: &'a mut dyn Static, monitor: Monitor<'a>) -> Self {
        let n = model.facts().n;
        let rest = vec![0.0; n];
        let (tendons, springs) = (model.facts().length_tendons, model.facts().springs);
        let material = normalised::material(model, &rest, &vec![1.0; n]);
        let mut of_tendons = LengthTendons::new(tendons, n);
        if tendons > 0 {
            model.linearise_length_tendons(&rest, &mut of_tendons);
        }
        let stiffness: Vec<f64> = of_tendons.stiffness.into_iter().chain(vec![1.0; springs]).collect();
        let inextensible = stiffness.iter().filter(|stiffness| stiffness.is_infinite()).count();
        let facts = model.facts();
        let (turns, gap_sizes, parts) =
            (facts.rotation_vectors.clone(), facts.gap_sizes.clone(), facts.parts.clone());
        Self {
            turns,
            rest,
            loops: gap_sizes.len() - inextensible,
            tendons,
            springs,
            gap_sizes,
            stiffness,
            material,
            parts: if parts.iter().sum::<usize>() == n { parts } else { vec![n] },
            model,
            monitor,
            counters: Counters::default(),
            is_conservative: false,
        }
    }

    pub(super) fn n(&self) -> usize {
        self.rest.len()
    }

    /// Whether a row may not be exceeded, and whether it acts on one side only.
    pub(super) fn is_rigid(&self, row: usize) -> bool {
        self.stiffness[row].is_infinite()
    }

    pub(super) fn is_one_sided(&self, row: usize) -> bool {
        row < self.tendons
    }

    pub(super) fn has_rigid(&self) -> bool {
        self.stiffness.iter().any(|stiffness| stiffness.is_infinite())
    }

    /// The shape of these coordinates, folded.
    pub(super) fn shape(&mut self, mut q: Vec<f64>) -> Result<Shape, Interrupted> {
        let n = self.n();
        chart::fold(&self.turns, &mut q);
        let raw_free_force = self.forces(&q)?;
        let contact_force = self.contact_force(&q, &raw_free_force)?;
        let (mut springs, mut left, mut raw_force) = (None, Vec::new(), raw_free_force.clone());
        if self.springs > 0 {
            let mut found = Springs::new(self.springs, n);
            self.model.linearise_springs(&q, &mut found);
            [_, left] = found.mismatch(&vec![0.0; self.springs]);
            let back: Vec<f64> = left.iter().map(|left| -left).collect();
            add_transposed(&found.jacobian, &back, &mut raw_force);
            springs = Some(found);
        }
        let (mut force, mut free_force) = (raw_force.clone(), raw_free_force);
        for force in [&mut force, &mut free_force] {
            chart::forces(&self.turns, &q, force);
        }
        let (mut gaps, mut gap_rows) =
            (vec![0.0; self.model.facts().constraints()], Matrix::zeros(self.model.facts().constraints(), n));
        if self.loops > 0 {
            self.model.gaps(&q, &mut gaps);
            self.model.gap_jacobian(&q, &mut gap_rows);
            let mut sizes = vec![0.0; n];
            self.model.sizes(&q, &mut sizes);
            constraint::forget_unmoved(&mut gap_rows, &sizes, &self.gap_sizes);
        }
        gaps.truncate(self.loops);
        let widest =
            gaps.iter().zip(&self.gap_sizes).map(|(gap, size)| (gap / size).abs()).fold(0.0, f64::max);
        let raw_gap_rows = gap_rows.rows(0, self.loops).into_owned();
        let m = self.tendons + self.springs;
        let (mut excess, mut spans) = (vec![0.0; m], vec![0.0; m]);
        let [mut raw_rows, mut reach] = [Matrix::zeros(m, n), Matrix::zeros(m, n)];
        if self.tendons > 0 {
            let mut tendons = LengthTendons::new(self.tendons, n);
            self.model.linearise_length_tendons(&q, &mut tendons);
            excess[..self.tendons].copy_from_slice(&tendons.excesses);
            spans[..self.tendons].copy_from_slice(&tendons.spans);
            raw_rows.rows_mut(0, self.tendons).copy_from(&tendons.jacobian);
            reach.rows_mut(0, self.tendons).copy_from(&tendons.reach);
        }
        if let Some(springs) = &springs {
            // Amplitudes a with the energy a^2 / 2 and the forces -G a.
            let amplitudes = &springs.inverse_root * nalgebra::DVector::from_column_slice(&springs.forces);
            let rows = springs.root.tr_mul(&springs.jacobian);
            let size = self.model.facts().length;
            for i in 0..self.springs {
                excess[self.tendons + i] = -amplitudes[i];
                spans[self.tendons + i] = springs.root.column(i).norm() * size;
            }
            raw_rows.rows_mut(self.tendons, self.springs).copy_from(&rows);
            reach.rows_mut(self.tendons, self.springs).copy_from(&rows.abs());
        }
        let (mut gap_rows, mut rows) = (raw_gap_rows.clone(), raw_rows.clone());
        for rows in [&mut gap_rows, &mut rows] {
            chart::rows(&self.turns, &q, rows);
        }
        Ok(Shape {
            q,
            raw_force,
            force,
            free_force,
            contact_force,
            gaps,
            widest,
            raw_gap_rows,
            gap_rows,
            excess,
            raw_rows,
            rows,
            reach,
            spans,
            springs,
            left,
        })
    }

    /// Contact forces in the shape evaluated last; empty if nothing touches.
    fn contact_force(&mut self, q: &[f64], forces: &[f64]) -> Result<Vec<f64>, Interrupted> {
        if !self.model.facts().has_contact || !self.model.is_touched() {
            return Ok(Vec::new());
        }
        self.model.leave_contact(true);
        let mut contact_force = self.forces(q)?;
        self.model.leave_contact(false);
        contact_force.iter_mut().zip(forces).for_each(|(without, with)| *without = with - *without);
        chart::forces(&self.turns, q, &mut contact_force);
        Ok(contact_force)
    }

    /// Forces along coordinates without loops, tendons and springs.
    fn forces(&mut self, q: &[f64]) -> Result<Vec<f64>, Interrupted> {
        (self.monitor)()?;
        self.counters.forces += 1;
        let mut force = vec![0.0; self.n()];
        let none = vec![0.0; self.tendons.max(self.springs)];
        self.hold(Some((&none[..self.tendons], &none[..self.springs])));
        self.model.inverse_dynamics(q, &self.rest, &self.rest, &mut force);
        self.hold(None);
        Ok(force)
    }

    fn hold(&mut self, tensions: Option<(&[f64], &[f64])>) {
        if self.tendons > 0 {
            self.model.hold_length_tendons(tensions.map(|(tendons, _)| tendons));
        }
        if self.springs > 0 {
            self.model.hold_springs(tensions.map(|(_, springs)| springs));
        }
    }

    /// Energy of tendons and springs.
    pub(super) fn spring_energy(&self, shape: &Shape) -> f64 {
        let of_row = |row: usize| {
            let x = shape.excess[row].max(0.0);
            if self.is_rigid(row) { 0.0 } else { 0.5 * self.stiffness[row] * x * x }
        };
        (0..self.tendons).map(of_row).sum::<f64>()
            + shape.springs.as_ref().map_or(0.0, |springs| springs.energy)
    }

    /// Excesses in a shape; amplitudes of springs along the axes of another shape, nearby.
    pub(super) fn excess_beside(&self, shape: &Shape, other: &Shape) -> Vec<f64> {
        let mut excess = shape.excess.clone();
        if let (Some(springs), Some(axes)) = (&shape.springs, &other.springs) {
            for (i, excess) in excess[self.tendons..].iter_mut().enumerate() {
                *excess =
                    -(0..self.springs).map(|k| axes.inverse_root[(i, k)] * springs.forces[k]).sum::<f64>();
            }
        }
        excess
    }

    /// Tensions of tendons and springs from their lengths; zero for inextensible tendons.
    pub(super) fn tensions(&self, excess: &[f64]) -> Vec<f64> {
        let of_row = |row: usize| match (self.is_rigid(row), self.is_one_sided(row)) {
            (true, _) => 0.0,
            (false, true) => self.stiffness[row] * excess[row].max(0.0),
            (false, false) => self.stiffness[row] * excess[row],
        };
        (0..excess.len()).map(of_row).collect()
    }

    /// Size of the energies in a shape.
    pub(super) fn energies(&mut self, q: &[f64]) -> f64 {
        let energy = self.model.energy(q, &self.rest);
        let size = energy.elastic.abs() + energy.gravitational.abs() + energy.loads.abs();
        if size.is_finite() { size } else { 0.0 }
    }

    /// Work of the forces from one shape to another one (Simpson's rule), and the decrease of the energy of tendons and springs.
    pub(super) fn work(&mut self, from: &Shape, to: &Shape) -> Result<f64, Interrupted> {
        let step = chart::step_between(&self.turns, &from.q, &to.q);
        let half: Vec<f64> = step.iter().map(|x| 0.5 * x).collect();
        let mut between = from.q.clone();
        chart::retract(&self.turns, &mut between, &half);
        let mut middle = self.forces(&between)?;
        chart::forces(&self.turns, &between, &mut middle);
        let along = |force: &[f64]| dot(force, &step);
        let of_springs = self.spring_energy(to) - self.spring_energy(from);
        Ok(-(along(&from.free_force) + 4.0 * along(&middle) + along(&to.free_force)) / 6.0 - of_springs)
    }

    /// Gradient along coordinates of the Lagrangian, for multipliers of loops and tensions.
    pub(super) fn raw_gradient(&self, shape: &Shape, multipliers: &[f64], tensions: &[f64]) -> Vec<f64> {
        let mut gradient = shape.raw_force.clone();
        add_transposed(&shape.raw_gap_rows, multipliers, &mut gradient);
        add_transposed(&shape.raw_rows, tensions, &mut gradient);
        gradient
    }

    /// Second derivative of the Lagrangian along steps, without the material stiffness of elastic tendons and springs; `None` if the
    /// forces have no potential or are not finite.
    pub(super) fn hessian(
        &mut self,
        shape: &Shape,
        raw_gradient: &[f64],
        multipliers: &[f64],
        tensions: &[f64],
        sizes: &[f64],
        work: &[f64],
    ) -> Option<Matrix> {
        let n = self.n();
        let mut tangent = Matrix::zeros(n, n);
        self.counters.tangents += 1;
        let mut all = vec![0.0; self.model.facts().constraints()];
        all[..self.loops].copy_from_slice(multipliers);
        let of_springs: Vec<f64> = shape.springs.as_ref().map_or_else(Vec::new, |springs| {
            let (amplitudes, m) = (&tensions[self.tendons..], self.springs);
            (0..m)
                .map(|i| shape.left[i] - (0..m).map(|k| springs.root[(i, k)] * amplitudes[k]).sum::<f64>())
                .collect()
        });
        self.hold(Some((&tensions[..self.tendons], &of_springs)));
        self.model.set_multipliers(&all);
        self.model.weighted_tangent(&shape.q, &self.rest, &self.rest, [1.0, 0.0, 0.0], &mut tangent);
        all.fill(0.0);
        self.model.set_multipliers(&all);
        self.hold(None);
        if let Some(springs) = &shape.springs {
            tangent += springs.jacobian.tr_mul(&(&springs.rest * &springs.jacobian));
        }
        if !tangent.iter().all(|x| x.is_finite()) {
            return None;
        }
        // Fixed moments of springs have no potential; moments that turn with the shape have one.
        let has_potential = self.is_conservative
            || self.has_potential(&tangent, sizes, work)
            || (shape.springs.is_some() && {
                let mut whole = Matrix::zeros(n, n);
                self.counters.tangents += 1;
                self.model.weighted_tangent(&shape.q, &self.rest, &self.rest, [1.0, 0.0, 0.0], &mut whole);
                self.has_potential(&whole, sizes, work)
            });
        if !has_potential {
            return None;
        }
        self.is_conservative = true;
        chart::hessian(&self.turns, &shape.q, raw_gradient, &mut tangent);
        Some(crate::numerics::linalg::symmetric_part(&tangent))
    }

    /// Derivatives of the forces of loops with these multipliers: the difference of the tangents with and without them.
    pub(super) fn stiffness_of_loops(&mut self, q: &[f64], multipliers: &[f64]) -> Matrix {
        let n = self.n();
        let mut all = vec![0.0; self.model.facts().constraints()];
        let mut tangent = |of_loops: &[f64]| {
            let mut tangent = Matrix::zeros(n, n);
            self.counters.tangents += 1;
            all[..self.loops].copy_from_slice(of_loops);
            self.model.set_multipliers(&all);
            self.model.weighted_tangent(q, &self.rest, &self.rest, [1.0, 0.0, 0.0], &mut tangent);
            tangent
        };
        tangent(multipliers) - tangent(&vec![0.0; multipliers.len()])
    }

    /// Whether a tangent is symmetric, relative to the stiffness of the coupled coordinates or, without any, to the largest stiffness and
    /// the magnitudes of forces.
    fn has_potential(&self, tangent: &Matrix, sizes: &[f64], work: &[f64]) -> bool {
        let n = tangent.nrows();
        let of_sizes = |j: usize, k: usize| tangent[(j, k)] * sizes[j] * sizes[k];
        let stiffness: Vec<f64> = (0..n)
            .map(|k| match self.material[(k, k)] * sizes[k] * sizes[k] {
                stiffness if stiffness > 0.0 => stiffness,
                _ => of_sizes(k, k).abs(),
            })
            .collect();
        let all = (0..n).flat_map(|k| (0..n).map(move |j| (j, k)));
        let forces = work.iter().zip(sizes).map(|(work, size)| work * size).fold(0.0, f64::max);
        let largest = all.clone().map(|(j, k)| of_sizes(j, k).abs()).fold(forces, f64::max);
        all.filter(|(j, k)| j < k).all(|(j, k)| {
            let size = (stiffness[j] * stiffness[k]).sqrt().max(ROUNDING_STIFFNESS * largest);
            (of_sizes(j, k) - of_sizes(k, j)).abs() <= LARGEST_ASYMMETRY * size
        })
    }
}

/// `sum += rows' weights`.
pub(super) fn add_transposed(rows: &Matrix, weights: &[f64], sum: &mut [f64]) {
    for (j, sum) in sum.iter_mut().enumerate() {
        *sum += weights.iter().enumerate().map(|(i, weight)| weight * rows[(i, j)]).sum::<f64>();
    }
}

/// `rows x`.
pub(super) fn times(rows: &Matrix, x: &[f64]) -> Vec<f64> {
    (0..rows.nrows()).map(|i| (0..x.len()).map(|j| rows[(i, j)] * x[j]).sum()).collect()
}

/// Rows with their columns multiplied by `scale`.
pub(super) fn scaled(rows: &Matrix, scale: &[f64]) -> Matrix {
    Matrix::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)] * scale[j])
}
