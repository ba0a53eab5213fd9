//! The tables of all parts.

use crate::description::body::described as body;
use crate::description::joint::described as joint;
use crate::description::rod::described as rod;
use crate::description::schema::{Part, Schema};
use crate::description::world::described::BaseMotion;
use crate::robot::described as robot;
use crate::robot::effects::actuator::described as actuator;
use crate::robot::effects::contact::described as contact;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::described as load;
use crate::robot::effects::loops::described as loops;
use crate::robot::effects::magnet::described as magnet;
use crate::robot::effects::support::described as support;

/// The parts that are described by tables, those that others hold first.
pub(crate) const PARTS: [&Schema; 40] = [
    rod::Circle::SCHEMA,
    rod::HollowCircle::SCHEMA,
    rod::Rectangle::SCHEMA,
    rod::Ellipse::SCHEMA,
    rod::Given::SCHEMA,
    rod::Segment::SCHEMA,
    contact::Ball::SCHEMA,
    contact::HalfSpace::SCHEMA,
    contact::Sphere::SCHEMA,
    contact::Capsule::SCHEMA,
    contact::Cuboid::SCHEMA,
    contact::HeightField::SCHEMA,
    contact::ConvexMesh::SCHEMA,
    contact::Contact::SCHEMA,
    load::Load::SCHEMA,
    body::Body::SCHEMA,
    support::Support::SCHEMA,
    Fluid::SCHEMA,
    magnet::Magnet::SCHEMA,
    BaseMotion::SCHEMA,
    actuator::Along::SCHEMA,
    actuator::Via::SCHEMA,
    actuator::Tendon::SCHEMA,
    actuator::Chamber::SCHEMA,
    actuator::Motor::SCHEMA,
    actuator::ActiveStrain::SCHEMA,
    joint::Weld::SCHEMA,
    joint::Mimic::SCHEMA,
    joint::Revolute::SCHEMA,
    joint::Prismatic::SCHEMA,
    joint::Cylindrical::SCHEMA,
    joint::Universal::SCHEMA,
    joint::Planar::SCHEMA,
    joint::Spherical::SCHEMA,
    joint::Free::SCHEMA,
    robot::Link::SCHEMA,
    loops::LoopEnd::SCHEMA,
    loops::Distance::SCHEMA,
    loops::Gear::SCHEMA,
    loops::Loop::SCHEMA,
];
