//! Steps do not allocate: all memory is allocated before the first one.
#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use lissom::body::Body;
use lissom::fluid::Fluid;
use lissom::linalg::{Matrix, TreeLu};
use lissom::load::{Extent, Frame, Load};
use lissom::model::{Dynamics, ForwardScratch, InTime as _, Tree};
use lissom::newmark;
use lissom::ode::{self, FirstOrder};
use lissom::radau;
use lissom::robot::{RobotModel, Rod};
use lissom::rod::Segment;
use lissom::signal::{Harmonic, Signal};
use lissom::stepping::{Method, Run};
use lissom::support::Support;
use lissom::world::BaseMotion;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: all calls are forwarded to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(run: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    run();
    ALLOCATIONS.with(Cell::get) - before
}

/// Planar and spatial rods of one and several segments, with few and many coordinates, and long chains; with
/// loads and masses at the tip and inside segments.
fn models() -> Vec<RobotModel> {
    let segment =
        |modes| Segment { modes, retardation_time: 0.01, ..Segment::straight(0.3, 0.01, 1e6, 4e5, 1e3) };
    let rods = [
        vec![segment([0, 3, 0, 0, 0, 0])],
        vec![segment([0, 0, 2, 1, 1, 0]); 3],
        vec![segment([2, 2, 2, 0, 0, 0]); 2],
        vec![segment([3, 3, 3, 3, 3, 3]); 2],
        vec![segment([0, 2, 0, 0, 0, 0]); 12],
        vec![segment([1, 1, 1, 1, 1, 1]); 6],
    ];
    let load = |extent, frame| Load {
        link: 0,
        extent,
        frame,
        force: [0.0, 0.0, 0.1].into(),
        moment: Signal::default(),
    };
    let swing = Signal::Harmonic(Harmonic { amplitude: [0.1; 3], frequency: 2.0, ..Harmonic::zero() });
    rods.into_iter()
        .flat_map(|segments| {
            let tip = Rod { tip_mass: 0.01, tip_force: [0.1; 3], ..Rod::new(segments) };
            let inside = Rod {
                loads: vec![
                    load(Extent::At(0.1), Frame::Body),
                    load(Extent::Along([0.0, 0.2]), Frame::World),
                ],
                bodies: vec![Body { at: Some(0.15), ..Body::point(0.01) }],
                ..tip.clone()
            };
            let varying = Rod {
                loads: vec![Load { force: swing.clone(), ..load(Extent::Along([0.1, 0.2]), Frame::World) }],
                base_motion: Some(BaseMotion { translation: swing.clone(), ..BaseMotion::rest() }),
                supports: vec![Support { stiffness: [1.0; 3], damping: [0.1; 3], ..Support::at_tip() }],
                fluid: Some(Fluid { drag_coefficients: [1.2, 0.01], ..Fluid::ideal(1000.0) }),
                ..tip.clone()
            };
            [tip, inside, varying]
        })
        .map(|rod| RobotModel::of_rod(&rod).unwrap())
        .collect()
}

#[test]
fn counting_works() {
    assert_eq!(allocations(|| drop(vec![0.0; 100])), 1);
}

#[test]
fn sweeps_allocate_nothing() {
    for mut model in models() {
        let n = model.facts().n;
        let (q, qd, qdd) = (vec![0.1; n], vec![0.2; n], vec![0.3; n]);
        let mut tau = vec![0.0; n];
        let mut tangent = Matrix::zeros(n, n);
        let mut scratch = ForwardScratch::of(&model);
        let count = allocations(|| {
            model.set_time(0.3).unwrap();
            model.inverse_dynamics(&q, &qd, &qdd, &mut tau);
            model.weighted_tangent(&q, &qd, &qdd, [1e-4, 1e-2, 1.0], &mut tangent);
            model.mass_matrix(&qd, &mut tangent);
            model.energy(&q, &qd);
            model.forward_dynamics(&qdd, &qd, &mut tau, &mut scratch).unwrap();
        });
        assert_eq!(count, 0, "{n} coordinates");
    }
}

