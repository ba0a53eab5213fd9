//! Segments as users describe them.

use super::{Allowable, Segment as Resolved, shear_modulus as shear_modulus_of};
use crate::description::rod::basis::Basis;
use crate::description::rod::profile::{Profile, Size};
use crate::description::rod::section;
use crate::description::rod::section::described::{Circle, Section};
use crate::description::rod::section::{Shape, ShearCorrection};
use crate::description::rod::strain::{STRAIGHT, STRAINS};
use crate::description::schema::{Data, Described, Fault, Field, Kind, Limits, Part as _, Reader, Value};
use crate::error::Checker;

/// Number of modes of each strain. Strains that are not named have no modes and keep their reference values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Described)]
#[part(dict)]
pub struct Modes {
    /// Modes of torsion, about the rod's axis.
    #[part(default = 0)]
    pub torsion: usize,
    /// Modes of bending about the body y axis; positive bending turns the rod towards body -z.
    #[part(default = 0)]
    pub bend_y: usize,
    /// Modes of bending about the body z axis.
    #[part(default = 0)]
    pub bend_z: usize,
    /// Modes of stretch along the rod.
    #[part(default = 0)]
    pub stretch: usize,
    /// Modes of shear along the body y axis.
    #[part(default = 0)]
    pub shear_y: usize,
    /// Modes of shear along the body z axis.
    #[part(default = 0)]
    pub shear_z: usize,
}

impl Modes {
    /// The numbers in the order of the strains.
    pub fn counts(&self) -> [usize; STRAINS] {
        [self.torsion, self.bend_y, self.bend_z, self.stretch, self.shear_y, self.shear_z]
    }
}

impl From<[usize; STRAINS]> for Modes {
    fn from([torsion, bend_y, bend_z, stretch, shear_y, shear_z]: [usize; STRAINS]) -> Self {
        Self { torsion, bend_y, bend_z, stretch, shear_y, shear_z }
    }
}

/// The modes of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeChoice {
    /// They are left to a requested accuracy.
    Open,
    /// These.
    Given(Modes),
}

impl ModeChoice {
    /// Modes of open segments until they are chosen.
    const UNTIL_CHOSEN: [usize; STRAINS] = [0, 1, 1, 0, 0, 0];

    fn counts(&self) -> [usize; STRAINS] {
        if let Self::Given(modes) = self { modes.counts() } else { Self::UNTIL_CHOSEN }
    }
}

impl Data for ModeChoice {
    const KIND: Kind = Kind::Open(&Modes::KIND);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        const WORDS: Kind = Kind::Word("ModeChoice", &[Kind::OPEN]);
        match value {
            Value::Text(_) => reader.word(&WORDS, value).map(|_| Self::Open),
            Value::Table(_) | Value::Part(_) => Modes::read(value, reader).map(Self::Given),
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        match self {
            Self::Open => Value::Text(Kind::OPEN.to_owned()),
            Self::Given(modes) => modes.write(),
        }
    }
}

impl Data for ShearCorrection {
    const KIND: Kind =
        Kind::OneOf("ShearCorrection", &[Kind::OneOrEach(2), Kind::Word("ShearRule", &["cowper"])]);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        const RULE: Kind = Kind::Word("ShearRule", &["cowper"]);
        match value {
            Value::Number(_) | Value::Integer(_) => f64::read(value, reader).map(Into::into),
            Value::List(_) => <[f64; 2]>::read(value, reader).map(Self::Factors),
            Value::Text(_) => reader.word(&RULE, value).map(|_| Self::Cowper),
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        match self {
            Self::Factors([y, z]) if y.to_bits() == z.to_bits() => y.check(limits, reader),
            Self::Factors(factors) => factors.check(limits, reader),
            Self::Cowper => {}
        }
    }

    fn write(&self) -> Value {
        match self {
            Self::Factors([y, z]) if y == z => y.write(),
            Self::Factors(factors) => factors.write(),
            Self::Cowper => Value::Text("cowper".to_owned()),
        }
    }
}

