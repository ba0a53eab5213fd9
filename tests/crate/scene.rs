//! Scene files: contents that are read, and every kind of problem with its exact line and column.

use lissom::body::Body;
use lissom::joint::{Joint, JointForces};
use lissom::robot::{Driven, described::Link};
use lissom::scene::{
    FileProblem, Imported, Imports, Jacobian, Method, Model, Quantity, Refusal, Request, Scene,
};
use lissom::{load, robot, rod};
use proptest::prelude::*;

const GOOD: &str = r#"version = 1

[[rod]]
[[rod.segment]]
length = 1.0
radius = 1e-3
young_modulus = 210e9
shear_modulus = 80e9
density = 7800
modes = { bend_y = 3 }

[simulation]
t_end = 3
"#;

/// The problems of a scene as `line:column: message`.
fn problems(text: &str) -> Vec<String> {
    let error = Scene::parse(text, "s.toml").expect_err("the scene is bad");
    let lines = error.problems.iter().map(|problem| error.header(problem));
    lines.map(|line| line.strip_prefix("s.toml:").expect("the file is named").to_owned()).collect()
}

/// The valid scene after a change.
fn changed(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "the good scene has no {from}");
    GOOD.replacen(from, to, 1)
}

/// Asserts that a change of the valid scene causes exactly these problems.
#[track_caller]
fn refused(from: &str, to: &str, expected: &[&str]) {
    assert_eq!(problems(&changed(from, to)), expected, "{to}");
}

fn rod_of(text: &str) -> robot::Rod {
    match Scene::parse(text, "s.toml").expect("the scene is good").model {
        Model::Rod(rod) => rod,
        Model::Robot(_) => panic!("a robot"),
        Model::Pendulum(_) => panic!("the scene has a rod"),
    }
}

