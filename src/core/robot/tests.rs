//! Robots with branches and joints.

use super::choice::Solve;
use super::compile;
use super::description::{Driven, Link, Robot, Rod};
use super::kernel::tree;
use super::model::RobotModel;
use super::plan::Plan;
use super::plan::joined::Weld;
use super::state::tangent::Tangent;
use super::sweeps::Sweeps;
use crate::description::body::Body;
use crate::description::joint::{Joint, JointForces};
use crate::description::rod::diagonal;
use crate::description::rod::{Section, Segment};
use crate::model::Dynamics as _;
use crate::numerics::lie::{Quaternion, Spatial, Vector};
use crate::numerics::linalg::Matrix;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::{Extent, Load};
use crate::robot::effects::support::Support;
use crate::robot::explain::cost;

type Space = Spatial<true>;

/// A rod of four segments, with loads, a body at its tip, and optional supports and fluid.
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
    let rotation = orientation.rotation();
    joined.weld = Some(Weld { to, orientation, rotation, position: position.into(), turns: true });
    plan.stations += 1;
}

/// The third segment at the end of the first one, rotated and displaced, and the fourth one on the frame.
fn fork(responds: bool) -> Plan<Space> {
    let mut plan = compile::plan::<Space>(&(&rod(responds)).into(), ());
    weld(&mut plan, 2, 1, Vector { x: 0.3, y: -0.5, z: 0.9 }, [0.02, 0.01, -0.03]);
    weld(&mut plan, 3, 0, Vector { x: 0.1, y: 0.2, z: -2.0 }, [0.0, 0.1, 0.0]);
    plan.find_families();
    plan
}

/// All joints, rods and bodies, attached at tips, inside rods and to bodies.
fn robot(responds: bool) -> Robot {
    let forces = JointForces {
        stiffness: 3.0,
        rest: 0.2,
        damping: 0.4,
        friction: 0.1,
        friction_velocity: 0.5,
        limits: Some([-0.2, 0.1]),
        limit_stiffness: 20.0,
        limit_dissipation: 0.3,
        armature: 0.05,
    };
    let body =
        || Body { centre: [0.05, -0.02, 0.1], inertia: diagonal([2e-3, 3e-3, 4e-3]), ..Body::point(0.4) };
    let own = rod(responds);
    let link = |name, parent, joint| Link {
        parent,
        joint,
        position: [0.1, -0.2, 0.3],
        orientation: [0.5, 0.1, -0.7, 0.5],
        ..Link::new(name)
    };
    let axis = [1.0, 2.0, -2.0];
    let links = vec![
        Link { body: Some(body()), ..link("head", None, Joint::Free) },
        Link { rod: own.segments, ..link("arm", Some(0), Joint::Revolute { axis, forces: forces.clone() }) },
        Link { body: Some(body()), at: Some(0.5), ..link("ring", Some(1), Joint::Cylindrical { axis }) },
        Link { rod: vec![], at: Some(0.35), body: Some(body()), ..link("ball", Some(1), Joint::Spherical) },
        Link { body: Some(body()), ..link("tool", Some(1), Joint::Weld) },
        Link { body: Some(body()), ..link("slide", Some(4), Joint::Prismatic { axis, forces }) },
        Link { body: Some(body()), ..link("plate", Some(2), Joint::Planar { normal: axis }) },
        Link {
            body: Some(body()),
            ..link("cross", None, Joint::Universal { axes: [axis, [1.0, 0.0, 0.0]] })
        },
    ];
    let on_arm = |load: Load| Load { link: 1, ..load };
    Robot {
        loads: own.loads.into_iter().map(on_arm).chain([Load { link: 5, ..dead() }]).collect(),
        supports: own.supports.into_iter().map(|support| Support { link: 1, ..support }).collect(),
        fluid: own.fluid,
        ..Robot::new(links)
    }
}

