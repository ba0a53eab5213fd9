//! Actuators: tangents against finite differences, power against forces, and equivalent ways of computation.

use lissom::actuator::{
    ActiveStrain, Actuator, Along, Chamber, Drive, Motor, MotorCommand, Part, Strain, Tendon, Via,
};
use lissom::body::Body;
use lissom::joint::{Joint, JointForces};
use lissom::linalg::{Matrix, TreeMatrix};
use lissom::load::{Frame, Load};
use lissom::model::{Dynamics, InTime as _, Tree};
use lissom::robot::{Driven, Kernel, Link, Robot, RobotModel, Rod, Solve};
use lissom::rod::{Profile, Segment, diagonal};
use lissom::signal::{Input, Signal};

fn input<const N: usize>(name: &str, value: [f64; N]) -> Signal<N> {
    Signal::Input(Input { name: name.into(), value })
}

fn segment(modes: [usize; 6], length: f64) -> Segment {
    Segment { modes, retardation_time: 1e-3, ..Segment::straight(length, 0.01, 1e6, 4e5, 1000.0) }
}

fn along(link: usize, offset: [Profile<1>; 2], along: [f64; 2]) -> Part {
    Part::Along(Along { link, offset, along })
}

fn via(link: Option<usize>, point: [f64; 3], at: Option<f64>) -> Part {
    Part::Via(Via { link, point, at })
}

fn tendon(name: &str, path: Vec<Part>, drive: Drive, friction: f64) -> Actuator {
    Actuator::Tendon(Tendon {
        name: name.into(),
        path,
        drive,
        friction,
        friction_velocity: 0.2,
        sliding: None,
    })
}

fn helix() -> [Profile<1>; 2] {
    let wave = |phase: f64| Profile::sampled(|x| Ok::<_, ()>([0.01 * (4.0 * x + phase).sin()])).unwrap();
    [wave(0.0), wave(std::f64::consts::FRAC_PI_2)]
}

fn flat(y: f64, z: f64) -> [Profile<1>; 2] {
    [y.into(), z.into()]
}

/// A rotating body, two rods with a ball in between, a hand and a branch, with actuators of every kind.
fn robot() -> Robot {
    let body = |mass| Body { inertia: diagonal([0.01, 0.02, 0.03]), ..Body::point(mass) };
    let link = |name, parent: Option<usize>, joint| Link {
        parent,
        joint,
        position: [0.05, 0.01, -0.02],
        ..Link::new(name)
    };
    let hinge = |axis| Joint::Revolute { axis, forces: JointForces::default() };
    let links = vec![
        Link { body: Some(body(1.0)), ..link("base", None, hinge([0.0, 1.0, 0.0])) },
        Link {
            rod: vec![segment([1, 2, 2, 1, 0, 0], 0.3), segment([1, 1, 2, 0, 1, 1], 0.2)],
            ..link("arm", Some(0), Joint::Weld)
        },
        Link { rod: vec![segment([0, 2, 1, 1, 0, 0], 0.25)], ..link("wrist", Some(1), Joint::Spherical) },
        Link { body: Some(body(0.1)), ..link("hand", Some(2), Joint::Weld) },
        Link {
            rod: vec![segment([0, 1, 2, 0, 0, 0], 0.2)],
            at: Some(0.2),
            ..link("branch", Some(1), hinge([0.0, 0.0, 1.0]))
        },
    ];
    let cable =
        |name: &str| Drive::Length { length: input(name, [0.4]), stiffness: Some(40.0), damping: 1.5 };
    let through = vec![
        via(None, [-0.1, 0.05, 0.1], None),
        along(1, [Profile::linear([[0.01], [0.02]]), 0.01.into()], [0.1, 0.45]),
        along(2, helix(), [0.0, 0.25]),
        via(Some(3), [0.01, 0.02, 0.03], None),
    ];
    let actuators = vec![
        tendon("helix", vec![along(1, helix(), [0.05, 0.4])], Drive::Tension(input("helix", [2.0])), 0.0),
        tendon("through", through.clone(), cable("through"), 0.0),
        tendon("rubbing", through, cable("rubbing"), 0.4),
        tendon(
            "stay",
            vec![via(Some(4), [0.0, 0.01, 0.02], Some(0.11)), via(Some(2), [0.0, 0.02, 0.03], Some(0.1))],
            Drive::Tension(input("stay", [1.0])),
            0.0,
        ),
        Actuator::Chamber(Chamber {
            name: "chamber".into(),
            path: vec![Along { link: 1, offset: flat(-0.01, 0.003), along: [0.0, 0.45] }],
            area: 1e-4,
            pressure: input("pressure", [2e4]),
        }),
        Actuator::Motor(Motor {
            name: "servo".into(),
            link: 4,
            coordinate: 0,
            command: MotorCommand::Position { position: input("angle", [0.3]), stiffness: 3.0, damping: 0.2 },
            limits: Some([-3.0, 2.0]),
        }),
        Actuator::ActiveStrain(ActiveStrain {
            name: "muscle".into(),
            link: 2,
            strain: Strain::BendY,
            shape: Profile::linear([[1.0], [3.0]]),
            amount: input("muscle", [0.7]),
        }),
    ];
    let load = Load { link: 2, force: input("push", [0.1, 0.2, 0.3]), ..Load::at_tip() };
    let follower = Load { frame: Frame::Body, moment: input("turn", [0.01, 0.0, 0.02]), ..load.clone() };
    Robot { actuators, loads: vec![load, follower], ..Robot::new(links) }
}

