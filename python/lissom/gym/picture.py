"""Pictures of a robot: rods as lines, rigid links and the goal as dots."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import Robot
from .task import Array, Task

#: Size in inches and resolution: 400 pixels wide and high.
SIZE, DOTS_PER_INCH = 4.0, 100
#: Number of points drawn per rod.
POINTS = 33


def picture(task: Task, robot: Robot, q: Array, goal: Array | None, t: float) -> NDArray[np.uint8]:
    """A picture, shape (height, width, 3), of the robot in the window of its task.

    Parameters
    ----------
    q : ndarray, shape (n,)
        Coordinates.
    goal : ndarray, optional
        A point in the world if it has three numbers; otherwise it is not drawn.
    t : float
        Time, seconds.

    Raises
    ------
    ImportError
        If matplotlib is missing (extra `plot`).
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    low, high = np.array(task.window)
    seen = np.flatnonzero(high > low)
    figure = Figure((SIZE, SIZE), DOTS_PER_INCH, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)
    axes: Any = figure.add_subplot(projection="3d" if len(seen) == 3 else None)
    for link in robot.links:
        if link.rod is None:
            points = robot.pose(q, link=link.name, t=t)[None, :3, 3]
            axes.plot(*points.T[seen], marker="s", color="black")
        else:
            length = sum(segment.length for segment in link.rod)
            stations = np.linspace(0.0, length, POINTS)
            points = robot.pose(q, stations, link=link.name, t=t)[:, :3, 3]
            axes.plot(*points.T[seen], linewidth=3)
    if goal is not None and goal.shape == (3,):
        axes.plot(*goal[seen, None], marker="x", color="red")
    for name, axis in zip("xyz", seen, strict=False):
        getattr(axes, f"set_{name}lim")(low[axis], high[axis])
        getattr(axes, f"set_{name}label")(f"{'xyz'[axis]} (m)")
    axes.set_aspect("equal")
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()
