//! The Newmark family against exact solutions and its own theory.

use lissom::body::Body;
use lissom::contact::{Contact, HalfSpace, Obstacle, Surface};
use lissom::error::Interrupted;
use lissom::joint::{Joint, JointForces};
use lissom::linalg::{Lu, Matrix};
use lissom::model::{Dynamics, Facts, Model};
use lissom::newmark::{METHODS, Options, Parameters, Predictor, Scheme, StepSize, Stepper, solve};
use lissom::ode::Tolerance;
use lissom::pendulum::SpringPendulum;
use lissom::robot::{Link, Robot, RobotModel};
use lissom::rod::Segment;
use lissom::roots::Derivative;
use lissom::second_order;
use lissom::second_order::{Counters, Failure, Solution, Status};
use proptest::prelude::*;

/// `M a + C v + K q = f(t)`, times `scale`.
struct Linear {
    facts: Facts,
    mass: Matrix,
    damping: Matrix,
    stiffness: Matrix,
    load: fn(f64) -> f64,
    scale: f64,
    /// Factor of a deliberately wrong tangent.
    tangent_error: f64,
}

impl Linear {
    fn oscillator(frequency: f64, damping_ratio: f64) -> Self {
        Self::new(1.0, 2.0 * damping_ratio * frequency, frequency * frequency)
    }

    fn new(m: f64, c: f64, k: f64) -> Self {
        let one = |x| Matrix::from_element(1, 1, x);
        Self::of(one(m), one(c), one(k))
    }

    fn of(mass: Matrix, damping: Matrix, stiffness: Matrix) -> Self {
        let facts = Facts::of_equations(mass.nrows());
        Self { facts, mass, damping, stiffness, load: |_| 0.0, scale: 1.0, tangent_error: 1.0 }
    }
}

impl second_order::SecondOrderSystem for Linear {
    type Model = dyn Model;
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn residual(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        r: &mut [f64],
    ) -> Result<(), Interrupted> {
        for i in 0..r.len() {
            r[i] = -(self.load)(t);
            for j in 0..r.len() {
                r[i] +=
                    self.mass[(i, j)] * a[j] + self.damping[(i, j)] * v[j] + self.stiffness[(i, j)] * q[j];
            }
            r[i] *= self.scale;
        }
        Ok(())
    }

    fn tangent(
        &mut self,
        _t: f64,
        _q: &[f64],
        _v: &[f64],
        _a: &[f64],
        [wq, wv, wa]: [f64; 3],
        tangent: &mut Matrix,
    ) -> Result<(), Interrupted> {
        let sum = &self.stiffness * wq + &self.damping * wv + &self.mass * wa;
        tangent.copy_from(&(sum * (self.scale * self.tangent_error)));
        Ok(())
    }
    fn model(&mut self) -> Option<&mut Self::Model> {
        None
    }
}

/// A scalar system given by a closure; its tangent is never used.
struct Scalar<F> {
    facts: Facts,
    equation: F,
}

impl<F: FnMut(f64, f64, f64, f64) -> Result<f64, Interrupted>> Scalar<F> {
    fn new(equation: F) -> Self {
        Self { facts: Facts::of_equations(1), equation }
    }
}

impl<F: FnMut(f64, f64, f64, f64) -> Result<f64, Interrupted>> second_order::SecondOrderSystem for Scalar<F> {
    type Model = dyn Model;
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn residual(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        r: &mut [f64],
    ) -> Result<(), Interrupted> {
        r[0] = (self.equation)(t, q[0], v[0], a[0])?;
        Ok(())
    }

    fn tangent(
        &mut self,
        _t: f64,
        _q: &[f64],
        _v: &[f64],
        _a: &[f64],
        _weights: [f64; 3],
        _tangent: &mut Matrix,
    ) -> Result<(), Interrupted> {
        unreachable!("differences evaluate residuals only")
    }
    fn model(&mut self) -> Option<&mut Self::Model> {
        None
    }
}

fn run<S: second_order::SecondOrderSystem>(
    system: &mut S,
    t_end: f64,
    q0: &[f64],
    v0: &[f64],
    options: &Options,
) -> Solution {
    solve(system, (0.0, t_end), q0, v0, options, None, &mut |_, _| Ok(())).unwrap()
}

fn scalar_run<S: second_order::SecondOrderSystem>(
    system: &mut S,
    t_end: f64,
    (q0, v0): (f64, f64),
    options: &Options,
) -> Solution {
    run(system, t_end, &[q0], &[v0], options)
}

fn by_name(name: &str) -> Scheme {
    Scheme::by_name(name, &Parameters::default()).unwrap()
}

fn with_scheme(scheme: Scheme, dt: f64) -> Options {
    Options { scheme, ..Options::new(dt) }
}

fn adaptive(dt: f64, tolerance: f64) -> Options {
    Options {
        step_size: StepSize::Adaptive { max_step: f64::INFINITY, min_step: 0.0 },
        rtol: tolerance.into(),
        atol: Some(tolerance.into()),
        ..Options::new(dt)
    }
}

fn differenced(dt: f64) -> Options {
    Options { derivative: Derivative::Forward, ..Options::new(dt) }
}

fn last(values: &[f64]) -> f64 {
    values[values.len() - 1]
}

/// Least-squares slope of `y` over `x`.
fn slope(x: &[f64], y: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (mx, my) = (mean(x), mean(y));
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx) * (x - mx)).sum::<f64>()
}

/// Observed orders of convergence of the displacement, velocity and acceleration at the end, from halved
/// steps.
fn orders(mut errors: impl FnMut(f64) -> [f64; 3]) -> [f64; 3] {
    let steps: Vec<f64> = (0..5).map(|k| 0.02 / f64::from(1 << k)).collect();
    let found: Vec<[f64; 3]> = steps.iter().map(|&h| errors(h)).collect();
    let x: Vec<f64> = steps.iter().map(|h| h.log2()).collect();
    std::array::from_fn(|part| {
        slope(&x, &found.iter().map(|errors| errors[part].abs().log2()).collect::<Vec<_>>())
    })
}

/// Exact damped oscillation from (q0, v0): displacement, velocity, acceleration.
fn damped_oscillation(w: f64, zeta: f64, q0: f64, v0: f64, t: f64) -> [f64; 3] {
    let wd = w * (1.0 - zeta * zeta).sqrt();
    let b = (v0 + zeta * w * q0) / wd;
    let (sin, cos) = (wd * t).sin_cos();
    let decay = (-zeta * w * t).exp();
    let q = decay * (q0 * cos + b * sin);
    let v = decay * wd * (b * cos - q0 * sin) - zeta * w * q;
    [q, v, -2.0 * zeta * w * v - w * w * q]
}

