//! Robots with more or less inertia under the same forces.

use super::Robot;
use crate::description::body::Body;
use crate::description::rod::Section;

impl Robot {
    /// The same robot with `factor` times the inertia and the same weight, buoyancy and drag: every mass times `factor`, gravity
    /// divided by it. Changes only the time scales of inertia, by the root of `factor`.
    pub(crate) fn with_inertia_times(&self, factor: f64) -> Self {
        let mut other = self.clone();
        other.gravity = self.gravity.map(|g| g / factor);
        for segment in other.segments_mut() {
            segment.density *= factor;
            if let Section::Given(given) = &mut segment.section {
                given.mass = given.mass.scaled(factor);
                given.inertia = given.inertia.scaled(factor);
            }
        }
        for link in &mut other.links {
            if let Some(forces) = link.joint.forces_mut() {
                forces.armature *= factor;
            }
        }
        let bodies = other.links.iter_mut().filter_map(|link| link.body.as_mut());
        for Body { mass, inertia, hull, .. } in bodies.chain(&mut other.bodies) {
            *mass *= factor;
            inertia.as_flattened_mut().iter_mut().for_each(|entry| *entry *= factor);
            // Drag counts the density of the fluid.
            hull.iter_mut().for_each(|hull| hull.drag_coefficient /= factor);
        }
        if let Some(fluid) = &mut other.fluid {
            fluid.density *= factor;
            fluid.drag_coefficients = fluid.drag_coefficients.map(|coefficient| coefficient / factor);
        }
        other
    }
}
