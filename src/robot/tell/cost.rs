//! Cost of a plan: numbers of floating-point products in its sweeps.
//!
//! The loops mirror those of the sweeps; each effect reports its own cost. Products within the loops are
//! counted by evaluating the formulas themselves with [`Counted`] numbers. A test compares with the products
//! of the real sweeps.

use std::ops::Range;

use super::cost_of_actuators::of_actuators;
use super::cost_of_loops::of_loops;
use crate::lie::{Counted, Cross, LANES, Twist, VectorSpace, Wrench, products};
use crate::robot::algebra::inertia::Seen as _;
use crate::robot::algebra::inertia::{Gyroscope, Inertia, SectionInertia};
use crate::robot::algebra::products::Products;
use crate::robot::algebra::response::Response;
use crate::robot::choice::Solve;
use crate::robot::effect::all as effects;
use crate::robot::kernel::inverse_dynamics::carried;
use crate::robot::kernel::tree;
use crate::robot::plan::Plan;
use crate::robot::plan::material::{Coupling, Moments};
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::tree::Relatives;
use crate::robot::turning::Turning;

/// Numbers of products of two doubles. A multiply-add counts as one; sums, quotients, roots and comparisons
/// are not counted. Of rotations computed by a series for small angles and another formula for large ones,
/// the former is counted. A few products that a sweep computes only once, such as those of supports, are
/// omitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Multiplications {
    /// One inverse dynamics, in a state of which nothing is known.
    pub residual: u64,
    /// One weighted tangent at a state with known residual, as in Newton's method.
    pub tangent: u64,
    /// One mass matrix at a known shape.
    pub mass_matrix: u64,
    /// One LU factorisation of a tangent, including the constraints of closed loops.
    pub factorisation: u64,
    /// One solution with this factorisation.
    pub solution: u64,
}

/// Counts of a plan with this solver.
pub(crate) fn multiplications<G: Turning>(plan: &Plan<G>, solve: Solve) -> Multiplications {
    let n = plan.n as u64;
    let [mut residual, mut tangent, mass_matrix] = evaluations(plan, solve, all(plan));
    for actuator in of_actuators(plan) {
        residual += actuator.residual;
        tangent += actuator.tangent;
    }
    for closed in of_loops(plan) {
        residual += closed.residual;
        tangent += closed.tangent;
    }
    let m = plan.loops.rows as u64;
    let [factorisation, solution] = match solve {
        // With the independent constraints as additional rows and columns, after these have been selected.
        Solve::Dense => [lu(n + m) + m * m * n, (n + m) * (n + m)],
        Solve::Tree => of_tree(plan),
    };
    Multiplications { residual, tangent, mass_matrix, factorisation, solution }
}

/// Size of the computation for a link, and its share of the products.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OfLink {
    /// Number of quadrature nodes of its rod.
    pub(crate) nodes: usize,
    /// Number of coordinates of its joint and rod.
    pub(crate) coordinates: usize,
    /// Share of [`Multiplications::residual`].
    pub(crate) residual: u64,
    /// Share of [`Multiplications::tangent`].
    pub(crate) tangent: u64,
}

/// Costs of links with all effects except actuators, including blocks with other links.
pub(crate) fn of_links<G: Turning>(plan: &Plan<G>, solve: Solve) -> Vec<OfLink> {
    let of_link = |link| {
        let pieces = plan.pieces_of(link);
        let [residual, tangent, _] = evaluations(plan, solve, pieces.clone());
        OfLink {
            nodes: plan.pieces[plan.links[link].rod.clone()]
                .iter()
                .map(|piece| piece.gauss.nodes.len())
                .sum(),
            coordinates: plan.pieces[pieces].iter().map(|piece| piece.n).sum(),
            residual,
            tangent,
        }
    };
    (0..plan.links.len()).map(of_link).collect()
}

/// Share of some pieces in a residual, a tangent and a mass matrix.
fn evaluations<G: Turning>(plan: &Plan<G>, solve: Solve, pieces: Range<usize>) -> [u64; 3] {
    let mut residual = kinematics(plan, pieces.clone());
    residual += motion(plan, pieces.clone());
    residual += projection(plan, pieces.clone());
    let [tangent, mass] =
        [false, true].map(|is_mass_only| tangent(plan, pieces.clone(), is_mass_only).total());
    let couplings = match solve {
        Solve::Dense => coupling(plan, pieces),
        Solve::Tree => [0, 0],
    };
    [residual.total(), tangent + couplings[0], mass + couplings[1]]
}

