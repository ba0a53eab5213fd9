//! LU factorisation of matrices in which most pairs of blocks of unknowns are not coupled: a sparse block LU factorisation.
//!
//! The coupled blocks are found from the entries of each matrix. Blocks are eliminated in an order with little fill-in
//! ([`Elimination`]); neighbours in this order with the same couplings form a front and are eliminated together. With the diagonal
//! block D of a front, its rows R and columns C in the remaining unknowns, and the remaining matrix S,
//!
//! ```text
//! W = D^-1 R,        S <- S - C W
//! ```
//!
//! Rows are exchanged within blocks, never between them. Therefore the matrix is scaled to a diagonal of ones on both sides.
//! Of one that is symmetric and positive definite no entry of S is then larger than one; of any matrix the error is small as long as
//! no entry of the factors is large (Demmel, Higham and Schreiber 1995). Where one is, or where sparse elimination saves little,
//! the matrix is factorised with all its entries and pivots ([`Lu`]).

use std::ops::Range;

use dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::linalg::matmul::matmul;
use faer::perm::PermRef;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Conj, MatMut, MatRef, Par};

use super::elimination::Elimination;
use super::{Lu, Matrix, Singular, view, view_mut};

/// Sparse elimination is used if it takes at most this fraction of the multiplications of dense elimination: multiplications of
/// small blocks are slower.
const WORTHWHILE: f64 = 0.3;

/// Largest accepted entry of the factors of a scaled matrix: rounding errors are at most its square times those with pivots from
/// all rows.
const LARGEST_FACTOR: f64 = 1e4;

/// Unknowns that are eliminated together, as one dense block.
#[derive(Clone, Debug)]
struct Front {
    /// Their places in the order of elimination.
    own: Range<usize>,
    /// Places of the coupled unknowns, in [`BlockLu::coupled`].
    coupled: Range<usize>,
}

/// A factorisation with memory for repeated use for one division into blocks.
pub struct BlockLu {
    /// The first unknown of each block, and the number of all.
    firsts: Vec<usize>,
    elimination: Elimination,
    /// For each unknown, its place in the order of elimination, and its scale: one over the root of its diagonal entry.
    places: Vec<usize>,
    scales: Vec<f64>,
    fronts: Vec<Front>,
    coupled: Vec<Range<usize>>,
    /// In the order of elimination: factors of D, C, and W in place of R. Only coupled entries are used.
    factors: Matrix,
    row_permutation: Vec<usize>,
    row_permutation_inverse: Vec<usize>,
    x: Vec<f64>,
    memory: MemBuffer,
    /// The dense factorisation, once it was needed, and whether solutions use it.
    dense: Option<Box<Lu>>,
    is_dense: bool,
}

impl std::fmt::Debug for BlockLu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BlockLu").field("firsts", &self.firsts).finish_non_exhaustive()
    }
}

impl Clone for BlockLu {
    fn clone(&self) -> Self {
        Self {
            firsts: self.firsts.clone(),
            elimination: self.elimination.clone(),
            places: self.places.clone(),
            scales: self.scales.clone(),
            fronts: self.fronts.clone(),
            coupled: self.coupled.clone(),
            factors: self.factors.clone(),
            row_permutation: self.row_permutation.clone(),
            row_permutation_inverse: self.row_permutation_inverse.clone(),
            x: self.x.clone(),
            memory: memory(self.x.len()),
            dense: self.dense.clone(),
            is_dense: self.is_dense,
        }
    }
}

/// Work memory of faer for fronts of any size.
fn memory(n: usize) -> MemBuffer {
    MemBuffer::new(StackReq::any_of(&[
        factor::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default()),
        solve::solve_in_place_scratch::<usize, f64>(n, n, Par::Seq),
    ]))
}

