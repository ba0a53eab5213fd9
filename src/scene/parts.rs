//! Common parts of rods and links: segments, commands, base motions.

use super::described::{Written, read};
use super::document::{
    Basis, Document, ModeChoice, ReferenceStrain, Segment, Simulation as Settings, StrainTable,
};
use super::section;
use super::shape::{Shape, report};
use crate::rod;
use crate::signal::covers;
use crate::world::{self, described::BaseMotion};

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

/// The motion written at `here`; rest after reporting a problem.
pub(super) fn base_motion(
    written: &Written<BaseMotion>,
    here: &str,
    settings: &Settings,
    shape: &mut Shape,
) -> world::BaseMotion {
    let Some(motion) = read(written, here, shape) else { return world::BaseMotion::rest() };
    let motion = motion.resolved();
    check_span(motion.span(), here, settings, shape);
    motion
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
