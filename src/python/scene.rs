//! `lissom.Scene` and its errors.

use std::collections::BTreeMap;
use std::path::PathBuf;

use numpy::{PyArray1, ToPyArray};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::create_exception;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyTuple};

use super::arguments;
use super::callback::Raised;
use super::errors::{LissomError, OrRaise as _};
use super::imports::Files;
use super::model::PyModel;
use super::motion::signals;
use super::pendulum::PySpringPendulum;
use super::record::{self, Reduced};
use super::robot::PyRobot;
use super::rod::PyRod;
use super::words::{warn, warn_of_old_word};
use crate::python::words::required;
use crate::scene::{
    Jacobian, Method, Model, Quantity, Scene, SceneError as CoreError, SceneProblem, Simulation, set_aside,
};

create_exception!(
    lissom,
    SceneError,
    PyValueError,
    "A scene that was refused: ``problems`` lists what is wrong with it (SceneProblem, in the order of the file, the first\n\
     hundred), the message shows each with the line it is about, and at its end the number of those left out."
);

/// A problem in a scene. As a string: ``file:line:column: key: what is wrong; what would be right``.
#[pyclass(name = "SceneProblem", module = "lissom", frozen)]
pub(crate) struct PySceneProblem {
    /// The file name, as given.
    #[pyo3(get)]
    file: String,
    /// Line number, from 1.
    #[pyo3(get)]
    line: usize,
    /// Column in characters, from 1.
    #[pyo3(get)]
    column: usize,
    /// Path of the key, such as ``rod[0].segment[1].radius``; empty for a syntax error.
    #[pyo3(get)]
    key: String,
    /// What is wrong.
    #[pyo3(get)]
    wrong: String,
    /// What is expected; may be empty for a syntax error.
    #[pyo3(get)]
    right: String,
    /// The line of the problem, with the offending part underlined.
    #[pyo3(get)]
    snippet: String,
    header: String,
}

#[pymethods]
impl PySceneProblem {
    fn __str__(&self) -> &str {
        &self.header
    }

    fn __repr__(&self) -> String {
        format!("<SceneProblem {}>", self.header)
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let Self { file, line, column, key, wrong, right, snippet, header } = self;
        record::reduce_to::<Self>(py, (file, line, column, key, wrong, right, snippet, header))
    }

    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "the fields")]
    fn _restore(
        file: String,
        line: usize,
        column: usize,
        key: String,
        wrong: String,
        right: String,
        snippet: String,
        header: String,
    ) -> Self {
        Self { file, line, column, key, wrong, right, snippet, header }
    }
}

impl PySceneProblem {
    fn new(error: &CoreError, problem: &SceneProblem) -> Self {
        Self {
            file: problem.file(&error.file).to_owned(),
            line: problem.line,
            column: problem.column,
            key: problem.key.clone(),
            wrong: problem.wrong.clone(),
            right: problem.right.clone(),
            snippet: error.snippet(problem),
            header: error.header(problem),
        }
    }
}

/// A validated model and simulation settings, read from a TOML file.
///
/// Created by ``Scene.load`` and ``Scene.loads``. Reading a scene executes no code.
#[pyclass(name = "Scene", module = "lissom", frozen)]
pub(crate) struct PyScene {
    scene: Scene,
    model: Py<PyModel>,
}

