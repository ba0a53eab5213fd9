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
const LOOKS: usize = 4;

/// A tendon is let go where it pushes by more than this part of the largest tension so far: less is rounding.
const PUSHES: f64 = 1e-10;

/// Where a step ends at which a tendon was to be let go, it pulls by less than this part of the largest tension.
const HARDLY_PULLS: f64 = 1e-4;

/// A step that ends at a change ends within this distance of it, in units of the model's length; for that its end is corrected as often.
const ON_THE_SPOT: f64 = 1e-12;
const MOST_CORRECTIONS: usize = 8;

/// Where a tendon that is taut is off by more than this within a step, in units of the model's length, it is told what no step of that
/// size follows.
const ASTRAY: f64 = 1e-3;

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
    /// A taut tendon is off by so much on the way: the step is shortened.
    Astray(f64),
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
pub(super) struct Look {
    /// Of every one, above zero behind its change: what it is passed by, or with what part of the largest tension it pushes.
    values: Vec<f64>,
    /// The highest of these, and its number.
    nearest: Point,
    which: usize,
    held: Vec<bool>,
    passed: Vec<[f64; 2]>,
    /// How far those are off that hold, here or on the way.
    astray: f64,
}

/// Looks at times within the last step.
pub(super) type Looks<'a> = dyn FnMut(f64) -> Result<Look, Interrupted> + 'a;

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

    /// Looks at a state of the last step.
    pub(super) fn look(
        &mut self,
        model: &mut dyn Model,
        t: f64,
        [q, v]: [&[f64]; 2],
    ) -> Result<Look, Interrupted> {
        model.set_time(t)?;
        let (passed, mut held) = (model.passed(q, v), model.held());
        let first = held.len() - passed.len();
        held.drain(..first);
        let mut multipliers = vec![0.0; first + passed.len()];
        if held.contains(&true) {
            // Without a mass there is no motion, either.
            let _ = saddle::accelerations(model, q, v, &mut vec![0.0; q.len()], &mut multipliers);
        }
        let tensions = &multipliers[first..];
        self.largest_tension =
            tensions.iter().fold(self.largest_tension, |largest, tension| largest.max(tension.abs()));
        let largest = self.largest_tension.max(f64::MIN_POSITIVE);
        let tendons = held.iter().zip(&passed).zip(tensions);
        let value = |((&is_held, [by, _]), tension): ((&bool, &[f64; 2]), &f64)| match is_held {
            true => -tension / largest - PUSHES,
            false => by - TAKEN_UP,
        };
        Ok(Look::new(t, tendons.map(value).collect(), held, passed))
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

/// Judges a step between two times of a leg that ends at `t_end`; the step was to end at an event if that was `planned`, after so many
/// corrections.
pub(super) fn judge(
    [t_old, t]: [f64; 2],
    t_end: f64,
    planned: Option<(Event, usize)>,
    look: &mut Looks<'_>,
) -> Result<Verdict, Interrupted> {
    let (found, end) = search([t_old, t], look)?;
    let (planned, corrections) = planned.map_or((None, 0), |(event, corrections)| (Some(event), corrections));
    let planned = planned.filter(|event| event.t == t);
    let is_planned = |event: Event| planned.is_some_and(|planned| planned.which == event.which);
    let event = match (found, planned) {
        (Some(event), _) if event.is_let_go && is_planned(event) => Event { t, ..event },
        (Some(event), _) => event,
        (None, Some(event)) if event.is_let_go && end.values[event.which] > -HARDLY_PULLS => event,
        (None, Some(event)) if event.is_let_go => return Ok(at_end(&end)),
        (None, Some(event)) => {
            let [by, rate] = end.passed[event.which];
            if rate <= 0.0 {
                return Ok(at_end(&end));
            }
            Event { t: if by.abs() <= ON_THE_SPOT { t } else { t - by / rate }, ..event }
        }
        (None, None) if end.astray > ASTRAY => return Ok(Verdict::Astray(end.astray)),
        (None, None) => return Ok(at_end(&end)),
    };
    let without = event.is_let_go.then_some(event.which);
    Ok(if event.t <= t_old {
        Verdict::ChangeAtStart(without)
    } else if event.t == t || corrections >= MOST_CORRECTIONS {
        Verdict::Change(without)
    } else if event.t >= t_end {
        Verdict::Done
    } else {
        Verdict::EndAt(event)
    })
}

/// The first event of a step, and what there is at its end.
fn search([t_old, t]: [f64; 2], look: &mut Looks<'_>) -> Result<(Option<Event>, Look), Interrupted> {
    let mut before = look(t_old)?;
    if before.nearest.value > 0.0 {
        let event = before.event();
        return Ok((Some(event), before));
    }
    for k in 1..=LOOKS {
        let time = if k == LOOKS { t } else { t_old + (t - t_old) * (k as f64 / LOOKS as f64) };
        let mut after = look(time)?;
        if after.nearest.value <= 0.0
            && let Some(top) = highest(&before, &after)
        {
            let there = look(top)?;
            if there.nearest.value > 0.0 {
                after = there;
            }
        }
        if after.nearest.value > 0.0 {
            let at = find_zero(before.nearest, after.nearest, |t| Ok(look(t)?.nearest.value))?;
            let found = look(at)?;
            let mut event = found.event();
            if !event.is_let_go {
                let [by, rate] = found.passed[event.which];
                event.t = if rate > 0.0 { (at - by / rate).clamp(t_old, t) } else { at };
            }
            return Ok((Some(event), after));
        }
        after.astray = after.astray.max(before.astray);
        before = after;
    }
    Ok((None, before))
}

/// Where what a tendon is told has a corner, it stops what moves or is slack.
fn at_end(end: &Look) -> Verdict {
    let is_left = |(&is_held, [_, rate]): (&bool, &[f64; 2])| is_held && rate.abs() > LEAVES;
    if end.held.iter().zip(&end.passed).any(is_left) { Verdict::Change(None) } else { Verdict::Done }
}

impl Look {
    fn new(t: f64, values: Vec<f64>, held: Vec<bool>, passed: Vec<[f64; 2]>) -> Self {
        let (mut nearest, mut which, mut astray) = (f64::NEG_INFINITY, 0, 0.0_f64);
        for (i, &value) in values.iter().enumerate() {
            (nearest, which) = if value > nearest { (value, i) } else { (nearest, which) };
            astray = if held[i] { astray.max(passed[i][0].abs()) } else { astray };
        }
        Self { values, nearest: Point { t, value: nearest }, which, held, passed, astray }
    }

    fn event(&self) -> Event {
        Event { t: self.nearest.t, which: self.which, is_let_go: self.held[self.which] }
    }
}

/// Where between two looks a tendon that is slack is longest, if it is longer there than at both, and may be too long.
fn highest(before: &Look, after: &Look) -> Option<f64> {
    let tendons = before.passed.iter().zip(&after.passed).zip(&before.held);
    let peaks =
        tendons.filter(|(([_, rises], [_, falls]), is_held)| !**is_held && *rises > 0.0 && *falls < 0.0);
    let h = after.nearest.t - before.nearest.t;
    // Of a parabola with these slopes.
    let peak = |(([by, rises], [_, falls]), _): (([f64; 2], [f64; 2]), bool)| {
        let x = rises / (rises - falls);
        (by + 0.5 * rises * x * h, before.nearest.t + x * h)
    };
    let peaks = peaks.map(|((a, b), held)| peak(((*a, *b), *held)));
    peaks.filter(|(height, _)| *height > -TAUT).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, t)| t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step with a tendon that is slack, longer than it is told by this and with this rate.
    fn judge_slack(
        excess: impl Fn(f64) -> [f64; 2],
        times: [f64; 2],
        planned: Option<(Event, usize)>,
    ) -> Verdict {
        let mut look = |t: f64| {
            let passed = vec![excess(t)];
            Ok(Look::new(t, vec![passed[0][0] - TAKEN_UP], vec![false], passed))
        };
        judge(times, 10.0, planned, &mut look).expect("nothing interrupts it")
    }

    #[test]
    fn steps_end_where_a_slack_tendon_is_as_long_as_it_is_told() {
        let fall = |t: f64| [t * t - 4.0, 2.0 * t];
        assert_eq!(judge_slack(fall, [0.0, 1.9], None), Verdict::Done);
        let Verdict::EndAt(event) = judge_slack(fall, [0.0, 3.0], None) else { panic!("it was passed") };
        assert!((event.t - 2.0).abs() < 1e-9 && !event.is_let_go);
        assert_eq!(
            judge_slack(fall, [0.0, 2.0], Some((Event { t: 2.0, ..event }, 1))),
            Verdict::Change(None)
        );
        // Too early: the same again, a little later.
        let Verdict::EndAt(corrected) =
            judge_slack(fall, [0.0, 1.999], Some((Event { t: 1.999, ..event }, 1)))
        else {
            panic!("it was not there yet")
        };
        assert!((corrected.t - 2.0).abs() < 1e-6);
    }

    #[test]
    fn an_end_that_is_reached_and_left_within_a_step_is_seen() {
        let throw = |t: f64| [1e-6 - (t - 0.47) * (t - 0.47), -2.0 * (t - 0.47)];
        let Verdict::EndAt(event) = judge_slack(throw, [0.0, 1.0], None) else { panic!("it was passed") };
        assert!((event.t - 0.469).abs() < 1e-6);
    }

    #[test]
    fn steps_end_where_a_taut_tendon_would_push() {
        let judge_taut = |by: f64, times: [f64; 2], planned: Option<(Event, usize)>| {
            let mut look = |t: f64| Ok(Look::new(t, vec![t - 2.0], vec![true], vec![[by, 0.0]]));
            judge(times, 10.0, planned, &mut look).expect("nothing interrupts it")
        };
        assert_eq!(judge_taut(0.0, [0.0, 1.9], None), Verdict::Done);
        let Verdict::EndAt(event) = judge_taut(0.0, [0.0, 3.0], None) else { panic!("it would push") };
        assert!((event.t - 2.0).abs() < 1e-12 && event.is_let_go);
        let reached = |t: f64| judge_taut(0.0, [0.0, t], Some((Event { t, ..event }, 1)));
        assert_eq!(reached(2.0 - 1e-6), Verdict::Change(Some(0)));
        assert_eq!(reached(1.5), Verdict::Done);
        // It is told what the step does not follow.
        assert_eq!(judge_taut(-0.01, [0.0, 1.9], None), Verdict::Astray(0.01));
    }

    #[test]
    fn changes_that_follow_each_other_quickly_are_a_chatter_and_others_are_not() {
        let mut changes = Changes::new((0.0, 1.0));
        assert!((0..10 * MOST_QUICK).all(|k| changes.count(1e-3 * k as f64, [0.0; 2])));
        let quick = (0..2 * MOST_QUICK).take_while(|_| changes.count(20.0, [1.0, 0.0])).count();
        assert_eq!(quick, MOST_QUICK + 1);
    }
}
