//! Equilibria without inertia that Newton's method does not find, or finds by going through surfaces.
//!
//! Where contacts begin or let go, the next equilibrium is far away. It is where the shape comes to rest as it goes down the potential
//! of a step: elastic energy, loads and contacts, and what damping dissipates from the start of the step. Increments are shortened by the work of the residual in them, as in [`Search`], and where they would lead through a surface.
//! Where the Jacobian is not positive definite, or increments have been shortened much, a multiple of the mass matrix is added, so that
//! all parts of a body have the same resistance to motion (Levenberg 1944; in this metric the way is that of an overdamped motion).
//!
//! Friction has a potential of the step's displacements if the normal forces by which it is multiplied are held (Li et al. 2020, section 5). Without
//! that, the Jacobian of what slides is indefinite by a quarter of the contact stiffness times the square of the coefficient of friction, so that
//! shifts were as large as that. Normal forces are therefore held, along rods, at those of the last equilibrium, and taken anew from the one that
//! is found, two or three times; Newton's method goes on from there with those that act.

use super::super::linear_system::LinearSystem;
use super::super::numbers::Numbers;
use super::super::search::Search;
use super::super::trial::Trial;
use super::{Corrector, Friction};
use crate::error::Interrupted;
use crate::integrators::second_order::{Counters, Failure, SecondOrderSystem, Solved, model_at};
use crate::model::{FrictionTreatment, InImpact, Radius, have_tunnelled};
use crate::numerics::linalg::{Matrix, dot};

/// Maximum number of increments. Catheters in bent vessels take 10 to 150, with much friction up to all: with 200 a nitinol wire with friction
/// of 0.2 takes 1.7 times the iterations, as steps in parts take over a thousand.
const MOST_INCREMENTS: usize = 400;

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

/// The same with any shift: where increments are shortened at a kink from side to side, the shift stays.
const VERY_NEAR: f64 = 1e-7;

/// The first equilibrium with held friction is only needed so far: its normal forces are those of the last step.
const NEAR_THE_FIRST: f64 = 1e-3;

/// The shift is reduced if the work that is left of an increment deviates by less than this part of its work from that of linear forces.
const LINEAR: f64 = 0.25;

/// Longest increment, in sizes of coordinates. Longer ones lead through walls; of each of these four evaluations and a Jacobian were in vain.
const LONGEST: f64 = 0.1;

/// Where a step without inertia begins: time, shape, and rates of the last step.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Origin<'a> {
    pub(in super::super) t: f64,
    pub(in super::super) q: &'a [f64],
    pub(in super::super) v: &'a [f64],
}