#[pymethods]
impl PyScene {
    /// Says what makes scenes.
    #[new]
    #[pyo3(signature = (*_args, **_kwargs))]
    fn refused(_args: &Bound<'_, PyTuple>, _kwargs: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        Err(PyTypeError::new_err(
            "scenes are read: `lissom.Scene.load(path)` from a file, `lissom.Scene.loads(text)` from a text; `model.to_scene()` makes \
             one of a model",
        ))
    }

    /// Read and check a scene file.
    ///
    /// Parameters
    /// ----------
    /// path : str or path-like
    /// anywhere : bool
    ///     Whether the scene may import files outside its folder, which is refused by default.
    ///
    /// Returns
    /// -------
    /// scene : Scene
    ///
    /// Raises
    /// ------
    /// SceneError
    ///     If the scene is invalid; the error lists all problems.
    /// OSError
    ///     If the file cannot be read.
    ///
    /// Warns
    /// -----
    /// FutureWarning
    ///     For every key with an old name, with its place and the new name.
    /// lissom.urdf.UrdfWarning
    ///     If an imported file has content that the robot does not include.
    #[staticmethod]
    #[pyo3(signature = (path=None, *, anywhere=false, **others), text_signature = "(path, *, anywhere=False)")]
    fn load(
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::given_path)] path: Option<PathBuf>,
        #[pyo3(from_py_with = arguments::flag::anywhere)] anywhere: bool,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let path = required!("Scene.load", others, path);
        let file = path.display().to_string();
        // Python's own errors contain the file name and have the right class.
        let bytes: Vec<u8> =
            py.import("lissom.common.disk")?.call_method1("read_given", (path,))?.extract()?;
        let mut imports = Files::beside(&file, anywhere);
        let read = py.detach(|| Scene::from_bytes(&bytes, &file, &mut imports));
        Self::new(py, &file, imports.or_raised(read)?)
    }

    /// Check a scene given as text.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     TOML.
    /// name : str
    ///     Name of the text in messages, and of the scene if the text gives none. Paths of imported files are
    ///     relative to the folder of this name, by default to the working directory.
    /// anywhere : bool
    ///     Whether the text may import files outside that folder, which is refused by default.
    /// imports : dict of str to bytes, optional
    ///     Contents of the files that the text names, in place of those on disk: `imports` of another scene.
    ///
    /// Returns
    /// -------
    /// scene : Scene
    ///
    /// Raises
    /// ------
    /// SceneError
    ///     If the scene is invalid; the error lists all problems.
    #[staticmethod]
    #[pyo3(signature = (text=None, name="scene", *, anywhere=false, imports=None, **others),
           text_signature = "(text, name='scene', *, anywhere=False, imports=None)")]
    fn loads(
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::given_text::text)] text: Option<&str>,
        #[pyo3(from_py_with = arguments::text::name)] name: &str,
        #[pyo3(from_py_with = arguments::flag::anywhere)] anywhere: bool,
        #[pyo3(from_py_with = arguments::imports)] imports: Option<BTreeMap<String, Vec<u8>>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let text = required!("Scene.loads", others, text);
        let mut imports = imports.map_or_else(|| Files::beside(name, anywhere), Files::given);
        let read = py.detach(|| Scene::parse_with(text, name, &mut imports));
        Self::new(py, name, imports.or_raised(read)?)
    }

    /// The JSON Schema of scene files as text, for editors.
    #[staticmethod]
    fn schema() -> String {
        Scene::schema()
    }

    /// Name of the scene; by default the stem of its file.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// The text of the scene.
    #[getter]
    fn text(&self) -> &str {
        &self.scene.text
    }

    /// Contents (bytes) of the files that the scene names, by these names: a robot, arrays. Results keep them with the text.
    #[getter]
    fn imports<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let imports = PyDict::new(py);
        for (name, content) in &self.scene.files {
            imports.set_item(name, PyBytes::new(py, content))?;
        }
        Ok(imports)
    }

    /// The text without its large arrays, and these as CSV files by name, whose names begin with `stem`.
    fn _set_aside(&self, stem: &str) -> (String, Vec<(String, String)>) {
        set_aside(&self.scene.text, stem)
    }

    /// The simulated model: a Rod, a Robot or a SpringPendulum.
    #[getter]
    fn model(&self, py: Python<'_>) -> Py<PyModel> {
        self.model.clone_ref(py)
    }

    /// Initial generalised coordinates, shape (n,).
    #[getter]
    fn q0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.scene.q0.to_pyarray(py)
    }

    /// Initial generalised velocities, shape (n,).
    #[getter]
    fn v0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.scene.v0.to_pyarray(py)
    }

    /// The simulation settings.
    #[getter]
    fn simulation(&self) -> PySimulationSettings {
        PySimulationSettings(self.scene.simulation.clone())
    }

    /// Simulate the scene.
    ///
    /// Parameters
    /// ----------
    /// **options
    ///     Options of ``lissom.simulate`` that override those of the scene, such as ``dt=1e-3``.
    ///
    /// Returns
    /// -------
    /// result
    ///     The result of ``lissom.simulate``.
    #[pyo3(signature = (**options))]
    fn run<'py>(&self, py: Python<'py>, options: Option<&Bound<'py, PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        let arguments = self.options(py)?;
        if let Some(options) = options {
            if let Some(method) = options.get_item("method")? {
                // Options of the scene's method: another one may not have them, or mean something else by them.
                let is_auto = |method: &str| method == "auto";
                let own = self.scene.simulation.method == Method::Auto;
                let keeps_tolerances = method.extract().is_ok_and(|name: &str| !is_auto(name)) && !own;
                let others: &[_] = if keeps_tolerances { &["jac"] } else { &["jac", "rtol", "atol"] };
                for name in others {
                    if arguments.contains(name)? {
                        arguments.del_item(name)?;
                    }
                }
            }
            arguments.update(options.as_mapping())?;
        }
        let simulate = py.import("lissom")?.getattr("simulate")?;
        simulate.call((self.model(py),), Some(&arguments))
    }

    /// The arguments for ``lissom.simulate`` except the model, including ``t_end``, as a dict.
    #[getter]
    fn options<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let simulation = &self.scene.simulation;
        let arguments = PyDict::new(py);
        let (t0, t_end) = simulation.t_span();
        arguments.set_item("t_end", t_end)?;
        arguments.set_item("t0", t0)?;
        arguments.set_item("q0", self.q0(py))?;
        arguments.set_item("v0", self.v0(py))?;
        arguments.set_item("method", method(simulation))?;
        arguments.set_item("dt", simulation.dt)?;
        // Other methods reject these options.
        if simulation.method.has_fixed_step() && simulation.method != Method::QuasiStatic {
            arguments.set_item("jac", jac(simulation))?;
        }
        arguments.set_item("rtol", simulation.rtol)?;
        if let Some(atol) = simulation.atol {
            arguments.set_item("atol", atol)?;
        }
        if let Some(times) = simulation.output_times() {
            arguments.set_item("t_eval", times.to_pyarray(py))?;
        }
        Ok(arguments)
    }

    fn __repr__(&self) -> String {
        format!("<lissom.Scene {:?}>", self.scene.name)
    }

    /// For copies and pickles. The model is included, so that numbers of modes that the scene leaves open are
    /// not chosen again.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        record::reduce_to::<Self>(py, (&self.scene.text, &self.scene.name, &self.model, self.imports(py)?))
    }

    #[staticmethod]
    #[pyo3(signature = (text, name, model, imports))]
    fn _restore(
        py: Python<'_>,
        text: &str,
        name: String,
        model: &Bound<'_, PyModel>,
        imports: BTreeMap<String, Vec<u8>>,
    ) -> PyResult<Self> {
        let mut imports = Files::given(imports);
        let parsed = py.detach(|| Scene::parse_with(text, &name, &mut imports));
        let mut scene = imports.or_raised(parsed)?.map_err(|error| refusal(py, &error))?;
        scene.name = name;
        if let Ok(rod) = model.cast::<PyRod>() {
            scene.set_model(Model::Rod(rod.get().description().clone()));
        } else if let Ok(robot) = model.cast::<PyRobot>() {
            scene.set_model(Model::Robot(robot.get().description().clone()));
        }
        Ok(Self { scene, model: model.clone().unbind() })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.model)
    }
}

