//! Robots: chains, stars and trees of rigid links, and a hand of soft fingers: `cargo bench --bench robot`.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use lissom::body::Body;
use lissom::joint::{Joint, JointForces};
use lissom::linalg::{Lu, Matrix};
use lissom::model::Dynamics;
use lissom::newmark;
use lissom::robot::{Link, Robot, RobotModel, Solve};
use lissom::rod::Segment;

/// The weights of a Newmark step of a millisecond.
const WEIGHTS: [f64; 3] = [2.5e-7, 5e-4, 1.0];

const STEP: f64 = 1e-3;

const SOLVES: [(Solve, &str); 2] = [(Solve::Tree, "by links"), (Solve::Dense, "densely")];

/// Revolute joints about x, y and z in turn, with links of a decimetre; `parent` gives the parent of each
/// link.
fn rigid(links: usize, parent: impl Fn(usize) -> Option<usize>) -> Robot {
    let link = |i: usize| Link {
        parent: parent(i),
        position: [if i == 0 { 0.0 } else { 0.1 }, 0.0, 0.0],
        joint: Joint::Revolute {
            axis: std::array::from_fn(|axis| f64::from(u8::from(axis == i % 3))),
            forces: JointForces::default(),
        },
        body: Some(Body {
            centre: [0.05, 0.01, 0.0],
            inertia: [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]],
            ..Body::point(0.1)
        }),
        ..Link::new(format!("link{i}"))
    };
    Robot::new((0..links).map(link).collect())
}

fn chain(links: usize) -> Robot {
    rigid(links, |i| i.checked_sub(1))
}

fn star(links: usize) -> Robot {
    rigid(links, |i| (i > 0).then_some(0))
}

fn tree(links: usize) -> Robot {
    rigid(links, |i| i.checked_sub(1).map(|before| before / 2))
}

/// A chain with an additional rigid link welded behind each joint, or with an additional body there.
fn chain_with_welds(links: usize, body: Option<&Body>) -> Robot {
    let mut robot = chain(links);
    robot.links.extend((0..links).map(|i| Link {
        parent: Some(i),
        position: [0.02, 0.0, 0.03],
        body: body.cloned(),
        ..Link::new(format!("welded{i}"))
    }));
    robot
}

/// A palm on a rail and a hinge, with five soft fingers of `modes` modes per bending direction.
fn hand(modes: usize) -> Robot {
    let finger = Segment {
        modes: [0, modes, modes, 0, 0, 0],
        retardation_time: 0.01,
        ..Segment::straight(0.1, 0.008, 1e6, 4e5, 1000.0)
    };
    let mut robot = rigid(2, |i| i.checked_sub(1));
    for i in 0..5 {
        robot.links.push(Link {
            parent: Some(1),
            position: [0.05, 0.02 * (f64::from(i) - 2.0), 0.0],
            rod: vec![finger.clone()],
            ..Link::new(format!("finger{i}"))
        });
    }
    robot
}

fn cases() -> Vec<(String, RobotModel)> {
    let mut robots: Vec<(String, Robot)> = Vec::new();
    for (name, make) in [("chain", chain as fn(usize) -> Robot), ("star", star), ("tree", tree)] {
        robots.extend([1, 4, 16, 64, 128].map(|n| (format!("{name}/{n}"), make(n))));
    }
    robots.extend([7, 30, 100].map(|n| (format!("chain/{n}"), chain(n))));
    robots.push(("chain and frames/30".to_owned(), chain_with_welds(30, None)));
    robots.push(("chain and bodies/30".to_owned(), chain_with_welds(30, Some(&Body::point(0.02)))));
    robots.push(("hand/62".to_owned(), hand(6)));
    robots.into_iter().map(|(name, robot)| (name, RobotModel::new(&robot).unwrap())).collect()
}

/// The robots with both solves.
fn by_solve() -> Vec<(String, RobotModel)> {
    let mut robots: Vec<(String, Robot)> = Vec::new();
    for (name, make) in [("chain", chain as fn(usize) -> Robot), ("star", star), ("tree", tree)] {
        robots.extend([7, 12, 20, 30, 64].map(|n| (format!("{name}/{n}"), make(n))));
    }
    robots.extend([1, 2, 4, 6].map(|modes| (format!("hand/{}", 2 + 10 * modes), hand(modes))));
    for (fingers, modes) in [(1, 6), (1, 18), (2, 6), (2, 12), (2, 18), (3, 6), (3, 12)] {
        let mut robot = hand(modes);
        robot.links.truncate(2 + fingers);
        robots.push((format!("{fingers} fingers/{}", 2 * modes), robot));
    }
    let with = |name: &str, robot: &Robot, (solve, by): (Solve, &str)| {
        (format!("{name}/{by}"), RobotModel::with_solve(robot, solve).unwrap())
    };
    robots.iter().flat_map(|(name, robot)| SOLVES.map(|solve| with(name, robot, solve))).collect()
}

fn state(n: usize) -> [Vec<f64>; 3] {
    [0.1, 0.2, 0.3].map(|size| (0..n).map(|k| size * (k as f64).sin()).collect())
}

fn residual(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("residual");
    for (name, mut model) in cases() {
        let n = model.facts().n;
        let ([mut q, qd, qdd], mut tau) = (state(n), vec![0.0; n]);
        group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
            bencher.iter(|| {
                // A new state in every iteration, because the model caches the last one.
                q[0] = 0.21 - q[0];
                model.inverse_dynamics(black_box(&q), &qd, &qdd, &mut tau);
            });
        });
    }
}

fn tangent(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("tangent at a known state");
    for (name, mut model) in cases() {
        let n = model.facts().n;
        let ([q, qd, qdd], mut tangent) = (state(n), Matrix::zeros(n, n));
        group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
            bencher.iter(|| model.weighted_tangent(black_box(&q), &qd, &qdd, WEIGHTS, &mut tangent));
        });
    }
}

fn solve(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("factorisation and solution");
    for (name, mut model) in cases() {
        let n = model.facts().n;
        let ([q, qd, qdd], mut tangent) = (state(n), Matrix::zeros(n, n));
        model.weighted_tangent(&q, &qd, &qdd, WEIGHTS, &mut tangent);
        let (mut lu, mut x) = (Lu::new(n), vec![1.0; n]);
        group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
            bencher.iter(|| {
                x.fill(1.0);
                lu.factorise(black_box(&tangent)).unwrap();
                lu.solve(&mut x);
            });
        });
    }
}

/// A hundred steps of Newmark's method, from rest.
fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("hundred steps");
    group.sample_size(20);
    for (name, mut model) in cases().into_iter().chain(by_solve()) {
        let n = model.facts().n;
        let ([q, _, _], v) = (state(n), vec![0.0; n]);
        let options = newmark::Options { rtol: 1e-6.into(), ..newmark::Options::new(STEP) };
        group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
            bencher.iter(|| {
                let mut stepper = newmark::Stepper::new(n, (0.0, 1.0), &q, &v, &options).unwrap();
                for _ in 0..100 {
                    stepper.step(&mut model).unwrap();
                }
                stepper.q()[0]
            });
        });
    }
}

criterion_group!(benches, residual, tangent, solve, steps);
criterion_main!(benches);
