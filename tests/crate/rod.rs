//! The Cosserat rod: tangents, mass matrix, energies, and the lab rod's published numbers.

use lissom::body::Body;
use lissom::linalg::Matrix;
use lissom::load::{Extent, Frame, Load};
use lissom::model::{Dynamics, ForwardScratch};
use lissom::robot::{Kernel, RobotModel, Rod, Solve};
use lissom::rod::{Basis, GivenSection, Profile, STRAIGHT, Section, SectionProperties, Segment, Shape};
use proptest::prelude::*;

fn lab_segment(modes: usize) -> Segment {
    Segment {
        modes: [0, modes, 0, 0, 0, 0],
        retardation_time: 1e-4,
        ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0)
    }
}

fn lab_rod(modes: usize) -> RobotModel {
    RobotModel::of_rod(&Rod::new(vec![lab_segment(modes)])).unwrap()
}

/// A soft rod with all features.
fn rich_rod() -> Rod {
    let first = Segment {
        section: Section::circle([0.02, 0.015]),
        modes: [2, 3, 1, 1, 2, 1],
        retardation_time: 0.01,
        reference_strain: [0.3, -0.5, 0.2, 1.02, 0.01, -0.02].into(),
        shear_correction: 0.9.into(),
        ..Segment::straight(0.4, 0.02, 3e5, 1.1e5, 1100.0)
    };
    let second = Segment { modes: [1, 2, 2, 0, 0, 0], ..Segment::straight(0.7, 0.015, 2e5, 0.8e5, 900.0) };
    let third = Segment {
        section: Section::circle([0.012, 0.006]),
        modes: [0, 2, 0, 1, 0, 1],
        ..Segment::straight(0.25, 0.0, 4e5, 1.5e5, 1000.0)
    };
    Rod {
        base_position: [0.3, -2.0, 1.0],
        base_orientation: [0.8, 0.2, -0.4, 0.4],
        tip_force: [0.05, -0.1, 0.2],
        tip_moment: [0.003, 0.002, -0.004],
        tip_mass: 0.05,
        loads: rich_loads(),
        bodies: rich_bodies(),
        ..Rod::new(vec![first, second, third])
    }
}

/// Loads of every kind, concentrated and distributed, inside segments and at their interfaces.
fn rich_loads() -> Vec<Load> {
    let load = |extent, frame, force: [f64; 3], moment: [f64; 3]| Load {
        link: 0,
        extent,
        frame,
        force: force.into(),
        moment: moment.into(),
    };
    vec![
        load(Extent::Tip, Frame::Body, [0.1, -0.2, 0.1], [0.004, 0.002, -0.003]),
        load(Extent::At(0.25), Frame::World, [0.2, 0.3, -0.4], [0.01, -0.02, 0.03]),
        load(Extent::At(0.25), Frame::Body, [-0.3, 0.1, 0.2], [0.02, 0.01, 0.01]),
        load(Extent::At(0.4), Frame::World, [0.1, -0.1, 0.3], [0.0; 3]),
        load(Extent::At(0.9), Frame::Body, [0.0, 0.0, 0.5], [0.0; 3]),
        load(Extent::Along([0.0, 1.35]), Frame::World, [0.1, 0.4, -0.2], [0.02, 0.0, 0.01]),
        load(Extent::Along([0.3, 1.2]), Frame::Body, [0.05, -0.3, 0.2], [0.01, 0.02, -0.01]),
    ]
}

