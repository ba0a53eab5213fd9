//! Common parts of rods and links: segments, loads, supports, fluids, base motions.

use std::sync::Arc;

use super::document::{
    BaseMotion, Basis, Command, Document, Fluid, Frame, Interpolation, Load, ModeChoice, Orientations,
    ReferenceStrain, Segment, Simulation as Settings, StrainTable, Support, VaryingCommand, VaryingLoad,
    VaryingNumber, VaryingVector, Vector,
};
use super::section;
use super::shape::{Shape, report};
use crate::body;
use crate::error::Checker;
use crate::load;
use crate::rod;
use crate::signal::{self, Harmonic, Input, Signal, Table, covers};
use crate::support;
use crate::world;

/// Modes of the model's open segments until they are chosen.
const UNTIL_CHOSEN: [usize; 6] = [0, 1, 1, 0, 0, 0];

/// All segments with their keys, link by link.
pub(super) fn segments(document: &Document) -> Vec<(String, &Segment)> {
    let of_rod = document.rod.first().into_iter().flat_map(|rod| {
        rod.segment.iter().enumerate().map(|(i, segment)| (format!("rod[0].segment[{i}]"), segment))
    });
    let of_links = document.link.iter().enumerate().flat_map(|(l, link)| {
        let segments = link.rod.iter().flat_map(|rod| &rod.segment).enumerate();
        segments.map(move |(i, segment)| (format!("link[{l}].rod.segment[{i}]"), segment))
    });
    of_rod.chain(of_links).collect()
}

/// Indices of segments with open modes, counted link by link.
pub(super) fn open_modes(document: &Document) -> Vec<usize> {
    let is_open = |segment: &Segment| matches!(segment.modes, ModeChoice::Open(_));
    let segments = segments(document).into_iter().enumerate();
    segments.filter(|(_, (_, segment))| is_open(segment)).map(|(i, _)| i).collect()
}

pub(super) fn segment(written: &Segment, here: &str, shape: &mut Shape) -> rod::Segment {
    let section = section::section(written, here, shape);
    let plain = match section {
        rod::Section::Given(section) => {
            section::refuse_material(written, here, shape);
            rod::Segment::given(written.length, *section)
        }
        section => {
            let [young_modulus, shear_modulus, density] = material(written, here, shape);
            let plain = rod::Segment::straight(written.length, 0.0, young_modulus, shear_modulus, density);
            rod::Segment {
                section,
                shear_correction: section::shear_correction(written),
                given_poisson_ratio: written.poisson_ratio,
                ..plain
            }
        }
    };
    let key = format!("{here}.reference_strain");
    let reference_strain = match &written.reference_strain {
        None => None,
        Some(ReferenceStrain::Constant(strain)) => Some((*strain).into()),
        Some(ReferenceStrain::Table(_)) if !shape.is_readable(&key) => None,
        Some(ReferenceStrain::Table(StrainTable { stations, values })) => {
            report(rod::Profile::table(stations, values), shape, |place| format!("{key}.{place}"))
        }
    };
    rod::Segment {
        basis: basis(written.basis),
        modes: match written.modes {
            ModeChoice::Open(_) => UNTIL_CHOSEN,
            ModeChoice::Given(modes) => modes.counts(),
        },
        retardation_time: written.retardation_time,
        reference_strain: reference_strain.unwrap_or(plain.reference_strain),
        nodes: written.nodes,
        ..plain
    }
}

/// Young's modulus, shear modulus and density. An unknown value is replaced by one that fits the others, to
/// avoid consequential problems.
fn material(written: &Segment, here: &str, shape: &mut Shape) -> [f64; 3] {
    const STAND_IN: f64 = 1.0;
    let place = |key: &str| format!("{here}.{key}");
    let [young, shear, poisson, density] =
        ["young_modulus", "shear_modulus", "poisson_ratio", "density"].map(place);
    for (value, key, what) in [
        (written.young_modulus, &young, "young_modulus: Young's modulus E in pascals"),
        (written.density, &density, "density: Density in kg/m^3"),
    ] {
        if value.is_none() && shape.is_readable(key) {
            shape.refuse(key, "missing", format!("add {what}"));
            shape.replaced.insert(key.clone());
        }
    }
    // A wrong modulus is reported once, by its own key.
    let modulus = written.young_modulus.filter(|modulus| modulus.is_finite() && *modulus > 0.0);
    let modulus = modulus.or(written.shear_modulus).unwrap_or(STAND_IN);
    let shear_modulus = match (written.shear_modulus, written.poisson_ratio) {
        (Some(_), Some(_)) => {
            shape.refuse(&poisson, "both poisson_ratio and shear_modulus are given", "keep one of them");
            modulus
        }
        (Some(modulus), None) => modulus,
        (None, Some(ratio)) => {
            report(rod::shear_modulus(modulus, ratio), shape, |_| poisson.clone()).unwrap_or(modulus)
        }
        (None, None) => {
            if shape.is_readable(&shear) && shape.is_readable(&poisson) {
                shape.refuse(here, "neither shear_modulus nor poisson_ratio", "add one of them");
            }
            modulus
        }
    };
    [written.young_modulus.unwrap_or(shear_modulus), shear_modulus, written.density.unwrap_or(STAND_IN)]
}

