//! Small motions about a state at rest, `M x'' + D x' + K x = 0`, and their eigenvalues.

use nalgebra::DVector;

use crate::constraint::inverse_length;
use crate::linalg::{Complex, Matrix, eigen_both, full_svd, norm, symmetric_eigen, symmetric_part};
use crate::model::Model;
use crate::natural::{self, DISPLACEMENT_ROUNDING, Natural, scaled};
use crate::pencil::{self, Eigenpairs};

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

/// Rounding of a stiffness over n coordinates, in units of n eps times the sum of the magnitudes of its terms: each is itself a sum of
/// products of rotations, and a change of charts multiplies it once more.
const ROUNDING: f64 = 16.0;

/// Forces that are out of balance are part of the error of a stiffness, up to this fraction of all forces: ten times the tolerance of
/// equilibria. Beyond that, the shape is none.
const OUT_OF_BALANCE: f64 = 1e-9;

/// No force can do work along a coordinate along which the forces of the same part could do less than this part of what they can do
/// along others: what is missing there is rounding.
const NOTHING: f64 = 1e-5;

/// No shape is so near to no stiffness, where that of the material is one, that what is left of Newton's method could reach it if all
/// other directions are stiffer than this.
const FIRM: f64 = 1e-3;

/// A double eigenvalue moves by the root of a perturbation, half of which first-order bounds tell: this factor is safe.
const DOUBLE: f64 = 4.0;

/// Eigenvectors of norm one that belong to a drift have a velocity of this size at least.
const DRIFT: f64 = 1e-8;

/// Matrices of small motions, in natural coordinates x of the shape: `q / s = W x` with the typical sizes s.
pub(crate) struct SmallMotions {
    pub(crate) mass: Matrix,
    pub(crate) damping: Matrix,
    pub(crate) stiffness: Matrix,
    /// Largest error of each entry of the stiffness.
    pub(crate) error: Matrix,
    /// How it changes with what is left of Newton's method to the equilibrium.
    pub(crate) change: Matrix,
    /// W.
    pub(crate) basis: Matrix,
    pub(crate) sizes: Vec<f64>,
}

