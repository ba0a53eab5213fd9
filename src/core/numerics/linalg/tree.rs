//! Matrices of trees. Links interact only through the places between them, whose state consists of a few
//! numbers. Therefore one sweep to the root and one to the leaves solve a linear system.
//!
//! The diagonal blocks are links. Each link is attached at a place of a preceding one, its carrier, or at
//! none (a root). A link can have several places, with several links at each. A coordinate j has one
//! generator for everything that carries it, a row `p_j` and a column `v_j`, and for each place of its link
//! one for everything attached there, a row `u_j` and a column `q_j`. With these
//!
//! ```text
//! A_jk = u_j . v_k    where the link of j carries that of k, directly or not
//! A_jk = p_j . q_k    where it is carried by it
//! A_jk = 0            where neither carries the other
//! ```
//!
//! For a chain of links these are the block semiseparable matrices in generator form: the sequentially
//! semiseparable ones of Chandrasekaran, Dewilde, Gu, Pals, Sun, van der Veen and White (2005) with
//! identities for transitions. Zero blocks between branches are the branch-induced sparsity of Featherstone
//! (2008, section 6.4).
//!
//! Let `a` be the sum of `q_k x_k` over all links that carry a place, and `c` the sum of `v_k x_k` over all
//! links attached there. The rows of a link in `A x = b` are
//!
//! ```text
//! D x + P a + sum_i U_i c_i = b,        a_i = a + Q_i^T x,        c = V^T x + sum_i c_i
//! ```
//!
//! where i is the index of its places. Elimination proceeds from the leaves to the root. The links attached
//! at place i respond by `c_i = G_i a_i + g_i`, with `G_i = 0` and `g_i = 0` if there are none; then
//!
//! ```text
//! W = D + sum_i U_i G_i Q_i^T,        F = P + sum_i U_i G_i,        E = V^T + sum_i G_i Q_i^T
//! y = W^-1 (b - sum_i U_i g_i),       x = y - W^-1 F a
//! ```
//!
//! and the response at the place to which the link is attached is `sum_i G_i - E W^-1 F` and
//! `sum_i g_i + E y`, summed over all links at this place. This is block LU factorisation from the leaves
//! without fill-in, with the Schur complements W as pivots; G corresponds to the articulated-body inertia of
//! Featherstone (1983).
//!
//! Rows are exchanged within blocks, never between them. For symmetric positive definite matrices the Schur
//! complements are symmetric positive definite too, and not worse conditioned; the elimination is then stable
//! as long as the matrix is well conditioned (Demmel, Higham and Schreiber 1995). Other matrices can have a
//! singular Schur complement although they are regular: then the factorisation fails with [`Singular`], as
//! for a singular matrix.

use std::marker::PhantomData;
use std::ops::Range;

use super::{Matrix, Singular, small_lu};
use crate::numerics::lie::{Instructions, LANES, Lanes, Pack, Sweep};

/// Rows and columns of generators, stored as columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Generators {
    /// Factors of the rows.
    pub rows: Matrix,
    /// Factors of the columns.
    pub columns: Matrix,
}

/// A place of a link at which others are attached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreePlace {
    /// Index of the link's block.
    pub block: usize,
    /// Index in [`TreeMatrix::carrying`] of the generator of its first coordinate.
    pub first: usize,
}

/// Matrix of a tree: diagonal blocks, and low-rank blocks between links of which one carries the other.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeMatrix {
    /// Square diagonal blocks, of any sizes including zero; carriers precede what they carry.
    pub blocks: Vec<Matrix>,
    /// Generators of each coordinate for its carriers: rows `p_j` (lower rank x n) and columns `v_j` (upper
    /// rank x n).
    pub carried: Generators,
    /// Generators of each coordinate for each place of its link, place by place: rows `u_j` (upper rank) and
    /// columns `q_j` (lower rank).
    pub carrying: Generators,
    /// The place at which each block is attached; `None` for a root.
    hangs_at: Vec<Option<usize>>,
    places: Vec<TreePlace>,
}