/// A segment of a rod with one kind of section and one material: a radius or another shape with its material, or a section
/// of given stiffness and inertia, which needs no material.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(base = "_Segment", positional = 10, brief, some_of = &["radius", "section"], called = "a segment",
       derived = Segment::derived, complete = Segment::complete, check = Segment::fits)]
pub struct Segment {
    /// Length.
    #[part(unit = "metres", positive)]
    pub length: f64,
    /// Radius of a circular section: a number, a pair of radii at the segment's base and tip, or a function of the arc
    /// length X from the segment's base as a table, or in Python a callable or a `Profile`. Give either `radius` or `section`.
    #[part(unit = "metres", positive)]
    pub radius: Option<Size>,
    /// Modulus of elasticity E, Young's modulus. Required unless the section is of kind 'given'.
    #[part(unit = "pascals", positive)]
    pub young_modulus: Option<f64>,
    /// Shear modulus G. Poisson's ratio E/(2G) - 1 has to be in (-1, 0.5]. Required, or `poisson_ratio`, unless the section
    /// is of kind 'given'.
    #[part(unit = "pascals", positive)]
    pub shear_modulus: Option<f64>,
    /// Density. Required unless the section is of kind 'given'.
    #[part(unit = "kg/m^3", positive)]
    pub density: Option<f64>,
    /// Number of modes of each strain. Its keys are "torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"; strains
    /// that are not named have no modes and keep their reference values. "auto" leaves them to an accuracy: scenes choose them for the
    /// rtol of their simulation when they are read, in Python `statics`, `modes`, `simulate` with method "auto", and `choose_modes`.
    #[part(always)]
    pub modes: Option<ModeChoice>,
    /// Retardation time of Kelvin-Voigt damping. The damping matrix is this time multiplied by the stiffness matrix.
    #[part(unit = "seconds", non_negative, default = 0.0)]
    pub retardation_time: f64,
    /// Stress-free strain: torsion, bend_y, bend_z (radians per metre), stretch, shear_y, shear_z. To vary it along the
    /// segment, give a table of stations (arc lengths from 0 to `length`, metres) and values, shape (m, 6), which is
    /// interpolated without overshoot; or in Python a callable of the arc length from the segment's base or a `Profile`.
    #[part(default = Profile::from(STRAIGHT))]
    pub reference_strain: Profile<6>,
    /// Shear correction factor. One number, two numbers for shear along y and along z, or 'cowper' for the factors of Cowper
    /// (1966), which depend on the shape of the section and Poisson's ratio.
    #[part(unit = "1 unless the section asks for less", positive, default = ShearCorrection::from(1.0))]
    pub shear_correction: ShearCorrection,
    /// Number of quadrature nodes, rounded up to a multiple of four. The default is accurate for bending up to about half a
    /// turn.
    pub nodes: Option<usize>,
    /// Shape functions of the modes, with x = X / length: Legendre or Chebyshev polynomials of 2 x - 1; powers of x; constants
    /// on equal pieces; or Hermite cubics on equally spaced knots, with two modes per knot for value and slope (times the
    /// knot spacing). With the last two, all strains that have modes have the same number.
    #[part(default = Basis::Legendre)]
    pub basis: Basis,
    /// Section of another shape, or with given stiffness and inertia.
    #[part(always)]
    pub section: Option<Section>,
    /// Poisson's ratio nu in (-1, 0.5], instead of the shear modulus: G = E/(2 (1 + nu)). Then the shear modulus follows Young's
    /// modulus where that is swept, fitted or differentiated with respect to.
    pub poisson_ratio: Option<f64>,
    /// Magnetisation of the material in the axes of the section; takes the same forms as `reference_strain`. It acts on the area
    /// of the unstretched section, in the field and beside the magnets of a `Robot`.
    #[part(unit = "A/m", default = Profile::from([0.0; 3]))]
    pub magnetisation: Profile<3>,
    /// Smallest radius to which the axis may be bent, as data sheets of cables and hoses state it. It changes no
    /// motion; reports and `peaks` of results say where it is exceeded.
    #[part(unit = "metres", positive)]
    pub min_bend_radius: Option<f64>,
    /// Largest allowable strain along the rod in the outermost fibre, as `min_bend_radius` for reports alone. Not for a section
    /// of kind 'given'.
    #[part(positive)]
    pub max_strain: Option<f64>,
    /// Largest allowable stress along the rod in the outermost fibre, as `min_bend_radius` for reports alone. Not for a section
    /// of kind 'given'.
    #[part(unit = "pascals", positive)]
    pub max_stress: Option<f64>,
}

