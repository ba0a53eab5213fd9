//! Growing small motions about a state, `x exp(s t)` with Re s > 0: about unstable equilibria, under follower loads, and of bodies that spin
//! about their intermediate axes. Steps that are too long for s do not resolve them, and methods that damp fast motions may even suppress
//! them.

use nalgebra::DVector;

use crate::analysis::at_rest::ROUNDING;
use crate::analysis::normalised::scaled;
use crate::analysis::small_motions::{Modal, SmallMotions};
use crate::model::Static;
use crate::model::chart::rate_matrix;
use crate::numerics::linalg::{Complex, Matrix};

/// Upper bound of growing motions, relative to the length or to typical coordinates: the linearisation does not hold beyond.
pub(crate) const FARTHEST: f64 = 2.0;

/// Rounding of a state and of its forces, relative to typical coordinates.
pub(crate) const ROUNDING_OF_STATES: f64 = 2e-15;

/// Growing motions are not computed if a bound shows that they grow by less than this factor in the given time.
const LITTLE_GROWTH: f64 = 2.0;

/// Displacement for the finite difference of the motion of the tip, relative to typical coordinates.
const TIP_DISPLACEMENT: f64 = 1e-4;

/// Step in radians of fourth-order finite differences of the map from angular velocities to rates of rotation vectors: truncation and
/// rounding errors are about 1e-10.
const TURN_STEP: f64 = 1e-2;

/// A growing motion about a state.
#[derive(Clone, Debug)]
pub(crate) struct Growing {
    /// Its complex rate s, and the real part and the absolute value of that, in 1/s.
    pub(crate) value: Complex,
    pub(crate) rate: f64,
    pub(crate) speed: f64,
    /// Displacement of the coordinates at its largest, for an amplitude of one.
    pub(crate) shape: Vec<f64>,
    /// Amplitude in the state, under constant loads.
    pub(crate) size: f64,
    /// Displacement from an equilibrium, or from a steady spin, in the time of a growth by e, relative to typical coordinates.
    pub(crate) departure: f64,
    /// Weights of static forces and of displacements: the absolute value of the weighted sum is the excited amplitude.
    pub(crate) of_forces: Vec<Complex>,
    pub(crate) of_places: Vec<Complex>,
}

/// The amplitude excited by these forces or displacements.
pub(crate) fn amplitude(weights: &[Complex], values: &[f64]) -> f64 {
    weights.iter().zip(values).map(|(weight, value)| weight * value).sum::<Complex>().norm()
}

impl Growing {
    /// The larger of two displacements for an amplitude of one: of the tip, relative to the length, and of a coordinate, relative to its
    /// typical size.
    pub(crate) fn reach<M: Static>(&self, model: &mut M, q: &[f64]) -> f64 {
        let of_coordinates = self.largest(&model.facts().typical_coordinates);
        let little = TIP_DISPLACEMENT / of_coordinates;
        let moved: Vec<f64> = q.iter().zip(&self.shape).map(|(q, x)| q + x * little).collect();
        let of_tip = model.moved(q, &moved) / (little * model.facts().length);
        of_coordinates.max(if of_tip.is_finite() { of_tip } else { 0.0 })
    }

    /// Elastic stiffness of the motion over its mass, in 1/s^2.
    pub(crate) fn elastic<M: Static>(&self, model: &mut M, q: &[f64]) -> f64 {
        let n = q.len();
        let [mut stiffness, mut mass] = [(); 2].map(|()| Matrix::zeros(n, n));
        model.elastic_tangent(q, &mut stiffness);
        model.mass_matrix(q, &mut mass);
        let shape = DVector::from_column_slice(&self.shape);
        shape.dot(&(stiffness * &shape)) / shape.dot(&(mass * &shape))
    }

    fn largest(&self, sizes: &[f64]) -> f64 {
        self.shape.iter().zip(sizes).map(|(x, size)| (x / size).abs()).fold(f64::MIN_POSITIVE, f64::max)
    }