impl BlockLu {
    /// Memory for matrices whose unknowns are divided into blocks of these sizes.
    pub fn new(sizes: &[usize]) -> Self {
        let n = sizes.iter().sum();
        let mut firsts = vec![0];
        firsts.extend(sizes.iter().scan(0, |first, size| {
            *first += size;
            Some(*first)
        }));
        Self {
            firsts,
            elimination: Elimination::new(sizes),
            places: vec![0; n],
            scales: vec![0.0; n],
            fronts: Vec::with_capacity(sizes.len()),
            coupled: Vec::new(),
            factors: Matrix::zeros(n, n),
            row_permutation: vec![0; n],
            row_permutation_inverse: vec![0; n],
            x: vec![0.0; n],
            memory: memory(n),
            dense: None,
            is_dense: false,
        }
    }

    /// Factorises `a` (n x n). Cost: n^2 comparisons, and m^3/3 + m^2 c + m c^2 multiplications for each block of m unknowns that is
    /// coupled with c later ones.
    pub fn factorise(&mut self, a: &Matrix) -> Result<(), Singular> {
        let n = self.x.len();
        self.find_coupled(a);
        let all = (n as f64).powi(3) / 3.0;
        self.is_dense = self.elimination.find_order() > WORTHWHILE * all || !self.eliminate(a);
        if self.is_dense {
            return self.dense.get_or_insert_with(|| Box::new(Lu::new(n))).factorise(a);
        }
        Ok(())
    }

    /// Solves `A x = b` in place.
    pub fn solve(&mut self, b: &mut [f64]) {
        if let Some(dense) = self.dense.as_mut().filter(|_| self.is_dense) {
            return dense.solve(b);
        }
        let Self { places, scales, x, .. } = self;
        for ((&place, scale), b) in places.iter().zip(&*scales).zip(&*b) {
            x[place] = b * scale;
        }
        self.solve_scaled();
        for ((&place, scale), b) in self.places.iter().zip(&self.scales).zip(b) {
            *b = self.x[place] * scale;
        }
    }

    fn block(&self, i: usize) -> Range<usize> {
        self.firsts[i]..self.firsts[i + 1]
    }

    /// Finds the coupled blocks. Entries that are not finite count as couplings.
    fn find_coupled(&mut self, a: &Matrix) {
        let blocks = self.firsts.len() - 1;
        self.elimination.clear();
        for j in 0..blocks {
            for column in
                a.as_slice()[self.firsts[j] * a.nrows()..].chunks_exact(a.nrows()).take(self.block(j).len())
            {
                for i in (0..blocks).filter(|&i| i != j) {
                    // Shifting out the sign bit makes 0.0 and -0.0 equal to zero.
                    let bits = column[self.block(i)].iter().fold(0, |bits, x| bits | x.to_bits() << 1);
                    if bits != 0 {
                        self.elimination.couple(i, j);
                    }
                }
            }
        }
    }

    /// Factorises with pivots within blocks; returns whether the factors are small enough.
    fn eliminate(&mut self, a: &Matrix) -> bool {
        for (i, scale) in self.scales.iter_mut().enumerate() {
            *scale = 1.0 / a[(i, i)].sqrt();
        }
        if !self.scales.iter().all(|scale| scale.is_finite() && *scale > 0.0) {
            return false;
        }
        self.arrange();
        self.copy(a);
        (0..self.fronts.len()).all(|front| self.eliminate_front(front))
    }

    /// Finds the fronts, and the place of each unknown in the order of elimination.
    fn arrange(&mut self) {
        let Self { firsts, elimination, places, fronts, coupled, .. } = self;
        let order = elimination.order();
        fronts.clear();
        coupled.clear();
        let mut begin = 0;
        let mut own = 0..0;
        for (k, &i) in order.iter().enumerate() {
            let block = firsts[i]..firsts[i + 1];
            for (place, unknown) in (own.end..).zip(block.clone()) {
                places[unknown] = place;
            }
            own.end += block.len();
            if order.get(k + 1).is_some_and(|&next| elimination.is_continued_by(i, next)) {
                continue;
            }
            let mut place = own.end;
            for &j in &order[k + 1..] {
                let size = firsts[j + 1] - firsts[j];
                if elimination.are_coupled(i, j) {
                    match coupled[begin..].last_mut() {
                        Some(last) if last.end == place => last.end += size,
                        _ => coupled.push(place..place + size),
                    }
                }
                place += size;
            }
            fronts.push(Front { own: own.clone(), coupled: begin..coupled.len() });
            begin = coupled.len();
            own = own.end..own.end;
        }
    }

