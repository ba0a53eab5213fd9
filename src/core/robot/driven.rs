//! Driven joints: all coordinates of joints and rods from the robot's independent ones.
//!
//! All coordinates are `q_all = G q + o(t)`: each one is independent, or a multiple of another joint's
//! coordinate plus an offset, or prescribed in time. G is constant, so that `v_all = G v + o'`, `a_all = G
//! a + o''`, and by virtual work `tau = G^T tau_all`: tangents and mass matrices are `G^T K_all G`, Jacobians
//! `J_all G`. The sweeps treat all coordinates alike; robots without driven joints skip this step.

use super::description::{Driven, Robot, origin};
use crate::description::signal::StepContext;
use crate::description::world::base_motion::MovingBase;
use crate::description::world::smooth::Smooth;
use crate::error::Interrupted;
use crate::numerics::linalg::Matrix;

/// Map from the robot's independent coordinates to all coordinates, and its transpose for dual quantities.
#[derive(Clone, Debug)]
pub(crate) struct Coordinates(Option<Box<Reduction>>);

/// G and o, with memory for quantities in all coordinates.
#[derive(Clone, Debug)]
struct Reduction {
    /// Indices of the independent coordinates among all.
    own: Vec<usize>,
    /// The inverse map; for dependent coordinates, the number of independent ones before them.
    before: Vec<usize>,
    multiples: Vec<Multiple>,
    prescribed: Vec<Prescribed>,
    varies_in_time: bool,
    time: f64,
    /// How prescribed motions are evaluated.
    step_context: StepContext,
    /// o and its first two derivatives.
    offset: [Vec<f64>; 3],
    /// Coordinates, velocities and accelerations.
    state: [Vec<f64>; 3],
    forces: Vec<f64>,
    matrix: Matrix,
}

/// A coordinate that is proportional to an independent one.
#[derive(Clone, Copy, Debug)]
struct Multiple {
    place: usize,
    of: usize,
    factor: f64,
}

/// Prescribed coordinates.
#[derive(Clone, Debug)]
enum Prescribed {
    /// A coordinate, or `factor` times the signal plus `offset`.
    Coordinate { place: usize, signal: Smooth<1>, factor: f64, offset: f64 },
    /// The six coordinates of a free joint.
    Base { first: usize, motion: MovingBase },
}

impl Coordinates {
    /// Coordinates of a valid robot.
    pub(crate) fn new(robot: &Robot) -> Self {
        if robot.links.iter().all(|link| link.driven.is_none()) {
            return Self(None);
        }
        let (mut own, mut before, mut firsts) = (Vec::new(), Vec::new(), Vec::new());
        for link in &robot.links {
            firsts.push(before.len());
            let of_joint = link.joint.coordinates().len();
            let of_rod = link.coordinates() - link.joint_coordinates().len();
            for k in 0..of_joint + of_rod {
                let place = before.len();
                before.push(own.len());
                if link.driven.is_none() || k >= of_joint {
                    own.push(place);
                }
            }
        }
        let all = before.len();
        let mut reduction = Reduction {
            multiples: Vec::new(),
            prescribed: Vec::new(),
            varies_in_time: robot
                .links
                .iter()
                .filter_map(|link| link.driven.as_ref())
                .any(Driven::varies_in_time),
            time: f64::NAN,
            step_context: StepContext::EXACT,
            offset: [(); 3].map(|()| vec![0.0; all]),
            state: [(); 3].map(|()| vec![0.0; all]),
            forces: vec![0.0; all],
            matrix: Matrix::zeros(all, all),
            own,
            before,
        };
        for (i, place) in firsts.iter().copied().enumerate() {
            reduction.drive(robot, i, place, &firsts);
        }
        reduction.begin();
        Self(Some(Box::new(reduction)))
    }

    /// Whether there are dependent or prescribed coordinates.
    pub(crate) fn are_driven(&self) -> bool {
        self.0.is_some()
    }

    /// Whether any coordinate depends on time explicitly.
    pub(crate) fn vary_in_time(&self) -> bool {
        self.0.as_ref().is_some_and(|reduction| reduction.varies_in_time)
    }

    /// Number of independent coordinates among `all`.
    pub(crate) fn own(&self, all: usize) -> usize {
        self.0.as_ref().map_or(all, |reduction| reduction.own.len())
    }

