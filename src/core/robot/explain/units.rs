//! Questions about numbers that are probably in other units than SI.

use super::distances::implausible_distances;
use super::sizes::{PLACES, half_width};
use super::text::significant;
use crate::description::rod::{Section, SectionProperties, Segment};
use crate::robot::description::{Link, Robot};
use crate::robot::effects::actuator::{Actuator, Along};

/// Pascals: softer than anything that holds its shape; brain and the softest gels have about 1 kPa (Engler et al. 2006).
const SOFTEST: f64 = 1e3;

/// Pascals: stiffer than anything. Diamond has 1.2e12.
const STIFFEST: f64 = 2e12;

/// Kilograms per cubic metre: lighter than foams, heavier than osmium (22 590).
const LIGHTEST: f64 = 10.0;
const HEAVIEST: f64 = 23e3;

/// Metres: half the width of a rod whose sizes are probably in millimetres.
const WIDEST: f64 = 1.0;

/// Width of a rod over its length: even discs are longer, and millimetres make slender rods at least five times as wide as long.
const STOUTEST: f64 = 3.0;

/// m/s^2: gravity above this is probably in other units.
const STRONGEST_GRAVITY: f64 = 100.0;

/// m/s^2: the Earth's gravity in millimetres and milliseconds, and the part of it by which others may differ.
const IN_MILLISECONDS: f64 = 9.81e-3;
const ALIKE: f64 = 5e-3;

/// Strains, in their order.
const BENDS: [usize; 2] = [1, 2];
const STRETCH: usize = 3;

/// Offset of a tendon or chamber over the half width of its rod: guide disks have at most a hundred, and offsets in millimetres at least
/// five hundred, as a tendon runs no nearer to the axis than by half the radius.
const FARTHEST: f64 = 200.0;

/// Area of a chamber over that of the section around it: bellows beside a rod are a few times as wide as it.
const WIDEST_CHAMBER: f64 = 10.0;

impl Robot {
    /// Questions about moduli, densities, widths, actuators, contacts and a gravity that are probably in other units than SI. Allocates.
    pub fn implausible_units(&self) -> Vec<String> {
        implausible_units(self)
    }
}

/// A sentence about each implausible modulus, density, width and contact, and about the gravity; each is said once.
fn implausible_units(robot: &Robot) -> Vec<String> {
    let mut said = Vec::new();
    let mut say = |sentence: String| {
        if !said.contains(&sentence) {
            said.push(sentence);
        }
    };
    for segment in robot.links.iter().flat_map(|link| &link.rod) {
        // A given section has neither a modulus nor a density.
        if matches!(segment.section, Section::Given(_)) {
            continue;
        }
        let [modulus, density] = [segment.young_modulus, segment.density];
        if !(SOFTEST..=STIFFEST).contains(&modulus) {
            let than = if modulus < SOFTEST { "softer than any gel" } else { "stiffer than diamond" };
            let modulus = significant(modulus);
            say(format!(
                "A Young's modulus of {modulus} Pa is {than}; in pascals rubber has 1e6 and steel 2.1e11."
            ));
        }
        if !(LIGHTEST..=HEAVIEST).contains(&density) {
            let than = if density < LIGHTEST { "lighter than foam" } else { "heavier than any metal" };
            let density = significant(density);
            say(format!("A density of {density} kg/m³ is {than}; water has 1000 and steel 7800."));
        }
    }
    for link in &robot.links {
        let widest = link.rod.iter().map(half_width).fold(0.0, f64::max);
        let by_stiffness = link.rod.iter().map(half_width_by_stiffness).fold(0.0, f64::max);
        let [width, length] = [2.0 * widest, link.length()].map(significant);
        if widest > WIDEST {
            say(format!("{:?} is {width} m wide; lengths are in metres.", link.name));
        } else if 2.0 * widest > STOUTEST * link.length() {
            say(format!("{:?} is {width} m wide and {length} m long; are both in metres?", link.name));
        } else if by_stiffness > WIDEST || 2.0 * by_stiffness > STOUTEST * link.length() {
            let width = significant(2.0 * by_stiffness);
            say(format!(
                "The stiffnesses of bending and stretch of {:?} are those of a rod that is {width} m wide, and it is {length} m long; is \
                 bending in N m²?",
                link.name
            ));
        }
    }
    robot.actuators.iter().flat_map(|actuator| of_actuator(robot, actuator)).for_each(&mut say);
    implausible_distances(robot).into_iter().for_each(&mut say);
    let strength = robot.gravity.iter().fold(0.0_f64, |sum, g| sum.hypot(*g));
    if (strength - IN_MILLISECONDS).abs() < ALIKE * IN_MILLISECONDS {
        let strength = significant(strength);
        say(format!(
            "Gravity is {strength} m/s², that of the Earth is 9.81; {strength} is its number in mm/ms², but lengths are in metres, times \
             in seconds and masses in kilograms."
        ));
    }
    if strength > STRONGEST_GRAVITY {
        let strength = significant(strength);
        say(format!("Gravity is {strength} m/s², on Earth it is 9.81; lengths are in metres."));
    }
    said
}