/// Which part of an increment was made, and by which part of its work what is left deviates from what linear forces would leave.
#[derive(Clone, Copy, Debug)]
struct Advance {
    length: f64,
    deviation: f64,
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
        let holds_friction = system.facts().has_dry_friction;
        if holds_friction {
            // As in the last equilibrium: the guess may be deep in a surface.
            counters.nfev += 1;
            system.residual(origin.t, origin.q, origin.v, last, &mut self.residual)?;
            model_at(system, origin.t)?.treat_friction(FrictionTreatment::Held);
        }
        let found = self.descend(system, trial, last, h, counters);
        if holds_friction && let Some(model) = system.model() {
            model.treat_friction(FrictionTreatment::Exact);
        }
        found
    }

    /// The same, from a trial. Held friction takes the normal forces of each equilibrium with those of the one before.
    fn descend<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        last: &[f64],
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        self.evaluate_residual(system, trial, counters)?;
        let mut dense = LinearSystem::of_size(trial.q.len(), 0);
        let weights = std::mem::replace(&mut trial.weights, [0.0, 0.0, 1.0]);
        let mass = self.dense_jacobian(system, trial, h, &mut dense, counters);
        trial.weights = weights;
        let mut damping = Damping { mass: mass?, shift: 0.0 };
        let holds_friction = system.facts().has_dry_friction;
        let mut is_first = holds_friction;
        for _ in 0..MOST_INCREMENTS {
            let jacobian = self.dense_jacobian(system, trial, h, &mut dense, counters)?;
            let unit = self.scaled_trace(&jacobian).abs() / self.scaled_trace(&damping.mass);
            self.set_displacements(trial, h);
            if !self.damped_increment(&jacobian, unit, &mut damping) {
                return Ok(Err(Failure::SingularJacobian));
            }
            let moved = self.displacement();
            if is_first && damping.shift == 0.0 && moved <= NEAR_THE_FIRST {
                is_first = false;
                model_at(system, trial.t)?.treat_friction(FrictionTreatment::Held);
                self.evaluate_residual(system, trial, counters)?;
                continue;
            }
            if damping.shift == 0.0 && moved <= NEAR || moved <= VERY_NEAR {
                let outcome = self.arrive(system, trial, last, h, counters)?;
                if outcome.is_ok() || !holds_friction {
                    return Ok(outcome);
                }
                model_at(system, trial.t)?.treat_friction(FrictionTreatment::Held);
                self.evaluate_residual(system, trial, counters)?;
                continue;
            }
            let Advance { length, deviation } = self.shorten(system, trial, &damping, counters)?;
            if length < SHORT {
                damping.shift = (STRONGER * damping.shift).max(SMALLEST_SHIFT * unit);
            } else if length == 1.0 && deviation < LINEAR {
                damping.shift *= WEAKER;
                if damping.shift < SMALLEST_SHIFT * unit {
                    damping.shift = 0.0;
                }
            }
        }
        Ok(Err(Failure::NotConverged))
    }

    /// Newton's method from a shape that is nearly the equilibrium, with the normal forces that act. After a failure the trial is back there,
    /// where its residual with these has been evaluated.
    fn arrive<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        last: &[f64],
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        let (place, accelerations) = (trial.q.to_vec(), trial.a.to_vec());
        model_at(system, trial.t)?.treat_friction(FrictionTreatment::Exact);
        let solved = self.with_fresh_jacobians(system, trial, [last; 2], h, Friction::Exact, counters)?;
        let passes = solved.is_ok() && passes_through(system, trial.t, [&place, &trial.q])?;
        let outcome = if passes { Err(Failure::PassedThrough) } else { solved };
        if outcome.is_err() {
            trial.set(&accelerations);
            self.evaluate_residual(system, trial, counters)?;
        }
        Ok(outcome)
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

    /// Computes the increment with the smallest shift, not below the given one, at which the symmetric part of the Jacobian is positive definite
    /// and the increment is not too long. Returns whether there is one.
    fn damped_increment(&mut self, jacobian: &Matrix, unit: f64, damping: &mut Damping) -> bool {
        let symmetric = 0.5 * (jacobian + jacobian.transpose());
        loop {
            let is_definite = (&symmetric + damping.shift * &damping.mass).cholesky().is_some();
            if is_definite {
                self.increment.copy_from_slice(&self.residual);
                let mut increment =
                    nalgebra::DVectorViewMut::from_slice(&mut self.increment, jacobian.nrows());
                if !(jacobian + damping.shift * &damping.mass).lu().solve_mut(&mut increment) {
                    return false;
                }
                if self.displacement() <= LONGEST {
                    return true;
                }
            }
            damping.shift = (STRONGER * damping.shift).max(SMALLEST_SHIFT * unit);
            // Without any stiffness bodies fall, with inertia. Not finite as well.
            let is_possible = unit > 0.0 && damping.shift <= LARGEST_SHIFT * unit;
            if !is_possible {
                return false;
            }
        }
    }

    /// Adds the increment to a trial, shortened until it leads through no surface and little of its work is left. Its length is zero if none is
    /// short enough.
    fn shorten<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        damping: &Damping,
        counters: &mut Counters,
    ) -> Result<Advance, Interrupted> {
        let n = trial.q.len();
        let place = trial.q.to_vec();
        self.start.copy_from_slice(&trial.a);
        self.direction.copy_from_slice(&self.increment);
        let work_before = dot(&self.residual[..n], &self.direction[..n]);
        let direction = nalgebra::DVectorView::from_slice(&self.direction, n);
        let predicted = damping.shift * (&damping.mass * direction).dot(&direction);
        let mut search = Search::new(work_before);
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
            if search.is_done(work) || search.still_falls(work) {
                return Ok(Advance { length, deviation: (work - predicted).abs() / work_before });
            }
            length = search.shorter(length, work);
        }
        trial.set(&self.start);
        self.evaluate_residual(system, trial, counters)?;
        Ok(Advance { length: 0.0, deviation: f64::INFINITY })
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
