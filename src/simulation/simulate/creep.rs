//! Friction that creeps where it should hold. Dry friction of tendons and joints is smoothed over a velocity, below which a part under a
//! constant force goes on slowly for ever. Checked at the times of the result only.

use super::Simulation;
use crate::description::joint::Joint;
use crate::error::{Interrupted, Number};
use crate::model::{Dynamics as _, InTime as _};
use crate::robot::effects::actuator::{Actuator, Tendon};
use crate::robot::{Robot, RobotModel};

/// Creep of more than this part of the way that a part has made, and of its typical range, causes a doubt.
const LARGE_CREEP: f64 = 0.05;

/// Part of the way that is left to creep with the velocity that a doubt suggests, if creep is proportional to that velocity: a hold of
/// 20 s that crept to its end needs a twentieth of what that gives for [`LARGE_CREEP`].
const SUGGESTED_CREEP: f64 = 2e-3;

/// What rubs: a tendon, by the index of the actuator, or a joint, by that of its coordinate.
#[derive(Clone, Copy, Debug)]
enum Rubbing {
    Tendon(usize),
    Joint(usize),
}

/// A part with friction over a run.
#[derive(Clone, Debug)]
struct Part {
    rubbing: Rubbing,
    name: String,
    /// The velocity over which friction is smoothed, and its unit.
    smoothing: f64,
    unit: &'static str,
    /// Speed now.
    speed: f64,
    /// The whole way, the way by which smoothed friction went on where dry friction holds, and a typical range.
    way: f64,
    crept: f64,
    range: f64,
}

impl Part {
    fn new(rubbing: Rubbing, name: String, smoothing: f64, unit: &'static str) -> Self {
        Self { rubbing, name, smoothing, unit, speed: 0.0, way: 0.0, crept: 0.0, range: 0.0 }
    }

    /// Speed at which friction is too small, times the part of it that is missing.
    fn creep(&self, speed: f64) -> f64 {
        speed * (1.0 - speed / speed.hypot(self.smoothing))
    }

    /// Adds the time since the last state, in which the speed changed linearly.
    fn go_on(&mut self, duration: f64, speed: f64) {
        let half = 0.5 * duration;
        self.way += half * (self.speed + speed);
        self.crept += half * (self.creep(self.speed) + self.creep(speed));
        self.speed = speed;
    }

    /// Part of the way that was creep, if that is large.
    fn large(&self) -> Option<f64> {
        let part = self.crept / self.way;
        (part > LARGE_CREEP && self.crept > LARGE_CREEP * self.range).then_some(part)
    }

    fn sentence(&self, part: f64) -> String {
        let Self { name, smoothing, unit, way, .. } = self;
        let enough = smoothing * SUGGESTED_CREEP / part;
        let of = match self.rubbing {
            Rubbing::Tendon(_) => "the tendon",
            Rubbing::Joint(_) => "the joint of",
        };
        let length = unit.trim_end_matches("/s");
        format!(
            "Friction of {of} \"{name}\" is smoothed over its `friction_velocity` of {} {unit} and creeps below: of a way of {way:.1e} {length} \
             it lets {:.0} % pass that dry friction would hold. Give it {enough:.0e} {unit}.",
            Number(*smoothing),
            100.0 * part
        )
    }
}

/// A doubt about the part whose friction crept most in a motion of this robot, if it crept far. Costs an evaluation of the motion for each
/// tendon with friction and time. Only a function of time can fail.
pub fn creep(model: &mut RobotModel, simulation: &Simulation) -> Result<Option<String>, Interrupted> {
    let Simulation { t, q, v, u, n, .. } = simulation;
    let mut parts = rubbing(model);
    if parts.is_empty() {
        return Ok(None);
    }
    let inputs = u.len() / t.len().max(1);
    let sizes = model.facts().typical_coordinates.clone();
    let mut gradient = vec![0.0; *n];
    for (k, &now) in t.iter().enumerate() {
        let (q, v) = (&q[k * n..][..*n], &v[k * n..][..*n]);
        if inputs > 0 {
            model.set_inputs(&u[k * inputs..][..inputs]);
        }
        model.set_time(now)?;
        for part in &mut parts {
            let (speed, range) = match part.rubbing {
                Rubbing::Joint(coordinate) => (v[coordinate], sizes[coordinate]),
                Rubbing::Tendon(actuator) => {
                    let [_, rate, tension] = model.actuator(q, v, actuator, &mut gradient);
                    let range = gradient.iter().zip(&sizes).map(|(slope, size)| (slope * size).abs());
                    // A slack tendon has no friction.
                    (if tension > 0.0 { rate } else { 0.0 }, range.fold(0.0, f64::max))
                }
            };
            part.range = part.range.max(range);
            if k == 0 {
                part.speed = speed.abs();
            } else {
                part.go_on(now - t[k - 1], speed.abs());
            }
        }
    }
    let far = parts.iter().filter_map(|part| Some((part.large()?, part)));
    let most = far.max_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(most.map(|(crept, part)| part.sentence(crept)))
}

/// Whether a joint of a robot has dry friction.
pub fn has_joint_friction(robot: &Robot) -> bool {
    robot.links.iter().any(|link| link.joint.forces().is_some_and(|forces| forces.friction > 0.0))
}

/// All that rubs by its velocity: tendons whose sliding is commanded do not creep, nor do prescribed joints.
fn rubbing(model: &RobotModel) -> Vec<Part> {
    let robot = model.description();
    let tendons = robot.actuators.iter().enumerate().filter_map(|(i, actuator)| match actuator {
        Actuator::Tendon(Tendon { name, friction, friction_velocity, sliding: None, .. }) => {
            let part = Part::new(Rubbing::Tendon(i), name.clone(), *friction_velocity, "m/s");
            (*friction > 0.0).then_some(part)
        }
        _ => None,
    });
    let joints = robot.links.iter().enumerate().filter_map(|(l, link)| {
        let forces = link.joint.forces().filter(|forces| forces.friction > 0.0 && link.driven.is_none())?;
        let unit = if matches!(link.joint, Joint::Prismatic { .. }) { "m/s" } else { "rad/s" };
        let coordinate = robot.coordinates_of(l).start;
        Some(Part::new(Rubbing::Joint(coordinate), link.name.clone(), forces.friction_velocity, unit))
    });
    tendons.chain(joints).collect()
}
