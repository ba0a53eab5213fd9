//! Scene files: TOML descriptions of a model and a simulation, read and validated.
//!
//! `document` is the file's structure in plain structs, whose tables define reader and JSON Schema; `shape` has the
//! values of a file with their places, `words` the old names of keys; `build`, with `parts` that rods and the `links` of
//! robots have in common, and with `actuators`, `loops` and `contacts`, turns it into a model with the usual
//! constructors; `diagnostics` formats problems with their places. A scene never executes anything.
//!
//! ```
//! use lissom::scene::Scene;
//!
//! let text = r#"
//! version = 1
//!
//! [[rod]]
//!
//! [[rod.segment]]
//! length = 1.0
//! radius = 1e-3
//! young_modulus = 210e9
//! shear_modulus = 80e9
//! density = 7800
//! modes = { bend_y = 3 }
//!
//! [simulation]
//! t_end = 1.0
//! "#;
//! let scene = Scene::parse(text, "wire.toml")?;
//! assert_eq!((scene.name.as_str(), scene.model.coordinates()), ("wire", 3));
//! # Ok::<(), lissom::scene::SceneError>(())
//! ```

mod advice;
mod arrays;
mod build;
mod described;
mod diagnostics;
mod document;
mod imports;
mod json_schema;
mod links;
mod lists;
mod parts;
mod shape;
#[cfg(feature = "python")]
mod tables;
mod words;
mod written;

use std::collections::BTreeMap;

use toml::de::{DeTable, DeValue};

use crate::error::{Interrupted, InvalidInput};
use crate::model::pendulum::SpringPendulum;
use crate::robot;
use crate::simulation::accuracy;
use crate::simulation::accuracy::{Modes, Purpose};

pub use arrays::set_aside;
pub use described::to_toml;
pub use diagnostics::{Elsewhere, SceneError, SceneProblem};
pub use document::{Jacobian, Method, Quantity};
pub use imports::{FileProblem, Imported, Imports, NoImports, Refusal, Request};
#[cfg(feature = "python")]
pub(crate) use tables::PARTS;

use shape::Shape;

/// A validated scene: the simulator accepts all of its values.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name of the scene; by default the stem of the file name.
    pub name: String,
    /// The text it was read from.
    pub text: String,
    /// The model.
    pub model: Model,
    /// Initial generalised coordinates.
    pub q0: Vec<f64>,
    /// Initial generalised velocities.
    pub v0: Vec<f64>,
    /// Settings of the simulation.
    pub simulation: Simulation,
    /// Deprecated keys in the order of the file, with their replacements.
    pub deprecations: Vec<SceneProblem>,
    /// Contents of an imported file that the robot lacks, if any.
    pub not_taken: Option<String>,
    /// Contents of the files that the text names, by their names.
    pub files: BTreeMap<String, Vec<u8>>,
}

/// Model of a scene.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "there is one in a scene")]
pub enum Model {
    /// A Cosserat rod.
    Rod(robot::Rod),
    /// A robot: a tree of links.
    Robot(robot::Robot),
    /// The spring pendulum.
    Pendulum(SpringPendulum),
}

impl Model {
    /// Number of generalised coordinates.
    pub fn coordinates(&self) -> usize {
        match self {
            Self::Rod(rod) => rod.coordinates(),
            Self::Robot(robot) => robot.coordinates(),
            Self::Pendulum(_) => 2,
        }
    }

    /// Shortest period of loads and base motion, in seconds; infinite without oscillations.
    fn shortest_period(&self) -> f64 {
        match self {
            Self::Rod(rod) => robot::Robot::from(rod).shortest_period(),
            Self::Robot(robot) => robot.shortest_period(),
            Self::Pendulum(_) => f64::INFINITY,
        }
    }
}

/// A last output time this close to the end, relative to the output step, counts as the end.
const END_OF_OUTPUT: f64 = 1e-6;

/// Settings of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// Time at the start, in seconds.
    pub t0: f64,
    /// Time at the end, in seconds.
    pub t_end: f64,
    /// Time integrator.
    pub method: Method,
    /// Time step of methods with a fixed step, in seconds.
    pub dt: f64,
    /// Jacobian of the equations of a fixed step.
    pub jac: Jacobian,
    /// Relative tolerance; with [`Method::Auto`] the requested accuracy.
    pub rtol: f64,
    /// Absolute tolerance; `None`: the default of the method.
    pub atol: Option<f64>,
    /// Interval between stored states, in seconds; `dt` if `None`.
    pub output_dt: Option<f64>,
    /// Quantities stored in addition to the coordinates.
    pub quantities: Vec<Quantity>,
}

impl Simulation {
    /// A simulation from time zero to `t_end` with defaults.
    pub fn until(t_end: f64) -> Self {
        Self {
            t0: 0.0,
            t_end,
            method: Method::default(),
            dt: 1e-2,
            jac: Jacobian::default(),
            rtol: 1e-6,
            atol: None,
            output_dt: None,
            quantities: Vec::new(),
        }
    }

    /// Start and end, in seconds.
    pub fn t_span(&self) -> (f64, f64) {
        (self.t0, self.t_end)
    }

    /// Simulated time in seconds.
    pub fn duration(&self) -> f64 {
        self.t_end - self.t0
    }

