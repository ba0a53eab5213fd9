//! Actuators as robots hold them, with indices of links: tendons, chambers, motors and active strains. [`described`] is what
//! users describe.
//!
//! Each actuator is a force that acts on a length: a length l(q) and a force F give the generalised forces `F
//! dl/dq` (docs/theory.md, "Actuators"). The length is that of a tendon's path, the volume of a chamber, or
//! the coordinate of a joint.
//!
//! ```
//! use lissom::actuator::{Actuator, Motor, MotorCommand};
//!
//! let motor = Motor {
//!     name: "elbow".into(),
//!     link: 0,
//!     coordinate: 0,
//!     command: MotorCommand::Torque([0.5].into()),
//!     limits: None,
//! };
//! assert_eq!(Actuator::Motor(motor).name(), "elbow");
//! ```

mod active_strain;
pub(crate) mod advice;
mod along_rod;
pub(crate) mod along_strains;
mod chamber;
pub(crate) mod compile;
pub mod described;
pub(crate) mod explain;
pub(crate) mod force;
mod motor;
mod path;
pub(crate) mod plan;
pub(crate) mod state;
mod tendon;

use crate::description::signal::Signal;

pub use active_strain::{ActiveStrain, Strain};
pub use along_rod::{AlongRod, Table as AlongRodTable};
pub use chamber::Chamber;
pub use motor::{Motor, MotorCommand};
pub use path::{Along, Part, Via};
pub use tendon::{Drive, Tendon};

/// An actuator with its command.
#[derive(Clone, Debug, PartialEq)]
pub enum Actuator {
    /// A cable that pulls along its path.
    Tendon(Tendon),
    /// A volume along a rod under fluid pressure.
    Chamber(Chamber),
    /// A torque about a joint, or a force along it.
    Motor(Motor),
    /// A commanded reference strain.
    ActiveStrain(ActiveStrain),
}

impl Actuator {
    /// Whether the force law differs between parts of the state space: a tendon that goes slack, a motor at
    /// its limits.
    pub fn is_one_sided(&self) -> bool {
        match self {
            Self::Tendon(tendon) => matches!(tendon.drive, Drive::Length { .. }),
            Self::Motor(motor) => motor.limits.is_some(),
            Self::Chamber(_) | Self::ActiveStrain(_) => false,
        }
    }

    /// The name.
    pub fn name(&self) -> &str {
        match self {
            Self::Tendon(tendon) => &tendon.name,
            Self::Chamber(chamber) => &chamber.name,
            Self::Motor(motor) => &motor.name,
            Self::ActiveStrain(active) => &active.name,
        }
    }

    /// The name, to change it.
    pub(crate) fn name_mut(&mut self) -> &mut String {
        match self {
            Self::Tendon(tendon) => &mut tendon.name,
            Self::Chamber(chamber) => &mut chamber.name,
            Self::Motor(motor) => &mut motor.name,
            Self::ActiveStrain(active) => &mut active.name,
        }
    }

    /// Signal of the command.
    pub fn command(&self) -> &Signal<1> {
        self.named_command().1
    }

    /// The command and its name.
    fn named_command(&self) -> (&'static str, &Signal<1>) {
        match self {
            Self::Tendon(tendon) => tendon.drive.command(),
            Self::Chamber(chamber) => ("pressure", &chamber.pressure),
            Self::Motor(motor) => motor.command.signal(),
            Self::ActiveStrain(active) => ("amount", &active.amount),
        }
    }

    /// Prescribed direction of sliding of a tendon, if any.
    pub fn sliding(&self) -> Option<&Signal<1>> {
        if let Self::Tendon(tendon) = self { tendon.sliding.as_ref() } else { None }
    }

    /// All signals, the command first.
    pub fn signals(&self) -> impl Iterator<Item = &Signal<1>> {
        self.named_signals().map(|(_, signal)| signal)
    }

    /// All signals with their names.
    pub fn named_signals(&self) -> impl Iterator<Item = (&'static str, &Signal<1>)> {
        [self.named_command()].into_iter().chain(self.sliding().map(|sliding| ("sliding", sliding)))
    }

    /// Whether the actuator is an inextensible tendon.
    pub fn is_inextensible(&self) -> bool {
        matches!(self, Self::Tendon(tendon) if tendon.is_inextensible())
    }

    /// Whether a positive force resists lengthening, as the tension of a tendon does.
    pub fn pulls(&self) -> bool {
        matches!(self, Self::Tendon(_))
    }

    /// Parts of the path along rods.
    pub fn along(&self) -> Vec<&Along> {
        match self {
            Self::Tendon(tendon) => tendon.path.iter().filter_map(Part::along).collect(),
            Self::Chamber(chamber) => chamber.path.iter().collect(),
            Self::Motor(_) | Self::ActiveStrain(_) => Vec::new(),
        }
    }

    /// The shortest commanded length of a tendon, in metres, as far as it is known before a run.
    pub(crate) fn shortest_command(&self) -> Option<f64> {
        let Self::Tendon(Tendon { drive: Drive::Length { length, .. }, .. }) = self else { return None };
        length.known_lowest(0).map(|(shortest, _)| shortest)
    }

    /// Points of the path.
    pub fn vias(&self) -> Vec<&Via> {
        match self {
            Self::Tendon(tendon) => tendon.path.iter().filter_map(Part::via).collect(),
            _ => Vec::new(),
        }
    }
}
