//! Extreme, infinite or too many numbers and problems are rejected quickly, without panics.

use std::time::{Duration, Instant};

use lissom::body::Body;
use lissom::error::{Interrupted, InvalidInput};
use lissom::model::{Facts, Model};
use lissom::newmark;
use lissom::ode::{self, Method, Options, Output, Status};
use lissom::robot::{RobotModel, Rod};
use lissom::rod::{Basis, GivenSection, MAX_OWN_NODES, Profile, Section, Segment, Shape, diagonal};
use lissom::roots::{Differences, Newton};
use lissom::scene::Scene;
use lissom::second_order;
use lissom::support::Support;

/// Time limit for errors, in a build with debug assertions on a busy machine.
const AT_ONCE: Duration = Duration::from_secs(5);

#[track_caller]
fn quickly<T>(action: impl FnOnce() -> T) -> T {
    let clock = Instant::now();
    let result = action();
    assert!(clock.elapsed() < AT_ONCE, "took {:?}", clock.elapsed());
    result
}

fn segment() -> Segment {
    Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 1e9, 4e8, 1000.0) }
}

fn curved(length: f64, curvature: f64) -> Segment {
    Segment { length, reference_strain: [0.0, curvature, 0.0, 1.0, 0.0, 0.0].into(), ..segment() }
}

fn compile(segment: Segment) -> Result<RobotModel, InvalidInput> {
    quickly(|| RobotModel::of_rod(&Rod::new(vec![segment])))
}

#[track_caller]
fn refused(segment: Segment, place: &str) -> String {
    let message = compile(segment).unwrap_err().to_string();
    assert!(message.starts_with(&format!("segments[0].{place}")), "{message}");
    message
}

#[test]
fn reference_curvature_has_a_bound() {
    for (length, curvature) in
        [(1.0, 3e3), (43e3, 0.1), (1.0, 1e15), (1.0, 1e300), (1.0, f64::MAX), (1e90, 1e90)]
    {
        let message = refused(curved(length, curvature), "reference_strain");
        assert!(message.contains("turns") && message.contains("1024 quadrature nodes"), "{message}");
    }
    let message = refused(curved(1.0, 3e3), "reference_strain");
    assert!(message.contains("477 turns") && message.contains("at least 2, or give `nodes`"), "{message}");
    // A rod too curved for one segment is accepted as two.
    let half = curved(0.5, 3e3);
    let model = quickly(|| RobotModel::of_rod(&Rod::new(vec![half.clone(), half]))).unwrap();
    assert!(model.nodes().iter().all(|nodes| (700..=MAX_OWN_NODES).contains(nodes)));
    assert_eq!(compile(curved(1.0, 1e3)).unwrap().nodes(), [512]);
    assert_eq!(compile(Segment { nodes: Some(16), ..curved(1.0, 1e300) }).unwrap().nodes(), [16]);
}

#[test]
fn long_tables_have_a_bound() {
    let stations: Vec<f64> = (0..4096).map(|i| f64::from(i) / 4095.0).collect();
    let strains: Vec<[f64; 6]> = stations.iter().map(|x| [0.0, x.sin(), 0.0, 1.0, 0.0, 0.0]).collect();
    let table = Segment { reference_strain: Profile::table(&stations, &strains).unwrap(), ..segment() };
    assert!(refused(table.clone(), "nodes").contains("long tables"));
    assert_eq!(compile(Segment { nodes: Some(64), ..table }).unwrap().nodes(), [64]);
    // All segments together have a limit, too.
    let rod = Rod::new(vec![curved(1.0, 1.9e3); 100]);
    let message = quickly(|| rod.validate()).unwrap_err().to_string();
    assert!(message.starts_with("segments: got 1.") && message.contains("GB"), "{message}");
}

#[test]
fn sections_at_the_edges_of_doubles() {
    for size in [1e-300, 1e-100, 1e-90, 1e77, 1e100, 1e155, 1e200, 1e300, f64::MAX, f64::MIN_POSITIVE, 5e-324]
    {
        for other in [size, 1.0, 1.0 / size] {
            let shapes = [
                Shape::Circle { radius: size },
                Shape::HollowCircle { outer: size, inner: 0.5 * size },
                Shape::Rectangle { width: size, height: other },
                Shape::Ellipse { semi_axis_y: size, semi_axis_z: other },
            ];
            for shape in shapes {
                let section = Section::Shape(shape.map(|&size| Profile::from(size)));
                let modes = [1, 3, 2, 1, 1, 1];
                // Extreme stiffness or softness, or no weight, causes neither a panic nor a hang.
                let error = compile(Segment { section, modes, ..segment() }).unwrap_err().to_string();
                assert!(error.len() < 2000, "{error}");
            }
        }
    }
}

