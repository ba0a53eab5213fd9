//! Functions of time as users describe them: constants, tables, harmonics and inputs.

use std::any::Any;
use std::sync::Arc;

use super::{Harmonic, Input, Interpolation, Signal, Table};
use crate::description::schema::{
    AnyPart, Data, Described, Fault, Kind, Limits, Part as _, Reader, Schema, Value,
};
use crate::error::Checker;

/// A function of time that prescribes a motion. Its tables are interpolated as they say, by default with a continuous
/// acceleration; it is no input.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drive<const N: usize>(pub Signal<N>);

/// The keys of a function of time of N numbers.
#[derive(Debug)]
struct Keys<const N: usize> {
    times: Option<Vec<f64>>,
    values: Option<Vec<[f64; N]>>,
    interpolation: Option<Interpolation>,
    amplitude: Option<[f64; N]>,
    frequency: Option<f64>,
    phase: Option<f64>,
    mean: Option<[f64; N]>,
    rate: Option<[f64; N]>,
    input: Option<String>,
    default: Option<[f64; N]>,
}

impl<const N: usize> Keys<N> {
    /// No key.
    const NONE: Self = Self {
        times: None,
        values: None,
        interpolation: None,
        amplitude: None,
        frequency: None,
        phase: None,
        mean: None,
        rate: None,
        input: None,
        default: None,
    };

    fn of(signal: &Signal<N>) -> Self {
        match signal {
            Signal::Constant(_) | Signal::Function(_) => Self::NONE,
            Signal::Table(table) => Self {
                times: Some(table.times().to_vec()),
                values: Some(table.values().to_vec()),
                interpolation: table.interpolation(),
                ..Self::NONE
            },
            Signal::Harmonic(Harmonic { mean, rate, amplitude, frequency, phase }) => {
                let unless_zero = |part: &[f64; N]| (*part != [0.0; N]).then_some(*part);
                let given = |number: &f64| (*number != 0.0).then_some(*number);
                Self {
                    amplitude: Some(*amplitude),
                    frequency: given(frequency),
                    phase: given(phase),
                    mean: unless_zero(mean),
                    rate: unless_zero(rate),
                    ..Self::NONE
                }
            }
            Signal::Input(Input { name, value }) => {
                Self { input: Some(name.as_ref().to_owned()), default: Some(*value), ..Self::NONE }
            }
        }
    }

    /// The signal; `None` after reporting a problem.
    fn signal(self, reader: &mut Reader) -> Option<Signal<N>> {
        let Self { times, values, interpolation, amplitude, frequency, phase, mean, rate, input, default } =
            self;
        let is_table = times.is_some() || values.is_some();
        let is_oscillation = amplitude.is_some() || frequency.is_some() || phase.is_some();
        let is_harmonic = is_oscillation || mean.is_some() || rate.is_some();
        let mut refuse = |key: &str, wrong: &str, right: &str| {
            reader.refuse(key, Fault::Other { wrong: wrong.to_owned(), right: right.to_owned() });
            None
        };
        if let Some(name) = input {
            if is_table || is_harmonic {
                let right = "keep either input and default, or what varies in time";
                return refuse("", "both an input and a function of time", right);
            }
            reader.require(!name.is_empty(), "input", "\"\"", "a name").then_some(())?;
            return Some(Signal::Input(Input { name: name.into(), value: default.unwrap_or([0.0; N]) }));
        }
        if default.is_some() {
            return refuse("default", "a default without input", "add input = \"name\", or remove it");
        }
        if is_table && is_harmonic {
            let right = "keep either times and values, or amplitude, frequency, phase, mean and rate";
            return refuse("", "both a table and a formula", right);
        }
        if interpolation.is_some() && !is_table {
            let right = "remove it: only times and values are interpolated";
            return refuse("interpolation", "it belongs to a table", right);
        }
        match (times, values) {
            (Some(times), Some(values)) => match Table::new(times, values) {
                Ok(table) => Some(Signal::Table(Arc::new(table.interpolated(interpolation)))),
                Err(error) => {
                    let mut check = Checker::new();
                    check.all(Err(error));
                    reader.nested(check);
                    None
                }
            },
            (None, None) if is_harmonic => {
                let [amplitude, mean, rate] = [amplitude, mean, rate].map(|part| part.unwrap_or([0.0; N]));
                let (frequency, phase) = (frequency.unwrap_or_default(), phase.unwrap_or_default());
                Some(Signal::Harmonic(Harmonic { mean, rate, amplitude, frequency, phase }))
            }
            (None, None) => {
                let right = "add times and values, or amplitude and frequency";
                refuse("", "nothing that varies in time", right)
            }
            (times, _) => {
                let missing = if times.is_none() { "times" } else { "values" };
                refuse("", &format!("{missing} are missing"), "give times and values, as many of each")
            }
        }
    }
}