    /// Copies the coupled blocks of the scaled matrix.
    fn copy(&mut self, a: &Matrix) {
        for (k, &i) in self.elimination.order().iter().enumerate() {
            let rows = self.firsts[i]..self.firsts[i + 1];
            for &j in &self.elimination.order()[k..] {
                if i != j && !self.elimination.are_coupled(i, j) {
                    continue;
                }
                let columns = self.firsts[j]..self.firsts[j + 1];
                for (rows, columns) in [(rows.clone(), columns.clone()), (columns, rows.clone())] {
                    for column in columns {
                        let scale = self.scales[column];
                        let place = self.places[column];
                        let from = a.as_slice()[column * a.nrows()..][rows.clone()].iter();
                        let to =
                            &mut self.factors.as_mut_slice()[place * a.nrows() + self.places[rows.start]..];
                        for ((to, from), of_row) in to.iter_mut().zip(from).zip(&self.scales[rows.clone()]) {
                            *to = from * scale * of_row;
                        }
                    }
                    if i == j {
                        break;
                    }
                }
            }
        }
    }

    /// Eliminates a front; returns whether its factors are small enough.
    fn eliminate_front(&mut self, front: usize) -> bool {
        let Front { own, coupled } = self.fronts[front].clone();
        let coupled = &self.coupled[coupled];
        let end = own.end;
        let (before, right, below, mut rest) = view_mut(&mut self.factors).split_at_mut(end, end);
        let mut pivots = before.submatrix_mut(own.start, own.start, own.len(), own.len());
        let mut right = right.subrows_mut(own.start, own.len());
        let mut below = below.subcols_mut(own.start, own.len());
        let permutation = &mut self.row_permutation[own.clone()];
        let inverse = &mut self.row_permutation_inverse[own.clone()];
        let memory = MemStack::new(&mut self.memory);
        if !is_moderate(pivots.rb()) {
            return false;
        }
        factor::lu_in_place(pivots.rb_mut(), permutation, inverse, Par::Seq, memory, Default::default());
        if !(0..own.len()).all(|i| pivots[(i, i)].abs() > 0.0) {
            return false;
        }
        for run in coupled {
            let row = right.rb_mut().subcols_mut(run.start - end, run.len());
            let permutation = PermRef::new_checked(permutation, inverse, own.len());
            solve::solve_in_place_with_conj(
                pivots.rb(),
                pivots.rb(),
                permutation,
                Conj::No,
                row,
                Par::Seq,
                memory,
            );
            if !is_moderate(right.rb().subcols(run.start - end, run.len()))
                || !is_moderate(below.rb_mut().subrows(run.start - end, run.len()))
            {
                return false;
            }
        }
        for columns in coupled {
            for rows in coupled {
                let rest = rest.rb_mut().submatrix_mut(
                    rows.start - end,
                    columns.start - end,
                    rows.len(),
                    columns.len(),
                );
                let below = below.rb().subrows(rows.start - end, rows.len());
                let right = right.rb().subcols(columns.start - end, columns.len());
                matmul(rest, Accum::Add, below, right, -1.0, Par::Seq);
            }
        }
        true
    }

