//! The spring pendulum: consistency of its functions. The independent formulation is in
//! tests/python/reference/pendulum.py.

use lissom::linalg::Matrix;
use lissom::model::{
    Autonomous, Dynamics, Elastic, Energy, Facts, ForwardScratch, InvalidShape, SingularMass, Smooth,
};
use lissom::pendulum::SpringPendulum;
use proptest::prelude::*;

/// The pendulum without its closed-form forward dynamics.
struct Generic(SpringPendulum);

impl Dynamics for Generic {
    fn facts(&self) -> &Facts {
        self.0.facts()
    }
    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        self.0.inverse_dynamics(q, qd, qdd, tau);
    }
    fn weighted_tangent(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], weights: [f64; 3], out: &mut Matrix) {
        self.0.weighted_tangent(q, qd, qdd, weights, out);
    }
    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix) {
        self.0.mass_matrix(q, mass);
    }
    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        self.0.energy(q, qd)
    }
    fn tip(&mut self, q: &[f64]) -> [f64; 3] {
        self.0.tip(q)
    }
    fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64 {
        self.0.dissipated_power(q, qd)
    }
    fn supplied_power(&mut self, _: &[f64], _: &[f64], _: &[f64]) -> f64 {
        0.0
    }
    fn invalid_shape(&mut self, _: &[f64]) -> Option<InvalidShape> {
        None
    }
}

impl Elastic for Generic {
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]) {
        self.0.elastic_forces(q, tau);
    }
    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix) {
        self.0.elastic_tangent(q, tangent);
    }
    fn turned_loads(&mut self, q: &[f64], forces: &mut Matrix, borne: &mut [f64]) {
        self.0.turned_loads(q, forces, borne);
    }
    fn sizes(&mut self, q: &[f64], sizes: &mut [f64]) {
        self.0.sizes(q, sizes);
    }
}

impl Autonomous for Generic {}

impl Smooth for Generic {}

fn pendulums() -> impl Strategy<Value = SpringPendulum> {
    (0.5..3.0, 0.1..5.0, 0.0..100.0, -10.0..10.0)
        .prop_map(|(l, m, k, g): (f64, f64, f64, f64)| SpringPendulum::new(l, m, k, g).unwrap())
}