fn rich_bodies() -> Vec<Body> {
    let inertia = [[2e-4, 1e-5, 0.0], [1e-5, 3e-4, -2e-5], [0.0, -2e-5, 4e-4]];
    let body = |at, mass| Body { link: 0, at, mass, centre: [0.02, -0.01, 0.03], inertia, hull: None };
    vec![
        body(None, 0.04),
        body(Some(0.1), 0.1),
        Body { at: Some(0.6), ..Body::point(0.03) },
        body(Some(1.1), 0.2),
    ]
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

fn central_difference(model: &mut RobotModel, state: [&[f64]; 3], which: usize) -> Matrix {
    let n = model.facts().n;
    let mut jacobian = Matrix::zeros(n, n);
    let mut shifted = state.map(<[f64]>::to_vec);
    for k in 0..n {
        let step = 1e-5 * state[which][k].abs().max(1.0);
        let [plus, minus] = [1.0, -1.0].map(|sign| {
            shifted[which][k] = state[which][k] + sign * step;
            residual(model, [&shifted[0], &shifted[1], &shifted[2]])
        });
        shifted[which][k] = state[which][k];
        for j in 0..n {
            jacobian[(j, k)] = (plus[j] - minus[j]) / (2.0 * step);
        }
    }
    jacobian
}

fn relative_difference(a: &Matrix, b: &Matrix) -> f64 {
    (a - b).amax() / b.amax()
}

#[test]
fn tangents_agree_with_central_differences() {
    let mut model = RobotModel::of_rod(&rich_rod()).unwrap();
    let n = model.facts().n;
    let (q, qd, qdd) = (state(n, 0.4, 0.3), state(n, 2.0, 1.0), state(n, 10.0, 2.0));
    let state = [&q[..], &qd[..], &qdd[..]];
    for which in 0..3 {
        let mut weights = [0.0; 3];
        weights[which] = 1.0;
        let mut tangent = Matrix::zeros(n, n);
        model.weighted_tangent(&q, &qd, &qdd, weights, &mut tangent);
        let wanted = central_difference(&mut model, state, which);
        let difference = relative_difference(&tangent, &wanted);
        assert!(difference < 2e-8, "derivative {which}: {difference:e}");
    }
}

#[test]
fn a_weighted_tangent_is_the_weighted_sum() {
    let mut model = RobotModel::of_rod(&rich_rod()).unwrap();
    let n = model.facts().n;
    let (q, qd, qdd) = (state(n, 0.4, 0.3), state(n, 2.0, 1.0), state(n, 10.0, 2.0));
    let weights = [0.7, -3.0, 0.2];
    let mut sum = Matrix::zeros(n, n);
    let mut part = Matrix::zeros(n, n);
    for which in 0..3 {
        let mut unit = [0.0; 3];
        unit[which] = 1.0;
        model.weighted_tangent(&q, &qd, &qdd, unit, &mut part);
        sum += &part * weights[which];
    }
    model.weighted_tangent(&q, &qd, &qdd, weights, &mut part);
    assert!(relative_difference(&part, &sum) < 1e-13);
}

#[test]
fn the_mass_matrix_agrees_with_the_inverse_dynamics_column_by_column() {
    let mut model = RobotModel::of_rod(&rich_rod()).unwrap();
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
        for j in 0..n {
            let column = tau[j] - bias[j];
            assert!((column - mass[(j, k)]).abs() < 1e-14 * (1.0 + bias[j].abs()), "entry ({j}, {k})");
        }
    }
    assert!(mass.clone().symmetric_eigenvalues().min() > 0.0);
}

#[test]
fn forward_dynamics_inverts_inverse_dynamics() {
    let mut model = RobotModel::of_rod(&rich_rod()).unwrap();
    let n = model.facts().n;
    let (q, qd) = (state(n, 0.4, 0.3), state(n, 2.0, 1.0));
    let mut qdd = vec![0.0; n];
    model.forward_dynamics(&q, &qd, &mut qdd, &mut ForwardScratch::new(n)).unwrap();
    let scale = residual(&mut model, [&q, &qd, &vec![0.0; n]]).iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for tau in residual(&mut model, [&q, &qd, &qdd]) {
        assert!(tau.abs() < 1e-11 * scale, "{tau} is not free motion");
    }
}

#[test]
fn power_of_the_residual_is_the_rate_of_the_energy() {
    let mut model = RobotModel::of_rod(&rich_rod()).unwrap();
    let n = model.facts().n;
    let (q, qd, qdd) = (state(n, 0.3, 0.3), state(n, 1.0, 1.0), state(n, 5.0, 2.0));
    let power: f64 = residual(&mut model, [&q, &qd, &qdd]).iter().zip(&qd).map(|(tau, v)| tau * v).sum();
    let power = power + model.supplied_power(&q, &qd, &qdd);
    let h = 1e-5;
    let moved = |model: &mut RobotModel, t: f64| {
        let q: Vec<f64> = (0..n).map(|i| q[i] + t * qd[i] + 0.5 * t * t * qdd[i]).collect();
        let qd: Vec<f64> = (0..n).map(|i| qd[i] + t * qdd[i]).collect();
        model.energy(&q, &qd).total()
    };
    let rate = (moved(&mut model, h) - moved(&mut model, -h)) / (2.0 * h);
    let dissipated = model.dissipated_power(&q, &qd);
    assert!(
        (power - rate - dissipated).abs() < 1e-7 * power.abs().max(rate.abs()),
        "{power} {rate} {dissipated}"
    );
    assert!(dissipated > 0.0);
}

