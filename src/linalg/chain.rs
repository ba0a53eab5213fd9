//! Matrices of chains: what couples one link with another passes through the places between them, whose state is a few
//! numbers, so that a linear system is solved in one sweep to each end.
//!
//! With square diagonal blocks `D_s` and, for each coordinate j, an upper row `u_j` and column `v_j` and a lower row
//! `p_j` and column `q_j`,
//!
//! ```text
//! A_jk = u_j . v_k    where the block of j comes before that of k
//! A_jk = p_j . q_k    where it comes after it
//! ```
//!
//! These are the block semiseparable matrices that are given by their generators: the sequentially semiseparable ones of
//! Chandrasekaran, Dewilde, Gu, Pals, Sun, van der Veen and White (2005) with identities for transitions.
//!
//! With `a_s`, the sum of `q_k x_k` over the blocks before s, and `c_s`, that of `v_k x_k` over the blocks behind it,
//! the rows of block s of `A x = b` are
//!
//! ```text
//! D x + P a_s + U c_s = b,        a_{s+1} = a_s + Q^T x,        c_{s-1} = c_s + V^T x
//! ```
//!
//! Elimination goes from the last block to the first. What lies behind block s answers `c_s = G a_{s+1} + g`, with
//! `G = 0` and `g = 0` behind the last one; then
//!
//! ```text
//! W = D + U G Q^T,        F = P + U G,        E = V^T + G Q^T
//! y = W^-1 (b - U g),     x = y - W^-1 F a_s
//! ```
//!
//! and block s - 1 sees `G - E W^-1 F` and `g + E y` behind it. This is block LU factorisation from the last block,
//! with the Schur complements W as pivots; G is to a chain what the articulated-body inertia of Featherstone (1983)
//! is to robots.
//!
//! Rows are exchanged within blocks, never between them. For symmetric positive definite matrices the Schur
//! complements are that, too, and are not worse conditioned; there the elimination is stable as long as the matrix is
//! well conditioned (Demmel, Higham and Schreiber 1995). A matrix without this property can have a singular Schur
//! complement although it is regular itself: then the factorisation fails with [`Singular`], as for a singular
//! matrix.

use super::{Matrix, Singular, small_lu};

/// One generator for each coordinate, as columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Generators {
    /// What the row of a coordinate multiplies, rank x n.
    pub rows: Matrix,
    /// What the column of a coordinate multiplies, rank x n.
    pub columns: Matrix,
}

impl Generators {
    fn zeros(rank: usize, n: usize) -> Self {
        Self { rows: Matrix::zeros(rank, n), columns: Matrix::zeros(rank, n) }
    }

    /// The entry of row j and column k.
    fn entry(&self, j: usize, k: usize) -> f64 {
        dot(Self::of(&self.rows, j), Self::of(&self.columns, k))
    }

    /// The generator of a coordinate.
    fn of(generators: &Matrix, coordinate: usize) -> &[f64] {
        column(generators.as_slice(), generators.nrows(), coordinate)
    }
}

/// The matrix of a chain: blocks on the diagonal, and low rank between different blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainMatrix {
    /// The diagonal blocks, square, of any sizes (zero included).
    pub blocks: Vec<Matrix>,
    /// All that stands above the diagonal blocks: `A_jk = rows_j . columns_k`.
    pub upper: Generators,
    /// All that stands below them, likewise.
    pub lower: Generators,
}

impl ChainMatrix {
    /// The zero matrix with diagonal blocks of these sizes and generators of these ranks.
    pub fn zeros(sizes: &[usize], upper_rank: usize, lower_rank: usize) -> Self {
        let n = sizes.iter().sum();
        Self {
            blocks: sizes.iter().map(|&size| Matrix::zeros(size, size)).collect(),
            upper: Generators::zeros(upper_rank, n),
            lower: Generators::zeros(lower_rank, n),
        }
    }

    /// Number of rows and of columns.
    pub fn n(&self) -> usize {
        self.blocks.iter().map(Matrix::nrows).sum()
    }

    /// The ranks of the upper and of the lower generators.
    pub fn ranks(&self) -> [usize; 2] {
        [&self.upper, &self.lower].map(|generators| generators.rows.nrows())
    }

