//! A model with the stepper of a method: the common interface of all methods.

use super::impact_resolver::{ImpactResolver, Resolved, Step};
use super::method::Method;
use super::rebounds::resolved_loss;
use super::status::Status;
use crate::description::signal::Cell;
use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::integrators::Retries;
use crate::integrators::attempts::Remedy;
use crate::integrators::newmark;
use crate::integrators::newmark::Lengths;
use crate::integrators::ode;
use crate::integrators::ode::FirstOrder;
use crate::integrators::radau;
use crate::integrators::second_order;
use crate::integrators::second_order::{Counters, Failure, Watched, constrained_start};
use crate::model::constraint::projection;
use crate::model::{ForwardScratch, Model};
use crate::numerics::roots::Derivative;
use crate::numerics::tape::Tape;
use crate::simulation::balance::State;

#[derive(Clone, Debug)]
pub(super) enum Integrator<M> {
    /// With the stepper before the last step if that may be taken back.
    Newmark {
        model: M,
        stepper: Box<newmark::Stepper>,
        before: Option<Box<newmark::Stepper>>,
    },
    Radau {
        model: M,
        stepper: Box<radau::Stepper>,
    },
    FirstOrder {
        system: Box<FirstOrder<M>>,
        stepper: Box<ode::Stepper>,
        n: usize,
    },
}

impl<M: Model> Integrator<M> {
    /// From `q0`, `v0` over `t_span`. Evaluates nothing yet.
    pub(super) fn new(
        mut model: M,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        method: &Method,
    ) -> Result<Self, InvalidInput> {
        let n = model.facts().n;
        Ok(match method {
            Method::Newmark(options) => {
                if model.facts().constraints() > 0 {
                    check_damps_constraints(options)?;
                }
                let stepper = newmark::Stepper::new(n, t_span, q0, v0, options)?;
                newmark::LinearSystem::check_memory(&mut model, options.derivative)?;
                Self::Newmark { model, stepper: Box::new(stepper), before: None }
            }
            Method::Radau { options, .. } => {
                radau::check_memory(&mut model)?;
                let stepper = radau::Stepper::new(n, t_span, q0, v0, options)?;
                Self::Radau { model, stepper: Box::new(stepper) }
            }
            Method::FirstOrder { options, .. } => {
                let state = [q0, v0].concat();
                let stepper = ode::Stepper::new(2 * n, t_span, &state, options)?;
                let system = Box::new(FirstOrder::new(model));
                Self::FirstOrder { system, stepper: Box::new(stepper), n }
            }
        })
    }

    pub(super) fn model(&mut self) -> &mut M {
        match self {
            Self::Newmark { model, .. } | Self::Radau { model, .. } => model,
            Self::FirstOrder { system, .. } => system.model(),
        }
    }

    /// Finds the accelerations at the start; `Some(status)` where there are none.
    pub(super) fn start(&mut self) -> Result<Option<Status>, Interrupted> {
        match self {
            Self::Newmark { model, stepper, .. } => of_second_order(stepper.start(model)),
            Self::Radau { model, stepper } => of_second_order(stepper.start(model)),
            Self::FirstOrder { system, stepper, .. } => stepper.start(&mut **system).map(|()| None),
        }
    }

    /// Makes one accepted step; `Some(status)` if the interval has ended. `lengths` says whether lengths of inextensible tendons jump over a
    /// step of fixed size. `monitor` is called with the time of its start if it takes many evaluations, and may interrupt it.
    pub(super) fn step(
        &mut self,
        lengths: Lengths,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        let t = self.t();
        let watch = &mut || monitor(t);
        match self {
            Self::Newmark { model, stepper, before } => {
                if model.facts().is_one_sided {
                    *before = Some(stepper.clone());
                    stepper.expect(lengths);
                }
                of_second_order(stepper.step(&mut Watched::new(model, watch)))
            }
            Self::Radau { model, stepper } => of_second_order(stepper.step(&mut Watched::new(model, watch))),
            Self::FirstOrder { system, stepper, .. } => {
                stepper.step(&mut **system).map(|status| status.map(Status::FirstOrder))
            }
        }
    }

    /// Closes loops that the last step has opened by its error. False at a singular position with several branches.
    pub(super) fn hold(&mut self) -> Result<bool, Interrupted> {
        match self {
            // Constraints are equations of their steps.
            Self::Newmark { .. } | Self::Radau { .. } => Ok(true),
            Self::FirstOrder { system, stepper, .. } => {
                let t = stepper.t();
                let [y, rate] = stepper.state_mut();
                system.hold(t, y, rate)
            }
        }
    }

