"""Tasks: the robot of an environment with its initial states, observations and rewards.

Tasks work on arrays with one row per environment, elementwise, so that a row has the same bits however many
rows there are. One class therefore serves both single and vector environments.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self, TypedDict

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from .._lissom import Robot, finite_array
from ..common.arguments import text, whole

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Draws a robot for a row with the random number generator of this row.
Randomise = Callable[[np.random.Generator], Robot]

#: Status of a state that leaves the observation space.
OUT_OF_BOUNDS = "out_of_bounds"


@dataclass(frozen=True)
class Start:
    """Initial state of an episode: coordinates (n,), velocities (n,), and the goal (m,), if there is one."""

    q: Array
    v: Array
    goal: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class States:
    """Rows of states: one robot for all or one each, q, v (k, n), goals (k, m), actions (k, actions).

    The times t have shape (k,), seconds.
    """

    robots: Sequence[Robot]
    q: Array
    v: Array
    goals: Array
    actions: Array
    t: Array

    def ask(self, question: Callable[..., Array], *more: Array) -> Array:
        """Evaluate a method of the robot for all rows: in one call if they share one robot.

        Parameters
        ----------
        question : callable
            ``question(robot, q, v, *more)``, with rows of these.
        more : ndarray, shape (k, ...)
            Further arguments, such as ``t`` if a base or loads vary in time.
        """
        if len(self.robots) == 1:
            return question(self.robots[0], self.q, self.v, *more)
        rows = zip(self.robots, self.q, self.v, *more, strict=True)
        return np.concatenate(
            [question(robot, *(np.asarray(part)[None] for part in parts)) for robot, *parts in rows]
        )


@dataclass(frozen=True)
class Outcome:
    """Observations (k, channels), rewards (k,), and additional numbers for `info`, each of shape (k,)."""

    observations: Array
    rewards: Array
    infos: Mapping[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Verdict:
    """An `Outcome` clipped to the observation space, and the rows whose episodes end, with the reasons."""

    outcome: Outcome
    terminated: Flags
    #: Status and message for each terminated row.
    reasons: Mapping[int, tuple[str, str]]


class Method(TypedDict):
    """Options of the time integration."""

    dt: float
    rtol: float
    atol: float


#: What tasks define.
METHODS = {
    "start": "def start(self, robot, random): return Start(q, v)",
    "inputs": "def inputs(self, actions): return u",
    "outcome": "def outcome(self, states): return Outcome(observations, rewards)",
}

#: What they have as attributes.
ATTRIBUTES = {
    "robot": "a Robot",
    "channels": "bounds of the observations by name",
    "dt": "the step in seconds",
    "control_step": "the duration of an action in seconds",
}


class Task(ABC):
    """Definition of an environment; subclass it for your own.

    All quantities are in SI units. Rows of arrays are environments. A row's results must not depend on the
    number of rows: use elementwise formulas and sums along rows, not matrix products.

    Attributes
    ----------
    robot : Robot
        The robot without randomisation.
    channels : mapping of str to float
        Names of the observations with the bounds of their magnitudes. An episode ends when an observation
        exceeds its bound.
    dt : float
        Size of the steps of Newmark's method, seconds.
    rtol, atol : float
        Tolerances of the equations of a step, as for `Simulation`. The resulting error is far below that of
        the step size.
    control_step : float
        Duration of an action, seconds.
    action_names : sequence of str
        Names of the actions; those of the robot's inputs unless the task has others, such as two bending
        angles that `inputs` turns into tensions of four tendons.
    max_episode_steps : int
        Default number of actions after which an episode is truncated.
    failed_reward : float
        Reward of a step that fails or leaves the bounds.
    window : pair of three floats, optional
        Corners of the box shown in pictures, metres. If the box is flat, pictures look along its normal. By
        default what the robot can reach about its bases.
    """

    robot: Robot
    channels: Mapping[str, float]
    dt: ClassVar[float]
    rtol: ClassVar[float] = 1e-5
    atol: ClassVar[float] = 1e-7
    control_step: ClassVar[float]
    max_episode_steps: ClassVar[int]
    failed_reward: ClassVar[float] = 0.0
    window: ClassVar[tuple[tuple[float, float, float], tuple[float, float, float]] | None] = None

    def __new__(cls, *_: Any, **__: Any) -> Self:
        """A task that has all of its methods."""
        missing = [f"`{METHODS[name]}`" for name in METHODS if name in cls.__abstractmethods__]
        if missing:
            raise TypeError(f"{cls.__name__} is a task without {', '.join(missing)}: define it in a subclass")
        return super().__new__(cls)

    @abstractmethod
    def start(self, robot: Robot, random: np.random.Generator) -> Start:
        """Return the initial state of an episode, drawn with the random number generator of its row."""

    @abstractmethod
    def inputs(self, actions: Array) -> Array:
        """Return the robot's inputs, shape (k, inputs), for actions in [-1, 1], shape (k, actions)."""

    @abstractmethod
    def outcome(self, states: States) -> Outcome:
        """Return the observations of states and the rewards for reaching them."""

    @property
    def action_names(self) -> Sequence[str]:
        """Names of the actions: those of the robot's inputs, unless a task sets others."""
        return tuple(self.robot.inputs)

    @property
    def action_space(self) -> Box:
        """One number for each action, from -1 to 1."""
        return Box(-1.0, 1.0, (len(self.action_names),), np.float32)

    @property
    def observation_space(self) -> Box:
        """The channels with their bounds."""
        bounds = self.bounds
        return Box(-bounds, bounds, dtype=np.float64)

    @property
    def bounds(self) -> Array:
        """The bounds of the channels, in order."""
        return np.array(list(self.channels.values()), dtype=float)

    @property
    def method(self) -> Method:
        """Options of the time integration: arguments of `Simulation` and `Simulations`."""
        return Method(dt=self.dt, rtol=self.rtol, atol=self.atol)

    def checked(self, actions: Any, shape: tuple[int, ...]) -> Array:
        """Check the shape of actions and clip them to [-1, 1].

        Raises
        ------
        ValueError, TypeError
            If they have another shape or are not finite.
        """
        array = finite_array(actions, "action")
        if array.shape != shape:
            raise ValueError(f"action: expected shape {shape}, got {array.shape}")
        return np.clip(array, -1.0, 1.0)

    def commands(self, actions: Array) -> Array:
        """The `inputs` for checked actions, with their shape checked.

        Raises
        ------
        ValueError, TypeError
            If `inputs` returns another shape or numbers that are not finite.
        """
        name = f"{type(self).__name__}.inputs"
        found = finite_array(self.inputs(actions), name)
        expected = (len(actions), len(self.robot.inputs))
        if found.shape != expected:
            raise ValueError(f"{name}: expected shape {expected}, an input in each column, got {found.shape}")
        return found

    def variant(self, randomise: Randomise, random: np.random.Generator) -> Robot:
        """A robot from a function of the user, checked for this task.

        Raises
        ------
        ValueError, TypeError
            If it is not a `Robot`, or has other coordinates or inputs.
        """
        robot = randomise(random)
        if not isinstance(robot, Robot):
            raise TypeError(f"randomise: expected a Robot, got {type(robot).__name__}")
        for what in ("coordinates", "inputs"):
            expected, got = getattr(self.robot, what), getattr(robot, what)
            if got != expected:
                raise ValueError(f"randomise: expected a robot with the {what} {expected}, got {got}")
        return robot

    def begun(self, robot: Robot, random: np.random.Generator) -> Start:
        """The `start` of an episode, checked.

        Raises
        ------
        TypeError
            If it is no `Start`.
        """
        start = self.start(robot, random)
        if not isinstance(start, Start):
            raise TypeError(
                f"{type(self).__name__}.start: expected a lissom.gym.Start(q, v, goal), got "
                f"{type(start).__name__}"
            )
        return start

    def seen(self, states: States) -> Outcome:
        """The `outcome` of states, with the numbers of rows and channels checked.

        Raises
        ------
        ValueError, TypeError
            If they are wrong, or it is no `Outcome`.
        """
        outcome = self.outcome(states)
        if not isinstance(outcome, Outcome):
            raise TypeError(
                f"{type(self).__name__}.outcome: expected a lissom.gym.Outcome(observations, rewards), got "
                f"{type(outcome).__name__}"
            )
        count = len(states.q)
        expected = {"observations": (count, len(self.channels)), "rewards": (count,)}
        for name, shape in expected.items():
            got = np.shape(getattr(outcome, name))
            if got != shape:
                raise ValueError(
                    f"{type(self).__name__}.outcome: expected {name} of shape {shape}, got {got}"
                )
        return outcome

    def judge(self, states: States, success: Flags, why: Callable[[int], tuple[str, str]]) -> Verdict:
        """Result of a step for the agent.

        Parameters
        ----------
        states : States
            States after the step; after a failed step those where it stopped.
        success : ndarray of bool, shape (k,)
            Which steps succeeded.
        why : callable
            Returns the status and the message of a failed step.
        """
        outcome = self.seen(states)
        bounds = self.bounds
        # Formulated such that NaN is outside.
        is_inside = np.abs(outcome.observations) <= bounds
        goes_on = success & is_inside.all(axis=-1)
        if goes_on.all():
            return Verdict(outcome, ~goes_on, {})
        reasons = {}
        for row in np.flatnonzero(~goes_on).tolist():
            if not success[row]:
                reasons[row] = why(row)
                continue
            first = int(np.argmin(is_inside[row]))
            name, value = list(self.channels)[first], outcome.observations[row, first]
            reasons[row] = OUT_OF_BOUNDS, f"{name} is {value:.3g}, beyond {bounds[first]:.3g}"
        limited = Outcome(
            np.clip(np.nan_to_num(outcome.observations), -bounds, bounds),
            np.where(goes_on, outcome.rewards, self.failed_reward),
            outcome.infos,
        )
        return Verdict(limited, ~goes_on, reasons)


