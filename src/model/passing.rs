//! Detection of surfaces that meet during a step, unseen at its ends.

use super::{Model, Radius};
use crate::error::Interrupted;
use crate::hermite;

/// What a gain of energy is compared with.
#[derive(Clone, Copy, Debug)]
pub enum Beside {
    /// The kinetic energy.
    Motion,
    /// Kinetic and elastic energy: a gain of half of this is an explosion.
    All,
}

/// Surfaces may overlap within a step by this part of the model's length without being seen.
const SHALLOW: f64 = 1e-4;

/// Shapes within a step that are looked at, at most.
const MOST_LOOKS: usize = 256;

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

/// Whether surfaces touch within a step between these times, displacements and rates although they do at neither end, as those of a
/// body that is thrown against a ceiling and falls back, or grazes a corner.
///
/// The motion bends away from the straight way between two of m looks by the m-th part squared of what it does in the whole
/// step: there are as many looks as make this shallow. `memory` is any vector, kept to save allocations.
pub(crate) fn have_touched<M: Model + ?Sized>(
    model: &mut M,
    [t, t_new]: [f64; 2],
    ends: [&[f64]; 2],
    rates: [&[f64]; 2],
    memory: &mut Vec<f64>,
) -> Result<bool, Interrupted> {
    let (n, h) = (ends[0].len(), t_new - t);
    memory.resize(2 * n, 0.0);
    let (q, sizes) = memory.split_at_mut(n);
    model.typical_coordinates(sizes);
    let changes = rates[0].iter().zip(rates[1]).zip(&*sizes);
    let bend = changes.map(|((leaving, coming), size)| (0.125 * h * (leaving - coming) / size).abs());
    let looks = (bend.fold(0.0, f64::max) / SHALLOW).sqrt().ceil().clamp(2.0, MOST_LOOKS as f64) as usize;
    let mut has_touched = false;
    model.set_time(t)?;
    model.note_surfaces(ends[0]);
    for look in 1..=looks {
        let x = look as f64 / looks as f64;
        for (i, q) in q.iter_mut().enumerate() {
            *q = hermite::cubic(x, h, ends.map(|end| end[i]), rates.map(|rate| rate[i]));
        }
        let is_end = look == looks;
        model.set_time(if is_end { t_new } else { t + x * h })?;
        let there = if is_end { ends[1] } else { &*q };
        // Nothing passes half-spaces: they are touched first at the ends of a straight way.
        has_touched = model.have_passed(there, Radius::Touching) || !is_end && model.overlaps(there);
        if has_touched {
            break;
        }
    }
    if !has_touched {
        return Ok(false);
    }
    for (t, q) in [(t, ends[0]), (t_new, ends[1])] {
        model.set_time(t)?;
        if model.overlaps(q) {
            return Ok(false);
        }
    }
    Ok(true)
}