impl TreeMatrix {
    /// Zero matrix with diagonal blocks of these sizes. Each block is attached at one of the places, whose
    /// blocks are given, or is a root. The ranks are those of the parts above and below the diagonal, at most
    /// 16 and 20.
    ///
    /// # Panics
    /// If a carrier does not precede what it carries, places are not in the order of their blocks, or ranks
    /// are too large.
    pub fn zeros(
        sizes: &[usize],
        hangs_at: &[Option<usize>],
        places: &[usize],
        [upper, lower]: [usize; 2],
    ) -> Self {
        let carried_by = |(block, place): (usize, &Option<usize>)| place.is_none_or(|p| places[p] < block);
        assert!(
            sizes.len() == hangs_at.len() && hangs_at.iter().enumerate().all(carried_by),
            "blocks behind their carriers"
        );
        assert!(places.is_sorted(), "places in the order of their blocks");
        Layout::of([upper, lower]);
        let n = sizes.iter().sum();
        let mut carrying = 0;
        let places = places.iter().map(|&block| {
            let first = carrying;
            carrying += sizes[block];
            TreePlace { block, first }
        });
        let places = places.collect();
        Self {
            blocks: sizes.iter().map(|&size| Matrix::zeros(size, size)).collect(),
            carried: Generators { rows: Matrix::zeros(lower, n), columns: Matrix::zeros(upper, n) },
            carrying: Generators {
                rows: Matrix::zeros(upper, carrying),
                columns: Matrix::zeros(lower, carrying),
            },
            hangs_at: hangs_at.to_vec(),
            places,
        }
    }

    /// An entry of a diagonal block.
    ///
    /// # Panics
    /// If the coordinates belong to several blocks.
    pub fn entry_of_block(&mut self, mut i: usize, mut j: usize) -> &mut f64 {
        let mut block = 0;
        while i >= self.blocks[block].nrows() {
            let size = self.blocks[block].nrows();
            (i, j, block) = (i - size, j - size, block + 1);
        }
        &mut self.blocks[block][(i, j)]
    }

    /// All entries: blocks, then generators.
    pub fn parts_mut(&mut self) -> impl Iterator<Item = &mut Matrix> {
        let Self { blocks, carried, carrying, .. } = self;
        let generators = [carried, carrying].map(|Generators { rows, columns }| [rows, columns]);
        blocks.iter_mut().chain(generators.into_iter().flatten())
    }

    /// Zero matrix of a chain of links, each of which is attached at the only place of the previous one.
    pub fn chain(sizes: &[usize], ranks: [usize; 2]) -> Self {
        let hangs_at: Vec<_> = (0..sizes.len()).map(|block| block.checked_sub(1)).collect();
        let places: Vec<_> = (1..sizes.len()).map(|block| block - 1).collect();
        Self::zeros(sizes, &hangs_at, &places, ranks)
    }

    /// Number of rows and of columns.
    pub fn n(&self) -> usize {
        self.blocks.iter().map(Matrix::nrows).sum()
    }

    /// The ranks above and below the diagonal.
    pub fn ranks(&self) -> [usize; 2] {
        [self.carrying.rows.nrows(), self.carried.rows.nrows()]
    }

    /// The places at which blocks are attached.
    pub fn places(&self) -> &[TreePlace] {
        &self.places
    }

    /// The coordinates of each block.
    fn coordinates(&self) -> Vec<Range<usize>> {
        let mut first = 0;
        let own = self.blocks.iter().map(|block| {
            first += block.nrows();
            first - block.nrows()..first
        });
        own.collect()
    }

