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

mod discretised;
mod elastic;
mod energy;
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
pub(crate) use flaw::at_least;
pub use flaw::{Flaw, Holder, Radius};
pub use forward::{ForwardScratch, SingularMass, Tree};
pub use in_time::InTime;
pub use passing::Beside;
pub(crate) use passing::{have_passed, have_touched};
pub use tied::{Switch, Tied};

/// A place along a rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPlace {
    /// Number of the segment, all rods in a row.
    pub segment: usize,
    /// Fraction of its length.
    pub x: f64,
}

/// What takes a twist of a section, (angular; linear), to its momentum per length; and derivatives with respect to its entries.
pub type InertiaMatrix = [[f64; 6]; 6];

/// A mechanical system with generalised coordinates `q` (n of them), velocities `qd`, accelerations `qdd`.
///
/// `tau(q, qd, qdd)` is the generalised force that the motion needs, elasticity, damping and dead loads
/// included: it is zero in free motion. A model owns its scratch memory, hence `&mut self`; all its methods
/// are pure functions of their arguments otherwise (and of the time last set), and none of them allocates.
/// Slices of the wrong length are a programming error and panic; the bindings check them first.
pub trait Model: Elastic + InTime + Discretised + Tied {
    /// Number of generalised coordinates.
    fn n(&self) -> usize;

