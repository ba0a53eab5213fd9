//! Fixed cases whose instructions are counted: `python benches/python/instructions.py`.
//!
//! `instructions CASE COUNT` evaluates a case COUNT times; the difference of two counts is the cost of the
//! case alone.

use std::hint::black_box;

use lissom::actuator::{Actuator, Along, Drive, Part, Tendon};
use lissom::contact::{Contact, HalfSpace, Obstacle, Surface};
use lissom::linalg::{Matrix, TreeLu};
use lissom::loops::{Loop, LoopEnd, Tie};
use lissom::model::{Dynamics, ForwardScratch, Model, Tree};
use lissom::newmark;
use lissom::ode::{self, FirstOrder};
use lissom::pendulum::SpringPendulum;
use lissom::radau;
use lissom::robot::{Robot, RobotModel, Rod};
use lissom::rod::{Profile, Segment};
use lissom::simulate::{Method, simulate};

/// The lab's rod: three coordinates in a plane.
fn lab() -> RobotModel {
    let segment = Segment {
        modes: [0, 3, 0, 0, 0, 0],
        retardation_time: 1e-4,
        ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0)
    };
    RobotModel::of_rod(&Rod::new(vec![segment])).expect("a valid rod")
}

/// [`two_segments`], compiled.
fn two(modes: [usize; 6], tendons: usize) -> RobotModel {
    RobotModel::of_rod(&two_segments(modes, tendons)).expect("a valid rod")
}

/// Two soft segments whose tip hangs on a bar.
fn on_a_bar() -> RobotModel {
    let end = |link, position| LoopEnd { link, at: None, position, orientation: [1.0, 0.0, 0.0, 0.0] };
    let (length, [x, y, z]) = (0.2, [0.6, 0.0, 0.0]);
    let ends = [end(Some(0), [0.0; 3]), end(None, [x, y, z + length])];
    let loops = vec![Loop { name: "bar".to_owned(), tie: Tie::Distance { ends, length } }];
    let robot = Robot::from(&two_segments([2, 2, 2, 0, 0, 0], 0));
    RobotModel::new(&Robot { loops, ..robot }).expect("a valid robot")
}

/// Two soft segments far above a floor.
fn above_a_floor() -> RobotModel {
    let floor = Obstacle::HalfSpace(HalfSpace { point: [0.0, 0.0, -10.0], normal: [0.0, 0.0, 1.0] });
    let contact = Contact::between("floor", [Surface::Rod { link: 0 }, Surface::Obstacle(floor)]);
    let robot = Robot::from(&two_segments([2, 2, 2, 0, 0, 0], 0));
    RobotModel::new(&Robot { contacts: vec![contact], ..robot }).expect("a valid robot")
}

/// Two soft spatial segments with `modes` each, and `tendons` tendons along both.
fn two_segments(modes: [usize; 6], tendons: usize) -> Rod {
    let segment = Segment { modes, retardation_time: 0.01, ..Segment::straight(0.3, 0.01, 1e6, 4e5, 1000.0) };
    let tendon = |i: usize| {
        let angle = i as f64;
        let offset = [0.008 * angle.cos(), 0.008 * angle.sin()].map(Profile::from);
        Actuator::Tendon(Tendon {
            name: format!("tendon {i}"),
            path: vec![Part::Along(Along { link: 0, offset, along: [0.0, 0.6] })],
            drive: Drive::Tension([0.5].into()),
            friction: 0.0,
            friction_velocity: 1e-3,
            sliding: None,
        })
    };
    let actuators = (0..tendons).map(tendon).collect();
    Rod { actuators, ..Rod::new(vec![segment; 2]) }
}

/// A chain of `segments` soft spatial segments, each with two modes per bending direction.
fn chain(segments: &str) -> RobotModel {
    let segment = Segment {
        modes: [0, 1, 1, 0, 0, 0],
        retardation_time: 0.01,
        ..Segment::straight(0.1, 0.01, 1e6, 4e5, 1000.0)
    };
    let segments = vec![segment; segments.parse().expect("a number of segments")];
    RobotModel::of_rod(&Rod::new(segments)).expect("a valid rod")
}

fn rod(name: &str) -> RobotModel {
    if let Some(segments) = name.strip_prefix("chain-") {
        return chain(segments);
    }
    match name {
        "lab-3" => lab(),
        "two-12" => two([2, 2, 2, 0, 0, 0], 0),
        "two-12-tendon" => two([2, 2, 2, 0, 0, 0], 1),
        "two-12-tendons" => two([2, 2, 2, 0, 0, 0], 4),
        "two-12-loop" => on_a_bar(),
        "two-12-floor" => above_a_floor(),
        "two-36" => two([3; 6], 0),
        _ => panic!("no rod is called {name}"),
    }
}

/// The shape of evaluation `i`; shapes differ, so that no cached result is reused.
fn shape(n: usize, i: usize) -> Vec<f64> {
    let mut q = vec![0.1; n];
    q[0] += 0.01 * (i % 2) as f64;
    q
}

fn residual(model: &mut RobotModel, count: usize) {
    let n = model.facts().n;
    let (qd, qdd, mut tau) = (vec![0.2; n], vec![0.3; n], vec![0.0; n]);
    let shapes = [shape(n, 0), shape(n, 1)];
    for i in 0..count {
        model.inverse_dynamics(black_box(&shapes[i % 2]), &qd, &qdd, &mut tau);
    }
}

