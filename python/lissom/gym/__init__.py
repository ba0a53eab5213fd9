"""Environments for reinforcement learning with Gymnasium's API: ``import lissom.gym`` registers them.

- ``lissom/Reach-v0``: an arm with six tendons brings its tip to a target (`Reach`);
- ``lissom/Balance-v0``: a flexible pole on a cart is held upright (`Balance`);
- ``lissom/Swim-v0``: an eel swims forward with its muscles (`Swim`).

``gymnasium.make`` creates one environment (`RobotEnv`), ``gymnasium.make_vec`` many that are stepped together
on all cores (`RobotVectorEnv`). Subclass `Task` for your own environments; ``docs/gym.md`` shows how.
``lissom.gym.stable_baselines3`` has the adapter to Stable-Baselines3.
Needs the extra `gym`: ``pip install 'lissom[gym]'``.
"""

try:
    import gymnasium
except ModuleNotFoundError as error:
    raise ImportError("lissom.gym takes Gymnasium: pip install 'lissom[gym]'") from error

from .balance import Balance
from .reach import Reach
from .single import RobotEnv
from .swim import Swim
from .task import Outcome, Start, States, Task
from .tasks import TASKS
from .vector import RobotVectorEnv

__all__ = [
    "Balance",
    "Outcome",
    "Reach",
    "RobotEnv",
    "RobotVectorEnv",
    "Start",
    "States",
    "Swim",
    "Task",
]

for _name, _task in TASKS.items():
    gymnasium.register(
        f"lissom/{_name.capitalize()}-v0",
        entry_point="lissom.gym.single:RobotEnv",
        vector_entry_point="lissom.gym.vector:RobotVectorEnv",
        max_episode_steps=_task.max_episode_steps,
        kwargs={"task": _name},
    )
