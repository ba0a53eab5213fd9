//! A finger bent by tendons to a circular arc, with a known solution.

use super::commands::{Command, Kind, commands};
use super::equilibria::{Equilibria, NoEquilibrium};
use super::misfit::Actuated;
use super::*;
use crate::description::body::Body;
use crate::description::joint::{Joint, JointForces};
use crate::description::rod::Segment;
use crate::description::signal::{Input, Signal};
use crate::robot::effects::actuator::{Along, Chamber, Motor, MotorCommand, Part};
use crate::robot::effects::load::Load;
use crate::robot::{Link, Robot, Rod};

const LENGTH: f64 = 0.3;
const RADIUS: f64 = 0.01;
const YOUNG_MODULUS: f64 = 1e6;
const OFFSET: f64 = 0.008;

fn input(name: &str, value: f64) -> Signal<1> {
    Signal::Input(Input { name: name.into(), value: [value] })
}

fn tendon(name: &str, z: f64, drive: Drive) -> Actuator {
    let along = Along { link: 0, offset: [0.0.into(), z.into()], along: [0.0, LENGTH] };
    Actuator::Tendon(Tendon {
        name: name.into(),
        path: vec![Part::Along(along)],
        drive,
        friction: 0.0,
        friction_velocity: 1e-3,
        sliding: None,
    })
}

/// A weightless finger that bends in a plane with constant curvature.
fn finger(actuators: Vec<Actuator>) -> RobotModel {
    let straight = Segment::straight(LENGTH, RADIUS, YOUNG_MODULUS, 4e5, 1000.0);
    let segment = Segment { modes: [0, 1, 0, 0, 0, 0], ..straight };
    RobotModel::of_rod(&Rod { gravity: [0.0; 3], actuators, ..Rod::new(vec![segment]) }).unwrap()
}

/// Two tendons with tensions as inputs, one on each side.
fn pulled() -> RobotModel {
    let tendon = |name, z| tendon(name, z, Drive::Tension(input(name, 0.0)));
    finger(vec![tendon("up", OFFSET), tendon("down", -OFFSET)])
}

/// The tip of the arc for a tension, in the plane of x and z.
fn tip(tension: f64) -> [f64; 3] {
    let inertia = std::f64::consts::PI * RADIUS.powi(4) / 4.0;
    // About y, which rotates x to -z.
    let curvature = -tension * OFFSET / (YOUNG_MODULUS * inertia);
    let angle = curvature * LENGTH;
    [angle.sin() / curvature, 0.0, -(1.0 - angle.cos()) / curvature]
}

fn at(position: [f64; 3]) -> Target {
    Target { position: Some(position), ..Target::new(0) }
}

fn search(model: &mut RobotModel, target: Target, options: &Options) -> Found {
    actuate(model, &[target], options, &mut || Ok(())).unwrap().expect("nothing interrupts it")
}

#[test]
fn the_tension_of_an_arc_is_found() {
    for tension in [0.5, 2.0] {
        let found = search(&mut pulled(), at(tip(tension)), &Options::default());
        assert_eq!(found.status, Status::Reached, "{}", found.message);
        assert!((found.u[0] - tension).abs() < 1e-7 && found.u[1].abs() < 1e-7, "{:?}", found.u);
        assert!(found.errors[0].position < 1e-9 && found.at_limits.is_empty() && found.equilibria > 1);
    }
    // In the other direction the other tendon pulls.
    let [x, y, z] = tip(1.0);
    let found = search(&mut pulled(), at([x, y, -z]), &Options::default());
    assert!(found.u[0].abs() < 1e-7 && (found.u[1] - 1.0).abs() < 1e-7, "{:?}", found.u);
}

#[test]
fn what_is_out_of_reach_is_said() {
    let far = search(&mut pulled(), at([0.4, 0.0, 0.0]), &Options::default());
    assert_eq!(far.status, Status::Nearest, "{}", far.message);
    assert!((far.errors[0].position - 0.1).abs() < 1e-9);
    let options = Options { limits: vec![(0, [0.0, 0.5])], ..Options::default() };
    let held = search(&mut pulled(), at(tip(1.0)), &options);
    // The other tendon would have to push.
    assert_eq!((held.status, &held.at_limits[..]), (Status::AtLimits, &[0, 1][..]), "{}", held.message);
    assert!(held.message.contains("'up' and 'down' are held back"), "{}", held.message);
    assert!((held.u[0] - 0.5).abs() < 1e-12 && held.u[1] == 0.0, "{:?}", held.u);
}