fn basis(written: Basis) -> rod::Basis {
    match written {
        Basis::Legendre => rod::Basis::Legendre,
        Basis::Chebyshev => rod::Basis::Chebyshev,
        Basis::Monomial => rod::Basis::Monomial,
        Basis::PiecewiseConstant => rod::Basis::PiecewiseConstant,
        Basis::Hermite => rod::Basis::Hermite,
    }
}

pub(super) fn load(written: &Load, place: &str, shape: &mut Shape) -> load::Load {
    let &Load { ref force, ref moment, at, along, frame } = written;
    if at.is_some() && along.is_some() {
        shape.refuse(&format!("{place}.along"), "both at and along are given", "keep one of them");
    }
    let [force, moment] = [("force", force), ("moment", moment)]
        .map(|(key, written)| vector(written, &format!("{place}.{key}"), shape));
    if force.is_zero() && moment.is_zero() && shape.is_readable(place) {
        shape.refuse(place, "neither force nor moment", "add one of them");
    }
    let extent = match (at, along) {
        (Some(x), _) => load::Extent::At(x),
        (None, Some(ends)) => load::Extent::Along(ends),
        (None, None) => load::Extent::Tip,
    };
    let frame = match frame {
        Frame::World => load::Frame::World,
        Frame::Body => load::Frame::Body,
    };
    load::Load { link: 0, extent, frame, force, moment }
}

/// The vector written at `place`.
fn vector(written: &Vector, place: &str, shape: &mut Shape) -> Signal<3> {
    match written {
        Vector::Constant(value) => Signal::Constant(*value),
        Vector::Varying(written) => {
            let VaryingLoad { times, values, amplitude, frequency, phase, mean, rate, input, default } =
                (**written).clone();
            let parts = Parts { times, values, interpolation: None, amplitude, frequency, phase, mean, rate };
            set_or_varying(input, default, parts, place, shape)
        }
    }
}

/// The command of an actuator written at `place`.
pub(super) fn command(written: &Command, place: &str, shape: &mut Shape) -> Signal<1> {
    match written {
        Command::Constant(value) => Signal::Constant([*value]),
        Command::Varying(written) => {
            let VaryingCommand { times, values, amplitude, frequency, phase, mean, rate, input, default } =
                written.clone();
            let parts = Parts::numbers(times, values, [amplitude, mean, rate], frequency, phase);
            set_or_varying(input, default.map(|default| [default]), parts, place, shape)
        }
    }
}

/// An input, or a function of time.
fn set_or_varying<const N: usize>(
    input: Option<String>,
    default: Option<[f64; N]>,
    parts: Parts<N>,
    place: &str,
    shape: &mut Shape,
) -> Signal<N> {
    let key = |key: &str| format!("{place}.{key}");
    let Some(name) = input else {
        if default.is_some() && shape.is_readable(&key("input")) {
            shape.refuse(&key("default"), "a default without input", "add input = \"name\", or remove it");
        }
        return parts.signal(place, shape);
    };
    if parts.are_there() {
        let right = "keep either input and default, or what varies in time";
        shape.refuse(place, "both an input and a function of time", right);
    }
    if name.is_empty() {
        shape.refuse(&key("input"), "got \"\"", "expected a name");
    }
    let value = default.unwrap_or([0.0; N]);
    let mut check = Checker::new();
    check.finite(&value, "default");
    report(check.finish(), shape, |problem| {
        // A single number has no index in the file.
        format!("{place}.{}", if N == 1 { "default" } else { problem })
    });
    Signal::Input(Input { name: name.into(), value })
}

fn varying_vector(written: &VaryingVector, place: &str, shape: &mut Shape) -> Signal<3> {
    let VaryingVector { times, values, interpolation, amplitude, frequency, phase, mean, rate } =
        written.clone();
    let interpolation = interpolation.map(Interpolation::of_table);
    let parts = Parts { times, values, interpolation, amplitude, frequency, phase, mean, rate };
    parts.signal(place, shape)
}

