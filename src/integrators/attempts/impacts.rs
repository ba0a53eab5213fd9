//! Energy that fixed steps lose in impacts which they do not resolve: all at once if a step stops an impact, or gradually if only a
//! few steps sample the rise and fall of contact forces.

use crate::error::Number;
use crate::model::{Impact, STEPS_OF_AN_IMPACT};
use crate::numerics::tape::Tape;

/// Losses of more than this part of the largest kinetic energy cause a warning. A body that stops at once loses all of it; a rod that
/// gradually comes to lie on a floor loses a tenth.
const LARGE_LOSS: f64 = 0.25;

/// The same for models without dissipation, where nothing explains a loss. A ball that rebounds in seven steps loses or gains 2 % of
/// its energy.
const UNEXPLAINED_LOSS: f64 = 0.06;

/// The same if impacts are resolved, but not all of them: resolved ones lose less.
const UNRESOLVED_LOSS: f64 = 0.02;

/// The same of impacts of rods that are followed after the run. A rod that falls flat at 3 m/s loses 9 % that a contact with the default
/// dissipation would return; one of 1 GPa that falls on its end 21 %.
const LOSS_OF_RODS: f64 = 0.12;

/// Losses must also exceed this part of the elastic energy: slowly pressed bodies have hardly any kinetic energy to lose.
const AT_REST: f64 = 0.1;

/// Recommended step relative to the current one if an impact takes only a few steps.
const RECOMMENDED_STEP_FACTOR: f64 = 0.25;

/// Steps over which losses in an impact of rods are added up: waves run through a rod in that time, if steps are too long for the impact.
const STEPS_OF_WAVES: f64 = 4.0;

/// Impacts are followed in parts of a step that would otherwise take this part of the largest kinetic energy which contacts give back.
const FOLLOWED_LOSS: f64 = 0.1;

/// Least number of parts in which an impact is followed. A soft rod that falls flat, with steps of 2 and 5 ms, loses 0.64 to 0.71 of its energy
/// in 24 falls, 0.65 with short steps; in three parts 0.36 to 0.93.
const PARTS_OF_AN_IMPACT: f64 = 8.0;

/// Maximum number of halvings of a step that follows an impact.
pub(super) const MOST_HALVINGS: usize = 5;

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

impl Remedy {
    /// What has become of other impacts.
    fn about_others(self) -> &'static str {
        match self {
            Self::Bounded => " Other impacts were resolved, with half as much work as the rest of the run.",
            Self::Resolve | Self::Shorten => "",
        }
    }
}

/// Energy in joules that stopped impacts have taken.
#[derive(Clone, Copy, Debug, Default)]
struct Losses {
    /// Of all, and of the worst one.
    lost: f64,
    worst: f64,
    /// Time and contact of the worst impact, and the longest step that would have resolved it.
    at: f64,
    contact: usize,
    longest: f64,
}

impl Losses {
    fn add(&mut self, t: f64, lost: f64, impact: &Impact) {
        // At most the kinetic energy can be given back: slowly pressed bodies lose energy to friction and bases.
        let lost = lost.min(impact.kinetic);
        self.lost += lost;
        if lost > self.worst {
            (self.worst, self.at) = (lost, t);
            (self.contact, self.longest) = (impact.contact, impact.longest);
        }
    }
}

/// An impact that steps follow in parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FollowedImpact {
    /// Longest part of a step in which surfaces touch, in seconds.
    longest_part: f64,
    /// Time at which it is over.
    end: f64,
}

impl FollowedImpact {
    /// Follows an impact in a step of size `h` to `t`; `None` if its parts would be too long, or if the whole step resolves it, so that
    /// something else has failed.
    fn new(impact: &Impact, t: f64, h: f64) -> Option<Self> {
        let duration = STEPS_OF_AN_IMPACT * impact.longest;
        let followed = Self { longest_part: duration / PARTS_OF_AN_IMPACT, end: t + duration };
        let shortest_part = h / f64::from(1 << MOST_HALVINGS);
        (followed.is_resolved_by(shortest_part) && !followed.is_resolved_by(h)).then_some(followed)
    }

    /// Whether surfaces may touch in a part of this size.
    pub(super) fn is_resolved_by(&self, h: f64) -> bool {
        h <= self.longest_part
    }

    /// Whether it may go on at this time.
    pub(super) fn lasts(&self, t: f64) -> bool {
        t < self.end
    }

    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.longest_part);
        tape.number(&mut self.end);
    }
}

