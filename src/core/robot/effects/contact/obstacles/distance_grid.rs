//! Shapes given by signed distances on a grid.

use std::sync::Arc;

use super::recent::Recent;
use super::{Cornered, Frame, Role, Shape, shape};
use crate::description::schema::{Layers, PerAxis, Reader};
use crate::robot::effects::contact::shapes::distance_grid::DistanceGrid as Grid;
use crate::robot::effects::contact::shapes::level_set::LevelSet;
use crate::robot::effects::contact::shapes::obstacle::Solid;

/// Largest number of values: they and the coefficients of the spline take 160 MB then.
pub(super) const MOST_VALUES: usize = 10_000_000;

/// Surfaces of the grids that were used last.
static SURFACES: Recent<(Layers, [f64; 3]), LevelSet> = Recent::new();

shape! {
    /// A shape of any form, given by signed distances on a regular grid: negative inside, positive outside.
    ///
    /// Its surface is where the tricubic spline through the values is zero, and contact takes the exact distance from that surface, also if
    /// the values are another function with the same zeros whose slope does not vanish there. Of smooth shapes the error falls with the fourth power of the spacing; edges
    /// and corners are rounded by up to half of a spacing, and walls need two spacings or more. If all values on the border are positive, all
    /// beyond the grid is outside, if none is, all beyond is inside; otherwise the surface continues linearly.
    #[part(tag = "distance_grid", called = "a distance grid", positional = 4)]
    pub struct DistanceGrid {
        /// Signed distances: two or more along each of the axes x, y and z, in this order.
        #[part(unit = "metres")]
        pub values: Layers,
        /// Distance between neighbouring values; three numbers for different spacings along x, y and z.
        #[part(unit = "metres", positive)]
        pub spacing: PerAxis<3>,
        /// Position of the first value.
        #[part(unit = "metres", default)]
        pub corner: [f64; 3],
        /// Orientation of its axes: unit quaternion (w, x, y, z).
        #[part(default = [1.0, 0.0, 0.0, 0.0])]
        pub orientation: [f64; 4],
    }
}

impl DistanceGrid {
    fn fits(&self, reader: &mut Reader) {
        let Layers { numbers, shape } = &self.values;
        let [rows, columns, layers] = *shape;
        let is_grid = shape.iter().all(|&n| n >= 2) && numbers.len() <= MOST_VALUES;
        let is_whole = reader.require(
            is_grid && shape.iter().product::<usize>() == numbers.len(),
            "values",
            format_args!("{rows} x {columns} x {layers} numbers"),
            &format!("two or more along each axis, and at most {MOST_VALUES} in all"),
        );
        if is_whole {
            let has = |is_inside: bool| numbers.iter().any(|&value| (value < 0.0) == is_inside);
            let found = if has(true) { "no positive number" } else { "no negative number" };
            reader.require(
                has(true) && has(false),
                "values",
                found,
                "distances of both signs: negative inside the shape",
            );
        }
        reader.check_orientation(&self.orientation);
    }

    fn surface(&self) -> Arc<LevelSet> {
        let key = (self.values.clone(), self.spacing.0);
        SURFACES.get(&key, || LevelSet::new(&self.values.numbers, self.values.shape, self.spacing.0))
    }
}

impl Shape for DistanceGrid {
    fn label(&self) -> String {
        let [rows, columns, layers] = self.values.shape;
        format!("a distance grid of {rows} x {columns} x {layers}")
    }

    fn rounding(&self) -> Option<f64> {
        Some(self.spacing.0.into_iter().fold(0.0, f64::max))
    }

    /// The nearest point may be anywhere.
    fn lies_across(&self, _axis: usize, _height: f64) -> bool {
        false
    }

    fn thickness(&self) -> f64 {
        self.surface().depth()
    }

    fn solid(&self, frame: &Frame) -> Solid {
        let (corner, axes) = (frame.place(self.corner), frame.axes(self.orientation));
        Solid::DistanceGrid(Arc::new(Grid::new(self.surface(), corner, axes)))
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        None
    }

    fn role(&self) -> Role {
        Role::Ground
    }
}
