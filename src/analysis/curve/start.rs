//! Initial coordinates of the search from the curvature of the points.

use std::ops::Range;

use super::points::Curve;
use crate::analysis::reach;
use crate::analysis::reach::{Target, reach};
use crate::analysis::statics::Monitor;
use crate::description::rod::{STRAINS, Segment, piece};
use crate::error::{Interrupted, InvalidInput};
use crate::numerics::lie::{Quaternion, Rotation, Vector};
use crate::numerics::linalg::{Cholesky, Matrix};
use crate::robot::{Link, Robot, RobotModel};

/// Strains that points without frames determine: bending about both axes, and stretch.
const DETERMINED: Range<usize> = 1..4;

/// Weight of the coordinates relative to that of the strains (Tikhonov regularisation): coordinates that the points do not determine
/// become zero.
const REGULARISATION: f64 = 1e-10;

/// Sine of the angle between directions below which they are parallel or opposite.
const NO_SINE: f64 = 1e-12;

/// Why no initial coordinates were found.
pub(super) enum NoStart {
    Input(InvalidInput),
    Interrupted,
}

impl From<InvalidInput> for NoStart {
    fn from(error: InvalidInput) -> Self {
        Self::Input(error)
    }
}

impl From<Interrupted> for NoStart {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// Points with their arc lengths and directions.
pub(super) struct Start {
    points: Vec<Vector<f64>>,
    /// Unit tangents: those of the circles through three neighbours.
    tangents: Vec<Vector<f64>>,
    /// Lengths of the arcs between the points.
    arcs: Vec<f64>,
    /// Arc lengths on the unstretched rod.
    pub(super) at: Vec<f64>,
    frames: Option<Vec<Quaternion<f64>>>,
}

impl Start {
    /// A valid curve along a rod of this length.
    pub(super) fn new(curve: &Curve, length: f64) -> Self {
        let points: Vec<Vector<f64>> = curve.points.iter().map(|&point| point.into()).collect();
        let tangents = tangents(&points);
        let arc = |i: usize| {
            let half = 0.5 * angle(tangents[i], tangents[i + 1]);
            let chord = points[i + 1] - points[i];
            chord.dot(chord).sqrt() * if half.sin() > NO_SINE { half / half.sin() } else { 1.0 }
        };
        let arcs: Vec<f64> = (0..points.len() - 1).map(arc).collect();
        let at = curve.at.clone().unwrap_or_else(|| {
            let total: f64 = arcs.iter().sum();
            let sums = arcs.iter().scan(0.0, |sum, arc| {
                *sum += arc;
                Some(*sum)
            });
            let mut at: Vec<f64> = std::iter::once(0.0).chain(sums.map(|sum| sum / total * length)).collect();
            at[points.len() - 1] = length;
            at
        });
        let frames =
            curve.frames.as_ref().map(|frames| frames.iter().map(|&rows| quaternion(rows)).collect());
        Self { points, tangents, arcs, at, frames }
    }

    /// A target for each point.
    pub(super) fn targets(&self, with_frames: bool) -> Vec<Target> {
        let target = |(i, point): (usize, &Vector<f64>)| {
            let frame = self.frames.as_ref().filter(|_| with_frames).map(|frames| rows(frames[i]));
            Target {
                at: Some(self.at[i]),
                position: Some(point.to_array()),
                orientation: frame,
                ..Target::new(0)
            }
        };
        self.points.iter().enumerate().map(target).collect()
    }

    /// Coordinates of a link attached to the world, whose rod has the curvature of the points.
    pub(super) fn coordinates(&self, link: &Link, monitor: Monitor<'_>) -> Result<Vec<f64>, NoStart> {
        let (mut q, base) = self.base(link, monitor)?;
        let frames = self.frames.clone().unwrap_or_else(|| transported(base, &self.tangents));
        let mut from = 0.0;
        for segment in &link.rod {
            q.append(&mut self.along_segment(segment, from, &frames));
            from += segment.length;
        }
        Ok(q)
    }

