//! Force laws of actuators: force from length, rate of length and command; and their power.
//!
//! The force is the one that a motion requires to move against the actuator, dual to its length: a tension is
//! positive, because it resists lengthening, and a pressure negative.

use crate::robot::effects::actuator::plan::Law;
use crate::robot::effects::actuator::state::Force;

/// Width of the transition in which the torque of a motor approaches its limits, relative to the range
/// between them. The largest error of the torque is half of that.
const BEND: f64 = 1e-3;

/// Force for this length, rate and command; for an inextensible tendon the command is its tension.
#[inline(always)]
pub(crate) fn force(law: Law, length: f64, rate: f64, command: f64) -> Force {
    let plain = Force { value: -command, of_command: -1.0, ..Force::default() };
    match law {
        Law::Tension if command < 0.0 => Force::default(),
        Law::Tension => Force { value: command, of_command: 1.0, ..Force::default() },
        Law::Cable { stiffness, damping } => {
            let value = stiffness * (length - command) + damping * rate;
            // Propagates NaN.
            if value < 0.0 {
                return Force::default();
            }
            Force { value, of_length: stiffness, of_rate: damping, of_command: -stiffness }
        }
        Law::Inextensible { .. } => Force { value: command, ..Force::default() },
        Law::Pressure | Law::Amount { .. } => plain,
        Law::Torque { limits } => limited(plain, limits),
        Law::Servo { stiffness, damping, limits } => {
            let value = stiffness * (length - command) + damping * rate;
            let force = Force { value, of_length: stiffness, of_rate: damping, of_command: -stiffness };
            limited(force, limits)
        }
    }
}

/// The force limited by a motor's torque limits; the torque is minus the force. With the distances a and b of
/// the commanded torque from both limits, it is
/// `lowest + (a + sqrt(a^2 + width^2)) / 2 - (b + sqrt(b^2 + width^2)) / 2`, in a form without cancellation
/// of large values.
#[inline(always)]
fn limited(force: Force, limits: Option<[f64; 2]>) -> Force {
    let Some([lowest, highest]) = limits else { return force };
    let (middle, range) = (0.5 * (lowest + highest), highest - lowest);
    let width = BEND * range;
    let wanted = -force.value;
    let (above, beyond) = (wanted - lowest, wanted - highest);
    let (root_above, root_beyond) = (above.hypot(width), beyond.hypot(width));
    let part = (wanted - middle) / (0.5 * root_above + 0.5 * root_beyond);
    let slope = 0.5 * (above / root_above - beyond / root_beyond);
    Force {
        value: -(middle + 0.5 * range * part).clamp(lowest, highest),
        of_length: slope * force.of_length,
        of_rate: slope * force.of_rate,
        of_command: slope * force.of_command,
    }
}

/// Potential of the force at a constant command, if it has one: counted as a load or as elastic.
pub(crate) enum Potential {
    Load(f64),
    Spring(f64),
}

/// Potential at this length.
pub(crate) fn potential(law: Law, length: f64, command: f64) -> Option<Potential> {
    match law {
        Law::Tension => Some(Potential::Load(command.max(0.0) * length)),
        Law::Cable { stiffness, .. } => {
            let stretch = (length - command).max(0.0);
            Some(Potential::Spring(0.5 * stiffness * stretch * stretch))
        }
        Law::Pressure | Law::Torque { limits: None } => Some(Potential::Load(-command * length)),
        Law::Servo { stiffness, limits: None, .. } => {
            let turn = length - command;
            Some(Potential::Spring(0.5 * stiffness * turn * turn))
        }
        Law::Amount { energy_of_unit } => {
            Some(Potential::Spring(command * (0.5 * command * energy_of_unit - length)))
        }
        // An inextensible tendon with constant length does no work.
        Law::Inextensible { .. } => Some(Potential::Load(0.0)),
        Law::Torque { limits: Some(_) } | Law::Servo { limits: Some(_), .. } => None,
    }
}

