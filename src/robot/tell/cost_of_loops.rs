//! Cost of each loop: its share of the products of a residual and of a tangent. Solving with its constraints
//! is counted with the linear systems.

use crate::model::Holder;
use crate::robot::algebra::tie::Row;
use crate::robot::plan::Plan;
use crate::robot::turning::Turning;

/// Size of the computation for a loop, and its share of the products.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OfLoop {
    /// Number of coordinates on which its forces act.
    pub(crate) coordinates: usize,
    /// Share of [`super::cost::Multiplications::residual`].
    pub(crate) residual: u64,
    /// Share of [`super::cost::Multiplications::tangent`].
    pub(crate) tangent: u64,
}

/// Products of a scalar product, of a cross product, and of a rotated vector.
const DOT: u64 = 3;
const CROSS: u64 = 6;
const ROTATED: u64 = 9;

/// Products of the unit wrench of a row (`Row::wrench`), of its change with the motion of the frames
/// (`Row::change`), and of the rate with this wrench (`Row::rate`). Counted by hand, because ties use plain
/// numbers.
fn of_row(row: &Row) -> [u64; 3] {
    let [wrench, change] = match row {
        Row::Across(_) => [ROTATED, ROTATED + CROSS],
        Row::Angle { .. } => [2 * ROTATED + CROSS, 2 * ROTATED + 4 * CROSS],
        Row::Distance(_) => [2 * DOT + 1, 2 * DOT + 1 + DOT + 2 * DOT],
    };
    [wrench, change, wrench + CROSS + 2 * DOT]
}

/// Costs of the loops, in the order of the robot.
pub(crate) fn of_loops<G: Turning>(plan: &Plan<G>) -> Vec<OfLoop> {
    let loops = &plan.loops;
    let n = plan.n as u64;
    let of_ties = loops.ties.iter().map(|tie| {
        let reached = tie.reaches.len() as u64;
        let sum = |i: usize| tie.rows.iter().map(|row| of_row(row)[i]).sum::<u64>();
        // Both frames, the wrench on both ends, the gaps.
        let residual = 2 * (4 * ROTATED) + 2 * sum(0) + 2 * CROSS + sum(0);
        // Displacements of both ends, the rows of G, and the change of the forces with 12 products per entry.
        let forces = sum(1) + 6 * tie.rows.len() as u64 + 3 * CROSS + 12 * n;
        let of_loop = OfLoop {
            coordinates: tie.reaches.len(),
            residual,
            tangent: reached * (2 * CROSS + sum(2) + forces),
        };
        (loops.held_by[tie.first], of_loop)
    });
    let of_gears = (0..loops.gears.len()).map(|g| {
        let of_loop = OfLoop { coordinates: 2, residual: 2, tangent: 0 };
        (loops.held_by[loops.first_gear() + g], of_loop)
    });
    let mut found: Vec<(Holder, OfLoop)> = of_ties.chain(of_gears).collect();
    let place = |holder: Holder| match holder {
        Holder::Loop(place) | Holder::Tendon(place) => place,
    };
    found.sort_by_key(|&(holder, _)| place(holder));
    found.into_iter().map(|(_, of_loop)| of_loop).collect()
}
