"""An environment of one robot."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import Space
from numpy.typing import NDArray

from .._lissom import Simulation
from ..common.arguments import suggesting
from .task import (
    RENDER_MODES,
    Array,
    Randomise,
    States,
    Task,
    checked_randomise,
    checked_render_mode,
    checked_seed,
    films,
)
from .tasks import task_of


@suggesting
class RobotEnv(gymnasium.Env[Array, NDArray[np.float32]]):
    """A Gymnasium environment with one robot.

    Parameters
    ----------
    task : Task or str
        The task; "reach", "balance" and "swim" name those of `lissom.gym`.
    randomise : callable, optional
        ``randomise(random)`` returns a `Robot` with the same coordinates and inputs, drawn with a random
        number generator. It is called at the first reset and at every reset with a seed; the episodes in
        between keep the robot.
    render_mode : str, optional
        "rgb_array" for pictures (needs matplotlib).

    Attributes
    ----------
    task : Task
    robot : Robot
        The robot of the current episode.
    simulation : Simulation
        Its simulation.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    Notes
    -----
    The episode terminates if a step fails or a state leaves the observation space. ``info["status"]`` and
    ``info["message"]`` then give the reason, the reward is `Task.failed_reward`, and the observation is that
    of the last state, clipped to its bounds. Copies and pickles continue bit for bit.

    Only ``gymnasium.make`` and ``gymnasium.wrappers.TimeLimit`` truncate episodes. A step after the end of an
    episode continues it.

    Examples
    --------
    >>> import gymnasium, lissom.gym
    >>> env = gymnasium.make("lissom/Balance-v0")
    >>> observation, info = env.reset(seed=0)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    >>> observation.shape, terminated
    ((8,), False)
    """

    # Gymnasium reads the attribute of the class, before there is a task, and declares it for instances.
    metadata: dict[str, Any] = {"render_modes": RENDER_MODES}  # noqa: RUF012

    def __init__(
        self, task: Task | str, *, randomise: Randomise | None = None, render_mode: str | None = None
    ) -> None:
        self.render_mode = checked_render_mode(render_mode)
        self.task = task_of(task)
        self.metadata = films(self.task)
        self.observation_space: Space[Any] = self.task.observation_space
        self.action_space: Space[Any] = self.task.action_space
        self.robot = self.task.robot
        self.simulation = Simulation(self.robot, **self.task.method)
        self._randomise = checked_randomise(randomise)
        # None before the first reset.
        self._goal: Array | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start an episode. Equal seeds give equal bits.

        Raises
        ------
        ValueError, TypeError
            If the seed is invalid.
        ConvergenceError
            If the task finds no initial state.
        """
        super().reset(seed=checked_seed(seed))
        if self._randomise is not None and (self._goal is None or seed is not None):
            self.robot = self.task.variant(self._randomise, self.np_random)
            self.simulation = Simulation(self.robot, **self.task.method)
        start = self.task.begun(self.robot, self.np_random)
        self.simulation.reset(q0=start.q, v0=start.v, t0=0.0)
        self._goal = start.goal
        outcome = self.task.seen(self._states(start.goal, np.zeros((1, len(self.task.action_names)))))
        return outcome.observations[0], _numbers(outcome.infos)

    def step(self, action: NDArray[Any]) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Apply an action for one control step. Actions are clipped to [-1, 1].

        Raises
        ------
        ValueError, TypeError
            If the action has the wrong shape or is not finite.
        gymnasium.error.ResetNeeded
            Before the first reset.
        """
        if self._goal is None:
            raise gymnasium.error.ResetNeeded("the environment has no state yet: call reset first")
        simulation = self.simulation
        actions = self.task.checked(action, (len(self.task.action_names),))[None]
        simulation.step(self.task.commands(actions)[0], duration=self.task.control_step)
        verdict = self.task.judge(
            self._states(self._goal, actions),
            np.array([simulation.success]),
            lambda row: (simulation.status, simulation.message),
        )
        info = _numbers(verdict.outcome.infos)
        if verdict.reasons:
            info["status"], info["message"] = verdict.reasons[0]
        reward = float(verdict.outcome.rewards[0])
        return verdict.outcome.observations[0], reward, bool(verdict.terminated[0]), False, info

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the robot, shape (height, width, 3); None without a `render_mode`.

        Raises
        ------
        ImportError
            Without matplotlib.
        """
        if self.render_mode is None:
            gymnasium.logger.warn("render: the environment was made without render_mode='rgb_array'")
            return None
        from .picture import picture

        return picture(self.task, self.robot, self.simulation.q, self._goal, self.simulation.t)

    def _states(self, goal: Array, actions: Array) -> States:
        simulation = self.simulation
        t = np.array([simulation.t])
        return States((self.robot,), simulation.q[None], simulation.v[None], goal[None], actions, t)


def _numbers(infos: Any) -> dict[str, Any]:
    """Values of the only row."""
    return {name: values[0].item() for name, values in infos.items()}
