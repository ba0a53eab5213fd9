//! Slack tendons during a motion, and negative tension commands, checked at the times of the result only.

use super::Simulation;
use crate::error::{Interrupted, Rounded, Time};
use crate::model::{Dynamics as _, InTime as _};
use crate::robot::RobotModel;
use crate::robot::effects::actuator::{Actuator, Drive, Tendon};

/// A tendon that was slack, or had a negative tension command.
#[derive(Clone, Debug, PartialEq)]
pub struct Slack {
    /// Name.
    pub name: String,
    /// First such time of the result, in seconds.
    pub from: f64,
    /// Lowest commanded tension in newtons, if negative.
    pub lowest: Option<f64>,
}

/// Slack tendons of a motion of this robot, in the order of its actuators. Checks only tendons that can be
/// slack: a tendon with commanded length costs one evaluation of the motion per time, a tendon with varying
/// tension one evaluation of the signal. Only a function of time can fail.
pub fn slackness(model: &mut RobotModel, simulation: &Simulation) -> Result<Vec<Slack>, Interrupted> {
    let actuators = model.description().actuators.iter().enumerate();
    let may_be_slack = actuators.filter_map(|(i, actuator)| match actuator {
        Actuator::Tendon(Tendon { drive: Drive::Length { .. }, name, .. }) => Some((i, true, name.clone())),
        Actuator::Tendon(Tendon { drive: Drive::Tension(tension), name, .. }) => {
            tension.constant().is_none().then(|| (i, false, name.clone()))
        }
        _ => None,
    });
    let may_be_slack: Vec<_> = may_be_slack.collect();
    if may_be_slack.is_empty() {
        return Ok(Vec::new());
    }
    let Simulation { t, q, v, u, n, .. } = simulation;
    let inputs = u.len() / t.len().max(1);
    let mut gradient = vec![0.0; *n];
    let mut found: Vec<Option<Slack>> = vec![None; may_be_slack.len()];
    for (k, &t) in t.iter().enumerate() {
        let (q, v) = (&q[k * n..][..*n], &v[k * n..][..*n]);
        if inputs > 0 {
            model.set_inputs(&u[k * inputs..][..inputs]);
        }
        model.set_time(t)?;
        let slack_tendons = if model.facts().is_one_sided { model.slack_tendons(q) } else { Vec::new() };
        for (found, (i, is_of_length, name)) in found.iter_mut().zip(&may_be_slack) {
            let tension = if *is_of_length {
                let is_inextensible = model.description().actuators[*i].is_inextensible();
                let mut is_taut = || match is_inextensible {
                    true => !slack_tendons.contains(i),
                    false => model.actuator(q, v, *i, &mut gradient)[2] != 0.0,
                };
                let is_known = found.is_some();
                if is_known || is_taut() {
                    continue;
                }
                None
            } else {
                let tension = model.command(*i);
                // Ignore NaN.
                if !matches!(tension.partial_cmp(&0.0), Some(std::cmp::Ordering::Less)) {
                    continue;
                }
                Some(tension)
            };
            let slack = found.get_or_insert_with(|| Slack { name: name.clone(), from: t, lowest: tension });
            slack.lowest = slack.lowest.zip(tension).map(|(before, tension)| before.min(tension));
        }
    }
    Ok(found.into_iter().flatten().collect())
}

impl Slack {
    /// A sentence for messages.
    pub fn sentence(&self) -> String {
        let Self { name, from, lowest } = self;
        match lowest {
            None => format!("'{name}' is slack, first at t = {}.", Time(*from)),
            Some(lowest) => format!(
                "The commanded tension of '{name}' is as low as {} N, first negative at t = {}: a tendon never pushes.",
                Rounded(*lowest),
                Time(*from)
            ),
        }
    }
}
