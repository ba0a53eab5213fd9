//! Constraints that hold one way only, for methods that find the time at which they change: within a step those hold that held at
//! its start. A step on which a tendon that is slack becomes longer than it is told, or one that is taut would have to push, ends
//! where it begins to.

use crate::constraint::one_sided::{LEAVES, TAKEN_UP, TAUT};
use crate::constraint::saddle;
use crate::error::Interrupted;
use crate::model::Model;
use crate::roots::bracket::{Point, find_zero};
use crate::tape::Tape;

/// At so many times of a step it is looked.
const LOOKS: usize = 5;

/// A tendon is let go where it pushes by more than this part of the largest tension so far: less is rounding.
const PUSHES: f64 = 1e-10;

/// A step that ends at a change ends within this distance of it, in units of the model's length; for that its end is corrected as often.
const ON_THE_SPOT: f64 = 1e-12;
const MOST_CORRECTIONS: usize = 8;

/// Changes that follow each other within this part of the way are a chatter when there are as many in a row.
const QUICK: f64 = 1e-6;
const MOST_QUICK: usize = 100;

/// One of the constraints that hold one way only begins or ceases to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Event {
    pub(super) t: f64,
    /// Its number among them, and whether it is let go.
    pub(super) which: usize,
    pub(super) is_let_go: bool,
}

/// What an end of a step calls for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// The step is over.
    Done,
    /// The step is over, and others hold from there on: without this one, if there is one.
    Change(Option<usize>),
    /// Others hold already from the start of the step on.
    ChangeAtStart(Option<usize>),
    /// The step ends there.
    EndAt(Event),
}

/// The changes of a run.
#[derive(Clone, Debug)]
pub(super) struct Changes {
    /// The leg.
    pub(super) t_span: (f64, f64),
    pub(super) has_begun: bool,
    /// Others hold from the current state on: without this one, if there is one.
    pub(super) due: Option<Option<usize>>,
    /// Energy that the last change has taken out, and its work, until somebody takes note.
    pub(super) flow: Option<[f64; 2]>,
    /// The time of the last change, and how many have followed each other quickly.
    last: f64,
    quick: usize,
    largest_tension: f64,
}

/// How near constraints are to a change at a time.
struct Look {
    t: f64,
    /// Of the one that is nearest, above zero behind the change, and its number.
    nearest: Point,
    which: usize,
    held: Vec<bool>,
    passed: Vec<[f64; 2]>,
}

/// States within the last step, and the model.
pub(super) type States<'a> =
    dyn FnMut(f64, &mut dyn FnMut(&mut dyn Model, [&[f64]; 2])) -> Result<(), Interrupted> + 'a;

impl Changes {
    pub(super) fn new(t_span: (f64, f64)) -> Self {
        Self {
            t_span,
            has_begun: false,
            due: None,
            flow: None,
            last: f64::NEG_INFINITY,
            quick: 0,
            largest_tension: 0.0,
        }
    }

    /// Takes note of a change. False where they do not come to an end.
    pub(super) fn count(&mut self, t: f64, flow: [f64; 2]) -> bool {
        let (from, to) = self.t_span;
        let is_quick = t - self.last <= QUICK * (to - from);
        self.quick = if is_quick { self.quick + 1 } else { 0 };
        self.last = t;
        let before = self.flow.unwrap_or_default();
        self.flow = Some([before[0] + flow[0], before[1] + flow[1]]);
        self.quick <= MOST_QUICK
    }

    /// Judges a step between two times, which was to end at an event if it was `planned`.
    pub(super) fn judge(
        &mut self,
        [t_old, t]: [f64; 2],
        planned: Option<(Event, usize)>,
        states: &mut States<'_>,
    ) -> Result<Verdict, Interrupted> {
        let (found, end) = self.search([t_old, t], states)?;
        let (planned, corrections) =
            planned.map_or((None, 0), |(event, corrections)| (Some(event), corrections));
        let planned = planned.filter(|event| event.t == t);
        let is_planned = |event: Event| planned.is_some_and(|planned| planned.which == event.which);
        let event = match (found, planned) {
            (Some(event), _) if event.is_let_go && is_planned(event) => Event { t, ..event },
            (Some(event), _) => event,
            (None, Some(event)) if event.is_let_go => event,
            (None, Some(event)) => {
                let [by, rate] = end.passed[event.which];
                if rate <= 0.0 {
                    return Ok(self.at_end(&end));
                }
                Event { t: if by.abs() <= ON_THE_SPOT { t } else { t - by / rate }, ..event }
            }
            (None, None) => return Ok(self.at_end(&end)),
        };
        let without = event.is_let_go.then_some(event.which);
        Ok(if event.t <= t_old {
            Verdict::ChangeAtStart(without)
        } else if event.t == t || corrections >= MOST_CORRECTIONS {
            Verdict::Change(without)
        } else if event.t >= self.t_span.1 {
            Verdict::Done
        } else {
            Verdict::EndAt(event)
        })
    }

