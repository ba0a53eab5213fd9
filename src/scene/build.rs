//! From a document to a scene: the physics is checked by the constructors that everybody uses, and their
//! complaints are carried back to the lines of the file.

use std::sync::Arc;

use crate::accuracy;
use crate::body;
use crate::error::{Checker, InvalidInput, Number};
use crate::load;
use crate::model::Discretised as _;
use crate::pendulum::SpringPendulum;
use crate::robot;
use crate::rod;
use crate::signal::{Harmonic, Signal, Table, covers};
use crate::simulate::check_step;
use crate::support;
use crate::world;

use super::document::{
    BaseMotion, Basis, Body, Document, Fluid, Frame, Load, ModeChoice, Orientations, Output, ReferenceStrain,
    Segment, Simulation as Settings, StrainTable, Support, VaryingNumber, VaryingVector, Vector,
};
use super::section;
use super::shape::Shape;
use super::{END_OF_OUTPUT, Method, Model, Quantity, Simulation};

/// Largest result that a scene may ask for; more would not fit in the memory of an ordinary machine.
const MAX_RESULT_BYTES: f64 = (1u64 << 30) as f64;

/// Most steps of a run: at a microsecond each they take hours.
const MAX_STEPS: f64 = 1e10;

/// Numbers that a result keeps per state beside q, v and a: time and the energy balance.
const NUMBERS_PER_STATE: usize = 7;

/// The model, its initial coordinates and velocities, and the settings. Problems are noted in `shape`; the parts
/// are meaningful only if there are none.
pub(super) fn build(document: &Document, shape: &mut Shape) -> Option<(Model, [Vec<f64>; 2], Simulation)> {
    let model = model(document, shape);
    check_open_modes(document, shape);
    let n = model.as_ref().map_or(0, |(model, _)| model.coordinates());
    let simulation = simulation(&document.simulation, n, shape);
    let (model, state) = model?;
    if let Model::Rod(rod) = &model
        && simulation.method.has_fixed_step()
    {
        let checked = check_step(simulation.dt, rod.shortest_period());
        report(checked, shape, |_| "simulation.dt".to_owned());
    }
    if let Model::Rod(rod) = &model
        && shape.problems.is_empty()
        && let Ok(compiled) = robot::RobotModel::of_rod(rod)
    {
        let checked = compiled.check_shape(&state[0], "q0");
        report(checked, shape, |place| format!("rod[0].{place}"));
    }
    if let Model::Rod(rod) = &model {
        let oscillations = simulation.duration() / rod.shortest_period();
        if oscillations > MAX_STEPS && shape.is_readable("simulation.t_end") {
            let wrong = format!("{} oscillations of a load or of the base", count(oscillations));
            let right = format!("expected at most {MAX_STEPS:e}: an earlier t_end, or a lower frequency");
            shape.refuse("simulation.t_end", wrong, right);
        }
    }
    Some((model, state, simulation))
}

/// Segments of the rod whose modes the scene leaves open.
pub(super) fn open_modes(document: &Document) -> Vec<usize> {
    let segments = document.rod.first().map_or(&[][..], |rod| &rod.segment);
    let is_open = |segment: &Segment| matches!(segment.modes, ModeChoice::Open(_));
    (0..segments.len()).filter(|&i| is_open(&segments[i])).collect()
}

fn check_open_modes(document: &Document, shape: &mut Shape) {
    for i in open_modes(document) {
        let place = format!("rod[0].segment[{i}].modes");
        if document.simulation.method != Method::Auto && shape.is_readable("simulation") {
            let right = "give simulation.method = \"auto\", to whose rtol the modes are chosen; or the modes";
            shape.refuse(&place, "\"auto\", but the method is another", right);
        }
        for (key, values) in [("q0", &document.rod[0].q0), ("v0", &document.rod[0].v0)] {
            if values.is_some() {
                let right = "give the modes as well, one value belongs to each; or start at rest without it";
                shape.refuse(&format!("rod[0].{key}"), "given, but the modes are \"auto\"", right);
            }
        }
    }
}

/// Where the modes are open, the model has these until they are chosen.
const UNTIL_CHOSEN: [usize; 6] = [0, 1, 1, 0, 0, 0];

