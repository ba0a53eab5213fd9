//! The stepper, for systems of any size.

use super::super::numbers::{FixedSize, Numbers};
use super::super::options::Options;
use super::super::scheme::Scheme;
use super::{Lengths, StepperOf};
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::attempts::{Fixed as _, Remedy, ResolvedLoss, Unilateral};
use crate::integrators::second_order::{Counters, SecondOrderSystem, Status};
use crate::integrators::{Reason, Retries};
use crate::numerics::tape::Tape;

/// An integration performed step by step. All memory is allocated by the time the initial accelerations are
/// known.
///
/// The stepper does not own the equations of motion; pass the same ones to every call.
#[derive(Clone, Debug)]
pub struct Stepper(Kind);

/// One stepper, with the storage that suits the system.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one for an integration, and it is not moved")]
enum Kind {
    One(StepperOf<FixedSize<1>>),
    Two(StepperOf<FixedSize<2>>),
    Three(StepperOf<FixedSize<3>>),
    Four(StepperOf<FixedSize<4>>),
    Any(StepperOf<Vec<f64>>),
}

/// The same for each kind.
macro_rules! of_kind {
    ($kind:expr, $stepper:ident => $what:expr) => {
        match $kind {
            Kind::One($stepper) => $what,
            Kind::Two($stepper) => $what,
            Kind::Three($stepper) => $what,
            Kind::Four($stepper) => $what,
            Kind::Any($stepper) => $what,
        }
    };
}

impl Stepper {
    /// Prepares the integration of `n` coordinates from `q0`, `v0` over `t_span`. Evaluates nothing.
    pub fn new(
        n: usize,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        options: &Options,
    ) -> Result<Self, InvalidInput> {
        let (rtol, atol) = options.check(n, t_span, q0, v0)?;
        Ok(Self(Kind::Any(StepperOf::new(t_span, [q0, v0], options, (&rtol, atol.as_deref())))))
    }

