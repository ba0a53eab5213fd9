//! Detection of contacts and stops that act within a step but at neither of its ends.

use super::{Model, Radius, Static};
use crate::error::Interrupted;
use crate::numerics::hermite;

/// Energies and supplied power of a motion at a time.
#[derive(Clone, Copy, Debug)]
pub struct EnergySnapshot {
    /// Total energy, in joules.
    pub total: f64,
    /// Kinetic energy.
    pub kinetic: f64,
    /// Elastic energy, including that of overlaps.
    pub elastic: f64,
    /// The power that loads without a potential supply, in watts.
    pub supplied: f64,
}

/// Number of steps in an impact, which takes `pi / omega`, that return more than nine tenths of its energy.
pub const STEPS_OF_AN_IMPACT: f64 = 20.0;

/// An impact in a step that does not resolve it.
#[derive(Clone, Copy, Debug)]
pub struct Impact {
    /// Index of the contact in the model.
    pub contact: usize,
    /// Energy in joules that the step has lost, as far as the contact would have given it back.
    pub lost: f64,
    /// All of the energy in joules that the step has lost, what contacts and materials dissipate in it included: steps that stop rods let them
    /// dissipate what waves would have given back.
    pub whole: f64,
    /// Kinetic energy before it, in joules.
    pub kinetic: f64,
    /// Elastic energy after it, overlaps included, in joules.
    pub elastic: f64,
    /// Size in seconds of steps that resolve it.
    pub longest: f64,
}

/// How touching surfaces separate again, with steps of one size.
#[derive(Clone, Copy, Debug, Default)]
pub struct Separation {
    /// Largest number of steps until they touch again: zero if none separate, infinite if nothing presses them together.
    pub flight: f64,
    /// Duration of the shortest of these impacts, in seconds; zero if there are none.
    pub impact: f64,
    /// Highest speed of separation, in metres per second.
    pub speed: f64,
}

impl Separation {
    /// The extremes of two sets of surfaces.
    pub fn and(self, other: Self) -> Self {
        let impact = if self.impact == 0.0 || other.impact == 0.0 {
            self.impact.max(other.impact)
        } else {
            self.impact.min(other.impact)
        };
        Self { flight: self.flight.max(other.flight), impact, speed: self.speed.max(other.speed) }
    }
}

/// The test of a gain of energy over a step.
#[derive(Clone, Copy, Debug)]
pub enum GainCheck {
    /// Relative to the kinetic energy.
    Kinetic,
    /// Relative to the kinetic and elastic energy: for steps that only lose energy unless they are too long for the motion.
    Mechanical,
    /// Relative to the same, for steps that cannot be shortened: a gain of half of it is an explosion.
    Explosion,
}

/// Overlaps within a step of up to this part of the model's length may be missed.
const SHALLOW_OVERLAP: f64 = 1e-4;

/// Maximum number of shapes that are tested within a step.
const MAX_SAMPLES: usize = 256;

