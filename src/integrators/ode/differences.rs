//! Jacobians of right-hand sides by forward differences with adaptive increments: the algorithm of
//! Salane (1986), "Adaptive routines for forming Jacobians numerically", as used by MATLAB's `numjac` and SciPy's
//! `num_jac`. Columns whose nonzero rows are disjoint share an evaluation (Curtis, Powell and Reid 1974).

use super::FirstOrderSystem;
use crate::error::{Checker, Interrupted, InvalidInput};
use crate::numerics::linalg::Matrix;

/// Exponent of the rounding unit in the first relative increment.
const FIRST_FACTOR_EXPONENT: f64 = 0.5;
/// A column whose largest relative difference is below this power of the rounding unit is recomputed
/// (Salane).
const REJECT_EXPONENT: f64 = 0.875;
/// Below this power, the increment grows for the next Jacobian (Salane).
const SMALL_EXPONENT: f64 = 0.75;
/// Above this power, the increment shrinks (Salane).
const BIG_EXPONENT: f64 = 0.25;
/// Smallest relative increment, in rounding units (Salane).
const SMALLEST_FACTOR_IN_ROUNDING_UNITS: f64 = 1e3;
/// Factor by which increments grow and shrink (Salane).
const FACTOR_CHANGE: f64 = 10.0;

/// Sparsity pattern of a Jacobian, with groups of columns that share an evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Sparsity {
    // The rows of every column.
    rows: Vec<Vec<usize>>,
    // The columns of every group.
    groups: Vec<Vec<usize>>,
}

impl Sparsity {
    /// Pattern of an (n, n) matrix whose nonzero entries are at the given (row, column) pairs.
    pub fn new(n: usize, places: impl IntoIterator<Item = (usize, usize)>) -> Result<Self, InvalidInput> {
        let mut rows = vec![Vec::new(); n];
        let mut checker = Checker::new();
        for (row, column) in places {
            let place = format!("jac_sparsity[{row}, {column}]");
            if checker.require(row < n && column < n, &place, "an entry", &format!("shape ({n}, {n})")) {
                rows[column].push(row);
            }
        }
        checker.finish()?;
        for rows in &mut rows {
            rows.sort_unstable();
            rows.dedup();
        }
        let groups = group(&rows);
        Ok(Self { rows, groups })
    }

    /// Number of evaluations per Jacobian.
    pub fn groups(&self) -> usize {
        self.groups.len()
    }

    pub(super) fn n(&self) -> usize {
        self.rows.len()
    }
}

/// Assigns every column to the first group without a common row.
fn group(rows: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    // Rows occupied by the columns of each group.
    let mut taken: Vec<Vec<bool>> = Vec::new();
    for (column, own_rows) in rows.iter().enumerate() {
        let fits = |taken: &Vec<bool>| own_rows.iter().all(|&row| !taken[row]);
        let index = taken.iter().position(fits).unwrap_or_else(|| {
            groups.push(Vec::new());
            taken.push(vec![false; rows.len()]);
            groups.len() - 1
        });
        groups[index].push(column);
        for &row in own_rows {
            taken[index][row] = true;
        }
    }
    groups
}

/// Point at which a Jacobian is evaluated.
pub(super) struct Place<'a> {
    pub(super) t: f64,
    pub(super) y: &'a [f64],
    /// f(t, y).
    pub(super) f: &'a [f64],
    /// Smallest sizes assumed for the components of y: the absolute tolerances.
    pub(super) threshold: &'a [f64],
    /// Size of the next step.
    pub(super) h_abs: f64,
}

/// A Jacobian by differences, with the adapted increments of earlier evaluations.
#[derive(Clone, Debug)]
pub(super) struct DifferencedJacobian {
    groups: Vec<Vec<usize>>,
    // `None`: the Jacobian is dense.
    rows: Option<Vec<Vec<usize>>>,
    // Increments relative to the size of the components.
    factors: Vec<f64>,
    increments: Vec<f64>,
    // One column per group.
    arguments: Matrix,
    values: Matrix,
    // Argument for a column that is recomputed.
    argument: Vec<f64>,
    value: Vec<f64>,
}

/// Largest change in a column of differences, and the size of the function in that row.
#[derive(Clone, Copy)]
struct Change {
    largest: f64,
    scale: f64,
}

