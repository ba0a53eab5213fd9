//! Initial states that satisfy the constraints of closed loops.

use crate::constraint::one_sided;
use crate::constraint::projection::{self, Metric};
use crate::error::{InvalidInput, Number};
use crate::model::Model;

/// Starts that are moved by less than this part of the model's length are as they were given, to rounding.
const UNMOVED: f64 = 1e-9;

/// A state whose loops are closed.
pub(crate) struct Start {
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// How far the place that moved most is from where it was given, in metres; zero if that is rounding.
    pub(crate) moved: f64,
}

impl Start {
    /// The state that is near this one. Refuses one whose loops cannot be closed from there.
    pub(crate) fn fitted<M: Model>(
        model: &mut M,
        t: f64,
        q0: &[f64],
        v0: &[f64],
    ) -> Result<Self, InvalidInput> {
        let (mut q, mut v) = (q0.to_vec(), v0.to_vec());
        // What a function of time raises is met by the run.
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
            // Without a mass there is no motion either.
            let _ = projection::fit_velocities(model, &q, &mut v);
        }
        let moved = model.moved(q0, &q);
        Ok(Self { q, v, moved: if moved > UNMOVED * model.length() { moved } else { 0.0 } })
    }

    /// What is said of one that was moved, behind a message.
    pub(crate) fn sentence(moved: f64) -> String {
        format!(" The start was moved by {} m to close its loops.", Number(moved))
    }
}
