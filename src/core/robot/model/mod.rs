//! A compiled robot with its working memory: the model that integrators use.

use std::sync::{Arc, OnceLock};

use self::any_sweeps::AnySweeps;
use self::cached::CachedEnergies;
use super::choice::{Kernel, Solve};
use super::description::{Robot, Rod};
use super::driven::Coordinates;
use super::facts;
use super::kernel::elasticity;
use super::kernel::kinematics::Pose;
use super::kernel::momentum::Momentum;
use super::kernel::sizes::Extent;
use super::plan::point::Place;
use super::state::tangent::Tangent;
use crate::description::body::Body;
use crate::description::rod::STRAINS;
use crate::error::Interrupted;
use crate::error::{Checker, InvalidInput};
use crate::model::constraint::one_sided::TAUT;
use crate::model::constraint::{Independent, one_sided};
use crate::model::{
    CollidingParts, Constraint, Dynamics, Energy, Facts, InvalidShape, OneSided as _, Tied as _,
};
use crate::numerics::lie::{Instructions, Plane, Vector};
use crate::numerics::linalg::{Matrix, symmetric_eigen};
use crate::robot::effects;
use crate::robot::effects::actuator::plan::Line;
use crate::robot::effects::contact::query::ReportedTouch;
use crate::robot::effects::loops::explain::explain_redundant;
use crate::robot::effects::loops::{Loop, Tie};
use crate::robot::explain::{Explanation, Multiplications, cost, overloads};

/// Gaps of loops above this part of the length of what they join, or above this difference of cosines, count as open: far
/// above the errors of methods that enforce constraints, and far below visible gaps.
const LARGEST_GAP: f64 = 1e-6;

/// A step into contact that gains more than this part of the kinetic energy does not resolve its impacts: with steps of a tenth of an
/// impact, the error of generalised-alpha is smaller.
const LARGEST_GAIN: f64 = 0.05;

/// The same for bodies at rest, whose kinetic energy is that of errors of steps: the gain must also exceed this part of the energy of
/// the overlaps, which corresponds to a hundredth of the speed of a vibration with that energy.
const AT_REST: f64 = 1e-4;

/// Errors of the backward Euler method are losses, unless its steps are so long for what turns that they say little: those that gain this part of
/// their kinetic and elastic energy are made in parts.
const SMALL_GAIN: f64 = 0.01;

/// One whose end has gained that part is no solution.
const EXPLOSION: f64 = 0.5;

/// A compiled robot, ready for simulation: rods and rigid bodies with joints. Clones share constant data and
/// have separate memory.
#[derive(Clone, Debug)]
pub struct RobotModel {
    sweeps: AnySweeps,
    /// Sweeps of the unloaded robot, if its forces are more than stiffness times coordinates because of
    /// supports.
    unloaded: Option<Box<AnySweeps>>,
    /// Sweeps with one piece per link, created when the wrench transmitted to a merged link is requested.
    apart: Option<Box<AnySweeps>>,
    /// Map from the independent coordinates to all coordinates of the sweeps.
    coordinates: Coordinates,
    solve: Solve,
    /// Estimated on first use.
    multiplications: OnceLock<Multiplications>,
    robot: Arc<Robot>,
    facts: Arc<Facts>,
    /// Places at which accuracy is measured.
    measured_places: Arc<[MeasuredPlace]>,
    /// Values that replace the forces of the supports' springs.
    fixed_spring_forces: Option<Vec<f64>>,
    /// Size of the steps in seconds if it is fixed, zero for adaptive steps, NaN before a run.
    steps: f64,
    /// Times at which adaptive steps end, in addition to those of signals.
    ends: Arc<[f64]>,
    /// Whether the set of taut inextensible tendons is fixed.
    slack_is_kept: bool,
    /// The energies at the ends of the step that is tested for a gain.
    cached: CachedEnergies,
    /// The parts under contact forces.
    colliding_parts: CollidingParts,
}

/// A place of a robot, or an offset from it in its axes.
#[derive(Clone, Debug)]
struct MeasuredPlace {
    place: Place,
    offset: Option<Vector<f64>>,
}

/// Calls a method of the sweeps, whatever their kind.
macro_rules! on_sweeps {
    ($model:expr, $sweeps:ident => $call:expr) => {
        match $model {
            AnySweeps::Planar($sweeps) => $call,
            AnySweeps::Spatial($sweeps) => $call,
            #[cfg(portable)]
            AnySweeps::PortablePlanar($sweeps) => $call,
            #[cfg(portable)]
            AnySweeps::PortableSpatial($sweeps) => $call,
        }
    };
}