    /// Coordinates of the joint that turn the base of the rod along the curve, and the orientation of the base.
    fn base(&self, link: &Link, monitor: Monitor<'_>) -> Result<(Vec<f64>, Quaternion<f64>), NoStart> {
        let count = link.joint_coordinates().len();
        let still = Quaternion { w: 1.0, v: Vector::zero() };
        if count == 0 {
            return Ok((Vec::new(), still));
        }
        let axis = Vector::new(1.0, 0.0, 0.0);
        let frame = match &self.frames {
            Some(frames) => frames[0],
            None => turning(axis, self.tangents[0]),
        };
        // Without frames, the turn about the tangent is undetermined.
        let about = [if self.frames.is_some() { 1.0 } else { 0.0 }, 1.0, 1.0];
        let target = Target {
            position: Some((self.points[0] - self.tangents[0] * self.at[0]).to_array()),
            orientation: Some(rows(frame)),
            weights: [[1.0; 3], about],
            at: Some(0.0),
            ..Target::new(0)
        };
        let mut model = RobotModel::new(&Robot::new(vec![link.clone()]))?;
        let found = reach(&mut model, &[target], &reach::Options::default(), monitor)?;
        let found = found.map_err(|unfinished| unfinished.interrupted())?;
        Ok((found.q[..count].to_vec(), Quaternion::of_rotation(&found.poses[0].rotation)))
    }

    /// Coordinates of a segment that begins at this arc length, from the turns between these frames of the points.
    fn along_segment(&self, segment: &Segment, from: f64, frames: &[Quaternion<f64>]) -> Vec<f64> {
        let pieces: Vec<_> = piece::of(segment).collect();
        let part = 1.0 / pieces.len() as f64;
        let mut q = Vec::with_capacity(segment.coordinates());
        for (i, piece) in pieces.iter().enumerate() {
            let begin = i as f64 * part;
            let ends = [begin, begin + part].map(|x| from + x * segment.length);
            let samples: Vec<Sample> = self.samples(ends, frames).collect();
            for strain in 0..STRAINS {
                let is_known = self.frames.is_some() || DETERMINED.contains(&strain);
                let values = samples.iter().map(|sample| {
                    let [a, b] = sample.ends.map(|x| (x - from) / segment.length);
                    let [at_a, at_b] = [a, b].map(|x| segment.reference_strain.integral(x)[strain]);
                    let fractions = [a, b].map(|x| ((x - begin) / part).clamp(0.0, 1.0));
                    (fractions, sample.strain[strain] - (at_b - at_a) / (b - a))
                });
                let values: Vec<([f64; 2], f64)> = if is_known { values.collect() } else { Vec::new() };
                q.extend(projected(segment, piece.modes[strain], &values));
            }
        }
        q
    }

