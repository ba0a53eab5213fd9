//! Errors of the target poses as a function of the scaled coordinates.

use super::target::Target;
use crate::analysis::statics::Monitor;
use crate::error::Interrupted;
use crate::model::{Dynamics as _, Elastic as _, InvalidShape, rotation_vectors};
use crate::numerics::lie::{Quaternion, Rotation, Vector, rotation_vector_rate};
use crate::numerics::linalg::{Matrix, norm};
use crate::numerics::roots::NonlinearSystem;
use crate::numerics::roots::least_squares::LeastSquares;
use crate::robot::{Place, Pose, RobotModel};

/// A target prepared for comparison.
struct Goal {
    place: Place,
    point: Vector<f64>,
    position: Option<Vector<f64>>,
    /// Inverse of the target rotation.
    back: Option<Quaternion<f64>>,
    /// Weights of position and orientation, relative to the largest weight.
    weights: [Vector<f64>; 2],
    counted: [bool; 6],
    /// Inverse of the length of the chain that moves the point: a position error of one length counts as much as a radian.
    scale: f64,
}

/// Position errors are compared with at least this part of the target's distance from the origin: with the default tolerance,
/// smaller ones are rounding of positions.
const ROUNDING: f64 = 1e-6;

/// Error of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Error {
    /// Distance of the point from its target position in metres, along axes with non-zero weight; zero
    /// without a target position.
    pub position: f64,
    /// Length of the rotation vector from the target orientation in radians, about axes with non-zero weight;
    /// zero without a target orientation.
    pub orientation: f64,
}

/// Difference between the poses of links and their targets: `p - p*` along the axes of the world, and the
/// rotation vector of `R*^T R`.
pub(crate) struct Misfit<'a, 'b> {
    model: &'a mut RobotModel,
    monitor: Monitor<'b>,
    goals: Vec<Goal>,
    pub(crate) sizes: Vec<f64>,
    q: Vec<f64>,
    of_pose: Matrix,
    /// Whether all non-zero weights are replaced by one.
    alike: bool,
    /// Indices of the rotation vectors that may be replaced by shorter ones.
    rotation_vectors: Vec<usize>,
    /// Problem of the last invalid shape.
    pub(crate) invalid_shape: Option<InvalidShape>,
}

impl<'a, 'b> Misfit<'a, 'b> {
    /// Misfit of valid targets, in sizes of the coordinates at a shape. Rotation vectors without bounds may be replaced by shorter
    /// ones.
    pub(crate) fn new(
        model: &'a mut RobotModel,
        targets: &[Target],
        near: &[f64],
        rotation_vectors: Vec<usize>,
        monitor: Monitor<'b>,
    ) -> Self {
        let n = model.facts().n;
        let goal = |target: &Target| {
            let rotation = target.rotation();
            let is_counted = |i: usize| {
                let half = i / 3;
                [target.position.is_some(), rotation.is_some()][half] && target.weights[half][i % 3] > 0.0
            };
            let distance = target.position.map_or(0.0, |position| norm(&position));
            let length = model.description().span(target.link, target.point).max(ROUNDING * distance);
            Goal {
                place: model.place_on(target.link, target.at),
                point: target.point.into(),
                position: target.position.map(Vector::from),
                back: rotation.map(|Quaternion { w, v }| Quaternion { w, v: -v }),
                weights: target.weights.map(Vector::from),
                counted: std::array::from_fn(is_counted),
                scale: 1.0 / length,
            }
        };
        let mut goals: Vec<Goal> = targets.iter().map(goal).collect();
        let largest = goals.iter().flat_map(Goal::counted_weights).fold(0.0, f64::max);
        for weights in goals.iter_mut().flat_map(|goal| &mut goal.weights) {
            *weights = weights.to_array().map(|weight| weight / largest).into();
        }
        let mut sizes = vec![1.0; n];
        model.sizes(near, &mut sizes);
        Self {
            model,
            monitor,
            goals,
            sizes,
            q: vec![0.0; n],
            of_pose: Matrix::zeros(6, n),
            alike: true,
            rotation_vectors,
            invalid_shape: None,
        }
    }

    /// Indices of the rotation vectors that may be replaced by shorter ones.
    pub(crate) fn rotation_vectors(&self) -> &[usize] {
        &self.rotation_vectors
    }

    /// Replaces all non-zero weights by one, or restores the weights of the targets.
    pub(crate) fn count_alike(&mut self, alike: bool) {
        self.alike = alike;
    }

    /// Whether this replacement has no effect.
    pub(crate) fn counts_alike(&self) -> bool {
        self.least_weight() == 1.0
    }

    /// Smallest non-zero weight over the largest.
    pub(crate) fn least_weight(&self) -> f64 {
        self.goals.iter().flat_map(Goal::counted_weights).fold(1.0, f64::min)
    }

