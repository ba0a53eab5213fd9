//! Small dense systems, factorised and solved by lissom, nalgebra and faer: `cargo bench --bench dense`.
//!
//! The crossings of the curves are the constants `SMALL` of `src/core/numerics/linalg/lu.rs` and `cholesky.rs`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt;
use faer::linalg::lu::partial_pivoting as lu;
use faer::perm::PermRef;
use faer::{Conj, MatMut, MatRef, Par};
use lissom::linalg::{Matrix, small_cholesky, small_lu};

const SIZES: [usize; 13] = [2, 3, 4, 6, 8, 12, 16, 20, 24, 32, 36, 48, 64];

/// A symmetric positive definite matrix that is not close to diagonal.
fn matrix(n: usize) -> Matrix {
    Matrix::from_fn(n, n, |i, j| {
        1.0 / (1.0 + i.abs_diff(j) as f64) + if i == j { 1.0 + 0.1 * i as f64 } else { 0.0 }
    })
}

/// The matrix with its rows in reverse order, so that pivoting is needed.
fn reversed(n: usize) -> Matrix {
    let matrix = matrix(n);
    Matrix::from_fn(n, n, |i, j| matrix[(n - 1 - i, j)])
}

fn view(a: &Matrix) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(a.as_slice(), a.nrows(), a.ncols())
}

fn view_mut(a: &mut Matrix) -> MatMut<'_, f64> {
    let n = a.nrows();
    MatMut::from_column_major_slice_mut(a.as_mut_slice(), n, n)
}

fn lu_factorisations(criterion: &mut Criterion) {
    for n in SIZES {
        let (a, b) = (reversed(n), vec![1.0; n]);
        let (mut factors, mut x, mut pivots) = (a.clone(), b.clone(), vec![0; n]);
        criterion.bench_function(&format!("LU lissom/{n}"), |bencher| {
            bencher.iter(|| {
                factors.copy_from(black_box(&a));
                x.copy_from_slice(&b);
                small_lu::factorise(factors.as_mut_slice(), &mut pivots).unwrap();
                small_lu::solve(factors.as_slice(), &pivots, &mut x);
            });
        });
        criterion.bench_function(&format!("LU nalgebra/{n}"), |bencher| {
            bencher.iter(|| {
                // Allocates: nalgebra's decomposition owns its matrix.
                let factors = black_box(&a).clone().lu();
                x.copy_from_slice(&b);
                factors.solve_mut(&mut nalgebra::DVectorViewMut::from_slice(&mut x, n));
            });
        });
        let mut memory = MemBuffer::new(StackReq::any_of(&[
            lu::factor::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default()),
            lu::solve::solve_in_place_scratch::<usize, f64>(n, 1, Par::Seq),
        ]));
        let (mut rows, mut rows_inverse) = (vec![0usize; n], vec![0usize; n]);
        criterion.bench_function(&format!("LU faer/{n}"), |bencher| {
            bencher.iter(|| {
                factors.copy_from(black_box(&a));
                x.copy_from_slice(&b);
                lu::factor::lu_in_place(
                    view_mut(&mut factors),
                    &mut rows,
                    &mut rows_inverse,
                    Par::Seq,
                    MemStack::new(&mut memory),
                    Default::default(),
                );
                lu::solve::solve_in_place_with_conj(
                    view(&factors),
                    view(&factors),
                    PermRef::new_checked(&rows, &rows_inverse, n),
                    Conj::No,
                    MatMut::from_column_major_slice_mut(&mut x, n, 1),
                    Par::Seq,
                    MemStack::new(&mut memory),
                );
            });
        });
    }
}

fn cholesky_factorisations(criterion: &mut Criterion) {
    for n in SIZES {
        let (a, b) = (matrix(n), vec![1.0; n]);
        let (mut factors, mut x) = (a.clone(), b.clone());
        criterion.bench_function(&format!("Cholesky lissom/{n}"), |bencher| {
            bencher.iter(|| {
                factors.copy_from(black_box(&a));
                x.copy_from_slice(&b);
                small_cholesky::factorise(factors.as_mut_slice(), n).unwrap();
                small_cholesky::solve(factors.as_slice(), &mut x);
            });
        });
        let mut kept = Some(a.clone());
        criterion.bench_function(&format!("Cholesky nalgebra/{n}"), |bencher| {
            bencher.iter(|| {
                let mut matrix = kept.take().unwrap();
                matrix.copy_from(black_box(&a));
                x.copy_from_slice(&b);
                let factors = nalgebra::Cholesky::new(matrix).unwrap();
                factors.solve_mut(&mut nalgebra::DVectorViewMut::from_slice(&mut x, n));
                kept = Some(factors.unpack_dirty());
            });
        });
        let mut memory = MemBuffer::new(StackReq::any_of(&[
            llt::factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()),
            llt::solve::solve_in_place_scratch::<f64>(n, 1, Par::Seq),
        ]));
        criterion.bench_function(&format!("Cholesky faer/{n}"), |bencher| {
            bencher.iter(|| {
                factors.copy_from(black_box(&a));
                x.copy_from_slice(&b);
                llt::factor::cholesky_in_place(
                    view_mut(&mut factors),
                    Default::default(),
                    Par::Seq,
                    MemStack::new(&mut memory),
                    Default::default(),
                )
                .unwrap();
                llt::solve::solve_in_place_with_conj(
                    view(&factors),
                    Conj::No,
                    MatMut::from_column_major_slice_mut(&mut x, n, 1),
                    Par::Seq,
                    MemStack::new(&mut memory),
                );
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(100)).measurement_time(std::time::Duration::from_millis(300)).sample_size(20);
    targets = lu_factorisations, cholesky_factorisations
}
criterion_main!(benches);
