//! Any rod is rejected, or it compiles and can be evaluated, and results reported as successes are finite.

use lissom::actuator::{ActiveStrain, Actuator, Along, Chamber, Drive, Part, Strain, Tendon, Via};
use lissom::body::Body;
use lissom::error::Interrupted;
use lissom::fluid::Fluid;
use lissom::linalg::Matrix;
use lissom::load::{Extent, Frame, Load};
use lissom::magnet::Magnet;
use lissom::model::{Dynamics, Elastic as _, ForwardScratch, InTime as _, Refinable as _};
use lissom::robot::{RobotModel, Rod};
use lissom::rod::{
    Basis, GivenSection, Profile, STRAIGHT, Section, Segment, Shape, ShearCorrection, diagonal,
};
use lissom::signal::{Harmonic, Input, Signal, Table};
use lissom::support::Support;
use lissom::world::{BaseMotion, BaseRotation};
use lissom::{newmark, statics};

use super::source::Source;

/// Last byte of an input whose rod has actuators.
const ACTUATED: u8 = b'a';

/// Last byte, behind that of actuators, of an input whose rod is magnetic.
const MAGNETIC: u8 = b'b';

/// Larger rods are compiled but not simulated, which would take time without finding more.
const MOVED: usize = 24;
const NODES: usize = 80;

/// Number of steps, and of iterations of a search.
const WORK: usize = 20;

/// Uses a rod as a user would. Panics if anything is wrong; returns a description of the outcome.
pub(crate) fn fuzz_plan(bytes: &[u8]) -> String {
    // Magnets and actuators only if the last bytes request them, so that older inputs keep their meaning.
    let (bytes, is_magnetic) = without(bytes, MAGNETIC);
    let (bytes, has_actuators) = without(bytes, ACTUATED);
    let source = &mut Source(bytes);
    let mut rod = rod(source);
    let length = rod.segments.iter().map(|segment| segment.length).sum();
    if has_actuators {
        rod.actuators = (0..1 + source.below(4)).map(|i| actuator(source, length, i)).collect();
    }
    if is_magnetic {
        magnetise(source, &mut rod, length);
    }
    if std::env::var_os("LISSOM_FUZZ_INPUT").is_some() {
        eprintln!("{rod:#?}");
    }
    let mut model = match RobotModel::of_rod(&rod) {
        Ok(model) => model,
        Err(error) => {
            assert!(!error.problems.is_empty(), "an error says what is wrong");
            assert!(error.to_string().len() < 100_000, "a message that nobody reads");
            return format!("refused {}", kind(&error.problems[0].place));
        }
    };
    assert_eq!(model.facts().n, rod.coordinates());
    assert!(model.explanation().to_string().len() < 1_000_000);
    let n = model.facts().n;
    if n == 0 || n > MOVED || model.nodes().iter().sum::<usize>() > NODES {
        return "compiled".to_owned();
    }
    let mut outcome = vec![String::from("moved")];
    let q: Vec<f64> = (0..n).map(|_| if source.one_in(3) { source.near(0.1) } else { 0.0 }).collect();
    let v: Vec<f64> = (0..n).map(|_| if source.one_in(3) { source.near(0.1) } else { 0.0 }).collect();
    let rest = vec![0.0; n];
    if model.set_time(source.near(0.5)).is_err() {
        return "no time".to_owned();
    }
    let is_resolved = model.check_shape(&q, "q").is_ok();
    outcome.push(format!("resolved {is_resolved}"));
    evaluate(&mut model, &q, &v);
    if let Ok(modes) = lissom::modes::modes(&mut model, &rest) {
        assert!(all_finite(&modes.frequency) && all_finite(&modes.damping), "modes that are not finite");
        outcome.push("modes".to_owned());
    }
    let dt = source.near(1e-2);
    if let Ok(status) = step(&mut model, [&q, &v], dt) {
        outcome.push(status);
    }
    let mut work = 0;
    let mut monitor = || {
        work += 1;
        if work > 5 * WORK { Err(Interrupted) } else { Ok(()) }
    };
    let options = statics::Options { max_iter: WORK, max_steps: WORK, ..statics::Options::default() };
    if let Ok(Ok(found)) = statics::equilibrium(&mut model, &options, &mut monitor) {
        assert!(!found.status.is_success() || all_finite(&found.q), "equilibrium that is not finite");
        assert!(!found.message.is_empty());
        outcome.push(found.status.name().to_owned());
    }
    outcome.join(" ")
}

/// Bytes without this last one, and whether they had it.
fn without(bytes: &[u8], last: u8) -> (&[u8], bool) {
    match bytes {
        [rest @ .., end] if *end == last => (rest, true),
        _ => (bytes, false),
    }
}

