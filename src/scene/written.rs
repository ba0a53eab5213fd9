//! Values of a document that are read later.

use std::marker::PhantomData;

use crate::description::schema::{Data, Item, Kind, Limits, Reader, Value};

/// A value as it stands in the file, read independently of problems around it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Written<T> {
    value: Value,
    kind: PhantomData<T>,
}

impl<T> Written<T> {
    pub(super) fn new(value: Value) -> Self {
        Self { value, kind: PhantomData }
    }

    /// The table.
    pub(super) fn value(&self) -> &Value {
        &self.value
    }

    /// The text of a key.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.value.get(key)?.text()
    }
}

impl<T: Data> Item for Written<T> {}

impl<T: Data> Data for Written<T> {
    const KIND: Kind = T::KIND;

    /// Instead of a part there must be a table.
    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        let is_table = matches!(value, Value::Table(_));
        if is_table { Some(Self::new(value.clone())) } else { reader.wrong_type(value, &Self::KIND) }
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        self.value.clone()
    }
}