    /// `y <- A x`. Cost: linear in the number of blocks. Allocates; not for step loops.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let mut before = vec![0.0; self.lower.rows.nrows()];
        let mut first = 0;
        for block in &self.blocks {
            let own = first..first + block.nrows();
            for j in own.clone() {
                let row = block.row(j - first);
                y[j] = row.iter().zip(&x[own.clone()]).map(|(entry, x)| entry * x).sum();
                y[j] += dot(Generators::of(&self.lower.rows, j), &before);
            }
            for k in own.clone() {
                add(&mut before, Generators::of(&self.lower.columns, k), x[k]);
            }
            first = own.end;
        }
        let mut behind = vec![0.0; self.upper.rows.nrows()];
        for block in self.blocks.iter().rev() {
            let own = first - block.nrows()..first;
            for j in own.clone() {
                y[j] += dot(Generators::of(&self.upper.rows, j), &behind);
            }
            for k in own.clone() {
                add(&mut behind, Generators::of(&self.upper.columns, k), x[k]);
            }
            first = own.start;
        }
    }

    /// True when everything that the matrix is made of is finite.
    pub fn is_finite(&self) -> bool {
        let Self { blocks, upper, lower } = self;
        let generators = [&upper.rows, &upper.columns, &lower.rows, &lower.columns];
        blocks.iter().chain(generators).all(|part| part.iter().all(|entry| entry.is_finite()))
    }

    /// The same matrix with all its entries.
    pub fn to_dense(&self) -> Matrix {
        let n = self.n();
        let mut dense = Matrix::zeros(n, n);
        let mut first = 0;
        for block in &self.blocks {
            let behind = first + block.nrows();
            dense.view_mut((first, first), block.shape()).copy_from(block);
            for k in first..behind {
                for j in 0..first {
                    dense[(j, k)] = self.upper.entry(j, k);
                }
                for j in behind..n {
                    dense[(j, k)] = self.lower.entry(j, k);
                }
            }
            first = behind;
        }
        dense
    }
}

/// What is left of a block after elimination.
#[derive(Clone, Debug)]
struct Link {
    first: usize,
    size: usize,
    /// The factors of W.
    factors: Matrix,
    pivots: Vec<usize>,
    /// `W^-1 F`, transposed: lower rank x size.
    response: Matrix,
    /// E, upper rank x size.
    answer: Matrix,
}

/// The factorisation of a [`ChainMatrix`], with memory for repeated use at one structure.
#[derive(Clone, Debug)]
pub struct ChainLu {
    links: Vec<Link>,
    /// U and Q, transposed.
    upper_rows: Matrix,
    lower_columns: Matrix,
    /// G, g and a of the elimination at hand.
    behind: Matrix,
    behind_offset: Vec<f64>,
    before: Vec<f64>,
}

/// Calls a function whose first arguments are the ranks, with those of rods as constants so that its loops are unrolled:
/// tangents with and without a dead load and mass matrices, in space and in a plane.
macro_rules! with_ranks {
    ($function:ident($ranks:expr $(, $argument:expr)*)) => {
        match $ranks {
            [6, 12] => $function([6, 12] $(, $argument)*),
            [6, 9] => $function([6, 9] $(, $argument)*),
            [6, 6] => $function([6, 6] $(, $argument)*),
            [3, 5] => $function([3, 5] $(, $argument)*),
            [3, 4] => $function([3, 4] $(, $argument)*),
            [3, 3] => $function([3, 3] $(, $argument)*),
            ranks => $function(ranks $(, $argument)*),
        }
    };
}

impl ChainLu {
    /// Memory for matrices of the structure of `a`.
    pub fn new(a: &ChainMatrix) -> Self {
        let [upper, lower] = a.ranks();
        let mut first = 0;
        let links = a.blocks.iter().map(|block| {
            let size = block.nrows();
            let link = Link {
                first,
                size,
                factors: Matrix::zeros(size, size),
                pivots: vec![0; size],
                response: Matrix::zeros(lower, size),
                answer: Matrix::zeros(upper, size),
            };
            first += size;
            link
        });
        Self {
            links: links.collect(),
            upper_rows: a.upper.rows.clone(),
            lower_columns: a.lower.columns.clone(),
            behind: Matrix::zeros(upper, lower),
            behind_offset: vec![0.0; upper],
            before: vec![0.0; lower],
        }
    }

    /// Factorises `a`, of the structure that the memory is for. Cost for each block of m coordinates, with the ranks
    /// r and l: about `m^3/3 + m^2 (r + l) + 3 m r l` multiplications.
    ///
    /// Fails when a Schur complement is singular or not finite; an entry that is not finite makes one so.
    ///
    /// # Panics
    /// When `a` has another structure.
    pub fn factorise(&mut self, a: &ChainMatrix) -> Result<(), Singular> {
        with_ranks!(factorise(a.ranks(), self, a))
    }