pub(super) fn varying_number(written: &VaryingNumber, place: &str, shape: &mut Shape) -> Signal<1> {
    let VaryingNumber { times, values, interpolation, amplitude, frequency, phase, mean, rate } =
        written.clone();
    let parts = Parts::numbers(times, values, [amplitude, mean, rate], frequency, phase);
    Parts { interpolation: interpolation.map(Interpolation::of_table), ..parts }.signal(place, shape)
}

/// Keys of a function of time of N numbers.
struct Parts<const N: usize> {
    times: Option<Vec<f64>>,
    values: Option<Vec<[f64; N]>>,
    interpolation: Option<signal::Interpolation>,
    amplitude: Option<[f64; N]>,
    frequency: Option<f64>,
    phase: Option<f64>,
    mean: Option<[f64; N]>,
    rate: Option<[f64; N]>,
}

impl Parts<1> {
    fn numbers(
        times: Option<Vec<f64>>,
        values: Option<Vec<f64>>,
        formula: [Option<f64>; 3],
        frequency: Option<f64>,
        phase: Option<f64>,
    ) -> Self {
        let values = values.map(|values| values.into_iter().map(|x| [x]).collect());
        let [amplitude, mean, rate] = formula.map(|part| part.map(|x| [x]));
        Self { times, values, interpolation: None, amplitude, frequency, phase, mean, rate }
    }
}

impl<const N: usize> Parts<N> {
    fn is_harmonic(&self) -> bool {
        self.frequency.is_some()
            || self.phase.is_some()
            || [self.amplitude, self.mean, self.rate].iter().any(Option::is_some)
    }

    fn are_there(&self) -> bool {
        self.times.is_some() || self.values.is_some() || self.is_harmonic()
    }

    /// The signal; a placeholder if the text is invalid.
    fn signal(self, place: &str, shape: &mut Shape) -> Signal<N> {
        let is_harmonic = self.is_harmonic();
        let Self { times, values, interpolation, amplitude, frequency, phase, mean, rate } = self;
        let is_table = times.is_some() || values.is_some();
        if is_table && is_harmonic {
            let right = "keep either times and values, or amplitude, frequency, phase, mean and rate";
            shape.refuse(place, "both a table and a formula", right);
        } else if !is_table && !is_harmonic && shape.is_readable(place) {
            let right = "add times and values, or amplitude and frequency";
            shape.refuse(place, "nothing that varies in time", right);
        }
        if interpolation.is_some() && !is_table {
            let right = "remove it: only times and values are interpolated";
            shape.refuse(&format!("{place}.interpolation"), "it belongs to a table", right);
        }
        let none = [0.0; N];
        let harmonic = Harmonic {
            mean: mean.unwrap_or(none),
            rate: rate.unwrap_or(none),
            amplitude: amplitude.unwrap_or(none),
            frequency: frequency.unwrap_or_default(),
            phase: phase.unwrap_or_default(),
        };
        match (times, values) {
            (None, None) => Signal::Harmonic(harmonic),
            (Some(times), Some(values)) => table(times, values, interpolation, place, shape),
            (times, _) => {
                let missing = if times.is_none() { "times" } else { "values" };
                if shape.is_readable(&format!("{place}.{missing}")) {
                    shape.refuse(
                        place,
                        format!("{missing} are missing"),
                        "give times and values, as many of each",
                    );
                }
                Signal::Harmonic(harmonic)
            }
        }
    }
}

/// A table, or a placeholder for an invalid one.
fn table<const N: usize>(
    times: Vec<f64>,
    values: Vec<[f64; N]>,
    interpolation: Option<signal::Interpolation>,
    place: &str,
    shape: &mut Shape,
) -> Signal<N> {
    let table = report(Table::new(times, values), shape, |problem| format!("{place}.{problem}"));
    let interpolated = |table: Table<N>| Signal::Table(Arc::new(table.interpolated(interpolation)));
    table.map_or(Signal::Harmonic(Harmonic::zero()), interpolated)
}

impl Interpolation {
    fn of_table(self) -> signal::Interpolation {
        match self {
            Self::Linear => signal::Interpolation::Linear,
            Self::Monotone => signal::Interpolation::Monotone,
            Self::Cubic => signal::Interpolation::Cubic,
        }
    }
}

