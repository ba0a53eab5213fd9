//! Independent parts of a linear system with constraints, such as several cables of a robot, each fixed at both ends.

use crate::numerics::linalg::Matrix;

/// The connected components of `[S, G^T; G, 0]`: unknowns are coupled where an entry between them is not zero.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    /// Part of each unknown, numbered in the order of their first unknowns; coordinates first, then multipliers.
    pub(super) of: Vec<usize>,
    pub(super) count: usize,
    /// Links of a disjoint-set forest: for each unknown a lower one of its part, or itself for the first.
    next: Vec<usize>,
}

impl Parts {
    /// A single part with all unknowns.
    pub(super) fn new(unknowns: usize) -> Self {
        Self { of: vec![0; unknowns], count: 1, next: vec![0; unknowns] }
    }

    /// Finds the parts; returns whether they have changed. Cost: (n + m) n comparisons at most.
    pub(super) fn find(&mut self, tangent: &Matrix, constraints: &Matrix) -> bool {
        let (n, m) = (tangent.nrows(), constraints.nrows());
        let mut trees = n + m;
        self.next.iter_mut().enumerate().for_each(|(k, next)| *next = k);
        for k in 0..n {
            let entries = tangent.column(k);
            let rows = constraints.column(k);
            let coupled = entries.iter().chain(&rows).enumerate().filter(|(_, entry)| **entry != 0.0);
            for (i, _) in coupled {
                trees -= usize::from(join(&mut self.next, k, i));
            }
            if trees == 1 {
                break;
            }
        }
        self.number()
    }

    /// Numbers the parts; returns whether the part of any unknown has changed.
    fn number(&mut self) -> bool {
        let (mut count, mut is_new) = (0, false);
        for k in 0..self.next.len() {
            let root = root(&mut self.next, k);
            // The root of a tree is its first unknown.
            let part = if root == k { count } else { self.of[root] };
            count += usize::from(root == k);
            is_new |= self.of[k] != part;
            self.of[k] = part;
        }
        is_new |= self.count != count;
        self.count = count;
        is_new
    }
}

/// Merges the parts of two unknowns; returns whether they were different.
fn join(next: &mut [usize], first: usize, second: usize) -> bool {
    let (first, second) = (root(next, first), root(next, second));
    next[first.max(second)] = first.min(second);
    first != second
}

/// The first unknown of a part; halves the path to it.
fn root(next: &mut [usize], mut k: usize) -> usize {
    while next[k] != k {
        next[k] = next[next[k]];
        k = next[k];
    }
    k
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknowns_belong_together_that_entries_join() {
        let mut tangent = Matrix::identity(5, 5);
        let mut constraints = Matrix::zeros(3, 5);
        tangent[(4, 1)] = 1.0;
        constraints[(0, 3)] = 2.0;
        constraints[(1, 3)] = 2.0;
        constraints[(1, 0)] = f64::NAN;
        let mut parts = Parts::new(8);
        assert!(parts.find(&tangent, &constraints));
        assert_eq!(parts.of, [0, 1, 2, 0, 1, 0, 0, 3]);
        assert_eq!(parts.count, 4);
        assert!(!parts.find(&tangent, &constraints));
        constraints[(2, 2)] = 1.0;
        assert!(parts.find(&tangent, &constraints));
        assert_eq!((parts.count, parts.of[7]), (3, 2));
        constraints.fill(1.0);
        assert!(parts.find(&tangent, &constraints));
        assert_eq!(parts.of, [0; 8]);
        assert_eq!(parts.count, 1);
    }
}
