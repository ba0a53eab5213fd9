//! Springs to the world and taut elastic tendons of a shape. Their forces are unknowns beside the coordinates, because a deflection
//! determines the force of a stiff spring only up to rounding times stiffness.

use crate::analysis::normalised;
use crate::analysis::normalised::DISPLACEMENT_ROUNDING;
use crate::model::springs::{LengthTendons, Springs};
use crate::model::{Reached, Static};
use crate::numerics::linalg::{Matrix, bounded_least_squares, norm};

/// Forces balance without a tendon if the residual is below this part of their magnitudes: ten times the tolerance of equilibria.
const BALANCED_WITHOUT_TENDON: f64 = 1e-9;

/// Every motion that slackens a tendon stretches others if its row is a combination of theirs up to this part.
const DEPENDENT_ROW: f64 = 1e-9;

/// Springs and taut elastic tendons in a shape, in coordinates divided by their sizes.
pub(crate) struct Ties {
    /// All of them, springs first; `None` if there are none.
    pub(crate) all: Option<Springs>,
    of_world: Option<Springs>,
    springs: usize,
    /// All tendons; which of them are elastic and taut, and which are just taut and count as slack.
    tendons: LengthTendons,
    taut: Vec<usize>,
    slack: Vec<usize>,
}

impl Ties {
    /// Under a part of the loads, tensions do not follow from lengths: then no tendons are included.
    pub(crate) fn new(model: &mut dyn Static, q: &[f64], sizes: &[f64], load_factor: f64) -> Self {
        let (n, m) = (q.len(), model.facts().length_tendons);
        let mut tendons = LengthTendons::new(m, n);
        if m > 0 {
            model.linearise_length_tendons(q, &mut tendons);
        }
        tendons.jacobian.column_iter_mut().zip(sizes).for_each(|(mut column, size)| column *= *size);
        // A tendon that is slack by no more than rounding counts as taut at first; `slacken` decides.
        let pulls = |i: &usize| {
            let is_taut = tendons.excesses[*i] > -DISPLACEMENT_ROUNDING * tendons.spans[*i];
            is_taut && tendons.stiffness[*i].is_finite() && load_factor == 1.0
        };
        let taut = (0..m).filter(pulls).collect();
        let of_world = normalised::linearised(model, q, sizes);
        let springs = model.facts().springs;
        let mut ties = Self { all: None, of_world, springs, tendons, taut, slack: Vec::new() };
        ties.gather(n);
        ties
    }

    fn gather(&mut self, n: usize) {
        self.all.clone_from(&self.of_world);
        if self.taut.is_empty() {
            return;
        }
        let mut all = Springs::new(self.springs + self.taut.len(), n);
        if let Some(of_world) = &self.of_world {
            all.begin_with(of_world);
        }
        for (place, &i) in (self.springs..).zip(&self.taut) {
            all.jacobian.row_mut(place).copy_from(&self.tendons.jacobian.row(i));
            all.stretch(place, self.tendons.stiffness[i], self.tendons.excesses[i]);
        }
        self.all = Some(all);
    }

    /// Prescribes the forces of these in forces and tangents; constraints have these multipliers.
    pub(crate) fn hold(&self, model: &mut dyn Static, forces: &[f64], multipliers: &[f64]) {
        if self.springs > 0 {
            model.hold_springs(Some(&forces[..self.springs]));
        }
        self.hold_length_tendons(model, forces, multipliers);
    }

    fn hold_length_tendons(&self, model: &mut dyn Static, forces: &[f64], multipliers: &[f64]) {
        if self.holds_length_tendons() {
            model.hold_length_tendons(Some(&self.tensions(forces, multipliers)));
        }
    }

    pub(crate) fn release(&self, model: &mut dyn Static) {
        if self.springs > 0 {
            model.hold_springs(None);
        }
        if self.holds_length_tendons() {
            model.hold_length_tendons(None);
        }
    }

    pub(crate) fn has_taut(&self) -> bool {
        !self.taut.is_empty()
    }

    /// Tendons exactly at their lengths, with whether they count as slack or taut.
    pub(crate) fn reached(&self) -> Vec<Reached> {
        let LengthTendons { excesses, spans, .. } = &self.tendons;
        let is_rounding = |i: &usize| excesses[*i].abs() <= DISPLACEMENT_ROUNDING * spans[*i];
        let taut = self.taut.iter().copied().filter(is_rounding).map(Reached::Taut);
        self.slack.iter().copied().map(Reached::Slack).chain(taut).collect()
    }

