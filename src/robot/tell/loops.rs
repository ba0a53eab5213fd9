//! What closes loops of links, in words, and what it costs.

use super::explanation::Explanation;
use super::text::{counted, listed};
use crate::loops::{Loop, Tie};
use crate::robot::algebra::tie::Row;
use crate::robot::description::Robot;
use crate::robot::plan::Plan;
use crate::robot::turning::Turning;

/// What a loop is computed with, and its part of the products.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OfLoop {
    /// Constraints.
    pub(crate) rows: usize,
    /// Those that its forces act on.
    pub(crate) coordinates: usize,
    /// Of [`super::cost::Multiplications::residual`].
    pub(crate) residual: u64,
    /// Of [`super::cost::Multiplications::tangent`].
    pub(crate) tangent: u64,
}

/// Products of a vector with another one, of a cross product, of a rotated vector.
const DOT: u64 = 3;
const CROSS: u64 = 6;
const ROTATED: u64 = 9;

/// The unit wrench of a row (`Row::wrench`), how it changes as the frames move (`Row::change`), and its rate with that wrench
/// (`Row::rate`); counted by hand, as the algebra of ties is one of plain numbers.
fn of_row(row: &Row) -> [u64; 3] {
    let [wrench, change] = match row {
        Row::Across(_) => [ROTATED, ROTATED + CROSS],
        Row::Angle { .. } => [2 * ROTATED + CROSS, 2 * ROTATED + 4 * CROSS],
        Row::Distance(_) => [2 * DOT + 1, 2 * DOT + 1 + DOT + 2 * DOT],
    };
    [wrench, change, wrench + CROSS + 2 * DOT]
}

/// What the loops are compiled to, in the order of the robot.
pub(crate) fn of_loops<G: Turning>(plan: &Plan<G>) -> Vec<OfLoop> {
    let loops = &plan.loops;
    let n = plan.n as u64;
    let of_ties = loops.ties.iter().map(|tie| {
        let reached = tie.reaches.len() as u64;
        let sum = |i: usize| tie.rows.iter().map(|row| of_row(row)[i]).sum::<u64>();
        // Both frames, the wrench on both ends, the gaps.
        let residual = 2 * (4 * ROTATED) + 2 * sum(0) + 2 * CROSS + sum(0);
        // How both ends move, the rows of G, and the change of the forces with 12 products an entry.
        let forces = sum(1) + 6 * tie.rows.len() as u64 + 3 * CROSS + 12 * n;
        let of_loop = OfLoop {
            rows: tie.rows.len(),
            coordinates: tie.reaches.len(),
            residual,
            tangent: reached * (2 * CROSS + sum(2) + forces),
        };
        (loops.loop_of[tie.first], of_loop)
    });
    let first_gear = loops.rows - loops.gears.len();
    let of_gears = (0..loops.gears.len()).map(|g| {
        let of_loop = OfLoop { rows: 1, coordinates: 2, residual: 2, tangent: 0 };
        (loops.loop_of[first_gear + g], of_loop)
    });
    let mut found: Vec<(usize, OfLoop)> = of_ties.chain(of_gears).collect();
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, of_loop)| of_loop).collect()
}

/// What is computed for the loops of a robot.
pub(super) fn tell(robot: &Robot, explanation: &mut Explanation) {
    if robot.loops.is_empty() {
        explanation.add(false, "closed loops", "none");
        return;
    }
    let names = robot.coordinate_names();
    for closed in &robot.loops {
        let rows = counted(closed.tie.rows(), "constraint");
        explanation.add(
            true,
            format!("loop {}", closed.name),
            format!("{rows}: {}", kind(robot, closed, &names)),
        );
    }
    let rows: usize = robot.loops.iter().map(|closed| closed.tie.rows()).sum();
    let n = robot.coordinates();
    let why = format!(
        "{} held by multipliers: {} of a step, exact at its end",
        counted(rows, "constraint"),
        counted(n + rows, "unknown"),
    );
    explanation.add(true, "closed loops", why);
}

/// What a loop holds, in words.
fn kind(robot: &Robot, closed: &Loop, names: &[String]) -> String {
    let ends = || {
        let ends = closed.tie.ends().into_iter().flatten();
        let name = |link: Option<usize>| link.map_or("the world", |link| robot.links[link].name.as_str());
        ends.map(|end| name(end.link)).collect::<Vec<_>>().join(" to ")
    };
    match &closed.tie {
        Tie::Joint { joint, .. } => format!("{} joint, {}", joint.name(), ends()),
        Tie::Distance { length, .. } => format!("a distance of {length} m, {}", ends()),
        Tie::Coordinates { coordinates: [first, second], ratio, offset } => {
            let offset = match *offset {
                0.0 => String::new(),
                offset if offset < 0.0 => format!(" - {}", -offset),
                offset => format!(" + {offset}"),
            };
            format!("gear, {} = {ratio} {}{offset}", names[*first], names[*second])
        }
    }
}

/// Adds which constraints the others determine in the shape in which all coordinates are zero, loop by loop.
pub(crate) fn tell_redundant(robot: &Robot, redundant: &[usize], explanation: &mut Explanation) {
    let named = robot.loops.iter().zip(redundant).filter(|(_, number)| **number > 0);
    let named: Vec<String> = named.map(|(closed, number)| format!("{number} of {}", closed.name)).collect();
    let (is_there, why) = match named.is_empty() {
        true => (false, "none where all coordinates are zero".to_owned()),
        false => {
            let why = "where all coordinates are zero; the others determine them, they get no multipliers";
            (true, format!("{}, {why}", listed(named)))
        }
    };
    explanation.add(is_there, "redundant constraints", why);
}
