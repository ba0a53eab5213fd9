//! How surfaces that meet part again.

use std::f64::consts::PI;

use lissom::body::Body;
use lissom::contact::{Contact, HalfSpace, Stiffness, Surface};
use lissom::joint::{Joint, JointForces};
use lissom::model::{InImpact, Separation};
use lissom::robot::{Link, Robot, RobotModel};

const RADIUS: f64 = 0.1;

/// Balls of these masses and stiffnesses that slide along z above a floor.
fn balls(of_each: &[(f64, f64)], gravity: f64) -> RobotModel {
    let links = of_each.iter().enumerate().map(|(i, &(mass, _))| {
        let joint = Joint::Prismatic { axis: [0.0, 0.0, 1.0], forces: JointForces::default() };
        Link { joint, body: Some(Body::point(mass)), ..Link::new(format!("ball {i}")) }
    });
    let contacts = of_each.iter().enumerate().map(|(link, &(_, stiffness))| {
        let floor = Surface::Obstacle(HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] }.into());
        let ball = Surface::Ball { link, at: None, position: [0.0; 3], radius: RADIUS };
        Contact {
            stiffness: Some(Stiffness::Given(stiffness)),
            dissipation: 0.0,
            ..Contact::between(&format!("contact {link}"), [ball, floor])
        }
    });
    let robot =
        Robot { gravity: [0.0, 0.0, -gravity], contacts: contacts.collect(), ..Robot::new(links.collect()) };
    RobotModel::new(&robot).unwrap()
}

/// The first ball comes with a speed and is stopped in a step of size `h`, at whose end it overlaps by `depth`; another one is far above.
fn separation(masses: &[f64], speed: f64, depth: f64, gravity: f64, h: f64) -> Separation {
    let of_each: Vec<_> = masses.iter().map(|&mass| (mass, 1e6 * mass)).collect();
    let mut model = balls(&of_each, gravity);
    let n = masses.len();
    let (mut q, mut before, mut a) = (vec![10.0; n], vec![-3.0; n], vec![-gravity; n]);
    (q[0], before[0], a[0]) = (RADIUS - depth, -speed, 1e6 * depth - gravity);
    let mut after = before.clone();
    after[0] = 0.0;
    model.separation(&before, [&q, &after, &a], h, h)
}

#[test]
fn a_ball_that_is_stopped_would_fly_for_two_speeds_over_the_weight() {
    let h = 1e-2;
    for masses in [&[1.0][..], &[1e-6], &[1.0, 1e6], &[1e-3, 1e6]] {
        let found = separation(masses, 2.0, 1e-3, 9.81, h);
        assert!((found.flight * 9.81 * h / 4.0 - 1.0).abs() < 1e-9, "{masses:?}: {found:?}");
        assert!((found.impact * 1e3 / PI - 1.0).abs() < 1e-9, "{masses:?}: {found:?}");
    }
    assert_eq!(separation(&[1.0], 2.0, 1e-3, 0.0, h).flight, f64::INFINITY);
    // Ten steps of this size follow the impact.
    assert_eq!(separation(&[1.0], 2.0, 1e-3, 9.81, 3e-4).flight, 0.0);
}

#[test]
fn what_rests_does_not_part_and_what_is_pressed_does() {
    let (gravity, h) = (9.81, 1e-2);
    let mut model = balls(&[(1.0, 1e6)], gravity);
    let mut from = |depth: f64, speed: f64| {
        let (q, v, a) = ([RADIUS - depth], [speed], [1e6 * depth - gravity]);
        model.separation(&v, [&q, &v, &a], 0.0, h).flight
    };
    let at_rest = gravity / 1e6;
    assert_eq!(from(at_rest, 0.0), 0.0);
    // It swings about its rest.
    assert_eq!(from(at_rest, 5e-3), 0.0);
    // u^2 = v^2 + (omega^2 d - 2 g) d
    let (depth, speed) = (1e-3, 0.3);
    let leaving = (speed * speed + (1e6 * depth - 2.0 * gravity) * depth).sqrt();
    assert!((from(depth, speed) * gravity * h / (2.0 * leaving) - 1.0).abs() < 1e-9);
}
