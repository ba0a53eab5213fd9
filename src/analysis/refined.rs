//! Coordinates of a model in one with more modes ([`Refinable::with_modes`](crate::model::Refinable::with_modes)).

use crate::description::rod::MAX_MODES;
use crate::model::Model;

/// A model with this many more modes of all strains that have some, and a shape in its coordinates; `None` for a model without modes and
/// if there would be more than `most` of them.
pub(crate) fn with_more_modes<M: Model>(
    model: &M,
    q: &[f64],
    more: usize,
    most: usize,
) -> Option<(M, Vec<f64>)> {
    let modes = model.modes()?;
    let between = model.coordinates_between();
    let with_more = |&modes: &usize| if modes == 0 { 0 } else { (modes + more).min(MAX_MODES) };
    let fine: Vec<usize> = modes.iter().map(with_more).collect();
    if fine.iter().sum::<usize>() > most {
        return None;
    }
    let richer = model.with_modes(&fine)?;
    let q = embed(q, &all_places(&modes, &fine, &between), richer.facts().n);
    Some((richer, q))
}

/// Coordinates of a coarser model in one of `n` coordinates, where they are at these places.
pub(crate) fn embed(values: &[f64], places: &[usize], n: usize) -> Vec<f64> {
    let mut all = vec![0.0; n];
    for (&place, &value) in places.iter().zip(values) {
        all[place] = value;
    }
    all
}

/// Indices of the coordinates of a model with `modes` modes in a model with more modes (`of`), where
/// `between` other coordinates precede the modes of each series in both models.
pub(crate) fn all_places(modes: &[usize], of: &[usize], between: &[usize]) -> Vec<usize> {
    let mut first = 0;
    let mut places = Vec::new();
    for ((modes, of), others) in modes.iter().chain([&0]).zip(of.iter().chain([&0])).zip(between) {
        places.extend(first..first + others + modes);
        first += others + of;
    }
    places
}

/// The same for modes only, because joints do not respond statically.
pub(crate) fn places_of_modes(modes: &[usize], of: &[usize], between: &[usize]) -> Vec<usize> {
    let mut first = 0;
    let mut places = Vec::new();
    for ((modes, of), others) in modes.iter().zip(of).zip(between) {
        first += others;
        places.extend(first..first + modes);
        first += of;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::{all_places, places_of_modes};

    #[test]
    fn coordinates_of_joints_keep_their_place_between_modes() {
        let (modes, richer, between) = ([2, 0, 1], [3, 1, 4], [1, 0, 2, 3]);
        assert_eq!(places_of_modes(&modes, &richer, &between), [1, 2, 7]);
        assert_eq!(all_places(&modes, &richer, &between), [0, 1, 2, 5, 6, 7, 11, 12, 13]);
        assert_eq!(all_places(&modes, &modes, &between), (0..9).collect::<Vec<_>>());
    }
}
