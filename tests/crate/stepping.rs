//! Runs advanced step by step, and controlled runs.

use lissom::error::{Interrupted, InvalidInput};
use lissom::linalg::Matrix;
use lissom::model::{
    Differentiable, Dynamics, Elastic, Energy, Facts, InTime, InertiaMatrix, InvalidShape, Smooth,
};
use lissom::newmark::{self, Parameters, Scheme, StepSize};
use lissom::simulate::{Control, Simulation, simulate, simulate_controlled};
use lissom::stepping::{Method, Run};
use lissom::{ode, radau};

/// `a + c v + k q + cubic q^3 = u + sin(t)`, with the energy of the springs; the input is held.
#[derive(Clone, Debug)]
struct Oscillator {
    damping: f64,
    stiffness: f64,
    cubic: f64,
    forcing: f64,
    time: f64,
    input: f64,
    facts: Facts,
}

impl Oscillator {
    fn linear() -> Self {
        let facts = Facts { is_driven: true, default_inputs: vec![0.0], ..Facts::smooth(1, 1.0) };
        Self { damping: 0.2, stiffness: 9.0, cubic: 0.0, forcing: 0.0, time: 0.0, input: 0.0, facts }
    }

    fn duffing() -> Self {
        let linear = Self::linear();
        let facts = Facts { varies_in_time: true, ..linear.facts.clone() };
        Self { cubic: 30.0, forcing: 1.0, facts, ..linear }
    }

    fn force(&self) -> f64 {
        self.input + self.forcing * self.time.sin()
    }
}

impl Elastic for Oscillator {
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]) {
        tau[0] = self.stiffness * q[0] + self.cubic * q[0].powi(3);
    }
    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix) {
        tangent[(0, 0)] = self.stiffness + 3.0 * self.cubic * q[0].powi(2);
    }
    fn turned_loads(&mut self, _: &[f64], forces: &mut Matrix, _borne: &mut [f64]) {
        forces.fill(0.0);
    }
    fn sizes(&mut self, _: &[f64], sizes: &mut [f64]) {
        sizes[0] = 1.0;
    }
}

impl InTime for Oscillator {
    fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        self.time = t;
        Ok(())
    }
    fn set_inputs(&mut self, inputs: &[f64]) {
        self.input = inputs[0];
    }
    fn input_tangent(&mut self, _: &[f64], _: &[f64], _: &[f64], tangent: &mut Matrix) {
        tangent.fill(-1.0);
    }
    fn not_finite(&self) -> Option<String> {
        None
    }
}

impl Differentiable for Oscillator {
    fn add_power_by_inertia(&mut self, _: &[f64], _: &[f64], _: &[f64], _: &[f64], _: &mut [InertiaMatrix]) {}
    fn add_power_by_length(&mut self, _: &[f64], _: &[f64], _: &[f64], _: &[f64], _: &mut [f64]) {}
}

impl Smooth for Oscillator {}

impl Dynamics for Oscillator {
    fn facts(&self) -> &Facts {
        &self.facts
    }
    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        self.elastic_forces(q, tau);
        tau[0] += qdd[0] + self.damping * qd[0] - self.force();
    }
    fn weighted_tangent(&mut self, q: &[f64], _: &[f64], _: &[f64], weights: [f64; 3], tangent: &mut Matrix) {
        self.elastic_tangent(q, tangent);
        tangent[(0, 0)] = weights[0] * tangent[(0, 0)] + weights[1] * self.damping + weights[2];
    }
    fn mass_matrix(&mut self, _: &[f64], mass: &mut Matrix) {
        mass[(0, 0)] = 1.0;
    }
    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        let elastic = 0.5 * self.stiffness * q[0].powi(2) + 0.25 * self.cubic * q[0].powi(4);
        Energy { kinetic: 0.5 * qd[0].powi(2), elastic, ..Energy::default() }
    }
    fn dissipated_power(&mut self, _: &[f64], qd: &[f64]) -> f64 {
        self.damping * qd[0].powi(2)
    }
    fn supplied_power(&mut self, _: &[f64], qd: &[f64], _: &[f64]) -> f64 {
        self.force() * qd[0]
    }
    fn invalid_shape(&mut self, _: &[f64]) -> Option<InvalidShape> {
        None
    }
    fn tip(&mut self, q: &[f64]) -> [f64; 3] {
        [q[0], 0.0, 0.0]
    }
}

const START: [[f64; 1]; 2] = [[0.3], [-0.1]];

fn newmark(name: &str, dt: f64) -> newmark::Options {
    let scheme = Scheme::by_name(name, &Parameters::default()).unwrap();
    newmark::Options { scheme, ..newmark::Options::new(dt) }
}

