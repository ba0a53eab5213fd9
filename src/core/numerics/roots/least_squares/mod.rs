//! Least squares within bounds: `min |R(x)|^2 / 2` with `lower <= x <= upper`, for any number of equations.
//!
//! Steps minimise a quadratic model in a trust region: the Gauss-Newton model (Levenberg 1944; Moré 1978) if
//! it converges fast, otherwise Newton's model with second derivatives of R by differences (Dennis, Gay and
//! Welsch 1981). Problems without a root thus converge as fast as those with one. Where the gradient
//! vanishes, the second derivatives distinguish a minimum from a saddle or a maximum, which is left along its
//! most negative curvature.
//!
//! `model` is the quadratic model with its steps within the bounds, `region` minimises it in a ball, and
//! `preferred` selects among roots.

mod bounds;
mod model;
mod preferred;
mod region;

pub use self::preferred::Form;

pub use self::bounds::Bounds;
use self::model::{Model, Step};
use super::NonlinearSystem;
use crate::error::{Interrupted, Unfinished};
use crate::numerics::linalg::{Matrix, norm};

/// Initial radius of the trust region, for unknowns of order one.
const FIRST_RADIUS: f64 = 1.0;

/// Largest radius: beyond, models of rotations are invalid.
const LARGEST_RADIUS: f64 = 4.0;

/// The search stalls when the radius falls below this value.
const SMALLEST_RADIUS: f64 = 1e-12;

/// A step is accepted if it achieves the fraction `ACCEPTED_RATIO` of the predicted decrease. Below `POOR_RATIO` the radius
/// shrinks to a quarter of the step, above `GOOD_RATIO` it may double (Conn, Gould and Toint 2000, section 6.1).
const ACCEPTED_RATIO: f64 = 1e-4;
const POOR_RATIO: f64 = 0.25;
const GOOD_RATIO: f64 = 0.75;

/// After a step that leaves more than `SLOW` of |R|, the search switches from the Gauss-Newton model to
/// Newton's; after a step that leaves less than `FAST` it switches back, because Gauss-Newton converges
/// quadratically near a root without second derivatives. A double root, at which a Gauss-Newton step leaves a
/// quarter, lies in between.
const SLOW: f64 = 0.5;
const FAST: f64 = 0.1;

/// Rounding error of |R|^2, relative to |R| times the size of the terms of R.
const ROUNDING: f64 = 10.0 * f64::EPSILON;

/// A bound is inactive if the gradient at it, relative to |R|, is smaller than this.
const NO_PUSH: f64 = 1e-7;

/// A least-squares system with knowledge about its unknowns.
pub trait LeastSquares: NonlinearSystem {
    /// Replaces an iterate by an equivalent better one, such as a shorter rotation vector.
    fn renew(&mut self, _x: &mut [f64]) {}
}

/// Options of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Norms |R| up to this value count as zero.
    pub tolerance: f64,
    /// Size of the terms whose difference is R; determines the rounding error.
    pub terms: f64,
    /// Maximum number of steps.
    pub max_iter: usize,
    /// Where second derivatives of R are computed.
    pub second_order: SecondOrder,
}

/// Where a search computes second derivatives of R, which cost one Jacobian per unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SecondOrder {
    /// From the start: useful if R does not vanish at the solution.
    FromStart,
    /// After steps of the Gauss-Newton model that converge slowly, and where the gradient vanishes.
    WhereSlow,
    /// Nowhere: for many unknowns with small residuals. Convergence is linear, with a rate proportional to the
    /// residual, and [`End::Minimum`] is judged by the gradient alone.
    Never,
}

/// Status of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// A root was found.
    Root,
    /// A minimum was found, by its gradient and, unless they are left out, second derivatives.
    Minimum,
    /// The limit of iterations was reached.
    IterationLimit,
    /// No step, however short, reduces |R|; or R is not finite at the end of every step.
    Stalled,
    /// R or its Jacobian is not finite at the start or at an iterate.
    NonFinite,
    /// The system asked to stop.
    Interrupted,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Status.
    pub end: End,
    /// |R| at the result.
    pub norm: f64,
    /// Unknowns at active bounds.
    pub at_bounds: Vec<usize>,
    /// Counts of steps and evaluations.
    pub counters: Counters,
}

/// Cost of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Accepted steps.
    pub iterations: usize,
    /// Evaluations of R.
    pub residuals: usize,
    /// Evaluations of the Jacobian of R.
    pub jacobians: usize,
}

impl std::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.residuals += other.residuals;
        self.jacobians += other.jacobians;
    }
}

