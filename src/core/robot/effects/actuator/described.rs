//! Actuators as users describe them: on links and joints with these names.

use super::along_rod::AlongRod;
use super::{Drive, MotorCommand, Strain};
use crate::description::schema::{Described, LinkName, Reader};
use crate::description::signal::Signal;
use crate::error::Number;

/// A part of a path that is embedded in a rod.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(positional = 3, called = "a part along a rod", check = Along::fits)]
pub struct Along {
    /// The link; optional if there is only one.
    pub link: Option<LinkName>,
    /// Offset (y, z) from the rod's axis in the plane of the section. It may lie outside the section, as with guide disks.
    /// Each of y and z is a number; two numbers, interpolated linearly between the ends of the part; or a table of stations
    /// and values, or in Python a callable or a `Profile`, over the arc length of the link's rod.
    #[part(unit = "metres", default = [AlongRod::Constant(0.0), AlongRod::Constant(0.0)])]
    pub offset: [AlongRod; 2],
    /// Arc lengths of the unstretched rod between which the part runs; by default the whole rod.
    #[part(arc_length)]
    pub along: Option<[f64; 2]>,
}

impl Along {
    fn fits(&self, reader: &mut Reader) {
        self.along.iter().for_each(|along| reader.check_interval("along[1]", *along));
    }
}

/// A point that a tendon passes through. It runs straight from the previous part and to the next one.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(positional = 3, called = "a point")]
pub struct Via {
    /// Link that carries the point. Without one the point is on the rod if there are no links, and otherwise in the world,
    /// where it does not move with the base.
    #[part(explicit)]
    pub link: Option<LinkName>,
    /// Position in the axes of the body, of the rod's section, or of the world.
    #[part(unit = "metres")]
    pub point: [f64; 3],
    /// Arc length of the rod's section; by default the tip, or the body of a rigid link.
    #[part(unit = "metres")]
    pub at: Option<f64>,
}

/// A part of the path of a tendon.
#[derive(Clone, Debug, PartialEq, Described)]
pub enum PathPart {
    /// Embedded in a rod.
    Along(Along),
    /// A point.
    Via(Via),
}

/// A cable that pulls along its path and cannot push.
///
/// Give either `tension` or `length`. With `length` and `stiffness` the tendon is a spring that cannot push. With `length`
/// alone it is inextensible: a one-sided constraint keeps its path no longer than `length`, and the tension is the multiplier.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(some_of = &["tension", "length"], check = Tendon::fits, example = include_str!("example_tendon.txt"))]
pub struct Tendon {
    /// Name of the tendon.
    pub name: String,
    /// Path from the actuated end to the fixed end. The tendon runs straight between parts that are not adjacent in the same
    /// rod.
    pub path: Vec<PathPart>,
    /// Tension; positive values pull. Negative values of functions, inputs and controllers mean a slack tendon; numbers,
    /// tables, defaults and oscillations below zero are rejected.
    #[part(unit = "newtons")]
    pub tension: Option<Signal<1>>,
    /// Length above which the tendon is taut, not negative. With `stiffness` the tension is
    /// ``max(0, stiffness * (path - length) + damping * rate of path)``.
    #[part(unit = "metres")]
    pub length: Option<Signal<1>>,
    /// Stiffness. Without it a tendon of a given length is inextensible; it then has neither damping nor friction. Steps end
    /// where the tendon becomes taut or slack. Where the length of a taut tendon jumps, as an `Input` does that is shortened,
    /// steps of fixed size follow, and runs by other methods end.
    #[part(unit = "newtons per metre", positive)]
    pub stiffness: Option<f64>,
    /// Damping of a tendon with a stiffness.
    #[part(unit = "newton seconds per metre", non_negative, default = 0.0)]
    pub damping: f64,
    /// Coefficient of friction. Where the tendon turns by an angle, the tension changes by ``exp(-friction * angle)``, as on
    /// a capstan: it decreases away from the actuated end while the tendon is pulled, and increases while it is released.
    /// This holds along embedded parts and at points between straight parts.
    #[part(non_negative, default = 0.0)]
    pub friction: f64,
    /// Rate of change of the path length below which friction is smoothed.
    #[part(unit = "metres per second", positive, default = 1e-3)]
    pub friction_velocity: f64,
    /// Direction of sliding: 1 as if pulled, -1 as if released, 0 for no friction; values outside [-1, 1] are clipped. By
    /// default the rate of change of the path length determines it; this rate is zero in statics, which then has no friction.
    pub sliding: Option<Signal<1>>,
}

