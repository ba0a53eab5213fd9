//! Surroundings of a rod: elastic supports and a fluid, also on moving bases.

use lissom::fluid::Fluid;
use lissom::linalg::Matrix;
use lissom::load::{Frame, Load};
use lissom::model::{Dynamics, Elastic as _, ForwardScratch, InTime as _, Tree};
use lissom::robot::{Kernel, RobotModel, Rod, Solve};
use lissom::rod::{Section, Segment};
use lissom::signal::{Harmonic, Signal};
use lissom::support::Support;
use lissom::world::{BaseMotion, BaseRotation};
use proptest::prelude::*;

/// The time of all evaluations.
const TIME: f64 = 0.3;

/// The orientation of all bases at rest, and their y axis.
const ORIENTATION: [f64; 4] = [0.8, 0.2, -0.4, 0.4];
const NORMAL: [f64; 3] = [-0.8, 0.6, 0.0];

/// The model with its time set.
fn set(mut model: RobotModel) -> RobotModel {
    model.set_time(TIME).unwrap();
    model
}

/// A state of size `scale` with different values of all coordinates.
fn state(n: usize, scale: f64, phase: f64) -> Vec<f64> {
    (0..n).map(|i| scale * (1.7 * i as f64 + phase).sin()).collect()
}

fn residual(model: &mut RobotModel, state: [&[f64]; 3]) -> Vec<f64> {
    let mut tau = vec![0.0; model.facts().n];
    model.inverse_dynamics(state[0], state[1], state[2], &mut tau);
    tau
}

/// Central differences of a vector function of the state.
fn central_difference(
    state: [&[f64]; 3],
    which: usize,
    mut function: impl FnMut([&[f64]; 3]) -> Vec<f64>,
) -> Matrix {
    let n = state[0].len();
    let mut jacobian = Matrix::zeros(n, n);
    let mut shifted = state.map(<[f64]>::to_vec);
    for k in 0..n {
        let step = 1e-5 * state[which][k].abs().max(1.0);
        let [plus, minus] = [1.0, -1.0].map(|sign| {
            shifted[which][k] = state[which][k] + sign * step;
            function([&shifted[0], &shifted[1], &shifted[2]])
        });
        shifted[which][k] = state[which][k];
        for j in 0..n {
            jacobian[(j, k)] = (plus[j] - minus[j]) / (2.0 * step);
        }
    }
    jacobian
}

fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

fn assert_close(a: &[f64], b: &[f64], tolerance: f64, what: &str) {
    let scale = largest(a).max(largest(b));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= tolerance * scale, "{what} {i}: {a:e} and {b:e} of {scale:e}");
    }
}

/// Supports at the tip, inside segments and at their interfaces; displaced, rotated, damped or none of these.
fn rich_supports() -> Vec<Support> {
    vec![
        Support { stiffness: [20.0, 40.0, 0.0], rotational_stiffness: [0.1, 0.4, 0.2], ..Support::at_tip() },
        Support {
            link: 0,
            at: Some(0.25),
            stiffness: [30.0, 10.0, 50.0],
            rotational_stiffness: [0.5, 0.0, 0.1],
            damping: [0.2, 0.1, 0.3],
            rotational_damping: [0.01, 0.03, 0.02],
            position: Some([0.4, -1.9, 1.1]),
            orientation: Some([0.5, 0.5, -0.5, 0.5]),
        },
        Support { at: Some(0.4), stiffness: [5.0; 3], damping: [0.1; 3], ..Support::at_tip() },
        Support { at: Some(0.9), rotational_damping: [0.02; 3], ..Support::at_tip() },
    ]
}

/// A fluid with all effects.
fn rich_fluid() -> Fluid {
    Fluid {
        density: 800.0,
        velocity: [0.3, -0.7, 0.5],
        viscous_drag: [0.4, 0.1],
        drag_coefficients: [1.2, 0.3],
        added_mass_coefficient: 0.9,
        is_buoyant: true,
    }
}