    fn holds_length_tendons(&self) -> bool {
        !self.taut.is_empty() || !self.slack.is_empty()
    }

    /// Tensions of all tendons: of taut elastic ones by these forces, of inextensible ones by multipliers, which follow those of loops.
    pub(crate) fn tensions(&self, forces: &[f64], multipliers: &[f64]) -> Vec<f64> {
        let LengthTendons { stiffness, excesses, .. } = &self.tendons;
        let rigid = stiffness.iter().filter(|stiffness| stiffness.is_infinite()).count();
        let mut of_rigid = multipliers.iter().skip(multipliers.len().saturating_sub(rigid));
        let mut tensions: Vec<f64> = stiffness
            .iter()
            .zip(excesses)
            .map(|(stiffness, excess)| match stiffness.is_infinite() {
                true => of_rigid.next().copied().unwrap_or(0.0),
                false => stiffness * excess.max(0.0),
            })
            .collect();
        for (&i, force) in self.taut.iter().zip(forces.iter().skip(self.springs)) {
            tensions[i] = -force;
        }
        self.slack.iter().for_each(|&i| tensions[i] = 0.0);
        tensions
    }

    /// Removes tendons that are only just taut: if forces balance without them as well as with them, they do not resist motions to one
    /// side. Keeps tendons that cannot become slack without stretching others that are just taut. `residual` are the residual forces,
    /// `rounding` bounds of their rounding, `work` the magnitudes of all forces along each coordinate. Returns whether any was removed.
    pub(crate) fn slacken(
        &mut self,
        forces: &[f64],
        residual: &[f64],
        rounding: &[f64],
        work: &[f64],
    ) -> bool {
        let n = work.len();
        let LengthTendons { excesses, spans, jacobian, .. } = &self.tendons;
        // The residual without a tension, relative to the magnitudes of forces, along coordinates that change the tendon's length.
        let left = |i: usize, tension: f64| {
            let along = (0..n).filter(|&k| jacobian[(i, k)] != 0.0);
            let left = |k: usize| ((residual[k] - tension * jacobian[(i, k)]).abs() - rounding[k]).max(0.0);
            along.map(|k| if left(k) == 0.0 { 0.0 } else { left(k) / work[k] }).fold(0.0, f64::max)
        };
        // Joints alone may carry the tension: then its size follows only from its excess, not from the balance along coordinates.
        let is_weak = |i: usize, tension: f64| {
            let most = (0..n).filter(|&k| jacobian[(i, k)] != 0.0).map(|k| work[k]).fold(0.0, f64::max);
            tension * spans[i] <= BALANCED_WITHOUT_TENDON * most
        };
        let is_just_taut = |i: usize, tension: f64| {
            if excesses[i] <= DISPLACEMENT_ROUNDING * spans[i] {
                return left(i, tension) <= BALANCED_WITHOUT_TENDON.max(left(i, 0.0));
            }
            // Its tension alone would disturb the balance, or is negligible.
            let is_refuted =
                (0..n).any(|k| (tension * jacobian[(i, k)]).abs() > BALANCED_WITHOUT_TENDON * work[k]);
            left(i, tension) <= BALANCED_WITHOUT_TENDON && (is_refuted || is_weak(i, tension))
        };
        let of_taut = self.taut.iter().zip(forces.iter().skip(self.springs));
        let just: Vec<usize> =
            of_taut.filter(|(i, force)| is_just_taut(**i, -**force)).map(|(i, _)| *i).collect();
        let slackens = |i: usize| {
            let others: Vec<usize> = just.iter().copied().filter(|other| *other != i).collect();
            if others.is_empty() {
                return true;
            }
            let columns = Matrix::from_fn(n, others.len(), |k, j| jacobian[(others[j], k)]);
            let wanted: Vec<f64> = (0..n).map(|k| -jacobian[(i, k)]).collect();
            let bounds = [vec![0.0; others.len()], vec![f64::INFINITY; others.len()]];
            let found = bounded_least_squares(&columns, &wanted, &bounds[0], &bounds[1]);
            let left = columns * nalgebra::DVector::from(found) - nalgebra::DVector::from(wanted.clone());
            left.norm() > DEPENDENT_ROW * norm(&wanted)
        };
        let slack: Vec<usize> = just.iter().copied().filter(|&i| slackens(i)).collect();
        let is_any = !slack.is_empty();
        self.taut.retain(|i| !slack.contains(i));
        self.slack.extend(slack);
        self.gather(n);
        is_any
    }
}
