//! Changes of one-sided constraints, for methods that locate them in time. The set of taut tendons is constant
//! within a step: a step in which a slack tendon exceeds its length, or a taut one would have to push, ends at
//! the time where this begins.

use crate::error::Interrupted;
use crate::model::Static;
use crate::model::constraint::one_sided::{ACTIVATION_EXCESS, SLACKENING_RATE, TAUT};
use crate::model::constraint::saddle;
use crate::numerics::roots::bracket::{Point, find_zero};
use crate::numerics::tape::Tape;

/// Each step is examined at this many times after its start, and at more if no tendon is taut: free motions are integrated
/// in long steps, and these looks need no tensions. Steps of fixed size are examined at their ends only.
const SAMPLES_OF_A_STEP: usize = 4;
const SAMPLES_WITHOUT_TENSION: usize = 16;

/// A tendon is released if it pushes by more than this part of the largest tension so far; less is rounding.
const PUSHING_FORCE: f64 = 1e-10;

/// At the end of a step that was planned to release a tendon, its tension must be below this part of the largest
/// tension.
const RELEASE_TENSION: f64 = 1e-4;

/// A step to a change ends within this distance of it, in units of the length of what the tendon joins, after at most
/// [`MOST_CORRECTIONS`] corrections.
const EVENT_TOLERANCE: f64 = 1e-12;
const MOST_CORRECTIONS: usize = 8;

/// If a taut tendon misses its length by more than this within a step, in the same units, the step
/// is too long for the prescribed length.
pub(super) const LARGEST_LENGTH_ERROR: f64 = 1e-3;

/// [`CHATTER_CHANGES`] changes in a row, each within this part of the interval after the one before, or within a step of fixed size, are
/// chattering.
const CHATTER_INTERVAL: f64 = 1e-6;
const CHATTER_CHANGES: usize = 100;

/// A one-sided constraint becomes active or inactive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Event {
    pub(super) t: f64,
    /// Index among the one-sided constraints, and whether it is released.
    pub(super) which: usize,
    pub(super) is_released: bool,
}

/// What to do after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// The step is over.
    Done,
    /// The step is over, and the active set changes at its end; this constraint, if any, is released.
    Change(Option<usize>),
    /// The active set already changes at the start of the step.
    ChangeAtStart(Option<usize>),
    /// Repeat the step so that it ends at this event.
    EndAt(Event),
    /// A taut tendon misses its length by this much within the step, in metres: shorten the step.
    LengthError(f64),
}

/// The changes of a run.
#[derive(Clone, Debug)]
pub(super) struct Changes {
    /// Start and end of the interval.
    pub(super) t_span: (f64, f64),
    pub(super) has_begun: bool,
    /// Set if the active set changes at the current state; the constraint inside, if any, is released.
    pub(super) due: Option<Option<usize>>,
    /// Set if lengths jump over the next step of fixed size, or did over the last one.
    pub(super) jumps: bool,
    pub(super) has_jumped: bool,
    /// The largest excess of a tendon over its length at the end of such a step, in units of the length of what it joins, and its time.
    pub(super) missed: Option<(f64, f64)>,
    /// Energy lost in changes and work done in them since they were last taken.
    pub(super) flow: Option<[f64; 2]>,
    /// Time of the last change, and the number of quick changes in a row.
    last: f64,
    quick: usize,
    pub(super) largest_tension: f64,
}

/// How close the constraints are to a change at a given time.
pub(super) struct ChangeIndicator {
    /// For each constraint, positive after its change: the violation, or the push relative to the largest tension.
    values: Vec<f64>,
    /// The largest of these values, and its index.
    nearest: Point,
    which: usize,
    active: Vec<bool>,
    passed: Vec<[f64; 2]>,
    /// Largest error of the active constraints, here or earlier in the step: relative, and in metres.
    length_error: [f64; 2],
}

/// Evaluates [`ChangeIndicator`] at a time within the last step.
pub(super) type IndicatorFunction<'a> = dyn FnMut(f64) -> Result<ChangeIndicator, Interrupted> + 'a;