/// Newton's method with the exact tangent from the straight rod, which suffices for these moderate
/// equilibria.
fn equilibrium(model: &mut RobotModel) -> Vec<f64> {
    let n = model.facts().n;
    let zero = vec![0.0; n];
    let mut q = vec![0.0; n];
    let mut tangent = Matrix::zeros(n, n);
    for _ in 0..20 {
        let tau = residual(model, [&q, &zero, &zero]);
        model.weighted_tangent(&q, &zero, &zero, [1.0, 0.0, 0.0], &mut tangent);
        let step = tangent.clone().lu().solve(&nalgebra::DVector::from_vec(tau)).unwrap();
        q.iter_mut().zip(step.iter()).for_each(|(q, step)| *q -= step);
    }
    q
}

#[test]
fn lab_rod_under_gravity() {
    let published: [&[f64]; 3] =
        [&[0.2408062382], &[0.2381234153, -0.3586538798], &[0.238212308, -0.3585635333, 0.1214608904]];
    for wanted in published {
        let mut model = lab_rod(wanted.len());
        let q = equilibrium(&mut model);
        for (q, wanted) in q.iter().zip(wanted) {
            assert!((q - wanted).abs() < 1e-9, "{q} is not {wanted}");
        }
    }
    let mut model = lab_rod(3);
    let q = equilibrium(&mut model);
    let tip = model.pose(&q, 1.0).position;
    assert!((tip.x - 0.9818006251).abs() < 1e-9 && (tip.z + 0.1775638079).abs() < 1e-9, "{tip:?}");
    assert!(tip.y.abs() < 1e-15);
}

#[test]
fn a_tip_moment_rolls_the_rod_into_a_circle_with_one_constant_mode() {
    let segment = lab_segment(1);
    let stiffness = 210e9 * std::f64::consts::PI * 1e-12 / 4.0;
    let turn = 2.0 * std::f64::consts::PI;
    let rod = Rod { gravity: [0.0; 3], tip_moment: [0.0, turn * stiffness, 0.0], ..Rod::new(vec![segment]) };
    let mut model = RobotModel::of_rod(&rod).unwrap();
    let q = equilibrium(&mut model);
    assert!((q[0] - turn).abs() < 1e-12 * turn);
    let tip = model.pose(&q, 1.0);
    assert!(tip.position.dot(tip.position).sqrt() < 1e-12, "{:?}", tip.position);
    assert!((tip.rotation.x.x - 1.0).abs() < 1e-14);
    let half = model.pose(&q, 0.5);
    assert!((half.position.z + 1.0 / std::f64::consts::PI).abs() < 1e-5, "{:?}", half.position);
}

#[test]
fn natural_frequencies_of_the_lab_rod() {
    for (modes, wanted) in [(3, [1.452225, 9.18028, 48.78]), (6, [1.451787, 9.098290, 25.48286])] {
        let segment = Segment { retardation_time: 0.0, ..lab_segment(modes) };
        let mut model = RobotModel::of_rod(&Rod { gravity: [0.0; 3], ..Rod::new(vec![segment]) }).unwrap();
        let zero = vec![0.0; modes];
        let (mut mass, mut stiffness) = (Matrix::zeros(modes, modes), Matrix::zeros(modes, modes));
        model.mass_matrix(&zero, &mut mass);
        model.weighted_tangent(&zero, &zero, &zero, [1.0, 0.0, 0.0], &mut stiffness);
        let l = mass.cholesky().unwrap().l();
        let left = l.solve_lower_triangular(&stiffness).unwrap();
        let standard = l.solve_lower_triangular(&left.transpose()).unwrap();
        let mut found: Vec<f64> = standard.symmetric_eigenvalues().iter().map(|x| x.sqrt()).collect();
        found.sort_by(f64::total_cmp);
        for (omega, wanted) in found.iter().zip(wanted) {
            let hertz = omega / (2.0 * std::f64::consts::PI);
            // One unit of the last published digit.
            let digit = if wanted == 48.78 { 5e-3 } else { 6e-6 };
            assert!((hertz - wanted).abs() < digit, "{hertz} is not {wanted}");
        }
    }
}

