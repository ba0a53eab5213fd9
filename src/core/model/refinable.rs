//! Models with an adjustable discretisation.

use super::Dynamics;

/// A finite number of modes and quadrature nodes.
pub trait Refinable: Dynamics {
    /// Numbers of modes of all series whose coefficients are coordinates, in order, empty series included;
    /// `None` for a system that is not discretised by hierarchical series (where a longer series contains the
    /// shorter one).
    fn modes(&self) -> Option<Vec<usize>>;

    /// Numbers of coordinates, such as those of joints, before each of these series and after the last one.
    fn coordinates_between(&self) -> Vec<usize>;

    /// The same system with these numbers of modes and enough nodes; `None` if there would be too many.
    fn with_modes(&self, modes: &[usize]) -> Option<Self>
    where
        Self: Sized;

    /// The same system and coordinates with this multiple of the default number of quadrature nodes; `None`
    /// if the nodes are fixed, or would be too many.
    fn with_nodes_times(&self, factor: usize) -> Option<Self>
    where
        Self: Sized;
}
