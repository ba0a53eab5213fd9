//! Parameter of a path of equilibria: a factor of all loads, or the position of inputs between two values.

use crate::error::{Checker, Interrupted};
use crate::model::Static;
use crate::numerics::linalg::Matrix;

/// Inputs along a straight path.
#[derive(Clone, Debug, PartialEq)]
pub struct InputPath {
    /// Inputs u at load factor zero, shape (m,).
    pub from: Vec<f64>,
    /// Inputs u at load factor one.
    pub to: Vec<f64>,
    /// Time of the model in seconds, set again with the inputs if the model varies in time.
    pub time: f64,
}

impl InputPath {
    pub(super) fn check(&self, check: &mut Checker, m: usize) {
        for (values, place) in [(&self.from, "inputs.from"), (&self.to, "inputs.to")] {
            if check.length(values, m, place) {
                check.finite(values, place);
            }
        }
        let moves = self.from != self.to;
        check.require(moves, "inputs", "the same `from` and `to`", "at least one input that changes");
    }
}

/// Meaning of the load factor.
pub(super) enum LoadParameter {
    /// Fraction of all loads that acts.
    Loads,
    /// Position of the inputs along their path.
    Inputs(Inputs),
}

/// Inputs along their path.
pub(super) struct Inputs {
    from: Vec<f64>,
    change: Vec<f64>,
    time: f64,
    /// Load factor whose inputs are set.
    at: f64,
    /// Derivative of the generalised forces with respect to all inputs.
    tangent: Matrix,
}

impl LoadParameter {
    pub(super) fn of_inputs(path: &InputPath, n: usize) -> Self {
        let InputPath { from, to, time } = path.clone();
        let change = from.iter().zip(&to).map(|(from, to)| to - from).collect();
        let tangent = Matrix::zeros(n, from.len());
        Self::Inputs(Inputs { from, change, time, at: f64::NAN, tangent })
    }

    /// Sets the inputs of a model, unless they are set already.
    pub(super) fn set(&mut self, model: &mut dyn Static, load_factor: f64) -> Result<(), Interrupted> {
        let Self::Inputs(inputs) = self else { return Ok(()) };
        if inputs.at != load_factor {
            model.set_inputs(&inputs.at(load_factor));
            model.set_time(inputs.time)?;
            inputs.at = load_factor;
        }
        Ok(())
    }

    /// Inputs at a load factor; `None` if loads grow instead.
    pub(super) fn inputs_at(&self, load_factor: f64) -> Option<Vec<f64>> {
        if let Self::Inputs(inputs) = self { Some(inputs.at(load_factor)) } else { None }
    }
}

impl Inputs {
    fn at(&self, load_factor: f64) -> Vec<f64> {
        self.from.iter().zip(&self.change).map(|(from, change)| from + load_factor * change).collect()
    }

