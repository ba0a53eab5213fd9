//! Small motions about a state at rest, `M x'' + D x' + K x = 0`, and their eigenvalues.

use nalgebra::DVector;

use crate::analysis::at_rest::{APART, AtRest, ROUNDING};
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

/// Eigenvalues whose real part is smaller than this fraction of their magnitude do not count as growing.
pub(crate) const GROWING: f64 = 1e-9;

/// Constraints with a singular value below this fraction of the largest one count as redundant.
const DEPENDENT: f64 = 1e-8;

/// If all directions are stiffer than this fraction of the material, the residual of Newton's method cannot change the verdict.
const FIRM: f64 = 1e-3;

/// Safety factor of first-order bounds: a double eigenvalue moves by the root of a perturbation, twice what these say.
const DOUBLE: f64 = 4.0;

/// Smallest velocity part of an eigenvector of norm one that counts as a drift.
const DRIFT: f64 = 1e-8;

/// Matrices of small motions, in normalised coordinates x of the shape: `q / s = W x` with the typical sizes s.
#[derive(Clone)]
pub(crate) struct SmallMotions {
    pub(crate) mass: Matrix,
    pub(crate) damping: Matrix,
    pub(crate) stiffness: Matrix,
    /// Largest error of each entry of the stiffness.
    pub(crate) error: Matrix,
    /// Its change up to the exact equilibrium, by the residual of Newton's method, and its difference from the derivative of the
    /// forces, by quadrature. Zero if all directions are [`FIRM`].
    pub(crate) change: Matrix,
    /// W.
    pub(crate) basis: Matrix,
    pub(crate) sizes: Vec<f64>,
}

/// The same in mass-normalised shapes of the undamped motion, slowest first, whose mass is one.
pub(crate) struct Modal {
    /// Eigenvalues of the symmetric part of the stiffness; exactly zero where its error could explain them.
    pub(crate) squares: Vec<f64>,
    /// Shapes as columns, in normalised coordinates.
    pub(crate) shapes: Matrix,
    /// The squares on the diagonal, and the part of the stiffness without a potential.
    stiffness: Matrix,
    /// Entries that are rounding are zero.
    pub(crate) damping: Matrix,
    error: Matrix,
}

/// A motion `x exp(s t)`.
pub(crate) struct Motion {
    /// Exactly zero where errors of the stiffness could explain it.
    pub(crate) rate: Complex,
    /// Bound of the change of s by these errors.
    pub(crate) bound: f64,
    /// x, in the shapes of the undamped motion.
    pub(crate) shape: Vec<Complex>,
    /// Weights of the velocities and accelerations in these shapes, whose sum over the rate is the amplitude of this motion in a state.
    pub(crate) excitation: [Vec<Complex>; 2],
}

