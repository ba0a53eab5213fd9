//! Sections of segments.

use super::document::{
    Inertia, Section, SectionKind, Segment, ShearCorrection, ShearRule, Size, SizeTable, Stiffness,
};
use super::shape::{Shape, report};
use crate::rod;

/// The section of the segment at `here`; a stand-in after reporting a problem.
pub(super) fn section(written: &Segment, here: &str, shape: &mut Shape) -> rod::Section {
    let [radius, table] = ["radius", "section"].map(|key| format!("{here}.{key}"));
    match (&written.radius, &written.section) {
        (Some(_), Some(_)) => {
            shape.refuse(&table, "both radius and section are given", "keep one of them");
            shape.replaced.insert(radius);
            shape.replaced.insert(table);
            stand_in()
        }
        (Some(written), None) => {
            rod::Section::Shape(rod::Shape::Circle { radius: size(written, &radius, shape) })
        }
        (None, Some(section)) => of_table(section, &table, shape),
        (None, None) => {
            if shape.is_readable(&radius) && shape.is_readable(&table) {
                shape.refuse(here, "neither radius nor section", "add one of them");
                shape.replaced.insert(radius);
            }
            stand_in()
        }
    }
}

fn stand_in() -> rod::Section {
    rod::Section::circle([1.0; 2])
}

/// The size written at `place`; one metre after reporting a problem.
fn size(written: &Size, place: &str, shape: &mut Shape) -> rod::Profile<1> {
    match written {
        Size::Constant(size) => (*size).into(),
        Size::Tapered(ends) => rod::Profile::linear(ends.map(|end| [end])),
        Size::Table(_) if !shape.is_readable(place) => 1.0.into(),
        Size::Table(SizeTable { stations, values }) => {
            let values: Vec<[f64; 1]> = values.iter().map(|&value| [value]).collect();
            let table = rod::Profile::table(stations, &values);
            report(table, shape, |problem| format!("{place}.{problem}")).unwrap_or(1.0.into())
        }
    }
}

/// Stand-in for a section that may have given properties, which needs no material.
fn given_stand_in() -> rod::Section {
    rod::Section::Given(Box::new(rod::GivenSection {
        stiffness: rod::diagonal([1.0; 6]).into(),
        mass: 1.0.into(),
        inertia: [0.0; 9].into(),
        centre: [0.0; 2].into(),
    }))
}

/// Reports material constants of a section with given properties.
pub(super) fn refuse_material(written: &Segment, here: &str, shape: &mut Shape) {
    if !shape.is_readable(&format!("{here}.section.shape")) {
        // The kind of section is unknown.
        return;
    }
    let keys = [
        ("young_modulus", written.young_modulus.is_some()),
        ("shear_modulus", written.shear_modulus.is_some()),
        ("poisson_ratio", written.poisson_ratio.is_some()),
        ("density", written.density.is_some()),
        ("shear_correction", written.shear_correction.is_some()),
    ];
    for (key, _) in keys.into_iter().filter(|(_, is_there)| *is_there) {
        let right = "remove it: the section's stiffness and mass are all that is needed";
        shape.refuse(&format!("{here}.{key}"), "a given section does not take it", right);
    }
}

/// Shear correction of a shape.
pub(super) fn shear_correction(written: &Segment) -> rod::ShearCorrection {
    match written.shear_correction {
        None => 1.0.into(),
        Some(ShearCorrection::Factor(factor)) => factor.into(),
        Some(ShearCorrection::Factors(factors)) => rod::ShearCorrection::Factors(factors),
        Some(ShearCorrection::Rule(ShearRule::Cowper)) => rod::ShearCorrection::Cowper,
    }
}

fn of_table(written: &Section, here: &str, shape: &mut Shape) -> rod::Section {
    if !shape.is_readable(&format!("{here}.shape")) {
        // The kind of section is unknown, and hence which of the other keys are valid.
        shape.replaced.insert(here.to_owned());
        return given_stand_in();
    }
    let (name, keys): (_, &[&str]) = match written.shape {
        SectionKind::Circle => ("a circle", &["radius"]),
        SectionKind::HollowCircle => ("a hollow circle", &["outer", "inner"]),
        SectionKind::Rectangle => ("a rectangle", &["width", "height"]),
        SectionKind::Ellipse => ("an ellipse", &["semi_axis_y", "semi_axis_z"]),
        SectionKind::Given => ("a given section", &["stiffness", "mass"]),
    };
    let optional: &[&str] = if written.shape == SectionKind::Given { &["inertia", "centre"] } else { &[] };
    let is_there = [
        ("radius", written.radius.is_some()),
        ("outer", written.outer.is_some()),
        ("inner", written.inner.is_some()),
        ("width", written.width.is_some()),
        ("height", written.height.is_some()),
        ("semi_axis_y", written.semi_axis_y.is_some()),
        ("semi_axis_z", written.semi_axis_z.is_some()),
        ("stiffness", written.stiffness.is_some()),
        ("mass", written.mass.is_some()),
        ("inertia", written.inertia.is_some()),
        ("centre", written.centre.is_some()),
    ];
    let mut is_complete = true;
    for (key, is_there) in is_there {
        let place = format!("{here}.{key}");
        if keys.contains(&key) && !is_there {
            is_complete = false;
            if shape.is_readable(&place) {
                shape.refuse(&place, "missing", format!("{name} takes {}", keys.join(" and ")));
            }
        } else if is_there && !keys.contains(&key) && !optional.contains(&key) {
            let right = format!("{name} takes {}", [keys, optional].concat().join(", "));
            shape.refuse(&place, format!("{name} does not take it"), right);
        }
    }
    if !is_complete {
        shape.replaced.insert(here.to_owned());
        return if written.shape == SectionKind::Given { given_stand_in() } else { stand_in() };
    }
    let mut size = |key: &str, written: &Option<Size>| {
        written.as_ref().map_or(1.0.into(), |written| size(written, &format!("{here}.{key}"), shape))
    };
    rod::Section::Shape(match written.shape {
        SectionKind::Circle => rod::Shape::Circle { radius: size("radius", &written.radius) },
        SectionKind::HollowCircle => rod::Shape::HollowCircle {
            outer: size("outer", &written.outer),
            inner: size("inner", &written.inner),
        },
        SectionKind::Rectangle => rod::Shape::Rectangle {
            width: size("width", &written.width),
            height: size("height", &written.height),
        },
        SectionKind::Ellipse => rod::Shape::Ellipse {
            semi_axis_y: size("semi_axis_y", &written.semi_axis_y),
            semi_axis_z: size("semi_axis_z", &written.semi_axis_z),
        },
        SectionKind::Given => return rod::Section::Given(Box::new(given(written))),
    })
}

fn given(written: &Section) -> rod::GivenSection {
    rod::GivenSection {
        stiffness: match &written.stiffness {
            Some(Stiffness::Full(rows)) => (**rows).into(),
            Some(Stiffness::Diagonal(diagonal)) => rod::diagonal(*diagonal).into(),
            None => [0.0; 36].into(),
        },
        mass: written.mass.unwrap_or(0.0).into(),
        inertia: match written.inertia {
            Some(Inertia::Full(rows)) => rows.into(),
            Some(Inertia::Diagonal(diagonal)) => rod::diagonal(diagonal).into(),
            None => [0.0; 9].into(),
        },
        centre: written.centre.unwrap_or([0.0; 2]).into(),
    }
}
