//! Newton's method: cost of an iteration without the residual, and savings of a reused Jacobian.
//!
//! `cargo bench --bench roots`

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use lissom::error::Interrupted;
use lissom::linalg::Matrix;
use lissom::roots::{Derivative, Method, Newton, NonlinearSystem, Options, Reuse};

/// The discrete integral equation of Moré, Garbow and Hillstrom (1981): a dense Jacobian close to the identity.
struct IntegralEquation {
    grid: Vec<f64>,
}

impl IntegralEquation {
    fn new(n: usize) -> Self {
        Self { grid: (1..=n).map(|i| i as f64 / (n + 1) as f64).collect() }
    }

    fn start(&self) -> Vec<f64> {
        self.grid.iter().map(|t| t * (t - 1.0)).collect()
    }

    fn kernel(&self, i: usize, j: usize) -> f64 {
        let (t, s) = (self.grid[i], self.grid[j]);
        let green = if s <= t { (1.0 - t) * s } else { t * (1.0 - s) };
        green / (2 * (self.grid.len() + 1)) as f64
    }
}

impl NonlinearSystem for IntegralEquation {
    fn unknowns(&self) -> usize {
        self.grid.len()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        for i in 0..x.len() {
            let load: f64 =
                (0..x.len()).map(|j| self.kernel(i, j) * (x[j] + self.grid[j] + 1.0).powi(3)).sum();
            residual[i] = x[i] + load;
        }
        Ok(())
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        for j in 0..x.len() {
            let slope = 3.0 * (x[j] + self.grid[j] + 1.0).powi(2);
            for i in 0..x.len() {
                jacobian[(i, j)] = self.kernel(i, j) * slope + if i == j { 1.0 } else { 0.0 };
            }
        }
        Ok(())
    }
}

fn solve(criterion: &mut Criterion) {
    let variants = [
        ("newton, analytic", Options::default()),
        ("newton, forward", Options { derivative: Derivative::Forward, ..Options::default() }),
        ("newton, analytic, kept Jacobian", Options { reuse: Reuse::WithinSolve, ..Options::default() }),
        (
            "newton, analytic, Jacobian kept across solves",
            Options { reuse: Reuse::AcrossSolves, ..Options::default() },
        ),
        ("line search, analytic", Options { method: Method::LineSearch, ..Options::default() }),
        ("trust region, analytic", Options { method: Method::TrustRegion, ..Options::default() }),
    ];
    for n in [3, 24] {
        let mut group = criterion.benchmark_group(format!("integral equation, {n} unknowns"));
        let mut system = IntegralEquation::new(n);
        let start = system.start();
        let mut residual = vec![0.0; n];
        group.bench_function("one residual", |bencher| {
            bencher.iter(|| system.residual(black_box(&start), &mut residual));
        });
        for (name, options) in &variants {
            let mut newton = Newton::new(n, n);
            let mut x = start.clone();
            group.bench_function(*name, |bencher| {
                bencher.iter(|| {
                    x.copy_from_slice(black_box(&start));
                    newton.solve(&mut system, &mut x, &Options { residual_tolerance: 1e-10, ..*options })
                });
            });
        }
    }
}

criterion_group!(benches, solve);
criterion_main!(benches);
