//! Any bytes of a scene file are rejected with a message, or give a scene of which the simulator accepts
//! every number.

use lissom::robot::RobotModel;
use lissom::scene::{Model, NoImports, Scene};

/// A message is for a person: a hundred problems with their lines.
const LONGEST_MESSAGE: usize = 1_000_000;

/// Larger rods are read, but not compiled.
const COMPILED: usize = 200;

/// Does the same as `lissom check` with a file. Panics if anything is wrong; returns a description of the
/// outcome.
pub(crate) fn fuzz_scene(bytes: &[u8]) -> String {
    let scene = match Scene::from_bytes(bytes, "fuzz.toml", &mut NoImports) {
        Ok(scene) => scene,
        Err(error) => {
            assert!(!error.problems.is_empty(), "an error says what is wrong");
            let message = error.to_string();
            assert!(message.len() < LONGEST_MESSAGE, "a message of {} bytes", message.len());
            for problem in &error.problems {
                assert!(problem.line >= 1 && problem.column >= 1, "a problem without a place: {problem:?}");
                assert!(!problem.wrong.is_empty());
            }
            let kind =
                |text: &str| text.chars().filter(|c| c.is_ascii_alphabetic()).take(40).collect::<String>();
            return format!("refused {}", kind(&error.problems[0].message()));
        }
    };
    assert_eq!((scene.q0.len(), scene.v0.len()), (scene.model.coordinates(), scene.model.coordinates()));
    assert!(scene.q0.iter().chain(&scene.v0).all(|value| value.is_finite()));
    let simulation = &scene.simulation;
    assert!(simulation.duration() > 0.0 && simulation.dt > 0.0);
    let times = simulation.output_times().map_or(0, |times| times.len());
    assert!(times < 1 << 28, "{times} output times");
    match scene.model {
        Model::Pendulum(_) => "pendulum".to_owned(),
        Model::Rod(rod) if rod.coordinates() <= COMPILED => {
            let model = RobotModel::of_rod(&rod).expect("a scene that was accepted compiles");
            format!("rod of {:?} nodes", model.nodes().len().min(3))
        }
        Model::Robot(robot) if robot.coordinates() <= COMPILED => {
            let model = RobotModel::new(&robot).expect("a scene that was accepted compiles");
            format!("robot of {:?} nodes", model.nodes().len().min(3))
        }
        Model::Rod(_) | Model::Robot(_) => "large rod or robot".to_owned(),
    }
}
