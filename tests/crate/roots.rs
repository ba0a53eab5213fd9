//! Newton's method: convergence, rate of convergence, and the status after a failure.

use lissom::error::Interrupted;
use lissom::linalg::Matrix;
use lissom::roots::{
    Derivative, Method, Newton, NonlinearSystem, Options, Outcome, Reuse, Status, StepTolerance,
    check_jacobian,
};

/// A system from two closures.
struct Equations<R, J> {
    unknowns: usize,
    equations: usize,
    residual: R,
    jacobian: J,
}

impl<R: FnMut(&[f64], &mut [f64]), J: FnMut(&[f64], &mut Matrix)> NonlinearSystem for Equations<R, J> {
    fn unknowns(&self) -> usize {
        self.unknowns
    }
    fn equations(&self) -> usize {
        self.equations
    }
    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        (self.residual)(x, residual);
        Ok(())
    }
    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        (self.jacobian)(x, jacobian);
        Ok(())
    }
}

fn scalar(f: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64) -> impl NonlinearSystem {
    Equations {
        unknowns: 1,
        equations: 1,
        residual: move |x: &[f64], r: &mut [f64]| r[0] = f(x[0]),
        jacobian: move |x: &[f64], j: &mut Matrix| j[(0, 0)] = slope(x[0]),
    }
}

/// The lab's f = (x^2 - 2x + 1/2)^2: two double roots, 1 -+ sqrt(1/2), and a maximum between them.
fn lab() -> impl NonlinearSystem {
    scalar(
        |x| x.powi(4) - 4.0 * x.powi(3) + 5.0 * x * x - 2.0 * x + 0.25,
        |x| 4.0 * x.powi(3) - 12.0 * x * x + 10.0 * x - 2.0,
    )
}

/// A circle and a hyperbola; one of the roots is (2 cos 15 deg, 2 sin 15 deg).
fn circle_and_hyperbola() -> impl NonlinearSystem {
    Equations {
        unknowns: 2,
        equations: 2,
        residual: |x: &[f64], r: &mut [f64]| {
            r[0] = x[0] * x[0] + x[1] * x[1] - 4.0;
            r[1] = x[0] * x[1] - 1.0;
        },
        jacobian: |x: &[f64], j: &mut Matrix| {
            *j = Matrix::from_row_slice(2, 2, &[2.0 * x[0], 2.0 * x[1], x[1], x[0]]);
        },
    }
}

fn solve(mut system: impl NonlinearSystem, start: &[f64], options: Options) -> (Outcome, Vec<f64>) {
    let mut x = start.to_vec();
    let mut newton = Newton::new(system.unknowns(), system.equations());
    let outcome = newton.solve(&mut system, &mut x, &options).expect("nobody interrupts");
    (outcome, x)
}

#[test]
fn the_defaults_are_those_of_the_lab() {
    let options = Options::default();
    assert_eq!(options.residual_tolerance, 1e-6);
    assert_eq!(options.max_iter, 1000);
    assert_eq!(options.derivative, Derivative::Analytic);
    assert_eq!(options.reuse, Reuse::Never);
    assert_eq!(options.step_tolerance, StepTolerance { absolute: 0.0, relative: 0.0 });
    assert_eq!(options.check(), Ok(()));
}

#[test]
fn the_rate_is_quadratic() {
    let root = [2.0 * 15f64.to_radians().cos(), 2.0 * 15f64.to_radians().sin()];
    let mut system = circle_and_hyperbola();
    let mut newton = Newton::new(2, 2);
    let mut x = [3.0, 1.0];
    let options = Options { residual_tolerance: 1e-13, history: true, ..Options::default() };
    let outcome = newton.solve(&mut system, &mut x, &options).unwrap();
    assert_eq!(outcome.status, Status::ConvergedResidual);
    let errors: Vec<f64> = newton
        .history()
        .iter()
        .map(|iterate| (iterate.x[0] - root[0]).hypot(iterate.x[1] - root[1]))
        .collect();
    assert_eq!(errors.len(), outcome.iterations + 1);
    assert!(*errors.last().unwrap() < 1e-14);
    for pair in errors.windows(2).filter(|pair| pair[1] > 1e-15) {
        assert!(pair[1] < 0.5 * pair[0] * pair[0], "{errors:?}");
    }
}