impl DifferencedJacobian {
    pub(super) fn new(n: usize, sparsity: Option<Sparsity>) -> Self {
        let (groups, rows) = match sparsity {
            Some(sparsity) => (sparsity.groups, Some(sparsity.rows)),
            None => ((0..n).map(|column| vec![column]).collect(), None),
        };
        Self {
            factors: vec![f64::EPSILON.powf(FIRST_FACTOR_EXPONENT); n],
            increments: vec![0.0; n],
            arguments: Matrix::zeros(n, groups.len()),
            values: Matrix::zeros(n, groups.len()),
            argument: vec![0.0; n],
            value: vec![0.0; n],
            groups,
            rows,
        }
    }

    /// `jacobian <- df/dy`; returns the number of evaluations.
    pub(super) fn evaluate<S: FirstOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        place: &Place<'_>,
        jacobian: &mut Matrix,
    ) -> Result<usize, Interrupted> {
        let n = place.y.len();
        if n == 0 {
            return Ok(0);
        }
        for column in 0..n {
            self.increments[column] = place.increment(column, &mut self.factors[column]);
        }
        for (index, columns) in self.groups.iter().enumerate() {
            let mut argument = self.arguments.column_mut(index);
            argument.as_mut_slice().copy_from_slice(place.y);
            for &column in columns {
                argument[column] += self.increments[column];
            }
        }
        system.rhs_columns(place.t, &self.arguments, &mut self.values)?;
        let mut evaluations = self.groups.len();
        jacobian.fill(0.0);
        let reject = f64::EPSILON.powf(REJECT_EXPONENT);
        let small = f64::EPSILON.powf(SMALL_EXPONENT);
        let big = f64::EPSILON.powf(BIG_EXPONENT);
        for index in 0..self.groups.len() {
            for position in 0..self.groups[index].len() {
                let column = self.groups[index][position];
                let mut change =
                    self.difference(place, column, self.values.column(index).as_slice(), jacobian);
                if change.largest < reject * change.scale {
                    change = self.try_larger(system, place, column, change, jacobian)?;
                    evaluations += 1;
                }
                let factor = &mut self.factors[column];
                if change.largest < small * change.scale {
                    *factor *= FACTOR_CHANGE;
                }
                if change.largest > big * change.scale {
                    *factor /= FACTOR_CHANGE;
                }
                *factor = factor.max(SMALLEST_FACTOR_IN_ROUNDING_UNITS * f64::EPSILON);
            }
        }
        Ok(evaluations)
    }

    /// Recomputes a column with a larger increment; keeps the result if it is more accurate.
    fn try_larger<S: FirstOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        place: &Place<'_>,
        column: usize,
        change: Change,
        jacobian: &mut Matrix,
    ) -> Result<Change, Interrupted> {
        let mut factor = FACTOR_CHANGE * self.factors[column];
        let increment = place.increment(column, &mut factor);
        self.argument.copy_from_slice(place.y);
        self.argument[column] += increment;
        system.rhs(place.t, &self.argument, &mut self.value)?;
        let larger = self.change(place, column, &self.value);
        if change.largest * larger.scale < larger.largest * change.scale {
            self.factors[column] = factor;
            self.increments[column] = increment;
            Ok(self.difference(place, column, &self.value, jacobian))
        } else {
            Ok(change)
        }
    }

    /// Writes a column of the Jacobian and returns its largest change.
    fn difference(&self, place: &Place<'_>, column: usize, value: &[f64], jacobian: &mut Matrix) -> Change {
        let increment = self.increments[column];
        let mut entries = jacobian.column_mut(column);
        match &self.rows {
            None => {
                for (row, entry) in entries.iter_mut().enumerate() {
                    *entry = (value[row] - place.f[row]) / increment;
                }
            }
            Some(rows) => {
                for &row in &rows[column] {
                    entries[row] = (value[row] - place.f[row]) / increment;
                }
            }
        }
        self.change(place, column, value)
    }

    fn change(&self, place: &Place<'_>, column: usize, value: &[f64]) -> Change {
        let mut change: Option<Change> = None;
        let mut consider = |row: usize| {
            let difference = (value[row] - place.f[row]).abs();
            if change.is_none_or(|change| difference > change.largest) {
                let scale = place.f[row].abs().max(value[row].abs());
                change = Some(Change { largest: difference, scale });
            }
        };
        match &self.rows {
            None => (0..value.len()).for_each(&mut consider),
            Some(rows) => rows[column].iter().copied().for_each(&mut consider),
        }
        change.unwrap_or(Change { largest: 0.0, scale: 0.0 })
    }
}

