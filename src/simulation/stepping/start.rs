//! Initial states that satisfy the constraints of closed loops.

use crate::error::{InvalidInput, Rounded};
use crate::model::constraint::{closing, projection};
use crate::model::{Model, chart};

/// Changes of a start below this part of the sizes of coordinates count as rounding.
const ROUNDING_OF_STARTS: f64 = 1e-9;

/// A state with closed loops.
pub(crate) struct Start {
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// Largest displacement of a place from the given start, in metres; zero if it is rounding.
    pub(crate) moved: f64,
}

impl Start {
    /// The nearest state with closed loops. Rejects a state from which loops cannot be closed.
    pub(crate) fn fitted<M: Model>(
        model: &mut M,
        t: f64,
        q0: &[f64],
        v0: &[f64],
    ) -> Result<Self, InvalidInput> {
        let (mut q, mut v) = (q0.to_vec(), v0.to_vec());
        // The run will report the failure of a function of time.
        if model.facts().constraints() == 0 || model.set_time(t).is_err() {
            return Ok(Self { q, v, moved: 0.0 });
        }
        let inputs = model.facts().default_inputs.clone();
        model.set_inputs(&inputs);
        let _ = model.set_time(t);
        closing::close(model, &mut q);
        if let Some(invalid_shape) = model.open_loop(&q) {
            let expected = "a start closer to a closed shape, and loops that do not contradict each other";
            return Err(InvalidInput::new(
                "q0",
                format_args!(
                    "a start that {} and could not be closed",
                    invalid_shape.with_loops(&model.facts().loops)
                ),
                expected,
            ));
        }
        model.release_open(&q, Some(&v));
        // A singular mass matrix prevents any motion; the run will report it.
        let _ = projection::fit_velocities(model, &q, &mut v);
        let mut sizes = vec![0.0; q.len()];
        model.sizes(&q, &mut sizes);
        let step = chart::step_between(&model.facts().rotation_vectors, q0, &q);
        let has_moved = step.iter().zip(sizes).any(|(step, size)| step.abs() > ROUNDING_OF_STARTS * size);
        let moved = if has_moved { model.moved(q0, &q) } else { 0.0 };
        Ok(Self { q, v, moved })
    }

    /// Sentence for messages about a start that was moved.
    pub(crate) fn sentence(moved: f64) -> String {
        format!(" The start was moved by {} m to satisfy its constraints.", Rounded(moved))
    }
}