#[test]
fn the_same_call_gives_the_same_bits() {
    let mut model = RobotModel::of_rod(&rich_rod()).unwrap();
    let n = model.facts().n;
    let (q, qd, qdd) = (state(n, 0.4, 0.3), state(n, 2.0, 1.0), state(n, 10.0, 2.0));
    let first = residual(&mut model, [&q, &qd, &qdd]);
    residual(&mut model, [&qd, &qdd, &q]);
    assert_eq!(first, residual(&mut model, [&q, &qd, &qdd]));
    assert_eq!(first, residual(&mut RobotModel::of_rod(&rich_rod()).unwrap(), [&q, &qd, &qdd]));
}

#[test]
fn everything_wrong_with_a_rod_is_reported_at_once() {
    let mut rod = rich_rod();
    rod.segments[1].length = -1.0;
    rod.segments[2].section = Section::circle([0.012, f64::NAN]);
    rod.segments[2].shear_modulus = 1e4;
    rod.base_orientation = [0.0; 4];
    let error = RobotModel::of_rod(&rod).unwrap_err();
    let places: Vec<&str> = error.problems.iter().map(|problem| problem.place.as_str()).collect();
    assert_eq!(
        places,
        ["segments[1].length", "segments[2].radius[1]", "segments[2].shear_modulus", "base_orientation"]
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Splitting a segment with the same strain changes neither the shape nor the energy.
    #[test]
    fn a_rod_split_in_two_is_the_same_rod(
        length in 0.2..3.0f64, share in 0.1..0.9f64, kappa in prop::array::uniform3(-1.0..1.0f64),
        rate in prop::array::uniform3(-2.0..2.0f64),
    ) {
        let modes = [1, 1, 1, 0, 0, 0];
        let segment = |length| Segment { modes, ..Segment::straight(length, 0.01, 1e6, 4e5, 1000.0) };
        let mut whole = RobotModel::of_rod(&Rod::new(vec![segment(length)])).unwrap();
        let parts = vec![segment(share * length), segment((1.0 - share) * length)];
        let mut split = RobotModel::of_rod(&Rod::new(parts)).unwrap();
        let twice = |v: [f64; 3]| [v, v].concat();
        let (a, b) = (whole.pose(&kappa, length), split.pose(&twice(kappa), length));
        let difference = a.position - b.position;
        prop_assert!(difference.dot(difference).sqrt() < 1e-8 * length);
        let (e, f) = (whole.energy(&kappa, &rate), split.energy(&twice(kappa), &twice(rate)));
        for (e, f) in [(e.kinetic, f.kinetic), (e.elastic, f.elastic), (e.gravitational, f.gravitational)] {
            prop_assert!((e - f).abs() <= 1e-8 * (e.abs() + f.abs() + 1e-6), "{} {}", e, f);
        }
    }

    /// A load or a body inside a segment acts as if the segment were split there.
    #[test]
    fn loads_and_bodies_need_no_end_of_a_segment(
        x in 0.05..0.95f64, kappa in prop::array::uniform3(-1.0..1.0f64),
        rate in prop::array::uniform3(-2.0..2.0f64), (mut loads, mut bodies) in loads_and_bodies(),
    ) {
        for load in &mut loads {
            load.extent = match load.extent {
                Extent::At(_) => Extent::At(x),
                Extent::Along(_) => Extent::Along([x, 1.0]),
                Extent::Tip => Extent::Tip,
            };
        }
        bodies.iter_mut().for_each(|body| body.at = body.at.map(|_| x));
        let modes = [1, 1, 1, 0, 0, 0];
        let segment = |length| Segment { modes, ..Segment::straight(length, 0.01, 1e6, 4e5, 1000.0) };
        let rod = |segments| RobotModel::of_rod(&Rod::new(segments).with(loads.clone(), bodies.clone())).unwrap();
        let mut whole = rod(vec![segment(1.0)]);
        let mut split = rod(vec![segment(x), segment(1.0 - x)]);
        let twice = |v: [f64; 3]| [v, v].concat();
        let wanted = residual(&mut split, [&twice(kappa), &twice(rate), &twice(rate)]);
        for (i, tau) in residual(&mut whole, [&kappa, &rate, &rate]).iter().enumerate() {
            let wanted = wanted[i] + wanted[3 + i];
            prop_assert!((tau - wanted).abs() < 1e-8 * (1.0 + wanted.abs()), "{} is not {}", tau, wanted);
        }
        let powers = [
            (
                whole.supplied_power(&kappa, &rate, &rate),
                split.supplied_power(&twice(kappa), &twice(rate), &twice(rate)),
            ),
            (whole.energy(&kappa, &rate).total(), split.energy(&twice(kappa), &twice(rate)).total()),
        ];
        for (found, wanted) in powers {
            prop_assert!((found - wanted).abs() < 1e-8 * (1.0 + wanted.abs()), "{} is not {}", found, wanted);
        }
    }

    /// Rotation matrices stay orthonormal for any bending, including several full turns.
    #[test]
    fn rotations_stay_proper(q in prop::collection::vec(-60.0..60.0f64, 9), x in 0.0..1.0f64) {
        let segment = Segment { modes: [3, 3, 3, 0, 0, 0], ..Segment::straight(1.0, 0.01, 1e6, 4e5, 1000.0) };
        let mut model = RobotModel::of_rod(&Rod::new(vec![segment])).unwrap();
        let r = model.pose(&q, x).rotation;
        let axes = [r.x, r.y, r.z];
        for i in 0..3 {
            for j in 0..3 {
                let wanted = if i == j { 1.0 } else { 0.0 };
                prop_assert!((axes[i].dot(axes[j]) - wanted).abs() < 1e-14);
            }
        }
        prop_assert!((r.x.cross(r.y).dot(r.z) - 1.0).abs() < 1e-14);
    }
}

/// Random planar rods: bending about y or z, stretch and shear in the plane, taper, curved reference, any
/// base, loads in and out of the plane.
fn planar_rods() -> impl Strategy<Value = Rod> {
    let segment = (
        (0.2..2.0, 0.005..0.03, 0.005..0.03, 0.0..0.1, 0..KINDS),
        (0usize..6, 0usize..3, 0usize..3),
        (-1.0..1.0, 0.9..1.1, -0.1..0.1),
    );
    let vector = || prop::array::uniform3(-3.0..3.0);
    (
        any::<bool>(),
        prop::collection::vec(segment, 1..4),
        [vector(), vector(), vector(), vector()],
        0.0..1.0,
        loads_and_bodies(),
    )
        .prop_map(|(about_y, segments, [axis, gravity, force, moment], tip_mass, (loads, bodies))| {
            let [bend, shear] = if about_y { [1, 5] } else { [2, 4] };
            let segments = segments.into_iter().map(|(body, modes, reference)| {
                let (length, base, tip, retardation_time, kind) = body;
                let mut segment = Segment { retardation_time, ..segment_of(kind, length, [base, tip]) };
                segment.modes[bend] = modes.0;
                segment.modes[3] = modes.1;
                segment.modes[shear] = modes.2;
                let mut strain = STRAIGHT;
                (strain[bend], strain[3], strain[shear]) = reference;
                segment.reference_strain = strain.into();
                segment
            });
            let [x, y, z]: [f64; 3] = axis;
            let norm = (1.0 + x * x + y * y + z * z).sqrt();
            Rod {
                base_position: [0.5, -1.0, 2.0],
                base_orientation: [1.0 / norm, x / norm, y / norm, z / norm],
                gravity,
                tip_force: force,
                tip_moment: moment,
                tip_mass,
                ..Rod::new(segments.collect())
            }
            .with(loads, bodies)
        })
}

/// Number of kinds of [`segment_of`].
const KINDS: usize = 6;

/// A rubber segment with a section of this kind, about as thick as a circle with these radii.
fn segment_of(kind: usize, length: f64, [base, tip]: [f64; 2]) -> Segment {
    let circle = Segment {
        section: Section::circle([base, tip]),
        ..Segment::straight(length, base, 1e6, 4e5, 1000.0)
    };
    let linear = |base: f64, tip: f64| Profile::linear([[base], [tip]]);
    let shape = match kind {
        0 => return circle,
        1 => Shape::Rectangle { width: linear(base, tip), height: linear(2.0 * tip, 1.5 * base) },
        2 => Shape::Ellipse { semi_axis_y: base.into(), semi_axis_z: (1.5 * tip).into() },
        3 => Shape::HollowCircle { outer: linear(base, tip), inner: linear(0.5 * base, 0.7 * tip) },
        4 => {
            let radii = [base, 0.5 * (base + tip), 0.6 * tip, tip].map(|radius| [radius]);
            let stations = [0.0, 0.3 * length, 0.7 * length, length];
            Shape::Circle { radius: Profile::table(&stations, &radii).expect("a table") }
        }
        _ => {
            // All strains are coupled; the centre of mass lies beside the axis.
            let mut stiffness = SectionProperties::at(&circle, 0.0).stiffness;
            let size: [f64; 6] = std::array::from_fn(|i| stiffness[i][i].sqrt());
            for (i, row) in stiffness.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry += 0.1 * size[i] * size[j];
                }
            }
            let [mass, moment] = [3000.0 * base * base, 1000.0 * base.powi(4)];
            let inertia =
                [[2.0, 0.1, -0.2], [0.1, 1.0, 0.3], [-0.2, 0.3, 1.5]].map(|row| row.map(|x| moment * x));
            let given = GivenSection {
                stiffness: stiffness.into(),
                mass: mass.into(),
                inertia: inertia.into(),
                centre: [0.3 * base, -0.2 * tip].into(),
            };
            return Segment::given(length, given);
        }
    };
    Segment { section: Section::Shape(shape), ..circle }
}

