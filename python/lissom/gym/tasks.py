"""The tasks of `lissom.gym` by name."""

from __future__ import annotations

from collections.abc import Sequence

from .._lissom import Model
from .balance import Balance
from .reach import Reach
from .swim import Swim
from .task import ATTRIBUTES, METHODS, Task

TASKS: dict[str, type[Task]] = {"reach": Reach, "balance": Balance, "swim": Swim}


def task_of(task: Task | str) -> Task:
    """Return the task, or create the one with this name.

    Raises
    ------
    ValueError, TypeError
        If the name is unknown, or the argument is something else.
    """
    if isinstance(task, Task):
        _check_attributes(task)
        _check_actions(task)
        return task
    if isinstance(task, type) and issubclass(task, Task):
        raise TypeError(f"task: expected a Task, got the class: write {task.__name__}()")
    if isinstance(task, Model):
        parts = ", ".join(f"`{part}`" for part in (*ATTRIBUTES, *METHODS.values()))
        raise TypeError(
            f"task: expected a Task or a name, got {type(task).__name__}; a task has a robot and rewards it: "
            f"`class Mine(lissom.gym.Task)` with {parts}"
        )
    if not isinstance(task, str):
        raise TypeError(f"task: expected a Task or a name, got {type(task).__name__}")
    if task not in TASKS:
        raise ValueError(f"task: expected one of {', '.join(TASKS)}, got {task!r:.60}")
    return TASKS[task]()


def _check_attributes(task: Task) -> None:
    """Refuse a task without what it needs."""
    missing = [f"{name} ({what})" for name, what in ATTRIBUTES.items() if not hasattr(task, name)]
    if missing:
        raise TypeError(f"{type(task).__name__}: a task needs the attributes {', '.join(missing)}")


def _check_actions(task: Task) -> None:
    """Refuse names of actions that are none."""
    names: object = task.action_names
    place = f"{type(task).__name__}.action_names"
    expected = "expected a sequence of different names, at least one"
    if isinstance(names, str) or not isinstance(names, Sequence):
        raise TypeError(f"{place}: got {names!r:.60}, {expected}")
    if not names or len(set(names)) < len(names) or not all(isinstance(name, str) for name in names):
        raise ValueError(f"{place}: got {tuple(names)!r:.60}, {expected}")