fn methods(dt: f64) -> Vec<(&'static str, Method)> {
    let adaptive = StepSize::Adaptive { max_step: f64::INFINITY, min_step: 0.0 };
    vec![
        ("newmark", Method::Newmark(newmark("newmark", dt))),
        ("hht", Method::Newmark(newmark("hht", dt))),
        ("generalised_alpha", Method::Newmark(newmark("generalised_alpha", dt))),
        ("adaptive", Method::Newmark(newmark::Options { step_size: adaptive, ..newmark("hht", dt) })),
        ("radau", Method::Radau { options: radau::Options::default(), dt, returns_steps: false }),
        ("rk45", Method::FirstOrder { options: ode::Options::default(), dt, returns_steps: false }),
        (
            "dop853",
            Method::FirstOrder {
                options: ode::Options { method: ode::Method::Dop853, ..ode::Options::default() },
                dt,
                returns_steps: false,
            },
        ),
    ]
}

/// A controller: a discontinuous function of the state.
fn law(t: f64, q: f64, v: f64) -> f64 {
    -3.0 * q - 0.5 * v + (7.0 * t).cos().round()
}

fn controlled(
    model: Oscillator,
    t_span: (f64, f64),
    method: &Method,
    step: f64,
    t_eval: Option<&[f64]>,
    law: impl Fn(f64, f64, f64) -> f64,
) -> Simulation {
    let mut inputs = |t: f64, q: &[f64], v: &[f64], u: &mut [f64]| {
        u[0] = law(t, q[0], v[0]);
        Ok(())
    };
    let control = Control { step, inputs: &mut inputs };
    let [q0, v0] = &START;
    let found = simulate_controlled(model, t_span, q0, v0, method, t_eval, control, &mut |_| Ok(())).unwrap();
    assert!(found.status.is_success(), "{}", found.message);
    found
}

fn run_of(model: Oscillator, t0: f64, method: &Method, dt: f64) -> Run<Oscillator> {
    let mut run = Run::new(model, (t0, t0 + dt), &START[0], &START[1], method).unwrap();
    assert_eq!(run.begin(), Ok(None));
    run
}

/// One interval; returns the state at its end.
fn interval(run: &mut Run<Oscillator>, input: Option<f64>, duration: Option<f64>) -> [f64; 4] {
    let end = run.end_of(duration).unwrap();
    if let Some(input) = input {
        run.set_inputs(&[input]);
    }
    run.begin_interval(end);
    let status = run.finish(&mut |_| Ok(())).unwrap();
    assert!(status.is_success(), "{}", run.explain(status));
    state(run)
}

fn state(run: &Run<Oscillator>) -> [f64; 4] {
    [run.t(), run.q()[0], run.v()[0], run.a()[0]]
}

#[test]
fn steps_of_a_run_are_those_of_simulate_to_the_bit() {
    let (t0, dt, steps) = (0.35, 0.01, 1000);
    for name in ["newmark", "hht", "generalised_alpha"] {
        let method = Method::Newmark(newmark(name, dt));
        let t_span = (t0, t0 + steps as f64 * dt);
        let model = Oscillator::duffing();
        let whole =
            simulate(model.clone(), t_span, &START[0], &START[1], &method, None, &mut |_| Ok(())).unwrap();
        let mut run = run_of(model, t0, &method, dt);
        assert_eq!(whole.t.len(), steps + 1);
        for i in 1..=steps {
            let a = whole.a.as_ref().unwrap();
            assert_eq!(
                interval(&mut run, None, None),
                [whole.t[i], whole.q[i], whole.v[i], a[i]],
                "{name}, step {i}"
            );
        }
    }
}

#[test]
fn a_controlled_run_is_its_legs_to_the_bit() {
    let (t0, dt, intervals) = (0.2, 0.02, 60);
    for step in [0.02, 0.1, 0.05] {
        for (name, method) in methods(dt) {
            // The ends of all intervals are output times; there are further ones.
            let mut run = run_of(Oscillator::duffing(), t0, &method, dt);
            let mut ends = vec![state(&run)];
            let mut inputs = Vec::new();
            for _ in 0..intervals {
                let [t, q, v, _] = *ends.last().unwrap();
                inputs.push(law(t, q, v));
                ends.push(interval(&mut run, inputs.last().copied(), Some(step)));
            }
            let times: Vec<f64> = ends.iter().map(|end| end[0]).collect();
            let t_span = (t0, times[intervals]);
            let whole = controlled(Oscillator::duffing(), t_span, &method, step, Some(&times), law);
            for i in 0..=intervals {
                assert_eq!(
                    [whole.q[i], whole.v[i]],
                    [ends[i][1], ends[i][2]],
                    "{name}, {step}, interval {i}"
                );
                assert_eq!(whole.u[i], inputs[i.min(intervals - 1)], "{name}, {step}, interval {i}");
            }
        }
    }
}