#[test]
fn left_out_keys_have_the_defaults_of_the_rod() {
    let scene = Scene::parse(GOOD, "folder/wire.toml").expect("the scene is good");
    assert_eq!(scene.name, "wire", "the file's stem");
    assert_eq!(scene.text, GOOD);
    let segment =
        rod::Segment { modes: [0, 3, 0, 0, 0, 0], ..rod::Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
    assert_eq!(scene.model, Model::Rod(robot::Rod::new(vec![segment])));
    assert_eq!((scene.q0, scene.v0), (vec![0.0; 3], vec![0.0; 3]));
    let simulation = scene.simulation;
    assert_eq!(simulation.t_end, 3.0);
    assert_eq!((simulation.method, simulation.jac), (Method::Newmark, Jacobian::Analytic));
    assert_eq!((simulation.dt, simulation.rtol, simulation.atol), (1e-2, 1e-6, None));
    assert_eq!(simulation.output_dt, None);
    assert_eq!(simulation.quantities.len(), 4, "everything is kept");
}

#[test]
fn every_key_is_read() {
    let text = r#"version = 1
[scene]
name = "everything"
gravity = [1, 2, 3]

[[rod]]
base = { position = [1, 2, 3], orientation = [0, 1, 0, 0] }
tip_force = [4, 5, 6]
tip_moment = [7, 8, 9]
tip_mass = 0.5
q0 = [1, 2, 3, 4, 5, 6, 7]
v0 = [7, 6, 5, 4, 3, 2, 1]

[[rod.segment]]
length = 2
radius = [2e-3, 1e-3]
young_modulus = 3e5
poisson_ratio = 0.5
density = 1000
modes = { torsion = 1, bend_y = 1, bend_z = 1, stretch = 1, shear_y = 1, shear_z = 1 }
retardation_time = 1e-3
reference_strain = [1, 2, 3, 1, 5, 6]
shear_correction = 0.9

[[rod.segment]]
length = 1
radius = 1e-3
young_modulus = 3e5
shear_modulus = 1e5
density = 1000
modes.bend_z = 1

[simulation]
t_end = 2.5
method = "rk45"
dt = 1e-3
jac = "central"
rtol = 1e-8
atol = 1e-10
output = { dt = 0.1, quantities = ["shape", "energy"] }
"#;
    let scene = Scene::parse(text, "s.toml").expect("the scene is good");
    assert_eq!(scene.name, "everything");
    assert_eq!(scene.q0, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(scene.v0, [7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]);
    let first = rod::Segment {
        section: rod::Section::circle([2e-3, 1e-3]),
        given_poisson_ratio: Some(0.5),
        modes: [1; 6],
        retardation_time: 1e-3,
        reference_strain: [1.0, 2.0, 3.0, 1.0, 5.0, 6.0].into(),
        shear_correction: 0.9.into(),
        ..rod::Segment::straight(2.0, 1.0, 3e5, 1e5, 1000.0)
    };
    let second =
        rod::Segment { modes: [0, 0, 1, 0, 0, 0], ..rod::Segment::straight(1.0, 1e-3, 3e5, 1e5, 1000.0) };
    let expected = robot::Rod {
        base_position: [1.0, 2.0, 3.0],
        base_orientation: [0.0, 1.0, 0.0, 0.0],
        gravity: [1.0, 2.0, 3.0],
        tip_force: [4.0, 5.0, 6.0],
        tip_moment: [7.0, 8.0, 9.0],
        tip_mass: 0.5,
        ..robot::Rod::new(vec![first, second])
    };
    assert_eq!(scene.model, Model::Rod(expected));
    let simulation = scene.simulation;
    assert_eq!((simulation.method, simulation.jac), (Method::Rk45, Jacobian::Central));
    assert_eq!((simulation.t_end, simulation.dt), (2.5, 1e-3));
    assert_eq!((simulation.rtol, simulation.atol), (1e-8, Some(1e-10)));
    assert_eq!(simulation.output_dt, Some(0.1));
    assert_eq!(simulation.quantities, [Quantity::Energy, Quantity::Shape]);
}

const WIRE: &str = r#"
version = 1
[[rod]]
[[rod.segment]]
length = 2.0
radius = 1e-3
young_modulus = 3e5
shear_modulus = 1e5
density = 1000
modes.bend_y = 4
reference_strain = { stations = [0, 0.5, 2], values = [[0, 1, 0, 1, 0, 0], [0, 2, 0, 1, 0, 0], [0, 0, 0, 1, 0, 0]] }
basis = "hermite"
[simulation]
t_end = 1
"#;

#[test]
fn bases_and_tables_of_reference_strains_are_read() {
    let values = [1.0, 2.0, 0.0].map(|bend| [0.0, bend, 0.0, 1.0, 0.0, 0.0]);
    let segment = rod::Segment {
        modes: [0, 4, 0, 0, 0, 0],
        basis: rod::Basis::Hermite,
        reference_strain: rod::Profile::table(&[0.0, 0.5, 2.0], &values).unwrap(),
        ..rod::Segment::straight(2.0, 1e-3, 3e5, 1e5, 1000.0)
    };
    assert_eq!(rod_of(WIRE).segments, [segment]);
    for basis in rod::Basis::ALL {
        let text = WIRE.replace("hermite", basis.name());
        assert_eq!(rod_of(&text).segments[0].basis, basis);
    }
    for (from, to, expected) in [
        ("hermite", "hermit", "did you mean \"hermite\""),
        ("bend_y = 4", "bend_y = 5", "even number of Hermite modes"),
        ("0.5, 2]", "0.5, 1.5]", "the segment's length"),
        ("0.5, 2]", "2.5, 2]", "more than stations[1]"),
        (", [0, 0, 0, 1, 0, 0]]", "]", "one row for each of the 3 stations"),
        ("{ stations", "{ places", "stations"),
    ] {
        let found = problems(&WIRE.replace(from, to));
        assert!(found.iter().any(|problem| problem.contains(expected)), "{to}: {found:?}");
    }
}

#[test]
fn loads_and_bodies_are_read() {
    let scene = changed(
        "[[rod.segment]]",
        "[[rod.load]]\nforce = [0, 0, 1]\nat = 0.5\n[[rod.load]]\nmoment = [0, 2, 0]\nalong = [0.1, 1]\nframe = 'body'\n\
         [[rod.body]]\nmass = 0.1\n[[rod.body]]\nmass = 0.2\nat = 0.3\ncentre = [0, 0, 0.1]\n\
         inertia = [[3, 0, 0], [0, 2, 0], [0, 0, 2]]\n[[rod.segment]]",
    );
    let rod = rod_of(&scene);
    let force =
        load::Load { extent: load::Extent::At(0.5), force: [0.0, 0.0, 1.0].into(), ..load::Load::at_tip() };
    let moment = load::Load {
        extent: load::Extent::Along([0.1, 1.0]),
        frame: load::Frame::Body,
        moment: [0.0, 2.0, 0.0].into(),
        ..load::Load::at_tip()
    };
    assert_eq!(rod.loads, [force, moment]);
    let inertia = [[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]];
    let body = Body { link: 0, at: Some(0.3), mass: 0.2, centre: [0.0, 0.0, 0.1], inertia, hull: None };
    assert_eq!(rod.bodies, [Body::point(0.1), body]);
}

#[test]
fn impossible_loads_and_bodies_are_refused() {
    let with = |text: &str| problems(&changed("[[rod.segment]]", &format!("{text}\n[[rod.segment]]")));
    assert_eq!(
        with("[[rod.load]]\nforce = [0, 0, 1]\nat = 1.5"),
        ["6:6: rod[0].load[0].at: got 1.5; expected an arc length in [0, 1] (metres)"]
    );
    assert_eq!(
        with("[[rod.load]]\nforce = [0, 0, 1]\nat = 0.5\nalong = [0, 1]"),
        ["7:9: rod[0].load[0].along: both at and along are given; keep one of them"]
    );
    assert_eq!(
        with("[[rod.load]]\nframe = 'bdoy'\nforce = [0, 0, 1]"),
        ["5:9: rod[0].load[0].frame: got \"bdoy\"; did you mean \"body\"? Expected \"world\" or \"body\""]
    );
    assert_eq!(
        with("[[rod.load]]\nat = 0.5"),
        ["4:1: rod[0].load[0]: neither force nor moment; add one of them"]
    );
    assert_eq!(
        with("[[rod.body]]\nmass = 1\ninertia = [[1, 0, 0], [0, 1, 0]]"),
        ["6:11: rod[0].body[0].inertia: got an array of 2; expected an array of 3 numbers or of 3 rows"]
    );
    assert_eq!(
        with("[[rod.body]]\nmass = -1"),
        ["5:8: rod[0].body[0].mass: got -1; expected a finite number >= 0 (kilograms)"]
    );
}

#[test]
fn a_pendulum_is_read() {
    let text = "version = 1\n[pendulum]\nlength = 2\nq0 = [-0.5, 0.5]\n[simulation]\nt_end = 1\n";
    let scene = Scene::parse(text, "s.toml").expect("the scene is good");
    assert_eq!(scene.q0, [-0.5, 0.5]);
    assert_eq!(scene.v0, [0.0, 0.0]);
    let Model::Pendulum(pendulum) = scene.model else { panic!("the scene has a pendulum") };
    assert_eq!(
        (pendulum.length(), pendulum.mass(), pendulum.stiffness(), pendulum.gravity()),
        (2.0, 1.0, 10.0, 9.81)
    );
}

#[test]
fn unknown_keys_are_refused_with_advice() {
    refused("length", "lenght", &["5:1: rod[0].segment[0].lenght: unknown key; did you mean `length`?"]);
    refused(
        "bend_y",
        "bendy",
        &["10:11: rod[0].segment[0].modes.bendy: unknown key; did you mean `bend_y`?"],
    );
    refused("[simulation]", "[simulaton]", &["12:2: simulaton: unknown key; did you mean `simulation`?"]);
    let misspelt = "version = 1\n[pendullum]\nmass = 1\n[simulation]\nt_end = 1\n";
    assert_eq!(problems(misspelt), ["2:2: pendullum: unknown key; did you mean `pendulum`?"]);
    refused(
        "[[rod]]",
        "[[rod]]\ngravity = 3",
        &["4:1: rod[0].gravity: unknown key; it belongs in [pendulum] or [scene]"],
    );
    refused(
        "t_end",
        "tip_mass = 3\nt_end",
        &["13:1: simulation.tip_mass: unknown key; it belongs in [[rod]]"],
    );
    refused(
        "bend_y = 3",
        "bend_y = 3, xxx = 1",
        &[
            "10:23: rod[0].segment[0].modes.xxx: unknown key; keys here are torsion, bend_y, bend_z, stretch, shear_y, \
             shear_z",
        ],
    );
}

#[test]
fn missing_keys_are_named_where_they_belong() {
    refused(
        "length = 1.0\n",
        "",
        &["4:1: rod[0].segment[0].length: missing; add length: length (metres, > 0)"],
    );
    refused(
        "[simulation]\nt_end = 3\n",
        "",
        &["1:1: simulation: missing; add simulation: duration, method and output of the simulation"],
    );
    refused(
        "shear_modulus = 80e9\n",
        "",
        &["4:1: rod[0].segment[0]: neither shear_modulus nor poisson_ratio; add one of them"],
    );
}

#[test]
fn booleans_are_read_where_they_belong() {
    let fluid = |value: &str| {
        changed("[[rod.segment]]", &format!("fluid = {{ density = 1, buoyancy = {value} }}\n[[rod.segment]]"))
    };
    for value in [true, false] {
        let fluid = rod_of(&fluid(&value.to_string())).fluid.expect("the scene has one");
        assert_eq!(fluid.is_buoyant, value);
    }
    let wrong = ["4:35: rod[0].fluid.buoyancy: got 1; expected true or false"];
    assert_eq!(problems(&fluid("1")), wrong);
    refused(
        "length = 1.0",
        "length = true",
        &["5:10: rod[0].segment[0].length: got true; expected a number"],
    );
}

#[test]
fn wrong_types_are_refused() {
    refused(
        "7800",
        "\"heavy\"",
        &["9:11: rod[0].segment[0].density: got the text \"heavy\"; expected a number"],
    );
    refused(
        "radius = 1e-3",
        "radius = true",
        &["6:10: rod[0].segment[0].radius: got true; expected a number or an array of 2 numbers or a table"],
    );
    refused(
        "radius = 1e-3",
        "radius = [1, 2, 3]",
        &["6:10: rod[0].segment[0].radius: got an array of 3; expected an array of 2 numbers"],
    );
    refused(
        "radius = 1e-3",
        "radius = [1, '2']",
        &["6:14: rod[0].segment[0].radius[1]: got the text \"2\"; expected a number"],
    );
    refused(
        "bend_y = 3",
        "bend_y = 3.0",
        &["10:20: rod[0].segment[0].modes.bend_y: got 3.0; expected an integer >= 0"],
    );
    refused(
        "bend_y = 3",
        "bend_y = -3",
        &["10:20: rod[0].segment[0].modes.bend_y: got -3; expected an integer >= 0"],
    );
    refused("t_end = 3", "t_end = 1979-05-27", &["13:9: simulation.t_end: got a date; expected a number"]);
    refused(
        "[[rod]]\n",
        "[rod]\n",
        &["3:2: rod: got a table; expected [[rod]], in double brackets, above [[rod.segment]]"],
    );
    refused(
        "[[rod.segment]]",
        "[rod.segment]",
        &["4:6: rod[0].segment: got a table; expected double brackets: [[rod.segment]]"],
    );
    refused(
        "[simulation]",
        "[[simulation]]",
        &["12:3: simulation: got an array; expected single brackets: [simulation]"],
    );
    refused("[[rod]]", "[scene]\nname = 3\n[[rod]]", &["4:8: scene.name: got 3; expected text in quotes"]);
}

#[test]
fn words_are_checked_with_advice() {
    refused(
        "t_end = 3",
        "t_end = 3\nmethod = \"newmrk\"\njac = 3",
        &[
            "14:10: simulation.method: got \"newmrk\"; did you mean \"newmark\"? Expected \"newmark\" or \"hht\" or \
             \"generalised_alpha\" or \"rk45\" or \"dop853\" or \"radau\" or \"quasi_static\" or \"auto\"",
            "15:7: simulation.jac: got 3; expected \"analytic\" or \"forward\" or \"central\"",
        ],
    );
    refused(
        "t_end = 3",
        "t_end = 3\noutput.quantities = ['tip']",
        &[
            "14:22: simulation.output.quantities[0]: got \"tip\"; expected \"velocity\" or \"acceleration\" or \
           \"energy\" or \"shape\"",
        ],
    );
}

#[test]
fn numbers_too_large_for_their_type_are_refused() {
    refused(
        "t_end = 3",
        "t_end = 1e999",
        &["13:9: simulation.t_end: 1e999 is too large; expected a double, at most 1.8e308"],
    );
    refused(
        "bend_y = 3",
        "bend_y = 99999999999999999999",
        &[
            "10:20: rod[0].segment[0].modes.bend_y: 99999999999999999999 is too large; expected an integer below \
           9.2e18",
        ],
    );
    let text = changed("bend_y = 3", "bend_y = 0x3");
    assert_eq!(rod_of(&text).coordinates(), 3, "integers may be written in hexadecimal");
}

#[test]
fn impossible_physics_is_refused() {
    refused(
        "length = 1.0",
        "length = -1.0",
        &["5:10: rod[0].segment[0].length: got -1; expected a finite number > 0 (metres)"],
    );
    refused(
        "radius = 1e-3",
        "radius = [1e-3, -2e-3]",
        &["6:17: rod[0].segment[0].radius[1]: got -0.002; expected a finite number > 0 (metres)"],
    );
    refused(
        "7800",
        "nan",
        &["9:11: rod[0].segment[0].density: got NaN; expected a finite number > 0 (kg/m^3)"],
    );
    refused(
        "shear_modulus = 80e9",
        "poisson_ratio = 0.6",
        &["8:17: rod[0].segment[0].poisson_ratio: got 0.6; expected a Poisson's ratio in (-1, 0.5]"],
    );
    refused(
        "shear_modulus = 80e9",
        "poisson_ratio = -1",
        &["8:17: rod[0].segment[0].poisson_ratio: got -1; expected a Poisson's ratio in (-1, 0.5]"],
    );
    refused(
        "shear_modulus = 80e9",
        "poisson_ratio = nan",
        &["8:17: rod[0].segment[0].poisson_ratio: got NaN; expected a finite number"],
    );
    refused(
        "shear_modulus = 80e9",
        "shear_modulus = 60e9",
        &[
            "8:17: rod[0].segment[0].shear_modulus: got 60000000000 (Poisson's ratio E/(2G) - 1 = 0.7500); expected a \
           shear modulus with Poisson's ratio in (-1, 0.5], as isotropic materials have; others are described by a \
           given section",
        ],
    );
    refused(
        "shear_modulus = 80e9",
        "shear_modulus = 80e9\npoisson_ratio = 0.3",
        &[
            "9:17: rod[0].segment[0].poisson_ratio: both poisson_ratio and shear_modulus are given; keep one of them",
        ],
    );
    refused(
        "[[rod.segment]]",
        "base.orientation = [0, 0, 0, 0]\nbase.position = [0, inf, 0]\ntip_mass = -1\n[[rod.segment]]",
        &[
            "4:20: rod[0].base.orientation: got a quaternion of norm 0; expected a quaternion (w, x, y, z) of norm 1",
            "5:21: rod[0].base.position[1]: got inf; expected a finite number",
            "6:12: rod[0].tip_mass: got -1; expected a finite number >= 0 (kilograms)",
        ],
    );
    refused(
        "[[rod]]",
        "[scene]\ngravity = [0, nan, 9]\n[[rod]]",
        &["4:15: scene.gravity[1]: got NaN; expected a finite number"],
    );
    refused(
        "bend_y = 3",
        "",
        &[
            "4:7: rod[0].segment: no modes, so nothing can move; give at least one, such as modes = { bend_y = 3 }",
        ],
    );
    refused(
        "[[rod.segment]]",
        "q0 = [1, inf]\n[[rod.segment]]",
        &[
            "4:6: rod[0].q0: got 2 values; expected 3 values, one for each mode of the rod",
            "4:10: rod[0].q0[1]: got inf; expected a finite number",
        ],
    );
}

#[test]
fn a_shape_at_the_start_that_no_node_resolves_is_refused() {
    let found = problems(&changed("[[rod.segment]]", "q0 = [1e8, 0, 0]\n[[rod.segment]]"));
    let [problem] = found.as_slice() else { panic!("{found:?}") };
    assert!(
        problem.starts_with("4:6: rod[0].q0: got a rod that turns by more than half a turn"),
        "{problem}"
    );
}

#[test]
fn a_poisson_ratio_of_one_half_is_a_ratio_like_any_other() {
    let rod = rod_of(&changed("shear_modulus = 80e9", "poisson_ratio = 0.5"));
    assert_eq!(rod.segments[0].shear_modulus, 70e9);
}

#[test]
fn sections_are_read() {
    let segment = |section: &str| rod_of(&changed("radius = 1e-3", section)).segments.remove(0);
    let circle = segment("radius = [1e-3, 2e-3]");
    assert_eq!(segment("section = { shape = 'circle', radius = [1e-3, 2e-3] }"), circle);
    let shapes = [
        (
            "section = { shape = 'hollow_circle', outer = 2e-3, inner = [0, 1e-3] }",
            rod::Shape::HollowCircle { outer: 2e-3.into(), inner: rod::Profile::linear([[0.0], [1e-3]]) },
        ),
        (
            "section = { shape = 'rectangle', width = 2e-3, height = 1e-3 }",
            rod::Shape::Rectangle { width: 2e-3.into(), height: 1e-3.into() },
        ),
        (
            "section = { shape = 'ellipse', semi_axis_y = 2e-3, semi_axis_z = 1e-3 }",
            rod::Shape::Ellipse { semi_axis_y: 2e-3.into(), semi_axis_z: 1e-3.into() },
        ),
    ];
    for (text, shape) in shapes {
        assert_eq!(segment(text), rod::Segment { section: rod::Section::Shape(shape), ..circle.clone() });
    }
    let table = "{ stations = [0, 0.4, 1], values = [1e-3, 3e-3, 2e-3] }";
    let radius = rod::Profile::table(&[0.0, 0.4, 1.0], &[[1e-3], [3e-3], [2e-3]]).expect("a table");
    let section = rod::Section::Shape(rod::Shape::Circle { radius });
    let wanted = rod::Segment { section, ..circle.clone() };
    assert_eq!(segment(&format!("radius = {table}")), wanted);
    assert_eq!(segment(&format!("section = {{ shape = 'circle', radius = {table} }}")), wanted);
    let corrections = [
        ("0.9", rod::ShearCorrection::Factors([0.9; 2])),
        ("[0.8, 0.9]", rod::ShearCorrection::Factors([0.8, 0.9])),
        ("'cowper'", rod::ShearCorrection::Cowper),
    ];
    for (text, correction) in corrections {
        let found = segment(&format!("radius = 1e-3\nshear_correction = {text}"));
        assert_eq!(found.shear_correction, correction);
    }
}

const MATERIAL: &str = "radius = 1e-3\nyoung_modulus = 210e9\nshear_modulus = 80e9\ndensity = 7800\n";

#[test]
fn given_sections_are_read_and_take_no_material() {
    let text = changed(
        MATERIAL,
        "section = { shape = 'given', stiffness = [1, 2, 3, 4, 5, 6], mass = 0.1, inertia = [1, 2, 3], centre = [0, 1] }\n",
    );
    let given = rod::GivenSection {
        stiffness: rod::diagonal([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).into(),
        mass: 0.1.into(),
        inertia: rod::diagonal([1.0, 2.0, 3.0]).into(),
        centre: [0.0, 1.0].into(),
    };
    let wanted = rod::Segment { modes: [0, 3, 0, 0, 0, 0], ..rod::Segment::given(1.0, given) };
    assert_eq!(rod_of(&text).segments, [wanted]);

    let rows = "[[2,0,0,0,0,0],[0,2,0,0,0,1],[0,0,2,0,0,0],[0,0,0,2,0,0],[0,0,0,0,2,0],[0,1,0,0,0,2]]";
    let full = changed(MATERIAL, &format!("section = {{ shape = 'given', stiffness = {rows}, mass = 1 }}\n"));
    let rod::Section::Given(section) = rod_of(&full).segments.remove(0).section else { panic!("given") };
    let stiffness = section.at(0.3).stiffness;
    assert_eq!([stiffness[1][5], stiffness[5][1]], [1.0; 2]);

    let text =
        changed("radius = 1e-3", "section = { shape = 'given', stiffness = [1, 2, 3, 4, 5, 6], mass = 0.1 }");
    let right = "a given section has all that it needs; remove it";
    let wanted =
        ["young_modulus", "shear_modulus", "density"].map(|key| format!("rod[0].segment[0].{key}: {right}"));
    assert_eq!(unplaced(&text), wanted);
}

/// The problems without line and column.
fn unplaced(text: &str) -> Vec<String> {
    let without_place =
        |problem: &String| problem.split_once(": ").map_or(String::new(), |(_, rest)| rest.to_owned());
    problems(text).iter().map(without_place).collect()
}

#[test]
fn sections_that_are_none_are_refused() {
    let here = "rod[0].segment[0]";
    refused("radius = 1e-3\n", "", &[&format!("4:1: {here}: neither radius nor section; add one of them")]);
    refused(
        "density = 7800\n",
        "",
        &[&format!("4:1: {here}.density: missing; add density: density (kg/m^3, > 0)")],
    );
    for (section, expected) in [
        (
            "{ shape = 'rectangle', width = 1e-3 }",
            "rod[0].segment[0].section: height is missing; add height: side along body z (metres, > 0)",
        ),
        (
            "{ shape = 'rectangle', width = 1e-3, height = 0.0 }",
            "rod[0].segment[0].section.height: got 0; expected a finite number > 0 (metres)",
        ),
        (
            "{ shape = 'circle', radius = [1e-3, -1e-3] }",
            "rod[0].segment[0].section.radius[1]: got -0.001; expected a finite number > 0 (metres)",
        ),
        (
            "{ shape = 'circle', radius = 1e-3, width = 1 }",
            "rod[0].segment[0].section.width: a section of shape \"circle\" does not take it; remove it: it takes radius",
        ),
        (
            "{ shape = 'hollow_circle', outer = 1e-3, inner = 2e-3 }",
            "rod[0].segment[0].section.inner: got [0.002, 0.002]; expected less than the outer radius",
        ),
        (
            "{ shape = 'square', width = 1 }",
            "rod[0].segment[0].section.shape: got \"square\"; expected \"circle\" or \"hollow_circle\" or \
             \"rectangle\" or \"ellipse\" or \"given\"",
        ),
    ] {
        assert_eq!(unplaced(&changed("radius = 1e-3", &format!("section = {section}"))), [expected]);
    }
    refused(
        "radius = 1e-3",
        "radius = 1e-3\nsection = { shape = 'circle', radius = 1 }",
        &["7:1: rod[0].segment[0].section: both radius and section are given; keep one of them"],
    );
    let given = |stiffness: &str| {
        let section = format!("section = {{ shape = 'given', stiffness = {stiffness}, mass = 1 }}\n");
        unplaced(&changed(MATERIAL, &section))
    };
    assert_eq!(
        given("[1, 0, 1, 1, 1, 1]"),
        [
            "rod[0].segment[0].section.stiffness[1][1]: got 0; expected a positive stiffness, as bend_y has modes"
        ]
    );
    let unknown = unplaced(&changed(MATERIAL, "section = { shape = 'givn' }\n"));
    let [problem] = &unknown[..] else { panic!("not one problem: {unknown:#?}") };
    assert!(problem.contains("section.shape: got \"givn\"; did you mean \"given\"?"), "{problem}");
    let found = given("[1, 2, 3]");
    let [problem] = &found[..] else { panic!("not one problem: {found:#?}") };
    assert!(problem.contains("section.stiffness: got an array of 3; expected an array of 6"), "{problem}");
}

#[test]
fn fixed_steps_that_cannot_see_an_oscillation_are_refused() {
    let load = "[[rod.load]]\nforce = { amplitude = [0, 0, 1], frequency = 100 }\n\n[simulation]\ndt = 0.01";
    let [problem] = &unplaced(&changed("[simulation]", load))[..] else { panic!("not one problem") };
    assert!(
        problem.contains("simulation.dt: got 0.01 s for a load or a base motion with a period of 0.01 s"),
        "{problem}"
    );
}

#[test]
fn a_scene_needs_exactly_one_body() {
    let simulation = "[simulation]\nt_end = 1\n";
    assert_eq!(
        problems(&format!("version = 1\n{simulation}")),
        [
            "1:1: nothing to simulate; add a [[rod]] with its [[rod.segment]], the [[link]] of a robot, or a [pendulum]"
        ]
    );
    refused(
        "[simulation]",
        "[pendulum]\n[simulation]",
        &["12:2: pendulum: a rod and a pendulum in one scene; keep one of them"],
    );
    let rod =
        GOOD.split_once("[[rod]]").and_then(|(_, rest)| rest.split_once("[simulation]")).expect("a rod").0;
    refused(
        "[simulation]",
        &format!("[[rod]]{rod}[simulation]"),
        &[
            "12:1: rod[1]: 2 rods in one scene; this version simulates one rod a scene; pieces in a row are its \
           [[rod.segment]]",
        ],
    );
    assert_eq!(
        problems(&format!("version = 1\n[scene]\ngravity = [0, 0, 0]\n[pendulum]\nmass = 0\n{simulation}")),
        [
            "3:11: scene.gravity: a pendulum does not use it; give the number pendulum.gravity instead",
            "5:8: pendulum.mass: got 0; expected a finite number > 0 (kilograms)",
        ]
    );
}

#[test]
fn what_does_not_fit_in_memory_is_refused() {
    refused(
        "bend_y = 3",
        "bend_y = 300",
        &["10:20: rod[0].segment[0].modes.bend_y: got 300; expected at most 64 modes"],
    );
    refused(
        "t_end = 3",
        "t_end = 3\ndt = 1e-12",
        &["14:6: simulation.dt: got 3.00e12 steps; expected at most 1e10 of them: a dt of at least 3.00e-10"],
    );
    refused(
        "t_end = 3",
        "t_end = 3\ndt = 1e-8",
        &[
            "14:6: simulation.dt: got 3.00e8 states of 128 bytes to keep; expected at most 1 GiB: an output.dt of \
           at least 3.58e-7",
        ],
    );
    let coarse = changed("t_end = 3", "t_end = 3\ndt = 1e-8\noutput.dt = 1e-3");
    assert!(Scene::parse(&coarse, "s.toml").is_ok(), "few states are kept of many steps");
    refused(
        "t_end = 3",
        "t_end = 3\noutput.dt = 1e-9",
        &["14:13: simulation.output.dt: got 3.00e9 states of 128 bytes to keep; expected at most 1 GiB: an \
           output.dt of at least 3.58e-7"],
    );
    let segment =
        &GOOD[GOOD.find("[[rod.segment]]").expect("a segment")..GOOD.find("\n[sim").expect("settings")];
    let wide = segment.replace("bend_y = 3", "bend_y = 64, bend_z = 64, torsion = 64");
    let problems = problems(&GOOD.replace(segment, &wide.repeat(33)));
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].contains("6336 modes in all"), "{problems:?}");
}

#[test]
fn numbers_of_steps_and_states_that_overflow_are_refused() {
    const MANY: &str = "got more than 1.80e308";
    for (settings, key, least) in [
        ("t_end = 1e300\ndt = 1e-300", "14:6: simulation.dt", "at least 1.00e290"),
        ("t_end = 1e308\ndt = 1e-2", "14:6: simulation.dt", "at least 1.00e298"),
        ("t_end = 1e308\nmethod = 'rk45'\ndt = 1e-2", "15:6: simulation.dt", "at least 1.19e301"),
        (
            "t_end = 1e300\nmethod = 'rk45'\noutput = { dt = 1e-300 }",
            "15:17: simulation.output.dt",
            "at least 1.19e293",
        ),
    ] {
        let found = problems(&changed("t_end = 3", settings));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with(&format!("{key}: {MANY} st")), "{found:?}");
        assert!(found[0].ends_with(least), "{found:?}");
    }
}