    /// Repeats a step of fixed size with an impact, or shortly after one, by a method that resolves it.
    pub(super) fn resolve_impact(&mut self, impact_resolver: &mut ImpactResolver) -> Result<(), Interrupted> {
        let Self::Newmark { model, stepper, .. } = self else { return Ok(()) };
        let (t_span, [q, v]) = ((stepper.t_old(), stepper.t()), stepper.before());
        let (changes, h) = ([v, stepper.v()], t_span.1 - t_span.0);
        let Some(impact) = impact_resolver.impact_to_follow(stepper.unilateral(), model.facts(), changes, h)
        else {
            return Ok(());
        };
        let allowed = impact_resolver.allowed(model.facts(), &stepper.counters());
        if allowed == 0 {
            return Ok(());
        }
        let step = Step { t_span, before: [q, v], impact };
        let (resolved, work) = impact_resolver.resolve(model, &step, allowed)?;
        stepper.add_work(&work);
        let Some(Resolved { motion: [q, v, a], touches }) = resolved else { return Ok(()) };
        stepper.end_instead([&q, &v, &a], touches);
        if touches {
            model.set_time(t_span.1)?;
            // The impact lasts until surfaces separate.
            impact_resolver.set_unfinished_impact(&model.separation(
                &v,
                [&q, &v, &a[..q.len()]],
                0.0,
                t_span.1 - t_span.0,
            ));
        }
        Ok(())
    }

    /// The multipliers with which the last step was solved, if steps are of fixed size: they act over the whole step.
    pub(super) fn pulls(&self) -> Option<&[f64]> {
        match self {
            Self::Newmark { stepper, .. } if stepper.has_fixed_steps() => Some(stepper.pulls()),
            _ => None,
        }
    }

    /// The gain of energy over the last step of fixed size, and the energy dissipated by damping, in joules.
    pub(super) fn gain(&mut self) -> Result<[f64; 2], Interrupted> {
        let Self::Newmark { model, stepper, .. } = self else {
            unreachable!("other steps end where lengths jump")
        };
        let (t, [q, v, _]) = stepper.state();
        let (t_old, before) = (stepper.t_old(), stepper.before());
        let (mut gained, mut damped) = (0.0, 0.0);
        for (t_there, [q, v], sign) in [(t_old, before, -1.0), (t, [q, v], 1.0)] {
            model.set_time(t_there)?;
            gained += sign * model.energy(q, v).total();
            damped += 0.5 * (t - t_old) * model.dissipated_power(q, v);
        }
        Ok([gained, damped])
    }

    /// The multipliers of constraints at an end of the last step, if accelerations there satisfy the constraints.
    pub(super) fn multipliers(&self, t: f64) -> Option<Vec<f64>> {
        let Self::Newmark { stepper, .. } = self else { return None };
        stepper.multipliers(t).map(<[f64]>::to_vec)
    }

    /// Takes back the last step; of fixed size also one that could not be made.
    pub(super) fn undo_step(&mut self) {
        match self {
            Self::Newmark { stepper, before, .. } => {
                stepper.undo_step(*before.take().expect("there is a last step"));
            }
            Self::Radau { stepper, .. } => stepper.undo_step(),
            Self::FirstOrder { stepper, .. } => stepper.undo_step(),
        }
    }

    /// Continues from this state, in which constraints have changed or velocities have jumped; `a` are accelerations followed by
    /// multipliers.
    pub(super) fn restart(&mut self, [q, v, a]: [&[f64]; 3]) -> Result<(), Interrupted> {
        match self {
            Self::Newmark { stepper, .. } => {
                stepper.restart([q, v, a]);
                Ok(())
            }
            Self::Radau { model, stepper } => stepper.restart(model, [q, v, a]),
            Self::FirstOrder { system, stepper, .. } => {
                system.forget_rank();
                stepper.restart([q, v]);
                stepper.start(&mut **system)
            }
        }
    }

    /// Whether loops are so near to a singular position that no step of an adaptive method may be small enough.
    pub(super) fn is_nearly_singular(&mut self) -> bool {
        match self {
            Self::Newmark { .. } => false,
            Self::Radau { model, stepper } => {
                model.facts().constraints() > 0
                    && projection::fit_velocities(model, stepper.q(), &mut stepper.v().to_vec())
                        .is_ok_and(|fit| fit.is_singular())
            }
            Self::FirstOrder { system, stepper, .. } => {
                let [y, _] = stepper.state_mut();
                system.is_nearly_singular(y)
            }
        }
    }