/// Searches from `x`, clipped to the bounds; `x` becomes the best point found, also after an interruption. Unknowns should be of order
/// one. Allocates. An iteration costs a Jacobian and the eigenvectors of a matrix whose size is the smaller
/// of the numbers of unknowns and equations; with second derivatives, one Jacobian per unknown and the
/// eigenvectors of a matrix of their number.
///
/// # Panics
/// If the sizes of x or of the bounds do not match the system.
pub fn solve(
    system: &mut dyn LeastSquares,
    x: &mut [f64],
    bounds: &Bounds,
    options: &Options,
) -> Result<Outcome, Unfinished<Outcome>> {
    let (n, m) = (system.unknowns(), system.equations());
    assert_eq!([x.len(), bounds.lower.len(), bounds.upper.len()], [n; 3], "lengths of x and of its bounds");
    bounds.clip(x);
    let mut search = Search {
        system,
        bounds,
        options,
        residual: vec![0.0; m],
        norm: f64::NAN,
        jacobian: Matrix::zeros(m, n),
        radius: FIRST_RADIUS,
        second_order: options.second_order == SecondOrder::FromStart,
        trial_x: x.to_vec(),
        trial_residual: vec![0.0; m],
        counters: Counters::default(),
    };
    let end = search.run(x).unwrap_or(End::Interrupted);
    let at_bounds = if end == End::Interrupted { Vec::new() } else { search.at_bounds(x) };
    let outcome = Outcome { end, norm: search.norm, at_bounds, counters: search.counters };
    if end == End::Interrupted { Err(Unfinished::new(outcome)) } else { Ok(outcome) }
}

struct Search<'a> {
    system: &'a mut dyn LeastSquares,
    bounds: &'a Bounds,
    options: &'a Options,
    residual: Vec<f64>,
    norm: f64,
    jacobian: Matrix,
    radius: f64,
    second_order: bool,
    trial_x: Vec<f64>,
    trial_residual: Vec<f64>,
    counters: Counters,
}

/// Result of a search for a step.
enum Trial {
    Taken,
    Ended(End),
}

