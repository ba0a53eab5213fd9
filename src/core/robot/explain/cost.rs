//! Cost of a plan: numbers of floating-point products in its sweeps, estimated by a small table.
//!
//! A sweep takes products at every node, for every pair of nodes (integrals along a piece), for every coordinate, and for every pair
//! of coordinates. How many of each depends on the kernel. The table was fitted to the products that the sweeps form, and a test
//! compares both: within a tenth for rods, and a fourth with everything that acts on them. Effects that are cheap beside these
//! count as nothing.

use crate::model::Constraint;
use crate::robot::choice::Solve;
use crate::robot::effects;
use crate::robot::effects::actuator::plan::{ActuatorPlan, Law, Part, RoutingSegment};
use crate::robot::kernel::tree;
use crate::robot::plan::Plan;
use crate::robot::plan::material::Moments;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::turning::Turning;

/// Numbers of products of two doubles, accurate to about a tenth; those of linear systems with dense matrices are exact. A
/// multiply-add counts as one; sums, quotients, roots and comparisons are not counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Multiplications {
    /// One inverse dynamics in a new state.
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

/// Size of the computation for a link, an actuator or a loop, and its share of the products.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Share {
    /// Number of coordinates that belong to it, or on which its forces act.
    pub(crate) coordinates: usize,
    /// Number of quadrature nodes.
    pub(crate) nodes: usize,
    /// Share of [`Multiplications::residual`].
    pub(crate) residual: u64,
    /// Share of [`Multiplications::tangent`].
    pub(crate) tangent: u64,
}

/// The share of an actuator, and what it consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OfActuator {
    pub(crate) share: Share,
    /// Number of straight parts.
    pub(crate) lines: usize,
    /// Whether its tangent has entries between different pieces.
    pub(crate) couples_pieces: bool,
}

/// Products of one kernel; three numbers are for a residual, a tangent and a mass matrix.
struct Table {
    /// At each node; sections that are not round take `general` more.
    node: [f64; 3],
    general: [f64; 3],
    /// At each node for each strain with modes.
    strain: [f64; 3],
    /// At each node for each node of the piece; of matrices for each coordinate as well.
    pair_of_nodes: [f64; 3],
    /// At each node for each coordinate, and for each pair of coordinates.
    coordinate: [f64; 3],
    pair_of_coordinates: [f64; 3],
    /// For each coordinate of a joint or a rod, beside its nodes.
    hinge: [f64; 3],
    /// For each pair of coordinates of different pieces of which one moves the other.
    coupled: [f64; 3],
    /// For a body.
    body: f64,
    /// For a point within a piece: at each node, and for each coordinate in matrices.
    point: [f64; 3],
    /// For a spread load and for a fluid: at each node, and at each node for each coordinate in matrices.
    spread: [[f64; 2]; 2],
    fluid: [[f64; 3]; 2],
    /// For an embedded tendon with friction at each node, and for a straight part in a residual.
    guide: f64,
    rubbing: f64,
    line: f64,
}

const PLANAR: Table = Table {
    node: [80.0, 18.0, 8.0],
    general: [0.0; 3],
    strain: [4.0, 18.0, 0.0],
    pair_of_nodes: [10.9, 8.5, 2.8],
    coordinate: [4.4, 50.0, 21.0],
    pair_of_coordinates: [0.0, 3.5, 1.7],
    hinge: [15.0, 45.0, 13.0],
    coupled: [0.0, 8.0, 3.0],
    body: 30.0,
    point: [11.0, 9.0, 3.0],
    spread: [[5.0, 0.0], [12.0, 4.3]],
    fluid: [[49.0, 400.0, 31.0], [0.0, 53.0, 13.0]],
    guide: 13.0,
    rubbing: 55.0,
    line: 180.0,
};

