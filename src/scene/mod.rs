//! Scene files: a TOML description of what is simulated and how, read and checked once.
//!
//! `document` is the file's shape in plain structs, from which the JSON Schema is generated; `shape` checks a file
//! against that schema; `build` turns it into a model with the constructors that everybody uses; `diagnostics`
//! says what is wrong, where. A scene never executes anything.

mod build;
mod diagnostics;
mod document;
mod shape;

use toml::de::{DeTable, DeValue};

use crate::pendulum::SpringPendulum;
use crate::rod;

pub use diagnostics::{SceneError, SceneProblem};
pub use document::{Jacobian, Method, Quantity};

use shape::Shape;

/// A checked scene: every number in it is one that the simulator accepts.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The scene's name; the file's stem unless it says otherwise.
    pub name: String,
    /// The text it was read from.
    pub text: String,
    /// What is simulated.
    pub model: Model,
    /// Initial generalised coordinates.
    pub q0: Vec<f64>,
    /// Initial generalised velocities.
    pub v0: Vec<f64>,
    /// How it is simulated.
    pub simulation: Simulation,
}

/// What a scene simulates.
#[derive(Clone, Debug, PartialEq)]
pub enum Model {
    /// A Cosserat rod.
    Rod(rod::Rod),
    /// The spring pendulum.
    Pendulum(SpringPendulum),
}

impl Model {
    /// Number of generalised coordinates.
    pub fn coordinates(&self) -> usize {
        match self {
            Self::Rod(rod) => rod.coordinates(),
            Self::Pendulum(_) => 2,
        }
    }
}

/// How a scene is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// Simulated time in seconds.
    pub duration: f64,
    /// Time integrator.
    pub method: Method,
    /// Newmark's time step in seconds.
    pub step: f64,
    /// Jacobian of Newmark's equations.
    pub jacobian: Jacobian,
    /// Relative tolerance.
    pub rtol: f64,
    /// Absolute tolerance.
    pub atol: f64,
    /// Time between the states that are kept, in seconds; every step of the integrator if `None`.
    pub output_step: Option<f64>,
    /// What is kept beside the coordinates.
    pub quantities: Vec<Quantity>,
}

impl Simulation {
    /// A simulation of `duration` seconds with everything else at its default.
    pub fn lasting(duration: f64) -> Self {
        Self {
            duration,
            method: Method::default(),
            step: 1e-2,
            jacobian: Jacobian::default(),
            rtol: 1e-6,
            atol: 1e-9,
            output_step: None,
            quantities: Vec::new(),
        }
    }
}

impl Scene {
    /// Reads a scene; `file` is its name in messages, and its stem the scene's name by default.
    ///
    /// # Errors
    /// Everything that is wrong with the text at once. A text that is not TOML is refused for that alone.
    pub fn parse(text: &str, file: &str) -> Result<Self, SceneError> {
        let fail = |problems| SceneError::new(file, text, problems);
        let (table, errors) = DeTable::parse_recoverable(text);
        if !errors.is_empty() {
            return Err(fail(errors.iter().map(syntax_problem).collect()));
        }
        let mut shape = Shape::default();
        check_version(table.get_ref(), &mut shape);
        if !shape.problems.is_empty() {
            return Err(fail(shape.problems));
        }
        let schema = document::schema().to_value();
        let mut shape = Shape::check(&table, &schema);
        let document: document::Document =
            shape.table.clone().try_into().expect("a table that fits the schema deserialises");
        let built = build::build(&document, &mut shape);
        match built {
            Some((model, [q0, v0], simulation)) if shape.problems.is_empty() => Ok(Self {
                name: document.scene.name.unwrap_or_else(|| stem(file)),
                text: text.to_owned(),
                model,
                q0,
                v0,
                simulation,
            }),
            _ => Err(fail(shape.problems)),
        }
    }

    /// The JSON Schema of scene files, for editors; the one in `scenes/` is this text.
    pub fn schema() -> String {
        let mut text = serde_json::to_string_pretty(document::schema().as_value()).expect("a schema is JSON");
        text.push('\n');
        text
    }
}

/// Keys of another version mean something else, so the version is checked before anything else is read.
fn check_version(table: &DeTable<'_>, shape: &mut Shape) {
    let Some((_, version)) = table.iter().find(|(key, _)| key.get_ref() == "version") else {
        return shape.refuse("version", "missing", "add it as the first line: version = 1");
    };
    let known = matches!(version.get_ref(), DeValue::Integer(number) if number.as_str().parse() == Ok(document::VERSION));
    if !known {
        shape.spans.insert("version".to_owned(), version.span());
        shape.refuse("version", "not a version that this lissom reads", "expected version = 1");
    }
}

fn syntax_problem(error: &toml::de::Error) -> SceneProblem {
    SceneProblem {
        line: 0,
        column: 0,
        key: String::new(),
        wrong: error.message().to_owned(),
        right: String::new(),
        span: error.span().unwrap_or(0..0),
    }
}

fn stem(file: &str) -> String {
    std::path::Path::new(file)
        .file_stem()
        .map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into())
}