impl Search<'_> {
    fn run(&mut self, x: &mut [f64]) -> Result<End, Interrupted> {
        self.counters.residuals += 1;
        self.system.residual(x, &mut self.residual)?;
        self.norm = norm(&self.residual);
        while self.norm.is_finite() {
            if self.norm <= self.options.tolerance {
                return Ok(End::Root);
            }
            self.counters.jacobians += 1;
            self.system.jacobian(x, &mut self.jacobian)?;
            if !self.jacobian.iter().all(|entry| entry.is_finite()) {
                break;
            }
            if self.counters.iterations == self.options.max_iter {
                return Ok(End::IterationLimit);
            }
            if let Trial::Ended(end) = self.find_step(x)? {
                return Ok(end);
            }
            self.system.renew(x);
        }
        Ok(End::NonFinite)
    }

    /// Moves x by a step that reduces |R|, if there is one.
    fn find_step(&mut self, x: &mut [f64]) -> Result<Trial, Interrupted> {
        let mut curvature = if self.second_order { Some(self.curvature(x)?) } else { None };
        loop {
            let model = Model::new(&self.jacobian, &self.residual, curvature.as_ref());
            let step = model.step(x, self.bounds, self.radius);
            if step.predicted <= ROUNDING * self.norm * (self.norm + self.options.terms) {
                if curvature.is_some() || self.options.second_order == SecondOrder::Never {
                    self.polish(x, &step)?;
                    return Ok(Trial::Ended(End::Minimum));
                }
                // The point may be a saddle: check with second derivatives.
                self.second_order = true;
                curvature = Some(self.curvature(x)?);
                continue;
            }
            let length = norm(&step.x);
            let there = self.try_step(x, &step)?;
            let reduction = 0.5 * (self.norm - there) * (self.norm + there);
            let ratio = if there.is_finite() { reduction / step.predicted } else { 0.0 };
            if ratio < POOR_RATIO {
                self.radius = 0.25 * length;
            } else if ratio > GOOD_RATIO && length > 0.5 * self.radius {
                self.radius = (2.0 * self.radius).min(LARGEST_RADIUS);
            }
            if ratio > ACCEPTED_RATIO {
                let left = there / self.norm;
                let is_slow = left > SLOW || (self.second_order && left > FAST);
                self.second_order = is_slow && self.options.second_order != SecondOrder::Never;
                self.take(x, there);
                return Ok(Trial::Taken);
            }
            if self.radius < SMALLEST_RADIUS {
                return Ok(Trial::Ended(End::Stalled));
            }
        }
    }

    /// |R| at the end of a step.
    fn try_step(&mut self, x: &[f64], step: &Step) -> Result<f64, Interrupted> {
        for (i, trial) in self.trial_x.iter_mut().enumerate() {
            // Rounding must not leave the bounds.
            *trial = self.bounds.nearest(i, x[i] + step.x[i]);
        }
        self.counters.residuals += 1;
        self.system.residual(&self.trial_x, &mut self.trial_residual)?;
        Ok(norm(&self.trial_residual))
    }

    fn take(&mut self, x: &mut [f64], norm: f64) {
        x.copy_from_slice(&self.trial_x);
        std::mem::swap(&mut self.residual, &mut self.trial_residual);
        self.norm = norm;
        self.counters.iterations += 1;
    }

    /// The last step, whose gain is below rounding: its gradient is still accurate to many digits.
    fn polish(&mut self, x: &mut [f64], step: &Step) -> Result<(), Interrupted> {
        let there = self.try_step(x, step)?;
        if there <= self.norm * (1.0 + ROUNDING) {
            self.take(x, there);
        }
        Ok(())
    }

    /// `sum_i R_i d^2 R_i / dx^2`, by forward differences of the Jacobian.
    fn curvature(&mut self, x: &[f64]) -> Result<Matrix, Interrupted> {
        let n = x.len();
        let mut sum = Matrix::zeros(n, n);
        let mut there = self.jacobian.clone();
        let mut shifted = x.to_vec();
        for k in (0..n).filter(|&k| self.bounds.lower[k] < self.bounds.upper[k]) {
            shifted[k] = x[k] + model::INCREMENT * x[k].abs().max(1.0);
            let increment = shifted[k] - x[k];
            self.counters.jacobians += 1;
            self.system.jacobian(&shifted, &mut there)?;
            shifted[k] = x[k];
            for j in 0..n {
                let (here, there) = (self.jacobian.column(j), there.column(j));
                let change = there.iter().zip(here.iter()).zip(&self.residual);
                sum[(j, k)] = change.map(|((there, here), r)| (there - here) * r).sum::<f64>() / increment;
            }
        }
        Ok(crate::numerics::linalg::symmetric_part(&sum))
    }

    /// Unknowns at bounds beyond which |R| would decrease.
    fn at_bounds(&self, x: &[f64]) -> Vec<usize> {
        let model = Model::new(&self.jacobian, &self.residual, None);
        let is_held = |&i: &usize| {
            let push = model.gradient()[i];
            let least = NO_PUSH * self.norm;
            (x[i] <= self.bounds.lower[i] && push > least) || (x[i] >= self.bounds.upper[i] && push < -least)
        };
        (0..x.len()).filter(is_held).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equations with a row-major Jacobian.
    struct Equations<F, J>(usize, usize, F, J);

    impl<F: Fn(&[f64]) -> Vec<f64>, J: Fn(&[f64]) -> Vec<f64>> NonlinearSystem for Equations<F, J> {
        fn unknowns(&self) -> usize {
            self.0
        }

        fn equations(&self) -> usize {
            self.1
        }

        fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
            residual.copy_from_slice(&(self.2)(x));
            Ok(())
        }

        fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
            jacobian.copy_from(&Matrix::from_row_slice(self.1, self.0, &(self.3)(x)));
            Ok(())
        }
    }

    impl<F: Fn(&[f64]) -> Vec<f64>, J: Fn(&[f64]) -> Vec<f64>> LeastSquares for Equations<F, J> {}

    const OPTIONS: Options =
        Options { tolerance: 1e-12, terms: 1.0, max_iter: 100, second_order: SecondOrder::WhereSlow };

    /// Two links of length one, whose end should reach a point.
    fn arm(target: [f64; 2]) -> impl LeastSquares {
        let end = move |x: &[f64]| {
            let both = x[0] + x[1];
            vec![x[0].cos() + both.cos() - target[0], x[0].sin() + both.sin() - target[1]]
        };
        let jacobian = |x: &[f64]| {
            let both = x[0] + x[1];
            vec![-x[0].sin() - both.sin(), -both.sin(), x[0].cos() + both.cos(), both.cos()]
        };
        Equations(2, 2, end, jacobian)
    }

    fn ends(target: [f64; 2], mut x: [f64; 2], bounds: &Bounds) -> (Outcome, [f64; 2]) {
        let outcome = solve(&mut arm(target), &mut x, bounds, &OPTIONS).unwrap();
        (outcome, x)
    }

    #[test]
    fn roots_are_found_from_where_the_gradient_vanishes() {
        // Stretched towards the target, and folded away from it.
        for (target, start) in [([1.0, 0.0], [0.0, 0.0]), ([1.5, 0.0], [std::f64::consts::PI, 0.0])] {
            let (outcome, x) = ends(target, start, &Bounds::none(2));
            assert_eq!(outcome.end, End::Root, "{x:?}");
            let elbow: f64 = (target[0] * target[0] / 2.0 - 1.0).acos();
            assert!((x[1].abs() - elbow).abs() < 1e-11, "{x:?}");
        }
    }

    #[test]
    fn what_is_out_of_reach_ends_at_the_nearest_point() {
        // Far away, Gauss-Newton steps would converge by a factor of about d / (d + 2).
        for distance in [2.1, 5.0, 1000.0] {
            let target = [0.6 * distance, 0.8 * distance];
            let (outcome, x) = ends(target, [0.3, 0.9], &Bounds::none(2));
            assert_eq!((outcome.end, outcome.at_bounds.len()), (End::Minimum, 0));
            assert!((outcome.norm - (distance - 2.0)).abs() < 1e-12 * distance);
            assert!((x[0] - 0.8_f64.atan2(0.6)).abs() < 1e-7 && x[1].abs() < 1e-7, "{distance}: {x:?}");
            assert!(outcome.counters.iterations < 20, "{distance}: {:?}", outcome.counters);
        }
        // At the boundary of the workspace the root is double.
        let (outcome, _) = ends([2.0, 0.0], [0.3, 0.4], &Bounds::none(2));
        assert_eq!(outcome.end, End::Root);
    }

    #[test]
    fn bounds_hold_back() {
        let bounds = Bounds { lower: vec![-0.2, 0.5], upper: vec![0.2, 1.0] };
        let (outcome, x) = ends([0.0, 1.5], [0.0, 0.7], &bounds);
        assert_eq!((outcome.end, x, outcome.at_bounds), (End::Minimum, [0.2, 1.0], vec![0, 1]));
        // The straight arm is at a bound, so that only one of both ways to bend remains.
        let bounds = Bounds { lower: vec![-9.0, -3.0], upper: vec![9.0, 0.0] };
        let (outcome, x) = ends([1.0, 0.0], [0.0, 0.0], &bounds);
        assert_eq!(outcome.end, End::Root);
        assert!((x[1] + 2.0 * std::f64::consts::FRAC_PI_3).abs() < 1e-11, "{x:?}");
        // With a fixed shoulder the solution is the closest point on the circle of the elbow.
        let bounds = Bounds { lower: vec![0.0, -9.0], upper: vec![0.0, 9.0] };
        let (outcome, x) = ends([3.0, 2.0], [0.0, 0.1], &bounds);
        assert_eq!(outcome.end, End::Minimum);
        assert!((outcome.norm - (8_f64.sqrt() - 1.0)).abs() < 1e-13);
        assert!((x[1] - std::f64::consts::FRAC_PI_4).abs() < 1e-8, "{x:?}");
    }

    #[test]
    fn more_unknowns_than_equations_and_fewer() {
        let mut wide =
            Equations(3, 1, |x: &[f64]| vec![x[0] + x[1] * x[2] - 2.0], |x: &[f64]| vec![1.0, x[2], x[1]]);
        let mut x = [0.0, 0.0, 0.0];
        assert_eq!(solve(&mut wide, &mut x, &Bounds::none(3), &OPTIONS).unwrap().end, End::Root);
        // The line through three points.
        let line = |x: &[f64]| vec![x[0] - 1.0, x[0] + x[1] - 2.0, x[0] + 2.0 * x[1] - 4.0];
        let mut tall = Equations(2, 3, line, |_: &[f64]| vec![1.0, 0.0, 1.0, 1.0, 1.0, 2.0]);
        let mut x = [0.0, 0.0];
        let outcome = solve(&mut tall, &mut x, &Bounds::none(2), &OPTIONS).unwrap();
        assert_eq!(outcome.end, End::Minimum);
        assert!((x[0] - 5.0 / 6.0).abs() < 1e-14 && (x[1] - 1.5).abs() < 1e-14, "{x:?}");
    }

    #[test]
    fn ends_that_are_none_say_so() {
        let mut x = [0.3, 0.4];
        let few = Options { max_iter: 1, ..OPTIONS };
        let outcome = solve(&mut arm([-1.0, 0.5]), &mut x, &Bounds::none(2), &few).unwrap();
        assert_eq!((outcome.end, outcome.counters.iterations), (End::IterationLimit, 1));
        // The root of the square root of x is zero, where its domain ends.
        let mut root =
            Equations(1, 1, |x: &[f64]| vec![x[0].sqrt() + 1.0], |x: &[f64]| vec![0.5 / x[0].sqrt()]);
        let mut x = [0.01];
        let outcome = solve(&mut root, &mut x, &Bounds::none(1), &OPTIONS).unwrap();
        assert!(matches!(outcome.end, End::Stalled | End::NonFinite) && outcome.norm.is_finite());
        let mut x = [-1.0];
        assert_eq!(solve(&mut root, &mut x, &Bounds::none(1), &OPTIONS).unwrap().end, End::NonFinite);
    }
}