    /// Solves with the factors, in the order of elimination.
    fn solve_scaled(&mut self) {
        let n = self.x.len();
        let factors = view(&self.factors);
        for Front { own, coupled } in &self.fronts {
            let (x, rest) = self.x.split_at_mut(own.end);
            let x = &mut x[own.start..];
            let pivots = factors.submatrix(own.start, own.start, own.len(), own.len());
            solve::solve_in_place_with_conj(
                pivots,
                pivots,
                PermRef::new_checked(
                    &self.row_permutation[own.clone()],
                    &self.row_permutation_inverse[own.clone()],
                    own.len(),
                ),
                Conj::No,
                MatMut::from_column_major_slice_mut(x, own.len(), 1),
                Par::Seq,
                MemStack::new(&mut self.memory),
            );
            for run in &self.coupled[coupled.clone()] {
                for (column, x) in own.clone().zip(&*x) {
                    let column = &self.factors.as_slice()[column * n..][run.clone()];
                    subtract(&mut rest[run.start - own.end..run.end - own.end], column, *x);
                }
            }
        }
        for Front { own, coupled } in self.fronts.iter().rev() {
            let (before, rest) = self.x.split_at_mut(own.end);
            let x = &mut before[own.start..];
            for run in &self.coupled[coupled.clone()] {
                for column in run.clone() {
                    let entries = &self.factors.as_slice()[column * n..][own.clone()];
                    subtract(x, entries, rest[column - own.end]);
                }
            }
        }
    }
}

/// `y <- y - factor x`.
fn subtract(y: &mut [f64], x: &[f64], factor: f64) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= factor * x;
    }
}

