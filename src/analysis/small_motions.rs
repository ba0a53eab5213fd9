//! Small motions about a state at rest, `M x'' + D x' + K x = 0`, and their eigenvalues.

use nalgebra::DVector;

use crate::analysis::at_rest::{AtRest, DIFFERENCE_STEP, ROUNDING};
use crate::analysis::normalised::scaled;
use crate::analysis::spring_forces::SpringForces;
use crate::analysis::weakly_active;
use crate::model::constraint::inverse_length;
use crate::model::{Reached, Static};
use crate::numerics::linalg::{Complex, Matrix, eigen_both, full_svd, symmetric_eigen, symmetric_part};
use crate::numerics::pencil;
use crate::numerics::pencil::Eigenpairs;

/// A stiffness counts as symmetric, so that its loads have a potential, if no entry differs from its
/// transpose by more than this fraction of the elastic stiffnesses it couples, and rounding. This is above the
/// quadrature error of strongly bent rods and below the effect of any relevant follower load.
const SYMMETRIC: f64 = 1e-6;

/// Damping counts as symmetric if no entry differs from its transpose by more than this fraction of the largest
/// entries of its row and column.
const SYMMETRIC_DAMPING: f64 = 1e-6;

/// Smallest real part of an eigenvalue of a growing motion, relative to its magnitude.
pub(crate) const SMALLEST_GROWTH_RATE: f64 = 1e-9;

/// Singular values of redundant constraints are below this fraction of the largest one.
const DEPENDENT: f64 = 1e-8;

/// Lowest eigenvalue, relative to the material stiffness, from which the residual of Newton's method cannot change the sign of any.
const FAR_FROM_SINGULAR: f64 = 1e-3;

/// Safety factor of first-order bounds of eigenvalues, well above two: a double eigenvalue moves by twice its first-order bound.
const SAFETY_OF_BOUNDS: f64 = 4.0;

/// Smallest velocity component of a drift in an eigenvector of norm one.
const SMALLEST_DRIFT: f64 = 1e-8;

/// Mass, damping and stiffness in normalised coordinates x, `q / s = W x`, with the typical sizes s of the coordinates.
#[derive(Clone)]
pub(crate) struct SmallMotions {
    pub(crate) mass: Matrix,
    pub(crate) damping: Matrix,
    pub(crate) stiffness: Matrix,
    /// Error bound of each entry of the stiffness.
    pub(crate) error: Matrix,
    /// Change of the stiffness from this shape to the exact equilibrium, estimated by a Newton step, plus the quadrature error of the
    /// tangent. Zero if no eigenvalue is below [`FAR_FROM_SINGULAR`].
    pub(crate) change: Matrix,
    /// W.
    pub(crate) basis: Matrix,
    pub(crate) sizes: Vec<f64>,
}

/// Small motions in modal coordinates: mass-normalised undamped modes, slowest first.
pub(crate) struct Modal {
    /// Eigenvalues of the symmetric part of the stiffness; exactly zero if they are below their error bound.
    pub(crate) squared_frequencies: Vec<f64>,
    /// Mode shapes in normalised coordinates, as columns.
    pub(crate) shapes: Matrix,
    /// Diagonal matrix of the squared frequencies, plus the skew-symmetric part of the stiffness.
    stiffness: Matrix,
    /// Modal damping, without entries at the level of rounding.
    pub(crate) damping: Matrix,
    error: Matrix,
}

/// A motion `x exp(s t)`.
pub(crate) struct Motion {
    /// Exactly zero if it is below its error bound.
    pub(crate) rate: Complex,
    /// Error bound of the rate.
    pub(crate) bound: f64,
    /// x in modal coordinates.
    pub(crate) shape: Vec<Complex>,
    /// Weights of the modal velocities and accelerations of a state: their weighted sum over the rate is the amplitude of this motion.
    pub(crate) excitation: [Vec<Complex>; 2],
}

impl Motion {
    pub(crate) fn is_growing(&self) -> bool {
        self.rate.re > (SMALLEST_GROWTH_RATE * self.rate.norm()).max(SAFETY_OF_BOUNDS * self.bound)
    }
}

impl SmallMotions {
    pub(crate) fn n(&self) -> usize {
        self.mass.nrows()
    }

    pub(crate) fn is_finite(&self) -> bool {
        let Self { mass, damping, stiffness, error, change, .. } = self;
        [mass, damping, stiffness, error, change].into_iter().all(|a| a.iter().all(|x| x.is_finite()))
    }