/// Random rods of all kinds: each strain, taper, damping, reference curvature, load and mass is optional.
fn rods() -> impl Strategy<Value = Rod> {
    let or_zero = |range: std::ops::Range<f64>| prop_oneof![Just(0.0), range];
    let segment = (
        (0.2..2.0, 0.005..0.03, prop_oneof![Just(1.0), 0.3..1.5], or_zero(0.0..0.1), 0..KINDS),
        prop::array::uniform6(0usize..4),
        prop_oneof![Just([0.0; 6]), prop::array::uniform6(-0.3..0.3)],
    );
    let vector = |size: f64| prop_oneof![Just([0.0; 3]), prop::array::uniform3(-size..size)];
    let loads = (vector(10.0), vector(1.0), vector(0.1), or_zero(0.0..0.5));
    (prop::collection::vec(segment, 1..4), loads).prop_map(
        |(segments, (gravity, force, moment, tip_mass))| {
            let segments =
                segments.into_iter().map(|((length, radius, taper, retardation_time, kind), modes, bent)| {
                    let plain = segment_of(kind, length, [radius, taper * radius]);
                    let mut segment = Segment { modes, retardation_time, ..plain };
                    let strain: [f64; 6] = std::array::from_fn(|i| STRAIGHT[i] + bent[i]);
                    segment.reference_strain = strain.into();
                    segment
                });
            let base_orientation = [0.8, 0.2, -0.4, 0.4];
            let rod = Rod { gravity, base_orientation, tip_mass, ..Rod::new(segments.collect()) };
            Rod { tip_force: force, tip_moment: moment, ..rod }
        },
    )
}

