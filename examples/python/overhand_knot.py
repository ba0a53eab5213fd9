"""An overhand knot in an elastic rope without friction is pulled tight, tighter, and let out again.

A loose knot is a circle of the radius R that two tails leave: with the bending stiffness B its energy is
pi B / R, its ends are 2 pi R nearer than the rope is long, and so the tension is B / (2 R^2) (Audoly,
Clauvelin and Neukirch 2007; Jawed, Dieleman, Audoly and Reis 2015). A rope that is not thin takes more length
the tighter it is. Whatever its shape, the pull does the work that the energy grows by.

    python examples/python/overhand_knot.py [--time seconds a tension] [--plot file.png] [--report page]
"""

from __future__ import annotations

import argparse
import time
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import lissom

RADIUS, YOUNG, PARTS, MODES = 0.005, 1e6, 18, 3
BENDING = YOUNG * np.pi / 4 * RADIUS**4
#: Radii of thin loops at the tensions, metres.
LOOPS = (0.06, 0.045, 0.085)
#: The way from the shape as it was tied to a smooth one is fast.
FIRST, FIRST_STEP, STEP = 0.12, 2e-4, 2e-3


def tied() -> tuple[np.ndarray, np.ndarray]:
    """Arc lengths and points of a rope with a knot: a polynomial trefoil with straight tails."""
    t = np.linspace(-2.15, 2.15, 4001)
    knot = 0.008 * np.stack([t**5 - 10 * t, 6 * (t**3 - 3 * t), 4 * (t**4 - 4 * t**2)], axis=1)
    ways = [knot[0] - knot[1], knot[-1] - knot[-2]]
    before, behind = (way / np.linalg.norm(way) * np.linspace(0, 0.1, 400)[1:, None] for way in ways)
    points = np.concatenate([knot[0] + before[::-1], knot, knot[-1] + behind])
    return np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))], points


