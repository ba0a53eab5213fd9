//! Robots with branches.

use super::compile;
use super::description::Rod;
use super::plan::Plan;
use super::plan::tree::Weld;
use super::state::tangent::Tangent;
use super::sweeps::Sweeps;
use crate::lie::{Quaternion, Spatial, Vector};
use crate::linalg::Matrix;
use crate::load::{Extent, Load};
use crate::rod::{Section, Segment};
use crate::support::Support;
use crate::world::Fluid;

type Space = Spatial<true>;

/// A rod of four segments, with loads, a body at its tip, supports and a fluid if wanted.
fn rod(responds: bool) -> Rod {
    let segment = |modes, length| Segment {
        modes,
        retardation_time: 0.01,
        section: Section::circle([0.02, 0.015]),
        ..Segment::straight(length, 0.02, 1e6, 4e5, 1000.0)
    };
    let segments = vec![
        segment([1, 2, 0, 0, 0, 0], 0.3),
        segment([0, 0, 0, 0, 0, 0], 0.1),
        segment([0, 1, 2, 1, 0, 0], 0.2),
        segment([2, 1, 1, 0, 0, 1], 0.25),
    ];
    let dead = Load { force: [0.3, -0.2, 0.1].into(), ..Load::at_tip() };
    let loads = vec![dead.clone(), Load { extent: Extent::Along([0.05, 0.55]), ..dead }];
    let mut rod = Rod { tip_mass: 0.05, loads, ..Rod::new(segments) };
    if responds {
        rod.supports = vec![Support { at: Some(0.5), stiffness: [10.0, 5.0, 2.0], ..Support::at_tip() }];
        rod.fluid = Some(Fluid { viscous_drag: [0.1; 2], velocity: [0.5; 3], ..Fluid::ideal(900.0) });
    }
    rod
}

/// Fixes piece `p` to a station.
fn weld(plan: &mut Plan<Space>, p: usize, to: usize, turn: Vector<f64>, position: [f64; 3]) {
    let orientation = Quaternion::exp(turn);
    let joined = &mut plan.pieces[p].joined;
    joined.begin = plan.stations;
    joined.weld = Some(Weld { to, orientation, position: position.into() });
    plan.stations += 1;
}

/// The third segment on the end of the first one, turned and beside it, and the fourth one on the frame.
fn fork(responds: bool) -> Plan<Space> {
    let mut plan = compile::plan::<Space>(&rod(responds), ());
    weld(&mut plan, 2, 1, Vector { x: 0.3, y: -0.5, z: 0.9 }, [0.02, 0.01, -0.03]);
    weld(&mut plan, 3, 0, Vector { x: 0.1, y: 0.2, z: -2.0 }, [0.0, 0.1, 0.0]);
    plan.find_families();
    plan
}

fn state(n: usize) -> [Vec<f64>; 3] {
    [1.0, 2.0, 10.0].map(|size| (0..n).map(|i| size * (1.7 * i as f64 + size).cos()).collect())
}

fn forces(sweeps: &mut Sweeps<Space>, [q, qd, qdd]: &[Vec<f64>; 3]) -> Vec<f64> {
    let mut tau = vec![0.0; q.len()];
    sweeps.inverse_dynamics([q, qd, qdd], &mut tau);
    tau
}

fn largest(matrix: &Matrix) -> f64 {
    matrix.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()))
}

#[test]
fn tangents_of_branches_are_the_derivatives_of_their_forces() {
    for responds in [false, true] {
        let mut sweeps = Sweeps::new(fork(responds));
        let n = sweeps.plan().n;
        let state = state(n);
        for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.7, 0.2, 0.1]] {
            let mut tangent = Matrix::from_element(n, n, f64::NAN);
            let [q, qd, qdd] = &state;
            sweeps.weighted_tangent([q, qd, qdd], weights, Tangent::Dense(&mut tangent));
            const STEP: f64 = 1e-5;
            let differences = Matrix::from_fn(n, n, |j, k| {
                let mut at = |sign: f64| {
                    let mut state = state.clone();
                    for (part, weight) in state.iter_mut().zip(weights) {
                        part[k] += sign * STEP * weight;
                    }
                    forces(&mut sweeps, &state)[j]
                };
                (at(1.0) - at(-1.0)) / (2.0 * STEP)
            });
            let error = largest(&(&tangent - &differences));
            assert!(error < 1e-7 * largest(&differences), "{responds} {weights:?}: {error:e}");
        }
    }
}

