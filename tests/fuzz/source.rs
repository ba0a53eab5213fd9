//! Structured values from bytes, as in the crate `arbitrary`: every input has a meaning, and a small change
//! of the bytes is a small change of the meaning. Missing bytes are zero, which selects the simplest choice.

/// Critical numbers for formulas.
pub(crate) const EXTREMES: [f64; 28] = [
    0.0,
    -0.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    1e300,
    -1e300,
    1e-300,
    1e200,
    1e-200,
    1.4e154,
    1e155,
    1e-155,
    1e100,
    1e-100,
    1e77,
    1e30,
    1e-30,
    1e15,
    1e5,
    1e3,
    -1.0,
    1.0 - f64::EPSILON,
    1.0 + f64::EPSILON,
];

/// The remaining bytes.
#[derive(Debug)]
pub(crate) struct Source<'a>(pub(crate) &'a [u8]);

impl Source<'_> {
    pub(crate) fn byte(&mut self) -> u8 {
        match self.0 {
            [first, rest @ ..] => {
                self.0 = rest;
                *first
            }
            [] => 0,
        }
    }

    /// A number below `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        let number = usize::from(self.byte());
        if end > 256 { (256 * number + usize::from(self.byte())) % end } else { number % end }
    }

    /// True with a probability of 1 / `times`.
    pub(crate) fn one_in(&mut self, times: usize) -> bool {
        self.below(times) == times - 1
    }

    /// Mostly the usual number, rarely another.
    pub(crate) fn near(&mut self, usual: f64) -> f64 {
        match self.byte() {
            0..=199 => usual,
            200..=219 => usual * (self.byte() as f64 / 128.0),
            220..=234 => usual * 10f64.powi(i32::from(self.byte() as i8) / 4),
            235..=249 => EXTREMES[self.below(EXTREMES.len())],
            _ => f64::from_bits(u64::from_le_bytes(std::array::from_fn(|_| self.byte()))),
        }
    }

    /// N numbers, mostly zero.
    pub(crate) fn zeros<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| if self.one_in(4) { self.near(0.1) } else { 0.0 })
    }

    /// Mostly the usual numbers, rarely others.
    pub(crate) fn like<const N: usize>(&mut self, usual: [f64; N]) -> [f64; N] {
        usual.map(|number| self.near(number))
    }

    /// Something with a probability of 1 / `times`, else nothing.
    pub(crate) fn maybe<T>(&mut self, times: usize, make: impl FnOnce(&mut Self) -> T) -> Option<T> {
        if self.one_in(times) { Some(make(self)) } else { None }
    }

    /// Up to `most` items, usually few.
    pub(crate) fn some<T>(&mut self, most: usize, mut make: impl FnMut(&mut Self) -> T) -> Vec<T> {
        let number = self.below(most + 1).min(self.below(most + 1));
        (0..number).map(|_| make(self)).collect()
    }
}
