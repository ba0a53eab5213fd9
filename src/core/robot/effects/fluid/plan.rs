//! The compiled fluid around rods and bodies.

use crate::numerics::lie::Geometry;

/// Effects of the fluid in a plan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Immersion {
    pub(crate) has_drag: bool,
    pub(crate) has_added_mass: bool,
}

/// Effects of the fluid on a piece, at the nodes and per length.
#[derive(Clone, Debug)]
pub(crate) struct Immersed<G: Geometry> {
    /// `C_a rho A`.
    pub(crate) added_mass: Vec<G::Pack>,
    pub(crate) drag: Vec<Drag<G::Pack>>,
}

/// Drag per length: viscous `c_n` and `c_t`, quadratic `rho d C_n / 2` and `pi rho d C_t / 2`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drag<T> {
    pub(crate) viscous: [T; 2],
    pub(crate) quadratic: [T; 2],
}

/// Effects of the fluid on a body.
#[derive(Clone, Debug)]
pub(crate) struct Hull<G: Geometry> {
    /// Centre of the volume in section axes.
    pub(crate) centre: G::Vector<f64>,
    /// Mass of the displaced fluid, `rho V`, if buoyancy acts.
    pub(crate) displaced: f64,
    /// `C_a rho V`.
    pub(crate) added_mass: f64,
    /// Drag over velocity.
    pub(crate) viscous: f64,
    /// `rho C_d A / 2`.
    pub(crate) quadratic: f64,
}