    /// `y <- A x`. Cost: linear in the number of blocks. Allocates; not for step loops.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let [upper, lower] = self.ranks();
        let coordinates = self.coordinates();
        let mut before = vec![0.0; lower * self.places.len()];
        let mut behind = vec![0.0; upper * self.places.len()];
        for (p, place) in self.places.iter().enumerate() {
            if let Some(carrier) = self.hangs_at[place.block] {
                before.copy_within(carrier * lower..(carrier + 1) * lower, p * lower);
            }
            for (i, k) in coordinates[place.block].clone().enumerate() {
                add(
                    &mut before[p * lower..][..lower],
                    generator(&self.carrying.columns, place.first + i),
                    x[k],
                );
            }
        }
        for (block, own) in self.blocks.iter().zip(&coordinates) {
            for j in own.clone() {
                let row = block.row(j - own.start);
                y[j] = row.iter().zip(&x[own.clone()]).map(|(entry, x)| entry * x).sum();
            }
        }
        for (s, own) in coordinates.iter().enumerate().rev() {
            let mut through = vec![0.0; upper];
            for (p, place) in self.places.iter().enumerate().filter(|(_, place)| place.block == s) {
                let behind = &behind[p * upper..][..upper];
                for (i, j) in own.clone().enumerate() {
                    y[j] += dot(generator(&self.carrying.rows, place.first + i), behind);
                }
                add(&mut through, behind, 1.0);
            }
            let Some(carrier) = self.hangs_at[s] else { continue };
            for k in own.clone() {
                add(&mut through, generator(&self.carried.columns, k), x[k]);
                y[k] += dot(generator(&self.carried.rows, k), &before[carrier * lower..][..lower]);
            }
            add(&mut behind[carrier * upper..][..upper], &through, 1.0);
        }
    }

    /// True if all entries of blocks and generators are finite.
    pub fn is_finite(&self) -> bool {
        let Self { blocks, carried, carrying, .. } = self;
        let generators = [&carried.rows, &carried.columns, &carrying.rows, &carrying.columns];
        blocks.iter().chain(generators).all(|part| part.iter().all(|entry| entry.is_finite()))
    }

    /// The same matrix in dense form.
    pub fn to_dense(&self) -> Matrix {
        let n = self.n();
        let mut dense = Matrix::zeros(n, n);
        let coordinates = self.coordinates();
        for (s, (block, own)) in self.blocks.iter().zip(&coordinates).enumerate() {
            dense.view_mut((own.start, own.start), block.shape()).copy_from(block);
            let mut place = self.hangs_at[s];
            while let Some(p) = place {
                let TreePlace { block: carrier, first } = self.places[p];
                for (i, j) in coordinates[carrier].clone().enumerate() {
                    let [u, q] =
                        [&self.carrying.rows, &self.carrying.columns].map(|g| generator(g, first + i));
                    for k in own.clone() {
                        dense[(j, k)] = dot(u, generator(&self.carried.columns, k));
                        dense[(k, j)] = dot(generator(&self.carried.rows, k), q);
                    }
                }
                place = self.hangs_at[carrier];
            }
        }
        dense
    }
}

/// A generator: one column of many.
fn generator(generators: &Matrix, k: usize) -> &[f64] {
    &generators.as_slice()[k * generators.nrows()..][..generators.nrows()]
}

/// Layout of generators in SIMD packs: numbers of packs of the upper and of the lower rank, and the lower rank.
#[derive(Clone, Copy, Debug)]
struct Layout {
    upper: usize,
    lower: usize,
    columns: usize,
}

/// Calls a method with the layout as constants, so that its loops are unrolled. The layouts are those of mass matrices and of
/// tangents of robots in space and in a plane, with and without dead loads and responses.
macro_rules! with_layout {
    ($layout:expr, $function:ident::<P>($($argument:expr),*)) => {
        match $layout {
            Layout { upper: 2, columns: 6, .. } => $function::<P, 6, 2, 2, 6>($($argument),*),
            Layout { upper: 2, columns: 9, .. } => $function::<P, 6, 2, 3, 9>($($argument),*),
            Layout { upper: 2, columns: 12, .. } => $function::<P, 6, 2, 3, 12>($($argument),*),
            Layout { upper: 2, columns: 18, .. } => $function::<P, 6, 2, 5, 18>($($argument),*),
            Layout { upper: 1, columns: 3, .. } => $function::<P, 3, 1, 1, 3>($($argument),*),
            Layout { upper: 1, columns: 4, .. } => $function::<P, 3, 1, 1, 4>($($argument),*),
            Layout { upper: 1, columns: 5, .. } => $function::<P, 3, 1, 2, 5>($($argument),*),
            Layout { upper: 1, columns: 9, .. } => $function::<P, 3, 1, 3, 9>($($argument),*),
            _ => $function::<P, 16, 4, 5, 20>($($argument),*),
        }
    };
}