def bends() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Arc lengths, curvatures in sections that do not twist, first point, axes of the first section."""
    arc, points = tied()
    s = np.linspace(0, arc[-1], 6001)
    curve = CubicSpline(s[::20], np.column_stack([np.interp(s[::20], arc, column) for column in points.T]))
    tangents = curve(s, 1)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    y = np.cross([0, 0, 1], tangents[0])
    sides = []
    for tangent in tangents:
        y = y - (y @ tangent) * tangent
        y /= np.linalg.norm(y)
        sides.append(y)
    ys = np.array(sides)
    zs = np.cross(tangents, ys)
    turns = np.gradient(tangents, s, axis=0)
    curvatures = np.stack([-np.sum(turns * zs, axis=1), np.sum(turns * ys, axis=1)])
    return s, curvatures, points[0], np.column_stack([tangents[0], ys[0], zs[0]])


def rope(tension: float) -> tuple[lissom.Robot, np.ndarray]:
    """The rope on a ball joint, pulled along x at its tip, in a syrup; and the coordinates of the knot."""
    s, curvatures, origin, axes = bends()
    part = lissom.Segment(
        s[-1] / PARTS, RADIUS, YOUNG, poisson_ratio=0.5, density=1000, retardation_time=0.02,
        modes={"torsion": 1, "bend_y": MODES, "bend_z": MODES},
    )  # fmt: skip
    turn = Rotation.from_matrix(axes).as_quat(scalar_first=True)
    link = lissom.Link(
        "rope", rod=[part] * PARTS, joint=lissom.Spherical(), position=origin, orientation=turn
    )
    robot = lissom.Robot(
        [link],
        loads=[lissom.Load(link="rope", force=(tension, 0, 0))],
        contacts=[lissom.Contact("rope", "rope", stiffness=5e4)],
        fluid=lissom.Fluid(density=1e-9, viscous_drag=(0.3, 0.3)),
        gravity=(0, 0, 0),
    )
    x, weights = np.polynomial.legendre.leggauss(16)
    basis = np.array([np.polynomial.legendre.Legendre.basis(k)(x) * (k + 0.5) for k in range(MODES)])
    q0 = [np.zeros(3)]
    for i in range(PARTS):
        values = np.array(
            [np.interp((i + (x + 1) / 2) * s[-1] / PARTS, s, curvature) for curvature in curvatures]
        )
        q0 += [np.zeros(1), *(basis @ (weights * value) for value in values)]
    return robot, np.concatenate(q0)


def shortening(robot: lissom.Robot, q: np.ndarray) -> float:
    """How much nearer the ends are than the rope is long, metres."""
    length = tied()[0][-1]
    ends = robot.pose(q, [0.0, length * (1 - 1e-12)])[:, :3, 3]
    return float(length - np.linalg.norm(ends[1] - ends[0]))


def pull(loops: tuple[float, ...], seconds: float) -> list[tuple[lissom.Robot, lissom.MotionResult]]:
    """Runs under one tension after the other, each from the end of the one before."""
    runs = []
    for k, radius in enumerate(loops):
        robot, q0 = rope(BENDING / (2 * radius**2))
        if k == 0:
            smooth = lissom.simulate(robot, min(FIRST, seconds), dt=FIRST_STEP, q0=q0)
            if not smooth.success:
                raise SystemExit(smooth.message)
        else:
            smooth = runs[-1][1]
        motion = lissom.simulate(robot, seconds, dt=STEP, q0=smooth.q[-1], v0=smooth.v[-1])
        if not motion.success:
            raise SystemExit(motion.message)
        runs.append((robot, motion))
    return runs


def draw(path: str, runs: list[tuple[lissom.Robot, lissom.MotionResult]]) -> None:
    """The knot at the end of each run."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, len(runs), figsize=(4 * len(runs), 3), subplot_kw={"projection": "3d"})
    figure.subplots_adjust(0, 0, 1, 1, wspace=0)
    length = tied()[0][-1]
    ring = np.linspace(0, 2 * np.pi, 17)
    skin = RADIUS * np.stack([0 * ring, np.cos(ring), np.sin(ring)])
    for axis, loop, (robot, motion) in zip(axes, LOOPS, runs, strict=True):
        poses = robot.pose(motion.q[-1], np.linspace(0.15, 0.85, 401) * length)
        line = poses[:, :3, 3]
        tube = line[:, :, None] + poses[:, :3, :3] @ skin
        axis.plot_surface(*np.moveaxis(tube, 1, 0), color="tab:green", linewidth=0, rstride=1, cstride=1)
        knot = line[100:301]
        across = np.linalg.eigh(np.cov(knot.T))[1][:, 0]
        axis.view_init(
            elev=np.degrees(np.arcsin(across[2])), azim=np.degrees(np.arctan2(across[1], across[0]))
        )
        centre = 0.5 * (knot.min(axis=0) + knot.max(axis=0))
        axis.set(**{f"{name}lim": (centre[k] - 0.14, centre[k] + 0.14) for k, name in enumerate("xyz")})
        axis.set_box_aspect((1, 1, 1), zoom=1.7)
        axis.set_axis_off()
        tension = BENDING / (2 * loop**2)
        axis.text2D(0.5, 0.04, f"{1e3 * tension:.0f} mN", transform=axis.transAxes, ha="center")
    figure.savefig(path, dpi=120)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--time", type=float, default=6.0, help="at each tension")
    parser.add_argument("--plot", help="picture of the knots")
    parser.add_argument("--report", help="page with the motion under the last tension")
    options = parser.parse_args()
    begin = time.perf_counter()
    runs = pull(LOOPS, options.time)
    print(f"{len(runs)} tensions, {time.perf_counter() - begin:.0f} s")
    print("tension [mN]  places that touch  energy [mJ]  shortening [mm]  of a thin loop")
    rows = []
    for radius, (robot, motion) in zip(LOOPS, runs, strict=True):
        q = motion.q[-1]
        # That of the surfaces is part of the elastic energy.
        rows.append(
            (BENDING / (2 * radius**2), robot.energy(q, np.zeros_like(q)).elastic, shortening(robot, q))
        )
        tension, energy, short = (1e3 * number for number in rows[-1])
        places, thin = len(robot.touches(q)), 2e3 * np.pi * radius
        print(f"{tension:12.1f}  {places:17d}  {energy:11.3f}  {short:15.1f}  {thin:14.1f}")
    for (T0, energy0, short0), (T1, energy1, short1) in pairwise(rows):
        # The integral of the power law through both.
        power = np.log(T1 / T0) / np.log(short0 / short1)
        work = (T1 * short1 - T0 * short0) / (power - 1)
        print(f"the energy changes by {1e3 * (energy1 - energy0):.3f} mJ, the pull does {1e3 * work:.3f} mJ")
    if options.plot:
        draw(options.plot, runs)
    if options.report:
        runs[-1][1].report(options.report)


if __name__ == "__main__":
    main()
