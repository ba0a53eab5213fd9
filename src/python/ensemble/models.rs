//! The models of the rows, and the number of rows.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::super::model::PyModel;
use super::super::remarks;
use super::super::rows::{Vectors, each};

/// Models of the rows.
pub(super) enum Models {
    One(Py<PyModel>),
    Each(Vec<Py<PyModel>>),
}

impl Models {
    pub(super) fn of(model: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(model) = model.cast::<PyModel>() {
            model.get().check_modes()?;
            return Ok(Self::One(model.clone().unbind()));
        }
        let models = each(model)?;
        if models.is_empty() {
            return Err(PyValueError::new_err(
                "model: got no models, expected at least one (for no rows, give one model and starts of shape (0, n))",
            ));
        }
        Ok(Self::Each(models))
    }

    pub(super) fn rows(&self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Each(models) => Some(models.len()),
        }
    }

    pub(super) fn first(&self) -> &PyModel {
        self.of_row(0).get()
    }

    /// Default inputs of the model of all rows, or of that of each.
    pub(super) fn default_inputs(&self) -> Vec<Vec<f64>> {
        match self {
            Self::One(model) => vec![model.get().default_inputs()],
            Self::Each(models) => models.iter().map(|model| model.get().default_inputs()).collect(),
        }
    }

    /// Questions about the units of the model of each row.
    pub(super) fn questions(&self) -> impl Fn(usize) -> Vec<String> {
        let of_one = match self {
            Self::One(model) => Some(remarks::questions(model.get())),
            Self::Each(_) => None,
        };
        move |row| of_one.clone().unwrap_or_else(|| remarks::questions(self.of_row(row).get()))
    }

    pub(super) fn of_row(&self, row: usize) -> &Py<PyModel> {
        match self {
            Self::One(model) => model,
            Self::Each(models) => &models[row],
        }
    }
}

/// Number of rows, and the argument that determines it.
pub(super) struct Count(pub(super) Option<(usize, &'static str)>);

impl Count {
    /// The n numbers of each row, if they are given.
    pub(super) fn vectors(
        &mut self,
        value: Option<&Bound<'_, PyAny>>,
        n: usize,
        name: &'static str,
    ) -> PyResult<Option<Vectors>> {
        let Some(value) = value else { return Ok(None) };
        let (vectors, rows) = Vectors::of_any(value, n, name)?;
        self.agree(rows, name)?;
        Ok(Some(vectors))
    }

    pub(super) fn agree(&mut self, rows: Option<usize>, name: &'static str) -> PyResult<()> {
        match (rows, self.0) {
            (Some(rows), Some((known, by))) if rows != known => {
                Err(PyValueError::new_err(format!("{name}: got {rows} rows, expected {known} as {by} has")))
            }
            (Some(rows), None) => {
                self.0 = Some((rows, name));
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