/// All pieces.
fn all<G: Turning>(plan: &Plan<G>) -> Range<usize> {
    0..plan.pieces.len()
}

/// LU factorisation: n - 1 - k multipliers and their square, for every pivot k.
fn lu(n: u64) -> u64 {
    n * n.saturating_sub(1) / 2 + n * n.saturating_sub(1) * (2 * n).saturating_sub(1) / 6
}

/// Factorisation and solution by [`crate::linalg::TreeLu`].
fn of_tree<G: Turning>(plan: &Plan<G>) -> [u64; 2] {
    let [upper, lower] = tree::ranks(plan).map(|rank| rank as u64);
    let mut count = [0, 0];
    for (s, piece) in plan.pieces.iter().enumerate() {
        let m = piece.n as u64;
        let places = plan.carrying.iter().filter(|place| place.piece == s).count() as u64;
        let is_carried = u64::from(piece.joined.hangs_at.is_some());
        let elimination = places * (2 * m * upper * lower + m * m * upper);
        let response = m * m * lower + is_carried * m * upper * lower;
        count[0] += lu(m) + elimination + response;
        count[1] += m * m + places * m * (upper + lower) + is_carried * m * (upper + lower);
    }
    count
}

/// Values of the types in the formulas.
struct Kinds<G: Turning> {
    twist: Twist<G, Counted>,
    wrench: Wrench<G, Counted>,
    axial: G::Axial<Counted>,
    vector: G::Vector<Counted>,
    rotation: G::Rotation<Counted>,
    section: SectionInertia<G, Counted>,
    inertia: Inertia<G, Counted>,
    gyroscope: Gyroscope<G, Counted>,
    response: Response<G, Counted>,
}

impl<G: Turning> Kinds<G> {
    fn new() -> Self {
        let vector = VectorSpace::zero();
        Self {
            twist: Twist::zero(),
            wrench: Wrench::zero(),
            axial: VectorSpace::zero(),
            vector,
            rotation: G::unrotated(),
            section: SectionInertia { mass: Counted, rotary: Counted, axis: vector, position: vector },
            inertia: Inertia::zero(),
            gyroscope: Gyroscope::zero(),
            response: Response::zero(),
        }
    }

    /// Inertial force of moving sections: their momentum and its change.
    fn force(&self, moments: &Moments<G>) -> u64 {
        let momenta = match moments {
            Moments::Round(_) => 2 * products(|| self.section.momentum(self.twist)),
            Moments::General(_) => self.carried() + 2 * products(|| self.inertia.momentum(self.twist)),
        };
        momenta + products(|| self.twist.bracket_transposed(self.wrench))
    }

    /// Inertia of sections, times quadrature weights.
    fn weighted(&self, moments: &Moments<G>) -> u64 {
        match moments {
            Moments::Round(_) => products(|| self.section.weighted(Counted)),
            Moments::General(_) => self.carried() + products(|| self.inertia.weighted(Counted)),
        }
    }

    /// Inertia about the origin.
    fn carried(&self) -> u64 {
        products(|| self.inertia.carried(&self.rotation, self.vector))
    }
}

/// Numbers of packs, nodes and coordinates of a piece.
fn sizes<G: Turning>(piece: &PiecePlan<G>) -> (u64, u64, u64) {
    (piece.packs as u64, (piece.packs * LANES) as u64, piece.n as u64)
}

/// `kernel::kinematics::update`.
fn kinematics<G: Turning>(plan: &Plan<G>, pieces: Range<usize>) -> Products {
    let k = Kinds::<G>::new();
    let mut count = Products::default();
    for piece in &plan.pieces[pieces] {
        let (packs, nodes, modes) = sizes(piece);
        if piece.joined.weld.is_some() {
            count.singles +=
                products(|| (G::rotate(&k.rotation, k.vector), G::compose(&k.rotation, &k.rotation)));
        }
        if piece.packs == 0 {
            let turn = products(|| G::compose(&k.rotation, &k.rotation));
            count.singles +=
                modes * (turn + products(|| carried::<G, _>(&k.rotation, k.vector, k.twist, true)));
            continue;
        }
        count += G::products_of_turn(piece);
        if piece.is_extensible {
            count.packs += packs * (modes + products(|| G::rotate(&k.rotation, k.vector)));
        }
        let scaled = products(|| k.vector * Counted);
        count.packs += packs * (nodes * scaled + scaled);
        let points = &plan.points[piece.points.all()];
        count.packs += piece.points.inside.len() as u64 * packs * scaled;
        let bodies = points.iter().filter(|point| point.body.is_some()).count() as u64;
        count.singles += bodies * k.carried();
    }
    count
}

