//! Models with an adjustable discretisation.

use super::flaw::{Flaw, at_least};
use crate::error::InvalidInput;

/// A finite number of modes and quadrature nodes. A model without has nothing to say.
pub trait Discretised {
    /// Whether a finite number of modes stands for infinitely many.
    fn is_discretised(&self) -> bool {
        false
    }

    /// Numbers of modes of all the series that the coordinates are coefficients of, those without modes included, in
    /// their order; `None` for a system that is not discretised by series of which each one begins like a longer one.
    fn modes(&self) -> Option<Vec<usize>> {
        None
    }

    /// How many coordinates that are no coefficients, those of joints, stand before each of these series, and behind the
    /// last one.
    fn coordinates_between(&self) -> Vec<usize> {
        self.modes().map_or_else(Vec::new, |modes| vec![0; modes.len() + 1])
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

    /// Why what is computed of this shape means nothing; `None` where it does mean something.
    fn flaw(&mut self, _q: &[f64]) -> Option<Flaw> {
        None
    }

    /// Refuses a shape with a flaw; `place` is the name of `q`.
    fn check_shape(&mut self, q: &[f64], place: &str) -> Result<(), InvalidInput> {
        let Some(flaw) = self.flaw(q) else { return Ok(()) };
        let expected = match flaw {
            Flaw::Unresolved { shortage } => format!(
                "a shape that the nodes resolve: smaller curvatures, more segments, or more `nodes`{}",
                at_least(shortage)
            ),
            Flaw::Inverted { .. } => {
                "a stretch (reference strain and modes together) > 0 all along".to_owned()
            }
            Flaw::Open { .. } => "one in which the loops are closed, or can be from there".to_owned(),
            Flaw::Sunk { .. } => "surfaces that overlap by less than a radius".to_owned(),
            Flaw::Collapsed { .. } => {
                "points apart from each other where a tendon pulls between them".to_owned()
            }
        };
        Err(InvalidInput::new(place, format_args!("a rod that {flaw}"), expected))
    }
}