#[test]
fn masses_of_branches_are_positive_and_nothing_couples_different_ones() {
    let mut sweeps = Sweeps::new(fork(true));
    let n = sweeps.plan().n;
    let [q, qd, qdd] = state(n);
    let mut mass = Matrix::from_element(n, n, f64::NAN);
    sweeps.mass_matrix(&q, Tangent::Dense(&mut mass));
    assert_eq!(mass, mass.transpose());
    assert!(crate::linalg::Cholesky::new(n).factorise(&mass).is_ok());
    // What it is the derivative of.
    let rest = forces(&mut sweeps, &[q.clone(), qd.clone(), vec![0.0; n]]);
    let moving = forces(&mut sweeps, &[q.clone(), qd, qdd.clone()]);
    let product = &mass * Matrix::from_column_slice(n, 1, &qdd);
    for (j, inertial) in product.iter().enumerate() {
        assert!((moving[j] - rest[j] - inertial).abs() < 1e-12 * largest(&product), "{j}");
    }
    let plan = sweeps.plan();
    let [first, third, fourth] = [0, 2, 3].map(|p| plan.pieces[p].coordinates());
    assert!(fourth.clone().all(|j| first.clone().chain(third.clone()).all(|k| mass[(j, k)] == 0.0)));
    assert!(third.clone().all(|j| first.clone().all(|k| mass[(j, k)] != 0.0)));
}

#[test]
fn a_chain_of_welds_that_move_nothing_is_the_chain() {
    for responds in [false, true] {
        let chain = compile::plan::<Space>(&rod(responds), ());
        let mut welded = chain.clone();
        for p in [1, 3] {
            weld(&mut welded, p, p, Vector::zero(), [0.0; 3]);
        }
        welded.find_families();
        assert!(welded.has_branches && !chain.has_branches);
        let n = chain.n;
        let state = state(n);
        let [q, qd, qdd] = &state;
        let results = [chain, welded].map(|plan| {
            let mut sweeps = Sweeps::new(plan);
            let (mut tangent, mut jacobian) = (Matrix::zeros(n, n), Matrix::zeros(6, n));
            sweeps.weighted_tangent([q, qd, qdd], [0.7, 0.2, 0.1], Tangent::Dense(&mut tangent));
            let place = sweeps.place(0.8);
            sweeps.jacobian(q, &place, &mut jacobian);
            let energy = sweeps.energy(q, qd).total();
            (forces(&mut sweeps, &state), tangent, jacobian, energy, sweeps.base_wrench([q, qd, qdd]))
        });
        assert_eq!(results[0], results[1]);
    }
}

#[test]
fn places_on_branches_move_as_their_jacobians_say() {
    let mut sweeps = Sweeps::new(fork(false));
    let n = sweeps.plan().n;
    let [q, qd, _] = state(n);
    for x in [0.2, 0.5, 0.8] {
        let place = sweeps.place(x);
        let mut jacobian = Matrix::zeros(6, n);
        sweeps.jacobian(&q, &place, &mut jacobian);
        let product = &jacobian * Matrix::from_column_slice(n, 1, &qd);
        let [angular, linear] = sweeps.velocity(&q, &qd, &place);
        const STEP: f64 = 1e-6;
        let mut at = |sign: f64| {
            let q: Vec<f64> = q.iter().zip(&qd).map(|(q, qd)| q + sign * STEP * qd).collect();
            sweeps.position(&q, &place)
        };
        let change = (at(1.0) - at(-1.0)) * (0.5 / STEP);
        for i in 0..3 {
            assert!((product[(i, 0)] - angular.to_array()[i]).abs() < 1e-12);
            assert!((product[(3 + i, 0)] - linear.to_array()[i]).abs() < 1e-12);
            assert!((change.to_array()[i] - linear.to_array()[i]).abs() < 1e-8);
        }
    }
}