/// `kernel::inverse_dynamics::update`.
fn motion<G: Turning>(plan: &Plan<G>, pieces: Range<usize>) -> Products {
    let k = Kinds::<G>::new();
    let scaled = products(|| k.twist * Counted);
    let mut count = Products::default();
    for piece in &plan.pieces[pieces] {
        let (packs, nodes, modes) = sizes(piece);
        if piece.packs == 0 {
            count.singles += modes * (2 * scaled + products(|| k.twist.bracket(k.twist)));
        }
        let carried = products(|| carried::<G, _>(&k.rotation, k.vector, k.twist, piece.is_extensible));
        let out = 2 * (modes + carried + nodes * scaled + scaled) + products(|| k.twist.bracket(k.twist));
        let back = nodes * scaled + scaled;
        count.packs += packs * (out + k.force(&piece.moments) + back);
        // To and from the points inside.
        count.packs += piece.points.inside.len() as u64 * packs * 3 * scaled;
        let bodies = plan.points[piece.points.all()].iter().filter(|point| point.body.is_some()).count();
        count.singles += bodies as u64
            * (2 * products(|| k.inertia.momentum(k.twist))
                + products(|| k.twist.bracket_transposed(k.wrench)));
        count += effects::products_of_action(plan, piece);
    }
    count
}

/// `kernel::inverse_dynamics::project`.
fn projection<G: Turning>(plan: &Plan<G>, pieces: Range<usize>) -> Products {
    let k = Kinds::<G>::new();
    let body = products(|| {
        let moment = G::rotate_axial_back(&k.rotation, k.vector.cross(k.vector));
        (moment, G::rotate_back(&k.rotation, k.vector))
    });
    let mut count = Products::default();
    for piece in &plan.pieces[pieces] {
        let (packs, _, modes) = sizes(piece);
        if piece.packs == 0 {
            count.singles += modes * products(|| k.twist.dot(k.wrench));
        }
        count.packs += packs * (body + modes);
        for component in &piece.components {
            let modes = component.modes as u64;
            count.singles += 2 * modes * if component.is_orthogonal { 1 } else { modes };
        }
        count.singles += 4 * piece.couplings.iter().map(coupled).sum::<u64>();
    }
    count
}