/// The same in mass-normalised shapes of the undamped motion, slowest first, whose mass is one.
pub(crate) struct Modal {
    /// Eigenvalues of the symmetric part of the stiffness; exactly zero where its error could explain them.
    pub(crate) squares: Vec<f64>,
    /// Shapes as columns, in natural coordinates.
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
    /// What these could change s by.
    pub(crate) bound: f64,
    /// x, in the shapes of the undamped motion.
    pub(crate) shape: Vec<Complex>,
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
    fn within(&self, Held { free, .. }: &Held) -> Self {
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

    /// Eigenvalues with this mass, and bounds of their errors: also as far beyond the equilibrium as the shape is before it.
    pub(crate) fn pairs(&self, mass: &Matrix) -> Option<Eigenpairs> {
        Some(Eigenpairs::new(&self.stiffness, mass, &self.error)?.with_change(&(&self.change * 2.0)))
    }

    /// What rounding makes of entries that should be equal: half of their differences, where these are beyond the quadrature error
    /// of bent rods. Next to nothing in the stiffness of a direction with next to no mass is much.
    fn asymmetry(&self) -> Matrix {
        let k = &self.stiffness;
        Matrix::from_fn(self.n(), self.n(), |i, j| {
            let (a, b) = (k[(i, j)], k[(j, i)]);
            let apart = (a - b).abs();
            if apart > SYMMETRIC * a.abs().max(b.abs()) { 0.5 * apart } else { 0.0 }
        })
    }

    /// Whether the stiffness is so far from zero in all directions that what is left of Newton's method decides nothing.
    fn is_firm(&self) -> bool {
        let firm = Matrix::identity(self.n(), self.n()) * FIRM;
        pencil::is_positive(&self.stiffness, &(&self.error + firm))
    }

    /// Newton's step against forces, without the directions whose stiffness may be zero.
    fn newton_step(&self, forces: &DVector<f64>) -> Option<DVector<f64>> {
        let (values, shapes) = symmetric_eigen(&symmetric_part(&self.stiffness))?;
        let mut step = DVector::zeros(self.n());
        for (value, shape) in values.iter().zip(shapes.column_iter()) {
            let sizes = shape.abs();
            if value.abs() > sizes.dot(&(&self.error * &sizes)) {
                step.axpy(-shape.dot(forces) / value, &shape, 1.0);
            }
        }
        Some(step)
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

/// Constraints in natural coordinates: of which motions they leave free, and what holds a force.
struct Held {
    /// An orthonormal basis of the motions that keep them.
    free: Matrix,
    /// Multipliers that take up a unit of each force outside these.
    multipliers: Matrix,
}

impl Held {
    /// By singular values. `rows` are the derivatives of the constraints.
    fn new(mut rows: Matrix) -> Option<Self> {
        let (m, n) = rows.shape();
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
        let at_rest = (0..n).filter(|&i| is_idle(i));
        let mut motions: Vec<Motion> =
            at_rest.map(|i| Motion { rate: Complex::from(0.0), bound: 0.0, shape: unit(i) }).collect();
        for (rate, right, left) in eigen_both(&state)? {
            let [mut velocity, mut shape, mut force] = [(); 3].map(|()| vec![Complex::from(0.0); n]);
            for (m, &(_, i, is_velocity)) in states.iter().enumerate() {
                if is_velocity {
                    (velocity[i], force[i]) = (right[m], left[m]);
                } else {
                    shape[i] = right[m] / frequency(i);
                }
            }
            let drift = (0..n).filter(|&i| is_idle(i)).map(|i| velocity[i].norm()).fold(0.0, f64::max);
            if drift > 0.0 && rate.norm() > 0.0 {
                (0..n).filter(|&i| is_idle(i)).for_each(|i| shape[i] = velocity[i] / rate);
            }
            let bound = self.along(&force, &shape);
            if rate.norm() > DOUBLE * bound {
                motions.push(Motion { rate, bound, shape });
            } else if drift <= DRIFT {
                motions.push(Motion { rate: Complex::from(0.0), bound, shape });
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

/// Small motions of a model about rest at `q` under this fraction of its loads, which keep its constraints. These are held by the
/// multipliers, of which a model without constraints has none. `None` if a number is not finite.
pub(crate) fn small_motions(
    model: &mut dyn Model,
    q: &[f64],
    sizes: &[f64],
    load_factor: f64,
    multipliers: &[f64],
) -> Option<SmallMotions> {
    let n = q.len();
    let material = natural::material(model, q, sizes);
    let own = natural::linearised(model, q, sizes);
    let (work, uncoupled) = (natural::work_of_loads(model, q, sizes), model.parts());
    let reference = |stiffness: &Matrix| natural::reference(&material, stiffness, &work, &uncoupled);
    let mut at_rest = Parts { model, q, sizes, load_factor, multipliers };
    let (natural, forces) = match &own {
        None => {
            let stiffness = at_rest.tangent([1.0, 0.0, 0.0]);
            (Natural::new(&material, None, || reference(&stiffness))?, None)
        }
        Some(own) => {
            let natural = Natural::new(&material, Some(own), || reference(&material))?;
            at_rest.model.hold_springs(Some(&own.forces));
            let [residual, _] = at_rest.forces();
            let forces = natural.settled(own, &natural.forces(&residual));
            (natural, Some(forces))
        }
    };
    at_rest.model.hold_springs(forces.as_deref());
    let parts = at_rest.stiffness(&material);
    let [residual, work] = at_rest.forces();
    at_rest.model.hold_springs(None);
    let residual = at_rest.missing(&residual, &work, &parts.magnitudes);
    let imbalance = at_rest.imbalance(&residual, &work);
    let stiffness = natural.tangent(&parts.total, own.as_ref());
    let mut error =
        natural.magnitudes(&parts.magnitudes, own.as_ref()) * (ROUNDING * n as f64 * f64::EPSILON);
    error += natural.magnitudes(&imbalance, None);
    let damping = natural.matrix(&at_rest.tangent([0.0, 1.0, 0.0]));
    let mut mass = Matrix::zeros(n, n);
    at_rest.model.mass_matrix(q, &mut mass);
    let mass = natural.matrix(&scaled(mass, sizes));
    let (basis, change) = (natural.basis(), Matrix::zeros(n, n));
    let mut motions = SmallMotions { mass, damping, stiffness, error, change, basis, sizes: sizes.to_vec() };
    let has_potential = motions.has_potential();
    if has_potential {
        motions.error += motions.asymmetry();
    }
    let mut rows = Matrix::zeros(multipliers.len(), n);
    if !multipliers.is_empty() {
        at_rest.model.gap_jacobian(q, &mut rows);
        for (mut column, size) in rows.column_iter_mut().zip(sizes) {
            column *= *size;
        }
    }
    let held = Held::new(rows * &motions.basis)?;
    let kept = motions.within(&held);
    if !has_potential || !kept.is_finite() || kept.is_firm() {
        return Some(kept);
    }
    let residual = DVector::from(natural.residual(&residual, own.as_ref(), forces.as_deref().unwrap_or(&[])));
    let step = &held.free * kept.newton_step(&held.free.tr_mul(&residual))?;
    let more = &held.multipliers * (&residual + &motions.stiffness * &step);
    let moved = natural.coordinates(step.as_slice());
    let q: Vec<f64> = q.iter().zip(sizes.iter().zip(moved)).map(|(q, (size, x))| q + size * x).collect();
    let multipliers: Vec<f64> = multipliers.iter().zip(more.iter()).map(|(own, more)| own - more).collect();
    let mut beside = Parts { model: at_rest.model, q: &q, multipliers: &multipliers, ..at_rest };
    let forces = own.as_ref().zip(forces).map(|(own, mut forces)| {
        let changes = natural.change_of_forces(own, step.as_slice());
        forces.iter_mut().zip(changes).for_each(|(force, change)| *force += change);
        forces
    });
    beside.model.hold_springs(forces.as_deref());
    let there = beside.stiffness(&material).total;
    beside.model.hold_springs(None);
    motions.change = natural.matrix(&(there - parts.total));
    Some(motions.within(&held))
}

/// A sum of matrices, and the sum of the magnitudes of their entries.
struct Sum {
    total: Matrix,
    magnitudes: Matrix,
}

/// Forces and stiffnesses of a model at rest, in scaled coordinates, as sums over what they come from: gravity may balance a
/// contact or a loop, so that nothing is left but rounding.
struct Parts<'a> {
    model: &'a mut dyn Model,
    q: &'a [f64],
    sizes: &'a [f64],
    load_factor: f64,
    multipliers: &'a [f64],
}

impl Parts<'_> {
    /// Calls this on the model as it is; without what its constraints do; and also without its contacts.
    fn each<T: Clone>(&mut self, mut get: impl FnMut(&mut dyn Model) -> T) -> [T; 3] {
        let whole = {
            if !self.multipliers.is_empty() {
                self.model.set_multipliers(self.multipliers);
            }
            get(self.model)
        };
        let mut unconstrained = whole.clone();
        if !self.multipliers.is_empty() {
            self.model.set_multipliers(&vec![0.0; self.multipliers.len()]);
            unconstrained = get(self.model);
        }
        let mut untouched = unconstrained.clone();
        if self.model.has_contact() {
            self.model.leave_contact(true);
            untouched = get(self.model);
            self.model.leave_contact(false);
        }
        [whole, unconstrained, untouched]
    }

    /// `own + load_factor loads + constraints`.
    fn under_load(&self, own: f64, unconstrained: f64, whole: f64) -> f64 {
        let loads = self.load_factor;
        if loads == 1.0 { whole } else { own + loads * (unconstrained - own) + (whole - unconstrained) }
    }

    fn tangent(&mut self, weights: [f64; 3]) -> Matrix {
        let Self { q, sizes, .. } = *self;
        let rest = vec![0.0; q.len()];
        let [whole, ..] = self.each(|model| {
            let mut tangent = Matrix::zeros(q.len(), q.len());
            model.weighted_tangent(q, &rest, &rest, weights, &mut tangent);
            tangent
        });
        scaled(whole, sizes)
    }

    fn stiffness(&mut self, material: &Matrix) -> Sum {
        let Self { q, sizes, .. } = *self;
        let rest = vec![0.0; q.len()];
        let mut elastic = Matrix::zeros(q.len(), q.len());
        self.model.elastic_tangent(q, &mut elastic);
        let elastic = scaled(elastic, sizes);
        let parts = self.each(|model| {
            let mut tangent = Matrix::zeros(q.len(), q.len());
            model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
            scaled(tangent, sizes)
        });
        let work = natural::work_of_loads(self.model, q, sizes);
        let between = natural::work_of_interactions(self.model, q, sizes);
        let (mut total, mut magnitudes) = (material.abs(), material.abs());
        for k in 0..total.len() {
            let [whole, unconstrained, untouched] = [0, 1, 2].map(|part| parts[part][k]);
            let own = elastic[k];
            total[k] = self.under_load(own, unconstrained, whole);
            magnitudes[k] +=
                self.magnitude((own - material[k]).abs(), own, [whole, unconstrained, untouched]);
        }
        // Entries of loads are sums of products that may cancel: each is at most what the loads could do, however they point.
        for range in self.parts() {
            for (i, j) in range.clone().flat_map(|i| range.clone().map(move |j| (i, j))) {
                magnitudes[(i, j)] += self.load_factor.abs() * work[i].min(work[j]);
            }
        }
        // Contacts and tendons couple parts.
        for (i, j) in (0..q.len()).flat_map(|i| (0..q.len()).map(move |j| (i, j))) {
            magnitudes[(i, j)] += self.load_factor.abs() * between[i].min(between[j]);
        }
        Sum { total, magnitudes }
    }

    /// Coordinates of parts that nothing couples.
    fn parts(&self) -> Vec<std::ops::Range<usize>> {
        let parts = match self.model.parts() {
            parts if parts.is_empty() => vec![self.q.len()],
            parts => parts,
        };
        let mut first = 0;
        parts
            .into_iter()
            .map(|part| {
                first += part;
                first - part..first
            })
            .collect()
    }

    /// Generalised forces times sizes, and the work that what they come from could do along these.
    fn forces(&mut self) -> [Vec<f64>; 2] {
        let Self { q, sizes, .. } = *self;
        let rest = vec![0.0; q.len()];
        let mut elastic = rest.clone();
        self.model.elastic_forces(q, &mut elastic);
        let parts = self.each(|model| {
            let mut forces = rest.clone();
            model.inverse_dynamics(q, &rest, &rest, &mut forces);
            forces
        });
        let of_loads = natural::work_of_loads(self.model, q, sizes);
        let between = natural::work_of_interactions(self.model, q, sizes);
        let [mut total, mut work] = [rest.clone(), rest.clone()];
        for (k, size) in sizes.iter().enumerate() {
            let [whole, unconstrained, untouched] = [0, 1, 2].map(|part| parts[part][k]);
            total[k] = size * self.under_load(elastic[k], unconstrained, whole);
            work[k] = size * self.magnitude(elastic[k].abs(), elastic[k], [whole, unconstrained, untouched])
                + self.load_factor.abs() * (of_loads[k] + between[k]);
        }
        [total, work]
    }

    /// The sum of the magnitudes of what elasticity, loads, contacts and constraints add.
    fn magnitude(&self, elastic: f64, own: f64, [whole, unconstrained, untouched]: [f64; 3]) -> f64 {
        let by_loads = (untouched - own).abs() + (unconstrained - untouched).abs();
        elastic + self.load_factor.abs() * by_loads + (whole - unconstrained).abs()
    }

    /// The forces that are missing for equilibrium, as far as tolerance and rounding of coordinates explain them: beyond that, the shape
    /// is none.
    fn missing(&self, residual: &[f64], work: &[f64], magnitudes: &Matrix) -> Vec<f64> {
        let most = |k: usize| {
            OUT_OF_BALANCE * work[k] + DISPLACEMENT_ROUNDING * magnitudes.row(k).iter().sum::<f64>()
        };
        residual.iter().enumerate().map(|(k, force)| force.min(most(k)).max(-most(k))).collect()
    }

    /// What these could change the stiffness by: no more than themselves, as a turn about one axis changes moments about another one by
    /// half of that about the third; and the shape is one of equilibrium under forces that differ by the part of them that is
    /// missing (Rigal and Gaches 1967), as their stiffness then does. Parts that nothing couples have no part in each other's.
    fn imbalance(&self, missing: &[f64], work: &[f64]) -> Matrix {
        let mut imbalance = Matrix::zeros(missing.len(), missing.len());
        for range in self.parts() {
            let least = NOTHING * range.clone().map(|k| work[k]).fold(0.0, f64::max);
            let part = |k: usize| if missing[k] == 0.0 { 0.0 } else { missing[k].abs() / work[k].max(least) };
            let (size, part) = (norm(&missing[range.clone()]), range.clone().map(part).fold(0.0, f64::max));
            for (i, j) in range.clone().flat_map(|i| range.clone().map(move |j| (i, j))) {
                imbalance[(i, j)] = size.min(part * work[i].min(work[j]));
            }
        }
        imbalance
    }
}