    /// Unscaled coordinates.
    pub(crate) fn coordinates(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.sizes).map(|(x, size)| x * size).collect()
    }

    fn set(&mut self, x: &[f64]) {
        for ((q, x), size) in self.q.iter_mut().zip(x).zip(&self.sizes) {
            *q = x * size;
        }
    }

    /// Differences in the shape x; NaN for invalid shapes.
    fn evaluate(&mut self, x: &[f64], residual: &mut [f64]) {
        self.set(x);
        let invalid_shape = self.model.invalid_shape(&self.q);
        if invalid_shape.is_some() {
            self.invalid_shape = invalid_shape;
            residual.fill(f64::NAN);
            return;
        }
        let mut rows = residual.iter_mut();
        for goal in &self.goals {
            let difference = goal.difference(&self.model.pose_at(&self.q, &goal.place));
            let weights = goal.weights(self.alike);
            let [position, turn] = [0, 1].map(|half| weighted(weights[half], difference[half]));
            for (value, _) in
                position.into_iter().chain(turn).zip(goal.counted).filter(|(_, is_counted)| *is_counted)
            {
                *rows.next().expect("a row for every component that counts") = value;
            }
        }
    }

    /// Norm of all weighted differences in the shape x, infinite for invalid shapes. Does not call the monitor.
    pub(crate) fn distance(&mut self, x: &[f64]) -> f64 {
        self.count_alike(false);
        let mut residual = vec![0.0; self.equations()];
        self.evaluate(x, &mut residual);
        let distance = norm(&residual);
        if distance.is_nan() { f64::INFINITY } else { distance }
    }

    /// Error of each target, and the pose of its section or body.
    pub(crate) fn errors(&mut self, q: &[f64]) -> Vec<(Error, Pose)> {
        let Self { model, goals, .. } = self;
        let error = |goal: &Goal| {
            let pose = model.pose_at(q, &goal.place);
            let counted = |half: usize, v: Vector<f64>| {
                let parts = v.to_array().into_iter().zip(&goal.counted[3 * half..]);
                // An empty sum would be -0.
                parts.filter(|(_, is_counted)| **is_counted).fold(0.0, |sum, (x, _)| sum + x * x).sqrt()
            };
            let [position, turn] = goal.difference(&pose);
            (Error { position: counted(0, position), orientation: counted(1, turn) }, pose)
        };
        goals.iter().map(error).collect()
    }
}

impl Goal {
    /// Displacement and rotation vector from the target; zero for parts without a target.
    fn difference(&self, pose: &Pose) -> [Vector<f64>; 2] {
        let point = pose.position + pose.rotation.apply(self.point);
        let position = self.position.map_or(Vector::zero(), |position| point - position);
        [position, self.turn(&pose.rotation)]
    }

    /// Non-zero weights.
    fn counted_weights(&self) -> impl Iterator<Item = f64> {
        let weights = self.weights.into_iter().flat_map(Vector::to_array).zip(self.counted);
        weights.filter(|(_, is_counted)| *is_counted).map(|(weight, _)| weight)
    }

    /// Weights of displacement and rotation vector; displacements are divided by the length of the chain that moves the point.
    fn weights(&self, alike: bool) -> [Vector<f64>; 2] {
        let [position, orientation] = if alike { [Vector::new(1.0, 1.0, 1.0); 2] } else { self.weights };
        [position * self.scale, orientation]
    }

    fn turn(&self, rotation: &Rotation<f64>) -> Vector<f64> {
        let from = |back: Quaternion<f64>| back.times(Quaternion::of_rotation(rotation)).log();
        self.back.map_or(Vector::zero(), from)
    }
}

/// Component-wise product of two vectors.
fn weighted(weights: Vector<f64>, v: Vector<f64>) -> [f64; 3] {
    [weights.x * v.x, weights.y * v.y, weights.z * v.z]
}

impl NonlinearSystem for Misfit<'_, '_> {
    fn unknowns(&self) -> usize {
        self.sizes.len()
    }

    fn equations(&self) -> usize {
        self.goals.iter().flat_map(|goal| goal.counted).filter(|is_counted| *is_counted).count()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        (self.monitor)()?;
        self.evaluate(x, residual);
        Ok(())
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        (self.monitor)()?;
        self.set(x);
        let mut row = 0;
        for goal in &self.goals {
            let pose = self.model.pose_at(&self.q, &goal.place);
            self.model.jacobian_at(&self.q, &goal.place, &mut self.of_pose);
            let arm = pose.rotation.apply(goal.point);
            let turn = goal.turn(&pose.rotation);
            let weights = goal.weights(self.alike);
            let mut rows = 0;
            for (k, size) in self.sizes.iter().enumerate() {
                let column = self.of_pose.column(k);
                let [angular, linear] = [0, 3].map(|i| Vector::new(column[i], column[i + 1], column[i + 2]));
                let point = weighted(weights[0], linear + angular.cross(arm));
                let in_body = pose.rotation.apply_transposed(angular);
                let turning = weighted(weights[1], rotation_vector_rate(turn, in_body));
                let values = point.into_iter().chain(turning).zip(goal.counted);
                rows = 0;
                for (value, _) in values.filter(|(_, is_counted)| *is_counted) {
                    jacobian[(row + rows, k)] = value * size;
                    rows += 1;
                }
            }
            row += rows;
        }
        Ok(())
    }
}

impl LeastSquares for Misfit<'_, '_> {
    fn renew(&mut self, x: &mut [f64]) {
        // Typical sizes are one in scaled coordinates.
        let mut rates = vec![0.0; x.len()];
        rotation_vectors::wrap(&self.rotation_vectors, x, &mut rates, &mut []);
    }
}
