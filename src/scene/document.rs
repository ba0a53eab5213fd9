//! The structure of a scene file: plain structs, from which the JSON Schema, the reader and the documentation of
//! every key are derived. Descriptions end up in editors, so they name units and defaults.
//! Stand-ins for required keys that could not be read let the rest of the file be checked.

use super::written::Written;
use crate::description::body::described::Body;
use crate::description::rod::described::Segment;
use crate::description::schema::{
    AnyPart as _, Data, Described, Field, Item, Kind, Limits, Part, Reader, Schema, Value,
};
use crate::description::signal::Signal;
use crate::description::world::described::BaseMotion;
use crate::robot::described;
use crate::robot::effects::actuator::described::{ActiveStrain, Chamber, Motor, Tendon};
use crate::robot::effects::contact::described::Contact;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::described::Load;
use crate::robot::effects::loops::described::Loop;
use crate::robot::effects::magnet::described::Magnet;
use crate::robot::effects::support::described::Support;

/// The only version of the format so far.
pub(super) const VERSION: usize = 1;

/// A lissom scene: one rod, one robot or one spring pendulum, and how to simulate it. SI units, angles in radians.
#[derive(Clone, Debug, PartialEq, Described)]
pub(super) struct Document {
    /// Version of the format: 1.
    // Checked on the raw table, before anything else is read.
    pub(super) version: usize,
    /// Data shared by all bodies.
    #[part(default)]
    pub(super) scene: General,
    /// The rod. Written as an array of tables; one per scene for now.
    #[part(default)]
    pub(super) rod: Vec<Rod>,
    /// A file with links of a robot, which precede those of this scene.
    pub(super) import: Option<Import>,
    /// The links of a robot, instead of a rod: parents before their children.
    #[part(default)]
    pub(super) link: Vec<Link>,
    /// Closed loops: additional joints between two links, or a link and the world.
    #[part(default, key = "loop")]
    pub(super) r#loop: Vec<Written<Loop>>,
    /// Pairs of surfaces of the rod, of links or of obstacles, which press on each other where they overlap.
    #[part(default)]
    pub(super) contact: Vec<Written<Contact>>,
    /// Motion of everything fixed to the world, about the frame of the first link's joint. Default: it is at rest.
    pub(super) base_motion: Option<Written<BaseMotion>>,
    /// Fluid around the rods and bodies of a robot. Default: none.
    pub(super) fluid: Option<Written<Fluid>>,
    /// Tendons that pull along their paths, on the rod or between the links of a robot.
    #[part(default)]
    pub(super) tendon: Vec<Written<Tendon>>,
    /// Fluidic chambers along rods.
    #[part(default)]
    pub(super) chamber: Vec<Written<Chamber>>,
    /// Motors on the joints of a robot.
    #[part(default)]
    pub(super) motor: Vec<Written<Motor>>,
    /// Actuated reference strains, such as muscles.
    #[part(default)]
    pub(super) active_strain: Vec<Written<ActiveStrain>>,
    /// A spring pendulum, instead of a rod.
    pub(super) pendulum: Option<Pendulum>,
    /// Duration, method and output of the simulation.
    #[part(stand_in = Simulation::stand_in)]
    pub(super) simulation: Simulation,
}

/// Data shared by all bodies.
#[derive(Clone, Debug, Default, PartialEq, Described)]
pub(super) struct General {
    /// Name of the scene, shown in reports. Default: the name of the file.
    pub(super) name: Option<String>,
    /// Gravity in the world, in m/s^2. Default: [0, 0, -9.81].
    pub(super) gravity: Option<[f64; 3]>,
    /// Uniform magnetic field in the world, in tesla, at magnets and magnetised segments. Default: [0, 0, 0].
    #[part(default)]
    pub(super) field: Signal<3>,
}

impl General {
    /// Whether a place in the description of a model is one of these keys, or lies in it.
    pub(super) fn has(place: &str) -> bool {
        place.split(['.', '[']).next().is_some_and(|key| Self::SCHEMA.index(key).is_some())
    }