/// The place of a problem without its indices.
fn kind(place: &str) -> String {
    place.chars().filter(|c| !c.is_ascii_digit()).collect()
}

fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

fn evaluate(model: &mut RobotModel, q: &[f64], v: &[f64]) {
    let n = q.len();
    let mut tau = vec![0.0; n];
    model.inverse_dynamics(q, v, &vec![0.0; n], &mut tau);
    model.elastic_forces(q, &mut tau);
    let mut matrix = Matrix::zeros(n, n);
    model.weighted_tangent(q, v, &tau, [1.0, 0.5, 0.25], &mut matrix);
    model.mass_matrix(q, &mut matrix);
    model.elastic_tangent(q, &mut matrix);
    let mut scratch = ForwardScratch::of(model);
    let mut a = vec![0.0; n];
    _ = model.forward_dynamics(q, v, &mut a, &mut scratch);
    _ = model.energy(q, v).total();
    let mut by_inputs = Matrix::zeros(n, model.facts().default_inputs.len());
    model.input_tangent(q, v, &vec![0.0; n], &mut by_inputs);
    let power = model.dissipated_power(q, v);
    assert!(power.is_nan() || power >= 0.0, "damping that does work: {power}");
    _ = model.supplied_power(q, v, &a);
    for x in [0.0, 0.3 * model.facts().length, f64::INFINITY, f64::NAN] {
        _ = model.pose(q, x);
        let place = model.place(x);
        _ = model.velocity_at(q, v, &place);
    }
    _ = model.tip(q);
    _ = model.base_wrench(q, v, &a);
    let mut sizes = vec![0.0; n];
    sizes.copy_from_slice(&model.facts().typical_coordinates);
    assert!(sizes.iter().all(|size| *size > 0.0), "typical coordinates {sizes:?}");
    if let Some(modes) = model.modes() {
        _ = model.with_modes(&modes.iter().map(|modes| modes + 1).collect::<Vec<_>>());
    }
}

/// A few steps of the default method.
fn step(model: &mut RobotModel, [q, v]: [&[f64]; 2], dt: f64) -> Result<String, ()> {
    let options = newmark::Options { max_steps: WORK, ..newmark::Options::new(dt) };
    let times = [0.0, dt, 3.0 * dt];
    let solution = newmark::solve(model, (0.0, 3.0 * dt), q, v, &options, Some(&times), &mut |_, _| Ok(()))
        .map_err(|_| ())?;
    if solution.status.is_success() {
        assert!(all_finite(&solution.q) && all_finite(&solution.v), "a motion that is not finite");
    }
    assert!(!solution.message.is_empty());
    Ok(solution.status.name().to_owned())
}

fn rod(source: &mut Source<'_>) -> Rod {
    let first = segment(source);
    let mut segments = vec![first];
    segments.extend(source.some(4, segment));
    let length = segments.iter().map(|segment| segment.length).sum::<f64>();
    Rod {
        base_position: source.zeros(),
        base_orientation: source.like([1.0, 0.0, 0.0, 0.0]),
        base_motion: source.maybe(8, base_motion),
        gravity: source.like([0.0, 0.0, -9.81]),
        tip_force: source.zeros(),
        tip_moment: source.zeros(),
        tip_mass: source.maybe(4, |source| source.near(0.1)).unwrap_or(0.0),
        loads: source.some(2, |source| load(source, length)),
        bodies: source.some(2, |source| body(source, length)),
        supports: source.some(2, |source| support(source, length)),
        fluid: source.maybe(8, fluid),
        ..Rod::new(segments)
    }
}

fn segment(source: &mut Source<'_>) -> Segment {
    let length = source.near(0.5);
    let section = section(source, length);
    let is_given = matches!(section, Section::Given(_));
    let usual = if is_given { [0.0; 3] } else { [1e9, 4e8, 1000.0] };
    let [young, shear, density] = source.like(usual);
    let basis = Basis::ALL[source.below(Basis::ALL.len())];
    let number = 2 * (1 + source.below(2));
    let modes = std::array::from_fn(|strain| match source.byte() {
        // Most rods have bending.
        0..=99 if strain == 1 => number,
        0..=149 => 0,
        150..=249 => number,
        250..=253 => source.below(80),
        _ => source.below(5),
    });
    Segment {
        section,
        modes,
        basis,
        retardation_time: source.maybe(3, |source| source.near(1e-3)).unwrap_or(0.0),
        reference_strain: source
            .maybe(3, |source| {
                let middle = source.zeros::<6>();
                profile(
                    source,
                    STRAIGHT,
                    |source| {
                        let strain = source.zeros::<6>();
                        std::array::from_fn(|i| STRAIGHT[i] + strain[i] + middle[i])
                    },
                    length,
                )
            })
            .unwrap_or_else(|| STRAIGHT.into()),
        shear_correction: match source.byte() {
            0..=229 => 1.0.into(),
            230..=239 => ShearCorrection::Cowper,
            _ => ShearCorrection::Factors(source.like([0.9, 0.8])),
        },
        nodes: source.maybe(6, |source| source.below(300)),
        ..Segment::straight(length, 1.0, young, shear, density)
    }
}

