//! Joints that follow others.

use super::driven::Driven;
use super::link::Link;
use crate::description::joint::OF_ONE_COORDINATE;
use crate::error::Checker;

/// Origin of a joint's single coordinate: `factor` times that of the joint of `link`, plus `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    /// Index of a link whose joint mimics no other.
    pub link: usize,
    /// Factor of its coordinate.
    pub factor: f64,
    /// Added constant, in metres or radians.
    pub offset: f64,
}

/// Origin of the coordinate of a link's joint, following all mimicked joints; `None` for a cycle or for an
/// index without a link.
pub fn origin(links: &[Link], link: usize) -> Option<Origin> {
    let mut origin = Origin { link, factor: 1.0, offset: 0.0 };
    for _ in 0..=links.len() {
        let Some(Driven::Mimic { link, multiplier, offset }) = links.get(origin.link)?.driven else {
            return Some(origin);
        };
        origin = Origin {
            link,
            factor: origin.factor * multiplier,
            offset: origin.offset + origin.factor * offset,
        };
    }
    None
}

/// Reports joints that mimic a missing link, a joint without exactly one coordinate, or themselves.
pub(super) fn check_mimics(check: &mut Checker, links: &[Link]) {
    for (i, link) in links.iter().enumerate() {
        let Some(Driven::Mimic { link: other, .. }) = link.driven else { continue };
        let place = format!("links[{i}].joint.mimic.link");
        let expected = format!("another link with {OF_ONE_COORDINATE}");
        let Some(mimicked) = links.get(other) else {
            check.require(false, &place, format_args!("link {other}"), &expected);
            continue;
        };
        let joint = &mimicked.joint;
        let found =
            format_args!("\"{}\", whose joint is a {} joint", mimicked.name, joint.name()).to_string();
        if check.require(joint.coordinates().len() == 1, &place, found, &expected) {
            let found = format_args!("\"{}\", which mimics this joint", mimicked.name).to_string();
            let found = if other == i { "the joint itself".to_owned() } else { found };
            let is_known = origin(links, i).is_some();
            check.require(is_known, &place, found, "joints that do not mimic each other in a circle");
        }
    }
}
