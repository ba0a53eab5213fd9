//! Among all roots within bounds, the one that minimises a quadratic form.
//!
//! Solves `min |D (x - w)|^2 / 2` subject to `R(x) = 0` and bounds by the method of multipliers (Hestenes
//! 1969; Powell 1969): a sequence of least-squares problems for `r (R + y)` and `D (x - w)`, with updates `y
//! <- y + R` and with r increased until R vanishes. Where this converges too slowly, because an equation hardly depends on the unknowns,
//! steps along the roots follow (generalised reduced gradients; Abadie and Carpentier 1969).

use super::{Bounds, Counters, End, LeastSquares, Options, SecondOrder, solve};
use crate::error::{Interrupted, Unfinished};
use crate::numerics::linalg::{Matrix, bounded_least_squares, full_svd, norm};
use crate::numerics::roots::NonlinearSystem;

/// Initial weight r^2 of the equations, its growth after rounds that leave more than the fraction `SLOW` of
/// R, and its largest value, at which doubles still resolve the quadratic form (Nocedal and Wright 2006,
/// section 17.4).
const FIRST_WEIGHT: f64 = 1e2;
const GROWTH: f64 = 10.0;
const SLOW: f64 = 0.03;
const LARGEST_WEIGHT: f64 = 1e10;

/// Maximum number of rounds: at the boundary of the reachable set, multipliers do not exist and the iteration
/// never converges.
const MAX_ROUNDS: usize = 30;

/// Steps allowed per round as a multiple of those of a start: weak preferences have long flat valleys.
const STEPS: usize = 10;

/// Maximum number of steps along roots, and the smallest part of one that is tried.
const MAX_SLIDES: usize = 50;
const SHORTEST: f64 = 1e-6;

/// Parts of steps after one that failed, and after one that did not.
const SHORTER: f64 = 0.25;
const LONGER: f64 = 2.0;

/// Steps of Newton's method back to a root.
const MAX_RETURNS: usize = 30;

/// Weight of the equations relative to the form in steps along roots: the steps violate the linearised equations by one over its square.
const FIRST: f64 = 1e3;

/// Equations whose relative singular values are smaller than this do not determine anything.
const RANK: f64 = 1e-8;

/// Steps below this length, for unknowns of order one, count as converged.
const CONVERGED_STEP: f64 = 1e-7;

/// Tolerance of roots between steps, relative to the requested one.
const CLOSER: f64 = 0.1;

/// The quadratic form `|D (x - w)|^2 / 2`.
#[derive(Clone, Debug)]
pub struct Form {
    /// D.
    pub root: Matrix,
    /// w.
    pub wanted: Vec<f64>,
}

impl Form {
    /// Moves from a root to the preferred one nearby; returns whether it converged. Otherwise x is unchanged.
    pub fn refine(
        &self,
        system: &mut dyn LeastSquares,
        x: &mut [f64],
        bounds: &Bounds,
        options: &Options,
        counters: &mut Counters,
    ) -> Result<bool, Interrupted> {
        let equations = system.equations();
        let mut here = x.to_vec();
        let mut augmented =
            Augmented { form: self, system, multipliers: vec![0.0; equations], weight: FIRST_WEIGHT.sqrt() };
        let mut residual = vec![0.0; equations];
        let mut before = f64::INFINITY;
        for _ in 0..MAX_ROUNDS {
            let search = Options {
                tolerance: 0.0,
                terms: options.terms * augmented.weight,
                max_iter: STEPS * options.max_iter,
                second_order: SecondOrder::FromStart,
            };
            let found = solve(&mut augmented, &mut here, bounds, &search).map_err(Unfinished::interrupted)?;
            *counters += found.counters;
            if !matches!(found.end, End::Minimum | End::Root) {
                break;
            }
            augmented.system.residual(&here, &mut residual)?;
            let left = norm(&residual);
            if left <= options.tolerance {
                x.copy_from_slice(&here);
                return Ok(true);
            }
            let growth = if left > SLOW * before { GROWTH.sqrt() } else { 1.0 };
            before = left;
            let weight = (augmented.weight * growth).min(LARGEST_WEIGHT.sqrt());
            let ratio = (augmented.weight / weight).powi(2);
            for (multiplier, residual) in augmented.multipliers.iter_mut().zip(&residual) {
                *multiplier = (*multiplier + residual) * ratio;
            }
            augmented.weight = weight;
        }
        self.slide(augmented.system, x, bounds, options.tolerance, counters)
    }

