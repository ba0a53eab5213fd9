//! Inputs of motions to an accuracy: held for equal times, known beforehand or given by a controller, and the same in every run.

use crate::error::Interrupted;
use crate::model::Model;
use crate::simulation::simulate::{Control, Simulation};

/// Part of an interval by which rounding may put a time before the start of the interval.
const ROUNDING_OF_TIMES: f64 = 1e-9;

/// Inputs of a motion to an accuracy.
#[derive(Debug, Default)]
pub enum Inputs<'a> {
    /// Those of the model.
    #[default]
    Defaults,
    /// One row after the other, each for `step` seconds, the last one until the end.
    Rows {
        /// Duration in seconds.
        step: f64,
        /// Rows of one number for each input; at least one row.
        values: Vec<f64>,
    },
    /// Those that a controller gives. It is called once for each of its intervals, in one of the runs; the others have the same inputs.
    Controller(Control<'a>),
}

impl Inputs<'_> {
    /// Duration of an interval, if there are any.
    pub(super) fn step(&self) -> Option<f64> {
        match self {
            Self::Defaults => None,
            Self::Rows { step, .. } | Self::Controller(Control { step, .. }) => Some(*step),
        }
    }
}

/// What is given of a motion.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) t_span: (f64, f64),
    pub(super) start: [&'a [f64]; 2],
    /// Inputs, unless they have their defaults or are not known yet.
    pub(super) held: Option<&'a Held>,
    pub(super) t_eval: Option<&'a [f64]>,
}

/// Known inputs: rows that are held for equal times.
#[derive(Clone, Debug)]
pub(super) struct Held {
    start: f64,
    pub(super) step: f64,
    width: usize,
    values: Vec<f64>,
}

impl Held {
    /// Rows for a model with this number of inputs, from the time `start` on.
    pub(super) fn new(step: f64, values: Vec<f64>, width: usize, start: f64) -> Self {
        Self { start, step, width, values }
    }

    /// Whether inputs differ between rows.
    pub(super) fn varies(&self) -> bool {
        (1..self.len()).any(|k| self.row(k) != self.row(0))
    }

    /// Number of the rows.
    fn len(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// The row of an interval; the last one for later intervals.
    pub(super) fn row(&self, interval: usize) -> &[f64] {
        let row = interval.min(self.len().saturating_sub(1));
        &self.values[row * self.width..][..self.width]
    }

    /// The interval that contains this time, or begins there.
    fn interval(&self, t: f64) -> usize {
        ((t - self.start) / self.step + ROUNDING_OF_TIMES).max(0.0) as usize
    }

    /// Sets the inputs of this time. The time is to be set afterwards.
    pub(super) fn set<M: Model + ?Sized>(&self, model: &mut M, t: f64) {
        model.set_inputs(self.row(self.interval(t)));
    }

    /// The next time after this one at which inputs may jump.
    pub(super) fn horizon(&self, t: f64) -> f64 {
        let next = self.interval(t) + 1;
        if next < self.len() { self.start + next as f64 * self.step } else { f64::INFINITY }
    }
}

/// Sets the inputs at the i-th time of a motion, and the time.
pub(super) fn set_state<M: Model + ?Sized>(
    model: &mut M,
    motion: &Simulation,
    i: usize,
) -> Result<(), Interrupted> {
    let width = model.facts().inputs();
    if width > 0 && !motion.u.is_empty() {
        model.set_inputs(&motion.u[i * width..][..width]);
    }
    model.set_time(motion.t[i])
}

/// A state in which a controller was called.
pub(super) struct State {
    pub(super) t: f64,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
}

/// A controller, and the inputs that it has given.
pub(super) struct Recording<'a> {
    control: Control<'a>,
    pub(super) held: Held,
    /// Those of the last run.
    pub(super) states: Vec<State>,
}

impl<'a> Recording<'a> {
    /// For a model with this number of inputs, from the time `start` on.
    pub(super) fn new(control: Control<'a>, width: usize, start: f64) -> Self {
        let held = Held { start, step: control.step, width, values: Vec::new() };
        Self { control, held, states: Vec::new() }
    }

    /// The inputs of the intervals of a run, one after the other. What the controller has given in a run before is given again; it is called
    /// for later intervals alone.
    pub(super) fn of_run(
        &mut self,
    ) -> impl FnMut(f64, &[f64], &[f64], &mut [f64]) -> Result<(), Interrupted> + use<'a, '_> {
        let Self { control, held, states } = self;
        states.clear();
        let mut interval = 0;
        move |t, q, v, inputs| {
            states.push(State { t, q: q.to_vec(), v: v.to_vec() });
            if interval < held.len() {
                inputs.copy_from_slice(held.row(interval));
            } else {
                (control.inputs)(t, q, v, inputs)?;
                held.values.extend_from_slice(inputs);
            }
            interval += 1;
            Ok(())
        }
    }
}
