//! Features of an excitation that steps must not pass over: jumps, short pulses, and oscillations.

use crate::error::Interrupted;

/// Samples belong to a change if the force changes between them at least at this part of its fastest rate.
const RATE_OF_CHANGE: f64 = 0.125;

/// Neighbouring changes with at most this number of other samples in between are one.
const SAMPLES_BETWEEN_CHANGES: usize = 2;

/// Changes that take more than this part of the whole time limit all steps; shorter ones only those within them.
const SHORT_CHANGE: f64 = 0.25;

/// Number of times that the remaining parts between changes are examined again; then their steps are limited.
const MAX_DEPTH: usize = 4;

/// A jump is located to this part of the whole time.
const JUMP_TOLERANCE: f64 = 1e-9;

/// Part of a change that an interval must contain to be halved again.
const CONTAINED_PART: f64 = 0.9;

/// Steps within a change that is too gradual to be a jump, but falls between two samples.
const STEPS_OF_AN_EDGE: usize = 4;

/// Largest number of times at which steps end; with more, the longest step is limited instead.
const MOST_ENDS: usize = 1000;

/// Modal forces at a time.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub(super) t: f64,
    pub(super) forces: Vec<f64>,
}

/// The features found so far.
pub(super) struct Features {
    /// Displacement of the tip under each unit modal force, in units of the smallest visible one.
    pub(super) weights: Vec<f64>,
    /// The whole time.
    pub(super) duration: f64,
    /// Longest step, in seconds, that misses no feature, if steps end at `ends`.
    pub(super) longest_step: f64,
    /// Increasing times at which steps must end.
    pub(super) ends: Vec<f64>,
}

/// How a modal force of some samples changes.
struct Change {
    /// The mode, and the largest change between two samples.
    mode: usize,
    steepest: f64,
    /// Time in which the force would run through its whole range at its fastest rate.
    longest_step: f64,
}

impl Features {
    /// Adds the features of a part of the time, given its equidistant samples; `at` evaluates others. Samples next to jumps are added
    /// to the given ones.
    pub(super) fn find(
        &mut self,
        part: &mut Vec<Sample>,
        at: &mut dyn FnMut(f64) -> Result<Sample, Interrupted>,
    ) -> Result<(), Interrupted> {
        let mut beside_jumps = Vec::new();
        self.examine(part, at, MAX_DEPTH, &mut beside_jumps)?;
        self.ends.sort_by(f64::total_cmp);
        self.ends.dedup();
        if self.ends.len() > MOST_ENDS {
            let shortest = self.ends.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
            self.longest_step = self.longest_step.min(shortest);
            self.ends.clear();
        }
        part.append(&mut beside_jumps);
        part.sort_by(|a, b| a.t.total_cmp(&b.t));
        // A jump at a sample has found this sample again.
        part.dedup_by(|a, b| a.t == b.t);
        Ok(())
    }

    fn examine(
        &mut self,
        part: &[Sample],
        at: &mut dyn FnMut(f64) -> Result<Sample, Interrupted>,
        depth: usize,
        beside_jumps: &mut Vec<Sample>,
    ) -> Result<(), Interrupted> {
        let Some(change) = self.fastest(part) else { return Ok(()) };
        let groups = change.groups(part);
        let together: f64 = groups.iter().map(|&(from, to)| part[to].t - part[from].t).sum();
        if depth == 0 || together > SHORT_CHANGE * self.duration {
            self.longest_step = self.longest_step.min(change.longest_step);
            return Ok(());
        }
        let mut first = 0;
        for (from, to) in groups {
            self.examine(&part[first..=from], at, depth - 1, beside_jumps)?;
            if to == from + 1 {
                self.locate([&part[from], &part[to]], change.mode, at, beside_jumps)?;
            } else {
                let group = &part[from..=to];
                let step = self.fastest(group).map_or(f64::INFINITY, |change| change.longest_step);
                self.end_between([group[0].t, group[group.len() - 1].t], step);
            }
            first = to;
        }
        self.examine(&part[first..], at, depth - 1, beside_jumps)
    }

    /// The fastest change of the samples; `None` if all forces are linear, which methods that stop at the ends of parts
    /// resolve, or if their deviation has no visible effect on the tip.
    fn fastest(&self, part: &[Sample]) -> Option<Change> {
        let last = part.len() - 1;
        let time = part[last].t - part[0].t;
        let mut fastest: Option<Change> = None;
        for (mode, weight) in self.weights.iter().enumerate() {
            let force = |i: usize| part[i].forces[mode];
            let line = |i: usize| force(0) + (force(last) - force(0)) * ((part[i].t - part[0].t) / time);
            let bend = (0..=last).map(|i| (force(i) - line(i)).abs()).fold(0.0, f64::max);
            let is_visible = bend * weight > 1.0;
            if !is_visible {
                continue;
            }
            let (lowest, highest) = (0..=last)
                .map(force)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            let steepest = (0..last).map(|i| (force(i + 1) - force(i)).abs()).fold(0.0, f64::max);
            let longest_step = time / last as f64 * (highest - lowest) / steepest;
            if fastest.as_ref().is_none_or(|fastest| longest_step < fastest.longest_step) {
                fastest = Some(Change { mode, steepest, longest_step });
            }
        }
        fastest
    }