#[test]
fn whoever_recalls_a_run_or_is_its_copy_goes_on_as_it_does() {
    for (name, method) in methods(0.02) {
        let mut run = run_of(Oscillator::duffing(), 0.1, &method, 0.02);
        for i in 0..40 {
            // Some steps of size `dt`, some intervals of other lengths; inputs that stay constant and inputs that
            // jump.
            let duration = [None, Some(0.05), Some(0.04)][i % 3];
            let input = (i % 4 == 0).then(|| (i as f64).sin());
            let memory = run.memory();
            let mut copy = run.clone();
            let mut other = run_of(Oscillator::duffing(), 0.1, &method, 0.02);
            other.recall(&memory).unwrap();
            assert_eq!(other.memory(), memory, "{name}");
            let wanted = interval(&mut run, input, duration);
            assert_eq!(interval(&mut copy, input, duration), wanted, "{name}, copy, interval {i}");
            assert_eq!(interval(&mut other, input, duration), wanted, "{name}, recalled, interval {i}");
            assert_eq!([copy.counters(), other.counters()], [run.counters(); 2], "{name}, interval {i}");
        }
    }
}

#[test]
fn a_memory_of_something_else_is_refused() {
    let all = methods(0.02);
    let mut memories: Vec<Vec<f64>> = all
        .iter()
        .map(|(_, method)| {
            let mut run = run_of(Oscillator::duffing(), 0.0, method, 0.02);
            interval(&mut run, None, None);
            run.memory()
        })
        .collect();
    let mut damaged = memories[0].clone();
    damaged[1] = 0.5;
    memories.extend([vec![], vec![f64::NAN; memories[0].len()], damaged]);
    let mut run = run_of(Oscillator::duffing(), 0.0, &all[0].1, 0.02);
    let refused = |error: InvalidInput| error.problems[0].place == "memory";
    for (i, memory) in memories.iter().enumerate() {
        // Memories of all members of the Newmark family have the same form.
        let is_right = i < 4;
        assert_eq!(run.recall(memory).is_ok(), is_right, "{i}");
        assert!(is_right || run.recall(memory).is_err_and(refused), "{i}");
    }
}

/// The exact motion of the linear oscillator under a constant force, from (q, v), after time t.
fn exact(model: &Oscillator, [q, v]: [f64; 2], force: f64, t: f64) -> [f64; 2] {
    let held = force / model.stiffness;
    let half = 0.5 * model.damping;
    let omega = (model.stiffness - half * half).sqrt();
    let (x, (sine, cosine)) = (q - held, (omega * t).sin_cos());
    let (decay, slope) = ((-half * t).exp(), (v + half * x) / omega);
    let moved = x * cosine + slope * sine;
    [held + decay * moved, decay * (omega * (slope * cosine - x * sine) - half * moved)]
}

/// Jumps of the inputs do not reduce the order of a method.
#[test]
fn order_two_with_inputs_that_jump() {
    let force = |t: f64| (3.0 * t).cos().signum() + t;
    let (step, intervals) = (0.1, 30);
    let model = Oscillator::linear();
    let mut wanted = [START[0][0], START[1][0]];
    for i in 0..intervals {
        wanted = exact(&model, wanted, force(f64::from(i) * step), step);
    }
    for name in ["newmark", "hht", "generalised_alpha"] {
        let error = |dt: f64| {
            let method = Method::Newmark(newmark::Options {
                rtol: 1e-12.into(),
                atol: Some(1e-13.into()),
                ..newmark(name, dt)
            });
            let t_end = f64::from(intervals) * step;
            let found =
                controlled(model.clone(), (0.0, t_end), &method, step, Some(&[t_end]), |t, _, _| force(t));
            (found.q[0] - wanted[0]).abs().max((found.v[0] - wanted[1]).abs())
        };
        let [coarse, fine] = [error(step / 4.0), error(step / 8.0)];
        assert!((coarse / fine).log2() > 1.85, "{name}: {coarse} {fine}");
        assert!(fine < 4e-3, "{name}: {fine}");
    }
    for (name, method) in methods(0.02).split_off(4) {
        let t_end = f64::from(intervals) * step;
        let found =
            controlled(model.clone(), (0.0, t_end), &method, step, Some(&[t_end]), |t, _, _| force(t));
        assert!((found.q[0] - wanted[0]).abs() < 2e-3, "{name}: {} {}", found.q[0], wanted[0]);
    }
}

