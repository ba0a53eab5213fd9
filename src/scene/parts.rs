//! Common parts of rods and links: segments, commands, base motions.

use super::described::{key_of, read, read_with};
use super::document::{Document, Simulation as Settings};
use super::shape::Shape;
use super::written::Written;
use crate::description::rod;
use crate::description::rod::STRAINS;
use crate::description::rod::described::{Modes, Segment};
use crate::description::schema::{Kind, Value};
use crate::description::signal::covers;
use crate::description::world;
use crate::description::world::described::BaseMotion;
use crate::robot::described::Link;

/// All segments with their keys, link by link.
pub(super) fn segments(document: &Document) -> Vec<(String, &Value)> {
    let of_rod = document.rod.first().into_iter().flat_map(|rod| {
        rod.segment.iter().enumerate().map(|(i, segment)| (format!("rod[0].segment[{i}]"), segment.value()))
    });
    let of_links = document.link.iter().enumerate().flat_map(|(l, link)| {
        let segments = of_link(&link.described).iter().enumerate();
        segments.map(move |(i, segment)| (format!("link[{l}].rod.segment[{i}]"), segment))
    });
    of_rod.chain(of_links).collect()
}

/// The segments of a link.
pub(super) fn of_link(link: &Written<Link>) -> &[Value] {
    match link.value().get("rod").and_then(|rod| rod.get("segment")) {
        Some(Value::List(segments)) => segments,
        _ => &[],
    }
}

/// Indices of segments with open modes, counted link by link.
pub(super) fn open_modes(document: &Document) -> Vec<usize> {
    let is_open = |segment: &Value| segment.get("modes").and_then(Value::text) == Some(Kind::OPEN);
    let segments = segments(document).into_iter().enumerate();
    segments.filter(|(_, (_, segment))| is_open(segment)).map(|(i, _)| i).collect()
}

/// The segment written at `here`; one of the same length and modes after reporting problems.
pub(super) fn segment(written: &Written<Segment>, here: &str, shape: &mut Shape) -> Segment {
    let found = read_with(written, here, shape, |place| in_section(written.value(), place));
    found.unwrap_or_else(|| {
        shape.replaced.insert(here.to_owned());
        stand_in(written.value())
    })
}

/// The place in the file of a place in the segment that this table describes: a circle may have a table of its own.
pub(super) fn in_section(segment: &Value, place: String) -> String {
    let is_inside = place.starts_with("radius") && segment.get("radius").is_none();
    if is_inside { format!("section.{place}") } else { place }
}

/// A segment of the length and the modes in this table, so that the rest can be checked.
pub(super) fn stand_in(segment: &Value) -> Segment {
    let length = key_of::<Segment, _>(segment, "length").unwrap_or(1.0);
    let modes = key_of::<Segment, Modes>(segment, "modes").map_or([0; STRAINS], |modes| modes.counts());
    rod::Segment { modes, ..rod::Segment::straight(length, 1.0, 1.0, 0.5, 1.0) }.described()
}

/// The motion written at `here`; rest after reporting a problem.
pub(super) fn base_motion(
    written: &Written<BaseMotion>,
    here: &str,
    settings: &Settings,
    shape: &mut Shape,
) -> BaseMotion {
    let Some(motion) = read(written, here, shape) else { return world::BaseMotion::rest().described() };
    check_span(motion.resolved().span(), here, settings, shape);
    motion
}

/// Reports a motion at `here` that is not defined during the whole run.
pub(super) fn check_span([from, to]: [f64; 2], here: &str, settings: &Settings, shape: &mut Shape) {
    let of_run = ["simulation.t_end", "simulation.t0"];
    let is_known = of_run.iter().all(|key| shape.is_readable(key));
    let (t0, t_end) = (settings.t0, settings.t_end);
    if is_known && !(covers([from, to], t0) && covers([from, to], t_end)) {
        let right = format!("its tables cover the run from {t0} to {t_end} s");
        shape.refuse(here, format!("known from {from} to {to} s"), format!("expected that {right}"));
    }
}
