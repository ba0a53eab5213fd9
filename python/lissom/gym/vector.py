"""A vector environment whose robots are stepped on all cores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from .._lissom import Robot, Simulations
from ..common.arguments import suggesting, whole
from .task import (
    Array,
    Flags,
    Outcome,
    Randomise,
    States,
    Task,
    Verdict,
    checked_randomise,
    checked_render_mode,
    checked_seed,
    films,
)
from .tasks import task_of

Infos = dict[str, Any]


@suggesting
class RobotVectorEnv(VectorEnv[Array, NDArray[np.float32], NDArray[Any]]):
    """A Gymnasium vector environment, stepped by `lissom.Simulations`.

    Row i has the same bits as a `RobotEnv` with the seed and the actions of that row.

    Parameters
    ----------
    task : Task or str
        As for `RobotEnv`.
    num_envs : int
        Number of environments.
    max_episode_steps : int, optional
        Number of actions after which an episode is truncated; by default that of the task.
    autoreset_mode : AutoresetMode or str
        "NextStep": the step after the end of an episode starts the next one and ignores the action;
        "SameStep": the last step of an episode starts the next one, and ``infos["final_obs"]`` and
        ``infos["final_info"]`` contain the end of the previous one;
        "Disabled": call ``reset(options={"reset_mask": mask})``.
    randomise : callable, optional
        As for `RobotEnv`; it draws a robot for each row with the generator of that row.
    workers : int, optional
        Number of threads; by default the number of processors.
    render_mode : str, optional
        As for `RobotEnv`.

    Attributes
    ----------
    task : Task
    robots : tuple of Robot
        One for all rows, or one for each.
    simulations : Simulations
        Their simulations.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    Notes
    -----
    ``infos["status"]`` and ``infos["message"]`` give the reasons for failed steps, as in `RobotEnv`, in the
    rows where the masks ``infos["_status"]`` and ``infos["_message"]`` are true.

    Examples
    --------
    >>> import gymnasium, lissom.gym
    >>> envs = gymnasium.make_vec("lissom/Balance-v0", num_envs=16)
    >>> observations, infos = envs.reset(seed=0)
    >>> observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
    >>> observations.shape, bool(terminated.any())
    ((16, 8), False)
    """

    def __init__(
        self,
        task: Task | str,
        num_envs: int = 1,
        *,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        randomise: Randomise | None = None,
        workers: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        self.render_mode = checked_render_mode(render_mode)
        self.task = task_of(task)
        self.num_envs = _count("num_envs", num_envs)
        self.max_episode_steps = _count(
            "max_episode_steps",
            self.task.max_episode_steps if max_episode_steps is None else max_episode_steps,
        )
        self.autoreset_mode = _mode(autoreset_mode)
        self.metadata = films(self.task) | {"autoreset_mode": self.autoreset_mode}
        self.single_observation_space = self.task.observation_space
        self.single_action_space = self.task.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.robots: tuple[Robot, ...] = (self.task.robot,)
        self._randomise = checked_randomise(randomise)
        self._workers = None if workers is None else _count("workers", workers)
        self.simulations = self._motions()
        # The state of each row: random numbers with their seeds; no goals before the first reset.
        self._randoms = [seeding.np_random() for _ in range(self.num_envs)]
        self._goals: Array | None = None
        self._elapsed = np.zeros(self.num_envs, dtype=int)
        self._ended = np.zeros(self.num_envs, dtype=bool)
        self._observations: Array = np.zeros(self.observation_space.shape or ())

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Array, Infos]:
        """Start episodes.

        Parameters
        ----------
        seed : int or sequence of int, optional
            Row i has the seed ``seed + i`` or ``seed[i]``. Rows without a seed keep their random number
            generators.
        options : dict, optional
            "reset_mask": rows in which an episode starts, bool, shape (num_envs,); by default all.

        Raises
        ------
        ValueError, TypeError
            If a seed or the mask is invalid, or the number of seeds differs from the number of rows.
        ConvergenceError
            If the task finds no initial state.
        """
        seeds = self._seeds(seed)
        mask = self._mask(options)
        is_seeded = np.array([each is not None for each in seeds])
        is_first = self._goals is None
        if is_first and not mask.all():
            raise ValueError("options['reset_mask']: the first reset is one of all rows")
        is_new = is_seeded | is_first
        if self._randomise is not None and is_new.any() and not mask.all():
            raise ValueError("seed: robots that are random are made anew where all rows begin, not some")
        for row in np.flatnonzero(is_seeded & mask):
            self._randoms[row] = seeding.np_random(seeds[row])
        if self._randomise is not None and is_new.any():
            self._draw_robots(self._randomise, is_new)
        infos: Infos = {}
        _put(infos, self._begin(mask).infos, mask)
        return self._observations.copy(), infos

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[Array, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Apply an action in each row for one control step. Actions are clipped to [-1, 1].

        Raises
        ------
        ValueError, TypeError
            If the actions have the wrong shape or are not finite.
        gymnasium.error.ResetNeeded
            Before the first reset, or if an episode has ended and autoreset is disabled.
        """
        if self._goals is None:
            raise gymnasium.error.ResetNeeded("the environments have no state yet: call reset first")
        simulations = self.simulations
        actions = self.task.checked(actions, self.action_space.shape or ())
        begins = self._ended
        if self.autoreset_mode is AutoresetMode.DISABLED and begins.any():
            rows = np.flatnonzero(begins).tolist()
            raise gymnasium.error.ResetNeeded(f"the episodes of rows {rows} have ended: reset them")
        # Rows that begin anew make a step, too, of which nothing is kept.
        success = simulations.step(self.task.commands(actions), self.task.control_step)
        verdict = self.task.judge(
            States(self.robots, simulations.q, simulations.v, self._goals, actions, simulations.t),
            success,
            lambda row: (simulations.status[row], simulations.message(row)),
        )
        self._elapsed += 1
        self._observations = verdict.outcome.observations
        rewards = np.where(begins, 0.0, verdict.outcome.rewards)
        terminated = verdict.terminated & ~begins
        truncated = (self._elapsed >= self.max_episode_steps) & ~begins
        ended = terminated | truncated
        infos: Infos = {}
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            _fill_infos(infos, verdict, ~ended)
            if ended.any():
                self._fill_final_infos(infos, verdict, ended)
            begins, self._ended = ended, np.zeros_like(ended)
        else:
            _fill_infos(infos, verdict, ~begins)
            self._ended = ended
        if begins.any():
            _put(infos, self._begin(begins).infos, begins)
        return self._observations.copy(), rewards, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Pictures of the robots, one for each row, as of `RobotEnv`; None without a `render_mode`.

        Raises
        ------
        ImportError
            Without matplotlib.
        """
        if self.render_mode is None:
            gymnasium.logger.warn("render: the environments were made without render_mode='rgb_array'")
            return None
        from .picture import picture

        q, t = self.simulations.q, self.simulations.t
        return tuple(
            picture(
                self.task,
                self.robots[row % len(self.robots)],
                q[row],
                None if self._goals is None else self._goals[row],
                float(t[row]),
            )
            for row in range(self.num_envs)
        )

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The random numbers of each row, as of Gymnasium's own environments of many."""
        return tuple(random for random, _ in self._randoms)

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        """The seed of each row."""
        return tuple(seed for _, seed in self._randoms)

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        """One for each row."""
        if not isinstance(seed, Sequence | np.ndarray):
            first = checked_seed(seed)
            return [None if first is None else first + row for row in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"seed: expected a number or {self.num_envs} of them, got {len(seed)}")
        return [checked_seed(each) for each in seed]

    def _mask(self, options: dict[str, Any] | None) -> Flags:
        """The rows to begin."""
        if options is not None and not isinstance(options, Mapping):
            raise TypeError(f"options: expected a dictionary, got {type(options).__name__}")
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, dtype=bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
            raise ValueError(
                f"options['reset_mask']: expected {self.num_envs} truth values, one of them true at least, "
                f"got shape {mask.shape}, {mask.dtype}"
            )
        return mask

    def _draw_robots(self, randomise: Randomise, which: Flags) -> None:
        """Makes the robots of some rows; their motions are made anew with them."""
        robots = list(self.robots) if len(self.robots) > 1 else list(self.robots) * self.num_envs
        for row in np.flatnonzero(which):
            robots[row] = self.task.variant(randomise, self._randoms[row][0])
        self.robots = tuple(robots)
        self.simulations = self._motions()

    def _begin(self, mask: Flags) -> Outcome:
        """Begins episodes in some rows; what their agents get, a row for each of these."""
        rows = np.flatnonzero(mask)
        robots = self.robots if len(self.robots) == 1 else tuple(self.robots[row] for row in rows)
        starts = [
            self.task.begun(robots[k % len(robots)], self._randoms[row][0]) for k, row in enumerate(rows)
        ]
        q, v, goals = (np.stack([getattr(start, part) for start in starts]) for part in ("q", "v", "goal"))
        self.simulations.reset(rows, q0=q, v0=v, t0=0.0)
        if self._goals is None:
            self._goals = goals
        self._goals[rows] = goals
        actions = np.zeros((len(rows), len(self.task.action_names)))
        outcome = self.task.seen(States(robots, q, v, goals, actions, np.zeros(len(rows))))
        self._observations[rows] = outcome.observations
        self._elapsed[rows] = 0
        self._ended[rows] = False
        return outcome

    def _motions(self) -> Simulations:
        """Those of the robots, from zero."""
        model = self.robots[0] if len(self.robots) == 1 else self.robots
        return Simulations(model, self.num_envs, workers=self._workers, **self.task.method)

    def _fill_final_infos(self, infos: Infos, verdict: Verdict, ended: Flags) -> None:
        """How episodes ended in the rows in which the next one has begun."""
        last = np.full(self.num_envs, None, dtype=object)
        for row in np.flatnonzero(ended):
            last[row] = verdict.outcome.observations[row].copy()
        final: Infos = {}
        _fill_infos(final, verdict, ended)
        infos |= {
            "final_obs": last,
            "_final_obs": ended.copy(),
            "final_info": final,
            "_final_info": ended.copy(),
        }


