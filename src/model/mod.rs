//! The interface of mechanical systems to the solvers.
//!
//! ```
//! use lissom::model::Model;
//! use lissom::pendulum::SpringPendulum;
//!
//! let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
//! let mut tau = [0.0; 2];
//! pendulum.inverse_dynamics(&[0.0, 0.1], &[0.0, 0.0], &[0.0, 0.0], &mut tau);
//! assert!((tau[1] - 1.0).abs() < 1e-12); // newtons along the spring: stiffness times elongation
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

pub(crate) mod chart;
mod discretised;
mod elastic;
mod energy;
mod facts;
mod flaw;
pub(crate) mod forward;
mod in_time;
mod passing;
pub(crate) mod rotation_vectors;
mod tied;

use crate::linalg::{Matrix, TreeMatrix};

pub use discretised::Discretised;
pub use elastic::Elastic;
pub use energy::Energy;
pub use facts::Facts;
pub(crate) use flaw::at_least;
pub use flaw::{Flaw, Holder, Radius};
pub use forward::{ForwardScratch, SingularMass, Tree};
pub use in_time::InTime;
pub use passing::{Beside, Impact};
pub(crate) use passing::{have_met_stops, have_passed, have_touched};
pub use tied::{Switch, Tied};

/// A section of a rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPlace {
    /// Index of the segment, counted through all rods.
    pub segment: usize,
    /// Position as a fraction of the segment's length.
    pub x: f64,
}

/// Maps the twist of a section, (angular; linear), to its momentum per length. Also used for derivatives with
/// respect to the entries of such a matrix.
pub type InertiaMatrix = [[f64; 6]; 6];

/// A mechanical system with generalised coordinates `q` (n of them), velocities `qd`, accelerations `qdd`.
///
/// `tau(q, qd, qdd)` is the generalised force that a motion requires, including elasticity, damping and dead
/// loads; it is zero in free motion. A model owns its scratch memory, hence `&mut self`. Apart from that, and
/// from the time last set, all methods are pure functions of their arguments, and none allocates. Slices of
/// the wrong length are a programming error and panic; the bindings check lengths first.
pub trait Model: Elastic + InTime + Discretised + Tied {
    /// What does not change during a run.
    fn facts(&self) -> &Facts;

