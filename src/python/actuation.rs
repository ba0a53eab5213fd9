//! Conversion of actuators: Python objects with the attributes of `lissom.Tendon` and the other classes.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use super::convert;
use super::link::{Links, has_default_name};
use super::profile;
use super::signal::{Functions, signal_of, signal_out};
use crate::actuator::{
    ActiveStrain, Actuator, Along, Chamber, Drive, Motor, MotorCommand, Part, Tendon, Via,
};
use crate::description::suggestion;
use crate::error::{Checker, InvalidInput, Number};
use crate::robot::{Robot, number_default_names};
use crate::rod::{Parts, Profile, STRAIN_NAMES};
use crate::signal::Signal;

/// Class names for messages.
const EXPECTED: &str = "lissom.Tendon, Chamber, Motor or ActiveStrain";

/// Stand-in for the length of unknown links, for checks that do not depend on it.
const UNIT: f64 = 1.0;

/// The model on which actuators act.
#[derive(Clone, Copy)]
pub(super) enum Surroundings<'a> {
    /// The links of a robot.
    Robot(&'a Links<'a>),
    /// A rod, which is the only link of its robot; actuators need not name it.
    Rod(&'a Links<'a>),
    /// Links that are not known yet.
    Unknown,
}

impl<'a> Surroundings<'a> {
    fn links(self) -> Option<&'a Links<'a>> {
        match self {
            Self::Robot(links) | Self::Rod(links) => Some(links),
            Self::Unknown => None,
        }
    }

    fn robot(self) -> Option<&'a Robot> {
        self.links().map(Links::robot)
    }

    fn link(self, name: Option<&str>, place: &str) -> Result<usize, InvalidInput> {
        self.links().map_or(Ok(0), |links| links.index_of(name, place))
    }

    /// Length of a link's rod.
    fn length(self, link: usize) -> f64 {
        let length = self.robot().map_or(UNIT, |robot| robot.links[link].length());
        if length > 0.0 { length } else { UNIT }
    }
}

/// Value of an attribute, unless it is None.
fn given<'py>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    Ok(Some(object.getattr(name)?).filter(|value| !value.is_none()))
}

fn number(object: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    convert::number(&object.getattr(name)?, name)
}

fn text(object: &Bound<'_, PyAny>, name: &str) -> PyResult<String> {
    let value = object.getattr(name)?;
    value.extract().map_err(|_| {
        PyTypeError::new_err(format!("{name}: expected a string, got {}", convert::describe(&value)))
    })
}