    /// Solves `A x = b` in place. Cost for each block: about `m^2 + 2 m (r + l)` multiplications.
    pub fn solve(&mut self, b: &mut [f64]) {
        with_ranks!(solve([self.upper_rows.nrows(), self.before.len()], self, b));
    }
}

#[inline(always)]
fn factorise([upper, lower]: [usize; 2], lu: &mut ChainLu, a: &ChainMatrix) -> Result<(), Singular> {
    let ChainLu { links, upper_rows, lower_columns, behind, .. } = lu;
    upper_rows.copy_from(&a.upper.rows);
    lower_columns.copy_from(&a.lower.columns);
    behind.fill(0.0);
    let behind = behind.as_mut_slice();
    assert_eq!(links.len(), a.blocks.len(), "blocks of a chain");
    let last = links.len().saturating_sub(1);
    for (s, (link, block)) in links.iter_mut().zip(&a.blocks).enumerate().rev() {
        let Link { first, size, factors, pivots, response, answer } = link;
        let of_link = |rank: usize| *first * rank..(*first + *size) * rank;
        let [u, v] = [&a.upper.rows, &a.upper.columns].map(|rows| &rows.as_slice()[of_link(upper)]);
        let [p, q] = [&a.lower.rows, &a.lower.columns].map(|rows| &rows.as_slice()[of_link(lower)]);
        let (factors, answer, response) =
            (factors.as_mut_slice(), answer.as_mut_slice(), response.as_mut_slice());
        factors.copy_from_slice(block.as_slice());
        if s == last {
            // Nothing is behind that could answer.
            answer.copy_from_slice(v);
        } else {
            for k in 0..*size {
                let answer = column_mut(answer, upper, k);
                answer.fill(0.0);
                for (i, &q) in column(q, lower, k).iter().enumerate() {
                    add(answer, column(behind, upper, i), q);
                }
                for (j, entry) in column_mut(factors, *size, k).iter_mut().enumerate() {
                    *entry += dot(column(u, upper, j), answer);
                }
                add(answer, column(v, upper, k), 1.0);
            }
        }
        small_lu::factorise(factors, pivots)?;
        if s == 0 {
            // Nothing is before that could be responded to.
            continue;
        }
        for j in 0..*size {
            let (u, p) = (column(u, upper, j), column(p, lower, j));
            for (i, entry) in column_mut(response, lower, j).iter_mut().enumerate() {
                *entry = p[i] + dot(u, column(behind, upper, i));
            }
        }
        small_lu::solve_rows(factors, pivots, lower, response);
        for i in 0..lower {
            let behind = column_mut(behind, upper, i);
            for k in 0..*size {
                add(behind, column(answer, upper, k), -response[k * lower + i]);
            }
        }
    }
    Ok(())
}

#[inline(always)]
fn solve([upper, lower]: [usize; 2], lu: &mut ChainLu, b: &mut [f64]) {
    let ChainLu { links, upper_rows, lower_columns, behind_offset, before, .. } = lu;
    let (behind, before) = (&mut behind_offset[..upper], &mut before[..lower]);
    behind.fill(0.0);
    for link in links.iter().rev() {
        let x = &mut b[link.first..][..link.size];
        for (j, x) in x.iter_mut().enumerate() {
            *x -= dot(column(upper_rows.as_slice(), upper, link.first + j), behind);
        }
        small_lu::solve(link.factors.as_slice(), &link.pivots, x);
        for (k, &x) in x.iter().enumerate() {
            add(behind, column(link.answer.as_slice(), upper, k), x);
        }
    }
    before.fill(0.0);
    for (s, link) in links.iter().enumerate() {
        for (j, x) in b[link.first..][..link.size].iter_mut().enumerate() {
            if s > 0 {
                *x -= dot(column(link.response.as_slice(), lower, j), before);
            }
        }
        for (k, &x) in b[link.first..][..link.size].iter().enumerate() {
            add(before, column(lower_columns.as_slice(), lower, link.first + k), x);
        }
    }
}

/// Column `k` of a matrix with so many rows.
#[inline(always)]
fn column(matrix: &[f64], rows: usize, k: usize) -> &[f64] {
    &matrix[k * rows..][..rows]
}

#[inline(always)]
fn column_mut(matrix: &mut [f64], rows: usize, k: usize) -> &mut [f64] {
    &mut matrix[k * rows..][..rows]
}

/// `y <- y + factor x`.
#[inline(always)]
fn add(y: &mut [f64], x: &[f64], factor: f64) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