const SPATIAL: Table = Table {
    node: [280.0, 100.0, 55.0],
    general: [200.0, 110.0, 110.0],
    strain: [7.0, 80.0, 0.0],
    pair_of_nodes: [19.6, 16.5, 5.4],
    coordinate: [6.2, 138.0, 57.0],
    pair_of_coordinates: [0.0, 6.8, 3.35],
    hinge: [36.0, 200.0, 40.0],
    coupled: [0.0, 18.0, 6.0],
    body: 153.0,
    point: [21.0, 18.0, 6.0],
    spread: [[12.0, 0.0], [62.0, 26.0]],
    fluid: [[109.0, 1900.0, 130.0], [0.0, 180.0, 45.0]],
    guide: 25.0,
    rubbing: 97.0,
    line: 330.0,
};

impl Table {
    fn of<G: Turning>() -> &'static Self {
        if G::ANGULAR == 1 { &PLANAR } else { &SPATIAL }
    }

    /// Products for a piece in a residual, a tangent and a mass matrix, without blocks between pieces.
    fn piece<G: Turning>(&self, plan: &Plan<G>, piece: &PiecePlan<G>) -> [f64; 3] {
        let (nodes, n) = (nodes(piece) as f64, piece.n as f64);
        let points = &plan.points[piece.points.all()];
        let bodies = points.iter().filter(|point| point.body.is_some()).count() as f64;
        let inside = piece.points.inside.len() as f64;
        let [is_general, is_immersed] =
            [matches!(piece.moments, Moments::General(_)), piece.immersed.is_some()].map(f64::from);
        let dead = f64::from(effects::is_dead_along(plan, piece)) * piece.spread.len() as f64;
        std::array::from_fn(|i| {
            // Residuals have no columns.
            let columns = if i == 0 { 1.0 } else { n };
            let per_node = self.node[i]
                + is_general * self.general[i]
                + self.strain[i] * piece.components.len() as f64
                + columns * self.pair_of_nodes[i] * nodes
                + self.coordinate[i] * n
                + self.pair_of_coordinates[i] * n * n
                + is_immersed * (self.fluid[0][i] + self.fluid[1][i] * n)
                + inside * self.point[i] * columns;
            let spread = match i {
                0 => self.spread[0][0] * piece.spread.len() as f64,
                1 => dead * (self.spread[1][0] + self.spread[1][1] * n),
                _ => 0.0,
            };
            let of_bodies = if i == 0 { self.body * bodies } else { 0.0 };
            nodes * (per_node + spread) + self.hinge[i] * n + of_bodies
        })
    }
}

/// Estimates for a plan with this solver.
pub(crate) fn multiplications<G: Turning>(plan: &Plan<G>, solve: Solve) -> Multiplications {
    let (actuators, loops) = (of_actuators(plan), of_loops(plan));
    let shares =
        || of_links(plan, solve).into_iter().chain(actuators.iter().map(|of| of.share)).chain(loops.clone());
    let sum = |of: fn(&Share) -> u64| shares().map(|share| of(&share)).sum();
    let [n, m] = [plan.n as u64, plan.effects.loops.rows as u64];
    let [factorisation, solution] = match solve {
        // With the independent constraints as additional rows and columns, after these have been selected.
        Solve::Dense => [lu(n + m) + m * m * n, (n + m) * (n + m)],
        Solve::Tree => of_tree(plan),
    };
    let mass_matrix =
        (0..plan.links.len()).map(|link| evaluations(plan, solve, plan.pieces_of(link))[2]).sum::<f64>();
    Multiplications {
        residual: sum(|share| share.residual),
        tangent: sum(|share| share.tangent),
        mass_matrix: mass_matrix.round() as u64,
        factorisation,
        solution,
    }
}

/// Shares of links with all effects except actuators, including blocks with other links.
pub(crate) fn of_links<G: Turning>(plan: &Plan<G>, solve: Solve) -> Vec<Share> {
    let of_link = |link| {
        let pieces = plan.pieces_of(link);
        let [residual, tangent, _] =
            evaluations(plan, solve, pieces.clone()).map(|count| count.round() as u64);
        let rod = &plan.pieces[plan.links[link].rod.clone()];
        Share {
            nodes: rod.iter().map(|piece| piece.gauss.nodes.len()).sum(),
            coordinates: plan.pieces[pieces].iter().map(|piece| piece.n).sum(),
            residual,
            tangent,
        }
    };
    (0..plan.links.len()).map(of_link).collect()
}

