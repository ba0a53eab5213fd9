//! Collects the requested states of a run.

use crate::error::Interrupted;
use crate::model::Model;
use crate::stepping::Run;

/// Records states at given times, or after every step.
pub(super) struct Recorder<'a> {
    t_eval: Option<&'a [f64]>,
    n: usize,
    pub(super) t: Vec<f64>,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) a: Vec<f64>,
    /// Inputs from each of these times on.
    pub(super) u: Vec<f64>,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(n: usize, inputs: usize, points: usize, t_eval: Option<&'a [f64]>) -> Self {
        let states = |n: usize| Vec::with_capacity(points.saturating_mul(n));
        let [q, v, a] = [(); 3].map(|()| states(n));
        Self { t_eval, n, t: Vec::with_capacity(points), q, v, a, u: states(inputs) }
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
        while let Some(&t) = times.get(self.t.len())
            && (t < now || with_now && t == now)
        {
            if t == now {
                self.push(run);
                continue;
            }
            let (n, end) = (self.n, self.q.len());
            for states in [&mut self.q, &mut self.v, &mut self.a] {
                states.resize(end + n, 0.0);
            }
            let state = [&mut self.q[end..], &mut self.v[end..], &mut self.a[end..]];
            let found = run.interpolate(t, state);
            if !matches!(found, Ok(true)) {
                for states in [&mut self.q, &mut self.v, &mut self.a] {
                    states.truncate(end);
                }
                return found;
            }
            self.t.push(t);
            self.u.extend_from_slice(run.inputs());
        }
        Ok(true)
    }

    fn push<M: Model>(&mut self, run: &Run<M>) {
        self.t.push(run.t());
        self.q.extend_from_slice(run.q());
        self.v.extend_from_slice(run.v());
        self.a.extend_from_slice(run.a());
        self.u.extend_from_slice(run.inputs());
    }
}