mod any_sweeps;
mod cached;
mod contact;
mod dynamics;
mod elastic;
mod refine;
mod ties;
mod time;

impl RobotModel {
    /// Compiles a robot for the simplest kernel, the best instruction set of this machine and the cheapest
    /// solver. An invalid robot is rejected with all its problems.
    pub fn new(robot: &Robot) -> Result<Self, InvalidInput> {
        robot.validate()?;
        Self::of_valid(robot)
    }

    /// Compiles a robot that has been found valid. Problems that only the compiled robot shows are rejected.
    #[doc(hidden)]
    pub fn of_valid(robot: &Robot) -> Result<Self, InvalidInput> {
        Self::compiled(robot, Kernel::plane(robot), Some(Instructions::of_machine()), None)
    }

    /// Compiles a rod as a robot with one link.
    pub fn of_rod(rod: &Rod) -> Result<Self, InvalidInput> {
        rod.validate()?;
        Self::new(&rod.into())
    }

    /// Compiles a robot with a given solver, for comparisons.
    pub fn with_solve(robot: &Robot, solve: Solve) -> Result<Self, InvalidInput> {
        robot.validate()?;
        Self::compiled(robot, Kernel::plane(robot), Some(Instructions::of_machine()), Some(solve))
    }

    /// Compiles a rod for the baseline instruction set, for comparisons.
    #[cfg(portable)]
    pub fn portable(rod: &Rod) -> Result<Self, InvalidInput> {
        rod.validate()?;
        let robot = Robot::from(rod);
        Self::compiled(&robot, Kernel::plane(&robot), None, None)
    }

    /// Compiles a robot for the spatial kernel, even if it is planar, for comparisons.
    pub fn spatial(robot: &Robot) -> Result<Self, InvalidInput> {
        robot.validate()?;
        Self::compiled(robot, None, Some(Instructions::of_machine()), None)
    }

    /// Compiles a robot for the spatial kernel without skipping anything, including zeros, for comparisons.
    pub fn with_nothing_skipped(robot: &Robot) -> Result<Self, InvalidInput> {
        robot.validate()?;
        check_machine()?;
        let sweeps =
            AnySweeps::new(robot, None, Instructions::of_machine().has_fused()).with_nothing_skipped();
        Self::with(robot, sweeps, None)
    }

    /// Compiles a valid robot, in the given plane if any, with the given instructions and solver or, by
    /// default, the cheapest solver.
    fn compiled(
        robot: &Robot,
        plane: Option<Plane>,
        instructions: Option<Instructions>,
        solve: Option<Solve>,
    ) -> Result<Self, InvalidInput> {
        check_machine()?;
        let is_fused = instructions.is_some_and(|instructions| instructions.has_fused());
        Self::with(robot, AnySweeps::new(robot, plane, is_fused), solve)
    }

    fn with(robot: &Robot, sweeps: AnySweeps, solve: Option<Solve>) -> Result<Self, InvalidInput> {
        on_sweeps!(&sweeps, sweeps => effects::contact::compile::check(robot, sweeps.plan()))?;
        let coordinates = Coordinates::new(robot);
        let solve = match coordinates.are_driven() {
            // Joints that mimic others couple branches.
            true => Solve::Dense,
            false if on_sweeps!(&sweeps, sweeps => effects::couple_pieces(sweeps.plan())) => Solve::Dense,
            false => solve.unwrap_or_else(|| Solve::cheapest(robot)),
        };
        let unloaded = (!robot.supports.is_empty()).then(|| Box::new(sweeps.with_robot(&robot.unloaded())));
        let mut facts = on_sweeps!(&sweeps, sweeps => facts::of(robot, sweeps, &coordinates));
        if !sweeps.follow_lengths() {
            facts.free_lengths = 0;
        }
        let mut model = Self {
            sweeps,
            unloaded,
            apart: None,
            coordinates,
            solve,
            multiplications: OnceLock::new(),
            robot: Arc::new(robot.clone()),
            facts: Arc::new(facts),
            measured_places: Arc::new([]),
            fixed_spring_forces: None,
            steps: f64::NAN,
            ends: Arc::new([]),
            slack_is_kept: false,
            cached: CachedEnergies::default(),
            colliding_parts: CollidingParts::default(),
        };
        model.check_inertia()?;
        model.measured_places = model.measured_places_of_links().into();
        Ok(model)
    }

