//! Validation of segments.

use std::f64::consts::TAU;

use super::basis::Basis;
use super::piece::Piece;
use super::section::along::{LARGEST, SMALLEST};
use super::section::{Section, SectionProperties, ShearCorrection};
use super::segment::{MAX_MODES, MAX_NODES, MAX_OWN_NODES, Segment};
use super::strain::STRAIN_NAMES;
use super::{nodes, piece};
use crate::error::{Checker, InvalidInput, Number};

impl Segment {
    /// Reports every problem of this segment.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.positive(self.length, "length", "metres");
        self.section.check(&mut check, self.length, &self.modes);
        self.check_material(&mut check);
        for (modes, name) in self.modes.iter().zip(STRAIN_NAMES).filter(|(modes, _)| **modes > MAX_MODES) {
            check.refuse(format!("modes.{name}"), modes, format!("at most {MAX_MODES} modes"));
        }
        self.check_basis(&mut check);
        check.non_negative(self.retardation_time, "retardation_time", "seconds");
        self.check_reference_strain(&mut check);
        for (name, along) in self.of_effects() {
            along.check(&mut check, name, self.length);
            let has_area = matches!(self.section, Section::Shape(_)) || along.is_zero();
            let found = format_args!("{name} of a given section");
            check.require(has_area, name, found, "none: a given section has no area");
        }
        if let Some(nodes) = self.nodes {
            check.require(
                (1..=MAX_NODES).contains(&nodes),
                "nodes",
                nodes,
                &format!("between 1 and {MAX_NODES} quadrature nodes, or none for what the modes need"),
            );
        }
        if check.is_ok() {
            self.check_length(&mut check);
            check.all(SectionProperties::validate(self));
            self.check_nodes(&mut check);
        }
        check.finish()
    }

    fn check_length(&self, check: &mut Checker) {
        if !(SMALLEST..=LARGEST).contains(&self.length) {
            let expected = format!("a length between {SMALLEST:e} and {LARGEST:e} metres");
            check.refuse("length", Number(self.length), expected);
        }
    }

    /// Rejects a segment that would need more quadrature nodes than [`MAX_OWN_NODES`].
    fn check_nodes(&self, check: &mut Checker) {
        let needed = |piece: &Piece| if self.nodes.is_some() { 0.0 } else { nodes::number_of_nodes(piece) };
        let by_nodes = |a: &Piece, b: &Piece| needed(a).total_cmp(&needed(b));
        let Some(piece) = piece::of(self).max_by(by_nodes) else { return };
        let (nodes, most) = (needed(&piece), MAX_OWN_NODES as f64);
        if nodes <= most {
            return;
        }
        let turns = Number((nodes::turn(&piece) / TAU).round());
        let (place, found) = if nodes::nodes_for_turns(&piece) >= 0.5 * nodes {
            ("reference_strain", format!("{turns} turns of one segment, which take {} nodes", Number(nodes)))
        } else {
            ("nodes", format!("none, and long tables that take {} of them", Number(nodes)))
        };
        /// If more segments than this were needed, a number is probably wrong.
        const SENSIBLE: f64 = 1000.0;
        let segments = (nodes / most).ceil();
        let instead = if segments <= SENSIBLE {
            format!("divide the segment into at least {segments}, or give `nodes`")
        } else {
            "check the numbers".to_owned()
        };
        let expected = format!("at most {MAX_OWN_NODES} quadrature nodes: {instead}");
        check.require(false, place, found, &expected);
    }

    /// Number of entries of each of its two integration matrices: the square of the number of nodes.
    pub(crate) fn integration(&self) -> f64 {
        let of_piece = |piece: Piece| nodes::number_of_nodes(&piece).powi(2);
        piece::of(self).map(of_piece).sum()
    }

    /// The numbers of modes must match the basis.
    fn check_basis(&self, check: &mut Checker) {
        if self.basis.is_nested() {
            return;
        }
        let present: Vec<(usize, &str)> =
            self.modes.into_iter().zip(STRAIN_NAMES).filter(|(modes, _)| *modes > 0).collect();
        if let [(first, first_name), others @ ..] = &present[..] {
            if self.basis == Basis::Hermite {
                let expected = "an even number of Hermite modes: value and slope at each knot";
                check.require(first % 2 == 0, &format!("modes.{first_name}"), first, expected);
            }
            for (modes, name) in others {
                let expected = format!(
                    "{first} as modes.{first_name} has, or none: strains of the basis \"{}\" share their {}",
                    self.basis.name(),
                    if self.basis == Basis::Hermite { "knots" } else { "pieces" }
                );
                check.require(modes == first, &format!("modes.{name}"), modes, &expected);
            }
        }
    }

    /// The reference strain must be finite, with a positive stretch everywhere.
    fn check_reference_strain(&self, check: &mut Checker) {
        /// Number of sample points of a varying strain.
        const PLACES: usize = 256;
        const EXPECTED: &str = "a stretch > 0 (1 for an unstretched rod)";
        if let Some(strain) = self.reference_strain.constant() {
            if check.finite(&strain, "reference_strain") {
                check.require(strain[3] > 0.0, "reference_strain[3]", strain[3], EXPECTED);
            }
        } else if check.nested("reference_strain", self.reference_strain.validate(self.length)).is_some() {
            let places = (0..=PLACES).map(|i| i as f64 / PLACES as f64);
            let stretches = places.map(|x| (x, self.reference_strain.at(x)[3]));
            let (x, smallest) = stretches.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.0, 1.0));
            let found = format_args!("{smallest} at X = {}", x * self.length).to_string();
            check.require(smallest > 0.0, "reference_strain[3]", found, EXPECTED);
        }
    }

    fn check_material(&self, check: &mut Checker) {
        /// E <= 3 G is equivalent to Poisson's ratio <= 1/2; tolerate rounding, so that 0.5 itself is valid.
        const POISSON_ROUNDING: f64 = 1e-9;
        if let Section::Given(_) = self.section {
            let moduli = [
                (self.young_modulus, "young_modulus"),
                (self.shear_modulus, "shear_modulus"),
                (self.density, "density"),
            ];
            for (value, name) in moduli {
                check.require(value == 0.0, name, value, "nothing: a given section has all that it needs");
            }
            check.require(
                self.shear_correction == ShearCorrection::from(1.0),
                "shear_correction",
                format_args!("{:?}", self.shear_correction),
                "nothing: the stiffness of a given section is complete",
            );
            return;
        }
        let young = check.positive(self.young_modulus, "young_modulus", "pascals");
        let shear = check.positive(self.shear_modulus, "shear_modulus", "pascals");
        if young && shear {
            let poisson = self.poisson_ratio();
            check.require(
                poisson <= 0.5 + POISSON_ROUNDING,
                "shear_modulus",
                format_args!("{} (Poisson's ratio E/(2G) - 1 = {poisson:.4})", self.shear_modulus),
                "a shear modulus with Poisson's ratio in (-1, 0.5], as isotropic materials have; others are described \
                 by a given section",
            );
        }
        check.positive(self.density, "density", "kg/m^3");
        if let ShearCorrection::Factors([y, z]) = self.shear_correction {
            let unit = "1 unless the section asks for less";
            if y.to_bits() == z.to_bits() {
                check.positive(y, "shear_correction", unit);
            } else {
                check.positive(y, "shear_correction[0]", unit);
                check.positive(z, "shear_correction[1]", unit);
            }
        }
    }
}
