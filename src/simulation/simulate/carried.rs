//! The energy of a run with fixed steps whose base or joints move as prescribed: what these supply is known at the ends of steps only,
//! too roughly to look at single steps, but not so roughly that most of the energy may come from nowhere.

use super::Simulation;
use crate::error::Number;
use crate::model::Model;
use crate::simulation::balance::{Balance, Flow};

/// Energies are compared at this many times of a run, evenly spaced, after its start.
const LOOKS: usize = 16;

/// A change of the total by more than this part of the largest energy causes a doubt. Steps that resolve the motion, but a prescribed
/// one hardly, leave up to half.
const UNKNOWN: f64 = 0.6;

/// Why the motion may be wrong, if much of its energy comes from nowhere.
pub(super) fn doubt<M: Model>(model: &mut M, simulation: &Simulation, dt: f64) -> Option<String> {
    let Simulation { t, q, v, u, n, flow, .. } = simulation;
    if !model.facts().is_carried || *n == 0 || t.len() < 2 {
        return None;
    }
    let last = t.len() - 1;
    let mut looks: Vec<usize> = (0..=LOOKS).map(|look| look * last / LOOKS).collect();
    looks.dedup();
    let inputs = u.len() / t.len();
    let pick = |values: &[f64], n: usize| -> Vec<f64> {
        if values.is_empty() {
            return Vec::new();
        };
        looks.iter().flat_map(|&i| &values[i * n..][..n]).copied().collect()
    };
    let flow = Flow { dissipated: pick(&flow.dissipated, 1), work: pick(&flow.work, 1) };
    let states = [pick(q, *n), pick(v, *n), pick(u, inputs)];
    let balance = Balance::new(model, &pick(t, 1), &states[0], &states[1], &states[2], &flow).ok()?;
    let drift = balance.drift();
    (drift > UNKNOWN).then(|| {
        format!(
            "The balance of energies is open by {:.0} % of the largest one: steps of {} s are too long for this motion. Take shorter \
             steps, adaptive ones, or method \"auto\".",
            100.0 * drift,
            Number(dt)
        )
    })
}