#[test]
fn settings_are_checked() {
    refused(
        "t_end = 3",
        "t_end = nan\ndt = 0\nrtol = -1\natol = inf\noutput.dt = -1",
        &[
            "13:9: simulation.t_end: got NaN; expected a finite number > t0 = 0 (seconds)",
            "14:6: simulation.dt: got 0; expected a finite number > 0 (seconds)",
            "15:8: simulation.rtol: got -1; expected a finite number >= 0 (relative)",
            "16:8: simulation.atol: got inf; expected a finite number >= 0 (absolute)",
            "17:13: simulation.output.dt: got -1; expected a finite number > 0 (seconds)",
        ],
    );
    refused(
        "t_end = 3",
        "t_end = 3\noutput.dt = 5",
        &["14:13: simulation.output.dt: got 5; expected at most the simulated time, 3 s"],
    );
}

#[test]
fn a_missing_header_is_named() {
    let wrong = ["3:3: rod: got a table; expected [[rod]], in double brackets, above [[rod.segment]]"];
    refused("[[rod]]\n", "", &wrong);
}

#[test]
fn the_version_is_checked_before_anything_else() {
    refused("version = 1\n", "", &["1:1: version: missing; add it as the first line: version = 1"]);
    let wrong = |found: &str| {
        let version = env!("CARGO_PKG_VERSION");
        format!("1:11: version: {found} is not a version that lissom {version} reads; expected version = 1")
    };
    refused("version = 1", "version = 2\nunknown = 3", &[&wrong("2")]);
    let wrong = [&*wrong("this")];
    refused("version = 1", "version = \"1\"", &wrong);
    refused("version = 1", "version = 1.0", &wrong);
}

