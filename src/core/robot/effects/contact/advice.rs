//! Advice on the stiffness of contacts: too soft for the acting forces, or so stiff that runs fail.

use crate::model::Overlap;
use crate::robot::description::Robot;
use crate::robot::effects::contact::compile::{OVERLAP, default_stiffness, needed_stiffness, stiffnesses};
use crate::robot::effects::contact::obstacles::{Obstacle, Tube};
use crate::robot::effects::contact::query::ReportedTouch;
use crate::robot::effects::contact::shapes::centre_line::CentreLine;
use crate::robot::effects::contact::shapes::distance::to_segment;
use crate::robot::effects::contact::{Contact, Surface};

/// Largest acceptable overlap over the thickness of the thinner surface: twice that for which the default stiffness is chosen.
const LARGE_OVERLAP: f64 = 0.35;

/// From this overlap over the thickness on, contacts may have to bear more than they do.
const SUNK: f64 = 0.9;

/// Contacts stiffer than needed by this factor cost several times as many iterations.
const STIFF_FACTOR: f64 = 10.0;

/// Distance of the centre line of a tube from the straight lines between its points, over the radius of the bore, from which on it may
/// have led to an overlap that its points do not show.
const BULGE: f64 = 0.1;

/// Places of the centre line at which it is measured, on each of its parts.
const MEASURED: usize = 8;

/// Sentences about the deepest overlap of a run, if it is too deep, and about the contact point with the deepest overlap where the run
/// ended or after one more step.
pub(crate) fn advice(
    robot: &Robot,
    touches: &[ReportedTouch],
    is_ahead: bool,
    deepest: Option<Overlap>,
    has_failed: bool,
) -> String {
    let mut said = String::new();
    if let Some(touch) = touches.iter().max_by(|a, b| a.share.total_cmp(&b.share)) {
        said += &on_contact_point(robot, touch, is_ahead);
    }
    let seen: &[ReportedTouch] = if is_ahead { &[] } else { touches };
    let deepest =
        seen.iter().map(overlap).fold(deepest, |deepest, found| Overlap::deeper(deepest, Some(found)));
    if let Some(overlap) = deepest.filter(|overlap| overlap.share > LARGE_OVERLAP) {
        said += &soft(robot, overlap, has_failed);
    }
    said
}

/// What to know of the surfaces of a contact where a start or the end of a search is deep in one of them; often empty.
pub(crate) fn on_deep_overlap(contact: &Contact) -> String {
    let tubes = contact.surfaces.iter().filter_map(|surface| match surface.obstacle() {
        Some(Obstacle::Tube(tube)) => Some(tube),
        _ => None,
    });
    tubes.filter_map(on_centre_line).collect()
}

/// Where the smooth centre line of a tube leaves the straight lines between its points, if that is much for its bore.
fn on_centre_line(tube: &Tube) -> Option<String> {
    let points: Vec<_> = tube.points.iter().map(|&point| point.into()).collect();
    let beside = |place| {
        points.windows(2).map(|ends| to_segment(place, [ends[0], ends[1]])).fold(f64::INFINITY, f64::min)
    };
    let places = CentreLine::new(&points).places(MEASURED).into_iter();
    let (bulge, place) =
        places.map(|place| (beside(place), place)).max_by(|(a, _), (b, _)| a.total_cmp(b))?;
    if bulge <= BULGE * tube.radius {
        return None;
    }
    let [x, y, z] = place.to_array();
    Some(format!(
        " The centre line of the tube is a smooth curve through its {} points, which at ({x:.4}, {y:.4}, {z:.4}) m is {bulge:.1e} m beside \
         the straight line between two of them (the radius of the bore is {} m): give more points where the tube is straight.",
        points.len(),
        tube.radius,
    ))
}

fn overlap(touch: &ReportedTouch) -> Overlap {
    Overlap { contact: touch.contact, depth: touch.overlap, share: touch.share }
}

/// The stiffness at which the present contact force would cause the overlap for which the default stiffness is chosen.
fn fitting(contact: &Contact, stiffness: f64, overlap: Overlap) -> f64 {
    let power = if contact.is_spread() { 1.5 } else { 1.0 };
    stiffness * (overlap.share / OVERLAP).powf(power)
}

fn on_contact_point(robot: &Robot, touch: &ReportedTouch, is_ahead: bool) -> String {
    let contact = &robot.contacts[touch.contact];
    let stiffness = stiffnesses(robot)[touch.contact];
    let mut needed = needed_stiffness(robot, contact);
    let [x, y, z] = touch.position.to_array();
    let place = format!("({x:.4}, {y:.4}, {z:.4}) m{}", place(robot, contact, touch));
    let name = &contact.name;
    let mut said = if is_ahead {
        format!(" Surfaces meet in the next step: those of contact \"{name}\" near {place}.")
    } else {
        needed = needed.max(fitting(contact, stiffness, overlap(touch)));
        format!(
            " Surfaces touch there: contact \"{name}\" overlaps most{} at {place}, {:.1e} m deep, {} of {}.",
            if touch.is_at_edge { ", on an edge," } else { "" },
            touch.overlap,
            percent(touch.share),
            thickness(contact),
        )
    };
    if touch.share > SUNK {
        said += &on_deep_overlap(contact);
    }
    if contact.is_spread() && stiffness > STIFF_FACTOR * needed {
        said += &format!(
            " It is stiff for its load: `stiffness={}` in place of {} N/m^2 gives overlaps of about 15 % of the radius at edges, and \
             moves shapes by less than a thousandth of their length.",
            rounded(needed),
            rounded(stiffness),
        );
    }
    said
}

/// Where a search or run has failed, or surfaces are sunk into each other, the force need not be the whole one that the contact has to bear.
fn soft(robot: &Robot, overlap: Overlap, has_failed: bool) -> String {
    let contact = &robot.contacts[overlap.contact];
    let stiffness = stiffnesses(robot)[overlap.contact];
    let mut raised = fitting(contact, stiffness, overlap);
    let default = default_stiffness(robot, contact);
    if (has_failed || overlap.share > SUNK) && default.is_finite() {
        raised = raised.max(default);
    }
    format!(
        " The contact \"{}\" is soft for its load, its surfaces overlap by up to {:.1e} m, {} of {}: raise `stiffness` from {} to {} {}.",
        contact.name,
        overlap.depth,
        percent(overlap.share),
        thickness(contact),
        rounded(stiffness),
        rounded(raised),
        if contact.is_spread() { "N/m^2" } else { "N/m" },
    )
}

/// Position of a contact point along its rod, in words.
fn place(robot: &Robot, contact: &Contact, touch: &ReportedTouch) -> String {
    let along = contact.surfaces.iter().zip(touch.along).find_map(|(surface, along)| match surface {
        Surface::Rod { link } => along.map(|x| (&robot.links[*link].name, x)),
        _ => None,
    });
    along.map_or_else(String::new, |(link, x)| format!(", {x:.4} m along \"{link}\""))
}

fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 1.0 { format!("{percent:.1e} %") } else { format!("{percent:.0} %") }
}

fn thickness(contact: &Contact) -> &'static str {
    let is_round = |surface: &Surface| matches!(surface, Surface::Rod { .. } | Surface::Ball { .. });
    if contact.surfaces.iter().any(is_round) { "the smaller radius" } else { "half the smaller thickness" }
}

/// With two digits.
fn rounded(stiffness: f64) -> String {
    format!("{stiffness:.1e}")
}
