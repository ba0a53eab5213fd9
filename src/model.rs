//! What every mechanical system of lissom offers to the integrators.

use crate::error::{Interrupted, InvalidInput};
use crate::linalg::{ChainLu, ChainMatrix, Cholesky, Matrix};
use crate::springs::Springs;

/// The energies of a state, in joules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Elastic (strain) energy.
    pub elastic: f64,
    /// Potential energy in the gravity field, zero at the world's origin.
    pub gravitational: f64,
    /// Potential energy of the loads that have one.
    pub loads: f64,
}

impl Energy {
    /// The sum of all parts: constant in free motion without damping.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational + self.loads
    }
}

/// Why a shape is none that the model can have, or none that it can follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flaw {
    /// It turns by more than half a turn between neighbouring quadrature nodes.
    Unresolved {
        /// How many times as many nodes it takes.
        shortage: f64,
    },
    /// It is turned inside out.
    Inverted {
        /// Arc length of the unstretched rod where it is worst, in metres.
        at: f64,
        /// The stretch there: length over length at rest, not positive.
        stretch: f64,
    },
}

impl std::fmt::Display for Flaw {
    /// What the rod does.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::Unresolved { .. } => {
                write!(f, "turns by more than half a turn between neighbouring quadrature nodes")
            }
            Self::Inverted { at, stretch } => {
                write!(f, "is turned inside out (stretch {} at X = {})", Rounded(stretch), Rounded(at))
            }
        }
    }
}

/// A number with four digits.
struct Rounded(f64);

impl std::fmt::Display for Rounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(value) = *self;
        let is_handy = value == 0.0 || (1e-3..1e4).contains(&value.abs());
        if is_handy { write!(f, "{}", (value * 1e4).round() / 1e4) } else { write!(f, "{value:.3e}") }
    }
}

/// The mass matrix was not positive definite (or not finite), so that no acceleration exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SingularMass;

impl std::fmt::Display for SingularMass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the mass matrix is not positive definite, or not finite: no acceleration exists")
    }
}

impl std::error::Error for SingularMass {}

/// The matrices of a model that is a chain, as zeros: their structure.
#[derive(Clone, Debug)]
pub struct Chain {
    /// For [`Model::chain_tangent`].
    pub tangent: ChainMatrix,
    /// For [`Model::chain_mass_matrix`].
    pub mass: ChainMatrix,
}

/// A mechanical system with generalised coordinates `q` (n of them), velocities `qd`, accelerations `qdd`.
///
/// `tau(q, qd, qdd)` is the generalised force that the motion needs, elasticity, damping and dead loads
/// included: it is zero in free motion. A model owns its scratch memory, hence `&mut self`; all its methods
/// are pure functions of their arguments otherwise (and of the time last set), and none of them allocates.
/// Slices of the wrong length are a programming error and panic; the bindings check them first.
pub trait Model {
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