#[test]
fn constant_acceleration_is_exact() {
    let mut falling = Scalar::new(|_t, _q, _v, a| Ok(a + 9.75));
    for name in METHODS {
        let steps = 100;
        let options = Options { scheme: by_name(name), ..differenced(0.125) };
        let found = scalar_run(&mut falling, 12.5, (3.0, -2.0), &options);
        assert_eq!(found.t.len(), steps + 1);
        for i in 0..=steps {
            let t = i as f64 * 0.125;
            assert_eq!(found.t[i], t);
            let (v, q) = (-2.0 - 9.75 * t, 3.0 - 2.0 * t - 9.75 / 2.0 * t * t);
            let bound = (i + 1) as f64 * 8.0 * f64::EPSILON;
            assert!((found.a[i] + 9.75).abs() <= bound * 9.75, "{name}, step {i}");
            assert!((found.v[i] - v).abs() <= bound * (2.0 + 9.75 * t), "{name}, step {i}");
            assert!((found.q[i] - q).abs() <= bound * (3.0 + 2.0 * t + 5.0 * t * t), "{name}, step {i}");
        }
    }
}

#[test]
fn order_two_on_linear_oscillators() {
    for name in METHODS {
        for zeta in [0.0, 0.15] {
            let mut system = Linear::oscillator(5.0, zeta);
            let found = orders(|h| {
                let found = scalar_run(&mut system, 1.0, (1.0, 0.5), &with_scheme(by_name(name), h));
                let exact = damped_oscillation(5.0, zeta, 1.0, 0.5, 1.0);
                [last(&found.q) - exact[0], last(&found.v) - exact[1], last(&found.a) - exact[2]]
            });
            // Displacements of the Fox-Goodwin method may converge faster.
            let most = if name == "fox_goodwin" { 4.2 } else { 2.1 };
            assert!(found.iter().all(|p| (1.9..most).contains(p)), "{name}, zeta = {zeta}: {found:?}");
        }
    }
}

#[test]
fn order_two_on_a_nonlinear_model_with_a_mass_matrix_that_depends_on_the_configuration() {
    let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
    let (q0, v0) = ([-0.7, 0.5], [0.0, 0.0]);
    let mut state_at_one = |options: &Options| {
        let found = run(&mut pendulum, 1.0, &q0, &v0, options);
        assert!(found.status.is_success(), "{}", found.message);
        let end = found.q.len() - 2;
        [&found.q[end..], &found.v[end..], &found.a[end..]].map(|x| [x[0], x[1]])
    };
    let tight =
        |scheme, dt| Options { rtol: 1e-11.into(), atol: Some(1e-12.into()), ..with_scheme(scheme, dt) };
    let exact = state_at_one(&tight(Scheme::FOX_GOODWIN, 2e-5));
    for name in ["newmark", "central_difference", "hht", "generalised_alpha"] {
        let found = orders(|h| {
            let found = state_at_one(&tight(by_name(name), h));
            std::array::from_fn(|part| {
                let [x, y]: [f64; 2] = std::array::from_fn(|i| found[part][i] - exact[part][i]);
                x.hypot(y)
            })
        });
        assert!(found.iter().all(|p| (p - 2.0).abs() < 0.1), "{name}: {found:?}");
    }
}

#[test]
fn order_one_with_another_gamma() {
    let mut system = Linear::oscillator(5.0, 0.0);
    let scheme = Scheme::newmark(0.36, 0.7).unwrap();
    assert_eq!(scheme.order(), 1);
    let exact = damped_oscillation(5.0, 0.0, 1.0, 0.5, 1.0);
    let found = orders(|h| {
        let found = scalar_run(&mut system, 1.0, (1.0, 0.5), &with_scheme(scheme, h / 4.0));
        [last(&found.q) - exact[0], last(&found.v) - exact[1], last(&found.a) - exact[2]]
    });
    assert!(found.iter().all(|p| (p - 1.0).abs() < 0.1), "{found:?}");
}

/// Loads are evaluated at the right time: q = sin(3 t) solves q'' + q = -8 sin(3 t).
#[test]
fn order_two_under_a_load_that_depends_on_time() {
    for name in ["newmark", "hht", "generalised_alpha"] {
        let mut system = Linear { load: |t| -8.0 * (3.0 * t).sin(), ..Linear::oscillator(1.0, 0.0) };
        let found = orders(|h| {
            let found = scalar_run(&mut system, 1.0, (0.0, 3.0), &with_scheme(by_name(name), h));
            let (sin, cos) = 3.0_f64.sin_cos();
            [last(&found.q) - sin, last(&found.v) - 3.0 * cos, last(&found.a) + 9.0 * sin]
        });
        assert!(found.iter().all(|p| (p - 2.0).abs() < 0.1), "{name}: {found:?}");
    }
}

