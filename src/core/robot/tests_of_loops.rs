//! Derivatives of closed loops, compared with finite differences.

use super::description::{Link, Robot};
use super::model::RobotModel;
use crate::description::body::Body;
use crate::description::joint::{Joint, JointForces};
use crate::description::rod::Segment;
use crate::description::signal::{Harmonic, Signal};
use crate::description::world::base_motion::{BaseMotion, BaseRotation};
use crate::model::{Dynamics as _, InTime as _, Tied as _};
use crate::numerics::linalg::Matrix;
use crate::robot::effects::actuator::{Actuator, Along, Drive, Part, Tendon, Via};
use crate::robot::effects::loops::{Loop, LoopEnd, Tie};

/// Two rods and a body, with loops of every kind between them and the world, none of them closed.
fn robot() -> Robot {
    let rod =
        |length| Segment { modes: [1, 2, 2, 1, 1, 1], ..Segment::straight(length, 0.01, 1e6, 4e5, 1000.0) };
    let hinge = Joint::Revolute { axis: [1.0, 2.0, 3.0], forces: JointForces::default() };
    let body = Body {
        centre: [0.05, 0.01, -0.02],
        inertia: [[2e-3, 0.0, 0.0], [0.0, 3e-3, 0.0], [0.0, 0.0, 2.5e-3]],
        ..Body::point(0.3)
    };
    let links = vec![
        Link {
            rod: vec![rod(0.5)],
            joint: Joint::Spherical,
            orientation: [0.6, 0.0, 0.8, 0.0],
            ..Link::new("arm")
        },
        Link { rod: vec![rod(0.4)], parent: Some(0), at: Some(0.2), joint: hinge, ..Link::new("leg") },
        Link { body: Some(body), position: [0.2, 0.1, 0.0], joint: Joint::Free, ..Link::new("block") },
    ];
    let end = |link, at, a: f64| LoopEnd {
        link,
        at,
        position: [0.1 * a.sin(), -0.07, 0.05 * a],
        orientation: {
            let half = 0.4 * a;
            [half.cos(), 0.0, half.sin() * 0.6, half.sin() * 0.8]
        },
    };
    let axis = [0.3, 1.0, 0.5];
    let joints = [
        Joint::Weld,
        Joint::Revolute { axis, forces: JointForces::default() },
        Joint::Prismatic { axis, forces: JointForces::default() },
        Joint::Cylindrical { axis },
        Joint::Universal { axes: [[1.0, 0.0, 0.2], [0.0, 1.0, 1.0]] },
        Joint::Planar { normal: axis },
        Joint::Spherical,
    ];
    let places = [(Some(0), Some(0.35)), (Some(1), None), (Some(2), None), (None, None)];
    let ends = |i: usize| {
        let [first, second] = [places[i % 4], places[(i + 1 + i / 4) % 4]];
        [end(first.0, first.1, i as f64), end(second.0, second.1, 0.7 * i as f64 + 1.0)]
    };
    let mut ties: Vec<Tie> =
        joints.into_iter().enumerate().map(|(i, joint)| Tie::Joint { ends: ends(i), joint }).collect();
    ties.push(Tie::Distance { ends: ends(1), length: 0.3 });
    ties.push(Tie::Coordinates { coordinates: [3, 11], ratio: 0.7, offset: 0.1 });
    let loops = ties.into_iter().enumerate().map(|(i, tie)| Loop { name: format!("{i}"), tie }).collect();
    Robot { loops, actuators: tendons(), ..Robot::new(links) }
}

