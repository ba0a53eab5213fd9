//! Compiles a piece of a segment to a part of a plan.

use crate::description::rod::STRAINS;
use crate::description::rod::piece::Piece;
use crate::description::rod::{STRAIGHT, SectionProperties, nodes, stiffness};
use crate::numerics::lie::{LANES, Lanes, VectorSpace};
use crate::robot::algebra::inertia;
use crate::robot::algebra::inertia::Inertia;
use crate::robot::plan;
use crate::robot::plan::joined::Joined;
use crate::robot::plan::material::{Component, Coupling, Moments};
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Points;
use crate::robot::plan::stretch::Stretch;
use crate::robot::turning::Turning;

pub(crate) fn plan<G: Turning>(
    piece: Piece,
    frame: G::Frame,
    joined: Joined<G>,
    first: usize,
    first_pack: usize,
) -> PiecePlan<G> {
    let degrees = piece.degrees();
    let gauss = nodes::quadrature(&piece);
    let nodes = gauss.nodes.len();
    let packs = nodes / LANES;
    let length = piece.length();

    let pack = |f: &dyn Fn(usize) -> f64| plan::packed(nodes, f);
    let up_to = gauss.weights_up_to_nodes();
    let matrix = |f: &dyn Fn(usize, usize) -> f64| -> Vec<G::Pack> {
        let entry =
            |p: usize, l: usize| G::Pack::from_lanes(std::array::from_fn(|lane| f(p * LANES + lane, l)));
        (0..packs).flat_map(|p| (0..nodes).map(move |l| (p, l))).map(|(p, l)| entry(p, l)).collect()
    };
    let at_nodes: Vec<Vec<f64>> = gauss.nodes.iter().map(|&x| basis_at(&piece, x)).collect();

    let components = components::<G>(&piece, frame, first);
    let before_stretch: usize = piece.modes[..3].iter().sum();
    let stretch = (piece.modes[3] > 0).then(|| Stretch::new(&piece, &gauss, first + before_stretch));
    let sections: Vec<_> = gauss.nodes.iter().map(|&x| piece.section(x)).collect();
    let is_straight =
        |strain: usize| piece.segment.reference_strain.is_entry_constant(strain) == Some(STRAIGHT[strain]);
    let is_extensible = piece.modes[3..].iter().any(|&modes| modes > 0) || !(3..STRAINS).all(is_straight);

    let [_, bend_y, bend_z, _, shear_y, shear_z] = piece.modes;
    let turns = bend_y + bend_z + shear_y + shear_z > 0 || !(1..STRAINS).all(is_straight);

    PiecePlan {
        length,
        joined,
        is_joint: false,
        hinge: None,
        largest_gap: if turns { length * gauss.largest_gap() } else { 0.0 },
        first,
        n: piece.modes.iter().sum(),
        first_pack,
        packs,
        weights: pack(&|i| length * gauss.weights[i]),
        from_base: matrix(&|i, l| length * up_to[i * nodes + l]),
        to_end: matrix(&|i, l| length * (gauss.weights[l] - up_to[i * nodes + l])),
        basis: (0..degrees).flat_map(|k| pack(&|i| at_nodes[i][k])).collect(),
        weighted_basis: (0..degrees)
            .flat_map(|k| pack(&|i| length * gauss.weights[i] * at_nodes[i][k]))
            .collect(),
        largest_reference_curvature: nodes::largest_reference_curvature(&piece, &gauss.nodes),
        reference_curvature: gauss
            .nodes
            .iter()
            .map(|&x| reference_curvature::<G>(&piece, frame, x))
            .collect(),
        turning: G::constants(&piece, frame, &gauss, &components),
        couplings: couplings(&piece, first),
        components,
        reference_slope: gauss
            .nodes
            .chunks(LANES)
            .map(|nodes| reference_slope::<G>(&piece, frame, nodes))
            .collect(),
        stretch,
        is_extensible,
        mass: pack(&|i| sections[i].mass),
        moments: moments(frame, &sections),
        retardation_time: piece.segment.retardation_time,
        spread: Vec::new(),
        points: Points::default(),
        immersed: None,
        gauss,
        source: Some(piece),
    }
}

/// Strain components of a piece whose first coordinate is `first`.
fn components<G: Turning>(piece: &Piece, frame: G::Frame, first: usize) -> Vec<Component> {
    let is_orthogonal = !stiffness::is_tapered(piece) && piece.basis.is_orthogonal();
    let mut next = first;
    let mut components = Vec::new();
    for (strain, &modes) in piece.modes.iter().enumerate().filter(|&(_, &modes)| modes > 0) {
        let index = G::strain_index(frame, strain);
        let stiffness = stiffness::stiffness(piece, [strain; 2]);
        components.push(Component { index, modes, first: next, stiffness, is_orthogonal });
        next += modes;
    }
    components
}

/// Values of the basis at a node.
fn basis_at(piece: &Piece, x: f64) -> Vec<f64> {
    let mut values = vec![0.0; piece.degrees()];
    piece.basis.values(x, &mut values);
    values
}

/// Angular part of the reference strain at a node.
fn reference_curvature<G: Turning>(piece: &Piece, frame: G::Frame, x: f64) -> G::Axial<f64> {
    let [a, b, c, ..] = piece.reference(x);
    G::axial_of(frame, [a, b, c].into())
}

/// Linear part of the reference strain at one pack of nodes.
fn reference_slope<G: Turning>(piece: &Piece, frame: G::Frame, nodes: &[f64]) -> G::Vector<G::Pack> {
    let mut slope = G::Vector::<G::Pack>::zero();
    for index in 0..G::COMPONENTS - G::ANGULAR {
        let at = |lane: usize| {
            let [.., d, e, f] = piece.reference(nodes[lane]);
            *G::vector_component(&mut G::vector_of(frame, [d, e, f].into()), index)
        };
        *G::vector_component(&mut slope, index) = G::Pack::from_lanes(std::array::from_fn(at));
    }
    slope
}

/// Stiffness between different strains of a piece whose first coordinate is `first`.
fn couplings(piece: &Piece, first: usize) -> Vec<Coupling> {
    let start = |strain: usize| first + piece.modes[..strain].iter().sum::<usize>();
    let coupling = |strains: [usize; 2]| Coupling {
        first: strains.map(start),
        stiffness: stiffness::stiffness(piece, strains),
    };
    stiffness::coupled(piece).into_iter().map(coupling).collect()
}

pub(crate) fn moments<G: Turning>(frame: G::Frame, sections: &[SectionProperties]) -> Moments<G> {
    let nodes = sections.len();
    let is_centred = |section: &SectionProperties| {
        let centre = G::vector_of(frame, section.centre.into());
        centre.dot(centre) == 0.0
    };
    let round = |section: &SectionProperties| {
        is_centred(section).then(|| G::rotary_inertia(frame, section.inertia_about_axis())).flatten()
    };
    match sections.iter().map(round).collect::<Option<Vec<f64>>>() {
        Some(rotary) => Moments::Round(plan::packed(nodes, |i| rotary[i])),
        None => Moments::General(inertia::packed(nodes, |i| {
            let section = &sections[i];
            Inertia {
                mass: section.mass,
                first_moment: G::vector_of(frame, section.centre.into()) * section.mass,
                second_moment: G::second_moment_of(frame, section.inertia_about_axis()),
            }
        })),
    }
}