    /// Growing motions among these small motions. The columns of `shapes` are the undamped modes in coordinates, those of `momenta` their
    /// products with the mass matrix; `v` and `a` are velocities and accelerations of the state.
    pub(crate) fn of(
        modal: &Modal,
        [shapes, momenta]: [&Matrix; 2],
        sizes: &[f64],
        [v, a]: [&[f64]; 2],
    ) -> Vec<Self> {
        let along = |values: &[f64]| momenta.tr_mul(&DVector::from_column_slice(values));
        let (v, a) = (along(v), along(a));
        let Some(motions) = modal.motions() else { return Vec::new() };
        let largest = |of_modes: &DVector<f64>| {
            let changes = shapes * of_modes;
            changes.iter().zip(sizes).map(|(x, size)| (x / size).abs()).fold(0.0, f64::max)
        };
        let [departs, of_jerk] = [largest(&a), largest(&modal.change_of_accelerations([&v, &a]))];
        let growing = motions.into_iter().filter(|motion| motion.is_growing() && motion.rate.im >= 0.0);
        let found = growing.map(|motion| {
            let [of_v, of_a] = &motion.excitation;
            let sum = |weights: &[Complex], values: &DVector<f64>| -> Complex {
                weights.iter().zip(values.iter()).map(|(weight, value)| weight * value).sum()
            };
            // The sum of two conjugate motions is twice the real part of one.
            let both = if motion.rate.im > 0.0 { 2.0 } else { 1.0 };
            let amplitude = both * (sum(of_v, &v) + sum(of_a, &a)) / motion.rate;
            let displacement: Vec<Complex> = (0..shapes.nrows())
                .map(|i| motion.shape.iter().enumerate().map(|(k, x)| x * shapes[(i, k)]).sum())
                .collect();
            let part = |i: &usize| displacement[*i].norm() / sizes[*i];
            let largest = (0..sizes.len()).max_by(|i, j| part(i).total_cmp(&part(j))).unwrap_or(0);
            let turned = displacement[largest].conj() / displacement[largest].norm();
            let weights = |of_modes: &[Complex], all: &Matrix, factor: Complex| -> Vec<Complex> {
                let weight =
                    |i| of_modes.iter().enumerate().map(|(k, w)| w * all[(i, k)]).sum::<Complex>() * factor;
                (0..all.nrows()).map(weight).collect()
            };
            Self {
                value: motion.rate,
                rate: motion.rate.re,
                speed: motion.rate.norm(),
                shape: displacement.iter().map(|x| (x * turned).re).collect(),
                size: amplitude.norm(),
                departure: (departs + of_jerk / motion.rate.norm()) / motion.rate.norm_sqr(),
                of_forces: weights(of_a, shapes, both / motion.rate),
                of_places: weights(of_v, momenta, both.into()),
            }
        });
        found.collect()
    }

    /// Growing motions about a state (q, v, a) of a model without constraints, in this time. Small rotations of rotation vectors are expressed
    /// in body axes, in which a steady spin is constant. Cost without growth: two tangents and a few products of matrices.
    pub(crate) fn about<M: Static>(model: &mut M, state: [&[f64]; 3], time: f64) -> Vec<Self> {
        Self::find(model, state, time).unwrap_or_default()
    }

    fn find<M: Static>(model: &mut M, [q, v, a]: [&[f64]; 3], time: f64) -> Option<Vec<Self>> {
        let n = q.len();
        let sizes = model.facts().typical_coordinates.clone();
        let [mut mass, mut damping, mut stiffness] = [(); 3].map(|()| Matrix::zeros(n, n));
        model.mass_matrix(q, &mut mass);
        let turned = InAxesOfBodies::new(&model.facts().rotation_vectors, q, v);
        // A body in free fall is weightless. Rotations are about the nearby steady spin, whose axes do not accelerate.
        let mut steady = a.to_vec();
        for &i in &model.facts().rotation_vectors {
            let spin =
                turned.as_ref().map_or([0.0; 3], |turned| std::array::from_fn(|k| turned.steady[i + k]));
            steady[i..i + 3].copy_from_slice(&spin);
        }
        model.weighted_tangent(q, v, &steady, [0.0, 1.0, 0.0], &mut damping);
        model.weighted_tangent(q, v, &steady, [1.0, 0.0, 0.0], &mut stiffness);
        let mut matrices = [mass, damping, stiffness];
        let (mut v, mut a) = (v.to_vec(), a.to_vec());
        if let Some(turned) = &turned {
            matrices = InAxesOfBodies::of(&turned.maps, matrices);
            a = turned.accelerations(&a)?;
            v.clone_from(&turned.velocities);
        }
        let [mass, damping, stiffness] = matrices.map(|m| scaled(m, &sizes));
        if grow_little([&mass, &damping, &stiffness], time)? {
            return Some(Vec::new());
        }
        let scales: Vec<f64> =
            (0..n).map(|i| stiffness.row(i).amax().max(stiffness.column(i).amax())).collect();
        let rounding = ROUNDING * n as f64 * f64::EPSILON;
        let error = Matrix::from_fn(n, n, |i, j| rounding * (scales[i] * scales[j]).sqrt());
        let (change, basis) = (Matrix::zeros(n, n), Matrix::identity(n, n));
        let unscaled =
            |a: &Matrix, power: i32| Matrix::from_fn(n, a.ncols(), |i, k| a[(i, k)] * sizes[i].powi(power));
        let motions = SmallMotions { mass, damping, stiffness, error, change, basis, sizes: sizes.clone() };
        let modal = motions.modal()?;
        let momenta = unscaled(&(&motions.mass * &modal.shapes), -1);
        let mut shapes = unscaled(&modal.shapes, 1);
        if let Some(turned) = &turned {
            shapes = &turned.maps[0] * shapes;
        }
        let mut found = Self::of(&modal, [&shapes, &momenta], &sizes, [&v, &a]);
        found.retain(|growing| growing.rate * time > LITTLE_GROWTH.ln());
        Some(found)
    }
}