    /// The part of `tau` at rest that is there without any load: that of elasticity, `K q` of a rod without supports.
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]);

    /// The derivative of [`Self::elastic_forces`], symmetric.
    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix);

    /// How many forces its springs to the world have.
    fn springs(&self) -> usize {
        0
    }

    /// Its springs in a shape, with the forces that they have there. Some evaluations of the forces for each; not for
    /// step loops.
    fn linearise_springs(&mut self, _q: &[f64], _springs: &mut Springs) {}

    /// From now on forces and tangents at rest take these for the springs' forces, whatever the shape, until they get
    /// `None`.
    fn hold_springs(&mut self, _forces: Option<&[f64]>) {}

    /// Changes of the coordinates that count as large, all > 0: what makes coordinates of different units comparable.
    fn typical_coordinates(&self, sizes: &mut [f64]) {
        sizes.fill(1.0);
    }

    /// About how many inverse dynamics cost as much as a weighted tangent: decides when an implicit step renews its
    /// Jacobian.
    fn tangent_cost(&self) -> f64 {
        3.0
    }

    /// The symmetric positive definite mass matrix.
    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix);

    /// The structure of tangent and mass matrix, when the model is a chain so long that it is cheaper to evaluate and
    /// solve with them as such. Allocates; not for step loops.
    fn chain(&self) -> Option<Chain> {
        None
    }

    /// [`Self::weighted_tangent`] of a model that is a chain.
    fn chain_tangent(
        &mut self,
        _q: &[f64],
        _qd: &[f64],
        _qdd: &[f64],
        _weights: [f64; 3],
        _tangent: &mut ChainMatrix,
    ) {
        unreachable!("the model is no chain");
    }

    /// [`Self::mass_matrix`] of a model that is a chain; symmetric to rounding.
    fn chain_mass_matrix(&mut self, _q: &[f64], _mass: &mut ChainMatrix) {
        unreachable!("the model is no chain");
    }

    /// The energies of a state.
    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy;

    /// Power that damping takes out of the motion, in watts, never negative.
    fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64;

    /// Where the tip is, in the frame of the model, in metres: what an accuracy is measured at.
    fn tip(&mut self, q: &[f64]) -> [f64; 3];

    /// The length of the model, in metres: what errors of the tip are relative to.
    fn length(&self) -> f64;

    /// How far in time a step from `t` may go that cannot pass unseen over something that drives the system: adaptive
    /// methods end a step there. Infinite where nothing does, or nothing is known of it.
    fn horizon(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// The shortest period of what drives the system, in seconds.
    fn shortest_period(&self) -> f64 {
        f64::INFINITY
    }

    /// Why what is computed of this shape means nothing; `None` where it does mean something.
    fn flaw(&self, _q: &[f64]) -> Option<Flaw> {
        None
    }

    /// Refuses a shape with a flaw; `place` is the name of `q`.
    fn check_shape(&self, q: &[f64], place: &str) -> Result<(), InvalidInput> {
        let Some(flaw) = self.flaw(q) else { return Ok(()) };
        let expected = match flaw {
            Flaw::Unresolved { shortage } => format!(
                "a shape that the nodes resolve: smaller curvatures, more segments, or more `nodes`{}",
                at_least(shortage)
            ),
            Flaw::Inverted { .. } => {
                "a stretch (reference strain and modes together) > 0 all along".to_owned()
            }
        };
        Err(InvalidInput::new(place, format_args!("a rod that {flaw}"), expected))
    }

    /// Whether a finite number of modes stands for infinitely many.
    fn is_discretised(&self) -> bool {
        false
    }

    /// Numbers of modes of all the series that the coordinates are coefficients of, those without modes included, in
    /// their order; `None` for a system that is not discretised by series of which each one begins like a longer one.
    fn modes(&self) -> Option<Vec<usize>> {
        None
    }

    /// The same system with these numbers of modes, and more nodes; `None` where there would be too many.
    fn with_modes(&self, _modes: &[usize]) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

    /// The same system in the same coordinates with so many times the quadrature nodes that it has by default; `None`
    /// where it leaves none open, or would have too many.
    fn with_nodes_times(&self, _factor: usize) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

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

    /// Power that what has no potential (moments of fixed direction, loads that vary, a base that is moved) puts into
    /// the motion, in watts. The accelerations matter where a base is moved.
    fn supplied_power(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64]) -> f64 {
        0.0
    }

    /// False where [`Self::supplied_power`] is zero whatever the state, so that a run does not integrate it.
    fn is_driven(&self) -> bool {
        false
    }

    /// The times, in seconds, between which the model is known; beyond, what depends on time by itself is NaN.
    fn time_span(&self) -> [f64; 2] {
        [f64::NEG_INFINITY, f64::INFINITY]
    }

    /// True where something of the model depends on time by itself, so that [`Self::set_time`] has to be called
    /// before anything is evaluated.
    fn varies_in_time(&self) -> bool {
        false
    }

    /// The time, in seconds, at which what depends on it by itself (loads that vary, a base that is moved) is
    /// evaluated from now on. Fails where a function of time that somebody else provides does.
    fn set_time(&mut self, _t: f64) -> Result<(), Interrupted> {
        Ok(())
    }

    /// What of the model is not finite at the time that is set, in words, so that nothing follows from it; `None`
    /// where all is.
    fn not_finite(&self) -> Option<String> {
        None
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
        let ForwardScratch { bias, mass } = scratch;
        qdd.fill(0.0);
        self.inverse_dynamics(q, qd, qdd, bias);
        for (acceleration, bias) in qdd.iter_mut().zip(bias) {
            *acceleration = -*bias;
        }
        match mass {
            Mass::Dense { matrix, cholesky } => {
                self.mass_matrix(q, matrix);
                cholesky.factorise(matrix).map_err(|_| SingularMass)?;
                cholesky.solve(qdd);
            }
            Mass::Chain { matrix, lu } => {
                self.chain_mass_matrix(q, matrix);
                lu.factorise(matrix).map_err(|_| SingularMass)?;
                lu.solve(qdd);
            }
        }
        Ok(())
    }
}

/// Memory for [`Model::forward_dynamics`].
#[derive(Clone, Debug)]
pub struct ForwardScratch {
    bias: Vec<f64>,
    mass: Mass,
}

/// The mass matrix and its factors.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one, and it is not moved")]
enum Mass {
    Dense { matrix: Matrix, cholesky: Cholesky },
    Chain { matrix: ChainMatrix, lu: ChainLu },
}

impl ForwardScratch {
    /// Scratch for a model of `n` coordinates that is no chain, or is to be treated as if it were none.
    pub fn new(n: usize) -> Self {
        let mass = Mass::Dense { matrix: Matrix::zeros(n, n), cholesky: Cholesky::new(n) };
        Self { bias: vec![0.0; n], mass }
    }

    /// Scratch for `model`.
    pub fn of<M: Model + ?Sized>(model: &M) -> Self {
        match model.chain() {
            Some(Chain { mass, .. }) => {
                let lu = ChainLu::new(&mass);
                Self { bias: vec![0.0; model.n()], mass: Mass::Chain { matrix: mass, lu } }
            }
            None => Self::new(model.n()),
        }
    }
}

/// ", at least 3 times as many": how many nodes a shape takes that they do not resolve, where that is a number anyone
/// would ask for.
pub(crate) fn at_least(shortage: f64) -> String {
    /// More is no shape to be resolved but a state that has left all bounds.
    const MOST: f64 = 1000.0;
    if shortage < MOST { format!(", at least {:.0} times as many", shortage.ceil()) } else { String::new() }
}
