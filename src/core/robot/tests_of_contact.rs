//! Forces of contact and their derivatives, compared with finite differences and the energy balance.

use super::description::{Link, Robot};
use super::model::RobotModel;
use crate::description::body::Body;
use crate::description::joint::{Joint, JointForces};
use crate::description::rod::{Section, Segment};
use crate::description::schema::{Layers, PerAxis, Rows};
use crate::model::{Dynamics as _, InContact as _, InImpact as _};
use crate::numerics::lie::Vector;
use crate::numerics::linalg::Matrix;
use crate::robot::effects::contact::{
    Capsule, Contact, ConvexMesh, Cuboid, DistanceGrid, HalfSpace, HeightField, Obstacle, Sphere, Stiffness,
    Surface,
};

/// Two thick rods and a floating body, one behind the other.
fn links() -> Vec<Link> {
    let rod = |length| Segment {
        modes: [1, 2, 2, 1, 1, 1],
        section: Section::circle([0.06, 0.04]),
        ..Segment::straight(length, 0.05, 1e6, 4e5, 1000.0)
    };
    let hinge = Joint::Revolute { axis: [1.0, 2.0, 3.0], forces: JointForces::default() };
    let body = Body { inertia: [[2e-3, 0.0, 0.0], [0.0, 3e-3, 0.0], [0.0, 0.0, 2.5e-3]], ..Body::point(0.3) };
    vec![
        Link {
            rod: vec![rod(0.5), rod(0.3)],
            joint: Joint::Spherical,
            orientation: [0.6, 0.0, 0.8, 0.0],
            ..Link::new("arm")
        },
        Link { rod: vec![rod(0.4)], parent: Some(0), at: Some(0.2), joint: hinge, ..Link::new("leg") },
        Link { body: Some(body), position: [0.2, 0.1, 0.0], joint: Joint::Free, ..Link::new("block") },
    ]
}

fn state(n: usize, phase: f64) -> Vec<f64> {
    (0..n).map(|k| 0.3 * (1.7 * k as f64 + phase).cos()).collect()
}

fn with(surfaces: [Surface; 2], friction: [f64; 3]) -> RobotModel {
    let stiffness = Some(Stiffness::Given(500.0));
    let contact = Contact {
        stiffness,
        friction,
        dissipation: 0.2,
        slip_velocity: 0.05,
        patch_radius: 0.004,
        ..Contact::between("contact", surfaces)
    };
    RobotModel::new(&Robot { contacts: vec![contact], ..Robot::new(links()) }).unwrap()
}

fn bare_model() -> RobotModel {
    RobotModel::new(&Robot::new(links())).unwrap()
}

/// A sphere with bumps by distances on a grid.
fn grid([x, y, z]: [f64; 3]) -> Obstacle {
    const NUMBER: usize = 25;
    const SPACING: f64 = 0.01;
    let value = |n: usize| {
        let [a, b, c] =
            [n / (NUMBER * NUMBER), n / NUMBER % NUMBER, n % NUMBER].map(|i| (i as f64 - 12.0) * SPACING);
        (a * a + b * b + c * c).sqrt() - 0.06 + 0.004 * (40.0 * a).sin() * (35.0 * b + 20.0 * c).cos()
    };
    Obstacle::DistanceGrid(DistanceGrid {
        values: Layers { numbers: (0..NUMBER.pow(3)).map(value).collect(), shape: [NUMBER; 3] },
        spacing: PerAxis([SPACING; 3]),
        corner: [x - 0.12, y - 0.12, z - 0.12],
        orientation: [1.0, 0.0, 0.0, 0.0],
    })
}