#[test]
fn all_syntax_errors_are_reported_and_nothing_else() {
    let found = problems(&changed("length = 1.0", "length = \nfoo = 1 2"));
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].starts_with("5:10: ") && found[1].starts_with("6:7: "), "{found:?}");
    refused("length = 1.0", "length = 1\nlength = 2", &["6:1: duplicate key"]);
}

#[test]
fn all_problems_are_reported_at_once_in_the_order_of_the_file() {
    let text = GOOD
        .replace("length = 1.0", "lenght = 1.0")
        .replace("1e-3", "[1e-3, 0]")
        .replace("80e9", "\"soft\"")
        .replace("7800\n", "-1\n")
        .replace("t_end = 3", "t_end = 0\ndt = true");
    assert_eq!(
        problems(&text),
        [
            "5:1: rod[0].segment[0].lenght: unknown key; did you mean `length`?",
            "6:17: rod[0].segment[0].radius[1]: got 0; expected a finite number > 0 (metres)",
            "8:17: rod[0].segment[0].shear_modulus: got the text \"soft\"; expected a number",
            "9:11: rod[0].segment[0].density: got -1; expected a finite number > 0 (kg/m^3)",
            "13:9: simulation.t_end: got 0; expected a finite number > t0 = 0 (seconds)",
            "14:6: simulation.dt: got true; expected a number",
        ]
    );
}

