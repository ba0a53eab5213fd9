//! Pose and motion of the base of a rod.
//!
//! At every time, equations use the inertial frame that coincides with the base and moves with its point. In
//! this frame the base has a fixed position, so that the kinematics along the rod do not depend on its
//! motion. The motion enters through the angular velocity and the acceleration at the first station, from
//! which the sweeps start, and through the world as seen from the base: the directions of gravity and of dead
//! loads, the velocity of the fluid, the anchors of supports. A base in free fall in empty space thus makes a
//! rod exactly weightless, and a constant velocity has no effect.

use super::prescribed::nearer;
use super::smooth::{self, Smooth, check_smooth, span};
use crate::description::signal::{Cell, Harmonic, Jumps, Motion, Signal, StepContext, Table};
use crate::error::{Checker, Interrupted, InvalidInput, Number};
use crate::numerics::lie::QUATERNION_TOLERANCE;
use crate::numerics::lie::{Quaternion, Rotation, Vector, rotation_vector_motion};

/// Cosine of half the largest angle between neighbouring orientations of a table, a right angle. With larger
/// angles the motion in between is ambiguous.
const LEAST_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2 * (1.0 - 1e-9);

/// Relative size below which sines and lengths are rounding errors.
const ROUNDING: f64 = 1e-12;

/// Motion of the base relative to the position and orientation of the rod.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseMotion {
    /// Displacement in the world, in metres.
    pub translation: Signal<3>,
    /// Rotation of the base about its point.
    pub rotation: BaseRotation,
}

/// Rotation of a base in world axes, applied after its own orientation.
#[derive(Clone, Debug, PartialEq)]
pub enum BaseRotation {
    /// Rotation about an axis in world coordinates, of any length, by an angle in radians.
    About {
        /// The axis.
        axis: [f64; 3],
        /// The angle.
        angle: Signal<1>,
    },
    /// Quaternions (w, x, y, z), normalised on use. A table is interpolated in R^4, which
    /// commutes with rotations of the world and of the base.
    By(Signal<4>),
}

impl BaseMotion {
    /// Rest: a start for `..` syntax.
    pub fn rest() -> Self {
        Self {
            translation: Signal::default(),
            rotation: BaseRotation::About { axis: [0.0, 0.0, 1.0], angle: Signal::default() },
        }
    }

