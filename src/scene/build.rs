//! Builds a scene from a document. The constructors of the crate check the physics, and their messages are
//! mapped to lines of the file.

use crate::error::{Checker, InvalidInput, Number};
use crate::model::pendulum::SpringPendulum;
use crate::model::{ContactText, Dynamics as _, InContact as _, InTime as _, InvalidShape};
use crate::robot;
use crate::simulation::accuracy;
use crate::simulation::stepping::check_step;

use super::document::{Document, General, Output, Simulation as Settings};
use super::imports::Imported;
use super::links;
use super::lists::{self, Keys};
use super::parts::{self, open_modes};
use super::shape::{Shape, report};
use super::{END_OF_OUTPUT, Method, Model, Quantity, Simulation};

/// Largest result that a scene may request; more would not fit in the memory of an ordinary machine.
const MAX_RESULT_BYTES: f64 = (1u64 << 30) as f64;

/// Maximum number of steps of a run: at a microsecond each they take hours.
const MAX_STEPS: f64 = 1e10;

/// Numbers per state in addition to q, v and a: time and the energy balance.
const NUMBERS_PER_STATE: usize = 7;

/// The model, its initial coordinates and velocities, and the settings. Problems are added to `shape`; the
/// parts are valid only without problems.
pub(super) fn build(
    document: &Document,
    imported: Option<&Imported>,
    shape: &mut Shape,
) -> Option<(Model, [Vec<f64>; 2], Simulation)> {
    let model = model(document, imported, shape);
    check_open_modes(document, shape);
    let n = model.as_ref().map_or(0, |(model, _)| model.coordinates());
    let simulation = simulation(&document.simulation, n, shape);
    let (model, state) = model?;
    let shortest_period = model.shortest_period();
    if simulation.method.has_fixed_step() {
        let checked = check_step(simulation.dt, shortest_period);
        report(checked, shape, |_| "simulation.dt".to_owned());
    }
    if shape.problems.is_empty() {
        // Compiling a robot finds joints that move nothing with inertia.
        let (compiled, q0) = match &model {
            Model::Rod(rod) => (Some(robot::RobotModel::of_rod(rod)), "rod[0].q0"),
            Model::Robot(robot) => (Some(robot::RobotModel::new(robot)), "link"),
            Model::Pendulum(_) => (None, ""),
        };
        match compiled {
            Some(Ok(mut compiled)) => {
                report(compiled.check_shape(&state[0], "q0"), shape, |_| q0.to_owned());
                check_contacts(document, &mut compiled, &state[0], simulation.t0, shape);
            }
            Some(Err(error)) => {
                let before = imported.map_or(0, |imported| imported.links.len());
                report(Err::<(), _>(error), shape, |place| links::key_of_link(place, before));
            }
            None => {}
        }
    }
    if shortest_period.is_finite() {
        let oscillations = simulation.duration() / shortest_period;
        if oscillations > MAX_STEPS && shape.is_readable("simulation.t_end") {
            let wrong = format!("{} oscillations of a load or of the base", count(oscillations));
            let right = format!("expected at most {MAX_STEPS:e}: an earlier t_end, or a lower frequency");
            shape.refuse("simulation.t_end", wrong, right);
        }
    }
    Some((model, state, simulation))
}

/// Rejects a start whose surfaces overlap deeply. With closed loops the start is projected first.
fn check_contacts(
    document: &Document,
    model: &mut robot::RobotModel,
    q0: &[f64],
    t0: f64,
    shape: &mut Shape,
) {
    if document.contact.is_empty() || !document.r#loop.is_empty() || !shape.problems.is_empty() {
        return;
    }
    if model.set_time(t0).is_err() || q0.len() != model.facts().n {
        return;
    }
    if let Some(InvalidShape::DeepPenetration { contact, overlap }) = model.deep_penetration(q0) {
        let wrong = format!("its surfaces overlap by {overlap:.3} m at the start");
        let advice = model.text_of_contact(contact, ContactText::AdviceOnDeepOverlap);
        let end = if advice.is_empty() { "" } else { "." };
        let right = format!("expected a start in which they overlap by less than a radius{end}{advice}");
        shape.refuse(&format!("contact[{contact}]"), wrong, &right);
    }
}