    /// Projection onto motions that satisfy constraints.
    fn within(&self, Constraints { free, multipliers }: &Constraints) -> Self {
        if multipliers.is_empty() {
            return self.clone();
        }
        let within = |a: &Matrix| free.tr_mul(&(a * free));
        Self {
            mass: within(&self.mass),
            damping: within(&self.damping),
            stiffness: within(&self.stiffness),
            error: free.abs().tr_mul(&(&self.error * free.abs())),
            change: within(&self.change),
            basis: &self.basis * free,
            sizes: self.sizes.clone(),
        }
    }

    /// Eigenvalues for this mass with error bounds. The change of the stiffness counts twice, so that bounds hold on both sides of the
    /// equilibrium.
    pub(crate) fn pairs(&self, mass: &Matrix) -> Option<Eigenpairs> {
        Some(Eigenpairs::new(&self.stiffness, mass, &self.error)?.with_change(&(&self.change * 2.0)))
    }

    /// Error of a stiffness that should be symmetric: half of the difference of two entries, if it exceeds the quadrature error of bent
    /// rods.
    fn asymmetry(&self) -> Matrix {
        let k = &self.stiffness;
        Matrix::from_fn(self.n(), self.n(), |i, j| {
            let (a, b) = (k[(i, j)], k[(j, i)]);
            let apart = (a - b).abs();
            if apart > SYMMETRIC * a.abs().max(b.abs()) { 0.5 * apart } else { 0.0 }
        })
    }

    /// Whether all eigenvalues of the stiffness exceed [`FAR_FROM_SINGULAR`] and their error bounds.
    fn is_far_from_singular(&self) -> bool {
        let firm = Matrix::identity(self.n(), self.n()) * FAR_FROM_SINGULAR;
        pencil::is_positive(&self.stiffness, &(&self.error + firm))
    }

    /// Newton step for residual forces by eigenvalues and eigenvectors of the stiffness, without eigenvectors whose eigenvalue may be
    /// zero.
    fn newton_step(&self, values: &[f64], shapes: &Matrix, forces: &DVector<f64>) -> DVector<f64> {
        let mut step = DVector::zeros(self.n());
        for (value, shape) in values.iter().zip(shapes.column_iter()) {
            let sizes = shape.abs();
            let error = sizes.dot(&(&self.error * &sizes)) + 2.0 * shape.dot(&(&self.change * shape)).abs();
            if value.abs() > error {
                step.axpy(-shape.dot(forces) / value, &shape, 1.0);
            }
        }
        step
    }

    /// Whether the stiffness is symmetric, so that its forces have a potential.
    pub(crate) fn has_potential(&self) -> bool {
        let Self { stiffness: k, error, .. } = self;
        (0..self.n()).all(|j| {
            (0..j).all(|i| (k[(i, j)] - k[(j, i)]).abs() <= SYMMETRIC + error[(i, j)] + error[(j, i)])
        })
    }

    /// Whether the damping matrix is symmetric, without gyroscopic terms. Compares each entry with the largest ones of
    /// its row and column.
    pub(crate) fn is_damping_symmetric(&self) -> bool {
        let (n, d) = (self.n(), &self.damping);
        let size = |i: usize| d.row(i).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let sizes: Vec<f64> = (0..n).map(size).collect();
        (0..n).all(|j| {
            (0..j).all(|i| (d[(i, j)] - d[(j, i)]).abs() <= SYMMETRIC_DAMPING * (sizes[i] * sizes[j]).sqrt())
        })
    }

    /// In modal coordinates. `None` if the mass is not positive definite or a number is not finite.
    pub(crate) fn modal(&self) -> Option<Modal> {
        let pairs = self.pairs(&self.mass)?;
        let n = self.n();
        let squared_frequencies: Vec<f64> =
            (0..n).map(|k| if pairs.is_neutral(k) { 0.0 } else { pairs.values[k] }).collect();
        let x = pairs.shapes;
        let modal = |a: &Matrix| x.tr_mul(&(a * &x));
        let mut stiffness = Matrix::from_diagonal(&squared_frequencies.clone().into());
        if !self.has_potential() {
            stiffness += modal(&((&self.stiffness - self.stiffness.transpose()) * 0.5));
        }
        let magnitudes = |a: &Matrix| x.abs().tr_mul(&(a * x.abs()));
        let rounding = magnitudes(&self.damping.abs()) * (ROUNDING * n as f64 * f64::EPSILON);
        let damping =
            modal(&self.damping).zip_map(&rounding, |d, least| if d.abs() <= least { 0.0 } else { d });
        let error = magnitudes(&self.error) + modal(&self.change).abs();
        Some(Modal { squared_frequencies, stiffness, damping, error, shapes: x })
    }
}