    /// The given keys that a pendulum does not take, with what is wrong and what would be right.
    pub(super) fn unknown_to_pendulums(&self) -> impl Iterator<Item = (&str, &str, &str)> {
        let (gravity, field) = (self.gravity.is_some(), !self.field.is_zero());
        let gravity = gravity.then_some((
            "gravity",
            "a pendulum does not use it",
            "give the number pendulum.gravity instead",
        ));
        let right = "remove it, or simulate a rod or a robot";
        gravity.into_iter().chain(field.then_some(("field", "a pendulum is not magnetic", right)))
    }
}

/// A rod that is clamped at its base: a sequence of segments with loads and rigid bodies.
#[derive(Clone, Debug, PartialEq, Described)]
pub(super) struct Rod {
    /// Pose of the clamped end.
    #[part(default)]
    pub(super) base: Base,
    /// Motion of the base relative to this pose, as a function of time. Default: it is fixed.
    pub(super) base_motion: Option<Written<BaseMotion>>,
    /// Dead force at the tip, in world axes, in newtons. Default: [0, 0, 0].
    #[part(default)]
    pub(super) tip_force: [f64; 3],
    /// Dead moment at the tip, in world axes, in newton metres. Default: [0, 0, 0].
    #[part(default)]
    pub(super) tip_moment: [f64; 3],
    /// Point mass at the tip, in kilograms. Default: 0.
    #[part(default)]
    pub(super) tip_mass: f64,
    /// Additional forces and moments, anywhere on the rod.
    #[part(default)]
    pub(super) load: Vec<Written<Load>>,
    /// Additional rigid bodies, anywhere on the rod.
    #[part(default)]
    pub(super) body: Vec<Written<Body>>,
    /// Springs and dampers to the world, anywhere on the rod.
    #[part(default)]
    pub(super) support: Vec<Written<Support>>,
    /// Magnetic dipoles, anywhere on the rod.
    #[part(default)]
    pub(super) magnet: Vec<Written<Magnet>>,
    /// Fluid around the rod. Default: none.
    pub(super) fluid: Option<Written<Fluid>>,
    /// Initial generalised coordinates, one per mode: segment by segment, in the order torsion, bend_y, bend_z,
    /// stretch, shear_y, shear_z, then by degree. Default: all zero, the stress-free rod.
    pub(super) q0: Option<Vec<f64>>,
    /// Initial generalised velocities, in the order of q0. Default: at rest.
    pub(super) v0: Option<Vec<f64>>,
    /// Segments from base to tip; each one starts where the previous one ends.
    #[part(stand_in = || Value::List(Vec::new()))]
    pub(super) segment: Vec<Written<Segment>>,
}

/// Links of a robot from a file. Unsupported content is listed when the scene is read.
#[derive(Clone, Debug, PartialEq, Described)]
pub(super) struct Import {
    /// A URDF file, relative to the folder of the scene.
    #[part(stand_in = || Value::Text("robot.urdf".to_owned()))]
    pub(super) urdf: String,
    /// Whether the root link moves freely. Default: false, it is welded to the world.
    #[part(default)]
    pub(super) floating: bool,
    /// Stiffness of the stops at joint limits, in N m/rad or N/m. Default: limits are not imported.
    #[part(positive)]
    pub(super) limit_stiffness: Option<f64>,
    /// Whether impossible moments of inertia are replaced by the nearest possible ones. Default: false, they are an error.
    #[part(default)]
    pub(super) mend_inertia: bool,
    /// Initial coordinates of the joints, in the order of the robot's coordinates. Default: all zero.
    pub(super) q0: Option<Vec<f64>>,
    /// Initial velocities, the derivatives of the coordinates. Default: at rest.
    pub(super) v0: Option<Vec<f64>>,
}

/// A link with the tables below it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Link {
    pub(super) described: Written<described::Link>,
    pub(super) below: BelowLink,
}