/// Share of some pieces in a residual, a tangent and a mass matrix.
fn evaluations<G: Turning>(plan: &Plan<G>, solve: Solve, pieces: std::ops::Range<usize>) -> [f64; 3] {
    let table = Table::of::<G>();
    let mut count = [0.0; 3];
    for piece in &plan.pieces[pieces] {
        let moving =
            piece.joined.ancestors.iter().map(|relatives| relatives.coordinates.len()).sum::<usize>();
        let couplings = if solve == Solve::Dense { (piece.n * moving) as f64 } else { 0.0 };
        for ((count, of_piece), coupled) in count.iter_mut().zip(table.piece(plan, piece)).zip(table.coupled)
        {
            *count += of_piece + coupled * couplings;
        }
    }
    count
}

fn nodes<G: Turning>(piece: &PiecePlan<G>) -> usize {
    piece.packs * crate::numerics::lie::LANES
}

/// Shares of the actuators.
pub(crate) fn of_actuators<G: Turning>(plan: &Plan<G>) -> Vec<OfActuator> {
    let table = Table::of::<G>();
    let of_actuator = |(i, actuator): (usize, &ActuatorPlan)| {
        let reached = actuator.reaches.len() as f64;
        let (mut residual, mut tangent) = (3.0 * reached, 0.0);
        let mut nodes = 0;
        for routing_segment in guides(plan, i) {
            let of_routing_segment = routing_segment.packs * crate::numerics::lie::LANES;
            nodes += of_routing_segment;
            let n = routing_segment.components.iter().map(|component| component.modes).sum::<usize>() as f64;
            let pairs = routing_segment.components.len() as f64;
            // Tendons along the same part of a segment share what belongs to its coordinates.
            let shared = n / routing_segment.guides.len() as f64;
            let at_nodes = of_routing_segment as f64;
            residual += at_nodes * (table.guide + n + shared);
            tangent += at_nodes * (4.0 * pairs + shared * (n + 1.0));
            if has_rate(actuator) {
                tangent += at_nodes * (2.0 * n + 3.0 * pairs);
            }
            if actuator.friction.is_some() {
                residual += at_nodes * (table.rubbing + 2.0 * n + at_nodes);
                tangent += n * at_nodes * (at_nodes + 3.0 * n) / 2.0 + at_nodes * table.rubbing;
            }
        }
        if actuator.law.has_stiffness() || has_rate(actuator) {
            tangent += reached * (3.0 + reached * if has_rate(actuator) { 2.0 } else { 1.0 });
        }
        let lines = actuator.path.iter().filter(|part| matches!(part, Part::Line(_))).count();
        residual += lines as f64 * table.line;
        // The ends of a straight part turn and move with every coordinate.
        tangent += lines as f64 * reached * (table.line + 4.0 * reached);
        let [residual, tangent] = [residual, tangent].map(|count| count.round() as u64);
        OfActuator {
            share: Share { coordinates: actuator.reaches.len(), nodes, residual, tangent },
            lines,
            couples_pieces: plan.effects.actuation.couples(i),
        }
    };
    plan.effects.actuation.actuators.iter().enumerate().map(of_actuator).collect()
}

/// Routing segments that contain guides of an actuator, one for each guide.
fn guides<G: Turning>(plan: &Plan<G>, actuator: usize) -> impl Iterator<Item = &RoutingSegment<G::Pack>> {
    let routing_segment_of = |part: &Part| match *part {
        Part::Guide { routing_segment, .. } => {
            Some(&plan.effects.actuation.routing_segments[routing_segment])
        }
        Part::Line(_) => None,
    };
    plan.effects.actuation.actuators[actuator].path.iter().filter_map(routing_segment_of)
}

/// Whether the tangent needs the rate of the length's gradient.
fn has_rate(actuator: &ActuatorPlan) -> bool {
    let is_damped = match actuator.law {
        Law::Cable { damping, .. } | Law::Servo { damping, .. } => damping != 0.0,
        Law::Tension | Law::Inextensible { .. } | Law::Pressure | Law::Torque { .. } | Law::Amount { .. } => {
            false
        }
    };
    is_damped || actuator.friction.as_ref().is_some_and(|friction| friction.sliding.is_none())
}