/// Constraints in normalised coordinates.
struct Constraints {
    /// Orthonormal basis of the null space of the constraints.
    free: Matrix,
    /// Maps forces to the multipliers that balance their part outside the null space.
    multipliers: Matrix,
}

impl Constraints {
    /// By singular values. `rows` are the derivatives of the constraints.
    fn new(mut rows: Matrix) -> Option<Self> {
        let (m, n) = rows.shape();
        if m == 0 {
            return Some(Self { free: Matrix::identity(n, n), multipliers: rows });
        }
        let longest = rows.row_iter().map(|row| row.norm()).fold(0.0, f64::max);
        let inverses: Vec<f64> = rows.row_iter().map(|row| inverse_length(row.norm(), longest)).collect();
        for (mut row, inverse) in rows.row_iter_mut().zip(&inverses) {
            row *= *inverse;
        }
        let (left, values, right) = full_svd(&rows)?;
        let largest = values.first().copied().unwrap_or(0.0);
        let rank = values.iter().filter(|&&value| value > DEPENDENT * largest).count();
        let multipliers = Matrix::from_fn(m, n, |i, j| {
            inverses[i] * (0..rank).map(|k| left[(i, k)] / values[k] * right[(j, k)]).sum::<f64>()
        });
        Some(Self { free: right.columns(rank, n - rank).into_owned(), multipliers })
    }
}

impl Modal {
    pub(crate) fn n(&self) -> usize {
        self.squared_frequencies.len()
    }

    /// Whether a motion may grow: negative stiffness, loads without a potential, or negative damping.
    pub(crate) fn may_grow(&self) -> bool {
        let has_potential =
            (0..self.n()).all(|j| (0..self.n()).all(|i| i == j || self.stiffness[(i, j)] == 0.0));
        !has_potential
            || self.squared_frequencies.iter().any(|squared| *squared < 0.0)
            || (0..self.n()).any(|i| self.damping[(i, i)] < 0.0)
    }

    /// Derivative of the accelerations in a state with these velocities and accelerations.
    pub(crate) fn change_of_accelerations(&self, [v, a]: [&DVector<f64>; 2]) -> DVector<f64> {
        -(&self.damping * a + &self.stiffness * v)
    }

    /// Damped motions from the eigenvalues of a state matrix. Its rows are sorted by their rates, fastest first: from such a graded
    /// matrix the QR algorithm finds slow eigenvalues as accurately as fast ones. Each neutral mode without coupling is one motion of rate
    /// zero; the steady drift along it is left out.
    pub(crate) fn motions(&self) -> Option<Vec<Motion>> {
        let n = self.n();
        let (k, d) = (&self.stiffness, &self.damping);
        let is_idle = |i: usize| k.column(i).iter().all(|x| *x == 0.0);
        // Displacements are multiplied by frequencies to have the units of velocities.
        let slowest = self
            .squared_frequencies
            .iter()
            .map(|l| l.abs().sqrt())
            .filter(|w| *w > 0.0)
            .fold(f64::INFINITY, f64::min);
        let slowest = if slowest.is_finite() { slowest } else { 1.0 };
        let frequency = |i: usize| {
            if self.squared_frequencies[i] == 0.0 {
                slowest
            } else {
                self.squared_frequencies[i].abs().sqrt()
            }
        };
        let mut states: Vec<(f64, usize, bool)> = Vec::with_capacity(2 * n);
        for i in 0..n {
            let fast = frequency(i).max(d[(i, i)].abs());
            states.push((fast, i, true));
            if !is_idle(i) {
                states.push((frequency(i) * (frequency(i) / fast), i, false));
            }
        }
        states.sort_by(|a, b| b.0.total_cmp(&a.0));
        let state = Matrix::from_fn(states.len(), states.len(), |row, column| {
            let ((_, i, is_velocity), (_, j, of_velocity)) = (states[row], states[column]);
            match (is_velocity, of_velocity) {
                (false, false) => 0.0,
                (false, true) => {
                    if i == j {
                        frequency(i)
                    } else {
                        0.0
                    }
                }
                (true, false) => -k[(i, j)] / frequency(j),
                (true, true) => -d[(i, j)],
            }
        });
        let unit = |i: usize| (0..n).map(|j| Complex::from(if i == j { 1.0 } else { 0.0 })).collect();
        let nothing = || [(); 2].map(|()| vec![Complex::from(0.0); n]);
        let still = |bound: f64, shape: Vec<Complex>| Motion {
            rate: Complex::from(0.0),
            bound,
            shape,
            excitation: nothing(),
        };
        let at_rest = (0..n).filter(|&i| is_idle(i));
        let mut motions: Vec<Motion> = at_rest.map(|i| still(0.0, unit(i))).collect();
        for (rate, right, left) in eigen_both(&state)? {
            let [mut velocity, mut shape] = nothing();
            let [mut of_velocities, mut force] = nothing();
            for (m, &(_, i, is_velocity)) in states.iter().enumerate() {
                if is_velocity {
                    (velocity[i], force[i]) = (right[m], left[m]);
                } else {
                    shape[i] = right[m] / frequency(i);
                    of_velocities[i] = left[m] * frequency(i);
                }
            }
            let drift = (0..n).filter(|&i| is_idle(i)).map(|i| velocity[i].norm()).fold(0.0, f64::max);
            if drift > 0.0 && rate.norm() > 0.0 {
                (0..n).filter(|&i| is_idle(i)).for_each(|i| shape[i] = velocity[i] / rate);
            }
            let bound = self.along(&force, &shape);
            if rate.norm() > SAFETY_OF_BOUNDS * bound {
                motions.push(Motion { rate, bound, shape, excitation: [of_velocities, force] });
            } else if drift <= SMALLEST_DRIFT {
                motions.push(still(bound, shape));
            }
        }
        Some(motions)
    }

