//! Properties of a model that do not change during a run.

use super::SectionPlace;
use crate::error::InvalidInput;

/// Facts of a model: values that no state, time or input changes. A model makes them once, when it is built.
///
/// A model of one's own begins with [`Facts::smooth`] and names what is different:
///
/// ```
/// use lissom::model::Facts;
///
/// let facts = Facts { is_damped: false, typical_coordinates: vec![1.0, 0.3], ..Facts::smooth(2, 0.3) };
/// assert_eq!((facts.n, facts.constraints(), facts.inputs()), (2, 0, 0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// Number of generalised coordinates.
    pub n: usize,
    /// Length of the model, in metres: the reference for relative errors of places.
    pub length: f64,
    /// Large changes of the coordinates, to compare coordinates of different units in error norms of runs: the same in all
    /// shapes, by the length of the whole model. They also determine the rounding errors of quantities computed from coordinates
    /// near zero. n numbers > 0; zero, unknown, only for [equations](Facts::of_equations).
    pub typical_coordinates: Vec<f64>,
    /// Whether each coordinate turns something: others only shift. n flags.
    pub turns: Vec<bool>,
    /// Index of the first component of each rotation vector among the coordinates. Integrators and their results keep rotation
    /// vectors no longer than pi.
    pub rotation_vectors: Vec<usize>,
    /// Numbers of coordinates of consecutive parts that move independently unless contacts or loops couple them, so that the tangent
    /// is block-sparse. Empty for a single part.
    pub parts: Vec<usize>,
    /// Whether a finite number of modes approximates infinitely many.
    pub is_discretised: bool,
    /// Typical size of each constraint's gap, > 0, in its unit: the length of the joined parts, or one for differences of cosines
    /// and for angles. The same in all shapes. One for each constraint.
    pub gap_sizes: Vec<f64>,
    /// Whether the last constraints are one-sided: `g <= 0` with non-negative multipliers. Inactive ones have zero gaps, zero rows
    /// of the Jacobian and zero multipliers.
    pub is_one_sided: bool,
    /// Whether the model has contacts, whose forces set in abruptly, so that very fast vibrations must be damped.
    pub has_contact: bool,
    /// Whether rods take part in contacts: their impacts last as long as waves along them, and there are many of them.
    pub has_rods_in_contact: bool,
    /// Whether a joint has stops, or a tendon has a stiffness and can become slack: one-sided springs.
    pub has_stops: bool,
    /// Whether some forces act only in part of the state space: contacts, joint stops, slack tendons, saturated motors.
    pub has_one_sided_forces: bool,
    /// Whether tendons have friction in bends: its work depends on the path, so that such forces have no potential.
    pub has_tendon_friction: bool,
    /// Whether joints, tendons or contacts have dry friction, whose forces change sign within a small range of velocities.
    pub has_dry_friction: bool,
    /// Time in seconds in which the weight that static friction holds accelerates a body to the velocity at which that friction has
    /// fallen; infinite without weight or contacts with static friction.
    pub sticking_time: f64,
    /// Whether forces other than material damping depend on velocities: drag, a current, a moving base. The
    /// stability of an equilibrium then follows from the whole linearised motion, because a current adds an
    /// unsymmetric part to the stiffness and a rotating base a negative part.
    pub has_velocity_forces: bool,
    /// False if [`Dynamics::dissipated_power`](super::Dynamics::dissipated_power) is always zero, so that a run need not integrate it.
    pub is_damped: bool,
    /// Whether strains are damped, by retardation times: steps that are short beside these end near where they begin.
    pub has_retardation: bool,
    /// False if [`Dynamics::supplied_power`](super::Dynamics::supplied_power) is always zero, so that a run need not integrate it.
    pub is_driven: bool,
    /// Whether the base or coordinates have prescribed motions.
    pub is_carried: bool,
    /// Whether the model depends on time explicitly, so that [`InTime::set_time`](super::InTime::set_time) must be called before
    /// any evaluation.
    pub varies_in_time: bool,
    /// Interval of time, in seconds, on which the model is defined; outside, its time-dependent parts are NaN.
    pub time_span: [f64; 2],
    /// Shortest period of the excitation, in seconds, apart from functions.
    pub shortest_period: f64,
    /// Whether functions of which only values are known may be part of the excitation.
    pub has_functions: bool,
    /// The default value of each input u.
    pub default_inputs: Vec<f64>,
    /// Number of forces of the springs to the world.
    pub springs: usize,
    /// Number of tendons of a commanded length, elastic and inextensible ones, without friction.
    pub length_tendons: usize,
    /// Sections whose inertia affects only the forces along rods; empty if other quantities depend on it, or
    /// if coordinates are prescribed.
    pub section_places: Vec<SectionPlace>,
    /// Number of leading segments whose lengths affect nothing except their rods: all segments, or none if
    /// other quantities depend on a length, such as the place of a load inside a rod.
    pub free_lengths: usize,
    /// What each closed loop joins, in words for messages.
    pub loops: Vec<String>,
    /// The same of loops that hold a chain that does not stretch taut, with its length.
    pub taut_loops: Vec<String>,
}