/// Offsets far beside the rod, or beyond its length, and chambers that are larger than their rods.
fn of_actuator(robot: &Robot, actuator: &Actuator) -> Vec<String> {
    let kind = if actuator.pulls() { "tendon" } else { "chamber" };
    let name = actuator.name();
    let mut said = Vec::new();
    for along in actuator.along() {
        let link = &robot.links[along.link];
        let width = link.rod.iter().map(half_width).fold(0.0, f64::max);
        let offset = largest_offset(along);
        // Given sections without inertia have no width.
        if offset > link.length() || width > 0.0 && offset > FARTHEST * width {
            said.push(format!(
                "The {kind} {name:?} runs {} m beside the axis of {:?}, which is {} m long{}; are its offsets in metres?",
                significant(offset),
                link.name,
                significant(link.length()),
                if width > 0.0 { format!(" and {} m wide", significant(2.0 * width)) } else { String::new() },
            ));
        }
        if let Actuator::Chamber(chamber) = actuator
            && let Some(outline) = outline(link)
            && chamber.area > WIDEST_CHAMBER * outline
        {
            said.push(format!(
                "The chamber {name:?} has an area of {} m², the section of {:?} {} m²; is it in square metres?",
                significant(chamber.area),
                link.name,
                significant(outline),
            ));
        }
    }
    said
}

/// The largest distance of a part of a path from the axis of its rod.
fn largest_offset(along: &Along) -> f64 {
    let at = |i| along.offset.each_ref().map(|offset| offset.at(f64::from(i) / f64::from(PLACES))[0]);
    (0..=PLACES).map(at).map(|[y, z]| y.hypot(z)).fold(0.0, f64::max)
}

/// The largest area within the outlines of a rod's sections; `None` if one is given without it.
fn outline(link: &Link) -> Option<f64> {
    let at =
        |segment: &Segment, i| SectionProperties::at(segment, f64::from(i) / f64::from(PLACES)).outline_area;
    let areas = link.rod.iter().flat_map(|segment| (0..=PLACES).map(move |i| at(segment, i)));
    let [least, most] =
        areas.fold([f64::INFINITY, 0.0], |[least, most], area| [area.min(least), area.max(most)]);
    (least > 0.0 && most > 0.0).then_some(most)
}

/// Half the width of a round section with the stiffnesses of a given one, 2 sqrt(E I / E A); zero where one of them does not matter,
/// because the strain has no modes.
fn half_width_by_stiffness(segment: &Segment) -> f64 {
    let (Section::Given(given), true) = (&segment.section, segment.modes[STRETCH] > 0) else { return 0.0 };
    let at = |i| {
        let stiffness = given.at(f64::from(i) / f64::from(PLACES)).stiffness;
        let bends = BENDS.into_iter().filter(|&bend| segment.modes[bend] > 0);
        bends
            .map(|bend| 2.0 * (stiffness[bend][bend] / stiffness[STRETCH][STRETCH]).sqrt())
            .fold(0.0, f64::max)
    };
    (0..=PLACES).map(at).fold(0.0, f64::max)
}