    /// Eigenvalues l of the undamped motion `x'' + K x = 0`, `x = exp(i sqrt(l) t)`; zero if they are below their error bound.
    pub(crate) fn undamped(&self) -> Option<Vec<Complex>> {
        // Fastest first, as in `motions`.
        let n = self.n();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| {
            self.squared_frequencies[b].abs().total_cmp(&self.squared_frequencies[a].abs())
        });
        let graded = Matrix::from_fn(n, n, |i, j| self.stiffness[(order[i], order[j])]);
        let values = eigen_both(&graded)?.into_iter().map(|(value, right, left)| {
            let [mut shape, mut force] = [(); 2].map(|()| vec![Complex::from(0.0); n]);
            for (m, &i) in order.iter().enumerate() {
                (shape[i], force[i]) = (right[m], left[m]);
            }
            if value.norm() <= SAFETY_OF_BOUNDS * self.along(&force, &shape) {
                Complex::from(0.0)
            } else {
                value
            }
        });
        Some(values.collect())
    }

    /// `|y|^T E |x|`.
    fn along(&self, y: &[Complex], x: &[Complex]) -> f64 {
        let x = Matrix::from_fn(x.len(), 1, |i, _| x[i].norm());
        (&self.error * x).iter().zip(y).map(|(error, y)| error * y.norm()).sum()
    }
}

/// Small motions about rest at `q` under this fraction of the loads, with the multipliers of the constraints there. `None` if a number
/// is not finite.
pub(crate) fn small_motions(
    model: &mut dyn Static,
    q: &[f64],
    sizes: &[f64],
    load_factor: f64,
    multipliers: &[f64],
) -> Option<SmallMotions> {
    let (idle, multipliers) = weakly_active::decide(model, q, sizes, load_factor, multipliers);
    let motions = decided_motions(model, q, sizes, load_factor, &multipliers, &idle);
    if !idle.is_empty() {
        model.decide(&[]);
    }
    motions
}