/// An impact of rods that steps have stopped, one after the other.
#[derive(Clone, Debug)]
pub(crate) struct StoppedImpact {
    /// Start and size of the first step, and end of the last one, at most [`STEPS_OF_WAVES`] later.
    pub(crate) t: f64,
    pub(crate) h: f64,
    pub(crate) end: f64,
    /// Energy in joules that the steps have lost, and what the first one says of it.
    lost: f64,
    contact: usize,
    longest: f64,
    /// Displacements and velocities at the start.
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
}

impl StoppedImpact {
    /// Duration of the impact if the parts that touch were rigid, in seconds.
    pub(crate) fn duration(&self) -> f64 {
        STEPS_OF_AN_IMPACT * self.longest
    }
}

/// The impacts of rods that steps have stopped.
#[derive(Clone, Debug, Default)]
pub(super) struct StoppedImpacts {
    /// The last one, its loss and end before the last step of fixed size, and the worst one before it.
    last: Option<StoppedImpact>,
    before: Option<(f64, f64)>,
    worst: Option<StoppedImpact>,
}

impl StoppedImpacts {
    /// A step of fixed size begins.
    pub(super) fn begin_step(&mut self) {
        self.before = self.last.as_ref().map(|last| (last.lost, last.end));
    }

    /// The last step of fixed size is made by another method.
    pub(super) fn undo_step(&mut self) {
        match (self.before, &mut self.last) {
            (Some((lost, end)), Some(last)) if last.t < end => (last.lost, last.end) = (lost, end),
            _ => self.last = None,
        }
    }

    /// Adds what a step of this size or a part of it between these times has lost, from this state on. Allocates for another impact.
    pub(super) fn add(&mut self, impact: &Impact, ([t, end], h): ([f64; 2], f64), before: [&[f64]; 2]) {
        let lost = impact.whole.min(impact.kinetic);
        let continues = |last: &&mut StoppedImpact| last.end == t && end <= last.t + STEPS_OF_WAVES * h;
        if let Some(last) = self.last.as_mut().filter(continues) {
            last.lost += lost;
            last.end = end;
            return;
        }
        let [q, v] = before.map(<[f64]>::to_vec);
        let &Impact { contact, longest, .. } = impact;
        let new = StoppedImpact { t, h, end, lost, contact, longest, q, v };
        if let Some(last) = self.last.replace(new)
            && self.worst.as_ref().is_none_or(|worst| last.lost > worst.lost)
        {
            self.worst = Some(last);
        }
    }

    /// The worst one so far.
    pub(super) fn worst(&self) -> Option<&StoppedImpact> {
        self.worst.iter().chain(&self.last).max_by(|a, b| a.lost.total_cmp(&b.lost))
    }
}

/// What a motion that resolves a stopped impact loses in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResolvedLoss {
    /// In joules, until surfaces part after the steps that have stopped it.
    pub(crate) lost: f64,
    /// Whether that was computed within the work that is allowed.
    pub(crate) is_complete: bool,
}

/// The largest kinetic energy of colliding parts, and the largest elastic energy at impacts.
#[derive(Clone, Copy, Debug, Default)]
struct Largest {
    kinetic: f64,
    elastic: f64,
}

impl Largest {
    fn add(&mut self, kinetic: f64, elastic: f64) {
        self.kinetic = self.kinetic.max(kinetic);
        self.elastic = self.elastic.max(elastic);
    }

    /// Whether a loss is more than this part of them.
    fn are_exceeded(&self, loss: f64, part: f64) -> bool {
        self.kinetic > 0.0 && loss > (part * self.kinetic).max(AT_REST.min(part) * self.elastic)
    }
}