#[test]
fn a_value_that_cannot_be_read_causes_no_other_complaint() {
    refused(
        "210e9",
        "\"hard\"",
        &["7:17: rod[0].segment[0].young_modulus: got the text \"hard\"; expected a number"],
    );
    let text = changed("{ bend_y = 3 }", "3").replace("[[rod.segment]]", "q0 = [1, 2]\n[[rod.segment]]");
    assert_eq!(problems(&text), ["11:9: rod[0].segment[0].modes: got 3; expected \"auto\" or a table"]);
}

#[test]
fn the_source_is_shown_with_the_offending_part_underlined() {
    let error =
        Scene::parse(&changed("1e-3", "[1e-3, -2e-3]"), "folder/s.toml").expect_err("a negative radius");
    assert_eq!(
        error.to_string(),
        "folder/s.toml:6:17: rod[0].segment[0].radius[1]: got -0.002; expected a finite number > 0 (metres)\n  \
         |\n6 | radius = [1e-3, -2e-3]\n  |                 ^^^^^"
    );
}

/// A file with two links, or with two errors.
struct TwoLinks {
    is_wrong: bool,
}

impl Imports for TwoLinks {
    fn read(&mut self, file: &str) -> Result<Vec<u8>, Refusal> {
        assert_eq!(file, "two.urdf");
        Ok(b"<robot/>".to_vec())
    }