    /// Reports every problem of the motion.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check_smooth(&self.translation, &mut check, "translation");
        match &self.rotation {
            BaseRotation::About { axis, angle } => {
                if check.finite(axis, "axis") {
                    let is_axis = axis.iter().any(|&x| x != 0.0);
                    check.require(is_axis, "axis", "a vector of length 0", "a vector that is not zero");
                }
                check_smooth(angle, &mut check, "angle");
            }
            BaseRotation::By(Signal::Table(table)) => check_orientations(&mut check, table),
            BaseRotation::By(Signal::Function(_)) => {}
            BaseRotation::By(_) => {
                let expected = "a table or a function of quaternions; for harmonic rotations axis and angle";
                check.require(false, "rotation", "a constant or harmonic one", expected);
            }
        }
        check.finish()
    }

    /// Latest end of a step from `t` that cannot miss a feature of the motion ([`Signal::horizon`]).
    pub fn horizon(&self, t: f64) -> f64 {
        let of_rotation = match &self.rotation {
            BaseRotation::About { angle, .. } => smooth::horizon(angle, t),
            BaseRotation::By(quaternion) => smooth::horizon(quaternion, t),
        };
        smooth::horizon(&self.translation, t).min(of_rotation)
    }

    /// The next time at which a step of fixed size must end.
    pub(crate) fn corner(&self, cell: Cell) -> Option<f64> {
        let of_rotation = match &self.rotation {
            BaseRotation::About { angle, .. } => smooth::corner(angle, cell),
            BaseRotation::By(quaternion) => smooth::corner(quaternion, cell),
        };
        smooth::corner(&self.translation, cell).into_iter().chain(of_rotation).reduce(f64::min)
    }

    /// The time at which the velocity jumps, if that is `t`, but for rounding.
    pub(crate) fn jump_near(&self, t: f64) -> Option<f64> {
        smooth::jump_near(&self.translation, t).or_else(|| match &self.rotation {
            BaseRotation::About { angle, .. } => smooth::jump_near(angle, t),
            BaseRotation::By(quaternion) => smooth::jump_near(quaternion, t),
        })
    }

    /// The quantities that may jump at some time.
    pub(crate) fn jumps(&self) -> Jumps {
        smooth::jumps(&self.translation).max(match &self.rotation {
            BaseRotation::About { angle, .. } => smooth::jumps(angle),
            BaseRotation::By(quaternion) => smooth::jumps(quaternion),
        })
    }

    /// Shortest period in seconds; infinite without oscillations.
    pub fn period(&self) -> f64 {
        let of_rotation = match &self.rotation {
            BaseRotation::About { angle, .. } => angle.period(),
            BaseRotation::By(quaternion) => quaternion.period(),
        };
        self.translation.period().min(of_rotation)
    }

    /// Interval of time on which the motion is defined.
    pub fn span(&self) -> [f64; 2] {
        let translation = span(&self.translation);
        let rotation = match &self.rotation {
            BaseRotation::About { angle, .. } => span(angle),
            BaseRotation::By(quaternion) => span(quaternion),
        };
        [translation[0].max(rotation[0]), translation[1].min(rotation[1])]
    }

    /// Whether the base never moves.
    pub fn is_constant(&self) -> bool {
        let turns = match &self.rotation {
            BaseRotation::About { angle, .. } => angle.constant().is_none(),
            BaseRotation::By(_) => true,
        };
        self.translation.constant().is_some() && !turns
    }

    /// Whether the motion certainly keeps the base in the plane perpendicular to `normal`, a unit vector in
    /// the world.
    pub(crate) fn stays_in_plane(&self, normal: Vector<f64>) -> bool {
        let is_across = |v: &[f64; 3]| {
            let v: Vector<f64> = (*v).into();
            v.dot(normal).abs() <= ROUNDING * v.dot(v).sqrt()
        };
        let moves_across = match &self.translation {
            Signal::Constant(_) | Signal::Input(_) => true,
            Signal::Harmonic(Harmonic { rate, amplitude, .. }) => is_across(rate) && is_across(amplitude),
            Signal::Table(table) => table.values().iter().all(is_across),
            Signal::Function(_) => false,
        };
        let turns_across = match &self.rotation {
            BaseRotation::About { angle: Signal::Constant([0.0]), .. } => true,
            BaseRotation::About { axis, .. } => {
                let axis: Vector<f64> = (*axis).into();
                let along = axis.dot(normal);
                let aside = axis - normal * along;
                aside.dot(aside).sqrt() <= ROUNDING * along.abs()
            }
            BaseRotation::By(_) => false,
        };
        moves_across && turns_across
    }
}

/// Requires unit quaternions, and neighbouring orientations within a right angle.
fn check_orientations(check: &mut Checker, table: &Table<4>) {
    let mut before: Option<[f64; 4]> = None;
    for (i, quaternion) in table.values().iter().enumerate() {
        let norm = dot(quaternion, quaternion).sqrt();
        let place = format!("rotation.values[{i}]");
        let is_unit = (norm - 1.0).abs() <= QUATERNION_TOLERANCE;
        let found = format_args!("a quaternion of norm {}", Number(norm)).to_string();
        check.require(is_unit, &place, found, "a quaternion (w, x, y, z) of norm 1");
        if let Some(before) = before
            && is_unit
        {
            let is_near = dot(&before, quaternion).abs() >= LEAST_COSINE * norm;
            let expected = "less than a right angle from one orientation to the next: more of them";
            check.require(is_near, &place, "a large turn since the one before", expected);
        }
        before = is_unit.then_some(*quaternion);
    }
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// State of a base at a time, in world coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Base {
    pub(crate) position: Vector<f64>,
    pub(crate) rotation: Rotation<f64>,
    pub(crate) velocity: Vector<f64>,
    pub(crate) acceleration: Vector<f64>,
    pub(crate) angular_velocity: Vector<f64>,
    pub(crate) angular_acceleration: Vector<f64>,
}

