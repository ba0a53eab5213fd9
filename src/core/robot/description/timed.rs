//! Time dependence of a robot: prescribed motions, forces and commands.

use super::driven::Driven;
use super::robot::Robot;
use super::signals::{PlacedSignal, SignalOf};
use crate::description::signal::{Cell, Jumps, Signal, Timed};
use crate::description::world::BaseMotion;
use crate::error::Number;

impl Robot {
    /// Sources of driven joints, link by link.
    pub(super) fn driven(&self) -> impl Iterator<Item = &Driven> {
        self.links.iter().filter_map(|link| link.driven.as_ref())
    }

    /// Forces and commands.
    fn signals(&self) -> impl Iterator<Item = &dyn Timed> {
        self.signals_with_places().map(PlacedSignal::timed)
    }

    /// Signals that determine forces directly: all but the lengths of inextensible tendons.
    fn force_signals(&self) -> impl Iterator<Item = &dyn Timed> {
        let follows =
            |placed: &PlacedSignal<'_>| placed.commands.is_none_or(|actuator| !actuator.is_inextensible());
        self.signals_with_places().filter(follows).map(PlacedSignal::timed)
    }

    /// Description of the first force or command that is not finite at a time.
    pub(crate) fn not_finite(&self, t: f64) -> Option<String> {
        self.signals_with_places().find_map(|placed| {
            let value = placed.timed().not_finite(t)?;
            let what = match placed.commands {
                Some(actuator) => format!("the command of actuator \"{}\"", actuator.name()),
                None => placed.place(),
            };
            Some(format!("{what} is {value} at t = {}", Number(t)))
        })
    }

    /// Latest end of a step from `t` that cannot miss a feature of loads and prescribed motions
    /// ([`crate::description::signal::Signal::horizon`]).
    pub fn horizon(&self, t: f64) -> f64 {
        let of_base = self.base_motion.iter().map(|motion| motion.horizon(t));
        let of_joints = self.driven().map(|driven| driven.horizon(t));
        let of_signals = self.signals().map(|signal| signal.horizon(t));
        of_base.chain(of_joints).chain(of_signals).fold(f64::INFINITY, f64::min)
    }

    /// The next time at which a step of fixed size must end, so that it loses nothing of loads, commands and
    /// prescribed motions in tables.
    pub fn corner(&self, cell: Cell) -> Option<f64> {
        let of_base = self.base_motion.iter().filter_map(|motion| motion.corner(cell));
        let of_joints = self.driven().filter_map(|driven| driven.corner(cell));
        let of_signals = self.signals().filter_map(|signal| signal.corner(cell));
        of_base.chain(of_joints).chain(of_signals).reduce(f64::min)
    }

    /// The time at which a prescribed velocity jumps, or for steps of the size `dt` a load or a command, if that is `t` up to
    /// rounding.
    pub fn jump_near(&self, t: f64, dt: f64) -> Option<f64> {
        let of_base = self.base_motion.as_ref().and_then(|motion| motion.jump_near(t));
        of_base
            .or_else(|| self.driven().find_map(|driven| driven.jump_near(t)))
            .or_else(|| self.force_signals().find_map(|signal| signal.edge_near(t, dt)))
    }

    /// Which quantities prescribed motions, and loads and commands for steps of the size `dt`, may make jump at some time.
    pub fn jumps(&self, dt: f64) -> Jumps {
        let of_base = self.base_motion.as_ref().map_or(Jumps::Nothing, BaseMotion::jumps);
        let has_edges = self.force_signals().any(|signal| signal.has_edges(dt));
        let of_forces = if has_edges { Jumps::Accelerations } else { Jumps::Nothing };
        self.driven().map(Driven::jumps).fold(of_base.max(of_forces), Jumps::max)
    }

    /// Shortest period of loads and prescribed motions, in seconds; infinite without oscillations.
    pub fn shortest_period(&self) -> f64 {
        let of_base = self.base_motion.iter().map(BaseMotion::period);
        let of_joints = self.driven().map(Driven::period);
        let of_signals = self.signals().map(Timed::period);
        of_base.chain(of_joints).chain(of_signals).fold(f64::INFINITY, f64::min)
    }

    /// Whether functions of which only values are known may command, load or move it; prescribed motions count as such.
    pub fn has_functions(&self) -> bool {
        let is_function = |placed: PlacedSignal<'_>| match placed.signal {
            SignalOf::Number(signal) => matches!(signal, Signal::Function(_)),
            SignalOf::Vector(signal) => matches!(signal, Signal::Function(_)),
        };
        self.is_prescribed() || self.signals_with_places().any(is_function)
    }

    /// Interval of time on which the prescribed motions of base and joints are defined.
    pub fn time_span(&self) -> [f64; 2] {
        let spans = self.base_motion.iter().map(BaseMotion::span).chain(self.driven().map(Driven::span));
        spans
            .fold([f64::NEG_INFINITY, f64::INFINITY], |[from, to], span| [from.max(span[0]), to.min(span[1])])
    }

    /// Whether positions require a time to be set, because base or joints have a prescribed motion.
    pub fn is_prescribed(&self) -> bool {
        self.base_motion.is_some() || self.driven().any(Driven::varies_in_time)
    }

    /// Whether positions depend on time explicitly, because the base or a joint moves as prescribed.
    pub fn is_moved(&self) -> bool {
        let base_moves = self.base_motion.as_ref().is_some_and(|motion| !motion.is_constant());
        base_moves || self.driven().any(Driven::varies_in_time)
    }

    /// Whether a loop connects the robot to the world under a moving base.
    pub fn is_tied_to_world(&self) -> bool {
        let mut ends = self.loops.iter().filter_map(|closed| closed.tie.ends()).flatten();
        self.base_motion.is_some() && ends.any(|end| end.link.is_none())
    }

    /// Whether anything depends on time explicitly.
    pub fn depends_on_time(&self) -> bool {
        self.is_moved() || self.signals().any(Timed::varies_in_time)
    }
}
