//! The types that fields may have.

use super::data::{Data, Item, Kind, Limits, Value};
use super::data::{Fault, Reader};
use crate::error::Number;

impl Data for f64 {
    const KIND: Kind = Kind::Number;

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        match value {
            Value::Number(number) => Some(*number),
            Value::Integer(number) => Some(*number as Self),
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        if !limits.contain(*self) {
            reader.require(false, "", Number(*self), &limits.expected());
        }
    }

    fn write(&self) -> Value {
        Value::Number(*self)
    }
}

impl Data for bool {
    const KIND: Kind = Kind::Flag;

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        if let Value::Flag(flag) = value { Some(*flag) } else { reader.wrong_type(value, &Self::KIND) }
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        Value::Flag(*self)
    }
}

impl Data for String {
    const KIND: Kind = Kind::Text;

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        if let Value::Text(text) = value { Some(text.clone()) } else { reader.wrong_type(value, &Self::KIND) }
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        Value::Text(self.clone())
    }
}

/// The name of a link of the robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkName(pub String);

impl From<&str> for LinkName {
    fn from(name: &str) -> Self {
        Self(name.to_owned())
    }
}

impl Data for LinkName {
    const KIND: Kind = Kind::Reference("links");

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        String::read(value, reader).map(Self)
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        Value::Text(self.0.clone())
    }
}

impl<T: Data> Data for Option<T> {
    const KIND: Kind = Kind::Optional(&T::KIND);
    const ABSENT: Option<fn() -> Value> = Some(|| Value::None);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        if matches!(value, Value::None) { Some(None) } else { T::read(value, reader).map(Some) }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        self.iter().for_each(|value| value.check(limits, reader));
    }

    fn write(&self) -> Value {
        self.as_ref().map_or(Value::None, T::write)
    }
}

impl<T: Data> Data for Box<T> {
    const KIND: Kind = T::KIND;

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        T::read(value, reader).map(Self::new)
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        self.as_ref().check(limits, reader);
    }

    fn write(&self) -> Value {
        self.as_ref().write()
    }
}

/// Reads each item of a list, and reports another number of them than `count`.
pub(crate) fn items<T: Data>(
    value: &Value,
    count: Option<usize>,
    kind: &Kind,
    reader: &mut Reader,
) -> Option<Vec<T>> {
    let Value::List(items) = value else { return reader.wrong_type(value, kind) };
    let read = |(i, item): (usize, &Value)| reader.at_item(i, |reader| T::read(item, reader));
    let found: Vec<Option<T>> = items.iter().enumerate().map(read).collect();
    if count.is_some_and(|count| count != items.len()) {
        let found = format!("an array of {}", items.len());
        reader.refuse("", Fault::Type { found, expected: kind.words() });
        return None;
    }
    found.into_iter().collect()
}

impl<const N: usize> Data for [f64; N] {
    const KIND: Kind = Kind::Array(&Kind::Number, N);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        items(value, Some(N), &Self::KIND, reader)?.try_into().ok()
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        for (i, number) in self.iter().enumerate() {
            reader.at_item(i, |reader| number.check(limits, reader));
        }
    }

    fn write(&self) -> Value {
        Value::List(self.iter().map(f64::write).collect())
    }
}

/// Rows of a symmetric matrix, or its diagonal.
impl<const N: usize> Data for [[f64; N]; N] {
    const KIND: Kind = Kind::Array(&<[f64; N]>::KIND, N);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        if let Value::Rows { numbers, columns } = value
            && (*columns, numbers.len()) == (N, N * N)
        {
            return numbers.as_chunks().0.try_into().ok();
        }
        if let Value::List(entries) = value
            && matches!(entries.first(), Some(Value::Number(_) | Value::Integer(_)))
        {
            let diagonal: [f64; N] = items(value, Some(N), &Self::KIND, reader)?.try_into().ok()?;
            let entry = |i: usize, j: usize| if i == j { diagonal[i] } else { 0.0 };
            return Some(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))));
        }
        items(value, Some(N), &Self::KIND, reader)?.try_into().ok()
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        for (i, row) in self.iter().enumerate() {
            reader.at_item(i, |reader| row.check(limits, reader));
        }
    }

    fn write(&self) -> Value {
        Value::Rows { numbers: self.concat(), columns: N }
    }
}

/// A symmetric matrix, whose symmetry the part checks that has it; a diagonal one may be given by its diagonal.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetric<const N: usize>(pub [[f64; N]; N]);