#: Values of `render_mode`.
RENDER_MODES = ["rgb_array"]


def checked_randomise(randomise: Randomise | None) -> Randomise | None:
    """Check a function that makes variants.

    Raises
    ------
    TypeError
        If it is not callable.
    """
    if randomise is not None and not callable(randomise):
        raise TypeError(f"randomise: expected a function or None, got {type(randomise).__name__}")
    return randomise


def checked_render_mode(mode: str | None) -> str | None:
    """Check a render mode.

    Raises
    ------
    ValueError
        If it is invalid.
    """
    if mode is not None and text("render_mode", mode) not in RENDER_MODES:
        raise ValueError(f"render_mode: expected None or 'rgb_array', got {mode!r:.60}")
    return mode


def films(task: Task) -> dict[str, Any]:
    """Metadata for pictures: one per control step gives a film in real time."""
    return {"render_modes": RENDER_MODES, "render_fps": max(1, round(1 / task.control_step))}


def checked_seed(seed: int | None) -> int | None:
    """Check a seed of Gymnasium.

    Raises
    ------
    ValueError, TypeError
        If it is not a whole number, or negative.
    """
    if seed is None:
        return None
    found = whole("seed", seed)
    if found < 0:
        raise ValueError(f"seed: expected zero or more, got {found}")
    return found