/// A soft rod with all features.
fn rich_rod() -> Rod {
    let first = Segment {
        section: Section::circle([0.02, 0.015]),
        modes: [2, 3, 1, 1, 2, 1],
        retardation_time: 0.01,
        reference_strain: [0.3, -0.5, 0.2, 1.02, 0.01, -0.02].into(),
        ..Segment::straight(0.4, 0.02, 3e5, 1.1e5, 1100.0)
    };
    let second = Segment { modes: [1, 2, 2, 0, 0, 0], ..Segment::straight(0.7, 0.015, 2e5, 0.8e5, 900.0) };
    let third = Segment { modes: [0, 2, 0, 1, 0, 1], ..Segment::straight(0.25, 0.01, 4e5, 1.5e5, 1000.0) };
    Rod {
        base_position: [0.3, -2.0, 1.0],
        base_orientation: ORIENTATION,
        tip_force: [0.05, -0.1, 0.2],
        tip_mass: 0.05,
        supports: rich_supports(),
        fluid: Some(rich_fluid()),
        ..Rod::new(vec![first, second, third])
    }
}

/// A rod with the same features that bends in one plane only.
fn planar_rod() -> Rod {
    let mut rod = rich_rod();
    for segment in &mut rod.segments {
        segment.reference_strain = [0.0, -0.5, 0.0, 1.02, 0.0, -0.02].into();
        segment.modes = [0, 3, 0, 1, 0, 1];
    }
    rod
}

/// A motion of about one metre and one radian per second.
fn motion(amplitude: [f64; 3], axis: [f64; 3]) -> BaseMotion {
    let translation = Harmonic { amplitude, rate: amplitude, frequency: 0.4, ..Harmonic::zero() };
    let angle = Harmonic { amplitude: [0.5], rate: [0.7], frequency: 0.6, phase: 0.3, ..Harmonic::zero() };
    BaseMotion {
        translation: Signal::Harmonic(translation),
        rotation: BaseRotation::About { axis, angle: Signal::Harmonic(angle) },
    }
}

/// Rods on fixed and moving bases, with motions in and out of the plane.
fn rich_rods() -> [Rod; 4] {
    let moving = |rod: Rod, motion| Rod { base_motion: Some(motion), ..rod };
    let rods = [
        rich_rod(),
        planar_rod(),
        moving(rich_rod(), motion([0.2, -0.3, 0.1], [1.0, 0.5, -2.0])),
        moving(planar_rod(), motion([0.3, 0.4, -0.2], NORMAL)),
    ];
    let kernels = rods.each_ref().map(|rod| RobotModel::of_rod(rod).unwrap().kernel());
    assert_eq!(kernels, [Kernel::Spatial, Kernel::Planar, Kernel::Spatial, Kernel::Planar]);
    rods
}

fn assert_tangents(rod: &Rod) {
    let mut model = set(RobotModel::of_rod(rod).unwrap());
    let n = model.facts().n;
    let (q, qd, qdd) = (state(n, 0.4, 0.3), state(n, 2.0, 1.0), state(n, 10.0, 2.0));
    let state = [&q[..], &qd[..], &qdd[..]];
    for which in 0..3 {
        let mut weights = [0.0; 3];
        weights[which] = 1.0;
        let mut tangent = Matrix::zeros(n, n);
        model.weighted_tangent(&q, &qd, &qdd, weights, &mut tangent);
        let wanted = central_difference(state, which, |state| residual(&mut model, state));
        let difference = (&tangent - &wanted).amax() / wanted.amax();
        assert!(difference < 2e-8, "derivative {which}: {difference:e}");
    }
}

#[test]
fn tangents_agree_with_central_differences() {
    rich_rods().iter().for_each(assert_tangents);
}

/// The elastic forces are those of the rod and its supports, independent of loads and bodies, and have a
/// potential.
#[test]
fn elastic_forces_are_the_gradient_of_the_elastic_energy() {
    for rod in rich_rods() {
        let mut model = set(RobotModel::of_rod(&rod).unwrap());
        let n = model.facts().n;
        let (q, zero) = (state(n, 0.4, 0.3), vec![0.0; n]);
        let mut forces = vec![0.0; n];
        model.elastic_forces(&q, &mut forces);
        let wanted: Vec<f64> = (0..n)
            .map(|k| {
                let [plus, minus] = [1e-5, -1e-5].map(|step| {
                    let mut q = q.clone();
                    q[k] += step;
                    model.energy(&q, &zero).elastic
                });
                (plus - minus) / 2e-5
            })
            .collect();
        assert_close(&forces, &wanted, 1e-8, "force");
        let (mut tangent, mut tau) = (Matrix::zeros(n, n), vec![0.0; n]);
        model.elastic_tangent(&q, &mut tangent);
        // Symmetric up to the quadrature error of the rotation of the tapered, strongly bent rod.
        assert_close(tangent.as_slice(), tangent.transpose().as_slice(), 1e-6, "mirror image");
        let wanted = central_difference([&q, &zero, &zero], 0, |state| {
            model.elastic_forces(state[0], &mut tau);
            tau.clone()
        });
        assert_close(tangent.as_slice(), wanted.as_slice(), 1e-8, "tangent");
        if rod.base_motion.is_some() {
            continue;
        }
        let unloaded = Rod { gravity: [0.0; 3], tip_force: [0.0; 3], tip_mass: 0.0, fluid: None, ..rod };
        let mut unloaded = RobotModel::of_rod(&unloaded).unwrap();
        assert_eq!(forces, residual(&mut unloaded, [&q, &zero, &zero]));
    }
}

