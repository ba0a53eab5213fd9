//! State of a robot's tendons at an equilibrium: slack tendons, negative tension commands, and omitted
//! friction.

use crate::description::signal::Signal;
use crate::error::Interrupted;
use crate::model::Dynamics as _;
use crate::robot::RobotModel;
use crate::robot::effects::actuator::{Actuator, Drive, Tendon};

/// Names of tendons in a state at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tendons {
    /// Tendons with a negative tension command, and tendons whose path is shorter than their commanded
    /// length.
    pub slack: Vec<String>,
    /// Tendons with a negative tension command, and the commanded tension.
    pub commanded_to_push: Vec<(String, f64)>,
    /// Tendons whose friction is ignored at rest, because they have no direction of sliding.
    pub without_friction: Vec<String>,
    /// Sentences about forces that are absurd for the stiffness of their rods.
    pub overloads: Vec<String>,
}

impl Tendons {
    /// Tendons of a robot in a shape, at a time and with the inputs u, which must be the model's; `None`
    /// stands for the defaults. Only a function of time can fail.
    pub fn of(model: &mut RobotModel, q: &[f64], t: f64, u: Option<&[f64]>) -> Result<Self, Interrupted> {
        let mut found = Self { overloads: model.overloads(t, u)?, ..Self::default() };
        let robot = model.description();
        if robot.actuators.is_empty() {
            return Ok(found);
        }
        let inputs = u.map(|u| (u, robot.inputs()));
        let value = |signal: &Signal<1>| match (&inputs, signal.input()) {
            (Some((u, inputs)), Some(input)) => Ok(u[inputs.place(input)]),
            _ => signal.at(t).map(|[value]| value),
        };
        let mut of_given_length = Vec::new();
        for (i, actuator) in robot.actuators.iter().enumerate() {
            let Actuator::Tendon(Tendon { name, drive, friction, sliding, .. }) = actuator else { continue };
            match drive {
                Drive::Tension(tension) => {
                    let commanded = value(tension)?;
                    if commanded < 0.0 {
                        found.commanded_to_push.push((name.clone(), commanded));
                        found.slack.push(name.clone());
                    }
                }
                Drive::Length { stiffness: Some(_), .. } => of_given_length.push(i),
                Drive::Length { stiffness: None, .. } => {}
            }
            if *friction > 0.0 && sliding.is_none() {
                found.without_friction.push(name.clone());
            }
        }
        if model.facts().is_one_sided {
            let slack = model.slack_tendons(q).into_iter();
            found.slack.extend(slack.map(|i| model.description().actuators[i].name().to_owned()));
        }
        let rest = vec![0.0; model.facts().n];
        let mut gradient = rest.clone();
        for i in of_given_length {
            let [_, _, tension] = model.actuator(q, &rest, i, &mut gradient);
            if tension == 0.0 {
                found.slack.push(model.description().actuators[i].name().to_owned());
            }
        }
        Ok(found)
    }

    /// Text to append to the message of a failure; empty without findings.
    pub fn of_failure(&self) -> String {
        self.overloads.iter().map(|sentence| format!(" {sentence}")).collect()
    }

    /// Text to append to a message; empty without findings.
    pub fn message(&self) -> String {
        let mut message = self.of_failure();
        if !self.slack.is_empty() {
            message += &format!(" Slack: {}.", quoted(self.slack.iter()));
        }
        for (name, tension) in &self.commanded_to_push {
            message += &format!(" The commanded tension of '{name}' is {tension} N: a tendon never pushes.");
        }
        if !self.without_friction.is_empty() {
            message += &format!(
                " At rest nothing slides: friction is left out of {}; `sliding` says which way it acts.",
                quoted(self.without_friction.iter())
            );
        }
        message
    }
}

