//! The parts of a model on which contact forces act in an impact. The energy that an impact loses is measured relative to theirs,
//! whatever else moves.

use super::{Energy, Model};

/// The parts that contact forces act on, and memory to find them.
#[derive(Clone, Debug, Default)]
pub struct CollidingParts {
    /// Whether each coordinate belongs to a part under contact forces; empty for a model of a single part.
    takes_part: Vec<bool>,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl CollidingParts {
    /// Finds the parts that contact forces act on at one of the ends of a step, at the time that is set: those of one end alone would leave
    /// others where they were, within surfaces that have moved.
    pub fn find<M: Model + ?Sized>(&mut self, model: &mut M, states: [[&[f64]; 2]; 2]) {
        self.takes_part.clear();
        let facts = model.facts();
        // Constraints transmit an impact to other parts.
        if facts.parts.len() < 2 || facts.constraints() > 0 {
            return;
        }
        self.takes_part.resize(facts.n, false);
        for state in states {
            model.mark_pushed(state, &mut self.takes_part);
        }
        let mut first = 0;
        for &size in &model.facts().parts {
            let part = &mut self.takes_part[first..first + size];
            if part.contains(&true) {
                part.fill(true);
            }
            first += size;
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
        // Contact has no kinetic energy, and need not be looked for.
        model.leave_contact(true);
        let Energy { kinetic, .. } = model.energy(q, &self.v);
        model.leave_contact(false);
        kinetic.min(whole)
    }

    /// The energy that these parts gain between two states; `whole` is the gain of all. The others are not under contact forces: what they
    /// gain needs no search for contacts.
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
        model.leave_contact(true);
        let [after, mixed] = [after, [&self.q, &self.v]].map(|[q, v]| model.energy(q, v).total());
        model.leave_contact(false);
        whole - (after - mixed)
    }
}