    /// Places for [`Dynamics::places`] on links with a rod or a body; the tip of the robot if there are none. If
    /// loops may hold tips, also the middles of rods.
    fn measured_places_of_links(&self) -> Vec<MeasuredPlace> {
        let mut measured_places = Vec::new();
        for (i, link) in self.robot.links.iter().enumerate() {
            let place = self.place_on(i, None);
            if let Some(body) = &link.body {
                let radius = (0.5 * (0..3).map(|k| body.inertia[k][k]).sum::<f64>() / body.mass).sqrt();
                let directions = if radius.is_finite() && radius > 0.0 { 0..3 } else { 0..1 };
                let radius = if radius.is_finite() { radius } else { 0.0 };
                measured_places.extend(directions.map(|k| {
                    let offset = std::array::from_fn(|i| body.centre[i] + if i == k { radius } else { 0.0 });
                    MeasuredPlace { place: place.clone(), offset: Some(offset.into()) }
                }));
            } else if !link.rod.is_empty() {
                measured_places.push(MeasuredPlace { place, offset: None });
                if !self.robot.loops.is_empty() {
                    let middle = self.place_on(i, Some(0.5 * link.length()));
                    measured_places.push(MeasuredPlace { place: middle, offset: None });
                }
            }
        }
        if measured_places.is_empty() {
            measured_places.push(MeasuredPlace { place: self.tip_place(), offset: None });
        }
        measured_places
    }

    /// All bodies with their extents.
    fn bodies(&self) -> Vec<Extent> {
        let of_body = |body: Body| Extent { place: self.place_on(body.link, body.at), own: body.extent() };
        self.robot.all_bodies().map(of_body).collect()
    }

