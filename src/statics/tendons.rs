//! What an equilibrium says of the tendons of a robot: which are slack, which were told what none can do, and where
//! friction is left out.

use crate::actuator::{Actuator, Drive, Tendon};
use crate::error::Interrupted;
use crate::model::Model as _;
use crate::robot::RobotModel;
use crate::signal::Signal;

/// Names of tendons in a state at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tendons {
    /// Those that are told to push, and those of a given length whose path is shorter than that.
    pub slack: Vec<String>,
    /// Those of which a tension below zero is asked for, with that.
    pub told_to_push: Vec<(String, f64)>,
    /// Those with friction and without a direction of sliding: at rest it is left out.
    pub without_friction: Vec<String>,
}

impl Tendons {
    /// Of a robot in a shape, at a time and with these inputs, which are those that it has; `None` where they are as they
    /// are by themselves. Only a function of time can fail.
    pub fn of(model: &mut RobotModel, q: &[f64], t: f64, u: Option<&[f64]>) -> Result<Self, Interrupted> {
        let mut found = Self::default();
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
                    let told = value(tension)?;
                    if told < 0.0 {
                        found.told_to_push.push((name.clone(), told));
                        found.slack.push(name.clone());
                    }
                }
                Drive::Length { .. } => of_given_length.push(i),
            }
            if *friction > 0.0 && sliding.is_none() {
                found.without_friction.push(name.clone());
            }
        }
        let rest = vec![0.0; model.n()];
        let mut gradient = rest.clone();
        for i in of_given_length {
            let [_, _, tension] = model.actuator(q, &rest, i, &mut gradient);
            if tension == 0.0 {
                found.slack.push(model.description().actuators[i].name().to_owned());
            }
        }
        Ok(found)
    }

    /// What to add to a message; nothing where there is nothing to say.
    pub fn message(&self) -> String {
        let mut message = String::new();
        if !self.slack.is_empty() {
            message += &format!(" Slack: {}.", quoted(self.slack.iter()));
        }
        for (name, tension) in &self.told_to_push {
            message += &format!(" The tension of '{name}' is told to be {tension} N: a tendon never pushes.");
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
