//! Time and inputs of a robot.

use super::{AnySweeps, RobotModel};
use crate::description::signal::{Cell, Jumps};
use crate::error::Interrupted;
use crate::model::{Excitation, InTime};
use crate::numerics::linalg::Matrix;

impl InTime for RobotModel {
    #[inline]
    fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        if !self.facts.varies_in_time {
            return Ok(());
        }
        self.cached.forget();
        self.coordinates.set_time(t)?;
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.set_time(t))
    }

    fn set_inputs(&mut self, u: &[f64]) {
        self.cached.forget();
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.set_inputs(u));
    }

    fn not_finite(&self) -> Option<String> {
        let t = on_sweeps!(&self.sweeps, sweeps => sweeps.time_without_loads())?;
        self.robot.not_finite(t)
    }

    fn input_tangent(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tangent: &mut Matrix) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.rows([q, qd, qdd], tangent, |state, tangent| {
            on_sweeps!(sweeps, sweeps => sweeps.input_tangent(state, tangent));
        });
    }
}

impl Excitation for RobotModel {
    fn horizon(&self, t: f64) -> f64 {
        let next = self.ends.partition_point(|&end| end <= t);
        self.ends.get(next).map_or(f64::INFINITY, |&end| end).min(self.robot.horizon(t))
    }

    fn end_steps_at(&mut self, times: &[f64]) {
        self.ends = times.into();
    }

    fn corner(&self, cell: Cell) -> Option<f64> {
        self.robot.corner(cell)
    }

    fn set_steps(&mut self, dt: f64) {
        self.cached.forget();
        self.steps = dt;
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.set_steps(dt));
    }

    fn jumps(&self) -> Jumps {
        self.robot.jumps(self.steps)
    }

    fn jump_near(&self, t: f64) -> Option<f64> {
        self.robot.jump_near(t, self.steps)
    }

    fn set_time_in_jump(&mut self, t: f64) -> Result<(), Interrupted> {
        self.cached.forget();
        self.coordinates.set_time_in_jump(t)?;
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.set_time_in_jump(t))
    }

    fn pass_jump(&mut self, t: f64) {
        self.cached.forget();
        self.coordinates.pass_jump(t);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.pass_jump(t));
    }

    fn mean_rates_over(&mut self, seconds: f64) {
        self.cached.forget();
        self.coordinates.mean_rates_over(seconds);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.mean_rates_over(seconds));
    }

    fn lag_loads(&mut self, lag: f64) -> bool {
        self.cached.forget();
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.lag_loads(lag))
    }

    fn prescribed(&mut self, to: &mut Vec<[f64; 3]>) {
        self.coordinates.prescribed(to);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.prescribed(to));
    }
}
