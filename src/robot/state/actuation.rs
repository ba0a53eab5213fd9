//! What is known of the actuators in a state.

use crate::lie::Scalar;
use crate::robot::plan::actuation::Actuation;

/// The force of an actuator, and how it changes with its length, with the rate of that and with what it is told.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Force {
    pub(crate) value: f64,
    pub(crate) of_length: f64,
    pub(crate) of_rate: f64,
    pub(crate) of_command: f64,
}

/// What is known of the actuators.
#[derive(Clone, Debug)]
pub(crate) struct ActuationState<P> {
    /// What they are told, NaN until a time is set that it depends on.
    pub(crate) commands: Vec<f64>,
    pub(crate) lengths: Vec<f64>,
    pub(crate) rates: Vec<f64>,
    pub(crate) forces: Vec<Force>,
    /// The gradients of the lengths, n numbers each.
    pub(crate) gradients: Vec<f64>,
    /// Per component and pack of a sleeve: strains, or another field at the nodes.
    pub(crate) field: Vec<P>,
    /// Of all sleeves and their threads in a row: per component and pack `b_c . t` with the unit tangent t, and per
    /// pack `1 / |u|`.
    pub(crate) slopes: Vec<P>,
    pub(crate) inverse_norms: Vec<P>,
}

/// Memory for the tangent of the actuators.
#[derive(Clone, Debug)]
pub(crate) struct ActuationTangent<P> {
    /// Per component and pack of a sleeve: strains, or another field at the nodes.
    pub(crate) field: Vec<P>,
    /// Per pair of components and pack of a sleeve: stiffness per length.
    pub(crate) stiffness: Vec<P>,
    /// Of the actuator at hand, per coordinate: the rate of its gradient.
    pub(crate) gradient_rate: Vec<f64>,
}

impl<P: Scalar> ActuationState<P> {
    pub(crate) fn new(actuation: &Actuation<P>, n: usize) -> Self {
        let number = actuation.actuators.len();
        let zero = P::splat(0.0);
        let nodes = |factor: fn(usize) -> usize| {
            let of_sleeve = actuation
                .sleeves
                .iter()
                .map(|sleeve| sleeve.threads.len() * factor(sleeve.components.len()) * sleeve.packs);
            vec![zero; of_sleeve.sum()]
        };
        Self {
            commands: vec![f64::NAN; number],
            lengths: vec![0.0; number],
            rates: vec![0.0; number],
            forces: vec![Force::default(); number],
            gradients: vec![0.0; number * n],
            field: largest(actuation, |components| components),
            slopes: nodes(|components| components),
            inverse_norms: nodes(|_| 1),
        }
    }
}

impl<P: Scalar> ActuationTangent<P> {
    pub(crate) fn new(actuation: &Actuation<P>, n: usize) -> Self {
        Self {
            field: largest(actuation, |components| components),
            stiffness: largest(actuation, |components| components * (components + 1) / 2),
            gradient_rate: vec![0.0; if actuation.actuators.is_empty() { 0 } else { n }],
        }
    }
}

/// Memory for so many numbers at the nodes of any sleeve.
fn largest<P: Scalar>(actuation: &Actuation<P>, numbers: fn(usize) -> usize) -> Vec<P> {
    let sizes = actuation.sleeves.iter().map(|sleeve| numbers(sleeve.components.len()) * sleeve.packs);
    vec![P::splat(0.0); sizes.max().unwrap_or(0)]
}
