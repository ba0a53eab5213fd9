//! What takes long to compute from a description, kept for the few that were used last: a shape is checked, compiled and explained from its
//! description, which is plain data.

use std::sync::{Arc, Mutex, PoisonError};

/// Number of results that are kept: the shapes of a robot and of its variants.
const KEPT: usize = 4;

/// Results by what they were computed from, the last one at the end.
pub(super) struct Recent<K, V>(Mutex<Vec<(K, Arc<V>)>>);

impl<K: PartialEq + Clone, V> Recent<K, V> {
    pub(super) const fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// The result for this key. Two threads that ask for a new one at once may both compute it.
    pub(super) fn get(&self, key: &K, make: impl FnOnce() -> V) -> Arc<V> {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut known = known();
            if let Some(place) = known.iter().position(|(other, _)| other == key) {
                let found = known.remove(place);
                let value = found.1.clone();
                known.push(found);
                return value;
            }
        }
        let made = Arc::new(make());
        let mut known = known();
        if known.len() >= KEPT {
            known.remove(0);
        }
        known.push((key.clone(), made.clone()));
        made
    }
}