impl Motion {
    pub(crate) fn is_growing(&self) -> bool {
        self.rate.re > (GROWING * self.rate.norm()).max(DOUBLE * self.bound)
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

    /// Small motions that satisfy constraints, by projection.
    fn within(&self, Held { free, multipliers }: &Held) -> Self {
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

    /// Eigenvalues with this mass, and bounds of their errors: of stiffnesses on both sides of the equilibrium, as far beyond it as the
    /// shape is before it.
    pub(crate) fn pairs(&self, mass: &Matrix) -> Option<Eigenpairs> {
        Some(Eigenpairs::new(&self.stiffness, mass, &self.error)?.with_change(&(&self.change * 2.0)))
    }

    /// Rounding of entries that should be symmetric: half of their differences, if these exceed the quadrature error of bent rods. For
    /// directions with almost no mass even a small stiffness matters.
    fn asymmetry(&self) -> Matrix {
        let k = &self.stiffness;
        Matrix::from_fn(self.n(), self.n(), |i, j| {
            let (a, b) = (k[(i, j)], k[(j, i)]);
            let apart = (a - b).abs();
            if apart > SYMMETRIC * a.abs().max(b.abs()) { 0.5 * apart } else { 0.0 }
        })
    }

    /// Whether the stiffness is so far from zero in all directions that the residual of Newton's method does not matter.
    fn is_far_from_singular(&self) -> bool {
        let firm = Matrix::identity(self.n(), self.n()) * FIRM;
        pencil::is_positive(&self.stiffness, &(&self.error + firm))
    }

    /// Newton's step against forces, by eigenvalues and eigenvectors of the stiffness, without the directions whose stiffness may be
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

    /// Whether the stiffness has a potential.
    pub(crate) fn has_potential(&self) -> bool {
        let Self { stiffness: k, error, .. } = self;
        (0..self.n()).all(|j| {
            (0..j).all(|i| (k[(i, j)] - k[(j, i)]).abs() <= SYMMETRIC + error[(i, j)] + error[(j, i)])
        })
    }

    /// Whether damping forces are friction only, without gyroscopic ones. Compares each entry with the largest ones of
    /// its row and column.
    pub(crate) fn is_damping_symmetric(&self) -> bool {
        let (n, d) = (self.n(), &self.damping);
        let size = |i: usize| d.row(i).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let sizes: Vec<f64> = (0..n).map(size).collect();
        (0..n).all(|j| {
            (0..j).all(|i| (d[(i, j)] - d[(j, i)]).abs() <= SYMMETRIC_DAMPING * (sizes[i] * sizes[j]).sqrt())
        })
    }

    /// In shapes of the undamped motion. `None` if the mass is not positive definite or a number is not finite.
    pub(crate) fn modal(&self) -> Option<Modal> {
        let pairs = self.pairs(&self.mass)?;
        let n = self.n();
        let squares: Vec<f64> =
            (0..n).map(|k| if pairs.is_neutral(k) { 0.0 } else { pairs.values[k] }).collect();
        let x = pairs.shapes;
        let modal = |a: &Matrix| x.tr_mul(&(a * &x));
        let mut stiffness = Matrix::from_diagonal(&squares.clone().into());
        if !self.has_potential() {
            stiffness += modal(&((&self.stiffness - self.stiffness.transpose()) * 0.5));
        }
        let magnitudes = |a: &Matrix| x.abs().tr_mul(&(a * x.abs()));
        let rounding = magnitudes(&self.damping.abs()) * (ROUNDING * n as f64 * f64::EPSILON);
        let damping =
            modal(&self.damping).zip_map(&rounding, |d, least| if d.abs() <= least { 0.0 } else { d });
        let error = magnitudes(&self.error) + modal(&self.change).abs();
        Some(Modal { squares, stiffness, damping, error, shapes: x })
    }
}

/// Constraints in normalised coordinates: free motions and multipliers.
struct Held {
    /// An orthonormal basis of the motions that satisfy them.
    free: Matrix,
    /// Multipliers that balance a unit of each force perpendicular to these motions.
    multipliers: Matrix,
}

impl Held {
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
        self.squares.len()
    }

    /// Whether some motion may grow: a direction without stiffness, loads without a potential, or forces along velocities.
    pub(crate) fn may_grow(&self) -> bool {
        let has_potential =
            (0..self.n()).all(|j| (0..self.n()).all(|i| i == j || self.stiffness[(i, j)] == 0.0));
        !has_potential
            || self.squares.iter().any(|square| *square < 0.0)
            || (0..self.n()).any(|i| self.damping[(i, i)] < 0.0)
    }

    /// Derivative of the accelerations in a state with these velocities and accelerations.
    pub(crate) fn change_of_accelerations(&self, [v, a]: [&DVector<f64>; 2]) -> DVector<f64> {
        -(&self.damping * a + &self.stiffness * v)
    }

    /// Motions with damping and all other forces. Eigenvalues are those of a state matrix whose rows are in the order of
    /// their rates, fastest first: from such a graded matrix QR finds slow ones as accurately as fast ones. Neutral shapes
    /// that nothing accelerates are at rest; each of them is one motion of rate zero, without the steady drift along it.
    pub(crate) fn motions(&self) -> Option<Vec<Motion>> {
        let n = self.n();
        let (k, d) = (&self.stiffness, &self.damping);
        let is_idle = |i: usize| k.column(i).iter().all(|x| *x == 0.0);
        // Displacements are multiplied by frequencies to have the units of velocities.
        let slowest =
            self.squares.iter().map(|l| l.abs().sqrt()).filter(|w| *w > 0.0).fold(f64::INFINITY, f64::min);
        let slowest = if slowest.is_finite() { slowest } else { 1.0 };
        let frequency =
            |i: usize| if self.squares[i] == 0.0 { slowest } else { self.squares[i].abs().sqrt() };
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
            if rate.norm() > DOUBLE * bound {
                motions.push(Motion { rate, bound, shape, excitation: [of_velocities, force] });
            } else if drift <= DRIFT {
                motions.push(still(bound, shape));
            }
        }
        Some(motions)
    }