    /// Generalised forces `tau` of a motion.
    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]);

    /// `weights[0] dtau/dq + weights[1] dtau/dqd + weights[2] dtau/dqdd`, exact, in one sweep: the Jacobian
    /// of an implicit step for its weights.
    fn weighted_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    );

    /// Approximate cost of a weighted tangent in units of inverse dynamics; determines when an implicit step
    /// updates its Jacobian.
    fn tangent_cost(&self) -> f64 {
        3.0
    }

    /// The derivative of `tau` with respect to the inputs, n x m, exact.
    fn input_tangent(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64], _tangent: &mut Matrix) {}

    /// Adds the derivatives of the power `rates . tau` with respect to the inertia matrices per length (of a twist in the
    /// section's axes, (angular; linear)) at each of the
    /// [`section_places`](Facts::section_places). Allocates.
    fn add_power_by_inertia(
        &mut self,
        _q: &[f64],
        _qd: &[f64],
        _qdd: &[f64],
        _rates: &[f64],
        _by_inertia: &mut [InertiaMatrix],
    ) {
    }

    /// Adds the derivatives of the power `rates . tau` with respect to the length of each of the
    /// [`free_lengths`](Facts::free_lengths) segments. Allocates.
    fn add_power_by_length(
        &mut self,
        _q: &[f64],
        _qd: &[f64],
        _qdd: &[f64],
        _rates: &[f64],
        _by_length: &mut [f64],
    ) {
    }

    /// The symmetric positive definite mass matrix.
    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix);

    /// Structure of tangent and mass matrix for long chains, for which sparse evaluation and factorisation
    /// are cheaper. Allocates; not for step loops.
    fn tree(&self) -> Option<Tree> {
        None
    }

    /// [`Self::weighted_tangent`] of a model that is a chain.
    fn tree_tangent(
        &mut self,
        _q: &[f64],
        _qd: &[f64],
        _qdd: &[f64],
        _weights: [f64; 3],
        _tangent: &mut TreeMatrix,
    ) {
        unreachable!("the model is no chain");
    }

    /// [`Self::mass_matrix`] for a chain; symmetric to rounding.
    fn tree_mass_matrix(&mut self, _q: &[f64], _mass: &mut TreeMatrix) {
        unreachable!("the model is no chain");
    }

    /// The energies of a state.
    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy;

    /// Power dissipated by damping, in watts, never negative.
    fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64;

    /// Position of the tip in the frame of the model, in metres, at which accuracy is measured.
    fn tip(&mut self, q: &[f64]) -> [f64; 3];

    /// Appends the positions at which accuracy is measured, in the frame of the model, in metres; their
    /// number is constant. Default: the tip.
    fn places(&mut self, q: &[f64], places: &mut Vec<[f64; 3]>) {
        places.push(self.tip(q));
    }

    /// Largest displacement of these positions between two states, in metres. Allocates; not for step loops.
    fn moved(&mut self, from: &[f64], to: &[f64]) -> f64 {
        let mut places = Vec::new();
        self.places(from, &mut places);
        let number = places.len();
        self.places(to, &mut places);
        let (from, to) = places.split_at(number);
        let square = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
        let largest = |most: f64, square: f64| if square <= most { most } else { square };
        from.iter().zip(to).map(square).fold(0.0, largest).sqrt()
    }

    /// By how much each of these springs is deformed in a shape, negative where it does not act.
    fn beyond_stops(&mut self, _q: &[f64], beyond: &mut Vec<f64>) {
        beyond.clear();
    }

    /// Disables contact forces, or enables them again.
    fn leave_contact(&mut self, _is_left: bool) {}

    /// Softens contacts: surfaces are no stiffer than those that such a force, in newtons for every pair of [`Self::shifts_of_contact`],
    /// presses into each other by their thickness. `None` undoes that. Returns whether any are softer than they are.
    fn soften_contact(&mut self, _forces: Option<&[f64]>) -> bool {
        false
    }

    /// The largest overlap in a shape over the thickness of the thinner surface; zero if nothing touches.
    fn deepest_overlap(&mut self, _q: &[f64]) -> f64 {
        0.0
    }

    /// For every pair of surfaces that may touch, a row: how far either of them moves at most for a unit of each coordinate, along
    /// steps from the shape. Allocates.
    fn shifts_of_contact(&mut self, q: &[f64]) -> Matrix {
        Matrix::zeros(0, q.len())
    }

    /// What contacts and actuators could do for a unit of each coordinate, in a shape at rest, in newtons or newton metres, if the
    /// motions of both surfaces and of the places at which they touch added up, and those of both ends of tendons: magnitudes to which
    /// the rounding of their forces and of their stiffness is relative.
    fn work_of_interactions(&mut self, _q: &[f64], work: &mut [f64]) {
        work.fill(0.0);
    }

    /// Selects the linearisation of friction for an iteration: at its start, or after a step that took this
    /// fraction of the last increment. `None` selects exact tangents.
    fn follow_friction(&mut self, _length: Option<f64>) {}

    /// A contact whose surfaces overlap by more than a radius, if any.
    fn sunk(&mut self, _q: &[f64]) -> Option<Flaw> {
        None
    }

    /// Whether any surfaces overlap in a shape.
    fn overlaps(&mut self, _q: &[f64]) -> bool {
        false
    }

    /// Takes down where surfaces are in a shape: [`Self::have_passed`] goes on from there.
    fn note_surfaces(&mut self, _q: &[f64]) {}

    /// Whether surfaces pass through each other, or overlap by more than half of the given radius, on the
    /// straight path from the stored shape to `q`. Stores `q` afterwards.
    fn have_passed(&mut self, _q: &[f64], _radius: Radius) -> bool {
        false
    }

    /// Whether an impact in a step of size `h`, in seconds, from the coordinates and velocities `before` to
    /// the given motion is too hard to be resolved by that step.
    fn is_jolted(&mut self, _before: [&[f64]; 2], _motion: [&[f64]; 3], _h: f64) -> bool {
        false
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

    /// Whether such a step ends with more energy than it began with, by more than errors of steps that see their impacts.
    fn gains_energy(&mut self, _before: [&[f64]; 2], _motion: [&[f64]; 3], _h: f64, _beside: Beside) -> bool {
        false
    }

    /// What an impact in such a step, which stops what meets, has taken out of the motion.
    fn impact(&mut self, _before: [&[f64]; 2], _motion: [&[f64]; 3], _h: f64) -> Option<Impact> {
        None
    }

    /// Power of forces without a potential (moments of fixed direction, varying loads, a moving base), in
    /// watts. Accelerations matter only for a moving base.
    fn supplied_power(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64]) -> f64 {
        0.0
    }

    /// Accelerations of the free motion: solves `M qdd = -tau(q, qd, 0)` for `tau(q, qd, qdd) = 0`, by
    /// Cholesky factorisation or by the factorisation of a chain. `scratch` must belong to this model.
    fn forward_dynamics(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &mut [f64],
        scratch: &mut ForwardScratch,
    ) -> Result<(), SingularMass> {
        forward::solve(self, q, qd, qdd, scratch)
    }
}