/// Spectral radius of a 2 x 2 matrix.
fn spectral_radius([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    let (half_trace, determinant) = (0.5 * (a + d), a * d - b * c);
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(100) })]

    /// The spectral radius of the step's matrix, determined by stepping, agrees with that of the textbook's
    /// amplification matrix (Hughes 1987, section 9.1, with the invariants of his eq. 9.1.19).
    #[test]
    fn spectral_radius_of_the_amplification_matrix(
        beta in 0.0..1.0_f64, gamma in 0.5..1.5_f64, frequency in 0.1..30.0_f64, zeta in 0.0..0.5_f64
    ) {
        let mut system = Linear::oscillator(frequency, zeta);
        let scheme = Scheme::newmark(beta, gamma).unwrap();
        let options = Options { rtol: 1e-14.into(), ..with_scheme(scheme, 1.0) };
        let columns = [(1.0, 0.0), (0.0, 1.0)].map(|start| {
            let found = scalar_run(&mut system, 1.0, start, &options);
            [found.q[1], found.v[1]]
        });
        let found = spectral_radius([[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]]);
        let square = frequency * frequency;
        let d = 1.0 + 2.0 * gamma * zeta * frequency + beta * square;
        let half_trace = 1.0 - (zeta * frequency + 0.5 * square * (gamma + 0.5)) / d;
        let determinant = 1.0 - (2.0 * zeta * frequency + square * (gamma - 0.5)) / d;
        let expected = spectral_radius([[half_trace, half_trace * half_trace - determinant], [1.0, half_trace]]);
        prop_assert!((found - expected).abs() < 1e-8 * expected.max(1.0), "{found} is not {expected}");
    }

    /// Growth begins at the stability limit.
    #[test]
    fn stability_limit(beta in 0.0..0.5_f64, gamma in 0.5..1.0_f64) {
        let scheme = Scheme::newmark(beta, gamma).unwrap();
        let limit = scheme.stability_limit();
        let growth = |frequency: f64| {
            let d = 1.0 + beta * frequency * frequency;
            let half_trace = 1.0 - 0.5 * frequency * frequency * (gamma + 0.5) / d;
            let determinant = 1.0 - frequency * frequency * (gamma - 0.5) / d;
            spectral_radius([[half_trace, half_trace * half_trace - determinant], [1.0, half_trace]])
        };
        if limit.is_finite() {
            prop_assert!(growth(0.999 * limit) <= 1.0 + 1e-9);
            prop_assert!(growth(1.001 * limit) > 1.0);
        } else {
            prop_assert!(growth(1e3) <= 1.0 + 1e-9);
        }
    }

    /// The trapezoidal rule conserves every quadratic invariant: the energy of linear undamped systems.
    #[test]
    fn average_acceleration_conserves_the_energy_of_linear_systems(
        entries in prop::collection::vec(-1.0..1.0_f64, 18), state in prop::collection::vec(-1.0..1.0_f64, 6),
        dt in 0.01..10.0_f64
    ) {
        // B^T B + I is symmetric positive definite.
        let definite = |entries: &[f64]| {
            let b = Matrix::from_column_slice(3, 3, entries);
            b.transpose() * &b + Matrix::identity(3, 3)
        };
        let mut system =
            Linear::of(definite(&entries[..9]), Matrix::zeros(3, 3), 20.0 * definite(&entries[9..]));
        let energy = |system: &Linear, q: &[f64], v: &[f64]| {
            let form = |a: &Matrix, x: &[f64]| -> f64 {
                (0..3).map(|i| (0..3).map(|j| x[i] * a[(i, j)] * x[j]).sum::<f64>()).sum()
            };
            0.5 * (form(&system.mass, v) + form(&system.stiffness, q))
        };
        let steps = 200;
        let found = run(&mut system, dt * f64::from(steps), &state[..3], &state[3..], &Options::new(dt));
        prop_assert!(found.status.is_success());
        let start = energy(&system, &state[..3], &state[3..]);
        let end = found.q.len() - 3;
        let change = energy(&system, &found.q[end..], &found.v[end..]) - start;
        prop_assert!(change.abs() <= 1e-11 * start, "{change} of {start}");
    }

    /// Scaling the equations by powers of two does not change the solution, bit by bit.
    #[test]
    fn scaled_equations_have_the_same_motion(exponent in -60..60_i32, dt in 0.001..0.1_f64) {
        let motion = |scale: f64| {
            let mut system = Linear { scale, load: |t| t.sin(), ..Linear::oscillator(7.0, 0.01) };
            scalar_run(&mut system, 1.0, (0.3, -1.0), &Options::new(dt))
        };
        let (one, other) = (motion(1.0), motion(2.0_f64.powi(exponent)));
        prop_assert_eq!(one.q, other.q);
        prop_assert_eq!(one.counters, other.counters);
    }
}

#[test]
fn periods_are_elongated_by_a_twelfth_of_the_square_of_omega_h() {
    for (scheme, factor) in [
        (Scheme::AVERAGE_ACCELERATION, 1.0 / 12.0),
        (Scheme::LINEAR_ACCELERATION, 1.0 / 24.0),
        (Scheme::CENTRAL_DIFFERENCE, -1.0 / 24.0),
    ] {
        let (frequency, dt) = (2.0 * std::f64::consts::PI, 0.01);
        let mut system = Linear::oscillator(frequency, 0.0);
        let options = Options { rtol: 1e-13.into(), ..with_scheme(scheme, dt) };
        let found = scalar_run(&mut system, 20.0, (1.0, 0.0), &options);
        // The phase of the discrete motion, a sine with an elongated period, unwrapped from step to step.
        let mut phase = 0.0;
        let angle = |i: usize| (-found.v[i] / frequency).atan2(found.q[i]);
        for i in 1..found.t.len() {
            phase += (angle(i) - angle(i - 1)).rem_euclid(2.0 * std::f64::consts::PI);
        }
        let elongation = frequency * 20.0 / phase - 1.0;
        let expected = factor * (frequency * dt).powi(2);
        assert!((elongation / expected - 1.0).abs() < 0.02, "{elongation} is not {expected}");
    }
}

#[test]
fn infinitely_fast_oscillations_are_multiplied_with_rho_inf() {
    for rho_inf in [0.0, 0.3, 0.8, 1.0] {
        let scheme = Scheme::generalised_alpha(rho_inf).unwrap();
        let mut system = Linear::oscillator(1e6, 0.0);
        let options = Options { rtol: 1e-14.into(), atol: Some(1e-30.into()), ..with_scheme(scheme, 1.0) };
        let found = scalar_run(&mut system, 40.0, (1.0, 0.0), &options);
        let size = |i: usize| found.q[i].abs();
        if rho_inf == 0.0 {
            assert!(size(10) < 1e-9, "{:?}", &found.q[..12]);
            continue;
        }
        // A double eigenvalue: q_i = (c + d i) rho^i, so that a quotient of i ratios tends to rho.
        let ratio = size(40) / size(39);
        let bound = if rho_inf == 1.0 { 1e-6 } else { 0.06 };
        assert!((ratio / rho_inf - 1.0).abs() < bound, "rho_inf = {rho_inf}: {ratio}");
    }
}

#[test]
fn generalised_alpha_with_rho_one_is_not_dissipative_and_hht_with_zero_is_average_acceleration() {
    let mut system = Linear::oscillator(3.0, 0.0);
    let average = scalar_run(&mut system, 5.0, (1.0, 0.0), &Options::new(0.1));
    let hht = scalar_run(&mut system, 5.0, (1.0, 0.0), &with_scheme(Scheme::hht(0.0).unwrap(), 0.1));
    assert_eq!(average.q, hht.q);
    let scheme = Scheme::generalised_alpha(1.0).unwrap();
    let found = scalar_run(&mut system, 500.0, (1.0, 0.0), &with_scheme(scheme, 0.1));
    let largest = found.q[4000..].iter().fold(0.0_f64, |m, q| m.max(q.abs()));
    assert!((largest - 1.0).abs() < 0.05, "{largest}");
}

#[test]
fn a_linear_system_takes_one_iteration_a_step_and_one_jacobian() {
    let mut system = Linear { load: f64::sin, ..Linear::oscillator(3.0, 0.1) };
    let found = scalar_run(&mut system, 10.0, (1.0, 0.0), &Options::new(0.01));
    let Counters { steps, nfev, njev, nlu, newton_iterations, .. } = found.counters;
    assert_eq!((steps, njev, nlu), (1000, 2, 2), "one Jacobian at the start, one for all steps");
    assert_eq!(nfev, newton_iterations);
    // One step in sixteen measures the rate of convergence, as do steps that differ from the previous one.
    assert!(nfev <= 1130, "{nfev}");
}