    /// Times of stored states: every output interval from the start, and the end. `None`: every `dt`.
    pub fn output_times(&self) -> Option<Vec<f64>> {
        let step = self.output_dt?;
        let whole = (self.duration() / step - END_OF_OUTPUT).max(0.0).floor() as usize;
        let mut times: Vec<f64> = (0..=whole).map(|i| self.t0 + i as f64 * step).collect();
        times.push(self.t_end);
        Some(times)
    }
}

impl Scene {
    /// Reads a scene. `file` is its name in messages, and its stem the default name of the scene. Scenes that
    /// import other files are rejected; use [`Scene::parse_with`].
    ///
    /// # Errors
    /// All problems of the text. Text that is not valid TOML has only a syntax error.
    pub fn parse(text: &str, file: &str) -> Result<Self, SceneError> {
        Self::parse_with(text, file, &mut NoImports)
    }

    /// Reads a scene, and the files that it names through `imports`; otherwise like [`Scene::parse`].
    ///
    /// # Errors
    /// As for [`Scene::parse`], and all problems of these files.
    pub fn parse_with(text: &str, file: &str, imports: &mut dyn Imports) -> Result<Self, SceneError> {
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
        let mut shape = Shape::of(&table, imports);
        let Some(document) = described::document::<document::Document>(&mut shape) else {
            return Err(fail(shape.problems));
        };
        let imported = document.import.as_ref().and_then(|import| links::import(import, imports, &mut shape));
        let built = build::build(&document, imported.as_ref(), &mut shape);
        match built {
            Some((model, [q0, v0], simulation)) if shape.problems.is_empty() => Ok(Self {
                not_taken: imported.and_then(|imported| imported.not_taken),
                files: shape.files,
                name: document.scene.name.unwrap_or_else(|| stem(file)),
                text: text.to_owned(),
                model,
                q0,
                v0,
                simulation,
                deprecations: diagnostics::placed(text, shape.deprecations),
            }),
            _ => Err(fail(shape.problems)),
        }
    }

    /// Reads a scene from the bytes of a UTF-8 file; otherwise like [`Scene::parse_with`].
    ///
    /// # Errors
    /// As for [`Scene::parse_with`], and bytes that are not UTF-8.
    pub fn from_bytes(bytes: &[u8], file: &str, imports: &mut dyn Imports) -> Result<Self, SceneError> {
        match str::from_utf8(bytes) {
            Ok(text) => Self::parse_with(text, file, imports),
            Err(error) => {
                let readable = error.valid_up_to();
                let text = String::from_utf8_lossy(bytes);
                let mut shape = Shape::default();
                shape.spans.insert(String::new(), readable..readable + 1);
                shape.refuse("", "not text in UTF-8", "save the file in UTF-8, as TOML requires");
                Err(SceneError::new(file, &text, shape.problems))
            }
        }
    }

    /// Indices of segments with open modes, counted link by link; [`Scene::choose_modes`] chooses them.
    pub fn open_modes(&self) -> Vec<usize> {
        match &self.model {
            Model::Rod(rod) => robot::Robot::from(rod).open_segments(),
            Model::Robot(robot) => robot.open_segments(),
            Model::Pendulum(_) => Vec::new(),
        }
    }

    /// Chooses the modes that the scene leaves open, by trial motions to its tolerance; `monitor` may stop
    /// the search. The model is complete only if the returned status is a success. Does nothing if no modes
    /// are open.
    pub fn choose_modes(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Modes>, InvalidInput> {
        let robot = match &self.model {
            Model::Rod(rod) => rod.into(),
            Model::Robot(robot) => robot.clone(),
            Model::Pendulum(_) => return Ok(None),
        };
        let open = robot.open_segments();
        if open.is_empty() {
            return Ok(None);
        }
        let Simulation { rtol, dt, output_dt, .. } = self.simulation;
        let request = accuracy::Request::new(rtol, output_dt.unwrap_or(dt).min(self.simulation.duration()));
        let purpose = Purpose::Motion(self.simulation.t_span());
        let modes = accuracy::choose_modes(&robot, &open, purpose, request, monitor)?;
        if modes.is_success {
            self.set_model(match &self.model {
                Model::Rod(rod) => Model::Rod(rod.with_segments_of(&modes.robot)),
                _ => Model::Robot(modes.robot.clone()),
            });
        }
        Ok(Some(modes))
    }

    /// Replaces the model, for example by one with chosen modes.
    pub fn set_model(&mut self, model: Model) {
        let n = model.coordinates();
        if self.q0.len() != n {
            (self.q0, self.v0) = (vec![0.0; n], vec![0.0; n]);
        }
        self.model = model;
    }

    /// JSON Schema of scene files for editors, in which old keys are marked as deprecated; identical to the
    /// file in `scenes/`.
    pub fn schema() -> String {
        let mut schema = json_schema::json_schema();
        words::add_old_words(&mut schema);
        let mut text = serde_json::to_string_pretty(&schema).expect("a value is JSON");
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
        let found = match version.get_ref() {
            DeValue::Integer(number) => number.as_str().to_owned(),
            _ => "this".to_owned(),
        };
        let wrong = format!("{found} is not a version that lissom {} reads", env!("CARGO_PKG_VERSION"));
        shape.refuse("version", wrong, "expected version = 1");
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
        elsewhere: None,
    }
}

fn stem(file: &str) -> String {
    std::path::Path::new(file)
        .file_stem()
        .map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into())
}