fn optional_text(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<String>> {
    given(object, name)?.map(|_| text(object, name)).transpose()
}

/// Adds the place to the message of a refusal. Exceptions of user functions have a traceback; they are
/// unchanged except for a note with the place.
pub(super) fn at_place(py: Python<'_>, place: &str, error: PyErr) -> PyErr {
    if error.traceback(py).is_some() {
        // Some exceptions do not accept notes.
        _ = error.value(py).call_method1("add_note", (format!("in {place}"),));
        return error;
    }
    let kind = error.get_type(py);
    let is_refusal = kind.is(py.get_type::<PyValueError>()) || kind.is(py.get_type::<PyTypeError>());
    if !is_refusal {
        return error;
    }
    let has_place = |problem: &str| problem.split(' ').next().is_some_and(|word| word.ends_with(':'));
    let placed = |problem: &str| match has_place(problem) {
        true => format!("{place}.{problem}"),
        false => format!("{place}: {problem}"),
    };
    let problems: Vec<String> = error.value(py).to_string().lines().map(placed).collect();
    PyErr::from_type(kind, problems.join("\n"))
}

/// A part embedded in a rod.
fn along_of(object: &Bound<'_, PyAny>, surroundings: Surroundings<'_>) -> PyResult<Along> {
    let link = surroundings.link(optional_text(object, "link")?.as_deref(), "link")?;
    let length = surroundings.length(link);
    let given_along = given(object, "along")?;
    let along: [f64; 2] = match &given_along {
        Some(along) => convert::array_of(along, "along")?,
        None => [0.0, length],
    };
    let offset = object.getattr("offset")?;
    let expected = "the pair (y, z) of distances from the rod's axis";
    let wrong =
        || PyTypeError::new_err(format!("offset: expected {expected}, got {}", convert::describe(&offset)));
    let parts: Vec<Bound<'_, PyAny>> =
        offset.try_iter().map_err(|_| wrong())?.collect::<PyResult<_>>().map_err(|_| wrong())?;
    let [y, z] = <[_; 2]>::try_from(parts)
        .map_err(|parts| InvalidInput::new("offset", format_args!("{} of them", parts.len()), expected))?;
    let whole = Stretch { ends: along, length, is_known: surroundings.robot().is_some(), unit: "metres" };
    let offset = [whole.profile(&y, "offset[0]")?, whole.profile(&z, "offset[1]")?];
    Ok(Along { link, offset, along })
}

/// The part of a link's rod along which numbers vary.
struct Stretch {
    /// Arc lengths to which two numbers refer.
    ends: [f64; 2],
    /// Length of the whole rod in metres.
    length: f64,
    /// Whether the length is known.
    is_known: bool,
    /// Unit of the numbers.
    unit: &'static str,
}

impl Stretch {
    /// A number, two numbers at the ends (linear in between), or data for a profile along the whole rod.
    fn profile(&self, value: &Bound<'_, PyAny>, place: &str) -> PyResult<Profile<1>> {
        let Self { ends: [from, to], length, .. } = *self;
        let mut check = Checker::new();
        let is_sequence = value.is_instance_of::<PyTuple>() || value.is_instance_of::<PyList>();
        if is_sequence && value.len()? == 2 && !convert::is_array(&value.get_item(0)?) {
            let numbers: [f64; 2] = convert::array_of(value, place)?;
            check.finite(&numbers, place);
            check.finish()?;
            let [start, end] = numbers;
            if from == 0.0 && to == length {
                return Ok(Profile::linear([[start], [end]]));
            }
            let slope = (end - start) / (to - from);
            if !slope.is_finite() {
                // Problems of the ends are reported with the other parameters.
                return Ok(start.into());
            }
            return Ok(Profile::linear([[start - slope * from], [start + slope * (length - from)]]));
        }
        if !self.is_known && profile::varies(value)? {
            return Ok(0.0.into());
        }
        let numbers: Profile<1> = profile::profile(value, &[], length, place)?;
        match numbers.parts() {
            Parts::Constant(&[number]) => {
                let expected = format!("a finite number ({})", self.unit);
                check.require(number.is_finite(), place, Number(number), &expected);
                check.finish()?;
            }
            // A table with two stations is linear.
            Parts::Table(&[_, end], &[base, tip]) if end == length => {
                return Ok(Profile::linear([base, tip]));
            }
            _ => {}
        }
        Ok(numbers)
    }
}

/// A part of a path.
fn part_of(object: &Bound<'_, PyAny>, surroundings: Surroundings<'_>) -> PyResult<Part> {
    if object.get_type().name()? == "Along" {
        return along_of(object, surroundings).map(Part::Along);
    }
    if object.get_type().name()? != "Via" {
        let found = convert::describe(object);
        return Err(PyTypeError::new_err(format!("expected lissom.Along or lissom.Via, got {found}")));
    }
    let link = match (optional_text(object, "link")?, surroundings) {
        (Some(name), _) => Some(surroundings.link(Some(&name), "link")?),
        (None, Surroundings::Rod(_)) => Some(0),
        (None, Surroundings::Robot(_) | Surroundings::Unknown) => None,
    };
    let at = given(object, "at")?.map(|_| number(object, "at")).transpose()?;
    Ok(Part::Via(Via { link, point: convert::array_of(&object.getattr("point")?, "point")?, at }))
}

fn path_of(object: &Bound<'_, PyAny>, surroundings: Surroundings<'_>) -> PyResult<Vec<Part>> {
    let path = object.getattr("path")?;
    let wrong = || {
        let found = convert::describe(&path);
        PyTypeError::new_err(format!("path: expected a sequence of lissom.Along and lissom.Via, got {found}"))
    };
    let parts = path.try_iter().map_err(|_| wrong())?.enumerate().map(|(i, part)| {
        part_of(&part?, surroundings).map_err(|error| at_place(object.py(), &format!("path[{i}]"), error))
    });
    parts.collect()
}

fn signal(object: &Bound<'_, PyAny>, name: &str, functions: &mut Functions) -> PyResult<Option<Signal<1>>> {
    given(object, name)?.map(|value| signal_of(&value, name, functions)).transpose()
}

/// One of two commands, exactly one of which must be given.
fn one_of<T>(names: [&str; 2], values: [Option<T>; 2]) -> Result<(usize, T), InvalidInput> {
    let [first, second] = names;
    let found = |how: &str, joint: &str| format!("{how} {first} {joint} {second}");
    let expected = "one of them".to_owned();
    match values {
        [Some(value), None] => Ok((0, value)),
        [None, Some(value)] => Ok((1, value)),
        [None, None] => Err(InvalidInput::new(first, found("neither", "nor"), expected)),
        [Some(_), Some(_)] => Err(InvalidInput::new(second, found("both", "and"), expected)),
    }
}

/// Converts an object of one of the classes to an actuator.
fn actuator_of(
    object: &Bound<'_, PyAny>,
    surroundings: Surroundings<'_>,
    functions: &mut Functions,
) -> PyResult<Actuator> {
    let mut check = Checker::new();
    let kind = object.get_type().name()?.to_string();
    Ok(match kind.as_str() {
        "Tendon" => {
            let path = path_of(object, surroundings)?;
            let commands = [signal(object, "tension", functions)?, signal(object, "length", functions)?];
            let stiffness = given(object, "stiffness")?.map(|_| number(object, "stiffness")).transpose()?;
            let damping = number(object, "damping")?;
            let (which, command) = one_of(["tension", "length"], commands)?;
            if which == 0 {
                let expected = "none: it belongs to a tendon of a given length";
                let found = Number(stiffness.unwrap_or_default());
                check.require(stiffness.is_none(), "stiffness", found, expected);
                check.require(damping == 0.0, "damping", Number(damping), expected);
            }
            check.finish()?;
            Actuator::Tendon(Tendon {
                name: text(object, "name")?,
                path,
                drive: match which {
                    0 => Drive::Tension(command),
                    _ => Drive::Length { length: command, stiffness, damping },
                },
                friction: number(object, "friction")?,
                friction_velocity: number(object, "friction_velocity")?,
                sliding: signal(object, "sliding", functions)?,
            })
        }
        "Chamber" => {
            let mut path = Vec::new();
            for (i, part) in path_of(object, surroundings)?.into_iter().enumerate() {
                match part {
                    Part::Along(along) => path.push(along),
                    Part::Via(_) => {
                        let expected = "lissom.Along: a chamber is embedded in rods";
                        check.require(false, &format!("path[{i}]"), "a Via", expected);
                    }
                }
            }
            check.finish()?;
            Actuator::Chamber(Chamber {
                name: text(object, "name")?,
                path,
                area: number(object, "area")?,
                pressure: signal(object, "pressure", functions)?.unwrap_or_default(),
            })
        }
        "Motor" => motor_of(object, surroundings, functions, check)?,
        "ActiveStrain" => {
            let link = surroundings.link(optional_text(object, "link")?.as_deref(), "link")?;
            let strain = text(object, "strain")?;
            let place = STRAIN_NAMES.iter().position(|known| *known == strain);
            let meant = suggestion(&strain, STRAIN_NAMES.iter().copied());
            let meant = meant.map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
            let expected = format!("one of {}{meant}", STRAIN_NAMES.join(", "));
            check.require(place.is_some(), "strain", format_args!("'{strain}'"), &expected);
            check.finish()?;
            let shape = object.getattr("shape")?;
            let length = surroundings.length(link);
            let whole = Stretch {
                ends: [0.0, length],
                length,
                is_known: surroundings.robot().is_some(),
                unit: "the strain for an amount of one",
            };
            Actuator::ActiveStrain(ActiveStrain {
                name: text(object, "name")?,
                link,
                strain: place.expect("it is known"),
                shape: whole.profile(&shape, "shape")?,
                amount: signal(object, "amount", functions)?.unwrap_or_default(),
            })
        }
        _ => {
            let found = convert::describe(object);
            return Err(PyTypeError::new_err(format!("expected {EXPECTED}, got {found}")));
        }
    })
}

fn motor_of(
    object: &Bound<'_, PyAny>,
    surroundings: Surroundings<'_>,
    functions: &mut Functions,
    mut check: Checker,
) -> PyResult<Actuator> {
    let joint = text(object, "joint")?;
    let commands = [signal(object, "torque", functions)?, signal(object, "position", functions)?];
    let (which, command) = one_of(["torque", "position"], commands)?;
    let gains = given(object, "gains")?;
    let found = gains.as_ref().map_or_else(|| "none".to_owned(), |gains| gains.to_string());
    let expected = match which {
        1 => "the pair (stiffness, damping) of a motor that holds a position",
        _ => "none: it belongs to a motor of a given position",
    };
    check.require(gains.is_some() == (which == 1), "gains", found, expected);
    check.finish()?;
    let gains: Option<[f64; 2]> = gains.map(|gains| convert::array_of(&gains, "gains")).transpose()?;
    let (link, coordinate) = match surroundings.robot() {
        Some(robot) => coordinate_of(robot, &joint)?,
        None => (0, 0),
    };
    let limits = given(object, "limits")?.map(|limits| convert::array_of(&limits, "limits")).transpose()?;
    Ok(Actuator::Motor(Motor {
        name: optional_text(object, "name")?.unwrap_or(joint),
        link,
        coordinate,
        command: match (which, gains) {
            (1, Some([stiffness, damping])) => {
                MotorCommand::Position { position: command, stiffness, damping }
            }
            _ => MotorCommand::Torque(command),
        },
        limits,
    }))
}

/// The link and the joint coordinate that a motor moves.
fn coordinate_of(robot: &Robot, name: &str) -> Result<(usize, usize), InvalidInput> {
    robot.motor_coordinate(name).ok_or_else(|| {
        let (known, places) = (robot.motor_coordinates(), robot.motor_places());
        let meant = suggestion(name, places.iter().map(String::as_str));
        let meant = meant.map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
        let expected = match known.is_empty() {
            true => "a coordinate of a joint, but no link has one that a motor can move".to_owned(),
            false => format!("a link with a joint of one coordinate, or one of {}{meant}", known.join(", ")),
        };
        InvalidInput::new("joint", format_args!("'{name}'"), expected)
    })
}

/// Rejects an actuator that is invalid on its own; the robot checks whether it fits.
#[pyfunction]
pub(crate) fn check_actuator(object: &Bound<'_, PyAny>) -> PyResult<()> {
    let actuator = actuator_of(object, Surroundings::Unknown, &mut Functions::default())?;
    Ok(actuator.validate()?)
}

/// Rejects a part of a path that is invalid on its own.
#[pyfunction]
pub(crate) fn check_path(object: &Bound<'_, PyAny>) -> PyResult<()> {
    Ok(part_of(object, Surroundings::Unknown)?.validate()?)
}

/// The actuators of a sequence.
pub(super) fn actuators_of(
    actuators: &Bound<'_, PyAny>,
    surroundings: Surroundings<'_>,
    functions: &mut Functions,
) -> PyResult<Vec<Actuator>> {
    let wrong = || {
        let found = convert::describe(actuators);
        PyTypeError::new_err(format!("actuators: expected a sequence of {EXPECTED}, got {found}"))
    };
    let (mut found, mut has_default) = (Vec::new(), Vec::new());
    for (i, object) in actuators.try_iter().map_err(|_| wrong())?.enumerate() {
        let object = object?;
        let actuator = actuator_of(&object, surroundings, functions);
        let actuator = actuator.map_err(|error| at_place(object.py(), &format!("actuators[{i}]"), error))?;
        has_default.push(has_default_name(&object, actuator.name())?);
        found.push(actuator);
    }
    number_default_names(found.iter_mut().map(Actuator::name_mut).zip(has_default));
    Ok(found)
}

/// Index of an actuator of a robot.
pub(super) fn actuator_index(robot: &Robot, name: &str) -> Result<usize, InvalidInput> {
    let names = || robot.actuators.iter().map(Actuator::name);
    names().position(|known| known == name).ok_or_else(|| {
        let all = names().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        let meant = suggestion(name, names());
        let meant = meant.map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
        let expected = match all.is_empty() {
            true => "an actuator, but the robot has none".to_owned(),
            false => format!("one of the actuators: {all}{meant}"),
        };
        InvalidInput::new("name", format_args!("'{name}'"), expected)
    })
}

/// The Python objects of the actuators of a robot.
pub(super) fn actuators_out<'py>(py: Python<'py>, robot: &Robot) -> PyResult<Bound<'py, PyTuple>> {
    let out = |actuator: &Actuator| -> PyResult<Bound<'py, PyAny>> {
        let lissom = py.import("lissom")?;
        let arguments = PyDict::new(py);
        match actuator {
            Actuator::Tendon(tendon) => {
                let parts = tendon.path.iter().map(|part| part_out(py, robot, part));
                let path = PyTuple::new(py, parts.collect::<PyResult<Vec<_>>>()?)?;
                match &tendon.drive {
                    Drive::Tension(tension) => arguments.set_item("tension", signal_out(py, tension)?)?,
                    Drive::Length { length, stiffness, damping } => {
                        arguments.set_item("length", signal_out(py, length)?)?;
                        arguments.set_item("stiffness", stiffness)?;
                        arguments.set_item("damping", damping)?;
                    }
                }
                arguments.set_item("friction", tendon.friction)?;
                arguments.set_item("friction_velocity", tendon.friction_velocity)?;
                let sliding = tendon.sliding.as_ref().map(|signal| signal_out(py, signal)).transpose()?;
                arguments.set_item("sliding", sliding)?;
                lissom.getattr("Tendon")?.call((&tendon.name, path), Some(&arguments))
            }
            Actuator::Chamber(chamber) => {
                let parts = chamber.path.iter().map(|along| along_out(py, robot, along));
                let path = PyTuple::new(py, parts.collect::<PyResult<Vec<_>>>()?)?;
                arguments.set_item("pressure", signal_out(py, &chamber.pressure)?)?;
                lissom.getattr("Chamber")?.call((&chamber.name, path, chamber.area), Some(&arguments))
            }
            Actuator::Motor(motor) => {
                let link = &robot.links[motor.link];
                let coordinate = link.joint.coordinates()[motor.coordinate];
                match &motor.command {
                    MotorCommand::Torque(torque) => arguments.set_item("torque", signal_out(py, torque)?)?,
                    MotorCommand::Position { position, stiffness, damping } => {
                        arguments.set_item("position", signal_out(py, position)?)?;
                        arguments.set_item("gains", (stiffness, damping))?;
                    }
                }
                arguments.set_item("limits", motor.limits.map(<(f64, f64)>::from))?;
                arguments.set_item("name", &motor.name)?;
                let joint = format!("{}.{coordinate}", link.name);
                lissom.getattr("Motor")?.call((joint,), Some(&arguments))
            }
            Actuator::ActiveStrain(active) => {
                let link = &robot.links[active.link];
                let strain = STRAIN_NAMES[active.strain];
                let shape = profile_out(py, &active.shape, link.length(), true)?;
                arguments.set_item("amount", signal_out(py, &active.amount)?)?;
                arguments.set_item("name", &active.name)?;
                lissom.getattr("ActiveStrain")?.call((&link.name, strain, shape), Some(&arguments))
            }
        }
    };
    PyTuple::new(py, robot.actuators.iter().map(out).collect::<PyResult<Vec<_>>>()?)
}

