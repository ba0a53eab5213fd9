//! Integration of initial value problems, through the public interface.

use std::f64::consts::PI;
use std::num::NonZeroUsize;

use lissom::error::Interrupted;
use lissom::linalg::Matrix;
use lissom::ode::{
    Controller, Counters, Direction, Event, FirstOrderSystem, JacobianKind, Method, Options, Output,
    Solution, Sparsity, Status, Stepper, solve,
};

/// A system from a function.
struct Function<F>(usize, F);

impl<F: FnMut(f64, &[f64], &mut [f64])> FirstOrderSystem for Function<F> {
    fn n(&self) -> usize {
        self.0
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
        self.1(t, y, dydt);
        Ok(())
    }
}

fn oscillator() -> impl FirstOrderSystem {
    Function(2, |_, y: &[f64], dydt: &mut [f64]| {
        dydt[0] = y[1];
        dydt[1] = -y[0];
    })
}

const METHODS: [Method; 3] = [Method::Rk45, Method::Dop853, Method::Radau];

fn tight(method: Method) -> Options {
    Options { method, rtol: 1e-10.into(), atol: 1e-12.into(), ..Options::default() }
}

fn run(
    system: &mut dyn FirstOrderSystem,
    t_span: (f64, f64),
    y0: &[f64],
    options: &Options,
    output: &Output,
) -> Solution {
    solve(system, t_span, y0, options, output, &mut [], &mut |_| Ok(())).expect("the input is right")
}

fn last(solution: &Solution) -> (f64, &[f64]) {
    let index = solution.t.len() - 1;
    (solution.t[index], solution.state(index))
}

#[test]
fn defaults_are_those_of_scipy() {
    let options = Options::default();
    assert_eq!(options.method, Method::Rk45);
    assert_eq!((options.rtol.clone(), options.atol.clone()), (1e-3.into(), 1e-6.into()));
    assert_eq!((options.first_step, options.max_step, options.min_step), (None, f64::INFINITY, 0.0));
    assert_eq!(options.max_steps, usize::MAX);
    assert_eq!(options.controller, Controller::Integral);
    let solution = run(&mut oscillator(), (0.0, 10.0), &[1.0, 0.0], &options, &Output::default());
    assert_eq!(solution.status, Status::Finished);
    let (t, y) = last(&solution);
    assert_eq!((solution.t[0], t), (0.0, 10.0));
    assert!((y[0] - t.cos()).abs() < 1e-2);
    assert!(solution.dense.is_none() && solution.events.is_empty());
}

