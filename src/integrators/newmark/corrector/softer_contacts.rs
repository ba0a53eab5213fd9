//! Newton's method by way of softer contacts.
//!
//! A thin wire that falls on a floor would end a step many radii deep in it. Forces of stiff contacts are so large there that the change
//! of their directions with the shape outweighs inertia and elasticity: the Jacobian is indefinite. An increment that takes the wire off the
//! floor sees no contact in the next iteration. With contacts that are soft enough neither matters, and the solution with softer contacts
//! is a good start for stiffer ones (penalty continuation: Nocedal and Wright 2006, section 17.1). The last solve uses the contacts of
//! the model.

use super::super::numbers::Numbers;
use super::super::search::Search;
use super::super::trial::Trial;
use super::{Corrector, Friction, STIFF_AGAIN};
use crate::integrators::second_order::{Counters, Failure, SecondOrderSystem, Solved};
use crate::model::{InContact, Softened};
use crate::numerics::linalg::dot;

/// Fractions of the stiffness. Steel wires of 0.5 mm on a floor and over an edge need a tenth more iterations if the first is 1e-4; if it is
/// 1e-2, four tenths more on the floor, where more steps are made in parts.
const FRACTIONS: [f64; 3] = [1e-3, 1e-2, 1e-1];

/// Maximum number of iterations with each of them, and how often an increment is shortened at most.
const MAX_SOFT_ITERATIONS: usize = 12;
const MAX_CUTS: usize = 3;

/// A solution with softer contacts is found when an increment moves coordinates by less than this part of their sizes.
const SOFT_MOTION: f64 = 1e-4;

impl<V: Numbers> Corrector<V> {
    /// Newton's method by way of softer contacts, with exact tangents of friction: followed friction needs twice the iterations there.
    pub(super) fn with_softer_contacts<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        [guess, last]: [&[f64]; 2],
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        self.kept = None;
        trial.set(guess);
        let mut approached = Ok(Ok(()));
        for fraction in FRACTIONS {
            soften(system, &trial.q, fraction);
            approached = self.approach(system, trial, [guess, last], h, counters);
            if !matches!(approached, Ok(Ok(()))) {
                break;
            }
        }
        if let Some(model) = system.model() {
            model.soften_contact(None);
        }
        let solved = match approached? {
            Ok(()) => {
                self.with_fresh_jacobians(system, trial, [guess, last], h, Friction::Exact, counters)?
            }
            Err(failure) => Err(failure),
        };
        (self.softly_solved, self.softly_failed) = match solved {
            Ok(()) => (self.softly_solved % STIFF_AGAIN + 1, 0),
            Err(_) => (0, STIFF_AGAIN),
        };
        Ok(solved)
    }

    /// Comes near the solution with the present stiffness. Increments that a few cuts do not make acceptable are taken: better ones
    /// follow mostly.
    fn approach<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        [guess, last]: [&[f64]; 2],
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        let n = trial.q.len();
        self.increments = 0;
        self.evaluate_residual(system, trial, counters)?;
        for _ in 0..MAX_SOFT_ITERATIONS {
            if let Err(failure) = self.evaluate_jacobian(system, trial, h, counters)? {
                return Ok(Err(failure));
            }
            self.set_tolerances(&[guess, last, &trial.a]);
            if !self.size_of_increment().is_finite() {
                return Ok(Err(Failure::NonFinite));
            }
            let moved = self.moved;
            self.start.copy_from_slice(&trial.a);
            self.direction.copy_from_slice(&self.increment);
            let mut search = Search::new(dot(&self.residual[..n], &self.direction[..n]));
            let mut length = 1.0;
            for cut in 0..=MAX_CUTS {
                for (increment, direction) in self.increment.iter_mut().zip(self.direction.iter()) {
                    *increment = length * direction;
                }
                trial.set(&self.start);
                trial.subtract(&self.increment);
                self.evaluate_residual(system, trial, counters)?;
                let work = dot(&self.residual[..n], &self.direction[..n]);
                if search.is_done(work) || !search.has_minimum() || cut == MAX_CUTS {
                    break;
                }
                length = search.shorter(length, work);
            }
            if length == 1.0 && moved <= SOFT_MOTION {
                return Ok(Ok(()));
            }
        }
        Ok(Err(Failure::NotConverged))
    }
}

fn soften<S: SecondOrderSystem + ?Sized>(system: &mut S, start: &[f64], fraction: f64) {
    if let Some(model) = system.model() {
        model.soften_contact(Some(Softened { forces: &[], fraction, enlargement: 0.0, start }));
    }
}
