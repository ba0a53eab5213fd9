//! Uneven ground.

use std::sync::Arc;

use super::{Cornered, Frame, Role, Shape, shape};
use crate::description::schema::{PerAxis, Reader, Rows};
use crate::robot::effects::contact::shapes::height_field::HeightField as Field;
use crate::robot::effects::contact::shapes::obstacle::Solid;

/// Largest number of heights: more would be a mistake in the input rather than a model of terrain.
const MOST_HEIGHTS: usize = 250_000;

shape! {
    /// Uneven ground: the region below a smooth surface that interpolates heights on a rectangular grid.
    ///
    /// The surface is the natural cubic spline through the heights in both directions, so forces vary smoothly along it. It is
    /// extended linearly beyond the grid. Steps in the heights make the spline overshoot.
    #[part(tag = "height_field", called = "a height field", positional = 4)]
    pub struct HeightField {
        /// Heights along the z axis in rows: two rows or more along the x axis, each of two numbers or more along the y axis.
        #[part(unit = "metres")]
        pub heights: Rows,
        /// Distance between neighbouring heights; two numbers for different spacings along x and y.
        #[part(unit = "metres", positive)]
        pub spacing: PerAxis<2>,
        /// Position of the first grid point, from which its height is measured.
        #[part(unit = "metres", default)]
        pub corner: [f64; 3],
        /// Orientation of its axes: unit quaternion (w, x, y, z).
        #[part(default = [1.0, 0.0, 0.0, 0.0])]
        pub orientation: [f64; 4],
    }
}

impl HeightField {
    fn fits(&self, reader: &mut Reader) {
        let Rows { numbers, shape: [rows, columns] } = &self.heights;
        let is_grid = *rows.min(columns) >= 2 && rows.checked_mul(*columns) == Some(numbers.len());
        reader.require(
            is_grid && numbers.len() <= MOST_HEIGHTS,
            "heights",
            format_args!("{} numbers in {rows} rows of {columns}", numbers.len()),
            &format!("two or more along each axis, and at most {MOST_HEIGHTS} in all"),
        );
        reader.check_orientation(&self.orientation);
    }
}

impl Shape for HeightField {
    fn label(&self) -> String {
        let [rows, columns] = self.heights.shape;
        format!("a height field of {rows} x {columns}")
    }

    /// The nearest point may be anywhere.
    fn lies_across(&self, _axis: usize, _height: f64) -> bool {
        false
    }

    fn thickness(&self) -> f64 {
        f64::INFINITY
    }

    fn solid(&self, frame: &Frame) -> Solid {
        let Rows { numbers, shape } = &self.heights;
        let (corner, axes) = (frame.place(self.corner), frame.axes(self.orientation));
        Solid::HeightField(Arc::new(Field::new(numbers, *shape, self.spacing.0, corner, axes)))
    }

    fn corners(&self) -> Option<&dyn Cornered> {
        None
    }

    fn role(&self) -> Role {
        Role::Ground
    }
}
