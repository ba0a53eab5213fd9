//! A limit of the wall-clock time of a run.

use std::time::Instant;

use crate::error::{Checker, Interrupted, InvalidInput, Number, Time};
use crate::simulation::simulate::Simulation;
use crate::simulation::stepping::Status;

/// Stops a run when its time is up, through its monitor, also within a step that takes many evaluations.
///
/// ```
/// use lissom::newmark;
/// use lissom::pendulum::SpringPendulum;
/// use lissom::simulate::{Method, simulate};
/// use lissom::time_limit::TimeLimit;
///
/// let pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
/// let method = Method::Newmark(newmark::Options::new(1e-3));
/// let mut limit = TimeLimit::new(Some(1e-3), 1e4)?;
/// let mut motion = simulate(pendulum, (0.0, 1e4), &[0.1; 2], &[0.0; 2], &method, None, &mut |t| limit.check(t))?;
/// limit.judge(&mut motion);
/// assert_eq!(motion.status.name(), "time_limit");
/// # Ok::<(), lissom::error::InvalidInput>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TimeLimit {
    seconds: Option<f64>,
    t_end: f64,
    start: Instant,
    is_reached: bool,
}

impl TimeLimit {
    /// A limit of a run to this time that counts from now on; `None` is no limit.
    pub fn new(seconds: Option<f64>, t_end: f64) -> Result<Self, InvalidInput> {
        let mut check = Checker::new();
        if let Some(seconds) = seconds {
            check.positive(seconds, "max_seconds", "seconds of wall-clock time");
        }
        check.finish()?;
        Ok(Self { seconds, t_end, start: Instant::now(), is_reached: false })
    }

    /// The same limit, counted from now on.
    pub fn again(&self) -> Self {
        Self { start: Instant::now(), is_reached: false, ..*self }
    }

    /// Requests a stop if the time is up at a step to the time `t` that is not the last one; to be called by a monitor.
    pub fn check(&mut self, t: f64) -> Result<(), Interrupted> {
        if t < self.t_end && self.seconds.is_some_and(|seconds| self.start.elapsed().as_secs_f64() >= seconds)
        {
            self.is_reached = true;
            return Err(Interrupted);
        }
        Ok(())
    }

    /// Whether this limit stopped the run.
    pub fn is_reached(&self) -> bool {
        self.is_reached
    }

    /// Sets status and message of a run that this limit stopped.
    pub fn judge(&self, simulation: &mut Simulation) {
        if self.is_reached && simulation.status.is_interrupted() {
            simulation.status = Status::TimeLimit;
            simulation.message = self.message(simulation.t.last().copied()) + &simulation.held;
        }
    }

    /// The message of a run that this limit stopped at this time.
    pub fn message(&self, t: Option<f64>) -> String {
        let seconds = Number(self.seconds.unwrap_or(f64::INFINITY));
        let reached = t.map_or_else(String::new, |t| format!(" at t = {}", Time(t)));
        format!(
            "The limit of {seconds} s of wall-clock time was reached{reached}: what was computed until then is kept. Allow more \
             `max_seconds`, or make the run cheaper: longer steps, fewer modes, softer contacts."
        )
    }
}