/// Random loads and bodies, with places as fractions of the rod's length.
fn loads_and_bodies() -> impl Strategy<Value = (Vec<Load>, Vec<Body>)> {
    let vector = || prop::array::uniform3(-3.0..3.0);
    let extent = prop_oneof![
        Just(Extent::Tip),
        (0.0..1.0).prop_map(Extent::At),
        (0.0..0.5, 0.5..1.0).prop_map(|(from, to)| Extent::Along([from, to])),
    ];
    let load = (extent, any::<bool>(), vector(), vector()).prop_map(|(extent, is_dead, force, moment)| {
        let frame = if is_dead { Frame::World } else { Frame::Body };
        Load { link: 0, extent, frame, force: force.into(), moment: moment.into() }
    });
    let body = (prop::option::of(0.0..1.0), 0.0..1.0, prop::array::uniform3(-0.1..0.1)).prop_map(
        |(at, mass, centre)| {
            let inertia = [[2e-3, 1e-4, 0.0], [1e-4, 3e-3, -2e-4], [0.0, -2e-4, 4e-3]];
            Body { link: 0, at, mass, centre, inertia, hull: None }
        },
    );
    (prop::collection::vec(load, 0..4), prop::collection::vec(body, 0..3))
}

trait With {
    /// The rod with these loads and bodies, at fractions of its length.
    fn with(self, loads: Vec<Load>, bodies: Vec<Body>) -> Self;
}

