//! Statics in Rust, where Python's tests cannot reach. Shapes and numbers are compared in
//! tests/python/equilibria/test_statics.py.

use std::f64::consts::PI;

use lissom::error::Interrupted;
use lissom::linalg::Matrix;
use lissom::model::{Dynamics, Elastic as _};
use lissom::pendulum::SpringPendulum;
use lissom::robot::{RobotModel, Rod};
use lissom::rod::{Section, Segment};
use lissom::statics::{
    ContinuationOptions, CriticalKind, Options, Stability, Start, Status, continuation, equilibrium,
};

const RADIUS: f64 = 0.01;
const YOUNG: f64 = 1e9;

fn bending_stiffness() -> f64 {
    YOUNG * PI / 4.0 * RADIUS.powi(4)
}

fn rod(modes: [usize; 6], tip_force: [f64; 3], tip_moment: [f64; 3]) -> RobotModel {
    let segment = Segment { modes, nodes: Some(24), ..Segment::straight(1.0, RADIUS, YOUNG, 4e8, 1e3) };
    RobotModel::of_rod(&Rod { gravity: [0.0; 3], tip_force, tip_moment, ..Rod::new(vec![segment]) }).unwrap()
}

#[test]
fn a_moment_rolls_the_rod_up_in_one_step() {
    let mut model = rod([0, 1, 0, 0, 0, 0], [0.0; 3], [0.0, 2.0 * PI * bending_stiffness(), 0.0]);
    let found = equilibrium(&mut model, &Options::default(), &mut || Ok(())).unwrap().unwrap();
    assert_eq!(
        (found.status, found.verdict.map(|v| v.stability)),
        (Status::Converged, Some(Stability::Stable))
    );
    assert!((found.q[0] - 2.0 * PI).abs() < 1e-12);
    assert_eq!(found.path.load_factor, [0.0, 1.0]);
}

#[test]
fn a_column_has_its_euler_load_and_a_branch() {
    let euler = PI * PI / 4.0 * bending_stiffness();
    let mut model = rod([0, 6, 0, 0, 0, 0], [-2.0 * euler, 0.0, 0.0], [0.0; 3]);
    let options = ContinuationOptions::default();
    let straight = continuation(&mut model, &options, &mut || Ok(())).unwrap().unwrap();
    let [point] = straight.path.critical.as_slice() else { panic!("one bifurcation") };
    assert_eq!(point.kind, CriticalKind::Bifurcation);
    assert!((point.load_factor - 0.5).abs() < 1e-8);
    let options = ContinuationOptions {
        q0: Some(point.q.clone()),
        load_factor: point.load_factor,
        direction: Some(point.directions.clone()),
        ..options
    };
    let branch = continuation(&mut model, &options, &mut || Ok(())).unwrap().unwrap();
    assert_eq!(branch.status, Status::Finished);
    assert_eq!(branch.path.stability.last(), Some(&Some(Stability::Stable)));
}

#[test]
fn a_monitor_stops_every_search() {
    let mut model = rod([2, 6, 2, 0, 0, 0], [0.0, 0.0, -50.0 * bending_stiffness()], [0.0; 3]);
    for start in
        [Start::Unloaded { stops: vec![1.0] }, Start::Descent(vec![0.1; 10]), Start::Newton(vec![0.1; 10])]
    {
        let mut evaluations = 0;
        let options = Options { start, ..Options::default() };
        let found = equilibrium(&mut model, &options, &mut || {
            evaluations += 1;
            if evaluations < 3 { Ok(()) } else { Err(Interrupted) }
        });
        let kept = found.unwrap().unwrap_err().into_inner();
        assert_eq!((kept.status, kept.q.len(), kept.verdict), (Status::Interrupted, 10, None));
        assert!(kept.residual_norm.is_finite() && !kept.status.is_success());
    }
}

/// Loads and elastic forces are separated: the forces without elasticity are linear in the loads.
#[test]
fn elastic_forces_are_those_of_an_unloaded_rod() {
    let segment = Segment { modes: [2, 3, 2, 1, 1, 1], ..Segment::straight(0.7, 0.02, 1e7, 4e6, 1e3) };
    let tapered = Segment { section: Section::circle([0.02, 0.01]), ..segment.clone() };
    let free = Rod { gravity: [0.0; 3], ..Rod::new(vec![segment, tapered]) };
    let mut model = RobotModel::of_rod(&free).unwrap();
    let n = model.facts().n;
    let q: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
    let zero = vec![0.0; n];
    let (mut elastic, mut all) = (zero.clone(), zero.clone());
    model.elastic_forces(&q, &mut elastic);
    model.inverse_dynamics(&q, &zero, &zero, &mut all);
    let mut tangent = Matrix::zeros(n, n);
    model.elastic_tangent(&q, &mut tangent);
    for i in 0..n {
        assert_eq!(elastic[i], all[i]);
        let product: f64 = (0..n).map(|j| tangent[(i, j)] * q[j]).sum();
        assert!((product - elastic[i]).abs() <= 1e-13 * elastic[i].abs().max(1.0));
    }
    let mut sizes = zero;
    sizes.copy_from_slice(&model.facts().typical_coordinates);
    assert!(sizes.iter().all(|size| (size - 1.0 / 1.4).abs() < 1e-15 || *size == 1.0));
}

#[test]
fn a_pendulum_without_gravity_is_neutral() {
    let mut model = SpringPendulum::new(1.0, 1.0, 10.0, 0.0).unwrap();
    let options = Options { start: Start::Newton(vec![0.0, 0.0]), ..Options::default() };
    let found = equilibrium(&mut model, &options, &mut || Ok(())).unwrap().unwrap();
    assert_eq!(
        (found.status, found.verdict.map(|v| v.stability)),
        (Status::Converged, Some(Stability::Neutral))
    );
}