fn states() -> impl Strategy<Value = [[f64; 2]; 3]> {
    let elongation = -0.4..2.0;
    ((-7.0..7.0, elongation), (-5.0..5.0, -5.0..5.0), (-20.0..20.0, -20.0..20.0)).prop_map(
        |(q, qd, qdd): ((f64, f64), (f64, f64), (f64, f64))| [[q.0, q.1], [qd.0, qd.1], [qdd.0, qdd.1]],
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn tangent_is_the_derivative_of_the_inverse_dynamics(mut pendulum in pendulums(), state in states()) {
        let weights = [0.7, -1.3, 2.1];
        let mut tangent = Matrix::zeros(2, 2);
        pendulum.weighted_tangent(&state[0], &state[1], &state[2], weights, &mut tangent);
        let step = 1e-5;
        for j in 0..2 {
            let mut shifted = |sign: f64| {
                let mut state = state;
                for (part, weight) in state.iter_mut().zip(weights) {
                    part[j] += sign * weight * step;
                }
                let mut tau = [0.0; 2];
                pendulum.inverse_dynamics(&state[0], &state[1], &state[2], &mut tau);
                tau
            };
            let (plus, minus) = (shifted(1.0), shifted(-1.0));
            for i in 0..2 {
                let difference = (plus[i] - minus[i]) / (2.0 * step);
                let size = 1.0 + tangent.amax();
                prop_assert!((difference - tangent[(i, j)]).abs() < 1e-7 * size, "{i}, {j}");
            }
        }
    }

    #[test]
    fn mass_matrix_is_the_part_of_the_inverse_dynamics_that_is_linear_in_qdd(
        mut pendulum in pendulums(), state in states()
    ) {
        let mut mass = Matrix::zeros(2, 2);
        pendulum.mass_matrix(&state[0], &mut mass);
        let mut bias = [0.0; 2];
        pendulum.inverse_dynamics(&state[0], &state[1], &[0.0; 2], &mut bias);
        for j in 0..2 {
            let mut unit = [0.0; 2];
            unit[j] = 1.0;
            let mut tau = [0.0; 2];
            pendulum.inverse_dynamics(&state[0], &state[1], &unit, &mut tau);
            for i in 0..2 {
                prop_assert!((tau[i] - bias[i] - mass[(i, j)]).abs() < 1e-11 * (1.0 + bias[i].abs()));
            }
        }
    }

    #[test]
    fn both_forward_dynamics_undo_the_inverse_dynamics(pendulum in pendulums(), state in states()) {
        let [q, qd, _] = state;
        let mut scratch = ForwardScratch::new(2);
        let mut generic = Generic(pendulum.clone());
        let mut pendulum = pendulum;
        let (mut closed_form, mut solved) = ([0.0; 2], [0.0; 2]);
        pendulum.forward_dynamics(&q, &qd, &mut closed_form, &mut scratch).unwrap();
        generic.forward_dynamics(&q, &qd, &mut solved, &mut scratch).unwrap();
        let mut tau = [0.0; 2];
        pendulum.inverse_dynamics(&q, &qd, &closed_form, &mut tau);
        for i in 0..2 {
            prop_assert!((closed_form[i] - solved[i]).abs() < 1e-11 * (1.0 + solved[i].abs()));
            prop_assert!(tau[i].abs() < 1e-11 * (1.0 + 100.0 + solved[i].abs()));
        }
    }

    /// d/dt (kinetic + potential) = qd . tau along any motion.
    #[test]
    fn generalised_forces_balance_the_power(mut pendulum in pendulums(), state in states()) {
        let [q, qd, qdd] = state;
        let step = 1e-5;
        let mut energy_at = |t: f64| {
            let moved = |x: [f64; 2], v: [f64; 2]| [x[0] + t * v[0], x[1] + t * v[1]];
            pendulum.energy(&moved(q, qd), &moved(qd, qdd)).total()
        };
        let change = (energy_at(step) - energy_at(-step)) / (2.0 * step);
        let mut tau = [0.0; 2];
        pendulum.inverse_dynamics(&q, &qd, &qdd, &mut tau);
        let power = qd[0] * tau[0] + qd[1] * tau[1];
        prop_assert!((change - power).abs() < 1e-6 * (1.0 + 1e3_f64.max(power.abs())), "{change} {power}");
    }
}

#[test]
fn energies_in_numbers() {
    let mut pendulum = SpringPendulum::new(1.0, 2.0, 10.0, 9.81).unwrap();
    let energy = pendulum.energy(&[-std::f64::consts::FRAC_PI_2, 0.5], &[2.0, 3.0]);
    assert_eq!(energy.kinetic, 0.5 * 2.0 * (9.0 + 2.25 * 4.0));
    assert_eq!(energy.elastic, 1.25);
    assert_eq!(energy.gravitational, -2.0 * 9.81 * 1.5);
    assert_eq!(energy.loads, 0.0);
    assert_eq!(energy.total(), energy.kinetic + energy.elastic + energy.gravitational);
}

#[test]
fn no_acceleration_exists_at_the_hinge() {
    let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
    let (mut qdd, mut scratch) = ([0.0; 2], ForwardScratch::new(2));
    let (q, qd) = ([0.3, -1.0], [0.1, 0.2]);
    assert_eq!(pendulum.forward_dynamics(&q, &qd, &mut qdd, &mut scratch), Err(SingularMass));
    assert_eq!(Generic(pendulum).forward_dynamics(&q, &qd, &mut qdd, &mut scratch), Err(SingularMass));
}

#[test]
fn impossible_parameters_are_refused_all_at_once() {
    let error = SpringPendulum::new(0.0, f64::NAN, -1.0, f64::INFINITY).unwrap_err();
    let places: Vec<_> = error.problems.iter().map(|p| p.place.as_str()).collect();
    assert_eq!(places, ["length", "mass", "stiffness", "gravity"]);
    assert!(SpringPendulum::new(1.0, 1.0, 0.0, -9.81).is_ok());
}