    /// Rejects joints that move nothing with inertia, for which accelerations do not exist. Checked in a
    /// state in which no two axes are aligned by chance.
    fn check_inertia(&mut self) -> Result<(), InvalidInput> {
        let robot = Arc::clone(&self.robot);
        if robot.links.iter().all(|link| link.joint_coordinates().is_empty()) {
            return Ok(());
        }
        let all = on_sweeps!(&self.sweeps, sweeps => sweeps.plan().n);
        let q: Vec<f64> = (0..all).map(|k| 0.1 + 0.05 * (k as f64).sin()).collect();
        let mut mass = Matrix::zeros(all, all);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.mass_matrix(&q, Tangent::Dense(&mut mass)));
        let mass = self.coordinates.reduced(mass);
        let mut check = Checker::new();
        let names = robot.coordinate_names();
        let joined = robot.links.iter().enumerate().filter(|(_, link)| !link.joint_coordinates().is_empty());
        for (i, link) in joined {
            let own = robot.coordinates_of(i).start;
            let mut coordinates: Vec<usize> = (own..own + link.joint_coordinates().len()).collect();
            // The axis may be aligned with that of a preceding joint.
            let carriers = std::iter::successors(link.parent, |&parent| robot.links[parent].parent);
            let moves = |&parent: &usize| !robot.links[parent].joint_coordinates().is_empty();
            if let Some(before) = carriers.into_iter().find(moves) {
                let first = robot.coordinates_of(before).start;
                coordinates.extend(first..first + robot.links[before].joint_coordinates().len());
            }
            let without: Vec<&str> =
                without_inertia(&mass, &coordinates).into_iter().map(|k| names[k].as_str()).collect();
            check.require(
                without.is_empty(),
                &format!("links[{i}].joint"),
                format_args!("no inertia against a motion of {}", without.join(", ")),
                "a mass off the axis, an inertia about it, or an armature",
            );
            if !without.is_empty() {
                // Joints beyond may only be a consequence.
                break;
            }
        }
        check.finish()
    }

    /// Moves the unloaded robot, if it is present, to the pose of the base, at rest.
    fn place_unloaded(&mut self) {
        let Some(unloaded) = self.unloaded.as_deref_mut() else { return };
        if self.robot.base_motion.is_some() {
            let base = on_sweeps!(&self.sweeps, sweeps => sweeps.base());
            on_sweeps!(&mut *unloaded, sweeps => sweeps.place_base(&base));
            // Anchors were recomputed for this pose.
            on_sweeps!(&mut *unloaded, sweeps => sweeps.hold_springs(self.fixed_spring_forces.as_deref()));
        }
    }

    /// The description from which the model was compiled.
    pub fn description(&self) -> &Robot {
        &self.robot
    }

    /// Explains what is computed, what is skipped, and why. Allocates.
    pub fn explanation(&self) -> Explanation {
        let Self { sweeps, solve, robot, facts, .. } = self;
        let cost = self.multiplications();
        on_sweeps!(sweeps, typed => {
            let plan = typed.plan();
            let (links, actuators) = (cost::of_links(plan, *solve), cost::of_actuators(plan));
            let (nodes, loops) = (plan.nodes(), cost::of_loops(plan));
            Explanation::new(robot, facts, sweeps.kernel(), *solve, &nodes, &cost, &links, &actuators, &loops)
        })
    }

    /// The explanation including redundant constraints of loops that are closed at zero coordinates. Without
    /// base or joint motions in time, because only then this shape is unique.
    pub fn full_explanation(&mut self) -> Explanation {
        let mut explanation = self.explanation();
        let rest = vec![0.0; self.robot.coordinates()];
        if self.facts.constraints() > 0 && !self.facts.varies_in_time && self.open_loop(&rest).is_none() {
            let redundant = self.redundant_constraints(&rest);
            let (is_computed, what, why) = explain_redundant(&self.robot, &redundant);
            explanation.add(is_computed, what, why);
        }
        explanation
    }

    /// Estimated numbers of multiplications of each kind of evaluation.
    pub fn multiplications(&self) -> Multiplications {
        *self.multiplications.get_or_init(
            || on_sweeps!(&self.sweeps, sweeps => cost::multiplications(sweeps.plan(), self.solve)),
        )
    }

    /// The kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.sweeps.kernel()
    }

    /// The solver of linear systems.
    pub fn solve(&self) -> Solve {
        self.solve
    }

    /// Quadrature nodes of each segment.
    pub fn nodes(&self) -> Vec<usize> {
        on_sweeps!(&self.sweeps, sweeps => sweeps.plan().nodes())
    }

    /// Pose at arc length `x` of the first link's unstretched rod, clamped to [0, L]: body axes and position
    /// in the world.
    pub fn pose(&mut self, q: &[f64], x: f64) -> Pose {
        self.pose_at(q, &self.place(x))
    }

    /// Place at arc length `x` of the first link's unstretched rod, clamped to [0, L], for [`Self::pose_at`].
    pub fn place(&self, x: f64) -> Place {
        self.place_on(0, Some(x))
    }

    /// Place on a link: at arc length `x` of its unstretched rod, clamped to [0, L], or at its tip; for a
    /// rigid link its base, for any `x`.
    pub fn place_on(&self, link: usize, x: Option<f64>) -> Place {
        on_sweeps!(&self.sweeps, sweeps => sweeps.place(link, x))
    }

    /// Place of [`Dynamics::tip`]: the tip of the last link.
    fn tip_place(&self) -> Place {
        self.place_on(self.robot.links.len() - 1, None)
    }

    /// Tips of all rods.
    pub fn tips_of_rods(&self) -> Vec<Place> {
        let rods = (0..self.robot.links.len()).filter(|&link| !self.robot.links[link].rod.is_empty());
        rods.map(|link| self.place_on(link, None)).collect()
    }

    /// Ends of equal parts of all segments, this many of each.
    pub fn places_along_rods(&self, parts: usize) -> Vec<Place> {
        let mut places = Vec::new();
        for (link, described) in self.robot.links.iter().enumerate() {
            let mut start = 0.0;
            for segment in &described.rod {
                let ends = (1..=parts).map(|i| start + segment.length * (i as f64 / parts as f64));
                places.extend(ends.map(|x| self.place_on(link, Some(x))));
                start += segment.length;
            }
        }
        places
    }

    /// Pose of a place of this robot. Several places in the same state cost little more than one.
    pub fn pose_at(&mut self, q: &[f64], place: &Place) -> Pose {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.pose(q, place)))
    }

    /// Moment and force that the base exerts on the rod in a motion, about the base and in world axes; for a
    /// planar robot the components in its plane.
    pub fn base_wrench(&mut self, q: &[f64], qd: &[f64], qdd: &[f64]) -> [Vector<f64>; 2] {
        self.with_loops_held([q, qd, qdd], |model| {
            let Self { sweeps, coordinates, .. } = model;
            coordinates.all([q, qd, qdd], |state| on_sweeps!(sweeps, sweeps => sweeps.base_wrench(state)))
        })
    }

    /// Moment and force transmitted to a link through its joint in a motion, about the place where the joint
    /// begins and in world axes; for a planar robot the components in its plane.
    pub fn joint_wrench(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], link: usize) -> [Vector<f64>; 2] {
        self.with_loops_held([q, qd, qdd], |model| {
            let Self { sweeps, coordinates, apart, robot, .. } = model;
            let is_one = on_sweeps!(&*sweeps, sweeps => sweeps.plan().pieces_of(link).is_empty());
            let sweeps = if is_one {
                let apart = apart.get_or_insert_with(|| Box::new(sweeps.taken_apart(robot)));
                apart.take_time(sweeps);
                &mut **apart
            } else {
                sweeps
            };
            coordinates
                .all([q, qd, qdd], |state| on_sweeps!(sweeps, sweeps => sweeps.joint_wrench(state, link)))
        })
    }

    /// Strain at a place of a rod, in the order of [`STRAIN_NAMES`](crate::description::rod::STRAIN_NAMES), including the
    /// reference strain.
    pub fn strain_at(&mut self, q: &[f64], place: &Place) -> [f64; STRAINS] {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.strain(q, place)))
    }

    /// Moments and forces in a motion that the part of a rod before each place exerts on what lies beyond,
    /// including bodies and loads at the place: about the section's point and in its axes, from the balance
    /// of everything beyond. For a planar robot the components in its plane. At the base of a link this is
    /// [`Self::joint_wrench`]. The forces of loops are found once for all places.
    pub fn internal_wrenches_at(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        places: &[Place],
    ) -> Vec<[Vector<f64>; 2]> {
        self.with_loops_held([q, qd, qdd], |model| {
            let Self { sweeps, coordinates, .. } = model;
            coordinates.all([q, qd, qdd], |state| {
                let at = |place| on_sweeps!(sweeps, sweeps => sweeps.internal_wrench(state, place));
                places.iter().map(at).collect()
            })
        })
    }

    /// Internal moment and force from the law of the material: minus stiffness times the strain relative to
    /// reference and active strains, minus damping times its rate. Zero for strains without modes. Converges
    /// to the balance as the number of modes increases, except for forces of embedded tendons and chambers,
    /// which only the balance includes.
    pub fn material_wrench_at(&mut self, q: &[f64], qd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd], |[q, qd]| on_sweeps!(sweeps, sweeps => sweeps.material_wrench(q, qd, place)))
    }

    /// Command of an actuator at the current time and inputs.
    pub fn command(&self, actuator: usize) -> f64 {
        on_sweeps!(&self.sweeps, sweeps => sweeps.commands()[actuator])
    }

    /// Length of an actuator (metres; cubic metres for a chamber; the coordinate for a motor), its rate and
    /// its force (the tension of a tendon; minus the pressure or torque for a chamber or motor). Writes the
    /// gradient of the length.
    pub fn actuator(&mut self, q: &[f64], qd: &[f64], actuator: usize, gradient: &mut [f64]) -> [f64; 3] {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.forces([q, qd], gradient, |[q, qd], gradient| {
            on_sweeps!(sweeps, sweeps => {
                let (numbers, of_all) = sweeps.actuator(q, qd, actuator);
                gradient.copy_from_slice(of_all);
                numbers
            })
        })
    }

    /// Sentences about forces that are absurd for the stiffness of their rods, at a time and with the inputs u, by default those of the
    /// description. Allocates. Only a function of time can fail.
    pub fn overloads(&self, t: f64, u: Option<&[f64]>) -> Result<Vec<String>, Interrupted> {
        overloads(&self.robot, t, u)
    }

    /// The stiffness of every contact: given, of the material or from the loads, in N/m^2 with a rod, otherwise in N/m. Allocates.
    pub fn contact_stiffness(&self) -> Vec<f64> {
        effects::contact::compile::stiffnesses(&self.robot)
    }

    /// Contact points in a state, contact by contact. Allocates.
    pub fn touches(&mut self, q: &[f64], qd: &[f64]) -> Vec<ReportedTouch> {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd], |[q, qd]| on_sweeps!(sweeps, sweeps => sweeps.touches(q, qd)))
    }

    /// Wrench of a contact on its first surface: moment about the world's origin, and force.
    pub fn contact_wrench(&mut self, q: &[f64], qd: &[f64], contact: usize) -> [Vector<f64>; 2] {
        let touches = self.touches(q, qd);
        let own = touches.iter().filter(|touch| touch.contact == contact);
        own.fold([Vector::zero(); 2], |[moment, force], touch| {
            [moment + touch.position.cross(touch.force), force + touch.force]
        })
    }

    /// Forces of closed loops in a motion: moment, about the second end of the loop, and force of the first
    /// end on the second one, in world axes; for a ratio of coordinates, the generalised force on the first
    /// coordinate. If constraints are redundant, the minimum-norm solution. `None` if a number is not finite. Allocates.
    pub fn loop_forces(&mut self, q: &[f64], qd: &[f64], qdd: &[f64]) -> Option<Vec<[f64; 6]>> {
        let mut multipliers = vec![0.0; self.facts.constraints()];
        one_sided::multipliers(self, [q, qd, qdd], &mut multipliers).ok()?;
        let (mut ties, mut gears) = (0, multipliers.len() - self.slack().len() - self.gears());
        let robot = Arc::clone(&self.robot);
        let of_loop = |closed: &Loop| {
            if matches!(closed.tie, Tie::Coordinates { .. }) {
                gears += 1;
                return [-multipliers[gears - 1], 0.0, 0.0, 0.0, 0.0, 0.0];
            }
            ties += 1;
            let Self { sweeps, coordinates, .. } = &mut *self;
            let [moment, force] = coordinates
                .all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.tie_wrench(q, ties - 1, &multipliers)));
            let ([a, b, c], [d, e, f]) = (moment.to_array(), force.to_array());
            [a, b, c, d, e, f]
        };
        Some(robot.loops.iter().map(of_loop).collect())
    }

    /// The energy of a state, and that of the overlaps in it; both are cached.
    fn cached_energy(&mut self, state: [&[f64]; 2]) -> (Energy, f64) {
        if let Some(known) = self.cached.of(state) {
            return (known.energy, known.of_overlaps);
        }
        let energy = self.energy(state[0], state[1]);
        let Self { sweeps, coordinates, cached, .. } = self;
        let of_overlaps = on_sweeps!(&*sweeps, sweeps => sweeps.overlap_energy());
        let is_pushed = cached.store(state, energy, of_overlaps);
        on_sweeps!(&*sweeps, sweeps => coordinates.mark_movers(is_pushed, sweeps.pushed()));
        (energy, of_overlaps)
    }

    /// Calls with the multipliers that a motion requires; zero if they are not determined.
    fn with_loops_held<T>(&mut self, state: [&[f64]; 3], of: impl FnOnce(&mut Self) -> T) -> T {
        if self.facts.constraints() == 0 {
            return of(self);
        }
        let mut multipliers = vec![0.0; self.facts.constraints()];
        // They remain zero if the mass matrix is singular.
        let _ = one_sided::multipliers(self, state, &mut multipliers);
        self.set_multipliers(&multipliers);
        let result = of(self);
        multipliers.fill(0.0);
        self.set_multipliers(&multipliers);
        result
    }

    /// Closed loops of a robot at rest: their contribution to the stiffness, n x n, and the derivatives of
    /// the gaps, m x n.
    pub fn loops_at_rest(&mut self, q: &[f64]) -> [Matrix; 2] {
        let (n, m) = (q.len(), self.facts.constraints());
        let rest = vec![0.0; n];
        let [mut stiffness, mut without, mut jacobian] =
            [Matrix::zeros(n, n), Matrix::zeros(n, n), Matrix::zeros(m, n)];
        self.with_loops_held([q, &rest, &rest], |model| {
            // The multipliers determine which tendons are taut.
            model.gap_jacobian(q, &mut jacobian);
            model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut stiffness);
        });
        self.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut without);
        [stiffness - without, jacobian]
    }

    /// Tension of an inextensible tendon in a motion; without given accelerations, in the free motion. `None`
    /// if the mass matrix is singular. Allocates.
    pub fn held_tension(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: Option<&[f64]>,
        actuator: usize,
    ) -> Option<f64> {
        let mut multipliers = vec![0.0; self.facts.constraints()];
        match qdd {
            Some(qdd) => one_sided::multipliers(self, [q, qd, qdd], &mut multipliers),
            None => one_sided::accelerations(self, q, qd, &mut vec![0.0; q.len()], &mut multipliers),
        }
        .ok()?;
        let tendon = Constraint::Tendon(actuator);
        on_sweeps!(&self.sweeps, sweeps => {
            let row = sweeps.plan().effects.loops.constraints.iter().position(|&by| by == tendon)?;
            Some(multipliers[row])
        })
    }

    /// Indices of slack inextensible tendons in a shape, at the time that is set.
    pub fn slack_tendons(&mut self, q: &[f64]) -> Vec<usize> {
        let rest = vec![0.0; q.len()];
        let passed = self.passed(q, &rest);
        let tendons = on_sweeps!(&self.sweeps, sweeps => sweeps.plan().effects.loops.lengths.clone());
        let is_slack = |&(_, [by, _]): &(usize, [f64; 2])| by < -TAUT;
        tendons.into_iter().zip(passed).filter(is_slack).map(|(i, _)| i).collect()
    }

    /// Number of redundant constraints of every loop, followed by those of every inextensible tendon, in a
    /// shape.
    pub fn redundant_constraints(&mut self, q: &[f64]) -> Vec<usize> {
        let (m, n) = (self.facts.constraints(), q.len());
        let (mut jacobian, mut mass) = (Matrix::zeros(m, n), Matrix::zeros(n, n));
        self.gap_jacobian(q, &mut jacobian);
        self.mass_matrix(q, &mut mass);
        let mut independent = Independent::new(m, n);
        independent.find(
            &jacobian,
            |k| mass[(k, k)].abs().sqrt().max(f64::MIN_POSITIVE).recip(),
            &vec![0; m],
        );
        let loops = self.robot.loops.len();
        let mut redundant = vec![0; loops + self.slack().len()];
        on_sweeps!(&self.sweeps, sweeps => {
            let closed = &sweeps.plan().effects.loops;
            for row in (0..m).filter(|&row| !independent.is_independent(row)) {
                match closed.constraints[row] {
                    Constraint::Loop(i) => redundant[i] += 1,
                    Constraint::Tendon(_) => redundant[loops + row - closed.first_length()] += 1,
                }
            }
        });
        redundant
    }

    /// Number of loops that couple coordinates.
    fn gears(&self) -> usize {
        self.robot.loops.iter().filter(|closed| matches!(closed.tie, Tie::Coordinates { .. })).count()
    }

    /// Whether a tendon has pulled two points together.
    fn collapsed(&mut self, q: &[f64]) -> Option<InvalidShape> {
        let Self { sweeps, coordinates, .. } = self;
        let can_shrink = on_sweeps!(&*sweeps, sweeps => sweeps.plan().effects.actuation.lines.iter().any(Line::can_shrink));
        if !can_shrink {
            return None;
        }
        coordinates.all([q, q], |[q, _]| {
            on_sweeps!(sweeps, sweeps => sweeps.collapsed(q))
                .map(|actuator| InvalidShape::Collapsed { actuator })
        })
    }

    /// Stiffness of rods and joint springs in a shape, n x n: the derivative of their generalised forces,
    /// without supports.
    pub fn stiffness(&mut self, q: &[f64], stiffness: &mut Matrix) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.matrix([q], stiffness, |[q], stiffness| {
            on_sweeps!(&*sweeps, sweeps => elasticity::stiffness(sweeps.plan(), q, stiffness));
        });
    }

    /// Mass, centre of mass and momentum in world axes; for a planar robot the components in its plane.
    pub fn momentum(&mut self, q: &[f64], qd: &[f64]) -> Momentum {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd], |[q, qd]| on_sweeps!(sweeps, sweeps => sweeps.momentum(q, qd)))
    }

    /// Angular velocity of the section at a place and velocity of its point, in world axes, including the
    /// motion of the base.
    pub fn velocity_at(&mut self, q: &[f64], qd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd], |[q, qd]| on_sweeps!(sweeps, sweeps => sweeps.velocity(q, qd, place)))
    }

    /// Angular acceleration of the section at a place and acceleration of its point, in world axes: the time
    /// derivative of [`Self::velocity_at`]. Includes the motion of the base; a body in free fall has the
    /// acceleration of gravity.
    pub fn acceleration_at(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd, qdd], |state| on_sweeps!(sweeps, sweeps => sweeps.acceleration(state, place)))
    }

    /// Jacobian of the pose of a place, 6 x n: angular velocity, and velocity of its point, in world axes,
    /// for unit rates of the coordinates; `Psi = int S`, shifted from the base to the point. Its transpose
    /// maps a moment and a force at the place to generalised forces. The motion of the base is not included.
    /// Costs about one inverse dynamics per few coordinates.
    pub fn jacobian_at(&mut self, q: &[f64], place: &Place, jacobian: &mut Matrix) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.columns(q, jacobian, |q, jacobian| {
            on_sweeps!(sweeps, sweeps => sweeps.jacobian(q, place, jacobian));
        });
    }
}

