//! The steps of a run that needed more than one attempt.

use crate::integrators::{Reason, Retries};
use crate::model::{Model, Overlap};
use crate::simulation::stepping::Run;

/// A step that was attempted more than once, or whose equations converged slowly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HardStep {
    /// Time at its start in seconds.
    pub t: f64,
    /// Its size in seconds; zero of a step that could not be made, which ended the run.
    pub h: f64,
    /// Attempts of the step and of its parts.
    pub attempts: usize,
    /// How often its shortest part was halved.
    pub halvings: usize,
    /// Newton iterations.
    pub iterations: usize,
    /// Jacobians.
    pub tangents: usize,
    /// Evaluations of the residual, or of the forward dynamics.
    pub evaluations: usize,
    /// Why its first attempt did not make it.
    pub reason: Reason,
    /// Index of the contact that is deepest at its end, or was at its start.
    pub contact: Option<usize>,
}

/// Time and cost of a run before a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct BeforeStep {
    t: f64,
    steps: usize,
    iterations: usize,
    tangents: usize,
    evaluations: usize,
    slow: usize,
}

impl BeforeStep {
    pub(super) fn new<M: Model>(run: &Run<M>) -> Self {
        let counters = run.counters();
        Self {
            t: run.t(),
            steps: counters.steps,
            iterations: counters.newton_iterations,
            tangents: counters.njev,
            evaluations: counters.nfev,
            slow: counters.full_newton,
        }
    }

    pub(super) fn steps(&self) -> usize {
        self.steps
    }
}

/// Collects the hard steps of a run: few in most runs, so that all others cost nothing but a comparison.
#[derive(Debug, Default)]
pub(super) struct HardSteps {
    pub(super) found: Vec<HardStep>,
    /// The deepest contact at the end of the last step.
    contact: Option<usize>,
}

impl HardSteps {
    /// Records what the run did since `before`, if that was hard, and returns its current time and cost.
    pub(super) fn record<M: Model>(
        &mut self,
        run: &mut Run<M>,
        before: &BeforeStep,
        overlap: Option<Overlap>,
    ) -> BeforeStep {
        let Retries { attempts, halvings, reason } = run.take_retries();
        let contact_before = self.contact;
        self.contact = overlap.map(|overlap| overlap.contact);
        let after = BeforeStep::new(run);
        let slow = (after.slow > before.slow).then_some(Reason::SlowConvergence);
        let Some(reason) = reason.or(slow) else { return after };
        self.found.push(HardStep {
            t: before.t,
            h: after.t - before.t,
            attempts,
            halvings,
            iterations: after.iterations - before.iterations,
            tangents: after.tangents - before.tangents,
            evaluations: after.evaluations - before.evaluations,
            reason,
            contact: self.contact.or(contact_before),
        });
        after
    }
}
