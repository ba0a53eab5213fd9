//! Second-order equations of motion, and free motions of models.

use super::Failure;
use crate::description::signal::Cell;
use crate::error::Interrupted;
use crate::model::constraint::{one_sided, projection};
use crate::model::{
    Beside, Facts, Flaw, Holding, Impact, Model, Radius, Switch, have_met_stops, have_passed, have_touched,
    rotation_vectors,
};
use crate::numerics::linalg::{Matrix, TreeMatrix};

/// Equations of motion `r(t, q, v, a) = 0` for displacements q, velocities v and accelerations a, n of each.
pub trait System {
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

    /// Derivative of the constraints with respect to the displacements, m x n. Must set every entry.
    fn constraint_jacobian(
        &mut self,
        _t: f64,
        _q: &[f64],
        _jacobian: &mut Matrix,
    ) -> Result<(), Interrupted> {
        unreachable!("the system has no constraints");
    }

    /// Gaps of the constraints, m numbers, as at the end of [`Self::residual`].
    fn gaps(&mut self, _t: f64, _q: &[f64], _gaps: &mut [f64]) -> Result<(), Interrupted> {
        unreachable!("the system has no constraints");
    }

    /// First time derivatives of the gaps.
    fn gap_rates(&mut self, _t: f64, _q: &[f64], _v: &[f64], _rates: &mut [f64]) -> Result<(), Interrupted> {
        unreachable!("the system has no constraints");
    }

    /// Second time derivatives of the gaps. `motion` contains displacements, velocities and accelerations.
    fn gap_accelerations(
        &mut self,
        _t: f64,
        _motion: [&[f64]; 3],
        _accelerations: &mut [f64],
    ) -> Result<(), Interrupted> {
        unreachable!("the system has no constraints");
    }

    /// Accelerations and multipliers at a start that satisfies the constraints. `a` has n + m entries.
    fn constrained_start(
        &mut self,
        _t: f64,
        _q: &[f64],
        _v: &[f64],
        _a: &mut [f64],
    ) -> Result<Result<(), Failure>, Interrupted> {
        unreachable!("the system has no constraints");
    }

    /// Changes velocities by the smallest kinetic energy that makes them satisfy the constraints, and sets accelerations and
    /// multipliers to those of that state. `a` has n + m entries. Returns whether it could; near singular positions it leaves
    /// everything as it was, unless it shall `even_singular`. Allocates.
    fn fit_to_constraints(
        &mut self,
        _t: f64,
        _q: &[f64],
        _v: &mut [f64],
        _a: &mut [f64],
        _even_singular: bool,
    ) -> Result<bool, Interrupted> {
        unreachable!("the system has no constraints");
    }

    /// Structure of the tangent (zeros) if it is the matrix of a chain for which this form is cheaper;
    /// [`Self::tree_tangent`] is then called instead of [`Self::tangent`].
    fn tree(&self) -> Option<TreeMatrix> {
        None
    }

    /// The tangent of a system that is a chain.
    fn tree_tangent(
        &mut self,
        _t: f64,
        _q: &[f64],
        _v: &[f64],
        _a: &[f64],
        _weights: [f64; 3],
        _tangent: &mut TreeMatrix,
    ) -> Result<(), Interrupted> {
        unreachable!("the system is no chain");
    }

    /// Rewrites a state in coordinates away from their singularities, if necessary. Called between accepted
    /// steps. `accelerations` are all vectors that transform as second derivatives of the coordinates.
    /// Returns whether anything changed.
    fn wrap(&mut self, _q: &mut [f64], _v: &mut [f64], _accelerations: &mut [&mut [f64]]) -> bool {
        false
    }

    /// Selects the linearisation of friction for an iteration ([`InImpact::follow_friction`](crate::model::InImpact::follow_friction)).
    fn follow_friction(&mut self, _length: Option<f64>) {}

    /// Whether an impact is too hard to be resolved by a step of size `h` from the displacements and
    /// velocities `before` to a motion (displacements, velocities, accelerations).
    fn is_jolted(
        &mut self,
        _t: f64,
        _before: [&[f64]; 2],
        _motion: [&[f64]; 3],
        _h: f64,
    ) -> Result<bool, Interrupted> {
        Ok(false)
    }