impl Layout {
    /// The layout of these ranks if robots in space or in the plane have them; otherwise one that is large enough.
    fn of([upper, lower]: [usize; 2]) -> Self {
        let columns = lower;
        let upper = match (upper, lower) {
            (6, 6 | 9 | 12 | 18) => 2,
            (3, 3 | 4 | 5 | 9) => 1,
            _ => {
                assert!(upper <= 4 * LANES && lower <= 5 * LANES, "ranks of at most 16 and 20");
                return Self { upper: 4, lower: 5, columns: 5 * LANES };
            }
        };
        Self { upper, lower: columns.div_ceil(LANES), columns }
    }
}

/// The remainder of a link after elimination.
#[derive(Clone, Debug)]
struct Link {
    /// First coordinate, and their number.
    first: usize,
    size: usize,
    /// The place at which it is attached, and whether it is the first one eliminated there.
    hangs_at: Option<usize>,
    is_first_there: bool,
    /// Its own places at which other links are attached.
    places: Range<usize>,
    /// The factors of W.
    factors: Vec<f64>,
    pivots: Vec<usize>,
    /// `W^-1 F` by rows, and E by columns.
    response: Vec<f64>,
    answer: Vec<f64>,
}

/// Factorisation of a [`TreeMatrix`], with memory for repeated use with a fixed structure.
#[derive(Clone, Debug)]
pub struct TreeLu {
    instructions: Instructions,
    layout: Layout,
    ranks: [usize; 2],
    /// Links with coordinates.
    links: Vec<Link>,
    blocks: usize,
    /// The first generator of each place.
    firsts: Vec<usize>,
    /// U and Q, transposed.
    rows: Vec<f64>,
    columns: Vec<f64>,
    /// By place: G by columns, g and a of the elimination at hand.
    behind: Vec<f64>,
    offset: Vec<f64>,
    before: Vec<f64>,
}

impl TreeLu {
    /// Memory for matrices of the structure of `a`.
    pub fn new(a: &TreeMatrix) -> Self {
        let layout = Layout::of(a.ranks());
        let [upper, lower] = [layout.upper, layout.lower].map(|packs| packs * LANES);
        let coordinates = a.coordinates();
        let mut has_one = vec![false; a.places.len()];
        let mut links: Vec<Link> = Vec::with_capacity(a.blocks.len());
        for (s, own) in coordinates.iter().enumerate().rev().filter(|(_, own)| !own.is_empty()) {
            let mut hangs_at = a.hangs_at[s];
            // A link without coordinates passes all forces on to its carrier.
            while let Some(place) = hangs_at.filter(|&place| coordinates[a.places[place].block].is_empty()) {
                hangs_at = a.hangs_at[a.places[place].block];
            }
            let is_first_there = hangs_at.is_some_and(|place| !std::mem::replace(&mut has_one[place], true));
            let size = own.len();
            let places = a.places.partition_point(|place| place.block < s)
                ..a.places.partition_point(|place| place.block <= s);
            links.push(Link {
                first: own.start,
                size,
                hangs_at,
                is_first_there,
                places,
                factors: vec![0.0; size * size],
                pivots: vec![0; size],
                response: vec![0.0; size * lower],
                answer: vec![0.0; size * upper],
            });
        }
        links.reverse();
        let carrying = a.carrying.rows.ncols();
        Self {
            instructions: Instructions::of_machine(),
            layout,
            ranks: a.ranks(),
            links,
            blocks: a.blocks.len(),
            firsts: a.places.iter().map(|place| place.first).collect(),
            rows: vec![0.0; carrying * upper],
            columns: vec![0.0; carrying * lower],
            // Zeros remain where nothing is attached.
            behind: vec![0.0; a.places.len() * upper * layout.columns],
            offset: vec![0.0; a.places.len() * upper],
            before: vec![0.0; a.places.len() * lower],
        }
    }

