//! Collects the requested states of a run.

use crate::error::Interrupted;
use crate::model::Model;
use crate::simulation::stepping::Run;

/// Records states at given times, or after every step.
pub(super) struct Recorder<'a> {
    t_eval: Option<&'a [f64]>,
    n: usize,
    /// Whether accelerations are recorded.
    knows_accelerations: bool,
    pub(super) t: Vec<f64>,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) a: Vec<f64>,
    /// Inputs from each of these times on.
    pub(super) u: Vec<f64>,
    /// Evaluations of the residual up to each of these times.
    pub(super) evaluations: Vec<usize>,
}

impl<'a> Recorder<'a> {
    pub(super) fn new<M: Model>(run: &Run<M>, points: usize, t_eval: Option<&'a [f64]>) -> Self {
        let (n, knows_accelerations) = (run.q().len(), run.knows_accelerations());
        let numbers = |n: usize| Vec::with_capacity(points.saturating_mul(n));
        let [t, q, v] = [1, n, n].map(numbers);
        let a = if knows_accelerations { numbers(n) } else { Vec::new() };
        Self {
            t_eval,
            n,
            knows_accelerations,
            t,
            q,
            v,
            a,
            u: numbers(run.inputs().len()),
            evaluations: Vec::with_capacity(points),
        }
    }

    /// Records the requested states before the current time, and at the current time only if `with_now`,
    /// without duplicates. Returns false if an interpolated value is not finite.
    pub(super) fn record<M: Model>(&mut self, run: &mut Run<M>, with_now: bool) -> Result<bool, Interrupted> {
        let now = run.t();
        let Some(times) = self.t_eval else {
            if with_now && self.t.last() != Some(&now) {
                self.push(run);
            }
            return Ok(true);
        };
        let due = &times[self.t.len()..];
        let within = due.iter().take_while(|t| **t < now).count();
        if within > 0 {
            let found = self.push_between(run, &due[..within]);
            if !matches!(found, Ok(true)) {
                return found;
            }
        }
        while with_now && times.get(self.t.len()) == Some(&now) {
            self.push(run);
        }
        Ok(true)
    }

    fn push_between<M: Model>(&mut self, run: &mut Run<M>, times: &[f64]) -> Result<bool, Interrupted> {
        let Self { n, knows_accelerations, q, v, a, .. } = self;
        let start = q.len();
        let end = start + times.len() * *n;
        q.resize(end, 0.0);
        v.resize(end, 0.0);
        let of_accelerations = if *knows_accelerations {
            a.resize(end, 0.0);
            &mut a[start..]
        } else {
            &mut []
        };
        let found = run.interpolate(times, [&mut q[start..], &mut v[start..], of_accelerations]);
        if matches!(found, Ok(true)) {
            self.t.extend_from_slice(times);
            times.iter().for_each(|_| self.u.extend_from_slice(run.inputs()));
            self.evaluations.resize(self.t.len(), run.counters().nfev);
        } else {
            [q, v, a].into_iter().for_each(|states| states.truncate(start));
        }
        found
    }

    fn push<M: Model>(&mut self, run: &Run<M>) {
        let (t, [q, v, a]) = run.state();
        self.t.push(t);
        self.q.extend_from_slice(q);
        self.v.extend_from_slice(v);
        if self.knows_accelerations {
            self.a.extend_from_slice(a);
        }
        self.u.extend_from_slice(run.inputs());
        self.evaluations.push(run.counters().nfev);
    }
}