    /// Bisects the interval between two samples that contains a change, until it is as short as a jump or the change takes all of
    /// it. Steps end at both of its ends.
    fn locate(
        &mut self,
        [from, to]: [&Sample; 2],
        mode: usize,
        at: &mut dyn FnMut(f64) -> Result<Sample, Interrupted>,
        beside_jumps: &mut Vec<Sample>,
    ) -> Result<(), Interrupted> {
        let (mut from, mut to) = (from.clone(), to.clone());
        let change = |from: &Sample, to: &Sample| (to.forces[mode] - from.forces[mode]).abs();
        let whole = change(&from, &to);
        let mut is_edge = false;
        while to.t - from.t > JUMP_TOLERANCE * self.duration && !is_edge {
            let middle = at(0.5 * (from.t + to.t))?;
            if change(&from, &middle) >= CONTAINED_PART * whole {
                to = middle;
            } else if change(&middle, &to) >= CONTAINED_PART * whole {
                from = middle;
            } else {
                is_edge = true;
            }
        }
        let step = if is_edge { (to.t - from.t) / STEPS_OF_AN_EDGE as f64 } else { f64::INFINITY };
        self.end_between([from.t, to.t], step);
        beside_jumps.extend([from, to]);
        Ok(())
    }

    /// Steps end at two times, and in between after at most this time.
    fn end_between(&mut self, [from, to]: [f64; 2], step: f64) {
        let number = ((to - from) / step).ceil().max(1.0);
        self.ends.extend((0..=number as usize).map(|i| from + (to - from) * (i as f64 / number)));
    }
}

impl Change {
    /// The first and the last sample of each interval in which the force changes.
    fn groups(&self, part: &[Sample]) -> Vec<(usize, usize)> {
        let mut groups: Vec<(usize, usize)> = Vec::new();
        for i in 1..part.len() {
            let by = (part[i].forces[self.mode] - part[i - 1].forces[self.mode]).abs();
            if by < RATE_OF_CHANGE * self.steepest {
                continue;
            }
            match groups.last_mut() {
                Some((_, to)) if i - 1 <= *to + SAMPLES_BETWEEN_CHANGES => *to = i,
                _ => groups.push((i - 1, i)),
            }
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const SAMPLES: usize = 500;

    /// Features of a force from 0 to 1 s that is visible above `visible`.
    fn features(force: impl Fn(f64) -> f64, visible: f64) -> Features {
        let mut features = Features {
            weights: vec![1.0 / visible],
            duration: 1.0,
            longest_step: f64::INFINITY,
            ends: Vec::new(),
        };
        let mut at = |t: f64| Ok(Sample { t, forces: vec![force(t)] });
        let mut part: Vec<Sample> =
            (0..=SAMPLES).map(|i| at(i as f64 / SAMPLES as f64).expect("it never stops")).collect();
        features.find(&mut part, &mut at).expect("it never stops");
        assert!(part.is_sorted_by(|a, b| a.t < b.t));
        features
    }

    #[test]
    fn a_jump_is_located_and_steps_elsewhere_are_as_long_as_they_like() {
        let place = 0.3_f64.sqrt();
        let Features { longest_step, ends, .. } = features(|t| if t < place { 0.0 } else { 1.0 }, 1e-3);
        assert_eq!(longest_step, f64::INFINITY);
        assert_eq!(ends.len(), 2);
        assert!(ends[0] < place && place <= ends[1] && ends[1] - ends[0] <= JUMP_TOLERANCE);
    }

    #[test]
    fn jumps_at_samples_are_located_too() {
        for place in [0.25, 0.5] {
            let found = features(|t| if t < place { 0.0 } else { 1.0 }, 1e-3);
            assert_eq!((found.ends.len(), found.ends[1]), (2, place));
            let found = features(|t| if t <= place { 0.0 } else { 1.0 }, 1e-3);
            assert_eq!((found.ends.len(), found.ends[0]), (2, place));
        }
    }

    #[test]
    fn several_jumps_beside_a_ramp_are_all_located() {
        let places = [0.1234, 0.4321, 0.8765];
        let force = |t: f64| 0.1 * t + places.iter().filter(|&&place| t >= place).count() as f64;
        let found = features(force, 1e-3);
        assert_eq!(found.longest_step, f64::INFINITY);
        for place in places {
            assert!(
                found.ends.windows(2).any(|pair| pair[0] < place
                    && place <= pair[1]
                    && pair[1] - pair[0] < 2.0 * JUMP_TOLERANCE)
            );
        }
    }

    #[test]
    fn an_edge_between_two_samples_is_followed_by_steps_within_it() {
        let force = |t: f64| 0.5 + 0.5 * ((t - 0.30123) / 1e-5).tanh();
        let Features { longest_step, ends, .. } = features(force, 1e-3);
        assert_eq!(longest_step, f64::INFINITY);
        let within = ends.iter().filter(|&&t| (t - 0.30123).abs() < 1e-4).count();
        assert!((4..20).contains(&within), "{within}");
    }

    #[test]
    fn a_short_pulse_limits_steps_within_it_alone() {
        let force =
            |t: f64| if (0.6..0.65).contains(&t) { (TAU * (t - 0.6) / 0.05).sin().powi(2) } else { 0.0 };
        let Features { longest_step, ends, .. } = features(force, 1e-3);
        assert_eq!(longest_step, f64::INFINITY);
        assert!(ends.iter().all(|t| (0.59..0.66).contains(t)));
        let longest = ends.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!((0.001..0.02).contains(&longest), "{longest}");
    }

    #[test]
    fn an_oscillation_limits_all_steps_and_a_straight_line_none() {
        let waves = features(|t| (TAU * 5.0 * t).sin(), 1e-3);
        assert!(waves.ends.is_empty());
        assert!((0.02..0.1).contains(&waves.longest_step), "{}", waves.longest_step);
        let line = features(|t| 3.0 - 2.0 * t, 1e-3);
        assert!(line.ends.is_empty() && line.longest_step == f64::INFINITY);
        let unseen = features(|t| if t < 0.5 { 0.0 } else { 1.0 }, 2.0);
        assert!(unseen.ends.is_empty() && unseen.longest_step == f64::INFINITY);
    }
}