impl<const N: usize> Symmetric<N> {
    /// The diagonal, if there is nothing else.
    fn diagonal(&self) -> Option<[f64; N]> {
        let is_zero = |i: usize, j: usize| i == j || self.0[i][j].to_bits() == 0;
        let is_diagonal = (0..N).all(|i| (0..N).all(|j| is_zero(i, j)));
        is_diagonal.then(|| std::array::from_fn(|i| self.0[i][i]))
    }
}

impl<const N: usize> Item for Symmetric<N> {}

impl<const N: usize> Data for Symmetric<N> {
    const KIND: Kind = Kind::Symmetric(N);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        <[[f64; N]; N]>::read(value, reader).map(Self)
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        self.0.check(limits, reader);
    }

    fn write(&self) -> Value {
        self.diagonal().map_or_else(|| self.0.write(), |diagonal| diagonal.write())
    }
}

impl Data for usize {
    const KIND: Kind = Kind::Integer;

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        let Value::Integer(number) = value else { return reader.wrong_type(value, &Self::KIND) };
        let found = Self::try_from(*number).ok();
        if found.is_none() {
            reader.require(false, "", number, &Self::KIND.words());
        }
        found
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        Value::Integer(*self as i64)
    }
}

impl<const N: usize> Data for [usize; N] {
    const KIND: Kind = Kind::Array(&Kind::Integer, N);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        items(value, Some(N), &Self::KIND, reader)?.try_into().ok()
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        Value::List(self.iter().map(usize::write).collect())
    }
}

/// One number for each direction; a single number stands for equal ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerAxis<const N: usize>(pub [f64; N]);

impl<const N: usize> Data for PerAxis<N> {
    const KIND: Kind = Kind::OneOrEach(N);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        match value {
            Value::Number(_) | Value::Integer(_) => f64::read(value, reader).map(|number| Self([number; N])),
            Value::List(_) => items(value, Some(N), &<[f64; N]>::KIND, reader)?.try_into().ok().map(Self),
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        let Self(numbers) = self;
        // NaN is even, too.
        if numbers.iter().all(|number| number.to_bits() == numbers[0].to_bits()) {
            numbers[0].check(limits, reader);
        } else {
            numbers.check(limits, reader);
        }
    }

    fn write(&self) -> Value {
        self.0.write()
    }
}

/// Coefficients of friction for each direction of sliding, and at rest, where that is given with them: two numbers are those at rest and of
/// sliding in any direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction<const N: usize> {
    /// For each direction; one number stands for equal ones.
    pub sliding: PerAxis<N>,
    /// At rest; `None` if it is not given with the others.
    pub at_rest: Option<f64>,
}

impl<const N: usize> Data for Friction<N> {
    const KIND: Kind = Kind::AtRestOrEach(N);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        match value {
            Value::List(numbers) if numbers.len() == 2 => {
                let [at_rest, sliding] = <[f64; 2]>::read(value, reader)?;
                Some(Self { sliding: PerAxis([sliding; N]), at_rest: Some(at_rest) })
            }
            Value::List(numbers) if numbers.len() != N => {
                let found = format!("an array of {}", numbers.len());
                reader.refuse("", Fault::Type { found, expected: Self::KIND.words() });
                None
            }
            Value::Number(_) | Value::Integer(_) | Value::List(_) => {
                PerAxis::read(value, reader).map(|sliding| Self { sliding, at_rest: None })
            }
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        self.sliding.check(limits, reader);
        self.at_rest.inspect(|at_rest| at_rest.check(limits, reader));
    }

    fn write(&self) -> Value {
        match self.at_rest {
            Some(at_rest) => [at_rest, self.sliding.0[0]].write(),
            None => self.sliding.write(),
        }
    }
}

/// Numbers in rows of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// All numbers, one row after the other.
    pub numbers: Vec<f64>,
    /// Number of rows, and of numbers in each.
    pub shape: [usize; 2],
}

impl Data for Rows {
    const KIND: Kind = Kind::List(&Kind::List(&Kind::Number));

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        if let Value::Rows { numbers, columns } = value {
            let rows = numbers.len().checked_div(*columns).unwrap_or(0);
            return Some(Self { numbers: numbers.clone(), shape: [rows, *columns] });
        }
        let rows: Vec<Vec<f64>> = items(value, None, &Self::KIND, reader)?;
        let columns = rows.first().map_or(0, Vec::len);
        if let Some(row) = rows.iter().position(|row| row.len() != columns) {
            let found = format!("{} numbers", rows[row].len());
            let expected = format!("{columns} numbers, as many as in the first row");
            reader.require(false, &format!("[{row}]"), found, &expected);
            return None;
        }
        Some(Self { shape: [rows.len(), columns], numbers: rows.concat() })
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        for (i, number) in self.numbers.iter().enumerate().filter(|(_, number)| !limits.contain(**number)) {
            let [row, column] = [i / self.shape[1], i % self.shape[1]];
            reader.require(false, &format!("[{row}][{column}]"), Number(*number), &limits.expected());
        }
    }

    fn write(&self) -> Value {
        Value::Rows { numbers: self.numbers.clone(), columns: self.shape[1] }
    }
}

