//! What the finite number of modes of rods does to natural frequencies: those of the same vibrations in a model with more modes.
//!
//! By Rayleigh's principle frequencies fall with every mode that is added, the highest ones most. A vibration is found again in the
//! larger model by its shape, since others may lie between in the order of frequencies: `|psi^H M phi|^2` is the part of its
//! kinetic energy that the vibration psi of the larger model has.

use crate::analysis::modes::{Modes, modes};
use crate::analysis::refined::{all_places, with_more_modes};
use crate::error::Interrupted;
use crate::model::Model;
use crate::numerics::linalg::{Complex, Matrix};

/// Additional modes of every strain that has some; fewer for large models.
const MORE_MODES: [usize; 3] = [4, 2, 1];

/// Largest model with more modes: a tenth of a second of work, or a second if damping couples the vibrations.
const MOST_COORDINATES: usize = 200;

/// Relative change of a frequency up to which it counts as resolved.
pub const RESOLVED: f64 = 1e-2;

/// A vibration of the larger model with this part of the kinetic energy is the same one. Two of one frequency, as of a round rod, share
/// theirs at worst equally.
const SAME: f64 = 0.4;

/// One with less has nothing to do with it.
const RELATED: f64 = 0.02;

/// Frequencies below this part of the largest one are rounding: motions of a body as a whole.
const ROUNDING: f64 = 1e-6;

/// So are imaginary parts of eigenvalues below this part of their size.
const ROUNDING_OF_EIGENVALUES: f64 = 1e-9;

/// Frequencies of a model's vibrations in one with more modes.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedModes {
    /// In rad/s, in the order of those of the model.
    pub frequency: Vec<f64>,
    /// How many more modes every strain has that had some.
    pub more: usize,
}

impl RefinedModes {
    /// Whether each frequency of the model is resolved.
    pub fn resolved(&self, frequency: &[f64]) -> Vec<bool> {
        let close =
            |(refined, found): (&f64, &f64)| (found - refined).abs() <= RESOLVED * refined.max(*found);
        self.frequency.iter().zip(frequency).map(close).collect()
    }

    /// Which frequencies, in rad/s, the modes of the rods resolve, and what the others become.
    pub fn sentence(&self, frequency: &[f64]) -> String {
        /// Unresolved frequencies that are named.
        const NAMED: usize = 3;
        let hertz = |omega: f64| omega / std::f64::consts::TAU;
        let percent = 100.0 * RESOLVED;
        let (resolved, more) = (self.resolved(frequency), self.more);
        let unresolved: Vec<usize> = (0..resolved.len()).filter(|&k| !resolved[k]).collect();
        let by = format!("by more than {percent:.0} % with {more} more `modes` of every strain");
        if unresolved.is_empty() {
            return format!("No frequency changes {by}.");
        }
        let named = unresolved.iter().take(NAMED).map(|&k| {
            let (found, refined) = (hertz(frequency[k]), hertz(self.frequency[k]));
            format!("number {} of {} Hz becomes {} Hz", k + 1, significant(found), significant(refined))
        });
        let named: Vec<String> = named.collect();
        let others = unresolved.len().saturating_sub(NAMED);
        let others = if others > 0 { format!(", and so do {others} more") } else { String::new() };
        let first = unresolved[0];
        let which = match first {
            0 => "The first frequency is not resolved".to_owned(),
            1 if unresolved.len() == resolved.len() - 1 => "Only the first frequency is resolved".to_owned(),
            _ if unresolved.len() == resolved.len() - first => {
                format!("The first {first} frequencies are resolved")
            }
            // Decays, which are not judged, may be among the others.
            _ => {
                let all = resolved.len();
                return format!("Of {all} frequencies these change {by}: {}{others}.", named.join(", "));
            }
        };
        format!("{which}; the following change {by}: {}{others}.", named.join(", "))
    }
}

