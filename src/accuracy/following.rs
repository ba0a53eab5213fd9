//! Vibrations that the steps have to follow, and how long steps may be that do.
//!
//! An implicit method that damps what it steps over says nothing about it: two runs that step over the same vibration agree with each
//! other, and not with the truth. What can be seen of the tip is followed from the start, therefore, and the vibrations that can be are
//! known beforehand: those that the start sets off, and those that loads and a moving base do, by the linear response of each of them
//! to what drives the model.

use std::f64::consts::E;

use crate::error::Interrupted;
use crate::model::Model;
use crate::spectrum::{Spectrum, Vibration};

/// Vibrations whose tip moves by less than this part of the tolerance need not be resolved.
const VISIBLE: f64 = 0.1;

/// A step h of a vibration of the rate omega multiplies it by `exp(i omega h) (1 + e)` with `|e| = (omega h)^(p + 1) / c`: order p + 1 and
/// c, from the stability functions (Hairer and Wanner 1996, sections IV.3 and IV.10); that of DOP853 from its coefficients. Radau's error is
/// dissipation, that of DOP853 a phase.
const IMPLICIT_ERROR: (i32, f64) = (6, 7.2e3);
const EXPLICIT_ERROR: (i32, f64) = (9, 1.4e7);

/// Beyond these steps, times the frequency, the formulas do not hold.
const LONGEST_IMPLICIT: f64 = 1.5;
const LONGEST_EXPLICIT: f64 = 3.0;

/// Of the tolerance of a run each vibration gets this part.
const SHARE: f64 = 0.5;

/// DOP853 is stable for steps below 6.1 over the largest rate (Hairer and Wanner 1996, section IV.2); with room for a rate that grows.
pub(super) const EXPLICIT_STABILITY: f64 = 4.0;

/// The tip cannot be farther off than this, relative to the length.
pub(super) const FARTHEST: f64 = 2.0;

/// Looks at what drives the model over the whole time, at least, and of each of the parts between which something is known to happen; and no more
/// than so many in all.
const LOOKS: f64 = 2000.0;
const LOOKS_OF_A_PART: f64 = 4.0;
const MOST_LOOKS: usize = 20_000;

/// One vibration that is to be followed.
#[derive(Clone, Copy, Debug)]
struct Followed {
    /// In rad/s.
    frequency: f64,
    /// How far it moves the tip, relative to the length.
    reach: f64,
    /// Over how many radians its error adds up: of the whole time, or until it has died away.
    radians: f64,
}

/// What is to be followed.
#[derive(Clone, Debug)]
pub(super) struct Following {
    /// Those of each state that was looked at.
    vibrations: Vec<Vec<Followed>>,
    /// Longest step, in seconds, that passes over nothing that drives the model.
    of_drive: f64,
    /// The longest stable step of the explicit method: an error estimate lets longer ones pass that do harm in time.
    stable: f64,
    /// Of the first run.
    loosest: f64,
}

impl Following {
    /// Nothing.
    pub(super) fn nothing() -> Self {
        let unlimited = f64::INFINITY;
        Self { vibrations: Vec::new(), of_drive: unlimited, stable: unlimited, loosest: unlimited }
    }

    /// What the state `q0` sets off, with the vibrations about it, and what drives the model over `t_span`; as far as that is visible.
    /// `loosest` is the tolerance of the first run.
    pub(super) fn new<M: Model>(
        model: &mut M,
        t_span: (f64, f64),
        q0: &[f64],
        spectrum: &Spectrum,
        loosest: f64,
    ) -> Result<Self, Interrupted> {
        let of_drive = model.shortest_period() / LOOKS_OF_A_PART;
        let stable = EXPLICIT_STABILITY / spectrum.rate();
        let mut following = Self { vibrations: Vec::new(), of_drive, stable, loosest };
        let mut sizes: Vec<f64> = spectrum.modes.iter().map(|mode| mode.size).collect();
        if model.varies_in_time() {
            let drive = Drive::new(model, t_span, q0, spectrum, VISIBLE * loosest)?;
            for (size, driven) in sizes.iter_mut().zip(drive.sizes) {
                *size = size.max(driven);
            }
            following.of_drive = of_drive.min(drive.longest_step);
        }
        following.add(model, t_span.1 - t_span.0, q0, spectrum, &sizes);
        Ok(following)
    }

