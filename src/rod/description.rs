//! What a rod is, in plain data: segments in a row, a base, loads and bodies.

use std::f64::consts::TAU;

use super::base::BaseMotion;
use super::basis::Basis;
use super::body::Body;
use super::fluid::Fluid;
use super::load::Load;
use super::piece::{self, Piece};
use super::plan;
use super::profile::Profile;
use super::section::{GivenSection, LARGEST, SMALLEST, Section, SectionProperties, ShearCorrection};
use super::support::Support;
use crate::error::{Checker, InvalidInput, Number};

/// Number of strain components.
pub const STRAINS: usize = 6;

/// Names of the strain components, in their order within a strain: angular first.
pub const STRAIN_NAMES: [&str; STRAINS] = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"];

/// Strain of a straight, unstretched rod along its body x axis.
pub const STRAIGHT: [f64; STRAINS] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];

/// Most modes of one strain component in one segment: beyond, Legendre modes cost conditioning and buy no accuracy.
pub const MAX_MODES: usize = 64;

/// Most quadrature nodes of one segment that can be asked for.
pub const MAX_NODES: usize = 256;

/// Most quadrature nodes that a segment takes by itself, for its reference strain and for long tables: an evaluation takes the square
/// of their number, a million multiplications.
pub const MAX_OWN_NODES: usize = 1024;

/// Most numbers in the integration matrices of a rod, the squares of the numbers of nodes: 1 GiB in two matrices.
const MAX_INTEGRATION: f64 = (1u64 << 26) as f64;

/// Most generalised coordinates of a rod: its dense Jacobian then takes 128 MiB.
pub const MAX_COORDINATES: usize = 4096;

/// A quaternion whose norm is off by more than this is refused as a mistake rather than normalised.
pub const QUATERNION_TOLERANCE: f64 = 1e-3;

/// A piece of rod with one kind of section.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Length in metres.
    pub length: f64,
    /// What it looks like across.
    pub section: Section,
    /// Young's modulus E in pascals; zero, as G and the density, where the section has stiffness and inertia of its own.
    pub young_modulus: f64,
    /// Shear modulus G in pascals.
    pub shear_modulus: f64,
    /// Density in kg/m^3.
    pub density: f64,
    /// Number of modes of each strain component, in the order of [`STRAIN_NAMES`]. Of piecewise constant strains the number of
    /// pieces; of Hermite's cubics twice the number of knots. In these two bases all strains have the same number, or none.
    pub modes: [usize; STRAINS],
    /// What the modes are.
    pub basis: Basis,
    /// Kelvin-Voigt retardation time mu in seconds: damping is mu times stiffness.
    pub retardation_time: f64,
    /// Strain at which the segment is free of stress.
    pub reference_strain: Profile<STRAINS>,
    /// Shear correction factors k of the shear stiffness k G A of a shape; one unless asked for.
    pub shear_correction: ShearCorrection,
    /// Quadrature nodes, rounded up to a multiple of four; `None` takes what the modes need for bends up to about half a
    /// turn (`docs/rod.md`).
    pub nodes: Option<usize>,
}

impl Segment {
    /// A straight elastic segment of constant radius, without modes: a start for `..` syntax.
    pub fn straight(length: f64, radius: f64, young_modulus: f64, shear_modulus: f64, density: f64) -> Self {
        Self {
            length,
            section: Section::circle([radius; 2]),
            young_modulus,
            shear_modulus,
            density,
            modes: [0; STRAINS],
            basis: Basis::Legendre,
            retardation_time: 0.0,
            reference_strain: STRAIGHT.into(),
            shear_correction: 1.0.into(),
            nodes: None,
        }
    }

    /// A straight segment with a given section, without modes: a start for `..` syntax.
    pub fn given(length: f64, section: GivenSection) -> Self {
        let section = Section::Given(Box::new(section));
        Self { section, ..Self::straight(length, 0.0, 0.0, 0.0, 0.0) }
    }

    /// Its mass times how far the centres of its sections lie from its axis, in their axes.
    pub(super) fn mass_offset(&self) -> [f64; 3] {
        match &self.section {
            Section::Shape(_) => [0.0; 3],
            Section::Given(given) => {
                let [y, z] = given.first_moment().map(|moment| moment * self.length);
                [0.0, y, z]
            }
        }
    }

    /// Poisson's ratio of an isotropic material, E / (2 G) - 1.
    pub(super) fn poisson_ratio(&self) -> f64 {
        self.young_modulus / (2.0 * self.shear_modulus) - 1.0
    }

    /// Number of generalised coordinates of this segment.
    pub fn coordinates(&self) -> usize {
        self.modes.iter().sum()
    }