/// A ball on the body, and the surfaces that it and the arm touch in the tested state.
fn pairs() -> Vec<(&'static str, [Surface; 2], f64)> {
    let mut bare = bare_model();
    let q = state(bare.facts().n, 0.1);
    let mut at = |link, x| {
        let place = bare.place_on(link, x);
        bare.pose_at(&q, &place).position.to_array()
    };
    let beside = |[x, y, z]: [f64; 3], by: [f64; 3]| [x + by[0], y + by[1], z + by[2]];
    let arm = || Surface::Rod { link: 0 };
    let [middle, block, on_leg] = [at(0, Some(0.35)), at(2, None), at(1, Some(0.25))];
    let ball = |radius| Surface::Ball { link: 2, at: None, position: [0.02, -0.01, 0.03], radius };
    let reach = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    let floor = |point| Obstacle::HalfSpace(HalfSpace { point, normal: [0.1, -0.3, 1.0] });
    let cuboid = |centre| {
        Obstacle::Cuboid(Cuboid { centre, half_extents: [0.05; 3], orientation: [0.8, 0.6, 0.0, 0.0] })
    };
    vec![
        ("arm on floor", [arm(), Surface::Obstacle(floor(middle))], 1e-5),
        (
            "arm on ball",
            [
                arm(),
                Surface::Obstacle(Obstacle::Sphere(Sphere {
                    centre: beside(middle, [0.05, 0.02, -0.04]),
                    radius: 0.06,
                })),
            ],
            1e-4,
        ),
        (
            "arm on capsule",
            [
                arm(),
                Surface::Obstacle(Obstacle::Capsule(Capsule {
                    start: beside(middle, [0.05, -0.3, -0.06]),
                    end: beside(middle, [0.03, 0.4, 0.0]),
                    radius: 0.05,
                })),
            ],
            1e-4,
        ),
        ("ball on box", [ball(0.1), Surface::Obstacle(cuboid(beside(block, [0.09, 0.02, 0.0])))], 1e-7),
        (
            "ball on ball",
            [
                ball(0.1),
                Surface::Obstacle(Obstacle::Sphere(Sphere {
                    centre: beside(block, [0.1, 0.0, 0.05]),
                    radius: 0.08,
                })),
            ],
            1e-7,
        ),
        ("arm on grid", [arm(), Surface::Obstacle(grid(beside(middle, [0.05, 0.02, -0.04])))], 1e-4),
        ("ball on grid", [ball(0.1), Surface::Obstacle(grid(beside(block, [0.1, 0.0, 0.05])))], 1e-6),
        ("ball on arm", [ball(0.9 * reach(block, middle)), arm()], 1e-4),
        (
            "ball on another",
            [
                ball(1.1 * reach(block, on_leg)),
                Surface::Ball { link: 1, at: Some(0.25), position: [0.0, 0.01, 0.0], radius: 0.05 },
            ],
            1e-7,
        ),
    ]
    .into_iter()
    .chain(pairs_with_solids(&mut bare, &q))
    .collect()
}

/// Solids on links, and the surfaces that they touch in that state.
fn pairs_with_solids(bare: &mut RobotModel, q: &[f64]) -> Vec<(&'static str, [Surface; 2], f64)> {
    let mut relative_to = |link, at, point: [f64; 3]| {
        let place = bare.place_on(link, at);
        let pose = bare.pose_at(q, &place);
        pose.rotation.apply_transposed(Vector::from(point) - pose.position).to_array()
    };
    let mut at = {
        let mut bare = bare_model();
        move |link, x, by: [f64; 3]| {
            let place = bare.place_on(link, x);
            (bare.pose_at(q, &place).position + Vector::from(by)).to_array()
        }
    };
    let arm = || Surface::Rod { link: 0 };
    let beside_arm = at(0, Some(0.35), [0.05, 0.02, -0.04]);
    let on_block = |shape| Surface::Solid { link: 2, at: None, shape };
    let on_leg = |shape| Surface::Solid { link: 1, at: Some(0.25), shape };
    let cuboid = |centre| {
        Obstacle::Cuboid(Cuboid {
            centre,
            half_extents: [0.05, 0.06, 0.04],
            orientation: [0.8, 0.6, 0.0, 0.0],
        })
    };
    let above = at(0, Some(0.35), [0.02, 0.01, 0.03]);
    let start = at(0, Some(0.35), [0.05, -0.3, -0.06]);
    let end = at(0, Some(0.35), [0.03, 0.4, 0.0]);
    let beside_leg = at(1, Some(0.25), [0.09, 0.02, 0.0]);
    let [under_block, below] = [-0.03, -0.09].map(|z| at(2, None, [0.0, 0.0, z]));
    let half_space = |point| Obstacle::HalfSpace(HalfSpace { point, normal: [0.1, -0.3, 1.0] });
    let ball = Surface::Ball { link: 2, at: None, position: [0.02, -0.01, 0.03], radius: 0.1 };
    vec![
        (
            "arm on sphere of block",
            [
                arm(),
                on_block(Obstacle::Sphere(Sphere { centre: relative_to(2, None, beside_arm), radius: 0.06 })),
            ],
            1e-4,
        ),
        ("arm on half-space of block", [arm(), on_block(half_space(relative_to(2, None, above)))], 1e-4),
        (
            "capsule of block on arm",
            [
                on_block(Obstacle::Capsule(Capsule {
                    start: relative_to(2, None, start),
                    end: relative_to(2, None, end),
                    radius: 0.05,
                })),
                arm(),
            ],
            1e-4,
        ),
        (
            "ball on box of leg",
            [
                Surface::Ball { link: 2, at: None, position: relative_to(2, None, beside_leg), radius: 0.07 },
                on_leg(cuboid([0.0; 3])),
            ],
            1e-7,
        ),
        ("box of leg on ball", [on_leg(cuboid(relative_to(1, Some(0.25), below))), ball], 1e-7),
        (
            "box of block on half-space of leg",
            [on_block(cuboid([0.0; 3])), on_leg(half_space(relative_to(1, Some(0.25), under_block)))],
            1e-7,
        ),
        (
            "box of block on floor",
            [on_block(cuboid([0.0; 3])), Surface::Obstacle(half_space(under_block))],
            1e-7,
        ),
        (
            "box of block on sphere",
            [
                on_block(cuboid([0.0; 3])),
                Surface::Obstacle(Obstacle::Sphere(Sphere { centre: below, radius: 0.06 })),
            ],
            1e-7,
        ),
    ]
}