    /// Continues to a later end, whatever the status was.
    pub(super) fn extend_to(&mut self, t_end: f64) {
        match self {
            Self::Newmark { stepper, .. } => stepper.extend_to(t_end),
            Self::Radau { stepper, .. } => stepper.extend_to(t_end),
            Self::FirstOrder { stepper, .. } => stepper.extend_to(t_end),
        }
    }

    /// Lets steps end there at the latest, within the interval; those of fixed size stay on their grid behind it.
    pub(super) fn end_at(&mut self, t: f64) {
        match self {
            Self::Newmark { stepper, .. } => stepper.end_at(t),
            _ => self.extend_to(t),
        }
    }

    /// Continues with other rotation vectors if the present ones come near their singularity.
    pub(super) fn shorten_rotation_vectors(&mut self) {
        match self {
            Self::Newmark { model, stepper, .. } => stepper.shorten_rotation_vectors(model),
            Self::Radau { model, stepper } => stepper.shorten_rotation_vectors(model),
            Self::FirstOrder { system, stepper, .. } => stepper.shorten_rotation_vectors(&mut **system),
        }
    }

    /// Takes these accelerations for the current ones.
    pub(super) fn jump(&mut self, a: &[f64]) {
        match self {
            Self::Newmark { stepper, .. } => stepper.jump(a),
            Self::Radau { stepper, .. } => stepper.jump(a),
            Self::FirstOrder { stepper, .. } => stepper.rate_mut()[a.len()..].copy_from_slice(a),
        }
    }

    /// Goes on by the method after a jump of what is prescribed, which its steps drag along by what is known of them.
    pub(super) fn ignore_jump(&mut self) {
        if let Self::Newmark { stepper, .. } = self {
            stepper.ignore_jump();
        }
    }

    /// Whether the last step removed what a jump before it excited faster than the step.
    pub(super) fn has_bridged_jump(&self) -> bool {
        if let Self::Newmark { stepper, .. } = self { stepper.has_stages() } else { false }
    }

    /// Velocities after a jump of prescribed velocities, and accelerations and multipliers then. The impulses of
    /// everything but what is prescribed, `M dv`, balance each other: `dv` is the change of the accelerations
    /// with the change of prescribed velocities, at the time `corner`, added to prescribed accelerations. Allocates.
    pub(super) fn after_jump(&mut self, corner: f64) -> Result<Option<[Vec<f64>; 3]>, Interrupted> {
        let constraints = self.model().facts().constraints();
        self.observe(|model, state| {
            let (n, q) = (state.q.len(), state.q.to_vec());
            let mut scratch = ForwardScratch::of(&*model);
            let [mut before, mut within] = [(); 2].map(|()| vec![0.0; n]);
            let mut v = state.v.to_vec();
            model.set_time(corner)?;
            let is_known = model.forward_dynamics(&q, &v, &mut before, &mut scratch).is_ok();
            model.set_time_in_jump(corner)?;
            if !is_known || model.forward_dynamics(&q, &v, &mut within, &mut scratch).is_err() {
                return Ok(None);
            }
            v.iter_mut()
                .zip(within.iter().zip(&before))
                .for_each(|(v, (within, before))| *v += within - before);
            model.pass_jump(corner);
            let mut a = vec![0.0; n + constraints];
            let is_known = if constraints > 0 {
                constrained_start(model, state.t, &q, &v, &mut a)?.is_ok()
            } else {
                model.set_time(state.t)?;
                model.forward_dynamics(&q, &v, &mut a, &mut scratch).is_ok()
            };
            Ok((is_known && v.iter().chain(&a).all(|x| x.is_finite())).then_some([q, v, a]))
        })
    }

    pub(super) fn t(&self) -> f64 {
        match self {
            Self::Newmark { stepper, .. } => stepper.t(),
            Self::Radau { stepper, .. } => stepper.t(),
            Self::FirstOrder { stepper, .. } => stepper.t(),
        }
    }

    /// Where the last step began.
    pub(super) fn t_old(&self) -> f64 {
        match self {
            Self::Newmark { stepper, .. } => stepper.t_old(),
            Self::Radau { stepper, .. } => stepper.t_old(),
            Self::FirstOrder { stepper, .. } => stepper.t_old(),
        }
    }