#[test]
fn chains_allocate_nothing() {
    let mut chains = 0;
    for mut model in models() {
        let Some(Tree { mut tangent, mut mass }) = model.tree() else { continue };
        chains += 1;
        let n = model.facts().n;
        model.set_time(0.0).unwrap();
        let (q, qd, qdd) = (vec![0.1; n], vec![0.2; n], vec![0.3; n]);
        let mut x = vec![1.0; n];
        for mass_only in [false, true] {
            let matrix = if mass_only { &mut mass } else { &mut tangent };
            let mut lu = TreeLu::new(matrix);
            let count = allocations(|| {
                if mass_only {
                    model.tree_mass_matrix(&q, matrix);
                } else {
                    model.tree_tangent(&q, &qd, &qdd, [1e-4, 1e-2, 1.0], matrix);
                }
                lu.factorise(matrix).unwrap();
                lu.solve(&mut x);
            });
            assert_eq!(count, 0, "{n} coordinates");
        }
    }
    assert_eq!(chains, 6);
}

#[test]
fn implicit_steps_allocate_nothing() {
    for mut model in models() {
        let n = model.facts().n;
        let zeros = vec![0.0; n];
        for options in [
            newmark::Options::new(1e-3),
            newmark::Options {
                step_size: newmark::StepSize::Adaptive { max_step: f64::INFINITY, min_step: 0.0 },
                ..newmark::Options::new(1e-3)
            },
        ] {
            let mut stepper = newmark::Stepper::new(n, (0.0, 10.0), &zeros, &zeros, &options).unwrap();
            stepper.start(&mut model).unwrap();
            stepper.step(&mut model).unwrap();
            let count = allocations(|| {
                for _ in 0..50 {
                    stepper.step(&mut model).unwrap();
                }
            });
            assert_eq!((count, stepper.counters().steps), (0, 51), "{n} coordinates");
        }
    }
}

#[test]
fn radau_steps_allocate_nothing() {
    for mut model in models() {
        let n = model.facts().n;
        let zeros = vec![0.0; n];
        let options = radau::Options { rtol: 1e-3.into(), atol: 1e-5.into(), ..radau::Options::default() };
        let mut stepper = radau::Stepper::new(n, (0.0, 10.0), &zeros, &zeros, &options).unwrap();
        stepper.start(&mut model).unwrap();
        stepper.step(&mut model).unwrap();
        let count = allocations(|| {
            for _ in 0..20 {
                stepper.step(&mut model).unwrap();
            }
        });
        assert_eq!((count, stepper.counters().steps), (0, 21), "{n} coordinates");
    }
}

#[test]
fn steps_of_first_order_allocate_nothing() {
    for model in models() {
        let zeros = vec![0.0; 2 * model.facts().n];
        let mut system = FirstOrder::new(model);
        for method in [ode::Method::Rk45, ode::Method::Dop853, ode::Method::Radau] {
            let options = ode::Options { method, ..ode::Options::default() };
            let mut stepper = ode::Stepper::new(zeros.len(), (0.0, 10.0), &zeros, &options).unwrap();
            stepper.step(&mut system).unwrap();
            let count = allocations(|| {
                for _ in 0..20 {
                    stepper.step(&mut system).unwrap();
                }
            });
            assert_eq!(count, 0, "{method:?}, {} equations", zeros.len());
        }
    }
}

#[test]
fn runs_that_are_stepped_from_outside_allocate_nothing() {
    let dt = 1e-3;
    let methods = [
        Method::Newmark(newmark::Options::new(dt)),
        Method::Radau {
            options: radau::Options { rtol: 1e-3.into(), ..radau::Options::default() },
            dt,
            returns_steps: false,
        },
        Method::FirstOrder { options: ode::Options::default(), dt, returns_steps: false },
    ];
    for model in models() {
        let n = model.facts().n;
        let zeros = vec![0.0; n];
        for method in &methods {
            let mut run = Run::new(model.clone(), (0.0, dt), &zeros, &zeros, method).unwrap();
            let inputs = run.inputs().to_vec();
            let mut interval = |duration| {
                let end = run.end_of(duration).unwrap();
                run.set_inputs(&inputs);
                run.begin_interval(end);
                run.finish(&mut |_| Ok(())).unwrap()
            };
            interval(None);
            let count = allocations(|| {
                for duration in [None, None, Some(2.0 * dt), Some(1.5 * dt), None] {
                    assert!(interval(duration).is_success());
                }
            });
            assert_eq!(count, 0, "{n} coordinates, {method:?}");
        }
    }
}
