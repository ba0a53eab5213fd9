//! Marker traits for models of one's own without time dependence, constraints, contacts and so on.

use super::{
    ContactText, Differentiable, Dynamics, Elastic, Excitation, FrictionTreatment, GainCheck, Impact,
    InContact, InImpact, InTime, InertiaMatrix, InvalidShape, MissingStrain, OneSided, Overlap, Radius,
    Reached, Refinable, Separation, Softened, Sprung, Switch, Tied,
};
use crate::description::signal::{Cell, Jumps};
use crate::error::Interrupted;
use crate::model::springs::{LengthTendons, Springs};
use crate::numerics::linalg::Matrix;

/// A model that depends on neither time nor inputs, and has no rods by whose parameters runs are differentiated: it is [`InTime`] and
/// [`Differentiable`] by default. Its [`Facts`](super::Facts) are those of [`smooth`](super::Facts::smooth).
pub trait Autonomous: Dynamics {}

/// A model without constraints, contacts, stops, springs to the world, tendons and an adjustable discretisation, whose forces have no
/// corners in time either: it is [`Tied`], [`OneSided`], [`InContact`], [`InImpact`], [`Sprung`], [`Excitation`] and [`Refinable`]
/// by default. Its [`Facts`](super::Facts) are those of [`smooth`](super::Facts::smooth).
pub trait Smooth: Dynamics {}

/// A model without constraints: it is [`Tied`] by default.
pub trait Untied: Dynamics {}

impl<M: Smooth> Untied for M {}

impl<M: Autonomous> InTime for M {
    #[inline]
    fn set_time(&mut self, _t: f64) -> Result<(), Interrupted> {
        Ok(())
    }

    fn set_inputs(&mut self, _u: &[f64]) {}

    fn not_finite(&self) -> Option<String> {
        None
    }

    fn input_tangent(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64], _tangent: &mut Matrix) {}
}

impl<M: Smooth + InTime> Excitation for M {
    fn horizon(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    fn end_steps_at(&mut self, _times: &[f64]) {}

    fn corner(&self, _cell: Cell) -> Option<f64> {
        None
    }

    fn set_steps(&mut self, _dt: f64) {}

    fn jumps(&self) -> Jumps {
        Jumps::Nothing
    }

    fn jump_near(&self, _t: f64) -> Option<f64> {
        None
    }

    fn set_time_in_jump(&mut self, t: f64) -> Result<(), Interrupted> {
        self.set_time(t)
    }

    fn pass_jump(&mut self, _t: f64) {}

    fn mean_rates_over(&mut self, _seconds: f64) {}

    fn lag_loads(&mut self, _lag: f64) -> bool {
        false
    }

    fn prescribed(&mut self, _to: &mut Vec<[f64; 3]>) {}
}

impl<M: Autonomous> Differentiable for M {
    fn add_power_by_inertia(
        &mut self,
        _q: &[f64],
        _qd: &[f64],
        _qdd: &[f64],
        _rates: &[f64],
        _by_inertia: &mut [InertiaMatrix],
    ) {
    }

    fn add_power_by_length(
        &mut self,
        _q: &[f64],
        _qd: &[f64],
        _qdd: &[f64],
        _rates: &[f64],
        _by_length: &mut [f64],
    ) {
    }
}

impl<M: Untied> Tied for M {
    fn set_multipliers(&mut self, _multipliers: &[f64]) {}

    fn away_from_half_turns(&mut self, _gaps: &mut [f64]) -> f64 {
        0.0
    }

    fn gaps(&mut self, _q: &[f64], _gaps: &mut [f64]) {}

    fn gap_rates(&mut self, _q: &[f64], _qd: &[f64], _rates: &mut [f64]) {}

    fn gap_accelerations(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64], _accelerations: &mut [f64]) {}

    fn gap_jacobian(&mut self, _q: &[f64], _jacobian: &mut Matrix) {}

    fn open_loop(&mut self, _q: &[f64]) -> Option<InvalidShape> {
        None
    }
}

impl<M: Smooth> OneSided for M {
    fn active(&self) -> Vec<bool> {
        Vec::new()
    }

    fn release(&mut self, _multipliers: &[f64]) {}

    fn release_open(&mut self, _q: &[f64], _qd: Option<&[f64]>) {}

