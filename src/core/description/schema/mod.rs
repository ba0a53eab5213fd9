//! Descriptions: each part of a model is one struct, with its documentation, defaults, units and ranges.
//!
//! `#[derive(Described)]` writes a table of the fields of a struct ([`Schema`]) and short functions that read, check and
//! write it. All else is written once, over these tables: reading of scenes with all problems at once, writing of scenes,
//! the JSON Schema, the classes of Python with their docstrings and stubs.
//!
//! ```
//! use lissom::contact::described::Sphere;
//! use lissom::schema::{Part, Value};
//!
//! let centre = Value::List(vec![Value::Number(0.0); 3]);
//! let table = Value::Table(vec![("centre".into(), centre), ("radius".into(), Value::Number(0.5))]);
//! let sphere = Sphere::from_value(&table).expect("it has all that a sphere needs");
//! assert_eq!((sphere.radius, sphere.link), (0.5, None));
//! assert!(Sphere::from_value(&Value::Table(Vec::new())).is_err_and(|problems| problems.len() == 2));
//! ```

mod data;
mod read;
#[doc(hidden)]
pub mod suggestion;
mod types;

pub use data::{
    AnyPart, Data, Fault, Field, Item, Kind, Limits, Make, Part, Problem, Reader, Schema, Sign, Value,
};
pub use types::{Friction, Layers, LinkName, PerAxis, Rows, Symmetric};

#[doc(hidden)]
pub use lissom_derive::Described;
#[doc(hidden)]
pub use suggestion::{
    LISTED, compared, did_you_mean, expected_name, expected_one_of, or_meant, quoted, suggestion, unexpected,
    within,
};
pub(crate) use types::items;