/// A table of scenes whose numbers have this type; it is made of the keys of a function of N numbers, and makes these.
macro_rules! table {
    ($Table:ident<$N:literal, $Numbers:ty>($wrap:expr, $unwrap:expr), $doc:literal,
     $($(#[$meta:meta])* $key:ident: $Type:ty = $into:expr, $from:expr;)*) => {
        #[doc = $doc]
        #[derive(Clone, Debug, PartialEq, Described)]
        struct $Table {
            /// Increasing times of the values.
            #[part(unit = "seconds")]
            times: Option<Vec<f64>>,
            /// Values at these times; of loads and commands interpolated linearly and constant before the first and after the
            /// last one.
            values: Option<Vec<$Numbers>>,
            $($(#[$meta])* $key: Option<$Type>,)*
        }

        impl From<$Table> for Keys<$N> {
            fn from(table: $Table) -> Self {
                let values = table.values.map(|values| values.into_iter().map($wrap).collect());
                Self { times: table.times, values, $($key: table.$key.map($into),)* ..Self::NONE }
            }
        }

        impl From<Keys<$N>> for $Table {
            fn from(keys: Keys<$N>) -> Self {
                let values = keys.values.map(|values| values.into_iter().map($unwrap).collect());
                Self { times: keys.times, values, $($key: keys.$key.map($from),)* }
            }
        }
    };
}

/// Tables of functions of time that are formulas, too: those of signals with inputs, and those of motions.
macro_rules! tables {
    ($Signal:ident, $Motion:ident, $N:literal, $Numbers:ty, $wrap:expr, $unwrap:expr) => {
        tables!(@ $Signal, $N, $Numbers, $wrap, $unwrap,
            "A function of time: either times and values, or mean + rate t + amplitude sin(2 pi frequency t + phase). Or an input, which a controller sets.",
            /// Instead: the name of an input. Inputs with the same name are one input; those of three numbers have the
            /// entries name.x, name.y and name.z.
            input: String = |name| name, |name| name;
            /// Value of the input unless a controller sets it; by default zero.
            default: $Numbers = $wrap, $unwrap;
        );
        tables!(@ $Motion, $N, $Numbers, $wrap, $unwrap,
            "A function of time: either times and values, or mean + rate t + amplitude sin(2 pi frequency t + phase).",
            /// Interpolation of times and values; by default cubic.
            interpolation: Interpolation = |word| word, |word| word;
        );
    };
    (@ $Table:ident, $N:literal, $Numbers:ty, $wrap:expr, $unwrap:expr, $doc:literal, $($more:tt)*) => {
        table! {
            $Table<$N, $Numbers>($wrap, $unwrap), $doc,
            /// Largest deviation from the steady part; by default zero.
            amplitude: $Numbers = $wrap, $unwrap;
            /// Oscillations per second; by default zero.
            #[part(unit = "hertz", non_negative)]
            frequency: f64 = |number| number, |number| number;
            /// Phase at time zero; by default zero.
            #[part(unit = "radians")]
            phase: f64 = |number| number, |number| number;
            /// Steady part at time zero; by default zero.
            mean: $Numbers = $wrap, $unwrap;
            /// Growth of the steady part per second; by default zero.
            rate: $Numbers = $wrap, $unwrap;
            $($more)*
        }
    };
}

tables!(VaryingCommand, VaryingNumber, 1, f64, |x| [x], |[x]: [f64; 1]| x);
tables!(VaryingLoad, VaryingVector, 3, [f64; 3], |x| x, |x: [f64; 3]| x);
table! {
    Orientations<4, [f64; 4]>(|x| x, |x: [f64; 4]| x),
    "Orientations at some times: unit quaternions (w, x, y, z), less than a right angle from one to the next.",
    /// Interpolation of times and values; by default cubic.
    interpolation: Interpolation = |word| word, |word| word;
}

/// A type that contains a signal.
trait Holder<const N: usize> {
    fn holding(signal: Signal<N>) -> Self;
    fn signal(&self) -> &Signal<N>;
}

impl<const N: usize> Holder<N> for Signal<N> {
    fn holding(signal: Self) -> Self {
        signal
    }

    fn signal(&self) -> &Self {
        self
    }
}

impl<const N: usize> Holder<N> for Drive<N> {
    fn holding(signal: Signal<N>) -> Self {
        Self(signal)
    }

    fn signal(&self) -> &Signal<N> {
        &self.0
    }
}

/// Implements [`Data`] for a type that contains a signal of N numbers, with its table in scenes. The name is the common one of a
/// constant or a table; if it is empty, only tables are allowed.
macro_rules! described {
    ($This:ty, $Table:ident, $name:literal, $Numbers:ty, $wrap:expr, $unwrap:expr) => {
        impl Data for $This {
            const KIND: Kind = Kind::Signal($name, &<$Numbers>::KIND, $Table::SCHEMA);

            fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
                let is_number = matches!(<$Numbers>::KIND, Kind::Number);
                let signal = match value {
                    Value::Part(_) => return value.part::<Self>().cloned(),
                    Value::Table(_) => {
                        let before = reader.problems().len();
                        let table =
                            $Table::read(value, reader).filter(|_| reader.problems().len() == before)?;
                        Keys::from(table).signal(reader)?
                    }
                    Value::Number(_) | Value::Integer(_) if is_number => {
                        Signal::Constant($wrap(<$Numbers>::read(value, reader)?))
                    }
                    Value::List(_) if !is_number => Signal::Constant($wrap(<$Numbers>::read(value, reader)?)),
                    _ => return reader.wrong_type(value, &Self::KIND),
                };
                Some(Holder::holding(signal))
            }

            fn check(&self, _: &Limits, reader: &mut Reader) {
                // A motion is checked as a whole.
                if !$name.is_empty() {
                    let mut check = Checker::new();
                    self.signal().check(&mut check, "");
                    reader.nested(check);
                }
            }

            fn write(&self) -> Value {
                match self.signal() {
                    Signal::Constant(value) => $unwrap(*value).write(),
                    _ => Value::Part(Arc::new(self.clone())),
                }
            }
        }

        /// The table of a function of time. That of a function of Python has what no table holds.
        impl AnyPart for $This {
            fn schema(&self) -> &'static Schema {
                $Table::SCHEMA
            }

            fn field(&self, index: usize) -> Value {
                match (self.signal(), index) {
                    (Signal::Function(_), 0) => Value::Other("a function".to_owned()),
                    (signal, _) => $Table::from(Keys::of(signal)).field(index),
                }
            }

            fn same(&self, other: &dyn AnyPart) -> bool {
                (other as &dyn Any).downcast_ref() == Some(self)
            }

            fn check_any(&self, reader: &mut Reader) {
                Data::check(self, &Limits::NONE, reader);
            }
        }
    };
}

described!(Signal<1>, VaryingCommand, "Command", f64, |x| [x], |[x]: [f64; 1]| x);
described!(Signal<3>, VaryingLoad, "Vector", [f64; 3], |x| x, |x: [f64; 3]| x);
described!(Drive<1>, VaryingNumber, "", f64, |x| [x], |[x]: [f64; 1]| x);
described!(Drive<3>, VaryingVector, "", [f64; 3], |x| x, |x: [f64; 3]| x);
described!(Drive<4>, Orientations, "", [f64; 4], |x| x, |x: [f64; 4]| x);
