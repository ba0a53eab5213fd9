//! Shapes of obstacles, and distances of curves and bodies to them.

mod bernstein;
pub(crate) mod bracket;
pub(crate) mod centre_line;
pub(crate) mod convex_mesh;
pub(crate) mod distance;
pub(crate) mod distance_grid;
pub(crate) mod edge;
pub(crate) mod ellipse;
pub(crate) mod elliptic_tube;
pub(crate) mod height_field;
pub(crate) mod level_set;
pub(crate) mod obstacle;
pub(crate) mod slide;
mod spline;
pub(crate) mod touch;
pub(crate) mod triangles;
mod tricubic;
pub(crate) mod tube;
