//! The parts of a model on which contact forces act in an impact. The energy that an impact loses is measured relative to theirs,
//! whatever else moves.

use super::{Energy, Model};

/// The parts that contact forces act on, and memory to find them.
#[derive(Clone, Debug, Default)]
pub struct CollidingParts {
    with: Vec<f64>,
    without: Vec<f64>,
    /// Whether each coordinate belongs to a part under contact forces; empty for a model of a single part.
    takes_part: Vec<bool>,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl CollidingParts {
    /// Finds these parts in a motion in which surfaces touch, at the time that is set.
    pub fn find<M: Model + ?Sized>(&mut self, model: &mut M, [q, v, a]: [&[f64]; 3]) {
        self.takes_part.clear();
        let facts = model.facts();
        // Constraints transmit an impact to other parts.
        if facts.parts.len() < 2 || facts.constraints() > 0 {
            return;
        }
        let (n, a) = (q.len(), &a[..q.len()]);
        self.with.resize(n, 0.0);
        self.without.resize(n, 0.0);
        model.leave_contact(true);
        model.inverse_dynamics(q, v, a, &mut self.without);
        model.leave_contact(false);
        model.inverse_dynamics(q, v, a, &mut self.with);
        for &size in &model.facts().parts {
            let part = self.takes_part.len()..self.takes_part.len() + size;
            // Forces of parts without contact agree bit for bit.
            let is_colliding = self.with[part.clone()] != self.without[part];
            self.takes_part.resize(self.takes_part.len() + size, is_colliding);
        }
        if !self.takes_part.contains(&true) {
            self.takes_part.clear();
        }
    }

    /// The kinetic energy of these parts in a state; `whole` is that of the model.
    pub fn kinetic<M: Model + ?Sized>(&mut self, model: &mut M, [q, v]: [&[f64]; 2], whole: f64) -> f64 {
        if !self.takes_part.contains(&false) {
            return whole;
        }
        let own = v.iter().zip(&self.takes_part).map(|(&v, &takes_part)| if takes_part { v } else { 0.0 });
        self.v.clear();
        self.v.extend(own);
        let Energy { kinetic, .. } = model.energy(q, &self.v);
        kinetic.min(whole)
    }

    /// The energy that these parts gain between two states, with the others as in the first state; `whole` is the gain of all.
    pub fn gain<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        before: [&[f64]; 2],
        after: [&[f64]; 2],
        whole: f64,
    ) -> f64 {
        if !self.takes_part.contains(&false) {
            return whole;
        }
        for (mixed, (before, after)) in
            [&mut self.q, &mut self.v].into_iter().zip(before.into_iter().zip(after))
        {
            let ends = before.iter().zip(after).zip(&self.takes_part);
            mixed.clear();
            mixed
                .extend(ends.map(|((&before, &after), &takes_part)| if takes_part { after } else { before }));
        }
        let [before, mixed] = [before, [&self.q, &self.v]].map(|[q, v]| model.energy(q, v).total());
        mixed - before
    }
}
