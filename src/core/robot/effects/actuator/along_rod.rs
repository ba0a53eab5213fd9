//! Numbers along a rod as users describe them, before the length of the rod is known.

use std::any::Any;
use std::sync::Arc;

use crate::description::rod::{Parts, Profile, Unsampled};
use crate::description::schema::{
    AnyPart, Data, Described, Fault, Kind, Limits, Part as _, Reader, Schema, Value, items,
};
use crate::description::signal::Function;
use crate::error::{Checker, Number};

/// A number along a rod.
#[derive(Clone, Debug, PartialEq)]
pub enum AlongRod {
    /// The same everywhere.
    Constant(f64),
    /// Linear between two numbers at the ends of a part.
    Linear([f64; 2]),
    /// Numbers at stations along the whole rod, which are interpolated.
    Table(Table),
    /// Chebyshev coefficients, over a rod of this length in metres.
    Polynomial(f64, Vec<f64>),
    /// A function of the arc length in metres.
    Function(Function<1>),
}

/// Numbers along the rod of a link, with smooth interpolation that does not overshoot.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(name = "AlongRodTable", check = Table::fits)]
pub struct Table {
    /// Increasing arc lengths from the base of the rod: the first is 0, the last the length of the rod.
    #[part(unit = "metres")]
    pub stations: Vec<f64>,
    /// The number at each.
    pub values: Vec<f64>,
}

impl Table {
    fn profile(&self, check: &mut Checker) -> Option<Profile<1>> {
        let values: Vec<_> = self.values.iter().map(|value| [*value]).collect();
        Profile::table(&self.stations, &values).map_err(|error| check.all(Err(error))).ok()
    }

    fn fits(&self, reader: &mut Reader) {
        // Numbers that are not finite are reported by themselves.
        if self.stations.iter().chain(&self.values).all(|number| number.is_finite()) {
            let mut check = Checker::new();
            _ = self.profile(&mut check);
            reader.nested(check);
        }
    }
}

impl From<f64> for AlongRod {
    fn from(number: f64) -> Self {
        Self::Constant(number)
    }
}

impl AlongRod {
    /// The number along the whole rod of this length, where two numbers are at these arc lengths; `None` after reporting a
    /// problem.
    pub fn resolved(&self, [from, to]: [f64; 2], length: f64, reader: &mut Reader) -> Option<Profile<1>> {
        let mut check = Checker::new();
        let found = match self {
            Self::Constant(number) => Some((*number).into()),
            Self::Linear([start, end]) if from == 0.0 && to == length => {
                Some(Profile::linear([[*start], [*end]]))
            }
            Self::Linear([start, end]) => {
                let slope = (end - start) / (to - from);
                let ends = [[start - slope * from], [start + slope * (length - from)]];
                // Problems of the ends are reported with them.
                Some(if slope.is_finite() { Profile::linear(ends) } else { (*start).into() })
            }
            Self::Table(table) => match (&table.stations[..], &table.values[..]) {
                // Linear, and equal to it bit by bit.
                (&[0.0, end], &[base, tip]) if end == length => Some(Profile::linear([[base], [tip]])),
                _ => table.profile(&mut check).inspect(|profile| check.all(profile.validate(length))),
            },
            Self::Polynomial(own, coefficients) => {
                let found = format_args!("a profile over {own} m").to_string();
                let expected = format!("one over the rod's length, {length} m");
                check.require(*own == length, "", found, &expected);
                let rows: Vec<_> = coefficients.iter().map(|number| [*number]).collect();
                Profile::polynomial(&rows).map_err(|error| check.all(Err(error))).ok()
            }
            Self::Function(Function(function)) => match Profile::sampled(|x| function.value(x * length)) {
                Ok(profile) => Some(profile),
                Err(Unsampled::Failed(_)) => {
                    reader.refuse("", Fault::Failed);
                    None
                }
                Err(Unsampled::NonFinite { x, value, .. }) => {
                    let found = format!("{} at X = {}", Number(value), x * length);
                    check.require(false, "", found, "finite numbers");
                    None
                }
                Err(Unsampled::NotSmooth { x }) => {
                    let found = format!("a function that does not become smooth at X = {:.4}", x * length);
                    check.require(false, "", found, "a smooth one, or a table (stations, values)");
                    None
                }
            },
        };
        let is_right = check.is_ok();
        reader.nested(check);
        found.filter(|_| is_right)
    }

    /// The description of a profile along a rod of this length; resolving it gives the same profile bit by bit. Two numbers
    /// belong to a part of the rod, unless `is_whole`.
    pub fn described(profile: &Profile<1>, length: f64, is_whole: bool) -> Self {
        let numbers = |rows: &[[f64; 1]]| rows.as_flattened().to_vec();
        match profile.parts() {
            Parts::Constant(&[number]) => Self::Constant(number),
            Parts::Linear(&[[base], [tip]]) if is_whole => Self::Linear([base, tip]),
            Parts::Linear(ends) => Self::Table(Table { stations: vec![0.0, length], values: numbers(ends) }),
            Parts::Table(stations, values) => {
                Self::Table(Table { stations: stations.to_vec(), values: numbers(values) })
            }
            Parts::Polynomial(coefficients) => Self::Polynomial(length, numbers(coefficients)),
        }
    }
}

impl Data for AlongRod {
    const KIND: Kind = Kind::AlongRod(Table::SCHEMA);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        match value {
            Value::Part(_) => value.part::<Self>().cloned(),
            Value::Table(_) => Table::read(value, reader).map(Self::Table),
            Value::List(_) => <[f64; 2]>::read(value, reader).map(Self::Linear),
            Value::Number(_) | Value::Integer(_) => f64::read(value, reader).map(Self::Constant),
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        match self {
            Self::Constant(number) => number.check(limits, reader),
            Self::Linear(ends) => ends.check(limits, reader),
            Self::Table(table) => table.check(limits, reader),
            Self::Polynomial(..) | Self::Function(_) => {}
        }
    }

    fn write(&self) -> Value {
        match self {
            Self::Constant(number) => number.write(),
            Self::Linear(ends) => ends.write(),
            _ => Value::Part(Arc::new(self.clone())),
        }
    }
}

impl<const N: usize> Data for [AlongRod; N] {
    const KIND: Kind = Kind::Array(&AlongRod::KIND, N);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        items(value, Some(N), &Self::KIND, reader)?.try_into().ok()
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        for (i, number) in self.iter().enumerate() {
            reader.at_item(i, |reader| number.check(limits, reader));
        }
    }

    fn write(&self) -> Value {
        Value::List(self.iter().map(AlongRod::write).collect())
    }
}

/// The table of fields; functions cannot be written to it.
impl AnyPart for AlongRod {
    fn schema(&self) -> &'static Schema {
        Table::SCHEMA
    }

    fn field(&self, index: usize) -> Value {
        if let Self::Table(table) = self { table.field(index) } else { Value::Other("a function".to_owned()) }
    }

    fn same(&self, other: &dyn AnyPart) -> bool {
        (other as &dyn Any).downcast_ref() == Some(self)
    }

    fn check_any(&self, reader: &mut Reader) {
        Data::check(self, &Limits::NONE, reader);
    }
}