    fn links(&mut self, request: &Request, content: &[u8]) -> Result<Imported, Refusal> {
        assert_eq!((request.file.as_str(), request.floating, content), ("two.urdf", false, &b"<robot/>"[..]));
        assert_eq!(request.limit_stiffness, Some(3.0));
        if self.is_wrong {
            let problem = |line, key: &str| FileProblem {
                file: "folder/two.urdf".to_owned(),
                line,
                column: 7,
                key: key.to_owned(),
                wrong: "got nothing".to_owned(),
                right: "expected something".to_owned(),
                snippet: "  <link/>".to_owned(),
            };
            return Err(Refusal::Wrong(vec![problem(3, "z"), problem(4, "a")]));
        }
        let joint = Joint::Revolute { axis: [0.0, 1.0, 0.0], forces: JointForces::default() }.described();
        let body = Body { centre: [0.1, 0.0, 0.0], ..Body::point(0.1) }.described(None);
        let arm = Link { joint, body: Some(body), parent: Some("stand".into()), ..Link::new("arm") };
        let links = vec![Link::new("stand"), arm];
        Ok(Imported { links, not_taken: None })
    }
}

const IMPORTING: &str = r#"version = 1
[import]
urdf = "two.urdf"
limit_stiffness = 3
q0 = [0.2]
[[link]]
name = "finger"
parent = "arm"
joint = { type = "revolute", axis = [0, 1, 0], mimic = { link = "arm" } }
body = { mass = 0.1, centre = [0.1, 0, 0] }
[[link]]
name = "tip"
parent = "finger"
joint = { type = "prismatic", axis = [1, 0, 0] }
body = { mass = 0.1 }
q0 = [0.3]
[[link.load]]
force = [0, 0, 1]
[simulation]
t_end = 1
"#;