impl Segment {
    /// A circle is its radius. A section of tables runs along the segment.
    fn complete(&mut self) {
        let length = self.length;
        match &self.section {
            Some(Section::Circle(Circle { radius, length: over }))
                if self.radius.is_none() && over.is_none_or(|over| over == length) =>
            {
                self.radius = Some(radius.clone());
                self.section = None;
            }
            Some(section) if section.length().is_none() => {
                self.section = Some(section.resolved().described(length));
            }
            _ => {}
        }
    }

    fn fits(&self, reader: &mut Reader) {
        let Self { length, radius, section, young_modulus, shear_modulus, poisson_ratio, .. } = self;
        reader.check_exclusive(["radius", "section"], radius, section);
        if let Some(over) = section.as_ref().and_then(Section::length) {
            let expected = format!("one for the segment's length, {length} m");
            reader.require(over == *length, "section", format_args!("one for {over} m"), &expected);
        }
        if let Some(Section::Given(_)) = section {
            let has_all = "a given section has all that it needs";
            for (key, value) in [
                ("young_modulus", young_modulus),
                ("shear_modulus", shear_modulus),
                ("poisson_ratio", poisson_ratio),
                ("density", &self.density),
            ] {
                reader.check_unused(key, *value, has_all);
            }
            let is_default = self.shear_correction == ShearCorrection::from(1.0);
            let correction = Some(self.shear_correction.write()).filter(|_| !is_default);
            let complete = "the stiffness of a given section is complete";
            reader.check_unused("shear_correction", correction, complete);
            let is_magnetic = self.magnetisation.constant() != Some([0.0; 3]);
            let magnetisation = Some(self.magnetisation.write()).filter(|_| is_magnetic);
            reader.check_unused("magnetisation", magnetisation, "a given section has no area");
            for (key, limit) in [("max_strain", self.max_strain), ("max_stress", self.max_stress)] {
                reader.check_unused(key, limit, "a given section has no outermost fibre");
            }
        } else {
            let expected = "a number, unless the section is given";
            self.check_there(reader, "young_modulus", young_modulus.is_some(), expected);
            match (shear_modulus, poisson_ratio) {
                (Some(_), Some(_)) => {
                    reader.refuse("poisson_ratio", Fault::Both(["poisson_ratio", "shear_modulus"]));
                }
                (None, None) if reader.is_complete() => {
                    reader.refuse("", Fault::NoneOf(&["shear_modulus", "poisson_ratio"]));
                }
                _ => {}
            }
            self.check_there(reader, "density", self.density.is_some(), expected);
        }
        self.check_there(reader, "modes", self.modes.is_some(), "a dict such as {'bend_y': 3}");
        let mut check = Checker::new();
        if let (Some(ratio), None) = (poisson_ratio, shear_modulus) {
            check.all(shear_modulus_of(1.0, *ratio).map(|_| ()));
        }
        check.all(self.resolved().validate());
        reader.nested(check);
    }

    /// Reports that a field is not given.
    fn check_there(&self, reader: &mut Reader, key: &'static str, is_there: bool, expected: &'static str) {
        if !is_there && reader.is_complete() {
            let field = Self::SCHEMA.index(key).map(|i| &Self::SCHEMA.fields[i]);
            let meaning = field.map_or_else(String::new, Field::summary);
            reader.refuse(key, Fault::Absent { key, meaning, expected });
        }
    }