#[test]
fn the_counters_of_the_default_run() {
    let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
    let found = run(&mut pendulum, 1.0, &[-0.7, 0.5], &[0.0, 0.0], &differenced(0.01));
    let Counters { steps, nfev, njev, nlu, newton_iterations, nfev_jacobian, .. } = found.counters;
    assert_eq!(steps, 100);
    assert_eq!(nfev, newton_iterations);
    assert_eq!((njev, nfev_jacobian), (nlu, 2 * njev));
    // Detects regressions of the predictor and of the reuse of Jacobians.
    assert!(nfev <= 250 && njev <= 110, "{:?}", found.counters);
}

#[test]
fn all_jacobians_find_the_same_motion_whether_kept_or_not() {
    let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
    let mut motion = |options: &Options| run(&mut pendulum, 5.0, &[-0.7, 0.5], &[0.0, 0.0], options).q;
    for scheme in ["newmark", "central_difference", "generalised_alpha"].map(by_name) {
        let options = Options { reuse_jacobian: false, rtol: 1e-12.into(), ..with_scheme(scheme, 0.01) };
        let exact = motion(&options);
        for derivative in [Derivative::Analytic, Derivative::Forward, Derivative::Central] {
            for predictor in [Predictor::Best, Predictor::Last, Predictor::Zero] {
                for reuse_jacobian in [true, false] {
                    let options =
                        Options { derivative, predictor, reuse_jacobian, ..with_scheme(scheme, 0.01) };
                    let found = motion(&options);
                    let error = found.iter().zip(&exact).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()));
                    assert!(error < 1e-5, "{derivative:?}, {predictor:?}, {reuse_jacobian}: {error:e}");
                }
            }
        }
    }
}

/// Neither zero tolerances nor forces that are large relative to the inertia of the first guess are mistaken
/// for a singular mass matrix.
#[test]
fn the_size_of_accelerations_need_not_be_known() {
    for derivative in [Derivative::Analytic, Derivative::Forward, Derivative::Central] {
        for predictor in [Predictor::Best, Predictor::Zero] {
            for (frequency, atol) in [2.0, 1e4, 1e8]
                .into_iter()
                .flat_map(|frequency| [None, Some(0.0), Some(1e-9)].map(|atol| (frequency, atol)))
            {
                let mut system = Linear::oscillator(frequency, 0.0);
                let options = Options {
                    derivative,
                    predictor,
                    atol: atol.map(Tolerance::from),
                    ..Options::new(0.1 / frequency)
                };
                let t_end = 1.0 / frequency;
                let found = scalar_run(&mut system, t_end, (1.0, 0.0), &options);
                let what = format!("{derivative:?}, {predictor:?}, {frequency:e}, {atol:?}");
                assert!(found.status.is_success(), "{what}: {}", found.message);
                assert!((last(&found.q) - 1.0_f64.cos()).abs() < 1e-3, "{what}: {}", last(&found.q));
                assert!(found.counters.njev <= 3, "{what}: {:?}", found.counters);
                // At rest at the origin, nothing indicates the size of the solution.
                let found = scalar_run(&mut system, t_end, (0.0, 0.0), &options);
                assert!(found.status.is_success(), "{what}: {}", found.message);
                assert_eq!(last(&found.q), 0.0, "{what}");
            }
        }
    }
}

/// Without a relative tolerance, an absolute one does not make the increments of finite differences huge.
#[test]
fn differences_without_a_relative_tolerance() {
    let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
    for derivative in [Derivative::Analytic, Derivative::Forward, Derivative::Central] {
        let options = Options { derivative, rtol: 0.0.into(), atol: Some(1e-3.into()), ..Options::new(0.01) };
        let found = run(&mut pendulum, 1.0, &[-0.7, 0.5], &[0.0, 0.0], &options);
        assert!(found.status.is_success(), "{derivative:?}: {}", found.message);
        let Counters { reuse_failures, full_newton, newton_iterations, .. } = found.counters;
        assert_eq!((reuse_failures, full_newton), (0, 0), "{derivative:?}");
        assert!(newton_iterations < 250, "{derivative:?}: {newton_iterations}");
    }
}

/// A tangent that is wrong by a factor slows Newton's method down, but does not cause false convergence.
#[test]
fn a_wrong_tangent_does_not_give_a_wrong_motion() {
    let exact = scalar_run(&mut Linear::oscillator(3.0, 0.1), 2.0, (1.0, 0.0), &Options::new(0.01));
    for tangent_error in [0.75, 1.5, 3.0, 100.0, 1e6] {
        let mut system = Linear { tangent_error, ..Linear::oscillator(3.0, 0.1) };
        let found = scalar_run(&mut system, 2.0, (1.0, 0.0), &Options::new(0.01));
        match found.status {
            Status::Finished => {
                let error = last(&found.q) - last(&exact.q);
                assert!(error.abs() < 1e-6, "factor {tangent_error}: {error:e}");
            }
            Status::NoInitialAcceleration(Failure::NotConverged)
            | Status::StepFailed(Failure::NotConverged) => {
                assert!(tangent_error > 2.0, "{}", found.message);
            }
            status => panic!("{status:?}"),
        }
    }
}

/// The residual of every accepted step, as an error of the accelerations in units of the tolerances.
#[test]
fn every_step_is_solved_to_the_tolerance() {
    let scheme = Scheme::AVERAGE_ACCELERATION;
    let mut judge = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
    let mut judge_lu = Lu::new(2);
    let mut tangent = Matrix::zeros(2, 2);
    for (rtol, dt) in [(1e-3, 0.01), (1e-6, 0.03), (1e-6, 0.01), (1e-6, 0.001), (1e-9, 0.01), (1e-9, 0.001)] {
        for derivative in [Derivative::Analytic, Derivative::Forward] {
            let mut errors = Vec::new();
            let mut last_a = [f64::INFINITY; 2];
            let mut judge_step = |stepper: &Stepper| {
                let (q, v, a) = (stepper.q(), stepper.v(), stepper.a());
                let mut error = [0.0; 2];
                judge.inverse_dynamics(q, v, a, &mut error);
                judge.weighted_tangent(q, v, a, scheme.weights(dt), &mut tangent);
                judge_lu.factorise(&tangent).unwrap();
                judge_lu.solve(&mut error);
                let ratios = [0, 1].map(|i| error[i] / (1e-9 + rtol * a[i].abs().max(last_a[i].abs())));
                last_a = [a[0], a[1]];
                errors.push((0.5 * (ratios[0].powi(2) + ratios[1].powi(2))).sqrt());
            };
            let options =
                Options { rtol: rtol.into(), atol: Some(1e-9.into()), derivative, ..with_scheme(scheme, dt) };
            let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
            let found = solve(
                &mut pendulum,
                (0.0, 5.0),
                &[-0.7, 0.5],
                &[0.0; 2],
                &options,
                None,
                &mut |_, stepper| {
                    judge_step(stepper);
                    Ok(())
                },
            )
            .unwrap();
            assert!(found.status.is_success());
            errors.sort_by(f64::total_cmp);
            let (typical, largest) = (errors[errors.len() * 9 / 10], errors[errors.len() - 1]);
            assert!(
                typical < 0.3 && largest < 3.0,
                "{rtol:e}, {dt}, {derivative:?}: {typical:.2e}, {largest:.2e}"
            );
        }
    }
}