#[test]
fn imported_links_stand_before_those_of_the_scene() {
    let mut two = TwoLinks { is_wrong: false };
    let scene = Scene::parse_with(IMPORTING, "folder/s.toml", &mut two).expect("the scene is good");
    let Model::Robot(robot) = &scene.model else { panic!("not a robot") };
    let parents: Vec<_> = robot.links.iter().map(|link| (link.name.as_str(), link.parent)).collect();
    assert_eq!(parents, [("stand", None), ("arm", Some(0)), ("finger", Some(1)), ("tip", Some(2))]);
    assert_eq!(robot.links[2].driven, Some(Driven::Mimic { link: 1, multiplier: 1.0, offset: 0.0 }));
    assert_eq!(robot.loads[0].link, 3);
    assert_eq!(robot.coordinate_names(), ["arm.angle", "tip.displacement"]);
    assert_eq!(scene.q0, [0.2, 0.3]);
    assert_eq!(scene.files.into_iter().collect::<Vec<_>>(), [("two.urdf".to_owned(), b"<robot/>".to_vec())]);
}

#[test]
fn problems_of_a_scene_that_imports_are_at_its_keys() {
    for (old, new, key, right) in [
        (r#"parent = "arm""#, r#"parent = "am""#, "link[0].parent", r#""stand", "arm""#),
        (r#"name = "tip""#, r#"name = "arm""#, "link[1].name", "a different name"),
        (r#"{ link = "arm" }"#, r#"{ link = "art" }"#, "link[0].joint.mimic.link", "did you mean \"arm\""),
        (
            r#"{ link = "arm" }"#,
            r#"{ link = "stand" }"#,
            "link[0].joint.mimic.link",
            "a revolute, prismatic or screw joint",
        ),
        ("q0 = [0.2]", "q0 = [0.2, 1]", "import.q0", "1 values: arm.angle"),
        ("mass = 0.1 }", "mass = -0.1 }", "link[1].body.mass", ""),
        (r#"urdf = "two.urdf""#, "urdf = 3", "import.urdf", "text"),
    ] {
        let text = IMPORTING.replace(old, new);
        assert_ne!(text, IMPORTING);
        let mut two = TwoLinks { is_wrong: false };
        let error = Scene::parse_with(&text, "s.toml", &mut two).expect_err("the scene is bad");
        let found = error.problems.iter().find(|problem| problem.key == key);
        let found = found.unwrap_or_else(|| panic!("nothing at {key}: {error}"));
        assert!(found.right.contains(right), "{error}");
    }
    let error = Scene::parse(IMPORTING, "s.toml").expect_err("nobody reads it");
    assert_eq!(error.problems.len(), 1);
    assert_eq!((error.problems[0].key.as_str(), error.problems[0].line), ("import.urdf", 3));
    let pendulum = "version = 1\n[import]\nurdf = \"two.urdf\"\nlimit_stiffness = 3\n[pendulum]\n[simulation]\nt_end = 1";
    let error = Scene::parse_with(pendulum, "s.toml", &mut TwoLinks { is_wrong: false }).expect_err("both");
    assert_eq!(error.problems[0].key, "import");
}

#[test]
fn problems_of_an_imported_file_are_in_that_file() {
    let text = IMPORTING.replace("mass = 0.1 }", "mass = -0.1 }").replace("t_end = 1", "t_end = -1");
    let error = Scene::parse_with(&text, "s.toml", &mut TwoLinks { is_wrong: true }).expect_err("it is bad");
    let headers: Vec<_> = error.problems.iter().map(|problem| error.header(problem)).collect();
    assert_eq!(headers[0], "folder/two.urdf:3:7: z: got nothing; expected something");
    assert_eq!(headers[1], "folder/two.urdf:4:7: a: got nothing; expected something");
    assert!(headers[2].starts_with("s.toml:15:"), "{error}");
    assert!(headers[2].contains("link[1].body.mass"), "{error}");
    assert!(headers[3].contains("simulation.t_end"), "{error}");
    assert_eq!(headers.len(), 4, "no follow-up of links that are not known: {error}");
    assert_eq!(error.snippet(&error.problems[0]), "  <link/>");
}

#[test]
fn the_committed_schema_is_up_to_date() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/lissom-scene.schema.json");
    if std::env::var_os("LISSOM_UPDATE_SCHEMA").is_some() {
        std::fs::write(path, Scene::schema()).expect("the schema can be written");
    }
    let committed = std::fs::read_to_string(path).expect("the schema is committed");
    assert_eq!(committed, Scene::schema(), "run LISSOM_UPDATE_SCHEMA=1 cargo test --test crate scene::");
}

#[test]
fn all_shipped_scenes_are_good() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("there are scenes") {
        let path = entry.expect("a readable folder").path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let text = std::fs::read_to_string(&path).expect("a readable file");
            if text.contains("[import]") {
                // Only Python reads the files that these scenes import; Python tests cover them.
                continue;
            }
            if let Err(error) = Scene::parse(&text, &path.to_string_lossy()) {
                panic!("{error}");
            }
            count += 1;
        }
    }
    assert!(count >= 4, "four scenes are shipped");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Any text is either read or rejected, without panics.
    #[test]
    fn no_text_causes_a_panic(cut in 0..GOOD.len(), length in 0..40usize, insert in "[\\[\\]{}=.,'\"0-9a-zé\n -]{0,12}") {
        let end = (cut + length).min(GOOD.len());
        let text = format!("{}{insert}{}", &GOOD[..cut], &GOOD[end..]);
        let _ = Scene::parse(&text, "s.toml").map_err(|error| error.to_string());
    }

    /// Any times are rejected, or few enough to be listed.
    #[test]
    fn accepted_times_can_be_listed(times in prop::array::uniform3(-323..309i32), method in prop::sample::select(&["newmark", "rk45"])) {
        let [duration, step, output] = times;
        let settings = format!("t_end = 1e{duration}\ndt = 1e{step}\noutput.dt = 1e{output}\nmethod = '{method}'");
        if let Ok(scene) = Scene::parse(&changed("t_end = 3", &settings), "s.toml") {
            // The longest allowed list takes 64 MB.
            let times = scene.simulation.output_times().expect("an output step is given");
            prop_assert_eq!(times.last(), Some(&scene.simulation.t_end));
            prop_assert!(times.is_sorted_by(|a, b| a < b));
        }
    }

    /// Any value of a key is either read or rejected, without panics.
    #[test]
    fn no_value_causes_a_panic(line in 4..13usize, value in prop::sample::select(&[
        "3", "-1", "0", "nan", "-inf", "1e308", "9223372036854775807", "true", "''", "[]", "[1]", "[[1, 2]]", "{}",
        "{a = 1}", "{bend_y = 9223372036854775807}", "[{}, 3]", "1979-05-27",
    ])) {
        let lines = GOOD.lines().enumerate().map(|(i, text)| match text.split_once('=') {
            Some((key, _)) if i == line => format!("{key} = {value}\n"),
            _ => format!("{text}\n"),
        });
        let text: String = lines.collect();
        let _ = Scene::parse(&text, "s.toml").map_err(|error| error.to_string());
    }
}

#[test]
fn old_words_are_read_and_named_with_their_places() {
    let old = changed(
        "t_end = 3",
        "t0 = 0.5\nduration = 2.5\nstep = 2e-3\njacobian = 'central'\noutput.step = 0.1",
    );
    let new = changed("t_end = 3", "t0 = 0.5\nt_end = 3\ndt = 2e-3\njac = 'central'\noutput.dt = 0.1");
    let (old, new) = (Scene::parse(&old, "s.toml").unwrap(), Scene::parse(&new, "s.toml").unwrap());
    assert_eq!(old.simulation, new.simulation);
    assert!(new.deprecations.is_empty());
    let said: Vec<String> = old.deprecations.iter().map(|said| said.header("s.toml")).collect();
    let refused = "an old name that the next version refuses";
    let expected = [
        format!(
            "s.toml:14:1: simulation.duration: {refused}; write t_end, the time at the end: duration later than t0"
        ),
        format!("s.toml:15:1: simulation.step: {refused}; write dt"),
        format!("s.toml:16:1: simulation.jacobian: {refused}; write jac"),
        format!("s.toml:17:8: simulation.output.step: {refused}; write dt"),
    ];
    assert_eq!(said, expected);
}

#[test]
fn an_old_tolerance_is_the_accuracy_of_method_auto() {
    let old = Scene::parse(&changed("t_end = 3", "t_end = 3\ntolerance = 1e-3"), "s.toml").unwrap();
    assert_eq!((old.simulation.method, old.simulation.rtol), (Method::Auto, 1e-3));
    assert_eq!(old.deprecations.len(), 1);
    refused(
        "t_end = 3",
        "t_end = 3\nmethod = 'rk45'\ntolerance = 1e-3",
        &[
            "15:1: simulation.tolerance: the method does not take it; remove the method, or write rtol and atol, which it \
             does take",
        ],
    );
}

#[test]
fn an_old_word_beside_its_new_one_is_refused() {
    refused(
        "t_end = 3",
        "t_end = 3\nduration = 3\noutput = { dt = 0.1, step = 0.1 }",
        &[
            "14:1: simulation.duration: the old name of t_end, which is given, too; remove it",
            "15:22: simulation.output.step: the old name of dt, which is given, too; remove it",
        ],
    );
    // A value under an old name is validated with the new name in messages.
    refused(
        "t_end = 3",
        "duration = 0",
        &["13:12: simulation.t_end: got 0; expected a finite number > t0 = 0 (seconds)"],
    );
}
