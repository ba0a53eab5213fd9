//! Functions of the arc length of a segment as users describe them: a value, two values at the ends, or a table.

use std::any::Any;
use std::sync::Arc;

use super::{Parts, Profile};
use crate::description::schema::{
    AnyPart, Data, Described, Kind, Limits, Part as _, Reader, Schema, Symmetric, Value,
};
use crate::error::Checker;

/// A value of a function of the arc length, as users give it.
trait Entries<const N: usize>: Data {
    fn entries(&self) -> [f64; N];
    fn of(entries: &[f64; N]) -> Self;
}

impl Entries<1> for f64 {
    fn entries(&self) -> [f64; 1] {
        [*self]
    }

    fn of(&[number]: &[f64; 1]) -> Self {
        number
    }
}

impl<const N: usize> Entries<N> for [f64; N] {
    fn entries(&self) -> [f64; N] {
        *self
    }

    fn of(entries: &[f64; N]) -> Self {
        *entries
    }
}

/// Symmetric matrices are kept row by row.
macro_rules! symmetric {
    ($($N:literal: $entries:literal),*) => {$(
        impl Entries<$entries> for Symmetric<$N> {
            fn entries(&self) -> [f64; $entries] {
                std::array::from_fn(|i| self.0[i / $N][i % $N])
            }

            fn of(entries: &[f64; $entries]) -> Self {
                Self(std::array::from_fn(|i| std::array::from_fn(|j| entries[$N * i + j])))
            }
        }
    )*};
}

symmetric!(3: 9, 6: 36);

/// A function of N numbers, whose values are given in this way, with its table in scenes.
macro_rules! described {
    ($N:literal, $Values:ty, $Table:ident) => {
        /// Values at places of a segment, with smooth interpolation that does not overshoot.
        #[derive(Clone, Debug, PartialEq, Described)]
        pub(super) struct $Table {
            /// Increasing arc lengths from the segment's base: the first is 0, the last the segment's length.
            #[part(unit = "metres")]
            stations: Vec<f64>,
            /// The value at each.
            values: Vec<$Values>,
        }

        impl Data for Profile<$N> {
            const KIND: Kind = Kind::Profile(&<$Values>::KIND, $Table::SCHEMA);

            fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
                match value {
                    Value::Part(_) => value.part::<Self>().cloned(),
                    Value::Table(_) => {
                        let before = reader.problems().len();
                        let table =
                            $Table::read(value, reader).filter(|_| reader.problems().len() == before)?;
                        let values: Vec<_> = table.values.iter().map(Entries::entries).collect();
                        let mut check = Checker::new();
                        let found = Self::table(&table.stations, &values);
                        let found = found.map_err(|error| check.all(Err(error))).ok();
                        reader.nested(check);
                        found
                    }
                    Value::Number(_) | Value::Integer(_) | Value::List(_) | Value::Rows { .. } => {
                        Some(<$Values>::read(value, reader)?.entries().into())
                    }
                    _ => reader.wrong_type(value, &Self::KIND),
                }
            }

            /// The part that has it checks functions along its segment.
            fn check(&self, limits: &Limits, reader: &mut Reader) {
                if let Parts::Constant(entries) = self.parts() {
                    <$Values as Entries<$N>>::of(entries).check(limits, reader);
                }
            }

            fn write(&self) -> Value {
                match self.parts() {
                    Parts::Constant(entries) => <$Values as Entries<$N>>::of(entries).write(),
                    _ => Value::Part(Arc::new(self.clone())),
                }
            }
        }

        /// The table; polynomials have what no table holds.
        impl AnyPart for Profile<$N> {
            fn schema(&self) -> &'static Schema {
                $Table::SCHEMA
            }

            fn field(&self, index: usize) -> Value {
                let Parts::Table(stations, values) = self.parts() else {
                    return Value::Other("a function".to_owned());
                };
                let values = values.iter().map(Entries::of).collect();
                $Table { stations: stations.to_vec(), values }.field(index)
            }

            fn same(&self, other: &dyn AnyPart) -> bool {
                (other as &dyn Any).downcast_ref() == Some(self)
            }

            fn check_any(&self, _: &mut Reader) {}
        }
    };
}

described!(1, f64, NumberTable);
described!(2, [f64; 2], PointTable);
described!(3, [f64; 3], VectorTable);
described!(6, [f64; 6], StrainTable);
described!(9, Symmetric<3>, InertiaTable);
described!(36, Symmetric<6>, StiffnessTable);

/// A size along a segment: a number, two numbers at base and tip between which it is linear, or a function of the arc length.
#[derive(Clone, Debug, PartialEq)]
pub struct Size(pub Profile<1>);

impl Data for Size {
    const KIND: Kind = Kind::Profile(&Kind::OneOrEach(2), NumberTable::SCHEMA);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        if let Value::List(_) = value {
            return <[f64; 2]>::read(value, reader).map(|ends| Self(Profile::linear(ends.map(|end| [end]))));
        }
        if matches!(value, Value::Number(_) | Value::Integer(_) | Value::Table(_) | Value::Part(_)) {
            return Profile::read(value, reader).map(Self);
        }
        reader.wrong_type(value, &Self::KIND)
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        match self.0.parts() {
            Parts::Linear(ends) => ends.map(|[end]| end).check(limits, reader),
            _ => self.0.check(limits, reader),
        }
    }

    fn write(&self) -> Value {
        match self.0.parts() {
            Parts::Linear(ends) => ends.map(|[end]| end).write(),
            _ => self.0.write(),
        }
    }
}