#[test]
fn reruns_are_equal_bit_by_bit() {
    let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
    let mut motion = || {
        let options = adaptive(0.01, 1e-5);
        let found = run(&mut pendulum, 3.0, &[-0.7, 0.5], &[0.0, 0.0], &options);
        (found.t, found.q, found.v, found.a, found.counters)
    };
    assert_eq!(motion(), motion());
}

/// 2 a + v/2 + 8 q = 0 by the average acceleration rule with h = 1/8, in rational arithmetic.
#[test]
fn anchor_of_the_fixed_step_path() {
    let mut system = Linear::new(2.0, 0.5, 8.0);
    let found = scalar_run(&mut system, 1.0, (1.0, -0.25), &Options::new(0.125));
    let expected = [
        1.0,
        0.9393939393939394,
        0.8236914600550964,
        0.6615744219050004,
        0.46427460176521035,
        0.24481570940146175,
        0.01716977078198058,
        -0.20461839822975755,
        -0.40728459859085164,
    ];
    for (found, expected) in found.q.iter().zip(expected) {
        assert!((found - expected).abs() <= 4.0 * f64::EPSILON, "{found:e} is not {expected:e}");
    }
}

#[test]
fn steps_fill_the_interval() {
    let mut system = Linear::oscillator(1.0, 0.0);
    for (t_end, dt, steps) in [
        (1.0, 0.1, 10),
        (0.3, 0.1, 3),
        (1.1, 0.1, 11),
        (1000.0, 0.01, 100_000),
        (1.05, 0.1, 11),
        (0.05, 0.1, 1),
        (0.0, 0.1, 0),
    ] {
        let found = scalar_run(&mut system, t_end, (1.0, 0.0), &Options::new(dt));
        assert_eq!(found.status, Status::Finished);
        assert_eq!(found.t.len(), steps + 1, "{t_end} / {dt}");
        assert_eq!(last(&found.t), t_end);
        assert!(found.t.windows(2).all(|t| t[1] - t[0] < dt * (1.0 + 1e-9) && t[1] > t[0]));
    }
}

#[test]
fn a_remainder_of_a_step_is_as_accurate_as_the_others() {
    for name in METHODS {
        let mut system = Linear::oscillator(3.0, 0.0);
        let errors: Vec<f64> = [1.0, 1.0 + 0.0003]
            .into_iter()
            .map(|t_end| {
                let found = scalar_run(&mut system, t_end, (1.0, 0.0), &with_scheme(by_name(name), 1e-3));
                let exact = damped_oscillation(3.0, 0.0, 1.0, 0.0, t_end);
                (last(&found.q) - exact[0]).abs().max((last(&found.v) - exact[1]).abs())
            })
            .collect();
        assert!(errors[1] < 1.05 * errors[0] + 1e-9, "{name}: {errors:?}");
    }
}

#[test]
fn output_times() {
    let mut system = Linear::oscillator(2.0, 0.05);
    let every = scalar_run(&mut system, 2.0, (1.0, 0.0), &Options::new(0.01));
    let mut at = |times: &[f64]| {
        solve(&mut system, (0.0, 2.0), &[1.0], &[0.0], &Options::new(0.01), Some(times), &mut |_, _| Ok(()))
            .unwrap()
    };
    let found = at(&[0.0, every.t[7], 0.5055, 2.0]);
    assert_eq!(found.t, [0.0, every.t[7], 0.5055, 2.0]);
    for (i, k) in [(0, 0), (1, 7), (3, 200)] {
        assert_eq!((found.q[i], found.v[i], found.a[i]), (every.q[k], every.v[k], every.a[k]));
    }
    // Between steps, the error is not larger than at the steps.
    let exact = damped_oscillation(2.0, 0.05, 1.0, 0.0, 0.5055);
    assert!((found.q[2] - exact[0]).abs() < 1e-4);
    assert!((found.v[2] - exact[1]).abs() < 1e-4);
    assert!((found.a[2] - exact[2]).abs() < 1e-3);
    assert!(at(&[]).t.is_empty());
    for wrong in [&[-0.1, 1.0][..], &[0.5, 0.5], &[1.0, 0.5], &[2.5], &[f64::NAN]] {
        let options = Options::new(0.01);
        let mut never =
            Scalar::new(|_, _, _, _| -> Result<f64, Interrupted> { unreachable!("refused before") });
        let result = solve(&mut never, (0.0, 2.0), &[1.0], &[0.0], &options, Some(wrong), &mut |_, _| Ok(()));
        assert!(result.unwrap_err().to_string().contains("t_eval["), "{wrong:?}");
    }
}

#[test]
fn failures_keep_what_was_computed() {
    // NaN from t = 0.5 on.
    let mut nan = Scalar::new(|t, q, _v, a| Ok(if t > 0.5 { f64::NAN } else { a + q }));
    let found = scalar_run(&mut nan, 1.0, (1.0, 0.0), &differenced(0.125));
    assert_eq!(found.status, Status::StepFailed(Failure::NonFinite));
    assert_eq!(found.status.name(), "non_finite");
    assert_eq!(found.t, [0.0, 0.125, 0.25, 0.375, 0.5]);
    assert!(found.message.contains("t = 0.5") && found.message.contains("dt"), "{}", found.message);
    assert!(found.q.iter().chain(&found.v).chain(&found.a).all(|x| x.is_finite()));
    // No real solution from t = 0.5 on.
    let mut rootless = Scalar::new(|t, _q, _v, a| Ok(if t > 0.5 { a * a + 1.0 } else { a - 1.0 }));
    let found = scalar_run(&mut rootless, 1.0, (1.0, 0.0), &differenced(0.125));
    assert_eq!(found.status, Status::StepFailed(Failure::NotConverged));
    assert_eq!(found.t.len(), 5);
    // The step is reduced repeatedly and never accepted.
    let found = scalar_run(
        &mut rootless,
        1.0,
        (1.0, 0.0),
        &Options { derivative: Derivative::Forward, ..adaptive(0.1, 1e-6) },
    );
    assert_eq!(found.status, Status::StepTooSmall);
    assert!(found.counters.unsolved > 10, "{:?}", found.counters);
    assert!(last(&found.t) <= 0.5 && last(&found.t) > 0.4999, "{}", last(&found.t));
    // The equations do not determine the accelerations.
    let mut massless = Scalar::new(|t, q, _v, a| Ok(if t > 0.5 { q - 1.0 + 0.0 * a } else { a }));
    let central = Options { scheme: Scheme::CENTRAL_DIFFERENCE, ..differenced(0.125) };
    let found = scalar_run(&mut massless, 1.0, (2.0, 0.0), &central);
    assert_eq!(found.status, Status::StepFailed(Failure::SingularJacobian));
    assert_eq!(found.t.len(), 5);
}