    /// Mean strains between points, of those parts that lie between these arc lengths.
    fn samples(&self, [from, to]: [f64; 2], frames: &[Quaternion<f64>]) -> impl Iterator<Item = Sample> {
        (0..self.arcs.len()).filter_map(move |i| {
            let (a, b) = (self.at[i], self.at[i + 1]);
            let ends = [a.max(from), b.min(to)];
            if ends[1] <= ends[0] {
                return None;
            }
            let turn = inverse(frames[i]).times(frames[i + 1]).log();
            let middle = frames[i].times(Quaternion::exp(turn * 0.5));
            let chord = self.points[i + 1] - self.points[i];
            let along = chord * (self.arcs[i] / chord.dot(chord).sqrt() / (b - a));
            let Vector { x, y, z } = middle.rotation().apply_transposed(along);
            let stretch = if self.frames.is_some() { [x, y, z] } else { [self.arcs[i] / (b - a), 0.0, 0.0] };
            let bend = (turn * (1.0 / (b - a))).to_array();
            let strain = [bend, stretch];
            Some(Sample { ends, strain: std::array::from_fn(|k| strain[k / 3][k % 3]) })
        })
    }
}

/// Mean strain between two arc lengths.
struct Sample {
    ends: [f64; 2],
    strain: [f64; STRAINS],
}

/// Indices of the coordinates of a rod that points without frames do not determine.
pub(super) fn undetermined(rod: &[Segment]) -> Vec<usize> {
    let strains = rod.iter().flat_map(piece::of).flat_map(|piece| {
        piece.modes.into_iter().enumerate().flat_map(|(strain, modes)| std::iter::repeat_n(strain, modes))
    });
    strains.enumerate().filter(|(_, strain)| !DETERMINED.contains(strain)).map(|(k, _)| k).collect()
}

/// Coordinates of a strain whose means over these parts of a piece are as given, in the sense of least squares.
fn projected(segment: &Segment, modes: usize, samples: &[([f64; 2], f64)]) -> Vec<f64> {
    let mut matrix = Matrix::zeros(modes, modes);
    let mut q = vec![0.0; modes];
    if modes == 0 || samples.is_empty() {
        return q;
    }
    let (mut at_a, mut at_b) = (vec![0.0; modes], vec![0.0; modes]);
    for &([a, b], value) in samples {
        segment.basis.integrals(a, &mut at_a);
        segment.basis.integrals(b, &mut at_b);
        let sums: Vec<f64> = at_a.iter().zip(&at_b).map(|(a, b)| b - a).collect();
        let weight = 1.0 / (b - a).max(f64::MIN_POSITIVE);
        for (i, row) in sums.iter().enumerate() {
            q[i] += row * value;
            for (j, column) in sums.iter().enumerate() {
                matrix[(i, j)] += row * column * weight;
            }
        }
    }
    let ridge = REGULARISATION * matrix.diagonal().iter().copied().fold(0.0, f64::max);
    for i in 0..modes {
        matrix[(i, i)] += ridge;
    }
    let mut factors = Cholesky::new(modes);
    if factors.factorise(&matrix).is_err() {
        return vec![0.0; modes];
    }
    factors.solve(&mut q);
    q
}

/// Unit tangents of a polyline: of the circles through three neighbours, at the ends of the nearest ones.
fn tangents(points: &[Vector<f64>]) -> Vec<Vector<f64>> {
    let chords: Vec<Vector<f64>> = points.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let last = chords.len();
    let unit = |v: Vector<f64>| v * (1.0 / v.dot(v).sqrt());
    let inner = |i: usize| {
        let [before, after] = [chords[i - 1], chords[i]];
        let [h, k] = [before, after].map(|v| v.dot(v).sqrt());
        let sum = before * (k / h) + after * (h / k);
        // Where the curve turns back there is no circle.
        if sum.dot(sum).sqrt() > NO_SINE * (h + k) { unit(sum) } else { unit(after) }
    };
    let mirrored = |inner: Vector<f64>, chord: Vector<f64>| {
        let chord = unit(chord);
        unit(chord * (2.0 * chord.dot(inner)) - inner)
    };
    let mut tangents = vec![unit(chords[0]); points.len()];
    for (i, tangent) in tangents.iter_mut().enumerate().take(last).skip(1) {
        *tangent = inner(i);
    }
    if last > 1 {
        tangents[0] = mirrored(tangents[1], chords[0]);
        tangents[last] = mirrored(tangents[last - 1], chords[last - 1]);
    }
    tangents
}

/// Frames along tangents that do not turn about them, from a base on.
fn transported(base: Quaternion<f64>, tangents: &[Vector<f64>]) -> Vec<Quaternion<f64>> {
    let first = base.rotation().apply(Vector::new(1.0, 0.0, 0.0));
    let mut frame = turning(first, tangents[0]).times(base).normalised();
    let mut frames = vec![frame];
    for pair in tangents.windows(2) {
        frame = turning(pair[0], pair[1]).times(frame).normalised();
        frames.push(frame);
    }
    frames
}

/// The smallest rotation from one unit vector to another.
fn turning(from: Vector<f64>, to: Vector<f64>) -> Quaternion<f64> {
    let across = from.cross(to);
    let sine = across.dot(across).sqrt();
    let angle = sine.atan2(from.dot(to));
    if sine > NO_SINE {
        return Quaternion::exp(across * (angle / sine));
    }
    if from.dot(to) > 0.0 {
        return Quaternion { w: 1.0, v: Vector::zero() };
    }
    // Half a turn about any axis across.
    let other = if from.x.abs() < 0.9 { Vector::new(1.0, 0.0, 0.0) } else { Vector::new(0.0, 0.0, 1.0) };
    let axis = from.cross(other);
    Quaternion::exp(axis * (std::f64::consts::PI / axis.dot(axis).sqrt()))
}

fn angle(a: Vector<f64>, b: Vector<f64>) -> f64 {
    let across = a.cross(b);
    across.dot(across).sqrt().atan2(a.dot(b))
}

fn inverse(Quaternion { w, v }: Quaternion<f64>) -> Quaternion<f64> {
    Quaternion { w, v: -v }
}

/// The rotation whose columns these are, given by rows.
fn quaternion(rows: [[f64; 3]; 3]) -> Quaternion<f64> {
    let [x, y, z] = [0, 1, 2].map(|j| Vector::from(rows.map(|row| row[j])));
    Quaternion::of_rotation(&Rotation { x, y, z })
}

fn rows(frame: Quaternion<f64>) -> [[f64; 3]; 3] {
    let Rotation { x, y, z } = frame.rotation();
    [[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]]
}