/// Products for the frames of a loop, for each of its rows in a residual, and for each row and coordinate in a tangent.
const FRAMES: u64 = 84;
const ROW: u64 = 40;
const ROW_OF_COORDINATE: u64 = 90;

/// Shares of the loops, in the order of the robot. Solving with their constraints is counted with the linear systems.
pub(crate) fn of_loops<G: Turning>(plan: &Plan<G>) -> Vec<Share> {
    let loops = &plan.effects.loops;
    let of_ties = loops.ties.iter().map(|tie| {
        let [rows, reached] = [tie.rows.len() as u64, tie.reaches.len() as u64];
        // The change of the forces has entries for every coordinate of the robot.
        let tangent = reached * (rows * ROW_OF_COORDINATE + 12 * plan.n as u64);
        (
            loops.constraints[tie.first],
            Share { coordinates: tie.reaches.len(), nodes: 0, residual: FRAMES + rows * ROW, tangent },
        )
    });
    let of_gears = (0..loops.gears.len()).map(|g| {
        (
            loops.constraints[loops.first_gear() + g],
            Share { coordinates: 2, nodes: 0, residual: 2, tangent: 0 },
        )
    });
    let mut found: Vec<(Constraint, Share)> = of_ties.chain(of_gears).collect();
    let place = |holder: Constraint| match holder {
        Constraint::Loop(place) | Constraint::Tendon(place) => place,
    };
    found.sort_by_key(|&(holder, _)| place(holder));
    found.into_iter().map(|(_, share)| share).collect()
}

/// LU factorisation: n - 1 - k multipliers and their square, for every pivot k.
fn lu(n: u64) -> u64 {
    n * n.saturating_sub(1) / 2 + n * n.saturating_sub(1) * (2 * n).saturating_sub(1) / 6
}

