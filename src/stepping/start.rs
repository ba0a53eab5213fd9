//! Initial states that satisfy the constraints of closed loops.

use crate::constraint::one_sided;
use crate::constraint::projection::{self, Metric};
use crate::error::{InvalidInput, Number};
use crate::model::Model;

/// Changes of a start below this fraction of the model's length count as rounding.
const UNMOVED: f64 = 1e-9;

/// A state with closed loops.
pub(crate) struct Start {
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// Largest displacement of a place from the given start, in metres; zero if it is rounding.
    pub(crate) moved: f64,
}

impl Start {
    /// The closest state with closed loops. Rejects a state from which loops cannot be closed.
    pub(crate) fn fitted<M: Model>(
        model: &mut M,
        t: f64,
        q0: &[f64],
        v0: &[f64],
    ) -> Result<Self, InvalidInput> {
        let (mut q, mut v) = (q0.to_vec(), v0.to_vec());
        // The run will report the failure of a function of time.
        if model.constraints() == 0 || model.set_time(t).is_err() {
            return Ok(Self { q, v, moved: 0.0 });
        }
        let inputs = model.default_inputs();
        model.set_inputs(&inputs);
        let _ = model.set_time(t);
        let closed = one_sided::close(model, &mut q, Metric::Elastic);
        if let (Ok(_), Some(flaw)) = (closed, model.open_loop(&q)) {
            let expected =
                "one in which the loops are closed, or can be from there: loops that conflict never are";
            return Err(InvalidInput::new(
                "q0",
                format_args!("a start that {flaw}, as near as it gets"),
                expected,
            ));
        }
        if closed.is_ok() {
            model.release_open(&q, Some(&v));
            // A singular mass matrix prevents any motion; the run will report it.
            let _ = projection::fit_velocities(model, &q, &mut v);
        }
        let moved = model.moved(q0, &q);
        Ok(Self { q, v, moved: if moved > UNMOVED * model.length() { moved } else { 0.0 } })
    }

    /// Sentence for messages about a start that was moved.
    pub(crate) fn sentence(moved: f64) -> String {
        format!(" The start was moved by {} m to satisfy its constraints.", Number(moved))
    }
}