/// `kernel::tangent::weighted_tangent` with all weights, or for the mass matrix only, without the blocks
/// between different pieces.
fn tangent<G: Turning>(plan: &Plan<G>, pieces: Range<usize>, is_mass_only: bool) -> Products {
    let k = Kinds::<G>::new();
    let momentum = products(|| k.inertia.momentum(k.twist));
    let gyroscopic = products(|| k.gyroscope.times(k.axial));
    let response = products(|| k.response.to(k.twist, k.twist, k.twist));
    let scaled = products(|| k.twist * Counted);
    let scaled_axial = products(|| k.axial * Counted);
    let dot = products(|| k.twist.dot(k.wrench));
    let bracket = products(|| k.twist.bracket(k.twist));
    let bracket_transposed = products(|| k.twist.bracket_transposed(k.wrench));

    let mut count = Products::default();
    for s in pieces {
        let piece = &plan.pieces[s];
        let (packs, nodes, modes) = sizes(piece);
        // Bodies and columns of S.
        count.packs += packs * sections(&k, &piece.moments, is_mass_only);
        for component in &piece.components {
            if component.index < G::ANGULAR {
                count.packs += packs * products(|| k.vector.cross(k.axial));
            }
            if !is_mass_only {
                count.packs += packs * (3 * bracket + bracket_transposed + scaled);
            }
        }
        if piece.packs == 0 && !is_mass_only {
            count.singles += modes * (3 * bracket + bracket_transposed + scaled);
        }
        // Columns.
        let integral = packs * (2 * scaled + nodes * scaled);
        if is_mass_only {
            count.packs += modes * (integral + packs * (scaled + momentum));
            count.singles += modes * (scaled + momentum);
        } else {
            let source = 2 * scaled_axial + 3 * scaled + momentum + gyroscopic + scaled;
            count.packs += modes * (3 * integral + packs * source);
            count.singles += modes * (3 * scaled + 3 * scaled_axial + momentum + gyroscopic);
            if plan.has_dead_loads {
                count.singles += modes * gyroscopic;
            }
        }
        // Effects along the piece: gyroscopes and responses, columns, and rows below.
        count += effects::products_of_response(plan, piece, is_mass_only);
        let has_dead = !is_mass_only && effects::is_dead_along(plan, piece);
        let has_responses = effects::responds_along(piece);
        if has_dead {
            count.packs += packs * modes * (gyroscopic + scaled_axial);
        }
        if has_responses && is_mass_only {
            let inertia = products(|| k.response.inertia.times_add(k.twist, k.wrench));
            count.packs += modes * packs * (inertia + scaled);
            count.singles += modes * inertia;
        } else if has_responses {
            count.packs += modes * packs * (response + 6 * scaled);
        }
        count += points_inside(plan, piece, &k, is_mass_only);
        if s > 0 && !is_mass_only {
            count += rows(plan, piece, &k);
        }
        // Block (half of it for a mass matrix), stiffness and damping.
        let entries = if is_mass_only { modes * (modes + 1) / 2 } else { modes * modes };
        count.packs += entries * packs * dot;
        count.singles += entries * dot;
        if !is_mass_only {
            count.singles += piece.components.iter().map(|c| (c.modes * c.modes) as u64).sum::<u64>();
            count.singles += piece.couplings.iter().map(coupled).sum::<u64>();
        }
    }
    count
}

/// Number of points with responses inside a piece.
fn responding<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>) -> u64 {
    let points = &plan.points[piece.points.inside.clone()];
    points.iter().filter(|point| effects::responds_at(point)).count() as u64
}

/// Share of the points inside a piece in its columns and entries, and in the responses beyond it.
fn points_inside<G: Turning>(
    plan: &Plan<G>,
    piece: &PiecePlan<G>,
    k: &Kinds<G>,
    is_mass_only: bool,
) -> Products {
    let (packs, _, modes) = sizes(piece);
    let momentum = products(|| k.inertia.momentum(k.twist));
    let gyroscopic = products(|| k.gyroscope.times(k.axial));
    let response = products(|| k.response.to(k.twist, k.twist, k.twist));
    let scaled = products(|| k.twist * Counted);
    let dot = products(|| k.twist.dot(k.wrench));
    let integrals = if is_mass_only { 1 } else { 3 };
    let inside = piece.points.inside.len() as u64;
    let mut count = Products {
        packs: inside * modes * integrals * packs * scaled,
        singles: inside * modes * (momentum + modes * dot),
    };
    if !is_mass_only {
        count.singles += inside * modes * (2 * gyroscopic + 6 * scaled);
        count.singles += responding(plan, piece) * modes * response;
        if plan.has_responses {
            count.singles += modes * (response + 3 * scaled);
        }
    }
    count
}

/// Rows of a piece that follows others.
fn rows<G: Turning>(plan: &Plan<G>, piece: &PiecePlan<G>, k: &Kinds<G>) -> Products {
    let (packs, _, modes) = sizes(piece);
    let momentum = products(|| k.inertia.momentum(k.twist));
    let transposed = products(|| k.gyroscope.transposed_times(k.twist));
    let response = products(|| k.response.to(k.twist, k.twist, k.twist));
    let inside = piece.points.inside.len() as u64;
    let mut count = Products {
        packs: modes * packs * (momentum + transposed),
        singles: modes * (momentum + transposed) + inside * modes * 2 * transposed,
    };
    if effects::responds_along(piece) {
        count.packs += modes * packs * products(|| k.response.transposed_times(k.twist));
    }
    if effects::is_dead_along(plan, piece) {
        count.packs += modes * packs * transposed;
    }
    if plan.has_dead_loads {
        count.singles += modes * transposed;
    }
    if plan.has_responses {
        count.singles += (1 + responding(plan, piece)) * modes * response;
    }
    count
}