def _mode(mode: AutoresetMode | str) -> AutoresetMode:
    """How the next episodes begin."""
    if isinstance(mode, AutoresetMode):
        return mode
    words = [each.value for each in AutoresetMode]
    if not isinstance(mode, str):
        raise TypeError(f"autoreset_mode: expected one of {', '.join(words)}, got {type(mode).__name__}")
    if mode not in words:
        raise ValueError(f"autoreset_mode: expected one of {', '.join(words)}, got {mode!r:.60}")
    return AutoresetMode(mode)


def _count(name: str, value: int) -> int:
    """A whole number of one or more."""
    found = whole(name, value)
    if found < 1:
        raise ValueError(f"{name}: expected one or more, got {found}")
    return found


def _put(infos: Infos, values: Mapping[str, NDArray[Any]], mask: Flags) -> None:
    """Adds values, one for each row of a mask, to what is known of others, as Gymnasium has it."""
    for name, numbers in values.items():
        if name not in infos:
            empty = None if numbers.dtype == object else 0
            infos[name] = np.full(len(mask), empty, dtype=numbers.dtype)
            infos[f"_{name}"] = np.zeros(len(mask), dtype=bool)
        infos[name][mask] = numbers
        infos[f"_{name}"] |= mask


def _fill_infos(infos: Infos, verdict: Verdict, mask: Flags) -> None:
    """Adds what is known of the rows of a mask, and why their episodes ended."""
    if not mask.any():
        return
    _put(infos, {name: values[mask] for name, values in verdict.outcome.infos.items()}, mask)
    for row, reason in verdict.reasons.items():
        if mask[row]:
            words = dict(
                zip(("status", "message"), (np.array([word], dtype=object) for word in reason), strict=True)
            )
            _put(infos, words, np.arange(len(mask)) == row)