fn check_open_modes(document: &Document, shape: &mut Shape) {
    let segments = parts::segments(document);
    for i in open_modes(document) {
        let place = format!("{}.modes", segments[i].0);
        if document.simulation.method != Method::Auto && shape.is_readable("simulation") {
            let right = "give simulation.method = \"auto\", to whose rtol the modes are chosen; or the modes";
            shape.refuse(&place, "\"auto\", but the method is another", right);
        }
        let owner = place.split('.').next().unwrap_or_default().to_owned();
        let given = document.rod.iter().map(|rod| (&rod.q0, &rod.v0)).chain(
            document
                .link
                .iter()
                .filter(|_| document.rod.is_empty())
                .map(|link| (&link.below.q0, &link.below.v0)),
        );
        let of_owner = owner.split(['[', ']']).nth(1).and_then(|i| i.parse::<usize>().ok());
        if let Some((q0, v0)) = of_owner.and_then(|i| given.into_iter().nth(i)) {
            for (key, values) in [("q0", q0), ("v0", v0)] {
                if values.is_some() {
                    let right =
                        "give the modes as well, one value belongs to each; or start at rest without it";
                    shape.refuse(&format!("{owner}.{key}"), "given, but the modes are \"auto\"", right);
                }
            }
        }
    }
}

fn model(
    document: &Document,
    imported: Option<&Imported>,
    shape: &mut Shape,
) -> Option<(Model, [Vec<f64>; 2])> {
    let is_robot = !document.link.is_empty() || document.import.is_some();
    if !is_robot {
        let of_robots =
            [("base_motion", document.base_motion.is_some()), ("fluid", document.fluid.is_some())];
        for (key, _) in of_robots.into_iter().filter(|(_, is_given)| *is_given) {
            let right = format!("write rod.{key} in its [[rod]], or the links of a robot as [[link]]");
            shape.refuse(key, "it belongs to a robot, and there is no [[link]]", right);
        }
        if !document.r#loop.is_empty() {
            let right =
                "write the links of a robot as [[link]]: a rod is a [[link]] with [[link.rod.segment]]";
            shape.refuse("loop", "it ties links of a robot, and there is no [[link]]", right);
        }
    }
    match (document.rod.as_slice(), &document.pendulum) {
        ([], None) if is_robot => {
            let (robot, state) = links::robot(document, imported, shape)?;
            Some((Model::Robot(robot), state))
        }
        ([], None) => {
            if ["rod", "link", "pendulum"].iter().all(|key| shape.is_readable(key)) {
                shape.refuse(
                    "",
                    "nothing to simulate",
                    "add a [[rod]] with its [[rod.segment]], the [[link]] of a robot, or a [pendulum]",
                );
            }
            None
        }
        ([], Some(_)) => {
            if document.import.is_some() {
                let right = "keep one of them";
                shape.refuse("import", "a pendulum and the links of a robot in one scene", right);
            }
            let of_robots = [
                ("tendon", document.tendon.is_empty()),
                ("chamber", document.chamber.is_empty()),
                ("motor", document.motor.is_empty()),
                ("active_strain", document.active_strain.is_empty()),
            ];
            for (key, _) in of_robots.into_iter().filter(|(_, is_absent)| !is_absent) {
                shape.refuse(key, "a pendulum has no actuators", "remove it, or simulate a rod or a robot");
            }
            if !document.contact.is_empty() {
                shape.refuse(
                    "contact",
                    "a pendulum touches nothing",
                    "remove it, or simulate a rod or a robot",
                );
            }
            pendulum(document, shape)
        }
        (rods, pendulum) => {
            if pendulum.is_some() {
                shape.refuse("pendulum", "a rod and a pendulum in one scene", "keep one of them");
            }
            if is_robot {
                let right = "keep one of them; a rod can be a link of the robot";
                let key = if document.link.is_empty() { "import" } else { "link" };
                shape.refuse(key, "a rod and the links of a robot in one scene", right);
            }
            for i in 1..rods.len() {
                shape.refuse(
                    &format!("rod[{i}]"),
                    format!("{} rods in one scene", rods.len()),
                    "this version simulates one rod a scene; pieces in a row are its [[rod.segment]]",
                );
            }
            rod(document, shape)
        }
    }
}

