//! Impacts that fixed steps have not resolved: what these would have given back is lost, at once where a step stops what meets,
//! and bit by bit where a few steps see too little of how forces rise and fall.

use crate::error::Number;
use crate::model::Impact;
use crate::numerics::tape::Tape;

/// Losses of more than this part of the largest kinetic energy cause a doubt. What stops at once loses all of it; a rod that comes to
/// lie on a floor meets it bit by bit and loses a tenth.
const LOSS: f64 = 0.25;

/// So do losses of this part where nothing dissipates, which nothing explains. A ball that seven steps push back has two hundredths of
/// its energy less, or more.
const UNEXPLAINED: f64 = 0.06;

/// Both do if they exceed this part of the elastic energy too: what is pressed slowly has hardly any kinetic energy to lose.
const AT_REST: f64 = 0.1;

/// What loses energy in a few steps keeps it in steps of that part.
const SHORTER: f64 = 0.25;

/// What can be done about impacts that steps have stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Remedy {
    /// Fixed steps can resolve them.
    Resolve,
    /// They do, but not with more work.
    Bounded,
    /// Only shorter steps or another method.
    Shorten,
}

/// The impacts of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Impacts {
    /// Energy that resolved impacts would have given back, in joules: of all, and of the worst one.
    lost: f64,
    worst: f64,
    /// When that was, the contact it was in, and the steps that would have resolved it.
    at: f64,
    contact: usize,
    longest: f64,
    /// The largest kinetic energy of what takes part in an impact, and the largest elastic one at impacts.
    kinetic: f64,
    elastic: f64,
    /// Energy that other steps have lost where surfaces touch and nothing took it, so far and at most: in an impact it falls and
    /// rises.
    missing: f64,
    most_missing: f64,
    /// Whether that is known, as nothing dissipates.
    is_known: bool,
}

impl Impacts {
    pub(super) fn count(&mut self, t: f64, impact: &Impact) {
        self.kinetic = self.kinetic.max(impact.kinetic);
        self.elastic = self.elastic.max(impact.elastic);
        // Only what moved can rebound: what is pressed slowly loses energy to friction and bases.
        let lost = impact.lost.min(impact.kinetic);
        self.lost += lost;
        if lost > self.worst {
            (self.worst, self.at) = (lost, t);
            (self.contact, self.longest) = (impact.contact, impact.longest);
        }
    }

    /// Takes note of what a step has lost at one of whose ends surfaces touch, unless it stops what meets, of the kinetic energy of what
    /// they press, and of the elastic one.
    pub(super) fn follow(&mut self, lost: f64, kinetic: f64, elastic: f64) {
        self.kinetic = self.kinetic.max(kinetic);
        self.elastic = self.elastic.max(elastic);
        self.is_known = true;
        self.missing += lost;
        self.most_missing = self.most_missing.max(self.missing);
    }

    /// The largest kinetic energy of what takes part in an impact so far.
    pub(super) fn largest_kinetic(&self) -> f64 {
        self.kinetic
    }

    /// As before these losses, but for the sizes to which losses are compared.
    pub(super) fn without_losses_since(&self, before: &Self) -> Self {
        Self { kinetic: self.kinetic, elastic: self.elastic, ..*before }
    }

    /// Why a motion with steps of this size may be wrong, if they have lost much.
    pub(super) fn doubt(&self, dt: f64, remedy: Remedy) -> Option<String> {
        let &Self { lost, worst, at, contact, longest, kinetic, elastic, missing, most_missing, is_known } =
            self;
        let all = lost + most_missing;
        let exceeds = |loss: f64, part: f64| loss > (part * kinetic).max(AT_REST.min(part) * elastic);
        let is_explained = !is_known || !exceeds(lost + missing, UNEXPLAINED);
        if kinetic == 0.0 || is_explained && !exceeds(all, LOSS) {
            return None;
        }
        if most_missing > lost {
            return Some(format!(
                "Impacts take only a few steps of {} s, which do not see all of what pushes surfaces apart: they take {} J out of \
                 the motion, {:.0} % of its largest kinetic energy, though nothing dissipates that. Take `dt={:.1e}` or less, {:.0} \
                 times less `stiffness`, or method \"radau\".",
                Number(dt),
                energy(all),
                100.0 * all / kinetic,
                SHORTER * dt,
                SHORTER.powi(-2)
            ));
        }
        let softer = (longest / dt).powi(2);
        Some(format!(
            "Impacts are shorter than steps of {} s, which stop what should rebound: they take {} J out of the motion, {:.0} % of \
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
            if remedy == Remedy::Bounded {
                " Steps of this size have resolved others, with half as much work as for all else."
            } else {
                ""
            }
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

/// With four digits.
fn energy(joules: f64) -> String {
    if (0.1..1e4).contains(&joules) { format!("{joules:.3}") } else { format!("{joules:.3e}") }
}