#[test]
fn power_of_the_residual_is_the_rate_of_the_energy() {
    for rod in rich_rods() {
        let mut model = set(RobotModel::of_rod(&rod).unwrap());
        let n = model.facts().n;
        let (q, qd, qdd) = (state(n, 0.3, 0.3), state(n, 1.0, 1.0), state(n, 5.0, 2.0));
        let forces = residual(&mut model, [&q, &qd, &qdd]);
        let power: f64 = forces.iter().zip(&qd).map(|(tau, v)| tau * v).sum();
        let power = power + model.supplied_power(&q, &qd, &qdd);
        let h = 1e-5;
        let [after, before] = [h, -h].map(|t| {
            let q: Vec<f64> = (0..n).map(|i| q[i] + t * qd[i] + 0.5 * t * t * qdd[i]).collect();
            let qd: Vec<f64> = (0..n).map(|i| qd[i] + t * qdd[i]).collect();
            model.set_time(TIME + t).unwrap();
            model.energy(&q, &qd).total()
        });
        let rate = (after - before) / (2.0 * h);
        model.set_time(TIME).unwrap();
        let dissipated = model.dissipated_power(&q, &qd);
        let scale = power.abs().max(rate.abs());
        assert!((power - rate - dissipated).abs() < 1e-7 * scale, "{power} {rate} {dissipated}");
    }
}

/// Asserts that two models of one rod give the same results up to rounding errors.
fn assert_same_rod(a: &mut RobotModel, b: &mut RobotModel, phase: f64) {
    let n = a.facts().n;
    let (q, qd, qdd) = (state(n, 1.0, phase), state(n, 2.0, 1.0 + phase), state(n, 10.0, 2.0));
    assert_close(&residual(a, [&q, &qd, &qdd]), &residual(b, [&q, &qd, &qdd]), 1e-12, "force");
    let [mut left, mut right] = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
    for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1e-4, 1e-2, 1.0]] {
        a.weighted_tangent(&q, &qd, &qdd, weights, &mut left);
        b.weighted_tangent(&q, &qd, &qdd, weights, &mut right);
        assert_close(left.as_slice(), right.as_slice(), 1e-12, "tangent");
    }
    a.mass_matrix(&q, &mut left);
    b.mass_matrix(&q, &mut right);
    assert_close(left.as_slice(), right.as_slice(), 1e-12, "mass matrix");
    let scalars = |model: &mut RobotModel| {
        let energy = model.energy(&q, &qd);
        let powers = [model.dissipated_power(&q, &qd), model.supplied_power(&q, &qd, &qdd)];
        [vec![energy.kinetic, energy.elastic, energy.gravitational, energy.loads], powers.to_vec()].concat()
    };
    for (i, (a, b)) in scalars(a).into_iter().zip(scalars(b)).enumerate() {
        assert!((a - b).abs() <= 1e-12 * a.abs().max(b.abs()).max(1e-3), "scalar {i}: {a:e} and {b:e}");
    }
    let [mut left, mut right] = [vec![0.0; n], vec![0.0; n]];
    a.elastic_forces(&q, &mut left);
    b.elastic_forces(&q, &mut right);
    assert_close(&left, &right, 1e-12, "elastic force");
}

fn vectors(size: f64) -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-size..size)
}

/// Random supports, with places as fractions of the rod's length.
fn supports() -> impl Strategy<Value = Vec<Support>> {
    let coefficients = |size: f64| prop_oneof![Just([0.0; 3]), prop::array::uniform3(0.0..size)];
    let support = (
        prop::option::of(0.0..1.0),
        [coefficients(100.0), coefficients(1.0), coefficients(1.0), coefficients(0.1)],
        prop::option::of(vectors(1.0)),
        prop::option::of(vectors(2.0)),
    );
    let support = support.prop_map(|(at, coefficients, position, axis)| {
        let [stiffness, rotational_stiffness, damping, rotational_damping] = coefficients;
        let orientation = axis.map(|[x, y, z]: [f64; 3]| {
            let norm = (1.0 + x * x + y * y + z * z).sqrt();
            [1.0 / norm, x / norm, y / norm, z / norm]
        });
        Support {
            link: 0,
            at,
            stiffness,
            rotational_stiffness,
            damping,
            rotational_damping,
            position,
            orientation,
        }
    });
    prop::collection::vec(support, 1..4)
}