pub(super) fn base_motion(
    written: &BaseMotion,
    here: &str,
    settings: &Settings,
    shape: &mut Shape,
) -> world::BaseMotion {
    let place = |key: &str| format!("{here}.{key}");
    let BaseMotion { translation, axis, angle, rotation } = written;
    if rotation.is_some() && (axis.is_some() || angle.is_some()) {
        shape.refuse(&place("rotation"), "both rotation and axis or angle", "keep one of the two ways");
    }
    if axis.is_some() != angle.is_some() {
        let (given, missing) = if axis.is_some() { ("axis", "angle") } else { ("angle", "axis") };
        if shape.is_readable(&place(missing)) {
            shape.refuse(&place(given), format!("{given} without {missing}"), format!("add {missing}"));
        }
    }
    let problems = shape.problems.len();
    let mut motion = world::BaseMotion::rest();
    if let Some(translation) = translation {
        motion.translation = varying_vector(translation, &place("translation"), shape);
    }
    if let (&Some(axis), Some(angle)) = (axis, angle) {
        let angle = varying_number(angle, &place("angle"), shape);
        motion.rotation = world::BaseRotation::About { axis, angle };
    }
    if let Some(Orientations { times, values, interpolation }) = rotation {
        let interpolation = interpolation.map(Interpolation::of_table);
        let quaternions = table(times.clone(), values.clone(), interpolation, &place("rotation"), shape);
        if matches!(quaternions, Signal::Table(_)) {
            motion.rotation = world::BaseRotation::By(quaternions);
        }
    }
    if problems == shape.problems.len() {
        check_span(motion.span(), here, settings, shape);
    }
    motion
}

/// Keys of a body on which the fluid acts.
pub(super) struct WrittenHull {
    pub(super) volume: Option<f64>,
    pub(super) centre: Option<[f64; 3]>,
    pub(super) added_mass_coefficient: Option<f64>,
    pub(super) drag_area: Option<f64>,
    pub(super) drag_coefficient: Option<f64>,
    pub(super) viscous_drag: Option<f64>,
}

pub(super) fn hull(written: WrittenHull) -> Option<body::Hull> {
    let none = body::Hull::none();
    let hull = body::Hull {
        volume: written.volume.unwrap_or(none.volume),
        centre: written.centre,
        added_mass_coefficient: written.added_mass_coefficient.unwrap_or(none.added_mass_coefficient),
        drag_area: written.drag_area.unwrap_or(none.drag_area),
        drag_coefficient: written.drag_coefficient.unwrap_or(none.drag_coefficient),
        viscous_drag: written.viscous_drag.unwrap_or(none.viscous_drag),
    };
    hull.unless_none()
}

/// Reports a motion at `here` that is not defined during the whole run.
pub(super) fn check_span([from, to]: [f64; 2], here: &str, settings: &Settings, shape: &mut Shape) {
    let of_run = ["simulation.t_end", "simulation.t0"];
    let is_known = of_run.iter().all(|key| shape.is_readable(key));
    let (t0, t_end) = (settings.t0, settings.t_end);
    if is_known && !(covers([from, to], t0) && covers([from, to], t_end)) {
        let right = format!("its tables cover the run from {t0} to {t_end} s");
        shape.refuse(here, format!("known from {from} to {to} s"), format!("expected that {right}"));
    }
}

pub(super) fn support(written: &Support) -> support::Support {
    support::Support {
        link: 0,
        at: written.at,
        stiffness: written.stiffness.numbers(),
        rotational_stiffness: written.rotational_stiffness.numbers(),
        damping: written.damping.numbers(),
        rotational_damping: written.rotational_damping.numbers(),
        position: written.position,
        orientation: written.orientation,
    }
}

pub(super) fn fluid(written: &Fluid) -> world::Fluid {
    let default = world::Fluid::ideal(written.density);
    world::Fluid {
        velocity: written.velocity,
        viscous_drag: written.viscous_drag,
        drag_coefficients: written.drag_coefficients,
        added_mass_coefficient: written.added_mass_coefficient.unwrap_or(default.added_mass_coefficient),
        is_buoyant: written.buoyancy.unwrap_or(default.is_buoyant),
        ..default
    }
}

/// Key in the table of a segment for a place in a [`rod::Segment`].
pub(super) fn segment_key(place: &str, written: &Segment) -> String {
    if written.shear_modulus.is_none() && place == "shear_modulus" {
        "poisson_ratio".to_owned()
    } else if written.section.is_some() && place.starts_with("radius") {
        // A circle in a table of its own.
        format!("section.{place}")
    } else {
        place.to_owned()
    }
}
