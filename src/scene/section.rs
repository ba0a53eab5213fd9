//! Sections of segments.

use super::described::{Written, read};
use super::document::{Segment, ShearCorrection, ShearRule, Size, SizeTable};
use super::shape::{Shape, report};
use crate::rod::{self, described::Section};

/// Shapes whose material the segment has.
const FIGURES: [&str; 4] = ["circle", "hollow_circle", "rectangle", "ellipse"];

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
    if written.section.as_ref().is_none_or(|section| section.text("shape") != Some("given")) {
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

fn of_table(written: &Written<Section>, here: &str, shape: &mut Shape) -> rod::Section {
    let Some(section) = read(written, here, shape) else {
        shape.replaced.insert(here.to_owned());
        // Of an unknown kind it may need no material.
        let is_figure = written.text("shape").is_some_and(|shape| FIGURES.contains(&shape));
        return if is_figure { stand_in() } else { given_stand_in() };
    };
    section.resolved()
}