/// Two inextensible tendons, longer than their commanded lengths: along both rods and straight between them,
/// and from the body to the world.
fn tendons() -> Vec<Actuator> {
    let along = |link, length| {
        Part::Along(Along { link, offset: [0.004.into(), 0.007.into()], along: [0.1 * length, length] })
    };
    let point = |link| Part::Via(Via { link, point: [0.05, -0.02, 0.04], at: None });
    let tendon = |name: &str, path, length: f64| {
        let drive = Drive::Length { length: [length].into(), stiffness: None, damping: 0.0 };
        let (friction, friction_velocity) = (0.0, 1e-3);
        Actuator::Tendon(Tendon {
            name: name.into(),
            path,
            drive,
            friction,
            friction_velocity,
            sliding: None,
        })
    };
    vec![
        tendon("inside", vec![along(0, 0.2), along(1, 0.4), point(Some(2))], 0.01),
        tendon("beside", vec![point(Some(2)), point(None)], 0.02),
    ]
}

fn state(n: usize, phase: f64) -> Vec<f64> {
    (0..n).map(|k| 0.3 * (1.7 * k as f64 + phase).cos()).collect()
}

fn moved(q: &[f64], by: &[f64], step: f64) -> Vec<f64> {
    q.iter().zip(by).map(|(q, by)| q + step * by).collect()
}

#[test]
fn gaps_and_their_derivatives_belong_together() {
    let mut model = RobotModel::new(&robot()).unwrap();
    let (n, m) = (model.facts().n, model.facts().constraints());
    assert_eq!(m, 6 + 5 + 5 + 4 + 4 + 3 + 3 + 1 + 1 + 2);
    let [q, v, a] = [0.1, 1.3, 2.9].map(|phase| state(n, phase));
    let mut gaps = |q: &[f64]| {
        let mut gaps = vec![0.0; m];
        model.gaps(q, &mut gaps);
        gaps
    };
    let h = 1e-4;
    let at = |t: f64| -> Vec<f64> { (0..n).map(|k| q[k] + t * v[k] + 0.5 * t * t * a[k]).collect() };
    let [before, here, after] = [-h, 0.0, h].map(|t| gaps(&at(t)));
    let (mut rates, mut accelerations) = (vec![0.0; m], vec![0.0; m]);
    model.gap_rates(&q, &v, &mut rates);
    model.gap_accelerations(&q, &v, &a, &mut accelerations);
    let mut jacobian = Matrix::zeros(m, n);
    model.gap_jacobian(&q, &mut jacobian);
    for i in 0..m {
        let rate = (after[i] - before[i]) / (2.0 * h);
        let acceleration = (after[i] - 2.0 * here[i] + before[i]) / (h * h);
        let by_jacobian: f64 = (0..n).map(|k| jacobian[(i, k)] * v[k]).sum();
        assert!((rates[i] - rate).abs() < 1e-7, "{i}: {} {rate}", rates[i]);
        assert!((rates[i] - by_jacobian).abs() < 1e-13, "{i}: {} {by_jacobian}", rates[i]);
        assert!((accelerations[i] - acceleration).abs() < 1e-5, "{i}: {} {acceleration}", accelerations[i]);
    }
}