fn dead() -> Load {
    Load { force: [0.3, -0.2, 0.1].into(), moment: [0.01, 0.02, -0.03].into(), ..Load::at_tip() }
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
    let joints = |responds| compile::plan::<Space>(&robot(responds), ());
    for (responds, plan) in
        [(false, fork(false)), (true, fork(true)), (false, joints(false)), (true, joints(true))]
    {
        let mut sweeps = Sweeps::new(plan);
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
            let mut by_links = tree::tangent(sweeps.plan());
            sweeps.weighted_tangent([q, qd, qdd], weights, Tangent::Tree(&mut by_links));
            let error = largest(&(&tangent - by_links.to_dense()));
            assert!(error < 1e-14 * largest(&tangent), "{responds} {weights:?}, by links: {error:e}");
        }
    }
}

#[test]
fn masses_of_joints_are_the_derivatives_of_their_forces() {
    for responds in [false, true] {
        let mut sweeps = Sweeps::new(compile::plan::<Space>(&robot(responds), ()));
        let n = sweeps.plan().n;
        let [q, qd, qdd] = state(n);
        let mut mass = Matrix::from_element(n, n, f64::NAN);
        sweeps.mass_matrix(&q, Tangent::Dense(&mut mass));
        assert_eq!(mass, mass.transpose());
        assert!(crate::numerics::linalg::Cholesky::new(n).factorise(&mass).is_ok());
        let mut by_links = tree::mass(sweeps.plan());
        sweeps.mass_matrix(&q, Tangent::Tree(&mut by_links));
        assert!(largest(&(&mass - by_links.to_dense())) < 1e-14 * largest(&mass));
        let rest = forces(&mut sweeps, &[q.clone(), qd.clone(), vec![0.0; n]]);
        let moving = forces(&mut sweeps, &[q, qd, qdd.clone()]);
        let product = &mass * Matrix::from_column_slice(n, 1, &qdd);
        for (j, inertial) in product.iter().enumerate() {
            assert!((moving[j] - rest[j] - inertial).abs() < 1e-12 * largest(&product), "{responds} {j}");
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
    assert!(crate::numerics::linalg::Cholesky::new(n).factorise(&mass).is_ok());
    // The mass matrix is the derivative of these forces with respect to the accelerations.
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
        let chain = compile::plan::<Space>(&(&rod(responds)).into(), ());
        let mut welded = chain.clone();
        for p in [1, 3] {
            weld(&mut welded, p, p, Vector::zero(), [0.0; 3]);
        }
        welded.find_families();
        assert!(!welded.has_branches && welded.stations > chain.stations);
        let n = chain.n;
        let state = state(n);
        let [q, qd, qdd] = &state;
        let results = [chain, welded].map(|plan| {
            let mut sweeps = Sweeps::new(plan);
            let (mut tangent, mut jacobian) = (Matrix::zeros(n, n), Matrix::zeros(6, n));
            sweeps.weighted_tangent([q, qd, qdd], [0.7, 0.2, 0.1], Tangent::Dense(&mut tangent));
            let place = sweeps.place(0, Some(0.8));
            sweeps.jacobian(q, &place, &mut jacobian);
            let energy = sweeps.energy(q, qd).total();
            (forces(&mut sweeps, &state), tangent, jacobian, energy, sweeps.base_wrench([q, qd, qdd]))
        });
        assert_eq!(results[0], results[1]);
    }
}

#[test]
fn places_on_branches_move_as_their_jacobians_say() {
    let joints = compile::plan::<Space>(&robot(false), ());
    let in_fork = [0.2, 0.5, 0.8].map(|x| (fork(false), 0, x));
    let in_joints = [(1, 0.2), (1, 0.6), (0, 0.0), (2, 0.0), (3, 0.0), (5, 0.0), (6, 0.0), (7, 0.0)];
    for (plan, link, x) in in_fork.into_iter().chain(in_joints.map(|(link, x)| (joints.clone(), link, x))) {
        let mut sweeps = Sweeps::new(plan);
        let n = sweeps.plan().n;
        let [q, qd, _] = state(n);
        let place = sweeps.place(link, Some(x));
        let mut jacobian = Matrix::zeros(6, n);
        sweeps.jacobian(&q, &place, &mut jacobian);
        let product = &jacobian * Matrix::from_column_slice(n, 1, &qd);
        let [angular, linear] = sweeps.velocity(&q, &qd, &place);
        const STEP: f64 = 1e-6;
        let mut at = |sign: f64| {
            let q: Vec<f64> = q.iter().zip(&qd).map(|(q, qd)| q + sign * STEP * qd).collect();
            sweeps.pose(&q, &place).position
        };
        let change = (at(1.0) - at(-1.0)) * (0.5 / STEP);
        let [angular, linear, change] = [angular, linear, change].map(Vector::to_array);
        for i in 0..3 {
            let errors = [
                product[(i, 0)] - angular[i],
                product[(3 + i, 0)] - linear[i],
                1e-4 * (change[i] - linear[i]),
            ];
            let error = errors.into_iter().fold(0.0, |largest: f64, error| largest.max(error.abs()));
            assert!(error < 1e-12, "link {link} at {x}: {errors:?}");
        }
    }
}

#[test]
fn driven_joints_are_solved_with_all_entries() {
    let joint = || Joint::Revolute { axis: [0.0, 1.0, 0.0], forces: JointForces::default() };
    let body = || Body { centre: [0.1, 0.0, 0.0], ..Body::point(0.1) };
    let link = |i: usize| Link {
        parent: i.checked_sub(1),
        joint: joint(),
        body: Some(body()),
        position: [0.2, 0.0, 0.0],
        ..Link::new(format!("link {i}"))
    };
    let mut robot = Robot::new((0..30).map(link).collect());
    assert_eq!(RobotModel::new(&robot).unwrap().solve(), Solve::Tree);
    robot.links[7].driven = Some(Driven::Mimic { link: 20, multiplier: -1.0, offset: 0.0 });
    let model = RobotModel::with_solve(&robot, Solve::Tree).unwrap();
    assert_eq!((model.solve(), model.facts().n), (Solve::Dense, 29));
    assert!(model.tree().is_none());
    robot.links[20].driven = Some(Driven::Mimic { link: 99, multiplier: f64::NAN, offset: 0.0 });
    let error = RobotModel::new(&robot).unwrap_err();
    let places: Vec<&str> = error.problems.iter().map(|problem| problem.place.as_str()).collect();
    assert_eq!(
        places,
        ["links[20].joint.mimic.multiplier", "links[7].joint.mimic.link", "links[20].joint.mimic.link"]
    );
}

#[test]
fn the_links_of_a_robot_share_its_pieces_and_their_cost() {
    for responds in [false, true] {
        let mut robot = robot(responds);
        // A frame at the end of a link is computed with that link.
        let frame = Link { parent: Some(robot.links.len() - 1), ..Link::new("frame") };
        robot.links.push(frame);
        let plan = compile::plan::<Space>(&robot, ());
        let pieces: Vec<usize> = (0..robot.links.len()).flat_map(|link| plan.pieces_of(link)).collect();
        assert_eq!(pieces, (0..plan.pieces.len()).collect::<Vec<_>>());
        assert!(plan.pieces_of(robot.links.len() - 1).is_empty());

        let all = cost::multiplications(&plan, Solve::Dense);
        let of_links = cost::of_links(&plan, Solve::Dense);
        assert_eq!(of_links.iter().map(|of| of.residual).sum::<u64>(), all.residual);
        assert_eq!(of_links.iter().map(|of| of.tangent).sum::<u64>(), all.tangent);
        assert_eq!(of_links.iter().map(|of| of.nodes).sum::<usize>(), plan.nodes().iter().sum::<usize>());
        for (link, of_link) in robot.links.iter().zip(&of_links) {
            assert_eq!(of_link.coordinates, link.coordinates(), "{}", link.name);
            assert_eq!(of_link.nodes > 0, !link.rod.is_empty(), "{}", link.name);
        }
    }
}
