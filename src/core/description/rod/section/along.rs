//! Validation of section properties along a segment.

use crate::description::rod::profile::Variation;
use crate::error::InvalidInput;

/// Number of sample points of a varying section, in addition to the stations of its tables.
pub(crate) const PLACES: usize = 256;

/// Range of a section's properties in SI units, far beyond all rods: products of three of them keep all
/// digits of a double.
pub(crate) const SMALLEST: f64 = 1e-100;

pub(crate) const LARGEST: f64 = 1e100;

/// Stations of tables inside (0, 1), in increasing order.
pub(crate) fn breaks(variations: &[Variation<'_>]) -> Vec<f64> {
    let mut breaks: Vec<f64> =
        variations.iter().flat_map(fractions).filter(|&x| x > 0.0 && x < 1.0).collect();
    breaks.sort_by(f64::total_cmp);
    breaks.dedup();
    breaks
}

/// Stations of a table as fractions of its length.
pub(crate) fn fractions<'a>(variation: &Variation<'a>) -> impl Iterator<Item = f64> + use<'a> {
    let stations = variation.stations;
    let end = stations.last().copied().unwrap_or(1.0);
    stations.iter().map(move |station| station / end)
}

/// Problems of section properties along a segment of this length, at the first point where there is any.
pub(crate) fn validate_along(
    variations: &[Variation<'_>],
    length: f64,
    validate: impl Fn(f64) -> Result<(), InvalidInput>,
) -> Result<(), InvalidInput> {
    if variations.is_empty() {
        return validate(0.0);
    }
    let evenly = (0..=PLACES).map(|i| i as f64 / PLACES as f64);
    let mut places: Vec<f64> = evenly.chain(variations.iter().flat_map(fractions)).collect();
    places.sort_by(f64::total_cmp);
    places.into_iter().try_for_each(|x| {
        validate(x).map_err(|mut error| {
            for problem in &mut error.problems {
                problem.found += &format!(" at X = {}", x * length);
            }
            error
        })
    })
}