#[test]
fn multipliers_act_by_the_derivatives_of_gaps_and_their_tangent_is_symmetric() {
    let mut model = RobotModel::new(&robot()).unwrap();
    let (n, m) = (model.facts().n, model.facts().constraints());
    let [q, rest] = [state(n, 0.1), vec![0.0; n]];
    let multipliers: Vec<f64> = (0..m).map(|i| (0.9 * i as f64).sin()).collect();
    let none = vec![0.0; m];
    let mut jacobian = Matrix::zeros(m, n);
    model.gap_jacobian(&q, &mut jacobian);
    let mut force = |q: &[f64]| {
        let [mut with, mut without] = [rest.clone(), rest.clone()];
        model.set_multipliers(&multipliers);
        model.inverse_dynamics(q, &rest, &rest, &mut with);
        model.set_multipliers(&none);
        model.inverse_dynamics(q, &rest, &rest, &mut without);
        with.iter().zip(&without).map(|(with, without)| with - without).collect::<Vec<f64>>()
    };
    for (k, force) in force(&q).into_iter().enumerate() {
        let wanted: f64 = (0..m).map(|i| jacobian[(i, k)] * multipliers[i]).sum();
        assert!((force - wanted).abs() < 1e-12, "{k}: {force} {wanted}");
    }
    let h = 1e-5;
    let differences: Vec<Vec<f64>> = (0..n)
        .map(|k| {
            let unit: Vec<f64> = (0..n).map(|j| f64::from(u8::from(j == k))).collect();
            let (plus, minus) = (force(&moved(&q, &unit, h)), force(&moved(&q, &unit, -h)));
            plus.iter().zip(minus).map(|(plus, minus)| (plus - minus) / (2.0 * h)).collect()
        })
        .collect();
    let mut tangents = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
    for (tangent, multipliers) in tangents.iter_mut().zip([&multipliers, &none]) {
        model.set_multipliers(multipliers);
        model.weighted_tangent(&q, &rest, &rest, [1.0, 0.0, 0.0], tangent);
    }
    let of_multipliers = &tangents[0] - &tangents[1];
    for (k, column) in differences.iter().enumerate() {
        for (j, difference) in column.iter().enumerate() {
            let entry = of_multipliers[(j, k)];
            assert!((entry - difference).abs() < 1e-7, "{j} {k}: {entry} {difference}");
            assert!((entry - of_multipliers[(k, j)]).abs() < 1e-11, "{j} {k}: {entry}");
        }
    }
}

#[test]
fn gaps_to_a_world_that_the_base_moves_in_have_derivatives_in_time() {
    let shaken = |amplitude: [f64; 3], frequency| {
        Signal::Harmonic(Harmonic { amplitude, frequency, phase: 0.4, ..Harmonic::zero() })
    };
    let angle = Harmonic { amplitude: [0.7], rate: [0.5], frequency: 0.9, ..Harmonic::zero() };
    let rotation = BaseRotation::About { axis: [1.0, -2.0, 0.5], angle: Signal::Harmonic(angle) };
    let motion = BaseMotion { translation: shaken([0.2, 0.1, -0.3], 1.3), rotation };
    let robot = Robot { base_motion: Some(motion), ..robot() };
    let mut model = RobotModel::new(&robot).unwrap();
    let (n, m) = (model.facts().n, model.facts().constraints());
    let [q, v, a] = [0.1, 1.3, 2.9].map(|phase| state(n, phase));
    let (time, h) = (0.37, 1e-4);
    let mut at = |t: f64| {
        let mut gaps = vec![0.0; m];
        model.set_time(time + t).unwrap();
        let q: Vec<f64> = (0..n).map(|k| q[k] + t * v[k] + 0.5 * t * t * a[k]).collect();
        model.gaps(&q, &mut gaps);
        gaps
    };
    let [before, here, after] = [-h, 0.0, h].map(&mut at);
    model.set_time(time).unwrap();
    let (mut rates, mut accelerations) = (vec![0.0; m], vec![0.0; m]);
    model.gap_rates(&q, &v, &mut rates);
    model.gap_accelerations(&q, &v, &a, &mut accelerations);
    let mut jacobian = Matrix::zeros(m, n);
    model.gap_jacobian(&q, &mut jacobian);
    let mut driven = 0;
    for i in 0..m {
        let rate = (after[i] - before[i]) / (2.0 * h);
        let acceleration = (after[i] - 2.0 * here[i] + before[i]) / (h * h);
        let by_jacobian: f64 = (0..n).map(|k| jacobian[(i, k)] * v[k]).sum();
        driven += usize::from((rate - by_jacobian).abs() > 1e-3);
        assert!((rates[i] - rate).abs() < 1e-6, "{i}: {} {rate}", rates[i]);
        assert!((accelerations[i] - acceleration).abs() < 1e-4, "{i}: {} {acceleration}", accelerations[i]);
    }
    assert!(driven > 10, "{driven}");
}