/// Whether all entries are finite and none is too large.
fn is_moderate(a: MatRef<'_, f64>) -> bool {
    a.col_iter().all(|column| {
        let column = column.try_as_col_major().expect("by columns").as_slice();
        column.iter().fold(true, |is, entry| is & (entry.abs() <= LARGEST_FACTOR))
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A matrix of coupled blocks with a positive definite symmetric part, with the same different units of rows and columns.
    fn coupled(sizes: &[usize], pairs: &[(usize, usize)], units: f64, seed: u64) -> Matrix {
        let n: usize = sizes.iter().sum();
        let first = |i: usize| sizes[..i].iter().sum::<usize>();
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut a = Matrix::identity(n, n);
        let own = (0..sizes.len()).map(|i| (i, i));
        for (i, j) in own.chain(pairs.iter().copied()) {
            for _ in 0..3 {
                let mut along = vec![0.0; n];
                let mut across = vec![0.0; n];
                for k in [i, j].into_iter().flat_map(|i| first(i)..first(i) + sizes[i]) {
                    along[k] = random();
                    across[k] = random();
                }
                for (k, l) in (0..n).flat_map(|k| (0..n).map(move |l| (k, l))) {
                    // The second part is not symmetric, as friction is not.
                    a[(k, l)] +=
                        30.0 * along[k] * along[l] + 0.5 * (across[k] * along[l] - along[k] * across[l]);
                }
            }
        }
        let units: Vec<f64> = (0..n).map(|_| (units * random()).exp()).collect();
        Matrix::from_fn(n, n, |k, l| units[k] * a[(k, l)] * units[l])
    }

    /// Compares a solution with that of the dense factorisation.
    fn compare(a: &Matrix, lu: &mut BlockLu) {
        let n = a.nrows();
        let mut dense = Lu::new(n);
        dense.factorise(a).unwrap();
        lu.factorise(a).unwrap();
        let b: Vec<f64> = (0..n).map(|i| a[(i, i)].sqrt() * ((7 * i + 3) as f64).sin()).collect();
        let (mut x, mut wanted) = (b.clone(), b);
        lu.solve(&mut x);
        dense.solve(&mut wanted);
        let scaled = |x: &[f64]| x.iter().enumerate().map(|(i, x)| x * a[(i, i)].sqrt()).collect::<Vec<_>>();
        let (x, wanted) = (scaled(&x), scaled(&wanted));
        let size = crate::numerics::linalg::norm_inf(&wanted);
        for (x, wanted) in x.iter().zip(&wanted) {
            assert!((x - wanted).abs() <= 1e-11 * size, "{x} is not {wanted}; {size}");
        }
    }

    fn ring(blocks: usize) -> Vec<(usize, usize)> {
        (0..blocks).map(|i| (i, (i + 1) % blocks)).collect()
    }

    proptest! {
        /// Any couplings, and one memory for all of them.
        #[test]
        fn solves_as_with_all_entries(
            sizes in prop::collection::vec(1_usize..9, 4..14),
            couplings in prop::collection::vec(prop::collection::vec((0_usize..14, 0_usize..14), 0..16), 1..4),
            units in 0.0..8.0,
            seed: u64,
        ) {
            let mut lu = BlockLu::new(&sizes);
            for pairs in couplings {
                let pairs: Vec<_> = pairs.into_iter().map(|(i, j)| (i % sizes.len(), j % sizes.len())).collect();
                compare(&coupled(&sizes, &pairs, units, seed), &mut lu);
            }
        }
    }

    /// Matrices with few couplings are factorised sparsely, others densely.
    #[test]
    fn is_sparse_where_that_pays() {
        let sizes = [5; 20];
        let mut lu = BlockLu::new(&sizes);
        for pairs in [vec![], ring(20)] {
            compare(&coupled(&sizes, &pairs, 4.0, 1), &mut lu);
            assert!(!lu.is_dense && lu.dense.is_none());
        }
        let all: Vec<_> = (0..20).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
        compare(&coupled(&sizes, &all, 4.0, 1), &mut lu);
        assert!(lu.is_dense);
        compare(&coupled(&sizes, &ring(20), 4.0, 2), &mut lu);
        assert!(!lu.is_dense);
    }

    /// The same solution to the last bit, in memory used for another matrix before.
    #[test]
    fn the_same_matrix_has_the_same_solution() {
        let sizes = [5; 20];
        let a = coupled(&sizes, &ring(20), 4.0, 3);
        let solution = |lu: &mut BlockLu| {
            lu.factorise(&a).unwrap();
            let mut b: Vec<f64> = (0..100).map(|i| (i as f64).cos()).collect();
            lu.solve(&mut b);
            b
        };
        let mut lu = BlockLu::new(&sizes);
        let first = solution(&mut lu);
        lu.factorise(&coupled(&sizes, &[(3, 9), (9, 17)], 4.0, 4)).unwrap();
        assert_eq!(solution(&mut lu), first);
        assert_eq!(solution(&mut lu.clone()), first);
    }

    /// Matrices whose first diagonal block is zero, nearly zero or negative, and one with a singular block that nothing couples.
    #[test]
    fn pivots_between_blocks_are_found_by_the_dense_factorisation() {
        let sizes = [2; 12];
        for diagonal in [0.0, 1e-14, -2.0] {
            let mut a = Matrix::identity(24, 24);
            a.view_mut((0, 0), (2, 2)).fill_with_identity();
            a.view_mut((0, 0), (2, 2)).scale_mut(diagonal);
            for i in 0..2 {
                a[(i, 2 + i)] = 1.0;
                a[(2 + i, i)] = -1.0;
            }
            let mut lu = BlockLu::new(&sizes);
            lu.factorise(&a).unwrap();
            assert!(lu.is_dense, "{diagonal}");
            let wanted: Vec<f64> = (0..24).map(|i| 1.0 + i as f64).collect();
            let mut x: Vec<f64> = (0..24).map(|i| (0..24).map(|j| a[(i, j)] * wanted[j]).sum()).collect();
            lu.solve(&mut x);
            assert!(x.iter().zip(&wanted).all(|(x, wanted)| (x - wanted).abs() < 1e-13 * wanted));
        }
        // All entries of the second block are the same, and nothing else couples it.
        let mut a = coupled(&sizes, &ring(3), 1.0, 5);
        a.view_mut((8, 8), (2, 2)).fill(1.0);
        assert_eq!(BlockLu::new(&sizes).factorise(&a), Err(Singular));
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        let sizes = [3; 8];
        let mut lu = BlockLu::new(&sizes);
        for (row, column) in [(0, 0), (1, 22), (22, 1), (5, 4)] {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut a = coupled(&sizes, &ring(8), 1.0, 6);
                a[(row, column)] = value;
                assert_eq!(lu.factorise(&a), Err(Singular), "{row} {column} {value}");
            }
        }
        compare(&coupled(&sizes, &ring(8), 1.0, 6), &mut lu);
    }
}
