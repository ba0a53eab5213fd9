//! Scaling with the number of segments, with block and dense solves: `cargo bench --bench chain`.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use lissom::linalg::{Lu, Matrix, TreeLu};
use lissom::model::{Dynamics, Tree};
use lissom::newmark;
use lissom::robot::{RobotModel, Rod, Solve};
use lissom::rod::Segment;

const SEGMENTS: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
const SOLVES: [(Solve, &str); 2] = [(Solve::Tree, "chain"), (Solve::Dense, "dense")];

/// The weights of a Newmark step of 10 ms.
const WEIGHTS: [f64; 3] = [2.5e-5, 5e-3, 1.0];

/// Soft spatial segments, each with two modes per bending direction.
fn rod(segments: usize, solve: Solve) -> RobotModel {
    let segment = Segment {
        modes: [0, 1, 1, 0, 0, 0],
        retardation_time: 0.01,
        ..Segment::straight(0.1, 0.01, 1e6, 4e5, 1000.0)
    };
    RobotModel::with_solve(&(&Rod::new(vec![segment; segments])).into(), solve).unwrap()
}

fn residual(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("residual");
    for segments in SEGMENTS {
        let mut model = rod(segments, Solve::Tree);
        let n = model.facts().n;
        let (mut q, qd, qdd, mut tau) = (vec![0.1; n], vec![0.2; n], vec![0.3; n], vec![0.0; n]);
        group.bench_function(BenchmarkId::from_parameter(segments), |bencher| {
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
    for (segments, (solve, name)) in cases() {
        let mut model = rod(segments, solve);
        let n = model.facts().n;
        let (q, qd, qdd) = (vec![0.1; n], vec![0.2; n], vec![0.3; n]);
        let Tree { tangent: mut chain, .. } = rod(segments, Solve::Tree).tree().unwrap();
        let mut dense = Matrix::zeros(n, n);
        group.bench_function(BenchmarkId::new(name, segments), |bencher| {
            bencher.iter(|| match solve {
                Solve::Tree => model.tree_tangent(black_box(&q), &qd, &qdd, WEIGHTS, &mut chain),
                Solve::Dense => model.weighted_tangent(black_box(&q), &qd, &qdd, WEIGHTS, &mut dense),
            });
        });
    }
}

fn solve(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("factorisation and solution");
    for (segments, (solve, name)) in cases() {
        let mut model = rod(segments, Solve::Tree);
        let n = model.facts().n;
        let Tree { tangent: mut chain, .. } = model.tree().unwrap();
        model.tree_tangent(&vec![0.1; n], &vec![0.2; n], &vec![0.3; n], WEIGHTS, &mut chain);
        let dense = chain.to_dense();
        let (mut chain_lu, mut lu) = (TreeLu::new(&chain), Lu::new(n));
        let mut x = vec![1.0; n];
        group.bench_function(BenchmarkId::new(name, segments), |bencher| {
            bencher.iter(|| {
                x.fill(1.0);
                match solve {
                    Solve::Tree => {
                        chain_lu.factorise(black_box(&chain)).unwrap();
                        chain_lu.solve(&mut x);
                    }
                    Solve::Dense => {
                        lu.factorise(black_box(&dense)).unwrap();
                        lu.solve(&mut x);
                    }
                }
            });
        });
    }
}

fn step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("Newmark step");
    for (segments, (solve, name)) in cases() {
        let mut model = rod(segments, solve);
        let zero = vec![0.0; model.facts().n];
        let options = newmark::Options::new(1e-3);
        let mut stepper = newmark::Stepper::new(zero.len(), (0.0, 1e9), &zero, &zero, &options).unwrap();
        stepper.start(&mut model).unwrap();
        group.bench_function(BenchmarkId::new(name, segments), |bencher| {
            bencher.iter(|| stepper.step(&mut model).unwrap());
        });
    }
}

fn cases() -> impl Iterator<Item = (usize, (Solve, &'static str))> {
    SEGMENTS.into_iter().flat_map(|segments| SOLVES.map(|solve| (segments, solve)))
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(200)).measurement_time(std::time::Duration::from_millis(700)).sample_size(10);
    targets = residual, tangent, solve, step
}
criterion_main!(benches);