    fn switch(&mut self, _q: &[f64], _multipliers: &mut [f64]) -> Switch {
        Switch::Nothing
    }

    fn keep_active_set(&mut self, _is_kept: bool) {}

    fn passed(&mut self, _q: &[f64], _qd: &[f64]) -> Vec<[f64; 2]> {
        Vec::new()
    }
}

impl<M: Smooth + Elastic> Sprung for M {
    fn linearise_springs(&mut self, _q: &[f64], _springs: &mut Springs) {}

    fn hold_springs(&mut self, _forces: Option<&[f64]>) {}

    fn linearise_length_tendons(&mut self, _q: &[f64], _length_tendons: &mut LengthTendons) {}

    fn hold_length_tendons(&mut self, _tensions: Option<&[f64]>) {}
}

impl<M: Smooth> InContact for M {
    fn reached(&mut self, _q: &[f64]) -> Vec<Reached> {
        Vec::new()
    }

    fn decide(&mut self, _reached: &[Reached]) {}

    fn leave_contact(&mut self, _is_left: bool) {}

    fn soften_contact(&mut self, _soft: Option<Softened<'_>>) -> bool {
        false
    }

    fn deepest_overlaps(&mut self, _q: &[f64]) -> [Option<Overlap>; 2] {
        [None; 2]
    }

    fn deepest_overlap(&mut self, _q: &[f64]) -> Option<Overlap> {
        None
    }

    fn text_of_contact(&self, _contact: usize, _text: ContactText) -> String {
        String::new()
    }

    fn advice_at_end(&mut self, _failed: &[&[f64]], _deepest: Option<Overlap>) -> String {
        String::new()
    }

    fn shifts_of_contact(&mut self, q: &[f64]) -> Matrix {
        Matrix::zeros(0, q.len())
    }

    fn work_of_interactions(&mut self, _q: &[f64], work: &mut [f64]) {
        work.fill(0.0);
    }

    fn deep_penetration(&mut self, _q: &[f64]) -> Option<InvalidShape> {
        None
    }

    fn store_surfaces(&mut self, _q: &[f64]) {}

    fn have_tunnelled(&mut self, _q: &[f64], _radius: Radius) -> bool {
        false
    }

    fn is_touched(&self) -> bool {
        false
    }
}

impl<M: Smooth> InImpact for M {
    fn beyond_stops(&mut self, _q: &[f64], beyond: &mut Vec<f64>) {
        beyond.clear();
    }

    fn treat_friction(&mut self, _treatment: FrictionTreatment) {}

    fn has_unresolved_impact(&mut self, _before: [&[f64]; 2], _motion: [&[f64]; 3], _h: f64) -> bool {
        false
    }

    fn separation(&mut self, _v_before: &[f64], _motion: [&[f64]; 3], _since: f64, _h: f64) -> Separation {
        Separation::default()
    }

    fn take_touched(&mut self) -> bool {
        false
    }

    fn may_touch(&self) -> bool {
        false
    }

    fn gains_energy(
        &mut self,
        _before: [&[f64]; 2],
        _motion: [&[f64]; 3],
        _h: f64,
        _check: GainCheck,
    ) -> bool {
        false
    }

    fn mark_pushed(&mut self, _state: [&[f64]; 2], _marks: &mut [bool]) {}

    fn impact(&mut self, _before: [&[f64]; 2], _motion: [&[f64]; 3], _h: f64) -> Option<Impact> {
        None
    }
}

impl<M: Smooth> Refinable for M {
    fn modes(&self) -> Option<Vec<usize>> {
        None
    }

    fn coordinates_between(&self) -> Vec<usize> {
        Vec::new()
    }

    fn with_modes(&self, _modes: &[usize]) -> Option<Self> {
        None
    }

    fn with_inertia_times(&self, _factor: f64) -> Option<Self> {
        None
    }

    fn with_nodes_times(&self, _factor: usize) -> Option<Self> {
        None
    }

    fn missing_strain(&mut self, _q: &[f64], _load_factor: f64) -> Option<MissingStrain> {
        None
    }

    fn effect_of_strains(&mut self, _q: &[f64], _change: &[f64]) -> Option<MissingStrain> {
        None
    }

    fn outline(&mut self, _q: &[f64], _positions: &mut Vec<[f64; 3]>) {}

    fn name_of_segment(&self, _segment: usize) -> String {
        String::new()
    }
}
