//! Inverse dynamics, tangents, forward dynamics and Newmark steps of rods: `cargo bench --bench rod`.
//!
//! `kernels`: rods of 3 to 36 coordinates. `scaling`: rods with many segments or modes. `machine`:
//! multiply-add throughput of this machine. `benches/python/speed/suite.py` creates tables from the results.

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use lissom::linalg::Matrix;
use lissom::model::{Dynamics, ForwardScratch};
use lissom::newmark;
use lissom::robot::{RobotModel, Rod, Solve};
use lissom::rod::Segment;
use pulp::Simd;

/// Steps of Newmark's method from the rod at rest, and their size in seconds.
const STEPS: usize = 100;
const STEP: f64 = 1e-2;

/// Rods with 3 (planar), 12, 18, 24 and 36 coordinates (spatial, two segments).
fn rods() -> Vec<(&'static str, Rod)> {
    let soft =
        |modes| Segment { modes, retardation_time: 0.01, ..Segment::straight(0.3, 0.01, 1e6, 4e5, 1000.0) };
    let lab = Segment {
        modes: [0, 3, 0, 0, 0, 0],
        retardation_time: 1e-4,
        ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0)
    };
    let two = |modes| Rod::new(vec![soft(modes), soft(modes)]);
    vec![
        ("lab-3", Rod::new(vec![lab])),
        ("two-12", two([2, 2, 2, 0, 0, 0])),
        ("two-18", two([2, 2, 2, 1, 1, 1])),
        ("two-24", two([2, 2, 2, 2, 2, 2])),
        ("two-36", two([3, 3, 3, 3, 3, 3])),
    ]
}

/// One metre of soft rod in `segments` segments, each with `modes` modes of torsion and of both bends.
fn chain(segments: usize, modes: usize) -> Rod {
    let segment = Segment {
        modes: [modes, modes, modes, 0, 0, 0],
        retardation_time: 0.01,
        ..Segment::straight(1.0 / segments as f64, 0.01, 1e6, 4e5, 1000.0)
    };
    Rod::new(vec![segment; segments])
}

/// A residual at a new state, and a tangent at a known one.
fn sweeps(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, rod: &Rod) {
    let mut model = RobotModel::of_rod(rod).unwrap();
    let n = model.facts().n;
    let (mut q, qd, qdd) = (vec![0.1; n], vec![0.2; n], vec![0.3; n]);
    let mut tau = vec![0.0; n];
    let mut tangent = Matrix::zeros(n, n);
    let mut flip = 1.0;
    group.bench_function(format!("residual of {name}"), |bencher| {
        bencher.iter(|| {
            // A new state in every iteration, because the model caches the last one.
            flip = -flip;
            q[0] = 0.1 + 0.01 * flip;
            model.inverse_dynamics(black_box(&q), &qd, &qdd, &mut tau);
        });
    });
    // The form of the tangent that a step uses.
    let mut chain = model.tree().map(|chain| chain.tangent);
    group.bench_function(format!("tangent of {name}"), |bencher| {
        bencher.iter(|| {
            let (q, weights) = (black_box(&q), [1e-4, 1e-2, 1.0]);
            match &mut chain {
                Some(chain) => model.tree_tangent(q, &qd, &qdd, weights, chain),
                None => model.weighted_tangent(q, &qd, &qdd, weights, &mut tangent),
            }
        });
    });
}

fn forward(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, rod: &Rod) {
    let mut model = RobotModel::of_rod(rod).unwrap();
    let n = model.facts().n;
    let (mut q, qd, mut qdd, mut scratch) =
        (vec![0.1; n], vec![0.2; n], vec![0.0; n], ForwardScratch::of(&model));
    let mut flip = 1.0;
    group.bench_function(format!("forward dynamics of {name}"), |bencher| {
        bencher.iter(|| {
            flip = -flip;
            q[0] = 0.1 + 0.01 * flip;
            model.forward_dynamics(black_box(&q), &qd, &mut qdd, &mut scratch).unwrap();
        });
    });
}

/// The first steps of a rod released from rest; later steps, near rest, are cheaper.
fn newmark_steps(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, mut model: RobotModel, steps: usize) {
    let rest = vec![0.0; model.facts().n];
    let options = newmark::Options::new(STEP);
    let t_span = (0.0, steps as f64 * STEP);
    group.throughput(Throughput::Elements(steps as u64));
    group.bench_function(format!("{steps} Newmark steps of {name}"), |bencher| {
        bencher.iter(|| {
            let mut stepper = newmark::Stepper::new(rest.len(), t_span, &rest, &rest, &options).unwrap();
            while stepper.step(&mut model).unwrap().is_none() {}
            black_box(stepper.q()[0])
        });
    });
}

fn kernels(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("kernels");
    for (name, rod) in rods() {
        sweeps(&mut group, name, &rod);
        forward(&mut group, name, &rod);
        newmark_steps(&mut group, name, RobotModel::of_rod(&rod).unwrap(), STEPS);
    }
    group.finish();
}

/// Numbers of segments in powers of two; modes up to a large number of quadrature nodes.
fn scaling(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("scaling");
    for segments in [1, 2, 4, 8, 16, 32, 64, 128] {
        let (rod, name) = (chain(segments, 1), format!("{segments} segments"));
        sweeps(&mut group, &name, &rod);
        newmark_steps(&mut group, &name, RobotModel::of_rod(&rod).unwrap(), STEPS / 10);
        let dense = RobotModel::with_solve(&(&rod).into(), Solve::Dense).unwrap();
        newmark_steps(&mut group, &format!("{name}, dense"), dense, STEPS / 10);
    }
    for modes in [1, 2, 3, 4, 6, 8, 12, 16] {
        let (rod, name) = (chain(1, modes), format!("{modes} modes"));
        sweeps(&mut group, &name, &rod);
        newmark_steps(&mut group, &name, RobotModel::of_rod(&rod).unwrap(), STEPS / 10);
    }
    group.finish();
}

/// Independent chains of multiply-adds: enough of them to hide the latency of two units with registers of any width.
const CHAINS: usize = 12;
const LINKS: usize = 1000;

struct MultiplyAdds;

impl pulp::WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        // Each chain tends to addend / (1 - factor): no overflow, no denormal numbers.
        let factor = simd.splat_f64s(black_box(0.5));
        let addend = simd.splat_f64s(black_box(1.0));
        let mut chains: [_; CHAINS] = std::array::from_fn(|i| simd.splat_f64s(i as f64));
        for _ in 0..LINKS {
            for chain in &mut chains {
                *chain = simd.mul_add_e_f64s(*chain, factor, addend);
            }
        }
        chains.into_iter().map(|chain| simd.reduce_sum_f64s(chain)).sum()
    }
}

/// Number of lanes in the registers that the sweeps use.
struct Width;

impl pulp::WithSimd for Width {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F64_LANES
    }
}

fn machine(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("machine");
    let arch = pulp::Arch::new();
    let width = arch.dispatch(Width);
    group.throughput(Throughput::Elements((CHAINS * LINKS * width) as u64));
    group.bench_function(format!("multiply-adds of {width} doubles"), |bencher| {
        bencher.iter(|| arch.dispatch(black_box(MultiplyAdds)));
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1)).sample_size(30);
    targets = machine, kernels, scaling
}
criterion_main!(benches);