/// A constant, linear, tabulated or polynomial profile; constant if the drawn one is invalid.
fn profile<const N: usize>(
    source: &mut Source<'_>,
    usual: [f64; N],
    mut make: impl FnMut(&mut Source<'_>) -> [f64; N],
    length: f64,
) -> Profile<N> {
    match source.byte() {
        0..=127 => make(source).into(),
        128..=169 => Profile::linear([make(source), make(source)]),
        170..=229 => {
            let number = if source.one_in(12) { source.below(3000) } else { 2 + source.below(24) };
            let end = source.near(length);
            let stations: Vec<f64> =
                (0..number).map(|i| end * i as f64 / (number.max(2) - 1) as f64).collect();
            let values: Vec<[f64; N]> =
                (0..number).map(|i| if i < 30 { make(source) } else { usual }).collect();
            Profile::table(&stations, &values).unwrap_or_else(|_| usual.into())
        }
        _ => {
            let mut coefficients = vec![usual];
            coefficients.extend(source.some(6, |source| make(source).map(|number| number * 0.01)));
            Profile::polynomial(&coefficients).unwrap_or_else(|_| usual.into())
        }
    }
}

fn section(source: &mut Source<'_>, length: f64) -> Section {
    let kind = source.below(8);
    let mut size = |usual: f64| profile(source, [usual], |source| [source.near(usual)], length);
    Section::Shape(match kind {
        0 | 5 | 6 => Shape::Circle { radius: size(1e-2) },
        1 => Shape::HollowCircle { outer: size(1e-2), inner: size(5e-3) },
        2 => Shape::Rectangle { width: size(1e-2), height: size(2e-2) },
        3 => Shape::Ellipse { semi_axis_y: size(1e-2), semi_axis_z: size(2e-2) },
        _ => return Section::Given(Box::new(given(source, length))),
    })
}

fn given(source: &mut Source<'_>, length: f64) -> GivenSection {
    let mut rows = diagonal(source.like([10.0, 10.0, 10.0, 1e5, 1e5, 1e5]));
    for _ in 0..source.below(3) {
        let (i, j, value) = (source.below(6), source.below(6), source.near(0.5));
        (rows[i][j], rows[j][i]) = (value, value);
    }
    let entries: [f64; 36] = std::array::from_fn(|i| rows[i / 6][i % 6]);
    GivenSection {
        stiffness: profile(
            source,
            entries,
            |source| {
                let factor = source.near(1.0);
                entries.map(|entry| entry * factor)
            },
            length,
        ),
        mass: profile(source, [0.3], |source| [source.near(0.3)], length),
        inertia: profile(
            source,
            [0.0; 9],
            |source| {
                let moment = source.near(1e-5);
                [2.0 * moment, 0.0, 0.0, 0.0, moment, 0.0, 0.0, 0.0, moment]
            },
            length,
        ),
        centre: profile(source, [0.0; 2], |source| source.zeros(), length),
    }
}

fn signal<const N: usize>(source: &mut Source<'_>) -> Signal<N> {
    match source.byte() {
        0..=179 => Signal::Constant(std::array::from_fn(|_| source.near(0.1))),
        180..=219 => Signal::Harmonic(Harmonic {
            mean: source.zeros(),
            rate: source.zeros(),
            amplitude: source.like([0.1; N]),
            frequency: source.near(2.0),
            phase: source.near(0.0),
        }),
        _ => {
            let times: Vec<f64> = (0..2 + source.below(3)).map(|i| source.near(i as f64)).collect();
            let values = times.iter().map(|_| source.zeros()).collect();
            Table::new(times, values).map_or(Signal::Constant([0.0; N]), |table| Signal::Table(table.into()))
        }
    }
}

fn base_motion(source: &mut Source<'_>) -> BaseMotion {
    let rotation = match source.byte() {
        0..=199 => BaseRotation::About { axis: source.like([0.0, 0.0, 1.0]), angle: signal(source) },
        _ => BaseRotation::By(signal(source)),
    };
    BaseMotion { translation: signal(source), rotation }
}

fn load(source: &mut Source<'_>, length: f64) -> Load {
    let extent = match source.below(3) {
        0 => Extent::Tip,
        1 => Extent::At(source.near(0.4 * length)),
        _ => Extent::Along(source.like([0.2 * length, 0.7 * length])),
    };
    let frame = if source.one_in(2) { Frame::Body } else { Frame::World };
    Load { link: 0, extent, frame, force: signal(source), moment: signal(source) }
}

fn body(source: &mut Source<'_>, length: f64) -> Body {
    Body {
        link: 0,
        at: source.maybe(2, |source| source.near(0.6 * length)),
        mass: source.near(0.1),
        centre: source.zeros(),
        inertia: diagonal(source.like([1e-4, 1e-4, 1e-4])),
        hull: None,
    }
}

fn support(source: &mut Source<'_>, length: f64) -> Support {
    Support {
        link: 0,
        at: source.maybe(2, |source| source.near(0.6 * length)),
        stiffness: source.like([100.0; 3]),
        rotational_stiffness: source.like([1.0; 3]),
        damping: source.zeros(),
        rotational_damping: source.zeros(),
        position: source.maybe(3, |source| source.zeros()),
        orientation: source.maybe(3, |source| source.like([1.0, 0.0, 0.0, 0.0])),
    }
}

fn actuator(source: &mut Source<'_>, length: f64, number: usize) -> Actuator {
    let name = if source.one_in(30) { "same".to_owned() } else { format!("actuator {number}") };
    match source.below(6) {
        0 => Actuator::Chamber(Chamber {
            name,
            path: (0..1 + source.below(2)).map(|_| along(source, length)).collect(),
            area: source.near(1e-5),
            pressure: command(source),
        }),
        1 => Actuator::ActiveStrain(ActiveStrain {
            name,
            link: 0,
            strain: [Strain::BendY, Strain::BendZ, Strain::Stretch][source.below(6) % 3],
            shape: profile(source, [1.0], |source| [source.near(1.0)], length),
            amount: command(source),
        }),
        _ => {
            let part = |source: &mut Source<'_>| match source.below(4) {
                0 => Part::Via(Via {
                    link: source.maybe(2, |_| 0),
                    point: source.like([0.02; 3]),
                    at: source.maybe(2, |source| source.near(0.5 * length)),
                }),
                _ => Part::Along(along(source, length)),
            };
            let path = (0..1 + source.below(3)).map(|_| part(source)).collect();
            let drive = match source.one_in(3) {
                false => Drive::Tension(command(source)),
                true => Drive::Length {
                    length: [source.near(0.9 * length)].into(),
                    stiffness: source.maybe(2, |source| source.near(100.0)),
                    damping: source.maybe(2, |source| source.near(0.1)).unwrap_or(0.0),
                },
            };
            Actuator::Tendon(Tendon {
                name,
                path,
                drive,
                friction: source.maybe(3, |source| source.near(0.2)).unwrap_or(0.0),
                friction_velocity: source.near(1e-3),
                sliding: source.maybe(4, command),
            })
        }
    }
}