/// Reports a signal with a known value below zero. Inputs count with their default value.
fn check_never_below_zero(reader: &mut Reader, signal: &Option<Signal<1>>, name: &str, expected: &str) {
    if let Some((lowest, place)) = signal.as_ref().and_then(|signal| signal.known_lowest(0))
        && lowest < 0.0
        && lowest.is_finite()
    {
        reader.require(false, &format!("{name}{place}"), Number(lowest), expected);
    }
}

fn check_name(reader: &mut Reader, name: &str) {
    reader.require(!name.is_empty(), "name", "\"\"", "a name");
}

impl Tendon {
    fn fits(&self, reader: &mut Reader) {
        let Self { path, tension, length, stiffness, damping, friction, .. } = self;
        check_name(reader, &self.name);
        let has_length = path.len() > 1 || path.iter().any(|part| matches!(part, PathPart::Along(_)));
        let found = if path.is_empty() { "no parts" } else { "one point" };
        reader.require(has_length, "path", found, "a part along a rod, or two points");
        reader.check_exclusive(["tension", "length"], tension, length);
        let expected = "a tension >= 0 (newtons): a tendon pulls, and a chamber pushes";
        check_never_below_zero(reader, tension, "tension", expected);
        check_never_below_zero(reader, length, "length", "a free length >= 0 (metres)");
        if length.is_none() {
            let belongs = "it belongs to a tendon of a given length";
            let damping = Some(*damping).filter(|damping| *damping != 0.0);
            reader.check_unused("stiffness", stiffness.map(Number), belongs);
            reader.check_unused("damping", damping.map(Number), belongs);
        } else if stiffness.is_none() {
            let expected = "none: a tendon without `stiffness` does not stretch";
            reader.require(*damping == 0.0, "damping", Number(*damping), expected);
            let expected =
                "none, or a `stiffness`: friction along a tendon that does not stretch is not supported";
            reader.require(*friction == 0.0, "friction", Number(*friction), expected);
        }
        if let Some([sliding]) = self.sliding.as_ref().and_then(Signal::constant) {
            let expected = "a direction in [-1, 1]: 1 while it is pulled, -1 while it is let out";
            reader.require(sliding.abs() <= 1.0 || sliding.is_nan(), "sliding", sliding, expected);
        }
    }

    /// The command, of a valid tendon.
    pub fn drive(&self) -> Drive {
        match (&self.tension, &self.length) {
            (Some(tension), _) => Drive::Tension(tension.clone()),
            (None, length) => Drive::Length {
                length: length.clone().unwrap_or_default(),
                stiffness: self.stiffness,
                damping: self.damping,
            },
        }
    }
}

/// A fluidic chamber along rods, with caps at its ends.
///
/// `area` is measured in the plane of the rod's section, so the volume is ``area`` times the integral of the middle line's
/// axial slope, and the generalised forces of a pressure do not depend on the shape.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(positional = 4, check = Chamber::fits, example = include_str!("example_chamber.txt"))]
pub struct Chamber {
    /// Name of the chamber.
    pub name: String,
    /// Middle line of the chamber: parts that are embedded in rods.
    pub path: Vec<Along>,
    /// Area in the plane of the section.
    #[part(unit = "square metres", positive)]
    pub area: f64,
    /// Gauge pressure.
    #[part(unit = "pascals", default)]
    pub pressure: Signal<1>,
}

impl Chamber {
    fn fits(&self, reader: &mut Reader) {
        check_name(reader, &self.name);
        reader.require(!self.path.is_empty(), "path", "no parts", "a part along a rod");
    }
}

