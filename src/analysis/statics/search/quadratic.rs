//! The quadratic problem of a step: least energy of a linearised model with closed loops as equalities, inextensible tendons as
//! inequalities, and springs of any stiffness.

use super::balance::IndependentRows;
use super::problem::{add_transposed, times};
use crate::numerics::linalg::{
    Cholesky, Matrix, bounded_least_squares, dot, full_svd, norm, symmetric_eigen, symmetric_part,
};

/// A pivot below this one of a matrix with ones on its diagonal is rounding, and the matrix not positive definite.
const SMALLEST_PIVOT: f64 = 1e-14;

/// Springs stretch nothing along directions whose singular value is below this part of the largest one.
const UNSTRETCHED: f64 = 1e-13;

/// A tendon that would have to push becomes slack if its force exceeds this part of the forces.
const PUSHING_FORCE: f64 = 1e-7;

/// Forces below this part of the gradient are balanced to rounding without inextensible tendons.
const BALANCED_TO_ROUNDING: f64 = 1e-12;

/// Elongations below this part of the sum of their terms are rounding.
const ROUNDING: f64 = 1e-13;

/// Number of changes of the active set after which only one row changes at a time.
const SIMULTANEOUS_CHANGES: usize = 12;

/// Factors of a symmetric matrix scaled to ones on its diagonal.
struct Factors {
    scale: Vec<f64>,
    cholesky: Cholesky,
}

impl Factors {
    /// `None` unless the matrix is positive definite.
    fn new(a: &Matrix) -> Option<Self> {
        let n = a.nrows();
        let scale: Vec<f64> = (0..n).map(|i| a[(i, i)].abs().max(f64::MIN_POSITIVE).sqrt().recip()).collect();
        let of_one = Matrix::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]);
        let mut cholesky = Cholesky::new(n);
        cholesky.factorise(&of_one).ok()?;
        (cholesky.smallest_pivot() > SMALLEST_PIVOT).then_some(Self { scale, cholesky })
    }

    fn solve(&self, x: &mut [f64]) {
        x.iter_mut().zip(&self.scale).for_each(|(x, scale)| *x *= scale);
        self.cholesky.solve(x);
        x.iter_mut().zip(&self.scale).for_each(|(x, scale)| *x *= scale);
    }

    fn solve_columns(&self, a: &mut Matrix) {
        a.column_iter_mut().for_each(|mut column| self.solve(column.as_mut_slice()));
    }
}

/// `min g'p + p'K p / 2 + sum (e + A p)^2 / 2` with `V p = -a`. Directions that springs stretch and those that they do not stretch are
/// separate unknowns, so that stiff springs cause no rounding in the latter. Rows of A are scaled to stiffness one.
pub(super) struct Saddle {
    constraints: IndependentRows,
    hessian: Matrix,
    /// Stretched and free directions.
    stretched: Matrix,
    free: Option<Matrix>,
    rows: Matrix,
    of_stretched: Matrix,
    inner: Factors,
    /// `(Z'K Z)^-1 Z'K Y`.
    coupling: Matrix,
    outer: Factors,
}

impl Saddle {
    /// `None` unless the problem is convex.
    fn new(hessian: &Matrix, constraints: IndependentRows, rows: Matrix) -> Option<Self> {
        let n = hessian.nrows();
        let kept = if constraints.rows.nrows() == 0 { None } else { Some(complement(&constraints.rows)?) };
        let (stretched, free) = if rows.nrows() == 0 {
            (Matrix::zeros(n, 0), kept)
        } else {
            let along = match &kept {
                Some(kept) => &rows * kept,
                None => rows.clone(),
            };
            let (_, values, right) = full_svd(&along)?;
            let largest = values.first().copied().unwrap_or(0.0);
            let rank = values.iter().filter(|&&value| value > UNSTRETCHED * largest && value > 0.0).count();
            let [stretched, free] = [(0, rank), (rank, right.ncols() - rank)]
                .map(|(first, number)| right.columns(first, number).into_owned());
            match kept {
                Some(kept) => (&kept * stretched, Some(kept * free)),
                None => (stretched, Some(free)),
            }
        };
        let of_free = free.as_ref().map(|free| free.tr_mul(&(hessian * free)));
        let inner = Factors::new(of_free.as_ref().unwrap_or(hessian))?;
        let with_stretched = hessian * &stretched;
        let couples = match &free {
            Some(free) => free.tr_mul(&with_stretched),
            None => with_stretched.clone(),
        };
        let mut coupling = couples.clone();
        inner.solve_columns(&mut coupling);
        let of_stretched = &rows * &stretched;
        let outer = stretched.tr_mul(&with_stretched) - couples.tr_mul(&coupling)
            + of_stretched.tr_mul(&of_stretched);
        let outer = Factors::new(&outer)?;
        Some(Self {
            constraints,
            hessian: hessian.clone(),
            stretched,
            free,
            rows,
            of_stretched,
            inner,
            coupling,
            outer,
        })
    }

