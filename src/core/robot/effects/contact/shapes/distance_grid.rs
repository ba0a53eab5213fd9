//! Shapes given by signed distances on a grid, placed in space.

use std::sync::Arc;

use super::distance::Distance;
use super::level_set::LevelSet;
use crate::numerics::lie::{Geometry as _, Rotation, Spatial, Vector};

/// The surface on which a spline through distances is zero, shared between copies, at a place.
#[derive(Clone, Debug)]
pub(crate) struct DistanceGrid {
    surface: Arc<LevelSet>,
    /// Position of the first value, and the axes, in the frame of the plan.
    corner: Vector<f64>,
    axes: Rotation<f64>,
}

impl DistanceGrid {
    pub(crate) fn new(surface: Arc<LevelSet>, corner: Vector<f64>, axes: Rotation<f64>) -> Self {
        Self { surface, corner, axes }
    }

    fn local(&self, point: Vector<f64>) -> Vector<f64> {
        self.axes.apply_transposed(point - self.corner)
    }

    /// Distance of a point from the shape.
    pub(crate) fn distance(&self, point: Vector<f64>) -> Distance {
        let Distance { value, normal, curvature } = self.surface.distance(self.local(point));
        let curvature = Spatial::<false>::rotate_second_moment(&self.axes, &curvature);
        Distance { value, normal: self.axes.apply(normal), curvature }
    }

    /// Whether a point is certainly farther from it than `reach`, by cells.
    pub(crate) fn is_certainly_beyond(&self, point: Vector<f64>, reach: f64) -> bool {
        self.surface.is_certainly_beyond(self.local(point), reach)
    }

    /// Largest distance of its points from the origin; infinite if it goes on beyond the grid.
    pub(crate) fn reach(&self) -> f64 {
        let Some([low, high]) = self.surface.extent() else { return f64::INFINITY };
        let corner = |k: usize| {
            let [low, high] = [low, high].map(Vector::to_array);
            let beside = std::array::from_fn(|i| if k >> i & 1 == 0 { low[i] } else { high[i] });
            let place = self.corner + self.axes.apply(Vector::from(beside));
            place.dot(place).sqrt()
        };
        (0..8).map(corner).fold(0.0, f64::max)
    }

    /// Depth of its middle below the surface; zero if it goes on beyond the grid.
    pub(crate) fn depth(&self) -> f64 {
        let depth = self.surface.depth();
        if depth.is_finite() { depth } else { 0.0 }
    }

    /// Largest concave curvature of its surface, per metre.
    pub(crate) fn hollowness(&self) -> f64 {
        self.surface.hollowness()
    }
}