    /// Factorises `a`, which must have the structure of the memory. Cost for each block of m coordinates with
    /// one place and the ranks r and l: about `m^3/3 + m^2 (r + l) + 3 m r l` multiplications.
    ///
    /// Fails if a Schur complement is singular or not finite, as it is if an entry is not finite.
    ///
    /// # Panics
    /// If `a` has another structure.
    pub fn factorise(&mut self, a: &TreeMatrix) -> Result<(), Singular> {
        assert!(a.ranks() == self.ranks && a.blocks.len() == self.blocks, "blocks of a tree");
        let instructions = self.instructions;
        if instructions.has_fused() {
            instructions.run::<Pack<true>, _>(Factorise::<Pack<true>> { lu: self, a, packs: PhantomData })
        } else {
            instructions.run::<Pack<false>, _>(Factorise::<Pack<false>> { lu: self, a, packs: PhantomData })
        }
    }

    /// Solves `A x = b` in place. Cost for each block: about `m^2 + 2 m (r + l)` multiplications.
    pub fn solve(&mut self, b: &mut [f64]) {
        let instructions = self.instructions;
        if instructions.has_fused() {
            instructions.run::<Pack<true>, _>(Solve::<Pack<true>> { lu: self, b, packs: PhantomData });
        } else {
            instructions.run::<Pack<false>, _>(Solve::<Pack<false>> { lu: self, b, packs: PhantomData });
        }
    }
}

struct Factorise<'a, P> {
    lu: &'a mut TreeLu,
    a: &'a TreeMatrix,
    packs: PhantomData<P>,
}

impl<P: Lanes> Sweep for Factorise<'_, P> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn call(self) -> Result<(), Singular> {
        with_layout!(self.lu.layout, factorise::<P>(self.lu, self.a))
    }
}

struct Solve<'a, P> {
    lu: &'a mut TreeLu,
    b: &'a mut [f64],
    packs: PhantomData<P>,
}

impl<P: Lanes> Sweep for Solve<'_, P> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        with_layout!(self.lu.layout, solve::<P>(self.lu, self.b));
    }
}

