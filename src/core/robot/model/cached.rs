//! Energies at the ends of a step, which several of its checks ask for.

use crate::model::Energy;

/// The energy of a state, the part of overlaps in it, and the coordinates that contact forces push; not valid for any state if the vectors
/// of the state are empty.
#[derive(Clone, Debug, Default)]
pub(super) struct CachedEnergy {
    of: [Vec<f64>; 2],
    pub(super) energy: Energy,
    pub(super) of_overlaps: f64,
    pub(super) is_pushed: Vec<bool>,
}

/// Those of two states, the latest first.
#[derive(Clone, Debug, Default)]
pub(super) struct CachedEnergies([CachedEnergy; 2]);

impl CachedEnergies {
    /// Those of a state, if they are known.
    pub(super) fn of(&self, state: [&[f64]; 2]) -> Option<&CachedEnergy> {
        if state[0].is_empty() {
            return None;
        }
        let is_it =
            |cached: &&CachedEnergy| cached.of.iter().zip(state).all(|(cached, values)| cached == values);
        self.0.iter().find(is_it)
    }

    /// Notes the energies of a state in place of the older ones; returns the memory for the coordinates that are pushed in it.
    pub(super) fn store(&mut self, state: [&[f64]; 2], energy: Energy, of_overlaps: f64) -> &mut [bool] {
        self.0.swap(0, 1);
        let [latest, _] = &mut self.0;
        (latest.energy, latest.of_overlaps) = (energy, of_overlaps);
        for (cached, values) in latest.of.iter_mut().zip(state) {
            cached.clear();
            cached.extend_from_slice(values);
        }
        latest.is_pushed.clear();
        latest.is_pushed.resize(state[0].len(), false);
        &mut latest.is_pushed
    }

    pub(super) fn forget(&mut self) {
        self.0.iter_mut().flat_map(|cached| &mut cached.of).for_each(Vec::clear);
    }
}