    /// What a state on the way has set off.
    pub(super) fn look<M: Model>(&mut self, model: &mut M, t: f64, duration: f64, [q, v]: [&[f64]; 2]) {
        if let Some(spectrum) = Spectrum::new(model, t, q, v) {
            let sizes: Vec<f64> = spectrum.modes.iter().map(|mode| mode.size).collect();
            self.add(model, duration, q, &spectrum, &sizes);
        }
    }

    fn add<M: Model>(&mut self, model: &mut M, duration: f64, q: &[f64], spectrum: &Spectrum, sizes: &[f64]) {
        let oscillates =
            |(mode, size): &(&Vibration, &f64)| mode.frequency > 0.0 && **size > 0.0 && !mode.is_overdamped();
        let followed = spectrum.modes.iter().zip(sizes).filter(oscillates).map(|(mode, &size)| {
            let reach = (mode.reach(model, q, size) / model.length()).min(FARTHEST);
            let life = 2.0 / (E * mode.damping.abs());
            Followed {
                frequency: mode.frequency,
                reach,
                radians: (mode.frequency * duration.min(life)).max(1.0),
            }
        });
        self.vibrations.push(followed.collect());
    }

    /// What steps of this size leave of all vibrations together, relative to the length: of those that are stepped over all of it is lost,
    /// in every run alike.
    pub(super) fn lost(&self, is_explicit: bool, step: f64) -> f64 {
        let (order, constant) = error_of_a_step(is_explicit);
        let part = |vibration: &Followed| {
            let of_a_radian = (vibration.frequency * step).powi(order - 1) / constant;
            vibration.reach * (vibration.radians * of_a_radian).min(1.0)
        };
        let of_state = |vibrations: &Vec<Followed>| vibrations.iter().map(part).sum();
        self.vibrations.iter().map(of_state).fold(0.0, f64::max)
    }

    /// The highest frequency, in rad/s, that is visible at this tolerance; zero if there is none.
    pub(super) fn highest(&self, tolerance: f64) -> f64 {
        self.visible(tolerance).map(|vibration| vibration.frequency).fold(0.0, f64::max)
    }

    /// The longest step, in seconds, with which no vibration leaves an error of more than its share of `tolerance`.
    pub(super) fn longest_step(&self, is_explicit: bool, tolerance: f64) -> f64 {
        let (order, constant) = error_of_a_step(is_explicit);
        let longest = if is_explicit { LONGEST_EXPLICIT } else { LONGEST_IMPLICIT };
        // Two runs must not have the same steps, whatever limits them: they would share the same errors.
        let power = 1.0 / f64::from(order - 1);
        let shorter = (tolerance / self.loosest).powf(power).min(1.0);
        let of_vibration = |vibration: &Followed| {
            let allowed = constant * SHARE * tolerance / (vibration.reach * vibration.radians);
            allowed.powf(power).min(longest * shorter) / vibration.frequency
        };
        let stable = if is_explicit { self.stable } else { f64::INFINITY };
        self.visible(tolerance).map(of_vibration).fold(self.of_drive.min(stable) * shorter, f64::min)
    }

    /// The same vibrations for all runs of a request, so that they can be compared.
    fn visible(&self, tolerance: f64) -> impl Iterator<Item = &Followed> {
        let visible = VISIBLE * tolerance.max(self.loosest);
        self.vibrations.iter().flatten().filter(move |vibration| vibration.reach > visible)
    }
}

/// See [`IMPLICIT_ERROR`].
fn error_of_a_step(is_explicit: bool) -> (i32, f64) {
    if is_explicit { EXPLICIT_ERROR } else { IMPLICIT_ERROR }
}

/// What loads and the motion of the base do to the vibrations about the start.
struct Drive {
    /// Largest modal amplitude of each vibration.
    sizes: Vec<f64>,
    /// See [`Following::of_drive`].
    longest_step: f64,
}