    /// Eigenvalues l of the motion `x'' + K x = 0` without damping, `x = exp(i sqrt(l) t)`; those that errors of the stiffness
    /// could explain are zero.
    pub(crate) fn undamped(&self) -> Option<Vec<Complex>> {
        // Fastest first, as in `motions`.
        let n = self.n();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| self.squares[b].abs().total_cmp(&self.squares[a].abs()));
        let graded = Matrix::from_fn(n, n, |i, j| self.stiffness[(order[i], order[j])]);
        let values = eigen_both(&graded)?.into_iter().map(|(value, right, left)| {
            let [mut shape, mut force] = [(); 2].map(|()| vec![Complex::from(0.0); n]);
            for (m, &i) in order.iter().enumerate() {
                (shape[i], force[i]) = (right[m], left[m]);
            }
            if value.norm() <= DOUBLE * self.along(&force, &shape) { Complex::from(0.0) } else { value }
        });
        Some(values.collect())
    }

    /// `|y|^T E |x|`.
    fn along(&self, y: &[Complex], x: &[Complex]) -> f64 {
        let x = Matrix::from_fn(x.len(), 1, |i, _| x[i].norm());
        (&self.error * x).iter().zip(y).map(|(error, y)| error * y.norm()).sum()
    }
}

/// Small motions of a model about rest at `q` under this fraction of its loads, which satisfy its constraints with these multipliers.
/// `None` if a number is not finite.
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
    let (springs, ties) = SpringForces::with_ties(model, q, sizes, load_factor, multipliers)?;
    let SpringForces { material, normalised, forces } = springs;
    let own = ties.all.as_ref();
    let mut at_rest = AtRest { model, q, sizes, load_factor, multipliers, ties: &ties, held: &forces };
    let parts = at_rest.stiffness(&material);
    let [residual, work] = at_rest.forces();
    let residual = at_rest.missing(&residual, &work, &parts.magnitudes);
    let imbalance = at_rest.imbalance(&residual, &work);
    let stiffness = normalised.tangent(&parts.total, own);
    let mut error = normalised.magnitudes(&parts.magnitudes, own) * (ROUNDING * n as f64 * f64::EPSILON);
    error += normalised.magnitudes(&imbalance, None);
    let mut rows = at_rest.gap_jacobian();
    error += normalised.magnitudes(&at_rest.of_gaps(&rows), None);
    if ties.has_taut() {
        // Rounding of the basis, in coordinates in which all stiffnesses are of size one.
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
    let held = Held::new(rows * &motions.basis)?;
    // Stiffnesses that are far from zero keep their signs.
    let mut kept = motions.within(&held);
    if !has_potential || !kept.is_finite() || kept.is_far_from_singular() {
        return Some(kept);
    }
    let (values, shapes) = symmetric_eigen(&symmetric_part(&kept.stiffness))?;
    if at_rest.model.facts().is_discretised {
        add_mismatch(&mut kept, &mut at_rest, [&values, &work], &shapes);
    }
    // The residual of Newton's method, in coordinates and in the forces of constraints and springs.
    let residual = DVector::from(normalised.residual(&residual, own, &forces));
    let step = &held.free * kept.newton_step(&values, &shapes, &held.free.tr_mul(&residual));
    let more = &held.multipliers * (&residual + &motions.stiffness * &step);
    let moved = normalised.coordinates(step.as_slice());
    let q: Vec<f64> = q.iter().zip(sizes.iter().zip(moved)).map(|(q, (size, x))| q + size * x).collect();
    let multipliers: Vec<f64> = multipliers.iter().zip(more.iter()).map(|(own, more)| own - more).collect();
    // Forces of springs follow from their displacements, not from the held forces.
    let forces: Vec<f64> = own.map_or_else(Vec::new, |own| {
        let changes = normalised.change_of_forces(own, step.as_slice());
        own.forces.iter().zip(changes).map(|(force, change)| force + change).collect()
    });
    let here = at_rest.model.reached(at_rest.q);
    let mut beside = AtRest { q: &q, multipliers: &multipliers, held: &forces, ..at_rest };
    let there = beside.stiffness_beyond(&material, idle, &here);
    let change = normalised.matrix(&(there - parts.total));
    kept.change += held.free.tr_mul(&(change * &held.free));
    Some(kept)
}

/// Adds the error of quadrature to small motions whose stiffness has these eigenvalues and shapes, and the rounding of the numerical
/// derivatives by which it is computed.
fn add_mismatch(
    kept: &mut SmallMotions,
    at_rest: &mut AtRest<'_>,
    [values, work]: [&[f64]; 2],
    shapes: &Matrix,
) {
    let doubtful: Vec<usize> = (0..kept.n()).filter(|&k| values[k].abs() < SYMMETRIC).collect();
    let shapes = shapes.select_columns(&doubtful);
    let directions = &kept.basis * &shapes;
    let mismatch = directions.tr_mul(&at_rest.mismatch(&directions));
    kept.change = &shapes * symmetric_part(&mismatch) * shapes.transpose();
    for (shape, direction) in shapes.column_iter().zip(directions.column_iter()) {
        let work: f64 = direction.iter().zip(work).map(|(x, work)| x.abs() * work).sum();
        let rounding = ROUNDING * f64::EPSILON * direction.amax() / APART * work;
        kept.error += shape.abs() * shape.abs().transpose() * rounding;
    }
}