fn along(source: &mut Source<'_>, length: f64) -> Along {
    let ends = if source.one_in(2) { [0.0, length] } else { source.like([0.2 * length, 0.7 * length]) };
    let offset = [0.0, 0.01].map(|usual| profile(source, [usual], |source| [source.near(usual)], length));
    Along { link: 0, offset, along: ends }
}

fn command(source: &mut Source<'_>) -> Signal<1> {
    match source.one_in(3) {
        false => signal(source),
        true => Signal::Input(Input { name: "told".into(), value: [source.near(0.5)] }),
    }
}

fn magnetise(source: &mut Source<'_>, rod: &mut Rod, length: f64) {
    for segment in &mut rod.segments {
        if matches!(segment.section, Section::Shape(_)) || source.one_in(30) {
            let usual = [1e4, 0.0, 1e3];
            segment.magnetisation = profile(source, usual, |source| source.like(usual), segment.length);
        }
    }
    rod.field = signal(source);
    rod.magnets = source.some(3, |source| Magnet {
        link: 0,
        at: source.maybe(2, |source| source.near(0.6 * length)),
        moment: source.like([0.1, 0.0, 0.01]),
        position: source.zeros(),
    });
}

fn fluid(source: &mut Source<'_>) -> Fluid {
    Fluid {
        velocity: source.zeros(),
        viscous_drag: source.like([1.0, 0.5]),
        drag_coefficients: source.like([1.0, 0.01]),
        added_mass_coefficient: source.near(1.0),
        is_buoyant: source.one_in(2),
        ..Fluid::ideal(source.near(1000.0))
    }
}
