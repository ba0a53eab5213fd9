//! Models with an adjustable discretisation.

use super::flaw::{Flaw, at_least};
use crate::error::InvalidInput;

/// A finite number of modes and quadrature nodes. The defaults are for models without discretisation.
pub trait Discretised {
    /// Numbers of modes of all series whose coefficients are coordinates, in order, empty series included;
    /// `None` for a system that is not discretised by hierarchical series (where a longer series contains the
    /// shorter one).
    fn modes(&self) -> Option<Vec<usize>> {
        None
    }

    /// Numbers of coordinates, such as those of joints, before each of these series and after the last one.
    fn coordinates_between(&self) -> Vec<usize> {
        self.modes().map_or_else(Vec::new, |modes| vec![0; modes.len() + 1])
    }

    /// The same system with these numbers of modes and enough nodes; `None` if there would be too many.
    fn with_modes(&self, _modes: &[usize]) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

    /// The same system and coordinates with this multiple of the default number of quadrature nodes; `None`
    /// if the nodes are fixed, or would be too many.
    fn with_nodes_times(&self, _factor: usize) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

    /// Reason why results for this shape are meaningless; `None` for a valid shape.
    fn flaw(&mut self, _q: &[f64]) -> Option<Flaw> {
        None
    }

    /// Rejects an invalid shape; `place` is the name of `q`.
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
