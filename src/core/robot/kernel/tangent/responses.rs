//! Contributions of responses at the nodes to the tangent. Each of these sweeps is a separate call, because
//! few robots have responses.

use crate::numerics::lie::{Scalar, Sweep, Twist, Wrench};
use crate::robot::algebra::response::Response;
use crate::robot::state::tangent::{Row, Weights};
use crate::robot::turning::Turning;

/// Adds the responses of all nodes.
pub(super) struct Sum<'a, G: Turning> {
    pub(super) responses: &'a [Response<G, G::Pack>],
    pub(super) sum: &'a mut Response<G, f64>,
}

impl<G: Turning> Sweep for Sum<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for response in self.responses {
            self.sum.add(response.sum());
        }
    }
}

/// Adds the changes for one column to its source at the nodes; returns their sum, added to the given total.
pub(super) struct ColumnOfMass<'a, G: Turning> {
    pub(super) responses: &'a [Response<G, G::Pack>],
    pub(super) w_a: f64,
    pub(super) psi: &'a [Twist<G, G::Pack>],
    pub(super) source: &'a mut [Wrench<G, G::Pack>],
    pub(super) total: Wrench<G, G::Pack>,
}

impl<G: Turning> Sweep for ColumnOfMass<'_, G> {
    type Output = Wrench<G, G::Pack>;

    #[inline(always)]
    fn call(self) -> Wrench<G, G::Pack> {
        let Self { responses, w_a, psi, source, mut total } = self;
        let w_a = G::Pack::splat(w_a);
        for (pack, response) in responses.iter().enumerate() {
            let change = response.inertia.times_add(psi[pack] * w_a, Wrench::zero());
            source[pack] += change;
            total += change;
        }
        total
    }
}

/// The same with all weights.
pub(super) struct Column<'a, G: Turning> {
    pub(super) responses: &'a [Response<G, G::Pack>],
    pub(super) weights: Weights,
    /// Psi, Psi' and Psi''.
    pub(super) psi: [&'a [Twist<G, G::Pack>]; 3],
    pub(super) source: &'a mut [Wrench<G, G::Pack>],
    pub(super) total: Wrench<G, G::Pack>,
}

impl<G: Turning> Sweep for Column<'_, G> {
    type Output = Wrench<G, G::Pack>;

    #[inline(always)]
    fn call(self) -> Wrench<G, G::Pack> {
        let Self { responses, weights, psi: [psi, rate, acceleration], source, mut total } = self;
        let [w_q, w_v, w_a] = [weights.q, weights.v, weights.a].map(G::Pack::splat);
        for (pack, response) in responses.iter().enumerate() {
            let y = (psi[pack] * w_v).add_scaled(rate[pack], w_q);
            let z = (psi[pack] * w_a).add_scaled(rate[pack], w_v + w_v).add_scaled(acceleration[pack], w_q);
            let change = response.to(psi[pack] * w_q, y, z);
            source[pack] += change;
            total += change;
        }
        total
    }
}

/// Adds the responses to the row of one coordinate.
pub(super) struct AddRow<'a, G: Turning> {
    pub(super) responses: &'a [Response<G, G::Pack>],
    pub(super) psi: &'a [Twist<G, G::Pack>],
    pub(super) row: Row<'a, G>,
}

impl<G: Turning> Sweep for AddRow<'_, G> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        for (&psi, response) in self.psi.iter().zip(self.responses) {
            self.row.answer_nodes(response, psi);
        }
    }
}
