//! The tables of all parts.

use std::sync::LazyLock;

use crate::description::body::described as body;
use crate::description::joint::described as joint;
use crate::description::rod::described as rod;
use crate::description::schema::{Part, Schema};
use crate::description::world::described::BaseMotion;
use crate::robot::described as robot;
use crate::robot::effects;

/// The parts that are described by tables, those that others hold first.
pub(crate) static PARTS: LazyLock<Vec<&'static Schema>> = LazyLock::new(|| {
    let of_robots = [
        rod::Circle::SCHEMA,
        rod::HollowCircle::SCHEMA,
        rod::Rectangle::SCHEMA,
        rod::Ellipse::SCHEMA,
        rod::Given::SCHEMA,
        rod::Segment::SCHEMA,
        body::Body::SCHEMA,
        BaseMotion::SCHEMA,
        joint::Weld::SCHEMA,
        joint::Mimic::SCHEMA,
        joint::Revolute::SCHEMA,
        joint::Prismatic::SCHEMA,
        joint::Screw::SCHEMA,
        joint::Cylindrical::SCHEMA,
        joint::Universal::SCHEMA,
        joint::Planar::SCHEMA,
        joint::Spherical::SCHEMA,
        joint::Free::SCHEMA,
        robot::Link::SCHEMA,
    ];
    of_robots.into_iter().chain(effects::PARTS).collect()
});
