//! Linear systems of Newton's method: a Jacobian with its factors.

use crate::error::InvalidInput;
use crate::integrators::second_order::{Failure, SecondOrderSystem};
use crate::model::Dynamics;
use crate::model::constraint::Saddle;
use crate::numerics::linalg::{BlockLu, Lu, Matrix, Singular, TreeLu, TreeMatrix};
use crate::numerics::memory;
use crate::numerics::roots::Derivative;
use crate::numerics::tape::Tape;

/// Smallest number of parts for the block-sparse factorisation: with fewer, factors are a small part of a step anyway.
const FEWEST_PARTS: usize = 4;

/// A Jacobian and its factorisation, with memory for repeated use.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one for an integration, and it is not moved")]
pub(crate) enum LinearSystem {
    Dense {
        jacobian: Matrix,
        lu: Lu,
    },
    /// Block-sparse Jacobian of parts that are coupled only by contacts.
    Blocks {
        jacobian: Matrix,
        lu: BlockLu,
    },
    Tree {
        jacobian: TreeMatrix,
        lu: TreeLu,
    },
    /// With constraints.
    Saddle(Box<Saddle>),
}

impl LinearSystem {
    /// Memory for a system of no coordinates.
    pub(super) fn empty() -> Self {
        Self::dense(0)
    }

    /// Memory for the Jacobian of a system; dense if it is computed by differences.
    pub(super) fn new<S: SecondOrderSystem + ?Sized>(system: &mut S, derivative: Derivative) -> Self {
        if system.facts().constraints() > 0 {
            return Self::of_size(system.facts().n, system.facts().constraints());
        }
        let chain = if derivative == Derivative::Analytic { tree(system) } else { None };
        match chain {
            Some(jacobian) => Self::Tree { lu: TreeLu::new(&jacobian), jacobian },
            None => Self::of_parts(&system.facts().parts).unwrap_or_else(|| Self::dense(system.facts().n)),
        }
    }

    /// Block-sparse memory for parts of these numbers of unknowns; `None` if there are too few parts.
    fn of_parts(sizes: &[usize]) -> Option<Self> {
        let n = sizes.iter().sum();
        (sizes.len() >= FEWEST_PARTS)
            .then(|| Self::Blocks { jacobian: Matrix::zeros(n, n), lu: BlockLu::new(sizes) })
    }

    /// An entry of the Jacobian, of two coordinates of one link.
    pub(super) fn entry(&mut self, i: usize, j: usize) -> &mut f64 {
        match self {
            Self::Dense { jacobian, .. } | Self::Blocks { jacobian, .. } => &mut jacobian[(i, j)],
            Self::Tree { jacobian, .. } => jacobian.entry_of_block(i, j),
            Self::Saddle(saddle) => &mut saddle.tangent[(i, j)],
        }
    }

    /// Refuses a system whose matrices do not fit in memory.
    pub(crate) fn check_memory<S: SecondOrderSystem + ?Sized>(
        system: &mut S,
        derivative: Derivative,
    ) -> Result<(), InvalidInput> {
        /// The Jacobian and its factors; with parts both kinds of factors.
        const SQUARE_MATRICES: [usize; 2] = [2, 3];
        let is_chain = derivative == Derivative::Analytic && tree(system).is_some();
        let has_parts = system.facts().parts.len() >= FEWEST_PARTS;
        let matrices = if is_chain { 0 } else { SQUARE_MATRICES[usize::from(has_parts)] };
        memory::check_square(
            matrices,
            system.facts().n,
            "q0",
            "an explicit method of `solve_ivp` needs no matrices",
        )
    }

    /// Memory for dense matrices of `n` coordinates and this number of constraints.
    pub(crate) fn of_size(n: usize, constraints: usize) -> Self {
        match constraints {
            0 => Self::dense(n),
            m => Self::Saddle(Box::new(Saddle::new(n, m))),
        }
    }

    fn dense(n: usize) -> Self {
        Self::Dense { jacobian: Matrix::zeros(n, n), lu: Lu::new(n) }
    }

    /// Factorises the Jacobian.
    pub(crate) fn factorise(&mut self) -> Result<(), Failure> {
        let factorised = match self {
            Self::Dense { jacobian, lu } => lu.factorise(jacobian),
            Self::Blocks { jacobian, lu } => lu.factorise(jacobian),
            Self::Tree { jacobian, lu } => lu.factorise(jacobian),
            Self::Saddle(saddle) => saddle.factorise(),
        };
        factorised
            .map_err(|Singular| if self.is_finite() { Failure::SingularJacobian } else { Failure::NonFinite })
    }

    /// Writes or reads the Jacobian; its factors are recomputed.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        match self {
            Self::Dense { jacobian, .. } | Self::Blocks { jacobian, .. } => {
                tape.numbers(jacobian.as_mut_slice());
            }
            Self::Tree { jacobian, .. } => {
                for matrix in jacobian.parts_mut() {
                    tape.numbers(matrix.as_mut_slice());
                }
            }
            Self::Saddle(saddle) => {
                tape.numbers(saddle.tangent.as_mut_slice());
                tape.numbers(saddle.constraints.as_mut_slice());
            }
        }
    }

    /// Number of independent constraints at the last factorisation.
    pub(super) fn rank(&self) -> usize {
        if let Self::Saddle(saddle) = self { saddle.rank() } else { 0 }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Dense { jacobian, .. } | Self::Blocks { jacobian, .. } => {
                jacobian.iter().all(|entry| entry.is_finite())
            }
            Self::Tree { jacobian, .. } => jacobian.is_finite(),
            Self::Saddle(saddle) => {
                saddle.tangent.iter().chain(saddle.constraints.iter()).all(|entry| entry.is_finite())
            }
        }
    }

    /// Solves with the factors, in place.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        match self {
            Self::Dense { lu, .. } => lu.solve(b),
            Self::Blocks { lu, .. } => lu.solve(b),
            Self::Tree { lu, .. } => lu.solve(b),
            Self::Saddle(saddle) => saddle.solve(b),
        }
    }
}

/// The structure of the tangent of a chain for which this form is cheaper.
fn tree<S: SecondOrderSystem + ?Sized>(system: &mut S) -> Option<TreeMatrix> {
    Some(system.model()?.tree()?.tangent)
}
