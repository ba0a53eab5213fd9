"""Pictures of a robot: rods with their sections, bodies, tendons and obstacles, and the goal as a cross."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import Robot
from ..drawing.figures import AXIS, corner
from ..drawing.painting import polygons, triangles, view_axes
from ..drawing.parts import parts
from ..drawing.report.motion import eye_of
from ..model.views import view
from .task import Array, Task

#: Size in inches and resolution: 400 pixels wide and high.
SIZE, DOTS_PER_INCH = 4.0, 100


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

    low, high = _within_reach(robot, t) if task.window is None else np.array(task.window)
    seen = np.flatnonzero(high > low)
    right, up = np.eye(3)[seen[[0, -1]]]
    # Windows in a plane are seen from its side, those in space obliquely.
    axes = view_axes(np.cross(right, up) if len(seen) == 2 else eye_of(high - low), up)
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), axis=-1).reshape(-1, 3)
    places = corners @ axes[:2].T

    figure = Figure((SIZE, SIZE), DOTS_PER_INCH, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)
    plot: Any = figure.add_subplot()
    found, is_there = parts(
        view(robot), q[None], np.zeros((1, len(q))), robot.u0[None], np.array([t]), is_smooth=True
    )
    if is_there.all():
        plot.add_collection(polygons(triangles(found, axes)), autolim=False)
    for link in robot.links:
        if link.rod is None:
            place = axes[:2] @ robot.pose(q, link=link.name, t=t)[:3, 3]
            plot.plot(*place[:, None], marker="s", color="black")
    if goal is not None and goal.shape == (3,):
        plot.plot(*(axes[:2] @ goal)[:, None], marker="x", color="red")
    for name, least, most in zip("xy", places.min(axis=0), places.max(axis=0), strict=True):
        getattr(plot, f"set_{name}lim")(least, most)
    plot.set_aspect("equal")
    if len(seen) == 2:
        for name, axis in zip("xy", seen, strict=True):
            getattr(plot, f"set_{name}label")(f"{'xyz'[axis]} (m)")
    else:
        plot.set_axis_off()
        # The edges of the window: pairs of its corners that differ along one axis.
        for i, j in np.argwhere(np.triu(np.sum(corners[:, None] != corners, axis=-1) == 1)):
            plot.plot(*places[[i, j]].T, color="lightgrey", linewidth=0.8, zorder=0)
        size = float(np.ptp(places[:, 0]))
        corner(plot, axes, places.min(axis=0) + 0.5 * AXIS * size, AXIS * size)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _within_reach(robot: Robot, t: float) -> tuple[Array, Array]:
    """The corners of the box around the bases of the links, as they are at rest, with the robot's reach."""
    rest = np.zeros(robot.n)
    bases = [
        robot.pose(rest, *([0.0] if link.rod else []), link=link.name, t=t)[:3, 3] for link in robot.links
    ]
    reach = view(robot).size
    return np.min(bases, axis=0) - reach, np.max(bases, axis=0) + reach