/// A frequency with four digits.
fn significant(hertz: f64) -> String {
    const DIGITS: f64 = 4.0;
    let before = hertz.abs().log10().floor() + 1.0;
    let after = if before.is_finite() { (DIGITS - before).clamp(0.0, 12.0) } else { 0.0 };
    format!("{hertz:.*}", after as usize)
}

/// The frequencies of the vibrations about rest at `q` with more modes, at a time and with inputs; `None` for models without modes, for
/// large ones, and where there are no vibrations. Only a function of time can fail. Allocates.
pub fn refined_modes<M: Model>(
    model: &mut M,
    q: &[f64],
    (t, u): (f64, Option<&[f64]>),
) -> Result<Option<RefinedModes>, Interrupted> {
    let finer = |more| with_more_modes(model, q, more, MOST_COORDINATES).map(|finer| (more, finer));
    let Some((more, (mut finer, at))) = MORE_MODES.into_iter().find_map(finer) else { return Ok(None) };
    let (Some(few), Some(many)) = (model.modes(), finer.modes()) else { return Ok(None) };
    if few == many {
        return Ok(None);
    }
    let places = all_places(&few, &many, &model.coordinates_between());
    if let Some(u) = u {
        finer.set_inputs(u);
    }
    finer.set_time(t)?;
    let (Ok(found), Ok(refined)) = (modes(model, q), modes(&mut finer, &at)) else { return Ok(None) };
    let overlaps = overlaps(&mut finer, &at, &places, &found, &refined);
    Ok(Some(RefinedModes {
        frequency: matched(&overlaps, [&vibrations(&found), &vibrations(&refined)]),
        more,
    }))
}

/// Parts of the kinetic energy of each vibration of a model that those of the larger model have, row by row. Of vibrations that damping
/// couples they are no shares, but small where the shapes differ, too.
fn overlaps<M: Model>(
    finer: &mut M,
    q: &[f64],
    places: &[usize],
    found: &Modes,
    refined: &Modes,
) -> Vec<Vec<f64>> {
    let (n, rest) = (q.len(), vec![0.0; q.len()]);
    let mut mass = Matrix::zeros(n, n);
    finer.weighted_tangent(q, &rest, &rest, [0.0, 0.0, 1.0], &mut mass);
    let momentum = |shape: &[Complex]| -> Vec<Complex> {
        (0..n).map(|i| shape.iter().zip(places).map(|(x, &j)| *x * mass[(i, j)]).sum()).collect()
    };
    let share = |shape: &[Complex], momentum: &[Complex]| {
        shape.iter().zip(momentum).map(|(psi, momentum)| psi.conj() * momentum).sum::<Complex>().norm_sqr()
    };
    let of_one = |shape: &[Complex]| -> Vec<f64> {
        let momentum = momentum(shape);
        refined.shapes.chunks_exact(n).map(|shape| share(shape, &momentum)).collect()
    };
    found.shapes.chunks_exact(places.len()).map(of_one).collect()
}

/// A frequency, and whether it is that of a vibration whose shape tells it from others: not rounding, and none of the many decays, fast and slow, of
/// motions that damping couples.
type Vibration = (f64, bool);

fn vibrations(modes: &Modes) -> Vec<Vibration> {
    let largest = modes.frequency.iter().copied().fold(0.0, f64::max);
    let is_vibration = |(&frequency, s): (&f64, &Complex)| {
        let decays = !modes.is_classical && s.im.abs() <= ROUNDING_OF_EIGENVALUES * frequency;
        (frequency, frequency > ROUNDING * largest && !decays)
    };
    modes.frequency.iter().zip(&modes.eigenvalues).map(is_vibration).collect()
}