    /// Solves for the accelerations at the start. [`Self::step`] calls this if necessary. Returns
    /// `Some(status)` if there are none.
    pub fn start<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
        self.suit(system);
        of_kind!(&mut self.0, stepper => stepper.start(system))
    }

    /// Chooses the storage before the first accelerations are known.
    fn suit<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) {
        let Kind::Any(stepper) = &self.0 else { return };
        // Quasi-static steps are not plain.
        if stepper.started || !system.facts().has_plain_steps() || !stepper.scheme.has_inertia() {
            return;
        }
        self.0 = match stepper.q.len() {
            1 => Kind::One(stepper.anew()),
            2 => Kind::Two(stepper.anew()),
            3 => Kind::Three(stepper.anew()),
            4 => Kind::Four(stepper.anew()),
            n => unreachable!("plain steps of {n} coordinates"),
        };
    }

    /// Makes one accepted step. Returns `Some(status)` if the integration has ended: the end was reached, or
    /// no step could be made, which leaves the state unchanged. After an interruption the state is that of
    /// the last accepted step, and the step can be repeated.
    ///
    /// # Panics
    /// If the integration had already ended.
    pub fn step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
        self.suit(system);
        of_kind!(&mut self.0, stepper => stepper.step(system))
    }

    /// Replaces rotation vectors that come close to their singularity by equivalent shorter ones.
    pub(crate) fn shorten_rotation_vectors<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) {
        of_kind!(&mut self.0, stepper => stepper.shorten_rotation_vectors(system));
    }

    /// Extends the integration to a later end, for any status. Steps of fixed size are equal: `dt` if that divides the interval.
    pub(crate) fn extend_to(&mut self, t_end: f64) {
        of_kind!(&mut self.0, stepper => stepper.extend_to(t_end));
    }

    /// Makes the next step end at this time at the latest, within the last step, which was undone, or at the end of the interval.
    pub(crate) fn end_at(&mut self, t: f64) {
        of_kind!(&mut self.0, stepper => stepper.end_at(t));
    }

    /// Sets the behaviour of tendon lengths over the next step of fixed size.
    pub(crate) fn expect(&mut self, lengths: Lengths) {
        of_kind!(&mut self.0, stepper => stepper.expect(lengths));
    }

    /// The multipliers of constraints in the last step, as means over it.
    pub(crate) fn pulls(&self) -> &[f64] {
        of_kind!(&self.0, stepper => &stepper.pulls)
    }

    /// The multipliers of constraints at an end of the last step.
    pub(crate) fn multipliers(&self, t: f64) -> Option<&[f64]> {
        of_kind!(&self.0, stepper => {
            let at_end = (t == stepper.t).then_some(&stepper.a);
            at_end.or_else(|| (t == stepper.t_old).then_some(&stepper.a_old)).map(|a| &a[stepper.q.len()..])
        })
    }

    /// Restores the state `before` the last step, which may have failed, for systems with constraints.
    pub(crate) fn undo_step(&mut self, before: Self) {
        let (Kind::Any(stepper), Kind::Any(before)) = (&mut self.0, before.0) else {
            unreachable!("plain steps have no constraints")
        };
        stepper.end_parts(before, false);
        stepper.forget();
        stepper.counters.rejected += 1;
        stepper.retries.fail(Reason::Event);
    }

    /// Replaces the current accelerations after a jump of forces.
    pub(crate) fn jump(&mut self, a: &[f64]) {
        of_kind!(&mut self.0, stepper => stepper.jump(a));
    }

    /// Goes on by the scheme after a jump.
    pub(crate) fn ignore_jump(&mut self) {
        of_kind!(&mut self.0, stepper => stepper.ignore_jump());
    }

    /// Whether the last step was one of two stages, after a jump.
    pub(crate) fn has_stages(&self) -> bool {
        of_kind!(&self.0, stepper => stepper.has_stages)
    }

    /// Continues from this state after a jump of velocities. `a` are accelerations, followed by multipliers.
    pub(crate) fn restart(&mut self, motion: [&[f64]; 3]) {
        of_kind!(&mut self.0, stepper => stepper.restart(motion));
    }

    /// State of one-sided forces.
    pub(crate) fn unilateral(&self) -> &Unilateral {
        of_kind!(&self.0, stepper => &stepper.unilateral)
    }

    /// Displacements and velocities at the start of the last step.
    pub(crate) fn before(&self) -> [&[f64]; 2] {
        of_kind!(&self.0, stepper => [&stepper.q_old[..], &stepper.v_old])
    }

    /// Replaces the end of the last step, which was repeated by another method; `touches`: whether surfaces touch there.
    pub(crate) fn end_instead(&mut self, motion: [&[f64]; 3], touches: bool) {
        of_kind!(&mut self.0, stepper => stepper.end_instead(motion, touches));
    }

    /// Adds the cost of a motion that resolves the impact of the last step.
    pub(crate) fn add_work(&mut self, work: &Counters) {
        of_kind!(&mut self.0, stepper => stepper.add_work(work));
    }

    /// Writes or reads the state that persists between steps.
    pub(crate) fn serialise<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S, tape: &mut Tape<'_>) {
        self.suit(system);
        of_kind!(&mut self.0, stepper => stepper.serialise(system, tape));
    }

    /// Current time.
    pub fn t(&self) -> f64 {
        of_kind!(&self.0, stepper => stepper.t)
    }

    /// Current displacements.
    pub fn q(&self) -> &[f64] {
        of_kind!(&self.0, stepper => &stepper.q)
    }

    /// Current velocities.
    pub fn v(&self) -> &[f64] {
        of_kind!(&self.0, stepper => &stepper.v)
    }

    /// Current accelerations, which satisfy the equations of motion.
    pub fn a(&self) -> &[f64] {
        of_kind!(&self.0, stepper => stepper.a())
    }

    /// Current time, displacements, velocities and accelerations.
    #[inline]
    pub(crate) fn state(&self) -> (f64, [&[f64]; 3]) {
        of_kind!(&self.0, stepper => (stepper.t, [&stepper.q, &stepper.v, stepper.a()]))
    }

    /// Current accelerations, and the multipliers of constraints behind them.
    pub(crate) fn unknowns(&self) -> &[f64] {
        of_kind!(&self.0, stepper => &stepper.a)
    }

    /// Time before the last step; the start if no step was made.
    pub fn t_old(&self) -> f64 {
        of_kind!(&self.0, stepper => stepper.t_old)
    }

    /// End of the interval.
    pub fn t_end(&self) -> f64 {
        of_kind!(&self.0, stepper => stepper.t_end)
    }

    /// Cost of the integration so far.
    pub fn counters(&self) -> Counters {
        of_kind!(&self.0, stepper => stepper.counters)
    }

    /// The attempts since the last call.
    pub(crate) fn take_retries(&mut self) -> Retries {
        of_kind!(&mut self.0, stepper => stepper.retries.take())
    }

    /// Accepted steps so far.
    pub(crate) fn steps(&self) -> usize {
        of_kind!(&self.0, stepper => stepper.counters.steps)
    }

    /// `None` while the integration is running.
    pub fn status(&self) -> Option<Status> {
        of_kind!(&self.0, stepper => stepper.status)
    }

    /// Why the motion so far may be wrong although all steps were solved: unresolved impacts, with a remedy.
    pub(crate) fn doubt(&self, remedy: Remedy) -> Option<String> {
        of_kind!(&self.0, stepper => stepper.doubt(remedy))
    }

    /// The same about impacts of rods, by what a motion loses that resolves the worst of them.
    pub(crate) fn doubt_of_rods(&self, remedy: Remedy, resolved: ResolvedLoss) -> Option<String> {
        of_kind!(&self.0, stepper => stepper.unilateral.doubt_of_rods(stepper.options.dt, remedy, resolved))
    }

    /// Describes a status of this integration, with advice unless it is a success.
    pub fn explain(&self, status: Status) -> String {
        of_kind!(&self.0, stepper => stepper.explain(status))
    }

    /// Whether steps have one size.
    pub(crate) fn has_fixed_steps(&self) -> bool {
        of_kind!(&self.0, stepper => stepper.has_fixed_steps())
    }

    /// The scheme of steps of one size that follow vibrations.
    pub(crate) fn fixed_scheme(&self) -> Option<Scheme> {
        of_kind!(&self.0, stepper => stepper.fixed_scheme())
    }

    /// Number of steps of fixed size that the interval takes; saturates.
    pub(in super::super) fn fixed_steps(&self) -> usize {
        of_kind!(&self.0, stepper => stepper.fixed_steps)
    }

    /// State at a time within the last step, by cubic Hermite interpolation of displacements and of
    /// velocities and by linear interpolation of accelerations. At the ends of the step, the result is bit
    /// for bit the state there.
    pub fn interpolate(&self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        of_kind!(&self.0, stepper => stepper.interpolate(t, q, v, a));
    }
}

impl<V: Numbers> StepperOf<V> {
    /// The same with another storage, before its first accelerations are known.
    fn anew<W: Numbers>(&self) -> StepperOf<W> {
        let tolerances = (&self.rtol[..], self.atol.as_deref());
        StepperOf {
            status: self.status,
            fixed_steps: self.fixed_steps,
            grid: self.grid,
            ..StepperOf::new((self.t, self.t_end), [&self.q, &self.v], &self.options, tolerances)
        }
    }
}