#[test]
fn no_initial_acceleration() {
    let options = differenced(0.1);
    let mut singular = Scalar::new(|_t, q, v, _a| Ok(q + v));
    let found = scalar_run(&mut singular, 1.0, (1.0, 0.0), &options);
    assert_eq!(found.status, Status::NoInitialAcceleration(Failure::SingularJacobian));
    assert!(found.t.is_empty() && found.q.is_empty());
    assert!(found.message.contains("mass"), "{}", found.message);
    let mut rootless = Scalar::new(|_t, _q, _v, a| Ok(a * a + 1.0));
    let found = scalar_run(&mut rootless, 1.0, (1.0, 0.0), &options);
    assert_eq!(found.status.name(), "no_initial_acceleration");
    let mut nan = Scalar::new(|_t, _q, _v, _a| Ok(f64::NAN));
    let found = scalar_run(&mut nan, 1.0, (1.0, 0.0), &options);
    assert_eq!(found.status, Status::NoInitialAcceleration(Failure::NonFinite));
    // A given initial acceleration is used as it is, here for an equation of first order, q + v = 0.
    let options = Options { initial_acceleration: Some(vec![1.0]), ..options };
    let found = scalar_run(&mut singular, 1.0, (1.0, -1.0), &options);
    assert_eq!(found.status, Status::Finished);
    assert_eq!(found.a[0], 1.0);
    assert!((last(&found.q) - (-1.0_f64).exp()).abs() < 2e-3);
}

#[test]
fn interruptions_keep_what_was_computed() {
    let mut system = Linear::oscillator(1.0, 0.0);
    let options = Options::new(0.1);
    let found = solve(&mut system, (0.0, 1.0), &[1.0], &[0.0], &options, None, &mut |_, stepper| {
        if stepper.t() > 0.45 { Err(Interrupted) } else { Ok(()) }
    })
    .unwrap();
    assert_eq!(found.status, Status::Interrupted);
    assert_eq!(found.t.len(), 6);
    let mut stopping = Scalar::new(|t, q, _v, a| if t > 0.45 { Err(Interrupted) } else { Ok(a + q) });
    let found = scalar_run(&mut stopping, 1.0, (1.0, 0.0), &differenced(0.1));
    assert_eq!(found.status, Status::Interrupted);
    assert_eq!(found.t.len(), 5);
    let found =
        scalar_run(&mut Linear::oscillator(1.0, 0.0), 1.0, (1.0, 0.0), &Options { max_steps: 3, ..options });
    assert_eq!((found.status, found.t.len()), (Status::TooManySteps, 4));
}

#[test]
fn central_differences_beyond_their_limit_blow_up_and_say_why() {
    let mut system = Linear::oscillator(10.0, 0.0);
    let stable = scalar_run(&mut system, 100.0, (1.0, 0.0), &with_scheme(Scheme::CENTRAL_DIFFERENCE, 0.199));
    assert!(stable.status.is_success() && last(&stable.q).abs() < 20.0);
    let found = scalar_run(&mut system, 1e3, (1.0, 0.0), &with_scheme(Scheme::CENTRAL_DIFFERENCE, 0.25));
    assert_eq!(found.status, Status::Unstable);
    assert!(found.message.contains("stable only for step sizes below 2.0000"), "{}", found.message);
}

#[test]
fn presets_and_names() {
    let parameters = |name: &str| {
        let scheme = by_name(name);
        (scheme.beta(), scheme.gamma(), scheme.alpha_m(), scheme.alpha_f())
    };
    assert_eq!(parameters("newmark"), (0.25, 0.5, 0.0, 0.0));
    assert_eq!(parameters("average_acceleration"), (0.25, 0.5, 0.0, 0.0));
    assert_eq!(parameters("linear_acceleration"), (1.0 / 6.0, 0.5, 0.0, 0.0));
    assert_eq!(parameters("fox_goodwin"), (1.0 / 12.0, 0.5, 0.0, 0.0));
    assert_eq!(parameters("central_difference"), (0.0, 0.5, 0.0, 0.0));
    assert_eq!(by_name("hht"), Scheme::hht(-0.1).unwrap());
    assert_eq!(by_name("generalised_alpha"), Scheme::generalised_alpha(0.8).unwrap());
    assert_eq!(by_name("generalized_alpha"), by_name("generalised_alpha"));
    // The member of Chung and Hulbert's family with asymptotic annihilation.
    let scheme = Scheme::generalised_alpha(0.0).unwrap();
    assert_eq!((scheme.alpha_m(), scheme.alpha_f(), scheme.beta(), scheme.gamma()), (-1.0, 0.0, 1.0, 1.5));
    assert_eq!(Scheme::CENTRAL_DIFFERENCE.stability_limit(), 2.0);
    assert!((Scheme::LINEAR_ACCELERATION.stability_limit() - 12.0_f64.sqrt()).abs() < 1e-14);
    assert!((Scheme::FOX_GOODWIN.stability_limit() - 6.0_f64.sqrt()).abs() < 1e-14);
    assert!(METHODS.iter().all(|name| by_name(name).order() == 2));
}

#[test]
fn unstable_and_inconsistent_parameters_are_refused_with_the_reason() {
    let message = |result: Result<Scheme, lissom::error::InvalidInput>| result.unwrap_err().to_string();
    assert!(message(Scheme::newmark(0.25, 0.4)).contains("oscillations grow"));
    assert!(message(Scheme::newmark(-0.1, 0.5)).contains("beta"));
    assert_eq!(Scheme::newmark(f64::NAN, f64::NAN).unwrap_err().problems.len(), 2);
    assert!(message(Scheme::hht(0.1)).contains("[-1/3, 0]"));
    assert!(message(Scheme::hht(-0.4)).contains("alpha"));
    assert!(message(Scheme::generalised_alpha(1.1)).contains("rho_inf"));
    let named = |name: &str, parameters: Parameters| message(Scheme::by_name(name, &parameters));
    let given = Parameters { beta: Some(0.3), rho_inf: Some(0.5), ..Parameters::default() };
    assert!(named("newmark", given).contains("rho_inf"));
    assert!(named("hht", given).contains("beta") && named("hht", given).contains("rho_inf"));
    assert!(named("fox_goodwin", given).contains("has no beta"));
    assert!(named("houbolt", Parameters::default()).contains("\"generalised_alpha\""));
}