impl Changes {
    pub(super) fn new(t_span: (f64, f64)) -> Self {
        Self {
            t_span,
            has_begun: false,
            due: None,
            jumps: false,
            has_jumped: false,
            missed: None,
            flow: None,
            last: f64::NEG_INFINITY,
            quick: 0,
            largest_tension: 0.0,
        }
    }

    /// Records a change, between steps of a fixed size if one is given. Returns false if the constraints chatter.
    pub(super) fn count(&mut self, t: f64, flow: [f64; 2], step: Option<f64>) -> bool {
        let (from, to) = self.t_span;
        let is_quick = t - self.last <= step.unwrap_or(CHATTER_INTERVAL * (to - from));
        self.quick = if is_quick { self.quick + 1 } else { 0 };
        self.last = t;
        self.add_flow(flow);
        self.quick <= CHATTER_CHANGES
    }

    /// Adds energy lost and work done.
    pub(super) fn add_flow(&mut self, [lost, work]: [f64; 2]) {
        let before = self.flow.unwrap_or_default();
        self.flow = Some([before[0] + lost, before[1] + work]);
    }

    /// Examines a state of the last step, with the multipliers of the active constraints if they are known. Allocates.
    pub(super) fn indicator(
        &mut self,
        model: &mut dyn Static,
        t: f64,
        [q, v]: [&[f64]; 2],
        known: Option<Vec<f64>>,
    ) -> Result<ChangeIndicator, Interrupted> {
        model.set_time(t)?;
        let (passed, mut active) = (model.passed(q, v), model.active());
        let first = active.len() - passed.len();
        active.drain(..first);
        let (is_known, sizes) = (known.is_some(), model.facts().gap_sizes.clone());
        let mut multipliers = known.unwrap_or_else(|| vec![0.0; sizes.len()]);
        if !is_known && active.contains(&true) {
            // A singular mass is reported by the step itself.
            let _ = saddle::accelerations(model, q, v, &mut vec![0.0; q.len()], &mut multipliers);
        }
        let tensions = &multipliers[first..];
        self.largest_tension =
            tensions.iter().fold(self.largest_tension, |largest, tension| largest.max(tension.abs()));
        let largest = self.largest_tension.max(f64::MIN_POSITIVE);
        let tendons = active.iter().zip(&passed).zip(tensions);
        let value = |((&is_active, [by, _]), tension): ((&bool, &[f64; 2]), &f64)| match is_active {
            true => -tension / largest - PUSHING_FORCE,
            false => by - ACTIVATION_EXCESS,
        };
        let values = tendons.map(value).collect();
        Ok(ChangeIndicator::new(t, values, active, passed, &sizes[first..]))
    }

    /// Data that persist from interval to interval.
    pub(super) fn serialise(&mut self, model: &mut dyn Static, tape: &mut Tape<'_>) {
        tape.flag(&mut self.has_begun);
        let number = |which: Option<usize>| which.map_or(0, |which| which + 1);
        let mut due = self.due.map(number);
        tape.optional(&mut due, 0, Tape::count);
        self.due = due.map(|due| due.checked_sub(1));
        tape.number(&mut self.last);
        tape.count(&mut self.quick);
        tape.number(&mut self.largest_tension);
        let mut active = model.active();
        active.iter_mut().for_each(|is_active| tape.flag(is_active));
        if tape.reads() && self.has_begun {
            let active: Vec<f64> =
                active.into_iter().map(|is_active| f64::from(u8::from(is_active))).collect();
            model.keep_active_set(false);
            model.release(&active);
            model.keep_active_set(true);
        }
    }

    /// Serialises the data of steps of fixed size about lengths that jump.
    pub(super) fn serialise_jumps(&mut self, tape: &mut Tape<'_>) {
        tape.flag(&mut self.jumps);
        tape.flag(&mut self.has_jumped);
        tape.optional(&mut self.missed, (0.0, 0.0), |tape, (by, t)| {
            tape.number(by);
            tape.number(t);
        });
    }
}

