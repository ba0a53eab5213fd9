//! Additional starts of a search: deterministic shapes that cover the range of the robot.

use std::f64::consts::PI;

use crate::description::joint::Motion;
use crate::description::rod::STRAINS;
use crate::description::rod::piece;
use crate::numerics::roots::least_squares::Bounds;
use crate::robot::{Link, Robot, Spans};

/// Largest strain other than curvature in starts: larger stretches are rare.
const LARGEST_STRAIN: f64 = 0.1;

/// Pseudo-random shapes of a robot.
pub(super) struct Starts {
    random: SplitMix,
    /// Interval from which each coordinate is drawn.
    ranges: Vec<[f64; 2]>,
}

impl Starts {
    /// Shapes around `q0`, or within the bounds if both are finite. Rods bend by up to half a turn; joints
    /// use their whole range.
    pub(super) fn new(robot: &Robot, q0: &[f64], bounds: &Bounds) -> Self {
        let reaches = reaches(robot);
        let sizes = robot.links.iter().zip(&reaches).flat_map(|(link, &reach)| sizes(link, reach));
        let ranges = sizes.enumerate().map(|(k, size)| {
            let [lower, upper] = [bounds.lower[k], bounds.upper[k]];
            if lower.is_finite() && upper.is_finite() {
                return [lower, upper];
            }
            [bounds.nearest(k, q0[k] - size), bounds.nearest(k, q0[k] + size)]
        });
        Self { random: SplitMix(0), ranges: ranges.collect() }
    }

    /// Next shape.
    pub(super) fn next(&mut self) -> Vec<f64> {
        let Self { random, ranges } = self;
        ranges.iter().map(|[lower, upper]| lower + (upper - lower) * random.next()).collect()
    }
}

/// For every link, the length of the longest chain that it is part of, in metres.
fn reaches(robot: &Robot) -> Vec<f64> {
    let spans = Spans::new(robot);
    let mut reaches: Vec<f64> = (0..robot.links.len()).map(|link| spans.of_link(link)).collect();
    for (i, link) in robot.links.iter().enumerate().rev() {
        if let Some(parent) = link.parent {
            reaches[parent] = reaches[parent].max(reaches[i]);
        }
    }
    reaches
}

/// Half-widths of the intervals for the coordinates of a link.
fn sizes(link: &Link, reach: f64) -> Vec<f64> {
    let mut sizes = Vec::with_capacity(link.coordinates());
    let motions = link.driven.is_none().then(|| link.joint.motions());
    for motion in motions.into_iter().flatten() {
        match motion {
            Motion::About(_) | Motion::Screw(..) => sizes.push(PI),
            Motion::Along(_) => sizes.push(reach),
            // The cube inscribed in the ball of all rotation vectors.
            Motion::AboutAll => sizes.extend([PI / 3.0_f64.sqrt(); 3]),
        }
    }
    for part in link.rod.iter().flat_map(piece::of) {
        for strain in 0..STRAINS {
            let size = if strain < 3 { PI / link.length() } else { LARGEST_STRAIN };
            sizes.extend((0..part.modes[strain]).map(|k| size / (k + 1) as f64));
        }
    }
    sizes
}

/// Pseudo-random numbers (Steele, Lea and Flood 2014, SplitMix64).
struct SplitMix(u64);

impl SplitMix {
    /// In [0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}