fn tangent(model: &mut RobotModel, count: usize) {
    let n = model.facts().n;
    let (q, qd, qdd, mut tangent) = (shape(n, 0), vec![0.2; n], vec![0.3; n], Matrix::zeros(n, n));
    for _ in 0..count {
        model.weighted_tangent(black_box(&q), &qd, &qdd, [1e-4, 1e-2, 1.0], &mut tangent);
    }
}

fn forward(model: &mut RobotModel, count: usize) {
    let n = model.facts().n;
    let (qd, mut qdd, mut scratch) = (vec![0.2; n], vec![0.0; n], ForwardScratch::of(model));
    let shapes = [shape(n, 0), shape(n, 1)];
    for i in 0..count {
        model
            .forward_dynamics(black_box(&shapes[i % 2]), &qd, &mut qdd, &mut scratch)
            .expect("a regular mass");
    }
}

/// A Newton iteration that evaluates a new Jacobian.
fn newton(model: &mut RobotModel, count: usize) {
    let n = model.facts().n;
    let (qd, qdd, mut tau) = (vec![0.2; n], vec![0.3; n], vec![0.0; n]);
    let shapes = [shape(n, 0), shape(n, 1)];
    let Tree { mut tangent, .. } = model.tree().expect("a chain");
    let mut lu = TreeLu::new(&tangent);
    for i in 0..count {
        let q = &shapes[i % 2];
        model.inverse_dynamics(black_box(q), &qd, &qdd, &mut tau);
        model.tree_tangent(q, &qd, &qdd, [1e-4, 1e-2, 1.0], &mut tangent);
        lu.factorise(&tangent).expect("a regular tangent");
        lu.solve(&mut tau);
    }
}

fn newmark_steps<M: Model>(model: &mut M, q0: &[f64], count: usize) {
    let v0 = vec![0.0; q0.len()];
    let options = newmark::Options::new(1e-2);
    let mut stepper = newmark::Stepper::new(q0.len(), (0.0, 1e9), q0, &v0, &options).expect("valid options");
    for _ in 0..count {
        stepper.step(model).expect("nothing interrupts");
    }
}

/// A complete run of `count` steps, including recording and checks.
fn run<M: Model>(model: M, q0: &[f64], count: usize) {
    let zeros = vec![0.0; q0.len()];
    let mut options = newmark::Options::new(1e-2);
    if model.facts().constraints() > 0 {
        // Closed loops need a method that damps.
        options.scheme = newmark::Scheme::generalised_alpha(0.8).expect("a valid radius");
    }
    let method = Method::Newmark(options);
    let span = (0.0, 1e-2 * count as f64);
    simulate(model, span, q0, &zeros, &method, None, &mut |_| Ok(())).expect("a valid run");
}

fn radau_steps(model: &mut RobotModel, count: usize) {
    let zeros = vec![0.0; model.facts().n];
    let options = radau::Options { rtol: 1e-6.into(), atol: 1e-9.into(), ..radau::Options::default() };
    let mut stepper =
        radau::Stepper::new(zeros.len(), (0.0, 1e9), &zeros, &zeros, &options).expect("valid options");
    for _ in 0..count {
        stepper.step(model).expect("nothing interrupts");
    }
}

fn first_order_steps<M: Model>(method: ode::Method, model: M, q0: &[f64], count: usize) {
    let y0 = [q0, &vec![0.0; q0.len()]].concat();
    let options = ode::Options { method, rtol: 1e-6.into(), atol: 1e-9.into(), ..ode::Options::default() };
    let mut stepper = ode::Stepper::new(y0.len(), (0.0, 1e9), &y0, &options).expect("valid options");
    let mut system = FirstOrder::new(model);
    for _ in 0..count {
        stepper.step(&mut system).expect("nothing interrupts");
    }
}

fn main() {
    // `cargo bench` adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let [case, count] = &arguments[..] else { return };
    let count: usize = count.parse().expect("a number of repetitions");
    let (kind, name) = case.split_once('/').expect("a case such as residual/lab-3");
    let pendulum_start = [-0.785, 0.5];
    match (kind, name) {
        ("residual", _) => residual(&mut rod(name), count),
        ("tangent", _) => tangent(&mut rod(name), count),
        ("newton", _) => newton(&mut rod(name), count),
        ("forward", _) => forward(&mut rod(name), count),
        ("newmark", "pendulum") => newmark_steps(&mut SpringPendulum::default(), &pendulum_start, count),
        ("rk45", "pendulum") => {
            first_order_steps(ode::Method::Rk45, SpringPendulum::default(), &pendulum_start, count);
        }
        ("newmark", _) => {
            let mut model = rod(name);
            let q0 = vec![0.0; model.facts().n];
            newmark_steps(&mut model, &q0, count);
        }
        ("simulate", "pendulum") => run(SpringPendulum::default(), &pendulum_start, count),
        ("simulate", _) => {
            let model = rod(name);
            let q0 = vec![0.0; model.facts().n];
            run(model, &q0, count);
        }
        ("radau", _) => radau_steps(&mut rod(name), count),
        ("rk45" | "radau of first order", _) => {
            let model = rod(name);
            let q0 = vec![0.0; model.facts().n];
            let method = if kind == "rk45" { ode::Method::Rk45 } else { ode::Method::Radau };
            first_order_steps(method, model, &q0, count);
        }
        _ => panic!("no case is called {case}"),
    }
}