    /// Moves along roots; returns whether it converged. Otherwise x is unchanged.
    fn slide(
        &self,
        system: &mut dyn LeastSquares,
        x: &mut [f64],
        bounds: &Bounds,
        tolerance: f64,
        counters: &mut Counters,
    ) -> Result<bool, Interrupted> {
        let mut roots = Roots { form: self, system, bounds, tolerance: CLOSER * tolerance, counters };
        let Some(mut here) = roots.nearest(x.to_vec())? else { return Ok(false) };
        let mut part = 1.0;
        for _ in 0..MAX_SLIDES {
            let wanted: Vec<f64> = self.left(&here.x).into_iter().map(|left| -left).collect();
            let step = roots.step(&here, &vec![0.0; here.values.len()], &wanted);
            let length = norm(&step);
            let next = loop {
                if length <= CONVERGED_STEP || part < SHORTEST {
                    break None;
                }
                let there = here.x.iter().zip(&step).map(|(x, step)| x + part * step).collect();
                let size = |x: &[f64]| norm(&self.left(x));
                match roots.nearest(there)?.filter(|found| size(&found.x) < size(&here.x)) {
                    Some(found) => break Some(found),
                    None => part *= SHORTER,
                }
            };
            match next {
                Some(there) => (here, part) = (there, (LONGER * part).min(1.0)),
                None if length <= CONVERGED_STEP.max(tolerance / here.least) => {
                    x.copy_from_slice(&here.x);
                    return Ok(true);
                }
                None => return Ok(false),
            }
        }
        Ok(false)
    }

    /// `D (x - w)`.
    fn left(&self, x: &[f64]) -> Vec<f64> {
        let difference: Vec<f64> = x.iter().zip(&self.wanted).map(|(x, wanted)| x - wanted).collect();
        (&self.root * nalgebra::DVector::from(difference)).as_slice().to_vec()
    }
}

/// Roots within bounds, each found from a nearby point by the smallest step in the norm of the form.
struct Roots<'a> {
    form: &'a Form,
    system: &'a mut dyn LeastSquares,
    bounds: &'a Bounds,
    tolerance: f64,
    counters: &'a mut Counters,
}

/// A point with the equations linearised there, in terms of orthonormal combinations of the unknowns, with the smallest significant
/// singular value. A weight large enough for equations that hardly depend on the unknowns would make the rounding errors of the others
/// larger than the form; orthonormal combinations avoid this.
struct Place {
    x: Vec<f64>,
    rows: Matrix,
    values: Vec<f64>,
    least: f64,
}

impl Place {
    /// `None` if a number is not finite.
    fn new(x: Vec<f64>, residual: &[f64], jacobian: &Matrix) -> Option<Self> {
        let (left, values, right) = full_svd(jacobian)?;
        let largest = values.iter().copied().fold(0.0, f64::max);
        let rank = values.iter().filter(|value| **value > RANK * largest).count();
        let along = |k: usize| (0..residual.len()).map(|i| left[(i, k)] * residual[i]).sum::<f64>();
        let least = values[..rank].last().copied().unwrap_or(f64::INFINITY);
        let values = (0..rank).map(|k| along(k) / values[k]).collect();
        Some(Self { x, rows: right.columns(0, rank).transpose(), values, least })
    }
}

impl Roots<'_> {
    /// `None` if none is found, or a number is not finite.
    fn nearest(&mut self, mut x: Vec<f64>) -> Result<Option<Place>, Interrupted> {
        let (m, n) = (self.system.equations(), x.len());
        let (mut residual, mut jacobian) = (vec![0.0; m], Matrix::zeros(m, n));
        for _ in 0..MAX_RETURNS {
            self.system.residual(&x, &mut residual)?;
            self.system.jacobian(&x, &mut jacobian)?;
            self.counters.jacobians += 1;
            if !jacobian.iter().chain(&residual).all(|number| number.is_finite()) {
                return Ok(None);
            }
            let Some(here) = Place::new(x, &residual, &jacobian) else { return Ok(None) };
            if norm(&residual) <= self.tolerance {
                return Ok(Some(here));
            }
            let back: Vec<f64> = here.values.iter().map(|value| -value).collect();
            let step = self.step(&here, &back, &vec![0.0; n]);
            let bounds = self.bounds.lower.iter().zip(&self.bounds.upper);
            let moved = here.x.iter().zip(step).zip(bounds);
            x = moved.map(|((x, step), (lower, upper))| (x + step).clamp(*lower, *upper)).collect();
        }
        Ok(None)
    }

    /// The step within bounds that best fulfils the equations and, second, the desired change of `D x`.
    fn step(&self, here: &Place, of_equations: &[f64], of_form: &[f64]) -> Vec<f64> {
        let (rank, n) = here.rows.shape();
        let mut columns = Matrix::zeros(rank + n, n);
        columns.rows_mut(0, rank).copy_from(&(&here.rows * FIRST));
        columns.rows_mut(rank, n).copy_from(&self.form.root);
        let wanted: Vec<f64> =
            of_equations.iter().map(|x| FIRST * x).chain(of_form.iter().copied()).collect();
        let within =
            |bound: &[f64]| bound.iter().zip(&here.x).map(|(bound, x)| bound - x).collect::<Vec<_>>();
        bounded_least_squares(&columns, &wanted, &within(&self.bounds.lower), &within(&self.bounds.upper))
    }
}

