//! Serialisation of the state between steps. One function both writes and reads it, so that both agree.

/// Largest whole number below which all are represented exactly.
const LARGEST_COUNT: f64 = (1_u64 << f64::MANTISSA_DIGITS) as f64;

/// Records the values passed to it in order, or replaces them with the recorded ones.
#[derive(Debug)]
pub struct Tape<'a>(Mode<'a>);

#[derive(Debug)]
enum Mode<'a> {
    Writing(&'a mut Vec<f64>),
    Reading { rest: &'a [f64], is_right: bool },
}

impl<'a> Tape<'a> {
    /// Appends to `numbers`.
    pub fn writing(numbers: &'a mut Vec<f64>) -> Self {
        Self(Mode::Writing(numbers))
    }

    /// Reads from `numbers`.
    pub fn reading(numbers: &'a [f64]) -> Self {
        Self(Mode::Reading { rest: numbers, is_right: true })
    }

    /// True if values are replaced.
    pub fn reads(&self) -> bool {
        matches!(self.0, Mode::Reading { .. })
    }

    /// True if all numbers were read.
    pub fn is_over(&self) -> bool {
        matches!(&self.0, Mode::Reading { rest: [], .. })
    }

    /// False if too few or too many numbers were read, or a number outside the allowed values.
    pub fn is_right(&self) -> bool {
        match &self.0 {
            Mode::Writing(_) => true,
            Mode::Reading { is_right, .. } => *is_right && self.is_over(),
        }
    }

    /// Reads or writes `values.len()` numbers.
    pub fn numbers(&mut self, values: &mut [f64]) {
        match &mut self.0 {
            Mode::Writing(numbers) => numbers.extend_from_slice(values),
            Mode::Reading { rest, is_right } => match rest.split_at_checked(values.len()) {
                Some((here, behind)) => {
                    values.copy_from_slice(here);
                    *rest = behind;
                }
                None => *is_right = false,
            },
        }
    }

    /// One number.
    pub fn number(&mut self, value: &mut f64) {
        self.numbers(std::slice::from_mut(value));
    }

    /// A whole number less than `end`.
    pub fn below(&mut self, end: usize, value: &mut usize) {
        let mut number = *value as f64;
        self.number(&mut number);
        if let Mode::Reading { is_right, .. } = &mut self.0 {
            if (0.0..=LARGEST_COUNT).contains(&number) && number.fract() == 0.0 && (number as usize) < end {
                *value = number as usize;
            } else {
                *is_right = false;
            }
        }
    }

    /// A whole number.
    pub fn count(&mut self, value: &mut usize) {
        self.below(usize::MAX, value);
    }

    /// A small whole number.
    pub fn small_count(&mut self, value: &mut u32) {
        let mut number = *value as usize;
        self.below(u32::MAX as usize, &mut number);
        *value = number as u32;
    }

    /// A Boolean.
    pub fn flag(&mut self, value: &mut bool) {
        let mut number = usize::from(*value);
        self.below(2, &mut number);
        *value = number == 1;
    }

    /// An optional value; `blank` is the initial value for reading.
    pub fn optional<T>(&mut self, value: &mut Option<T>, blank: T, each: impl FnOnce(&mut Self, &mut T)) {
        let mut is_there = value.is_some();
        self.flag(&mut is_there);
        if self.reads() {
            *value = is_there.then_some(blank);
        }
        if let Some(value) = value {
            each(self, value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One of each kind.
    #[derive(Clone, Debug, Default, PartialEq)]
    struct Things {
        x: f64,
        xs: [f64; 3],
        count: usize,
        flag: bool,
        some: Option<f64>,
        none: Option<f64>,
    }

    impl Things {
        fn pass(&mut self, tape: &mut Tape<'_>) {
            tape.number(&mut self.x);
            tape.numbers(&mut self.xs);
            tape.count(&mut self.count);
            tape.flag(&mut self.flag);
            tape.optional(&mut self.some, 0.0, Tape::number);
            tape.optional(&mut self.none, 0.0, Tape::number);
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let mut things = Things {
            x: -0.0,
            xs: [1.0, f64::INFINITY, 1e-300],
            count: 1 << 40,
            flag: true,
            some: Some(2.5),
            none: None,
        };
        let mut numbers = Vec::new();
        things.pass(&mut Tape::writing(&mut numbers));
        let mut others = Things { none: Some(1.0), ..Things::default() };
        let mut tape = Tape::reading(&numbers);
        others.pass(&mut tape);
        assert!(tape.is_right());
        assert_eq!(others, things);
        assert!(others.x.is_sign_negative());
    }

    #[test]
    fn what_is_damaged_is_not_right() {
        let mut numbers = Vec::new();
        Things::default().pass(&mut Tape::writing(&mut numbers));
        let is_right = |numbers: &[f64]| {
            let mut tape = Tape::reading(numbers);
            Things::default().pass(&mut tape);
            tape.is_right()
        };
        assert!(is_right(&numbers));
        assert!(!is_right(&numbers[1..]) && !is_right(&[]));
        assert!(!is_right(&[&numbers[..], &[0.0]].concat()));
        for (place, wrong) in [(4, -1.0), (4, 0.5), (4, f64::NAN), (4, 1e300), (5, 2.0), (6, 1.0)] {
            let mut damaged = numbers.clone();
            damaged[place] = wrong;
            assert!(!is_right(&damaged), "{wrong} at {place}");
        }
    }
}