/// The tables below a link.
#[derive(Clone, Debug, PartialEq, Described)]
pub(super) struct BelowLink {
    /// Further rigid bodies, fixed to the link; at is an arc length of its rod.
    #[part(default)]
    pub(super) fixed_body: Vec<Written<Body>>,
    /// Forces and moments on the link; at and along are arc lengths of its rod.
    #[part(default)]
    pub(super) load: Vec<Written<Load>>,
    /// Springs and dampers between the link and the world; at is an arc length of its rod.
    #[part(default)]
    pub(super) support: Vec<Written<Support>>,
    /// Magnetic dipoles on the link; at is an arc length of its rod.
    #[part(default)]
    pub(super) magnet: Vec<Written<Magnet>>,
    /// Initial coordinates of the link: those of the joint, then the modes of the rod. Default: all zero.
    pub(super) q0: Option<Vec<f64>>,
    /// Initial velocities, the derivatives of the link's coordinates. Default: at rest.
    pub(super) v0: Option<Vec<f64>>,
}

/// The keys of a link in scenes: first those of its description.
static LINK: Schema = Schema { fields: &LINK_FIELDS, ..*described::Link::SCHEMA };
static LINK_FIELDS: [Field; DESCRIBED + BELOW] = {
    let (described, below) = (described::Link::SCHEMA.fields, BelowLink::SCHEMA.fields);
    let mut all = [described[0]; DESCRIBED + BELOW];
    let mut i = 0;
    while i < DESCRIBED + BELOW {
        all[i] = if i < DESCRIBED { described[i] } else { below[i - DESCRIBED] };
        i += 1;
    }
    all
};
const DESCRIBED: usize = described::Link::SCHEMA.fields.len();
const BELOW: usize = BelowLink::SCHEMA.fields.len();

impl Item for Link {}

impl Data for Link {
    const KIND: Kind = Kind::Part(&LINK);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        let mut values = reader.open(&LINK, value)?;
        let below = BelowLink::of_fields(&values.split_off(DESCRIBED), reader)?;
        let given =
            LINK_FIELDS.iter().zip(values).filter_map(|(field, value)| Some((field.name.into(), value?)));
        Some(Self { described: Written::new(Value::Table(given.collect())), below })
    }

    fn check(&self, _: &Limits, _: &mut Reader) {}

    fn write(&self) -> Value {
        let Value::Table(mut pairs) = self.described.write() else { return Value::None };
        let below = BelowLink::SCHEMA.fields.iter().enumerate();
        pairs.extend(below.map(|(i, field)| (field.name.into(), self.below.field(i))));
        Value::Table(pairs)
    }
}

/// Pose of a clamped end.
#[derive(Clone, Debug, PartialEq, Described)]
pub(super) struct Base {
    /// Position in the world, in metres. Default: [0, 0, 0].
    #[part(default)]
    pub(super) position: [f64; 3],
    /// Orientation: unit quaternion [w, x, y, z] that turns body axes into world axes; the rod leaves along its
    /// body x axis. Default: [1, 0, 0, 0], along world x.
    #[part(default = [1.0, 0.0, 0.0, 0.0])]
    pub(super) orientation: [f64; 4],
}

impl Default for Base {
    fn default() -> Self {
        Self { position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0] }
    }
}

/// A point mass on a massless spring that swings in a vertical plane.
#[derive(Clone, Debug, PartialEq, Described)]
pub(super) struct Pendulum {
    /// Length of the unstretched spring, in metres. Default: 1.
    #[part(positive)]
    pub(super) length: Option<f64>,
    /// Mass in kilograms. Default: 1.
    #[part(positive)]
    pub(super) mass: Option<f64>,
    /// Stiffness of the spring in N/m. Default: 10.
    #[part(positive)]
    pub(super) stiffness: Option<f64>,
    /// Gravity along -y, in m/s^2. Default: 9.81.
    pub(super) gravity: Option<f64>,
    /// Initial state: [angle from +x counter-clockwise in radians, elongation in metres]. Default: [0, 0].
    pub(super) q0: Option<[f64; 2]>,
    /// Initial velocities, in the order of q0. Default: at rest.
    pub(super) v0: Option<[f64; 2]>,
}