#[test]
fn stiffness_mass_and_length_at_the_edges_of_doubles() {
    let plain = segment();
    refused(Segment { young_modulus: f64::MAX, shear_modulus: f64::MAX / 2.5, ..plain.clone() }, "section");
    refused(Segment { young_modulus: 1e-300, shear_modulus: 4e-301, ..plain.clone() }, "section");
    refused(Segment { density: f64::MAX, ..plain.clone() }, "section");
    refused(Segment { density: 1e-300, ..plain.clone() }, "section");
    refused(Segment { length: 1e300, ..plain.clone() }, "length");
    refused(Segment { length: 5e-324, ..plain.clone() }, "length");
    let taper = Section::circle([1e-3, 1e60]);
    refused(Segment { section: taper, ..plain.clone() }, "section");
    let given = |stiffness: [f64; 6]| {
        let section = GivenSection {
            stiffness: diagonal(stiffness).into(),
            mass: 1.0.into(),
            inertia: [0.0; 9].into(),
            centre: [0.0; 2].into(),
        };
        Segment { modes: [2, 3, 0, 0, 0, 0], ..Segment::given(1.0, section) }
    };
    assert!(compile(given([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])).is_ok());
    assert!(compile(given([1e99, 1e-99, 1.0, 0.0, 0.0, 0.0])).is_ok(), "definite, if of different sizes");
    for stiffness in [1e300, 1e-300, f64::MAX, 5e-324] {
        refused(given([stiffness; 6]), "section");
        refused(given([stiffness, 1.0, 1.0, 1.0, 1.0, 1.0]), "section");
    }
    // Asymmetry of a matrix with huge entries is detected.
    let mut rows = diagonal([1e200; 6]);
    (rows[0][1], rows[1][0]) = (1e199, -1e199);
    let Section::Given(mut section) = given([1.0; 6]).section else { unreachable!() };
    section.stiffness = rows.into();
    assert!(
        refused(Segment { section: Section::Given(section), ..given([1.0; 6]) }, "section")
            .contains("symmetric")
    );
}

#[test]
fn what_stands_on_a_rod_at_the_edges_of_doubles() {
    for value in [f64::MAX, -f64::MAX, 1e200, 1e-300, 5e-324] {
        let size = value.abs();
        let mut rod = Rod::new(vec![segment()]);
        rod.base_position = [value; 3];
        rod.gravity = [value; 3];
        rod.tip_force = [value; 3];
        rod.tip_mass = size;
        rod.bodies = vec![Body { centre: [value; 3], inertia: diagonal([size; 3]), ..Body::point(size) }];
        rod.supports =
            vec![Support { stiffness: [size; 3], rotational_stiffness: [size; 3], ..Support::at_tip() }];
        let model = quickly(|| RobotModel::of_rod(&rod));
        let Ok(mut model) = model else { continue };
        quickly(|| lissom::modes::modes(&mut model, &[0.0; 3])).ok();
        let options = lissom::statics::Options::default();
        let found =
            quickly(|| lissom::statics::equilibrium(&mut model, &options, &mut || Ok(()))).unwrap().unwrap();
        assert!(!found.status.is_success() || found.q.iter().all(|q| q.is_finite()));
    }
    for basis in Basis::ALL {
        let stiff = Segment {
            basis,
            modes: [2, 2, 2, 2, 2, 2],
            young_modulus: 1e100,
            shear_modulus: 4e99,
            ..segment()
        };
        assert!(compile(stiff).is_ok());
    }
}

/// A constant derivative of the state.
struct Constant(Vec<f64>);

impl ode::FirstOrderSystem for Constant {
    fn n(&self) -> usize {
        self.0.len()
    }
    fn rhs(&mut self, _: f64, _: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
        dydt.copy_from_slice(&self.0);
        Ok(())
    }
}

#[test]
fn states_that_overflow_end_an_integration() {
    for method in [Method::Rk45, Method::Dop853, Method::Radau] {
        for rate in [1e308, -1e308, 1e307, f64::MAX] {
            let options = Options { method, ..Options::default() };
            let system = &mut Constant(vec![rate, 0.0]);
            let solve = || {
                ode::solve(
                    system,
                    (0.0, 100.0),
                    &[0.0, 1.0],
                    &options,
                    &Output::default(),
                    &mut [],
                    &mut |_| Ok(()),
                )
            };
            let solution = quickly(solve).unwrap();
            assert!(!solution.status.is_success(), "{method:?}, {rate}: {:?}", solution.status);
            assert!(solution.y.iter().all(|y| y.is_finite()), "{method:?}, {rate}");
            if method != Method::Radau && rate.abs() < 1e308 {
                assert_eq!(solution.status, Status::NonFinite);
                let end = solution.t[solution.t.len() - 1];
                assert!((end - f64::MAX / rate.abs()).abs() < 1e-9, "{method:?} ends at {end}");
            }
        }
    }
}

