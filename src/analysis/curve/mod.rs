//! Fits the coordinates of a rod to given points, such as nodes of another code, splines of drawings or motion capture.
//!
//! Points determine bending and stretch. Torsion and shear hardly change the axis of a rod; they keep their values at rest
//! unless frames of sections are given as well. The sum of squared distances (and of angles, times the length of the rod)
//! is minimised by Gauss-Newton steps in a trust region (Levenberg 1944; Moré 1978) with the exact Jacobians of
//! the kinematics. `start` estimates the initial coordinates from the curvature of the points, so that the search for rods of
//! many turns does not end in a local minimum.
//!
//! ```
//! use lissom::curve::{Curve, coordinates_of};
//! use lissom::robot::{Robot, Rod};
//! use lissom::rod::Segment;
//!
//! let segment = Segment { modes: [0, 0, 1, 0, 0, 0], ..Segment::straight(1.0, 0.01, 1e6, 4e5, 1000.0) };
//! let robot = Robot::from(&Rod::new(vec![segment]));
//! // A quarter of a circle in the x-y plane.
//! let radius = 2.0 / std::f64::consts::PI;
//! let points = (0..=20).map(|i| f64::from(i) / 20.0 / radius);
//! let points = points.map(|angle| [radius * angle.sin(), radius * (1.0 - angle.cos()), 0.0]).collect();
//! let found = coordinates_of(&robot, 0, &Curve::new(points), &mut || Ok(()))?.expect("nothing interrupts it");
//! assert!((found.q[0] - 1.0 / radius).abs() < 1e-9 && found.largest_distance() < 1e-9);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod points;
mod start;

use crate::analysis::reach::Target;
use crate::analysis::reach::misfit::Misfit;
use crate::analysis::statics::Monitor;
use crate::description::joint::Joint;
use crate::error::{InvalidInput, Rounded, Unfinished};
use crate::model::{InvalidShape, rotation_vectors};
use crate::numerics::linalg::norm;
use crate::numerics::roots::least_squares::{Bounds, Counters, End, Options, SecondOrder, solve};
use crate::robot::{Link, Robot, RobotModel};
use start::{NoStart, Start};

pub use points::Curve;

/// Norm of all residuals, relative to the length of the rod, below which it is rounding of positions.
const TOLERANCE: f64 = 1e-14;

/// Maximum number of steps: Gauss-Newton steps converge linearly where the points are not on a curve of the modes.
const MAX_ITER: usize = 200;

/// Status of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// The sum of squared distances has a local minimum.
    Fitted,
    /// The limit of iterations was reached.
    IterationLimit,
    /// No step, however short, reduces the distances.
    Stalled,
    /// The search ended in an invalid shape.
    Invalid(InvalidShape),
    /// The monitor asked to stop.
    Interrupted,
}

impl Status {
    /// True if a local minimum was found.
    pub fn is_success(self) -> bool {
        self == Self::Fitted
    }

    /// Stable name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fitted => "fitted",
            Self::IterationLimit => "iteration_limit",
            Self::Stalled => "stalled",
            Self::Invalid(InvalidShape::Unresolved { .. }) => "unresolved",
            Self::Invalid(InvalidShape::Inverted { .. }) => "inverted",
            Self::Invalid(
                InvalidShape::Collapsed { .. }
                | InvalidShape::Open { .. }
                | InvalidShape::DeepPenetration { .. },
            ) => "collapsed",
            Self::Interrupted => "interrupted",
        }
    }
}

/// Coordinates of a rod, and its distances from the points.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// Coordinates of the link: of its joint unless it is driven, then of its rod.
    pub q: Vec<f64>,
    /// How the search ended.
    pub status: Status,
    /// Status in words, with the distances and advice.
    pub message: String,
    /// Arc lengths of the points on the unstretched rod, in metres.
    pub at: Vec<f64>,
    /// Distance of each point from its section, in metres.
    pub distances: Vec<f64>,
    /// Angle of each frame from its section, in radians; zero without frames.
    pub angles: Vec<f64>,
    /// Steps and evaluations.
    pub counters: Counters,
}

impl Followed {
    /// The largest distance in metres.
    pub fn largest_distance(&self) -> f64 {
        self.distances.iter().copied().fold(0.0, f64::max)
    }

    /// The root mean square of the distances in metres.
    pub fn rms_distance(&self) -> f64 {
        norm(&self.distances) / (self.distances.len() as f64).sqrt()
    }
}