    /// Whether surfaces touch in the state evaluated last.
    fn is_touched(&self) -> bool {
        false
    }

    /// Whether surfaces have touched in any state evaluated since the last call.
    fn take_touched(&mut self) -> bool {
        false
    }

    /// Whether surfaces in the state evaluated last are so close that they may touch in the next one.
    fn may_touch(&self) -> bool {
        false
    }

    /// Whether such a step gains more energy than a step that resolves its impacts would.
    fn gains_energy(
        &mut self,
        _t: f64,
        _before: [&[f64]; 2],
        _motion: [&[f64]; 3],
        _h: f64,
        _beside: Beside,
    ) -> Result<bool, Interrupted> {
        Ok(false)
    }

    /// What an impact in such a step, which stops what meets, has taken out of the motion.
    fn impact(
        &mut self,
        _t: f64,
        _before: [&[f64]; 2],
        _motion: [&[f64]; 3],
        _h: f64,
    ) -> Result<Option<Impact>, Interrupted> {
        Ok(None)
    }

    /// From now on, loads are those of earlier times ([`Excitation::lag_loads`](crate::model::Excitation::lag_loads)).
    fn lag_loads(&mut self, _lag: f64) -> bool {
        false
    }

    /// What such a motion has; `None` where something dissipates, which steps of an impact tell badly, and where what moves it from
    /// outside is known at single times alone.
    fn holding(&mut self, _t: f64, _motion: [&[f64]; 3]) -> Result<Option<Holding>, Interrupted> {
        Ok(None)
    }

    /// Whether displacements are an invalid shape ([`Flaw`](crate::model::Flaw)), including sunk surfaces.
    fn is_flawed(&mut self, _t: f64, _q: &[f64]) -> Result<bool, Interrupted> {
        Ok(false)
    }

    /// Whether displacements contain rotations too large to be followed, which a step that is too long can
    /// cause.
    fn is_turned_too_far(&mut self, _t: f64, _q: &[f64]) -> Result<bool, Interrupted> {
        Ok(false)
    }

    /// Whether surfaces pass through each other along a path given by times and displacements, by more than
    /// half of a radius.
    fn have_passed(&mut self, _way: &[(f64, &[f64])], _radius: Radius) -> Result<bool, Interrupted> {
        Ok(false)
    }

    /// Whether surfaces touch within a step between these times, displacements and velocities although they do at neither end.
    /// `memory` is any vector, kept to save allocations.
    fn have_touched(
        &mut self,
        _times: [f64; 2],
        _ends: [&[f64]; 2],
        _rates: [&[f64]; 2],
        _memory: &mut Vec<f64>,
    ) -> Result<bool, Interrupted> {
        Ok(false)
    }

    /// Whether springs that act one way only do so within such a step although they do at neither end.
    fn have_met_stops(
        &mut self,
        _times: [f64; 2],
        _ends: [&[f64]; 2],
        _rates: [&[f64]; 2],
        _memory: &mut Vec<f64>,
    ) -> Result<bool, Interrupted> {
        Ok(false)
    }

    /// Makes exactly the constraints with non-zero multipliers active.
    fn release(&mut self, _multipliers: &[f64]) {}

    /// Activates violated constraints, or releases one with a negative multiplier.
    fn switch(&mut self, _t: f64, _q: &[f64], _multipliers: &mut [f64]) -> Result<Switch, Interrupted> {
        Ok(Switch::Nothing)
    }

    /// Latest end of an adaptive step from `t` that cannot miss a feature of the excitation.
    fn horizon(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// The next time at which a step of fixed size must end ([`Excitation::corner`](crate::model::Excitation::corner)).
    fn corner(&self, _cell: Cell) -> Option<f64> {
        None
    }

    /// Approximate cost of a tangent in units of residuals; determines when a fresh tangent pays.
    fn tangent_cost(&self) -> f64 {
        3.0
    }
}

/// Free motion of a model: zero inverse dynamics.
#[derive(Debug)]
pub struct FreeMotion<'a, M: ?Sized>(pub &'a mut M);

