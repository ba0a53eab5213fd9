//! Curves as points, with or without frames and arc lengths.

use crate::analysis::reach::Target;
use crate::description::rod::arc_length::is_on_rod;
use crate::error::{Checker, InvalidInput, Number};
use crate::numerics::linalg::norm;
use crate::robot::Link;

/// Points that are closer than this part of the length of the curve count as the same.
const SAME_POINT: f64 = 1e-9;

/// A curve in the axes in which the link is attached: those of its parent's section or body, or of the world, moved by
/// the link's `position` and `orientation`.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Points from base to tip, in metres.
    pub points: Vec<[f64; 3]>,
    /// Axes of the sections at the points: columns of matrices given by their rows.
    pub frames: Option<Vec<[[f64; 3]; 3]>>,
    /// Arc lengths of the points on the unstretched rod, in metres, increasing; `None` divides the rod from base to
    /// tip in proportion to the lengths of the arcs between the points.
    pub at: Option<Vec<f64>>,
}

impl Curve {
    /// Points from the base of a rod to its tip.
    pub fn new(points: Vec<[f64; 3]>) -> Self {
        Self { points, frames: None, at: None }
    }

    /// Reports every problem of a curve for a rod of this length.
    pub(super) fn check(&self, link: &Link) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        let (count, length) = (self.points.len(), link.length());
        check.require(!link.rod.is_empty(), "link", &link.name, "a link with a rod");
        check.require(count >= 2, "points", format_args!("{count} points"), "at least two, from base to tip");
        let finite = self.points.iter().enumerate().all(|(i, p)| check.finite(p, &format!("points[{i}]")));
        if finite {
            let steps = self.points.windows(2).map(|pair| distance(pair[0], pair[1]));
            let shortest = SAME_POINT * steps.clone().sum::<f64>();
            for (i, step) in steps.enumerate() {
                let expected = format!("another point than points[{i}]: leave out one of the two");
                let found = format_args!("a distance of {} from it", Number(step));
                check.require(step > shortest, &format!("points[{}]", i + 1), found, &expected);
            }
        }
        if let Some(frames) = &self.frames {
            let expected = format!("{count}, one for each point");
            check.require(frames.len() == count, "frames", frames.len(), &expected);
            for (i, &frame) in frames.iter().enumerate() {
                let target = Target { orientation: Some(frame), ..Target::new(0) };
                check.nested(&format!("frames[{i}]"), target.validate());
            }
        }
        if let Some(at) = &self.at
            && check.length(at, count, "X")
            && check.finite(at, "X")
        {
            for (i, &x) in at.iter().enumerate() {
                let expected = format!("an arc length in [0, {}] (metres)", Number(length));
                check.require(is_on_rod(x, length), &format!("X[{i}]"), Number(x), &expected);
                let before = i.checked_sub(1).map_or(f64::NEG_INFINITY, |before| at[before]);
                let expected = format!("more than X[{}], {}", i.saturating_sub(1), Number(before));
                check.require(x > before, &format!("X[{i}]"), Number(x), &expected);
            }
        }
        check.finish()
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm(&[b[0] - a[0], b[1] - a[1], b[2] - a[2]])
}