    /// Whether all coordinates are independent.
    pub(crate) fn are_own(&self) -> bool {
        self.0.is_none()
    }

    /// Evaluates prescribed coordinates at a time. If a function of time fails, no time is set.
    pub(crate) fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        match &mut self.0 {
            Some(reduction) if reduction.varies_in_time && reduction.time != t => reduction.set_time(t),
            _ => Ok(()),
        }
    }

    /// The same with the change of prescribed velocities at this time added to prescribed accelerations.
    pub(crate) fn set_time_in_jump(&mut self, t: f64) -> Result<(), Interrupted> {
        let Some(reduction) = self.0.as_mut().filter(|reduction| reduction.varies_in_time) else {
            return Ok(());
        };
        let passed = std::mem::replace(&mut reduction.step_context.passed, t);
        let after = reduction.set_time(t).map(|()| reduction.offset[1].clone());
        reduction.step_context.passed = passed;
        let after = after?;
        reduction.set_time(t)?;
        // Not the motion at this time: it must be set again.
        reduction.time = f64::NAN;
        let [_, before, accelerations] = &mut reduction.offset;
        for (acceleration, (after, before)) in accelerations.iter_mut().zip(after.iter().zip(&*before)) {
            *acceleration += after - before;
        }
        Ok(())
    }

    /// From now on, prescribed velocities at `t` are those after a jump.
    pub(crate) fn pass_jump(&mut self, t: f64) {
        if let Some(reduction) = &mut self.0 {
            (reduction.step_context.passed, reduction.time) = (t, f64::NAN);
        }
    }

    /// From now on, prescribed velocities are means over this many seconds; see [`StepContext`].
    pub(crate) fn mean_rates_over(&mut self, seconds: f64) {
        if let Some(reduction) = &mut self.0 {
            (reduction.step_context.mean_over, reduction.time) = (seconds, f64::NAN);
        }
    }

    /// Appends prescribed coordinates of joints with one, and those of bases that shift, with their first two derivatives.
    pub(crate) fn prescribed(&self, to: &mut Vec<[f64; 3]>) {
        let Some(reduction) = self.0.as_ref().filter(|reduction| reduction.varies_in_time) else { return };
        for coordinate in &reduction.prescribed {
            let places = match coordinate {
                Prescribed::Coordinate { place, .. } => *place..place + 1,
                Prescribed::Base { first, .. } => *first..first + 3,
            };
            to.extend(places.map(|place| [0, 1, 2].map(|order| reduction.offset[order][place])));
        }
    }

    /// Calls with all coordinates, and with velocities and accelerations if given.
    #[inline(always)]
    pub(crate) fn all<const N: usize, T>(
        &mut self,
        own: [&[f64]; N],
        of_all: impl FnOnce([&[f64]; N]) -> T,
    ) -> T {
        match &mut self.0 {
            None => of_all(own),
            Some(reduction) => {
                reduction.expand(&own);
                of_all(std::array::from_fn(|order| &reduction.state[order][..]))
            }
        }
    }

    /// All coordinates, with zeros for those that are not independent, for queries without a time.
    pub(crate) fn only_own<'a>(&'a mut self, q: &'a [f64]) -> &'a [f64] {
        let Some(reduction) = &mut self.0 else { return q };
        let all = &mut reduction.state[0];
        all.fill(0.0);
        for (&place, x) in reduction.own.iter().zip(q) {
            all[place] = *x;
        }
        all
    }

    /// Marks the independent coordinates that move these among all.
    pub(crate) fn mark_movers(&self, own: &mut [bool], moved: impl Iterator<Item = usize>) {
        for place in moved {
            match &self.0 {
                None => own[place] = true,
                Some(reduction) => reduction.mark_movers(own, place),
            }
        }
    }

    /// Generalised forces, `G^T tau_all`.
    #[inline(always)]
    pub(crate) fn forces<const N: usize, T>(
        &mut self,
        own: [&[f64]; N],
        tau: &mut [f64],
        of_all: impl FnOnce([&[f64]; N], &mut [f64]) -> T,
    ) -> T {
        match &mut self.0 {
            None => of_all(own, tau),
            Some(reduction) => {
                reduction.expand(&own);
                let Reduction { state, forces, own, multiples, .. } = &mut **reduction;
                let result = of_all(std::array::from_fn(|order| &state[order][..]), forces);
                for (tau, &place) in tau.iter_mut().zip(&*own) {
                    *tau = forces[place];
                }
                for &Multiple { place, of, factor } in &*multiples {
                    tau[of] += factor * forces[place];
                }
                result
            }
        }
    }

    /// Several generalised forces as rows, `G^T T_all`. Allocates.
    pub(crate) fn rows<const N: usize>(
        &mut self,
        own: [&[f64]; N],
        forces: &mut Matrix,
        of_all: impl FnOnce([&[f64]; N], &mut Matrix),
    ) {
        match &mut self.0 {
            None => of_all(own, forces),
            Some(reduction) => {
                reduction.expand(&own);
                let Reduction { state, own, multiples, before, .. } = &mut **reduction;
                let mut all = Matrix::zeros(before.len(), forces.ncols());
                of_all(std::array::from_fn(|order| &state[order][..]), &mut all);
                for j in 0..forces.ncols() {
                    for (i, &place) in own.iter().enumerate() {
                        forces[(i, j)] = all[(place, j)];
                    }
                    for &Multiple { place, of, factor } in &*multiples {
                        forces[(of, j)] += factor * all[(place, j)];
                    }
                }
            }
        }
    }

    /// A tangent or mass matrix, `G^T K_all G`.
    #[inline(always)]
    pub(crate) fn matrix<const N: usize>(
        &mut self,
        own: [&[f64]; N],
        matrix: &mut Matrix,
        of_all: impl FnOnce([&[f64]; N], &mut Matrix),
    ) {
        match &mut self.0 {
            None => of_all(own, matrix),
            Some(reduction) => {
                reduction.expand(&own);
                let Reduction { state, matrix: all, .. } = &mut **reduction;
                of_all(std::array::from_fn(|order| &state[order][..]), all);
                reduction.reduce(matrix);
            }
        }
    }

    /// Derivatives of a quantity with respect to the coordinates, `J_all G`. Allocates.
    pub(crate) fn columns(
        &mut self,
        q: &[f64],
        jacobian: &mut Matrix,
        of_all: impl FnOnce(&[f64], &mut Matrix),
    ) {
        match &mut self.0 {
            None => of_all(q, jacobian),
            Some(reduction) => {
                reduction.expand(&[q]);
                let mut all = Matrix::zeros(jacobian.nrows(), reduction.before.len());
                of_all(&reduction.state[0], &mut all);
                *jacobian = self.own_columns(all);
            }
        }
    }

    /// `J_all G`. Allocates.
    pub(crate) fn own_columns(&self, all: Matrix) -> Matrix {
        let Some(reduction) = &self.0 else { return all };
        let mut own = all.select_columns(&reduction.own);
        for &Multiple { place, of, factor } in &reduction.multiples {
            own.column_mut(of).axpy(factor, &all.column(place), 1.0);
        }
        own
    }

    /// Power of the forces that drive the prescribed coordinates, `tau_all . o'`.
    pub(crate) fn power(
        &mut self,
        own: [&[f64]; 3],
        inverse_dynamics: impl FnOnce([&[f64]; 3], &mut [f64]),
    ) -> f64 {
        let Some(reduction) = self.0.as_mut().filter(|reduction| reduction.varies_in_time) else {
            return 0.0;
        };
        reduction.expand(&own);
        let Reduction { state, forces, offset, .. } = &mut **reduction;
        inverse_dynamics(std::array::from_fn(|order| &state[order][..]), forces);
        forces.iter().zip(&offset[1]).map(|(force, velocity)| force * velocity).sum()
    }

    /// Selects the flags of independent coordinates. Allocates.
    pub(crate) fn own_of(&self, all: &[bool]) -> Vec<bool> {
        self.0
            .as_ref()
            .map_or_else(|| all.to_vec(), |reduction| reduction.own.iter().map(|&k| all[k]).collect())
    }

    /// Selects the values of independent coordinates from values for all.
    pub(crate) fn pick(&self, values: &mut [f64], of_all: impl FnOnce(&mut [f64])) {
        match &self.0 {
            None => of_all(values),
            Some(reduction) => {
                let mut all = vec![0.0; reduction.before.len()];
                of_all(&mut all);
                for (value, &place) in values.iter_mut().zip(&reduction.own) {
                    *value = all[place];
                }
            }
        }
    }

    /// `G^T K_all G` of a matrix in all coordinates. Allocates.
    pub(crate) fn reduced(&mut self, all: Matrix) -> Matrix {
        let Some(reduction) = &mut self.0 else { return all };
        let mut reduced = Matrix::zeros(reduction.own.len(), reduction.own.len());
        reduction.matrix = all;
        reduction.reduce(&mut reduced);
        reduced
    }
}