/// The frequency of each vibration in the larger model: of those with much of its kinetic energy, the nearest. Vibrations that are spread over many have
/// the lowest frequencies that are left, as if sorted. What is no vibration stays.
fn matched(overlaps: &[Vec<f64>], [found, refined]: [&[Vibration]; 2]) -> Vec<f64> {
    let mut is_free: Vec<bool> = refined.iter().map(|&(_, is_vibration)| is_vibration).collect();
    let mut take = |row: &[f64], least: f64, near: Option<f64>| {
        let free = (0..row.len()).filter(|&j| is_free[j] && row[j] >= least);
        let distance = |j: usize, frequency: f64| (refined[j].0 / frequency).ln().abs();
        let taken = match near {
            Some(frequency) => {
                free.min_by(|&i, &j| distance(i, frequency).total_cmp(&distance(j, frequency)))
            }
            None => free.min(),
        };
        taken.map(|j| {
            is_free[j] = false;
            refined[j].0
        })
    };
    let mut matches: Vec<Option<f64>> = overlaps
        .iter()
        .zip(found)
        .map(|(row, &(frequency, is_vibration))| match is_vibration {
            true => take(row, SAME, Some(frequency)),
            false => Some(frequency),
        })
        .collect();
    for (row, found) in overlaps.iter().zip(&mut matches) {
        if found.is_none() {
            *found = take(row, RELATED, None).or_else(|| take(row, 0.0, None));
        }
    }
    matches.into_iter().map(|found| found.unwrap_or(f64::NAN)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vibrations_are_found_by_their_shapes_and_spread_ones_in_order() {
        // The second of the larger model lies between; the third of the smaller one is spread.
        let overlaps = [
            vec![0.99, 0.0, 0.01, 0.0, 0.0],
            vec![0.0, 0.01, 0.95, 0.04, 0.0],
            vec![0.0, 0.2, 0.05, 0.35, 0.3],
        ];
        let all =
            |frequencies: &[f64]| -> Vec<Vibration> { frequencies.iter().map(|&f| (f, true)).collect() };
        let of = |overlaps: &[Vec<f64>], found: &[f64], refined: &[f64]| {
            matched(overlaps, [&all(found), &all(refined)])
        };
        assert_eq!(of(&overlaps, &[1.0, 3.1, 6.0], &[1.0, 2.0, 3.0, 4.0, 5.0]), [1.0, 3.0, 2.0]);
        // A pair of one frequency, whose planes are turned.
        let pair = [vec![0.5, 0.5], vec![0.5, 0.5]];
        assert_eq!(of(&pair, &[7.1, 7.1], &[7.0, 7.0]), [7.0, 7.0]);
        // Of one shape the nearest.
        let twins = [vec![0.9, 0.0, 0.95], vec![0.95, 0.0, 0.9]];
        assert_eq!(of(&twins, &[8.2, 180.0], &[8.3, 20.0, 228.0]), [8.3, 228.0]);
        // A free body: what is rounding has no shape of its own.
        let free = [vec![0.3, 0.3, 0.0], vec![0.3, 0.3, 0.0], vec![0.0, 0.0, 1.0]];
        let found = [(0.0, false), (1e-11, false), (6.5, true)];
        let refined = [(2e-10, false), (3e-10, false), (6.4, true)];
        assert_eq!(matched(&free, [&found, &refined]), [0.0, 1e-11, 6.4]);
    }

    #[test]
    fn sentences_name_what_changes() {
        let tau = std::f64::consts::TAU;
        let found = [1.0, 6.3, 17.6, 60.0].map(|hertz| tau * hertz);
        let refined =
            |hertz: [f64; 4]| RefinedModes { frequency: hertz.map(|hertz| tau * hertz).to_vec(), more: 4 };
        assert_eq!(
            refined([1.0, 6.3, 17.6, 34.5]).sentence(&found),
            "The first 3 frequencies are resolved; the following change by more than 1 % with 4 more `modes` of every strain: \
             number 4 of 60.00 Hz becomes 34.50 Hz."
        );
        assert!(
            refined([1.0, 6.3, 17.6, 59.9])
                .sentence(&found)
                .starts_with("No frequency changes by more than 1 %")
        );
        assert!(
            refined([0.5, 6.3, 17.6, 34.5])
                .sentence(&found)
                .starts_with("The first frequency is not resolved; ")
        );
        assert!(
            refined([1.0, 6.0, 15.0, 34.5])
                .sentence(&found)
                .starts_with("Only the first frequency is resolved; ")
        );
    }
}
