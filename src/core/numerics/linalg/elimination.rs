//! The order in which blocks of unknowns are eliminated from a sparse system, by the minimum-degree rule (Tinney and Walker 1967)
//! on the explicit elimination graph of the blocks (George and Liu 1989), which is small.

/// The number of nodes in a word of a set.
const WORD: usize = u64::BITS as usize;

/// Blocks, which of them are coupled, and the order of their elimination.
#[derive(Clone, Debug)]
pub(super) struct Elimination {
    sizes: Vec<usize>,
    /// Words of a set of blocks.
    words: usize,
    /// For each block, the set of blocks coupled with it; after [`Self::find_order`] only the later ones.
    neighbours: Vec<u64>,
    /// For each block, the number of unknowns in that set.
    degrees: Vec<usize>,
    /// Copy of the set of the block that is being eliminated.
    pivot: Vec<u64>,
    left: Vec<usize>,
    order: Vec<usize>,
}

impl Elimination {
    /// Memory for blocks of this many unknowns.
    pub(super) fn new(sizes: &[usize]) -> Self {
        let blocks = sizes.len();
        let words = blocks.div_ceil(WORD).max(1);
        Self {
            sizes: sizes.to_vec(),
            words,
            neighbours: vec![0; blocks * words],
            degrees: vec![0; blocks],
            pivot: vec![0; words],
            left: Vec::with_capacity(blocks),
            order: Vec::with_capacity(blocks),
        }
    }

    /// Uncouples all blocks.
    pub(super) fn clear(&mut self) {
        self.neighbours.fill(0);
    }

    /// Couples two different blocks.
    pub(super) fn couple(&mut self, i: usize, j: usize) {
        for (i, j) in [(i, j), (j, i)] {
            self.neighbours[i * self.words + j / WORD] |= 1 << (j % WORD);
        }
    }

    /// Whether two blocks are coupled; after [`Self::find_order`], whether `j` is eliminated later than `i` and coupled with it.
    pub(super) fn are_coupled(&self, i: usize, j: usize) -> bool {
        contains(&self.neighbours[i * self.words..][..self.words], j)
    }

    /// Whether `next`, the block eliminated right after `i`, has the same couplings as `i` (apart from each other).
    pub(super) fn is_continued_by(&self, i: usize, next: usize) -> bool {
        self.are_coupled(i, next) && self.degrees[i] == self.degrees[next] + self.sizes[next]
    }

    /// The order of [`Self::find_order`].
    pub(super) fn order(&self) -> &[usize] {
        &self.order
    }

    /// Finds the order: the next block is the one coupled with the fewest unknowns, the first of several. Returns the number
    /// of multiplications of a factorisation in that order.
    pub(super) fn find_order(&mut self) -> f64 {
        let Self { sizes, words, neighbours, degrees, pivot, left, order } = self;
        let words = *words;
        let unknowns = |set: &[u64]| -> usize { members(set).map(|i| sizes[i]).sum() };
        for (degree, set) in degrees.iter_mut().zip(neighbours.chunks_exact(words)) {
            *degree = unknowns(set);
        }
        order.clear();
        left.clear();
        left.extend(0..sizes.len());
        let mut products = 0.0;
        while let Some(place) = (0..left.len()).min_by_key(|&place| (degrees[left[place]], left[place])) {
            let i = left.swap_remove(place);
            order.push(i);
            let (own, coupled) = (sizes[i] as f64, degrees[i] as f64);
            products += own * (own * own / 3.0 + coupled * (own + coupled));
            pivot.copy_from_slice(&neighbours[i * words..][..words]);
            for j in members(pivot) {
                let set = &mut neighbours[j * words..][..words];
                for (word, pivot) in set.iter_mut().zip(&*pivot) {
                    *word |= pivot;
                }
                for k in [i, j] {
                    set[k / WORD] &= !(1 << (k % WORD));
                }
                degrees[j] = unknowns(set);
            }
        }
        products
    }
}

fn contains(set: &[u64], i: usize) -> bool {
    set[i / WORD] >> (i % WORD) & 1 == 1
}

fn members(set: &[u64]) -> impl Iterator<Item = usize> {
    set.iter().enumerate().flat_map(|(w, &word)| {
        let mut rest = word;
        std::iter::from_fn(move || {
            let i = rest.trailing_zeros() as usize;
            rest &= rest.checked_sub(1)?;
            Some(w * WORD + i)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A star is eliminated from its leaves; in a ring each block has at most two later neighbours.
    #[test]
    fn few_couplings_are_added() {
        let mut star = Elimination::new(&[2; 100]);
        for i in (0..100).filter(|&i| i != 70) {
            star.couple(i, 70);
        }
        star.find_order();
        assert!(star.order()[..98].iter().all(|&i| i != 70));
        assert!((0..100).all(|i| (0..100).filter(|&j| star.are_coupled(i, j)).count() <= 1));

        let mut ring = Elimination::new(&[1; 67]);
        for i in 0..67 {
            ring.couple(i, (i + 1) % 67);
        }
        let products = ring.find_order();
        assert!((0..67).all(|i| (0..67).filter(|&j| ring.are_coupled(i, j)).count() <= 2));
        assert!(products <= 67.0 * (1.0 / 3.0 + 2.0 + 4.0), "{products}");
    }

    /// Every block comes once, and the neighbours of an eliminated block are coupled with each other afterwards.
    #[test]
    fn the_graph_is_one_of_elimination() {
        let sizes: Vec<usize> = (0..40).map(|i| 1 + i % 4).collect();
        let mut graph = Elimination::new(&sizes);
        for i in 0..40 {
            for j in [(7 * i + 3) % 40, (i * i + 11) % 40] {
                if i != j {
                    graph.couple(i, j);
                }
            }
        }
        graph.find_order();
        let mut sorted = graph.order().to_vec();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..40));
        let order = graph.order();
        for (place, &i) in order.iter().enumerate() {
            let coupled: Vec<usize> = (0..40).filter(|&j| graph.are_coupled(i, j)).collect();
            assert!(coupled.iter().all(|j| order[place + 1..].contains(j)));
            for (&j, &k) in coupled.iter().flat_map(|j| coupled.iter().map(move |k| (j, k))) {
                assert!(j == k || graph.are_coupled(j, k) || graph.are_coupled(k, j));
            }
            if let Some(&next) = order.get(place + 1) {
                let others: Vec<usize> = coupled.iter().copied().filter(|&j| j != next).collect();
                let same = (0..40).filter(|&j| graph.are_coupled(next, j)).eq(others.iter().copied());
                assert_eq!(graph.is_continued_by(i, next), same && others.len() < coupled.len());
            }
        }
    }
}
