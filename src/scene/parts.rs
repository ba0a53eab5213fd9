//! Common parts of rods and links: segments, commands, base motions.

use super::described::{Written, read, read_with};
use super::document::{Document, Simulation as Settings};
use super::shape::Shape;
use crate::description::Kind;
use crate::rod::described::{Modes, Section, Segment};
use crate::rod::{self, STRAINS};
use crate::signal::covers;
use crate::world::{self, described::BaseMotion};

/// All segments with their keys, link by link.
pub(super) fn segments(document: &Document) -> Vec<(String, &Written<Segment>)> {
    let of_rod = document.rod.first().into_iter().flat_map(|rod| {
        rod.segment.iter().enumerate().map(|(i, segment)| (format!("rod[0].segment[{i}]"), segment))
    });
    let of_links = document.link.iter().enumerate().flat_map(|(l, link)| {
        let segments = link.rod.iter().flat_map(|rod| &rod.segment).enumerate();
        segments.map(move |(i, segment)| (format!("link[{l}].rod.segment[{i}]"), segment))
    });
    of_rod.chain(of_links).collect()
}

/// Indices of segments with open modes, counted link by link.
pub(super) fn open_modes(document: &Document) -> Vec<usize> {
    let is_open = |segment: &Written<Segment>| segment.text("modes") == Some(Kind::OPEN);
    let segments = segments(document).into_iter().enumerate();
    segments.filter(|(_, (_, segment))| is_open(segment)).map(|(i, _)| i).collect()
}

/// The segment written at `here`; one of the same length and modes after reporting problems.
pub(super) fn segment(written: &Written<Segment>, here: &str, shape: &mut Shape) -> rod::Segment {
    // A circle may stand in a table of its own.
    let is_table = written.key::<Section>("section").is_some();
    let found = read_with(written, here, shape, |place| match place.starts_with("radius") && is_table {
        true => format!("section.{place}"),
        false => place,
    });
    if let Some(found) = found {
        return found.resolved();
    }
    shape.replaced.insert(here.to_owned());
    let length = written.key("length").filter(|length: &f64| length.is_finite() && *length > 0.0);
    let modes = written.key("modes").map_or([0; STRAINS], |modes: Modes| modes.counts());
    rod::Segment { modes, ..rod::Segment::straight(length.unwrap_or(1.0), 1.0, 1.0, 0.5, 1.0) }
}

/// The motion written at `here`; rest after reporting a problem.
pub(super) fn base_motion(
    written: &Written<BaseMotion>,
    here: &str,
    settings: &Settings,
    shape: &mut Shape,
) -> world::BaseMotion {
    let Some(motion) = read(written, here, shape) else { return world::BaseMotion::rest() };
    let motion = motion.resolved();
    check_span(motion.span(), here, settings, shape);
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
