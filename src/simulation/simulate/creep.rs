//! Friction that creeps where it should hold. Dry friction of tendons, joints and contacts is smoothed over a velocity, below which a part
//! under a constant force goes on slowly for ever. Checked at times of the result only.

use super::Simulation;
use crate::description::joint::Joint;
use crate::error::{Interrupted, Number};
use crate::model::{Dynamics as _, InTime as _};
use crate::robot::effects::actuator::{Actuator, Tendon};
use crate::robot::{ReportedTouch, Robot, RobotModel};

/// Creep of more than this part of the way that a part has made, and of its typical range, causes a doubt.
const LARGE_CREEP: f64 = 0.05;

/// Part of the way that is left to creep with the velocity that a doubt suggests, if creep is proportional to that velocity: a hold of
/// 20 s that crept to its end needs a twentieth of what that gives for [`LARGE_CREEP`].
const SUGGESTED_CREEP: f64 = 2e-3;

/// Surfaces under constant loads that slide by fewer velocities `slip_velocity` than this would stick: so slow they would be stopped at once. What
/// slides steadily because something drives it may be as slow.
const SLOW: f64 = 10.0;

/// Part of the creep that causes a doubt that is left with the `slip_velocity` that the doubt suggests.
const LEFT_OF_SLOW: f64 = 0.5;

/// Times of the result at which contacts are looked at, at most: each costs an evaluation, and what creeps does so for long.
const MOST_TIMES: usize = 200;

/// What rubs: a tendon, by the index of the actuator, a joint, by that of its coordinate, or a contact.
#[derive(Clone, Copy, Debug)]
enum Rubbing {
    Tendon(usize),
    Joint(usize),
    Contact(usize),
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
    /// Whether all slow motion is creep, because nothing drives it.
    is_undriven: bool,
}

impl Part {
    fn new(rubbing: Rubbing, name: String, smoothing: f64, unit: &'static str) -> Self {
        Self {
            rubbing,
            name,
            smoothing,
            unit,
            speed: 0.0,
            way: 0.0,
            crept: 0.0,
            range: 0.0,
            is_undriven: false,
        }
    }

    /// Speed at which friction is too small, times the part of it that is missing.
    fn creep(&self, speed: f64) -> f64 {
        if self.is_undriven && speed < SLOW * self.smoothing {
            return speed;
        }
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
        let enough = match self.is_undriven {
            // Creep is proportional to the velocity.
            true => smoothing * LEFT_OF_SLOW * LARGE_CREEP * self.range / self.crept,
            false => smoothing * SUGGESTED_CREEP / part,
        };
        let of = match self.rubbing {
            Rubbing::Tendon(_) => "the tendon",
            Rubbing::Joint(_) => "the joint of",
            Rubbing::Contact(_) => "the contact",
        };
        let velocity = match self.rubbing {
            Rubbing::Tendon(_) | Rubbing::Joint(_) => "friction_velocity",
            Rubbing::Contact(_) => "slip_velocity",
        };
        let length = unit.trim_end_matches("/s");
        format!(
            "Friction of {of} \"{name}\" is smoothed over its `{velocity}` of {} {unit} and creeps below: of a way of {way:.1e} {length} \
             it lets {:.0} % pass that dry friction would hold. Give it {enough:.0e} {unit}.",
            Number(*smoothing),
            100.0 * part
        )
    }
}

/// A doubt about the part whose friction crept most in a motion of this robot, if it crept far. Costs an evaluation of the motion for each
/// tendon with friction and time, and `MOST_TIMES` for all contacts. Only a function of time can fail.
pub fn creep(model: &mut RobotModel, simulation: &Simulation) -> Result<Option<String>, Interrupted> {
    let Simulation { t, q, v, u, n, .. } = simulation;
    let (mut parts, mut contacts) = (rubbing(model), contacts(model));
    let Some(last) = t.len().checked_sub(1).filter(|_| !parts.is_empty() || !contacts.is_empty()) else {
        return Ok(None);
    };
    let (stride, mut touched_at) = (t.len().div_ceil(MOST_TIMES), t[0]);
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
                Rubbing::Contact(_) => unreachable!("contacts are apart"),
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
        if !contacts.is_empty() && (k % stride == 0 || k == last) {
            follow_contacts(&mut contacts, &model.touches(q, v), now - touched_at);
            touched_at = now;
        }
    }
    parts.append(&mut contacts);
    let far = parts.iter().filter_map(|part| Some((part.large()?, part)));
    let most = far.max_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(most.map(|(crept, part)| part.sentence(crept)))
}

/// Goes on with all contacts by the speeds of sliding of their contact points, each with the share of its normal force.
fn follow_contacts(contacts: &mut [Part], touches: &[ReportedTouch], duration: f64) {
    for part in contacts {
        let Rubbing::Contact(contact) = part.rubbing else { continue };
        let [mut force, mut weighted] = [0.0; 2];
        for touch in touches.iter().filter(|touch| touch.contact == contact) {
            let normal = touch.force.dot(touch.normal).max(0.0);
            force += normal;
            weighted += normal * touch.sliding.dot(touch.sliding).sqrt();
        }
        part.go_on(duration, if force > 0.0 { weighted / force } else { 0.0 });
    }
}

/// All contacts with friction, whose typical range is the length of the robot.
fn contacts(model: &RobotModel) -> Vec<Part> {
    let (range, robot) = (model.facts().length, model.description());
    let facts = model.facts();
    let is_undriven = !facts.varies_in_time
        && !facts.is_carried
        && robot.actuators.is_empty()
        && robot.links.iter().all(|link| link.driven.is_none());
    let with_friction =
        robot.contacts.iter().enumerate().filter(|(_, contact)| contact.largest_friction()[0] > 0.0);
    let parts = with_friction.map(|(c, contact)| {
        let part = Part::new(Rubbing::Contact(c), contact.name.clone(), contact.slip_velocity, "m/s");
        Part { range, is_undriven, ..part }
    });
    parts.collect()
}

/// Whether a joint or a contact of a robot has dry friction.
pub fn has_friction(robot: &Robot) -> bool {
    robot.links.iter().any(|link| link.joint.forces().is_some_and(|forces| forces.friction > 0.0))
        || robot.contacts.iter().any(|contact| contact.largest_friction()[0] > 0.0)
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
