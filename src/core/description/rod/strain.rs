//! Strain components of a rod and their order.

/// Number of strain components.
pub const STRAINS: usize = 6;

/// Names of the strain components in order: angular components first.
pub const STRAIN_NAMES: [&str; STRAINS] = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"];

/// Strain of a straight, unstretched rod along its body x axis.
pub const STRAIGHT: [f64; STRAINS] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