#[test]
fn forward_and_backward_with_dense_output_and_given_times() {
    for method in METHODS {
        for t_end in [3.0, -3.0] {
            let times: Vec<f64> = (0..=30).map(|i| t_end * f64::from(i) / 30.0).collect();
            let output = Output { dense: true, ..Output::at(times.clone()) };
            let solution = run(&mut oscillator(), (0.0, t_end), &[1.0, 0.0], &tight(method), &output);
            assert_eq!(solution.t, times);
            let dense = solution.dense.as_ref().unwrap();
            let mut y = [0.0; 2];
            for (i, &t) in times.iter().enumerate() {
                dense.evaluate(t, &mut y);
                assert!((y[0] - t.cos()).abs() < 1e-8 && (y[1] + t.sin()).abs() < 1e-8, "{method:?} {t}");
                assert!((y[0] - solution.state(i)[0]).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn nothing_is_evaluated_beyond_the_end() {
    for method in METHODS {
        for t_end in [0.1 + 0.2, -1.0 / 3.0, 1e-4] {
            let mut furthest: f64 = 0.0;
            let mut system = Function(1, |t: f64, y: &[f64], dydt: &mut [f64]| {
                furthest = furthest.max(t / t_end);
                dydt[0] = y[0];
            });
            let output = Output { dense: true, ..Output::default() };
            let solution = run(&mut system, (0.0, t_end), &[1.0], &tight(method), &output);
            assert_eq!(last(&solution).0, t_end);
            assert_eq!(furthest, 1.0, "{method:?}");
        }
    }
}

#[test]
fn events_inside_of_a_step_are_found_in_order() {
    let mut events = [
        Event { terminal: NonZeroUsize::new(3), ..Event::new(|_, y: &[f64]| Ok(y[0])) },
        Event::new(|_, y: &[f64]| Ok(y[1])).direction(Direction::Rising),
        // Has two zeros within one step of an integration with loose tolerances.
        Event::new(|t, _: &[f64]| Ok((t - 2.0) * (t - 2.3))),
    ];
    let solution = solve(
        &mut oscillator(),
        (0.0, 100.0),
        &[1.0, 0.0],
        &tight(Method::Dop853),
        &Output::default(),
        &mut events,
        &mut |_| Ok(()),
    )
    .unwrap();
    assert_eq!(solution.status, Status::Event);
    let expected: [&[f64]; 3] = [&[0.5 * PI, 1.5 * PI, 2.5 * PI], &[PI], &[2.0, 2.3]];
    for (found, expected) in solution.events.iter().zip(expected) {
        assert_eq!(found.t.len(), expected.len(), "{found:?} {expected:?}");
        for (found, expected) in found.t.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
    }
    let (t, y) = last(&solution);
    assert_eq!(t, solution.events[0].t[2]);
    assert!(y[0].abs() < 1e-14);
}

#[test]
fn an_integration_restarted_at_an_event_does_not_find_it_again() {
    let mut event = [Event::new(|_, y: &[f64]| Ok(y[0])).terminal()];
    let (options, output) = (Options::default(), Output::default());
    let mut free_fall = Function(2, |_, y: &[f64], dydt: &mut [f64]| {
        dydt[0] = y[1];
        dydt[1] = -2.0;
    });
    let solution =
        solve(&mut free_fall, (0.0, 9.0), &[0.0, 3.0], &options, &output, &mut event, &mut |_| Ok(()))
            .unwrap();
    assert_eq!(solution.status, Status::Event);
    assert!((last(&solution).0 - 3.0).abs() < 1e-12);
}

#[test]
fn failures_have_a_reason_and_keep_what_was_computed() {
    let span = (0.0, 10.0);
    for method in METHODS {
        let options = Options { method, ..Options::default() };
        let output = Output::default();
        let mut blow_up = Function(1, |_, y: &[f64], dydt: &mut [f64]| dydt[0] = y[0] * y[0]);
        let solution = run(&mut blow_up, span, &[1.0], &options, &output);
        assert_eq!(solution.status, Status::StepTooSmall, "{}", solution.message);
        assert!((last(&solution).0 - 1.0).abs() < 1e-2);
        assert!(solution.y.iter().all(|y| y.is_finite()));

        let mut undefined = Function(1, |t: f64, _: &[f64], dydt: &mut [f64]| dydt[0] = (2.0 - t).sqrt());
        let solution = run(&mut undefined, span, &[1.0], &options, &output);
        assert_eq!(solution.status, Status::NonFinite, "{}", solution.message);
        assert!(solution.y.iter().all(|y| y.is_finite()));
        assert!((last(&solution).0 - 2.0).abs() < 1e-6);

        let mut never = Function(1, |_, _: &[f64], dydt: &mut [f64]| dydt[0] = f64::NAN);
        let solution = run(&mut never, span, &[1.0], &options, &output);
        assert_eq!((solution.status, solution.t.len()), (Status::NonFinite, 1));

        let mut growth = Function(1, |_, y: &[f64], dydt: &mut [f64]| dydt[0] = y[0]);
        let solution = run(&mut growth, span, &[1.0], &Options { max_steps: 3, ..options.clone() }, &output);
        assert_eq!((solution.status, solution.t.len()), (Status::TooManySteps, 4));
        assert!(solution.message.contains("`max_steps`"), "{}", solution.message);

        let coarse = Options { min_step: 1.0, rtol: 1e-12.into(), ..options };
        let solution = run(&mut growth, span, &[1.0], &coarse, &output);
        assert_eq!(solution.status, Status::StepTooSmall);
        assert!(solution.message.contains("`min_step`"), "{}", solution.message);
    }
}

#[test]
fn the_monitor_and_the_system_can_stop() {
    let (options, output) = (Options::default(), Output::default());
    let mut stop = |stepper: &Stepper| if stepper.t() > 1.0 { Err(Interrupted) } else { Ok(()) };
    let solution =
        solve(&mut oscillator(), (0.0, 10.0), &[1.0, 0.0], &options, &output, &mut [], &mut stop).unwrap();
    assert_eq!(solution.status, Status::Interrupted);
    assert!(last(&solution).0 > 1.0 && last(&solution).0 < 3.0);

    struct Failing;
    impl FirstOrderSystem for Failing {
        fn n(&self) -> usize {
            1
        }
        fn rhs(&mut self, t: f64, _: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
            dydt[0] = 1.0;
            if t > 5.0 { Err(Interrupted) } else { Ok(()) }
        }
    }
    let solution = run(&mut Failing, (0.0, 10.0), &[1.0], &options, &output);
    assert_eq!(solution.status, Status::Interrupted);
    assert!(last(&solution).0 <= 5.0);
}

#[test]
fn empty_and_zero_length_problems() {
    for method in METHODS {
        let options = Options { method, ..Options::default() };
        let output = Output { dense: true, ..Output::default() };
        let mut decay = Function(1, |_, y: &[f64], dydt: &mut [f64]| dydt[0] = -y[0]);
        let solution = run(&mut decay, (4.0, 4.0), &[2.0], &options, &output);
        assert_eq!((solution.status, &solution.t[..]), (Status::Finished, &[4.0, 4.0][..]));
        let mut y = [0.0];
        solution.dense.unwrap().evaluate(5.0, &mut y);
        assert_eq!(y, [2.0]);

        let mut nothing = Function(0, |_, _: &[f64], _: &mut [f64]| ());
        let solution = run(&mut nothing, (0.0, f64::INFINITY), &[], &options, &output);
        assert_eq!(solution.status, Status::Finished);
        solution.dense.unwrap().evaluate(5.0, &mut []);
    }
}

#[test]
fn stiffness_is_noticed_and_the_remedy_named() {
    for method in [Method::Rk45, Method::Dop853] {
        let mut stiff = Function(1, |t: f64, y: &[f64], dydt: &mut [f64]| dydt[0] = -1e4 * (y[0] - t.cos()));
        let options = Options { method, ..Options::default() };
        let solution = run(&mut stiff, (0.0, 10.0), &[0.0], &options, &Output::at([10.0]));
        assert!(solution.status.is_success());
        assert!(solution.stiff_at.is_some());
        assert!(solution.message.contains("radau"), "{}", solution.message);

        let options = Options { rtol: 1e-8.into(), ..options };
        let solution = run(&mut oscillator(), (0.0, 5e3), &[1.0, 0.0], &options, &Output::at([5e3]));
        assert!(solution.counters.accepted > 1000 && solution.stiff_at.is_none());
    }
}

/// `y' = A y` with a stiff matrix, exact solution `(e^-t + e^-1000t, e^-t - e^-1000t) / 2`.
struct StiffLinear {
    kind: JacobianKind,
    jacobians: usize,
}

impl FirstOrderSystem for StiffLinear {
    fn n(&self) -> usize {
        2
    }
    fn rhs(&mut self, _: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
        dydt[0] = -500.5 * y[0] + 499.5 * y[1];
        dydt[1] = 499.5 * y[0] - 500.5 * y[1];
        Ok(())
    }
    fn jacobian_kind(&self) -> JacobianKind {
        self.kind
    }
    fn jacobian(&mut self, _: f64, _: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        self.jacobians += 1;
        jacobian.copy_from_slice(&[-500.5, 499.5, 499.5, -500.5]);
        Ok(())
    }
}

#[test]
fn radau_takes_every_kind_of_jacobian() {
    let options =
        Options { rtol: 1e-8.into(), atol: 1e-10.into(), method: Method::Radau, ..Options::default() };
    for kind in [JacobianKind::Differenced, JacobianKind::Supplied, JacobianKind::Constant] {
        let mut system = StiffLinear { kind, jacobians: 0 };
        let solution = run(&mut system, (0.0, 2.0), &[1.0, 0.0], &options, &Output::default());
        let (t, y) = last(&solution);
        let exact = 0.5 * (-t).exp();
        assert!(y.iter().all(|y| (y - exact).abs() < 1e-7), "{kind:?} {y:?}");
        let Counters { nfev_jacobian, njev, nlu, .. } = solution.counters;
        // An explicit method would need more than 1000 steps for stability alone.
        assert!(nlu > 0 && solution.counters.accepted < 600, "{:?}", solution.counters);
        match kind {
            // A column whose differences are not significant is evaluated again.
            JacobianKind::Differenced => assert!(nfev_jacobian >= 2 * njev && system.jacobians == 0),
            JacobianKind::Supplied => assert_eq!((nfev_jacobian, system.jacobians), (0, njev)),
            JacobianKind::Constant => assert_eq!((nfev_jacobian, njev, system.jacobians), (0, 0, 1)),
        }
    }
}

#[test]
fn a_jacobian_that_is_promised_but_missing_ends_with_a_status() {
    struct Promise(JacobianKind);
    impl FirstOrderSystem for Promise {
        fn n(&self) -> usize {
            1
        }
        fn rhs(&mut self, _: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
            dydt[0] = -y[0];
            Ok(())
        }
        fn jacobian_kind(&self) -> JacobianKind {
            self.0
        }
    }
    let options = Options { method: Method::Radau, ..Options::default() };
    for kind in [JacobianKind::Supplied, JacobianKind::Constant] {
        let solution = run(&mut Promise(kind), (0.0, 1.0), &[1.0], &options, &Output::default());
        assert_eq!(solution.status, Status::NonFiniteJacobian, "{kind:?}");
        assert!(solution.counters.rejected < 5, "{kind:?}: {} rejected steps", solution.counters.rejected);
    }
}

#[test]
fn an_interrupted_step_can_be_tried_again() {
    struct Moody(bool);
    impl FirstOrderSystem for Moody {
        fn n(&self) -> usize {
            1
        }
        fn rhs(&mut self, _: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
            dydt[0] = -y[0];
            if self.0 { Err(Interrupted) } else { Ok(()) }
        }
    }
    for method in METHODS {
        let options = Options { method, ..Options::default() };
        let stepper = || Stepper::new(1, (0.0, 3.0), &[1.0], &options).unwrap();
        let (mut smooth, mut interrupted) = (stepper(), stepper());
        while smooth.step(&mut Moody(false)).unwrap().is_none() {
            assert_eq!(interrupted.step(&mut Moody(true)), Err(Interrupted));
            interrupted.step(&mut Moody(false)).unwrap();
            assert_eq!((interrupted.t(), interrupted.y()), (smooth.t(), smooth.y()));
        }
    }
}

#[test]
fn bad_input_is_refused_with_all_its_problems() {
    let refused = |t_span, y0: &[f64], options: &Options, output: &Output| {
        let mut decay = Function(1, |_, _: &[f64], _: &mut [f64]| panic!("nothing is evaluated"));
        let error = solve(&mut decay, t_span, y0, options, output, &mut [], &mut |_| Ok(())).unwrap_err();
        error.problems.into_iter().map(|problem| problem.place).collect::<Vec<_>>()
    };
    let options = Options {
        rtol: (-1.0).into(),
        atol: vec![1e-6, 1e-6].into(),
        max_step: 0.0,
        min_step: f64::NAN,
        ..Options::default()
    };
    let places = refused((f64::NAN, 1.0), &[f64::INFINITY], &options, &Output::default());
    assert_eq!(places, ["t_span[0]", "y0[0]", "rtol", "atol", "max_step", "min_step"]);
    let fine = Options::default();
    assert_eq!(refused((0.0, 1.0), &[1.0], &fine, &Output::at([0.5, 0.25])), ["t_eval[1]"]);
    assert_eq!(refused((0.0, 1.0), &[1.0], &fine, &Output::at([0.5, 2.0])), ["t_eval[1]"]);
    assert_eq!(refused((0.0, 1.0), &[1.0], &fine, &Output::at([f64::NAN])), ["t_eval[0]"]);
    for (first_step, ok) in [(1.0, true), (1.5, false), (0.0, false)] {
        let options = Options { first_step: Some(first_step), ..Options::default() };
        assert_eq!(Stepper::new(1, (0.0, 1.0), &[1.0], &options).is_ok(), ok);
    }
    let sparsity = Some(Sparsity::new(2, [(0, 0)]).unwrap());
    let options = Options { method: Method::Radau, sparsity, ..Options::default() };
    assert_eq!(refused((0.0, 1.0), &[1.0], &options, &Output::default()), ["jac_sparsity"]);
}
