//! Radau IIA of order 5 for equations of motion of second order.

use lissom::error::Interrupted;
use lissom::linalg::Matrix;
use lissom::model::{Dynamics, Facts, Model};
use lissom::ode::{self, FirstOrder, Output};
use lissom::pendulum::SpringPendulum;
use lissom::radau::{Options, Stepper, solve};
use lissom::robot::{RobotModel, Rod};
use lissom::rod::Segment;
use lissom::second_order;
use lissom::second_order::Solution;

fn two_segments() -> RobotModel {
    let segment = Segment {
        modes: [2, 2, 2, 0, 0, 0],
        retardation_time: 0.01,
        ..Segment::straight(0.3, 0.02, 1e6, 4e5, 1e3)
    };
    RobotModel::of_rod(&Rod { tip_force: [0.0, 0.05, 0.0], ..Rod::new(vec![segment.clone(), segment]) })
        .unwrap()
}

fn within(rtol: f64, atol: f64) -> Options {
    Options { rtol: rtol.into(), atol: atol.into(), ..Options::default() }
}

fn run<M: Model>(model: &mut M, t_end: f64, q0: &[f64], options: &Options, times: &[f64]) -> Solution {
    let v0 = vec![0.0; q0.len()];
    let found = solve(model, (0.0, t_end), q0, &v0, options, Some(times), &mut |_, _| Ok(())).unwrap();
    assert!(found.status.is_success(), "{}", found.message);
    found
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Errors of displacements and velocities at some times, and the mean step size, for decreasing tolerances.
fn errors_by_step_size(times: &[f64]) -> Vec<(f64, [f64; 2])> {
    let (start, t_end) = ([-0.7, 0.5], times[times.len() - 1]);
    let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
    let exact = run(&mut pendulum, t_end, &start, &within(1e-13, 1e-14), times);
    let tolerances = [1e-7, 1e-8, 1e-9];
    let measure = |tolerance: &f64| {
        let found = run(&mut pendulum, t_end, &start, &within(*tolerance, *tolerance), times);
        let errors = [largest_difference(&found.q, &exact.q), largest_difference(&found.v, &exact.v)];
        (t_end / found.counters.steps as f64, errors)
    };
    tolerances.iter().map(measure).collect()
}

/// Slope of the regression line of log(error) over log(step size).
fn order(errors: &[(f64, [f64; 2])], of: usize) -> f64 {
    let points: Vec<[f64; 2]> = errors.iter().map(|(h, errors)| [h.ln(), errors[of].ln()]).collect();
    let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let covariance: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    covariance / points.iter().map(|point| (point[0] - x).powi(2)).sum::<f64>()
}

#[test]
fn order_five_at_and_between_the_steps() {
    let times: Vec<f64> = (0..80).map(|i| 0.0123 * f64::from(i) + 0.003).collect();
    let errors = errors_by_step_size(&times);
    for of in [0, 1] {
        let order = order(&errors, of);
        assert!((4.6..5.6).contains(&order), "order {order} from {errors:?}");
    }
}

#[test]
fn agrees_with_the_first_order_method_on_a_stiff_rod() {
    let mut model = two_segments();
    let (n, t_end) = (model.facts().n, 0.5);
    let times = [0.1, 0.25, t_end];
    let q0 = vec![0.0; n];
    let found = run(&mut model, t_end, &q0, &within(1e-8, 1e-10), &times);
    let options = ode::Options {
        method: ode::Method::Radau,
        rtol: 1e-9.into(),
        atol: 1e-11.into(),
        ..ode::Options::default()
    };
    let y0 = vec![0.0; 2 * n];
    let mut system = FirstOrder::new(model);
    let other =
        ode::solve(&mut system, (0.0, t_end), &y0, &options, &Output::at(times), &mut [], &mut |_| Ok(()))
            .unwrap();
    for i in 0..times.len() {
        let difference = largest_difference(&found.q[i * n..][..n], &other.state(i)[..n]);
        assert!(difference < 1e-6, "{difference:e} at t = {}", times[i]);
    }
}

#[test]
fn the_error_follows_the_tolerance() {
    let mut model = two_segments();
    let q0 = vec![0.0; model.facts().n];
    let exact = run(&mut model, 0.5, &q0, &within(1e-11, 1e-12), &[0.5]);
    let errors = [1e-3, 1e-5, 1e-7].map(|tolerance| {
        let found = run(&mut model, 0.5, &q0, &within(tolerance, 1e-2 * tolerance), &[0.5]);
        assert_eq!(found.counters.unsolved, 0, "{:?}", found.counters);
        (largest_difference(&found.q, &exact.q), found.counters.steps)
    });
    assert!(errors[0].0 < 1e-3 && errors[1].0 < 0.02 * errors[0].0 && errors[2].0 < 0.02 * errors[1].0);
    assert!(errors[0].1 < 100 && errors[2].1 < 1000, "{errors:?}");
}

#[test]
fn accelerations_balance_the_equations_of_motion() {
    let mut model = two_segments();
    let n = model.facts().n;
    let q0 = vec![0.0; n];
    let found = run(&mut model, 0.3, &q0, &within(1e-9, 1e-11), &[0.3]);
    let mut acceleration = vec![0.0; n];
    let mut scratch = lissom::model::ForwardScratch::new(n);
    model.forward_dynamics(&found.q, &found.v, &mut acceleration, &mut scratch).unwrap();
    let size = acceleration.iter().fold(0.0_f64, |size, a| size.max(a.abs()));
    assert!(largest_difference(&acceleration, &found.a) < 1e-3 * size, "{acceleration:?} {:?}", found.a);
}

/// `mass a + q = force`, with a mass and a force that may fail.
struct Oscillator {
    facts: Facts,
    mass: f64,
    force: fn(f64) -> f64,
}

impl second_order::SecondOrderSystem for Oscillator {
    type Model = dyn Model;
    fn facts(&self) -> &Facts {
        &self.facts
    }
    fn residual(
        &mut self,
        t: f64,
        q: &[f64],
        _v: &[f64],
        a: &[f64],
        residual: &mut [f64],
    ) -> Result<(), Interrupted> {
        residual[0] = self.mass * a[0] + q[0] - (self.force)(t);
        Ok(())
    }
    fn tangent(
        &mut self,
        _t: f64,
        _q: &[f64],
        _v: &[f64],
        _a: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) -> Result<(), Interrupted> {
        tangent[(0, 0)] = weights[0] + weights[2] * self.mass;
        Ok(())
    }
    fn model(&mut self) -> Option<&mut Self::Model> {
        None
    }
}

fn status(mass: f64, force: fn(f64) -> f64, options: &Options) -> (&'static str, Option<f64>, String) {
    let mut system = Oscillator { facts: Facts::of_equations(1), mass, force };
    let found = solve(&mut system, (0.0, 10.0), &[1.0], &[0.0], options, None, &mut |_, _| Ok(())).unwrap();
    (found.status.name(), found.t.last().copied(), found.message)
}

#[test]
fn failures_are_statuses_with_what_to_do() {
    let options = Options::default();
    assert_eq!(status(1.0, |_| 0.0, &options).0, "finished");
    let (name, t, _) = status(0.0, |_| 0.0, &options);
    assert_eq!((name, t), ("no_initial_acceleration", None));
    let (name, t, message) = status(1.0, |t| if t < 3.0 { 0.0 } else { f64::NAN }, &options);
    assert_eq!(name, "non_finite");
    assert!((t.unwrap() - 3.0).abs() < 1e-9 && message.contains("near the last state"), "{message}");
    let (name, t, message) = status(1.0, f64::sin, &Options { max_steps: 3, ..Options::default() });
    assert_eq!(name, "too_many_steps");
    assert!(t.unwrap() < 10.0 && message.contains("max_steps"), "{message}");
    let (name, _, message) = status(1.0, f64::sin, &Options { min_step: 1.0, ..within(1e-12, 1e-12) });
    assert_eq!(name, "step_too_small");
    assert!(message.contains("min_step"), "{message}");
}

#[test]
fn the_last_step_ends_at_the_end() {
    let mut system = Oscillator { facts: Facts::of_equations(1), mass: 1.0, force: |_| 0.0 };
    let found =
        solve(&mut system, (0.0, 10.0), &[1.0], &[0.0], &within(1e-10, 1e-10), None, &mut |_, _| Ok(()))
            .unwrap();
    assert_eq!(found.t.last(), Some(&10.0));
    assert!((found.q.last().unwrap() - 10.0_f64.cos()).abs() < 1e-8);
}

#[test]
fn the_monitor_stops_the_run_and_keeps_what_was_computed() {
    let mut system = Oscillator { facts: Facts::of_equations(1), mass: 1.0, force: |_| 0.0 };
    let mut monitor =
        |_: &mut Oscillator, stepper: &Stepper| if stepper.t() > 2.0 { Err(Interrupted) } else { Ok(()) };
    let found =
        solve(&mut system, (0.0, 10.0), &[1.0], &[0.0], &Options::default(), None, &mut monitor).unwrap();
    assert_eq!(found.status.name(), "interrupted");
    assert!(found.t.last().unwrap() > &2.0);
}

#[test]
fn everything_wrong_is_said_before_any_evaluation() {
    let mut system = Oscillator { facts: Facts::of_equations(1), mass: 1.0, force: |_| panic!("evaluated") };
    let options = Options { first_step: Some(-1.0), max_step: 0.0, ..within(f64::NAN, -1.0) };
    let error = solve(&mut system, (0.0, 1.0), &[1.0], &[0.0], &options, None, &mut |_, _| Ok(()))
        .unwrap_err()
        .to_string();
    for name in ["rtol", "atol", "first_step", "max_step"] {
        assert!(error.contains(name), "{name}: {error}");
    }
    let mut none = Oscillator { facts: Facts::of_equations(1), mass: 1.0, force: |_| 0.0 };
    let error = solve(&mut none, (1.0, 0.0), &[1.0], &[0.0], &Options::default(), None, &mut |_, _| Ok(()));
    assert!(error.unwrap_err().to_string().contains("t_span[1]"));
}
