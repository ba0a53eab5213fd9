//! Second-order equations of motion, and those of models.

use super::Failure;
use crate::error::Interrupted;
use crate::model::constraint::one_sided;
use crate::model::{Facts, InTime, Model};
use crate::numerics::linalg::Matrix;

/// Equations of motion `r(t, q, v, a) = 0` for displacements q, velocities v and accelerations a, n of each.
///
/// Every [`Model`] has them: its generalised forces vanish in free motion. Equations that are nothing else are smooth and without
/// constraints; their facts are [`Facts::of_equations`], and their type of [`Self::Model`] can be `dyn Model`.
pub trait SecondOrderSystem {
    /// The model whose motion this is.
    type Model: Model + ?Sized;

    /// What does not change during a run. With constraints, multipliers follow the accelerations passed to
    /// [`Self::residual`], and gaps follow the residual.
    fn facts(&self) -> &Facts;

    /// `residual <- r(t, q, v, a)`. Must set every entry. Non-finite values are allowed; they shorten the
    /// step, or end the integration with a status that says so.
    fn residual(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        residual: &mut [f64],
    ) -> Result<(), Interrupted>;

    /// `tangent <- weights[0] dr/dq + weights[1] dr/dv + weights[2] dr/da`. Must set every entry. Called only
    /// for [`Derivative::Analytic`](crate::numerics::roots::Derivative::Analytic).
    fn tangent(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) -> Result<(), Interrupted>;

    /// The model, for constraints, contacts, stops, changes of the excitation and tangents of chains; `None` for plain equations.
    fn model(&mut self) -> Option<&mut Self::Model>;
}

/// Free motion of a model: zero inverse dynamics.
impl<M: Model + ?Sized> SecondOrderSystem for M {
    type Model = M;

    #[inline]
    fn facts(&self) -> &Facts {
        self.facts()
    }

    #[inline]
    fn residual(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        residual: &mut [f64],
    ) -> Result<(), Interrupted> {
        self.set_time(t)?;
        if self.facts().constraints() == 0 {
            self.inverse_dynamics(q, v, a, residual);
            return Ok(());
        }
        let (a, multipliers) = a.split_at(q.len());
        let (tau, gaps) = residual.split_at_mut(q.len());
        self.set_multipliers(multipliers);
        self.inverse_dynamics(q, v, a, tau);
        self.gaps(q, gaps);
        Ok(())
    }

    #[inline]
    fn tangent(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) -> Result<(), Interrupted> {
        let a = set_motion(self, t, q, a)?;
        self.weighted_tangent(q, v, a, weights, tangent);
        Ok(())
    }

    #[inline]
    fn model(&mut self) -> Option<&mut M> {
        Some(self)
    }
}

/// The model of equations that have what only models have, such as constraints or contacts.
#[inline]
pub(crate) fn model_of<S: SecondOrderSystem + ?Sized>(system: &mut S) -> &mut S::Model {
    system.model().expect("only models have constraints and contacts")
}

/// The same, at a time.
#[inline]
pub(crate) fn model_at<S: SecondOrderSystem + ?Sized>(
    system: &mut S,
    t: f64,
) -> Result<&mut S::Model, Interrupted> {
    let model = model_of(system);
    model.set_time(t)?;
    Ok(model)
}

/// Sets the time and the multipliers, which follow the accelerations if there are constraints. Returns the accelerations.
#[inline]
pub(crate) fn set_motion<'a, M: Model + ?Sized>(
    model: &mut M,
    t: f64,
    q: &[f64],
    unknowns: &'a [f64],
) -> Result<&'a [f64], Interrupted> {
    model.set_time(t)?;
    let (a, multipliers) = unknowns.split_at(q.len());
    if !multipliers.is_empty() {
        model.set_multipliers(multipliers);
    }
    Ok(a)
}

/// Accelerations and multipliers of a model with constraints in a state that satisfies them. `unknowns` has n + m entries. Allocates.
pub(crate) fn constrained_start<M: Model + ?Sized>(
    model: &mut M,
    t: f64,
    q: &[f64],
    v: &[f64],
    unknowns: &mut [f64],
) -> Result<Result<(), Failure>, Interrupted> {
    model.set_time(t)?;
    let (a, multipliers) = unknowns.split_at_mut(q.len());
    Ok(match one_sided::accelerations(model, q, v, a, multipliers) {
        Ok(()) if unknowns.iter().all(|x| x.is_finite()) => Ok(()),
        Ok(()) => Err(Failure::NonFinite),
        Err(_) => Err(Failure::SingularJacobian),
    })
}
