//! Detection of surfaces that pass through each other during a step.

use super::{Model, Radius};
use crate::error::Interrupted;

/// Whether surfaces of a model pass through each other along a path given by times and shapes.
pub(crate) fn have_passed<'a, M: Model + ?Sized>(
    model: &mut M,
    way: impl Iterator<Item = (f64, &'a [f64])>,
    radius: Radius,
) -> Result<bool, Interrupted> {
    for (i, (t, q)) in way.enumerate() {
        model.set_time(t)?;
        if i == 0 {
            model.note_surfaces(q);
        } else if model.have_passed(q, radius) {
            return Ok(true);
        }
    }
    Ok(false)
}