/// Random fluids: each effect is optional.
fn fluids() -> impl Strategy<Value = Fluid> {
    let or_zero = |size: f64| prop_oneof![1 => Just(0.0), 2 => 0.0..size];
    let velocity = prop_oneof![1 => Just([0.0; 3]), 2 => vectors(1.0)];
    let drag = ([or_zero(2.0), or_zero(2.0)], [or_zero(1.5), or_zero(1.5)]);
    (or_zero(1500.0), velocity, drag, or_zero(1.5), any::<bool>()).prop_map(
        |(density, velocity, (viscous_drag, drag_coefficients), added_mass_coefficient, is_buoyant)| Fluid {
            density,
            velocity,
            viscous_drag,
            drag_coefficients,
            added_mass_coefficient,
            is_buoyant,
        },
    )
}

/// Rest, or motions in the plane, across the normal or not.
fn motions() -> impl Strategy<Value = Option<BaseMotion>> {
    let across = |[x, y, z]: [f64; 3]| {
        let [a, b, c] = NORMAL;
        [b * z - c * y, c * x - a * z, a * y - b * x]
    };
    prop_oneof![
        Just(None),
        vectors(0.5).prop_map(move |amplitude| Some(motion(across(amplitude), NORMAL))),
        vectors(0.5).prop_map(|amplitude| Some(motion(amplitude, [1.0, 0.5, -2.0]))),
    ]
}

/// Random rods, planar and spatial, with or without a fluid, with supports anywhere, on fixed or moving
/// bases.
fn rods() -> impl Strategy<Value = Rod> {
    let segment = (
        0.1..0.5,
        0.01..0.02,
        0.01..0.02,
        prop_oneof![Just(0.0), 0.001..0.1],
        prop::array::uniform6(0usize..3),
    );
    let around = (supports(), prop::option::of(fluids()), motions());
    (prop::collection::vec(segment, 1..6), any::<bool>(), around, vectors(1.0), any::<bool>()).prop_map(
        |(segments, is_planar, (mut supports, fluid, base_motion), tip_force, is_dead)| {
            let segments = segments.into_iter().map(|(length, base, tip, retardation_time, modes)| Segment {
                section: Section::circle([base, tip]),
                modes: if is_planar { [0, modes[1], 0, modes[3], 0, modes[5]] } else { modes },
                retardation_time,
                ..Segment::straight(length, base, 3e5, 1.1e5, 1000.0)
            });
            let base = Rod { base_orientation: ORIENTATION, base_motion, ..Rod::new(segments.collect()) };
            let rod = Rod { fluid, ..base };
            let length = rod.length();
            supports.iter_mut().for_each(|support| support.at = support.at.map(|x| x * length));
            let loads = vec![Load { force: tip_force.into(), frame: Frame::Body, ..Load::at_tip() }];
            if is_dead { Rod { supports, tip_force, ..rod } } else { Rod { supports, loads, ..rod } }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_planar_kernel_agrees_with_the_spatial_one(rod in rods(), phase in 0.0..6.0) {
        let [mut best, mut spatial] = [RobotModel::of_rod(&rod), RobotModel::spatial(&(&rod).into())].map(|rod| set(rod.unwrap()));
        prop_assert_eq!(spatial.kernel(), Kernel::Spatial);
        assert_same_rod(&mut best, &mut spatial, phase);
        assert_same_rod(&mut best, &mut set(RobotModel::portable(&rod).unwrap()), phase);
    }

    #[test]
    fn what_is_skipped_makes_no_difference(rod in rods(), phase in 0.0..6.0, is_bare: bool) {
        let rod = if is_bare { Rod { supports: Vec::new(), fluid: None, ..rod } } else { rod };
        let mut skipping = set(RobotModel::of_rod(&rod).unwrap());
        let mut complete = set(RobotModel::with_nothing_skipped(&(&rod).into()).unwrap());
        assert_same_rod(&mut skipping, &mut complete, phase);
        prop_assert!(skipping.multiplications().residual <= complete.multiplications().residual);
        prop_assert!(skipping.multiplications().tangent <= complete.multiplications().tangent);
    }

    #[test]
    fn tangents_are_chains(rod in rods(), phase in 0.0..6.0) {
        let mut model = set(RobotModel::with_solve(&(&rod).into(), Solve::Tree).unwrap());
        let n = model.facts().n;
        let (q, qd, qdd) = (state(n, 1.0, phase), state(n, 2.0, 1.0 + phase), state(n, 10.0, 2.0));
        let Tree { mut tangent, mut mass } = model.tree().unwrap();
        let mut dense = Matrix::zeros(n, n);
        for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1e-4, 1e-2, 1.0]] {
            model.weighted_tangent(&q, &qd, &qdd, weights, &mut dense);
            model.tree_tangent(&q, &qd, &qdd, weights, &mut tangent);
            assert_close(tangent.to_dense().as_slice(), dense.as_slice(), 1e-14, "tangent");
        }
        model.tree_mass_matrix(&q, &mut mass);
        model.mass_matrix(&q, &mut dense);
        assert_close(mass.to_dense().as_slice(), dense.as_slice(), 1e-14, "mass matrix");
        let mut qdd = vec![0.0; n];
        let mut scratch = ForwardScratch::of(&model);
        model.forward_dynamics(&q, &qd, &mut qdd, &mut scratch).unwrap();
        let scale = largest(&residual(&mut model, [&q, &qd, &vec![0.0; n]]));
        prop_assert!(largest(&residual(&mut model, [&q, &qd, &qdd])) <= 1e-9 * scale);
    }
}