    /// The solution for a gradient, gaps of the independent rows, and elongations.
    pub(super) fn solve(&self, gradient: &[f64], gaps: &[f64], elongations: &[f64]) -> Vec<f64> {
        let n = gradient.len();
        let mut x = vec![0.0; n];
        let closing: Vec<f64> = gaps.iter().map(|gap| -gap).collect();
        add_transposed(&self.constraints.rows, &closing, &mut x);
        let mut force = gradient.to_vec();
        if !gaps.is_empty() {
            times(&self.hessian, &x).into_iter().zip(&mut force).for_each(|(more, force)| *force += more);
        }
        let mut z = self.onto_free(&force);
        if self.stretched.ncols() == 0 {
            self.inner.solve(&mut z);
            self.add_free(&z, -1.0, &mut x);
            return x;
        }
        let mut y = transposed_times(&self.stretched, &force);
        let mut part = transposed_times(&self.coupling, &z);
        y.iter_mut().zip(&part).for_each(|(y, part)| *y -= part);
        let stretch: Vec<f64> =
            elongations.iter().zip(times(&self.rows, &x)).map(|(e, more)| e + more).collect();
        part = transposed_times(&self.of_stretched, &stretch);
        y.iter_mut().zip(&part).for_each(|(y, part)| *y += part);
        self.outer.solve(&mut y);
        y.iter_mut().for_each(|y| *y = -*y);
        times(&self.stretched, &y).into_iter().zip(&mut x).for_each(|(more, x)| *x += more);
        self.inner.solve(&mut z);
        times(&self.coupling, &y).into_iter().zip(&mut z).for_each(|(more, z)| *z += more);
        self.add_free(&z, -1.0, &mut x);
        x
    }

    fn onto_free(&self, force: &[f64]) -> Vec<f64> {
        self.free.as_ref().map_or_else(|| force.to_vec(), |free| transposed_times(free, force))
    }

    fn add_free(&self, z: &[f64], factor: f64, x: &mut [f64]) {
        match &self.free {
            None => x.iter_mut().zip(z).for_each(|(x, z)| *x += factor * z),
            Some(free) => {
                times(free, z).into_iter().zip(x).for_each(|(z, x)| *x += factor * z);
            }
        }
    }

    /// A direction of roughly the least curvature among those free of constraints and springs, of length one; `None` if there are none.
    pub(super) fn least_curved(&self) -> Option<Vec<f64>> {
        const ITERATIONS: usize = 4;
        let n = self.hessian.nrows();
        let free = self.free.as_ref().map_or(n, Matrix::ncols);
        if free == 0 {
            return None;
        }
        let mut z: Vec<f64> = (0..free).map(|k| (1.0 + k as f64).cos()).collect();
        for _ in 0..ITERATIONS {
            self.inner.solve(&mut z);
            let size = norm(&z);
            z.iter_mut().for_each(|z| *z /= size);
        }
        let mut x = vec![0.0; n];
        self.add_free(&z, 1.0, &mut x);
        Some(x)
    }
}