/// The same after weakly active stops and contacts have been disabled.
fn decided_motions(
    model: &mut dyn Static,
    q: &[f64],
    sizes: &[f64],
    load_factor: f64,
    multipliers: &[f64],
    idle: &[Reached],
) -> Option<SmallMotions> {
    let n = q.len();
    let (spring_forces, ties) = SpringForces::with_ties(model, q, sizes, load_factor, multipliers)?;
    let SpringForces { material, normalised, forces } = spring_forces;
    let springs = ties.all.as_ref();
    let mut at_rest = AtRest { model, q, sizes, load_factor, multipliers, ties: &ties, tie_forces: &forces };
    let parts = at_rest.stiffness(&material);
    let [residual, work] = at_rest.forces();
    let residual = at_rest.missing(&residual, &work, &parts.magnitudes);
    let imbalance = at_rest.imbalance(&residual, &work);
    let stiffness = normalised.tangent(&parts.total, springs);
    let mut error = normalised.magnitudes(&parts.magnitudes, springs) * (ROUNDING * n as f64 * f64::EPSILON);
    error += normalised.magnitudes(&imbalance, None);
    let mut rows = at_rest.gap_jacobian();
    error += normalised.magnitudes(&at_rest.of_gaps(&rows), None);
    if ties.has_taut() {
        // Rounding of the basis W, in which all stiffnesses are of size one.
        error += Matrix::identity(n, n) * (ROUNDING * n as f64 * f64::EPSILON);
    }
    let just = ties.reached();
    if !just.is_empty() {
        at_rest.model.decide(&[idle, &just].concat());
    }
    let damping = normalised.matrix(&at_rest.tangent([0.0, 1.0, 0.0]));
    if !just.is_empty() {
        at_rest.model.decide(idle);
    }
    let mut mass = Matrix::zeros(n, n);
    at_rest.model.mass_matrix(q, &mut mass);
    let mass = normalised.matrix(&scaled(mass, sizes));
    let (basis, change) = (normalised.basis(), Matrix::zeros(n, n));
    let mut motions = SmallMotions { mass, damping, stiffness, error, change, basis, sizes: sizes.to_vec() };
    let has_potential = motions.has_potential();
    if has_potential {
        motions.error += motions.asymmetry();
    }
    for (mut column, size) in rows.column_iter_mut().zip(sizes) {
        column *= *size;
    }
    let constraints = Constraints::new(rows * &motions.basis)?;
    // The signs of eigenvalues far from zero are known without the Newton step below.
    let mut motions_on_constraints = motions.within(&constraints);
    if !has_potential || !motions_on_constraints.is_finite() || motions_on_constraints.is_far_from_singular()
    {
        return Some(motions_on_constraints);
    }
    let (values, shapes) = symmetric_eigen(&symmetric_part(&motions_on_constraints.stiffness))?;
    if at_rest.model.facts().is_discretised {
        add_mismatch(&mut motions_on_constraints, &mut at_rest, [&values, &work], &shapes);
    }
    // The Newton step to the exact equilibrium: change of the coordinates, of the multipliers and of the spring forces.
    let residual = DVector::from(normalised.residual(&residual, springs, &forces));
    let step = &constraints.free
        * motions_on_constraints.newton_step(&values, &shapes, &constraints.free.tr_mul(&residual));
    let more = &constraints.multipliers * (&residual + &motions.stiffness * &step);
    let moved = normalised.coordinates(step.as_slice());
    let q: Vec<f64> = q.iter().zip(sizes.iter().zip(moved)).map(|(q, (size, x))| q + size * x).collect();
    let multipliers: Vec<f64> =
        multipliers.iter().zip(more.iter()).map(|(multiplier, more)| multiplier - more).collect();
    // Forces of springs follow from their displacements, not from the fixed forces.
    let forces: Vec<f64> = springs.map_or_else(Vec::new, |springs| {
        let changes = normalised.change_of_forces(springs, step.as_slice());
        springs.forces.iter().zip(changes).map(|(force, change)| force + change).collect()
    });
    let here = at_rest.model.reached(at_rest.q);
    let mut beside = AtRest { q: &q, multipliers: &multipliers, tie_forces: &forces, ..at_rest };
    let there = beside.stiffness_beyond(&material, idle, &here);
    let change = normalised.matrix(&(there - parts.total));
    motions_on_constraints.change += constraints.free.tr_mul(&(change * &constraints.free));
    Some(motions_on_constraints)
}

/// Adds the quadrature error of the stiffness, which numerical derivatives of the forces show, and the rounding of these derivatives, for
/// eigenvectors whose eigenvalues are small.
fn add_mismatch(
    motions_on_constraints: &mut SmallMotions,
    at_rest: &mut AtRest<'_>,
    [values, work]: [&[f64]; 2],
    shapes: &Matrix,
) {
    let doubtful: Vec<usize> =
        (0..motions_on_constraints.n()).filter(|&k| values[k].abs() < SYMMETRIC).collect();
    let shapes = shapes.select_columns(&doubtful);
    let directions = &motions_on_constraints.basis * &shapes;
    let mismatch = directions.tr_mul(&at_rest.mismatch(&directions));
    motions_on_constraints.change = &shapes * symmetric_part(&mismatch) * shapes.transpose();
    for (shape, direction) in shapes.column_iter().zip(directions.column_iter()) {
        let work: f64 = direction.iter().zip(work).map(|(x, work)| x.abs() * work).sum();
        let rounding = ROUNDING * f64::EPSILON * direction.amax() / DIFFERENCE_STEP * work;
        motions_on_constraints.error += shape.abs() * shape.abs().transpose() * rounding;
    }
}