impl PyScene {
    /// The scene read from `file`, with a warning for every old name in it.
    fn new(py: Python<'_>, file: &str, read: Result<Scene, CoreError>) -> PyResult<Self> {
        let mut scene = read.map_err(|error| refusal(py, &error))?;
        for deprecation in &scene.deprecations {
            warn(py, &deprecation.header(file))?;
        }
        if let Some(not_taken) = &scene.not_taken {
            let class = py.import("lissom.urdf")?.getattr("UrdfWarning")?;
            py.import("warnings")?.call_method1("warn", (not_taken, class))?;
        }
        if !scene.open_modes().is_empty() {
            let mut raised = Raised::default();
            let chosen = py.detach(|| scene.choose_modes(&mut signals(&mut raised)));
            raised.into_result()?;
            if let Some(modes) = chosen.or_raise()?
                && !modes.is_success
            {
                return Err(LissomError::new_err(format!("{}: modes: {}", scene.name, modes.message)));
            }
        }
        let model = match &scene.model {
            Model::Rod(rod) => Bound::new(py, PyRod::initializer(rod.clone())?)?.into_super().into_super(),
            Model::Robot(robot) => Bound::new(py, PyRobot::initializer(robot.clone())?)?.into_super(),
            Model::Pendulum(pendulum) => {
                Bound::new(py, PySpringPendulum::initializer(pendulum.clone()))?.into_super()
            }
        };
        Ok(Self { scene, model: model.unbind() })
    }
}