    /// Calls `observe` with the model and its current state.
    pub(super) fn observe<T>(&mut self, observe: impl FnOnce(&mut M, State<'_>) -> T) -> T {
        match self {
            Self::Newmark { model, stepper, .. } => {
                let (t, [q, v, a]) = stepper.state();
                observe(model, State { t, q, v, a })
            }
            Self::Radau { model, stepper } => {
                let state = State { t: stepper.t(), q: stepper.q(), v: stepper.v(), a: stepper.a() };
                observe(model, state)
            }
            Self::FirstOrder { system, stepper, n } => {
                let (q, v) = stepper.y().split_at(*n);
                observe(system.model(), State { t: stepper.t(), q, v, a: &stepper.rate()[*n..] })
            }
        }
    }

    /// The time, displacements, velocities and accelerations.
    #[inline]
    pub(super) fn state(&self) -> (f64, [&[f64]; 3]) {
        match self {
            Self::Newmark { stepper, .. } => stepper.state(),
            Self::Radau { stepper, .. } => (stepper.t(), [stepper.q(), stepper.v(), stepper.a()]),
            Self::FirstOrder { stepper, n, .. } => {
                let (q, v) = stepper.y().split_at(*n);
                (stepper.t(), [q, v, &stepper.rate()[*n..]])
            }
        }
    }

    /// The states at these times within the last step, one after another; accelerations if the method knows them there. False
    /// where they are not finite.
    pub(super) fn interpolate(
        &mut self,
        times: &[f64],
        [q, v, a]: [&mut [f64]; 3],
    ) -> Result<bool, Interrupted> {
        let n = self.state().1[0].len();
        let here = |k: usize| k * n..(k + 1) * n;
        match self {
            Self::Newmark { stepper, .. } => {
                for (k, &t) in times.iter().enumerate() {
                    stepper.interpolate(t, &mut q[here(k)], &mut v[here(k)], &mut a[here(k)]);
                }
            }
            Self::Radau { stepper, .. } => {
                for (k, &t) in times.iter().enumerate() {
                    stepper.interpolate(t, &mut q[here(k)], &mut v[here(k)], &mut a[here(k)]);
                }
            }
            Self::FirstOrder { system, stepper, .. } => {
                let Some(step) = stepper.last_step(&mut **system)? else {
                    q.fill(f64::NAN);
                    v.fill(f64::NAN);
                    return Ok(false);
                };
                step.evaluate_halves(times, [q, v]);
            }
        }
        Ok(true)
    }

    /// Whether the method knows accelerations between the ends of its steps.
    pub(super) fn knows_accelerations(&self) -> bool {
        !matches!(self, Self::FirstOrder { .. })
    }

    pub(super) fn counters(&self) -> Counters {
        match self {
            Self::Newmark { stepper, .. } => stepper.counters(),
            Self::Radau { stepper, .. } => stepper.counters(),
            Self::FirstOrder { stepper, .. } => {
                let ode::Counters { accepted, rejected, nfev, nfev_jacobian, njev, nlu } = stepper.counters();
                let steps = accepted;
                Counters { steps, rejected, nfev, nfev_jacobian, njev, nlu, ..Counters::default() }
            }
        }
    }

    /// The attempts since the last call.
    pub(super) fn take_retries(&mut self) -> Retries {
        match self {
            Self::Newmark { stepper, .. } => stepper.take_retries(),
            Self::Radau { stepper, .. } => stepper.take_retries(),
            Self::FirstOrder { stepper, .. } => stepper.take_retries(),
        }
    }

    /// Description of a status of this method.
    pub(super) fn explain(&self, status: Status) -> String {
        match (self, status) {
            (Self::Newmark { stepper, .. }, Status::SecondOrder(status)) => stepper.explain(status),
            (Self::Radau { stepper, .. }, Status::SecondOrder(status)) => stepper.explain(status),
            (Self::FirstOrder { stepper, .. }, Status::FirstOrder(status)) => stepper.explain(status),
            _ => unreachable!("the status is of another method"),
        }
    }

    /// The scheme of a method with steps of fixed size and inertia.
    pub(super) fn fixed_scheme(&self) -> Option<newmark::Scheme> {
        if let Self::Newmark { stepper, .. } = self { stepper.fixed_scheme() } else { None }
    }

    /// This end of a step of the fixed size `dt`, or the corner from which it differs by rounding only.
    pub(super) fn end_at_corner(&self, end: f64, dt: f64) -> f64 {
        match self {
            Self::Newmark { model, stepper, .. } if stepper.has_fixed_steps() => {
                Cell { start: end - dt, t: end - dt, end }.end_at_corner(|cell| model.corner(cell))
            }
            _ => end,
        }
    }

    /// Why the motion so far may be wrong although all steps were made, and what can be done.
    pub(super) fn doubt(&self, remedy: Remedy) -> Option<String> {
        if let Self::Newmark { stepper, .. } = self { stepper.doubt(remedy) } else { None }
    }

    /// The same about impacts of rods, by a motion that resolves the worst of them; costs up to half of the work of the run.
    pub(super) fn doubt_of_rods(&mut self, remedy: Remedy) -> Result<Option<String>, Interrupted> {
        let Self::Newmark { model, stepper, .. } = self else { return Ok(None) };
        // Constraints would have impulses.
        if model.facts().constraints() > 0 {
            return Ok(None);
        }
        let Some(stopped) = stepper.unilateral().stopped_impact() else { return Ok(None) };
        let found = resolved_loss(model, stopped, &stepper.counters());
        model.set_time(stepper.t())?;
        Ok(stepper.doubt_of_rods(remedy, found?))
    }

    /// Accepted steps so far.
    pub(super) fn steps(&self) -> usize {
        match self {
            Self::Newmark { stepper, .. } => stepper.steps(),
            Self::Radau { stepper, .. } => stepper.counters().steps,
            Self::FirstOrder { stepper, .. } => stepper.counters().accepted,
        }
    }

    /// The status of a run that has no accelerations after a jump.
    pub(super) fn no_acceleration(&self, failure: Failure) -> Status {
        match self {
            Self::Newmark { .. } | Self::Radau { .. } => {
                Status::SecondOrder(second_order::Status::NoInitialAcceleration(failure))
            }
            Self::FirstOrder { .. } => Status::FirstOrder(ode::Status::NonFinite),
        }
    }

    /// The status of a run that was asked to stop.
    pub(super) fn interrupted(&self) -> Status {
        match self {
            Self::Newmark { .. } | Self::Radau { .. } => {
                Status::SecondOrder(second_order::Status::Interrupted)
            }
            Self::FirstOrder { .. } => Status::FirstOrder(ode::Status::Interrupted),
        }
    }

    /// Serialises all data that persist from step to step.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        match self {
            Self::Newmark { model, stepper, .. } => stepper.serialise(model, tape),
            Self::Radau { model, stepper } => stepper.serialise(model, tape),
            Self::FirstOrder { stepper, .. } => stepper.serialise(tape),
        }
    }
}