/// Factorisation and solution by [`crate::numerics::linalg::TreeLu`].
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::body::Body;
    use crate::description::rod::{Section, Segment};
    use crate::numerics::lie::{LANES, Planar, Plane, Spatial, products};
    use crate::numerics::linalg::Matrix;
    use crate::robot::compile;
    use crate::robot::description::Rod;
    use crate::robot::effects::actuator::{
        ActiveStrain, Actuator, Along, Chamber, Drive, Part, Strain, Tendon, Via,
    };
    use crate::robot::effects::fluid::Fluid;
    use crate::robot::effects::load::{Extent, Frame, Load};
    use crate::robot::effects::support::Support;
    use crate::robot::kernel::{inverse_dynamics, kinematics, tangent as exact_tangent};
    use crate::robot::state::Workspace;
    use crate::robot::state::tangent::{Tangent, TangentWorkspace};

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

    /// Actuators of all kinds; two tendons share a routing segment.
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

    /// Packs count their products while the sweeps run; those of single places, which the sweeps do beside them, are a few percent.
    fn assert_estimated<G: Turning>(rod: &Rod, frame: G::Frame, within: f64) {
        let plan = compile::plan::<G>(&rod.into(), frame);
        let (mut work, mut memory) = (Workspace::new(&plan), TangentWorkspace::new(&plan));
        let (q, mut tau) = (vec![0.01; plan.n], vec![0.0; plan.n]);
        let mut matrix = Matrix::zeros(plan.n, plan.n);
        let mut tangent_of = |work: &Workspace<G>, weights| {
            let to = Tangent::Dense(&mut matrix);
            products(|| exact_tangent::weighted_tangent(&plan, work, &mut memory, weights, to))
        };
        let mut residual = products(|| kinematics::update(&plan, &mut work, &q));
        let mass_matrix = tangent_of(&work, [0.0, 0.0, 1.0]);
        residual += products(|| inverse_dynamics::update(&plan, &mut work, &q, &q, &q));
        let tangent = tangent_of(&work, [1e-4, 1e-2, 1.0]);
        residual += products(|| inverse_dynamics::project(&plan, &mut work, &q, &q, &mut tau));
        let estimated = multiplications(&plan, Solve::Dense);
        for (what, counted, estimated) in [
            ("residual", residual, estimated.residual),
            ("tangent", tangent, estimated.tangent),
            ("mass matrix", mass_matrix, estimated.mass_matrix),
        ] {
            let ratio = estimated as f64 / (LANES as u64 * counted) as f64;
            assert!((1.0 - within..1.0 + within).contains(&ratio), "{what}: {ratio} of {counted}");
        }
    }

    #[test]
    fn the_sweeps_form_about_as_many_products_of_packs_as_are_estimated() {
        let planar: [&[[usize; 6]]; 3] = [
            &[[0, 3, 0, 0, 0, 0]],
            &[[0, 9, 0, 2, 0, 1], [0, 4, 0, 0, 0, 0]],
            &[[0, 1, 0, 1, 0, 0], [0, 2, 0, 0, 0, 3]],
        ];
        let spatial: [&[[usize; 6]]; 3] =
            [&[[2, 2, 2, 0, 0, 0]; 2], &[[3; 6]; 2], &[[1, 4, 0, 0, 2, 0], [0, 2, 7, 0, 0, 0]]];
        for (acts, within) in [(false, 0.15), (true, 0.3)] {
            let rod = |modes| {
                let whole = rod(modes, true);
                if acts { whole } else { Rod { segments: whole.segments, ..Rod::new(Vec::new()) } }
            };
            for modes in planar {
                assert_estimated::<Planar<true>>(&rod(modes), Plane::ABOUT_Y, within);
            }
            for modes in spatial {
                assert_estimated::<Spatial<true>>(&rod(modes), (), within);
            }
        }
    }

    #[test]
    fn links_and_actuators_share_all_products() {
        let rod = rod(&[[2, 2, 2, 1, 0, 0], [0, 3, 0, 0, 0, 0]], true);
        let plan = compile::plan::<Spatial<true>>(&(&rod).into(), ());
        let all = multiplications(&plan, Solve::Dense);
        let (links, actuators) = (of_links(&plan, Solve::Dense), of_actuators(&plan));
        let sum = |of: fn(&Share) -> u64| actuators.iter().map(|actuator| of(&actuator.share)).sum::<u64>();
        assert_eq!(links.iter().map(|of| of.residual).sum::<u64>() + sum(|of| of.residual), all.residual);
        assert_eq!(links.iter().map(|of| of.tangent).sum::<u64>() + sum(|of| of.tangent), all.tangent);

        // Constant forces have no tangent; friction and damping add costs.
        let [pull, held, undamped, straight, rubbing, chamber, active] = &actuators[..] else {
            panic!("all")
        };
        assert_eq!([chamber.share.tangent, active.share.tangent, chamber.share.nodes as u64], [0; 3]);
        assert!(held.share.tangent > pull.share.tangent && rubbing.share.tangent > undamped.share.tangent);
        assert_eq!([pull.lines, straight.lines, rubbing.lines], [0, 2, 1]);
        assert_eq!([pull, straight].map(|of| of.share.coordinates), [10, 10]);
        let couple = actuators.iter().map(|of| of.couples_pieces).collect::<Vec<_>>();
        assert_eq!(couple, [false, true, false, true, true, false, false]);
    }

    #[test]
    fn tendons_along_one_way_share_what_they_have_in_common() {
        let of = |number: usize| {
            let whole = rod(&[[2, 2, 2, 1, 0, 0]], false);
            let actuators = vec![whole.actuators[0].clone(); number];
            let plan = compile::plan::<Spatial<true>>(&(&Rod { actuators, ..whole }).into(), ());
            of_actuators(&plan)
                .into_iter()
                .map(|of| [of.share.residual, of.share.tangent])
                .collect::<Vec<_>>()
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
            assert!((ten[i] - nine[i]).abs_diff(five[i] - four[i]) <= 1, "{i}");
        }
        let dense = of(10, Solve::Dense);
        assert_eq!(dense[0], ten[0]);
        assert!((1..5).all(|i| dense[i] > ten[i]), "{dense:?} {ten:?}");
    }
}