#[test]
fn a_slack_tendon_is_named_where_it_is_why_nothing_is_found() {
    let length =
        |name: &str, value| Drive::Length { length: input(name, value), stiffness: Some(1e4), damping: 0.0 };
    let slack = || finger(vec![tendon("up", OFFSET, length("up", 0.31))]);
    let found = search(&mut slack(), at(tip(1.0)), &Options::default());
    assert!(!found.status.is_success());
    assert!(found.message.contains("'up' is slack there"), "{}", found.message);
    // From a taut tendon the target is reachable.
    let taut = Options { u: Some(vec![0.299]), ..Options::default() };
    let found = search(&mut slack(), at(tip(1.0)), &taut);
    assert_eq!(found.status, Status::Reached, "{}", found.message);
    assert!(!found.message.contains("slack"));
    // An input that is not requested is ignored.
    let both = vec![
        tendon("up", OFFSET, Drive::Tension(input("up", 0.0))),
        tendon("down", -OFFSET, length("down", 0.31)),
    ];
    let alone = Options { free: Some(vec![0]), ..Options::default() };
    let found = search(&mut finger(both), at([0.4, 0.0, 0.0]), &alone);
    assert!(!found.status.is_success() && !found.message.contains("slack"), "{}", found.message);
}

#[test]
fn bad_input_is_refused_before_any_search() {
    let refused = |targets: &[Target], options: &Options| {
        let error = actuate(&mut pulled(), targets, options, &mut || panic!("work")).unwrap_err();
        error.problems.into_iter().map(|problem| problem.place).collect::<Vec<_>>()
    };
    let plain = Options::default();
    assert_eq!(refused(&[], &plain), ["targets"]);
    let target = || [at([0.1, 0.0, 0.0])];
    assert_eq!(refused(&target(), &Options { u: Some(vec![0.0]), ..plain.clone() }), ["u"]);
    assert_eq!(refused(&target(), &Options { u: Some(vec![0.0, f64::NAN]), ..plain.clone() }), ["u[1]"]);
    assert_eq!(refused(&target(), &Options { free: Some(vec![]), ..plain.clone() }), ["inputs"]);
    assert_eq!(refused(&target(), &Options { free: Some(vec![2]), ..plain.clone() }), ["inputs"]);
    for limits in [[1.0, 0.0], [f64::NAN, 1.0], [-2.0, -1.0]] {
        let limits = vec![(1, limits)];
        assert_eq!(refused(&target(), &Options { limits, ..plain.clone() }), ["limits['down']"]);
    }
    assert_eq!(refused(&target(), &Options { tol: 0.0, ..plain.clone() }), ["tol"]);
    let without = actuate(&mut finger(Vec::new()), &target(), &plain, &mut || Ok(())).unwrap_err();
    assert_eq!(without.problems[0].place, "robot");
}

#[test]
fn an_interrupt_ends_it() {
    let interrupted = actuate(&mut pulled(), &[at(tip(1.0))], &Options::default(), &mut || Err(Interrupted));
    let kept = interrupted.unwrap().unwrap_err().into_inner();
    assert_eq!((kept.status, kept.u.len()), (Status::Interrupted, 2));
}

