"""Environments of lissom for Stable-Baselines3: ``from lissom.gym.stable_baselines3 import RobotVecEnv``.

Stable-Baselines3 has vector environments of its own kind, which differ from Gymnasium's in how episodes end.
Needs the extra `learning`: ``pip install 'lissom[learning]'`` (large: it brings PyTorch along).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

try:
    from stable_baselines3.common.vec_env import VecEnv
except ModuleNotFoundError as error:
    raise ImportError(
        "lissom.gym.stable_baselines3 takes Stable-Baselines3: pip install 'lissom[learning]'"
    ) from error

from ..common.arguments import suggesting
from .task import Array, Randomise, Task
from .vector import RobotVectorEnv

__all__ = ["RobotVecEnv"]


@suggesting
class RobotVecEnv(VecEnv):
    """Many robots as a vector environment of Stable-Baselines3, stepped on all cores.

    Parameters
    ----------
    task : Task or str
        As for `RobotEnv`.
    num_envs : int
        Number of environments.
    max_episode_steps : int, optional
        Number of actions after which an episode is truncated; by default that of the task.
    randomise : callable, optional
        As for `RobotVectorEnv`.
    workers : int, optional
        Number of threads; by default the number of processors.
    seed : int, optional
        Row i has the seed ``seed + i`` at the first reset, as after ``RobotVecEnv.seed(seed)``.
    render_mode : str, optional
        As for `RobotEnv`.

    Attributes
    ----------
    envs : RobotVectorEnv
        The environment of Gymnasium that is stepped; row i has the bits of its row i.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    Notes
    -----
    A row whose episode ends returns the first observation of the next one, and its info has
    ``"terminal_observation"``, the last observation of the previous one, and ``"TimeLimit.truncated"``. The
    other infos are those of `RobotEnv`.

    The attributes of rows are those of `RobotVectorEnv`, ``robot`` that of the row. Rows have no methods of
    their own, and no wrappers: wrap this environment, for example in ``VecMonitor`` and ``VecNormalize``.
    """

    def __init__(
        self,
        task: Task | str,
        num_envs: int = 1,
        *,
        max_episode_steps: int | None = None,
        randomise: Randomise | None = None,
        workers: int | None = None,
        seed: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        self.envs = RobotVectorEnv(
            task,
            num_envs,
            max_episode_steps=max_episode_steps,
            autoreset_mode=AutoresetMode.SAME_STEP,
            randomise=randomise,
            workers=workers,
            render_mode=render_mode,
        )
        super().__init__(num_envs, self.envs.single_observation_space, self.envs.single_action_space)
        self.metadata = self.envs.metadata
        self._actions: NDArray[Any] | None = None
        if seed is not None:
            self.seed(seed)

    def reset(self) -> Array:
        """Start episodes, with the seeds of `seed` if it was called; return the observations.

        Raises
        ------
        ConvergenceError
            If the task finds no initial state.
        """
        observations, infos = self.envs.reset(seed=self._seeds)
        self.reset_infos = [_info(infos, row) for row in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions of the next `step_wait`, shape (num_envs, actions)."""
        self._actions = actions

    def step_wait(self) -> tuple[Array, NDArray[Any], NDArray[Any], list[dict[str, Any]]]:
        """Apply the actions for one control step: observations, rewards, ends of episodes, infos.

        Raises
        ------
        ValueError, TypeError
            If the actions have the wrong shape or are not finite.
        """
        observations, rewards, terminated, truncated, found = self.envs.step(np.asarray(self._actions))
        infos = [_info(found, row) for row in range(self.num_envs)]
        ends = terminated | truncated
        for row in np.flatnonzero(ends).tolist():
            self.reset_infos[row] = infos[row]
            infos[row] = _info(found["final_info"], row)
            infos[row]["terminal_observation"] = found["final_obs"][row]
            infos[row]["TimeLimit.truncated"] = bool(truncated[row] and not terminated[row])
        return observations, rewards, ends, infos

    def close(self) -> None:
        """Release the environments."""
        self.envs.close()

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """A picture of each row; None without a `render_mode`."""
        return [None] * self.num_envs if self.envs.render_mode is None else list(self.envs.render() or ())

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute for each row.

        Raises
        ------
        AttributeError
            If `RobotVectorEnv` has no attribute of this name.
        """
        rows = self._get_indices(indices)
        if attr_name == "robot":
            return [self.envs.robots[row % len(self.envs.robots)] for row in rows]
        return [getattr(self.envs, attr_name) for _ in rows]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refused: rows share their attributes.

        Raises
        ------
        NotImplementedError
            Always.
        """
        raise NotImplementedError(f"{attr_name}: rows share their attributes, which cannot be set for some")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Refused: rows have no methods of their own.

        Raises
        ------
        NotImplementedError
            Always.
        """
        raise NotImplementedError(f"{method_name}: rows have no methods of their own; call those of `envs`")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """False for each row."""
        return [False for _ in self._get_indices(indices)]


def _info(infos: Mapping[str, Any], row: int) -> dict[str, Any]:
    """What Gymnasium's infos say about a row; keys with an underscore are masks of those that count."""
    return {
        name: _plain(values[row])
        for name, values in infos.items()
        if not name.startswith(("_", "final_")) and infos[f"_{name}"][row]
    }


def _plain(value: Any) -> Any:
    """A number of Python for one of NumPy."""
    return value.item() if isinstance(value, np.generic) else value