    /// Where what a tendon is told has a corner, it stops what moves or is slack.
    fn at_end(&self, end: &Look) -> Verdict {
        let is_left = |(&is_held, [_, rate]): (&bool, &[f64; 2])| is_held && rate.abs() > LEAVES;
        if end.held.iter().zip(&end.passed).any(is_left) { Verdict::Change(None) } else { Verdict::Done }
    }

    /// The first event of a step, and what there is at its end.
    fn search(
        &mut self,
        [t_old, t]: [f64; 2],
        states: &mut States<'_>,
    ) -> Result<(Option<Event>, Look), Interrupted> {
        let mut before = self.look(t_old, states)?;
        if before.nearest.value > 0.0 {
            let event = before.event();
            return Ok((Some(event), before));
        }
        for k in 1..=LOOKS {
            let time = if k == LOOKS { t } else { t_old + (t - t_old) * (k as f64 / LOOKS as f64) };
            let mut after = self.look(time, states)?;
            if after.nearest.value <= 0.0
                && let Some(top) = highest(&before, &after)
            {
                let there = self.look(top, states)?;
                if there.nearest.value > 0.0 {
                    after = there;
                }
            }
            if after.nearest.value > 0.0 {
                let at =
                    find_zero(before.nearest, after.nearest, |t| Ok(self.look(t, states)?.nearest.value))?;
                let found = self.look(at, states)?;
                let mut event = found.event();
                if !event.is_let_go {
                    let [by, rate] = found.passed[event.which];
                    event.t = if rate > 0.0 { (at - by / rate).clamp(t_old, t) } else { at };
                }
                return Ok((Some(event), after));
            }
            before = after;
        }
        Ok((None, before))
    }

    fn look(&mut self, t: f64, states: &mut States<'_>) -> Result<Look, Interrupted> {
        let (mut found, mut nearest) = (Ok(()), (f64::NEG_INFINITY, 0));
        let (mut held, mut passed) = (Vec::new(), Vec::new());
        states(t, &mut |model, [q, v]| {
            found = model.set_time(t);
            passed = model.passed(q, v);
            held = model.held();
            let first = held.len() - passed.len();
            held.drain(..first);
            let mut multipliers = vec![0.0; first + passed.len()];
            if held.contains(&true) {
                // Without a mass there is no motion, either.
                let _ = saddle::accelerations(model, q, v, &mut vec![0.0; q.len()], &mut multipliers);
            }
            let tensions = &multipliers[first..];
            let largest = tensions.iter().fold(self.largest_tension, |largest, x| largest.max(x.abs()));
            self.largest_tension = largest;
            for (i, &is_held) in held.iter().enumerate() {
                let value = match is_held {
                    true => -tensions[i] / largest.max(f64::MIN_POSITIVE) - PUSHES,
                    false => passed[i][0] - TAKEN_UP,
                };
                nearest = if value > nearest.0 { (value, i) } else { nearest };
            }
        })?;
        found?;
        let (value, which) = nearest;
        Ok(Look { t, nearest: Point { t, value }, which, held, passed })
    }

    /// What goes on from leg to leg.
    pub(super) fn carry(&mut self, model: &mut dyn Model, tape: &mut Tape<'_>) {
        tape.flag(&mut self.has_begun);
        let number = |which: Option<usize>| which.map_or(0, |which| which + 1);
        let mut due = self.due.map(number);
        tape.optional(&mut due, 0, Tape::count);
        self.due = due.map(|due| due.checked_sub(1));
        tape.number(&mut self.last);
        tape.count(&mut self.quick);
        tape.number(&mut self.largest_tension);
        let mut held = model.held();
        held.iter_mut().for_each(|is_held| tape.flag(is_held));
        if tape.reads() && self.has_begun {
            let held: Vec<f64> = held.into_iter().map(|is_held| f64::from(u8::from(is_held))).collect();
            model.keep_held(false);
            model.release(&held);
            model.keep_held(true);
        }
    }
}

impl Look {
    fn event(&self) -> Event {
        Event { t: self.t, which: self.which, is_let_go: self.held[self.which] }
    }
}

/// Where between two looks a tendon that is slack is longest, if it is longer there than at both, and may be too long.
fn highest(before: &Look, after: &Look) -> Option<f64> {
    let tendons = before.passed.iter().zip(&after.passed).zip(&before.held);
    let peaks =
        tendons.filter(|(([_, rises], [_, falls]), is_held)| !**is_held && *rises > 0.0 && *falls < 0.0);
    let h = after.t - before.t;
    // Of a parabola with these slopes.
    let peak = |(([by, rises], [_, falls]), _): (([f64; 2], [f64; 2]), bool)| {
        let x = rises / (rises - falls);
        (by + 0.5 * rises * x * h, before.t + x * h)
    };
    let peaks = peaks.map(|((a, b), held)| peak(((*a, *b), *held)));
    peaks.filter(|(height, _)| *height > -TAUT).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, t)| t)
}