/// Whether a bound shows that all motions grow by less than a factor in this time. The bound is that of an energy, with unit masses and the
/// symmetric part of the stiffness: only the symmetric part of the damping and the skew part of the stiffness change it. `None` if the mass
/// matrix is not positive definite or a number is not finite.
fn grow_little([mass, damping, stiffness]: [&Matrix; 3], time: f64) -> Option<bool> {
    let n = mass.nrows();
    let is_finite = |a: &&Matrix| a.iter().all(|x| x.is_finite());
    if ![mass, damping, stiffness].iter().all(is_finite) {
        return None;
    }
    let factor = mass.clone().cholesky()?.l();
    let within = |a: &Matrix| {
        let half = factor.solve_lower_triangular(a)?;
        factor.solve_lower_triangular(&half.transpose()).map(|a| a.transpose())
    };
    let (k, d) = (within(stiffness)?, within(damping)?);
    let allowed = 0.5 * LITTLE_GROWTH.ln() / time;
    let supplied = ((&k - k.transpose()) * 0.5).norm();
    // The two terms of the bound: supplied / (2 sqrt(least)), and the negative of the lowest damping.
    let least = (0.5 * supplied / allowed).powi(2);
    let rounding = |a: &Matrix| ROUNDING * n as f64 * f64::EPSILON * a.norm();
    let exceeds = |a: &Matrix, least: f64| {
        let shifted = (a + a.transpose()) * 0.5 - Matrix::identity(n, n) * least;
        shifted.cholesky().is_some()
    };
    Some(exceeds(&k, least) && exceeds(&d, -allowed - rounding(&d)))
}

/// Coordinates in which rotation vectors are replaced by small rotations in body axes, in which a steady spin is constant.
struct InAxesOfBodies {
    /// The map from these velocities to rates of the coordinates, and its first two derivatives with respect to time in a steady spin.
    maps: [Matrix; 3],
    /// Velocities, and accelerations of the coordinates in a steady spin.
    velocities: Vec<f64>,
    steady: Vec<f64>,
}

impl InAxesOfBodies {
    /// For rotation vectors whose first components have these indices. `None` if no body rotates.
    fn new(first: &[usize], q: &[f64], v: &[f64]) -> Option<Self> {
        let n = q.len();
        if !first.iter().any(|&i| v[i..i + 3].iter().any(|x| *x != 0.0)) {
            return None;
        }
        let mut maps = [Matrix::identity(n, n), Matrix::zeros(n, n), Matrix::zeros(n, n)];
        let (mut velocities, mut steady) = (v.to_vec(), vec![0.0; n]);
        for &i in first {
            let vector = |values: &[f64]| -> [f64; 3] { std::array::from_fn(|k| values[i + k]) };
            let (phi, rate) = (vector(q), vector(v));
            let speed = rate.iter().map(|x| x * x).sum::<f64>().sqrt();
            let step = if speed > 0.0 { TURN_STEP / speed } else { 1.0 };
            let map = |steps: f64, second: [f64; 3]| {
                let t = steps * step;
                let rows = rate_matrix(std::array::from_fn(|k| phi[k] + t * (rate[k] + 0.5 * t * second[k])));
                Matrix::from_fn(3, 3, |row, column| rows[row][column])
            };
            let here = map(0.0, [0.0; 3]);
            let of_first = |second| {
                (map(1.0, second) - map(-1.0, second)) * (8.0 / 12.0)
                    - (map(2.0, second) - map(-2.0, second)) / 12.0
            };
            let changes = of_first([0.0; 3]) / step;
            let spin = here.clone().lu().solve(&DVector::from_column_slice(&rate))?;
            let second = vector_of(&changes * &spin);
            let sums = [1.0, 2.0].map(|steps| map(steps, second) + map(-steps, second));
            let curves = (&sums[0] * 16.0 - &sums[1] - &here * 30.0) / (12.0 * step * step);
            velocities[i..i + 3].copy_from_slice(spin.as_slice());
            steady[i..i + 3].copy_from_slice(&second);
            for (all, own) in maps.iter_mut().zip([here, changes, curves]) {
                all.view_mut((i, i), (3, 3)).copy_from(&own);
            }
        }
        Some(Self { maps, velocities, steady })
    }

