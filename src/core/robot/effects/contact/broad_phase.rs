//! Candidate pairs of curves, of two rods or of one rod with itself, that may be close to each other.
//!
//! The curves of a rod are the leaves of a binary tree, in the order along the rod, and each branch has a
//! bounding ball. Branches with disjoint balls contain no close curves. Successive branches of one rod always
//! overlap: there the search descends to the curves around their common end, so that its cost is linear in
//! the number of curves.

use std::ops::Range;

use crate::numerics::lie::Vector;
use crate::robot::effects::contact::plan::{Contacts, Curve, Pair};
use crate::robot::effects::contact::shapes::distance;
use crate::robot::plan::space::Space;

/// Centre and radius.
pub(crate) type Ball = (Vector<f64>, f64);

/// Computes the bounding balls of the branches of all rods, in depth-first order, from those of their curves.
pub(super) fn enclose<G: Space>(contacts: &Contacts<G>, curves: &[Ball], branches: &mut [Ball]) {
    for rod in &contacts.rods {
        enclose_branch(&curves[rod.clone()], &mut branches[balls_of(rod)]);
    }
}

/// Range of the balls of a rod's branches: a tree over c leaves has 2 c - 1 of them.
fn balls_of(rod: &Range<usize>) -> Range<usize> {
    2 * rod.start..2 * rod.end - 1
}

fn enclose_branch(leaves: &[Ball], branches: &mut [Ball]) -> Ball {
    let ball = if leaves.len() == 1 {
        leaves[0]
    } else {
        let (first, second) = leaves.split_at(leaves.len() / 2);
        let (of_first, of_second) = branches[1..].split_at_mut(2 * first.len() - 1);
        around(enclose_branch(first, of_first), enclose_branch(second, of_second))
    };
    branches[0] = ball;
    ball
}

/// The smallest ball around two.
fn around((a, of_a): Ball, (b, of_b): Ball) -> Ball {
    let between = distance::between(a, b);
    if between + of_b <= of_a {
        return (a, of_a);
    }
    if between + of_a <= of_b {
        return (b, of_b);
    }
    let radius = 0.5 * (between + of_a + of_b);
    (a + (b - a) * ((radius - of_a) / between), radius)
}

/// Curves that follow each other along a rod, with their balls.
#[derive(Clone, Copy)]
struct Branch<'a> {
    first: usize,
    balls: &'a [Ball],
}

impl<'a> Branch<'a> {
    fn of(rod: &Range<usize>, branches: &'a [Ball]) -> Self {
        Self { first: rod.start, balls: &branches[balls_of(rod)] }
    }

    fn curves(&self) -> usize {
        self.balls.len().div_ceil(2)
    }

    fn last(&self) -> usize {
        self.first + self.curves() - 1
    }

    fn halves(&self) -> [Self; 2] {
        let half = self.curves() / 2;
        let (first, second) = self.balls[1..].split_at(2 * half - 1);
        [Self { first: self.first, balls: first }, Self { first: self.first + half, balls: second }]
    }

    fn is_apart(&self, other: &Self) -> bool {
        let ((centre, radius), (there, of_other)) = (self.balls[0], other.balls[0]);
        distance::between(centre, there) > radius + of_other
    }
}

/// Whether every part of a curve is a neighbour of every part of the same or a later curve of its rod.
fn are_neighbours<P>(curve: &Curve<P>, other: &Curve<P>, neighbourhood: f64) -> bool {
    let end_of_first_part = curve.start + curve.samples[1].x * curve.length;
    let last = other.samples.len() - 2;
    let begin_of_last_part = other.start + other.samples[last].x * other.length;
    begin_of_last_part < end_of_first_part + neighbourhood
}

/// Adds all pairs of curves of two rods whose balls overlap. For a rod with itself, adds every pair once, in the order along the rod, and
/// skips curves that are neighbours everywhere.
pub(super) fn gather<G: Space>(
    contacts: &Contacts<G>,
    pair: &Pair,
    [rod, other]: [&Range<usize>; 2],
    branches: &[Ball],
    found: &mut Vec<[usize; 2]>,
) {
    let is_excluded = |c: usize, o: usize| {
        pair.neighbourhood > 0.0
            && are_neighbours(&contacts.curves[c], &contacts.curves[o], pair.neighbourhood)
    };
    let [first, second] = [rod, other].map(|rod| Branch::of(rod, branches));
    if rod == other {
        gather_within(first, &is_excluded, found);
    } else {
        gather_between(first, second, &is_excluded, found);
    }
}