/// Numbers in layers of rows, all of one shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// All numbers, the last index varying fastest.
    pub numbers: Vec<f64>,
    /// Number of layers, of rows in each, and of numbers in each row.
    pub shape: [usize; 3],
}

impl Data for Layers {
    const KIND: Kind = Kind::List(&Rows::KIND);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        let layers: Vec<Rows> = items(value, None, &Self::KIND, reader)?;
        let [rows, columns] = layers.first().map_or([0; 2], |layer| layer.shape);
        if let Some(layer) = layers.iter().position(|layer| layer.shape != [rows, columns]) {
            let [found, of] = layers[layer].shape;
            let expected = format!("{rows} rows of {columns} numbers, as in the first layer");
            reader.require(
                false,
                &format!("[{layer}]"),
                format_args!("{found} rows of {of} numbers"),
                &expected,
            );
            return None;
        }
        let shape = [layers.len(), rows, columns];
        Some(Self { shape, numbers: layers.into_iter().flat_map(|layer| layer.numbers).collect() })
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        for (i, number) in self.numbers.iter().enumerate().filter(|(_, number)| !limits.contain(**number)) {
            let [_, rows, columns] = self.shape;
            let place = [i / (rows * columns), i / columns % rows, i % columns];
            let place = place.map(|i| format!("[{i}]")).concat();
            reader.require(false, &place, Number(*number), &limits.expected());
        }
    }

    fn write(&self) -> Value {
        let [_, rows, columns] = self.shape;
        let layer = |numbers: &[f64]| Value::Rows { numbers: numbers.to_vec(), columns };
        Value::List(self.numbers.chunks((rows * columns).max(1)).map(layer).collect())
    }
}

impl Data for Vec<f64> {
    const KIND: Kind = Kind::List(&Kind::Number);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        items(value, None, &Self::KIND, reader)
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        for (i, number) in self.iter().enumerate().filter(|(_, number)| !limits.contain(**number)) {
            reader.require(false, &format!("[{i}]"), Number(*number), &limits.expected());
        }
    }

    fn write(&self) -> Value {
        Value::List(self.iter().map(f64::write).collect())
    }
}

/// Rows of three numbers, from lists or from rows of numbers.
fn triples<T: Data>(value: &Value, kind: &Kind, reader: &mut Reader) -> Option<Vec<T>> {
    let Value::Rows { numbers, columns } = value else { return items(value, None, kind, reader) };
    let is_integer = matches!(kind, Kind::List(Kind::Array(Kind::Integer, _)));
    let number = |number: &f64| match is_integer {
        true if number.fract() == 0.0 => Value::Integer(*number as i64),
        _ => Value::Number(*number),
    };
    let rows = numbers.chunks((*columns).max(1)).map(|row| Value::List(row.iter().map(number).collect()));
    items(&Value::List(rows.collect()), None, kind, reader)
}

impl<const N: usize> Data for Vec<[f64; N]> {
    const KIND: Kind = Kind::List(&<[f64; N]>::KIND);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        triples(value, &Self::KIND, reader)
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        for (i, row) in self.iter().enumerate() {
            reader.at_item(i, |reader| row.check(limits, reader));
        }
    }

    fn write(&self) -> Value {
        Value::Rows { numbers: self.concat(), columns: N }
    }
}

impl Data for Vec<[usize; 3]> {
    const KIND: Kind = Kind::List(&<[usize; 3]>::KIND);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        triples(value, &Self::KIND, reader)
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        Value::List(self.iter().map(<[usize; 3]>::write).collect())
    }
}

impl<T: Item> Data for Vec<T> {
    const KIND: Kind = Kind::List(&T::KIND);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        items(value, None, &Self::KIND, reader)
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        for (i, item) in self.iter().enumerate() {
            reader.at_item(i, |reader| item.check(limits, reader));
        }
    }

    fn write(&self) -> Value {
        Value::List(self.iter().map(T::write).collect())
    }
}