#[test]
fn bad_problems_are_refused_all_at_once_before_any_evaluation() {
    let mut never = Scalar::new(|_, _, _, _| -> Result<f64, Interrupted> { unreachable!("refused before") });
    let mut refused = |t_span, q0: &[f64], v0: &[f64], options: &Options| {
        solve(&mut never, t_span, q0, v0, options, None, &mut |_, _| Ok(())).unwrap_err()
    };
    let good = Options::new(0.1);
    let places = |error: lissom::error::InvalidInput| {
        error.problems.into_iter().map(|problem| problem.place).collect::<Vec<_>>()
    };
    let bad =
        Options { rtol: (-1.0).into(), atol: Some(Tolerance::Each(vec![1.0, 2.0])), ..Options::new(-1.0) };
    let found = places(refused((1.0, 0.0), &[f64::NAN], &[0.0, 1.0], &bad));
    assert_eq!(found, ["t_span[1]", "q0[0]", "v0", "dt", "rtol", "atol"]);
    assert_eq!(places(refused((0.0, f64::INFINITY), &[0.0], &[0.0], &good)), ["t_span[1]"]);
    assert_eq!(places(refused((0.0, 1.0), &[0.0], &[0.0], &Options::new(1e-20))), ["dt"]);
    let a0 = Options { initial_acceleration: Some(vec![1.0, 2.0]), ..good.clone() };
    assert_eq!(places(refused((0.0, 1.0), &[0.0], &[0.0], &a0)), ["a0"]);
    // 1e12 steps of 4 numbers each.
    let error = refused((0.0, 1e6), &[0.0], &[0.0], &Options::new(1e-6)).to_string();
    assert!(error.contains("4 GiB") && error.contains("t_eval"), "{error}");
    let wrong = Options { step_size: StepSize::Adaptive { max_step: 0.1, min_step: 0.2 }, ..good };
    assert_eq!(places(refused((0.0, 1.0), &[0.0], &[0.0], &wrong)), ["min_step"]);
}

#[test]
fn an_empty_system_is_integrated() {
    struct Empty(Facts);
    impl second_order::SecondOrderSystem for Empty {
        type Model = dyn Model;
        fn facts(&self) -> &Facts {
            &self.0
        }
        fn residual(
            &mut self,
            _: f64,
            _: &[f64],
            _: &[f64],
            _: &[f64],
            _: &mut [f64],
        ) -> Result<(), Interrupted> {
            Ok(())
        }
        fn tangent(
            &mut self,
            _: f64,
            _: &[f64],
            _: &[f64],
            _: &[f64],
            _: [f64; 3],
            _: &mut Matrix,
        ) -> Result<(), Interrupted> {
            Ok(())
        }
        fn model(&mut self) -> Option<&mut Self::Model> {
            None
        }
    }
    let found = run(&mut Empty(Facts::of_equations(0)), 1.0, &[], &[], &Options::new(0.1));
    assert_eq!((found.status, found.t.len()), (Status::Finished, 11));
}

mod adaptive_steps {
    use super::*;