/// Duration, method and output of the simulation.
#[derive(Clone, Debug, PartialEq, Described)]
pub(super) struct Simulation {
    /// End of the simulation, in seconds.
    #[part(stand_in = || Value::Number(1.0))]
    pub(super) t_end: f64,
    /// Start of the simulation, in seconds. Default: 0.
    #[part(default)]
    pub(super) t0: f64,
    /// Time integrator. Default: "newmark". With a fixed step dt: "newmark", the average acceleration, which conserves energy;
    /// "hht" and "generalised_alpha", which damp vibrations that the step does not resolve. Adaptive: "rk45" and "dop853",
    /// explicit Runge-Kutta methods of orders 5 and 8; "radau", implicit, for stiff models; "auto", whichever suits the model,
    /// with the accuracy rtol. "quasi_static": equilibria under what changes slowly, with friction and damping, without inertia, in steps of dt.
    #[part(default)]
    pub(super) method: Method,
    /// Step size of the methods with a fixed step, in seconds. Default: 0.01. The other methods are adaptive.
    #[part(positive)]
    pub(super) dt: Option<f64>,
    /// Jacobian of the equations of a fixed step. Default: "analytic".
    #[part(default)]
    pub(super) jac: Jacobian,
    /// Relative tolerance: of an adaptive step's error, of Newton's iteration within a fixed step. Default: 1e-6. With
    /// method "auto" the accuracy that is wanted, the largest error of the tip relative to the length of the model.
    /// Default then: 1e-4.
    #[part(non_negative)]
    pub(super) rtol: Option<f64>,
    /// Absolute tolerance, for values near zero. By default 1e-9 for errors of adaptive steps, and in fixed steps what moves coordinates by
    /// rounding alone, in any units. Not with method "auto".
    #[part(non_negative)]
    pub(super) atol: Option<f64>,
    /// Output of the run.
    #[part(default)]
    pub(super) output: Output,
}

impl Simulation {
    fn stand_in() -> Value {
        Value::Table(vec![("t_end".into(), Value::Number(1.0))])
    }
}

/// Time integrator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Described)]
pub enum Method {
    /// Newmark's implicit average-acceleration method with a fixed step: unconditionally stable, conserves energy.
    #[default]
    Newmark,
    /// Implicit method of Hilber, Hughes and Taylor with a fixed step: damps vibrations that the step does not resolve.
    Hht,
    /// Implicit generalised-alpha method with a fixed step: damps unresolved vibrations, and the slow motion less than "hht".
    GeneralisedAlpha,
    /// Adaptive explicit Runge-Kutta pair of orders 5 and 4 (Dormand and Prince).
    Rk45,
    /// Adaptive explicit Runge-Kutta method of order 8 (Dormand and Prince).
    Dop853,
    /// Adaptive implicit Runge-Kutta method Radau IIA of order 5, for stiff models.
    Radau,
    /// Equilibria under what changes slowly, without inertia, with a fixed step.
    QuasiStatic,
    /// DOP853 or Radau, whichever suits the model, with the accuracy rtol.
    Auto,
}

impl Method {
    /// True when all steps have the size that the scene gives.
    pub fn has_fixed_step(self) -> bool {
        matches!(self, Self::Newmark | Self::Hht | Self::GeneralisedAlpha | Self::QuasiStatic)
    }
}

/// Where the Jacobian of an implicit step comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Described)]
pub enum Jacobian {
    /// The model's exact tangent.
    #[default]
    Analytic,
    /// Forward differences.
    Forward,
    /// Central differences.
    Central,
}

/// Output of the run.
#[derive(Clone, Debug, Default, PartialEq, Described)]
pub(super) struct Output {
    /// Interval of the output times, in seconds. Default: the simulation's dt.
    #[part(positive)]
    pub(super) dt: Option<f64>,
    /// Quantities written besides the coordinates: any of "velocity", "acceleration", "energy", "shape".
    /// Default: all of them.
    pub(super) quantities: Option<Vec<Quantity>>,
}

/// A quantity in results besides the coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Described)]
pub enum Quantity {
    /// Generalised velocities.
    Velocity,
    /// Generalised accelerations.
    Acceleration,
    /// The energies and what damping dissipated.
    Energy,
    /// The rod's centre line.
    Shape,
}

impl Item for Quantity {}