    /// The segment of a rod; what is missing fits to what there is.
    pub fn resolved(&self) -> Resolved {
        const STAND_IN: f64 = 1.0;
        let section = match (&self.radius, &self.section) {
            (Some(Size(radius)), _) => section::Section::Shape(Shape::Circle { radius: radius.clone() }),
            (None, Some(section)) => section.resolved(),
            (None, None) => section::Section::circle([STAND_IN; 2]),
        };
        let is_given = matches!(section, section::Section::Given(_));
        let [young_modulus, shear_modulus, density] = if is_given {
            [0.0; 3]
        } else {
            // A wrong modulus is reported by itself.
            let modulus = self.young_modulus.filter(|modulus| modulus.is_finite() && *modulus > 0.0);
            let modulus = modulus.or(self.shear_modulus).unwrap_or(STAND_IN);
            let of_ratio = || shear_modulus_of(modulus, self.poisson_ratio?).ok();
            let shear_modulus = match self.poisson_ratio {
                Some(_) if self.shear_modulus.is_some() => modulus,
                _ => self.shear_modulus.or_else(of_ratio).unwrap_or(modulus),
            };
            [self.young_modulus.unwrap_or(shear_modulus), shear_modulus, self.density.unwrap_or(STAND_IN)]
        };
        Resolved {
            length: self.length,
            section,
            young_modulus,
            shear_modulus,
            given_poisson_ratio: self.poisson_ratio.filter(|_| !is_given),
            density,
            modes: self.modes.as_ref().map_or([0; STRAINS], ModeChoice::counts),
            modes_are_open: self.modes == Some(ModeChoice::Open),
            basis: self.basis,
            retardation_time: self.retardation_time,
            reference_strain: self.reference_strain.clone(),
            magnetisation: self.magnetisation.clone(),
            shear_correction: if is_given { 1.0.into() } else { self.shear_correction },
            nodes: self.nodes,
            allowable: Allowable {
                bend_radius: self.min_bend_radius,
                strain: self.max_strain,
                stress: self.max_stress,
            },
        }
    }

    /// The value of a field that is not given: the section from the radius, or an elastic constant from the others.
    fn derived(&self, key: &str) -> Value {
        let is_given = matches!(self.section, Some(Section::Given(_)));
        match (key, &self.radius) {
            ("section", Some(radius)) => {
                let circle = section::Section::Shape(Shape::Circle { radius: radius.0.clone() });
                circle.described(self.length).write()
            }
            ("shear_modulus", _) if !is_given => self.resolved().shear_modulus.write(),
            ("poisson_ratio", _) if !is_given => self.resolved().poisson_ratio().write(),
            _ => Value::None,
        }
    }
}

impl Resolved {
    /// The description of this segment.
    pub fn described(&self) -> Segment {
        let is_given = matches!(self.section, section::Section::Given(_));
        let of_material = |value: f64| (!is_given).then_some(value);
        let mut described = Segment {
            length: self.length,
            radius: None,
            young_modulus: of_material(self.young_modulus),
            shear_modulus: of_material(self.shear_modulus).filter(|_| self.given_poisson_ratio.is_none()),
            density: of_material(self.density),
            modes: Some(match self.modes_are_open {
                true => ModeChoice::Open,
                false => ModeChoice::Given(self.modes.into()),
            }),
            retardation_time: self.retardation_time,
            reference_strain: self.reference_strain.clone(),
            shear_correction: self.shear_correction,
            nodes: self.nodes,
            basis: self.basis,
            section: Some(self.section.described(self.length)),
            poisson_ratio: self.given_poisson_ratio,
            magnetisation: self.magnetisation.clone(),
            min_bend_radius: self.allowable.bend_radius,
            max_strain: self.allowable.strain,
            max_stress: self.allowable.stress,
        };
        described.complete();
        described
    }
}