#[inline(always)]
fn factorise<P: Lanes, const RANK: usize, const UPPER: usize, const LOWER: usize, const COLUMNS: usize>(
    lu: &mut TreeLu,
    a: &TreeMatrix,
) -> Result<(), Singular> {
    let [upper, lower] = [UPPER * LANES, LOWER * LANES];
    // In layouts of robots the compiler knows the ranks.
    let ranks = if RANK == UPPER * LANES { lu.ranks } else { [RANK, COLUMNS] };
    let TreeLu { links, firsts, rows, columns, behind, .. } = lu;
    copy_padded(ranks[0], a.carrying.rows.as_slice(), upper, rows);
    copy_padded(ranks[1], a.carrying.columns.as_slice(), lower, columns);
    let blocks = a.blocks.iter().rev().filter(|block| block.nrows() > 0);
    for (link, block) in links.iter_mut().rev().zip(blocks) {
        let Link { first, size, hangs_at, is_first_there, places, factors, pivots, response, answer } = link;
        let size = *size;
        factors.copy_from_slice(block.as_slice());
        let own = |rank: usize| *first * rank..(*first + size) * rank;
        copy_padded(ranks[0], &a.carried.columns.as_slice()[own(ranks[0])], upper, answer);
        copy_padded(ranks[1], &a.carried.rows.as_slice()[own(ranks[1])], lower, response);
        for place in places.clone() {
            let behind = &behind[place * upper * COLUMNS..][..upper * COLUMNS];
            let of_coordinate =
                |k: usize, width: usize| (firsts[place] + k) * width..(firsts[place] + k + 1) * width;
            for k in 0..size {
                let q = &columns[of_coordinate(k, lower)][..COLUMNS];
                let mut here = combined::<P, UPPER>(behind, q);
                for j in 0..size {
                    let u = packs::<P, UPPER>(&rows[of_coordinate(j, upper)]);
                    factors[k * size + j] += product(u, here);
                }
                let answer = &mut answer[k * upper..][..upper];
                for (here, known) in here.iter_mut().zip(packs::<P, UPPER>(answer)) {
                    *here += known;
                }
                store(here, answer);
            }
            for j in 0..size {
                let u = packs::<P, UPPER>(&rows[of_coordinate(j, upper)]);
                for (i, entry) in response[j * lower..][..COLUMNS].iter_mut().enumerate() {
                    *entry += product(u, packs::<P, UPPER>(&behind[i * upper..]));
                }
            }
        }
        factorise_block(factors, pivots, lower, response)?;
        let Some(carrier) = *hangs_at else { continue };
        let (carriers, own_places) = behind.split_at_mut(places.start * upper * COLUMNS);
        let seen = &mut carriers[carrier * upper * COLUMNS..][..upper * COLUMNS];
        for (i, seen) in seen.chunks_exact_mut(upper).enumerate() {
            let mut sum = if *is_first_there { [P::splat(0.0); UPPER] } else { packs::<P, UPPER>(seen) };
            for place in 0..places.len() {
                let through = packs::<P, UPPER>(&own_places[(place * COLUMNS + i) * upper..]);
                for (sum, through) in sum.iter_mut().zip(through) {
                    *sum += through;
                }
            }
            for k in 0..size {
                let answer = packs::<P, UPPER>(&answer[k * upper..]);
                let response = P::splat(response[k * lower + i]);
                for (sum, answer) in sum.iter_mut().zip(answer) {
                    *sum = answer.mul_sub_from(response, *sum);
                }
            }
            store(sum, seen);
        }
    }
    Ok(())
}

/// The columns times these factors.
#[inline(always)]
fn combined<P: Lanes, const UPPER: usize>(columns: &[f64], factors: &[f64]) -> [P; UPPER] {
    // Two independent sums, which the processor computes in parallel.
    let mut sums = [[P::splat(0.0); UPPER]; 2];
    for (i, &factor) in factors.iter().enumerate() {
        let column = packs::<P, UPPER>(&columns[i * UPPER * LANES..]);
        for (sum, column) in sums[i % 2].iter_mut().zip(column) {
            *sum = column.mul_add(P::splat(factor), *sum);
        }
    }
    let mut sum = sums[0];
    for (sum, other) in sum.iter_mut().zip(sums[1]) {
        *sum += other;
    }
    sum
}

/// Factorises a block, and solves with it for rows of this width.
#[inline(always)]
fn factorise_block(
    factors: &mut [f64],
    pivots: &mut [usize],
    width: usize,
    rows: &mut [f64],
) -> Result<(), Singular> {
    if let [factor] = factors {
        let reciprocal = 1.0 / *factor;
        if reciprocal == 0.0 || !reciprocal.is_finite() {
            return Err(Singular);
        }
        *factor = reciprocal;
        rows.iter_mut().for_each(|entry| *entry *= reciprocal);
        return Ok(());
    }
    small_lu::factorise(factors, pivots)?;
    small_lu::solve_rows(factors, pivots, width, rows);
    Ok(())
}