/// Products of a dense tangent for the blocks between different pieces, and of a mass matrix for half of
/// them.
fn coupling<G: Turning>(plan: &Plan<G>, pieces: Range<usize>) -> [u64; 2] {
    let k = Kinds::<G>::new();
    let dot = products(|| k.twist.dot(k.wrench));
    let axial_dot = products(|| k.axial.dot(k.axial));
    let linear_dot = if plan.has_responses { products(|| k.vector.dot(k.vector)) } else { 0 };
    let mut count = [0, 0];
    for piece in &plan.pieces[pieces] {
        let size = |relatives: &Relatives| relatives.coordinates.len() as u64;
        let [before, behind] = [&piece.joined.ancestors, &piece.joined.descendants]
            .map(|relatives| relatives.iter().map(size).sum::<u64>());
        let modes = piece.n as u64;
        count[0] += modes * (before * dot + behind * (dot + 2 * axial_dot + 2 * linear_dot));
        count[1] += modes * before * dot;
    }
    count
}

/// Inertia of a node, and its products with the motion.
fn sections<G: Turning>(k: &Kinds<G>, moments: &Moments<G>, is_mass_only: bool) -> u64 {
    let moving = products(|| Gyroscope::new(&k.inertia, k.twist, k.wrench * Counted));
    k.weighted(moments) + if is_mass_only { 0 } else { moving }
}

/// Number of entries of a stiffness between components.
fn coupled(coupling: &Coupling) -> u64 {
    coupling.stiffness.len() as u64
}

#[cfg(test)]
mod tests {
    use super::super::cost_of_actuators::{OfActuator, action, response};
    use super::*;
    use crate::actuator::{ActiveStrain, Actuator, Along, Chamber, Drive, Part, Strain, Tendon, Via};
    use crate::body::Body;
    use crate::lie::{Planar, Plane, Spatial};
    use crate::linalg::Matrix;
    use crate::load::{Extent, Frame, Load};
    use crate::robot::compile;
    use crate::robot::description::Rod;
    use crate::robot::kernel::{inverse_dynamics, kinematics as sweep, tangent as exact_tangent};
    use crate::robot::state::Workspace;
    use crate::robot::state::tangent::{Tangent, TangentWorkspace};
    use crate::rod::{Basis, Profile, STRAIGHT, Section, Segment};
    use crate::support::Support;
    use crate::world::Fluid;

    /// A rod of several segments with a load and a mass at its tip, so that only absent modes are skipped.
    fn rod(modes: &[[usize; 6]], is_tapered: bool) -> Rod {
        let segments = modes.iter().map(|&modes| Segment {
            modes,
            section: Section::circle(if is_tapered { [0.02, 0.01] } else { [0.02; 2] }),
            retardation_time: 0.01,
            ..Segment::straight(0.3, 0.02, 1e6, 4e5, 1000.0)
        });
        let load = Load { force: [0.1, 0.0, 0.2].into(), ..Load::at_tip() };
        let loads = vec![
            load.clone(),
            Load { extent: Extent::At(0.1), frame: Frame::Body, ..load.clone() },
            Load { extent: Extent::Along([0.0, 0.2]), ..load.clone() },
            Load { extent: Extent::Along([0.1, 0.3]), frame: Frame::Body, ..load },
        ];
        let bodies = vec![Body { at: Some(0.2), ..Body::point(0.01) }];
        let supports = vec![Support { at: Some(0.1), stiffness: [1.0; 3], ..Support::at_tip() }];
        let fluid = Fluid { viscous_drag: [0.1; 2], velocity: [1.0; 3], ..Fluid::ideal(900.0) };
        let rod = Rod { tip_mass: 0.01, loads, bodies, supports, ..Rod::new(segments.collect()) };
        Rod { fluid: Some(fluid), actuators: kinds_of_actuators(0.3 * modes.len() as f64), ..rod }
    }

