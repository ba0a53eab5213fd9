//! Facts of a robot: properties that do not change during a run.

use super::description::{Robot, Spans, Tightness};
use super::driven::Coordinates;
use super::explain::text::significant;
use super::kernel::{elasticity, sizes};
use super::sweeps::Sweeps;
use super::turning::Turning;
use crate::model::{Constraint, Facts};
use crate::robot::effects::actuator::Actuator;
use crate::robot::effects::contact::Contact;
use crate::robot::effects::loops::{Loop, LoopEnd, Tie};

/// Facts of a compiled robot.
pub(super) fn of<G: Turning>(robot: &Robot, sweeps: &Sweeps<G>, coordinates: &Coordinates) -> Facts {
    let plan = sweeps.plan();
    let (n, length) = (coordinates.own(plan.n), robot.length());
    let mut typical_coordinates = vec![0.0; n];
    coordinates
        .pick(&mut typical_coordinates, |of_all| elasticity::typical_coordinates(plan, length, of_all));
    let spans = Spans::new(robot);
    let gap_sizes = sizes::of_gaps(plan, |constraint| match constraint {
        Constraint::Loop(i) => spans.of_loop(&robot.loops[i]),
        Constraint::Tendon(i) => spans.of_tendon(&robot.actuators[i]),
    });
    let actuators = &plan.effects.actuation.actuators;
    let (has_contact, has_stops) = (!robot.contacts.is_empty(), sweeps.has_stops());
    let has_tendon_friction = actuators.iter().any(|actuator| actuator.friction.is_some());
    let has_rough_contact = robot.contacts.iter().any(|contact| contact.largest_friction() != [0.0; 3]);
    let are_sections_separate = coordinates.are_own() && robot.has_separate_sections();
    let are_lengths_free = are_sections_separate && robot.has_all_at_tips();
    let vary_coordinates = coordinates.vary_in_time();
    Facts {
        n,
        length,
        typical_coordinates,
        turns: coordinates.own_of(&elasticity::turns(plan)),
        rotation_vectors: robot.rotation_vectors(),
        parts: robot.parts(),
        is_discretised: robot.segments().any(|segment| segment.coordinates() > 0),
        gap_sizes,
        is_one_sided: !sweeps.slack().is_empty(),
        has_contact,
        has_rods_in_contact: robot.contacts.iter().any(Contact::has_rod),
        has_stops,
        has_one_sided_forces: has_contact || has_stops || robot.actuators.iter().any(Actuator::is_one_sided),
        has_tendon_friction,
        has_dry_friction: has_tendon_friction || has_rough_contact || sweeps.has_joint_friction(),
        sticking_time: sticking_time(robot),
        has_velocity_forces: vary_coordinates || sweeps.has_velocity_forces(),
        is_damped: sweeps.is_damped(),
        has_retardation: sweeps.has_retardation(),
        is_driven: vary_coordinates || sweeps.is_driven(),
        is_carried: vary_coordinates || robot.base_motion.is_some(),
        varies_in_time: vary_coordinates || plan.varies_in_time,
        time_span: robot.time_span(),
        shortest_period: robot.shortest_period(),
        has_functions: robot.has_functions(),
        default_inputs: robot.inputs().defaults().to_vec(),
        // Moment and force of every support, in the axes of the base.
        springs: 6 * robot.supports.len(),
        length_tendons: sweeps.length_tendons().count(),
        loops: robot.loops.iter().map(|closed| joined_by(robot, closed)).collect(),
        taut_loops: robot.loops.iter().filter_map(|closed| taut_between(robot, closed)).collect(),
        section_places: if are_sections_separate { sweeps.section_places() } else { Vec::new() },
        free_lengths: if are_lengths_free { sweeps.free_lengths() } else { 0 },
    }
}

fn sticking_time(robot: &Robot) -> f64 {
    let weight = robot.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let time_of = |contact: &Contact| {
        let at_rest = contact.static_friction.filter(|at_rest| *at_rest > contact.friction[0])?;
        Some(contact.stribeck_velocity / (at_rest * weight))
    };
    robot.contacts.iter().filter_map(time_of).fold(f64::INFINITY, f64::min)
}

/// What a loop joins and how long that is, in words, if it is a straight line that cannot stretch.
fn taut_between(robot: &Robot, closed: &Loop) -> Option<String> {
    let (Tightness::Taut, [_, length]) = robot.tightness(closed)? else { return None };
    Some(format!("{}: {} m", joined_by(robot, closed), significant(length)))
}

/// What a loop joins, in words.
fn joined_by(robot: &Robot, closed: &Loop) -> String {
    let of_end = |end: &LoopEnd| match end.link {
        Some(link) => format!("\"{}\"", robot.links[link].name),
        None => "the world".to_owned(),
    };
    match &closed.tie {
        Tie::Joint { ends, .. } | Tie::Distance { ends, .. } => {
            let joined = ends.each_ref().map(of_end).join(" and ");
            match robot.tightness(closed) {
                Some((Tightness::TooShort, ends)) => {
                    let [apart, length] = ends.map(significant);
                    format!("{joined} ({apart} m apart, and what joins them is only {length} m long)")
                }
                _ => joined,
            }
        }
        Tie::Coordinates { coordinates, .. } => {
            let names = robot.coordinate_names();
            coordinates.map(|coordinate| format!("\"{}\"", names[coordinate])).join(" and ")
        }
    }
}