    fn error_of(found: &Solution, exact: impl Fn(f64) -> [f64; 3]) -> f64 {
        (0..found.t.len())
            .map(|i| {
                let exact = exact(found.t[i]);
                (found.q[i] - exact[0]).abs().max((found.v[i] - exact[1]).abs())
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn errors_follow_the_tolerance() {
        for name in ["newmark", "fox_goodwin", "hht", "generalised_alpha"] {
            let tolerances: Vec<f64> = (2..8).map(|k| 10.0_f64.powi(-k)).collect();
            let (mut errors, mut steps) = (Vec::new(), Vec::new());
            for &tolerance in &tolerances {
                let options = Options { scheme: by_name(name), ..adaptive(0.1, tolerance) };
                let found = scalar_run(&mut Linear::oscillator(3.0, 0.02), 5.0, (1.0, 0.0), &options);
                assert!(found.status.is_success(), "{}", found.message);
                let error = error_of(&found, |t| damped_oscillation(3.0, 0.02, 1.0, 0.0, t));
                let bound = 10.0 * found.counters.steps as f64 * tolerance;
                assert!(error <= bound, "{name}, {tolerance:e}: {error:e} > {bound:e}");
                errors.push(error.ln());
                steps.push((found.counters.steps as f64).ln());
            }
            assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{name}: {errors:?}");
            let order = -slope(&steps, &errors);
            assert!((1.7..2.3).contains(&order), "{name}: {order}");
        }
    }

    #[test]
    fn blind_schemes_are_refused_with_a_remedy() {
        let refuse = |scheme| {
            let options = Options { scheme, ..adaptive(0.1, 1e-3) };
            let mut never =
                Scalar::new(|_, _, _, _| -> Result<f64, Interrupted> { unreachable!("refused before") });
            solve(&mut never, (0.0, 1.0), &[1.0], &[0.0], &options, None, &mut |_, _| Ok(()))
                .unwrap_err()
                .to_string()
        };
        for scheme in [
            Scheme::LINEAR_ACCELERATION,
            Scheme::newmark(1.0 / 6.0 + 0.009, 0.5).unwrap(),
            Scheme::newmark(1.0 / 6.0, 0.505).unwrap(),
        ] {
            let message = refuse(scheme);
            assert!(
                message.contains("blind") && message.contains("0.1667") && message.contains("fixed"),
                "{message}"
            );
        }
        for scheme in
            [Scheme::newmark(1.0 / 6.0 + 0.02, 0.5).unwrap(), Scheme::newmark(1.0 / 6.0, 0.52).unwrap()]
        {
            let options = Options { scheme, ..adaptive(0.1, 1e-4) };
            assert!(
                scalar_run(&mut Linear::oscillator(1.0, 0.0), 1.0, (1.0, 0.0), &options).status.is_success()
            );
        }
    }

    /// Displacements hardly show a fast oscillation, and at gamma = 1/2 the error estimate of the velocity
    /// vanishes.
    #[test]
    fn a_fast_oscillation_is_not_lost() {
        let frequency = 1000.0;
        let found =
            scalar_run(&mut Linear::oscillator(frequency, 0.0), 0.05, (0.0, 1.0), &adaptive(0.05, 1e-5));
        assert!(found.status.is_success());
        let error = error_of(&found, |t| damped_oscillation(frequency, 0.0, 0.0, 1.0, t));
        assert!(
            error < 0.05,
            "velocity error {error} of an amplitude of 1 in {} steps",
            found.counters.steps
        );
    }

    /// A zero error estimate is no reason to increase the step.
    #[test]
    fn a_zero_estimate_does_not_let_the_step_grow() {
        let mut falling = Scalar::new(|_t, _q, _v, a| Ok(a + 9.75));
        let options = Options { derivative: Derivative::Forward, ..adaptive(0.125, 1e-6) };
        let found = scalar_run(&mut falling, 10.0, (0.0, 0.0), &options);
        assert_eq!(found.counters.steps, 80);
    }

    #[test]
    fn bounds_of_the_step_are_kept() {
        let bounded = |max_step, min_step, tolerance| {
            let options =
                Options { step_size: StepSize::Adaptive { max_step, min_step }, ..adaptive(1.0, tolerance) };
            scalar_run(&mut Linear::oscillator(3.0, 0.0), 2.0, (1.0, 0.0), &options)
        };
        let found = bounded(0.05, 0.0, 1e-1);
        assert!(found.status.is_success());
        assert!(found.t.windows(2).all(|t| t[1] - t[0] < 0.05 * (1.0 + 1e-9)));
        let found = bounded(1.0, 0.01, 1e-8);
        assert_eq!(found.status, Status::StepTooSmall);
        assert!(found.message.contains("min_step"), "{}", found.message);
    }

    #[test]
    fn a_step_whose_equations_cannot_be_solved_is_cut() {
        // Newton's method has no root in long steps: the equations change abruptly beyond q = 1.5.
        let mut wall = Scalar::new(|_t, q, _v, a| Ok(if q > 1.5 { f64::NAN } else { a + 4.0 * q }));
        let options = Options { derivative: Derivative::Forward, ..adaptive(1.0, 1e-4) };
        let found = scalar_run(&mut wall, 3.0, (0.0, 2.9), &options);
        assert!(found.status.is_success(), "{}", found.message);
        let error = error_of(&found, |t| {
            let (sin, cos) = (2.0 * t).sin_cos();
            [1.45 * sin, 2.9 * cos, 0.0]
        });
        assert!(error < 0.1, "{error}");
    }
}

/// A system whose tangent is divided into these parts.
struct Divided<'a, S> {
    system: &'a mut S,
    facts: Facts,
}

impl<S: second_order::SecondOrderSystem> second_order::SecondOrderSystem for Divided<'_, S> {
    type Model = S::Model;
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn residual(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        r: &mut [f64],
    ) -> Result<(), Interrupted> {
        self.system.residual(t, q, v, a, r)
    }

    fn tangent(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) -> Result<(), Interrupted> {
        self.system.tangent(t, q, v, a, weights, tangent)
    }

    fn model(&mut self) -> Option<&mut S::Model> {
        self.system.model()
    }
}

/// Rods side by side on a floor, each of which rubs on its neighbours, and one that lies across a few.
fn rods_on_a_floor() -> RobotModel {
    const RODS: usize = 9;
    let rod = |i: usize| {
        let segment = Segment { modes: [1, 2, 1, 0, 0, 0], ..Segment::straight(0.3, 0.01, 1e6, 4e5, 1000.0) };
        let lying = Link { rod: vec![segment], joint: Joint::Free, ..Link::new(format!("rod {i}")) };
        let half = std::f64::consts::FRAC_1_SQRT_2;
        match i {
            0 => Link { position: [0.1, 0.0, 0.029], orientation: [half, 0.0, 0.0, half], ..lying },
            _ => Link { position: [0.002 * i as f64, 0.0199 * i as f64, 0.0099], ..lying },
        }
    };
    let between = |a: usize, b: Option<usize>| {
        let floor =
            Surface::Obstacle(Obstacle::HalfSpace(HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] }));
        let other = b.map_or(floor, |link| Surface::Rod { link });
        let contact = Contact::between(&format!("{a} {b:?}"), [Surface::Rod { link: a }, other]);
        Contact { friction: [0.3; 3], ..contact }
    };
    let pairs = (0..RODS).flat_map(|a| (a + 1..RODS).map(move |b| between(a, Some(b))));
    let contacts = pairs.chain((0..RODS).map(|a| between(a, None))).collect();
    RobotModel::new(&Robot { contacts, ..Robot::new((0..RODS).map(rod).collect()) }).unwrap()
}

/// Newton's method ends at the same accelerations, within what it leaves, whether the tangent is factorised by blocks or with all
/// its entries; and by blocks with the same bits in every run.
#[test]
fn parts_are_solved_for_as_the_whole_is() {
    let mut model = rods_on_a_floor();
    let n = model.facts().n;
    assert_eq!(model.facts().parts, [10; 9]);
    let options = Options { rtol: 1e-9.into(), atol: Some(1e-12.into()), ..Options::new(1e-3) };
    let rest = vec![0.0; n];
    let pushed: Vec<f64> = (0..n).map(|k| 0.02 * (1.3 * k as f64).sin()).collect();
    let facts = model.facts().clone();
    let parts = facts.parts.clone();
    let mut run = |parts: &[usize]| {
        let facts = Facts { parts: parts.to_vec(), ..facts.clone() };
        let mut system = Divided { system: &mut model, facts };
        let motion = solve(&mut system, (0.0, 0.03), &rest, &pushed, &options, None, &mut |_, _| Ok(()));
        let motion = motion.unwrap();
        assert!(motion.status.is_success(), "{}", motion.message);
        motion
    };
    let [parts, again, whole] = [&parts[..], &parts, &[]].map(&mut run);
    assert!(parts.q == again.q && parts.v == again.v && parts.a == again.a);
    assert_eq!(parts.t, whole.t);
    for (x, wanted, tolerance) in [(&parts.q, &whole.q, 1e-9), (&parts.v, &whole.v, 1e-6)] {
        for (x, wanted) in x.iter().zip(wanted) {
            assert!((x - wanted).abs() <= tolerance, "{x} is not {wanted}");
        }
    }
}

/// Links that the same coordinate moves are one part, as far as they come one after another; what stands on the same link without
/// coordinates is not.
#[test]
fn parts_are_what_coordinates_move() {
    let body = Body { inertia: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], ..Body::point(0.3) };
    let link = |name, parent, joint| Link { parent, joint, body: Some(body.clone()), ..Link::new(name) };
    let hinge = || Joint::Revolute { axis: [0.0, 0.0, 1.0], forces: JointForces::default() };
    let links = vec![
        link("ground", None, Joint::Weld),
        link("arm", Some(0), hinge()),
        link("forearm", Some(1), hinge()),
        link("leg", Some(0), hinge()),
        link("hand", Some(2), hinge()),
        link("stone", None, Joint::Free),
    ];
    assert_eq!(RobotModel::new(&Robot::new(links)).unwrap().facts().parts, [2, 1, 1, 6]);
}
