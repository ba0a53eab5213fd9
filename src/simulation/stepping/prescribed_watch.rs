//! Detects prescribed motions that fixed steps do not resolve. Prescribed coordinates and velocities are exact at the ends of steps, but
//! free coordinates are driven by the prescribed accelerations there alone. In a motion of only a few steps these do not integrate to its
//! displacement: a mass without friction on a rail that moves by one metre in n steps is dragged along by about 1/n^2 m.

use crate::analysis::spectrum::Spectrum;
use crate::error::Number;
use crate::integrators::newmark::Scheme;
use crate::model::Model;
use crate::numerics::tape::Tape;
use crate::simulation::balance::State;

/// A drag of more than this part of the range of a prescribed motion causes a warning: cubic moves of seven steps. So does a
/// remaining velocity of more than this part of the largest one, such as after moves that begin and end within steps with jumps of the
/// acceleration.
const LARGEST_DRAG: f64 = 2e-2;

/// Number of steps over which drags accumulate. Over longer times the small errors of resolved motions would accumulate too, which
/// springs and dampers remove.
const STEPS_OF_MEMORY: f64 = 16.0;

/// A prescribed coordinate, compared with the integration of its accelerations by the scheme.
#[derive(Clone, Copy, Debug, Default)]
struct PrescribedCoordinate {
    /// The coordinate with its first two derivatives.
    motion: [f64; 3],
    /// Errors of the integrated displacement and velocity.
    off: [f64; 2],
    lowest: f64,
    highest: f64,
    /// The largest error of the displacement.
    worst: f64,
    /// The largest error of the velocity.
    left: f64,
    fastest: f64,
}

/// All prescribed coordinates over a run with fixed steps.
#[derive(Clone, Debug)]
pub(super) struct PrescribedWatch {
    dt: f64,
    weights: [f64; 2],
    t: f64,
    coordinates: Vec<PrescribedCoordinate>,
    now: Vec<[f64; 3]>,
}

impl PrescribedWatch {
    /// `None` if nothing is prescribed, or nothing is free.
    pub(super) fn new<M: Model>(
        model: &mut M,
        State { t, .. }: State<'_>,
        scheme: Scheme,
        dt: f64,
    ) -> Option<Self> {
        let facts = model.facts();
        if !facts.is_carried || facts.n == 0 || model.set_time(t).is_err() {
            return None;
        }
        let mut now = Vec::new();
        model.prescribed(&mut now);
        let at = |&motion: &[f64; 3]| PrescribedCoordinate {
            motion,
            lowest: motion[0],
            highest: motion[0],
            fastest: motion[1].abs(),
            ..PrescribedCoordinate::default()
        };
        let coordinates = now.iter().map(at).collect();
        Some(Self { dt, weights: scheme.smooth_weights(), t, coordinates, now })
    }

    /// Records the prescribed coordinates after a step, at the time that is set in the model.
    pub(super) fn step<M: Model>(&mut self, model: &mut M, t: f64) {
        let h = t - std::mem::replace(&mut self.t, t);
        let ([beta, gamma], kept) = (self.weights, (-h / (STEPS_OF_MEMORY * self.dt)).exp());
        self.now.clear();
        model.prescribed(&mut self.now);
        for (coordinate, &now) in self.coordinates.iter_mut().zip(&self.now) {
            let PrescribedCoordinate {
                motion,
                off: [place, velocity],
                lowest,
                highest,
                worst,
                left,
                fastest,
            } = coordinate;
            let [before, here] = [*motion, now];
            let way = h * before[1] + h * h * ((0.5 - beta) * before[2] + beta * here[2]);
            let gain = h * ((1.0 - gamma) * before[2] + gamma * here[2]);
            *place = kept * (*place + h * *velocity) + way - (here[0] - before[0]);
            *velocity = kept * *velocity + gain - (here[1] - before[1]);
            (*lowest, *highest) = (lowest.min(here[0]), highest.max(here[0]));
            (*worst, *left) = (worst.max(place.abs()), left.max(velocity.abs()));
            *fastest = fastest.max(here[1].abs());
            *motion = here;
        }
    }

    /// Continues after a jump of prescribed coordinates.
    pub(super) fn jump<M: Model>(&mut self, model: &mut M) {
        self.now.clear();
        model.prescribed(&mut self.now);
        for (coordinate, now) in self.coordinates.iter_mut().zip(&self.now) {
            coordinate.motion = *now;
        }
    }

    /// Why the motion may be wrong, if free coordinates were dragged far and no springs move them back.
    pub(super) fn verdict<M: Model>(&self, model: &mut M, end: State<'_>) -> Option<String> {
        let part = |coordinate: &PrescribedCoordinate| {
            let of = |off: f64, most: f64| if most > 0.0 { off / most } else { 0.0 };
            let range = coordinate.highest - coordinate.lowest;
            [of(coordinate.worst, range), of(coordinate.left, coordinate.fastest)]
        };
        let [dragged, left] = self
            .coordinates
            .iter()
            .map(part)
            .fold([0.0; 2], |[place, velocity], [p, v]| [f64::max(place, p), f64::max(velocity, v)]);
        if dragged.max(left) <= LARGEST_DRAG {
            return None;
        }
        // Vibrations that are faster than that return meanwhile.
        let spectrum = Spectrum::new(model, end.t, end.q, end.v)?;
        let slowest = spectrum.modes.iter().map(|mode| mode.frequency).fold(f64::INFINITY, f64::min);
        let [dragged, left] =
            [dragged, left].map(|off| off / (1.0 + (slowest * STEPS_OF_MEMORY * self.dt).powi(2)));
        let found = if dragged > LARGEST_DRAG {
            format!("is dragged along by up to {:.0} % of this motion", (100.0 * dragged).min(100.0))
        } else if left > LARGEST_DRAG {
            format!("keeps up to {:.0} % of its largest velocity", (100.0 * left).min(100.0))
        } else {
            return None;
        };
        Some(format!(
            "A prescribed motion lasts only a few steps of {} s, too few to resolve its accelerations: what moves freely behind it {found}. \
             Take steps of {:.1e} s or less, or method \"radau\".",
            Number(self.dt),
            self.dt * (LARGEST_DRAG / dragged).sqrt().min(LARGEST_DRAG / left)
        ))
    }

    /// Serialises all data that persist from step to step.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.t);
        for PrescribedCoordinate { motion, off, lowest, highest, worst, left, fastest } in
            &mut self.coordinates
        {
            tape.numbers(motion);
            tape.numbers(off);
            [lowest, highest, worst, left, fastest].into_iter().for_each(|number| tape.number(number));
        }
    }
}