#[test]
fn the_work_of_inputs_that_jump_closes_the_balance() {
    for step in [0.02, 0.1, 0.05] {
        let method = Method::Newmark(newmark("newmark", 0.02));
        let mut model = Oscillator::linear();
        let found = controlled(model.clone(), (0.0, 3.0), &method, step, None, law);
        let drift = found.balance(&mut model).unwrap().drift();
        assert!(drift < 1e-12, "{step}: {drift}");
    }
    for (name, method) in methods(0.02).split_off(4) {
        let mut model = Oscillator::duffing();
        let found = controlled(model.clone(), (0.0, 3.0), &method, 0.1, None, law);
        let drift = found.balance(&mut model).unwrap().drift();
        assert!(drift < 1e-2, "{name}: {drift}");
    }
}

#[test]
fn accelerations_and_inputs_are_those_that_act_from_a_time_on() {
    for (name, method) in methods(0.02) {
        let mut model = Oscillator::duffing();
        let found = controlled(model.clone(), (0.1, 1.1), &method, 0.1, None, law);
        let a = found.accelerations(&mut model).unwrap();
        for (i, &t) in found.t.iter().enumerate() {
            model.set_inputs(&[found.u[i]]);
            model.set_time(t).unwrap();
            let mut tau = [0.0];
            model.inverse_dynamics(&[found.q[i]], &[found.v[i]], &[a[i]], &mut tau);
            let tolerance = if name == "adaptive" || name == "radau" { 0.2 } else { 1e-6 };
            // Results of adaptive methods are interpolated between steps.
            assert!(tau[0].abs() < tolerance, "{name} at {t}: {}", tau[0]);
        }
    }
}

#[test]
fn durations_are_divided_into_equal_steps() {
    let method = Method::Newmark(newmark("newmark", 0.1));
    let mut run = run_of(Oscillator::linear(), 1.0, &method, 0.1);
    let mut times = |duration| {
        let end = run.end_of(duration).unwrap();
        run.begin_interval(end);
        let mut times = Vec::new();
        while run.step(&mut |_| Ok(())).unwrap().is_none() {
            times.push(run.t());
        }
        times.push(run.t());
        times
    };
    assert_eq!(times(None), [1.0 + 0.1]);
    assert_eq!(times(Some(0.3)), [1.0 + 2.0 * 0.1, 1.0 + 3.0 * 0.1, 1.0 + 4.0 * 0.1]);
    let parts = times(Some(0.25));
    let start = 1.0 + 4.0 * 0.1;
    assert_eq!((parts.len(), parts[2]), (3, start + 0.25));
    assert!((parts[0] - start - 0.25 / 3.0).abs() < 1e-15);
    assert_eq!(times(Some(0.01)), [start + 0.25 + 0.01]);
    for wrong in [0.0, -0.1, f64::NAN, f64::INFINITY, 1e-20] {
        assert_eq!(run.end_of(Some(wrong)).unwrap_err().problems[0].place, "duration");
    }
}

#[test]
fn a_step_that_fails_leaves_the_state_and_the_next_one_may_go_on() {
    for (name, method) in methods(0.02) {
        let mut run = run_of(Oscillator::duffing(), 0.0, &method, 0.02);
        let before = interval(&mut run, Some(0.1), None);
        let end = run.end_of(None).unwrap();
        run.set_inputs(&[f64::NAN]);
        run.begin_interval(end);
        let status = run.finish(&mut |_| Ok(())).unwrap();
        assert!(!status.is_success() && run.explain(status).len() > 20, "{name}");
        assert_eq!(state(&run)[..3], before[..3], "{name}");
        let after = interval(&mut run, Some(0.1), None);
        assert!(after[0] > before[0] && after[1].is_finite(), "{name}");
    }
}

#[test]
fn an_interrupted_leg_goes_on() {
    for (name, method) in methods(0.02) {
        let mut run = run_of(Oscillator::duffing(), 0.0, &method, 0.02);
        let mut other = run.clone();
        let wanted = interval(&mut other, Some(0.1), Some(0.2));
        let end = run.end_of(Some(0.2)).unwrap();
        run.set_inputs(&[0.1]);
        run.begin_interval(end);
        let mut left = 1;
        let interrupted = run.finish(&mut |_| {
            left -= 1;
            if left < 0 { Err(Interrupted) } else { Ok(()) }
        });
        assert!(interrupted.is_err() || run.t() == end, "{name}");
        if interrupted.is_err() {
            assert!(run.finish(&mut |_| Ok(())).unwrap().is_success(), "{name}");
        }
        assert_eq!(state(&run), wanted, "{name}");
    }
}