impl With for Rod {
    fn with(self, mut loads: Vec<Load>, mut bodies: Vec<Body>) -> Self {
        let length = self.length();
        for load in &mut loads {
            load.extent = match load.extent {
                Extent::Tip => Extent::Tip,
                Extent::At(x) => Extent::At(x * length),
                Extent::Along(ends) => Extent::Along(ends.map(|x| x * length)),
            };
        }
        for body in &mut bodies {
            body.at = body.at.map(|x| x * length);
        }
        Self { loads, bodies, ..self }
    }
}

fn assert_equal_to_rounding(a: &[f64], b: &[f64], what: &str) {
    let largest = a.iter().chain(b).fold(0.0, |m: f64, x| m.max(x.abs()));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= 1e-12 * largest, "{what} {i}: {a:e} and {b:e}");
    }
}

/// Asserts that two models of one rod give the same results up to rounding errors.
fn assert_same_rod(rod: &Rod, a: &mut RobotModel, b: &mut RobotModel, phase: f64) {
    assert_eq!(a.nodes(), b.nodes());
    let n = a.facts().n;
    let (q, qd, qdd) = (state(n, 1.0, phase), state(n, 2.0, 1.0 + phase), state(n, 10.0, 2.0));
    assert_equal_to_rounding(&residual(a, [&q, &qd, &qdd]), &residual(b, [&q, &qd, &qdd]), "force");
    let [mut left, mut right] = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
    for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1e-4, 1e-2, 1.0]] {
        a.weighted_tangent(&q, &qd, &qdd, weights, &mut left);
        b.weighted_tangent(&q, &qd, &qdd, weights, &mut right);
        assert_equal_to_rounding(left.as_slice(), right.as_slice(), "tangent");
    }
    a.mass_matrix(&q, &mut left);
    b.mass_matrix(&q, &mut right);
    assert_equal_to_rounding(left.as_slice(), right.as_slice(), "mass matrix");
    let energies = |model: &mut RobotModel| {
        let energy = model.energy(&q, &qd);
        [energy.kinetic, energy.elastic, energy.gravitational, energy.loads]
    };
    assert_equal_to_rounding(&energies(a), &energies(b), "energy");
    let power = |model: &mut RobotModel| [model.dissipated_power(&q, &qd)];
    assert_equal_to_rounding(&power(a), &power(b), "dissipated power");
    for x in [0.0, 0.1, 0.5 * rod.length(), rod.length()] {
        let [left, right] = [&mut *a, &mut *b].map(|model| {
            let pose = model.pose(&q, x);
            let rotation = [pose.rotation.x, pose.rotation.y, pose.rotation.z].map(|axis| axis.to_array());
            [rotation[0], rotation[1], rotation[2], pose.position.to_array()].concat()
        });
        assert_equal_to_rounding(&left, &right, "pose");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn the_planar_kernel_agrees_with_the_spatial_one_to_rounding(rod in planar_rods(), phase in 0.0..6.0) {
        let mut planar = RobotModel::of_rod(&rod).unwrap();
        let mut spatial = RobotModel::spatial(&(&rod).into()).unwrap();
        prop_assert_eq!((planar.kernel(), spatial.kernel()), (Kernel::Planar, Kernel::Spatial));
        assert_same_rod(&rod, &mut planar, &mut spatial, phase);
    }

    #[test]
    fn portable_instructions_agree_with_the_best_of_this_machine(
        rod in prop_oneof![planar_rods(), rods()],
        phase in 0.0..6.0,
    ) {
        let mut best = RobotModel::of_rod(&rod).unwrap();
        let mut portable = RobotModel::portable(&rod).unwrap();
        prop_assert_eq!(best.kernel(), portable.kernel());
        assert_same_rod(&rod, &mut best, &mut portable, phase);
    }

    #[test]
    fn what_is_skipped_makes_no_difference(rod in prop_oneof![planar_rods(), rods()], phase in 0.0..6.0) {
        let mut skipping = RobotModel::of_rod(&rod).unwrap();
        let mut complete = RobotModel::with_nothing_skipped(&(&rod).into()).unwrap();
        assert_same_rod(&rod, &mut skipping, &mut complete, phase);
        prop_assert!(skipping.multiplications().residual <= complete.multiplications().residual);
        prop_assert!(skipping.multiplications().tangent <= complete.multiplications().tangent);
    }
}

