//! The strains of a rod, in their order.

/// Number of strain components.
pub const STRAINS: usize = 6;

/// Names of the strain components, in their order within a strain: angular first.
pub const STRAIN_NAMES: [&str; STRAINS] = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"];

/// Strain of a straight, unstretched rod along its body x axis.
pub const STRAIGHT: [f64; STRAINS] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