impl Base {
    /// Place, velocity and acceleration in each direction.
    pub(crate) fn shifts(&self) -> [[f64; 3]; 3] {
        let motion = [self.position, self.velocity, self.acceleration].map(|vector| vector.to_array());
        std::array::from_fn(|i| motion.map(|vector| vector[i]))
    }

    /// A base at rest.
    pub(crate) fn at(position: [f64; 3], orientation: [f64; 4]) -> Self {
        let rotation = Quaternion::from_array(orientation).rotation();
        let zero = Vector::from([0.0; 3]);
        Self {
            position: position.into(),
            rotation,
            velocity: zero,
            acceleration: zero,
            angular_velocity: zero,
            angular_acceleration: zero,
        }
    }

    /// The same pose at rest.
    pub(crate) fn at_rest(&self) -> Self {
        let zero = Vector::from([0.0; 3]);
        Self {
            velocity: zero,
            acceleration: zero,
            angular_velocity: zero,
            angular_acceleration: zero,
            ..*self
        }
    }

    /// Position and velocity, in the frame that follows this base, of a point fixed in the world. `point` is
    /// given relative to the base at rest.
    pub(crate) fn point_in_frame(&self, point: Vector<f64>, at_rest: &Self) -> [Vector<f64>; 2] {
        let way = at_rest.position - self.position + at_rest.rotation.apply(point);
        [way, -self.velocity].map(|v| self.rotation.apply_transposed(v))
    }

    /// Axes fixed in the world, relative to this base. `axes` are given relative to the base at rest.
    pub(crate) fn sees_axes(&self, axes: Rotation<f64>, at_rest: &Self) -> Rotation<f64> {
        let seen = |v: Vector<f64>| self.rotation.apply_transposed(at_rest.rotation.apply(v));
        Rotation { x: seen(axes.x), y: seen(axes.y), z: seen(axes.z) }
    }

    /// A base whose state is not known yet: NaN.
    pub(crate) fn unknown(&self) -> Self {
        let nan = Vector::<f64>::splat([f64::NAN; 3]);
        Self {
            position: nan,
            rotation: Rotation { x: nan, y: nan, z: nan },
            velocity: nan,
            acceleration: nan,
            angular_velocity: nan,
            angular_acceleration: nan,
        }
    }
}

/// A compiled motion of the base.
#[derive(Clone, Debug)]
pub(crate) struct MovingBase {
    position: Vector<f64>,
    orientation: Quaternion<f64>,
    translation: Smooth<3>,
    rotation: Turn,
}

#[derive(Clone, Debug)]
enum Turn {
    About { axis: Vector<f64>, angle: Smooth<1> },
    By(Smooth<4>),
}

impl MovingBase {
    /// Compiles a valid motion of the base of a rod.
    pub(crate) fn new(motion: &BaseMotion, position: [f64; 3], orientation: [f64; 4]) -> Self {
        let rotation = match &motion.rotation {
            BaseRotation::About { axis, angle } => {
                let axis: Vector<f64> = (*axis).into();
                Turn::About { axis: axis * (1.0 / axis.dot(axis).sqrt()), angle: Smooth::new(angle) }
            }
            BaseRotation::By(Signal::Table(table)) => Turn::By(Smooth::of_table(&on_one_side(table))),
            BaseRotation::By(quaternion) => Turn::By(Smooth::new(quaternion)),
        };
        Self {
            position: position.into(),
            orientation: Quaternion::from_array(orientation),
            translation: Smooth::new(&motion.translation),
            rotation,
        }
    }

    /// State of the base at a time; where its velocity jumps, that before the jump, unless `t` is the time that
    /// was passed.
    pub(crate) fn at(&self, t: f64, step_context: StepContext) -> Result<Base, Interrupted> {
        let [displacement, velocity, acceleration] = self.translation.motion(t, step_context)?;
        let (turn, angular_velocity, angular_acceleration) = self.turn(t, step_context)?;
        Ok(Base {
            position: self.position + displacement.into(),
            rotation: turn.times(self.orientation).normalised().rotation(),
            velocity: velocity.into(),
            acceleration: acceleration.into(),
            angular_velocity,
            angular_acceleration,
        })
    }