fn quoted<'a>(names: impl Iterator<Item = &'a String>) -> String {
    names.map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::rod::Segment;
    use crate::description::signal::Input;
    use crate::model::InTime as _;
    use crate::robot::Rod;
    use crate::robot::effects::actuator::{Along, Part};

    const LENGTH: f64 = 0.3;

    fn input(name: &str, value: f64) -> Signal<1> {
        Signal::Input(Input { name: name.into(), value: [value] })
    }

    fn tendon(name: &str, drive: Drive, friction: f64, sliding: Option<f64>) -> Actuator {
        let along = Along { link: 0, offset: [0.0.into(), 0.01.into()], along: [0.0, LENGTH] };
        let sliding = sliding.map(|sliding| [sliding].into());
        let (name, path) = (name.into(), vec![Part::Along(along)]);
        Actuator::Tendon(Tendon { name, path, drive, friction, friction_velocity: 1e-3, sliding })
    }

    fn length(signal: Signal<1>) -> Drive {
        Drive::Length { length: signal, stiffness: Some(100.0), damping: 0.0 }
    }

    fn of(actuators: Vec<Actuator>, q: f64, u: Option<&[f64]>) -> Tendons {
        let straight = Segment::straight(LENGTH, 0.01, 1e6, 4e5, 1000.0);
        let segment = Segment { modes: [0, 1, 0, 0, 0, 0], ..straight };
        let mut model = RobotModel::of_rod(&Rod { actuators, ..Rod::new(vec![segment]) }).unwrap();
        if let Some(u) = u {
            model.set_inputs(u);
        }
        Tendons::of(&mut model, &[q], 0.0, u).unwrap()
    }

    #[test]
    fn tendons_that_pull_need_no_word() {
        let taut = vec![
            tendon("pull", Drive::Tension([1.0].into()), 0.0, None),
            tendon("free", Drive::Tension([0.0].into()), 0.0, None),
            tendon("held", length([0.2].into()), 0.0, None),
            tendon("rubbing", Drive::Tension([1.0].into()), 0.1, Some(1.0)),
        ];
        let found = of(taut, 0.0, None);
        assert_eq!(found, Tendons::default());
        assert_eq!(found.message(), "");
        assert_eq!(of(Vec::new(), 0.0, None), Tendons::default());
    }

    #[test]
    fn slack_ones_follow_from_shape_and_inputs() {
        let held = || vec![tendon("held", length(input("held", LENGTH)), 0.0, None)];
        // At the curvature q the tendon is longer by 1 percent of q.
        assert_eq!(of(held(), 1.0, None).slack, [""; 0]);
        assert_eq!(of(held(), -1.0, None).slack, ["held"]);
        assert_eq!(of(held(), 1.0, Some(&[0.31])).slack, ["held"]);
        assert_eq!(of(held(), -1.0, Some(&[0.29])).slack, [""; 0]);
        assert_eq!(of(held(), -1.0, None).message(), " Slack: 'held'.");
    }

    #[test]
    fn what_no_tendon_can_is_said_with_its_number() {
        let commanded = || vec![tendon("push", Drive::Tension(input("push", 0.5)), 0.0, None)];
        assert_eq!(of(commanded(), 0.0, None), Tendons::default());
        let found = of(commanded(), 0.0, Some(&[-2.5]));
        assert_eq!(found.commanded_to_push, [("push".to_owned(), -2.5)]);
        assert_eq!(found.slack, ["push"]);
        let message = found.message();
        assert!(message.contains("The commanded tension of 'push' is -2.5 N"), "{message}");
    }

    #[test]
    fn friction_without_a_direction_is_left_out_and_said() {
        let rubbing = vec![
            tendon("a", Drive::Tension([1.0].into()), 0.1, None),
            tendon("b", length([0.2].into()), 0.1, None),
        ];
        let found = of(rubbing, 0.0, None);
        assert_eq!(found.without_friction, ["a", "b"]);
        assert!(found.message().contains("friction is left out of 'a', 'b'; `sliding` says"));
    }
}