/// Eigenvalues and eigenvectors of the second derivative, including active tendons and springs, for motions that satisfy loops and active
/// inextensible tendons. Empty if a number is not finite.
pub(super) fn softest(
    hessian: &Matrix,
    of_loops: &IndependentRows,
    rows: &Matrix,
    stiffness: &[f64],
    active: &[bool],
) -> Vec<(f64, Vec<f64>)> {
    let (n, loops) = (hessian.nrows(), of_loops.rows.nrows());
    let of_kind = |is_rigid: bool| {
        let chosen = (0..active.len()).filter(|&row| active[row] && stiffness[row].is_infinite() == is_rigid);
        chosen.collect::<Vec<_>>()
    };
    let (rigid, elastic) = (of_kind(true), of_kind(false));
    let stretched =
        Matrix::from_fn(elastic.len(), n, |i, j| stiffness[elastic[i]].sqrt() * rows[(elastic[i], j)]);
    let whole = hessian + stretched.tr_mul(&stretched);
    let constraints = Matrix::from_fn(loops + rigid.len(), n, |i, j| match i.checked_sub(loops) {
        None => of_loops.rows[(i, j)],
        Some(i) => rows[(rigid[i], j)],
    });
    let free = if constraints.nrows() == 0 {
        Some(Matrix::identity(n, n))
    } else {
        complement(&IndependentRows::new(&constraints).rows)
    };
    let found = free.and_then(|free| {
        let (values, vectors) = symmetric_eigen(&symmetric_part(&free.tr_mul(&(whole * &free))))?;
        let vectors = free * vectors;
        let columns = vectors.column_iter().map(|x| x.iter().copied().collect());
        Some(values.iter().copied().zip(columns).collect())
    });
    found.unwrap_or_default()
}

/// Orthonormal columns that complete orthonormal rows.
fn complement(rows: &Matrix) -> Option<Matrix> {
    let (_, _, right) = full_svd(rows)?;
    let rank = rows.nrows().min(rows.ncols());
    Some(right.columns(rank, rows.ncols() - rank).into_owned())
}

fn transposed_times(a: &Matrix, x: &[f64]) -> Vec<f64> {
    a.column_iter().map(|column| dot(column.as_slice(), x)).collect()
}

/// Data of a quadratic problem without its second derivative: the gradient, independent rows of closed loops, and rows of tendons and
/// springs with their excesses and stiffnesses.
pub(super) struct Linearised<'a> {
    pub(super) gradient: &'a [f64],
    pub(super) constraints: &'a IndependentRows,
    pub(super) rows: &'a Matrix,
    pub(super) excess: &'a [f64],
    pub(super) stiffness: &'a [f64],
    /// Rows that act on one side only; the others always act.
    pub(super) is_one_sided: &'a [bool],
}

/// A solution.
pub(super) struct Solution {
    pub(super) x: Vec<f64>,
    pub(super) taut: Vec<bool>,
    pub(super) saddle: Saddle,
    /// Taut inextensible rows, and taut elastic ones.
    pub(super) rigid: Vec<usize>,
    pub(super) elastic: Vec<usize>,
    /// Maps gaps of the loops' independent rows, followed by excesses of taut inextensible rows, to those of the saddle.
    pub(super) transform: Matrix,
}