    /// Displacement and rotation vector at a time, with their first two derivatives.
    pub(crate) fn coordinates(&self, t: f64, step_context: StepContext) -> Result<Motion<6>, Interrupted> {
        let displacement = self.translation.motion(t, step_context)?;
        let (turn, angular_velocity, angular_acceleration) = self.turn(t, step_context)?;
        let turn = turn.times(self.orientation).normalised();
        let rotation = rotation_vector_motion(turn, angular_velocity, angular_acceleration);
        let position: [f64; 3] = self.position.to_array();
        Ok(std::array::from_fn(|order| {
            let of_rotation = rotation[order].to_array();
            std::array::from_fn(|i| match i {
                0..3 => displacement[order][i] + if order == 0 { position[i] } else { 0.0 },
                _ => of_rotation[i - 3],
            })
        }))
    }

    /// The additional rotation, its angular velocity and its angular acceleration.
    fn turn(&self, t: f64, step_context: StepContext) -> Result<Turned, Interrupted> {
        Ok(match &self.rotation {
            Turn::About { axis, angle } => {
                let [[angle], [rate], [acceleration]] = angle.motion(t, step_context)?;
                (Quaternion::exp(*axis * angle), *axis * rate, *axis * acceleration)
            }
            Turn::By(quaternion) => turning(quaternion.motion(t, step_context)?),
        })
    }
}

/// The same orientations, with signs such that successive quaternions are close to each other.
fn on_one_side(table: &Table<4>) -> Table<4> {
    let mut values = table.values().to_vec();
    for i in 0..values.len() {
        values[i] = if i == 0 { values[0] } else { nearer(values[i - 1], values[i]) };
        let norm = dot(&values[i], &values[i]).sqrt();
        values[i] = values[i].map(|x| x / norm);
    }
    let same = Table::new(table.times().to_vec(), values).expect("signs and norms spoil no table");
    same.interpolated(table.interpolation())
}

/// A quaternion (w, x, y, z) with its first two derivatives, from angular velocity w and angular acceleration in
/// world axes: `q' = w q / 2`.
pub fn quaternion_motion(quaternion: [f64; 4], angular: [[f64; 3]; 2]) -> Motion<4> {
    let half = |q: Quaternion<f64>, w: [f64; 3]| Quaternion { w: 0.0, v: Vector::from(w) * 0.5 }.times(q);
    let [w, x, y, z] = quaternion;
    let q = Quaternion { w, v: Vector { x, y, z } };
    let rate = half(q, angular[0]);
    let (with_acceleration, with_velocity) = (half(q, angular[1]), half(rate, angular[0]));
    let acceleration =
        Quaternion { w: with_acceleration.w + with_velocity.w, v: with_acceleration.v + with_velocity.v };
    [q, rate, acceleration].map(|Quaternion { w, v }| [w, v.x, v.y, v.z])
}

/// A rotation, its angular velocity and its angular acceleration.
type Turned = (Quaternion<f64>, Vector<f64>, Vector<f64>);

/// Rotation, angular velocity and angular acceleration of a quaternion that need not be normalised: `w = 2
/// vec(q' q*) / |q|^2`.
fn turning([q, rate, acceleration]: Motion<4>) -> Turned {
    let square = dot(&q, &q);
    let split = |[w, x, y, z]: [f64; 4]| (w, Vector { x, y, z });
    let (w, v) = split(q);
    // The vector part of the product with the conjugate of q.
    let with_conjugate = |other: [f64; 4]| {
        let (a, b) = split(other);
        (b * w - v * a - b.cross(v)) * (2.0 / square)
    };
    let angular = with_conjugate(rate);
    let stretching = 2.0 * dot(&q, &rate) / square;
    (Quaternion::from_array(q), angular, with_conjugate(acceleration) - angular * stretching)
}