/// A lower bound for half the thickness of the bodies below.
const THICKNESS: f64 = 0.2;

/// Bodies beside the block, moved along a direction until the deepest overlap is a hundredth of that
/// thickness.
fn pairs_of_bodies() -> Vec<(&'static str, [Surface; 2], f64)> {
    let mut bare = bare_model();
    let q = state(bare.facts().n, 0.1);
    let mut pose_of = |link, at| {
        let place = bare.place_on(link, at);
        bare.pose_at(&q, &place)
    };
    let poses = [pose_of(2, None), pose_of(1, Some(0.25))];
    let on_block = |shape| Surface::Solid { link: 2, at: None, shape };
    let turned = [0.8, 0.36, -0.48, 0.0];
    let cuboid =
        |centre| Obstacle::Cuboid(Cuboid { centre, half_extents: [0.2, 0.3, 0.25], orientation: turned });
    let long = |centre| {
        Obstacle::Cuboid(Cuboid {
            centre,
            half_extents: [0.9, 0.2, 0.3],
            orientation: [0.6, 0.0, 0.64, -0.48],
        })
    };
    let capsule = |[x, y, z]: [f64; 3]| {
        Obstacle::Capsule(Capsule {
            start: [x - 0.1, y + 0.5, z - 0.2],
            end: [x + 0.2, y - 0.6, z + 0.3],
            radius: 0.2,
        })
    };
    let tetrahedron = |[x, y, z]: [f64; 3]| {
        Obstacle::ConvexMesh(ConvexMesh {
            points: [[-0.9, -0.7, -0.6], [1.1, -0.4, -0.5], [0.1, 0.9, -0.7], [0.2, 0.1, 1.2]]
                .map(|[a, b, c]| [x + a, y + b, z + c])
                .to_vec(),
            faces: vec![[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            radius: 0.0,
        })
    };
    let field = |[x, y, z]: [f64; 3]| {
        Obstacle::HeightField(HeightField {
            heights: Rows {
                numbers: (0..36).map(|k| 0.1 * (1.3 * f64::from(k)).sin()).collect(),
                shape: [6, 6],
            },
            spacing: PerAxis([0.5, 0.5]),
            corner: [x - 1.3, y - 1.2, z - 0.1],
            orientation: [1.0, 0.0, 0.0, 0.0],
        })
    };
    type Shape<'a> = &'a dyn Fn([f64; 3]) -> Obstacle;
    let kinds: [(&'static str, Shape<'_>, Shape<'_>, [f64; 3]); 9] = [
        ("box and box, a corner", &cuboid, &cuboid, [0.4, -1.0, 0.3]),
        ("box and long box", &cuboid, &long, [0.1, 0.3, -1.0]),
        ("long box and box", &long, &cuboid, [-0.2, 1.0, 0.5]),
        ("box and capsule", &cuboid, &capsule, [0.3, 0.2, -1.0]),
        ("capsule and capsule", &capsule, &capsule, [1.0, 0.2, 0.1]),
        ("capsule and long box", &capsule, &long, [0.1, 0.1, -1.0]),
        ("tetrahedron and box", &tetrahedron, &cuboid, [0.2, -0.6, -1.0]),
        ("tetrahedra", &tetrahedron, &tetrahedron, [1.0, 0.3, 0.2]),
        ("box and hills", &cuboid, &field, [0.0, 0.0, -1.0]),
    ];
    let mut found = Vec::new();
    for (name, own, other, direction) in kinds {
        let direction = Vector::from(direction);
        for moves in [false, true] {
            let surfaces = |way: f64| {
                let place = poses[0].position + direction * way;
                let second = if moves {
                    let there = poses[1].rotation.apply_transposed(place - poses[1].position);
                    Surface::Solid { link: 1, at: Some(0.25), shape: other(there.to_array()) }
                } else {
                    Surface::Obstacle(other(place.to_array()))
                };
                [on_block(own([0.0; 3])), second]
            };
            let deepest = |way: f64| {
                let touches = with(surfaces(way), [0.0; 3]).touches(&q, &vec![0.0; q.len()]);
                touches.iter().map(|touch| touch.overlap).fold(0.0, f64::max)
            };
            let [mut near, mut far] = [0.0, 4.0];
            for _ in 0..50 {
                let middle = 0.5 * (near + far);
                if deepest(middle) > 0.01 * THICKNESS { near = middle } else { far = middle }
            }
            found.push((name, surfaces(far), 1e-6));
        }
    }
    found
}

#[test]
fn tangents_are_derivatives_and_power_is_accounted_for() {
    for (name, surfaces, tolerance) in pairs().into_iter().chain(pairs_of_bodies()) {
        for friction in [[0.0; 3], [0.5; 3], [0.2, 0.7, 1.1]] {
            let is_rod = matches!(surfaces[0], Surface::Rod { .. });
            if !is_rod && friction[0] != friction[2] {
                continue;
            }
            let mut model = with(surfaces.clone(), friction);
            let mut bare = RobotModel::new(&Robot::new(links())).unwrap();
            let n = model.facts().n;
            let [q, v, a] = [0.1, 1.3, 2.9].map(|phase| state(n, phase));
            let mut contact = |q: &[f64], v: &[f64]| {
                let [mut with, mut without] = [vec![0.0; n], vec![0.0; n]];
                model.inverse_dynamics(q, v, &a, &mut with);
                bare.inverse_dynamics(q, v, &a, &mut without);
                with.iter().zip(&without).map(|(with, without)| with - without).collect::<Vec<f64>>()
            };
            let here = contact(&q, &v);
            let size = here.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            assert!(size > 1e-3, "{name}: no contact");
            let weights = [0.3, 0.05, 1.0];
            let h = 1e-6;
            let differences: Vec<Vec<f64>> = (0..n)
                .map(|k| {
                    let mut shifted = |h: f64| {
                        let (mut q, mut v) = (q.clone(), v.clone());
                        q[k] += h * weights[0];
                        v[k] += h * weights[1];
                        contact(&q, &v)
                    };
                    let (plus, minus) = (shifted(h), shifted(-h));
                    plus.iter().zip(minus).map(|(plus, minus)| (plus - minus) / (2.0 * h)).collect()
                })
                .collect();
            let [mut tangent, mut without] = [Matrix::zeros(n, n), Matrix::zeros(n, n)];
            model.weighted_tangent(&q, &v, &a, weights, &mut tangent);
            bare.weighted_tangent(&q, &v, &a, weights, &mut without);
            tangent -= without;
            let size = tangent.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            let mut worst = 0.0_f64;
            for (k, column) in differences.iter().enumerate() {
                for (j, difference) in column.iter().enumerate() {
                    worst = worst.max((tangent[(j, k)] - difference).abs());
                }
            }
            assert!(worst < tolerance * size, "{name} {friction:?}: {worst} of {size}");
            // The power of the motion against contact is stored or dissipated.
            let power: f64 = here.iter().zip(&v).map(|(tau, v)| tau * v).sum();
            let at = |h: f64| q.iter().zip(&v).map(|(q, v)| q + h * v).collect::<Vec<f64>>();
            let mut stored = |q: &[f64]| model.energy(q, &v).elastic - bare.energy(q, &v).elastic;
            let rate = (stored(&at(h)) - stored(&at(-h))) / (2.0 * h);
            let lost = model.dissipated_power(&q, &v) - bare.dissipated_power(&q, &v);
            assert!(lost >= 0.0);
            let error = (power - rate - lost).abs() / (power.abs() + rate.abs());
            assert!(error < tolerance, "{name} {friction:?}: {power} {rate} {lost}");
        }
    }
}

/// Coordinates of parts that contact forces push are those on which forces act only with contact.
#[test]
fn pushed_parts_are_those_whose_forces_change() {
    for (name, surfaces, _) in pairs() {
        let mut model = with(surfaces, [0.3; 3]);
        let n = model.facts().n;
        let [q, qd, at_rest] = [state(n, 0.1), state(n, 0.7), vec![0.0; n]];
        let [mut with, mut without] = [vec![0.0; n], vec![0.0; n]];
        model.leave_contact(true);
        model.inverse_dynamics(&q, &qd, &at_rest, &mut without);
        model.leave_contact(false);
        model.inverse_dynamics(&q, &qd, &at_rest, &mut with);
        let mut marks = vec![false; n];
        model.mark_pushed([&q, &qd], &mut marks);
        let mut first = 0;
        for &size in &model.facts().parts {
            let part = first..first + size;
            first += size;
            assert_eq!(marks[part.clone()].contains(&true), with[part.clone()] != without[part], "{name}");
        }
        assert!(marks.contains(&true), "{name}");
    }
}