#[test]
fn a_linear_system_takes_one_step() {
    let matrix = Matrix::from_row_slice(3, 3, &[0.0, 2.0, -1.0, 1e6, 3.0, 0.5, 1.0, 1.0, 1e-6]);
    let (for_residual, for_jacobian) = (matrix.clone(), matrix);
    let system = Equations {
        unknowns: 3,
        equations: 3,
        residual: move |x: &[f64], r: &mut [f64]| {
            for i in 0..3 {
                r[i] = (0..3).map(|j| for_residual[(i, j)] * x[j]).sum::<f64>() - 1.0;
            }
        },
        jacobian: move |_: &[f64], j: &mut Matrix| j.copy_from(&for_jacobian),
    };
    let (outcome, _) = solve(system, &[5.0, -3.0, 20.0], Options::default());
    assert_eq!((outcome.status, outcome.iterations), (Status::ConvergedResidual, 1));
    assert_eq!(
        (outcome.residual_evaluations, outcome.jacobian_evaluations, outcome.factorisations),
        (2, 1, 1)
    );
}

#[test]
fn evaluations_are_counted() {
    for (derivative, per_jacobian) in [(Derivative::Forward, 2), (Derivative::Central, 4)] {
        let options = Options { derivative, ..Options::default() };
        let (outcome, _) = solve(circle_and_hyperbola(), &[3.0, 1.0], options);
        assert_eq!(outcome.status, Status::ConvergedResidual);
        assert_eq!(outcome.jacobian_evaluations, outcome.iterations);
        assert_eq!(outcome.difference_evaluations, per_jacobian * outcome.jacobian_evaluations);
        assert_eq!(outcome.residual_evaluations, 1 + outcome.iterations + outcome.difference_evaluations);
    }
}

#[test]
fn a_start_on_the_root_costs_one_evaluation() {
    let (outcome, x) = solve(scalar(|x| x - 2.0, |_| 1.0), &[2.0], Options::default());
    assert_eq!(
        (outcome.status, outcome.residual_evaluations, outcome.iterations),
        (Status::AlreadyRoot, 1, 0)
    );
    assert!(outcome.step_norm.is_nan());
    assert_eq!(x, [2.0]);
}

#[test]
fn the_labs_stationary_point_is_named_with_every_jacobian() {
    for derivative in [Derivative::Analytic, Derivative::Forward, Derivative::Central] {
        let (outcome, x) = solve(lab(), &[1.0], Options { derivative, ..Options::default() });
        assert_eq!(outcome.status, Status::StationaryPoint, "{derivative:?}");
        assert_eq!((outcome.iterations, x[0]), (0, 1.0));
    }
}

#[test]
fn the_labs_double_roots_are_found_slowly() {
    for start in [6.0, 0.7] {
        for derivative in [Derivative::Analytic, Derivative::Forward, Derivative::Central] {
            let (outcome, x) = solve(lab(), &[start], Options { derivative, ..Options::default() });
            assert_eq!(outcome.status, Status::ConvergedResidual);
            assert!(((x[0] - 1.0).abs() - 0.5f64.sqrt()).abs() < 1e-3);
            assert!(outcome.iterations > 5, "a double root is approached linearly");
        }
    }
}

#[test]
fn least_squares_and_underdetermined_systems() {
    // x + y + z = 6 from the origin: the nearest solution is (2, 2, 2).
    let plane = Equations {
        unknowns: 3,
        equations: 1,
        residual: |x: &[f64], r: &mut [f64]| r[0] = x[0] + x[1] + x[2] - 6.0,
        jacobian: |_: &[f64], j: &mut Matrix| j.fill(1.0),
    };
    let (outcome, x) = solve(plane, &[0.0; 3], Options::default());
    assert_eq!(outcome.status, Status::ConvergedResidual);
    assert!(x.iter().all(|v| (v - 2.0).abs() < 1e-14));
    // x = 1 and x = 3: the least-squares solution is 2, which is not a root.
    let contradiction = Equations {
        unknowns: 1,
        equations: 2,
        residual: |x: &[f64], r: &mut [f64]| (r[0], r[1]) = (x[0] - 1.0, x[0] - 3.0),
        jacobian: |_: &[f64], j: &mut Matrix| j.fill(1.0),
    };
    let (outcome, x) = solve(contradiction, &[10.0], Options::default());
    assert_eq!(outcome.status, Status::StationaryPoint);
    assert!((x[0] - 2.0).abs() < 1e-14);
}