/// `r (R + y)` and `D (x - w)`.
struct Augmented<'a> {
    form: &'a Form,
    system: &'a mut dyn LeastSquares,
    multipliers: Vec<f64>,
    weight: f64,
}

impl NonlinearSystem for Augmented<'_> {
    fn unknowns(&self) -> usize {
        self.system.unknowns()
    }

    fn equations(&self) -> usize {
        self.multipliers.len() + self.system.unknowns()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        let (of_system, of_form) = residual.split_at_mut(self.multipliers.len());
        self.system.residual(x, of_system)?;
        for (residual, multiplier) in of_system.iter_mut().zip(&self.multipliers) {
            *residual = self.weight * (*residual + multiplier);
        }
        of_form.fill(0.0);
        for (k, column) in self.form.root.column_iter().enumerate() {
            let difference = x[k] - self.form.wanted[k];
            of_form.iter_mut().zip(column.iter()).for_each(|(sum, entry)| *sum += entry * difference);
        }
        Ok(())
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        let (m, n) = (self.multipliers.len(), x.len());
        let mut of_system = Matrix::zeros(m, n);
        self.system.jacobian(x, &mut of_system)?;
        jacobian.rows_mut(0, m).copy_from(&(of_system * self.weight));
        jacobian.rows_mut(m, n).copy_from(&self.form.root);
        Ok(())
    }
}

impl LeastSquares for Augmented<'_> {}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of three unknowns, and a curved surface with a weight of one millionth.
    struct Weak;

    const WEAK: f64 = 1e-6;

    impl NonlinearSystem for Weak {
        fn unknowns(&self) -> usize {
            3
        }

        fn equations(&self) -> usize {
            2
        }

        fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
            residual[0] = x[0] + x[1] + x[2] - 3.0;
            residual[1] = WEAK * (x[0] * x[0] + x[1] - 3.0 * x[2] - 1.0);
            Ok(())
        }

        fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
            jacobian.copy_from(&Matrix::from_row_slice(
                2,
                3,
                &[1.0, 1.0, 1.0, WEAK * 2.0 * x[0], WEAK, -3.0 * WEAK],
            ));
            Ok(())
        }
    }

    impl LeastSquares for Weak {}

    /// The roots are a curve: `x1 = (10 - 3 a - a^2) / 4` and `x2 = 3 - a - x1` for a = x0.
    #[test]
    fn an_equation_that_hardly_matters_is_kept() {
        let on_curve = |a: f64| {
            let b = (10.0 - 3.0 * a - a * a) / 4.0;
            [a, b, 3.0 - a - b]
        };
        let size = |x: [f64; 3]| x.into_iter().map(|x| x * x).sum::<f64>();
        let best = (0..2_000_001)
            .map(|k| f64::from(k) * 1e-6)
            .min_by(|a, b| size(on_curve(*a)).total_cmp(&size(on_curve(*b))))
            .map(on_curve)
            .unwrap();
        let mut x = on_curve(0.1);
        let bounds = Bounds { lower: vec![0.0; 3], upper: vec![f64::INFINITY; 3] };
        let form = Form { root: Matrix::identity(3, 3), wanted: vec![0.0; 3] };
        let mut counters = Counters::default();
        let is_settled = form.slide(&mut Weak, &mut x, &bounds, 1e-11, &mut counters).unwrap();
        assert!(is_settled, "{x:?}");
        for (found, best) in x.iter().zip(best) {
            assert!((found - best).abs() < 1e-4, "{x:?}, not {best:?}");
        }
    }
}