/// Judges a step between two times of an interval that ends at `t_end`. `planned` is the event at which the step was
/// planned to end, with the number of corrections made so far.
pub(super) fn judge(
    [t_old, t]: [f64; 2],
    t_end: f64,
    is_fixed: bool,
    planned: Option<(Event, usize)>,
    indicator: &mut IndicatorFunction<'_>,
) -> Result<Verdict, Interrupted> {
    let (found, end) = search([t_old, t], is_fixed, indicator)?;
    let (planned, corrections) = planned.map_or((None, 0), |(event, corrections)| (Some(event), corrections));
    let planned = planned.filter(|event| event.t == t);
    let is_planned = |event: Event| planned.is_some_and(|planned| planned.which == event.which);
    let event = match (found, planned) {
        (Some(event), _) if event.is_released && is_planned(event) => Event { t, ..event },
        (Some(event), _) => event,
        (None, Some(event)) if event.is_released && end.values[event.which] > -RELEASE_TENSION => event,
        (None, Some(event)) if event.is_released => return Ok(at_end(&end)),
        (None, Some(event)) => {
            let [by, rate] = end.passed[event.which];
            if rate <= 0.0 {
                return Ok(at_end(&end));
            }
            Event { t: if by.abs() <= EVENT_TOLERANCE { t } else { t - by / rate }, ..event }
        }
        (None, None) if end.length_error[0] > LARGEST_LENGTH_ERROR => {
            return Ok(Verdict::LengthError(end.length_error[1]));
        }
        (None, None) => return Ok(at_end(&end)),
    };
    let without = event.is_released.then_some(event.which);
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

/// The first event in a step, and the constraints at its end.
fn search(
    [t_old, t]: [f64; 2],
    is_fixed: bool,
    indicator: &mut IndicatorFunction<'_>,
) -> Result<(Option<Event>, ChangeIndicator), Interrupted> {
    let mut before = indicator(t_old)?;
    if before.nearest.value > 0.0 {
        let event = before.event();
        return Ok((Some(event), before));
    }
    let looks = match before.active.contains(&true) {
        _ if is_fixed => 1,
        true => SAMPLES_OF_A_STEP,
        false => SAMPLES_WITHOUT_TENSION,
    };
    for k in 1..=looks {
        let time = if k == looks { t } else { t_old + (t - t_old) * (k as f64 / looks as f64) };
        let mut after = indicator(time)?;
        if after.nearest.value <= 0.0
            && let Some(top) = highest(&before, &after)
        {
            let there = indicator(top)?;
            if there.nearest.value > 0.0 {
                after = there;
            }
        }
        if after.nearest.value > 0.0 {
            let at = find_zero(before.nearest, after.nearest, |t| Ok(indicator(t)?.nearest.value))?;
            let found = indicator(at)?;
            let mut event = found.event();
            if !event.is_released {
                let [by, rate] = found.passed[event.which];
                event.t = if rate > 0.0 { (at - by / rate).clamp(t_old, t) } else { at };
            }
            return Ok((Some(event), after));
        }
        after.length_error = if before.length_error[0] > after.length_error[0] {
            before.length_error
        } else {
            after.length_error
        };
        before = after;
    }
    Ok((None, before))
}

/// At a corner of a prescribed length, a taut tendon stops the motion or becomes slack.
fn at_end(end: &ChangeIndicator) -> Verdict {
    let is_left = |(&is_active, [_, rate]): (&bool, &[f64; 2])| is_active && rate.abs() > SLACKENING_RATE;
    if end.active.iter().zip(&end.passed).any(is_left) { Verdict::Change(None) } else { Verdict::Done }
}

impl ChangeIndicator {
    fn new(t: f64, values: Vec<f64>, active: Vec<bool>, passed: Vec<[f64; 2]>, sizes: &[f64]) -> Self {
        let (mut nearest, mut which, mut length_error) = (f64::NEG_INFINITY, 0, [0.0_f64; 2]);
        for (i, &value) in values.iter().enumerate() {
            (nearest, which) = if value > nearest { (value, i) } else { (nearest, which) };
            let by = passed[i][0].abs();
            length_error = if active[i] && by > length_error[0] { [by, by * sizes[i]] } else { length_error };
        }
        Self { values, nearest: Point { t, value: nearest }, which, active, passed, length_error }
    }

    fn event(&self) -> Event {
        Event { t: self.nearest.t, which: self.which, is_released: self.active[self.which] }
    }
}

/// The time between two samples at which a slack tendon is longest, if its length peaks between them and may be too large.
fn highest(before: &ChangeIndicator, after: &ChangeIndicator) -> Option<f64> {
    let tendons = before.passed.iter().zip(&after.passed).zip(&before.active);
    let peaks =
        tendons.filter(|(([_, rises], [_, falls]), is_active)| !**is_active && *rises > 0.0 && *falls < 0.0);
    let h = after.nearest.t - before.nearest.t;
    // The vertex of the parabola with these slopes.
    let peak = |(([by, rises], [_, falls]), _): (([f64; 2], [f64; 2]), bool)| {
        let x = rises / (rises - falls);
        (by + 0.5 * rises * x * h, before.nearest.t + x * h)
    };
    let peaks = peaks.map(|((a, b), active)| peak(((*a, *b), *active)));
    peaks.filter(|(height, _)| *height > -TAUT).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, t)| t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Judges a step with a slack tendon that exceeds its length by this much, at this rate.
    fn judge_slack(
        excess: impl Fn(f64) -> [f64; 2],
        times: [f64; 2],
        planned: Option<(Event, usize)>,
    ) -> Verdict {
        let mut indicator = |t: f64| {
            let passed = vec![excess(t)];
            Ok(ChangeIndicator::new(t, vec![passed[0][0] - ACTIVATION_EXCESS], vec![false], passed, &[1.0]))
        };
        judge(times, 10.0, false, planned, &mut indicator).expect("nothing interrupts it")
    }

    #[test]
    fn steps_end_where_a_slack_tendon_reaches_its_commanded_length() {
        let fall = |t: f64| [t * t - 4.0, 2.0 * t];
        assert_eq!(judge_slack(fall, [0.0, 1.9], None), Verdict::Done);
        let Verdict::EndAt(event) = judge_slack(fall, [0.0, 3.0], None) else { panic!("it was passed") };
        assert!((event.t - 2.0).abs() < 1e-9 && !event.is_released);
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
            let mut indicator =
                |t: f64| Ok(ChangeIndicator::new(t, vec![t - 2.0], vec![true], vec![[by, 0.0]], &[1.0]));
            judge(times, 10.0, false, planned, &mut indicator).expect("nothing interrupts it")
        };
        assert_eq!(judge_taut(0.0, [0.0, 1.9], None), Verdict::Done);
        let Verdict::EndAt(event) = judge_taut(0.0, [0.0, 3.0], None) else { panic!("it would push") };
        assert!((event.t - 2.0).abs() < 1e-12 && event.is_released);
        let reached = |t: f64| judge_taut(0.0, [0.0, t], Some((Event { t, ..event }, 1)));
        assert_eq!(reached(2.0 - 1e-6), Verdict::Change(Some(0)));
        assert_eq!(reached(1.5), Verdict::Done);
        // The prescribed length changes faster than the step follows.
        assert_eq!(judge_taut(-0.01, [0.0, 1.9], None), Verdict::LengthError(0.01));
    }

    #[test]
    fn changes_that_follow_each_other_quickly_are_a_chatter_and_others_are_not() {
        let mut changes = Changes::new((0.0, 1.0));
        assert!((0..10 * CHATTER_CHANGES).all(|k| changes.count(1e-3 * k as f64, [0.0; 2], None)));
        let quick = (0..2 * CHATTER_CHANGES).take_while(|_| changes.count(20.0, [1.0, 0.0], None)).count();
        assert_eq!(quick, CHATTER_CHANGES + 1);
    }
}