    /// Actuators of all kinds; two tendons share a sleeve.
    fn kinds_of_actuators(length: f64) -> Vec<Actuator> {
        let along = |z: f64, to: f64| {
            Part::Along(Along { link: 0, offset: [0.002.into(), z.into()], along: [0.0, to] })
        };
        let point = |z: f64, at: f64| Part::Via(Via { link: Some(0), point: [0.0, 0.0, z], at: Some(at) });
        let tendon = |name: &str, path: Vec<Part>, drive: Drive, friction: f64| {
            let name = name.to_owned();
            Actuator::Tendon(Tendon { name, path, drive, friction, friction_velocity: 1e-3, sliding: None })
        };
        let tension = Drive::Tension([1.0].into());
        let taut = |damping| Drive::Length { length: [0.01].into(), stiffness: Some(9.0), damping };
        vec![
            tendon("pull", vec![along(0.01, length)], tension.clone(), 0.0),
            tendon("held", vec![along(-0.01, length)], taut(1.0), 0.0),
            tendon("undamped", vec![along(-0.01, 0.2)], taut(0.0), 0.0),
            tendon("straight", vec![point(0.1, 0.0), along(0.01, 0.2), point(-0.1, length)], tension, 0.0),
            tendon("rubbing", vec![along(0.01, 0.2), point(0.1, 0.25)], taut(1.0), 0.1),
            Actuator::Chamber(Chamber {
                name: "blow".to_owned(),
                path: vec![Along { link: 0, offset: [0.0.into(), 0.01.into()], along: [0.0, length] }],
                area: 1e-4,
                pressure: [1e3].into(),
            }),
            Actuator::ActiveStrain(ActiveStrain {
                name: "muscle".to_owned(),
                link: 0,
                strain: Strain::BendY,
                shape: 1.0.into(),
                amount: [1.0].into(),
            }),
        ]
    }

    /// Packs count their products while the sweeps run.
    fn assert_counts<G: Turning>(rod: &Rod, frame: G::Frame) {
        let plan = compile::plan::<G>(&rod.into(), frame);
        let (mut work, mut memory) = (Workspace::new(&plan), TangentWorkspace::new(&plan));
        let (q, mut tau) = (vec![0.01; plan.n], vec![0.0; plan.n]);
        let mut matrix = Matrix::zeros(plan.n, plan.n);
        let of_actuators =
            [action(&plan), response(&plan)].map(|of| of.iter().map(|of| of.packs).sum::<u64>());
        let counted = products(|| sweep::update(&plan, &mut work, &q));
        assert_eq!(counted, kinematics(&plan, all(&plan)).packs, "kinematics");
        let mut tangent_of = |work: &Workspace<G>, weights| {
            let to = Tangent::Dense(&mut matrix);
            products(|| exact_tangent::weighted_tangent(&plan, work, &mut memory, weights, to))
        };
        assert_eq!(tangent_of(&work, [0.0, 0.0, 1.0]), tangent(&plan, all(&plan), true).packs, "mass matrix");
        let counted = products(|| inverse_dynamics::update(&plan, &mut work, &q, &q, &q));
        assert_eq!(counted, motion(&plan, all(&plan)).packs + of_actuators[0], "motion");
        let whole = tangent(&plan, all(&plan), false).packs + of_actuators[1];
        assert_eq!(tangent_of(&work, [1e-4, 1e-2, 1.0]), whole, "tangent");
        let counted = products(|| inverse_dynamics::project(&plan, &mut work, &q, &q, &mut tau));
        assert_eq!(counted, projection(&plan, all(&plan)).packs, "projection");
    }

    #[test]
    fn the_sweeps_form_as_many_products_of_packs_as_are_counted() {
        let planar: [&[[usize; 6]]; 3] = [
            &[[0, 3, 0, 0, 0, 0]],
            &[[0, 9, 0, 2, 0, 1], [0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0]],
            &[[0, 0, 0, 1, 0, 0], [0, 2, 0, 0, 0, 3]],
        ];
        let spatial: [&[[usize; 6]]; 3] =
            [&[[2, 2, 2, 0, 0, 0]; 2], &[[3; 6]; 2], &[[1, 4, 0, 0, 2, 0], [0, 0, 7, 0, 0, 0], [0; 6]]];
        for is_tapered in [false, true] {
            for modes in planar {
                assert_counts::<Planar<true>>(&rod(modes, is_tapered), Plane::ABOUT_Y);
            }
            for modes in spatial.into_iter().chain(planar) {
                assert_counts::<Spatial<true>>(&rod(modes, is_tapered), ());
            }
        }
    }