#[inline(always)]
fn solve<P: Lanes, const RANK: usize, const UPPER: usize, const LOWER: usize, const COLUMNS: usize>(
    lu: &mut TreeLu,
    b: &mut [f64],
) {
    let [upper, lower] = [UPPER * LANES, LOWER * LANES];
    let TreeLu { links, firsts, rows, columns, offset, before, .. } = lu;
    // The place written last and its values, which the next link mostly needs.
    let mut last = (usize::MAX, [P::splat(0.0); UPPER]);
    for link in links.iter().rev() {
        let x = &mut b[link.first..][..link.size];
        let mut sum = [P::splat(0.0); UPPER];
        for place in link.places.clone() {
            let offset = if place == last.0 { last.1 } else { packs::<P, UPPER>(&offset[place * upper..]) };
            for (x, row) in x.iter_mut().zip(rows[firsts[place] * upper..].chunks_exact(upper)) {
                *x -= product(packs::<P, UPPER>(row), offset);
            }
            for (sum, offset) in sum.iter_mut().zip(offset) {
                *sum += offset;
            }
        }
        if link.size == 1 {
            x[0] *= link.factors[0];
        } else {
            small_lu::solve(&link.factors, &link.pivots, x);
        }
        let Some(carrier) = link.hangs_at else { continue };
        for (&x, answer) in x.iter().zip(link.answer.chunks_exact(upper)) {
            for (sum, answer) in sum.iter_mut().zip(packs::<P, UPPER>(answer)) {
                *sum = answer.mul_add(P::splat(x), *sum);
            }
        }
        let seen = &mut offset[carrier * upper..][..upper];
        if !link.is_first_there {
            for (sum, seen) in sum.iter_mut().zip(packs::<P, UPPER>(seen)) {
                *sum += seen;
            }
        }
        store(sum, seen);
        last = (carrier, sum);
    }
    let mut last = (usize::MAX, [P::splat(0.0); LOWER]);
    for link in links.iter() {
        let x = &mut b[link.first..][..link.size];
        let mut here = [P::splat(0.0); LOWER];
        if let Some(carrier) = link.hangs_at {
            here = if carrier == last.0 { last.1 } else { packs::<P, LOWER>(&before[carrier * lower..]) };
            for (x, response) in x.iter_mut().zip(link.response.chunks_exact(lower)) {
                *x -= product(packs::<P, LOWER>(response), here);
            }
        }
        for place in link.places.clone() {
            let mut sum = here;
            for (&x, column) in x.iter().zip(columns[firsts[place] * lower..].chunks_exact(lower)) {
                for (sum, column) in sum.iter_mut().zip(packs::<P, LOWER>(column)) {
                    *sum = column.mul_add(P::splat(x), *sum);
                }
            }
            store(sum, &mut before[place * lower..][..lower]);
            last = (place, sum);
        }
    }
}

/// Copies generators of this rank to places at distance `width`, with zeros between them, so that stale NaN cannot spread.
#[inline(always)]
fn copy_padded(rank: usize, from: &[f64], width: usize, to: &mut [f64]) {
    if rank == 0 {
        return to.fill(0.0);
    }
    for (to, from) in to.chunks_exact_mut(width).zip(from.chunks_exact(rank)) {
        // A plain loop: `copy_from_slice` would call memcpy for a few numbers.
        for (to, &from) in to.iter_mut().zip(from) {
            *to = from;
        }
        for to in &mut to[rank..] {
            *to = 0.0;
        }
    }
}

/// The first numbers of a slice.
#[inline(always)]
fn packs<P: Lanes, const N: usize>(numbers: &[f64]) -> [P; N] {
    let (lanes, _) = numbers.as_chunks::<LANES>();
    let mut packs = [P::splat(0.0); N];
    // A plain loop: array::from_fn is not always inlined.
    for (pack, &lanes) in packs.iter_mut().zip(&lanes[..N]) {
        *pack = P::from_lanes(lanes);
    }
    packs
}

/// Writes them back.
#[inline(always)]
fn store<P: Lanes, const N: usize>(packs: [P; N], numbers: &mut [f64]) {
    let (lanes, _) = numbers.as_chunks_mut::<LANES>();
    for (lanes, pack) in lanes[..N].iter_mut().zip(packs) {
        for (i, number) in lanes.iter_mut().enumerate() {
            *number = pack.lane(i);
        }
    }
}

/// The sum of all products.
#[inline(always)]
fn product<P: Lanes, const N: usize>(a: [P; N], b: [P; N]) -> f64 {
    let mut sum = P::splat(0.0);
    for (a, b) in a.into_iter().zip(b) {
        sum = a.mul_add(b, sum);
    }
    sum.sum()
}

/// `y <- y + factor x`.
fn add(y: &mut [f64], x: &[f64], factor: f64) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