impl Linearised<'_> {
    /// Elongations of elastic rows in units in which their stiffness is one.
    pub(super) fn in_units_of_stiffness(&self, elastic: &[usize], excess: impl Fn(usize) -> f64) -> Vec<f64> {
        elastic.iter().map(|&row| self.stiffness[row].sqrt() * excess(row)).collect()
    }

    /// Length of the gradient in a diagonal metric.
    pub(super) fn steepest(&self, metric: &[f64]) -> f64 {
        self.gradient.iter().zip(metric).map(|(g, b)| g * g / b).sum::<f64>().sqrt()
    }

    /// Solves from this active set, or from none.
    pub(super) fn attempt(&self, hessian: &Matrix, taut: &[bool]) -> Option<Solution> {
        let from = |taut: &[bool]| self.solve(hessian, taut);
        let is_any = taut.iter().any(|taut| *taut);
        from(taut).or_else(|| if is_any { from(&vec![false; taut.len()]) } else { None })
    }

    /// Solves with one-sided rows: `A p <= -c` for inextensible ones, and the energies `k max(0, c + A p)^2 / 2` of the others, by a
    /// primal-dual active set method from `taut` (Hintermueller, Ito and Kunisch 2003). If a set recurs, one row changes at a time.
    /// `None` if the problem is not convex, or no set is consistent.
    pub(super) fn solve(&self, hessian: &Matrix, taut: &[bool]) -> Option<Solution> {
        let m = self.excess.len();
        let mut taut: Vec<bool> =
            taut.iter().zip(self.is_one_sided).map(|(taut, tendon)| *taut || !tendon).collect();
        let mut seen: Vec<Vec<bool>> = Vec::new();
        for attempt in 0..4 * (SIMULTANEOUS_CHANGES + m) {
            let solution = self.with_active(hessian, &taut)?;
            let wrong = self.wrong(&solution, hessian);
            if !wrong.iter().any(|wrong| *wrong) {
                return Some(solution);
            }
            let mut next: Vec<bool> = taut.iter().zip(&wrong).map(|(taut, wrong)| taut != wrong).collect();
            seen.push(taut.clone());
            if seen.contains(&next) || attempt > SIMULTANEOUS_CHANGES {
                let last = wrong.iter().rposition(|wrong| *wrong).unwrap_or(0);
                next = taut;
                next[last] = !next[last];
            }
            taut = next;
        }
        None
    }

    fn with_active(&self, hessian: &Matrix, taut: &[bool]) -> Option<Solution> {
        let active = |is_rigid: bool| -> Vec<usize> {
            (0..taut.len())
                .filter(|&row| taut[row] && self.stiffness[row].is_infinite() == is_rigid)
                .collect()
        };
        let (rigid, elastic) = (active(true), active(false));
        let loops = self.constraints.rows.nrows();
        let (constraints, transform) = if rigid.is_empty() {
            (self.constraints.clone(), Matrix::identity(loops, loops))
        } else {
            let n = self.gradient.len();
            let all = Matrix::from_fn(loops + rigid.len(), n, |i, j| match i.checked_sub(loops) {
                None => self.constraints.rows[(i, j)],
                Some(i) => self.rows[(rigid[i], j)],
            });
            let all = IndependentRows::new(&all);
            let transform = all.transform.clone();
            (all, transform)
        };
        let rows = Matrix::from_fn(elastic.len(), self.gradient.len(), |i, j| {
            self.stiffness[elastic[i]].sqrt() * self.rows[(elastic[i], j)]
        });
        let saddle = Saddle::new(hessian, constraints, rows)?;
        let gaps: Vec<f64> =
            vec![0.0; loops].into_iter().chain(rigid.iter().map(|&row| self.excess[row])).collect();
        let elongations = self.in_units_of_stiffness(&elastic, |row| self.excess[row]);
        let x = saddle.solve(self.gradient, &times(&transform, &gaps), &elongations);
        x.iter().all(|x| x.is_finite()).then_some(Solution {
            x,
            taut: taut.to_vec(),
            saddle,
            rigid,
            elastic,
            transform,
        })
    }

    /// Rows that are active but push, or inactive but exceeded.
    fn wrong(&self, solution: &Solution, hessian: &Matrix) -> Vec<bool> {
        let Solution { x, taut, rigid, .. } = solution;
        let m = self.excess.len();
        let mut wrong = vec![false; m];
        if !self.is_one_sided.iter().any(|tendon| *tendon) {
            return wrong;
        }
        let moved = times(self.rows, x);
        let mut elastic_force: Vec<f64> = vec![0.0; m];
        for row in 0..m {
            let length = self.excess[row] + moved[row];
            let size: f64 = self.excess[row].abs()
                + (0..x.len()).map(|j| (self.rows[(row, j)] * x[j]).abs()).sum::<f64>();
            if !taut[row] {
                wrong[row] = length > ROUNDING * size;
            } else if self.stiffness[row].is_finite() {
                wrong[row] = self.is_one_sided[row] && length < 0.0;
                elastic_force[row] = self.stiffness[row] * length;
            }
        }
        if !rigid.is_empty() {
            let mut force: Vec<f64> =
                self.gradient.iter().zip(times(hessian, x)).map(|(g, more)| g + more).collect();
            add_transposed(self.rows, &elastic_force, &mut force);
            let force = self.constraints.free(&force);
            let size = norm(&force);
            if size > BALANCED_TO_ROUNDING * norm(self.gradient) {
                let mut columns = Matrix::zeros(x.len(), rigid.len());
                for (k, &row) in rigid.iter().enumerate() {
                    let column: Vec<f64> = self.rows.row(row).iter().copied().collect();
                    columns.column_mut(k).copy_from_slice(&self.constraints.free(&column));
                }
                let wanted: Vec<f64> = force.iter().map(|x| -x / size).collect();
                let bounds = [vec![0.0; rigid.len()], vec![f64::INFINITY; rigid.len()]];
                let tensions = bounded_least_squares(&columns, &wanted, &bounds[0], &bounds[1]);
                let pulls = times(&columns, &tensions);
                let left: Vec<f64> = pulls.iter().zip(&wanted).map(|(pull, wanted)| pull - wanted).collect();
                if norm(&left) > PUSHING_FORCE {
                    for (&row, tension) in rigid.iter().zip(tensions) {
                        wrong[row] |= tension == 0.0;
                    }
                }
            }
        }
        wrong
    }
}