    #[test]
    fn other_bases_and_reference_strains_that_vary_are_counted_too() {
        let stations = [0.0, 0.1, 0.3];
        let strains = [[0.0, 1.0, 0.0, 1.0, 0.0, 0.0], [0.0, 2.0, 0.0, 1.1, 0.0, 0.0], STRAIGHT];
        for basis in Basis::ALL {
            let mut planar = rod(&[[0, 4, 0, 4, 0, 0]; 2], false);
            let mut spatial = rod(&[[4, 4, 4, 0, 0, 0], [2, 2, 0, 2, 0, 2]], true);
            for segment in planar.segments.iter_mut().chain(&mut spatial.segments) {
                segment.basis = basis;
                segment.reference_strain = Profile::table(&stations, &strains).unwrap();
            }
            assert_counts::<Planar<true>>(&planar, Plane::ABOUT_Y);
            assert_counts::<Spatial<true>>(&planar, ());
            assert_counts::<Spatial<true>>(&spatial, ());
        }
    }

    #[test]
    fn links_and_actuators_share_all_products() {
        let rod = rod(&[[2, 2, 2, 1, 0, 0], [0, 3, 0, 0, 0, 0]], true);
        let plan = compile::plan::<Spatial<true>>(&(&rod).into(), ());
        let all = multiplications(&plan, Solve::Dense);
        let (links, actuators) = (of_links(&plan, Solve::Dense), of_actuators(&plan));
        let sum = |of: fn(&OfActuator) -> u64| actuators.iter().map(of).sum::<u64>();
        assert_eq!(links.iter().map(|of| of.residual).sum::<u64>() + sum(|of| of.residual), all.residual);
        assert_eq!(links.iter().map(|of| of.tangent).sum::<u64>() + sum(|of| of.tangent), all.tangent);

        // Constant forces have no tangent; friction and damping add costs.
        let [pull, held, undamped, straight, rubbing, chamber, active] = &actuators[..] else {
            panic!("all")
        };
        assert_eq!([chamber.tangent, active.tangent, chamber.nodes as u64], [0; 3]);
        assert!(held.tangent > pull.tangent && rubbing.tangent > undamped.tangent);
        assert_eq!([pull.lines, straight.lines, rubbing.lines], [0, 2, 1]);
        assert_eq!([pull, straight].map(|of| of.coordinates), [10, 10]);
        let couple = actuators.iter().map(|of| of.couples_pieces).collect::<Vec<_>>();
        assert_eq!(couple, [false, true, false, true, true, false, false]);
    }

    #[test]
    fn tendons_along_one_way_share_what_they_have_in_common() {
        let of = |number: usize| {
            let whole = rod(&[[2, 2, 2, 1, 0, 0]], false);
            let actuators = vec![whole.actuators[0].clone(); number];
            let plan = compile::plan::<Spatial<true>>(&(&Rod { actuators, ..whole }).into(), ());
            of_actuators(&plan).into_iter().map(|of| [of.residual, of.tangent]).collect::<Vec<_>>()
        };
        let (one, three) = (of(1), of(3));
        for i in 0..2 {
            let [first, second, third] = [0, 1, 2].map(|k| three[k][i]);
            assert!(first < one[0][i] && first.abs_diff(second) <= 4 && second.abs_diff(third) <= 4);
        }
    }

    #[test]
    fn a_factorisation_costs_a_third_of_the_cube() {
        let of = |segments: usize| {
            let rod = rod(&vec![[2, 2, 2, 0, 0, 0]; segments], false);
            multiplications(&compile::plan::<Spatial<true>>(&(&rod).into(), ()), Solve::Dense)
        };
        assert_eq!((of(1).factorisation, of(1).solution), ((6 * 6 * 6 - 6) / 3, 36));
        assert_eq!(of(2).factorisation, (12 * 12 * 12 - 12) / 3);
    }

    #[test]
    fn a_chain_costs_as_much_for_every_segment_more() {
        let of = |segments: usize, solve| {
            let rod = Rod { actuators: Vec::new(), ..rod(&vec![[2, 2, 2, 0, 0, 0]; segments], false) };
            let count = multiplications(&compile::plan::<Spatial<true>>(&(&rod).into(), ()), solve);
            [count.residual, count.tangent, count.mass_matrix, count.factorisation, count.solution]
        };
        let [four, five, nine, ten] = [4, 5, 9, 10].map(|segments| of(segments, Solve::Tree));
        for i in 0..four.len() {
            assert_eq!(ten[i] - nine[i], five[i] - four[i], "{i}");
        }
        let dense = of(10, Solve::Dense);
        assert_eq!(dense[0], ten[0]);
        assert!((1..5).all(|i| dense[i] > ten[i]), "{dense:?} {ten:?}");
    }
}