/// Simulation settings of a scene: those that it gives, and defaults.
#[pyclass(name = "SimulationSettings", module = "lissom", frozen, eq)]
#[derive(PartialEq)]
pub(crate) struct PySimulationSettings(Simulation);

#[pymethods]
impl PySimulationSettings {
    /// Start time, seconds.
    #[getter]
    fn t0(&self) -> f64 {
        self.0.t0
    }

    /// End time, seconds.
    #[getter]
    fn t_end(&self) -> f64 {
        self.0.t_end
    }

    /// Time integrator, a method of ``lissom.simulate``.
    #[getter]
    fn method(&self) -> &'static str {
        method(&self.0)
    }

    /// Time step of methods with a fixed step, seconds.
    #[getter]
    fn dt(&self) -> f64 {
        self.0.dt
    }

    /// Jacobian of the equations of a fixed step: "analytic", "forward" or "central".
    #[getter]
    fn jac(&self) -> &'static str {
        jac(&self.0)
    }

    /// Relative tolerance; with method "auto" the requested accuracy.
    #[getter]
    fn rtol(&self) -> f64 {
        self.0.rtol
    }

    /// Absolute tolerance; None for the default of the method.
    #[getter]
    fn atol(&self) -> Option<f64> {
        self.0.atol
    }

    /// Interval of the saved states, seconds; None for every ``dt``.
    #[getter]
    fn output_dt(&self) -> Option<f64> {
        self.0.output_dt
    }

    /// Saved quantities in addition to the coordinates, out of "velocity", "acceleration", "energy", "shape".
    #[getter]
    fn quantities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let names = self.0.quantities.iter().map(|quantity| name_of(&QUANTITIES, quantity));
        PyTuple::new(py, names.collect::<Vec<_>>())
    }

    /// The attributes, without old names, which warn when they are read.
    fn __dir__<'py>(slf: &Bound<'py, Self>) -> PyResult<Vec<String>> {
        const OLD: [&str; 4] = ["duration", "step", "jacobian", "output_step"];
        let object = slf.py().get_type::<PyAny>();
        let names: Vec<String> = object.call_method1("__dir__", (slf,))?.extract()?;
        Ok(names.into_iter().filter(|name| !OLD.contains(&name.as_str())).collect())
    }

    /// The old name of ``t_end - t0``.
    #[getter]
    fn duration(&self, py: Python<'_>) -> PyResult<f64> {
        warn_of_old_word(py, "SimulationSettings.duration", "write t_end - t0")?;
        Ok(self.0.duration())
    }

    /// The old name of ``dt``.
    #[getter]
    fn step(&self, py: Python<'_>) -> PyResult<f64> {
        warn_of_old_word(py, "SimulationSettings.step", "write dt")?;
        Ok(self.0.dt)
    }

    /// The old name of ``jac``.
    #[getter]
    fn jacobian(&self, py: Python<'_>) -> PyResult<&'static str> {
        warn_of_old_word(py, "SimulationSettings.jacobian", "write jac")?;
        Ok(jac(&self.0))
    }

    /// The old name of ``output_dt``.
    #[getter]
    fn output_step(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        warn_of_old_word(py, "SimulationSettings.output_step", "write output_dt")?;
        Ok(self.0.output_dt)
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let Simulation { t0, t_end, method: _, dt, jac: _, rtol, atol, output_dt, quantities: _ } =
            slf.get().0;
        let names = (method(&slf.get().0), jac(&slf.get().0), slf.get().quantities(slf.py())?);
        record::reduce_to::<Self>(slf.py(), (names, (t0, t_end), (dt, rtol, atol), output_dt))
    }

    #[staticmethod]
    fn _restore(
        names: (String, String, Vec<String>),
        span: (f64, f64),
        numbers: (f64, f64, Option<f64>),
        output_dt: Option<f64>,
    ) -> PyResult<Self> {
        let (method, jac, quantities) = names;
        let ((t0, t_end), (dt, rtol, atol)) = (span, numbers);
        let (method, jac) = (setting_of(&METHODS, &method)?, setting_of(&JACOBIANS, &jac)?);
        let quantities =
            quantities.iter().map(|name| setting_of(&QUANTITIES, name)).collect::<PyResult<_>>()?;
        Ok(Self(Simulation { t0, t_end, method, dt, jac, rtol, atol, output_dt, quantities }))
    }
}