/// A motor on a joint: a torque about its axis, or a force along it.
///
/// Give either `torque`, or `position` and `gains`.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(positional = 2, some_of = &["torque", "position"], complete = Motor::complete, check = Motor::fits,
       example = include_str!("example_motor.txt"))]
pub struct Motor {
    /// Name of a link whose joint has one coordinate, or name of a joint coordinate as listed in `Robot.coordinates`, such as
    /// "slide.angle". Joints with `mimic` can have motors; spherical joints, free joints and joints with a prescribed motion
    /// cannot.
    pub joint: String,
    /// Torque, newton metres, or force, newtons.
    pub torque: Option<Signal<1>>,
    /// Set point, radians or metres. The motor applies ``gains[0] * (position - coordinate) - gains[1] * velocity``.
    pub position: Option<Signal<1>>,
    /// Stiffness and damping of a motor with a set point.
    #[part(non_negative)]
    pub gains: Option<[f64; 2]>,
    /// Lowest and highest torque or force. Saturation is smooth, over a thousandth of the range.
    pub limits: Option<[f64; 2]>,
    /// Name of the motor; by default that of `joint`.
    pub name: Option<String>,
}

impl Motor {
    fn complete(&mut self) {
        self.name.get_or_insert_with(|| self.joint.clone());
    }

    fn fits(&self, reader: &mut Reader) {
        let Self { torque, position, gains, limits, name, .. } = self;
        name.iter().for_each(|name| check_name(reader, name));
        reader.check_exclusive(["torque", "position"], torque, position);
        let pair = |[a, b]: [f64; 2]| format!("({}, {})", Number(a), Number(b));
        if position.is_none() {
            reader.check_unused("gains", gains.map(pair), "it belongs to a motor of a given position");
        } else {
            let expected = "the pair (stiffness, damping) of a motor that holds a position";
            reader.require(gains.is_some(), "gains", "none", expected);
        }
        if let Some([lowest, highest]) = limits.filter(|limits| limits.iter().all(|limit| limit.is_finite()))
        {
            let expected = "the lowest and the highest torque or force, with a range between them";
            reader.require(lowest < highest, "limits", pair([lowest, highest]), expected);
        }
    }

    /// The command, of a valid motor.
    pub fn command(&self) -> MotorCommand {
        match (&self.position, self.gains) {
            (Some(position), Some([stiffness, damping])) => {
                MotorCommand::Position { position: position.clone(), stiffness, damping }
            }
            _ => MotorCommand::Torque(self.torque.clone().unwrap_or_default()),
        }
    }
}

/// An actuated reference strain: a muscle, a shape-memory wire, a swimming gait.
///
/// The stress depends on the strain minus the reference strain of the segments and minus ``amount * shape``. Two active
/// strains make a travelling wave: ``sin(k X - w t)`` has the shapes ``sin(k X)`` and ``cos(k X)`` with the amounts
/// ``cos(w t)`` and ``-sin(w t)``.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(positional = 4, complete = ActiveStrain::complete, check = ActiveStrain::fits,
       example = include_str!("example_active_strain.txt"))]
pub struct ActiveStrain {
    /// The link; optional if there is only one.
    #[part(explicit)]
    pub link: Option<LinkName>,
    /// The strain. The rod needs modes of it.
    pub strain: Strain,
    /// Strain along the link's rod for an amount of one. It is a number; two numbers, interpolated linearly from base to tip;
    /// or a table of stations and values, or in Python a callable or a `Profile`, over the arc length.
    #[part(unit = "radians or metres per metre", default = AlongRod::Constant(1.0))]
    pub shape: AlongRod,
    /// Amplitude.
    #[part(default)]
    pub amount: Signal<1>,
    /// Name of the actuator; by default made of the link and the strain.
    pub name: Option<String>,
}

impl ActiveStrain {
    /// The name that it has by default.
    fn default_name(&self) -> String {
        let strain = self.strain.name();
        match &self.link {
            Some(LinkName(link)) => format!("{link}.{strain}"),
            None => strain.to_owned(),
        }
    }