    /// Everything that is wrong with this segment.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.positive(self.length, "length", "metres");
        self.section.check(&mut check, self.length, &self.modes);
        self.check_material(&mut check);
        for (modes, name) in self.modes.iter().zip(STRAIN_NAMES) {
            check.require(
                *modes <= MAX_MODES,
                &format!("modes.{name}"),
                modes,
                &format!("at most {MAX_MODES} modes"),
            );
        }
        self.check_basis(&mut check);
        check.non_negative(self.retardation_time, "retardation_time", "seconds");
        self.check_reference_strain(&mut check);
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
        let expected = format!("a length between {SMALLEST:e} and {LARGEST:e} metres");
        check.require((SMALLEST..=LARGEST).contains(&self.length), "length", Number(self.length), &expected);
    }

    /// Refuses what would take more quadrature nodes than [`MAX_OWN_NODES`].
    fn check_nodes(&self, check: &mut Checker) {
        let needed = |piece: &Piece| if self.nodes.is_some() { 0.0 } else { plan::number_of_nodes(piece) };
        let by_nodes = |a: &Piece, b: &Piece| needed(a).total_cmp(&needed(b));
        let Some(piece) = piece::of(self).max_by(by_nodes) else { return };
        let (nodes, most) = (needed(&piece), MAX_OWN_NODES as f64);
        if nodes <= most {
            return;
        }
        let turns = Number((plan::turn(&piece) / TAU).round());
        let (place, found) = if plan::nodes_for_turns(&piece) >= 0.5 * nodes {
            ("reference_strain", format!("{turns} turns of one segment, which take {} nodes", Number(nodes)))
        } else {
            ("nodes", format!("none, and long tables that take {} of them", Number(nodes)))
        };
        /// More segments are a slip in a number rather than a way out.
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

    /// Numbers in each of its two integration matrices, the squares of its nodes.
    fn integration(&self) -> f64 {
        let of_piece = |piece: Piece| plan::number_of_nodes(&piece).powi(2);
        piece::of(self).map(of_piece).sum()
    }

    /// The numbers of modes must be those of the basis.
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

    /// The reference strain must be finite and stretch the segment by a positive factor everywhere.
    fn check_reference_strain(&self, check: &mut Checker) {
        /// Where a strain that varies is looked at.
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
        /// E <= 3 G is Poisson's ratio <= 1/2; this much rounding is forgiven, so that 0.5 itself can be written.
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

/// A rod: segments in a row, clamped at its base, with loads and rigid bodies on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Rod {
    /// The segments from base to tip; each continues where the one before ends.
    pub segments: Vec<Segment>,
    /// Position of the base in the world, in metres.
    pub base_position: [f64; 3],
    /// Orientation of the base: quaternion (w, x, y, z) that turns body axes into world axes; normalised on use.
    pub base_orientation: [f64; 4],
    /// How the base moves from there; it rests if `None`.
    pub base_motion: Option<BaseMotion>,
    /// Gravity in the world, in m/s^2.
    pub gravity: [f64; 3],
    /// Dead force at the tip in world axes, in newtons.
    pub tip_force: [f64; 3],
    /// Dead moment at the tip in world axes, in newton metres. A constant spatial moment has no potential.
    pub tip_moment: [f64; 3],
    /// Point mass at the tip, in kilograms.
    pub tip_mass: f64,
    /// Further loads.
    pub loads: Vec<Load>,
    /// Further rigid bodies.
    pub bodies: Vec<Body>,
    /// Springs and dampers to the world.
    pub supports: Vec<Support>,
    /// The fluid around it.
    pub fluid: Option<Fluid>,
}

impl Rod {
    /// A rod at the origin along world x, under standard gravity along -z, without tip loads.
    pub fn new(segments: Vec<Segment>) -> Self {
        Self {
            segments,
            base_position: [0.0; 3],
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            base_motion: None,
            gravity: [0.0, 0.0, -9.81],
            tip_force: [0.0; 3],
            tip_moment: [0.0; 3],
            tip_mass: 0.0,
            loads: Vec::new(),
            bodies: Vec::new(),
            supports: Vec::new(),
            fluid: None,
        }
    }

    /// Number of generalised coordinates.
    pub fn coordinates(&self) -> usize {
        self.segments.iter().map(Segment::coordinates).sum()
    }

    /// All loads, those at the tip that have names of their own included, as far as they are not zero.
    pub(super) fn all_loads(&self) -> impl Iterator<Item = Load> {
        let tip = Load { force: self.tip_force.into(), moment: self.tip_moment.into(), ..Load::at_tip() };
        let is_load = |load: &Load| !load.force.is_zero() || !load.moment.is_zero();
        std::iter::once(tip).chain(self.loads.iter().cloned()).filter(is_load)
    }

    /// All bodies, the mass at the tip included, as far as they are not zero.
    pub(super) fn all_bodies(&self) -> impl Iterator<Item = Body> {
        let is_body = |body: &Body| body.mass != 0.0 || body.inertia != [[0.0; 3]; 3];
        std::iter::once(Body::point(self.tip_mass)).chain(self.bodies.iter().cloned()).filter(is_body)
    }

    /// The same rod with nothing on it but its supports: what it answers to deformation with.
    pub(super) fn unloaded(&self) -> Self {
        let Self { base_position, base_orientation, .. } = *self;
        let supports = self.supports.clone();
        let gravity = [0.0; 3];
        Self { base_position, base_orientation, gravity, supports, ..Self::new(self.segments.clone()) }
    }

    /// Length of the unstretched rod in metres.
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|segment| segment.length).sum()
    }

    /// How far a step from `t` may go that cannot pass over a part of its loads and of the motion of its base unseen
    /// ([`crate::signal::Signal::horizon`]).
    pub fn horizon(&self, t: f64) -> f64 {
        let of_base = self.base_motion.iter().map(|motion| motion.horizon(t));
        self.loads.iter().map(|load| load.horizon(t)).chain(of_base).fold(f64::INFINITY, f64::min)
    }

    /// The shortest period of its loads and of the motion of its base, in seconds; infinite where nothing oscillates.
    pub fn shortest_period(&self) -> f64 {
        let of_base = self.base_motion.iter().map(BaseMotion::period);
        self.loads.iter().map(Load::period).chain(of_base).fold(f64::INFINITY, f64::min)
    }

    /// Whether where the rod is depends on time by itself: its base moves.
    pub fn is_moved(&self) -> bool {
        self.base_motion.as_ref().is_some_and(|motion| !motion.is_constant())
    }

    /// Whether anything of it depends on time by itself.
    pub fn depends_on_time(&self) -> bool {
        self.is_moved() || self.loads.iter().any(Load::varies_in_time)
    }

    /// The first of its loads that is not finite at a time, in words.
    pub(super) fn not_finite(&self, t: f64) -> Option<String> {
        let of_load = |(i, load): (usize, &Load)| {
            let signals = [("force", &load.force), ("moment", &load.moment)];
            let (name, value) = signals.into_iter().find_map(|(name, signal)| {
                let value = signal.at(t).ok()?.into_iter().find(|x| !x.is_finite())?;
                Some((name, value))
            })?;
            Some(format!("loads[{i}].{name} is {value} at t = {}", Number(t)))
        };
        self.loads.iter().enumerate().find_map(of_load)
    }

    /// Everything that is wrong with this rod and its segments.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.require(!self.segments.is_empty(), "segments", "none", "at least one segment");
        for (i, segment) in self.segments.iter().enumerate() {
            check.nested(&format!("segments[{i}]"), segment.validate());
        }
        if check.is_ok() {
            let n = self.coordinates();
            check.require(
                n <= MAX_COORDINATES,
                "segments",
                format_args!("{n} modes in all"),
                &format!("at most {MAX_COORDINATES} modes in all segments together"),
            );
            let numbers: f64 = self.segments.iter().map(Segment::integration).sum();
            check.require(
                numbers <= MAX_INTEGRATION,
                "segments",
                format_args!("{:.1} GB of integration matrices", numbers * 16e-9),
                "fewer quadrature nodes: their square in each segment counts",
            );
        }
        check.finite(&self.base_position, "base_position");
        if check.finite(&self.base_orientation, "base_orientation") {
            let norm = self.base_orientation.iter().map(|x| x * x).sum::<f64>().sqrt();
            check.require(
                (norm - 1.0).abs() <= QUATERNION_TOLERANCE,
                "base_orientation",
                format_args!("a quaternion of norm {norm}"),
                "a quaternion (w, x, y, z) of norm 1",
            );
        }
        if let Some(motion) = &self.base_motion {
            check.nested("base_motion", motion.validate());
        }
        check.finite(&self.gravity, "gravity");
        check.finite(&self.tip_force, "tip_force");
        check.finite(&self.tip_moment, "tip_moment");
        check.non_negative(self.tip_mass, "tip_mass", "kilograms");
        let length = self.length();
        for (i, load) in self.loads.iter().enumerate() {
            check.nested(&format!("loads[{i}]"), load.validate(length));
        }
        for (i, body) in self.bodies.iter().enumerate() {
            check.nested(&format!("bodies[{i}]"), body.validate(length));
        }
        for (i, support) in self.supports.iter().enumerate() {
            check.nested(&format!("supports[{i}]"), support.validate(length));
        }
        if let Some(fluid) = &self.fluid {
            check.nested("fluid", fluid.validate());
            let given = self.segments.iter().position(|segment| matches!(segment.section, Section::Given(_)));
            check.require(
                given.is_none(),
                "fluid",
                format_args!("a fluid around segments[{}], whose section is given", given.unwrap_or(0)),
                "sections with an outline that a fluid can flow around",
            );
        }
        check.finish()
    }
}