#[test]
fn failures_are_named() {
    let run = |system: &mut dyn NonlinearSystem, start: f64| {
        let mut x = [start];
        let outcome = Newton::new(1, 1).solve(system, &mut x, &Options::default()).unwrap();
        assert!(!outcome.status.is_success());
        (outcome.status, x[0])
    };
    assert_eq!(run(&mut scalar(|_| f64::NAN, |_| 1.0), 0.3), (Status::NonFiniteResidual, 0.3));
    assert_eq!(run(&mut scalar(|x| x.ln() - 1.0, |x| 1.0 / x), 20.0), (Status::NonFiniteResidual, 20.0));
    assert_eq!(run(&mut scalar(|x| x - 1.0, |_| f64::INFINITY), 0.3), (Status::NonFiniteJacobian, 0.3));
    assert_eq!(run(&mut scalar(|_| 1e10, |_| 1e-300), 0.0), (Status::SingularJacobian, 0.0));
    // No real root: the iterates wander, and the best one is returned.
    let (status, x) = run(&mut scalar(|x| x * x + 1.0, |x| 2.0 * x), 3.0);
    assert_eq!(status, Status::IterationLimit);
    assert!(x.abs() < 0.1, "{x}");
    let (status, x) = run(&mut scalar(f64::atan, |x| 1.0 / (1.0 + x * x)), 2.0);
    assert_eq!((status, x), (Status::Diverged, 2.0));
    // A wrong Jacobian: the steps vanish but the residual does not.
    let (status, _) = run(&mut scalar(|_| 1.0, |_| 1e20), 3.0);
    assert_eq!(status, Status::Stalled);
}

#[test]
fn a_pole_is_no_root_for_the_step_rule() {
    let options =
        Options { step_tolerance: StepTolerance { absolute: 1e-8, relative: 0.0 }, ..Options::default() };
    let (outcome, _) = solve(scalar(|x| 1.0 / x, |x| -1.0 / (x * x)), &[1e-12], options);
    assert_ne!(outcome.status, Status::ConvergedStep);
}

#[test]
fn the_step_rule_stops_where_the_residual_cannot_be_small() {
    // Residuals of 1e20: a tolerance of 1e-6 is out of reach.
    let system = || scalar(|x| 1e20 * (x * x - 2.0), |x| 2e20 * x);
    let step_tolerance = StepTolerance { absolute: 0.0, relative: 1e-3 };
    let (by_rule, x) = solve(system(), &[1.0], Options { step_tolerance, ..Options::default() });
    assert_eq!(by_rule.status, Status::ConvergedStep);
    assert!((x[0] - 2f64.sqrt()).abs() < 1e-5);
    let (by_rounding, x) = solve(system(), &[1.0], Options::default());
    assert_eq!(by_rounding.status, Status::ConvergedStep);
    assert!((x[0] - 2f64.sqrt()).abs() < 1e-15);
    assert!(by_rule.iterations < by_rounding.iterations);
}

#[test]
fn scales_decide_what_is_small() {
    let system = || scalar(|x| 1e9 * (x * x - 2.0), |x| 2e9 * x);
    let mut x = [1.0];
    let mut newton = Newton::new(1, 1).with_scales(&[1.0], &[1e9]).unwrap();
    let outcome = newton.solve(&mut system(), &mut x, &Options::default()).unwrap();
    assert_eq!(outcome.status, Status::ConvergedResidual);
    assert!(outcome.residual_norm <= 1e-6 && outcome.iterations < 6);
    assert!(Newton::new(1, 1).with_scales(&[0.0], &[1.0]).is_err());
    assert!(Newton::new(1, 1).with_scales(&[1.0, 1.0], &[1.0]).is_err());
}

#[test]
fn a_kept_jacobian_saves_factorisations() {
    let options = |reuse| Options { reuse, residual_tolerance: 1e-10, ..Options::default() };
    let (fresh, _) = solve(circle_and_hyperbola(), &[2.2, 0.6], options(Reuse::Never));
    let (chord, x) = solve(circle_and_hyperbola(), &[2.2, 0.6], options(Reuse::WithinSolve));
    assert_eq!(chord.status, Status::ConvergedResidual);
    assert!(chord.factorisations < fresh.factorisations, "{chord:?} {fresh:?}");
    assert!((x[0] * x[1] - 1.0).abs() < 1e-10);
}

#[test]
fn a_kept_jacobian_serves_later_solves_and_is_dropped_when_it_does_not() {
    // x^2 = c with c that changes a little from solve to solve, as in the time steps of an integrator.
    let mut newton = Newton::new(1, 1);
    let mut x = [1.0];
    let options = Options { reuse: Reuse::AcrossSolves, residual_tolerance: 1e-9, ..Options::default() };
    let mut solve_for = |c: f64, x: &mut [f64; 1]| {
        newton.solve(&mut scalar(move |x| x * x - c, |x| 2.0 * x), x, &options).unwrap()
    };
    assert_eq!(solve_for(1.01, &mut x).factorisations, 1);
    assert_eq!(solve_for(1.02, &mut x).factorisations, 0);
    let far = solve_for(100.0, &mut x);
    assert_eq!(far.status, Status::ConvergedResidual);
    assert!(far.factorisations >= 1);
    assert!((x[0] - 10.0).abs() < 1e-9);
}

