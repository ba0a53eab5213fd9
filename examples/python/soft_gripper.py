"""Three fingers with tendons grasp a ball and lift it, or let it slip: friction tells how heavy it may be.

The fingers hang from a palm that moves up after they have closed. How hard they press on a light ball, and
where, says what friction can carry; balls that are a little lighter or heavier than that are lifted, or stay.

    python examples/python/soft_gripper.py [--plot picture.png] [--report page.html]
"""

from __future__ import annotations

import argparse

import numpy as np
from scipy.spatial.transform import Rotation

import lissom

LENGTH, RADIUS, YOUNG = 0.1, 0.006, 1e7  # of a finger
OFFSET, TENSION = 0.004, 10.0  # of a tendon
BALL, GAP = 0.03, 0.002
FRICTION, GRAVITY = 0.5, 9.81
#: Of the bases of the fingers above the middle of the ball.
HEIGHT = 0.085
LIFT = 0.03
CLOSED, LIFTED, END = 1.0, 2.0, 2.5  # s
FINGERS = ["finger 0", "finger 1", "finger 2"]


def gripper(mass: float) -> lissom.Robot:
    """The hand over a ball that lies on a floor."""
    half = lissom.Segment(
        LENGTH / 2, RADIUS, YOUNG, poisson_ratio=0.45, density=1000, retardation_time=0.01,
        modes={"torsion": 1, "bend_y": 3, "bend_z": 2},
    )  # fmt: skip
    # A table for the palm, at rest at both ends.
    part = np.linspace(0, 1, 21)
    rise = (CLOSED + part * (LIFTED - CLOSED), LIFT * part**3 * (10 - 15 * part + 6 * part**2))
    way = tuple(
        np.r_[edge[0], column, edge[1]] for edge, column in zip([(0, END), (0, LIFT)], rise, strict=True)
    )
    up = lissom.Prismatic((0, 0, 1), motion=way)
    ball = lissom.Ball("ball", BALL)
    links = [lissom.Link("palm", joint=up, position=(0, 0, BALL + HEIGHT), body=lissom.Body(0.2))]
    contacts = [
        lissom.Contact(ball, lissom.HalfSpace(), stiffness=1e5, friction=FRICTION, name="floor"),
    ]
    pulls = []
    for i, name in enumerate(FINGERS):
        angle = 2 * np.pi * i / 3
        out = np.array([np.cos(angle), np.sin(angle), 0])
        # Down along x, the tendon on the side of z, towards the ball.
        down = np.array([0, 0, -1])
        axes = np.column_stack([down, np.cross(-out, down), -out])
        turn = Rotation.from_matrix(axes).as_quat(scalar_first=True)
        place = (BALL + RADIUS + GAP) * out
        links.append(lissom.Link(name, rod=[half] * 2, parent="palm", position=place, orientation=turn))
        path = [lissom.Along(name, offset=(0, OFFSET))]
        pulls.append(lissom.Tendon(f"tendon {i}", path, tension=([0, 0.5 * CLOSED], [0, TENSION])))
        contacts.append(lissom.Contact(name, ball, friction=FRICTION, name=name))
    inertia = 0.4 * mass * BALL**2 * np.eye(3)
    links.append(
        lissom.Link(
            "ball", joint=lissom.Free(), body=lissom.Body(mass, inertia=inertia), position=(0, 0, BALL)
        )
    )
    return lissom.Robot(links, gravity=(0, 0, -GRAVITY), actuators=pulls, contacts=contacts)


def carried(robot: lissom.Robot, motion: lissom.MotionResult, step: int) -> float:
    """The largest weight that friction could carry with the pressures of a time, newtons."""
    most = 0.0
    for touch in robot.touches(motion.q[step], motion.v[step], t=motion.t[step]):
        if touch.contact in FINGERS:
            # The normals point from the ball to the finger.
            pressure = touch.force @ touch.normal
            most += pressure * (FRICTION * np.hypot(*touch.normal[:2]) - touch.normal[2])
    return most


def run(mass: float) -> tuple[lissom.MotionResult, float, float]:
    """A lift: how far the ball comes up, and what friction could carry then."""
    robot = gripper(mass)
    motion = lissom.simulate(robot, END, dt=5e-3)
    if not motion.success:
        raise SystemExit(motion.message)
    height = robot.pose(motion.q, link="ball", t=motion.t)[:, 2, 3] - BALL
    return motion, height[-1], carried(robot, motion, -1)


def draw(path: str, motions: list[lissom.MotionResult]) -> None:
    """The hand closed, and at the end of each lift."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(
        1,
        1 + len(motions),
        figsize=(3.2 * (1 + len(motions)), 4.0),
        subplot_kw={"projection": "3d"},
        layout="constrained",
    )
    u, v = np.meshgrid(np.linspace(0, np.pi, 25), np.linspace(0, 2 * np.pi, 49), indexing="ij")
    sphere = BALL * np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1)
    along = np.linspace(0, LENGTH, 41)
    ring = np.linspace(0, 2 * np.pi, 17)
    skin = RADIUS * np.stack([0 * ring, np.cos(ring), np.sin(ring)])
    pictures = [(motions[0], CLOSED), *((motion, END) for motion in motions)]
    titles = [
        "closed",
        *(f"{1e3 * motion.model.links[-1].body.mass:.0f} g, after the lift" for motion in motions),
    ]
    for axis, title, (motion, t) in zip(axes, titles, pictures, strict=True):
        robot, q = motion.model, motion.q[np.searchsorted(motion.t, t - 1e-9)]
        centre = robot.pose(q, link="ball", t=t)[:3, 3]
        axis.plot_surface(*np.moveaxis(centre + sphere, -1, 0), color="tab:orange", linewidth=0)
        for name in FINGERS:
            poses = robot.pose(q, along, link=name, t=t)
            tube = poses[:, :3, 3, None] + poses[:, :3, :3] @ skin
            axis.plot_surface(*np.moveaxis(tube, 1, 0), color="tab:blue", linewidth=0)
        axis.set(title=title, xlim=(-0.05, 0.05), ylim=(-0.05, 0.05), zlim=(0, 0.15))
        axis.set_box_aspect((1, 1, 1.5), zoom=1.35)
        axis.set_axis_off()
        axis.view_init(elev=8, azim=30)
    figure.savefig(path, dpi=120)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plot", help="picture of the hand, closed and after two lifts")
    parser.add_argument("--report", help="page with the lift of the heavier ball")
    options = parser.parse_args()
    light = 0.06
    _, _, most = run(light)
    print(f"a ball of {1e3 * light:.0f} g is held so that friction could carry {1e3 * most / GRAVITY:.1f} g")
    motions = []
    print("mass [g]  comes up by [mm]")
    for part in (0.6, 0.9, 1.1):
        mass = part * most / GRAVITY
        motion, height, _ = run(mass)
        print(f"{1e3 * mass:8.1f}  {1e3 * height:16.2f}")
        motions.append(motion)
    if options.plot:
        draw(options.plot, motions[1:])
    if options.report:
        motions[-1].report(options.report)


if __name__ == "__main__":
    main()
