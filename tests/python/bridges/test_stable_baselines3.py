"""The adapter to Stable-Baselines3, beside a stand-in for the class from which its environments derive.

The package itself is large; `tests/torch` tests with it.
"""

import importlib
import subprocess
import sys
from abc import ABC, abstractmethod
from types import ModuleType

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from numpy.testing import assert_array_equal

import lissom.gym


class VecEnv(ABC):
    """What Stable-Baselines3 2.9 does and asks for in `stable_baselines3.common.vec_env.VecEnv`."""

    def __init__(self, num_envs, observation_space, action_space):
        self.num_envs = num_envs
        self.observation_space = observation_space
        self.action_space = action_space
        self.reset_infos = [{} for _ in range(num_envs)]
        self._seeds = [None for _ in range(num_envs)]
        self._options = [{} for _ in range(num_envs)]
        self.render_mode = self.get_attr("render_mode")[0]

    def _reset_seeds(self):
        self._seeds = [None for _ in range(self.num_envs)]

    def _reset_options(self):
        self._options = [{} for _ in range(self.num_envs)]

    def _get_indices(self, indices):
        if indices is None:
            return range(self.num_envs)
        return [indices] if isinstance(indices, int) else indices

    def seed(self, seed=None):
        self._seeds = [seed + row for row in range(self.num_envs)]

    def step(self, actions):
        self.step_async(actions)
        return self.step_wait()

    @abstractmethod
    def reset(self): ...

    @abstractmethod
    def step_async(self, actions): ...

    @abstractmethod
    def step_wait(self): ...

    @abstractmethod
    def close(self): ...

    @abstractmethod
    def get_attr(self, attr_name, indices=None): ...

    @abstractmethod
    def set_attr(self, attr_name, value, indices=None): ...

    @abstractmethod
    def env_method(self, method_name, *args, indices=None, **kwargs): ...

    @abstractmethod
    def env_is_wrapped(self, wrapper_class, indices=None): ...


@pytest.fixture(scope="module")
def adapter():
    """The module, imported with the stand-in."""
    names = ("stable_baselines3", "stable_baselines3.common", "stable_baselines3.common.vec_env")
    with pytest.MonkeyPatch.context() as patch:
        for name in names:
            patch.setitem(sys.modules, name, ModuleType(name))
        sys.modules[names[-1]].VecEnv = VecEnv
        patch.delitem(sys.modules, "lissom.gym.stable_baselines3", raising=False)
        yield importlib.import_module("lissom.gym.stable_baselines3")
        del sys.modules["lissom.gym.stable_baselines3"]


def test_rows_are_those_of_single_environments(adapter):
    """Through ends of episodes: poles fall at different times."""
    envs = adapter.RobotVecEnv("balance", 3, max_episode_steps=20, seed=5)
    alone = [gymnasium.make("lissom/Balance-v0", max_episode_steps=20) for _ in range(3)]
    assert_array_equal(envs.reset(), [env.reset(seed=5 + row)[0] for row, env in enumerate(alone)])
    ended = {"fallen": 0, "truncated": 0}
    for k in range(150):
        actions = np.full((3, 1), 0.05 * np.cos(k)) * [[0.0], [1.0], [20.0]]
        observations, rewards, ends, infos = envs.step(actions)
        for row, env in enumerate(alone):
            observation, reward, terminated, truncated, info = env.step(actions[row])
            assert rewards[row] == reward
            assert ends[row] == (terminated or truncated)
            if ends[row]:
                ended["fallen" if terminated else "truncated"] += 1
                assert_array_equal(infos[row].pop("terminal_observation"), observation)
                assert infos[row].pop("TimeLimit.truncated") is (truncated and not terminated)
                observation, first = env.reset()
                assert envs.reset_infos[row] == first
            assert infos[row] == info
            assert_array_equal(observations[row], observation)
    assert min(ended.values()) > 0


def test_infos_are_numbers_of_python(adapter):
    envs = adapter.RobotVecEnv("reach", 2, seed=0)
    envs.reset()
    assert [set(info) for info in envs.reset_infos] == [{"distance", "is_success"}] * 2
    *_, infos = envs.step(np.zeros((2, 6)))
    assert {type(info["distance"]) for info in infos} == {float}
    assert {type(info["is_success"]) for info in infos} == {bool}


def test_seeds_count_once(adapter):
    envs = adapter.RobotVecEnv("balance", 2, seed=1)
    first, second = envs.reset(), envs.reset()
    assert not np.array_equal(first, second)
    envs.seed(1)
    assert_array_equal(envs.reset(), first)


def test_attributes_pictures_and_what_rows_do_not_have(adapter):
    def other(random):
        return lissom.gym.reach.arm(density=random.uniform(900.0, 1200.0))

    envs = adapter.RobotVecEnv("reach", 2, randomise=other, seed=0)
    envs.reset()
    assert envs.render_mode is None
    assert envs.get_attr("robot") == list(envs.envs.robots)
    assert envs.get_attr("robot", 1) == [envs.envs.robots[1]]
    assert envs.get_attr("num_envs", [0, 1]) == [2, 2]
    assert envs.env_is_wrapped(object) == [False, False]
    assert envs.get_images() == [None, None]
    with pytest.raises(AttributeError):
        envs.get_attr("nothing")
    with pytest.raises(NotImplementedError, match="dt: rows share their attributes"):
        envs.set_attr("dt", 1.0)
    with pytest.raises(NotImplementedError, match="jump: rows have no methods of their own"):
        envs.env_method("jump")
    drawn = adapter.RobotVecEnv("balance", 2, render_mode="rgb_array", seed=0)
    drawn.reset()
    assert [image.shape for image in drawn.get_images()] == [(400, 400, 3)] * 2
    assert drawn.envs.autoreset_mode is AutoresetMode.SAME_STEP


def test_what_is_missing_is_said():
    code = "import sys; sys.modules['stable_baselines3'] = None; import lissom.gym.stable_baselines3"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "takes Stable-Baselines3: pip install 'lissom[learning]'" in run.stderr