impl Drive {
    /// By the response of each vibration, without the others, to modal forces that are straight lines between the looks: exact.
    fn new<M: Model>(
        model: &mut M,
        (t0, t_end): (f64, f64),
        q0: &[f64],
        spectrum: &Spectrum,
        visible: f64,
    ) -> Result<Self, Interrupted> {
        let modes = &spectrum.modes;
        let softness: Vec<f64> = modes
            .iter()
            .map(|mode| {
                let of_one = mode.frequency.powi(-2);
                if of_one.is_finite() { mode.reach(model, q0, of_one) / model.length() } else { 0.0 }
            })
            .collect();
        let mut forces = Forces::new(q0.len());
        let mut motion: Vec<Oscillation> = modes.iter().map(Oscillation::new).collect();
        let (mut t, mut looks, mut longest_step) = (t0, 0, f64::INFINITY);
        let mut before = forces.at(model, modes, q0, t)?;
        while t < t_end && looks < MOST_LOOKS {
            let end = model.horizon(t).min(t_end);
            let number = (LOOKS * (end - t) / (t_end - t0)).ceil().max(LOOKS_OF_A_PART);
            let step = (end - t) / number;
            let mut part = vec![before];
            for i in 1..=number as usize {
                let here = forces.at(model, modes, q0, (t + step * i as f64).min(end))?;
                for ((oscillation, mode), (from, to)) in
                    motion.iter_mut().zip(modes).zip(part[i - 1].iter().zip(&here))
                {
                    oscillation.step(mode, step, [*from, *to]);
                }
                part.push(here);
            }
            looks += part.len();
            longest_step = longest_step.min(step * steps_of_change(&part, &softness, visible));
            before = part.pop().expect("there was one at the start");
            t = end;
        }
        Ok(Self { sizes: motion.into_iter().map(|oscillation| oscillation.largest).collect(), longest_step })
    }
}

/// Over how many looks the forces change by what they change at all within a part of the time, beside the straight line between its ends; infinite where that
/// would not be seen.
fn steps_of_change(part: &[Vec<f64>], softness: &[f64], visible: f64) -> f64 {
    let last = part.len() - 1;
    let mut fewest = f64::INFINITY;
    for (k, softness) in softness.iter().enumerate() {
        let aside = |i: usize| {
            let x = i as f64 / last as f64;
            part[i][k] - (1.0 - x) * part[0][k] - x * part[last][k]
        };
        let largest = (0..=last).map(|i| aside(i).abs()).fold(0.0, f64::max);
        let steepest = (0..last).map(|i| (aside(i + 1) - aside(i)).abs()).fold(0.0, f64::max);
        if largest * softness > visible {
            fewest = fewest.min(largest / steepest);
        }
    }
    fewest
}

/// Modal forces at the start.
struct Forces {
    rest: Vec<f64>,
    tau: Vec<f64>,
}

impl Forces {
    fn new(n: usize) -> Self {
        Self { rest: vec![0.0; n], tau: vec![0.0; n] }
    }

    fn at<M: Model>(
        &mut self,
        model: &mut M,
        modes: &[Vibration],
        q0: &[f64],
        t: f64,
    ) -> Result<Vec<f64>, Interrupted> {
        model.set_time(t)?;
        model.inverse_dynamics(q0, &self.rest, &self.rest, &mut self.tau);
        let along = |mode: &Vibration| -mode.shape.iter().zip(&self.tau).map(|(x, tau)| x * tau).sum::<f64>();
        Ok(modes.iter().map(along).collect())
    }
}

/// `x'' + c x' + w^2 x = f(t)`.
struct Oscillation {
    x: f64,
    v: f64,
    /// The largest amplitude about where the force would hold it.
    largest: f64,
}

impl Oscillation {
    fn new(mode: &Vibration) -> Self {
        Self { x: 0.0, v: mode.velocity, largest: 0.0 }
    }

    /// A step with a force that is a straight line.
    fn step(&mut self, mode: &Vibration, h: f64, [from, to]: [f64; 2]) {
        if mode.frequency == 0.0 || mode.is_overdamped() {
            return;
        }
        let (square, half) = (mode.frequency.powi(2), 0.5 * mode.damping);
        let slope = (to - from) / h / square;
        let lag = mode.damping / square * slope;
        let held = from / square - lag;
        let (x, v) = (self.x - held, self.v - slope);
        self.largest = self.largest.max(x.hypot(v / mode.frequency));
        let frequency = (square - half * half).sqrt();
        let (sine, cosine) = (frequency * h).sin_cos();
        let decay = (-half * h).exp();
        let sine = if frequency > 0.0 { sine / frequency } else { h };
        self.x = decay * (x * cosine + (v + half * x) * sine) + held + slope * h;
        self.v = decay * (v * cosine - (square * x + half * v) * sine) + slope;
    }
}