#[test]
fn an_interruption_comes_through() {
    struct Impatient;
    impl NonlinearSystem for Impatient {
        fn unknowns(&self) -> usize {
            1
        }
        fn residual(&mut self, _: &[f64], _: &mut [f64]) -> Result<(), Interrupted> {
            Err(Interrupted)
        }
        fn jacobian(&mut self, _: &[f64], _: &mut Matrix) -> Result<(), Interrupted> {
            Err(Interrupted)
        }
    }
    let (mut newton, mut x) = (Newton::new(1, 1), [1.0]);
    let outcome = newton.solve(&mut Impatient, &mut x, &Options::default()).unwrap_err().into_inner();
    assert_eq!((outcome.status, outcome.iterations, x), (Status::Interrupted, 0, [1.0]));
    assert!(outcome.residual_norm.is_nan() && newton.residual()[0].is_nan());
}

#[test]
fn senseless_options_are_refused_all_at_once() {
    let options = Options { residual_tolerance: f64::NAN, chord_rate: 1.5, ..Options::default() };
    assert_eq!(options.check().unwrap_err().problems.len(), 2);
}

#[test]
fn globalised_methods_come_back_from_far_away() {
    // Newton's method alone diverges for |x| > 1.39.
    for method in [Method::LineSearch, Method::TrustRegion] {
        for derivative in [Derivative::Analytic, Derivative::Forward, Derivative::Central] {
            let options = Options { method, derivative, history: true, ..Options::default() };
            let mut newton = Newton::new(1, 1);
            let mut x = [20.0];
            let mut system = scalar(f64::atan, |x| 1.0 / (1.0 + x * x));
            let outcome = newton.solve(&mut system, &mut x, &options).unwrap();
            assert_eq!(outcome.status, Status::ConvergedResidual, "{method:?} {derivative:?}");
            assert!(newton.history().windows(2).all(|pair| pair[1].residual_norm < pair[0].residual_norm));
        }
    }
}

#[test]
fn globalised_methods_name_a_minimum_that_is_no_root() {
    for method in [Method::LineSearch, Method::TrustRegion] {
        let options = Options { method, ..Options::default() };
        let (outcome, x) = solve(scalar(|x| x * x + 1.0, |x| 2.0 * x), &[3.0], options);
        assert_eq!(outcome.status, Status::StationaryPoint);
        assert!(x[0].abs() < 1e-4);
    }
}

#[test]
fn multiple_roots_are_recognised_and_stepped_over() {
    let (plain, _) = solve(lab(), &[6.0], Options::default());
    assert_eq!((plain.multiplicity, plain.iterations), (Some(2), 16));
    let (accelerated, x) = solve(lab(), &[6.0], Options { accelerate: true, ..Options::default() });
    assert_eq!((accelerated.multiplicity, accelerated.iterations), (Some(2), 5));
    assert!((x[0] - 1.0 - 0.5f64.sqrt()).abs() < 1e-4);
    assert!(accelerated.message().contains("multiplicity 2"));
}

#[test]
fn steps_may_be_limited() {
    let options = Options { longest_step: Some(3.0), ..Options::default() };
    let (outcome, _) = solve(scalar(|x| x - 10.0, |_| 1.0), &[0.0], options);
    assert_eq!(outcome.iterations, 4);
    let endless = Options { longest_step: Some(0.1), residual_tolerance: 1e-12, ..Options::default() };
    let (outcome, _) = solve(scalar(|x| (-x).exp(), |x| -(-x).exp()), &[0.0], endless);
    assert_eq!(outcome.status, Status::LongestSteps);
}

#[test]
fn a_wrong_entry_of_a_jacobian_is_found() {
    let x = [1.3, -0.4];
    let check = check_jacobian(&mut circle_and_hyperbola(), &x, &[1.0; 2]).unwrap().unwrap();
    assert!(check.relative_difference < 1e-9);
    let mut wrong = Equations {
        unknowns: 2,
        equations: 2,
        residual: |x: &[f64], r: &mut [f64]| (r[0], r[1]) = (x[0] * x[1], x[1].sin()),
        jacobian: |x: &[f64], j: &mut Matrix| {
            *j = Matrix::from_row_slice(2, 2, &[x[1], x[0], 0.0, -x[1].cos()]);
        },
    };
    let check = check_jacobian(&mut wrong, &x, &[1.0; 2]).unwrap().unwrap();
    assert_eq!((check.row, check.column), (1, 1));
    assert!((check.given + check.difference).abs() < 1e-9);
    assert!((check.relative_difference - 2.0).abs() < 1e-6);
}