impl Reduction {
    /// Marks the independent coordinates that move this one among all.
    fn mark_movers(&self, own: &mut [bool], place: usize) {
        let multiples = self.multiples.iter().filter(|multiple| multiple.place == place);
        multiples.for_each(|multiple| own[multiple.of] = true);
        if let Ok(independent) = self.own.binary_search(&place) {
            own[independent] = true;
        }
    }

    /// Adds the source of a driven link whose coordinates begin at `place`.
    fn drive(&mut self, robot: &Robot, link: usize, place: usize, firsts: &[usize]) {
        match &robot.links[link].driven {
            None => {}
            Some(Driven::Base(motion)) => {
                let motion = MovingBase::new(motion, [0.0; 3], [1.0, 0.0, 0.0, 0.0]);
                self.prescribed.push(Prescribed::Base { first: place, motion });
            }
            Some(_) => {
                let origin = origin(&robot.links, link).expect("a valid robot's mimics end somewhere");
                let (factor, offset) = (origin.factor, origin.offset);
                if let Some(Driven::Coordinate(signal)) = &robot.links[origin.link].driven {
                    let signal = Smooth::new(signal);
                    self.prescribed.push(Prescribed::Coordinate { place, signal, factor, offset });
                } else {
                    let of = self.before[firsts[origin.link]];
                    self.multiples.push(Multiple { place, of, factor });
                    self.offset[0][place] = offset;
                }
            }
        }
    }

