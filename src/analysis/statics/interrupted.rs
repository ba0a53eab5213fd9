//! Interrupted searches.

use super::equations::{Counters, Equations, State};
use super::load_parameter::LoadParameter;
use super::options::Start;
use super::outcome::{self, Equilibrium, Status};
use super::path::Path;
use crate::error::{Interrupted, Unfinished};
use crate::model::Static;
use crate::numerics::linalg::norm;

/// Called before every evaluation; may stop a search.
pub type Monitor<'a> = &'a mut dyn FnMut() -> Result<(), Interrupted>;

/// An interrupted search, with its latest state, if any.
pub(super) struct InterruptedSearch(Option<Box<Reached>>);

/// State of a search at its interruption.
pub(super) struct Reached {
    pub(super) q: Vec<f64>,
    pub(super) load_factor: f64,
    pub(super) path: Path,
    pub(super) counters: Counters,
}

impl From<Interrupted> for InterruptedSearch {
    fn from(_: Interrupted) -> Self {
        Self(None)
    }
}

impl InterruptedSearch {
    pub(super) fn at(state: &State, path: &Path, equations: &Equations<'_>) -> Self {
        let mut q = state.q.clone();
        equations.wrap(&mut q);
        let (path, counters) = (path.clone(), equations.counters);
        Self::with(Reached { q, load_factor: state.load_factor, path, counters })
    }

    pub(super) fn with(reached: Reached) -> Self {
        Self(Some(Box::new(reached)))
    }

    /// The same after another search.
    pub(super) fn after(self, counters: Counters) -> Self {
        Self(self.0.map(|reached| Box::new(Reached { counters: counters + reached.counters, ..*reached })))
    }

    /// The same after a path of loads.
    pub(super) fn along(self, path: &Path) -> Self {
        Self(self.0.map(|reached| Box::new(Reached { path: path.clone(), ..*reached })))
    }

    /// The result until the interruption, with the residual forces, which are evaluated once.
    pub(super) fn unfinished(self, model: &mut dyn Static, start: &Start) -> Unfinished<Equilibrium> {
        let n = model.facts().n;
        let Reached { q, load_factor, path, counters } = self.0.map_or_else(
            || Reached {
                q: start.shape(n),
                load_factor: if matches!(start, Start::Unloaded { .. }) { 0.0 } else { 1.0 },
                path: Path::default(),
                counters: Counters::default(),
            },
            |reached| *reached,
        );
        let mut never = || Ok(());
        let mut equations = Equations::new(model, LoadParameter::Loads, &q, &mut never);
        let [mut residual, mut load] = [vec![0.0; n], vec![0.0; n]];
        // A function of time that has failed is not called again.
        let evaluated = equations.residual(&q, load_factor, &mut residual, &mut load);
        Unfinished::new(Equilibrium {
            message: outcome::message(model, Status::Interrupted, load_factor, true, None, &path),
            q,
            load_factor,
            status: Status::Interrupted,
            residual_norm: evaluated.map_or(f64::NAN, |()| norm(&residual)),
            step_norm: f64::NAN,
            verdict: None,
            lowest: f64::NAN,
            path,
            deepest: None,
            counters,
        })
    }
}