/// Fits the rod of a link to a curve by least squares. Costs about ten
/// Jacobians per point, and about ten eigendecompositions of matrices of the size of the coordinates. An
/// interruption carries the best shape so far.
///
/// Fails before the search if the curve is invalid.
pub fn coordinates_of(
    robot: &Robot,
    link: usize,
    curve: &Curve,
    monitor: Monitor<'_>,
) -> Result<Result<Followed, Unfinished<Followed>>, InvalidInput> {
    curve.check(&robot.links[link])?;
    let alone = alone(&robot.links[link]);
    let start = Start::new(curve, alone.links[0].length());
    let targets = start.targets(curve.frames.is_some());
    let mut model = RobotModel::new(&alone)?;
    let found = start.coordinates(&alone.links[0], monitor);
    let (mut q, is_interrupted) = match found {
        Ok(q) => (q, false),
        Err(NoStart::Input(error)) => return Err(error),
        Err(NoStart::Interrupted) => (vec![0.0; alone.coordinates()], true),
    };
    let (end, invalid_shape, counters) = if is_interrupted {
        (End::Interrupted, None, Counters::default())
    } else {
        descend(&mut model, &targets, &mut q, monitor)
    };
    let status = match end {
        End::Root | End::Minimum => Status::Fitted,
        End::IterationLimit => Status::IterationLimit,
        End::Stalled | End::NonFinite => invalid_shape.map_or(Status::Stalled, Status::Invalid),
        End::Interrupted => Status::Interrupted,
    };
    let mut rates = vec![0.0; q.len()];
    rotation_vectors::wrap(&alone.rotation_vectors(), &mut q, &mut rates, &mut []);
    let mut never = || Ok(());
    let mut misfit = Misfit::new(&mut model, &targets, &q, Vec::new(), &mut never);
    let errors = misfit.errors(&q);
    let mut followed = Followed {
        q,
        status,
        message: String::new(),
        at: start.at,
        distances: errors.iter().map(|(error, _)| error.position).collect(),
        angles: errors.iter().map(|(error, _)| error.orientation).collect(),
        counters,
    };
    followed.message = message(&followed);
    Ok(if status == Status::Interrupted { Err(Unfinished::new(followed)) } else { Ok(followed) })
}

/// The link as a robot, attached to the world at the axes of the curve. Driven joints count as welded.
fn alone(link: &Link) -> Robot {
    let joint = if link.driven.is_none() { link.joint.clone() } else { Joint::Weld };
    Robot::new(vec![Link { joint, rod: link.rod.clone(), ..Link::new(link.name.clone()) }])
}

/// Moves the coordinates of a robot of one link to the nearest local minimum of its distances from these targets.
fn descend(
    model: &mut RobotModel,
    targets: &[Target],
    q: &mut Vec<f64>,
    monitor: Monitor<'_>,
) -> (End, Option<InvalidShape>, Counters) {
    let robot = model.description().clone();
    let has_frames = targets.iter().any(|target| target.orientation.is_some());
    let mut bounds = Bounds::none(q.len());
    if !has_frames {
        let first = robot.links[0].joint_coordinates().len();
        for k in start::undetermined(&robot.links[0].rod).into_iter().map(|k| first + k) {
            (bounds.lower[k], bounds.upper[k]) = (0.0, 0.0);
        }
    }
    let mut misfit = Misfit::new(model, targets, q, robot.rotation_vectors(), monitor);
    let mut x: Vec<f64> = q.iter().zip(&misfit.sizes).map(|(q, size)| q / size).collect();
    let options =
        Options { tolerance: TOLERANCE, terms: 1.0, max_iter: MAX_ITER, second_order: SecondOrder::Never };
    let outcome = solve(&mut misfit, &mut x, &bounds, &options).unwrap_or_else(Unfinished::into_inner);
    *q = misfit.coordinates(&x);
    (outcome.end, misfit.invalid_shape, outcome.counters)
}

fn message(found: &Followed) -> String {
    let said = match found.status {
        Status::Fitted => "The rod follows the points as nearly as its modes allow.".to_owned(),
        Status::IterationLimit => {
            "The limit of iterations was reached: these are the nearest coordinates found.".to_owned()
        }
        Status::Stalled => {
            "No step, however short, brings the rod nearer, although the derivatives predict it.".to_owned()
        }
        Status::Invalid(invalid_shape) => format!(
            "The search ended at a shape in which a rod {invalid_shape}. Check the units and the order of the points, or give the segments \
             more `nodes`."
        ),
        Status::Interrupted => "The search was interrupted.".to_owned(),
    };
    format!(
        "{said} Distance from the points: at most {} m, {} m in the root mean square. Where that is too much, give the \
         segments more modes or divide them, check that the points are in the axes in which the link is attached, and give \
         `X` if they do not reach from base to tip.",
        Rounded(found.largest_distance()),
        Rounded(found.rms_distance())
    )
}