/// The conservative part of the force.
#[inline(always)]
pub(crate) fn conservative(law: Law, length: f64, command: f64) -> f64 {
    match law {
        Law::Cable { stiffness, .. } => stiffness * (length - command).max(0.0),
        Law::Servo { stiffness, .. } => stiffness * (length - command),
        _ => force(law, length, 0.0, command).value,
    }
}

/// Whether the force has a part that always dissipates power.
pub(crate) fn dissipates(law: Law) -> bool {
    matches!(law, Law::Cable { damping, .. } | Law::Servo { damping, .. } if damping > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Law; 8] = [
        Law::Tension,
        Law::Cable { stiffness: 300.0, damping: 2.0 },
        Law::Pressure,
        Law::Torque { limits: None },
        Law::Torque { limits: Some([-1.0, 0.5]) },
        Law::Servo { stiffness: 5.0, damping: 0.3, limits: None },
        Law::Servo { stiffness: 5.0, damping: 0.3, limits: Some([-1.0, 0.5]) },
        Law::Amount { energy_of_unit: 3.0 },
    ];

    #[test]
    fn derivatives_are_those_of_the_force() {
        let step = 1e-6;
        for law in LAWS {
            for [length, rate, command] in
                [[0.3, 0.1, 0.2], [0.3, -0.2, 0.29], [0.1, 0.0, 0.4], [-0.2, 0.5, -0.6]]
            {
                let at = |l: f64, r: f64, c: f64| force(law, length + l, rate + r, command + c).value;
                let Force { of_length, of_rate, of_command, .. } = force(law, length, rate, command);
                let of = |value: fn(f64) -> [f64; 3]| {
                    let [a, b, c] = value(step);
                    (at(a, b, c) - at(-a, -b, -c)) / (2.0 * step)
                };
                assert!(
                    (of(|h| [h, 0.0, 0.0]) - of_length).abs() < 1e-5 * (1.0 + of_length.abs()),
                    "{law:?}"
                );
                assert!((of(|h| [0.0, h, 0.0]) - of_rate).abs() < 1e-5 * (1.0 + of_rate.abs()), "{law:?}");
                assert!(
                    (of(|h| [0.0, 0.0, h]) - of_command).abs() < 1e-5 * (1.0 + of_command.abs()),
                    "{law:?}"
                );
            }
        }
    }

    #[test]
    fn conservative_parts_are_slopes_of_potentials() {
        let step = 1e-6;
        for law in LAWS {
            for [length, command] in [[0.3, 0.2], [0.1, 0.4], [-0.2, 0.6]] {
                let at = |length: f64| match potential(law, length, command)? {
                    Potential::Load(energy) | Potential::Spring(energy) => Some(energy),
                };
                let (Some(before), Some(after)) = (at(length - step), at(length + step)) else { continue };
                let slope = (after - before) / (2.0 * step);
                assert!((slope - conservative(law, length, command)).abs() < 1e-6, "{law:?}");
            }
        }
    }

    #[test]
    fn motors_stay_between_their_limits_and_tendons_never_push() {
        let law = Law::Torque { limits: Some([-2.0, 3.0]) };
        for (command, torque) in [(-1e3, -2.0), (-1.0, -1.0), (0.0, 0.0), (2.5, 2.5), (1e6, 3.0)] {
            let found = -force(law, 0.0, 0.0, command).value;
            assert!((found - torque).abs() < 1e-4, "{command}: {found}");
            assert!((-2.0..=3.0).contains(&found));
        }
        // Limits far below all commands.
        let narrow = Law::Torque { limits: Some([-1e-9, 1e-9]) };
        for (command, torque) in [(-1e12, -1e-9), (-1.0, -1e-9), (0.0, 0.0), (1.0, 1e-9), (1e12, 1e-9)] {
            let found = -force(narrow, 0.0, 0.0, command).value;
            assert!((found - torque).abs() < 1e-18, "{command}: {found}");
        }
        let cable = Law::Cable { stiffness: 10.0, damping: 1.0 };
        assert_eq!(force(cable, 0.1, 0.0, 0.2).value, 0.0);
        assert_eq!(force(cable, 0.3, -5.0, 0.2).value, 0.0);
        assert_eq!(force(Law::Tension, 0.0, 0.0, -1.0).value, 0.0);
    }
}