/// Refuses members of the Newmark family that cannot integrate constraints: without damping of infinite frequencies,
/// multipliers oscillate with growing amplitude (Cardona and Geradin 1989); with beta = 0 displacements do not depend on the
/// accelerations at the end of the step, and multipliers cannot correct them.
fn check_damps_constraints(options: &newmark::Options) -> Result<(), InvalidInput> {
    let (scheme, mut check) = (options.scheme, Checker::new());
    let expected = "a method that damps what is infinitely fast: \"generalised_alpha\" with rho_inf < 1, \"hht\" with alpha < 0, \
                    or \"newmark\" with gamma > 0.5; with other methods the forces in closed loops oscillate with growing amplitude";
    check.require(scheme.damps() && scheme.beta() > 0.0, "method", "one without damping", expected);
    let expected = "\"analytic\": closed loops are held by exact derivatives";
    check.require(options.derivative == Derivative::Analytic, "jac", "differences", expected);
    check.finish()
}

/// The model of motions without inertia; refuses models and arguments that have no meaning there.
pub(super) fn without_inertia<M: Model>(model: M, v0: &[f64]) -> Result<M, InvalidInput> {
    let mut check = Checker::new();
    let fastest = v0.iter().copied().fold(0.0, |most: f64, v| most.max(v.abs()));
    let expected = "none: without inertia velocities are those of the shapes, which inputs, loads and prescribed motions move";
    check.require(fastest == 0.0, "v0", Number(fastest), expected);
    let expected = "another method, or tendons with a `stiffness`";
    let found = "without inertia, of a robot with tendons that do not stretch";
    check.require(!model.facts().is_one_sided, "method", found, expected);
    let slowed = model.with_inertia_times(newmark::SLOWED);
    let expected = "another method: \"quasi_static\" leaves inertia out, which only robots and rods allow, in flows without added mass \
                    (`added_mass_coefficient=0`)";
    check.require(slowed.is_some(), "method", "\"quasi_static\" for this model", expected);
    check.finish()?;
    Ok(slowed.expect("it was checked"))
}

fn of_second_order(
    status: Result<Option<second_order::Status>, Interrupted>,
) -> Result<Option<Status>, Interrupted> {
    status.map(|status| status.map(Status::SecondOrder))
}