impl Place<'_> {
    /// Increment of a component: exactly representable, nonzero, and in the direction of the solution's
    /// derivative, where the right-hand side is more likely to be defined. Enlarges the factor until the
    /// increment is not 0. Without an absolute tolerance, the size of a component that is 0 is its change in the
    /// next step.
    fn increment(&self, component: usize, factor: &mut f64) -> f64 {
        let y = self.y[component];
        let size = match y.abs().max(self.threshold[component]) {
            0.0 => self.h_abs * self.f[component].abs(),
            size => size,
        };
        let size = if self.f[component] >= 0.0 { size } else { -size };
        loop {
            let increment = (y + *factor * size) - y;
            if increment != 0.0 {
                return increment;
            }
            if size == 0.0 {
                // The scale of the component is unknown: y = 0 without a tolerance, and it does not change.
                return *factor;
            }
            *factor *= FACTOR_CHANGE;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Robertson {
        evaluations: usize,
    }

    impl FirstOrderSystem for Robertson {
        fn n(&self) -> usize {
            3
        }
        fn rhs(&mut self, _: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
            self.evaluations += 1;
            dydt[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
            dydt[2] = 3e7 * y[1] * y[1];
            dydt[1] = -dydt[0] - dydt[2];
            Ok(())
        }
    }

    #[test]
    fn a_badly_scaled_jacobian() {
        let mut system = Robertson { evaluations: 0 };
        let y = [1.0, 0.0, 0.0];
        let mut f = [0.0; 3];
        system.rhs(0.0, &y, &mut f).unwrap();
        system.evaluations = 0;
        let exact = Matrix::from_row_slice(3, 3, &[-0.04, 0.0, 0.0, 0.04, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let mut jacobian = Matrix::zeros(3, 3);
        let mut differences = DifferencedJacobian::new(3, None);
        let mut counted = 0;
        for _ in 0..3 {
            let place = Place { t: 0.0, y: &y, f: &f, threshold: &[1e-5; 3], h_abs: 1.0 };
            counted += differences.evaluate(&mut system, &place, &mut jacobian).unwrap();
            assert!((&jacobian - &exact).amax() < 1e-4, "{jacobian}");
        }
        assert_eq!(counted, system.evaluations);
    }

    struct Tridiagonal(usize);

    impl FirstOrderSystem for Tridiagonal {
        fn n(&self) -> usize {
            self.0
        }
        fn rhs(&mut self, _: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
            for i in 0..self.0 {
                let left = if i > 0 { y[i - 1] } else { 0.0 };
                let right = if i + 1 < self.0 { y[i + 1] } else { 0.0 };
                dydt[i] = left * left - 3.0 * y[i] + y[i] * right;
            }
            Ok(())
        }
    }

    #[test]
    fn a_sparse_jacobian_takes_few_evaluations() {
        let n = 20;
        let mut system = Tridiagonal(n);
        let places = (0..n).flat_map(|i| (i.saturating_sub(1)..n.min(i + 2)).map(move |j| (i, j)));
        let sparsity = Sparsity::new(n, places).unwrap();
        assert_eq!(sparsity.groups(), 3);
        let y: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut f = vec![0.0; n];
        system.rhs(0.0, &y, &mut f).unwrap();
        let place = Place { t: 0.0, y: &y, f: &f, threshold: &vec![1e-6; n], h_abs: 1.0 };
        let (mut dense, mut sparse) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        DifferencedJacobian::new(n, None).evaluate(&mut system, &place, &mut dense).unwrap();
        DifferencedJacobian::new(n, Some(sparsity)).evaluate(&mut system, &place, &mut sparse).unwrap();
        assert!((dense - sparse).amax() < 1e-6);
        assert!(Sparsity::new(2, [(0, 2)]).is_err());
    }
}