fn state(n: usize) -> [Vec<f64>; 3] {
    [0.3, 0.5, 1.0].map(|size| (0..n).map(|i| size * (1.7 * i as f64 + size).cos()).collect())
}

fn forces(model: &mut RobotModel, [q, qd, qdd]: &[Vec<f64>; 3]) -> Vec<f64> {
    let mut tau = vec![0.0; q.len()];
    model.inverse_dynamics(q, qd, qdd, &mut tau);
    tau
}

fn tangent(model: &mut RobotModel, [q, qd, qdd]: &[Vec<f64>; 3], weights: [f64; 3]) -> Matrix {
    let mut tangent = Matrix::zeros(q.len(), q.len());
    model.weighted_tangent(q, qd, qdd, weights, &mut tangent);
    tangent
}

fn assert_close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found} is not {wanted}");
}

/// Compares the tangents with respect to coordinates, velocities and inputs with central differences.
fn check_derivatives(model: &mut RobotModel) {
    const STEP: f64 = 1e-5;
    let n = model.facts().n;
    let here = state(n);
    for order in 0..2 {
        let weights = [0, 1, 2].map(|i| if i == order { 1.0 } else { 0.0 });
        let exact = tangent(model, &here, weights);
        let size = exact.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        for k in 0..n {
            let mut moved = here.clone();
            moved[order][k] += STEP;
            let after = forces(model, &moved);
            moved[order][k] = here[order][k] - STEP;
            let before = forces(model, &moved);
            for j in 0..n {
                let slope = (after[j] - before[j]) / (2.0 * STEP);
                assert_close(exact[(j, k)], slope, 1e-7 * size, &format!("order {order}, entry {j}, {k}"));
            }
        }
    }
    let u = model.description().inputs().defaults().to_vec();
    let mut exact = Matrix::zeros(n, u.len());
    model.input_tangent(&here[0], &here[1], &here[2], &mut exact);
    for k in 0..u.len() {
        let step = STEP * u[k].abs().max(1.0);
        let mut at = |x: f64| {
            let mut moved = u.clone();
            moved[k] = x;
            model.set_inputs(&moved);
            forces(model, &here)
        };
        let (after, before) = (at(u[k] + step), at(u[k] - step));
        let size = (0..n).fold(0.0, |size: f64, j| size.max(exact[(j, k)].abs()));
        for j in 0..n {
            let slope = (after[j] - before[j]) / (2.0 * step);
            assert_close(exact[(j, k)], slope, 1e-6 * size, &format!("input {k}, entry {j}"));
        }
    }
    model.set_inputs(&u);
}

#[test]
fn tangents_are_the_derivatives_of_the_forces() {
    let mut model = RobotModel::new(&robot()).unwrap();
    assert_eq!(model.solve(), Solve::Dense, "straight parts couple links");
    check_derivatives(&mut model);
}

#[test]
fn tangents_know_joints_that_follow_others() {
    let mut robot = robot();
    robot.links[4].driven = Some(Driven::Mimic { link: 0, multiplier: -0.5, offset: 0.1 });
    check_derivatives(&mut RobotModel::new(&robot).unwrap());
}

#[test]
fn powers_and_gradients_are_those_of_the_forces() {
    let robot = robot();
    let mut model = RobotModel::new(&robot).unwrap();
    let mut bare = RobotModel::new(&Robot { actuators: Vec::new(), ..robot.clone() }).unwrap();
    let [q, qd, _] = state(model.facts().n);
    let at_rest = vec![0.0; q.len()];
    let here = [q.clone(), qd.clone(), at_rest.clone()];
    let given: f64 = forces(&mut bare, &here)
        .iter()
        .zip(forces(&mut model, &here))
        .zip(&qd)
        .map(|((without, with), rate)| (without - with) * rate)
        .sum();
    let power =
        |model: &mut RobotModel| model.supplied_power(&q, &qd, &at_rest) - model.dissipated_power(&q, &qd);
    assert_close(power(&mut model) - power(&mut bare), given, 1e-10 * given.abs(), "power");
    let mut gradient = vec![0.0; q.len()];
    for i in 0..robot.actuators.len() {
        let [_, rate, _] = model.actuator(&q, &qd, i, &mut gradient);
        let along: f64 = gradient.iter().zip(&qd).map(|(g, rate)| g * rate).sum();
        assert_close(rate, along, 1e-12 * along.abs(), "rate");
        let step = 1e-6;
        let mut at = |sign: f64| {
            let moved: Vec<f64> = q.iter().zip(&qd).map(|(q, qd)| q + sign * step * qd).collect();
            model.actuator(&moved, &at_rest, i, &mut vec![0.0; q.len()])[0]
        };
        let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
        assert_close(slope, along, 1e-7 * along.abs(), "slope of the length");
    }
}