fn model(document: &Document, shape: &mut Shape) -> Option<(Model, [Vec<f64>; 2])> {
    match (document.rod.as_slice(), &document.pendulum) {
        ([], None) => {
            if shape.is_readable("rod") && shape.is_readable("pendulum") {
                shape.refuse(
                    "",
                    "nothing to simulate",
                    "add a [[rod]] with its [[rod.segment]], or a [pendulum]",
                );
            }
            None
        }
        ([], Some(_)) => pendulum(document, shape),
        (rods, pendulum) => {
            if pendulum.is_some() {
                shape.refuse("pendulum", "a rod and a pendulum in one scene", "keep one of them");
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
    let segments: Vec<_> =
        written.segment.iter().enumerate().map(|(i, segment)| rod_segment(segment, i, shape)).collect();
    let moving = written.base_motion.as_ref();
    let rod = robot::Rod {
        base_motion: moving.map(|written| base_motion(written, &document.simulation, shape)),
        base_position: written.base.position,
        base_orientation: written.base.orientation,
        tip_force: written.tip_force,
        tip_moment: written.tip_moment,
        tip_mass: written.tip_mass,
        loads: written.load.iter().enumerate().map(|(i, load)| rod_load(load, i, shape)).collect(),
        bodies: written.body.iter().map(rod_body).collect(),
        supports: written.support.iter().map(rod_support).collect(),
        fluid: written.fluid.as_ref().map(rod_fluid),
        ..robot::Rod::new(segments)
    };
    let rod = robot::Rod { gravity: document.scene.gravity.unwrap_or(rod.gravity), ..rod };
    let valid = report(rod.validate(), shape, |place| rod_place(place, &written.segment)).is_some();
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

fn rod_segment(written: &Segment, i: usize, shape: &mut Shape) -> rod::Segment {
    let here = format!("rod[0].segment[{i}]");
    let section = section::section(written, &here, shape);
    let plain = match section {
        rod::Section::Given(section) => {
            section::refuse_material(written, &here, shape);
            rod::Segment::given(written.length, *section)
        }
        section => {
            let [young_modulus, shear_modulus, density] = material(written, &here, shape);
            let plain = rod::Segment::straight(written.length, 0.0, young_modulus, shear_modulus, density);
            rod::Segment { section, shear_correction: section::shear_correction(written), ..plain }
        }
    };
    let key = format!("{here}.reference_strain");
    let reference_strain = match &written.reference_strain {
        None => None,
        Some(ReferenceStrain::Constant(strain)) => Some((*strain).into()),
        Some(ReferenceStrain::Table(_)) if !shape.is_readable(&key) => None,
        Some(ReferenceStrain::Table(StrainTable { stations, values })) => {
            report(rod::Profile::table(stations, values), shape, |place| format!("{key}.{place}"))
        }
    };
    rod::Segment {
        basis: basis(written.basis),
        modes: match written.modes {
            ModeChoice::Open(_) => UNTIL_CHOSEN,
            ModeChoice::Given(modes) => modes.counts(),
        },
        retardation_time: written.retardation_time,
        reference_strain: reference_strain.unwrap_or(plain.reference_strain),
        nodes: written.nodes,
        ..plain
    }
}

/// Young's modulus, shear modulus and density. Where one is unknown, a value that fits the others avoids a problem
/// that the user doesn't have.
fn material(written: &Segment, here: &str, shape: &mut Shape) -> [f64; 3] {
    const STAND_IN: f64 = 1.0;
    let place = |key: &str| format!("{here}.{key}");
    let [young, shear, poisson, density] =
        ["young_modulus", "shear_modulus", "poisson_ratio", "density"].map(place);
    for (value, key, what) in [
        (written.young_modulus, &young, "young_modulus: Young's modulus E in pascals"),
        (written.density, &density, "density: Density in kg/m^3"),
    ] {
        if value.is_none() && shape.is_readable(key) {
            shape.refuse(key, "missing", format!("add {what}"));
            shape.replaced.insert(key.clone());
        }
    }
    let modulus = written.young_modulus.or(written.shear_modulus).unwrap_or(STAND_IN);
    let shear_modulus = match (written.shear_modulus, written.poisson_ratio) {
        (Some(_), Some(_)) => {
            shape.refuse(&poisson, "both poisson_ratio and shear_modulus are given", "keep one of them");
            modulus
        }
        (Some(modulus), None) => modulus,
        (None, Some(ratio)) => {
            report(rod::shear_modulus(modulus, ratio), shape, |_| poisson.clone()).unwrap_or(modulus)
        }
        (None, None) => {
            if shape.is_readable(&shear) && shape.is_readable(&poisson) {
                shape.refuse(here, "neither shear_modulus nor poisson_ratio", "add one of them");
            }
            modulus
        }
    };
    [written.young_modulus.unwrap_or(shear_modulus), shear_modulus, written.density.unwrap_or(STAND_IN)]
}

fn basis(written: Basis) -> rod::Basis {
    match written {
        Basis::Legendre => rod::Basis::Legendre,
        Basis::Chebyshev => rod::Basis::Chebyshev,
        Basis::Monomial => rod::Basis::Monomial,
        Basis::PiecewiseConstant => rod::Basis::PiecewiseConstant,
        Basis::Hermite => rod::Basis::Hermite,
    }
}

fn rod_load(written: &Load, i: usize, shape: &mut Shape) -> load::Load {
    let &Load { ref force, ref moment, at, along, frame } = written;
    let place = format!("rod[0].load[{i}]");
    if at.is_some() && along.is_some() {
        shape.refuse(&format!("{place}.along"), "both at and along are given", "keep one of them");
    }
    let [force, moment] = [("force", force), ("moment", moment)]
        .map(|(key, written)| vector(written, &format!("{place}.{key}"), shape));
    if force.is_zero() && moment.is_zero() && shape.is_readable(&place) {
        shape.refuse(&place, "neither force nor moment", "add one of them");
    }
    let extent = match (at, along) {
        (Some(x), _) => load::Extent::At(x),
        (None, Some(ends)) => load::Extent::Along(ends),
        (None, None) => load::Extent::Tip,
    };
    let frame = match frame {
        Frame::World => load::Frame::World,
        Frame::Body => load::Frame::Body,
    };
    load::Load { link: 0, extent, frame, force, moment }
}

/// A vector as it is written at `place`.
fn vector(written: &Vector, place: &str, shape: &mut Shape) -> Signal<3> {
    match written {
        Vector::Constant(value) => Signal::Constant(*value),
        Vector::Varying(written) => varying_vector(written, place, shape),
    }
}

fn varying_vector(written: &VaryingVector, place: &str, shape: &mut Shape) -> Signal<3> {
    let VaryingVector { times, values, amplitude, frequency, phase, mean, rate } = written.clone();
    let parts = Parts { times, values, amplitude, frequency, phase, mean, rate };
    parts.signal(place, shape)
}

fn varying_number(written: &VaryingNumber, place: &str, shape: &mut Shape) -> Signal<1> {
    let VaryingNumber { times, values, amplitude, frequency, phase, mean, rate } = written.clone();
    let values = values.map(|values| values.into_iter().map(|x| [x]).collect());
    let [amplitude, mean, rate] = [amplitude, mean, rate].map(|part| part.map(|x| [x]));
    Parts { times, values, amplitude, frequency, phase, mean, rate }.signal(place, shape)
}

/// What a function of time of N numbers is written with.
struct Parts<const N: usize> {
    times: Option<Vec<f64>>,
    values: Option<Vec<[f64; N]>>,
    amplitude: Option<[f64; N]>,
    frequency: Option<f64>,
    phase: Option<f64>,
    mean: Option<[f64; N]>,
    rate: Option<[f64; N]>,
}

impl<const N: usize> Parts<N> {
    /// The signal; a stand-in where what is written makes no sense.
    fn signal(self, place: &str, shape: &mut Shape) -> Signal<N> {
        let Self { times, values, amplitude, frequency, phase, mean, rate } = self;
        let is_table = times.is_some() || values.is_some();
        let is_harmonic = frequency.is_some()
            || phase.is_some()
            || [amplitude, mean, rate].iter().any(|part| part.is_some());
        if is_table && is_harmonic {
            let right = "keep either times and values, or amplitude, frequency, phase, mean and rate";
            shape.refuse(place, "both a table and a formula", right);
        } else if !is_table && !is_harmonic && shape.is_readable(place) {
            let right = "add times and values, or amplitude and frequency";
            shape.refuse(place, "nothing that varies in time", right);
        }
        let none = [0.0; N];
        let harmonic = Harmonic {
            mean: mean.unwrap_or(none),
            rate: rate.unwrap_or(none),
            amplitude: amplitude.unwrap_or(none),
            frequency: frequency.unwrap_or_default(),
            phase: phase.unwrap_or_default(),
        };
        match (times, values) {
            (None, None) => Signal::Harmonic(harmonic),
            (Some(times), Some(values)) => table(times, values, place, shape),
            (times, _) => {
                let missing = if times.is_none() { "times" } else { "values" };
                if shape.is_readable(&format!("{place}.{missing}")) {
                    shape.refuse(
                        place,
                        format!("{missing} are missing"),
                        "give times and values, as many of each",
                    );
                }
                Signal::Harmonic(harmonic)
            }
        }
    }
}

/// A table, or a stand-in for one that makes no sense.
fn table<const N: usize>(
    times: Vec<f64>,
    values: Vec<[f64; N]>,
    place: &str,
    shape: &mut Shape,
) -> Signal<N> {
    let table = report(Table::new(times, values), shape, |problem| format!("{place}.{problem}"));
    table.map_or(Signal::Harmonic(Harmonic::zero()), |table| Signal::Table(Arc::new(table)))
}

fn base_motion(written: &BaseMotion, settings: &Settings, shape: &mut Shape) -> world::BaseMotion {
    let place = |key: &str| format!("rod[0].base_motion.{key}");
    let BaseMotion { translation, axis, angle, rotation } = written;
    if rotation.is_some() && (axis.is_some() || angle.is_some()) {
        shape.refuse(&place("rotation"), "both rotation and axis or angle", "keep one of the two ways");
    }
    if axis.is_some() != angle.is_some() {
        let (given, missing) = if axis.is_some() { ("axis", "angle") } else { ("angle", "axis") };
        if shape.is_readable(&place(missing)) {
            shape.refuse(&place(given), format!("{given} without {missing}"), format!("add {missing}"));
        }
    }
    let problems = shape.problems.len();
    let mut motion = world::BaseMotion::rest();
    if let Some(translation) = translation {
        motion.translation = varying_vector(translation, &place("translation"), shape);
    }
    if let (&Some(axis), Some(angle)) = (axis, angle) {
        let angle = varying_number(angle, &place("angle"), shape);
        motion.rotation = world::BaseRotation::About { axis, angle };
    }
    if let Some(Orientations { times, values }) = rotation {
        let quaternions = table(times.clone(), values.clone(), &place("rotation"), shape);
        if matches!(quaternions, Signal::Table(_)) {
            motion.rotation = world::BaseRotation::By(quaternions);
        }
    }
    let [from, to] = motion.span();
    let of_run = ["simulation.t_end", "simulation.t0"];
    let is_known = problems == shape.problems.len() && of_run.iter().all(|key| shape.is_readable(key));
    let (t0, t_end) = (settings.t0, settings.t_end);
    if is_known && !(covers([from, to], t0) && covers([from, to], t_end)) {
        let right = format!("its tables cover the run from {t0} to {t_end} s");
        shape.refuse(
            "rod[0].base_motion",
            format!("known from {from} to {to} s"),
            format!("expected that {right}"),
        );
    }
    motion
}

fn rod_body(written: &Body) -> body::Body {
    let &Body { mass, at, centre, inertia } = written;
    body::Body { link: 0, at, mass, centre, inertia }
}

fn rod_support(written: &Support) -> support::Support {
    support::Support {
        link: 0,
        at: written.at,
        stiffness: written.stiffness.numbers(),
        rotational_stiffness: written.rotational_stiffness.numbers(),
        damping: written.damping.numbers(),
        rotational_damping: written.rotational_damping.numbers(),
        position: written.position,
        orientation: written.orientation,
    }
}

fn rod_fluid(written: &Fluid) -> world::Fluid {
    let default = world::Fluid::ideal(written.density);
    world::Fluid {
        velocity: written.velocity,
        viscous_drag: written.viscous_drag,
        drag_coefficients: written.drag_coefficients,
        added_mass_coefficient: written.added_mass_coefficient.unwrap_or(default.added_mass_coefficient),
        is_buoyant: written.buoyancy.unwrap_or(default.is_buoyant),
        ..default
    }
}

/// The key in the file of a place in a [`robot::Rod`].
fn rod_place(place: &str, segments: &[Segment]) -> String {
    if place.starts_with("gravity") {
        return format!("scene.{place}");
    }
    let mut key = place.replace("segments", "segment").replace("base_position", "base.position");
    key = key.replace("base_orientation", "base.orientation");
    key = key.replace("loads[", "load[").replace("bodies[", "body[").replace("supports[", "support[");
    let of_segment = key.strip_prefix("segment[").and_then(|rest| rest.split_once("]."));
    if let Some((i, place)) = of_segment
        && let Some(segment) = i.parse::<usize>().ok().and_then(|i| segments.get(i))
    {
        if segment.shear_modulus.is_none() && place == "shear_modulus" {
            key = format!("segment[{i}].poisson_ratio");
        } else if segment.section.is_some() && place.starts_with("radius") {
            // A circle that stands in a table of its own.
            key = format!("segment[{i}].section.{place}");
        }
    }
    format!("rod[0].{key}")
}

fn pendulum(document: &Document, shape: &mut Shape) -> Option<(Model, [Vec<f64>; 2])> {
    let written = document.pendulum.as_ref()?;
    if document.scene.gravity.is_some() {
        shape.refuse(
            "scene.gravity",
            "a pendulum does not use it",
            "give the number pendulum.gravity instead",
        );
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
        atol: written.atol.unwrap_or(default.atol),
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
    /// Everything that is wrong with the settings, whatever the model.
    fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        let starts = check.require(self.t0.is_finite(), "t0", Number(self.t0), "a finite number (seconds)");
        let expected = format!("a finite number > t0 = {} (seconds)", Number(self.t0));
        let is_later = self.duration() > 0.0 && self.duration().is_finite();
        let runs = starts && check.require(is_later, "t_end", Number(self.t_end), &expected);
        check.positive(self.dt, "dt", "seconds");
        check.non_negative(self.rtol, "rtol", "relative");
        check.non_negative(self.atol, "atol", "absolute");
        check.require(
            self.rtol > 0.0 || self.atol > 0.0,
            "rtol",
            "both rtol and atol zero",
            "one of them > 0",
        );
        if let Some(dt) = self.output_dt
            && check.positive(dt, "output.dt", "seconds")
            && runs
        {
            let expected = format!("at most the simulated time, {} s", Number(self.duration()));
            // The duration is a difference, and rounded.
            let is_within = dt * (1.0 - END_OF_OUTPUT) <= self.duration();
            check.require(is_within, "output.dt", Number(dt), &expected);
        }
        check.finish()
    }

    /// Refuses a run of a model of `n` coordinates that would not end or not fit in memory. Says nothing about times
    /// that [`Self::validate`] refuses.
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
        // The quotients may be infinite: too many, like any other number that is too large.
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

/// A large number in words that hold even where it overflowed.
fn count(number: f64) -> String {
    if number.is_finite() { format!("{number:.2e}") } else { format!("more than {:.2e}", f64::MAX) }
}

/// Notes the complaints of a constructor at the keys of the file, unless the value there is a stand-in.
pub(super) fn report<T>(
    result: Result<T, InvalidInput>,
    shape: &mut Shape,
    key: impl Fn(&str) -> String,
) -> Option<T> {
    let error = match result {
        Ok(value) => return Some(value),
        Err(error) => error,
    };
    for problem in error.problems {
        let key = key(&problem.place);
        if shape.is_readable(&key) {
            shape.refuse(&key, format!("got {}", problem.found), format!("expected {}", problem.expected));
        }
    }
    None
}
