//! Inverse dynamics, tangent and forward dynamics of rods: `cargo bench --bench rod`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use lissom::linalg::Matrix;
use lissom::model::{ForwardScratch, Model};
use lissom::rod::{Rod, RodModel, Segment};

/// Rods with 3 (planar), 12, 18, 24 and 36 coordinates (spatial, two segments).
fn rods() -> Vec<(&'static str, RodModel)> {
    let soft =
        |modes| Segment { modes, retardation_time: 0.01, ..Segment::straight(0.3, 0.01, 1e6, 4e5, 1000.0) };
    let lab = Segment {
        modes: [0, 3, 0, 0, 0, 0],
        retardation_time: 1e-4,
        ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0)
    };
    let two = |modes| RodModel::new(&Rod::new(vec![soft(modes), soft(modes)])).unwrap();
    vec![
        ("lab3", RodModel::new(&Rod::new(vec![lab])).unwrap()),
        ("two12", two([2, 2, 2, 0, 0, 0])),
        ("two18", two([2, 2, 2, 1, 1, 1])),
        ("two24", two([2, 2, 2, 2, 2, 2])),
        ("two36", two([3, 3, 3, 3, 3, 3])),
    ]
}

fn sweeps(criterion: &mut Criterion) {
    for (name, mut model) in rods() {
        let n = model.n();
        let (mut q, qd, qdd) = (vec![0.1; n], vec![0.2; n], vec![0.3; n]);
        let mut tau = vec![0.0; n];
        let mut tangent = Matrix::zeros(n, n);
        let mut flip = 1.0;
        criterion.bench_function(&format!("inverse dynamics/{name}"), |bencher| {
            bencher.iter(|| {
                // A new state each time: the model remembers the last one.
                flip = -flip;
                q[0] = 0.1 + 0.01 * flip;
                model.inverse_dynamics(black_box(&q), &qd, &qdd, &mut tau);
            });
        });
        criterion.bench_function(&format!("tangent at a known state/{name}"), |bencher| {
            bencher
                .iter(|| model.weighted_tangent(black_box(&q), &qd, &qdd, [1e-4, 1e-2, 1.0], &mut tangent));
        });
        let mut scratch = ForwardScratch::new(n);
        criterion.bench_function(&format!("forward dynamics/{name}"), |bencher| {
            bencher.iter(|| {
                flip = -flip;
                q[0] = 0.1 + 0.01 * flip;
                model.forward_dynamics(black_box(&q), &qd, &mut tau, &mut scratch).unwrap();
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(300)).measurement_time(std::time::Duration::from_secs(1)).sample_size(30);
    targets = sweeps
}
criterion_main!(benches);