impl RobotModel {
    /// Which inextensible tendons are slack.
    fn slack(&self) -> Vec<bool> {
        on_sweeps!(&self.sweeps, sweeps => sweeps.slack().to_vec())
    }

    fn set_slack(&mut self, slack: &[bool]) {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.set_slack(slack));
    }

    /// Excess of the lengths of inextensible tendons over the commanded lengths, in metres, and its rates.
    fn excesses(&mut self, q: &[f64], qd: &[f64]) -> Vec<[f64; 2]> {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd], |[q, qd]| on_sweeps!(sweeps, sweeps => sweeps.excesses(q, qd)))
    }

    /// By virtual work: generalised forces that balance a unit of each force.
    fn find_jacobian_of_springs(&mut self, q: &[f64], jacobian: &mut Matrix) {
        self.place_unloaded();
        let length = self.facts.length;
        let Self { sweeps, unloaded, coordinates, fixed_spring_forces, .. } = self;
        let Some(unloaded) = unloaded.as_deref_mut() else { return };
        coordinates.columns(q, jacobian, |q, jacobian| {
            let mut elastic = vec![0.0; q.len()];
            on_sweeps!(&*sweeps, sweeps => elasticity::forces(sweeps.plan(), q, &mut elastic));
            // Forces of the size of elastic forces lose no digits in their sum.
            let size = elastic.iter().fold(0.0, |size: f64, tau| size.max(tau.abs()));
            let moment = if size > 0.0 { size / length } else { 1.0 };
            let mut tau = elastic.clone();
            let mut forces = vec![0.0; jacobian.nrows()];
            for i in 0..forces.len() {
                let unit = if i % 6 < 3 { moment } else { moment / length };
                forces[i] = unit;
                on_sweeps!(&mut *unloaded, sweeps => sweeps.hold_springs(Some(&forces)));
                on_sweeps!(&mut *unloaded, sweeps => sweeps.forces_at_rest(q, &mut tau));
                forces[i] = 0.0;
                for j in 0..q.len() {
                    jacobian[(i, j)] = (elastic[j] - tau[j]) / unit;
                }
            }
        });
        on_sweeps!(unloaded, sweeps => sweeps.hold_springs(fixed_spring_forces.as_deref()));
    }
}

