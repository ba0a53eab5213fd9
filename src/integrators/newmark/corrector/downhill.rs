//! Equilibria without inertia that Newton's method does not find, or finds by going through surfaces.
//!
//! Where contacts begin or let go, the next equilibrium is far away. It is where the shape comes to rest as it goes down the potential
//! of a step: elastic energy, loads and contacts, and what damping dissipates from the start of the step. Increments are shortened by the work of the residual in them, as in [`Search`], and where they would lead through a surface.
//! Where the Jacobian is not positive definite, or increments have been shortened much, a multiple of the mass matrix is added, so that
//! all parts of a body have the same resistance to motion (Levenberg 1944; in this metric the way is that of an overdamped motion).

use super::super::linear_system::LinearSystem;
use super::super::numbers::Numbers;
use super::super::search::Search;
use super::super::trial::Trial;
use super::{Corrector, Friction};
use crate::error::Interrupted;
use crate::integrators::second_order::{Counters, Failure, SecondOrderSystem, Solved, model_at};
use crate::model::{Radius, have_tunnelled};
use crate::numerics::linalg::{Matrix, dot};

/// Maximum number of increments. Catheters in bent vessels take 10 to 150.
const MOST_INCREMENTS: usize = 200;

/// Maximum number of times that an increment is shortened.
const MOST_CUTS: usize = 8;

/// The shift is multiplied by the first factor where the Jacobian is not positive definite or an increment has been shortened to less
/// than [`SHORT`], and by the second one after one that was not shortened.
const STRONGER: f64 = 8.0;
const WEAKER: f64 = 0.1;
const SHORT: f64 = 0.3;

/// The smallest and the largest shift, in units of the ratio of the traces of Jacobian and mass matrix, of coordinates in units of their sizes.
const SMALLEST_SHIFT: f64 = 1e-9;
const LARGEST_SHIFT: f64 = 1e12;

/// Newton's method goes on from where an increment without shift moves coordinates by less than this part of their sizes.
const NEAR: f64 = 1e-5;

/// Where a step without inertia begins: time, shape, and rates of the last step.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Origin<'a> {
    pub(in super::super) t: f64,
    pub(in super::super) q: &'a [f64],
    pub(in super::super) v: &'a [f64],
}

/// Metric of the shift, and the shift itself.
struct Damping {
    mass: Matrix,
    shift: f64,
}