/// Data that are read back as the same profile, bit for bit: a number; two numbers for a linear profile if
/// these refer to base and tip (`is_whole`), otherwise a table with two stations; or a `lissom.Profile`. The
/// length is omitted where possible, so that the data also fit rods of other lengths.
fn profile_out<'py>(
    py: Python<'py>,
    values: &Profile<1>,
    length: f64,
    is_whole: bool,
) -> PyResult<Bound<'py, PyAny>> {
    use pyo3::IntoPyObjectExt;
    match values.parts() {
        Parts::Constant(&[number]) => number.into_bound_py_any(py),
        Parts::Linear(&[[base], [tip]]) if is_whole => (base, tip).into_bound_py_any(py),
        Parts::Linear(&[[base], [tip]]) => ((0.0, length), (base, tip)).into_bound_py_any(py),
        Parts::Table(..) | Parts::Polynomial(_) => {
            profile::to_python(values, &[], length).into_bound_py_any(py)
        }
    }
}

fn along_out<'py>(py: Python<'py>, robot: &Robot, along: &Along) -> PyResult<Bound<'py, PyAny>> {
    let link = &robot.links[along.link];
    let [y, z] = &along.offset;
    let length = link.length();
    let is_whole = along.along == [0.0, length];
    let offset = (profile_out(py, y, length, is_whole)?, profile_out(py, z, length, is_whole)?);
    // A part along the whole rod, for any length: the length may be swept, fitted or differentiated.
    let ends = (!is_whole).then_some(<(f64, f64)>::from(along.along));
    py.import("lissom")?.getattr("Along")?.call1((&link.name, offset, ends))
}

fn part_out<'py>(py: Python<'py>, robot: &Robot, part: &Part) -> PyResult<Bound<'py, PyAny>> {
    match part {
        Part::Along(along) => along_out(py, robot, along),
        Part::Via(via) => {
            let link = via.link.map(|link| &robot.links[link].name);
            let point = <(f64, f64, f64)>::from(via.point);
            py.import("lissom")?.getattr("Via")?.call1((link, point, via.at))
        }
    }
}