#[test]
fn what_does_not_fit_in_memory_is_refused() {
    let n = 300_000;
    let refused = |result: Result<(), InvalidInput>, place: &str| {
        let message = result.unwrap_err().to_string();
        assert!(message.starts_with(place) && message.contains(" GB: "), "{message}");
    };
    refused(Newton::check_memory(n, n), "x0: got 300000 values");
    refused(Differences::check_memory(n, n), "x: got 300000 values");
    let y0 = vec![0.0; n];
    let system = &mut Constant(y0.clone());
    let radau = Options { method: Method::Radau, ..Options::default() };
    let solved = ode::solve(system, (0.0, 1.0), &y0, &radau, &Output::default(), &mut [], &mut |_| Ok(()));
    refused(solved.map(|_| ()), "y0: got 300000 values");
    let times: Vec<f64> = (0..1_000_000).map(|i| f64::from(i) * 1e-6).collect();
    let output = Output::at(times);
    let solved = ode::solve(system, (0.0, 1.0), &y0, &Options::default(), &output, &mut [], &mut |_| Ok(()));
    refused(solved.map(|_| ()), "t_eval: got 1000000 times");
    let options = newmark::Options::new(0.1);
    let solved = newmark::solve(
        &mut Free(Facts::of_equations(n)),
        (0.0, 1.0),
        &y0,
        &y0,
        &options,
        None,
        &mut |_, _| Ok(()),
    );
    refused(solved.map(|_| ()), "q0: got 300000 values");
    let options = lissom::radau::Options::default();
    let solved = lissom::radau::solve(
        &mut Free(Facts::of_equations(n)),
        (0.0, 1.0),
        &y0,
        &y0,
        &options,
        None,
        &mut |_, _| Ok(()),
    );
    refused(solved.map(|_| ()), "q0: got 300000 values");
}

/// Masses without forces.
struct Free(Facts);

impl second_order::SecondOrderSystem for Free {
    type Model = dyn Model;
    fn facts(&self) -> &Facts {
        &self.0
    }
    fn residual(
        &mut self,
        _: f64,
        _: &[f64],
        _: &[f64],
        a: &[f64],
        residual: &mut [f64],
    ) -> Result<(), Interrupted> {
        residual.copy_from_slice(a);
        Ok(())
    }
    fn tangent(
        &mut self,
        _: f64,
        _: &[f64],
        _: &[f64],
        _: &[f64],
        weights: [f64; 3],
        tangent: &mut lissom::linalg::Matrix,
    ) -> Result<(), Interrupted> {
        tangent.fill_with_identity();
        *tangent *= weights[2];
        Ok(())
    }
    fn model(&mut self) -> Option<&mut Self::Model> {
        None
    }
}

#[test]
fn many_problems_are_refused_in_time_and_in_few_words() {
    let keys = |number: usize| -> String { (0..number).map(|i| format!("k{i} = 1\n")).collect() };
    let bad = "[[rod.segment]]\nlength = -1\nradius = -1\nyoung_modulus = -1\nshear_modulus = 1\ndensity = -1\nk = 1\n";
    let head = "version = 1\n[simulation]\nt_end = 1\n";
    let scenes = [
        (format!("version = 1\n{}", keys(20_000)), 20_000),
        (format!("{head}[[rod]]\n{}", bad.repeat(4000)), 4 * 4000),
        (format!("{head}[[rod]]\n[[rod.segment]]\n{}", keys(20_000)), 20_000),
        (format!("{head}q = [{}]\n", "1, ".repeat(200_000)), 1),
        (format!("{head}[[rod]]\nq0 = [{}]\n", "true, ".repeat(50_000)), 50_000),
        (format!("version = 1\n{} = 1\n", "k".repeat(1_000_000)), 1),
        (format!("version = 1\n\"{}\" = 1\n", ".[".repeat(200_000)), 1),
        (format!("{head}method = \"{}\"\n", "x".repeat(1_000_000)), 1),
        (format!("version = 1\nx = {}1{}\n", "[".repeat(20_000), "]".repeat(20_000)), 1),
        (format!("version = 1\n{}x = 1\n", "x.".repeat(20_000)), 1),
        (format!("{}x = 1\n", "{".repeat(100_000)), 1),
        ("= 1\n".repeat(20_000), 1),
        ("k = 1\n".repeat(20_000), 1),
    ];
    for (text, least) in scenes {
        let shown = &text[..text.len().min(60)];
        let (error, message) = quickly(|| {
            let error = Scene::parse(&text, "s.toml").unwrap_err();
            let message = error.to_string();
            (error, message)
        });
        assert!(error.problems.len() <= 100, "{shown}");
        assert!(
            error.problems.len() + error.omitted >= least,
            "{shown}: {} + {}",
            error.problems.len(),
            error.omitted
        );
        assert!(message.len() < 500_000, "{shown}: a message of {} bytes", message.len());
        if error.omitted > 0 {
            assert!(message.ends_with(&format!("and {} more problems", error.omitted)), "{shown}");
        }
    }
}

#[test]
fn problems_in_long_lines_are_shown_where_they_are() {
    let text = format!("version = 1\nx = [{}]\n", "1, ".repeat(100_000));
    let error = Scene::parse(&text, "s.toml").unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("s.toml:2:1: x: unknown key") && message.contains("\n2 | x = [1, 1, "),
        "{message}"
    );
    let text = format!(
        "version = 1\nq0 = [{}] # é\n[simulation]\nt_end = 1\n[[rod]]\nq0 = [{}x]\n",
        "1, ".repeat(3),
        "é".repeat(1000)
    );
    assert!(Scene::parse(&text, "s.toml").is_err_and(|error| error.to_string().contains("s.toml:6:")));
}