/// Two segments with the given basis, tapered and damped, with varying reference strains and the same number
/// of modes of each strain in `strains`.
fn rod_in(basis: Basis, strains: &[usize]) -> Rod {
    let bent = |bend: f64, stretch: f64| [0.0, bend, 0.0, stretch, 0.0, 0.1 * bend];
    let table = Profile::table(&[0.0, 0.1, 0.4], &[bent(0.0, 1.0), bent(2.0, 1.1), bent(-1.0, 1.0)]).unwrap();
    let line = Profile::polynomial(&[bent(1.0, 1.0), bent(0.5, 0.05)]).unwrap();
    let segments = [(table, 4), (line, 6)].map(|(reference_strain, number)| {
        let mut modes = [0; 6];
        strains.iter().for_each(|&strain| modes[strain] = number);
        Segment {
            section: Section::circle([0.02, 0.015]),
            modes,
            basis,
            retardation_time: 0.01,
            reference_strain,
            ..Segment::straight(0.4, 0.02, 1e6, 4e5, 1000.0)
        }
    });
    let loads =
        vec![Load { extent: Extent::Along([0.1, 0.6]), force: [0.1, 0.0, 0.2].into(), ..Load::at_tip() }];
    let bodies = vec![Body { at: Some(0.25), ..Body::point(0.1) }];
    Rod { tip_force: [0.1, 0.2, 0.3], loads, bodies, ..Rod::new(segments.into()) }
}

#[test]
fn all_kernels_and_solves_agree_in_every_basis() {
    for basis in Basis::ALL {
        let flat = rod_in(basis, &[1, 3]);
        let mut planar = RobotModel::of_rod(&flat).unwrap();
        assert_eq!(planar.kernel(), Kernel::Planar);
        assert_same_rod(&flat, &mut planar, &mut RobotModel::spatial(&(&flat).into()).unwrap(), 0.3);

        let rod = rod_in(basis, &[0, 1, 2, 5]);
        let mut best = RobotModel::of_rod(&rod).unwrap();
        assert_same_rod(&rod, &mut best, &mut RobotModel::portable(&rod).unwrap(), 0.7);
        assert_same_rod(&rod, &mut best, &mut RobotModel::with_nothing_skipped(&(&rod).into()).unwrap(), 1.1);

        let mut chain = RobotModel::with_solve(&(&rod).into(), Solve::Tree).unwrap();
        let n = chain.facts().n;
        let (q, qd, qdd) = (state(n, 1.0, 0.2), state(n, 2.0, 1.2), state(n, 10.0, 2.0));
        let mut dense = Matrix::zeros(n, n);
        best.weighted_tangent(&q, &qd, &qdd, [1e-4, 1e-2, 1.0], &mut dense);
        let mut tangent = chain.tree().expect("a chain was asked for").tangent;
        chain.tree_tangent(&q, &qd, &qdd, [1e-4, 1e-2, 1.0], &mut tangent);
        assert_equal_to_rounding(tangent.to_dense().as_slice(), dense.as_slice(), "chain");
    }
}

#[test]
fn the_planar_kernel_is_taken_where_the_rod_stays_in_a_plane() {
    let kernel = |modes, reference_strain: [f64; 6]| {
        let reference_strain = reference_strain.into();
        let segment = Segment { modes, reference_strain, ..Segment::straight(1.0, 0.01, 1e6, 4e5, 1000.0) };
        let straight =
            Segment { modes: [0, 1, 0, 0, 0, 0], ..Segment::straight(1.0, 0.01, 1e6, 4e5, 1000.0) };
        RobotModel::of_rod(&Rod::new(vec![segment, straight])).unwrap().kernel()
    };
    let straight = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    assert_eq!(kernel([0, 3, 0, 2, 0, 1], straight), Kernel::Planar);
    assert_eq!(kernel([0, 0, 0, 0, 0, 0], [0.0, 1.0, 0.0, 1.0, 0.0, 0.3]), Kernel::Planar);
    // Torsion, two bends (here in different segments), shear out of the plane, and a twisted reference each
    // require space.
    assert_eq!(kernel([1, 3, 0, 0, 0, 0], straight), Kernel::Spatial);
    assert_eq!(kernel([0, 0, 3, 0, 0, 0], straight), Kernel::Spatial);
    assert_eq!(kernel([0, 3, 0, 0, 1, 0], straight), Kernel::Spatial);
    assert_eq!(kernel([0, 3, 0, 0, 0, 0], [0.1, 0.0, 0.0, 1.0, 0.0, 0.0]), Kernel::Spatial);
}
