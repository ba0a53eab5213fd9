"""The tasks of `lissom.gym` by name."""

from __future__ import annotations

from .balance import Balance
from .reach import Reach
from .swim import Swim
from .task import Task

TASKS: dict[str, type[Task]] = {"reach": Reach, "balance": Balance, "swim": Swim}


def task_of(task: Task | str) -> Task:
    """Return the task, or create the one with this name.

    Raises
    ------
    ValueError, TypeError
        If the name is unknown, or the argument is something else.
    """
    if isinstance(task, Task):
        return task
    if not isinstance(task, str):
        raise TypeError(f"task: expected a Task or a name, got {type(task).__name__}")
    if task not in TASKS:
        raise ValueError(f"task: expected one of {', '.join(TASKS)}, got {task!r:.60}")
    return TASKS[task]()
