//! Running mean and variance of vectors.

/// Mean and sum of squared deviations of vectors (Welford 1962). Two of these can be merged (Chan, Golub and
/// LeVeque 1979), so that parts of the data can be accumulated separately.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spread {
    samples: usize,
    mean: Vec<f64>,
    squares: Vec<f64>,
}

impl Spread {
    /// Statistics of no vectors, with `width` numbers each.
    pub fn new(width: usize) -> Self {
        Self { samples: 0, mean: vec![0.0; width], squares: vec![0.0; width] }
    }

    /// Adds a vector.
    pub fn add(&mut self, values: impl IntoIterator<Item = f64>) {
        self.samples += 1;
        let count = self.samples as f64;
        for ((mean, square), value) in self.mean.iter_mut().zip(&mut self.squares).zip(values) {
            let before = value - *mean;
            *mean += before / count;
            *square += before * (value - *mean);
        }
    }

    /// Merges the statistics of further vectors.
    pub fn merge(&mut self, other: &Self) {
        if other.samples == 0 {
            return;
        }
        let [own, others] = [self.samples, other.samples].map(|samples| samples as f64);
        let all = own + others;
        let added = other.mean.iter().zip(&other.squares);
        for ((mean, square), (other_mean, other_square)) in
            self.mean.iter_mut().zip(&mut self.squares).zip(added)
        {
            let apart = other_mean - *mean;
            *mean += apart * others / all;
            *square += other_square + apart * apart * own * others / all;
        }
        self.samples += other.samples;
    }

    /// Number of vectors.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Mean; NaN without vectors.
    pub fn mean(&self) -> Vec<f64> {
        if self.samples == 0 { vec![f64::NAN; self.mean.len()] } else { self.mean.clone() }
    }

    /// Unbiased variance; NaN with fewer than two vectors.
    pub fn variance(&self) -> Vec<f64> {
        if self.samples < 2 {
            return vec![f64::NAN; self.squares.len()];
        }
        let freedom = (self.samples - 1) as f64;
        self.squares.iter().map(|square| square / freedom).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors far from zero, for which sums of squares would lose all digits.
    fn vectors() -> Vec<[f64; 2]> {
        (0..10).map(|i| [1e9 + f64::from(i), 1e9 - 3.0 * f64::from(i)]).collect()
    }

    fn of(vectors: &[[f64; 2]]) -> Spread {
        let mut spread = Spread::new(2);
        vectors.iter().for_each(|&vector| spread.add(vector));
        spread
    }

    #[test]
    fn mean_and_variance_are_those_of_the_whole_numbers() {
        let spread = of(&vectors());
        assert_eq!(spread.samples(), 10);
        assert_eq!(spread.mean(), [1e9 + 4.5, 1e9 - 13.5]);
        // Variance (n^2 - 1) / 12 times n / (n - 1) of n consecutive whole numbers.
        let wanted = 99.0 / 12.0 * 10.0 / 9.0;
        for (found, wanted) in spread.variance().iter().zip([wanted, 9.0 * wanted]) {
            assert!((found - wanted).abs() < 1e-9, "{found}");
        }
    }

    #[test]
    fn parts_that_are_merged_are_the_whole() {
        let all = of(&vectors());
        for cut in 0..=10 {
            let vectors = vectors();
            let (first, second) = vectors.split_at(cut);
            let mut merged = of(first);
            merged.merge(&of(second));
            assert_eq!(merged.samples(), 10);
            for (found, wanted) in merged.variance().iter().zip(all.variance()) {
                assert!((found - wanted).abs() < 1e-9, "{found}");
            }
        }
    }

    #[test]
    fn of_nothing_nothing_is_known() {
        let one = of(&vectors()[..1]);
        assert_eq!(one.mean(), vectors()[0]);
        assert!(one.variance()[0].is_nan() && Spread::new(1).mean()[0].is_nan());
    }
}
