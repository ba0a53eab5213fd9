//! Loads that are absurd for the stiffness of the rod on which they act: probably numbers in other units.

use super::text::significant;
use crate::description::rod::SectionProperties;
use crate::description::signal::Signal;
use crate::error::Interrupted;
use crate::robot::description::{Inputs, Link, Robot};
use crate::robot::effects::actuator::{Actuator, Along, Chamber, Drive, Tendon};
use crate::robot::effects::load::Extent;

/// Strain at which the compressed side of a rod has no length left.
const CRUSHED: f64 = 1.0;

/// Strain that no material bears: the best rubbers break below.
const TORN: f64 = 10.0;

/// Parts of a segment between the places at which its section is looked at.
const PLACES: u32 = 4;

/// The strains that a force along a rod causes in the section where they are largest.
struct Strains {
    /// In the axis.
    axial: f64,
    /// In the outermost fibre, by bending.
    bent: f64,
    /// E A there, in newtons.
    stiffness: f64,
}

/// Values of inputs at a time.
struct Commands<'a> {
    t: f64,
    inputs: Option<(&'a [f64], Inputs)>,
}

impl Commands<'_> {
    fn value<const N: usize>(&self, signal: &Signal<N>) -> Result<[f64; N], Interrupted> {
        match (&self.inputs, signal.input()) {
            (Some((u, inputs)), Some(input)) => {
                let first = inputs.place(input);
                Ok(std::array::from_fn(|i| u[first + i]))
            }
            _ => signal.at(self.t),
        }
    }
}

/// A sentence about each tendon, chamber and force that by the stiffness of its rod would strain it more than anything bears. Only a
/// function of time can fail.
pub(crate) fn overloads(robot: &Robot, t: f64, u: Option<&[f64]>) -> Result<Vec<String>, Interrupted> {
    let commands = Commands { t, inputs: u.map(|u| (u, robot.inputs())) };
    let mut said = Vec::new();
    for actuator in &robot.actuators {
        let (force, does) = match actuator {
            Actuator::Tendon(Tendon { name, drive: Drive::Tension(tension), .. }) => {
                let [tension] = commands.value(tension)?;
                (
                    tension.max(0.0),
                    format!("The tendon \"{name}\" pulls with {} N", significant(tension.max(0.0))),
                )
            }
            Actuator::Chamber(Chamber { name, area, pressure, .. }) => {
                let [pressure] = commands.value(pressure)?;
                let force = (pressure * area).abs();
                (force, format!("The chamber \"{name}\" presses with {} N", significant(force)))
            }
            _ => continue,
        };
        let along = actuator.along().into_iter();
        let worst = along.map(|along| (&robot.links[along.link], strains(robot, along, force)));
        let worst = worst.max_by(|(_, a), (_, b)| (a.axial + a.bent).total_cmp(&(b.axial + b.bent)));
        let Some((link, Strains { axial, bent, stiffness })) = worst else { continue };
        // Tension in a chamber relieves the inner side of the bend.
        let is_absurd = match actuator.pulls() {
            true => axial + bent > CRUSHED,
            false => bent - axial > CRUSHED || axial + bent > TORN,
        };
        if is_absurd {
            said.push(sentence(&does, link, axial + bent, stiffness));
        }
    }
    for load in robot.acting_loads() {
        let over = if let Extent::Along([from, to]) = load.extent { to - from } else { 1.0 };
        let force = over * commands.value(&load.force)?.into_iter().fold(0.0, f64::hypot);
        let link = &robot.links[load.link];
        let stiffness =
            places(link).map(|(_, section)| section.stiffness[3][3]).fold(f64::INFINITY, f64::min);
        if force > TORN * stiffness {
            let does = format!("A load pulls with {} N", significant(force));
            said.push(sentence(&does, link, force / stiffness, stiffness));
        }
    }
    Ok(said)
}

fn sentence(does: &str, link: &Link, strain: f64, stiffness: f64) -> String {
    format!(
        "{does}, which by the stiffness of the rod of {:?} (E A = {} N) would strain it by {:.0} %, more than rods bear. Is the force in \
         newtons, is the modulus in pascals, are the lengths in metres?",
        link.name,
        significant(stiffness),
        100.0 * strain,
    )
}

/// The sections of a rod at arc lengths from its base.
fn places(link: &Link) -> impl Iterator<Item = (f64, Section)> {
    let mut start = 0.0;
    link.rod.iter().flat_map(move |segment| {
        let from = start;
        start += segment.length;
        (0..=PLACES).map(move |i| {
            let x = f64::from(i) / f64::from(PLACES);
            let SectionProperties { stiffness, .. } = SectionProperties::at(segment, x);
            (from + x * segment.length, Section { stiffness, half_extents: segment.section.half_extents(x) })
        })
    })
}

/// Stiffness and size of a section.
struct Section {
    stiffness: [[f64; 6]; 6],
    half_extents: [f64; 2],
}

/// The largest strains by a force along a part of a rod.
fn strains(robot: &Robot, along: &Along, force: f64) -> Strains {
    let link = &robot.links[along.link];
    let length = link.length();
    let within = |x: &f64| (along.along[0]..=along.along[1]).contains(x);
    let all = places(link).filter(|(x, _)| within(x)).map(|(x, Section { stiffness, half_extents })| {
        let [y, z] = along.offset.each_ref().map(|offset| offset.at(x / length)[0]);
        let [about_y, about_z] = [force * z / stiffness[1][1], force * y / stiffness[2][2]];
        let bent = (about_y * half_extents[1]).abs() + (about_z * half_extents[0]).abs();
        Strains { axial: force / stiffness[3][3], bent, stiffness: stiffness[3][3] }
    });
    let none = Strains { axial: 0.0, bent: 0.0, stiffness: f64::INFINITY };
    all.fold(
        none,
        |worst, found| if found.axial + found.bent > worst.axial + worst.bent { found } else { worst },
    )
}