/// Whether surfaces of a model pass through each other along a path given by times and shapes.
pub fn have_tunnelled<'a, M: Static + ?Sized>(
    model: &mut M,
    path: impl Iterator<Item = (f64, &'a [f64])>,
    radius: Radius,
) -> Result<bool, Interrupted> {
    for (i, (t, q)) in path.enumerate() {
        model.set_time(t)?;
        if i == 0 {
            model.store_surfaces(q);
        } else if model.have_tunnelled(q, radius) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Stops are missed if a step passes them by more than this, in radians or parts of the length; far below the tolerances of methods.
const LARGEST_PASSAGE: f64 = 1e-9;

/// Number of parts of a step at whose ends stops are tested: a path to a stop and back has one extremum.
const STOP_SAMPLES: usize = 8;

/// Whether a joint passes a stop, or a tendon with a stiffness becomes taut, within a step between these times,
/// displacements and rates, and is before it at both ends: the error estimate sees only the stages of the
/// step. `memory` is any vector. Allocates.
fn have_met_stops<M: Model + ?Sized>(
    model: &mut M,
    [t, t_new]: [f64; 2],
    ends: [&[f64]; 2],
    rates: [&[f64]; 2],
    memory: &mut Vec<f64>,
) -> Result<bool, Interrupted> {
    let h = t_new - t;
    let mut samples = [const { Vec::new() }; STOP_SAMPLES + 1];
    memory.resize(ends[0].len(), 0.0);
    for (sample, beyond) in samples.iter_mut().enumerate() {
        let x = sample as f64 / STOP_SAMPLES as f64;
        // Methods continue from the end of the step, at its exact time.
        let t = if sample == STOP_SAMPLES { t_new } else { t + x * h };
        hermite::cubics(x, h, ends, rates, memory);
        model.set_time(t)?;
        model.beyond_stops(memory, beyond);
    }
    Ok((0..samples[0].len()).any(|stop| {
        let is_before = samples[0][stop].max(samples[STOP_SAMPLES][stop]) <= 0.0;
        let passes =
            |near: &[Vec<f64>]| highest([near[0][stop], near[1][stop], near[2][stop]]) > LARGEST_PASSAGE;
        is_before && samples.windows(3).any(passes)
    }))
}

/// The highest point of the parabola through three values at equal distances, between the outer ones.
fn highest([before, here, after]: [f64; 3]) -> f64 {
    let (slope, bend) = (0.5 * (after - before), 2.0 * here - before - after);
    if bend > slope.abs() { here + 0.5 * slope * slope / bend } else { before.max(after) }
}

/// Whether surfaces touch within a step between these times, displacements and rates although they do at neither end: a body that
/// is thrown against a ceiling and falls back, or grazes a corner.
///
/// The step is tested along m straight parts. The motion deviates from each by `1/m^2` of its deviation over the whole step; m makes
/// this [`SHALLOW_OVERLAP`]. `memory` is any vector, kept to save allocations.
fn have_touched<M: Model + ?Sized>(
    model: &mut M,
    [t, t_new]: [f64; 2],
    ends: [&[f64]; 2],
    rates: [&[f64]; 2],
    memory: &mut Vec<f64>,
) -> Result<bool, Interrupted> {
    let (n, h) = (ends[0].len(), t_new - t);
    memory.resize(2 * n, 0.0);
    let (q, sizes) = memory.split_at_mut(n);
    sizes.copy_from_slice(&model.facts().typical_coordinates);
    let changes = rates[0].iter().zip(rates[1]).zip(&*sizes);
    let bend = changes.map(|((leaving, coming), size)| (0.125 * h * (leaving - coming) / size).abs());
    let samples =
        (bend.fold(0.0, f64::max) / SHALLOW_OVERLAP).sqrt().ceil().clamp(2.0, MAX_SAMPLES as f64) as usize;
    let mut has_touched = false;
    model.set_time(t)?;
    model.store_surfaces(ends[0]);
    for sample in 1..=samples {
        let x = sample as f64 / samples as f64;
        hermite::cubics(x, h, ends, rates, q);
        let is_end = sample == samples;
        model.set_time(if is_end { t_new } else { t + x * h })?;
        let there = if is_end { ends[1] } else { &*q };
        // A half-space is touched first at an end of a straight path, so overlaps there suffice.
        has_touched = model.have_tunnelled(there, Radius::Touching)
            || !is_end && model.deepest_overlap(there).is_some();
        if has_touched {
            break;
        }
    }
    if !has_touched {
        return Ok(false);
    }
    for (t, q) in [(t, ends[0]), (t_new, ends[1])] {
        model.set_time(t)?;
        if model.deepest_overlap(q).is_some() {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether the model has contacts or stops that a step can miss.
pub fn may_miss<M: Model + ?Sized>(model: &M) -> bool {
    model.facts().has_contact || model.facts().has_stops
}

/// Whether surfaces pass through each other, or touch and separate, or stops are reached, within a step along these times and shapes
/// but at neither end, where the velocities are `rates`. `memory` is any vector, kept to save allocations.
pub fn have_missed<M: Model + ?Sized>(
    model: &mut M,
    path: &[(f64, &[f64])],
    rates: [&[f64]; 2],
    memory: &mut Vec<f64>,
) -> Result<bool, Interrupted> {
    let &[(t, start), .., (t_new, end)] = path else { return Ok(false) };
    let (times, ends) = ([t, t_new], [start, end]);
    if model.facts().has_stops && have_met_stops(model, times, ends, rates, memory)? {
        return Ok(true);
    }
    Ok(model.facts().has_contact
        && (have_tunnelled(model, path.iter().copied(), Radius::Smaller)?
            || have_touched(model, times, ends, rates, memory)?))
}
