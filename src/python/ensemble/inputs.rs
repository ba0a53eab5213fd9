//! The inputs of the rows.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::super::convert::{self, Numbers};
use super::super::inputs::numbered;
use super::super::rows::Vectors;
use super::models::{Count, Models};
use crate::integrators::second_order::number_of_steps;
use crate::simulation::accuracy;

/// Inputs of the rows.
pub(super) enum Inputs {
    Defaults,
    Held { values: Vectors, step: f64 },
    Steps { values: Vec<f64>, of_row: usize, width: usize, step: f64 },
}

impl Inputs {
    pub(super) fn of(
        given: Option<&Bound<'_, PyAny>>,
        models: &Models,
        control_step: Option<f64>,
        ((t0, t_end), dt): ((f64, f64), f64),
        count: &mut Count,
    ) -> PyResult<Self> {
        let no_steps = |control_step: Option<f64>| match control_step {
            None => Ok(()),
            Some(step) => Err(PyValueError::new_err(format!(
                "control_step: got {step:?}, but only inputs of shape (count, steps, inputs) are held for a time: leave it out"
            ))),
        };
        let Some(given) = given else { return no_steps(control_step).map(|()| Self::Defaults) };
        let (names, held) = (models.first().input_names(), models.default_inputs());
        let width = names.len();
        if width == 0 {
            return Err(PyValueError::new_err(
                "u: this model has no inputs: leave `u` out, or give loads or actuators a lissom.Input",
            ));
        }
        let given = &numbered(given, &names, &held, "u")?;
        let of_three = convert::numbers(given, "u", "an array of real numbers, of one to three dimensions")?;
        let Numbers { values, shape } = of_three;
        let [rows, steps, inputs] = shape[..] else {
            no_steps(control_step)?;
            let (values, rows) = Vectors::of_any(given, width, "u")?;
            count.agree(rows, "u")?;
            let step = if t_end > t0 { t_end - t0 } else { dt };
            return Ok(Self::Held { values, step });
        };
        let step = control_step.unwrap_or(dt);
        let is_step = step.is_finite() && step > 0.0;
        let wanted = if is_step { number_of_steps(t_end - t0, step).max(1) } else { steps };
        if inputs != width || steps != wanted {
            let message =
                format!("u: expected shape (count, {wanted}, {width}), got ({rows}, {steps}, {inputs})");
            return Err(PyValueError::new_err(message));
        }
        if let Some(index) = values.iter().position(|x| !x.is_finite()) {
            let (row, rest) = (index / (steps * width), index % (steps * width));
            let message = format!(
                "u[{row}, {}, {}]: got {}, expected a finite number",
                rest / width,
                rest % width,
                values[index]
            );
            return Err(PyValueError::new_err(message));
        }
        count.agree(Some(rows), "u")?;
        Ok(Self::Steps { values, of_row: steps * width, width, step })
    }

    /// Duration of a control step, unless the inputs have their defaults.
    pub(super) fn step(&self) -> Option<f64> {
        match self {
            Self::Defaults => None,
            Self::Held { step, .. } | Self::Steps { step, .. } => Some(*step),
        }
    }

    /// All inputs of a row, for a motion to an accuracy.
    pub(super) fn of_row(&self, row: usize) -> accuracy::Inputs<'static> {
        let (step, values) = match self {
            Self::Defaults => return accuracy::Inputs::Defaults,
            Self::Held { values, step } => (*step, values.of(row)),
            Self::Steps { values, of_row, step, .. } => (*step, &values[row * of_row..][..*of_row]),
        };
        accuracy::Inputs::Rows { step, values: values.to_vec() }
    }

    /// Inputs of a row in this control step.
    pub(super) fn at(&self, row: usize, step: usize) -> &[f64] {
        match self {
            Self::Defaults => &[],
            Self::Held { values, .. } => values.of(row),
            Self::Steps { values, of_row, width, .. } => {
                let values = &values[row * of_row..(row + 1) * of_row];
                &values[(step * width).min(of_row - width)..][..*width]
            }
        }
    }
}
