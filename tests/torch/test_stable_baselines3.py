"""Environments in Stable-Baselines3 itself, which is large: `make test-torch`."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3", reason="only `make test-torch` installs it")

from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

import lissom.gym
from lissom.gym.stable_baselines3 import RobotVecEnv


@pytest.mark.parametrize("name", ["reach", "balance", "swim"])
def test_the_checker_finds_nothing(name):
    check_env(lissom.gym.RobotEnv(name))


def test_a_policy_learns_to_hold_the_pole():
    envs = VecNormalize(VecMonitor(RobotVecEnv("balance", 16, seed=0)), norm_reward=False)
    model = PPO("MlpPolicy", envs, n_steps=128, batch_size=256, learning_rate=1e-3, seed=0, device="cpu")
    before, _ = evaluate_policy(model, envs, n_eval_episodes=16)
    model.learn(40_000)
    after, _ = evaluate_policy(model, envs, n_eval_episodes=16)
    assert after > 2 * before


def test_successes_are_counted_where_episodes_end():
    envs = RobotVecEnv("reach", 4, max_episode_steps=5, seed=0)
    envs.reset()
    for _ in range(5):
        _, _, ends, infos = envs.step(np.zeros((4, 6)))
    assert ends.all()
    assert {type(info["is_success"]) for info in infos} == {bool}
    assert [image is None for image in envs.get_images()] == [True] * 4