#[test]
fn every_input_is_known_by_what_it_commands() {
    let body = || Some(Body::point(0.1));
    let joint = |axis| Joint::Revolute { axis, forces: JointForces::default() };
    let mut robot = Robot::new(vec![
        Link {
            rod: vec![Segment {
                modes: [0, 1, 0, 0, 0, 0],
                ..Segment::straight(LENGTH, RADIUS, 1e6, 4e5, 1e3)
            }],
            ..Link::new("finger")
        },
        Link { joint: joint([0.0, 1.0, 0.0]), body: body(), ..Link::new("wheel") },
    ]);
    let wind = Signal::Input(Input { name: "wind".into(), value: [0.0, 0.0, 1.0] });
    robot.loads = vec![Load { force: wind, ..Load::at_tip() }];
    let length = Drive::Length { length: input("length", 0.2), stiffness: Some(1.0), damping: 0.0 };
    let along = Along { link: 0, offset: [0.0.into(), 0.01.into()], along: [0.0, LENGTH] };
    let motor = |name: &str, command, limits| {
        Actuator::Motor(Motor { name: name.into(), link: 1, coordinate: 0, command, limits })
    };
    let position = MotorCommand::Position { position: input("angle", 0.4), stiffness: 1.0, damping: 0.0 };
    robot.actuators = vec![
        tendon("held", OFFSET, length),
        Actuator::Chamber(Chamber {
            name: "blow".into(),
            path: vec![along],
            area: 1e-4,
            pressure: input("pressure", 5.0),
        }),
        motor("servo", position, None),
        motor("weak", MotorCommand::Torque(input("torque", 0.5)), Some([-1.0, 2.0])),
        // Of inputs with the same name, the first one determines the kind.
        tendon("other", -OFFSET, Drive::Tension(input("pressure", 5.0))),
    ];
    let any = [f64::NEG_INFINITY, f64::INFINITY];
    let command = |kind, limits, least| Command { kind, limits, least };
    let expected = [
        command(Kind::Force, any, 0.0),
        command(Kind::Force, any, 0.0),
        command(Kind::Force, any, 0.0),
        // For lengths, the input of least effort is the default.
        command(Kind::Length, [0.0, f64::INFINITY], 0.2),
        command(Kind::Pressure, any, 0.0),
        command(Kind::Position, any, 0.4),
        command(Kind::Torque, [-1.0, 2.0], 0.0),
    ];
    assert_eq!(commands(&robot), expected);
}

/// Any size of the coordinate.
const SIZE: [f64; 1] = [3.0];

#[test]
fn equilibria_change_with_inputs_as_their_sensitivity_says() {
    let mut model = pulled();
    let mut never = || Ok(());
    let mut equilibria =
        Equilibria::new(&mut model, 0.0, vec![0.0, 0.0], vec![0.0], SIZE.to_vec(), &mut never);
    let step = 1e-4;
    let mut shape = |u: [f64; 2]| equilibria.at(&u).unwrap().expect("a way").to_vec()[0];
    let found: Vec<f64> = [-step, step, 0.0].map(|h| shape([1.0 + h, 0.2])).into();
    let sensitivity = equilibria.sensitivity().unwrap().expect("no singular stiffness");
    let difference = (found[1] - found[0]) / (2.0 * step) / SIZE[0];
    assert!((sensitivity[(0, 0)] - difference).abs() < 1e-6 * difference.abs(), "{difference}");
    assert!((sensitivity[(0, 0)] + sensitivity[(0, 1)]).abs() < 1e-12 * difference.abs());
    // Non-finite inputs fail, and the previous state remains usable.
    assert!(equilibria.at(&[f64::NAN, 0.0]).unwrap().is_none());
    assert_eq!(equilibria.no_equilibrium, Some(NoEquilibrium::Continuation(statics::Status::NonFinite)));
    assert!(equilibria.at(&[1.0, 0.2]).unwrap().is_some());
}

#[test]
fn the_misfit_changes_with_inputs_as_its_jacobian_says() {
    let (mut model, mut seen) = (pulled(), pulled());
    let (mut never, mut neither) = (|| Ok(()), || Ok(()));
    let equilibria = Equilibria::new(&mut model, 0.0, vec![0.0, 0.0], vec![0.0], SIZE.to_vec(), &mut never);
    let targets = [at([0.2, 0.0, 0.1])];
    let mut misfit = Misfit::new(&mut seen, &targets, &[0.0], Vec::new(), &mut neither);
    misfit.sizes = SIZE.to_vec();
    let mut system = Actuated::new(equilibria, misfit, vec![0.0, 0.3], vec![0], vec![0.5]);
    // Larger than its size; the other input is unchanged.
    assert_eq!(system.inputs(&[2.0]), [1.0, 0.3]);
    let residual = |system: &mut Actuated<'_, '_>, x: f64| {
        let mut residual = vec![0.0; system.equations()];
        system.residual(&[x], &mut residual).unwrap();
        residual
    };
    let step = 1e-4;
    let [before, after] = [-step, step].map(|h| residual(&mut system, 2.0 + h));
    let mut jacobian = Matrix::zeros(system.equations(), 1);
    system.jacobian(&[2.0], &mut jacobian).unwrap();
    for (i, (before, after)) in before.iter().zip(&after).enumerate() {
        let difference = (after - before) / (2.0 * step);
        assert!((jacobian[(i, 0)] - difference).abs() < 1e-7, "{i}: {} {difference}", jacobian[(i, 0)]);
    }
    assert!(residual(&mut system, f64::NAN).iter().all(|entry| entry.is_nan()));
}