/// The coordinates, of those given, of a motion without inertia, if there is such a motion.
fn without_inertia(mass: &Matrix, coordinates: &[usize]) -> Vec<usize> {
    /// Smallest eigenvalue of a mass matrix with unit diagonal that is not rounding.
    const SMALLEST_EIGENVALUE: f64 = 1e-14;
    /// Smallest relative part in that motion for a coordinate to be named.
    const SMALLEST_PART: f64 = 0.1;
    let scale = |k: usize| mass[(k, k)].sqrt();
    if let Some(&k) = coordinates.iter().find(|&&k| mass[(k, k)] <= 0.0) {
        return vec![k];
    }
    let n = coordinates.len();
    let scaled = Matrix::from_fn(n, n, |i, j| {
        mass[(coordinates[i], coordinates[j])] / (scale(coordinates[i]) * scale(coordinates[j]))
    });
    let Some((values, vectors)) = symmetric_eigen(&scaled) else { return Vec::new() };
    let singular = values.iter().position(|&value| value < SMALLEST_EIGENVALUE);
    let Some(singular) = singular else { return Vec::new() };
    let moves = |&(i, _): &(usize, &usize)| vectors[(i, singular)].abs() > SMALLEST_PART;
    coordinates.iter().enumerate().filter(moves).map(|(_, &k)| k).collect()
}

/// Rejects machines for which this build has no sweeps.
fn check_machine() -> Result<(), InvalidInput> {
    if Instructions::of_machine().are_compiled() {
        return Ok(());
    }
    let expected = "one with AVX2 and FMA, or a build with the feature `portable`";
    Err(InvalidInput::new("this machine", "one without fused multiply-add", expected))
}