    /// Before a time is set, prescribed coordinates are unknown unless they are constant.
    fn begin(&mut self) {
        if !self.varies_in_time && self.set_time(0.0).is_ok() {
            return;
        }
        let Self { prescribed, offset, .. } = self;
        for coordinate in prescribed.iter() {
            let places = match coordinate {
                Prescribed::Coordinate { place, .. } => *place..place + 1,
                Prescribed::Base { first, .. } => *first..first + 6,
            };
            for offset in offset.iter_mut() {
                offset[places.clone()].fill(f64::NAN);
            }
        }
    }

    fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        self.time = f64::NAN;
        let Self { prescribed, offset, step_context, .. } = self;
        for coordinate in prescribed.iter() {
            match coordinate {
                Prescribed::Coordinate { place, signal, factor, offset: constant } => {
                    let motion = signal.motion(t, *step_context)?;
                    for (order, offset) in offset.iter_mut().enumerate() {
                        offset[*place] = factor * motion[order][0];
                    }
                    offset[0][*place] += constant;
                }
                Prescribed::Base { first, motion } => {
                    let motion = motion.coordinates(t, *step_context)?;
                    for (offset, motion) in offset.iter_mut().zip(&motion) {
                        offset[*first..first + 6].copy_from_slice(motion);
                    }
                }
            }
        }
        self.time = t;
        Ok(())
    }

    /// `q_all = G q + o`, and its derivatives.
    fn expand(&mut self, own: &[&[f64]]) {
        for ((all, own), offset) in self.state.iter_mut().zip(own).zip(&self.offset) {
            all.copy_from_slice(offset);
            for (&place, x) in self.own.iter().zip(*own) {
                all[place] = *x;
            }
            for &Multiple { place, of, factor } in &self.multiples {
                all[place] += factor * own[of];
            }
        }
    }

    /// `G^T K_all G` of the matrix in memory, column by column and row by row.
    fn reduce(&mut self, reduced: &mut Matrix) {
        let Self { own, multiples, matrix: all, .. } = self;
        let n = all.nrows();
        for &Multiple { place, of, factor } in &*multiples {
            for i in 0..n {
                all[(i, own[of])] += factor * all[(i, place)];
            }
        }
        for &Multiple { place, of, factor } in &*multiples {
            for j in 0..n {
                all[(own[of], j)] += factor * all[(place, j)];
            }
        }
        for (j, &column) in own.iter().enumerate() {
            for (i, &row) in own.iter().enumerate() {
                reduced[(i, j)] = all[(row, column)];
            }
        }
    }
}