/// Names of the settings in Python.
const METHODS: [(Method, &str); 8] = [
    (Method::Newmark, "newmark"),
    (Method::Hht, "hht"),
    (Method::GeneralisedAlpha, "generalised_alpha"),
    (Method::Rk45, "rk45"),
    (Method::Dop853, "dop853"),
    (Method::Radau, "radau"),
    (Method::QuasiStatic, "quasi_static"),
    (Method::Auto, "auto"),
];
const JACOBIANS: [(Jacobian, &str); 3] =
    [(Jacobian::Analytic, "analytic"), (Jacobian::Forward, "forward"), (Jacobian::Central, "central")];
const QUANTITIES: [(Quantity, &str); 4] = [
    (Quantity::Velocity, "velocity"),
    (Quantity::Acceleration, "acceleration"),
    (Quantity::Energy, "energy"),
    (Quantity::Shape, "shape"),
];

fn name_of<T: PartialEq>(names: &[(T, &'static str)], setting: &T) -> &'static str {
    names.iter().find(|(known, _)| known == setting).expect("all settings have names").1
}

fn setting_of<T: Copy>(names: &[(T, &'static str)], name: &str) -> PyResult<T> {
    let found = names.iter().find(|(_, known)| *known == name);
    found.map(|found| found.0).ok_or_else(|| PyValueError::new_err(format!("unknown setting {name:?}")))
}

fn method(simulation: &Simulation) -> &'static str {
    name_of(&METHODS, &simulation.method)
}

fn jac(simulation: &Simulation) -> &'static str {
    name_of(&JACOBIANS, &simulation.jac)
}

fn refusal(py: Python<'_>, error: &CoreError) -> PyErr {
    let exception = SceneError::new_err(error.to_string());
    let problems = error.problems.iter().map(|problem| PySceneProblem::new(error, problem));
    let kept = PyList::empty(py);
    for problem in problems {
        if let Err(failure) = Bound::new(py, problem).and_then(|problem| kept.append(problem)) {
            return failure;
        }
    }
    match exception.value(py).setattr("problems", kept) {
        Ok(()) => exception,
        Err(failure) => failure,
    }
}
