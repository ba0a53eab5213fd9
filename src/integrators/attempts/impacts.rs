//! Energy that fixed steps lose in impacts which they do not resolve: all at once if a step stops an impact, or gradually if only a
//! few steps sample the rise and fall of contact forces.

use crate::error::Number;
use crate::model::Impact;
use crate::numerics::tape::Tape;

/// Losses of more than this part of the largest kinetic energy cause a warning. A body that stops at once loses all of it; a rod that
/// gradually comes to lie on a floor loses a tenth.
const LARGE_LOSS: f64 = 0.25;

/// The same for models without dissipation, where nothing explains a loss. A ball that rebounds in seven steps loses or gains 2 % of
/// its energy.
const UNEXPLAINED_LOSS: f64 = 0.06;

/// The same if impacts are resolved, but not all of them: resolved ones lose less.
const UNRESOLVED_LOSS: f64 = 0.02;

/// Losses must also exceed this part of the elastic energy: slowly pressed bodies have hardly any kinetic energy to lose.
const AT_REST: f64 = 0.1;

/// Recommended step relative to the current one if an impact takes only a few steps.
const RECOMMENDED_STEP_FACTOR: f64 = 0.25;

/// What users can do about impacts that steps have stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Remedy {
    /// Ask for resolved impacts.
    Resolve,
    /// Impacts are resolved already, up to a limit of work.
    Bounded,
    /// Shorter steps or another method.
    Shorten,
}

/// The impacts of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Impacts {
    /// Energy in joules that the stopped impacts would have given back: of all, and of the worst one.
    lost: f64,
    worst: f64,
    /// Time and contact of the worst impact, and the longest step that would have resolved it.
    at: f64,
    contact: usize,
    longest: f64,
    /// The largest kinetic energy of colliding parts, and the largest elastic energy at impacts.
    kinetic: f64,
    elastic: f64,
    /// Energy that other steps with contact have lost without a cause, now and at most: within an impact it falls and rises.
    missing: f64,
    most_missing: f64,
    /// Whether that is known, because the model has no dissipation.
    is_known: bool,
}

impl Impacts {
    /// Records an impact that a step has stopped; `is_known` says whether nothing but steps loses energy.
    pub(super) fn count(&mut self, t: f64, impact: &Impact, is_known: bool) {
        self.is_known |= is_known;
        self.kinetic = self.kinetic.max(impact.kinetic);
        self.elastic = self.elastic.max(impact.elastic);
        // At most the kinetic energy can be given back: slowly pressed bodies lose energy to friction and bases.
        let lost = impact.lost.min(impact.kinetic);
        self.lost += lost;
        if lost > self.worst {
            (self.worst, self.at) = (lost, t);
            (self.contact, self.longest) = (impact.contact, impact.longest);
        }
    }

    /// Records the energy lost in a step with contact at one of its ends that has not stopped an impact, with the kinetic energy of the
    /// touching parts and the elastic energy.
    pub(super) fn follow(&mut self, lost: f64, kinetic: f64, elastic: f64) {
        self.kinetic = self.kinetic.max(kinetic);
        self.elastic = self.elastic.max(elastic);
        self.is_known = true;
        self.missing += lost;
        self.most_missing = self.most_missing.max(self.missing);
    }

    /// The largest kinetic energy of colliding parts so far.
    pub(super) fn largest_kinetic(&self) -> f64 {
        self.kinetic
    }

    /// The losses of an earlier time, with the current energies to which losses are compared.
    pub(super) fn without_losses_since(&self, before: &Self) -> Self {
        Self { kinetic: self.kinetic, elastic: self.elastic, ..*before }
    }

    /// Why a motion with steps of this size may be wrong, if much energy was lost.
    pub(super) fn doubt(&self, dt: f64, remedy: Remedy) -> Option<String> {
        let &Self { lost, worst, at, contact, longest, kinetic, elastic, missing, most_missing, is_known } =
            self;
        let all = lost + most_missing;
        let exceeds = |loss: f64, part: f64| loss > (part * kinetic).max(AT_REST.min(part) * elastic);
        let unexplained = if remedy == Remedy::Bounded { UNRESOLVED_LOSS } else { UNEXPLAINED_LOSS };
        let is_explained = !is_known || !exceeds(lost + missing, unexplained);
        if kinetic == 0.0 || is_explained && !exceeds(all, LARGE_LOSS) {
            return None;
        }
        let bounded = if remedy == Remedy::Bounded {
            " Other impacts were resolved, with half as much work as the rest of the run."
        } else {
            ""
        };
        if most_missing > lost {
            return Some(format!(
                "Impacts take only a few steps of {} s, which do not resolve the contact forces: the motion loses {} J, \
                 {:.0} % of its largest kinetic energy, without dissipation. Take `dt={:.1e}` or less, {:.0} \
                 times less `stiffness`, or method \"radau\".{bounded}",
                Number(dt),
                energy(all),
                100.0 * all / kinetic,
                RECOMMENDED_STEP_FACTOR * dt,
                RECOMMENDED_STEP_FACTOR.powi(-2)
            ));
        }
        let softer = (longest / dt).powi(2);
        Some(format!(
            "Impacts are shorter than steps of {} s, which suppress rebounds: the motion loses {} J, {:.0} % of \
             its largest kinetic energy, {} J of these in contacts[{contact}] at t = {at:.3} s. Take `dt={longest:.1e}` or less, \
             {softer:.0e} times that `stiffness`, {}or method \"radau\".{}",
            Number(dt),
            energy(lost),
            100.0 * lost / kinetic,
            energy(worst),
            if remedy == Remedy::Resolve {
                "`method=lissom.methods.Newmark(impacts=\"resolved\")`, "
            } else {
                ""
            },
            bounded
        ))
    }

    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        let Self { lost, worst, at, contact, longest, kinetic, elastic, missing, most_missing, is_known } =
            self;
        for number in [lost, worst, at, longest, kinetic, elastic, missing, most_missing] {
            tape.number(number);
        }
        tape.count(contact);
        tape.flag(is_known);
    }
}

/// A number of joules with four digits.
fn energy(joules: f64) -> String {
    if (0.1..1e4).contains(&joules) { format!("{joules:.3}") } else { format!("{joules:.3e}") }
}
