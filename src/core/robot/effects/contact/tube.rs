//! Whether points and a radius are a tube.

use super::shapes::centre_line::{CentreLine, Tightest};
use crate::error::{Checker, InvalidInput, Number};
use crate::numerics::lie::Vector;

/// More of them would be a mistake in the input rather than a model of a vessel.
const MOST_POINTS: usize = 1000;

/// Everything that is wrong with them.
pub(super) fn check(check: &mut Checker, points: &[[f64; 3]], radius: f64) {
    let number = points.len();
    let mut is_right = check.require(
        (2..=MOST_POINTS).contains(&number),
        "points",
        format_args!("{number} points"),
        &format!("the centre line: 2 to {MOST_POINTS} points, of a straight tube its two ends"),
    );
    for (i, point) in points.iter().enumerate() {
        is_right &= check.finite(point, &format!("points[{i}]"));
    }
    for (i, ends) in points.windows(2).enumerate() {
        let place = format!("points[{}]", i + 1);
        is_right &= check.require(ends[0] != ends[1], &place, "the point before it", "another point");
    }
    if !is_right {
        return;
    }
    let points: Vec<_> = points.iter().map(|&point| Vector::from(point)).collect();
    let Tightest { place, radius: most } = CentreLine::new(&points).tightest();
    let [x, y, z] = place.to_array();
    let expected = format!(
        "less than {most:.4} m: the curve through the points bends as tightly as that, or comes as near to itself, at ({x:.4}, \
         {y:.4}, {z:.4}) m"
    );
    check.require(radius < most, "radius", Number(radius), &expected);
}

/// Places for drawings on each part of a centre line, which turns by less than half a radian.
const DRAWN: usize = 4;

/// Places along the smooth centre line of a tube through points, for drawings.
///
/// # Errors
///
/// What `check` finds of the points.
pub fn centre_line(points: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, InvalidInput> {
    let mut found = Checker::new();
    check(&mut found, points, 0.0);
    found.finish()?;
    let points: Vec<_> = points.iter().map(|&point| Vector::from(point)).collect();
    Ok(CentreLine::new(&points).places(DRAWN).into_iter().map(Vector::to_array).collect())
}