fn rod(document: &Document, shape: &mut Shape) -> Option<(Model, [Vec<f64>; 2])> {
    let written = &document.rod[0];
    let mut keys = Keys::default();
    let described = lists::rod(document, &mut keys, shape);
    let key = |place: &str| keys.of(place).unwrap_or_else(|| rod_place(place));
    let (rod, places) = lists::resolved(shape, key, |reader| described.resolved(reader));
    let key = |place: &str| keys.of_model(place, &places).unwrap_or_else(|| key(place));
    let valid = report(rod.validate(), shape, key).is_some();
    let n = (valid && shape.is_readable("rod[0].segment")).then(|| rod.coordinates());
    if n == Some(0) {
        shape.refuse(
            "rod[0].segment",
            "no modes, so nothing can move",
            "give at least one, such as modes = { bend_y = 3 }",
        );
    }
    let state = [("q0", &written.q0), ("v0", &written.v0)].map(|(key, values)| {
        let values = values.clone().unwrap_or_else(|| vec![0.0; n.unwrap_or(0)]);
        let mut check = Checker::new();
        if let Some(n) = n
            && open_modes(document).is_empty()
        {
            let wanted = format!("{n} values, one for each mode of the rod");
            check.require(values.len() == n, key, format_args!("{} values", values.len()), &wanted);
        }
        check.finite(&values, key);
        report(check.finish(), shape, |place| format!("rod[0].{place}"));
        values
    });
    n.map(|_| (Model::Rod(rod), state))
}

/// Key in the file for a place in a [`robot::Rod`].
fn rod_place(place: &str) -> String {
    if General::has(place) {
        return format!("scene.{place}");
    }
    let key = place.replace("segments", "segment").replace("base_position", "base.position");
    format!("rod[0].{}", key.replace("base_orientation", "base.orientation"))
}

fn pendulum(document: &Document, shape: &mut Shape) -> Option<(Model, [Vec<f64>; 2])> {
    let written = document.pendulum.as_ref()?;
    for (key, wrong, right) in document.scene.unknown_to_pendulums() {
        shape.refuse(&format!("scene.{key}"), wrong, right);
    }
    let state = [written.q0, written.v0].map(Option::unwrap_or_default);
    let mut check = Checker::new();
    check.finite(&state[0], "q0");
    check.finite(&state[1], "v0");
    report(check.finish(), shape, |place| format!("pendulum.{place}"));
    let default = SpringPendulum::default();
    let pendulum = SpringPendulum::new(
        written.length.unwrap_or(default.length()),
        written.mass.unwrap_or(default.mass()),
        written.stiffness.unwrap_or(default.stiffness()),
        written.gravity.unwrap_or(default.gravity()),
    );
    let pendulum = report(pendulum, shape, |place| format!("pendulum.{place}"))?;
    Some((Model::Pendulum(pendulum), state.map(Vec::from)))
}

