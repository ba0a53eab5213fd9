"""A soft arm learns to reach: proximal policy optimisation by Stable-Baselines3 on `lissom/Reach-v0`.

    pip install 'lissom[learning,plot]'
    python examples/python/train_reach.py

It writes the learning curve to train_reach.png. `--steps` says how many control steps the training takes,
`--envs` how many arms are stepped together.
"""

import argparse
import time

import gymnasium
import numpy as np
import torch
from matplotlib.figure import Figure
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

import lissom.gym
from lissom.gym.stable_baselines3 import RobotVecEnv


class Curve(BaseCallback):
    """Where episodes end, over the steps of the training."""

    def __init__(self):
        super().__init__()
        self.ends = []

    def _on_step(self):
        self.ends += [
            (self.num_timesteps, info["episode"]["r"], info["distance"])
            for info in self.locals["infos"]
            if "episode" in info
        ]
        return True


def train(steps, count=64, seed=0):
    """A trained model, and the (steps, return, last distance) of each episode on the way."""
    arms = VecNormalize(VecMonitor(RobotVecEnv("reach", count, seed=seed)), norm_reward=False)
    model = PPO(
        "MlpPolicy",
        arms,
        n_steps=64,
        batch_size=16 * count,
        n_epochs=5,
        gamma=0.97,
        learning_rate=1e-3,
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -0.5},
        seed=seed,
        device="cpu",
    )
    curve = Curve()
    model.learn(steps, callback=curve)
    return model, np.array(curve.ends)


def last_distances(act, count, seed=1000):
    """How far the tips of arms are from their targets at the end of an episode."""
    envs = gymnasium.make_vec("lissom/Reach-v0", num_envs=count, autoreset_mode="SameStep")
    observations, _ = envs.reset(seed=seed)
    for _ in range(envs.max_episode_steps):
        observations, *_, infos = envs.step(act(observations))
    return infos["final_info"]["distance"]


def plot(ends, path):
    """The learning curve: means and the middle eighty of a hundred episodes."""
    steps, returns, distances = ends.T
    bins = np.array_split(np.arange(len(steps)), min(60, len(steps)))
    figure = Figure((7, 3), layout="constrained")
    for axes, values, name in zip(
        figure.subplots(1, 2), (returns, 100 * distances), ("return", "last distance (cm)"), strict=True
    ):
        middle = [steps[each].mean() for each in bins]
        low, high = np.array([np.percentile(values[each], (10, 90)) for each in bins]).T
        axes.fill_between(middle, low, high, alpha=0.3)
        axes.plot(middle, [values[each].mean() for each in bins])
        axes.set_xlabel("control steps")
        axes.set_ylabel(name)
        axes.set_ylim(bottom=0)
    figure.savefig(path, dpi=90)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=300_000)
    parser.add_argument("--envs", type=int, default=64)
    options = parser.parse_args()
    # The networks are small: a second thread costs more than it brings.
    torch.set_num_threads(1)
    before = time.perf_counter()
    model, ends = train(options.steps, options.envs)
    print(f"{options.steps} control steps in {time.perf_counter() - before:.0f} s, {len(ends)} episodes")
    normalise = model.get_vec_normalize_env().normalize_obs
    policies = {
        "slack": lambda observations: -np.ones((len(observations), 6)),
        "trained": lambda observations: model.predict(normalise(observations), deterministic=True)[0],
    }
    for name, act in policies.items():
        distances = 100 * last_distances(act, 4 * options.envs)
        reached = np.mean(distances < 100 * lissom.gym.reach.REACHED)
        print(
            f"{name}: ends {np.mean(distances):.1f} cm away, median {np.median(distances):.1f}; "
            f"{100 * reached:.0f} % within 1 cm"
        )
    plot(ends, "train_reach.png")