    /// Generalised forces `tau` of a motion.
    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]);

    /// `weights[0] dtau/dq + weights[1] dtau/dqd + weights[2] dtau/dqdd`, exact, in one sweep.
    /// With the weights of an implicit step this is that step's Jacobian.
    fn weighted_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    );

    /// The first coordinates of the rotation vectors among the coordinates. Integrators keep them no longer than pi, and
    /// their results too.
    fn rotation_vectors(&self) -> &[usize] {
        &[]
    }

    /// About how many inverse dynamics cost as much as a weighted tangent: decides when an implicit step renews its
    /// Jacobian.
    fn tangent_cost(&self) -> f64 {
        3.0
    }

    /// The derivative of `tau` with respect to the inputs, n x m, exact.
    fn input_tangent(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64], _tangent: &mut Matrix) {}

    /// Where the inertia of sections counts, where that acts on nothing but the forces along rods; none where more depends on it,
    /// or the coordinates are not all free. Allocates.
    fn section_places(&self) -> Vec<SectionPlace> {
        Vec::new()
    }

    /// Adds the derivatives of the power `rates . tau` with respect to the inertia matrices per length (of a twist in the
    /// section's axes, (angular; linear)) at each of the [`Self::section_places`]. Allocates.
    fn add_power_by_inertia(
        &mut self,
        _q: &[f64],
        _qd: &[f64],
        _qdd: &[f64],
        _rates: &[f64],
        _by_inertia: &mut [InertiaMatrix],
    ) {
    }

    /// How many segments, the first ones, have lengths on which nothing depends but the rods that they are parts of: all of them, or
    /// none where more depends on one, such as the place of a load inside a rod.
    fn free_lengths(&self) -> usize {
        0
    }

    /// Adds the derivatives of the power `rates . tau` with respect to the length of each of the [`Self::free_lengths`]. Allocates.
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

    /// The structure of tangent and mass matrix, when the model is a chain so long that it is cheaper to evaluate and
    /// solve with them as such. Allocates; not for step loops.
    fn tree(&self) -> Option<Tree> {
        None
    }

    /// The numbers of coordinates, one after another, of parts that move by themselves unless something couples them, such as
    /// contact; none where all is one. Allocates; not for step loops.
    fn parts(&self) -> Vec<usize> {
        Vec::new()
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

    /// [`Self::mass_matrix`] of a model that is a chain; symmetric to rounding.
    fn tree_mass_matrix(&mut self, _q: &[f64], _mass: &mut TreeMatrix) {
        unreachable!("the model is no chain");
    }

    /// The energies of a state.
    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy;

    /// Power that damping takes out of the motion, in watts, never negative.
    fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64;

    /// Where the tip is, in the frame of the model, in metres: what an accuracy is measured at.
    fn tip(&mut self, q: &[f64]) -> [f64; 3];

    /// Appends the places that an accuracy is measured at, in the frame of the model, in metres: as many in every state.
    /// By default the tip.
    fn places(&mut self, q: &[f64], places: &mut Vec<[f64; 3]>) {
        places.push(self.tip(q));
    }

    /// How far the one of these places that moves most moves from one state to another, in metres. Allocates; not for
    /// step loops.
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

    /// The length of the model, in metres: what errors of the tip are relative to.
    fn length(&self) -> f64;

    /// False where [`Self::dissipated_power`] is zero whatever the state, so that a run does not integrate it.
    fn is_damped(&self) -> bool {
        true
    }

    /// True where more than the damping of what the model is made of depends on velocities: drag, a current, a base
    /// that moves. The stability of an equilibrium is then that of the whole linearised motion, for a current also
    /// gives the stiffness its unsymmetric part, and a turning base its negative one.
    fn has_velocity_forces(&self) -> bool {
        false
    }

    /// True where surfaces can touch: forces then set in at once, and what is infinitely fast must be damped.
    fn has_contact(&self) -> bool {
        false
    }

    /// True where some forces may act in a part of all states only: contact, stops of joints, slack tendons, saturated motors.
    fn has_one_sided_forces(&self) -> bool {
        self.has_contact()
    }

    /// Lets surfaces pass through each other from now on, or no more.
    fn leave_contact(&mut self, _is_left: bool) {}

    /// From now on tangents linearise friction as suits an iteration that begins anew, or that has taken this part of the last
    /// increment; with nothing they are exact again.
    fn follow_friction(&mut self, _length: Option<f64>) {}

    /// Where surfaces have gone into each other by more than a radius.
    fn sunk(&mut self, _q: &[f64]) -> Option<Flaw> {
        None
    }

    /// Whether any surfaces overlap in a shape.
    fn overlaps(&mut self, _q: &[f64]) -> bool {
        false
    }

    /// Takes down where surfaces are in a shape: [`Self::have_passed`] goes on from there.
    fn note_surfaces(&mut self, _q: &[f64]) {}

    /// Whether surfaces pass through each other on the straight way from what was noted to a shape, which is noted then: whether
    /// they overlap by more than half of that radius there.
    fn have_passed(&mut self, _q: &[f64], _radius: Radius) -> bool {
        false
    }

    /// Whether surfaces meet too hard for a step of size `h`, in seconds, that begins with the coordinates and velocities
    /// `before` and ends in a motion: too hard to see the impact rise and fall.
    fn is_jolted(&mut self, _before: [&[f64]; 2], _motion: [&[f64]; 3], _h: f64) -> bool {
        false
    }

    /// Whether surfaces touch in the state that was looked at last.
    fn is_touched(&self) -> bool {
        false
    }

    /// Whether surfaces are so near each other there that they may touch in the next one.
    fn may_touch(&self) -> bool {
        false
    }

    /// Whether such a step ends with more energy than it began with, by more than errors of steps that see their impacts.
    fn gains_energy(&mut self, _before: [&[f64]; 2], _motion: [&[f64]; 3], _h: f64, _beside: Beside) -> bool {
        false
    }

    /// Power that what has no potential (moments of fixed direction, loads that vary, a base that is moved) puts into
    /// the motion, in watts. The accelerations matter where a base is moved.
    fn supplied_power(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64]) -> f64 {
        0.0
    }

    /// False where [`Self::supplied_power`] is zero whatever the state, so that a run does not integrate it.
    fn is_driven(&self) -> bool {
        false
    }

    /// Accelerations of the free motion: `qdd` with `tau(q, qd, qdd) = 0`, by a solve of `M qdd = -tau(q, qd, 0)`:
    /// Cholesky's, or that of a chain. `scratch` must be of this model.
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