impl<V: Numbers> Corrector<V> {
    /// Finds the equilibrium of a step without inertia downhill from its start. `last` are the accelerations there, zeros. Allocates.
    pub(in super::super) fn go_downhill<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        origin: Origin<'_>,
        last: &[f64],
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        self.begin(trial, last, last, h);
        (self.kept, self.increments) = (None, 0);
        if !begins_in_front(system, trial, origin, h)? {
            return Ok(Err(Failure::PassedThrough));
        }
        self.evaluate_residual(system, trial, counters)?;
        let mut dense = LinearSystem::of_size(trial.q.len(), 0);
        let weights = std::mem::replace(&mut trial.weights, [0.0, 0.0, 1.0]);
        let mass = self.dense_jacobian(system, trial, h, &mut dense, counters);
        trial.weights = weights;
        let mut damping = Damping { mass: mass?, shift: 0.0 };
        for _ in 0..MOST_INCREMENTS {
            let jacobian = self.dense_jacobian(system, trial, h, &mut dense, counters)?;
            let unit = self.scaled_trace(&jacobian).abs() / self.scaled_trace(&damping.mass);
            self.set_displacements(trial, h);
            if !self.damped_increment(&jacobian, unit, &mut damping) {
                return Ok(Err(Failure::SingularJacobian));
            }
            if damping.shift == 0.0 && self.displacement() <= NEAR {
                let place = trial.q.to_vec();
                let solved =
                    self.with_fresh_jacobians(system, trial, [last; 2], h, Friction::Exact, counters)?;
                let passes = solved.is_ok() && passes_through(system, trial.t, [&place, &trial.q])?;
                return Ok(if passes { Err(Failure::PassedThrough) } else { solved });
            }
            let length = self.shorten(system, trial, counters)?;
            if length < SHORT {
                damping.shift = (STRONGER * damping.shift).max(SMALLEST_SHIFT * unit);
            } else if length == 1.0 {
                damping.shift *= WEAKER;
                if damping.shift < SMALLEST_SHIFT * unit {
                    damping.shift = 0.0;
                }
            }
        }
        Ok(Err(Failure::NotConverged))
    }

    /// The derivative of the residual at a trial with respect to accelerations, for its weights.
    fn dense_jacobian<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial<V>,
        h: f64,
        dense: &mut LinearSystem,
        counters: &mut Counters,
    ) -> Result<Matrix, Interrupted> {
        self.jacobian.evaluate(system, trial, &self.residual, h, dense, counters)?;
        match dense {
            LinearSystem::Dense { jacobian, .. } => Ok(jacobian.clone()),
            _ => unreachable!("made dense"),
        }
    }

    /// The trace of a matrix of the coordinates in units of their sizes.
    fn scaled_trace(&self, matrix: &Matrix) -> f64 {
        matrix
            .diagonal()
            .iter()
            .zip(self.inverse_sizes.iter())
            .map(|(entry, inverse)| entry / (inverse * inverse))
            .sum()
    }

    /// Computes the increment with the smallest shift, not below the given one, at which the symmetric part of the Jacobian is positive definite.
    /// Returns whether there is one.
    fn damped_increment(&mut self, jacobian: &Matrix, unit: f64, damping: &mut Damping) -> bool {
        let symmetric = 0.5 * (jacobian + jacobian.transpose());
        while (&symmetric + damping.shift * &damping.mass).cholesky().is_none() {
            damping.shift = (STRONGER * damping.shift).max(SMALLEST_SHIFT * unit);
            // Without any stiffness bodies fall, with inertia. Not finite as well.
            let is_possible = unit > 0.0 && damping.shift <= LARGEST_SHIFT * unit;
            if !is_possible {
                return false;
            }
        }
        self.increment.copy_from_slice(&self.residual);
        let mut increment = nalgebra::DVectorViewMut::from_slice(&mut self.increment, jacobian.nrows());
        (jacobian + damping.shift * &damping.mass).lu().solve_mut(&mut increment)
            && self.increment.iter().all(|a| a.is_finite())
    }

    /// Adds the increment to a trial, shortened until it leads through no surface and little of its work is left. Returns its length, zero if
    /// none is short enough.
    fn shorten<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        counters: &mut Counters,
    ) -> Result<f64, Interrupted> {
        let n = trial.q.len();
        let place = trial.q.to_vec();
        self.start.copy_from_slice(&trial.a);
        self.direction.copy_from_slice(&self.increment);
        let mut search = Search::new(dot(&self.residual[..n], &self.direction[..n]));
        let mut length = 1.0;
        for _ in 0..=MOST_CUTS {
            for (increment, direction) in self.increment.iter_mut().zip(self.direction.iter()) {
                *increment = length * direction;
            }
            trial.set(&self.start);
            trial.subtract(&self.increment);
            if passes_through(system, trial.t, [&place, &trial.q])? {
                length *= 0.5;
                continue;
            }
            self.evaluate_residual(system, trial, counters)?;
            let work = dot(&self.residual[..n], &self.direction[..n]);
            if search.is_done(work) {
                return Ok(length);
            }
            length = search.shorter(length, work);
        }
        trial.set(&self.start);
        self.evaluate_residual(system, trial, counters)?;
        Ok(0.0)
    }
}

/// Whether surfaces pass through each other between two shapes at a time.
fn passes_through<S: SecondOrderSystem + ?Sized>(
    system: &mut S,
    t: f64,
    shapes: [&[f64]; 2],
) -> Result<bool, Interrupted> {
    have_tunnelled(model_at(system, t)?, shapes.into_iter().map(|q| (t, q)), Radius::Smaller)
}

/// Sets a trial to the shape that goes on with the rates of the last step, or to that at the start of the step, if nothing passes through a surface on
/// the way. Returns whether there is such a shape.
fn begins_in_front<S: SecondOrderSystem + ?Sized, V: Numbers>(
    system: &mut S,
    trial: &mut Trial<V>,
    origin: Origin<'_>,
    h: f64,
) -> Result<bool, Interrupted> {
    for rate in [1.0, 0.0] {
        let guess: Vec<f64> = origin.v.iter().map(|v| rate * v / h).collect();
        trial.set(&guess);
        let way = [(origin.t, origin.q), (trial.t, &trial.q[..])];
        if !have_tunnelled(model_at(system, origin.t)?, way.into_iter(), Radius::Smaller)? {
            return Ok(true);
        }
    }
    Ok(false)
}