#[test]
fn tendons_in_a_plane_are_those_in_space() {
    let path = vec![along(0, flat(0.0, 0.012), [0.02, 0.28]), via(Some(0), [0.01, 0.0, 0.02], None)];
    let actuators = vec![
        tendon(
            "cable",
            path,
            Drive::Length { length: [0.2].into(), stiffness: Some(50.0), damping: 0.4 },
            0.2,
        ),
        tendon("pull", vec![along(0, flat(0.0, -0.01), [0.0, 0.3])], Drive::Tension([1.5].into()), 0.0),
    ];
    let rod = Rod { actuators, ..Rod::new(vec![segment([0, 3, 0, 1, 0, 1], 0.3)]) };
    let robot = Robot::from(&rod);
    let mut plane = RobotModel::new(&robot).unwrap();
    let mut space = RobotModel::spatial(&robot).unwrap();
    assert_eq!((plane.kernel(), space.kernel()), (Kernel::Planar, Kernel::Spatial));
    let here = state(plane.facts().n);
    let (a, b) = (forces(&mut plane, &here), forces(&mut space, &here));
    let size = a.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    a.iter().zip(&b).for_each(|(a, b)| assert_close(*a, *b, 1e-12 * size, "force"));
    let weights = [1.0, 0.1, 0.01];
    let (a, b) = (tangent(&mut plane, &here, weights), tangent(&mut space, &here, weights));
    let size = a.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    a.iter().zip(b.iter()).for_each(|(a, b)| assert_close(*a, *b, 1e-12 * size, "tangent"));
    let outside = Rod {
        actuators: vec![tendon(
            "pull",
            vec![along(0, flat(0.01, 0.0), [0.0, 0.3])],
            Drive::Tension([1.5].into()),
            0.0,
        )],
        ..rod
    };
    assert_eq!(RobotModel::of_rod(&outside).unwrap().kernel(), Kernel::Spatial);
}

#[test]
fn trees_have_the_tangents_of_tendons_that_couple_nothing() {
    let mut robot = robot();
    robot.actuators.retain(|actuator| ["helix", "chamber", "servo", "muscle"].contains(&actuator.name()));
    let mut dense = RobotModel::with_solve(&robot, Solve::Dense).unwrap();
    let mut tree = RobotModel::with_solve(&robot, Solve::Tree).unwrap();
    let [q, qd, qdd] = state(dense.facts().n);
    let weights = [1.0, 0.1, 0.01];
    let wanted = tangent(&mut dense, &[q.clone(), qd.clone(), qdd.clone()], weights);
    let Some(Tree { tangent: mut found, .. }) = tree.tree() else { panic!("it was asked for") };
    tree.tree_tangent(&q, &qd, &qdd, weights, &mut found);
    let found = TreeMatrix::to_dense(&found);
    let size = wanted.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    wanted.iter().zip(found.iter()).for_each(|(a, b)| assert_close(*b, *a, 1e-12 * size, "entry"));
}

#[test]
fn a_long_path_is_as_long_as_its_parts() {
    let pull = |parts| vec![tendon("pull", parts, Drive::Tension([1.5].into()), 0.0)];
    let rod = Rod::new(vec![segment([1, 2, 2, 1, 1, 1], 0.3), segment([1, 2, 2, 0, 0, 0], 0.2)]);
    let whole = pull(vec![along(0, helix(), [0.0, 0.5])]);
    let parts =
        pull([0.0, 0.13, 0.3, 0.41, 0.5].windows(2).map(|x| along(0, helix(), [x[0], x[1]])).collect());
    let mut lengths = [whole, parts].map(|actuators| {
        let mut model = RobotModel::of_rod(&Rod { actuators, ..rod.clone() }).unwrap();
        let [q, qd, _] = state(model.facts().n);
        let mut gradient = vec![0.0; q.len()];
        let numbers = model.actuator(&q, &qd, 0, &mut gradient);
        [numbers[0], numbers[1], gradient[3]]
    });
    let [whole, parts] = &mut lengths;
    for (whole, part) in whole.iter().zip(parts) {
        assert_close(*part, *whole, 1e-12, "length");
    }
}

#[test]
fn inputs_stand_in_the_order_of_the_description() {
    let robot = robot();
    let names = robot.inputs().names();
    let wanted = [
        "push.x", "push.y", "push.z", "turn.x", "turn.y", "turn.z", "helix", "through", "rubbing", "stay",
        "pressure", "angle", "muscle",
    ];
    assert_eq!(names, wanted);
    assert_eq!(robot.inputs().defaults().len(), RobotModel::new(&robot).unwrap().facts().inputs());
    let mut twice = robot.clone();
    twice.actuators.truncate(1);
    let Actuator::Tendon(other) = &mut twice.actuators[0] else { panic!("a tendon") };
    other.drive = Drive::Tension(input("push", [1.0]));
    let problems = twice.validate().unwrap_err().to_string();
    assert!(
        problems.starts_with("actuators[0].tension: got the input \"push\" with the default"),
        "{problems}"
    );
}
