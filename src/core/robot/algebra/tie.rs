//! Scalar constraints between two frames: their values, the wrenches of unit multipliers, and the changes of
//! these wrenches with the motion of the frames. With the wrench `(c; e)` on the second frame about its
//! origin, and the opposite wrench on the first frame, all other quantities follow:
//!
//! ```text
//! dg/dt   = c . (w2 - w1) + e . (v2 - v1 - w1 x d),   d = p2 - p1
//! d2g/dt2 = c . (w2' - w1') + e . (v2' - v1' - w1' x d - w1 x (v2 - v1)) + c' . (w2 - w1) + e' . (v2 - v1 - w1 x d)
//! ```

use crate::numerics::lie::{Rotation, Vector};

/// A frame in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) position: Vector<f64>,
    pub(crate) axes: Rotation<f64>,
}

/// Velocity or acceleration of a frame: angular, and of its origin.
pub(crate) type Motion<T = f64> = [Vector<T>; 2];

/// A scalar constraint between two frames.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Row {
    /// The second origin has no displacement along a direction of the first frame: `n1 . d = 0`.
    Across(Vector<f64>),
    /// The angle between directions of both frames is constant: `n1 . n2 = cosine`.
    Angle { first: Vector<f64>, second: Vector<f64>, cosine: f64 },
    /// The distance of the origins is constant: `|d| = length`.
    Distance(f64),
}

/// Origins closer than this, in metres, have no direction from one to the other.
const SHORTEST: f64 = 1e-14;

/// Direction from the first origin to the second, and the reciprocal of their distance; both zero if there is
/// none.
fn direction([first, second]: &[Frame; 2]) -> (Vector<f64>, f64) {
    let way = second.position - first.position;
    let length = way.dot(way).sqrt();
    let inverse = if length > SHORTEST { length.recip() } else { 0.0 };
    (way * inverse, inverse)
}

impl Row {
    /// g: metres, or the difference of two cosines.
    pub(crate) fn value(&self, frames: &[Frame; 2]) -> f64 {
        let [first, second] = frames;
        let way = second.position - first.position;
        match *self {
            Self::Across(e) => first.axes.apply(e).dot(way),
            Self::Angle { first: n1, second: n2, cosine } => {
                first.axes.apply(n1).dot(second.axes.apply(n2)) - cosine
            }
            Self::Distance(length) => way.dot(way).sqrt() - length,
        }
    }

    /// Moment about the second origin, and force there, of a unit multiplier on the second frame.
    pub(crate) fn wrench(&self, frames: &[Frame; 2]) -> [Vector<f64>; 2] {
        let [first, second] = frames;
        match *self {
            Self::Across(e) => [Vector::zero(), first.axes.apply(e)],
            Self::Angle { first: n1, second: n2, .. } => {
                [second.axes.apply(n2).cross(first.axes.apply(n1)), Vector::zero()]
            }
            Self::Distance(_) => [Vector::zero(), direction(frames).0],
        }
    }

    /// Change of the wrench with the motion of the frames.
    pub(crate) fn change(
        &self,
        frames: &[Frame; 2],
        [of_first, of_second]: &[Motion; 2],
    ) -> [Vector<f64>; 2] {
        let [first, second] = frames;
        match *self {
            Self::Across(e) => [Vector::zero(), of_first[0].cross(first.axes.apply(e))],
            Self::Angle { first: n1, second: n2, .. } => {
                let (n1, n2) = (first.axes.apply(n1), second.axes.apply(n2));
                let moment = of_second[0].cross(n2).cross(n1) + n2.cross(of_first[0].cross(n1));
                [moment, Vector::zero()]
            }
            Self::Distance(_) => {
                let (direction, inverse_length) = direction(frames);
                let moved = of_second[1] - of_first[1];
                [Vector::zero(), (moved - direction * direction.dot(moved)) * inverse_length]
            }
        }
    }

    /// `dg/dt`.
    pub(crate) fn rate(&self, frames: &[Frame; 2], motions: &[Motion; 2]) -> f64 {
        let [moment, force] = self.wrench(frames);
        let [turning, shifting] = relative(frames, motions);
        moment.dot(turning) + force.dot(shifting)
    }

    /// `d2g/dt2`.
    pub(crate) fn acceleration(
        &self,
        frames: &[Frame; 2],
        velocities: &[Motion; 2],
        accelerations: &[Motion; 2],
    ) -> f64 {
        let [moment, force] = self.wrench(frames);
        let [moment_rate, force_rate] = self.change(frames, velocities);
        let [turning, shifting] = relative(frames, velocities);
        let [turning_rate, mut shifting_rate] = relative(frames, accelerations);
        shifting_rate = shifting_rate - velocities[0][0].cross(velocities[1][1] - velocities[0][1]);
        moment.dot(turning_rate)
            + force.dot(shifting_rate)
            + moment_rate.dot(turning)
            + force_rate.dot(shifting)
    }
}

/// Motion of the second frame relative to the first one, in the axes of the latter.
fn relative([first, second]: &[Frame; 2], [of_first, of_second]: &[Motion; 2]) -> Motion {
    let way = second.position - first.position;
    [of_second[0] - of_first[0], of_second[1] - of_first[1] - of_first[0].cross(way)]
}
