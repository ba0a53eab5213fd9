//! Scene files: what is read, and every kind of complaint with its exact line and column.

use lissom::rod;
use lissom::scene::{Jacobian, Method, Model, Quantity, Scene};

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
duration = 3
"#;

/// `line:column: message` of everything that is wrong with a scene.
fn problems(text: &str) -> Vec<String> {
    let error = Scene::parse(text, "s.toml").expect_err("the scene is bad");
    error.problems.iter().map(|p| error.header(p).trim_start_matches("s.toml:").to_owned()).collect()
}

/// The problems of the good scene after a change.
fn problems_with(from: &str, to: &str) -> Vec<String> {
    assert!(GOOD.contains(from), "the good scene has no {from}");
    problems(&GOOD.replacen(from, to, 1))
}

#[test]
fn print_all() {
    for (from, to) in [
        ("length", "lenght"),
        ("length = 1.0\n", ""),
        ("density = 7800", "density = \"heavy\""),
        ("radius = 1e-3", "radius = [1e-3, -2e-3]"),
        ("radius = 1e-3", "radius = [1e-3, 2, 3]"),
        ("radius = 1e-3", "radius = true"),
        ("bend_y = 3", "bendy = 3"),
        ("bend_y = 3", "bend_y = -3"),
        ("bend_y = 3", "bend_y = 3.0"),
        ("bend_y = 3", "bend_y = 300"),
        ("bend_y = 3", ""),
        ("shear_modulus = 80e9", "shear_modulus = 60e9"),
        ("shear_modulus = 80e9", "poisson_ratio = 0.6"),
        ("shear_modulus = 80e9", "poisson_ratio = -1"),
        ("shear_modulus = 80e9", "poisson_ratio = 0.3\nshear_modulus = 80e9"),
        ("shear_modulus = 80e9", ""),
        ("duration = 3", "duration = nan"),
        ("duration = 3", "duration = 1e999"),
        ("duration = 3", "duration = 3\nmethod = \"newmrk\"\njacobian = 3"),
        ("duration = 3", "duration = 3\nstep=1e-12"),
        ("duration = 3", "duration = 3\nstep=1e-8"),
        ("duration = 3", "duration = 3\nstep=1e-2\n[simulation.output]\nstep=5\nquantities=[\"enrgy\", 3]"),
        ("[[rod]]", "[[rod]]\nbase = {position=[0,0], orientation=[0,0,0,0]}\ngravity=3\nq0=[1,inf]"),
        ("[[rod]]", "[scene]\ngravity = [0, nan, 9]\n[[rod]]\n"),
        ("[[rod]]", "[rod]"),
        ("[[rod.segment]]", "[rod.segment]"),
        ("version = 1", "version = 2"),
        ("version = 1", ""),
        ("length = 1.0", "length = "),
        ("length = 1.0", "length = 1\nlength = 2"),
        ("[simulation]\nduration = 3", ""),
        ("[simulation]", "[[rod]]\n[pendulum]\nmass = 0\n[simulation]"),
        ("[simulation]", "[pendullum]\nmass = 0\n[simulation]"),
    ] {
        println!("--- {from:?} -> {to:?}");
        let error = Scene::parse(&GOOD.replacen(from, to, 1), "s.toml");
        match error { Ok(_) => println!("FINE"), Err(e) => println!("{e}") }
    }
}
