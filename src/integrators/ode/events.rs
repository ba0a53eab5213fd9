//! Events: zeros of functions of the solution.

use std::fmt;
use std::num::NonZeroUsize;

use super::dense::StepPolynomial;
use crate::error::Interrupted;
use crate::numerics::roots::bracket::{Point, find_zero};

/// Sign changes that count as events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// Both directions.
    #[default]
    Any,
    /// From negative to positive, in the order of the integration.
    Rising,
    /// From positive to negative, in the order of the integration.
    Falling,
}

/// A function g(t, y) of time and state.
pub type EventFunction<'a> = Box<dyn FnMut(f64, &[f64]) -> Result<f64, Interrupted> + 'a>;

/// An event function g(t, y), whose zeros along the solution are located.
///
/// An event occurs where g changes sign or reaches zero. Neither a zero at the start of the integration nor
/// leaving a zero is an event, so that an integration can be restarted from an event without finding it
/// again.
pub struct Event<'a> {
    /// g.
    pub function: EventFunction<'a>,
    /// Direction of the sign changes that count.
    pub direction: Direction,
    /// The integration ends at the event with this number; `None`: never.
    pub terminal: Option<NonZeroUsize>,
}

impl<'a> Event<'a> {
    /// An event for every zero of `function`, which does not end the integration.
    pub fn new(function: impl FnMut(f64, &[f64]) -> Result<f64, Interrupted> + 'a) -> Self {
        Self { function: Box::new(function), direction: Direction::Any, terminal: None }
    }

    /// Counts crossings in this direction only.
    pub fn direction(self, direction: Direction) -> Self {
        Self { direction, ..self }
    }

    /// Ends the integration at the first event.
    pub fn terminal(self) -> Self {
        Self { terminal: Some(NonZeroUsize::MIN), ..self }
    }
}

impl fmt::Debug for Event<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Event")
            .field("direction", &self.direction)
            .field("terminal", &self.terminal)
            .finish_non_exhaustive()
    }
}

/// A zero of an event function.
#[derive(Clone, Copy, Debug)]
pub(super) struct Occurrence {
    pub(super) event: usize,
    pub(super) t: f64,
}

/// Events of a step.
pub(super) struct Found<'a> {
    pub(super) occurrences: &'a [Occurrence],
    /// Whether the last event ends the integration.
    pub(super) terminal: bool,
}

/// Tracks the event functions along the integration.
#[derive(Debug)]
pub(super) struct EventSearch {
    samples: usize,
    // Last point of every function.
    last: Vec<Point>,
    // Sign of each function's last nonzero value (0 if there was none).
    signs: Vec<f64>,
    counts: Vec<usize>,
    found: Vec<Occurrence>,
    y: Vec<f64>,
}

impl EventSearch {
    /// Evaluates all functions at the start.
    pub(super) fn new(
        events: &mut [Event<'_>],
        samples: usize,
        t0: f64,
        y0: &[f64],
    ) -> Result<Self, Interrupted> {
        let mut last = Vec::with_capacity(events.len());
        for event in events.iter_mut() {
            last.push(Point { t: t0, value: (event.function)(t0, y0)? });
        }
        let signs = last.iter().map(|point| sign(point.value)).collect();
        Ok(Self {
            samples,
            last,
            signs,
            counts: vec![0; events.len()],
            found: Vec::new(),
            y: vec![0.0; y0.len()],
        })
    }

    /// Finds the events of a step, in the order of the integration, up to the first terminal one. `y` is the
    /// state at the end of the step.
    pub(super) fn search(
        &mut self,
        events: &mut [Event<'_>],
        step: StepPolynomial<'_>,
        y: &[f64],
    ) -> Result<Found<'_>, Interrupted> {
        self.found.clear();
        for (index, event) in events.iter_mut().enumerate() {
            for sample in 1..=self.samples {
                let at_end = sample == self.samples;
                let fraction = sample as f64 / self.samples as f64;
                let t = if at_end { step.t } else { step.t_old + fraction * (step.t - step.t_old) };
                let value = if at_end {
                    (event.function)(t, y)?
                } else {
                    step.evaluate(t, &mut self.y);
                    (event.function)(t, &self.y)?
                };
                let point = Point { t, value };
                if let Some(t) = self.crossing(index, event, step, point)? {
                    self.found.push(Occurrence { event: index, t });
                }
            }
        }
        let direction = if step.t < step.t_old { -1.0 } else { 1.0 };
        self.found.sort_by(|a, b| (direction * a.t).total_cmp(&(direction * b.t)));
        for (position, occurrence) in self.found.iter().enumerate() {
            let count = &mut self.counts[occurrence.event];
            *count += 1;
            if events[occurrence.event].terminal.is_some_and(|limit| *count >= limit.get()) {
                return Ok(Found { occurrences: &self.found[..=position], terminal: true });
            }
        }
        Ok(Found { occurrences: &self.found, terminal: false })
    }

    /// Advances to the next point of an event function; returns the zero in between, if it counts.
    fn crossing(
        &mut self,
        index: usize,
        event: &mut Event<'_>,
        step: StepPolynomial<'_>,
        point: Point,
    ) -> Result<Option<f64>, Interrupted> {
        let before = std::mem::replace(&mut self.last[index], point);
        let sign_before = self.signs[index];
        let sign_now = sign(point.value);
        if sign_now != 0.0 {
            self.signs[index] = sign_now;
        }
        let arrives = before.value != 0.0 && sign_before != 0.0 && sign_now != sign_before;
        let counts = match event.direction {
            Direction::Any => true,
            Direction::Rising => sign_before < 0.0,
            Direction::Falling => sign_before > 0.0,
        };
        if !arrives || !counts || point.value.is_nan() || before.value.is_nan() {
            return Ok(None);
        }
        let y = &mut self.y;
        find_zero(before, point, |t| {
            step.evaluate(t, y);
            (event.function)(t, y)
        })
        .map(Some)
    }
}

fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}