fn gather_within(
    branch: Branch<'_>,
    is_excluded: &impl Fn(usize, usize) -> bool,
    found: &mut Vec<[usize; 2]>,
) {
    if is_excluded(branch.first, branch.last()) {
        return;
    }
    if branch.curves() == 1 {
        return found.push([branch.first, branch.first]);
    }
    let [first, second] = branch.halves();
    gather_within(first, is_excluded, found);
    gather_within(second, is_excluded, found);
    gather_between(first, second, is_excluded, found);
}

fn gather_between(
    first: Branch<'_>,
    second: Branch<'_>,
    is_excluded: &impl Fn(usize, usize) -> bool,
    found: &mut Vec<[usize; 2]>,
) {
    if first.is_apart(&second) || is_excluded(first.first, second.last()) {
        return;
    }
    if first.curves() == 1 && second.curves() == 1 {
        return found.push([first.first, second.first]);
    }
    if first.curves() >= second.curves() {
        first.halves().into_iter().for_each(|half| gather_between(half, second, is_excluded, found));
    } else {
        second.halves().into_iter().for_each(|half| gather_between(first, half, is_excluded, found));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ball() -> impl Strategy<Value = Ball> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0, 0.0..0.3)
            .prop_map(|(x, y, z, radius)| (Vector::new(x, y, z), radius))
    }

    fn overlap((a, of_a): Ball, (b, of_b): Ball) -> bool {
        distance::between(a, b) <= of_a + of_b
    }

    /// The branches of rods of some numbers of curves, one after the other.
    fn branches_of(rods: &[Range<usize>], leaves: &[Ball]) -> Vec<Ball> {
        let mut branches = vec![(Vector::zero(), 0.0); 2 * leaves.len()];
        for rod in rods {
            enclose_branch(&leaves[rod.clone()], &mut branches[balls_of(rod)]);
        }
        branches
    }

    proptest! {
        #[test]
        fn balls_enclose_two(a in ball(), b in ball()) {
            let (centre, radius) = around(a, b);
            for (at, of_one) in [a, b] {
                prop_assert!(distance::between(centre, at) + of_one <= radius + 1e-12);
            }
        }

        /// All pairs that overlap are seen, each once.
        #[test]
        fn two_rods(leaves in prop::collection::vec(ball(), 2..40), at in 0.0..1.0) {
            let first = 1 + (at * (leaves.len() - 1) as f64) as usize;
            let rods = [0..first.min(leaves.len() - 1), first.min(leaves.len() - 1)..leaves.len()];
            let branches = branches_of(&rods, &leaves);
            let mut seen = Vec::new();
            let [a, b] = [&rods[0], &rods[1]].map(|rod| Branch::of(rod, &branches));
            gather_between(a, b, &|_, _| false, &mut seen);
            seen.sort_unstable();
            let wanted: Vec<_> = rods[0]
                .clone()
                .flat_map(|c| rods[1].clone().map(move |o| [c, o]))
                .filter(|&[c, o]| overlap(leaves[c], leaves[o]))
                .collect();
            prop_assert_eq!(seen, wanted);
        }

        /// Pairs of a rod with itself, except neighbours along it.
        #[test]
        fn one_rod(leaves in prop::collection::vec(ball(), 1..40), near in 0_usize..4) {
            let rod = 0..leaves.len();
            let branches = branches_of(std::slice::from_ref(&rod), &leaves);
            let mut seen = Vec::new();
            gather_within(Branch::of(&rod, &branches), &|c, o| o - c < near, &mut seen);
            seen.sort_unstable();
            let wanted: Vec<_> = (0..leaves.len())
                .flat_map(|c| (c..leaves.len()).map(move |o| [c, o]))
                .filter(|&[c, o]| o - c >= near && overlap(leaves[c], leaves[o]))
                .collect();
            prop_assert_eq!(seen, wanted);
        }
    }
}