impl<M: Model + ?Sized> System for FreeMotion<'_, M> {
    #[inline]
    fn facts(&self) -> &Facts {
        self.0.facts()
    }

    fn wrap(&mut self, q: &mut [f64], v: &mut [f64], accelerations: &mut [&mut [f64]]) -> bool {
        rotation_vectors::wrap(&self.0.facts().rotation_vectors, q, v, accelerations)
    }

    fn horizon(&self, t: f64) -> f64 {
        self.0.horizon(t)
    }

    fn corner(&self, cell: Cell) -> Option<f64> {
        self.0.corner(cell)
    }

    fn follow_friction(&mut self, length: Option<f64>) {
        self.0.follow_friction(length);
    }

    fn is_jolted(
        &mut self,
        t: f64,
        before: [&[f64]; 2],
        [q, v, a]: [&[f64]; 3],
        h: f64,
    ) -> Result<bool, Interrupted> {
        self.0.set_time(t)?;
        let (a, multipliers) = a.split_at(q.len());
        if !multipliers.is_empty() {
            self.0.set_multipliers(multipliers);
        }
        Ok(self.0.is_jolted(before, [q, v, a], h))
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
        self.0.set_time(t)?;
        if self.0.facts().constraints() == 0 {
            self.0.inverse_dynamics(q, v, a, residual);
            return Ok(());
        }
        let (a, multipliers) = a.split_at(q.len());
        let (tau, gaps) = residual.split_at_mut(q.len());
        self.0.set_multipliers(multipliers);
        self.0.inverse_dynamics(q, v, a, tau);
        self.0.gaps(q, gaps);
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
        self.0.set_time(t)?;
        let (a, multipliers) = a.split_at(q.len());
        if !multipliers.is_empty() {
            self.0.set_multipliers(multipliers);
        }
        self.0.weighted_tangent(q, v, a, weights, tangent);
        Ok(())
    }

    fn constraint_jacobian(&mut self, t: f64, q: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        self.0.set_time(t)?;
        self.0.gap_jacobian(q, jacobian);
        Ok(())
    }

    fn gaps(&mut self, t: f64, q: &[f64], gaps: &mut [f64]) -> Result<(), Interrupted> {
        self.0.set_time(t)?;
        self.0.gaps(q, gaps);
        Ok(())
    }

    fn gap_rates(&mut self, t: f64, q: &[f64], v: &[f64], rates: &mut [f64]) -> Result<(), Interrupted> {
        self.0.set_time(t)?;
        self.0.gap_rates(q, v, rates);
        Ok(())
    }

    fn gap_accelerations(
        &mut self,
        t: f64,
        [q, v, a]: [&[f64]; 3],
        accelerations: &mut [f64],
    ) -> Result<(), Interrupted> {
        self.0.set_time(t)?;
        self.0.gap_accelerations(q, v, a, accelerations);
        Ok(())
    }

    fn constrained_start(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &mut [f64],
    ) -> Result<Result<(), Failure>, Interrupted> {
        self.0.set_time(t)?;
        let (a, multipliers) = a.split_at_mut(q.len());
        let found = one_sided::accelerations(self.0, q, v, a, multipliers);
        Ok(match found {
            Ok(()) if a.iter().chain(&*multipliers).all(|x| x.is_finite()) => Ok(()),
            Ok(()) => Err(Failure::NonFinite),
            Err(_) => Err(Failure::SingularJacobian),
        })
    }

    fn fit_to_constraints(
        &mut self,
        t: f64,
        q: &[f64],
        v: &mut [f64],
        a: &mut [f64],
        even_singular: bool,
    ) -> Result<bool, Interrupted> {
        self.0.set_time(t)?;
        let (mut fitted, mut found) = (v.to_vec(), a.to_vec());
        let is_regular = projection::fit_velocities(self.0, q, &mut fitted).is_ok_and(|fit| {
            (even_singular || !fit.is_nearly_singular()) && fitted.iter().all(|v| v.is_finite())
        });
        if !is_regular || self.constrained_start(t, q, &fitted, &mut found)?.is_err() {
            return Ok(false);
        }
        v.copy_from_slice(&fitted);
        a.copy_from_slice(&found);
        Ok(true)
    }

    fn is_touched(&self) -> bool {
        self.0.is_touched()
    }

    fn take_touched(&mut self) -> bool {
        self.0.take_touched()
    }

    fn may_touch(&self) -> bool {
        self.0.may_touch()
    }

    fn gains_energy(
        &mut self,
        t: f64,
        before: [&[f64]; 2],
        [q, v, a]: [&[f64]; 3],
        h: f64,
        beside: Beside,
    ) -> Result<bool, Interrupted> {
        self.0.set_time(t)?;
        Ok(self.0.gains_energy(before, [q, v, &a[..q.len()]], h, beside))
    }

    fn impact(
        &mut self,
        t: f64,
        before: [&[f64]; 2],
        [q, v, a]: [&[f64]; 3],
        h: f64,
    ) -> Result<Option<Impact>, Interrupted> {
        self.0.set_time(t)?;
        Ok(self.0.impact(before, [q, v, &a[..q.len()]], h))
    }

    fn lag_loads(&mut self, lag: f64) -> bool {
        self.0.lag_loads(lag)
    }

    fn holding(&mut self, t: f64, [q, v, a]: [&[f64]; 3]) -> Result<Option<Holding>, Interrupted> {
        let Facts { is_damped, is_driven, is_carried, varies_in_time, .. } = *self.0.facts();
        if is_carried || varies_in_time || is_damped {
            return Ok(None);
        }
        self.0.set_time(t)?;
        let energy = self.0.energy(q, v);
        let supplied = if is_driven { self.0.supplied_power(q, v, &a[..q.len()]) } else { 0.0 };
        Ok(Some(Holding {
            total: energy.total(),
            kinetic: energy.kinetic,
            elastic: energy.elastic,
            supplied,
        }))
    }

    fn is_flawed(&mut self, t: f64, q: &[f64]) -> Result<bool, Interrupted> {
        self.0.set_time(t)?;
        Ok(self.0.flaw(q).is_some() || self.0.sunk(q).is_some())
    }

    fn is_turned_too_far(&mut self, t: f64, q: &[f64]) -> Result<bool, Interrupted> {
        self.0.set_time(t)?;
        Ok(matches!(self.0.flaw(q), Some(Flaw::Unresolved { .. })))
    }

    fn have_passed(&mut self, way: &[(f64, &[f64])], radius: Radius) -> Result<bool, Interrupted> {
        if !self.0.facts().has_contact {
            return Ok(false);
        }
        have_passed(self.0, way.iter().copied(), radius)
    }

    fn have_touched(
        &mut self,
        times: [f64; 2],
        ends: [&[f64]; 2],
        rates: [&[f64]; 2],
        memory: &mut Vec<f64>,
    ) -> Result<bool, Interrupted> {
        have_touched(self.0, times, ends, rates, memory)
    }

    fn have_met_stops(
        &mut self,
        times: [f64; 2],
        ends: [&[f64]; 2],
        rates: [&[f64]; 2],
        memory: &mut Vec<f64>,
    ) -> Result<bool, Interrupted> {
        Ok(self.0.facts().has_stops && have_met_stops(self.0, times, ends, rates, memory)?)
    }

    fn release(&mut self, multipliers: &[f64]) {
        self.0.release(multipliers);
    }

    fn switch(&mut self, t: f64, q: &[f64], multipliers: &mut [f64]) -> Result<Switch, Interrupted> {
        self.0.set_time(t)?;
        Ok(self.0.switch(q, multipliers))
    }

    fn tree(&self) -> Option<TreeMatrix> {
        self.0.tree().map(|tree| tree.tangent)
    }

    #[inline]
    fn tree_tangent(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        weights: [f64; 3],
        tangent: &mut TreeMatrix,
    ) -> Result<(), Interrupted> {
        self.0.set_time(t)?;
        self.0.tree_tangent(q, v, a, weights, tangent);
        Ok(())
    }

    fn tangent_cost(&self) -> f64 {
        self.0.tangent_cost()
    }
}