    /// Derivative of the generalised forces with respect to the load factor.
    pub(super) fn load(&mut self, model: &mut dyn Static, q: &[f64], rest: &[f64], load: &mut [f64]) {
        model.input_tangent(q, rest, rest, &mut self.tangent);
        load.fill(0.0);
        for (column, change) in self.tangent.column_iter().zip(&self.change).filter(|(_, x)| **x != 0.0) {
            load.iter_mut().zip(column.iter()).for_each(|(load, entry)| *load += entry * change);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::rod::Segment;
    use crate::description::signal::{Harmonic, Input, Signal};
    use crate::model::{Dynamics as _, InTime as _};
    use crate::robot::effects::actuator::{Actuator, Along, Drive, Part, Tendon};
    use crate::robot::{RobotModel, Rod};

    /// Two tendons, with tension and length as inputs; and one that varies in time.
    fn model() -> RobotModel {
        let tendon = |name: &str, z: f64, drive: Drive| {
            let along = Along { link: 0, offset: [0.0.into(), z.into()], along: [0.0, 0.3] };
            let (name, path) = (name.into(), vec![Part::Along(along)]);
            Actuator::Tendon(Tendon {
                name,
                path,
                drive,
                friction: 0.0,
                friction_velocity: 1e-3,
                sliding: None,
            })
        };
        let input = |name: &str, value| Signal::Input(Input { name: name.into(), value: [value] });
        let sway = Harmonic { mean: [1.0], rate: [2.0], ..Harmonic::zero() };
        let actuators = vec![
            tendon("up", 0.01, Drive::Tension(input("up", 1.0))),
            tendon(
                "down",
                -0.01,
                Drive::Length { length: input("down", 0.29), stiffness: Some(50.0), damping: 0.0 },
            ),
            tendon("sway", 0.005, Drive::Tension(Signal::Harmonic(sway))),
        ];
        let straight = Segment::straight(0.3, 0.01, 1e6, 4e5, 1000.0);
        let segment = Segment { modes: [0, 2, 0, 0, 0, 0], ..straight };
        RobotModel::of_rod(&Rod { actuators, ..Rod::new(vec![segment]) }).unwrap()
    }

    fn path() -> InputPath {
        InputPath { from: vec![0.5, 0.29], to: vec![2.5, 0.28], time: 0.25 }
    }

    const Q: [f64; 2] = [0.3, -0.2];
    const REST: [f64; 2] = [0.0; 2];

    fn forces(load_parameter: &mut LoadParameter, model: &mut RobotModel, load_factor: f64) -> [f64; 2] {
        let mut tau = [0.0; 2];
        load_parameter.set(model, load_factor).unwrap();
        model.inverse_dynamics(&Q, &REST, &REST, &mut tau);
        tau
    }

    #[test]
    fn inputs_go_straight_from_one_place_to_the_other_at_their_time() {
        let mut load_parameter = LoadParameter::of_inputs(&path(), 2);
        for (load_factor, u) in [(0.0, [0.5, 0.29]), (1.0, [2.5, 0.28]), (-0.5, [-0.5, 0.295])] {
            let found = load_parameter.inputs_at(load_factor).unwrap();
            assert!(found.iter().zip(u).all(|(found, u)| (found - u).abs() < 1e-15), "{found:?}");
            let (mut one, mut other) = (model(), model());
            other.set_inputs(&found);
            other.set_time(0.25).unwrap();
            let mut expected = [0.0; 2];
            other.inverse_dynamics(&Q, &REST, &REST, &mut expected);
            assert_eq!(forces(&mut load_parameter, &mut one, load_factor), expected);
        }
    }

    #[test]
    fn the_load_is_the_derivative_by_the_load_factor() {
        let (mut load_parameter, mut model) = (LoadParameter::of_inputs(&path(), 2), model());
        let step = 1e-4;
        let [before, after] =
            [0.4 - step, 0.4 + step].map(|factor| forces(&mut load_parameter, &mut model, factor));
        load_parameter.set(&mut model, 0.4).unwrap();
        let mut load = [f64::NAN; 2];
        let LoadParameter::Inputs(inputs) = &mut load_parameter else { panic!("inputs grow") };
        inputs.load(&mut model, &Q, &REST, &mut load);
        let differences = [0, 1].map(|i| (after[i] - before[i]) / (2.0 * step));
        let scale = differences[0].abs().max(differences[1].abs());
        for (load, difference) in load.iter().zip(differences) {
            assert!((load - difference).abs() < 1e-8 * scale, "{load} {difference}");
        }
    }

    #[test]
    fn where_loads_grow_no_input_is_touched() {
        let (mut grown, mut left) = (model(), model());
        let mut load_parameter = LoadParameter::Loads;
        assert!(load_parameter.inputs_at(0.5).is_none());
        let mut tau = [0.0; 2];
        for model in [&mut grown, &mut left] {
            model.set_time(0.0).unwrap();
        }
        left.inverse_dynamics(&Q, &REST, &REST, &mut tau);
        assert_eq!(forces(&mut load_parameter, &mut grown, 0.5), tau);
    }

    #[test]
    fn a_path_of_inputs_that_makes_no_sense_is_refused() {
        let refused = |path: InputPath| {
            let mut check = Checker::new();
            path.check(&mut check, 2);
            check.finish().unwrap_err().problems.into_iter().map(|problem| problem.place).collect::<Vec<_>>()
        };
        assert_eq!(refused(InputPath { from: vec![0.5], ..path() }), ["inputs.from"]);
        assert_eq!(refused(InputPath { to: vec![f64::NAN, 0.0], ..path() }), ["inputs.to[0]"]);
        assert_eq!(refused(InputPath { to: path().from, ..path() }), ["inputs"]);
        let mut check = Checker::new();
        path().check(&mut check, 2);
        assert!(check.finish().is_ok());
    }
}
