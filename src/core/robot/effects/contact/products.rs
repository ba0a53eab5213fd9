//! Sums of the products of several contact points of a pair in the tangent, as products of matrices.
//!
//! A contact point adds `sum_c m_c a_c^T` to the tangent, with the motion m of one of its sides per unit of each coordinate and the change
//! a of the wrench that this side requires, over the six components c of both sides. Products of matrices are faster than
//! these sums by a factor, the more so the more coordinates move the place.

use std::ops::Range;

use crate::numerics::linalg::{Matrix, add_product};
use crate::robot::effects::contact::plan::Contacts;
use crate::robot::plan::space::Space;

/// Number of products that are summed at once: those of sixteen contact points, which still are near the processor.
const MAX_PRODUCTS: usize = 7 * 16;

/// Largest number of products of a side of a contact point: its wrench, and the shares of its nodes.
const OF_A_SIDE: usize = 7;

/// Factors of products that wait to be added, with one row for each coordinate that moves the pair.
#[derive(Clone, Debug)]
pub(crate) struct Products {
    sides: [Factors; 2],
    /// Largest number of coordinates that move a pair.
    rows: usize,
}

/// Left and right factors, column by column.
#[derive(Clone, Debug)]
struct Factors {
    left: Vec<f64>,
    right: Vec<f64>,
    columns: usize,
}

impl Products {
    /// Memory for the pairs of a robot.
    pub(super) fn new<G: Space>(contacts: &Contacts<G>) -> Self {
        let numbers = contacts.pairs.iter().map(|pair| pair.reaches.iter().map(Range::len).sum());
        let rows = numbers.max().unwrap_or(0);
        let factors = || Factors {
            left: vec![0.0; MAX_PRODUCTS * rows],
            right: vec![0.0; MAX_PRODUCTS * rows],
            columns: 0,
        };
        Self { sides: [factors(), factors()], rows }
    }

    /// Adds a product of a side; both factors have an entry for each coordinate of the robot.
    #[inline(always)]
    pub(super) fn push(&mut self, side: usize, reaches: &[Range<usize>], left: &[f64], right: &[f64]) {
        let Self { sides, rows } = self;
        let factors = &mut sides[side];
        let own = factors.columns * *rows..(factors.columns + 1) * *rows;
        for (to, from) in [(&mut factors.left, left), (&mut factors.right, right)] {
            let mut to = &mut to[own.clone()];
            for reach in reaches {
                let (here, rest) = to.split_at_mut(reach.len());
                here.copy_from_slice(&from[reach.clone()]);
                to = rest;
            }
        }
        factors.columns += 1;
    }

    /// Whether the products of another contact point may not fit.
    pub(super) fn are_full(&self) -> bool {
        self.sides.iter().any(|factors| factors.columns + OF_A_SIDE > MAX_PRODUCTS)
    }

    /// Adds the products to the tangent, and forgets them.
    pub(super) fn add_to(&mut self, reaches: &[Range<usize>], tangent: &mut Matrix) {
        let Self { sides, rows } = self;
        for Factors { left, right, columns } in sides {
            let number = std::mem::take(columns);
            if number == 0 {
                continue;
            }
            let [left, right] = [&*left, &*right].map(|factor| &factor[..number * *rows]);
            let mut place = 0;
            for reach in reaches {
                let own = place..place + reach.len();
                place = own.end;
                // Coordinates that move only the other side have no entries here.
                let mut entries = left.chunks_exact(*rows).flat_map(|column| &column[own.clone()]);
                if entries.all(|entry| *entry == 0.0) {
                    continue;
                }
                let mut other = 0;
                for of_columns in reaches {
                    let there = other..other + of_columns.len();
                    other = there.end;
                    let block = [reach.clone(), of_columns.clone()];
                    add_product(tangent, block, *rows, [(left, own.clone()), (right, there)]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products of pairs that two ranges of coordinates move, against their sums one by one.
    #[test]
    fn products_are_those_of_all_contact_points() {
        let (n, reaches) = (9, [1..3, 5..9]);
        let rows = 6;
        let factors = || Factors {
            left: vec![0.0; MAX_PRODUCTS * rows],
            right: vec![0.0; MAX_PRODUCTS * rows],
            columns: 0,
        };
        let mut products = Products { sides: [factors(), factors()], rows };
        let mut tangent = Matrix::from_fn(n, n, |i, j| (i + 2 * j) as f64);
        let mut wanted = tangent.clone();
        for touch in 0..40 {
            let value = |seed: usize| ((touch * 31 + seed * 17) % 23) as f64 - 11.0;
            for component in 0..OF_A_SIDE {
                for side in 0..2 {
                    let left: Vec<f64> = (0..n)
                        .map(|k| if reaches[side].contains(&k) { value(k + component) } else { 0.0 })
                        .collect();
                    let right: Vec<f64> = (0..n)
                        .map(|k| if k == 0 || k == 4 { 0.0 } else { value(3 * k + 5 * component) })
                        .collect();
                    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                        let is_reached = reaches.iter().any(|reach| reach.contains(&j));
                        wanted[(i, j)] += if is_reached { left[i] * right[j] } else { 0.0 };
                    }
                    products.push(side, &reaches, &left, &right);
                }
            }
            if products.are_full() {
                products.add_to(&reaches, &mut tangent);
            }
        }
        products.add_to(&reaches, &mut tangent);
        assert_eq!(tangent, wanted);
    }
}
