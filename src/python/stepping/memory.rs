//! A run with the additional data of its Python owner.

use pyo3::prelude::*;

use super::super::callback::{Raised, or_raised};
use super::super::choice::with_python_names;
use super::super::convert;
use super::super::model::{PyModel, Stepped};
use super::super::motion::signals;
use crate::error::{InvalidInput, Number};
use crate::python::errors::OrRaise as _;
use crate::simulation::methods::Configuration;
use crate::simulation::stepping::Status;
use crate::simulation::time_limit::TimeLimit;

/// Maximum number of steps of a model of one coordinate in a call before other threads may run: about 0.1 ms.
/// To reacquire the interpreter may take longer than a short call.
pub(super) const STEPS_WITH_INTERPRETER: usize = 256;

/// The status before the first step.
pub(super) const READY: &str = "ready";

#[derive(Clone, PartialEq)]
pub(super) struct Start {
    pub(super) t: f64,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
}

pub(super) struct Memory {
    pub(super) start: Start,
    pub(super) run: Box<dyn Stepped>,
    /// Limit of the wall-clock time of each interval.
    pub(super) limit: TimeLimit,
    /// Memory for inputs.
    pub(super) inputs: Vec<f64>,
    pub(super) outcome: Outcome,
}

/// Outcome of the last step.
#[derive(Clone)]
pub(super) enum Outcome {
    Ready,
    Ended(Status),
    /// A function raised an exception.
    Raised,
    /// Restored from another process: status, success and message.
    Told(String, bool, String),
}

impl Outcome {
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Ready => READY,
            Self::Ended(status) => status.name(),
            Self::Raised => "interrupted",
            Self::Told(status, ..) => status,
        }
    }

    pub(super) fn is_success(&self) -> bool {
        match self {
            Self::Ready => true,
            Self::Ended(status) => status.is_success(),
            Self::Raised => false,
            Self::Told(_, success, _) => *success,
        }
    }
}

impl Memory {
    /// A run from this start, with the initial accelerations computed.
    pub(super) fn begin(
        py: Python<'_>,
        model: &PyModel,
        configuration: &Configuration,
        limit: TimeLimit,
        start: Start,
    ) -> PyResult<Self> {
        let mut memory = Self::prepare(model, configuration, limit, start)?;
        let begun = or_raised(py.detach(|| memory.run.begin()))?;
        if let Some(status) = begun {
            memory.outcome = Outcome::Ended(status);
        }
        Ok(memory)
    }

    fn prepare(
        model: &PyModel,
        configuration: &Configuration,
        limit: TimeLimit,
        start: Start,
    ) -> PyResult<Self> {
        check_start_time(start.t).or_raise()?;
        let t_span = (start.t, start.t + configuration.dt());
        let run = model.native().run(t_span, &start.q, &start.v, configuration);
        let run = run.map_err(with_python_names).or_raise()?;
        run.end_of(None).or_raise()?;
        let inputs = run.inputs().to_vec();
        Ok(Self { start, run, limit, inputs, outcome: Outcome::Ready })
    }

    pub(super) fn message(&mut self) -> String {
        match &self.outcome {
            Outcome::Ready => "No step was made yet.".to_owned(),
            Outcome::Ended(Status::TimeLimit) => self.limit.message(Some(self.run.t())),
            Outcome::Ended(status) => self.run.explain(*status),
            Outcome::Raised => "The last step was ended by an exception.".to_owned(),
            Outcome::Told(.., message) => message.clone(),
        }
    }

    /// Advances to the end of this interval: a few steps with the interpreter, the rest without.
    pub(super) fn finish(&mut self, py: Python<'_>) -> PyResult<Status> {
        let mut raised = Raised::default();
        let mut limit = self.limit.again();
        let run = &mut *self.run;
        let finished = {
            let mut signals = signals(&mut raised);
            let mut monitor = |t| {
                limit.check(t)?;
                signals(t)
            };
            let with_interpreter = STEPS_WITH_INTERPRETER / run.state()[0].len().max(1);
            let mut step = || match run.watched_step(&mut monitor)? {
                None => monitor(run.t()).map(|()| None),
                status => Ok(status),
            };
            let first = (0..with_interpreter).find_map(|_| step().transpose());
            first.unwrap_or_else(|| py.detach(|| run.finish(&mut monitor)))
        };
        raised.into_result()?;
        if limit.is_reached() {
            return Ok(Status::TimeLimit);
        }
        Ok(finished.unwrap_or_else(|_| run.interrupted()))
    }

    /// An independent copy.
    pub(super) fn copy(&self) -> Self {
        Self {
            start: self.start.clone(),
            run: self.run.boxed_clone(),
            limit: self.limit,
            inputs: self.inputs.clone(),
            outcome: self.outcome.clone(),
        }
    }
}

/// Validates the start time, `t0` in messages.
pub(super) fn check_start_time(t0: f64) -> Result<(), InvalidInput> {
    if t0.is_finite() {
        Ok(())
    } else {
        Err(InvalidInput::new("t0", Number(t0), "a finite number (seconds)"))
    }
}

/// The initial state; zero by default.
pub(super) fn start(
    n: usize,
    q: Option<&Bound<'_, PyAny>>,
    v: Option<&Bound<'_, PyAny>>,
    t: f64,
) -> PyResult<Start> {
    let state = |value: Option<&Bound<'_, PyAny>>, name| match value {
        Some(value) => convert::finite_vector_of(value, n, name),
        None => Ok(vec![0.0; n]),
    };
    Ok(Start { t, q: state(q, "q0")?, v: state(v, "v0")? })
}