/// The impacts of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Impacts {
    /// As far as the contacts would have given it back, if all that touches were rigid.
    of_law: Losses,
    /// Energies at impacts of rods, which are looked at apart: steps depend on the others.
    of_rods: Largest,
    largest: Largest,
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
        self.largest.add(impact.kinetic, impact.elastic);
        self.of_law.add(t, impact.lost, impact);
    }

    /// The impact that a step of size `h` to `t` has stopped, if it is to be followed instead.
    pub(super) fn followed(&self, impact: &Impact, t: f64, h: f64) -> Option<FollowedImpact> {
        let matters = impact.lost > FOLLOWED_LOSS * impact.kinetic.max(self.largest.kinetic);
        if matters { FollowedImpact::new(impact, t, h) } else { None }
    }

    /// Records the energies at an impact of rods.
    pub(super) fn compare_rods(&mut self, impact: &Impact) {
        self.of_rods.add(impact.kinetic, impact.elastic);
    }

    /// Whether so much energy was lost in this impact that what rods give back matters.
    pub(super) fn may_doubt_rods(&self, stopped: &StoppedImpact) -> bool {
        self.of_rods.are_exceeded(stopped.lost, LOSS_OF_RODS)
    }

    /// Records the energy lost in a step with contact at one of its ends that has not stopped an impact, with the kinetic energy of the
    /// touching parts and the elastic energy.
    pub(super) fn follow(&mut self, lost: f64, kinetic: f64, elastic: f64) {
        self.largest.add(kinetic, elastic);
        self.is_known = true;
        self.missing += lost;
        self.most_missing = self.most_missing.max(self.missing);
    }

    /// The largest kinetic energy of colliding parts so far.
    pub(super) fn largest_kinetic(&self) -> f64 {
        self.largest.kinetic
    }

    /// The losses of an earlier time, with the current energies to which losses are compared.
    pub(super) fn without_losses_since(&self, before: &Self) -> Self {
        Self { largest: self.largest, ..*before }
    }

    /// Why a motion with steps of this size may be wrong, if much energy was lost.
    pub(super) fn doubt(&self, dt: f64, remedy: Remedy) -> Option<String> {
        let &Self { of_law: Losses { lost, .. }, largest, missing, most_missing, is_known, .. } = self;
        let all = lost + most_missing;
        let unexplained = if remedy == Remedy::Bounded { UNRESOLVED_LOSS } else { UNEXPLAINED_LOSS };
        let is_explained = !is_known || !largest.are_exceeded(lost + missing, unexplained);
        if is_explained && !largest.are_exceeded(all, LARGE_LOSS) {
            return None;
        }
        if most_missing > lost {
            return Some(format!(
                "Impacts take only a few steps of {} s, which do not resolve the contact forces: the motion loses {} J, \
                 {:.0} % of its largest kinetic energy, without dissipation. Take `dt={:.1e}` or less, {:.0} \
                 times less `stiffness`, or method \"radau\".{}",
                Number(dt),
                energy(all),
                100.0 * all / largest.kinetic,
                RECOMMENDED_STEP_FACTOR * dt,
                RECOMMENDED_STEP_FACTOR.powi(-2),
                remedy.about_others()
            ));
        }
        Some(sentence(&self.of_law, largest.kinetic, dt, remedy, ""))
    }

    /// The same of models in which rods touch, by what a motion loses that resolves the worst impact.
    pub(super) fn doubt_of_rods(
        &self,
        dt: f64,
        remedy: Remedy,
        stopped: &StoppedImpact,
        resolved: ResolvedLoss,
    ) -> Option<String> {
        let &StoppedImpact { t: at, contact, longest, .. } = stopped;
        let lost = stopped.lost - resolved.lost;
        let losses = Losses { lost, worst: lost, at, contact, longest };
        let found = if resolved.is_complete {
            " Rods give that back as waves, as short steps show in which they rebound."
        } else {
            " Rods may give that back as waves, which would take too much work to see."
        };
        let Largest { kinetic, .. } = self.of_rods;
        // What would take too much work is doubted where resolved impacts were asked for.
        let is_known = resolved.is_complete || remedy == Remedy::Bounded;
        (is_known && self.of_rods.are_exceeded(lost, LOSS_OF_RODS))
            .then(|| sentence(&losses, kinetic, dt, remedy, found))
    }

    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        // What rods may give back is looked for in the impacts after the state was stored only.
        let Self { of_law, largest: Largest { kinetic, elastic }, missing, most_missing, is_known, .. } =
            self;
        let Losses { lost, worst, at, contact, longest } = of_law;
        for number in [lost, worst, at, longest, kinetic, elastic, missing, most_missing] {
            tape.number(number);
        }
        tape.count(contact);
        tape.flag(is_known);
    }
}

/// Why losses matter, compared with the largest kinetic energy.
fn sentence(losses: &Losses, kinetic: f64, dt: f64, remedy: Remedy, found: &str) -> String {
    let &Losses { lost, worst, at, contact, longest } = losses;
    let softer = (longest / dt).powi(2);
    format!(
        "Impacts are shorter than steps of {} s, which suppress rebounds: the motion loses {} J, {:.0} % of \
         its largest kinetic energy, {} J of these in contacts[{contact}] at t = {at:.3} s.{found} Take `dt={longest:.1e}` or less, \
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
        remedy.about_others()
    )
}

/// A number of joules with four digits.
fn energy(joules: f64) -> String {
    if (0.1..1e4).contains(&joules) { format!("{joules:.3}") } else { format!("{joules:.3e}") }
}
