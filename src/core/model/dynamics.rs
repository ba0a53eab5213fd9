//! Forces, inertia and energies of a mechanical system.

use super::forward::{ForwardScratch, Mass, SingularMass, Tree};
use super::invalid_shape::{InvalidShape, at_least};
use super::{Energy, Facts};
use crate::error::InvalidInput;
use crate::numerics::linalg::{Matrix, TreeLu, TreeMatrix};

/// A mechanical system with generalised coordinates `q` (n of them), velocities `qd`, accelerations `qdd`.
///
/// `tau(q, qd, qdd)` is the generalised force that a motion requires, including elasticity, damping and dead
/// loads; it is zero in free motion. A model owns its scratch memory, hence `&mut self`. Apart from that, and
/// from the time last set, all methods are pure functions of their arguments, and none allocates. Slices of
/// the wrong length are a programming error and panic; the bindings check lengths first.
pub trait Dynamics {
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

    /// Power of forces without a potential (moments of fixed direction, varying loads, a moving base), in
    /// watts. Accelerations matter only for a moving base.
    fn supplied_power(&mut self, q: &[f64], qd: &[f64], qdd: &[f64]) -> f64;

    /// Reason why results for this shape are meaningless; `None` for a valid shape.
    fn invalid_shape(&mut self, q: &[f64]) -> Option<InvalidShape>;

    /// Rejects an invalid shape; `place` is the name of `q`.
    fn check_shape(&mut self, q: &[f64], place: &str) -> Result<(), InvalidInput> {
        let Some(invalid_shape) = self.invalid_shape(q) else { return Ok(()) };
        let expected = match invalid_shape {
            InvalidShape::Unresolved { shortage } => format!(
                "a shape that the nodes resolve: smaller curvatures, more segments, or more `nodes`{}",
                at_least(shortage)
            ),
            InvalidShape::Inverted { .. } => {
                "a stretch (reference strain and modes together) > 0 all along".to_owned()
            }
            InvalidShape::Open { .. } => "a shape with closed loops".to_owned(),
            InvalidShape::DeepPenetration { .. } => "surfaces that overlap by less than a radius".to_owned(),
            InvalidShape::Collapsed { .. } => {
                "points apart from each other where a tendon pulls between them".to_owned()
            }
        };
        Err(InvalidInput::new(place, format_args!("a rod that {invalid_shape}"), expected))
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
        forward_dynamics(self, q, qd, qdd, scratch)
    }
}

impl ForwardScratch {
    /// Scratch for `model`.
    pub fn of<M: Dynamics + ?Sized>(model: &M) -> Self {
        match model.tree() {
            Some(Tree { mass, .. }) => {
                let lu = TreeLu::new(&mass);
                Self { bias: vec![0.0; model.facts().n], mass: Mass::Tree { matrix: mass, lu } }
            }
            None => Self::new(model.facts().n),
        }
    }
}

/// [`Dynamics::forward_dynamics`] for models without constraints.
pub(crate) fn forward_dynamics<M: Dynamics + ?Sized>(
    model: &mut M,
    q: &[f64],
    qd: &[f64],
    qdd: &mut [f64],
    scratch: &mut ForwardScratch,
) -> Result<(), SingularMass> {
    qdd.fill(0.0);
    model.inverse_dynamics(q, qd, qdd, &mut scratch.bias);
    match &mut scratch.mass {
        Mass::Dense { matrix, .. } => model.mass_matrix(q, matrix),
        Mass::Tree { matrix, .. } => model.tree_mass_matrix(q, matrix),
    }
    scratch.solve(qdd)
}
