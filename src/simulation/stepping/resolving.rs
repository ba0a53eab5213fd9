//! Impacts that steps of fixed size stop: such a step is made once more, by a method that resolves them.
//!
//! What meets within a step should rebound as its law of contact says. An impulse by the masses of the model would not do: for
//! rods the mass at the place of an impact is that of the discretisation, and waves make the rebound. So the law stays as it is, and
//! only the steps in which something rebounds take shorter ones, by Radau's method with an error estimate.

use crate::error::Interrupted;
use crate::integrators::radau;
use crate::integrators::second_order::{Counters, Status};
use crate::model::{Facts, Model};
use crate::numerics::tape::Tape;
use crate::simulation::balance::{FlowMeter, Rule, State};

/// Impacts matter after which surfaces part for more than so many steps. Stopped ones lose no more of a height than `2 g dt^2`, four times
/// what a step without memory does.
const FLIGHT: f64 = 4.0;

/// Tolerance of the steps within, relative to what the step changes velocities by: balls rebound with 1.0000 of their energy, and none is
/// gained but 2e-4. So is that of displacements, relative to these changes times the step.
const TOLERANCE: f64 = 1e-4;

/// Velocities count as changed by this part of the largest change, all in typical sizes: what hardly takes part needs no digits.
const HARDLY: f64 = 1e-4;

/// Numbers of this size relative to places and velocities are rounding, also of those that move along.
const ROUNDING: f64 = 1e-12;

/// Evaluations, times coordinates and parts that may meet each other, for which impacts are resolved however few the others are: a tenth of a
/// second or so. A rod of rubber that falls on its end takes a sixth of it, one a thousand times as stiff most.
const FREE_WORK: usize = 120_000;

/// Beside these, one for so many others.
const OTHERS: usize = 2;

/// A step is tried if that part of what the last one has taken in vain is allowed.
const CHEAPER: usize = 4;

/// How far impacts are resolved in a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Resolving {
    /// Evaluations so far.
    used: usize,
    /// Those of the last step that took more than it was allowed.
    in_vain: usize,
    /// Whether an impact that matters has not been resolved, because of its work.
    is_exhausted: bool,
    /// Whether the last step was resolved and ended within an impact: what is pressed is yet to be given back.
    goes_on: bool,
}

/// A step made once more.
pub(super) struct Resolved {
    /// Displacements, velocities, and accelerations with multipliers behind them.
    pub(super) motion: [Vec<f64>; 3],
    /// Energy dissipated in it, and work.
    pub(super) flow: [f64; 2],
    /// Whether surfaces touch at its end.
    pub(super) touches: bool,
}

/// Tangents count as evaluations of this number.
const TANGENT: usize = 5;

fn work_of(counters: &Counters) -> usize {
    counters.nfev + TANGENT * counters.njev
}

impl Resolving {
    /// Whether impacts matter after which surfaces part for so many steps.
    pub(super) fn matters(flight: f64) -> bool {
        flight > FLIGHT
    }

    /// Whether the step follows on one that was resolved and ended within an impact.
    pub(super) fn goes_on(&self) -> bool {
        self.goes_on
    }

    /// The last step ended within an impact, or not.
    pub(super) fn go_on(&mut self, is_within: bool) {
        self.goes_on = is_within;
    }

    /// Whether impacts that matter have not been resolved, because that would have taken too much work.
    pub(super) fn is_exhausted(&self) -> bool {
        self.is_exhausted
    }

    /// Evaluations that may be made for a step of this model, in a run that has taken this work in all; none where that is not worth a try.
    pub(super) fn allowed(&mut self, facts: &Facts, work: &Counters) -> usize {
        let others = work_of(work).saturating_sub(self.used);
        let free = FREE_WORK / (facts.n * facts.parts.len().max(1)).max(1);
        let allowed = (free + others / OTHERS).saturating_sub(self.used);
        if allowed <= self.in_vain / CHEAPER {
            self.is_exhausted = true;
            return 0;
        }
        allowed
    }

    /// The step of `model` from these displacements and velocities, which has led to the velocities `found`, with what it took; nothing
    /// where it takes more evaluations than are allowed.
    pub(super) fn resolve<M: Model>(
        &mut self,
        model: &mut M,
        t_span: (f64, f64),
        [q, v]: [&[f64]; 2],
        found: &[f64],
        allowed: usize,
    ) -> Result<(Option<Resolved>, Counters), Interrupted> {
        let (n, h) = (q.len(), t_span.1 - t_span.0);
        let of_velocities = tolerances(&model.facts().typical_coordinates, [v, found], h);
        let atol: Vec<f64> =
            of_velocities.iter().map(|atol| h * atol).chain(of_velocities.iter().copied()).collect();
        let options =
            radau::Options { rtol: ROUNDING.into(), atol: atol.into(), ..radau::Options::default() };
        let Ok(mut stepper) = radau::Stepper::new(n, t_span, q, v, &options) else {
            return Ok((None, Counters::default()));
        };
        stepper.set_accuracy(TOLERANCE);
        let mut meter = FlowMeter::new(model, Rule::Quintic, t_span.0, [q, v], Some(&[]));
        let status = loop {
            let status = stepper.step(model)?;
            let state = State { t: stepper.t(), q: stepper.q(), v: stepper.v(), a: stepper.a() };
            if let Some(meter) = &mut meter {
                meter.step(model, state)?;
            }
            if status.is_some() || work_of(&stepper.counters()) > allowed {
                break status;
            }
        };
        let work = stepper.counters();
            eprintln!("t {:.4} h {h} work {:?}", t_span.0, work);
        }
        self.used += work_of(&work);
        model.set_time(t_span.1)?;
        if status != Some(Status::Finished) {
            (self.in_vain, self.is_exhausted) = (work_of(&work), true);
            return Ok((None, work));
        }
        let touches = model.overlaps(stepper.q());
        let motion = [stepper.q(), stepper.v(), stepper.unknowns()].map(<[f64]>::to_vec);
        let flow = meter.map_or([0.0; 2], |meter| meter.total());
        Ok((Some(Resolved { motion, flow, touches }), work))
    }

    /// What goes on from step to step.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.count(&mut self.used);
        tape.count(&mut self.in_vain);
        tape.flag(&mut self.is_exhausted);
        tape.flag(&mut self.goes_on);
    }
}

/// Absolute tolerances of velocities in a step of size `h` that changes them so: by differences alone, which no motion of the whole has.
fn tolerances(sizes: &[f64], [before, after]: [&[f64]; 2], h: f64) -> Vec<f64> {
    let changes = before.iter().zip(after).map(|(before, after)| (after - before).abs());
    let largest = changes.clone().zip(sizes).map(|(change, size)| change / size).fold(ROUNDING / h, f64::max);
    changes.zip(sizes).map(|(change, size)| TOLERANCE * change.max(HARDLY * largest * size)).collect()
}
