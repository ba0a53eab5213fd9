//! Tolerances: one number, or one for each coordinate.

use crate::description::schema::{Data, Kind, Limits, Reader, Value};
use crate::error::{Checker, InvalidInput};
use crate::integrators::ode::Tolerance;

impl Data for Tolerance {
    const KIND: Kind = Kind::OneOrMany;

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        match value {
            Value::List(_) => Data::read(value, reader).map(Self::Each),
            Value::Number(_) | Value::Integer(_) => Data::read(value, reader).map(Self::Same),
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        match self {
            Self::Same(number) => number.check(limits, reader),
            Self::Each(numbers) => numbers.check(limits, reader),
        }
    }

    fn write(&self) -> Value {
        match self {
            Self::Same(number) => number.write(),
            Self::Each(numbers) => numbers.write(),
        }
    }
}

/// Tolerances of `n` coordinates and their velocities from those of the coordinates.
pub(super) fn of_states(tolerance: &Tolerance, n: usize, name: &str) -> Result<Tolerance, InvalidInput> {
    let Tolerance::Each(values) = tolerance else { return Ok(tolerance.clone()) };
    let mut checker = Checker::new();
    checker.length(values, n, name);
    checker.finish()?;
    Ok(Tolerance::Each([values.as_slice(), values.as_slice()].concat()))
}