fn simulation(written: &Settings, n: usize, shape: &mut Shape) -> Simulation {
    let default = Simulation::until(written.t_end);
    let is_auto = written.method == Method::Auto;
    if is_auto && written.atol.is_some() {
        let right = "give rtol alone, the largest error of the tip relative to the length";
        shape.refuse("simulation.atol", "method \"auto\" does not take it", right);
    }
    if let Some(rtol) = written.rtol
        && is_auto
    {
        let checked = accuracy::Request::new(rtol, default.dt).validate();
        report(checked, shape, |_| "simulation.rtol".to_owned());
    }
    let default_rtol = if is_auto { accuracy::DEFAULT_RTOL } else { default.rtol };
    let simulation = Simulation {
        t0: written.t0,
        method: written.method,
        dt: written.dt.unwrap_or(default.dt),
        jac: written.jac,
        rtol: written.rtol.unwrap_or(default_rtol),
        atol: written.atol,
        output_dt: written.output.dt,
        quantities: quantities(&written.output),
        ..default
    };
    report(simulation.validate(), shape, |place| format!("simulation.{place}"));
    let readable = ["simulation.t0", "simulation.t_end", "simulation.dt", "simulation.output"];
    if readable.iter().all(|place| shape.is_readable(place)) {
        report(simulation.check_size(n), shape, |place| format!("simulation.{place}"));
    }
    simulation
}

fn quantities(output: &Output) -> Vec<Quantity> {
    const ALL: [Quantity; 4] =
        [Quantity::Velocity, Quantity::Acceleration, Quantity::Energy, Quantity::Shape];
    let mut kept = ALL.to_vec();
    if let Some(wanted) = &output.quantities {
        kept.retain(|quantity| wanted.contains(quantity));
    }
    kept
}

impl Simulation {
    /// Reports every problem of the settings, independent of the model.
    fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        let starts = check.require(self.t0.is_finite(), "t0", Number(self.t0), "a finite number (seconds)");
        let expected = format!("a finite number > t0 = {} (seconds)", Number(self.t0));
        let is_later = self.duration() > 0.0 && self.duration().is_finite();
        let runs = starts && check.require(is_later, "t_end", Number(self.t_end), &expected);
        check.positive(self.dt, "dt", "seconds");
        check.non_negative(self.rtol, "rtol", "relative");
        if let Some(atol) = self.atol {
            check.non_negative(atol, "atol", "absolute");
        }
        check.require(
            self.rtol > 0.0 || self.atol != Some(0.0),
            "rtol",
            "both rtol and atol zero",
            "one of them > 0",
        );
        if let Some(dt) = self.output_dt
            && check.positive(dt, "output.dt", "seconds")
            && runs
        {
            let expected = format!("at most the simulated time, {} s", Number(self.duration()));
            // The duration is a rounded difference.
            let is_within = dt * (1.0 - END_OF_OUTPUT) <= self.duration();
            check.require(is_within, "output.dt", Number(dt), &expected);
        }
        check.finish()
    }

    /// Rejects a run of a model with `n` coordinates that would take too long or not fit in memory. Ignores
    /// times that [`Self::validate`] rejects.
    fn check_size(&self, n: usize) -> Result<(), InvalidInput> {
        let (kept_every, place) = match self.output_dt {
            Some(dt) => (dt, "output.dt"),
            None => (self.dt, "dt"),
        };
        let duration = self.duration();
        let mut check = Checker::new();
        if ![duration, self.dt, kept_every].iter().all(|time| time.is_finite() && *time > 0.0) {
            return check.finish();
        }
        // The quotients may be infinite, which counts as too many.
        let steps = duration / self.dt;
        if self.method.has_fixed_step() {
            let least = duration / MAX_STEPS;
            let found = format!("{} steps", count(steps));
            let expected = format!("at most {MAX_STEPS:e} of them: a dt of at least {least:.2e}");
            check.require(steps <= MAX_STEPS, "dt", found, &expected);
        }
        let bytes_per_state = (8 * (3 * n + NUMBERS_PER_STATE)) as f64;
        let states = duration / kept_every;
        if check.is_ok() {
            let least = duration * (bytes_per_state / MAX_RESULT_BYTES);
            let found = format!("{} states of {bytes_per_state} bytes to keep", count(states));
            let expected = format!("at most 1 GiB: an output.dt of at least {least:.2e}");
            check.require(states <= MAX_RESULT_BYTES / bytes_per_state, place, found, &expected);
        }
        check.finish()
    }
}

/// Formats a large number, including infinity.
fn count(number: f64) -> String {
    if number.is_finite() { format!("{number:.2e}") } else { format!("more than {:.2e}", f64::MAX) }
}