    fn complete(&mut self) {
        if self.name.is_none() {
            self.name = Some(self.default_name());
        }
    }

    fn fits(&self, reader: &mut Reader) {
        self.name.iter().for_each(|name| check_name(reader, name));
    }
}

/// An actuator.
#[derive(Clone, Debug, PartialEq, Described)]
pub enum Actuator {
    /// A tendon.
    Tendon(Tendon),
    /// A chamber.
    Chamber(Chamber),
    /// A motor.
    Motor(Motor),
    /// An active strain.
    ActiveStrain(ActiveStrain),
}

impl Actuator {
    /// Whether its name is the one that it has by default.
    pub fn has_default_name(&self) -> bool {
        match self {
            Self::Tendon(_) | Self::Chamber(_) => false,
            Self::Motor(motor) => motor.name.as_ref() == Some(&motor.joint),
            Self::ActiveStrain(active) => active.name == Some(active.default_name()),
        }
    }
}

impl super::Along {
    /// The description of this part, on a link of this name and length.
    fn described(&self, link: &dyn Fn(usize) -> (LinkName, f64)) -> Along {
        let (link, length) = link(self.link);
        // A part along the whole rod, for any length: the length may be swept, fitted or differentiated.
        let is_whole = self.along == [0.0, length];
        let offset = self.offset.each_ref().map(|offset| AlongRod::described(offset, length, is_whole));
        Along { link: Some(link), offset, along: (!is_whole).then_some(self.along) }
    }
}

impl super::Actuator {
    /// The description of this actuator, of a robot whose links have these names and lengths, and whose joints have these
    /// names of coordinates.
    pub fn described(
        &self,
        link: &dyn Fn(usize) -> (LinkName, f64),
        coordinate: impl Fn(usize, usize) -> String,
    ) -> Actuator {
        match self {
            Self::Tendon(tendon) => {
                let part = |part: &super::Part| match part {
                    super::Part::Along(along) => along.described(link).into(),
                    &super::Part::Via(super::Via { link: on, point, at }) => {
                        Via { link: on.map(|on| link(on).0), point, at }.into()
                    }
                };
                let (mut tension, mut length, mut stiffness, mut damping) = (None, None, None, 0.0);
                match &tendon.drive {
                    Drive::Tension(signal) => tension = Some(signal.clone()),
                    Drive::Length { length: signal, stiffness: k, damping: c } => {
                        (length, stiffness, damping) = (Some(signal.clone()), *k, *c);
                    }
                }
                Tendon {
                    name: tendon.name.clone(),
                    path: tendon.path.iter().map(part).collect(),
                    tension,
                    length,
                    stiffness,
                    damping,
                    friction: tendon.friction,
                    friction_velocity: tendon.friction_velocity,
                    sliding: tendon.sliding.clone(),
                }
                .into()
            }
            Self::Chamber(chamber) => Chamber {
                name: chamber.name.clone(),
                path: chamber.path.iter().map(|along| along.described(link)).collect(),
                area: chamber.area,
                pressure: chamber.pressure.clone(),
            }
            .into(),
            Self::Motor(motor) => {
                let (torque, position, gains) = match &motor.command {
                    MotorCommand::Torque(torque) => (Some(torque.clone()), None, None),
                    MotorCommand::Position { position, stiffness, damping } => {
                        (None, Some(position.clone()), Some([*stiffness, *damping]))
                    }
                };
                let (joint, name) = (coordinate(motor.link, motor.coordinate), Some(motor.name.clone()));
                Motor { joint, torque, position, gains, limits: motor.limits, name }.into()
            }
            Self::ActiveStrain(active) => {
                let (link, length) = link(active.link);
                ActiveStrain {
                    link: Some(link),
                    strain: active.strain,
                    shape: AlongRod::described(&active.shape, length, true),
                    amount: active.amount.clone(),
                    name: Some(active.name.clone()),
                }
                .into()
            }
        }
    }
}