    /// Transforms mass, damping and stiffness matrices to these coordinates.
    fn of([turn, first, second]: &[Matrix; 3], [mass, damping, stiffness]: [Matrix; 3]) -> [Matrix; 3] {
        [
            turn.tr_mul(&(&mass * turn)),
            turn.tr_mul(&(&damping * turn + &mass * first * 2.0)),
            turn.tr_mul(&(&stiffness * turn + &damping * first + &mass * second)),
        ]
    }

    /// Transforms accelerations of the coordinates.
    fn accelerations(&self, a: &[f64]) -> Option<Vec<f64>> {
        let [turn, first, _] = &self.maps;
        let rest = DVector::from_column_slice(a) - first * DVector::from_column_slice(&self.velocities);
        turn.clone().lu().solve(&rest).map(|a| a.as_slice().to_vec())
    }
}

fn vector_of(values: DVector<f64>) -> [f64; 3] {
    std::array::from_fn(|k| values[k])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::description::body::Body;
    use crate::description::joint::Joint;
    use crate::description::rod::diagonal;
    use crate::model::Dynamics as _;
    use crate::model::pendulum::SpringPendulum;
    use crate::robot::{Link, Robot, RobotModel};

    const TIME: f64 = 1.0;

    #[test]
    fn a_pendulum_falls_from_its_upper_position() {
        let (length, mass, stiffness, gravity) = (1.0, 1.0, 100.0, 9.81);
        let mut model = SpringPendulum::new(length, mass, stiffness, gravity).unwrap();
        let short = length - mass * gravity / stiffness;
        let (size, rate) = (1e-5, (gravity / short).sqrt());
        let q = [FRAC_PI_2 + size, short - length];
        let a = [rate * rate * size, 0.0];
        let found = Growing::about(&mut model, [&q, &[0.0; 2], &a], TIME);
        assert_eq!(found.len(), 1);
        assert!((found[0].rate / rate - 1.0).abs() < 1e-6, "{}", found[0].rate);
        // Half of it grows, and half decays.
        let moved = found[0].size * found[0].shape[0].abs();
        assert!((moved / (0.5 * size) - 1.0).abs() < 1e-6, "{moved}");
        assert!(found[0].departure < 3.0 * size);
        let hangs = [-FRAC_PI_2, mass * gravity / stiffness];
        assert!(Growing::about(&mut model, [&hangs, &[0.0; 2], &[0.0; 2]], TIME).is_empty());
    }

    /// A body on a ball joint, which spins.
    fn spinning(phi: [f64; 3], spin: [f64; 3]) -> Vec<Growing> {
        let inertia = diagonal([1.0, 2.0, 3.0]);
        let body = Body { inertia, ..Body::point(1.0) };
        let link = Link { body: Some(body), joint: Joint::Spherical, ..Link::new("body") };
        let mut model = RobotModel::new(&Robot { gravity: [0.0; 3], ..Robot::new(vec![link]) }).unwrap();
        let v: Vec<f64> =
            rate_matrix(phi).iter().map(|row| row.iter().zip(spin).map(|(x, w)| x * w).sum()).collect();
        let mut a = [0.0; 3];
        let mut scratch = crate::model::ForwardScratch::new(3);
        model.forward_dynamics(&phi, &v, &mut a, &mut scratch).unwrap();
        Growing::about(&mut model, [&phi, &v, &a], TIME)
    }

    #[test]
    fn a_spin_about_the_middle_axis_grows_in_all_attitudes() {
        let rate = 50.0 / 3.0_f64.sqrt();
        let shapes =
            [[0.0; 3], [0.5, -0.3, 0.8], [1.5, 1.0, -2.0], [0.6 * PI, 0.0, 0.8 * PI], [3.0, 1e-4, -0.9]];
        for phi in shapes {
            for deviation in [0.0, 1e-6, 1e-2] {
                let found = spinning(phi, [deviation, -50.0, 0.0]);
                assert_eq!(found.len(), 1, "{phi:?} {deviation} {found:?}");
                assert!((found[0].rate / rate - 1.0).abs() < 1e-3, "{phi:?} {deviation}: {}", found[0].rate);
                assert!(found[0].departure < 3.0 * deviation + 1e-6, "{phi:?} {deviation}: {found:?}");
                let moved = found[0].size / deviation.max(1e-9);
                assert!(moved < 1.0 && (deviation == 0.0 || moved > 1e-3), "{phi:?} {deviation}: {moved}");
            }
            for axis in [0, 2] {
                let spin = std::array::from_fn(|k| if k == axis { 50.0 } else { 1e-3 });
                assert!(spinning(phi, spin).is_empty(), "{phi:?} {axis}: {:?}", spinning(phi, spin));
            }
        }
    }
}