#[test]
fn the_mass_matrix_has_the_added_mass() {
    for rod in [rich_rod(), planar_rod()] {
        let mut model = RobotModel::of_rod(&rod).unwrap();
        let n = model.facts().n;
        let (q, zero) = (state(n, 0.7, 0.3), vec![0.0; n]);
        let mut mass = Matrix::zeros(n, n);
        model.mass_matrix(&q, &mut mass);
        assert_eq!(mass, mass.transpose());
        let bias = residual(&mut model, [&q, &zero, &zero]);
        for k in 0..n {
            let mut unit = zero.clone();
            unit[k] = 1.0;
            let tau = residual(&mut model, [&q, &zero, &unit]);
            let column: Vec<f64> = tau.iter().zip(&bias).map(|(tau, bias)| tau - bias).collect();
            let rounding = 1e-13 * (1.0 + largest(&bias));
            for (j, entry) in column.into_iter().enumerate() {
                assert!((entry - mass[(j, k)]).abs() < rounding, "entry ({j}, {k})");
            }
        }
        // Twice the kinetic energy; larger than in vacuum.
        let qd = state(n, 1.0, 0.1);
        let kinetic = model.energy(&q, &qd).kinetic;
        let v = nalgebra::DVector::from_column_slice(&qd);
        assert!((0.5 * v.dot(&(&mass * &v)) - kinetic).abs() < 1e-13 * kinetic);
        let dry = RobotModel::of_rod(&Rod { fluid: None, ..rod }).unwrap().energy(&q, &qd).kinetic;
        assert!(kinetic > 1.01 * dry, "{kinetic} {dry}");
        assert!(mass.symmetric_eigenvalues().min() > 0.0);
    }
}

#[test]
fn a_fluid_that_makes_no_sense_is_refused() {
    let fluid = Fluid { density: -1.0, drag_coefficients: [1.0, f64::NAN], ..rich_fluid() };
    let text = RobotModel::of_rod(&Rod { fluid: Some(fluid), ..rich_rod() }).unwrap_err().to_string();
    for place in ["fluid.density", "fluid.drag_coefficients[1]"] {
        assert!(text.contains(place), "{place}: {text}");
    }
}

#[test]
fn a_support_that_makes_no_sense_is_refused() {
    let support =
        Support { at: Some(2.0), stiffness: [-1.0; 3], damping: [0.0, f64::NAN, 0.0], ..Support::at_tip() };
    let turned = Support { orientation: Some([1.0, 1.0, 0.0, 0.0]), ..Support::at_tip() };
    let rod = Rod { supports: vec![support, turned], ..rich_rod() };
    let text = RobotModel::of_rod(&rod).unwrap_err().to_string();
    for place in
        ["supports[0].at", "supports[0].stiffness", "supports[0].damping[1]", "supports[1].orientation"]
    {
        assert!(text.contains(place), "{place}: {text}");
    }
}