impl Facts {
    /// Up to this number of coordinates, steps are compiled separately for each number. With more, the model takes most of the time.
    pub const MOST_PLAIN: usize = 4;

    /// Facts of a model of `n` coordinates and a `length` in metres, whose generalised force is a smooth function of coordinates,
    /// velocities and accelerations, and of nothing else: no time, inputs, prescribed motions, constraints, contacts, stops or
    /// springs to the world. Coordinates are plain numbers of which one is a large change, and all may turn something. Forces may
    /// dissipate, have a potential otherwise, and depend on velocities only by damping and inertia.
    pub fn smooth(n: usize, length: f64) -> Self {
        Self {
            n,
            length,
            typical_coordinates: vec![1.0; n],
            turns: vec![true; n],
            rotation_vectors: Vec::new(),
            parts: Vec::new(),
            is_discretised: false,
            gap_sizes: Vec::new(),
            is_one_sided: false,
            has_contact: false,
            has_rods_in_contact: false,
            has_stops: false,
            has_one_sided_forces: false,
            has_tendon_friction: false,
            has_dry_friction: false,
            sticking_time: f64::INFINITY,
            has_velocity_forces: false,
            is_damped: true,
            has_retardation: true,
            is_driven: false,
            is_carried: false,
            varies_in_time: false,
            time_span: [f64::NEG_INFINITY, f64::INFINITY],
            shortest_period: f64::INFINITY,
            has_functions: true,
            default_inputs: Vec::new(),
            springs: 0,
            length_tendons: 0,
            section_places: Vec::new(),
            free_lengths: 0,
            loops: Vec::new(),
            taut_loops: Vec::new(),
        }
    }

    /// Facts of `n` equations of motion of which only the number is known: [`Facts::smooth`] of length one, with unknown typical
    /// coordinates.
    pub fn of_equations(n: usize) -> Self {
        Self { typical_coordinates: vec![0.0; n], ..Self::smooth(n, 1.0) }
    }

    /// Number of constraints m.
    pub fn constraints(&self) -> usize {
        self.gap_sizes.len()
    }

    /// Number of inputs u.
    pub fn inputs(&self) -> usize {
        self.default_inputs.len()
    }

    /// Names of what steps handle beside coordinates: constraints, contact, rotation vectors that become too long, and functions of
    /// time, whose corners end steps. If empty, steps skip all of it.
    pub fn watched(&self) -> Vec<&'static str> {
        let all = [
            (self.constraints() > 0, "closed loops or tendons that do not stretch"),
            (self.has_contact, "contact"),
            (self.varies_in_time, "functions of time"),
            (!self.rotation_vectors.is_empty(), "rotation vectors"),
        ];
        all.into_iter().filter(|(is_there, _)| *is_there).map(|(_, what)| what).collect()
    }

    /// Whether fixed steps use the short loop: few coordinates, and nothing else to [handle](Self::watched). Decided once, before the
    /// first step.
    pub fn has_plain_steps(&self) -> bool {
        (1..=Self::MOST_PLAIN).contains(&self.n) && self.watched().is_empty()
    }

    /// Rejects models with constraints, on behalf of a method that does not support them.
    pub fn check_untied(&self, what: &str) -> Result<(), InvalidInput> {
        if self.constraints() == 0 {
            return Ok(());
        }
        let (found, expected) = match self.is_one_sided {
            true => ("one with tendons that do not stretch", "tendons with a `stiffness`"),
            false => ("one with closed loops", "a robot without closed loops"),
        };
        Err(InvalidInput::new("model", found, format!("{expected}: {what} does not hold them yet")))
    }
}
