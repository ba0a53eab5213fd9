"""A pulled rod is twisted until it forms a loop, touches itself, and winds up: a plectoneme.

From then on its torque stays the same and every turn takes the same length, as published theory says. With
the tension T, the bending stiffness B and the distance R of the windings from their middle, the winding angle
a follows from T = B / R^2 sin^4 a (1 / 2 + 1 / cos 2a); the torque is 2 B / R sin^3 a cos a / cos 2a, and a
turn takes 4 pi R / sin 2a (Clauvelin, Audoly and Neukirch 2009). The rod is four times as stiff against twist
as against bending, so that little twist is stored before it winds; surfaces have no friction.

    python examples/python/plectoneme.py [--levels turns ...] [--dt seconds] [--plot file.png] [--report page]
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy.optimize import brentq

import lissom

LENGTH, RADIUS, YOUNG, PARTS = 0.5, 0.01, 1e6, 9
BENDING = YOUNG * np.pi / 4 * RADIUS**4
#: Of a winding angle of half a radian, if surfaces did not give way.
TENSION = BENDING / RADIUS**2 * np.sin(0.5) ** 4 * (0.5 + 1 / np.cos(1.0))
#: Turns at the start, which the straight rod bears, and those between which it is held.
START, LEVELS = 1.6, (2.15, 2.45)
#: Seconds for the way to a level, and for the rest there.
WAY, REST = 0.8, 0.4


def turning(levels: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Times and angles of the base: from level to level, at rest at each of them."""
    part = np.linspace(0, 1, 61)
    smooth = part**3 * (10 - 15 * part + 6 * part**2)
    times, turns = [np.zeros(1)], [np.array([START])]
    for level in levels:
        before, at = times[-1][-1], turns[-1][-1]
        times.append(before + np.r_[WAY * part[1:], WAY + REST * part[6::6]])
        turns.append(np.r_[at + (level - at) * smooth[1:], np.full(10, level)])
    return np.concatenate(times), 2 * np.pi * np.concatenate(turns)


def rod(levels: tuple[float, ...], stiffness: float = 1e6) -> lissom.Robot:
    """The base turns about its axis, the tip slides along it; a syrup damps what is sudden."""
    segment = lissom.Segment(
        LENGTH / PARTS, radius=RADIUS, young_modulus=YOUNG, shear_modulus=2 * YOUNG, density=1000,
        modes={"torsion": 1, "bend_y": 3, "bend_z": 3}, retardation_time=0.02,
    )  # fmt: skip
    link = lissom.Link("rod", rod=[segment] * PARTS, joint=lissom.Revolute((1, 0, 0), motion=turning(levels)))
    slide = lissom.Loop(None, "rod", lissom.Prismatic((1, 0, 0)), name="slide")
    loads = [
        lissom.Load(link="rod", force=(TENSION, 0, 0)),
        # So that the loop is in the middle.
        lissom.Load(link="rod", along=(0.4 * LENGTH, 0.6 * LENGTH), force=(0, 0, TENSION / (4 * LENGTH))),
    ]
    return lissom.Robot(
        [link],
        loops=[slide],
        loads=loads,
        contacts=[lissom.Contact("rod", "rod", stiffness=stiffness)],
        fluid=lissom.Fluid(density=1e-9, viscous_drag=(40.0, 0.0)),
        gravity=(0, 0, 0),
    )


def theory(radius: float) -> tuple[float, float]:
    """Torque, newton metres, and metres a turn, with the axes at a distance from the middle."""

    def excess(angle: float) -> float:
        return BENDING / radius**2 * np.sin(angle) ** 4 * (0.5 + 1 / np.cos(2 * angle)) - TENSION

    angle = brentq(excess, 0.01, 0.78)
    torque = 2 * BENDING / radius * np.sin(angle) ** 3 * np.cos(angle) / np.cos(2 * angle)
    return torque, 4 * np.pi * radius / np.sin(2 * angle)


def twist(robot: lissom.Robot, t_end: float, dt: float) -> lissom.MotionResult:
    """The motion, from the straight rod with its twist."""
    q0 = np.zeros(robot.n)
    torsion = [name.endswith("torsion[0]") for name in robot.coordinates]
    q0[torsion] = -2 * np.pi * START / LENGTH
    return lissom.simulate(robot, t_end, dt=dt, q0=q0)


def torque(robot: lissom.Robot, motion: lissom.MotionResult, step: int) -> float:
    """The mean of those at both ends: windings that turn in the syrup have a share of it."""
    state = motion.q[step], motion.v[step], motion.a[step]
    base = robot.joint_wrench(*state, link="rod", t=motion.t[step])[0]
    tip = robot.loop_forces(*state, t=motion.t[step]).ravel()[0]
    return 0.5 * (abs(base) + abs(tip))


def distance(robot: lissom.Robot, motion: lissom.MotionResult, step: int) -> float:
    """Of the axes from the middle between them: half of what is left of two radii where they press."""
    touches = robot.touches(motion.q[step], motion.v[step], t=motion.t[step])
    if not touches:
        return RADIUS
    overlap = np.average(
        [touch.overlap for touch in touches], weights=[np.linalg.norm(touch.force) for touch in touches]
    )
    return RADIUS - 0.5 * float(overlap)


def draw(
    path: str, robot: lissom.Robot, motion: lissom.MotionResult, levels: tuple[float, ...], steps: list[int]
) -> None:
    """Shapes of the rod at four steps."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(
        2, 2, figsize=(10, 4.4), subplot_kw={"projection": "3d"}, gridspec_kw={"wspace": 0, "hspace": 0}
    )
    figure.subplots_adjust(0, 0, 1, 1)
    X = np.linspace(0, LENGTH, 301)
    ring = np.linspace(0, 2 * np.pi, 17)
    skin = RADIUS * np.stack([0 * ring, np.cos(ring), np.sin(ring)])
    half = 0.5 * LENGTH * np.array([1.0, 0.45, 0.45])
    for axis, step in zip(axes.flat, steps, strict=True):
        t = motion.t[step]
        poses = robot.pose(motion.q[step], X, t=t)
        line = poses[:, :3, 3]
        tube = line[:, :, None] + poses[:, :3, :3] @ skin
        axis.plot_surface(*np.moveaxis(tube, 1, 0), color="tab:blue", linewidth=0, rstride=1, cstride=1)
        # Seen along the axis across the rod in which it is flattest.
        across = np.linalg.eigh(np.cov(line[:, 1:].T))[1][:, 0]
        axis.view_init(elev=np.degrees(np.arcsin(across[1])), azim=np.degrees(np.arctan2(across[0], 0.0)))
        centre = np.r_[0.5 * LENGTH, line[:, 1:].mean(axis=0)]
        axis.set(**{f"{name}lim": (centre[k] - half[k], centre[k] + half[k]) for k, name in enumerate("xyz")})
        axis.set_box_aspect(tuple(half), zoom=1.9)
        axis.set_axis_off()
        turns = np.interp(t, *turning(levels)) / (2 * np.pi)
        axis.text2D(0.5, 0.12, f"{turns:.2f} turns", transform=axis.transAxes, ha="center")
    figure.savefig(path, dpi=120)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--levels", type=float, nargs="+", default=list(LEVELS), help="turns to be held at")
    parser.add_argument("--dt", type=float, default=4e-3)
    parser.add_argument("--plot", help="picture of the rod as it winds")
    parser.add_argument("--report", help="page with the motion")
    options = parser.parse_args()
    robot = rod(tuple(options.levels))
    begin = time.perf_counter()
    motion = twist(robot, len(options.levels) * (WAY + REST), options.dt)
    print(motion.message, f"{time.perf_counter() - begin:.1f} s")
    if not motion.success:
        raise SystemExit(1)
    held = [int(np.searchsorted(motion.t, (k + 1) * (WAY + REST) - 1e-9)) for k in range(len(options.levels))]
    ends = robot.pose(motion.q, t=motion.t)[:, 0, 3]
    print("turns  length [mm]  torque [N m]  in theory")
    for level, step in zip(options.levels, held, strict=True):
        wanted, _ = theory(distance(robot, motion, step))
        print(f"{level:5.2f}  {1e3 * ends[step]:11.1f}  {torque(robot, motion, step):12.4f}  {wanted:9.4f}")
    if len(held) > 1:
        _, wanted = theory(distance(robot, motion, held[-1]))
        way = (ends[held[0]] - ends[held[-1]]) / (options.levels[-1] - options.levels[0])
        print(f"a turn takes {1e3 * way:.1f} mm, in theory {1e3 * wanted:.1f} mm")
    if options.plot:
        loops = int(np.argmin(np.abs(motion.t - 0.62 * WAY)))
        draw(options.plot, robot, motion, tuple(options.levels), [0, loops, held[0], held[-1]])
    if options.report:
        motion.report(options.report)


if __name__ == "__main__":
    main()
